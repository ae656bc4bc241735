//! Detections of two established tracks together: targets that a sensor does not resolve.
//!
//! Targets within a resolution cell of a sensor give a single common detection. A tracker with at most one track per
//! detection gives the detection to either track, which is drawn aside; the other is missed until deleted. A second
//! sensor, or the time before and after, determines both tracks better.
//!
//! So, for each pair of confirmed tracks of a hypothesis that may lie within a cell of the sensor (difference of range
//! and of bearing), the scan has two explanations, weighed by that probability U: resolved and unresolved. Resolved,
//! each track has its own detection or none. Unresolved, the pair has a single detection z, or is missed as a whole.
//! The unresolved explanation has the measurement z = h((a + b) / 2), so each of both states a and b is updated with
//! half the derivative and the other's covariance as a part of the measurement's. Both tracks keep the detection in
//! memory, so both stay in the same cluster.
//!
//! Two tracks of the same target would share detections for ever. A detection of two does not count as a sign of life
//! of either: of two tracks that have only had such detections for `deletion.silent_s`, the later one is deleted.
//!
//! The detection states the address of either, or none: with a third address, the detection is of another target.
//!
//! Limits: pairs, not larger groups; a track is in a single pair of a hypothesis at a time, the likeliest, and a
//! hypothesis has at most [`PAIRS_OF_HYPOTHESIS_MAX`] pairs. The correlation of both states after the update is not
//! kept.
//!
//! Source: W. Koch, G. van Keuk, *Multiple hypothesis track maintenance with possibly unresolved measurements*, IEEE
//! Transactions on Aerospace and Electronic Systems 33 (1997).

use std::ops::Range;

use association::distance::largest_sigma2;
use estimation::Gaussian;

use crate::gating::Gating;
use crate::identity::ScanReplies;
use crate::motion::TargetMotion;
use crate::plot::Plot;
use crate::population::Population;
use crate::resolution_cell::ResolutionCell;
use crate::sensor::Sensor;

/// Most pairs of a hypothesis that a scan may leave unresolved.
pub(crate) const PAIRS_OF_HYPOTHESIS_MAX: usize = 2;
/// Least probability of being unresolved for a pair to be considered.
const PROBABILITY_MIN: f64 = 0.01;
/// Largest probability: the cell is never known better.
const PROBABILITY_MAX: f64 = 0.99;
/// Standard deviations within which detections of a pair are looked for.
const REACH: f64 = 4.0;

/// Set in the number of a pair of a detection and two tracks, to distinguish the pair from a pair with a single track.
pub(crate) const SHARED: u32 = 1 << 31;

/// Two confirmed tracks that a sensor may not resolve.
#[derive(Clone, Debug)]
pub(crate) struct UnresolvedPair {
    pub(crate) tracks: [u32; 2],
    /// Logarithms of the probabilities of a single detection for both, and of separate detections.
    pub(crate) log_unresolved: f64,
    pub(crate) log_resolved: f64,
    /// Logarithm of the probability that both are missed together.
    pub(crate) log_miss: f64,
    /// Places of the pair's detections.
    pub(crate) detections: Range<u32>,
}

/// A detection that may be of both tracks of a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SharedDetection {
    pub(crate) pair: u32,
    pub(crate) plot: u32,
    /// Density of the detection if both targets are there and it is of both.
    pub(crate) log_likelihood: f64,
}

/// A confirmed track at the time of the scan.
#[derive(Clone, Copy, Debug)]
struct Predicted {
    track: u32,
    motion: TargetMotion,
    estimate: Gaussian,
    /// Distance east within which others may be in the same cell, metres.
    reach_m: f64,
}

/// Pairs of a scan; working memory, reused for each scan.
#[derive(Clone, Debug)]
pub(crate) struct Unresolved {
    pub(crate) pairs: Vec<UnresolvedPair>,
    pub(crate) detections: Vec<SharedDetection>,
    predicted: Vec<Predicted>,
    /// (east, place in that list), sorted.
    places: Vec<(f64, u32)>,
}

impl Unresolved {
    /// Room for some of the tracks and detections; a tracker of sensors that resolve everything needs none.
    pub(crate) fn new(tracks_max: usize, is_needed: bool) -> Self {
        let room = if is_needed { tracks_max } else { 0 };
        Self {
            pairs: Vec::with_capacity(room),
            detections: Vec::with_capacity(4 * room),
            predicted: Vec::with_capacity(room),
            places: Vec::with_capacity(room),
        }
    }

    /// The tracks of a detection's pair, given as [`SHARED`] and the detection's place.
    pub(crate) fn tracks_of(&self, shared: u32) -> [u32; 2] {
        let found = self.detections[(shared & !SHARED) as usize];
        self.pairs[found.pair as usize].tracks
    }

