//! Measurement from a look: a position with its covariance.

use estimation::Symmetric3;
use nalgebra::Matrix2;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::sensor_settings::{MeasurementErrors, PlaneErrors};

/// Measured position from the sensor's point of view: the covariance excludes biases.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimulatedMeasurement {
    /// East, north, up, metres.
    pub(crate) position_m: [f64; 3],
    pub(crate) covariance_m2: Symmetric3,
    /// Whether the third component was measured.
    pub(crate) height: bool,
}

impl MeasurementErrors {
    /// Measures an object at `true_position_m` from `site_m`; always draws three random numbers.
    pub(crate) fn measure(
        &self,
        site_m: [f64; 3],
        true_position_m: [f64; 3],
        random: &mut ChaCha8Rng,
    ) -> SimulatedMeasurement {
        let errors: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(random));
        let offset = [0, 1].map(|axis| true_position_m[axis] - site_m[axis]);
        let (plane, r) = self.plane.measure(offset, [errors[0], errors[1]]);
        let sigma = self.height_sigma_m.unwrap_or(0.0);
        let height = if self.height_sigma_m.is_some() {
            true_position_m[2] + sigma * errors[2] + self.bias_m[2]
        } else {
            0.0
        };
        SimulatedMeasurement {
            position_m: [
                site_m[0] + plane[0] + self.bias_m[0],
                site_m[1] + plane[1] + self.bias_m[1],
                height,
            ],
            covariance_m2: [r[(0, 0)], r[(0, 1)], 0.0, r[(1, 1)], 0.0, sigma * sigma],
            height: self.height_sigma_m.is_some(),
        }
    }
}

impl PlaneErrors {
    /// Returns the measured offset from the site, and its covariance, for a true offset and two standard normal
    /// numbers.
    fn measure(&self, [east, north]: [f64; 2], errors: [f64; 2]) -> ([f64; 2], Matrix2<f64>) {
        match *self {
            Self::Cartesian { sigma_m } => (
                [east + sigma_m * errors[0], north + sigma_m * errors[1]],
                Matrix2::identity() * (sigma_m * sigma_m),
            ),
            Self::Polar {
                range_sigma_m,
                azimuth_sigma_rad,
                range_bias_m,
                azimuth_bias_rad,
            } => {
                let range = (east.hypot(north) + range_bias_m + range_sigma_m * errors[0]).max(1.0);
                let azimuth = east.atan2(north) + azimuth_bias_rad + azimuth_sigma_rad * errors[1];
                let (sin, cos) = azimuth.sin_cos();
                let (along, across) = (range_sigma_m.powi(2), (range * azimuth_sigma_rad).powi(2));
                let cross = (along - across) * sin * cos;
                let covariance = Matrix2::new(
                    along * sin * sin + across * cos * cos,
                    cross,
                    cross,
                    along * cos * cos + across * sin * sin,
                );
                ([range * sin, range * cos], covariance)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use estimation::Gaussian;
    use messages::Covariance;

    use super::*;
    use crate::random::{Purpose, stream};

    const POLAR: PlaneErrors = PlaneErrors::Polar {
        range_sigma_m: 50.0,
        azimuth_sigma_rad: 0.0012,
        range_bias_m: 0.0,
        azimuth_bias_rad: 0.0,
    };

    fn errors(plane: PlaneErrors) -> MeasurementErrors {
        MeasurementErrors {
            plane,
            height_sigma_m: Some(15.0),
            bias_m: [0.0; 3],
        }
    }

    /// Normalised squared errors are chi-square with three degrees of freedom: mean 3, variance 6.
    #[test]
    fn errors_are_as_stated() {
        for plane in [POLAR, PlaneErrors::Cartesian { sigma_m: 20.0 }] {
            let errors = errors(plane);
            let (truth, site) = ([70_000.0, -30_000.0, 9000.0], [5000.0, 2000.0, 0.0]);
            let mut random = stream(1, Purpose::Look, 0, 0, 0);
            let (count, mut sum, mut mean) = (20_000, 0.0, [0.0; 3]);
            let exact = Gaussian::new(truth, [0.0; 3], &Covariance::default());
            for _ in 0..count {
                let measured = errors.measure(site, truth, &mut random);
                let squared = exact.squared_distance::<3>(measured.position_m, &measured.covariance_m2);
                sum += squared.expect("positive definite");
                for axis in 0..3 {
                    mean[axis] += (measured.position_m[axis] - truth[axis]) / f64::from(count);
                }
            }
            let average = sum / f64::from(count);
            let four_sigma = 4.0 * (6.0 / f64::from(count)).sqrt();
            assert!((average - 3.0).abs() < four_sigma, "{average}");
            assert!(mean.iter().all(|mean| mean.abs() < 2.5), "no bias: {mean:?}");
        }
    }

    #[test]
    fn biases_shift_by_what_they_say() {
        let plane = PlaneErrors::Polar {
            range_sigma_m: 1e-6,
            azimuth_sigma_rad: 1e-12,
            range_bias_m: 100.0,
            azimuth_bias_rad: 0.001,
        };
        let errors = MeasurementErrors {
            bias_m: [0.0, 7.0, 5.0],
            height_sigma_m: Some(1e-6),
            plane,
        };
        let mut random = stream(1, Purpose::Look, 0, 0, 0);
        // North of the site: range is north, azimuth grows to the east.
        let measured = errors.measure([0.0; 3], [0.0, 50_000.0, 1000.0], &mut random);
        let expected = [50_100.0 * 0.001f64.sin(), 50_100.0 * 0.001f64.cos() + 7.0, 1005.0];
        let close = |axis: usize| (measured.position_m[axis] - expected[axis]).abs() < 1e-3;
        assert!((0..3).all(close), "{measured:?}");
    }
}
