//! Limits beyond which alarms are raised.

use settings::Seconds;

use crate::board::Finding;

/// Share of a limit below which an alarm is cleared again.
const CLEARED_SHARE: f64 = 0.6;

settings::settings! {
    /// Limits beyond which alarms are raised.
    #[derive(Copy)]
    pub struct Limits {
        /// Offset of a source's clock.
        clock_off_s: Seconds = Seconds::of(1.0), in [1e-3, 3600];
        /// Offset of the newest states from the machine's clock.
        data_off_s: Seconds = Seconds::of(3.0), in [0.1, 3600];
        /// Factor by which fusion has to enlarge a source's covariances.
        inflation: f64 = 4.0, in [1.3, 1000];
        /// Offset of another host's clock, after subtraction of the measurement's uncertainty.
        host_clock_ms: f64 = 20.0, in [0.1, 3.6e6];
        /// Time without health messages after which a process counts as silent.
        process_silent_s: Seconds = Seconds::of(3.0), in [1, 3600];
        /// Least free space on the disk of the output files; 0: no limit.
        disk_free_mb: f64 = 500.0, in [0, 1e9];
        /// Least available memory of the machine; 0: no limit.
        memory_free_mb: f64 = 200.0, in [0, 1e9];
    }
}

/// Returns the finding for a value that is bad above `limit`, and good well below it.
pub fn above(value: f64, limit: f64) -> Option<Finding> {
    match value {
        value if value > limit => Some(Finding::Bad),
        value if value > CLEARED_SHARE * limit => Some(Finding::Between),
        _ => None,
    }
}

/// Returns the finding for a value that is bad below `limit`, and good well above it.
pub fn below(value: f64, limit: f64) -> Option<Finding> {
    match value {
        value if value < limit => Some(Finding::Bad),
        value if CLEARED_SHARE * value < limit => Some(Finding::Between),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_raising_and_clearing_lies_a_band() {
        let (bad, between) = (Some(Finding::Bad), Some(Finding::Between));
        assert_eq!(
            [1.1, 1.0, 0.7, 0.5].map(|value| above(value, 1.0)),
            [bad, between, between, None]
        );
        assert_eq!(
            [0.9, 1.0, 1.5, 2.0].map(|value| below(value, 1.0)),
            [bad, between, between, None]
        );
        assert_eq!(
            (above(f64::NAN, 1.0), below(f64::NAN, 1.0), below(1.0, 0.0)),
            (None, None, None)
        );
    }
}
