//! Lines of simulated receivers of AIS, as those of a network of coast stations: each message with a tag block that
//! states the station and the time of receipt.

use std::fmt::Write as _;

use deployment::Source;
use formats::ais::{AisClass, AisPosition, AisStaticData};
use frames::SystemFrame;
use messages::NS_PER_S;
use net::UdpSender;
use runtime::{HealthEntry, Now, Process};
use scenario::{AisMessage, AisReport, AisSettings, AisShip, SimulatedAis, Truth};

use crate::rows::count_sent;
use crate::{DATAGRAM_OCTETS_MAX, WorldObserver, sender_to};

const KNOT_MPS: f64 = 1852.0 / 3600.0;
/// Codes of the navigation status: under way using engine, at anchor.
const UNDER_WAY: u8 = 0;
const AT_ANCHOR: u8 = 1;
/// Speed below which a ship is at anchor, knots.
const ANCHORED_KT: f64 = 0.5;

/// Simulated receivers with an encoder.
#[derive(Debug)]
pub struct AisFeed {
    simulated: SimulatedAis,
    frame: SystemFrame,
    heard: Vec<AisMessage>,
    /// Number of the next message in several sentences.
    sequence: u8,
    messages: u64,
}

impl AisFeed {
    /// Lines of the receivers `simulated`, whose positions are in `frame`.
    pub fn new(simulated: SimulatedAis, frame: SystemFrame) -> Self {
        Self {
            simulated,
            frame,
            heard: Vec::new(),
            sequence: 0,
            messages: 0,
        }
    }

    /// Returns the time of the next delivery, seconds from the scenario's start.
    pub fn due_s(&self) -> f64 {
        self.simulated.next_delivery_s()
    }

    /// Messages so far; a message that several receivers hear counts as often.
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// Passes the lines of each message of the next second to `send`, in which line times are `ahead_s` seconds later
    /// than those of the simulation.
    pub fn deliver(&mut self, truth: &Truth, ahead_s: i64, send: &mut impl FnMut(&str)) {
        let received_s = self.simulated.second() + ahead_s;
        let second = self.simulated.second().rem_euclid(60) as u8;
        self.heard.clear();
        self.simulated.hear(truth, &mut self.heard);
        let mut lines = String::new();
        for message in &self.heard {
            let channel = if message.is_on_channel_b { 'B' } else { 'A' };
            let mut sentences = String::new();
            match &message.report {
                Some(report) => position(&self.frame, &message.ship, report, second).write(channel, &mut sentences),
                None => {
                    let name = format!("{} {}", message.ship.name, message.ship.id + 1);
                    static_data(&message.ship, &name).write(channel, self.sequence, &mut sentences);
                    self.sequence = (self.sequence + 1) % 10;
                }
            }
            lines.clear();
            let tag = format!("s:station{},c:{received_s}", message.station + 1);
            let sum = tag.bytes().fold(0, |sum, octet| sum ^ octet);
            for sentence in sentences.lines() {
                // Writing into memory does not fail.
                let _ = write!(lines, "\\{tag}*{sum:02X}\\{sentence}\r\n");
            }
            send(&lines);
            self.messages += 1;
        }
    }
}

/// A report with directions from true north at the ship.
fn position(frame: &SystemFrame, ship: &AisShip, report: &AisReport, second: u8) -> AisPosition {
    let [to_east, to_north, _] = frame.axes(report.position_m);
    let along = |axis: [f64; 3], [x, y]: [f64; 2]| axis[0] * x + axis[1] * y;
    let bearing_deg = |direction: [f64; 2]| along(to_east, direction).atan2(along(to_north, direction)).to_degrees();
    let place = frame.to_geodetic(report.position_m);
    let speed_kt = report.velocity_mps[0].hypot(report.velocity_mps[1]) / KNOT_MPS;
    AisPosition {
        mmsi: ship.mmsi,
        class: class(ship),
        position_deg: [place.latitude_deg(), place.longitude_deg()],
        is_accurate: ship.is_accurate,
        speed_kt,
        course_deg: bearing_deg(report.velocity_mps),
        heading_deg: report
            .heading_rad
            .map(|heading| bearing_deg([heading.sin(), heading.cos()])),
        second,
        navigation: if speed_kt < ANCHORED_KT { AT_ANCHOR } else { UNDER_WAY },
    }
}

fn static_data<'a>(ship: &'a AisShip, name: &'a str) -> AisStaticData<'a> {
    AisStaticData {
        mmsi: ship.mmsi,
        class: class(ship),
        name,
        callsign: std::str::from_utf8(&ship.callsign).unwrap_or_default().trim_end(),
        ship_type: ship.ship_type,
        distances_m: ship.distances_m,
    }
}

fn class(ship: &AisShip) -> AisClass {
    if ship.is_class_b { AisClass::B } else { AisClass::A }
}

/// Simulated receivers of a source, which send datagrams.
#[derive(Debug)]
pub(crate) struct AisReceivers {
    feed: AisFeed,
    sender: UdpSender,
    datagram: String,
}

impl AisReceivers {
    pub(crate) fn new(process: &Process, source: &Source, settings: &AisSettings) -> anyhow::Result<Self> {
        let (seed, start_utc_ns) = (process.options.seed, process.options.scenario_start_ns);
        let mut simulated = SimulatedAis::new(settings, seed, source.number, start_utc_ns)?;
        simulated.restart_at(((Now::read().utc_ns - start_utc_ns) as f64 / NS_PER_S).max(0.0));
        Ok(Self {
            feed: AisFeed::new(simulated, process.config.frame),
            sender: sender_to(process, &source.adapter)?,
            datagram: String::with_capacity(DATAGRAM_OCTETS_MAX),
        })
    }
}

impl WorldObserver for AisReceivers {
    fn due_s(&self) -> f64 {
        self.feed.due_s()
    }

    fn deliver(&mut self, truth: &Truth, _now_utc_ns: i64) {
        let (sender, datagram) = (&mut self.sender, &mut self.datagram);
        // The sender counts failures; receivers do not stop without a reader.
        let mut send = |lines: &mut String| {
            if !lines.is_empty() {
                drop(sender.send(lines.as_bytes()));
                lines.clear();
            }
        };
        self.feed.deliver(truth, 0, &mut |lines| {
            if datagram.len() + lines.len() > DATAGRAM_OCTETS_MAX {
                send(datagram);
            }
            datagram.push_str(lines);
        });
        send(datagram);
    }

    fn count(&self, entry: &mut HealthEntry) {
        count_sent(self.feed.messages(), &self.sender, entry);
    }
}
