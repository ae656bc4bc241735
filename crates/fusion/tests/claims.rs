//! What the methods that the rules come from promise, each in a small world with and without: a smooth hand-over
//! (TI-13), a steady course in spite of offsets (TI-11), a truer place than the mosaic's (QF-5).

use fusion::Engine;
use fusion::settings::{AccuracyTable, HandOverSettings, Settings, SourceSettings, Weighing};
use messages::{Covariance, FusionRule, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use settings::Seconds;
use test_support::{Random, S};

/// Speed of the target, which flies east along y = 0, metres per second.
const SPEED_MPS: f64 = 200.0;
/// Length of a run, and its beginning, in which tracks are confirmed and nothing is judged, seconds.
const RUN_S: u32 = 300;
const BEGINNING_S: f64 = 20.0;

/// One source at one time.
struct Look {
    /// Standard deviation of its errors, metres, and the one that it states.
    sigma_m: f64,
    stated_m: f64,
    /// By how much it is off to the north, metres.
    north_m: f64,
}

/// Settings for two sources that report each second, by `rule`; systematic errors stay as they are.
fn settings(rule: FusionRule) -> Settings {
    let source = |number: u32| {
        let usual = (1.0, number);
        let (name, weighing) = (format!("source-{number}"), Weighing::default());
        SourceSettings::new(&name, &weighing, usual, [0.0; 2], &AccuracyTable::default()).unwrap()
    };
    let mut settings = Settings::default();
    settings.rule.name.0 = rule;
    settings.registration.enabled = false;
    settings.refresh_s = Some(Seconds::of(1.0));
    settings.with_sources((0..2).map(source).collect()).unwrap()
}

/// Error of place, metres, at each refresh: along and across. `look` says how the sources see at a time in seconds.
fn errors(settings: Settings, seed: u64, look: impl Fn(usize, f64) -> Look) -> Vec<[f64; 2]> {
    let mut engine = Engine::new(settings).unwrap();
    let mut random = Random::new(seed);
    let mut normal = || (0..12).map(|_| random.unit() - 0.5).sum::<f64>();
    let mut errors = Vec::new();
    let mut sink = |track: &SystemTrack| {
        assert_eq!(track.track_number, 1, "one target");
        let time_s = track.reference_time_ns as f64 / S as f64;
        if track.state == TrackState::Confirmed as u8 && time_s > BEGINNING_S {
            errors.push([track.position_m[0] - SPEED_MPS * time_s, track.position_m[1]]);
        }
    };
    for step in 0..RUN_S {
        for source in 0..2 {
            let time_s = f64::from(step) + 0.4 * source as f64;
            let Look {
                sigma_m,
                stated_m,
                north_m,
            } = look(source, time_s);
            let report = SensorTrack {
                time_of_measurement_ns: (time_s * S as f64) as i64,
                source: source as u16,
                track_number: 1,
                valid: sensor_track_bits::VELOCITY | sensor_track_bits::OWN_COVARIANCE,
                position_m: [
                    SPEED_MPS * time_s + sigma_m * normal(),
                    north_m + sigma_m * normal(),
                    0.0,
                ],
                velocity_mps: [SPEED_MPS + 0.1 * normal(), 0.1 * normal(), 0.0],
                covariance: Covariance::diagonal([stated_m; 3], [1.0; 3]),
                state: TrackState::Confirmed as u8,
                ..SensorTrack::default()
            };
            engine.take(&report, &mut sink);
        }
    }
    assert!(errors.len() > 250, "shown all the time: {}", errors.len());
    errors
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0, 0.0), |(count, sum), value| (count + 1, sum + value * value));
    (sum / f64::from(count)).sqrt()
}

#[test]
fn a_blended_hand_over_is_smooth() {
    // The better source becomes the worse one, and the other is elsewhere.
    let look = |source: usize, time_s: f64| {
        let sigmas_m = if time_s < 150.0 { [1.0, 4.0] } else { [15.0, 1.0] };
        Look {
            sigma_m: sigmas_m[source],
            stated_m: 60.0,
            north_m: 120.0 * source as f64,
        }
    };
    for seed in 1..5 {
        let largest_step = |ramp: &[f64]| {
            let mut settings = settings(FusionRule::BestSource);
            (settings.rule.hysteresis, settings.rule.hold_refreshes) = (0.05, 5);
            settings.rule.hand_over = HandOverSettings {
                ramp: ramp.to_vec(),
                ..HandOverSettings::default()
            };
            let errors = errors(settings, seed, look);
            // It has been handed over, and stays so.
            assert!(errors[..100].iter().all(|error| error[1].abs() < 20.0));
            assert!(
                errors[errors.len() - 50..]
                    .iter()
                    .all(|error| (error[1] - 120.0).abs() < 40.0)
            );
            let steps = errors.windows(2).map(|pair| (pair[1][1] - pair[0][1]).abs());
            steps.fold(0.0, f64::max)
        };
        let (without, with) = (largest_step(&[]), largest_step(&[0.2, 0.4, 0.6, 0.8]));
        assert!(
            without > 80.0 && with < 0.6 * without,
            "seed {seed}: {without} m, {with} m"
        );
    }
}

#[test]
fn the_course_is_steadier_where_offset_sources_are_not_averaged() {
    // Two sources on either side, each in turn as sure of itself as it can be.
    let look = |source: usize, time_s: f64| {
        let side = if source == 0 { 1.0 } else { -1.0 };
        Look {
            sigma_m: 3.0,
            stated_m: 40.0 * (1.0 + 0.8 * side * (time_s / 6.0).sin()),
            north_m: 40.0 * side,
        }
    };
    for seed in 1..5 {
        let course_deg = |rule| {
            let mut settings = settings(rule);
            (settings.rule.hysteresis, settings.rule.hold_refreshes) = (0.02, 10);
            let errors = errors(settings, seed, look);
            let spans = errors.windows(6).map(|span| span[5][1] - span[0][1]);
            rms(spans.map(|aside_m| (aside_m / (5.0 * SPEED_MPS)).atan().to_degrees()))
        };
        let [averaged, followed] = [FusionRule::InverseTrace, FusionRule::BestSource].map(course_deg);
        assert!(averaged > 2.0 * followed, "seed {seed}: {averaged}°, {followed}°");
    }
}

#[test]
fn quality_factors_give_a_truer_place_than_a_mosaic() {
    let look = |_, _| Look {
        sigma_m: 50.0,
        stated_m: 50.0,
        north_m: 0.0,
    };
    for seed in 1..5 {
        let error_m = |rule| {
            let errors = errors(settings(rule), seed, look);
            rms(errors.iter().flatten().copied())
        };
        let [mosaic, weighted] = [FusionRule::Mosaic, FusionRule::QualityFactor].map(error_m);
        assert!(weighted < 0.85 * mosaic, "seed {seed}: {mosaic} m, {weighted} m");
    }
}
