//! Limits by which a run is judged: ratios to the run without faults, and times in periods of the targets.

use serde::Serialize;

/// Median, 95 %, 99 % and worst of a set of values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    pub(crate) p95: f64,
    pub(crate) p99: f64,
    pub(crate) worst: f64,
}

impl Spread {
    /// Spread of these values; `None` if there are none.
    pub(crate) fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| Some(sorted[((share * sorted.len() as f64) as usize).min(sorted.len().checked_sub(1)?)]);
        Some(Self {
            median: at(0.5)?,
            p95: at(0.95)?,
            p99: at(0.99)?,
            worst: at(1.0)?,
        })
    }
}

impl std::fmt::Display for Spread {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            out,
            "median {:.2}, 95 % {:.2}, 99 % {:.2}, worst {:.2}",
            self.median, self.p95, self.p99, self.worst
        )
    }
}

/// Begin of a run in which the picture comes about, seconds.
pub(crate) const SETTLED_S: u32 = 8;
/// Time after a second at which it is judged: so long the states may be in transit, seconds.
pub(crate) const GRACE_S: f64 = 1.0;

/// Error of a single state over the 95 % of all errors without faults.
pub(crate) const SINGLE: f64 = 15.0;
/// Seconds over which the error of a target counts as lasting, and the median there over the 95 % of all errors without
/// faults.
pub(crate) const LASTING_S: usize = 6;
pub(crate) const LASTING: f64 = 3.0;
/// The same over a longer time, over the median of all errors without faults, or of the target's own.
pub(crate) const LONG_S: usize = 30;
pub(crate) const LONG: f64 = 3.0;
/// Seconds over which the whole picture is compared, and median and 95 % of all errors over the errors without faults.
pub(crate) const WHOLE_S: usize = 5;
pub(crate) const WHOLE_MEDIAN: f64 = 1.5;
pub(crate) const WHOLE_P95: f64 = 2.0;
/// The same while the tracks of sensors or fusion's estimates of sensors begin anew.
pub(crate) const RENEWED_MEDIAN: f64 = 3.0;
pub(crate) const RENEWED_P95: f64 = 4.0;
pub(crate) const RENEWED_LASTING: f64 = 4.5;
/// The same while all that fusion had learned is lost.
pub(crate) const FORGOTTEN_MEDIAN: f64 = 6.0;
pub(crate) const FORGOTTEN_P95: f64 = 6.0;
pub(crate) const FORGOTTEN_LASTING: f64 = 9.0;
/// How long that takes, in periods of the slowest source.
pub(crate) const RENEWED_PERIODS: f64 = 6.0;
pub(crate) const FORGOTTEN_PERIODS: f64 = 12.0;
/// States over the states without faults, in a time without faults: of a single target, and of all.
pub(crate) const RATE: std::ops::Range<f64> = 0.6..2.5;
pub(crate) const WHOLE_RATE: std::ops::Range<f64> = 0.75..1.3;
pub(crate) const RATE_S: usize = 10;
/// States that the moment of counting can add or take.
pub(crate) const RATE_STATES: u32 = 4;
/// States that repeat the previous state, with fewer others between them.
pub(crate) const REPEATS: u32 = 3;

/// Age of a target's newest state beyond the greatest age without faults, seconds.
pub(crate) const LATE_S: f64 = 1.5;
/// Time after the begin, or the end of the cause, at which a fault of fusion or of an adapter is over, seconds.
pub(crate) const FUSION_S: f64 = 1.0;
/// The same where the whole deployment begins anew, seconds.
pub(crate) const MEMORY_S: f64 = 4.0;
/// The same where all sensors begin anew, in periods of the target: a sensor's track is confirmed by the third report.
pub(crate) const SENSORS_PERIODS: f64 = 4.0;
/// Epochs that a fault of fusion may lead to, and time in which another is permitted without a fault, seconds.
pub(crate) const EPOCHS: u32 = 3;
pub(crate) const EPOCH_ALONE_S: f64 = 20.0;
/// Time between the sending of a state and the arrival, seconds.
pub(crate) const ARRIVAL_S: f64 = 2.0;
/// Error of clocks, seconds.
pub(crate) const CLOCK_S: f64 = 0.1;
/// A track without an address this near to a target may be the target's track, metres.
pub(crate) const NEAR_M: f64 = 1000.0;
/// A second track, or a track without a target, this near to a track of the run without faults is the same, metres.
pub(crate) const SAME_M: f64 = 500.0;
/// Time after which a silent track counts as forgotten, beyond that after which it has to end, seconds.
pub(crate) const FORGOTTEN_S: f64 = 10.0;

/// The limits in words.
pub(crate) fn text(period_s: f64) -> String {
    format!(
        "errors over those of the run without faults: whole picture, {WHOLE_S} s: median {WHOLE_MEDIAN}, 95 % \
         {WHOLE_P95} ({RENEWED_MEDIAN} and {RENEWED_P95} for {:.0} s after faults of sensors or fusion, \
         {FORGOTTEN_MEDIAN} and {FORGOTTEN_P95} for {:.0} s after the loss of the checkpoint); one target: \
         {LASTING} ({RENEWED_LASTING}, {FORGOTTEN_LASTING}) times the 95 % of all for {LASTING_S} s, {LONG} times the median for {LONG_S} s; one state: {SINGLE} \
         times the 95 %. Age of a target: {LATE_S} s more than without faults, and {FUSION_S} s for a fault of fusion or \
         an adapter, {MEMORY_S} s for a new start, {SENSORS_PERIODS} periods of the target for one of all sensors. Two tracks of a \
         target, tracks without a target or without their address: {period_s} s",
        RENEWED_PERIODS * period_s,
        FORGOTTEN_PERIODS * period_s
    )
}
