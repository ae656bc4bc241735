//! Tracks of a sensor that delivers detections: cut into scans, and each scan through the tracker (HT, SP).
//!
//! Detections wait until their scan is complete ([`::tracking::cutting`]), which is decided by times of the data alone.
//! Then they are published with the scan's number, and after them every confirmed track as it is after the scan, in the
//! order of times. Numbers of scans that are left out are scans without detections, which the tracker is told of as soon as the
//! next scan is complete. `koseki track` does all of this with the recorded detections again and comes to the same tracks.
//!
//! A track has come in, as far as the stages of its journey are concerned, when the datagram did that completed its scan. How
//! old it is by then shows in the age of the data.
//!
//! Numbers of scans and tracks begin with a number that depends on the time ([`::tracking::cutting`]), so that an adapter
//! that was restarted, and knows nothing of the tracks before, does not give their numbers to other targets.

use anyhow::Context as _;
use formats::detection::Detection;
use formats::wide_area::WideAreaReport;
use messages::{COUNTERS_MAX, Counter};
use runtime::config::SourceTracker;
use tracking::cutting::{CutScan, Cutter, CutterSettings, Taken};
use tracking::scans::silent_times_ns;
use tracking::wide_area::arrivals::Arrivals;
use tracking::{TrackReport, Tracker};

use super::Made;

/// See the module's documentation.
#[derive(Debug)]
pub(crate) struct Tracking {
    source: u16,
    sensor_id: u32,
    cutter: Cutter<i64>,
    tracker: Tracker,
    /// Number and time of the latest scan.
    latest: Option<(u32, i64)>,
    /// Its tracks in the order of times.
    reports: Vec<TrackReport>,
    /// When the latest datagram came in, monotonic, nanoseconds.
    ingested_ns: i64,
    detections: u64,
    late: u64,
    refused: u64,
    scans: u64,
    /// Reports of wide-area sensors that wait for the scans to come to their arrival.
    counts: Arrivals,
    counts_late: u64,
    counts_refused: u64,
}

impl Tracking {
    /// Scan numbers count from `epoch_ns` (UTC, nanoseconds).
    pub(super) fn new(source: u16, tracker: &SourceTracker, epoch_ns: i64, counts: Arrivals) -> anyhow::Result<Self> {
        let settings = &tracker.settings;
        let sensor = settings.sensors.first().context("a tracker needs a sensor")?;
        Ok(Self {
            source,
            sensor_id: sensor.sensor_id,
            cutter: Cutter::new(CutterSettings {
                epoch_ns,
                ..tracker.cutter
            }),
            reports: Vec::with_capacity(settings.capacity.tracks),
            tracker: Tracker::new(settings.clone()).map_err(anyhow::Error::msg)?,
            latest: None,
            ingested_ns: 0,
            detections: 0,
            late: 0,
            refused: 0,
            scans: 0,
            counts,
            counts_late: 0,
            counts_refused: 0,
        })
    }

    pub(super) fn take(&mut self, detection: Detection, ingested_ns: i64, made: &mut Made) {
        self.ingested_ns = ingested_ns;
        match self.cutter.take(detection, ingested_ns) {
            Taken::Waits => self.work_off(made),
            Taken::TooLate => self.late += 1,
            Taken::Refused => self.refused += 1,
        }
    }

    /// Takes a report of a wide-area sensor. It is for the first scan after its arrival, or for the next one if that has been
    /// worked off.
    pub(super) fn wide_area(&mut self, report: WideAreaReport) {
        let is_late = self.latest.is_some_and(|(_, time_ns)| report.arrival_ns <= time_ns);
        self.counts_late += u64::from(is_late);
        self.counts_refused += u64::from(!self.counts.arrive(report));
    }

    /// The sensor's time has come to `time_ns` (UTC, nanoseconds), and its next turn begins there or not.
    pub(super) fn passed(&mut self, time_ns: i64, turn_begins: bool, ingested_ns: i64, made: &mut Made) {
        self.ingested_ns = ingested_ns;
        if turn_begins {
            self.cutter.turn_begins(time_ns);
        } else {
            self.cutter.passed(time_ns);
        }
        self.work_off(made);
    }

    pub(super) fn end(&mut self, made: &mut Made) {
        while let Some(scan) = self.cutter.last_scan() {
            self.scan(scan, made);
        }
    }

    /// Time of the latest scan: no later track is older.
    pub(super) fn progress_ns(&self) -> i64 {
        self.latest.map_or(i64::MIN, |(_, time_ns)| time_ns)
    }

    pub(super) fn count(&self, counters: &mut [u64; COUNTERS_MAX]) {
        let counts = self.tracker.counts();
        counters[Counter::Detections as usize] = self.detections;
        counters[Counter::RejectedLate as usize] += self.late;
        counters[Counter::Reports as usize] -= self.late + self.refused;
        counters[Counter::DetectionsRefused as usize] =
            self.refused + counts.unusable_detections + counts.crowded_out_detections;
        counters[Counter::RefusedTracks as usize] += counts.refused_tracks;
        counters[Counter::Scans as usize] = self.scans;
        counters[Counter::WideAreaReports as usize] = counts.wide_area_reports;
        counters[Counter::WideAreaRefused as usize] = counts.wide_area_reports_refused + self.counts_refused;
        counters[Counter::WideAreaLate as usize] = self.counts_late;
        counters[Counter::WideAreaUsed as usize] = counts.wide_area_reports_used;
        counters[Counter::WideAreaUnmatched as usize] = counts.wide_area_reports_unmatched;
    }

    fn work_off(&mut self, made: &mut Made) {
        while let Some(scan) = self.cutter.next_scan() {
            self.scan(scan, made);
        }
    }

    fn scan(&mut self, scan: CutScan, made: &mut Made) {
        for (detection, ingested_ns) in self.cutter.detections().iter().zip(self.cutter.with_them()) {
            self.detections += 1;
            made.detections.push(detection.sample(self.source, *ingested_ns));
        }
        let now = (scan.number, scan.time_ns);
        match self.latest {
            None => self.tracker.number_from(scan.number),
            Some(before) => {
                for time_ns in silent_times_ns(before, now) {
                    self.counts.give(time_ns, &mut self.tracker, |_| ());
                    let taken = self.tracker.scan(self.sensor_id, time_ns, &[]);
                    self.publish(taken.is_ok(), made);
                }
            }
        }
        // What the tracker refuses it counts.
        self.counts.give(scan.time_ns, &mut self.tracker, |_| ());
        let taken = self
            .tracker
            .scan(self.sensor_id, scan.time_ns, self.cutter.detections());
        self.publish(taken.is_ok(), made);
        self.latest = Some(now);
    }

    fn publish(&mut self, is_taken: bool, made: &mut Made) {
        // A scan at the very time of the one before, of a sensor whose clock stands still, may be refused: the tracker counts.
        if !is_taken {
            return;
        }
        self.scans += 1;
        self.reports.clear();
        self.reports.extend_from_slice(self.tracker.tracks());
        self.reports.sort_unstable_by_key(TrackReport::order);
        for report in &self.reports {
            let mut track = report.sensor_track(self.source);
            track.stages.ingested_ns = self.ingested_ns;
            made.tracks.push(track);
        }
    }
}
