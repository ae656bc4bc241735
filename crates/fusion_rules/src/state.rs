//! A position, a velocity and the covariance of both, extrapolated in time.

use estimation::{AxisNoise, Gaussian};
use messages::{AXES, Covariance, SensorTrack, sensor_track_bits};
use serde::{Deserialize, Serialize};

/// State of a target at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// The time, UTC, nanoseconds.
    pub time_ns: i64,
    /// Position east, north, up, metres.
    pub position_m: [f64; 3],
    /// Velocity east, north, up, metres per second.
    pub velocity_mps: [f64; 3],
    /// Covariance of position and velocity.
    pub covariance: Covariance,
    /// Whether `position_m[2]` was observed.
    pub has_height: bool,
}

impl State {
    /// State of a report.
    #[inline]
    pub fn of_report(report: &SensorTrack) -> Self {
        Self {
            time_ns: report.time_of_measurement_ns,
            position_m: report.position_m,
            velocity_mps: report.velocity_mps,
            covariance: report.covariance,
            has_height: report.has(sensor_track_bits::HEIGHT),
        }
    }

    /// State of an estimate at its time.
    #[inline]
    pub fn of_estimate(time_ns: i64, estimate: &Gaussian, has_height: bool) -> Self {
        Self {
            time_ns,
            position_m: estimate.position_m(),
            velocity_mps: estimate.velocity_mps(),
            covariance: estimate.covariance,
            has_height,
        }
    }

    /// This state at `time_ns`: uniform straight motion, with white-noise acceleration of the given spectral density.
    #[inline]
    pub fn at(&self, time_ns: i64, process_noise_m2ps3: f64) -> Self {
        let ns = time_ns - self.time_ns;
        if ns == 0 {
            return *self;
        }
        let seconds = ns as f64 / messages::NS_PER_S;
        let noise = [AxisNoise::white(process_noise_m2ps3, seconds); AXES];
        let now = Gaussian::new(self.position_m, self.velocity_mps, &self.covariance);
        Self::of_estimate(time_ns, &now.moved(seconds, noise), self.has_height)
    }

    /// Sum of the position variances over east and north, m², for comparisons of traces (TI-16).
    #[inline]
    pub fn horizontal_trace_m2(&self) -> f64 {
        self.covariance.get(0, 0) + self.covariance.get(1, 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn carrying_moves_along_the_velocity_and_grows_the_covariance() {
        let mut covariance = Covariance::diagonal([2.0; 3], [1.0; 3]);
        covariance.set(0, 1, 1.2);
        let state = State {
            position_m: [10.0, 20.0, 30.0],
            velocity_mps: [1.0, 2.0, 3.0],
            covariance,
            ..State::default()
        };
        let later = state.at(2_000_000_000, 3.0);
        assert_eq!(later.position_m, [12.0, 24.0, 36.0]);
        // P + dt² Pv + q dt³/3 = 4 + 4 + 8; cross: dt Pv + q dt²/2 = 2 + 6; velocity: 1 + q dt = 7.
        assert!((later.covariance.get(0, 0) - 16.0).abs() < 1e-12);
        assert!((later.covariance.get(0, 3) - 8.0).abs() < 1e-12);
        assert!((later.covariance.get(3, 3) - 7.0).abs() < 1e-12);
        assert!((later.covariance.get(0, 1) - 1.2).abs() < 1e-12);
    }
}
