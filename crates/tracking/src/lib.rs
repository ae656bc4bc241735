//! Tracks from detections: several interpretations are kept side by side until later scans decide (HT, SP).
//!
//! A sensor gives detections: some of targets, some of nothing, and none of them says of which. The obvious way gives
//! each detection to the nearest track. It fails where there is a choice, and it cannot be undone. This tracker keeps
//! the choices as *hypotheses*: each is a set of tracks without a common detection, which explains everything seen so
//! far, with a *reliability*, its probability. Each scan gives each hypothesis a child for every consistent
//! interpretation of the scan; later scans make the wrong ones unlikely. A track that remains in all that are left is
//! beyond doubt, and only then is it confirmed.
//!
//! # A scan's way (HT-1)
//!
//! 1. [`Tracker::scan`] finds the scan's place among the open ones (`tracker`): late ones are worked in as if they had
//!    come in time. `plot` takes over the usable detections; `measurement` knows what each kind says of a state.
//! 2. `scan_update` makes the tables after the scan of those before it. Every track is predicted and compared with the
//!    detections near it. Detections in several clusters' gates bring them together (`gating`, `joined`), and the
//!    product of their hypotheses is made (`parents`).
//! 3. `cluster_update`: each hypothesis poses an assignment problem (`interpretations`); the likeliest interpretations
//!    of all of them come out in order, and no more than can be kept (`ranked`). Their tracks are made in `branching`.
//!    The tests hold the definition instead: every interpretation there is.
//! 4. Children that are the same are merged, unreliable ones dropped, tracks confirmed (`hypothesis_store`), clusters
//!    separated (`separation`).
//!
//! Wide-area support is asked in one place, `wide_area::support`.
//!
//! A tracker goes on where another one was killed (`resumption`).
//!
//! What was considered and decided can be had as records ([`explanation`]).
//! Detections that come one by one are made into scans by [`cutting`], those of files by [`scans`]. The time of a turn
//! that is not configured is found by [`turn_time`].
//! [`settings`] says what can be chosen; the options for targets that part are in `splitting`.
//!
//! # Memory and time
//!
//! Everything is allocated in [`Tracker::new`], and nothing after. A population is four flat tables, and each scan
//! writes the next one (`population`); a track is a flat record that remembers its last scans (`track`). What has no
//! room is dropped and counted ([`TrackerCounts`]); every search has a named maximum: [`COMPARISONS_MAX`] detections
//! per track, of which [`PAIRS_MAX`] are considered, [`CLUSTER_TRACKS_MAX`] tracks and 64 detections per cluster,
//! [`HYPOTHESES_MAX`] hypotheses. What the maxima cut off is bounded and reported, too
//! ([`TrackerCounts::dropped_probability_max`], HT-11).
//!
//! Nothing here performs I/O or reads a clock; the same scans give the same bits. Clusters are worked off one after the
//! other.
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
pub mod cutting;
mod directions;
#[cfg(test)]
mod enumeration_tests;
pub mod explanation;
mod field_of_view;
mod gate;
mod gating;
mod hypothesis_store;
mod initiation;
mod interpretations;
mod joined;
mod life;
mod limits;
mod log_sum;
mod measurement;
mod motion;
mod parents;
mod plot;
mod population;
mod ranked;
mod resolution;
mod resumption;
mod scan_context;
mod scan_update;
pub mod scans;
pub mod selection;
mod sensor;
mod separation;
pub mod settings;
mod splitting;
#[cfg(test)]
mod testing;
mod track;
mod track_report;
mod tracker;
#[cfg(test)]
mod tracker_tests;
mod turn;
pub mod turn_time;
pub mod wide_area;
#[cfg(test)]
mod wide_area_identity_tests;
#[cfg(test)]
mod wide_area_tests;

pub use counts::TrackerCounts;
pub use field_of_view::FieldOfView;
pub use initiation::Initiation;
pub use limits::{CLUSTER_TRACKS_MAX, COMPARISONS_MAX, DETECTION_COUNTS, HISTORY_MAX, HYPOTHESES_MAX, PAIRS_MAX};
pub use resumption::{LeftTracks, TrackMemory};
pub use settings::Settings;
pub use track_report::TrackReport;
pub use tracker::{Rejection, Tracker};
