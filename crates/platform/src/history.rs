//! The latest states of a platform, and the interpolation to a time.
//!
//! Position, heading and tilt come from different instruments at different rates, so each is interpolated between
//! separate neighbours. Extrapolation would need no waiting, but depends on when a state came; interpolation depends on
//! the data alone, and a recording gives the live process's results.
//!
//! Between two states at the distance T, a time at the share f:
//!
//! - position: the cubic through both positions with both velocities (Hermite); without velocities the straight line;
//! - angles: along the shorter arc, so across north, at a constant rate;
//! - variances: (1 − f)·σ₁² + f·σ₂². Errors of successive states are taken as the same, as is mostly true of a compass;
//!   independent errors would partly cancel, so the value is never too small;
//! - growth: the motion between the states deviates from the line by at most a·f·(1 − f)·T²/2 at an acceleration a.
//!   This is added as a standard deviation, for the cubic with a further factor f·(1 − f), since the cubic follows the
//!   motion to a higher order.

use std::f64::consts::{PI, TAU};

use crate::channel::{Around, Channel};
use crate::pose::{AngleAt, NoState, Pose, level};
use crate::settings::Assumed;
use crate::state::State;

const NS_PER_S: f64 = 1e9;

/// Latest states of a platform.
#[derive(Clone, Debug)]
pub struct History {
    assumed: Assumed,
    places: Channel<PlaceEntry>,
    headings: Channel<AngleEntry<1>>,
    tilts: Channel<AngleEntry<2>>,
}

/// Effect of a state on the history.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Added {
    /// The state, or a part, is kept.
    Kept,
    /// The state has nothing to keep: no position, heading or tilt, and a velocity of no kept position.
    Nothing,
    /// The state is older than all kept states, and there is no room.
    TooOld,
}

#[derive(Clone, Copy, Debug)]
struct PlaceEntry {
    position_m: [f64; 3],
    sigma_m: f64,
    velocity: Option<([f64; 3], f64)>,
}

#[derive(Clone, Copy, Debug)]
struct AngleEntry<const N: usize> {
    angles_rad: [f64; N],
    sigmas_rad: [f64; N],
}

impl History {
    /// Makes a history that keeps at most `capacity` states of each kind.
    pub fn new(assumed: Assumed, capacity: usize) -> Self {
        Self {
            assumed,
            places: Channel::new(capacity),
            headings: Channel::new(capacity),
            tilts: Channel::new(capacity),
        }
    }

    /// Assumptions where the states give no value.
    pub fn assumed(&self) -> &Assumed {
        &self.assumed
    }

    /// Takes a state. The parts of states with the same time complete each other.
    pub fn add(&mut self, state: &State) -> Added {
        let assumed = self.assumed;
        let (mut any, mut kept) = (false, false);
        let mut note = |is_kept: bool| {
            any = true;
            kept |= is_kept;
        };
        let velocity = state
            .velocity_mps
            .map(|velocity| (velocity, state.velocity_sigma_mps.unwrap_or(assumed.velocity_sigma_mps)));
        if let Some(position_m) = state.position_m {
            let earlier = self.places.of(state.time_ns).and_then(|entry| entry.velocity);
            let entry = PlaceEntry {
                position_m,
                sigma_m: state.position_sigma_m.unwrap_or(assumed.position_sigma_m),
                velocity: velocity.or(earlier),
            };
            note(self.places.add(state.time_ns, entry));
        } else if let (Some(entry), true) = (self.places.of(state.time_ns), velocity.is_some()) {
            entry.velocity = velocity;
            note(true);
        }
        if let Some(heading_rad) = state.heading_rad {
            let sigma_rad = state.heading_sigma_rad.unwrap_or(assumed.heading_sigma_deg.rad());
            let entry = AngleEntry {
                angles_rad: [heading_rad],
                sigmas_rad: [sigma_rad],
            };
            note(self.headings.add(state.time_ns, entry));
        }
        if let Some(angles_rad) = state.tilt_rad {
            let sigmas_rad = state.tilt_sigmas_rad.unwrap_or([assumed.attitude_sigma_deg.rad(); 2]);
            let entry = AngleEntry { angles_rad, sigmas_rad };
            note(self.tilts.add(state.time_ns, entry));
        }
        match (any, kept) {
            (_, true) => Added::Kept,
            (true, false) => Added::TooOld,
            (false, false) => Added::Nothing,
        }
    }

