//! Possible futures of a target: draws from its state, each of which goes on by a motion model.
//!
//! - Place and velocity are drawn together, since they are correlated. In straight flight the velocity has the smaller
//!   covariance that the state states for it.
//! - A target that turns goes on turning in as many draws as its turn is probable, until its course has changed by
//!   an angle that is drawn, and flies straight then.
//! - A climb or descent ends at the height at which it is to end, or after the vertical look-ahead.
//!
//! The draws are the same for every state: two equal states have equal futures, and a probability does not change by
//! chance from one state to the next. Draws come in pairs with opposite signs, so their mean is the state itself.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::target::Target;

/// Number of futures of a target or pair.
pub(crate) const FUTURES: usize = 128;
/// Mean of the angle by which a turn still goes on, radians. Turns of flights are of some tens of degrees.
const TURN_LEFT_RAD: f64 = 0.8;
/// Seed of the draws.
const SEED: u64 = 0x6b6f_7365_6b69;

/// A draw of standard normal and uniform numbers.
#[derive(Clone, Copy, Debug)]
struct Draw {
    /// Place and velocity, height and climb.
    normal: [f64; 6],
    /// Model of the horizontal and of the vertical motion, end of the turn.
    uniform: [f64; 3],
}

/// Draws for the two sides of a pair. A single target uses those of the first side.
#[derive(Clone, Debug)]
pub(crate) struct Draws([Vec<Draw>; 2]);

/// Which target of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    One = 0,
    Other = 1,
}

/// One future of a target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Future {
    place_m: [f64; 2],
    velocity_mps: [f64; 2],
    /// Rate of turn, radians per second; 0 in straight flight.
    turn_radps: f64,
    /// End of the turn, seconds from the state's time.
    turn_end_s: f64,
    height_m: f64,
    climb_mps: f64,
    /// End of the climb, seconds from the state's time.
    climb_end_s: f64,
}

impl Draws {
    pub(crate) fn new() -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut side = || {
            let mut draws: Vec<Draw> = (0..FUTURES / 2)
                .map(|_| Draw {
                    normal: std::array::from_fn(|_| StandardNormal.sample(&mut random)),
                    uniform: std::array::from_fn(|_| random.random()),
                })
                .collect();
            // Beside each other, so that any even number of the first ones has the mean of all.
            draws = draws
                .into_iter()
                .flat_map(|draw| {
                    let opposite = Draw {
                        normal: draw.normal.map(|number| -number),
                        uniform: draw.uniform.map(|number| 1.0 - number),
                    };
                    [draw, opposite]
                })
                .collect();
            make_independent(&mut draws);
            draws
        };
        Self([side(), side()])
    }

    /// Futures of a target whose climbs end after `vertical_s`, seconds from the state's time.
    pub(crate) fn futures<'a>(
        &'a self,
        side: Side,
        target: &'a Target,
        vertical_s: f64,
    ) -> impl Iterator<Item = Future> + 'a {
        let spread = Spread::of(target);
        self.0[side as usize]
            .iter()
            .map(move |draw| spread.future(target, draw, vertical_s))
    }
}

/// Gives the normal numbers of finitely many draws the spread 1, and no correlation with each other: else every
/// covariance would be another one.
fn make_independent(draws: &mut [Draw]) {
    for place in 0..6 {
        for earlier in 0..place {
            let both: f64 = draws.iter().map(|draw| draw.normal[place] * draw.normal[earlier]).sum();
            let share = both / draws.len() as f64;
            for draw in &mut *draws {
                draw.normal[place] -= share * draw.normal[earlier];
            }
        }
        let squares: f64 = draws.iter().map(|draw| draw.normal[place] * draw.normal[place]).sum();
        let spread = (squares / draws.len() as f64).sqrt();
        for draw in &mut *draws {
            draw.normal[place] /= spread;
        }
    }
}

/// Square roots of the covariances of a target.
#[derive(Clone, Copy, Debug)]
struct Spread {
    /// Of the place: xx, yx, yy of a lower triangle.
    place: [f64; 3],
    /// Velocity by the draw of the place.
    gain: [[f64; 2]; 2],
    /// Of the velocity, beyond that: in straight flight, and in general.
    velocity: [[f64; 3]; 2],
    height: f64,
    climb_gain: f64,
    /// Of the climb rate, beyond that: in steady flight, and in general.
    climb: [f64; 2],
}

