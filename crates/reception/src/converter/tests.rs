//! Observations into sensor tracks.

use frames::{Geodetic, SystemFrame};

use messages::{STANDARD_PRESSURE_HPA, alert_bits};
use observations::Alerts;

use super::*;
use crate::{CovarianceFrom, CovarianceModel, PlausibilityLimits, PoorQuality};
use observations::{Detection, DetectionKind};
use observations::{Plane, Quality};
use test_support::S;

const DAY: i64 = 16_931 * 86_400 * S;

fn converter() -> Converter {
    converter_with(|_| ())
}

fn converter_with(change: impl FnOnce(&mut CovarianceModel)) -> Converter {
    let place = Geodetic::from_degrees(41.297063, 2.078447, 0.0).unwrap();
    let system = SystemFrame::at(place);
    let mut model = ConversionModel {
        is_on_board: false,
        number: 1,
        sac_sic: Some((0, 107)),
        method: Default::default(),
        positions: PositionForm::Any,
        frame: SensorFrame::new(&system, place, 0.0),
        system,
        height_m: 0.0,
        assumed_height_m: 5000.0,
        qnh_hpa: STANDARD_PRESSURE_HPA,
        limits: PlausibilityLimits {
            range_m: 50e3,
            height_min_m: -500.0,
            height_max_m: 20e3,
            speed_mps: 350.0,
            jump_m: 100.0,
            time_step_s: Some(settings::Seconds::of_ns(60 * S)),
            tracks: 2,
        },
        covariance: CovarianceModel {
            from: CovarianceFrom::Report,
            position_sigma_m: 5.0,
            velocity_sigma_mps: 2.0,
            unstated_position_sigma_m: None,
            unstated_velocity_sigma_mps: None,
            height_sigma_m: 30.0,
            range_sigma_m: None,
            azimuth_sigma_deg: None,
            doppler_sigma_mps: None,
            doppler_towards: false,
            poor_quality: PoorQuality::Use,
        },
    };
    change(&mut model.covariance);
    Converter::new(model, DAY)
}

fn observation(time_s: f64) -> Observation {
    Observation {
        sac_sic: Some((0, 107)),
        time_of_day_ns: Some((time_s * S as f64) as i64),
        track_number: Some(7),
        cartesian: Some([1000.0, -500.0]),
        velocity: Some([30.0, 0.0]),
        pressure_altitude_m: Some(120.0),
        state: TrackState::Confirmed,
        ..Observation::default()
    }
}

fn refused(observation: Observation) -> Counter {
    let mut converter = converter();
    assert_eq!(converter.convert(&observation, 0), None);
    let counted: Vec<_> = Counter::ALL
        .iter()
        .filter(|counter| converter.counters()[**counter] == 1)
        .collect();
    assert_eq!(counted.len(), 1, "one reason each");
    *counted[0]
}

#[test]
fn the_velocity_of_a_tentative_track_is_a_guess() {
    let variance = |state| {
        let track = converter()
            .convert(
                &Observation {
                    state,
                    ..observation(1.0)
                },
                0,
            )
            .unwrap();
        track.covariance.get(3, 3)
    };
    assert_eq!(variance(TrackState::Confirmed), 4.0);
    assert_eq!(variance(TrackState::Tentative), 1e4);
}

#[test]
fn a_sound_report_becomes_a_sensor_track() {
    let track = converter().convert(&observation(86_399.5), 42).unwrap();
    assert_eq!(track.time_of_measurement_ns, DAY + 86_399_500_000_000);
    // The earth falls away by 10 cm over 1.1 km.
    assert!((track.position_m[0] - 1000.0).abs() < 1e-6 && (track.position_m[2] - 119.9).abs() < 0.005);
    assert_eq!((track.track_number, track.source, track.stages.ingested_ns), (7, 1, 42));
    assert!(track.has(bits::HEIGHT | bits::VELOCITY));
    assert!(!track.has(bits::OWN_COVARIANCE));
    assert_eq!(track.covariance.get(0, 0), 25.0);
}

#[test]
fn live_stamps_are_judged_by_the_time_of_receipt() {
    let mut converter = converter();
    let midnight = DAY + 5 * 86_400 * S;
    converter.received(midnight + S / 2, midnight + S / 2);
    let before = converter.convert(&observation(86_399.5), 0).unwrap();
    assert_eq!(
        before.time_of_measurement_ns,
        midnight - S / 2,
        "late, of the day before"
    );
    let early = converter.convert(&observation(1.0), 0).unwrap();
    assert_eq!(early.time_of_measurement_ns, midnight + S, "its clock is ahead");
    let count = |converter: &Converter| converter.counters()[Counter::RejectedTime];
    for (refused, time_s) in [(1, 61.0), (2, 62.0), (3, 43_000.0)] {
        let track = converter.convert(&observation(time_s), 0).unwrap();
        assert!(track.has(bits::WILD_CLOCK), "however often it insists");
        assert_eq!(count(&converter), refused);
        assert_eq!(
            converter.running_ns(),
            Some(midnight + S),
            "and time does not go on with it"
        );
    }
    converter.received(midnight + 61 * S, midnight + 61 * S);
    assert!(converter.convert(&observation(61.0), 0).is_some());
}

