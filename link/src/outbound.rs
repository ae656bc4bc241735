//! Outgoing direction: topics of this deployment, for all requesting readers.
//!
//! Slices are taken from shared memory by a normal subscriber, combined into messages of some tens of kilobytes, and
//! passed to the [`Outbox`]. A full outbox means that the network is too slow. Then the newest samples of an ordinary
//! topic are omitted. Of system tracks, the newest state of each track replaces older states, so that a slow reader
//! sees all targets at their present positions, only less often. Both are counted.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bus::{Bus, Payload, SharedMemory, Subscriber};
use messages::{BatchHeader, FrameOrigin, SystemTrack, Topic};
use runtime::Now;

use crate::history::{self, SharedHistory};
use crate::outbox::Outbox;
use crate::picture::NewestStates;
use crate::wire::{Head, Message};

/// Slices taken in one turn: as many as can wait.
const SLICES_PER_TURN: usize = 256;
/// Size at which a message goes out.
const MESSAGE_OCTETS: usize = 60_000;
/// Silence after which a stream repeats its position, nanoseconds. Otherwise a reader would not notice the loss of
/// the last samples before a pause.
const SILENCE_NS: i64 = 500_000_000;
/// Number of held-back states in a slice.
const HELD_BACK_PER_SLICE: usize = 32;

/// Counts of the outgoing direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct OutboundCounts {
    pub(crate) taken: u64,
    pub(crate) lost: u64,
    pub(crate) schema_mismatch: u64,
    pub(crate) sent: u64,
    pub(crate) unsent: u64,
    pub(crate) conflated: u64,
}

/// A topic on its way out.
pub(crate) trait Outbound {
    /// Takes published slices and offers them to the outbox; returns whether more may be waiting.
    fn turn(&mut self, now: Now, outbox: &Outbox) -> anyhow::Result<bool>;

    /// Whether slices are waiting.
    fn has_slices(&self) -> bool;

    fn counts(&self) -> OutboundCounts;
}

/// The deployment that sends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sender {
    /// Origin of its frame.
    pub(crate) frame: FrameOrigin,
    /// Its number.
    pub(crate) origin: u32,
}

impl Sender {
    pub(crate) fn head(self, now: Now, conflated: u64) -> Head {
        Head {
            conflated,
            sent_utc_ns: now.utc_ns,
            sent_mono_ns: now.mono_ns,
            frame: self.frame,
            origin: self.origin,
            part: None,
        }
    }
}

/// A stream: its index in the outbox, and the sender.
pub(crate) type Lane = (usize, Sender);

/// How far a lane is.
#[derive(Debug, Default)]
struct LaneProgress {
    /// Header of a slice that would come next; `None` while nothing has come.
    header: Option<BatchHeader>,
    at_ns: i64,
}

impl LaneProgress {
    fn pass(&mut self, header: &BatchHeader, count: usize, now: Now) {
        self.header = Some(BatchHeader {
            first_sequence: header.first_sequence + count as u64,
            ..*header
        });
        self.at_ns = now.mono_ns;
    }

    /// An empty slice where it has been silent for long.
    fn say<T: Payload>(&mut self, now: Now) -> Option<Message> {
        let header = self.header.filter(|_| now.mono_ns - self.at_ns >= SILENCE_NS)?;
        self.at_ns = now.mono_ns;
        let mut message = Message::new();
        message.add::<T>(&header, &[]);
        Some(message)
    }
}

/// A topic with all samples sent.
pub(crate) struct TopicStream<T: Payload> {
    lane: Lane,
    subscriber: Subscriber<SharedMemory, T>,
    counts: OutboundCounts,
    reached: LaneProgress,
    history: SharedHistory,
}

impl<T: Payload> TopicStream<T> {
    /// Opens a topic; sent messages are kept in `history`.
    pub(crate) fn open(
        bus: &Bus<SharedMemory>,
        topic: &Topic<T>,
        lane: Lane,
        joined_ns: u64,
        history: SharedHistory,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            lane,
            subscriber: bus.subscriber(topic, || joined_ns)?,
            counts: OutboundCounts::default(),
            reached: LaneProgress::default(),
            history,
        })
    }
}

impl<T: Payload> Outbound for TopicStream<T> {
    fn turn(&mut self, now: Now, outbox: &Outbox) -> anyhow::Result<bool> {
        let ((lane, sender), counts) = (self.lane, &mut self.counts);
        let mut message = Message::new();
        let history = &self.history;
        let mut send = |message: Message, reached: &LaneProgress| {
            let samples = message.samples() as u64;
            if outbox.has_room(message.octets()) {
                counts.sent += samples;
                let message = message.finish(sender.head(now, 0));
                if let Some(header) = &reached.header {
                    history::lock(history).keep(&message, header);
                }
                outbox.put(lane, message);
            } else {
                counts.unsent += samples;
            }
        };
        let reached = &mut self.reached;
        let slices = self.subscriber.take(SLICES_PER_TURN, |header, samples| {
            reached.pass(header, samples.len(), now);
            message.add(header, samples);
            if message.octets() >= MESSAGE_OCTETS {
                send(std::mem::replace(&mut message, Message::new()), reached);
            }
        })?;
        match message.is_empty() {
            false => send(message, reached),
            true => {
                if let Some(sign) = reached.say::<T>(now) {
                    send(sign, reached);
                }
            }
        }
        Ok(slices == SLICES_PER_TURN)
    }

