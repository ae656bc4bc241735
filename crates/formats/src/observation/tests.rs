//! Observations made of the items of each category. The records are written by hand, byte by byte.

use std::f64::consts::{FRAC_PI_2, PI};

use frames::time::NS_PER_S;
use messages::Identity;

use super::navigation::*;
use super::*;
use asterix::categories::*;
use asterix::{Category, Decoder, Mode};
use observations::Position;

/// Reads a record, given as the octets of its parts.
fn reading(table: &'static Category, parts: &[&[u8]]) -> Reading {
    let body = parts.concat();
    let [high, low] = (body.len() as u16 + 3).to_be_bytes();
    let block = [&[table.number, high, low], &body[..]].concat();
    let mut decoder = Decoder::new(Mode::Strict).with_table(table);
    let mut records = decoder.records(&block);
    let reading = read(&records.next().expect("a record").expect("a good record"));
    assert!(records.next().is_none(), "one record");
    reading
}

fn target(table: &'static Category, parts: &[&[u8]]) -> Observation {
    match reading(table, parts) {
        Reading::Target(observation) => observation,
        other => panic!("{other:?}"),
    }
}

fn near(found: [f64; 2], expected: [f64; 2]) -> bool {
    (0..2).all(|i| (found[i] - expected[i]).abs() <= 1e-9 * expected[i].abs().max(1.0))
}

/// 12:00:00.5 and what it is in nanoseconds.
const NOON: &[u8] = &[0x54, 0x60, 0x40];
const NOON_NS: i64 = 43_200 * NS_PER_S + NS_PER_S / 2;

/// A track of CAT048 without its descriptor, its track status and its warnings.
fn radar_track(descriptor: &[u8], status: &[u8], warnings: &[u8]) -> Observation {
    target(
        &CAT048_V1_31,
        &[
            &[0xFD, 0xDF, if warnings.is_empty() { 0x83 } else { 0xC3 }, 0x80],
            &[25, 201],
            NOON,
            descriptor,
            &[0x64, 0x00, 0x40, 0x00],             // 100 NM, 90°
            &[0x0F, 0xC0],                         // 7700
            &[0x05, 0x78],                         // FL 350
            &[0x3C, 0x65, 0x0C],                   // address
            &[0x10, 0xC2, 0x36, 0xD4, 0x18, 0x20], // DLH65A
            &[0x0D, 0xEB],                         // 3563
            &[0x32, 0x00, 0x00, 0x00],             // 100 NM east
            &[0x08, 0x00, 0x40, 0x00],             // 1/8 NM/s towards 90°
            status,
            &[2, 1, 4, 16], // 2/128 NM, 1/128 NM, 4/16384 NM/s, 16/4096 of a circle
            warnings,
            &[0x28, 0x00],                               // an alert, in the air
            &[0x30, 0x80, 0x00, 0x00, 0x00, 0x00, 0x00], // an advisory
        ],
    )
}

/// Roll-call, special position identification; military emergency.
const SEEN: &[u8] = &[0xA5, 0x10];

