//! Documents to messages.

use frames::time::NS_PER_S;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;

use super::DOCUMENT_OCTETS_MAX;
use super::aircraft::{AircraftState, within};
use super::origin::Origin;
use super::reason::{Read, ReadsbReason};
use super::trace::Trace;
use crate::target_message::{self, KnownTarget, Memory, Refusal, TargetMessage, utc_ns};

/// Longest time by which altitude and velocity may be ahead of a used position, nanoseconds: in this time an aircraft
/// in a standard turn changes its heading by 15°.
pub const MOTION_AHEAD_MAX_NS: i64 = 5 * NS_PER_S;
/// Time within which the same position is a repetition, nanoseconds: programs round ages to a tenth of a second, and
/// aircraft send two positions a second.
pub const REPETITION_NS: i64 = NS_PER_S / 4;
/// After this silence an aircraft may be forgotten, nanoseconds.
pub const SILENCE_MAX_NS: i64 = 600 * NS_PER_S;

/// A later time is in milliseconds: some aggregators write `now` so.
const SECONDS_MAX: f64 = 1e11;
/// Greatest age of a position, seconds.
const AGE_MAX_S: f64 = 86_400.0;

/// Settings of a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadsbSettings {
    /// Most aircraft that are remembered.
    pub aircraft_max: usize,
}

impl Default for ReadsbSettings {
    /// More aircraft than are in the air at once.
    fn default() -> Self {
        Self { aircraft_max: 1 << 14 }
    }
}

/// Counts. A document is in exactly one of `documents` and `refused_documents`; a state of a used document is in
/// exactly one of `observations`, `repetitions`, `without_position` and `refused_states`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadsbCounters {
    /// Documents that were used.
    pub documents: u64,
    /// Documents that were refused.
    pub refused_documents: u64,
    /// States of aircraft in documents that were used.
    pub states: u64,
    /// States with a new position.
    pub observations: u64,
    /// States whose position was given before.
    pub repetitions: u64,
    /// States without a position.
    pub without_position: u64,
    /// States that were refused.
    pub refused_states: u64,
    /// Statements given.
    pub statements: u64,
    /// Documents and states that were refused, by [`ReadsbReason`].
    pub refused: [u64; ReadsbReason::ALL.len()],
}

/// Reader of documents.
#[derive(Debug)]
pub struct ReadsbReader {
    aircraft: Memory<KnownTarget>,
    counters: ReadsbCounters,
    refusal: Option<Refusal<ReadsbReason>>,
}

/// Keys by which documents differ.
#[derive(Deserialize)]
struct Document<'a> {
    now: Option<f64>,
    #[serde(borrow, alias = "ac")]
    aircraft: Option<Vec<&'a RawValue>>,
    hex: Option<IgnoredAny>,
    icao: Option<String>,
    timestamp: Option<f64>,
    #[serde(borrow)]
    trace: Option<Vec<&'a RawValue>>,
}

impl ReadsbReader {
    /// Returns a reader with an allocated table.
    pub fn new(settings: ReadsbSettings) -> Self {
        Self {
            aircraft: Memory::new(settings.aircraft_max, SILENCE_MAX_NS),
            counters: ReadsbCounters::default(),
            refusal: None,
        }
    }

    /// Takes a document; calls `each` for each state with news.
    pub fn take(&mut self, document: &[u8], mut each: impl FnMut(Origin, TargetMessage)) {
        match self.document(document, &mut each) {
            Ok(()) => self.counters.documents += 1,
            Err(refusal) => {
                self.counters.refused_documents += 1;
                self.refuse(refusal);
            }
        }
    }

    /// Counts so far.
    pub fn counters(&self) -> &ReadsbCounters {
        &self.counters
    }

    /// The latest refusal; `None` if there was none.
    pub fn refused(&self) -> Option<&Refusal<ReadsbReason>> {
        self.refusal.as_ref()
    }

    fn document(&mut self, document: &[u8], each: &mut dyn FnMut(Origin, TargetMessage)) -> Read<()> {
        if document.len() > DOCUMENT_OCTETS_MAX {
            return Err(Refusal::new(ReadsbReason::Length, "document of", document.len()));
        }
        let found: Document<'_> = object(document)?;
        let now_s = found.now.map(|now| if now > SECONDS_MAX { now / 1e3 } else { now });
        if let (Some(now_s), Some(states)) = (now_s, found.aircraft) {
            time("now", now_s)?;
            for state in states {
                let state = object(state.get().as_bytes());
                self.state(state.map(|state| (state, now_s)), each);
            }
        } else if let (Some(icao), Some(timestamp_s), Some(rows)) = (found.icao, found.timestamp, found.trace) {
            time("timestamp", timestamp_s)?;
            let mut trace = Trace::new(icao);
            for row in rows {
                let state = trace.row(row);
                self.state(state.map(|(state, after_s)| (state, timestamp_s + after_s)), each);
            }
        } else if let (Some(now_s), Some(_)) = (now_s, found.hex) {
            time("now", now_s)?;
            let state = object(document)?;
            self.state(Ok((state, now_s)), each);
        } else {
            return Err(Refusal::new(
                ReadsbReason::Kind,
                "document",
                String::from_utf8_lossy(&document[..document.len().min(100)]),
            ));
        }
        Ok(())
    }

