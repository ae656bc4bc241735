//! Detections of a sensor on board: properties, and consistency by Monte Carlo.

use std::f64::consts::{PI, TAU};

use messages::DetectionKind;
use observations::{Detection, DetectionPlatform, StatedHeight, TransponderReply};
use platform::{AngleAt, Assumed, Attitude, Bearings, History, Mount, NoState, Pose, Refusal, State};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use settings::Degrees;

const KINDS: [DetectionKind; 4] = [
    DetectionKind::RangeBearing,
    DetectionKind::RangeBearingElevation,
    DetectionKind::Bearing,
    DetectionKind::BearingElevation,
];

fn detection(kind: DetectionKind, [range_m, bearing, elevation]: [f64; 3], sigmas: [f64; 4]) -> Detection {
    let [sr, sb, se, rate] = sigmas;
    let (values, sigmas) = match kind {
        DetectionKind::RangeBearing => ([range_m, bearing, 0.0], [sr, sb, 0.0, rate]),
        DetectionKind::RangeBearingElevation => ([range_m, bearing, elevation], [sr, sb, se, rate]),
        DetectionKind::Bearing => ([bearing, 0.0, 0.0], [sb, 0.0, 0.0, rate]),
        _ => ([bearing, elevation, 0.0], [sb, se, 0.0, rate]),
    };
    Detection {
        time_of_measurement_ns: 0,
        sensor_id: 1,
        scan: 0,
        detection_id: 0,
        kind,
        values,
        range_rate_mps: None,
        sigmas: Some(sigmas),
        platform_m: [0.0; 3],
        platform: DetectionPlatform::default(),
        height: None,
        velocity: None,
        reply: TransponderReply::default(),
        truth: None,
    }
}

fn pose(angles_rad: [f64; 3], sigma_rad: f64) -> Pose {
    let [heading, pitch, roll] = angles_rad.map(|angle_rad| AngleAt {
        angle_rad,
        rate_radps: 0.0,
        sigma_rad,
    });
    Pose {
        time_ns: 0,
        position_m: [100.0, 200.0, 10.0],
        position_sigma_m: 0.0,
        velocity_mps: Some([0.0; 3]),
        velocity_sigma_mps: 0.0,
        heading: Ok(heading),
        tilt: Ok([pitch, roll]),
    }
}

fn circular(a: f64, b: f64) -> f64 {
    (a - b + PI).rem_euclid(TAU) - PI
}

/// Bearing and elevation of a result, whatever its kind.
fn directions(detection: &Detection) -> (f64, Option<f64>) {
    let [a, b, c] = detection.values;
    match detection.kind {
        DetectionKind::RangeBearing => (b, None),
        DetectionKind::RangeBearingElevation => (b, Some(c)),
        DetectionKind::Bearing => (a, None),
        _ => (a, Some(b)),
    }
}

/// Where the end of a measured range, bearing and elevation lies.
fn point(detection: &Detection) -> [f64; 3] {
    let [range_m, bearing, elevation] = detection.values;
    let ground = range_m * elevation.cos();
    let offset = [
        ground * bearing.sin(),
        ground * bearing.cos(),
        range_m * elevation.sin(),
    ];
    std::array::from_fn(|axis| detection.platform_m[axis] + offset[axis])
}

fn offset_seen(point: [f64; 3], attitude: &Attitude, mount: &Attitude, arm: [f64; 3], place: [f64; 3]) -> [f64; 3] {
    // The inverse of the rotation is the rotation's transpose: from the columns that the axes give.
    let inverse = |attitude: &Attitude, vector: [f64; 3]| {
        let axis = |unit| turn(attitude, unit);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        [
            dot(axis([1.0, 0.0, 0.0]), vector),
            dot(axis([0.0, 1.0, 0.0]), vector),
            dot(axis([0.0, 0.0, 1.0]), vector),
        ]
    };
    let moved = std::array::from_fn(|axis| point[axis] - place[axis]);
    let on_board = inverse(attitude, moved);
    inverse(mount, std::array::from_fn(|axis| on_board[axis] - arm[axis]))
}

