//! Measurements and times of one track, and its smoothed states.

use std::ops::Range;

use estimation::{Plane, Vertical};

use super::knowledge::Knowledge;
use super::plane::{PlaneBase, PlaneSmoother};
use super::stretch::Stretch;
use super::vertical::{VerticalBase, VerticalSmoother};
use crate::update::filter_input::FilterInput;

/// Most inputs searched for an earlier input to replace: no more are kept for late reports.
const REPLACED_MAX: usize = 256;

/// Inputs of a track's filter in the order of arrival, and the times of the track's states.
#[derive(Debug, Default)]
pub(super) struct Trajectory {
    pub(super) inputs: Vec<FilterInput>,
    pub(super) times_ns: Vec<i64>,
}

/// A smoothed state.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmoothedState {
    pub(super) time_ns: i64,
    pub(super) plane: Plane,
    /// Probabilities of the models of the plane, in the order of `MotionMode`.
    pub(super) plane_modes: [f32; 5],
    /// Rate of turn, clockwise from above, and its standard deviation, rad/s; 0 for a target that hardly moves.
    pub(super) turn_rate: [f64; 2],
    /// Vertical state with the probabilities of its models; `None` before the first measured height.
    pub(super) vertical: Option<(Vertical, [f32; 3])>,
}

impl SmoothedState {
    fn is_finite(&self) -> bool {
        let Plane { mean, covariance } = &self.plane;
        let vertical = self.vertical.map(|(vertical, _)| vertical).unwrap_or_default();
        let values = mean.iter().chain(covariance);
        let values = values.chain(&vertical.mean).chain(&vertical.covariance);
        values.copied().all(f64::is_finite)
    }
}

/// State of the filters at a moment, as the start of a later stretch.
#[derive(Clone, Debug)]
pub(super) struct Base {
    pub(super) time_ns: i64,
    plane: PlaneBase,
    vertical: Option<VerticalBase>,
}

impl Trajectory {
    /// Takes the next input.
    pub(super) fn take(&mut self, input: &FilterInput) {
        let same = self.inputs.iter_mut().rev().filter(|_| input.replaces);
        match same.take(REPLACED_MAX).find(|other| input.is_of_same_report(other)) {
            Some(place) => *place = *input,
            None => self.inputs.push(*input),
        }
    }

    /// Smoothed states at the wanted times, if measurements precede or follow.
    pub(super) fn smooth(&self, known: &impl Knowledge) -> Vec<SmoothedState> {
        let mut times_ns = self.times_ns.clone();
        times_ns.sort_unstable();
        times_ns.dedup();
        let mut states = Vec::with_capacity(times_ns.len());
        for inputs in self.stretches() {
            let begin_ns = self.inputs[inputs.start].time_ns;
            let end_ns = self.inputs.get(inputs.end).map_or(i64::MAX, |next| next.time_ns);
            let wanted = times_ns.partition_point(|time_ns| *time_ns < begin_ns)
                ..times_ns.partition_point(|time_ns| *time_ns < end_ns);
            let mut inputs = self.inputs[inputs].to_vec();
            inputs.sort_by_key(|input| input.time_ns);
            smooth_stretch(known, (&inputs, None), (&times_ns[wanted], i64::MIN), &mut states);
        }
        // A filter may restart with a report older than the previous report.
        states.sort_by_key(|state: &SmoothedState| state.time_ns);
        states
    }

    /// The inputs from each beginning to the next.
    pub(super) fn stretches(&self) -> impl Iterator<Item = Range<usize>> {
        let begins = (0..self.inputs.len()).filter(|place| *place == 0 || self.inputs[*place].begins);
        let ends = (1..=self.inputs.len()).filter(|place| self.inputs.get(*place).is_none_or(|next| next.begins));
        begins.zip(ends).map(|(begin, end)| begin..end)
    }
}

/// Smooths a stretch: inputs in the order of time, from a base or else from the first input. Adds the states at the
/// wanted times. Returns the base at the last moment up to `done_ns`, if there is one.
pub(super) fn smooth_stretch(
    known: &impl Knowledge,
    (inputs, base): (&[FilterInput], Option<&Base>),
    (wanted_ns, done_ns): (&[i64], i64),
    states: &mut Vec<SmoothedState>,
) -> Option<Base> {
    if wanted_ns.is_empty() {
        return None;
    }
    let stretch = Stretch::new(known, inputs, wanted_ns, base.map(|base| base.time_ns));
    let done = stretch.moments_until(done_ns);
    let (plane, next_plane) = PlaneSmoother::smooth(known, &stretch, base.map(|base| &base.plane), done);
    let before = (base.and_then(|base| base.vertical.as_ref()), done);
    let (vertical, next_vertical) = VerticalSmoother::smooth(known, &stretch, &plane, before);
    for (place, time_ns) in wanted_ns.iter().enumerate() {
        let (Some(plane), Some(vertical)) = (plane.wanted(&stretch, place), vertical.get(place)) else {
            continue;
        };
        let state = SmoothedState {
            time_ns: *time_ns,
            plane: plane.state,
            plane_modes: plane.modes,
            turn_rate: plane.turn_rate,
            vertical: *vertical,
        };
        // A state with non-finite values stays as fused.
        if state.is_finite() {
            states.push(state);
        }
    }
    Some(Base {
        time_ns: stretch.moments[done.checked_sub(1)?].time_ns,
        plane: next_plane?,
        vertical: next_vertical,
    })
}
