//! Continuity of each target's track.
//!
//! A picture can be right at every second and still be useless for following a single aircraft: if two tracks
//! exchange numbers when their targets cross, every single picture is perfect. Pairs are therefore carried from
//! second to second, as in the CLEAR MOT measures (Bernardin and Stiefelhagen, 2008). A pair of the previous second
//! stays while it is nearer than the gate, even if other tracks are closer; the rest is paired anew by best
//! assignment. Then
//!
//! - an *identity switch* is a target with another track than its last;
//! - a *break* is a target that had lost its track and has a track again;
//! - a *spurious* track belongs to a target in less than half of its displayed seconds;
//! - *wander* is the movement of a track's error from one second to the next, visible as trembling;
//! - *direction* is the angle between the track's velocity and the target's.

use std::f64::consts::{PI, TAU};

use rustc_hash::{FxHashMap, FxHashSet};

use crate::gospa::Metric;
use crate::near::{PointPair, distance};
use crate::states::{KinematicState, positions};

/// Continuity of the tracks of targets, from picture to picture.
#[derive(Debug)]
pub(crate) struct Continuity {
    gate_m: f64,
    moving_mps: f64,
    /// By target.
    followed: FxHashMap<i64, TargetContinuity>,
    /// By track.
    shown: FxHashMap<i64, TrackSeconds>,
    /// Error in the plane of each pair of the previous second.
    errors_m: FxHashMap<(i64, i64), [f64; 2]>,
    pub(crate) found: ContinuityFigures,
}

/// Figures found so far.
#[derive(Debug, Default)]
pub(crate) struct ContinuityFigures {
    pub(crate) switches: u64,
    pub(crate) breaks: u64,
    /// Target-seconds with a track, and in total.
    pub(crate) covered: u64,
    pub(crate) target_seconds: u64,
    pub(crate) wander_m: Vec<f64>,
    pub(crate) angles_rad: Vec<f64>,
}

/// State of one target.
#[derive(Clone, Copy, Debug, Default)]
struct TargetContinuity {
    /// Present or last track of the target.
    track: Option<i64>,
    /// Whether the target had a track in its latest second.
    now: bool,
}

/// Seconds of one track.
#[derive(Clone, Copy, Debug, Default)]
struct TrackSeconds {
    shown: u64,
    paired: u64,
}

impl Continuity {
    /// Creates empty figures. Pairs are nearer than `gate_m` metres; angles concern targets faster than
    /// `moving_mps` in the plane.
    pub(crate) fn new(gate_m: f64, moving_mps: f64) -> Self {
        Self {
            gate_m,
            moving_mps,
            followed: FxHashMap::default(),
            shown: FxHashMap::default(),
            errors_m: FxHashMap::default(),
            found: ContinuityFigures::default(),
        }
    }

    /// Passes over a second that is not compared: an error does not move from before it to behind it.
    pub(crate) fn pause(&mut self) {
        self.errors_m.clear();
    }

    /// Adds the next second: the targets and the displayed tracks, each with its own number.
    pub(crate) fn add(&mut self, targets: &[KinematicState<3>], tracks: &[KinematicState<3>]) {
        let mut pairs = self.pairs_that_stay(targets, tracks);
        pairs.extend(self.new_pairs(targets, tracks, &pairs));
        for track in tracks {
            self.shown.entry(track.id).or_default().shown += 1;
        }
        let mut track_of = vec![None; targets.len()];
        for &(target, track) in &pairs {
            track_of[target] = Some(tracks[track].id);
        }
        for (target, track) in targets.iter().zip(track_of) {
            self.follow(target.id, track);
        }
        let pairs: Vec<_> = pairs
            .iter()
            .map(|(target, track)| (&targets[*target], &tracks[*track]))
            .collect();
        self.measure_wander(&pairs);
        self.measure_direction(&pairs);
    }

    /// Returns the track of a target in the latest second that has this target; `None` if it had none.
    pub(crate) fn track_of(&self, target: i64) -> Option<i64> {
        self.followed.get(&target).filter(|followed| followed.now)?.track
    }

    /// Returns the number of tracks paired with a target in less than half of their displayed seconds.
    pub(crate) fn spurious(&self) -> u64 {
        let spurious = |seconds: &&TrackSeconds| 2 * seconds.paired < seconds.shown;
        self.shown.values().filter(spurious).count() as u64
    }

