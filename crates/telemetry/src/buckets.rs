//! Distribution as counts between fixed bounds, the form that collectors of metrics store.
//!
//! Percentiles cannot be added over machines or times. Counts between the same bounds can, and their sum gives an
//! estimate of percentiles. The price is resolution: three bounds per decade resolve a latency to a factor of about
//! two. The exact figures are in the report and in the histogram files.

use hdrhistogram::Histogram;

/// Upper bounds, nanoseconds: one, two and five times each power of ten from one microsecond to 100 seconds. Longer
/// latencies count beyond the last bound.
pub const BUCKET_BOUNDS_NS: [u64; 25] = {
    let mut bounds_ns = [0; 25];
    let (mut index, mut decade_ns) = (0, 1_000);
    while index < bounds_ns.len() {
        bounds_ns[index] = [1, 2, 5][index % 3] * decade_ns;
        if index % 3 == 2 {
            decade_ns *= 10;
        }
        index += 1;
    }
    bounds_ns
};

/// Distribution as counts between fixed bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Buckets {
    /// Number of latencies up to each bound of [`BUCKET_BOUNDS_NS`] and above the bound before; the last count is
    /// beyond all bounds.
    pub counts: [u64; BUCKET_BOUNDS_NS.len() + 1],
    /// Sum of all latencies, nanoseconds.
    pub sum_ns: f64,
}

impl From<&Histogram<u64>> for Buckets {
    fn from(histogram: &Histogram<u64>) -> Self {
        let mut buckets = Self::default();
        let mut bucket = 0;
        for step in histogram.iter_recorded() {
            let (value_ns, count) = (step.value_iterated_to(), step.count_at_value());
            while BUCKET_BOUNDS_NS
                .get(bucket)
                .is_some_and(|bound_ns| value_ns > *bound_ns)
            {
                bucket += 1;
            }
            buckets.counts[bucket] += count;
            buckets.sum_ns += value_ns as f64 * count as f64;
        }
        buckets
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_rise_from_a_microsecond_to_a_hundred_seconds() {
        assert_eq!(BUCKET_BOUNDS_NS[..4], [1_000, 2_000, 5_000, 10_000]);
        assert_eq!(BUCKET_BOUNDS_NS[24], 100_000_000_000);
    }

    #[test]
    fn every_latency_is_counted_once_at_its_place() {
        let mut histogram = Histogram::new(3).expect("possible");
        for (value_ns, count) in [(1, 2), (1_000, 3), (1_001, 5), (4_000_000, 7), (200_000_000_000, 11)] {
            histogram.record_n(value_ns, count).expect("grows");
        }
        let buckets = Buckets::from(&histogram);
        assert_eq!(buckets.counts.iter().sum::<u64>(), histogram.len());
        assert_eq!(buckets.counts[..2], [5, 5]);
        assert_eq!(buckets.counts[11], 7, "up to 5 ms");
        assert_eq!(buckets.counts[25], 11);
        let sum_ns = 2.0 + 3_000.0 + 5_005.0 + 28e6 + 2.2e12;
        assert!((buckets.sum_ns / sum_ns - 1.0).abs() < 1e-3, "{}", buckets.sum_ns);
        assert_eq!(Buckets::from(&Histogram::new(3).expect("possible")), Buckets::default());
    }
}
