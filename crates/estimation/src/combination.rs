//! Combination of several estimates of the same state, under three assumptions on the correlation of the errors.
//!
//! Two sensors' tracks of the same target share the target: both lag behind the same manoeuvre, so the errors are
//! correlated even where the sensors' noises are not.
//!
//! - [`information_sum`]: no correlation. Inverse covariances add up. Simple, and too sure of itself by the ignored
//!   part.
//! - [`intersection_weights`] with [`weighted_information`]: any correlation. Weights of sum 1 on the inverse
//!   covariances make the result a bound on the true covariance for every correlation; the smallest bound is chosen
//!   (S. J. Julier, J. K. Uhlmann, *A non-divergent estimation algorithm in the presence of unknown correlations*,
//!   1997).
//! - [`correlated_combination`]: known cross-covariances. The best linear unbiased combination (Y. Bar-Shalom, L.
//!   Campo,
//!   *The effect of the common process noise on the two-sensor fused-track covariance*, 1986; for more than two the
//!   same by least squares, K. C. Chang, R. K. Saha, Y. Bar-Shalom, *On optimal track-to-track fusion*, 1997).
//!
//! Each gives every input's share: the trace of the input's matrix weight over the dimension. Matrix weights add up to
//! the identity, so shares sum to 1.

use nalgebra::{SMatrix, SVector};

use crate::dense;

/// Most inputs to a combination.
pub const INPUTS_MAX: usize = 16;
/// Most rows of a joint covariance: inputs times components.
const JOINT_MAX: usize = 64;
/// Strengths of the barrier that keeps intersection weights positive, in succession: each start is good for the next.
const BARRIERS: [f64; 3] = [1e-2, 1e-5, 1e-8];
/// Most Newton steps per strength; a handful is usual.
const NEWTON_STEPS_MAX: usize = 16;
/// Most halvings of a single Newton step.
const HALVINGS_MAX: usize = 30;

/// A mean and the covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<const D: usize> {
    /// Expected state.
    pub mean: SVector<f64, D>,
    /// Covariance of the estimate.
    pub covariance: SMatrix<f64, D, D>,
}

impl<const D: usize> Default for Estimate<D> {
    fn default() -> Self {
        Self {
            mean: SVector::zeros(),
            covariance: SMatrix::zeros(),
        }
    }
}

/// Quantity that covariance intersection makes small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// The trace over the first so many components.
    Trace {
        /// Number of components; all of the same unit, for a sum of metres and metres per second means nothing.
        components: usize,
    },
    /// The determinant: the volume of the error ellipsoid, in any units.
    Determinant,
}

/// P⁻¹ = Σ Pⱼ⁻¹, for independent errors. `None` if a covariance is not positive definite.
pub fn information_sum<const D: usize>(inputs: &[Estimate<D>], shares: &mut [f64]) -> Option<Estimate<D>> {
    weighted_information(inputs, &[1.0; INPUTS_MAX][..inputs.len()], shares)
}

/// P⁻¹ = Σ wⱼ·Pⱼ⁻¹ and P⁻¹·x = Σ wⱼ·Pⱼ⁻¹·xⱼ. With weights of sum 1, P bounds the true covariance.
///
/// `None` if there are no inputs or more than [`INPUTS_MAX`], or a covariance is not positive definite.
pub fn weighted_information<const D: usize>(
    inputs: &[Estimate<D>],
    weights: &[f64],
    shares: &mut [f64],
) -> Option<Estimate<D>> {
    let information = inverses(inputs)?;
    let (mut sum, mut pull) = (SMatrix::zeros(), SVector::zeros());
    // Relative to a single input: large coordinates cost no digits.
    let origin = inputs.first()?.mean;
    for ((input, y), weight) in inputs.iter().zip(&information).zip(weights) {
        sum += y * *weight;
        pull += y * (input.mean - origin) * *weight;
    }
    let covariance = inverse(&sum)?;
    for ((share, y), weight) in shares.iter_mut().zip(&information).zip(weights) {
        *share = weight * covariance.component_mul(y).sum() / D as f64;
    }
    Some(Estimate {
        mean: origin + covariance * pull,
        covariance,
    })
}

