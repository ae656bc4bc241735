//! Products of the normal equations with the effect of a source's errors, in arrays.
//!
//! The effect H is a 3×6 matrix with 11 constant elements, each 0 or 1. The products equal the products of `nalgebra`
//! with the whole matrix, term by term in the same order, so that the sums have the same bits.

use estimation::length;
use messages::AXES;
use nalgebra::SMatrix;

use crate::registration::rows::{AZIMUTH, ERRORS, Errors, NormalMatrix, RANGE, TIME};

/// Derivatives of a report with respect to the errors of its source. The derivatives by the offset are the unit
/// vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sensitivity {
    time: [f64; AXES],
    range: [f64; 2],
    azimuth: [f64; 2],
}

/// Columns of HᵀW.
pub(crate) type Weighted = [[f64; ERRORS]; AXES];

impl Sensitivity {
    /// Without a position of the sensor, the azimuth bias turns the targets about the origin: the same rotation, apart
    /// from an offset. A range bias has no effect then.
    pub(crate) fn new(position: [f64; AXES], velocity: [f64; AXES], place: Option<[f64; 2]>) -> Self {
        let [east, north] = place.unwrap_or_default();
        let (dx, dy) = (position[0] - east, position[1] - north);
        let range = length([dx, dy]);
        let is_apart = range > 1.0;
        Self {
            time: velocity.map(|part| -part),
            range: match place {
                Some(_) if is_apart => [dx / range, dy / range],
                _ => [0.0; 2],
            },
            // Azimuth counts clockwise from north.
            azimuth: if is_apart { [dy, -dx] } else { [0.0; 2] },
        }
    }

    /// Returns H.
    pub(crate) fn matrix(&self) -> SMatrix<f64, AXES, ERRORS> {
        let mut h = SMatrix::zeros();
        for axis in 0..AXES {
            h[(axis, axis)] = 1.0;
            h[(axis, TIME)] = self.time[axis];
        }
        for axis in 0..2 {
            h[(axis, RANGE)] = self.range[axis];
            h[(axis, AZIMUTH)] = self.azimuth[axis];
        }
        h
    }

    /// Returns the effect of these errors on the report, H·θ.
    pub(crate) fn effect(&self, errors: &Errors) -> [f64; AXES] {
        let (t, r, a) = (errors[TIME], errors[RANGE], errors[AZIMUTH]);
        let in_plane = |axis: usize| errors[axis] + self.time[axis] * t + self.range[axis] * r + self.azimuth[axis] * a;
        [in_plane(0), in_plane(1), errors[2] + self.time[2] * t]
    }

    /// Returns HᵀW; `weight` has the columns of W.
    pub(crate) fn weighted(&self, weight: &[[f64; AXES]; AXES]) -> Weighted {
        std::array::from_fn(|column| {
            let [x, y, z] = weight[column];
            [
                x,
                y,
                z,
                self.time[0] * x + self.time[1] * y + self.time[2] * z,
                self.range[0] * x + self.range[1] * y,
                self.azimuth[0] * x + self.azimuth[1] * y,
            ]
        })
    }

    /// Adds HᵀW·H to a sum.
    pub(crate) fn add_product(&self, weighted: &Weighted, sum: &mut NormalMatrix) {
        let [x, y, z] = weighted;
        let columns = &mut sum.data.0;
        for row in 0..ERRORS {
            columns[0][row] += x[row];
            columns[1][row] += y[row];
            columns[2][row] += z[row];
            columns[TIME][row] += x[row] * self.time[0] + y[row] * self.time[1] + z[row] * self.time[2];
            columns[RANGE][row] += x[row] * self.range[0] + y[row] * self.range[1];
            columns[AZIMUTH][row] += x[row] * self.azimuth[0] + y[row] * self.azimuth[1];
        }
    }
}

/// Adds HᵀW·Δ to a sum.
pub(crate) fn add_vector([x, y, z]: &Weighted, difference: &[f64; AXES], sum: &mut Errors) {
    for row in 0..ERRORS {
        sum[row] += x[row] * difference[0] + y[row] * difference[1] + z[row] * difference[2];
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    type Triple = [f64; AXES];

    proptest! {
        #[test]
        fn the_products_equal_those_of_matrices_to_the_bit(
            position in prop::array::uniform3(-1e5..1e5f64), velocity in prop::array::uniform3(-300.0..300.0f64),
            has_place in any::<bool>(), difference in prop::array::uniform3(-100.0..100.0f64),
            weight in prop::array::uniform3(prop::array::uniform3(-1.0..1.0f64)),
            errors in prop::array::uniform6(-100.0..100.0f64),
        ) {
            let place = has_place.then_some([1e3, -2e3]);
            let of = Sensitivity::new(position, velocity, place);
            let h = of.matrix();
            let errors = Errors::from(errors);
            prop_assert_eq!(of.effect(&errors), Triple::from(h * errors));
            let weighted = h.transpose() * SMatrix::from(weight);
            prop_assert_eq!(of.weighted(&weight), weighted.data.0);
            let mut sums = (NormalMatrix::zeros(), Errors::zeros());
            of.add_product(&weighted.data.0, &mut sums.0);
            add_vector(&weighted.data.0, &difference, &mut sums.1);
            prop_assert_eq!(sums, (weighted * h, weighted * SMatrix::<f64, AXES, 1>::from(difference)));
        }
    }
}