/// Turns a vector (right, forward, up) by an attitude, step by step, as the word "heading" reads.
fn turn(attitude: &Attitude, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let (sr, cr) = attitude.roll_rad.sin_cos();
    let (x, z) = (cr * x + sr * z, -sr * x + cr * z);
    let (sp, cp) = attitude.pitch_rad.sin_cos();
    let (y, z) = (cp * y - sp * z, sp * y + cp * z);
    let (sh, ch) = attitude.heading_rad.sin_cos();
    [ch * x + sh * y, -sh * x + ch * y, z]
}

fn polar([x, y, z]: [f64; 3]) -> [f64; 3] {
    let ground = x.hypot(y);
    [ground.hypot(z), x.atan2(y), z.atan2(ground)]
}

fn kind() -> impl Strategy<Value = DetectionKind> {
    prop::sample::select(KINDS.to_vec())
}

proptest! {
    #[test]
    fn a_level_platform_with_its_nose_to_the_north_changes_nothing(
        kind in kind(), range_m in 10.0..1e5f64, bearing in -3.1..3.1f64, elevation in -1.2..1.2f64,
        sigmas in prop::array::uniform4(1e-3..0.1f64),
    ) {
        let measured = detection(kind, [range_m, bearing, elevation], sigmas);
        let carried = Mount::default().carry(&measured, &pose([0.0; 3], 0.0), None, None).unwrap().detection;
        prop_assert_eq!(carried.kind, kind);
        prop_assert_eq!(carried.platform_m, [100.0, 200.0, 10.0]);
        let ((before, up_before), (after, up_after)) = (directions(&measured), directions(&carried));
        prop_assert!(circular(before, after).abs() < 1e-9);
        prop_assert!((up_before.unwrap_or(0.0) - up_after.unwrap_or(0.0)).abs() < 1e-9);
        for (before, after) in measured.sigmas.unwrap().iter().zip(carried.sigmas.unwrap()).take(3) {
            prop_assert!((before - after).abs() < 1e-6 * before.max(1e-9), "{before} {after}");
        }
    }

    #[test]
    fn a_point_measured_on_board_is_found_where_it_is(
        heading in -3.1..3.1f64, pitch in -0.3..0.3f64, roll in -0.5..0.5f64,
        mounting in prop::array::uniform3(-40.0..40.0f64), lever_arm_m in prop::array::uniform3(-30.0..30.0f64),
        target in (-2e4..2e4f64, -2e4..2e4f64, -50.0..2e3f64),
    ) {
        let target = [target.0, target.1, target.2];
        prop_assume!(target[0].hypot(target[1]) > 500.0);
        let mount = Mount {
            lever_arm_m,
            mounting_deg: mounting.map(Degrees::of),
            ..Mount::default()
        };
        let at = pose([heading, pitch, roll], 0.005);
        let attitude = Attitude::of([heading, pitch, roll]);
        let [forward, right, up] = lever_arm_m;
        let fixed = Attitude::of(mounting.map(f64::to_radians));
        let seen = offset_seen(target, &attitude, &fixed, [right, forward, up], at.position_m);
        let measured = detection(DetectionKind::RangeBearingElevation, polar(seen), [20.0, 0.01, 0.01, 0.0]);
        let carried = mount.carry(&measured, &at, None, None).unwrap();
        let found = point(&carried.detection);
        for axis in 0..3 {
            prop_assert!((found[axis] - target[axis]).abs() < 1e-6 * 1e4, "{found:?} {target:?}");
        }
        // A position in the sensor's axes is the same point.
        let position = Detection {
            kind: DetectionKind::Position3,
            values: seen,
            sigmas: Some([20.0, 20.0, 20.0, 0.0]),
            ..measured
        };
        let again = point(&mount.carry(&position, &at, None, None).unwrap().detection);
        for axis in 0..3 {
            prop_assert!((again[axis] - target[axis]).abs() < 1e-2);
        }
    }

    /// A radar without elevation finds the point, too, where the target's height is known.
    #[test]
    fn a_stated_height_puts_a_plot_where_the_target_is(
        heading in -3.1..3.1f64, tilt in prop::array::uniform2(-0.2..0.2f64), yaw in -180.0..180.0f64,
        lever_arm_m in prop::array::uniform3(-30.0..30.0f64),
        ground_m in 1e3..1e5f64, azimuth in -3.1..3.1f64, steepness in -0.3..1.2f64,
    ) {
        let target = [
            100.0 + ground_m * azimuth.sin(),
            200.0 + ground_m * azimuth.cos(),
            10.0 + ground_m * steepness,
        ];
        let mount = Mount {
            lever_arm_m,
            mounting_deg: [Degrees::of(yaw), Degrees::of(1.0), Degrees::of(-2.0)],
            ..Mount::default()
        };
        let at = pose([heading, tilt[0], tilt[1]], 0.005);
        let fixed = Attitude::of([yaw.to_radians(), 1f64.to_radians(), -2f64.to_radians()]);
        let [forward, right, up] = lever_arm_m;
        let attitude = Attitude::of([heading, tilt[0], tilt[1]]);
        let seen = polar(offset_seen(target, &attitude, &fixed, [right, forward, up], at.position_m));
        let plot = in_height(detection(DetectionKind::RangeBearing, seen, [20.0, 0.01, 0.0, 0.0]), target[2]);
        let carried = mount.carry(&plot, &at, None, None).unwrap().detection;
        prop_assert_eq!((carried.kind, carried.height), (DetectionKind::RangeBearingElevation, None));
        let found = point(&carried);
        for axis in 0..3 {
            prop_assert!((found[axis] - target[axis]).abs() < 0.1, "{found:?} {target:?}");
        }
    }

    /// A ship, and all around it, turned together: the result turns with them.
    #[test]
    fn results_turn_with_the_world(
        kind in kind(), heading in -3.1..3.1f64, world in -3.1..3.1f64,
        tilt in prop::array::uniform2(-0.3..0.3f64), bearing in -3.1..3.1f64, elevation in -0.5..0.5f64,
    ) {
        let mount = Mount {
            lever_arm_m: [12.0, -3.0, 20.0],
            ..Mount::default()
        };
        let measured = detection(kind, [5e3, bearing, elevation], [20.0, 0.01, 0.02, 0.0]);
        let at = |heading: f64| pose([heading, tilt[0], tilt[1]], 0.005);
        let one = mount.carry(&measured, &at(heading), None, None).unwrap();
        let other = mount.carry(&measured, &at(heading + world), None, None).unwrap();
        let ((a, up_a), (b, up_b)) = (directions(&one.detection), directions(&other.detection));
        prop_assert!(circular(b, a + world).abs() < 1e-9);
        prop_assert!((up_a.unwrap_or(0.0) - up_b.unwrap_or(0.0)).abs() < 1e-9);
        for (a, b) in one.covariance.iter().flatten().zip(other.covariance.iter().flatten()) {
            prop_assert!((a - b).abs() <= 1e-9 * (1.0 + a.abs()), "{a} {b}");
        }
        let away = |carried: &Detection| [0, 1].map(|axis| carried.platform_m[axis] - at(0.0).position_m[axis]);
        let ([x, y], [p, q]) = (away(&one.detection), away(&other.detection));
        let (sine, cosine) = world.sin_cos();
        prop_assert!((p - (cosine * x + sine * y)).abs() < 1e-9 && (q - (cosine * y - sine * x)).abs() < 1e-9);
    }
}

