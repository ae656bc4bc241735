//! Past of the sensor tracks: every report, within the configured time span and memory.
//!
//! A picture of the past shows the sensor tracks, and the positions of a selected track's contributors, at its own
//! moment. Reports are stored in the order of arrival, each with the picture's time at that moment. The sensor
//! tracks of a moment are the latest reports before it, up to the age limit of the layer.

use std::collections::VecDeque;

use messages::picture::PictureSensorTrack;
use rustc_hash::FxHashMap;

/// Report of a sensor track.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SensorTrackReport {
    /// Time of the picture at the report's arrival, UTC, nanoseconds.
    at_ns: i64,
    /// Time of measurement, UTC, nanoseconds.
    pub(crate) time_ns: i64,
    /// Record of the report; its age is not set.
    pub(crate) record: PictureSensorTrack,
}

/// History of reports, see the module's documentation.
#[derive(Debug)]
pub(crate) struct Reports {
    span_ns: i64,
    /// Maximum age of a displayed sensor track, nanoseconds.
    age_ns: i64,
    most: usize,
    reports: VecDeque<SensorTrackReport>,
    /// Number of the oldest report; numbers start with 1.
    first: u64,
}

/// Sensor tracks at a moment: report numbers by source and track number.
#[derive(Clone, Debug, Default)]
pub(crate) struct LatestReports {
    pub(crate) reports: FxHashMap<(u16, u32), u64>,
    /// Number of the first later report.
    next: u64,
}

impl Reports {
    /// Creates an empty history for the last `span_ns`, in at most `octets_max` bytes.
    pub(crate) fn new(span_ns: i64, age_ns: i64, octets_max: usize) -> Self {
        Self {
            span_ns,
            age_ns,
            most: (octets_max / size_of::<SensorTrackReport>()).max(1),
            reports: VecDeque::new(),
            first: 1,
        }
    }

    /// Stores a report that arrived at picture time `at_ns`.
    pub(crate) fn keep(&mut self, at_ns: i64, time_ns: i64, record: PictureSensorTrack) {
        let newest_ns = self.reports.back().map_or(at_ns, |newest| newest.at_ns);
        if at_ns < newest_ns - self.age_ns {
            // The clock has restarted.
            self.first += self.reports.len() as u64;
            self.reports.clear();
        }
        let at_ns = self.reports.back().map_or(at_ns, |newest| newest.at_ns.max(at_ns));
        self.reports.push_back(SensorTrackReport { at_ns, time_ns, record });
        let too_old = |oldest: &SensorTrackReport| oldest.at_ns < at_ns - self.span_ns - self.age_ns;
        while self.reports.len() > self.most || self.reports.front().is_some_and(too_old) {
            self.reports.pop_front();
            self.first += 1;
        }
    }

    /// Returns the report of this number; `None` if it was dropped.
    pub(crate) fn get(&self, number: u64) -> Option<&SensorTrackReport> {
        self.reports.get(usize::try_from(number.checked_sub(self.first)?).ok()?)
    }

    /// Moves `latest` to the time `at_ns`.
    pub(crate) fn go_to(&self, latest: &mut LatestReports, at_ns: i64) {
        let before = |ns: i64| self.first + self.reports.partition_point(|report| report.at_ns < ns) as u64;
        let (begin, end) = (before(at_ns - self.age_ns), before(at_ns.saturating_add(1)));
        if latest.next > end || latest.next < begin {
            latest.reports.clear();
            latest.next = begin;
        }
        for number in latest.next..end {
            let Some(report) = self.get(number) else { break };
            let key = (report.record.source, report.record.track_number);
            let known = latest.reports.get(&key).and_then(|known| self.get(*known));
            if known.is_none_or(|known| known.time_ns <= report.time_ns) {
                latest.reports.insert(key, number);
            }
        }
        latest.next = end;
        let oldest_ns = at_ns - self.age_ns;
        let is_shown = |number: u64| self.get(number).is_some_and(|report| report.time_ns >= oldest_ns);
        latest.reports.retain(|_, number| is_shown(*number));
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    fn record(source: u16, track_number: u32, east_m: f32) -> PictureSensorTrack {
        PictureSensorTrack {
            source,
            track_number,
            east_m,
            ..PictureSensorTrack::default()
        }
    }

    fn shown(reports: &Reports, latest: &mut LatestReports, at_s: i64) -> Vec<(u16, f32)> {
        reports.go_to(latest, at_s * S);
        let mut shown: Vec<_> = latest
            .reports
            .values()
            .map(|number| reports.get(*number).unwrap().record)
            .map(|record| (record.source, record.east_m))
            .collect();
        shown.sort_by_key(|(source, _)| *source);
        shown
    }

    #[test]
    fn a_moment_has_its_own_reports_whichever_way_one_comes_there() {
        let mut reports = Reports::new(600 * S, 30 * S, usize::MAX);
        for second in 0..200 {
            reports.keep(second * S, second * S - S / 2, record(0, 7, second as f32));
            if second < 100 {
                reports.keep(second * S, second * S, record(1, 7, -second as f32));
            }
        }
        let mut latest = LatestReports::default();
        for (at_s, expected) in [
            (50, vec![(0, 50.0), (1, -50.0)]),
            (52, vec![(0, 52.0), (1, -52.0)]),
            (120, vec![(0, 120.0), (1, -99.0)]),
            (135, vec![(0, 135.0)]),
            (10, vec![(0, 10.0), (1, -10.0)]),
            (199, vec![(0, 199.0)]),
            (-5, vec![]),
        ] {
            assert_eq!(shown(&reports, &mut latest, at_s), expected, "{at_s} s");
            assert_eq!(
                shown(&reports, &mut LatestReports::default(), at_s),
                expected,
                "{at_s} s, anew"
            );
        }
    }

    #[test]
    fn memory_is_bounded_and_time_may_begin_anew() {
        let mut reports = Reports::new(600 * S, 30 * S, 100 * size_of::<SensorTrackReport>());
        for second in 0..500 {
            reports.keep(second * S, second * S, record(0, second as u32, 0.0));
        }
        assert_eq!(reports.reports.len(), 100);
        assert_eq!(shown(&reports, &mut LatestReports::default(), 499).len(), 31);
        reports.keep(0, 0, record(0, 1, 5.0));
        assert_eq!(shown(&reports, &mut LatestReports::default(), 0), [(0, 5.0)]);
    }
}
