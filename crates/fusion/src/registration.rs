//! Registration: systematic errors of the sources, from targets that several of them see (BF-3).
//!
//! A radar whose north mark is a tenth of a degree off puts every target at 60 km 100 m aside; a source whose clock is
//! late drags every target behind itself. Such errors do not average out, but they show: two sources that see the same
//! target differ by the difference of their errors. With θ = (offset east, north, up; time offset; range bias; azimuth
//! bias) of a source, and H(target) how they move its report, a pair of reports of one target at one time gives
//!
//! Δ = x_j − x_k = H_j·θ_j − H_k·θ_k + noise.
//!
//! For every pair of sources the normal equations of this are summed up, with slow forgetting; at every tick a few
//! sweeps of block Gauss–Seidel solve them for all sources together. Only differences can be seen: either a named
//! reference source is taken as true, or the middle of all sources is. That is their geometric median: of three of
//! which two agree it is the third that is off.
//!
//! Where targets all fly one way, a time offset cannot be told from a place, nor is it known of two sources which is
//! late. The times of receipt tell: a clock that is off by them has its offset as prior, and the middle is a median in
//! which such a source weighs less.
//!
//! Errors may change. Where the latest differences show that the estimate lags behind, those of the last seconds alone
//! count, until it has caught up. What they still leave over goes into the published covariances, as do offsets that
//! are not removed, and the error of the middle itself, which nobody can see.
//!
//! Sixty-four sources that all see the same targets make four thousand pairs, a millisecond's work, and no report shall
//! wait that long. So a solution is worked out in steps of bounded work, and what is known of the sources changes when
//! it is complete. For four sources one step is enough.
//!
//! The tracks' errors are correlated in time, and targets do not show the same point to all sources: both make the
//! estimate less certain than the formula says. A sample counts for a quarter, and the spread of the detection points,
//! divided by the number of targets, is added. An error is removed when it is significant, until it no longer is.
//!
//! One source's absurd reports must not spoil what is known of the others. Reports whose velocities are far apart are
//! not compared, and an estimate beyond reason, or one that most differences contradict, is dropped with all that it
//! rests on.
//!
//! Limits: range and azimuth biases need the sensor's place; over a small area they cannot be told from an offset.
//!
//! Source: Y. Bar-Shalom, P. Willett, X. Tian, *Tracking and Data Fusion* (YBS, 2011), chapter 9, for the model.

mod errors;
pub(crate) mod settings;

use std::ops::Range;

use kept::kept;
use messages::AXES;
use nalgebra::{Cholesky, Const, SMatrix, SVector};
use serde::{Deserialize, Serialize};

use crate::drift::{DRIFT_S, Residuals};
use crate::registration::errors::{ERROR_MAX_SIGMA, PRIOR_SIGMA, TIME, clock_of, sensitivity};
use crate::source_ref::SOURCES_MAX;

pub(crate) use crate::registration::errors::{ClockError, View};
pub use crate::registration::errors::{ERRORS, Errors, SourceErrors};

type Block = SMatrix<f64, ERRORS, ERRORS>;

/// Velocities of one target do not differ by more, metres per second.
const VELOCITY_GATE_MPS: f64 = 300.0;
/// Weight of one sample: errors of tracks persist over several reports.
const SAMPLE_WEIGHT: f64 = 0.25;
/// Sweeps of Gauss–Seidel per tick.
const SWEEPS: usize = 4;
/// Work of one step of a solution, in visits to pairs: some ten microseconds. The source begun last is finished.
const STEP_WORK: usize = 192;
/// Work of factoring the equations of a source, and of solving them, in such visits.
const FACTOR_WORK: usize = 16;
const SOLVE_WORK: usize = 4;
/// Chi-square with two degrees of freedom beyond which a horizontal offset is removed, and below which it is no longer.
const SIGNIFICANT_2: f64 = 13.8;
const INSIGNIFICANT_2: f64 = 2.8;
/// Chi-square with one degree of freedom, likewise, for the other errors.
const SIGNIFICANT_1: f64 = 10.8;
const INSIGNIFICANT_1: f64 = 1.6;
/// Samples of a source before any of its errors is removed.
const SAMPLES_MIN: f64 = 20.0;
/// Largest squared statistical length of a difference that is used.
const DIFFERENCE_GATE: f64 = 25.0;
/// Largest variance per axis by which different points of one target explain a difference, m², when it is asked whether
/// an estimate is wrong: so that it cannot hide behind targets that seem ever larger.
const POINTS_MAX_M2: f64 = 100.0 * 100.0;
/// Share of the latest differences beyond either at which it is the estimate that is wrong, and the weight of one of
/// them.
const CONTRADICTED: f64 = 0.75;
const CONTRADICTION_GAIN: f64 = 1.0 / 64.0;

