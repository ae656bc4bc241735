//! Smoothed states some seconds behind, against those of the whole trajectory so far.

use messages::Decision;

use super::tests::{Errors, errors, reports, settings};
use super::*;
use crate::smoothing::knowledge::AsAssumed;
use crate::{FilterInput, Settings, Sink};

/// What the engine emits, in its order.
#[derive(Clone, Copy, Debug)]
// Few of them, and all of them at once.
#[allow(clippy::large_enum_variant)]
enum Emitted {
    Input(FilterInput),
    State(SystemTrack),
}

#[derive(Default)]
struct Tape(Vec<Emitted>);

impl Sink for Tape {
    fn track(&mut self, track: &SystemTrack) {
        self.0.push(Emitted::State(*track));
    }

    fn decision(&mut self, _: &Decision) {}

    fn follows_inputs(&self) -> bool {
        true
    }

    fn input(&mut self, input: &FilterInput) {
        self.0.push(Emitted::Input(*input));
    }
}

fn emitted(settings: Settings, seed: u64) -> Vec<Emitted> {
    let sources = settings.sources.len() as u16;
    let mut engine = Engine::new(settings).unwrap();
    let mut tape = Tape::default();
    for report in reports(seed, (sources, 1), |_, _| 0.0) {
        engine.take(&report, &mut tape);
    }
    tape.0
}

fn every_second() -> Settings {
    let mut settings = settings();
    settings.refresh_s = Some(settings::Seconds::of(1.0));
    settings
}

/// The states that leave, each with the number of events before it.
fn lagging(events: &[Emitted], lag_s: f64) -> Vec<(usize, SystemTrack)> {
    let mut smoother = LagSmoother::new((lag_s * 1e9) as i64);
    let mut left = Vec::new();
    for (place, event) in (1..).zip(events) {
        let out = |state: &SystemTrack| left.push((place, *state));
        match event {
            Emitted::Input(input) => smoother.input(input, out),
            Emitted::State(state) => smoother.state(state, out),
        }
    }
    smoother.finish(|state| left.push((events.len(), *state)));
    left
}

/// The state of the smoother over all that a track had by then.
fn of_the_whole(events: &[Emitted], wanted: &SystemTrack) -> Option<SystemTrack> {
    let mut whole = Trajectory::default();
    let mut assumed = None;
    for event in events {
        match event {
            Emitted::Input(input) if input.system_track == wanted.track_number => {
                assumed = input.assumed.or(assumed);
                whole.take(input);
            }
            Emitted::State(state) if state.track_number == wanted.track_number => {
                whole.times_ns.push(state.reference_time_ns);
            }
            _ => {}
        }
    }
    let assumed = assumed?;
    let states = whole.smooth(&AsAssumed(assumed));
    let at = |smoothed: &&SmoothedState| smoothed.time_ns == wanted.reference_time_ns;
    Some(with_kinematics(wanted, states.iter().find(at)?, assumed.unseen))
}

/// The models depend on speeds and courses, which stay as they were found, and on the motion that fusion assumes, which
/// it learns. Where a manoeuvre begins at the end of a run, a state may differ by more than its standard deviation.
#[test]
fn lagging_states_nearly_equal_those_of_the_whole_trajectory_so_far() {
    const NEAR: f64 = 0.1;
    let mut apart = Vec::new();
    for (seed, lag_s) in [(939_026_535_082, 17.2), (9_122_838_464, 4.9), (3, 3.0), (7, 10.0)] {
        let events = emitted(every_second(), seed);
        let left = lagging(&events, lag_s);
        assert!(left.len() > 130);
        for (place, state) in left.iter().step_by(15) {
            let Some(expected) = of_the_whole(&events[..*place], state) else {
                continue;
            };
            let sigmas = (0..AXES).flat_map(|axis| {
                let sigma = |axis: usize| expected.covariance.get(axis, axis).sqrt();
                [
                    (state.position_m[axis] - expected.position_m[axis]) / sigma(axis),
                    (state.velocity_mps[axis] - expected.velocity_mps[axis]) / sigma(axis + AXES),
                ]
            });
            apart.push(sigmas.map(f64::abs).fold(0.0, f64::max));
        }
    }
    apart.sort_by(f64::total_cmp);
    let near = apart.iter().filter(|apart| **apart < NEAR).count();
    assert!(apart.len() > 30 && apart.len() - near <= 2, "{apart:?}");
    assert!(apart[apart.len() / 2] < 0.25 * NEAR, "{apart:?}");
}