#[test]
fn a_radar_track_has_a_plot_behind_it() {
    let track = radar_track(SEEN, &[0x01, 0x10], &[]);
    assert_eq!((track.sac_sic, track.time_of_day_ns), (Some((25, 201)), Some(NOON_NS)));
    assert_eq!(
        (track.track_number, track.plot, track.state),
        (Some(3563), false, TrackState::Confirmed)
    );
    let identity = Identity::default().with_mode_3a(0o7700).with_address(0x3C_650C);
    assert_eq!(track.identity, identity.with_callsign(*b"DLH65A  "));
    assert!(near(track.cartesian.unwrap(), [185_200.0, 0.0]));
    assert_eq!(
        track.plane,
        Plane::Stereographic,
        "the tracker has corrected for slant range"
    );
    assert!(near(track.slant_polar.unwrap(), [185_200.0, FRAC_PI_2]));
    assert_eq!((track.polar, track.geodetic), (None, None));
    assert_eq!(
        track.position(),
        Some(Position::Cartesian(track.cartesian.unwrap(), Plane::Stereographic))
    );
    assert_eq!(
        track.polar_position(),
        Some(Position::Slant(track.slant_polar.unwrap()))
    );
    assert!(near(track.velocity.unwrap(), [231.5, 0.0]));
    assert_eq!(track.axes, Axes::Target);
    assert!((track.pressure_altitude_m.unwrap() - 10_668.0).abs() < 1e-9);
    assert_eq!((track.geometric_height_m, track.on_ground), (None, false));
    let everything = alert_bits::SPECIAL_IDENTIFICATION
        | alert_bits::EMERGENCY
        | alert_bits::TRANSPONDER_ALERT
        | alert_bits::RESOLUTION_ADVISORY;
    assert_eq!(track.alerts.raised, everything);
    let Quality::Covariance([xx, xy, yy]) = track.quality else {
        panic!("{:?}", track.quality);
    };
    assert!(near([xx, yy], [28.9375f64.powi(2), 14.46875f64.powi(2)]) && xy == 0.0);
    // It flies east: the error of speed is along x, that of heading, 231.5 m/s × 1.406°, along y.
    let [xx, xy, yy] = track.velocity_covariance.unwrap();
    assert!((xx - 0.2044).abs() < 1e-4 && xy.abs() < 1e-9, "{xx} {xy}");
    assert!((yy - 5.6819f64.powi(2)).abs() < 1e-2, "{yy}");
}

/// The text of `koseki decode` and the live path read the sign of a level alike, in every edition: an aircraft at a
/// coast under high pressure is below flight level 0.
#[test]
fn levels_below_zero_are_the_same_decoded_and_live() {
    // FL −10 in 14 bits of quarters.
    let octets = (-40i16).to_be_bytes();
    let octets = [octets[0] & 0x3F, octets[1]];
    for (tables, fspec) in [(CAT048, &[0x84][..]), (CAT020, &[0x81, 0x20][..])] {
        for table in tables {
            let record = [fspec, &[25, 201], &octets[..]].concat();
            let seen = target(table, &[&record]);
            assert!(
                (seen.pressure_altitude_m.unwrap() + 304.8).abs() < 1e-9,
                "{table}: {seen:?}"
            );
            let block = [&[table.number, 0, record.len() as u8 + 3], &record[..]].concat();
            let mut decoder = Decoder::new(Mode::Strict).with_table(table);
            let decoded = decoder.records(&block).next().unwrap().unwrap();
            let named = asterix::NamedRecord::new(&decoded);
            let level = named.get(&["090", "FL"]).and_then(|level| level.as_f64());
            assert_eq!(level, Some(-10.0), "{table}");
        }
    }
}

#[test]
fn a_radar_says_what_became_of_a_track() {
    let state = |descriptor, status| radar_track(descriptor, status, &[]).state;
    assert_eq!(state(SEEN, &[0x80]), TrackState::Tentative);
    assert_eq!(state(SEEN, &[0x01, 0x80]), TrackState::Terminated);
    assert_eq!(state(&[0x00], &[0x00]), TrackState::Coasted, "not seen in this turn");
    assert_eq!(radar_track(SEEN, &[0x00], &[]).plane, Plane::Slant, "not corrected");
    let secondary = |descriptor: u8| radar_track(&[descriptor], &[0x00], &[]).secondary;
    let detections = [0x00, 0x20, 0x40, 0x60, 0xA0].map(secondary);
    assert_eq!(detections, [None, Some(false), Some(true), Some(true), Some(true)]);
    let beyond = radar_track(&[0xA1, 0x40], &[0x00], &[]);
    assert_eq!(beyond.slant_polar, None, "the range does not fit its item");
    assert!(radar_track(&[0xA1, 0x80], &[0x00], &[]).test && radar_track(&[0xB0], &[0x00], &[]).test);
    assert!(radar_track(&[0xA2], &[0x00], &[]).field_monitor);
}

