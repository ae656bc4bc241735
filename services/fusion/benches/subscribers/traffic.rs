//! Reports of the bench: targets on a grid, each observed by each source once a second, with noise that fits the stated
//! covariance. The same numbers give the same report in each run.

use messages::{Covariance, SensorTrack, TrackState, sensor_track_bits};
use test_support::S;

/// 2016-05-10.
pub(crate) const START_NS: i64 = 16_931 * 86_400 * S;
/// Standard deviations of the sources' noise: position, metres, and velocity, metres per second.
const SIGMA_M: f64 = 10.0;
const SIGMA_MPS: f64 = 1.0;
/// Targets that turn: distance between the middles of their circles, speed and rate of turn (a rate-one turn).
const CIRCLES_M: f64 = 8_000.0;
const SPEED_MPS: f64 = 80.0;
const TURN_RADPS: f64 = 0.052_36;
/// They climb or descend at this speed, metres per second.
const CLIMB_MPS: f64 = 8.0;
/// Height at the start of targets that have one, metres.
const HEIGHT_M: f64 = 3_000.0;
/// Trackers: noise of their plots along and across the line of sight and in height, metres, and the acceleration that
/// they expect of a target, as a spectral density, m²/s³.
const PLOT_SIGMA_M: [f64; 3] = [15.0, 45.0, 30.0];
const TRACKER_NOISE_M2PS3: f64 = 1.0;
/// The trackers stand on a circle of this radius around the grid.
const TRACKERS_M: f64 = 60_000.0;

/// What the targets do, and what the sources report of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// Straight flight without height; uncorrelated errors and covariances.
    Level,
    /// Circles with changing height; uncorrelated errors and covariances.
    Turning,
    /// Straight and level flight, as a tracker outputs it with its height: full covariances, and errors that last.
    Tracked,
}

impl Kind {
    /// Returns the kind with this name among `words`, else straight flight.
    pub(crate) fn among(words: &[String]) -> Self {
        let named = |name: &str| words.iter().any(|word| word == name);
        match (named("turning"), named("tracked")) {
            (true, _) => Self::Turning,
            (_, true) => Self::Tracked,
            _ => Self::Level,
        }
    }
}

/// Builder of reports.
#[derive(Debug)]
pub(crate) struct Traffic {
    kind: Kind,
    targets: u64,
    trackers: [AxisTracker; 3],
    /// Errors of the trackers' states, along, across and in height: position and velocity, by source and target.
    errors: Vec<[[f64; 2]; 3]>,
}

impl Traffic {
    pub(crate) fn new(kind: Kind, sources: usize, targets: u64) -> Self {
        Self {
            kind,
            targets,
            trackers: PLOT_SIGMA_M.map(AxisTracker::settled),
            errors: vec![[[0.0; 2]; 3]; sources * targets as usize],
        }
    }

    /// Returns the report of `source` on `target` in `scan`; each source reports each target once a scan, in the order
    /// of scans.
    pub(crate) fn report(&mut self, source: u64, target: u64, scan: u64, time_ns: i64) -> SensorTrack {
        let second = (time_ns - START_NS) as f64 / S as f64;
        let mut report = SensorTrack {
            time_of_measurement_ns: time_ns,
            track_number: target as u32,
            valid: sensor_track_bits::VELOCITY,
            position_m: [
                2000.0 * (target % 16) as f64,
                2000.0 * (target / 16) as f64 + 10.0 * second,
                0.0,
            ],
            velocity_mps: [0.0, 10.0, 0.0],
            covariance: Covariance::diagonal([SIGMA_M, SIGMA_M, 100.0], [SIGMA_MPS; 3]),
            state: TrackState::Confirmed as u8,
            ..SensorTrack::default()
        };
        if self.kind == Kind::Turning {
            turn(&mut report, target, second);
        }
        if self.kind == Kind::Tracked {
            self.track(&mut report, source, target, scan);
            return report;
        }
        let axes = if self.kind == Kind::Turning { 3 } else { 2 };
        for axis in 0..axes {
            let noise = |number: usize| noise(source, target, scan, number as u64);
            report.position_m[axis] += report.covariance.get(axis, axis).sqrt() * noise(axis);
            report.velocity_mps[axis] += SIGMA_MPS * noise(3 + axis);
        }
        report
    }

