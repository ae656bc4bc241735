//! Formats of recordings, from outside.

mod autoferry;
mod containers;
mod nmea;
mod recording;
mod replies;
