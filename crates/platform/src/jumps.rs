//! Jumps of a platform's states: values that no motion explains.
//!
//! A receiver that loses satellites, a compass that is adjusted, or two instruments that answer in turn make a state
//! jump. Detections carried with such a state are displaced all together. A state is compared with the prediction from
//! the two states before, so that a steady turn or roll is no jump.

use crate::history::shorter_arc;
use crate::state::State;

const NS_PER_S: f64 = 1e9;

settings::settings! {
    /// Differences from the prediction by the states before that count as jumps.
    #[derive(Copy)]
    pub struct JumpLimits {
        /// Of the position.
        position_m: f64 = 100.0, in [0.1, 1e5];
        /// Of the velocity over ground, and so of the course.
        velocity_mps: f64 = 10.0, in [0.1, 1e3];
        /// Of heading, pitch and roll.
        attitude_deg: settings::Degrees = settings::Degrees::of(15.0), in [0.1, 180];
    }
}

/// Quantity that jumped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jump {
    /// The position.
    Position,
    /// The velocity over ground.
    Velocity,
    /// Heading, pitch or roll.
    Attitude,
}

/// Watches the states of a platform for jumps.
#[derive(Clone, Copy, Debug)]
pub struct JumpWatch {
    limits: JumpLimits,
    /// Longest time between states that are compared, nanoseconds.
    over_max_ns: i64,
    position: Line<3>,
    velocity: Option<(i64, [f64; 3])>,
    heading: Line<1>,
    tilt: Line<2>,
}

/// The latest value with the rate.
#[derive(Clone, Copy, Debug)]
struct Line<const N: usize> {
    latest: Option<(i64, [f64; N])>,
    rate: Option<[f64; N]>,
}

impl<const N: usize> Line<N> {
    const NONE: Self = Self {
        latest: None,
        rate: None,
    };

    /// Takes a value; returns the differences from the prediction, if any.
    fn take(
        &mut self,
        time_ns: i64,
        value: [f64; N],
        over_max_ns: i64,
        difference: impl Fn(f64, f64) -> f64,
    ) -> Option<[f64; N]> {
        let Some((before_ns, before)) = self.latest else {
            self.latest = Some((time_ns, value));
            return None;
        };
        let over_ns = time_ns.saturating_sub(before_ns);
        if over_ns <= 0 {
            return None;
        }
        self.latest = Some((time_ns, value));
        if over_ns > over_max_ns {
            self.rate = None;
            return None;
        }
        let over_s = over_ns as f64 / NS_PER_S;
        let moved: [f64; N] = std::array::from_fn(|place| difference(before[place], value[place]));
        let predicted = self.rate.replace(moved.map(|moved| moved / over_s));
        predicted.map(|rate| std::array::from_fn(|place| moved[place] - rate[place] * over_s))
    }
}

impl JumpWatch {
    /// Watches with these limits; states farther apart than `over_max_ns` are not compared.
    pub fn new(limits: JumpLimits, over_max_ns: i64) -> Self {
        Self {
            limits,
            over_max_ns,
            position: Line::NONE,
            velocity: None,
            heading: Line::NONE,
            tilt: Line::NONE,
        }
    }

