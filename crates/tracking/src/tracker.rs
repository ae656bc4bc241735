//! The tracker: processes scan after scan, including late scans (HT-1, HT-12).
//!
//! A late scan could be used at once, with detections carried forward; but decisions made without these detections
//! would stay. Instead the last scans stay open, each stored with the population before the scan. A late scan is
//! inserted in order, and all scans from there on are processed again. So the result is bitwise the same as if every
//! scan had come in order; scans of equal time are in the order of sensors. Scans older than all open scans are
//! rejected and counted.

use observations::{Detection, WideAreaReport};
use settings::SettingsError;

use crate::counts::TrackerCounts;
use crate::explanation::Observer;
use crate::plot::{Scan, admit};
use crate::population::Population;
use crate::resolution::unite;
use crate::scan_update::ScanUpdate;
use crate::settings::Settings;
use crate::track_report::{BestBranch, TrackReport, find_best, has_left, report_of};
use crate::wide_area::cue::{Cue, cue};
use crate::wide_area::emission::{Emission, EmissionRejection};
use crate::wide_area::report::ReportRejection;
use crate::wide_area::support::Support;

/// Reason why a scan was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScanRejection {
    /// No settings for a sensor of this number.
    UnknownSensor(u32),
    /// The scan is older than every open scan.
    TooLate,
}

impl std::fmt::Display for ScanRejection {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::UnknownSensor(sensor) => write!(formatter, "sensor {sensor} is not configured"),
            Self::TooLate => write!(formatter, "the scan is older than every open one; keep more scans open"),
        }
    }
}

impl std::error::Error for ScanRejection {}

/// The multiple-hypothesis tracker. No clone can be made: a clone would lack the memory allocated beforehand.
#[derive(Debug)]
pub struct Tracker {
    settings: Settings,
    /// In order of time, then of sensors; the first `open` count.
    scans: Vec<Scan>,
    open: usize,
    /// Before each open scan, then after the last.
    populations: Vec<Population>,
    update: ScanUpdate,
    support: Support,
    /// By detection of a scan: number of united detections.
    united: Vec<u32>,
    best: Vec<BestBranch>,
    reports: Vec<TrackReport>,
    counts: TrackerCounts,
}

