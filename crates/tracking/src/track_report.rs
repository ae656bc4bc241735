//! What is said of the confirmed tracks after a scan: each by its best branch, or several as one group.

use estimation::PackedGaussian;
use messages::{NS_PER_S, SensorTrack, TargetType, TrackKind, TrackState, sensor_track_bits};

use crate::motion::{MotionSettings, noise};
use crate::population::{Cluster, Population};
use crate::settings::Settings;
use crate::track::Track;
use crate::wide_area::expectation::Expectation;
use crate::wide_area::group::Group;
use crate::wide_area::identification::Whereabouts;
use crate::wide_area::settings::WideArea;

/// A confirmed track after the latest scan: the most reliable branch of its ancestor (HT-10).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackReport {
    /// The ancestor's number, counted from 1.
    pub number: u32,
    /// Confirmed, or coasted if the latest scan had no detection of it.
    pub state: TrackState,
    /// Time of the latest scan or of its detection in it, nanoseconds.
    pub time_ns: i64,
    /// Position and velocity then.
    pub estimate: PackedGaussian,
    /// Whether any detection has told its height.
    pub height_known: bool,
    /// Sum over the hypotheses that contain the branch.
    pub reliability: f64,
    /// Hypotheses of its cluster.
    pub hypotheses: u32,
    /// Detections in all.
    pub detections: u32,
    /// Scans since the last one.
    pub missed: u32,
    /// Set if this is not a single target but several that are not told apart (WA-7).
    pub group: Option<Group>,
    /// Where a wide-area sensor says that the targets around came from, east and north in metres (WA-9).
    pub origin_m: Option<[f64; 2]>,
    /// What type of target it is, as far as that is known (WA-9).
    pub target_type: TargetType,
}

impl TrackReport {
    /// Carried on to `time_ns`, with accelerations of this spectral density (horizontal and vertical, m²/s³).
    pub fn moved_to(&self, time_ns: i64, process_noise_m2ps3: [f64; 2]) -> Self {
        let seconds = time_ns.saturating_sub(self.time_ns) as f64 / NS_PER_S;
        Self {
            time_ns,
            estimate: self.estimate.moved(seconds, noise(process_noise_m2ps3, seconds)),
            ..*self
        }
    }

    /// In the order of times; of one time, in that of the tracks' numbers.
    pub fn order(&self) -> (i64, u32) {
        (self.time_ns, self.number)
    }

    /// As a report of the source numbered `source`, with the numbers of the source's own at 0.
    pub fn sensor_track(&self, source: u16) -> SensorTrack {
        let mut track = SensorTrack {
            time_of_measurement_ns: self.time_ns,
            track_number: self.number,
            source,
            valid: sensor_track_bits::VELOCITY | sensor_track_bits::OWN_COVARIANCE,
            position_m: self.estimate.position_m(),
            velocity_mps: self.estimate.velocity_mps(),
            covariance: self.estimate.covariance,
            state: self.state as u8,
            kind: self.group.map_or(TrackKind::Single, |_| TrackKind::Group) as u8,
            members: self.group.map_or(0, |group| group.members as u16),
            target_type: self.target_type,
            ..SensorTrack::default()
        };
        if self.height_known {
            track.valid |= sensor_track_bits::HEIGHT | sensor_track_bits::VERTICAL_RATE;
        } else {
            // What was never observed is not passed on.
            (track.position_m[2], track.velocity_mps[2]) = (0.0, 0.0);
        }
        track
    }
}

pub(crate) fn report_of(track: &Track, cluster: &Cluster, time_ns: i64, settings: &Settings) -> TrackReport {
    let seen = track.missed == 0;
    let time_ns = if seen { track.time_ns } else { time_ns };
    let estimate = track.motion_at(time_ns, &settings.motion).estimate();
    // Without a height the first guess stands, or has grown.
    let guessed_m = settings.first_guess.height_sigma_m;
    TrackReport {
        number: track.number,
        state: if seen {
            TrackState::Confirmed
        } else {
            TrackState::Coasted
        },
        time_ns,
        estimate,
        height_known: estimate.covariance.get(2, 2) < (0.5 * guessed_m).powi(2),
        reliability: track.reliability.min(1.0),
        hypotheses: cluster.hypotheses.len() as u32,
        detections: track.detections,
        missed: track.missed,
        group: None,
        origin_m: None,
        target_type: TargetType::default(),
    }
}

/// Writes of each confirmed ancestor the number, the most reliable branch and its cluster to `best`, by their numbers.
pub(crate) fn find_best(population: &Population, best: &mut Vec<(u32, u32, u32)>) {
    let of = |track: u32| &population.tracks[track as usize];
    best.clear();
    for (cluster, place) in population.clusters.iter().zip(0..) {
        // All branches of an ancestor are in one cluster.
        let first = best.len();
        for track in cluster.tracks.clone().filter(|track| of(*track).is_confirmed()) {
            let number = of(track).number;
            match best[first..].iter_mut().find(|(other, ..)| *other == number) {
                Some((_, branch, _)) if of(track).is_preferred_to(of(*branch)) => *branch = track,
                Some(_) => (),
                None => best.push((number, track, place)),
            }
        }
    }
    best.sort_unstable();
}

/// Where a track is at `time_ns`, along its velocity; as uncertain as it was when it was last seen.
pub(crate) fn whereabouts(track: &Track, time_ns: i64) -> Whereabouts {
    let estimate = track.motion.estimate();
    let (position_m, velocity_mps) = (estimate.position_m(), estimate.velocity_mps());
    let seconds = time_ns.saturating_sub(track.time_ns) as f64 / NS_PER_S;
    let [xx, xy, _, yy, ..] = estimate.position_covariance();
    Whereabouts {
        place_m: [0, 1].map(|axis| position_m[axis] + velocity_mps[axis] * seconds),
        variances_m2: [xx, yy, xy],
    }
}

/// WA-7: whether the cluster's targets are not told apart.
pub(crate) fn group_of(
    population: &Population,
    cluster: &Cluster,
    expectation: &Expectation,
    settings: &WideArea,
) -> Option<Group> {
    let (groups, targets) = settings.groups.zip(expectation.targets)?;
    let hypotheses = &population.hypotheses[cluster.hypotheses.start as usize..cluster.hypotheses.end as usize];
    let rated = hypotheses
        .iter()
        .map(|hypothesis| (hypothesis.log_reliability.exp(), hypothesis.members.len()));
    groups.decide(rated, targets)
}

/// One track for several, branches included: their mean by reliability. `None` of none.
pub(crate) fn joined(
    tracks: impl Iterator<Item = TrackReport>,
    group: Group,
    time_ns: i64,
    motion: &MotionSettings,
) -> Option<TrackReport> {
    let mut sum = 0.0;
    let moved = tracks.map(|track| track.moved_to(time_ns, motion.process_noise_m2ps3));
    let joined = moved.reduce(|all, track| {
        sum = if sum == 0.0 { all.reliability } else { sum } + track.reliability;
        let of_one = all.detections >= track.detections;
        TrackReport {
            number: all.number.min(track.number),
            state: if all.missed.min(track.missed) == 0 {
                TrackState::Confirmed
            } else {
                TrackState::Coasted
            },
            estimate: PackedGaussian::mixture(&all.estimate, &track.estimate, track.reliability / sum),
            reliability: all.reliability.max(track.reliability),
            missed: all.missed.min(track.missed),
            detections: if of_one { all.detections } else { track.detections },
            ..all
        }
    })?;
    Some(TrackReport {
        group: Some(group),
        ..joined
    })
}
