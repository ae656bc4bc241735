//! Gross biases: reports without a bias, and the bias that would make two tracks coincide.

use estimation::length;
use fusion_settings::CorrectionTable;
use messages::{AXES, BiasKind, Covariance, NS_PER_S, SensorTrack, sensor_track_bits};
use serde::{Deserialize, Serialize};

/// Horizontal position and velocity, and the position of the sensor, if known; metres and metres per second.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct TrackMotion {
    /// East and north.
    pub position_m: [f64; 2],
    /// East and north.
    pub velocity_mps: [f64; 2],
    /// Place of the sensor, east and north.
    pub place_m: Option<[f64; 2]>,
}

impl TrackMotion {
    /// The motion without an error of the source; unchanged if the error needs an unknown place.
    pub fn without(mut self, kind: BiasKind, value: [f64; 2]) -> Self {
        let ([x, y], [vx, vy]) = (self.position_m, self.velocity_mps);
        match (kind, self.place_m) {
            (BiasKind::Azimuth, Some([east, north])) => {
                let (sin, cos) = value[0].sin_cos();
                let turned = |dx: f64, dy: f64| [dx * cos - dy * sin, dx * sin + dy * cos];
                let [dx, dy] = turned(x - east, y - north);
                self.position_m = [east + dx, north + dy];
                self.velocity_mps = turned(vx, vy);
            }
            (BiasKind::Range, Some([east, north])) => {
                let (dx, dy) = (x - east, y - north);
                let range = length([dx, dy]).max(1.0);
                let shorter = 1.0 - value[0] / range;
                self.position_m = [east + dx * shorter, north + dy * shorter];
            }
            (BiasKind::Time, _) => self.position_m = [x + vx * value[0], y + vy * value[0]],
            (BiasKind::Position, _) => self.position_m = [x - value[0], y - value[1]],
            (BiasKind::Azimuth | BiasKind::Range, None) => {}
        }
        self
    }

    /// Returns the bias of this kind that would move the target of `other` here, if possible; `sigma` is the
    /// deviation of two tracks of a target without a bias.
    pub fn implied(&self, other: &Self, kind: BiasKind, sigma: Sigma) -> Option<[f64; 2]> {
        const SIGMAS: f64 = 3.0;
        let apart = [0, 1].map(|axis| self.position_m[axis] - other.position_m[axis]);
        match kind {
            BiasKind::Position => Some(apart),
            BiasKind::Time => {
                let velocity = [0, 1].map(|axis| 0.5 * (self.velocity_mps[axis] + other.velocity_mps[axis]));
                let speed = length(velocity);
                let along = (apart[0] * velocity[0] + apart[1] * velocity[1]) / speed;
                let across = (apart[0] * velocity[1] - apart[1] * velocity[0]) / speed;
                let error = [-along / speed, 0.0];
                (across.abs() <= SIGMAS * sigma.without(kind, error).position_m).then_some(error)
            }
            BiasKind::Azimuth | BiasKind::Range => {
                let [east, north] = self.place_m?;
                let polar = |of: &Self| {
                    let (dx, dy) = (of.position_m[0] - east, of.position_m[1] - north);
                    (length([dx, dy]), dx.atan2(dy))
                };
                let ((own_m, own), (range_m, azimuth)) = (polar(self), polar(other));
                let turn = (own - azimuth + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU);
                let (longer_m, turned) = (own_m - range_m, turn - std::f64::consts::PI);
                let (error, rest_m) = match kind {
                    BiasKind::Azimuth => (turned, longer_m),
                    _ => (longer_m, turned * range_m),
                };
                (rest_m.abs() <= SIGMAS * sigma.position_m).then_some([error, 0.0])
            }
        }
    }
}

/// Deviations per axis of the difference of two motions, metres and metres per second.
#[derive(Clone, Copy, Debug)]
pub struct Sigma {
    /// Of a position.
    pub position_m: f64,
    /// Of a velocity.
    pub velocity_mps: f64,
}

