//! Completed observations, statements, accuracy, replies, origins, and the bounds of the table.

use formats::mode_s::{ModeSOrigin, ModeSRefusal};
use observations::{Emergency, Quality, TargetCategory};
use test_support::Dice;

use super::*;

const A: u32 = 0x3c_6589;
const HERE: [f64; 2] = [52.25, 4.75];
/// Standard deviation by rounding to knots, metres per second.
const KNOT_SIGMA_MPS: f64 = 1852.0 / 3600.0 / 3.464_101_6;

/// A reader with an aircraft whose next odd frame has a position.
fn paired(head: u8, address: u32) -> ModeSReader {
    let mut reader = reader(None);
    take(&mut reader, &squitter_at(head, address, false), 0.0);
    reader
}

fn squitter_at(head: u8, address: u32, is_odd: bool) -> String {
    let fields = [
        &[(11, 5), (0, 3), (0xc38, 12), (0, 1)][..],
        &compact(HERE, false, is_odd),
    ]
    .concat();
    squitter(head, address, message(&fields))
}

fn position(reader: &mut ModeSReader, after_s: f64) -> Observation {
    observed(&take(reader, &airborne(A, HERE, true), after_s)).unwrap()
}

/// A velocity of 100 kn to the east, with an accuracy category.
fn velocity(accuracy: u64) -> String {
    let fields = [
        (19, 5),
        (1, 3),
        (0, 2),
        (accuracy, 3),
        (0, 1),
        (101, 10),
        (0, 1),
        (1, 10),
        (1, 1),
        (0, 1),
        (11, 9),
    ];
    squitter(0x8d, A, message(&fields))
}

/// An operational status in the air.
pub(super) fn status(version: u64, accuracy: u64, level: u64) -> String {
    let fields = [
        (31, 5),
        (0, 35),
        (version, 3),
        (0, 1),
        (accuracy, 4),
        (0, 2),
        (level, 2),
    ];
    squitter(0x8d, A, message(&fields))
}

#[test]
fn a_position_takes_along_what_was_received_before() {
    let mut reader = paired(0x8d, A);
    take(&mut reader, &velocity(1), 1.0);
    take(&mut reader, "8D4840D6202CC371C32CE0576098", 1.0);
    let found = position(&mut reader, 6.0);
    assert_eq!(
        found
            .velocity
            .map(|[east, north]| ((east * 1e6).round(), north.abs() < 1e-9)),
        Some((51_444_444.0, true))
    );
    let [east, cross, north] = found.velocity_covariance.unwrap();
    assert!((east.sqrt() - (10.0_f64 / 2.447_746_8).hypot(KNOT_SIGMA_MPS)).abs() < 1e-9);
    assert!(cross == 0.0 && north == east);
    assert!((found.vertical_rate_mps.unwrap() - 640.0 * 0.3048 / 60.0).abs() < 1e-9);
    assert_eq!(
        (found.identity.address(), found.identity.callsign()),
        (Some(A), None),
        "another aircraft's"
    );
    assert_eq!(position(&mut reader, 6.3).velocity, None, "too old");
}

#[test]
fn accuracy_is_that_of_the_version() {
    for (status, expected) in [
        // Type 11 of version 0 is an error of 0.05 NM.
        (None, Quality::Radius95(92.6)),
        (Some(status(0, 11, 3)), Quality::Radius95(92.6)),
        (Some(status(2, 11, 3)), Quality::Radius95(3.0)),
        (Some(status(2, 9, 3)), Quality::Radius95(30.0)),
        (Some(status(1, 6, 2)), Quality::Radius95(555.6)),
        // A position without any bound may be as accurate as the category states.
        (Some(status(2, 9, 0)), Quality::Radius95(30.0)),
        // An accuracy that is not known is the configured one where the error is bounded.
        (Some(status(2, 0, 3)), Quality::Unstated),
        (Some(status(2, 0, 0)), Quality::Unknown),
    ] {
        let mut reader = paired(0x8d, A);
        if let Some(status) = &status {
            take(&mut reader, status, 0.5);
        }
        match (position(&mut reader, 1.0).quality, expected) {
            (Quality::Radius95(found), Quality::Radius95(expected)) => {
                assert!((found - expected.hypot(2.447_746_8 * 5.09 / 12f64.sqrt())).abs() < 1e-9);
            }
            (found, expected) => assert_eq!(found, expected),
        }
    }
}

