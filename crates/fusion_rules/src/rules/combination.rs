//! Weighted mean, common to rules with weights on whole states.

use messages::{AXES, CONTRIBUTIONS_MAX};

use super::{Candidate, Share};
use crate::state::State;

/// Returns Σ eta·state over the candidates' states at a common time (TI-19). `shares` has an entry per candidate.
///
/// Height comes from the states with height, with weights scaled to sum to 1; if none of these states has weight, from
/// the state with the smallest accuracy value.
///
/// The covariance is the same weighted sum: by convexity, the covariance of Σ eta·e is at most Σ eta·P whatever the
/// correlation of the errors e. Axes with different weights are different mixtures of sources; between those the
/// covariance is unknown, and set to 0.
pub(crate) fn combine(candidates: &[Candidate], shares: &[Share]) -> State {
    let states = || candidates.iter().map(|candidate| &candidate.state);
    let weights = weights_per_axis(candidates, shares);
    let weights = &weights[..candidates.len()];
    let together = |a: usize, b: usize| weights.iter().all(|weight| weight[a] == weight[b]);
    let has_height = states().any(|state| state.has_height);
    let mut fused = State {
        time_ns: candidates[0].state.time_ns,
        has_height,
        ..State::default()
    };
    for (state, weight) in states().zip(weights) {
        for (axis, weight) in weight.iter().enumerate() {
            fused.position_m[axis] += weight * state.position_m[axis];
            fused.velocity_mps[axis] += weight * state.velocity_mps[axis];
        }
    }
    for row in 0..2 * AXES {
        for column in row..2 * AXES {
            let axis = row % AXES;
            if together(axis, column % AXES) {
                let sum = states()
                    .zip(weights)
                    .map(|(state, weight)| weight[axis] * state.covariance.get(row, column))
                    .sum();
                fused.covariance.set(row, column, sum);
            }
        }
    }
    fused
}

/// The weights of each state on each axis.
fn weights_per_axis(candidates: &[Candidate], shares: &[Share]) -> [[f64; AXES]; CONTRIBUTIONS_MAX] {
    let mut weights = [[0.0; AXES]; CONTRIBUTIONS_MAX];
    for (weight, share) in weights.iter_mut().zip(shares) {
        *weight = share.weight;
    }
    let known = |index: &usize| candidates[*index].state.has_height;
    let all = 0..candidates.len();
    if all.clone().all(|index| known(&index)) || !all.clone().any(|index| known(&index)) {
        return weights;
    }
    let total: f64 = all.clone().filter(known).map(|index| shares[index].weight[2]).sum();
    let best = all.filter(known).min_by(|a, b| {
        let by_accuracy = shares[*a].accuracy.total_cmp(&shares[*b].accuracy);
        by_accuracy.then(candidates[*a].source.cmp(&candidates[*b].source))
    });
    for (index, weight) in weights[..candidates.len()].iter_mut().enumerate() {
        weight[2] = match known(&index) {
            false => 0.0,
            true if total > 0.0 => weight[2] / total,
            true => f64::from(u8::from(best == Some(index))),
        };
    }
    weights
}

#[cfg(test)]
mod tests {
    use messages::Covariance;
    use proptest::prelude::*;

    use super::*;

    fn state(x: f64, variance: f64, has_height: bool) -> State {
        let mut covariance = Covariance::diagonal([variance.sqrt(); 3], [1.0; 3]);
        covariance.set(0, 1, 0.3 * variance);
        State {
            time_ns: 0,
            position_m: [x, 2.0 * x, 3.0 * x],
            velocity_mps: [1.0, 2.0, 3.0],
            covariance,
            has_height,
        }
    }

    /// `combine` over states and weights.
    fn combined(parts: &[(State, f64)]) -> State {
        let candidate = |state| Candidate {
            state,
            ..Candidate::default()
        };
        let share = |weight: f64| Share {
            weight: [weight; 3],
            accuracy: 1.0 - weight,
            ..Share::default()
        };
        let candidates: Vec<_> = parts.iter().map(|(state, _)| candidate(*state)).collect();
        let shares: Vec<_> = parts.iter().map(|(_, weight)| share(*weight)).collect();
        combine(&candidates, &shares)
    }

    #[test]
    fn one_source_passes_through_unchanged() {
        let only = state(10.0, 4.0, true);
        assert_eq!(combined(&[(only, 1.0)]), only);
    }

    #[test]
    fn the_mean_and_its_covariance_are_weighted() {
        let fused = combined(&[(state(0.0, 4.0, true), 0.25), (state(100.0, 16.0, true), 0.75)]);
        assert!((fused.position_m[0] - 75.0).abs() < 1e-12);
        assert!((fused.covariance.get(0, 0) - 13.0).abs() < 1e-12);
    }

    #[test]
    fn a_source_without_height_does_not_give_one() {
        let fused = combined(&[(state(0.0, 4.0, false), 1.0), (state(100.0, 16.0, true), 0.0)]);
        assert_eq!(fused.position_m, [0.0, 0.0, 300.0]);
        assert!(fused.has_height);
        assert_eq!(fused.covariance.get(0, 2), 0.0, "of two sources, nothing is known");
    }

    proptest! {
        #[test]
        fn fused_positions_lie_between_the_sources(
            parts in prop::collection::vec((-1e4..1e4f64, 0.01..1.0f64), 1..6),
        ) {
            let total: f64 = parts.iter().map(|(_, weight)| weight).sum();
            let weighed: Vec<_> = parts.iter().map(|(x, weight)| (state(*x, 9.0, true), weight / total)).collect();
            let fused = combined(&weighed);
            let low = parts.iter().map(|(x, _)| *x).fold(f64::INFINITY, f64::min);
            let high = parts.iter().map(|(x, _)| *x).fold(f64::NEG_INFINITY, f64::max);
            prop_assert!((low - 1e-6..=high + 1e-6).contains(&fused.position_m[0]));
        }
    }
}
