//! Sentences of NMEA 0183 in a stream.
//!
//! The first byte selects where the stream is divided, and whether times of receipt are known. A division must not
//! change the states or the counts, and no state may have a value that is not finite.

#![no_main]

use formats::nmea::{NmeaReader, NmeaSettings};
use libfuzzer_sys::fuzz_target;

const SETTINGS: NmeaSettings = NmeaSettings {
    receipt_sigma_s: 0.05,
    heading_sigma_rad: 0.01,
};

fuzz_target!(|input: &[u8]| {
    let Some((&choice, bytes)) = input.split_first() else {
        return;
    };
    let received_ns = (choice & 1 == 0).then_some(1_700_000_000_000_000_000);
    let cut = bytes.len() * usize::from(choice) / 256;
    let (mut whole, mut divided) = (NmeaReader::new(SETTINGS), NmeaReader::new(SETTINGS));
    let (mut states, mut found) = (Vec::new(), Vec::new());
    whole.take(bytes, received_ns, |state| states.push(state));
    divided.take(&bytes[..cut], received_ns, |state| found.push(state));
    divided.take(&bytes[cut..], received_ns, |state| found.push(state));
    assert_eq!(states, found);
    assert_eq!(whole.counts(), divided.counts());
    for state in &states {
        let tilt = state.tilt_rad.unwrap_or_default();
        let velocity = state.velocity_mps.unwrap_or_default();
        let heading = [state.heading_rad.unwrap_or_default()];
        assert!(
            tilt.iter()
                .chain(&velocity)
                .chain(&heading)
                .all(|value| value.is_finite())
        );
    }
});
