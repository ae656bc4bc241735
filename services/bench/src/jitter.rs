//! What the machine does by itself.
//!
//! A thread that does nothing but read the clock should see every time there is. Where two readings are farther apart
//! than two readings take, something else had the core: an interrupt, another process, the host of a virtual machine.
//! No latency can be better than that, so it is measured next to each, on the same core, at the same priority.
//!
//! Two distributions come of the same readings. *Gaps* are the times between successive readings beyond the
//! usual one: how long the machine is away. *Lateness* asks at the times at which reports would have been due, how much
//! later the next reading was: what of it a latency shows, percentile by percentile.

use hdrhistogram::Histogram;

use crate::drive::Clock;
use crate::pace::Pace;
use crate::recorder::histogram;

/// A gap of more readings than this is an interruption, and not a reading that took a little longer.
const INTERRUPTION: u64 = 10;
/// Readings from which the usual gap is taken.
const FIRST: usize = 10_000;

/// See the module's documentation. Nanoseconds.
#[derive(Clone, Debug)]
pub(crate) struct Jitter {
    /// The usual time between two readings: what one costs.
    pub(crate) reading_ns: u64,
    /// Times between readings, beyond what one takes; those of a few readings' length are left out.
    pub(crate) gaps: Histogram<u64>,
    /// Readings.
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

    /// Reads the clock for `seconds`, as if batches were due at `rate` per second. With rests, the thread sleeps when
    /// the schedule lets it.
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

    /// Takes another measurement in.
    pub(crate) fn add(&mut self, other: &Self) {
        self.reading_ns = self.reading_ns.min(other.reading_ns);
        self.readings += other.readings;
        self.gaps.add(&other.gaps).expect("the same bounds");
        self.lateness.add(&other.lateness).expect("the same bounds");
    }
}

/// What reading the clock costs: the median over successive readings, nanoseconds.
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

    /// 40 ns a reading, and every millisecond 10 µs elsewhere.
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
        // Due every 10 µs: one of a hundred falls into the 10 µs of an interruption.
        let late = jitter.lateness.count_between(100, u64::MAX);
        assert!((950..=1050).contains(&late), "{late}");
        assert!(jitter.lateness.value_at_quantile(0.5) <= 40);
    }
}
