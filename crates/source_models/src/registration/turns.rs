//! Attribution of a rotation: the frame follows the majority.
//!
//! Problem: sensors of unknown position show rotations relative to each other. Of two sources, either may be turned,
//! and the first comparison decides by chance. A third source then looks turned like the source that was blamed, and
//! the picture stays with the single source that is off.
//!
//! Method: each source votes for a rotation: its own, if its model has one, or the rotation of a source with almost the
//! same displacement of the compared targets, as long as too few comparisons exist for a model of its own. If most
//! sources vote for one rotation, the frame is turned by this rotation. Fits do not change, because the common part of
//! all errors shows in no difference. Two sources alone get half of the rotation each, and the published covariance
//! contains both possibilities.
//!
//! Limits: with a reference source, and with a source known to have no offset, the frame is fixed.

use crate::registration::errors::{SAMPLES_MIN, SourceErrors};
use crate::registration::progress::Vote;
use crate::registration::rows::{AZIMUTH, Errors, NormalMatrix};
use crate::registration::{MAJORITY, Registration};
use crate::settings::SOURCES_MAX;

/// Largest difference of two rotations that count as one, relative to the larger.
const SAME_TURN: f64 = 1.0 / 3.0;
/// Largest squared distance from a turned source, relative to the squared distance from the frame, of a source that
/// agrees with the turned source.
const AGREES_2: f64 = 0.5;
/// Variance per axis of the rotation of the frame by two sources, relative to the mean squared displacement by half the
/// rotation: two sources determine the spread poorly.
const FEW: f64 = 1.5;
/// Least squared statistical length of a displacement that counts as a vote.
const SIGNIFICANT: f64 = 13.8;

impl Registration {
    /// Turns the frame by the rotation that most sources have in common. Returns whether the frame has been turned.
    pub(super) fn turn_to_majority(&mut self) -> bool {
        let (count, votes) = (self.sources.len(), &self.solution.votes);
        // The estimate of a voter may have been dropped since.
        let are_valid = votes
            .iter()
            .zip(&self.sources)
            .all(|(vote, source)| vote.turn().is_none() || is_compared(source));
        if self.reference.is_some() || !are_valid {
            return false;
        }
        let Some(turn) = half(votes).or_else(|| majority(votes)) else {
            return false;
        };
        // The centre of the rotation is free: most of the sources that were turned have no offset.
        let mut offsets = [[0.0; SOURCES_MAX]; 2];
        let mut agreeing = 0;
        for own in 0..count {
            if turn_of(&self.sources[own]).is_some_and(|own_turn| is_same(own_turn, turn)) {
                let offset = self.offset_in_turned_frame(own, turn);
                (offsets[0][agreeing], offsets[1][agreeing]) = (offset[0], offset[1]);
                agreeing += 1;
            }
        }
        let middle = offsets.each_mut().map(|values| median(&mut values[..agreeing]));
        for own in 0..count {
            if let Some(own_turn) = self.solution.votes[own].turn() {
                self.turn(own, (turn, middle), is_same(own_turn, turn));
            }
        }
        true
    }

    /// Returns the offset of a source in a frame turned by `turn` about the origin: the rotation of the frame is a
    /// rotation about the sensor, and an offset.
    fn offset_in_turned_frame(&self, own: usize, turn: f64) -> [f64; 2] {
        let [east_m, north_m] = self.places_m[own].unwrap_or_default();
        let errors = &self.sources[own].errors;
        [errors[0] - turn * north_m, errors[1] + turn * east_m]
    }

    /// Expresses the errors of a source in a frame turned by `turn` about the origin and displaced by `middle`. A
    /// source that `agrees` with the rotation is not turned in this frame.
    fn turn(&mut self, own: usize, (turn, middle): (f64, [f64; 2]), agrees: bool) {
        let offset = self.offset_in_turned_frame(own, turn);
        let source = &mut self.sources[own];
        // The offset without a rotation is a mean over the compared targets. The next solution yields the offset.
        let is_mean = agrees && !source.model.is_polar();
        for axis in 0..2 {
            source.errors[axis] = if is_mean { 0.0 } else { offset[axis] - middle[axis] };
        }
        source.errors[AZIMUTH] = if agrees { 0.0 } else { source.errors[AZIMUTH] - turn };
        source.model = source.model.with_offset(!agrees);
    }

