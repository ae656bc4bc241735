//! Lines of single messages and packs.

use base64::Engine as _;
use observations::{Emergency, Quality, TargetCategory};
use proptest::prelude::*;

use super::*;
use crate::target_message::{TargetMessage, number_of_name};

/// 2024-06-06 08:58:39.1 UTC.
const TIME_S: f64 = 1_717_664_319.1;
const MS: i64 = 1_000_000;
const SERIAL: &str = "1581F45T7228900AB123";

fn reader() -> RemoteIdReader {
    RemoteIdReader::new(RemoteIdSettings { drones_max: 3 })
}

fn take(reader: &mut RemoteIdReader, line: &str) -> Vec<TargetMessage> {
    let mut found = Vec::new();
    reader.take(line.as_bytes(), |message| found.push(message));
    found
}

fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect()
}

fn line(time_s: f64, mac: &str, octets: &[u8]) -> String {
    format!(
        "{{\"time\":{time_s},\"receiver\":\"rx1\",\"mac\":\"{mac}\",\"payload\":\"{}\"}}",
        hex(octets)
    )
}

fn basic_id(kinds: u8, id: &str) -> [u8; 25] {
    let mut message = [0; 25];
    message[..2].copy_from_slice(&[0x02, kinds]);
    message[2..2 + id.len()].copy_from_slice(id.as_bytes());
    message
}

/// Airborne at 51.5°, -1.25° with 10 m/s to 270°, climbing, at 08:58:38.9.
fn location() -> [u8; 25] {
    let mut message = [0; 25];
    message[..5].copy_from_slice(&[0x12, 0x22, 90, 40, 5]);
    message[5..9].copy_from_slice(&515_000_000i32.to_le_bytes());
    message[9..13].copy_from_slice(&(-12_500_000i32).to_le_bytes());
    message[13..15].copy_from_slice(&2200u16.to_le_bytes());
    message[15..17].copy_from_slice(&2300u16.to_le_bytes());
    message[19..21].copy_from_slice(&[0x5a, 0x03]);
    message[21..23].copy_from_slice(&35_189u16.to_le_bytes());
    message
}

fn system(latitude: i32, longitude: i32) -> [u8; 25] {
    let mut message = [0; 25];
    message[..2].copy_from_slice(&[0x42, 0x05]);
    message[2..6].copy_from_slice(&latitude.to_le_bytes());
    message[6..10].copy_from_slice(&longitude.to_le_bytes());
    message
}

fn pack(messages: &[[u8; 25]]) -> Vec<u8> {
    let mut octets = vec![0xf2, 25, messages.len() as u8];
    octets.extend(messages.as_flattened());
    octets
}

fn is_whole(counters: &RemoteIdCounters, lines: u64) {
    assert_eq!(counters.lines + counters.refused_lines, lines);
    let kinds = [
        counters.identities,
        counters.locations,
        counters.systems,
        counters.others,
        counters.refused_messages,
    ];
    assert_eq!(kinds.iter().sum::<u64>(), counters.messages);
    let locations = counters.observations + counters.repetitions + counters.without_position;
    assert_eq!(locations, counters.locations);
    let refused: u64 = counters.refused.iter().sum();
    assert_eq!(refused, counters.refused_lines + counters.refused_messages);
}

#[test]
fn a_pack_has_identity_position_and_operator() {
    let mut reader = reader();
    // The identity serves, although it comes last.
    let octets = pack(&[location(), system(514_000_000, -12_000_000), basic_id(0x12, SERIAL)]);
    let text = base64::engine::general_purpose::STANDARD.encode(octets);
    let found = take(&mut reader, &format!("{{\"time\":{TIME_S},\"payload\":\"{text}\"}}"));
    let [message] = found[..] else { panic!("{found:?}") };
    assert_eq!(message.time_ns, 1_717_664_318_900 * MS);
    let observation = message.observation.unwrap();
    assert_eq!(
        observation.time_of_day_ns,
        Some((8 * 3600 + 58 * 60 + 38) * 1000 * MS + 900 * MS)
    );
    assert_eq!(observation.identity.name(), Some(SERIAL));
    assert_eq!(observation.track_number, Some(number_of_name(SERIAL.as_bytes())));
    assert_eq!(
        observation
            .geodetic
            .unwrap()
            .map(|angle| (angle.to_degrees() * 1e6).round()),
        [51_500_000.0, -1_250_000.0]
    );
    let [east, north] = observation.velocity.unwrap();
    assert!((east + 10.0).abs() < 1e-9 && north.abs() < 1e-9);
    assert_eq!(
        (observation.pressure_altitude_m, observation.ellipsoid_height_m),
        (Some(100.0), Some(150.0))
    );
    assert_eq!(
        (observation.vertical_rate_mps, observation.on_ground),
        (Some(2.5), false)
    );
    assert_eq!(observation.quality, Quality::Radius95(10.0));
    assert!(observation.velocity_covariance.is_some());
    let statement = message.statement.unwrap();
    assert_eq!(
        (statement.category, statement.emergency),
        (TargetCategory::Unmanned, Emergency::None)
    );
    assert_eq!(Some(statement.track_number), observation.track_number);
    assert!((statement.operator_rad.unwrap()[0].to_degrees() - 51.4).abs() < 1e-9);
    is_whole(reader.counters(), 1);
}

