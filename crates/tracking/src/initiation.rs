//! Initiation: the state of a track after the first detection.
//!
//! A single detection gives a position, not a velocity: the velocity starts at zero with the standard deviation of
//! target speeds, and the second detection determines the velocity. A range rate narrows the velocity along the line of
//! sight at once. But boats are ten times slower than aircraft. A common standard deviation either loses aircraft or
//! joins every boat with every detection in a gate of a third of a kilometre after two seconds. A first state therefore
//! consists of a slow and a fast target, and the second detection selects. A direction alone begins no track: the
//! position is only a ray. Two crossing directions may begin a track ([`crate::crossing`]).
//!
//! In the gate of a confirmed track, a new track is probably a target that flew along and now separates; the new
//! track may then start with that track's motion (SP-2, [`crate::splitting`]).

use estimation::Gaussian;
use messages::{Covariance, STATE_LEN};
use observations::DetectionKind;

use crate::measurement::DetectionMeasurement;

settings::words! {
    /// Detections at which tracks start.
    pub enum Starts {
        /// Detections of every sensor.
        Any = "any",
        /// Designations only.
        Designated = "designated",
    }
}

settings::settings! {
    /// Assumptions on a target before its first observation.
    #[derive(Copy)]
    pub struct Initiation {
        /// Expected new targets per expected false detection (HT-8).
        new_target_share: f64 = 0.04, in [1e-6, 1e3];
        /// Standard deviation of the velocity east and north.
        speed_sigma_mps: f64 = 100.0, in [1e-3, 1e4];
        /// Standard deviation of the velocity of slow targets, assumed as frequent as fast targets. Needs
        /// `[motion.manoeuvres]`.
        slow_sigma_mps: Option<f64> = Some(10.0), in [1e-3, 1e4];
        /// Standard deviation of the velocity up.
        climb_sigma_mps: f64 = 10.0, in [1e-3, 1e4];
        /// Standard deviation of the height over the sensor where it is not measured.
        height_sigma_m: f64 = 5000.0, in [1e-3, 1e5];
        /// Longest time between directions of two sensors at whose crossing a track may start; off: directions start
        /// no tracks.
        crossing_s: Option<f64> = None, in [1e-3, 60];
        /// Least number of detections with which directions alone confirm a track that has started at a crossing: until
        /// then, ghosts betray themselves by their motion.
        crossing_detections: u32 = 10, in [2, 1000];
    }
}

/// The state after a first measurement; `None` of a direction alone.
pub(crate) fn first_state(measurement: &DetectionMeasurement, guess: &Initiation) -> Option<Gaussian> {
    let [a, b, c] = measurement.values;
    let [sa, sb, sc, _] = measurement.sigmas;
    let mut state = Gaussian {
        mean: [0.0; STATE_LEN],
        covariance: Covariance::diagonal(
            [sa, sb, guess.height_sigma_m],
            [guess.speed_sigma_mps, guess.speed_sigma_mps, guess.climb_sigma_mps],
        ),
    };
    match measurement.kind {
        DetectionKind::Position2 => state.mean[..2].copy_from_slice(&[a, b]),
        DetectionKind::Position3 => {
            state.mean[..3].copy_from_slice(&[a, b, c]);
            state.covariance.set(2, 2, sc * sc);
        }
        DetectionKind::RangeBearing => {
            let (sin, cos) = b.sin_cos();
            state.mean[..2].copy_from_slice(&[a * sin, a * cos]);
            // Along and across the beam.
            set_position(&mut state, [[sin, cos, 0.0], [cos, -sin, 0.0]], [sa, a * sb]);
        }
        DetectionKind::RangeBearingElevation => {
            let ((sin, cos), (up, ground)) = (b.sin_cos(), c.sin_cos());
            state.mean[..3].copy_from_slice(&[a * ground * sin, a * ground * cos, a * up]);
            let axes = [
                [ground * sin, ground * cos, up],
                [cos, -sin, 0.0],
                [-up * sin, -up * cos, ground],
            ];
            state.covariance.set(2, 2, 0.0);
            set_position(&mut state, axes, [sa, a * ground * sb, a * sc]);
        }
        DetectionKind::Bearing | DetectionKind::BearingElevation => return None,
    }
    if matches!(
        measurement.kind,
        DetectionKind::RangeBearing | DetectionKind::RangeBearingElevation
    ) {
        for (value, platform) in state.mean.iter_mut().zip(measurement.platform_m) {
            *value += platform;
        }
    }
    measurement.update_range_rate(&mut state);
    Some(state)
}

