//! Scans of several sensors in the order of time (HT-12).
//!
//! Each sensor's detections are cut into scans by the sensor's own times ([`tracking::cutting`],
//! [`tracking::stated_scans`]). A tracker needs the scans of all sensors in a single order. Scans in the order of
//! arrival would depend on the load of the machine; therefore a scan waits until no earlier scan can come: until every
//! other sensor has passed the scan's time. A silent sensor must not stop the others. The wait ends when the data of
//! any sensor are later than the scan by the stated *wait*; a sensor with a scan still open then counts as having come
//! so far.
//!
//! The result depends on the events and the order alone, so recorded events give the same scans. A scan that comes
//! after the release of later scans is released at once: the tracker inserts the scan among the open scans, or rejects
//! the scan ([`tracking::Tracker`]). With a single sensor nothing waits here.

use observations::{Detection, SensorEvent};
use settings::SettingsError;
use tracking::cutting::{Boundaries, CutScan, Cutter, CutterSettings, DetectionTreatment};
use tracking::scans::{SILENT_SCANS_MAX, silent_scans};
use tracking::stated_scans::StatedScans;
use tracking::turn_time::TurnEstimate;

use crate::scan_tracker::SensorScan;

/// Most scans that wait for scans of other sensors; beyond, the earliest is released.
const WAITING_MAX: usize = 1024;

/// Rules for joining the detections of a tracker's sensors.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JoiningSettings {
    /// Rules for the scans of each sensor, in the order of the tracker's sensors.
    pub cutters: Vec<CutterSettings>,
    /// Time for which a complete scan waits for earlier scans of other sensors, nanoseconds.
    pub wait_ns: i64,
}

/// A complete scan.
#[derive(Clone, Debug, Default)]
struct WaitingScan {
    sensor: usize,
    number: u32,
    time_ns: i64,
    /// Whether the sensor's time alone shows the scan, which has no detections.
    by_time: bool,
    detections: Vec<Detection>,
    with_them: Vec<i64>,
}

/// Joins the scans of several sensors.
#[derive(Debug)]
pub struct ScanJoiner {
    sensors: Vec<JoinedSensor>,
    wait_ns: i64,
    /// Latest time of any event.
    running_ns: i64,
    /// In the order of times, then of sensors, then of completion.
    waiting: Vec<WaitingScan>,
    has_ended: bool,
    released: WaitingScan,
    /// Memory of released scans.
    spare: Vec<WaitingScan>,
}

#[derive(Debug)]
struct JoinedSensor {
    sensor_id: u32,
    scans: SensorScans,
    /// Period as configured, nanoseconds.
    period_ns: Option<i64>,
    /// Number and time of the latest complete scan.
    latest: Option<(u32, i64)>,
    /// Latest time of the sensor's own events.
    own_ns: i64,
}

/// Content of a scan that is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ScanContent {
    Detections,
    /// A gap in the numbers is a scan without detections.
    None,
    /// The sensor's time alone shows the scan.
    NoneByTime,
}

/// Method for the scans of a sensor.
#[derive(Debug)]
enum SensorScans {
    Cut(Box<Cutter<i64>>),
    Stated(Box<StatedScans<i64>>),
}

impl ScanJoiner {
    /// A joiner for the sensors with these ids. Scan numbers count from `epoch_ns` (UTC, nanoseconds).
    ///
    /// # Errors
    /// If the rules do not belong to these sensors.
    pub fn new(sensor_ids: &[u32], settings: &JoiningSettings, epoch_ns: i64) -> Result<Self, SettingsError> {
        if sensor_ids.is_empty() || sensor_ids.len() != settings.cutters.len() {
            return Err(SettingsError::new("sensor", "a tracker needs a sensor"));
        }
        let sensors = sensor_ids.iter().zip(&settings.cutters);
        Ok(Self {
            sensors: sensors
                .map(|(sensor_id, cutter)| JoinedSensor {
                    sensor_id: *sensor_id,
                    scans: SensorScans::new(CutterSettings { epoch_ns, ..*cutter }),
                    period_ns: cutter.period_ns,
                    latest: None,
                    own_ns: i64::MIN,
                })
                .collect(),
            wait_ns: settings.wait_ns,
            running_ns: i64::MIN,
            waiting: Vec::with_capacity(WAITING_MAX),
            has_ended: false,
            released: WaitingScan::default(),
            spare: Vec::new(),
        })
    }

