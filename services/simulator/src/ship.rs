//! Simulated ship: its navigation sends sentences of NMEA 0183, its radar rows of detections (FM-6), scan by scan.

use std::net::SocketAddr;

use anyhow::Context as _;
use deployment::{Platform, PlatformFeed, PlatformInput};
use formats::detections_csv::DetectionWriter;
use formats::nmea::write_sentences;
use frames::SystemFrame;
use frames::time::NS_PER_DAY;
use messages::{Counter, NS_PER_S};
use net::{SenderSettings, UdpSender};
use observations::Detection;
use platform::{Navigation, State};
use runtime::Process;
use runtime::{HealthEntry, Now};
use scenario::{OnBoardSettings, SimulatedShip, Truth};

use crate::WorldObserver;
use crate::rows::RowSender;

/// Simulated ship, see the module's documentation.
#[derive(Debug)]
pub(crate) struct Ship {
    simulated: SimulatedShip,
    start_utc_ns: i64,
    frame: SystemFrame,
    navigation: UdpSender,
    radar: Option<RowSender>,
    text: String,
    states: u64,
}

impl Ship {
    pub(crate) fn new(process: &Process, platform: &Platform, settings: &OnBoardSettings) -> anyhow::Result<Self> {
        let PlatformInput::Live(PlatformFeed::Loopback(port)) = platform.input else {
            anyhow::bail!("its input is not the deployment's own");
        };
        let start_utc_ns = process.options.scenario_start_ns;
        let mut simulated = SimulatedShip::new(*settings, process.options.seed);
        simulated.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        let destination = SocketAddr::from((process.loopback, port));
        let radar = platform
            .radar
            .as_ref()
            .map(|receiver| RowSender::new(process, receiver));
        Ok(Self {
            simulated,
            start_utc_ns,
            frame: process.config.frame,
            navigation: UdpSender::open(&SenderSettings::new(destination)).context("its navigation")?,
            radar: radar.transpose()?,
            text: String::new(),
            states: 0,
        })
    }
}

impl WorldObserver for Ship {
    fn due_s(&self) -> f64 {
        self.simulated.due_s()
    }

    fn deliver(&mut self, _: &Truth, now_utc_ns: i64) {
        let start_utc_ns = self.start_utc_ns;
        if let Some(state) = self.simulated.next_state() {
            let state = State {
                time_ns: start_utc_ns + state.time_ns,
                ..state
            };
            self.text.clear();
            write_sentences(&Navigation::of(&state, &self.frame), &mut self.text);
            // The sender counts failures.
            drop(self.navigation.send(self.text.as_bytes()));
            self.states += 1;
            return;
        }
        let detections = self.simulated.next_scan();
        let Some(radar) = &mut self.radar else { return };
        let at = |detection: &Detection| Detection {
            time_of_measurement_ns: start_utc_ns + detection.time_of_measurement_ns,
            ..*detection
        };
        let detections: Vec<Detection> = detections.iter().map(at).collect();
        let midnight_ns = now_utc_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
        radar.send(&detections, |datagram, rows| {
            let mut table = DetectionWriter::begin(datagram, midnight_ns)?;
            rows.iter().try_for_each(|row| table.write(row))
        });
    }

    fn count(&self, entry: &mut HealthEntry) {
        let sent = self.navigation.counters();
        for (counter, count) in [
            (Counter::RecordsSent, self.states),
            (Counter::DatagramsSent, sent.sent),
            (Counter::SendFailures, sent.failed),
        ] {
            entry.counters[counter] += count;
        }
        if let Some(radar) = &self.radar {
            radar.count(entry);
        }
    }
}
