//! A source's life: what is observed becomes the samples that it publishes (PL-3).
//!
//! Data come from a socket, a connection or a file, live or replayed; what becomes of them is the same for all and
//! happens here. A [`Pipeline`] takes one source's observations. A sensor that delivers tracks has them checked and
//! passed on. One that delivers less has its tracks made: of detections by a tracker ([`DetectionTracker`]), of
//! bearings by a locator ([`BearingLocator`]). What comes out are [`Samples`], in the order in which they are to be
//! published.
//!
//! Everything round a tracker, when pictures are shown, when counts and emissions are given to it, when sensors are
//! cued, is in [`ScanTracker`], which `koseki track` drives too: so a live source and its recorded detections give the
//! same tracks.
//!
//! Nothing here performs I/O or reads a clock. What comes out depends on what was read and in which order, never on
//! when.

#![forbid(unsafe_code)]

mod bearing_locator;
mod detection_tracker;
mod last_kept;
mod pipeline;
mod samples;
mod scan_tracker;

pub use bearing_locator::BearingLocator;
pub use detection_tracker::{DetectionTracker, TrackerSettings};
pub use pipeline::{Pipeline, Processing};
pub use samples::Samples;
pub use scan_tracker::{Outputs, Scan, ScanTracker, TrackSink};