    fn state(&mut self, state: Read<(AircraftState, f64)>, each: &mut dyn FnMut(Origin, TargetMessage)) {
        self.counters.states += 1;
        match state.and_then(|(state, now_s)| self.message(&state, now_s)) {
            Ok(Some((origin, message))) => {
                self.counters.statements += u64::from(message.statement.is_some());
                each(origin, message);
            }
            Ok(None) => {}
            Err(refusal) => {
                self.counters.refused_states += 1;
                self.refuse(refusal);
            }
        }
    }

    /// The news of a state that was written at `now_s`.
    fn message(&mut self, state: &AircraftState, now_s: f64) -> Read<Option<(Origin, TargetMessage)>> {
        let age = |key, age| within(ReadsbReason::Time, key, age, &(0.0..=AGE_MAX_S));
        let position_age_s = age("seen_pos", state.seen_pos)?.unwrap_or(0.0);
        let message_age_s = age("seen", state.seen)?.unwrap_or(0.0);
        let now_ns = time("now", now_s)?;
        let time_ns = time("now less seen_pos", now_s - position_age_s)?;
        let ahead_ns = frames::time::ns(position_age_s - message_age_s);
        let (number, _) = state.number()?;
        let position = state.position()?;
        // Everything is checked before anything is remembered.
        let stated = state.statement(number)?;
        let observation = state.observation(time_ns, position, ahead_ns <= MOTION_AHEAD_MAX_NS)?;
        let known = self.aircraft.of(number, now_ns);
        let known = known.ok_or_else(|| Refusal::new(ReadsbReason::Room, "hex", state.hex.as_deref().unwrap_or("")))?;
        let is_new = position.map(|position| known.is_new(time_ns, position, REPETITION_NS.unsigned_abs()));
        let counter = match is_new {
            Some(true) => &mut self.counters.observations,
            Some(false) => &mut self.counters.repetitions,
            None => &mut self.counters.without_position,
        };
        *counter += 1;
        let observation = (is_new == Some(true)).then_some(observation);
        let statement = known.news(stated);
        let message = TargetMessage {
            time_ns: if observation.is_some() { time_ns } else { now_ns },
            observation,
            statement,
        };
        let has_news = observation.is_some() || statement.is_some();
        Ok(has_news.then_some((state.origin(), message)))
    }

    fn refuse(&mut self, refusal: Refusal<ReadsbReason>) {
        self.counters.refused[refusal.reason as usize] += 1;
        self.refusal = Some(refusal);
    }
}

/// The value of an object.
fn object<'a, T: Deserialize<'a>>(text: &'a [u8]) -> Read<T> {
    target_message::object(text).map_err(|error| Refusal::new(ReadsbReason::Json, "JSON", error))
}

fn time(key: &'static str, seconds: f64) -> Read<i64> {
    utc_ns(seconds).ok_or_else(|| Refusal::new(ReadsbReason::Time, key, seconds))
}

/// Divides a file into its documents: JSON values one after the other, on a line each or on several. Where a value is
/// cut or wrong, the rest of its line is a document, too, so that its refusal is counted.
pub fn documents(file: &[u8]) -> Documents<'_> {
    Documents { rest: file }
}

/// Documents of a file: see [`documents`].
#[derive(Clone, Debug)]
pub struct Documents<'a> {
    rest: &'a [u8],
}

impl<'a> Documents<'a> {
    /// The part of the file that was not given yet.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

impl<'a> Iterator for Documents<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<Self::Item> {
        self.rest = self.rest.trim_ascii_start();
        if self.rest.is_empty() {
            return None;
        }
        let mut values = serde_json::Deserializer::from_slice(self.rest).into_iter::<IgnoredAny>();
        let length = match values.next() {
            Some(Ok(_)) => values.byte_offset(),
            _ => self
                .rest
                .iter()
                .position(|octet| *octet == b'\n')
                .unwrap_or(self.rest.len()),
        };
        let (document, rest) = self.rest.split_at(length);
        self.rest = rest;
        Some(document)
    }
}
