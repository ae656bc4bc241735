//! The filter: all bearings at once for as long as it matters, then one after the other (EL-2).
//!
//! A bearing says nothing about range; range comes from how the bearings change while the platform flies. The obvious
//! filter, an extended Kalman filter, linearises each bearing once, where it believes the emitter to be at that time. At
//! first it believes a triangulation of a few nearly parallel bearings, which may be wrong by its own size. What it then
//! takes the bearings to say of the range is wrong, and nothing undoes it: with an emitter 50 km away the filter ends seven
//! times worse than the bearings allow, and is sure of itself.
//!
//! Here nothing is linearised for good while it matters. The last sightings are kept ([`crate::window`]); what they say together
//! is found by Gauss–Newton iteration, that is, with all of them linearised anew where the emitter is believed to be *now*
//! (the maximum-likelihood estimate). Only sightings for which the position is known to a fiftieth of their range go
//! into a Gaussian prior for good, and for them the linearisation is exact enough.
//!
//! An emitter is a fixed point (two components: position) or moves straight on (four: velocity, too). Without process noise
//! the state at a reference time holds all there is, and no bearing is ever forgotten. With process noise, for emitters
//! that wander or manoeuvre, the same search gives the start, and from then on it is the extended Kalman filter, which works
//! well once it knows the range.
//!
//! # Bearings that are wrong
//!
//! One that is off by more than four standard deviations counts the less the farther off it is (as in Huber's
//! estimator). But a platform that turns gives bearings that are wrong *together*: each by little, all to one side, and a
//! filter averages them in. A running sum of the normalised innovations, in which the last ten or so count, sees that: it
//! is Gaussian with known variance as long as bearings and state are right. When it leaves its bounds, the last
//! sightings are taken back and new ones set aside until they agree again. If they never do, it is the state that is wrong;
//! [`crate::bank`] decides that.
//!
//! # Evidence
//!
//! Each filter keeps score of how improbable its model makes the bearings: −2 log likelihood, up to a constant that is
//! the same for all models, with the last few hundred bearings counting. With it comes the price of freedom: a
//! model with a velocity spreads its prior over all velocities, and must earn that.
//!
//! Sources: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation* (Wiley,
//! 2001), chapters 3 and 10; B. M. Bell, F. W. Cathey, *The iterated Kalman filter update as a Gauss–Newton method*,
//! IEEE Transactions on Automatic Control 38 (1993).

use nalgebra::{Matrix2, Matrix4, SMatrix, SVector};

use crate::linear::Factor;
use crate::sighting::Sighting;
use crate::triangulation::crossing;
use crate::window::Window;

/// The geometry allows a fix when the longest half-axis of its error ellipse is below this share of the range.
const LOCATED_SHARE: f64 = 0.3;
/// From this share on the linearisation is good enough to judge bearings one by one.
const SETTLED_SHARE: f64 = 0.1;
/// From this share on a sighting may be linearised for good.
const LINEAR_SHARE: f64 = 0.02;
/// Sightings that go into the prior at a time.
const FOLDED_AT_ONCE: usize = 16;
/// Bearings after which a settled filter linearises its window anew.
const RELINEARISED_EVERY: u32 = 8;
/// Rounds of the search for a first fix, and of its improvement.
const ROUNDS_FIRST: usize = 20;
const ROUNDS: usize = 3;
/// Steps of less than this squared statistical length are not worth another round.
const STEP_SQUARED_MIN: f64 = 1e-4;
/// Fewest sightings of a fix.
const SIGHTINGS_MIN: usize = 3;

/// Normalised innovations beyond this count less.
const DEVIATION_MAX: f64 = 4.0;
/// What a bearing adds to the score at most: the square of three standard deviations.
const SCORE_MAX: f64 = 9.0;
/// What is kept of the running sum of innovations at each bearing, and the sum's standard deviation.
const SUM_KEPT: f64 = 0.85;
const SUM_SIGMA: f64 = 1.898_315_991;
/// Sightings that are taken back when the sum leaves its bounds.
const TAKEN_BACK: usize = 8;
/// A sum within this many standard deviations, and an innovation within its own, let bearings in again.
const AGREE_SUM: f64 = 1.0;
const AGREE_ONE: f64 = 2.5;
/// What a restarted model pays per bearing until it can be judged again.
const RESTART_PENALTY: f64 = 3.0;

/// How an emitter is assumed to move, and what is known of it before the first bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Model {
    /// Fixed point: m²/s; straight motion: m²/s³.
    pub(crate) process_noise: f64,
    /// Standard deviation of an unknown emitter's position about the platform, metres.
    pub(crate) range_sigma_m: f64,
    /// … of its speed along each axis, m/s; of no meaning for fixed points.
    pub(crate) speed_sigma_mps: f64,
    /// Bearings that count in the score.
    pub(crate) memory: f64,
}