impl Tracker {
    /// A tracker without tracks. All memory is allocated here.
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        settings::check(&settings)?;
        let (tracks, detections) = (settings.capacity.tracks(), settings.capacity.detections());
        let open_scans = settings.open_scans();
        let types = settings.wide_area.knowledge.types.len();
        let population = |_| Population::new(tracks, settings.sensors.len(), types);
        let scan = |_| Scan {
            time_ns: i64::MIN,
            sensor: 0,
            plots: Vec::with_capacity(detections),
        };
        Ok(Self {
            scans: (0..=open_scans).map(scan).collect(),
            open: 0,
            populations: (0..open_scans + 2).map(population).collect(),
            update: ScanUpdate::new(&settings),
            support: Support::new(&settings.wide_area, tracks),
            united: vec![0; detections],
            best: Vec::with_capacity(tracks),
            reports: Vec::with_capacity(tracks),
            counts: TrackerCounts::default(),
            settings,
        })
    }

    /// Numbers confirmed tracks from `first` on (0 is taken for 1). After a take-over, the tracker begins beyond the
    /// numbers that the predecessor may have used. Must be called before the first scan; later calls have no effect.
    pub fn number_from(&mut self, first: u32) {
        if self.counts.scans == 0 {
            let first = first.max(1);
            self.populations
                .iter_mut()
                .for_each(|population| population.next_number = population.next_number.max(first));
        }
    }

    /// Processes a scan of the sensor `sensor_id` at `time_ns`. An empty scan is information, too.
    ///
    /// # Errors
    /// [`ScanRejection`], counted, if the scan cannot be used; single detections that cannot be used are left out and
    /// counted.
    pub fn scan(&mut self, sensor_id: u32, time_ns: i64, detections: &[Detection]) -> Result<(), ScanRejection> {
        self.scan_explained(sensor_id, time_ns, detections, None)
    }

    /// Processes a scan like [`Self::scan`], and gives an observer the records of the decisions.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn scan_explained(
        &mut self,
        sensor_id: u32,
        time_ns: i64,
        detections: &[Detection],
        observer: Option<&dyn Observer>,
    ) -> Result<(), ScanRejection> {
        let place = self
            .place(sensor_id, time_ns)
            .inspect_err(|_| self.counts.rejected_scans += 1)?;
        let (sensor, mut place) = place;
        if self.open == self.scans.len() {
            // The oldest scan is closed.
            self.scans.rotate_left(1);
            self.populations.rotate_left(1);
            self.open -= 1;
            place -= 1;
        }
        let latest_ns = self.scans[..self.open]
            .last()
            .map_or(time_ns, |scan| scan.time_ns.max(time_ns));
        let scan = &mut self.scans[self.open];
        (scan.time_ns, scan.sensor) = (time_ns, sensor);
        admit(
            detections,
            [time_ns, latest_ns],
            &self.settings.sensors[sensor],
            &self.settings.selection,
            &mut scan.plots,
            &mut self.counts,
        );
        if let Some(resolution_m) = self.settings.sensors[sensor].model.resolution_m {
            self.counts.united_detections += unite(&mut scan.plots, resolution_m, &mut self.united) as u64;
        }
        self.scans[place..=self.open].rotate_right(1);
        self.counts.late_scans += u64::from(place < self.open);
        self.open += 1;
        let first = self.first_changed(place);
        self.work_off_again(first, Some(place), observer);
        Ok(())
    }

    /// Takes a report of a wide-area sensor at the arrival (WA-2). The report is used in the first scan after the
    /// arrival. Open scans after the arrival are processed again; if the scans are closed, the next scan uses the
    /// report.
    ///
    /// # Errors
    /// [`ReportRejection`], counted, if the report cannot be used.
    pub fn wide_area(&mut self, report: &WideAreaReport) -> Result<(), ReportRejection> {
        let (closed_ns, settings) = (self.closed_ns(), &self.settings.wide_area);
        let due_ns = self
            .support
            .take_report(report, closed_ns, settings, &mut self.counts)?;
        let first = self.scans[..self.open].partition_point(|scan| scan.time_ns < due_ns);
        if first < self.open {
            self.work_off_from(first, None);
        }
        Ok(())
    }

    /// Takes an emission received on board (WA-9). The first scan after the emission uses it to identify the emitting
    /// track; tracks of open scans after the emission are identified again.
    ///
    /// # Errors
    /// [`EmissionRejection`], counted, if the emission cannot be used.
    pub fn emission(&mut self, emission: &Emission) -> Result<(), EmissionRejection> {
        let (closed_ns, settings) = (self.closed_ns(), &self.settings.wide_area);
        let due_ns = self
            .support
            .take_emission(emission, closed_ns, settings, &mut self.counts)?;
        let first = self.scans[..self.open].partition_point(|scan| scan.time_ns < due_ns);
        if first < self.open {
            (first..self.open).for_each(|place| self.identify(place));
            self.report(None);
        }
        Ok(())
    }

    /// Time of the last scan that is never worked off again.
    fn closed_ns(&self) -> i64 {
        if self.open == self.scans.len() {
            self.scans[0].time_ns
        } else {
            self.populations[0].time_ns
        }
    }

    /// The confirmed tracks after the latest scan, by number.
    pub fn tracks(&self) -> &[TrackReport] {
        &self.reports
    }

    /// The confirmed tracks at `time_ns`, into `picture` (WA-11), without tracks that have been silent for so long that
    /// a scan would delete the track (HT-10): pictures continue while the sensors are silent.
    pub fn picture_at(&self, time_ns: i64, picture: &mut Vec<TrackReport>) {
        let noise = self.settings.motion.process_noise_m2ps3;
        picture.clear();
        let silent_ns = self.settings.deletion.limits.silent_s.ns();
        let current = |track: &&TrackReport| time_ns.saturating_sub(track.time_ns) < silent_ns;
        let current = self.reports.iter().filter(current);
        picture.extend(current.map(|track| track.moved_to(time_ns, noise)));
    }

    /// Writes to `cues` a search region for each confirmed track at `time_ns`, for the sensor `sensor_id` with a
    /// standard deviation of `sigma_m` metres (WA-12).
    pub fn cues_at(&self, (sensor_id, time_ns): (u32, i64), sigma_m: f64, cues: &mut Vec<Cue>) {
        let Settings { motion, gate, .. } = &self.settings;
        let look = (sensor_id, time_ns);
        let all = self.reports.iter();
        cues.clear();
        cues.extend(all.map(|track| cue(track, look, sigma_m, gate.probability, motion)));
    }

    /// Counters of processed and rejected inputs so far.
    pub fn counts(&self) -> &TrackerCounts {
        &self.counts
    }

    /// Tracks after the latest scan, tentative tracks and branches included.
    pub fn branches(&self) -> usize {
        self.latest().tracks.len()
    }

    /// Clusters after the latest scan.
    pub fn clusters(&self) -> usize {
        self.latest().clusters.len()
    }

    /// Settings of the tracker.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    pub(crate) fn best_branches(&self) -> &[BestBranch] {
        &self.best
    }

    /// Population before the first scan.
    pub(crate) fn first_population(&mut self) -> &mut Population {
        &mut self.populations[0]
    }

    pub(crate) fn latest(&self) -> &Population {
        &self.populations[self.open]
    }

    /// The sensor's place in the settings, and the scan's place among the open scans.
    fn place(&self, sensor_id: u32, time_ns: i64) -> Result<(usize, usize), ScanRejection> {
        let mut sensors = self.settings.sensors.iter();
        let sensor = sensors.position(|sensor| sensor.sensor_id == sensor_id);
        let sensor = sensor.ok_or(ScanRejection::UnknownSensor(sensor_id))?;
        let open = &self.scans[..self.open];
        let place = open.partition_point(|scan| (scan.time_ns, scan.sensor) <= (time_ns, sensor));
        let closed = self.open == self.scans.len() && place == 0;
        // The population before the first open scan may be later than this scan, if others have been closed.
        let behind = place == 0 && time_ns < self.populations[0].time_ns;
        if closed || behind {
            return Err(ScanRejection::TooLate);
        }
        Ok((sensor, place))
    }

    /// Returns the first open scan to be processed again because of the scan at `place`: this scan, or a scan outranked
    /// by this scan.
    fn first_changed(&self, place: usize) -> usize {
        if !self.has_priorities() {
            return place;
        }
        let same_time_ns = self.settings.selection.same_time_s.ns();
        let earliest_ns = self.scans[place].time_ns.saturating_sub(same_time_ns);
        self.scans[..place].partition_point(|scan| scan.time_ns < earliest_ns)
    }

    /// Whether another open scan at the same time is of a sensor of higher priority (WA-1).
    fn is_outranked(&self, place: usize) -> bool {
        let same_time_ns = self.settings.selection.same_time_s.ns();
        let priority = |scan: &Scan| self.settings.sensors[scan.sensor].priority;
        let scan = &self.scans[place];
        let outranks = |other: &Scan| {
            let apart_ns = other.time_ns.saturating_sub(scan.time_ns).saturating_abs();
            apart_ns <= same_time_ns && priority(other) > priority(scan)
        };
        self.has_priorities() && self.scans[..self.open].iter().any(outranks)
    }

    fn has_priorities(&self) -> bool {
        self.settings.sensors.iter().any(|sensor| sensor.priority > 0)
    }

    /// Processes all open scans from `first` on again.
    fn work_off_from(&mut self, first: usize, observer: Option<&dyn Observer>) {
        self.work_off_again(first, None, observer);
    }

    /// Processes the open scans from `first` on, all but `new` again. Counts of the sender's messages stay as counted
    /// before.
    fn work_off_again(&mut self, first: usize, new: Option<usize>, observer: Option<&dyn Observer>) {
        for place in first..self.open {
            let counted = self.counts.designations_followed;
            self.work_off(place, observer);
            if new != Some(place) {
                self.counts.designations_followed = counted;
            }
            self.identify(place);
        }
        self.report(observer);
    }

    /// Makes the population after the open scan at `place`.
    fn work_off(&mut self, place: usize, observer: Option<&dyn Observer>) {
        let is_outranked = self.is_outranked(place);
        self.counts.outranked_scans += u64::from(is_outranked);
        let log_kept_weight = self.settings.selection.log_kept_weight();
        let (before, after) = self.populations.split_at_mut(place + 1);
        let (before, next) = (&before[place], &mut after[0]);
        if is_outranked && log_kept_weight.is_none() {
            next.carry_on(before);
            return;
        }
        let log_weight = log_kept_weight.filter(|_| is_outranked).unwrap_or(0.0);
        self.update.run(
            (&self.scans[place], log_weight),
            (before, next),
            &self.settings,
            &mut self.support,
            observer,
            &mut self.counts,
        );
    }

    /// Identifies the tracks after the open scan at `place` (WA-9).
    fn identify(&mut self, place: usize) {
        let (before, after) = self.populations.split_at_mut(place + 1);
        let (before, next) = (&before[place], &mut after[0]);
        let (time_ns, settings) = (self.scans[place].time_ns, &self.settings.wide_area);
        self.support.identify(before, next, time_ns, settings, &mut self.counts);
    }

    /// Reports of each confirmed ancestor the most reliable branch (HT-10).
    pub(crate) fn report(&mut self, observer: Option<&dyn Observer>) {
        let (population, settings) = (&self.populations[self.open], &self.settings);
        find_best(population, &mut self.best);
        let shown_min = settings.deletion.shown_min;
        self.best.retain(|best| {
            best.existence() >= shown_min && !has_left(&population.tracks[best.track as usize], population, settings)
        });
        self.reports.clear();
        self.reports.extend(self.best.iter().map(|best| {
            let track = &population.tracks[best.track as usize];
            let cluster = &population.clusters[best.cluster as usize];
            report_of(track, cluster, population.time_ns, settings)
        }));
        if let Some(last) = self.open.checked_sub(1) {
            let (scan, first_serial) = (&self.scans[last], self.populations[last].next_serial);
            for (report, best) in self.reports.iter_mut().zip(&self.best) {
                // Serial numbers of earlier scans, and that of no detection, are not in this scan.
                let serial = population.tracks[best.track as usize].history[0];
                let plot = scan.plots.get(serial.wrapping_sub(first_serial) as usize);
                let place = plot.and_then(|plot| plot.measurement.position(report.estimate.mean[2]));
                report.measured_m = place.filter(|_| report.missed == 0);
            }
        }
        let (best, reports) = (&self.best, &mut self.reports);
        self.support.amend(population, best, settings, observer, reports);
    }
}
