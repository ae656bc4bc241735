//! Reader of a stream: octets in, observations and statements out.
//!
//! Replies to interrogations have no checksum of their own: the address that the checksum leaves is right if a
//! squitter had it within the last minute. After a minute of silence another aircraft may take an aircraft's place in
//! the table. What ground stations send about an aircraft (TIS-B, ADS-R) has entries of its own: it is another source.

use observations::{Observation, Statement};
use rustc_hash::FxHashMap;

use super::aircraft::Aircraft;
use super::clock::{FrameClock, StreamClock};
use super::counters::ModeSCounters;
use super::frame::ModeSFrame;
use super::framing::{FrameReader, FrameStamp, Framed};
use super::message::{ModeSMessage, ModeSOrigin};
use super::position::{PLACE_AGE_MAX_NS, ReceiverRange};
use super::refusal::ModeSRefusal;
use crate::sbs::SILENCE_MAX_NS;

/// How to read a receiver's frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeSSettings {
    /// UTC of the first frame of a stream that has ticks only, nanoseconds since 1970.
    pub start_utc_ns: i64,
    /// The receiver's place and range; without it, positions on the ground need an earlier position in the air.
    pub receiver: Option<ReceiverRange>,
    /// Most aircraft that are remembered.
    pub aircraft_max: usize,
}

impl Default for ModeSSettings {
    /// No place, and more aircraft than a receiver receives in a minute.
    fn default() -> Self {
        Self {
            start_utc_ns: 0,
            receiver: None,
            aircraft_max: 4096,
        }
    }
}

/// What the reader gives, with its origin and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeSOutput {
    /// Who has sent the frame. Each origin is a source of its own.
    pub origin: ModeSOrigin,
    /// Whether the address is not the aircraft's own. The identity then has none, and the track number is above 2²⁴.
    pub is_anonymous: bool,
    /// Time of the frame, UTC, nanoseconds since 1970.
    pub utc_ns: i64,
    /// Clock of `utc_ns`.
    pub clock: FrameClock,
    /// The value.
    pub value: ModeSValue,
}

/// Value of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "it is taken apart at once, and must not allocate"
)]
pub enum ModeSValue {
    /// Position, completed with recent values.
    Observation(Observation),
    /// Statement that has changed.
    Statement(Statement),
}

/// Reader of the frames of one receiver.
#[derive(Debug)]
pub struct ModeSReader {
    frames: FrameReader,
    merger: Merger,
}

/// What is known of the aircraft.
#[derive(Debug)]
struct Merger {
    settings: ModeSSettings,
    aircraft: FxHashMap<(ModeSOrigin, bool, u32), Entry>,
    clock: StreamClock,
    counters: ModeSCounters,
}

#[derive(Debug, Default)]
struct Entry {
    last_ns: i64,
    values: Aircraft,
}

impl ModeSReader {
    /// Makes a reader with an allocated table.
    pub fn new(settings: ModeSSettings) -> Self {
        let mut aircraft = FxHashMap::default();
        aircraft.reserve(settings.aircraft_max);
        Self {
            frames: FrameReader::default(),
            merger: Merger {
                settings,
                aircraft,
                clock: StreamClock::starting_at(settings.start_utc_ns),
                counters: ModeSCounters::default(),
            },
        }
    }

    /// Counts so far.
    pub fn counters(&self) -> &ModeSCounters {
        &self.merger.counters
    }

    /// Takes octets of the stream, received at `received_utc_ns` (UTC, nanoseconds since 1970), `None` in a file
    /// without times of receipt. Frames may begin and end anywhere.
    pub fn take(&mut self, octets: &[u8], received_utc_ns: Option<i64>, out: &mut impl FnMut(ModeSOutput)) {
        let Self { frames, merger } = self;
        frames.take(octets, &mut |framed| merger.take(framed, received_utc_ns, out));
        merger.counters.damaged_octets = frames.damaged_octets();
    }

    /// The stream has ended, or its connection: what has begun is a frame, or was cut. The next octets begin another
    /// stream; what is known of the aircraft stays.
    pub fn end(&mut self, received_utc_ns: Option<i64>, out: &mut impl FnMut(ModeSOutput)) {
        let Self { frames, merger } = self;
        frames.end(&mut |framed| merger.take(framed, received_utc_ns, out));
    }
}

