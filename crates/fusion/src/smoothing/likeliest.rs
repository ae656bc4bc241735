//! How targets of a recording move: which assumption makes its measurements the likeliest.
//!
//! A filter must expect more than most targets do, because it follows unexpected motion too late. A smoother has both
//! sides of each moment, and the same expectation makes its covariances too large. Of the smoothed velocity three
//! quarters of the variance come from the noise of the motion, of the position one quarter; and turns that are expected
//! too often leave a wide tail.
//!
//! The noise of straight motion and the mean time of straight flight are therefore chosen afterwards, one after the
//! other and from a few factors: the one with which the measurements are the likeliest. A sample of the tracks is used.
//! The noise of turns stays: less of it would be likelier as well, but makes smoothed turns worse, because their rates
//! lie between those of the models.

use super::knowledge::{Knowledge, MotionFactors};
use super::plane::evidence;
use super::stretch::Stretch;
use super::trajectory::Trajectory;

/// Number of inputs that are looked at.
const INPUTS_MAX: usize = 20_000;
/// Factors that are compared.
const STEADY: [f64; 5] = [1.0, 4.0, 0.25, 0.0625, 0.015625];
const STRAIGHT: [f64; 5] = [1.0, 0.5, 2.0, 4.0, 8.0];

/// The likeliest factors; `with` gives the knowledge that contains some.
pub(super) fn likeliest<'a, K: Knowledge>(
    tracks: impl Iterator<Item = &'a Trajectory>,
    with: impl Fn(MotionFactors) -> K,
) -> MotionFactors {
    let stretches = sample(tracks, &with(MotionFactors::ONE));
    if stretches.is_empty() {
        return MotionFactors::ONE;
    }
    let of = |factors: MotionFactors| -> f64 {
        let known = with(factors);
        stretches.iter().map(|stretch| evidence(&known, stretch)).sum()
    };
    let steady = STEADY.map(|steady| MotionFactors {
        steady,
        ..MotionFactors::ONE
    });
    let found = best(steady, of);
    best(STRAIGHT.map(|straight| MotionFactors { straight, ..found }), of)
}

/// The candidate with the greatest evidence; of equal ones the first.
fn best<const N: usize>(candidates: [MotionFactors; N], of: impl Fn(MotionFactors) -> f64) -> MotionFactors {
    let mut found = (f64::NEG_INFINITY, MotionFactors::ONE);
    for factors in candidates {
        let evidence = of(factors);
        if evidence > found.0 {
            found = (evidence, factors);
        }
    }
    found.1
}

/// Stretches of the first tracks, without wanted states.
fn sample<'a>(tracks: impl Iterator<Item = &'a Trajectory>, known: &impl Knowledge) -> Vec<Stretch> {
    let mut stretches = Vec::new();
    let mut inputs = 0;
    for track in tracks {
        for part in track.stretches() {
            let mut part = track.inputs[part].to_vec();
            part.sort_by_key(|input| input.time_ns);
            inputs += part.len();
            stretches.push(Stretch::new(known, &part, &[], None));
        }
        if inputs > INPUTS_MAX {
            break;
        }
    }
    stretches
}
