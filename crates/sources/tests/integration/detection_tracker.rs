//! What a detection tracker says at even times, of where to look, and of who is who.

use std::path::Path;

use configuration::Config;
use messages::{
    Counter, Counters, SensorBearing, SensorTrack, StageTimes, TrackState, sensor_bearing_bits, sensor_track_bits,
};
use observations::{Detection, DetectionKind, DetectionPlatform, Sampled as _, SensorEvent, TransponderReply};
use proptest::prelude::*;

use sources::{DetectionTracker, PlatformAxes, Samples, ScanTracker, SensorScan, TrackSink, TrackerSettings};
use test_support::S;
use tracking::TrackReport;
use tracking::scans::{scans_of, silent_scans};
use tracking::wide_area::arrivals::Arrivals;
use tracking::wide_area::cue::Cue;

const SITE: &str = "name = \"t\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n[[receiver]]\nname = \"lan\"\n\
                    [receiver.udp]\nlisten = \"127.0.0.1:8600\"\n[[receiver]]\nname = \"ears\"\n[receiver.udp]\nlisten = \"127.0.0.1:8601\"\n\
                    [[source]]\nname = \"radar\"\nperiod_s = 4.0\n[source.live]\nreceiver = \"lan\"\n[source.covariance]\nposition_sigma_m = 50.0\n\
                    [source.tracker]\nscans = \"period\"\nclutter_density = 1e-10\nKEYS\n[[source.tracker.wide_area.type]]\nname = \"patrol\"\n\
                    emissions = [{ frequency_hz = [9.3e9, 9.5e9] }]\n[[source.tracker.wide_area.prior]]\n\
                    circle = { centre_m = [0.0, 0.0], radius_m = 90e3 }\ntypes = { patrol = 0.6 }\n\
                    [[source]]\nname = \"finder\"\n[source.live]\nreceiver = \"ears\"\n[source.locator]\n";

fn settings(keys: &str) -> TrackerSettings {
    let config = Config::parse(Path::new("t.toml"), &SITE.replace("KEYS", keys), &[]).unwrap();
    config.tracker(0).unwrap().clone()
}

fn tracker(keys: &str) -> DetectionTracker {
    DetectionTracker::new(0, &settings(keys), 0, Arrivals::new()).unwrap()
}

fn east_m(time_s: f64) -> f64 {
    1000.0 + 100.0 * time_s
}

/// A detection of a target that flies east.
fn seen(time_s: f64) -> Detection {
    Detection {
        time_of_measurement_ns: (time_s * 1e9) as i64,
        sensor_id: 1,
        scan: 0,
        detection_id: 0,
        kind: DetectionKind::Position2,
        values: [east_m(time_s), 20e3, 0.0],
        range_rate_mps: None,
        sigmas: Some([50.0, 50.0, 0.0, 0.0]),
        platform_m: [0.0; 3],
        platform: DetectionPlatform::default(),
        height: None,
        velocity: None,
        reply: TransponderReply::default(),
        truth: None,
    }
}

/// One detection in the middle of each period, and the time in the middle of its second half.
fn fly(tracking: &mut DetectionTracker, scans: std::ops::Range<u32>, made: &mut Samples) {
    for scan in scans {
        let time_s = 4.0 * f64::from(scan) + 1.2;
        tracking.take(seen(time_s), 0, made);
        tracking.passed((time_s * 1e9) as i64 + 2 * S, false, 0, made);
    }
}