/// Position covariance Σ σ²·u·uᵀ over the axes u; of two axes in the plane the height's variance stays.
fn set_position<const N: usize>(state: &mut Gaussian, axes: [[f64; 3]; N], sigmas: [f64; N]) {
    for row in 0..N {
        for column in row..N {
            let sum = (0..N)
                .map(|k| sigmas[k] * sigmas[k] * axes[k][row] * axes[k][column])
                .sum();
            state.covariance.set(row, column, sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GUESS: Initiation = Initiation {
        new_target_share: 0.04,
        speed_sigma_mps: 150.0,
        slow_sigma_mps: None,
        climb_sigma_mps: 10.0,
        height_sigma_m: 1000.0,
        crossing_s: None,
        crossing_detections: 10,
    };

    fn measurement(kind: DetectionKind, values: [f64; 3], sigmas: [f64; 4]) -> DetectionMeasurement {
        DetectionMeasurement {
            kind,
            values,
            range_rate_mps: None,
            sigmas,
            platform_m: [100.0, 200.0, 50.0],
        }
    }

    /// A measurement at the predicted state has no innovation, and an equal second measurement halves the variances
    /// along the measured axes.
    #[test]
    fn each_kind_begins_where_it_was_seen() {
        for (kind, values, sigmas) in [
            (DetectionKind::Position2, [5e3, -2e3, 0.0], [30.0, 20.0, 0.0, 0.0]),
            (DetectionKind::Position3, [5e3, -2e3, 400.0], [30.0, 20.0, 10.0, 0.0]),
            (DetectionKind::RangeBearing, [5e3, 2.0, 0.0], [30.0, 0.002, 0.0, 0.0]),
            (
                DetectionKind::RangeBearingElevation,
                [5e3, -2.0, 0.3],
                [30.0, 0.002, 0.003, 0.0],
            ),
        ] {
            let measurement = measurement(kind, values, sigmas);
            let state = first_state(&measurement, &GUESS).unwrap();
            assert!(estimation::is_usable(&state.covariance), "{kind:?}");
            let innovation = measurement.innovation(&state).unwrap();
            // Slant range and height are correlated through the guess only where the height is not measured.
            assert!(innovation.squared_distance < 0.01, "{kind:?} {innovation:?}");
            let doubled: f64 = (0..innovation.dimension)
                .map(|k| (2.0 * sigmas[k] * sigmas[k]).ln())
                .sum();
            let expected = -0.5 * doubled - 0.5 * innovation.dimension as f64 * std::f64::consts::TAU.ln();
            assert!((innovation.log_likelihood - expected).abs() < 0.02, "{kind:?}");
        }
    }

    #[test]
    fn directions_begin_nothing() {
        for kind in [DetectionKind::Bearing, DetectionKind::BearingElevation] {
            assert_eq!(first_state(&measurement(kind, [1.0, 0.1, 0.0], [0.1; 4]), &GUESS), None);
        }
    }

    #[test]
    fn a_range_rate_tells_the_velocity_along_the_line_of_sight() {
        let mut measurement = measurement(DetectionKind::RangeBearing, [5e3, 0.0, 0.0], [30.0, 0.002, 0.0, 1.0]);
        measurement.range_rate_mps = Some(-80.0);
        let state = first_state(&measurement, &GUESS).unwrap();
        assert!(
            (state.mean[4] + 80.0).abs() < 0.1 && state.mean[3].abs() < 0.1,
            "{:?}",
            state.mean
        );
        let sigma = |row: usize| state.covariance.get(row, row).sqrt();
        assert!((sigma(4) - 1.0).abs() < 0.1 && sigma(3) > 140.0);
    }
}
