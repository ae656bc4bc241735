//! The stochastic Cramér–Rao bound of the bearings, which no unbiased method can beat.
//!
//! For signals that are random themselves, with covariance P and noise of variance 1 (Stoica, Larsson & Gershman, "The
//! stochastic CRB for array processing: a textbook derivation", IEEE Signal Processing Letters 8 (5), 2001):
//!
//! ```text
//!   CRB = 1/(2N) · [ Re{ (Dᴴ Π D) ∘ (P Aᴴ R⁻¹ A P)ᵀ } ]⁻¹,   R = A P Aᴴ + I,   Π = I − A (AᴴA)⁻¹ Aᴴ
//! ```
//!
//! with the steering vectors A and the derivatives D. The bound serves to design arrays and to judge results; the
//! computation allocates.

use nalgebra::{Complex, DMatrix};

use super::array::AntennaArray;
use super::error::MusicError;
use super::simulation::SimulatedWaves;

/// Least standard deviation of each bearing that any unbiased method reaches with these waves, radians, in the order of
/// the waves.
///
/// # Errors
/// If the waves are impossible, or no array of this kind can separate them.
pub fn stochastic_bound(array: &AntennaArray, waves: &SimulatedWaves) -> Result<Vec<f64>, MusicError> {
    waves.check()?;
    let (antennas, sources) = (array.len(), waves.bearings_rad.len());
    let wave_number = AntennaArray::wave_number(waves.frequency_hz);
    let mut steering = DMatrix::<Complex<f64>>::zeros(antennas, sources);
    let mut derivative = steering.clone();
    for (column, &bearing_rad) in waves.bearings_rad.iter().enumerate() {
        for (row, response) in array.response(wave_number, bearing_rad).enumerate() {
            steering[(row, column)] = response.value;
            derivative[(row, column)] = response.first();
        }
    }
    let signals = DMatrix::from_fn(sources, sources, |row, column| {
        Complex::from(waves.covariance(row, column))
    });
    let bound = || {
        let identity = DMatrix::<Complex<f64>>::identity(antennas, antennas);
        let received = &steering * &signals * steering.adjoint() + &identity;
        let overlap = (steering.adjoint() * &steering).try_inverse()?;
        let beside = &identity - &steering * overlap * steering.adjoint();
        let first = derivative.adjoint() * beside * &derivative;
        let second = &signals * steering.adjoint() * received.try_inverse()? * &steering * &signals;
        let information = first.component_mul(&second.transpose()).map(|element| element.re);
        (information * (2.0 * waves.snapshots as f64)).try_inverse()
    };
    let variances = bound().map(|bound| bound.diagonal());
    match variances {
        Some(variances) if variances.iter().all(|variance| variance.is_finite() && *variance > 0.0) => {
            Ok(variances.iter().map(|variance| variance.sqrt()).collect())
        }
        _ => Err(MusicError::Sources { sources, antennas }),
    }
}
