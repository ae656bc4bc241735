//! Update of a cluster by a scan: from the hypotheses before to the hypotheses after.
//!
//! The children of all parents are drawn together, likeliest first ([`crate::interpretations`]); tracks are made on
//! demand ([`crate::branching`]). The children are then corrected by wide-area reports and reduced, and the tracks are
//! confirmed ([`crate::hypothesis_store`]). Finally the separated clusters are written ([`crate::separation`]).

use crate::branching::{Branches, REMOVED, UNMADE, explain_end};
use crate::cluster_explanation::{explain_cluster, explain_confirmations, explain_ends, explain_hypotheses};
use crate::counts::TrackerCounts;
use crate::directions::{Claims, Directions};
use crate::explanation::TrackEvent;
use crate::gating::NONE;
use crate::hypothesis_store::HypothesisStore;
use crate::interpretations::{Interpretation, Interpretations};
use crate::joined::{DetectionRows, JoinedClusters};
use crate::limits::{CLUSTER_TRACKS_MAX, HYPOTHESES_MAX, PAIRS_MAX};
use crate::parents::Parents;
use crate::plot::SharedPlot;
use crate::population::{Cluster, Population};
use crate::ranked::ROWS_MAX;
use crate::scan_context::ScanContext;
use crate::separation::Separation;
use crate::splitting::{DetectionCounts, SplitLimits};
use crate::unresolved::SHARED;
use crate::wide_area::children::ChildCorrection;

/// Most children drawn for each that may be kept: some break the limits of SP-3 and SP-5.
const DRAWN_PER_KEPT: usize = 8;
/// Maximum of children before the reduction: doubled because children with enough tracks are drawn separately.
const CHILDREN_MAX: usize = 2 * HYPOTHESES_MAX;

/// Working memory, reused for each cluster.
#[derive(Clone, Debug)]
pub(crate) struct ClusterUpdate {
    rows: DetectionRows,
    children: ChildHypotheses,
    separation: Separation,
}

/// The children of a cluster's hypotheses.
#[derive(Clone, Debug)]
struct ChildHypotheses {
    parents: Parents,
    interpretations: Interpretations,
    branches: Branches,
    store: HypothesisStore,
    correction: ChildCorrection,
    /// By track: the pair that the present child takes, or [`NONE`].
    taken: Vec<u32>,
}

impl ClusterUpdate {
    pub(crate) fn new(tracks_max: usize, plots_max: usize) -> Self {
        let stored_tracks = CLUSTER_TRACKS_MAX * (PAIRS_MAX + 1) + ROWS_MAX;
        let members = CHILDREN_MAX * (CLUSTER_TRACKS_MAX + ROWS_MAX);
        Self {
            rows: DetectionRows::new(CLUSTER_TRACKS_MAX, plots_max),
            children: ChildHypotheses {
                parents: Parents::new(HYPOTHESES_MAX, CLUSTER_TRACKS_MAX),
                interpretations: Interpretations::new(),
                branches: Branches::new(tracks_max),
                store: HypothesisStore::new(stored_tracks, CHILDREN_MAX, members),
                correction: ChildCorrection::new(CHILDREN_MAX),
                taken: vec![NONE; tracks_max],
            },
            separation: Separation::new(stored_tracks),
        }
    }

    /// Updates the clusters that the scan has joined, and writes the resulting clusters to `next`.
    pub(crate) fn run(
        &mut self,
        scan: &ScanContext<'_>,
        clusters: &[(u32, u32)],
        plots: (&[(u32, u32)], &[SharedPlot]),
        next: &mut Population,
        counts: &mut TrackerCounts,
    ) {
        let before = *counts;
        let joined = JoinedClusters::of(scan, clusters, plots, &mut self.rows, counts);
        let mut dropped = self.children.make(&joined, next, counts);
        let (reduction, store) = (&scan.settings.reduction, &mut self.children.store);
        dropped += store.reduce(reduction, counts);
        counts.drop_probability(dropped);
        let first_number = next.next_number;
        let confirmation = &scan.settings.confirmation;
        store.confirm_trees(confirmation, &scan.settings.splitting, &mut next.next_number, counts);
        let first_early = next.next_number;
        let taken_over = |track: &_, value, limit| scan.explain(TrackEvent::ConfirmedEarly, track, value, limit);
        let (scans, next_number) = (reduction.merge_scans, &mut next.next_number);
        joined.support.confirm(store, scans, next_number, counts, taken_over);
        if let Some(observer) = scan.observer {
            explain_confirmations(&joined, store, [first_number, first_early]);
            explain_ends(&joined, store);
            explain_cluster(&joined, observer, [&before, counts], dropped);
            explain_hypotheses(&joined, observer, store);
        }
        self.separation
            .write(store, next, reduction, &joined.detections, counts);
    }

