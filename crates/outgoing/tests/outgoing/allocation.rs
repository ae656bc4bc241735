//! Sending does not allocate once every table and buffer has been made.

use std::hint::black_box;

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use asterix::registry;
use deployment::Technology;
use messages::{Contribution, SensorTrack, SystemTrack, TrackState, contribution_bits};
use outgoing::{SensorReports, StatusReports, SystemReports, SystemSource, SystemStatus};

use crate::model::World;
use test_support::S;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

/// More tracks than there is room for at a time, so that numbers are given, rest and come back.
const TRACKS: u32 = 30_000;

/// Whatever is done with a block.
fn take(block: &[u8]) {
    black_box(block.len());
}

fn system_track(number: u32, state: TrackState) -> SystemTrack {
    let mut track = SystemTrack {
        track_number: number,
        reference_time_ns: i64::from(number) * S / 50,
        position_m: [f64::from(number), -2.0 * f64::from(number), 3000.0],
        velocity_mps: [100.0, -20.0, 3.0],
        covariance: messages::Covariance::diagonal([10.0; 3], [1.0; 3]),
        state: state as u8,
        height_valid: 1,
        velocity_valid: 1,
        contribution_count: 1,
        source_count: 1,
        alerts: number as u8,
        ..SystemTrack::default()
    };
    track.contributions[0] = Contribution {
        time_of_measurement_ns: track.reference_time_ns - S,
        source: 1,
        flags: contribution_bits::FRESH,
        ..Contribution::default()
    };
    track.identity = track
        .identity
        .with_address(number)
        .with_callsign(*b"KSK123  ")
        .with_mode_3a(0o1234);
    track
}

fn sensor_track(number: u32, state: TrackState) -> SensorTrack {
    let system = system_track(number, state);
    SensorTrack {
        track_number: number,
        time_of_measurement_ns: system.reference_time_ns,
        identity: system.identity,
        position_m: system.position_m,
        measured_m: system.position_m,
        velocity_mps: system.velocity_mps,
        covariance: system.covariance,
        state: system.state,
        alerts: system.alerts,
        valid: u16::MAX,
        ..SensorTrack::default()
    }
}

/// Calls `report` with every state of every track; a track ends when the next begins.
fn lives(range: std::ops::Range<u32>, mut report: impl FnMut(u32, TrackState)) {
    for number in range {
        report(number, TrackState::Tentative);
        report(number, TrackState::Confirmed);
        report(number, TrackState::Coasted);
        report(number, TrackState::Terminated);
    }
}

#[test]
fn sending_system_tracks_does_not_allocate() {
    let world = World::simple(52.0, 13.0);
    let sources = [SystemSource {
        number: 1,
        technology: Technology::ModeS,
        code: Some([1, 3]),
    }];
    for table in registry::editions(62) {
        let mut sender = SystemReports::new(table, 1, 2, world.system, &sources, 1400).unwrap();
        let mut report = |number, state| sender.report(&system_track(number, state), &mut take);
        lives(0..100, &mut report);
        assert_no_alloc(|| lives(100..TRACKS, &mut report));
        let counts = sender.counts();
        assert_eq!(
            (counts.records, counts.refused()),
            (3 * u64::from(TRACKS), 0),
            "{table}"
        );
    }
}

#[test]
fn sending_sensor_tracks_does_not_allocate() {
    let world = World::simple(52.0, 13.0);
    for table in [48, 20, 21, 10].into_iter().flat_map(registry::editions) {
        let mut sender = SensorReports::new(table, 1, 2, world.sensor, world.system, 1400).unwrap();
        let mut report = |number, state| {
            sender.report(&sensor_track(number, state), &mut take);
            if number.is_multiple_of(100) {
                sender.status(i64::from(number) * S / 50, &mut take);
                sender.sector(i64::from(number) * S / 50, 1.0, &mut take);
            }
        };
        lives(0..100, &mut report);
        assert_no_alloc(|| lives(100..10_000, &mut report));
        assert!(sender.counts().records > 10_000, "{table}: {:?}", sender.counts());
    }
}

#[test]
fn sending_status_does_not_allocate() {
    let [of_system, of_sensors] = [65, 63].map(|number| registry::default_edition(number).unwrap());
    let mut sender = StatusReports::new(of_system, of_sensors, 1, 2, 1400).unwrap();
    let mut send = || {
        sender.system(S, SystemStatus::default(), &mut take);
    };
    send();
    send();
    assert_no_alloc(send);
}