    /// Place of the sensor with this id.
    pub fn place(&self, sensor_id: u32) -> Option<usize> {
        self.sensors.iter().position(|sensor| sensor.sensor_id == sensor_id)
    }

    /// Takes an event of the sensor in this place; `with_it` stays with a detection: the time of receipt.
    pub fn take(&mut self, sensor: usize, event: &SensorEvent, with_it: i64) -> DetectionTreatment {
        let treatment = self.sensors[sensor].scans.take(event, with_it);
        if treatment == DetectionTreatment::Waits {
            self.sensors[sensor].reach(event.time_ns());
            self.come_to(event.time_ns(), sensor);
        }
        treatment
    }

    /// The clock has come to `time_ns`, in the time of the data (nanoseconds): as if a sensor beside the others had
    /// sent data of this time.
    pub fn clock(&mut self, time_ns: i64) {
        self.come_to(time_ns, 0);
    }

    /// The time of the only sensor has come to `time_ns` by the clock, nanoseconds: the scan at hand may be complete,
    /// but a scan without detections is no scan of the sensor.
    pub fn passed_by_clock(&mut self, time_ns: i64) {
        self.sensors[0].scans.passed(time_ns);
        self.come_to(time_ns, 0);
    }

    /// [`Self::shown_ns`] of several sensors once data have come to `time_ns`, nanoseconds.
    pub fn shown_at_ns(&self, time_ns: i64) -> i64 {
        // A scan at the horizon may still come.
        time_ns.saturating_sub(self.wait_ns).saturating_sub(1)
    }

    /// Takes the statement of the sensor in this place that a turn takes `turn_ns` nanoseconds.
    pub fn turn_takes(&mut self, sensor: usize, turn_ns: i64) {
        if let SensorScans::Cut(cutter) = &mut self.sensors[sensor].scans {
            cutter.turn_takes(turn_ns);
        }
    }

    /// Turn time of the first sensor, estimated so far from the data.
    pub fn turn(&self) -> Option<TurnEstimate> {
        match &self.sensors[0].scans {
            SensorScans::Cut(cutter) => cutter.turn(),
            SensorScans::Stated(_) => None,
        }
    }

    /// Period of the first sensor's scans, nanoseconds.
    pub fn period_ns(&self) -> Option<i64> {
        match &self.sensors[0].scans {
            SensorScans::Cut(cutter) => cutter.period_ns(),
            SensorScans::Stated(_) => None,
        }
    }

    /// Time after which a first sensor that sends nothing is not waited for, nanoseconds; `None` until the period is
    /// known.
    pub fn patience_ns(&self) -> Option<i64> {
        match &self.sensors[0].scans {
            SensorScans::Cut(cutter) => cutter.patience_ns(),
            SensorScans::Stated(_) => None,
        }
    }

    /// No more events come: all scans that wait are released.
    pub fn end(&mut self) {
        self.has_ended = true;
        for place in 0..self.sensors.len() {
            while let Some(scan) = self.sensors[place].scans.last() {
                self.put(place, scan);
            }
        }
    }