#[test]
fn what_a_sensor_needs_and_nobody_gives_is_named() {
    let measured = detection(DetectionKind::RangeBearing, [5e3, 1.0, 0.0], [20.0, 0.01, 0.0, 0.0]);
    let mut at = pose([0.5, 0.0, 0.0], 0.01);
    at.heading = Err(NoState::Gap);
    let nose = Mount::default();
    assert_eq!(
        nose.carry(&measured, &at, None, None),
        Err(Refusal::Heading(NoState::Gap))
    );
    // A sensor with bearings from north needs no heading; its lever arm then has an unknown direction.
    let north = Mount {
        bearings: Bearings::North,
        lever_arm_m: [20.0, 0.0, 5.0],
        ..nose
    };
    let carried = north.carry(&measured, &at, None, None).unwrap();
    assert!((carried.detection.values[1] - 1.0).abs() < 1e-12);
    assert_eq!(carried.detection.platform_m, [100.0, 200.0, 15.0]);
    assert!((carried.covariance[0][0] - 400.0 - 200.0).abs() < 1e-6);
    at.tilt = Err(NoState::NotYet);
    at.heading = pose([0.5, 0.0, 0.0], 0.01).heading;
    assert_eq!(
        nose.carry(&measured, &at, None, None),
        Err(Refusal::Tilt(NoState::NotYet))
    );
    let unstated = Detection {
        sigmas: None,
        ..measured
    };
    let level = pose([0.0; 3], 0.0);
    assert_eq!(nose.carry(&unstated, &level, None, None), Err(Refusal::NoSigmas));
    let stated = nose
        .carry(&unstated, &level, Some([20.0, 0.01, 0.0, 0.0]), None)
        .unwrap();
    assert!((stated.detection.sigmas.unwrap()[1] - 0.01).abs() < 1e-12);
}

