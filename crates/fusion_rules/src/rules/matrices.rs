//! Common parts of the rules that combine whole covariances.
//!
//! East and north, positions and velocities, are combined together (4×4); height and vertical speed separately (2×2),
//! over the sources with observed height, so that a source without height neither contributes height nor gains or
//! loses weight. The correlation of horizontal with vertical errors, stated by hardly any source, is omitted.
//!
//! A covariance that is not positive definite is repaired and counted; if no part can be kept, the source is
//! left out. A single source passes through untouched.

use estimation::{Estimate, Matrix6, repaired, unpacked};
use messages::{AXES, CONTRIBUTIONS_MAX, STATE_LEN};
use nalgebra::{SMatrix, SVector};

use super::{Candidate, Share};
use crate::state::State;

/// Variance in place of 0, which would claim exact knowledge: (1 mm)², (1 mm/s)².
const VARIANCE_MIN: f64 = 1e-6;
/// x, y, vx, vy.
const HORIZONTAL: [usize; 4] = [0, 1, 3, 4];
/// z, vz.
const VERTICAL: [usize; 2] = [2, 5];

/// A way to combine estimates.
pub(super) trait Combination {
    /// The combination of `inputs`, each with a share of the result; `None` if the combination cannot be formed.
    ///
    /// The first half of the components are positions, the second half the velocities.
    fn combine<const D: usize>(&self, inputs: &[Estimate<D>], shares: &mut [f64]) -> Option<Estimate<D>>;
}

/// Combines the candidates; fills the weights of the shares.
pub(super) fn fuse(candidates: &[Candidate], combination: &impl Combination, shares: &mut [Share]) -> Option<State> {
    if let ([only], [share]) = (candidates, &mut *shares) {
        share.weight = [1.0; AXES];
        return Some(only.state);
    }
    let mut covariances = [None; CONTRIBUTIONS_MAX];
    for ((covariance, candidate), share) in covariances.iter_mut().zip(candidates).zip(&mut *shares) {
        let stated = stated(&candidate.state);
        *covariance = repaired(&stated);
        share.repaired = *covariance != Some(stated);
    }
    let everyone = [true; CONTRIBUTIONS_MAX];
    let has_height: [bool; CONTRIBUTIONS_MAX] = std::array::from_fn(|index| {
        candidates
            .get(index)
            .is_some_and(|candidate| candidate.state.has_height)
    });
    let (horizontal, weights) = over(HORIZONTAL, combination, candidates, &covariances, &everyone)?;
    for (share, weight) in shares.iter_mut().zip(weights) {
        share.weight = [weight; AXES];
    }
    let mut state = State {
        time_ns: candidates[0].state.time_ns,
        ..State::default()
    };
    write(&mut state, HORIZONTAL, &horizontal);
    if let Some((vertical, weights)) = over(VERTICAL, combination, candidates, &covariances, &has_height) {
        write(&mut state, VERTICAL, &vertical);
        state.has_height = true;
        for (share, weight) in shares.iter_mut().zip(weights) {
            share.weight[2] = weight;
        }
    } else {
        // The height is unknown: any valid state will do.
        let mut unknown = Estimate::<2>::default();
        for (row, component) in VERTICAL.into_iter().enumerate() {
            let means = candidates.iter().zip(&*shares);
            unknown.mean[row] = means
                .map(|(candidate, share)| share.weight[0] * component_of(&candidate.state, component))
                .sum();
            let variances = covariances.iter().flatten().map(|p| p[(component, component)]);
            unknown.covariance[(row, row)] = variances.fold(VARIANCE_MIN, f64::max);
        }
        write(&mut state, VERTICAL, &unknown);
    }
    Some(state)
}

/// Returns the covariance stated by the source, without unobserved parts.
fn stated(state: &State) -> Matrix6 {
    let mut matrix = unpacked(&state.covariance);
    for component in 0..STATE_LEN {
        if !state.has_height && VERTICAL.contains(&component) {
            let variance = matrix[(component, component)];
            matrix.row_mut(component).fill(0.0);
            matrix.column_mut(component).fill(0.0);
            matrix[(component, component)] = variance;
        }
        let variance = &mut matrix[(component, component)];
        *variance = variance.max(VARIANCE_MIN);
    }
    matrix
}

/// Combines `components` of the `wanted` candidates; the weights are those of all candidates.
fn over<const D: usize>(
    components: [usize; D],
    combination: &impl Combination,
    candidates: &[Candidate],
    covariances: &[Option<Matrix6>; CONTRIBUTIONS_MAX],
    wanted: &[bool; CONTRIBUTIONS_MAX],
) -> Option<(Estimate<D>, [f64; CONTRIBUTIONS_MAX])> {
    let mut inputs = [Estimate::<D>::default(); CONTRIBUTIONS_MAX];
    let (mut places, mut len) = ([0; CONTRIBUTIONS_MAX], 0);
    for (index, candidate) in candidates.iter().enumerate() {
        let Some(covariance) = covariances[index].filter(|_| wanted[index]) else {
            continue;
        };
        inputs[len] = Estimate {
            mean: SVector::from_fn(|row, _| component_of(&candidate.state, components[row])),
            covariance: SMatrix::from_fn(|row, column| covariance[(components[row], components[column])]),
        };
        places[len] = index;
        len += 1;
    }
    if len == 0 {
        return None;
    }
    let (mut shares, mut weights) = ([0.0; CONTRIBUTIONS_MAX], [0.0; CONTRIBUTIONS_MAX]);
    let fused = combination.combine(&inputs[..len], &mut shares[..len])?;
    // Correlated inputs may have negative shares; the shown weights omit these.
    let total: f64 = shares[..len].iter().map(|share| share.max(0.0)).sum();
    for (place, share) in places[..len].iter().zip(shares) {
        weights[*place] = share.max(0.0) / total;
    }
    Some((fused, weights))
}

fn component_of(state: &State, component: usize) -> f64 {
    if component < AXES {
        state.position_m[component]
    } else {
        state.velocity_mps[component - AXES]
    }
}

fn write<const D: usize>(state: &mut State, components: [usize; D], estimate: &Estimate<D>) {
    for (row, component) in components.into_iter().enumerate() {
        if component < AXES {
            state.position_m[component] = estimate.mean[row];
        } else {
            state.velocity_mps[component - AXES] = estimate.mean[row];
        }
        for (column, other) in components.into_iter().enumerate().skip(row) {
            state
                .covariance
                .set(component, other, estimate.covariance[(row, column)]);
        }
    }
}
