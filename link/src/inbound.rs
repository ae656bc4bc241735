//! What comes in: topics of other deployments, for external sources of this one.
//!
//! Each message is checked, and its slices are published here as their source published them there: the same samples,
//! the same marks of progress, gaps where something was lost on the way. Stamps of the other host's monotonic clock are
//! turned into this one's, as far as the clocks have been compared. That is done in a thread of its own, which sleeps
//! until a message comes.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context as _, anyhow};
use bus::{Bus, Mark, Payload, Publisher, Root, SharedMemory};
use configuration::RemoteTopic;
use messages::{BatchHeader, Outgoing, PlatformState, SensorTrack, Topic, WideArea};
use runtime::Now;
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample;
use zenoh::{Session, Wait as _};

use crate::clocks::Clocks;
use crate::keys;
use crate::wire;

/// Messages that wait to be published at most.
const WAITING: usize = 1024;
/// Longest sleep, so that the end is noticed.
const SLEEP: Duration = Duration::from_millis(100);

/// Counts of what comes in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    /// Messages that were received.
    pub(crate) messages: u64,
    /// Messages that could not be read, were of another layout, or repeated others.
    pub(crate) rejected: u64,
    /// Samples that were published.
    pub(crate) published: u64,
    /// Samples that are missing from the senders' sequences.
    pub(crate) missing: u64,
    /// Samples that the senders left out because newer ones took their place.
    pub(crate) conflated: u64,
}

impl Counts {
    /// Samples that were sent and did not arrive.
    pub(crate) fn lost(&self) -> u64 {
        self.missing.saturating_sub(self.conflated)
    }
}

/// The topics that come in. They come until this is dropped.
#[derive(Debug)]
pub(crate) struct Inbound {
    counts: Arc<Mutex<Counts>>,
    overrun: Arc<AtomicU64>,
    subscribers: Vec<Subscriber<()>>,
    thread: Option<JoinHandle<anyhow::Result<()>>>,
}

/// A message and the place of its topic among those received.
type Arrived = (usize, Vec<u8>);

impl Inbound {
    /// Receives `topics` over `session`, for the deployment at `root`.
    pub(crate) fn open(
        session: &Session,
        root: &Root,
        topics: &[RemoteTopic],
        clocks: &Clocks,
    ) -> anyhow::Result<Self> {
        let counts = Arc::new(Mutex::new(Counts::default()));
        let overrun = Arc::new(AtomicU64::new(0));
        let (sender, receiver) = sync_channel(WAITING);
        let work = Work {
            root: root.clone(),
            topics: topics.to_vec(),
            clocks: clocks.clone(),
            counts: Arc::clone(&counts),
        };
        let thread = std::thread::Builder::new().name("inbound".to_owned());
        let thread = thread.spawn(move || work.run(&receiver))?;
        let mut inbound = Self {
            counts,
            overrun,
            subscribers: Vec::new(),
            thread: Some(thread),
        };
        for (index, topic) in topics.iter().enumerate() {
            inbound.subscribe(session, index, topic, sender.clone())?;
        }
        Ok(inbound)
    }

    fn subscribe(
        &mut self,
        session: &Session,
        index: usize,
        topic: &RemoteTopic,
        sender: SyncSender<Arrived>,
    ) -> anyhow::Result<()> {
        let key = keys::topic_of_any_layout(&topic.deployment, &topic.topic);
        let overrun = Arc::clone(&self.overrun);
        // What finds no room is missing from the sequence, and counted there; what is dropped at the end is not.
        let arrive = move |sample: Sample| {
            let message = sample.payload().to_bytes().into_owned();
            if let Err(TrySendError::Full(_)) = sender.try_send((index, message)) {
                overrun.fetch_add(1, Ordering::Relaxed);
            }
        };
        let subscriber = session.declare_subscriber(key.clone()).callback(arrive).wait();
        self.subscribers
            .push(subscriber.map_err(|error| anyhow!("subscribing to {key}: {error}"))?);
        Ok(())
    }

    pub(crate) fn counts(&self) -> Counts {
        *lock(&self.counts)
    }

    /// Messages that were dropped because they came faster than they could be published.
    pub(crate) fn overrun(&self) -> u64 {
        self.overrun.load(Ordering::Relaxed)
    }

    /// Fails if what comes in can no longer be published.
    pub(crate) fn check(&mut self) -> anyhow::Result<()> {
        let Some(thread) = self.thread.take_if(|thread| thread.is_finished()) else {
            return Ok(());
        };
        thread
            .join()
            .map_err(|_| anyhow!("publishing what comes in has panicked"))?
    }
}

