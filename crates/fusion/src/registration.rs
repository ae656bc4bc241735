//! Registration: estimates the systematic errors of the sources from targets that several sources observe (BF-3).
//!
//! A north mark that is off by a tenth of a degree moves every target at 60 km range aside by 100 m. A source whose
//! clock is late drags every target behind. Such errors do not average out, but they are observable: two sources that
//! observe the same target differ by the difference of their errors. Let θ = (offset east, north, up; time offset;
//! range bias; azimuth bias) be the errors of a source, and H(target) their effect on its report. A pair of reports
//! of one target at one time gives
//!
//! Δ = x_j − x_k = H_j·θ_j − H_k·θ_k + noise.
//!
//! The normal equations of this model are summed for every pair of sources, with slow forgetting. At every tick a few
//! sweeps of block Gauss–Seidel solve the equations for all sources together. Only differences are observable, so a
//! reference is needed: either a configured reference source is taken as true, or the geometric median of all sources
//! is. If two of three sources agree, the median attributes the error to the third.
//!
//! If all targets move in one direction, a time offset is indistinguishable from a position offset. With two sources
//! the late clock is undetermined as well. Times of receipt resolve both cases: a clock that deviates from them gets
//! its offset as prior, and its source weighs less in the median.
//!
//! Errors may change. If the latest differences show that the estimate lags, only the differences of the last seconds
//! count until the estimate has caught up. The published covariances include the remaining differences, the offsets
//! that are not removed, and the unobservable error of the median itself.
//!
//! Sixty-four sources that all observe the same targets form four thousand pairs, a millisecond of work. No report
//! may wait that long, so a solution proceeds in steps of bounded work, and the estimates change once it is complete.
//! Four sources need a single step.
//!
//! Two effects make the estimate less certain than the formula: the errors of a track are correlated in time, and the
//! sources detect different points of a target. Therefore a sample counts for a quarter, and the variance of the
//! detection points, divided by the number of targets, is added. An error is removed from the reports once it is
//! significant, until it becomes insignificant.
//!
//! Absurd reports of one source must not spoil the estimates of the others. Reports with widely different velocities
//! are not compared. An estimate that is out of bounds, or that most differences contradict, is dropped together with
//! the sums behind it.
//!
//! An azimuth error, a range error and an offset look alike over a small area. Which of them a source has is decided by
//! evidence (module `model`). A sensor whose position is not known gets a rotation and a shift instead.
//!
//! Source: Y. Bar-Shalom, P. Willett, X. Tian, *Tracking and Data Fusion* (YBS, 2011), chapter 9, for the model.

mod errors;
mod model;
pub(crate) mod settings;

use std::ops::Range;

use kept::kept;
use messages::AXES;
use nalgebra::{Cholesky, Const, SMatrix, SVector};
use serde::{Deserialize, Serialize};

use crate::drift::{DRIFT_S, Residuals};
use crate::registration::errors::{AZIMUTH, ERROR_MAX_SIGMA, PRIOR_SIGMA, RANGE, TIME, clock_of, sensitivity};
use crate::registration::model::Model;
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
/// Work of one step of a solution, in visits to pairs: about ten microseconds. The source in progress is completed.
const STEP_WORK: usize = 192;
/// Work of factoring the equations of a source, and of solving them, in visits to pairs.
const FACTOR_WORK: usize = 16;
const SOLVE_WORK: usize = 4;
/// Work of comparing the models of a source, likewise.
const SELECT_WORK: usize = 64;
/// Chi-square with two degrees of freedom above which a horizontal offset is removed, and below which removal stops.
const SIGNIFICANT_2: f64 = 13.8;
const INSIGNIFICANT_2: f64 = 2.8;
/// Chi-square with one degree of freedom, likewise, for the other errors.
const SIGNIFICANT_1: f64 = 10.8;
const INSIGNIFICANT_1: f64 = 1.6;
/// Samples of a source before any of its errors is removed.
const SAMPLES_MIN: f64 = 20.0;
/// Samples of a source before other sources' models are judged by comparison with it.
const SETTLED_MIN: f64 = 2.0 * SAMPLES_MIN;
/// Largest squared statistical length of a difference that is used.
const DIFFERENCE_GATE: f64 = 25.0;
/// Largest variance per axis with which detection points may explain a difference, m², in the check for a wrong
/// estimate. The bound prevents a wrong estimate from passing as ever larger targets.
const POINTS_MAX_M2: f64 = 100.0 * 100.0;
/// Weight of one difference in the mean of their squares, and the largest mean that a clear error may have caused.
const FIT_GAIN: f64 = 1.0 / 64.0;
const FIT_MAX: f64 = 12.0;
/// Share of contradicting differences at which the estimate is dropped, and the weight of one difference.
const CONTRADICTED: f64 = 0.75;
const CONTRADICTION_GAIN: f64 = 1.0 / 64.0;