#[test]
fn velocities_on_the_ground_have_the_accuracy_and_the_north_of_the_status() {
    for (is_heading, is_magnetic, expected) in [(0, 1, true), (1, 0, true), (1, 1, false)] {
        let mut reader = reader(Some(RECEIVER));
        take(&mut reader, &surface(A, HERE, false), 0.0);
        let fields = [
            [(31, 5), (1, 3), (0, 8), (2, 3), (0, 21), (2, 3)],
            [(0, 1), (9, 4), (0, 2), (3, 2), (is_heading, 1), (is_magnetic, 1)],
        ];
        take(&mut reader, &squitter(0x8c, A, message(&fields.concat())), 0.5);
        let found = observed(&take(&mut reader, &surface(A, HERE, true), 1.0)).unwrap();
        assert_eq!(
            (found.velocity.is_some(), found.velocity_covariance.is_some()),
            (expected, expected)
        );
        if let Some([variance, ..]) = found.velocity_covariance {
            assert!((variance.sqrt() - (3.0_f64 / 2.447_746_8).hypot(KNOT_SIGMA_MPS)).abs() < 1e-9);
        }
        let Quality::Radius95(radius_m) = found.quality else {
            panic!("{:?}", found.quality)
        };
        assert!((radius_m - 30.0_f64.hypot(2.447_746_8 * 1.27 / 12f64.sqrt())).abs() < 1e-9);
    }
}

#[test]
fn fast_aircraft_and_heights_above_the_ellipsoid() {
    let mut reader = reader(None);
    let at = |is_odd: bool| {
        let head = [(20, 5), (0, 3), (0xc38, 12), (0, 1)];
        squitter(0x8d, A, message(&[&head[..], &compact(HERE, false, is_odd)].concat()))
    };
    take(&mut reader, &at(false), 0.0);
    let fields = [(19, 5), (2, 3), (0, 5), (1, 1), (251, 10), (1, 1), (1, 10)];
    take(&mut reader, &squitter(0x8d, A, message(&fields)), 0.5);
    let found = observed(&take(&mut reader, &at(true), 1.0)).unwrap();
    let [east, north] = found.velocity.unwrap();
    assert!(
        (east + 1000.0 * 1852.0 / 3600.0).abs() < 1e-9 && north.abs() < 1e-9,
        "{east} {north}"
    );
    assert!((found.ellipsoid_height_m.unwrap() - 38_000.0 * 0.3048).abs() < 1e-6);
    assert_eq!((found.pressure_altitude_m, found.velocity_covariance), (None, None));
}

#[test]
fn statements_are_given_when_they_change() {
    let mut reader = reader(None);
    let mut state = |fields: &[(u64, u32)]| stated(&take(&mut reader, &squitter(0x8d, A, message(fields)), 0.0));
    let heavy = [(4, 5), (5, 3), (1, 6)];
    let found = state(&heavy).unwrap();
    assert_eq!((found.track_number, found.category), (A, TargetCategory::Heavy));
    assert_eq!((found.emergency, found.selected_altitude_m), (Emergency::Unknown, None));
    assert_eq!(state(&heavy), None);
    assert_eq!(state(&[(28, 5), (1, 3), (0, 3)]).unwrap().emergency, Emergency::None);
    assert_eq!(
        state(&[(28, 5), (1, 3), (5, 3)]).unwrap().emergency,
        Emergency::UnlawfulInterference
    );
    let selected = |by_plan: u64, steps: u64| [(29, 5), (1, 2), (0, 1), (by_plan, 1), (steps, 11)];
    assert_eq!(
        state(&selected(0, 939)).unwrap().selected_altitude_m,
        Some((938.0 * 32.0 * 0.3048) as f32)
    );
    for none in [selected(0, 939), selected(1, 1000), selected(0, 0)] {
        assert_eq!(state(&none), None);
    }
    assert_eq!(reader.counters().statements, 4);
}

