//! Formats of recordings, from outside.

mod autoferry;
mod containers;
mod recording;
mod replies;
