//! A simulated wide-area sensor with its way out: tables of counts in datagrams (FM-6), each with its header line, when they are
//! to arrive.

use formats::wide_area::{WideAreaReport, WideAreaWriter};
use frames::time::NS_PER_DAY;
use messages::{Counter, NS_PER_S};
use net::UdpSender;
use runtime::config::WideAreaSensor;
use runtime::{HealthEntry, Now, Process};
use scenario::{SimulatedWideAreaSensor, Truth, WideAreaSettings};

use crate::{DATAGRAM_OCTETS_MAX, Observer, sender_to};

/// Longest row: eleven numbers, each of at most 24 characters and a separator.
const ROW_OCTETS_MAX: usize = 11 * 25;

/// See the module's documentation.
#[derive(Debug)]
pub(crate) struct WideArea {
    simulated: SimulatedWideAreaSensor,
    sender: UdpSender,
    observed: Vec<WideAreaReport>,
    datagram: Vec<u8>,
    records: u64,
}

impl WideArea {
    pub(crate) fn new(process: &Process, sensor: &WideAreaSensor, settings: &WideAreaSettings) -> anyhow::Result<Self> {
        let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
        let mut simulated = SimulatedWideAreaSensor::new(settings, seed, sensor.number, start_utc_ns)?;
        simulated.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        Ok(Self {
            simulated,
            sender: sender_to(process, &sensor.adapter)?,
            observed: Vec::new(),
            datagram: Vec::with_capacity(DATAGRAM_OCTETS_MAX),
            records: 0,
        })
    }

    /// Sends the rows from `first` on that fit into a datagram; where the next ones begin.
    fn send_from(&mut self, first: usize, midnight_ns: i64) -> std::io::Result<usize> {
        self.datagram.clear();
        let mut table = WideAreaWriter::begin(&mut self.datagram, midnight_ns)?;
        let mut next = first;
        while next < self.observed.len() && table.get_ref().len() + ROW_OCTETS_MAX <= DATAGRAM_OCTETS_MAX {
            table.write(&self.observed[next])?;
            next += 1;
        }
        self.records += (next - first) as u64;
        // What could not be sent is counted by the sender.
        drop(self.sender.send(&self.datagram));
        Ok(next)
    }
}

impl Observer for WideArea {
    fn due_s(&self) -> f64 {
        self.simulated.next_delivery_s()
    }

    fn deliver(&mut self, truth: &Truth, now_utc_ns: i64) {
        self.observed.clear();
        self.simulated.observe(truth, &mut self.observed);
        let midnight_ns = now_utc_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
        let mut next = 0;
        while next < self.observed.len() {
            // Writing into memory does not fail.
            next = self.send_from(next, midnight_ns).unwrap_or(self.observed.len());
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
