//! States of other centres, joined with the state of the own sensors.
//!
//! The states of two centres are correlated by an unknown amount if the centres share a sensor: then, and if the
//! contributing sensors are unknown, states are joined by covariance intersection. Without a common sensor, only the
//! target's manoeuvres correlate the states: both filters lag behind the same turns. This part is taken as constant,
//! because neither filter is steady. Other centres may share sensors among themselves, which is never known here:
//! their states are first joined with each other by intersection.
//!
//! A centre's newest state replaces the previous state, and never enters the filter of a target with local sources.
//! The data sent by this deployment therefore come from its own sensors alone, and no data return to the sender, for
//! any topology of centres.

use estimation::{Estimate, INPUTS_MAX, correlated_combination};
use messages::AXES;
use nalgebra::SMatrix;

use super::bar_shalom_campo::block_root;
use super::matrices::{self, Combination};
use super::{Candidate, Share};
use crate::settings::Intersection;
use crate::state::State;

/// Measure minimised by intersection here.
const MEASURE: Intersection = Intersection::Trace;

/// Correlation of the errors of two centres without a common sensor.
///
/// For two like filters with the process noise of the target, the correlation is 1/4 in position and 3/4 in velocity,
/// whatever the noise and the accuracy (steady state in continuous time, white acceleration). Real targets at times
/// turn harder, and both filters then lag by nearly the same. With a half, the errors of simulated centres nearly
/// match the stated accuracy in several worlds, and positions are hardly less exact than with less.
const CORRELATION: f64 = 0.5;

/// Combination of states correlated by manoeuvres only.
struct ManoeuvreCombination;

impl Combination for ManoeuvreCombination {
    fn combine<const D: usize>(&self, inputs: &[Estimate<D>], shares: &mut [f64]) -> Option<Estimate<D>> {
        let mut roots = [SMatrix::<f64, D, D>::zeros(); INPUTS_MAX];
        for (root, input) in roots.iter_mut().zip(inputs) {
            *root = block_root(&input.covariance);
        }
        let cross = |i: usize, j: usize| roots[i] * roots[j].transpose() * CORRELATION;
        correlated_combination(inputs, cross, shares)
    }
}

/// Joins the state of the `own` sensors, if any, with the states of other centres; all are of the same time. Fills the
/// shares of the centres and returns the own share. `shares_none`: the centres and this centre have no sensor in
/// common. `None` if no state can be used.
pub fn join(
    own: Option<&State>,
    centres: &[Candidate],
    shares_none: bool,
    shares: &mut [Share],
) -> Option<(State, f64)> {
    let theirs = matrices::fuse(centres, &MEASURE, shares)?;
    let Some(own) = own else {
        return Some((theirs, 0.0));
    };
    let both = [*own, theirs].map(|state| Candidate {
        state,
        ..Candidate::default()
    });
    let mut halves = [Share::default(); 2];
    let joined = if shares_none {
        matrices::fuse(&both, &ManoeuvreCombination, &mut halves)
    } else {
        matrices::fuse(&both, &MEASURE, &mut halves)
    }?;
    for share in shares {
        for axis in 0..AXES {
            share.weight[axis] *= halves[1].weight[axis];
        }
    }
    Some((joined, halves[0].weight[0]))
}
