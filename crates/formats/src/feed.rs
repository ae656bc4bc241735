//! Data of a receiver's feed in any format: pieces in, observations out.
//!
//! A feed is a stream of transmissions of targets that state their own positions. The formats differ in pieces (lines,
//! frames, documents), and each has a reader with its own rules; a feed hides which reader is at work, so that the live
//! adapter, the replay of a file and the check of a file take the same way. A reader combines the transmissions of a
//! target, so a feed has a state, and its pieces have an order.

use std::fmt;

use observations::{Observation, Statement};

use crate::ais::{AisOutput, AisReader, AisSettings};
use crate::cot_events::{CotReader, CotSettings};
use crate::mode_s::{FrameClock, ModeSOrigin, ModeSReader, ModeSRefusal, ModeSSettings, ModeSValue};
use crate::nmea::{RadarTargetReader, RadarTargetSettings};
use crate::readsb::{self, ReadsbReader, ReadsbSettings};
use crate::remote_id::{RemoteIdReader, RemoteIdSettings};
use crate::sbs::{AircraftMerger, SbsLine, SbsSettings, stamped_ns};
use crate::target_message::TargetMessage;

/// Number of the only connection of a feed.
const CONNECTION: u32 = 0;

/// How a feed is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FeedSettings {
    /// Lines of SBS-1; a piece is a line.
    Sbs(SbsSettings),
    /// Mode S frames; a piece is any part of the stream.
    ModeS(ModeSSettings),
    /// Lines of AIS; a piece is a line.
    Ais(AisSettings),
    /// Lines with targets of a radar; a piece is a line.
    RadarTargets(RadarTargetSettings),
    /// JSON of readsb; a piece is a document, or several.
    Readsb(ReadsbSettings),
    /// Lines of JSON with messages of Remote ID; a piece is a line.
    RemoteId(RemoteIdSettings),
    /// Events of Cursor on Target; a piece is any part of the stream.
    Cot(CotSettings),
}

/// Origin of a position in a feed: the errors of two origins have nothing in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedOrigin {
    /// The target states its own position, or the feed has no other origin.
    Own,
    /// A network of receivers has calculated the position from times of arrival.
    Multilateration,
    /// A ground station sends the position of a target that other sensors see (TIS-B).
    Traffic,
    /// A ground station repeats the position that the target states on another link (ADS-R).
    Repeated,
}

/// Transmission of a target in a feed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transmission {
    /// Origin of its positions.
    pub origin: FeedOrigin,
    /// Its time, UTC, nanoseconds since 1970: the time of receipt where the data have none.
    pub utc_ns: i64,
}

/// What a piece of a feed has brought.
pub enum Fed<'a> {
    /// Report of a target.
    Target(Transmission, &'a Observation),
    /// Statement of a target beside its motion, or of a station that is no target.
    Statement(Transmission, &'a Statement),
    /// Refused data: the reason, and the refusal in words.
    Refused(&'static str, &'a dyn fmt::Display),
}

/// Counts of a feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeedCounts {
    /// Transmissions of targets that were read.
    pub records: u64,
    /// Transmissions with a time of their own; the others have the time of receipt.
    pub timed: u64,
    /// Refused transmissions.
    pub refused: u64,
    /// Octets of these.
    pub refused_octets: u64,
    /// Transmissions that announce a position and hold none.
    pub without_position: u64,
    /// Transmissions of targets for which the table had no room.
    pub without_room: u64,
    /// Positions that another transmission has brought already.
    pub repeated: u64,
}

/// Reader of a feed.
#[derive(Debug)]
pub struct FeedReader {
    reader: Reader,
    /// Octets of refused pieces.
    refused_octets: u64,
    /// First time with a date in the data, UTC, nanoseconds.
    first_utc_ns: Option<i64>,
}

#[derive(Debug)]
enum Reader {
    Sbs(AircraftMerger),
    ModeS(Box<ModeSReader>),
    Ais(Box<AisReader>),
    RadarTargets(Box<RadarTargetReader>),
    Readsb(Box<ReadsbReader>),
    RemoteId(Box<RemoteIdReader>),
    Cot(Box<CotReader>),
}

impl FeedReader {
    /// Creates the reader of a feed that begins.
    pub fn new(settings: FeedSettings) -> Self {
        Self {
            reader: match settings {
                FeedSettings::Sbs(settings) => Reader::Sbs(AircraftMerger::new(settings)),
                FeedSettings::ModeS(settings) => Reader::ModeS(Box::new(ModeSReader::new(settings))),
                FeedSettings::Ais(settings) => Reader::Ais(Box::new(AisReader::new(settings))),
                FeedSettings::RadarTargets(settings) => {
                    Reader::RadarTargets(Box::new(RadarTargetReader::new(settings)))
                }
                FeedSettings::Readsb(settings) => Reader::Readsb(Box::new(ReadsbReader::new(settings))),
                FeedSettings::RemoteId(settings) => Reader::RemoteId(Box::new(RemoteIdReader::new(settings))),
                FeedSettings::Cot(settings) => Reader::Cot(Box::new(CotReader::new(settings))),
            },
            refused_octets: 0,
            first_utc_ns: None,
        }
    }