kept! {
    /// Sums over one ordered pair of sources, from the view of the first.
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
        fit: f64,
    }
}

/// Registration of all sources against each other.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Registration {
    sources: Vec<SourceErrors>,
    pairs: Vec<Pair>,
    /// Sources with which each source has been compared, as bits.
    partners: Vec<u64>,
    /// Share of each source's latest differences that contradict its estimate.
    contradicted: Vec<f64>,
    /// Mean square of each source's latest differences, as the estimate leaves them, per axis and relative to what is
    /// expected.
    fits: Vec<f64>,
    reference: Option<u16>,
    /// Whether the position of each sensor is known.
    has_place: Vec<bool>,
    /// Latest differences of each source that the estimates leave over.
    rests: Vec<Residuals>,
    /// Share of the sums that is left after one tick, and of those of sources that drift.
    keep: f64,
    keep_drifting: f64,
    solution: Solution,
}

/// A solution in progress.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Solution {
    /// Next sweep and source; `None` if no solution is in progress.
    next: Option<(usize, usize)>,
    sources: Vec<SourceErrors>,
    /// Factored normal equations of each source, set in the first sweep.
    factors: Vec<Option<Cholesky<f64, Const<ERRORS>>>>,
    /// Change of a model that raises the evidence most, and by how much.
    best: Option<(f64, usize, Model)>,
}

impl Registration {
    /// Creates the registration of `sources` sources; `reference` is taken as true. Sums decay with time constant
    /// `memory_s`; a tick is `tick_s` seconds.
    pub(crate) fn new(sources: usize, reference: Option<u16>, memory_s: f64, tick_s: f64) -> Self {
        let unknown = SourceErrors::unknown();
        Self {
            pairs: vec![EMPTY; sources * sources],
            partners: vec![0; sources],
            contradicted: vec![0.0; sources],
            fits: vec![1.0; sources],
            has_place: vec![false; sources],
            rests: vec![Residuals::default(); sources],
            reference,
            keep: (-tick_s / memory_s).exp(),
            keep_drifting: (-tick_s / DRIFT_S.min(memory_s)).exp(),
            solution: Solution {
                next: None,
                sources: vec![unknown; sources],
                factors: vec![None; sources],
                best: None,
            },
            sources: vec![unknown; sources],
        }
    }

    /// Returns the part of a source's state for the checkpoint.
    pub(crate) fn kept(&self, source: usize) -> KeptErrors {
        KeptErrors {
            known: self.sources[source],
            partners: self.partners[source],
            contradicted: self.contradicted[source],
            fit: self.fits[source],
        }
    }

    /// Resumes from the stored state of a source.
    pub(crate) fn resume(&mut self, source: usize, kept: &KeptErrors) {
        self.sources[source] = kept.known;
        self.partners[source] = kept.partners;
        self.contradicted[source] = kept.contradicted;
        self.fits[source] = kept.fit;
    }

    /// Returns the sums over each ordered pair of sources.
    pub(crate) fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Resumes from the stored sums of the pair at this index.
    pub(crate) fn resume_pair(&mut self, place: usize, kept: Pair) {
        self.pairs[place] = kept;
    }

    /// Returns the estimated errors of `source`.
    pub(crate) fn of(&self, source: u16) -> &SourceErrors {
        &self.sources[usize::from(source)]
    }

    /// Returns the displacement of a report of `source` that the removed errors cause, metres.
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

    /// Returns the estimated horizontal displacement by errors that are *not* removed, as they are not significant
    /// yet, metres.
    pub(crate) fn suspected_shift(&self, source: u16) -> [f64; 2] {
        let known = self.of(source);
        std::array::from_fn(|axis| if known.removed[axis] { 0.0 } else { known.errors[axis] })
    }

    /// Returns the variance per axis of the systematic error of a state to which all sources contribute, m². The sum
    /// contains the common part of the horizontal offsets and the part that is not removed.
    pub(crate) fn common_error_m2(&self) -> f64 {
        self.common_offset_m2() + self.left_over_m2()
    }

