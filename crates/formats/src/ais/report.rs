//! Reports of positions, as observations.
//!
//! # Time
//!
//! A report states the second of the minute at which its position was measured, nothing more. The position is of the
//! latest time with this second that is not more than 2 s, the error of clocks, after the time of receipt. A time more
//! than 30 s before the receipt is none of a ship that reports by itself; then, and where the second is not stated, the
//! time of receipt serves. Type 27 states no second.
//!
//! Errors of positions and velocities: [`accuracy`](super::accuracy).

use aivdm::{AisMessage, Heading, Sog, Timestamp};
use frames::Geodetic;
use frames::time::{NS_PER_DAY, NS_PER_S};
use messages::{Identity, TrackState, alert_bits};
use observations::{Alerts, Axes, Emergency, NavigationStatus, Observation, Quality, Statement, TargetCategory};

use super::accuracy::{self, MPS_PER_KT, VelocitySteps};
use super::codes;
use super::static_data::Station;

/// Most that the clock of receipt may be behind that of the ship, nanoseconds.
const CLOCK_ERROR_MAX_NS: i64 = 2 * NS_PER_S;
/// Age of a position at its receipt up to which its second is believed, nanoseconds.
const AGE_MAX_NS: i64 = 30 * NS_PER_S;
/// Speed below which a ship without a course is at rest, knots.
const REST_KT: f64 = 0.2;
/// Speed above which a ship without a heading points to its course, knots.
const UNDER_WAY_KT: f64 = 2.0;

/// A report of a position, of any type. Values that are not available are `None`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Report {
    pub(super) mmsi: u32,
    /// Latitude and longitude, degrees.
    position_deg: Option<[f64; 2]>,
    is_accurate: bool,
    /// The coordinates are whole tenths of a minute.
    is_coarse: bool,
    speed_kt: Option<f64>,
    course_deg: Option<f64>,
    heading_deg: Option<f64>,
    time: Timestamp,
    /// Code of the navigation status.
    navigation: Option<u8>,
    /// Height, metres, and whether it is barometric.
    height_m: Option<(f64, bool)>,
    /// The report is one of a rescue aircraft.
    is_aircraft: bool,
    /// The report is one of class A: the ship may be long.
    is_class_a: bool,
}

impl Report {
    /// The report in a message of type 1, 2, 3, 9, 18, 19 or 27.
    pub(super) fn of(message: &AisMessage) -> Option<Self> {
        macro_rules! report {
            ($of:ident, $speed_kt:expr, $heading_deg:expr, $navigation:expr) => {
                Self {
                    mmsi: $of.mmsi.raw(),
                    position_deg: position_deg([$of.latitude.raw(), $of.longitude.raw()], 600_000),
                    is_accurate: $of.position_accuracy,
                    is_coarse: false,
                    speed_kt: $speed_kt,
                    course_deg: below($of.cog.raw(), 3600).map(|tenths| tenths / 10.0),
                    heading_deg: $heading_deg,
                    time: $of.timestamp,
                    navigation: $navigation,
                    height_m: None,
                    is_aircraft: false,
                    is_class_a: false,
                }
            };
        }
        // The greatest number of a speed or height stands for all greater values.
        let speed_kt = |speed: Sog| below(speed.raw(), 1022).map(|tenths| tenths / 10.0);
        let heading_deg = |heading: Heading| below(heading.raw(), 360);
        Some(match message {
            AisMessage::PositionReportClassA(of) => {
                let navigation = Some(of.navigation_status.to_raw());
                Self {
                    is_class_a: true,
                    ..report!(of, speed_kt(of.sog), heading_deg(of.heading), navigation)
                }
            }
            AisMessage::PositionReportClassB(of) => report!(of, speed_kt(of.sog), heading_deg(of.heading), None),
            AisMessage::PositionReportClassBExtended(of) => {
                report!(of, speed_kt(of.sog), heading_deg(of.heading), None)
            }
            AisMessage::SarAircraftPositionReport(of) => Self {
                height_m: below(of.altitude_meters, 4094).map(|height_m| (height_m, of.barometric_altitude)),
                is_aircraft: true,
                ..report!(of, below(of.sog_knots, 1022), None, None)
            },
            AisMessage::LongRangeBroadcast(of) => Self {
                mmsi: of.mmsi.raw(),
                // `aivdm` 0.3.0 takes other numbers for "not available" than the recommendation.
                position_deg: position_deg([of.latitude_raw, of.longitude_raw], 600),
                is_accurate: of.position_accuracy,
                is_coarse: true,
                speed_kt: below(of.sog_knots.into(), 63),
                course_deg: below(of.cog_degrees, 360),
                heading_deg: None,
                time: Timestamp::NotAvailable,
                navigation: Some(of.navigation_status.to_raw()),
                height_m: None,
                is_aircraft: false,
                is_class_a: true,
            },
            _ => return None,
        })
    }

