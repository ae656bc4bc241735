//! Load of a tracker process: several sensors, paced by the times of their scans.
//!
//! A scan's detections come together at the time of the scan, followed by a mark of the sensor's time. The sensors'
//! scans are evenly staggered. Each event is timed alone. A virtual clock adds up the times: an event begins when it
//! has come and the events before it are done. The latency of a scan counts from the event that ends its wait for other
//! sensors, so an event that had to queue shows. The same simulated seconds on a slow machine give a growing queue, not
//! a longer measurement.
//!
//! Targets fly straight over a disc. A sensor that delivers fewer detections in a scan than there are targets looks at
//! a sector with as many targets; what is missing to its detections is false.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::fmt::Write as _;

use hdrhistogram::Histogram;
use messages::{DetectionKind, DetectionMark, SensorDetection, sensor_detection_bits as bits};

use crate::product::TrackerStage;

/// Radius of the disc, metres, and of its empty middle.
const DISC_M: [f64; 2] = [2e3, 40e3];
/// Slowest and fastest target, metres per second.
const SPEEDS_MPS: [f64; 2] = [50.0, 250.0];
/// Standard deviations of range (metres) and bearing (radians).
const SIGMAS: [f64; 2] = [10.0, 1e-3];
/// Share of the targets in view that a scan shows.
const DETECTED: f64 = 0.9;
/// Standard deviation of `sum of twelve uniform numbers - 6` is 1.
const NORMAL_PARTS: usize = 12;
/// Bounds of the measured times, nanoseconds.
const TIMES_NS: [u64; 2] = [1, 3_600_000_000_000];

/// Load to drive a tracker with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackerLoad {
    /// Sensors, alike but for their sectors.
    pub sensors: usize,
    /// Targets.
    pub targets: usize,
    /// Scans of each sensor per second.
    pub scans_per_s: f64,
    /// Detections in a scan.
    pub detections: usize,
    /// Least share of false detections in a scan.
    pub false_share: f64,
    /// Simulated time before the measurement, seconds.
    pub warm_up_s: f64,
    /// Simulated time of the measurement, seconds.
    pub seconds: f64,
}

/// Times of a load.
#[derive(Clone, Debug)]
pub(crate) struct LoadTimes {
    /// From the event that ends a scan's wait to its tracks, nanoseconds.
    pub(crate) latency: Histogram<u64>,
    /// Time for a scan's own events and the scans that they release, without the queue, nanoseconds.
    pub(crate) work: Histogram<u64>,
    /// Share of the simulated time for which the tracker worked.
    pub(crate) busy: f64,
    /// Longest queue, and the queue at the end: time by which the tracker is behind the data, nanoseconds.
    pub(crate) queue_ns: [i64; 2],
    /// Mean number of tracks after a scan.
    pub(crate) tracks: f64,
}

impl TrackerLoad {
    /// Configuration of a tracker for this load.
    pub(crate) fn config_text(&self) -> String {
        let mut text = "name = \"bench\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n\
                        [[tracker]]\nname = \"all\"\nwait_s = 1.0\n"
            .to_owned();
        for sensor in 0..self.sensors {
            let [from, to] = self.sector(sensor).map(f64::to_degrees);
            let reach = 1.1 * DISC_M[1];
            let sector = match self.share() {
                1.0.. => String::new(),
                _ => format!(", sector_deg = [{from}, {to}]"),
            };
            let _ = writeln!(
                text,
                "[[tracker.sensor]]\nname = \"s{sensor}\"\nfield_of_view = {{ range_m = [0.0, {reach}], \
                 position_m = [0.0, 0.0]{sector} }}\n[tracker.sensor.external]",
            );
        }
        text
    }

    /// Share of the disc that a sensor sees.
    fn share(&self) -> f64 {
        let of_targets = self.detections as f64 * (1.0 - self.false_share);
        of_targets / (DETECTED * self.targets as f64)
    }

    /// First and last bearing of a sensor, radians.
    fn sector(&self, sensor: usize) -> [f64; 2] {
        let width = TAU * self.share().min(1.0);
        let from = TAU * sensor as f64 / self.sensors as f64;
        let to = from + width;
        [from, if to > TAU { to - TAU } else { to }]
    }

    fn sees(&self, sensor: usize, bearing: f64) -> bool {
        let [from, to] = self.sector(sensor);
        (bearing - from).rem_euclid(TAU) < (to - from).rem_euclid(TAU) || self.share() >= 1.0
    }
}