#[test]
fn single_messages_belong_together_by_their_transmitter() {
    let mut reader = reader();
    let mut take = |after_s: f64, mac: &str, octets: &[u8]| take(&mut reader, &line(TIME_S + after_s, mac, octets));
    let first = take(0.0, "aa:01", &location());
    let by_transmitter = first[0].observation.unwrap();
    assert_eq!(by_transmitter.track_number, Some(number_of_name(b"AA:01")));
    assert_eq!(by_transmitter.identity.name(), None);
    let stated = take(0.1, "AA:01", &basic_id(0x12, SERIAL));
    let statement = stated[0].statement.unwrap();
    assert_eq!(
        (stated[0].observation, statement.category),
        (None, TargetCategory::Unmanned)
    );
    let mut later = location();
    later[21] += 10;
    let found = take(1.0, "aa:01", &later)[0].observation.unwrap();
    assert_eq!(found.track_number, Some(statement.track_number));
    assert_eq!(found.identity.name(), Some(SERIAL));
    // A registration is less lasting than a serial number, and another receiver has the same Location.
    assert_eq!(take(1.1, "aa:01", &basic_id(0x22, "DEU1234")), []);
    assert_eq!(take(1.2, "aa:01", &later), []);
    // The other radio of the same drone.
    take(1.3, "aa:02", &basic_id(0x12, SERIAL));
    assert_eq!(take(1.4, "aa:02", &later), []);
    let counters = reader.counters();
    assert_eq!(
        (counters.observations, counters.repetitions, counters.identities),
        (2, 2, 3)
    );
    is_whole(counters, 7);
}

#[test]
fn unknown_values_are_unknown() {
    let mut reader = reader();
    let mut message = location();
    message[1] = 0x03; // status undeclared, coarse speed, west
    message[2..5].copy_from_slice(&[181, 255, 126]);
    message[13..17].fill(0);
    message[19..21].fill(0);
    message[21..23].fill(0xff);
    let found = take(&mut reader, &line(TIME_S, "aa:01", &message));
    let observation = found[0].observation.unwrap();
    assert_eq!((observation.velocity, observation.vertical_rate_mps), (None, None));
    assert_eq!(
        (observation.pressure_altitude_m, observation.ellipsoid_height_m),
        (None, None)
    );
    assert_eq!(
        (observation.quality, observation.velocity_covariance),
        (Quality::Unknown, None)
    );
    assert_eq!((found[0].time_ns, found[0].statement), (1_717_664_319_100 * MS, None));
    message[5..13].fill(0);
    assert_eq!(take(&mut reader, &line(TIME_S, "aa:01", &message)), []);
    assert_eq!(take(&mut reader, &line(TIME_S, "aa:01", &system(0, 0))), []);
    // No direction, but at rest.
    message[1..4].copy_from_slice(&[0x30, 181, 0]);
    message[5..13].copy_from_slice(&location()[5..13]);
    let found = take(&mut reader, &line(TIME_S + 1.0, "aa:01", &message));
    assert_eq!(found[0].observation.unwrap().velocity, Some([0.0; 2]));
    assert_eq!(found[0].statement.unwrap().emergency, Emergency::General);
    let counters = reader.counters();
    assert_eq!((counters.received_times, counters.without_position), (2, 1));
    is_whole(counters, 4);
}

