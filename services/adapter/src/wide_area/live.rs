//! A wide-area sensor behind a receiver of datagrams.

use asterix::blocks;
use bus::{Mark, Publisher, SharedMemory};
use deployment::{WideAreaInput, WideAreaSensor};
use messages::{Counter, StageTimes, WideArea};
use observations::Sampled;
use runtime::Process;
use runtime::clock::mono_ns;
use runtime::{HealthEntry, Now};
use sources::Readings;
use tracking::wide_area::WideAreaReport;

use super::rows::CountRows;
use super::tracks::OtherSystemTracks;
use crate::receiver::{DatagramReader, ReceiptTime};

/// Reader of the datagrams.
#[derive(Debug)]
enum CountReader {
    /// Rows of counts.
    Rows(CountRows),
    /// Another system's tracks.
    Tracks(Box<OtherSystemTracks>),
}

/// Counts in datagrams.
#[derive(Debug)]
pub(super) struct LiveCounts {
    reader: CountReader,
    sensor: u16,
    publisher: Publisher<SharedMemory, WideArea>,
    reports: Vec<WideAreaReport>,
    /// Arrival of the latest report.
    arrived_ns: i64,
}

impl LiveCounts {
    pub(super) fn new(process: &Process, sensor: &WideAreaSensor, readings: &Readings) -> anyhow::Result<Self> {
        let topic = messages::wide_area(&sensor.name);
        Ok(Self {
            reader: match &sensor.input {
                WideAreaInput::Tracks(tracks) => {
                    let model = super::model(sensor, readings)?;
                    CountReader::Tracks(Box::new(OtherSystemTracks::new(tracks, model, process.first_day_ns())))
                }
                _ => CountReader::Rows(CountRows::default()),
            },
            sensor: sensor.number,
            publisher: process.bus.publisher(&topic, process.incarnation)?,
            reports: Vec::new(),
            arrived_ns: i64::MIN,
        })
    }
}

impl DatagramReader for LiveCounts {
    fn take(&mut self, bytes: &[u8], received: ReceiptTime) -> anyhow::Result<()> {
        match &mut self.reader {
            CountReader::Rows(rows) => rows.take(bytes, received, &mut self.reports),
            CountReader::Tracks(tracks) => {
                tracks.take(blocks(bytes), bytes.len(), Some(received.utc_ns), &mut self.reports);
            }
        }
        Ok(())
    }

    fn publish(&mut self, count: usize, now: Now) -> anyhow::Result<()> {
        if let (0, CountReader::Tracks(tracks)) = (count, &mut self.reader) {
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
            CountReader::Rows(rows) => rows.count(whole),
            CountReader::Tracks(tracks) => tracks.count(&mut whole.counters),
        }
        whole.progress_ns = self.arrived_ns;
        whole.set(Counter::Published, self.publisher.counts().samples);
    }
}
