//! Checks of a report before use.

use estimation::Gaussian;
use fusion_rules::gross::without_biases;
use messages::{AXES, Counter, Covariance, Identity, NS_PER_S, STATE_LEN, SensorTrack, TrackState};

use crate::settings::{ReportLimits, SourceSettings};
use crate::tables::system_tracks::SystemTracks;
use crate::update::filter::TargetFilter;

/// Smallest accepted variances, of position (m²) and velocity (m²/s²): no knowledge is exact to a millimetre and a
/// tenth of a millimetre per second.
const VARIANCE_MIN: [f64; 2] = [1e-6, 1e-8];
/// Largest distance between two reports of the same address for the same target, metres.
const ADDRESS_REACH_M: f64 = 10e3;
/// Silence beyond which that distance no longer grows, seconds.
const ADDRESS_SILENCE_S: f64 = 900.0;

/// Whether a point lies within `limit` of the origin of its coordinates.
fn is_in_reach([east, north]: [f64; 2], limit: f64) -> bool {
    east * east + north * north <= limit * limit
}

/// The covariance of each source's latest sound report: many sources always state the same covariance.
#[derive(Debug)]
pub(crate) struct SoundCovariances(Vec<Option<Covariance>>);

impl SoundCovariances {
    pub(crate) fn new(sources: usize) -> Self {
        Self(vec![None; sources])
    }

    /// Whether the covariance of a report equals the covariance of its source's latest sound report.
    #[inline]
    pub(crate) fn have(&self, report: &SensorTrack) -> bool {
        let Some(Some(sound)) = self.0.get(usize::from(report.source)) else {
            return false;
        };
        // The bits that differ, without a branch for each element.
        let pairs = sound.upper.iter().zip(&report.covariance.upper);
        pairs.fold(0, |all, (one, other)| all | (one.to_bits() ^ other.to_bits())) == 0
    }

    /// Returns whether the covariance of a report [is usable](is_usable), and stores the covariance. After a possible
    /// rotation by a correction, the earlier check of the covariance does not count.
    #[inline]
    pub(crate) fn judge(&mut self, report: &SensorTrack, is_as_given: bool, is_known: bool) -> bool {
        if is_as_given && is_known {
            return true;
        }
        let is_usable = is_usable(&report.covariance);
        if is_usable && is_as_given {
            self.remember(report);
        }
        is_usable
    }

    /// Stores the covariance of a sound report.
    fn remember(&mut self, report: &SensorTrack) {
        self.0[usize::from(report.source)] = Some(report.covariance);
    }
}

/// Returns whether a report belongs to these sources, no order excludes its source, and its source's limits hold. The
/// covariance may already be checked.
#[inline]
pub(crate) fn is_valid(report: &SensorTrack, sources: &[SourceSettings], has_sound_covariance: bool) -> bool {
    let Some(source) = sources.get(usize::from(report.source)) else {
        return false;
    };
    !source.is_out
        && is_near(report, &source.limits)
        && is_slow_enough(report, &source.limits)
        && TrackState::from_code(report.state).is_some()
        && report.has_possible_state()
        && (has_sound_covariance || report.covariance.is_possible())
}

/// Whether the report lies within its sensor's range.
fn is_near(report: &SensorTrack, limits: &ReportLimits) -> bool {
    let ([x, y, _], [x0, y0]) = (report.position_m, limits.place_m);
    is_in_reach([x - x0, y - y0], limits.range_m)
}

/// Whether the report is no faster than the targets.
fn is_slow_enough(report: &SensorTrack, limits: &ReportLimits) -> bool {
    let [vx, vy, _] = report.velocity_mps;
    is_in_reach([vx, vy], limits.speed_mps)
}

/// Whether the report's numbers are possible on this planet.
fn is_possible(report: &SensorTrack) -> bool {
    report.has_possible_state() && report.covariance.is_possible()
}

/// Counter of an invalid report. A limit of the configuration is named only without any other fault.
#[cold]
pub(crate) fn rejection(report: &SensorTrack, sources: &[SourceSettings]) -> Counter {
    match sources.get(usize::from(report.source)) {
        Some(source) if source.is_out => Counter::RejectedByOrder,
        Some(source) if is_possible(report) && TrackState::from_code(report.state).is_some() => {
            match is_near(report, &source.limits) {
                true => Counter::RejectedTooFast,
                false => Counter::RejectedTooFar,
            }
        }
        _ => Counter::RejectedInvalid,
    }
}

/// Returns the report without the configured biases of its source, at `now_ns`; `None` without configured biases.
#[inline]
pub(crate) fn corrected(report: &SensorTrack, sources: &[SourceSettings], now_ns: i64) -> Option<SensorTrack> {
    let source = sources.get(usize::from(report.source))?;
    let known = source.correction.as_ref()?;
    Some(without_biases(report, (known, source.place_m), now_ns))
}

