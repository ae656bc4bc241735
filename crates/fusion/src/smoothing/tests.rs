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

/// Three targets seen by two sources, of which the second is off by `offset_m` to the east.
fn run(settings: Settings, offset_m: f64) -> (Vec<SystemTrack>, SmoothedTracks) {
    let mut engine = Engine::new(settings).unwrap();
    let mut random = Random::new(8);
    let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
    let mut collector = Collector::default();
    for step in 0..280 {
        let (time_s, source) = (0.5 * f64::from(step), (step % 2) as u16);
        let (place, velocity_mps) = truth(time_s);
        for target in 0..3u32 {
            let away_m = [20e3 * f64::from(target) + f64::from(source) * offset_m, 0.0, 0.0];
            let report = SensorTrack {
                time_of_measurement_ns: (time_s * 1e9) as i64,
                source,
                track_number: target,
                position_m: std::array::from_fn(|axis| place[axis] + away_m[axis] + SIGMA_M * normal()),
                velocity_mps,
                covariance: Covariance::diagonal([SIGMA_M; 3], [20.0; 3]),
                state: TrackState::Confirmed as u8,
                valid: sensor_track_bits::VELOCITY | sensor_track_bits::HEIGHT,
                ..SensorTrack::default()
            };
            engine.take(&report, &mut collector);
        }
    }
    let Collector { trajectories, states } = collector;
    let smoothed = trajectories.smooth(&engine, |_| Ok::<(), ()>(())).unwrap();
    (states, smoothed)
}

fn settings() -> Settings {
    let mut settings = test_settings(2);
    settings.rule.name = RuleName(FusionRule::SystemFilter);
    settings
}

/// Root mean squares of the errors of states between these times: plane (m), height (m), velocity in the plane (m/s),
/// and the mean normalised square of the errors in the plane.
fn errors(states: &[SystemTrack], [since_s, until_s]: [f64; 2], offset_m: f64) -> [f64; 4] {
    let mut sums = [0.0; 4];
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
        sums[2] += (state.velocity_mps[0] - velocity[0]).powi(2) + (state.velocity_mps[1] - velocity[1]).powi(2);
        sums[3] += 0.5 * association::distance::squared2(error, [p(0, 0), p(0, 1), p(1, 1)]);
        count += 1.0;
    }
    assert!(count > 50.0);
    let [plane, height, velocity, nees] = sums.map(|sum| sum / count);
    [plane.sqrt(), height.sqrt(), velocity.sqrt(), nees]
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
    assert!((0.4..1.6).contains(&now[3]), "{now:?}");
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
        movement: state.movement,
        ..after
    };
    assert_eq!(format!("{like_before:?}"), format!("{state:?}"));
    assert_ne!(after.position_m, state.position_m);
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