#[test]
fn times_of_day_beyond_midnight_are_of_the_next_day() {
    let mut recorded = converter();
    for (time_s, expected_s) in [
        (86_398.0, 86_398),
        (86_400.0, 86_400),
        (86_410.0, 86_410),
        (12.0, 86_412),
    ] {
        let track = recorded.convert(&observation(time_s), 0).unwrap();
        assert_eq!(track.time_of_measurement_ns, DAY + expected_s * S, "{time_s}");
    }
    let first = converter().convert(&observation(86_410.0), 0).unwrap();
    assert_eq!(first.time_of_measurement_ns, DAY + 86_410 * S, "without one before it");
    let mut live = converter();
    live.received(DAY + 86_409 * S, DAY + 86_409 * S);
    let track = live.convert(&observation(86_410.0), 0).unwrap();
    assert_eq!(track.time_of_measurement_ns, DAY + 86_410 * S);
}

#[test]
fn a_source_of_one_method_takes_what_was_observed_so_and_goes_on_with_its_own_tracks() {
    let seen = |time_s: f64, number: u32, secondary| Observation {
        track_number: Some(number),
        secondary,
        ..observation(time_s)
    };
    for (method, own, other) in [(Method::Primary, false, true), (Method::Secondary, true, false)] {
        let mut converter = converter();
        converter.model.method = method;
        let mut takes = |observation| converter.convert(&observation, 0).is_some();
        assert!(takes(seen(100.0, 7, Some(own))));
        assert!(!takes(seen(101.0, 8, Some(other))));
        assert!(takes(seen(104.0, 7, None)), "unseen in this turn");
        assert!(!takes(seen(105.0, 8, None)), "the other source's");
        assert_eq!(converter.counters()[Counter::RejectedSource], 2);
    }
}

#[test]
fn what_cannot_be_is_refused_by_reason() {
    let good = observation(100.0);
    assert_eq!(
        refused(Observation {
            sac_sic: Some((0, 7)),
            ..good
        }),
        Counter::RejectedSource
    );
    assert_eq!(
        refused(Observation {
            time_of_day_ns: None,
            ..good
        }),
        Counter::RejectedTime
    );
    assert_eq!(
        refused(Observation {
            time_of_day_ns: Some(-S),
            ..good
        }),
        Counter::RejectedTime
    );
    assert_eq!(
        refused(Observation {
            field_monitor: true,
            ..good
        }),
        Counter::RejectedFieldMonitor
    );
    assert_eq!(refused(Observation { test: true, ..good }), Counter::RejectedTestTarget);
    assert_eq!(
        refused(Observation {
            track_number: None,
            ..good
        }),
        Counter::RejectedNoTrackNumber
    );
    assert_eq!(
        refused(Observation {
            cartesian: None,
            ..good
        }),
        Counter::RejectedNoPosition
    );
    assert_eq!(
        refused(Observation {
            cartesian: Some([60e3, 0.0]),
            ..good
        }),
        Counter::RejectedPosition
    );
    assert_eq!(
        refused(Observation {
            cartesian: Some([f64::NAN, 0.0]),
            ..good
        }),
        Counter::RejectedPosition
    );
    assert_eq!(
        refused(Observation {
            velocity: Some([400.0, 0.0]),
            ..good
        }),
        Counter::RejectedSpeed
    );
    let nowhere = Observation {
        cartesian: None,
        slant_polar: Some([f64::NAN, 0.0]),
        pressure_altitude_m: None,
        ..good
    };
    assert_eq!(refused(nowhere), Counter::RejectedPosition);
    for slant in [[1000.0, f64::INFINITY], [1e300, 0.0], [-1.0, 0.0]] {
        let nowhere = Observation {
            slant_polar: Some(slant),
            ..nowhere
        };
        assert_eq!(refused(nowhere), Counter::RejectedPosition, "{slant:?}");
    }
    let antarctic = Observation {
        cartesian: None,
        geodetic: Some([-71f64.to_radians(), 0.0]),
        ..good
    };
    assert_eq!(refused(antarctic), Counter::RejectedPosition);
    // The other side of the earth is near on the plane.
    let below = Observation {
        geodetic: Some([-41.297_063f64.to_radians(), (2.078_447f64 - 180.0).to_radians()]),
        ..antarctic
    };
    assert_eq!(refused(below), Counter::RejectedPosition);
}

#[test]
fn an_impossible_height_costs_the_height_only() {
    let mut converter = converter();
    let track = converter
        .convert(
            &Observation {
                pressure_altitude_m: Some(40e3),
                ..observation(1.0)
            },
            0,
        )
        .unwrap();
    assert!(!track.has(bits::HEIGHT));
    assert!(track.covariance.get(2, 2) > 1e6);
    assert_eq!(converter.counters()[Counter::RejectedHeight], 1);
}

