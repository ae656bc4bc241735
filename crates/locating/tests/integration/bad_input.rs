//! Geometries that allow no fix, and values that cannot be: no fix or an honest one, counted, never a panic.

use crate::common::{Noise, S, bearing};
use locating::settings::FilterChoice;
use locating::{BearingRejection, EmitterReport, Locator, OWN_NUMBERS, Settings};
use messages::TrackState;
use observations::Bearing;
use proptest::prelude::*;

const SIGMA: f64 = 0.02;

fn locator(filter: FilterChoice) -> Locator {
    let mut settings = Settings {
        emitters_max: 4,
        ..Settings::default()
    };
    settings.motion.filter = filter;
    Locator::new(settings).unwrap()
}

/// What comes of bearings that are all taken.
fn reports(locator: &mut Locator, bearings: impl IntoIterator<Item = Bearing>) -> Vec<EmitterReport> {
    let taken = bearings
        .into_iter()
        .filter_map(|bearing| locator.bearing(&bearing).unwrap());
    taken.collect()
}

fn is_finite(report: &EmitterReport) -> bool {
    let (raw, output) = (&report.raw, &report.output);
    let values = output.position_m.iter().chain(&output.velocity_mps);
    let values = values
        .chain(&raw.position_m)
        .chain(&raw.velocity_mps)
        .chain(raw.covariance.iter());
    values.into_iter().all(|value| value.is_finite()) && raw.variance_m2() > 0.0
}

#[test]
fn a_platform_that_stands_still_gets_no_fix() {
    for filter in FilterChoice::ALL {
        let (mut locator, mut noise) = (locator(filter), Noise::new(5));
        let flight = (0..2_000).map(|k| bearing(f64::from(k), [10.0, 20.0], [5e3, 5e3], SIGMA, SIGMA * noise.next()));
        let found = reports(&mut locator, flight);
        assert!(found.is_empty(), "{} fixes", found.len());
        assert_eq!(locator.counts().without_fix, 2_000);
    }
}

#[test]
fn parallel_bearings_get_no_fix_near_by() {
    for filter in FilterChoice::ALL {
        let (mut locator, mut noise) = (locator(filter), Noise::new(6));
        let flight = (0..600).map(|k| {
            let platform = [20.0 * f64::from(k), 0.0];
            bearing(f64::from(k), platform, [platform[0], 1e6], SIGMA, SIGMA * noise.next())
        });
        for report in reports(&mut locator, flight) {
            let (north_m, sigma_m) = (report.raw.position_m[1], report.raw.variance_m2().sqrt());
            match filter {
                // It may be near and keep abreast, and nobody can know.
                FilterChoice::Straight => assert!(is_finite(&report) && north_m > 0.0, "{:?}", report.raw),
                _ => assert!(north_m + 4.0 * sigma_m > 20e3, "{:?}", report.raw),
            }
        }
    }
}

#[test]
fn bearings_that_diverge_get_no_fix() {
    let mut locator = locator(FilterChoice::Fixed);
    let flight = (0..300).map(|k| {
        let platform = [50.0 * f64::from(k), 0.0];
        bearing(f64::from(k), platform, [3.0 * platform[0] + 10.0, 5e3], SIGMA, 0.0)
    });
    for report in reports(&mut locator, flight) {
        assert!(is_finite(&report));
    }
}

#[test]
fn flying_over_the_emitter_does_no_harm() {
    for filter in FilterChoice::ALL {
        let (mut locator, mut noise) = (locator(filter), Noise::new(7));
        // Through the emitter itself, and back beside it.
        let flight = (0..800).map(|k| {
            let along = 50.0 * f64::from(k) - 10e3;
            let platform = if k < 400 { [along, 0.0] } else { [20e3 - along, 2e3] };
            bearing(f64::from(k), platform, [0.0, 0.0], SIGMA, SIGMA * noise.next())
        });
        let found = reports(&mut locator, flight);
        assert!(found.iter().all(is_finite));
        if filter != FilterChoice::Straight {
            let last = found.last().unwrap().raw.position_m;
            assert!(last[0].hypot(last[1]) < 100.0, "{filter:?}: {last:?}");
        }
    }
}

