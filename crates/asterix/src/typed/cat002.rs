//! CAT002 ed 1.0 to 1.2: service messages of a radar, the format before CAT034.

use super::fields::*;
use crate::categories::CAT002;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT002_V1_2;

    const UAP: &Uap = CAT002_V1_2.uap();

    /// I002/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I002/000.
    pub const MESSAGE_TYPE: Frn = UAP.frn("000");
    /// I002/020.
    pub const SECTOR: Frn = UAP.frn("020");
    /// I002/030.
    pub const TIME_OF_DAY: Frn = UAP.frn("030");
    /// I002/041.
    pub const ANTENNA_PERIOD: Frn = UAP.frn("041");
}

/// I002/000: what a record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageType {
    /// The antenna points north.
    NorthMarker,
    /// The antenna enters a sector.
    SectorCrossing,
    /// The antenna points south.
    SouthMarker,
    /// Targets of an area are no longer sent.
    BlindZoneBegins,
    /// Targets of that area are sent again.
    BlindZoneEnds,
    /// A number without common meaning.
    Undefined(u8),
}

/// A record about the radar itself: every record of this category.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServiceMessage {
    /// I002/000.
    pub message_type: Option<MessageType>,
    /// I002/010.
    pub source: Option<Source>,
    /// I002/030: of the crossing, in a message about one.
    pub time_of_day: Option<TimeOfDay>,
    /// I002/020: the azimuth at which the sector begins, in rad.
    pub sector_azimuth_rad: Option<f64>,
    /// I002/041: time of one turn of the antenna, in s.
    pub antenna_period_s: Option<f64>,
}

impl ServiceMessage {
    /// Reads a service message; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT002).then_some(())?;
        Some(Self {
            message_type: record.item(MESSAGE_TYPE).map(|item| match item[0] {
                1 => MessageType::NorthMarker,
                2 => MessageType::SectorCrossing,
                3 => MessageType::SouthMarker,
                8 => MessageType::BlindZoneBegins,
                9 => MessageType::BlindZoneEnds,
                other => MessageType::Undefined(other),
            }),
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            sector_azimuth_rad: record.item(SECTOR).map(sector_azimuth_rad),
            antenna_period_s: record.item(ANTENNA_PERIOD).map(period_s),
        })
    }
}
