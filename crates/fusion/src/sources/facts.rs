//! What fusion finds out about the sources while it works: plain data, from which the models learn.

use estimation::Gaussian;
use messages::{AXES, SensorTrack};

use crate::innovation::FilterInnovation;
use crate::measurement::{Correction, Measurement, gaussian_of};
use crate::tracker_gain::GainEvidence;

/// The latest report of a sensor track, as fusion uses it, with what was taken off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StatedState<'a> {
    /// The corrected report.
    pub(crate) report: &'a SensorTrack,
    pub(crate) correction: &'a Correction,
}

impl StatedState<'_> {
    /// The report's state as the source gave it.
    pub(crate) fn as_stated(&self) -> Gaussian {
        self.correction.undone(gaussian_of(self.report))
    }

    /// Position of the report as the source gave it, metres.
    pub(crate) fn stated_m(&self) -> [f64; AXES] {
        std::array::from_fn(|axis| self.report.position_m[axis] + self.correction.shift_m[axis])
    }
}

/// The report of a sensor track before another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EarlierReport<'a> {
    pub(crate) stated: StatedState<'a>,
    /// What the reports of the track showed of the gain of the source's tracker.
    pub(crate) evidence: &'a GainEvidence,
    /// Reports of the track so far.
    pub(crate) reports: u32,
}

/// What a measurement shows of its source, beside the prediction from all sources.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Innovation<'a> {
    pub(crate) source: u16,
    pub(crate) report: &'a SensorTrack,
    /// Place of its target in the table of system tracks.
    pub(crate) target: u32,
    pub(crate) innovation: &'a FilterInnovation,
    /// Normalised innovation squared in the plane, finite.
    pub(crate) nis: f64,
    /// The target's velocity, m/s, where the innovation shows how targets move.
    pub(crate) moves_mps: Option<[f64; AXES]>,
    /// The innovation about the mean of its sensor track's, metres; `None` while that is not known.
    pub(crate) about_mean_m: Option<[f64; 2]>,
    /// Whether it shows a change of the source's systematic errors.
    pub(crate) shows_errors: bool,
    /// Whether it shows how true the source's covariances are.
    pub(crate) shows_accuracy: bool,
    /// Probability that the target flies straight.
    pub(crate) steadiness: f64,
    /// The sensor track's mean beside those of others.
    pub(crate) apart: Option<MeanApart>,
}

/// How far the mean innovation of a sensor track lies from those of the others of its target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeanApart {
    /// East and north, metres.
    pub(crate) offset_m: [f64; 2],
    /// Variances per axis that noise explains, and of a measurement, m².
    pub(crate) noise_m2: f64,
    pub(crate) measured_m2: f64,
    /// Size of the target, metres.
    pub(crate) size_m: f64,
}

/// Reports of two sources on one target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ComparedStates<'a> {
    /// The newer report, and the measurement in it.
    pub(crate) own: StatedState<'a>,
    pub(crate) measurement: Option<&'a Measurement>,
    pub(crate) other: StatedState<'a>,
    /// Reports of the target so far, and its age, seconds.
    pub(crate) reports: u32,
    pub(crate) age_s: f64,
}

/// A target that is looked at for who follows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FollowedTarget {
    pub(crate) time_ns: i64,
    pub(crate) place_m: [f64; AXES],
    /// Probability that there is a target.
    pub(crate) existence: f64,
    /// Sources that follow it, and those of which it is known whether they do, as bits.
    pub(crate) follows: u64,
    pub(crate) asked: u64,
}
