//! Values in memory that outlives its process: a kill costs at most one value.
//!
//! A killed process leaves its stores in memory. A successor can resume if whole values can be distinguished from
//! torn values: each record is stored in two copies with checksums. A [`Kept`] value is written to words
//! and read back field by field ([`kept!`](crate::kept)). Contents and times of writing are up to the users of this
//! crate. Values that change together form a [`Picture`].
//!
//! Writing neither allocates nor locks nor calls the system.

#![forbid(unsafe_code)]

mod atomic;
mod image;
mod picture;
mod record;
#[cfg(feature = "states")]
mod states;
mod value;

pub use image::{HEAD, Memory, MemoryRefusal, is_marked, mark};
pub use picture::Picture;
pub use record::{RecordArea, RecordState, mixed};
pub use value::{Get, Kept, Put};