kept! {
    /// Sums over one ordered pair of sources, seen from the first.
    #[derive(Clone, Copy, Debug, Serialize, Deserialize)]
    pub(crate) struct Pair {
        /// Σ HⱼᵀWHⱼ.
        own: Block,
        /// Σ HⱼᵀWHₖ.
        cross: Block,
        /// Σ HⱼᵀWΔ.
        right: Errors,
    }
}

const EMPTY: Pair = Pair {
    own: Block::from_array_storage(nalgebra::ArrayStorage([[0.0; ERRORS]; ERRORS])),
    cross: Block::from_array_storage(nalgebra::ArrayStorage([[0.0; ERRORS]; ERRORS])),
    right: Errors::from_array_storage(nalgebra::ArrayStorage([[0.0; ERRORS]; 1])),
};

kept! {
    /// Part of one source's errors that a checkpoint keeps, beside the [`Pair`]s.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct KeptErrors {
        known: SourceErrors,
        partners: u64,
        contradicted: f64,
    }
}

/// Registration of all sources with each other.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Registration {
    sources: Vec<SourceErrors>,
    pairs: Vec<Pair>,
    /// Sources with which each source was compared, as bits.
    partners: Vec<u64>,
    /// Share of each source's latest differences that its estimate does not explain.
    contradicted: Vec<f64>,
    reference: Option<u16>,
    /// Latest differences of each source that the estimates leave over.
    rests: Vec<Residuals>,
    /// Share of the sums that is left after one tick, and of those of sources that drift.
    keep: f64,
    keep_drifting: f64,
    solution: Solution,
}

/// A solution that is being worked out.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Solution {
    /// Sweep and source that come next; `None` if nothing is being worked out.
    next: Option<(usize, usize)>,
    sources: Vec<SourceErrors>,
    /// Factored normal equations of each source, from the first sweep on.
    factors: Vec<Option<Cholesky<f64, Const<ERRORS>>>>,
}

impl Registration {
    /// Of `sources` sources; `reference` is taken as true. Sums are forgotten with time constant `memory_s`; a tick is
    /// `tick_s` seconds.
    pub(crate) fn new(sources: usize, reference: Option<u16>, memory_s: f64, tick_s: f64) -> Self {
        let unknown = SourceErrors::unknown();
        Self {
            pairs: vec![EMPTY; sources * sources],
            partners: vec![0; sources],
            contradicted: vec![0.0; sources],
            rests: vec![Residuals::default(); sources],
            reference,
            keep: (-tick_s / memory_s).exp(),
            keep_drifting: (-tick_s / DRIFT_S.min(memory_s)).exp(),
            solution: Solution {
                next: None,
                sources: vec![unknown; sources],
                factors: vec![None; sources],
            },
            sources: vec![unknown; sources],
        }
    }

    /// Part that a checkpoint keeps, of the source with this number.
    pub(crate) fn kept(&self, source: usize) -> KeptErrors {
        KeptErrors {
            known: self.sources[source],
            partners: self.partners[source],
            contradicted: self.contradicted[source],
        }
    }

    /// Goes on with what was kept of a source.
    pub(crate) fn resume(&mut self, source: usize, kept: &KeptErrors) {
        self.sources[source] = kept.known;
        self.partners[source] = kept.partners;
        self.contradicted[source] = kept.contradicted;
    }