/// North at a place far from the origin is not the system frame's north.
#[test]
fn bearings_from_north_are_from_the_north_at_the_platforms_place() {
    let origin = frames::Geodetic::from_degrees(60.0, 5.0, 0.0).unwrap();
    let frame = frames::SystemFrame::at(origin);
    let here = frames::Geodetic::from_degrees(60.5, 8.0, 0.0).unwrap();
    let there = frames::Geodetic::from_degrees(60.7, 8.0, 0.0).unwrap();
    let measured = detection(DetectionKind::Bearing, [0.0; 3], [0.0, 0.001, 0.0, 0.0]);
    let at = Pose {
        position_m: frame.to_local(here),
        ..pose([0.0; 3], 0.0)
    };
    let mount = Mount {
        bearings: Bearings::North,
        ..Mount::default()
    };
    let found = mount
        .carry(&measured, &at, None, Some(&frame))
        .unwrap()
        .detection
        .values[0];
    let (a, b) = (frame.to_local(here), frame.to_local(there));
    let expected = (b[0] - a[0]).atan2(b[1] - a[1]);
    assert!(circular(found, expected).abs() < 1e-3, "{found} {expected}");
    assert!(expected.abs() > 0.03, "the meridians converge");
}

/// Far from the origin of the frame, a height above the ellipsoid is not the height above the frame's plane.
#[test]
fn a_height_is_above_the_ellipsoid_at_the_target() {
    let frame = frames::SystemFrame::at(frames::Geodetic::from_degrees(60.0, 5.0, 0.0).unwrap());
    let [ship, aircraft] = [(60.8, 7.5, 40.0), (61.1, 7.0, 9000.0)]
        .map(|(latitude, longitude, up)| frames::Geodetic::from_degrees(latitude, longitude, up).unwrap());
    let (ship, aircraft) = (frame.to_local(ship), frame.to_local(aircraft));
    let attitude = [0.7, 0.05, -0.1];
    let at = Pose {
        position_m: ship,
        ..pose(attitude, 0.005)
    };
    let level = Attitude::default();
    let seen = polar(offset_seen(aircraft, &Attitude::of(attitude), &level, [0.0; 3], ship));
    let plot = in_height(
        detection(DetectionKind::RangeBearing, seen, [20.0, 0.001, 0.0, 0.0]),
        9000.0,
    );
    let carried = Mount::default()
        .carry(&plot, &at, None, Some(&frame))
        .unwrap()
        .detection;
    let found = point(&carried);
    let missed_m = (0..3)
        .map(|axis| (found[axis] - aircraft[axis]).powi(2))
        .sum::<f64>()
        .sqrt();
    assert!(missed_m < 1.0, "{found:?} {aircraft:?}");
}

/// No direction leads to a height beyond the range: the height is then as unknown as without a statement.
#[test]
fn a_height_that_contradicts_the_range_is_not_used() {
    let plot = detection(DetectionKind::RangeBearing, [5e3, 1.0, 0.0], [20.0, 0.01, 0.0, 0.0]);
    let at = pose([0.5, 0.02, 0.1], 0.005);
    let carry = |plot: &Detection| Mount::default().carry(plot, &at, None, None).unwrap();
    assert_eq!(carry(&in_height(plot, 6e3)), carry(&plot));
    assert_ne!(carry(&in_height(plot, 4e3)), carry(&plot));
}