    /// Returns the total number of tracks.
    pub(crate) fn tracks(&self) -> u64 {
        self.shown.len() as u64
    }

    /// Returns the pairs of the previous second that are near enough to stay, as places of target and track.
    fn pairs_that_stay(&self, targets: &[KinematicState<3>], tracks: &[KinematicState<3>]) -> Vec<(usize, usize)> {
        let place: FxHashMap<i64, usize> = tracks.iter().map(|track| track.id).zip(0..).collect();
        let [targets_m, tracks_m] = [targets, tracks].map(positions);
        let mut taken = FxHashSet::default();
        let mut pairs = Vec::new();
        for (target, state) in targets.iter().enumerate() {
            let before = self.followed.get(&state.id).filter(|followed| followed.now);
            let Some(&track) = before.and_then(|followed| place.get(&followed.track?)) else {
                continue;
            };
            let near = distance(&targets_m[target], &tracks_m[track]) < self.gate_m;
            // The track of a returning target may belong to another target by now.
            if near && taken.insert(track) {
                pairs.push((target, track));
            }
        }
        pairs
    }

    /// Pairs the targets and tracks that are not in `pairs`.
    fn new_pairs(
        &self,
        targets: &[KinematicState<3>],
        tracks: &[KinematicState<3>],
        pairs: &[(usize, usize)],
    ) -> Vec<(usize, usize)> {
        let mut free = (vec![true; targets.len()], vec![true; tracks.len()]);
        for &(target, track) in pairs {
            free.0[target] = false;
            free.1[track] = false;
        }
        let left = |free: Vec<bool>| -> Vec<usize> { (0..free.len()).filter(|place| free[*place]).collect() };
        let (targets_left, tracks_left) = (left(free.0), left(free.1));
        let metric = Metric {
            cut_off_m: self.gate_m,
            power: 2,
        };
        let of = |states: &[KinematicState<3>], left: &[usize]| -> Vec<[f64; 3]> {
            let all = positions(states);
            left.iter().map(|place| all[*place]).collect()
        };
        let compared = metric.compare(&of(targets, &targets_left), &of(tracks, &tracks_left));
        let places = |pair: &PointPair| (targets_left[pair.target], tracks_left[pair.track]);
        compared.pairs.iter().map(places).collect()
    }

    /// Records that a target has this track in this second, or none.
    fn follow(&mut self, target: i64, track: Option<i64>) {
        self.found.target_seconds += 1;
        let followed = self.followed.entry(target).or_default();
        if let Some(track) = track {
            self.found.covered += 1;
            self.shown.entry(track).or_default().paired += 1;
            let had_one = followed.track.is_some();
            self.found.switches += u64::from(had_one && followed.track != Some(track));
            self.found.breaks += u64::from(had_one && !followed.now);
            followed.track = Some(track);
        }
        followed.now = track.is_some();
    }

    fn measure_wander(&mut self, pairs: &[(&KinematicState<3>, &KinematicState<3>)]) {
        let error = |(target, track): &(&KinematicState<3>, &KinematicState<3>)| {
            let error = [0, 1].map(|axis| track.position_m[axis] - target.position_m[axis]);
            ((target.id, track.id), error)
        };
        let now: FxHashMap<_, _> = pairs.iter().map(error).collect();
        for (pair, error) in pairs.iter().map(error) {
            if let Some(before) = self.errors_m.get(&pair) {
                self.found.wander_m.push(distance(&error, before));
            }
        }
        self.errors_m = now;
    }

    fn measure_direction(&mut self, pairs: &[(&KinematicState<3>, &KinematicState<3>)]) {
        let course = |state: &KinematicState<3>| state.velocity_mps[0].atan2(state.velocity_mps[1]);
        let known = pairs
            .iter()
            .filter(|(target, track)| target.has_velocity && track.has_velocity);
        for (target, track) in known {
            if target.velocity_mps[0].hypot(target.velocity_mps[1]) > self.moving_mps {
                let angle = course(track) - course(target);
                self.found.angles_rad.push((angle + PI).rem_euclid(TAU) - PI);
            }
        }
    }
}
