//! Recovery: the measurement behind a sensor track's latest report.
//!
//! A sensor track is a filter's output: each report contains all earlier reports again, so fusing reports as
//! measurements counts the same information many times. But the filter can be inverted. Between two reports of the same
//! track, a filter that measures position and assumes nearly constant velocity predicts, P⁻ = F·P·Fᵀ + Q, and updates,
//! P⁺ = P⁻ − A·S⁻¹·Aᵀ and x⁺ = x⁻ + A·S⁻¹·ν, with the position columns A of P⁻. The change in the position block, D =
//! P⁻ₚₚ − P⁺ₚₚ, gives S = P⁻ₚₚ·D⁻¹·P⁻ₚₚ, hence the measurement's covariance R = S − P⁻ₚₚ and the measurement z = x⁻ₚ +
//! P⁻ₚₚ·D⁻¹·(x⁺ₚ − x⁻ₚ). Measurements have independent errors and may be fused with measurements of other sensors.
//!
//! The inversion needs the filter's own process noise, which sources do not report. Two facts reveal it
//! ([`implied_noise`]): measuring a position changes neither the variance of the velocity for a given position, nor the
//! regression of the velocity on the position. Each yields the noise from two successive covariances alone; agreement
//! of both confirms that the source works as assumed.
//!
//! Limits: a report that went missing hides a measurement, and the two then no longer agree; sources that smooth
//! differently, or fill in a covariance by hand, cannot be undone.
//!
//! Source: O. E. Drummond, *Tracklets and a hybrid fusion with process noise*, SPIE 3163 (1997), in the form for
//! position measurements; the two conditions are elementary properties of the conditional normal distribution.

use messages::{AXES, Covariance};
use nalgebra::{SMatrix, SVector};

use crate::{AxisNoise, Gaussian};

/// Largest relative difference of the two estimates of [`implied_noise`] that rounding explains.
const AGREEMENT: f64 = 0.05;
/// Smallest relative change of a variance from which anything can be computed.
const CHANGE_MIN: f64 = 1e-6;

/// A recovered measurement of the first `D` axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recovered<const D: usize> {
    /// Measured position, metres.
    pub position_m: SVector<f64, D>,
    /// Covariance R of the measurement, m².
    pub covariance_m2: SMatrix<f64, D, D>,
}

/// The measurement that led from `predicted` (the earlier report, carried on with the source's own process noise) to
/// `updated`; `None` if the update shows no measurement.
pub fn recovered<const D: usize>(predicted: &Gaussian, updated: &Gaussian) -> Option<Recovered<D>> {
    const { assert!(D == 2 || D == 3, "a position has two or three axes") };
    let position = |state: &Gaussian| SVector::<f64, D>::from_fn(|axis, _| state.mean[axis]);
    let covariance = |state: &Gaussian| SMatrix::<f64, D, D>::from_fn(|row, column| state.covariance.get(row, column));
    let (before, after) = (covariance(predicted), covariance(updated));
    let change = before - after;
    if (0..D).any(|axis| change[(axis, axis)] <= CHANGE_MIN * before[(axis, axis)]) {
        return None;
    }
    let inverse = change.cholesky()?.inverse();
    let undo = before * inverse;
    let shift = position(updated) - position(predicted);
    let covariance = undo * before - before;
    let covariance_m2 = (covariance + covariance.transpose()) * 0.5;
    covariance_m2.cholesky()?;
    Some(Recovered {
        position_m: position(predicted) + undo * shift,
        covariance_m2,
    })
}

/// Spectral density of the white acceleration noise, m²/s³, that a position filter must have assumed on each of the `D`
/// axes from `first` on, between two successive covariances `duration_s` apart; `None` if the covariances do not come
/// from such a filter.
///
/// Axes with correlated measurement errors, as of a radar, must be treated together: the matrix of regression is
/// invariant, not the single elements.
pub fn implied_noise<const D: usize>(
    before: &Covariance,
    after: &Covariance,
    duration_s: f64,
    first: usize,
) -> Option<f64> {
    let block = |covariance: &Covariance, row: usize, column: usize| {
        SMatrix::<f64, D, D>::from_fn(|i, j| covariance.get(first + row + i, first + column + j))
    };
    let of = |covariance| {
        let velocity = block(covariance, AXES, AXES);
        (block(covariance, 0, 0), block(covariance, 0, AXES), velocity)
    };
    // Carried on without noise; the noise adds q times the unit's, the same on each axis.
    let (position, cross, velocity) = of(before);
    let t = duration_s;
    let moved_position = position + (cross + cross.transpose()) * t + velocity * (t * t);
    let moved_cross = cross + velocity * t;
    let unit = AxisNoise::white(1.0, t);
    let identity = SMatrix::<f64, D, D>::identity();
    let (position, cross, conditional) = of(after);
    let regression = cross.transpose() * position.cholesky()?.inverse();
    // q of the equations wanted = q · unit, by least squares.
    let solved = |wanted: SMatrix<f64, D, D>, unit: SMatrix<f64, D, D>| wanted.dot(&unit) / unit.norm_squared();
    // The regression of velocity on position is the same before and after the update.
    let by_regression = solved(
        regression * moved_position - moved_cross.transpose(),
        identity * unit.cross_m2ps - regression * unit.position_m2,
    );
    // So is the covariance of velocity for a given position.
    let by_variance = solved(
        conditional - velocity - regression * (cross - moved_cross),
        identity * unit.velocity_m2ps2 - regression * unit.cross_m2ps,
    );
    // Written so that NaN is refused.
    let agree = (by_regression - by_variance).abs() <= AGREEMENT * by_variance.abs() && by_variance > 0.0;
    let updated = (0..D).all(|axis| {
        let predicted = moved_position[(axis, axis)] + by_variance * unit.position_m2;
        position[(axis, axis)] < (1.0 - CHANGE_MIN) * predicted
    });
    (agree && updated).then_some(by_variance)
}

