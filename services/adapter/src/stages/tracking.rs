//! Tracks of a sensor that delivers detections: cut into scans, and each scan through the tracker (HT, SP).
//!
//! Detections wait until their scan is complete ([`::tracking::cutting`]), which is decided by times of the data alone.
//! Then they are published with the scan's number, and after them every confirmed track as it is after the scan, in the
//! order of times. Numbers of scans that are left out are scans without detections, which the tracker is told of as soon as the
//! next scan is complete. `koseki track` does all of this with the recorded detections again and comes to the same tracks.
//!
//! Where tracks are wanted at even times instead (WA-11), all confirmed ones are moved to each such time as soon as the data have
//! come to it. Those of a picture that no scan has come before since the last one are marked as coasted: they are the tracker's own
//! extrapolation and no observation, and fusion takes them for that.
//!
//! Reports of wide-area sensors wait until the scans have come to their arrival, as in `koseki track`. A live one that comes when
//! that scan has been worked off is counted, and used in the next.
//!
//! A track has come in, as far as the stages of its journey are concerned, when the datagram did that completed its scan. How
//! old it is by then shows in the age of the data.
//!
//! Numbers of scans and tracks begin with a number that depends on the time ([`::tracking::cutting`]), so that an adapter
//! that was restarted, and knows nothing of the tracks before, does not give their numbers to other targets.

use anyhow::Context as _;
use configuration::{Source, SourceTracker};
use messages::{Counter, Counters, SensorBearing, StageTimes, TrackState, sensor_bearing_bits};
use observations::{Detection, Sampled, WideAreaReport};
use tracking::cutting::{CutScan, Cutter, CutterSettings, Taken};
use tracking::scans::silent_times_ns;
use tracking::wide_area::Emission;
use tracking::wide_area::arrivals::Arrivals;
use tracking::wide_area::cue::{Cue, Looks, sigma_m};
use tracking::wide_area::schedule::Schedule;
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
    /// Emissions without a frequency.
    emissions_refused: u64,
    /// Where tracks come at even times instead of after each scan.
    pictures: Option<Pictures>,
    /// Where the sensor is told where to look next.
    cueing: Option<Cueing>,
}

/// Tracks at even times (WA-11).
#[derive(Debug)]
struct Pictures {
    schedule: Schedule,
    /// Time of the latest picture.
    shown_ns: i64,
    /// Scans that had been worked off by then.
    scans: u64,
}

/// Where to look next (WA-12).
#[derive(Debug)]
struct Cueing {
    looks: Looks,
    /// Standard deviation of the detections' places when there were any last, metres.
    sigma_m: f64,
    cues: Vec<Cue>,
    said: u64,
}

impl Tracking {
    /// Scan numbers count from `epoch_ns` (UTC, nanoseconds).
    pub(super) fn new(
        source: &Source,
        tracker: &SourceTracker,
        epoch_ns: i64,
        counts: Arrivals,
    ) -> anyhow::Result<Self> {
        let settings = &tracker.settings;
        let sensor = settings.sensors.first().context("a tracker needs a sensor")?;
        let pictures = |period_ns| Pictures {
            schedule: Schedule::new(period_ns),
            shown_ns: i64::MIN,
            scans: 0,
        };
        let cueing = || Cueing {
            looks: Looks::of([sensor.sensor_id].into_iter()),
            sigma_m: 0.0,
            cues: Vec::with_capacity(settings.capacity.tracks),
            said: 0,
        };
        Ok(Self {
            pictures: tracker.output_period_ns.map(pictures),
            cueing: tracker.cues.then(cueing),
            source: source.number,
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
            emissions_refused: 0,
        })
    }

