//! Comparison of a replay's system tracks with the recorded system tracks, bit for bit.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::ops::Range;

use formats::rows::Utc;
use messages::SystemTrack;
use messages::layout::Sample as _;

/// Result so far.
#[derive(Debug, Default)]
pub(crate) struct Verification {
    /// By start-up number of fusion.
    runs: BTreeMap<u64, RunStates>,
    /// States compared.
    pub(crate) states: u64,
    pub(crate) differences: u64,
    pub(crate) first: Option<Difference>,
    /// Recorded states without a possible verdict.
    pub(crate) not_verified: u64,
    /// States that the replay gives and the recording lacks: lost by the recorder, or never sent by a killed fusion.
    pub(crate) not_recorded: u64,
    /// Byte ranges of a state that the recording lacks, from a build with another layout.
    missing: Vec<Range<usize>>,
}

/// States of a run of fusion, by sequence number.
#[derive(Debug, Default)]
struct RunStates {
    given: VecDeque<SystemTrack>,
    recorded: VecDeque<SystemTrack>,
    /// Numbers of states that are not given, since fusion's state is unknown.
    unknown: VecDeque<Range<u64>>,
    /// Number of the state that is given next.
    next: u64,
}

/// Difference of a state that was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Difference {
    time_ns: i64,
    track_number: u32,
    /// First field that differs; `None` if the replay does not give the state at all.
    field: Option<String>,
}

impl Verification {
    /// Leaves these byte ranges of all states out of the comparison.
    pub(crate) fn pass_over(&mut self, missing: &[Range<usize>]) {
        self.missing = missing.to_vec();
    }

    /// From the state with this number on, the run is given.
    pub(crate) fn begin(&mut self, epoch: u64, sequence: u64) {
        let run = self.runs.entry(epoch).or_insert_with(RunStates::unknown);
        if let Some(unknown) = run.unknown.back_mut().filter(|unknown| unknown.end == u64::MAX) {
            unknown.end = sequence;
        }
        run.next = sequence;
    }

    /// End of a run: the run's further states are not given, unless the run begins again. States of a later run may
    /// have been recorded by then.
    pub(crate) fn break_off(&mut self, epoch: u64) {
        if let Some(run) = self.runs.get_mut(&epoch) {
            run.unknown.push_back(run.next..u64::MAX);
        }
    }

    pub(crate) fn give(&mut self, state: &SystemTrack) {
        let run = self.runs.entry(state.epoch).or_insert_with(RunStates::unknown);
        run.next = state.sequence + 1;
        run.given.push_back(*state);
        self.settle(state.epoch);
    }

    pub(crate) fn record(&mut self, state: &SystemTrack) {
        let run = self.runs.entry(state.epoch).or_insert_with(RunStates::unknown);
        run.recorded.push_back(*state);
        self.settle(state.epoch);
    }

    /// Compares as far as both sides are there.
    fn settle(&mut self, epoch: u64) {
        let Some(run) = self.runs.get_mut(&epoch) else { return };
        loop {
            self.not_verified += run.pass_over_unknown();
            let (Some(&given), Some(&recorded)) = (run.given.front(), run.recorded.front()) else {
                break;
            };
            if given.sequence <= recorded.sequence {
                run.given.pop_front();
            }
            if given.sequence < recorded.sequence {
                self.not_recorded += 1;
                continue;
            }
            run.recorded.pop_front();
            self.states += 1;
            let field = match given.sequence == recorded.sequence {
                true => differing_field(&given, &recorded, &self.missing),
                false => Some(String::new()),
            };
            if let Some(field) = field {
                self.differences += 1;
                self.first.get_or_insert_with(|| Difference::of(&recorded, Some(field)));
            }
        }
    }

    /// Nothing follows.
    pub(crate) fn finish(&mut self) {
        for mut run in std::mem::take(&mut self.runs).into_values() {
            self.not_recorded += run.given.len() as u64;
            let is_known = |state: &SystemTrack| !run.unknown.iter().any(|unknown| unknown.contains(&state.sequence));
            let before = run.recorded.len();
            run.recorded.retain(is_known);
            self.not_verified += (before - run.recorded.len()) as u64;
            self.differences += run.recorded.len() as u64;
            if let Some(recorded) = run.recorded.front() {
                self.first.get_or_insert_with(|| Difference::of(recorded, None));
            }
        }
    }
}

impl RunStates {
    /// A run of which nothing is known yet.
    fn unknown() -> Self {
        let mut run = Self::default();
        run.unknown.push_back(0..u64::MAX);
        run
    }

    /// Forgets the next recorded states without a given counterpart; returns the number.
    fn pass_over_unknown(&mut self) -> u64 {
        let mut count = 0;
        while let (Some(recorded), Some(unknown)) = (self.recorded.front(), self.unknown.front()) {
            if recorded.sequence >= unknown.end {
                self.unknown.pop_front();
            } else if unknown.contains(&recorded.sequence) && unknown.end != u64::MAX {
                self.recorded.pop_front();
                count += 1;
            } else {
                break;
            }
        }
        count
    }
}