    /// Takes a state; returns the first quantity that jumped.
    pub fn take(&mut self, state: &State) -> Option<Jump> {
        let (time_ns, over_max_ns) = (state.time_ns, self.over_max_ns);
        let plain = |before: f64, after: f64| after - before;
        let moved = state
            .position_m
            .and_then(|position| self.position.take(time_ns, position, over_max_ns, plain));
        let faster = state.velocity_mps.and_then(|velocity| {
            let (before_ns, before) = self.velocity.replace((time_ns, velocity))?;
            let is_near = (1..=over_max_ns).contains(&time_ns.saturating_sub(before_ns));
            is_near.then(|| std::array::from_fn(|axis| velocity[axis] - before[axis]))
        });
        let turned = state
            .heading_rad
            .and_then(|heading| self.heading.take(time_ns, [heading], over_max_ns, shorter_arc));
        let tilted = state
            .tilt_rad
            .and_then(|tilt| self.tilt.take(time_ns, tilt, over_max_ns, shorter_arc));
        let angle = |angle: &f64| angle.abs() > self.limits.attitude_deg.rad();
        if moved.is_some_and(|moved| length(moved) > self.limits.position_m) {
            return Some(Jump::Position);
        }
        if faster.is_some_and(|faster| length(faster) > self.limits.velocity_mps) {
            return Some(Jump::Velocity);
        }
        let jumped = turned.is_some_and(|turned| turned.iter().any(angle))
            || tilted.is_some_and(|tilted| tilted.iter().any(angle));
        jumped.then_some(Jump::Attitude)
    }
}

fn length(vector: [f64; 3]) -> f64 {
    vector.iter().map(|value| value * value).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    fn watch() -> JumpWatch {
        JumpWatch::new(JumpLimits::default(), 2 * S)
    }

    fn at(time_ns: i64, position: [f64; 3], heading_deg: f64, roll_deg: f64) -> State {
        State {
            time_ns,
            position_m: Some(position),
            velocity_mps: Some([8.0, 0.0, 0.0]),
            heading_rad: Some(heading_deg.to_radians()),
            tilt_rad: Some([0.0, roll_deg.to_radians()]),
            ..State::default()
        }
    }

    #[test]
    fn a_fast_vessel_that_turns_and_rolls_does_not_jump() {
        let mut watch = watch();
        for step in 0..600 {
            let time_s = 0.5 * f64::from(step);
            let roll = 10.0 * (time_s * std::f64::consts::TAU / 10.0).sin();
            let state = at((time_s * 1e9) as i64, [500.0 * time_s, 0.0, 0.0], 20.0 * time_s, roll);
            assert_eq!(watch.take(&state), None, "{step}");
        }
    }

    #[test]
    fn each_quantity_that_jumps_is_named_once() {
        let mut watch = watch();
        let place = |time_s: i64, off: f64| [8.0 * time_s as f64 + off, 0.0, 0.0];
        for time_s in 0..5 {
            assert_eq!(watch.take(&at(time_s * S, place(time_s, 0.0), 350.0, 0.0)), None);
        }
        assert_eq!(
            watch.take(&at(5 * S, place(5, 300.0), 350.0, 0.0)),
            Some(Jump::Position)
        );
        // After a gap, there is nothing to compare with.
        assert_eq!(watch.take(&at(20 * S, place(20, 9e3), 100.0, 0.0)), None);
        assert_eq!(watch.take(&at(21 * S, place(21, 9e3), 100.0, 0.0)), None);
        assert_eq!(
            watch.take(&at(22 * S, place(22, 9e3), 130.0, 0.0)),
            Some(Jump::Attitude)
        );
        let faster = State {
            time_ns: 23 * S,
            velocity_mps: Some([-8.0, 0.0, 0.0]),
            ..State::default()
        };
        assert_eq!(watch.take(&faster), Some(Jump::Velocity));
    }

    #[test]
    fn a_stated_limit_of_angles_holds() {
        let jumps = |attitude_deg: f64| {
            let limits = JumpLimits {
                attitude_deg: settings::Degrees::of(attitude_deg),
                ..JumpLimits::default()
            };
            let mut watch = JumpWatch::new(limits, 2 * S);
            let state = |time_s: i64| {
                at(
                    time_s * S,
                    [8.0 * time_s as f64, 0.0, 0.0],
                    0.0,
                    if time_s == 5 { 10.0 } else { 0.0 },
                )
            };
            let jumped: Vec<Jump> = (0..6).filter_map(|time_s| watch.take(&state(time_s))).collect();
            jumped
        };
        assert_eq!((jumps(5.0), jumps(15.0)), (vec![Jump::Attitude], Vec::new()));
    }
}