    /// Returns the variance per axis of the common part of the horizontal offsets, m²; 0 if a reference source is
    /// taken as true. The common part shows in no difference, but if the offsets lie far apart, their median is
    /// hardly 0. Few offsets determine their spread poorly, so the variance is enlarged by `(n + 1)·n / (n − 1)²`.
    fn common_offset_m2(&self) -> f64 {
        let (mut sum, mut total, mut count) = (0.0, 0.0, 0.0);
        let is_of_offset = |known: &&SourceErrors| known.samples >= SAMPLES_MIN && !known.model.is_polar();
        for known in self.sources.iter().filter(is_of_offset) {
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

    /// Returns the mean square per axis of the horizontal offsets that are not removed, m²: not significant yet, or
    /// drifted away from the estimate.
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

    /// Learns from two views of one target at one time; `points_m2` is the variance per axis between the detected
    /// points, m².
    pub(crate) fn learn(&mut self, a: &View, b: &View, points_m2: f64) {
        let apart_mps = |axis: usize| a.velocity_mps[axis] - b.velocity_mps[axis];
        let apart_m = |axis: usize| a.position_m[axis] - b.position_m[axis];
        // Written so that NaN is rejected.
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
        // One velocity for both views: a common part of all clock errors then shows in no difference, and the
        // solution does not run away when the part is subtracted.
        let velocity_mps = std::array::from_fn(|axis| 0.5 * (a.velocity_mps[axis] + b.velocity_mps[axis]));
        let (of_a, of_b) = (a.sensitivity(velocity_mps), b.sensitivity(velocity_mps));
        let explained = of_a * self.of(a.source).errors - of_b * self.of(b.source).errors;
        let Some(weight) = weight.cholesky().map(|factor| factor.inverse()) else {
            return;
        };
        let rest = difference - explained;
        let squared = (rest.transpose() * weight * rest)[0];
        // Before enough samples exist, large errors must pass.
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
            let fit = &mut self.fits[usize::from(source)];
            *fit += FIT_GAIN * ((squared / axes as f64).min(FIT_MAX) - *fit);
        }
        for view in [a, b] {
            self.has_place[usize::from(view.source)] = view.place_m.is_some();
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

    /// Begins a solution for all sources, once per tick; does nothing while a solution is in progress.
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
        self.solution.best = None;
        self.solution.next = Some((0, 0));
    }

    /// Returns whether a solution is in progress.
    pub(crate) fn is_solving(&self) -> bool {
        self.solution.next.is_some()
    }

    /// Performs one step of the solution and returns whether the solution is now complete; then [`Self::decide`] is
    /// due. The estimate of a source with impossible or contradicted errors is dropped, and the source is passed to
    /// `restarted`. `clocks` are the clock errors of the sources from the times of receipt.
    pub(crate) fn step(&mut self, clocks: &[ClockError], mut restarted: impl FnMut(u16)) -> bool {
        let Some((mut sweep, mut own)) = self.solution.next.take() else {
            return false;
        };
        let mut work = 0;
        while sweep <= SWEEPS {
            if work >= STEP_WORK {
                self.solution.next = Some((sweep, own));
                return false;
            }
            if sweep == SWEEPS {
                self.compare_models(own, clock_of(clocks, own));
                work += SELECT_WORK + self.partners[own].count_ones() as usize;
                own += 1;
                if own == self.sources.len() {
                    sweep += 1;
                }
                continue;
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
        if let Some((_, own, model)) = self.solution.best {
            self.sources[own].model = model;
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

    /// Drops the estimate of a source and all sums behind it.
    pub(crate) fn forget(&mut self, own: usize) {
        let count = self.sources.len();
        for other in partners(self.partners[own]) {
            self.pairs[own * count + other] = EMPTY;
            self.pairs[other * count + own] = EMPTY;
            self.partners[other] &= !(1 << own);
        }
        self.partners[own] = 0;
        self.contradicted[own] = 0.0;
        self.fits[own] = 1.0;
        self.rests[own] = Residuals::default();
        self.sources[own] = SourceErrors::unknown();
    }

    /// Decays the sums of one source by one tick, and factors its normal equations.
    fn forget_and_factor(&mut self, own: usize, clock: ClockError) {
        let count = self.sources.len();
        let (mut normal, _) = prior(clock);
        for other in partners(self.partners[own]) {
            let pair = &mut self.pairs[own * count + other];
            let drifts = self.rests[own].is_drift() || self.rests[other].is_drift();
            let keep = if drifts { self.keep_drifting } else { self.keep };
            pair.own *= keep;
            pair.cross *= keep;
            pair.right *= keep;
            normal += pair.own;
        }
        self.solution.sources[own].model.hold(&mut normal);
        let is_sought = self.reference != Some(own as u16) && self.sources[own].samples != 0.0;
        let factor = if is_sought { normal.cholesky() } else { None };
        if let Some(factor) = &factor {
            self.solution.sources[own].variances = factor.inverse().diagonal();
        }
        self.solution.factors[own] = factor;
    }

    /// Solves for the errors of one source, with the errors of the others fixed.
    fn solve(&mut self, own: usize, clock: ClockError) {
        let Some(factor) = &self.solution.factors[own] else {
            return;
        };
        let count = self.sources.len();
        let (_, mut right) = prior(clock);
        for other in partners(self.partners[own]) {
            let pair = &self.pairs[own * count + other];
            right += pair.right + pair.cross * self.solution.sources[other].errors;
        }
        self.solution.sources[own].errors = factor.solve(&right);
    }

    /// Returns the normal equations of one source without the comparisons with sources whose own errors are not solved
    /// for yet.
    fn settled_equations(&self, own: usize, clock: ClockError) -> (Block, Errors) {
        let count = self.sources.len();
        let (mut normal, mut right) = prior(clock);
        for other in partners(self.partners[own]) {
            if self.sources[other].samples >= SETTLED_MIN {
                let pair = &self.pairs[own * count + other];
                normal += pair.own;
                right += pair.right + pair.cross * self.solution.sources[other].errors;
            }
        }
        (normal, right)
    }

    /// Compares the models of a source by their evidence, with the errors of the others fixed.
    fn compare_models(&mut self, own: usize, clock: ClockError) {
        let samples = self.sources[own].samples;
        if self.solution.factors[own].is_none() || samples < SAMPLES_MIN {
            return;
        }
        let (normal, right) = self.settled_equations(own, clock);
        let better = self.sources[own].model.better(
            &normal,
            &right,
            1.0 / self.fits[own].max(1.0),
            SAMPLE_WEIGHT * samples,
            self.has_place[own],
        );
        if let Some((gain, model)) = better
            && self.solution.best.is_none_or(|(best, ..)| gain > best)
        {
            self.solution.best = Some((gain, own, model));
        }
    }

    /// Without a reference, takes the geometric median of all compared sources as true: a single outlier hardly moves
    /// it. Every sweep makes one step towards the median (Weiszfeld).
    fn fix_gauge(&mut self, clocks: &[ClockError]) {
        if self.reference.is_some() {
            return;
        }
        let is_any_off = clocks.iter().any(|clock| clock.excess_s > 0.0);
        // Range and azimuth biases are observable in absolute terms, from different positions. So is the offset, relative
        // to a source that is known to have none.
        let is_anchored = |source: &SourceErrors| source.samples > 0.0 && !source.model.has_offset();
        let is_anchored = self.solution.sources.iter().any(is_anchored);
        for rows in [0..2, 2..3, TIME..TIME + 1].into_iter().skip(usize::from(is_anchored)) {
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

    /// Returns a step from 0 towards the geometric median of the compared sources.
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

    /// Returns the median of each error over the compared sources; sources with wrong clocks weigh less.
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

    /// Decides the significance of the errors once a solution is complete. `known` returns whether the spread of a
    /// source is known, a precondition of the decision. `spread_m2` is the variance of the detection points,
    /// `targets` the number of targets that several sources observe. `points` is true if the detection points are
    /// known to lie far apart.
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

    /// Decides the significance of the errors of one source: the horizontal offset jointly, the others separately.
    /// `spread_m2` is the variance that the detection points add to a mean over all targets.
    ///
    /// If detection points lie far apart, a point ahead of the others looks like a fast clock. Time offsets are then
    /// left alone, unless the times of receipt confirm them.
    fn decide_for(&mut self, own: usize, spread_m2: f64, points: bool) {
        let known = &mut self.sources[own];
        let enough = known.samples >= SAMPLES_MIN;
        let squared = |row: usize, extra: f64| known.errors[row] * known.errors[row] / (known.variances[row] + extra);
        let horizontal = squared(0, spread_m2) + squared(1, spread_m2);
        let time = if points { 0.0 } else { squared(3, 0.0) };
        let values = [horizontal, horizontal, squared(2, 0.0), time];
        for (row, (removed, value)) in known.removed.iter_mut().zip(values).enumerate() {
            let limit = match (row < 2, *removed) {
                (true, false) => SIGNIFICANT_2,
                (true, true) => INSIGNIFICANT_2,
                (false, false) => SIGNIFICANT_1,
                (false, true) => INSIGNIFICANT_1,
            };
            *removed = enough && value > limit;
        }
        for row in [RANGE, AZIMUTH] {
            known.removed[row] = enough && known.model.estimates(row);
        }
        if known.model.is_polar() && known.model.has_offset() {
            // The offset belongs to the rotation.
            known.removed[..2].fill(enough);
        }
    }
}

/// Returns the normal equations of a source before any comparison.
fn prior(clock: ClockError) -> (Block, Errors) {
    let mut normal = Block::from_diagonal(&Errors::from_fn(|row, _| 1.0 / (PRIOR_SIGMA[row] * PRIOR_SIGMA[row])));
    let mut right = Errors::zeros();
    let (information, offset_s) = clock.prior();
    normal[(TIME, TIME)] = information;
    right[TIME] = information * offset_s;
    (normal, right)
}

/// Returns the weighted median of `values` in rising order, with weights that add up to `total`: the mean of the two
/// middle values if the half lies between them; 0 if there are no values.
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

/// Returns the sources in the bit set `bits`, in rising order.
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
