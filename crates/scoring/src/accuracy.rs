//! Running quality of a track picture against the truth: sums that give a short report at any time.
//!
//! A picture is the set of system tracks at one time. Each track is matched with at most one target, each target
//! with at most one track. Matching by address comes first, since an address identifies the target; the remaining
//! tracks are matched by distance, the closest pair first. The rest is counted by cause:
//!
//! - *duplicate*: a further track near a held target, or with its address;
//! - *false track*: a track without a target near it;
//! - *missed target*: a target without a track;
//! - *identity error*: a track near some target with the address of another target, or of none.
//!
//! Position errors are horizontal. A histogram in millimetres (three significant digits) holds their distribution,
//! so memory does not grow with the length of the run.

use hdrhistogram::Histogram;
use messages::{NS_PER_S, SystemTrack, TrackState};
use serde::Serialize;

/// Largest error distinguished by the histogram, millimetres; the maximum of a gate.
const ERROR_MAX_MM: u64 = 1_000_000_000;
/// Gate suitable for aircraft and their sensors, metres.
const GATE_M: f64 = 1000.0;

/// Target expected in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureTarget {
    /// Number of the target; at equal distances, the smaller number goes first.
    pub id: u32,
    /// East, north, up, metres, at the picture's time.
    pub position_m: [f64; 3],
    /// 24-bit address.
    pub address: u32,
}

/// System track of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureTrack {
    /// System-track number.
    pub track_number: u32,
    /// East, north, up, metres, at the picture's time.
    pub position_m: [f64; 3],
    /// 24-bit address of the track, if any.
    pub address: Option<u32>,
}

impl PictureTrack {
    /// Moves a system track along its velocity to the picture's time; `None` unless it is confirmed or coasted, the
    /// displayed states.
    pub fn from_system_track(track: &SystemTrack, at_utc_ns: i64) -> Option<Self> {
        let shown = matches!(
            TrackState::from_code(track.state),
            Some(TrackState::Confirmed | TrackState::Coasted)
        );
        let seconds = (at_utc_ns - track.reference_time_ns) as f64 / NS_PER_S;
        shown.then(|| Self {
            track_number: track.track_number,
            position_m: std::array::from_fn(|axis| track.position_m[axis] + track.velocity_mps[axis] * seconds),
            address: track.identity.address(),
        })
    }
}

/// Sums over the pictures so far.
#[derive(Clone, Debug)]
pub struct AccuracySums {
    gate_m: f64,
    sums: Sums,
    error_sum_m: f64,
    error_square_sum_m2: f64,
    errors_mm: Histogram<u64>,
    scratch: Scratch,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    pictures: u64,
    targets: u64,
    held: u64,
    held_once: u64,
    duplicates: u64,
    false_tracks: u64,
    identity_errors: u64,
}

/// Figures of an [`AccuracySums`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AccuracyReport {
    /// Pictures compared.
    pub pictures: u64,
    /// Mean number of targets per picture.
    pub targets: f64,
    /// Share of targets held by exactly one track, over all pictures; 0 to 1.
    pub held_once_share: f64,
    /// Share of targets without a track, over all pictures; 0 to 1.
    pub missed_share: f64,
    /// Mean number of duplicates per picture.
    pub duplicates: f64,
    /// Mean number of false tracks per picture.
    pub false_tracks: f64,
    /// Tracks with a wrong address near a target, summed over all pictures.
    pub identity_errors: u64,
    /// Number of horizontal errors behind the following figures: one per held target and picture.
    pub errors: u64,
    /// Mean horizontal error, metres.
    pub mean_m: f64,
    /// Root of the mean squared horizontal error, metres.
    pub rms_m: f64,
    /// 95th percentile of the horizontal errors, metres.
    pub p95_m: f64,
    /// Largest horizontal error, metres.
    pub max_m: f64,
}

impl Default for AccuracySums {
    fn default() -> Self {
        Self::new(GATE_M)
    }
}

impl AccuracySums {
    /// Creates an empty accuracy; tracks and targets more than `gate_m` metres apart in the plane (at most 1,000
    /// km) never match.
    ///
    /// # Panics
    /// If the gate is not a positive number within that limit.
    pub fn new(gate_m: f64) -> Self {
        assert!(
            gate_m > 0.0 && gate_m * 1000.0 <= ERROR_MAX_MM as f64,
            "a gate is positive and at most 1,000 km"
        );
        Self {
            gate_m,
            sums: Sums::default(),
            error_sum_m: 0.0,
            error_square_sum_m2: 0.0,
            errors_mm: Histogram::new_with_bounds(1, ERROR_MAX_MM, 3)
                .expect("the bounds are constants that suit each other"),
            scratch: Scratch::default(),
        }
    }

