//! Gate: the largest accepted distance between a detection and the prediction (HT-2).
//!
//! Under the model, the squared statistical distance between a detection of D quantities and the prediction follows a
//! chi-square distribution with D degrees of freedom. The gate is the distance not exceeded with the configured
//! probability.

use crate::measurement::DIMENSIONS_MAX;

/// Γ(D/2 + 1) for D = 1 … 4.
const GAMMA: [f64; DIMENSIONS_MAX] = [0.886_226_925_452_758, 1.0, 1.329_340_388_179_137, 2.0];

/// Largest squared statistical distances, by number of quantities less 1.
pub(crate) fn gates(probability: f64) -> [f64; DIMENSIONS_MAX] {
    std::array::from_fn(|place| quantile(place + 1, probability))
}

/// By bisection: computed only once.
fn quantile(dimension: usize, probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while distribution(dimension, high) < probability && high < 1e3 {
        high *= 2.0;
    }
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if distribution(dimension, middle) < probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Probability that chi-square stays below `value`: the series of the incomplete gamma function.
fn distribution(dimension: usize, value: f64) -> f64 {
    let (a, x) = (0.5 * dimension as f64, 0.5 * value);
    let (mut term, mut sum, mut n) = (1.0, 1.0, a);
    while term > 1e-17 * sum {
        n += 1.0;
        term *= x / n;
        sum += term;
    }
    x.powf(a) * (-x).exp() * sum / GAMMA[dimension - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tabled_quantiles() {
        for (probability, expected) in [
            (0.95, [3.8415, 5.9915, 7.8147, 9.4877]),
            (0.99, [6.6349, 9.2103, 11.3449, 13.2767]),
        ] {
            for (found, expected) in gates(probability).into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-4, "{found} instead of {expected}");
            }
        }
    }
}
