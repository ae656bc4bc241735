//! CAT019 ed 1.3: service messages of a multilateration system.

use super::fields::*;
use crate::bits::i16_at;
use crate::categories::CAT019_V1_3;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{CAT019_V1_3, Frn, Uap};

    const UAP: &Uap = CAT019_V1_3.uap();

    /// I019/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I019/000.
    pub const MESSAGE_TYPE: Frn = UAP.frn("000");
    /// I019/140.
    pub const TIME_OF_DAY: Frn = UAP.frn("140");
    /// I019/550.
    pub const SYSTEM_STATUS: Frn = UAP.frn("550");
    /// I019/600.
    pub const REFERENCE_POSITION: Frn = UAP.frn("600");
    /// I019/610.
    pub const REFERENCE_HEIGHT: Frn = UAP.frn("610");
    /// I019/620.
    pub const UNDULATION: Frn = UAP.frn("620");
}

/// I019/000: what a record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageType {
    /// A new update cycle begins.
    StartOfUpdateCycle,
    /// The state of the system, sent regularly.
    PeriodicStatus,
    /// The state of the system, sent as it changed.
    EventStatus,
    /// A number without meaning in this edition.
    Undefined(u8),
}

/// A record about the system itself: every record of this category.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServiceMessage {
    /// I019/000.
    pub message_type: Option<MessageType>,
    /// I019/010.
    pub source: Option<Source>,
    /// I019/140.
    pub time_of_day: Option<TimeOfDay>,
    /// I019/550.
    pub system_status: Option<SystemStatus>,
    /// I019/600: the origin of the system's Cartesian positions.
    pub reference_position: Option<GeodeticPosition>,
    /// I019/610: the origin's height above mean sea level, in m.
    pub reference_height_m: Option<f64>,
    /// I019/620: the geoid's height above the ellipsoid there, in m.
    pub undulation_m: Option<f64>,
}

impl ServiceMessage {
    /// Reads a service message; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(&[&CAT019_V1_3]).then_some(())?;
        Some(Self {
            message_type: record.item(MESSAGE_TYPE).map(|item| match item[0] {
                1 => MessageType::StartOfUpdateCycle,
                2 => MessageType::PeriodicStatus,
                3 => MessageType::EventStatus,
                other => MessageType::Undefined(other),
            }),
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            system_status: record.item(SYSTEM_STATUS).map(|item| SystemStatus::new(item[0], 0x08)),
            reference_position: record
                .item(REFERENCE_POSITION)
                .map(|item| GeodeticPosition::from_32_bits(item, 30)),
            reference_height_m: record
                .item(REFERENCE_HEIGHT)
                .map(|item| f64::from(i16_at(item, 0)) * 0.25),
            undulation_m: record.item(UNDULATION).map(|item| f64::from(item[0] as i8)),
        })
    }
}
