//! Values in memory that outlives its process, so that a kill costs one of them at most.
//!
//! A process that is killed leaves what it has stored. Its successor can go on from there if it can tell what is whole:
//! `image` has records for that, each in two copies with checksums. A [`Kept`] value is written into words and read
//! back, field by field ([`kept!`](crate::kept)). What is in the memory and when it is written is for others to say;
//! values that belong together and change together are a [`Picture`].
//!
//! Nothing here allocates, locks or calls the system while it writes.

#![forbid(unsafe_code)]

mod image;
mod picture;
#[cfg(feature = "states")]
mod states;
mod value;

pub use image::{Area, Found, HEAD, Memory, Refused, is_marked, mark, mixed};
pub use picture::Picture;
pub use value::{Get, Kept, Put};
