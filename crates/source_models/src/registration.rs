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
//! The normal equations of this model are summed for every pair of sources, with slow forgetting. At every tick, or at
//! every fifth once nothing changes, a few sweeps of block Gauss–Seidel solve the equations for all sources together.
//! Only differences are observable, so a reference is needed: either a configured reference source is taken as true, or
//! the geometric median of all sources is. If two of three sources agree, the median attributes the error to the third.
//!
//! If all targets move in one direction, a time offset is indistinguishable from a position offset. With two sources
//! the late clock is undetermined as well. Times of receipt resolve both cases: a clock that deviates from them gets
//! its offset as prior, and its source weighs less in the median.
//!
//! Errors may change. If the latest differences show a drift, only the differences of the last seconds count until the
//! estimate has caught up (module `recent`). After a step, the estimate of the changed source restarts (modules
//! `changes` and `steps`). The published covariances include the remaining differences, the offsets that are not
//! removed, and the unobservable error of the median itself.
//!
//! Sixty-four sources that all observe the same targets form four thousand pairs, a millisecond of work. No report may
//! wait that long, so a solution proceeds in steps of bounded work, and the estimates change after the last step. Four
//! sources need a single step.
//!
//! Two effects make the estimate less certain than the formula: the errors of a track are correlated in time, and the
//! sources detect different points of a target. Therefore a sample counts for a quarter, and the variance of the
//! detection points, divided by the number of targets, is added. A significant error is removed from the reports, until
//! the error becomes insignificant.
//!
//! Absurd reports of a source must not spoil the estimates of the others. Reports with widely different velocities are
//! not compared. An estimate out of bounds, or contradicted by most differences, is dropped together with the
//! underlying sums.
//!
//! An azimuth error, a range error and an offset look alike over a small area. Evidence decides among these errors
//! (module `model`). A sensor of unknown position gets a rotation and a shift instead.
//!
//! Source: Y. Bar-Shalom, P. Willett, X. Tian, *Tracking and Data Fusion* (YBS, 2011), chapter 9, for the model.

mod changes;
mod contradiction;
mod displacement;
mod errors;
mod gauge;
mod model;
mod progress;
mod recent;
mod rows;
mod sensitivity;
mod significance;
mod solution;
mod steps;
mod turns;

use estimation::{Symmetric3, inverse3};
use kept::kept;
use messages::AXES;
use serde::{Deserialize, Serialize};

use crate::registration::displacement::Displacement;
use crate::registration::errors::{ERROR_MAX_SIGMA, PRIOR_SIGMA, SAMPLES_MIN, clock_of, sensitivity};
use crate::registration::progress::{SETTLED_MIN, SolutionProgress};
use crate::registration::recent::{RECENT_S, Recent, SOLUTIONS_MIN};
use crate::registration::rows::{NormalMatrix, TIME};
use crate::registration::sensitivity::{Sensitivity, Weighted, add_vector};
use crate::registration::significance::PointsVariance;
use crate::registration::steps::{FormerErrors, MISLED_TICKS, Seed, StepSearch};
use crate::settings::SourceSet;
use crate::stamps::StampError;

pub use crate::registration::errors::SourceErrors;
pub(crate) use crate::registration::errors::{ClockError, TargetView};
pub use crate::registration::rows::{ERRORS, Errors};

