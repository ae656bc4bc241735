//! Errors of the attitude that persist from look to look.
//!
//! A filter takes the errors of successive detections as independent. The heading's error at a look is still present at
//! the next look, two seconds later: the filter averages an error that does not average out, and becomes certain of a
//! wrong place. To estimate the error itself, as a state common to all tracks, would couple all tracks. The equivalent
//! for each track alone is noise of the same spectral density at low frequencies. An error with the correlation
//! exp(−t/τ), seen every T, has at frequency 0 the density of independent errors with the variance
//!
//! σ²·(1 + ρ)/(1 − ρ), ρ = exp(−T/τ).
//!
//! A track filter of ships is slow (some twenty seconds) against the usual τ, so the filter passes exactly this
//! density. Against a τ much longer than a track's memory the variance is too large: the covariance is then cautious.
//!
//! Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation* (2001),
//! section 8.2, for autocorrelated noise, and section 1.4.22 for spectral densities.

const NS_PER_S: f64 = 1e9;
/// Looks that the mean interval between two looks remembers.
const MEMORY: u32 = 16;

/// Factor of the variance of an error with the correlation time `correlation_s` that is seen every `interval_s`; 1 if
/// the error is new in each look.
pub(crate) fn variance_factor(interval_s: f64, correlation_s: f64) -> f64 {
    if correlation_s <= 0.0 || interval_s <= 0.0 {
        return 1.0;
    }
    // (1 + ρ)/(1 − ρ) is the hyperbolic cotangent of T/2τ.
    1.0 / (0.5 * interval_s / correlation_s).tanh()
}

/// Mean interval between two looks of a sensor, by the sensor's scan numbers or turns.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LookInterval {
    /// Configured interval, seconds.
    stated_s: Option<f64>,
    mean_s: f64,
    /// Looks in the mean.
    count: u32,
    /// Number and first time of the scan at hand.
    scan: Option<(u32, i64)>,
    /// Beginning of the turn at hand.
    turn_ns: Option<i64>,
}

impl LookInterval {
    /// With a configured interval, or as shown by the data.
    pub(crate) fn new(stated_ns: Option<i64>) -> Self {
        Self {
            stated_s: stated_ns.map(|stated_ns| stated_ns as f64 / NS_PER_S),
            ..Self::default()
        }
    }

    /// The interval, seconds; 0 until the data have shown the interval.
    pub(crate) fn s(&self) -> f64 {
        self.stated_s.unwrap_or(self.mean_s)
    }

    /// Notes a detection of scan `number`.
    pub(crate) fn detected(&mut self, number: u32, time_ns: i64) {
        if let Some((scan, begin_ns)) = self.scan
            && number >= scan
        {
            let scans = number - scan;
            if scans == 0 {
                return;
            }
            self.add(time_ns.saturating_sub(begin_ns), scans);
        }
        self.scan = Some((number, time_ns));
    }

    /// Notes that a turn begins.
    pub(crate) fn turned(&mut self, time_ns: i64) {
        if let Some(turn_ns) = self.turn_ns.replace(time_ns) {
            self.add(time_ns.saturating_sub(turn_ns), 1);
        }
    }

    fn add(&mut self, span_ns: i64, looks: u32) {
        if span_ns > 0 {
            self.count = (self.count + 1).min(MEMORY);
            let interval_s = span_ns as f64 / NS_PER_S / f64::from(looks);
            self.mean_s += (interval_s - self.mean_s) / f64::from(self.count);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn the_variance_grows_with_the_correlation_from_look_to_look() {
        assert_eq!([variance_factor(2.0, 0.0), variance_factor(0.0, 5.0)], [1.0; 2]);
        // (1 + ρ)/(1 − ρ) with ρ = exp(−2), exp(−0.2).
        for (correlation_s, expected) in [(1.0, 1.313), (10.0, 10.033)] {
            let factor = variance_factor(2.0, correlation_s);
            assert!((factor - expected).abs() < 1e-3, "{factor}");
        }
    }

    #[test]
    fn the_interval_is_that_of_scans_or_turns_unless_stated() {
        let mut looks = LookInterval::new(None);
        assert_eq!(looks.s(), 0.0);
        looks.detected(7, 0);
        looks.detected(7, S);
        assert_eq!(looks.s(), 0.0);
        looks.detected(8, 2 * S);
        looks.detected(10, 6 * S);
        assert_eq!(looks.s(), 2.0);
        // The sensor has started again.
        looks.detected(1, 50 * S);
        looks.detected(2, 52 * S);
        assert_eq!(looks.s(), 2.0);
        let mut turns = LookInterval::new(None);
        for turn in 0..5 {
            turns.detected(0, turn * 3 * S + 1);
            turns.turned(turn * 3 * S);
        }
        assert_eq!(turns.s(), 3.0);
        let mut stated = LookInterval::new(Some(4 * S));
        stated.detected(1, 0);
        stated.detected(2, S);
        assert_eq!(stated.s(), 4.0);
    }
}
