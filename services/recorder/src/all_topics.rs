//! Recording of all topics, independent of their sample types.

use std::fmt::Debug;

use bus::{Bus, LogReader, Payload, PublisherLine, Subscriber, Transport, Waiter};
use configuration::{Config, Segments as Settings};
use messages::layout::Layout;
use messages::{BatchHeader, Stream, Streamed, Topic};
use recording::Facts;
use runtime::Now;

use crate::images::Images;
use crate::recorded::{ForSamples, Recorded, for_samples};
use crate::segments::{SegmentCounts, Segments};
use crate::start::Start;

/// Slices taken from one topic before the next one's turn.
const SLICES_PER_TOPIC: usize = 64;

/// Recorder of all topics of a deployment.
#[derive(Debug)]
pub(crate) struct AllTopics<S: Transport> {
    topics: Vec<Box<dyn Taken<S>>>,
    /// Lines left by publishers before their topics were opened, with the topics' places.
    lines: Vec<(usize, PublisherLine)>,
    /// Start time, monotonic, nanoseconds; earlier slices arrive within a short time after it.
    since_ns: i64,
    segments: Segments,
    images: Images<S>,
}

/// Callback for each slice of the stream at a place of [`Config::streams`], with the number of the next sample.
pub(crate) type Done<'d> = dyn FnMut(usize, &BatchHeader, u64) + 'd;

/// Time after which all slices waiting at the start are taken, nanoseconds.
const CATCH_UP_NS: i64 = 500_000_000;

/// Topic of any sample type.
trait Taken<S: Transport>: Debug {
    /// Passes the arrived slices to the file; returns whether there were any.
    fn take(&mut self, place: usize, segments: &mut Segments, now: Now, done: &mut Done<'_>) -> anyhow::Result<bool>;

    /// Whether slices have arrived.
    fn has_slices(&self) -> bool;

    /// Returns the number of samples taken; a log does not count them.
    fn taken(&self) -> u64 {
        0
    }
}

/// Topic of a stream.
#[derive(Debug)]
struct OfStream<S: Transport, T: Payload>(Subscriber<S, T>);

impl<S: Transport, T: Payload + Streamed> Taken<S> for OfStream<S, T> {
    fn take(&mut self, place: usize, segments: &mut Segments, now: Now, done: &mut Done<'_>) -> anyhow::Result<bool> {
        let taken = self.0.take(SLICES_PER_TOPIC, |header, samples| {
            segments.slice(place, header, T::octets(samples), now);
            done(place, header, samples.last().map_or(0, |sample| sample.sequence() + 1));
        })?;
        Ok(taken > 0)
    }

    fn has_slices(&self) -> bool {
        self.0.has_slices()
    }

    fn taken(&self) -> u64 {
        self.0.counts().taken
    }
}

impl<S: Transport, T: Payload> Taken<S> for Subscriber<S, T> {
    fn take(&mut self, place: usize, segments: &mut Segments, now: Now, _: &mut Done<'_>) -> anyhow::Result<bool> {
        let taken = Self::take(self, SLICES_PER_TOPIC, |header, samples| {
            segments.slice(place, header, T::octets(samples), now);
        })?;
        Ok(taken > 0)
    }

    fn has_slices(&self) -> bool {
        Self::has_slices(self)
    }
}

impl<S: Transport, T: Payload> Taken<S> for LogReader<T> {
    fn take(&mut self, place: usize, segments: &mut Segments, now: Now, _: &mut Done<'_>) -> anyhow::Result<bool> {
        let incarnation = self.created_ns();
        // After a restart, continues at the position of the previous recorder.
        self.go_on(segments.next_sequence(place, incarnation));
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
            segments.slice(place, &header, T::octets(samples), now);
            read = true;
        }
        Ok(read)
    }

    /// A log can wait: other topics wake the recorder.
    fn has_slices(&self) -> bool {
        false
    }
}

/// Collector of the topics' subscribers.
struct Opening<'a, S: Transport> {
    bus: &'a Bus<S>,
    incarnation: u64,
    /// Woken by the topics of data, unless other files of this process are.
    waiter: Option<&'a mut Waiter<S>>,
    topics: Vec<Box<dyn Taken<S>>>,
    names: Vec<(String, Layout)>,
    lines: Vec<(usize, PublisherLine)>,
}

impl<S: Transport> Opening<'_, S> {
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

    fn open_stream(&mut self, stream: Stream, name: &str) -> anyhow::Result<()> {
        for_samples(stream, Naming { opening: self, name })
    }
}

