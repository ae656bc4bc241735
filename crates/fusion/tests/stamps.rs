//! Coarse time stamps in a small world: errors of place, and whether the published covariance contains them.
//!
//! Three sources see twelve targets in straight flight, each source all targets at once. The periods are whole seconds,
//! so that the rounding is the same for all reports of a source.

use std::array::from_fn;

use fusion::Engine;
use fusion::settings::{AccuracyModel, AccuracyTable, Settings, SourceSettings, StampRounding, Weighing};
use messages::{Covariance, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use settings::Seconds;
use test_support::{Random, S};

const TARGETS: u32 = 12;
/// Length of a run, and its beginning, in which nothing is judged, seconds.
const RUN_S: f64 = 150.0;
const BEGINNING_S: f64 = 40.0;
/// Period, begin and standard deviation of each source, seconds and metres.
const SOURCES: [(f64, f64, f64); 3] = [(4.0, 0.0, 50.0), (5.0, 1.3, 30.0), (2.0, 0.7, 80.0)];

/// Root mean square of the error in the plane, metres, and the mean normalised square of the error per axis.
#[derive(Clone, Copy, Debug, Default)]
struct Quality {
    error_m: f64,
    nees: f64,
}

fn settings(stamps: [Option<StampRounding>; 3]) -> Settings {
    let accuracy = AccuracyTable {
        model: AccuracyModel::Reported,
        ..AccuracyTable::default()
    };
    let source = |number: usize| {
        let weighing = Weighing {
            stamps: stamps[number],
            ..Weighing::default()
        };
        let usual = (SOURCES[number].0, number as u32);
        SourceSettings::new(&format!("source-{number}"), &weighing, usual, [0.0; 2], &accuracy).unwrap()
    };
    let settings = Settings {
        refresh_s: Some(Seconds::of(1.0)),
        ..Settings::default()
    };
    settings.with_sources((0..3).map(source).collect()).unwrap()
}

fn velocity_mps(target: u32) -> [f64; 2] {
    let (heading, speed_mps) = (f64::from(target) * 0.55, 150.0 + 8.0 * f64::from(target));
    [speed_mps * heading.sin(), speed_mps * heading.cos()]
}

fn place_m(target: u32, time_s: f64) -> [f64; 2] {
    let velocity = velocity_mps(target);
    let begin = [8e3 * f64::from(target % 4), 8e3 * f64::from(target / 4)];
    from_fn(|axis| begin[axis] + velocity[axis] * time_s)
}

/// The target at a place.
fn nearest(track: &SystemTrack, time_s: f64) -> (u32, [f64; 2]) {
    let apart = |target: u32| {
        let place = place_m(target, time_s);
        [0, 1].map(|axis| track.position_m[axis] - place[axis])
    };
    let all = (0..TARGETS).map(|target| (target, apart(target)));
    all.min_by(|(_, a), (_, b)| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])))
        .unwrap()
}

