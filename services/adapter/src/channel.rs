//! One source's way from observations to its topic.

use bus::{Mark, Publisher, SharedMemory};
use formats::reports::{Converter, Observation};
use messages::{COUNTERS_MAX, Counter, SensorTrack};
use runtime::clock::mono_ns;
use runtime::config::Source;
use runtime::{HealthEntry, Process};

/// Reports that are gathered before they are published, at most: those of one batch of datagrams.
const GATHERED_MAX: usize = 4096;

/// Converts what is observed, gathers it, and publishes it in slices, in the order in which it came.
#[derive(Debug)]
pub(crate) struct Channel {
    source: u16,
    name: String,
    converter: Converter,
    publisher: Publisher<SharedMemory, SensorTrack>,
    gathered: Vec<SensorTrack>,
    newest_ns: i64,
}

impl Channel {
    pub(crate) fn open(process: &Process, source: &Source) -> anyhow::Result<Self> {
        let topic = messages::sensor_tracks(&source.name);
        Ok(Self {
            source: source.number,
            name: source.name.clone(),
            converter: Converter::new(source.model, process.first_day_ns()),
            publisher: process.bus.publisher(&topic, process.incarnation)?,
            gathered: Vec::with_capacity(GATHERED_MAX),
            newest_ns: i64::MIN,
        })
    }

    /// What follows was received at `received_ns` (UTC, nanoseconds).
    pub(crate) fn received(&mut self, received_ns: i64) {
        self.converter.received(received_ns);
    }

    /// Takes a target report that came in at `ingested_ns` (monotonic, nanoseconds).
    pub(crate) fn take(&mut self, observation: &Observation, ingested_ns: i64) -> anyhow::Result<()> {
        if let Some(report) = self.converter.convert(observation, ingested_ns) {
            if self.gathered.len() == GATHERED_MAX {
                self.publish()?;
            }
            self.newest_ns = self.newest_ns.max(report.time_of_measurement_ns);
            self.gathered.push(report);
        }
        Ok(())
    }

    /// Takes a record that speaks of the sensor.
    pub(crate) fn service(&mut self, time_of_day_ns: Option<i64>) {
        self.converter.service(time_of_day_ns);
        self.newest_ns = self.newest_ns.max(self.converter.running_ns().unwrap_or(i64::MIN));
    }

    /// Publishes what has been gathered.
    pub(crate) fn publish(&mut self) -> anyhow::Result<()> {
        if self.gathered.is_empty() {
            return Ok(());
        }
        let mark = Mark {
            progress_ns: self.newest_ns,
            sent_ns: mono_ns(),
            end: false,
        };
        let gathered = &self.gathered;
        self.publisher.send(mark, gathered.len(), |index, sequence| {
            let mut report = gathered[index];
            report.sequence = sequence;
            report.stages.published_ns = mark.sent_ns;
            report
        })?;
        self.gathered.clear();
        Ok(())
    }

    /// How the source is; `decoded` is what its decoder has counted, indexed by [`Counter`].
    pub(crate) fn health(&self, decoded: &[u64; COUNTERS_MAX]) -> HealthEntry {
        let mut entry = HealthEntry {
            source: self.source,
            progress_ns: self.newest_ns,
            counters: *self.converter.counters(),
            // Readers without the configuration, such as `koseki top`, know sources by their numbers only.
            note: self.name.clone(),
            ..HealthEntry::default()
        };
        for (counter, decoded) in entry.counters.iter_mut().zip(decoded) {
            *counter += decoded;
        }
        entry.set(Counter::Published, self.publisher.counts().samples);
        entry
    }
}