/// Largest difference between velocities of the same target, metres per second.
const VELOCITY_GATE_MPS: f64 = 300.0;
/// Weight of a sample: errors of tracks persist over several reports.
const SAMPLE_WEIGHT: f64 = 0.25;
/// Least number of targets at which a common difference of all targets cannot come from a few wrong joins.
pub(crate) const TARGETS_MIN: usize = 3;
/// Largest mean square of the differences, and largest share of contradicting differences, of an estimate that explains
/// the differences.
const LEARNED_FIT_MAX: f64 = 2.0;
const LEARNED_CONTRADICTED_MAX: f64 = 0.25;
/// Largest squared statistical length of a used difference.
const DIFFERENCE_GATE: f64 = 25.0;
/// Largest variance per axis, m², by which detection points may explain a difference in the check for a wrong estimate.
/// The bound prevents a wrong estimate from passing as ever larger targets.
const POINTS_MAX_M2: f64 = 100.0 * 100.0;
/// Number of agreeing sources that outvote another source, and the largest squared displacement of each, relative to
/// that source.
const MAJORITY: usize = 2;
const NEAR_2: f64 = 1.0 / 9.0;
/// Probability that a source errs together with a wrong source, if both agree.
const ERR_TOGETHER: f64 = 0.27;
/// Squared displacement by a removed error, m², above which filters were misled.
const MISLED_M2: f64 = 40.0 * 40.0;
/// Ticks after which the tracks of compared sources are joined.
const ACQUAINTED_TICKS: u32 = 20;
/// Largest variance per axis of the possible displacement of an unsettled source, m².
const DOUBT_MAX_M2: f64 = 100.0 * 100.0;
/// Largest number of comparisons of a target within the memory of the latest differences.
const RECENT_TIMES: f64 = 3.0;
/// Weight of a difference in the mean square of the differences, and bound of each square per axis.
const FIT_GAIN: f64 = 1.0 / 64.0;
const FIT_MAX: f64 = 12.0;
/// Weight of a difference in the share of contradicting differences.
const CONTRADICTION_GAIN: f64 = 1.0 / 64.0;

kept! {
    /// Sums over an ordered pair of sources, from the view of the first.
    #[derive(Clone, Copy, Debug, Serialize, Deserialize)]
    pub(crate) struct SourcePair {
        /// Σ HⱼᵀWHⱼ.
        own: NormalMatrix,
        /// Σ HⱼᵀWHₖ.
        cross: NormalMatrix,
        /// Σ HⱼᵀWΔ.
        right: Errors,
    }
}

impl SourcePair {
    fn fade(&mut self, keep: f64) {
        self.own *= keep;
        self.cross *= keep;
        self.right *= keep;
    }
}

const EMPTY: SourcePair = SourcePair {
    own: NormalMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; ERRORS]; ERRORS])),
    cross: NormalMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; ERRORS]; ERRORS])),
    right: Errors::from_array_storage(nalgebra::ArrayStorage([[0.0; ERRORS]; 1])),
};

kept! {
    /// State of a source's errors for the checkpoint, beside the [`SourcePair`]s.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct KeptErrors {
        known: SourceErrors,
        partners: [u64; 2],
        contradicted: f64,
        fit: f64,
        ticks: u32,
    }
}

/// Registration of all sources against each other.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Registration {
    sources: Vec<SourceErrors>,
    pairs: Vec<SourcePair>,
    /// Compared partners of each source.
    partners: Vec<SourceSet>,
    /// Share of contradicting differences among the latest differences of each source.
    contradicted: Vec<f64>,
    /// Mean square per axis of each source's latest residual differences, relative to the expected square.
    fits: Vec<f64>,
    reference: Option<u16>,
    /// Number of targets observed by several sources; at least 1.
    targets: f64,
    /// Duration of a tick, seconds.
    tick_s: f64,
    /// Position of each sensor, if known.
    places_m: Vec<Option<[f64; 2]>>,
    /// Latest differences of each source.
    recents: Vec<Recent>,
    /// Ticks and number of solutions of each source's present estimate; at most [`SOLUTIONS_MIN`] solutions.
    ticks: Vec<u32>,
    solutions: Vec<u8>,
    /// Factor on the sums per tick, and factor for drifting sources.
    keep: f64,
    keep_drifting: f64,
    /// Displacement of each source's reports by systematic errors.
    displacements: Vec<Displacement>,
    solution: SolutionProgress,
    steps: StepSearch,
    /// Per source: information from the latest step, the estimate before the step (`formers`), and the remaining ticks
    /// in which states lag behind the step (`young`).
    seeds: Vec<Seed>,
    /// Variance per axis of the possible displacement of each source relative to the others, m².
    doubts_m2: Vec<f64>,
    formers: Vec<Option<FormerErrors>>,
    young: Vec<u8>,
    /// Remaining ticks in which a removed error may still mislead filters.
    misled_ticks: u8,
}

