//! Models of fusion's sources and of the motion of targets, learned while fusion works.
//!
//! The models contain no table of tracks. Fusion's core passes each finding as a [`Fact`], which is plain data: a
//! report, an innovation, a pair of reports, a scan, a target, an order. Work beyond a fact, such as the registration
//! of systematic errors, is done in parts at ticks. [`Sources`] gives the knowledge by the number of the source.
//!
//! | model | file |
//! |---|---|
//! | systematic errors of a source: registration, steps, drifts | `registration` |
//! | gross errors that keep tracks apart | `alignment` |
//! | truth of covariances, spread of detection points, detection | `source_model` |
//! | shape of errors across and along the line of sight | `error_shape` |
//! | gain and noise of a source's tracker | `tracker_gain`, `corrections` |
//! | the measurement behind a report | `content`, `measurement` |
//! | sources that have errors in common | `dependence` |
//! | sources that others contradict | `credibility` |
//! | points of targets that sources see | `points` |
//! | where a source follows targets, from a place that may move | `detection_map`, `moving_sources` |
//! | how many new tracks of a source are targets | `purity` |
//! | periods, gaps, restarts, lateness: how long reports and tracks live | `lifetimes`, `gaps`, `restarts`, `rhythm` |
//! | how targets turn and climb | `manoeuvres`, `motion` |
//! | height and pressure altitude | `pressure` |
//! | time stamps that are multiples of a coarse step | `stamps` |
//!
//! A late report teaches nothing: the estimate for a comparison has moved on. Evidence of a single target stays with
//! the sensor track, in the core; the conclusion about the source is a fact.
//!
//! Architecture invariants: no clock, no file, no thread; no table of tracks; after construction nothing is allocated;
//! the same facts in the same order lead to the same knowledge, bit for bit.

#![forbid(unsafe_code)]

mod alignment;
mod body_frame;
mod content;
mod corrections;
mod credibility;
mod dependence;
mod detection_map;
mod error_shape;
mod facts;
mod gaps;
mod height_errors;
mod innovation;
mod kept_sources;
mod knowledge;
mod learned;
mod learning;
mod lifetimes;
mod manoeuvres;
mod mean_innovation;
mod measurement;
mod median;
mod motion;
mod moving_sources;
mod points;
mod pressure;
mod principal;
mod purity;
pub mod registration;
mod restarts;
mod rhythm;
mod sampling;
mod seeker;
mod source_model;
mod sources;
mod stamps;
mod step_memory;
#[cfg(test)]
mod testing;
mod tracker_gain;

pub(crate) use fusion_rules::gross;
pub(crate) use fusion_settings as settings;

pub use body_frame::{from_body, to_body};
pub use credibility::{AGREES, CONTRADICTS, Judgement, apart, distance_from};
pub use detection_map::DetectionProbability;
pub use error_shape::Stretch;
pub use facts::*;
pub use height_errors::HeightApart;
pub use innovation::{FilterInnovation, Fit, Manoeuvre};
pub use kept_sources::{KeptClass, KeptPair, KeptSource};
pub use knowledge::Nearness;
pub use learned::Learned;
pub use mean_innovation::{MeanInnovation, odd_one};
pub use measurement::*;
pub use motion::{LEVELS, MANOEUVRE_S, Motion};
pub use points::{DetectionPoint, Points, Referred};
pub use purity::LASTING_REPORTS;
pub use restarts::SILENT;
pub use rhythm::Rhythm;
pub use source_model::{MEAN_GAIN, MEAN_VARIANCE};
pub use sources::{Sources, place_of};
pub use stamps::Stamps;
pub use tracker_gain::GainEvidence;

/// Returns the key of a call sign; 0 of an empty call sign.
pub fn callsign_key(callsign: &str) -> u64 {
    let mut bytes = [0; size_of::<u64>()];
    for (byte, character) in bytes.iter_mut().zip(callsign.trim().bytes()) {
        *byte = character;
    }
    u64::from_be_bytes(bytes)
}

/// Time between two ticks, nanoseconds.
pub const TICK_NS: i64 = 1_000_000_000;