#[test]
fn tracks_come_at_even_times_and_what_is_extrapolated_says_so() {
    let mut tracking = tracker("output_period_s = 1.5");
    let mut made = Samples::default();
    fly(&mut tracking, 0..20, &mut made);
    let times: Vec<i64> = made.tracks.iter().map(|track| track.time_of_measurement_ns).collect();
    assert!(times.len() > 20 && times.is_sorted(), "{times:?}");
    assert!(times.iter().all(|time_ns| time_ns % 1_500_000_000 == 0), "{times:?}");
    // None is left out, and no later one is older than the progress that was said.
    assert!(
        times.windows(2).all(|pair| pair[1] - pair[0] == 1_500_000_000),
        "{times:?}"
    );
    assert_eq!(tracking.progress_ns(), *times.last().unwrap());
    let is = |track: &&SensorTrack, state: TrackState| track.state == state as u8;
    let coasted = made
        .tracks
        .iter()
        .filter(|track| is(track, TrackState::Coasted))
        .count();
    let confirmed = made
        .tracks
        .iter()
        .filter(|track| is(track, TrackState::Confirmed))
        .count();
    // One scan in four seconds, a picture each one and a half: most pictures follow no scan.
    assert!(confirmed > 8 && coasted > confirmed, "{confirmed} {coasted}");
    for track in &made.tracks {
        let expected = east_m(track.time_of_measurement_ns as f64 / 1e9);
        assert!((track.position_m[0] - expected).abs() < 100.0, "{track:?}");
    }
}

#[test]
fn without_a_period_tracks_come_after_scans() {
    let mut tracking = tracker("");
    let mut made = Samples::default();
    fly(&mut tracking, 0..10, &mut made);
    let times = made.tracks.iter().map(|track| track.time_of_measurement_ns);
    assert!(times.clone().all(|time_ns| time_ns % (4 * S) == 1_200_000_000) && times.count() > 5);
    assert!(made.cues.is_empty());
}

/// A radar of which nobody says that a turn takes 7.6 s; its north marks, its statement and its plots each do.
#[test]
fn tracks_are_made_turn_by_turn_where_no_period_is_configured() {
    let turn_ns = 76 * S / 10;
    for by in ["north marks", "statement", "plots"] {
        let site = SITE.replace("period_s = 4.0\n", "").replace("scans = \"period\"\n", "");
        let config = Config::parse(Path::new("t.toml"), &site.replace("KEYS", ""), &[]).unwrap();
        let settings = config.tracker(0).unwrap();
        let mut tracking = DetectionTracker::new(0, settings, 0, Arrivals::new()).unwrap();
        let mut made = Samples::default();
        for turn in 0..40 {
            let begin_ns = turn * turn_ns;
            match by {
                "north marks" => tracking.passed(begin_ns, true, 0, &mut made),
                "statement" => tracking.turn_takes(turn_ns),
                _ => {}
            }
            // Eight targets fly east, 40 km away in as many directions.
            for target in 0..8 {
                let share = (f64::from(target) + 0.4) / 8.0;
                let time_ns = begin_ns + (share * turn_ns as f64) as i64;
                let (sin, cos) = (share * std::f64::consts::TAU).sin_cos();
                tracking.take(
                    Detection {
                        values: [40e3 * sin + time_ns as f64 * 1e-8, 40e3 * cos, 0.0],
                        time_of_measurement_ns: time_ns,
                        ..seen(0.0)
                    },
                    0,
                    &mut made,
                );
            }
        }
        let mut counters = Counters::default();
        counters[Counter::Reports] = 320;
        tracking.count(&mut counters);
        let period_ms = counters[Counter::ScanPeriodMs];
        assert!(period_ms.abs_diff(7_600) < 40, "{by}: {period_ms} ms");
        assert!(
            (38..=42).contains(&counters[Counter::Scans]),
            "{by}: {}",
            counters[Counter::Scans]
        );
        let numbers: std::collections::BTreeSet<u32> = made.tracks.iter().map(|track| track.track_number).collect();
        assert_eq!(numbers.len(), 8, "{by}");
        assert!(made.tracks.len() > 8 * 30, "{by}: {}", made.tracks.len());
    }
}

