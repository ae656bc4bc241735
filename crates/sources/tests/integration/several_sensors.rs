//! What a tracker of several sensors does with counts, priorities, and the clock, live and again (HT-12, WA).

use std::path::Path;

use configuration::Config;
use messages::sensor_detection_bits as bits;
use messages::{Counter, Counters, DetectionMark, SensorDetection, SensorTrack, StageTimes, TrackState};
use observations::{
    Detection, DetectionKind, DetectionPlatform, Sampled as _, SensorEvent, TransponderReply, WideAreaReport,
};
use proptest::prelude::*;
use sources::joining::ScanJoiner;
use sources::{DetectionTracker, Samples, ScanTracker, SensorScan, TrackSink, TrackerSettings};
use test_support::S;
use tracking::TrackReport;
use tracking::wide_area::arrivals::Arrivals;
use tracking::wide_area::cue::Cue;

/// Number of the tracker among the sources; its sensors follow.
const TRACKER: u16 = 0;
/// Keys of sensors without false detections.
const CLEAN: &str = "clutter_density = 1e-10";

/// Settings of a tracker of two sensors, with these keys of the tracker, of both sensors, and of the second sensor.
fn settings(keys: &str, of_both: &str, second: &str) -> TrackerSettings {
    let text = format!(
        "name = \"t\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n\
         [[wide_area_sensor]]\nname = \"remote\"\n[wide_area_sensor.external]\n\
         [[tracker]]\nname = \"ship\"\nwait_s = 0.5\nwide_area_sensors = [\"remote\"]\n{keys}\n\
         [[tracker.sensor]]\nname = \"one\"\n{of_both}\n[tracker.sensor.external]\n\
         [[tracker.sensor]]\nname = \"two\"\n{of_both}\n{second}\n[tracker.sensor.external]\n"
    );
    let config = Config::parse(Path::new("t.toml"), &text, &[]).unwrap();
    config.tracker(TRACKER).unwrap().clone()
}

fn live(settings: &TrackerSettings) -> DetectionTracker {
    DetectionTracker::new(TRACKER, settings, 0, Arrivals::new()).unwrap()
}

/// Detections at these places (east, north) in a scan with this number.
fn scan(number: u32, time_ns: i64, places_m: &[[f64; 2]]) -> Vec<SensorEvent> {
    let detection = |(detection_id, [east, north]): (u32, &[f64; 2])| Detection {
        time_of_measurement_ns: time_ns,
        scan: number,
        detection_id,
        values: [*east, *north, 0.0],
        sensor_id: 0,
        kind: DetectionKind::Position2,
        range_rate_mps: None,
        sigmas: Some([60.0, 60.0, 0.0, 0.0]),
        platform_m: [0.0; 3],
        platform: DetectionPlatform::default(),
        height: None,
        velocity: None,
        reply: TransponderReply::default(),
        truth: None,
    };
    let detections = (0..).zip(places_m).map(detection);
    detections.map(SensorEvent::Detection).collect()
}

/// The tracks that come out of a tracker.
#[derive(Default)]
struct Tracks(Vec<SensorTrack>);

impl TrackSink for Tracks {
    fn tracks(&mut self, tracks: &[TrackReport], extrapolated: bool) {
        self.0.extend(tracks.iter().map(|report| SensorTrack {
            state: match extrapolated {
                true => TrackState::Coasted as u8,
                false => report.state as u8,
            },
            ..report.sensor_track(TRACKER)
        }));
    }

    fn cues(&mut self, _scan_ns: i64, _cues: &[Cue]) {}
}

fn plain(tracks: &[SensorTrack]) -> Vec<SensorTrack> {
    let without = |track: &SensorTrack| SensorTrack {
        stages: StageTimes::default(),
        ..*track
    };
    tracks.iter().map(without).collect()
}

