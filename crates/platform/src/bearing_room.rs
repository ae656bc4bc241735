//! Bearings of a direction finder on board that wait for the states of its platform (EL-2, EL-11).
//!
//! A bearing from the bow becomes one from north, from the place of the antennas, with the errors of position, heading
//! and attitude added to its variance. It waits for the state after its time as detections do ([`WaitingRoom`]).
//! Errors of the attitude that persist from bearing to bearing count as with detections: the locator takes
//! successive errors as independent.
//!
//! [`WaitingRoom`]: crate::WaitingRoom

use std::collections::VecDeque;

use frames::SystemFrame;
use observations::Bearing;

use crate::carried::Refusal;
use crate::history::History;
use crate::mount::Mount;
use crate::persistence::{LookInterval, variance_factor};
use crate::pose::{NoState, Pose};
use crate::waiting::WaitingCounts;

/// Bearings of one finder that wait, each with what came with it.
#[derive(Clone, Debug)]
pub struct BearingRoom<T> {
    mount: Mount,
    wait_ns: i64,
    waiting: VecDeque<(Bearing, T)>,
    waiting_max: usize,
    /// Latest time of the finder's data, nanoseconds.
    reached_ns: i64,
    looks: LookInterval,
    counts: WaitingCounts,
}

impl<T> BearingRoom<T> {
    /// Makes a room for `waiting_max` bearings of a finder, whose data run ahead of the platform's states by at most
    /// `wait_ns`.
    pub fn new(mount: Mount, wait_ns: i64, waiting_max: usize) -> Self {
        Self {
            mount,
            wait_ns,
            waiting: VecDeque::with_capacity(waiting_max),
            waiting_max,
            reached_ns: i64::MIN,
            looks: LookInterval::default(),
            counts: WaitingCounts::default(),
        }
    }

    /// Takes a bearing from the bow. A bearing without room is refused and counted.
    pub fn take(&mut self, bearing: Bearing, with_it: T) {
        if bearing.time_of_measurement_ns > self.reached_ns {
            self.reached_ns = bearing.time_of_measurement_ns;
            // Bearings of one time are one look of the finder.
            self.looks.turned(self.reached_ns);
        }
        match self.waiting.len() < self.waiting_max {
            true => self.waiting.push_back((bearing, with_it)),
            false => self.counts.count(Refusal::Full),
        }
    }

    /// The next bearing from north that need not wait any longer; `None` if the first one must wait. Refused bearings
    /// are counted and passed over.
    pub fn next(&mut self, history: &History, frame: Option<&SystemFrame>) -> Option<(Bearing, T)> {
        loop {
            let (bearing, _) = self.waiting.front()?;
            let time_ns = bearing.time_of_measurement_ns;
            let pose = history.at(time_ns).map_err(Refusal::Position);
            let pose = pose.map(|pose| self.persisting(pose, history));
            let carried = pose.and_then(|pose| self.mount.carry_bearing(bearing, &pose, frame));
            let may_come = matches!(
                carried,
                Err(Refusal::Position(state) | Refusal::Heading(state) | Refusal::Tilt(state))
                    if matches!(state, NoState::NotYet | NoState::None)
            );
            if may_come && self.reached_ns.saturating_sub(time_ns) <= self.wait_ns {
                return None;
            }
            let (_, with_it) = self.waiting.pop_front()?;
            match carried {
                Ok(carried) => {
                    self.counts.carried += 1;
                    return Some((carried, with_it));
                }
                Err(refusal) => self.counts.count(refusal),
            }
        }
    }

    /// Numbers of bearings by what became of them.
    pub fn counts(&self) -> &WaitingCounts {
        &self.counts
    }

    /// The pose with standard deviations for errors that persist from bearing to bearing.
    fn persisting(&self, pose: Pose, history: &History) -> Pose {
        let correlation_s = history.assumed().attitude_correlation_s.s();
        match variance_factor(self.looks.s(), correlation_s) {
            1.0 => pose,
            factor => pose.with_angle_sigmas(factor.sqrt()),
        }
    }
}

