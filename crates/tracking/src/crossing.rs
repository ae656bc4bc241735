//! Crossings: tracks that start where directions of two sensors meet.
//!
//! A direction alone has no range and starts nothing. Two cameras see the same boat from two places, and the boat is
//! where their bearings cross; but of n boats, n² pairs of bearings cross, and most crossings are *ghosts*. The obvious
//! way, to take each crossing for a detection of a position, makes every ghost a track: the bearings of a ghost are
//! seen at each look, since each is of a real boat.
//!
//! A ghost shares both bearings with real targets, and a bearing has a single cause. So each crossing begins a
//! tentative track that has used both bearings, unless a track has begun there already. The tracker's hypotheses do the
//! rest. Two tracks that have used the same bearing are in no common hypothesis ([`crate::parents`]). Each further
//! bearing belongs to a single track of a hypothesis, and a hypothesis with ghosts needs misses or turns that real
//! targets do not. While two explanations are equally good, no track is confirmed.
//!
//! Until then, a scan of directions is processed for these clusters like a scan of positions; for all other clusters,
//! directions are used as usual ([`crate::directions`]). A direction in the gate of a confirmed track of another
//! cluster is most likely of that track: the likelihood adds to the density of false directions.
//!
//! Ghosts win where the comparison is not fair. A ghost that begins first, since a target was missed, is certain before
//! the targets can compete: so all crossings begin again if a further crossing follows soon. Hypotheses with equal
//! associations over two scans are merged elsewhere. Where one camera sees nothing, the hypotheses of targets and of
//! ghosts are equal, so these clusters compare the whole memory. Beside confirmed tracks, no track is confirmed more
//! easily.
//!
//! Expected new targets at a crossing: `initiation.new_target_share` per false direction of the second sensor, as at
//! any detection, over the number of false directions of the first sensor that may cross by chance.
//!
//! The first state is that of a range and bearing from the second sensor, with the range from the crossing. Along the
//! ray, it has the errors of both bearings and the motion of a target in the time between them.
//!
//! Bounds: of each sensor at most [`RAYS_OF_SCAN_MAX`] free directions are kept, of the latest scan only. A scan with
//! more free directions, or with more than [`CROSSINGS_MAX`] crossings, starts nothing: five targets have more
//! permutations than a cluster has hypotheses, so bearings cannot identify the real crossings. All of this is counted.
//!
//! Limit: the errors of range and bearing are taken for independent.

use std::f64::consts::TAU;

use messages::NS_PER_S;
use observations::DetectionKind;

use crate::cluster_update::ClusterUpdate;
use crate::counts::TrackerCounts;
use crate::coupling::Coupling;
use crate::crossing_memory::{CrossingMemory, RAYS_MAX, ROOTS_MAX, Ray};
use crate::departure::Departures;
use crate::directions::{Claims, Directions};
use crate::explanation::TrackEvent;
use crate::gating::Gating;
use crate::identity::ScanReplies;
use crate::initiation::{Initiation, Starts};
use crate::limits::{HISTORY_MAX, HYPOTHESES_MAX, PAIRS_MAX};
use crate::measurement::DetectionMeasurement;
use crate::motion::TargetMotion;
use crate::population::{Cluster, Hypothesis, Population};
use crate::scan_clusters::run_clusters;
use crate::scan_context::ScanContext;
use crate::settings::Settings;
use crate::track::{TENTATIVE, Track};
use crate::unresolved::Unresolved;
use crate::wide_area::support::Support;

/// Most free directions of a scan that are kept.
pub(crate) const RAYS_OF_SCAN_MAX: usize = 16;
/// Most crossings of a scan at which tracks start: the crossings of four targets.
pub(crate) const CROSSINGS_MAX: usize = 16;
/// Most crossings of a scan that are compared with tracks that have begun at crossings.
const COMPARED_MAX: usize = 64;
/// Least sine of the angle between two rays: 10°.
const SINE_MIN: f64 = 0.17;
/// Largest standard deviation of a range, relative to the range.
const KNOWN: f64 = 0.2;
/// Time within which all crossings begin again after a further crossing, in multiples of `initiation.crossing_s`.
const ANEW_SPANS: f64 = 3.0;
/// Least reliability of a hypothesis among ghosts: chance must not end the true hypothesis early.
const RELIABILITY_MIN: f64 = 1e-4;
/// Largest deviation of the heights of two directions, in standard deviations.
const HEIGHT_GATE: f64 = 3.5;
/// Least expected number of false directions of a scan.
const FALSE_MIN: f64 = 0.1;

