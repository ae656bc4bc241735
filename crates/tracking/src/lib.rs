//! Tracks from detections: several interpretations are kept side by side until later scans decide (HT, SP).
//!
//! A sensor reports detections, some of targets and some false, without the origins. The obvious tracker gives each
//! detection to the nearest track, fails at ambiguous detections, and cannot undo a choice. This tracker keeps the
//! alternatives as *hypotheses*: each is a set of tracks without a common detection, which explains all detections so
//! far, with a *reliability*, the probability. Each scan gives each hypothesis a child for every consistent
//! interpretation of the scan; later scans make wrong interpretations unlikely. A track is confirmed only when all
//! remaining hypotheses contain it.
//!
//! # A scan's way (HT-1)
//!
//! 1. [`Tracker::scan`] finds the scan's place among the open scans (`tracker`): late scans are processed as if
//!    received in time. `plot` copies the usable detections; `measurement` models each kind of measurement.
//! 2. `scan_update` makes the tables after the scan from the tables before. Every track is predicted and compared with
//!    the detections nearby. Detections in the gates of several clusters join these clusters (`gating`, `joined`), and
//!    the product of the hypotheses is made (`parents`).
//! 3. `cluster_update`: each hypothesis poses an assignment problem (`interpretations`); the likeliest interpretations
//!    of all problems come out in order, and no more than can be kept (`ranked`). The tracks are made in `branching`.
//!    The tests hold the definition instead: every interpretation there is.
//! 4. Children that are the same are merged, unreliable ones dropped, tracks confirmed (`hypothesis_store`), clusters
//!    separated (`separation`).
//!
//! The update calls wide-area support through a single module, `wide_area::support`.
//!
//! Decisions are available as records ([`explanation`]). [`cutting`] makes scans of single detections, [`scans`]
//! makes scans of files. [`turn_time`] estimates the turn time if none is configured. [`settings`] lists the
//! options; the options for separating targets are in `splitting`.
//!
//! # Memory and time
//!
//! [`Tracker::new`] allocates all memory. A population is four flat tables, and each scan writes the next population
//! (`population`); a track is a flat record with the last scans (`track`). Items without room are dropped and counted
//! ([`TrackerCounts`]). Every search has a named maximum: [`COMPARISONS_MAX`] detections per track, of which
//! [`PAIRS_MAX`] are considered, [`CLUSTER_TRACKS_MAX`] tracks and 64 detections per cluster, [`HYPOTHESES_MAX`]
//! hypotheses. The loss by these maxima is bounded and reported ([`TrackerCounts::dropped_probability_max`], HT-11).
//!
//! Nothing here performs I/O or reads a clock; the same scans give the same bits. Clusters are processed one at a time.
//!
//! Sources: D. B. Reid, *An algorithm for tracking multiple targets*, IEEE Transactions on Automatic Control 24 (1979);
//! patent JP3886773B2 for clusters, matrices and splitting; S. S. Blackman, *Multiple hypothesis tracking for multiple
//! target tracking*, IEEE Aerospace and Electronic Systems Magazine 19 (2004).

#![forbid(unsafe_code)]

mod branching;
mod cluster_explanation;
mod cluster_update;
mod clutter;
#[cfg(test)]
mod correlation_tests;
mod counts;
mod coupling;
mod crossing;
mod crossing_memory;
#[cfg(test)]
mod crowd_tests;
pub mod cutting;
mod departure;
mod designation;
mod detection_rate;
mod directions;
#[cfg(test)]
mod enumeration_tests;
mod existence;
pub mod explanation;
mod field_of_view;
mod gate;
mod gating;
mod hypothesis_store;
mod identity;
mod initiation;
mod interpretations;
mod joined;
mod life;
mod limits;
mod log_sum;
mod measurement;
mod motion;
mod parents;
#[cfg(test)]
mod parting_tests;
mod plot;
mod population;
mod quiet;
mod ranked;
mod resolution;
mod resolution_cell;
mod resumption;
mod scan_clusters;
mod scan_context;
mod scan_update;
pub mod scans;
pub mod selection;
mod sensor;
mod separation;
pub mod settings;
mod splitting;
pub mod stated_scans;
#[cfg(test)]
mod testing;
mod track;
mod track_report;
mod tracker;
#[cfg(test)]
mod tracker_tests;
mod turn;
pub mod turn_time;
mod unresolved;
pub mod wide_area;
#[cfg(test)]
mod wide_area_identity_tests;
#[cfg(test)]
mod wide_area_tests;

pub use counts::TrackerCounts;
pub use field_of_view::FieldOfView;
pub use identity::{IdentitySettings, ReportedIdentity};
pub use initiation::Initiation;
pub use limits::{CLUSTER_TRACKS_MAX, COMPARISONS_MAX, DETECTION_COUNTS, HISTORY_MAX, HYPOTHESES_MAX, PAIRS_MAX};
pub use resolution_cell::ResolutionCell;
pub use resumption::{LeftTracks, TrackerMemory};
pub use settings::Settings;
pub use track_report::TrackReport;
pub use tracker::{ScanRejection, Tracker};