    /// Time that the positions have reached, nanoseconds.
    pub fn reached_ns(&self) -> Option<i64> {
        self.places.latest().map(|(time_ns, _)| time_ns)
    }

    /// The platform's state at a time.
    ///
    /// # Errors
    /// The reason, if the position is unknown. The heading and the tilt have separate reasons in the [`Pose`].
    pub fn at(&self, time_ns: i64) -> Result<Pose, NoState> {
        let gap_ns = self.assumed.max_gap_s.ns();
        let place = self.places.around(time_ns, gap_ns)?;
        let heading = self.headings.around(time_ns, gap_ns);
        let tilt = self.tilts.around(time_ns, gap_ns);
        let pose = |position_m, position_sigma_m, velocity_mps, velocity_sigma_mps| Pose {
            time_ns,
            position_m,
            position_sigma_m,
            velocity_mps,
            velocity_sigma_mps,
            heading: heading.map(|around| self.angles(time_ns, &around)[0]),
            tilt: match tilt {
                Err(NoState::None) => Ok(level(&self.assumed)),
                tilt => tilt.map(|around| self.angles(time_ns, &around)),
            },
        };
        Ok(match place {
            Around::At(entry) => {
                let velocity = entry.velocity.or_else(|| self.slope(time_ns));
                let sigma = velocity.map_or(self.assumed.velocity_sigma_mps, |(_, sigma)| sigma);
                pose(
                    entry.position_m,
                    entry.sigma_m,
                    velocity.map(|(velocity, _)| velocity),
                    sigma,
                )
            }
            Around::Between(entries) => {
                let ([position, velocity], [sigma_m, sigma_mps]) = between(entries, time_ns, &self.assumed);
                pose(position, sigma_m, Some(velocity), sigma_mps)
            }
        })
    }

    /// Velocity by the positions around that of exactly this time.
    fn slope(&self, time_ns: i64) -> Option<([f64; 3], f64)> {
        let gap_ns = self.assumed.max_gap_s.ns();
        let beside = [time_ns.checked_sub(1)?, time_ns.checked_add(1)?];
        beside
            .iter()
            .find_map(|beside_ns| match self.places.around(*beside_ns, gap_ns) {
                Ok(Around::Between(entries)) => {
                    let ([_, velocity], [_, sigma]) = between(entries, *beside_ns, &self.assumed);
                    Some((velocity, sigma))
                }
                _ => None,
            })
    }

    fn angles<const N: usize>(&self, time_ns: i64, around: &Around<AngleEntry<N>>) -> [AngleAt; N] {
        match around {
            Around::At(entry) => std::array::from_fn(|place| AngleAt {
                angle_rad: entry.angles_rad[place],
                rate_radps: self.rate(time_ns, place, N),
                sigma_rad: entry.sigmas_rad[place],
            }),
            Around::Between([(before_ns, before), (after_ns, after)]) => {
                let span_s = (after_ns - before_ns) as f64 / NS_PER_S;
                let share = (time_ns - before_ns) as f64 / NS_PER_S / span_s;
                let growth = growth(self.assumed.angular_acceleration_degps2.rad(), share, span_s);
                std::array::from_fn(|place| {
                    let arc = shorter_arc(before.angles_rad[place], after.angles_rad[place]);
                    let variance = mixed(share, before.sigmas_rad[place], after.sigmas_rad[place]);
                    AngleAt {
                        angle_rad: wrapped(before.angles_rad[place] + share * arc),
                        rate_radps: arc / span_s,
                        sigma_rad: (variance + growth * growth).sqrt(),
                    }
                })
            }
        }
    }

