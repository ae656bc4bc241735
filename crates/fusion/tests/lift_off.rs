//! A detection point that leaps to another place on its target, as at lift-off: the track goes on where it was.

use fusion::Engine;
use fusion::settings::{AccuracyTable, Settings, SourceSettings, Weighing};
use messages::{Covariance, Identity, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use test_support::{Random, S};

/// Standard deviations, metres, and periods, seconds, of multilateration, radar and ADS-B.
const SIGMAS_M: [f64; 3] = [5.0, 25.0, 10.0];
const PERIODS_S: [u32; 3] = [1, 4, 1];
/// Where multilateration sees the aircraft, metres ahead of the middle, before and after.
const NOSE_M: f64 = 30.0;
const BELLY_M: f64 = -10.0;
const TARGETS: u32 = 10;
const END_S: u32 = 120;

#[derive(Clone, Copy, Debug)]
struct Case {
    /// Ranks of the sources: the first one's point is shown.
    ranks: [u32; 3],
    /// Acceleration across the course from that time on, m/s².
    turn_mps2: f64,
    leaps: bool,
    seed: u64,
}

/// What a track showed of its target.
#[derive(Clone, Copy, Debug)]
struct Shown {
    target: u32,
    /// Since the leap, seconds.
    since_s: f64,
    /// Ahead of the target's middle, metres.
    ahead_m: f64,
    speed_error_mps: f64,
}

impl Case {
    fn leap_s(&self, target: u32) -> f64 {
        50.3 + 2.0 * f64::from(target)
    }

    /// Position, velocity and course of a target.
    fn motion(&self, target: u32, time_s: f64) -> ([f64; 2], [f64; 2], [f64; 2]) {
        let speed_mps = 65.0 + 2.0 * f64::from(target);
        let heading = f64::from(target) * 2.4;
        let start_m = [f64::from(target % 5) * 9e3, f64::from(target / 5) * 9e3];
        let turning_s = (time_s - self.leap_s(target)).max(0.0);
        let rate = self.turn_mps2 / speed_mps;
        let now = heading + rate * turning_s;
        let course = [now.sin(), now.cos()];
        let straight_m = speed_mps * (time_s - turning_s);
        let mut place_m = [
            start_m[0] + straight_m * heading.sin(),
            start_m[1] + straight_m * heading.cos(),
        ];
        if rate > 0.0 {
            place_m[0] += speed_mps / rate * (heading.cos() - now.cos());
            place_m[1] += speed_mps / rate * (now.sin() - heading.sin());
        } else {
            place_m[0] += speed_mps * turning_s * course[0];
            place_m[1] += speed_mps * turning_s * course[1];
        }
        (place_m, course.map(|part| speed_mps * part), course)
    }

    fn ahead_m(&self, source: usize, target: u32, time_s: f64) -> f64 {
        match source {
            0 if self.leaps && time_s >= self.leap_s(target) => BELLY_M,
            0 => NOSE_M,
            _ => 0.0,
        }
    }

    fn run(&self) -> Vec<Shown> {
        let sources = (0..3).map(|source| {
            let (name, rank) = (format!("source-{source}"), self.ranks[source]);
            let weighing = Weighing::default();
            SourceSettings::new(&name, &weighing, (1.0, rank), [0.0; 2], &AccuracyTable::default()).unwrap()
        });
        let mut engine = Engine::new(Settings::default().with_sources(sources.collect()).unwrap()).unwrap();
        let (mut random, mut shown) = (Random::new(self.seed), Vec::new());
        for second in 0..END_S {
            for source in (0..3).filter(|source| second % PERIODS_S[*source] == 0) {
                for target in 0..TARGETS {
                    let time_s = f64::from(second) + 0.3 * source as f64 + 0.02 * f64::from(target);
                    let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
                    let (place_m, velocity_mps, course) = self.motion(target, time_s);
                    let (ahead_m, sigma_m) = (self.ahead_m(source, target, time_s), SIGMAS_M[source]);
                    let measured = |axis: usize, noise: f64| place_m[axis] + ahead_m * course[axis] + sigma_m * noise;
                    let report = SensorTrack {
                        time_of_measurement_ns: (time_s * S as f64) as i64,
                        source: source as u16,
                        track_number: target + 1,
                        valid: sensor_track_bits::VELOCITY,
                        position_m: [measured(0, normal()), measured(1, normal()), 500.0],
                        velocity_mps: [velocity_mps[0] + normal(), velocity_mps[1] + normal(), 0.0],
                        covariance: Covariance::diagonal([sigma_m, sigma_m, 30.0], [1.0; 3]),
                        identity: Identity::default().with_address(0x40_0000 + target),
                        state: TrackState::Confirmed as u8,
                        ..SensorTrack::default()
                    };
                    engine.take(&report, &mut |track: &SystemTrack| {
                        let target = track.identity.address().unwrap() - 0x40_0000;
                        let time_s = track.reference_time_ns as f64 / S as f64;
                        let (place_m, velocity_mps, course) = self.motion(target, time_s);
                        let along = |axis: usize| (track.position_m[axis] - place_m[axis]) * course[axis];
                        let faster = |axis: usize| track.velocity_mps[axis] - velocity_mps[axis];
                        shown.push(Shown {
                            target,
                            since_s: time_s - self.leap_s(target),
                            ahead_m: along(0) + along(1),
                            speed_error_mps: faster(0).hypot(faster(1)),
                        });
                    });
                }
            }
        }
        shown
    }
}

/// Mean over the states of a target in a time since the leap, seconds.
fn mean(shown: &[Shown], target: u32, (from_s, to_s): (f64, f64), of: impl Fn(&Shown) -> f64) -> f64 {
    let within = |shown: &&Shown| shown.target == target && (from_s..to_s).contains(&shown.since_s);
    let values: Vec<f64> = shown.iter().filter(within).map(of).collect();
    assert!(
        !values.is_empty(),
        "target {target} has no state from {from_s} to {to_s} s"
    );
    values.iter().sum::<f64>() / values.len() as f64
}

/// Ways of the tracks from where they were before, metres, the least first, in a time after the leap.
fn ways_m(shown: &[Shown], time_s: (f64, f64)) -> Vec<f64> {
    let ahead_m = |target, time_s| mean(shown, target, time_s, |shown| shown.ahead_m);
    let way_m = |target| (ahead_m(target, time_s) - ahead_m(target, (-10.0, 0.0))).abs();
    let mut ways_m: Vec<f64> = (0..TARGETS).map(way_m).collect();
    ways_m.sort_by(f64::total_cmp);
    ways_m
}

const IN_ORDER: [u32; 3] = [1, 2, 3];

#[test]
fn tracks_stay_where_they_were_when_points_leap() {
    for ranks in [IN_ORDER, [2, 3, 1], [3, 1, 2]] {
        let runs = (1..=10).map(|seed| {
            let case = Case {
                ranks,
                turn_mps2: 0.0,
                leaps: true,
                seed,
            };
            case.run()
        });
        let runs: Vec<_> = runs.collect();
        for time_s in [(2.0, 4.0), (4.0, 8.0), (20.0, 24.0), (36.0, 44.0)] {
            let mut all_m: Vec<f64> = runs.iter().flat_map(|shown| ways_m(shown, time_s)).collect();
            all_m.sort_by(f64::total_cmp);
            // Tracks wander by some metres without a leap; one that follows the point moves by more than 30 m. Two or
            // three leaps in a hundred are taken for noise.
            let [middle_m, most_m] = [50, 94].map(|place| all_m[place]);
            assert!(middle_m < 4.0 && most_m < 10.0, "{ranks:?}, {time_s:?}: {all_m:.1?} m");
            let speed_mps = |shown: &[Shown], target| mean(shown, target, time_s, |shown| shown.speed_error_mps);
            let count_off = |shown: &Vec<Shown>| (0..TARGETS).filter(|target| speed_mps(shown, *target) > 2.0).count();
            let off: usize = runs.iter().map(count_off).sum();
            assert!(off < 6, "{ranks:?}, {time_s:?}: {off} velocities");
        }
    }
}

#[test]
fn a_turn_is_no_leap() {
    for (turn_mps2, seed) in [(3.0, 4), (8.0, 5), (15.0, 6)] {
        let case = Case {
            ranks: IN_ORDER,
            turn_mps2,
            leaps: false,
            seed,
        };
        // A source that is no longer followed in the turn would leave the track behind for long.
        let ways_m = ways_m(&case.run(), (8.0, 16.0));
        assert!(ways_m[9] < 12.0, "{case:?}: {ways_m:.1?} m");
    }
}
