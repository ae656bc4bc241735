//! Properties of every rule on candidates; tests of the engine cover the other rules.

use estimation::{is_positive_definite, unpacked};
use messages::{CONTRIBUTIONS_MAX, Covariance};
use proptest::prelude::*;

use super::testing::{fused_of, target};
use super::*;
use crate::settings::{DropOut, HandOverSettings, ResidualKind};
use test_support::S;

/// The rules on candidates.
fn of_candidates() -> impl Iterator<Item = &'static RuleEntry> {
    REGISTRY.iter().filter(|rule| !rule.is_from_filter())
}

/// A position and velocity within sensor range, with a correlated covariance.
fn state() -> impl Strategy<Value = State> {
    (
        prop::array::uniform3(-3e4..3e4f64),
        prop::array::uniform3(-300.0..300.0f64),
        prop::array::uniform3(2.0..200.0f64),
        prop::array::uniform3(0.5..20.0f64),
        prop::array::uniform3(-0.7..0.7f64),
        any::<bool>(),
    )
        .prop_map(
            |(position_m, velocity_mps, sigma_m, sigma_mps, correlation, has_height)| {
                let mut covariance = Covariance::diagonal(sigma_m, sigma_mps);
                covariance.set(0, 1, 0.5 * correlation[0] * sigma_m[0] * sigma_m[1]);
                for axis in 0..3 {
                    covariance.set(
                        axis,
                        axis + 3,
                        0.5 * correlation[axis] * sigma_m[axis] * sigma_mps[axis],
                    );
                }
                State {
                    time_ns: 0,
                    position_m,
                    velocity_mps,
                    covariance,
                    has_height,
                }
            },
        )
}

fn candidates() -> impl Strategy<Value = Vec<Candidate>> {
    let residual = prop::option::weighted(0.8, prop::array::uniform3(0.0..200.0f64));
    let trace = prop::option::weighted(0.5, -1.0..1e4f64);
    let one = (0.0..100.0f64, residual, 0u32..3, trace, 1u32..11, 1i64..13, state());
    prop::collection::vec(one, 1..CONTRIBUTIONS_MAX).prop_map(|parts| {
        let number = |(source, (alpha, residual, priority, trace_m2, quality, period_s, state))| {
            let candidate = Candidate {
                source: source as u16,
                priority,
                alpha,
                residual,
                trace_m2,
                quality,
                period_ns: period_s * S,
                state,
                ..Candidate::default()
            };
            Candidate {
                lambda: candidate.lambda_over(true),
                ..candidate
            }
        };
        parts.into_iter().enumerate().map(number).collect()
    })
}

/// Whether two states are the same up to rounding, in units of the first's standard deviations.
fn close(a: &State, b: &State) -> bool {
    let sigma = |axis: usize| a.covariance.get(axis, axis).sqrt();
    let near = |a: f64, b: f64, sigma: f64| (a - b).abs() <= 1e-5 * (sigma + 1.0);
    (0..3).all(|axis| {
        near(a.position_m[axis], b.position_m[axis], sigma(axis))
            && near(a.velocity_mps[axis], b.velocity_mps[axis], sigma(axis + 3))
    }) && (0..6).all(|k| (a.covariance.get(k, k) / b.covariance.get(k, k) - 1.0).abs() < 1e-5)
}