    /// Updates the tracks of a cluster by the directions in the gates ([`crate::directions`]); the hypotheses stay, but
    /// for the tracks that have been silent for too long.
    pub(crate) fn run_directions(
        &mut self,
        scan: &ScanContext<'_>,
        cluster: &Cluster,
        claims: &[Claims],
        next: &mut Population,
        counts: &mut TrackerCounts,
    ) {
        let directions = Directions::of(scan);
        let ChildHypotheses { branches, store, .. } = &mut self.children;
        store.clear();
        for number in cluster.tracks.clone() {
            let mut track = scan.before.tracks[number as usize];
            directions.take_in(&mut track, claims, &scan.survival);
            let deletion = scan.settings.deletion.of(&track, &scan.settings.identity);
            let is_gone = deletion.is_met(&track, scan.time_ns);
            if is_gone {
                explain_end(scan, &track, &deletion, TrackEvent::ENDS);
            }
            branches.keep_directed(number, (!is_gone).then_some(track), store);
        }
        for hypothesis in &scan.before.hypotheses[cluster.hypotheses.start as usize..cluster.hypotheses.end as usize] {
            for member in scan.before.members_of(hypothesis) {
                add_member(store, branches.directed(*member), counts);
            }
            store.finish_child(hypothesis.log_reliability);
        }
        let detections = DetectionCounts {
            detections: cluster.detections,
            scans: cluster.scans,
        };
        self.separation
            .write(store, next, &scan.settings.reduction, &detections, counts);
    }
}

impl ChildHypotheses {
    /// Makes the likeliest children, with corrected reliabilities. Returns a bound on the share of the probability that
    /// was left behind.
    fn make(&mut self, joined: &JoinedClusters<'_>, next: &mut Population, counts: &mut TrackerCounts) -> f64 {
        self.store.clear();
        self.correction.clear();
        self.branches.clear(joined);
        let hypotheses_max = joined.scan.settings.reduction.hypotheses_max;
        let dropped = self.parents.gather(joined, hypotheses_max);
        self.interpretations.pose(joined, &self.parents, counts);
        let left = self.draw(joined, next, counts);
        self.correction.run(joined, &mut self.parents, &mut self.store, counts);
        dropped + left
    }

    /// Draws children, likeliest first, until there are enough or the rest cannot matter. Returns a bound on the share
    /// of the probability that was left behind.
    fn draw(&mut self, joined: &JoinedClusters<'_>, next: &mut Population, counts: &mut TrackerCounts) -> f64 {
        let reduction = &joined.scan.settings.reduction;
        let Some(best) = self.interpretations.next_cost() else {
            return 0.0;
        };
        let is_apart = self.interpretations.are_apart();
        let children_max = if is_apart { 2 } else { 1 } * reduction.hypotheses_max;
        let (mut drawn, mut taken, mut fallback) = (0, 0.0, None);
        while let Some(cost) = self.interpretations.next_cost() {
            let enough = self.store.children.len() >= children_max;
            // The share of this child in the sum with the best child is below the minimum.
            let unreliable = (best - cost).exp() < reduction.reliability_min;
            if enough || unreliable || drawn >= DRAWN_PER_KEPT * children_max {
                break;
            }
            let Some(interpretation) = self.interpretations.next(&self.parents) else {
                break;
            };
            drawn += 1;
            let Some(interpretation) = interpretation else { continue };
            taken += (best - cost).exp();
            if !self.make_child(joined, &interpretation, joined.limits, next, counts) {
                // Something must stay even if every child breaks the limits: the likeliest.
                fallback = fallback.or(Some(interpretation));
            }
        }
        counts.hypotheses_drawn += drawn as u64;
        if let Some(interpretation) = fallback.filter(|_| self.store.children.is_empty()) {
            self.make_child(joined, &interpretation, SplitLimits::NONE, next, counts);
        }
        let left = (self.interpretations.log_left() + best).exp();
        left / (left + taken)
    }

    /// `false` if the child breaks the limits or finds no room.
    fn make_child(
        &mut self,
        joined: &JoinedClusters<'_>,
        interpretation: &Interpretation,
        limits: SplitLimits,
        next: &mut Population,
        counts: &mut TrackerCounts,
    ) -> bool {
        let (interpretations, store) = (&self.interpretations, &mut self.store);
        if interpretations.new_rows(interpretation).count() > limits.new_tracks_max {
            counts.too_many_new_tracks += 1;
            return false;
        }
        for pair in interpretations.pairs(interpretation) {
            if pair & SHARED == 0 {
                let track = joined.scan.gating.pairs[pair as usize].track;
                self.taken[track as usize] = pair;
            } else {
                for track in joined.scan.unresolved.tracks_of(pair) {
                    self.taken[track as usize] = pair;
                }
            }
        }
        let mut room = true;
        for &track in self.parents.members(interpretation.parent) {
            let pair = std::mem::replace(&mut self.taken[track as usize], NONE);
            let place = self.branches.continued(joined, track, pair, store, counts);
            room &= add_member(store, place, counts);
        }
        for row in interpretations.new_rows(interpretation) {
            let place = self.branches.begun(joined, row, store, next, counts);
            room &= add_member(store, place, counts);
        }
        if limits.forbids(store.tentative_members()) {
            counts.too_many_tentative_tracks += 1;
            store.drop_child();
            return false;
        }
        if !room {
            store.drop_child();
            counts.hypotheses_dropped += 1;
            return false;
        }
        let finished = store.finish_child(interpretation.log_reliability);
        if finished {
            let is_enough = interpretation.is_enough.unwrap_or(true);
            self.correction.add(interpretation.parent, is_enough);
        }
        finished
    }
}

/// `false` if there is no room.
fn add_member(store: &mut HypothesisStore, place: u32, counts: &mut TrackerCounts) -> bool {
    match place {
        REMOVED => true,
        UNMADE => {
            counts.dropped_tracks += 1;
            false
        }
        place => store.add_member(place),
    }
}
