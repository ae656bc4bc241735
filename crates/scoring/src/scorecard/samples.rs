//! What a scorecard counts: the errors of paired tracks, and the seconds of targets and tracks.
//!
//! At each whole second, targets and tracks nearer than the gate are paired by best assignment, each second by itself.
//! A target counts from some time after its first row on: the start of tracks is a property of its own, and would
//! hide the figures of the phases. Seconds without any target of the truth are left out, and heights and velocities
//! that are not known are not compared; a second without a velocity of its target is in no phase but `all`.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use messages::Covariance;
use rustc_hash::FxHashMap;

use crate::gospa::Metric;
use crate::normalised::{covariance_after, normalised_square};
use crate::picture::{PictureError, Timeline, TimelinePass, first_whole_second};
use crate::states::{KinematicState, SteadyKnowledge, positions};

use super::phases::{PhaseLimits, PhaseSet, phases_of};

/// Least speed at which a course counts, m/s.
pub(crate) const MOVING_MPS: f64 = 3.0;

/// Settings of a scorecard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CardSettings {
    /// First whole second (10).
    pub first_s: i64,
    /// Last whole second; if not given, the last second of the truth.
    pub last_s: Option<i64>,
    /// Distance from which a track does not belong to a target, metres (250).
    pub gate_m: f64,
    /// Time from the first row of a target until it counts, seconds (25).
    pub settle_s: f64,
    /// Limits of the phases.
    pub limits: PhaseLimits,
}

impl Default for CardSettings {
    fn default() -> Self {
        Self {
            first_s: 10,
            last_s: None,
            gate_m: 250.0,
            settle_s: 25.0,
            limits: PhaseLimits {
                turning_mps2: 0.5,
                climbing_mps2: 0.3,
            },
        }
    }
}

/// Agreement of the addresses of target and track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AddressCheck {
    /// The target has no address in the file.
    Unknown,
    /// The track has none.
    Missing,
    /// The track has the target's.
    Right,
    /// The track has another.
    Wrong,
}

/// Errors of a track paired with a target: track minus target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorSample {
    /// The second.
    pub second: i64,
    /// Number of the target.
    pub target: i64,
    /// Number of the track.
    pub track: i64,
    /// Place of the target, east and north, metres.
    pub place_m: [f64; 2],
    /// Phases of the target.
    pub phases: PhaseSet,
    /// Speed of the target in the plane, m/s; 0 if not known.
    pub target_speed_mps: f64,
    /// Error in the plane east and north, metres.
    pub plane_m: [f64; 2],
    /// Length of the error in the plane, metres.
    pub position_m: f64,
    /// Error along the target's course, and across it to the right, metres; `None` if the target stands still.
    pub along_across_m: Option<[f64; 2]>,
    /// Error of the height, metres; `None` if either height is unknown.
    pub height_m: Option<f64>,
    /// Error of the speed in the plane, m/s; `None` if either velocity is unknown.
    pub speed_mps: Option<f64>,
    /// Length of the error of the velocity in the plane, m/s; `None` if either is unknown.
    pub velocity_mps: Option<f64>,
    /// Error of the course, degrees; `None` if either velocity is unknown, or the target is slower than 3 m/s.
    pub heading_deg: Option<f64>,
    /// Error of the rate of climb, m/s; `None` if either height or velocity is unknown.
    pub climb_mps: Option<f64>,
    /// Normalised squares per degree of freedom: position and velocity in the plane, height, rate of climb; then
    /// velocity and rate of climb by the likeliest case, if the track states it.
    pub normalised: [Option<f64>; 6],
    /// Agreement of the addresses.
    pub address: AddressCheck,
}

/// Second of a target that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TargetSecond {
    pub(crate) target: i64,
    pub(crate) second: i64,
    pub(crate) place_m: [f64; 2],
    /// Whether a track is paired with the target.
    pub(crate) is_reported: bool,
}

/// Second of a shown track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TrackSecond {
    pub(crate) track: i64,
    pub(crate) place_m: [f64; 2],
    /// Whether the track is paired with a target, counting or not yet.
    pub(crate) is_paired: bool,
}

