//! Events of Cursor on Target in a stream.
//!
//! The first byte selects where the stream is divided. A division must not change the messages or the counts; each
//! event is counted once, and no value is given that is not finite.

#![no_main]

use formats::cot_events::{CotReader, CotSettings};
use libfuzzer_sys::fuzz_target;

const SETTINGS: CotSettings = CotSettings { things_max: 4 };

fuzz_target!(|input: &[u8]| {
    let Some((&choice, octets)) = input.split_first() else {
        return;
    };
    let cut = octets.len() * usize::from(choice) / 256;
    let (mut whole, mut divided) = (CotReader::new(SETTINGS), CotReader::new(SETTINGS));
    let (mut found, mut parts) = (Vec::new(), Vec::new());
    whole.take(octets, |message| found.push(message));
    whole.end();
    divided.take(&octets[..cut], |message| parts.push(message));
    divided.take(&octets[cut..], |message| parts.push(message));
    divided.end();
    assert_eq!(found, parts);
    assert_eq!(whole.counters(), divided.counters());
    let counters = whole.counters();
    let given = counters.observations + counters.repetitions + counters.without_position + counters.others;
    assert_eq!(given + counters.refused.iter().sum::<u64>(), counters.events);
    for message in &found {
        let observation = message.observation.unwrap_or_default();
        let pairs = observation.geodetic.into_iter().chain(observation.velocity).flatten();
        let heights = observation
            .ellipsoid_height_m
            .into_iter()
            .chain(observation.vertical_rate_mps);
        assert!(pairs.chain(heights).all(f64::is_finite));
    }
});