    /// Takes a piece that was received at `received_utc_ns` (UTC, nanoseconds); `None` in a file without times of
    /// receipt, where the times of the data alone count.
    pub fn take(&mut self, piece: &[u8], received_utc_ns: Option<i64>, out: &mut dyn FnMut(Fed<'_>)) {
        let received_ns = received_utc_ns.unwrap_or(0);
        let first = &mut self.first_utc_ns;
        match &mut self.reader {
            Reader::Sbs(merger) => match merger.take(piece, received_ns) {
                Ok(Some(observed)) => {
                    *first = first.or_else(|| dated(piece));
                    out(Fed::Target(own(received_ns), &observed));
                }
                Ok(None) => {}
                Err(error) => {
                    self.refused_octets += piece.len() as u64;
                    out(Fed::Refused(error.rejection.sentence(), &error));
                }
            },
            Reader::ModeS(reader) => {
                let before = reader.counters().refused;
                reader.take(piece, received_utc_ns, &mut |output| {
                    let origin = match output.origin {
                        ModeSOrigin::Own => FeedOrigin::Own,
                        ModeSOrigin::TisB => FeedOrigin::Traffic,
                        ModeSOrigin::Rebroadcast => FeedOrigin::Repeated,
                    };
                    if output.clock == FrameClock::Line {
                        first.get_or_insert(output.utc_ns);
                    }
                    let utc_ns = output.utc_ns;
                    let transmission = Transmission { origin, utc_ns };
                    match &output.value {
                        ModeSValue::Observation(observed) => out(Fed::Target(transmission, observed)),
                        ModeSValue::Statement(statement) => out(Fed::Statement(transmission, statement)),
                    }
                });
                for (reason, count) in reader.counters().refusals() {
                    let new = count - before[reason as usize];
                    if new > 0 && reason != ModeSRefusal::Repeated {
                        let words = format!("{new} times, a frame {}", reason.sentence());
                        out(Fed::Refused(reason.sentence(), &words));
                    }
                }
            }
            Reader::Ais(reader) => {
                let taken = reader.take(CONNECTION, piece, received_ns, |utc_ns, output| match output {
                    AisOutput::Target(observed) => out(Fed::Target(own(utc_ns), &observed)),
                    AisOutput::Statement(statement) => out(Fed::Statement(own(utc_ns), &statement)),
                    // Own ship is no target.
                    AisOutput::OwnShip(_) => {}
                });
                *first = first.or(reader.counters().first_stated_ns);
                if let Err(error) = taken {
                    self.refused_octets += piece.len() as u64;
                    out(Fed::Refused(error.rejection.sentence(), &error));
                }
            }
            Reader::RadarTargets(reader) => {
                let taken = reader.take(piece, received_utc_ns);
                *first = first.or(reader.counters().first_stated_ns);
                match taken {
                    Ok(Some(observed)) => out(Fed::Target(own(received_ns), &observed)),
                    Ok(None) => {}
                    Err(error) => {
                        self.refused_octets += piece.len() as u64;
                        out(Fed::Refused(error.rejection.sentence(), &error));
                    }
                }
            }
            Reader::Readsb(reader) => {
                for document in readsb::documents(piece) {
                    let before = *reader.counters();
                    reader.take(document, |origin, message| {
                        let origin = match origin {
                            readsb::Origin::Multilateration => FeedOrigin::Multilateration,
                            readsb::Origin::Traffic => FeedOrigin::Traffic,
                            readsb::Origin::Repeated => FeedOrigin::Repeated,
                            readsb::Origin::Own | readsb::Origin::Contract | readsb::Origin::Other => FeedOrigin::Own,
                        };
                        first.get_or_insert(message.time_ns);
                        give(origin, &message, out);
                    });
                    let now = reader.counters();
                    if now.refused_documents > before.refused_documents {
                        self.refused_octets += document.len() as u64;
                    }
                    if now.refused != before.refused
                        && let Some(refusal) = reader.refused()
                    {
                        out(Fed::Refused(refusal.reason.word(), refusal));
                    }
                }
            }
            Reader::RemoteId(reader) => {
                let before = reader.counters().refused;
                reader.take(piece, |message| {
                    first.get_or_insert(message.time_ns);
                    give(FeedOrigin::Own, &message, out);
                });
                if reader.counters().refused != before
                    && let Some(refusal) = reader.refused()
                {
                    self.refused_octets += piece.len() as u64;
                    out(Fed::Refused(refusal.reason.word(), refusal));
                }
            }
            Reader::Cot(reader) => {
                let before = reader.counters().refused;
                reader.take(piece, |message| {
                    first.get_or_insert(message.time_ns);
                    give(FeedOrigin::Own, &message, out);
                });
                if reader.counters().refused != before
                    && let Some(refusal) = reader.refused()
                {
                    out(Fed::Refused(refusal.reason.word(), refusal));
                }
            }
        }
    }

    /// The feed has ended, or its connection: what has begun was cut, and is counted as refused.
    pub fn end(&mut self) {
        match &mut self.reader {
            Reader::ModeS(reader) => reader.end(None, &mut |_| {}),
            Reader::Cot(reader) => reader.end(),
            Reader::Ais(reader) => reader.end(),
            Reader::Sbs(_) | Reader::RadarTargets(_) | Reader::Readsb(_) | Reader::RemoteId(_) => {}
        }
    }

    /// Returns the first time with a date in the data, UTC, nanoseconds since 1970; `None` if the data have dates only
    /// by their receipt.
    pub fn first_utc_ns(&self) -> Option<i64> {
        self.first_utc_ns
    }

    /// Returns the counts so far.
    pub fn counts(&self) -> FeedCounts {
        let counts = match &self.reader {
            Reader::Sbs(merger) => {
                let counted = merger.counters();
                FeedCounts {
                    records: counted.messages,
                    timed: counted.timed,
                    refused: counted.rejected.iter().sum(),
                    without_position: counted.without_position,
                    without_room: counted.refused_aircraft,
                    ..FeedCounts::default()
                }
            }
            Reader::ModeS(reader) => {
                let counted = reader.counters();
                FeedCounts {
                    records: counted.accepted,
                    timed: counted.timed,
                    refused: counted.refused_sum() - counted.refused(ModeSRefusal::Repeated),
                    repeated: counted.refused(ModeSRefusal::Repeated),
                    refused_octets: counted.damaged_octets,
                    without_position: counted.unpaired,
                    ..FeedCounts::default()
                }
            }
            Reader::Ais(reader) => {
                let counted = reader.counters();
                FeedCounts {
                    records: counted.messages,
                    timed: counted.timed,
                    refused: counted.rejected.iter().sum::<u64>() + counted.unfinished,
                    without_position: counted.without_position,
                    without_room: counted.refused_stations,
                    repeated: counted.repeats,
                    ..FeedCounts::default()
                }
            }
            Reader::RadarTargets(reader) => {
                let counted = reader.counters();
                FeedCounts {
                    records: counted.targets + counted.ended,
                    timed: counted.timed,
                    refused: counted.rejected.iter().sum(),
                    without_position: counted.without_position,
                    repeated: counted.repeats,
                    ..FeedCounts::default()
                }
            }
            Reader::Readsb(reader) => {
                let counted = reader.counters();
                FeedCounts {
                    records: counted.states,
                    timed: counted.states,
                    refused: counted.refused.iter().sum(),
                    without_position: counted.without_position,
                    repeated: counted.repetitions,
                    ..FeedCounts::default()
                }
            }
            Reader::RemoteId(reader) => {
                let counted = reader.counters();
                FeedCounts {
                    records: counted.messages,
                    timed: counted.messages,
                    refused: counted.refused.iter().sum(),
                    without_position: counted.without_position,
                    repeated: counted.repetitions,
                    ..FeedCounts::default()
                }
            }
            Reader::Cot(reader) => {
                let counted = reader.counters();
                let refused = counted.refused.iter().sum();
                FeedCounts {
                    records: counted.events - refused,
                    timed: counted.events - refused,
                    refused,
                    without_position: counted.without_position,
                    repeated: counted.repetitions,
                    ..FeedCounts::default()
                }
            }
        };
        FeedCounts {
            refused_octets: counts.refused_octets + self.refused_octets,
            ..counts
        }
    }
}

/// Returns the time of a line of SBS-1, UTC, nanoseconds since 1970, if it has a date.
fn dated(line: &[u8]) -> Option<i64> {
    match SbsLine::parse(line) {
        Ok(SbsLine::Message(message)) => stamped_ns(message.received),
        _ => None,
    }
}

/// A target's own transmission at `utc_ns` (nanoseconds).
fn own(utc_ns: i64) -> Transmission {
    let origin = FeedOrigin::Own;
    Transmission { origin, utc_ns }
}

/// Passes the news of a target on: position and statement.
fn give(origin: FeedOrigin, message: &TargetMessage, out: &mut dyn FnMut(Fed<'_>)) {
    let utc_ns = message.time_ns;
    let transmission = Transmission { origin, utc_ns };
    if let Some(observed) = &message.observation {
        out(Fed::Target(transmission, observed));
    }
    if let Some(statement) = &message.statement {
        out(Fed::Statement(transmission, statement));
    }
}