impl Registration {
    /// Creates the registration of `sources` sources; `reference` is taken as true. Sums decay with time constant
    /// `memory_s`; a tick is `tick_s` seconds.
    pub(crate) fn new(sources: usize, reference: Option<u16>, memory_s: f64, tick_s: f64) -> Self {
        let unknown = SourceErrors::unknown();
        Self {
            pairs: vec![EMPTY; sources * sources],
            partners: vec![SourceSet::EMPTY; sources],
            contradicted: vec![0.0; sources],
            fits: vec![1.0; sources],
            places_m: vec![None; sources],
            recents: vec![Recent::default(); sources],
            ticks: vec![0; sources],
            solutions: vec![0; sources],
            tick_s,
            reference,
            targets: 1.0,
            keep: (-tick_s / memory_s).exp(),
            keep_drifting: (-tick_s / RECENT_S.min(memory_s)).exp(),
            displacements: vec![Displacement::UNKNOWN; sources],
            solution: SolutionProgress::new(sources),
            sources: vec![unknown; sources],
            steps: StepSearch::new(sources),
            seeds: vec![Seed::NONE; sources],
            doubts_m2: vec![0.0; sources],
            formers: vec![None; sources],
            young: vec![0; sources],
            misled_ticks: 0,
        }
    }

    /// Returns the part of a source's state for the checkpoint.
    pub(crate) fn kept(&self, source: usize) -> KeptErrors {
        KeptErrors {
            known: self.sources[source],
            partners: self.partners[source].bits(),
            contradicted: self.contradicted[source],
            fit: self.fits[source],
            ticks: self.ticks[source],
        }
    }

    /// Resumes from the stored state of a source.
    pub(crate) fn resume(&mut self, source: usize, kept: &KeptErrors) {
        self.sources[source] = kept.known;
        self.partners[source] = SourceSet::of_bits(kept.partners);
        self.contradicted[source] = kept.contradicted;
        self.fits[source] = kept.fit;
        self.ticks[source] = kept.ticks;
    }

    /// Returns the sums over each ordered pair of sources.
    pub(crate) fn pairs(&self) -> &[SourcePair] {
        &self.pairs
    }

    /// Resumes from the stored sums of the pair at this index.
    pub(crate) fn resume_pair(&mut self, place: usize, kept: SourcePair) {
        self.pairs[place] = kept;
    }

    /// Returns the estimated errors of `source`.
    #[inline]
    pub(crate) fn of(&self, source: u16) -> &SourceErrors {
        &self.sources[usize::from(source)]
    }

    /// Returns the displacement of a report of `source` by the removed errors, metres.
    #[inline]
    pub(crate) fn shift(
        &self,
        source: u16,
        position_m: [f64; AXES],
        velocity_mps: [f64; AXES],
        place_m: Option<[f64; 2]>,
    ) -> [f64; AXES] {
        self.of(source).shift(position_m, velocity_mps, place_m)
    }

    /// Returns the estimated horizontal displacement of a report of a target with this velocity by errors that are
    /// *not* removed, because not significant yet, metres.
    #[inline]
    pub(crate) fn suspected_shift(&self, source: u16, velocity_mps: [f64; AXES]) -> [f64; 2] {
        let known = self.of(source);
        let suspected = |row: usize| if known.removed[row] { 0.0 } else { known.errors[row] };
        let suspected_s = known.errors[TIME] - known.time_offset_s();
        std::array::from_fn(|axis| suspected(axis) - suspected_s * velocity_mps[axis])
    }

