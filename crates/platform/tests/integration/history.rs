//! Interpolation of a platform's states, and detections that wait for them.

use std::f64::consts::{PI, TAU};

use messages::DetectionKind;
use observations::{Detection, DetectionPlatform, TransponderReply};
use platform::{Added, Assumed, History, Mount, NoState, Refusal, State, WaitingRoom};
use proptest::prelude::*;
use settings::{Degrees, Seconds};

const S: i64 = 1_000_000_000;

fn assumed() -> Assumed {
    Assumed {
        acceleration_mps2: 0.0,
        angular_acceleration_degps2: Degrees::of(0.0),
        ..Assumed::default()
    }
}

fn place(time_ns: i64, east: f64) -> State {
    State {
        time_ns,
        position_m: Some([east, 0.0, 0.0]),
        ..State::default()
    }
}

#[test]
fn a_heading_goes_through_north_by_the_shorter_way() {
    let mut history = History::new(assumed(), 16);
    for (time_ns, heading_deg) in [(0, 350.0), (S, 10.0), (2 * S, 340.0)] {
        history.add(&State {
            heading_rad: Some(f64::to_radians(heading_deg)),
            ..place(time_ns, 0.0)
        });
    }
    let heading = |time_ns| history.at(time_ns).unwrap().heading.unwrap();
    let near = |value: f64, expected_deg: f64| {
        let off = (value - f64::to_radians(expected_deg) + PI).rem_euclid(TAU) - PI;
        assert!(off.abs() < 1e-12, "{value} {expected_deg}");
    };
    near(heading(S / 2).angle_rad, 0.0);
    near(heading(S / 4).angle_rad, 355.0);
    near(heading(S * 3 / 2).angle_rad, -5.0);
    near(heading(S / 2).rate_radps, 20.0);
    near(heading(3 * S / 2).rate_radps, -30.0);
}

#[test]
fn times_without_states_beside_them_are_refused_by_reason() {
    let mut history = History::new(assumed(), 4);
    assert_eq!(history.at(0), Err(NoState::None));
    for time_ns in [S, 2 * S, 5 * S] {
        assert_eq!(history.add(&place(time_ns, 0.0)), Added::Kept);
    }
    assert_eq!(history.at(S - 1), Err(NoState::TooOld));
    assert!(history.at(S).is_ok() && history.at(3 * S / 2).is_ok());
    assert_eq!(history.at(3 * S), Err(NoState::Gap));
    assert!(history.at(5 * S).is_ok());
    assert_eq!(history.at(5 * S + 1), Err(NoState::NotYet));
    // The memory is bounded: the oldest state leaves, and an older one has no room.
    for time_ns in [6 * S, 7 * S] {
        history.add(&place(time_ns, 0.0));
    }
    assert_eq!(history.at(S), Err(NoState::TooOld));
    assert_eq!(history.add(&place(S, 0.0)), Added::TooOld);
    assert_eq!(history.add(&State::default()), Added::Nothing);
    // A compass that stops: the position stays known, the heading is not.
    history.add(&State {
        time_ns: 6 * S,
        heading_rad: Some(1.0),
        ..State::default()
    });
    assert_eq!(history.at(7 * S).unwrap().heading.unwrap_err(), NoState::NotYet);
    // Without any instrument for it, the platform is assumed level.
    let [pitch, _] = history.at(7 * S).unwrap().tilt.unwrap();
    assert_eq!(
        (pitch.angle_rad, pitch.sigma_rad),
        (0.0, assumed().level_sigma_deg.rad())
    );
}

#[test]
fn covariances_grow_in_the_middle_of_a_gap() {
    let mut history = History::new(Assumed::default(), 16);
    for time_ns in [0, 2 * S] {
        history.add(&State {
            heading_rad: Some(0.1),
            position_sigma_m: Some(1.0),
            ..place(time_ns, 0.0)
        });
    }
    let sigma = |time_ns| history.at(time_ns).unwrap().position_sigma_m;
    assert_eq!(sigma(0), 1.0);
    // ½·0.5·½·½·2² m = 0.25 m.
    assert!((sigma(S) - 1.0625f64.sqrt()).abs() < 1e-12);
    assert!(sigma(S / 2) > 1.0 && sigma(S / 2) < sigma(S));
    let heading = |time_ns| history.at(time_ns).unwrap().heading.unwrap().sigma_rad;
    let expected = 1f64.to_radians().hypot(1.5f64.to_radians());
    assert!((heading(S) - expected).abs() < 1e-9, "{} {expected}", heading(S));
}

