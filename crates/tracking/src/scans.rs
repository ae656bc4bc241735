//! Rows of detections made into scans, for inputs that have no scans of their own.
//!
//! A file of detections is a list; what the tracker needs is what each sensor saw each time, and when it saw nothing at
//! all. Detections of one sensor with the same scan number are a scan, at the time of its latest one. Numbers that are
//! left out are scans without detections, evenly spaced between their neighbours: each of them is a miss for every track.
//! Before the first scan with a detection and after the last one nothing is known.

use std::ops::Range;

use observations::Detection;

/// Most scans without detections that are filled in between two: a longer gap is a pause of the sensor, or a number that
/// means something else.
pub const SILENT_SCANS_MAX: u32 = 100;

/// One sensor's scan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScanOfDetections {
    /// The sensor.
    pub sensor_id: u32,
    /// Time of its latest detection, nanoseconds; of a scan without any, between its neighbours.
    pub time_ns: i64,
    /// Its detections' places in the sorted list.
    pub detections: Range<usize>,
}

/// Sorts `detections` by sensors, scans, times and numbers, so that their order does not matter, and returns the scans in order of time, then of sensors.
pub fn scans_of(detections: &mut [Detection]) -> Vec<ScanOfDetections> {
    detections.sort_by_key(|detection| {
        let Detection { sensor_id, scan, .. } = *detection;
        (
            sensor_id,
            scan,
            detection.time_of_measurement_ns,
            detection.detection_id,
        )
    });
    let mut scans: Vec<ScanOfDetections> = Vec::new();
    let (mut begin, mut before) = (0, None);
    for same in detections.chunk_by(|one, other| (one.sensor_id, one.scan) == (other.sensor_id, other.scan)) {
        let (first, last) = (&same[0], &same[same.len() - 1]);
        let (sensor_id, scan, time_ns) = (first.sensor_id, first.scan, last.time_of_measurement_ns);
        if let Some((sensor_before, scan_before, time_before)) = before
            && sensor_before == sensor_id
        {
            scans.extend(silent(sensor_id, (scan_before, time_before), (scan, time_ns), begin));
        }
        before = Some((sensor_id, scan, time_ns));
        scans.push(ScanOfDetections {
            sensor_id,
            time_ns,
            detections: begin..begin + same.len(),
        });
        begin += same.len();
    }
    scans.sort_by_key(|scan| (scan.time_ns, scan.sensor_id));
    scans
}

/// The scans between two of the same sensor.
fn silent(
    sensor_id: u32,
    before: (u32, i64),
    after: (u32, i64),
    place: usize,
) -> impl Iterator<Item = ScanOfDetections> {
    silent_times_ns(before, after).map(move |time_ns| ScanOfDetections {
        sensor_id,
        time_ns,
        detections: place..place,
    })
}

/// Times of the scans without detections between two of a sensor that follow each other: (number, time in nanoseconds).
pub fn silent_times_ns(
    (scan_before, time_before): (u32, i64),
    (scan, time_ns): (u32, i64),
) -> impl Iterator<Item = i64> {
    let gap = scan.saturating_sub(scan_before);
    let step_ns = time_ns.saturating_sub(time_before) / i64::from(gap.max(1));
    let missing = if gap <= SILENT_SCANS_MAX + 1 { 1..gap } else { 1..1 };
    missing.map(move |number| time_before.saturating_add(step_ns.saturating_mul(i64::from(number))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{S, position};

    fn detection(sensor_id: u32, scan: u32, time_ns: i64) -> Detection {
        Detection {
            sensor_id,
            scan,
            ..position(time_ns, 0.0, 0.0)
        }
    }

    #[test]
    fn detections_become_scans_and_gaps_silence() {
        let mut detections = [
            detection(2, 7, 3 * S),
            detection(1, 4, 9 * S),
            detection(1, 1, 2 * S),
            detection(1, 1, 3 * S),
            detection(2, 200, 4 * S),
        ];
        let found: Vec<_> = scans_of(&mut detections)
            .into_iter()
            .map(|scan| (scan.time_ns / S, scan.sensor_id, scan.detections))
            .collect();
        let expected = [
            (3, 1, 0..2),
            (3, 2, 3..4),
            (4, 2, 4..5),
            (5, 1, 2..2),
            (7, 1, 2..2),
            (9, 1, 2..3),
        ];
        assert_eq!(found, expected);
        assert_eq!(detections[2].scan, 4);
        assert_eq!(scans_of(&mut []), []);
    }

    #[test]
    fn times_that_cannot_be_do_not_overflow() {
        let mut detections = [
            detection(1, 0, i64::MAX),
            detection(1, 50, i64::MIN),
            detection(1, u32::MAX, 0),
        ];
        assert_eq!(scans_of(&mut detections).len(), 3 + 49);
    }
}
