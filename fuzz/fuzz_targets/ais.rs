//! Lines of AIS receivers.
//!
//! The first byte selects the time between lines and the number of connections. Each line must be counted once,
//! positions must be on the globe, and values finite.

#![no_main]

use formats::ais::{AisOutput, AisReader, AisSettings};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let Some((&choice, bytes)) = input.split_first() else {
        return;
    };
    let mut reader = AisReader::new(AisSettings { stations_max: 4 });
    let mut lines = 0;
    for line in bytes.split(|octet| *octet == b'\n') {
        lines += 1;
        let received_ns = 1_700_000_000_000_000_000 + lines * i64::from(choice >> 2) * 100_000_000;
        let connection = lines as u32 % u32::from((choice & 3) + 1);
        let _ = reader.take(connection, line, received_ns, |_, output| {
            let [latitude, longitude] = match output {
                AisOutput::Target(found) | AisOutput::OwnShip(found) => {
                    let velocity_mps = found.velocity.unwrap_or_default();
                    assert!(velocity_mps.iter().all(|speed| speed.abs() < 1000.0));
                    found.geodetic.unwrap()
                }
                AisOutput::Statement(statement) => {
                    let size_m = statement.size_m.unwrap_or_default();
                    assert!(size_m.iter().all(|metres| (0.0..=500.0).contains(metres)));
                    statement.station.map_or([0.0; 2], |station| station.place_rad)
                }
            };
            assert!(latitude.abs() <= std::f64::consts::FRAC_PI_2 && longitude.abs() <= std::f64::consts::PI);
        });
    }
    let counters = reader.counters();
    let taken = counters.messages + counters.parts + counters.repeats + counters.others;
    assert_eq!(taken + counters.rejected.iter().sum::<u64>(), lines as u64);
});