    /// Adds one picture: the expected targets and the tracks at the same time, both in any order.
    pub fn add_picture(&mut self, targets: &[PictureTarget], tracks: &[PictureTrack]) {
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.begin(targets, tracks.len());
        self.match_by_address(targets, tracks, &mut scratch);
        self.match_by_closeness(targets, tracks, &mut scratch);
        self.count_unmatched(targets, tracks, &mut scratch);
        self.count_targets(&scratch);
        self.scratch = scratch;
    }

    /// Returns the figures so far; shares, means and errors are 0 without data.
    pub fn report(&self) -> AccuracyReport {
        let sums = &self.sums;
        let ratio = |count: u64, of: u64| if of == 0 { 0.0 } else { count as f64 / of as f64 };
        let errors = self.errors_mm.len();
        let mean = |sum: f64| if errors == 0 { 0.0 } else { sum / errors as f64 };
        AccuracyReport {
            pictures: sums.pictures,
            targets: ratio(sums.targets, sums.pictures),
            held_once_share: ratio(sums.held_once, sums.targets),
            missed_share: ratio(sums.targets - sums.held, sums.targets),
            duplicates: ratio(sums.duplicates, sums.pictures),
            false_tracks: ratio(sums.false_tracks, sums.pictures),
            identity_errors: sums.identity_errors,
            errors,
            mean_m: mean(self.error_sum_m),
            rms_m: mean(self.error_square_sum_m2).sqrt(),
            p95_m: self.errors_mm.value_at_quantile(0.95) as f64 / 1000.0,
            max_m: self.errors_mm.max() as f64 / 1000.0,
        }
    }

    /// Matches by address: a track within the gate of the target with its address holds that target; of several
    /// tracks, the closest.
    fn match_by_address(&mut self, targets: &[PictureTarget], tracks: &[PictureTrack], scratch: &mut Scratch) {
        for (index, track) in tracks.iter().enumerate() {
            let Some(address) = track.address else {
                continue;
            };
            let target = scratch
                .by_address
                .binary_search_by_key(&address, |(address, _)| *address)
                .map(|place| scratch.by_address[place].1);
            match target {
                Ok(target) if distance_m(track, &targets[target]) <= self.gate_m => {
                    scratch
                        .pairs
                        .push(MatchPair::new(track, index, &targets[target], target));
                }
                _ => {
                    let near = scratch.nearest(track, targets, self.gate_m).is_some();
                    self.sums.identity_errors += u64::from(near);
                }
            }
        }
        scratch.sort_pairs();
        for place in 0..scratch.pairs.len() {
            let pair = scratch.pairs[place];
            scratch.used[pair.track] = true;
            if scratch.held[pair.target].error_m.is_none() {
                scratch.hold(&pair);
            } else {
                scratch.held[pair.target].duplicates += 1;
            }
        }
    }

    fn match_by_closeness(&self, targets: &[PictureTarget], tracks: &[PictureTrack], scratch: &mut Scratch) {
        for (index, track) in tracks.iter().enumerate() {
            if scratch.used[index] {
                continue;
            }
            for place in scratch.east_of(track.position_m[0], self.gate_m) {
                let target = scratch.by_east[place].1;
                let free = scratch.held[target].error_m.is_none();
                if free && distance_m(track, &targets[target]) <= self.gate_m {
                    scratch
                        .pairs
                        .push(MatchPair::new(track, index, &targets[target], target));
                }
            }
        }
        scratch.sort_pairs();
        for place in 0..scratch.pairs.len() {
            let pair = scratch.pairs[place];
            if !scratch.used[pair.track] && scratch.held[pair.target].error_m.is_none() {
                scratch.used[pair.track] = true;
                scratch.hold(&pair);
            }
        }
    }

    fn count_unmatched(&mut self, targets: &[PictureTarget], tracks: &[PictureTrack], scratch: &mut Scratch) {
        for (index, track) in tracks.iter().enumerate() {
            if scratch.used[index] {
                continue;
            }
            match scratch.nearest(track, targets, self.gate_m) {
                Some(target) => scratch.held[target].duplicates += 1,
                None => self.sums.false_tracks += 1,
            }
        }
    }