/// Quality of the picture of sources whose stamps are rounded down to these steps, seconds; 0: exact.
fn quality(stamps: [Option<StampRounding>; 3], steps_s: [f64; 3], seed: u64) -> Quality {
    let mut engine = Engine::new(settings(stamps)).unwrap();
    let mut random = Random::new(seed);
    let mut normal = || (0..12).map(|_| random.unit() - 0.5).sum::<f64>();
    let mut reports = Vec::new();
    for (number, (period_s, begin_s, sigma_m)) in SOURCES.into_iter().enumerate() {
        for look in 0.. {
            let time_s = begin_s + period_s * f64::from(look);
            if time_s >= RUN_S {
                break;
            }
            let stamp_s = match steps_s[number] {
                0.0 => time_s,
                step_s => (time_s / step_s + 1e-9).floor() * step_s,
            };
            for target in 0..TARGETS {
                let ([x, y], [vx, vy]) = (place_m(target, time_s), velocity_mps(target));
                reports.push(SensorTrack {
                    time_of_measurement_ns: (stamp_s * 1e3).round() as i64 * (S / 1000),
                    source: number as u16,
                    track_number: target + 1,
                    valid: sensor_track_bits::VELOCITY | sensor_track_bits::OWN_COVARIANCE,
                    position_m: [x + sigma_m * normal(), y + sigma_m * normal(), 0.0],
                    velocity_mps: [vx + 5.0 * normal(), vy + 5.0 * normal(), 0.0],
                    covariance: Covariance::diagonal([sigma_m; 3], [5.0; 3]),
                    state: TrackState::Confirmed as u8,
                    ..SensorTrack::default()
                });
            }
        }
    }
    reports.sort_by_key(|report| report.time_of_measurement_ns);
    let (mut squares_m2, mut nees, mut count) = (0.0, 0.0, 0.0);
    let mut sink = |track: &SystemTrack| {
        let time_s = track.reference_time_ns as f64 / S as f64;
        if track.state != TrackState::Confirmed as u8 || time_s < BEGINNING_S {
            return;
        }
        let (_, [x, y]) = nearest(track, time_s);
        let [xx, xy, yy] = [(0, 0), (0, 1), (1, 1)].map(|(row, column)| track.covariance.get(row, column));
        squares_m2 += x * x + y * y;
        nees += (yy * x * x - 2.0 * xy * x * y + xx * y * y) / (2.0 * (xx * yy - xy * xy));
        count += 1.0;
    };
    reports.iter().for_each(|report| engine.take(report, &mut sink));
    assert!(
        count > 0.9 * f64::from(TARGETS) * (RUN_S - BEGINNING_S),
        "shown: {count}"
    );
    Quality {
        error_m: (squares_m2 / count).sqrt(),
        nees: nees / count,
    }
}

/// The mean of four seeds.
fn mean(stamps: [Option<StampRounding>; 3], steps_s: [f64; 3]) -> Quality {
    let all = (1..5).map(|seed| quality(stamps, steps_s, seed));
    let sum = all.fold(Quality::default(), |sum, each| Quality {
        error_m: sum.error_m + each.error_m,
        nees: sum.nees + each.nees,
    });
    Quality {
        error_m: sum.error_m / 4.0,
        nees: sum.nees / 4.0,
    }
}

#[test]
fn rounded_times_of_all_sources_are_in_the_covariance() {
    for step_s in [1.0, 0.5] {
        let unknown = mean([None; 3], [step_s; 3]);
        let down = mean([Some(StampRounding::Down); 3], [step_s; 3]);
        let nearest = mean([Some(StampRounding::Nearest); 3], [step_s; 3]);
        assert!((0.3..1.3).contains(&unknown.nees), "{step_s}: {unknown:?}");
        assert!((0.4..1.4).contains(&down.nees), "{step_s}: {down:?}");
        assert!(nearest.nees > unknown.nees, "{step_s}: {nearest:?}");
        assert!(down.error_m < 0.9 * unknown.error_m, "{step_s}: {down:?} {unknown:?}");
    }
}

#[test]
fn fine_stamps_of_a_source_decide_about_those_of_others() {
    let exact = mean([None; 3], [0.0; 3]);
    for stated in [Some(StampRounding::Down), Some(StampRounding::Unknown)] {
        let beside = mean([stated, None, stated], [1.0, 0.0, 1.0]);
        assert!(
            beside.error_m < 1.25 * exact.error_m,
            "{beside:?}, with exact times {exact:?}"
        );
        assert!((0.4..1.4).contains(&beside.nees), "{beside:?}");
    }
}

#[test]
fn a_source_that_measures_at_whole_seconds_is_exact_beside_fine_stamps() {
    // The first source measures at multiples of four seconds: the rounding changes nothing, nor does the recognition.
    let exact = quality([None; 3], [0.0; 3], 1);
    let rounded = quality([None; 3], [1.0, 0.0, 0.0], 1);
    assert_eq!((exact.error_m, exact.nees), (rounded.error_m, rounded.nees));
    let stated = quality([Some(StampRounding::Unknown), None, None], [0.0; 3], 1);
    assert_ne!(exact.nees, stated.nees);
}
