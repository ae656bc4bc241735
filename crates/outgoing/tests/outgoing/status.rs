//! CAT063, 065, 034, 019, 023 and the status of CAT010.

use asterix::{NamedRecord, registry};
use messages::{SensorTrack, TrackState};
use outgoing::{Condition, SensorBiases, SensorReports, SensorStatus, StatusReports, SystemStatus};

use crate::model::World;
use crate::reading::{Sent, records};

/// A little before midnight, which it is rounded to.
const NOW_NS: i64 = 20_000 * 86_400_000_000_000 - 1_000_000;

#[test]
fn the_system_reports_its_state_in_every_edition() {
    let of_sensors = registry::default_edition(63).unwrap();
    for table in registry::editions(65) {
        let mut sender = StatusReports::new(table, of_sensors, 3, 4, 200)
            .unwrap()
            .with_service(5);
        let mut bytes = vec![];
        let status = SystemStatus {
            condition: Condition::Degraded,
            overloaded: true,
            time_source_invalid: false,
            processing_system: 2,
            renumbered: true,
        };
        sender.system(NOW_NS, status, &mut |block| bytes.extend_from_slice(block));
        let [record] = &records(table, &bytes)[..] else {
            panic!("one record");
        };
        let sent = Sent { record, table };
        sent.is(&["000"], 1u64);
        sent.is(&["010", "SAC"], 3u64);
        sent.is(&["010", "SIC"], 4u64);
        sent.is(&["015"], 5u64);
        assert_eq!(sent.quantity(&["030"]), 0.0, "midnight");
        for (element, expected) in [("NOGO", 1u64), ("OVL", 1), ("TSV", 0), ("PSS", 2), ("STTN", 1)] {
            sent.is(&["040", element], expected);
        }
        assert_eq!((sender.counts().records, sender.counts().blocks), (1, 1));
    }
}

#[test]
fn sensors_are_reported_one_by_one_in_every_edition() {
    let of_system = registry::default_edition(65).unwrap();
    let sensors: Vec<SensorStatus> = (0..40)
        .map(|number| SensorStatus {
            sac: 20,
            sic: number,
            condition: [
                Condition::Operational,
                Condition::Degraded,
                Condition::Initialising,
                Condition::NotConnected,
            ][usize::from(number % 4)],
            silent: number % 3 == 0,
            time_source_invalid: number % 5 == 0,
            ..SensorStatus::default()
        })
        .collect();
    for table in registry::editions(63) {
        let mut sender = StatusReports::new(of_system, table, 3, 4, 150).unwrap();
        let mut blocks = vec![];
        sender.sensors(NOW_NS, &sensors, &mut |block| blocks.push(block.to_vec()));
        assert!(blocks.len() > 1 && blocks.iter().all(|block| block.len() <= 150));
        let found: Vec<NamedRecord> = blocks.iter().flat_map(|block| records(table, block)).collect();
        assert_eq!(found.len(), sensors.len());
        for (record, sensor) in found.iter().zip(&sensors) {
            let sent = Sent { record, table };
            sent.is(&["010", "SAC"], 3u64);
            sent.is(&["050", "SAC"], 20u64);
            sent.is(&["050", "SIC"], sensor.sic);
            sent.near_time(&["030"], NOW_NS);
            sent.is(&["060", "CON"], u64::from(sensor.sic % 4));
            sent.is(&["060", "NPW"], u64::from(sensor.silent));
            sent.is(&["060", "TSV"], u64::from(sensor.time_source_invalid));
            for other in ["PSR", "SSR", "MDS", "ADS", "MLT", "OPS", "ODP", "OXT", "MSC"] {
                sent.is(&["060", other], 0u64);
            }
            assert!(!sent.has(&["015"]));
            for bias in ["070", "080", "081", "090", "091"] {
                assert!(!sent.has(&[bias]), "{bias} is not known");
            }
        }
    }
}

#[test]
fn known_biases_are_sent_in_the_items_of_the_sensors_kind() {
    let of_system = registry::default_edition(65).unwrap();
    for table in registry::editions(63) {
        for (primary, range, azimuth) in [(false, ["080", "SRB"], "081"), (true, ["090", "PRB"], "091")] {
            let biases = SensorBiases {
                time_s: Some(-0.25),
                range_m: Some(-120.0),
                azimuth_rad: Some(0.01),
                primary,
            };
            let sensor = SensorStatus {
                biases,
                ..SensorStatus::default()
            };
            let beyond = SensorBiases {
                time_s: Some(1e9),
                range_m: Some(f64::NAN),
                ..SensorBiases::default()
            };
            let sensors = [
                sensor,
                SensorStatus {
                    biases: beyond,
                    ..sensor
                },
            ];
            let mut sender = StatusReports::new(of_system, table, 3, 4, 200).unwrap();
            let mut bytes = vec![];
            sender.sensors(NOW_NS, &sensors, &mut |block| bytes.extend_from_slice(block));
            let found = records(table, &bytes);
            let sent = Sent {
                record: &found[0],
                table,
            };
            assert_eq!(sent.quantity(&["070"]), -250.0, "ms");
            assert!((sent.quantity(&range) + 120.0 / 1852.0).abs() <= 1.0 / 256.0, "NM");
            assert!((sent.quantity(&[azimuth]) - 0.01_f64.to_degrees()).abs() < 0.003, "°");
            let unknown = Sent {
                record: &found[1],
                table,
            };
            assert!(
                ["070", "080", "081", "090", "091"]
                    .iter()
                    .all(|bias| !unknown.has(&[bias]))
            );
        }
    }
}

