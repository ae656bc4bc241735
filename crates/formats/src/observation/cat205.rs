//! CAT205: radio direction finders: bearings of transmissions, and positions that a system of several finders has made
//! of them.
//!
//! A [`FinderReport`] is a record in the sender's own terms; [`FinderReport::measurement`] is what the locator takes,
//! in the system frame. A system bearing begins at the position in the record, the bearing of a single sensor at the
//! position in the record or, without one, at the sensor's configured place. I205/070 counts from geographical north at
//! that position, I205/080 from north at the system reference point. Meridians converge: away from the origin of the
//! system frame both differ from the frame's north, and are turned into it.
//!
//! # Limits
//!
//! - The category has no standard deviation of a bearing. Quality (I205/100) has a meaning by agreement only, and the
//!   quality of a signal (I205/190) no unit: the deviation is configured.
//! - The confidence of the radius in I205/110 is not stated; the radius is taken for that of 95 %.
//! - A report of two transmitters at once (message type 3) is not used: neither position is sure.
//! - Elevations (I205/200) have no stated error and are not used. Transmitters are placed at the height of the finder.
//!
//! # Sources
//!
//! EUROCONTROL-SPEC-0149-31; ICAO Annex 10 volume V, table 4-1 (bis), for the frequencies behind the names of channels.

use std::f64::consts::TAU;

use asterix::categories::CAT205;
use frames::time::DayUnroller;
use frames::{Geodetic, SensorFrame, SystemFrame};
use observations::{Bearing, EmitterMeasurement, RADIUS95_SIGMAS, ReadyFix};

use super::*;

const KIND: Elements<1> = whole(CAT205, "000");
const TIME: Elements<1> = whole(CAT205, "030");
const CHANNEL: Frn = item(CAT205, "090");
const GEODETIC: Elements<2> = elements(CAT205, "050", ["LAT", "LON"]);
const CARTESIAN: Elements<2> = elements(CAT205, "060", ["X", "Y"]);
const LOCAL_BEARING: Elements<1> = whole(CAT205, "070");
const SYSTEM_BEARING: Elements<1> = whole(CAT205, "080");
const UNCERTAINTY: Elements<1> = whole(CAT205, "110");
const TRACK_NUMBER: Elements<1> = whole(CAT205, "160");
const SENSOR: Elements<1> = whole(CAT205, "170");

/// Largest standard deviation of a usable direction, radians.
const SIGMA_MAX_RAD: f64 = 1.0;
/// A full turn with the rounding of its conversion.
const TURN_RAD: f64 = TAU * (1.0 + 1e-12);
/// Length of a vector of which only the direction counts, metres: far above the rounding of positions.
const ARM_M: f64 = 1e4;

/// Report of a radio direction finder, in the sender's own terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinderReport {
    /// System area code and system identification code of the sender.
    pub sac_sic: Option<(u8, u8)>,
    /// Number of the sensor within the sender's system.
    pub sensor: Option<u8>,
    /// Kind of the report.
    pub kind: FinderReportKind,
    /// Time of transmission of the report, nanoseconds since midnight UTC.
    pub time_of_day_ns: Option<i64>,
    /// Latitude and longitude, radians: of the finder in reports of bearings, else of the transmitter.
    pub geodetic: Option<[f64; 2]>,
    /// The same position towards east and north of the system reference point, metres.
    pub cartesian: Option<[f64; 2]>,
    /// Bearing from geographical north at the finder, radians clockwise.
    pub local_bearing_rad: Option<f64>,
    /// Bearing from north at the system reference point, radians clockwise.
    pub system_bearing_rad: Option<f64>,
    /// Radius around the position within which the transmitter is expected, metres.
    pub uncertainty_m: Option<f64>,
    /// Number of the transmission's track.
    pub track_number: Option<u16>,
    /// Name of the channel.
    pub channel: Option<[u8; 7]>,
    /// Frequency of the channel, hertz, if the channel's name is one.
    pub frequency_hz: Option<f64>,
}

/// Kind of a report of a direction finder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FinderReportKind {
    /// Position of a transmitter.
    Position,
    /// Bearing from one of the system's finders.
    Bearing,
    /// Positions of two transmitters at the same time on the same frequency.
    Conflict,
    /// End of a transmission.
    End,
    /// Data of a single sensor.
    Sensor,
    /// Another number, or none.
    Unknown,
}

/// What is configured of the sender of reports.
#[derive(Clone, Copy, Debug)]
pub struct DirectionFinder {
    frame: SystemFrame,
    reference: SensorFrame,
    height_m: f64,
    sigma_rad: f64,
}

