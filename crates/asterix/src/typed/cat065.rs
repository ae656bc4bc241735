//! CAT065 ed 1.4 to 1.6: service messages of a surveillance data processing system.

use super::fields::*;
use crate::categories::CAT065;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT065_V1_6;

    const UAP: &Uap = CAT065_V1_6.uap();

    /// I065/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I065/000.
    pub const MESSAGE_TYPE: Frn = UAP.frn("000");
    /// I065/030.
    pub const TIME_OF_DAY: Frn = UAP.frn("030");
    /// I065/020.
    pub const BATCH: Frn = UAP.frn("020");
    /// I065/040.
    pub const SYSTEM_STATUS: Frn = UAP.frn("040");
    /// I065/050.
    pub const SERVICE_REPORT: Frn = UAP.frn("050");
}

/// I065/000: what a record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageType {
    /// The state of the system.
    SystemStatus,
    /// All tracks of a batch have been sent.
    EndOfBatch,
    /// Something about a service.
    ServiceStatus,
    /// A number without meaning.
    Undefined(u8),
}

/// I065/040: the state of the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ProcessingStatus {
    /// NOGO; a system that is not connected is not to be used.
    pub availability: Availability,
    /// OVL: some targets may be missing.
    pub overloaded: bool,
    /// TSV: time stamps are not to be trusted.
    pub time_source_invalid: bool,
    /// STTN: changes whenever tracks get new numbers.
    pub numbering: bool,
}

/// A record about the system itself: every record of this category.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ServiceMessage {
    /// I065/000.
    pub message_type: Option<MessageType>,
    /// I065/010.
    pub source: Option<Source>,
    /// I065/030.
    pub time_of_day: Option<TimeOfDay>,
    /// I065/020: number of the batch that has been sent.
    pub batch: Option<u8>,
    /// I065/040.
    pub system_status: Option<ProcessingStatus>,
    /// I065/050: what happened to a service, as numbered by the document.
    pub service_report: Option<u8>,
}

impl ServiceMessage {
    /// Reads a service message; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT065).then_some(())?;
        Some(Self {
            message_type: record.item(MESSAGE_TYPE).map(|item| match item[0] {
                1 => MessageType::SystemStatus,
                2 => MessageType::EndOfBatch,
                3 => MessageType::ServiceStatus,
                other => MessageType::Undefined(other),
            }),
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            batch: record.item(BATCH).map(|item| item[0]),
            system_status: record.item(SYSTEM_STATUS).map(|item| ProcessingStatus {
                availability: Availability::new(item[0] >> 6),
                overloaded: item[0] & 0x20 != 0,
                time_source_invalid: item[0] & 0x10 != 0,
                numbering: item[0] & 0x02 != 0,
            }),
            service_report: record.item(SERVICE_REPORT).map(|item| item[0]),
        })
    }
}
