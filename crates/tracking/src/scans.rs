//! Makes scans of rows of detections, for inputs without scans.
//!
//! A file of detections is a list; the tracker needs the detections of each look, and also the looks without
//! detections. Detections of one sensor with the same scan number are a scan, at the time of the latest detection.
//! Missing numbers are scans without detections, evenly spaced between the neighbours: each is a miss for every track.
//! No scans are assumed before a sensor's first known scan or after the last; inputs may state scans without detections
//! there.

use std::ops::Range;

use observations::Detection;

/// Most scans without detections that are filled in between two: a longer gap is a pause of the sensor, or a number
/// that means something else.
pub const SILENT_SCANS_MAX: u32 = 100;

/// Scan of a sensor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScanOfDetections {
    /// The sensor.
    pub sensor_id: u32,
    /// Number of the scan at the sensor.
    pub number: u32,
    /// Time of the latest detection, nanoseconds; for an empty scan, a time between the neighbours.
    pub time_ns: i64,
    /// Places of the detections in the sorted list.
    pub detections: Range<usize>,
}

/// Sorts `detections` by sensors, scans, times and numbers, so that the input order does not matter, and returns the
/// scans in order of time, then of sensors. `silent` are scans stated to be without detections: (sensor, number, time
/// in nanoseconds). The statement has no effect if the scan has detections, or after an earlier statement about the
/// same scan.
pub fn scans_of(detections: &mut [Detection], silent: &[(u32, u32, i64)]) -> Vec<ScanOfDetections> {
    detections.sort_by_key(|detection| {
        let Detection { sensor_id, scan, .. } = *detection;
        (
            sensor_id,
            scan,
            detection.time_of_measurement_ns,
            detection.detection_id,
        )
    });
    let mut begin = 0;
    let same_scan = |one: &Detection, other: &Detection| (one.sensor_id, one.scan) == (other.sensor_id, other.scan);
    let seen = detections.chunk_by(same_scan).map(|same| {
        let last = &same[same.len() - 1];
        begin += same.len();
        ScanOfDetections {
            sensor_id: last.sensor_id,
            number: last.scan,
            time_ns: last.time_of_measurement_ns,
            detections: begin - same.len()..begin,
        }
    });
    let mut scans: Vec<ScanOfDetections> = seen.collect();
    let without_detections = |sensor_id, (number, time_ns), place| ScanOfDetections {
        sensor_id,
        number,
        time_ns,
        detections: place..place,
    };
    let known = silent
        .iter()
        .map(|(sensor, number, time_ns)| without_detections(*sensor, (*number, *time_ns), 0));
    scans.extend(known);
    // Stable: scans with detections come first.
    scans.sort_by_key(|scan| (scan.sensor_id, scan.number));
    scans.dedup_by_key(|scan| (scan.sensor_id, scan.number));
    let gaps: Vec<ScanOfDetections> = scans
        .windows(2)
        .filter(|pair| pair[0].sensor_id == pair[1].sensor_id)
        .flat_map(|pair| {
            let [before, after] = [0, 1].map(|place: usize| (pair[place].number, pair[place].time_ns));
            let (sensor_id, place) = (pair[1].sensor_id, pair[1].detections.start);
            silent_scans(before, after).map(move |scan| without_detections(sensor_id, scan, place))
        })
        .collect();
    scans.extend(gaps);
    scans.sort_by_key(|scan| (scan.time_ns, scan.sensor_id, scan.number));
    scans
}

/// Scans without detections, number and time in nanoseconds, between two of a sensor that follow each other.
pub fn silent_scans(
    (before, time_before): (u32, i64),
    (scan, time_ns): (u32, i64),
) -> impl Iterator<Item = (u32, i64)> {
    let gap = scan.saturating_sub(before);
    let step_ns = time_ns.saturating_sub(time_before) / i64::from(gap.max(1));
    let missing = if gap <= SILENT_SCANS_MAX + 1 { 1..gap } else { 1..1 };
    missing.map(move |number| {
        let after_ns = step_ns.saturating_mul(i64::from(number));
        (before + number, time_before.saturating_add(after_ns))
    })
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
        let found: Vec<_> = scans_of(&mut detections, &[])
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
        assert_eq!(scans_of(&mut [], &[]), []);
    }

    #[test]
    fn scans_known_to_be_silent_are_filled_up_between_and_never_twice() {
        let mut detections = [detection(1, 4, 9 * S), detection(1, 5, 10 * S)];
        let found: Vec<_> = scans_of(&mut detections, &[(1, 3, 8 * S), (2, 0, 0), (1, 0, 2 * S)])
            .into_iter()
            .map(|scan| (scan.time_ns / S, scan.sensor_id, scan.number, scan.detections.len()))
            .collect();
        let expected = [
            (0, 2, 0, 0),
            (2, 1, 0, 0),
            (4, 1, 1, 0),
            (6, 1, 2, 0),
            (8, 1, 3, 0),
            (9, 1, 4, 1),
            (10, 1, 5, 1),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_scan_is_silent_once_and_only_without_detections() {
        let mut detections = [detection(1, 4, 9 * S)];
        let silent = [(1, 5, 10 * S), (1, 4, 8 * S), (1, 5, 11 * S)];
        let found: Vec<_> = scans_of(&mut detections, &silent)
            .into_iter()
            .map(|scan| (scan.time_ns / S, scan.number, scan.detections))
            .collect();
        assert_eq!(found, [(9, 4, 0..1), (10, 5, 0..0)]);
    }

    #[test]
    fn times_that_cannot_be_do_not_overflow() {
        let mut detections = [
            detection(1, 0, i64::MAX),
            detection(1, 50, i64::MIN),
            detection(1, u32::MAX, 0),
        ];
        assert_eq!(scans_of(&mut detections, &[]).len(), 3 + 49);
    }
}
