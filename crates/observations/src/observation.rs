//! A target report of any format, still in the sensor's own terms.
//!
//! Values missing in an observation were missing in the source's report: nothing is made up here, and nothing
//! converted but units.

use messages::{Identity, TrackState};

use crate::Alerts;

/// Period of truncated times, nanoseconds: two bytes of 1/128 s.
pub const TRUNCATION_NS: i64 = 512_000_000_000;
/// Ratio of the radius that holds 95 % of a circular normal distribution to its standard deviation per axis.
pub const RADIUS95_SIGMAS: f64 = 2.447_746_8;

/// A target report in the sensor's own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// System area code and system identification code of the sender; `None` where it is the same as in the record
    /// before.
    pub sac_sic: Option<(u8, u8)>,
    /// Time of measurement, nanoseconds since midnight UTC.
    pub time_of_day_ns: Option<i64>,
    /// Time of measurement, nanoseconds since the last whole [`TRUNCATION_NS`] after midnight UTC, of
    /// a source that sends no more of it.
    pub truncated_time_ns: Option<i64>,
    /// Set if a transponder's reply has contributed; `false` for the echo of a primary radar alone. `None` if the
    /// report comes from no detection, or does not state it.
    pub secondary: Option<bool>,
    /// Set if the report is from a fixed transponder that only monitors the system.
    pub field_monitor: bool,
    /// Set if the report is simulated or a test.
    pub test: bool,
    /// Set if the sender reports a failed check of the position.
    pub suspect: bool,
    /// Number of the track at its source; the address, where the source numbers none.
    pub track_number: Option<u32>,
    /// Set for a plot: a new detection of the sensor, not yet part of any track of the sensor.
    pub plot: bool,
    /// Identity as the target states it.
    pub identity: Identity,
    /// Position towards the sensor's own x (its east) and y (its north).
    pub cartesian: Option<[f64; 2]>,
    /// Plane of `cartesian`.
    pub plane: Plane,
    /// Range along the ground (m) and azimuth clockwise from the sensor's north (rad).
    pub polar: Option<[f64; 2]>,
    /// Straight distance (m) and azimuth clockwise from the sensor's north (rad).
    pub slant_polar: Option<[f64; 2]>,
    /// Radial speed measured by the Doppler effect, with the sender's sign, metres per second.
    pub doppler_mps: Option<f64>,
    /// Latitude and longitude, radians.
    pub geodetic: Option<[f64; 2]>,
    /// Horizontal velocity along two axes, metres per second.
    pub velocity: Option<[f64; 2]>,
    /// Axes of `velocity`.
    pub axes: Axes,
    /// The report's own covariance (xx, xy, yy) of `velocity`, m²/s².
    pub velocity_covariance: Option<[f64; 3]>,
    /// Altitude in the standard atmosphere, metres.
    pub pressure_altitude_m: Option<f64>,
    /// Altitude in the standard atmosphere that the transponder stated last, metres, and its age, nanoseconds;
    /// `None` if `pressure_altitude_m` is current.
    pub stated_altitude: Option<(f64, i64)>,
    /// Height above mean sea level or the ellipsoid, whichever the source gives, metres.
    pub geometric_height_m: Option<f64>,
    /// Height above the ellipsoid (WGS-84), metres, where the report states it as such.
    pub ellipsoid_height_m: Option<f64>,
    /// Rate of climb, metres per second.
    pub vertical_rate_mps: Option<f64>,
    /// Set if the target reports that it is on the ground.
    pub on_ground: bool,
    /// Alerts of the target or its source, without those of the Mode 3/A code alone.
    pub alerts: Alerts,
    /// State of the track at its source.
    pub state: TrackState,
    /// Reported horizontal accuracy of the position in [`Observation::position`].
    pub quality: Quality,
}

/// Plane of a Cartesian position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// Tangential to the earth at the sensor; the position lies straight below or above the target.
    #[default]
    Tangent,
    /// The target, turned down into the horizon: its distance from the sensor is the straight one.
    Slant,
    /// A map of the ground around the sensor, in stereographic projection.
    Stereographic,
}

/// Axes of a velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// The sensor's own x and y.
    #[default]
    Sensor,
    /// True east and north at the target. Meridians converge: at 45° of latitude and 300 km east of the sensor, north
    /// is almost 3° off the sensor's.
    Target,
}

/// Position in one of the sensors' forms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// See [`Observation::cartesian`].
    Cartesian([f64; 2], Plane),
    /// See [`Observation::polar`].
    Polar([f64; 2]),
    /// See [`Observation::slant_polar`].
    Slant([f64; 2]),
    /// See [`Observation::geodetic`].
    Geodetic([f64; 2]),
}

/// Statement of a report on its own horizontal accuracy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Quality {
    /// Nothing.
    #[default]
    Unstated,
    /// Covariance (xx, xy, yy), m².
    Covariance([f64; 3]),
    /// Horizontal dilution of precision: position error per range error.
    Dilution(f64),
    /// Radius within which the position lies with 95 % probability, metres.
    Radius95(f64),
    /// The report declares its accuracy unknown.
    Unknown,
}

impl Observation {
    /// The position as the source's tracker calculated it, or the only one there is.
    pub fn position(&self) -> Option<Position> {
        let cartesian = self.cartesian.map(|position| Position::Cartesian(position, self.plane));
        let geodetic = || self.geodetic.map(Position::Geodetic);
        cartesian.or_else(|| self.polar_position()).or_else(geodetic)
    }

    /// Altitude in the standard atmosphere that the transponder stated, metres, and its age, nanoseconds.
    pub fn transponder_altitude(&self) -> Option<(f64, i64)> {
        self.stated_altitude
            .or_else(|| self.pressure_altitude_m.map(|altitude_m| (altitude_m, 0)))
    }

    /// The position as range and azimuth: as measured, where the source has a tracker as well.
    pub fn polar_position(&self) -> Option<Position> {
        let slant = || self.slant_polar.map(Position::Slant);
        self.polar.map(Position::Polar).or_else(slant)
    }
}

/// Record about the sensor itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ServiceMessage {
    /// System area code and system identification code of the sensor, if the message has them.
    pub sac_sic: Option<(u8, u8)>,
    /// Time of the message, nanoseconds since midnight UTC.
    pub time_of_day_ns: Option<i64>,
    /// Set if the sensor's next turn begins: its antenna points north, or a new update cycle starts.
    pub turn_begins: bool,
    /// Time of an antenna turn, nanoseconds, if the message states it.
    pub turn_ns: Option<i64>,
}
