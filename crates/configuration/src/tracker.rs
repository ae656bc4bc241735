//! Trackers: that of `koseki track`, and those of sources.
//!
//! Offline, everything in the file may be left out: a pass over the detections tells which sensors there are and how
//! large their scans are. Live, the same tables stand in `[source.tracker]`, where the one sensor is the source.

use std::collections::BTreeSet;
use std::path::Path;

use platform::OfflinePlatform;
use settings::{Seconds, SettingsError};
use sources::joining::JoiningSettings;
use sources::{Outputs, TrackerSettings};
use tracking::cutting::{CutterSettings, PERIOD_MIN_NS};
use tracking::settings::{ROOM_MAX, SensorFacts, Settings};

use super::ConfigError;
use super::tables::SourceTrackerTable;

/// Room for tracks, where nobody says more: so many times the detections of the largest scan.
const TRACKS_PER_DETECTION: usize = 6;
/// Room for detections that wait for their scan to be complete: so many times that of a scan.
pub(crate) const WAITING_SCANS: usize = 2;

/// A configuration of `koseki track`; an empty one says nothing.
#[derive(Debug, Default)]
pub struct Tracking {
    table: TrackingTable,
}

settings::settings! {
    /// A configuration of `koseki track`.
    pub(crate) struct TrackingTable with tracker: Settings {
        /// Platform of the sensors, with `--platform`.
        platform: OfflinePlatform = OfflinePlatform::default();
    }
}

/// Facts that files of detections tell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SeenDetections {
    /// Every `sensor_id`.
    pub sensor_ids: BTreeSet<u32>,
    /// Detections of the largest scan.
    pub scan_max: usize,
}

impl Tracking {
    /// Reads the text of `path`.
    ///
    /// # Errors
    /// [`ConfigError`] with file, line, key, value and remedy.
    pub fn parse(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let table = super::read(path, text)?;
        Ok(Self { table })
    }

    /// The platform of the sensors.
    pub fn platform(&self) -> &OfflinePlatform {
        &self.table.platform
    }

    /// Standard deviations of a sensor's detections that state none.
    pub fn sigmas(&self, sensor_id: u32) -> Option<[f64; 4]> {
        let mut sensors = self.table.tracker.sensors.iter();
        sensors.find(|sensor| sensor.sensor_id == sensor_id)?.default_sigmas()
    }

    /// The tracker's settings for what the files hold; sensors and sizes that are not configured are as usual.
    pub fn settings(&self, seen: &SeenDetections) -> Settings {
        let mut settings = self.table.tracker.clone();
        let room = &mut settings.capacity;
        let more = |usual: usize, seen: usize| usual.max(seen.min(ROOM_MAX));
        room.detections = Some(
            room.detections
                .unwrap_or_else(|| more(room.detections(), seen.scan_max)),
        );
        let tracks_seen = TRACKS_PER_DETECTION * seen.scan_max;
        room.tracks = Some(room.tracks.unwrap_or_else(|| more(room.tracks(), tracks_seen)));
        let known: BTreeSet<u32> = settings.sensors.iter().map(|sensor| sensor.sensor_id).collect();
        settings
            .sensors
            .extend(seen.sensor_ids.difference(&known).map(|sensor_id| SensorFacts {
                sensor_id: *sensor_id,
                ..SensorFacts::default()
            }));
        settings.sensors.sort_unstable_by_key(|sensor| sensor.sensor_id);
        settings
    }
}

/// The tracker of the source numbered `number`, which looks around once in `period_s`, if that is configured. Its links
/// are found when all sources and sensors are known.
pub(crate) fn source_tracker(
    table: &SourceTrackerTable,
    number: u16,
    period_s: Option<f64>,
) -> Result<TrackerSettings, SettingsError> {
    let period_ns = period_s.map(|period_s| Seconds::of(period_s).ns());
    if let Some(period_s) = period_s.filter(|_| period_ns < Some(PERIOD_MIN_NS)) {
        let what = format!("{period_s} is too short for a tracker, whose scans take 0.0625 s at least");
        return Err(SettingsError::new(format!("source[{number}].period_s"), what));
    }
    let mut settings = table.tracker.clone();
    settings.sensors = vec![SensorFacts {
        sensor_id: observations::sensor_id(number),
        model: table.model,
        ..SensorFacts::default()
    }];
    Ok(TrackerSettings {
        joining: JoiningSettings {
            cutters: vec![CutterSettings {
                boundaries: table.scans,
                period_ns,
                wait_ns: table.wait_s.map(|wait_s| Seconds::of(wait_s).ns()),
                waiting_max: WAITING_SCANS * settings.capacity.detections(),
                epoch_ns: 0,
            }],
            wait_ns: 0,
        },
        events: false,
        platform: None,
        settings,
        outputs: Outputs {
            period_ns: table.output_period_s.map(Seconds::ns),
            cues: table.cues,
        },
    })
}

#[cfg(test)]
#[path = "tracker_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "wide_area_tests.rs"]
mod wide_area_tests;
