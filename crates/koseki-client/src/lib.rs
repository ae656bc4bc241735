//! Readers and feeders of a Koseki deployment, for programs that are no part of it (PL-2, PL-11).
//!
//! A [`Subscription`] gives access to the samples published by the deployment's processes, without copying. A
//! [`Publisher`] is the opposite direction: tracks of a source, detections of a tracker's sensor, counts of a
//! wide-area sensor and positions of a platform that the configuration calls `external`. [`Orders`] gives orders to
//! fusion. All may move between threads.
//!
//! Feeding needs no frame and no bit: a [`Detection`] or a [`TrackReport`] has degrees and standard deviations.
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
//! ```no_run
//! use koseki_client::{Detection, Publisher};
//!
//! # fn main() -> Result<(), koseki_client::Error> {
//! let mut source = Publisher::open("feed", "own")?;
//! source.send(&[Detection::at(41.40, 2.10).sigma_m(20.0)])?;
//! # Ok(())
//! # }
//! ```
//!
//! - A reader blocks no other process. A slow reader loses its oldest slices, and receives the number of lost
//!   samples.
//! - After a restart of fusion, its slices have a higher *epoch*: see [`Slice::starts_epoch`]. Live, tracks continue
//!   under their numbers, or are reported as terminated; with recorded inputs, numbers restart. Later slices of an
//!   older epoch are dropped, and counted.
//! - When the deployment ends, or is replaced by another of the same name, that is an error ([`ErrorKind::Ended`]):
//!   drop the subscription and open it again. Its memory can only be cleared when all have left it.
//! - A source has one publisher. A second one is refused ([`ErrorKind::Fed`]); the successor of a killed one is
//!   accepted at once. Samples with a fault, such as a time in seconds, are refused before they are published.
//! - A publisher built from another version of the samples is an error, too ([`ErrorKind::Schema`]).
//!
//! Programs that choose topics at run time use [`by_name`], which is also the basis for other languages.

#![forbid(unsafe_code)]

pub mod by_name;
mod claim;
mod clock;
mod connection;
mod directory;
mod error;
mod frame;
pub mod observation;
mod orders;
mod publisher;
pub mod refusals;
mod subscription;

pub use frames::{Geodetic, SystemFrame};
pub use messages;

pub use bus::{BORROWED_MAX, Payload, Root};
pub use directory::{instances, sources, topics};
pub use error::{Error, ErrorKind};
pub use frame::frame;
pub use observation::{Detection, TrackReport};
pub use orders::Orders;
pub use publisher::Publisher;
pub use subscription::{Counts, Slice, Subscription};
