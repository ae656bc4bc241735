//! The solution of the normal equations of all sources, in steps of bounded work.
//!
//! A few sweeps of block Gauss–Seidel solve for the errors of the sources in turn, with the errors of all other sources
//! fixed. A first sweep solves only for sources without an estimate, so that a large error does not pass through all
//! estimates. Then the models of each source are compared. The estimates change after completion.

use crate::registration::displacement::Displacement;
use crate::registration::errors::{ClockError, PRIOR_SIGMA, SAMPLES_MIN, clock_of, prior_variances};
use crate::registration::progress::SETTLED_MIN;
use crate::registration::recent::{Recent, SOLUTIONS_MIN};
use crate::registration::rows::{Errors, NormalMatrix, TIME};
use crate::registration::steps::MISLED_TICKS;
use crate::registration::{Registration, SAMPLE_WEIGHT, gauge};
use crate::stamps::StampError;

/// Sweeps of Gauss–Seidel per solution.
const SWEEPS: usize = 4;
/// Ticks from a solution to the next while no estimate changes, and least age of such an estimate in ticks: the sums of
/// a minute hardly change within the interval.
const STEADY_TICKS: i32 = 5;
const STEADY_AGE: u32 = 60;
/// Work of a step of a solution, in visits to pairs: about ten microseconds. The source in progress is completed.
const STEP_WORK: usize = 192;
/// Work of factoring and of solving the equations of a source, in visits to pairs.
const FACTOR_WORK: usize = 16;
const SOLVE_WORK: usize = 4;
/// Work of comparing the models of a source, likewise.
const SELECT_WORK: usize = 64;
/// Time after which a further comparison of a target counts as independent in the evidence for a model, seconds: the
/// detection points and the errors of the trackers persist.
const INDEPENDENT_S: f64 = 5.0;
/// Share of contradicting differences at which the estimate is dropped.
const CONTRADICTED: f64 = 0.75;

impl Registration {
    /// Takes a tick, and begins a solution for all sources if one is due; does nothing while a solution is in progress.
    /// A solution is due each tick while an estimate is new or changes, else each [`STEADY_TICKS`]. After a step of
    /// a source's errors, the estimate is dropped, and the source is passed to `restarted`. `points` holds the size of
    /// large targets, metres, and the variance per axis of detection points, m².
    pub(crate) fn begin(&mut self, points: (f64, f64), mut restarted: impl FnMut(u16)) {
        if self.is_solving() {
            return;
        }
        let keep = self.keep.powf(1.0 / SWEEPS as f64);
        for source in &mut self.sources {
            for _ in 0..SWEEPS {
                source.samples *= keep;
            }
        }
        for ticks in &mut self.ticks {
            *ticks = ticks.saturating_add(1);
        }
        for young in &mut self.young {
            *young = young.saturating_sub(1);
        }
        for (recent, known) in self.recents.iter_mut().zip(&self.sources) {
            recent.look(self.keep_drifting, known.model);
        }
        self.look_for_step(points, &mut restarted);
        self.forget_after_step(restarted);
        self.solution.ticks += 1;
        if self.solution.ticks < STEADY_TICKS && self.is_steady() {
            return;
        }
        self.solution.sources.copy_from_slice(&self.sources);
        self.solution.best = None;
        self.solution.next = Some((0, 0));
    }

    /// Returns whether all estimates have been known for some time, and do not change.
    fn is_steady(&self) -> bool {
        (0..self.sources.len()).all(|own| {
            let is_compared = self.sources[own].samples > 0.0;
            let changes = self.recents[own].is_drift() || self.young[own] > 0;
            let is_known = self.is_settled(own as u16) && self.ticks[own] >= STEADY_AGE;
            !changes && (!is_compared || is_known)
        })
    }

    /// Returns whether a solution is in progress.
    #[inline]
    pub(crate) fn is_solving(&self) -> bool {
        self.solution.next.is_some()
    }

