//! Facts about the sources: plain data from fusion, from which the models learn.

use estimation::Gaussian;
use messages::{AXES, SensorTrack};

use crate::credibility::Judgement;
use crate::height_errors::HeightApart;
use crate::innovation::FilterInnovation;
use crate::measurement::{Correction, Measurement, gaussian_of};
use crate::settings::SourceSet;
use crate::tracker_gain::GainEvidence;

/// The latest report of a sensor track, corrected as fusion uses the report.
#[derive(Clone, Copy, Debug)]
pub struct StatedState<'a> {
    /// The corrected report.
    pub report: &'a SensorTrack,
    /// The correction.
    pub correction: &'a Correction,
}

impl StatedState<'_> {
    /// The report's state as the source gave it.
    #[inline]
    pub fn as_stated(&self) -> Gaussian {
        self.correction.undone(gaussian_of(self.report))
    }

    /// Position of the report as the source gave it, metres.
    #[inline]
    pub fn stated_m(&self) -> [f64; AXES] {
        std::array::from_fn(|axis| self.report.position_m[axis] + self.correction.shift_m[axis])
    }
}

/// The report of a sensor track before another one.
#[derive(Clone, Copy, Debug)]
pub struct EarlierReport<'a> {
    /// The report.
    pub stated: StatedState<'a>,
    /// Evidence of the track's reports on the gain of the source's tracker.
    pub evidence: &'a GainEvidence,
    /// Reports of the track so far.
    pub reports: u32,
}

/// A measurement beside the prediction from all sources.
#[derive(Clone, Copy, Debug)]
pub struct Innovation<'a> {
    /// Number of the source.
    pub source: u16,
    /// The corrected report.
    pub report: &'a SensorTrack,
    /// Place of the target in the table of system tracks.
    pub target: u32,
    /// The innovation, of the measured point.
    pub innovation: &'a FilterInnovation,
    /// Normalised innovation squared in the plane, finite.
    pub nis: f64,
    /// Velocity of the target, m/s, if the innovation bears on the motion of targets.
    pub moves_mps: Option<[f64; AXES]>,
    /// The innovation about the mean innovation of the sensor track, metres; `None` before a mean is known.
    pub about_mean_m: Option<[f64; 2]>,
    /// Whether the innovation bears on the source's systematic errors.
    pub shows_errors: bool,
    /// Whether the innovation bears on the source's covariances.
    pub shows_accuracy: bool,
    /// Probability that the target flies straight.
    pub steadiness: f64,
    /// The mean innovation of the sensor track beside the means of others.
    pub apart: Option<MeanApart>,
    /// The same for the heights.
    pub height: Option<HeightApart>,
}

/// Distance of the mean innovation of a sensor track from the means of the other tracks of the target.
#[derive(Clone, Copy, Debug)]
pub struct MeanApart {
    /// East and north, metres.
    pub offset_m: [f64; 2],
    /// Variance per axis that noise explains, m².
    pub noise_m2: f64,
    /// Variance per axis of a measurement, m².
    pub measured_m2: f64,
    /// Size of the target, metres.
    pub size_m: f64,
}

/// Reports of two sources on one target.
#[derive(Clone, Copy, Debug)]
pub struct ComparedStates<'a> {
    /// The newer report.
    pub own: StatedState<'a>,
    /// The measurement in it.
    pub measurement: Option<&'a Measurement>,
    /// The latest report of the other source.
    pub other: StatedState<'a>,
    /// Reports of the target so far.
    pub reports: u32,
    /// Age of the target, seconds.
    pub age_s: f64,
}

/// A target, and the sources that follow the target.
#[derive(Clone, Copy, Debug)]
pub struct FollowedTarget {
    /// Time of the look, nanoseconds.
    pub time_ns: i64,
    /// Place of the target, metres.
    pub place_m: [f64; AXES],
    /// Probability that there is a target.
    pub existence: f64,
    /// Sources that follow the target.
    pub follows: SourceSet,
    /// Sources that can be expected to follow the target, or do.
    pub asked: SourceSet,
}

