//! A state of the vertical alone: height and rate of climb.

/// Height and rate of climb at one time, as far as they are known.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Vertical {
    /// Expected height and rate of climb, m and m/s.
    pub mean: [f64; 2],
    /// Their covariance: variance of the height, m², covariance, m²/s, variance of the rate, m²/s².
    pub covariance: [f64; 3],
}

impl Vertical {
    /// Nearly constant rate for `duration_s` seconds, with a white acceleration of density `density_m2ps3`.
    #[inline]
    pub fn advance(&mut self, duration_s: f64, density_m2ps3: f64) {
        let t = duration_s;
        let gained = density_m2ps3 * t.abs();
        let [height, cross, rate] = &mut self.covariance;
        self.mean[0] += t * self.mean[1];
        *height += t * (2.0 * *cross + t * *rate) + gained * t * t / 3.0;
        *cross += t * *rate + 0.5 * gained * t;
        *rate += gained;
    }

    /// Updates with a measured height. Returns the residual's squared length and variance; `None`, and no change, if
    /// the variance is not positive or a value not finite.
    #[inline]
    pub fn update(&mut self, measured_m: f64, variance_m2: f64) -> Option<(f64, f64)> {
        let [height, cross, _] = self.covariance;
        let (variance, residual) = (height + variance_m2, measured_m - self.mean[0]);
        let inverse = 1.0 / variance;
        let squared = residual * residual * inverse;
        if variance <= 0.0 || !squared.is_finite() {
            return None;
        }
        let gain = [height * inverse, cross * inverse];
        self.mean[0] += gain[0] * residual;
        self.mean[1] += gain[1] * residual;
        // (1 − K)·P = P·R/S keeps the sign of the variance.
        self.covariance[0] = height * variance_m2 * inverse;
        self.covariance[1] = cross * variance_m2 * inverse;
        self.covariance[2] -= gain[1] * cross;
        Some((squared, variance))
    }

    /// Mixture of states with weights that sum to 1.
    #[inline]
    pub fn mixture<const N: usize>(states: &[Self; N], weights: [f64; N]) -> Self {
        let about = states[0].mean;
        let (mut first, mut second) = ([0.0; 2], [0.0; 3]);
        for (state, weight) in states.iter().zip(weights) {
            let d = [state.mean[0] - about[0], state.mean[1] - about[1]];
            first[0] += weight * d[0];
            first[1] += weight * d[1];
            second[0] += weight * (state.covariance[0] + d[0] * d[0]);
            second[1] += weight * (state.covariance[1] + d[0] * d[1]);
            second[2] += weight * (state.covariance[2] + d[1] * d[1]);
        }
        Self {
            mean: [about[0] + first[0], about[1] + first[1]],
            covariance: [
                second[0] - first[0] * first[0],
                second[1] - first[0] * first[1],
                second[2] - first[1] * first[1],
            ],
        }
    }
}
