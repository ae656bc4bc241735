//! Receive path of the recorder: one subscriber for each topic, whatever the sample type.

use std::fmt::Debug;

use bus::{Bus, LogReader, Payload, PublisherLine, Subscriber, SubscriberCounts, Transport, Waiter};
use deployment::{Deployment, SystemTracks};
use messages::layout::Layout;
use messages::{BatchHeader, Stream, Streamed, Topic};
use runtime::Now;

use crate::journal::Journal;
use crate::recorded::{ForSamples, RecordedSample, for_samples};
use crate::repeats::{Repeated, Repeats};

/// Slices taken from one topic before the next one's turn.
const SLICES_PER_TOPIC: usize = 64;

/// Subscribers of the recorded topics.
#[derive(Debug)]
pub(crate) struct TopicIntake<S: Transport> {
    /// Data streams in the order of [`Deployment::streams`], then the other topics.
    topics: Vec<Box<dyn Arriving<S>>>,
    /// Lines left by publishers before their topics were opened, with the topics' places.
    lines: Vec<(usize, PublisherLine)>,
    /// Start time, monotonic, nanoseconds; earlier slices arrive within a short time after it.
    since_ns: i64,
}

/// Callback for each slice of a data stream, with its place in [`Deployment::streams`] and the number of the next
/// sample.
pub(crate) type Done<'d> = dyn FnMut(usize, &BatchHeader, u64) + 'd;

/// Time after which all slices waiting at the start are taken, nanoseconds.
const CATCH_UP_NS: i64 = 500_000_000;

/// Topic of any sample type.
trait Arriving<S: Transport>: Debug {
    /// Adds the arrived slices to the journal; returns whether there were any.
    fn take(&mut self, place: usize, journal: &mut Journal, now: Now, done: &mut Done<'_>) -> anyhow::Result<bool>;

    /// Whether slices have arrived.
    fn has_slices(&self) -> bool;

    /// Returns the counts of the subscriber; a log has none.
    fn counts(&self) -> SubscriberCounts;
}

/// Topic of a data stream.
#[derive(Debug)]
struct OfStream<S: Transport, T: Payload>(Subscriber<S, T>);

impl<S: Transport, T: Payload + Streamed> Arriving<S> for OfStream<S, T> {
    fn take(&mut self, place: usize, journal: &mut Journal, now: Now, done: &mut Done<'_>) -> anyhow::Result<bool> {
        let taken = self.0.take(SLICES_PER_TOPIC, |header, samples| {
            journal.add_numbered(place, header, samples, now);
            done(place, header, journal.account(place).next_sequence());
        })?;
        Ok(taken > 0)
    }

    fn has_slices(&self) -> bool {
        self.0.has_slices()
    }

    fn counts(&self) -> SubscriberCounts {
        self.0.counts()
    }
}

/// Topic whose publishers repeat their messages.
#[derive(Debug)]
struct OfRepeats<S: Transport, T: Payload>(Subscriber<S, T>, Repeats);

impl<S: Transport, T: Payload + Repeated> Arriving<S> for OfRepeats<S, T> {
    fn take(&mut self, place: usize, journal: &mut Journal, now: Now, _: &mut Done<'_>) -> anyhow::Result<bool> {
        let Self(subscriber, repeats) = self;
        let taken = subscriber.take(SLICES_PER_TOPIC, |header, samples| {
            if !repeats.has(header, samples, now.mono_ns) {
                journal.add(place, header, samples, now);
            }
        })?;
        Ok(taken > 0)
    }

    fn has_slices(&self) -> bool {
        self.0.has_slices()
    }

    fn counts(&self) -> SubscriberCounts {
        self.0.counts()
    }
}

impl<S: Transport, T: Payload> Arriving<S> for Subscriber<S, T> {
    fn take(&mut self, place: usize, journal: &mut Journal, now: Now, _: &mut Done<'_>) -> anyhow::Result<bool> {
        let taken = Self::take(self, SLICES_PER_TOPIC, |header, samples| {
            journal.add(place, header, samples, now);
        })?;
        Ok(taken > 0)
    }

