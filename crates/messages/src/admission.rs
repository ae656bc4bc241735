//! Checks of a sample of an external program, before it is published.
//!
//! A sample that fusion or a tracker would refuse is refused at its publisher, which can correct the mistake: the fault
//! names field, value, limit and remedy. The limits are also those of fusion, so both refuse the same samples.
//!
//! Two faults are known at the publisher alone. A time of measurement far from the present is mostly a mistake of the
//! unit or of the clock, and the magnitude of the number shows which ([`time_fault`]). A covariance that is not
//! positive semidefinite is repaired by fusion, since the source may not be at hand; its publisher is, and can correct
//! it.

use std::f64::consts::{PI, TAU};
use std::fmt;

use crate::{
    Covariance, Cue, DetectionKind, DetectionMark, Identity, IdentityKind, NS_PER_S, PlatformState, STATE_LEN,
    SensorBearing, SensorDetection, SensorTrack, TrackState, WideArea, platform_state_bits, sensor_bearing_bits,
    sensor_detection_bits, sensor_track_bits, wide_area_bits,
};

/// Largest coordinate that a sensor on this planet can report, metres.
pub const POSITION_MAX_M: f64 = 1e8;
/// Largest distance of a stated place from the origin of the system frame, metres: `limits.range_m` is no greater. A
/// place beyond it is none of this deployment, as latitude 0, longitude 0 of a receiver without a fix.
pub const REACH_M: f64 = 2e6;
/// Largest component of a velocity that a sensor on this planet can report, metres per second.
pub const SPEED_MAX_MPS: f64 = 1e5;
/// Largest element of a covariance, m², m²/s or m²/s².
pub const COVARIANCE_MAX: f64 = 1e14;
/// Largest valid time from 1970, nanoseconds: 146 years. Sums and differences of two valid times, and of any
/// configurable time span, fit into 64 bits.
pub const TIME_MAX_NS: i64 = 1 << 62;
/// Largest distance of a time of measurement from the publisher's clock, nanoseconds: ten minutes, less than any
/// difference between a local time and UTC.
pub const CLOCK_LIMIT_NS: i64 = 600_000_000_000;
/// Distance within which a time in another unit is recognised as such, nanoseconds: a day.
const UNIT_REACH_NS: i128 = 86_400_000_000_000;
/// Largest time since a machine's start, nanoseconds: 10 years.
const UPTIME_MAX_NS: i64 = 315_360_000_000_000_000;
/// Smallest eigenvalue of a semidefinite matrix as rounding may show it, relative to the variance.
const ROUNDING: f64 = 1e-9;

const FINITE: &str = "fill the field with a number, or leave it 0";
const VARIANCE: &str = "state the sensor's error: a standard deviation of 30 m is a variance of 900";
const RADIANS: &str = "write radians, not degrees";

/// Reason for which a sample is not published.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Name of the field, with its index.
    pub field: String,
    /// Its value.
    pub value: String,
    /// The limit that the value violates.
    pub limit: String,
    /// Correction of the mistake.
    pub remedy: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            field,
            value,
            limit,
            remedy,
        } = self;
        write!(formatter, "{field} is {value}: {limit}; {remedy}")
    }
}

