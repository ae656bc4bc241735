//! Who a target is, through every stage: sensor tracks, fusion, system tracks, and each form in which these leave.

use std::collections::{BTreeMap, BTreeSet};

use asterix::{Mode, NamedRecord, Value as ItemValue, blocks, registry};
use formats::sensor_tracks_csv::SensorTrackWriter;
use fusion::Engine;
use fusion::settings::{Accuracy, Capacity, Settings, SourceSettings};
use messages::layout::Sample as _;
use messages::{Covariance, Identity, IdentityText, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use outgoing::SystemReports;
use sample_text::{LineFormat, LineReader, LineWriter, SampleNames};
use test_support::{Random, S};

use crate::common::{Folder, system};

const TARGETS: u32 = 2000;
/// Targets stand so far apart.
const STEP_M: f64 = 4e3;
const SECONDS: u32 = 12;

/// Ships and aircraft at random. Among them are pairs of ships whose numbers have the same low 24 bits, aircraft with
/// these bits as their address, and the least and largest numbers.
fn identities() -> Vec<Identity> {
    let mut random = Random::new(23);
    let none = Identity::default();
    let mut all = vec![
        none.with_mmsi(227_000_000),
        none.with_mmsi(227_000_000 - (1 << 24)),
        none.with_address(227_000_000),
        none.with_mmsi(1),
        none.with_mmsi(999_999_999),
        none.with_mmsi(0x00ff_ffff),
        none.with_address(1),
        none.with_address(0x00ff_fffe),
    ];
    let mut known: BTreeSet<_> = all.iter().map(Identity::unique_number).collect();
    while all.len() < TARGETS as usize {
        let number = (random.unit() * 1e9) as u32;
        let identity = match random.unit() < 0.6 {
            true => none.with_mmsi(number),
            false => none.with_address(number),
        };
        if known.insert(identity.unique_number()) {
            all.push(identity);
        }
    }
    let named = |(place, identity): (usize, Identity)| match identity.mmsi() {
        Some(_) if place % 3 > 0 => identity.with_name(&format!("SHIP {place}")),
        Some(_) => identity,
        None => identity.with_callsign(*b"KOS1    ").with_mode_3a(place as u16 & 0o7777),
    };
    all.into_iter().enumerate().map(named).collect()
}

/// Reports of two sources: the first knows who the targets are, the second sees them.
fn reports(identities: &[Identity]) -> Vec<SensorTrack> {
    let mut all = Vec::new();
    for second in 0..SECONDS {
        for source in 0..2_u16 {
            for (number, identity) in (1..).zip(identities) {
                let (column, row) = (f64::from(number % 50), f64::from(number / 50));
                let time_s = f64::from(second) + 0.4 * f64::from(source) + 1e-4 * f64::from(number);
                let velocity_mps = [10.0 * column.cos(), 10.0 * column.sin(), 0.0];
                all.push(SensorTrack {
                    time_of_measurement_ns: (time_s * S as f64) as i64,
                    source,
                    track_number: number,
                    valid: sensor_track_bits::VELOCITY | sensor_track_bits::OWN_COVARIANCE,
                    identity: if source == 0 { *identity } else { Identity::default() },
                    position_m: [
                        STEP_M * (column - 25.0) + velocity_mps[0] * time_s,
                        STEP_M * (row - 20.0) + velocity_mps[1] * time_s,
                        0.0,
                    ],
                    velocity_mps,
                    covariance: Covariance::diagonal([100.0, 100.0, 0.0], [4.0, 4.0, 0.0]),
                    state: TrackState::Confirmed as u8,
                    ..SensorTrack::default()
                });
            }
        }
    }
    all.sort_by_key(|report| report.time_of_measurement_ns);
    all
}

/// The identity in the columns of a table.
fn of_columns(value: impl Fn(&str) -> String) -> Identity {
    let mut identity = Identity::default();
    for text in IdentityText::ALL {
        let written = value(text.key);
        if !written.is_empty() {
            assert_eq!(written.len(), text.digits, "{written}");
            identity = text.set(identity, text.read(&written).unwrap());
        }
    }
    let callsign = value("callsign");
    if !callsign.is_empty() {
        identity = identity.with_callsign(format!("{callsign:8}").into_bytes().try_into().unwrap());
    }
    let name = value("name");
    match name.is_empty() {
        true => identity,
        false => identity.with_name(&name),
    }
}

/// The identities in the rows of a table of system tracks, by track number.
fn of_table(table: &str, number: &str) -> BTreeMap<u32, Identity> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let head = reader.headers().unwrap().clone();
    let place = |name: &str| {
        head.iter()
            .position(|column| column == name)
            .unwrap_or_else(|| panic!("{name}"))
    };
    let rows = reader.records().map(Result::unwrap);
    rows.map(|row| {
        let identity = of_columns(|name| row[place(name)].to_owned());
        (row[place(number)].parse().unwrap(), identity)
    })
    .collect()
}

