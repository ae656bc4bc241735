//! Changes of the systematic errors of a source: the start of a new estimate, and the time after it.
//!
//! A step shows in the innovations (module `steps`), in the differences of states (module `recent`), or in
//! contradictions with other sources beyond the limits of the filters. The estimate of the changed source is dropped.
//! The states of the tracker lag behind the step for some scans. Meanwhile the measurements of the source are compared
//! with the states of others, the states of the source are compared with nothing, and innovations of misled filters
//! teach nothing.

use messages::AXES;

use crate::registration::displacement::Displacement;
use crate::registration::errors::{SAMPLES_MIN, SourceErrors};
use crate::registration::recent::{Recent, SOLUTIONS_MIN, step_limit};
use crate::registration::rows::{AZIMUTH, Errors, RANGE};
use crate::registration::steps::{FormerErrors, MISLED_TICKS, Seed, Step, YOUNG_TICKS};
use crate::registration::{EMPTY, Registration, TARGETS_MIN};
use crate::settings::SourceSet;

/// Number of samples as which the innovations of a detected step count.
const SEEDED_SAMPLES: f64 = 1.2 * SAMPLES_MIN;
/// Least size of a small step, metres, and in standard deviations of detection points. A smaller mean may come from a
/// few dominant targets, such as parked aircraft.
const CARRIED_MIN_M: f64 = 12.0;
const POINTS_SIGMAS: f64 = 2.0;
/// Chi-square with two degrees of freedom up to which an offset may be 0.
const EXPLAINED_2: f64 = 9.2;

impl Registration {
    /// Drops the estimate of a source and all sums behind it.
    pub(crate) fn forget(&mut self, own: usize) {
        let count = self.sources.len();
        for other in self.partners_of(own) {
            self.pairs[own * count + other] = EMPTY;
            self.pairs[other * count + own] = EMPTY;
            self.partners[other].remove(own as u16);
        }
        self.partners[own] = SourceSet::EMPTY;
        self.contradicted[own] = 0.0;
        self.fits[own] = 1.0;
        self.recents[own] = Recent::default();
        self.ticks[own] = 0;
        self.solutions[own] = 0;
        self.sources[own] = SourceErrors {
            stamps: self.sources[own].stamps,
            ..SourceErrors::unknown()
        };
        self.seeds[own] = Seed::NONE;
        self.displacements[own] = Displacement::UNKNOWN;
        self.formers[own] = None;
        self.young[own] = 0;
        self.steps.clear();
    }

    /// Drops the estimates of sources after a step of the errors, and passes these sources to `restarted`.
    pub(super) fn forget_after_step(&mut self, mut restarted: impl FnMut(u16)) {
        let is_sought = |own: usize| self.reference != Some(own as u16) && self.sources[own].samples >= SAMPLES_MIN;
        let sought = (0..self.sources.len()).filter(|own| is_sought(*own));
        let limit = step_limit(sought.map(|own| &self.recents[own]));
        if limit == f64::INFINITY || self.targets < TARGETS_MIN as f64 {
            return;
        }
        for own in 0..self.sources.len() {
            if self.reference != Some(own as u16) && self.recents[own].is_step(limit) {
                self.begin_anew(own);
                restarted(own as u16);
            }
        }
        // The latest differences of all sources contain the step.
        self.recents.fill(Recent::default());
    }

    /// Adds an innovation of a source's report: residual and its covariance, of a target with this number, position
    /// (east, north) and velocity.
    #[inline]
    pub(crate) fn add_innovation(
        &mut self,
        source: usize,
        (mut residual_m, covariance_m2): ([f64; 2], [f64; 3]),
        (target, position_m, velocity_mps): (u32, [f64; 2], [f64; AXES]),
    ) {
        // A known error, even if not removed, is no change.
        let suspected_m = self.suspected_shift(source as u16, velocity_mps);
        for (residual, suspected) in residual_m.iter_mut().zip(suspected_m) {
            *residual -= suspected;
        }
        self.steps
            .add(source, (residual_m, covariance_m2), (target, position_m));
    }

    /// Returns whether the tracker states of a source lag behind a recent change of the errors.
    #[inline]
    pub(crate) fn is_young(&self, source: u16) -> bool {
        self.young[usize::from(source)] > 0
    }

    /// Returns the sources with a recent, estimated step. The states of the trackers lag behind the step and
    /// contradict the other sources without need.
    pub(crate) fn with_known_steps(&self) -> SourceSet {
        let is_known =
            |own: usize| self.young[own] > 0 && self.seeds[own].normal[(2, 2)] > 0.0 && self.is_corrected(own);
        let known = (0..self.sources.len()).filter(|own| is_known(*own));
        known.map(|own| own as u16).collect()
    }

    /// Returns whether a step was found at this tick or the previous tick.
    pub(crate) fn takes_step(&self) -> bool {
        self.young.iter().any(|young| *young + 1 >= YOUNG_TICKS)
    }

