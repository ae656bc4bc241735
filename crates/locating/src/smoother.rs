//! Filter of an emitter: all bearings together while the geometry is poor, later recursively (EL-2).
//!
//! A bearing contains no range; range comes from the change of the bearings while the platform flies. The obvious
//! filter, an extended Kalman filter, linearises each bearing once, at the emitter position estimated at that time.
//! The first estimate is a triangulation of a few nearly parallel bearings, with an error possibly as large as the
//! range. The resulting range information is wrong, and is never corrected: with an emitter 50 km away the filter
//! ends seven times worse than the bearings allow, with a far too small variance.
//!
//! Here no linearisation is final while relevant. The last lines are stored ([`crate::window`]) and solved together by
//! Gauss–Newton iteration: all lines are linearised anew at the *current* estimate (the maximum-likelihood estimate).
//! Only lines for which the position is known to a fiftieth of their range are folded into a Gaussian prior for good,
//! and there the linearisation is exact enough.
//!
//! An emitter is a fixed point (two components: position) or moves straight on (four: velocity, too). Without process
//! noise the state at a reference time holds all information, and no bearing is ever forgotten. With process noise, for
//! emitters that wander or manoeuvre, the filter is the extended Kalman filter. That filter works well with a known
//! range, so it starts at the settled state of the model without noise.
//!
//! # Bearings that are wrong
//!
//! A bearing with an error above four standard deviations gets a weight that decreases with the error (as in Huber's
//! estimator). But a turning platform gives bearings that are wrong *together*: each slightly, all to the same side,
//! and a filter averages these errors in. A running sum of the normalised innovations, over about the last ten
//! bearings, detects such errors: while bearings and state are right, the sum is Gaussian with known variance. When the
//! sum leaves the bounds, the last lines are removed and new lines are set aside until they agree again. Without an
//! agreement the state is wrong; [`crate::bank`] makes this decision.
//!
//! Sources: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation* (Wiley,
//! 2001), chapters 3 and 10; B. M. Bell, F. W. Cathey, *The iterated Kalman filter update as a Gauss–Newton method*,
//! IEEE Transactions on Automatic Control 38 (1993).

use kept::{kept, kept_variants};
use nalgebra::{Matrix4, SMatrix, SVector, Vector4};

use crate::gauss_newton::{DEVIATION_MAX, LeastSquaresProblem, StatePrior};
use crate::kinematics::{add_process_noise, longest_half_axis, position, sensitivity, transition};
use crate::line_of_bearing::LineOfBearing;
use crate::linear::Factor;
use crate::ranges::RangeHypotheses;
use crate::search_start::{BEARINGS_MIN, start_position};
use crate::window::Window;

/// The geometry allows a fix when the longest half-axis of the error ellipse is below this share of the range.
const LOCATED_SHARE: f64 = 0.3;
/// While hypotheses about the range compete, this is a share of the present range; or the half-axis is below this share
/// of the longer of the first and the present range.
const LOCATED_SHARE_LONGEST: f64 = 0.08;
/// … and no longer above this share.
const LOST_SHARE: f64 = 0.5;
/// From this share on the linearisation is good enough to judge bearings singly.
const SETTLED_SHARE: f64 = 0.05;
/// From this share on a line may be linearised for good.
const LINEAR_SHARE: f64 = 0.02;
/// Lines that go into the prior at a time.
const FOLDED_AT_ONCE: usize = 16;
/// Bearings between two linearisations of a settled filter's window.
const RELINEARISED_EVERY: u64 = 8;
/// Before that, after this share of all bearings.
const SEARCHED_EVERY: u64 = 16;
/// Rounds of the search for a first fix, and of the improvement.
const ROUNDS_FIRST: usize = 20;
const ROUNDS: usize = 3;
/// The prior of the velocity is widened when the velocity is found beyond so many standard deviations.
const SPEED_SIGMAS: f64 = 3.0;

