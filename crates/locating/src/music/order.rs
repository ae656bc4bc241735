//! How many transmitters there are, from the eigenvalues of the snapshots' covariance.
//!
//! Without transmitters all eigenvalues would be equal but for chance. A criterion weighs, for every number *k*, how
//! unequal the smallest antennas − *k* are against the number of values needed to describe *k* transmitters (Wax &
//! Kailath, "Detection of signals by information theoretic criteria", IEEE Trans. ASSP 33 (2), 1985). MDL finds the
//! right number with enough snapshots; AIC finds weak transmitters earlier, and an excess transmitter now and then.
//!
//! A number, given or estimated, does not prove that each transmitter can be resolved. Noise alone spreads the
//! eigenvalues up to about σ²(1 + √(antennas / snapshots))². The eigenvector of a transmitter with an eigenvalue below
//! this edge is not informative (Baik, Ben Arous & Péché 2005), so such transmitters are not searched. The random
//! excess of noise beyond that edge is known, too (Johnstone, "On the distribution of the largest eigenvalue in
//! principal components analysis", Annals of Statistics 29 (2), 2001).

use super::error::MusicError;

/// Distance beyond the edge to which noise may reach, in units of the spread there: once in some hundred cases at most.
const NOISE_DEVIATIONS: f64 = 2.0;

/// Number of transmitters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceCount {
    /// A known number.
    Given(usize),
    /// The number by minimum description length.
    Mdl,
    /// The number by Akaike's information criterion.
    Aic,
}

impl SourceCount {
    pub(super) fn check(self, antennas: usize) -> Result<(), MusicError> {
        match self {
            Self::Given(sources) if sources == 0 || sources >= antennas => {
                Err(MusicError::Sources { sources, antennas })
            }
            _ => Ok(()),
        }
    }

    /// The number for these eigenvalues (in falling order) of the covariance of so many snapshots.
    ///
    /// # Errors
    /// Too few snapshots: a given number needs an additional snapshot, an estimate needs a snapshot per antenna.
    pub(super) fn count(self, values: &[f64], snapshots: usize) -> Result<usize, MusicError> {
        let needed = match self {
            Self::Given(sources) => sources + 1,
            Self::Mdl | Self::Aic => values.len(),
        };
        if snapshots < needed {
            return Err(MusicError::TooFewSnapshots { snapshots, needed });
        }
        let penalty_per_value = match self {
            Self::Given(sources) => return Ok(sources),
            Self::Mdl => 0.5 * (snapshots as f64).ln(),
            Self::Aic => 1.0,
        };
        let criterion = |sources: usize| {
            let free_values = (sources * (2 * values.len() - sources)) as f64;
            snapshots as f64 * inequality(values, sources) + penalty_per_value * free_values
        };
        let better = |best: usize, sources: usize| {
            if criterion(sources) < criterion(best) {
                sources
            } else {
                best
            }
        };
        Ok((0..values.len()).reduce(better).unwrap_or(0))
    }
}

/// Inequality of the values after the first `sources`: the number of values times the logarithm of the arithmetic over
/// the geometric mean.
fn inequality(values: &[f64], sources: usize) -> f64 {
    // Without noise the smallest values are rounding errors, of either sign and any ratio.
    let floor = f64::EPSILON * values.len() as f64 * values[0];
    let rest = || values[sources..].iter().map(|value| value.max(floor));
    let count = rest().len() as f64;
    let mean = rest().sum::<f64>() / count;
    count * mean.ln() - rest().map(f64::ln).sum::<f64>()
}

/// Variance of the noise: the mean of the smallest eigenvalues, corrected for the noise absorbed by the sources'
/// eigenvectors at few snapshots. Never below the rounding error.
pub(super) fn noise_variance(values: &[f64], snapshots: usize, sources: usize) -> f64 {
    let sum: f64 = values[sources..].iter().sum();
    let share = (snapshots - sources) as f64 / snapshots as f64;
    let mean = sum / ((values.len() - sources) as f64 * share);
    mean.max(f64::EPSILON * values.len() as f64 * values[0])
}

/// Number of the first `sources` eigenvalues that stand out of the noise.
pub(super) fn above_noise(values: &[f64], snapshots: usize, sources: usize, noise_variance: f64) -> usize {
    let [antennas, count] = [values.len(), snapshots].map(|number| (number as f64).sqrt());
    let (edge, spread) = (
        (count + antennas).powi(2),
        (count + antennas) * (1.0 / count + 1.0 / antennas).cbrt(),
    );
    let limit = noise_variance * (edge + NOISE_DEVIATIONS * spread) / snapshots as f64;
    values[..sources].iter().take_while(|&&value| value > limit).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of Wax & Kailath: seven antennas, 100 snapshots, two sources; both criteria find two, MDL by 66.9
    /// against 67.2 for one.
    #[test]
    fn published_example() {
        let values = [21.2359, 2.1717, 1.4279, 1.0979, 1.0544, 0.9432, 0.7324];
        assert_eq!(SourceCount::Mdl.count(&values, 100), Ok(2));
        assert_eq!(SourceCount::Aic.count(&values, 100), Ok(2));
    }

    #[test]
    fn equal_values_are_no_sources() {
        for count in [SourceCount::Mdl, SourceCount::Aic] {
            assert_eq!(count.count(&[1.0; 4], 50), Ok(0));
            assert_eq!(count.count(&[1000.0, 1.0, 1.0, 1.0], 50), Ok(1));
            // No noise at all: only rounding remains.
            assert_eq!(count.count(&[1000.0, 10.0, 3e-14, -2e-14], 50), Ok(2));
        }
        let needed = 4;
        let error = MusicError::TooFewSnapshots { snapshots: 3, needed };
        assert_eq!(SourceCount::Mdl.count(&[1.0; 4], 3), Err(error));
        assert_eq!(SourceCount::Given(2).count(&[1.0; 4], 3), Ok(2));
    }

    #[test]
    fn what_noise_could_do_is_not_seen() {
        // For 4 antennas and 100 snapshots the edge is 1.44, the spread 0.12 · 0.6^⅓ = 0.101.
        assert_eq!(above_noise(&[50.0, 1.65, 1.0, 1.0], 100, 2, 1.0), 2);
        assert_eq!(above_noise(&[50.0, 1.64, 1.0, 1.0], 100, 2, 1.0), 1);
    }
}
