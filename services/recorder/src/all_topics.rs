//! The recording of all topics, whatever their samples are.

use std::fmt::Debug;

use bus::{Bus, LogReader, Payload, Subscriber, Transport, Waiter};
use configuration::{Config, Segments as Settings};
use messages::layout::Layout;
use messages::{BatchHeader, Stream, Streamed as _, Topic};
use recording::Facts;
use runtime::Now;

use crate::agent::Start;
use crate::segments::{SegmentCounts, Segments};

/// Slices taken from one topic before the next one's turn.
const SLICES_PER_TOPIC: usize = 64;

/// Records all topics of a deployment.
#[derive(Debug)]
pub(crate) struct AllTopics<S: Transport> {
    topics: Vec<Box<dyn Taken<S>>>,
    segments: Segments,
}

/// A topic of whatever samples.
trait Taken<S: Transport>: Debug {
    /// Hands what has arrived to the file; whether there was anything.
    fn take(&mut self, place: usize, segments: &mut Segments, now: Now) -> anyhow::Result<bool>;

    /// Whether something has arrived.
    fn has_slices(&self) -> bool;
}

impl<S: Transport, T: Payload> Taken<S> for Subscriber<S, T> {
    fn take(&mut self, place: usize, segments: &mut Segments, now: Now) -> anyhow::Result<bool> {
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
    fn take(&mut self, place: usize, segments: &mut Segments, now: Now) -> anyhow::Result<bool> {
        let incarnation = self.created_ns();
        // After a restart from where the one before had come.
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

    /// A log can wait: what comes of it wakes the recorder.
    fn has_slices(&self) -> bool {
        false
    }
}

/// Collects subscribers of topics.
struct Opening<'a, S: Transport> {
    bus: &'a Bus<S>,
    incarnation: u64,
    /// Woken by the topics of data, unless somebody else of this process is.
    waiter: Option<&'a mut Waiter<S>>,
    topics: Vec<Box<dyn Taken<S>>>,
    names: Vec<(String, Layout)>,
}

impl<S: Transport> Opening<'_, S> {
    fn open<T: Payload>(&mut self, topic: &Topic<T>) -> anyhow::Result<()> {
        if let Some(waiter) = &mut self.waiter {
            waiter.watch(self.bus, topic)?;
        }
        self.topics
            .push(Box::new(self.bus.subscriber(topic, || self.incarnation)?));
        self.names.push((topic.name.as_str().to_owned(), T::LAYOUT));
        Ok(())
    }

    fn open_log<T: Payload>(&mut self, topic: &Topic<T>) -> anyhow::Result<()> {
        self.topics.push(Box::new(self.bus.log_reader(topic)?));
        self.names.push((topic.name.as_str().to_owned(), T::LAYOUT));
        Ok(())
    }

    fn open_stream(&mut self, stream: Stream, name: &str) -> anyhow::Result<()> {
        match stream {
            Stream::SensorTracks => self.open(&messages::SensorTrack::topic(name)),
            Stream::Detections => self.open(&messages::SensorDetection::topic(name)),
            Stream::Bearings => self.open(&messages::SensorBearing::topic(name)),
            Stream::PlatformStates => self.open(&messages::PlatformState::topic(name)),
            Stream::Cues => self.open(&messages::Cue::topic(name)),
            Stream::WideArea => self.open(&messages::WideArea::topic(name)),
            Stream::SystemTracks => self.open(&messages::SystemTrack::topic(name)),
            Stream::Alarms => self.open(&messages::Alarm::topic(name)),
            Stream::Decisions => self.open(&messages::Decision::topic(name)),
        }
    }
}

impl<S: Transport> AllTopics<S> {
    /// Recording of the `start` of `config`, by the recorder that started at `incarnation`. Topics of data wake
    /// `waiter`, if there is one.
    ///
    /// # Errors
    /// If a topic cannot be opened, or what an earlier recorder has left cannot be read.
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
        };
        for (id, name) in config.streams() {
            opening.open_stream(id.stream, name)?;
        }
        // Talk between processes can wait for the next look.
        opening.waiter = None;
        opening.open(&messages::health())?;
        opening.open(&messages::control())?;
        opening.open(&messages::progress())?;
        opening.open(&messages::frame_origin())?;
        opening.open(&messages::restored())?;
        // Last: of what was taken of the system tracks in a turn, the order of work is there.
        opening.open_log(&messages::order())?;
        let facts = Facts::from([
            ("run".to_owned(), start.run.trim().to_owned()),
            ("version".to_owned(), start.version.to_owned()),
            ("first_day_ns".to_owned(), start.first_day_ns.to_string()),
            ("configuration".to_owned(), config.text.clone()),
        ]);
        // What was said before all of them were open is no loss.
        let since_ns = Now::read().mono_ns as u64;
        Ok(Self {
            topics: opening.topics,
            segments: Segments::new(start.folder, settings, facts, opening.names, since_ns)?,
        })
    }

    /// Hands what has arrived to the file, and does what else is due; whether there was anything.
    pub(crate) fn turn(&mut self, now: Now) -> anyhow::Result<bool> {
        let mut worked = false;
        for (place, topic) in self.topics.iter_mut().enumerate() {
            worked |= topic.take(place, &mut self.segments, now)?;
        }
        self.segments.tend(now);
        Ok(worked)
    }

    pub(crate) fn has_slices(&self) -> bool {
        self.topics.iter().any(|topic| topic.has_slices())
    }

    pub(crate) fn counts(&self) -> SegmentCounts {
        self.segments.counts()
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If it, or anything before, could not be written.
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