/// Returns an incomplete report, completed first with known properties of its source, and then with the substitutes for
/// unknown values (`messages`, module `unknown`). `None` for complete reports.
#[inline]
pub(crate) fn completed(report: &SensorTrack, sources: &[SourceSettings]) -> Option<SensorTrack> {
    if !report.is_incomplete() {
        return None;
    }
    Some(completed_from(report, sources.get(usize::from(report.source))?))
}

/// The completed report of a source. In place of a whole covariance, a source may give its trace: positions with equal
/// uncertainty on each axis, velocities as from two such positions a period apart. A position without either has the
/// configured accuracy.
#[inline(never)]
fn completed_from(report: &SensorTrack, source: &SourceSettings) -> SensorTrack {
    if report.gives_trace() {
        let sigma_m = (0.5 * report.trace_m2).sqrt();
        let sigma_mps = std::f64::consts::SQRT_2 * sigma_m / (source.period_ns as f64 / NS_PER_S);
        let covariance = Covariance::diagonal([sigma_m; AXES], [sigma_mps; AXES]);
        return SensorTrack { covariance, ..*report }.completed([None; 2]);
    }
    let configured_m2 = source
        .accuracy
        .base
        .configured_m(report.position_m)
        .map(|sigma_m| sigma_m * sigma_m);
    report.completed([configured_m2; 2])
}

/// Returns whether all variances are plausible, and the covariance is positive definite.
pub(crate) fn is_usable(covariance: &Covariance) -> bool {
    let is_believed = |index: usize| covariance.get(index, index) >= VARIANCE_MIN[index / AXES];
    (0..STATE_LEN).fold(true, |all, index| all & is_believed(index))
        && (covariance.is_diagonal() || estimation::is_usable(covariance))
}

/// Returns the report with a repaired covariance; `None` if unrepairable.
#[cold]
pub(crate) fn repaired(report: &SensorTrack) -> Option<SensorTrack> {
    let mut full = estimation::unpacked(&report.covariance);
    for component in 0..STATE_LEN {
        let least = VARIANCE_MIN[component / AXES];
        if full[(component, component)] < least {
            full.row_mut(component).fill(0.0);
            full.column_mut(component).fill(0.0);
            full[(component, component)] = least;
        }
    }
    let covariance = estimation::packed(&estimation::repaired(&full)?);
    Some(SensorTrack { covariance, ..*report })
}

/// Largest distance of a target after a long silence from its place in straight flight, metres: an immediate reversal
/// is possible.
#[cold]
fn way_m(filter: &TargetFilter, time_ns: i64) -> f64 {
    let Gaussian { mean, covariance } = &filter.estimate;
    // The velocity is unknown for a target with a single report without a velocity.
    let sigma_mps = (covariance.get(3, 3) + covariance.get(4, 4)).sqrt();
    let speed = mean[3].hypot(mean[4]) + sigma_mps;
    let seconds = (time_ns - filter.time_ns).max(0) as f64 / NS_PER_S;
    2.0 * speed * seconds.min(ADDRESS_SILENCE_S)
}

/// Returns the accepted part of a report's identity, and the counter to increase. An address of a target far away is
/// not accepted, because transponders are misread, and two transponders can have the same address.
pub(crate) fn believed_identity(report: &SensorTrack, systems: &SystemTracks) -> (Identity, Option<Counter>) {
    let identity = report.identity;
    let Some(system) = identity
        .unique_number()
        .and_then(|address| systems.with_address(address))
    else {
        return (identity, None);
    };
    let entry = systems.get(system);
    let carried_m = entry.filter.place_at(report.time_of_measurement_ns);
    let apart = |axis: usize| report.position_m[axis] - carried_m[axis];
    let mut reach_m = ADDRESS_REACH_M;
    if entry.life == TrackState::Suspended || entry.rhythm.is_slow() {
        reach_m += way_m(&entry.filter, report.time_of_measurement_ns);
    }
    if apart(0) * apart(0) + apart(1) * apart(1) <= reach_m * reach_m {
        return (identity, None);
    }
    (identity.without_unique_number(), Some(Counter::IdentityConflicts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_covariance_that_is_equal_in_all_elements_is_known() {
        let mut sound = SoundCovariances::new(2);
        let report = SensorTrack {
            source: 1,
            covariance: Covariance::diagonal([10.0, 20.0, 30.0], [1.0; 3]),
            ..SensorTrack::default()
        };
        assert!(!sound.have(&report));
        sound.remember(&report);
        assert!(sound.have(&report));
        for element in 0..report.covariance.upper.len() {
            let mut other = report;
            other.covariance.upper[element] += 1.0;
            assert!(!sound.have(&other), "{element}");
        }
        let of_others = [0, 9].map(|source| SensorTrack { source, ..report });
        assert_eq!(of_others.map(|report| sound.have(&report)), [false; 2]);
    }
}
