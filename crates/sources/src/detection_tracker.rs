//! Tracks of sensors that deliver detections: cut into scans, and each scan through the tracker (HT, SP).
//!
//! Detections wait until the scan is complete and, with several sensors, until no earlier scan can come
//! ([`crate::joining`]), which depends on times of the data alone. The detections are then published with the scan's
//! number, followed by every confirmed track after the scan, in the order of times. Missing scan numbers are scans
//! without detections; the tracker receives them as soon as the next scan is complete. Where the sensor's marks of
//! time, or the clock ([`crate::silence`]), show a scan without detections before, the scan is published as a mark.
//! `koseki track` repeats all of this with the recorded detections and marks, and produces the same tracks.
//!
//! A tracker of several sensors instead publishes each event of a sensor on arrival, before any decision about the
//! event: detections, late ones included, and marks of time. `koseki track` takes the recorded events in the same
//! order, makes the same tracks and rejects the same late detections.
//!
//! With a configured output period (WA-11), all confirmed tracks are moved to each multiple of the period as soon as
//! the data have reached that time. If no scan came since the previous picture, the tracks are marked as coasted: such
//! tracks are the tracker's own extrapolation without an observation, and fusion treats the tracks as such.
//!
//! The picture of a single sensor does not wait while the sensor is silent ([`DetectionTracker::elapsed`]). The picture
//! goes out without further data once the clock, in the sensor's time, is later than the picture's time by a period and
//! the wait. The scan at hand is completed likewise. With several sensors the clock acts as a further sensor that has
//! come so far ([`DetectionTracker::clock`]). The time of the clock is published as a mark among the events, under the
//! number of the tracker, so `koseki track` makes the same pictures after the same scans. The clock decides *when*,
//! never the *content*: a picture is the state after the scans published before the picture, moved to the picture's
//! time. Each picture is published before the next scan. So a recording holds the order of scans and pictures, and the
//! recorded detections give the same pictures.
//!
//! Reports of wide-area sensors wait until the scans have reached the time of arrival. If that scan has already been
//! processed, a live report is counted, and used in the next scan.
//!
//! The ingest time of a track is the ingest time of the datagram that completed the scan. The age of the data shows the
//! waiting time before.
//!
//! A killed adapter leaves tracks ([`tracking::LeftTracks`]): a successor resumes these tracks under the same numbers.
//! In addition, new numbers of scans and tracks begin with a number that depends on the time ([`tracking::cutting`]),
//! so that a successor without the earlier tracks does not give these numbers to other targets.

use std::sync::atomic::AtomicU64;

use kept::{Memory, MemoryRefusal};
use messages::{Counter, Counters, SensorBearing, StageTimes, TrackState, sensor_track_bits};
use observations::{Bearing, Detection, Sampled, SensorEvent, WideAreaReport};
use settings::SettingsError;
use tracking::cutting::{CutterSettings, DetectionTreatment};
use tracking::turn_time::TurnEstimate;
use tracking::wide_area::Emission;
use tracking::wide_area::arrivals::Arrivals;
use tracking::wide_area::cue::Cue;
use tracking::{LeftTracks, ScanRejection, TrackReport, Tracker, TrackerMemory};

use crate::joining::{JoiningSettings, ScanJoiner};
use crate::last_kept::LastKept;
use crate::samples::Samples;
use crate::scan_tracker::{Outputs, ScanTracker, SensorScan, TrackSink};
use crate::silence::{SilenceRules, SilentSensor};

/// Settings for making tracks of a source's detections.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackerSettings {
    /// Settings of the tracker with the sensors. The only sensor of a source's own tracker is the source, under the
    /// number in the source's files.
    pub settings: tracking::Settings,
    /// Rules for the scans of the sensors.
    pub joining: JoiningSettings,
    /// Requested outputs of the tracker.
    pub outputs: Outputs,
    /// Whether the events of the sensors are published on arrival, instead of the detections of complete scans.
    pub events: bool,
    /// Axes of the platform that carries all sensors, if any. The tracks then state the platform's place.
    pub platform: Option<PlatformAxes>,
}

