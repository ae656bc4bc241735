//! `bar-shalom-campo`: the best linear combination under a modelled cross-covariance (BF-1).
//!
//! The target itself correlates two trackers: both lag behind its manoeuvres. Each source is modelled as a steady
//! filter of nearly constant velocity with the reported position variance; common process noise and the gains of these
//! filters give the correlations of every pair (`estimation::SteadyFilter`). The correlations are transferred to the
//! reported covariances by the covariances' square roots. Sources that fit the model are thus combined exactly, and
//! the joint covariance is positive definite for all others.
//!
//! Limits: steady state; the shortest period of the sources is used for all, which errs towards more correlation; an
//! aged report is taken for a report of a poorer filter; common errors of sources for other reasons are not modelled.
//! Should rounding leave the joint covariance indefinite, the sources are combined by covariance intersection.

use estimation::{Estimate, INPUTS_MAX, SteadyFilter, correlated_combination};
use messages::NS_PER_S;
use nalgebra::{Matrix2, SMatrix};

use super::matrices::{self, Combination};
use super::{RuleEntry, RuleMemory, RuleMethod, Share, Target};
use crate::settings::{Intersection, RuleSettings};
use crate::state::State;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    code: messages::FusionRule::BarShalomCampo,
    summary: "all sources, weighed by covariances and the cross-covariances that common process noise explains",
    assumption: "errors of different sources are correlated by the target's manoeuvres, as in steady filters, and no more",
    keeps_points: false,
    chooses_by_accuracy: false,
    claims_consistency: true,
    method: RuleMethod::Candidates(fuse),
};

/// Inputs of the model beside the states.
struct CommonNoise {
    density_m2ps3: f64,
    period_s: f64,
}

fn fuse(settings: &RuleSettings, target: &Target<'_>, _: &mut RuleMemory, shares: &mut [Share]) -> Option<State> {
    let periods = target.candidates.iter().map(|candidate| candidate.period_ns);
    let model = CommonNoise {
        density_m2ps3: settings.common_noise_m2ps3.unwrap_or(target.process_noise_m2ps3),
        period_s: periods.min()? as f64 / NS_PER_S,
    };
    matrices::fuse(target.candidates, &model, shares)
}

impl Combination for CommonNoise {
    fn combine<const D: usize>(&self, inputs: &[Estimate<D>], shares: &mut [f64]) -> Option<Estimate<D>> {
        let (mut filters, mut roots) = ([None; INPUTS_MAX], [SMatrix::<f64, D, D>::zeros(); INPUTS_MAX]);
        for ((filter, root), input) in filters.iter_mut().zip(&mut roots).zip(inputs) {
            let axes = D / 2;
            let variance = (0..axes).map(|k| input.covariance[(k, k)]).sum::<f64>() / axes as f64;
            *filter =
                (self.density_m2ps3 > 0.0).then(|| SteadyFilter::new(variance, self.density_m2ps3, self.period_s));
            *root = block_root(&input.covariance);
        }
        let cross = |i: usize, j: usize| {
            let correlation = filters[i].and_then(|a| a.correlation(&filters[j]?));
            roots[i] * spread(&correlation.unwrap_or_default()) * roots[j].transpose()
        };
        correlated_combination(inputs, cross, shares).or_else(|| Intersection::Determinant.combine(inputs, shares))
    }
}

/// Matrix with the same correlation on every axis, none between axes.
fn spread<const D: usize>(correlation: &Matrix2<f64>) -> SMatrix<f64, D, D> {
    let axes = D / 2;
    SMatrix::from_fn(|row, column| {
        if row % axes == column % axes {
            correlation[(row / axes, column / axes)]
        } else {
            0.0
        }
    })
}

/// B with B·Bᵀ = `covariance`, lower triangular by blocks (position, velocity) with symmetric blocks on the diagonal:
/// B turns with the frame, so that the result does not depend on the direction of north. D is 2 or 4.
pub(super) fn block_root<const D: usize>(covariance: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    let axes = D / 2;
    // A single axis is treated as two, with the second never used.
    let block = |row: usize, column: usize| {
        Matrix2::from_fn(|r, c| {
            if r < axes && c < axes {
                covariance[(row * axes + r, column * axes + c)]
            } else {
                f64::from(u8::from(r == c && row == column))
            }
        })
    };
    let position = symmetric_root(&block(0, 0));
    let cross = block(1, 0) * position.try_inverse().unwrap_or_default();
    let velocity = symmetric_root(&(block(1, 1) - cross * cross.transpose()));
    SMatrix::from_fn(|row, column| {
        let at = (row % axes, column % axes);
        match (row / axes, column / axes) {
            (0, 0) => position[at],
            (1, 0) => cross[at],
            (1, 1) => velocity[at],
            _ => 0.0,
        }
    })
}