    /// The sums over each ordered pair of sources.
    pub(crate) fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Goes on with the sums that were kept of the pair at this place.
    pub(crate) fn resume_pair(&mut self, place: usize, kept: Pair) {
        self.pairs[place] = kept;
    }

    /// Errors of `source`, as far as they are known.
    pub(crate) fn of(&self, source: u16) -> &SourceErrors {
        &self.sources[usize::from(source)]
    }

    /// By how much the errors that are being removed have moved a report of `source`, metres.
    pub(crate) fn shift(
        &self,
        source: u16,
        position_m: [f64; AXES],
        velocity_mps: [f64; AXES],
        place_m: Option<[f64; 2]>,
    ) -> [f64; AXES] {
        let known = self.of(source);
        if known.removed == [false; ERRORS] {
            return [0.0; AXES];
        }
        let removed = Errors::from_fn(|row, _| if known.removed[row] { known.errors[row] } else { 0.0 });
        (sensitivity(position_m, velocity_mps, place_m) * removed).into()
    }

    /// By how much, as far as is known, the errors that are *not* being removed move a report: estimated, not yet
    /// significant.
    pub(crate) fn suspected_shift(&self, source: u16) -> [f64; 2] {
        let known = self.of(source);
        std::array::from_fn(|axis| if known.removed[axis] { 0.0 } else { known.errors[axis] })
    }

    /// Variance per axis of what systematic errors do to a state that all sources contribute to, m²: of what their
    /// horizontal offsets have in common, and of what is not removed.
    pub(crate) fn common_error_m2(&self) -> f64 {
        self.common_offset_m2() + self.left_over_m2()
    }

    /// Variance per axis of what the horizontal offsets of all sources have in common, m²: it shows in no difference,
    /// but where the offsets lie far apart their middle is hardly 0. None where a source is taken as true. Few offsets
    /// tell badly how far they lie apart: beforehand, as much is known of it as two more would tell.
    fn common_offset_m2(&self) -> f64 {
        let (mut sum, mut total, mut count) = (0.0, 0.0, 0.0);
        for known in self.sources.iter().filter(|known| known.samples >= SAMPLES_MIN) {
            let weight = known.closeness(0..2);
            sum += weight * weight * known.excess_m2();
            total += weight;
            count += 1.0;
        }
        if self.reference.is_some() || count < 2.0 {
            return 0.0;
        }
        let few = (count + 1.0) * count / ((count - 1.0) * (count - 1.0));
        (few * sum / (total * total)).max(0.0)
    }

    /// Mean square per axis of what is not removed of the sources' horizontal offsets, m²: it is not significant yet,
    /// or has drifted away from the estimate.
    fn left_over_m2(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (known, rest) in self.sources.iter().zip(&self.rests) {
            if known.samples >= SAMPLES_MIN {
                sum += if known.removed[0] { 0.0 } else { known.excess_m2() } + rest.drift_m2();
                count += 1.0;
            }
        }
        if count < 2.0 { 0.0 } else { (sum / count).max(0.0) }
    }

