//! Another system's tracks, counted by place (WA-2).
//!
//! A remote system that sends its tracks implicitly reports the number of targets. The tracks come singly, each with
//! its own time; a count needs all tracks at the same time. So the tracks are cut by time: the measurements of a period
//! are a picture, with the latest report of each track. The picture is complete when a track of a later period arrives,
//! or when the caller reports a period of silence. Then all tracks of the picture are moved along the velocities to the
//! latest time of the picture. Tracks within a distance of each other, directly or through others between, make a
//! single report: number, mean position and mean velocity.
//!
//! All reports of a picture have the same time of observation and of arrival, so that a tracker that shares counts
//! among clusters can use all together.
//!
//! Limits: a picture is up to a period late. A track with a change of number within a period counts twice in the
//! period.

use messages::{AXES, NS_PER_S};
use observations::WideAreaReport;

/// Most tracks of a picture.
pub const TRACKS_MAX: usize = 2048;

/// Track of the other system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CountedTrack {
    /// Track number in that system.
    pub number: u32,
    /// Time of measurement, nanoseconds.
    pub time_ns: i64,
    /// East, north, up, metres.
    pub position_m: [f64; AXES],
    /// Metres per second.
    pub velocity_mps: [f64; AXES],
}

/// Totals of tracks counted and left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CountingTotals {
    /// Tracks of a period with an already complete picture.
    pub late: u64,
    /// Tracks beyond [`TRACKS_MAX`] in a period.
    pub crowded_out: u64,
    /// Pictures that were made reports of.
    pub pictures: u64,
}

/// Counts of a wide-area sensor that are made of another system's tracks.
#[derive(Debug)]
pub struct TrackCounter {
    period_ns: i64,
    group_m: f64,
    /// Number of the period at hand.
    period: Option<i64>,
    picture: Vec<CountedTrack>,
    /// By track of the picture: the group.
    groups: Vec<usize>,
    counts: CountingTotals,
}

impl TrackCounter {
    /// Pictures of `period_ns` nanoseconds (at least 1), groups of tracks no farther than `group_m` metres from the
    /// next.
    pub fn new(period_ns: i64, group_m: f64) -> Self {
        Self {
            period_ns: period_ns.max(1),
            group_m,
            period: None,
            picture: Vec::with_capacity(TRACKS_MAX),
            groups: Vec::with_capacity(TRACKS_MAX),
            counts: CountingTotals::default(),
        }
    }

    /// Takes a track received at `arrival_ns` (UTC, nanoseconds). A track of a later period completes the picture
    /// before; the reports of that picture are added to `reports`.
    pub fn take(&mut self, track: CountedTrack, arrival_ns: i64, reports: &mut Vec<WideAreaReport>) {
        let period = track.time_ns.div_euclid(self.period_ns);
        match self.period {
            Some(at_hand) if period < at_hand => {
                self.counts.late += 1;
                return;
            }
            Some(at_hand) if period > at_hand => self.complete(arrival_ns, reports),
            _ => {}
        }
        self.period = Some(period);
        match self.picture.iter().position(|known| known.number == track.number) {
            Some(place) if self.picture[place].time_ns <= track.time_ns => self.picture[place] = track,
            Some(_) => {}
            None if self.picture.len() == TRACKS_MAX => self.counts.crowded_out += 1,
            None => self.picture.push(track),
        }
    }

