//! Gaussian beliefs that compete: the mixture, and the belief that a tighter prior of the velocity would give.

use nalgebra::{Matrix2, Matrix4, SMatrix, SVector, Vector2, Vector4};

use crate::linear::Factor;

/// A Gaussian belief with the logarithm of the weight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weighted<const D: usize> {
    pub(crate) log_weight: f64,
    pub(crate) mean: SVector<f64, D>,
    pub(crate) covariance: SMatrix<f64, D, D>,
}

/// Mean and covariance of a mixture of beliefs (moment matching); `None` for a mixture of nothing. Weights need not be
/// normalised.
pub(crate) fn matched<const D: usize, const N: usize>(
    beliefs: &[Option<Weighted<D>>; N],
) -> Option<(SVector<f64, D>, SMatrix<f64, D, D>)> {
    let weights = beliefs.iter().flatten().map(|belief| belief.log_weight);
    let greatest = weights.fold(f64::NEG_INFINITY, f64::max);
    // By reference: a belief of four components is 168 octets.
    let shares = beliefs.each_ref().map(|belief| {
        let belief = belief.as_ref();
        belief.map_or(0.0, |belief| (belief.log_weight - greatest).exp())
    });
    let total: f64 = shares.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let shared = || {
        let shares = beliefs.iter().zip(&shares);
        shares.filter_map(|(belief, share)| Some((belief.as_ref()?, share / total)))
    };
    let mut mean = SVector::zeros();
    for (belief, share) in shared() {
        mean += belief.mean * share;
    }
    let mut covariance = SMatrix::zeros();
    for (belief, share) in shared() {
        let apart = belief.mean - mean;
        for column in 0..D {
            for row in 0..D {
                covariance[(row, column)] += (belief.covariance[(row, column)] + apart[row] * apart[column]) * share;
            }
        }
    }
    Some((mean, covariance))
}

/// Belief about (position, velocity) with a tighter prior of the velocity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slowed {
    /// Logarithm of the Bayes factor of the tighter prior against the belief's own.
    pub(crate) log_odds: f64,
    pub(crate) mean: Vector4<f64>,
    pub(crate) covariance: Matrix4<f64>,
}

/// Returns the belief with the prior σ `tighter_mps` of the velocity along each axis in place of `own_mps`, which is
/// greater; `None` if the covariance is none.
///
/// Both priors' ratio times the belief equals a measurement times the belief: velocity zero, with variance 1 /
/// (1/σ² − 1/σ_own²). For σ = 0 the Bayes factor is that of Savage and Dickey: by how much the bearings have raised the
/// density of rest (J. M. Dickey, *The weighted likelihood ratio, linear hypotheses on normal location parameters*,
/// Annals of Mathematical Statistics 42, 1971). `cost_of_rest_max` bounds the squared distance from rest, where the
/// true value is known.
pub(crate) fn slowed(
    (mean, covariance): (&Vector4<f64>, &Matrix4<f64>),
    own_mps: f64,
    tighter_mps: f64,
    cost_of_rest_max: f64,
) -> Option<Slowed> {
    let share = (tighter_mps / own_mps).powi(2);
    let variance = tighter_mps * tighter_mps / (1.0 - share);
    let velocity = Vector2::new(mean[2], mean[3]);
    let innovation = covariance.fixed_view::<2, 2>(2, 2) + Matrix2::identity() * variance;
    let factor = Factor::of(&innovation)?;
    let solved = factor.solve(&velocity);
    let cost = velocity.dot(&solved).min(cost_of_rest_max);
    let log_odds = 2.0 * own_mps.ln() - (1.0 - share).ln() - 0.5 * (factor.log_determinant() + cost);
    let with_velocity = covariance.fixed_view::<4, 2>(0, 2);
    Some(Slowed {
        log_odds,
        mean: mean - with_velocity * solved,
        covariance: covariance - with_velocity * factor.inverse() * with_velocity.transpose(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_has_the_spread_of_its_parts() {
        let part = |log_weight, mean, variance| Weighted::<2> {
            log_weight,
            mean: SVector::from([mean, 0.0]),
            covariance: SMatrix::identity() * variance,
        };
        let parts = [part(1e4, 0.0, 1.0), part(1e4 + 3f64.ln(), 4.0, 2.0)];
        let (mean, covariance) = matched(&parts.map(Some)).unwrap();
        assert!((mean[0] - 3.0).abs() < 1e-9);
        // 0.25·1 + 0.75·2, and 0.25·9 + 0.75·1 for the means.
        assert!((covariance[(0, 0)] - 4.75).abs() < 1e-9 && (covariance[(1, 1)] - 1.75).abs() < 1e-9);
        assert!(matched::<2, 1>(&[None]).is_none());
    }

    #[test]
    fn a_tighter_prior_gives_what_it_would_have_given_from_the_start() {
        // Velocity east measured as 1.5 m/s with variance 0.5, and independently position east plus 10 s of this
        // velocity as 40 m.
        let measured = |own: f64| {
            let mut information =
                Matrix4::from_diagonal(&Vector4::new(1e-6, 1.0, 1.0 / (own * own), 1.0 / (own * own)));
            let mut vector = Vector4::zeros();
            for (h, value, variance) in [
                (Vector4::new(0.0, 0.0, 1.0, 0.0), 1.5, 0.5),
                (Vector4::new(1.0, 0.0, 10.0, 0.0), 40.0, 4.0),
            ] {
                information += h * h.transpose() / variance;
                vector += h * (value / variance);
            }
            let covariance = Factor::of(&information).unwrap().inverse();
            let mean = covariance * vector;
            // ln of the evidence except terms that do not depend on the prior.
            let log_evidence =
                0.5 * mean.dot(&vector) - 2.0 * own.ln() + 0.5 * Factor::of(&covariance).unwrap().log_determinant();
            (mean, covariance, log_evidence)
        };
        let (mean, covariance, wide) = measured(3.0);
        for tighter in [1.0, 0.1, 1e-4] {
            let (expected, spread, log_evidence) = measured(tighter);
            let found = slowed((&mean, &covariance), 3.0, tighter, f64::INFINITY).unwrap();
            assert!((found.mean - expected).amax() < 1e-6, "{tighter}");
            assert!((found.covariance - spread).amax() < 1e-3, "{tighter}");
            assert!((found.log_odds - (log_evidence - wide)).abs() < 1e-6, "{tighter}");
        }
        let rest = slowed((&mean, &covariance), 3.0, 0.0, f64::INFINITY).unwrap();
        assert!((rest.log_odds - (measured(1e-4).2 - wide)).abs() < 1e-6);
    }
}
