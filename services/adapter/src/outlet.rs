//! Publication of samples of a single kind.

use bus::{BusError, Mark, Payload, Publisher, SharedMemory};
use messages::{Outgoing, ProcessKind, StreamId, Topic};
use runtime::Process;
use runtime::flow::Flow;

/// Publisher of a topic that some sources have.
#[derive(Debug)]
pub(crate) struct TopicOutlet<T: Payload>(Option<Publisher<SharedMemory, T>>);

impl<T: Outgoing> TopicOutlet<T> {
    /// Opens `topic` if the source has this topic; `sensor_uid` is the identity of the source's sensor.
    pub(crate) fn open(
        process: &Process,
        topic: &Topic<T>,
        sensor_uid: u32,
        is_wanted: bool,
    ) -> Result<Self, BusError> {
        let publisher = || process.bus.publisher(topic, process.incarnation);
        let publisher = is_wanted.then(publisher).transpose()?;
        Ok(Self(publisher.map(|publisher| publisher.of_sensor(sensor_uid))))
    }

    /// Publishes the samples and empties the buffer.
    pub(crate) fn send(&mut self, mark: Mark, samples: &mut Vec<T>) -> Result<(), BusError> {
        if let Some(publisher) = self.0.as_mut().filter(|_| !samples.is_empty()) {
            publisher.send(mark, samples.len(), |index, sequence| {
                let mut sample = samples[index];
                sample.leave(sequence, mark.sent_ns);
                sample
            })?;
        }
        samples.clear();
        Ok(())
    }

    /// Sets the offset of the source's clock for all later slices, seconds; a known offset of 0 stays distinct from
    /// an unknown offset.
    pub(crate) fn set_clock_offset(&mut self, offset_s: f64) {
        if let Some(publisher) = &mut self.0 {
            // `as` saturates.
            let offset_ms = (1e3 * offset_s).round() as i32;
            publisher.set_clock_offset(if offset_ms == 0 { 1 } else { offset_ms });
        }
    }

    /// Returns the number of published samples.
    pub(crate) fn sent(&self) -> u64 {
        self.0.as_ref().map_or(0, |publisher| publisher.counts().samples)
    }
}

/// Publisher of a recording's topic, limited by the topic's consumers.
#[derive(Debug)]
pub(crate) struct PacedOutlet<T: Payload> {
    publisher: Publisher<SharedMemory, T>,
    flow: Flow<SharedMemory>,
}

impl<T: Outgoing> PacedOutlet<T> {
    pub(crate) fn open(
        process: &Process,
        topic: &Topic<T>,
        stream: StreamId,
        sensor_uid: Option<u32>,
        consumers: &[ProcessKind],
    ) -> anyhow::Result<Self> {
        let publisher = process.bus.publisher(topic, process.incarnation)?;
        let depth = topic.capacity.depth;
        Ok(Self {
            publisher: match sensor_uid {
                Some(uid) => publisher.of_sensor(uid),
                None => publisher,
            },
            flow: Flow::new(&process.bus, process.incarnation, stream, depth, consumers)?,
        })
    }

    /// Reads the consumers' progress.
    pub(crate) fn update(&mut self) -> anyhow::Result<()> {
        self.flow.update(self.publisher.counts().slices)
    }

    /// Whether every consumer has room for another slice.
    pub(crate) fn may_send(&self) -> bool {
        self.flow.may_send(self.publisher.counts().slices)
    }

    /// Publishes `count` samples with given numbers, received at `ingested_ns` (monotonic, nanoseconds): the time of
    /// receipt of a recorded sample is its due time.
    pub(crate) fn send(
        &mut self,
        mark: Mark,
        count: usize,
        ingested_ns: i64,
        mut next: impl FnMut() -> (u64, T),
    ) -> Result<(), BusError> {
        self.publisher.send(mark, count, |_, _| {
            let (sequence, mut sample) = next();
            sample.leave(sequence, mark.sent_ns);
            sample.came_in(ingested_ns);
            sample
        })
    }

    pub(crate) fn flow(&self) -> &Flow<SharedMemory> {
        &self.flow
    }

    pub(crate) fn slice_len(&self) -> usize {
        self.publisher.slice_len()
    }

    /// Returns the number of published samples.
    pub(crate) fn sent(&self) -> u64 {
        self.publisher.counts().samples
    }
}
