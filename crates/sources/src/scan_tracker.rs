//! A tracker, with all steps around the tracker at each scan.
//!
//! The order of events determines the output: a track picture must include all scans until the picture's time and no
//! later scan, and a report of a wide-area sensor is for the first scan after the arrival of the report. The order is
//! the same for a live source, with each scan processed as soon as it is complete, and for files:
//!
//! 1. the pictures before the scan are shown, where tracks are wanted at even times (WA-11);
//! 2. the tracker receives the counts of wide-area sensors and the emissions until the scan;
//! 3. the scan goes through the tracker;
//! 4. the tracks after the scan are handed out, unless wanted at even times;
//! 5. each sensor receives the search regions for the next look (WA-12).

use observations::{Detection, WideAreaReport};
use settings::SettingsError;
use tracking::explanation::Observer;
use tracking::wide_area::arrivals::Arrivals;
use tracking::wide_area::cue::{Cue, LookTimes, sigma_m};
use tracking::wide_area::schedule::OutputSchedule;
use tracking::wide_area::{Emission, EmissionRejection, ReportRejection};
use tracking::{LeftTracks, ScanRejection, Settings, TrackReport, Tracker};

/// Requested outputs of a tracker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// Time between two pictures of all confirmed tracks, nanoseconds; `None`: tracks come after each scan.
    pub period_ns: Option<i64>,
    /// Set if sensors receive search regions after each scan.
    pub cues: bool,
}

/// Scan of a sensor.
#[derive(Clone, Copy, Debug)]
pub struct SensorScan<'a> {
    /// The sensor.
    pub sensor_id: u32,
    /// Number of the scan; a gap is as many scans without detections.
    pub number: u32,
    /// Time of the latest detection, nanoseconds; of an empty scan, between the neighbours.
    pub time_ns: i64,
    /// Detections; an empty scan is information, too.
    pub detections: &'a [Detection],
}

/// Receiver of the output of a [`ScanTracker`].
pub trait TrackSink {
    /// A scan is about to be worked off.
    fn begins(&mut self) {}

    /// A scan has been worked off, or rejected.
    fn done(&mut self, _scan: &SensorScan<'_>, _taken: Result<(), ScanRejection>, _tracker: &Tracker) {}

    /// Confirmed tracks, in the order of times and numbers. `extrapolated`: no scan has come since the last tracks.
    fn tracks(&mut self, tracks: &[TrackReport], extrapolated: bool);

    /// Cues made after the scan at `scan_ns` (nanoseconds).
    fn cues(&mut self, scan_ns: i64, cues: &[Cue]);

    /// A report of a wide-area sensor was rejected.
    fn report_rejected(&mut self, _reason: ReportRejection) {}

    /// An emission was rejected.
    fn emission_rejected(&mut self, _reason: EmissionRejection) {}
}

/// Tracker with all steps around the tracker at a scan.
#[derive(Debug)]
pub struct ScanTracker {
    tracker: Tracker,
    /// Reports of wide-area sensors that wait for the scans to reach the arrival.
    reports: Arrivals,
    /// Emissions waiting for the scans to reach the emission's time, the latest first.
    emissions: Vec<Emission>,
    pictures: Option<PictureOutput>,
    cueing: Option<Cueing>,
    shown: Vec<TrackReport>,
    scans: u64,
    begun: bool,
}

#[derive(Debug)]
struct PictureOutput {
    schedule: OutputSchedule,
    /// Time of the latest picture.
    shown_ns: i64,
    /// Scans that had been worked off by then.
    scans: u64,
}

#[derive(Debug)]
struct Cueing {
    looks: LookTimes,
    sensors: Vec<CuedSensor>,
    cues: Vec<Cue>,
}

#[derive(Debug)]
struct CuedSensor {
    sensor_id: u32,
    /// Standard deviations of detections that state none.
    sigmas: Option<[f64; 4]>,
    /// Standard deviation of the latest detections' positions, metres; 0 before the first.
    sigma_m: f64,
}

impl ScanTracker {
    /// A tracker that uses these `reports` of wide-area sensors and `emissions` in due time; more may follow.
    ///
    /// # Errors
    /// The first unusable setting.
    pub fn new(
        settings: Settings,
        outputs: Outputs,
        reports: Arrivals,
        mut emissions: Vec<Emission>,
    ) -> Result<Self, SettingsError> {
        let tracks_max = settings.capacity.tracks();
        let pictures = |period_ns| PictureOutput {
            schedule: OutputSchedule::new(period_ns),
            shown_ns: i64::MIN,
            scans: 0,
        };
        let cueing = || Cueing {
            looks: LookTimes::of(settings.sensors.iter().map(|sensor| sensor.sensor_id)),
            sensors: settings.sensors.iter().map(CuedSensor::of).collect(),
            cues: Vec::with_capacity(tracks_max),
        };
        emissions.sort_by_key(|emission| emission.time_ns);
        emissions.reverse();
        Ok(Self {
            pictures: outputs.period_ns.map(pictures),
            cueing: outputs.cues.then(cueing),
            tracker: Tracker::new(settings)?,
            reports,
            emissions,
            shown: Vec::with_capacity(tracks_max),
            scans: 0,
            begun: false,
        })
    }

