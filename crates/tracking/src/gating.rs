//! Pairs of detections and tracks within the gates, and the clusters that these pairs join (HT-2, HT-4).
//!
//! Every track is predicted to each detection's time and compared with the detections nearby, found by a grid. A
//! detection in a gate belongs to the track's cluster; if the detection already belongs to another cluster, the two are
//! joined. A detection with another address than the track's does not lie in the track's gate ([`crate::identity`]).
//!
//! Bounds: a track is compared with at most [`COMPARISONS_MAX`] detections and keeps the [`PAIRS_MAX`] likeliest; a
//! cluster that would grow beyond [`CLUSTER_TRACKS_MAX`] tracks or [`ROWS_MAX`] detections drops the pair beyond the
//! limit. So 10,000 detections in one gate cost no more than 10,000 elsewhere. All is counted.

use association::{Grid, distance};
use messages::NS_PER_S;

use crate::counts::TrackerCounts;
use crate::existence::{self, Survival};
use crate::identity::{LOG_NAMED, ScanReplies, TrackIdentity};
use crate::limits::{COMPARISONS_MAX, PAIRS_MAX};
use crate::motion::TargetMotion;
use crate::plot::{Plot, SharedPlot};
use crate::population::Population;
use crate::ranked::ROWS_MAX;
use crate::sensor::Sensor;
use crate::track::Track;

/// Side of the grid's cells, metres.
const CELL_M: f64 = 1000.0;
/// Most cells on a side of a search in the grid; a wider search compares every detection.
const CELLS_MAX: f64 = 12.0;

/// Reaches beyond which a detection is not in the gate of the other model either.
const FAR_REACHES: f64 = 3.0;

pub(crate) const NONE: u32 = u32::MAX;

/// A track and a detection in the gate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GatedPair {
    pub(crate) track: u32,
    pub(crate) plot: u32,
    /// Density of the detection if it is of the track, with the likelihood of the reply ([`crate::identity`]).
    pub(crate) log_likelihood: f64,
    /// Set if the detection lies outside the gate, but names the track's target.
    pub(crate) is_far: bool,
}

/// Pairs and clusters of a scan.
#[derive(Clone, Debug)]
pub(crate) struct Gating {
    /// Sorted by track.
    pub(crate) pairs: Vec<GatedPair>,
    /// By track: index of the first pair; the last entry is the end.
    pub(crate) pairs_begin: Vec<u32>,
    /// By track: logarithm of the probability of no detection in the gate, times the weight of the scan.
    pub(crate) log_misses: Vec<f64>,
    /// By track: probability that the target has gone, after a miss.
    pub(crate) absences: Vec<f64>,
    /// By track: the same before the scan.
    absent: Vec<f64>,
    /// By cluster: number of detections, at most.
    rows: Vec<u32>,
    /// By detection: the last cluster with the detection in a gate, or [`NONE`].
    owner: Vec<u32>,
    /// By detection: whether the reply names a track with the detection in the gate.
    is_named: Vec<bool>,
    /// (track, detection) in the gate of motion, with different addresses; sorted by track.
    strangers: Vec<(u32, u32)>,
    /// By detection: whether the address is that of a track with the detection in the gate.
    pub(crate) is_echo: Vec<bool>,
    /// By detection: whether the reply names a track anywhere: the target has left no other track.
    pub(crate) names: Vec<bool>,
    /// (representative, cluster), sorted.
    pub(crate) clusters: Vec<(u32, u32)>,
    /// (representative, detection), sorted; detections of no cluster last.
    pub(crate) plots: Vec<(u32, u32)>,
    /// By entry of that list.
    pub(crate) shared: Vec<SharedPlot>,
    grid: Grid,
    in_grid: usize,
    /// By detection: place, east and north, metres.
    places: Vec<[f64; 2]>,
    near: Vec<u32>,
}

