//! Observations of independent non-cooperative surveillance, of records that are written by hand, byte by byte.

use asterix::categories::{CAT004_V1_13, CAT015, CAT016_V1_0};
use asterix::{Category, Decoder, Mode};
use frames::time::NS_PER_S;
use messages::{Identity, TrackState};
use observations::{Axes, Observation, Position, Quality};

use super::{Reading, read};

fn reading(table: &'static Category, parts: &[&[u8]]) -> Reading {
    let body = parts.concat();
    let block = [&[table.number, 0, body.len() as u8 + 3], &body[..]].concat();
    let mut decoder = Decoder::new(Mode::Strict).with_table(table);
    let mut records = decoder.records(&block);
    let reading = read(&records.next().unwrap().unwrap());
    assert!(records.next().is_none());
    reading
}

fn target(table: &'static Category, parts: &[&[u8]]) -> Observation {
    match reading(table, parts) {
        Reading::Target(observation) => observation,
        other => panic!("{other:?}"),
    }
}

fn near(found: Option<[f64; 2]>, expected: [f64; 2]) -> bool {
    let found = found.expect("a value");
    (0..2).all(|i| (found[i] - expected[i]).abs() <= 1e-9 * expected[i].abs().max(1.0))
}

/// A measurement track with position, height, velocity and climb, and their deviations.
fn track(kind: u8, descriptor: u8, status: u8) -> Vec<u8> {
    [
        &[0xD7, 0x87, 0xA0][..],         // FRN 1, 2, 4, 6, 7; 8, 13, 14; 15, 17
        &[25, 9],                        //
        &[kind << 1],                    //
        &[descriptor],                   //
        &[0x54, 0x60, 0x40],             // 12:00:00.5
        &[0x01, 0x2C],                   // 300
        &[status],                       //
        &[0xA0],                         // P84 and HPP
        &[0x20, 0, 0, 0, 0xF8, 0, 0, 0], // 45° N, 11.25° W
        &[0, 40, 0, 80, 0x40],           // 10 m, 20 m, 0.5
        &[0x80, 0x01, 0x86, 0xA0],       // 1000 m
        &[0xA0],                         // HV and SDHV
        &[0x02, 0x71, 0x0F, 0xD8, 0xF0], // 100 m/s east, 100 m/s south
        &[0, 200, 0, 100, 0xC0],         // 2 m/s, 1 m/s, -0.5
        &[0x80, 0xFF, 0xFF, 0x38],       // −2 m/s
    ]
    .concat()
}

#[test]
fn a_track_has_position_velocity_and_their_errors() {
    for table in CAT015 {
        let found = target(table, &[&track(2, 0x00, 0x00)]);
        assert_eq!((found.sac_sic, found.track_number), (Some((25, 9)), Some(300)));
        assert_eq!(found.time_of_day_ns, Some(43_200 * NS_PER_S + NS_PER_S / 2));
        assert!(
            near(found.geodetic, [45_f64.to_radians(), -11.25_f64.to_radians()]),
            "{found:?}"
        );
        assert_eq!(found.position(), found.geodetic.map(Position::Geodetic));
        assert_eq!(found.quality, Quality::Covariance([100.0, 100.0, 400.0]));
        assert!(near(found.velocity, [100.0, -100.0]), "{found:?}");
        assert_eq!(found.axes, Axes::Target);
        let [xx, xy, yy] = found.velocity_covariance.unwrap();
        assert!(near(Some([xx, xy]), [4.0, -1.0]) && (yy - 1.0).abs() < 1e-9);
        assert!(near(
            found
                .ellipsoid_height_m
                .zip(found.vertical_rate_mps)
                .map(|(h, v)| [h, v]),
            [1000.0, -2.0]
        ));
        assert_eq!(found.geometric_height_m, found.ellipsoid_height_m);
        assert_eq!((found.secondary, found.identity), (Some(false), Identity::default()));
        assert_eq!(
            (found.state, found.plot, found.test),
            (TrackState::Confirmed, false, false)
        );
    }
}

#[test]
fn kind_and_status_are_those_of_the_track() {
    let of = |kind, descriptor, status| target(CAT015[0], &[&track(kind, descriptor, status)]);
    assert!(of(1, 0, 0).plot && of(3, 0, 0).plot && !of(4, 0, 0).plot);
    assert_eq!(of(5, 0, 0).state, TrackState::Terminated);
    assert_eq!(of(2, 0, 0x20).state, TrackState::Terminated);
    assert_eq!(of(2, 0, 0x02).state, TrackState::Tentative);
    assert_eq!(of(2, 0, 0x08).state, TrackState::Coasted);
    assert!(of(2, 0x10, 0).field_monitor && !of(2, 0x10, 0).test);
    assert!(of(2, 0x20, 0).test && of(2, 0x30, 0).test);
}

#[test]
fn a_sensor_of_one_place_has_range_and_azimuth() {
    // Range 12,345.6 m, radial speed −10 m/s, azimuth 90°.
    let plot = |descriptor: u8, range: [u8; 3]| {
        target(
            CAT015[2],
            &[
                &[0xD1, 0x01, 0x07, 0x80],
                &[25, 9],
                &[3 << 1],
                &[descriptor],
                &[0x80],
                &range,
                &[0x80, 0xFF, 0xFC, 0x18],
                &[0x80, 0x40, 0x00],
            ],
        )
    };
    let found = plot(0x00, [0x01, 0xE2, 0x40]);
    assert!(
        near(found.slant_polar, [12_345.6, std::f64::consts::FRAC_PI_2]),
        "{found:?}"
    );
    assert!((found.doppler_mps.unwrap() + 10.0).abs() < 1e-9);
    assert_eq!((found.quality, found.track_number), (Quality::Unstated, None));
    // The detour by way of the target, of several places; and a range that cannot be a distance.
    let found = plot(0x40, [0x01, 0xE2, 0x40]);
    assert_eq!((found.position(), found.doppler_mps), (None, None));
    assert_eq!(plot(0x00, [0xFF, 0xFF, 0xFF]).position(), None);
}

#[test]
fn configurations_and_safety_nets_are_no_targets() {
    assert_eq!(reading(&CAT016_V1_0, &[&[0xA0], &[25, 9], &[1]]), Reading::Other);
    assert_eq!(reading(&CAT004_V1_13, &[&[0xC0], &[25, 9], &[7]]), Reading::Other);
}