/// The symmetric positive root of a symmetric positive 2×2 matrix M: (M + √det·1) / √(tr + 2·√det).
fn symmetric_root(matrix: &Matrix2<f64>) -> Matrix2<f64> {
    let root_of_determinant = matrix.determinant().max(0.0).sqrt();
    let scale = (matrix.trace() + 2.0 * root_of_determinant)
        .max(f64::MIN_POSITIVE)
        .sqrt();
    (matrix + Matrix2::identity() * root_of_determinant) / scale
}

#[cfg(test)]
mod tests {
    use messages::Covariance;

    use super::*;
    use crate::rules::{Candidate, testing};

    /// A source that is a steady filter at manoeuvring index 1: T = 1 s, R = 1 m², q = 1 m²/s³.
    fn steady(source: u16, x: f64) -> Candidate {
        let mut covariance = Covariance::diagonal([0.75_f64.sqrt(); 3], [1.0; 3]);
        for axis in 0..3 {
            covariance.set(axis, axis + 3, 0.5);
        }
        Candidate {
            source,
            period_ns: 1_000_000_000,
            state: State {
                position_m: [x, 0.0, 0.0],
                covariance,
                has_height: true,
                ..State::default()
            },
            ..Candidate::default()
        }
    }

    #[test]
    fn two_equal_steady_filters_fuse_to_the_published_covariance() {
        let (state, shares) = testing::fused(&ENTRY, &[steady(0, 0.0), steady(1, 2.0)]);
        let state = state.unwrap();
        for axis in 0..3 {
            let p = |row: usize, column: usize| state.covariance.get(axis + row, axis + column);
            assert!((p(0, 0) - 5.0 / 12.0).abs() < 1e-9, "{}", p(0, 0));
            assert!((p(0, 3) - 1.0 / 3.0).abs() < 1e-9);
            assert!((p(3, 3) - 5.0 / 6.0).abs() < 1e-9);
        }
        assert!((state.position_m[0] - 1.0).abs() < 1e-9);
        assert!(shares.iter().all(|share| (share.weight[0] - 0.5).abs() < 1e-9));
    }

    #[test]
    fn the_more_sources_the_smaller_but_never_below_the_common_part() {
        let variance = |count: u16| {
            let candidates: Vec<_> = (0..count).map(|source| steady(source, 0.0)).collect();
            let state = testing::fused_of(&ENTRY, &candidates).0.unwrap();
            state.covariance.get(0, 0)
        };
        let found: Vec<_> = [1, 2, 3, 8, 16].map(variance).to_vec();
        assert!(found.windows(2).all(|pair| pair[1] < pair[0]), "{found:?}");
        assert!(found[4] > 1.0 / 12.0, "{found:?}");
    }

    #[test]
    fn turning_the_frame_turns_the_result() {
        let turned = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            let ellipse = |source: u16, along: f64, across: f64, bearing: f64| {
                let mut candidate = steady(source, 0.0);
                let (s, c) = (bearing + angle).sin_cos();
                for (offset, scale) in [(0, 1.0), (3, 0.1)] {
                    let p = &mut candidate.state.covariance;
                    p.set(offset, offset, scale * (along * c * c + across * s * s));
                    p.set(offset + 1, offset + 1, scale * (along * s * s + across * c * c));
                    p.set(offset, offset + 1, scale * (along - across) * s * c);
                    for other in 3..6 {
                        if offset == 0 {
                            p.set(0, other, 0.0);
                            p.set(1, other, 0.0);
                        }
                    }
                }
                candidate.state.position_m = [100.0 * f64::from(source) * cos, 100.0 * f64::from(source) * sin, 0.0];
                candidate
            };
            let state = testing::fused(&ENTRY, &[ellipse(0, 90.0, 4.0, 0.3), ellipse(1, 50.0, 9.0, 1.4)])
                .0
                .unwrap();
            let [x, y, _] = state.position_m;
            [x * cos + y * sin, y * cos - x * sin]
        };
        let (straight, other) = (turned(0.0), turned(0.7));
        for (a, b) in straight.iter().zip(other) {
            assert!((a - b).abs() < 1e-6, "{straight:?} {other:?}");
        }
    }
}