/// Errors of the deck's tilt and of the ship's place do not move a target up or down whose height is known.
#[test]
fn a_stated_height_has_its_own_error_alone() {
    let plot = detection(DetectionKind::RangeBearing, [5e3, 1.0, 0.0], [20.0, 0.01, 0.0, 0.0]);
    let at = Pose {
        position_sigma_m: 50.0,
        ..pose([0.5, 0.02, 0.1], 0.01)
    };
    let carried = Mount::default()
        .carry(&in_height(plot, 100.0), &at, None, None)
        .unwrap();
    let up_sigma_m = 5e3 * carried.covariance[2][2].sqrt();
    assert!((up_sigma_m / HEIGHT_SIGMA_M - 1.0).abs() < 0.02, "{up_sigma_m}");
}

fn in_height(detection: Detection, height_m: f64) -> Detection {
    let sigma_m = HEIGHT_SIGMA_M;
    Detection {
        height: Some(StatedHeight { height_m, sigma_m }),
        ..detection
    }
}

const HEIGHT_SIGMA_M: f64 = 30.0;

struct Noise(ChaCha8Rng);

impl Noise {
    fn of(&mut self, sigma: f64) -> f64 {
        let value: f64 = StandardNormal.sample(&mut self.0);
        value * sigma
    }
}

/// The ship of `config/on-board.toml`: roll ± 10°, a turn of 2°/s.
fn ship(time_s: f64) -> ([f64; 3], [f64; 3], [f64; 3]) {
    let heading = 5.8 + 2f64.to_radians() * time_s;
    let rate = 2f64.to_radians();
    let speed = 8.0;
    let position = [
        speed / rate * (5.8f64.cos() - heading.cos()),
        speed / rate * (heading.sin() - 5.8f64.sin()),
        0.0,
    ];
    let velocity = [speed * heading.sin(), speed * heading.cos(), 0.0];
    let roll = 10f64.to_radians() * (TAU / 10.0 * time_s).sin();
    let pitch = 3f64.to_radians() * (TAU / 7.0 * time_s).sin();
    (position, velocity, [heading, pitch, roll])
}

