//! The errors of the sources over a recording: selection of the estimate for a report.
//!
//! The estimate at the end of a recording is not the best for all of the recording: registration forgets, and the
//! errors of a source may change. The estimate at the time of a report lacks the evidence of later reports. Estimates
//! are therefore kept at each change. The best estimate for a report comes from a while later, with the memory of
//! registration around the report. If the errors change sooner, the last estimate before the change holds: before
//! registration dropped the estimate, or before a shift beyond the estimate's own uncertainty. The first seconds after
//! a report do not count, because a change is noticed late.

use messages::NS_PER_S;
use source_models::place_of;
use source_models::registration::{ERRORS, SourceErrors};

use crate::Engine;
use crate::update::filter_input::FilterInput;

/// Time between two looks at the estimates, nanoseconds.
const LOOK_NS: i64 = 1_000_000_000;
/// Time for registration to notice a change, nanoseconds.
const NOTICED_NS: i64 = 6_000_000_000;
/// Change of an error relative to its standard deviation: threshold to keep an estimate, and threshold for a change of
/// the error itself.
const KEPT: f64 = 0.1;
const CHANGED: f64 = 5.0;
/// Remaining share of the samples below which an estimate counts as dropped.
const DROPPED: f64 = 0.5;

/// Estimates of the errors of all sources, by change.
#[derive(Debug, Default)]
pub(super) struct ErrorsOverTime {
    /// By source, in the order of time.
    of_sources: Vec<Vec<Estimate>>,
    /// Time of the next look.
    next_ns: Option<i64>,
}

#[derive(Clone, Copy, Debug)]
struct Estimate {
    time_ns: i64,
    errors: SourceErrors,
    /// Index of the valid estimate for reports of this time.
    best: usize,
}

impl ErrorsOverTime {
    /// Looks at the estimates of an engine.
    pub(super) fn look(&mut self, engine: &Engine) {
        let now_ns = engine.now_ns();
        if now_ns == i64::MIN || self.next_ns.is_some_and(|next_ns| now_ns < next_ns) {
            return;
        }
        self.next_ns = Some(now_ns.saturating_add(LOOK_NS));
        let sources = engine.settings.sources.len();
        self.of_sources.resize(sources, Vec::new());
        for (source, estimates) in (0..).zip(&mut self.of_sources) {
            let errors = *engine.tracks.sources.errors(source);
            if estimates.last().is_none_or(|last| is_news(&last.errors, &errors)) {
                estimates.push(Estimate {
                    time_ns: now_ns,
                    errors,
                    best: 0,
                });
            }
        }
    }

    /// Chooses the best estimate for each time, once all are there; registration remembers for `memory_s`.
    pub(super) fn settle(&mut self, memory_s: f64) {
        let horizon_ns = (memory_s * NS_PER_S) as i64;
        for estimates in &mut self.of_sources {
            for place in 0..estimates.len() {
                let first = estimates[place];
                let until_ns = first.time_ns.saturating_add(horizon_ns);
                let later = estimates[place..].windows(2).take_while(|pair| {
                    pair[1].time_ns <= until_ns
                        && !is_dropped(&pair[0].errors, &pair[1].errors)
                        && !is_changed(&first.errors, &pair[1].errors)
                });
                estimates[place].best = place + later.count();
            }
        }
    }

    /// Displacement of the report behind an input by the errors of its source, metres; `None` without an estimate.
    pub(super) fn shift_m(&self, engine: &Engine, input: &FilterInput) -> Option<[f64; 3]> {
        let estimates = self.of_sources.get(usize::from(input.source))?;
        let noticed_ns = input.time_ns.saturating_add(NOTICED_NS);
        let begun = estimates.partition_point(|estimate| estimate.time_ns <= noticed_ns);
        let best = estimates.get(begun.saturating_sub(1))?.best;
        let place_m = place_of(&engine.settings.sources[usize::from(input.source)]);
        Some(
            estimates[best]
                .errors
                .shift(input.reported_m, input.velocity_mps, place_m),
        )
    }
}

/// Whether an estimate differs from the last kept estimate.
fn is_news(last: &SourceErrors, now: &SourceErrors) -> bool {
    let moved = |row: usize| (now.errors[row] - last.errors[row]).powi(2) > KEPT * KEPT * now.variances[row];
    now.removed != last.removed || is_dropped(last, now) || (0..ERRORS).any(moved)
}

/// Whether registration has dropped the estimate between both.
fn is_dropped(before: &SourceErrors, after: &SourceErrors) -> bool {
    after.samples < DROPPED * before.samples
}

/// Whether the errors themselves have changed.
fn is_changed(before: &SourceErrors, after: &SourceErrors) -> bool {
    let moved =
        |row: usize| (after.errors[row] - before.errors[row]).powi(2) > CHANGED * CHANGED * before.variances[row];
    before.removed != [false; ERRORS] && (0..ERRORS).any(moved)
}
