//! `best-source`: follow the source with the smallest accuracy value (TI-8 … TI-18).
//!
//! Two sensors with different points of a large target, or with a bias, give parallel but offset tracks. An average
//! makes a still target creep as the weights change. This rule does not average: at each refresh the source with the
//! smallest lambda = alpha·V gets weight 1, all others 0. Only when the best source changes may the output be blended
//! from the old to the new source, over few refreshes (`hand_over`).
//!
//! With hysteresis (TI-18) the present source is kept until another's lambda is below h times the present lambda, and
//! for a minimum number of refreshes.

use super::combination::combine;
use super::{Candidate, NO_SOURCE, RuleEntry, RuleMemory, RuleMethod, Share, Target};
use crate::settings::{ResidualKind, RuleSettings, Tie};
use crate::state::State;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::BestSource,
    summary: "the source with the smallest accuracy value lambda = alpha·V gets weight 1",
    assumption: "none: one source at a time, so correlation between sources does not matter",
    keeps_points: false,
    chooses_by_accuracy: true,
    claims_consistency: false,
    method: RuleMethod::Candidates(fuse),
};

fn fuse(settings: &RuleSettings, target: &Target<'_>, memory: &mut RuleMemory, shares: &mut [Share]) -> Option<State> {
    let (candidates, per_axis) = (target.candidates, settings.residual == ResidualKind::PerAxis);
    if candidates.iter().all(|candidate| candidate.stale) {
        return None;
    }
    for axis in 0..3 {
        memory.selected[axis] = if per_axis || axis == 0 {
            choose(settings, candidates, memory, axis)
        } else {
            memory.selected[0]
        };
        memory.hand_overs[axis].follow(&settings.hand_over, memory.selected[axis], axis, candidates, shares);
    }
    Some(combine(candidates, shares))
}

/// The source to follow on an axis.
fn choose(settings: &RuleSettings, candidates: &[Candidate], memory: &RuleMemory, axis: usize) -> u16 {
    let last = memory.selected[axis];
    let fresh = || candidates.iter().filter(|candidate| !candidate.stale);
    let keyed = || fresh().map(|candidate| ComparisonKey::new(settings, candidate, last, axis));
    let Some(best) = keyed().min_by(ComparisonKey::compare) else {
        return NO_SOURCE;
    };
    match keyed().find(|key| key.source == last) {
        Some(present) if !present.gives_way_to(&best, settings, memory.hand_overs[axis].refreshes()) => last,
        _ => best.source,
    }
}

/// Criteria by which two sources are compared, most important first (TI-10, TI-11).
struct ComparisonKey {
    lambda: f64,
    alpha: f64,
    chosen_last: bool,
    priority: u32,
    source: u16,
}

impl ComparisonKey {
    fn new(settings: &RuleSettings, candidate: &Candidate, last: u16, axis: usize) -> Self {
        let lambda = match candidate.residual {
            Some(residual) if settings.residual == ResidualKind::PerAxis => candidate.alpha * residual[axis].abs(),
            _ => candidate.lambda,
        };
        Self {
            // A source without a V loses to any source with a V, and is scored by alpha alone (TI-10).
            lambda,
            alpha: candidate.alpha,
            chosen_last: settings.tie == Tie::LastThenPriority && candidate.source == last,
            priority: candidate.priority,
            source: candidate.source,
        }
    }

    /// Whether hysteresis permits a change from this, the present source, to `best`.
    fn gives_way_to(&self, best: &Self, settings: &RuleSettings, refreshes: u32) -> bool {
        let clearly = if self.lambda.is_finite() || best.lambda.is_finite() {
            best.lambda < settings.hysteresis * self.lambda
        } else {
            best.alpha < settings.hysteresis * self.alpha
        };
        // The choice itself is the first of the refreshes.
        refreshes.saturating_add(1) >= settings.hold_refreshes && (settings.hysteresis >= 1.0 || clearly)
    }

