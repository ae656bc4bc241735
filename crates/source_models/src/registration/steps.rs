//! Steps of the systematic errors: a generalised likelihood ratio on innovations, and the start of a new estimate.
//!
//! The differences of registration compare states of trackers. A tracker follows a step of the sensor over several
//! scans, and settled sources are compared rarely, so that such differences show a step after half a minute. The
//! innovations of the system filters show the step in the next scan: the measurements behind the states are independent
//! of each other, and each report has an innovation.
//!
//! For each source and for several possible times of the step, the mean innovation since then is compared with the mean
//! innovation of all other sources since then. Both means contain the common part of all sources, such as the lag of
//! the filters in a turn, and the part of the step already absorbed by the filters. The difference of the means is the
//! most likely step, and its squared statistical length the likelihood ratio. A step is an offset, or an offset and a
//! rotation. The length is reduced if the innovations of the source scatter more than expected. The source with the
//! greatest length has changed, if no other source comes near; two sources alone are indistinguishable.
//!
//! The new estimate of the changed source begins with the detected step. The former estimate is a rival: a former
//! estimate that explains the new errors, as after the end of a fault, is resumed.
//!
//! Source: A. Willsky, H. Jones, *A generalized likelihood ratio approach to the detection and estimation of jumps in
//! linear systems*, IEEE Transactions on Automatic Control 21 (1976).

use association::distance::{Symmetric2, squared2};
use estimation::length;
use serde::{Deserialize, Serialize};

use crate::mean_innovation::{MeanInnovation, Others, SECOND_MAX};
use crate::registration::errors::SourceErrors;
use crate::registration::model::BiasModel;
use crate::registration::rows::{AZIMUTH, ERRORS, Errors, NormalMatrix, TIME};

type Matrix3 = nalgebra::Matrix3<f64>;
type Vector3 = nalgebra::Vector3<f64>;

/// Rows of the errors that may step.
const ROWS: [usize; 3] = [0, 1, AZIMUTH];

/// Intervals of the memory, and ticks per interval.
const INTERVALS: usize = 12;
const INTERVAL_TICKS: u8 = 2;
/// Numbers of intervals since the tested starts of a step.
const STARTS: [usize; 7] = [1, 2, 3, 4, 6, 9, 12];
/// Least number of innovations of each source in a test.
const COUNT_MIN: f64 = 6.0;
/// Least squared statistical length of a significant rotation.
const TURNS: f64 = 16.0;
/// Squared length below which a rotation needs no further look; the sums are rounded.
const TURNS_LEAST: f64 = 0.99 * TURNS;
/// Weight of an innovation: turns make innovations of a target depend on each other.
const WEIGHT: f64 = 0.5;
/// Largest squared length of an innovation. Scattered absurd reports make no step, because of the enlarged scatter.
const SQUARED_MAX: f64 = 1000.0;
/// Least squared statistical length of a step.
const STEP: f64 = 25.0;
/// Least squared statistical length of a further step of a recently changed source, and ticks of this state.
const FURTHER: f64 = 9.2;
const MOVING_TICKS: u8 = 24;
/// Squared statistical length up to which a former estimate explains the new errors.
const EXPLAINED: f64 = 11.3;
/// Standard deviation of a resumed former estimate, metres.
const FORMER_SIGMA_M: f64 = 10.0;
/// Standard deviation of a detected step relative to its length: filters and trackers have absorbed a part.
const UNKNOWN_SHARE: f64 = 0.1;
/// Least standard deviation of a rotation, radians: ten metres at fifty kilometres.
const ROTATION_MIN_RAD: f64 = 2e-4;
/// Ticks after a step with comparisons of measurements instead of states: trackers have not followed the step yet.
pub(crate) const YOUNG_TICKS: u8 = 25;

/// Ticks after a step with possibly misled filters.
pub(crate) const MISLED_TICKS: u8 = 6;

/// Sums of the innovations of a source in an interval, as the normal equations of an offset and a rotation.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Sums {
    /// Σ HᵀWH of the offset (xx, xy, yy), the products of offset and rotation, and of the rotation.
    information: [f64; 3],
    mixed: [f64; 2],
    rotation: f64,
    /// Σ HᵀW·residual.
    sum: [f64; 3],
    /// Σ of squared lengths, and number.
    squares: f64,
    count: f64,
    /// Number of bounded innovations.
    bounded: f64,
    /// Targets of the innovations, as bits by number.
    targets: u64,
}

