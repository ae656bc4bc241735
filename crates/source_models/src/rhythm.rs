//! Report interval of a single target, if longer than for other targets of the same sources.
//!
//! The period of a source is the time between two reports of most of its targets. A target at the edge of coverage,
//! behind hills, with a weak transponder, or a ship at anchor among ships under way, has far fewer reports. By the
//! period, its track would end after each report. Each system track therefore learns the mean interval between its own
//! reports. From the third report on, a mean longer than [`SLOW`] periods replaces the period.
//!
//! A target without an address or MMSI is slow only while most of its last intervals are long. With an address or MMSI,
//! a single gap sets the expectation: the target comes back under its number in any case.
//!
//! The mean follows the last few intervals, so the period soon holds again for a ship that weighs anchor. Reports of
//! all sources count alike: a target with frequent reports of any source is not slow.

use messages::NS_PER_S;
use serde::{Deserialize, Serialize};

use crate::settings::FRESH_PERIODS;

/// Least ratio between the intervals of a slow target and the period: gaps of up to two missed reports are not a
/// rhythm.
const SLOW: f64 = 2.0;
/// Number of intervals in the mean.
const MEMORY: u8 = 4;
/// Number of last intervals: without a name, most must be long.
const LAST: u32 = 3;
/// Number of intervals for a valid mean.
const ENOUGH: u8 = 2;
/// Silence after which a target has gone, in mean intervals: of intervals without any rhythm, 2 % are longer.
const SILENCE: f64 = 4.0;

/// The rhythm of a target.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Rhythm {
    /// Validity time of reports of the target, nanoseconds; 0 if the validity time of the sources' reports holds.
    fresh_ns: i64,
    /// Mean interval, seconds.
    interval_s: f32,
    /// Intervals so far, up to [`MEMORY`].
    intervals: u8,
    /// Long intervals among the last [`LAST`], as bits.
    long: u8,
}

impl Rhythm {
    /// Learns from the time since the previous report; `usual_ns` is the validity time of reports of the present
    /// source. Without a name, a single gap is no rhythm: most of the last intervals must be long.
    #[inline]
    pub fn learn(&mut self, interval_ns: i64, usual_ns: i64, is_named: bool) {
        let slow_ns = usual_ns as f64 * (SLOW / FRESH_PERIODS);
        let is_long = interval_ns as f64 > slow_ns;
        self.long = (self.long << 1 | u8::from(is_long)) & ((1 << LAST) - 1);
        if !is_long && self.intervals == MEMORY && self.fresh_ns == 0 {
            // Of a usual rhythm, the mean need not be exact: most reports cost nothing more.
            return;
        }
        let interval_s = (interval_ns as f64 / NS_PER_S) as f32;
        let slow_s = (slow_ns / NS_PER_S) as f32;
        self.intervals = (self.intervals + 1).min(MEMORY);
        self.interval_s += (interval_s - self.interval_s) / f32::from(self.intervals);
        self.fresh_ns = 0;
        if self.interval_s > slow_s && self.intervals >= ENOUGH {
            let is_steady = is_named || 2 * self.long.count_ones() > LAST;
            self.fresh_ns = i64::from(is_steady) * (FRESH_PERIODS * f64::from(self.interval_s) * NS_PER_S) as i64;
        }
    }

    /// Validity time of reports of the target, nanoseconds; 0 if the validity time of the sources' reports holds.
    #[inline]
    pub fn fresh_ns(&self) -> i64 {
        self.fresh_ns
    }

    /// Whether the target has fewer reports than other targets of the same sources.
    #[inline]
    pub fn is_slow(&self) -> bool {
        self.fresh_ns > 0
    }

    /// Mean time between two reports of the target, nanoseconds; 0 if the period of the sources holds.
    pub fn interval_ns(&self) -> i64 {
        (self.fresh_ns as f64 / FRESH_PERIODS) as i64
    }

    /// Silence after which the target has gone, nanoseconds; 0 if the silence limit of the sources holds.
    pub fn silence_ns(&self) -> i64 {
        (SILENCE / FRESH_PERIODS * self.fresh_ns as f64) as i64
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    fn learned(intervals_s: &[i64], is_named: bool) -> Rhythm {
        let mut rhythm = Rhythm::default();
        for interval_s in intervals_s {
            rhythm.learn(interval_s * S, 12 * S, is_named);
        }
        rhythm
    }

    #[test]
    fn the_period_holds_until_the_third_report_and_for_missed_reports() {
        for is_named in [false, true] {
            assert_eq!(learned(&[40], is_named).fresh_ns(), 0);
            assert_eq!(learned(&[40, 20], is_named).fresh_ns(), 75 * S);
            assert_eq!(learned(&[40, 20], is_named).silence_ns(), 120 * S);
            assert_eq!(learned(&[40, 20], is_named).interval_ns(), 30 * S);
            assert!(!learned(&[5, 5, 10, 15, 5, 10, 5], is_named).is_slow());
        }
    }

    #[test]
    fn one_gap_is_a_rhythm_of_a_named_target_alone() {
        let slow = |is_named| learned(&[4, 40, 6, 5], is_named).is_slow();
        assert_eq!([false, true].map(slow), [false, true]);
    }

    #[test]
    fn a_target_that_is_reported_often_again_is_measured_by_the_period_again() {
        let mut rhythm = learned(&[180; 20], true);
        assert!(rhythm.is_slow());
        let reports = (1..).find(|_| {
            rhythm.learn(5 * S, 12 * S, true);
            !rhythm.is_slow()
        });
        assert!(reports.is_some_and(|reports| reports < 15), "{reports:?}");
    }
}
