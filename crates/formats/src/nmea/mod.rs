//! NMEA 0183: navigation receivers, compasses and inertial sensors on ships.
//!
//! Read are position (GGA, RMC), velocity (RMC, VTG), heading (HDT, THS) and attitude (PASHR), and apart from these the
//! targets of a radar (TTM, TLL: [`RadarTarget`]). The crate `nmea` would read four of these, but depends on `chrono`,
//! which `deny.toml` excludes; `nmea0183` gives reasons as texts, so wrong checksums and cut sentences could not be
//! counted apart. The sentences are short; the framing below is what matters.
//!
//! # Time
//!
//! GGA and PASHR state a time of day, RMC a date as well. The day is the one that brings the time nearest to the time
//! of receipt, or without one, nearest to the latest stated time; without either, a date must come first. Thus
//! midnight is passed in either order of sentences. A leap second is the first moment of the next day.
//!
//! HDT and THS state no time: the time of receipt serves, or without one, the latest stated time. The heading has
//! meanwhile changed by an unknown part of a turn, so its standard deviation grows by the rate of turn times the
//! deviation of the receipt ([`NmeaSettings::receipt_sigma_s`]). VTG belongs to the latest fix.
//!
//! # Faults
//!
//! A sentence without its checksum is refused, not only a wrong one: a cut sentence is otherwise a shorter number.
//! Every refusal is counted by reason ([`NmeaCounts`]), and the latest is named ([`NmeaRefusal`]).

mod fields;
mod radar_targets;
mod reader;
mod refusal;
mod sentence;
mod writer;

pub use radar_targets::{RadarPlace, RadarTarget, Reference, Referred};
pub use reader::{NmeaReader, NmeaSettings};
pub use refusal::NmeaRefusal;
pub(crate) use sentence::summed;
pub use sentence::{NmeaCounts, NmeaFault};
pub use writer::write_sentences;
