//! `information`: inverse covariances add up (BF-1).
//!
//! The best combination of sources with independent errors; too sure if the target's manoeuvres, or a common
//! reference, correlate the errors.

use estimation::{Estimate, information_sum};

use super::matrices::{self, Combination};
use super::{RuleEntry, RuleMemory, RuleMethod, Share, Target};
use crate::settings::RuleSettings;
use crate::state::State;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::Information,
    summary: "all sources, weighed by their inverse covariances",
    assumption: "errors of different sources are independent; where they are not, the covariance is too small",
    keeps_points: false,
    chooses_by_accuracy: false,
    claims_consistency: false,
    method: RuleMethod::Candidates(fuse),
};

struct Sum;

impl Combination for Sum {
    fn combine<const D: usize>(&self, inputs: &[Estimate<D>], shares: &mut [f64]) -> Option<Estimate<D>> {
        information_sum(inputs, shares)
    }
}

fn fuse(_: &RuleSettings, target: &Target<'_>, _: &mut RuleMemory, shares: &mut [Share]) -> Option<State> {
    matrices::fuse(target.candidates, &Sum, shares)
}

#[cfg(test)]
mod tests {
    use messages::Covariance;

    use super::*;
    use crate::rules::{Candidate, testing};

    fn candidate(source: u16, x: f64, sigma_m: f64, has_height: bool) -> Candidate {
        Candidate {
            source,
            state: State {
                position_m: [x, x, 10.0 * x],
                covariance: Covariance::diagonal([sigma_m, sigma_m, 20.0], [1.0; 3]),
                has_height,
                ..State::default()
            },
            ..Candidate::default()
        }
    }

    #[test]
    fn variances_add_up_inversely() {
        let (state, shares) = testing::fused(&ENTRY, &[candidate(0, 0.0, 10.0, true), candidate(1, 50.0, 20.0, true)]);
        let state = state.unwrap();
        assert!((state.position_m[0] - 10.0).abs() < 1e-9, "4 : 1");
        assert!((state.covariance.get(0, 0) - 80.0).abs() < 1e-9);
        assert!((state.covariance.get(2, 2) - 200.0).abs() < 1e-9, "equal heights");
        // Positions 4 : 1, velocities 1 : 1.
        assert!((shares[0].weight[0] - 0.65).abs() < 1e-9, "{shares:?}");
        assert!((shares[0].weight[2] - 0.5).abs() < 1e-9);
    }

    #[test]
    fn height_comes_from_those_that_observe_it_and_costs_the_others_nothing() {
        let (state, shares) = testing::fused(
            &ENTRY,
            &[candidate(0, 0.0, 10.0, false), candidate(1, 50.0, 10.0, true)],
        );
        let state = state.unwrap();
        assert!((state.position_m[0] - 25.0).abs() < 1e-9);
        assert!((state.position_m[2] - 500.0).abs() < 1e-9 && state.has_height);
        assert!((state.covariance.get(2, 2) - 400.0).abs() < 1e-9);
        assert!((shares[0].weight[0] - 0.5).abs() < 1e-9 && shares[0].weight[2] == 0.0);
        let (state, _) = testing::fused(
            &ENTRY,
            &[candidate(0, 0.0, 10.0, false), candidate(1, 50.0, 10.0, false)],
        );
        assert!(!state.unwrap().has_height);
    }

    #[test]
    fn an_impossible_covariance_is_repaired_and_told() {
        let mut bad = candidate(1, 50.0, 10.0, true);
        bad.state.covariance.set(0, 1, 150.0);
        let (state, shares) = testing::fused(&ENTRY, &[candidate(0, 0.0, 10.0, true), bad]);
        let state = state.unwrap();
        assert_eq!(shares.map(|share| share.repaired), [false, true]);
        assert!(state.covariance.get(0, 0) > 0.0 && (0.0..=50.0).contains(&state.position_m[0]));
    }
}