proptest! {
    #[test]
    fn weights_lie_between_0_and_1_and_sum_to_1(candidates in candidates()) {
        for rule in of_candidates() {
            let (state, shares) = fused_of(rule, &candidates);
            prop_assert!(state.is_some(), "{}", rule.name());
            for axis in 0..3 {
                let sum: f64 = shares.iter().map(|share| share.weight[axis]).sum();
                prop_assert!((sum - 1.0).abs() < 1e-9, "{}: {sum}", rule.name());
                prop_assert!(shares.iter().all(|share| (0.0..=1.0).contains(&share.weight[axis])), "{}", rule.name());
            }
        }
    }

    #[test]
    fn the_order_of_the_sources_does_not_matter(candidates in candidates()) {
        for rule in of_candidates() {
            let (there, forwards) = fused_of(rule, &candidates);
            let reversed: Vec<_> = candidates.iter().rev().copied().collect();
            let (back, mut backwards) = fused_of(rule, &reversed);
            backwards.reverse();
            prop_assert!(close(&there.unwrap(), &back.unwrap()), "{}: {there:?} {back:?}", rule.name());
            for (a, b) in forwards.iter().zip(&backwards) {
                prop_assert!((0..3).all(|axis| (a.weight[axis] - b.weight[axis]).abs() < 1e-6), "{}", rule.name());
                prop_assert_eq!(a.accuracy, b.accuracy);
            }
        }
    }

    #[test]
    fn a_single_source_passes_through(candidates in candidates()) {
        for rule in of_candidates() {
            let (state, shares) = fused_of(rule, &candidates[..1]);
            prop_assert_eq!(shares[0].weight, [1.0; 3], "{}", rule.name());
            prop_assert_eq!(state, Some(candidates[0].state), "{}", rule.name());
        }
    }

    #[test]
    fn covariances_stay_positive_definite(candidates in candidates()) {
        for rule in of_candidates() {
            let state = fused_of(rule, &candidates).0.unwrap();
            prop_assert!(is_positive_definite(&unpacked(&state.covariance)), "{}: {state:?}", rule.name());
            let known = candidates.iter().any(|candidate| candidate.state.has_height);
            prop_assert_eq!(state.has_height, known, "{}", rule.name());
        }
    }

    #[test]
    fn a_covariance_that_cannot_be_does_no_harm(candidates in candidates(), factor in 1.1..5.0f64, at in 0usize..15) {
        let mut candidates = candidates;
        let index = at % candidates.len();
        let p = &mut candidates[index].state.covariance;
        p.set(0, 1, factor * (p.get(0, 0) * p.get(1, 1)).sqrt());
        for rule in of_candidates() {
            let state = fused_of(rule, &candidates).0.unwrap();
            let numbers = state.position_m.iter().chain(&state.velocity_mps).chain(&state.covariance.upper);
            prop_assert!(numbers.into_iter().all(|number| number.is_finite()), "{}", rule.name());
        }
    }

    /// Of two equal sources, neither is preferred without reason, and the state is that of both.
    #[test]
    fn two_equal_sources_say_together_what_each_says(candidates in candidates()) {
        let twin = Candidate {
            source: candidates[0].source + 1,
            ..candidates[0]
        };
        for rule in of_candidates() {
            let (state, shares) = fused_of(rule, &[candidates[0], twin]);
            let state = state.unwrap();
            let alone = candidates[0].state;
            for axis in 0..3 {
                prop_assert!((state.position_m[axis] - alone.position_m[axis]).abs() < 1e-6, "{}", rule.name());
                prop_assert!((state.velocity_mps[axis] - alone.velocity_mps[axis]).abs() < 1e-6, "{}", rule.name());
            }
            let ratio = state.covariance.get(0, 0) / alone.covariance.get(0, 0);
            let (share, expected) = match rule.name() {
                "best-source" | "mosaic" => (1.0, 1.0..=1.0),
                "information" => (0.5, 0.5..=0.5),
                "bar-shalom-campo" => (0.5, 0.5..=1.0),
                _ => (0.5, 1.0..=1.0),
            };
            prop_assert!((shares[0].weight[0] - share).abs() < 1e-6, "{}: {shares:?}", rule.name());
            prop_assert!(*expected.start() - 1e-6 <= ratio && ratio <= *expected.end() + 1e-6, "{}: {ratio}", rule.name());
        }
    }

    /// With a ramp, no change of source at any time moves the output by more than the ramp's largest step.
    #[test]
    fn a_ramp_bounds_every_step_of_a_hand_over(
        states in prop::array::uniform3(state()),
        residuals in prop::collection::vec(prop::array::uniform3(prop::array::uniform3(0.1..9.0f64)), 2..40),
        per_axis in any::<bool>(),
    ) {
        let settings = RuleSettings {
            residual: if per_axis { ResidualKind::PerAxis } else { ResidualKind::Position },
            hand_over: HandOverSettings {
                ramp: vec![0.25, 0.5, 0.75],
                drop_out: DropOut::Blend,
                ..HandOverSettings::default()
            },
            ..RuleSettings::default()
        };
        let RuleMethod::Candidates(rule) = entry(messages::FusionRule::BestSource).method else {
            unreachable!("it takes its states from nowhere else");
        };
        let mut memory = RuleMemory::default();
        let mut last: Option<State> = None;
        let spread = |axis: usize| {
            let places = states.map(|state| state.position_m[axis]);
            places.iter().fold(f64::MIN, |a, b| a.max(*b)) - places.iter().fold(f64::MAX, |a, b| a.min(*b))
        };
        for residual in residuals {
            let mut candidates = [0, 1, 2].map(|index: usize| Candidate {
                source: index as u16,
                alpha: 1.0,
                residual: Some(residual[index]),
                state: State { has_height: true, ..states[index] },
                ..Candidate::default()
            });
            for candidate in &mut candidates {
                candidate.lambda = candidate.lambda_over(true);
            }
            let mut shares = [Share::default(); 3];
            let state = fuse(rule, &settings, &target(&candidates), &mut memory, &mut shares).unwrap();
            for axis in 0..3 {
                let sum: f64 = shares.iter().map(|share| share.weight[axis]).sum();
                prop_assert!((sum - 1.0).abs() < 1e-9);
                if let Some(last) = last {
                    let step = (state.position_m[axis] - last.position_m[axis]).abs();
                    prop_assert!(step <= 0.25 * spread(axis) + 1e-6, "{step} of {}", spread(axis));
                }
            }
            last = Some(state);
        }
    }
}

#[test]
fn every_code_has_one_rule_and_every_rule_says_what_it_assumes() {
    for rule in REGISTRY {
        assert!(std::ptr::eq(entry(rule.code), rule));
        assert!(!rule.summary.is_empty() && !rule.assumption.is_empty());
    }
    assert_eq!(REGISTRY.len(), messages::FusionRule::ALL.len(), "a code without a rule");
}
