//! Restarts of sources: after a restart, a sensor gives new tracks to all its targets.
//!
//! A sensor seldom states its restart, and its adapter keeps running. The tracks show the restart: all tracks followed
//! for some time are silent, and new tracks begin. Until the end of the former tracks, the source would otherwise count
//! twice for each target. The new track could not join the target's system track, since two tracks of a source mean two
//! targets. Two sources with a common restart would agree on a second target.

use messages::NS_PER_S;
use serde::{Deserialize, Serialize};

/// Least reports of known tracks in two periods for a meaningful silence, and least number of first reports in a row.
const REPORTS_MIN: u32 = 5;
/// Share of a period with all known tracks silent while others begin; first reports of a single scan may follow each
/// other.
pub const SILENT: f64 = 0.75;
/// Time after the last report before a restart for the return of its tracks, nanoseconds.
const SHORTLY_NS: i64 = 60 * NS_PER_S as i64;
/// Age of its latest report, in periods, from which a track is overdue.
const OVERDUE: f64 = 1.25;
/// Silence after which all tracks have ended and a restart no longer matters, nanoseconds.
const LONG_NS: i64 = 300 * NS_PER_S as i64;

/// The sources' latest restarts.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Restarts {
    sources: Vec<SourceRestarts>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct SourceRestarts {
    /// Time of the latest report other than the first of a track, nanoseconds.
    known_ns: i64,
    /// End of the present period of such reports, nanoseconds, and number of reports in the previous and the present
    /// period.
    look_ns: i64,
    reports: [u32; 2],
    /// First reports since the latest such report, and time of the earliest, nanoseconds.
    begun: u32,
    begun_ns: i64,
    /// Latest time of a restart before which no track had a second report, nanoseconds; `i64::MAX` if there was none.
    unproved_ns: i64,
    /// Time of the restart, nanoseconds: tracks without a later report are from before the restart.
    restarted_ns: i64,
}

impl Restarts {
    pub(crate) fn new(sources: usize) -> Self {
        let none = SourceRestarts {
            known_ns: i64::MIN,
            look_ns: i64::MIN,
            reports: [0; 2],
            begun: 0,
            begun_ns: i64::MIN,
            unproved_ns: i64::MAX,
            restarted_ns: i64::MIN,
        };
        Self {
            sources: vec![none; sources],
        }
    }

    /// Whether a track of `source` with its latest report at `time_ns` is from before a restart of the source.
    #[inline]
    pub(crate) fn is_before(&self, source: u16, time_ns: i64) -> bool {
        time_ns <= self.sources[usize::from(source)].restarted_ns
    }

    /// Whether `source` restarted shortly before the beginning of a track of the source.
    pub(crate) fn is_shortly_before(&self, source: u16, began_ns: i64) -> bool {
        let restarted_ns = self.sources[usize::from(source)].restarted_ns;
        began_ns > restarted_ns && began_ns.saturating_sub(restarted_ns) < SHORTLY_NS
    }

    /// Takes the time of a report of `source`, possibly the first of its track.
    #[inline]
    pub(crate) fn take(&mut self, (source, period_ns): (u16, i64), time_ns: i64, is_first: bool) {
        let own = &mut self.sources[usize::from(source)];
        if is_first {
            return own.begin(period_ns, time_ns);
        }
        (own.known_ns, own.begun) = (own.known_ns.max(time_ns), 0);
        if time_ns >= own.look_ns {
            own.look(period_ns, time_ns);
        }
        own.reports[1] = own.reports[1].saturating_add(1);
    }
}

impl SourceRestarts {
    /// A track begins: whether all others are silent.
    #[cold]
    fn begin(&mut self, period_ns: i64, time_ns: i64) {
        if self.begun == 0 {
            self.begun_ns = time_ns;
        }
        self.begun = self.begun.saturating_add(1);
        if self.begun < REPORTS_MIN {
            return;
        }
        let silence_ns = time_ns.saturating_sub(self.known_ns);
        let had_tracks = self.reports[0].saturating_add(self.reports[1]) >= REPORTS_MIN;
        if had_tracks && silence_ns as f64 >= SILENT * period_ns as f64 && silence_ns < LONG_NS {
            self.restarted_ns = self.known_ns;
        }
        // A restart of a source soon after a start: its first tracks are overdue, and none has a second report.
        let overdue_ns = time_ns.saturating_sub((OVERDUE * period_ns as f64) as i64);
        if self.begun >= 2 * REPORTS_MIN && self.begun_ns <= overdue_ns {
            self.restarted_ns = self.restarted_ns.max(overdue_ns);
            self.unproved_ns = self.begun_ns.saturating_add(period_ns);
            self.look_ns = self.look_ns.min(time_ns);
        }
    }

