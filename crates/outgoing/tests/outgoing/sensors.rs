//! CAT048, 020, 021 and 010, in every edition, against what the tracks say.

use std::collections::HashMap;

use asterix::table::Edition;
use asterix::{Category, NamedRecord, registry};
use messages::{SensorTrack, TrackState, alert_bits, sensor_track_bits as bits};
use outgoing::{HeightReference, OutgoingError, SensorReports};
use proptest::prelude::*;

use crate::model::{self, FOOT_M, LEVEL_M, NM_M, World, gradient, sensor_track, world};
use crate::reading::{Sent, records};

const SPEED_LSB: f64 = 1.0 / 16_384.0;
const TURN_LSB_DEG: f64 = 360.0 / 65_536.0;
const EMERGENCIES: u8 = alert_bits::EMERGENCY | alert_bits::COMMUNICATION_FAILURE | alert_bits::UNLAWFUL_INTERFERENCE;

/// A sender of one edition and what it is to send.
struct Case {
    world: World,
    height: HeightReference,
    table: &'static Category,
}

/// A record and the track it is of.
struct Pair<'r> {
    world: &'r World,
    height: HeightReference,
    sent: Sent<'r>,
    track: &'r SensorTrack,
    state: TrackState,
}

impl Case {
    /// Sends the tracks one by one and checks every record, the numbers and the counters.
    fn run(&self, tracks: &[SensorTrack]) {
        let Self { world, height, table } = *self;
        let mut sender = SensorReports::new(table, 7, 9, world.sensor, world.system, 1400)
            .unwrap()
            .with_height(height);
        let is_adsb = table.number == 21;
        let mut live = HashMap::<u32, u64>::new();
        let mut expected_counts = (0, 0, 0);
        for track in tracks {
            let state = TrackState::from_code(track.state).unwrap();
            let found = send_one(&mut sender, table, track);
            let withheld = match state {
                TrackState::Coasted => is_adsb,
                TrackState::Terminated => is_adsb || !live.contains_key(&track.track_number),
                _ => false,
            };
            let refused = !withheld && is_adsb && track.identity.address().is_none();
            expected_counts.1 += u64::from(withheld);
            expected_counts.2 += u64::from(refused);
            if withheld || refused {
                assert!(found.is_empty(), "{table}: sent {state:?}");
                continue;
            }
            expected_counts.0 += 1;
            let [record] = found.as_slice() else {
                panic!("{table}: {} records of one track", found.len());
            };
            let sent = Sent { record, table };
            note_number(&mut live, &sent, track, state);
            let pair = Pair {
                world: &world,
                height,
                sent,
                track,
                state,
            };
            pair.check();
        }
        let counts = sender.counts();
        assert_eq!(
            (counts.records, counts.withheld, counts.refused_address),
            expected_counts
        );
        assert_eq!(counts.refused(), counts.refused_address);
    }
}

fn send_one(sender: &mut SensorReports, table: &'static Category, track: &SensorTrack) -> Vec<NamedRecord> {
    let mut bytes = vec![];
    sender.report(track, &mut |block| bytes.extend_from_slice(block));
    sender.flush(&mut |block| bytes.extend_from_slice(block));
    records(table, &bytes)
}

/// The item that holds the track number, and its element.
fn number_path(table: &Category) -> Option<[&'static str; 2]> {
    match (table.number, table.edition.major) {
        (10, _) => Some(["161", "TRK"]),
        (21, 0) => None,
        (21, _) => Some(["161", "TRNUM"]),
        _ => Some(["161", "TRN"]),
    }
}

fn note_number(live: &mut HashMap<u32, u64>, sent: &Sent<'_>, track: &SensorTrack, state: TrackState) {
    let Some(path) = number_path(sent.table) else { return };
    let number = sent.number(&path);
    assert!((1..=4095).contains(&number));
    assert_eq!(
        *live.entry(track.track_number).or_insert(number),
        number,
        "a track keeps its number"
    );
    let same = live.values().filter(|other| **other == number).count();
    assert_eq!(same, 1, "live tracks have numbers of their own");
    if state == TrackState::Terminated {
        live.remove(&track.track_number);
    }
}