#[test]
fn parts_of_a_state_with_the_same_time_complete_each_other() {
    let mut history = History::new(assumed(), 16);
    for time_ns in [0, S] {
        history.add(&place(time_ns, 10.0 * time_ns as f64 / S as f64));
        let velocity = State {
            time_ns,
            velocity_mps: Some([10.0, 0.0, 0.0]),
            velocity_sigma_mps: Some(0.25),
            ..State::default()
        };
        assert_eq!(history.add(&velocity), Added::Kept);
    }
    let pose = history.at(S / 2).unwrap();
    assert_eq!(
        (pose.position_m, pose.velocity_mps),
        ([5.0, 0.0, 0.0], Some([10.0, 0.0, 0.0]))
    );
    assert_eq!(pose.velocity_sigma_mps, 0.25);
    let alone = State {
        time_ns: S / 2,
        velocity_mps: Some([1.0; 3]),
        ..State::default()
    };
    assert_eq!(history.add(&alone), Added::Nothing);
}

proptest! {
    /// The cubic is exact for a motion with a constant jerk, and its velocity is the motion's.
    #[test]
    fn a_cubic_motion_is_followed_exactly(
        c in prop::array::uniform4(-5.0..5.0f64), at in 0.0..1.0f64, span_s in 0.1..2.0f64,
    ) {
        let x = |t: f64| c[0] + t * (c[1] + t * (c[2] + t * c[3]));
        let v = |t: f64| c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]);
        let ns = |t: f64| (t * 1e9).round() as i64;
        let mut history = History::new(assumed(), 4);
        let end_ns = ns(span_s);
        let span_s = end_ns as f64 / 1e9;
        for (time_ns, t) in [(0, 0.0), (end_ns, span_s)] {
            history.add(&State { velocity_mps: Some([v(t), 0.0, 0.0]), ..place(time_ns, x(t)) });
        }
        let time_ns = ns(at * span_s);
        let t = time_ns as f64 / 1e9;
        let pose = history.at(time_ns).unwrap();
        prop_assert!((pose.position_m[0] - x(t)).abs() < 1e-9);
        prop_assert!((pose.velocity_mps.unwrap()[0] - v(t)).abs() < 1e-8);
    }

    /// The order of arrival does not matter.
    #[test]
    fn a_history_is_a_function_of_its_states(
        mut states in prop::collection::vec((0i64..20, 0.0..100.0f64), 2..12), at in 0i64..20_000,
    ) {
        states.sort_by_key(|state| state.0);
        states.dedup_by_key(|state| state.0);
        let fill = |reversed: bool| {
            let mut history = History::new(assumed(), 32);
            let order: Vec<_> = if reversed { states.iter().rev().collect() } else { states.iter().collect() };
            for (time_s, east) in order {
                history.add(&place(time_s * S, *east));
            }
            history.at(at * S / 1000)
        };
        prop_assert_eq!(fill(false), fill(true));
    }
}

fn detection(time_ns: i64, detection_id: u32) -> Detection {
    Detection {
        time_of_measurement_ns: time_ns,
        sensor_id: 1,
        scan: 0,
        detection_id,
        kind: DetectionKind::RangeBearing,
        values: [1000.0, 0.5, 0.0],
        range_rate_mps: None,
        sigmas: Some([10.0, 0.01, 0.0, 0.0]),
        platform_m: [0.0; 3],
        platform: DetectionPlatform::default(),
        height: None,
        velocity: None,
        reply: TransponderReply::default(),
        truth: None,
    }
}

fn whole(time_ns: i64) -> State {
    State {
        heading_rad: Some(0.0),
        ..place(time_ns, time_ns as f64 / 1e9)
    }
}

