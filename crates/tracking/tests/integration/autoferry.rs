//! Two boats in a harbour, seen from a ferry by lidar, radar and two cameras: all sensors into one tracker (HT-12).
//!
//! The settings are the default ones; of the sensors they state what an operator knows. Scans come in the order of
//! recording, in two scenarios up to 0.7 s late.
//!
//! A target is *visible* at a second if within the five seconds before it some sensor that measures positions had a
//! detection within 20 m of it in at least half of its scans, and in two at least; before that nobody could know of it.
//! It is *tracked* if a confirmed track lies within 20 m of it, one track for each target at most (GOSPA's pairs).
//!
//! `--nocapture` prints the table of docs/tracking.md.

use formats::autoferry::{self, Scan, Sensor};
use scoring::gospa::Metric;
use test_support::recording;
use tracking::settings::{Capacity, SensorSettings};
use tracking::{FieldOfView, Settings, Tracker};

const S: i64 = 1_000_000_000;
const METRIC: Metric = Metric {
    cut_off_m: 20.0,
    power: 2,
};
const SCENARIOS: [u32; 4] = [2, 3, 13, 16];
const POSITIONS: [Sensor; 2] = [Sensor::Lidar, Sensor::Radar];

fn scenario(number: u32) -> Option<Vec<Scan>> {
    let read = |kind: &str| recording(&format!("autoferry/scenario{number}/scenario{number}_{kind}.json"));
    Some(autoferry::read(&read("detections")?, &read("groundTruth")?).unwrap())
}

/// What is known of the sensors. Reach: the lidar's by its data sheet, the radar's range scale, and to where the cameras tell
/// a boat from the shore; detection: nearly always by the first two, about every second time by the cameras. Where on a
/// hull of ten metres a reflection comes from is the larger part of the errors, three metres, at sixty metres 0.05 rad.
fn known(sensor: Sensor) -> SensorSettings {
    let (detection_probability, range_m, sigma, resolution_m) = match sensor {
        Sensor::Lidar => (0.9, 100.0, 3.0, Some(15.0)),
        Sensor::Radar => (0.85, 500.0, 5.0, Some(15.0)),
        Sensor::InfraredCamera => (0.4, 150.0, 0.05, None),
        Sensor::Camera => (0.6, 200.0, 0.05, None),
    };
    SensorSettings {
        sensor_id: sensor.id(),
        detection_probability,
        sigmas: Some([sigma, sigma, 0.0, 0.0]),
        field_of_view: Some(FieldOfView {
            range_m: [0.0, range_m],
            sector_rad: None,
            position_m: None,
        }),
        resolution_m,
        ..SensorSettings::default()
    }
}

/// Figures of one scenario with some sensors.
#[derive(Debug, Default)]
struct Figures {
    gospa_m: f64,
    missed_m: f64,
    false_m: f64,
    seconds: u32,
    /// By target: seconds, seconds visible, seconds tracked while visible, seconds tracked.
    targets: [[u32; 4]; 2],
}

impl Figures {
    fn share_of_visible(&self, target: usize) -> f64 {
        let [_, visible, tracked, _] = self.targets[target];
        f64::from(tracked) / f64::from(visible.max(1))
    }

    fn share(&self) -> f64 {
        let sum = |place: usize| self.targets.iter().map(|target| f64::from(target[place])).sum::<f64>();
        sum(3) / sum(0)
    }
}

/// Where the targets were at a time, between the two known positions around it.
struct Truth(Vec<Vec<(i64, [f64; 2])>>);

impl Truth {
    fn of(scans: &[Scan]) -> Self {
        let mut targets = vec![Vec::new(); 2];
        for truth in scans.iter().flat_map(|scan| &scan.truth) {
            let [east, north, _] = truth.position_m;
            targets[truth.target_id as usize - 1].push((truth.time_ns, [east, north]));
        }
        for target in &mut targets {
            target.sort_by_key(|(time_ns, _)| *time_ns);
            target.dedup_by_key(|(time_ns, _)| *time_ns);
        }
        Self(targets)
    }

    fn at(&self, target: usize, time_ns: i64) -> [f64; 2] {
        let known = &self.0[target];
        let after = known.partition_point(|(at, _)| *at < time_ns).clamp(1, known.len() - 1);
        let ((begin, from), (end, to)) = (known[after - 1], known[after]);
        let share = ((time_ns - begin) as f64 / (end - begin) as f64).clamp(0.0, 1.0);
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    }
}

fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// See the header.
fn is_visible(scans: &[&Scan], truth: &Truth, target: usize, time_ns: i64) -> bool {
    POSITIONS.iter().any(|sensor| {
        let recent = |scan: &&&Scan| {
            let age = time_ns - scan.time_of_measurement_ns;
            scan.sensor == *sensor && (0..5 * S).contains(&age)
        };
        let of_sensor = scans.iter().filter(recent);
        let (mut all, mut hits) = (0, 0);
        for scan in of_sensor {
            let at = truth.at(target, scan.time_of_measurement_ns);
            let mut detections = scan.detections.iter();
            all += 1;
            hits +=
                u32::from(detections.any(|found| distance([found.values[0], found.values[1]], at) < METRIC.cut_off_m));
        }
        hits >= 2 && 2 * hits >= all
    })
}

fn run(scans: &[Scan], sensors: &[Sensor]) -> Figures {
    let settings = Settings {
        sensors: sensors.iter().copied().map(known).collect(),
        capacity: Capacity {
            tracks: 2048,
            detections: 128,
            open_scans: 16,
        },
        ..Settings::default()
    };
    let mut tracker = Tracker::new(settings).unwrap();
    let truth = Truth::of(scans);
    let used: Vec<_> = scans.iter().filter(|scan| sensors.contains(&scan.sensor)).collect();
    let begin = scans.iter().map(|scan| scan.time_of_measurement_ns).min().unwrap();
    let mut figures = Figures::default();
    let mut second = 1;
    for scan in &used {
        // What is known a second's end, before anything later has come.
        while begin + second * S < scan.time_of_measurement_ns {
            figures.add(&tracker, &used, &truth, begin + second * S);
            second += 1;
        }
        tracker
            .scan(scan.sensor.id(), scan.time_of_measurement_ns, &scan.detections)
            .unwrap();
    }
    assert_eq!(tracker.counts().refused_scans, 0);
    for sum in [&mut figures.gospa_m, &mut figures.missed_m, &mut figures.false_m] {
        *sum /= f64::from(figures.seconds);
    }
    figures
}

impl Figures {
    fn add(&mut self, tracker: &Tracker, scans: &[&Scan], truth: &Truth, time_ns: i64) {
        let targets = [0, 1].map(|target| truth.at(target, time_ns));
        let shown: Vec<_> = tracker
            .tracks()
            .iter()
            .map(|track| {
                let later_s = (time_ns - track.time_ns) as f64 / S as f64;
                [0, 1].map(|axis| track.estimate.mean[axis] + later_s * track.estimate.mean[axis + 3])
            })
            .collect();
        let apart = METRIC.compare(&targets, &shown);
        self.seconds += 1;
        self.gospa_m += apart.gospa_m();
        self.missed_m += apart.missed_m();
        self.false_m += apart.false_m();
        for target in 0..2 {
            let tracked = u32::from(apart.pairs.iter().any(|pair| pair.target == target));
            let visible = u32::from(is_visible(scans, truth, target, time_ns));
            let more = [1, visible, visible * tracked, tracked];
            for (sum, more) in self.targets[target].iter_mut().zip(more) {
                *sum += more;
            }
        }
    }
}

const ALL: [Sensor; 4] = Sensor::ALL;
const COMBINATIONS: [&[Sensor]; 7] = [
    &[Sensor::Lidar],
    &[Sensor::Radar],
    &[Sensor::Lidar, Sensor::Radar],
    &[Sensor::Radar, Sensor::InfraredCamera, Sensor::Camera],
    &[Sensor::Lidar, Sensor::Radar, Sensor::InfraredCamera],
    &[Sensor::Lidar, Sensor::Radar, Sensor::Camera],
    &ALL,
];

/// Least share of its visible time for which a target must be tracked.
const SHARE_MIN: f64 = 0.9;

#[test]
fn both_targets_are_tracked_while_they_are_visible() {
    for number in SCENARIOS {
        let Some(scans) = scenario(number) else { return };
        let positions = run(&scans, &POSITIONS);
        for sensors in COMBINATIONS {
            let figures = run(&scans, sensors);
            println!(
                "scenario {number}, {sensors:?}: GOSPA {:.1} m (missed {:.1}, false {:.1}); tracked for {:.3} and {:.3} of \
                 {} and {} visible seconds, {:.3} of all",
                figures.gospa_m,
                figures.missed_m,
                figures.false_m,
                figures.share_of_visible(0),
                figures.share_of_visible(1),
                figures.targets[0][1],
                figures.targets[1][1],
                figures.share(),
            );
            if !POSITIONS.iter().all(|sensor| sensors.contains(sensor)) {
                continue;
            }
            for target in 0..2 {
                let share = figures.share_of_visible(target);
                assert!(
                    share >= SHARE_MIN,
                    "scenario {number}, {sensors:?}, target {}: {share}",
                    target + 1
                );
            }
            assert!(
                figures.missed_m < positions.missed_m + 1.0,
                "scenario {number}, {sensors:?}: directions do harm"
            );
        }
    }
}
