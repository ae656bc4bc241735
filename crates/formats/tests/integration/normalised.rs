//! Normalised errors: as large as stated, if their mean is 1.

use observations::{Quality, RADIUS95_SIGMAS};
use test_support::Random;

/// A number of the standard normal distribution, by the method of Box and Muller.
pub(crate) fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.unit()).cos()
}

/// Mean of eᵀ P⁻¹ e / 2, where P is the stated covariance of the errors e of two components: 1, if P is right.
#[derive(Debug, Default)]
pub(crate) struct Nees {
    sum: f64,
    count: u32,
}

impl Nees {
    /// Takes an error with its stated covariance (xx, xy, yy).
    pub(crate) fn take(&mut self, [x, y]: [f64; 2], [xx, xy, yy]: [f64; 3]) {
        let determinant = xx * yy - xy * xy;
        self.sum += (x * x * yy - 2.0 * x * y * xy + y * y * xx) / determinant / 2.0;
        self.count += 1;
    }

    /// Takes an error of position, metres, with the stated quality.
    pub(crate) fn take_quality(&mut self, error_m: [f64; 2], quality: Quality) {
        let covariance = match quality {
            Quality::Covariance(covariance) => covariance,
            Quality::Radius95(radius_m) => [
                (radius_m / RADIUS95_SIGMAS).powi(2),
                0.0,
                (radius_m / RADIUS95_SIGMAS).powi(2),
            ],
            other => panic!("{other:?}"),
        };
        self.take(error_m, covariance);
    }

    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    pub(crate) fn mean(&self) -> f64 {
        self.sum / f64::from(self.count)
    }
}
