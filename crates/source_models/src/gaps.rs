//! Silence of a source about a continuing target.
//!
//! The period of a source gives the due time of the next report, not its delay. A centre with a period of five seconds
//! leaves one target in a hundred without reports for thirty. Ending or hiding a track before the source surely reports
//! again has no cause. The measure is the quantile of the intervals between two reports of a sensor track: only
//! [`BEYOND`] of all intervals are longer. The estimate follows each interval by a step upwards or downwards; the two
//! step sizes balance at the quantile (H. Robbins and S. Monro, 1951), so nothing is stored.
//!
//! A silence after the end of the sensor track counts, too, once the source uses the track number again.

use messages::NS_PER_S;
use serde::{Deserialize, Serialize};

/// Share of the longer intervals.
const BEYOND: f64 = 0.01;
/// Relative step after a longer interval.
const STEP: f64 = 0.2;
/// Margin on the silence, as a factor: the quantile is no exact figure.
const MARGIN: f64 = 1.1;
/// Longest silence of a target assumed to continue, nanoseconds.
const SILENCE_MAX_NS: i64 = 60 * NS_PER_S as i64;

/// The intervals of one source.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Gaps {
    /// Interval exceeded by few, nanoseconds; 0 before the first interval.
    long_ns: i64,
}

impl Gaps {
    /// Learns from the interval between two reports of one sensor track.
    #[inline]
    pub(crate) fn learn(&mut self, interval_ns: i64) {
        if self.long_ns == 0 {
            self.long_ns = interval_ns.clamp(1, SILENCE_MAX_NS);
        }
        let long_ns = self.long_ns as f64;
        let step = if interval_ns > self.long_ns {
            STEP * (1.0 - BEYOND)
        } else {
            -STEP * BEYOND
        };
        self.long_ns = ((long_ns + step * long_ns) as i64).min(SILENCE_MAX_NS);
    }

    /// Silence after which no further report of a target is expected, nanoseconds; 0 if unknown.
    #[inline]
    pub(crate) fn silence_ns(&self) -> i64 {
        ((MARGIN * self.long_ns as f64) as i64).min(SILENCE_MAX_NS)
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    fn learned(intervals_s: impl Iterator<Item = f64>) -> f64 {
        let mut gaps = Gaps::default();
        for interval_s in intervals_s {
            gaps.learn((interval_s * S as f64) as i64);
        }
        gaps.silence_ns() as f64 / S as f64
    }

    #[test]
    fn rare_gaps_count_where_they_are_as_frequent_as_one_in_a_hundred() {
        let every = |gap: u32, count: u32| (0..count).map(move |at| if at % gap == gap - 1 { 30.0 } else { 5.0 });
        let often = learned(every(50, 6_000));
        assert!((28.0..45.0).contains(&often), "{often}");
        let seldom = learned(every(400, 40_000));
        assert!((5.0..14.0).contains(&seldom), "{seldom}");
    }

    #[test]
    fn regular_reports_leave_no_gap_and_a_lasting_one_is_limited() {
        let regular = learned((0..5_000).map(|_| 4.0));
        assert!((4.0..5.5).contains(&regular), "{regular}");
        assert_eq!(
            learned((0..5_000).map(|at| if at % 2 == 0 { 900.0 } else { 4.0 })),
            60.0
        );
    }
}