/// Compares the identities of tracks, in any order, with those of the targets.
fn assert_all<'a>(found: impl IntoIterator<Item = &'a Identity>, expected: &[Identity], of: &str) {
    let sorted = |mut all: Vec<Identity>| {
        all.sort_by_key(Identity::unique_number);
        all
    };
    let found = sorted(found.into_iter().copied().collect());
    let expected = sorted(expected.to_vec());
    assert_eq!(found.len(), expected.len(), "{of}");
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found, expected, "{of}");
    }
}

/// The last states of the engine, after the reports.
fn fused(reports: &[SensorTrack]) -> Vec<SystemTrack> {
    let source = |name: &str| SourceSettings::of(name, 1.0, Accuracy::constant(10.0));
    let settings = Settings {
        capacity: Capacity {
            system_tracks: Some(2 * TARGETS as usize),
            sensor_tracks: Some(4 * TARGETS as usize),
            ..Capacity::default()
        },
        ..Settings::of(vec![source("ais"), source("radar")])
    };
    let mut engine = Engine::new(settings).unwrap();
    let mut latest: BTreeMap<u32, SystemTrack> = BTreeMap::new();
    for report in reports {
        engine.take(report, &mut |track: &SystemTrack| {
            latest.insert(track.track_number, *track);
        });
    }
    latest
        .into_values()
        .filter(|track| track.state == TrackState::Confirmed as u8)
        .collect()
}

#[test]
fn two_thousand_ships_and_aircraft_stay_what_they_are_through_every_stage() {
    let identities = identities();
    let reports = reports(&identities);
    let tracks = fused(&reports);
    assert_all(tracks.iter().map(|track| &track.identity), &identities, "fusion");
    assert!(tracks.iter().all(|track| track.contributions().len() == 2));
    // Tables of the recorder, and of programs in Python.
    let frame = system().1;
    let octets = SystemTrack::octets(&tracks);
    let table = recorder::table("SystemTrack", octets, &frame, 0).unwrap();
    assert_all(
        of_table(&table, "system_track_id").values(),
        &identities,
        "table of system tracks",
    );
    let named: Vec<SensorTrack> = reports
        .iter()
        .filter(|report| report.source == 0)
        .take(TARGETS as usize)
        .copied()
        .collect();
    let table = recorder::table("SensorTrack", SensorTrack::octets(&named), &frame, 0).unwrap();
    assert_all(
        of_table(&table, "sensor_track_id").values(),
        &identities,
        "table of sensor tracks",
    );
    // Lines, with words and with numbers, and back.
    let names = || SampleNames::new(vec!["ais".to_owned(), "radar".to_owned()], frame);
    for names in [Some(names()), None] {
        let lines = LineWriter::new(&SystemTrack::LAYOUT, LineFormat::Json, names);
        let reader = LineReader::new(&SystemTrack::LAYOUT, Vec::new());
        let again = tracks.iter().map(|track| {
            let (mut text, mut octets) = (Vec::new(), SystemTrack::octets(&[SystemTrack::default()]).to_vec());
            lines.write(SystemTrack::octets(&[*track]), &mut text);
            reader
                .read(&serde_json::from_slice(&text).unwrap(), &mut octets)
                .unwrap();
            SystemTrack::of_octets(&octets).unwrap().identity
        });
        assert_all(&again.collect::<Vec<_>>(), &identities, "lines of JSON");
    }
    // CAT062 has addresses of aircraft, and never a ship's number.
    for edition in registry::editions(62) {
        let mut sender = SystemReports::new(edition, 1, 2, frame, &[], 1400).unwrap();
        let mut sent = Vec::new();
        for track in &tracks {
            sender.report(track, &mut |block| sent.extend_from_slice(block));
        }
        sender.flush(&mut |block| sent.extend_from_slice(block));
        let mut found = Vec::new();
        let mut records = 0;
        for block in blocks(&sent) {
            for record in block.unwrap().records(edition, Mode::Strict) {
                records += 1;
                let record = NamedRecord::new(&record.unwrap());
                if let Some(ItemValue::Unsigned(address)) = record.get(&["380", "ADR"]) {
                    found.push(*address as u32);
                }
            }
        }
        let mut expected: Vec<u32> = identities.iter().filter_map(Identity::address).collect();
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!((records, found), (TARGETS, expected), "{edition}");
    }
}