#[test]
fn the_next_detection_is_where_the_cue_says() {
    let mut tracking = tracker("cues = true");
    let mut made = Samples::default();
    fly(&mut tracking, 0..12, &mut made);
    assert!(made.cues.len() > 6, "{:?}", made.cues);
    let mut counters = Counters::default();
    counters[Counter::Reports] = 12;
    tracking.count(&mut counters);
    assert_eq!(counters[Counter::Cues], made.cues.len() as u64);
    for cue in &made.cues {
        let time_s = cue.time_ns as f64 / 1e9;
        // One turn after a detection there is the next one, within the ellipse.
        assert_eq!(cue.time_ns % (4 * S), 1_200_000_000, "{cue:?}");
        let away = (cue.position_m[0] - east_m(time_s)).hypot(cue.position_m[1] - 20e3);
        assert!(away < cue.half_axes_m[1] && cue.half_axes_m[0] < 2e3, "{cue:?}");
        assert!((0.0..std::f64::consts::PI).contains(&cue.orientation_rad) && cue.track_number > 0);
    }
}

#[test]
fn emissions_identify_a_track_and_bad_ones_are_counted() {
    let mut tracking = tracker("emissions = [\"finder\"]");
    let mut made = Samples::default();
    fly(&mut tracking, 0..6, &mut made);
    assert!(made.tracks.iter().all(|track| track.target_type.name().is_none()));
    let heard = |time_s: f64| SensorBearing {
        time_of_measurement_ns: (time_s * 1e9) as i64,
        bearing_rad: east_m(time_s).atan2(20e3),
        sigma_rad: 0.01,
        frequency_hz: 9.4e9,
        valid: sensor_bearing_bits::FREQUENCY,
        ..SensorBearing::default()
    };
    tracking.emission(&heard(23.0));
    for bad in [
        SensorBearing {
            valid: 0,
            ..heard(23.5)
        },
        SensorBearing {
            bearing_rad: f64::NAN,
            ..heard(23.5)
        },
        SensorBearing {
            frequency_hz: -1.0,
            ..heard(23.5)
        },
    ] {
        tracking.emission(&bad);
    }
    made.tracks.clear();
    fly(&mut tracking, 6..9, &mut made);
    let last = made.tracks.last().unwrap();
    assert_eq!(last.target_type.name(), Some("patrol"), "{last:?}");
    let mut counters = Counters::default();
    counters[Counter::Reports] = 9;
    tracking.count(&mut counters);
    assert_eq!(counters[Counter::Emissions], 1);
    assert_eq!(counters[Counter::EmissionsRejected], 3);
}

/// Time of the latest detection of [`fly`] with 20 scans.
const LAST_NS: i64 = 77_200_000_000;

#[test]
fn pictures_go_on_by_the_clock_while_the_sensor_is_silent() {
    let mut tracking = tracker("output_period_s = 1.5");
    let mut made = Samples::default();
    fly(&mut tracking, 0..20, &mut made);
    let by_data = made.tracks.len();
    made.has_picture = false;
    // A period and a tenth of it are waited for data.
    let patience_ns = 4_400_000_000;
    for step in 0..400 {
        let (clock_ns, before) = (LAST_NS + step * S / 2, made.tracks.len());
        tracking.elapsed(clock_ns, &mut made);
        let times = made.tracks[before..].iter().map(|track| track.time_of_measurement_ns);
        assert!(times.clone().all(|time_ns| time_ns <= clock_ns - patience_ns));
        assert_eq!(std::mem::take(&mut made.has_picture), times.count() > 0);
    }
    let times: Vec<i64> = made.tracks.iter().map(|track| track.time_of_measurement_ns).collect();
    assert!(
        times.windows(2).all(|pair| pair[1] - pair[0] == 1_500_000_000),
        "{times:?}"
    );
    let states = made.tracks[by_data..].iter().map(|track| track.state);
    assert!(states.skip(4).all(|state| state == TrackState::Coasted as u8));
    // The detection that waited for the end of its scan is in them; a target silent for a minute is not.
    assert_eq!(made.detections.len(), 20);
    let last_ns = *times.last().unwrap();
    assert!((LAST_NS + 57 * S..LAST_NS + 60 * S).contains(&last_ns), "{last_ns}");
    // The sensor comes back, and its track is the same.
    let number = made.tracks[0].track_number;
    let seen_again = made.tracks.len();
    tracking.take(seen(280.0), 0, &mut made);
    fly(&mut tracking, 71..80, &mut made);
    assert!(made.tracks.len() > seen_again && made.tracks[seen_again].track_number >= number);
}