#[test]
fn a_height_that_the_radar_doubts_is_none() {
    for (warning, doubted) in [(12, true), (18, true), (1, false)] {
        let track = radar_track(SEEN, &[0x00], &[warning << 1]);
        assert_eq!(track.pressure_altitude_m.is_none(), doubted, "{warning}");
    }
}

#[test]
fn a_plot_is_numbered_by_its_address_if_it_has_one() {
    // I048/010, /140, /020, /040, and /220 in the first.
    let with = target(
        &CAT048_V1_31,
        &[
            &[0xF1, 0x80],
            &[25, 201],
            NOON,
            &[0xA0],
            &[0x64, 0, 0x40, 0],
            &[0x3C, 0x65, 0x0C],
        ],
    );
    assert_eq!((with.track_number, with.plot), (Some(0x3C_650C), true));
    let without = target(
        &CAT048_V1_31,
        &[&[0xF0], &[25, 201], NOON, &[0x20], &[0x64, 0, 0x40, 0]],
    );
    assert_eq!((without.track_number, without.plot), (None, true));
    assert_eq!(
        (without.cartesian, without.velocity, without.quality),
        (None, None, Quality::Unstated)
    );
}

#[test]
fn the_older_radar_format_has_plots_and_tracks_and_half_a_time() {
    // A plot: I001/010, /020, /040, /070 and /090, /141.
    let plot = target(
        &CAT001_V1_4,
        &[
            &[0xFA],
            &[25, 13],
            &[0x25, 0x20],
            &[0x32, 0, 0x40, 0],
            &[0x0E, 0x80],
            &[0x05, 0x78],
            &[0x01, 0x40],
        ],
    );
    assert_eq!((plot.track_number, plot.plot, plot.time_of_day_ns), (None, true, None));
    assert_eq!(plot.truncated_time_ns, Some(2_500_000_000));
    assert!(near(plot.slant_polar.unwrap(), [185_200.0, FRAC_PI_2]), "1/128 NM each");
    assert_eq!(plot.identity.mode_3a(), Some(0o7200));
    let alerts = alert_bits::SPECIAL_IDENTIFICATION | alert_bits::UNLAWFUL_INTERFERENCE;
    assert_eq!(plot.alerts.raised, alerts, "7500, says the radar");
    // A track: I001/010, /020, /161, /042, /200 and /170.
    let track = |status: &[u8]| {
        target(
            &CAT001_V1_4,
            &[
                &[0xED, 0x04],
                &[25, 13],
                &[0xA0],
                &[0x12, 0x34],
                &[0x19, 0x00, 0xE7, 0x00],
                &[0x08, 0x00, 0x00, 0x00],
                status,
            ],
        )
    };
    let found = track(&[0x00]);
    assert_eq!(
        (found.track_number, found.plot, found.state),
        (Some(0x1234), false, TrackState::Confirmed)
    );
    assert!(near(found.cartesian.unwrap(), [185_200.0, -185_200.0]), "1/64 NM each");
    assert_eq!((found.plane, found.axes), (Plane::Slant, Axes::Sensor));
    assert!(near(found.velocity.unwrap(), [0.0, 231.5]));
    assert_eq!(track(&[0x80]).state, TrackState::Tentative);
    assert_eq!(track(&[0x01, 0x80]).state, TrackState::Terminated);
}

