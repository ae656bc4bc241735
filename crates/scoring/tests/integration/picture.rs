//! Scores of pictures with known quality: the tracks of a single sensor.

use std::collections::BTreeMap;

use messages::{SensorTrack, SystemTrack, TrackState};
use scenario::{ScenarioSettings, SensorIdentity, SensorKind, SensorSettings, SimulatedSensor, TargetState, Truth};
use scoring::{AccuracyReport, AccuracySums, PictureTarget, PictureTrack};

const START_NS: i64 = 1_700_000_000_000_000_000;

/// Scores the sensor's tracks as if they were the fused picture, once per second from 20 s to 120 s.
fn scored(settings: &SensorSettings) -> AccuracyReport {
    let truth = Truth::new(&ScenarioSettings::default(), 11).expect("valid");
    let mut sensor = SimulatedSensor::new(settings, 11, 0, START_NS).expect("valid");
    let mut latest: BTreeMap<u32, SystemTrack> = BTreeMap::new();
    let mut reports: Vec<SensorTrack> = Vec::new();
    let mut accuracy = AccuracySums::default();
    for second in 0..120 {
        let time_s = f64::from(second);
        while sensor.next_scan_time_s() <= time_s {
            sensor.scan(&truth, &mut reports);
        }
        for report in reports.drain(..) {
            if report.state == TrackState::Terminated as u8 {
                latest.remove(&report.track_number);
            } else {
                latest.insert(report.track_number, as_system_track(&report));
            }
        }
        if second >= 20 {
            let target = |target: TargetState| PictureTarget {
                id: target.id,
                position_m: target.position_m,
                address: target.address,
            };
            let targets: Vec<PictureTarget> = truth.at(time_s).map(target).collect();
            let now_ns = START_NS + i64::from(second) * 1_000_000_000;
            let tracks: Vec<PictureTrack> = latest
                .values()
                .filter_map(|track| PictureTrack::from_system_track(track, now_ns))
                .collect();
            accuracy.add_picture(&targets, &tracks);
        }
    }
    accuracy.report()
}

fn as_system_track(report: &SensorTrack) -> SystemTrack {
    SystemTrack {
        reference_time_ns: report.time_of_measurement_ns,
        track_number: report.track_number,
        identity: report.identity,
        position_m: report.position_m,
        velocity_mps: report.velocity_mps,
        state: report.state,
        ..SystemTrack::default()
    }
}

#[test]
fn a_sensor_that_sees_all_holds_all() {
    let settings = SensorSettings {
        range_max_m: Some(300_000.0),
        ..SensorSettings::new(SensorKind::Multilateration)
    };
    let report = scored(&settings);
    assert_eq!((report.pictures, report.targets), (100, 80.0));
    assert!(report.held_once_share > 0.999, "{report:?}");
    assert_eq!((report.identity_errors, report.false_tracks), (0, 0.0));
    // Measured with 28 m in the plane; the filter gains, and prediction by up to a second loses.
    assert!((10.0..35.0).contains(&report.rms_m), "{report:?}");
    assert!(report.mean_m <= report.rms_m && report.rms_m <= report.p95_m);
    assert!(report.p95_m <= report.max_m);
}

#[test]
fn what_a_sensor_lacks_shows() {
    let anonymous = SensorSettings {
        identity: Some(SensorIdentity::None),
        equipped_share: Some(0.5),
        bias_m: Some([200.0, 0.0, 0.0]),
        ..SensorSettings::new(SensorKind::Multilateration)
    };
    let report = scored(&anonymous);
    assert!((0.3..0.7).contains(&report.missed_share), "{report:?}");
    assert!((150.0..400.0).contains(&report.mean_m), "{report:?}");

    let reflecting = SensorSettings {
        false_tracks_per_period: Some(1.0),
        ..SensorSettings::new(SensorKind::Radar)
    };
    let report = scored(&reflecting);
    assert!((1.0..10.0).contains(&report.false_tracks), "{report:?}");
    assert!(report.missed_share >= 0.2, "the surface is not seen: {report:?}");
}
