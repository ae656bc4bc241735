//! Contributions of sensor tracks, as candidates for a rule.

use messages::{SensorTrack, TrackState, sensor_track_bits};

use crate::rules::Candidate;
use crate::settings::Settings;
use crate::state::State;

/// Contribution of the `latest` report of a sensor track, moved to `state` at `reference_ns`, without earlier reports.
#[inline]
pub fn candidate_of(settings: &Settings, latest: &SensorTrack, state: State, reference_ns: i64) -> Candidate {
    let (source, rule) = (&settings.sources[usize::from(latest.source)], &settings.rule);
    let age_ns = (reference_ns - latest.time_of_measurement_ns).max(0);
    let grown_m2 = || state.horizontal_trace_m2() - State::of_report(latest).horizontal_trace_m2();
    Candidate {
        source: latest.source,
        priority: source.priority,
        age_ns,
        period_ns: source.period_ns,
        overdue: age_ns as f64 > rule.overdue_periods * source.period_ns as f64,
        life: TrackState::from_code(latest.state).unwrap_or(TrackState::Tentative),
        trace_m2: latest
            .has(sensor_track_bits::TRACE)
            .then(|| latest.trace_m2 + grown_m2()),
        state,
        ..Candidate::default()
    }
}

/// Gives each candidate its accuracy value.
#[inline]
pub fn value(candidates: &mut [Candidate]) {
    let three_axes = candidates.iter().all(|candidate| candidate.state.has_height);
    for candidate in candidates {
        candidate.lambda = candidate.lambda_over(three_axes);
    }
}