/// A fact about the sources.
#[derive(Clone, Copy, Debug)]
pub enum Fact<'a> {
    /// A report by itself, or beside the report before.
    Report(ReportFact<'a>),
    /// A measurement beside the prediction from all sources.
    Innovation(InnovationFact<'a>),
    /// Reports of several sources on a target, beside each other.
    Pair(PairFact<'a>),
    /// A scan of the source has detected a tracked target, or missed the target.
    Scan {
        /// Number of the source.
        source: u16,
        /// Whether the scan detected the target.
        is_detected: bool,
    },
    /// The followers of a target, or the truth of a new track.
    Target(TargetFact),
    /// An order to forget all knowledge of a source.
    Order {
        /// Number of the source.
        source: u16,
    },
}

/// A fact from a report.
#[derive(Clone, Copy, Debug)]
pub enum ReportFact<'a> {
    /// A valid report has come at `now_ns`: evidence on the place of a moving source, and on gross errors.
    Came {
        /// The report, free of known gross errors.
        report: &'a SensorTrack,
        /// The engine's time, nanoseconds.
        now_ns: i64,
    },
    /// The time stamp of a valid report, as the source gave it.
    Stamped {
        /// Number of the source.
        source: u16,
        /// The stamp, nanoseconds.
        time_ns: i64,
    },
    /// A report of the source has come late by `late_ns`.
    Late {
        /// Number of the source.
        source: u16,
        /// Delay, nanoseconds.
        late_ns: i64,
    },
    /// A report in the form of the source, which is a sensor: possibly a copy of another source's report.
    Original(&'a SensorTrack),
    /// The time of a report, which may be the first of a sensor track.
    Timed {
        /// Number of the source, and its period, nanoseconds.
        source: (u16, i64),
        /// Time of measurement, nanoseconds.
        time_ns: i64,
        /// Whether the sensor track is new.
        is_first: bool,
    },
    /// A report follows the report before of its sensor track, or begins a sensor track.
    Follows {
        /// Number of the source.
        source: u16,
        /// Time of measurement, nanoseconds.
        time_ns: i64,
        /// Time since the report before, nanoseconds.
        since_ns: Option<i64>,
    },
    /// The source was silent about a target for `gap_ns`, and reported the target again.
    Gap {
        /// Number of the source.
        source: u16,
        /// Time between two reports, nanoseconds.
        gap_ns: i64,
    },
    /// A report states height and pressure altitude.
    Pressure(&'a SensorTrack),
}

/// A fact from a measurement beside the prediction.
#[derive(Clone, Copy, Debug)]
pub enum InnovationFact<'a> {
    /// The measurement was used.
    Used(Innovation<'a>),
    /// The measurement was not used, since other sources contradict the measurement.
    Contradicted {
        /// Number of the source.
        source: u16,
        /// Place of the target in the table of system tracks.
        target: u32,
        /// Place of the target, east and north, metres.
        place_m: [f64; 2],
        /// Velocity in the report, m/s.
        velocity_mps: [f64; AXES],
        /// Distance of the measurement from `place_m`, metres, and the covariance (xx, xy, yy) of the distance, m².
        residual: ([f64; 2], [f64; 3]),
    },
    /// The detection point of a target of the source has leapt.
    Leapt {
        /// Number of the source.
        source: u16,
        /// Time of measurement, nanoseconds.
        time_ns: i64,
        /// Number of targets of the source.
        targets: usize,
    },
}

/// A fact from reports on a target beside each other.
#[derive(Clone, Copy, Debug)]
pub enum PairFact<'a> {
    /// The states of two sources: systematic errors.
    States(ComparedStates<'a>),
    /// The latest reports of two sources: common errors.
    Reports(&'a SensorTrack, &'a SensorTrack),
    /// A report was near enough to the others' estimate to need no comparison.
    Near {
        /// Number of the source.
        source: u16,
    },
    /// A report was judged by the others of its target.
    Judged(&'a Judgement),
    /// A position from the target itself was compared with positions from sensors.
    Verified {
        /// Number of the source.
        source: u16,
        /// Whether the sensors contradict the position.
        is_contradicted: bool,
    },
}

/// A fact about a target.
#[derive(Clone, Copy, Debug)]
pub enum TargetFact {
    /// The sources that follow the target.
    Followed(FollowedTarget),
    /// A new track of the source turned out to be a target, or false.
    Proved {
        /// Number of the source.
        source: u16,
        /// Whether there was a target.
        is_target: bool,
    },
}