impl Drop for Inbound {
    fn drop(&mut self) {
        // With the last sender gone, the thread ends.
        self.subscribers.clear();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn lock(counts: &Mutex<Counts>) -> MutexGuard<'_, Counts> {
    counts.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Business of the thread.
struct Work {
    root: Root,
    topics: Vec<RemoteTopic>,
    clocks: Clocks,
    counts: Arc<Mutex<Counts>>,
}

impl Work {
    fn run(self, receiver: &Receiver<Arrived>) -> anyhow::Result<()> {
        let bus: Bus<SharedMemory> = Bus::open(&self.root, "link-inbound")?;
        let inlets = self.topics.iter().map(|topic| inlet(&bus, topic));
        let mut inlets = inlets.collect::<anyhow::Result<Vec<_>>>()?;
        loop {
            match receiver.recv_timeout(SLEEP) {
                Ok((index, message)) => {
                    let now = Now::read();
                    let offset = self.clocks.of(&self.topics[index].deployment);
                    let offset_ns = offset.map(|comparison| comparison.mono_offset_ns);
                    let mut counts = *lock(&self.counts);
                    counts.messages += 1;
                    inlets[index].take(&message, now, offset_ns, &mut counts)?;
                    *lock(&self.counts) = counts;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
    }
}

/// A topic that is fed from another host.
trait Inlet {
    /// Publishes a message's slices. `offset_ns` is the other host's monotonic clock less this one's.
    fn take(&mut self, message: &[u8], now: Now, offset_ns: Option<i64>, counts: &mut Counts) -> anyhow::Result<()>;
}

fn inlet<'a>(bus: &'a Bus<SharedMemory>, remote: &RemoteTopic) -> anyhow::Result<Box<dyn Inlet + 'a>> {
    let name = || remote.into.split('/').nth(1).unwrap_or_default();
    fn feed<'a, T: Outgoing + Payload>(bus: &'a Bus<SharedMemory>, topic: Topic<T>) -> Box<dyn Inlet + 'a> {
        Box::new(Feed {
            bus,
            topic,
            publisher: None,
            conflated: 0,
        })
    }
    match remote.into.split('/').next() {
        Some("sensor") => Ok(feed::<SensorTrack>(bus, messages::sensor_tracks(name()))),
        Some("platform") => Ok(feed::<PlatformState>(bus, messages::platform_states(name()))),
        Some("wide-area") => Ok(feed::<WideArea>(bus, messages::wide_area(name()))),
        _ => Err(anyhow!("{} is no topic that is fed from outside", remote.into)),
    }
}

struct Feed<'a, T: Payload> {
    bus: &'a Bus<SharedMemory>,
    topic: Topic<T>,
    publisher: Option<Open<T>>,
    /// Samples left out, as the sender said last.
    conflated: u64,
}

/// The publisher that stands here for one there.
struct Open<T: Payload> {
    publisher: Publisher<SharedMemory, T>,
    incarnation: u64,
    next_sequence: u64,
}

impl<T: Outgoing + Payload> Feed<'_, T> {
    /// The publisher that stands for the one of `header`.
    fn standing_for(&mut self, header: &BatchHeader, now: Now) -> anyhow::Result<&mut Open<T>> {
        if self
            .publisher
            .as_ref()
            .is_none_or(|open| open.incarnation != header.incarnation)
        {
            // The one before is gone first: a topic has room for one and its successor.
            self.publisher = None;
            let publisher = self.bus.publisher(&self.topic, now.mono_ns as u64)?;
            self.publisher = Some(Open {
                publisher: publisher.of_sensor(header.sensor_uid),
                incarnation: header.incarnation,
                next_sequence: header.first_sequence,
            });
        }
        self.publisher.as_mut().context("it was just opened")
    }
}

impl<T: Outgoing + Payload> Inlet for Feed<'_, T> {
    fn take(&mut self, message: &[u8], now: Now, offset_ns: Option<i64>, counts: &mut Counts) -> anyhow::Result<()> {
        let Some((head, slices)) = wire::read::<T>(message, self.topic.capacity.slice_len) else {
            counts.rejected += 1;
            return Ok(());
        };
        counts.conflated += head
            .conflated
            .saturating_sub(std::mem::replace(&mut self.conflated, head.conflated));
        for (header, mut samples) in slices {
            let open = self.standing_for(&header, now)?;
            let Some(missing) = header.first_sequence.checked_sub(open.next_sequence) else {
                counts.rejected += 1;
                continue;
            };
            counts.missing += missing;
            counts.published += samples.len() as u64;
            open.publisher.pass_over(missing);
            open.next_sequence = header.first_sequence + samples.len() as u64;
            for sample in &mut samples {
                let here_ns = offset_ns.map(|offset_ns| sample.ingested_ns() - offset_ns);
                sample.came_in(here_ns.unwrap_or(now.mono_ns));
            }
            let mark = Mark {
                progress_ns: header.progress_ns,
                sent_ns: now.mono_ns,
                end: header.flags & BatchHeader::END != 0,
            };
            open.publisher.send(mark, samples.len(), |index, sequence| {
                let mut sample = samples[index];
                sample.leave(sequence, now.mono_ns);
                sample
            })?;
        }
        Ok(())
    }
}