impl Sums {
    fn plus(mut self, other: &Self) -> Self {
        fn add<const N: usize>(own: &mut [f64; N], other: &[f64; N]) {
            own.iter_mut().zip(other).for_each(|(own, other)| *own += other);
        }
        add(&mut self.information, &other.information);
        add(&mut self.mixed, &other.mixed);
        add(&mut self.sum, &other.sum);
        self.rotation += other.rotation;
        self.squares += other.squares;
        self.count += other.count;
        self.bounded += other.bounded;
        self.targets |= other.targets;
        self
    }

    /// Returns the mean and its covariance, without a rotation.
    fn mean(&self) -> ([f64; 2], Symmetric2) {
        let [xx, xy, yy] = inverse(self.information);
        let [east, north, _] = self.sum;
        ([xx * east + xy * north, xy * east + yy * north], [xx, xy, yy])
    }

    /// Returns the mean with its covariance; all innovations of a target contain the same detection point.
    fn mean_of(&self, source: usize, points_m2: f64) -> MeanInnovation {
        let (mean_m, covariance_m2) = self.mean();
        let [xx, xy, yy] = covariance_m2.map(|value| value * self.scatter(mean_m) / WEIGHT);
        let points_m2 = points_m2 * self.targets_share();
        MeanInnovation {
            source,
            mean_m,
            covariance_m2: [xx + points_m2, xy, yy + points_m2],
        }
    }

    /// Returns the variance of the innovations about the mean relative to the expected variance; at least 1.
    fn scatter(&self, [east, north]: [f64; 2]) -> f64 {
        let explained = self.sum[0] * east + self.sum[1] * north;
        ((self.squares - explained) / (2.0 * self.count - 2.0)).max(1.0)
    }

    /// Returns the share of a single target in the sums.
    fn targets_share(&self) -> f64 {
        1.0 / f64::from(self.targets.count_ones().max(1))
    }

    /// Returns the effect of an offset and a rotation on the observed targets, root mean square, metres.
    fn effect_m(&self, by: &Vector3) -> f64 {
        let ([xx, xy, yy], [xa, ya]) = (self.information, self.mixed);
        let normal = Matrix3::new(xx, xy, xa, xy, yy, ya, xa, ya, self.rotation);
        (by.dot(&(normal * by)) / (0.5 * (xx + yy))).sqrt()
    }

    /// Returns whether a rotation can be significant, beside the mean without a rotation: by the squared statistical
    /// length of the rotation, at the least scatter.
    fn may_turn(&self, [east, north]: [f64; 2]) -> bool {
        let ([xx, xy, yy], [xa, ya]) = (inverse(self.information), self.mixed);
        let rest = self.sum[2] - xa * east - ya * north;
        let information = self.rotation - (xx * xa * xa + 2.0 * xy * xa * ya + yy * ya * ya);
        WEIGHT * rest * rest > TURNS_LEAST * information
    }

    /// Returns the step of offset and rotation relative to the mean of the others, and its covariance.
    fn turned(&self, others_m: [f64; 2], others_m2: Symmetric2) -> Option<(Vector3, Matrix3)> {
        let ([xx, xy, yy], [xa, ya]) = (self.information, self.mixed);
        let normal = Matrix3::new(xx, xy, xa, xy, yy, ya, xa, ya, self.rotation);
        let right = Vector3::from(self.sum);
        let inverse = normal.cholesky()?.inverse();
        let explained = right.dot(&(inverse * right));
        let scatter = ((self.squares - explained) / (2.0 * self.count - 3.0)).max(1.0);
        let others = Vector3::new(others_m[0], others_m[1], 0.0);
        let mut covariance = inverse * (scatter / WEIGHT);
        covariance[(0, 0)] += others_m2[0];
        covariance[(0, 1)] += others_m2[1];
        covariance[(1, 0)] += others_m2[1];
        covariance[(1, 1)] += others_m2[2];
        Some((inverse * right - others, covariance))
    }
}

fn inverse([xx, xy, yy]: Symmetric2) -> Symmetric2 {
    let determinant = xx * yy - xy * xy;
    [yy / determinant, -xy / determinant, xx / determinant]
}