/// A sample that can be checked before it is published.
pub trait Admission {
    /// Time to which the sample refers, with the field's name; `None` if it has none that must be near the present.
    fn stated_time(&self) -> Option<(&'static str, i64)>;

    /// Returns the first fault of the sample's values apart from its time.
    fn value_fault(&self) -> Option<Fault>;
}

/// Returns the fault of a sample at `now_ns` (UTC, nanoseconds); times farther than `clock_limit_ns` from it are
/// faults. `clock_limit_ns` of `None`: all times on which fusion can calculate are permitted.
pub fn fault<T: Admission>(sample: &T, now_ns: i64, clock_limit_ns: Option<i64>) -> Option<Fault> {
    let time = sample.stated_time();
    time.and_then(|(field, time_ns)| time_fault(field, time_ns, now_ns, clock_limit_ns))
        .or_else(|| sample.value_fault())
}

/// Returns the fault of a time (UTC, nanoseconds since 1970) at `now_ns`.
pub fn time_fault(field: &str, time_ns: i64, now_ns: i64, clock_limit_ns: Option<i64>) -> Option<Fault> {
    let apart_ns = i128::from(time_ns) - i128::from(now_ns);
    let limit_ns = match clock_limit_ns {
        Some(limit_ns) => limit_ns,
        None if is_valid_time(time_ns) => return None,
        None => TIME_MAX_NS,
    };
    if apart_ns.unsigned_abs() <= u128::from(limit_ns.unsigned_abs()) {
        return None;
    }
    Some(far_time(field, (time_ns, now_ns), limit_ns))
}

#[cold]
fn far_time(field: &str, (time_ns, now_ns): (i64, i64), limit_ns: i64) -> Fault {
    let units = [
        ("seconds", 1_000_000_000),
        ("milliseconds", 1_000_000),
        ("microseconds", 1_000),
    ];
    let in_unit = units.iter().find(|(_, unit_ns)| {
        let apart_ns = i128::from(time_ns) * i128::from(*unit_ns) - i128::from(now_ns);
        apart_ns.abs() <= UNIT_REACH_NS
    });
    let apart_s = (i128::from(time_ns) - i128::from(now_ns)) as f64 / NS_PER_S;
    let remedy = match in_unit {
        Some((unit, factor)) => format!("the number is in {unit}; multiply it by {factor}"),
        None if time_ns == 0 => "fill in the time of measurement".to_owned(),
        None if (0..UPTIME_MAX_NS).contains(&time_ns) => {
            "the number is no UTC, perhaps of the monotonic clock; use the clock of UTC".to_owned()
        }
        None => format!(
            "the clock is {:.0} s {}; set the sensor's clock or this machine's by UTC, or raise the limit",
            apart_s.abs(),
            if apart_s > 0.0 { "ahead" } else { "behind" }
        ),
    };
    Fault {
        field: field.to_owned(),
        value: time_ns.to_string(),
        limit: format!(
            "nanoseconds of UTC since 1970 within {} s of {now_ns}, the time of this machine",
            limit_ns / 1_000_000_000
        ),
        remedy,
    }
}

/// Whether fusion can calculate with a time.
#[inline]
pub fn is_valid_time(time_ns: i64) -> bool {
    (-TIME_MAX_NS..TIME_MAX_NS).contains(&time_ns)
}

/// Whether all values are within a limit. Not a number is within none. All are looked at, without a branch for each.
#[inline]
pub fn within(values: &[f64], limit: f64) -> bool {
    values.iter().fold(true, |all, value| all & (value.abs() <= limit))
}

impl SensorTrack {
    /// Whether the report's time, position and velocity are possible on this planet.
    #[inline]
    pub fn has_possible_state(&self) -> bool {
        is_valid_time(self.time_of_measurement_ns)
            && within(&self.position_m, POSITION_MAX_M)
            && within(&self.velocity_mps, SPEED_MAX_MPS)
    }
}

impl Covariance {
    /// Whether the covariance is possible on this planet: no variance is negative, and those of east and north are not
    /// 0.
    #[inline]
    pub fn is_possible(&self) -> bool {
        within(&self.upper, COVARIANCE_MAX)
            && (0..STATE_LEN).all(|index| self.get(index, index) >= 0.0)
            && (0..2).all(|index| self.get(index, index) > 0.0)
    }

    /// Returns the first component that the components before it leave with a negative variance: then the matrix is not
    /// positive semidefinite. Components of variance 0 are unknown and must not be correlated.
    fn indefinite_component(&self) -> Option<usize> {
        if self.is_diagonal() {
            return None;
        }
        let at = Self::index;
        let mut rest = self.upper;
        for known in 0..STATE_LEN {
            let (variance, stated) = (rest[at(known, known)], self.get(known, known));
            if variance < -ROUNDING * stated {
                return Some(known);
            }
            let is_spent = variance <= ROUNDING * stated;
            for row in known + 1..STATE_LEN {
                let shared = rest[at(known, row)];
                if is_spent {
                    // A component that is known exactly, given the ones before, has no covariance left.
                    let scale = (stated * self.get(row, row)).sqrt();
                    if shared.abs() > ROUNDING.sqrt() * scale {
                        return Some(row);
                    }
                    continue;
                }
                let slope = shared / variance;
                for column in row..STATE_LEN {
                    rest[at(row, column)] -= slope * rest[at(known, column)];
                }
            }
        }
        None
    }

    fn fault(&self) -> Option<Fault> {
        if self.is_possible() && self.indefinite_component().is_none() {
            return None;
        }
        Some(self.which_fault())
    }

