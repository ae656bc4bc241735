//! Times of publication of the track picture (WA-11): at a fixed period, independent of the sensors.
//!
//! Scans come at irregular times; a display or another system needs the confirmed tracks at even times. So the times
//! are multiples of the period, and the tracks are moved to these times
//! ([`Tracker::picture_at`](crate::Tracker::picture_at)).

/// Most pictures that are made up for after a pause.
const BEHIND_MAX: i64 = 100;

/// Successive even times.
#[derive(Clone, Debug)]
pub struct OutputSchedule {
    period_ns: i64,
    next_ns: Option<i64>,
}

impl OutputSchedule {
    /// Every `period_ns`, at least 1 ns.
    pub fn new(period_ns: i64) -> Self {
        Self {
            period_ns: period_ns.max(1),
            next_ns: None,
        }
    }

    /// Time between two even times, nanoseconds.
    pub fn period_ns(&self) -> i64 {
        self.period_ns
    }

    /// Whether [`Self::next`] has a time until `now_ns`; never before the first call of [`Self::next`].
    pub fn is_due(&self, now_ns: i64) -> bool {
        self.next_ns.is_some_and(|next_ns| next_ns <= now_ns)
    }

    /// The next time of a picture, if not after `now_ns`; to be called until `None`. The first picture is at the first
    /// even time from the first `now_ns` on; after a pause at most the last hundred are made up for.
    pub fn next(&mut self, now_ns: i64) -> Option<i64> {
        let even = |time_ns: i64| time_ns.div_euclid(self.period_ns).saturating_mul(self.period_ns);
        let first_ns = || even(now_ns.saturating_sub(1)).saturating_add(self.period_ns);
        let earliest_ns = even(now_ns).saturating_sub(self.period_ns.saturating_mul(BEHIND_MAX - 1));
        let next_ns = self.next_ns.map_or_else(first_ns, |next_ns| next_ns.max(earliest_ns));
        let is_due = next_ns <= now_ns;
        self.next_ns = Some(if is_due {
            next_ns.saturating_add(self.period_ns)
        } else {
            next_ns
        });
        is_due.then_some(next_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_at_even_times_whatever_comes_between() {
        let mut schedule = OutputSchedule::new(10);
        let mut found = Vec::new();
        assert!(!schedule.is_due(100), "no time has come yet");
        for now_ns in [-3, 4, 5, 9, 31, 31, 40] {
            while let Some(time_ns) = schedule.next(now_ns) {
                found.push((now_ns, time_ns));
            }
        }
        assert_eq!(found, [(4, 0), (31, 10), (31, 20), (31, 30), (40, 40)]);
        assert_eq!([49, 50].map(|now_ns| schedule.is_due(now_ns)), [false, true]);
    }

    #[test]
    fn a_long_pause_is_not_made_up_for_whole() {
        let mut schedule = OutputSchedule::new(10);
        assert_eq!(schedule.next(0), Some(0));
        let mut found = Vec::new();
        while let Some(time_ns) = schedule.next(1_000_000_005) {
            found.push(time_ns);
        }
        assert_eq!((found.len(), found.last()), (100, Some(&1_000_000_000)));
        let mut extreme = OutputSchedule::new(i64::MAX);
        while extreme.next(i64::MAX).is_some_and(|time_ns| time_ns < i64::MAX) {}
    }
}
