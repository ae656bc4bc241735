//! Incoming direction: topics of other deployments.
//!
//! Messages wait for a separate thread, which sleeps until a message arrives. An [`Inlet`] checks the message and
//! publishes its slices locally.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::anyhow;
use bus::{Bus, Root, SharedMemory};
use messages::Counter;
use runtime::{HealthEntry, Now};
use zenoh::pubsub::Subscriber;
use zenoh::query::{ConsolidationMode, Reply};
use zenoh::sample::Sample;
use zenoh::{Session, Wait as _};

use crate::clocks::PeerClocks;
use crate::keys;
use crate::refused;
use crate::session::MESSAGE_MAX;

/// Messages that wait to be published at most.
const WAITING: usize = 1024;
/// Largest total size of waiting messages of all senders, bytes.
pub(crate) const WAITING_OCTETS: usize = 4 * MESSAGE_MAX;
/// Longest sleep, so that the end is noticed.
const SLEEP: Duration = Duration::from_millis(100);
/// Time limit of a request without an answer.
const ANSWER_PATIENCE: Duration = Duration::from_secs(5);
/// Time between two requests for missing samples, nanoseconds.
const ASK_NS: i64 = 500_000_000;
/// Largest time between two requests if losses continue after each answer: a snapshot is large, and must not be the
/// cause of the overload.
const ASK_MAX_NS: i64 = 8_000_000_000;

/// Counts of the incoming direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct InboundCounts {
    /// Messages that were received.
    pub(crate) messages: u64,
    /// Messages that could not be read, or repeated others.
    pub(crate) rejected: u64,
    /// Messages of another layout.
    pub(crate) schema_mismatch: u64,
    /// Samples that came, but for whole pictures.
    pub(crate) came: u64,
    /// Samples that were published.
    pub(crate) published: u64,
    /// Samples that are missing from the senders' sequences.
    pub(crate) missing: u64,
    /// Samples omitted by the senders because newer samples replaced them.
    pub(crate) conflated: u64,
}

impl InboundCounts {
    /// Samples that were sent and did not arrive.
    pub(crate) fn lost(&self) -> u64 {
        self.missing.saturating_sub(self.conflated)
    }
}

/// A topic that is wanted.
pub(crate) struct Wanted {
    /// Deployment that has it.
    pub(crate) deployment: String,
    /// Its name there.
    pub(crate) topic: String,
    /// Constructor of the inlet for the messages, called in the receiving thread.
    pub(crate) inlet: Box<dyn FnOnce() -> Box<dyn Inlet> + Send>,
}

/// The topics that come in. They come until this is dropped.
#[derive(Debug)]
pub(crate) struct Inbound {
    counts: Arc<Mutex<InboundCounts>>,
    overrun: Arc<AtomicU64>,
    subscribers: Vec<Subscriber<()>>,
    is_closed: Arc<AtomicBool>,
    thread: Option<JoinHandle<anyhow::Result<()>>>,
}

/// Something for the topic in this place among those wanted.
struct Arrived {
    index: usize,
    what: InboundEvent,
}

enum InboundEvent {
    Message(Vec<u8>),
    /// A message that was asked for.
    Answer(Vec<u8>),
    /// No further answer comes to the latest question.
    EndOfAnswers,
}

/// Queue of received messages for the thread.
#[derive(Clone)]
struct Entrance {
    sender: SyncSender<Arrived>,
    octets: Arc<AtomicUsize>,
    overrun: Arc<AtomicU64>,
}

