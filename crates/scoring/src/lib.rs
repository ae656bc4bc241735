//! Quality of tracks and fixes against a known truth.
//!
//! A change of a rule, a gate or a noise setting must be judged by its effect on the picture. The eye does not
//! notice a few metres, a lost track in a thousand or an exchanged number. With a known truth, from a simulation or
//! from better instruments, figures show the difference.
//!
//! - [`score_picture`]: the picture of a fused or a single tracker, second by second: GOSPA and OSPA ([`gospa`]),
//!   errors, identity switches, breaks, completeness, spurious tracks;
//! - [`score_card`]: errors by phase of movement, and lines of published standards with their limits;
//! - [`ResolutionScore`]: the resolution of targets that fly close to each other, and its delay;
//! - [`AccuracySums`]: running figures of a picture, available at any time;
//! - [`NumberTally`]: the stability of track numbers through failures;
//! - [`score_alerts`]: alerts on targets, judged by what the truth does afterwards;
//! - [`FixRuns`]: the fixes of a bearings-only locator, compared with the best possible.
//!
//! Everything is a pure function of the given rows: no file, no clock. [`csv_table`] reads the rows, so columns are
//! found by name and errors state line, column, value and remedy.

#![forbid(unsafe_code)]

mod accuracy;
mod alerts;
pub mod assignment;
mod basis;
mod bound;
mod continuity;
mod fixes;
pub mod gospa;
mod near;
mod normalised;
mod numbers;
mod picture;
mod reference;
mod resolution;
mod row_columns;
mod scorecard;
mod states;
mod statistics;
mod words;

pub use accuracy::{AccuracyReport, AccuracySums, PictureTarget, PictureTrack};
pub use alerts::{
    ALERT_KINDS, AlertFigures, AlertScore, AlertScoreSettings, AlertTable, KindReliability, KindScore, Minima,
    MissedEvent, ReliabilityBin, score_alerts,
};
pub use basis::FileBasis;
pub use fixes::{
    BroadsideFigures, CaseSettings, CourseFigures, FIX_WORDS, FixCase, FixError, FixFigures, FixInputError, FixRuns,
    FixScore,
};
pub use near::PointPair;
pub use numbers::NumberTally;
pub use picture::{
    Compared, PICTURE_WORDS, PictureError, PictureScore, PictureSettings, ShownState, Timeline, score_picture,
};
pub use resolution::{
    ConfirmedTracks, NoTruthSince, PooledResolutionScore, RESOLUTION_WORDS, ResolutionScore, ResolutionSettings,
    TargetsByTime,
};
pub use scorecard::{
    AddressCheck, AreaCard, AreaKind, CardReference, CardSettings, ErrorSample, ErrorSpread, GroupConsistency,
    LineLimit, LineMeasure, LineResult, LineVerdict, MOVEMENT_PHASES, MeasuredFigure, MovementPhase, PhaseFigures,
    PhaseLimits, PhaseSet, PhaseTable, SURVEILLANCE_STANDARDS, Scorecard, ScoredArea, SpreadConsistency, StandardCard,
    StandardLine, SurveillanceStandard, score_card, surveillance_standard,
};
pub use words::Word;
