//! Coupling of clusters by shared detections: which clusters are updated together (HT-4).
//!
//! The source joins two clusters as soon as a detection lies in gates of both. In a crowd, the wide gates of new tracks
//! join everything with everything. A cluster of k tracks that may each be false needs 2^k hypotheses, so a few dozen
//! hypotheses describe five of sixty tracks; the others are lost or never confirmed. More hypotheses hardly help.
//!
//! Most of these shared detections do not matter: most lie at the edge of a gate, or almost surely belong to a track of
//! a single cluster. So each cluster has a *claim* to a detection,
//!
//! ```text
//! claim = Σ over its tracks  r·w / (1 − r + r·(m + Σ w of its other detections))
//! ```
//!
//! with the reliability r of the track, the likelihood w of the pair relative to a false detection and the probability
//! m of a miss. Two clusters are joined where both may have the detection: the product of the claims' shares in the sum
//! with 1, for false, reaches `reduction.join_probability_min`. Elsewhere each cluster is updated alone, and the
//! others' claims add to the likelihood of a false detection. These are the messages of a single round of belief
//! propagation (J. Williams, R. Lau, *Approximate evaluation of marginal association probabilities with belief
//! propagation*, IEEE Transactions on Aerospace and Electronic Systems 50 (2014)); joining stays exact.
//!
//! Limit: two clusters that are not joined may both take the detection, with at most that probability. If the clusters
//! are joined later, the hypotheses with a common detection are left out ([`crate::parents`]).

use association::components::representative;

use crate::departure::Departures;
use crate::gating::{Gating, NONE};
use crate::limits::CLUSTER_TRACKS_MAX;
use crate::plot::{Plot, SharedPlot};
use crate::population::Population;
use crate::ranked::ROWS_MAX;
use crate::sensor::Sensor;
use crate::settings::{Settings, Starts};
use crate::track::NO_DETECTION;
use crate::unresolved::Unresolved;

/// Largest logarithm of a likelihood ratio: more is certain, and must not overflow.
const LOG_MAX: f64 = 30.0;

/// A cluster's claim to a detection.
#[derive(Clone, Copy, Debug)]
struct Claim {
    plot: u32,
    cluster: u32,
    likelihood: f64,
    is_confirmed: bool,
}

/// Working memory, reused for each scan.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    /// Sorted by detection.
    claims: Vec<Claim>,
    /// (serial number of a detection, cluster, reliability of the cluster's tracks with the detection), sorted.
    taken: Vec<(u32, u32, f64)>,
    /// By cluster: another cluster joined with this cluster, or the cluster itself.
    joined: Vec<u32>,
    /// By representative: numbers of tracks and, at most, detections of the joined clusters.
    sizes: Vec<(u32, u32)>,
    /// (representative, detection, use of the detection), sorted.
    shared: Vec<(u32, u32, SharedPlot)>,
}

impl Coupling {
    pub(crate) fn new(tracks_max: usize, pairs_max: usize, plots_max: usize) -> Self {
        Self {
            claims: Vec::with_capacity(2 * pairs_max),
            taken: Vec::with_capacity(tracks_max),
            joined: Vec::with_capacity(tracks_max),
            sizes: Vec::with_capacity(tracks_max),
            shared: Vec::with_capacity(2 * pairs_max + plots_max),
        }
    }

    /// Joins the clusters that have to be updated together, and lists the detections of each.
    pub(crate) fn run(
        &mut self,
        (gating, unresolved, departures): (&mut Gating, &Unresolved, &Departures),
        population: &Population,
        (plots, log_clutter): (&[Plot], &[f64]),
        sensor: &Sensor,
        settings: &Settings,
    ) {
        self.find_claims(gating, population, (plots, log_clutter), sensor);
        self.add_claims_of_two(unresolved, population, (plots, log_clutter), sensor);
        self.merge_claims();
        let reduction = &settings.reduction;
        self.begin(population);
        let most = (CLUSTER_TRACKS_MAX, ROWS_MAX);
        self.join(reduction.join_probability_min, most);
        self.join_by_past(population, reduction.join_probability_min, most);
        let few = (reduction.join_tracks, reduction.join_detections);
        self.join(0.0, few);
        self.join_by_past(population, 0.0, few);
        self.share((gating, departures), log_clutter, settings);
        gating.clusters.clear();
        for cluster in 0..self.joined.len() as u32 {
            let first = representative(&mut self.joined, cluster);
            gating.clusters.push((first, cluster));
        }
        gating.clusters.sort_unstable();
        gating.plots.clear();
        gating.shared.clear();
        for &(first, plot, shared) in &self.shared {
            gating.plots.push((first, plot));
            gating.shared.push(shared);
        }
    }

