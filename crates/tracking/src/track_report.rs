//! Reports of the confirmed tracks after a scan: each by the best branch, or several as a group.

use estimation::Gaussian;
use messages::{NS_PER_S, SensorTrack, TargetType, TrackKind, TrackState, sensor_track_bits};

use crate::identity::ReportedIdentity;
use crate::motion::noise;
use crate::population::{Cluster, Population};
use crate::settings::Settings;
use crate::track::{NO_DETECTION, Track};
use crate::wide_area::group::Group;

/// Looks without a detection after which a track beyond every field of view is not reported.
const LOOKS: u32 = 3;

/// A confirmed track after the latest scan: the most reliable branch of the ancestor (HT-10).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackReport {
    /// The ancestor's number, counted from 1.
    pub number: u32,
    /// Confirmed, or coasted if the latest scan had no detection of the track.
    pub state: TrackState,
    /// Time of the latest scan or of the track's detection in that scan, nanoseconds.
    pub time_ns: i64,
    /// Position and velocity then.
    pub estimate: Gaussian,
    /// Set if any detection has measured the height.
    pub height_known: bool,
    /// Sum over the hypotheses that contain the branch.
    pub reliability: f64,
    /// Hypotheses of the cluster.
    pub hypotheses: u32,
    /// Detections in all.
    pub detections: u32,
    /// Scans since the last detection.
    pub missed: u32,
    /// Set if the report is for several unresolved targets (WA-7).
    pub group: Option<Group>,
    /// Origin of the targets around, reported by a wide-area sensor: east and north in the system frame, metres (WA-9);
    /// `None` if not known.
    pub origin_m: Option<[f64; 2]>,
    /// Type of the target, as far as that is known (WA-9).
    pub target_type: TargetType,
    /// Identity of the target by transponder replies.
    pub identity: ReportedIdentity,
    /// Place of the detection with which the latest scan updated the track, metres, for residuals (TI-6). A height that
    /// is not measured is the track's. `None` without such a detection, and of a direction alone.
    pub measured_m: Option<[f64; 3]>,
}

impl TrackReport {
    /// Carried on to `time_ns`, with accelerations of this spectral density (horizontal and vertical, m²/s³).
    pub fn moved_to(&self, time_ns: i64, process_noise_m2ps3: [f64; 2]) -> Self {
        let seconds = time_ns.saturating_sub(self.time_ns) as f64 / NS_PER_S;
        Self {
            measured_m: self.measured_m.filter(|_| time_ns == self.time_ns),
            time_ns,
            estimate: self.estimate.moved(seconds, noise(process_noise_m2ps3, seconds)),
            ..*self
        }
    }

    /// Sort key: time, then track number.
    pub fn order(&self) -> (i64, u32) {
        (self.time_ns, self.number)
    }

    /// The report as a sample of the source numbered `source`, with the numbers of the source's own at 0.
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
            identity: self.identity.identity,
            identity_ages: self.identity.ages(self.time_ns),
            ..SensorTrack::default()
        };
        if let Some((level, age_ms)) = self.identity.level_at(self.time_ns) {
            track.valid |= sensor_track_bits::LEVEL;
            (track.level, track.level_age_ms) = (level, age_ms);
        }
        if self.height_known {
            track.valid |= sensor_track_bits::HEIGHT | sensor_track_bits::VERTICAL_RATE;
        } else {
            // Unobserved components are not published.
            (track.position_m[2], track.velocity_mps[2]) = (0.0, 0.0);
        }
        // A detection of a single member is none of a group.
        if let Some([east, north, up]) = self.measured_m.filter(|_| self.group.is_none()) {
            track.valid |= sensor_track_bits::MEASURED;
            track.measured_m = [east, north, if self.height_known { up } else { 0.0 }];
        }
        track
    }
}

pub(crate) fn report_of(track: &Track, cluster: &Cluster, time_ns: i64, settings: &Settings) -> TrackReport {
    let seen = track.missed == 0;
    let time_ns = if seen { track.time_ns } else { time_ns };
    let estimate = track.motion_at(time_ns, &settings.motion).estimate();
    // Without a height the first guess stands, or has grown.
    let guessed_m = settings.initiation.height_sigma_m;
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
        identity: track.identity.reported(),
        measured_m: None,
    }
}