/// A crossing of a direction of this scan with an earlier direction.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    plot: u32,
    ray: Ray,
    measurement: DetectionMeasurement,
}

/// Working memory, reused for each scan of directions.
#[derive(Debug)]
pub(crate) struct Crossings {
    /// Clusters with tracks that have begun at crossings.
    open: Population,
    gating: Gating,
    coupling: Coupling,
    unresolved: Unresolved,
    departures: Departures,
    replies: ScanReplies,
    support: Support,
    /// Settings for the open clusters.
    settings: Settings,
    log_clutter: Vec<f64>,
    is_free: Vec<bool>,
    found: Vec<Crossing>,
}

impl Crossings {
    /// `None` if tracks start at no crossings.
    pub(crate) fn new(settings: &Settings) -> Option<Box<Self>> {
        settings.initiation.crossing_s?;
        let (tracks, detections) = (settings.capacity.tracks(), settings.capacity.detections());
        let types = settings.wide_area.knowledge.types.len();
        Some(Box::new(Self {
            open: Population::new(tracks, settings.sensors.len(), types),
            gating: Gating::new(tracks, detections),
            coupling: Coupling::new(tracks, 4 * tracks + PAIRS_MAX, detections),
            unresolved: Unresolved::new(tracks, false),
            departures: Departures::new(detections),
            replies: ScanReplies::new(detections, settings.identity, settings.initiation.height_sigma_m),
            support: Support::new(&settings.wide_area, tracks),
            settings: confirmed_late(settings),
            log_clutter: Vec::with_capacity(detections),
            is_free: Vec::with_capacity(detections),
            found: Vec::with_capacity(RAYS_MAX * RAYS_OF_SCAN_MAX),
        }))
    }