/// Share of the running sum of innovations that is kept at each bearing, and the sum's standard deviation.
const SUM_KEPT: f64 = 0.85;
const SUM_SIGMA: f64 = 1.898_315_991;
/// Lines removed when the sum leaves the bounds.
const TAKEN_BACK: usize = 8;
/// A fix by which fewer bearings than this were judged is no match for bearings that disagree.
const YOUNG: u64 = 32;
/// A sum within this many standard deviations, and an innovation within its own bound, let bearings in again.
const AGREE_SUM: f64 = 2.0;
const AGREE_ONE: f64 = 2.5;
/// Share of the running share of wrong arrival times that is kept at each, for a young fix and later; shares at which a
/// fix is distrusted, and trusted again.
const WRONG_KEPT: [f64; 2] = [0.92, 0.95];
const WRONG_MAX: f64 = 0.6;
const WRONG_AGREE: f64 = 0.5;

/// Assumptions on the motion of an emitter, and prior knowledge before the first bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Model {
    /// Fixed point: m²/s; straight motion: m²/s³.
    pub(crate) process_noise: f64,
    /// Standard deviation of an unknown emitter's position about the platform, metres.
    pub(crate) range_sigma_m: f64,
    /// … of the velocity along each axis, m/s; of no meaning for fixed points.
    pub(crate) speed_sigma_mps: f64,
    /// … as long as the bearings do not show a greater velocity.
    pub(crate) slow_sigma_mps: f64,
    /// Known first place, in place of the unknown place about the platform.
    pub(crate) start: Option<StartPoint>,
}

/// Known place of an emitter at a time, before the first bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StartPoint {
    pub(crate) time_ns: i64,
    /// East and north, metres.
    pub(crate) position_m: [f64; 2],
    /// Standard deviation along each axis, metres.
    pub(crate) sigma_m: f64,
}

/// Bounds of the running sum of innovations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// In standard deviations.
    pub(crate) limit: f64,
    /// Since when the platform turns.
    pub(crate) turning_since_ns: Option<i64>,
}

/// Treatment of a bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BearingTreatment {
    /// Used.
    Used,
    /// Not used: the bearing or the preceding bearings disagree.
    SetAside,
    /// The first that was set aside; the sum of innovations in standard deviations.
    Distrusted(f64),
    /// The first that agrees again.
    Trusted,
}

impl BearingTreatment {
    /// Whether the bearing counts.
    pub(crate) fn is_used(self) -> bool {
        matches!(self, Self::Used | Self::Trusted)
    }
}

/// Filter of an emitter for a single model, of D components: position and, if D is 4, velocity.
#[derive(Clone, Debug)]
pub(crate) struct Smoother<const D: usize> {
    model: Model,
    /// Time of prior and estimate.
    reference_ns: i64,
    prior: StatePrior<D>,
    /// Standard deviation of the velocity in the prior, m/s.
    speed_sigma_mps: f64,
    /// Hypotheses about the range, until the geometry has shown the range.
    ranges: Option<RangeHypotheses<D>>,
    window: Window,
    estimate: SVector<f64, D>,
    covariance: SMatrix<f64, D, D>,
    /// Bearings so far, and since the window was linearised.
    bearings: u64,
    since_linearised: u64,
    /// Number of bearings since the filter settled.
    settled_for: u64,
    stage: FilterStage,
    /// Whether the lines of a search have no place in common.
    is_misfit: bool,
    /// By how much a velocity explains the window better than rest at the fixed point's fix.
    lead_over_rest: Option<f64>,
    sum: f64,
    /// Running share of arrival times that are far off.
    wrong: f64,
    is_distrusting: bool,
}

/// Degree of knowledge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum FilterStage {
    /// Nothing yet.
    Empty,
    /// Lines without a consistent position.
    Searching,
    /// A position, but with insufficient geometry for a fix.
    Vague,
    /// A fix.
    Located,
    /// … by which bearings can be judged.
    Settled,
}