/// What became of a bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Taken {
    /// Used.
    Used,
    /// Not used: it disagrees, or those before it do.
    SetAside,
    /// The first that was set aside; the sum of innovations in standard deviations.
    Distrusted(f64),
    /// The first that agrees again.
    Trusted,
}

/// Filter of one emitter for one model, of D components: position and, if D is 4, velocity.
#[derive(Clone, Debug)]
pub(crate) struct Smoother<const D: usize> {
    model: Model,
    /// Time of prior and estimate.
    reference_ns: i64,
    prior_mean: SVector<f64, D>,
    prior_information: SMatrix<f64, D, D>,
    /// Determinant's logarithm of the first prior's information: what freedom costs.
    log_freedom: f64,
    window: Window,
    estimate: SVector<f64, D>,
    covariance: SMatrix<f64, D, D>,
    /// Bearings so far, and since the window was linearised.
    bearings: u64,
    since_linearised: u32,
    stage: Stage,
    sum: f64,
    is_distrusting: bool,
    score: f64,
    is_scored_singly: bool,
}

/// How much is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Stage {
    /// Nothing yet.
    Empty,
    /// Sightings, and no place that explains them.
    Searching,
    /// A place, and the geometry does not allow to say it.
    Vague,
    /// A fix.
    Located,
    /// … by which bearings can be judged.
    Settled,
}

/// The window and the prior, linearised at a state.
struct System<const D: usize> {
    information: SMatrix<f64, D, D>,
    gradient: SVector<f64, D>,
    cost: f64,
    sightings: usize,
}

impl<const D: usize> Smoother<D> {
    pub(crate) fn new(model: Model) -> Self {
        const { assert!(D == 2 || D == 4, "position, or position and velocity") };
        Self {
            model,
            reference_ns: 0,
            prior_mean: SVector::zeros(),
            prior_information: SMatrix::zeros(),
            log_freedom: 0.0,
            window: Window::EMPTY,
            estimate: SVector::zeros(),
            covariance: SMatrix::zeros(),
            bearings: 0,
            since_linearised: 0,
            stage: Stage::Empty,
            sum: 0.0,
            is_distrusting: false,
            score: 0.0,
            is_scored_singly: false,
        }
    }

    /// Whether there is a fix.
    pub(crate) fn is_located(&self) -> bool {
        self.stage >= Stage::Located
    }

    /// Whether bearings are judged by the fix.
    pub(crate) fn is_settled(&self) -> bool {
        self.stage == Stage::Settled
    }

    /// Whether bearings are set aside.
    pub(crate) fn is_distrusting(&self) -> bool {
        self.is_distrusting
    }

    /// How improbable the model makes the bearings; less is better.
    pub(crate) fn score(&self) -> f64 {
        self.score
    }

    /// Position and velocity at a time, and their covariance.
    pub(crate) fn state_at(&self, time_ns: i64) -> ([f64; 2], [f64; 2], Matrix4<f64>) {
        let after_s = seconds(time_ns - self.reference_ns);
        let (state, covariance) = self.moved(after_s);
        let mut full = Matrix4::zeros();
        full.fixed_view_mut::<D, D>(0, 0).copy_from(&covariance);
        let velocity = match D {
            4 => [state[2], state[3]],
            _ => [0.0; 2],
        };
        ([state[0], state[1]], velocity, full)
    }

    /// How a sighting compares with what is expected: squared normalised innovation, and the logarithm of the innovation's
    /// variance; `None` where nothing is expected.
    pub(crate) fn compare(&self, sighting: &Sighting) -> Option<(f64, f64)> {
        if !self.is_located() {
            return None;
        }
        let (state, covariance) = self.moved(sighting.after_s(self.reference_ns));
        let residual = sighting.residual([state[0], state[1]])?;
        let [east, north] = residual.gradient;
        let p = &covariance;
        let spread = east * east * p[(0, 0)] + 2.0 * east * north * p[(0, 1)] + north * north * p[(1, 1)];
        let variance = spread + 1.0 / sighting.information;
        Some((
            residual.innovation_rad * residual.innovation_rad / variance,
            variance.ln(),
        ))
    }

