//! Knowledge of a smoother beside the measurements: motion of targets, and errors of the sources.

use messages::SensorTrack;
use source_models::{Correction, Motion};

use super::errors_over_time::ErrorsOverTime;
use crate::Engine;
use crate::update::filter_input::{Assumed, FilterInput};

/// Factors on the motion of targets assumed by the filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MotionFactors {
    /// On the noise of straight motion.
    pub(super) steady: f64,
    /// Factor on the mean time of straight flight.
    pub(super) straight: f64,
}

impl MotionFactors {
    /// The assumption of the filters.
    pub(super) const ONE: Self = Self {
        steady: 1.0,
        straight: 1.0,
    };
}

/// Knowledge of motion and of the sources' errors.
pub(super) trait Knowledge {
    /// Factors on this motion.
    fn factors(&self) -> MotionFactors {
        MotionFactors::ONE
    }

    /// How a target with this velocity moves, m/s.
    fn motion(&self, velocity_mps: [f64; 2]) -> &Motion;

    /// Errors of the source of an input.
    fn correction(&self, input: &FilterInput) -> Correction;
}

/// As all is known at the end of a recording.
#[derive(Clone, Copy, Debug)]
pub(super) struct Afterwards<'a> {
    pub(super) engine: &'a Engine,
    pub(super) errors: &'a ErrorsOverTime,
    pub(super) factors: MotionFactors,
}

impl Knowledge for Afterwards<'_> {
    fn factors(&self) -> MotionFactors {
        self.factors
    }

    fn motion(&self, [vx, vy]: [f64; 2]) -> &Motion {
        self.engine.tracks.sources.motion([vx, vy, 0.0])
    }

    fn correction(&self, input: &FilterInput) -> Correction {
        let report = SensorTrack {
            source: input.source,
            position_m: input.reported_m,
            velocity_mps: input.velocity_mps,
            ..SensorTrack::default()
        };
        let engine = self.engine;
        let mut correction = engine.tracks.sources.correction_of(&engine.settings.sources, &report);
        if let Some(shift_m) = self.errors.shift_m(engine, input) {
            correction.shift_m = shift_m;
        }
        correction
    }
}

/// The assumption of fusion at the time of each input.
#[derive(Clone, Copy, Debug)]
pub(super) struct AsAssumed(pub(super) Assumed);

impl Knowledge for AsAssumed {
    fn motion(&self, _: [f64; 2]) -> &Motion {
        &self.0.motion
    }

    fn correction(&self, input: &FilterInput) -> Correction {
        input.correction
    }
}