impl Entrance {
    fn arrive(&self, index: usize, sample: &Sample) {
        let octets = sample.payload().len();
        let has_room = self.octets.fetch_add(octets, Ordering::Relaxed) + octets <= WAITING_OCTETS;
        let message = has_room.then(|| sample.payload().to_bytes().into_owned());
        // Messages without room are missing in the sequence, and counted there; messages dropped at the end are not
        // counted.
        let offered = message.map(|message| {
            let what = InboundEvent::Message(message);
            self.sender.try_send(Arrived { index, what })
        });
        if let None | Some(Err(TrySendError::Full(_))) = offered {
            self.octets.fetch_sub(octets, Ordering::Relaxed);
            self.overrun.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Receiver of the answers to a request, and of their end.
struct Answers {
    index: usize,
    entrance: Entrance,
}

impl Answers {
    fn arrive(&self, sample: &Sample) {
        let message = sample.payload().to_bytes().into_owned();
        self.entrance.octets.fetch_add(message.len(), Ordering::Relaxed);
        // Waits for room: the sender has more, and is to wait as well. It fails at the end of this process only.
        let _ = self.entrance.sender.send(Arrived {
            index: self.index,
            what: InboundEvent::Answer(message),
        });
    }
}

impl Drop for Answers {
    fn drop(&mut self) {
        let _ = self.entrance.sender.send(Arrived {
            index: self.index,
            what: InboundEvent::EndOfAnswers,
        });
    }
}

impl Inbound {
    /// Receives the `wanted` topics over `session`, for the deployment at `root`.
    pub(crate) fn open(
        session: &Session,
        root: &Root,
        wanted: Vec<Wanted>,
        clocks: &PeerClocks,
    ) -> anyhow::Result<Self> {
        let counts = Arc::new(Mutex::new(InboundCounts::default()));
        let (sender, receiver) = sync_channel(WAITING);
        let is_closed = Arc::new(AtomicBool::new(false));
        let entrance = Entrance {
            sender,
            octets: Arc::default(),
            overrun: Arc::new(AtomicU64::new(0)),
        };
        let mut subscribers = Vec::new();
        for (index, each) in wanted.iter().enumerate() {
            let key = keys::topic_of_any_layout(&each.deployment, &each.topic);
            let entrance = entrance.clone();
            let arrive = move |sample: Sample| entrance.arrive(index, &sample);
            let subscriber = session.declare_subscriber(key.clone()).callback(arrive).wait();
            subscribers.push(subscriber.map_err(|error| anyhow!("subscribing to {key}: {error}"))?);
        }
        let overrun = Arc::clone(&entrance.overrun);
        let work = InboundWork {
            root: root.clone(),
            wanted,
            clocks: clocks.clone(),
            counts: Arc::clone(&counts),
            session: session.clone(),
            entrance,
            is_closed: Arc::clone(&is_closed),
        };
        let thread = std::thread::Builder::new().name("inbound".to_owned());
        Ok(Self {
            counts,
            overrun,
            subscribers,
            is_closed,
            thread: Some(thread.spawn(move || work.run(&receiver))?),
        })
    }

    pub(crate) fn counts(&self) -> InboundCounts {
        *lock(&self.counts)
    }

    /// Reports received and rejected messages, for links and mirrors alike.
    pub(crate) fn report(&self, entry: &mut HealthEntry) {
        let came = self.counts();
        entry.set(Counter::Published, came.published);
        entry.set(Counter::LostOnTheWay, came.lost());
        entry.set(Counter::MessagesRejected, came.rejected + self.overrun());
        entry.counters.add(Counter::RejectedSchema, came.schema_mismatch);
        entry.set(Counter::RequestsRejected, refused::so_far());
    }

    /// Returns the number of messages dropped because they arrived faster than publication.
    fn overrun(&self) -> u64 {
        self.overrun.load(Ordering::Relaxed)
    }

    /// Fails if received messages can no longer be published.
    pub(crate) fn check(&mut self) -> anyhow::Result<()> {
        let Some(thread) = self.thread.take_if(|thread| thread.is_finished()) else {
            return Ok(());
        };
        thread
            .join()
            .map_err(|_| anyhow!("publishing received samples has panicked"))?
    }
}

impl Drop for Inbound {
    fn drop(&mut self) {
        self.subscribers.clear();
        self.is_closed.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn lock(counts: &Mutex<InboundCounts>) -> MutexGuard<'_, InboundCounts> {
    counts.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Business of the thread.
struct InboundWork {
    root: Root,
    wanted: Vec<Wanted>,
    clocks: PeerClocks,
    counts: Arc<Mutex<InboundCounts>>,
    session: Session,
    entrance: Entrance,
    is_closed: Arc<AtomicBool>,
}

impl InboundWork {
    fn run(self, receiver: &Receiver<Arrived>) -> anyhow::Result<()> {
        let bus: Bus<SharedMemory> = Bus::open(&self.root, "link-inbound")?;
        let open = |wanted: Wanted| (wanted.deployment, (wanted.inlet)());
        let mut inlets: Vec<(String, Box<dyn Inlet>)> = self.wanted.into_iter().map(open).collect();
        let mut asking = vec![Asking::NOT_YET; inlets.len()];
        while !self.is_closed.load(Ordering::Relaxed) {
            let arrived = receiver.recv_timeout(SLEEP);
            let now = Now::read();
            if let Ok(Arrived { index, what }) = arrived {
                let (deployment, inlet) = &mut inlets[index];
                let (message, is_answer) = match &what {
                    InboundEvent::Message(message) => (Some(message), false),
                    InboundEvent::Answer(message) => (Some(message), true),
                    InboundEvent::EndOfAnswers => (None, true),
                };
                let octets = message.map_or(0, Vec::len);
                self.entrance.octets.fetch_sub(octets, Ordering::Relaxed);
                let offset = self.clocks.of(deployment);
                let arrival = Arrival {
                    bus: &bus,
                    message: message.map_or(&[], Vec::as_slice),
                    is_answer,
                    now,
                    offset_ns: offset.map(|comparison| comparison.mono_offset_ns),
                };
                let mut counts = *lock(&self.counts);
                counts.messages += u64::from(message.is_some());
                match message {
                    Some(_) => inlet.take(arrival, &mut counts)?,
                    None => inlet.answered(arrival, &mut counts)?,
                }
                *lock(&self.counts) = counts;
            }
            for (index, (_, inlet)) in inlets.iter_mut().enumerate() {
                // An answer may take a while.
                if let Some(Question { key, payload }) = asking[index].is_due(inlet.lacks(), now) {
                    let answers = Answers {
                        index,
                        entrance: self.entrance.clone(),
                    };
                    let take = move |reply: Reply| {
                        if let Ok(sample) = reply.result() {
                            answers.arrive(sample);
                        }
                    };
                    inlet.asked();
                    // Without anybody there is no answer, and it is asked again.
                    let question = self.session.get(key).consolidation(ConsolidationMode::None);
                    let question = question.payload(payload).timeout(ANSWER_PATIENCE);
                    let _ = question.callback(take).wait();
                }
            }
        }
        Ok(())
    }
}

/// Times of the requests for a topic's missing samples.
#[derive(Clone, Copy)]
struct Asking {
    at_ns: i64,
    pause_ns: i64,
    /// Whether it has been had since.
    was_had: bool,
}

impl Asking {
    const NOT_YET: Self = Self {
        at_ns: i64::MIN,
        pause_ns: ASK_NS,
        was_had: true,
    };

    /// Returns the request that is due now for missing samples.
    fn is_due(&mut self, lacks: Option<Question>, now: Now) -> Option<Question> {
        self.was_had |= lacks.is_none();
        let since_ns = now.mono_ns.saturating_sub(self.at_ns);
        let due = lacks.filter(|_| since_ns >= self.pause_ns)?;
        let is_soon_again = self.was_had && since_ns < 4 * self.pause_ns;
        *self = Self {
            at_ns: now.mono_ns,
            pause_ns: if is_soon_again {
                (2 * self.pause_ns).min(ASK_MAX_NS)
            } else {
                ASK_NS
            },
            was_had: false,
        };
        Some(due)
    }
}

/// A message that has arrived.
pub(crate) struct Arrival<'a> {
    pub(crate) bus: &'a Bus<SharedMemory>,
    pub(crate) message: &'a [u8],
    /// Whether it was asked for.
    pub(crate) is_answer: bool,
    pub(crate) now: Now,
    /// The other host's monotonic clock less this one's, nanoseconds.
    pub(crate) offset_ns: Option<i64>,
}

/// A topic that is fed from another host.
pub(crate) trait Inlet {
    /// Publishes a message's slices.
    ///
    /// # Errors
    /// If shared memory fails.
    fn take(&mut self, arrival: Arrival<'_>, counts: &mut InboundCounts) -> anyhow::Result<()>;

    /// Returns the request for missing samples; `None` if none are missing.
    fn lacks(&self) -> Option<Question>;

    /// The question has been asked.
    fn asked(&mut self) {}

    /// All answers to the latest question have come, if any have.
    ///
    /// # Errors
    /// If shared memory fails.
    fn answered(&mut self, _arrival: Arrival<'_>, _counts: &mut InboundCounts) -> anyhow::Result<()> {
        Ok(())
    }
}

/// Request for a topic's missing samples.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Question {
    /// Key of the request.
    pub(crate) key: String,
    /// Description of the samples already present.
    pub(crate) payload: Vec<u8>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lost_again_at_once_is_asked_for_ever_more_rarely() {
        let mut asking = Asking::NOT_YET;
        let mut ask = |lacks: bool, ms: i64| {
            let now = Now {
                mono_ns: ms * 1_000_000,
                utc_ns: 0,
            };
            asking.is_due(lacks.then(Question::default), now).is_some()
        };
        assert!(ask(true, 0), "at once");
        assert!(
            !ask(true, 499) && ask(true, 500) && ask(true, 1000),
            "as often while nobody answers"
        );
        assert!(!ask(false, 1100) && !ask(true, 1200) && ask(true, 1500));
        assert!(
            !ask(false, 1600) && !ask(true, 2000) && ask(true, 2500),
            "it was had, and is lost again"
        );
        assert!(!ask(false, 2600) && !ask(true, 4400) && ask(true, 4500));
        assert!(
            !ask(false, 4600) && ask(true, 30_000) && !ask(false, 30_100) && ask(true, 30_500),
            "after a long peace"
        );
    }
}