/// The most reliable branch of a confirmed ancestor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BestBranch {
    /// Number of the ancestor.
    pub(crate) number: u32,
    /// Places of the branch and of the cluster in the population.
    pub(crate) track: u32,
    pub(crate) cluster: u32,
    /// Probabilities that a hypothesis with the track is right, and that in addition the target is still there: sums
    /// over all branches.
    reliability: f64,
    presence: f64,
}

impl BestBranch {
    /// Probability that the target is still there, if a hypothesis with the track is right.
    pub(crate) fn existence(&self) -> f64 {
        self.presence / self.reliability
    }
}

/// Whether a track after the latest scan has been missed for some looks, and lies where no sensor sees it.
pub(crate) fn has_left(track: &Track, population: &Population, settings: &Settings) -> bool {
    if track.missed < LOOKS {
        return false;
    }
    let [east, north, ..] = track.motion_at(population.time_ns, &settings.motion).mean();
    let mut sensors = settings.sensors.iter().zip(&population.sensors);
    !sensors.any(|(sensor, memory)| memory.sees(sensor.model.field_of_view.as_ref(), [east, north]))
}

/// Writes the best branches of all confirmed ancestors to `best`, by number.
pub(crate) fn find_best(population: &Population, best: &mut Vec<BestBranch>) {
    let of = |track: u32| &population.tracks[track as usize];
    best.clear();
    for (place, cluster) in (0..).zip(&population.clusters) {
        // All branches of an ancestor are in the same cluster.
        let first = best.len();
        for track in cluster.tracks.clone().filter(|track| of(*track).is_confirmed()) {
            let number = of(track).number;
            match best[first..].iter_mut().find(|best| best.number == number) {
                Some(best) => {
                    best.reliability += of(track).reliability;
                    best.presence += of(track).presence();
                    if of(track).is_preferred_to(of(best.track)) {
                        best.track = track;
                    }
                }
                None => best.push(BestBranch {
                    number,
                    track,
                    cluster: place,
                    reliability: of(track).reliability,
                    presence: of(track).presence(),
                }),
            }
        }
    }
    for of_cluster in best.chunk_by_mut(|one, other| one.cluster == other.cluster) {
        let cluster = &population.clusters[of_cluster[0].cluster as usize];
        keep_apart(population, cluster, of_cluster);
    }
    best.sort_unstable_by_key(|best| best.number);
}

/// Replaces the best branch of an ancestor by the next best if a more reliable best branch of another ancestor has the
/// same latest detection, unless a hypothesis contains both: two targets are not shown as a single target.
fn keep_apart(population: &Population, cluster: &Cluster, best: &mut [BestBranch]) {
    let of = |track: u32| &population.tracks[track as usize];
    let hypotheses = &population.hypotheses[cluster.hypotheses.start as usize..cluster.hypotheses.end as usize];
    let are_together = |one: u32, other: u32| {
        hypotheses.iter().any(|hypothesis| {
            let members = population.members_of(hypothesis);
            members.contains(&one) && members.contains(&other)
        })
    };
    let is_double = |one: u32, other: u32| {
        let latest = of(one).history[0];
        latest != NO_DETECTION && latest == of(other).history[0] && !are_together(one, other)
    };
    for place in 0..best.len() {
        let BestBranch { track, number, .. } = best[place];
        let is_less = |other: &&BestBranch| other.number != number && of(other.track).is_preferred_to(of(track));
        let Some(other) = best.iter().filter(is_less).find(|other| is_double(track, other.track)) else {
            continue;
        };
        let other = other.track;
        let branches = cluster.tracks.clone().filter(|branch| of(*branch).number == number);
        let next = branches
            .filter(|branch| are_together(*branch, other))
            .reduce(|best, branch| {
                if of(branch).is_preferred_to(of(best)) {
                    branch
                } else {
                    best
                }
            });
        best[place].track = next.unwrap_or(track);
    }
}
