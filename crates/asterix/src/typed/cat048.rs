//! CAT048 ed 1.27 to 1.32: target reports of a radar, plots and tracks.
//!
//! What is read here lies in the same place in all of these editions; the parts that later ones add to I048/020 are not
//! read. I048/090 is in two's complement here in every edition, though only the last says so: without the sign, an
//! aircraft a little below sea level pressure would fly in space.

use super::fields::*;
use crate::bits::u16_at;
use crate::categories::CAT048;
use crate::record::Record;
use crate::table::{Frn, Uap};
use item::*;

/// The field reference numbers of the items read here.
pub mod item {
    use super::{Frn, Uap};
    use crate::categories::CAT048_V1_32;

    const UAP: &Uap = CAT048_V1_32.uap();

    /// I048/010.
    pub const SOURCE: Frn = UAP.frn("010");
    /// I048/140.
    pub const TIME_OF_DAY: Frn = UAP.frn("140");
    /// I048/020.
    pub const DESCRIPTOR: Frn = UAP.frn("020");
    /// I048/040.
    pub const POLAR_POSITION: Frn = UAP.frn("040");
    /// I048/070.
    pub const MODE_3A: Frn = UAP.frn("070");
    /// I048/090.
    pub const FLIGHT_LEVEL: Frn = UAP.frn("090");
    /// I048/220.
    pub const ADDRESS: Frn = UAP.frn("220");
    /// I048/240.
    pub const CALLSIGN: Frn = UAP.frn("240");
    /// I048/250.
    pub const REGISTERS: Frn = UAP.frn("250");
    /// I048/161.
    pub const TRACK_NUMBER: Frn = UAP.frn("161");
    /// I048/042.
    pub const CARTESIAN_POSITION: Frn = UAP.frn("042");
    /// I048/200.
    pub const POLAR_VELOCITY: Frn = UAP.frn("200");
    /// I048/170.
    pub const TRACK_STATUS: Frn = UAP.frn("170");
    /// I048/210.
    pub const TRACK_QUALITY: Frn = UAP.frn("210");
    /// I048/030.
    pub const WARNINGS: Frn = UAP.frn("030");
    /// I048/110.
    pub const MEASURED_HEIGHT: Frn = UAP.frn("110");
    /// I048/230.
    pub const TRANSPONDER: Frn = UAP.frn("230");
    /// I048/260.
    pub const RESOLUTION_ADVISORY: Frn = UAP.frn("260");
}

/// I048/020 TYP: how a target was detected in this turn of the antenna.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detection {
    /// Not at all: the position is extrapolated.
    None,
    /// Primary radar.
    Primary,
    /// Secondary radar.
    Secondary,
    /// Both.
    Combined,
    /// Reply to a Mode S interrogation of all.
    AllCall,
    /// Reply to a Mode S interrogation of this aircraft.
    RollCall,
    /// Reply to a Mode S interrogation of all, and primary radar.
    AllCallCombined,
    /// Reply to a Mode S interrogation of this aircraft, and primary radar.
    RollCallCombined,
}

/// I048/020: properties of a report. A flag whose extension octet was not sent is `false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptor {
    /// TYP.
    pub detection: Detection,
    /// SIM: simulated.
    pub simulated: bool,
    /// SPI: special position identification.
    pub special_identification: bool,
    /// RAB: a fixed transponder that monitors the radar, no target.
    pub field_monitor: bool,
    /// TST: a test target.
    pub test: bool,
    /// ERR: the range is beyond what I048/040 can hold.
    pub beyond_range: bool,
    /// ME: military emergency.
    pub military_emergency: bool,
    /// MI: military identification.
    pub military_identification: bool,
}

impl Descriptor {
    fn new(item: &[u8]) -> Self {
        let (first, second) = (item[0], extension(item, 1));
        Self {
            detection: match first >> 5 {
                0 => Detection::None,
                1 => Detection::Primary,
                2 => Detection::Secondary,
                3 => Detection::Combined,
                4 => Detection::AllCall,
                5 => Detection::RollCall,
                6 => Detection::AllCallCombined,
                _ => Detection::RollCallCombined,
            },
            simulated: first & 0x10 != 0,
            special_identification: first & 0x04 != 0,
            field_monitor: first & 0x02 != 0,
            test: second & 0x80 != 0,
            beyond_range: second & 0x40 != 0,
            military_emergency: second & 0x10 != 0,
            military_identification: second & 0x08 != 0,
        }
    }
}

/// I048/170: what the radar's tracker says of its track. A flag whose extension octet was not sent is `false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RadarTrackStatus {
    /// CNF: still being initialised; otherwise confirmed.
    pub tentative: bool,
    /// DOU: little confidence that the plot is of this track.
    pub doubtful: bool,
    /// MAH: a horizontal manoeuvre.
    pub manoeuvring: bool,
    /// TRE: the last report of this track; its number may be given to another.
    pub ended: bool,
    /// GHO: probably no real target.
    pub ghost: bool,
    /// SUP: maintained with what a neighbouring radar sees.
    pub from_neighbour: bool,
    /// TCC: I048/042 lies in a plane that touches the earth at the radar, ranges along the ground; otherwise its
    /// distance from the radar is the straight one.
    pub slant_corrected: bool,
}

