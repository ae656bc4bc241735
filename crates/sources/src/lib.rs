//! Processing of a source: from observations to published samples (PL-3).
//!
//! Data come from a socket, a connection or a file, live or replayed; this crate processes all data alike. A
//! [`Pipeline`] takes the observations of a source. Tracks of a sensor are checked and passed on. For other sensors the
//! tracks are made here: from detections by a tracker ([`DetectionTracker`]), from bearings by a locator
//! ([`BearingLocator`]), and bearings from snapshots of an antenna array ([`SnapshotIntake`]). The output consists of
//! [`Samples`], in the order of publication.
//!
//! [`ScanTracker`] contains all steps around a tracker: the times of pictures, the input of counts and emissions, and
//! the cues of sensors. `koseki track` uses this type too, so a live source and its recorded detections give the same
//! tracks.
//!
//! [`carrying`] turns detections of sensors on a moving platform into detections in the system frame; [`joining`] joins
//! the detections of several sensors into a single order of scans; [`silence`] states the time of a sensor that sends
//! nothing.
//!
//! This crate performs no I/O and reads no clock. The output depends on the data and the order of the data, never on
//! the time of reading.

#![forbid(unsafe_code)]

mod bearing_locator;
pub mod carrying;
mod detection_tracker;
pub mod joining;
mod last_kept;
mod pipeline;
mod plot_relay;
mod readings;
mod reorder;
mod samples;
mod scan_tracker;
pub mod silence;
mod snapshot_intake;

pub use bearing_locator::{BearingLocator, FinderSettings};
pub use detection_tracker::{DetectionTracker, PlatformAxes, TrackerSettings};
pub use pipeline::{Pipeline, Processing};
pub use readings::{PlatformReading, Readings, SourceReading};
pub use reorder::Reorder;
pub use samples::Samples;
pub use scan_tracker::{Outputs, ScanTracker, SensorScan, TrackSink};
pub use snapshot_intake::{ArrayMeasurement, SnapshotIntake};
