//! Helpers that the tests have in common.

use observations::{Detection, DetectionKind, DetectionPlatform, TransponderReply};

use crate::Settings;
use crate::settings::{SensorFacts, SensorModel, TrackerCapacity};
pub(crate) use test_support::S;

/// A detection of a position by sensor 1, 10 m sigma.
pub(crate) fn position(time_ns: i64, east: f64, north: f64) -> Detection {
    Detection {
        time_of_measurement_ns: time_ns,
        sensor_id: 1,
        scan: 0,
        detection_id: 0,
        kind: DetectionKind::Position2,
        values: [east, north, 0.0],
        range_rate_mps: None,
        sigmas: Some([10.0, 10.0, 0.0, 0.0]),
        platform_m: [0.0; 3],
        platform: DetectionPlatform::default(),
        height: None,
        velocity: None,
        reply: TransponderReply::default(),
        truth: None,
    }
}

/// Sensor 1 detects nine in ten, with a false detection per square kilometre.
pub(crate) fn settings() -> Settings {
    let mut settings = Settings {
        sensors: vec![SensorFacts {
            sensor_id: 1,
            model: SensorModel {
                clutter_density: Some(1e-6),
                detection_probability: Some(0.9),
                ..SensorModel::default()
            },
            ..SensorFacts::default()
        }],
        capacity: TrackerCapacity {
            tracks: Some(1024),
            detections: Some(256),
            open_scans: 0,
        },
        ..Settings::default()
    };
    settings.initiation.speed_sigma_mps = 20.0;
    settings.motion.process_noise_m2ps3 = [1.0, 1.0];
    settings.motion.manoeuvres.enabled = false;
    settings.confirmation.detections_min = 3;
    settings.deletion.coherence_s = 1.0;
    settings
}