/// Tracks of published events, as `koseki track` makes them of a recording.
fn again(settings: &TrackerSettings, published: &[SensorDetection], reports: Arrivals) -> Vec<SensorTrack> {
    let ids = settings.sensor_ids();
    let mut joiner = ScanJoiner::new(&ids, &settings.joining, 0).unwrap();
    let mut tracker = ScanTracker::new(settings.settings.clone(), settings.outputs, reports, Vec::new()).unwrap();
    let mut tracks = Tracks::default();
    for sample in published {
        let event = SensorEvent::of_sample(sample).unwrap();
        match ids.iter().position(|id| *id == u32::from(sample.source) + 1) {
            Some(sensor) => drop(joiner.take(sensor, &event, 0)),
            None => joiner.clock(event.time_ns()),
        }
        while joiner.next_scan().is_some() {
            tracker.scan(&joiner.released(), None, &mut tracks);
        }
        tracker.show(joiner.shown_ns(), &mut tracks);
    }
    tracks.0
}

/// Whether a published event is a time of the clock.
fn is_of_clock(sample: &SensorDetection) -> bool {
    sample.source == TRACKER && sample.valid & bits::MARK != 0 && sample.kind == DetectionMark::Passed.code()
}

const PICTURES: &str = "output_period_s = 1.0";

/// A target flies east, seen by the sensors in turn, twice a second; data take 0.1 s. Returns the time of the last
/// detection.
fn fly(tracking: &mut DetectionTracker, steps: std::ops::Range<i64>, made: &mut Samples) -> i64 {
    let mut last_ns = 0;
    for step in steps {
        last_ns = step * S / 2 + S / 10;
        let sensor = (step % 2) as usize;
        for event in scan(step as u32, last_ns, &[[100.0 * last_ns as f64 / 1e9, 20e3]]) {
            tracking.event(sensor, &event, last_ns + S / 10, made);
        }
    }
    last_ns
}

#[test]
fn pictures_of_several_sensors_go_on_by_the_clock_while_all_are_silent() {
    let settings = settings(PICTURES, CLEAN, "");
    let mut tracking = live(&settings);
    let mut made = Samples::default();
    // Before the first scan the clock changes nothing.
    tracking.clock(0, &mut made);
    let last_ns = fly(&mut tracking, 0..60, &mut made);
    assert!(!made.detections.iter().any(is_of_clock));
    let by_data = made.tracks.len();
    assert!(by_data > 20);
    made.has_picture = false;
    let mut marks = 0;
    for step in 0..400 {
        // The time of the data is 0.1 s behind the clock.
        let (clock_ns, before) = (last_ns + step * S / 5 + S / 10, made.tracks.len());
        tracking.clock(clock_ns, &mut made);
        let times = made.tracks[before..].iter().map(|track| track.time_of_measurement_ns);
        // A picture is overdue after the wait and a period.
        assert!(times.clone().all(|time_ns| time_ns < clock_ns - S / 10 - S / 2 - S));
        assert_eq!(std::mem::take(&mut made.has_picture), times.count() > 0);
        let now = made.detections.iter().filter(|sample| is_of_clock(sample)).count();
        assert!(now <= marks + 1);
        marks = now;
    }
    // One mark for a picture, no mark without one.
    assert!((75..=80).contains(&marks), "{marks}");
    let times: Vec<i64> = made.tracks.iter().map(|track| track.time_of_measurement_ns).collect();
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] == S), "{times:?}");
    // The scans that waited for other sensors are in the first of these pictures; a target silent for a minute is in
    // none.
    let states = made.tracks[by_data..].iter().map(|track| track.state);
    assert!(states.skip(2).all(|state| state == TrackState::Coasted as u8));
    assert!(((last_ns + 57 * S)..(last_ns + 60 * S)).contains(times.last().unwrap()));
    // The sensors come back.
    let before = made.tracks.len();
    fly(&mut tracking, 240..300, &mut made);
    assert!(made.tracks.len() > before + 10);
    assert_eq!(plain(&made.tracks), again(&settings, &made.detections, Arrivals::new()));
}

#[test]
fn without_pictures_the_clock_of_several_sensors_changes_nothing() {
    let mut tracking = live(&settings("", CLEAN, ""));
    let mut made = Samples::default();
    fly(&mut tracking, 0..20, &mut made);
    let (tracks, events) = (made.tracks.len(), made.detections.len());
    tracking.clock(10_000 * S, &mut made);
    assert_eq!((made.tracks.len(), made.detections.len()), (tracks, events));
}