    #[cold]
    fn which_fault(&self) -> Fault {
        let found = values_fault("covariance.upper", &self.upper, COVARIANCE_MAX);
        found.unwrap_or_else(|| {
            const AXES: [&str; STATE_LEN] = ["east", "north", "up", "velocity east", "velocity north", "velocity up"];
            let variance = |index: usize| self.get(index, index);
            let wrong = (0..STATE_LEN).find(|index| variance(*index) < 0.0 || (*index < 2 && variance(*index) == 0.0));
            let (index, limit, remedy) = match wrong {
                Some(index) if index < 2 => (index, "must be above 0", VARIANCE),
                Some(index) => (index, "must not be negative", VARIANCE),
                None => (
                    self.indefinite_component().unwrap_or_default(),
                    "must leave a variance beside the correlations with the other components (positive semidefinite)",
                    "no correlation exceeds 1; order the 21 elements by rows of the upper triangle",
                ),
            };
            Fault {
                field: format!(
                    "covariance.upper[{}], the variance {},",
                    Self::index(index, index),
                    AXES[index]
                ),
                value: variance(index).to_string(),
                limit: limit.to_owned(),
                remedy: remedy.to_owned(),
            }
        })
    }
}

#[cold]
fn fault_of(field: String, value: impl fmt::Display, limit: impl Into<String>, remedy: &str) -> Fault {
    Fault {
        field,
        value: value.to_string(),
        limit: limit.into(),
        remedy: remedy.to_owned(),
    }
}

/// The first of the values of a field whose magnitude exceeds a limit, or which is not a number.
fn values_fault(field: &str, values: &[f64], limit: f64) -> Option<Fault> {
    if within(values, limit) {
        return None;
    }
    let (index, value) = values
        .iter()
        .enumerate()
        .find(|(_, value)| !within(std::slice::from_ref(*value), limit))?;
    let field = match values.len() {
        1 => field.to_owned(),
        _ => format!("{field}[{index}]"),
    };
    let remedy = if value.is_finite() { "check its unit" } else { FINITE };
    Some(fault_of(
        field,
        value,
        format!("must be a number from {:e} to {limit:e}", -limit),
        remedy,
    ))
}

fn positive(field: &str, value: f64, limit: f64, remedy: &str) -> Option<Fault> {
    let is_fine = value > 0.0 && value <= limit;
    (!is_fine).then(|| {
        fault_of(
            field.to_owned(),
            value,
            format!("must be above 0 and at most {limit:e}"),
            remedy,
        )
    })
}

fn code_fault(field: &str, code: u8, is_known: bool) -> Option<Fault> {
    (!is_known).then(|| {
        fault_of(
            field.to_owned(),
            code,
            "is no code of this field",
            "use a code of the header",
        )
    })
}

/// The fault of a number that no target of its kind has.
fn identity_fault(identity: &Identity) -> Option<Fault> {
    code_fault(
        "identity.kind",
        identity.kind,
        IdentityKind::from_code(identity.kind).is_some(),
    )
    .or_else(|| {
        let (field, number, limit) = identity.unspelled()?;
        let remedy = "check the number and the kind: 1 for an address, 2 for an MMSI";
        Some(fault_of(field.to_owned(), number, limit, remedy))
    })
}

impl Admission for SensorTrack {
    fn stated_time(&self) -> Option<(&'static str, i64)> {
        Some(("time_of_measurement_ns", self.time_of_measurement_ns))
    }

    fn value_fault(&self) -> Option<Fault> {
        let spread = || match self.gives_trace() {
            true => positive("trace_m2", self.trace_m2, COVARIANCE_MAX, VARIANCE),
            false => self.covariance.fault(),
        };
        code_fault("state", self.state, TrackState::from_code(self.state).is_some())
            .or_else(|| values_fault("position_m", &self.position_m, POSITION_MAX_M))
            .or_else(|| values_fault("velocity_mps", &self.velocity_mps, SPEED_MAX_MPS))
            .or_else(spread)
            .or_else(|| {
                let is_measured = self.valid & sensor_track_bits::MEASURED != 0;
                is_measured.then(|| values_fault("measured_m", &self.measured_m, POSITION_MAX_M))?
            })
            .or_else(|| {
                let is_fine = (0.0..=1.0).contains(&self.existence);
                let what = || {
                    fault_of(
                        "existence".to_owned(),
                        self.existence,
                        "must be a probability",
                        "0: not stated",
                    )
                };
                (!is_fine).then(what)
            })
            .or_else(|| values_fault("turn_rate_radps", &[f64::from(self.turn_rate_radps)], TAU))
            .or_else(|| {
                values_fault(
                    "pressure_offset_m",
                    &[f64::from(self.pressure_offset_m)],
                    POSITION_MAX_M,
                )
            })
            .or_else(|| identity_fault(&self.identity))
    }
}

impl Admission for SensorDetection {
    fn stated_time(&self) -> Option<(&'static str, i64)> {
        Some(("time_of_measurement_ns", self.time_of_measurement_ns))
    }

