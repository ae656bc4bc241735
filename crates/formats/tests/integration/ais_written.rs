//! Lines of simulated ships: the values that the reader finds again, and errors as large as stated.

use std::f64::consts::TAU;

use formats::ais::{AisClass, AisOutput, AisPosition, AisStaticData};
use frames::{Geodetic, SystemFrame};
use observations::{NavigationStatus, Observation, Quality, RADIUS95_SIGMAS, Statement, TargetCategory};
use test_support::Random;

use crate::ais::reader;
use crate::normalised::{Nees, normal};

const S: i64 = 1_000_000_000;
/// 2020-01-01, 12:00:20.
const RECEIVED_NS: i64 = (1_577_836_800 + 43_220) * S;
const KT: f64 = 1852.0 / 3600.0;

fn position(class: AisClass) -> AisPosition {
    AisPosition {
        mmsi: 431_000_123,
        class,
        position_deg: [-34.750_01, 139.350_02],
        is_accurate: true,
        speed_kt: 12.34,
        course_deg: 359.97,
        heading_deg: Some(359.6),
        second: 18,
        navigation: 5,
    }
}

fn statics(class: AisClass) -> AisStaticData<'static> {
    AisStaticData {
        mmsi: 431_000_123,
        class,
        name: "Sea 12 (of Edo)",
        callsign: "SEA012",
        ship_type: 70,
        distances_m: [150, 50, 10, 20],
    }
}

fn outputs(text: &str) -> Vec<AisOutput> {
    let (mut reader, mut found) = (reader(), Vec::new());
    for line in text.lines() {
        let taken = reader.take(0, line.as_bytes(), RECEIVED_NS, |_, output| found.push(output));
        taken.unwrap_or_else(|error| panic!("{error}"));
    }
    found
}

fn ship(found: &[AisOutput]) -> Observation {
    let target = found.iter().rev().find_map(|output| match output {
        AisOutput::Target(observation) => Some(*observation),
        _ => None,
    });
    target.unwrap()
}

#[test]
fn positions_are_found_again() {
    for class in [AisClass::A, AisClass::B] {
        let mut text = String::new();
        position(class).write('B', &mut text);
        assert!(
            text.lines().all(|line| line.len() <= 80) && text.ends_with("\r\n"),
            "{text}"
        );
        let found = outputs(&text);
        let ship = ship(&found);
        let [latitude, longitude] = ship.geodetic.unwrap().map(f64::to_degrees);
        assert!((latitude + 34.750_01).abs() < 1e-6 && (longitude - 139.350_02).abs() < 1e-6);
        let [east, north] = ship.velocity.unwrap();
        assert!((north - 12.3 * KT).abs() < 1e-9 && east.abs() < 1e-9, "{east} {north}");
        assert_eq!(ship.track_number, Some(431_000_123));
        // The antenna of a ship of class A is somewhere along a hull that points north.
        match (class, ship.quality) {
            (AisClass::A, Quality::Covariance([east, cross, north])) => {
                assert!((east.sqrt() - 4.085).abs() < 1e-3 && (north.sqrt() - 40.21).abs() < 0.01 && cross == 0.0);
            }
            (AisClass::B, quality) => assert_eq!(quality, Quality::Radius95(10.0)),
            other => panic!("{other:?}"),
        }
        assert_eq!(ship.time_of_day_ns, Some(43_218 * S));
        let moored = |output: &AisOutput| {
            matches!(
                output,
                AisOutput::Statement(Statement {
                    navigation: NavigationStatus::Moored,
                    ..
                })
            )
        };
        assert_eq!(found.iter().any(moored), class == AisClass::A);
    }
}

#[test]
fn static_data_are_found_again() {
    for (class, sentences) in [(AisClass::A, 2), (AisClass::B, 2)] {
        let mut text = String::new();
        statics(class).write('A', 7, &mut text);
        assert_eq!(text.lines().count(), sentences, "{text}");
        position(class).write('A', &mut text);
        let found = outputs(&text);
        let stated = found.iter().find_map(|output| match output {
            AisOutput::Statement(statement) => Some(*statement),
            _ => None,
        });
        let stated = stated.unwrap();
        assert_eq!(
            (stated.category, stated.size_m),
            (TargetCategory::Cargo, Some([200.0, 30.0]))
        );
        let ship = ship(&found);
        assert_eq!(ship.identity.name(), Some("SEA 12 (OF EDO)"));
        assert_eq!(ship.identity.callsign(), Some("SEA012"));
        // The centre lies 50 m ahead of the antenna, and 5 m to starboard.
        let antenna = Geodetic::from_degrees(-34.750_01, 139.350_02, 0.0).unwrap();
        let [latitude, longitude] = ship.geodetic.unwrap().map(f64::to_degrees);
        let centre = SystemFrame::at(antenna).to_local(Geodetic::from_degrees(latitude, longitude, 0.0).unwrap());
        assert!(
            (centre[1] - 50.0).abs() < 0.3 && (centre[0] - 5.0).abs() < 0.3,
            "{centre:?}"
        );
    }
}

