//! `covariance-intersection`: valid under any correlation, with a larger covariance (BF-1).
//!
//! The weights on the inverse covariances sum to 1 and are chosen for all sources together, so that trace or
//! determinant of the combined covariance is smallest (see `estimation`). The combination is never surer of a target
//! than that, however many sources agree: equal sources gain nothing from each other.

use estimation::{Criterion, Estimate, INPUTS_MAX, intersection_weights, weighted_information};

use super::matrices::{self, Combination};
use super::{RuleEntry, RuleMemory, RuleMethod, Share, Target};
use crate::settings::{Intersection, RuleSettings};
use crate::state::State;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::CovarianceIntersection,
    summary: "all sources, weighed so that the covariance holds whatever their correlation and is as small as that allows",
    assumption: "any: the covariance bounds the error whatever the correlation between sources",
    keeps_points: false,
    chooses_by_accuracy: false,
    claims_consistency: false,
    method: RuleMethod::Candidates(fuse),
};

impl Combination for Intersection {
    fn combine<const D: usize>(&self, inputs: &[Estimate<D>], shares: &mut [f64]) -> Option<Estimate<D>> {
        let criterion = match self {
            Self::Determinant => Criterion::Determinant,
            Self::Trace => Criterion::Trace { components: D / 2 },
        };
        let mut weights = [0.0; INPUTS_MAX];
        intersection_weights(inputs, criterion, &mut weights[..inputs.len()])?;
        weighted_information(inputs, &weights[..inputs.len()], shares)
    }
}

fn fuse(settings: &RuleSettings, target: &Target<'_>, _: &mut RuleMemory, shares: &mut [Share]) -> Option<State> {
    matrices::fuse(target.candidates, &settings.intersection, shares)
}

#[cfg(test)]
mod tests {
    use messages::Covariance;

    use super::*;
    use crate::rules::{self, Candidate, testing};

    #[test]
    fn trace_and_determinant_want_different_weights() {
        let candidate = |source: u16, sigma_m: [f64; 2]| Candidate {
            source,
            state: State {
                covariance: Covariance::diagonal([sigma_m[0], sigma_m[1], 1.0], [1.0; 3]),
                ..State::default()
            },
            ..Candidate::default()
        };
        let candidates = [candidate(0, [10.0, 10.0]), candidate(1, [2.0, 40.0])];
        let trace_m2 = |intersection| {
            let settings = RuleSettings {
                name: crate::settings::RuleName(ENTRY.code),
                intersection,
                ..RuleSettings::default()
            };
            let mut shares = [Share::default(); 2];
            let target = testing::target(&candidates);
            let state = rules::fuse(fuse, &settings, &target, &mut RuleMemory::default(), &mut shares).unwrap();
            state.horizontal_trace_m2()
        };
        let (by_trace, by_determinant) = (trace_m2(Intersection::Trace), trace_m2(Intersection::Determinant));
        assert!(by_trace < by_determinant - 1.0, "{by_trace} {by_determinant}");
        assert!(by_trace < 200.0);
    }
}
