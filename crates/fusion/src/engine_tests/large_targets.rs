//! Targets that are larger than the sources' errors: each source sees another point of them.

use std::collections::BTreeSet;

use messages::{AXES, FusionRule};

use super::*;
use crate::settings::{CoverageArea, RuleName};

/// Where the sources see a target, in parts of its size: along its course and to the right of it.
const POINTS: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.85]];
const TARGETS: u32 = 8;

/// Reports of a source: time of the first one, seconds; period, whole seconds; standard deviation, metres.
#[derive(Clone, Copy)]
struct Reports {
    begins_s: f64,
    period_s: u32,
    sigma_m: f64,
}

const EXACT: Reports = Reports {
    begins_s: 0.0,
    period_s: 1,
    sigma_m: 4.0,
};

/// Fusion of targets of size `size_m` that all go their ways, without noise; the errors of source 0's point, largest of
/// all targets at each second, m.
fn followed(size_m: f64, sources: [Reports; 3], seconds: u32) -> (Harness, Vec<f64>) {
    let mut settings = test_settings(3);
    settings.rule.name = RuleName(FusionRule::Auto);
    for (source, reports) in settings.sources.iter_mut().zip(sources) {
        source.period_ns = i64::from(reports.period_s) * S;
        source.coverage = Some(CoverageArea {
            probability: 0.95,
            ..CoverageArea::none()
        });
    }
    let mut harness = Harness::new(settings);
    let mut errors_m = Vec::new();
    for second in 0..seconds {
        let mut largest_m = 0.0f64;
        for (source, reports) in (0..3u16).zip(sources) {
            let time_s = f64::from(second) + 0.2 * f64::from(source);
            if time_s < reports.begins_s || !second.is_multiple_of(reports.period_s) {
                continue;
            }
            let sigma_m = reports.sigma_m;
            for target in 0..TARGETS {
                // A point that lies ahead is told from a clock that is fast by targets of several speeds.
                let speed_mps = 4.0 + 2.0 * f64::from(target);
                let (sin, cos) = f64::from(target).sin_cos();
                let [along, right] = POINTS[usize::from(source)].map(|part| part * size_m);
                let from = [3000.0 * f64::from(target), 0.0];
                let seen = [from[0] + along * sin + right * cos, from[1] + along * cos - right * sin];
                let seen = SensorTrack {
                    covariance: Covariance::diagonal([sigma_m, sigma_m, 100.0], [sigma_m / 4.0, sigma_m / 4.0, 1.0]),
                    ..report(source, target, time_s, seen, [speed_mps * sin, speed_mps * cos])
                };
                if let Some(track) = harness.take(&seen) {
                    let [east, north, _] = track.position_m;
                    let moved_m = speed_mps * time_s;
                    let error_m = (east - from[0] - moved_m * sin).hypot(north - moved_m * cos);
                    largest_m = largest_m.max(error_m);
                }
            }
        }
        errors_m.push(largest_m);
    }
    (harness, errors_m)
}

#[test]
fn each_is_one_system_track_from_the_first_report_on() {
    for size_m in [20.0, 40.0] {
        let (harness, _) = followed(size_m, [EXACT; 3], 30);
        let shown = |track: &&SystemTrack| track.state == TrackState::Confirmed as u8;
        let published = harness.published.iter().filter(shown);
        let numbers: BTreeSet<u32> = published.map(|track| track.track_number).collect();
        assert_eq!(numbers.len(), TARGETS as usize, "{size_m} m: {numbers:?}");
    }
}

/// Each source places a ship's echo hundreds of metres from the others' echoes, and starts a track of its own there.
#[test]
fn long_ships_are_shown_early_and_once() {
    let radar = |period_s| Reports {
        period_s,
        sigma_m: 15.0,
        ..EXACT
    };
    let (harness, _) = followed(240.0, [radar(3), radar(5), radar(10)], 120);
    let mut shown = vec![BTreeSet::new(); 120];
    for track in &harness.published {
        let second = (track.time_of_measurement_ns / S) as usize;
        if track.state == TrackState::Confirmed as u8 {
            shown[second / 10].insert(track.track_number);
        }
    }
    let counts: Vec<usize> = shown[..12].iter().map(BTreeSet::len).collect();
    assert_eq!(counts[2..], [TARGETS as usize; 10], "{counts:?}");
}