/// The weights of covariance intersection: at least 0, of sum 1, a weight per input, such that the combined covariance
/// is smallest by `criterion`. Where several are as good, equal inputs get equal weights.
///
/// Both criteria are convex in the weights. Newton's method on the simplex with a logarithmic barrier finds the minimum
/// in a bounded number of steps; a barrier of 1e-8 moves the minimum by no more than that. An input that is best alone,
/// which is common, is recognised without any search. `None` as in [`weighted_information`].
pub fn intersection_weights<const D: usize>(
    inputs: &[Estimate<D>],
    criterion: Criterion,
    weights: &mut [f64],
) -> Option<()> {
    let information = inverses(inputs)?;
    let n = inputs.len();
    let mut problem = IntersectionCost {
        information: &information[..n],
        criterion,
        scale: 1.0,
    };
    let mut at = [0.0; INPUTS_MAX];
    if let Some(best) = (0..n).find(|index| problem.is_best_alone(*index, &inputs[*index].covariance)) {
        weights[..n].fill(0.0);
        weights[best] = 1.0;
        return Some(());
    }
    at[..n].fill(1.0 / n as f64);
    problem.scale = 1.0 / problem.value(&at, 0.0)?.abs().max(f64::MIN_POSITIVE);
    if criterion == Criterion::Determinant {
        problem.scale = 1.0;
    }
    if n > 1 {
        for barrier in BARRIERS {
            for _ in 0..NEWTON_STEPS_MAX {
                if !problem.step(&mut at, barrier)? {
                    break;
                }
            }
        }
    }
    let total: f64 = at[..n].iter().sum();
    for (weight, found) in weights.iter_mut().zip(&at[..n]) {
        *weight = found / total;
    }
    Some(())
}

/// The function that covariance intersection minimises.
struct IntersectionCost<'a, const D: usize> {
    information: &'a [SMatrix<f64, D, D>],
    criterion: Criterion,
    /// Makes the criterion about 1, so that the barrier's strength means the same for every input.
    scale: f64,
}