impl<const D: usize> Smoother<D> {
    pub(crate) fn new(model: Model) -> Self {
        const { assert!(D == 2 || D == 4, "position, or position and velocity") };
        Self {
            model,
            reference_ns: 0,
            prior: StatePrior::default(),
            speed_sigma_mps: model.slow_sigma_mps,
            ranges: None,
            window: Window::EMPTY,
            estimate: SVector::zeros(),
            covariance: SMatrix::zeros(),
            bearings: 0,
            since_linearised: 0,
            settled_for: 0,
            stage: FilterStage::Empty,
            is_misfit: false,
            lead_over_rest: None,
            sum: 0.0,
            wrong: 0.0,
            is_distrusting: false,
        }
    }

    /// Whether there is a fix.
    pub(crate) fn is_located(&self) -> bool {
        self.stage >= FilterStage::Located
    }

    /// Whether bearings are judged by the fix.
    pub(crate) fn is_settled(&self) -> bool {
        self.stage == FilterStage::Settled
    }

    /// Whether bearings are set aside.
    pub(crate) fn is_distrusting(&self) -> bool {
        self.is_distrusting
    }

    /// Position and velocity at a time, and their covariance; without a velocity, the velocity is exactly zero.
    pub(crate) fn state_at(&self, time_ns: i64) -> (Vector4<f64>, Matrix4<f64>) {
        let (state, covariance) = self.moved(seconds(time_ns - self.reference_ns));
        let (mut full, mut spread) = (Vector4::zeros(), Matrix4::zeros());
        full.fixed_rows_mut::<D>(0).copy_from(&state);
        spread.fixed_view_mut::<D, D>(0, 0).copy_from(&covariance);
        (full, spread)
    }

    /// Standard deviation of the velocity in the prior, m/s.
    pub(crate) fn speed_sigma_mps(&self) -> f64 {
        self.speed_sigma_mps
    }

    /// Twice the logarithm by which rest at the fixed point's fix explains the lines worse; infinite if unknown.
    ///
    /// Far from a straight line of states the local Gaussian exaggerates; this true cost does not.
    pub(crate) fn cost_of_rest(&self) -> f64 {
        self.lead_over_rest.unwrap_or(f64::INFINITY)
    }

    /// Whether the lines fit together, but do not determine the range.
    pub(crate) fn is_range_open(&self) -> bool {
        self.stage == FilterStage::Vague
    }

    /// Compares a line of bearing with the prediction: squared normalised innovation, and the logarithm of the
    /// innovation's variance; `None` without a prediction.
    pub(crate) fn compare(&self, line: &LineOfBearing) -> Option<(f64, f64)> {
        if !self.is_located() {
            return None;
        }
        let (state, covariance) = self.moved(line.after_s(self.reference_ns));
        let residual = line.residual([state[0], state[1]])?;
        let [east, north] = residual.gradient;
        let p = &covariance;
        let spread = east * east * p[(0, 0)] + 2.0 * east * north * p[(0, 1)] + north * north * p[(1, 1)];
        let variance = spread + 1.0 / line.information;
        Some((
            residual.innovation_rad * residual.innovation_rad / variance,
            variance.ln(),
        ))
    }