    /// Processes a scan of directions; `density` is that of false directions per radian. Returns how many directions
    /// lie in no confirmed track's gate.
    pub(crate) fn run(
        &mut self,
        (scan, density): (&ScanContext<'_>, f64),
        clusters: &mut ClusterUpdate,
        claims: &mut Vec<Claims>,
        next: &mut Population,
        counts: &mut TrackerCounts,
    ) -> usize {
        let roots = &mut next.crossings.roots;
        let is_tentative = |root: u32| {
            let mut tracks = scan.before.tracks.iter();
            tracks.any(|track| track.root == root && !track.is_confirmed())
        };
        roots.retain(|root| is_tentative(*root));
        self.run_others(scan, clusters, claims, next, counts);
        self.is_free.clear();
        self.is_free.extend(claims.iter().map(|claims| !claims.are_made()));
        let mut outside = self.is_free.iter().filter(|is_free| **is_free).count();
        if self.are_rivals_late(scan, &next.crossings) {
            next.crossings.roots.clear();
        } else if !self.open.clusters.is_empty() {
            outside -= self.run_open(scan, clusters, claims, next, counts);
        }
        self.begin(scan, next, counts);
        self.remember((scan, density), &mut next.crossings, counts);
        outside
    }

    /// Lets the tracks of all other clusters take directions, and copies the open clusters.
    fn run_others(
        &mut self,
        scan: &ScanContext<'_>,
        clusters: &mut ClusterUpdate,
        claims: &mut Vec<Claims>,
        next: &mut Population,
        counts: &mut TrackerCounts,
    ) {
        let before = scan.before;
        self.open.follow(before, before.time_ns);
        claims.clear();
        claims.resize(scan.plots.len(), Claims::NONE);
        let directions = Directions::of(scan);
        let tracks_of = |cluster: &Cluster| &before.tracks[cluster.tracks.start as usize..cluster.tracks.end as usize];
        for cluster in &before.clusters {
            let tracks = tracks_of(cluster);
            if is_open(tracks, &next.crossings) {
                copy(before, cluster, &mut self.open);
                continue;
            }
            for track in tracks.iter().filter(|track| track.is_confirmed()) {
                directions.claim(track, claims);
            }
        }
        for cluster in &before.clusters {
            if !is_open(tracks_of(cluster), &next.crossings) {
                clusters.run_directions(scan, cluster, claims, next, counts);
            }
        }
    }

    /// Updates the open clusters by the hypotheses. Returns the number of free directions in the gates of confirmed
    /// tracks of these clusters.
    fn run_open(
        &mut self,
        scan: &ScanContext<'_>,
        clusters: &mut ClusterUpdate,
        claims: &[Claims],
        next: &mut Population,
        counts: &mut TrackerCounts,
    ) -> usize {
        let (open, plots, sensor) = (&self.open, scan.plots, scan.sensor);
        self.log_clutter.clear();
        let claimed = scan.log_clutter.iter().zip(claims);
        // No confirmed track has the number [`TENTATIVE`]: these are the claims of all tracks.
        let claimed = claimed.map(|(log_clutter, claims)| log_clutter + claims.of_others(TENTATIVE).ln_1p());
        self.log_clutter.extend(claimed);
        self.replies.read(plots.iter().map(|plot| &plot.identity));
        self.gating.run(
            open,
            plots,
            (scan.time_ns, &self.replies),
            (sensor, &scan.survival),
            counts,
        );
        self.unresolved
            .find((open, &self.gating), plots, (scan.time_ns, &self.replies), sensor);
        self.departures.clear();
        let found = (&mut self.gating, &self.unresolved, &self.departures);
        self.coupling
            .run(found, open, (plots, &self.log_clutter), sensor, scan.settings);
        let of_open = ScanContext {
            before: open,
            log_clutter: &self.log_clutter,
            gating: &self.gating,
            unresolved: &self.unresolved,
            departures: &self.departures,
            support: &self.support,
            settings: &self.settings,
            ..*scan
        };
        run_clusters(&of_open, clusters, next, counts);
        let mut inside = 0;
        let is_confirmed = |track: u32| open.tracks[track as usize].is_confirmed();
        for pair in self.gating.pairs.iter().filter(|pair| is_confirmed(pair.track)) {
            let is_free = &mut self.is_free[pair.plot as usize];
            inside += usize::from(*is_free);
            *is_free = false;
        }
        inside
    }

    /// Whether a crossing has no track although tracks have begun at others lately. A ghost that begins before the
    /// targets, since a target was missed, would be certain before the targets can compete: all begin again.
    fn are_rivals_late(&mut self, scan: &ScanContext<'_>, memory: &CrossingMemory) -> bool {
        let span_s = scan.settings.initiation.crossing_s.unwrap_or(0.0);
        let since_s = scan.time_ns.saturating_sub(memory.since_ns) as f64 / NS_PER_S;
        let is_early = since_s <= ANEW_SPANS * span_s;
        // Tracks that have begun elsewhere stay.
        let stays = |track: &Track| track.is_confirmed() || !memory.roots.contains(&track.root);
        if self.open.clusters.is_empty() || !is_early || self.open.tracks.iter().any(stays) {
            return false;
        }
        self.find(scan, memory);
        self.found.len() <= CROSSINGS_MAX && self.found.iter().any(|crossing| !is_known(crossing, scan, &self.open))
    }

    /// Finds the crossings of free directions with earlier directions.
    fn find(&mut self, scan: &ScanContext<'_>, memory: &CrossingMemory) {
        let settings = scan.settings;
        self.found.clear();
        let Some(span_s) = settings.initiation.crossing_s else {
            return;
        };
        let free = self.is_free.iter().filter(|is_free| **is_free).count();
        if settings.starts == Starts::Designated || free == 0 || free > RAYS_OF_SCAN_MAX {
            return;
        }
        for (place, plot) in (0..).zip(scan.plots).filter(|(place, _)| self.is_free[*place as usize]) {
            for ray in &memory.rays {
                let apart_s = plot.time_ns.saturating_sub(ray.time_ns) as f64 / NS_PER_S;
                if ray.sensor == scan.sensor.bit || apart_s.abs() > span_s {
                    continue;
                }
                if let Some(measurement) = cross(&ray.measurement, &plot.measurement, apart_s, &settings.initiation) {
                    self.found.push(Crossing {
                        plot: place as u32,
                        ray: *ray,
                        measurement,
                    });
                }
            }
        }
    }

    /// Begins a track at each crossing of a free direction with an earlier direction, unless a track has begun there
    /// already.
    fn begin(&mut self, scan: &ScanContext<'_>, next: &mut Population, counts: &mut TrackerCounts) {
        self.find(scan, &next.crossings);
        if self.found.len() <= COMPARED_MAX {
            self.found.retain(|crossing| !is_known(crossing, scan, next));
        }
        let has_room = next.crossings.roots.len() + self.found.len() <= ROOTS_MAX;
        if self.found.len() > CROSSINGS_MAX || !has_room {
            counts.crossings_dropped += self.found.len() as u64;
            return;
        }
        if next.crossings.roots.is_empty() && !self.found.is_empty() {
            next.crossings.since_ns = match next.crossings.since_ns {
                // The crossings begin again.
                since_ns if !self.open.clusters.is_empty() => since_ns,
                _ => scan.time_ns,
            };
        }
        for crossing in &self.found {
            begin_at(crossing, scan, next, counts);
        }
    }

    /// Keeps the free directions of this scan in place of the sensor's scan before.
    fn remember(
        &self,
        (scan, density): (&ScanContext<'_>, f64),
        memory: &mut CrossingMemory,
        counts: &mut TrackerCounts,
    ) {
        let span_s = scan.settings.initiation.crossing_s.unwrap_or(0.0);
        let is_young = |ray: &Ray| scan.time_ns.saturating_sub(ray.time_ns) as f64 / NS_PER_S <= span_s;
        memory.rays.retain(|ray| ray.sensor != scan.sensor.bit && is_young(ray));
        let free = (0..)
            .zip(scan.plots)
            .zip(&self.is_free)
            .filter(|(_, is_free)| **is_free);
        let count = free.clone().count();
        if count > RAYS_OF_SCAN_MAX || memory.rays.len() + count > RAYS_MAX {
            counts.crossings_dropped += count as u64;
            return;
        }
        let width_rad = scan.sensor.extent().width_rad.min(TAU);
        memory.rays.extend(free.map(|((place, plot), _)| Ray {
            sensor: scan.sensor.bit,
            time_ns: plot.time_ns,
            serial: scan.first_serial.wrapping_add(place),
            expected_false: (density * width_rad).max(FALSE_MIN),
            measurement: plot.measurement,
        }));
    }
}

/// The settings by which directions confirm tracks that have begun at crossings: after more detections than others, and
/// no easier beside confirmed tracks, where ghosts are.
fn confirmed_late(settings: &Settings) -> Settings {
    let mut late = settings.clone();
    let confirmation = &mut late.confirmation;
    confirmation.detections_min = confirmation.detections_min.max(settings.initiation.crossing_detections);
    late.splitting.reliability_min = None;
    late.reduction.merge_scans = HISTORY_MAX;
    late.reduction.hypotheses_max = HYPOTHESES_MAX;
    late.reduction.reliability_min = late.reduction.reliability_min.min(RELIABILITY_MIN);
    late.splitting.third_reliability_min = None;
    late
}

/// Whether a cluster has a tentative track that has begun at a crossing.
fn is_open(tracks: &[Track], memory: &CrossingMemory) -> bool {
    let begun = |track: &Track| !track.is_confirmed() && memory.roots.contains(&track.root);
    !memory.roots.is_empty() && tracks.iter().any(begun)
}

/// Copies a cluster with its tracks and hypotheses into `to`, which has as much room as the cluster's population.
fn copy(from: &Population, cluster: &Cluster, to: &mut Population) {
    let [tracks, hypotheses] = [to.tracks.len() as u32, to.hypotheses.len() as u32];
    let moved = |member: &u32| member - cluster.tracks.start + tracks;
    to.tracks
        .extend_from_slice(&from.tracks[cluster.tracks.start as usize..cluster.tracks.end as usize]);
    for hypothesis in &from.hypotheses[cluster.hypotheses.start as usize..cluster.hypotheses.end as usize] {
        let begin = to.members.len() as u32;
        to.members.extend(from.members_of(hypothesis).iter().map(moved));
        to.hypotheses.push(Hypothesis {
            log_reliability: hypothesis.log_reliability,
            members: begin..to.members.len() as u32,
        });
    }
    to.clusters.push(Cluster {
        tracks: tracks..to.tracks.len() as u32,
        hypotheses: hypotheses..to.hypotheses.len() as u32,
        ..cluster.clone()
    });
}

/// Whether a track that has begun at a crossing is there.
fn is_known(crossing: &Crossing, scan: &ScanContext<'_>, population: &Population) -> bool {
    let time_ns = scan.plots[crossing.plot as usize].time_ns;
    let roots = &population.crossings.roots;
    let mut begun = population.tracks.iter().filter(|track| roots.contains(&track.root));
    begun.any(|track| {
        let motion = track.motion_at(time_ns, &scan.settings.motion);
        let innovation = motion.innovation(&crossing.measurement);
        innovation.is_some_and(|innovation| innovation.squared_distance <= scan.sensor.gates[1])
    })
}

fn begin_at(crossing: &Crossing, scan: &ScanContext<'_>, next: &mut Population, counts: &mut TrackerCounts) {
    let settings = scan.settings;
    let plot = &scan.plots[crossing.plot as usize];
    let weight = (scan.log_weight + plot.log_weight).exp();
    let by_chance = crossing.ray.expected_false / scan.sensor.detection_probability;
    let share = weight * settings.initiation.new_target_share / by_chance;
    let reliability = share / (1.0 + share);
    if reliability < settings.reduction.reliability_min {
        return;
    }
    let Some(motion) = TargetMotion::first(&crossing.measurement, &settings.initiation, &settings.motion) else {
        return;
    };
    let serial = scan.first_serial.wrapping_add(crossing.plot);
    let mut track = Track {
        log_likelihood_ratio: settings.initiation.new_target_share.ln(),
        seen_by: scan.sensor.bit | crossing.ray.sensor,
        reliability,
        ..Track::begun(motion, plot.time_ns, crossing.ray.serial, next.next_root)
    };
    // Both directions are used: a track that has used either is another explanation.
    track.remember(serial);
    let root = track.root;
    if !next.add_tentative(track) {
        counts.dropped_tracks += 1;
        return;
    }
    next.crossings.roots.push(root);
    counts.crossings += 1;
    scan.explain(TrackEvent::Started, &track, reliability, f64::NAN);
}

/// The crossing of an earlier direction with a direction `apart_s` later, as a range and bearing from the sensor of the
/// later direction. `None` where the rays do not meet, or hardly at an angle.
fn cross(
    first: &DetectionMeasurement,
    second: &DetectionMeasurement,
    apart_s: f64,
    guess: &Initiation,
) -> Option<DetectionMeasurement> {
    let ([bearing, _, _], [other, _, _]) = (second.values, first.values);
    let ((sin, cos), (other_sin, other_cos)) = (bearing.sin_cos(), other.sin_cos());
    let sine = sin * other_cos - cos * other_sin;
    // Written so that NaN is refused.
    let is_sharp = sine.abs() >= SINE_MIN;
    if !is_sharp {
        return None;
    }
    let [east, north] = [0, 1].map(|axis| first.platform_m[axis] - second.platform_m[axis]);
    let range = (east * other_cos - north * other_sin) / sine;
    let other_range = (east * cos - north * sin) / sine;
    if !(range >= 1.0 && other_range >= 1.0) {
        return None;
    }
    let moved = guess.speed_sigma_mps * apart_s.abs();
    let across = (other_range * first.sigmas[0]).hypot(moved);
    let cosine = (1.0 - sine * sine).max(0.0).sqrt();
    let along = across.hypot(range * second.sigmas[0] * cosine) / sine.abs();
    if along > KNOWN * range {
        return None;
    }
    let elevated = |measurement: &DetectionMeasurement| measurement.kind == DetectionKind::BearingElevation;
    if elevated(first) && elevated(second) {
        let height = |measurement: &DetectionMeasurement, ground: f64, error: f64| {
            let (elevation, tangent) = (measurement.values[1], measurement.values[1].tan());
            let sigma = (ground * measurement.sigmas[1] / elevation.cos().powi(2)).hypot(error * tangent);
            (measurement.platform_m[2] + ground * tangent, sigma)
        };
        let (up, sigma) = height(second, range, along);
        let (other_up, other_sigma) = height(first, other_range, along);
        let climbed = guess.climb_sigma_mps * apart_s.abs();
        let is_level = (up - other_up).abs() <= HEIGHT_GATE * sigma.hypot(other_sigma).hypot(climbed);
        if !is_level {
            return None;
        }
    }
    let (kind, values, sigmas) = match elevated(second) {
        true => {
            let [_, elevation, _] = second.values;
            let slant = 1.0 / elevation.cos();
            (
                DetectionKind::RangeBearingElevation,
                [range * slant, bearing, elevation],
                [along * slant, second.sigmas[0], second.sigmas[1], 0.0],
            )
        }
        false => (
            DetectionKind::RangeBearing,
            [range, bearing, 0.0],
            [along, second.sigmas[0], 0.0, 0.0],
        ),
    };
    Some(DetectionMeasurement {
        kind,
        values,
        range_rate_mps: None,
        sigmas,
        platform_m: second.platform_m,
    })
}

#[cfg(test)]
#[path = "crossing_tests.rs"]
mod tests;