#[test]
fn a_missing_velocity_is_derived_once_it_can_be() {
    let mut converter = converter();
    let mut last = None;
    for second in 0..4 {
        let x = 1000.0 + 20.0 * f64::from(second);
        let report = Observation {
            velocity: None,
            cartesian: Some([x, 0.0]),
            ..observation(f64::from(second))
        };
        last = converter.convert(&report, 0);
        assert_eq!(last.unwrap().has(bits::DERIVED_VELOCITY), second > 0);
    }
    assert!((last.unwrap().velocity_mps[0] - 20.0).abs() < 1e-6);
}

#[test]
fn own_quality_is_believed_down_to_the_floor() {
    let variance = |quality: Quality| {
        converter()
            .convert(
                &Observation {
                    quality,
                    ..observation(1.0)
                },
                0,
            )
            .unwrap()
            .covariance
            .get(0, 0)
    };
    assert_eq!(variance(Quality::Covariance([400.0, 0.0, 100.0])), 400.0);
    assert_eq!(variance(Quality::Covariance([1.0, 0.0, 1.0])), 25.0);
    assert_eq!(variance(Quality::Dilution(3.0)), 225.0);
    assert!((variance(Quality::Radius95(92.6)).sqrt() - 37.83).abs() < 0.01);
    assert_eq!(variance(Quality::Unknown).sqrt(), UNKNOWN_POSITION_SIGMA_M);
}

#[test]
fn reports_without_a_statement_have_an_accuracy_of_their_own() {
    let sigmas = |change: fn(&mut CovarianceModel), quality, velocity_covariance| {
        let observation = Observation {
            quality,
            velocity_covariance,
            ..observation(1.0)
        };
        let covariance = converter_with(change).convert(&observation, 0).unwrap().covariance;
        [covariance.get(0, 0).sqrt(), covariance.get(3, 3).sqrt()]
    };
    let own = |model: &mut CovarianceModel| {
        model.unstated_position_sigma_m = Some(40.0);
        model.unstated_velocity_sigma_mps = Some(7.0);
    };
    let stated = (Quality::Covariance([100.0, 0.0, 100.0]), Some([9.0, 0.0, 9.0]));
    assert_eq!(sigmas(|_| (), Quality::Unstated, None), [5.0, 2.0], "the minimum");
    assert_eq!(sigmas(own, Quality::Unstated, None), [40.0, 7.0]);
    assert_eq!(sigmas(own, stated.0, stated.1), [10.0, 3.0]);
    let configured = |model: &mut CovarianceModel| {
        model.unstated_position_sigma_m = Some(40.0);
        model.unstated_velocity_sigma_mps = Some(7.0);
        model.from = CovarianceFrom::Configuration;
    };
    assert_eq!(sigmas(configured, Quality::Unstated, None), [5.0, 2.0]);
}

#[test]
fn polar_and_cartesian_forms_of_one_plot_are_the_same_place() {
    // A plot of the Barcelona surface radar carries both.
    let both = Observation {
        cartesian: Some([-673.0, -823.0]),
        polar: Some([1063.0, 219.309_082_031_25f64.to_radians()]),
        ..observation(1.0)
    };
    let place = |form: PositionForm| {
        let mut converter = converter();
        converter.model.positions = form;
        converter.convert(&both, 0).unwrap().position_m
    };
    let (cartesian, polar) = (place(PositionForm::Cartesian), place(PositionForm::Polar));
    assert_eq!(place(PositionForm::Any), cartesian);
    assert_ne!(polar, cartesian, "each form is really used");
    assert!((polar[0] - cartesian[0]).hypot(polar[1] - cartesian[1]) < 1.0);
    let mut converter = converter();
    converter.model.positions = PositionForm::Polar;
    assert_eq!(
        converter.convert(&Observation { polar: None, ..both }, 0),
        None,
        "the other form is not wanted"
    );
}

#[test]
fn an_end_without_position_ends_where_the_track_was() {
    let mut converter = converter();
    converter.convert(&observation(1.0), 0).unwrap();
    let end = Observation {
        cartesian: None,
        state: TrackState::Terminated,
        ..observation(2.0)
    };
    let ended = converter.convert(&end, 0).unwrap();
    assert_eq!(ended.state, TrackState::Terminated as u8);
    assert!((ended.position_m[0] - 1000.0).abs() < 1e-6);
    assert_eq!(converter.convert(&end, 0), None, "a track that nobody knows");
}