    /// The picture at hand is complete at `arrival_ns`: nothing has come for a period, or nothing follows.
    pub fn complete(&mut self, arrival_ns: i64, reports: &mut Vec<WideAreaReport>) {
        let Some(time_ns) = self.picture.iter().map(|track| track.time_ns).max() else {
            return;
        };
        // Makes the order and the sums of the reports independent of the order of arrival.
        self.picture.sort_unstable_by_key(|track| track.number);
        for track in &mut self.picture {
            let seconds = (time_ns - track.time_ns) as f64 / NS_PER_S;
            track.position_m = std::array::from_fn(|axis| track.position_m[axis] + track.velocity_mps[axis] * seconds);
        }
        self.group();
        // An arrival before the observation comes from a clock that is ahead.
        let arrival_ns = arrival_ns.max(time_ns);
        for group in 0..self.picture.len() {
            let members = || {
                let own = self.picture.iter().zip(&self.groups);
                own.filter(|(_, of)| **of == group).map(|(track, _)| track)
            };
            let targets = members().count();
            if targets == 0 {
                continue;
            }
            let mean = |of: fn(&CountedTrack) -> [f64; AXES]| -> [f64; AXES] {
                std::array::from_fn(|axis| members().map(|track| of(track)[axis]).sum::<f64>() / targets as f64)
            };
            reports.push(WideAreaReport {
                time_ns,
                arrival_ns,
                position_m: mean(|track| track.position_m),
                velocity_mps: mean(|track| track.velocity_mps),
                targets: targets as u32,
                origin_m: None,
            });
        }
        self.picture.clear();
        self.counts.pictures += 1;
    }

    /// Gives each track the place of the first track of the group.
    fn group(&mut self) {
        self.groups.clear();
        self.groups.extend(0..self.picture.len());
        for one in 0..self.picture.len() {
            for other in 0..one {
                let away = |axis: usize| self.picture[one].position_m[axis] - self.picture[other].position_m[axis];
                let (joined, joins) = (self.groups[one], self.groups[other]);
                if joined == joins || away(0).hypot(away(1)) > self.group_m {
                    continue;
                }
                let (least, most) = (joined.min(joins), joined.max(joins));
                for group in self.groups[..=one].iter_mut().filter(|group| **group == most) {
                    *group = least;
                }
            }
        }
    }