/// Mean normalised squared error of each quantity count, over detections of a target from the turning, rolling ship.
/// With `stated`, targets of 0 to 0.5 rad elevation state their height.
fn nees((kind, stated): (DetectionKind, bool), seed: u64, runs: usize) -> [f64; 2] {
    const SIGMA_RAD: f64 = 0.3 * PI / 180.0;
    let mut noise = Noise(ChaCha8Rng::seed_from_u64(seed));
    let mount = Mount {
        lever_arm_m: [20.0, 2.0, 15.0],
        mounting_deg: [30.0, 1.0, -2.0].map(Degrees::of),
        ..Mount::default()
    };
    let assumed = Assumed::default();
    let (mut whole, mut diagonal) = (0.0, 0.0);
    for run in 0..runs {
        let time_s = 0.05 + 0.731 * run as f64 % 60.0;
        let time_ns = (time_s * 1e9) as i64;
        // The instruments' errors change slowly: the same on both sides of the detection.
        let errors = [noise.of(SIGMA_RAD), noise.of(SIGMA_RAD), noise.of(SIGMA_RAD)];
        let shift = [noise.of(3.0), noise.of(3.0), noise.of(3.0)];
        let mut history = History::new(assumed, 8);
        for k in [-1.0, 0.0, 1.0, 2.0] {
            let at_s = (time_s * 10.0).floor() / 10.0 + 0.1 * k;
            let (position, velocity, angles) = ship(at_s);
            history.add(&State {
                time_ns: (at_s * 1e9).round() as i64,
                position_m: Some(std::array::from_fn(|axis| position[axis] + shift[axis])),
                velocity_mps: Some(velocity),
                heading_rad: Some((angles[0] + errors[0]).rem_euclid(TAU)),
                tilt_rad: Some([angles[1] + errors[1], angles[2] + errors[2]]),
                position_sigma_m: Some(3.0),
                velocity_sigma_mps: Some(0.1),
                heading_sigma_rad: Some(SIGMA_RAD),
                tilt_sigmas_rad: Some([SIGMA_RAD; 2]),
            });
        }
        let (position, _, angles) = ship(time_s);
        let azimuth = 2.4 * run as f64;
        let range_m = 300.0 + 40.0 * (run % 200) as f64;
        let has_height = kind == DetectionKind::RangeBearingElevation;
        let [forward, right, up] = mount.lever_arm_m;
        let elevation = if stated {
            0.05 * (run % 11) as f64
        } else if has_height {
            0.1
        } else {
            noise.of(mount.elevation_sigma_deg.rad())
        };
        let attitude = Attitude::of(angles);
        let arm = turn(&attitude, [right, forward, up]);
        let place: [f64; 3] = std::array::from_fn(|axis| position[axis] + arm[axis]);
        let (se, ce) = elevation.sin_cos();
        let target = [
            place[0] + range_m * ce * azimuth.sin(),
            place[1] + range_m * ce * azimuth.cos(),
            place[2] + range_m * se,
        ];
        let fixed = Attitude::of(mount.mounting_deg.map(|angle| angle.rad()));
        let seen = polar(offset_seen(target, &attitude, &fixed, [right, forward, up], position));
        let sigmas = [8.0, 0.006, 0.008, 0.0];
        let measured = Detection {
            time_of_measurement_ns: time_ns,
            ..detection(kind, std::array::from_fn(|k| seen[k] + noise.of(sigmas[k])), sigmas)
        };
        let measured = match stated {
            true => in_height(measured, target[2] + noise.of(HEIGHT_SIGMA_M)),
            false => measured,
        };
        let carried = mount
            .carry(&measured, &history.at(time_ns).unwrap(), None, None)
            .unwrap();
        let from: [f64; 3] = std::array::from_fn(|axis| target[axis] - carried.detection.platform_m[axis]);
        let truth = polar(from);
        let values = carried.detection.values;
        let residual = [
            values[0] - truth[0],
            circular(values[1], truth[1]),
            values[2] - truth[2],
        ];
        let dimension = if has_height || stated { 3 } else { 2 };
        whole += squared(&carried.covariance, residual, dimension) / dimension as f64;
        let share = |k: usize| residual[k] * residual[k] / carried.covariance[k][k];
        diagonal += (0..dimension).map(share).sum::<f64>() / dimension as f64;
    }
    [whole / runs as f64, diagonal / runs as f64]
}

/// rᵀ·C⁻¹·r by elimination.
fn squared(covariance: &[[f64; 4]; 4], residual: [f64; 3], dimension: usize) -> f64 {
    let (mut c, mut r) = (*covariance, residual);
    let mut sum = 0.0;
    for k in 0..dimension {
        sum += r[k] * r[k] / c[k][k];
        for row in k + 1..dimension {
            let factor = c[row][k] / c[k][k];
            r[row] -= factor * r[k];
            let above = c[k];
            let elements = c[row].iter_mut().zip(above).take(dimension);
            elements.skip(k).for_each(|(element, above)| *element -= factor * above);
        }
    }
    sum
}

#[test]
fn errors_are_as_large_as_the_covariance_states_on_a_rolling_turning_ship() {
    use DetectionKind::{RangeBearing, RangeBearingElevation};
    for case in [
        (RangeBearing, false),
        (RangeBearing, true),
        (RangeBearingElevation, false),
    ] {
        for value in nees(case, 5, 20_000) {
            assert!((0.9..1.1).contains(&value), "{case:?} {value}");
        }
    }
}

