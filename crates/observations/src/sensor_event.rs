//! Event of a sensor with detections: a detection, or a mark of the sensor's time.
//!
//! A tracker needs to know how far a sensor has looked, also where the sensor has found nothing. A scan without
//! detections, the beginning of a turn, and the end of the data so far are marks. A mark travels among the detections,
//! so that the order of both is recorded.

use messages::{DetectionMark, SensorDetection, StageTimes, sensor_detection_bits as bits};

use crate::{Detection, Sampled};

/// Event of a sensor with detections. Times are UTC, nanoseconds since 1970.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly all events are detections")]
pub enum SensorEvent {
    /// A detection.
    Detection(Detection),
    /// The sensor's time has come to this time.
    Passed(i64),
    /// A scan has no detections.
    EmptyScan {
        /// Number of the scan at the sensor.
        number: u32,
        /// Time of the scan.
        time_ns: i64,
    },
    /// A turn begins at this time.
    TurnBegins(i64),
    /// A detection of this time was refused: no state of the sensor's platform belongs to it. No mark of time.
    Unplaced(i64),
}

impl SensorEvent {
    /// The event as one of the sensor with this id.
    #[must_use]
    pub fn of_sensor(self, sensor_id: u32) -> Self {
        match self {
            Self::Detection(detection) => Self::Detection(Detection { sensor_id, ..detection }),
            mark => mark,
        }
    }

    /// Time of the event.
    pub fn time_ns(&self) -> i64 {
        match self {
            Self::Detection(detection) => detection.time_of_measurement_ns,
            Self::Passed(time_ns) | Self::EmptyScan { time_ns, .. } => *time_ns,
            Self::TurnBegins(time_ns) | Self::Unplaced(time_ns) => *time_ns,
        }
    }
}

impl Sampled for SensorEvent {
    type Sample = SensorDetection;

    fn sample(&self, source: u16, stages: StageTimes) -> SensorDetection {
        let mark = |kind: DetectionMark, scan, time_ns| SensorDetection {
            time_of_measurement_ns: time_ns,
            stages,
            scan,
            source,
            kind: kind.code(),
            valid: bits::MARK,
            ..SensorDetection::default()
        };
        match *self {
            Self::Detection(detection) => detection.sample(source, stages),
            Self::Passed(time_ns) => mark(DetectionMark::Passed, 0, time_ns),
            Self::EmptyScan { number, time_ns } => mark(DetectionMark::EmptyScan, number, time_ns),
            Self::TurnBegins(time_ns) => mark(DetectionMark::TurnBegins, 0, time_ns),
            Self::Unplaced(time_ns) => mark(DetectionMark::Unplaced, 0, time_ns),
        }
    }

    fn of_sample(sample: &SensorDetection) -> Option<Self> {
        if sample.valid & bits::MARK == 0 {
            return Detection::of_sample(sample).map(Self::Detection);
        }
        let time_ns = sample.time_of_measurement_ns;
        Some(match DetectionMark::from_code(sample.kind)? {
            DetectionMark::Passed => Self::Passed(time_ns),
            DetectionMark::EmptyScan => Self::EmptyScan {
                number: sample.scan,
                time_ns,
            },
            DetectionMark::TurnBegins => Self::TurnBegins(time_ns),
            DetectionMark::Unplaced => Self::Unplaced(time_ns),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_holds_a_mark_and_a_mark_is_no_detection() {
        let marks = [
            SensorEvent::Passed(5),
            SensorEvent::EmptyScan { number: 7, time_ns: 6 },
            SensorEvent::TurnBegins(8),
            SensorEvent::Unplaced(9),
        ];
        for mark in marks {
            let sample = mark.sample(3, StageTimes::default());
            assert_eq!(SensorEvent::of_sample(&sample), Some(mark));
            assert_eq!((sample.source, sample.time_of_measurement_ns), (3, mark.time_ns()));
            assert_eq!(Detection::of_sample(&sample), None);
        }
        let unknown = SensorDetection {
            valid: bits::MARK,
            kind: 9,
            ..SensorDetection::default()
        };
        assert_eq!(SensorEvent::of_sample(&unknown), None);
    }
}