/// Why a report gives no measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FinderRefusal {
    /// A report of a kind that measures nothing alone.
    #[error("a report of this kind (I205/000) has no bearing, and no position of a single transmitter")]
    Kind,
    /// Without a time of day.
    #[error("I205/030, the time of day, is missing")]
    Time,
    /// Without a bearing.
    #[error("I205/070 and I205/080, the bearings, are missing")]
    Bearing,
    /// A bearing of more than a full turn.
    #[error("the bearing in I205/070 or I205/080 is more than 360°")]
    BearingRange,
    /// Without the position that its kind needs.
    #[error("I205/050 and I205/060, the positions, are missing")]
    Position,
    /// A latitude beyond a pole, or a longitude beyond half a turn.
    #[error("the position in I205/050 is not on the earth")]
    PositionRange,
    /// A position without its radius.
    #[error("I205/110, the uncertainty of the position, is missing or 0")]
    Uncertainty,
    /// A position without number.
    #[error("I205/160, the number of the track, is missing")]
    TrackNumber,
}

impl FinderRefusal {
    /// A word for the reason, by which refusals are told apart.
    pub fn label(self) -> &'static str {
        match self {
            Self::Kind => "kind",
            Self::Time => "time",
            Self::Bearing => "bearing",
            Self::BearingRange => "bearing-range",
            Self::Position => "position",
            Self::PositionRange => "position-range",
            Self::Uncertainty => "uncertainty",
            Self::TrackNumber => "track-number",
        }
    }
}

/// The report in a record; `None` for records of other categories.
pub fn finder_report(record: &Record<'_>) -> Option<FinderReport> {
    record.table().is_one_of(CAT205).then(|| FinderReport {
        sac_sic: record.sender(),
        sensor: SENSOR.number(record).map(|number| number as u8),
        kind: match KIND.number(record) {
            Some(1) => FinderReportKind::Position,
            Some(2) => FinderReportKind::Bearing,
            Some(3) => FinderReportKind::Conflict,
            Some(4) => FinderReportKind::End,
            Some(5) => FinderReportKind::Sensor,
            _ => FinderReportKind::Unknown,
        },
        time_of_day_ns: time_of_day_ns(record, &TIME),
        geodetic: GEODETIC.quantities(record),
        cartesian: CARTESIAN.quantities(record),
        local_bearing_rad: LOCAL_BEARING.quantity(record),
        system_bearing_rad: SYSTEM_BEARING.quantity(record),
        uncertainty_m: UNCERTAINTY.quantity(record),
        track_number: TRACK_NUMBER.number(record).map(|number| number as u16),
        channel: record.item(CHANNEL).and_then(|name| name.try_into().ok()),
        frequency_hz: record.item(CHANNEL).and_then(frequency_hz),
    })
}

impl DirectionFinder {
    /// A finder with bearings of this standard deviation (radians, above 0 and at most 1), for measurements in `frame`.
    /// `place` is that of the finder; of a system with several, it is the system reference point. `None` for another
    /// deviation.
    pub fn new(frame: &SystemFrame, place: Geodetic, sigma_rad: f64) -> Option<Self> {
        (sigma_rad > 0.0 && sigma_rad <= SIGMA_MAX_RAD).then(|| Self {
            frame: *frame,
            reference: SensorFrame::new(frame, place, 0.0),
            height_m: place.height_m(),
            sigma_rad,
        })
    }

    fn at(&self, [latitude, longitude]: [f64; 2]) -> Result<[f64; 3], FinderRefusal> {
        let place = Geodetic::from_degrees(latitude.to_degrees(), longitude.to_degrees(), self.height_m);
        place
            .map(|place| self.frame.to_local(place))
            .map_err(|_| FinderRefusal::PositionRange)
    }
}

impl FinderReport {
    /// Returns whether the report states this sender (SAC and SIC), or no sender; true of every report for `None`.
    pub fn may_be_of(&self, sac_sic: Option<(u8, u8)>) -> bool {
        sac_sic.is_none() || self.sac_sic.is_none() || self.sac_sic == sac_sic
    }

