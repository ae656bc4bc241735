//! Simulated direction finder: sends tables of bearings in datagrams (FM-7), each with a header line, or the snapshots
//! of its antenna array (EL-1).

use deployment::Source;
use formats::bearings_csv::BearingWriter;
use formats::snapshot_datagram::each_datagram;
use frames::time::NS_PER_DAY;
use messages::NS_PER_S;
use net::UdpSender;
use observations::{Bearing, SnapshotBlock};
use runtime::Process;
use runtime::{HealthEntry, Now};
use scenario::{ArrayGeometry, DirectionFinderSettings, SimulatedDirectionFinder, Truth};

use crate::rows::{RowSender, count_sent};
use crate::{DATAGRAM_OCTETS_MAX, WorldObserver, sender_to};

/// The finder of a simulated source, at the time of a process's start.
fn present(
    process: &Process,
    source: &Source,
    settings: &DirectionFinderSettings,
) -> anyhow::Result<SimulatedDirectionFinder> {
    let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
    let mut simulated = SimulatedDirectionFinder::new(settings, seed, source.number, start_utc_ns)?;
    simulated.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
    Ok(simulated)
}

/// Simulated direction finder that delivers bearings, see the module's documentation.
#[derive(Debug)]
pub(crate) struct DirectionFinder {
    simulated: SimulatedDirectionFinder,
    heard: Vec<Bearing>,
    sender: RowSender,
}

impl DirectionFinder {
    pub(crate) fn new(process: &Process, source: &Source, settings: &DirectionFinderSettings) -> anyhow::Result<Self> {
        Ok(Self {
            simulated: present(process, source, settings)?,
            heard: Vec::new(),
            sender: RowSender::new(process, &source.adapter)?,
        })
    }
}

impl WorldObserver for DirectionFinder {
    fn due_s(&self) -> f64 {
        self.simulated.next_delivery_s()
    }

    fn deliver(&mut self, truth: &Truth, now_utc_ns: i64) {
        self.heard.clear();
        self.simulated.listen(truth, &mut self.heard);
        let midnight_ns = now_utc_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
        self.sender.send(&self.heard, |datagram, rows| {
            let mut table = BearingWriter::begin(datagram, midnight_ns)?;
            rows.iter().try_for_each(|row| table.write(row))
        });
    }

    fn count(&self, entry: &mut HealthEntry) {
        self.sender.count(entry);
    }
}

/// Simulated direction finder that delivers the snapshots of its antenna array.
#[derive(Debug)]
pub(crate) struct ArrayFinder {
    simulated: SimulatedDirectionFinder,
    array: ArrayGeometry,
    measured: Vec<SnapshotBlock>,
    sender: UdpSender,
    measurements: u64,
}

impl ArrayFinder {
    pub(crate) fn new(
        process: &Process,
        source: &Source,
        settings: &DirectionFinderSettings,
        array: &ArrayGeometry,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            simulated: present(process, source, settings)?,
            array: array.clone(),
            measured: Vec::new(),
            sender: sender_to(process, &source.adapter)?,
            measurements: 0,
        })
    }
}

impl WorldObserver for ArrayFinder {
    fn due_s(&self) -> f64 {
        self.simulated.next_delivery_s()
    }

    fn deliver(&mut self, truth: &Truth, _now_utc_ns: i64) {
        self.measured.clear();
        self.simulated.take_snapshots(&self.array, truth, &mut self.measured);
        for measurement in &self.measured {
            each_datagram(measurement, DATAGRAM_OCTETS_MAX, |octets| {
                // The sender counts failures.
                drop(self.sender.send(octets));
            });
        }
        self.measurements += self.measured.len() as u64;
    }

    fn count(&self, entry: &mut HealthEntry) {
        count_sent(self.measurements, &self.sender, entry);
    }
}