    /// Processes the next line. A model with process noise takes no line before the start state is set.
    pub(crate) fn add(&mut self, line: &LineOfBearing, bounds: Bounds) -> BearingTreatment {
        if self.is_recursive() {
            return self.add_recursively(line);
        }
        if self.stage == FilterStage::Empty {
            self.begin(line);
        }
        self.bearings += 1;
        self.since_linearised += 1;
        let taken = match self.stage {
            FilterStage::Settled => self.judge(line, bounds),
            _ => BearingTreatment::Used,
        };
        self.settled_for = match self.stage {
            FilterStage::Settled => self.settled_for + 1,
            _ => 0,
        };
        let is_used = taken.is_used();
        if is_used {
            self.improve(line);
        }
        self.keep(LineOfBearing { is_used, ..*line });
        if line.ray().is_none() && self.ranges.is_some() {
            self.search_without_ranges();
        }
        let is_distrusted = matches!(taken, BearingTreatment::Distrusted(_));
        if is_distrusted || self.is_due() {
            self.linearise();
        }
        let is_weak = self.settled_for < YOUNG || self.shares(line)[1] > LOCATED_SHARE;
        if is_distrusted && is_weak || self.wrong > WRONG_MAX {
            // The fix is young, rests on removed lines, or differs from most arrival times, which do not go wrong
            // together: the fix is wrong, not the lines.
            self.restart();
        }
        self.look_at_geometry(line);
        taken
    }

    /// Sets the next line aside, because a more accurate model rejects the line. `since_ns`: with all lines since then,
    /// because that model has detected the error only now.
    pub(crate) fn set_aside(&mut self, line: &LineOfBearing, since_ns: Option<i64>) {
        if self.is_recursive() {
            // Lines already folded in cannot be removed.
            if since_ns.is_some() {
                self.stage = FilterStage::Empty;
            }
            return;
        }
        if self.stage == FilterStage::Empty {
            self.begin(line);
        }
        if since_ns.is_some() {
            self.window.take_back(TAKEN_BACK, since_ns);
            self.linearise();
        }
        self.keep(LineOfBearing {
            is_used: false,
            ..*line
        });
    }

    /// The extended Kalman filter.
    fn add_recursively(&mut self, line: &LineOfBearing) -> BearingTreatment {
        if self.stage != FilterStage::Settled {
            return BearingTreatment::Used;
        }
        // With process noise the state is always at fault, and the bearings correct the state.
        self.advance(line.time_ns);
        if let Some((squared, _)) = self.compare(line).filter(|_| line.has_outliers()) {
            self.counted(line, squared.sqrt());
            if self.wrong > WRONG_MAX {
                // Most arrival times differ: the state is not that of the emitter.
                self.stage = FilterStage::Empty;
            }
        }
        self.improve(line);
        BearingTreatment::Used
    }

    /// Whether the window is to be linearised anew: at every bearing at first, then less often.
    fn is_due(&self) -> bool {
        let wait = match self.stage {
            // A velocity is found late: while the filter is young, the linearisation ages fast.
            FilterStage::Settled if D == 4 => (self.settled_for / 16).min(RELINEARISED_EVERY),
            FilterStage::Settled => RELINEARISED_EVERY,
            _ => (self.bearings / SEARCHED_EVERY).min(RELINEARISED_EVERY),
        };
        self.since_linearised >= wait.max(1)
    }

    /// Restarts with the lines of the window alone.
    pub(crate) fn restart(&mut self) {
        let Some(first) = self.window.all().first().copied() else {
            self.stage = FilterStage::Empty;
            return;
        };
        self.begin(&first);
        self.window.use_all();
        self.stage = FilterStage::Searching;
        self.linearise();
    }

    /// Corrects the kept differences of arrival times: see [`Window::set_clocks`].
    pub(crate) fn set_clocks(&mut self, ahead: &impl Fn([u16; 2], i64) -> Option<(f64, f64)>) {
        self.window.set_clocks(ahead);
    }

    /// Restarts at the state of another filter of the same kind; returns whether that filter has a state.
    pub(crate) fn restart_like(&mut self, other: &Self) -> bool {
        let Some(factor) = Factor::of(&other.covariance).filter(|_| other.is_settled() && !other.is_distrusting) else {
            return false;
        };
        self.reference_ns = other.reference_ns;
        self.estimate = other.estimate;
        self.covariance = other.covariance;
        self.prior.mean = other.estimate;
        self.prior.information = factor.inverse();
        self.window.clear();
        self.ranges = None;
        self.stage = FilterStage::Settled;
        (self.sum, self.wrong, self.is_distrusting) = (0.0, 0.0, false);
        self.lead_over_rest = None;
        true
    }