/// An ADS-B report of CAT021.
fn ads_b(descriptor: &[u8], quality: &[u8], version: u8) -> Observation {
    target(
        &CAT021_V2_4,
        &[
            // 010, 040, 130 | 080, 073, 074 | 140, 090, 210, 070, 145 | 200, 157, 160 | 170
            &[0xC5, 0x1D, 0x7B, 0x59, 0x80],
            &[25, 201],
            descriptor,
            &[0x20, 0x00, 0x00, 0xC0, 0x00, 0x00], // 45° N, 90° W
            &[0x3C, 0x65, 0x0C],
            NOON,
            &[0x50, 0x00, 0x00, 0x00], // the next second, and a quarter of it
            &[0x10, 0x00],             // 4096 × 6.25 ft
            quality,
            &[version << 3 | 2],
            &[0x0E, 0x80],
            &[0x05, 0x78],
            &[0x0E],                   // minimum fuel, code changed
            &[0x80, 0x00],             // more than can be sent
            &[0x08, 0x00, 0x40, 0x00], // 1/8 NM/s towards 90°
            &[0x10, 0xC2, 0x36, 0xD4, 0x18, 0x20],
        ],
    )
}

#[test]
fn an_ads_b_report_is_numbered_by_its_address_and_timed_by_its_reception() {
    let found = ads_b(&[0x01, 0x40], &[0x01, 0x10], 2);
    assert_eq!(found.track_number, Some(0x3C_650C));
    assert_eq!(found.time_of_day_ns, Some(43_201 * NS_PER_S + NS_PER_S / 4));
    assert!(near(found.geodetic.unwrap(), [PI / 4.0, -FRAC_PI_2]));
    assert!(near(found.velocity.unwrap(), [231.5, 0.0]) && found.axes == Axes::Target);
    assert!((found.pressure_altitude_m.unwrap() - 10_668.0).abs() < 1e-9);
    assert!((found.geometric_height_m.unwrap() - 4096.0 * 6.25 * 0.3048).abs() < 1e-9);
    assert_eq!((found.vertical_rate_mps, found.on_ground), (None, true));
    assert_eq!(
        found.alerts.raised,
        alert_bits::MINIMUM_FUEL | alert_bits::TRANSPONDER_ALERT
    );
    assert_eq!(
        (found.identity.mode_3a(), found.identity.callsign()),
        (Some(0o7200), Some("DLH65A"))
    );
    assert!(!found.suspect && !found.test);
}

#[test]
fn a_position_that_the_ground_station_refutes_is_suspect() {
    for (third, suspect) in [(0x02, true), (0x04, true), (0x08, true), (0x20, true), (0x50, false)] {
        let found = ads_b(&[0x01, 0x01, third], &[0x00], 0);
        assert_eq!(found.suspect, suspect, "{third:02X}");
    }
}

#[test]
fn each_generation_of_ads_b_says_differently_how_good_it_is() {
    // NUCr or NACv 2, NUCp or NIC 7; then SIL 3 and NACp 9.
    let one = &[0x4E][..];
    let two = &[0x4F, 0x72][..];
    let radius = |octets: &[u8], version| match ads_b(&[0x00], octets, version).quality {
        Quality::Radius95(radius) => (10.0 * radius).round() / 10.0,
        other => panic!("{other:?}"),
    };
    assert_eq!(radius(one, 0), 92.6, "NUCp");
    assert_eq!(radius(two, 0), 92.6, "NUCp, whatever follows");
    assert_eq!(radius(two, 1), 30.0, "NACp");
    assert_eq!(radius(two, 2), 30.0);
    assert_eq!(radius(&[0x4F, 0x12], 2), 30.0, "NACp, whatever SIL");
    assert_eq!(radius(&[0x41, 0x72], 2), 30.0, "or NIC");
    // Without NACp, NIC and SIL decide whether the accuracy is the configured one, or unknown.
    for (octets, expected) in [
        (one, Quality::Unstated),
        (&[0x4F, 0x60], Quality::Unstated),
        (&[0x4F, 0x20], Quality::Unstated),
        (&[0x4F, 0x00], Quality::Unknown),
        (&[0x41, 0x60], Quality::Unknown),
        (&[0x40], Quality::Unknown),
    ] {
        assert_eq!(ads_b(&[0x00], octets, 2).quality, expected, "{octets:02X?}");
    }
    assert_eq!(radius(&[0x4F, 0x12], 0), 92.6, "version 0 has neither");
    let [xx, xy, yy] = ads_b(&[0x00], one, 2).velocity_covariance.unwrap();
    assert!((xx.sqrt() - 3.0 / 2.4477).abs() < 1e-4 && xy == 0.0 && yy == xx);
    assert_eq!(
        ads_b(&[0x00], &[0x0E], 2).velocity_covariance,
        None,
        "NACv 0 says nothing"
    );
}

