//! Lines with messages of Remote ID.
//!
//! Each line is read as it is, and as the octets of a payload, so that the decoder of messages is reached at once. Each
//! line and message is counted once, and no value is given that is not finite.

#![no_main]

use std::fmt::Write as _;

use formats::remote_id::{RemoteIdReader, RemoteIdSettings};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let mut reader = RemoteIdReader::new(RemoteIdSettings { drones_max: 4 });
    let mut count = 0;
    for line in input.split(|octet| *octet == b'\n') {
        let mut payload = String::new();
        for octet in line {
            write!(payload, "{octet:02x}").expect("memory can be written");
        }
        let mac = line.first().map_or(0, |octet| octet % 8);
        let whole = format!("{{\"time\":1717664319.1,\"mac\":\"{mac}\",\"payload\":\"{payload}\"}}");
        for line in [line, whole.as_bytes()] {
            count += 1;
            reader.take(line, |message| {
                let observation = message.observation.unwrap_or_default();
                let pairs = observation.geodetic.into_iter().chain(observation.velocity).flatten();
                let heights = observation
                    .pressure_altitude_m
                    .into_iter()
                    .chain(observation.ellipsoid_height_m);
                assert!(pairs.chain(heights).all(f64::is_finite));
            });
        }
    }
    let counters = reader.counters();
    assert_eq!(counters.lines + counters.refused_lines, count);
    let given = counters.observations + counters.repetitions + counters.without_position;
    assert_eq!(given, counters.locations);
});
