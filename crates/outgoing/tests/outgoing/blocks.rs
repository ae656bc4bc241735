//! Blocks: sizes, and nothing lost between them.

use asterix::{Category, NamedRecord, registry};
use messages::{SensorTrack, SystemTrack, TrackState};
use outgoing::{BLOCK_OCTETS_LEAST, SensorReports, SystemReports};
use proptest::prelude::*;

use crate::model::{World, sensor_track, system_track, world};
use crate::reading::records;

/// The blocks of `send`, which reports everything and flushes.
fn check_blocks(
    table: &'static Category,
    octets_max: usize,
    send: impl FnOnce(&mut dyn FnMut(&[u8])) -> (u64, u64),
) -> Vec<NamedRecord> {
    let mut blocks: Vec<Vec<u8>> = vec![];
    let (sent_records, sent_blocks) = send(&mut |block| blocks.push(block.to_vec()));
    assert!(blocks.iter().all(|block| block.len() <= octets_max));
    let found: Vec<Vec<NamedRecord>> = blocks.iter().map(|block| records(table, block)).collect();
    assert!(found.iter().all(|records| !records.is_empty()));
    // None is smaller than it must be: the next block's records would not all have fitted.
    for pair in blocks.windows(2) {
        assert!(pair[0].len() + pair[1].len() - 3 > octets_max);
    }
    let found = found.concat();
    assert_eq!((found.len() as u64, blocks.len() as u64), (sent_records, sent_blocks));
    found
}

fn send_system(world: &World, table: &'static Category, tracks: &[SystemTrack], octets_max: usize) -> Vec<NamedRecord> {
    check_blocks(table, octets_max, |send| {
        let mut sender = SystemReports::new(table, 1, 2, world.system, &[], octets_max)
            .unwrap()
            .with_tentative()
            .with_service(3);
        tracks.iter().for_each(|track| sender.report(track, send));
        sender.flush(send);
        sender.flush(send);
        (sender.counts().records, sender.counts().blocks)
    })
}

fn send_sensor(world: &World, table: &'static Category, tracks: &[SensorTrack], octets_max: usize) -> Vec<NamedRecord> {
    check_blocks(table, octets_max, |send| {
        let mut sender = SensorReports::new(table, 1, 2, world.sensor, world.system, octets_max).unwrap();
        tracks.iter().for_each(|track| sender.report(track, send));
        sender.flush(send);
        (sender.counts().records, sender.counts().blocks)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Blocks never exceed their size, whatever it is, and the records in them are the same.
    #[test]
    fn blocks_keep_to_their_size_and_lose_nothing(
        world in world(), octets_max in BLOCK_OCTETS_LEAST..1500,
        system in prop::collection::vec(system_track(), 1..40), sensor in prop::collection::vec(sensor_track(200e3), 1..40),
    ) {
        for table in registry::editions(62) {
            let small = send_system(&world, table, &system, octets_max);
            prop_assert_eq!(small, send_system(&world, table, &system, 65_535));
        }
        for table in [48, 20, 21, 10].into_iter().flat_map(registry::editions) {
            let small = send_sensor(&world, table, &sensor, octets_max);
            prop_assert_eq!(small, send_sensor(&world, table, &sensor, 65_535));
        }
    }
}

/// A track of which everything is known, so that its record is as long as it can be.
#[test]
fn the_longest_record_of_every_edition_fits_the_least_block() {
    let world = World::simple(45.0, 11.25);
    let identity = messages::Identity::default()
        .with_address(0xABCDEF)
        .with_mode_3a(0o7777)
        .with_callsign(*b"ABCDEFGH");
    let covariance = messages::Covariance::diagonal([10.0; 3], [1.0; 3]);
    let system = SystemTrack {
        track_number: 1,
        identity,
        covariance,
        velocity_mps: [100.0, 100.0, 10.0],
        state: TrackState::Coasted as u8,
        height_valid: 1,
        velocity_valid: 1,
        on_ground: 1,
        alerts: u8::MAX,
        ..SystemTrack::default()
    };
    let sensor = SensorTrack {
        track_number: 1,
        identity,
        covariance,
        velocity_mps: [100.0, 100.0, 10.0],
        position_m: [1000.0, 1000.0, 100.0],
        measured_m: [1000.0, 1000.0, 100.0],
        state: TrackState::Confirmed as u8,
        valid: u16::MAX,
        alerts: u8::MAX,
        ..SensorTrack::default()
    };
    for table in registry::editions(62) {
        assert_eq!(send_system(&world, table, &[system], BLOCK_OCTETS_LEAST).len(), 1);
    }
    for table in [48, 20, 21, 10].into_iter().flat_map(registry::editions) {
        assert_eq!(send_sensor(&world, table, &[sensor], BLOCK_OCTETS_LEAST).len(), 1);
    }
}
