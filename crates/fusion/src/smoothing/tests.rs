//! Smoothed trajectories of tracks that the engine fuses.

use messages::{Covariance, Decision, FusionRule, SensorTrack, VerticalMovement, sensor_track_bits};
use test_support::Random;

use super::*;
use crate::settings::RuleName;
use crate::testing::test_settings;
use crate::{FilterInput, Settings, Sink};

const SIGMA_M: f64 = 50.0;
const SPEED_MPS: f64 = 200.0;
const ACCELERATION_MPS2: f64 = 6.0;
/// Seconds between which targets turn to the right, and climb.
const TURN_S: [f64; 2] = [60.0, 90.0];
const CLIMB_S: [f64; 2] = [40.0, 80.0];
const CLIMB_MPS: f64 = 10.0;

#[derive(Default)]
struct Collector {
    trajectories: Trajectories,
    states: Vec<SystemTrack>,
}

impl Sink for Collector {
    fn track(&mut self, track: &SystemTrack) {
        self.trajectories.state(track);
        self.states.push(*track);
    }

    fn decision(&mut self, _: &Decision) {}

    fn follows_inputs(&self) -> bool {
        true
    }

    fn input(&mut self, input: &FilterInput) {
        self.trajectories.input(input);
    }
}

/// Place and velocity of a target that flies north, turns, and flies straight again; and climbs meanwhile.
fn truth(time_s: f64) -> ([f64; 3], [f64; 3]) {
    let rate = ACCELERATION_MPS2 / SPEED_MPS;
    let turned = rate * (time_s.clamp(TURN_S[0], TURN_S[1]) - TURN_S[0]);
    let radius_m = SPEED_MPS / rate;
    let (east, north) = (SPEED_MPS * turned.sin(), SPEED_MPS * turned.cos());
    let straight_s = (time_s - TURN_S[1]).max(0.0);
    let height_m = 3e3 + CLIMB_MPS * (time_s.clamp(CLIMB_S[0], CLIMB_S[1]) - CLIMB_S[0]);
    let climbs = (CLIMB_S[0]..CLIMB_S[1]).contains(&time_s);
    let place = [
        radius_m * (1.0 - turned.cos()) + straight_s * east,
        SPEED_MPS * time_s.min(TURN_S[0]) + radius_m * turned.sin() + straight_s * north,
        height_m,
    ];
    (place, [east, north, if climbs { CLIMB_MPS } else { 0.0 }])
}

/// Reports of so many targets by so many sources in turn, each of which is off by `offset_m` at its time to the east.
pub(super) fn reports(
    seed: u64,
    (sources, targets): (u16, u32),
    offset_m: impl Fn(u16, f64) -> f64,
) -> Vec<SensorTrack> {
    let mut random = Random::new(seed);
    let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
    let mut reports = Vec::new();
    let steps = 140 * u32::from(sources);
    for step in 0..steps {
        let (time_s, source) = (f64::from(step) / f64::from(sources), (step % u32::from(sources)) as u16);
        let (place, velocity_mps) = truth(time_s);
        for target in 0..targets {
            let away_m = [20e3 * f64::from(target) + offset_m(source, time_s), 0.0, 0.0];
            reports.push(SensorTrack {
                time_of_measurement_ns: (time_s * 1e9) as i64,
                source,
                track_number: target,
                position_m: std::array::from_fn(|axis| place[axis] + away_m[axis] + SIGMA_M * normal()),
                velocity_mps,
                covariance: Covariance::diagonal([SIGMA_M; 3], [20.0; 3]),
                state: TrackState::Confirmed as u8,
                valid: sensor_track_bits::VELOCITY | sensor_track_bits::HEIGHT,
                ..SensorTrack::default()
            });
        }
    }
    reports
}