impl Pair<'_> {
    fn check(&self) {
        match (self.sent.table.number, self.sent.table.edition.major) {
            (48, _) => self.check_cat048(),
            (20, _) => self.check_cat020(),
            (10, _) => self.check_cat010(),
            (_, 0) => self.check_cat021_v0(),
            _ => self.check_cat021_v2(),
        }
    }

    fn has(&self, bit: u16) -> bool {
        self.track.has(bit)
    }

    fn ended(&self) -> bool {
        self.state == TrackState::Terminated
    }

    fn coasted(&self) -> bool {
        self.state == TrackState::Coasted
    }

    fn alert(&self, bits: u8) -> bool {
        self.track.alerts & bits != 0
    }

    /// Height above the ellipsoid, metres, if it is known.
    fn height_m(&self) -> Option<f64> {
        let place = self.world.system.to_geodetic(self.track.position_m);
        (self.has(bits::HEIGHT) && !self.ended()).then_some(place.height_m())
    }

    fn feet(&self) -> Option<f64> {
        let feet = self.height_m().map(|height_m| height_m / FOOT_M);
        let geometric = self.height == HeightReference::Geometric;
        feet.filter(|feet| geometric && (-1500.0..=150_000.0).contains(feet))
    }

    fn level(&self) -> Option<f64> {
        let level = self.height_m().map(|height_m| height_m / LEVEL_M);
        level.filter(|level| (-15.0..=1500.0).contains(level))
    }

    fn barometric_level(&self) -> Option<f64> {
        self.level().filter(|_| self.height == HeightReference::Barometric)
    }

    fn velocity(&self) -> Option<[f64; 3]> {
        let track = self.track;
        let known = self.has(bits::VELOCITY) && !self.ended();
        known.then(|| {
            self.world
                .velocity(track.position_m, track.velocity_mps, self.has(bits::VERTICAL_RATE))
        })
    }

    fn climb(&self) -> Option<f64> {
        let [vx, vy, vz] = self.track.velocity_mps;
        let plane = if self.has(bits::VELOCITY) { 1.0 } else { 0.0 };
        let known = self.has(bits::VERTICAL_RATE) && !self.ended();
        known.then(|| {
            self.world
                .at_target(self.track.position_m, [plane * vx, plane * vy, vz])[2]
        })
    }

    /// Speed (NM/s) and course (degrees).
    fn ground_vector(&self) -> Option<(f64, f64)> {
        let [east, north, _] = self.velocity()?;
        Some((east.hypot(north) / NM_M, east.atan2(north).to_degrees()))
    }

    /// The velocity along the sensor's x and y.
    fn sensor_velocity(&self) -> Option<[f64; 2]> {
        let [vx, vy, vz] = self.track.velocity_mps;
        let vz = if self.has(bits::VERTICAL_RATE) { vz } else { 0.0 };
        let [x, y, _] = self.world.vector_in_sensor([vx, vy, vz]);
        (self.has(bits::VELOCITY) && !self.ended()).then_some([x, y])
    }

    /// Variances of the sensor's x and y and their covariance.
    fn sensor_covariance(&self) -> [f64; 3] {
        let flat = |[x, y, z]: [f64; 3]| [x, y, if self.has(bits::HEIGHT) { z } else { 0.0 }];
        let [x, y] = [0, 1].map(|axis| gradient(|vector| self.world.vector_in_sensor(flat(vector))[axis]));
        let covariance = |a, b| World::position_covariance(&self.track.covariance, a, b);
        [covariance(x, x), covariance(x, y), covariance(y, y)]
    }

    /// Covariance of the velocity's components towards east and north.
    fn velocity_covariance(&self) -> Option<[f64; 3]> {
        let vertical = self.has(bits::VERTICAL_RATE);
        let row = |axis: usize| gradient(|vector| self.world.velocity(self.track.position_m, vector, vertical)[axis]);
        let covariance = |a, b| World::velocity_covariance(&self.track.covariance, a, b);
        let known = self.has(bits::VELOCITY) && !self.ended();
        known.then(|| {
            [
                covariance(row(0), row(0)),
                covariance(row(0), row(1)),
                covariance(row(1), row(1)),
            ]
        })
    }

    fn height_sigma_m(&self) -> Option<f64> {
        let up = gradient(|vector| self.world.at_target(self.track.position_m, vector)[2]);
        let variance = World::position_covariance(&self.track.covariance, up, up);
        self.height_m().map(|_| variance.sqrt())
    }

    fn check_source_and_time(&self, time: &str) {
        self.sent.is(&["010", "SAC"], 7u64);
        self.sent.is(&["010", "SIC"], 9u64);
        self.sent.near_time(&[time], self.track.time_of_measurement_ns);
    }

    fn check_address(&self, item: &str) {
        let address = self.track.identity.address();
        assert_eq!(self.sent.has(&[item]), address.is_some());
        self.sent.is(&[item], address.unwrap_or(0));
    }

    fn check_code(&self, item: &str) {
        let code = self.sent.text(&[item, "MODE3A"]).map(str::to_owned);
        assert_eq!(code, model::code(&self.track.identity));
        let lately = u64::from(code.is_some() && (self.coasted() || self.ended()));
        for (flag, expected) in [("V", 0), ("G", 0), ("L", lately)] {
            self.sent.is(&[item, flag], expected);
        }
    }

    fn check_call_sign(&self, path: &[&str]) {
        assert_eq!(self.sent.text(path), model::call_sign(&self.track.identity).as_deref());
    }

    fn check_ground_vector(&self, item: &str, speed: &str, course: &str) {
        let vector = self.ground_vector();
        self.sent
            .near_if(&[item, speed], vector.map(|(speed, _)| speed), SPEED_LSB);
        if let Some((_, course_deg)) = vector {
            self.sent.near_turn(&[item, course], course_deg, TURN_LSB_DEG);
        }
    }

    fn check_flight_status(&self, item: &str, expected: bool) {
        assert_eq!(self.sent.has(&[item]), expected);
        if !expected {
            return;
        }
        let alert = self.alert(EMERGENCIES | alert_bits::TRANSPONDER_ALERT);
        let special = self.alert(alert_bits::SPECIAL_IDENTIFICATION);
        let status = match (alert, special, self.has(bits::ON_GROUND)) {
            (false, false, ground) => u64::from(ground),
            (true, false, ground) => 2 + u64::from(ground),
            (true, true, _) => 4,
            (false, true, _) => 5,
        };
        self.sent.is(&[item, "STAT"], status);
        self.sent.is(&[item, "COM"], 0u64);
        self.sent.is(
            &[item, "AIC"],
            u64::from(model::call_sign(&self.track.identity).is_some()),
        );
    }

    fn check_climb_mode(&self, item: &str) {
        let Some(climb) = self.climb() else {
            return self.sent.is(&[item, "CDM"], 3u64);
        };
        let limit = 0.508;
        if (climb.abs() - limit).abs() > 1e-6 {
            let mode = if climb.abs() < limit {
                0u64
            } else {
                1 + u64::from(climb < 0.0)
            };
            self.sent.is(&[item, "CDM"], mode);
        }
    }

    /// Items of a category that have no source in a track.
    fn check_absent(&self, items: &[&str]) {
        for item in items {
            assert!(!self.sent.has(&[item]), "{}: {item}", self.sent.table);
        }
    }

    fn check_cat048(&self) {
        let Self { sent, track, world, .. } = self;
        self.check_source_and_time("140");
        let identity = &track.identity;
        let kind = match (
            identity.address(),
            identity.mode_3a(),
            self.has(bits::HEIGHT) && !self.ended(),
        ) {
            _ if self.coasted() || self.ended() => 0u64,
            (Some(_), _, _) => 5,
            (None, None, false) => 1,
            _ => 2,
        };
        sent.is(&["020", "TYP"], kind);
        sent.is(&["020", "SIM"], 0u64);
        sent.is(
            &["020", "SPI"],
            u64::from(self.alert(alert_bits::SPECIAL_IDENTIFICATION)),
        );
        assert_eq!((sent.has(&["040"]), sent.has(&["042"])), (!self.ended(), !self.ended()));
        if !self.ended() {
            let measured = self.has(bits::MEASURED) && !self.coasted();
            let [x, y, up] = world.in_sensor(if measured { track.measured_m } else { track.position_m });
            let range_m = (x * x + y * y + up * up).sqrt();
            sent.near(&["040", "RHO"], range_m / NM_M, 1.0 / 256.0);
            sent.near_turn(&["040", "THETA"], x.atan2(y).to_degrees(), TURN_LSB_DEG);
            let [x, y, up] = world.in_sensor(track.position_m);
            let stretch = (x * x + y * y + up * up).sqrt() / x.hypot(y); // into the radar plane
            let [x, y] = [x * stretch, y * stretch];
            sent.near(&["042", "X"], x / NM_M, 1.0 / 128.0);
            sent.near(&["042", "Y"], y / NM_M, 1.0 / 128.0);
        }
        self.check_code("070");
        let has_sign = sent.table.edition >= Edition::new(1, 32);
        let level = self
            .level()
            .filter(|level| !self.coasted() && (has_sign || (level * 4.0).round() >= 0.0));
        sent.near_if(&["090", "FL"], level, 0.25);
        self.check_address("220");
        self.check_call_sign(&["240"]);
        self.check_ground_vector("200", "GSP", "HDG");
        sent.is(&["170", "CNF"], u64::from(self.state == TrackState::Tentative));
        sent.is(&["170", "TRE"], u64::from(self.ended()));
        sent.is(&["170", "TCC"], 0u64);
        let primary = identity.address().is_none() && identity.mode_3a().is_none() && !self.has(bits::HEIGHT);
        sent.is(&["170", "RAD"], if primary { 1u64 } else { 2 });
        self.check_climb_mode("170");
        self.check_quality_of_cat048();
        self.check_flight_status("230", identity.address().is_some() && !self.ended());
        self.check_absent(&[
            "030", "050", "055", "060", "065", "080", "100", "110", "120", "130", "250", "260", "RE",
        ]);
    }

    /// All four deviations, or none.
    fn check_quality_of_cat048(&self) {
        let Some(([ee, en, nn], [east, north, _])) = self.velocity_covariance().zip(self.velocity()) else {
            return self.check_absent(&["210"]);
        };
        let speed = east.hypot(north);
        let (sin, cos) = (east / speed, north / speed);
        let along = (sin * sin * ee + 2.0 * sin * cos * en + cos * cos * nn).sqrt();
        let across = (cos * cos * ee - 2.0 * sin * cos * en + sin * sin * nn).sqrt();
        let [xx, _, yy] = self.sensor_covariance();
        let sigmas = [
            ("SIGX", xx.sqrt() / NM_M, 1.0 / 128.0),
            ("SIGY", yy.sqrt() / NM_M, 1.0 / 128.0),
            ("SIGV", along / NM_M, SPEED_LSB),
            ("SIGH", (across / speed).to_degrees(), 360.0 / 4096.0),
        ];
        let fits = |slack: f64| sigmas.iter().all(|(_, sigma, lsb)| sigma / lsb < 255.5 + slack);
        assert!(fits(1e-3) || !self.sent.has(&["210"]));
        assert!(!fits(-1e-3) || self.sent.has(&["210"]));
        if self.sent.has(&["210"]) {
            for (element, sigma, lsb) in sigmas {
                self.sent.near_sigma(&["210", element], sigma, lsb, 255);
            }
        }
    }

    fn check_cat020(&self) {
        let Self { sent, track, world, .. } = self;
        self.check_source_and_time("140");
        let mode_s = track.identity.address().is_some();
        sent.is(&["020", "MS"], u64::from(mode_s));
        sent.is(&["020", "SSR"], u64::from(!mode_s));
        sent.is(
            &["020", "SPI"],
            u64::from(self.alert(alert_bits::SPECIAL_IDENTIFICATION)),
        );
        sent.is(&["020", "GBS"], u64::from(self.has(bits::ON_GROUND)));
        sent.is(&["020", "SIM"], 0u64);
        sent.is(
            &["020", "CF"],
            if sent.table.edition >= Edition::new(1, 10) {
                3u64
            } else {
                0
            },
        );
        assert_eq!((sent.has(&["041"]), sent.has(&["042"])), (!self.ended(), !self.ended()));
        if !self.ended() {
            sent.near_place(
                "041",
                world.system.to_geodetic(track.position_m),
                180.0 / (1u64 << 25) as f64,
            );
            let [x, y, _] = world.in_sensor(track.position_m);
            sent.near(&["042", "X"], x, 0.5);
            sent.near(&["042", "Y"], y, 0.5);
        }
        sent.is(&["170", "CNF"], u64::from(self.state == TrackState::Tentative));
        sent.is(&["170", "TRE"], u64::from(self.ended()));
        sent.is(&["170", "CST"], u64::from(self.coasted()));
        sent.is(&["170", "STH"], 1u64);
        self.check_climb_mode("170");
        self.check_code("070");
        let velocity = self.sensor_velocity();
        sent.near_if(&["202", "VX"], velocity.map(|[x, _]| x), 0.25);
        sent.near_if(&["202", "VY"], velocity.map(|[_, y]| y), 0.25);
        sent.near_if(&["090", "FL"], self.barometric_level(), 0.25);
        sent.near_if(&["105"], self.feet(), 6.25);
        self.check_address("220");
        self.check_call_sign(&["245", "CHR"]);
        sent.is(&["245", "STI"], if sent.has(&["245"]) { 2u64 } else { 0 });
        self.check_accuracy_of_cat020();
        let alerts = EMERGENCIES | alert_bits::TRANSPONDER_ALERT | alert_bits::SPECIAL_IDENTIFICATION;
        self.check_flight_status("230", mode_s && self.alert(alerts) && !self.ended());
        self.check_absent(&[
            "030", "050", "055", "100", "110", "210", "250", "260", "300", "310", "400", "RE", "SP",
        ]);
    }

    fn check_accuracy_of_cat020(&self) {
        let [xx, xy, yy] = self.sensor_covariance();
        let fits = !self.ended() && xx.sqrt().max(yy.sqrt()) < 65_535.0 * 0.25;
        assert_eq!(self.sent.has(&["500", "SDP"]), fits);
        if fits {
            self.sent.near_sigma(&["500", "SDP", "X"], xx.sqrt(), 0.25, 65_535);
            self.sent.near_sigma(&["500", "SDP", "Y"], yy.sqrt(), 0.25, 65_535);
            let correlation = (xy / (xx * yy).sqrt()).max(0.0);
            self.sent.near(&["500", "SDP", "XY"], correlation, 0.25);
        }
        let geometric = self
            .height_sigma_m()
            .filter(|_| self.height == HeightReference::Geometric);
        let sigma = geometric.filter(|sigma| *sigma < 65_535.0 * 0.5);
        self.sent
            .near_if(&["500", "SDH"], sigma.map(|sigma| sigma.max(0.5)), 0.5);
    }

    fn check_cat010(&self) {
        let Self { sent, track, world, .. } = self;
        self.check_source_and_time("140");
        sent.is(&["000"], 1u64);
        let kind = match (track.identity.address(), track.identity.mode_3a()) {
            (Some(_), _) => 1u64,
            (None, Some(_)) => 0,
            (None, None) => 3,
        };
        sent.is(&["020", "TYP"], kind);
        sent.is(&["020", "GBS"], u64::from(self.has(bits::ON_GROUND)));
        sent.is(&["020", "SIM"], 0u64);
        sent.is(
            &["020", "SPI"],
            u64::from(self.alert(alert_bits::SPECIAL_IDENTIFICATION)),
        );
        self.check_positions_of_cat010(world);
        self.check_ground_vector("200", "GSP", "TRA");
        let velocity = self.sensor_velocity();
        sent.near_if(&["202", "VX"], velocity.map(|[x, _]| x), 0.25);
        sent.near_if(&["202", "VY"], velocity.map(|[_, y]| y), 0.25);
        sent.is(&["170", "CNF"], u64::from(self.state == TrackState::Tentative));
        sent.is(&["170", "TRE"], u64::from(self.ended()));
        sent.is(&["170", "CST"], if self.coasted() { 3u64 } else { 0 });
        sent.is(&["170", "TCC"], 1u64);
        sent.is(&["170", "STH"], 1u64);
        self.check_code("060");
        self.check_address("220");
        self.check_call_sign(&["245", "CHR"]);
        sent.is(&["245", "STI"], 0u64);
        sent.near_if(&["090", "FL"], self.barometric_level(), 0.25);
        let up_ft = world.in_sensor(track.position_m)[2] / FOOT_M;
        let geometric = self.height_m().is_some() && self.height == HeightReference::Geometric;
        let fits = (-204_800.0..204_790.0).contains(&up_ft);
        sent.near_if(&["091"], (geometric && fits).then_some(up_ft), 6.25);
        let [xx, xy, yy] = self.sensor_covariance();
        let largest = (xx.sqrt().max(yy.sqrt()) * 4.0 / 255.5).max(xy.abs() * 4.0 / 32_767.5);
        assert!(sent.has(&["500"]) == (!self.ended() && largest < 1.0) || (largest - 1.0).abs() < 1e-3);
        if sent.has(&["500"]) {
            sent.near_sigma(&["500", "DEVX"], xx.sqrt(), 0.25, 255);
            sent.near_sigma(&["500", "DEVY"], yy.sqrt(), 0.25, 255);
            sent.near(&["500", "COVXY"], xy, 0.25);
        }
        self.check_absent(&["131", "210", "250", "270", "280", "300", "310", "550", "RE", "SP"]);
    }

    fn check_positions_of_cat010(&self, world: &World) {
        let Self { sent, track, .. } = self;
        assert_eq!(sent.has(&["041"]), !self.ended());
        if self.ended() {
            return self.check_absent(&["040", "042"]);
        }
        sent.near_place(
            "041",
            world.system.to_geodetic(track.position_m),
            180.0 / (1u64 << 31) as f64,
        );
        let [x, y, up] = world.in_sensor(track.measured_m);
        let range_m = (x * x + y * y + up * up).sqrt();
        let measured = self.has(bits::MEASURED) && !self.coasted() && range_m < 65_535.4;
        sent.near_if(&["040", "RHO"], measured.then_some(range_m), 1.0);
        if measured {
            sent.near_turn(&["040", "TH"], x.atan2(y).to_degrees(), TURN_LSB_DEG);
        }
        let [x, y, _] = world.in_sensor(track.position_m);
        let fits = [x, y].iter().all(|value| (-32_768.4..32_767.4).contains(value));
        sent.near_if(&["042", "X"], fits.then_some(x), 1.0);
        sent.near_if(&["042", "Y"], fits.then_some(y), 1.0);
    }

    fn check_cat021_v2(&self) {
        let Self { sent, track, world, .. } = self;
        self.check_source_and_time("071");
        sent.near_time(&["073"], track.time_of_measurement_ns);
        for item in ["072", "075"] {
            assert_eq!(sent.has(&[item]), self.has(bits::VELOCITY));
            if sent.has(&[item]) {
                sent.near_time(&[item], track.time_of_measurement_ns);
            }
        }
        sent.is(&["040", "ATP"], 0u64);
        sent.is(&["040", "ARC"], 2u64);
        sent.is(&["040", "GBS"], u64::from(self.has(bits::ON_GROUND)));
        sent.is(&["040", "SIM"], 0u64);
        sent.near_place(
            "131",
            world.system.to_geodetic(track.position_m),
            180.0 / (1u64 << 30) as f64,
        );
        self.check_address("080");
        self.check_call_sign(&["170"]);
        assert_eq!(
            sent.text(&["070", "MODE3A"]).map(str::to_owned),
            model::code(&track.identity)
        );
        sent.near_if(&["140"], self.feet(), 6.25);
        sent.near_if(&["145"], self.barometric_level(), 0.25);
        self.check_climb(&["157", "GVR"], &["155", "BVR"]);
        self.check_ground_vector("160", "GS", "TA");
        self.check_quality_of_cat021();
        let emergency = model::emergency(track.alerts);
        let surveillance = if self.alert(EMERGENCIES) {
            1u64
        } else if self.alert(alert_bits::TRANSPONDER_ALERT) {
            2
        } else {
            3 * u64::from(self.alert(alert_bits::SPECIAL_IDENTIFICATION))
        };
        sent.is(&["200", "PS"], emergency);
        sent.is(&["200", "SS"], surveillance);
        assert_eq!(sent.has(&["200"]), emergency + surveillance > 0);
        sent.is(&["008", "RA"], u64::from(self.alert(alert_bits::RESOLUTION_ADVISORY)));
        self.check_absent(&[
            "015", "016", "020", "074", "076", "077", "110", "130", "132", "146", "220", "295", "RE",
        ]);
    }

    fn check_climb(&self, geometric: &[&str], barometric: &[&str]) {
        let feet_per_minute = self.climb().map(|climb| climb * 60.0 / FOOT_M);
        let of = |reference| feet_per_minute.filter(|_| self.height == reference);
        self.sent.near_if(geometric, of(HeightReference::Geometric), 6.25);
        self.sent.near_if(barometric, of(HeightReference::Barometric), 6.25);
    }

    /// The bounds that the classes promise hold, and those of the next better class do not.
    fn check_quality_of_cat021(&self) {
        let position = ellipse(self.sensor_covariance()) * 2.447_746_8;
        check_class(self.sent.number(&["090", "NACP"]), position, |class| {
            [
                f64::INFINITY,
                18_520.0,
                7408.0,
                3704.0,
                1852.0,
                926.0,
                555.6,
                185.2,
                92.6,
                30.0,
                10.0,
                3.0,
            ]
            .get(class)
            .copied()
        });
        let velocity = self
            .velocity_covariance()
            .map_or(f64::INFINITY, |of| ellipse(of) * 2.447_746_8);
        check_class(self.sent.number(&["090", "NUCRNACV"]), velocity, |class| {
            [f64::INFINITY, 10.0, 3.0, 1.0, 0.3].get(class).copied()
        });
        let geometric = self
            .height_sigma_m()
            .filter(|_| self.height == HeightReference::Geometric);
        check_class(
            self.sent.number(&["090", "GVA"]),
            geometric.map_or(f64::INFINITY, |sigma| sigma * 1.96),
            |class| [f64::INFINITY, 150.0, 45.0].get(class).copied(),
        );
        for element in ["NUCPNIC", "SIL", "SDA", "PIC"] {
            self.sent.is(&["090", element], 0u64);
        }
        self.sent.is(&["210", "VN"], 2u64);
        self.sent.is(&["210", "LTT"], 2u64);
    }

    fn check_cat021_v0(&self) {
        let Self { sent, track, world, .. } = self;
        self.check_source_and_time("030");
        sent.is(&["040", "ATP"], 1u64);
        sent.is(&["040", "GBS"], u64::from(self.has(bits::ON_GROUND)));
        sent.is(
            &["040", "SPI"],
            u64::from(self.alert(alert_bits::SPECIAL_IDENTIFICATION)),
        );
        sent.is(&["040", "SIM"], 0u64);
        let exponent = if sent.table.edition.minor == 23 { 23 } else { 25 };
        sent.near_place(
            "130",
            world.system.to_geodetic(track.position_m),
            180.0 / (1u64 << exponent) as f64,
        );
        self.check_address("080");
        self.check_call_sign(&["170"]);
        sent.near_if(&["140"], self.feet(), 6.25);
        sent.near_if(&["145"], self.barometric_level(), 0.25);
        self.check_climb(&["157"], &["155"]);
        self.check_ground_vector("160", "GS", "TA");
        sent.is(&["210", "MDS"], 1u64);
        sent.is(&["200"], model::emergency(track.alerts));
        let code = model::code(&track.identity).filter(|_| sent.table.edition.minor == 26);
        assert_eq!(sent.text(&["070", "MODE3A"]).map(str::to_owned), code);
        let position = ellipse(self.sensor_covariance()) * 2.447_746_8;
        check_class(sent.number(&["090", "PA"]), position, |class| {
            [
                f64::INFINITY,
                18_520.0,
                9260.0,
                1852.0,
                926.0,
                463.0,
                185.2,
                92.6,
                10.0,
                3.0,
            ]
            .get(class)
            .copied()
        });
        let velocity = self
            .velocity_covariance()
            .map_or(f64::INFINITY, |of| ellipse(of) * 2.447_746_8);
        check_class(sent.number(&["095"]), velocity, |class| {
            [f64::INFINITY, 10.0, 3.0, 1.0, 0.3].get(class).copied()
        });
        self.check_absent(&[
            "020", "032", "110", "131", "146", "150", "165", "220", "230", "RE", "SP",
        ]);
    }
}