    fn count_targets(&mut self, scratch: &Scratch) {
        self.sums.pictures += 1;
        self.sums.targets += scratch.held.len() as u64;
        for held in &scratch.held {
            self.sums.duplicates += u64::from(held.duplicates);
            let Some(error_m) = held.error_m else {
                continue;
            };
            self.sums.held += 1;
            self.sums.held_once += u64::from(held.duplicates == 0);
            self.error_sum_m += error_m;
            self.error_square_sum_m2 += error_m * error_m;
            self.errors_mm.saturating_record((error_m * 1000.0).round() as u64);
        }
    }
}

/// Target in the current picture.
#[derive(Clone, Copy, Debug, Default)]
struct MatchedTarget {
    /// Error of the holding track, if any.
    error_m: Option<f64>,
    duplicates: u32,
}

/// Candidate pair of a track and a target, by their places in the picture.
#[derive(Clone, Copy, Debug)]
struct MatchPair {
    distance_m: f64,
    track_number: u32,
    target_id: u32,
    track: usize,
    target: usize,
}

impl MatchPair {
    fn new(track: &PictureTrack, index: usize, target: &PictureTarget, target_index: usize) -> Self {
        Self {
            distance_m: distance_m(track, target),
            track_number: track.track_number,
            target_id: target.id,
            track: index,
            target: target_index,
        }
    }
}

/// Working memory, reused for each picture.
#[derive(Clone, Debug, Default)]
struct Scratch {
    /// Targets sorted by address.
    by_address: Vec<(u32, usize)>,
    /// Targets sorted by their position east, for a search of neighbours.
    by_east: Vec<(f64, usize)>,
    pairs: Vec<MatchPair>,
    /// By target.
    held: Vec<MatchedTarget>,
    /// By track: whether it is matched or counted.
    used: Vec<bool>,
}

impl Scratch {
    fn begin(&mut self, targets: &[PictureTarget], tracks: usize) {
        self.by_address.clear();
        self.by_east.clear();
        for (index, target) in targets.iter().enumerate() {
            self.by_address.push((target.address, index));
            self.by_east.push((target.position_m[0], index));
        }
        self.by_address.sort_unstable();
        self.by_east
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.held.clear();
        self.held.resize(targets.len(), MatchedTarget::default());
        self.used.clear();
        self.used.resize(tracks, false);
        self.pairs.clear();
    }

    /// Sorts the closest pair first; numbers decide at equal distances.
    fn sort_pairs(&mut self) {
        self.pairs.sort_unstable_by(|a, b| {
            a.distance_m
                .total_cmp(&b.distance_m)
                .then(a.target_id.cmp(&b.target_id))
                .then(a.track_number.cmp(&b.track_number))
        });
    }

    fn hold(&mut self, pair: &MatchPair) {
        self.held[pair.target].error_m = Some(pair.distance_m);
    }

    /// Returns the places in `by_east` of the targets within the gate to east or west.
    fn east_of(&self, east_m: f64, gate_m: f64) -> std::ops::Range<usize> {
        let begin = self.by_east.partition_point(|(east, _)| *east < east_m - gate_m);
        let end = self.by_east.partition_point(|(east, _)| *east <= east_m + gate_m);
        begin..end.max(begin)
    }

    fn nearest(&self, track: &PictureTrack, targets: &[PictureTarget], gate_m: f64) -> Option<usize> {
        self.east_of(track.position_m[0], gate_m)
            .map(|place| self.by_east[place].1)
            .map(|target| (distance_m(track, &targets[target]), targets[target].id, target))
            .filter(|(distance_m, _, _)| *distance_m <= gate_m)
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, _, target)| target)
    }
}

