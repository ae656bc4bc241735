//! Bearings of a direction finder on board that wait for the states of the platform (EL-2, EL-11).
//!
//! A bearing from the bow becomes a bearing from north, from the place of the antennas, with the errors of position,
//! heading and attitude added to the variance. The bearing waits for the state after its time as detections do
//! ([`WaitingRoom`]). Errors of the attitude that persist from bearing to bearing count as with detections: the locator
//! takes successive errors as independent.
//!
//! [`WaitingRoom`]: crate::WaitingRoom

use frames::SystemFrame;
use observations::Bearing;

use crate::history::History;
use crate::mount::Mount;
use crate::state_queue::{StateQueue, WaitingCounts};

/// Bearings of a finder that wait, each with the attached data.
#[derive(Clone, Debug)]
pub struct BearingRoom<T> {
    mount: Mount,
    queue: StateQueue<Bearing, T>,
}

impl<T> BearingRoom<T> {
    /// Makes a room for `waiting_max` bearings of a finder, with data ahead of the platform's states by at most
    /// `wait_ns`.
    pub fn new(mount: Mount, wait_ns: i64, waiting_max: usize) -> Self {
        Self {
            mount,
            queue: StateQueue::new(wait_ns, waiting_max),
        }
    }

    /// Takes a bearing from the bow. A bearing without room is refused and counted.
    pub fn take(&mut self, bearing: Bearing, with_it: T) {
        let time_ns = bearing.time_of_measurement_ns;
        if time_ns > self.queue.reached_ns {
            self.queue.reached_ns = time_ns;
            // Bearings of the same time are a single look of the finder.
            self.queue.looks.turned(time_ns);
        }
        self.queue.push(time_ns, bearing, with_it);
    }

    /// The next bearing from north that need not wait any longer; `None` if the first bearing must wait. Refused
    /// bearings are counted and passed over.
    pub fn next(&mut self, history: &History, frame: Option<&SystemFrame>) -> Option<(Bearing, T)> {
        loop {
            let mount = &self.mount;
            let carry = |bearing: &Bearing, pose: &_| mount.carry_bearing(bearing, pose, frame);
            let (carried, _, with_it) = self.queue.next(history, carry)?;
            if let Ok(carried) = carried {
                return Some((carried, with_it));
            }
        }
    }

    /// Numbers of bearings by outcome.
    pub fn counts(&self) -> &WaitingCounts {
        &self.queue.counts
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