    /// The measurement in the system frame: a bearing, or a position found by the sender. The day is the one that
    /// brings the time of day nearest to `near_ns` (UTC, nanoseconds).
    ///
    /// # Errors
    /// Why the report gives none.
    pub fn measurement(&self, finder: &DirectionFinder, near_ns: i64) -> Result<EmitterMeasurement, FinderRefusal> {
        let start_m = match self.kind {
            FinderReportKind::Position => return self.fix(finder, near_ns).map(EmitterMeasurement::Fix),
            FinderReportKind::Bearing => self.position(finder)?.ok_or(FinderRefusal::Position)?,
            FinderReportKind::Sensor => self
                .position(finder)?
                .unwrap_or_else(|| finder.reference.cartesian([0.0; 3])),
            FinderReportKind::Conflict | FinderReportKind::End | FinderReportKind::Unknown => {
                return Err(FinderRefusal::Kind);
            }
        };
        Ok(EmitterMeasurement::Bearing(Bearing {
            time_of_measurement_ns: self.utc_ns(near_ns)?,
            emitter_id: self.track_number.map(u32::from),
            bearing_rad: self.bearing_rad(finder, start_m)?,
            sigma_rad: finder.sigma_rad,
            platform_m: start_m,
            heading_rad: None,
            frequency_hz: self.frequency_hz,
            pulse_interval_s: None,
        }))
    }

    fn fix(&self, finder: &DirectionFinder, near_ns: i64) -> Result<ReadyFix, FinderRefusal> {
        let radius_m = self.uncertainty_m.filter(|radius| *radius > 0.0);
        let variance_m2 = (radius_m.ok_or(FinderRefusal::Uncertainty)? / RADIUS95_SIGMAS).powi(2);
        Ok(ReadyFix {
            time_of_measurement_ns: self.utc_ns(near_ns)?,
            emitter_id: self.track_number.map(u32::from).ok_or(FinderRefusal::TrackNumber)?,
            position_m: self.position(finder)?.ok_or(FinderRefusal::Position)?,
            covariance_m2: [variance_m2, 0.0, variance_m2],
        })
    }

    fn utc_ns(&self, near_ns: i64) -> Result<i64, FinderRefusal> {
        let time_of_day_ns = self.time_of_day_ns.ok_or(FinderRefusal::Time)?;
        Ok(DayUnroller::near(near_ns).utc_ns(time_of_day_ns))
    }

    fn position(&self, finder: &DirectionFinder) -> Result<Option<[f64; 3]>, FinderRefusal> {
        match (self.geodetic, self.cartesian) {
            (Some(geodetic), _) => finder.at(geodetic).map(Some),
            (None, cartesian) => Ok(cartesian.map(|position| finder.reference.above(position, finder.height_m))),
        }
    }

    /// Bearing clockwise from north of the system frame.
    fn bearing_rad(&self, finder: &DirectionFinder, start_m: [f64; 3]) -> Result<f64, FinderRefusal> {
        let stated = self.local_bearing_rad.or(self.system_bearing_rad);
        let stated = stated.ok_or(FinderRefusal::Bearing)?;
        if stated > TURN_RAD {
            return Err(FinderRefusal::BearingRange);
        }
        let (sine, cosine) = stated.sin_cos();
        let [east, north] = if self.local_bearing_rad.is_some() {
            let [east, north, _] = finder.frame.axes(start_m);
            [0, 1].map(|axis| sine * east[axis] + cosine * north[axis])
        } else {
            finder.reference.velocity([sine * ARM_M, cosine * ARM_M])
        };
        Ok(east.atan2(north).rem_euclid(TAU))
    }
}

/// Frequency behind the name of a channel such as 121.500, hertz. In the aeronautical band, names between multiples of
/// 25 kHz stand for the three channels of 8.33 kHz in them: .005, .010 and .015 behind the multiple.
fn frequency_hz(name: &[u8]) -> Option<f64> {
    const AERONAUTICAL_KHZ: std::ops::Range<u32> = 117_975..137_000;
    let name = std::str::from_utf8(name).ok()?.trim_matches([' ', '\0']);
    let (mhz, fraction) = name.split_once('.').unwrap_or((name, ""));
    let is_number = |text: &str| text.bytes().all(|digit| digit.is_ascii_digit());
    if mhz.is_empty() || !is_number(mhz) || !is_number(fraction) {
        return None;
    }
    let stated_hz = name.parse::<f64>().ok()? * 1e6;
    let khz = (stated_hz / 1e3).round() as u32;
    let base_hz = f64::from(khz / 25 * 25) * 1e3;
    let frequency_hz = match khz % 25 {
        5 if AERONAUTICAL_KHZ.contains(&khz) => base_hz,
        10 if AERONAUTICAL_KHZ.contains(&khz) => base_hz + 25e3 / 3.0,
        15 if AERONAUTICAL_KHZ.contains(&khz) => base_hz + 50e3 / 3.0,
        _ => stated_hz,
    };
    (frequency_hz > 0.0).then_some(frequency_hz)
}
