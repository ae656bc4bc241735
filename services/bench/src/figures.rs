//! Figures of one distribution, and of several runs of the same measurement.

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};
use telemetry::Summary;

/// Latencies in a JSON file (FM-4), nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Number of latencies.
    pub count: u64,
    /// Reports without an answer.
    pub lost: u64,
    /// Median.
    pub p50_ns: u64,
    /// 90th percentile.
    pub p90_ns: u64,
    /// 99th percentile.
    pub p99_ns: u64,
    /// 99.9th percentile.
    pub p999_ns: u64,
    /// Maximum.
    pub max_ns: u64,
}

impl Figures {
    /// Returns the figures of one distribution.
    pub(crate) fn of(histogram: &Histogram<u64>, lost: u64) -> Self {
        let summary = Summary::from(histogram);
        Self {
            count: summary.count,
            lost,
            p50_ns: summary.p50_ns,
            p90_ns: summary.p90_ns,
            p99_ns: summary.p99_ns,
            p999_ns: summary.p999_ns,
            max_ns: summary.max_ns,
        }
    }

    /// Returns the percentiles and the maximum, in the order of [`Self::NAMES`].
    pub(crate) fn values(&self) -> [u64; 5] {
        [self.p50_ns, self.p90_ns, self.p99_ns, self.p999_ns, self.max_ns]
    }

    /// Names of [`Figures::values`] in tables.
    pub(crate) const NAMES: [&'static str; 5] = ["p50", "p90", "p99", "p99.9", "max"];

    /// Returns the median of each figure over `runs`; counts and losses are summed, and the maximum is that of all
    /// runs.
    pub(crate) fn median(runs: &[Self]) -> Self {
        let middle = |of: fn(&Self) -> u64| median(&runs.iter().map(|run| of(run) as f64).collect::<Vec<_>>()) as u64;
        Self {
            count: runs.iter().map(|run| run.count).sum(),
            lost: runs.iter().map(|run| run.lost).sum(),
            p50_ns: middle(|run| run.p50_ns),
            p90_ns: middle(|run| run.p90_ns),
            p99_ns: middle(|run| run.p99_ns),
            p999_ns: middle(|run| run.p999_ns),
            max_ns: runs.iter().map(|run| run.max_ns).max().unwrap_or(0),
        }
    }
}

/// Returns the median of `values`, in any order; 0 if empty.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        odd if odd % 2 == 1 => sorted[odd / 2],
        even => f64::midpoint(sorted[even / 2 - 1], sorted[even / 2]),
    }
}

/// Returns the smallest and largest of `values`; zeros if empty.
pub(crate) fn range(values: &[f64]) -> (f64, f64) {
    let low = values.iter().copied().reduce(f64::min).unwrap_or(0.0);
    let high = values.iter().copied().reduce(f64::max).unwrap_or(0.0);
    (low, high)
}

/// Median of paired ratios with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Ratio {
    /// Number of pairs.
    pub(crate) pairs: usize,
    /// Median of the ratios.
    pub(crate) median: f64,
    /// Lower end of the interval; 0 with too few pairs.
    pub(crate) low: f64,
    /// Upper end of the interval; infinite with too few pairs, which JSON writes as null.
    #[serde(with = "infinite_as_null")]
    pub(crate) high: f64,
}

impl Ratio {
    /// Computes the ratio from pairs (with, without).
    ///
    /// The interval consists of order statistics. For any distribution of ratios, the true median lies between the
    /// k-th smallest and the k-th largest of n values with a probability given by the binomial distribution alone
    /// (the inverted sign test; W. J. Conover, *Practical Nonparametric Statistics*, 3.1). Latencies have heavier
    /// tails than a normal distribution. Fewer than six pairs permit no statement at 95 %.
    pub(crate) fn of_pairs(pairs: &[(f64, f64)]) -> Self {
        let usable = pairs.iter().filter(|(with, without)| *with > 0.0 && *without > 0.0);
        let mut ratios: Vec<f64> = usable.map(|(with, without)| with / without).collect();
        ratios.sort_by(f64::total_cmp);
        let rank = sign_rank(ratios.len());
        Self {
            pairs: ratios.len(),
            median: median(&ratios),
            low: rank.map_or(0.0, |rank| ratios[rank - 1]),
            high: rank.map_or(f64::INFINITY, |rank| ratios[ratios.len() - rank]),
        }
    }
}

/// JSON has no infinity.
mod infinite_as_null {
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    pub(super) fn serialize<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
    }
}

/// Returns the largest k for which the k-th smallest and k-th largest of `count` enclose the median with at least
/// 95 %.
fn sign_rank(count: usize) -> Option<usize> {
    let mut rank = None;
    // Probability of fewer than k successes in `count` throws of a fair coin.
    let mut below = 0.0;
    let mut term = 0.5f64.powi(count as i32);
    for k in 1..=count / 2 {
        below += term;
        if below > 0.025 {
            break;
        }
        rank = Some(k);
        term *= (count + 1 - k) as f64 / k as f64;
    }
    rank
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_ranges() {
        assert_eq!(
            (median(&[]), median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0])),
            (0.0, 2.0, 2.5)
        );
        assert_eq!(range(&[2.0, 1.0, 5.0]), (1.0, 5.0));
        let run = |p50_ns, max_ns| Figures {
            count: 10,
            lost: 1,
            p50_ns,
            max_ns,
            ..Figures::default()
        };
        let all = Figures::median(&[run(5, 50), run(3, 90), run(4, 20)]);
        assert_eq!((all.count, all.lost, all.p50_ns, all.max_ns), (30, 3, 4, 90));
    }

    #[test]
    fn ranks_are_those_of_the_tables() {
        // W. J. Conover, table A4: the smallest numbers of pairs for each rank at 95 %.
        for (count, rank) in [
            (5, None),
            (6, Some(1)),
            (9, Some(2)),
            (11, Some(2)),
            (12, Some(3)),
            (20, Some(6)),
        ] {
            assert_eq!(sign_rank(count), rank, "{count}");
        }
    }

    #[test]
    fn an_interval_covers_what_did_not_change_and_not_what_did() {
        let pairs = |factor: f64| {
            (0..11)
                .map(move |run| (factor * (100.0 + f64::from(run % 4)), 101.5))
                .collect::<Vec<_>>()
        };
        let same = Ratio::of_pairs(&pairs(1.0));
        assert!(same.low < 1.0 && same.high > 1.0, "{same:?}");
        let slower = Ratio::of_pairs(&pairs(1.2));
        assert!(slower.low > 1.15 && slower.high < 1.25, "{slower:?}");
        let few = Ratio::of_pairs(&pairs(1.2)[..5]);
        assert_eq!((few.low, few.high), (0.0, f64::INFINITY));
        let text = serde_json::to_string(&few).unwrap();
        assert!(text.contains("\"high\":null"), "{text}");
        assert_eq!(serde_json::from_str::<Ratio>(&text).unwrap(), few);
    }
}