impl Sigma {
    /// Returns the deviations after removal of the bias from either motion; a report moved along its velocity has an
    /// additional error of the velocity.
    pub fn without(mut self, kind: BiasKind, value: [f64; 2]) -> Self {
        if kind == BiasKind::Time {
            self.position_m = length([self.position_m, self.velocity_mps * value[0]]);
        }
        self
    }
}

/// Returns a report without its source's gross bias, at `now_ns`. A corrected time may be the present time; if
/// reports come in the order of their stated times, the target is extrapolated instead.
#[cold]
pub fn corrected(
    report: &SensorTrack,
    kind: BiasKind,
    value: [f64; 2],
    place_m: Option<[f64; 2]>,
    now_ns: i64,
) -> SensorTrack {
    /// Times so near the present are times of reports, nanoseconds.
    const PRESENT_NS: i64 = 5_000_000_000;
    let mut report = *report;
    if kind == BiasKind::Time {
        let measured_ns = report.time_of_measurement_ns - (value[0] * NS_PER_S) as i64;
        if (measured_ns - now_ns).abs() <= PRESENT_NS {
            report.time_of_measurement_ns = measured_ns;
            report.valid &= !sensor_track_bits::WILD_CLOCK;
            return report;
        }
        let covariance = report.covariance;
        for axis in 0..2 {
            let upper = &mut report.covariance.upper;
            upper[Covariance::index(axis, axis)] += value[0] * value[0] * covariance.get(axis + AXES, axis + AXES);
        }
    }
    let motion = TrackMotion {
        position_m: [report.position_m[0], report.position_m[1]],
        velocity_mps: [report.velocity_mps[0], report.velocity_mps[1]],
        place_m,
    };
    let motion = motion.without(kind, value);
    report.position_m[..2].copy_from_slice(&motion.position_m);
    report.velocity_mps[..2].copy_from_slice(&motion.velocity_mps);
    report
}

/// Returns the report without the biases `known` of a source at `place_m`, at `now_ns`.
#[cold]
pub fn without_biases(
    report: &SensorTrack,
    (known, place_m): (&CorrectionTable, Option<[f64; 2]>),
    now_ns: i64,
) -> SensorTrack {
    let mut unbiased = *report;
    unbiased.position_m[2] -= known.up_m;
    for (kind, value) in known.biases() {
        unbiased = corrected(&unbiased, kind, value, place_m, now_ns);
    }
    unbiased
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGMA: Sigma = Sigma {
        position_m: 50.0,
        velocity_mps: 1.0,
    };

    #[test]
    fn an_error_that_is_implied_brings_the_tracks_together() {
        let target = TrackMotion {
            position_m: [40e3, -25e3],
            velocity_mps: [150.0, 80.0],
            place_m: Some([-10e3, 5e3]),
        };
        let errors = [
            (BiasKind::Azimuth, [0.05, 0.0]),
            (BiasKind::Range, [-700.0, 0.0]),
            (BiasKind::Time, [30.0, 0.0]),
            (BiasKind::Position, [900.0, -300.0]),
        ];
        for (kind, value) in errors {
            // Removal of the contrary error yields this error; but for the length of an arc that is exact.
            let seen = target.without(kind, value.map(|part| -part));
            let implied = seen.implied(&target, kind, SIGMA).unwrap();
            assert!(
                (implied[0] - value[0]).abs() < 1e-6 * value[0].abs(),
                "{kind:?}: {implied:?}"
            );
            let back = seen.without(kind, implied);
            let apart = |axis: usize| back.position_m[axis] - target.position_m[axis];
            assert!(apart(0).hypot(apart(1)) < 1e-3, "{kind:?}");
        }
        let aside = TrackMotion {
            position_m: [40e3 + 800.0, -25e3 - 1500.0],
            ..target
        };
        assert_eq!(aside.implied(&target, BiasKind::Time, SIGMA), None);
    }
}
