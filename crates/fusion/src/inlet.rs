//! Checks of a report before it is believed.

use messages::{AXES, Counter, Covariance, Identity, NS_PER_S, STATE_LEN, SensorTrack, TrackState, sensor_track_bits};

use crate::settings::{ReportLimits, SourceSettings};
use crate::system_tracks::SystemTracks;

/// Largest coordinate, metres; climb, metres per second; and square of a deviation that a sensor on this planet can
/// report.
const POSITION_MAX_M: f64 = 1e8;
const SPEED_MAX_MPS: f64 = 1e5;
const COVARIANCE_MAX: f64 = 1e14;
/// Smallest variances that are believed, of position (m²) and velocity (m²/s²): to a millimetre and a tenth of a
/// millimetre per second nothing is known.
const VARIANCE_MIN: [f64; 2] = [1e-6, 1e-8];
/// Standard deviation of a velocity that a report does not give, metres per second.
const UNKNOWN_VELOCITY_SIGMA_MPS: f64 = 100.0;
/// Times farther from 1970 than this are none, nanoseconds: 146 years. Of any two others, and of any time span that can
/// be configured, sums and differences can be told in 64 bits.
const TIME_MAX_NS: i64 = 1 << 62;
/// Farther apart than this, two reports of one address are not of one target, metres.
const ADDRESS_REACH_M: f64 = 10e3;

/// Returns whether a report can be one of these sources, and no order keeps it out.
pub(crate) fn is_valid(report: &SensorTrack, sources: &[SourceSettings]) -> bool {
    let Some(source) = sources.get(usize::from(report.source)) else {
        return false;
    };
    let ReportLimits {
        place_m,
        range_m,
        speed_mps,
    } = source.limits;
    // Not a number is within no limit. All are looked at, without a branch for each.
    let within = |values: &[f64], limit: f64| values.iter().fold(true, |all, value| all & (value.abs() <= limit));
    let is_in_reach = |[east, north]: [f64; 2], limit: f64| east * east + north * north <= limit * limit;
    let [[x, y, _], [vx, vy, _]] = [report.position_m, report.velocity_mps];
    (-TIME_MAX_NS..TIME_MAX_NS).contains(&report.time_of_measurement_ns)
        && !source.is_out
        && is_in_reach([x - place_m[0], y - place_m[1]], range_m)
        && is_in_reach([vx, vy], speed_mps)
        && TrackState::from_code(report.state).is_some()
        && within(&report.position_m, POSITION_MAX_M)
        && within(&report.velocity_mps, SPEED_MAX_MPS)
        && within(&report.covariance.upper, COVARIANCE_MAX)
        && (0..STATE_LEN).all(|index| report.covariance.get(index, index) >= 0.0)
        && (0..2).all(|index| report.covariance.get(index, index) > 0.0)
}

/// Counter of a report that is not valid.
#[cold]
pub(crate) fn rejection(report: &SensorTrack, sources: &[SourceSettings]) -> Counter {
    match sources.get(usize::from(report.source)) {
        Some(source) if source.is_out => Counter::RejectedByOrder,
        _ => Counter::RejectedInvalid,
    }
}

/// A report that has the trace of its covariance in place of the covariance, with one: positions as uncertain on each
/// axis as the trace says, velocities as if they were of two such positions a period apart. `None` for any other.
pub(crate) fn completed(report: &SensorTrack, sources: &[SourceSettings]) -> Option<SensorTrack> {
    if report.covariance.upper[0] != 0.0 || !report.has(sensor_track_bits::TRACE) {
        return None;
    }
    let period_s = sources.get(usize::from(report.source))?.period_ns as f64 / NS_PER_S;
    let sigma_m = (0.5 * report.trace_m2).sqrt();
    let sigma_mps = match report.has(sensor_track_bits::VELOCITY) {
        true => std::f64::consts::SQRT_2 * sigma_m / period_s,
        false => UNKNOWN_VELOCITY_SIGMA_MPS,
    };
    let covariance = Covariance::diagonal([sigma_m; AXES], [sigma_mps; AXES]);
    Some(SensorTrack { covariance, ..*report })
}

/// Whether no variance says more than can be known, and all of them together are positive definite.
pub(crate) fn is_usable(covariance: &Covariance) -> bool {
    let is_believed = |index: usize| {
        let variance = covariance.get(index, index);
        variance == 0.0 || variance >= VARIANCE_MIN[index / AXES]
    };
    (0..STATE_LEN).fold(true, |all, index| all & is_believed(index)) && estimation::is_usable(covariance)
}

/// The report with its covariance, which cannot be used as it is, made usable; `None` if there is nothing to keep of
/// it.
#[cold]
pub(crate) fn repaired(report: &SensorTrack) -> Option<SensorTrack> {
    let mut full = estimation::unpacked(&report.covariance);
    for component in 0..STATE_LEN {
        let variance = full[(component, component)];
        let least = VARIANCE_MIN[component / AXES];
        if variance < least {
            full.row_mut(component).fill(0.0);
            full.column_mut(component).fill(0.0);
            full[(component, component)] = if variance == 0.0 { 1.0 } else { least };
        }
    }
    let covariance = estimation::packed(&estimation::repaired(&full)?);
    Some(SensorTrack { covariance, ..*report })
}

/// The identity of a report as far as it is believed, and what is to be counted of it: an address that belongs to a
/// target far away is not believed, for transponders are misread, and two can have the same.
pub(crate) fn believed_identity(report: &SensorTrack, systems: &SystemTracks) -> (Identity, Option<Counter>) {
    let identity = report.identity;
    let Some(system) = identity
        .unique_number()
        .and_then(|address| systems.with_address(address))
    else {
        return (identity, None);
    };
    let carried_m = systems.get(system).filter.place_at(report.time_of_measurement_ns);
    let apart = |axis: usize| report.position_m[axis] - carried_m[axis];
    if apart(0) * apart(0) + apart(1) * apart(1) <= ADDRESS_REACH_M * ADDRESS_REACH_M {
        return (identity, None);
    }
    (identity.without_unique_number(), Some(Counter::IdentityConflicts))
}