    fn compare(&self, other: &Self) -> std::cmp::Ordering {
        self.lambda
            .total_cmp(&other.lambda)
            .then(self.alpha.total_cmp(&other.alpha))
            .then(other.chosen_last.cmp(&self.chosen_last))
            .then(self.priority.cmp(&other.priority))
            .then(self.source.cmp(&other.source))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules::{self, testing};

    fn defaults() -> RuleSettings {
        RuleSettings {
            name: crate::settings::RuleName(messages::FusionRule::BestSource),
            ..RuleSettings::default()
        }
    }

    fn candidate(source: u16, alpha: f64, residual: Option<[f64; 3]>) -> Candidate {
        let candidate = Candidate {
            source,
            priority: u32::from(source),
            alpha,
            residual,
            ..Candidate::default()
        };
        Candidate {
            lambda: candidate.lambda_over(true),
            ..candidate
        }
    }

    /// A memory with `source` chosen last.
    fn chosen(source: u16) -> RuleMemory {
        RuleMemory {
            selected: [source; 3],
            ..RuleMemory::default()
        }
    }

    fn selected(settings: &RuleSettings, candidates: &[Candidate], memory: &mut RuleMemory) -> [u16; 3] {
        let target = testing::target(candidates);
        let mut shares = vec![Share::default(); candidates.len()];
        rules::fuse(fuse, settings, &target, memory, &mut shares).expect("there is a source");
        memory.selected
    }

    #[test]
    fn the_worked_check_hands_over_at_t4() {
        // Until t3 lambda_A < lambda_B, from t4 on lambda_B < lambda_A.
        let settings = defaults();
        let mut memory = RuleMemory::default();
        let lambdas = [(1.0, 2.0), (1.0, 2.0), (1.0, 2.0), (3.0, 2.0), (3.0, 2.0)];
        let chosen: Vec<u16> = lambdas
            .iter()
            .map(|(a, b)| {
                let both = [
                    candidate(0, 1.0, Some([*a, 0.0, 0.0])),
                    candidate(1, 1.0, Some([*b, 0.0, 0.0])),
                ];
                selected(&settings, &both, &mut memory)[0]
            })
            .collect();
        assert_eq!(chosen, [0, 0, 0, 1, 1]);
    }

    #[test]
    fn alpha_makes_main_and_standby_sources() {
        let both = [
            candidate(0, 1.0, Some([4.0, 0.0, 0.0])),
            candidate(1, 10.0, Some([1.0, 0.0, 0.0])),
        ];
        assert_eq!(selected(&defaults(), &both, &mut RuleMemory::default()), [0; 3]);
    }

    #[test]
    fn a_source_without_residual_loses_and_is_scored_by_alpha_alone() {
        let settings = defaults();
        let both = [candidate(0, 1.0, None), candidate(1, 99.0, Some([50.0, 0.0, 0.0]))];
        assert_eq!(selected(&settings, &both, &mut RuleMemory::default()), [1; 3]);
        let neither = [candidate(0, 2.0, None), candidate(1, 1.0, None)];
        assert_eq!(selected(&settings, &neither, &mut RuleMemory::default()), [1; 3]);
    }

    #[test]
    fn ties_go_to_the_smaller_alpha_then_the_last_choice_then_priority() {
        let still = Some([0.0; 3]);
        let settings = defaults();
        let mut last_was_1 = chosen(1);
        let equal = [candidate(0, 1.0, still), candidate(1, 1.0, still)];
        assert_eq!(selected(&settings, &equal, &mut last_was_1), [1; 3]);
        assert_eq!(selected(&settings, &equal, &mut RuleMemory::default()), [0; 3]);
        let priority_only = RuleSettings {
            tie: Tie::Priority,
            ..defaults()
        };
        assert_eq!(selected(&priority_only, &equal, &mut last_was_1), [0; 3]);
        let smaller_alpha = [candidate(0, 1.0, still), candidate(1, 0.5, still)];
        assert_eq!(selected(&settings, &smaller_alpha, &mut chosen(0)), [1; 3]);
    }

    #[test]
    fn per_axis_each_axis_chooses_for_itself() {
        let settings = RuleSettings {
            residual: ResidualKind::PerAxis,
            name: crate::settings::RuleName(messages::FusionRule::BestSource),
            ..defaults()
        };
        let both = [
            candidate(0, 1.0, Some([1.0, 9.0, 0.0])),
            candidate(1, 1.0, Some([9.0, 1.0, 5.0])),
        ];
        assert_eq!(selected(&settings, &both, &mut RuleMemory::default()), [0, 1, 0]);
    }

    #[test]
    fn the_present_source_is_kept_until_another_is_clearly_better_and_its_time_is_up() {
        let settings = RuleSettings {
            hysteresis: 0.5,
            ..defaults()
        };
        let both = |a: f64, b: f64| {
            [
                candidate(0, 1.0, Some([a, 0.0, 0.0])),
                candidate(1, 1.0, Some([b, 0.0, 0.0])),
            ]
        };
        let mut memory = RuleMemory::default();
        assert_eq!(selected(&settings, &both(2.0, 3.0), &mut memory), [0; 3]);
        assert_eq!(
            selected(&settings, &both(4.0, 2.0), &mut memory),
            [0; 3],
            "not below half"
        );
        assert_eq!(selected(&settings, &both(4.0, 1.9), &mut memory), [1; 3]);
        let settings = RuleSettings {
            hold_refreshes: 3,
            ..defaults()
        };
        let mut memory = RuleMemory::default();
        let lambdas = [(1.0, 2.0), (2.0, 1.0), (2.0, 1.0), (2.0, 1.0), (1.0, 2.0)];
        let chosen = lambdas.map(|(a, b)| selected(&settings, &both(a, b), &mut memory)[0]);
        assert_eq!(
            chosen,
            [0, 0, 0, 1, 1],
            "three refreshes of 0, then at least three of 1"
        );
        assert_eq!(
            selected(&settings, &both(1.0, 9.0)[..1], &mut memory),
            [0; 3],
            "1 has gone"
        );
    }
}
