//! A distribution in a few figures.

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

/// Count, percentiles, maximum and mean of latencies; all 0 if there were none. Each is the upper end of the range
/// that the histogram cannot tell apart, at most 0.1 % too long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How many there were.
    pub count: u64,
    /// Half of them took no longer than this, nanoseconds.
    pub p50_ns: u64,
    /// 90 % took no longer than this, nanoseconds.
    pub p90_ns: u64,
    /// 99 % took no longer than this, nanoseconds.
    pub p99_ns: u64,
    /// 99.9 % took no longer than this, nanoseconds.
    pub p999_ns: u64,
    /// The longest, nanoseconds.
    pub max_ns: u64,
    /// Their mean, nanoseconds.
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