#[test]
fn files_of_ships_and_aircraft_are_fused_and_read_back() {
    let identities = identities();
    let folder = Folder::new();
    for (source, name) in [(0, "ais.csv"), (1, "radar.csv")] {
        let mut writer = SensorTrackWriter::begin(Vec::new(), 0).unwrap();
        for report in reports(&identities).iter().filter(|report| report.source == source) {
            writer.write(report).unwrap();
        }
        folder.write(name, writer.into_inner());
    }
    folder.succeed("fuse --tracks ais.csv radar.csv --refresh 1 --out fused.csv");
    let fused = folder.read("fused.csv");
    assert_all(of_table(&fused, "system_track_id").values(), &identities, "fused file");
}

#[test]
fn thirty_ships_keep_mmsi_name_and_kind_when_a_radar_sees_them_too() {
    let mut all = identities();
    all.retain(|identity| identity.mmsi().is_some() && identity.name().is_some());
    all.truncate(30);
    let head = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,P00,P01,P02,P03,P04,P05,P11,P12,P13,P14,P15,P22,P23,P24,P25,\
                P33,P34,P35,P44,P45,P55,state,height_valid";
    let row = |sensor: u32, period_s: f64, named: bool| {
        let mut text = format!("{head}{}\n", if named { ",mmsi,name" } else { "" });
        for step in 0..(180.0 / period_s) as u32 {
            let time_s = f64::from(step) * period_s + 0.1 * f64::from(sensor);
            for (number, identity) in (1..).zip(&all) {
                let (x, y) = (
                    3e3 * f64::from(number % 6) + 6.0 * time_s,
                    3e3 * f64::from(number / 6) - 4.0 * time_s,
                );
                let who = match named {
                    true => format!(",{},{}", identity.mmsi().unwrap(), identity.name().unwrap()),
                    false => String::new(),
                };
                text += &format!(
                    "{time_s},{sensor},{number},{x},{y},0,6,-4,0,400,0,0,0,0,0,400,0,0,0,0,1,0,0,0,4,0,0,4,0,1,confirmed,0{who}\n"
                );
            }
        }
        text
    };
    let folder = Folder::new();
    folder.write("ais.csv", row(1, 6.0, true));
    folder.write("radar.csv", row(2, 2.5, false));
    folder.succeed("fuse --tracks ais.csv radar.csv --refresh 2 --out fused.csv");
    let fused = folder.read("fused.csv");
    let expected: Vec<Identity> = all;
    assert_all(of_table(&fused, "system_track_id").values(), &expected, "fused file");
    // In no row is a ship an aircraft.
    let mut reader = csv::Reader::from_reader(fused.as_bytes());
    let head = reader.headers().unwrap().clone();
    let address = head.iter().position(|name| name == "address").unwrap();
    assert!(reader.records().all(|row| row.unwrap()[address].is_empty()));
}