/// States of the tracks of these reports, and the smoothed ones.
pub(super) fn smoothed(settings: Settings, reports: Vec<SensorTrack>) -> (Vec<SystemTrack>, SmoothedTracks) {
    let mut engine = Engine::new(settings).unwrap();
    let mut collector = Collector::default();
    for report in reports {
        engine.take(&report, &mut collector);
        collector.trajectories.look(&engine);
    }
    let Collector { trajectories, states } = collector;
    let smoothed = trajectories.smooth(&engine, |_| Ok::<(), ()>(())).unwrap();
    (states, smoothed)
}

/// The second of two sources is off by `offset_m`.
fn run(settings: Settings, offset_m: f64) -> (Vec<SystemTrack>, SmoothedTracks) {
    smoothed(settings, reports(8, (2, 3), |source, _| f64::from(source) * offset_m))
}

pub(super) fn settings() -> Settings {
    let mut settings = test_settings(2);
    settings.rule.name = RuleName(FusionRule::SystemFilter);
    let exact = Some(crate::settings::StampRounding::Exact);
    settings.sources.iter_mut().for_each(|source| source.stamps = exact);
    settings
}

/// Errors of states: see [`errors`].
pub(super) type Errors = [f64; 5];

/// Root mean squares of the errors of states between these times: plane (m), height (m), velocity in the plane (m/s),
/// and the mean normalised squares of the errors of position and velocity in the plane.
pub(super) fn errors(states: &[SystemTrack], [since_s, until_s]: [f64; 2], offset_m: f64) -> Errors {
    let mut sums = [0.0; 5];
    let mut count = 0.0;
    for state in states {
        let time_s = state.reference_time_ns as f64 / 1e9;
        if !(since_s..until_s).contains(&time_s) {
            continue;
        }
        let (place, velocity) = truth(time_s);
        let column = ((state.position_m[0] - place[0]) / 20e3).round();
        let error = [
            state.position_m[0] - place[0] - 20e3 * column - offset_m,
            state.position_m[1] - place[1],
        ];
        let p = |row, column| state.covariance.get(row, column);
        sums[0] += error[0] * error[0] + error[1] * error[1];
        sums[1] += (state.position_m[2] - place[2]).powi(2);
        let off_mps = [state.velocity_mps[0] - velocity[0], state.velocity_mps[1] - velocity[1]];
        sums[2] += off_mps[0] * off_mps[0] + off_mps[1] * off_mps[1];
        sums[4] += 0.5 * association::distance::squared2(off_mps, [p(3, 3), p(3, 4), p(4, 4)]);
        sums[3] += 0.5 * association::distance::squared2(error, [p(0, 0), p(0, 1), p(1, 1)]);
        count += 1.0;
    }
    assert!(count > 50.0);
    let [plane, height, velocity, nees, velocity_nees] = sums.map(|sum| sum / count);
    [plane.sqrt(), height.sqrt(), velocity.sqrt(), nees, velocity_nees]
}

#[test]
fn later_measurements_halve_the_errors_and_find_the_turn_where_it_began() {
    let (live, smoothed) = run(settings(), 0.0);
    let after: Vec<SystemTrack> = live.iter().map(|state| smoothed.of(state).unwrap()).collect();
    let all = [10.0, 140.0];
    let (before, now) = (errors(&live, all, 0.0), errors(&after, all, 0.0));
    assert!(
        now[0] < 0.55 * before[0] && now[1] < 0.6 * before[1] && now[2] < 0.5 * before[2],
        "{before:?} {now:?}"
    );
    assert!((0.4..1.6).contains(&now[3]) && (0.35..1.6).contains(&now[4]), "{now:?}");
    // In the turn, where a live filter is worst.
    let (before, now) = (errors(&live, TURN_S, 0.0), errors(&after, TURN_S, 0.0));
    assert!(
        now[0] < 0.5 * before[0] && now[2] < 0.4 * before[2],
        "{before:?} {now:?}"
    );
    let turning = |states: &[SystemTrack], second: f64| {
        let at = states
            .iter()
            .filter(|state| (state.reference_time_ns as f64 / 1e9 - second).abs() < 0.1);
        let turns: Vec<f32> = at.map(|state| state.mode_probabilities[3]).collect();
        turns.iter().sum::<f32>() / turns.len() as f32
    };
    let begun = TURN_S[0] + 4.0;
    assert!(
        turning(&after, begun) > 0.8 && turning(&live, begun) < 0.5,
        "{} {}",
        turning(&after, begun),
        turning(&live, begun)
    );
    assert!(turning(&after, TURN_S[0] - 6.0) < 0.2 && turning(&after, TURN_S[1] + 6.0) < 0.2);
    // What follows from the modes follows the smoothed ones.
    let middle = after
        .iter()
        .find(|state| state.reference_time_ns == 75_000_000_000)
        .unwrap();
    let rate = f64::from(middle.turn_rate_radps);
    assert!((rate / (ACCELERATION_MPS2 / SPEED_MPS) - 1.0).abs() < 0.35, "{rate}");
    assert_eq!(middle.movement.horizontal, HorizontalMovement::TurnRight as u8);
    assert!(middle.movement.acceleration_mps2[0] > 3.0, "{:?}", middle.movement);
    assert_eq!(middle.movement.vertical, VerticalMovement::Climb as u8);
}