/// Axes in which a platform's sensors look around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlatformAxes {
    /// Axes of the system frame, at the platform's place.
    North,
    /// Axes of the hull.
    Hull,
}

impl TrackerSettings {
    /// Ids of the sensors, in order.
    pub fn sensor_ids(&self) -> Vec<u32> {
        self.settings.sensors.iter().map(|sensor| sensor.sensor_id).collect()
    }
}

/// Tracker of sensors that deliver detections.
#[derive(Debug)]
pub struct DetectionTracker {
    source: u16,
    /// See [`TrackerSettings::events`].
    events: bool,
    joiner: ScanJoiner,
    /// Scans of the first sensor.
    cutter: CutterSettings,
    /// Silence of the only sensor.
    silent: SilentSensor,
    tracker: ScanTracker,
    /// Number and time of the latest scan.
    latest: Option<(u32, i64)>,
    /// Monotonic time of receipt of the latest datagram, nanoseconds.
    ingested_ns: i64,
    detections: u64,
    /// Latest time of any detection, nanoseconds.
    newest_ns: i64,
    /// Latest time of any event of the sensors, and the monotonic time of receipt, nanoseconds.
    newest_event: Option<(i64, i64)>,
    /// Detections that came, where events are published.
    taken: u64,
    late: u64,
    dropped: u64,
    /// Detections refused by age.
    deselected: u64,
    /// Detections refused for want of a state of the sensor's platform.
    unplaced: u64,
    cues: u64,
    reports_late: u64,
    reports_dropped: u64,
    /// Emissions without a frequency.
    emissions_rejected: u64,
    memory: Option<TrackerMemory>,
    kept: LastKept,
    axes: Option<PlatformAxes>,
    /// Place of the platform, east and north, metres, and the heading of the axes, radians.
    platform: Option<[f64; 3]>,
}

impl DetectionTracker {
    /// The tracker of source number `source`; the tracker uses these `reports` of wide-area sensors, and more may come.
    /// Scan numbers count from `epoch_ns` (UTC, nanoseconds).
    ///
    /// # Errors
    /// The first unusable setting.
    pub fn new(
        source: u16,
        settings: &TrackerSettings,
        epoch_ns: i64,
        reports: Arrivals,
    ) -> Result<Self, SettingsError> {
        Ok(Self {
            source,
            events: settings.events,
            cutter: settings.joining.cutters[0],
            silent: SilentSensor::default(),
            joiner: ScanJoiner::new(&settings.sensor_ids(), &settings.joining, epoch_ns)?,
            tracker: ScanTracker::new(settings.settings.clone(), settings.outputs, reports, Vec::new())?,
            latest: None,
            ingested_ns: 0,
            detections: 0,
            newest_ns: i64::MIN,
            newest_event: None,
            taken: 0,
            late: 0,
            dropped: 0,
            deselected: 0,
            unplaced: 0,
            cues: 0,
            reports_late: 0,
            reports_dropped: 0,
            emissions_rejected: 0,
            memory: None,
            kept: LastKept::default(),
            axes: settings.platform,
            platform: None,
        })
    }

    /// Takes a detection of the first sensor received at `ingested_ns` (monotonic, nanoseconds).
    pub fn take(&mut self, detection: Detection, ingested_ns: i64, samples: &mut Samples) {
        self.event(0, &SensorEvent::Detection(detection), ingested_ns, samples);
    }

    /// Takes an event of the sensor in this place of the settings, received at `ingested_ns`.
    pub fn event(&mut self, sensor: usize, event: &SensorEvent, ingested_ns: i64, samples: &mut Samples) {
        if !self.events {
            self.silent.came(event.time_ns(), ingested_ns);
        }
        self.pass_on(sensor, event, ingested_ns, samples);
    }

