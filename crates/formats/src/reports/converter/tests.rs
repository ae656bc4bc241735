//! Observations into sensor tracks.

use frames::{Geodetic, SystemFrame};

use super::*;
use crate::reports::observation::Quality;
use crate::reports::{CovarianceFrom, CovarianceModel, Limits, PoorQuality, STANDARD_PRESSURE_HPA};

const S: i64 = 1_000_000_000;
const DAY: i64 = 16_931 * 86_400 * S;

fn converter() -> Converter {
    let place = Geodetic::from_degrees(41.297063, 2.078447, 0.0).unwrap();
    let system = SystemFrame::at(place);
    let model = SourceModel {
        number: 1,
        sac_sic: Some((0, 107)),
        positions: PositionForm::Any,
        frame: SensorFrame::new(&system, place, 0.0),
        system,
        height_m: 0.0,
        assumed_height_m: 5000.0,
        qnh_hpa: STANDARD_PRESSURE_HPA,
        limits: Limits {
            range_m: 50e3,
            height_min_m: -500.0,
            height_max_m: 20e3,
            speed_mps: 350.0,
            jump_m: 100.0,
            time_step_ns: 60 * S,
            tracks: 2,
        },
        covariance: CovarianceModel {
            from: CovarianceFrom::Report,
            position_sigma_m: 5.0,
            velocity_sigma_mps: 2.0,
            height_sigma_m: 30.0,
            polar: None,
            poor_quality: PoorQuality::Use,
        },
    };
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
        .filter(|counter| converter.counters()[**counter as usize] == 1)
        .collect();
    assert_eq!(counted.len(), 1, "one reason each");
    *counted[0]
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
    converter.received(midnight + S / 2);
    let before = converter.convert(&observation(86_399.5), 0).unwrap();
    assert_eq!(
        before.time_of_measurement_ns,
        midnight - S / 2,
        "late, of the day before"
    );
    let early = converter.convert(&observation(1.0), 0).unwrap();
    assert_eq!(early.time_of_measurement_ns, midnight + S, "its clock is ahead");
    let count = |converter: &Converter| converter.counters()[Counter::RejectedTime as usize];
    for (refused, time_s) in [(1, 61.0), (2, 62.0), (3, 43_000.0)] {
        assert_eq!(
            converter.convert(&observation(time_s), 0),
            None,
            "however often it insists"
        );
        assert_eq!(count(&converter), refused);
    }
    converter.received(midnight + 61 * S);
    assert!(converter.convert(&observation(61.0), 0).is_some());
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
            time_of_day_ns: Some(90_000 * S),
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
    let antarctic = Observation {
        cartesian: None,
        geodetic: Some([-71f64.to_radians(), 0.0]),
        ..good
    };
    assert_eq!(refused(antarctic), Counter::RejectedPosition);
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
    assert_eq!(converter.counters()[Counter::RejectedHeight as usize], 1);
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
    assert_eq!(converter.counters()[Counter::RefusedTracks as usize], 1);
    for second in 0..4 {
        converter.service(Some(second * 50 * S));
    }
    assert!(converter.convert(&third(160.0), 0).is_some());
}
