//! Simulated sensor that sends ASTERIX datagrams.

use deployment::Source;
use messages::{Counter, NS_PER_S};
use net::UdpSender;
use runtime::Process;
use runtime::{HealthEntry, Now};
use scenario::{SensorSettings, Truth};

use crate::{SensorFeed, WorldObserver, sender_to};

/// Simulated sensor, see the module's documentation.
#[derive(Debug)]
pub(crate) struct AsterixSensor {
    feed: SensorFeed,
    sender: UdpSender,
}

impl AsterixSensor {
    pub(crate) fn new(process: &Process, source: &Source, settings: &SensorSettings) -> anyhow::Result<Self> {
        let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
        let mut feed = SensorFeed::new((source, process.config.frame), settings, seed, start_utc_ns)?;
        feed.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        Ok(Self {
            feed,
            sender: sender_to(process, &source.adapter)?,
        })
    }
}

impl WorldObserver for AsterixSensor {
    fn due_s(&self) -> f64 {
        self.feed.due_s()
    }

    fn deliver(&mut self, truth: &Truth, now_utc_ns: i64) {
        let sender = &mut self.sender;
        // The sender counts failures; a sensor does not stop without a receiver.
        self.feed
            .deliver(truth, now_utc_ns, &mut |datagram| drop(sender.send(datagram)));
    }

    fn count(&self, entry: &mut HealthEntry) {
        let (reports, sent) = (self.feed.reports.counts(), self.sender.counters());
        for (counter, count) in [
            (Counter::RecordsSent, reports.records),
            (Counter::TracksDropped, reports.refused()),
            (Counter::DatagramsSent, sent.sent),
            (Counter::SendFailures, sent.failed),
        ] {
            entry.counters[counter] += count;
        }
    }
}
