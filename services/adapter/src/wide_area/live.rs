//! A wide-area sensor behind a receiver of datagrams.

use asterix::blocks;
use bus::{Mark, Publisher, SharedMemory};
use deployment::{Process, WideAreaInput, WideAreaSensor};
use messages::{Counter, StageTimes, WideArea};
use observations::Sampled;
use runtime::clock::mono_ns;
use runtime::{HealthEntry, Now};
use tracking::wide_area::WideAreaReport;

use super::rows::Rows;
use super::tracks::Tracks;
use crate::receiver::{Datagrams, Received};

/// Reader of the datagrams.
#[derive(Debug)]
enum Reader {
    /// Rows of counts.
    Rows(Rows),
    /// Another system's tracks.
    Tracks(Box<Tracks>),
}

/// Counts in datagrams.
#[derive(Debug)]
pub(super) struct Live {
    reader: Reader,
    sensor: u16,
    publisher: Publisher<SharedMemory, WideArea>,
    reports: Vec<WideAreaReport>,
    /// Arrival of the latest report.
    arrived_ns: i64,
}

impl Live {
    pub(super) fn new(process: &Process, sensor: &WideAreaSensor) -> anyhow::Result<Self> {
        let topic = messages::wide_area(&sensor.name);
        Ok(Self {
            reader: match &sensor.input {
                WideAreaInput::Tracks(tracks) => Reader::Tracks(Box::new(Tracks::new(tracks, process.first_day_ns()))),
                _ => Reader::Rows(Rows::default()),
            },
            sensor: sensor.number,
            publisher: process.bus.publisher(&topic, process.incarnation)?,
            reports: Vec::new(),
            arrived_ns: i64::MIN,
        })
    }
}

impl Datagrams for Live {
    fn take(&mut self, bytes: &[u8], received: Received) -> anyhow::Result<()> {
        match &mut self.reader {
            Reader::Rows(rows) => rows.take(bytes, received.utc_ns, &mut self.reports),
            Reader::Tracks(tracks) => {
                tracks.take(blocks(bytes), bytes.len(), Some(received.utc_ns), &mut self.reports);
            }
        }
        Ok(())
    }

    fn publish(&mut self, count: usize, now: Now) -> anyhow::Result<()> {
        if let (0, Reader::Tracks(tracks)) = (count, &mut self.reader) {
            tracks.silent(now.utc_ns, &mut self.reports);
        }
        let Some(latest_ns) = self.reports.iter().map(|report| report.arrival_ns).max() else {
            return Ok(());
        };
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: mono_ns(),
            end: false,
        };
        let (sensor, reports) = (self.sensor, &self.reports);
        self.publisher.send(mark, reports.len(), |index, sequence| {
            let report = &reports[index];
            let stages = StageTimes {
                // Reports with a later stated arrival count as arrived by now.
                ingested_ns: (report.arrival_ns - now.utc_ns)
                    .saturating_add(now.mono_ns)
                    .min(mark.sent_ns),
                published_ns: mark.sent_ns,
                ..StageTimes::default()
            };
            WideArea {
                sequence,
                ..report.sample(sensor, stages)
            }
        })?;
        self.arrived_ns = self.arrived_ns.max(latest_ns);
        self.reports.clear();
        Ok(())
    }

    fn health(&self, whole: &mut HealthEntry, _sources: &mut Vec<HealthEntry>) {
        match &self.reader {
            Reader::Rows(rows) => rows.count(&mut whole.counters),
            Reader::Tracks(tracks) => tracks.count(&mut whole.counters),
        }
        whole.progress_ns = self.arrived_ns;
        whole.set(Counter::Published, self.publisher.counts().samples);
    }
}