    /// Returns the residual bias of a report of `source` after the removal, and the variance of all biases, m and m²;
    /// `None` until an estimate explains the differences from other sources.
    pub(crate) fn left(
        &self,
        source: u16,
        position_m: [f64; AXES],
        velocity_mps: [f64; AXES],
        place_m: Option<[f64; 2]>,
    ) -> Option<(f64, f64)> {
        let known = self.of(source);
        let index = usize::from(source);
        let is_learned = known.samples >= SETTLED_MIN
            && self.fits[index] <= LEARNED_FIT_MAX
            && self.contradicted[index] <= LEARNED_CONTRADICTED_MAX;
        if !is_learned {
            return None;
        }
        let effect = sensitivity(position_m, velocity_mps, place_m);
        let mut left = Errors::from_fn(|row, _| if known.removed[row] { 0.0 } else { known.errors[row] });
        left[TIME] = known.errors[TIME] - known.time_offset_s();
        let left = effect * left;
        let estimated = |row: usize| known.model.estimates(row);
        let variance_m2 = (0..ERRORS).filter(|row| estimated(*row)).map(|row| {
            (effect[(0, row)] * effect[(0, row)] + effect[(1, row)] * effect[(1, row)]) * known.variances[row]
        });
        Some((left[0].hypot(left[1]), variance_m2.sum()))
    }

    /// Returns the variance per axis of the possible displacement of an unsettled `source` relative to the others, m²;
    /// 0 once `source` is settled.
    #[inline]
    pub(crate) fn doubt_m2(&self, source: u16) -> f64 {
        self.doubts_m2[usize::from(source)]
    }

    /// Updates [`Self::doubt_m2`]. With fewer than two other settled sources, the source itself may be true.
    fn doubt(&mut self) {
        let settled = (0..self.sources.len() as u16)
            .filter(|own| self.is_settled(*own))
            .count();
        for own in 0..self.sources.len() {
            let is_compared = self.sources[own].samples > 0.0 && settled >= MAJORITY;
            self.doubts_m2[own] = match is_compared && !self.is_settled(own as u16) {
                true => self.displacements[own].variance_m2().min(DOUBT_MAX_M2),
                false => 0.0,
            };
        }
    }

    /// Returns whether a source has been compared for so long that a remaining error no longer keeps its tracks apart
    /// from the tracks of others.
    pub(crate) fn is_acquainted(&self, source: u16) -> bool {
        self.is_settled(source) && self.ticks[usize::from(source)] >= ACQUAINTED_TICKS
    }

    /// Returns whether the errors of a source have been estimated for some time.
    #[inline]
    pub(crate) fn is_settled(&self, source: u16) -> bool {
        let own = usize::from(source);
        self.sources[own].samples >= SETTLED_MIN && self.solutions[own] >= SOLUTIONS_MIN
    }

    /// Returns the variance per axis of the systematic error of a state to which all sources contribute, m². The sum
    /// contains the common part of the horizontal offsets and the part that is not removed.
    pub(crate) fn common_error_m2(&self) -> f64 {
        self.common_offset_m2() + self.undecided_turn_m2() + self.left_over_m2()
    }