/// Drives the tracker; `now_ns` reads the clock, and `stop` may end the drive.
///
/// # Errors
/// That of `stop`.
pub(crate) fn drive<E>(
    tracker: &mut dyn TrackerStage,
    load: &TrackerLoad,
    start_ns: i64,
    mut now_ns: impl FnMut() -> i64,
    mut stop: impl FnMut() -> Result<(), E>,
) -> Result<LoadTimes, E> {
    let mut traffic = LoadTraffic::new(load);
    let mut times = LoadTimes::new();
    let (warm_up_ns, interval_ns) = (
        (1e9 * load.warm_up_s) as i64,
        1e9 / (load.scans_per_s * load.sensors as f64),
    );
    let end_ns = warm_up_ns + (1e9 * load.seconds) as i64;
    // Times of scans without tracks so far; until when the tracker is busy; how long it worked.
    let (mut waiting, mut free_ns, mut busy_ns, mut tracks) = (VecDeque::new(), 0, 0, 0);
    let mut scan = Vec::with_capacity(load.detections + 1);
    for number in 0.. {
        let came_ns = (number as f64 * interval_ns) as i64;
        if came_ns >= end_ns {
            break;
        }
        stop()?;
        let sensor = number % load.sensors;
        traffic.scan(sensor, (number / load.sensors) as u32, [start_ns, came_ns], &mut scan);
        waiting.push_back(came_ns);
        let is_measured = came_ns >= warm_up_ns;
        free_ns = came_ns.max(free_ns);
        let mut work_ns = 0;
        for event in &scan {
            let begin_ns = now_ns();
            let made = tracker.event(sensor, event);
            let took_ns = now_ns() - begin_ns;
            (free_ns, work_ns) = (free_ns + took_ns, work_ns + took_ns);
            let reached_ns = tracker.progress_ns().saturating_sub(start_ns);
            while waiting.front().is_some_and(|time_ns: &i64| *time_ns <= reached_ns) {
                waiting.pop_front();
                if is_measured {
                    times.latency.saturating_record((free_ns - came_ns) as u64);
                }
            }
            tracks += if is_measured { made } else { 0 };
        }
        if is_measured {
            times.work.saturating_record(work_ns as u64);
            busy_ns += work_ns;
            let behind_ns = free_ns - came_ns - work_ns;
            times.queue_ns = [times.queue_ns[0].max(behind_ns), behind_ns];
        } else {
            // The queue begins with the measurement.
            free_ns = came_ns;
        }
    }
    times.busy = busy_ns as f64 / (end_ns - warm_up_ns) as f64;
    times.tracks = tracks as f64 / times.latency.len().max(1) as f64;
    Ok(times)
}

impl LoadTimes {
    fn new() -> Self {
        let [least, most] = TIMES_NS;
        let histogram = || Histogram::new_with_bounds(least, most, 3).expect("fixed bounds");
        Self {
            latency: histogram(),
            work: histogram(),
            busy: 0.0,
            queue_ns: [0; 2],
            tracks: 0.0,
        }
    }
}

/// Targets and the sensors' detections of them.
struct LoadTraffic<'a> {
    load: &'a TrackerLoad,
    /// East, north (metres), and velocities (metres per second).
    targets: Vec<[f64; 4]>,
    random: Random,
}

impl<'a> LoadTraffic<'a> {
    fn new(load: &'a TrackerLoad) -> Self {
        let mut random = Random(1);
        let targets = (0..load.targets).map(|_| {
            let [range, bearing] = random.place();
            let (course, speed) = (random.between([0.0, TAU]), random.between(SPEEDS_MPS));
            let (sin, cos) = course.sin_cos();
            [range * bearing.sin(), range * bearing.cos(), speed * sin, speed * cos]
        });
        Self {
            targets: targets.collect(),
            load,
            random,
        }
    }

    /// The events of a sensor's scan.
    fn scan(&mut self, sensor: usize, number: u32, [start_ns, at_ns]: [i64; 2], scan: &mut Vec<SensorDetection>) {
        scan.clear();
        let (time_ns, seconds) = (start_ns + at_ns, at_ns as f64 * 1e-9);
        let mut add = |range, bearing: f64| {
            scan.push(SensorDetection {
                time_of_measurement_ns: time_ns,
                scan: number,
                detection_id: scan.len() as u32,
                values: [range, bearing, 0.0],
                sigmas: [SIGMAS[0], SIGMAS[1], 0.0, 0.0],
                kind: DetectionKind::RangeBearing.code(),
                valid: bits::SIGMAS,
                ..SensorDetection::default()
            });
            scan.len()
        };
        let mut made = 0;
        for [east, north, v_east, v_north] in &self.targets {
            let (east, north) = (east + v_east * seconds, north + v_north * seconds);
            let bearing = east.atan2(north);
            if made < self.load.detections && self.load.sees(sensor, bearing) && self.random.next() < DETECTED {
                let noise = [SIGMAS[0] * self.random.normal(), SIGMAS[1] * self.random.normal()];
                made = add(east.hypot(north) + noise[0], bearing + noise[1]);
            }
        }
        while made < self.load.detections {
            let [range, bearing] = self.random.place();
            if self.load.sees(sensor, bearing) {
                made = add(range, bearing);
            }
        }
        scan.push(SensorDetection {
            time_of_measurement_ns: time_ns + 1,
            kind: DetectionMark::Passed.code(),
            valid: bits::MARK,
            ..SensorDetection::default()
        });
    }
}

/// Random numbers, the same in every measurement (SplitMix64).
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.next()
    }

    fn normal(&mut self) -> f64 {
        (0..NORMAL_PARTS).map(|_| self.next()).sum::<f64>() - NORMAL_PARTS as f64 / 2.0
    }

    /// Range and bearing, evenly over the disc.
    fn place(&mut self) -> [f64; 2] {
        let [near, far] = DISC_M.map(|range| range * range);
        [self.between([near, far]).sqrt(), self.between([0.0, TAU])]
    }
}
