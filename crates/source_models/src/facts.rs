//! What fusion finds out about the sources while it works: plain data, from which the models learn.

use estimation::Gaussian;
use messages::{AXES, SensorTrack};

use crate::credibility::Judgement;
use crate::innovation::FilterInnovation;
use crate::measurement::{Correction, Measurement, gaussian_of};
use crate::tracker_gain::GainEvidence;

/// The latest report of a sensor track, as fusion uses it, with what was taken off.
#[derive(Clone, Copy, Debug)]
pub struct StatedState<'a> {
    /// The corrected report.
    pub report: &'a SensorTrack,
    /// What was taken off.
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
    /// What the reports of the track showed of the gain of the source's tracker.
    pub evidence: &'a GainEvidence,
    /// Reports of the track so far.
    pub reports: u32,
}

/// What a measurement shows of its source, beside the prediction from all sources.
#[derive(Clone, Copy, Debug)]
pub struct Innovation<'a> {
    /// Number of the source.
    pub source: u16,
    /// The corrected report.
    pub report: &'a SensorTrack,
    /// Place of its target in the table of system tracks.
    pub target: u32,
    /// The innovation, of the measured point.
    pub innovation: &'a FilterInnovation,
    /// Normalised innovation squared in the plane, finite.
    pub nis: f64,
    /// The target's velocity, m/s, where the innovation shows how targets move.
    pub moves_mps: Option<[f64; AXES]>,
    /// The innovation about the mean of its sensor track's, metres; `None` while that is not known.
    pub about_mean_m: Option<[f64; 2]>,
    /// Whether it shows a change of the source's systematic errors.
    pub shows_errors: bool,
    /// Whether it shows how true the source's covariances are.
    pub shows_accuracy: bool,
    /// Probability that the target flies straight.
    pub steadiness: f64,
    /// The sensor track's mean beside those of others.
    pub apart: Option<MeanApart>,
}

/// How far the mean innovation of a sensor track lies from those of the others of its target.
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

/// A target that is looked at for who follows it.
#[derive(Clone, Copy, Debug)]
pub struct FollowedTarget {
    /// Time of the look, nanoseconds.
    pub time_ns: i64,
    /// Place of the target, metres.
    pub place_m: [f64; AXES],
    /// Probability that there is a target.
    pub existence: f64,
    /// Sources that follow it, as bits.
    pub follows: u64,
    /// Sources of which it is known whether they follow it, as bits.
    pub asked: u64,
}

/// What fusion finds out about the sources.
#[derive(Clone, Copy, Debug)]
pub enum Fact<'a> {
    /// A report shows something by itself, or beside the one before.
    Report(ReportFact<'a>),
    /// A measurement shows something beside the prediction from all sources.
    Innovation(InnovationFact<'a>),
    /// Reports of several sources on one target show something beside each other.
    Pair(PairFact<'a>),
    /// A scan of the source has detected a target that the source tracks, or not.
    Scan {
        /// Number of the source.
        source: u16,
        /// Whether it detected the target.
        is_detected: bool,
    },
    /// A target shows who follows it, or a new track what it was.
    Target(TargetFact),
    /// An operator orders that a source begin anew.
    Order {
        /// Number of the source.
        source: u16,
    },
}

/// What a report shows.
#[derive(Clone, Copy, Debug)]
pub enum ReportFact<'a> {
    /// A valid report has come at `now_ns`: where its source stands, and whether it has a gross error.
    Came {
        /// The report, free of a gross error that is known.
        report: &'a SensorTrack,
        /// The engine's time, nanoseconds.
        now_ns: i64,
    },
    /// So late, nanoseconds, a report of the source has come.
    Late {
        /// Number of the source.
        source: u16,
        /// Delay, nanoseconds.
        late_ns: i64,
    },
    /// A report, in its source's form, is one of a sensor: it may be a copy of another source's.
    Original(&'a SensorTrack),
    /// A report of a source with this period has this time; it may be the first of its sensor track.
    Timed {
        /// Number of the source, and its period, nanoseconds.
        source: (u16, i64),
        /// Time of measurement, nanoseconds.
        time_ns: i64,
        /// Whether its sensor track is new.
        is_first: bool,
    },
    /// A report follows another one of its sensor track after so long, or begins a sensor track.
    Follows {
        /// Number of the source.
        source: u16,
        /// Time of measurement, nanoseconds.
        time_ns: i64,
        /// Time since the report before, nanoseconds.
        since_ns: Option<i64>,
    },
    /// The source was silent for so long about a target that goes on.
    Gap {
        /// Number of the source.
        source: u16,
        /// Time between two reports, nanoseconds.
        gap_ns: i64,
    },
    /// A report states height and pressure altitude.
    Pressure(&'a SensorTrack),
}

/// What a measurement shows beside the prediction.
#[derive(Clone, Copy, Debug)]
pub enum InnovationFact<'a> {
    /// It was used.
    Used(Innovation<'a>),
    /// It was not used, since others contradict it.
    Contradicted {
        /// Number of the source.
        source: u16,
        /// Place of its target in the table of system tracks.
        target: u32,
        /// Where the target is, east and north, metres.
        place_m: [f64; 2],
        /// Velocity in the report, m/s.
        velocity_mps: [f64; AXES],
        /// Distance of the measurement from there, metres, and its covariance (xx, xy, yy), m².
        residual: ([f64; 2], [f64; 3]),
    },
    /// The detection point of one of the source's targets has leapt.
    Leapt {
        /// Number of the source.
        source: u16,
        /// Time of measurement, nanoseconds.
        time_ns: i64,
        /// Targets that the source follows.
        targets: usize,
    },
}

/// What reports on one target show beside each other.
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
    /// A position that a target reported was compared with those that sensors measured.
    Verified {
        /// Number of the source.
        source: u16,
        /// Whether they contradict it.
        is_contradicted: bool,
    },
}

/// What a target shows.
#[derive(Clone, Copy, Debug)]
pub enum TargetFact {
    /// Which sources follow it.
    Followed(FollowedTarget),
    /// A new track of the source turned out to be a target, or false.
    Proved {
        /// Number of the source.
        source: u16,
        /// Whether there was a target.
        is_target: bool,
    },
}