    /// Returns the variance per axis of the common part of the displacements, m²; 0 if a reference source is taken as
    /// true. The common part shows in no difference, but if the displacements lie far apart, the median is hardly 0.
    /// Few displacements determine the spread poorly, so the variance is enlarged by `(n + 1)·n / (n − 1)²`. Sources
    /// that agree against another source may be wrong together; the fewer agree, the more the other source counts.
    fn common_offset_m2(&self) -> f64 {
        let known = || {
            let all = self.sources.iter().zip(&self.displacements);
            all.filter(|(known, _)| known.samples >= SAMPLES_MIN && !known.model.is_polar())
        };
        let (mut sum, mut total, mut count, mut together) = (0.0, 0.0, 0.0, 0.0);
        for (of, displacement) in known() {
            let errors = of.beside_stamps();
            let weight = displacement.closeness(&errors);
            let excess_m2 = displacement.excess_m2(&errors);
            sum += weight * weight * excess_m2;
            total += weight;
            count += 1.0;
            let is_near =
                |(of, near): &(&SourceErrors, &Displacement)| near.excess_m2(&of.beside_stamps()) < NEAR_2 * excess_m2;
            let agreeing = if excess_m2 > 0.0 {
                known().filter(is_near).count()
            } else {
                0
            };
            if agreeing >= MAJORITY {
                together += ERR_TOGETHER.powi(agreeing as i32 - 1) * excess_m2;
            }
        }
        if self.reference.is_some() || count < 2.0 {
            return 0.0;
        }
        let few = (count + 1.0) * count / ((count - 1.0) * (count - 1.0));
        (few * sum / (total * total) + together).max(0.0)
    }

    /// Sets the time offset that the stamps of a source imply.
    pub(crate) fn set_stamps(&mut self, source: usize, stamps: StampError) {
        let known = &mut self.sources[source];
        known.stamps = stamps;
        if self.reference == Some(source as u16) {
            // The others are compared with the reference as its source gives it.
            known.errors[TIME] = stamps.mean_s;
        }
    }

    /// Returns the variance of the time offset that compared sources have in common, s²: the sources' stamps decide
    /// about the offset by their inverse variances, or a reference source by its own. 0 without comparisons.
    pub(crate) fn common_time_s2(&self) -> f64 {
        if let Some(reference) = self.reference {
            return self.of(reference).stamps.variance_s2;
        }
        let compared = self.sources.iter().filter(|source| source.samples >= SAMPLES_MIN);
        let information: f64 = compared.map(|source| source.stamps.information()).sum();
        if information > 0.0 { 1.0 / information } else { 0.0 }
    }

    /// Returns the mean square per axis of the remaining horizontal offsets, m²: not significant yet, or drifted away
    /// from the estimate.
    fn left_over_m2(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (known, recent) in self.sources.iter().zip(&self.recents) {
            if known.samples >= SAMPLES_MIN {
                sum += if known.removed[0] { 0.0 } else { known.excess_m2() } + recent.drift_m2();
                count += 1.0;
            }
        }
        if count < 2.0 { 0.0 } else { (sum / count).max(0.0) }
    }

