//! Simulated wide-area sensor: sends tables of counts in datagrams (FM-6), each with a header line, at the time of
//! arrival.

use deployment::WideAreaSensor;
use formats::wide_area_csv::WideAreaWriter;
use frames::time::NS_PER_DAY;
use messages::NS_PER_S;
use observations::WideAreaReport;
use runtime::Process;
use runtime::{HealthEntry, Now};
use scenario::{SimulatedWideAreaSensor, Truth, WideAreaSettings};

use crate::WorldObserver;
use crate::rows::RowSender;

/// Simulated wide-area sensor, see the module's documentation.
#[derive(Debug)]
pub(crate) struct SimulatedWideArea {
    simulated: SimulatedWideAreaSensor,
    observed: Vec<WideAreaReport>,
    sender: RowSender,
}

impl SimulatedWideArea {
    pub(crate) fn new(process: &Process, sensor: &WideAreaSensor, settings: &WideAreaSettings) -> anyhow::Result<Self> {
        let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
        let mut simulated = SimulatedWideAreaSensor::new(settings, seed, sensor.number, start_utc_ns)?;
        simulated.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        Ok(Self {
            simulated,
            observed: Vec::new(),
            sender: RowSender::new(process, &sensor.adapter)?,
        })
    }
}

impl WorldObserver for SimulatedWideArea {
    fn due_s(&self) -> f64 {
        self.simulated.next_delivery_s()
    }

    fn deliver(&mut self, truth: &Truth, now_utc_ns: i64) {
        self.observed.clear();
        self.simulated.observe(truth, &mut self.observed);
        let midnight_ns = now_utc_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
        self.sender.send(&self.observed, |datagram, rows| {
            let mut table = WideAreaWriter::begin(datagram, midnight_ns)?;
            rows.iter().try_for_each(|row| table.write(row))
        });
    }

    fn count(&self, entry: &mut HealthEntry) {
        self.sender.count(entry);
    }
}
