//! Track of one target in a sensor: a filter and a life cycle.
//!
//! The first hit starts a tentative track; further hits confirm the track. A confirmed track without a hit coasts;
//! too many misses in a row terminate the track. The sensor reports the termination once, and assigns a new number
//! if the target returns.

use estimation::Gaussian;
use messages::TrackState;

use crate::measurement::SimulatedMeasurement;
use crate::sensor_settings::SensorTracker;

/// Track in a sensor, see the module's documentation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalTrack {
    pub(crate) number: u32,
    pub(crate) gaussian: Gaussian,
    pub(crate) state: TrackState,
    /// Looks with a detection since the start of the track.
    pub(crate) hits: u32,
    /// Consecutive looks without a detection, up to the latest.
    misses: u32,
    time_s: f64,
}

impl LocalTrack {
    pub(crate) fn new(number: u32, time_s: f64, first: &SimulatedMeasurement, tracking: &SensorTracker) -> Self {
        let velocity = tracking.first_velocity;
        let gaussian = if first.height {
            Gaussian::from_first_position::<3>(first.position_m, &first.covariance_m2, velocity)
        } else {
            Gaussian::from_first_position::<2>(first.position_m, &first.covariance_m2, velocity)
        };
        Self {
            number,
            gaussian,
            state: if tracking.confirming_hits <= 1 {
                TrackState::Confirmed
            } else {
                TrackState::Tentative
            },
            hits: 1,
            misses: 0,
            time_s,
        }
    }

    /// Predicts the track to the time of a look and updates it with the result.
    pub(crate) fn look(&mut self, time_s: f64, found: Option<&SimulatedMeasurement>, tracking: &SensorTracker) {
        self.gaussian = tracking.motion.predicted(&self.gaussian, time_s - self.time_s);
        self.time_s = time_s;
        match found {
            Some(measurement) => {
                self.update(measurement, tracking);
                self.hits += 1;
                self.misses = 0;
                if self.hits >= tracking.confirming_hits {
                    self.state = TrackState::Confirmed;
                }
            }
            None => {
                self.misses += 1;
                let (misses_max, otherwise) = match self.state {
                    TrackState::Tentative => (tracking.misses_max_tentative, TrackState::Tentative),
                    _ => (tracking.misses_max, TrackState::Coasted),
                };
                self.state = if self.misses >= misses_max {
                    TrackState::Terminated
                } else {
                    otherwise
                };
            }
        }
    }

    fn update(&mut self, measurement: &SimulatedMeasurement, tracking: &SensorTracker) {
        let (position_m, r) = (measurement.position_m, &measurement.covariance_m2);
        let updated = if measurement.height {
            self.gaussian.update_position::<3>(position_m, r).is_some()
        } else {
            self.gaussian.forget_height(tracking.first_velocity);
            self.gaussian.update_position::<2>(position_m, r).is_some()
        };
        debug_assert!(updated, "simulated covariances are positive definite");
    }

    /// Whether the velocity is based on more than its prior.
    pub(crate) fn has_velocity(&self) -> bool {
        self.hits >= 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor_settings::{SensorKind, SensorSettings};

    #[test]
    fn life_cycle() {
        use TrackState::*;
        let tracking = SensorSettings::new(SensorKind::Radar)
            .checked()
            .expect("usable")
            .tracking;
        let follow = |looks: &str| states(looks, &tracking);
        assert_eq!(
            follow("xx-x---"),
            [
                Tentative, Tentative, Confirmed, Coasted, Confirmed, Coasted, Coasted, Terminated
            ]
        );
        assert_eq!(follow("-x-x"), [Tentative, Tentative, Tentative, Tentative, Confirmed]);
        assert_eq!(follow("--"), [Tentative, Tentative, Terminated]);
    }

    #[test]
    fn keys_set_the_hits_to_a_confirmation_and_the_misses_to_an_end() {
        use TrackState::*;
        let settings = SensorSettings {
            confirming_hits: Some(2),
            misses_max_tentative: Some(1),
            misses_max: Some(4),
            ..SensorSettings::new(SensorKind::Radar)
        };
        let tracking = settings.checked().expect("usable").tracking;
        let confirmed = [Tentative, Confirmed, Coasted, Coasted, Coasted, Terminated];
        assert_eq!(states("x----", &tracking), confirmed);
        assert_eq!(states("-", &tracking), [Tentative, Terminated]);
    }

    /// Returns the states of a track after its first hit and after each further look; `x` is a hit.
    fn states(looks: &str, tracking: &SensorTracker) -> Vec<TrackState> {
        let measurement = SimulatedMeasurement {
            position_m: [0.0; 3],
            covariance_m2: [1.0, 0.0, 0.0, 1.0, 0.0, 1.0],
            height: true,
        };
        let mut track = LocalTrack::new(1, 0.0, &measurement, tracking);
        let mut states = vec![track.state];
        for (index, look) in looks.chars().enumerate() {
            let found = (look == 'x').then_some(&measurement);
            track.look(4.0 * (index + 1) as f64, found, tracking);
            states.push(track.state);
        }
        states
    }
}