    /// The next scan in order; valid until the next call. [`Self::receipts`] belong to the scan's detections.
    pub fn next_scan(&mut self) -> Option<SensorScan<'_>> {
        if !self.is_released() {
            return None;
        }
        let next = self.waiting.remove(0);
        let mut passed = std::mem::replace(&mut self.released, next);
        passed.detections.clear();
        passed.with_them.clear();
        self.spare.push(passed);
        Some(self.released())
    }

    /// The latest released scan.
    pub fn released(&self) -> SensorScan<'_> {
        let scan = &self.released;
        SensorScan {
            sensor_id: self.sensors[scan.sensor].sensor_id,
            number: scan.number,
            time_ns: scan.time_ns,
            detections: &scan.detections,
        }
    }

    /// Whether the sensor's time alone shows the latest released scan, which has no detections.
    pub fn is_by_time(&self) -> bool {
        self.released.by_time
    }

    /// Place of the sensor of the latest released scan, and the data attached to the detections, in order.
    pub fn receipts(&self) -> (usize, &[i64]) {
        (self.released.sensor, &self.released.with_them)
    }

    /// Time until which pictures are due, nanoseconds: with several sensors, as long as no scan waits any longer.
    pub fn shown_ns(&self) -> i64 {
        match (self.sensors.len(), self.has_ended) {
            (1, _) | (_, true) => self.running_ns,
            _ => self.shown_at_ns(self.running_ns),
        }
    }

    /// Scans before this time wait for no other sensor: all scans of others until then are complete.
    fn horizon_ns(&self) -> i64 {
        self.running_ns.saturating_sub(self.wait_ns)
    }

    /// Time to which the sensor in this place counts as having come, nanoseconds. The sensor's longest scan that ends
    /// there is complete when the wait for the scan's first detection ends.
    fn cut_ns(&self, place: usize) -> i64 {
        let rest_ns = self.wait_ns.saturating_sub(self.sensors[place].scans.span_ns()).max(0);
        self.running_ns.saturating_sub(rest_ns)
    }

    /// The data of the sensor in this place have come to `time_ns`.
    fn come_to(&mut self, time_ns: i64, sensor: usize) {
        let is_alone = self.sensors.len() == 1;
        // Only an advance of time concerns the other sensors: most detections of a scan have the scan's time.
        let concerned = match time_ns > self.running_ns {
            true => 0..self.sensors.len(),
            false => sensor..sensor + 1,
        };
        self.running_ns = self.running_ns.max(time_ns);
        for place in concerned {
            let cut_ns = self.cut_ns(place);
            if !is_alone {
                self.sensors[place].scans.passed(cut_ns);
            }
            while let Some(scan) = self.sensors[place].scans.next() {
                self.put(place, scan);
            }
            self.put_silent(place);
        }
    }

    /// Puts the scans without detections that the sensor's own marks of time show: the empty scans since the latest
    /// scan. Without marks these scans are known when the next detection comes. The marks may be marks of the clock
    /// ([`crate::silence`]).
    fn put_silent(&mut self, place: usize) {
        let sensor = &self.sensors[place];
        let rhythm = sensor.rhythm().filter(|_| sensor.scans.is_idle());
        let (Some((mut number, mut time_ns)), Some((period_ns, span_ns))) = (sensor.latest, rhythm) else {
            return;
        };
        let own_ns = sensor.own_ns;
        // A longer gap is a pause of the sensor, or a time that means something else.
        let longest_ns = i64::from(SILENT_SCANS_MAX).saturating_mul(period_ns);
        if own_ns.saturating_sub(time_ns) > longest_ns {
            return;
        }
        while own_ns.saturating_sub(time_ns) >= period_ns + span_ns {
            (number, time_ns) = (number.saturating_add(1), time_ns + period_ns);
            self.insert(place, CutScan { number, time_ns }, ScanContent::NoneByTime);
            let sensor = &mut self.sensors[place];
            sensor.latest = Some((number, time_ns));
            sensor.scans.empty_by_time(CutScan { number, time_ns });
        }
    }

    /// Puts the complete scan of the sensor in this place among those that wait, behind the same sensor's scans without
    /// detections.
    fn put(&mut self, place: usize, scan: CutScan) {
        let now = (scan.number, scan.time_ns);
        let before = self.sensors[place].latest.replace(now);
        for (number, time_ns) in before.into_iter().flat_map(|before| silent_scans(before, now)) {
            self.insert(place, CutScan { number, time_ns }, ScanContent::None);
        }
        self.insert(place, scan, ScanContent::Detections);
    }

    fn insert(&mut self, sensor: usize, scan: CutScan, content: ScanContent) {
        let mut waiting = self.spare.pop().unwrap_or_default();
        (waiting.sensor, waiting.number, waiting.time_ns) = (sensor, scan.number, scan.time_ns);
        waiting.by_time = content == ScanContent::NoneByTime;
        if content == ScanContent::Detections {
            let (detections, with_them) = self.sensors[sensor].scans.complete();
            waiting.detections.extend_from_slice(detections);
            waiting.with_them.extend_from_slice(with_them);
        }
        let order = (scan.time_ns, sensor);
        let place = self
            .waiting
            .partition_point(|each| (each.time_ns, each.sensor) <= order);
        self.waiting.insert(place, waiting);
    }

    /// Whether the first scan that waits is released.
    fn is_released(&self) -> bool {
        let Some(first) = self.waiting.first() else {
            return false;
        };
        let is_due = self.has_ended || first.time_ns < self.horizon_ns() || self.waiting.len() >= WAITING_MAX;
        let order = (first.time_ns, first.sensor);
        let mut others = (0..self.sensors.len()).filter(|place| *place != first.sensor);
        is_due || others.all(|place| (self.sensors[place].scans.earliest_ns(), place) > order)
    }
}