    fn pass_on(&mut self, sensor: usize, event: &SensorEvent, ingested_ns: i64, samples: &mut Samples) {
        self.ingested_ns = ingested_ns;
        if let SensorEvent::Detection(detection) = event
            && self.is_too_old(detection.time_of_measurement_ns)
        {
            self.deselected += 1;
            return;
        }
        let sensor_id = self.tracker.tracker().settings().sensors[sensor].sensor_id;
        let event = event.of_sensor(sensor_id);
        if self.events {
            samples
                .detections
                .push(event.sample(sensor_id as u16 - 1, ingested(ingested_ns)));
            self.taken += u64::from(matches!(event, SensorEvent::Detection(_)));
        }
        if matches!(event, SensorEvent::Unplaced(_)) {
            // Published all the same: the recording holds the refused detections.
            self.unplaced += 1;
            return;
        }
        let treatment = self.joiner.take(sensor, &event, ingested_ns);
        let is_newest = |(newest_ns, _): (i64, i64)| event.time_ns() > newest_ns;
        if treatment == DetectionTreatment::Waits && self.newest_event.is_none_or(is_newest) {
            self.newest_event = Some((event.time_ns(), ingested_ns));
        }
        match treatment {
            DetectionTreatment::Waits => self.come_to(samples),
            DetectionTreatment::TooLate => self.late += 1,
            DetectionTreatment::Refused => self.dropped += 1,
        }
    }

    /// Whether a detection is so much older than the latest detection that the detection is not selected (WA-1).
    /// Decided before the scan is cut, by times of the data alone; a refused detection is not published, so `koseki
    /// track` does not need the detection.
    fn is_too_old(&mut self, time_ns: i64) -> bool {
        let selection = &self.tracker.tracker().settings().selection;
        let refused = selection.age_max_s.filter(|_| selection.kept_weight.is_none());
        let is_old = refused.is_some_and(|most| self.newest_ns.saturating_sub(time_ns) > most.ns());
        self.newest_ns = self.newest_ns.max(time_ns);
        is_old
    }

    /// Place in the settings of the sensor with this id.
    pub fn place(&self, sensor_id: u32) -> Option<usize> {
        self.joiner.place(sensor_id)
    }

    /// Takes a report of a wide-area sensor, for the first scan after its arrival, or for the next scan if the
    /// former has been processed.
    pub fn wide_area(&mut self, report: WideAreaReport) {
        let is_late = self.latest.is_some_and(|(_, time_ns)| report.arrival_ns <= time_ns);
        self.reports_late += u64::from(is_late);
        self.reports_dropped += u64::from(!self.tracker.report(report));
    }

    /// Takes a bearing of a direction finder. A bearing with a frequency is an emission, and may identify a track
    /// (WA-9).
    pub fn emission(&mut self, bearing: &SensorBearing) {
        match Bearing::of_sample(bearing).and_then(|bearing| Emission::of(&bearing)) {
            // The tracker counts rejected emissions.
            Some(emission) => drop(self.tracker.emission(&emission)),
            None => self.emissions_rejected += 1,
        }
    }

    /// The first sensor's time has come to `time_ns` (UTC, nanoseconds), and the next turn begins there or not.
    pub fn passed(&mut self, time_ns: i64, turn_begins: bool, ingested_ns: i64, samples: &mut Samples) {
        let event = match turn_begins {
            true => SensorEvent::TurnBegins(time_ns),
            false => SensorEvent::Passed(time_ns),
        };
        self.event(0, &event, ingested_ns, samples);
    }