    fn value_fault(&self) -> Option<Fault> {
        use sensor_detection_bits as bits;
        let states = |bit: u8| self.valid & bit != 0;
        if states(bits::MARK) {
            return code_fault("kind", self.kind, DetectionMark::from_code(self.kind).is_some());
        }
        let Some(kind) = DetectionKind::from_code(self.kind) else {
            return code_fault("kind", self.kind, false);
        };
        let quantities = kind.quantities();
        let value = |index: usize| quantities[index].fault(self.values[index]).map(|what| (index, what));
        let sigmas = || {
            let measured = (0..quantities.len()).chain(states(bits::RANGE_RATE).then_some(3));
            let remedy = "state a standard deviation in the value's unit, or leave out the bit SIGMAS";
            let mut faults = measured
                .map(|index| (index, self.sigmas[index]))
                .filter(|(_, sigma)| !(*sigma > 0.0 && *sigma <= COVARIANCE_MAX.sqrt()));
            faults
                .next()
                .and_then(|(index, sigma)| positive(&format!("sigmas[{index}]"), sigma, COVARIANCE_MAX.sqrt(), remedy))
        };
        values_fault("values", &self.values[..quantities.len()], POSITION_MAX_M)
            .or_else(|| {
                let (index, what) = (0..quantities.len()).find_map(value)?;
                let remedy = "check unit and order of the values";
                Some(fault_of(format!("values[{index}]"), self.values[index], what, remedy))
            })
            .or_else(|| states(bits::SIGMAS).then(sigmas)?)
            .or_else(|| {
                states(bits::RANGE_RATE)
                    .then(|| values_fault("range_rate_mps", &[self.range_rate_mps], SPEED_MAX_MPS))?
            })
            .or_else(|| values_fault("platform_m", &self.platform_m, POSITION_MAX_M))
            .or_else(|| {
                let velocity = self.platform_velocity_mps.map(f64::from);
                values_fault("platform_velocity_mps", &velocity, SPEED_MAX_MPS)
            })
            .or_else(|| values_fault("platform_attitude_rad", &self.platform_attitude_rad.map(f64::from), TAU))
            .or_else(|| identity_fault(&self.identity))
    }
}

impl Admission for SensorBearing {
    fn stated_time(&self) -> Option<(&'static str, i64)> {
        Some(("time_of_measurement_ns", self.time_of_measurement_ns))
    }

    fn value_fault(&self) -> Option<Fault> {
        let has_heading = self.valid & sensor_bearing_bits::HEADING != 0;
        angle("bearing_rad", self.bearing_rad)
            .or_else(|| positive("sigma_rad", self.sigma_rad, PI, RADIANS))
            .or_else(|| values_fault("platform_m", &self.platform_m, POSITION_MAX_M))
            .or_else(|| has_heading.then(|| angle("heading_rad", self.heading_rad))?)
    }
}

fn angle(field: &str, value: f64) -> Option<Fault> {
    let is_fine = value.abs() <= TAU;
    (!is_fine).then(|| fault_of(field.to_owned(), value, "must be within a full turn", RADIANS))
}

impl Admission for PlatformState {
    fn stated_time(&self) -> Option<(&'static str, i64)> {
        Some(("time_ns", self.time_ns))
    }

    fn value_fault(&self) -> Option<Fault> {
        use platform_state_bits as bits;
        let states = |bit: u16| self.valid & bit != 0;
        values_fault("position_m", &self.position_m, POSITION_MAX_M)
            .or_else(|| values_fault("velocity_mps", &self.velocity_mps, SPEED_MAX_MPS))
            .or_else(|| states(bits::HEADING).then(|| angle("heading_rad", self.heading_rad))?)
            .or_else(|| {
                let has_attitude = states(bits::ATTITUDE);
                has_attitude.then(|| angle("pitch_rad", self.pitch_rad).or_else(|| angle("roll_rad", self.roll_rad)))?
            })
            .or_else(|| {
                let stated = states(bits::POSITION_SIGMA);
                stated.then(|| positive("position_sigma_m", self.position_sigma_m, POSITION_MAX_M, VARIANCE))?
            })
            .or_else(|| {
                let stated = states(bits::HEADING_SIGMA);
                stated.then(|| positive("heading_sigma_rad", self.heading_sigma_rad, PI, RADIANS))?
            })
    }
}

impl Admission for WideArea {
    fn stated_time(&self) -> Option<(&'static str, i64)> {
        Some(("time_of_observation_ns", self.time_of_observation_ns))
    }

    fn value_fault(&self) -> Option<Fault> {
        let has_origin = self.valid & wide_area_bits::ORIGIN != 0;
        values_fault("position_m", &self.position_m, POSITION_MAX_M)
            .or_else(|| values_fault("velocity_mps", &self.velocity_mps, SPEED_MAX_MPS))
            .or_else(|| has_origin.then(|| values_fault("origin_m", &self.origin_m, POSITION_MAX_M))?)
    }
}

impl Admission for Cue {
    fn stated_time(&self) -> Option<(&'static str, i64)> {
        None
    }

    fn value_fault(&self) -> Option<Fault> {
        None
    }
}

#[cfg(test)]
#[path = "admission_tests.rs"]
mod tests;