    /// Performs a step of the solution and returns whether the solution is now complete; then [`Self::decide`] is due.
    /// The estimate of a source with impossible or contradicted errors is dropped, and the source is passed to
    /// `restarted`. `clocks` are the clock errors of the sources from the times of receipt.
    pub(crate) fn step(&mut self, clocks: &[ClockError], mut restarted: impl FnMut(u16)) -> bool {
        let Some((mut sweep, mut own)) = self.solution.next.take() else {
            return false;
        };
        let mut work = 0;
        while sweep <= SWEEPS + 1 {
            if work >= STEP_WORK {
                self.solution.next = Some((sweep, own));
                return false;
            }
            if sweep == SWEEPS + 1 {
                self.compare_models(own, clock_of(clocks, own));
                self.solution.votes[own] = self.vote(own);
                work += SELECT_WORK + 2 * self.partners[own].count() as usize;
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
            work += SOLVE_WORK + self.partners[own].count() as usize;
            if sweep > 0 || self.solutions[own] == 0 {
                self.solve(own, clock_of(clocks, own));
            }
            own += 1;
            if own == self.sources.len() {
                if sweep > 0 && self.reference.is_none() {
                    gauge::fix(&mut self.solution.sources, &self.displacements, clocks);
                }
                (sweep, own) = (sweep + 1, 0);
            }
        }
        if let Some((_, own, model)) = self.solution.best {
            self.sources[own].model = model;
            self.steps.clear();
            // The latest differences are relative to the former model.
            self.recents.fill(Recent::default());
        }
        for own in 0..self.sources.len() {
            let solved = self.solution.sources[own];
            if solved.are_possible() && self.contradicted[own] <= CONTRADICTED {
                (self.sources[own].errors, self.sources[own].variances) = (solved.errors, solved.variances);
                let is_begun = self.sources[own].samples >= SAMPLES_MIN;
                self.solutions[own] = (self.solutions[own] + u8::from(is_begun)).min(SOLUTIONS_MIN);
            } else {
                self.forget(own);
                restarted(own as u16);
            }
        }
        if self.turn_to_majority() {
            self.steps.clear();
            self.recents.fill(Recent::default());
            self.misled_ticks = MISLED_TICKS;
        }
        self.solution.ticks = 0;
        true
    }

    /// Fades the sums of a source by the ticks since the solution before, and factors the normal equations.
    fn forget_and_factor(&mut self, own: usize, clock: ClockError) {
        let count = self.sources.len();
        let ticks = self.solution.ticks;
        self.seeds[own].fade(self.keep_drifting.powi(ticks));
        // A drift is found at the tick before the solution.
        let before = self.keep.powi(ticks - 1);
        let (mut normal, _) = prior(clock, self.sources[own].stamps);
        normal += self.seeds[own].normal;
        for other in self.partners_of(own) {
            let pair = &mut self.pairs[own * count + other];
            let drifts = self.recents[own].is_drift() || self.recents[other].is_drift();
            let keep = if drifts { self.keep_drifting } else { self.keep };
            pair.fade(before * keep);
            normal += pair.own;
        }
        let sums = self.partners_of(own).map(|other| &self.pairs[own * count + other].own);
        self.displacements[own] = Displacement::new(&self.seeds[own].normal, sums);
        self.solution.sources[own].model.hold(&mut normal);
        let is_sought = self.reference != Some(own as u16) && self.sources[own].samples != 0.0;
        let factor = if is_sought { normal.cholesky() } else { None };
        if let Some(factor) = &factor {
            let held = self.solution.sources[own].model;
            self.solution.sources[own].variances = held.known(factor.inverse().diagonal(), &prior_variances());
        }
        self.solution.factors[own] = factor;
    }

    /// Solves for the errors of a source, with the errors of all others fixed.
    fn solve(&mut self, own: usize, clock: ClockError) {
        let Some(factor) = &self.solution.factors[own] else {
            return;
        };
        let count = self.sources.len();
        let (_, mut right) = prior(clock, self.sources[own].stamps);
        right += self.seeds[own].right;
        for other in self.partners_of(own) {
            let pair = &self.pairs[own * count + other];
            right += pair.right + pair.cross * self.solution.sources[other].errors;
        }
        let known = &mut self.solution.sources[own];
        known.errors = known.model.known(factor.solve(&right), &Errors::zeros());
    }

    /// Returns the normal equations of a source without the comparisons with unsettled sources.
    fn settled_equations(&self, own: usize, clock: ClockError) -> (NormalMatrix, Errors) {
        let count = self.sources.len();
        let (mut normal, mut right) = prior(clock, self.sources[own].stamps);
        normal += self.seeds[own].normal;
        right += self.seeds[own].right;
        for other in self.partners_of(own) {
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
        let weighted = SAMPLE_WEIGHT * samples;
        let age_s = f64::from(self.ticks[own]) * self.tick_s;
        let effective = weighted.min(SAMPLE_WEIGHT * self.targets * (1.0 + age_s / INDEPENDENT_S));
        let better = self.sources[own].model.better(
            &normal,
            &right,
            effective / weighted / self.fits[own].max(1.0),
            effective,
            self.places_m[own].is_some(),
        );
        if let Some((gain, model)) = better
            && self.solution.best.is_none_or(|(best, ..)| gain > best)
        {
            self.solution.best = Some((gain, own, model));
        }
    }
}

/// Returns the normal equations of a source before any comparison: a clock that deviates from the times of receipt has
/// a prior of its own.
fn prior(clock: ClockError, stamps: StampError) -> (NormalMatrix, Errors) {
    let mut normal =
        NormalMatrix::from_diagonal(&Errors::from_fn(|row, _| 1.0 / (PRIOR_SIGMA[row] * PRIOR_SIGMA[row])));
    let mut right = Errors::zeros();
    let (information, offset_s) = match stamps.is_coarse() && clock.excess_s == 0.0 {
        true => (stamps.information(), stamps.mean_s),
        false => clock.prior(),
    };
    normal[(TIME, TIME)] = information;
    right[TIME] = information * offset_s;
    (normal, right)
}