    /// Tests rest at a fixed point, and continues from there if rest explains prior and window better: a search that
    /// began with few bearings may have ended at a false position.
    pub(crate) fn reconsider(&mut self, position_m: Option<[f64; 2]>, latest: &LineOfBearing) {
        if self.is_recursive() || self.since_linearised > 0 || self.ranges.is_some() || self.stage < FilterStage::Vague
        {
            return;
        }
        self.lead_over_rest = None;
        let Some(position_m) = position_m else { return };
        let mut at = SVector::zeros();
        at[0] = position_m[0];
        at[1] = position_m[1];
        let cost = |at| self.problem(self.window.all()).cost(at);
        let lead = cost(&at) - cost(&self.estimate);
        self.lead_over_rest = Some(lead);
        if lead < 0.0 {
            self.estimate = at;
            self.stage = FilterStage::Vague;
            self.linearise();
            self.look_at_geometry(latest);
        }
    }

    fn is_recursive(&self) -> bool {
        self.model.process_noise > 0.0
    }

    fn begin(&mut self, first: &LineOfBearing) {
        let unknown = StartPoint {
            time_ns: first.time_ns,
            position_m: first.origin_m(),
            sigma_m: self.model.range_sigma_m,
        };
        let start = self.model.start.unwrap_or(unknown);
        self.reference_ns = start.time_ns;
        self.prior = StatePrior::default();
        self.ranges = match self.model.start {
            None if D == 4 => RangeHypotheses::new(first, self.model.range_sigma_m),
            _ => None,
        };
        self.speed_sigma_mps = match self.ranges {
            Some(_) => self.model.slow_sigma_mps,
            None => self.model.speed_sigma_mps,
        };
        for axis in 0..D {
            let sigma = match axis {
                0 | 1 => start.sigma_m,
                _ => self.speed_sigma_mps,
            };
            self.prior.information[(axis, axis)] = 1.0 / (sigma * sigma);
        }
        self.prior.mean[0] = start.position_m[0];
        self.prior.mean[1] = start.position_m[1];
        self.stage = FilterStage::Searching;
        (self.sum, self.wrong, self.is_distrusting) = (0.0, 0.0, false);
    }

    /// Judges a line by the prediction of the settled filter.
    fn judge(&mut self, line: &LineOfBearing, bounds: Bounds) -> BearingTreatment {
        let Some((squared, _)) = self.compare(line) else {
            return BearingTreatment::SetAside;
        };
        let residual = line.residual(self.position_at(line.time_ns));
        let sign = residual.map_or(0.0, |residual| residual.innovation_rad.signum());
        let deviation = sign * squared.sqrt();
        self.sum = SUM_KEPT * self.sum + self.counted(line, deviation);
        let sum = self.sum / SUM_SIGMA;
        if self.is_distrusting {
            if sum.abs() < AGREE_SUM && deviation.abs() < AGREE_ONE && self.wrong < WRONG_AGREE {
                self.is_distrusting = false;
                return BearingTreatment::Trusted;
            }
            return BearingTreatment::SetAside;
        }
        if sum.abs() > bounds.limit || self.wrong > WRONG_MAX {
            self.is_distrusting = true;
            self.window.take_back(TAKEN_BACK, bounds.turning_since_ns);
            return BearingTreatment::Distrusted(sum);
        }
        match deviation.abs() > DEVIATION_MAX {
            true => BearingTreatment::SetAside,
            false => BearingTreatment::Used,
        }
    }