/// A step of the errors of a source.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Step {
    pub(crate) source: usize,
    /// Offset east and north, metres, and rotation about the origin, radians clockwise; the covariance of the three.
    pub(crate) by: Vector3,
    covariance: Matrix3,
    /// Whether the step includes a rotation.
    pub(crate) turns: bool,
    /// Whether the step exceeds the range of the innovations.
    pub(crate) is_beyond: bool,
    /// Whether the source has changed recently.
    pub(crate) is_further: bool,
    /// Number of targets with the step, at most 64.
    pub(crate) targets: u32,
    /// Interval of the detection of the step, and number of intervals up to then since the step.
    found: usize,
    intervals: usize,
    /// Squared statistical length.
    length: f64,
    /// Effect on the observed targets, root mean square, metres.
    pub(crate) effect_m: f64,
}

impl Step {
    /// Variance of the offset per axis, m².
    pub(crate) fn variance_m2(&self) -> f64 {
        0.5 * (self.covariance[(0, 0)] + self.covariance[(1, 1)])
    }
}

/// Information on a changed source from the step itself.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Seed {
    /// Normal equations, fading.
    pub(crate) normal: NormalMatrix,
    pub(crate) right: Errors,
}

impl Seed {
    pub(crate) const NONE: Self = Self {
        normal: NormalMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; ERRORS]; ERRORS])),
        right: Errors::from_array_storage(nalgebra::ArrayStorage([[0.0; ERRORS]; 1])),
    };

    /// Returns the information of a step on a source with the errors `old` before the step, with the `former` estimate
    /// as rival, and the model of the new errors. `place_m` is the position of the sensor, if known.
    pub(crate) fn of(
        step: &Step,
        old: &SourceErrors,
        former: Option<&FormerErrors>,
        place_m: Option<[f64; 2]>,
    ) -> (Self, BiasModel) {
        let [east, north] = place_m.unwrap_or_default();
        // A rotation about the origin equals a rotation about the sensor and an offset.
        let moved = Matrix3::new(1.0, 0.0, north, 0.0, 1.0, -east, 0.0, 0.0, 1.0);
        let by = moved * step.by;
        let mut covariance = moved * step.covariance * moved.transpose();
        let unknown = UNKNOWN_SHARE * by.xy().norm();
        covariance[(0, 0)] += unknown * unknown;
        covariance[(1, 1)] += unknown * unknown;
        covariance[(2, 2)] += UNKNOWN_SHARE * UNKNOWN_SHARE * by.z * by.z + ROTATION_MIN_RAD * ROTATION_MIN_RAD;
        let before = ROWS.map(|row| old.errors[row]);
        let now = by + Vector3::from(before);
        let mut seed = Self::NONE;
        for row in [2, TIME] {
            // Doubled deviations: the height and the clock may have changed, too.
            seed.add_row(row, old.errors[row], 4.0 * old.variances[row]);
        }
        if let Some(former) = former
            && former.explains(&now, &covariance)
        {
            for (part, row) in ROWS
                .into_iter()
                .enumerate()
                .filter(|(_, row)| former.model.estimates(*row))
            {
                seed.add_row(row, former.errors[part], former.variances[part]);
            }
            return (seed, former.model);
        }
        let model = if step.turns || old.model.is_polar() {
            BiasModel::TURNED
        } else {
            BiasModel::OFFSET
        };
        if model == BiasModel::OFFSET {
            let offset_m2 = [covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]];
            let [xx, xy, yy] = inverse(offset_m2);
            let information = Matrix3::new(xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, 0.0);
            seed.add(&information, &now);
        } else if let Some(factor) = covariance.cholesky() {
            seed.add(&factor.inverse(), &now);
        }
        (seed, model)
    }

    fn add(&mut self, information: &Matrix3, errors: &Vector3) {
        let right = information * errors;
        for (part, row) in ROWS.into_iter().enumerate() {
            self.right[row] += right[part];
            for (other, column) in ROWS.into_iter().enumerate() {
                self.normal[(row, column)] += information[(part, other)];
            }
        }
    }

    fn add_row(&mut self, row: usize, error: f64, variance: f64) {
        self.normal[(row, row)] += 1.0 / variance;
        self.right[row] += error / variance;
    }

    pub(crate) fn fade(&mut self, keep: f64) {
        self.normal *= keep;
        self.right *= keep;
    }
}

