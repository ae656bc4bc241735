//! A simulated sensor with its way out: what it tracks, or its plots, in ASTERIX of the category of its kind.

use anyhow::Context as _;
use asterix::{Category, registry};
use configuration::{Process, Source};
use messages::{Counter, NS_PER_S, SensorTrack};
use net::UdpSender;
use outgoing::{HeightReference, SensorReports};
use runtime::{HealthEntry, Now};
use scenario::{Plot, SensorKind, SensorSettings, SimulatedSensor, Truth};

use crate::{DATAGRAM_OCTETS_MAX, Observer, sender_to};

/// Time between two status messages of a sensor, nanoseconds.
const STATUS_PERIOD_NS: i64 = 1_000_000_000;
/// Most reports of one delivery; more need more memory.
const DELIVERY_MAX: usize = 4096;

/// See the module's documentation.
#[derive(Debug)]
pub(crate) struct Sensor {
    simulated: SimulatedSensor,
    reports: SensorReports,
    sender: UdpSender,
    next_status_ns: i64,
    sends_plots: bool,
    start_utc_ns: i64,
    delivery: Vec<SensorTrack>,
    plots: Vec<Plot>,
}

impl Sensor {
    pub(crate) fn new(process: &Process, source: &Source, settings: &SensorSettings) -> anyhow::Result<Self> {
        let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
        let mut simulated = SimulatedSensor::new(settings, seed, source.number, start_utc_ns)?;
        simulated.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        let (sac, sic) = source.model.sac_sic.context("it has no SAC and SIC")?;
        let model = &source.model;
        let table = table(settings.kind).context("there is no table for it")?;
        Ok(Self {
            simulated,
            // Sensors report flight levels; the height of the simulated world is pressure altitude.
            reports: SensorReports::new(table, sac, sic, model.frame, model.system, DATAGRAM_OCTETS_MAX)?
                .with_height(HeightReference::Barometric),
            sender: sender_to(process, &source.adapter)?,
            next_status_ns: i64::MIN,
            sends_plots: settings.plots,
            start_utc_ns,
            delivery: Vec::with_capacity(DELIVERY_MAX),
            plots: Vec::with_capacity(DELIVERY_MAX),
        })
    }

    /// Tracks, and when it is time a status message.
    fn deliver_tracks(&mut self, truth: &Truth, now_utc_ns: i64) {
        self.simulated.scan(truth, &mut self.delivery);
        let sender = &mut self.sender;
        // What could not be sent is counted by the sender; a sensor does not stop because nobody listens.
        let mut send = |datagram: &[u8]| drop(sender.send(datagram));
        if now_utc_ns >= self.next_status_ns {
            self.reports.status(now_utc_ns, &mut send);
            self.next_status_ns = now_utc_ns + STATUS_PERIOD_NS;
        }
        for track in &self.delivery {
            self.reports.report(track, &mut send);
        }
        self.reports.flush(&mut send);
    }

    /// Plots, after a north marker if a turn began.
    fn deliver_plots(&mut self, truth: &Truth) {
        let north_s = self.simulated.period_begins_s();
        self.simulated
            .scan_with_plots(truth, &mut self.delivery, &mut self.plots);
        let sender = &mut self.sender;
        let mut send = |datagram: &[u8]| drop(sender.send(datagram));
        if let Some(north_s) = north_s {
            self.reports
                .status(self.start_utc_ns + (north_s * NS_PER_S) as i64, &mut send);
        }
        for plot in &self.plots {
            self.reports
                .plot(plot.time_of_measurement_ns, plot.position_m, plot.height, &mut send);
        }
        self.reports.flush(&mut send);
    }
}

impl Observer for Sensor {
    fn due_s(&self) -> f64 {
        self.simulated.next_scan_time_s()
    }

    fn deliver(&mut self, truth: &Truth, now_utc_ns: i64) {
        self.delivery.clear();
        self.plots.clear();
        if self.sends_plots {
            self.deliver_plots(truth);
        } else {
            self.deliver_tracks(truth, now_utc_ns);
        }
    }

    fn count(&self, entry: &mut HealthEntry) {
        let (reports, sent) = (self.reports.counts(), self.sender.counters());
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

/// Category and edition that a sensor of this kind speaks.
fn table(kind: SensorKind) -> Option<&'static Category> {
    registry::default_edition(match kind {
        SensorKind::Radar => 48,
        SensorKind::Multilateration => 20,
        SensorKind::AdsB => 21,
    })
}