#[cfg(test)]
mod tests {
    use settings::Degrees;

    use super::*;
    use crate::{Assumed, State};

    fn bearing(second: i64) -> Bearing {
        Bearing {
            time_of_measurement_ns: second * 1_000_000_000,
            emitter_id: None,
            bearing_rad: 0.5,
            sigma_rad: 0.03,
            platform_m: [0.0; 3],
            heading_rad: None,
            frequency_hz: None,
            pulse_interval_s: None,
        }
    }

    fn state(second: i64) -> State {
        State {
            time_ns: second * 1_000_000_000,
            position_m: Some([10.0 * second as f64, 0.0, 0.0]),
            heading_rad: Some(1.0 + 0.1 * second as f64),
            heading_sigma_rad: Some(0.04),
            tilt_rad: Some([0.0; 2]),
            tilt_sigmas_rad: Some([1e-6; 2]),
            ..State::default()
        }
    }

    fn assumed() -> Assumed {
        Assumed {
            angular_acceleration_degps2: Degrees::of(0.0),
            ..Assumed::default()
        }
    }

    #[test]
    fn a_bearing_waits_for_the_state_after_it_and_gets_the_variance_of_the_heading() {
        let mut history = History::new(assumed(), 8);
        let mount = Mount {
            mounting_deg: [Degrees::of(90.0), Degrees::of(0.0), Degrees::of(0.0)],
            ..Mount::default()
        };
        let mut room = BearingRoom::new(mount, 2_000_000_000, 3);
        history.add(&state(0));
        room.take(bearing(1), 7);
        assert_eq!(room.next(&history, None), None);
        history.add(&state(2));
        let (found, with_it) = room.next(&history, None).unwrap();
        // Halfway between headings of 1.0 and 1.2, and a right angle by the mounting.
        let expected = 0.5 + 1.1 + std::f64::consts::FRAC_PI_2;
        assert!((found.bearing_rad - expected).abs() < 1e-6, "{}", found.bearing_rad);
        assert!((found.sigma_rad - 0.05).abs() < 1e-3, "{}", found.sigma_rad);
        assert!((found.platform_m[0] - 10.0).abs() < 1e-9 && with_it == 7);
        assert!((found.heading_rad.unwrap() - 1.1).abs() < 1e-9);
    }

    #[test]
    fn bearings_without_a_state_or_a_room_are_counted() {
        let mut history = History::new(assumed(), 8);
        history.add(&state(0));
        let mut room = BearingRoom::new(Mount::default(), 2_000_000_000, 2);
        for second in 1..=3 {
            room.take(bearing(second), ());
        }
        assert_eq!(room.counts().full, 1);
        assert_eq!(room.next(&history, None), None);
        room.take(bearing(6), ());
        assert_eq!(room.next(&history, None), None);
        assert_eq!(room.counts().no_state, 2);
    }

    #[test]
    fn an_error_of_the_heading_that_persists_counts_more() {
        let correlated = Assumed {
            attitude_correlation_s: settings::Seconds::of(20.0),
            ..assumed()
        };
        let mut history = History::new(correlated, 16);
        let mut room = BearingRoom::new(Mount::default(), 2_000_000_000, 16);
        for second in 0..=9 {
            history.add(&state(second));
            room.take(bearing(second), ());
        }
        let mut sigmas = std::iter::from_fn(|| room.next(&history, None)).map(|(bearing, ())| bearing.sigma_rad);
        let last = sigmas.nth(8).unwrap();
        // tanh(1/40): the variance of 0.04 rad counts forty times.
        assert!(
            (last - (0.03_f64.powi(2) + 40.0 * 0.04_f64.powi(2)).sqrt()).abs() < 2e-3,
            "{last}"
        );
    }
}
