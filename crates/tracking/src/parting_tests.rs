//! Two targets that fly together, mostly seen as one and counted from afar, and part (WA-4, WA-6).

use observations::Detection;

use crate::Tracker;
use crate::settings::{SensorFacts, Settings};
use crate::testing::{S, position};
use crate::track_report::TrackReport;
use crate::wide_area::WideAreaReport;
use crate::wide_area::arrivals::Arrivals;

/// Random numbers (xorshift), the same in every run.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Of variance 1, nearly normal.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Time at which the targets part, seconds.
const PARTING_S: i64 = 100;
const END_S: i64 = 180;

/// Distance of each target from the middle, metres.
fn half_m(second: i64) -> f64 {
    100.0 + 12.5 * (second - PARTING_S).max(0) as f64
}

fn middle_m(second: i64) -> f64 {
    45e3 - 180.0 * second as f64
}

/// Scan of two sensors in turn: 60 m of noise, nine detections in ten; nearer than 400 m, four in five are of both.
fn scan(second: i64, noise: &mut Noise) -> Vec<Detection> {
    let (half, north) = (half_m(second), middle_m(second));
    let merged = half < 200.0 && noise.uniform() < 0.8;
    let places = if merged { vec![0.0] } else { vec![-half, half] };
    let mut seen: Vec<[f64; 2]> = Vec::new();
    for east in places {
        if noise.uniform() < 0.9 {
            seen.push([east + 60.0 * noise.normal(), north + 60.0 * noise.normal()]);
        }
    }
    for _ in 0..5 {
        seen.push([20e3 * (noise.uniform() - 0.5), north + 20e3 * (noise.uniform() - 0.5)]);
    }
    let detection = |[east, north]: [f64; 2]| Detection {
        sigmas: Some([60.0, 60.0, 0.0, 0.0]),
        ..position(second * S, east, north)
    };
    seen.into_iter().map(detection).collect()
}

/// A count of two, observed eight seconds before its arrival.
fn report(second: i64, noise: &mut Noise) -> WideAreaReport {
    WideAreaReport {
        time_ns: second * S,
        arrival_ns: (second + 8) * S,
        position_m: [1000.0 * noise.normal(), middle_m(second) + 1000.0 * noise.normal(), 0.0],
        velocity_mps: [0.0, -180.0, 0.0],
        targets: 2,
        origin_m: None,
    }
}

fn has_track(tracks: &[TrackReport], second: i64, east: f64) -> bool {
    let north = middle_m(second);
    let near = |track: &TrackReport| {
        let [x, y, _] = track.estimate.position_m();
        (x - east).hypot(y - north) < 300.0
    };
    tracks.iter().any(near)
}

/// Shares of the scans in which each target has a track and no third one is near: while the targets are together, and
/// after they have parted.
fn shares(runs: u64, counted: bool) -> [f64; 2] {
    let (mut right, mut all) = ([0.0; 2], [0.0; 2]);
    for run in 0..runs {
        let mut noise = Noise(0x9e37_79b9_7f4a_7c15 ^ ((run + 1) * 0x1234_5679));
        let sensors = [1, 2].map(|sensor_id| SensorFacts {
            sensor_id,
            ..SensorFacts::default()
        });
        let mut tracker = Tracker::new(Settings {
            sensors: sensors.to_vec(),
            ..Settings::default()
        })
        .unwrap();
        let mut reports = Arrivals::new();
        for second in 0..END_S {
            if second % 8 == 0 && counted {
                reports.arrive(report(second, &mut noise));
            }
            reports.give(second * S, &mut tracker, |reason| panic!("{reason}"));
            let detections = scan(second, &mut noise);
            tracker.scan(1 + (second % 2) as u32, second * S, &detections).unwrap();
            let after = usize::from(second > PARTING_S + 20);
            if (second > 30 && second < PARTING_S) || after == 1 {
                let (tracks, half) = (tracker.tracks(), half_m(second));
                let near = [-half, half].map(|east| has_track(tracks, second, east));
                let middle = tracks.iter().filter(|track| {
                    let [x, y, _] = track.estimate.position_m();
                    x.abs() < half + 300.0 && (y - middle_m(second)).abs() < 300.0
                });
                right[after] += f64::from(u8::from(near == [true; 2] && middle.count() == 2));
                all[after] += 1.0;
            }
        }
    }
    [right[0] / all[0], right[1] / all[1]]
}

/// A track that was confirmed early and proved wrong must not stand for the second target for good: counts help while
/// the targets are together, and do no harm after that.
#[test]
fn counts_help_while_targets_are_together_and_do_no_harm_after_they_part() {
    let [without, parted_without] = shares(20, false);
    let [with, parted_with] = shares(20, true);
    assert!(with > without + 0.3, "{without} without counts, {with} with");
    assert!(
        parted_without > 0.9 && parted_with > 0.93,
        "{parted_without} {parted_with}"
    );
}
