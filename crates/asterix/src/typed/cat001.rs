//! CAT001 ed 1.2 to 1.4: target reports of a radar, plots and tracks, the format before CAT048.
//!
//! Plots and tracks have the same items in different places. Three things a receiver must add: the time is cut off at
//! 512 s, and the messages of CAT002 give the rest of it; a block may state I001/010 in its first record only; and
//! whether I001/042 is corrected for slant range, nothing says. Items in a random field sequence are not read.

use super::fields::*;
use crate::bits::u16_at;
use crate::categories::{CAT001, CAT001_V1_4};
use crate::record::Record;
use crate::table::{Frn, Profile, Uap};

/// The field reference numbers that plots and tracks have in common.
const SOURCE: Frn = profile(0).frn("010");
const DESCRIPTOR: Frn = profile(0).frn("020");

/// The field reference numbers of the items read here.
struct Places {
    polar_position: Frn,
    mode_3a: Frn,
    flight_level: Frn,
    time: Frn,
    track: Option<TrackPlaces>,
}

/// Those that only tracks have.
struct TrackPlaces {
    number: Frn,
    cartesian_position: Frn,
    polar_velocity: Frn,
    status: Frn,
}

const PLOT: Places = Places::new(profile(0), None);
const TRACK: Places = Places::new(
    profile(1),
    Some(TrackPlaces {
        number: profile(1).frn("161"),
        cartesian_position: profile(1).frn("042"),
        polar_velocity: profile(1).frn("200"),
        status: profile(1).frn("170"),
    }),
);

/// The profile for a value of I001/020 TYP: 0 plot, 1 track.
const fn profile(typ: usize) -> &'static Uap {
    match &CAT001_V1_4.profile {
        Profile::Depends { cases, .. } => &cases[typ].1,
        Profile::Single(uap) => uap,
    }
}

impl Places {
    const fn new(uap: &Uap, track: Option<TrackPlaces>) -> Self {
        Self {
            polar_position: uap.frn("040"),
            mode_3a: uap.frn("070"),
            flight_level: uap.frn("090"),
            time: uap.frn("141"),
            track,
        }
    }
}

/// I001/020 SSRPSR: how a target was detected in this turn of the antenna.
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
}

/// I001/020: properties of a report. A flag whose extension octet was not sent is `false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Descriptor {
    /// TYP: of a track; otherwise of a plot.
    pub is_track: bool,
    /// SSRPSR.
    pub detection: Detection,
    /// SIM: simulated.
    pub simulated: bool,
    /// SPI: special position identification.
    pub special_identification: bool,
    /// RAB: a fixed transponder that monitors the radar, no target.
    pub field_monitor: bool,
    /// TST: a test target.
    pub test: bool,
    /// DS1/DS2: what a Mode 3/A code of 7500, 7600 or 7700 means.
    pub emergency: Emergency,
    /// ME: military emergency.
    pub military_emergency: bool,
    /// MI: military identification.
    pub military_identification: bool,
}

impl Descriptor {
    fn new(item: &[u8]) -> Self {
        let (first, second) = (item[0], extension(item, 1));
        Self {
            is_track: first & 0x80 != 0,
            detection: match first >> 4 & 0x03 {
                0 => Detection::None,
                1 => Detection::Primary,
                2 => Detection::Secondary,
                _ => Detection::Combined,
            },
            simulated: first & 0x40 != 0,
            special_identification: first & 0x04 != 0,
            field_monitor: first & 0x02 != 0,
            test: second & 0x80 != 0,
            emergency: match second >> 5 & 0x03 {
                0 => Emergency::None,
                1 => Emergency::UnlawfulInterference,
                2 => Emergency::CommunicationFailure,
                _ => Emergency::General,
            },
            military_emergency: second & 0x10 != 0,
            military_identification: second & 0x08 != 0,
        }
    }
}

/// I001/170: what the radar's tracker says of its track. A flag whose extension octet was not sent is `false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RadarTrackStatus {
    /// CON: still being initialised; otherwise confirmed.
    pub tentative: bool,
    /// MAN: a manoeuvre.
    pub manoeuvring: bool,
    /// DOU: it is doubtful that the plot is of this track.
    pub doubtful: bool,
    /// GHO: probably no real target.
    pub ghost: bool,
    /// TRE: the last report of this track; its number may be given to another.
    pub ended: bool,
}

impl RadarTrackStatus {
    fn new(item: &[u8]) -> Self {
        Self {
            tentative: item[0] & 0x80 != 0,
            manoeuvring: item[0] & 0x20 != 0,
            doubtful: item[0] & 0x10 != 0,
            ghost: item[0] & 0x02 != 0,
            ended: extension(item, 1) & 0x80 != 0,
        }
    }
}

/// I001/141: time since the last multiple of 512 s after midnight UTC, in ticks of 1/128 s.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TruncatedTime {
    /// As sent: all sixteen bits are used.
    pub ticks: u16,
}

/// A target report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetReport {
    /// I001/010.
    pub source: Option<Source>,
    /// I001/141.
    pub time: Option<TruncatedTime>,
    /// I001/020, which every record has.
    pub descriptor: Option<Descriptor>,
    /// I001/040: straight distance and azimuth, measured in this turn or, without detection, extrapolated.
    pub slant_position: Option<PolarPosition>,
    /// I001/042, of a track. What its plane is, is not said.
    pub cartesian_position: Option<CartesianPosition>,
    /// I001/200, of a track.
    pub polar_velocity: Option<PolarVelocity>,
    /// I001/161, of a track.
    pub track_number: Option<u16>,
    /// I001/170, of a track.
    pub track_status: Option<RadarTrackStatus>,
    /// I001/070.
    pub mode_3a: Option<Mode3A>,
    /// I001/090.
    pub flight_level: Option<FlightLevel>,
}

impl TargetReport {
    /// Reads a target report; `None` for a record of another table.
    pub fn read(record: &Record<'_>) -> Option<Self> {
        record.table().is_one_of(CAT001).then_some(())?;
        let descriptor = record.item(DESCRIPTOR).map(Descriptor::new);
        let places = match descriptor {
            Some(descriptor) if descriptor.is_track => &TRACK,
            _ => &PLOT,
        };
        let of_track = |place: fn(&TrackPlaces) -> Frn| record.item(place(places.track.as_ref()?));
        Some(Self {
            source: record.item(SOURCE).map(source),
            time: record
                .item(places.time)
                .map(|item| TruncatedTime { ticks: u16_at(item, 0) }),
            descriptor,
            slant_position: record
                .item(places.polar_position)
                .map(|item| PolarPosition::from_nautical_miles(item, 128.0)),
            cartesian_position: of_track(|places| places.cartesian_position)
                .map(|item| CartesianPosition::from_nautical_miles(item, 64.0)),
            polar_velocity: of_track(|places| places.polar_velocity).map(PolarVelocity::new),
            track_number: of_track(|places| places.number).map(|item| u16_at(item, 0)),
            track_status: of_track(|places| places.status).map(RadarTrackStatus::new),
            mode_3a: record.item(places.mode_3a).map(Mode3A::new),
            flight_level: record.item(places.flight_level).map(FlightLevel::new),
        })
    }
}