    /// Totals so far.
    pub fn counts(&self) -> CountingTotals {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use test_support::S;

    fn track(number: u32, time_s: f64, east_m: f64) -> CountedTrack {
        CountedTrack {
            number,
            time_ns: (time_s * NS_PER_S) as i64,
            position_m: [east_m, 0.0, 1000.0],
            velocity_mps: [100.0, 0.0, 0.0],
        }
    }

    fn all(counting: &mut TrackCounter, tracks: &[CountedTrack]) -> Vec<WideAreaReport> {
        let mut reports = Vec::new();
        for track in tracks {
            counting.take(*track, track.time_ns + S / 2, &mut reports);
        }
        reports
    }

    #[test]
    fn tracks_of_one_period_near_each_other_are_one_report() {
        let mut counting = TrackCounter::new(4 * S, 500.0);
        let tracks = [
            track(1, 0.5, 0.0),
            track(2, 1.0, 9000.0),
            // The first track again, 150 m on at its time; two tracks beside, the second through the first only.
            track(1, 2.0, 150.0),
            track(3, 2.0, 600.0),
            track(4, 3.0, 1200.0),
            track(5, 4.5, 0.0),
        ];
        let reports = all(&mut counting, &tracks);
        let found: Vec<(u32, f64)> = reports
            .iter()
            .map(|report| (report.targets, report.position_m[0]))
            .collect();
        // All at 3 s: 250, 700 and 1200; 9200.
        assert_eq!(found, [(3, (250.0 + 700.0 + 1200.0) / 3.0), (1, 9200.0)]);
        assert!(
            reports
                .iter()
                .all(|report| (report.time_ns, report.arrival_ns) == (3 * S, 5 * S))
        );
        assert_eq!(reports[0].velocity_mps, [100.0, 0.0, 0.0]);
        // The rest when nothing follows; an earlier period does not come back.
        let mut rest = all(&mut counting, &[track(6, 1.0, 0.0)]);
        counting.complete(9 * S, &mut rest);
        counting.complete(9 * S, &mut rest);
        assert_eq!((rest.len(), rest[0].targets, rest[0].arrival_ns), (1, 1, 9 * S));
        let expected = CountingTotals {
            late: 1,
            crowded_out: 0,
            pictures: 2,
        };
        assert_eq!(counting.counts(), expected);
    }

    #[test]
    fn a_clock_that_is_ahead_makes_no_negative_delay() {
        let mut counting = TrackCounter::new(S, 0.0);
        let mut reports = Vec::new();
        counting.take(track(1, 100.0, 0.0), 5 * S, &mut reports);
        counting.complete(6 * S, &mut reports);
        assert_eq!(reports[0].arrival_ns, reports[0].time_ns);
    }

    #[test]
    fn more_tracks_than_there_is_room_for_are_counted() {
        let mut counting = TrackCounter::new(S, 10.0);
        let tracks: Vec<CountedTrack> = (0..TRACKS_MAX as u32 + 3)
            .map(|number| track(number, 0.5, 1e3 * f64::from(number)))
            .collect();
        let mut reports = all(&mut counting, &tracks);
        counting.complete(S, &mut reports);
        assert_eq!((reports.len(), counting.counts().crowded_out), (TRACKS_MAX, 3));
    }

    fn any_tracks() -> impl Strategy<Value = Vec<CountedTrack>> {
        let one = (
            0..40u32,
            0..12_000_000_000i64,
            prop::array::uniform3(-5e3..5e3f64),
            prop::array::uniform3(-300.0..300.0f64),
        );
        let one = one.prop_map(|(number, time_ns, position_m, velocity_mps)| CountedTrack {
            number,
            time_ns,
            position_m,
            velocity_mps,
        });
        prop::collection::vec(one, 0..60)
    }

    proptest! {
        #[test]
        fn every_track_of_a_picture_is_counted_once(mut tracks in any_tracks(), group_m in 0.0..3e3f64) {
            tracks.sort_by_key(|track| track.time_ns);
            let period_ns = 3 * S;
            let mut counting = TrackCounter::new(period_ns, group_m);
            let mut reports = all(&mut counting, &tracks);
            counting.complete(20 * S, &mut reports);
            let mut seen: Vec<(i64, u32)> = tracks.iter().map(|track| (track.time_ns.div_euclid(period_ns), track.number)).collect();
            seen.sort_unstable();
            seen.dedup();
            prop_assert_eq!(reports.iter().map(|report| report.targets as usize).sum::<usize>(), seen.len());
            for (place, one) in reports.iter().enumerate() {
                prop_assert!(one.arrival_ns >= one.time_ns && one.targets > 0);
                prop_assert!(one.position_m.iter().chain(&one.velocity_mps).all(|value| value.is_finite()));
                // Single tracks with a separate report are farther from each other than the distance.
                for other in reports[..place].iter().filter(|other| other.time_ns == one.time_ns) {
                    let away = (one.position_m[0] - other.position_m[0]).hypot(one.position_m[1] - other.position_m[1]);
                    prop_assert!(one.targets > 1 || other.targets > 1 || away > group_m - 1e-6);
                }
            }
        }

        #[test]
        fn the_order_within_a_period_does_not_matter(mut tracks in any_tracks(), turns in 0..50usize) {
            tracks.iter_mut().for_each(|track| track.time_ns %= S);
            tracks.sort_by_key(|track| (track.number, track.time_ns));
            tracks.dedup_by_key(|track| track.number);
            let report = |tracks: &[CountedTrack]| {
                let mut counting = TrackCounter::new(S, 1e3);
                let mut reports = Vec::new();
                tracks.iter().for_each(|track| counting.take(*track, 2 * S, &mut reports));
                counting.complete(2 * S, &mut reports);
                reports
            };
            let expected = report(&tracks);
            let middle = turns % tracks.len().max(1);
            tracks.rotate_left(middle);
            prop_assert_eq!(report(&tracks), expected);
        }
    }
}
