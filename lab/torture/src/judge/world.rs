//! The world of a record: where each target is at any time, from the record's whole seconds.

use std::collections::VecDeque;

use super::event::{Second, Target};

/// Seconds that are kept: states older than this are late beyond every limit.
const KEPT: usize = 64;

/// The latest seconds of the world.
#[derive(Clone, Debug)]
pub(crate) struct World {
    begin_utc_ns: i64,
    seconds: VecDeque<Second>,
}

/// Place and velocity of a target; metres, metres per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kinematics {
    pub(crate) position_m: [f64; 3],
    pub(crate) velocity_mps: [f64; 3],
}

impl World {
    pub(crate) fn new(begin_utc_ns: i64) -> Self {
        Self {
            begin_utc_ns,
            seconds: VecDeque::new(),
        }
    }

    /// Takes the next second.
    pub(crate) fn take(&mut self, second: &Second) {
        if self.seconds.len() == KEPT {
            self.seconds.pop_front();
        }
        self.seconds.push_back(second.clone());
    }

    /// Whether there is a simulated world.
    pub(crate) fn is_known(&self) -> bool {
        !self.seconds.is_empty()
    }

    /// The second with this number.
    pub(crate) fn second(&self, number: u32) -> Option<&Second> {
        let first = self.seconds.front()?.second;
        self.seconds.get(number.checked_sub(first)? as usize)
    }

    /// UTC of a second, nanoseconds.
    pub(crate) fn utc_ns(&self, second: u32) -> i64 {
        self.begin_utc_ns + i64::from(second) * SECOND_NS
    }

    /// Where the target of this address is at a time; `None` if there is none, or the time is unknown.
    pub(crate) fn target_at(&self, address: u32, utc_ns: i64) -> Option<Kinematics> {
        let since_ns = utc_ns.checked_sub(self.begin_utc_ns)?;
        let latest = i64::from(self.seconds.back()?.second);
        let before = since_ns.div_euclid(SECOND_NS).min(latest - 1);
        let [one, other] = [before, before + 1].map(|number| self.second(u32::try_from(number).ok()?));
        let of = |second: &Second| second.targets.iter().position(|target| target.address == address);
        let (one, other) = (one?, other?);
        let (from, to) = (&one.targets[of(one)?], &other.targets[of(other)?]);
        Some(between(
            from,
            to,
            (since_ns - before * SECOND_NS) as f64 / SECOND_NS as f64,
        ))
    }
}

/// A second, nanoseconds.
pub(crate) const SECOND_NS: i64 = 1_000_000_000;

/// The cubic that has the places and velocities of both seconds: less than a metre off in the tightest turn.
fn between(from: &Target, to: &Target, share: f64) -> Kinematics {
    let [square, cube] = [share * share, share * share * share];
    let along = |axis: usize| {
        let (p, q) = (from.position_m[axis], to.position_m[axis]);
        let (v, w) = (from.velocity_mps[axis], to.velocity_mps[axis]);
        let place = (2.0 * cube - 3.0 * square + 1.0) * p
            + (cube - 2.0 * square + share) * v
            + (3.0 * square - 2.0 * cube) * q
            + (cube - square) * w;
        let speed = (6.0 * square - 6.0 * share) * (p - q)
            + (3.0 * square - 4.0 * share + 1.0) * v
            + (3.0 * square - 2.0 * share) * w;
        [place, speed]
    };
    let axes: [[f64; 2]; 3] = std::array::from_fn(along);
    Kinematics {
        position_m: axes.map(|[place, _]| place),
        velocity_mps: axes.map(|[_, speed]| speed),
    }
}

/// Place after a time along a velocity.
pub(crate) fn moved(place_m: [f64; 3], velocity_mps: [f64; 3], seconds: f64) -> [f64; 3] {
    std::array::from_fn(|axis| place_m[axis] + velocity_mps[axis] * seconds)
}

/// Distance of two places, or of two velocities, in the plane.
pub(crate) fn distance(one: [f64; 3], other: [f64; 3]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_seconds_a_turning_target_is_where_it_is() {
        // A turn of 3 degrees a second at 200 m/s.
        let (speed_mps, turn_radps) = (200.0, 0.0524);
        let at = |time_s: f64| Target {
            address: 7,
            position_m: [
                speed_mps / turn_radps * (turn_radps * time_s).sin(),
                speed_mps / turn_radps * (1.0 - (turn_radps * time_s).cos()),
                1000.0 + 10.0 * time_s,
            ],
            velocity_mps: [
                speed_mps * (turn_radps * time_s).cos(),
                speed_mps * (turn_radps * time_s).sin(),
                10.0,
            ],
            undisturbed: None,
        };
        let mut world = World::new(500);
        for second in 3..6 {
            let (targets, strangers_m) = (vec![at(f64::from(second))], Vec::new());
            world.take(&Second {
                second,
                targets,
                strangers_m,
            });
        }
        for (time_s, limit_m) in [(3.0, 1e-9), (3.5, 0.01), (4.9, 0.01), (5.5, 0.2)] {
            let found = world.target_at(7, 500 + (time_s * 1e9) as i64).expect("known");
            let truth = at(time_s);
            assert!(
                distance(found.position_m, truth.position_m) < limit_m,
                "{time_s}: {found:?}"
            );
            assert!(
                (found.position_m[2] - truth.position_m[2]).abs() < limit_m,
                "{time_s}: {found:?}"
            );
            assert!(
                distance(found.velocity_mps, truth.velocity_mps) < 20.0 * limit_m + 1e-6,
                "{time_s}: {found:?}"
            );
        }
        assert_eq!(world.target_at(7, 0), None, "before the record");
        assert_eq!(world.target_at(8, 4_000_000_500), None, "no such target");
    }
}
