//! Writes blocks of made-up tracks, one file for each edition that can be sent: to try other decoders on them.
//!
//! ```text
//! cargo run --release -p outgoing --example send_blocks -- FOLDER
//! ```
//!
//! Prints a line for each file: its name, and CATEGORY=EDITION of the tables it is made with.

use std::error::Error;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use asterix::{Category, registry};
use deployment::Technology;
use frames::{Geodetic, SensorFrame, SystemFrame};
use messages::{Contribution, Covariance, Identity, SensorTrack, SystemTrack, contribution_bits};
use outgoing::{
    Condition, HeightReference, SensorReports, SensorStatus, StatusReports, SystemReports, SystemSource, SystemStatus,
};

/// Tracks in each file.
const TRACKS: u32 = 2000;
const BLOCK_OCTETS_MAX: usize = 1400;
const START_NS: i64 = 20_000 * 86_400_000_000_000 - 60_000_000_000; // a minute before midnight

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder] = arguments.as_slice() else {
        return Err("usage: send_blocks FOLDER".into());
    };
    let system = SystemFrame::at(Geodetic::from_degrees(47.5, 8.5, 400.0)?);
    let sensor = SensorFrame::new(&system, Geodetic::from_degrees(47.8, 8.1, 700.0)?, 0.05);
    let write = |table: &Category, bytes: Vec<u8>, tables: &[&Category]| {
        let name = format!("{:03}_{}.ast", table.number, table.edition);
        let mut choices: Vec<String> = tables
            .iter()
            .map(|table| format!(" {}={}", table.number, table.edition))
            .collect();
        choices.dedup();
        println!("{name}{}", choices.concat());
        fs::write(Path::new(folder).join(name), bytes)
    };
    for table in registry::editions(62) {
        write(table, system_tracks(table, system)?, &[table])?;
    }
    for (number, status) in [(48, 34), (20, 19), (21, 23), (10, 10)] {
        let status = registry::default_edition(status).ok_or("no table for status messages")?;
        for table in registry::editions(number) {
            write(table, sensor_tracks(table, sensor, system)?, &[table, status])?;
        }
    }
    let of_sensors: Vec<&'static Category> = registry::editions(63).collect();
    for (of_system, of_sensors) in registry::editions(65).zip(of_sensors.into_iter().cycle()) {
        write(of_system, status(of_system, of_sensors)?, &[of_system, of_sensors])?;
    }
    Ok(())
}

fn system_tracks(table: &'static Category, system: SystemFrame) -> Result<Vec<u8>, Box<dyn Error>> {
    let kinds = [
        Technology::Primary,
        Technology::Secondary,
        Technology::ModeS,
        Technology::AdsB,
        Technology::Multilateration,
    ];
    let sources: Vec<SystemSource> = (0..)
        .zip(kinds)
        .map(|(number, technology)| SystemSource {
            number,
            technology,
            code: Some([4, number as u8]),
        })
        .collect();
    let mut bytes = vec![];
    for height in [HeightReference::Geometric, HeightReference::Barometric] {
        let mut sender = SystemReports::new(table, 1, 2, system, &sources, BLOCK_OCTETS_MAX)?
            .with_height(height)
            .with_tentative()
            .with_service(3);
        if height == HeightReference::Geometric {
            sender = sender.with_target_identification();
        }
        let mut chance = Chance(u64::from(table.edition.minor));
        for number in 0..TRACKS {
            sender.report(&system_track(number, &mut chance), &mut |block| {
                bytes.extend_from_slice(block)
            });
        }
        sender.flush(&mut |block| bytes.extend_from_slice(block));
    }
    Ok(bytes)
}

fn sensor_tracks(
    table: &'static Category,
    sensor: SensorFrame,
    system: SystemFrame,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = vec![];
    for height in [HeightReference::Geometric, HeightReference::Barometric] {
        let mut sender = SensorReports::new(table, 1, 2, sensor, system, BLOCK_OCTETS_MAX)?.with_height(height);
        let mut chance = Chance(u64::from(table.number) << 8 | u64::from(table.edition.minor));
        for number in 0..TRACKS {
            let track = sensor_track(number, &mut chance);
            sender.report(&track, &mut |block| bytes.extend_from_slice(block));
            if number.is_multiple_of(100) {
                let (now_ns, azimuth_rad) = (track.time_of_measurement_ns, chance.between(0.0, TAU));
                sender.status(now_ns, &mut |block| bytes.extend_from_slice(block));
                sender.sector(now_ns, azimuth_rad, &mut |block| bytes.extend_from_slice(block));
            }
        }
        sender.flush(&mut |block| bytes.extend_from_slice(block));
    }
    Ok(bytes)
}