#[cfg(test)]
mod tests {
    use messages::STATE_LEN;
    use nalgebra::{Matrix3, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::testing::any_gaussian;
    use crate::{FirstVelocity, NearlyConstantVelocity};

    #[test]
    fn a_filters_measurements_come_back() {
        let model = NearlyConstantVelocity::new(20.0, 2.0);
        let r = [2500.0, 300.0, 0.0, 1600.0, 0.0, 5625.0];
        let velocity = FirstVelocity {
            horizontal_sigma_mps: 150.0,
            vertical_sigma_mps: 15.0,
        };
        let mut track = Gaussian::from_first_position::<3>([1e4, -2e4, 5e3], &r, velocity);
        for step in 0..20 {
            let seconds = if step % 3 == 0 { 8.0 } else { 4.0 };
            let predicted = model.predicted(&track, seconds);
            let [x, y, height, ..] = predicted.mean;
            let z = [x + 30.0, y - 50.0 + f64::from(step), height + 10.0];
            let mut updated = predicted;
            updated.update_position::<3>(z, &r).expect("positive definite");
            let found = recovered::<3>(&predicted, &updated).expect("there was a measurement");
            assert!((found.position_m - Vector3::from(z)).amax() < 1e-6);
            let r = Matrix3::new(r[0], r[1], r[2], r[1], r[3], r[4], r[2], r[4], r[5]);
            assert!((found.covariance_m2 - r).amax() < 1e-5);
            track = updated;
        }
    }

    /// Errors of a radar that is far away: six times as wide across the line of sight as along the line of sight, and
    /// neither east nor north.
    #[test]
    fn elongated_errors_hide_no_process_noise() {
        let model = NearlyConstantVelocity::new(20.0, 2.0);
        let velocity = FirstVelocity {
            horizontal_sigma_mps: 150.0,
            vertical_sigma_mps: 15.0,
        };
        let [along, across] = [50.0f64, 300.0].map(|sigma| sigma * sigma);
        let ellipse = |turn_rad: f64| {
            let (sin, cos) = turn_rad.sin_cos();
            let [xx, xy, yy] = [
                cos * cos * along + sin * sin * across,
                sin * cos * (along - across),
                sin * sin * along + cos * cos * across,
            ];
            [xx, xy, 0.0, yy, 0.0, 5625.0]
        };
        let mut track = Gaussian::from_first_position::<3>([0.0; 3], &ellipse(0.7), velocity);
        for step in 1..20 {
            let mut updated = model.predicted(&track, 4.0);
            let turned = ellipse(0.7 + 0.02 * f64::from(step));
            updated
                .update_position::<3>([0.0; 3], &turned)
                .expect("positive definite");
            let found = implied_noise::<2>(&track.covariance, &updated.covariance, 4.0, 0).expect("a filter");
            assert!((found - 20.0).abs() < 1e-3, "{found} in step {step}");
            let vertical = implied_noise::<1>(&track.covariance, &updated.covariance, 4.0, 2).expect("a filter");
            assert!((vertical - 2.0).abs() < 1e-3, "{vertical} in step {step}");
            track = updated;
        }
    }

    #[test]
    fn extrapolation_shows_no_measurement() {
        let start = Gaussian::new([0.0; 3], [0.0; 3], &Covariance::diagonal([10.0; 3], [10.0; 3]));
        let predicted = NearlyConstantVelocity::new(5.0, 5.0).predicted(&start, 4.0);
        assert_eq!(recovered::<3>(&predicted, &predicted), None);
        assert_eq!(
            implied_noise::<2>(&start.covariance, &predicted.covariance, 4.0, 0),
            None
        );
    }

    #[test]
    fn covariances_filled_in_by_hand_imply_no_filter() {
        let constant = Covariance::diagonal([5.0; 3], [5.0; 3]);
        assert_eq!(implied_noise::<2>(&constant, &constant, 1.0, 0), None);
    }

    proptest! {
        #[test]
        fn the_process_noise_is_found(
            start in any_gaussian(), density in 0.01..100.0f64, seconds in 0.5..12.0f64, sigma in 5.0..200.0f64,
        ) {
            // Along a single axis, as the axes are independent where the sensor's errors are.
            let mut covariance = Covariance::default();
            for index in 0..STATE_LEN {
                covariance.set(index, index, start.covariance.get(index, index));
            }
            let mut before = Gaussian::new([0.0; 3], [0.0; 3], &covariance);
            let model = NearlyConstantVelocity::new(density, density);
            before = model.predicted(&before, 1.0);
            let mut after = model.predicted(&before, seconds);
            after.update_position::<3>([0.0; 3], &[1.0, 0.0, 0.0, 1.0, 0.0, 1.0].map(|one| one * sigma * sigma)).expect("positive definite");
            let found = implied_noise::<1>(&before.covariance, &after.covariance, seconds, 1);
            if let Some(found) = found {
                prop_assert!((found / density - 1.0).abs() < 0.05, "{found} instead of {density}");
            } else {
                // Noise that drowns in the variances cannot be found, and is not invented.
                prop_assert!(density * seconds < 1e-4 * after.covariance.get(4, 4) || sigma > 1e3 || density < 1.0);
            }
        }
    }
}