#[test]
fn impossible_values_are_refused_and_counted() {
    let good = bearing(0.0, [0.0, 0.0], [1e3, 1e3], SIGMA, 0.0);
    let mut locator = locator(FilterChoice::Auto);
    let bad = [
        Bearing { sigma_rad: 0.0, ..good },
        Bearing {
            sigma_rad: -1.0,
            ..good
        },
        Bearing {
            sigma_rad: f64::NAN,
            ..good
        },
        Bearing { sigma_rad: 2.0, ..good },
        Bearing {
            bearing_rad: f64::NAN,
            ..good
        },
        Bearing {
            bearing_rad: f64::INFINITY,
            ..good
        },
        Bearing {
            platform_m: [f64::NAN, 0.0, 0.0],
            ..good
        },
        Bearing {
            platform_m: [0.0, 1e300, 0.0],
            ..good
        },
        Bearing {
            heading_rad: Some(f64::NAN),
            ..good
        },
        Bearing {
            frequency_hz: Some(0.0),
            ..good
        },
    ];
    for bearing in &bad {
        assert!(
            matches!(locator.bearing(bearing), Err(BearingRejection::Unusable(_))),
            "{bearing:?}"
        );
    }
    assert_eq!((locator.counts().unusable, locator.emitters()), (bad.len() as u64, 0));
}

#[test]
fn times_backwards_are_refused_and_equal_times_are_not() {
    let mut locator = locator(FilterChoice::Auto);
    let mut noise = Noise::new(8);
    for k in 0..100 {
        let platform = [100.0 * f64::from(k), 0.0];
        let measured = bearing(f64::from(k), platform, [3e3, 8e3], SIGMA, SIGMA * noise.next());
        locator.bearing(&measured).unwrap();
        locator.bearing(&measured).unwrap();
        let late = Bearing {
            time_of_measurement_ns: measured.time_of_measurement_ns - 1,
            ..measured
        };
        assert_eq!(locator.bearing(&late), Err(BearingRejection::OutOfOrder));
    }
    assert_eq!((locator.counts().bearings, locator.counts().out_of_order), (200, 100));
}

#[test]
fn a_full_table_refuses_until_an_emitter_has_been_silent_for_long() {
    let mut locator = locator(FilterChoice::Auto);
    let of = |id: u32, time_s: f64| Bearing {
        emitter_id: Some(id),
        ..bearing(time_s, [0.0, 0.0], [1e3, 1e3], SIGMA, 0.0)
    };
    for id in 0..4 {
        locator.bearing(&of(id, f64::from(id))).unwrap();
    }
    assert_eq!(locator.bearing(&of(9, 10.0)), Err(BearingRejection::TableFull));
    locator.bearing(&of(0, 500.0)).unwrap();
    // Emitter 1 was silent longest.
    assert!(locator.bearing(&of(9, 602.0)).is_ok());
    assert_eq!(
        locator.bearing(&of(1, 602.0)),
        Ok(None),
        "emitter 2 gives its place to it"
    );
    let counts = locator.counts();
    assert_eq!((counts.table_full, counts.emitters_dropped, counts.emitters), (1, 2, 6));
}

#[test]
fn bearings_without_id_find_their_emitter_by_frequency_and_direction() {
    let mut settings = Settings {
        emitters_max: 10,
        ..Settings::default()
    };
    settings.association.frequency_tolerance_hz = 1e3;
    let mut locator = Locator::new(settings).unwrap();
    let mut noise = Noise::new(9);
    // Two of one frequency, a third of another in the direction of the first.
    let emitters = [([0.0, 9e3], 1.2e8), ([20e3, 9e3], 1.2e8), ([0.0, 9.1e3], 2.4e8)];
    let mut last = std::collections::BTreeMap::new();
    for k in 0..300 {
        let platform = [50.0 * f64::from(k), 0.0];
        for (place, frequency) in emitters {
            let measured = Bearing {
                emitter_id: None,
                frequency_hz: Some(frequency + 100.0 * noise.next()),
                ..bearing(f64::from(k), platform, place, SIGMA, SIGMA * noise.next())
            };
            if let Some(report) = locator.bearing(&measured).unwrap() {
                last.insert(report.number, report.raw.position_m);
            }
        }
    }
    assert_eq!((locator.emitters(), locator.counts().associated), (3, 897));
    assert_eq!(
        last.keys().copied().collect::<Vec<_>>(),
        [0, 1, 2].map(|k| OWN_NUMBERS + k)
    );
    for (found, (place, _)) in last.values().zip(emitters) {
        let off = (found[0] - place[0]).hypot(found[1] - place[1]);
        assert!(off < 300.0, "off by {off} m");
    }
}