#[test]
fn emergencies_and_advisories_are_alerts() {
    let mut reader = paired(0x8d, A);
    take(
        &mut reader,
        &squitter(0x8d, A, message(&[(28, 5), (1, 3), (4, 3)])),
        0.5,
    );
    take(
        &mut reader,
        &squitter(0x8d, A, message(&[(28, 5), (2, 3), (1, 1)])),
        0.5,
    );
    let alerts = position(&mut reader, 1.0).alerts;
    use messages::alert_bits::{COMMUNICATION_FAILURE, RESOLUTION_ADVISORY};
    assert_eq!(alerts.raised, COMMUNICATION_FAILURE | RESOLUTION_ADVISORY);
    assert!(alerts.has_advisory);
}

#[test]
fn replies_need_a_squitter_and_codes_a_second_reply() {
    let reply = |code: u8, address: u32| sealed(&[0x28, 0, 0x0a, code], address);
    let mut reader = paired(0x8d, A);
    assert_eq!(take(&mut reader, &reply(0x8a, 0x12_3456), 0.5), []);
    assert_eq!(reader.counters().refused(ModeSRefusal::Address), 1);
    take(&mut reader, &reply(0x8a, A), 0.5);
    assert_eq!(position(&mut reader, 1.0).identity.mode_3a(), None);
    take(&mut reader, &reply(0x8a, A), 2.0);
    let code = position(&mut reader, 3.0).identity.mode_3a();
    assert!(code.is_some());
    take(&mut reader, &reply(0x2a, A), 4.0);
    assert_eq!(
        position(&mut reader, 5.0).identity.mode_3a(),
        code,
        "one reply of another code"
    );
    // A minute after the last squitter, nobody has the address.
    take(&mut reader, &reply(0x2a, A), 65.1);
    assert_eq!(reader.counters().refused(ModeSRefusal::Address), 2);
}

#[test]
fn an_altitude_reply_completes_a_position_without_one() {
    let mut reader = reader(Some(RECEIVER));
    let at = |is_odd: bool| {
        squitter(
            0x8d,
            A,
            message(&[&[(11, 5), (0, 16)][..], &compact(HERE, false, is_odd)].concat()),
        )
    };
    take(&mut reader, &at(false), 0.0);
    take(&mut reader, &sealed(&[0x20, 0, 0x0c, 0x38], A), 0.5);
    let found = observed(&take(&mut reader, &at(true), 1.0)).unwrap();
    assert!(
        (found.pressure_altitude_m.unwrap() - 18_800.0 * 0.3048).abs() < 1e-6,
        "{found:?}"
    );
}

