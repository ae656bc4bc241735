//! Wire and file formats of sensors: bytes in, values out.
//!
//! A format here is a pure function of its input. It opens no file and no socket, reads no clock and starts no thread;
//! whoever has the bytes, from a network, a recording or a test, calls it. So the same code serves the live system, the
//! replay of a recording and a command-line decoder, and every byte offset in an error is an offset in what the caller
//! passed.
//!
//! - [`containers`]: what recordings of [`asterix`] come packed in: captures of networks, recorders' frames;
//! - [`recording`]: a recording as a whole: which of its records can be believed, and statistics of them;
//! - [`sbs`]: lines of transponder receivers (SBS-1, BaseStation);
//! - [`reports`]: what such records and lines mean to the pipeline: checked sensor tracks in the system frame;
//! - [`detection`]: single measurements, for sensors whose tracks are made here; [`autoferry`] reads a public data set
//!   of them; [`wide_area`]: how many targets a remote sensor has seen;
//! - [`bearing`]: directions of emitters, for sensors that measure nothing else;
//! - [`sensor_tracks_csv`], [`detections_csv`], [`bearings_csv`]: these inputs as rows of text, by the rules of
//!   [`csv_table`];
//! - [`tracks_csv`]: sensor tracks and system tracks as output.

#![forbid(unsafe_code)]

pub mod autoferry;
pub mod bearing;
pub mod bearings_csv;
pub mod containers;
pub mod csv_table;
pub mod detection;
pub mod detections_csv;
pub mod recording;
pub mod reports;
pub mod sbs;
pub mod sensor_tracks_csv;
pub mod tracks_csv;
pub mod wide_area;