/// Everything that scorecards count.
#[derive(Clone, Debug, Default)]
pub(crate) struct CardSamples {
    /// In the order of time.
    pub(crate) errors: Vec<ErrorSample>,
    pub(crate) targets: Vec<TargetSecond>,
    pub(crate) tracks: Vec<TrackSecond>,
    /// Number of seconds with truth.
    pub(crate) seconds: u64,
}

impl CardSamples {
    /// Compares tracks with the truth.
    ///
    /// # Errors
    /// If there is no second to compare.
    pub(crate) fn collect(truth: &Timeline, tracks: &Timeline, settings: &CardSettings) -> Result<Self, PictureError> {
        let (first_s, last_s) = truth.span(settings.first_s, settings.last_s)?;
        let paths = Path::of_targets(truth, &settings.limits);
        let (known, mut truth, mut tracks) = (truth, TimelinePass::new(truth), TimelinePass::new(tracks));
        let metric = Metric {
            cut_off_m: settings.gate_m,
            power: 2,
        };
        let mut samples = Self::default();
        for second in first_s..=last_s {
            let (targets, shown) = (truth.at(second), tracks.at(second));
            if !known.knows(&targets) {
                continue;
            }
            let pairs = metric.compare(&positions(&targets), &positions(&shown)).pairs;
            let (mut reported, mut paired) = (vec![false; targets.len()], vec![false; shown.len()]);
            for pair in &pairs {
                (reported[pair.target], paired[pair.track]) = (true, true);
                let (target, track) = (&targets[pair.target], &shown[pair.track]);
                let path = &paths[&target.id];
                if path.counts(second, settings) {
                    let phases = path.phases.get(&second).copied().unwrap_or(PhaseSet::ALL_ALONE);
                    samples.errors.push(errors(second, target, track, phases));
                }
            }
            let counting = targets.iter().zip(reported);
            samples.targets.extend(
                counting
                    .filter(|(target, _)| paths[&target.id].counts(second, settings))
                    .map(|(target, is_reported)| TargetSecond {
                        target: target.id,
                        second,
                        place_m: plane(&target.position_m),
                        is_reported,
                    }),
            );
            let of_track = |(track, is_paired): (&KinematicState<3>, bool)| TrackSecond {
                track: track.id,
                place_m: plane(&track.position_m),
                is_paired,
            };
            samples.tracks.extend(shown.iter().zip(paired).map(of_track));
            samples.seconds += 1;
        }
        Ok(samples)
    }
}

/// A target of the truth: its first second, and its velocities, each with its second.
struct SeenTarget {
    first_s: i64,
    seconds: Vec<i64>,
    velocities_mps: Vec<[f64; 3]>,
}

impl SeenTarget {
    fn from(first_s: i64) -> Self {
        Self {
            first_s,
            seconds: Vec::new(),
            velocities_mps: Vec::new(),
        }
    }
}

/// Path of a target.
struct Path {
    first_s: i64,
    /// By second with a velocity.
    phases: FxHashMap<i64, PhaseSet>,
}

impl Path {
    fn of_targets(truth: &Timeline, limits: &PhaseLimits) -> FxHashMap<i64, Self> {
        let mut seen: BTreeMap<i64, SeenTarget> = BTreeMap::new();
        if let (Some(first_s), Some(last_s)) = (truth.first_second(), truth.last_second()) {
            let mut pass = TimelinePass::new(truth);
            for second in first_s..=last_s {
                for target in pass.at(second) {
                    let seen = seen.entry(target.id).or_insert_with(|| SeenTarget::from(second));
                    if target.has_velocity {
                        seen.seconds.push(second);
                        seen.velocities_mps.push(target.velocity_mps);
                    }
                }
            }
        }
        let path = |(target, seen): (i64, SeenTarget)| {
            let phases = phases_of(&seen.seconds, &seen.velocities_mps, limits);
            let path = Self {
                first_s: seen.first_s,
                phases: seen.seconds.into_iter().zip(phases).collect(),
            };
            (target, path)
        };
        seen.into_iter().map(path).collect()
    }