    /// Finds the pairs of tracks that the sensor may not resolve in a scan, and the detections of each pair.
    pub(crate) fn find(
        &mut self,
        (population, gating): (&Population, &Gating),
        plots: &[Plot],
        (time_ns, replies): (i64, &ScanReplies),
        sensor: &Sensor,
    ) {
        self.pairs.clear();
        self.detections.clear();
        let (Some(cell), Some(sensor_m)) = (sensor.cell, sensor.platform_m) else {
            return;
        };
        self.predict(population, time_ns, sensor, (&cell, sensor_m));
        for first in 0..self.places.len() {
            let (east, place) = self.places[first];
            let one = self.predicted[place as usize];
            let near = self.places[first + 1..]
                .iter()
                .take_while(|(other, _)| other - east <= one.reach_m);
            for &(_, place) in near {
                let other = &self.predicted[place as usize];
                let tracks = [one.track, other.track];
                let [a, b] = tracks.map(|track| &population.tracks[track as usize]);
                if a.number == b.number || self.pairs.len() == self.pairs.capacity() {
                    continue;
                }
                let probability = cell.holds(&one.estimate, &other.estimate, sensor_m);
                if probability < PROBABILITY_MIN || probability.is_nan() {
                    continue;
                }
                let probability = probability.min(PROBABILITY_MAX);
                let middle = TargetMotion::middle(&one.motion, &other.motion);
                let begin = self.detections.len() as u32;
                let pair = self.pairs.len() as u32;
                let may_be_both = |plot: &Plot| {
                    ![a, b]
                        .iter()
                        .all(|track| replies.are_strangers(&track.identity, track.is_confirmed(), &plot.identity))
                };
                find_detections(&middle, pair, plots, may_be_both, sensor, &mut self.detections);
                let log_presence: f64 = tracks.iter().map(|track| gating.log_presence(*track)).sum();
                let found = self.detections[begin as usize..].iter_mut();
                found.for_each(|found| found.log_likelihood += log_presence);
                self.pairs.push(UnresolvedPair {
                    tracks,
                    log_unresolved: probability.ln(),
                    log_resolved: (-probability).ln_1p(),
                    log_miss: sensor.log_miss(sensor.probability_in_view(&middle.estimate())),
                    detections: begin..self.detections.len() as u32,
                });
            }
        }
    }

    /// Predicts the confirmed tracks, from west to east.
    fn predict(
        &mut self,
        population: &Population,
        time_ns: i64,
        sensor: &Sensor,
        (cell, [east, north]): (&ResolutionCell, [f64; 2]),
    ) {
        self.predicted.clear();
        self.places.clear();
        for (number, track) in (0..).zip(&population.tracks) {
            if !track.is_confirmed() || self.predicted.len() == self.predicted.capacity() {
                continue;
            }
            let motion = track.motion_at(time_ns, &sensor.motion);
            let estimate = motion.estimate();
            let range = (estimate.mean[0] - east).hypot(estimate.mean[1] - north);
            let [xx, xy, _, yy, ..] = estimate.position_covariance();
            let sigma = largest_sigma2([xx, xy, yy]);
            self.places.push((estimate.mean[0], self.predicted.len() as u32));
            self.predicted.push(Predicted {
                track: number,
                motion,
                estimate,
                reach_m: cell.widest_m(range) + REACH * sigma,
            });
        }
        self.places
            .sort_unstable_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
    }
}

/// Adds the detections in the gate of the middle of a pair that may be of both.
fn find_detections(
    middle: &TargetMotion,
    pair: u32,
    plots: &[Plot],
    may_be_both: impl Fn(&Plot) -> bool,
    sensor: &Sensor,
    found: &mut Vec<SharedDetection>,
) {
    let widest = middle.widest();
    let [xx, xy, _, yy, ..] = widest.position_covariance();
    let sigma = largest_sigma2([xx, xy, yy]);
    let [east, north, ..] = widest.mean;
    for (number, plot) in (0..).zip(plots) {
        let Some((place, sigma_m)) = plot.measurement.place() else {
            continue;
        };
        let apart = (place[0] - east).hypot(place[1] - north);
        if apart > REACH * sigma.hypot(sigma_m) || found.len() == found.capacity() {
            continue;
        }
        let Some(innovation) = middle.innovation(&plot.measurement) else {
            continue;
        };
        if innovation.squared_distance <= sensor.gates[innovation.dimension - 1] && may_be_both(plot) {
            found.push(SharedDetection {
                pair,
                plot: number,
                log_likelihood: innovation.log_likelihood,
            });
        }
    }
}