    /// Learns from two views of one target at one time, of which the sources see points that lie apart with this
    /// variance per axis, m².
    pub(crate) fn learn(&mut self, a: &View, b: &View, points_m2: f64) {
        let apart_mps = |axis: usize| a.velocity_mps[axis] - b.velocity_mps[axis];
        let apart_m = |axis: usize| a.position_m[axis] - b.position_m[axis];
        // Written so that NaN is refused.
        let may_be_one = apart_mps(0).hypot(apart_mps(1)) <= VELOCITY_GATE_MPS
            && apart_m(0).hypot(apart_m(1)) <= ERROR_MAX_SIGMA * PRIOR_SIGMA[0];
        if !may_be_one {
            return;
        }
        let three = a.has_height && b.has_height;
        let axes = if three { AXES } else { 2 };
        let difference = SVector::<f64, AXES>::from_fn(|axis, _| {
            if axis < axes {
                a.position_m[axis] - b.position_m[axis]
            } else {
                0.0
            }
        });
        let mut weight = a.covariance_m2 + b.covariance_m2;
        let stated_m2 = weight[(0, 0)] + weight[(1, 1)];
        for axis in 0..2 {
            weight[(axis, axis)] += points_m2;
        }
        if !three {
            for axis in 0..2 {
                weight[(axis, 2)] = 0.0;
                weight[(2, axis)] = 0.0;
            }
            weight[(2, 2)] = 1e12;
        }
        // One target has one velocity. So what all clocks have in common shows in no difference, and the solution does
        // not run away when it is taken off.
        let velocity_mps = std::array::from_fn(|axis| 0.5 * (a.velocity_mps[axis] + b.velocity_mps[axis]));
        let (of_a, of_b) = (a.sensitivity(velocity_mps), b.sensitivity(velocity_mps));
        let explained = of_a * self.of(a.source).errors - of_b * self.of(b.source).errors;
        let Some(weight) = weight.cholesky().map(|factor| factor.inverse()) else {
            return;
        };
        let rest = difference - explained;
        let squared = (rest.transpose() * weight * rest)[0];
        // While little is known, large errors must be let in.
        let settled = self.of(a.source).samples > SAMPLES_MIN && self.of(b.source).samples > SAMPLES_MIN;
        if !squared.is_finite() {
            return;
        }
        let explained_m2 = DIFFERENCE_GATE * (stated_m2 + 2.0 * points_m2.min(POINTS_MAX_M2));
        let is_too_far = rest[0] * rest[0] + rest[1] * rest[1] > explained_m2;
        let is_contradicted = settled && (squared > DIFFERENCE_GATE || is_too_far);
        for source in [a.source, b.source] {
            let share = &mut self.contradicted[usize::from(source)];
            *share += CONTRADICTION_GAIN * (f64::from(u8::from(is_contradicted)) - *share);
        }
        if is_contradicted {
            return;
        }
        let weight = weight * SAMPLE_WEIGHT;
        self.rests[usize::from(a.source)].add(&weight, [rest[0], rest[1]]);
        self.rests[usize::from(b.source)].add(&weight, [-rest[0], -rest[1]]);
        self.add(
            a.source,
            b.source,
            &(of_a.transpose() * weight),
            &of_a,
            &of_b,
            &difference,
        );
        self.add(
            b.source,
            a.source,
            &(of_b.transpose() * weight),
            &of_b,
            &of_a,
            &-difference,
        );
    }

    fn add(
        &mut self,
        own: u16,
        other: u16,
        weighted: &SMatrix<f64, ERRORS, AXES>,
        of_own: &SMatrix<f64, AXES, ERRORS>,
        of_other: &SMatrix<f64, AXES, ERRORS>,
        difference: &SVector<f64, AXES>,
    ) {
        let count = self.sources.len();
        let pair = &mut self.pairs[usize::from(own) * count + usize::from(other)];
        pair.own += weighted * of_own;
        pair.cross += weighted * of_other;
        pair.right += weighted * difference;
        self.partners[usize::from(own)] |= 1 << other;
        self.sources[usize::from(own)].samples += 1.0;
    }

    /// Begins to solve for all sources, once per tick; does nothing while that is still being done.
    pub(crate) fn begin(&mut self) {
        if self.is_solving() {
            return;
        }
        let keep = self.keep.powf(1.0 / SWEEPS as f64);
        for source in &mut self.sources {
            for _ in 0..SWEEPS {
                source.samples *= keep;
            }
        }
        for rest in &mut self.rests {
            rest.look(self.keep_drifting);
        }
        self.solution.sources.copy_from_slice(&self.sources);
        self.solution.next = Some((0, 0));
    }

    /// Whether a solution has begun and not been completed.
    pub(crate) fn is_solving(&self) -> bool {
        self.solution.next.is_some()
    }

