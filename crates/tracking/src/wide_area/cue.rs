//! Search regions for the sensors' next looks (WA-12).
//!
//! Before its next look, a steerable sensor needs the expected position of each target and the size of the search
//! region. The tracker holds both: the state predicted to the time of the look, and the gate for detections (HT-2).
//! A cue combines them in the plane: an ellipse around the predicted position.

use messages::{AXES, StageTimes};
use observations::{Detection, Sampled, sensor_id};

use crate::gate::gates;
use crate::measurement::DetectionMeasurement;
use crate::motion::MotionSettings;
use crate::track_report::TrackReport;

/// Search region for a track, and the time of the look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cue {
    /// The sensor that is to look.
    pub sensor_id: u32,
    /// The track's number.
    pub track_number: u32,
    /// Time of the look, nanoseconds.
    pub time_ns: i64,
    /// Predicted position east, north, up, metres.
    pub position_m: [f64; AXES],
    /// Predicted velocity, metres per second.
    pub velocity_mps: [f64; AXES],
    /// Longer and shorter half axis of the search region, metres.
    pub half_axes_m: [f64; 2],
    /// Direction of the longer axis, clockwise from north, radians in [0, π).
    pub orientation_rad: f64,
}

impl Sampled for Cue {
    type Sample = messages::Cue;

    fn sample(&self, source: u16, stages: StageTimes) -> messages::Cue {
        messages::Cue {
            time_ns: self.time_ns,
            stages,
            position_m: self.position_m,
            velocity_mps: self.velocity_mps,
            half_axes_m: self.half_axes_m,
            orientation_rad: self.orientation_rad,
            track_number: self.track_number,
            source,
            ..messages::Cue::default()
        }
    }

    fn of_sample(sample: &messages::Cue) -> Option<Self> {
        Some(Self {
            sensor_id: sensor_id(sample.source),
            track_number: sample.track_number,
            time_ns: sample.time_ns,
            position_m: sample.position_m,
            velocity_mps: sample.velocity_mps,
            half_axes_m: sample.half_axes_m,
            orientation_rad: sample.orientation_rad,
        })
    }
}

/// Times of the sensors' next looks: a period after the last look of each, or as many periods as a silent sensor has
/// let pass.
#[derive(Clone, Debug, Default)]
pub struct LookTimes {
    /// (sensor, last time, period), nanoseconds.
    sensors: Vec<(u32, i64, Option<i64>)>,
}

impl LookTimes {
    /// For these sensors.
    pub fn of(sensors: impl Iterator<Item = u32>) -> Self {
        Self {
            sensors: sensors.map(|sensor| (sensor, i64::MIN, None)).collect(),
        }
    }

    /// Learns that a sensor has looked.
    pub fn saw(&mut self, sensor_id: u32, time_ns: i64) {
        let Some((_, last_ns, period_ns)) = self.sensors.iter_mut().find(|(sensor, ..)| *sensor == sensor_id) else {
            return;
        };
        if *last_ns == i64::MIN {
            *last_ns = time_ns;
        } else if time_ns > *last_ns {
            *period_ns = Some(time_ns.saturating_sub(*last_ns));
            *last_ns = time_ns;
        }
    }

    /// Pairs (sensor, time of the first look after `now_ns` in nanoseconds) for the sensors with a known period.
    pub fn next(&self, now_ns: i64) -> impl Iterator<Item = (u32, i64)> + '_ {
        let next = move |(sensor, last_ns, period_ns): &(u32, i64, Option<i64>)| {
            let period_ns = (*period_ns)?;
            let passed = now_ns.saturating_sub(*last_ns).max(0) / period_ns;
            let after_ns = period_ns.saturating_mul(passed.saturating_add(1));
            Some((*sensor, last_ns.saturating_add(after_ns)))
        };
        self.sensors.iter().filter_map(next)
    }
}

/// Mean of the largest standard deviations of detections' places, metres, where `sigmas` are for detections that state
/// none. `None` if no detection has a place: directions alone do not.
pub fn sigma_m(detections: &[Detection], sigmas: Option<[f64; 4]>) -> Option<f64> {
    let places = detections
        .iter()
        .filter_map(|detection| DetectionMeasurement::of(detection, sigmas)?.place());
    let (sum_m, count) = places.fold((0.0, 0.0), |(sum_m, count), (_, sigma_m)| {
        (sum_m + sigma_m, count + 1.0)
    });
    (count > 0.0).then_some(sum_m / count)
}

/// Makes a cue at `time_ns` for `sensor_id` with a standard deviation of detections of `sigma_m` in any direction.
pub(crate) fn cue(
    track: &TrackReport,
    (sensor_id, time_ns): (u32, i64),
    sigma_m: f64,
    gate_probability: f64,
    motion: &MotionSettings,
) -> Cue {
    // Wide enough for a manoeuvring target.
    let noise = motion
        .manoeuvres()
        .map_or(motion.process_noise_m2ps3, |turning| turning.process_noise_m2ps3);
    let moved = track.moved_to(time_ns, noise);
    let [xx, xy, _, yy, ..] = moved.estimate.position_covariance();
    let (xx, yy) = (xx + sigma_m * sigma_m, yy + sigma_m * sigma_m);
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let apart = half.hypot(xy);
    let gate = gates(gate_probability)[1];
    let axis = |variance: f64| (gate * variance.max(0.0)).sqrt();
    // Counter-clockwise from east, then as a bearing.
    let turned = 0.5 * xy.atan2(half);
    Cue {
        sensor_id,
        track_number: track.number,
        time_ns,
        position_m: moved.estimate.position_m(),
        velocity_mps: moved.estimate.velocity_mps(),
        half_axes_m: [axis(mean + apart), axis(mean - apart)],
        orientation_rad: (std::f64::consts::FRAC_PI_2 - turned).rem_euclid(std::f64::consts::PI),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_looks_again_after_a_period_and_a_silent_one_at_its_next_turn() {
        let mut looks = LookTimes::of([1, 2, 3].into_iter());
        for (sensor_id, time_ns) in [(1, 0), (2, 1), (3, 2), (1, 4), (2, 11), (1, 8), (7, 9)] {
            looks.saw(sensor_id, time_ns);
        }
        let next = |now_ns| looks.next(now_ns).collect::<Vec<_>>();
        assert_eq!(next(8), [(1, 12), (2, 21)], "sensor 3 has shown no period yet");
        assert_eq!(next(12), [(1, 16), (2, 21)]);
        assert_eq!(next(31), [(1, 32), (2, 41)]);
        assert_eq!(next(i64::MIN), [(1, 12), (2, 21)]);
        assert!(next(i64::MAX).iter().all(|(_, time_ns)| *time_ns > i64::MAX - 11));
    }
}