    /// Takes the next sighting. `limit` is how many standard deviations the sum of innovations may have.
    pub(crate) fn add(&mut self, sighting: &Sighting, limit: f64) -> Taken {
        if self.stage == Stage::Empty {
            self.begin(sighting);
        }
        self.bearings += 1;
        self.since_linearised += 1;
        self.score *= 1.0 - 1.0 / self.model.memory;
        if self.is_settled() && self.is_recursive() {
            self.advance(sighting.time_ns);
        }
        let taken = match self.stage {
            Stage::Settled => self.judge(sighting, limit),
            _ => Taken::Used,
        };
        let is_used = matches!(taken, Taken::Used | Taken::Trusted);
        if is_used {
            self.improve(sighting);
        }
        if !(self.is_settled() && self.is_recursive()) {
            self.keep(Sighting { is_used, ..*sighting });
            let is_due = match self.stage {
                Stage::Settled => self.since_linearised >= RELINEARISED_EVERY || matches!(taken, Taken::Distrusted(_)),
                Stage::Located | Stage::Vague => self.bearings <= 64 || self.bearings.is_multiple_of(4),
                _ => self.bearings <= 16 || self.bearings.is_multiple_of(8),
            };
            if is_due {
                self.linearise();
            }
            self.look_at_geometry(sighting);
        }
        taken
    }

    /// Begins anew: with the sightings of the window, and nothing else.
    pub(crate) fn restart(&mut self) {
        let Some(first) = self.window.all().first().copied() else {
            self.stage = Stage::Empty;
            return;
        };
        self.begin(&first);
        self.window.use_last(usize::MAX, true);
        self.stage = Stage::Searching;
        self.linearise();
    }

    /// Begins anew where another filter of the same kind is.
    pub(crate) fn restart_like(&mut self, other: &Self) {
        if let Some(factor) = Factor::of(&other.covariance).filter(|_| other.is_settled()) {
            self.reference_ns = other.reference_ns;
            self.estimate = other.estimate;
            self.covariance = other.covariance;
            self.prior_mean = other.estimate;
            self.prior_information = factor.inverse();
            self.window.clear();
            self.stage = Stage::Settled;
            (self.sum, self.is_distrusting) = (0.0, false);
        } else {
            self.restart();
        }
    }

    fn is_recursive(&self) -> bool {
        self.model.process_noise > 0.0
    }

    fn begin(&mut self, first: &Sighting) {
        self.reference_ns = first.time_ns;
        self.prior_mean = SVector::zeros();
        self.prior_information = SMatrix::zeros();
        for axis in 0..D {
            let sigma = match axis {
                0 | 1 => self.model.range_sigma_m,
                _ => self.model.speed_sigma_mps,
            };
            self.prior_information[(axis, axis)] = 1.0 / (sigma * sigma);
        }
        self.prior_mean[0] = first.platform_m[0];
        self.prior_mean[1] = first.platform_m[1];
        self.log_freedom = (0..D).map(|axis| self.prior_information[(axis, axis)].ln()).sum();
        self.stage = Stage::Searching;
        (self.sum, self.is_distrusting) = (0.0, false);
    }

    /// Whether a sighting is to be believed, by what the settled filter expects.
    fn judge(&mut self, sighting: &Sighting, limit: f64) -> Taken {
        let Some((squared, log_variance)) = self.compare(sighting) else {
            return Taken::SetAside;
        };
        self.score += squared.min(SCORE_MAX) - 1.0 + log_variance + sighting.information.ln();
        if self.is_recursive() {
            // With process noise the covariance grows until bearings are believed again.
            return Taken::Used;
        }
        let residual = sighting.residual(self.position_at(sighting.time_ns));
        let sign = residual.map_or(0.0, |residual| residual.innovation_rad.signum());
        let deviation = sign * squared.sqrt();
        self.sum = SUM_KEPT * self.sum + deviation.clamp(-DEVIATION_MAX, DEVIATION_MAX);
        let sum = self.sum / SUM_SIGMA;
        if self.is_distrusting {
            if sum.abs() < AGREE_SUM && deviation.abs() < AGREE_ONE {
                self.is_distrusting = false;
                return Taken::Trusted;
            }
            return Taken::SetAside;
        }
        if sum.abs() > limit {
            self.is_distrusting = true;
            self.window.use_last(TAKEN_BACK, false);
            return Taken::Distrusted(sum);
        }
        match deviation.abs() > DEVIATION_MAX {
            true => Taken::SetAside,
            false => Taken::Used,
        }
    }

