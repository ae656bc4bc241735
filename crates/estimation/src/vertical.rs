//! A state of the vertical alone: height and rate of climb.

/// Height and rate of climb at a single time, as far as known.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Vertical {
    /// Expected height and rate of climb, m and m/s.
    pub mean: [f64; 2],
    /// Covariance of both: variance of the height, m², covariance, m²/s, variance of the rate, m²/s².
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::AxisNoise;
    use crate::gaussian::Gaussian;
    use crate::testing::any_gaussian;

    fn vertical_of(gaussian: &Gaussian) -> Vertical {
        let p = |row, column| gaussian.covariance.get(row, column);
        Vertical {
            mean: [gaussian.mean[2], gaussian.mean[5]],
            covariance: [p(2, 2), p(2, 5), p(5, 5)],
        }
    }

    fn assert_close(a: &Vertical, b: &Vertical) {
        let scale = [
            a.covariance[0],
            (a.covariance[0] * a.covariance[2]).sqrt(),
            a.covariance[2],
        ];
        for index in 0..2 {
            assert!(
                (a.mean[index] - b.mean[index]).abs() <= 1e-9 * (1.0 + a.mean[index].abs()),
                "{a:?} {b:?}"
            );
        }
        for ((a, b), scale) in a.covariance.iter().zip(b.covariance).zip(scale) {
            assert!((a - b).abs() <= 1e-9 * scale, "{a} {b}");
        }
    }

    fn is_positive(vertical: &Vertical) -> bool {
        let [height, cross, rate] = vertical.covariance;
        height > 0.0 && rate > 0.0 && height * rate > cross * cross
    }

    proptest! {
        #[test]
        fn motion_and_mixtures_equal_those_of_whole_states(
            a in any_gaussian(), b in any_gaussian(), q in 0.0..50.0f64, t in -20.0..20.0f64, weight in 0.0..1.0f64,
        ) {
            let mut moved = vertical_of(&a);
            moved.advance(t, q);
            assert_close(&moved, &vertical_of(&a.moved(t, [AxisNoise::white(q, t); 3])));
            let mixture = Vertical::mixture(&[vertical_of(&a), vertical_of(&b)], [1.0 - weight, weight]);
            assert_close(&mixture, &vertical_of(&Gaussian::mixture(&a, &b, weight)));
            prop_assert!(is_positive(&moved) && is_positive(&mixture));
        }

        #[test]
        fn an_update_equals_the_textbooks(start in any_gaussian(), sigma in 1.0..500.0f64, shift in -500.0..500.0f64) {
            let start = vertical_of(&start);
            let mut updated = start;
            let r = sigma * sigma;
            let (squared, variance) = updated.update(start.mean[0] + shift, r).expect("positive");
            let [height, cross, rate] = start.covariance;
            prop_assert!((variance - height - r).abs() <= 1e-9 * variance);
            prop_assert!((squared - shift * shift / variance).abs() <= 1e-6 * (1.0 + squared));
            let expected = Vertical {
                mean: [start.mean[0] + height / variance * shift, start.mean[1] + cross / variance * shift],
                covariance: [
                    height - height * height / variance,
                    cross - height * cross / variance,
                    rate - cross * cross / variance,
                ],
            };
            assert_close(&expected, &updated);
            prop_assert!(is_positive(&updated));
        }
    }

    #[test]
    fn what_is_not_usable_changes_nothing() {
        let start = Vertical {
            mean: [1.0, 2.0],
            covariance: [9.0, 1.0, 4.0],
        };
        let mut vertical = start;
        assert_eq!(vertical.update(f64::NAN, 1.0), None);
        assert_eq!(vertical.update(0.0, -20.0), None);
        assert_eq!(vertical, start);
    }
}