#[test]
fn a_full_table_refuses_new_tracks_and_forgets_old_ones() {
    let mut converter = converter();
    for number in 0..2 {
        assert!(
            converter
                .convert(
                    &Observation {
                        track_number: Some(number),
                        ..observation(1.0)
                    },
                    0
                )
                .is_some()
        );
    }
    let third = |time| Observation {
        track_number: Some(9),
        ..observation(time)
    };
    assert_eq!(converter.convert(&third(2.0), 0), None);
    assert_eq!(converter.counters()[Counter::TracksDropped], 1);
    for second in 0..4 {
        converter.service(Some(second * 50 * S));
    }
    assert!(converter.convert(&third(160.0), 0).is_some());
}

/// A radar at 45° N, 10° E, 150 m, in a system around 45.5° N, 11° E.
fn radar() -> Converter {
    radar_in(SystemFrame::at(Geodetic::from_degrees(45.5, 11.0, 0.0).unwrap()))
}

/// The same radar, where the system is around it.
fn central_radar() -> Converter {
    radar_in(SystemFrame::at(Geodetic::from_degrees(45.0, 10.0, 0.0).unwrap()))
}

fn radar_in(system: SystemFrame) -> Converter {
    let place = Geodetic::from_degrees(45.0, 10.0, 150.0).unwrap();
    let mut model = converter().model;
    model.frame = SensorFrame::new(&system, place, 0.0);
    model.system = system;
    model.height_m = 150.0;
    model.limits.range_m = 400e3;
    model.limits.jump_m = 1000.0;
    Converter::new(model, DAY)
}

/// What that radar sees of an aircraft at 46° N, 12° E, FL 350: from the coordinates of both in the earth's own frame,
/// worked out apart from this program.
const SLANT: [f64; 2] = [192_233.109, 0.940_324_3];
/// Where it is in the system, from the same.
const PLACE: [f64; 3] = [77_588.699, 56_148.553, 9950.518];

