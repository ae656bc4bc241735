//! Quality index of each sensor track: its recently confirmed scans (QF-4).
//!
//! A report gives a scan of its source the value 1 if the track is confirmed, otherwise 0; a due scan without a
//! report has the value 0. Scans are distinguished by time alone: reports within half a period of the scan's
//! beginning belong to the scan, and a scan is missed half a period after its due time. The antenna may thus turn
//! unevenly, and a source with more frequent reports than its period has no advantage.

pub use fusion_settings::SCANS_MAX;
use serde::{Deserialize, Serialize};

/// The last scans of every sensor-track slot, allocated at once.
#[derive(Debug, Serialize, Deserialize)]
pub struct Qualities {
    scans: Vec<ScanHistory>,
}

/// The last scans of a sensor track.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct ScanHistory {
    /// Bit 0 is the latest scan with a report; 1 if that scan confirmed the track.
    confirmed: u64,
    /// Beginning of that scan, nanoseconds; `None` before the first report.
    began_ns: Option<i64>,
}

impl Qualities {
    /// Qualities of `slots` sensor tracks, without reports.
    pub fn new(slots: usize) -> Self {
        Self {
            scans: vec![ScanHistory::default(); slots],
        }
    }

    /// Clears the reports of a sensor track.
    pub fn clear(&mut self, slot: usize) {
        self.scans[slot] = ScanHistory::default();
    }

    /// Adds a report of the track in `slot` of a source with the given period.
    #[inline]
    pub fn push(&mut self, slot: usize, time_ns: i64, period_ns: i64, confirmed: bool) {
        let scans = &mut self.scans[slot];
        let passed = scans
            .began_ns
            .map_or(1, |began_ns| nearest_scan(time_ns - began_ns, period_ns));
        if passed == 0 {
            scans.confirmed = (scans.confirmed & !1) | u64::from(confirmed);
            return;
        }
        scans.confirmed = shifted(scans.confirmed, passed) | u64::from(confirmed);
        scans.began_ns = Some(time_ns);
    }

    /// M: number of scans, of the last `count` due scans, that confirmed the track, as of `now_ns`.
    #[inline]
    pub fn index(&self, slot: usize, now_ns: i64, period_ns: i64, count: u32) -> u32 {
        let scans = &self.scans[slot];
        let passed = scans
            .began_ns
            .map_or(0, |began_ns| nearest_scan(now_ns - began_ns, period_ns));
        // The scan that is due about now may still come.
        let kept = shifted(scans.confirmed, passed.saturating_sub(1));
        let window = u64::MAX >> (SCANS_MAX - count.clamp(1, SCANS_MAX));
        (kept & window).count_ones()
    }
}

/// Returns the number of scans since the scan that began `age_ns` ago, rounded.
fn nearest_scan(age_ns: i64, period_ns: i64) -> u64 {
    let period_ns = period_ns.max(1);
    ((age_ns.max(0) + period_ns / 2) / period_ns) as u64
}

fn shifted(bits: u64, by: u64) -> u64 {
    if by < u64::from(SCANS_MAX) { bits << by } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::S;

    #[test]
    fn missed_and_unconfirmed_scans_count_nothing() {
        let mut qualities = Qualities::new(1);
        // Scans at 0, 4, 8, 12 s; none at 16 s; 20 s with another turn's jitter, not confirmed there.
        for time_s in [0, 4, 8, 12] {
            qualities.push(0, time_s * S, 4 * S, true);
        }
        qualities.push(0, 20 * S + S / 2, 4 * S, false);
        assert_eq!(qualities.index(0, 20 * S + S / 2, 4 * S, 10), 4);
        assert_eq!(
            qualities.index(0, 20 * S + S / 2, 4 * S, 5),
            3,
            "of 4, 8, 12, (16), (20)"
        );
        assert_eq!(qualities.index(0, 25 * S, 4 * S, 5), 3, "24 s may still come");
        assert_eq!(qualities.index(0, 27 * S, 4 * S, 5), 2, "it has not");
        assert_eq!(qualities.index(0, i64::MAX / 2, 4 * S, 64), 0);
    }

    #[test]
    fn reports_within_one_scan_count_once() {
        let mut qualities = Qualities::new(1);
        for step in 0..21 {
            qualities.push(0, step * S / 10, S, true);
        }
        assert!(qualities.index(0, 2 * S, S, 64) <= 5, "21 reports within two seconds");
        qualities.clear(0);
        assert_eq!(qualities.index(0, 2 * S, S, 64), 0);
    }
}
