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
use configuration::{Link, Process, RemoteTopic};
use frames::{FrameChange, SystemFrame};
use messages::{BatchHeader, FrameOrigin, Outgoing, Topic};
use runtime::Now;
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample;
use zenoh::{Session, Wait as _};

use crate::clocks::Clocks;
use crate::frame::{self, Placed};
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
    /// Receives over `session` what `link` names, for the deployment of `process`.
    pub(crate) fn open(session: &Session, process: &Process, link: &Link, clocks: &Clocks) -> anyhow::Result<Self> {
        let topics = &link.receive;
        let counts = Arc::new(Mutex::new(Counts::default()));
        let overrun = Arc::new(AtomicU64::new(0));
        let (sender, receiver) = sync_channel(WAITING);
        let work = Work {
            root: process.bus.root().clone(),
            frame: process.config.frame,
            topics: topics.clone(),
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
    frame: SystemFrame,
    topics: Vec<RemoteTopic>,
    clocks: Clocks,
    counts: Arc<Mutex<Counts>>,
}

impl Work {
    fn run(self, receiver: &Receiver<Arrived>) -> anyhow::Result<()> {
        let bus: Bus<SharedMemory> = Bus::open(&self.root, "link-inbound")?;
        let inlets = self.topics.iter().map(|topic| inlet(&bus, self.frame, topic));
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

fn inlet<'a>(
    bus: &'a Bus<SharedMemory>,
    frame: SystemFrame,
    remote: &RemoteTopic,
) -> anyhow::Result<Box<dyn Inlet + 'a>> {
    let name = || remote.into.split('/').nth(1).unwrap_or_default();
    match remote.into.split('/').next() {
        Some("sensor") => Ok(Feed::open(bus, frame, messages::sensor_tracks(name()))),
        Some("wide-area") => Ok(Feed::open(bus, frame, messages::wide_area(name()))),
        _ => Err(anyhow!("{} is no topic that is fed from outside", remote.into)),
    }
}

struct Feed<'a, T: Payload> {
    bus: &'a Bus<SharedMemory>,
    topic: Topic<T>,
    frame: SystemFrame,
    /// Frame of what came last, and the change from there; `None` where it is this deployment's.
    change: (FrameOrigin, Option<FrameChange>),
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

impl<'a, T: Outgoing + Payload + Placed> Feed<'a, T> {
    fn open(bus: &'a Bus<SharedMemory>, frame: SystemFrame, topic: Topic<T>) -> Box<dyn Inlet + 'a> {
        Box::new(Self {
            bus,
            topic,
            frame,
            change: (FrameOrigin::default(), None),
            publisher: None,
            conflated: 0,
        })
    }

    /// The publisher that stands for the one of `header`, in the deployment whose number is `origin`.
    fn standing_for(&mut self, header: &BatchHeader, origin: u32, now: Now) -> anyhow::Result<&mut Open<T>> {
        if self
            .publisher
            .as_ref()
            .is_none_or(|open| open.incarnation != header.incarnation)
        {
            // The one before is gone first: a topic has room for one and its successor.
            self.publisher = None;
            let publisher = self.bus.publisher(&self.topic, now.mono_ns as u64)?;
            self.publisher = Some(Open {
                publisher: publisher.of_sensor(header.sensor_uid).of_origin(origin),
                incarnation: header.incarnation,
                next_sequence: header.first_sequence,
            });
        }
        self.publisher.as_mut().context("it was just opened")
    }
}

impl<T: Outgoing + Payload + Placed> Inlet for Feed<'_, T> {
    fn take(&mut self, message: &[u8], now: Now, offset_ns: Option<i64>, counts: &mut Counts) -> anyhow::Result<()> {
        let Some((head, slices)) = wire::read::<T>(message, self.topic.capacity.slice_len) else {
            counts.rejected += 1;
            return Ok(());
        };
        counts.conflated += head
            .conflated
            .saturating_sub(std::mem::replace(&mut self.conflated, head.conflated));
        if self.change.0 != head.frame {
            self.change = match frame::change(&head.frame, &self.frame) {
                Some(change) => (head.frame, change),
                None => {
                    counts.rejected += 1;
                    return Ok(());
                }
            };
        }
        let change = self.change.1;
        for (header, mut samples) in slices {
            let open = self.standing_for(&header, head.origin, now)?;
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
                if let Some(change) = &change {
                    sample.change_frame(change);
                }
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