impl Spread {
    fn of(target: &Target) -> Self {
        let p = &target.covariance;
        let place = triangle([p[0][0], p[0][1], p[1][1]]);
        // Solves gain · triangleᵀ = the covariance of velocity and place.
        let gain = [2, 3].map(|row: usize| {
            let first = ratio(p[row][0], place[0]);
            [first, ratio(p[row][1] - first * place[1], place[2])]
        });
        let beyond = |[xx, xy, yy]: [f64; 3]| {
            triangle([
                xx - gain[0][0] * gain[0][0] - gain[0][1] * gain[0][1],
                xy - gain[0][0] * gain[1][0] - gain[0][1] * gain[1][1],
                yy - gain[1][0] * gain[1][0] - gain[1][1] * gain[1][1],
            ])
        };
        let general = [p[2][2], p[2][3], p[3][3]];
        let steady = target.steady.map_or(general, |(_, steady)| steady);
        let [of_height, of_both, of_climb] = target.height.map_or([0.0; 3], |height| height.covariance);
        let height = of_height.max(0.0).sqrt();
        let climb_gain = ratio(of_both, height);
        let steady_climb = target
            .height
            .and_then(|height| height.steady)
            .map_or(of_climb, |(_, variance)| variance);
        let root = |variance: f64| (variance - climb_gain * climb_gain).max(0.0).sqrt();
        Self {
            place,
            gain,
            velocity: [beyond(steady), beyond(general)],
            height,
            climb_gain,
            climb: [root(steady_climb), root(of_climb)],
        }
    }

    fn future(&self, target: &Target, draw: &Draw, vertical_s: f64) -> Future {
        let [a, b, c, d, of_height, of_climb] = draw.normal;
        let [of_motion, of_vertical, of_end] = draw.uniform;
        let turns = of_motion < target.turn_probability;
        // The rest of the probability is straight flight with a steady velocity, or something else.
        let is_steady = !turns
            && target
                .steady
                .is_some_and(|(probability, _)| of_motion < target.turn_probability + probability);
        let [xx, yx, yy] = self.velocity[usize::from(!is_steady)];
        let velocity_mps = [
            target.velocity_mps[0] + self.gain[0][0] * a + self.gain[0][1] * b + xx * c,
            target.velocity_mps[1] + self.gain[1][0] * a + self.gain[1][1] * b + yx * c + yy * d,
        ];
        let turn_radps = if turns { target.turn_radps } else { 0.0 };
        let (mut height_m, mut climb_mps) = (0.0, 0.0);
        if let Some(height) = target.height {
            let is_steady = height.steady.is_some_and(|(probability, _)| of_vertical < probability);
            height_m = height.height_m + self.height * of_height;
            climb_mps = height.climb_mps + self.climb_gain * of_height + self.climb[usize::from(!is_steady)] * of_climb;
        }
        Future {
            place_m: [
                target.place_m[0] + self.place[0] * a,
                target.place_m[1] + self.place[1] * a + self.place[2] * b,
            ],
            velocity_mps,
            turn_radps,
            turn_end_s: if turns {
                -TURN_LEFT_RAD * of_end.max(1e-9).ln() / turn_radps.abs()
            } else {
                0.0
            },
            height_m,
            climb_mps,
            climb_end_s: vertical_s,
        }
    }
}

/// Lower triangle whose product with its transpose is a covariance (xx, xy, yy). What is negative counts as 0.
fn triangle([xx, xy, yy]: [f64; 3]) -> [f64; 3] {
    let first = xx.max(0.0).sqrt();
    let below = ratio(xy, first);
    [first, below, (yy - below * below).max(0.0).sqrt()]
}

fn ratio(of: f64, by: f64) -> f64 {
    if by > 0.0 { of / by } else { 0.0 }
}

impl Future {
    /// The mean future: the state itself, which goes on turning for the mean angle if a turn is more probable than not.
    pub(crate) fn mean(target: &Target, vertical_s: f64) -> Self {
        let turns = target.turn_probability > 0.5;
        Self {
            place_m: target.place_m,
            velocity_mps: target.velocity_mps,
            turn_radps: if turns { target.turn_radps } else { 0.0 },
            turn_end_s: if turns {
                TURN_LEFT_RAD / target.turn_radps.abs()
            } else {
                0.0
            },
            height_m: target.height.map_or(0.0, |height| height.height_m),
            climb_mps: target.height.map_or(0.0, |height| height.climb_mps),
            climb_end_s: vertical_s,
        }
    }

    /// The same at rest.
    pub(crate) fn still(self) -> Self {
        Self {
            velocity_mps: [0.0; 2],
            turn_radps: 0.0,
            ..self
        }
    }

    /// Place after a time from the state's time, metres.
    pub(crate) fn place_m(&self, time_s: f64) -> [f64; 2] {
        let [vx, vy] = self.velocity_mps;
        if self.turn_radps == 0.0 {
            return [self.place_m[0] + vx * time_s, self.place_m[1] + vy * time_s];
        }
        let turning_s = time_s.min(self.turn_end_s);
        let (sin, cos) = (self.turn_radps * turning_s).sin_cos();
        let (along, across) = (sin / self.turn_radps, (1.0 - cos) / self.turn_radps);
        let straight_s = time_s - turning_s;
        let end_mps = [vx * cos - vy * sin, vx * sin + vy * cos];
        [
            self.place_m[0] + vx * along - vy * across + end_mps[0] * straight_s,
            self.place_m[1] + vx * across + vy * along + end_mps[1] * straight_s,
        ]
    }

    /// Height after a time from the state's time, metres.
    pub(crate) fn height_m(&self, time_s: f64) -> f64 {
        self.height_m + self.climb_mps * time_s.min(self.climb_end_s)
    }