#[test]
fn the_hour_is_the_nearest_and_a_wrong_clock_is_not_used() {
    // 08:00:00.05, and Locations of the seconds around.
    let hour_s = 1_717_660_800.05;
    for (tenths, expected_ms, received) in [
        (0u16, 1_717_660_800_000, 0),
        (35_995, 1_717_660_799_500, 0),
        (36_000, 1_717_660_800_000, 0),
        (90, 1_717_660_809_000, 0),
        (110, 1_717_660_800_050, 1),
        (35_000, 1_717_660_800_050, 1),
        (36_001, 1_717_660_800_050, 1),
    ] {
        let mut reader = reader();
        let mut message = location();
        message[21..23].copy_from_slice(&tenths.to_le_bytes());
        let found = take(&mut reader, &line(hour_s, "aa:01", &message));
        assert_eq!(found[0].time_ns, expected_ms * MS, "{tenths}");
        assert_eq!(reader.counters().received_times, received);
    }
}

#[test]
fn refusals_are_counted_by_reason_with_the_value() {
    let mut reader = reader();
    let mut beyond = location();
    beyond[5..9].copy_from_slice(&900_000_001i32.to_le_bytes());
    let payload = hex(&location());
    let nested = pack(&[location(), [0xf2; 25]]);
    let lines = [
        ("x".repeat(5000), ["line of \"5000\"", "4096"]),
        (
            "{\"time\":1}".to_owned(),
            ["missing field `payload`", "time and payload"],
        ),
        (
            format!("{{\"time\":-1,\"payload\":\"{payload}\"}}"),
            ["time \"-1\"", "since 1970"],
        ),
        (
            format!("{{\"time\":1,\"payload\":\"{}\"}}", &payload[2..]),
            ["payload", "25 octets"],
        ),
        (
            format!("{{\"time\":1,\"payload\":\"{payload}\"}}"),
            ["message without \"mac\"", "add mac"],
        ),
        (line(TIME_S, "aa", &[0x62; 25]), ["type \"6\"", "0 to 5"]),
        (line(TIME_S, "aa", &nested), ["type \"15\"", "no other pack"]),
        (
            line(TIME_S, "aa", &beyond),
            ["position \"90.0000001 -1.25\"", "-90 to 90"],
        ),
        (
            line(TIME_S, "aa", &basic_id(0x12, "AB\u{1b}[2J")),
            ["AB\\\\x1b", "printable"],
        ),
        (line(TIME_S, "aa", &pack(&[])), ["F21900", "one to nine"]),
    ];
    for (line, words) in &lines {
        let _ = take(&mut reader, line);
        let text = reader.refused().unwrap().to_string();
        assert!(words.iter().all(|words| text.contains(words)), "{text}");
    }
    let of_each = reader.counters().refused;
    assert!(
        RemoteIdReason::ALL
            .iter()
            .all(|reason| of_each[*reason as usize] > 0 || *reason == RemoteIdReason::Room)
    );
    is_whole(reader.counters(), lines.len() as u64);
}

#[test]
fn a_full_table_refuses_further_drones() {
    let mut reader = reader();
    let mut count = |after_s: f64, mac: &str| take(&mut reader, &line(TIME_S + after_s, mac, &location())).len();
    assert_eq!(
        [count(0.0, "1"), count(0.0, "2"), count(0.0, "3"), count(1.0, "4")],
        [1, 1, 1, 0]
    );
    assert_eq!(count(62.0, "4"), 1);
    assert_eq!(reader.counters().refused[RemoteIdReason::Room as usize], 1);
    is_whole(reader.counters(), 5);
}

proptest! {
    #[test]
    fn any_octets_are_counted_once(line in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut reader = reader();
        reader.take(&line, |_| {});
        is_whole(reader.counters(), 1);
    }

    #[test]
    fn any_messages_are_counted_once_and_give_numbers_only(
        messages in prop::collection::vec((0u8..7, prop::array::uniform25(any::<u8>())), 1..12),
        macs in prop::collection::vec(0u8..5, 1..20),
        time_s in 0.0..8e9,
    ) {
        let mut reader = reader();
        let messages: Vec<_> = messages.into_iter().map(|(kind, mut message)| {
            message[0] = kind << 4;
            message
        }).collect();
        let mut lines = 0;
        for (place, mac) in macs.iter().enumerate() {
            let octets = match messages.get(place) {
                Some(message) => message.to_vec(),
                None => pack(&messages),
            };
            lines += 1;
            for message in take(&mut reader, &line(time_s, ["", "a", "b", "c", "d"][usize::from(*mac)], &octets)) {
                prop_assert!(message.observation.is_some() || message.statement.is_some());
                let observation = message.observation.unwrap_or_default();
                let values = observation.geodetic.into_iter().chain(observation.velocity).flatten();
                prop_assert!(values.chain(observation.pressure_altitude_m).all(f64::is_finite));
            }
        }
        is_whole(reader.counters(), lines);
    }
}
