//! `inverse-trace`: every source has a weight by the inverse of the covariance's trace (TI-17).
//!
//! Traces are taken over east and north for all sources, so that no source wins for lack of a height.

use super::combination::combine;
use super::{RuleEntry, RuleMemory, RuleMethod, Share, Target};
use crate::settings::RuleSettings;
use crate::state::State;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::InverseTrace,
    summary: "all sources, each with a weight proportional to 1/trace of its covariance",
    assumption: "any: the covariance bounds the error whatever the correlation between sources",
    keeps_points: false,
    chooses_by_accuracy: false,
    claims_consistency: false,
    method: RuleMethod::Candidates(fuse),
};

fn fuse(_: &RuleSettings, target: &Target<'_>, _: &mut RuleMemory, shares: &mut [Share]) -> Option<State> {
    for (share, candidate) in shares.iter_mut().zip(target.candidates) {
        // If the source delivers an impossible trace, its covariance is used instead.
        let usable = candidate.usable_trace_m2();
        share.trace_unusable = usable.is_none();
        share.weight = [usable.unwrap_or_else(|| candidate.state.horizontal_trace_m2()).recip(); 3];
    }
    let total: f64 = shares.iter().map(|share| share.weight[0]).sum();
    for share in shares.iter_mut() {
        share.weight = share.weight.map(|weight| weight / total);
    }
    Some(combine(target.candidates, shares))
}

#[cfg(test)]
mod tests {
    use messages::Covariance;

    use super::*;
    use crate::rules::{Candidate, testing};

    #[test]
    fn weights_are_inverse_to_horizontal_traces() {
        let candidate = |source: u16, sigma_m: f64| Candidate {
            source,
            state: State {
                covariance: Covariance::diagonal([sigma_m, sigma_m, 1000.0], [1.0; 3]),
                ..State::default()
            },
            ..Candidate::default()
        };
        let mut candidates = [candidate(0, 10.0), candidate(1, 20.0)];
        let (_, shares) = testing::fused(&ENTRY, &candidates);
        assert!((shares[0].weight[0] - 0.8).abs() < 1e-12, "400 : 100");
        // The source's stated trace counts, unless invalid.
        candidates[1].trace_m2 = Some(200.0);
        assert!((testing::fused(&ENTRY, &candidates).1[0].weight[0] - 0.5).abs() < 1e-12);
        candidates[1].trace_m2 = Some(-3.0);
        let (_, shares) = testing::fused(&ENTRY, &candidates);
        assert!((shares[0].weight[0] - 0.8).abs() < 1e-12);
        assert!(shares[1].trace_unusable && !shares[0].trace_unusable);
    }
}