    fn has_slices(&self) -> bool {
        Self::has_slices(self)
    }

    fn counts(&self) -> SubscriberCounts {
        Self::counts(self)
    }
}

impl<S: Transport, T: Payload> Arriving<S> for LogReader<T> {
    fn take(&mut self, place: usize, journal: &mut Journal, now: Now, _: &mut Done<'_>) -> anyhow::Result<bool> {
        let incarnation = self.created_ns();
        // After a restart, continues at the position of the previous recorder.
        self.go_on(journal.account(place).next_of(incarnation));
        let mut read = false;
        for _ in 0..SLICES_PER_TOPIC {
            let Some((first_sequence, samples)) = self.read() else {
                break;
            };
            let header = BatchHeader {
                schema: T::SCHEMA,
                incarnation,
                first_sequence,
                progress_ns: i64::MIN,
                sent_ns: now.mono_ns,
                ..BatchHeader::default()
            };
            journal.add(place, &header, samples, now);
            read = true;
        }
        Ok(read)
    }

    /// A log can wait: other topics wake the recorder.
    fn has_slices(&self) -> bool {
        false
    }

    fn counts(&self) -> SubscriberCounts {
        SubscriberCounts {
            schema_mismatch: self.refused(),
            ..SubscriberCounts::default()
        }
    }
}

/// Collector of the topics' subscribers.
struct IntakeBuilder<'a, S: Transport> {
    bus: &'a Bus<S>,
    incarnation: u64,
    /// Woken by the topics of data.
    waiter: Option<&'a mut Waiter<S>>,
    topics: Vec<Box<dyn Arriving<S>>>,
    names: Vec<(String, Layout)>,
    lines: Vec<(usize, PublisherLine)>,
}

impl<S: Transport> IntakeBuilder<'_, S> {
    fn subscribe<T: Payload>(&mut self, topic: &Topic<T>) -> anyhow::Result<Subscriber<S, T>> {
        if let Some(waiter) = &mut self.waiter {
            waiter.watch(self.bus, topic)?;
        }
        // Read before subscribing: later slices arrive, or leave a gap.
        let place = self.topics.len();
        let lines = self.bus.publisher_lines(topic)?;
        self.lines.extend(lines.into_iter().map(|line| (place, line)));
        self.names.push((topic.name.as_str().to_owned(), T::LAYOUT));
        Ok(self.bus.subscriber(topic, || self.incarnation)?.of_all_epochs())
    }

    fn open<T: Payload>(&mut self, topic: &Topic<T>) -> anyhow::Result<()> {
        let subscriber = self.subscribe(topic)?;
        self.topics.push(Box::new(subscriber));
        Ok(())
    }

    fn open_repeated<T: Payload + Repeated>(&mut self, topic: &Topic<T>) -> anyhow::Result<()> {
        let subscriber = self.subscribe(topic)?;
        self.topics.push(Box::new(OfRepeats(subscriber, Repeats::default())));
        Ok(())
    }

    fn open_of<T: Payload + Streamed>(&mut self, name: &str) -> anyhow::Result<()> {
        let subscriber = self.subscribe(&T::topic(name))?;
        self.topics.push(Box::new(OfStream(subscriber)));
        Ok(())
    }

    fn open_log<T: Payload>(&mut self, topic: &Topic<T>) -> anyhow::Result<()> {
        self.topics.push(Box::new(self.bus.log_reader(topic)?));
        self.names.push((topic.name.as_str().to_owned(), T::LAYOUT));
        Ok(())
    }

    /// Opens the topics of messages between processes, and the event log; first the further track pictures.
    fn open_others(&mut self, tracks: &SystemTracks) -> anyhow::Result<()> {
        if tracks.exchange {
            self.open(&messages::own_tracks())?;
        }
        if tracks.smooths {
            self.open(&messages::smoothed_tracks())?;
        }
        // Messages between processes can wait for the next poll.
        self.waiter = None;
        self.open_repeated(&messages::health())?;
        self.open(&messages::orders())?;
        self.open(&messages::progress())?;
        self.open_repeated(&messages::frame_origin())?;
        self.open(&messages::restored())?;
        // Last, so that the event log contains every system track taken in the same turn.
        self.open_log(&messages::event_log())
    }

    fn open_stream(&mut self, stream: Stream, name: &str) -> anyhow::Result<()> {
        for_samples(stream, Naming { opening: self, name })
    }
}

