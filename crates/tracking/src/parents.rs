//! The hypotheses of clusters that a scan brings together, made into those of one cluster (HT-4).
//!
//! What happens in one cluster says nothing about another, so a hypothesis of both is one of each, and its reliability
//! the product. Of all combinations the best ones are kept, cluster after cluster; what is dropped is known exactly.

use std::ops::Range;

use crate::explanation::CorrectionRecord;
use crate::log_sum::log_sum;
use crate::population::{Cluster, Hypothesis, Population};
use crate::wide_area::correction::{Gains, Rule, has_enough, lacking};

/// A hypothesis before the scan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parent {
    pub(crate) log_reliability: f64,
    /// How many tracks it lacks of those that a valid wide-area report has seen, and of those by which reliabilities are
    /// corrected in this scan.
    pub(crate) lacking: usize,
    pub(crate) lacking_due: usize,
    /// Places in the list of members.
    members: Range<u32>,
}

/// What wide-area reports ask of a cluster.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Asked {
    /// How many targets there are, if that is known.
    pub(crate) targets: Option<f64>,
    /// How the reliabilities of its hypotheses are corrected.
    pub(crate) correction: Option<Rule>,
    /// Whether those of their children are corrected, too.
    pub(crate) corrects_children: bool,
}

impl Asked {
    fn is_enough(&self, hypothesis: &Hypothesis) -> bool {
        self.targets
            .is_none_or(|targets| has_enough(hypothesis.members.len(), targets))
    }

    fn gains(&self, hypotheses: &[Hypothesis]) -> Gains {
        let rated = hypotheses
            .iter()
            .map(|hypothesis| (hypothesis.log_reliability, self.is_enough(hypothesis)));
        self.correction.map_or(Gains::NONE, |rule| Gains::of_all(rated, rule))
    }

    /// What the correction of these hypotheses comes to, if it changes them.
    pub(crate) fn explained(&self, hypotheses: &[Hypothesis]) -> Option<CorrectionRecord> {
        let gains = self.gains(hypotheses);
        let enough = hypotheses.iter().filter(|hypothesis| self.is_enough(hypothesis));
        let before: f64 = enough.map(|hypothesis| hypothesis.log_reliability.exp()).sum();
        (gains != Gains::NONE).then(|| CorrectionRecord {
            targets: self.targets.unwrap_or(f64::NAN),
            before: before.min(1.0),
            after: (before * gains.gain(true).exp()).min(1.0),
            of_children: false,
        })
    }
}

/// The hypotheses of one cluster, or of several together.
#[derive(Clone, Debug)]
pub(crate) struct Parents {
    pub(crate) list: Vec<Parent>,
    members: Vec<u32>,
    /// The same after the next cluster.
    next: (Vec<Parent>, Vec<u32>),
    /// Logarithm of a product, with the two places that it comes from.
    products: Vec<(f64, u32, u32)>,
    /// Whether a wide-area report that is due changed their reliabilities.
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

    /// Takes the hypotheses of `clusters`, at most `hypotheses_max` of all together. Returns the share of their
    /// probability that was dropped.
    pub(crate) fn gather<'a>(
        &mut self,
        population: &'a Population,
        clusters: impl Iterator<Item = (&'a Cluster, Asked)>,
        hypotheses_max: usize,
    ) -> f64 {
        self.list.clear();
        self.members.clear();
        self.corrected = false;
        self.list.push(Parent {
            log_reliability: 0.0,
            lacking: 0,
            lacking_due: 0,
            members: 0..0,
        });
        for (cluster, asked) in clusters {
            self.multiply(population, cluster, hypotheses_max, &asked);
        }
        let kept = log_sum(self.list.iter().map(|parent| parent.log_reliability));
        (1.0 - kept.exp()).max(0.0)
    }

    /// The tracks of a parent, by their places in the population.
    pub(crate) fn members(&self, parent: usize) -> &[u32] {
        let range = &self.list[parent].members;
        &self.members[range.start as usize..range.end as usize]
    }

    fn multiply(&mut self, population: &Population, cluster: &Cluster, hypotheses_max: usize, asked: &Asked) {
        let range = cluster.hypotheses.start as usize..cluster.hypotheses.end as usize;
        let hypotheses = &population.hypotheses[range];
        // WA-4, to the hypotheses themselves; their children follow once they are drawn.
        let gains = asked.gains(hypotheses);
        self.corrected |= asked.corrects_children && gains != Gains::NONE;
        self.products.clear();
        for (one, parent) in (0..).zip(&self.list) {
            for (other, hypothesis) in (0..).zip(hypotheses) {
                let corrected = hypothesis.log_reliability + gains.gain(asked.is_enough(hypothesis));
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
            let lacking = asked.targets.map_or(0, |targets| lacking(of_other.len(), targets));
            list.push(Parent {
                log_reliability,
                lacking: parent.lacking + lacking,
                lacking_due: parent.lacking_due + if asked.corrects_children { lacking } else { 0 },
                members: begin..members.len() as u32,
            });
        }
        std::mem::swap(&mut self.list, list);
        std::mem::swap(&mut self.members, members);
    }
}