    /// Learns from two simultaneous views of a target. `points_m2` is the variance per axis between the detected
    /// points, m²; `reports` is the number of reports of the target per source, in `age_s` seconds.
    pub(crate) fn learn(&mut self, a: &TargetView, b: &TargetView, points_m2: f64, (reports, age_s): (f64, f64)) {
        let (of_a_mps, of_b_mps) = (a.velocity_beside(b), b.velocity_beside(a));
        let apart_mps = |axis: usize| of_a_mps[axis] - of_b_mps[axis];
        let apart_m = |axis: usize| a.position_m[axis] - b.position_m[axis];
        // This form of the condition rejects NaN.
        let may_be_one = is_within([apart_mps(0), apart_mps(1)], VELOCITY_GATE_MPS)
            && is_within([apart_m(0), apart_m(1)], ERROR_MAX_SIGMA * PRIOR_SIGMA[0]);
        if !may_be_one {
            return;
        }
        let three = a.has_height && b.has_height;
        let axes = if three { AXES } else { 2 };
        let difference: [f64; AXES] = std::array::from_fn(|axis| {
            if axis < axes {
                a.position_m[axis] - b.position_m[axis]
            } else {
                0.0
            }
        });
        let mut covariance_m2: Symmetric3 =
            std::array::from_fn(|place| a.covariance_m2[place] + b.covariance_m2[place]);
        let stated_m2 = covariance_m2[0] + covariance_m2[3];
        if !three {
            let [xx, xy, _, yy, ..] = covariance_m2;
            covariance_m2 = [xx, xy, 0.0, yy, 0.0, 1e12];
        }
        // The detection points of a target persist, so repeated comparisons yield no more than a single pair of points:
        // a parked aircraft must not outweigh all passing aircraft.
        let times = 1.0 + reports * (self.collected_s(a.source, b.source) / age_s).clamp(0.0, 1.0);
        let weight_of = |points_m2: f64| {
            let [xx, xy, xz, yy, yz, zz] = covariance_m2;
            inverse3([xx + points_m2, xy, xz, yy + points_m2, yz, zz])
        };
        let points_m2 = (times * points_m2, times.min(RECENT_TIMES) * points_m2);
        // A common velocity for both views: a common part of all clock errors then shows in no difference, and the
        // solution does not diverge when the part is subtracted.
        let velocity_mps = std::array::from_fn(|axis| 0.5 * (of_a_mps[axis] + of_b_mps[axis]));
        let (of_a, of_b) = (a.sensitivity(velocity_mps), b.sensitivity(velocity_mps));
        let (by_a, by_b) = (
            of_a.effect(&self.of(a.source).errors),
            of_b.effect(&self.of(b.source).errors),
        );
        let Some(weight) = weight_of(points_m2.0) else {
            return;
        };
        let weight_of_recent = match points_m2.1 == points_m2.0 {
            true => Some(weight),
            false => weight_of(points_m2.1),
        };
        let Some(weight_of_recent) = weight_of_recent else {
            return;
        };
        let rest: [f64; AXES] = std::array::from_fn(|axis| difference[axis] - (by_a[axis] - by_b[axis]));
        let product = |a: &[f64; AXES], b: &[f64; AXES]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let [east, north, up] = &weight;
        let squared = product(
            &[product(east, &rest), product(north, &rest), product(up, &rest)],
            &rest,
        );
        // Before enough samples exist, large errors must pass.
        let settled = self.of(a.source).samples > SAMPLES_MIN && self.of(b.source).samples > SAMPLES_MIN;
        if !squared.is_finite() {
            return;
        }
        let explained_m2 = DIFFERENCE_GATE * (stated_m2 + 2.0 * points_m2.0.min(POINTS_MAX_M2));
        let is_too_far = rest[0] * rest[0] + rest[1] * rest[1] > explained_m2;
        let is_contradicted = settled && (squared > DIFFERENCE_GATE || is_too_far);
        for source in [a.source, b.source] {
            let share = &mut self.contradicted[usize::from(source)];
            *share += CONTRADICTION_GAIN * (f64::from(u8::from(is_contradicted)) - *share);
            let fit = &mut self.fits[usize::from(source)];
            *fit += FIT_GAIN * ((squared / axes as f64).min(FIT_MAX) - *fit);
        }
        for view in [a, b] {
            self.places_m[usize::from(view.source)] = view.place_m;
        }
        let bound = (DIFFERENCE_GATE / squared.max(DIFFERENCE_GATE)).sqrt();
        let bounded = rest.map(|part| part * bound);
        let negative = |vector: [f64; AXES]| vector.map(|part| -part);
        let sample = |mut weight: [[f64; AXES]; AXES]| {
            weight.iter_mut().flatten().for_each(|value| *value *= SAMPLE_WEIGHT);
            weight
        };
        let is_solved = |view: &TargetView| {
            self.solutions[usize::from(view.source)] >= SOLUTIONS_MIN && !self.is_young(view.source)
        };
        if settled && is_solved(a) && is_solved(b) {
            let weight = sample(weight_of_recent);
            for (view, of, bounded) in [(a, &of_a, bounded), (b, &of_b, negative(bounded))] {
                self.recents[usize::from(view.source)].add(of, &of.weighted(&weight), &bounded);
            }
        }
        if is_contradicted {
            return;
        }
        let weight = sample(weight);
        self.recents[usize::from(a.source)].add_used(&weight, [rest[0], rest[1]]);
        self.recents[usize::from(b.source)].add_used(&weight, [-rest[0], -rest[1]]);
        let (weighted_a, weighted_b) = (of_a.weighted(&weight), of_b.weighted(&weight));
        self.add((a.source, b.source), &weighted_a, (&of_a, &of_b), &difference);
        self.add((b.source, a.source), &weighted_b, (&of_b, &of_a), &negative(difference));
    }

