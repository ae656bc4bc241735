//! Events to messages.

use frames::time::NS_PER_S;
use messages::TrackState;
use observations::Statement;

use super::event::ThingEvent;
use super::reason::{CotReason, Read};
use super::stream::EventStream;
use crate::target_message::{KnownTarget, Memory, Refusal, TargetMessage};

/// After this silence a thing may be forgotten, nanoseconds.
pub const SILENCE_MAX_NS: i64 = 600 * NS_PER_S;

/// Octets at the beginning of an event that are shown.
const SHOWN_MAX: usize = 100;

/// Settings of a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CotSettings {
    /// Most things that are remembered.
    pub things_max: usize,
}

impl Default for CotSettings {
    /// More things than a map shows.
    fn default() -> Self {
        Self { things_max: 1 << 14 }
    }
}

/// Counts. Each event is in exactly one of `observations`, `repetitions`, `without_position`, `others` and `refused`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CotCounters {
    /// Events that have begun.
    pub events: u64,
    /// Events with a new position.
    pub observations: u64,
    /// Events whose position was given before.
    pub repetitions: u64,
    /// Events of things without a position.
    pub without_position: u64,
    /// Events that are not of things.
    pub others: u64,
    /// Statements given.
    pub statements: u64,
    /// Events that were refused, by [`CotReason`].
    pub refused: [u64; CotReason::ALL.len()],
}

/// Reader of a stream of events.
#[derive(Debug)]
pub struct CotReader {
    stream: EventStream,
    events: EventReader,
}

/// Reader of single events.
#[derive(Debug)]
struct EventReader {
    things: Memory<KnownTarget>,
    counters: CotCounters,
    refusal: Option<Refusal<CotReason>>,
}

impl CotReader {
    /// Returns a reader with an allocated table.
    pub fn new(settings: CotSettings) -> Self {
        Self {
            stream: EventStream::new(),
            events: EventReader {
                things: Memory::new(settings.things_max, SILENCE_MAX_NS),
                counters: CotCounters::default(),
                refusal: None,
            },
        }
    }

    /// Takes octets of the stream, divided anywhere; calls `each` for each event with news.
    pub fn take(&mut self, octets: &[u8], mut each: impl FnMut(TargetMessage)) {
        let events = &mut self.events;
        self.stream
            .take(octets, &mut |octets, fault| events.event(octets, fault, &mut each));
    }

    /// The stream has ended, or its datagram: an event that has begun was cut.
    pub fn end(&mut self) {
        let events = &mut self.events;
        self.stream
            .end(&mut |octets, fault| events.event(octets, fault, &mut |_| {}));
    }

    /// Counts so far.
    pub fn counters(&self) -> &CotCounters {
        &self.events.counters
    }

    /// Octets that belong to no event, such as declarations of XML.
    pub fn octets_between(&self) -> u64 {
        self.stream.between()
    }

    /// The latest refusal; `None` if there was none.
    pub fn refused(&self) -> Option<&Refusal<CotReason>> {
        self.events.refusal.as_ref()
    }
}

impl EventReader {
    fn event(&mut self, octets: &[u8], fault: Option<CotReason>, each: &mut dyn FnMut(TargetMessage)) {
        self.counters.events += 1;
        let message = match fault {
            Some(reason) => {
                let begin = String::from_utf8_lossy(&octets[..octets.len().min(SHOWN_MAX)]);
                Err(Refusal::new(reason, "event", begin))
            }
            None => self.message(octets),
        };
        match message {
            Ok(Some(message)) => {
                self.counters.statements += u64::from(message.statement.is_some());
                each(message);
            }
            Ok(None) => {}
            Err(refusal) => {
                self.counters.refused[refusal.reason as usize] += 1;
                self.refusal = Some(refusal);
            }
        }
    }

    fn message(&mut self, octets: &[u8]) -> Read<Option<TargetMessage>> {
        let Some(event) = ThingEvent::read(octets)? else {
            self.counters.others += 1;
            return Ok(None);
        };
        let known = self.things.of(event.number, event.time_ns);
        let known = known.ok_or_else(|| Refusal::new(CotReason::Room, "track", event.number))?;
        let position = event.observation.geodetic;
        // The end of a track repeats the last position.
        let has_ended = event.observation.state == TrackState::Terminated;
        let is_new = position.map(|position| known.is_new(event.time_ns, position, 1) || has_ended);
        let counter = match is_new {
            Some(true) => &mut self.counters.observations,
            Some(false) => &mut self.counters.repetitions,
            None => &mut self.counters.without_position,
        };
        *counter += 1;
        let observation = (is_new == Some(true)).then_some(event.observation);
        let statement = known.news(Statement {
            track_number: event.number,
            category: event.category,
            ..Statement::default()
        });
        let has_news = observation.is_some() || statement.is_some();
        Ok(has_news.then_some(TargetMessage {
            time_ns: event.time_ns,
            observation,
            statement,
        }))
    }
}