#[test]
fn an_offset_found_late_is_taken_off_from_the_beginning() {
    const OFFSET_M: f64 = 120.0;
    let (live, smoothed) = run(settings(), OFFSET_M);
    let after: Vec<SystemTrack> = live.iter().map(|state| smoothed.of(state).unwrap()).collect();
    // Which of the two sources is off cannot be seen; that they differ can. An offset that stayed would make the tracks
    // swing between both.
    let early = [8.0, 30.0];
    let (before, now) = (
        errors(&live, early, 0.5 * OFFSET_M),
        errors(&after, early, 0.5 * OFFSET_M),
    );
    assert!(now[0] < 25.0 && now[0] < 0.5 * before[0], "{before:?} {now:?}");
    assert!(now[2] < 6.0 && now[2] < 0.5 * before[2], "{before:?} {now:?}");
}

#[test]
fn all_but_the_kinematics_stays_and_unknown_states_have_none() {
    let (live, smoothed) = run(settings(), 0.0);
    let state = &live[live.len() / 2];
    let after = smoothed.of(state).unwrap();
    let like_before = SystemTrack {
        position_m: state.position_m,
        velocity_mps: state.velocity_mps,
        covariance: state.covariance,
        mode_probabilities: state.mode_probabilities,
        turn_rate_radps: state.turn_rate_radps,
        turn_rate_sigma_radps: state.turn_rate_sigma_radps,
        climb_rate_mps: state.climb_rate_mps,
        climb_rate_variance: state.climb_rate_variance,
        steady_velocity_covariance: state.steady_velocity_covariance,
        steady_climb_variance: state.steady_climb_variance,
        movement: state.movement,
        ..after
    };
    assert_eq!(format!("{like_before:?}"), format!("{state:?}"));
    assert_ne!(after.position_m, state.position_m);
    assert!(state.steady_velocity().is_some() && after.steady_velocity().is_none() && after.steady_climb().is_none());
    let unknown = SystemTrack {
        track_number: 9_999,
        ..*state
    };
    assert!(smoothed.of(&unknown).is_none());
    let between = SystemTrack {
        reference_time_ns: state.reference_time_ns + 1,
        ..*state
    };
    assert!(smoothed.of(&between).is_none());
}

#[test]
fn targets_that_fly_straight_for_long_are_taken_to_do_so() {
    let mut engine = Engine::new(settings()).unwrap();
    let mut collector = Collector::default();
    // Before the turn.
    let before = reports(9, (2, 4), |_, _| 0.0);
    let before = before
        .iter()
        .filter(|report| report.time_of_measurement_ns < 60_000_000_000);
    before.for_each(|report| engine.take(report, &mut collector));
    let errors = ErrorsOverTime::default();
    let factors = likeliest(collector.trajectories.tracks.values(), |factors| Afterwards {
        engine: &engine,
        errors: &errors,
        factors,
    });
    assert!(factors.steady < 1.0 && factors.straight > 1.0, "{factors:?}");
}