    /// Returns the variance per axis of the rotation of the frame, as far as two sources alone cannot decide which of
    /// them is turned, m².
    pub(super) fn undecided_turn_m2(&self) -> f64 {
        let compared = || (0..self.sources.len()).filter(|own| is_compared(&self.sources[*own]));
        let is_turned = |source: &SourceErrors| turn_of(source).is_some() && source.model.has_offset();
        let is_undecided =
            self.reference.is_none() && compared().count() == 2 && compared().all(|own| is_turned(&self.sources[own]));
        if !is_undecided {
            return 0.0;
        }
        // A source that has just changed has been compared with nothing.
        let squares_m2 = compared().filter_map(|own| self.squared_m2(own));
        FEW * 0.5 * squares_m2.sum::<f64>()
    }

    /// Returns the mean square of the displacement of the compared targets in the plane by the errors of a source, sum
    /// over both axes, m²; `None` without comparisons.
    pub(super) fn squared_m2(&self, own: usize) -> Option<f64> {
        let form = self.form(own);
        let information = 0.5 * (form[(0, 0)] + form[(1, 1)]);
        (information > 0.0).then(|| squared(&form, self.sources[own].errors) / information)
    }

    /// Returns the sum of the normal equations over the partners of a source.
    fn form(&self, own: usize) -> NormalMatrix {
        let sums = self
            .partners_of(own)
            .map(|other| &self.pairs[own * self.sources.len() + other].own);
        sums.fold(NormalMatrix::zeros(), |sum, pair| sum + pair)
    }

    /// Returns the vote of a source by the solution in progress.
    pub(super) fn vote(&self, own: usize) -> Vote {
        let sources = &self.solution.sources;
        if !is_compared(&sources[own]) {
            return Vote::None;
        }
        let own_turn = turn_of(&sources[own]);
        if !sources[own].model.has_offset() {
            return Vote::Fixed(own_turn.unwrap_or(0.0));
        }
        if let Some(turn) = own_turn {
            return Vote::Free(turn);
        }
        if sources.iter().all(|other| turn_of(other).is_none()) {
            return Vote::Free(0.0);
        }
        let (form, errors) = (self.form(own), sources[own].errors);
        let from_frame = squared(&form, errors);
        let turned = sources
            .iter()
            .filter_map(|other| Some((squared(&form, errors - other.errors), turn_of(other)?)));
        let nearest = turned.min_by(|a, b| a.0.total_cmp(&b.0));
        let agrees = |(apart, _): &(f64, f64)| from_frame > SIGNIFICANT && *apart < AGREES_2 * from_frame;
        Vote::Free(nearest.filter(agrees).map_or(0.0, |(_, turn)| turn))
    }
}

fn is_compared(source: &SourceErrors) -> bool {
    source.samples >= SAMPLES_MIN
}

/// Returns the rotation in the model of a compared source, radians.
fn turn_of(source: &SourceErrors) -> Option<f64> {
    (is_compared(source) && source.model.estimates(AZIMUTH)).then_some(source.errors[AZIMUTH])
}

/// Returns the weighted square of the displacement of the compared targets in the plane.
fn squared(form: &NormalMatrix, mut errors: Errors) -> f64 {
    errors[2] = 0.0;
    errors.dot(&(form * errors))
}

/// Returns half the rotation between two sources, if all of it is attributed to one of them, radians.
fn half(votes: &[Vote]) -> Option<f64> {
    let mut given = votes.iter().filter_map(|vote| vote.turn());
    let (one, other) = (given.next()?, given.next()?);
    let are_free = votes.iter().all(|vote| !matches!(vote, Vote::Fixed(_)));
    let is_of_one = (one == 0.0) != (other == 0.0);
    (is_of_one && are_free && given.next().is_none()).then_some(0.5 * (one + other))
}

/// Returns the rotation for which most of the sources vote, radians; `None` if this is the present frame. A source with
/// a rotation about the known position alone would need an offset in another frame, and counts against the rotation.
pub(super) fn majority(votes: &[Vote]) -> Option<f64> {
    let mut free = [0.0; SOURCES_MAX];
    let mut count = 0;
    for turn in votes.iter().filter_map(|vote| vote.free()) {
        free[count] = turn;
        count += 1;
    }
    let free = &mut free[..count];
    let turn = (count > 0).then(|| median(free))?;
    let agreeing = free.iter().filter(|vote| is_same(**vote, turn)).count();
    let all = votes.iter().filter(|vote| vote.turn().is_some()).count();
    (turn != 0.0 && agreeing >= MAJORITY && 2 * agreeing > all).then_some(turn)
}

/// Returns the upper median of values; 0 without values.
fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn is_same(one: f64, turn: f64) -> bool {
    (one - turn).abs() <= SAME_TURN * turn.abs()
}
