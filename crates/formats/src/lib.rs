//! Wire and file formats of sensors: bytes in, values out.
//!
//! A format here is a pure function of its input. It opens no file and no socket, reads no clock and starts no thread;
//! whoever has the bytes, from a network, a recording or a test, calls it. So the same code serves the live system, the
//! replay of a recording and a command-line decoder, and every byte offset in an error is an offset in what the caller
//! passed.
//!
//! - [`asterix`]: EUROCONTROL's binary format for surveillance data (radar, multilateration, ADS-B);
//! - [`reports`]: what their records mean to the pipeline: checked sensor tracks in the system frame;
//! - [`outgoing`]: the way back, tracks as data blocks for other systems;
//! - [`tracks_csv`]: sensor tracks and system tracks as rows of text.

#![forbid(unsafe_code)]

pub mod asterix;
pub mod outgoing;
pub mod reports;
pub mod tracks_csv;