/// Task that opens the topic of a stream whose source or sensor is called `name`.
struct Naming<'o, 'a, 'n, S: Transport> {
    opening: &'o mut IntakeBuilder<'a, S>,
    name: &'n str,
}

impl<S: Transport> ForSamples for Naming<'_, '_, '_, S> {
    type Done = anyhow::Result<()>;

    fn of<T: RecordedSample>(self, _: &str) -> Self::Done {
        self.opening.open_of::<T>(self.name)
    }
}

impl<S: Transport> TopicIntake<S> {
    /// Opens the data streams of `config`, and if it `has_all` topics to record all others, for the recorder that
    /// started at `incarnation`. Topics of data wake `waiter`. Returns the names and layouts of the topics in their
    /// order, too.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(crate) fn open(
        (config, has_all): (&Deployment, bool),
        bus: &Bus<S>,
        waiter: &mut Waiter<S>,
        incarnation: u64,
    ) -> anyhow::Result<(Self, Vec<(String, Layout)>)> {
        let mut opening = IntakeBuilder {
            bus,
            incarnation,
            waiter: Some(waiter),
            topics: Vec::new(),
            names: Vec::new(),
            lines: Vec::new(),
        };
        for (id, name) in config.recorded_streams() {
            opening.open_stream(id.stream, name)?;
        }
        if has_all {
            opening.open_others(&config.system_tracks)?;
        }
        let intake = Self {
            topics: opening.topics,
            lines: opening.lines,
            // Slices sent before all topics were open do not count as lost.
            since_ns: Now::read().mono_ns,
        };
        Ok((intake, opening.names))
    }

    /// Returns the start of the recording, monotonic, nanoseconds.
    pub(crate) fn since_ns(&self) -> i64 {
        self.since_ns
    }

    /// Returns the time at which all slices sent before the start have been taken, monotonic, nanoseconds.
    pub(crate) fn caught_up_ns(&self) -> i64 {
        self.since_ns + CATCH_UP_NS
    }

    /// Whether publishers of sensor tracks had sent samples before the start.
    pub(crate) fn is_late(&self, config: &Deployment) -> bool {
        let is_report = |place: usize| {
            let stream = config.recorded_streams().nth(place).map(|(id, _)| id.stream);
            stream == Some(Stream::SensorTracks)
        };
        let has_sent = |(place, line): &(usize, PublisherLine)| is_report(*place) && line.next_sequence > 0;
        self.lines.iter().any(has_sent)
    }

    /// Adds the arrived slices to the journal; returns whether there were any. Calls `done` with each slice of a data
    /// stream.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(crate) fn take(&mut self, journal: &mut Journal, now: Now, done: &mut Done<'_>) -> anyhow::Result<bool> {
        let mut worked = false;
        for (place, topic) in self.topics.iter_mut().enumerate() {
            worked |= topic.take(place, journal, now, done)?;
        }
        if now.mono_ns > self.caught_up_ns() {
            // Counts samples lost with an earlier recorder, of publishers silent since.
            for (place, line) in self.lines.drain(..) {
                journal.catch_up(place, line.incarnation, line.next_sequence);
            }
        }
        Ok(worked)
    }

    /// Whether slices have arrived.
    pub(crate) fn has_slices(&self) -> bool {
        self.topics.iter().any(|topic| topic.has_slices())
    }

    /// Returns the counts of the subscriber at this place.
    pub(crate) fn counts(&self, place: usize) -> SubscriberCounts {
        self.topics[place].counts()
    }
}