impl Difference {
    fn of(recorded: &SystemTrack, field: Option<String>) -> Self {
        Self {
            time_ns: recorded.reference_time_ns,
            track_number: recorded.track_number,
            field: field.filter(|field| !field.is_empty()),
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at {}, track {}: ", Utc(self.time_ns), self.track_number)?;
        match &self.field {
            Some(field) => write!(f, "{field} differs"),
            None => write!(f, "the replay does not give this state"),
        }
    }
}

/// Returns the first field in which two states differ, apart from the stamps of processing and from the byte ranges
/// `missing`; `None` if all others are equal.
fn differing_field(given: &SystemTrack, recorded: &SystemTrack, missing: &[Range<usize>]) -> Option<String> {
    let [given, recorded] = [given, recorded].map(|state| {
        let mut state = *state;
        (state.stages.taken_ns, state.stages.fused_ns, state.held_us) = (0, 0, 0);
        state
    });
    let octets = |state: &SystemTrack| {
        let mut octets = SystemTrack::octets(std::slice::from_ref(state)).to_vec();
        for range in missing {
            octets[range.clone()].fill(0);
        }
        octets
    };
    let (given, recorded) = (octets(&given), octets(&recorded));
    let offset = given.iter().zip(&recorded).position(|(one, other)| one != other)?;
    Some(SystemTrack::LAYOUT.name_at(offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(epoch: u64, sequence: u64) -> SystemTrack {
        SystemTrack {
            epoch,
            sequence,
            track_number: 7,
            ..SystemTrack::default()
        }
    }

    #[test]
    fn stamps_of_processing_may_differ_and_nothing_else() {
        let mut verification = Verification::default();
        verification.begin(3, 0);
        let mut recorded = state(3, 0);
        (recorded.stages.taken_ns, recorded.stages.fused_ns, recorded.held_us) = (5, 6, 7);
        verification.record(&recorded);
        verification.give(&state(3, 0));
        assert_eq!((verification.states, verification.differences), (1, 0));
        let mut recorded = state(3, 1);
        recorded.contributions[2].weight = 0.25;
        verification.give(&state(3, 1));
        verification.record(&recorded);
        let first = verification.first.clone().unwrap().to_string();
        assert_eq!(
            first,
            "at 1970-01-01T00:00:00Z, track 7: contributions[2].weight differs"
        );
        verification.finish();
        assert_eq!(
            (
                verification.differences,
                verification.not_verified,
                verification.not_recorded
            ),
            (1, 0, 0)
        );
    }

    #[test]
    fn a_run_that_is_known_again_is_verified_from_there_on() {
        let mut verification = Verification::default();
        verification.begin(3, 10);
        (10..12).for_each(|sequence| verification.give(&state(3, sequence)));
        (8..20).for_each(|sequence| verification.record(&state(3, sequence)));
        verification.break_off(3);
        verification.begin(3, 15);
        (15..19).for_each(|sequence| verification.give(&state(3, sequence)));
        verification.break_off(3);
        verification.finish();
        let Verification {
            states,
            not_verified,
            differences,
            not_recorded,
            ..
        } = verification;
        // Two before the first begin, three between 12 and 15, a single state at the end.
        assert_eq!((states, not_verified, differences, not_recorded), (6, 6, 0, 0));
    }

    #[test]
    fn a_run_ends_that_breaks_though_another_one_has_been_recorded_by_then() {
        let mut verification = Verification::default();
        verification.begin(3, 0);
        verification.give(&state(3, 0));
        (0..3).for_each(|sequence| verification.record(&state(3, sequence)));
        (5..9).for_each(|sequence| verification.record(&state(4, sequence)));
        verification.break_off(3);
        verification.begin(4, 7);
        (7..9).for_each(|sequence| verification.give(&state(4, sequence)));
        verification.finish();
        assert_eq!((verification.states, verification.not_verified), (3, 4));
        assert_eq!((verification.differences, verification.not_recorded), (0, 0));
    }

    #[test]
    fn states_on_one_side_only_are_told_apart() {
        let mut verification = Verification::default();
        verification.begin(3, 0);
        (0..3).for_each(|sequence| verification.give(&state(3, sequence)));
        (1..4).for_each(|sequence| verification.record(&state(3, sequence)));
        verification.break_off(3);
        // Of a fusion without a recorded begin.
        verification.record(&state(2, 0));
        verification.begin(4, 0);
        verification.record(&state(4, 0));
        verification.finish();
        assert_eq!((verification.states, verification.not_recorded), (2, 1));
        assert_eq!((verification.not_verified, verification.differences), (2, 1));
        assert!(verification.first.unwrap().to_string().contains("does not give"));
    }
}
