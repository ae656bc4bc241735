//! Jitter of the machine itself.
//!
//! A thread that only reads the clock should observe a continuous time. A gap longer than the cost of a reading
//! means that something else had the core: an interrupt, another process, the host of a virtual machine. No latency
//! can be better than these gaps, so they are measured next to each latency, on the same core, at the same
//! priority.
//!
//! The same readings give two distributions. *Gaps* are the times between successive readings beyond the usual
//! time: the absences of the machine. *Lateness* is the delay of the next reading after each due time of the
//! reports: the share of jitter in a latency, percentile by percentile.

use hdrhistogram::Histogram;

use crate::drive::Clock;
use crate::pace::Pace;
use crate::recorder::histogram;

/// Length of a gap, in readings, above which the gap counts as an interruption rather than a slow reading.
const INTERRUPTION: u64 = 10;
/// Number of readings that determine the usual gap.
const FIRST: usize = 10_000;

/// Jitter, see the module's documentation. Nanoseconds.
#[derive(Clone, Debug)]
pub(crate) struct Jitter {
    /// Usual time between two readings: the cost of a reading.
    pub(crate) reading_ns: u64,
    /// Times between readings, less the cost of a reading; gaps of a few readings are omitted.
    pub(crate) gaps: Histogram<u64>,
    /// Number of readings.
    pub(crate) readings: u64,
    /// Lateness at due times.
    pub(crate) lateness: Histogram<u64>,
}

impl Jitter {
    pub(crate) fn new() -> Self {
        Self {
            reading_ns: u64::MAX,
            gaps: histogram(),
            readings: 0,
            lateness: histogram(),
        }
    }

    /// Reads the clock for `seconds`, as if batches were due at `rate` per second. With rests, the thread sleeps
    /// when the schedule permits.
    pub(crate) fn measure(clock: &impl Clock, seconds: f64, rate: f64, rests: bool) -> Self {
        let mut jitter = Self::new();
        jitter.reading_ns = reading_ns(clock);
        let pace = Pace::new(clock.now_ns(), rate, rests);
        let batches = (seconds * rate).max(1.0) as u64;
        let mut last_ns = clock.now_ns();
        let mut due_ns = pace.due_ns(0);
        let mut batch = 0;
        while batch < batches {
            let now_ns = clock.now_ns();
            let gap_ns = (now_ns - last_ns) as u64;
            if gap_ns > INTERRUPTION * jitter.reading_ns {
                jitter.gaps.saturating_record(gap_ns - jitter.reading_ns);
            }
            jitter.readings += 1;
            last_ns = now_ns;
            while due_ns <= now_ns && batch < batches {
                jitter.lateness.saturating_record((now_ns - due_ns).max(1) as u64);
                batch += 1;
                due_ns = pace.due_ns(batch);
            }
            if rests && due_ns - now_ns > 1_000_000 {
                clock.sleep(due_ns - now_ns - 200_000);
                last_ns = clock.now_ns();
            }
        }
        jitter
    }

    /// Adds another measurement.
    pub(crate) fn add(&mut self, other: &Self) {
        self.reading_ns = self.reading_ns.min(other.reading_ns);
        self.readings += other.readings;
        self.gaps.add(&other.gaps).expect("the same bounds");
        self.lateness.add(&other.lateness).expect("the same bounds");
    }
}

/// Returns the cost of a clock reading: the median over successive readings, nanoseconds.
pub(crate) fn reading_ns(clock: &impl Clock) -> u64 {
    let mut gaps: Vec<u64> = Vec::with_capacity(FIRST);
    let mut last_ns = clock.now_ns();
    for _ in 0..FIRST {
        let now_ns = clock.now_ns();
        gaps.push((now_ns - last_ns) as u64);
        last_ns = now_ns;
    }
    gaps.sort_unstable();
    gaps[FIRST / 2].max(1)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// Fake clock: 40 ns a reading, and an absence of 10 µs every millisecond.
    struct Interrupted(Cell<i64>);

    impl Clock for Interrupted {
        fn now_ns(&self) -> i64 {
            let before = self.0.get();
            let after = before + 40;
            let interrupted = after / 1_000_000 != before / 1_000_000;
            self.0.set(if interrupted { after + 10_000 } else { after });
            self.0.get()
        }

        fn sleep(&self, nanoseconds: i64) {
            self.0.set(self.0.get() + nanoseconds);
        }
    }

    #[test]
    fn interruptions_are_seen_as_gaps_and_at_due_times() {
        let jitter = Jitter::measure(&Interrupted(Cell::new(0)), 1.0, 100_000.0, false);
        assert_eq!(jitter.reading_ns, 40);
        assert!((985..=1000).contains(&jitter.gaps.len()), "{}", jitter.gaps.len());
        assert!(jitter.gaps.min().abs_diff(10_000) < 20);
        // Due every 10 µs: one in a hundred falls into the 10 µs of an interruption.
        let late = jitter.lateness.count_between(100, u64::MAX);
        assert!((950..=1050).contains(&late), "{late}");
        assert!(jitter.lateness.value_at_quantile(0.5) <= 40);
    }
}
