//! Correction of the children of each hypothesis by a known number of targets (WA-4).

use super::correction::Gains;
use crate::counts::TrackerCounts;
use crate::explanation::{CorrectionRecord, Explanation, Observer};
use crate::hypothesis_store::HypothesisStore;
use crate::joined::JoinedClusters;
use crate::log_sum::log_sum;
use crate::parents::Parents;

/// Families of the children in a store, in the store's order; working memory, reused for each cluster.
#[derive(Clone, Debug)]
pub(crate) struct ChildCorrection {
    /// Parent, and whether the child has as many tracks as a wide-area report asks for.
    families: Vec<(usize, bool)>,
}

impl ChildCorrection {
    pub(crate) fn new(children_max: usize) -> Self {
        Self {
            families: Vec::with_capacity(children_max),
        }
    }

    pub(crate) fn clear(&mut self) {
        self.families.clear();
    }

    /// Learns of the child completed last.
    pub(crate) fn add(&mut self, parent: usize, is_enough: bool) {
        self.families.push((parent, is_enough));
    }

    /// Corrects the children's reliabilities, counts the correction, and records it together with the correction of the
    /// parents.
    pub(crate) fn run(
        &self,
        joined: &JoinedClusters<'_>,
        parents: &mut Parents,
        store: &mut HypothesisStore,
        counts: &mut TrackerCounts,
    ) {
        let before = joined.scan.observer.map(|_| self.share_of_enough(store));
        self.correct(joined, parents, store);
        if let (Some(observer), Some(before)) = (joined.scan.observer, before) {
            self.explain(joined, observer, store, before);
        }
        counts.wide_area_corrections += u64::from(parents.corrected);
    }

    fn correct(&self, joined: &JoinedClusters<'_>, parents: &mut Parents, store: &mut HypothesisStore) {
        let Some(rule) = joined.support.correction() else {
            return;
        };
        for parent in 0..parents.list.len() {
            if parents.list[parent].lacking_due == 0 {
                continue;
            }
            let family = || (0..).zip(&self.families).filter(|(_, (of, _))| *of == parent);
            let log_reliability = |child: usize| store.children[child].log_reliability;
            let gains = Gains::of_all(
                family().map(|(child, (_, is_enough))| (log_reliability(child), *is_enough)),
                rule,
            );
            parents.corrected |= gains != Gains::NONE;
            for (child, (_, is_enough)) in family() {
                store.children[child].log_reliability += gains.gain(*is_enough);
            }
        }
    }

    /// Share of the children's reliability held by children with as many tracks as a due wide-area report asks for.
    fn share_of_enough(&self, store: &HypothesisStore) -> f64 {
        let children = store.children.iter().map(|child| child.log_reliability);
        let enough = children.clone().zip(&self.families);
        let enough = enough.filter(|(_, (_, is_enough))| *is_enough);
        (log_sum(enough.map(|(log_reliability, _)| log_reliability)) - log_sum(children)).exp()
    }

    /// Records the correction of the clusters before the scan and of the children, with the share of children that
    /// had enough tracks before.
    fn explain(&self, joined: &JoinedClusters<'_>, observer: &dyn Observer, store: &HypothesisStore, before: f64) {
        let hypotheses = &joined.scan.before.hypotheses;
        for (place, cluster) in joined.clusters() {
            let range = cluster.hypotheses.start as usize..cluster.hypotheses.end as usize;
            if let Some(correction) = joined.support.demand(place).explained(&hypotheses[range]) {
                observer.explain(&Explanation::Correction(correction));
            }
        }
        let after = self.share_of_enough(store);
        // Written so that NaN (no children) makes no record.
        if after > before {
            observer.explain(&Explanation::Correction(CorrectionRecord {
                targets: joined.support.targets_due(),
                before,
                after,
                of_children: true,
            }));
        }
    }
}