impl JoinedSensor {
    /// Period of the scans, and time from a scan to the completion: a period and the wait, nanoseconds; `None` if the
    /// period is not known.
    fn rhythm(&self) -> Option<(i64, i64)> {
        match &self.scans {
            SensorScans::Cut(cutter) => Some((cutter.period_ns()?, cutter.span_ns())),
            SensorScans::Stated(scans) => {
                let period_ns = self.period_ns?;
                Some((period_ns, period_ns.saturating_add(scans.wait_ns())))
            }
        }
    }

    /// The sensor's own events have come to `time_ns`. A single event does not make more than a scan or two empty: the
    /// time of the event may be wrong.
    fn reach(&mut self, time_ns: i64) {
        let ahead_ns = time_ns.saturating_sub(self.own_ns);
        let is_pause = |period_ns: i64| ahead_ns > period_ns.saturating_mul(i64::from(SILENT_SCANS_MAX));
        let reached_ns = match self.rhythm() {
            Some((period_ns, span_ns)) if !is_pause(period_ns) => {
                time_ns.min(self.own_ns.saturating_add(span_ns.saturating_mul(2)))
            }
            _ => time_ns,
        };
        self.own_ns = self.own_ns.max(reached_ns);
    }
}

impl SensorScans {
    fn new(settings: CutterSettings) -> Self {
        match settings.boundaries {
            Boundaries::Stated => {
                let wait_ns = settings.wait_ns.unwrap_or(0);
                Self::Stated(Box::new(StatedScans::new(wait_ns, settings.waiting_max)))
            }
            Boundaries::Turn | Boundaries::Period => Self::Cut(Box::new(Cutter::new(settings))),
        }
    }

    fn take(&mut self, event: &SensorEvent, with_it: i64) -> DetectionTreatment {
        match (self, *event) {
            (Self::Cut(cutter), SensorEvent::Detection(detection)) => return cutter.take(detection, with_it),
            (Self::Stated(scans), SensorEvent::Detection(detection)) => return scans.take(detection, with_it),
            (Self::Cut(cutter), SensorEvent::TurnBegins(time_ns)) => cutter.turn_begins(time_ns),
            (Self::Stated(scans), SensorEvent::EmptyScan { number, time_ns }) => {
                scans.empty_scan(CutScan { number, time_ns });
            }
            (scans, _) => scans.passed(event.time_ns()),
        }
        DetectionTreatment::Waits
    }

    fn passed(&mut self, time_ns: i64) {
        match self {
            Self::Cut(cutter) => cutter.passed(time_ns),
            Self::Stated(scans) => scans.passed(time_ns),
        }
    }

    fn next(&mut self) -> Option<CutScan> {
        match self {
            Self::Cut(cutter) => cutter.next_scan(),
            Self::Stated(scans) => scans.next_scan(),
        }
    }

    fn last(&mut self) -> Option<CutScan> {
        match self {
            Self::Cut(cutter) => cutter.last_scan(),
            Self::Stated(scans) => scans.last_scan(),
        }
    }

    fn complete(&self) -> (&[Detection], &[i64]) {
        match self {
            Self::Cut(cutter) => (cutter.detections(), cutter.with_them()),
            Self::Stated(scans) => (scans.detections(), scans.with_them()),
        }
    }

    /// Whether nothing waits for the completion of a scan.
    fn is_idle(&self) -> bool {
        match self {
            Self::Cut(cutter) => cutter.is_idle(),
            Self::Stated(scans) => scans.is_idle(),
        }
    }

    /// A scan without detections is complete.
    fn empty_by_time(&mut self, scan: CutScan) {
        match self {
            Self::Cut(cutter) => cutter.empty_scan(scan),
            Self::Stated(scans) => scans.unnumbered_scan(scan.time_ns),
        }
    }

    /// Longest time from a detection to the completion of the scan, as far as known, nanoseconds.
    fn span_ns(&self) -> i64 {
        match self {
            Self::Cut(cutter) => cutter.span_ns(),
            Self::Stated(scans) => scans.wait_ns(),
        }
    }

    fn earliest_ns(&self) -> i64 {
        match self {
            Self::Cut(cutter) => cutter.earliest_ns(),
            Self::Stated(scans) => scans.earliest_ns(),
        }
    }
}

#[cfg(test)]
#[path = "joining_tests.rs"]
mod tests;
