//! Detections of sensors on board wait for the states of their platform, and leave in their order (HT-12, EL-11).

use std::f64::consts::FRAC_PI_2;

use messages::DetectionKind;
use observations::{Detection, DetectionPlatform, SensorEvent, StatedHeight, TransponderReply};
use platform::{Assumed, Mount, State};
use sources::carrying::{CarriedSensor, Carrier, Carrying};
use tracking::settings::SensorFacts;
use tracking::{Settings, Tracker};

const S: i64 = 1_000_000_000;

fn detection(time_ns: i64, number: u32) -> Detection {
    Detection {
        time_of_measurement_ns: time_ns,
        sensor_id: 1,
        scan: 0,
        detection_id: number,
        kind: DetectionKind::RangeBearing,
        values: [1000.0, 0.0, 0.0],
        range_rate_mps: None,
        sigmas: None,
        platform_m: [0.0; 3],
        platform: DetectionPlatform::default(),
        height: None,
        velocity: None,
        reply: TransponderReply::default(),
        truth: None,
    }
}

fn east(time_ns: i64) -> State {
    State {
        time_ns,
        position_m: Some([500.0, 0.0, 0.0]),
        heading_rad: Some(FRAC_PI_2),
        ..State::default()
    }
}

/// A radar on board with a wait of two seconds, and a sensor ashore.
fn carrying(carrier: Option<usize>) -> Carrying<u32> {
    let carriers = [Carrier {
        assumed: Assumed::default(),
        wait_ns: 2 * S,
        states_max: 16,
    }];
    let sensor = CarriedSensor {
        carrier,
        mount: Mount::default(),
        default_sigmas: Some([10.0, 0.01, f64::NAN, f64::NAN]),
        looks_ns: None,
    };
    Carrying::new(&carriers, &[Some(sensor), None], Assumed::default(), None)
}

fn words(left: &[(usize, SensorEvent, u32)]) -> Vec<String> {
    let word = |(place, event, with_it): &(usize, SensorEvent, u32)| match event {
        SensorEvent::Detection(_) => format!("{place} detection {with_it}"),
        SensorEvent::Unplaced(_) => format!("{place} refused {with_it}"),
        _ => format!("{place} mark {with_it}"),
    };
    left.iter().map(word).collect()
}

#[test]
fn marks_do_not_overtake_detections_that_wait_and_other_sensors_do() {
    let mut carrying = carrying(Some(0));
    let mut left = Vec::new();
    let mut out = |place, event, with_it| left.push((place, event, with_it));
    carrying.state(0, &east(0));
    carrying.take(0, SensorEvent::Detection(detection(S, 0)), 1, &mut out);
    carrying.take(0, SensorEvent::TurnBegins(S), 2, &mut out);
    carrying.take(1, SensorEvent::Detection(detection(S, 0)), 3, &mut out);
    carrying.take(0, SensorEvent::Detection(detection(2 * S, 1)), 4, &mut out);
    carrying.state(0, &east(3 * S / 2));
    carrying.release(&mut out);
    carrying.take(
        0,
        SensorEvent::EmptyScan {
            number: 9,
            time_ns: 2 * S,
        },
        5,
        &mut out,
    );
    carrying.state(0, &east(3 * S));
    carrying.release(&mut out);
    assert_eq!(
        words(&left),
        [
            "1 detection 3",
            "0 detection 1",
            "0 mark 2",
            "0 detection 4",
            "0 mark 5"
        ]
    );
    let (_, SensorEvent::Detection(carried), _) = left[1] else {
        unreachable!()
    };
    assert_eq!(carried.platform_m, [500.0, 0.0, 0.0]);
    assert!((carried.values[1] - FRAC_PI_2).abs() < 1e-9, "{carried:?}");
    let heading = carried.platform.attitude_rad.map(|[heading_rad, ..]| heading_rad);
    assert_eq!(heading, Some(std::f32::consts::FRAC_PI_2), "fixed to the hull");
    // The heading's error is added to the bearing's.
    let sigma = carried.sigmas.unwrap()[1];
    assert!(sigma > 0.01_f64.hypot(1_f64.to_radians()) - 1e-9, "{sigma}");
    assert_eq!(carrying.counts().carried, 2);
}

#[test]
fn a_detection_that_has_waited_leaves_a_mark_of_its_refusal() {
    let mut carrying = carrying(Some(0));
    let mut left = Vec::new();
    let mut out = |place, event, with_it| left.push((place, event, with_it));
    carrying.state(0, &east(0));
    carrying.take(0, SensorEvent::Detection(detection(S, 0)), 1, &mut out);
    // The sensor's data may run ahead by the wait, and not by more.
    carrying.take(0, SensorEvent::Passed(3 * S), 2, &mut out);
    carrying.release(&mut out);
    assert_eq!(carrying.counts().no_state, 0);
    carrying.take(0, SensorEvent::Passed(3 * S + 1), 3, &mut out);
    assert_eq!(carrying.counts().no_state, 1);
    carrying.take(0, SensorEvent::Detection(detection(4 * S, 1)), 4, &mut out);
    carrying.states_end();
    carrying.release(&mut out);
    assert_eq!(words(&left), ["0 refused 1", "0 mark 2", "0 mark 3", "0 refused 4"]);
    assert_eq!(left[0].1, SensorEvent::Unplaced(S));
    assert_eq!(carrying.counts().no_state, 2);
}

