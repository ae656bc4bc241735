//! Sources with too large a share of useless reports: impossible times, late arrival, false positions, or no resulting
//! tracks.
//!
//! Every sensor errs now and then. A single report in a thousand is no alarm, and only counted. Therefore each
//! condition here needs a share of recent data, and a minimum number.

use alarms::{AlarmKind, Finding, Lately, Round, Subject, above};
use deployment::SourceFacts;
use messages::{Counter, Counters, ProcessKind};
use observed::Deployment;
use telemetry::table::count;

use crate::text::{percent, several};

/// Time over which shares of reports are taken, nanoseconds, and in words.
const REPORTS_NS: i64 = 60_000_000_000;
/// Time over which a tracker's work is looked at, nanoseconds: a slow antenna makes some 25 turns.
const SCANS_NS: i64 = 300_000_000_000;
/// Time over which targets with a stuck alert are counted, nanoseconds.
const STUCK_NS: i64 = 600_000_000_000;
/// Share of a source's reports that may claim times that cannot be.
const WILD_SHARE_MAX: f64 = 0.02;
/// Share of a source's reports that may come too late.
const LATE_SHARE_MAX: f64 = 0.01;
/// Fewer bad reports are no share.
const BAD_MIN: u64 = 5;
/// Detections and scans from which a tracker makes tracks, if there is a target.
const DETECTIONS_MIN: u64 = 200;
const SCANS_MIN: u64 = 10;
/// A tracker with less than a single track in so many scans has practically no tracks.
const SCANS_PER_REPORT: u64 = 10;

/// All sources' shares, with the necessary memory.
#[derive(Debug)]
pub(crate) struct SourceShares {
    reports: Lately<2>,
    scans: Lately<3>,
    stuck: Lately<1>,
}

impl SourceShares {
    pub(crate) fn new() -> Self {
        Self {
            reports: Lately::new(REPORTS_NS),
            scans: Lately::new(SCANS_NS),
            stuck: Lately::new(STUCK_NS),
        }
    }

    /// Evaluates all shares at `now_ns` (monotonic, nanoseconds).
    pub(crate) fn look(&mut self, observed: &Deployment, now_ns: i64, round: &mut Round<'_>) {
        let book = observed.book();
        for SourceFacts {
            number,
            name,
            adapter,
            sensor_of,
            ..
        } in observed.configured_sources()
        {
            let subject = Subject::source(*number);
            let adapter = book.adapter(adapter, *number);
            let fusion = book.service(ProcessKind::Fusion, *number);
            let (wild, late) = (fusion[Counter::RejectedClock], adapter[Counter::RejectedLate]);
            let false_position = fusion[Counter::RejectedFalsePosition];
            let shares = [
                (
                    AlarmKind::SourceIsolated,
                    [wild, fusion[Counter::Taken].max(wild)],
                    WILD_SHARE_MAX,
                ),
                (
                    AlarmKind::PositionFalse,
                    [false_position, fusion[Counter::Taken].max(false_position)],
                    0.0,
                ),
                (
                    AlarmKind::ReportsLate,
                    [late, adapter[Counter::Reports] + late],
                    LATE_SHARE_MAX,
                ),
            ];
            for (kind, counts, most) in shares {
                let [bad, all] = self.reports.grown(kind, subject, counts, now_ns);
                let share = bad as f64 / all.max(1) as f64;
                if let Some(finding) = above(share, most).filter(|_| bad >= BAD_MIN) {
                    let values = [
                        ("source", name.clone()),
                        ("share", percent(share)),
                        ("bad", count(bad)),
                        ("all", several(all, "report")),
                    ];
                    round.find(kind, subject, finding, &values);
                }
            }
            let kind = AlarmKind::AlertStuck;
            let [stuck] = self
                .stuck
                .grown(kind, subject, [adapter[Counter::AdvisoriesStuck]], now_ns);
            if stuck > 0 {
                let values = [("source", name.clone()), ("count", several(stuck, "target"))];
                round.find(kind, subject, Finding::Bad, &values);
            }
            if sensor_of.is_some() {
                // The tracker makes the tracks.
                continue;
            }
            let kind = AlarmKind::TrackerIdle;
            let worked = self.scans.grown(kind, subject, work(&adapter), now_ns);
            if is_idle(worked) {
                let [detections, scans, reports] = worked;
                let period_ms = adapter[Counter::ScanPeriodMs];
                let period = (period_ms > 0).then(|| format!(" of {:.2} s", period_ms as f64 / 1e3));
                let values = [
                    ("source", name.clone()),
                    ("detections", several(detections, "detection")),
                    ("scans", several(scans, "scan")),
                    ("reports", several(reports, "report")),
                    ("period", period.unwrap_or_default()),
                ];
                round.find(kind, subject, Finding::Bad, &values);
            }
        }
    }
}

/// Concerns from a source's counts of a whole run, for the final report: a recording may end before a share becomes an
/// alarm.
pub(crate) fn concerns(name: &str, adapter: &Counters, is_sensor: bool) -> impl Iterator<Item = (AlarmKind, String)> {
    let late = adapter[Counter::RejectedLate];
    let share = late as f64 / (adapter[Counter::Reports] + late).max(1) as f64;
    let are_late = (late >= BAD_MIN && share > LATE_SHARE_MAX).then(|| {
        let (late, share) = (several(late, "report"), percent(share));
        (
            AlarmKind::ReportsLate,
            format!("{late} of {name} ({share}) came too late and were not used"),
        )
    });
    let worked = work(adapter);
    let idle = (is_idle(worked) && !is_sensor).then(|| {
        let [detections, scans, reports] = worked;
        let (reports, scans) = (several(reports, "report"), several(scans, "scan"));
        let detections = several(detections, "detection");
        (
            AlarmKind::TrackerIdle,
            format!("the tracker of {name} made {reports} of tracks from {detections} in {scans}"),
        )
    });
    are_late.into_iter().chain(idle)
}

/// Detections, scans, and reports of the resulting tracks. A recorded source is ahead of its publishing.
fn work(adapter: &Counters) -> [u64; 3] {
    let reports = adapter[Counter::Published] + adapter[Counter::ReportsAhead];
    [adapter[Counter::Detections], adapter[Counter::Scans], reports]
}

/// Whether these many detections in so many scans should have given more reports of tracks.
fn is_idle([detections, scans, reports]: [u64; 3]) -> bool {
    detections >= DETECTIONS_MIN && scans >= SCANS_MIN && reports * SCANS_PER_REPORT < scans
}
