//! Checks of a report before it is believed.

use messages::{Counter, Identity, STATE_LEN, SensorTrack, TrackState};

use crate::system_tracks::SystemTracks;

/// Largest values that a sensor on this planet can report: metres, metres per second, and the square of a deviation.
const POSITION_MAX_M: f64 = 1e8;
const SPEED_MAX_MPS: f64 = 1e5;
const COVARIANCE_MAX: f64 = 1e14;
/// Farther apart than this, two reports of one address are not of one target, metres.
const ADDRESS_REACH_M: f64 = 10e3;

/// Whether a report can be one of `sources` sources.
pub(crate) fn is_valid(report: &SensorTrack, sources: usize) -> bool {
    // Not a number is within no limit. All are looked at, without a branch for each.
    let within = |values: &[f64], limit: f64| values.iter().fold(true, |all, value| all & (value.abs() <= limit));
    usize::from(report.source) < sources
        && TrackState::from_code(report.state).is_some()
        && within(&report.position_m, POSITION_MAX_M)
        && within(&report.velocity_mps, SPEED_MAX_MPS)
        && within(&report.covariance.upper, COVARIANCE_MAX)
        && (0..STATE_LEN).all(|index| report.covariance.get(index, index) >= 0.0)
        && (0..2).all(|index| report.covariance.get(index, index) > 0.0)
}

/// The report with its covariance, which is not positive definite, made usable; `None` if there is nothing to keep of
/// it.
#[cold]
pub(crate) fn repaired(report: &SensorTrack) -> Option<SensorTrack> {
    let mut full = estimation::unpacked(&report.covariance);
    for component in 0..STATE_LEN {
        if full[(component, component)] == 0.0 {
            full.row_mut(component).fill(0.0);
            full.column_mut(component).fill(0.0);
            full[(component, component)] = 1.0;
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
