//! CAT063 ed 1.6 and 1.7: what a surveillance data processing system says of its sensors.

use super::fields::*;
use crate::bits::{i16_at, u16_at};
use crate::categories::CAT063;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT063_V1_7;

    const UAP: &Uap = CAT063_V1_7.uap();

    /// I063/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I063/030.
    pub const TIME_OF_DAY: Frn = UAP.frn("030");
    /// I063/050.
    pub const SENSOR: Frn = UAP.frn("050");
    /// I063/060.
    pub const STATUS: Frn = UAP.frn("060");
    /// I063/070.
    pub const TIME_BIAS: Frn = UAP.frn("070");
    /// I063/080.
    pub const RANGE_BIAS: Frn = UAP.frn("080");
    /// I063/081.
    pub const AZIMUTH_BIAS: Frn = UAP.frn("081");
}

/// I063/060 CON: whether the system gets data of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Connection {
    /// In operation.
    Operational,
    /// In operation with restrictions.
    Degraded,
    /// Being initialised.
    Initialising,
    /// Not connected.
    None,
}

/// I063/060: the state of a sensor. A flag whose extension octet was not sent is `false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SensorStatus {
    /// CON.
    pub connection: Connection,
    /// OPS: not to be used.
    pub unreleased: bool,
    /// ODP or OXT: processing or transmission cannot follow.
    pub overloaded: bool,
    /// TSV: time stamps are not to be trusted.
    pub time_source_invalid: bool,
}

/// I063/080: how a sensor's ranges are wrong, as the system estimates it: true = gain × measured + bias.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeBias {
    /// Difference of the gain from 1.
    pub gain_error: f64,
    /// In m.
    pub bias_m: f64,
}

/// A record about a sensor: every record of this category.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorMessage {
    /// I063/010: the system.
    pub source: Option<Source>,
    /// I063/030.
    pub time_of_day: Option<TimeOfDay>,
    /// I063/050: the sensor.
    pub sensor: Option<Source>,
    /// I063/060.
    pub status: Option<SensorStatus>,
    /// I063/070: how much its time stamps are late, in s.
    pub time_bias_s: Option<f64>,
    /// I063/080, of its secondary radar.
    pub range_bias: Option<RangeBias>,
    /// I063/081, of its secondary radar, in rad.
    pub azimuth_bias_rad: Option<f64>,
}

impl SensorMessage {
    /// Reads a message about a sensor; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT063).then_some(())?;
        Some(Self {
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            sensor: record.item(SENSOR).map(source),
            status: record.item(STATUS).map(status),
            time_bias_s: record.item(TIME_BIAS).map(|item| f64::from(i16_at(item, 0)) * 0.001),
            range_bias: record.item(RANGE_BIAS).map(|item| RangeBias {
                gain_error: f64::from(i16_at(item, 0)) * 0.000_01,
                bias_m: f64::from(i16_at(item, 2)) * (NAUTICAL_MILE_M / 128.0),
            }),
            azimuth_bias_rad: record
                .item(AZIMUTH_BIAS)
                .map(|item| (f64::from(u16_at(item, 0) as i16) * (360.0 / 65_536.0)).to_radians()),
        })
    }
}

fn status(item: &[u8]) -> SensorStatus {
    let second = extension(item, 1);
    SensorStatus {
        connection: match item[0] >> 6 {
            0 => Connection::Operational,
            1 => Connection::Degraded,
            2 => Connection::Initialising,
            _ => Connection::None,
        },
        unreleased: second & 0x80 != 0,
        overloaded: second & 0x60 != 0,
        time_source_invalid: second & 0x08 != 0,
    }
}
