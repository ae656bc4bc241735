//! Prediction: nearly constant velocity.
//!
//! A target flies straight until a manoeuvre. The model lets the velocity drift by a white-noise acceleration of
//! spectral density q (m²/s³): over T seconds the velocity's variance grows by q·T. Large q follows turns, small q
//! smooths; a common choice is √(q·T) between half and all of the change of speed that one period T can bring.
//!
//! Two discretisations are in use, and published figures are only reproduced with the original discretisation:
//!
//! - *white* ([`AxisNoise::white`]): acceleration is white in continuous time. The covariance composes: two steps of a
//!   and b seconds equal a single step of a + b, so the result does not depend on how often reports happen to come. Use
//!   this discretisation where reports of several sensors arrive at any time (Bar-Shalom et al. 2001, section 6.2.2).
//! - *piecewise constant* ([`AxisNoise::piecewise_constant`]): acceleration is constant within each period and
//!   independent of the next. Steady-state tables over the manoeuvring index are made with this discretisation (section
//!   6.3.2).
//!
//! Limit: a single density for all times. A target that alternates between long legs and hard turns is served better by
//! several models in parallel (IMM).

use messages::AXES;
use serde::{Deserialize, Serialize};

use crate::gaussian::{Gaussian, at};

/// Covariance that an axis gains between two times: of position, of position with velocity, of velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisNoise {
    /// Gain in position variance, m².
    pub position_m2: f64,
    /// Gain in the covariance of position with velocity, m²/s.
    pub cross_m2ps: f64,
    /// Gain in velocity variance, m²/s².
    pub velocity_m2ps2: f64,
}

impl AxisNoise {
    /// Noise of a white-noise acceleration of density `density_m2ps3` over `duration_s` seconds.
    ///
    /// A negative duration (bringing a state to an earlier time) adds noise too: the sign goes into the cross term.
    pub fn white(density_m2ps3: f64, duration_s: f64) -> Self {
        let (q, t) = (density_m2ps3, duration_s);
        Self {
            position_m2: q * t.abs() * t * t / 3.0,
            cross_m2ps: q * t.abs() * t / 2.0,
            velocity_m2ps2: q * t.abs(),
        }
    }

    /// Noise of an acceleration that is constant over the `duration_s` seconds, with standard deviation `sigma_mps2`.
    pub fn piecewise_constant(sigma_mps2: f64, duration_s: f64) -> Self {
        let (variance, t) = (sigma_mps2 * sigma_mps2, duration_s);
        Self {
            position_m2: variance * t * t * t * t / 4.0,
            cross_m2ps: variance * t * t * t / 2.0,
            velocity_m2ps2: variance * t * t,
        }
    }
}

/// The motion model: constant velocity, disturbed by a white-noise acceleration per axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NearlyConstantVelocity {
    /// Spectral density of the acceleration east, north, up, m²/s³.
    pub density_m2ps3: [f64; AXES],
}

impl NearlyConstantVelocity {
    /// A density for east and north, another for up.
    pub fn new(horizontal_density_m2ps3: f64, vertical_density_m2ps3: f64) -> Self {
        Self {
            density_m2ps3: [
                horizontal_density_m2ps3,
                horizontal_density_m2ps3,
                vertical_density_m2ps3,
            ],
        }
    }

    /// `gaussian` brought to a time `duration_s` seconds later (negative: earlier, with added uncertainty too).
    #[must_use]
    pub fn predicted(&self, gaussian: &Gaussian, duration_s: f64) -> Gaussian {
        let noise = self.density_m2ps3.map(|density| AxisNoise::white(density, duration_s));
        gaussian.moved(duration_s, noise)
    }
}

impl Gaussian {
    /// Moved along the velocity for `duration_s` seconds: F·x and F·P·Fᵀ + Q, Q being `noise` per axis.
    #[must_use]
    pub fn moved(&self, duration_s: f64, noise: [AxisNoise; AXES]) -> Self {
        let mut moved = *self;
        moved.advance(duration_s, noise);
        moved
    }

    /// [`Self::moved`] in place.
    pub fn advance(&mut self, duration_s: f64, noise: [AxisNoise; AXES]) {
        let t = duration_s;
        let p = &mut self.covariance.upper;
        for row in 0..AXES {
            self.mean[row] += t * self.mean[row + AXES];
            for column in row..AXES {
                // Each element is read before being written: a pair of axes touches no other pair's.
                let velocity = p[at(row + AXES, column + AXES)];
                let (cross, mirrored) = (p[at(row, column + AXES)], p[at(column, row + AXES)]);
                p[at(row, column)] = p[at(row, column)] + t * (cross + mirrored) + t * t * velocity;
                p[at(row, column + AXES)] = cross + t * velocity;
                p[at(column, row + AXES)] = mirrored + t * velocity;
            }
        }
        for (axis, noise) in noise.iter().enumerate() {
            p[at(axis, axis)] += noise.position_m2;
            p[at(axis, axis + AXES)] += noise.cross_m2ps;
            p[at(axis + AXES, axis + AXES)] += noise.velocity_m2ps2;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::definite::is_usable;
    use crate::gaussian::{Matrix6, Vector6, packed, unpacked};
    use crate::testing::{any_gaussian, assert_close};

    #[test]
    fn equals_the_matrix_form() {
        let (t, model) = (2.5, NearlyConstantVelocity::new(3.0, 0.5));
        let mean = Vector6::from_fn(|row, _| row as f64 - 2.0);
        let covariance = Matrix6::from_fn(|row, column| {
            if row == column {
                9.0
            } else {
                1.0 / (row + column) as f64
            }
        });
        let gaussian = Gaussian {
            mean: mean.into(),
            covariance: packed(&covariance),
        };
        let mut transition = Matrix6::identity();
        let mut noise = Matrix6::zeros();
        for axis in 0..AXES {
            transition[(axis, axis + AXES)] = t;
            let q = model.density_m2ps3[axis];
            noise[(axis, axis)] = q * t * t * t / 3.0;
            noise[(axis, axis + AXES)] = q * t * t / 2.0;
            noise[(axis + AXES, axis)] = q * t * t / 2.0;
            noise[(axis + AXES, axis + AXES)] = q * t;
        }
        let predicted = model.predicted(&gaussian, t);
        assert!((Vector6::from(predicted.mean) - transition * mean).amax() < 1e-12);
        let expected = transition * covariance * transition.transpose() + noise;
        assert!((unpacked(&predicted.covariance) - expected).amax() < 1e-12);
    }

    proptest! {
        #[test]
        fn two_steps_equal_one(gaussian in any_gaussian(), a in 0.0..30.0f64, b in 0.0..30.0f64, q in 0.0..50.0f64) {
            let model = NearlyConstantVelocity::new(q, q / 10.0);
            assert_close(
                &model.predicted(&model.predicted(&gaussian, a), b),
                &model.predicted(&gaussian, a + b),
            );
        }

        #[test]
        fn covariance_stays_positive_definite(gaussian in any_gaussian(), t in -20.0..20.0f64, q in 0.0..50.0f64) {
            let predicted = NearlyConstantVelocity::new(q, q / 10.0).predicted(&gaussian, t);
            prop_assert!(is_usable(&predicted.covariance));
        }
    }
}
