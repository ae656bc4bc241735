//! Motion of targets of a recording: selection of the likeliest assumption for the measurements.
//!
//! A filter must expect more motion than most targets have, because a filter follows unexpected motion too late. A
//! smoother has both sides of each moment, and the same expectation makes its covariances too large. The noise of the
//! motion accounts for three quarters of the variance of the smoothed velocity, and for a quarter of the variance of
//! the position. Too frequent expected turns leave a wide tail.
//!
//! The noise of straight motion and the mean time of straight flight are therefore chosen afterwards, one after the
//! other, from a few factors: the factor with the likeliest measurements. A sample of the tracks is used. The noise of
//! turns stays: a smaller noise would be likelier as well, but makes smoothed turns worse, because real turn rates lie
//! between the rates of the models.

use super::knowledge::{Knowledge, MotionFactors};
use super::plane::evidence;
use super::stretch::Stretch;
use super::trajectory::Trajectory;

/// Number of inputs in the sample.
const INPUTS_MAX: usize = 20_000;
/// Factors compared with 1.
const STEADY: [f64; 4] = [4.0, 0.25, 0.0625, 0.015625];
const STRAIGHT: [f64; 4] = [0.5, 2.0, 4.0, 8.0];

/// The likeliest factors; `with` gives the knowledge for given factors.
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
    let one = MotionFactors::ONE;
    let known = (of(one), one);
    let steady = STEADY.map(|steady| MotionFactors { steady, ..one });
    let (evidence, found) = best(known, steady, of);
    let straight = STRAIGHT.map(|straight| MotionFactors { straight, ..found });
    best((evidence, found), straight, of).1
}

/// The factors with the greatest evidence, among those `known` so far with theirs, and candidates; among equal ones the
/// first.
fn best<const N: usize>(
    known: (f64, MotionFactors),
    candidates: [MotionFactors; N],
    of: impl Fn(MotionFactors) -> f64,
) -> (f64, MotionFactors) {
    let mut found = known;
    for factors in candidates {
        let evidence = of(factors);
        if evidence > found.0 {
            found = (evidence, factors);
        }
    }
    found
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
