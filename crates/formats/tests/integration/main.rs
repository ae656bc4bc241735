//! Formats of recordings, from outside.

mod ais;
mod ais_lines;
mod autoferry;
mod containers;
mod mode_s;
mod nmea;
mod recording;
mod replies;