#[test]
fn every_step_of_a_category_is_less_accurate() {
    let radius = |of: fn(u8) -> Quality, category| match of(category) {
        Quality::Radius95(radius) => radius,
        other => panic!("{other:?}"),
    };
    for category in 1..9 {
        assert!(radius(radius_of_nucp, category) > radius(radius_of_nucp, category + 1));
    }
    for category in 1..11 {
        assert!(radius(radius_of_nacp, category) > radius(radius_of_nacp, category + 1));
    }
    assert_eq!(
        (radius_of_nacp(0), radius_of_nacp(12)),
        (Quality::Unknown, Quality::Unknown)
    );
}

#[test]
fn ads_b_times_fall_back_on_what_there_is() {
    // I021/010, /040, and one of /071, /073, /072, /075, /077.
    let timed = |fspec: &[u8], time: &[u8]| target(&CAT021_V2_4, &[fspec, &[25, 201], &[0x00], time]).time_of_day_ns;
    assert_eq!(timed(&[0xC8], NOON), Some(NOON_NS));
    assert_eq!(timed(&[0xC1, 0x08], NOON), Some(NOON_NS));
    assert_eq!(timed(&[0xC1, 0x80], NOON), Some(NOON_NS));
    assert_eq!(timed(&[0xC1, 0x02], NOON), Some(NOON_NS));
    assert_eq!(timed(&[0xC1, 0x01, 0x01, 0x02], NOON), Some(NOON_NS));
    assert_eq!(timed(&[0xC0], &[]), None);
    // 23:59:59.75 rounded up, and the fraction of the second before.
    let midnight = target(
        &CAT021_V2_4,
        &[&[0xC1, 0x0C], &[25, 201], &[0x00], &[0, 0, 0], &[0xB0, 0, 0, 0]],
    );
    assert_eq!(midnight.time_of_day_ns, Some(86_399 * NS_PER_S + 3 * NS_PER_S / 4));
}

/// A system track of CAT062: I062/010, /070, /105 or not, /100, /185 | /060, /380, /040, /080 | /136, /130, /135, /220
/// | /500.
fn system_track(geodetic: bool, status: &[u8], barometric: [u8; 2], accuracy: &[u8]) -> Observation {
    let place: &[u8] = if geodetic {
        &[0x00, 0x80, 0, 0, 0xFF, 0, 0, 0]
    } else {
        &[]
    };
    target(
        &CAT062_V1_18,
        &[
            &[if geodetic { 0x9F } else { 0x97 }, 0x5D, 0x3D, 0x04],
            &[25, 100],
            NOON,
            place,
            &[0x00, 0x00, 0x02, 0xFF, 0xFF, 0xFE], // 1 m, -1 m
            &[0x00, 0x04, 0xFF, 0xF8],             // 1 m/s, -2 m/s
            &[0x0E, 0x80],
            &[0xC1, 0x30, 0x3C, 0x65, 0x0C, 0x10, 0xC2, 0x36, 0xD4, 0x18, 0x20], // ADR, ID …
            &[0x28, 0x00],                                                       // … COM: an alert
            &[0x02, 0x05],                                                       // … SAB: on the ground, unlawful
            &[0x12, 0x34],
            status,
            &[0x05, 0x78],
            &[0x10, 0x00],
            &barometric,
            &[0x00, 0x60], // 600 ft/min
            accuracy,
        ],
    )
}

