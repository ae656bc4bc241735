//! ASTERIX reports of a simulated sensor, in the category of the sensor kind: tracks or plots.

use anyhow::Context as _;
use asterix::{Category, registry};
use deployment::Source;
use frames::SystemFrame;
use messages::{NS_PER_S, SensorTrack};
use outgoing::{HeightReference, SensorReports};
use scenario::{RadarPlot, SensorKind, SensorSettings, SimulatedSensor, Truth};

use crate::DATAGRAM_OCTETS_MAX;

/// Time between two status messages of a sensor, nanoseconds.
const STATUS_PERIOD_NS: i64 = 1_000_000_000;
/// Expected maximum of reports in one delivery; more reports need more memory.
const DELIVERY_MAX: usize = 4096;

/// Simulated sensor with an encoder.
#[derive(Debug)]
pub struct SensorFeed {
    simulated: SimulatedSensor,
    pub(crate) reports: SensorReports,
    next_status_ns: i64,
    sends_plots: bool,
    start_utc_ns: i64,
    delivery: Vec<SensorTrack>,
    plots: Vec<RadarPlot>,
}

impl SensorFeed {
    /// Creates the sensor of `source`, whose reports refer to the `system`'s frame, with these settings, in a scenario
    /// of this seed that starts at `start_utc_ns` (UTC, nanoseconds).
    ///
    /// # Errors
    /// If a setting cannot be used.
    pub fn new(
        (source, system): (&Source, SystemFrame),
        settings: &SensorSettings,
        seed: u64,
        start_utc_ns: i64,
    ) -> anyhow::Result<Self> {
        let (sac, sic) = source.sac_sic.context("it has no SAC and SIC")?;
        let table = table(settings.kind).context("there is no table for it")?;
        Ok(Self {
            simulated: SimulatedSensor::new(settings, seed, source.number, start_utc_ns)?,
            // Sensors report flight levels; the height of the simulated world is pressure altitude.
            reports: SensorReports::new(table, sac, sic, source.frame, system, DATAGRAM_OCTETS_MAX)?
                .with_height(HeightReference::Barometric),
            next_status_ns: i64::MIN,
            sends_plots: settings.plots,
            start_utc_ns,
            delivery: Vec::with_capacity(DELIVERY_MAX),
            plots: Vec::with_capacity(DELIVERY_MAX),
        })
    }

    /// Continues at `time_s` seconds from the scenario's start.
    pub fn restart_at(&mut self, time_s: f64) {
        self.simulated.restart_at(time_s);
    }

    /// Returns the time of the next delivery, seconds from the scenario's start.
    pub fn due_s(&self) -> f64 {
        self.simulated.next_scan_time_s()
    }

    /// Makes the observations due by `now_utc_ns` and passes the resulting datagrams to `send`.
    pub fn deliver(&mut self, truth: &Truth, now_utc_ns: i64, send: &mut impl FnMut(&[u8])) {
        self.delivery.clear();
        self.plots.clear();
        if self.sends_plots {
            self.deliver_plots(truth, send);
        } else {
            self.deliver_tracks(truth, now_utc_ns, send);
        }
    }

    /// Sends tracks, and a status message if due.
    fn deliver_tracks(&mut self, truth: &Truth, now_utc_ns: i64, send: &mut impl FnMut(&[u8])) {
        self.simulated.scan(truth, &mut self.delivery);
        if now_utc_ns >= self.next_status_ns {
            self.reports.status(now_utc_ns, send);
            self.next_status_ns = now_utc_ns + STATUS_PERIOD_NS;
        }
        for track in &self.delivery {
            self.reports.report(track, send);
        }
        self.reports.flush(send);
    }

    /// Sends plots, preceded by a north marker at the start of a turn.
    fn deliver_plots(&mut self, truth: &Truth, send: &mut impl FnMut(&[u8])) {
        let north_s = self.simulated.period_begins_s();
        self.simulated
            .scan_with_plots(truth, &mut self.delivery, &mut self.plots);
        if let Some(north_s) = north_s {
            self.reports
                .status(self.start_utc_ns + (north_s * NS_PER_S) as i64, send);
        }
        for plot in &self.plots {
            let (time_ns, identity) = (plot.time_of_measurement_ns, &plot.identity);
            self.reports
                .replied_plot(time_ns, plot.position_m, plot.height, identity, send);
        }
        self.reports.flush(send);
    }
}

/// Returns category and edition for a sensor of this kind.
fn table(kind: SensorKind) -> Option<&'static Category> {
    registry::default_edition(match kind {
        SensorKind::Radar => 48,
        SensorKind::Multilateration => 20,
        SensorKind::AdsB => 21,
    })
}