/// Task that opens the topic of a stream whose source or sensor is called `name`.
struct Naming<'o, 'a, 'n, S: Transport> {
    opening: &'o mut Opening<'a, S>,
    name: &'n str,
}

impl<S: Transport> ForSamples for Naming<'_, '_, '_, S> {
    type Done = anyhow::Result<()>;

    fn of<T: Recorded>(self, _: &str) -> Self::Done {
        self.opening.open_of::<T>(self.name)
    }
}

impl<S: Transport> AllTopics<S> {
    /// Creates the recording of the run `start` of `config`, by the recorder that started at `incarnation`. Topics
    /// of data wake `waiter`, if given.
    ///
    /// # Errors
    /// If a topic cannot be opened, or the remains of an earlier recorder cannot be read.
    pub(crate) fn new(
        config: &Config,
        settings: Settings,
        bus: &Bus<S>,
        waiter: Option<&mut Waiter<S>>,
        incarnation: u64,
        start: &Start<'_>,
    ) -> anyhow::Result<Self> {
        let mut opening = Opening {
            bus,
            incarnation,
            waiter,
            topics: Vec::new(),
            names: Vec::new(),
            lines: Vec::new(),
        };
        for (id, name) in config.streams() {
            opening.open_stream(id.stream, name)?;
        }
        if config.fusion.settings.exchange {
            opening.open(&messages::own_tracks())?;
        }
        // Messages between processes can wait for the next poll.
        opening.waiter = None;
        opening.open(&messages::health())?;
        opening.open(&messages::orders())?;
        opening.open(&messages::progress())?;
        opening.open(&messages::frame_origin())?;
        opening.open(&messages::restored())?;
        // Last, so that the event log contains every system track taken in the same turn.
        opening.open_log(&messages::event_log())?;
        let facts = Facts::from([
            ("run".to_owned(), start.run.trim().to_owned()),
            ("version".to_owned(), start.version.to_owned()),
            ("first_day_ns".to_owned(), start.first_day_ns.to_string()),
            ("configuration".to_owned(), config.text_without_secrets()),
        ]);
        // Slices sent before all topics were open do not count as lost.
        let since_ns = Now::read().mono_ns;
        let is_report = |place: usize| {
            let stream = config.streams().nth(place).map(|(id, _)| id.stream);
            stream == Some(Stream::SensorTracks)
        };
        let is_late = opening
            .lines
            .iter()
            .any(|(place, line)| is_report(*place) && line.next_sequence > 0);
        Ok(Self {
            topics: opening.topics,
            lines: opening.lines,
            since_ns,
            images: Images::new(bus, &settings, incarnation, since_ns + CATCH_UP_NS, is_late)?,
            segments: Segments::new(start.folder, settings, facts, opening.names, since_ns as u64)?,
        })
    }

    /// Passes the arrived slices to the file, and performs periodic work; returns whether there were any slices.
    pub(crate) fn turn(&mut self, now: Now, done: &mut Done<'_>) -> anyhow::Result<bool> {
        let mut worked = false;
        for (place, topic) in self.topics.iter_mut().enumerate() {
            worked |= topic.take(place, &mut self.segments, now, done)?;
        }
        if now.mono_ns > self.since_ns + CATCH_UP_NS {
            // Counts samples lost with an earlier recorder, of publishers silent since.
            for (place, line) in self.lines.drain(..) {
                self.segments.catch_up(place, line.incarnation, line.next_sequence);
            }
        }
        self.segments.tend(now);
        self.images.tend(self.segments.counts().lost, now)?;
        Ok(worked)
    }

    pub(crate) fn has_slices(&self) -> bool {
        self.topics.iter().any(|topic| topic.has_slices())
    }

    /// Returns the number of samples taken of the stream at this place of [`Config::streams`].
    pub(crate) fn taken(&self, stream: usize) -> u64 {
        self.topics[stream].taken()
    }

    pub(crate) fn counts(&self) -> SegmentCounts {
        self.segments.counts()
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If the file, or anything before, could not be written.
    pub(crate) fn close(&mut self, now: Now) -> anyhow::Result<()> {
        self.segments.finish(now);
        let SegmentCounts { lost, failures, .. } = self.counts();
        anyhow::ensure!(
            failures == 0,
            "the recording of all topics could not be written {failures} times; it lacks {lost} samples"
        );
        Ok(())
    }
}