#[test]
fn detections_wait_for_the_platform_and_then_are_refused_and_counted() {
    let assumed = Assumed {
        max_gap_s: Seconds::of(1.0),
        ..assumed()
    };
    let mut history = History::new(assumed, 16);
    let mut room = WaitingRoom::new(Mount::default(), None, S, 3);
    assert!(room.take(detection(S / 2, 1), "first").is_none());
    assert!(room.next(&history, None).is_none());
    history.add(&whole(0));
    assert!(room.next(&history, None).is_none());
    history.add(&whole(S));
    let departure = room.next(&history, None).unwrap();
    assert_eq!((departure.with_it, departure.measured.detection_id), ("first", 1));
    assert_eq!(departure.outcome.unwrap().detection.platform_m, [0.5, 0.0, 0.0]);
    // The platform is silent while the sensor goes on: after the wait, the detection is refused.
    for (time_ns, number) in [(3 * S / 2, 2), (2 * S, 3), (5 * S / 2, 4)] {
        assert!(room.take(detection(time_ns, number), "").is_none());
        assert!(room.next(&history, None).is_none());
    }
    let full = room.take(detection(5 * S / 2, 5), "").unwrap();
    assert_eq!((full.outcome, full.measured.detection_id), (Err(Refusal::Full), 5));
    room.passed(5 * S / 2 + 1);
    let refused = room.next(&history, None).unwrap();
    assert_eq!(refused.outcome, Err(Refusal::Position(NoState::NotYet)));
    assert!(room.next(&history, None).is_none());
    // The states come again, after a gap.
    history.add(&whole(3 * S));
    assert_eq!(
        room.next(&history, None).unwrap().outcome,
        Err(Refusal::Position(NoState::Gap))
    );
    room.end();
    assert_eq!(
        room.next(&history, None).unwrap().outcome,
        Err(Refusal::Position(NoState::Gap))
    );
    assert!(room.next(&history, None).is_none());
    let counts = room.counts();
    assert_eq!((counts.carried, counts.no_state, counts.gap, counts.full), (1, 1, 2, 1));
    assert_eq!(counts.refused(), 4);
}

/// The heave of a ship must not look like the height of a target.
#[test]
fn the_height_of_a_sensor_without_elevation_is_held() {
    let mut history = History::new(assumed(), 16);
    for (time_s, up) in [(0, 15.0), (1, 12.0), (2, 18.5), (3, 70.0)] {
        history.add(&State {
            position_m: Some([0.0, 0.0, up]),
            ..whole(time_s * S)
        });
    }
    let mut room = WaitingRoom::new(Mount::default(), None, S, 4);
    let mut height = |time_s: i64, kind: DetectionKind| {
        let values = [1000.0, 0.5, 0.1];
        let sigmas = Some([10.0, 0.01, 0.01, 0.0]);
        let measured = Detection {
            kind,
            values,
            sigmas,
            ..detection(time_s * S, 1)
        };
        assert!(room.take(measured, ()).is_none());
        room.next(&history, None).unwrap().outcome.unwrap().detection.platform_m[2]
    };
    let (plane, space) = (DetectionKind::RangeBearing, DetectionKind::RangeBearingElevation);
    assert_eq!(
        [0, 1, 2, 3].map(|time_s| height(time_s, plane)),
        [15.0, 15.0, 15.0, 70.0]
    );
    assert_eq!([0, 1, 2].map(|time_s| height(time_s, space)), [15.0, 12.0, 18.5]);
}

/// The same error at each look is like a greater one that is new at each look.
#[test]
fn errors_of_the_attitude_that_persist_weigh_more_from_the_second_look_on() {
    let variance = |correlation_s: f64, stated_ns: Option<i64>| {
        let assumed = Assumed {
            attitude_correlation_s: Seconds::of(correlation_s),
            position_sigma_m: 1e-3,
            heading_sigma_deg: Degrees::of(0.5),
            ..assumed()
        };
        let mut history = History::new(assumed, 64);
        (0..8).for_each(|time_s| {
            history.add(&State {
                heading_rad: Some(0.0),
                tilt_rad: Some([0.0; 2]),
                ..place(time_s * S, 0.0)
            });
        });
        let mut room = WaitingRoom::new(Mount::default(), None, S, 4).with_looks(stated_ns);
        [0, 2, 4].map(|time_s| {
            let measured = Detection {
                scan: 7 + time_s as u32 / 2,
                kind: DetectionKind::RangeBearing,
                values: [10e3, 0.0, 0.0],
                sigmas: Some([10.0, 1e-4, 0.0, 0.0]),
                ..detection(time_s * S, 1)
            };
            assert!(room.take(measured, ()).is_none());
            let carried = room.next(&history, None).unwrap().outcome.unwrap().detection;
            carried.sigmas.unwrap()[1].powi(2)
        })
    };
    let plain = variance(0.0, None);
    assert_eq!([plain[1], plain[2]], [plain[0]; 2]);
    let lasting = variance(10.0, None);
    assert_eq!(lasting[0], plain[0], "the interval between two looks is not known yet");
    for variance in [lasting[1], lasting[2], variance(10.0, Some(2 * S))[0]] {
        let factor = variance / plain[0];
        // (1 + ρ)/(1 − ρ) with ρ = exp(−0.2).
        assert!((factor - 10.03).abs() < 0.05, "{factor}");
    }
}