    fn find_claims(
        &mut self,
        gating: &Gating,
        population: &Population,
        (plots, log_clutter): (&[Plot], &[f64]),
        sensor: &Sensor,
    ) {
        self.claims.clear();
        for (cluster, of_cluster) in (0..).zip(&population.clusters) {
            for number in of_cluster.tracks.clone() {
                let track = &population.tracks[number as usize];
                let pairs = &gating.pairs[gating.pairs_of(number)];
                let likelihoods = pairs.iter().map(|pair| {
                    let plot = pair.plot as usize;
                    let log_ratio = sensor.log_detection + pair.log_likelihood - log_clutter[plot];
                    (log_ratio + plots[plot].log_weight).min(LOG_MAX).exp()
                });
                let all = likelihoods.clone().sum::<f64>() + gating.log_misses[number as usize].exp();
                let reliability = track.reliability.min(1.0);
                for (pair, likelihood) in pairs.iter().zip(likelihoods) {
                    let otherwise = 1.0 - reliability + reliability * (all - likelihood);
                    self.claims.push(Claim {
                        plot: pair.plot,
                        cluster,
                        likelihood: reliability * likelihood / otherwise.max(f64::MIN_POSITIVE),
                        is_confirmed: track.is_confirmed() && !pair.is_far,
                    });
                }
            }
        }
    }

    /// Adds the claims of pairs of tracks that the sensor may not resolve.
    fn add_claims_of_two(
        &mut self,
        unresolved: &Unresolved,
        population: &Population,
        (plots, log_clutter): (&[Plot], &[f64]),
        sensor: &Sensor,
    ) {
        for found in &unresolved.detections {
            let (pair, plot) = (&unresolved.pairs[found.pair as usize], found.plot as usize);
            let log_ratio = sensor.log_detection + found.log_likelihood - log_clutter[plot] + pair.log_unresolved;
            let likelihood = (log_ratio + plots[plot].log_weight - pair.log_miss).min(LOG_MAX).exp();
            for track in pair.tracks {
                let clusters = &population.clusters;
                let cluster = clusters.partition_point(|cluster| cluster.tracks.end <= track) as u32;
                if self.claims.len() < self.claims.capacity() {
                    self.claims.push(Claim {
                        plot: found.plot,
                        cluster,
                        likelihood: likelihood * population.tracks[track as usize].reliability.min(1.0),
                        is_confirmed: false,
                    });
                }
            }
        }
    }

    /// Adds up the claims of each cluster to each detection.
    fn merge_claims(&mut self) {
        self.claims.sort_unstable_by(|one, other| {
            let places = (one.plot, one.cluster).cmp(&(other.plot, other.cluster));
            places.then(one.likelihood.total_cmp(&other.likelihood))
        });
        self.claims.dedup_by(|later, earlier| {
            let is_same = (later.plot, later.cluster) == (earlier.plot, earlier.cluster);
            if is_same {
                earlier.likelihood += later.likelihood;
                earlier.is_confirmed |= later.is_confirmed;
            }
            is_same
        });
    }

    /// Every cluster alone.
    fn begin(&mut self, population: &Population) {
        self.joined.clear();
        self.joined.extend(0..population.clusters.len() as u32);
        self.sizes.clear();
        let tracks = population.clusters.iter().map(|cluster| cluster.tracks.len() as u32);
        self.sizes.extend(tracks.map(|tracks| (tracks, 0)));
        for claim in &self.claims {
            self.sizes[claim.cluster as usize].1 += 1;
        }
    }

    fn join(&mut self, probability_min: f64, most: (usize, usize)) {
        for of_plot in self.claims.chunk_by(|one, other| one.plot == other.plot) {
            let sum = 1.0 + of_plot.iter().map(|claim| claim.likelihood).sum::<f64>();
            let strongest = of_plot
                .iter()
                .max_by(|one, other| one.likelihood.total_cmp(&other.likelihood));
            let Some(strongest) = strongest else { continue };
            for other in of_plot.iter().filter(|other| other.cluster != strongest.cluster) {
                let both = (strongest.likelihood / sum) * (other.likelihood / sum);
                if both >= probability_min {
                    unite(
                        &mut self.joined,
                        &mut self.sizes,
                        (strongest.cluster, other.cluster),
                        most,
                    );
                }
            }
        }
    }