impl RadarTrackStatus {
    fn new(item: &[u8]) -> Self {
        let (first, second) = (item[0], extension(item, 1));
        Self {
            tentative: first & 0x80 != 0,
            doubtful: first & 0x10 != 0,
            manoeuvring: first & 0x08 != 0,
            ended: second & 0x80 != 0,
            ghost: second & 0x40 != 0,
            from_neighbour: second & 0x20 != 0,
            slant_corrected: second & 0x10 != 0,
        }
    }
}

/// I048/210: standard deviations of a track. Zero says nothing: it is less than the LSB, or not given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackQuality {
    /// Of x, in m.
    pub sigma_x_m: f64,
    /// Of y, in m.
    pub sigma_y_m: f64,
    /// Of ground speed, in m/s.
    pub sigma_speed_m_s: f64,
    /// Of heading, in rad.
    pub sigma_track_rad: f64,
}

impl TrackQuality {
    fn new(item: &[u8]) -> Self {
        Self {
            sigma_x_m: f64::from(item[0]) * (NAUTICAL_MILE_M / 128.0),
            sigma_y_m: f64::from(item[1]) * (NAUTICAL_MILE_M / 128.0),
            sigma_speed_m_s: speed_m_s(f64::from(item[2])),
            sigma_track_rad: (f64::from(item[3]) * (360.0 / 4096.0)).to_radians(),
        }
    }
}

/// I048/030: warnings and classifications, by the numbers of the document.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Warnings(u128);

impl Warnings {
    /// The height code differs too much from the track's.
    pub const ABNORMAL_HEIGHT: u8 = 12;
    /// The height code has no meaning.
    pub const UNDECODABLE_HEIGHT: u8 = 18;

    fn new(item: &[u8]) -> Self {
        Self(item.iter().fold(0, |codes, octet| codes | 1 << (octet >> 1)))
    }

    /// Whether a warning was given.
    pub fn contains(&self, number: u8) -> bool {
        number < 128 && self.0 >> number & 1 == 1
    }
}

/// A target report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// I048/010.
    pub source: Option<Source>,
    /// I048/140.
    pub time_of_day: Option<TimeOfDay>,
    /// I048/020.
    pub descriptor: Option<Descriptor>,
    /// I048/040: straight distance and azimuth, measured in this turn or, without detection, extrapolated.
    pub slant_position: Option<PolarPosition>,
    /// I048/042, of the track. What its plane is, I048/170 TCC says.
    pub cartesian_position: Option<CartesianPosition>,
    /// I048/200, of the track: towards north at the aircraft.
    pub polar_velocity: Option<PolarVelocity>,
    /// I048/161.
    pub track_number: Option<u16>,
    /// I048/170.
    pub track_status: Option<RadarTrackStatus>,
    /// I048/210.
    pub track_quality: Option<TrackQuality>,
    /// I048/070.
    pub mode_3a: Option<Mode3A>,
    /// I048/090.
    pub flight_level: Option<FlightLevel>,
    /// I048/110: above mean sea level, of a radar that measures elevation, in m.
    pub measured_height_m: Option<f64>,
    /// I048/220: 24-bit address.
    pub address: Option<u32>,
    /// I048/240. `None` also if the item has no letter or digit.
    pub callsign: Option<Callsign>,
    /// I048/230.
    pub transponder: Option<Transponder>,
    /// I048/260.
    pub resolution_advisory: Option<ResolutionAdvisory>,
    /// I048/030.
    pub warnings: Option<Warnings>,
}

impl TargetReport {
    /// Reads a target report; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT048).then_some(())?;
        Some(Self {
            source: record.item(SOURCE).map(source),
            time_of_day: record.item(TIME_OF_DAY).map(time_of_day),
            descriptor: record.item(DESCRIPTOR).map(Descriptor::new),
            slant_position: record
                .item(POLAR_POSITION)
                .map(|item| PolarPosition::from_nautical_miles(item, 256.0)),
            cartesian_position: record
                .item(CARTESIAN_POSITION)
                .map(|item| CartesianPosition::from_nautical_miles(item, 128.0)),
            polar_velocity: record.item(POLAR_VELOCITY).map(PolarVelocity::new),
            track_number: record.item(TRACK_NUMBER).map(track_number),
            track_status: record.item(TRACK_STATUS).map(RadarTrackStatus::new),
            track_quality: record.item(TRACK_QUALITY).map(TrackQuality::new),
            mode_3a: record.item(MODE_3A).map(Mode3A::new),
            flight_level: record.item(FLIGHT_LEVEL).map(FlightLevel::new),
            measured_height_m: record.item(MEASURED_HEIGHT).map(measured_height_m),
            address: record.item(ADDRESS).map(address),
            callsign: record.item(CALLSIGN).and_then(Callsign::from_six_bits),
            transponder: record.item(TRANSPONDER).map(Transponder::new),
            resolution_advisory: record.item(RESOLUTION_ADVISORY).map(ResolutionAdvisory::new),
            warnings: record.item(WARNINGS).map(Warnings::new),
        })
    }
}

/// I048/250: the registers read from a Mode S transponder in this turn; none for a record of another table.
pub fn registers<'a>(record: &Record<'a>) -> impl Iterator<Item = Register> + use<'a> {
    let item = record.item(REGISTERS).filter(|_| record.table().is_one_of(CAT048));
    item.into_iter().flat_map(Register::all)
}

/// Fourteen bits in two's complement, LSB 25 ft.
fn measured_height_m(item: &[u8]) -> f64 {
    let steps = ((u16_at(item, 0) << 2) as i16) >> 2;
    f64::from(steps) * (25.0 * FOOT_M)
}
