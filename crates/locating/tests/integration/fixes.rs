//! Ready-made fixes (EL-12): through the filters, joined with bearings, and as they are.

use locating::selection::{AboveThreshold, Select, SelectionInterval};
use locating::settings::FilterChoice;
use locating::{BearingRejection, Locator, MotionModel, Settings};
use observations::ReadyFix;

use crate::common::{Noise, S, bearing};

fn fix(time_s: f64, [east, north]: [f64; 2], covariance_m2: [f64; 3]) -> ReadyFix {
    ReadyFix {
        time_of_measurement_ns: (time_s * S as f64).round() as i64,
        emitter_id: 1,
        position_m: [east, north, 0.0],
        covariance_m2,
    }
}

/// The example of the specification: fixes 10 s apart, the fifth with a variance above the threshold.
#[test]
fn the_worked_check_holds_for_fixes_as_they_are() {
    let mut settings = Settings::default();
    settings.motion.filter = FilterChoice::None;
    settings.selection.select = Select::Interval;
    settings.selection.interval_s = 10.0;
    settings.selection.above_threshold = AboveThreshold::Continue;
    let mut locator = Locator::new(settings).unwrap();
    let good_m2 = 0.4 * settings.selection.position_sigma_max_m.powi(2);
    let mut outputs = Vec::new();
    for (step, place) in [
        [0.0, 0.0],
        [10.0, 0.0],
        [20.0, 2.0],
        [30.0, 3.0],
        [70.0, 70.0],
        [0.0, 0.0],
    ]
    .into_iter()
    .enumerate()
    {
        let variance_m2 = if step < 4 { good_m2 } else { 2.0 * good_m2 };
        let fix = fix(10.0 * step as f64, place, [variance_m2, 0.0, variance_m2]);
        let report = locator.fix(&fix).unwrap().unwrap();
        assert_eq!((report.raw.position_m, report.raw.motion), (place, MotionModel::Given));
        let [x, y, _] = report.output.position_m;
        outputs.push([x, y]);
    }
    let expected = [
        [0.0, 0.0],
        [10.0, 0.0],
        [20.0, 0.0],
        [30.0, 2.0],
        [40.0, 5.0],
        [50.0, 8.0],
    ];
    for (output, expected) in outputs.iter().zip(expected) {
        for axis in 0..2 {
            assert!((output[axis] - expected[axis]).abs() < 1e-9, "{outputs:?}");
        }
    }
}

/// Fixes of others have no platform from which a direction could change: intervals of geometry are intervals of time.
#[test]
fn intervals_of_geometry_end_by_time_for_fixes_as_they_are() {
    let selected = |interval: SelectionInterval| {
        let mut settings = Settings::default();
        settings.motion.filter = FilterChoice::None;
        settings.selection.select = Select::Interval;
        settings.selection.interval = interval;
        settings.selection.interval_s = 10.0;
        let mut locator = Locator::new(settings).unwrap();
        // The direction from the first fix turns by 36° with each of them.
        let fixes = (0..30).map(|step| {
            let angle = 0.2 * std::f64::consts::PI * f64::from(step);
            fix(
                f64::from(step),
                [50.0 * angle.sin(), 50.0 * angle.cos()],
                [25.0, 0.0, 25.0],
            )
        });
        fixes
            .map(|fix| locator.fix(&fix).unwrap().map(|report| report.output))
            .collect::<Vec<_>>()
    };
    assert_eq!(selected(SelectionInterval::Geometry), selected(SelectionInterval::Time));
}

#[test]
fn fixes_and_bearings_are_joined_in_one_filter() {
    const RUNS: u64 = 300;
    let (place, platform, sigma_rad) = ([5e3, 9e3], [0.0, 0.0], 0.01);
    let covariance_m2: [f64; 3] = [250_000.0, 60_000.0, 90_000.0];
    let [xx, xy, yy] = covariance_m2;
    let (mut squared, mut bound_m2) = (0.0, 0.0);
    for seed in 1..=RUNS {
        let mut noise = Noise::new(seed);
        let mut settings = Settings::default();
        settings.motion.filter = FilterChoice::Auto;
        let mut locator = Locator::new(settings).unwrap();
        let mut last = None;
        let mut information = nalgebra::Matrix2::zeros();
        for k in 0..20 {
            let time_s = 2.0 * f64::from(k);
            let east = xx.sqrt() * noise.next();
            let north = xy / xx * east + (yy - xy * xy / xx).sqrt() * noise.next();
            let found = fix(time_s, [place[0] + east, place[1] + north], covariance_m2);
            last = locator.fix(&found).unwrap().or(last);
            let seen = bearing(time_s + 1.0, platform, place, sigma_rad, sigma_rad * noise.next());
            last = locator.bearing(&seen).unwrap().or(last);
            let range_m2 = place[0] * place[0] + place[1] * place[1];
            let across = nalgebra::Vector2::new(place[1], -place[0]) / (range_m2 * sigma_rad);
            let of_fix = nalgebra::Matrix2::new(xx, xy, xy, yy).try_inverse().unwrap();
            information += of_fix + across * across.transpose();
        }
        let raw = last.expect("a fix determines the position").raw;
        squared += (raw.position_m[0] - place[0]).powi(2) + (raw.position_m[1] - place[1]).powi(2);
        bound_m2 += information.try_inverse().unwrap().trace();
    }
    let ratio = f64::sqrt(squared / bound_m2);
    assert!(ratio < 1.1, "{ratio} of the bound");
}

#[test]
fn fixes_that_cannot_be_are_refused_and_counted() {
    let mut locator = Locator::new(Settings::default()).unwrap();
    for bad in [
        fix(0.0, [f64::NAN, 0.0], [1.0, 0.0, 1.0]),
        fix(0.0, [0.0, 1e10], [1.0, 0.0, 1.0]),
        fix(0.0, [0.0, 0.0], [1.0, 2.0, 1.0]),
        fix(0.0, [0.0, 0.0], [0.0, 0.0, 1.0]),
        fix(0.0, [0.0, 0.0], [-1.0, 0.0, -1.0]),
        fix(0.0, [0.0, 0.0], [1.0, f64::NAN, 1.0]),
    ] {
        assert!(
            matches!(locator.fix(&bad), Err(BearingRejection::Unusable(_))),
            "{bad:?}"
        );
    }
    assert_eq!((locator.counts().unusable, locator.counts().ready_fixes), (6, 0));
    assert!(locator.fix(&fix(5.0, [0.0; 2], [1.0, 0.0, 1.0])).is_ok());
    let late = locator.fix(&fix(4.0, [0.0; 2], [1.0, 0.0, 1.0]));
    assert_eq!(late, Err(BearingRejection::OutOfOrder));
}
