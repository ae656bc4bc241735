//! Forecast of a source's next slice.
//!
//! A process that sleeps until a wake-up answers some 50 microseconds later than a spinning process. Sensors send at
//! regular intervals, so a slice is mostly expected: a waiter that spins around the expected time answers at once, and
//! sleeps for the rest. An irregular source is not forecast, and costs no spinning.

/// Part of the interval by which slices of a regular source may differ.
const TOLERANCE: i64 = 8;
/// Intervals in a row that agree, before the next is forecast.
const AGREEING: u32 = 3;

/// Interval between a source's slices.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Forecast {
    latest_ns: i64,
    interval_ns: i64,
    agreed: u32,
}

impl Forecast {
    /// Adds a slice sent at `sent_ns` (monotonic, nanoseconds).
    #[inline]
    pub(crate) fn learn(&mut self, sent_ns: i64) {
        let interval_ns = sent_ns.saturating_sub(self.latest_ns);
        self.latest_ns = sent_ns;
        let off_ns = interval_ns.saturating_sub(self.interval_ns);
        if interval_ns > 0 && off_ns.saturating_abs() <= self.interval_ns / TOLERANCE {
            self.interval_ns += off_ns / TOLERANCE;
            self.agreed = self.agreed.saturating_add(1);
        } else {
            (self.interval_ns, self.agreed) = (interval_ns.max(0), 0);
        }
    }

    /// Time of the next slice (monotonic, nanoseconds); `None` of a source without a regular interval.
    #[inline]
    pub(crate) fn next_ns(&self) -> Option<i64> {
        (self.agreed >= AGREEING).then(|| self.latest_ns.saturating_add(self.interval_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(times: &[i64]) -> Option<i64> {
        let mut forecast = Forecast::default();
        times.iter().for_each(|time| forecast.learn(*time));
        forecast.next_ns()
    }

    #[test]
    fn a_regular_source_is_forecast_and_an_irregular_one_is_not() {
        let regular = [1_000_000, 1_500_000, 2_000_500, 2_499_500, 3_000_000];
        assert_eq!(after(&regular[..4]), None, "too few");
        let next_ns = after(&regular).unwrap();
        assert!((3_499_000..3_501_000).contains(&next_ns), "{next_ns}");
        assert_eq!(after(&[0, 500, 900, 1_900, 2_000, 2_700, 4_000]), None);
        assert_eq!(
            after(&[&regular[..], &[3_100_000]].concat()),
            None,
            "a slice out of turn"
        );
    }

    #[test]
    fn absurd_times_are_no_intervals() {
        assert_eq!(after(&[i64::MAX, i64::MIN, 0, i64::MAX, 5, 5, 5, 5, 5]), None);
    }
}
