//! Collects the detections of a sensor that numbers the scans itself.
//!
//! A camera's image or a lidar's sweep has a number and a time. The scans of such a sensor need no cutting
//! ([`crate::cutting`]): detections with the same number are a scan. A scan is complete when the sensor's time has come
//! beyond the scan's latest detection by more than the *wait*. An image without detections has a number, too, and is a
//! scan without detections.
//!
//! Detections of complete scans, and of times before them, are too late and are rejected. Times count, not numbers: a
//! restarted sensor begins again with the first number.

use observations::Detection;

use crate::cutting::{CutScan, DetectionTreatment};

/// Most scans that wait to be complete.
const OPEN_MAX: usize = 64;

/// Collector of a sensor's scans. `T` stays with each detection.
#[derive(Clone, Debug)]
pub struct StatedScans<T> {
    wait_ns: i64,
    waiting_max: usize,
    waiting: Vec<(Detection, T)>,
    /// In the order of times.
    open: Vec<CutScan>,
    /// Latest complete scan.
    closed: Option<CutScan>,
    running_ns: i64,
    complete: Vec<Detection>,
    with_them: Vec<T>,
}

impl<T: Copy> StatedScans<T> {
    /// A collector in which detections may come later than newer detections by `wait_ns` nanoseconds, with room for
    /// `waiting_max` detections.
    pub fn new(wait_ns: i64, waiting_max: usize) -> Self {
        Self {
            wait_ns,
            waiting_max,
            waiting: Vec::with_capacity(waiting_max),
            open: Vec::with_capacity(OPEN_MAX),
            closed: None,
            running_ns: i64::MIN,
            complete: Vec::with_capacity(waiting_max),
            with_them: Vec::with_capacity(waiting_max),
        }
    }

    /// Takes a detection together with the attached data.
    pub fn take(&mut self, detection: Detection, with_it: T) -> DetectionTreatment {
        let scan = CutScan {
            number: detection.scan,
            time_ns: detection.time_of_measurement_ns,
        };
        if self.is_closed(scan) {
            return DetectionTreatment::TooLate;
        }
        if self.waiting.len() == self.waiting_max || !self.open(scan) {
            return DetectionTreatment::Refused;
        }
        self.waiting.push((detection, with_it));
        self.passed(scan.time_ns);
        DetectionTreatment::Waits
    }

    /// Takes the sensor's statement that a scan has no detections.
    pub fn empty_scan(&mut self, scan: CutScan) {
        if !self.is_closed(scan) {
            self.open(scan);
        }
        self.passed(scan.time_ns);
    }

    /// Takes note of a complete scan without detections that the sensor has not numbered: earlier detections are too
    /// late.
    pub fn unnumbered_scan(&mut self, time_ns: i64) {
        if let Some(closed) = &mut self.closed {
            closed.time_ns = closed.time_ns.max(time_ns);
        }
    }

    /// Whether no scan is open.
    pub fn is_idle(&self) -> bool {
        self.open.is_empty()
    }

    /// The sensor's time has come to `time_ns`.
    pub fn passed(&mut self, time_ns: i64) {
        self.running_ns = self.running_ns.max(time_ns);
    }

    /// Time by which detections may come later than newer detections, nanoseconds.
    pub fn wait_ns(&self) -> i64 {
        self.wait_ns
    }

    /// No scan that is complete later is earlier than this time, nanoseconds.
    pub fn earliest_ns(&self) -> i64 {
        let closed_ns = self.closed.map_or(i64::MIN, |scan| scan.time_ns);
        let come_ns = self.running_ns.saturating_sub(self.wait_ns);
        self.open
            .first()
            .map_or(closed_ns, |open| open.time_ns.min(come_ns).max(closed_ns))
    }

    /// The next complete scan; [`Self::detections`] holds the detections until the next call.
    pub fn next_scan(&mut self) -> Option<CutScan> {
        let scan = *self.open.first()?;
        (self.running_ns > scan.time_ns.saturating_add(self.wait_ns)).then(|| self.close())
    }