impl<const D: usize> IntersectionCost<'_, D> {
    fn sum(&self, weights: &[f64; INPUTS_MAX]) -> SMatrix<f64, D, D> {
        let terms = self.information.iter().zip(weights);
        terms.fold(SMatrix::zeros(), |sum, (y, weight)| sum + y * *weight)
    }

    /// Returns whether no weight on another input makes the criterion clearly smaller than input `index` alone, of
    /// covariance P, judged by the gradient there. An equal input is no worse.
    fn is_best_alone(&self, index: usize, covariance: &SMatrix<f64, D, D>) -> bool {
        let outer = self.outer(covariance);
        let worth = |y: &SMatrix<f64, D, D>| outer.component_mul(y).sum();
        let own = worth(&self.information[index]);
        let mut others = self.information.iter().enumerate().filter(|(other, _)| *other != index);
        others.all(|(_, y)| worth(y) < (1.0 - 1e-9) * own)
    }

    /// Matrix of which the gradient is made: P for the determinant, P·S·P for the trace.
    fn outer(&self, covariance: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
        match self.criterion {
            Criterion::Determinant => *covariance,
            Criterion::Trace { components } => {
                let mut chosen = *covariance;
                for row in components..D {
                    chosen.row_mut(row).fill(0.0);
                }
                covariance * chosen
            }
        }
    }

    /// Criterion plus barrier; `None` outside the simplex.
    fn value(&self, weights: &[f64; INPUTS_MAX], barrier: f64) -> Option<f64> {
        let used = &weights[..self.information.len()];
        if used.iter().any(|weight| *weight <= 0.0) {
            return None;
        }
        let factor = self.sum(weights).cholesky()?;
        let criterion = match self.criterion {
            Criterion::Determinant => -2.0 * (0..D).map(|k| factor.l_dirty()[(k, k)].ln()).sum::<f64>(),
            Criterion::Trace { components } => {
                let covariance = factor.inverse();
                (0..components).map(|k| covariance[(k, k)]).sum()
            }
        };
        let logarithms: f64 = used.iter().map(|weight| weight.ln()).sum();
        Some(self.scale * criterion - barrier * logarithms)
    }

    /// A single damped Newton step along the simplex; `false` once there is nothing more to gain.
    fn step(&self, weights: &mut [f64; INPUTS_MAX], barrier: f64) -> Option<bool> {
        let n = self.information.len();
        let (gradient, mut hessian) = self.derivatives(weights, barrier)?;
        if !dense::factorise(&mut hessian, n) {
            return Some(false);
        }
        // H·d + g + ν·1 = 0 with Σ d = 0.
        let (mut along, mut ones) = (gradient, [1.0; INPUTS_MAX]);
        dense::solve(&hessian, n, &mut along);
        dense::solve(&hessian, n, &mut ones);
        let multiplier = along[..n].iter().sum::<f64>() / ones[..n].iter().sum::<f64>();
        let direction: [f64; INPUTS_MAX] = std::array::from_fn(|k| multiplier * ones[k] - along[k]);
        let slope: f64 = (0..n).map(|k| gradient[k] * direction[k]).sum();
        // Minus twice the gain that is left, to second order.
        if slope > -1e-3 * barrier * barrier.sqrt() {
            return Some(false);
        }
        let before = self.value(weights, barrier)?;
        let mut length = 1.0;
        for _ in 0..HALVINGS_MAX {
            let trial = std::array::from_fn(|k| if k < n { weights[k] + length * direction[k] } else { 0.0 });
            if self
                .value(&trial, barrier)
                .is_some_and(|after| after <= before + 0.1 * length * slope)
            {
                *weights = trial;
                return Some(true);
            }
            length *= 0.5;
        }
        Some(false)
    }

    /// Gradient and Hessian of criterion plus barrier. With P = (Σ w·Y)⁻¹, for −ln det P⁻¹, gradient and Hessian are
    /// −tr(P·Yᵢ) and tr(P·Yᵢ·P·Yⱼ); for tr(S·P), −tr(P·S·P·Yᵢ) and 2·tr(P·S·P·Yᵢ·P·Yⱼ).
    fn derivatives(&self, weights: &[f64; INPUTS_MAX], barrier: f64) -> Option<([f64; INPUTS_MAX], Square)> {
        let covariance = inverse(&self.sum(weights))?;
        let outer = self.outer(&covariance);
        let twice = if self.criterion == Criterion::Determinant {
            1.0
        } else {
            2.0
        };
        let (mut gradient, mut hessian) = ([0.0; INPUTS_MAX], [[0.0; INPUTS_MAX]; INPUTS_MAX]);
        for (i, y) in self.information.iter().enumerate() {
            let left = outer * y;
            gradient[i] = -self.scale * left.trace() - barrier / weights[i];
            // P·Yᵢ·A, so that the elementwise product with Yⱼ sums to the trace.
            let both = covariance * left.transpose();
            for (j, other) in self.information[..=i].iter().enumerate() {
                hessian[i][j] = self.scale * twice * both.component_mul(other).sum();
                hessian[j][i] = hessian[i][j];
            }
            hessian[i][i] += barrier / (weights[i] * weights[i]);
        }
        Some((gradient, hessian))
    }
}

type Square = [[f64; INPUTS_MAX]; INPUTS_MAX];

/// The best linear combination for known cross-covariances: `cross(i, j)` is E[eᵢ·eⱼᵀ], asked for with i > j only.
///
/// With H the stacked identities and Π the joint covariance, P = (Hᵀ·Π⁻¹·H)⁻¹ and x = P·Hᵀ·Π⁻¹·(stacked means). `None`
/// if there are too many inputs or the joint covariance is not positive definite. Shares may lie outside [0, 1]: where
/// an input is much the better and correlated with the other, the other counts negatively.
pub fn correlated_combination<const D: usize>(
    inputs: &[Estimate<D>],
    cross: impl Fn(usize, usize) -> SMatrix<f64, D, D>,
    shares: &mut [f64],
) -> Option<Estimate<D>> {
    let rows = inputs.len() * D;
    if rows > JOINT_MAX {
        return None;
    }
    let mut joint = [[0.0; JOINT_MAX]; JOINT_MAX];
    for (i, input) in inputs.iter().enumerate() {
        for j in 0..=i {
            let block = if i == j { input.covariance } else { cross(i, j) };
            for row in 0..D {
                for column in 0..D {
                    joint[i * D + row][j * D + column] = block[(row, column)];
                }
            }
        }
    }
    if !dense::factorise(&mut joint, rows) {
        return None;
    }
    // Π⁻¹·H, a single column at a time.
    let mut weighing = [SMatrix::<f64, D, D>::zeros(); INPUTS_MAX];
    for column in 0..D {
        let mut solved = [0.0; JOINT_MAX];
        for i in 0..inputs.len() {
            solved[i * D + column] = 1.0;
        }
        dense::solve(&joint, rows, &mut solved);
        for (i, block) in weighing[..inputs.len()].iter_mut().enumerate() {
            for row in 0..D {
                block[(row, column)] = solved[i * D + row];
            }
        }
    }
    let weighing = &weighing[..inputs.len()];
    let sum: SMatrix<f64, D, D> = weighing.iter().sum();
    let covariance = inverse(&((sum + sum.transpose()) * 0.5))?;
    let origin = inputs.first()?.mean;
    let mut pull = SVector::zeros();
    for ((input, block), share) in inputs.iter().zip(weighing).zip(shares) {
        pull += block.transpose() * (input.mean - origin);
        *share = covariance.component_mul(block).sum() / D as f64;
    }
    Some(Estimate {
        mean: origin + covariance * pull,
        covariance,
    })
}