#[test]
fn without_pictures_the_clock_changes_nothing() {
    let mut tracking = tracker("");
    let mut made = Samples::default();
    fly(&mut tracking, 0..10, &mut made);
    let (tracks, detections) = (made.tracks.len(), made.detections.len());
    tracking.elapsed(10_000 * S, &mut made);
    assert_eq!((made.tracks.len(), made.detections.len()), (tracks, detections));
    assert!(!made.has_picture);
}

/// Handles the pictures of a tracker that is fed with recorded scans.
#[derive(Default)]
struct Repeated(Vec<SensorTrack>);

impl TrackSink for Repeated {
    fn tracks(&mut self, tracks: &[TrackReport], extrapolated: bool) {
        self.0.extend(tracks.iter().map(|report| SensorTrack {
            state: match extrapolated {
                true => TrackState::Coasted as u8,
                false => report.state as u8,
            },
            ..report.sensor_track(0)
        }));
    }

    fn cues(&mut self, _scan_ns: i64, _cues: &[Cue]) {}
}

/// What was published, in its order: number, time and detections of a scan, or the time of the latest picture.
enum Published {
    Scan(u32, i64, Vec<Detection>),
    Picture(i64),
}

proptest! {
    /// Whenever data come and the clock is read, the order of publication is all that is needed to repeat the pictures.
    #[test]
    fn the_order_of_publication_gives_the_same_pictures_again(
        steps in prop::collection::vec((0u32..3, 0.0..3.0f64), 40..120),
    ) {
        let keys = "output_period_s = 1.5";
        let mut tracking = tracker(keys);
        let (mut time_s, mut log, mut live) = (0.0, Vec::new(), Vec::new());
        for (what, step_s) in steps {
            time_s += step_s;
            let mut made = Samples::default();
            match what {
                0 => tracking.elapsed((time_s * 1e9) as i64, &mut made),
                1 => tracking.passed((time_s * 1e9) as i64, false, 0, &mut made),
                _ => tracking.take(seen(time_s), 0, &mut made),
            }
            for scan in made.detections.chunk_by(|one, other| one.scan == other.scan) {
                let detections: Vec<Detection> = scan.iter().filter_map(Detection::of_sample).collect();
                let last = scan.last().unwrap();
                log.push(Published::Scan(last.scan, last.time_of_measurement_ns, detections));
            }
            // Pictures without tracks count, too.
            log.push(Published::Picture(tracking.progress_ns()));
            live.extend(made.tracks);
        }
        let settings = settings(keys);
        let mut again = ScanTracker::new(settings.settings, settings.outputs, Arrivals::new(), Vec::new()).unwrap();
        let (mut repeated, mut latest) = (Repeated::default(), None);
        for each in &log {
            let Published::Scan(scan, scan_ns, detections) = each else {
                let Published::Picture(time_ns) = each else { continue };
                again.show(*time_ns, &mut repeated);
                continue;
            };
            let now = (*scan, *scan_ns);
            let of_sensor = |(number, time_ns), detections| SensorScan { sensor_id: 1, number, time_ns, detections };
            for silent in latest.into_iter().flat_map(|before| silent_scans(before, now)) {
                again.scan(&of_sensor(silent, &[]), None, &mut repeated);
            }
            again.scan(&of_sensor(now, &detections[..]), None, &mut repeated);
            latest = Some(now);
        }
        let plain = |tracks: Vec<SensorTrack>| -> Vec<SensorTrack> {
            tracks.into_iter().map(|track| SensorTrack { stages: StageTimes::default(), ..track }).collect()
        };
        prop_assert_eq!(plain(live), plain(repeated.0));
    }
}