    /// A period of reports ends, or the last of the tracks before an unproved restart are overdue.
    #[cold]
    fn look(&mut self, period_ns: i64, time_ns: i64) {
        self.look_ns = time_ns.saturating_add(period_ns);
        self.reports = [self.reports[1], 0];
        let overdue_ns = self.unproved_ns.saturating_add((OVERDUE * period_ns as f64) as i64);
        if time_ns >= overdue_ns {
            self.restarted_ns = self.restarted_ns.max(self.unproved_ns);
            self.unproved_ns = i64::MAX;
        } else {
            self.look_ns = self.look_ns.min(overdue_ns);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = NS_PER_S as i64;
    const SOURCE: (u16, i64) = (0, 4 * S);

    /// Eight tracks, a report each in every period of 4 s, from `from_s` to `to_s`.
    fn scans(restarts: &mut Restarts, from_s: i64, to_s: i64) {
        for time_s in from_s..to_s {
            for number in (0..8).filter(|number| number % 4 == time_s % 4) {
                restarts.take(SOURCE, time_s * S + number, time_s < from_s + 4);
            }
        }
    }

    #[test]
    fn a_source_whose_tracks_are_all_silent_while_others_come_has_restarted() {
        let mut restarts = Restarts::new(1);
        scans(&mut restarts, 0, 40);
        assert!(!restarts.is_before(0, 20 * S), "its first tracks are no restart");
        scans(&mut restarts, 45, 60);
        assert!(restarts.is_before(0, 39 * S) && !restarts.is_before(0, 46 * S));
        scans(&mut restarts, 62, 68);
        scans(&mut restarts, 69, 74);
        assert!(
            restarts.is_before(0, 67 * S) && !restarts.is_before(0, 69 * S),
            "again and again"
        );
    }

    #[test]
    fn a_source_that_begins_anew_before_any_track_came_twice_has_restarted() {
        let mut restarts = Restarts::new(1);
        let mut scan = |from_s: f64, seconds: f64, is_first: bool| {
            for part in 0..40 {
                let time_s = from_s + seconds * f64::from(part) / 40.0;
                restarts.take(SOURCE, (time_s * S as f64) as i64, is_first);
            }
            restarts.clone()
        };
        let started = scan(0.0, 3.9, true);
        assert!(!started.is_before(0, 0), "its first tracks are not overdue");
        let again = scan(4.3, 4.0, true);
        assert!(again.is_before(0, 2 * S) && !again.is_before(0, 5 * S));
        let followed = scan(8.3, 4.0, false);
        assert!(followed.is_before(0, 39 * S / 10) && !followed.is_before(0, 43 * S / 10));
    }

    #[test]
    fn a_gap_after_which_the_tracks_go_on_is_none() {
        let mut restarts = Restarts::new(1);
        scans(&mut restarts, 0, 40);
        for _ in 0..8 {
            restarts.take(SOURCE, 60 * S, false);
            // As many have begun meanwhile.
            restarts.take(SOURCE, 60 * S, true);
        }
        assert!(!restarts.is_before(0, 39 * S));
    }

    #[test]
    fn new_tracks_beside_others_are_none_and_few_tracks_show_nothing() {
        let mut restarts = Restarts::new(1);
        scans(&mut restarts, 0, 40);
        (0..8).for_each(|_| restarts.take(SOURCE, 40 * S, true));
        assert!(!restarts.is_before(0, 39 * S), "a formation");
        let mut few = Restarts::new(1);
        (0..40)
            .step_by(4)
            .for_each(|time_s| few.take(SOURCE, time_s * S, false));
        (0..8).for_each(|_| few.take(SOURCE, 60 * S, true));
        assert!(!few.is_before(0, 36 * S));
    }
}