#[test]
fn every_published_state_leaves_once_and_in_order_not_before_its_time() {
    const LAG_S: f64 = 8.0;
    let events = emitted(every_second(), 3);
    let left = lagging(&events, LAG_S);
    let mut newest = BTreeMap::new();
    let mut published = Vec::new();
    for event in &events {
        if let Emitted::State(state) = event {
            published.push((state.track_number, state.reference_time_ns, state.state));
        }
    }
    let mut all: Vec<_> = left
        .iter()
        .map(|(_, state)| (state.track_number, state.reference_time_ns, state.state))
        .collect();
    for (place, state) in &left {
        let before = newest.insert(state.track_number, state.reference_time_ns);
        assert!(before.is_none_or(|before| before < state.reference_time_ns));
        if *place < events.len() {
            let Emitted::State(latest) = &events[*place - 1] else {
                panic!("left with an input");
            };
            let age_s = (latest.reference_time_ns - state.reference_time_ns) as f64 / 1e9;
            assert!((LAG_S..1.25 * LAG_S + 1.1).contains(&age_s), "{age_s}");
        }
    }
    all.sort_unstable();
    published.sort_unstable();
    assert_eq!(all, published);
}

#[test]
fn states_without_a_refresh_time_are_thinned_and_a_longer_lag_gives_smaller_errors() {
    let mut settings = settings();
    settings.sources = crate::testing::test_settings(4).sources;
    let events = emitted(settings, 4);
    let span_s = [20.0, 130.0];
    let count = |states: &[SystemTrack]| {
        let seconds = states.iter().map(|state| state.reference_time_ns as f64 / 1e9);
        seconds.filter(|second| (span_s[0]..span_s[1]).contains(second)).count()
    };
    let of = |lag_s: f64| -> (usize, Errors) {
        let states: Vec<SystemTrack> = lagging(&events, lag_s).into_iter().map(|(_, state)| state).collect();
        (count(&states), errors(&states, span_s, 0.0))
    };
    let live: Vec<SystemTrack> = events
        .iter()
        .filter_map(|event| match event {
            Emitted::State(state) => Some(*state),
            Emitted::Input(_) => None,
        })
        .collect();
    let (thinned, short) = of(3.0);
    let (_, long) = of(15.0);
    assert!(count(&live) > 400 && thinned < 2 * 110 + 2, "{thinned}");
    let live = errors(&live, span_s, 0.0);
    assert!(
        short[0] < 0.85 * live[0] && long[0] < 0.85 * short[0],
        "{live:?} {short:?} {long:?}"
    );
    assert!(
        short[2] < 0.85 * live[2] && long[2] < 0.8 * short[2],
        "{live:?} {short:?} {long:?}"
    );
    assert!((0.4..1.6).contains(&long[3]), "{long:?}");
}

/// The states that leave when a track changes to this state.
fn left_by(life: TrackState) -> Vec<SystemTrack> {
    let events = emitted(every_second(), 5);
    let mut smoother = LagSmoother::new(5_000_000_000);
    let mut last = None;
    let mut left = 0;
    for event in &events {
        let out = |_: &SystemTrack| left += 1;
        match event {
            Emitted::Input(input) => smoother.input(input, out),
            Emitted::State(state) => {
                last = Some(*state);
                smoother.state(state, out);
            }
        }
    }
    let mut ended = last.unwrap();
    ended.reference_time_ns += 1_000_000_000;
    ended.state = life as u8;
    let mut of_track = Vec::new();
    smoother.state(&ended, |state| of_track.push(*state));
    assert!(left > 0 && of_track.len() > 4, "{left} {}", of_track.len());
    assert!(of_track.iter().all(|state| state.track_number == ended.track_number));
    of_track
}

#[test]
fn a_track_that_ends_or_rests_leaves_at_once() {
    for life in [TrackState::Suspended, TrackState::Terminated] {
        assert_eq!(left_by(life).last().unwrap().state, life as u8);
    }
}