    /// The extended Kalman filter's update; until the next linearisation it is what there is.
    fn improve(&mut self, sighting: &Sighting) {
        if self.stage < Stage::Vague {
            return;
        }
        let after_s = sighting.after_s(self.reference_ns);
        let Some(residual) = sighting.residual(position(&self.estimate, after_s)) else {
            return;
        };
        let h = sensitivity::<D>(residual.gradient, after_s);
        let spread = self.covariance * h;
        let expected = h.dot(&spread);
        let mut variance = 1.0 / sighting.information;
        // An outlier is taken for what it is: a bearing as bad as that.
        let squared = residual.innovation_rad * residual.innovation_rad / (expected + variance);
        variance *= (squared / (DEVIATION_MAX * DEVIATION_MAX)).max(1.0);
        let gain = spread / (expected + variance);
        self.estimate += gain * residual.innovation_rad;
        let covariance = self.covariance - gain * spread.transpose();
        self.covariance = (covariance + covariance.transpose()) * 0.5;
    }

    /// Puts a sighting into the window, making room as lossless as can be.
    fn keep(&mut self, sighting: Sighting) {
        if self.window.is_full() && !self.window.forget_unused() {
            let place = (self.stage >= Stage::Vague).then(|| self.position_at(sighting.time_ns));
            if self.may_fold(FOLDED_AT_ONCE) {
                self.fold(FOLDED_AT_ONCE);
            } else if !self.window.merge(place, false) {
                match self.is_located() {
                    true => self.fold(FOLDED_AT_ONCE),
                    false => _ = self.window.merge(place, true),
                }
            }
        }
        self.window.push(sighting);
    }

    /// Whether the first `count` sightings are so far from the emitter that they may be linearised for good.
    fn may_fold(&self, count: usize) -> bool {
        let error_m = self.error_m(self.reference_ns);
        self.is_settled()
            && self.window.all()[..count].iter().all(|sighting| {
                let position_m = position(&self.estimate, sighting.after_s(self.reference_ns));
                error_m < LINEAR_SHARE * sighting.distance_m(position_m)
            })
    }

    /// Makes the first `count` sightings part of the prior, which moves to the time of the last of them.
    fn fold(&mut self, count: usize) {
        let folded = &self.window.all()[..count];
        let system = self.system(&self.estimate, folded);
        let Some(factor) = Factor::of(&system.information) else {
            return;
        };
        let mean = self.estimate + factor.solve(&system.gradient);
        let time_ns = folded[count - 1].time_ns;
        let after_s = seconds(time_ns - self.reference_ns);
        let (back, forth) = (transition::<D>(-after_s), transition::<D>(after_s));
        self.prior_mean = forth * mean;
        self.prior_information = back.transpose() * system.information * back;
        self.estimate = forth * self.estimate;
        self.covariance = forth * self.covariance * forth.transpose();
        self.reference_ns = time_ns;
        self.window.forget_first(count);
    }

    /// Searches the state that explains prior and window best, linearising all of it where that is.
    fn linearise(&mut self) {
        self.since_linearised = 0;
        let is_first = self.stage == Stage::Searching;
        let Some(mut at) = self.start() else { return };
        let mut system = self.system(&at, self.window.all());
        let rounds = if is_first { ROUNDS_FIRST } else { ROUNDS };
        let mut has_converged = false;
        for _ in 0..rounds {
            let Some(factor) = Factor::of(&system.information) else {
                return;
            };
            let step = factor.solve(&system.gradient);
            if system.gradient.dot(&step) < STEP_SQUARED_MIN {
                has_converged = true;
                at += step;
                break;
            }
            let Some((next, there)) = self.descend(&at, &step, &system) else {
                break;
            };
            (at, system) = (next, there);
        }
        let Some(factor) = Factor::of(&system.information) else {
            return;
        };
        if (is_first && !has_converged) || !at.iter().all(|value| value.is_finite()) {
            return;
        }
        self.estimate = at;
        self.covariance = factor.inverse();
        if is_first {
            self.stage = Stage::Vague;
        }
        if !self.is_scored_singly {
            self.score = system.cost - system.sightings as f64 + factor.log_determinant() - self.log_freedom;
        }
    }

    /// Where to begin the search.
    fn start(&self) -> Option<SVector<f64, D>> {
        if self.stage != Stage::Searching {
            return Some(self.estimate);
        }
        if self.window.all().iter().filter(|sighting| sighting.is_used).count() < SIGHTINGS_MIN {
            return None;
        }
        let crossing = crossing(self.window.all())?;
        let mut start = SVector::zeros();
        start[0] = crossing[0];
        start[1] = crossing[1];
        Some(start)
    }