    fn has_slices(&self) -> bool {
        self.subscriber.has_slices()
    }

    fn counts(&self) -> OutboundCounts {
        let taken = self.subscriber.counts();
        OutboundCounts {
            taken: taken.taken,
            lost: taken.lost,
            schema_mismatch: taken.schema_mismatch,
            ..self.counts
        }
    }
}

/// The snapshot for late readers.
pub(crate) type SharedPicture = Arc<Mutex<NewestStates>>;

pub(crate) fn lock(picture: &SharedPicture) -> MutexGuard<'_, NewestStates> {
    picture.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The system tracks: as they come, or the newest of each.
pub(crate) struct OutgoingTracks {
    stream: TopicStream<SystemTrack>,
    picture: SharedPicture,
    /// Tracks with an unsent newest state.
    held_back: BTreeSet<u32>,
    /// States that have been taken since something is held back.
    conflated: u64,
    /// Last words of tracks that ended meanwhile.
    ended: Vec<SystemTrack>,
    header: BatchHeader,
}

impl OutgoingTracks {
    pub(crate) fn open(
        bus: &Bus<SharedMemory>,
        topic: &Topic<SystemTrack>,
        lane: Lane,
        joined_ns: u64,
        picture: SharedPicture,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            // Newer states take the place of those that are missed.
            stream: TopicStream::open(bus, topic, lane, joined_ns, SharedHistory::default())?,
            picture,
            held_back: BTreeSet::new(),
            conflated: 0,
            ended: Vec::new(),
            header: BatchHeader::default(),
        })
    }

    /// Sends held-back states in the order of their numbers, as far as there is room.
    fn catch_up(&mut self, now: Now, outbox: &Outbox) {
        let picture = lock(&self.picture);
        let held_back = self
            .held_back
            .iter()
            .filter_map(|number| picture.state(*number).copied());
        let mut states: Vec<SystemTrack> = held_back.chain(self.ended.iter().copied()).collect();
        drop(picture);
        states.sort_unstable_by_key(|state| state.sequence);
        for states in states.chunks(HELD_BACK_PER_SLICE) {
            let mut message = Message::new();
            for state in states {
                // Missing numbers in between belong to replaced states.
                let header = BatchHeader {
                    first_sequence: state.sequence,
                    ..self.header
                };
                message.add(&header, std::slice::from_ref(state));
            }
            if !outbox.has_room(message.octets()) {
                return;
            }
            self.conflated -= states.len() as u64;
            self.stream.counts.sent += states.len() as u64;
            for state in states {
                self.held_back.remove(&state.track_number);
                self.ended.retain(|ended| ended.track_number != state.track_number);
            }
            let conflated = self.stream.counts.conflated;
            let (lane, sender) = self.stream.lane;
            outbox.put(lane, message.finish(sender.head(now, conflated)));
        }
        // All that was taken meanwhile and has not gone out never will.
        self.stream.counts.conflated += std::mem::take(&mut self.conflated);
    }
}

impl Outbound for OutgoingTracks {
    fn turn(&mut self, now: Now, outbox: &Outbox) -> anyhow::Result<bool> {
        if !self.held_back.is_empty() || !self.ended.is_empty() {
            self.catch_up(now, outbox);
        }
        let mut picture = self.picture.lock().unwrap_or_else(PoisonError::into_inner);
        let stream = &mut self.stream;
        let mut message = Message::new();
        let ((lane, sender), counts, reached) = (stream.lane, &mut stream.counts, &mut stream.reached);
        let (held_back, ended, waiting, last) = (
            &mut self.held_back,
            &mut self.ended,
            &mut self.conflated,
            &mut self.header,
        );
        let slices = stream.subscriber.take(SLICES_PER_TURN, |header, states| {
            *last = *header;
            reached.pass(header, states.len(), now);
            picture.hear(header, states);
            let octets = message.octets() + size_of_val(states) + 2 * size_of::<BatchHeader>();
            if held_back.is_empty() && ended.is_empty() && outbox.has_room(octets) {
                message.add(header, states);
                if message.octets() >= MESSAGE_OCTETS {
                    counts.sent += message.samples() as u64;
                    let message = std::mem::replace(&mut message, Message::new());
                    outbox.put(lane, message.finish(sender.head(now, counts.conflated)));
                }
                return;
            }
            *waiting += states.len() as u64;
            for state in states {
                match picture.state(state.track_number) {
                    Some(_) => drop(held_back.insert(state.track_number)),
                    None => {
                        held_back.remove(&state.track_number);
                        ended.push(*state);
                    }
                }
            }
        })?;
        let is_complete = held_back.is_empty() && ended.is_empty();
        let sign = || reached.say::<SystemTrack>(now).filter(|_| is_complete);
        if let Some(message) = Some(message).filter(|message| !message.is_empty()).or_else(sign) {
            counts.sent += message.samples() as u64;
            outbox.put(lane, message.finish(sender.head(now, counts.conflated)));
        }
        Ok(slices == SLICES_PER_TURN)
    }

    fn has_slices(&self) -> bool {
        self.stream.has_slices()
    }

    fn counts(&self) -> OutboundCounts {
        self.stream.counts()
    }
}
