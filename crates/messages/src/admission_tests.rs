use super::*;

const NOW_NS: i64 = 1_800_000_000_123_456_789;

fn track() -> SensorTrack {
    SensorTrack {
        time_of_measurement_ns: NOW_NS - 1_000_000,
        covariance: Covariance::diagonal([30.0; 3], [3.0; 3]),
        ..SensorTrack::default()
    }
}

fn detection() -> SensorDetection {
    SensorDetection {
        time_of_measurement_ns: NOW_NS,
        valid: sensor_detection_bits::SIGMAS,
        values: [1e3, 2e3, 0.0],
        sigmas: [5.0, 5.0, 0.0, 0.0],
        ..SensorDetection::default()
    }
}

/// The text of the fault of a sample that differs from a sound one.
fn told<T: Admission>(mut sample: T, change: impl FnOnce(&mut T)) -> String {
    assert_eq!(fault(&sample, NOW_NS, Some(CLOCK_LIMIT_NS)), None);
    change(&mut sample);
    let found = fault(&sample, NOW_NS, Some(CLOCK_LIMIT_NS)).expect("a fault");
    found.to_string()
}

#[test]
fn a_time_in_another_unit_or_of_another_clock_is_recognised() {
    let time = |time_ns: i64| told(track(), |track| track.time_of_measurement_ns = time_ns);
    for (time_ns, expected) in [
        (NOW_NS / 1_000_000_000, "in seconds; multiply it by 1000000000"),
        (NOW_NS / 1_000_000, "in milliseconds; multiply it by 1000000"),
        (NOW_NS / 1_000, "in microseconds; multiply it by 1000"),
        (0, "fill in the time"),
        (86_400_000_000_000, "monotonic"),
        (NOW_NS + 601_000_000_000, "601 s ahead"),
        (NOW_NS - 7_200_000_000_000, "7200 s behind"),
        (i64::MIN, "behind"),
        (i64::MAX, "ahead"),
    ] {
        let text = time(time_ns);
        assert!(text.contains(expected), "{text}");
        assert!(
            text.starts_with(&format!("time_of_measurement_ns is {time_ns}: ")),
            "{text}"
        );
        assert!(text.contains("within 600 s"), "{text}");
    }
}

#[test]
fn the_limit_of_the_clock_is_inclusive_and_can_be_left_out() {
    for (apart_ns, limit_ns, is_fault) in [
        (CLOCK_LIMIT_NS, Some(CLOCK_LIMIT_NS), false),
        (-CLOCK_LIMIT_NS, Some(CLOCK_LIMIT_NS), false),
        (CLOCK_LIMIT_NS + 1, Some(CLOCK_LIMIT_NS), true),
        (-CLOCK_LIMIT_NS - 1, Some(CLOCK_LIMIT_NS), true),
        (-NOW_NS, None, false),
    ] {
        let found = time_fault("time_ns", NOW_NS + apart_ns, NOW_NS, limit_ns);
        assert_eq!(found.is_some(), is_fault, "{apart_ns} {limit_ns:?}");
    }
    assert!(time_fault("time_ns", i64::MAX, NOW_NS, None).is_some());
}