    /// Takes a report of a wide-area sensor, for the first scan after the arrival. `false` if there is no room.
    pub fn report(&mut self, report: WideAreaReport) -> bool {
        self.reports.arrive(report)
    }

    /// Takes an emission at once.
    ///
    /// # Errors
    /// [`EmissionRejection`], counted by the tracker, if the emission is unusable.
    pub fn emission(&mut self, emission: &Emission) -> Result<(), EmissionRejection> {
        self.tracker.emission(emission)
    }

    /// Processes a scan; an `observer` receives the records of the decisions.
    pub fn scan(&mut self, scan: &SensorScan<'_>, observer: Option<&dyn Observer>, sink: &mut impl TrackSink) {
        if !self.begun {
            self.begun = true;
            self.tracker.number_from(scan.number);
        }
        // The track picture of a time includes no later scan.
        self.show(scan.time_ns - 1, sink);
        sink.begins();
        self.give(scan.time_ns, sink);
        let taken = self
            .tracker
            .scan_explained(scan.sensor_id, scan.time_ns, scan.detections, observer);
        sink.done(scan, taken, &self.tracker);
        // A scan at the same time as the previous scan, from a sensor with a stopped clock, may be rejected: the
        // tracker counts.
        if taken.is_err() {
            return;
        }
        self.scans += 1;
        if self.pictures.is_none() {
            self.shown.clear();
            self.shown.extend_from_slice(self.tracker.tracks());
            self.hand_out(false, sink);
        }
        if let Some(cueing) = &mut self.cueing {
            cueing.after(scan, &self.tracker, sink);
        }
    }

    /// Hands out the pictures until `time_ns`: for when no scan that is worked off later belongs there.
    pub fn show(&mut self, time_ns: i64, sink: &mut impl TrackSink) {
        while let Some(pictures) = &mut self.pictures
            && let Some(time_ns) = pictures.schedule.next(time_ns)
        {
            // Without any scan since the previous picture, the picture is the tracker's own extrapolation.
            let extrapolated = pictures.scans == self.scans;
            (pictures.shown_ns, pictures.scans) = (time_ns, self.scans);
            self.tracker.picture_at(time_ns, &mut self.shown);
            self.hand_out(extrapolated, sink);
        }
    }

    /// Time between two pictures, nanoseconds; `None` if there are no pictures.
    pub fn period_ns(&self) -> Option<i64> {
        self.pictures.as_ref().map(|pictures| pictures.schedule.period_ns())
    }

    /// Whether a picture until `time_ns` has not been handed out.
    pub fn has_picture_due(&self, time_ns: i64) -> bool {
        let pictures = self.pictures.as_ref();
        pictures.is_some_and(|pictures| pictures.schedule.is_due(time_ns))
    }

    /// Resumes the tracks of another tracker. Must be called before the first scan.
    pub fn resume(&mut self, left: &LeftTracks) {
        self.tracker.resume(left);
    }

    /// The tracker.
    pub fn tracker(&self) -> &Tracker {
        &self.tracker
    }

    /// Time of the latest picture, nanoseconds, before the first picture `i64::MIN`; `None` if there are no pictures.
    pub fn shown_ns(&self) -> Option<i64> {
        self.pictures.as_ref().map(|pictures| pictures.shown_ns)
    }

    /// Number of scans taken by the tracker.
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// Numbers of reports and of emissions waiting for a scan.
    pub fn waiting(&self) -> (usize, usize) {
        (self.reports.waiting(), self.emissions.len())
    }

    /// Gives the tracker the reports and emissions received until `time_ns`.
    fn give(&mut self, time_ns: i64, sink: &mut impl TrackSink) {
        self.reports
            .give(time_ns, &mut self.tracker, |reason| sink.report_rejected(reason));
        while let Some(emission) = self.emissions.pop_if(|emission| emission.time_ns <= time_ns) {
            if let Err(reason) = self.tracker.emission(&emission) {
                sink.emission_rejected(reason);
            }
        }
    }

    fn hand_out(&mut self, extrapolated: bool, sink: &mut impl TrackSink) {
        self.shown.sort_unstable_by_key(TrackReport::order);
        sink.tracks(&self.shown, extrapolated);
    }
}

impl Cueing {
    fn after(&mut self, scan: &SensorScan<'_>, tracker: &Tracker, sink: &mut impl TrackSink) {
        let Self { looks, sensors, cues } = self;
        let own = sensors.iter_mut().find(|sensor| sensor.sensor_id == scan.sensor_id);
        if let Some(sensor) = own {
            sensor.sigma_m = sigma_m(scan.detections, sensor.sigmas).unwrap_or(sensor.sigma_m);
        }
        looks.saw(scan.sensor_id, scan.time_ns);
        for look in looks.next(scan.time_ns) {
            let next = sensors.iter().find(|sensor| sensor.sensor_id == look.0);
            tracker.cues_at(look, next.map_or(0.0, |sensor| sensor.sigma_m), cues);
            sink.cues(scan.time_ns, cues);
        }
    }
}

impl CuedSensor {
    fn of(sensor: &tracking::settings::SensorFacts) -> Self {
        Self {
            sensor_id: sensor.sensor_id,
            sigmas: sensor.default_sigmas(),
            sigma_m: 0.0,
        }
    }
}