#[test]
fn single_wild_bearings_are_passed_over() {
    let (mut locator, mut noise) = (locator(FilterChoice::Auto), Noise::new(10));
    let flight = (0..500).map(|k| {
        let platform = [40.0 * f64::from(k), 0.0];
        let wild = if k % 25 == 24 { 1.0 } else { 0.0 };
        bearing(f64::from(k), platform, [9e3, 9e3], SIGMA, SIGMA * noise.next() + wild)
    });
    let last = *reports(&mut locator, flight).last().unwrap();
    let off = (last.raw.position_m[0] - 9e3).hypot(last.raw.position_m[1] - 9e3);
    assert!(off < 60.0, "off by {off} m");
}

#[test]
fn a_report_is_a_sensor_track() {
    let (mut locator, mut noise) = (locator(FilterChoice::Straight), Noise::new(11));
    let flight = (0..600).map(|k| {
        let angle = f64::from(k) / 40.0;
        let platform = [5e3 * angle.sin(), 5e3 * angle.cos()];
        bearing(
            f64::from(k),
            platform,
            [300.0 + 5.0 * f64::from(k), 0.0],
            SIGMA,
            SIGMA * noise.next(),
        )
    });
    let report = *reports(&mut locator, flight).last().unwrap();
    let track = report.sensor_track(3);
    assert_eq!(
        (track.track_number, track.source, track.time_of_measurement_ns),
        (1, 3, 599 * S)
    );
    assert_eq!(track.state, TrackState::Confirmed as u8);
    assert_eq!(track.position_m, report.output.position_m);
    assert!((track.velocity_mps[0] - 5.0).abs() < 0.5);
    let raw = &report.raw.covariance;
    for (component, place) in [(0, 0), (1, 1), (3, 2), (4, 3)] {
        assert!(track.covariance.get(component, component) >= raw[(place, place)]);
    }
    assert!(track.covariance.get(2, 2) > 1e6, "height is not observed");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_comes_nothing_breaks(
        rows in prop::collection::vec(
            (0u32..3, 0.0..3.0f64, -7.0..7.0f64, 1e-6..1.0f64, -1e4..1e4f64, -1e4..1e4f64, prop::option::of(-7.0..7.0f64)),
            1..400,
        ),
        filter in prop::sample::select(FilterChoice::ALL.to_vec()),
    ) {
        let mut locator = locator(filter);
        let mut time_s = 0.0;
        for (emitter, after_s, bearing_rad, sigma_rad, east, north, heading_rad) in rows {
            time_s += after_s;
            let bearing = Bearing {
                time_of_measurement_ns: (time_s * S as f64) as i64,
                emitter_id: (emitter > 0).then_some(emitter),
                bearing_rad,
                sigma_rad,
                platform_m: [east, north, 0.0],
                heading_rad,
                frequency_hz: None,
                pulse_interval_s: None,
            };
            if let Ok(Some(report)) = locator.bearing(&bearing) {
                prop_assert!(is_finite(&report), "{report:?}");
                prop_assert!(estimation_is_sound(&report));
            }
        }
    }
}

/// The covariance of the position is positive definite.
fn estimation_is_sound(report: &EmitterReport) -> bool {
    let p = &report.raw.covariance;
    p[(0, 0)] > 0.0 && p[(0, 0)] * p[(1, 1)] > p[(0, 1)] * p[(0, 1)]
}
