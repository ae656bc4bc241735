//! Sums of probabilities that are kept as logarithms, so that products of many do not vanish.

/// Logarithm of the sum of the exponentials of `logarithms`; −∞ for an empty sum.
pub(crate) fn log_sum(logarithms: impl Iterator<Item = f64>) -> f64 {
    logarithms.fold(f64::NEG_INFINITY, log_add)
}

/// Logarithm of the sum of the exponentials of `a` and `b`.
pub(crate) fn log_add(a: f64, b: f64) -> f64 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    if low == f64::NEG_INFINITY {
        return high;
    }
    high + (low - high).exp().ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_logarithms() {
        assert_eq!(log_sum([].into_iter()), f64::NEG_INFINITY);
        assert!((log_add(0.0, 0.0) - 2f64.ln()).abs() < 1e-15);
        assert_eq!(log_add(f64::NEG_INFINITY, -3.0), -3.0);
        assert_eq!(log_add(1000.0, -1000.0), 1000.0);
    }
}