#[test]
fn a_system_track_prefers_its_geographic_position_and_uncorrected_altitude() {
    let found = system_track(true, &[0x00], [0x05, 0x70], &[0x00]);
    assert_eq!(
        (found.track_number, found.time_of_day_ns),
        (Some(0x1234), Some(NOON_NS))
    );
    assert!(near(found.geodetic.unwrap(), [PI / 4.0, -FRAC_PI_2]));
    assert_eq!(found.cartesian, None, "its plane is of a place that is not told");
    assert!(near(found.velocity.unwrap(), [1.0, -2.0]) && found.axes == Axes::Target);
    assert!(
        (found.pressure_altitude_m.unwrap() - 348.0 * 30.48).abs() < 1e-9,
        "the track's, not the last measured"
    );
    let (stated_m, age_ns) = found.transponder_altitude().unwrap();
    assert!(
        (stated_m - 350.0 * 30.48).abs() < 1e-9 && age_ns == 0,
        "the measured one"
    );
    assert!((found.geometric_height_m.unwrap() - 4096.0 * 6.25 * 0.3048).abs() < 1e-9);
    assert!((found.vertical_rate_mps.unwrap() - 3.048).abs() < 1e-9);
    assert_eq!(
        (found.identity.address(), found.identity.callsign()),
        (Some(0x3C_650C), Some("DLH65A"))
    );
    assert!(found.on_ground);
    assert_eq!(
        found.alerts.raised,
        alert_bits::TRANSPONDER_ALERT | alert_bits::UNLAWFUL_INTERFERENCE
    );
    let corrected = system_track(false, &[0x00], [0x85, 0x70], &[0x00]);
    assert!(
        (corrected.pressure_altitude_m.unwrap() - 350.0 * 30.48).abs() < 1e-9,
        "that of the local pressure is none"
    );
    assert!(near(corrected.cartesian.unwrap(), [1.0, -1.0]) && corrected.plane == Plane::Stereographic);
}

#[test]
fn a_system_says_what_became_of_a_track() {
    let state = |status: &[u8]| system_track(true, status, [0, 0], &[0x00]).state;
    assert_eq!(state(&[0x02]), TrackState::Tentative);
    assert_eq!(state(&[0x03, 0x40]), TrackState::Terminated);
    assert_eq!(state(&[0x01, 0x01, 0x01, 0x80]), TrackState::Coasted);
    assert_eq!(
        state(&[0x01, 0x01, 0x01, 0x01, 0x02]),
        TrackState::Coasted,
        "flight plan only"
    );
    assert_eq!(state(&[0x00]), TrackState::Confirmed);
    assert!(system_track(true, &[0x01, 0x80], [0, 0], &[0x00]).test);
    let medical = system_track(true, &[0x41, 0x01, 0x11, 0x01, 0x10], [0, 0], &[0x00])
        .alerts
        .raised;
    let more = alert_bits::SPECIAL_IDENTIFICATION | alert_bits::EMERGENCY | alert_bits::MEDICAL;
    assert_eq!(medical & more, more);
}

#[test]
fn a_system_states_covariances() {
    let quality = |accuracy: &[u8]| system_track(true, &[0x00], [0, 0], accuracy);
    // APC 10 m and 20 m; COV: the root of 100 m² in steps of 0.5 m, negative; ATV 1 m/s and 2 m/s.
    let all = quality(&[0xC4, 0x00, 0x14, 0x00, 0x28, 0xFF, 0xEC, 0x04, 0x08]);
    assert_eq!(all.quality, Quality::Covariance([100.0, -100.0, 400.0]));
    assert_eq!(all.velocity_covariance, Some([1.0, 0.0, 4.0]));
    // APW: 18 steps of 180/2^25 degrees of latitude, half a metre each, and as many of longitude at 45° N.
    let Quality::Covariance([xx, _, yy]) = quality(&[0x20, 0x00, 0x12, 0x00, 0x12]).quality else {
        panic!("a covariance");
    };
    assert!(
        (yy.sqrt() - 18.0 * 0.5965).abs() < 0.01 && (xx / yy - 0.5).abs() < 1e-6,
        "{xx} {yy}"
    );
    assert_eq!(
        quality(&[0x80, 0, 0, 0, 0]).quality,
        Quality::Unstated,
        "zero is no accuracy"
    );
}

