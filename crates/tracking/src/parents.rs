//! Joins the hypotheses of the clusters in a scan into the hypotheses of one cluster (HT-4).
//!
//! Clusters are independent: a hypothesis of the joined cluster combines a hypothesis of each, and its reliability
//! is their product. Cluster after cluster, the best combinations are kept; the dropped probability is known
//! exactly.

use std::ops::Range;

use crate::joined::JoinedClusters;
use crate::log_sum::log_sum;
use crate::population::{Cluster, Population};
use crate::wide_area::support::Demand;

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

/// The hypotheses of one cluster, or of several together.
#[derive(Clone, Debug)]
pub(crate) struct Parents {
    pub(crate) list: Vec<Parent>,
    members: Vec<u32>,
    /// The same after the next cluster.
    next: (Vec<Parent>, Vec<u32>),
    /// Logarithm of a product, and the indices of its two factors.
    products: Vec<(f64, u32, u32)>,
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
            corrected: false,
        }
    }

    /// Takes the hypotheses of joined clusters, at most `hypotheses_max` of all together. Returns the share of their
    /// probability that was dropped.
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
        for (place, cluster) in joined.clusters() {
            let demand = joined.support.demand(place);
            self.multiply(joined.scan.before, cluster, hypotheses_max, &demand);
        }
        let kept = log_sum(self.list.iter().map(|parent| parent.log_reliability));
        (1.0 - kept.exp()).max(0.0)
    }

    /// The tracks of a parent, by their places in the population.
    pub(crate) fn members(&self, parent: usize) -> &[u32] {
        let range = &self.list[parent].members;
        &self.members[range.start as usize..range.end as usize]
    }

    fn multiply(&mut self, population: &Population, cluster: &Cluster, hypotheses_max: usize, demand: &Demand) {
        let range = cluster.hypotheses.start as usize..cluster.hypotheses.end as usize;
        let hypotheses = &population.hypotheses[range];
        // WA-4 for the hypotheses themselves; their children follow after they are drawn.
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