fn distance_m(track: &PictureTrack, target: &PictureTarget) -> f64 {
    (track.position_m[0] - target.position_m[0]).hypot(track.position_m[1] - target.position_m[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(id: u32, east: f64, north: f64) -> PictureTarget {
        PictureTarget {
            id,
            position_m: [east, north, 9000.0],
            address: 0x84_0000 + id,
        }
    }

    fn track(track_number: u32, east: f64, north: f64, of: Option<u32>) -> PictureTrack {
        PictureTrack {
            track_number,
            position_m: [east, north, 0.0],
            address: of.map(|id| 0x84_0000 + id),
        }
    }

    fn report(targets: &[PictureTarget], tracks: &[PictureTrack]) -> AccuracyReport {
        let mut accuracy = AccuracySums::default();
        accuracy.add_picture(targets, tracks);
        accuracy.report()
    }

    #[test]
    fn perfect_picture() {
        let targets = [target(0, 0.0, 0.0), target(1, 500.0, 0.0)];
        let tracks = [track(1, 3.0, 4.0, Some(0)), track(2, 500.0, 10.0, None)];
        let report = report(&targets, &tracks);
        assert_eq!((report.held_once_share, report.missed_share), (1.0, 0.0));
        assert_eq!((report.duplicates, report.false_tracks), (0.0, 0.0));
        assert_eq!((report.identity_errors, report.errors), (0, 2));
        assert!((report.mean_m - 7.5).abs() < 1e-9);
        assert!((report.rms_m - 62.5f64.sqrt()).abs() < 1e-9);
        assert!((report.max_m - 10.0).abs() < 0.01);
    }

    #[test]
    fn address_counts_more_than_closeness() {
        let targets = [target(0, 0.0, 0.0), target(1, 300.0, 0.0)];
        // Track 1 is nearer to target 1 but has the address of target 0.
        let tracks = [track(1, 200.0, 0.0, Some(0)), track(2, 310.0, 0.0, None)];
        let report = report(&targets, &tracks);
        assert_eq!((report.held_once_share, report.identity_errors), (1.0, 0));
        assert!((report.mean_m - 105.0).abs() < 1e-9);
    }

    #[test]
    fn what_goes_wrong_is_counted_by_its_cause() {
        let targets = [
            target(0, 0.0, 0.0),
            target(1, 10_000.0, 0.0),
            target(2, 20_000.0, 0.0),
            target(3, 30_000.0, 0.0),
        ];
        let tracks = [
            track(1, 5.0, 0.0, Some(0)),
            track(2, 50.0, 0.0, Some(0)), // duplicate by address
            track(3, 10_010.0, 0.0, None),
            track(4, 10_200.0, 0.0, None),     // duplicate by closeness
            track(5, 20_000.0, 30.0, Some(0)), // holds target 2 under a wrong name
            track(6, 50_000.0, 0.0, None),     // false
            track(7, 60_000.0, 0.0, Some(3)),  // false: far from the target it names
        ];
        let report = report(&targets, &tracks);
        assert_eq!((report.pictures, report.targets), (1, 4.0));
        assert_eq!((report.held_once_share, report.missed_share), (0.25, 0.25));
        assert_eq!((report.duplicates, report.false_tracks), (2.0, 2.0));
        assert_eq!((report.identity_errors, report.errors), (1, 3));
    }

    #[test]
    fn order_does_not_matter() {
        let mut targets: Vec<PictureTarget> = (0..40)
            .map(|id| target(id, f64::from(id * 37 % 40) * 300.0, f64::from(id % 7) * 200.0))
            .collect();
        let mut tracks: Vec<PictureTrack> = (0..50)
            .map(|number| {
                let named = (number % 3 == 0).then_some(number % 45);
                track(
                    number,
                    f64::from(number * 23 % 50) * 250.0,
                    f64::from(number % 5) * 250.0,
                    named,
                )
            })
            .collect();
        let before = report(&targets, &tracks);
        targets.reverse();
        tracks.rotate_left(17);
        let after = report(&targets, &tracks);
        assert!((before.mean_m - after.mean_m).abs() < 1e-9);
        assert_eq!(
            AccuracyReport {
                mean_m: 0.0,
                rms_m: 0.0,
                ..before
            },
            AccuracyReport {
                mean_m: 0.0,
                rms_m: 0.0,
                ..after
            }
        );
    }

    #[test]
    fn nothing_to_divide_by() {
        let report = AccuracySums::default().report();
        assert_eq!((report.errors, report.mean_m, report.held_once_share), (0, 0.0, 0.0));
    }

    #[test]
    fn system_tracks_are_moved_to_the_time_of_the_picture() {
        let mut system = SystemTrack {
            reference_time_ns: 1_000_000_000,
            track_number: 9,
            position_m: [0.0, 10.0, 20.0],
            velocity_mps: [100.0, 0.0, -2.0],
            state: TrackState::Coasted as u8,
            ..SystemTrack::default()
        };
        let moved = PictureTrack::from_system_track(&system, 1_500_000_000).expect("shown");
        assert_eq!(moved.position_m, [50.0, 10.0, 19.0]);
        assert_eq!((moved.track_number, moved.address), (9, None));
        system.state = TrackState::Tentative as u8;
        assert_eq!(PictureTrack::from_system_track(&system, 0), None);
    }
}