#[test]
fn a_detection_that_comes_too_long_after_newer_ones_is_not_selected() {
    let late = |keys: &str| {
        let mut tracking = tracker(keys);
        let mut made = Samples::default();
        fly(&mut tracking, 0..5, &mut made);
        // Both belong to the scan at hand: one is three seconds older than the newest, the other one.
        for time_s in [23.2, 20.2, 22.2] {
            tracking.take(seen(time_s), 0, &mut made);
        }
        tracking.end(&mut made);
        let mut counters = Counters::default();
        counters[Counter::Reports] = 8;
        tracking.count(&mut counters);
        let times = made
            .detections
            .iter()
            .map(|each| each.time_of_measurement_ns / (S / 10));
        (
            times.skip(5).collect::<Vec<_>>(),
            counters[Counter::DetectionsRejected],
            counters[Counter::Reports],
        )
    };
    assert_eq!(late(""), (vec![202, 222, 232], 0, 8));
    assert_eq!(
        late("[source.tracker.selection]\nage_max_s = 2.0"),
        (vec![222, 232], 1, 7)
    );
    let kept = late("[source.tracker.selection]\nage_max_s = 2.0\nkept_weight = 0.5");
    assert_eq!(
        kept,
        (vec![202, 222, 232], 0, 8),
        "used with less weight, so not refused"
    );
}

/// What was published as one table: `koseki track` reads the detections, and the scans without any.
fn tracks_of_the_table(made: &Samples) -> Vec<SensorTrack> {
    let settings = settings("");
    let events = made.detections.iter().filter_map(SensorEvent::of_sample);
    let (mut detections, mut silent) = (Vec::new(), Vec::new());
    for event in events {
        match event {
            SensorEvent::Detection(detection) => detections.push(detection),
            SensorEvent::EmptyScan { number, time_ns } => silent.push((1, number, time_ns)),
            mark => panic!("{mark:?}"),
        }
    }
    let mut again = ScanTracker::new(settings.settings, settings.outputs, Arrivals::new(), Vec::new()).unwrap();
    let mut repeated = Repeated::default();
    for scan in scans_of(&mut detections, &silent) {
        let detections = &detections[scan.detections.clone()];
        let scan = SensorScan {
            sensor_id: 1,
            number: scan.number,
            time_ns: scan.time_ns,
            detections,
        };
        again.scan(&scan, None, &mut repeated);
    }
    repeated.0
}

fn plain(tracks: &[SensorTrack]) -> Vec<SensorTrack> {
    let plain = |track: &SensorTrack| SensorTrack {
        stages: StageTimes::default(),
        ..*track
    };
    tracks.iter().map(plain).collect()
}

#[test]
fn a_silent_radars_tracks_coast_and_end_by_its_marks_of_time() {
    let mut tracking = tracker("");
    let mut made = Samples::default();
    fly(&mut tracking, 0..20, &mut made);
    let by_data = made.tracks.len();
    let mut times = Vec::new();
    for turn in 20..60 {
        tracking.passed(i64::from(turn) * 4 * S, true, 0, &mut made);
        let new = made.tracks[by_data + times.len()..]
            .iter()
            .map(|track| track.time_of_measurement_ns);
        times.extend(new.collect::<Vec<_>>());
    }
    // A turn is over at its end and the wait: 4.4 s after its time. The track lives for some turns, and ends.
    let expected: Vec<i64> = (1..=times.len() as i64)
        .map(|turn| LAST_NS - 4 * S + 4 * S * turn)
        .collect();
    assert_eq!(times, expected);
    assert!((3..20).contains(&times.len()), "{}", times.len());
    // It comes back, as late as its first turn that is not known to be empty.
    fly(&mut tracking, 59..70, &mut made);
    tracking.end(&mut made);
    assert!(made.tracks.last().unwrap().time_of_measurement_ns > 270 * S);
    assert_eq!(plain(&made.tracks), plain(&tracks_of_the_table(&made)));
}

