//! Acceptance of wide-area reports (WA-2), and the list of reports still in use.

use observations::WideAreaReport;

/// Most targets of a report: a cluster holds no more tracks.
pub const TARGETS_MAX: u32 = 256;
/// Most reports kept at a time.
pub(crate) const REPORTS_MAX: usize = 4096;
/// Largest valid coordinate, metres: beyond, nothing on Earth is in one plane with the sensors.
pub(crate) const PLACE_MAX_M: f64 = 1e7;

/// Reason why a report was rejected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReportRejection {
    /// A coordinate, velocity or origin is no number, or no place.
    NoPlace,
    /// The report arrived before the time of observation.
    NegativeDelay,
    /// The report arrived later than allowed; the delay in nanoseconds.
    TooLate(i64),
    /// More targets than [`TARGETS_MAX`].
    TooManyTargets(u32),
    /// No room for another report.
    Full,
}

impl std::fmt::Display for ReportRejection {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoPlace => write!(
                formatter,
                "position, velocity and origin must be numbers, places at most {PLACE_MAX_M:e} m away"
            ),
            Self::NegativeDelay => write!(
                formatter,
                "it arrived before it was observed; check the sensors' clocks"
            ),
            Self::TooLate(delay_ns) => write!(
                formatter,
                "it arrived {:.1} s after the observation; allow a longer delay if that is right",
                *delay_ns as f64 / messages::NS_PER_S
            ),
            Self::TooManyTargets(targets) => {
                write!(
                    formatter,
                    "{targets} targets in one report; at most {TARGETS_MAX} can be used"
                )
            }
            Self::Full => write!(formatter, "{REPORTS_MAX} reports are already kept"),
        }
    }
}

impl std::error::Error for ReportRejection {}

/// Returns the fault of a report, independent of the receiver; `None` if there is none.
pub fn fault_in(report: &WideAreaReport) -> Option<ReportRejection> {
    let is_place = |value: f64| value.abs() <= PLACE_MAX_M;
    let origin = report.origin_m.unwrap_or_default();
    let numbers = report.position_m.iter().chain(&origin).all(|value| is_place(*value))
        && report.velocity_mps.iter().all(|value| value.is_finite());
    if !numbers {
        return Some(ReportRejection::NoPlace);
    }
    if report.arrival_ns < report.time_ns {
        return Some(ReportRejection::NegativeDelay);
    }
    (report.targets > TARGETS_MAX).then_some(ReportRejection::TooManyTargets(report.targets))
}

/// Fault of a report for a tracker that allows a delay of `delay_max_ns`; `None` if there is none.
pub(crate) fn fault(report: &WideAreaReport, delay_max_ns: i64) -> Option<ReportRejection> {
    let delay_ns = report.arrival_ns.saturating_sub(report.time_ns);
    let late = (delay_ns > delay_max_ns).then_some(ReportRejection::TooLate(delay_ns));
    fault_in(report).or(late)
}

/// Returns whether a report is valid at `time_ns`: at most `valid_ns` after its observation.
pub(crate) fn is_valid(report: &WideAreaReport, time_ns: i64, valid_ns: i64) -> bool {
    report.arrival_ns <= time_ns && time_ns.saturating_sub(report.time_ns) <= valid_ns
}

/// Returns whether the scan at `time_ns` is the first after a report's arrival, if reports up to `used_ns` have been
/// used.
pub(crate) fn is_due(report: &WideAreaReport, used_ns: i64, time_ns: i64) -> bool {
    used_ns < report.arrival_ns && report.arrival_ns <= time_ns
}

/// Reports that may still matter, in the order of arrival.
#[derive(Clone, Debug)]
pub(crate) struct ReportList {
    list: Vec<WideAreaReport>,
}

impl ReportList {
    pub(crate) fn new() -> Self {
        Self {
            list: Vec::with_capacity(REPORTS_MAX),
        }
    }

    pub(crate) fn list(&self) -> &[WideAreaReport] {
        &self.list
    }

    /// Stores a report. Reports without effect on scans after `closed_ns` are removed.
    pub(crate) fn keep(
        &mut self,
        report: WideAreaReport,
        closed_ns: i64,
        valid_ns: i64,
    ) -> Result<(), ReportRejection> {
        self.list
            .retain(|kept| kept.arrival_ns > closed_ns || is_valid(kept, closed_ns, valid_ns));
        if self.list.len() == REPORTS_MAX {
            return Err(ReportRejection::Full);
        }
        let order = |report: &WideAreaReport| (report.arrival_ns, report.time_ns);
        let place = self.list.partition_point(|kept| order(kept) <= order(&report));
        self.list.insert(place, report);
        Ok(())
    }
}
