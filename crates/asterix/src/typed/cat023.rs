//! CAT023 ed 1.2 and 1.3: state of an ADS-B or multilateration ground station and of its services.

use super::fields::*;
use crate::categories::CAT023;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT023_V1_3;

    const UAP: &Uap = CAT023_V1_3.uap();

    /// I023/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I023/000.
    pub const REPORT_TYPE: Frn = UAP.frn("000");
    /// I023/070.
    pub const TIME_OF_DAY: Frn = UAP.frn("070");
    /// I023/100.
    pub const STATION_STATUS: Frn = UAP.frn("100");
    /// I023/110.
    pub const SERVICE_STATUS: Frn = UAP.frn("110");
    /// I023/200.
    pub const RANGE: Frn = UAP.frn("200");
}

/// I023/000: what a record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReportType {
    /// The state of the ground station.
    StationStatus,
    /// The state of one of its services.
    ServiceStatus,
    /// Counts of messages.
    ServiceStatistics,
    /// A number without meaning.
    Undefined(u8),
}

/// I023/100: the state of the ground station.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StationStatus {
    /// NOGO: not to be used.
    pub unreleased: bool,
    /// ODP or OXT: processing or transmission cannot follow.
    pub overloaded: bool,
    /// TSV: time stamps are not to be trusted.
    pub time_source_invalid: bool,
    /// SPO: somebody may be sending false messages.
    pub spoofed: bool,
    /// RN: tracks get new numbers.
    pub renumbered: bool,
}

/// I023/110: the state of a service.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ServiceStatus {
    /// Not known.
    Unknown,
    /// It has failed.
    Failed,
    /// It is switched off.
    Disabled,
    /// It works with restrictions.
    Degraded,
    /// It works.
    Normal,
    /// It begins.
    Initialising,
    /// A number without meaning.
    Undefined(u8),
}

/// A record about the ground station itself: every record of this category.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServiceMessage {
    /// I023/000.
    pub report_type: Option<ReportType>,
    /// I023/010.
    pub source: Option<Source>,
    /// I023/070.
    pub time_of_day: Option<TimeOfDay>,
    /// I023/100.
    pub station_status: Option<StationStatus>,
    /// I023/110.
    pub service_status: Option<ServiceStatus>,
    /// I023/200: range of the station, in m.
    pub range_m: Option<f64>,
}

impl ServiceMessage {
    /// Reads a service message; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT023).then_some(())?;
        Some(Self {
            report_type: record.item(REPORT_TYPE).map(|item| match item[0] {
                1 => ReportType::StationStatus,
                2 => ReportType::ServiceStatus,
                3 => ReportType::ServiceStatistics,
                other => ReportType::Undefined(other),
            }),
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            station_status: record.item(STATION_STATUS).map(station_status),
            service_status: record.item(SERVICE_STATUS).map(service_status),
            range_m: record.item(RANGE).map(|item| f64::from(item[0]) * NAUTICAL_MILE_M),
        })
    }
}

fn station_status(item: &[u8]) -> StationStatus {
    StationStatus {
        unreleased: item[0] & 0x80 != 0,
        overloaded: item[0] & 0x60 != 0,
        time_source_invalid: item[0] & 0x08 != 0,
        spoofed: item[0] & 0x04 != 0,
        renumbered: item[0] & 0x02 != 0,
    }
}

fn service_status(item: &[u8]) -> ServiceStatus {
    match item[0] >> 1 & 0x07 {
        0 => ServiceStatus::Unknown,
        1 => ServiceStatus::Failed,
        2 => ServiceStatus::Disabled,
        3 => ServiceStatus::Degraded,
        4 => ServiceStatus::Normal,
        5 => ServiceStatus::Initialising,
        other => ServiceStatus::Undefined(other),
    }
}