    /// End of the turn, seconds from the state's time; 0 without a turn.
    pub(crate) fn turn_end_s(&self) -> f64 {
        self.turn_end_s
    }

    /// End of the climb, seconds from the state's time.
    pub(crate) fn climb_end_s(&self) -> f64 {
        self.climb_end_s
    }

    pub(crate) fn speed_mps(&self) -> f64 {
        self.velocity_mps[0].hypot(self.velocity_mps[1])
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use frames::{Geodetic, SystemFrame};
    use messages::{SystemTrack, TrackState};

    use super::*;

    pub(crate) fn frame() -> SystemFrame {
        SystemFrame::at(Geodetic::from_degrees(46.0, 7.0, 0.0).unwrap())
    }

    /// State of a target with known standard deviations, m and m/s.
    pub(crate) fn state(number: u32, position_m: [f64; 3], velocity_mps: [f64; 3], sigma: [f64; 2]) -> SystemTrack {
        SystemTrack {
            track_number: number,
            state: TrackState::Confirmed.code(),
            height_valid: 1,
            velocity_valid: 1,
            position_m,
            velocity_mps,
            identity: messages::Identity::default().with_address(number),
            covariance: messages::Covariance::diagonal([sigma[0]; 3], [sigma[1]; 3]),
            ..SystemTrack::default()
        }
    }

    #[test]
    fn futures_have_the_covariance_of_the_state() {
        let mut track = state(1, [0.0; 3], [100.0, 0.0, 5.0], [40.0, 3.0]);
        track.covariance.set(0, 3, 60.0);
        track.covariance.set(1, 3, -30.0);
        track.covariance.set(2, 5, 50.0);
        let target = Target::of(&track, &frame()).unwrap();
        let draws = Draws::new();
        for side in [Side::One, Side::Other] {
            let of = |value: &dyn Fn(&Future) -> [f64; 2]| {
                let futures: Vec<[f64; 2]> = draws
                    .futures(side, &target, 30.0)
                    .map(|future| value(&future))
                    .collect();
                let mean = [0, 1].map(|axis| futures.iter().map(|each| each[axis]).sum::<f64>() / FUTURES as f64);
                let both = futures
                    .iter()
                    .map(|each| (each[0] - mean[0]) * (each[1] - mean[1]))
                    .sum::<f64>();
                (mean, both / FUTURES as f64)
            };
            let (mean, xx) = of(&|future| [future.place_m[0], future.place_m[0]]);
            assert!(mean[0].abs() < 1e-6 && (xx - 1600.0).abs() < 1.0, "{mean:?} {xx}");
            let (mean, vx) = of(&|future| [future.place_m[0], future.velocity_mps[0]]);
            assert!(
                (mean[1] - target.velocity_mps[0]).abs() < 1e-6 && (vx - 60.0).abs() < 1e-3,
                "{vx}"
            );
            let (_, vy) = of(&|future| [future.place_m[1], future.velocity_mps[0]]);
            assert!((vy + 30.0).abs() < 1e-3, "{vy}");
            let (_, climb) = of(&|future| [future.height_m, future.climb_mps]);
            assert!((climb - 50.0).abs() < 1e-3, "{climb}");
        }
    }

    #[test]
    fn a_turn_goes_round_and_ends() {
        let track = state(1, [0.0, 0.0, 3_000.0], [0.0, 100.0, 0.0], [0.0; 2]);
        let mut target = Target::of(&track, &frame()).unwrap();
        target.turn_radps = -0.05;
        target.turn_probability = 1.0;
        let mut future = Future::mean(&target, 0.0);
        future.turn_end_s = std::f64::consts::FRAC_PI_2 / 0.05;
        // A quarter of a circle of 2 km to the right, then 100 m to the east.
        let radius_m = target.speed_mps() / 0.05;
        let place_m = future.place_m(future.turn_end_s + 1.0);
        assert!(
            (place_m[0] - radius_m - target.speed_mps()).abs() < 2.0,
            "{place_m:?} {radius_m}"
        );
        assert!((place_m[1] - radius_m).abs() < 2.0, "{place_m:?}");
        let ends: Vec<f64> = Draws::new()
            .futures(Side::One, &target, 0.0)
            .map(|each| each.turn_end_s)
            .collect();
        let mean_s = ends.iter().sum::<f64>() / FUTURES as f64;
        assert!((mean_s - TURN_LEFT_RAD / 0.05).abs() < 3.0, "{mean_s}");
    }

    #[test]
    fn a_climb_ends_after_the_vertical_look_ahead() {
        let track = state(1, [0.0, 0.0, 3_000.0], [100.0, 0.0, 10.0], [0.0; 2]);
        let future = Future::mean(&Target::of(&track, &frame()).unwrap(), 20.0);
        let climbed = |time_s| (future.height_m(time_s) - 3_000.0).round();
        assert_eq!((climbed(10.0), climbed(20.0), climbed(60.0)), (100.0, 200.0, 200.0));
    }
}