const RADAR: Reports = Reports { sigma_m: 15.0, ..EXACT };

/// A ship's echoes lie too far apart to join by their distance. Silence joins them: each radar follows one of them.
#[test]
fn the_points_of_a_long_ship_become_one_track_at_the_point_of_the_first_source() {
    for (size_m, periods_s) in [
        (240.0, [3, 5, 10]),
        (400.0, [3, 5, 10]),
        (400.0, [1, 1, 2]),
        (400.0, [10, 3, 3]),
    ] {
        let sources = periods_s.map(|period_s| Reports { period_s, ..RADAR });
        let (harness, errors_m) = followed(size_m, sources, 150);
        assert_eq!(harness.live(), TARGETS as usize, "{size_m} m, {periods_s:?}");
        let last_m = errors_m[110..].iter().copied().fold(0.0, f64::max);
        assert!(last_m < 10.0, "{size_m} m, {periods_s:?}: {errors_m:.0?}");
    }
}

#[test]
fn the_point_of_a_first_source_that_comes_late_lies_within_the_covariance_and_is_shown_soon() {
    let late = Reports {
        begins_s: 60.0,
        period_s: 5,
        ..RADAR
    };
    let (harness, errors_m) = followed(400.0, [late, RADAR, RADAR], 120);
    let last_m = errors_m[90..].iter().copied().fold(0.0, f64::max);
    assert!(last_m < 15.0, "{errors_m:.0?}");
    for track in &harness.published {
        let time_s = track.time_of_measurement_ns as f64 / S as f64;
        // Three reports show the late point.
        if track.state != TrackState::Confirmed.code() || time_s < 71.0 {
            continue;
        }
        let squared = (0..TARGETS).map(|target| {
            let (sin, cos) = f64::from(target).sin_cos();
            let way_m = (4.0 + 2.0 * f64::from(target)) * time_s;
            let off_m = [
                track.position_m[0] - 3000.0 * f64::from(target) - way_m * sin,
                track.position_m[1] - way_m * cos,
            ];
            let of = |row: usize, column: usize| track.covariance.get(row, column);
            association::distance::squared2(off_m, [of(0, 0), of(0, 1), of(1, 1)])
        });
        let least = squared.fold(f64::INFINITY, f64::min);
        assert!(least < 9.0, "{least} at {time_s} s, {:?}", track.position_m);
    }
}

/// Two boats abreast, which two radars follow both, are no points of a ship.
#[test]
fn boats_that_keep_together_stay_two() {
    let mut settings = test_settings(2);
    settings.rule.name = RuleName(FusionRule::Auto);
    for source in &mut settings.sources {
        source.coverage = Some(CoverageArea {
            probability: 0.95,
            ..CoverageArea::none()
        });
    }
    let mut harness = Harness::new(settings);
    for second in 0..120 {
        // Each radar finds one boat first, and the other boat later.
        for (source, boat, begins_s) in [(0, 0, 0), (1, 1, 0), (0, 1, 12), (1, 0, 30)] {
            if second >= begins_s {
                let time_s = f64::from(second) + 0.2 * f64::from(source);
                let place_m = [200.0 * f64::from(boat), 8.0 * time_s];
                harness.take(&report(source, boat, time_s, place_m, [0.0, 8.0]));
            }
        }
    }
    assert_eq!(harness.live(), 2);
}