impl Merger {
    /// Takes what stands in the stream, and counts it once.
    fn take(&mut self, framed: Framed, received_utc_ns: Option<i64>, out: &mut impl FnMut(ModeSOutput)) {
        let taken = match framed {
            Framed::Frame(frame, stamp) => self.take_frame(&frame, stamp, received_utc_ns, out),
            Framed::Other => Ok(false),
            Framed::Refused(refusal) => Err(refusal),
        };
        match taken {
            Ok(true) => self.counters.accepted += 1,
            Ok(false) => self.counters.other += 1,
            Err(refusal) => self.counters.refused[refusal as usize] += 1,
        }
    }

    /// Takes a frame; `false` for a kind that is not used. A refused frame gives and changes nothing, except that its
    /// position may be the half of another pair.
    fn take_frame(
        &mut self,
        frame: &ModeSFrame,
        stamp: FrameStamp,
        received_utc_ns: Option<i64>,
        out: &mut impl FnMut(ModeSOutput),
    ) -> Result<bool, ModeSRefusal> {
        let (clock, utc_ns) = self.clock.date(stamp, received_utc_ns).ok_or(ModeSRefusal::Time)?;
        self.counters.tick_restarts = self.clock.restarts;
        self.counters.timed += u64::from(stamp != FrameStamp::None);
        let Some(message) = ModeSMessage::read(frame)? else {
            return Ok(false);
        };
        let receiver = self.settings.receiver;
        let values = self.values(&message, utc_ns)?;
        let position_deg = match message.position {
            Some(position) => values
                .positions
                .take(position, utc_ns, message.ground_speed_mps, receiver.as_ref())?,
            None => None,
        };
        values.take(&message, utc_ns);
        let statement = values.statement(&message);
        let observation = position_deg.map(|position_deg| values.observation(&message, position_deg, utc_ns));
        self.count(&message, observation.is_some(), statement.is_some());
        let observation = observation.map(ModeSValue::Observation);
        for value in observation.into_iter().chain(statement.map(ModeSValue::Statement)) {
            out(ModeSOutput {
                origin: message.origin,
                is_anonymous: message.is_anonymous,
                utc_ns,
                clock,
                value,
            });
        }
        Ok(true)
    }

    /// Values of the message's aircraft; forgets silent aircraft if that makes room.
    fn values(&mut self, message: &ModeSMessage, utc_ns: i64) -> Result<&mut Aircraft, ModeSRefusal> {
        let within = |age_max_ns: i64, entry: &Entry| utc_ns.abs_diff(entry.last_ns) <= age_max_ns.unsigned_abs();
        let key = (message.origin, message.is_anonymous, message.address);
        let known = self.aircraft.get(&key);
        if message.is_reply && !known.is_some_and(|entry| within(SILENCE_MAX_NS, entry)) {
            return Err(ModeSRefusal::Address);
        }
        let most = self.settings.aircraft_max;
        if known.is_none() && self.aircraft.len() >= most {
            self.aircraft.retain(|_, entry| within(SILENCE_MAX_NS, entry));
            if self.aircraft.len() >= most {
                return Err(ModeSRefusal::Table);
            }
        }
        let entry = self.aircraft.entry(key).or_default();
        if !within(PLACE_AGE_MAX_NS, entry) {
            *entry = Entry::default();
        }
        // Replies prove nothing about their address.
        if !message.is_reply {
            entry.last_ns = utc_ns;
        }
        Ok(&mut entry.values)
    }

    fn count(&mut self, message: &ModeSMessage, is_observed: bool, is_stated: bool) {
        let counters = &mut self.counters;
        counters.observations += u64::from(is_observed);
        counters.statements += u64::from(is_stated);
        counters.unpaired += u64::from(message.position.is_some() && !is_observed);
        counters.anonymous += u64::from(message.is_anonymous);
        match message.origin {
            ModeSOrigin::Own => {}
            ModeSOrigin::TisB => counters.tis_b += 1,
            ModeSOrigin::Rebroadcast => counters.rebroadcast += 1,
        }
    }
}