    /// Returns the age of the sums of two sources, seconds.
    fn collected_s(&self, a: u16, b: u16) -> f64 {
        f64::from(self.ticks[usize::from(a)].min(self.ticks[usize::from(b)])) * self.tick_s
    }

    fn add(
        &mut self,
        (own, other): (u16, u16),
        weighted: &Weighted,
        (of_own, of_other): (&Sensitivity, &Sensitivity),
        difference: &[f64; AXES],
    ) {
        let count = self.sources.len();
        let pair = &mut self.pairs[usize::from(own) * count + usize::from(other)];
        of_own.add_product(weighted, &mut pair.own);
        of_other.add_product(weighted, &mut pair.cross);
        add_vector(weighted, difference, &mut pair.right);
        self.partners[usize::from(own)].insert(other);
        self.sources[usize::from(own)].samples += 1.0;
    }

    /// Decides the significance of the errors once a solution is complete. `spread_m2` returns the variance per axis of
    /// the detection points of a source, `None` if too little is known for a decision. `targets` is the number of
    /// targets observed by several sources.
    ///
    /// With detection points known to lie `far_apart`, a time offset is removed only if the times of receipt confirm a
    /// clock error.
    pub(crate) fn decide(
        &mut self,
        clocks: &[ClockError],
        spread_m2: impl Fn(usize) -> Option<f64>,
        targets: usize,
        far_apart: bool,
    ) {
        self.targets = targets.max(1) as f64;
        for own in 0..self.sources.len() {
            let is_clock_off = clock_of(clocks, own).excess_s > 0.0;
            let Some(spread_m2) = spread_m2(own) else {
                continue;
            };
            let offset_m2 = spread_m2 / self.targets;
            let time_s2 = match far_apart && !is_clock_off {
                true => f64::INFINITY,
                false => offset_m2 / self.mean_squared_speed(own),
            };
            let before = self.sources[own].removed;
            let points = PointsVariance { offset_m2, time_s2 };
            significance::decide(&mut self.sources[own], &points, &self.displacements[own]);
            if self.sources[own].removed != before {
                self.steps.clear();
                let has_misled = self.displacements[own].squared_m2(&self.sources[own].errors) > MISLED_M2;
                self.misled_ticks = self.misled_ticks.max(if has_misled { MISLED_TICKS } else { 0 });
            }
        }
        self.doubt();
    }

    /// Returns the compared partners of a source.
    fn partners_of(&self, own: usize) -> impl Iterator<Item = usize> + use<> {
        self.partners[own].iter().map(usize::from)
    }

    /// Returns the mean squared speed of the targets in the comparisons of a source, m²/s²; at least 1.
    fn mean_squared_speed(&self, own: usize) -> f64 {
        let pairs = self
            .partners_of(own)
            .map(|other| &self.pairs[own * self.sources.len() + other].own);
        let (speeds, weights) = pairs.fold((0.0, 0.0), |(speeds, weights), sums| {
            (speeds + sums[(TIME, TIME)], weights + sums[(0, 0)])
        });
        (speeds / weights).max(1.0)
    }
}

/// Returns whether a vector is no longer than `limit`.
fn is_within([x, y]: [f64; 2], limit: f64) -> bool {
    x * x + y * y <= limit * limit
}

#[cfg(test)]
#[path = "registration_tests.rs"]
mod tests;