proptest! {
    /// Whatever comes late, and whenever the clock is read, the published events give the same tracks again.
    #[test]
    fn published_events_give_the_same_pictures_again(
        steps in prop::collection::vec((0usize..3, 0.0..1.5f64, 0.0..2.0f64), 40..120),
    ) {
        let settings = settings(PICTURES, CLEAN, "");
        let mut tracking = live(&settings);
        let (mut now_ns, mut made) = (S, Samples::default());
        for (number, (what, step_s, late_s)) in (0..).zip(steps) {
            now_ns += (1e9 * step_s) as i64;
            let time_ns = now_ns - (1e9 * late_s * late_s * late_s) as i64;
            match what {
                2 => tracking.clock(now_ns, &mut made),
                sensor => for event in scan(number, time_ns, &[[100.0 * time_ns as f64 / 1e9, 20e3]]) {
                    tracking.event(sensor, &event, now_ns, &mut made);
                }
            }
        }
        prop_assert_eq!(plain(&made.tracks), again(&settings, &made.detections, Arrivals::new()));
    }
}

/// Deterministic noise: from -1 to 1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Standard deviation 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() / 2.0
    }
}

/// Two targets 200 m apart; the sensors see them in turn, each every 2 s, and resolve them in one scan of five.
fn pair(seed: u64) -> Vec<(usize, Vec<SensorEvent>)> {
    let mut noise = Noise(seed);
    let scans = 40..200;
    let of_second = |second: i64| {
        let north = 45e3 - 180.0 * second as f64;
        let mut places = match noise.next() < 0.6 {
            true => vec![[0.0, north]],
            false => vec![[-100.0, north], [100.0, north]],
        };
        places.retain(|_| noise.next() < 0.8);
        places
            .iter_mut()
            .flatten()
            .for_each(|value| *value += 60.0 * noise.normal());
        let clutter = (0..5).map(|_| [10e3 * noise.next(), north + 10e3 * noise.next()]);
        places.extend(clutter);
        ((second % 2) as usize, scan(second as u32 / 2, second * S, &places))
    };
    scans.map(of_second).collect()
}

/// Counts of two every 8 s, which arrive 8 s later.
fn counts() -> Vec<WideAreaReport> {
    let report = |second: i64| WideAreaReport {
        position_m: [300.0, 45e3 - 180.0 * second as f64, 0.0],
        velocity_mps: [0.0, -180.0, 0.0],
        time_ns: second * S,
        arrival_ns: (second + 8) * S,
        targets: 2,
        origin_m: None,
    };
    (0..200).step_by(8).map(report).collect()
}

/// Share of the scans from the 60th second on with exactly two tracks near the targets.
fn both_right(tracks: &[SensorTrack]) -> f64 {
    let is_near = |track: &&SensorTrack| {
        let second = track.time_of_measurement_ns as f64 / 1e9;
        track.position_m[0].abs() < 1e3 && (track.position_m[1] - (45e3 - 180.0 * second)).abs() < 1e3
    };
    let right = |second: &i64| {
        // A coasted track has the scan's time, too.
        let at = tracks.iter().filter(|track| track.time_of_measurement_ns == second * S);
        at.filter(is_near).count() == 2
    };
    let seconds = 60..195;
    let all = seconds.clone().count() as f64;
    seconds.filter(right).count() as f64 / all
}

/// Scans in the order of their times, as `koseki track` reads them from tables, with all counts known beforehand.
fn offline(
    settings: &TrackerSettings,
    scans: &[(usize, Vec<SensorEvent>)],
    reports: &[WideAreaReport],
) -> Vec<SensorTrack> {
    let arrivals = Arrivals::of(reports.to_vec());
    let mut tracker = ScanTracker::new(settings.settings.clone(), settings.outputs, arrivals, Vec::new()).unwrap();
    let mut tracks = Tracks::default();
    for (sensor, events) in scans {
        let sensor_id = settings.sensor_ids()[*sensor];
        let detections: Vec<Detection> = events
            .iter()
            .filter_map(|event| match event.of_sensor(sensor_id) {
                SensorEvent::Detection(detection) => Some(detection),
                _ => None,
            })
            .collect();
        let (number, time_ns) = (detections[0].scan, detections[0].time_of_measurement_ns);
        let scan = SensorScan {
            sensor_id,
            number,
            time_ns,
            detections: &detections,
        };
        tracker.scan(&scan, None, &mut tracks);
    }
    tracks.0
}