    /// The clock has come to `time_ns`, in the sensor's time (UTC, nanoseconds), whether or not data have come: the
    /// pictures that no longer wait for data are made (WA-11). Without a configured output period, or before the first
    /// scan, nothing happens.
    pub fn elapsed(&mut self, time_ns: i64, samples: &mut Samples) {
        // Of several sensors, see `clock`.
        if self.events {
            return;
        }
        let Some(patience_ns) = self.joiner.patience_ns() else {
            return;
        };
        let due_ns = time_ns.saturating_sub(patience_ns);
        // Only with a picture to make: a scan is not to be cut short for nothing.
        if self.tracker.scans() > 0 && self.tracker.has_picture_due(due_ns) {
            self.joiner.passed_by_clock(due_ns);
            self.come_to(samples);
        }
    }

    /// The clock has come to `mono_ns` (monotonic, nanoseconds), and no received data wait: the scans that a silent
    /// sensor has made meanwhile had no detections, until the silence raises the alarm after `silent_after_ns`.
    pub fn silent(&mut self, mono_ns: i64, silent_after_ns: Option<i64>, samples: &mut Samples) {
        // The process states the time of each of several sensors.
        let Some(period_ns) = self.joiner.period_ns().filter(|_| !self.events) else {
            return;
        };
        let rules = SilenceRules::new(&self.cutter, period_ns, silent_after_ns);
        if let Some((event, came_ns)) = self.silent.statement(mono_ns, &rules) {
            self.pass_on(0, &event, came_ns, samples);
        }
    }

    /// The clock has come to `mono_ns` (monotonic, nanoseconds), and no received data wait: pictures of several sensors
    /// that are overdue by a period do not wait for data any longer (WA-11). The time of the data is taken to have gone
    /// on since the newest event came.
    pub fn clock(&mut self, mono_ns: i64, samples: &mut Samples) {
        let newest = self.newest_event.filter(|_| self.events && self.tracker.scans() > 0);
        let (Some((newest_ns, came_ns)), Some(period_ns)) = (newest, self.tracker.period_ns()) else {
            return;
        };
        let since_ns = mono_ns.saturating_sub(came_ns);
        let time_ns = newest_ns.saturating_add(since_ns).saturating_sub(period_ns);
        if self.tracker.has_picture_due(self.joiner.shown_at_ns(time_ns)) {
            self.clock_mark(time_ns, samples);
        }
    }

    /// Takes the time to which the clock has come, in the time of the data (UTC, nanoseconds), and publishes this time.
    fn clock_mark(&mut self, time_ns: i64, samples: &mut Samples) {
        let mark = SensorEvent::Passed(time_ns);
        samples.detections.push(mark.sample(self.source, StageTimes::default()));
        self.joiner.clock(time_ns);
        self.come_to(samples);
    }

    /// Takes the first sensor's report that a turn takes `turn_ns` nanoseconds.
    pub fn turn_takes(&mut self, turn_ns: i64) {
        self.joiner.turn_takes(0, turn_ns);
    }

    /// Turn time estimated so far from the first sensor's data.
    pub fn turn(&self) -> Option<TurnEstimate> {
        self.joiner.turn()
    }

    /// Processes the waiting detections at the end of the data.
    pub fn end(&mut self, samples: &mut Samples) {
        self.joiner.end();
        match self.events {
            true => self.come_to(samples),
            // A picture of a time beyond the latest scan waits for data of that time.
            false => self.work_off(samples),
        }
    }

    /// Size in words of the memory for the tracks.
    pub fn kept_words(&self) -> usize {
        TrackerMemory::words(self.tracker.tracker().settings())
    }

    /// Resumes from another tracker's tracks in `memory`, if later than `since_ns` (UTC, nanoseconds); otherwise only
    /// the numbers stay reserved. Must be called before the first detection.
    ///
    /// # Errors
    /// If the memory is not whole, or not this tracker's.
    pub fn resume(&mut self, memory: &[AtomicU64], owner: &str, since_ns: i64) -> Result<(), MemoryRefusal> {
        if let Some(mut left) = LeftTracks::read(memory, owner, self.tracker.tracker().settings())? {
            if left.kept_ns() < since_ns {
                left.end();
            }
            self.tracker.resume(&left);
        }
        Ok(())
    }