    /// Rate of an angle at the time of exactly one state.
    fn rate(&self, time_ns: i64, place: usize, angles: usize) -> f64 {
        let gap_ns = self.assumed.max_gap_s.ns();
        let beside = [time_ns.saturating_sub(1), time_ns.saturating_add(1)];
        let rate_of = |beside_ns: i64| -> Option<f64> {
            let of = |first: i64, second: i64, a: f64, b: f64| shorter_arc(a, b) / ((second - first) as f64 / NS_PER_S);
            match angles {
                1 => match self.headings.around(beside_ns, gap_ns) {
                    Ok(Around::Between([(s, a), (t, b)])) => Some(of(s, t, a.angles_rad[place], b.angles_rad[place])),
                    _ => None,
                },
                _ => match self.tilts.around(beside_ns, gap_ns) {
                    Ok(Around::Between([(s, a), (t, b)])) => Some(of(s, t, a.angles_rad[place], b.angles_rad[place])),
                    _ => None,
                },
            }
        };
        beside.iter().find_map(|beside_ns| rate_of(*beside_ns)).unwrap_or(0.0)
    }
}

/// Position and velocity between two states, with standard deviations.
fn between(
    [(before_ns, before), (after_ns, after)]: [(i64, PlaceEntry); 2],
    time_ns: i64,
    assumed: &Assumed,
) -> ([[f64; 3]; 2], [f64; 2]) {
    let span_s = (after_ns - before_ns) as f64 / NS_PER_S;
    let share = (time_ns - before_ns) as f64 / NS_PER_S / span_s;
    let straight = growth(assumed.acceleration_mps2, share, span_s);
    let variance = mixed(share, before.sigma_m, after.sigma_m);
    let chord: [f64; 3] = std::array::from_fn(|axis| (after.position_m[axis] - before.position_m[axis]) / span_s);
    if let (Some((v0, s0)), Some((v1, s1))) = (before.velocity, after.velocity) {
        let (f, f2, f3) = (share, share * share, share * share * share);
        let position = std::array::from_fn(|axis| {
            (2.0 * f3 - 3.0 * f2 + 1.0) * before.position_m[axis]
                + (3.0 * f2 - 2.0 * f3) * after.position_m[axis]
                + span_s * ((f3 - 2.0 * f2 + f) * v0[axis] + (f3 - f2) * v1[axis])
        });
        let velocity = std::array::from_fn(|axis| {
            6.0 * (f - f2) * chord[axis] + (3.0 * f2 - 4.0 * f + 1.0) * v0[axis] + (3.0 * f2 - 2.0 * f) * v1[axis]
        });
        let cubic = straight * share * (1.0 - share);
        let sigma_mps = mixed(share, s0, s1).sqrt();
        return ([position, velocity], [(variance + cubic * cubic).sqrt(), sigma_mps]);
    }
    let position = std::array::from_fn(|axis| before.position_m[axis] + share * span_s * chord[axis]);
    // The chord is the mean velocity; at both ends the velocity differs by half of the acceleration's effect.
    let turned = 0.5 * assumed.acceleration_mps2 * span_s;
    let sigma_mps = (assumed.velocity_sigma_mps.powi(2) + turned * turned).sqrt();
    ([position, chord], [(variance + straight * straight).sqrt(), sigma_mps])
}

/// Deviation from a straight line between two states.
fn growth(acceleration: f64, share: f64, span_s: f64) -> f64 {
    0.5 * acceleration * share * (1.0 - share) * span_s * span_s
}

fn mixed(share: f64, before: f64, after: f64) -> f64 {
    (1.0 - share) * before * before + share * after * after
}

/// The turn between two angles by less than half a circle, radians.
pub(crate) fn shorter_arc(from_rad: f64, to_rad: f64) -> f64 {
    wrapped(to_rad - from_rad)
}

/// The angle in [−π, π).
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}