#[test]
fn a_track_with_impossible_numbers_is_refused_by_its_field() {
    type Change = fn(&mut SensorTrack);
    let changes: [(Change, &str); 9] = [
        (|track| track.position_m[1] = f64::NAN, "position_m[1] is NaN"),
        (|track| track.position_m[2] = 1e9, "position_m[2] is 1000000000"),
        (|track| track.velocity_mps[0] = f64::INFINITY, "velocity_mps[0] is inf"),
        (
            |track| track.covariance = Covariance::default(),
            "covariance.upper[0], the variance east, is 0: must be above 0",
        ),
        (
            |track| track.covariance.set(4, 4, -1.0),
            "velocity north, is -1: must not be negative",
        ),
        (|track| track.covariance.set(0, 1, 901.0), "positive semidefinite"),
        (
            |track| track.covariance.set(2, 5, f64::NAN),
            "covariance.upper[14] is NaN",
        ),
        (|track| track.state = 77, "state is 77"),
        (|track| track.existence = 1.5, "existence is 1.5"),
    ];
    for (change, expected) in changes {
        let text = told(track(), change);
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn a_track_may_state_a_trace_in_place_of_a_covariance() {
    let mut of_trace = SensorTrack {
        covariance: Covariance::default(),
        trace_m2: 800.0,
        valid: sensor_track_bits::TRACE,
        ..track()
    };
    assert_eq!(of_trace.value_fault(), None);
    of_trace.trace_m2 = 0.0;
    assert!(of_trace.value_fault().unwrap().field == "trace_m2");
}

#[test]
fn full_correlation_is_semidefinite_and_one_beyond_it_is_not() {
    for (correlation, is_fault) in [
        (1.0, false),
        (-1.0, false),
        (0.999, false),
        (1.001, true),
        (-1.001, true),
    ] {
        let mut sample = track();
        sample.covariance.set(0, 1, correlation * 900.0);
        sample.covariance.set(0, 3, 0.5 * 90.0);
        sample.covariance.set(1, 3, correlation * 0.5 * 90.0);
        assert_eq!(sample.value_fault().is_some(), is_fault, "{correlation}");
    }
    // An unknown height has no correlation.
    let mut unknown = track();
    unknown.covariance.set(2, 2, 0.0);
    assert_eq!(unknown.value_fault(), None);
    unknown.covariance.set(1, 2, 5.0);
    assert!(unknown.value_fault().is_some());
}

#[test]
fn a_detection_is_checked_by_its_kind() {
    type Change = fn(&mut SensorDetection);
    let changes: [(Change, &str); 8] = [
        (|sample| sample.values[0] = f64::NAN, "values[0] is NaN"),
        (|sample| sample.sigmas[1] = 0.0, "sigmas[1] is 0: must be above 0"),
        (|sample| sample.sigmas[0] = -5.0, "sigmas[0] is -5"),
        (|sample| sample.kind = 200, "kind is 200"),
        (
            |sample| (sample.kind, sample.values[1]) = (DetectionKind::RangeBearing as u8, 270.0),
            "radians, not degrees",
        ),
        (
            |sample| (sample.kind, sample.values[0]) = (DetectionKind::RangeBearing as u8, -1.0),
            "no range is",
        ),
        (
            |sample| sample.valid |= sensor_detection_bits::RANGE_RATE,
            "sigmas[3] is 0",
        ),
        (|sample| sample.time_of_measurement_ns /= 1_000_000_000, "in seconds"),
    ];
    for (change, expected) in changes {
        let text = told(detection(), change);
        assert!(text.contains(expected), "{text}");
    }
    // Values beyond the kind's have no meaning.
    let mut beyond = detection();
    beyond.values[2] = f64::NAN;
    assert_eq!(beyond.value_fault(), None);
    let mark = SensorDetection {
        valid: sensor_detection_bits::MARK,
        ..SensorDetection::default()
    };
    assert_eq!(mark.value_fault(), None);
}

#[test]
fn bearings_platforms_and_counts_are_checked_as_well() {
    let bearing = SensorBearing {
        time_of_measurement_ns: NOW_NS,
        sigma_rad: 0.02,
        ..SensorBearing::default()
    };
    assert!(told(bearing, |sample| sample.bearing_rad = 270.0).contains("radians"));
    assert!(told(bearing, |sample| sample.sigma_rad = 0.0).contains("sigma_rad is 0"));
    let platform = PlatformState {
        time_ns: NOW_NS,
        valid: platform_state_bits::HEADING,
        ..PlatformState::default()
    };
    assert!(told(platform, |sample| sample.heading_rad = 270.0).contains("radians"));
    let count = WideArea {
        time_of_observation_ns: NOW_NS,
        ..WideArea::default()
    };
    assert!(told(count, |sample| sample.position_m[0] = f64::NAN).contains("position_m[0]"));
}

#[test]
fn a_number_that_no_target_of_its_kind_has_is_refused() {
    // A ship's number under the kind of aircraft: cut to 24 bits, it would be another target's address.
    let text = told(track(), |track| {
        track.identity = Identity::default().with_mmsi(227_000_000);
        track.identity.kind = IdentityKind::Aircraft.code();
    });
    assert!(
        text.starts_with("identity.address is 227000000: must be an address of 24 bits"),
        "{text}"
    );
    let text = told(detection(), |found| {
        found.identity = Identity::default().with_mmsi(1_000_000_000)
    });
    assert!(text.contains("nine digits"), "{text}");
    let text = told(track(), |track| {
        track.identity = Identity::default().with_mode_3a(0o7777);
        track.identity.mode_3a += 1;
    });
    assert!(text.starts_with("identity.mode_3a is 4096"), "{text}");
    let text = told(detection(), |found| found.identity.kind = 7);
    assert!(text.starts_with("identity.kind is 7"), "{text}");
}