/// Offset and azimuth bias of a source before its latest step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct FormerErrors {
    errors: [f64; 3],
    variances: [f64; 3],
    model: BiasModel,
}

impl FormerErrors {
    pub(crate) fn of(known: &SourceErrors) -> Self {
        let least = [FORMER_SIGMA_M, FORMER_SIGMA_M, ROTATION_MIN_RAD];
        let variance = |part: usize| {
            let known = known.model.estimates(ROWS[part]).then(|| known.variances[ROWS[part]]);
            known.unwrap_or_default().max(least[part] * least[part])
        };
        Self {
            errors: ROWS.map(|row| known.errors[row]),
            variances: std::array::from_fn(variance),
            model: known.model,
        }
    }

    fn explains(&self, errors: &Vector3, covariance: &Matrix3) -> bool {
        let apart = errors - Vector3::from(self.errors);
        let covariance = covariance + Matrix3::from_diagonal(&Vector3::from(self.variances));
        covariance
            .cholesky()
            .is_some_and(|factor| apart.dot(&factor.solve(&apart)) < EXPLAINED)
    }
}

/// Search for steps of all sources.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct StepSearch {
    /// Per source, and per interval as a ring.
    sums: Vec<[Sums; INTERVALS]>,
    /// For the search: sums of each source since a start, means, and the most likely step of each source.
    since: Vec<Sums>,
    means: Vec<MeanInnovation>,
    best: Vec<Option<Step>>,
    /// Remaining ticks in which each source counts as changing.
    moving: Vec<u8>,
    /// Present interval, and its ticks.
    present: usize,
    ticks: u8,
}

impl StepSearch {
    pub(crate) fn new(sources: usize) -> Self {
        Self {
            sums: vec![[Sums::default(); INTERVALS]; sources],
            since: vec![Sums::default(); sources],
            means: Vec::with_capacity(sources),
            moving: vec![0; sources],
            best: vec![None; sources],
            present: 0,
            ticks: 0,
        }
    }

    /// Adds an innovation of a source: residual and covariance, number and position (east, north) of the target.
    #[inline]
    pub(crate) fn add(
        &mut self,
        source: usize,
        (residual_m, covariance_m2): ([f64; 2], Symmetric2),
        (target, position_m): (u32, [f64; 2]),
    ) {
        let [xx, xy, yy] = inverse(covariance_m2);
        let squared = squared2(residual_m, covariance_m2);
        // The condition rejects NaN.
        if !(squared < f64::MAX && xx > 0.0) {
            return;
        }
        let bound = (SQUARED_MAX / squared.max(SQUARED_MAX)).sqrt();
        let [east, north] = residual_m.map(|part| part * bound);
        let sums = &mut self.sums[source][self.present];
        // Azimuth counts clockwise from north.
        let turned = [position_m[1], -position_m[0]];
        let mixed = [xx * turned[0] + xy * turned[1], xy * turned[0] + yy * turned[1]];
        let added = Sums {
            information: [xx, xy, yy],
            mixed,
            rotation: mixed[0] * turned[0] + mixed[1] * turned[1],
            sum: [
                xx * east + xy * north,
                xy * east + yy * north,
                mixed[0] * east + mixed[1] * north,
            ],
            squares: squared.min(SQUARED_MAX),
            count: 1.0,
            bounded: f64::from(u8::from(squared > SQUARED_MAX)),
            targets: 1 << (target % u64::BITS),
        };
        *sums = sums.plus(&added);
    }

    /// Subtracts the offset of a step from the innovations since the step: later reports are corrected by the offset.
    pub(crate) fn carry(&mut self, step: &Step) {
        let (east, north) = (step.by.x, step.by.y);
        self.moving[step.source] = MOVING_TICKS;
        for back in 0..step.intervals {
            let sums = &mut self.sums[step.source][(step.found + INTERVALS - back) % INTERVALS];
            let ([xx, xy, yy], [xa, ya]) = (sums.information, sums.mixed);
            let by = [xx * east + xy * north, xy * east + yy * north, xa * east + ya * north];
            let squares = (by[0] - 2.0 * sums.sum[0]) * east + (by[1] - 2.0 * sums.sum[1]) * north;
            sums.squares = (sums.squares + squares).max(0.0);
            for (sum, by) in sums.sum.iter_mut().zip(by) {
                *sum -= by;
            }
        }
    }