    /// A step along `step` after which prior and sightings fit better; it goes at most half of the way to the platform.
    fn descend(
        &self,
        at: &SVector<f64, D>,
        step: &SVector<f64, D>,
        system: &System<D>,
    ) -> Option<(SVector<f64, D>, System<D>)> {
        let range = self
            .window
            .all()
            .last()
            .map_or(f64::MAX, |last| last.distance_m([at[0], at[1]]));
        let length = step[0].hypot(step[1]);
        let mut share = (0.5 * range / length.max(f64::MIN_POSITIVE)).min(1.0);
        for _ in 0..5 {
            let next = at + step * share;
            let there = self.system(&next, self.window.all());
            if there.cost <= system.cost {
                return Some((next, there));
            }
            share *= 0.4;
        }
        None
    }

    fn system(&self, at: &SVector<f64, D>, sightings: &[Sighting]) -> System<D> {
        let offset = self.prior_mean - at;
        let gradient = self.prior_information * offset;
        let mut system = System {
            information: self.prior_information,
            gradient,
            cost: offset.dot(&gradient),
            sightings: 0,
        };
        for sighting in sightings.iter().filter(|sighting| sighting.is_used) {
            let after_s = sighting.after_s(self.reference_ns);
            let Some(residual) = sighting.residual(position(at, after_s)) else {
                continue;
            };
            let h = sensitivity::<D>(residual.gradient, after_s);
            let squared = residual.innovation_rad * residual.innovation_rad * sighting.information;
            let (cost, weight) = robust(squared);
            let information = weight * sighting.information;
            system.cost += cost;
            system.sightings += 1;
            system.gradient += h * (information * residual.innovation_rad);
            let scaled = h * information;
            for column in 0..D {
                for row in 0..D {
                    system.information[(row, column)] += scaled[row] * h[column];
                }
            }
        }
        system
    }

    /// What the geometry allows to say.
    fn look_at_geometry(&mut self, latest: &Sighting) {
        if self.stage < Stage::Vague || self.is_settled() {
            return;
        }
        let range = |sighting: &Sighting| sighting.distance_m(self.position_at(sighting.time_ns));
        let range_m = self.window.all().first().map_or(0.0, range).max(range(latest));
        let share = self.error_m(latest.time_ns) / range_m;
        if share < LOCATED_SHARE {
            self.stage = self.stage.max(Stage::Located);
        }
        if share < SETTLED_SHARE {
            self.stage = Stage::Settled;
            self.is_scored_singly = true;
            if self.is_recursive() {
                self.window.clear();
                self.advance(latest.time_ns);
            }
        } else if self.is_scored_singly {
            self.score += RESTART_PENALTY;
        }
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

/// Cost and weight of a squared normalised innovation.
fn robust(squared: f64) -> (f64, f64) {
    const KNEE: f64 = DEVIATION_MAX * DEVIATION_MAX;
    if squared <= KNEE {
        (squared, 1.0)
    } else {
        (KNEE * (1.0 + (squared / KNEE).ln()), KNEE / squared)
    }
}

fn position<const D: usize>(state: &SVector<f64, D>, after_s: f64) -> [f64; 2] {
    match D {
        4 => [state[0] + after_s * state[2], state[1] + after_s * state[3]],
        _ => [state[0], state[1]],
    }
}

/// How a bearing after so many seconds depends on the state.
fn sensitivity<const D: usize>(gradient: [f64; 2], after_s: f64) -> SVector<f64, D> {
    SVector::from_fn(|axis, _| match axis {
        0 | 1 => gradient[axis],
        _ => gradient[axis - 2] * after_s,
    })
}

fn transition<const D: usize>(after_s: f64) -> SMatrix<f64, D, D> {
    let mut transition = SMatrix::identity();
    if D == 4 {
        transition[(0, 2)] = after_s;
        transition[(1, 3)] = after_s;
    }
    transition
}

/// White noise in the velocity of a point, or in the acceleration of a straight motion.
fn add_process_noise<const D: usize>(covariance: &mut SMatrix<f64, D, D>, density: f64, after_s: f64) {
    let q = density * after_s;
    for axis in 0..2 {
        if D == 4 {
            covariance[(axis, axis)] += q * after_s * after_s / 3.0;
            covariance[(axis, axis + 2)] += q * after_s / 2.0;
            covariance[(axis + 2, axis)] += q * after_s / 2.0;
            covariance[(axis + 2, axis + 2)] += q;
        } else {
            covariance[(axis, axis)] += q;
        }
    }
}

fn longest_half_axis(covariance: &Matrix2<f64>) -> f64 {
    let mean = 0.5 * (covariance[(0, 0)] + covariance[(1, 1)]);
    let half = 0.5 * (covariance[(0, 0)] - covariance[(1, 1)]);
    (mean + half.hypot(covariance[(0, 1)])).sqrt()
}

fn seconds(ns: i64) -> f64 {
    ns as f64 * 1e-9
}