/// Tracks of the same scans and counts as they come in to a tracker process, out of order within the wait.
fn process(
    settings: &TrackerSettings,
    scans: &[(usize, Vec<SensorEvent>)],
    reports: &[WideAreaReport],
) -> (Vec<SensorTrack>, Counters) {
    let (mut tracking, mut made) = (live(settings), Samples::default());
    let mut reports = reports.iter().peekable();
    for (number, (sensor, events)) in scans.iter().enumerate() {
        let time_ns = events[0].time_ns();
        // A remote sensor's reports arrive by the clock, that is before later scans.
        while let Some(report) = reports.next_if(|report| report.arrival_ns <= time_ns + S / 2) {
            tracking.wide_area(*report);
        }
        for event in events {
            tracking.event(*sensor, event, number as i64, &mut made);
        }
    }
    tracking.end(&mut made);
    let mut counters = Counters::default();
    counters[Counter::Reports] = 1 << 20;
    tracking.count(&mut counters);
    (made.tracks, counters)
}

#[test]
fn counts_are_worth_as_much_live_as_offline() {
    let settings = settings("", "", "");
    let (mut gains, reports) = ([0.0; 2], counts());
    for seed in 0..12 {
        let scans = pair(seed);
        for (gain, reports) in gains.iter_mut().zip([&[][..], &reports]) {
            let (live, counters) = process(&settings, &scans, reports);
            assert_eq!(plain(&live), offline(&settings, &scans, reports), "seed {seed}");
            assert_eq!(
                (counters[Counter::WideAreaLate], counters[Counter::RejectedLate]),
                (0, 0)
            );
            *gain += both_right(&live) / 12.0;
        }
    }
    let [without, with] = gains;
    assert!(with > without + 0.1 && with > 0.6, "{without} {with}");
}

/// Two sensors look at the same times; the second has priority, and wrong places would show at once.
#[test]
fn of_scans_at_the_same_time_the_sensor_with_priority_is_used() {
    let places = |keys: &str| {
        let mut tracking = live(&settings(
            "[tracker.settings.selection]\nsame_time_s = 0.2",
            CLEAN,
            keys,
        ));
        let mut made = Samples::default();
        for second in 1..30_i64 {
            // The second sensor measures a little later, its data come first.
            let places = [[0.0, 20e3], [150.0, 20e3]];
            for (sensor, time_ns) in [(1, second * S + S / 10), (0, second * S)] {
                for event in scan(second as u32, time_ns, &[places[sensor]]) {
                    tracking.event(sensor, &event, 0, &mut made);
                }
            }
        }
        tracking.end(&mut made);
        made.tracks.last().map(|track| track.position_m[0]).unwrap()
    };
    let (equal, second) = (places(""), places("priority = 1"));
    assert!((30.0..130.0).contains(&equal), "{equal}");
    assert!((second - 150.0).abs() < 1.0, "{second}");
}

/// A scan so much older than the newest detection is not selected, and not published.
#[test]
fn detections_of_another_sensor_that_are_too_old_are_not_selected() {
    let keys = "[tracker.settings.capacity]\nopen_scans = 16\n[tracker.settings.selection]\nage_max_s = 2.0";
    let mut tracking = live(&settings(keys, CLEAN, ""));
    let mut made = Samples::default();
    fly(&mut tracking, 0..40, &mut made);
    let before = made.detections.len();
    for (number, time_ns) in [(900, 15 * S), (901, 18 * S)] {
        for event in scan(number, time_ns, &[[100.0, 20e3]]) {
            tracking.event(1, &event, 20 * S, &mut made);
        }
    }
    assert_eq!(made.detections.len(), before + 1);
    let mut counters = Counters::default();
    counters[Counter::Reports] = 1 << 20;
    tracking.count(&mut counters);
    assert_eq!(counters[Counter::DetectionsRejected], 1);
}