#[test]
fn a_detection_that_states_its_platform_waits_for_nothing() {
    let mut carrying = carrying(None);
    let mut left = Vec::new();
    let mut out = |place, event, with_it| left.push((place, event, with_it));
    let mut own = detection(S, 0);
    own.platform_m = [7.0, 8.0, 9.0];
    own.platform.attitude_rad = Some([std::f32::consts::FRAC_PI_2, 0.0, 0.0]);
    own.platform.attitude_sigmas_rad = [0.02, 0.01, 0.01];
    carrying.take(0, SensorEvent::Detection(own), 1, &mut out);
    // Without an attitude, the detection is in the system frame.
    carrying.take(0, SensorEvent::Detection(detection(S, 1)), 2, &mut out);
    let (_, SensorEvent::Detection(carried), _) = left[0] else {
        unreachable!()
    };
    assert_eq!(carried.platform_m, [7.0, 8.0, 9.0]);
    assert!((carried.values[1] - FRAC_PI_2).abs() < 1e-6, "{carried:?}");
    assert_eq!(left[1].1, SensorEvent::Detection(detection(S, 1)));
    assert_eq!(carrying.counts().carried, 1);
}

/// Position and height of the track of an aircraft, from plots of a radar on a ship that rolls and turns.
fn track_of_an_aircraft(states_height: bool) -> ([f64; 3], bool) {
    const AIRCRAFT_M: [f64; 3] = [9e3, 7e3, 6e3];
    let mut carrying = carrying(Some(0));
    let mut settings = Settings::default();
    settings.sensors.push(SensorFacts {
        sensor_id: 1,
        ..SensorFacts::default()
    });
    let mut tracker = Tracker::new(settings).unwrap();
    let mut left = Vec::new();
    for second in 0..12_u32 {
        let time_ns = i64::from(second) * 4 * S;
        let ship_m = [20.0 * f64::from(second), 500.0, 0.0];
        let (heading, roll) = (0.1 * f64::from(second), 0.15 * f64::from(second).sin());
        carrying.state(
            0,
            &State {
                time_ns,
                position_m: Some(ship_m),
                heading_rad: Some(heading),
                tilt_rad: Some([0.0, roll]),
                ..State::default()
            },
        );
        let target_m = [
            AIRCRAFT_M[0] + 150.0 * 4.0 * f64::from(second),
            AIRCRAFT_M[1],
            AIRCRAFT_M[2],
        ];
        let [east, north, up] = [0, 1, 2].map(|axis| target_m[axis] - ship_m[axis]);
        // Right and up of the deck at this heading and roll; the antenna measures in the plane of its deck.
        let (right, ahead) = (
            heading.cos() * east - heading.sin() * north,
            heading.sin() * east + heading.cos() * north,
        );
        let (right, ahead) = (roll.cos() * right - roll.sin() * up, ahead);
        let plot = Detection {
            values: [
                (east * east + north * north + up * up).sqrt() + 10.0 * f64::from(second * 7 % 5) - 20.0,
                right.atan2(ahead),
                0.0,
            ],
            scan: second,
            height: states_height.then_some(StatedHeight {
                height_m: target_m[2],
                sigma_m: 15.0,
            }),
            ..detection(time_ns, 0)
        };
        carrying.take(0, SensorEvent::Detection(plot), 0, &mut |_, event, _| left.push(event));
    }
    carrying.states_end();
    carrying.release(&mut |_, event, _| left.push(event));
    for event in &left {
        let SensorEvent::Detection(carried) = event else {
            panic!("{event:?}");
        };
        tracker.scan(1, carried.time_of_measurement_ns, &[*carried]).unwrap();
    }
    let [track] = tracker.tracks() else {
        panic!("{:?}", tracker.tracks());
    };
    let place = track.estimate.position_m();
    let truth = [AIRCRAFT_M[0] + 150.0 * 44.0, AIRCRAFT_M[1], AIRCRAFT_M[2]];
    ([0, 1, 2].map(|axis| place[axis] - truth[axis]), track.height_known)
}

/// A plot's height takes the slant range to the plane, and gives the track its height.
#[test]
fn an_aircraft_that_states_its_height_is_tracked_where_it_is() {
    let ([east, north, up], height_known) = track_of_an_aircraft(true);
    assert!(
        height_known && east.hypot(north) < 200.0 && up.abs() < 40.0,
        "{east} {north} {up}"
    );
    let ([east, north, _], height_known) = track_of_an_aircraft(false);
    assert!(!height_known && east.hypot(north) > 800.0, "{east} {north}");
}
