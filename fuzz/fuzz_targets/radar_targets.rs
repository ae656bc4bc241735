//! Lines with the targets of ships' radars.
//!
//! The first byte selects whether the radar's place is known, and the time between lines. Each line must be counted
//! once, positions must be on the globe, and velocities finite.

#![no_main]

use formats::nmea::{RadarTargetReader, RadarTargetSettings};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let Some((&choice, bytes)) = input.split_first() else {
        return;
    };
    let mut reader = RadarTargetReader::new(RadarTargetSettings {
        place_deg: (choice & 1 != 0).then_some([54.0, 179.9]),
        sigma: None,
    });
    let mut lines = 0;
    for line in bytes.split(|octet| *octet == b'\n') {
        lines += 1;
        let received_ns = 1_700_000_000_000_000_000 + lines * i64::from(choice >> 2) * 100_000_000;
        let received_ns = (choice & 2 != 0).then_some(received_ns);
        if let Ok(Some(found)) = reader.take(line, received_ns) {
            assert!(found.velocity.unwrap_or_default().iter().all(|speed| speed.is_finite()));
            if let Some([latitude, longitude]) = found.geodetic {
                assert!(latitude.abs() <= std::f64::consts::FRAC_PI_2 && longitude.abs() <= std::f64::consts::PI);
            }
        }
    }
    let counters = reader.counters();
    let taken = counters.targets + counters.ended + counters.without_position + counters.repeats;
    let taken = taken + counters.own + counters.others;
    assert_eq!(taken + counters.rejected.iter().sum::<u64>(), lines as u64);
});
