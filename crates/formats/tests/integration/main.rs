//! Formats of recordings, from outside.

mod ais;
mod ais_lines;
mod ais_written;
mod autoferry;
mod containers;
mod mode_s;
mod nmea;
mod normalised;
mod recording;
mod replies;
