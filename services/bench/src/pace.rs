//! Due times of the reports.
//!
//! A load generator that sends its next report after the answer to the last report hides stalls: a stall of the
//! measured process stalls the generator too. It then records one long latency where hundreds of reports would have
//! waited (coordinated omission; G. Tene, *How NOT to Measure Latency*). Here the times are fixed in advance: batch
//! *k* is due at `start + k × interval` in any case, and latency counts from there.
//!
//! A thread with a real-time priority must not spin all the time: otherwise the kernel takes the core away for 50
//! ms in every second. Its schedule therefore has rests: stretches without due reports, in which the thread can
//! sleep.

/// Due times of the batches of one load, nanoseconds of the monotonic clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pace {
    start_ns: i64,
    interval_ns: f64,
    /// Number of batches between two rests, and length of a rest, nanoseconds.
    rests: Option<(u64, f64)>,
}

/// Time from the start of one rest to the start of the next, nanoseconds.
const REST_EVERY_NS: f64 = 50e6;
/// Length of a rest, nanoseconds; leaves well below 95 % of the time for spinning.
const REST_NS: f64 = 6e6;
/// Margin at both ends of a rest for a process that rests together with the bench, nanoseconds.
const REST_MARGIN_NS: f64 = 300e3;

impl Pace {
    /// Creates a pace of `rate` batches per second from `start_ns` on; rests are additional time.
    pub(crate) fn new(start_ns: i64, rate: f64, with_rests: bool) -> Self {
        let interval_ns = 1e9 / rate;
        let between = ((REST_EVERY_NS - REST_NS) / interval_ns).floor().max(1.0);
        // Large intervals between batches leave time to rest anyway.
        let needed = with_rests && interval_ns < REST_NS;
        Self {
            start_ns,
            interval_ns,
            rests: needed.then_some((between as u64, REST_NS)),
        }
    }

    /// Returns the rest of a process that answers at once: nanoseconds without work before the sleep, and
    /// nanoseconds of sleep. Nothing is due meanwhile.
    pub(crate) fn idle_rest_ns(&self) -> Option<(i64, i64)> {
        self.rests?;
        let idle_ns = 1.5 * self.interval_ns + REST_MARGIN_NS;
        let sleep_ns = REST_NS - idle_ns - 3.0 * REST_MARGIN_NS;
        (sleep_ns > 0.0).then_some((idle_ns as i64, sleep_ns as i64))
    }

    /// Returns the due time of batch number `batch`.
    pub(crate) fn due_ns(&self, batch: u64) -> i64 {
        let rests_ns = self
            .rests
            .map_or(0.0, |(between, rest_ns)| (batch / between) as f64 * rest_ns);
        self.start_ns + (batch as f64 * self.interval_ns + rests_ns).round() as i64
    }

    /// Returns the batch that is due at `due_ns`; `None` before the first.
    pub(crate) fn batch_at(&self, due_ns: i64) -> Option<u64> {
        let elapsed_ns = (due_ns - self.start_ns) as f64;
        if elapsed_ns < 0.0 {
            return None;
        }
        let (before, rest_ns) = match self.rests {
            None => (0, elapsed_ns),
            Some((between, rest_ns)) => {
                let cycle_ns = between as f64 * self.interval_ns + rest_ns;
                // Due times are rounded to whole nanoseconds.
                let cycles = ((elapsed_ns + 1.0) / cycle_ns).floor();
                (cycles as u64 * between, elapsed_ns - cycles * cycle_ns)
            }
        };
        Some(before + (rest_ns / self.interval_ns).round() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn due_times_are_evenly_spaced_and_lead_back_to_their_batch() {
        for (rate, with_rests) in [(20_000.0, false), (20_000.0, true), (333_333.3, true), (7.0, true)] {
            let pace = Pace::new(1_000_000_007, rate, with_rests);
            for batch in (0..200_000).step_by(7) {
                assert_eq!(pace.batch_at(pace.due_ns(batch)), Some(batch), "{rate} {with_rests}");
            }
            assert_eq!(pace.batch_at(1_000_000_006), None);
        }
        let even = Pace::new(0, 1000.0, false);
        assert_eq!(
            [0, 1, 1000].map(|batch| even.due_ns(batch)),
            [0, 1_000_000, 1_000_000_000]
        );
    }

    #[test]
    fn rests_leave_less_than_95_percent_of_the_time() {
        let pace = Pace::new(0, 20_000.0, true);
        let second = pace.batch_at(1_000_000_000).unwrap();
        let busy_ns = second as f64 * 50_000.0;
        assert!(busy_ns < 0.95e9, "{busy_ns}");
        assert!(busy_ns > 0.85e9, "{busy_ns}");
        let (idle_ns, sleep_ns) = pace.idle_rest_ns().unwrap();
        assert!(idle_ns > 50_000 && sleep_ns > 4_000_000 && idle_ns + sleep_ns < 6_000_000);
        assert_eq!(Pace::new(0, 20_000.0, false).idle_rest_ns(), None);
    }
}