    fn counts(&self, second: i64, settings: &CardSettings) -> bool {
        (second - self.first_s) as f64 >= settings.settle_s
    }
}

fn plane([east, north, _]: &[f64; 3]) -> [f64; 2] {
    [*east, *north]
}

/// Returns a covariance with what holds without a manoeuvre, of the velocity and of the climb rate, each where a
/// manoeuvre is the less likely case. Otherwise manoeuvres prevail in the whole covariance.
fn likeliest(stated: &Covariance, steady: &SteadyKnowledge) -> Covariance {
    let mut likeliest = *stated;
    if let Some((_, [xx, xy, yy])) = steady.velocity.filter(|(probability, _)| *probability >= 0.5) {
        for (row, column, value) in [(3, 3, xx), (3, 4, xy), (4, 4, yy)] {
            likeliest.set(row, column, value);
        }
    }
    if let Some((_, variance)) = steady.climb.filter(|(probability, _)| *probability >= 0.5) {
        likeliest.set(5, 5, variance);
    }
    likeliest
}

fn errors(second: i64, target: &KinematicState<3>, track: &KinematicState<3>, phases: PhaseSet) -> ErrorSample {
    let [east, north, up]: [f64; 3] = std::array::from_fn(|axis| track.position_m[axis] - target.position_m[axis]);
    let [vx, vy, vz]: [f64; 3] = std::array::from_fn(|axis| track.velocity_mps[axis] - target.velocity_mps[axis]);
    let has_height = target.has_height && track.has_height;
    let has_velocity = target.has_velocity && track.has_velocity;
    let has_climb = has_height && has_velocity;
    let [tx, ty, _] = target.velocity_mps;
    let speed = tx.hypot(ty);
    let track_speed = track.velocity_mps[0].hypot(track.velocity_mps[1]);
    let course = |state: &KinematicState<3>| state.velocity_mps[0].atan2(state.velocity_mps[1]);
    let turned = (course(track) - course(target) + PI).rem_euclid(TAU) - PI;
    // The state holds the covariance at the first second at which it is visible.
    let seconds = (second - first_whole_second(track.time_s)) as f64;
    let covariance = track.covariance.map(|stated| covariance_after(&stated, seconds));
    let normalised = covariance.map_or([None; 6], |stated| {
        let likeliest = likeliest(&stated, &track.steady);
        let velocity = |stated| normalised_square([vx, vy], stated, [3, 4]).filter(|_| has_velocity);
        let climb = |stated| normalised_square([vz], stated, [5]).filter(|_| has_climb);
        [
            normalised_square([east, north], &stated, [0, 1]),
            velocity(&stated),
            normalised_square([up], &stated, [2]).filter(|_| has_height),
            climb(&stated),
            track.steady.velocity.and_then(|_| velocity(&likeliest)),
            track.steady.climb.and_then(|_| climb(&likeliest)),
        ]
    });
    ErrorSample {
        second,
        target: target.id,
        track: track.id,
        place_m: plane(&target.position_m),
        phases,
        target_speed_mps: speed,
        plane_m: [east, north],
        position_m: east.hypot(north),
        along_across_m: (speed > 0.0).then(|| [(east * tx + north * ty) / speed, (east * ty - north * tx) / speed]),
        height_m: has_height.then_some(up),
        speed_mps: has_velocity.then_some(track_speed - speed),
        velocity_mps: has_velocity.then(|| vx.hypot(vy)),
        heading_deg: (has_velocity && speed > MOVING_MPS).then(|| turned.to_degrees()),
        climb_mps: has_climb.then_some(vz),
        normalised,
        address: match (target.address, track.address) {
            (None, _) => AddressCheck::Unknown,
            (_, None) => AddressCheck::Missing,
            (target, track) if target == track => AddressCheck::Right,
            _ => AddressCheck::Wrong,
        },
    }
}
