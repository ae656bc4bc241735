//! A simulated direction finder with its way out: tables of bearings in datagrams (FM-7), each with its header line.

use formats::bearing::Bearing;
use formats::bearings_csv::BearingWriter;
use frames::time::NS_PER_DAY;
use messages::{Counter, NS_PER_S};
use net::UdpSender;
use runtime::config::Source;
use runtime::{HealthEntry, Now, Process};
use scenario::{DirectionFinderSettings, SimulatedDirectionFinder, Truth};

use crate::{DATAGRAM_OCTETS_MAX, Observer, sender_to};

/// Longest row: nine numbers, each of at most 24 characters and a separator.
const ROW_OCTETS_MAX: usize = 9 * 25;

/// See the module's documentation.
#[derive(Debug)]
pub(crate) struct DirectionFinder {
    simulated: SimulatedDirectionFinder,
    sender: UdpSender,
    heard: Vec<Bearing>,
    datagram: Vec<u8>,
    records: u64,
}

impl DirectionFinder {
    pub(crate) fn new(process: &Process, source: &Source, settings: &DirectionFinderSettings) -> anyhow::Result<Self> {
        let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
        let mut simulated = SimulatedDirectionFinder::new(settings, seed, source.number, start_utc_ns)?;
        simulated.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        Ok(Self {
            simulated,
            sender: sender_to(process, &source.adapter)?,
            heard: Vec::new(),
            datagram: Vec::with_capacity(DATAGRAM_OCTETS_MAX),
            records: 0,
        })
    }

    /// Sends the rows from `first` on that fit into a datagram; where the next ones begin.
    fn send_from(&mut self, first: usize, midnight_ns: i64) -> std::io::Result<usize> {
        self.datagram.clear();
        let mut table = BearingWriter::begin(&mut self.datagram, midnight_ns)?;
        let mut next = first;
        while next < self.heard.len() && table.get_ref().len() + ROW_OCTETS_MAX <= DATAGRAM_OCTETS_MAX {
            table.write(&self.heard[next])?;
            next += 1;
        }
        self.records += (next - first) as u64;
        // What could not be sent is counted by the sender.
        drop(self.sender.send(&self.datagram));
        Ok(next)
    }
}

impl Observer for DirectionFinder {
    fn due_s(&self) -> f64 {
        self.simulated.next_delivery_s()
    }

    fn deliver(&mut self, truth: &Truth, now_utc_ns: i64) {
        self.heard.clear();
        self.simulated.listen(truth, &mut self.heard);
        let midnight_ns = now_utc_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
        let mut next = 0;
        while next < self.heard.len() {
            // Writing into memory does not fail.
            next = self.send_from(next, midnight_ns).unwrap_or(self.heard.len());
        }
    }

    fn count(&self, entry: &mut HealthEntry) {
        let sent = self.sender.counters();
        for (counter, count) in [
            (Counter::RecordsSent, self.records),
            (Counter::DatagramsSent, sent.sent),
            (Counter::SendFailures, sent.failed),
        ] {
            entry.counters[counter as usize] += count;
        }
    }
}
