//! Distribution in a few figures.

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

/// Count, percentiles, maximum and mean of latencies; all 0 without latencies. Each figure is the upper end of the
/// histogram's bucket, at most 0.1 % too long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Number of latencies.
    pub count: u64,
    /// Median, nanoseconds.
    pub p50_ns: u64,
    /// 90th percentile, nanoseconds.
    pub p90_ns: u64,
    /// 99th percentile, nanoseconds.
    pub p99_ns: u64,
    /// 99.9th percentile, nanoseconds.
    pub p999_ns: u64,
    /// Maximum, nanoseconds.
    pub max_ns: u64,
    /// Mean, nanoseconds.
    pub mean_ns: f64,
}

impl From<&Histogram<u64>> for Summary {
    fn from(histogram: &Histogram<u64>) -> Self {
        if histogram.is_empty() {
            return Self::default();
        }
        let at = |quantile| histogram.value_at_quantile(quantile);
        Self {
            count: histogram.len(),
            p50_ns: at(0.5),
            p90_ns: at(0.9),
            p99_ns: at(0.99),
            p999_ns: at(0.999),
            max_ns: histogram.max(),
            mean_ns: histogram.mean(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_keys() {
        let mut histogram = Histogram::new(3).expect("possible");
        histogram.record(1500).expect("grows");
        let text = serde_json::to_string(&Summary::from(&histogram)).expect("serialisable");
        assert_eq!(
            text,
            r#"{"count":1,"p50_ns":1500,"p90_ns":1500,"p99_ns":1500,"p999_ns":1500,"max_ns":1500,"mean_ns":1500.0}"#
        );
        let back: Summary = serde_json::from_str(&text).expect("its own output");
        assert_eq!(back, Summary::from(&histogram));
    }
}
