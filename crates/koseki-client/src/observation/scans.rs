//! Numbers of scans that observations do not state: detections with one time are one scan.

use messages::SensorDetection;

/// Number of the latest scan of a sensor, and the count of its detections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Scans {
    number: u32,
    detections: u32,
    time_ns: i64,
}

impl Scans {
    /// Numbers a detection. One that states its scan keeps it.
    pub fn number(&mut self, detection: &mut SensorDetection, is_stated: bool) {
        let is_same = match is_stated {
            true => detection.scan == self.number,
            false => detection.time_of_measurement_ns == self.time_ns,
        };
        if !is_same {
            self.number = if is_stated {
                detection.scan
            } else {
                self.number.wrapping_add(1)
            };
            self.detections = 0;
        }
        self.time_ns = detection.time_of_measurement_ns;
        self.detections += 1;
        (detection.scan, detection.detection_id) = (self.number, self.detections);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detections_with_one_time_are_one_scan_and_stated_scans_stay() {
        let mut scans = Scans::default();
        let mut numbered = |time_ns: i64, stated: Option<u32>| {
            let mut detection = SensorDetection {
                time_of_measurement_ns: time_ns,
                scan: stated.unwrap_or_default(),
                ..SensorDetection::default()
            };
            scans.number(&mut detection, stated.is_some());
            (detection.scan, detection.detection_id)
        };
        assert_eq!(
            [numbered(10, None), numbered(10, None), numbered(20, None)],
            [(1, 1), (1, 2), (2, 1)]
        );
        assert_eq!(
            [numbered(30, Some(77)), numbered(31, Some(77)), numbered(40, None)],
            [(77, 1), (77, 2), (78, 1)]
        );
    }
}
