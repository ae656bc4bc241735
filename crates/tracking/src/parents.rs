//! Joins the hypotheses of the clusters in a scan into the hypotheses of a single cluster (HT-4).
//!
//! Clusters are independent: a hypothesis of the joined cluster combines a hypothesis of each cluster, and the
//! reliability is the product. Cluster after cluster, the best combinations are kept; the dropped probability is known
//! exactly. Hypotheses of two clusters that have given the same detection to a track each ([`crate::coupling`]) exclude
//! each other.

use std::ops::Range;

use crate::joined::JoinedClusters;
use crate::limits::HISTORY_MAX;
use crate::log_sum::log_sum;
use crate::population::{Cluster, Hypothesis, Population};
use crate::track::NO_DETECTION;
use crate::wide_area::support::Demand;

/// Most pairs of tracks with a common detection that are considered.
const CONFLICTS_MAX: usize = 4096;

/// A hypothesis before the scan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parent {
    pub(crate) log_reliability: f64,
    /// Number of missing tracks: against the targets in valid wide-area reports, and against the targets of this
    /// scan's correction.
    pub(crate) lacking: usize,
    pub(crate) lacking_due: usize,
    /// Places in the list of members.
    members: Range<u32>,
}

/// The hypotheses of a cluster, or of several together.
#[derive(Clone, Debug)]
pub(crate) struct Parents {
    pub(crate) list: Vec<Parent>,
    members: Vec<u32>,
    /// The same after the next cluster.
    next: (Vec<Parent>, Vec<u32>),
    /// Logarithm of a product, and the indices of the two factors.
    products: Vec<(f64, u32, u32)>,
    /// (detection, cluster, track) of the joined clusters' memories.
    taken: Vec<(u32, u32, u32)>,
    /// Tracks of different clusters with a common detection, sorted.
    conflicts: Vec<(u32, u32)>,
    /// Set if a due wide-area report changed the reliabilities.
    pub(crate) corrected: bool,
}

impl Parents {
    pub(crate) fn new(hypotheses_max: usize, tracks_max: usize) -> Self {
        let lists = || {
            (
                Vec::with_capacity(hypotheses_max),
                Vec::with_capacity(hypotheses_max * tracks_max),
            )
        };
        let (list, members) = lists();
        Self {
            list,
            members,
            next: lists(),
            products: Vec::with_capacity(hypotheses_max * hypotheses_max),
            taken: Vec::with_capacity(tracks_max * HISTORY_MAX),
            conflicts: Vec::with_capacity(CONFLICTS_MAX),
            corrected: false,
        }
    }

    /// Takes the hypotheses of joined clusters, at most `hypotheses_max` of all together. Returns the dropped share of
    /// the probability.
    pub(crate) fn gather(&mut self, joined: &JoinedClusters<'_>, hypotheses_max: usize) -> f64 {
        self.list.clear();
        self.members.clear();
        self.corrected = false;
        self.list.push(Parent {
            log_reliability: 0.0,
            lacking: 0,
            lacking_due: 0,
            members: 0..0,
        });
        self.find_conflicts(joined);
        for (place, cluster) in joined.clusters() {
            let demand = joined.support.demand(place);
            self.multiply(joined.scan.before, cluster, hypotheses_max, &demand);
        }
        let kept = log_sum(self.list.iter().map(|parent| parent.log_reliability));
        (1.0 - kept.exp()).max(0.0)
    }

    /// The tracks of a parent, by places in the population.
    pub(crate) fn members(&self, parent: usize) -> &[u32] {
        let range = &self.list[parent].members;
        &self.members[range.start as usize..range.end as usize]
    }

    /// Finds the tracks of different clusters that have taken the same detection ([`crate::coupling`]).
    fn find_conflicts(&mut self, joined: &JoinedClusters<'_>) {
        self.taken.clear();
        self.conflicts.clear();
        if joined.clusters().nth(1).is_none() {
            return;
        }
        for (place, cluster) in joined.clusters() {
            for track in cluster.tracks.clone() {
                let memory = joined.scan.before.tracks[track as usize].history.iter();
                let detections = memory.filter(|serial| **serial != NO_DETECTION);
                self.taken.extend(detections.map(|serial| (*serial, place, track)));
            }
        }
        self.taken.sort_unstable();
        for of_detection in self.taken.chunk_by(|one, other| one.0 == other.0) {
            for (number, &(_, place, track)) in of_detection.iter().enumerate() {
                let others = of_detection[number + 1..].iter().filter(|other| other.1 != place);
                let room = self.conflicts.capacity() - self.conflicts.len();
                let both = others.map(|other| (track.min(other.2), track.max(other.2)));
                self.conflicts.extend(both.take(room));
            }
        }
        self.conflicts.sort_unstable();
        self.conflicts.dedup();
    }

    /// Leaves out the products with a detection in two tracks, unless all products have such a detection; the others
    /// sum to 1.
    fn leave_out_conflicts(&mut self, population: &Population, hypotheses: &[Hypothesis]) {
        if self.conflicts.is_empty() {
            return;
        }
        let (list, members, conflicts) = (&self.list, &self.members, &self.conflicts);
        let is_possible = |&(_, one, other): &(f64, u32, u32)| {
            let Range { start, end } = list[one as usize].members;
            let of_other = population.members_of(&hypotheses[other as usize]);
            let mut firsts = members[start as usize..end as usize].iter();
            !firsts.any(|one| {
                let conflict = |other: &u32| conflicts.binary_search(&(*one.min(other), *one.max(other))).is_ok();
                of_other.iter().any(conflict)
            })
        };
        let all = log_sum(self.products.iter().map(|product| product.0));
        let possible = log_sum(
            self.products
                .iter()
                .filter(|product| is_possible(product))
                .map(|product| product.0),
        );
        if possible > f64::NEG_INFINITY {
            self.products.retain(is_possible);
            self.products.iter_mut().for_each(|product| product.0 += all - possible);
        }
    }

    fn multiply(&mut self, population: &Population, cluster: &Cluster, hypotheses_max: usize, demand: &Demand) {
        let range = cluster.hypotheses.start as usize..cluster.hypotheses.end as usize;
        let hypotheses = &population.hypotheses[range];
        // WA-4 for the hypotheses themselves; the children follow when drawn.
        let gains = demand.gains(hypotheses);
        self.corrected |= demand.corrects_children && !gains.are_none();
        self.products.clear();
        for (one, parent) in (0..).zip(&self.list) {
            for (other, hypothesis) in (0..).zip(hypotheses) {
                let corrected = hypothesis.log_reliability + gains.gain(demand.is_enough(hypothesis));
                let product = parent.log_reliability + corrected;
                self.products.push((product, one, other));
            }
        }
        self.leave_out_conflicts(population, hypotheses);
        self.products
            .sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        self.products.truncate(hypotheses_max);
        let (list, members) = &mut self.next;
        list.clear();
        members.clear();
        for &(log_reliability, one, other) in &self.products {
            let begin = members.len() as u32;
            let parent = &self.list[one as usize];
            members.extend_from_slice(&self.members[parent.members.start as usize..parent.members.end as usize]);
            let of_other = population.members_of(&hypotheses[other as usize]);
            members.extend_from_slice(of_other);
            let lacking = demand.lacking(of_other.len());
            list.push(Parent {
                log_reliability,
                lacking: parent.lacking + lacking,
                lacking_due: parent.lacking_due + if demand.corrects_children { lacking } else { 0 },
                members: begin..members.len() as u32,
            });
        }
        std::mem::swap(&mut self.list, list);
        std::mem::swap(&mut self.members, members);
    }
}