#[test]
fn values_beyond_the_messages_are_cut() {
    let mut text = String::new();
    AisPosition {
        speed_kt: 1e6,
        course_deg: -0.01,
        heading_deg: None,
        second: 99,
        navigation: 200,
        ..position(AisClass::A)
    }
    .write('A', &mut text);
    AisStaticData {
        name: "a name that is longer than twenty, ä",
        distances_m: [9999; 4],
        ..statics(AisClass::A)
    }
    .write('A', 255, &mut text);
    assert!(!outputs(&text).is_empty());
}

/// The mean normalised square of errors of position and of velocity, with errors as receivers have them.
fn nees(is_accurate: bool, seed: u64) -> [f64; 2] {
    let mut random = Random::new(seed);
    let frame = SystemFrame::at(Geodetic::from_degrees(34.75, 139.35, 0.0).unwrap());
    let sigma_m = if is_accurate { 10.0 } else { 30.0 } / RADIUS95_SIGMAS;
    let (mut of_position, mut of_velocity) = (Nees::default(), Nees::default());
    for count in 0..2000 {
        let true_m = [random.between(-3e4, 3e4), random.between(-3e4, 3e4)];
        let (speed_kt, course_rad) = (random.between(0.0, 25.0), random.between(0.0, TAU));
        let true_mps = [course_rad.sin(), course_rad.cos()].map(|part| part * speed_kt * KT);
        let measured_m = true_m.map(|place| place + sigma_m * normal(&mut random));
        // Limits of receivers (IEC 61108-1) at 95 %.
        let speed_sigma_kt = 0.2_f64.max(0.02 * speed_kt) / 1.96;
        let across_sigma_kt = 0.2_f64.max(speed_kt * if speed_kt > 17.0 { 1.0_f64 } else { 3.0 }.to_radians()) / 1.96;
        let along_kt = speed_kt + speed_sigma_kt * normal(&mut random);
        let across_kt = across_sigma_kt * normal(&mut random);
        let place = frame.to_geodetic([measured_m[0], measured_m[1], 0.0]);
        let mut text = String::new();
        let mmsi = 431_000_000 + count;
        AisStaticData {
            mmsi,
            distances_m: [50, 50, 8, 8],
            ..statics(AisClass::A)
        }
        .write('A', 0, &mut text);
        AisPosition {
            mmsi,
            position_deg: [place.latitude_deg(), place.longitude_deg()],
            is_accurate,
            speed_kt: along_kt.hypot(across_kt),
            course_deg: (course_rad + across_kt.atan2(along_kt)).to_degrees(),
            ..position(AisClass::A)
        }
        .write('A', &mut text);
        let ship = ship(&outputs(&text));
        let [latitude, longitude] = ship.geodetic.unwrap().map(f64::to_degrees);
        let found_m = frame.to_local(Geodetic::from_degrees(latitude, longitude, 0.0).unwrap());
        of_position.take_quality([found_m[0] - true_m[0], found_m[1] - true_m[1]], ship.quality);
        if let (Some([east, north]), Some(covariance)) = (ship.velocity, ship.velocity_covariance) {
            // Meridians of the ship and of the frame's origin differ by 0.2° at most.
            of_velocity.take([east - true_mps[0], north - true_mps[1]], covariance);
        }
    }
    [of_position.mean(), of_velocity.mean()]
}

#[test]
fn errors_of_ships_are_as_stated() {
    for is_accurate in [false, true] {
        let [position, velocity] = nees(is_accurate, 1);
        println!(
            "AIS, accuracy flag {}: NEES of position {position:.2}, of velocity {velocity:.2}",
            u8::from(is_accurate)
        );
        assert!(
            (0.7..1.4).contains(&position) && (0.7..1.4).contains(&velocity),
            "{position} {velocity}"
        );
    }
}
