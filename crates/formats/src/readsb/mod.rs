//! JSON of transponder receivers: readsb, dump1090 and tar1090.
//!
//! These programs publish the latest values of each aircraft, instead of each transmission as
//! [`sbs`](crate::sbs) has it. The source of all meanings is `README-json.md` of readsb
//! (<https://github.com/wiedehopf/readsb>). Three kinds of document are read:
//!
//! | document | keys |
//! | --- | --- |
//! | list of aircraft (`aircraft.json`, and the network interfaces of aggregators) | `now`, `aircraft` or `ac` |
//! | state of an aircraft, with its own time (a line of history) | `now`, `hex`, … |
//! | trace of an aircraft (`trace_full_*.json`, unpacked) | `icao`, `timestamp`, `trace` |
//!
//! [`documents`] divides a file of one or more documents. [`ReadsbReader`] reads a document, and gives a
//! [`TargetMessage`](crate::target_message::TargetMessage) for each state with news, beside its [`Origin`]: receivers
//! mix positions that aircraft state themselves with results of multilateration and of ground stations, whose errors
//! have nothing in common. A caller may make each origin a source of its own.
//!
//! # Time
//!
//! A position is as old as `seen_pos` states, in most programs to a tenth of a second. The same position within
//! [`REPETITION_NS`] is therefore a repetition. Speed, altitude and vertical rate have no time of their own. Such a
//! value may be as late as the last message of the aircraft (`seen`); with a position that is older by more than
//! [`MOTION_AHEAD_MAX_NS`], none of them is used. Identity and statements change seldom, and are always used.
//!
//! # Errors of position
//!
//! `nac_p` is the category of the estimated position uncertainty: the radius of 95 % of the errors. `nic`, `rc` and
//! `sil` describe bounds that an error exceeds seldom (10⁻³ to 10⁻⁷ an hour), so no error follows from them. Without
//! `nac_p`, the accuracy is the configured one, and unknown if `nic` or `sil` is 0. The step of coordinates in
//! squitters (5 m) is added. The categories are the transponder's own, and are not used for positions of
//! multilateration.
//!
//! # Limits
//!
//! - Missing values are unknown. A value outside the range of its key refuses the state, with the key and the value;
//!   keys that are not used are not checked.
//! - `nav_altitude_mcp` is an altitude by the altimeter setting of the crew, given on as if by the standard one: below
//!   the transition altitude, both differ by 8 m per hectopascal.
//! - Traces have on the ground a heading in the place of the track; then the velocity is unknown. Details of a row
//!   (identity, accuracy) serve for the following rows up to [`DETAIL_AGE_MAX_S`].
//! - A document of more than [`DOCUMENT_OCTETS_MAX`] is refused; texts are unpacked by the caller.

mod aircraft;
mod origin;
mod reader;
mod reason;
mod trace;

pub use origin::Origin;
pub use reader::{
    Documents, MOTION_AHEAD_MAX_NS, REPETITION_NS, ReadsbCounters, ReadsbReader, ReadsbSettings, SILENCE_MAX_NS,
    documents,
};
pub use reason::ReadsbReason;
pub use trace::DETAIL_AGE_MAX_S;

/// Longest document that is read, octets: a list of 20,000 aircraft.
pub const DOCUMENT_OCTETS_MAX: usize = 16 << 20;

#[cfg(test)]
mod any_json;
#[cfg(test)]
mod tests;
