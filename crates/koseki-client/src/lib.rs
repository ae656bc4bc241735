//! Readers and feeders of a Koseki deployment, for programs that are no part of it (PL-2, PL-11).
//!
//! A [`Subscription`] hands out what the deployment's processes publish, where they wrote it; a [`Publisher`] is the
//! other way: tracks of a source, counts of a wide-area sensor and places of a platform that the configuration calls
//! `external`. Both may move between threads.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! # fn main() -> Result<(), koseki_client::Error> {
//! let mut tracks = koseki_client::Subscription::open("demo")?;
//! loop {
//!     let Some(slice) = tracks.next(Duration::from_secs(1))? else { continue };
//!     for track in &slice {
//!         println!("{} at {:?} m, {} lost before", track.track_number, track.position_m, slice.lost());
//!     }
//! }
//! # }
//! ```
//!
//! - A reader holds up nobody. One that is too slow loses its oldest slices, and is told how many samples.
//! - When fusion is started anew, its slices have a higher *epoch*: see [`Slice::starts_epoch`]. Live, tracks go on
//!   under their numbers, or are told ended; with recorded inputs, numbers begin again. What still comes from an older
//!   one is dropped, and counted.
//! - When the deployment ends, or is replaced by another of the same name, that is an error ([`ErrorKind::Ended`]):
//!   drop the subscription and open it again. Its memory can only be cleared when all have left it.
//! - A publisher built from another version of the samples is an error, too ([`ErrorKind::Schema`]).
//!
//! Programs that are told the name of a topic only when they run use [`by_name`]; that is what other languages stand
//! on.

#![forbid(unsafe_code)]

pub mod by_name;
mod clock;
mod connection;
mod error;
mod publisher;
mod subscription;

pub use messages;

pub use bus::{BORROWED_MAX, Root};
pub use error::{Error, ErrorKind};
pub use publisher::Publisher;
pub use subscription::{Counts, Slice, Subscription};