#[test]
fn tables_of_other_categories_are_refused() {
    let table = |number| registry::default_edition(number).unwrap();
    let error = StatusReports::new(table(62), table(63), 0, 0, 1400).unwrap_err();
    assert_eq!(
        error.to_string(),
        "CAT062 ed 1.18 can not be sent here; choose one of CAT065"
    );
    assert!(StatusReports::new(table(65), table(65), 0, 0, 1400).is_err());
}

/// The status messages of a sensor, with a report waiting that must go first.
fn status(category: u8, status_category: u8, ask: impl Fn(&mut SensorReports, &mut dyn FnMut(&[u8]))) -> NamedRecord {
    let world = World::simple(45.0, 11.25);
    let mut status = None;
    for table in registry::editions(category) {
        let mut sender = SensorReports::new(table, 7, 9, world.sensor, world.system, 1400).unwrap();
        let mut track = SensorTrack {
            state: TrackState::Confirmed as u8,
            ..SensorTrack::default()
        };
        track.identity = track.identity.with_address(1);
        let mut blocks = vec![];
        sender.report(&track, &mut |_| panic!("the block is not full"));
        ask(&mut sender, &mut |block| blocks.push(block.to_vec()));
        assert_eq!(
            blocks.iter().map(|block| block[0]).collect::<Vec<_>>(),
            [category, status_category]
        );
        assert_eq!((sender.counts().records, sender.counts().blocks), (2, 2));
        status = Some(blocks.swap_remove(1));
    }
    let table = registry::default_edition(status_category).unwrap();
    records(table, &status.expect("an edition")).swap_remove(0)
}

#[test]
fn radars_report_north_and_sectors() {
    let table = registry::default_edition(34).unwrap();
    let record = status(48, 34, |sender, send| sender.status(NOW_NS, send));
    let sent = Sent { record: &record, table };
    sent.is(&["010", "SIC"], 9u64);
    sent.is(&["000"], 1u64);
    sent.near_time(&["030"], NOW_NS);
    assert!(!sent.has(&["041"]), "nobody has told how fast the antenna turns");
    assert!(!sent.has(&["020"]));
    for (azimuth_deg, sector_deg) in [
        (0.0, 0.0),
        (11.25, 11.25),
        (12.6, 11.25),
        (359.9, 358.593_75),
        (-90.0, 270.0),
    ] {
        let azimuth_rad = f64::to_radians(azimuth_deg);
        let record = status(48, 34, |sender, send| sender.sector(NOW_NS, azimuth_rad, send));
        let sent = Sent { record: &record, table };
        sent.is(&["000"], 2u64);
        assert_eq!(sent.quantity(&["020"]), sector_deg, "{azimuth_deg}°");
    }
}

#[test]
fn the_other_sensors_report_periodically() {
    let table = |number| registry::default_edition(number).unwrap();
    let record = status(20, 19, |sender, send| sender.status(NOW_NS, send));
    let sent = Sent {
        record: &record,
        table: table(19),
    };
    sent.is(&["000"], 2u64);
    sent.near_time(&["140"], NOW_NS);
    sent.is(&["550", "NOGO"], 0u64);
    assert_eq!(
        (sent.quantity(&["600", "LAT"]), sent.quantity(&["600", "LON"])),
        (45.0, 11.25)
    );
    let record = status(21, 23, |sender, send| sender.status(NOW_NS, send));
    let sent = Sent {
        record: &record,
        table: table(23),
    };
    sent.is(&["000"], 1u64);
    sent.near_time(&["070"], NOW_NS);
    sent.is(&["100", "NOGO"], 0u64);
    let record = status(10, 10, |sender, send| sender.status(NOW_NS, send));
    let sent = Sent {
        record: &record,
        table: table(10),
    };
    sent.is(&["000"], 3u64);
    sent.near_time(&["140"], NOW_NS);
    sent.is(&["550", "NOGO"], 0u64);
    assert!(!sent.has(&["020"]));
}

#[test]
fn sensors_without_antenna_have_no_sectors() {
    let world = World::simple(45.0, 11.25);
    for category in [20, 21, 10] {
        let table = registry::default_edition(category).unwrap();
        let mut sender = SensorReports::new(table, 7, 9, world.sensor, world.system, 1400).unwrap();
        sender.sector(NOW_NS, 0.0, &mut |_| panic!("CAT{category:03} has sectors"));
    }
}