fn status(of_system: &'static Category, of_sensors: &'static Category) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut sender = StatusReports::new(of_system, of_sensors, 1, 2, BLOCK_OCTETS_MAX)?.with_service(3);
    let mut bytes = vec![];
    let mut send = |block: &[u8]| bytes.extend_from_slice(block);
    let conditions = [
        Condition::Operational,
        Condition::Degraded,
        Condition::Initialising,
        Condition::NotConnected,
    ];
    for (round, condition) in (0..).zip(conditions) {
        let now_ns = START_NS + i64::from(round) * 30_000_000_000;
        let status = SystemStatus {
            condition,
            overloaded: round == 1,
            time_source_invalid: round == 2,
            processing_system: round,
            renumbered: round == 3,
        };
        sender.system(now_ns, status, &mut send);
        let sensors: Vec<SensorStatus> = (0..100)
            .map(|sic| SensorStatus {
                sac: 1,
                sic,
                condition,
                silent: sic % 2 == 0,
                time_source_invalid: sic % 3 == 0,
                ..SensorStatus::default()
            })
            .collect();
        sender.sensors(now_ns, &sensors, &mut send);
    }
    Ok(bytes)
}

fn system_track(number: u32, chance: &mut Chance) -> SystemTrack {
    let track = sensor_track(number, chance);
    let mut system = SystemTrack {
        reference_time_ns: track.time_of_measurement_ns,
        track_number: track.track_number,
        identity: track.identity,
        position_m: track.position_m,
        velocity_mps: track.velocity_mps,
        covariance: track.covariance,
        state: track.state,
        alerts: track.alerts,
        height_valid: u8::from(chance.holds()),
        velocity_valid: 1,
        on_ground: u8::from(chance.holds()),
        source_count: chance.below(4) as u16,
        ..SystemTrack::default()
    };
    system.contribution_count = system.source_count;
    // A last report, mostly with level and code of its own.
    system.trigger_source = chance.below(6) as u16;
    let report_ms = chance.below(9_000) as u32;
    system.time_of_measurement_ns = system.reference_time_ns - i64::from(report_ms) * 1_000_000;
    system.level = chance.below(2_000) as i16 - 50;
    system.level_valid = u8::from(chance.holds());
    let mut age_ms = || {
        if chance.holds() {
            report_ms
        } else {
            chance.below(90_000) as u32
        }
    };
    (system.level_age_ms, system.identity_ages.mode_3a_ms) = (age_ms(), age_ms());
    for index in 0..usize::from(system.source_count) {
        system.contributions[index] = Contribution {
            time_of_measurement_ns: system.reference_time_ns - chance.below(20_000_000_000) as i64,
            source: chance.below(6) as u16,
            flags: if chance.holds() { contribution_bits::FRESH } else { 0 },
            ..Contribution::default()
        };
    }
    if chance.holds() {
        system.climb_rate_mps = chance.between(-30.0, 30.0) as f32;
        system.climb_rate_variance = chance.between(0.1, 9.0) as f32;
    }
    if chance.holds() {
        system.turn_rate_radps = chance.between(-0.05, 0.05) as f32;
        system.turn_rate_sigma_radps = 0.01;
    }
    system
}

/// A track with one of some numbers, so that tracks live on, coast, end and begin again.
fn sensor_track(number: u32, chance: &mut Chance) -> SensorTrack {
    let mut across = |limit: f64| chance.between(-limit, limit);
    let position_m = [across(250e3), across(250e3), across(8000.0) + 7000.0];
    let velocity_mps = [across(300.0), across(300.0), across(30.0)];
    let mut covariance = Covariance::diagonal(
        [0, 1, 2].map(|_| 10f64.powf(chance.between(-1.0, 3.0))),
        [0, 1, 2].map(|_| 10f64.powf(chance.between(-2.0, 1.5))),
    );
    covariance.set(0, 1, 0.5 * (covariance.get(0, 0) * covariance.get(1, 1)).sqrt());
    SensorTrack {
        time_of_measurement_ns: START_NS + i64::from(number) * 61_234_567,
        track_number: 1 + chance.below(300) as u32,
        identity: identity(chance),
        position_m,
        measured_m: position_m.map(|axis| axis + 10.0),
        velocity_mps,
        covariance,
        state: [1, 1, 1, 1, 0, 2, 2, 3][chance.below(8) as usize],
        alerts: if chance.holds() { chance.below(256) as u8 } else { 0 },
        valid: chance.below(256) as u16,
        ..SensorTrack::default()
    }
}

fn identity(chance: &mut Chance) -> Identity {
    let mut identity = Identity::default();
    if chance.holds() {
        identity = identity.with_address(chance.below(1 << 24) as u32);
    }
    if chance.holds() {
        identity = identity.with_mode_3a(chance.below(0o10000) as u16);
    }
    if chance.holds() {
        let mut call_sign = *b"KSK     ";
        let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
        let length = 4 + chance.below(5) as usize;
        call_sign[3..length].fill_with(|| alphabet[chance.below(36) as usize]);
        identity = identity.with_callsign(call_sign);
    }
    identity
}

/// Numbers by chance, the same in every run: SplitMix64.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    fn holds(&mut self) -> bool {
        self.below(2) == 1
    }

    fn between(&mut self, least: f64, greatest: f64) -> f64 {
        least + (greatest - least) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}