/// The long half axis of an ellipse with this covariance, as the greatest deviation in any of many directions.
fn ellipse([xx, xy, yy]: [f64; 3]) -> f64 {
    let variance = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        cos * cos * xx + 2.0 * sin * cos * xy + sin * sin * yy
    };
    let angles = (0..20_000).map(|step| f64::from(step) * std::f64::consts::PI / 20_000.0);
    angles.map(variance).fold(0.0, f64::max).sqrt()
}

fn check_class(class: u64, error: f64, bound: impl Fn(usize) -> Option<f64>) {
    let class = class as usize;
    let slack = error * 1e-4;
    let held = bound(class).expect("a class there is");
    assert!(
        class == 0 || error - slack < held,
        "class {class} promises {held}, the error is {error}"
    );
    let better = bound(class + 1);
    assert!(
        better.is_none_or(|better| error + slack >= better),
        "class {class}: the next would hold {error}"
    );
}

fn height(barometric: bool) -> HeightReference {
    if barometric {
        HeightReference::Barometric
    } else {
        HeightReference::Geometric
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn radars_say_what_their_tracks_say(
        world in world(), tracks in prop::collection::vec(sensor_track(225e3), 1..12), barometric in any::<bool>(),
    ) {
        for table in registry::editions(48) {
            Case { world, height: height(barometric), table }.run(&tracks);
        }
    }

    #[test]
    fn multilateration_says_what_its_tracks_say(
        world in world(), tracks in prop::collection::vec(sensor_track(400e3), 1..12), barometric in any::<bool>(),
    ) {
        for table in registry::editions(20) {
            Case { world, height: height(barometric), table }.run(&tracks);
        }
    }

    #[test]
    fn surface_sensors_say_what_their_tracks_say(
        world in world(), far in any::<bool>(), near in prop::collection::vec(sensor_track(40e3), 1..12),
        distant in prop::collection::vec(sensor_track(400e3), 1..12), barometric in any::<bool>(),
    ) {
        let tracks = if far { distant } else { near };
        for table in registry::editions(10) {
            Case { world, height: height(barometric), table }.run(&tracks);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn adsb_stations_say_what_their_tracks_say(
        world in world(), tracks in prop::collection::vec(sensor_track(400e3), 1..8), barometric in any::<bool>(),
    ) {
        for table in registry::editions(21) {
            Case { world, height: height(barometric), table }.run(&tracks);
        }
    }
}

#[test]
fn a_radar_refuses_what_lies_beyond_its_items() {
    let world = World::simple(52.0, 13.0);
    let table = registry::default_edition(48).unwrap();
    let mut sender = SensorReports::new(table, 7, 9, world.sensor, world.system, 1400).unwrap();
    for (number, x_m) in [(1, 473e3), (2, 475e3), (3, f64::NAN)] {
        let track = SensorTrack {
            track_number: number,
            position_m: [x_m, 0.0, -17e3],
            state: TrackState::Confirmed as u8,
            ..SensorTrack::default()
        };
        let found = send_one(&mut sender, table, &track);
        assert_eq!(found.len(), usize::from(number == 1), "256 NM are 474.1 km");
    }
    assert_eq!((sender.counts().refused_position, sender.counts().refused()), (2, 2));
}

#[test]
fn simulated_reports_are_marked_where_asked_for() {
    let world = World::simple(52.0, 13.0);
    for (number, path) in [
        (48, ["020", "SIM"]),
        (20, ["020", "SIM"]),
        (10, ["020", "SIM"]),
        (21, ["040", "SIM"]),
    ] {
        for table in registry::editions(number) {
            let sender = SensorReports::new(table, 7, 9, world.sensor, world.system, 1400).unwrap();
            let mut sender = sender.marked_simulated();
            let mut track = SensorTrack {
                state: TrackState::Confirmed as u8,
                ..SensorTrack::default()
            };
            track.identity = track.identity.with_address(1);
            let found = send_one(&mut sender, table, &track);
            Sent {
                record: &found[0],
                table,
            }
            .is(&path, 1u64);
        }
    }
}

#[test]
fn what_can_not_be_sent_is_named_with_what_can() {
    let world = World::simple(52.0, 13.0);
    let sender = |table, octets| SensorReports::new(table, 7, 9, world.sensor, world.system, octets).map(|_| ());
    let status = registry::default_edition(63).unwrap();
    let error = sender(status, 1400).unwrap_err();
    assert_eq!(
        error.to_string(),
        "CAT063 ed 1.6 can not be sent here; choose one of CAT048, CAT020, CAT021 and CAT010"
    );
    let radar = registry::default_edition(48).unwrap();
    for octets in [0, 147, 65_536] {
        let error = sender(radar, octets).unwrap_err();
        assert_eq!(error, OutgoingError::BlockSize { octets });
        assert!(error.to_string().contains("choose 148 to 65535"), "{error}");
    }
    assert_eq!((sender(radar, 148), sender(radar, 65_535)), (Ok(()), Ok(())));
}

#[test]
fn a_radars_plot_has_neither_number_nor_track() {
    let world = World::simple(45.0, 10.0);
    let place = world.sensor.slant(50_000.0, 1.0, 3000.0);
    for table in registry::REGISTRY.iter().copied().filter(|table| table.number == 48) {
        let mut sender = SensorReports::new(table, 7, 9, world.sensor, world.system, 1400).unwrap();
        let mut sent = Vec::new();
        for height_known in [true, false] {
            sender.plot(43_200_000_000_000, place, height_known, &mut |block| {
                sent.extend_from_slice(block)
            });
        }
        sender.flush(&mut |block| sent.extend_from_slice(block));
        let found = records(table, &sent);
        assert_eq!(found.len(), 2, "{table}");
        for (record, height_known) in found.iter().zip([true, false]) {
            let sent = Sent { record, table };
            assert!(
                (sent.quantity(&["040", "RHO"]) * NM_M - 50_000.0).abs() < 4.0,
                "{table}"
            );
            assert!(
                (sent.quantity(&["040", "THETA"]).to_radians() - 1.0).abs() < 1e-4,
                "{table}"
            );
            assert_eq!(sent.has(&["090"]), height_known);
            assert!(!sent.has(&["161"]) && !sent.has(&["042"]), "{table}");
            sent.is(&["020", "TYP"], if height_known { 2u64 } else { 1 });
        }
    }
    let table = registry::default_edition(20).unwrap();
    let mut sender = SensorReports::new(table, 7, 9, world.sensor, world.system, 1400).unwrap();
    sender.plot(0, place, true, &mut |_| panic!("multilateration has no plots"));
    assert_eq!(sender.counts().withheld, 1);
}