    /// Saves the tracks in `memory` from now on; the memory is blank and has [this size](Self::kept_words).
    pub fn keep_in(&mut self, memory: Box<dyn Memory>, owner: &str) {
        self.memory = Some(TrackerMemory::begin(memory, owner, self.tracker.tracker().settings()));
    }

    /// Saves the tracks, if due at `now_ns` (UTC, nanoseconds): before publication.
    pub fn keep(&mut self, now_ns: i64) {
        if let Some(memory) = &mut self.memory
            && self.kept.is_due(self.tracker.scans(), now_ns)
        {
            self.tracker.tracker().keep(memory, now_ns);
        }
    }

    /// Time of the latest scan, or of the latest picture if there are any, nanoseconds: no later track is older.
    pub fn progress_ns(&self) -> i64 {
        let latest_ns = || self.latest.map_or(i64::MIN, |(_, time_ns)| time_ns);
        self.tracker.shown_ns().unwrap_or_else(latest_ns)
    }

    /// Adds the counts of this tracker.
    pub fn count(&self, counters: &mut Counters) {
        let counts = self.tracker.tracker().counts();
        counters[Counter::Detections] = self.detections;
        counters[Counter::RejectedLate] += self.late;
        counters[Counter::RejectedPlatform] += self.unplaced;
        let deselected = match self.tracker.tracker().settings().selection.kept_weight {
            Some(_) => 0,
            None => self.deselected + counts.deselected_detections,
        };
        // Where events are published, refused detections were not counted as taken.
        let refused = if self.events { 0 } else { self.deselected };
        counters[Counter::Reports] += self.taken;
        counters[Counter::Reports] -= self.late + self.dropped + refused;
        counters[Counter::DetectionsRejected] =
            self.dropped + counts.rejected_detections + counts.dropped_detections + deselected;
        counters[Counter::TracksDropped] += counts.dropped_tracks;
        counters[Counter::Scans] = self.tracker.scans();
        counters[Counter::ScanPeriodMs] = self
            .joiner
            .period_ns()
            .map_or(0, |period_ns| period_ns as u64 / 1_000_000);
        counters[Counter::WideAreaReports] = counts.wide_area_reports;
        counters[Counter::WideAreaRejected] = counts.wide_area_reports_rejected + self.reports_dropped;
        counters[Counter::WideAreaLate] = self.reports_late;
        counters[Counter::WideAreaUsed] = counts.wide_area_reports_used;
        counters[Counter::WideAreaUnmatched] = counts.wide_area_reports_unmatched;
        counters[Counter::Emissions] = counts.emissions;
        counters[Counter::EmissionsRejected] = counts.emissions_rejected + self.emissions_rejected;
        counters[Counter::EmissionsUnclear] = counts.emissions_unclear;
        counters[Counter::DesignationsFollowed] = counts.designations_followed;
        counters[Counter::Cues] = self.cues;
    }

    fn come_to(&mut self, samples: &mut Samples) {
        self.work_off(samples);
        let shown_ns = self.joiner.shown_ns();
        let mut sink = Publishing {
            source: self.source,
            ingested_ns: self.ingested_ns,
            has_pictures: self.tracker.shown_ns().is_some(),
            cues: &mut self.cues,
            platform: self.platform,
            late: None,
            samples,
        };
        self.tracker.show(shown_ns, &mut sink);
    }

