//! Simulated direction finder: sends tables of bearings in datagrams (FM-7), each with a header line.

use deployment::{Process, Source};
use formats::bearings_csv::BearingWriter;
use frames::time::NS_PER_DAY;
use messages::NS_PER_S;
use observations::Bearing;
use runtime::{HealthEntry, Now};
use scenario::{DirectionFinderSettings, SimulatedDirectionFinder, Truth};

use crate::WorldObserver;
use crate::rows::RowSender;

/// Simulated direction finder, see the module's documentation.
#[derive(Debug)]
pub(crate) struct DirectionFinder {
    simulated: SimulatedDirectionFinder,
    heard: Vec<Bearing>,
    sender: RowSender,
}

impl DirectionFinder {
    pub(crate) fn new(process: &Process, source: &Source, settings: &DirectionFinderSettings) -> anyhow::Result<Self> {
        let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
        let mut simulated = SimulatedDirectionFinder::new(settings, seed, source.number, start_utc_ns)?;
        simulated.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        Ok(Self {
            simulated,
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