    /// Adds the error of a tracker's state, and its covariance.
    fn track(&mut self, report: &mut SensorTrack, source: u64, target: u64, scan: u64) {
        let errors = &mut self.errors[(source * self.targets + target) as usize];
        let bearing = 2.4 * source as f64;
        let sight = [
            report.position_m[0] - TRACKERS_M * bearing.sin(),
            report.position_m[1] - TRACKERS_M * bearing.cos(),
        ];
        let range_m = sight[0].hypot(sight[1]);
        let [east, north] = sight.map(|length_m| length_m / range_m);
        let axes = [[east, north, 0.0], [-north, east, 0.0], [0.0, 0.0, 1.0]];
        report.valid |= sensor_track_bits::HEIGHT | sensor_track_bits::VERTICAL_RATE;
        report.position_m[2] = HEIGHT_M;
        for (number, axis) in axes.iter().enumerate() {
            let tracker = &self.trackers[number];
            let plot_m = PLOT_SIGMA_M[number] * noise(source, target, scan, number as u64);
            errors[number] = tracker.error_after(errors[number], plot_m);
            for (row, part) in axis.iter().enumerate() {
                report.position_m[row] += part * errors[number][0];
                report.velocity_mps[row] += part * errors[number][1];
            }
        }
        for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
            let sum = |of: fn(&AxisTracker) -> f64| {
                let parts = axes.iter().zip(&self.trackers);
                parts
                    .map(|(axis, tracker)| axis[row] * axis[column] * of(tracker))
                    .sum::<f64>()
            };
            let covariance = &mut report.covariance;
            covariance.set(row, column, sum(|tracker| tracker.position_m2));
            covariance.set(row, 3 + column, sum(|tracker| tracker.both_m2ps));
            covariance.set(3 + row, 3 + column, sum(|tracker| tracker.velocity_m2ps2));
        }
    }
}

/// Puts the target of `report` on its circle.
fn turn(report: &mut SensorTrack, target: u64, second: f64) {
    let (sin, cos) = (TURN_RADPS * second + target as f64).sin_cos();
    let climb_mps = if target.is_multiple_of(2) {
        CLIMB_MPS
    } else {
        -CLIMB_MPS
    };
    let radius_m = SPEED_MPS / TURN_RADPS;
    report.valid |= sensor_track_bits::HEIGHT | sensor_track_bits::VERTICAL_RATE;
    report.position_m = [
        CIRCLES_M * (target % 16) as f64 + radius_m * sin,
        CIRCLES_M * (target / 16) as f64 + radius_m * cos,
        HEIGHT_M + climb_mps * second,
    ];
    report.velocity_mps = [SPEED_MPS * cos, -SPEED_MPS * sin, climb_mps];
    report.covariance = Covariance::diagonal([SIGMA_M, SIGMA_M, 20.0], [SIGMA_MPS; 3]);
}

/// A Kalman filter of one axis with a plot a second, after so many plots that its gain is constant.
#[derive(Clone, Copy, Debug, Default)]
struct AxisTracker {
    position_m2: f64,
    both_m2ps: f64,
    velocity_m2ps2: f64,
    /// Gains of position and velocity.
    gains: [f64; 2],
}

impl AxisTracker {
    fn settled(plot_sigma_m: f64) -> Self {
        let mut tracker = Self {
            position_m2: plot_sigma_m * plot_sigma_m,
            velocity_m2ps2: 100.0,
            ..Self::default()
        };
        for _ in 0..1000 {
            let position =
                tracker.position_m2 + 2.0 * tracker.both_m2ps + tracker.velocity_m2ps2 + TRACKER_NOISE_M2PS3 / 3.0;
            let both = tracker.both_m2ps + tracker.velocity_m2ps2 + TRACKER_NOISE_M2PS3 / 2.0;
            let velocity = tracker.velocity_m2ps2 + TRACKER_NOISE_M2PS3;
            let innovation = position + plot_sigma_m * plot_sigma_m;
            let gains = [position / innovation, both / innovation];
            tracker = Self {
                position_m2: (1.0 - gains[0]) * position,
                both_m2ps: (1.0 - gains[0]) * both,
                velocity_m2ps2: velocity - gains[1] * both,
                gains,
            };
        }
        tracker
    }

    /// The error of the state after a plot that lies `plot_m` from the target.
    fn error_after(&self, [position_m, velocity_mps]: [f64; 2], plot_m: f64) -> [f64; 2] {
        let innovation_m = plot_m - (position_m + velocity_mps);
        [
            position_m + velocity_mps + self.gains[0] * innovation_m,
            velocity_mps + self.gains[1] * innovation_m,
        ]
    }
}

/// Noise of variance 1: the sum of four uniform numbers.
fn noise(source: u64, target: u64, scan: u64, axis: u64) -> f64 {
    let mut word = source << 48 ^ target << 32 ^ scan << 8 ^ axis;
    let mut sum = 0.0;
    for _ in 0..4 {
        // The finaliser of splitmix64.
        word = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (word ^ word >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        sum += (mixed >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
    }
    sum * 3.0_f64.sqrt()
}