/// A taxiing aircraft whose radar echo lies 200 m aside is no ship: its address excludes one.
#[test]
fn a_slow_aircraft_is_no_point_of_a_ship() {
    let live = |address: u32| {
        let mut settings = test_settings(2);
        settings.rule.name = RuleName(FusionRule::Auto);
        for source in &mut settings.sources {
            source.coverage = Some(CoverageArea {
                probability: 0.95,
                ..CoverageArea::none()
            });
        }
        let mut harness = Harness::new(settings);
        for second in 0..120 {
            for source in 0..2u16 {
                let time_s = f64::from(second) + 0.2 * f64::from(source);
                let seen = report(source, 1, time_s, [200.0 * f64::from(source), 0.0], [0.0, 8.0]);
                let has_address = source == 1 && address != 0;
                harness.take(&if has_address { with_address(seen, address) } else { seen });
            }
        }
        harness.live()
    };
    assert_eq!([live(0), live(0x3c_6545)], [1, 2]);
}

#[test]
fn all_show_the_point_of_the_first_source_also_where_it_comes_last() {
    for begins_s in [0.0, 40.0] {
        let first = Reports { begins_s, ..EXACT };
        let (_, errors_m) = followed(20.0, [first, EXACT, EXACT], 100);
        let last_m = errors_m[80..].iter().copied().fold(0.0, f64::max);
        assert!(last_m < 2.0, "{begins_s}: {errors_m:.1?}");
    }
}

#[test]
fn tracks_stay_certain_when_one_point_is_chosen() {
    // The source of the chosen point reports seldom and coarsely, and the points of the others are unknown at first.
    let coarse = Reports {
        period_s: 8,
        sigma_m: 100.0,
        ..EXACT
    };
    let (harness, _) = followed(20.0, [coarse, EXACT, EXACT], 60);
    let largest = |axis: usize| {
        let later = harness.published.iter().skip(4 * TARGETS as usize);
        let variances = later.map(|track| track.covariance.get(axis, axis));
        variances.fold(0.0, f64::max).sqrt()
    };
    let (largest_m, largest_mps) = (largest(0), largest(AXES));
    assert!(
        largest_m < 30.0 && largest_mps < 8.0,
        "{largest_m} m, {largest_mps} m/s"
    );
}

/// The errors of coarse sources change slowly, so that means over some reports err by more than noise would let them.
#[test]
fn slow_errors_of_coarse_sources_are_no_points_for_accurate_sources() {
    const SIGMAS_M: [f64; 6] = [250.0, 250.0, 250.0, 10.0, 12.0, 15.0];
    let mut settings = test_settings(SIGMAS_M.len());
    settings.rule.name = RuleName(FusionRule::Auto);
    let mut harness = Harness::new(settings);
    let mut largest_m = 0.0f64;
    for second in 0..150 {
        for (source, sigma_m) in (0u16..).zip(SIGMAS_M) {
            let time_s = f64::from(second) + 0.1 * f64::from(source);
            for target in 0..TARGETS {
                let phase = f64::from(7 * target + 3 * u32::from(source));
                // Accurate sources err anew at each report, coarse ones within a minute.
                let rate = if sigma_m > 100.0 { 0.1 } else { 2.4 };
                let error_m = [0.0, 1.5].map(|axis| sigma_m * (rate * time_s + phase + axis).sin());
                let way_m = 50.0 * time_s;
                let (sin, cos) = f64::from(target).sin_cos();
                let from_m = [30_000.0 * f64::from(target), 0.0];
                let place_m = [from_m[0] + way_m * sin, from_m[1] + way_m * cos];
                let seen = SensorTrack {
                    covariance: Covariance::diagonal([sigma_m, sigma_m, 100.0], [10.0, 10.0, 1.0]),
                    ..report(
                        source,
                        target,
                        time_s,
                        [from_m[0] + error_m[0], error_m[1]],
                        [50.0 * sin, 50.0 * cos],
                    )
                };
                if let Some(track) = harness.take(&seen)
                    && second > 60
                    && track.state == TrackState::Confirmed as u8
                {
                    let [east, north, _] = track.position_m;
                    largest_m = largest_m.max((east - place_m[0]).hypot(north - place_m[1]));
                }
            }
        }
    }
    assert!(largest_m < 25.0, "{largest_m} m");
}