fn inverses<const D: usize>(inputs: &[Estimate<D>]) -> Option<[SMatrix<f64, D, D>; INPUTS_MAX]> {
    let mut found = [SMatrix::zeros(); INPUTS_MAX];
    if inputs.is_empty() || inputs.len() > INPUTS_MAX {
        return None;
    }
    for (found, input) in found.iter_mut().zip(inputs) {
        *found = inverse(&input.covariance)?;
    }
    Some(found)
}

/// Inverse of a positive definite matrix; exactly symmetric.
fn inverse<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    let inverse = matrix.cholesky()?.inverse();
    Some((inverse + inverse.transpose()) * 0.5)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Vector2};
    use proptest::prelude::*;

    use super::*;
    use crate::gaussian::unpacked;
    use crate::is_positive_definite;
    use crate::testing::any_gaussian;

    fn published() -> [Estimate<2>; 2] {
        [
            Estimate {
                mean: Vector2::new(1.0, -2.0),
                covariance: Matrix2::new(3.0, 0.0, 0.0, 0.4),
            },
            Estimate {
                mean: Vector2::new(-2.0, -1.0),
                covariance: Matrix2::new(2.0, -0.8, -0.8, 1.0),
            },
        ]
    }

    fn intersected<const D: usize>(inputs: &[Estimate<D>], criterion: Criterion) -> (Vec<f64>, Estimate<D>) {
        let (mut weights, mut shares) = (vec![0.0; inputs.len()], vec![0.0; inputs.len()]);
        intersection_weights(inputs, criterion, &mut weights).expect("positive definite");
        let fused = weighted_information(inputs, &weights, &mut shares).expect("positive definite");
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        (weights, fused)
    }

    #[test]
    fn intersection_gives_the_published_numbers() {
        let (weights, fused) = intersected(&published(), Criterion::Determinant);
        assert!((weights[0] - 0.56452).abs() < 5e-6, "{weights:?}");
        let expected = Matrix2::new(2.09909, -0.26208, -0.26208, 0.52012);
        assert!((fused.covariance - expected).amax() < 1e-5, "{fused:?}");
        assert!(
            (fused.mean - Vector2::new(-0.44515, -1.88199)).amax() < 1e-5,
            "{fused:?}"
        );
        let (weights, _) = intersected(&published(), Criterion::Trace { components: 2 });
        assert!((weights[0] - 0.40370).abs() < 5e-6, "{weights:?}");
    }

    #[test]
    fn equal_inputs_share_equally_and_only_independent_ones_gain() {
        let one = published()[1];
        let mut shares = [0.0; 3];
        let summed = information_sum(&[one; 3], &mut shares).expect("positive definite");
        assert!(shares.iter().all(|share| (share - 1.0 / 3.0).abs() < 1e-12));
        assert!((summed.covariance * 3.0 - one.covariance).amax() < 1e-12);
        for criterion in [Criterion::Determinant, Criterion::Trace { components: 1 }] {
            let (weights, fused) = intersected(&[one; 3], criterion);
            assert!(
                weights.iter().all(|weight| (weight - 1.0 / 3.0).abs() < 1e-9),
                "{weights:?}"
            );
            assert!((fused.covariance - one.covariance).amax() < 1e-9);
        }
    }

    #[test]
    fn equal_steady_filters_fuse_to_the_published_covariance() {
        let input = Estimate {
            mean: Vector2::new(1.0, 2.0),
            covariance: Matrix2::new(0.75, 0.5, 0.5, 1.0),
        };
        let other = Estimate {
            mean: Vector2::new(3.0, 4.0),
            ..input
        };
        let cross = Matrix2::new(1.0 / 12.0, 1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0);
        let mut shares = [0.0; 2];
        let fused = correlated_combination(&[input, other], |_, _| cross, &mut shares).expect("positive definite");
        let expected = Matrix2::new(5.0 / 12.0, 1.0 / 3.0, 1.0 / 3.0, 5.0 / 6.0);
        assert!((fused.covariance - expected).amax() < 1e-12);
        assert!((fused.mean - Vector2::new(2.0, 3.0)).amax() < 1e-12);
        assert!(shares.iter().all(|share| (share - 0.5).abs() < 1e-12));
    }

    #[test]
    fn what_cannot_be_used_is_refused() {
        let mut bad = published();
        bad[1].covariance[(0, 0)] = -1.0;
        let mut shares = [0.0; 2];
        assert_eq!(information_sum(&bad, &mut shares), None);
        assert_eq!(intersection_weights(&bad, Criterion::Determinant, &mut shares), None);
        assert_eq!(correlated_combination(&bad, |_, _| Matrix2::zeros(), &mut shares), None);
        let fully = published()[0].covariance;
        let same = [published()[0]; 2];
        assert_eq!(correlated_combination(&same, |_, _| fully, &mut shares), None);
        assert_eq!(information_sum::<2>(&[], &mut []), None);
    }

    fn several() -> impl Strategy<Value = Vec<Estimate<6>>> {
        let estimate = any_gaussian().prop_map(|gaussian| Estimate {
            mean: gaussian.mean.into(),
            covariance: unpacked(&gaussian.covariance),
        });
        prop::collection::vec(estimate, 2..5)
    }

    /// The criterion at given weights.
    fn judged(inputs: &[Estimate<6>], weights: &[f64], criterion: Criterion) -> f64 {
        let mut shares = vec![0.0; inputs.len()];
        let covariance = weighted_information(inputs, weights, &mut shares)
            .expect("positive")
            .covariance;
        match criterion {
            Criterion::Determinant => covariance.determinant().ln(),
            Criterion::Trace { components } => (0..components).map(|k| covariance[(k, k)]).sum::<f64>().ln(),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn no_other_weights_are_better(inputs in several()) {
            let steps = 12;
            for criterion in [Criterion::Determinant, Criterion::Trace { components: 2 }] {
                let (weights, fused) = intersected(&inputs, criterion);
                prop_assert!(is_positive_definite(&fused.covariance));
                let found = judged(&inputs, &weights, criterion);
                // Every point of a grid over the simplex; the last weight is the remainder.
                let n = inputs.len();
                for code in 0..(steps + 1_usize).pow(n as u32 - 1) {
                    let mut grid = vec![0.0; n];
                    let (mut rest, mut left) = (code, steps as i64);
                    for weight in &mut grid[..n - 1] {
                        let part = (rest % (steps + 1)) as i64;
                        rest /= steps + 1;
                        left -= part;
                        *weight = part as f64 / steps as f64;
                    }
                    if left >= 0 {
                        grid[n - 1] = left as f64 / steps as f64;
                        prop_assert!(found <= judged(&inputs, &grid, criterion) + 1e-7, "{weights:?} {grid:?}");
                    }
                }
            }
        }

        #[test]
        fn without_correlation_the_general_combination_is_the_information_sum(inputs in several()) {
            let (mut a, mut b) = (vec![0.0; inputs.len()], vec![0.0; inputs.len()]);
            let summed = information_sum(&inputs, &mut a).expect("positive definite");
            let combined = correlated_combination(&inputs, |_, _| SMatrix::zeros(), &mut b).expect("positive definite");
            for k in 0..6 {
                let sigma = summed.covariance[(k, k)].sqrt();
                prop_assert!((summed.mean[k] - combined.mean[k]).abs() < 1e-6 * (sigma + 1.0));
                prop_assert!((summed.covariance[(k, k)] / combined.covariance[(k, k)] - 1.0).abs() < 1e-6);
            }
            for (a, b) in a.iter().zip(&b) {
                prop_assert!((a - b).abs() < 1e-6);
            }
        }
    }
}
