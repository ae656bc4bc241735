//! Frames of Mode S in a stream.
//!
//! The first byte selects where the stream is divided, and whether times of receipt are known. A division must not
//! change the outputs or the counts, each frame is counted once, and no value may be one that is not finite.

#![no_main]

use formats::mode_s::{FrameReader, ModeSReader, ModeSSettings, ModeSValue, ReceiverRange};
use libfuzzer_sys::fuzz_target;

const SETTINGS: ModeSSettings = ModeSSettings {
    start_utc_ns: 1_700_000_000_000_000_000,
    receiver: Some(ReceiverRange {
        place_deg: [52.0, 4.4],
        range_m: 740_800.0,
    }),
    aircraft_max: 8,
};

fuzz_target!(|input: &[u8]| {
    let Some((&choice, bytes)) = input.split_first() else {
        return;
    };
    let received_ns = (choice & 1 == 0).then_some(SETTINGS.start_utc_ns);
    let cut = bytes.len() * usize::from(choice) / 256;
    let (mut whole, mut divided) = (ModeSReader::new(SETTINGS), ModeSReader::new(SETTINGS));
    let (mut outputs, mut found, mut frames) = (Vec::new(), Vec::new(), 0);
    whole.take(bytes, received_ns, &mut |output| outputs.push(output));
    divided.take(&bytes[..cut], received_ns, &mut |output| found.push(output));
    divided.take(&bytes[cut..], received_ns, &mut |output| found.push(output));
    assert_eq!(outputs, found);
    assert_eq!(whole.counters(), divided.counters());
    FrameReader::default().take(bytes, &mut |_| frames += 1);
    let counters = whole.counters();
    assert_eq!(counters.accepted + counters.other + counters.refused_sum(), frames);
    for output in outputs {
        let ModeSValue::Observation(observation) = output.value else {
            continue;
        };
        let pairs = [observation.geodetic, observation.velocity];
        let numbers = [
            observation.pressure_altitude_m,
            observation.ellipsoid_height_m,
            observation.vertical_rate_mps,
        ];
        assert!(
            pairs
                .iter()
                .flatten()
                .flatten()
                .chain(numbers.iter().flatten())
                .all(|value| value.is_finite())
        );
    }
});