    /// Part of a deviation that counts in the running sum. Arrival times that are far off come singly, and do not count
    /// in the sum; if most are, the fix is wrong.
    fn counted(&mut self, line: &LineOfBearing, deviation: f64) -> f64 {
        if !line.has_outliers() {
            return deviation.clamp(-DEVIATION_MAX, DEVIATION_MAX);
        }
        let is_wrong = deviation.abs() > DEVIATION_MAX;
        let kept = WRONG_KEPT[usize::from(self.settled_for >= YOUNG)];
        self.wrong = kept * self.wrong + (1.0 - kept) * f64::from(u8::from(is_wrong));
        if is_wrong { 0.0 } else { deviation }
    }

    /// Update of the extended Kalman filter; valid until the next linearisation.
    fn improve(&mut self, line: &LineOfBearing) {
        if self.stage < FilterStage::Vague {
            return;
        }
        let after_s = line.after_s(self.reference_ns);
        let Some(residual) = line.residual(position(&self.estimate, after_s)) else {
            return;
        };
        let h = sensitivity::<D>(residual.gradient, after_s);
        let spread = self.covariance * h;
        let expected = h.dot(&spread);
        let mut variance = 1.0 / line.information;
        // An outlier enters with a standard deviation as large as the innovation.
        let squared = residual.innovation_rad * residual.innovation_rad / (expected + variance);
        variance *= (squared / (DEVIATION_MAX * DEVIATION_MAX)).max(1.0);
        let gain = spread / (expected + variance);
        self.estimate += gain * residual.innovation_rad;
        let covariance = self.covariance - gain * spread.transpose();
        self.covariance = (covariance + covariance.transpose()) * 0.5;
    }

    /// Puts a line into the window, making room as lossless as can be.
    fn keep(&mut self, line: LineOfBearing) {
        if self.window.is_full() && !self.window.forget_unused() {
            let place = (self.stage >= FilterStage::Vague).then(|| self.position_at(line.time_ns));
            let (estimate, reference_ns) = (self.estimate, self.reference_ns);
            let at = |time_ns| position(&estimate, seconds(time_ns - reference_ns));
            let merged = place.map_or(0, |_| self.window.merge_pairs(at));
            if merged > 0 {
                // Differences of arrival times stay unchanged, so that the clocks can be corrected later.
            } else if self.is_settled() && self.may_fold(FOLDED_AT_ONCE) {
                self.fold(FOLDED_AT_ONCE);
            } else if self.stage == FilterStage::Searching && self.is_misfit {
                self.window.forget_first(FOLDED_AT_ONCE);
            } else if self.window.merge(place) == 0 {
                match self.is_located() {
                    true => {
                        self.end_ranges();
                        self.fold(FOLDED_AT_ONCE);
                    }
                    false => _ = self.window.merge(None),
                }
            }
            if self.window.is_full() {
                // No line could be folded or merged: used and unused lines alternate.
                self.window.forget_first(1);
            }
        }
        self.window.push(line);
    }

    /// Returns whether the first `count` lines are far enough from the emitter to be linearised for good.
    fn may_fold(&self, count: usize) -> bool {
        let error_m = self.error_m(self.reference_ns);
        self.window.all()[..count].iter().all(|line| {
            let position_m = position(&self.estimate, line.after_s(self.reference_ns));
            error_m < LINEAR_SHARE * line.distance_m(position_m)
        })
    }

    /// Makes the first `count` lines part of the prior, which moves to the time of the last of these lines.
    fn fold(&mut self, count: usize) {
        let folded = &self.window.all()[..count];
        let system = self.problem(folded).linearised(&self.estimate);
        let Some(factor) = Factor::of(&system.information) else {
            return;
        };
        let mean = self.estimate + factor.solve(&system.gradient);
        let time_ns = folded[count - 1].time_ns;
        let after_s = seconds(time_ns - self.reference_ns);
        let (back, forth) = (transition::<D>(-after_s), transition::<D>(after_s));
        self.prior.mean = forth * mean;
        self.prior.information = back.transpose() * system.information * back;
        self.estimate = forth * self.estimate;
        self.covariance = forth * self.covariance * forth.transpose();
        self.reference_ns = time_ns;
        self.window.forget_first(count);
    }