    /// Gives the tracker the scans that are complete.
    fn work_off(&mut self, samples: &mut Samples) {
        while self.joiner.next_scan().is_some() {
            let scan = self.joiner.released();
            self.detections += scan.detections.len() as u64;
            if !self.events {
                let (_, receipts) = self.joiner.receipts();
                let published = scan.detections.iter().zip(receipts);
                let published = published.map(|(detection, at_ns)| detection.sample(self.source, ingested(*at_ns)));
                samples.detections.extend(published);
                if self.joiner.is_by_time() {
                    let (number, time_ns) = (scan.number, scan.time_ns);
                    let empty = SensorEvent::EmptyScan { number, time_ns };
                    samples
                        .detections
                        .push(empty.sample(self.source, ingested(self.ingested_ns)));
                }
            }
            let latest_ns = self.latest.map_or(i64::MIN, |(_, time_ns)| time_ns);
            if let Some(axes) = self.axes
                && scan.time_ns >= latest_ns
            {
                self.platform = platform_of(scan.detections, axes, self.platform);
            }
            let mut sink = Publishing {
                source: self.source,
                ingested_ns: self.ingested_ns,
                has_pictures: self.tracker.shown_ns().is_some(),
                cues: &mut self.cues,
                platform: self.platform,
                late: self.events.then_some(&mut self.late),
                samples,
            };
            self.tracker.scan(&scan, None, &mut sink);
            if !self.events || scan.time_ns >= latest_ns {
                self.latest = Some((scan.number, scan.time_ns));
            }
        }
    }
}

/// Place of the platform, and heading of the `axes`, at the latest of a scan's detections. Values not stated remain.
fn platform_of(detections: &[Detection], axes: PlatformAxes, before: Option<[f64; 3]>) -> Option<[f64; 3]> {
    let Some(latest) = detections.last() else {
        return before;
    };
    let [east, north, _] = latest.platform_m;
    let heading_rad = match (axes, latest.platform.attitude_rad) {
        (PlatformAxes::North, _) => 0.0,
        (PlatformAxes::Hull, Some([heading_rad, ..])) => f64::from(heading_rad),
        (PlatformAxes::Hull, None) => before.map_or(0.0, |[.., heading_rad]| heading_rad),
    };
    Some([east, north, heading_rad])
}

/// The way of a tracker's tracks and cues into samples.
struct Publishing<'a> {
    source: u16,
    ingested_ns: i64,
    /// Whether tracks come as pictures at even times.
    has_pictures: bool,
    cues: &'a mut u64,
    /// See [`DetectionTracker::platform`].
    platform: Option<[f64; 3]>,
    /// Count of the detections in scans that are too late for the tracker.
    late: Option<&'a mut u64>,
    samples: &'a mut Samples,
}

impl TrackSink for Publishing<'_> {
    fn done(&mut self, scan: &SensorScan<'_>, taken: Result<(), ScanRejection>, _: &Tracker) {
        if let (Err(ScanRejection::TooLate), Some(late)) = (taken, &mut self.late) {
            **late += scan.detections.len() as u64;
        }
    }

    fn tracks(&mut self, tracks: &[TrackReport], extrapolated: bool) {
        for report in tracks {
            let mut track = report.sensor_track(self.source);
            track.stages.ingested_ns = self.ingested_ns;
            if extrapolated {
                track.state = TrackState::Coasted as u8;
                track.valid &= !sensor_track_bits::MEASURED;
            } else if let Some(platform) = self.platform {
                track.measured_m = platform;
                track.valid = track.valid & !sensor_track_bits::MEASURED | sensor_track_bits::PLATFORM;
            }
            self.samples.tracks.push(track);
        }
        self.samples.has_picture |= self.has_pictures && !tracks.is_empty();
    }

    fn cues(&mut self, scan_ns: i64, cues: &[Cue]) {
        *self.cues += cues.len() as u64;
        // A sensor's number in files is the number of the source plus 1.
        let source = |cue: &Cue| cue.sensor_id.saturating_sub(1) as u16;
        let samples = cues.iter().map(|cue| messages::Cue {
            made_ns: scan_ns,
            ..cue.sample(source(cue), ingested(self.ingested_ns))
        });
        self.samples.cues.extend(samples);
    }
}

/// Stage times of data received at `ingested_ns`, without further stages.
pub(crate) fn ingested(ingested_ns: i64) -> StageTimes {
    StageTimes {
        ingested_ns,
        ..StageTimes::default()
    }
}
