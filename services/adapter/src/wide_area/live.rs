//! A wide-area sensor on the network: one socket, and the sensor behind it.

use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use anyhow::Context as _;
use bus::{Mark, Publisher, SharedMemory};
use configuration::{Process, WideAreaSensor};
use messages::{Counter, Counters, StageTimes, WideArea};
use net::{ReceiverSettings, UdpReceiver};
use observations::Sampled;
use runtime::clock::mono_ns;
use runtime::{Agent, HealthEntry, Now, Turn};
use tracking::wide_area::WideAreaReport;

use super::rows::Rows;
use super::tracks::Tracks;

/// Longest wait for a datagram in one turn: health messages must be said, and a stop be heard.
const PATIENCE: Duration = Duration::from_millis(50);

/// What reads the datagrams.
#[derive(Debug)]
pub(super) enum Reader {
    /// Rows of counts.
    Rows(Rows),
    /// Another system's tracks.
    Tracks(Box<Tracks>),
}

/// The agent of a wide-area sensor behind a receiver.
#[derive(Debug)]
pub(super) struct Live {
    receiver: UdpReceiver,
    reader: Reader,
    sensor: u16,
    publisher: Publisher<SharedMemory, WideArea>,
    reports: Vec<WideAreaReport>,
    /// Arrival of the latest report.
    arrived_ns: i64,
}

impl Live {
    pub(super) fn new(
        process: &Process,
        settings: &ReceiverSettings,
        sensor: &WideAreaSensor,
        reader: Reader,
    ) -> anyhow::Result<Self> {
        let receiver = UdpReceiver::open(settings).with_context(|| {
            let address = SocketAddr::new(settings.address, settings.port);
            format!("receiving at {address}")
        })?;
        Ok(Self {
            receiver,
            reader,
            sensor: sensor.number,
            publisher: process
                .bus
                .publisher(&messages::wide_area(&sensor.name), process.incarnation)?,
            reports: Vec::new(),
            arrived_ns: i64::MIN,
        })
    }

    /// The receiver of a simulated sensor, at `port` of the deployment's own loopback address.
    pub(super) fn loopback(
        process: &Process,
        port: u16,
        sensor: &WideAreaSensor,
        reader: Reader,
    ) -> anyhow::Result<Self> {
        let address = IpAddr::V4(process.loopback);
        Self::new(process, &ReceiverSettings::new(address, port), sensor, reader)
    }

    fn publish(&mut self, now: Now) -> anyhow::Result<()> {
        if self.reports.is_empty() {
            return Ok(());
        }
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: mono_ns(),
            end: false,
        };
        let (sensor, reports) = (self.sensor, &self.reports);
        self.publisher.send(mark, reports.len(), |index, sequence| {
            let report = &reports[index];
            let stages = StageTimes {
                // What says that it arrives later has come in by now.
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
        let latest_ns = reports.iter().map(|report| report.arrival_ns).max();
        self.arrived_ns = self.arrived_ns.max(latest_ns.unwrap_or(i64::MIN));
        self.reports.clear();
        Ok(())
    }
}

impl Agent for Live {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let (reader, reports) = (&mut self.reader, &mut self.reports);
        let received = self.receiver.receive(PATIENCE, |datagram| {
            let received_ns = datagram.received_utc_ns;
            match reader {
                Reader::Rows(rows) => rows.take(datagram.bytes, received_ns, reports),
                Reader::Tracks(tracks) => tracks.take(datagram.bytes, Some(received_ns), reports),
            }
        })?;
        if let (0, Reader::Tracks(tracks)) = (received, reader) {
            tracks.silent(now.utc_ns, reports);
        }
        self.publish(now)?;
        Ok(Turn::Worked)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut counters = Counters::default();
        match &self.reader {
            Reader::Rows(rows) => rows.count(&mut counters),
            Reader::Tracks(tracks) => tracks.count(&mut counters),
        }
        let mut whole = HealthEntry {
            progress_ns: self.arrived_ns,
            note: self.receiver.warning().unwrap_or_default().to_owned(),
            counters,
            ..HealthEntry::default()
        };
        whole.set(Counter::Published, self.publisher.counts().samples);
        let counted = self.receiver.counters();
        whole.set(Counter::Datagrams, counted.datagrams);
        whole.set(Counter::DatagramsRejected, counted.refused_senders);
        whole.set(
            Counter::DatagramsRejectedLength,
            counted.empty + counted.oversized + counted.unstamped,
        );
        whole.set(Counter::DatagramsDropped, counted.kernel_drops);
        entries.push(whole);
    }
}
