//! How good tracks and fixes are, against a known truth.
//!
//! Somebody who changes a rule, a gate or a noise setting wants to know whether the picture became better. Looking at
//! it does not tell: a few metres, a lost track in a thousand or a swapped number are below what an eye notices. Where
//! the truth is known, from a simulation or from better instruments, the difference can be put into figures.
//!
//! - [`score_picture`]: the picture of a fused or a single tracker, second by second: GOSPA and OSPA ([`gospa`]),
//!   errors, identity switches, breaks, completeness, spurious tracks;
//! - [`ResolutionScore`]: whether a tracker tells targets apart that fly close to each other, and how soon;
//! - [`Accuracy`]: the picture as it goes on, in a few figures that can be had at any time;
//! - [`NumberTally`]: whether targets keep their numbers, and numbers their targets, whatever dies;
//! - [`FixRuns`]: the fixes of a bearings-only locator, beside the best that is possible.
//!
//! Everything is a pure function of rows that somebody else has opened: no file, no clock. Rows are read through
//! [`csv_table`], so columns are found by name and errors say line, column, value and remedy.

#![forbid(unsafe_code)]

mod accuracy;
pub mod assignment;
mod bound;
mod continuity;
mod fixes;
pub mod gospa;
mod near;
mod normalised;
mod numbers;
mod picture;
mod resolution;
mod states;
mod statistics;
mod words;

pub use accuracy::{Accuracy, AccuracyReport, PictureTarget, PictureTrack};
pub use fixes::{
    BroadsideFigures, CaseSettings, CourseFigures, FIX_WORDS, FixCase, FixError, FixFigures, FixInputError, FixRuns,
    FixScore,
};
pub use near::Pair;
pub use numbers::NumberTally;
pub use picture::{PICTURE_WORDS, PictureError, PictureScore, PictureSettings, ShownState, Timeline, score_picture};
pub use resolution::{
    ConfirmedTracks, NoTruthSince, PooledResolutionScore, RESOLUTION_WORDS, ResolutionScore, ResolutionSettings,
    TargetsByTime,
};
pub use words::Word;
