use frames::Geodetic;
use messages::{Contribution, Covariance, Identity, StageTimes, TargetType, TrackState, sensor_track_bits};
use sample_text::{LineFormat, LineWriter, SampleNames};

use super::*;

fn frame(latitude: f64) -> SystemFrame {
    SystemFrame::at(Geodetic::from_degrees(latitude, 2.0, 0.0).unwrap())
}

fn sources() -> Vec<String> {
    ["west", "own"].map(str::to_owned).to_vec()
}

fn lines() -> TappedLines {
    TappedLines::new(sources(), frame(41.0), (3, vec![7, 0]))
}

fn tapped<T: Sample>(sample: T, is_named: bool) -> Map<String, Value> {
    let names = is_named.then(|| SampleNames::new(["west", "other"].map(str::to_owned).to_vec(), frame(41.0)));
    let (layout, mut text): (&'static Layout, _) = (&T::LAYOUT, Vec::new());
    LineWriter::new(layout, LineFormat::Json, names).write(T::octets(&[sample]), &mut text);
    serde_json::from_slice(&text).unwrap()
}

fn identities() -> [Identity; 4] {
    let none = Identity::default();
    [
        none,
        none.with_address(0x87_3f5f)
            .with_mode_3a(0o2300)
            .with_callsign(*b"KOS1    "),
        none.with_mmsi(2_275_400).with_name("QUEEN, MARY 2"),
        none.with_mode_3a(0o1216),
    ]
}

fn report(identity: Identity) -> SensorTrack {
    SensorTrack {
        time_of_measurement_ns: 1_800_000_000_123_456_789,
        sequence: 77,
        track_number: 9,
        source: 1,
        valid: sensor_track_bits::HEIGHT
            | sensor_track_bits::VELOCITY
            | sensor_track_bits::VERTICAL_RATE
            | sensor_track_bits::TURN_RATE,
        identity,
        position_m: [12_345.678, -2_345.5, 3_000.125],
        velocity_mps: [100.0, 1.0 / 3.0, -2.5],
        covariance: Covariance::diagonal([30.0, 40.0, 50.0], [3.0; 3]),
        state: TrackState::Coasted as u8,
        alerts: 5,
        target_type: TargetType::new("boat", 0.75).unwrap(),
        turn_rate_radps: 0.1,
        level: -3,
        ..SensorTrack::default()
    }
}

#[test]
fn a_tapped_report_is_fed_with_every_field() {
    for identity in identities() {
        for is_named in [true, false] {
            let stated = report(identity);
            let found = lines().track(&tapped(stated, is_named), 1).unwrap();
            assert_eq!(found, stated);
        }
    }
}

#[test]
fn a_tapped_detection_is_fed_with_every_field() {
    for identity in identities() {
        let stated = SensorDetection {
            time_of_measurement_ns: 1_800_000_000_123_456_789,
            scan: 5,
            detection_id: 3,
            values: [1.5, -2.5, 0.0],
            sigmas: [5.0, 6.0, 0.0, 0.0],
            valid: messages::sensor_detection_bits::SIGMAS,
            identity,
            level: 77,
            platform_attitude_rad: [0.1, -0.2, 0.3],
            ..SensorDetection::default()
        };
        for is_named in [true, false] {
            assert_eq!(lines().detection(&tapped(stated, is_named)).unwrap(), stated);
        }
    }
}

#[test]
fn a_tapped_state_is_fed_as_the_report_of_another_centre() {
    for identity in identities() {
        let mut state = SystemTrack {
            reference_time_ns: 1_800_000_000_000_000_000,
            track_number: 4,
            origin: 2,
            identity,
            stages: StageTimes::default(),
            position_m: [1e4, 2e4, 3e3],
            velocity_mps: [100.0, -50.0, 2.0],
            height_valid: 1,
            velocity_valid: 1,
            covariance: Covariance::diagonal([30.0; 3], [3.0; 3]),
            state: TrackState::Confirmed as u8,
            source_count: 1,
            contribution_count: 1,
            ..SystemTrack::default()
        };
        state.contributions[0] = Contribution {
            sensor_uid: 7,
            source: 1,
            ..Contribution::default()
        };
        let found = lines().track(&tapped(state, true), 1).unwrap();
        assert_eq!(found, SensorTrack::of_centre(&state, 1, 3, &[7, 0]).unwrap());
        assert_eq!((found.identity, found.track_number), (identity, 4));
        state.origin = 3;
        let fault = lines().track(&tapped(state, true), 1).unwrap_err();
        assert_eq!(fault.field, "origin", "{fault}");
    }
}

#[test]
fn a_line_of_another_system_frame_is_refused() {
    let line = tapped(report(Identity::default()), true);
    let elsewhere = TappedLines {
        frame: frame(41.1),
        ..lines()
    };
    let fault = elsewhere.track(&line, 1).unwrap_err();
    assert_eq!(fault.field, "latitude");
    assert!(fault.to_string().contains("the frames differ"), "{fault}");
    // Numbers alone do not show it.
    assert!(elsewhere.track(&tapped(report(Identity::default()), false), 1).is_ok());
}

#[test]
fn identities_as_numbers_and_twofold_ones_are_refused() {
    for (identity, field) in [
        (r#"{"address": 8863583}"#, "address"),
        (r#"{"mode_3a": 1216}"#, "mode_3a"),
        (r#"{"address": "873F5F", "mmsi": "002275400"}"#, "mmsi"),
    ] {
        let line = format!(r#"{{"time_of_measurement_ns": 1, "identity": {identity}}}"#);
        let line: Map<String, Value> = serde_json::from_str(&line).unwrap();
        assert_eq!(lines().track(&line, 0).unwrap_err().field, field);
        let fault = lines().detection(&line).unwrap_err();
        assert_eq!(fault.field, field);
    }
}
