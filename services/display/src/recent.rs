//! Latest reports of each sensor track, whole: the basis of reasons and of comparisons between rules.

use std::collections::BTreeMap;

use messages::SensorTrack;

/// Reports per sensor track: fusion's rules use the latest and, by default, five earlier ones.
const REPORTS_MAX: usize = 6;
/// Maximum number of sensor tracks; with their reports 22 MB.
const TRACKS_MAX: usize = 8_192;

/// Latest reports, see the module's documentation.
#[derive(Debug, Default)]
pub(crate) struct RecentReports {
    /// By source and track number; the oldest report first.
    tracks: BTreeMap<(u16, u32), Vec<SensorTrack>>,
}

impl RecentReports {
    /// Stores a report; an older report than the latest is ignored.
    pub(crate) fn keep(&mut self, report: &SensorTrack) {
        let key = (report.source, report.track_number);
        if self.tracks.len() >= TRACKS_MAX && !self.tracks.contains_key(&key) {
            return;
        }
        let reports = self
            .tracks
            .entry(key)
            .or_insert_with(|| Vec::with_capacity(REPORTS_MAX));
        let is_newer = |last: &SensorTrack| last.time_of_measurement_ns < report.time_of_measurement_ns;
        if !reports.last().is_none_or(is_newer) {
            return;
        }
        if reports.len() == REPORTS_MAX {
            reports.remove(0);
        }
        reports.push(*report);
    }

    /// Returns the reports of a sensor track up to `until_ns` (time of measurement), the oldest first.
    pub(crate) fn until(&self, key: (u16, u32), until_ns: i64) -> &[SensorTrack] {
        let reports = self.tracks.get(&key).map_or(&[][..], Vec::as_slice);
        &reports[..reports.partition_point(|report| report.time_of_measurement_ns <= until_ns)]
    }

    /// Drops sensor tracks without a report since `oldest_ns`.
    pub(crate) fn forget_before(&mut self, oldest_ns: i64) {
        self.tracks.retain(|_, reports| {
            reports
                .last()
                .is_some_and(|last| last.time_of_measurement_ns >= oldest_ns)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(track_number: u32, time_of_measurement_ns: i64) -> SensorTrack {
        SensorTrack {
            track_number,
            time_of_measurement_ns,
            ..SensorTrack::default()
        }
    }

    #[test]
    fn the_latest_reports_are_kept_in_order_and_in_bounded_number() {
        let mut recent = RecentReports::default();
        for time in [1, 2, 2, 5, 4, 6, 7, 8, 9, 10] {
            recent.keep(&report(3, time));
        }
        let times = |recent: &RecentReports, until: i64| -> Vec<i64> {
            let reports = recent.until((0, 3), until);
            reports.iter().map(|report| report.time_of_measurement_ns).collect()
        };
        assert_eq!(times(&recent, 100), [5, 6, 7, 8, 9, 10]);
        assert_eq!(times(&recent, 6), [5, 6]);
        assert!(recent.until((0, 4), 100).is_empty());
        for track in 0..2 * TRACKS_MAX as u32 {
            recent.keep(&report(track, 20));
        }
        assert_eq!(recent.tracks.len(), TRACKS_MAX);
        recent.forget_before(21);
        assert!(recent.tracks.is_empty());
    }
}
