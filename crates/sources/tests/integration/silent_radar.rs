//! A radar with a tracker of its own that falls silent publishes its empty scans by the clock (HT-12, WA-11).

use std::path::Path;

use configuration::Config;
use messages::{DetectionMark, TrackState, sensor_detection_bits as bits};
use observations::Observation;
use sources::{Pipeline, Processing, Samples};
use test_support::S;
use tracking::wide_area::arrivals::Arrivals;

/// A radar of four seconds whose silence raises the alarm after five periods.
const SITE: &str = "name = \"t\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n[[receiver]]\nname = \"lan\"\n\
                    [receiver.udp]\nlisten = \"127.0.0.1:8600\"\n\
                    [[source]]\nname = \"radar\"\nperiod_s = 4.0\n[source.live]\nreceiver = \"lan\"\n\
                    [source.covariance]\nposition_sigma_m = 50.0\n\
                    [source.tracker]\nscans = \"period\"\nclutter_density = 1e-10\n";
/// Monotonic time at the beginning of the day, nanoseconds.
const BOOT_NS: i64 = 1_000 * S;
/// Silence that raises the alarm, nanoseconds.
const ALARM_NS: i64 = 40 * S;

fn radar() -> Pipeline {
    let config = Config::parse(Path::new("t.toml"), SITE, &[]).unwrap();
    let processing = Processing::Detections(Box::new(config.tracker(0).unwrap().clone()));
    Pipeline::new(config.readings.sources[0].model, &processing, 0, Arrivals::new()).unwrap()
}

/// A plot of a target that flies east, received at once.
fn plot(pipeline: &mut Pipeline, time_ns: i64, samples: &mut Samples) {
    let plot = Observation {
        time_of_day_ns: Some(time_ns),
        plot: true,
        cartesian: Some([1e3 + 1e-7 * time_ns as f64, 20e3]),
        ..Observation::default()
    };
    pipeline.received(time_ns, time_ns);
    pipeline.take(&plot, BOOT_NS + time_ns, samples);
}

/// Times of the published scans without detections, seconds.
fn empty_scans(samples: &Samples) -> Vec<f64> {
    let marks = samples
        .detections
        .iter()
        .filter(|sample| sample.valid & bits::MARK != 0);
    let empty = marks.filter(|mark| DetectionMark::from_code(mark.kind) == Some(DetectionMark::EmptyScan));
    empty
        .map(|mark| mark.time_of_measurement_ns as f64 / S as f64)
        .collect()
}

#[test]
fn a_silent_radar_publishes_its_empty_scans_by_the_clock() {
    let (mut pipeline, mut samples) = (radar(), Samples::default());
    let at_ns = |turn: i64| 4 * S * turn + S;
    // The clock is read all the time; while the radar sends, it changes nothing.
    for turn in 0..20 {
        plot(&mut pipeline, at_ns(turn), &mut samples);
        (1..4).for_each(|second| pipeline.silent(BOOT_NS + at_ns(turn) + second * S, Some(ALARM_NS), &mut samples));
    }
    assert!(empty_scans(&samples).is_empty());
    let last_ns = at_ns(19);
    assert_eq!(samples.tracks.last().unwrap().state, TrackState::Confirmed as u8);
    // Two periods later, the radar's own turn is over, and each further turn was empty.
    let clock = |pipeline: &mut Pipeline, seconds: std::ops::Range<i64>, samples: &mut Samples| {
        seconds.for_each(|second| pipeline.silent(BOOT_NS + last_ns + second * S, Some(ALARM_NS), samples));
        empty_scans(samples)
    };
    assert!(clock(&mut pipeline, 1..8, &mut samples).is_empty());
    let by_the_clock = clock(&mut pipeline, 8..ALARM_NS / S, &mut samples);
    assert!((5..=8).contains(&by_the_clock.len()), "{by_the_clock:?}");
    let first_s = last_ns as f64 / S as f64;
    assert!(
        (first_s + 1.0..first_s + 8.0).contains(&by_the_clock[0]),
        "{by_the_clock:?}"
    );
    assert!(
        by_the_clock.windows(2).all(|pair| pair[1] - pair[0] == 4.0),
        "{by_the_clock:?}"
    );
    assert_eq!(samples.tracks.last().unwrap().state, TrackState::Coasted as u8);
    // A radar that is silent for longer may be dead.
    assert_eq!(clock(&mut pipeline, ALARM_NS / S..500, &mut samples), by_the_clock);
}
