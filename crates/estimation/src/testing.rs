//! Random states for the property tests.

use nalgebra::SMatrix;
use proptest::prelude::*;

use crate::Gaussian;
use crate::gaussian::{Matrix6, Vector6, packed};

/// States as sensors yield them: positions within 200 km, sigmas from 1 m to 1 km and 0.1 m/s to 100 m/s, correlated.
pub(crate) fn any_gaussian() -> impl Strategy<Value = Gaussian> {
    (
        prop::array::uniform6(-1.0..1.0f64),
        prop::collection::vec(-1.0..1.0f64, 36),
        0.0..3.0f64,
        -1.0..2.0f64,
    )
        .prop_map(|(mean, mixing, position_exponent, velocity_exponent)| {
            let (position, velocity) = (10f64.powf(position_exponent), 10f64.powf(velocity_exponent));
            let mixing = SMatrix::<f64, 6, 6>::from_column_slice(&mixing);
            let scale = Vector6::from_fn(|row, _| if row < 3 { position } else { velocity });
            let correlated = mixing * mixing.transpose() + Matrix6::identity() * 0.1;
            Gaussian {
                mean: std::array::from_fn(|row| mean[row] * if row < 3 { 2e5 } else { 300.0 }),
                covariance: packed(&Matrix6::from_fn(|row, column| {
                    correlated[(row.min(column), row.max(column))] * scale[row] * scale[column]
                })),
            }
        })
}

/// Equal up to rounding, component by component in units of the standard deviations.
pub(crate) fn assert_close(a: &Gaussian, b: &Gaussian) {
    for row in 0..6 {
        assert!(
            (a.mean[row] - b.mean[row]).abs() <= 1e-9 * (1.0 + a.mean[row].abs()),
            "means differ: {a:?} {b:?}"
        );
        for column in 0..6 {
            let scale = (a.covariance.get(row, row) * a.covariance.get(column, column)).sqrt();
            let difference = (a.covariance.get(row, column) - b.covariance.get(row, column)).abs();
            assert!(difference <= 1e-9 * scale, "covariances differ: {a:?} {b:?}");
        }
    }
}