    /// Goes on with the solution; whether that has completed it. Then [`Self::decide`] is due. What was learned of a
    /// source whose errors are beyond reason is dropped, and the source given to `restarted`. `clocks` are the errors
    /// of the sources' clocks by the times of receipt.
    pub(crate) fn step(&mut self, clocks: &[ClockError], mut restarted: impl FnMut(u16)) -> bool {
        let Some((mut sweep, mut own)) = self.solution.next.take() else {
            return false;
        };
        let mut work = 0;
        while sweep < SWEEPS {
            if work >= STEP_WORK {
                self.solution.next = Some((sweep, own));
                return false;
            }
            if sweep == 0 {
                self.forget_and_factor(own, clock_of(clocks, own));
                work += FACTOR_WORK;
            }
            work += SOLVE_WORK + self.partners[own].count_ones() as usize;
            self.solve(own, clock_of(clocks, own));
            own += 1;
            if own == self.sources.len() {
                self.fix_gauge(clocks);
                (sweep, own) = (sweep + 1, 0);
            }
        }
        for own in 0..self.sources.len() {
            let solved = self.solution.sources[own];
            if solved.are_possible() && self.contradicted[own] <= CONTRADICTED {
                (self.sources[own].errors, self.sources[own].variances) = (solved.errors, solved.variances);
            } else {
                self.forget(own);
                restarted(own as u16);
            }
        }
        true
    }

    /// Drops all that was learned of a source.
    pub(crate) fn forget(&mut self, own: usize) {
        let count = self.sources.len();
        for other in partners(self.partners[own]) {
            self.pairs[own * count + other] = EMPTY;
            self.pairs[other * count + own] = EMPTY;
            self.partners[other] &= !(1 << own);
        }
        self.partners[own] = 0;
        self.contradicted[own] = 0.0;
        self.rests[own] = Residuals::default();
        self.sources[own] = SourceErrors::unknown();
    }

    /// Lets the sums of one source fade by one tick, and factors the normal equations they make.
    fn forget_and_factor(&mut self, own: usize, clock: ClockError) {
        let count = self.sources.len();
        let mut normal = Block::from_diagonal(&Errors::from_fn(|row, _| 1.0 / (PRIOR_SIGMA[row] * PRIOR_SIGMA[row])));
        normal[(TIME, TIME)] = clock.prior().0;
        for other in partners(self.partners[own]) {
            let pair = &mut self.pairs[own * count + other];
            let drifts = self.rests[own].is_drift() || self.rests[other].is_drift();
            let keep = if drifts { self.keep_drifting } else { self.keep };
            pair.own *= keep;
            pair.cross *= keep;
            pair.right *= keep;
            normal += pair.own;
        }
        let is_sought = self.reference != Some(own as u16) && self.sources[own].samples != 0.0;
        let factor = if is_sought { normal.cholesky() } else { None };
        if let Some(factor) = &factor {
            self.solution.sources[own].variances = factor.inverse().diagonal();
        }
        self.solution.factors[own] = factor;
    }

    /// Solves for the errors of one source, those of the others given.
    fn solve(&mut self, own: usize, clock: ClockError) {
        let Some(factor) = &self.solution.factors[own] else {
            return;
        };
        let count = self.sources.len();
        let mut right = Errors::zeros();
        let (information, offset_s) = clock.prior();
        right[TIME] = information * offset_s;
        for other in partners(self.partners[own]) {
            let pair = &self.pairs[own * count + other];
            right += pair.right + pair.cross * self.solution.sources[other].errors;
        }
        self.solution.sources[own].errors = factor.solve(&right);
    }

    /// Without a reference the middle of all sources that are compared is taken as true: their geometric median, which
    /// a single one that is far off hardly moves. A step towards it (Weiszfeld) is made at every sweep.
    fn fix_gauge(&mut self, clocks: &[ClockError]) {
        if self.reference.is_some() {
            return;
        }
        let is_any_off = clocks.iter().any(|clock| clock.excess_s > 0.0);
        // Range and azimuth biases are seen absolutely, from different places.
        for rows in [0..2, 2..3, TIME..TIME + 1] {
            let middle = match is_any_off {
                true => self.median_by_clocks(rows.clone(), clocks),
                false => self.step_to_median(rows.clone()),
            };
            for source in self.solution.sources.iter_mut().filter(|source| source.samples > 0.0) {
                for row in rows.clone() {
                    source.errors[row] -= middle[row];
                }
            }
        }
    }