    /// Joins clusters that both contain the same past detection, each with some probability: at most one cluster is
    /// right.
    fn join_by_past(&mut self, population: &Population, probability_min: f64, most: (usize, usize)) {
        self.taken.clear();
        for (cluster, of_cluster) in (0..).zip(&population.clusters) {
            for track in &population.tracks[of_cluster.tracks.start as usize..of_cluster.tracks.end as usize] {
                if track.history[0] != NO_DETECTION {
                    self.taken.push((track.history[0], cluster, track.reliability));
                }
            }
        }
        self.taken.sort_unstable_by(|one, other| {
            let places = (one.0, one.1).cmp(&(other.0, other.1));
            places.then(one.2.total_cmp(&other.2))
        });
        self.taken.dedup_by(|later, earlier| {
            let is_same = (later.0, later.1) == (earlier.0, earlier.1);
            if is_same {
                earlier.2 += later.2;
            }
            is_same
        });
        for of_detection in self.taken.chunk_by(|one, other| one.0 == other.0) {
            let strongest = of_detection.iter().max_by(|one, other| one.2.total_cmp(&other.2));
            let Some(strongest) = strongest else { continue };
            for other in of_detection.iter().filter(|other| other.1 != strongest.1) {
                if strongest.2 * other.2 >= probability_min {
                    unite(&mut self.joined, &mut self.sizes, (strongest.1, other.1), most);
                }
            }
        }
    }

    /// Lists the detections of each group of joined clusters with the use of each; detections in no cluster come last.
    fn share(&mut self, (gating, departures): (&Gating, &Departures), log_clutter: &[f64], settings: &Settings) {
        self.shared.clear();
        let mut next = 0;
        for of_plot in self.claims.chunk_by(|one, other| one.plot == other.plot) {
            let plot = of_plot[0].plot;
            self.shared
                .extend((next..plot).map(|plot| (NONE, plot, SharedPlot::OWN)));
            next = plot + 1;
            let sum = of_plot.iter().map(|claim| claim.likelihood).sum::<f64>();
            let owner = of_plot.iter().max_by(|one, other| {
                let confirmed = one.is_confirmed.cmp(&other.is_confirmed);
                confirmed.then(one.likelihood.total_cmp(&other.likelihood))
            });
            let owner = owner.map_or(NONE, |owner| representative(&mut self.joined, owner.cluster));
            let is_confirmed = of_plot.iter().any(|claim| claim.is_confirmed);
            let starts = match settings.starts {
                Starts::Designated => 0.0,
                Starts::Any if gating.names[plot as usize] => settings.initiation.new_target_share,
                Starts::Any => departures.new_target_share(plot, log_clutter[plot as usize], is_confirmed, settings),
            };
            let begin = self.shared.len();
            for claim in of_plot {
                let first = representative(&mut self.joined, claim.cluster);
                match self.shared[begin..].iter_mut().find(|(group, ..)| *group == first) {
                    Some((.., own)) => own.log_others += claim.likelihood,
                    None => self.shared.push((
                        first,
                        plot,
                        SharedPlot {
                            log_others: claim.likelihood,
                            may_start: first == owner,
                        },
                    )),
                }
            }
            let is_alone = self.shared.len() == begin + 1;
            for (.., shared) in &mut self.shared[begin..] {
                let others = if is_alone {
                    0.0
                } else {
                    (sum - shared.log_others).max(0.0)
                };
                let starts = if shared.may_start { 0.0 } else { starts };
                shared.log_others = (others + starts).ln_1p();
            }
        }
        self.shared
            .extend((next..log_clutter.len() as u32).map(|plot| (NONE, plot, SharedPlot::OWN)));
        self.shared.sort_unstable_by_key(|(first, plot, _)| (*first, *plot));
    }
}

/// Joins two clusters, unless both together would have more than `most` tracks or detections.
fn unite(joined: &mut [u32], sizes: &mut [(u32, u32)], (one, other): (u32, u32), most: (usize, usize)) {
    let (one, other) = (representative(joined, one), representative(joined, other));
    let ((tracks, plots), (more_tracks, more_plots)) = (sizes[one as usize], sizes[other as usize]);
    let sum = (tracks + more_tracks, plots + more_plots);
    if one == other || sum.0 as usize > most.0 || sum.1 as usize > most.1 {
        return;
    }
    let (low, high) = (one.min(other), one.max(other));
    joined[high as usize] = low;
    sizes[low as usize] = sum;
}
