//! CAT034 ed 1.27 to 1.29: service messages of a radar.

use super::fields::*;
use super::subitems::subitems;
use crate::bits::i16_at;
use crate::categories::CAT034;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT034_V1_29;

    const UAP: &Uap = CAT034_V1_29.uap();

    /// I034/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I034/000.
    pub const MESSAGE_TYPE: Frn = UAP.frn("000");
    /// I034/030.
    pub const TIME_OF_DAY: Frn = UAP.frn("030");
    /// I034/020.
    pub const SECTOR: Frn = UAP.frn("020");
    /// I034/041.
    pub const ANTENNA_PERIOD: Frn = UAP.frn("041");
    /// I034/050.
    pub const SYSTEM_STATUS: Frn = UAP.frn("050");
    /// I034/120.
    pub const POSITION: Frn = UAP.frn("120");
}

/// I034/000: what a record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageType {
    /// The antenna points north.
    NorthMarker,
    /// The antenna enters a sector.
    SectorCrossing,
    /// An area from which targets are not sent.
    GeographicalFilter,
    /// A direction that is jammed.
    JammingStrobe,
    /// A solar storm; of later editions.
    SolarStorm,
    /// A direction in which secondary radar is jammed; of later editions.
    SecondaryJammingStrobe,
    /// A direction in which Mode S is jammed; of later editions.
    ModeSJammingStrobe,
    /// A number without meaning.
    Undefined(u8),
}

/// I034/050 COM: the state of the radar as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RadarStatus {
    /// NOGO: not to be used.
    pub unreleased: bool,
    /// RDPR: data processing was restarted; tracks get new numbers.
    pub restarted: bool,
    /// OVL RDP or OVL XMT: processing or transmission cannot follow.
    pub overloaded: bool,
    /// TSV: time stamps are not to be trusted.
    pub time_source_invalid: bool,
}

/// I034/120: where the radar stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadarPosition {
    /// On the WGS-84 ellipsoid.
    pub place: GeodeticPosition,
    /// Height in m; above what, the document does not say.
    pub height_m: f64,
}

/// A record about the radar itself: every record of this category.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServiceMessage {
    /// I034/000.
    pub message_type: Option<MessageType>,
    /// I034/010.
    pub source: Option<Source>,
    /// I034/030: of the crossing, in a message about one.
    pub time_of_day: Option<TimeOfDay>,
    /// I034/020: the azimuth at which the sector begins, in rad.
    pub sector_azimuth_rad: Option<f64>,
    /// I034/041: time of one turn of the antenna, in s.
    pub antenna_period_s: Option<f64>,
    /// I034/050 COM.
    pub status: Option<RadarStatus>,
    /// I034/120.
    pub position: Option<RadarPosition>,
}

impl ServiceMessage {
    /// Reads a service message; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT034).then_some(())?;
        Some(Self {
            message_type: record.item(MESSAGE_TYPE).map(message_type),
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            sector_azimuth_rad: record.item(SECTOR).map(sector_azimuth_rad),
            antenna_period_s: record.item(ANTENNA_PERIOD).map(period_s),
            status: subitems(record, SYSTEM_STATUS)
                .find(|(place, _)| *place == 1) // COM
                .map(|(_, common)| status(common)),
            position: record.item(POSITION).map(|item| RadarPosition {
                place: GeodeticPosition::from_24_bits(&item[2..]),
                height_m: f64::from(i16_at(item, 0)),
            }),
        })
    }
}

fn message_type(item: &[u8]) -> MessageType {
    match item[0] {
        1 => MessageType::NorthMarker,
        2 => MessageType::SectorCrossing,
        3 => MessageType::GeographicalFilter,
        4 => MessageType::JammingStrobe,
        5 => MessageType::SolarStorm,
        6 => MessageType::SecondaryJammingStrobe,
        7 => MessageType::ModeSJammingStrobe,
        other => MessageType::Undefined(other),
    }
}

fn status(common: &[u8]) -> RadarStatus {
    RadarStatus {
        unreleased: common[0] & 0x80 != 0,
        restarted: common[0] & 0x20 != 0,
        overloaded: common[0] & 0x18 != 0,
        time_source_invalid: common[0] & 0x02 != 0,
    }
}
