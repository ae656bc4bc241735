//! Smoothed states while fusion runs: states some seconds old, with the measurements since then.
//!
//! A [`LagSmoother`] takes the inputs of all filters and the published states, in the order of emission by fusion. A
//! state waits until its track has a state a *lag* later. Then the smoother of [`super`] runs over the inputs since the
//! last smoothed state, and the waiting states up to the lag leave with smoothed kinematics. The filters at the last of
//! these states are kept as the start of the next run. The result equals a run of that smoother over the whole
//! trajectory so far, apart from the speeds and courses for the models. Before the start of a run, speeds and courses
//! stay unchanged.
//!
//! The errors of sources and the motion of targets are the assumptions of fusion at each time. Later inputs do not
//! change states after output: a measurement later than the lag is not used.
//!
//! The result depends only on the order of inputs and states, so live data and files give the same states. Work and
//! memory are bounded: at most two states a second of a track are smoothed, and the states of a track with very many
//! inputs wait less.

use std::collections::{BTreeMap, VecDeque};

use messages::{SystemTrack, TrackState};

use super::knowledge::AsAssumed;
use super::trajectory::{Base, SmoothedState, smooth_stretch};
use super::with_kinematics;
use crate::update::filter_input::{Assumed, FilterInput};

/// Least time between two states of a track, nanoseconds.
const SPACING_NS: i64 = 500_000_000;
/// A run smooths the states of at least this part of the lag together.
const TOGETHER: i64 = 4;
/// Most waiting inputs of a track.
const INPUTS_MAX: usize = 512;

/// Smoother of all system tracks, some seconds behind.
#[derive(Debug)]
pub struct LagSmoother {
    lag_ns: i64,
    /// By number.
    tracks: BTreeMap<u32, LaggingTrack>,
}

#[derive(Debug, Default)]
struct LaggingTrack {
    /// The filters after the last smoothed state; `None` for a stretch from the first input.
    base: Option<Base>,
    /// Inputs since then, in the order of time.
    inputs: Vec<FilterInput>,
    /// Waiting states, and the latest state, waiting or not.
    waiting: VecDeque<SystemTrack>,
    latest: Option<(i64, u8)>,
    assumed: Option<Assumed>,
}

impl LagSmoother {
    /// Creates a smoother with this lag, nanoseconds.
    pub fn new(lag_ns: i64) -> Self {
        Self {
            lag_ns,
            tracks: BTreeMap::new(),
        }
    }

    /// Takes the next input of a filter. Finished states go to `out`.
    pub fn input(&mut self, input: &FilterInput, out: impl FnMut(&SystemTrack)) {
        let track = self.tracks.entry(input.system_track).or_default();
        track.assumed = input.assumed.or(track.assumed);
        if input.begins {
            // The filter begins without the measurements so far.
            track.smooth(i64::MAX, out);
            track.base = None;
            track.inputs.clear();
            track.inputs.push(*input);
            return;
        }
        track.add(input);
        if track.inputs.len() > INPUTS_MAX {
            track.smooth(track.inputs[INPUTS_MAX / 2].time_ns, out);
            if track.inputs.len() > INPUTS_MAX {
                // No state waits among these inputs.
                track.inputs.remove(0);
            }
        }
    }

    /// Takes the next state of a system track. Finished states go to `out`.
    pub fn state(&mut self, state: &SystemTrack, out: impl FnMut(&SystemTrack)) {
        let track = self.tracks.entry(state.track_number).or_default();
        let time_ns = state.reference_time_ns;
        let is_due = track
            .latest
            .is_none_or(|(latest_ns, life)| time_ns - latest_ns >= SPACING_NS || life != state.state);
        if is_due {
            track.waiting.push_back(*state);
            track.latest = Some((time_ns, state.state));
        }
        // A suspended track has no further states, and its filter restarts on resumption.
        if matches!(
            TrackState::from_code(state.state),
            Some(TrackState::Suspended | TrackState::Terminated)
        ) {
            track.smooth(i64::MAX, out);
            self.tracks.remove(&state.track_number);
            return;
        }
        let oldest_ns = track.waiting.front().map(|oldest| oldest.reference_time_ns);
        if oldest_ns.is_some_and(|oldest_ns| time_ns - oldest_ns >= self.lag_ns + self.lag_ns / TOGETHER) {
            track.smooth(time_ns - self.lag_ns, out);
        }
    }

    /// Ends the input: all waiting states go to `out`.
    pub fn finish(&mut self, mut out: impl FnMut(&SystemTrack)) {
        for track in self.tracks.values_mut() {
            track.smooth(i64::MAX, &mut out);
        }
        self.tracks.clear();
    }
}

impl LaggingTrack {
    /// Inserts an input at its place in time. An input from before the base is too late.
    fn add(&mut self, input: &FilterInput) {
        if self.base.as_ref().is_some_and(|base| input.time_ns <= base.time_ns) {
            return;
        }
        let is_same = |other: &&mut FilterInput| input.is_of_same_report(other);
        if let Some(same) = self.inputs.iter_mut().find(is_same).filter(|_| input.replaces) {
            *same = *input;
            return;
        }
        let place = self.inputs.partition_point(|other| other.time_ns <= input.time_ns);
        // The trajectory is empty before the first report of the filter.
        if place > 0 || self.base.is_some() {
            self.inputs.insert(place, *input);
        }
    }

    /// Smooths and emits the waiting states up to `until_ns`.
    fn smooth(&mut self, until_ns: i64, mut out: impl FnMut(&SystemTrack)) {
        let leaving = self
            .waiting
            .iter()
            .rposition(|state| state.reference_time_ns <= until_ns);
        let Some(leaving) = leaving.map(|last| last + 1) else {
            return;
        };
        let begin_ns = match (&self.base, self.inputs.first()) {
            (Some(base), _) => base.time_ns + 1,
            (None, Some(first)) => first.time_ns,
            (None, None) => i64::MAX,
        };
        let times = self.waiting.iter().map(|state| state.reference_time_ns);
        let mut wanted_ns: Vec<i64> = times.filter(|time_ns| *time_ns >= begin_ns).collect();
        wanted_ns.sort_unstable();
        wanted_ns.dedup();
        let mut smoothed = Vec::new();
        if let Some(assumed) = self.assumed {
            let known = AsAssumed(assumed);
            let last_ns = self.waiting.range(..leaving).map(|state| state.reference_time_ns).max();
            let done_ns = last_ns.unwrap_or(i64::MIN);
            let from = (&self.inputs[..], self.base.as_ref());
            if let Some(base) = smooth_stretch(&known, from, (&wanted_ns, done_ns), &mut smoothed) {
                self.inputs.retain(|input| input.time_ns > base.time_ns);
                self.base = Some(base);
            }
        }
        for state in self.waiting.drain(..leaving) {
            let place =
                smoothed.binary_search_by_key(&state.reference_time_ns, |smoothed: &SmoothedState| smoothed.time_ns);
            match (place, self.assumed) {
                (Ok(place), Some(assumed)) => {
                    out(&with_kinematics(&state, &smoothed[place], assumed.unseen));
                }
                // Without a measurement of its own, the state stays unchanged.
                _ => out(&state),
            }
        }
    }
}