#[test]
fn multilateration_uses_the_transponders_own_word() {
    // I020/010, /020, /140, /042 | /220 | | /230
    let found = target(
        &CAT020_V1_10,
        &[
            &[0xE9, 0x09, 0x01, 0x80],
            &[0, 107],
            &[0x40],
            NOON,
            &[0x00, 0x00, 0x02, 0xFF, 0xFF, 0xFE],
            &[0x3C, 0x65, 0x0C],
            &[0x2C, 0x00], // an alert, on the ground
        ],
    );
    assert_eq!((found.track_number, found.plot), (Some(0x3C_650C), true));
    assert_eq!(
        (found.on_ground, found.alerts.raised),
        (true, alert_bits::TRANSPONDER_ALERT)
    );
    assert_eq!(found.plane, Plane::Tangent);
}

#[test]
fn an_advisory_holds_until_it_ends() {
    let advisory = |first: u8, fourth: u8| {
        let records: &[&[u8]] = &[&[0x01, 0x01, 0x01, 0x80], &[0x30, first, 0, fourth, 0, 0, 0]];
        target(&CAT048_V1_31, records).alerts.raised == alert_bits::RESOLUTION_ADVISORY
    };
    assert!(advisory(0x80, 0x00));
    assert!(advisory(0x00, 0x10), "more than one threat");
    assert!(!advisory(0x80, 0x20), "ended");
    assert!(!advisory(0x40, 0x00), "none");
}

#[test]
fn messages_about_the_source_give_its_time() {
    let service = |table, fspec: &[u8], between: &[u8]| reading(table, &[fspec, &[25, 201], between, NOON]);
    for (found, turn_begins) in [
        (service(&CAT002_V1_2, &[0xD0], &[1]), true),
        (service(&CAT002_V1_2, &[0xD0], &[2]), false),
        (service(&CAT019_V1_3, &[0xE0], &[1]), true),
        (service(&CAT023_V1_3, &[0xD0], &[1]), false),
        (service(&CAT034_V1_29, &[0xE0], &[1]), true),
        (service(&CAT063_V1_7, &[0xA0], &[]), false),
        (service(&CAT065_V1_6, &[0xD0], &[1]), false),
        (service(&CAT010_V1_1, &[0xD0], &[2]), true),
    ] {
        let expected = ServiceMessage {
            sac_sic: Some((25, 201)),
            time_of_day_ns: Some(NOON_NS),
            turn_begins,
            turn_ns: None,
        };
        assert_eq!(found, Reading::Service(expected));
    }
}

#[test]
fn messages_of_radars_give_the_time_of_a_turn() {
    let turn_ns = |table, fspec: u8, between: &[u8], turn: [u8; 2]| {
        let found = reading(table, &[&[fspec], &[25, 201], between, NOON, &turn]);
        let Reading::Service(service) = found else {
            panic!("{found:?}");
        };
        service.turn_ns
    };
    // 976/128 s.
    assert_eq!(turn_ns(&CAT034_V1_29, 0b1110_1000, &[1], [3, 208]), Some(7_625_000_000));
    assert_eq!(turn_ns(&CAT002_V1_2, 0b1101_1000, &[1], [3, 208]), Some(7_625_000_000));
    assert_eq!(turn_ns(&CAT034_V1_29, 0b1110_1000, &[1], [0, 0]), None);
}