    /// The next waiting scan, whether or not more detections may come.
    pub fn last_scan(&mut self) -> Option<CutScan> {
        (!self.open.is_empty()).then(|| self.close())
    }

    /// Detections of the latest scan, by time and, at equal times, by arrival.
    pub fn detections(&self) -> &[Detection] {
        &self.complete
    }

    /// Companions of the detections, in the same order.
    pub fn with_them(&self) -> &[T] {
        &self.with_them
    }

    fn is_closed(&self, scan: CutScan) -> bool {
        let closed = |closed: CutScan| scan.time_ns < closed.time_ns || scan.number == closed.number;
        self.closed.is_some_and(closed)
    }

    /// Opens a scan, or moves the time of an open scan on. `false` without room.
    fn open(&mut self, scan: CutScan) -> bool {
        match self.open.iter().position(|open| open.number == scan.number) {
            Some(place) => self.open[place].time_ns = self.open[place].time_ns.max(scan.time_ns),
            None if self.open.len() == OPEN_MAX => return false,
            None => self.open.push(scan),
        }
        self.open.sort_by_key(|open| open.time_ns);
        true
    }

    fn close(&mut self) -> CutScan {
        let scan = self.open.remove(0);
        self.complete.clear();
        self.with_them.clear();
        self.waiting
            .sort_by_key(|(detection, _)| detection.time_of_measurement_ns);
        for (detection, with_it) in self.waiting.iter().filter(|(each, _)| each.scan == scan.number) {
            self.complete.push(*detection);
            self.with_them.push(*with_it);
        }
        self.waiting.retain(|(each, _)| each.scan != scan.number);
        self.closed = Some(scan);
        scan
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{S, position};

    fn detection(scan: u32, time_s: i64) -> Detection {
        Detection {
            scan,
            ..position(time_s * S, 0.0, 0.0)
        }
    }

    fn cut(scan: u32, time_s: i64) -> CutScan {
        CutScan {
            number: scan,
            time_ns: time_s * S,
        }
    }

    #[test]
    fn a_scan_is_complete_when_a_later_one_has_come() {
        let mut scans = StatedScans::new(0, 10);
        for (scan, time_s) in [(7, 1), (7, 1), (8, 2)] {
            assert_eq!(scans.take(detection(scan, time_s), ()), DetectionTreatment::Waits);
        }
        assert_eq!((scans.next_scan(), scans.detections().len()), (Some(cut(7, 1)), 2));
        assert_eq!(scans.next_scan(), None);
        assert_eq!(scans.earliest_ns(), 2 * S);
        assert_eq!(scans.take(detection(7, 1), ()), DetectionTreatment::TooLate);
        assert_eq!(scans.take(detection(6, 0), ()), DetectionTreatment::TooLate);
        scans.empty_scan(cut(9, 3));
        assert_eq!((scans.next_scan(), scans.detections().len()), (Some(cut(8, 2)), 1));
        scans.passed(3 * S + 1);
        assert_eq!((scans.next_scan(), scans.detections().len()), (Some(cut(9, 3)), 0));
    }

    #[test]
    fn what_comes_within_the_wait_is_put_in_order_and_a_restarted_sensor_is_followed() {
        let mut scans = StatedScans::new(S, 10);
        for (scan, time_s) in [(5, 2), (4, 1), (0, 4)] {
            assert_eq!(scans.take(detection(scan, time_s), ()), DetectionTreatment::Waits);
        }
        let numbers: Vec<u32> = std::iter::from_fn(|| scans.next_scan().map(|scan| scan.number)).collect();
        assert_eq!(numbers, [4, 5]);
        assert_eq!(scans.last_scan(), Some(cut(0, 4)));
        assert_eq!(scans.last_scan(), None);
    }

    #[test]
    fn room_is_bounded() {
        let mut scans = StatedScans::new(S, 1);
        assert_eq!(scans.take(detection(1, 1), ()), DetectionTreatment::Waits);
        assert_eq!(scans.take(detection(1, 1), ()), DetectionTreatment::Refused);
    }
}
