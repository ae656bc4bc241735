//! Datagrams of array snapshots, one after the other, up to bearings.
//!
//! The input is a row of datagrams, each behind its length in two bytes. A datagram that is read is written again to
//! the same bytes, and no bearing may have a value that is not finite.

#![no_main]

use formats::snapshot_datagram::{decode, encode};
use libfuzzer_sys::fuzz_target;
use locating::music::{ArraySettings, ElementPosition};
use observations::SnapshotBlock;
use sources::SnapshotIntake;

fuzz_target!(|input: &[u8]| {
    let antenna = |place: u8| ElementPosition {
        right_m: 0.1 * f64::from(place),
        forward_m: 0.05 * f64::from(place % 2),
    };
    let settings = ArraySettings {
        antennas: (0..3).map(antenna).collect(),
        frequency_max_hz: 1e9,
        paths: 2,
        ..ArraySettings::default()
    };
    let mut intake = SnapshotIntake::new(&settings).expect("usable");
    let (mut rest, mut block) = (input, SnapshotBlock::default());
    while let Some((length, bytes)) = rest.split_first_chunk::<2>() {
        let (datagram, behind) = bytes.split_at(bytes.len().min(usize::from(u16::from_le_bytes(*length))));
        rest = behind;
        if decode(datagram, &mut block).is_err() {
            continue;
        }
        let mut again = Vec::new();
        encode(&block, &mut again);
        assert_eq!(again, datagram);
        intake.take(&block, 0, true, |measurement| {
            for bearing in &measurement.bearings {
                assert!(bearing.bearing_rad.is_finite() && bearing.sigma_rad > 0.0);
            }
            if let Some(spectrum) = &measurement.spectrum {
                assert!(spectrum.spectrum_db.iter().all(|value| value.is_finite()));
            }
        });
    }
});
