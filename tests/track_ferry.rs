//! Two boats in a harbour, seen from a ferry by lidar, radar and two cameras: all sensors into one tracker (HT-12).
//!
//! `koseki track` reads the recordings as they are, with `examples/autoferry.toml`. What is judged are its pictures at
//! whole seconds.
//!
//! A target is *visible* at a second if within the five seconds before it some sensor that measures positions had a
//! detection within 20 m of it in at least half of its scans, and in two at least; before that nobody could know of it.
//! It is *tracked* if a confirmed track lies within 20 m of it, one track for each target at most (GOSPA's pairs).
//!
//! `--nocapture` prints the table of docs/tracking.md.

use std::collections::BTreeMap;

use formats::autoferry::{self, FerryScan, FerrySensor};
use frames::time::NS_PER_DAY;
use scoring::gospa::Metric;
use serde_json::{Value, json};
use test_support::{numbers, recording};

use crate::common::{Folder, S, repository};

const METRIC: Metric = Metric {
    cut_off_m: 20.0,
    power: 2,
};
const SCENARIOS: [u32; 4] = [2, 3, 13, 16];
const POSITIONS: [FerrySensor; 2] = [FerrySensor::Lidar, FerrySensor::Radar];

/// The detections as they are in the file, and with the truth beside them.
fn scenario(number: u32) -> Option<(Value, Vec<FerryScan>)> {
    let file = |kind: &str| format!("autoferry/scenario{number}/scenario{number}_{kind}.json");
    let (detections, truth) = (recording(&file("detections"))?, recording(&file("groundTruth"))?);
    let scans = autoferry::read(&detections, &truth).unwrap();
    Some((serde_json::from_slice(&detections).unwrap(), scans))
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
    fn of(scans: &[FerryScan]) -> Self {
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
fn is_visible(scans: &[&FerryScan], truth: &Truth, target: usize, time_ns: i64) -> bool {
    POSITIONS.iter().any(|sensor| {
        let recent = |scan: &&&FerryScan| {
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

/// Pictures that `koseki track` makes of the scans of some sensors: east and north of each track by whole second.
fn pictures(folder: &Folder, json: &Value, sensors: &[FerrySensor]) -> BTreeMap<i64, Vec<[f64; 2]>> {
    let own = |entry: &&Value| sensors.iter().any(|sensor| entry["sensorID"] == sensor.id());
    let of_sensors: Vec<&Value> = json.as_array().unwrap().iter().filter(own).collect();
    folder.write("detections.json", serde_json::to_vec(&of_sensors).unwrap());
    let config = repository("examples/autoferry.toml");
    let said = folder.json(&format!(
        "track --detections detections.json --config {} --period 1 --out tracks.csv --json",
        config.display()
    ));
    // Those before the first detection count, too.
    assert_eq!(said["scans"], of_sensors.len(), "{said}");
    assert_eq!(said["refused_scans"], json!({}), "{said}");
    let table = folder.read("tracks.csv");
    let [times, east, north] = ["time_s", "x", "y"].map(|name| numbers(&table, name));
    let mut pictures: BTreeMap<i64, Vec<[f64; 2]>> = BTreeMap::new();
    for ((time_s, east), north) in times.into_iter().zip(east).zip(north) {
        pictures.entry(time_s as i64).or_default().push([east, north]);
    }
    pictures
}

fn run(scans: &[FerryScan], sensors: &[FerrySensor], pictures: &BTreeMap<i64, Vec<[f64; 2]>>) -> Figures {
    let truth = Truth::of(scans);
    let times = scans.iter().map(|scan| scan.time_of_measurement_ns);
    let (begin_ns, end_ns) = (times.clone().min().unwrap(), times.max().unwrap());
    let midnight_ns = begin_ns.div_euclid(NS_PER_DAY) * NS_PER_DAY;
    let used: Vec<&FerryScan> = scans.iter().filter(|scan| sensors.contains(&scan.sensor)).collect();
    let mut figures = Figures::default();
    for second in (begin_ns - midnight_ns) / S + 1..=(end_ns - midnight_ns) / S {
        let shown = pictures.get(&second).map_or(&[][..], Vec::as_slice);
        figures.add(shown, &used, &truth, midnight_ns + second * S);
    }
    for sum in [&mut figures.gospa_m, &mut figures.missed_m, &mut figures.false_m] {
        *sum /= f64::from(figures.seconds);
    }
    figures
}

impl Figures {
    fn add(&mut self, shown: &[[f64; 2]], scans: &[&FerryScan], truth: &Truth, time_ns: i64) {
        let targets = [0, 1].map(|target| truth.at(target, time_ns));
        let apart = METRIC.compare(&targets, shown);
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

const ALL: [FerrySensor; 4] = FerrySensor::ALL;
const COMBINATIONS: [&[FerrySensor]; 7] = [
    &[FerrySensor::Lidar],
    &[FerrySensor::Radar],
    &[FerrySensor::Lidar, FerrySensor::Radar],
    &[FerrySensor::Radar, FerrySensor::InfraredCamera, FerrySensor::Camera],
    &[FerrySensor::Lidar, FerrySensor::Radar, FerrySensor::InfraredCamera],
    &[FerrySensor::Lidar, FerrySensor::Radar, FerrySensor::Camera],
    &ALL,
];

/// Least share of its visible time for which a target must be tracked.
const SHARE_MIN: f64 = 0.9;

#[test]
fn both_targets_are_tracked_while_they_are_visible() {
    let folder = Folder::new();
    for number in SCENARIOS {
        let Some((json, scans)) = scenario(number) else { return };
        let figures_of = |sensors: &[FerrySensor]| run(&scans, sensors, &pictures(&folder, &json, sensors));
        let positions = figures_of(&POSITIONS);
        for sensors in COMBINATIONS {
            let figures = figures_of(sensors);
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
