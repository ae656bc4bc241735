//! How accurate a bearing is, and whether a minimum is as deep as a source's would be.
//!
//! With many snapshots, the error of a MUSIC bearing is normal with the variance (Stoica & Nehorai, "MUSIC, maximum
//! likelihood, and Cramér–Rao bound", IEEE Trans. ASSP 37 (5), 1989, theorem 3.1)
//!
//! ```text
//!   σ²/(2N) · Σ λ/(λ − σ²)² |s·a|²  /  |projection of a' on the noise subspace|²
//! ```
//!
//! with N snapshots, noise variance σ², signal eigenvectors s with values λ, steering vector a and the derivative a'.
//! For a single source, and for several that are well separated and independent, this is the stochastic Cramér–Rao
//! bound itself. All terms are known from the measurement, so that every bearing has an individual accuracy.
//!
//! Independent phase errors φ of the antennas move a bearing by φ / |projection of a'|, whatever the number of
//! snapshots; this term is added.
//!
//! Along the line of a line array the phases do not change with the bearing: the measured quantity is the cosine of
//! the angle to the line. An error ε of the cosine is an error ε / sin of the angle, but never more than √(2ε),
//! since the cosine is flat there. A bearing that appears farther off the line by chance must not seem too accurate,
//! so the sine is taken two deviations nearer to the line.
//!
//! At a true source's bearing the null spectrum is not 0 but σ²/N · Σ … times half a chi-square number with two degrees
//! of freedom per noise eigenvector, or with wrong phases that more. A minimum that is clearly less deep is none of a
//! source: a side lobe, or the common minimum of two sources that were not separated.

use std::f64::consts::PI;

use super::array::AntennaArray;
use super::null_spectrum::SpectrumMinimum;

/// Standard deviation of a bearing of which nothing is known: uniform over the circle.
pub(super) const UNKNOWN_RAD: f64 = PI / 1.732_050_807_568_877_2;
/// Standard deviations that a minimum may lack in depth.
const DEPTH_DEVIATIONS: f64 = 4.5;

/// Quantities that the accuracy of all bearings of a measurement depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct AccuracyInputs {
    pub(super) snapshots: usize,
    pub(super) sources: usize,
    pub(super) phase_sigma_rad: f64,
}

impl AccuracyInputs {
    /// Standard deviation of the bearing at a minimum, radians.
    pub(super) fn sigma_rad(&self, minimum: &SpectrumMinimum, array: &AntennaArray) -> f64 {
        let by_noise = 0.5 * self.deviation(minimum) / minimum.sharpness;
        let by_phases = self.phase_sigma_rad.powi(2) / minimum.sharpness;
        let of_search = (by_noise + by_phases).sqrt();
        let of_bearing = match array.sine_to_line(minimum.bearing_rad) {
            Some(sine) => {
                let cosine = (1.0 - sine * sine).sqrt() + 2.0 * of_search;
                let nearer = (1.0 - cosine * cosine).max(0.0).sqrt();
                (of_search / nearer).min((2.0 * of_search).sqrt())
            }
            None => of_search,
        };
        // NaN (0 / 0) if the bearing is undetermined.
        if of_bearing < UNKNOWN_RAD {
            of_bearing
        } else {
            UNKNOWN_RAD
        }
    }

    /// Returns whether a minimum is deep enough for a source.
    pub(super) fn may_be_a_source(&self, minimum: &SpectrumMinimum, antennas: usize) -> bool {
        let noise_vectors = (antennas - self.sources) as f64;
        let by_noise = 0.5 * self.deviation(minimum) * chi_square_limit(2.0 * noise_vectors);
        let by_phases = self.phase_sigma_rad.powi(2) * chi_square_limit(noise_vectors);
        // Few snapshots estimate neither the noise nor the deviation well, and rounding is a lower limit.
        let few = self.snapshots as f64 / (self.snapshots - self.sources) as f64;
        minimum.depth <= few * (by_noise + by_phases) + f64::EPSILON * (antennas * antennas) as f64
    }

    /// Mean of the null spectrum at the source's true bearing, per noise eigenvector.
    fn deviation(&self, minimum: &SpectrumMinimum) -> f64 {
        minimum.deviation / self.snapshots as f64
    }
}

/// The chi-square number that is not exceeded but by chance (Wilson & Hilferty 1931).
pub(super) fn chi_square_limit(degrees: f64) -> f64 {
    let part = 2.0 / (9.0 * degrees);
    degrees * (1.0 - part + DEPTH_DEVIATIONS * part.sqrt()).powi(3)
}
