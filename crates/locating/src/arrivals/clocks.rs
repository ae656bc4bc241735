//! Clocks of the receivers.
//!
//! Only differences of clocks matter, so each pair of receivers has a separate estimate: exact where all receivers take
//! the reference emitter's transmissions, and independent of the emitters that each pair can receive. A pair without
//! common reference is compared over a third receiver.

use observations::ReceiverName;

use super::pair_clock::{ClockModel, ClockReading, PairClock};

/// Most receivers with a separate clock.
pub(crate) const RECEIVERS_MAX: usize = 32;
const PAIRS: usize = RECEIVERS_MAX * (RECEIVERS_MAX - 1) / 2;

/// Differences of all clocks.
#[derive(Debug)]
pub(crate) struct Clocks {
    model: ClockModel,
    names: Vec<ReceiverName>,
    pairs: Vec<PairClock>,
}

impl Clocks {
    pub(crate) fn new(model: ClockModel) -> Self {
        Self {
            model,
            names: Vec::with_capacity(RECEIVERS_MAX),
            pairs: vec![PairClock::UNKNOWN; PAIRS],
        }
    }

    /// Number of a receiver; `None` if there are too many.
    pub(crate) fn number(&mut self, name: ReceiverName) -> Option<usize> {
        let known = self.names.iter().position(|known| *known == name);
        if known.is_none() && self.names.len() < RECEIVERS_MAX {
            self.names.push(name);
            return Some(self.names.len() - 1);
        }
        known
    }

    /// Takes how far the clock of receiver `one` is ahead of that of `other`.
    pub(crate) fn take(&mut self, one: usize, other: usize, reading: ClockReading) {
        if one == other {
            return;
        }
        let sign = if one < other { 1.0 } else { -1.0 };
        let reading = ClockReading {
            ahead_m: sign * reading.ahead_m,
            ..reading
        };
        self.pairs[pair(one, other)].take(reading, self.model);
    }

    /// How far the clock of receiver `one` is ahead of that of `other` at a time, and the variance: metres of way, m².
    pub(crate) fn ahead(&self, one: usize, other: usize, time_ns: i64) -> Option<(f64, f64)> {
        let over = |third: usize| {
            let (first_m, first_m2) = self.direct(one, third, time_ns)?;
            let (second_m, second_m2) = self.direct(third, other, time_ns)?;
            Some((first_m + second_m, first_m2 + second_m2))
        };
        self.direct(one, other, time_ns).or_else(|| {
            let ways = (0..self.names.len()).filter_map(over);
            ways.min_by(|one, other| one.1.total_cmp(&other.1))
        })
    }

    fn direct(&self, one: usize, other: usize, time_ns: i64) -> Option<(f64, f64)> {
        if one == other {
            return Some((0.0, 0.0));
        }
        let (ahead_m, variance_m2) = self.pairs[pair(one, other)].at(time_ns, self.model)?;
        Some((if one < other { ahead_m } else { -ahead_m }, variance_m2))
    }
}

/// Place of two receivers' pair.
fn pair(one: usize, other: usize) -> usize {
    let (low, high) = (one.min(other), one.max(other));
    high * (high - 1) / 2 + low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_compared_over_a_third_receiver() {
        let mut clocks = Clocks::new(ClockModel {
            drift_sigma_mps: 3_000.0,
            drift_noise: 0.0,
        });
        let [a, b, c] = ["a", "b", "c"].map(|name| clocks.number(ReceiverName::new(name).unwrap()).unwrap());
        for second in 0..10 {
            let reading = |ahead_m: f64| ClockReading {
                time_ns: second * 1_000_000_000,
                ahead_m,
                variance_m2: 1.0,
            };
            clocks.take(b, a, reading(50.0));
            clocks.take(b, c, reading(-20.0));
        }
        let now_ns = 9_000_000_000;
        let (ahead_m, _) = clocks.ahead(a, b, now_ns).unwrap();
        assert!((ahead_m + 50.0).abs() < 1e-3, "{ahead_m}");
        let (ahead_m, variance_m2) = clocks.ahead(a, c, now_ns).unwrap();
        assert!(
            (ahead_m + 70.0).abs() < 1e-3 && variance_m2 > 0.6,
            "{ahead_m} {variance_m2}"
        );
        assert_eq!(clocks.ahead(c, c, now_ns), Some((0.0, 0.0)));
    }

    #[test]
    fn all_pairs_have_a_place_of_their_own() {
        let mut places: Vec<_> = (0..RECEIVERS_MAX)
            .flat_map(|high| (0..high).map(move |low| pair(low, high)))
            .collect();
        places.sort_unstable();
        assert_eq!(places, (0..PAIRS).collect::<Vec<_>>());
    }
}
