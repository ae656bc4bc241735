//! Frames of aircraft transponders as radio receivers pass them on (Mode S, ADS-B on 1090 MHz).
//!
//! A program that reads a receiver's decoded lines ([`crate::sbs`]) gets positions without accuracy, and whatever
//! errors that program makes. The frames themselves have the accuracy that each aircraft states, the kind of its
//! sender, and a checksum that shows damage. [`ModeSReader`] reads a stream of them:
//!
//! 1. [`FrameReader`] finds the frames in the octets, and their time stamps;
//! 2. [`FrameClock`] is what dates a frame: its own line, its receipt, or the receiver's ticks;
//! 3. [`ModeSMessage`] has the values of a single frame;
//! 4. [`CprPosition`] becomes a latitude and longitude with a second frame or an earlier position, after checks of
//!    range and speed;
//! 5. every position becomes an [`Observation`](observations::Observation) with the aircraft's recent values, every
//!    change of category, emergency or selected altitude a [`Statement`](observations::Statement).
//!
//! Used are the formats 0, 4, 5, 11, 16, 17, 18, 20 and 21. Frames of ground stations about an aircraft (TIS-B, ADS-R)
//! and frames with an address that is not the aircraft's own are marked in [`ModeSOutput`]: a caller keeps them apart
//! as sources. Not used are the registers in replies, coarse TIS-B, and replies of Modes A and C. Each frame is counted
//! once in [`ModeSCounters`]; a wrong checksum refuses a frame, and no bit is repaired.
//!
//! Sources: ICAO Annex 10 volume IV; ICAO Doc 9871; RTCA DO-260, DO-260A, DO-260B.

mod aircraft;
mod altitude;
mod clock;
mod counters;
mod cpr;
mod frame;
mod framing;
mod message;
mod position;
mod reader;
mod refusal;

pub use clock::FrameClock;
pub use counters::ModeSCounters;
pub use cpr::CprPosition;
pub use frame::ModeSFrame;
pub use framing::{FrameReader, FrameStamp, Framed, LINE_OCTETS_MAX};
pub use message::{ModeSMessage, ModeSOrigin};
pub use position::ReceiverRange;
pub use reader::{ModeSOutput, ModeSReader, ModeSSettings, ModeSValue};
pub use refusal::ModeSRefusal;