    pub(super) fn take(&mut self, detection: Detection, ingested_ns: i64, made: &mut Made) {
        self.ingested_ns = ingested_ns;
        let time_ns = detection.time_of_measurement_ns;
        match self.cutter.take(detection, ingested_ns) {
            Taken::Waits => {
                self.work_off(made);
                self.show(time_ns, made);
            }
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

    /// Takes a bearing of a direction finder. What has a frequency is an emission, and may tell who a track is (WA-9).
    pub(super) fn emission(&mut self, bearing: &SensorBearing) {
        use sensor_bearing_bits::{FREQUENCY, PULSE_INTERVAL};
        let has = |bit: u16| bearing.valid & bit != 0;
        if !has(FREQUENCY) {
            self.emissions_refused += 1;
            return;
        }
        // What the tracker refuses it counts.
        let _ = self.tracker.emission(&Emission {
            time_ns: bearing.time_of_measurement_ns,
            bearing_rad: bearing.bearing_rad,
            sigma_rad: bearing.sigma_rad,
            platform_m: [bearing.platform_m[0], bearing.platform_m[1]],
            frequency_hz: bearing.frequency_hz,
            pulse_interval_s: has(PULSE_INTERVAL).then_some(bearing.pulse_interval_s),
        });
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
        self.show(time_ns, made);
    }

    pub(super) fn end(&mut self, made: &mut Made) {
        while let Some(scan) = self.cutter.last_scan() {
            self.scan(scan, made);
        }
    }

    /// Time of the latest scan, or of the latest picture where there are some: no later track is older.
    pub(super) fn progress_ns(&self) -> i64 {
        match &self.pictures {
            Some(pictures) => pictures.shown_ns,
            None => self.latest.map_or(i64::MIN, |(_, time_ns)| time_ns),
        }
    }

    pub(super) fn count(&self, counters: &mut Counters) {
        let counts = self.tracker.counts();
        counters[Counter::Detections] = self.detections;
        counters[Counter::RejectedLate] += self.late;
        counters[Counter::Reports] -= self.late + self.refused;
        counters[Counter::DetectionsRejected] =
            self.refused + counts.unusable_detections + counts.crowded_out_detections;
        counters[Counter::TracksDropped] += counts.refused_tracks;
        counters[Counter::Scans] = self.scans;
        counters[Counter::WideAreaReports] = counts.wide_area_reports;
        counters[Counter::WideAreaRejected] = counts.wide_area_reports_refused + self.counts_refused;
        counters[Counter::WideAreaLate] = self.counts_late;
        counters[Counter::WideAreaUsed] = counts.wide_area_reports_used;
        counters[Counter::WideAreaUnmatched] = counts.wide_area_reports_unmatched;
        counters[Counter::Emissions] = counts.emissions;
        counters[Counter::EmissionsRejected] = counts.emissions_refused + self.emissions_refused;
        counters[Counter::EmissionsUnclear] = counts.emissions_unclear;
        counters[Counter::Cues] = self.cueing.as_ref().map_or(0, |cueing| cueing.said);
    }

    fn work_off(&mut self, made: &mut Made) {
        while let Some(scan) = self.cutter.next_scan() {
            self.scan(scan, made);
        }
    }

    fn scan(&mut self, scan: CutScan, made: &mut Made) {
        for (detection, ingested_ns) in self.cutter.detections().iter().zip(self.cutter.with_them()) {
            self.detections += 1;
            let stages = StageTimes {
                ingested_ns: *ingested_ns,
                ..StageTimes::default()
            };
            made.detections.push(detection.sample(self.source, stages));
        }
        let now = (scan.number, scan.time_ns);
        match self.latest {
            None => self.tracker.number_from(scan.number),
            Some(before) => {
                for time_ns in silent_times_ns(before, now) {
                    self.show(time_ns - 1, made);
                    self.counts.give(time_ns, &mut self.tracker, |_| ());
                    let taken = self.tracker.scan(self.sensor_id, time_ns, &[]);
                    self.publish(taken.is_ok(), made);
                }
            }
        }
        // What is shown of a time has heard no later scan.
        self.show(scan.time_ns - 1, made);
        self.counts.give(scan.time_ns, &mut self.tracker, |_| ());
        let taken = self
            .tracker
            .scan(self.sensor_id, scan.time_ns, self.cutter.detections());
        self.publish(taken.is_ok(), made);
        self.latest = Some(now);
        self.cue(scan.time_ns, made);
    }

    fn publish(&mut self, is_taken: bool, made: &mut Made) {
        // A scan at the very time of the one before, of a sensor whose clock stands still, may be refused: the tracker counts.
        if !is_taken {
            return;
        }
        self.scans += 1;
        if self.pictures.is_some() {
            return;
        }
        self.reports.clear();
        self.reports.extend_from_slice(self.tracker.tracks());
        self.hand_out(false, made);
    }

    /// Publishes the tracks of each even time that the data have come to.
    fn show(&mut self, until_ns: i64, made: &mut Made) {
        while let Some(pictures) = &mut self.pictures
            && let Some(time_ns) = pictures.schedule.next(until_ns)
        {
            // What no scan has been heard of since the picture before is the tracker's own extrapolation.
            let extrapolated = pictures.scans == self.scans;
            (pictures.shown_ns, pictures.scans) = (time_ns, self.scans);
            self.tracker.picture_at(time_ns, &mut self.reports);
            self.hand_out(extrapolated, made);
        }
    }

    /// Says where the sensor should look next, as long after its latest scan as that came after the one before.
    fn cue(&mut self, time_ns: i64, made: &mut Made) {
        let Some(cueing) = &mut self.cueing else { return };
        cueing.sigma_m = sigma_m(self.cutter.detections(), None).unwrap_or(cueing.sigma_m);
        cueing.looks.saw(self.sensor_id, time_ns);
        let Some(look) = cueing.looks.next().next() else { return };
        self.tracker.cues_at(look, cueing.sigma_m, &mut cueing.cues);
        cueing.said += cueing.cues.len() as u64;
        made.cues.extend(cueing.cues.iter().map(|cue| messages::Cue {
            time_ns: cue.time_ns,
            stages: StageTimes {
                ingested_ns: self.ingested_ns,
                ..StageTimes::default()
            },
            position_m: cue.position_m,
            velocity_mps: cue.velocity_mps,
            half_axes_m: cue.half_axes_m,
            orientation_rad: cue.orientation_rad,
            track_number: cue.track_number,
            source: self.source,
            ..messages::Cue::default()
        }));
    }

    fn hand_out(&mut self, extrapolated: bool, made: &mut Made) {
        self.reports.sort_unstable_by_key(TrackReport::order);
        for report in &self.reports {
            let mut track = report.sensor_track(self.source);
            track.stages.ingested_ns = self.ingested_ns;
            if extrapolated {
                track.state = TrackState::Coasted as u8;
            }
            made.tracks.push(track);
        }
    }
}

#[cfg(test)]
#[path = "tracking_tests.rs"]
mod tests;