    /// A step from 0 towards the geometric median of the sources that are compared.
    fn step_to_median(&self, rows: Range<usize>) -> Errors {
        let mut total = 0.0;
        let mut middle = Errors::zeros();
        for source in self.solution.sources.iter().filter(|source| source.samples > 0.0) {
            let weight = source.closeness(rows.clone());
            total += weight;
            middle += source.errors * weight;
        }
        if total > 0.0 { middle / total } else { Errors::zeros() }
    }

    /// The median of each error over the sources that are compared, in which those whose clocks are off weigh less.
    fn median_by_clocks(&self, rows: Range<usize>, clocks: &[ClockError]) -> Errors {
        let mut middle = Errors::zeros();
        for row in rows {
            let mut values = [(0.0, 0.0); SOURCES_MAX];
            let (mut count, mut total) = (0, 0.0);
            for (own, source) in self.solution.sources.iter().enumerate() {
                if source.samples > 0.0 {
                    let weight = 1.0 / (1.0 + clock_of(clocks, own).excess_s);
                    values[count] = (source.errors[row], weight);
                    (count, total) = (count + 1, total + weight);
                }
            }
            let values = &mut values[..count];
            values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            middle[row] = weighted_median(values, total);
        }
        middle
    }

    /// Decides which errors are significant, once a solution is complete. `known` says for which sources the spread is
    /// known, so that one can decide; `spread_m2` is the variance of the detection points on the targets, `targets` how
    /// many targets several sources see; `points` whether the detection points are known to lie far apart.
    pub(crate) fn decide(
        &mut self,
        clocks: &[ClockError],
        known: impl Fn(usize) -> bool,
        spread_m2: f64,
        targets: usize,
        points: bool,
    ) {
        for own in 0..self.sources.len() {
            let is_clock_off = clock_of(clocks, own).excess_s > 0.0;
            if known(own) || is_clock_off {
                self.decide_for(own, spread_m2 / targets.max(1) as f64, points && !is_clock_off);
            }
        }
    }

    /// Which errors of a source are significant: the horizontal offset as one, the others each for itself. `spread_m2`
    /// is the variance that the detection points add to a mean over all targets.
    ///
    /// Where detection points are far apart, one that lies ahead of the others looks like a clock that is fast: then
    /// time offsets are left alone, unless the times of receipt show the same.
    fn decide_for(&mut self, own: usize, spread_m2: f64, points: bool) {
        let known = &mut self.sources[own];
        let enough = known.samples >= SAMPLES_MIN;
        let squared = |row: usize, extra: f64| known.errors[row] * known.errors[row] / (known.variances[row] + extra);
        let horizontal = squared(0, spread_m2) + squared(1, spread_m2);
        let time = if points { 0.0 } else { squared(3, 0.0) };
        let values = [
            horizontal,
            horizontal,
            squared(2, 0.0),
            time,
            squared(4, spread_m2),
            squared(5, 0.0),
        ];
        for (row, (removed, value)) in known.removed.iter_mut().zip(values).enumerate() {
            let limit = match (row < 2, *removed) {
                (true, false) => SIGNIFICANT_2,
                (true, true) => INSIGNIFICANT_2,
                (false, false) => SIGNIFICANT_1,
                (false, true) => INSIGNIFICANT_1,
            };
            *removed = enough && value > limit;
        }
    }
}

/// The median of values with weights, of this total, in rising order: between two where it lies between them; 0 of
/// none.
fn weighted_median(values: &[(f64, f64)], total: f64) -> f64 {
    let mut before = 0.0;
    let reaches_half = |(_, weight): &(f64, f64)| {
        before += weight;
        before >= 0.5 * total
    };
    let Some(lower) = values.iter().position(reaches_half) else {
        return 0.0;
    };
    let upper = if before == 0.5 * total { lower + 1 } else { lower };
    let value = |place: usize| values.get(place).unwrap_or(&values[lower]).0;
    0.5 * (value(lower) + value(upper))
}

/// The sources that `bits` names, in the order of their numbers.
fn partners(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let source = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (source < u64::BITS as usize).then_some(source)
    })
}

#[cfg(test)]
#[path = "registration_tests.rs"]
mod tests;