/// A plot of it.
fn plot(time_s: f64) -> Observation {
    Observation {
        slant_polar: Some(SLANT),
        plot: true,
        cartesian: None,
        velocity: None,
        pressure_altitude_m: Some(10_668.0),
        ..observation(time_s)
    }
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn a_radar_plot_lies_where_its_height_puts_it() {
    let track = radar().convert(&plot(1.0), 0).unwrap();
    assert!(apart(track.position_m, PLACE) < 0.1, "{:?}", track.position_m);
    assert!(track.has(bits::HEIGHT) && !track.has(bits::MEASURED));
}

#[test]
fn all_planes_of_x_and_y_lead_to_the_same_place() {
    let cartesian = |x: f64, y: f64, plane| {
        let report = Observation {
            cartesian: Some([x, y]),
            plane,
            slant_polar: None,
            ..plot(1.0)
        };
        radar().convert(&report, 0).unwrap().position_m
    };
    let (sine, cosine) = SLANT[1].sin_cos();
    let slant = cartesian(SLANT[0] * sine, SLANT[0] * cosine, Plane::Slant);
    assert!(apart(slant, PLACE) < 0.1, "{slant:?}");
    // The radar's own east and north of the aircraft.
    let tangent = cartesian(155_153.765, 113_237.088, Plane::Tangent);
    assert!(apart(tangent, PLACE) < 20.0, "{tangent:?}");
    // Along the ground it is 191,789.890 m to the place below the aircraft, which is 191,804.375 m on the map.
    let map = cartesian(154_929.862, 113_073.675, Plane::Stereographic);
    assert!(apart(map, PLACE) < 20.0, "{map:?}");
    assert!(
        apart(cartesian(154_929.862, 113_073.675, Plane::Tangent), PLACE) > 250.0,
        "it is not the same plane"
    );
}

#[test]
fn a_plot_without_height_is_placed_by_an_assumed_one_and_pays_for_it() {
    let mut converter = central_radar();
    let at = |range: f64| Observation {
        slant_polar: Some([range, 0.0]),
        pressure_altitude_m: None,
        ..plot(1.0)
    };
    let track = converter.convert(&at(20e3), 0).unwrap();
    assert_eq!(converter.counters()[Counter::HeightAssumed], 1);
    assert!(!track.has(bits::HEIGHT) && track.position_m[2] == 0.0);
    let ground = track.position_m[0].hypot(track.position_m[1]);
    // √(20² − 4.82²) km: 4.85 km above the radar is 30 m less above its horizon, as the earth falls away.
    assert!((ground - 19_410.4).abs() < 1.0, "{ground}");
    // Ground ranges from √(20² − 11.85²) = 16.111 km to 20.000 km: 3.889²/12 + (18.055 − 19.403)² = 3.077 km².
    let along = track.covariance.get(1, 1);
    assert!((along - 3.077e6).abs() < 0.01e6, "{along}");
    assert!(
        (track.covariance.get(0, 0) - 25.0).abs() < 1e-6,
        "across, it is as good as ever"
    );
    let near = central_radar().convert(&at(4e3), 0).unwrap();
    let ground = near.position_m[0].hypot(near.position_m[1]);
    assert!((ground - 3464.0).abs() < 2.0, "no steeper than 30°: {ground}");
    let known = central_radar().convert(
        &Observation {
            pressure_altitude_m: Some(5000.0),
            ..at(20e3)
        },
        0,
    );
    assert!(
        known.unwrap().covariance.get(1, 1) < 1e-3 * along,
        "a known height costs nothing"
    );
}

#[test]
fn a_track_keeps_its_height_for_a_while() {
    let mut converter = central_radar();
    let at = |time_s: f64, height: Option<f64>| Observation {
        slant_polar: Some([20e3, 0.0]),
        pressure_altitude_m: height,
        ..plot(time_s)
    };
    let known = converter.convert(&at(1.0, Some(10_000.0)), 0).unwrap();
    let remembered = converter.convert(&at(11.0, None), 0).unwrap();
    assert_eq!(
        remembered.position_m[..2],
        known.position_m[..2],
        "not where 5 km would put it"
    );
    assert!(!remembered.has(bits::HEIGHT) && remembered.position_m[2] == 0.0);
    assert_eq!(converter.counters()[Counter::HeightAssumed], 0);
    // It may be 200 m higher or lower by now: 9.85 km / 17.41 km of that along the ground.
    let along = remembered.covariance.get(1, 1) - known.covariance.get(1, 1);
    assert!((along.sqrt() - 113.2).abs() < 0.5, "{along}");
    assert!(converter.convert(&at(32.0, None), 0).is_some());
    assert_eq!(converter.counters()[Counter::HeightAssumed], 1, "31 s are too long");
}

#[test]
fn range_and_azimuth_errors_count_along_and_across_the_line_of_sight() {
    let mut converter = central_radar();
    let covariance = &mut converter.model.covariance;
    covariance.range_sigma_m = Some(50.0);
    covariance.azimuth_sigma_deg = Some(settings::Degrees::of_rad(0.001));
    let seen = |range: f64, height: f64| {
        let report = Observation {
            slant_polar: Some([range, 0.0]),
            pressure_altitude_m: Some(height),
            ..plot(1.0)
        };
        let covariance = Converter::new(converter.model, DAY)
            .convert(&report, 0)
            .unwrap()
            .covariance;
        (covariance.get(1, 1).sqrt(), covariance.get(0, 0).sqrt())
    };
    let (along, across) = seen(100e3, 1000.0);
    assert!(
        (along - 50.0).abs() < 0.1 && (across - 100.0).abs() < 0.1,
        "{along} {across}"
    );
    // At 45° of elevation a range error counts √2-fold, and the height error of 30 m once.
    let (along, across) = seen(10e3, 150.0 + 10e3 / 2f64.sqrt());
    assert!((along - (5000f64 + 900.0).sqrt()).abs() < 1.0, "{along}");
    assert!((across - 10.0).abs() < 0.1, "{across}");
}

#[test]
fn the_plot_goes_along_with_its_track() {
    let both = Observation {
        cartesian: Some([SLANT[0] * SLANT[1].sin() + 300.0, SLANT[0] * SLANT[1].cos()]),
        plane: Plane::Slant,
        quality: Quality::Covariance([400.0, 0.0, 400.0]),
        ..plot(1.0)
    };
    let track = radar().convert(&both, 0).unwrap();
    assert!(track.has(bits::MEASURED | bits::OWN_COVARIANCE));
    assert!(apart(track.measured_m, PLACE) < 0.1, "{:?}", track.measured_m);
    assert!((apart(track.position_m, track.measured_m) - 300.0).abs() < 2.0);
    let coasted = Observation {
        state: TrackState::Coasted,
        ..both
    };
    assert!(
        !radar().convert(&coasted, 0).unwrap().has(bits::MEASURED),
        "not seen in this turn"
    );
    let mut converter = radar();
    converter.model.positions = PositionForm::Polar;
    let plot = converter.convert(&both, 0).unwrap();
    assert!(apart(plot.position_m, PLACE) < 0.1 && !plot.has(bits::MEASURED));
    assert!(!plot.has(bits::OWN_COVARIANCE), "the statement is the track's");
}

#[test]
fn a_velocity_towards_the_targets_north_is_turned() {
    let mut converter = radar();
    let place = Observation {
        cartesian: None,
        // Four degrees of longitude east of the system's origin, where north is 2.852° to the left of the origin's.
        geodetic: Some([45.5f64.to_radians(), 15f64.to_radians()]),
        velocity: Some([0.0, 200.0]),
        axes: Axes::Target,
        velocity_covariance: Some([100.0, 0.0, 900.0]),
        ..observation(1.0)
    };
    let track = converter.convert(&place, 0).unwrap();
    let [vx, vy, _] = track.velocity_mps;
    assert!((vx.atan2(vy).to_degrees() + 2.852).abs() < 0.01, "{vx} {vy}");
    assert!((vx.hypot(vy) - 200.0).abs() < 0.5);
    let (sine, cosine) = 2.852f64.to_radians().sin_cos();
    let cross = track.covariance.get(3, 4);
    assert!((cross + 800.0 * sine * cosine).abs() < 1.0, "{cross}");
    // Against the sensor's north, of one degree of longitude further west.
    let sensor = Observation {
        axes: Axes::Sensor,
        ..place
    };
    let [vx, vy, _] = radar().convert(&sensor, 0).unwrap().velocity_mps;
    assert!((vx.atan2(vy).to_degrees() - 0.71).abs() < 0.01, "{vx} {vy}");
}

#[test]
fn own_velocity_accuracy_is_believed_down_to_the_floor() {
    let variance = |stated: [f64; 3]| {
        let report = Observation {
            velocity_covariance: Some(stated),
            ..observation(1.0)
        };
        converter().convert(&report, 0).unwrap().covariance.get(3, 3)
    };
    assert!((variance([25.0, 0.0, 1.0]) - 25.0).abs() < 1e-6);
    assert!((variance([0.01, 0.0, 0.01]) - 4.0).abs() < 1e-6);
}

#[test]
fn a_derived_velocity_is_as_good_as_the_positions_it_comes_from() {
    let mut converter = converter();
    converter.model.covariance.position_sigma_m = 100.0;
    let mut last = None;
    for turn in 0..3 {
        let report = Observation {
            velocity: None,
            cartesian: Some([1000.0 * f64::from(turn), 0.0]),
            ..observation(5.0 * f64::from(turn))
        };
        last = converter.convert(&report, 0);
    }
    let track = last.unwrap();
    assert!((track.velocity_mps[0] - 200.0).abs() < 1e-6);
    // 100² m² over (5² + 0 + 5²) s², and 1 m/s² since the mean time of 5 s ago.
    assert!((track.covariance.get(3, 3) - 225.0).abs() < 1e-6);
}

#[test]
fn the_local_pressure_corrects_pressure_altitudes_only() {
    let mut converter = radar();
    converter.model.qnh_hpa = 1003.25;
    let mut converter = Converter::new(converter.model, DAY);
    let mut up = |report: Observation| converter.convert(&report, 0).unwrap().position_m[2];
    let by_pressure = up(plot(1.0));
    // 10 hPa less are 83.7 m less by the altimeter's formula.
    assert!((PLACE[2] - by_pressure - 83.7).abs() < 1.0, "{by_pressure}");
    let geometric = Observation {
        pressure_altitude_m: None,
        geometric_height_m: Some(10_668.0),
        ..plot(2.0)
    };
    assert!((up(geometric) - PLACE[2]).abs() < 0.1);
}

#[test]
fn the_level_of_the_transponder_goes_on_with_its_age() {
    let mut converter = radar();
    converter.model.qnh_hpa = 1003.25;
    let mut converter = Converter::new(converter.model, DAY);
    let mut level = |report: Observation| {
        let track = converter.convert(&report, 0).unwrap();
        track.has(bits::LEVEL).then_some((track.level, track.level_age_ms))
    };
    let at = |time_s: f64, altitude_m: Option<f64>| Observation {
        pressure_altitude_m: altitude_m,
        ..plot(time_s)
    };
    assert_eq!(level(at(1.0, None)), None);
    assert_eq!(
        level(at(2.0, Some(10_668.0))),
        Some((1_400, 0)),
        "as stated, whatever the local pressure"
    );
    assert_eq!(level(at(6.0, None)), Some((1_400, 4_000)), "the last one, older now");
    let told = Observation {
        stated_altitude: Some((10_668.0 + 7.62, 1_500_000_000)),
        ..at(7.0, Some(10_668.0))
    };
    assert_eq!(level(told), Some((1_401, 1_500)), "the measured one, with its own age");
    assert_eq!(
        level(at(8.0, Some(90_000.0))),
        Some((1_401, 2_500)),
        "what no target has is none"
    );
    assert_eq!(level(at(60.0, None)), None, "too old");
    assert_eq!(level(at(61.0, Some(0.0))), Some((0, 0)), "level 0 is one");
}

#[test]
fn alerts_are_those_of_the_track_and_not_of_a_single_report() {
    let mut converter = converter();
    let mut alerts = |time_s: f64, code: u16, stated: Alerts| {
        let report = Observation {
            identity: messages::Identity::default().with_mode_3a(code),
            alerts: stated,
            ..observation(time_s)
        };
        converter.convert(&report, 0).unwrap().alerts
    };
    let medical = |is_set| Alerts::flag(alert_bits::MEDICAL, is_set);
    assert_eq!(alerts(1.0, 0o7700, medical(true)), alert_bits::MEDICAL, "a single code");
    let both = alert_bits::EMERGENCY | alert_bits::MEDICAL;
    assert_eq!(alerts(2.0, 0o7700, Alerts::default()), both, "no word on the other");
    assert_eq!(alerts(3.0, 0o7700, medical(false)), alert_bits::EMERGENCY);
}

#[test]
fn a_stuck_advisory_is_counted_once_and_is_no_alert() {
    let mut converter = converter();
    let report = |time_s: u32| Observation {
        alerts: Alerts::flag(alert_bits::RESOLUTION_ADVISORY, true),
        ..observation(f64::from(time_s))
    };
    let alerts = (0..200).map(|second| converter.convert(&report(second), 0).unwrap().alerts);
    let shown = alerts
        .filter(|bits| bits & alert_bits::RESOLUTION_ADVISORY != 0)
        .count();
    assert_eq!(shown, 121);
    assert_eq!(converter.counters()[Counter::AdvisoriesStuck], 1);
}

#[test]
fn a_report_with_both_heights_states_their_difference() {
    let offset = |pressure_m: Option<f64>, ellipsoid_m: Option<f64>| {
        let report = Observation {
            pressure_altitude_m: pressure_m,
            ellipsoid_height_m: ellipsoid_m,
            geometric_height_m: ellipsoid_m,
            ..observation(1.0)
        };
        let track = converter().convert(&report, 0).unwrap();
        track.has(bits::PRESSURE_OFFSET).then_some(track.pressure_offset_m)
    };
    assert_eq!(offset(Some(1_000.0), Some(880.0)), Some(120.0));
    assert_eq!(offset(Some(1_000.0), None), None);
    assert_eq!(offset(None, Some(880.0)), None);
    assert_eq!(offset(Some(1_000.0), Some(9e5)), None, "no aircraft is there");
}

#[test]
fn a_suspect_position_is_refused() {
    let report = Observation {
        suspect: true,
        ..observation(1.0)
    };
    assert_eq!(refused(report), Counter::RejectedQuality);
}

#[test]
fn half_a_time_is_completed_by_the_service_messages() {
    let truncated = |seconds: i64| Observation {
        time_of_day_ns: None,
        truncated_time_ns: Some(seconds * S),
        ..observation(0.0)
    };
    assert_eq!(
        refused(truncated(100)),
        Counter::RejectedTime,
        "nothing to complete it by"
    );
    let mut converter = converter();
    converter.service(Some(43_200 * S));
    // 43,200 s are 84 periods and 192 s.
    let track = converter.convert(&truncated(190), 0).unwrap();
    assert_eq!(track.time_of_measurement_ns, DAY + 43_198 * S);
    let mut live = self::converter();
    live.received(DAY + 43_200 * S, DAY + 43_200 * S);
    assert!(live.convert(&truncated(190), 0).is_some(), "or by the time of receipt");
}

#[test]
fn a_sender_that_is_not_repeated_stays_the_same() {
    let mut converter = converter();
    let unsaid = |time| Observation {
        sac_sic: None,
        ..observation(time)
    };
    assert_eq!(converter.convert(&unsaid(1.0), 0), None, "nobody has said who");
    converter.convert(&observation(1.5), 0).unwrap();
    assert!(converter.convert(&unsaid(2.0), 0).is_some());
    let other = Observation {
        sac_sic: Some((0, 7)),
        ..observation(2.5)
    };
    assert_eq!(converter.convert(&other, 0), None);
    assert_eq!(converter.convert(&unsaid(3.0), 0), None);
    assert_eq!(converter.counters()[Counter::RejectedSource], 3);
}

/// Where a detection lies, by its own quantities.
fn place_of(detection: &Detection) -> [f64; 3] {
    let [range, bearing, elevation] = detection.values;
    let [east, north, up] = detection.platform_m;
    let ground = range * elevation.cos();
    [
        east + ground * bearing.sin(),
        north + ground * bearing.cos(),
        up + range * elevation.sin(),
    ]
}

fn polar(mut converter: Converter) -> Converter {
    let covariance = &mut converter.model.covariance;
    covariance.range_sigma_m = Some(40.0);
    covariance.azimuth_sigma_deg = Some(settings::Degrees::of_rad(0.001));
    converter
}

#[test]
fn a_plot_with_height_is_detected_at_its_straight_range() {
    let mut converter = polar(radar());
    let unnumbered = Observation {
        track_number: None,
        ..plot(1.0)
    };
    let detection = converter.detect(&unnumbered).unwrap();
    assert_eq!(
        (detection.kind, detection.sensor_id),
        (DetectionKind::RangeBearingElevation, 2)
    );
    assert_eq!(detection.time_of_measurement_ns, DAY + S);
    assert!(apart(place_of(&detection), PLACE) < 0.1, "{detection:?}");
    assert!(
        (detection.values[0] - SLANT[0]).abs() < 0.01,
        "the straight range is kept"
    );
    let sigmas = detection.sigmas.unwrap();
    assert_eq!((sigmas[0], sigmas[3]), (40.0, 0.0));
    assert!((sigmas[1] - 0.001).abs() < 1e-5, "{sigmas:?}");
    // The height's 30 m, seen from 192 km.
    assert!((sigmas[2] * 192e3 - 30.0).abs() < 0.5, "{sigmas:?}");
    assert_eq!(converter.counters()[Counter::Reports], 1);
    assert_eq!(converter.counters()[Counter::RejectedNoTrackNumber], 0);
}

#[test]
fn a_plot_without_height_is_detected_on_the_ground() {
    let mut converter = polar(central_radar());
    let report = Observation {
        slant_polar: Some([20e3, 1.0]),
        pressure_altitude_m: None,
        ..plot(1.0)
    };
    let detection = converter.detect(&report).unwrap();
    assert_eq!(detection.kind, DetectionKind::RangeBearing);
    assert_eq!(detection.values[2], 0.0);
    assert!((detection.values[0] - 19_410.4).abs() < 1.0, "{detection:?}");
    // As for tracks: 3.077 km² for a height that nobody knows.
    let sigma = detection.sigmas.unwrap()[0];
    assert!((sigma * sigma - 3.077e6).abs() < 0.02e6, "{sigma}");
    assert_eq!(converter.counters()[Counter::HeightAssumed], 1);
}

#[test]
fn a_plot_of_a_radar_on_board_stays_as_measured() {
    let mut converter = polar(central_radar());
    converter.model.is_on_board = true;
    let at = |slant_polar| Observation {
        slant_polar: Some(slant_polar),
        ..plot(1.0)
    };
    // Neither an assumed height nor the place of the radar enters.
    let detection = converter.detect(&at([20e3, 1.0])).unwrap();
    assert_eq!(detection.kind, DetectionKind::RangeBearing);
    assert_eq!((detection.values, detection.platform_m), ([20e3, 1.0, 0.0], [0.0; 3]));
    assert_eq!(detection.sigmas, Some([40.0, 0.001, 0.0, 0.0]));
    // The height stays beside the slant range, by Mode C or by a radar that measures it.
    let height = |detection: Detection| detection.height.map(|height| (height.height_m, height.sigma_m));
    assert_eq!(height(detection), Some((10_668.0, 30.0)));
    let flat = Observation {
        pressure_altitude_m: None,
        ..at([20e3, 1.0])
    };
    let measured = Observation {
        geometric_height_m: Some(4000.0),
        ..flat
    };
    assert_eq!(converter.detect(&flat).and_then(height), None);
    assert_eq!(converter.detect(&measured).and_then(height), Some((4000.0, 30.0)));
    assert_eq!(converter.detect(&at([converter.model.limits.range_m + 1.0, 1.0])), None);
    assert_eq!(converter.counters()[Counter::RejectedPosition], 1);
}

#[test]
fn what_was_measured_is_detected_and_nothing_else() {
    // Of plot and track, the plot.
    let both = Observation {
        plot: false,
        cartesian: Some([1e3, 1e3]),
        ..plot(1.0)
    };
    let detection = polar(radar()).detect(&both).unwrap();
    assert!(apart(place_of(&detection), PLACE) < 0.1);
    let refused = |observation: Observation| {
        let mut converter = polar(radar());
        assert_eq!(converter.detect(&observation), None);
        converter.counters()[Counter::RejectedNoPosition]
    };
    let coasted = Observation {
        state: TrackState::Coasted,
        ..plot(1.0)
    };
    let smoothed = Observation {
        slant_polar: None,
        ..both
    };
    assert_eq!((refused(coasted), refused(smoothed)), (1, 1));
    // A plot of another form is a position.
    let position = Observation {
        plot: true,
        track_number: None,
        ..observation(1.0)
    };
    let detection = converter().detect(&position).unwrap();
    assert_eq!(detection.kind, DetectionKind::Position3);
    assert_eq!(detection.sigmas, Some([5.0, 5.0, 30.0, 0.0]));
    assert!((detection.values[0] - 1000.0).abs() < 1e-6);
    let flat = Observation {
        pressure_altitude_m: None,
        ..position
    };
    let detection = converter().detect(&flat).unwrap();
    assert_eq!((detection.kind, detection.values[2]), (DetectionKind::Position2, 0.0));
}

#[test]
fn a_doppler_speed_is_the_range_rate_where_its_accuracy_is_configured() {
    let report = Observation {
        doppler_mps: Some(25.0),
        ..plot(1.0)
    };
    let detect = |sigma_mps: Option<f64>, towards: bool, report: &Observation| {
        let mut model = polar(radar()).model;
        model.covariance.doppler_sigma_mps = sigma_mps;
        model.covariance.doppler_towards = towards;
        let detection = Converter::new(model, DAY).detect(report).unwrap();
        (detection.range_rate_mps, detection.sigmas.unwrap()[3])
    };
    assert_eq!(detect(None, false, &report), (None, 0.0));
    assert_eq!(detect(Some(2.0), false, &report), (Some(25.0), 2.0));
    assert_eq!(detect(Some(2.0), true, &report), (Some(-25.0), 2.0));
    assert_eq!(detect(Some(2.0), false, &plot(1.0)), (None, 0.0));
}