    /// The observation of the position, received at `received_ns` (UTC, nanoseconds since 1970); `None` without one.
    pub(super) fn observation(&self, sender: &Station, received_ns: i64) -> Option<Observation> {
        let [latitude, longitude] = self.position_deg?;
        let antenna = Geodetic::from_degrees(latitude, longitude, 0.0).ok()?;
        let is_under_way = self.speed_kt.is_some_and(|speed| speed > UNDER_WAY_KT);
        let heading_deg = self.heading_deg.or(self.course_deg.filter(|_| is_under_way));
        let heading_rad = heading_deg.map(f64::to_radians);
        let place = match (sender.hull, heading_rad) {
            (Some(hull), Some(heading_rad)) => hull.centre(antenna, heading_rad),
            _ => antenna,
        };
        let is_distress = self.emergency(sender) == Emergency::Distress;
        Some(Observation {
            time_of_day_ns: Some(measured_ns(self.time, received_ns).rem_euclid(NS_PER_DAY)),
            test: self.is_test(sender),
            // A station is its own track.
            track_number: Some(self.mmsi),
            identity: Identity::default().with_mmsi(self.mmsi).or(&sender.identity),
            geodetic: Some([place.latitude_deg().to_radians(), place.longitude_deg().to_radians()]),
            velocity: self.velocity(),
            axes: Axes::Target,
            velocity_covariance: self.velocity_covariance(),
            pressure_altitude_m: self
                .height_m
                .and_then(|(height, is_barometric)| is_barometric.then_some(height)),
            geometric_height_m: self
                .height_m
                .and_then(|(height, is_barometric)| (!is_barometric).then_some(height)),
            alerts: match codes::is_distress_device(self.category()) {
                true => Alerts::flag(alert_bits::EMERGENCY, is_distress),
                false => Alerts::default(),
            },
            state: TrackState::Confirmed,
            quality: match self.offset_sigma_m(sender, heading_rad) {
                Some(sigma_m) => accuracy::with_offset(self.quality(latitude), sigma_m, heading_rad),
                None => self.quality(latitude),
            },
            ..Observation::default()
        })
    }

    /// What the report states beside its motion; `None` if it states nothing.
    pub(super) fn statement(&self, sender: &Station) -> Option<Statement> {
        let statement = Statement {
            track_number: self.mmsi,
            category: self.category(),
            navigation: codes::navigation_status(self.navigation.unwrap_or(15)),
            emergency: self.emergency(sender),
            ..Statement::default()
        };
        let is_empty = (statement.category, statement.navigation) == Default::default();
        (!is_empty).then_some(statement)
    }

    fn category(&self) -> TargetCategory {
        match self.is_aircraft {
            true => TargetCategory::Rescue,
            false => codes::category_of_number(self.mmsi),
        }
    }

    /// Only devices for distress state one: many ships have the status of an active device by mistake.
    fn emergency(&self, sender: &Station) -> Emergency {
        let is_active = codes::navigation_status(self.navigation.unwrap_or(15)) == NavigationStatus::Rescue;
        match codes::is_distress_device(self.category()) {
            true if self.is_test(sender) => Emergency::None,
            true if is_active => Emergency::Distress,
            _ => Emergency::Unknown,
        }
    }

    /// A device under test has the status 15, and announces the test in a text.
    fn is_test(&self, sender: &Station) -> bool {
        let is_device = codes::is_distress_device(self.category());
        is_device && (sender.is_under_test() || self.navigation == Some(15))
    }

    /// East and north, metres per second.
    fn velocity(&self) -> Option<[f64; 2]> {
        let speed_kt = self.speed_kt?;
        let (sine, cosine) = match self.course_deg {
            Some(course_deg) => course_deg.to_radians().sin_cos(),
            None if speed_kt < REST_KT => return Some([0.0; 2]),
            None => return None,
        };
        let speed_mps = speed_kt * MPS_PER_KT;
        Some([speed_mps * sine, speed_mps * cosine])
    }

    /// Covariance of the velocity; `None` without a course.
    fn velocity_covariance(&self) -> Option<[f64; 3]> {
        let steps = VelocitySteps {
            speed_kt: if self.is_coarse || self.is_aircraft {
                1.0
            } else {
                accuracy::FINE.speed_kt
            },
            course_deg: if self.is_coarse { 1.0 } else { accuracy::FINE.course_deg },
        };
        Some(accuracy::of_velocity(self.speed_kt?, self.course_deg?, steps))
    }

    /// Standard deviation of the distance from the position to the hull's centre, metres; `None` if the position is the
    /// centre's, or of a boat, an aircraft or a device.
    fn offset_sigma_m(&self, sender: &Station, heading_rad: Option<f64>) -> Option<f64> {
        match sender.hull {
            Some(hull) => hull.offset_sigma_m(heading_rad.is_some()),
            None => {
                (self.is_class_a && self.category() == TargetCategory::Unknown).then(|| accuracy::offset_sigma_m(None))
            }
        }
    }

    fn quality(&self, latitude_deg: f64) -> Quality {
        match self.time {
            Timestamp::ManualInputMode | Timestamp::DeadReckoning | Timestamp::Inoperative => Quality::Unknown,
            _ if self.is_coarse => accuracy::of_coarse(self.is_accurate, latitude_deg),
            _ => accuracy::by_flag(self.is_accurate),
        }
    }
}

/// Latitude and longitude of whole parts of a degree; `None` if they are not available, or on no globe.
pub(super) fn position_deg([latitude, longitude]: [i32; 2], per_degree: i32) -> Option<[f64; 2]> {
    let is_place = latitude.abs() <= 90 * per_degree && longitude.abs() <= 180 * per_degree;
    is_place.then(|| [latitude, longitude].map(|parts| f64::from(parts) / f64::from(per_degree)))
}

/// A number below the first one that stands for no value.
fn below(number: u16, end: u16) -> Option<f64> {
    (number < end).then(|| f64::from(number))
}

/// Time of a measurement with its second of the minute, received at `received_ns`.
pub(super) fn measured_ns(time: Timestamp, received_ns: i64) -> i64 {
    let Timestamp::Second(second) = time else {
        return received_ns;
    };
    let latest_ns = received_ns.saturating_add(CLOCK_ERROR_MAX_NS);
    let behind_ns = latest_ns
        .saturating_sub(i64::from(second) * NS_PER_S)
        .rem_euclid(60 * NS_PER_S);
    if behind_ns - CLOCK_ERROR_MAX_NS > AGE_MAX_NS {
        return received_ns;
    }
    latest_ns.saturating_sub(behind_ns)
}