#[test]
fn ground_stations_and_anonymous_addresses_are_kept_apart() {
    for (head, origin, is_anonymous) in [
        (0x8d, ModeSOrigin::Own, false),
        (0x90, ModeSOrigin::Own, false),
        (0x91, ModeSOrigin::Own, true),
        (0x92, ModeSOrigin::TisB, false),
        (0x95, ModeSOrigin::TisB, true),
        (0x96, ModeSOrigin::Rebroadcast, false),
    ] {
        let mut reader = paired(0x8d, A);
        // A position of the aircraft itself is no half of a pair with theirs.
        let is_same = origin == ModeSOrigin::Own && !is_anonymous;
        let found = take(&mut reader, &squitter_at(head, A, true), 0.5);
        assert_eq!(place(&found).is_some(), is_same, "{head:x}");
        take(&mut reader, &squitter_at(head, A, false), 1.0);
        let found = take(&mut reader, &squitter_at(head, A, true), 1.5);
        assert_eq!(
            (found[0].origin, found[0].is_anonymous),
            (origin, is_anonymous),
            "{head:x}"
        );
        let observation = observed(&found).unwrap();
        assert_eq!(observation.identity.address(), (!is_anonymous).then_some(A));
        assert_eq!(observation.track_number, Some(A | u32::from(is_anonymous) << 24));
        let counters = reader.counters();
        assert_eq!(counters.tis_b > 0, origin == ModeSOrigin::TisB);
        assert_eq!(counters.rebroadcast > 0, origin == ModeSOrigin::Rebroadcast);
        assert_eq!(counters.anonymous > 0, is_anonymous);
    }
}

#[test]
fn a_full_table_refuses_until_an_aircraft_has_been_silent() {
    let mut reader = reader(None);
    for number in 0..9 {
        take(&mut reader, &airborne(A + number, HERE, false), f64::from(number));
    }
    assert_eq!(reader.counters().refused(ModeSRefusal::Table), 1);
    take(&mut reader, &airborne(A + 8, HERE, false), 60.5);
    assert_eq!(
        reader.counters().refused(ModeSRefusal::Table),
        1,
        "the first is forgotten"
    );
}

#[test]
fn any_right_frame_gives_finite_values_and_is_counted_once() {
    let mut dice = Dice::new(7);
    let mut reader = reader(Some(RECEIVER));
    let (mut observations, mut frames) = (0, 0);
    for step in 0..100_000 {
        let format = dice.one_of(&[0u8, 4, 5, 11, 16, 17, 17, 17, 17, 18, 18, 19, 20, 21, 24, 31]);
        let mut data: Vec<u8> = (0..if format < 16 { 4 } else { 11 })
            .map(|_| dice.bits() as u8)
            .collect();
        data[0] = format << 3 | data[0] & 7;
        // Five aircraft, seen in every kind of message.
        data[1..4].copy_from_slice(&[0, 0, (dice.below(5)) as u8]);
        let overlay = if matches!(format, 11 | 17 | 18) {
            0
        } else {
            dice.below(5) as u32
        };
        let frame = sealed(&data, overlay);
        frames += 1;
        for output in take(&mut reader, &frame, f64::from(step) * 0.01) {
            if let Some(found) = observed(&[output]) {
                observations += 1;
                let numbers = [
                    found.pressure_altitude_m,
                    found.ellipsoid_height_m,
                    found.vertical_rate_mps,
                ];
                let pairs = [found.geodetic, found.velocity];
                assert!(
                    numbers
                        .iter()
                        .flatten()
                        .chain(pairs.iter().flatten().flatten())
                        .all(|value| value.is_finite())
                );
            }
        }
    }
    let counters = reader.counters();
    assert_eq!(counters.accepted + counters.other + counters.refused_sum(), frames);
    assert_eq!(counters.observations, observations);
    assert!(
        observations > 10 && counters.refused(ModeSRefusal::Parity) == 0,
        "{counters:?}"
    );
}

#[test]
fn damaged_frames_are_refused() {
    let mut dice = Dice::new(8);
    let mut reader = reader(Some(RECEIVER));
    let whole = u128::from_str_radix("8D40621D58C382D690C8AC2863A7", 16).unwrap();
    for step in 0..20_000 {
        // The checksum finds every damage of up to five bits.
        let damage = (0..=dice.below(3)).fold(0u128, |damage, _| damage | 1 << dice.below(107));
        take(&mut reader, &format!("{:028X}", whole ^ damage), f64::from(step) * 0.01);
    }
    let counters = reader.counters();
    assert_eq!(
        counters.refused(ModeSRefusal::Parity) + counters.refused(ModeSRefusal::Length),
        20_000
    );
}