/// The range rate is that of the target over ground: the ship's own motion, and its mast's by the roll, are removed.
#[test]
fn the_range_rate_of_a_target_at_rest_is_zero() {
    let mount = Mount {
        lever_arm_m: [20.0, 5.0, 15.0],
        ..Mount::default()
    };
    let [forward, right, up] = mount.lever_arm_m;
    let place = |time_s: f64| {
        let (position, _, angles) = ship(time_s);
        let arm = turn(&Attitude::of(angles), [right, forward, up]);
        std::array::from_fn::<f64, 3, _>(|axis| position[axis] + arm[axis])
    };
    let target = [3e3, -4e3, 200.0];
    let mut largest = 0f64;
    for step in 0..100 {
        let time_s = 1.0 + 0.1037 * f64::from(step);
        let mut history = History::new(Assumed::default(), 64);
        for k in -2..4 {
            let at_s = (time_s * 50.0).floor() / 50.0 + 0.02 * f64::from(k);
            let (position, velocity, angles) = ship(at_s);
            history.add(&State {
                time_ns: (at_s * 1e9).round() as i64,
                position_m: Some(position),
                velocity_mps: Some(velocity),
                heading_rad: Some(angles[0]),
                tilt_rad: Some([angles[1], angles[2]]),
                ..State::default()
            });
        }
        let range = |time_s: f64| polar(std::array::from_fn(|axis| target[axis] - place(time_s)[axis]))[0];
        let rate = (range(time_s + 1e-4) - range(time_s - 1e-4)) / 2e-4;
        let (position, _, angles) = ship(time_s);
        let level = Attitude::default();
        let seen = polar(offset_seen(
            target,
            &Attitude::of(angles),
            &level,
            [right, forward, up],
            position,
        ));
        let measured = Detection {
            range_rate_mps: Some(rate),
            ..detection(DetectionKind::RangeBearingElevation, seen, [8.0, 0.005, 0.005, 0.2])
        };
        let at = history.at((time_s * 1e9) as i64).unwrap();
        let carried = mount.carry(&measured, &at, None, None).unwrap().detection;
        largest = largest.max(carried.range_rate_mps.unwrap().abs());
        assert!(carried.sigmas.unwrap()[3] >= 0.5);
        assert!(rate.abs() < 20.0);
    }
    assert!(largest < 0.1, "{largest}");
}

/// A detection that states its platform's attitude itself gives what the state of a feed gives; its position is the
/// sensor's.
#[test]
fn a_detection_may_state_its_platform_itself() {
    let mount = Mount {
        lever_arm_m: [20.0, 0.0, 15.0],
        mounting_deg: [10.0, 0.0, 0.0].map(Degrees::of),
        ..Mount::default()
    };
    let plain = detection(DetectionKind::RangeBearing, [5e3, 1.0, 0.0], [20.0, 0.01, 0.0, 0.0]);
    let assumed = Assumed::default();
    let unstated = mount.carry_own(&plain, &assumed, None, None);
    assert_eq!(unstated, Err(Refusal::Heading(NoState::None)));
    let measured = Detection {
        platform_m: [7.0, 8.0, 9.0],
        platform: DetectionPlatform {
            velocity_mps: None,
            attitude_rad: Some([0.5, 0.0, 0.125]),
            sigma_m: Some(4.0),
            attitude_sigmas_rad: [0.0078125, 0.0, 0.0],
        },
        ..plain
    };
    let own = mount.carry_own(&measured, &assumed, None, None).unwrap();
    assert_eq!(own.detection.platform_m, [7.0, 8.0, 9.0]);
    let mut at = pose([0.5, 0.0, 0.125], 0.0078125);
    (at.position_m, at.position_sigma_m) = ([7.0, 8.0, 9.0], 4.0);
    let level = assumed.attitude_sigma_deg.rad();
    at.tilt = at.tilt.map(|tilt| {
        tilt.map(|angle| AngleAt {
            sigma_rad: level,
            ..angle
        })
    });
    let without_arm = Mount {
        lever_arm_m: [0.0; 3],
        ..mount
    };
    let fed = without_arm.carry(&measured, &at, None, None).unwrap();
    assert!(circular(fed.detection.values[1], own.detection.values[1]).abs() < 1e-12);
    assert!(circular(own.detection.values[1], 1.0 + 0.5 + 10f64.to_radians()).abs() < 0.02);
    // Of two deviations of the tilt that are not stated, none is taken for zero.
    assert!((own.covariance[1][1] - fed.covariance[1][1]).abs() < 1e-12);
}
