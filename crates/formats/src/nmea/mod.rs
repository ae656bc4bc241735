//! NMEA 0183: navigation receivers, compasses and inertial sensors on ships.
//!
//! Read are position (GGA, RMC, GLL), velocity (RMC, VTG), heading (HDT, THS, HDG) and attitude (PASHR), and apart
//! from these the targets of a radar (TTM, TLL: [`RadarTarget`], [`RadarTargetReader`]). The crate `nmea` would read
//! four of these, but depends on `chrono`, which `deny.toml` excludes; `nmea0183` gives reasons as texts, so wrong
//! checksums and cut sentences could not be counted apart. The sentences are short; the framing below is what matters.
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
//! HDG states a magnetic heading. It is read where it states the variation, too, and for as long as no instrument that
//! finds true north by itself is among the sentences.
//!
//! # Faults
//!
//! A sentence without its checksum is refused, not only a wrong one: a cut sentence is otherwise a shorter number.
//! Every refusal is counted by reason ([`NmeaCounts`]), and the latest is named ([`NmeaRefusal`]).

mod envelope;
mod fields;
mod own_ship;
mod radar_targets;
mod reader;
mod refusal;
mod sentence;
mod target_counters;
mod target_numbers;
mod target_reader;
#[cfg(test)]
mod target_reader_tests;
mod writer;

pub(crate) use envelope::{Envelope, LINE_OCTETS_MAX};
pub use radar_targets::{RadarPlace, RadarTarget, Reference, Referred};
pub use reader::{NmeaReader, NmeaSettings};
pub use refusal::NmeaRefusal;
pub use sentence::{NmeaCounts, NmeaFault};
pub use target_counters::{RadarTargetCounters, RadarTargetError, RadarTargetRejection};
pub use target_reader::{RadarTargetReader, RadarTargetSettings};
pub use writer::write_sentences;
