//! Frames from the literature, and a recording.
//!
//! Most frames are from J. Sun, The 1090 Megahertz Riddle (2nd edition, TU Delft 2021), with the values printed there.

use formats::mode_s::{FrameClock, FrameReader, Framed, ModeSMessage, ModeSRefusal};
use test_support::recording;

use super::*;

const KT: f64 = 1852.0 / 3600.0;
const FT: f64 = 0.3048;

fn read(frame: &str) -> ModeSMessage {
    let mut found = None;
    FrameReader::default().take(format!("{frame}\n").as_bytes(), &mut |framed| match framed {
        Framed::Frame(frame, _) => found = ModeSMessage::read(&frame).unwrap(),
        other => panic!("{other:?}"),
    });
    found.unwrap()
}

fn near(found: Option<f64>, expected: f64, margin: f64) {
    assert!(
        found.is_some_and(|found| (found - expected).abs() <= margin),
        "{found:?} {expected}"
    );
}

#[test]
fn identification() {
    let found = read("8D4840D6202CC371C32CE0576098");
    assert_eq!((found.address, found.callsign), (0x48_40d6, Some(*b"KLM1023 ")));
}

#[test]
fn a_pair_in_the_air_has_a_position_and_an_altitude() {
    let mut reader = reader(None);
    assert_eq!(place(&take(&mut reader, "8D40621D58C386435CC412692AD6", 0.0)), None);
    let found = take(&mut reader, "8D40621D58C382D690C8AC2863A7", 1.0);
    assert_eq!(place(&found), Some([52.2572, 3.9194]));
    let observation = observed(&found).unwrap();
    near(observation.pressure_altitude_m, 38_000.0 * FT, 1e-6);
    assert_eq!(
        (observation.track_number, observation.on_ground),
        (Some(0x40_621d), false)
    );
    assert_eq!((found[0].clock, found[0].utc_ns), (FrameClock::Receipt, START_NS + S));
    // The odd frame alone, near the place.
    let found = take(&mut reader, "8D40621D58C386435CC412692AD6", 60.0);
    assert_eq!(place(&found), Some([52.2658, 3.9389]));
}

#[test]
fn a_pair_on_the_ground_needs_the_receiver() {
    let (even, odd) = ("8C4841753AAB238733C8CD4020B1", "8C4841753A9A153237AEF0F275BE");
    let mut known = reader(Some(RECEIVER));
    assert_eq!(place(&take(&mut known, odd, 0.0)), None);
    let found = take(&mut known, even, 1.0);
    assert_eq!(place(&found), Some([52.3230, 4.7305]));
    let observation = observed(&found).unwrap();
    let [east, north] = observation.velocity.unwrap();
    near(Some(east.hypot(north)), 18.0 * KT, 1e-9);
    near(Some(east.atan2(north).to_degrees()), 140.625, 1e-9);
    assert!(observation.on_ground && observation.pressure_altitude_m.is_none());
    let mut unknown = reader(None);
    take(&mut unknown, odd, 0.0);
    assert_eq!(take(&mut unknown, even, 1.0), []);
    assert_eq!(unknown.counters().refused(ModeSRefusal::Reference), 1);
}

#[test]
fn velocities() {
    let found = read("8D485020994409940838175B284F");
    near(found.ground_speed_mps, 159.2 * KT, 0.02 * KT);
    near(found.track_rad, 182.88f64.to_radians(), 1e-4);
    near(found.vertical_rate_mps, -832.0 * FT / 60.0, 1e-9);
    // An airspeed of 375 kn is no ground speed.
    let found = read("8DA05F219B06B6AF189400CBC33F");
    assert_eq!((found.ground_speed_mps, found.track_rad), (None, None));
    near(found.vertical_rate_mps, -2304.0 * FT / 60.0, 1e-9);
}

#[test]
fn replies_and_all_calls() {
    let found = read("2A00516D492B80");
    assert_eq!(
        (found.address, found.mode_3a, found.is_reply),
        (0x51_0af9, Some(0o0356), true)
    );
    let found = read("A02014B400000000000000F9D514");
    near(found.altitude_m, 32_300.0 * FT, 1e-6);
    assert_eq!(read("5D484FDEA248F5").address, 0x48_4fde);
}

#[test]
fn states() {
    let found = read("8DA2C1B6E112B600000000760759");
    assert_eq!(
        (found.emergency, found.mode_3a),
        (observations::Emergency::None, Some(0o6513))
    );
    let found = read("8DA05629EA21485CBF3F8CADAEEB");
    near(found.selected_altitude_m, 16_992.0 * FT, 1e-6);
    assert_eq!((found.accuracy, found.version), (Some((9, 3)), Some(2)));
}

/// Values of another decoder for each transmission; of a transmission that comes twice, both rows are one.
#[test]
fn a_recording_of_one_aircraft_has_the_values_of_another_decoder() {
    let (Some(octets), Some(expected)) = (
        recording("round4/beast/one_aircraft.beast"),
        recording("round4/beast/expected.csv"),
    ) else {
        return;
    };
    let (mut frames, mut taken) = (Vec::new(), FrameReader::default());
    taken.take(&octets, &mut |framed| match framed {
        Framed::Frame(frame, stamp) if !frames.contains(&(frame, stamp)) => frames.push((frame, stamp)),
        Framed::Frame(..) => {}
        other => panic!("{other:?}"),
    });
    let mut places = Vec::new();
    let mut whole = reader(None);
    whole.take(&octets, None, &mut |output| {
        assert_eq!(output.clock, FrameClock::Ticks);
        places.extend(observed(&[output]).map(|observation| observation.geodetic.unwrap()));
    });
    let expected = String::from_utf8(expected).unwrap();
    let mut rows = expected.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let mut places = places.into_iter();
    let mut compared = 0;
    for (frame, _) in frames {
        let found = ModeSMessage::read(&frame).unwrap().unwrap();
        let kind = match (found.callsign, found.position, found.ground_speed_mps) {
            (Some(_), ..) => "1",
            (_, Some(_), _) => "3",
            (.., Some(_)) => "4",
            _ => continue,
        };
        let row = rows.next().unwrap();
        assert_eq!((row[1], row[2]), (kind, format!("{:06X}", found.address).as_str()));
        let callsign = found
            .callsign
            .map(|callsign| String::from_utf8(callsign.to_vec()).unwrap());
        assert_eq!(callsign.unwrap_or_default(), row[3]);
        let numbers = [4, 5, 6, 7, 8].map(|place| row[place].parse::<f64>().ok());
        let track = found.track_rad.map(f64::to_degrees);
        let altitude = found.altitude_m.map(|altitude_m| altitude_m / FT);
        let speed = found.ground_speed_mps.map(|speed| speed / KT);
        for (own, other) in [altitude, speed, track].into_iter().zip(numbers) {
            assert_eq!(own.is_some(), other.is_some(), "{row:?}");
            assert!(
                own.zip(other).is_none_or(|(own, other)| (own - other).abs() < 1.0),
                "{row:?} {own:?}"
            );
        }
        if let (Some(latitude), Some(longitude)) = (numbers[3], numbers[4]) {
            let found = places.next().unwrap().map(f64::to_degrees);
            assert!(
                (found[0] - latitude).abs() < 1e-5 && (found[1] - longitude).abs() < 1e-5,
                "{row:?}"
            );
        }
        compared += 1;
    }
    assert_eq!((compared, places.next()), (15, None));
    let counters = whole.counters();
    assert_eq!((counters.accepted + counters.refused_sum(), counters.other), (40, 0));
    assert_eq!(counters.refused_sum(), counters.refused(ModeSRefusal::Repeated));
}
