//! Statistics of values; `None` without values.

/// Returns the mean.
pub(crate) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Returns the root of the mean of given squares.
pub(crate) fn root_mean(squares: &[f64]) -> Option<f64> {
    mean(squares).map(f64::sqrt)
}

/// Returns the standard deviation (root mean squared difference from the mean).
pub(crate) fn standard_deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values)?;
    let squares: Vec<f64> = values.iter().map(|value| (value - mean) * (value - mean)).collect();
    root_mean(&squares)
}

/// Returns the quantile at `share` (0 to 1), interpolated linearly between neighbours.
pub(crate) fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    values.sort_unstable_by(f64::total_cmp);
    let place = share * last as f64;
    let (below, part) = (place.floor() as usize, place.fract());
    let above = (below + 1).min(last);
    Some(values[below] + part * (values[above] - values[below]))
}

/// Returns the standard deviation of directions, radians, from the length of the mean of their unit vectors (Mardia
/// and Jupp, *Directional Statistics*), so that north is a single direction.
pub(crate) fn circular_deviation(directions_rad: &[f64]) -> Option<f64> {
    /// Lower limit of the mean length, because the logarithm of zero is infinite.
    const LENGTH_MIN: f64 = 1e-12;
    let sines: Vec<f64> = directions_rad.iter().map(|direction| direction.sin()).collect();
    let cosines: Vec<f64> = directions_rad.iter().map(|direction| direction.cos()).collect();
    let length = mean(&sines)?.hypot(mean(&cosines)?).max(LENGTH_MIN);
    Some((-2.0 * length.ln()).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    #[test]
    fn figures_by_hand() {
        assert_eq!(mean(&[1.0, 2.0, 6.0]), Some(3.0));
        assert_eq!(root_mean(&[9.0, 16.0, 50.0]), Some(5.0));
        // Differences -2, -2, 4: squares 4, 4, 16.
        assert_eq!(standard_deviation(&[1.0, 1.0, 7.0]), Some(8f64.sqrt()));
        assert_eq!(quantile(&mut [30.0, 10.0, 20.0], 0.5), Some(20.0));
        assert_eq!(quantile(&mut [30.0, 10.0, 20.0], 0.75), Some(25.0));
        assert_eq!(quantile(&mut [7.0], 0.95), Some(7.0));
    }

    #[test]
    fn nothing_has_no_figures() {
        assert_eq!((mean(&[]), root_mean(&[]), standard_deviation(&[])), (None, None, None));
        assert_eq!((quantile(&mut [], 0.5), circular_deviation(&[])), (None, None));
    }

    #[test]
    fn directions_about_north_are_close_to_each_other() {
        let deviation = circular_deviation(&[0.1, -0.1, 2.0 * PI + 0.1, 2.0 * PI - 0.1]).unwrap();
        // The mean vector has the length cos 0.1.
        assert!(
            (deviation - (-2.0 * 0.1f64.cos().ln()).sqrt()).abs() < 1e-12,
            "{deviation}"
        );
        assert!(circular_deviation(&[0.0, FRAC_PI_2, PI, -FRAC_PI_2]).unwrap() > 7.0);
        assert_eq!(circular_deviation(&[1.0, 1.0]).unwrap(), 0.0);
    }
}