    /// Discards the innovations, because innovations contain the detection points of the targets.
    pub(crate) fn pass_over_innovations(&mut self) {
        self.steps.clear();
    }

    /// Returns whether filters may still be misled by a step.
    #[inline]
    pub(crate) fn has_misled_filters(&self) -> bool {
        self.young.iter().any(|young| *young > YOUNG_TICKS - MISLED_TICKS)
    }

    /// Processes a step in the innovations of a source. A step of at least half a large target (`largest_m` metres)
    /// restarts the estimate; a smaller step is added to the estimate. The detection points of a target have a variance
    /// of up to `points_m2` per axis.
    pub(super) fn look_for_step(&mut self, (largest_m, points_m2): (f64, f64), restarted: &mut impl FnMut(u16)) {
        let is_sought = |own: usize| {
            self.reference != Some(own as u16)
                && self.sources[own].samples >= SAMPLES_MIN
                && self.solutions[own] >= SOLUTIONS_MIN
                && self.young[own] <= YOUNG_TICKS - MISLED_TICKS
        };
        if self.misled_ticks > 0 {
            self.misled_ticks -= 1;
            self.steps.clear();
            return;
        }
        let Some(step) = self.steps.look(points_m2, is_sought) else {
            return;
        };
        if step.targets < TARGETS_MIN as u32 {
            return;
        }
        let own = step.source;
        if step.effect_m < 0.5 * largest_m {
            let least_m = CARRIED_MIN_M.max(POINTS_SIGMAS * points_m2.sqrt());
            if !step.turns && (step.is_further || step.effect_m >= least_m) {
                self.carry(&step);
            }
            return;
        }
        if step.is_beyond {
            self.begin_anew(own);
            restarted(own as u16);
            return;
        }
        let old = self.sources[own];
        let (seed, model) = Seed::of(&step, &old, self.formers[own].as_ref(), self.places_m[own]);
        self.begin_anew(own);
        self.seeds[own] = seed;
        self.sources[own].model = model;
        self.sources[own].samples = SEEDED_SAMPLES;
        restarted(own as u16);
    }

    /// Adds a change of the offset to the estimate of a source and to the underlying differences. The weight of the
    /// differences is reduced: the variance of the change adds to the variance of the estimate.
    fn carry(&mut self, step: &Step) {
        let (own, count) = (step.source, self.sources.len());
        let known_m2 = self.displacements[own].variance_m2();
        let keep = known_m2 / (known_m2 + step.variance_m2());
        let mut by = Errors::zeros();
        (by[0], by[1]) = (step.by.x, step.by.y);
        for other in self.partners_of(own) {
            let pair = &mut self.pairs[own * count + other];
            pair.right += pair.own * by;
            pair.fade(keep);
            let pair = &mut self.pairs[other * count + own];
            pair.right -= pair.cross * by;
            pair.fade(keep);
        }
        let seed = &mut self.seeds[own];
        seed.right += seed.normal * by;
        self.sources[own].errors += by;
        self.steps.carry(step);
        self.recents.fill(Recent::default());
    }

    /// Returns the sources with a removed horizontal error.
    pub(crate) fn removing(&self) -> SourceSet {
        let is_removed = |known: &SourceErrors| [0, RANGE, AZIMUTH].into_iter().any(|row| known.removed[row]);
        let removed = (0..).zip(&self.sources).filter(|(_, known)| is_removed(known));
        removed.map(|(own, _)| own).collect()
    }

    /// Returns whether the present estimate of a changed source has just been solved for the first time, and corrects
    /// the reports.
    pub(crate) fn is_first_solution(&self, source: u16) -> bool {
        let own = usize::from(source);
        self.is_young(source) && self.solutions[own] == 1 && self.is_corrected(own)
    }

    /// Returns whether the horizontal errors of a source are removed, or insignificant.
    fn is_corrected(&self, own: usize) -> bool {
        let known = &self.sources[own];
        let squared = |row: usize| known.errors[row] * known.errors[row] / known.variances[row];
        self.solutions[own] > 0 && (known.removed[0] || known.removed[AZIMUTH] || squared(0) + squared(1) < EXPLAINED_2)
    }

    /// Restarts the estimate of a settled source; returns whether a restart took place.
    pub(crate) fn begin_anew_if_settled(&mut self, source: u16) -> bool {
        let own = usize::from(source);
        let is_settled = self.reference != Some(source)
            && self.solutions[own] >= SOLUTIONS_MIN
            && self.young[own] == 0
            && self.targets >= TARGETS_MIN as f64;
        if is_settled {
            self.begin_anew(own);
        }
        is_settled
    }

    /// Drops the estimate of a source with changed errors; the dropped estimate is a rival of the next estimate.
    pub(crate) fn begin_anew(&mut self, own: usize) {
        let former = FormerErrors::of(&self.sources[own]);
        self.forget(own);
        self.formers[own] = Some(former);
        self.young[own] = YOUNG_TICKS;
        // The latest differences of all sources contain the step.
        self.recents.fill(Recent::default());
    }
}