impl Gating {
    pub(crate) fn new(tracks_max: usize, plots_max: usize) -> Self {
        Self {
            pairs: Vec::with_capacity(4 * tracks_max + PAIRS_MAX),
            pairs_begin: Vec::with_capacity(tracks_max + 1),
            log_misses: Vec::with_capacity(tracks_max),
            absences: Vec::with_capacity(tracks_max),
            absent: Vec::with_capacity(tracks_max),
            rows: Vec::with_capacity(tracks_max),
            owner: Vec::with_capacity(plots_max),
            is_named: Vec::with_capacity(plots_max),
            strangers: Vec::with_capacity(4 * tracks_max),
            is_echo: Vec::with_capacity(plots_max),
            names: Vec::with_capacity(plots_max),
            clusters: Vec::with_capacity(tracks_max),
            plots: Vec::with_capacity(2 * (4 * tracks_max + PAIRS_MAX) + plots_max),
            shared: Vec::with_capacity(2 * (4 * tracks_max + PAIRS_MAX) + plots_max),
            grid: Grid::new(CELL_M, plots_max),
            in_grid: 0,
            places: Vec::with_capacity(plots_max),
            near: Vec::with_capacity(plots_max),
        }
    }

    /// Compares all tracks with all detections of a scan.
    pub(crate) fn run(
        &mut self,
        population: &Population,
        plots: &[Plot],
        (time_ns, replies): (i64, &ScanReplies),
        (sensor, survival): (&Sensor, &Survival<'_>),
        counts: &mut TrackerCounts,
    ) {
        self.begin(population, plots);
        let reach = Reach::of(plots, time_ns);
        for (number, cluster) in (0..).zip(&population.clusters) {
            let are_several = population.has_several(cluster);
            for track in cluster.tracks.clone() {
                self.pairs_begin.push(self.pairs.len() as u32);
                let compared = &population.tracks[track as usize];
                let predicted = compared.motion_at(time_ns, &sensor.motion);
                let seen = sensor.probability_in_view(predicted.widest());
                let absence = survival.absence(compared.absence, predicted.widest());
                let log_miss = sensor.log_miss(seen);
                self.absences
                    .push(existence::weighed(absence, sensor.silence(seen, log_miss)));
                self.log_misses.push(match compared.seen_by & sensor.bit {
                    0 => log_miss,
                    _ => sensor.log_lapse(seen),
                });
                self.absent.push(if are_several { 0.0 } else { absence });
                self.search(&predicted, plots.len(), &reach, sensor.gates[1]);
                let first = self.pairs.len();
                self.compare(track, compared, &predicted, (time_ns, replies), plots, sensor, counts);
                self.own(number, first, counts);
            }
        }
        self.pairs_begin.push(self.pairs.len() as u32);
        if replies.are_any() {
            self.find_far(population, plots, replies, sensor, counts);
        }
    }

    /// The pairs of a track.
    pub(crate) fn pairs_of(&self, track: u32) -> std::ops::Range<usize> {
        self.pairs_begin[track as usize] as usize..self.pairs_begin[track as usize + 1] as usize
    }

    /// Logarithm of the probability that a track's target is there before the scan's detections.
    pub(crate) fn log_presence(&self, track: u32) -> f64 {
        (-self.absent[track as usize]).ln_1p()
    }

    fn begin(&mut self, population: &Population, plots: &[Plot]) {
        for item in 0..self.in_grid {
            self.grid.remove(item as u32);
        }
        self.in_grid = plots.len();
        self.places.clear();
        for (item, plot) in (0..).zip(plots) {
            let place = plot.measurement.place().map(|(place, _)| place);
            if let Some([east, north]) = place {
                self.grid.place(item, east, north);
            }
            self.places.push(place.unwrap_or_default());
        }
        self.pairs.clear();
        self.pairs_begin.clear();
        self.log_misses.clear();
        self.absences.clear();
        self.absent.clear();
        self.rows.clear();
        self.rows.resize(population.clusters.len(), 0);
        self.strangers.clear();
        self.is_named.clear();
        self.is_named.resize(plots.len(), false);
        self.is_echo.clear();
        self.is_echo.resize(plots.len(), false);
        self.names.clear();
        self.names.resize(plots.len(), false);
        self.owner.clear();
        self.owner.resize(plots.len(), NONE);
    }

    /// Finds the detections that may be in the gate of a track predicted here.
    fn search(&mut self, predicted: &TargetMotion, plots: usize, reach: &Reach, gate: f64) {
        self.near.clear();
        let predicted = predicted.widest();
        let [xx, xy, _, yy, ..] = predicted.position_covariance();
        let sigma = distance::largest_sigma2([xx, xy, yy]).hypot(reach.sigma_m);
        let reach_m = gate.sqrt() * sigma;
        // Written so that NaN looks at all.
        let few_cells = 2.0 * reach_m <= CELLS_MAX * CELL_M;
        if reach.all_have_places && few_cells {
            let near = &mut self.near;
            let [east, north, _, vx, vy, ..] = predicted.mean;
            let cells = CELLS_MAX as i32 + 1;
            // Cells are large: the detections far beyond the reach are left out at no cost. The target moves between
            // the times of the detections of a turn.
            let moved_m = vx.hypot(vy) * reach.apart_s;
            let (places, far_m) = (&self.places, FAR_REACHES * reach_m + moved_m);
            self.grid.near(east, north, reach_m, cells, |item| {
                let [x, y] = places[item as usize];
                if (x - east).abs() <= far_m && (y - north).abs() <= far_m {
                    near.push(item);
                }
            });
            near.sort_unstable();
        } else {
            self.near.extend(0..plots as u32);
        }
    }

    /// Finds the detections with a place near this prediction, in the order of detections; none for a prediction that
    /// is nearly anywhere.
    pub(crate) fn near(&self, predicted: &TargetMotion, gate: f64, near: &mut Vec<u32>) {
        near.clear();
        let predicted = predicted.widest();
        let [xx, xy, _, yy, ..] = predicted.position_covariance();
        let [east, north, ..] = predicted.mean;
        let reach_m = gate.sqrt() * distance::largest_sigma2([xx, xy, yy]);
        // Written so that NaN finds none.
        let few_cells = 2.0 * reach_m <= CELLS_MAX * CELL_M;
        if !few_cells {
            return;
        }
        self.grid
            .near(east, north, reach_m, CELLS_MAX as i32 + 1, |item| near.push(item));
        near.sort_unstable();
    }

    /// Adds the track's likeliest pairs with the nearby detections, in the order of detections.
    #[expect(clippy::too_many_arguments, reason = "the parts of a scan")]
    fn compare(
        &mut self,
        number: u32,
        track: &Track,
        predicted: &TargetMotion,
        (time_ns, replies): (i64, &ScanReplies),
        plots: &[Plot],
        sensor: &Sensor,
        counts: &mut TrackerCounts,
    ) {
        let first = self.pairs.len();
        let room = PAIRS_MAX.min(self.pairs.capacity() - first);
        let made = self.near.len().min(COMPARISONS_MAX);
        counts.dropped_comparisons += (self.near.len() - made) as u64;
        for &item in &self.near[..made] {
            let plot = &plots[item as usize];
            let innovation = if plot.time_ns == time_ns {
                predicted.innovation(&plot.measurement)
            } else {
                let predicted = track.motion_at(plot.time_ns, &sensor.motion);
                predicted.innovation(&plot.measurement)
            };
            let Some(innovation) = innovation else { continue };
            if innovation.squared_distance > sensor.gates[innovation.dimension - 1] {
                continue;
            }
            if replies.are_strangers(&track.identity, track.is_confirmed(), &plot.identity) {
                if self.strangers.len() < self.strangers.capacity() {
                    self.strangers.push((number, item));
                }
                continue;
            }
            let log_ratio = replies.log_ratio(&track.identity, &plot.identity);
            if log_ratio > LOG_NAMED {
                self.is_named[item as usize] = true;
                self.is_echo[item as usize] |= track.identity.has_address_of(&plot.identity);
            }
            let pair = GatedPair {
                track: number,
                plot: item,
                log_likelihood: innovation.log_likelihood + log_ratio + self.log_presence(number),
                is_far: false,
            };
            if self.pairs.len() - first < room {
                self.pairs.push(pair);
                continue;
            }
            counts.dropped_pairs += 1;
            let kept = self.pairs[first..].iter_mut();
            let worst = kept.min_by(|one, other| one.log_likelihood.total_cmp(&other.log_likelihood));
            if let Some(worst) = worst.filter(|worst| worst.log_likelihood < pair.log_likelihood) {
                *worst = pair;
            }
        }
        self.pairs[first..].sort_unstable_by_key(|pair| pair.plot);
    }

    /// Adds pairs with detections outside the gates that name the tracks' targets.
    fn find_far(
        &mut self,
        population: &Population,
        plots: &[Plot],
        replies: &ScanReplies,
        sensor: &Sensor,
        counts: &mut TrackerCounts,
    ) {
        let far_begin = self.pairs.len();
        for (number, cluster) in (0..).zip(&population.clusters) {
            for track in cluster.tracks.clone() {
                let compared = &population.tracks[track as usize];
                for item in replies.naming(&compared.identity) {
                    self.names[item as usize] = true;
                    let mut far = self.pairs[far_begin..].iter().filter(|pair| pair.track == track);
                    let near = &self.pairs[self.pairs_of(track)];
                    if near.iter().any(|pair| pair.plot == item) || far.any(|pair| pair.plot == item) {
                        continue;
                    }
                    let plot = &plots[item as usize];
                    if replies.are_strangers(&compared.identity, compared.is_confirmed(), &plot.identity) {
                        continue;
                    }
                    let predicted = compared.motion_at(plot.time_ns, &sensor.motion);
                    let found = predicted
                        .innovation(&plot.measurement)
                        .and_then(|innovation| sensor.log_far(&innovation));
                    let Some((log_likelihood, is_far)) = found else {
                        continue;
                    };
                    if is_far && self.has_strange_reply(track, &compared.identity, plots, replies) {
                        continue;
                    }
                    if self.pairs.len() == self.pairs.capacity() || self.pairs_of(track).len() >= PAIRS_MAX {
                        counts.dropped_pairs += 1;
                        continue;
                    }
                    let first = self.pairs.len();
                    self.pairs.push(GatedPair {
                        track,
                        plot: item,
                        log_likelihood: log_likelihood
                            + replies.log_ratio(&compared.identity, &plot.identity)
                            + self.log_presence(track),
                        is_far,
                    });
                    self.is_echo[item as usize] |= compared.identity.has_address_of(&plot.identity);
                    self.own(number, first, counts);
                }
            }
        }
        if self.pairs.len() > far_begin {
            self.pairs.sort_unstable_by_key(|pair| (pair.track, pair.plot));
            let pairs = &self.pairs;
            for (track, begin) in self.pairs_begin.iter_mut().enumerate() {
                *begin = pairs.partition_point(|pair| (pair.track as usize) < track) as u32;
            }
        }
    }

    /// Whether a detection in the track's gate has a reply that contradicts and names no target there: replies were
    /// exchanged, and the target has not moved.
    fn has_strange_reply(&self, track: u32, identity: &TrackIdentity, plots: &[Plot], replies: &ScanReplies) -> bool {
        let near = self.pairs[self.pairs_of(track)].iter().map(|pair| pair.plot as usize);
        let first = self.strangers.partition_point(|(of, _)| *of < track);
        let mut strangers = self.strangers[first..].iter().take_while(|(of, _)| *of == track);
        near.into_iter()
            .any(|item| !self.is_named[item] && replies.log_ratio(identity, &plots[item].identity) < 0.0)
            || strangers.any(|(_, item)| !self.is_named[*item as usize])
    }

    /// Keeps the detections of the pairs from `first` on for the cluster; drops pairs that would give the cluster too
    /// many.
    fn own(&mut self, cluster: u32, first: usize, counts: &mut TrackerCounts) {
        let mut kept = first;
        for place in first..self.pairs.len() {
            let pair = self.pairs[place];
            let (owner, rows) = (&mut self.owner[pair.plot as usize], &mut self.rows[cluster as usize]);
            if *owner != cluster && *rows as usize >= ROWS_MAX {
                counts.dropped_pairs += 1;
                continue;
            }
            *rows += u32::from(*owner != cluster);
            *owner = cluster;
            self.pairs[kept] = pair;
            kept += 1;
        }
        self.pairs.truncate(kept);
    }
}

/// Width of the search for a scan's detections.
struct Reach {
    /// Largest standard deviation of any detection's place, metres.
    sigma_m: f64,
    /// Directions without a range have no place in the grid.
    all_have_places: bool,
    /// Longest time between a detection and the prediction, seconds.
    apart_s: f64,
}

impl Reach {
    fn of(plots: &[Plot], time_ns: i64) -> Self {
        let apart_ns = plots.iter().map(|plot| plot.time_ns.abs_diff(time_ns)).max();
        let sigmas = plots
            .iter()
            .map(|plot| plot.measurement.place().map(|(_, sigma)| sigma));
        Self {
            sigma_m: sigmas.clone().flatten().fold(0.0, f64::max),
            all_have_places: sigmas.into_iter().all(|sigma| sigma.is_some()),
            apart_s: apart_ns.unwrap_or(0) as f64 / NS_PER_S,
        }
    }
}