    /// Discards all innovations after a change of the corrections.
    pub(crate) fn clear(&mut self) {
        self.sums.fill([Sums::default(); INTERVALS]);
        self.ticks = 0;
    }

    /// Searches for a step among the `sought` sources, once per tick. The detection points of a target have a variance
    /// of up to `points_m2` per axis.
    pub(crate) fn look(&mut self, points_m2: f64, sought: impl Fn(usize) -> bool) -> Option<Step> {
        let step = self.step(points_m2, sought);
        for moving in &mut self.moving {
            *moving = moving.saturating_sub(1);
        }
        self.ticks += 1;
        if self.ticks >= INTERVAL_TICKS {
            self.ticks = 0;
            self.present = (self.present + 1) % INTERVALS;
            for sums in &mut self.sums {
                sums[self.present] = Sums::default();
            }
        }
        step
    }

    fn step(&mut self, points_m2: f64, sought: impl Fn(usize) -> bool) -> Option<Step> {
        self.since.fill(Sums::default());
        self.best.fill(None);
        for back in 0..INTERVALS {
            let interval = (self.present + INTERVALS - back) % INTERVALS;
            for (since, sums) in self.since.iter_mut().zip(&self.sums) {
                *since = since.plus(&sums[interval]);
            }
            if STARTS.contains(&(back + 1)) {
                self.compare(back + 1, points_m2);
            }
        }
        let (mut best, mut second): (Option<Step>, f64) = (None, 0.0);
        for step in self.best.iter().flatten() {
            if best.is_none_or(|best| step.length > best.length) {
                second = best.map_or(second, |best| best.length.max(second));
                best = Some(*step);
            } else {
                second = second.max(step.length);
            }
        }
        let mut best = best?;
        best.is_further = self.moving[best.source] > 0;
        let limit = if best.is_further { FURTHER } else { STEP };
        (best.length > limit && second < SECOND_MAX * best.length && sought(best.source)).then_some(best)
    }

    /// Compares the mean innovation of each source in the latest intervals with the mean of all others.
    fn compare(&mut self, intervals: usize, points_m2: f64) {
        self.means.clear();
        let known = self
            .since
            .iter()
            .enumerate()
            .filter(|(_, sums)| sums.count >= COUNT_MIN);
        self.means
            .extend(known.map(|(source, sums)| sums.mean_of(source, points_m2)));
        let Some(others) = Others::of(&mut self.means) else {
            return;
        };
        for own in &self.means {
            let step = step_of(
                own,
                &self.since[own.source],
                &others.beside(own),
                (self.present, intervals),
            );
            let best = &mut self.best[own.source];
            if step.length.is_finite() && best.is_none_or(|best| step.length > best.length) {
                *best = Some(step);
            }
        }
    }
}

/// Returns the most likely step of a source with these sums and this mean, relative to the mean of the others.
fn step_of(
    own: &MeanInnovation,
    sums: &Sums,
    (others_m, others_m2): &([f64; 2], Symmetric2),
    (found, intervals): (usize, usize),
) -> Step {
    let (by_m, covariance_m2) = own.apart(others_m, others_m2);
    let [xx, xy, yy] = covariance_m2;
    let shift = Step {
        source: own.source,
        by: Vector3::new(by_m[0], by_m[1], 0.0),
        covariance: Matrix3::new(xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, 0.0),
        turns: false,
        is_beyond: 2.0 * sums.bounded > sums.count,
        is_further: false,
        targets: sums.targets.count_ones(),
        found,
        intervals,
        length: squared2(by_m, covariance_m2),
        effect_m: length(by_m),
    };
    if !sums.may_turn(own.mean_m) {
        return shift;
    }
    let Some((by, covariance)) = sums.turned(*others_m, *others_m2) else {
        return shift;
    };
    let length = covariance.cholesky().map_or(0.0, |factor| by.dot(&factor.solve(&by)));
    if by.z * by.z > TURNS * covariance[(2, 2)] && length > shift.length {
        return Step {
            by,
            covariance,
            turns: true,
            length,
            effect_m: sums.effect_m(&by),
            ..shift
        };
    }
    shift
}

#[cfg(test)]
#[path = "steps_tests.rs"]
mod tests;
