//! The sources' topics, as fusion reads them.

use bus::{Bus, Subscriber, Transport, Waiter};
use messages::{BatchHeader, COUNTERS_MAX, Counter, SensorTrack};
use runtime::config::Config;

/// One source's topic.
#[derive(Debug)]
pub(crate) struct Input<S: Transport> {
    pub(crate) source: u16,
    subscriber: Subscriber<S, SensorTrack>,
    /// Most samples in one slice of the topic.
    pub(crate) slice_len: usize,
    /// Latest progress mark, UTC, nanoseconds.
    pub(crate) progress_ns: i64,
}

impl<S: Transport> Input<S> {
    /// Opens the topics of all sources, in the order of their numbers, and has `waiter` watch them.
    pub(crate) fn open_all(
        config: &Config,
        bus: &Bus<S>,
        incarnation: u64,
        waiter: &mut Waiter<S>,
    ) -> anyhow::Result<Vec<Self>> {
        let mut inputs = Vec::new();
        for source in &config.sources {
            let topic = messages::sensor_tracks(&source.name);
            waiter.watch(bus, &topic)?;
            let subscriber = bus.subscriber(&topic, || incarnation)?;
            inputs.push(Self {
                source: source.number,
                subscriber,
                slice_len: topic.capacity.slice_len,
                progress_ns: i64::MIN,
            });
        }
        Ok(inputs)
    }

    /// Takes one slice, if there is one. Each report is stamped with the time by `clock` and its source, and handed to
    /// `visit` before the header is.
    pub(crate) fn take_slice(
        &mut self,
        clock: fn() -> i64,
        mut visit: impl FnMut(&SensorTrack),
        mut header: impl FnMut(&BatchHeader, &[SensorTrack]),
    ) -> anyhow::Result<bool> {
        let (source, progress_ns) = (self.source, &mut self.progress_ns);
        let taken = self.subscriber.take(1, |batch, reports| {
            // Read here, not before the take: between the two the slice may have been published.
            let taken_ns = clock();
            for report in reports {
                let mut report = *report;
                report.stages.taken_ns = taken_ns;
                // A topic is its source: what a report says of its source is not believed.
                report.source = source;
                visit(&report);
            }
            *progress_ns = (*progress_ns).max(batch.progress_ns);
            header(batch, reports);
        })?;
        Ok(taken > 0)
    }

    pub(crate) fn has_slices(&self) -> bool {
        self.subscriber.has_slices()
    }

    /// Adds what the topic's reader has counted.
    pub(crate) fn count(&self, counters: &mut [u64; COUNTERS_MAX]) {
        let counts = self.subscriber.counts();
        counters[Counter::Taken as usize] += counts.taken;
        counters[Counter::Lost as usize] += counts.lost;
        counters[Counter::SchemaMismatch as usize] += counts.schema_mismatch;
    }
}