#[test]
fn a_silent_sensors_scans_go_on_by_the_clock() {
    let mut tracking = tracker("");
    let mut made = Samples::default();
    for scan in 0..20 {
        let time_s = 4.0 * f64::from(scan) + 1.2;
        tracking.take(seen(time_s), (time_s * 1e9) as i64, &mut made);
    }
    let by_data = made.tracks.len();
    let mut clock = |tracking: &mut DetectionTracker, until_s: i64| {
        (78..until_s).for_each(|mono_s| tracking.silent(mono_s * S, Some(50 * S), &mut made));
        (made.tracks.len() - by_data, made.detections.len())
    };
    // The last scan is complete when the clock has come two periods and two waits beyond it; each period is one more.
    assert_eq!(clock(&mut tracking, 88), (0, 19));
    let (tracks, events) = clock(&mut tracking, 140);
    assert!((3..12).contains(&tracks), "{tracks}");
    assert!((26..34).contains(&events), "{events}");
    assert_eq!(clock(&mut tracking, 900), (tracks, events), "the sensor counts as dead");
    assert_eq!(plain(&made.tracks), plain(&tracks_of_the_table(&made)));
}

proptest! {
    /// Whenever marks and detections come, and whenever the clock is read, the table gives the same tracks.
    #[test]
    fn the_table_of_a_silent_sensor_gives_the_same_tracks_again(
        steps in prop::collection::vec((0u32..6, 0.0..6.0f64, -3.0..0.5f64), 40..120),
    ) {
        let mut tracking = tracker("");
        let (mut time_s, mut made) = (0.0, Samples::default());
        for (what, step_s, late_s) in steps {
            time_s += step_s;
            let now_ns = (time_s * 1e9) as i64;
            match what {
                0 => tracking.silent(now_ns, None, &mut made),
                1 => tracking.passed(now_ns, true, now_ns, &mut made),
                2 => tracking.passed(now_ns, false, now_ns, &mut made),
                3 => tracking.take(seen(time_s + late_s.min(0.0)), now_ns, &mut made),
                _ => tracking.take(seen(time_s), now_ns, &mut made),
            }
        }
        tracking.end(&mut made);
        prop_assert_eq!(plain(&made.tracks), plain(&tracks_of_the_table(&made)));
    }
}

#[test]
fn the_tracks_of_a_tracker_on_board_state_where_its_platform_is() {
    for (axes, heading_rad) in [
        (None, 0.0),
        (Some(PlatformAxes::North), 0.0),
        (Some(PlatformAxes::Hull), 0.5),
    ] {
        let settings = TrackerSettings {
            platform: axes,
            ..settings("")
        };
        let mut tracking = DetectionTracker::new(0, &settings, 0, Arrivals::new()).unwrap();
        let mut made = Samples::default();
        for scan in 0..10 {
            let time_s = 4.0 * f64::from(scan) + 1.2;
            let mut detection = seen(time_s);
            detection.platform_m = [10.0 * time_s, 700.0, 15.0];
            // A camera among the sensors may state no attitude.
            detection.platform.attitude_rad = (scan % 2 == 0).then_some([0.5, 0.1, 0.0]);
            tracking.take(detection, 0, &mut made);
        }
        assert!(made.tracks.len() > 3);
        for track in &made.tracks {
            assert_eq!(track.has(sensor_track_bits::PLATFORM), axes.is_some());
            if axes.is_some() {
                let time_s = track.time_of_measurement_ns as f64 / 1e9;
                let [east, north, heading] = track.measured_m;
                assert!((east - 10.0 * time_s).abs() < 1e-6 && north == 700.0, "{east} {north}");
                assert_eq!(heading, heading_rad);
            }
        }
    }
}
