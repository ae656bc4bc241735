//! Remote ID: messages that unmanned aircraft broadcast about themselves.
//!
//! ASTM F3411 and ASD-STAN EN 4709-002 define the same messages of 25 octets, sent over Bluetooth and Wi-Fi, single or
//! in packs of up to nine. Receivers have no common form for them, so each line here is a JSON object:
//!
//! ```json
//! {"time": 1717664319.1, "receiver": "rx1", "mac": "60:60:1F:12:34:56", "payload": "1020…"}
//! ```
//!
//! | key | value |
//! | --- | --- |
//! | `time` | time of receipt, seconds since 1970 (UTC) |
//! | `payload` | a message or a pack from the octet of type and version on, in hexadecimal digits or base64 |
//! | `mac` | address of the transmitter, any text; may be missing with packs that hold a Basic ID |
//!
//! Other keys, such as `receiver`, are not used: a message received twice is a repetition. The number of characters
//! distinguishes hexadecimal digits from base64.
//!
//! # Messages
//!
//! | message | used |
//! | --- | --- |
//! | Basic ID | serial number, else registration: name and number of the track; type: category |
//! | Location | position, both altitudes, velocity, status, accuracies, time |
//! | System | place of the operator |
//! | Operator ID, Self-ID, authentication | counted |
//!
//! The number of the track is a hash of the identity; until a Basic ID has come (every 3 s at least), that of the
//! transmitter. A drone may therefore begin with a short track of another number. Session identities change with each
//! flight: they number a track, and give no name. Accuracies are upper bounds of the 95 % error, one category from the
//! next; the bound is taken. Values that the standard declares unknown are unknown here.
//!
//! # Time
//!
//! A Location states tenths of a second since the full hour; the hour is the one that brings the time nearest to that
//! of receipt. The standard allows a second of delay. A time more than [`DELAY_MAX_NS`] from receipt is of a clock
//! that is wrong. Each drone has its own clock, so no estimate of the source's clock corrects the time: the time of
//! receipt is used, and counted.
//!
//! # Sources
//!
//! Layouts and unknown values follow the reference implementation
//! (<https://github.com/opendroneid/opendroneid-core-c>), which compares no versions either: later versions have added
//! values in reserved places only. The crate `opendroneid` 0.1 wraps this library, and does not serve here: a build
//! needs a C compiler and libclang, `UasData::decode` hands the library a pointer to octets without their number, so
//! that a short pack is read beyond its end, and the library accepts places beyond the poles. Three fixed layouts are
//! less than the checks around them would be.

mod line;
mod message;
mod reader;
mod reason;

pub use line::LINE_OCTETS_MAX;
pub use reader::{DELAY_MAX_NS, RemoteIdCounters, RemoteIdReader, RemoteIdSettings, SILENCE_MAX_NS};
pub use reason::RemoteIdReason;

#[cfg(test)]
mod tests;