    /// Searches the state that explains prior and window best, with all lines linearised there.
    fn linearise(&mut self) {
        self.since_linearised = 0;
        if self.ranges.is_some() {
            self.search_ranges();
            return;
        }
        let is_first = self.stage == FilterStage::Searching;
        let Some(start) = self.start() else { return };
        let rounds = if is_first { ROUNDS_FIRST } else { ROUNDS };
        let Some(found) = self.problem(self.window.all()).search(start, rounds) else {
            return;
        };
        let at = found.state;
        if !at.iter().all(|value| value.is_finite()) || (is_first && !found.has_converged) {
            return;
        }
        self.is_misfit = self.stage < FilterStage::Settled && !found.is_plausible;
        if self.is_misfit {
            // The position fitted a few bearings, but does not fit all.
            self.stage = FilterStage::Searching;
            return;
        }
        self.estimate = at;
        self.covariance = found.covariance;
        if is_first {
            self.stage = FilterStage::Vague;
        }
    }

    /// Searches with a hypothesis for each range.
    fn search_ranges(&mut self) {
        let lines = self.window.all();
        if lines.iter().filter(|line| line.is_used).count() < BEARINGS_MIN {
            return;
        }
        let (prior, range_sigma_m) = (&self.prior, self.model.range_sigma_m);
        let Some(found) =
            (self.ranges.as_mut()).and_then(|ranges| ranges.search(prior, range_sigma_m, lines, self.reference_ns))
        else {
            return;
        };
        let squared: f64 = found.mean.iter().skip(2).map(|speed| speed * speed).sum();
        let is_fast = squared > (SPEED_SIGMAS * self.speed_sigma_mps).powi(2);
        if (is_fast || !found.is_plausible) && self.speed_sigma_mps < self.model.speed_sigma_mps {
            self.widen_speed();
            return;
        }
        self.is_misfit = !found.is_plausible;
        if self.is_misfit {
            // The lines at hand later may fit together: all ranges are possible again.
            self.stage = FilterStage::Searching;
            self.renew_ranges();
            return;
        }
        self.estimate = found.mean;
        self.covariance = found.covariance;
        self.stage = self.stage.max(FilterStage::Vague);
    }

    /// Continues with a wider prior of the velocity, and all ranges again.
    fn widen_speed(&mut self) {
        self.speed_sigma_mps = (2.0 * self.speed_sigma_mps).min(self.model.speed_sigma_mps);
        for axis in 2..D {
            self.prior.information[(axis, axis)] = self.speed_sigma_mps.powi(-2);
        }
        self.renew_ranges();
        self.since_linearised = RELINEARISED_EVERY;
    }

    /// Continues without hypotheses about the range, which lines of other kinds than bearings show.
    fn search_without_ranges(&mut self) {
        self.ranges = None;
        self.stage = FilterStage::Searching;
        self.speed_sigma_mps = self.model.speed_sigma_mps;
        for axis in 2..D {
            self.prior.information[(axis, axis)] = self.speed_sigma_mps.powi(-2);
        }
    }

    fn renew_ranges(&mut self) {
        if let Some(first) = self.window.all().first() {
            self.ranges = RangeHypotheses::new(first, self.model.range_sigma_m);
        }
    }

    fn problem<'a>(&'a self, lines: &'a [LineOfBearing]) -> LeastSquaresProblem<'a, D> {
        LeastSquaresProblem {
            reference_ns: self.reference_ns,
            prior: &self.prior,
            lines,
        }
    }

    /// Starting point of the search.
    fn start(&self) -> Option<SVector<f64, D>> {
        if self.stage != FilterStage::Searching {
            return Some(self.estimate);
        }
        if self.model.start.is_some() {
            return Some(self.prior.mean);
        }
        let [east, north] = start_position(self.window.all())?;
        let mut start = SVector::zeros();
        start[0] = east;
        start[1] = north;
        Some(start)
    }

    /// Judges whether the geometry allows a fix.
    fn look_at_geometry(&mut self, latest: &LineOfBearing) {
        if self.stage < FilterStage::Vague {
            return;
        }
        let [present, longest] = self.shares(latest);
        let (share, is_located) = match self.ranges.is_some() {
            true => (present, present < LOCATED_SHARE || longest < LOCATED_SHARE_LONGEST),
            false => (longest, longest < LOCATED_SHARE),
        };
        if share > LOST_SHARE {
            self.stage = FilterStage::Vague;
        } else if is_located {
            self.stage = self.stage.max(FilterStage::Located);
        }
        if share < SETTLED_SHARE {
            self.stage = FilterStage::Settled;
            self.end_ranges();
        }
    }

    /// Continues from the mixture of ranges with a single state.
    fn end_ranges(&mut self) {
        if self.ranges.take().is_some() {
            self.linearise();
        }
    }

    /// Longest half-axis of the error ellipse over the present range, and over the longer of the first and the present
    /// range.
    fn shares(&self, latest: &LineOfBearing) -> [f64; 2] {
        let range = |line: &LineOfBearing| line.distance_m(self.position_at(line.time_ns));
        let (present_m, error_m) = (range(latest), self.error_m(latest.time_ns));
        let first_m = self.window.all().first().map_or(0.0, range);
        [error_m / present_m, error_m / present_m.max(first_m)]
    }

    /// Longest half-axis of the position's error ellipse at a time, metres.
    fn error_m(&self, time_ns: i64) -> f64 {
        let (_, covariance) = self.moved(seconds(time_ns - self.reference_ns));
        longest_half_axis(&covariance.fixed_view::<2, 2>(0, 0).into_owned())
    }

    fn position_at(&self, time_ns: i64) -> [f64; 2] {
        position(&self.estimate, seconds(time_ns - self.reference_ns))
    }

    /// State and covariance moved to another time, with the process noise of the way.
    fn moved(&self, after_s: f64) -> (SVector<f64, D>, SMatrix<f64, D, D>) {
        if after_s == 0.0 {
            return (self.estimate, self.covariance);
        }
        let forth = transition::<D>(after_s);
        let mut covariance = forth * self.covariance * forth.transpose();
        add_process_noise(&mut covariance, self.model.process_noise, after_s.max(0.0));
        (forth * self.estimate, covariance)
    }

    fn advance(&mut self, time_ns: i64) {
        (self.estimate, self.covariance) = self.moved(seconds(time_ns - self.reference_ns));
        self.reference_ns = time_ns;
    }
}

fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}

kept_variants!(FilterStage {
    Empty,
    Searching,
    Vague,
    Located,
    Settled,
});
kept!(Model {
    process_noise: f64,
    range_sigma_m: f64,
    speed_sigma_mps: f64,
    slow_sigma_mps: f64,
    start: Option<StartPoint>,
});
kept!(StartPoint {
    time_ns: i64,
    position_m: [f64; 2],
    sigma_m: f64,
});

/// Fields of a filter of so many components, in the memory for a successor.
macro_rules! kept_smoother {
    ($components:literal) => {
        kept!(Smoother<$components> {
            model: Model,
            reference_ns: i64,
            prior: StatePrior<$components>,
            speed_sigma_mps: f64,
            ranges: Option<RangeHypotheses<$components>>,
            window: Window,
            estimate: SVector<f64, $components>,
            covariance: SMatrix<f64, $components, $components>,
            bearings: u64,
            since_linearised: u64,
            settled_for: u64,
            stage: FilterStage,
            is_misfit: bool,
            lead_over_rest: Option<f64>,
            sum: f64,
            wrong: f64,
            is_distrusting: bool,
        });
    };
}
kept_smoother!(2);
kept_smoother!(4);
