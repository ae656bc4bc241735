//! The configuration of fusion on files: `[fusion]` as in a deployment, and what is known of each sensor.
//!
//! Somebody who has a file of sensor tracks knows neither the place of the sensors nor how often they report. So
//! nothing has to be configured: a first pass over the files tells which sensors there are, their period, how accurate
//! they say they are, and how many tracks live at a time; the engine's settings follow from that. What is known better
//! stands in a file:
//!
//! ```toml
//! [fusion.rule]
//! name = "best-source"
//!
//! [[sensor]]
//! id = 3                  # the sensor_id of the files
//! period_s = 4.0
//! position_m = [12e3, -3e3]
//! [sensor.accuracy]
//! sigma_m = 50.0
//! [sensor.coverage]       # else learned from the reports
//! range_m = 60e3
//! sector_deg = [300.0, 120.0]
//! probability = 0.9
//! ```

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use deployment::check_name;
use fusion_settings::{AccuracyModel, AccuracyTable, Settings, SourceSettings, Weighing};
use messages::admission::REACH_M;
use reception::PlausibilityLimits;
use settings::{Document, Seconds, SettingsError};

use super::ConfigError;
use super::checked::{Checked, limits};
use super::tables::FusionTable;

/// Period of a sensor that never reported a track twice, and has none configured, seconds.
const PERIOD_UNKNOWN_S: f64 = 1.0;
/// Accuracy of a sensor that has not said how accurate it is, metres.
const SIGMA_UNKNOWN_M: f64 = 20.0;
/// Room in tables: so many times what was seen, and so many entries more, up to the greatest number.
const ROOM_FACTOR: f64 = 1.25;
const ROOM_MORE: usize = 64;
const ROOM_MAX: usize = 200_000;

/// Facts about one sensor that a first pass over the files has found.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenSensor {
    /// The files' `sensor_id`.
    pub id: u32,
    /// Median time between two reports of one track, nanoseconds; `None` if no track was reported twice.
    pub period_ns: Option<i64>,
    /// Median standard deviation of the position (root mean square of east and north) that it states, metres.
    pub sigma_m: Option<f64>,
    /// Most tracks that lived at a time.
    pub tracks_max: usize,
}

/// Settings that the engine is built from.
#[derive(Clone, Debug)]
pub struct OfflineSettings {
    /// The files' `sensor_id` of each source.
    pub sensor_ids: Vec<u32>,
    /// The engine's settings.
    pub engine: Settings,
}

/// A configuration as read; an empty one says nothing.
#[derive(Debug, Default)]
pub struct Offline {
    path: PathBuf,
    text: String,
    raw: OfflineTable,
}

settings::settings! {
    /// A configuration of `koseki fuse`: what is not configured, a first pass over the files tells.
    pub(crate) struct OfflineTable {
        check OfflineTable::check;
        /// Fusion.
        fusion: FusionTable = FusionTable::default();
        /// Sensor with known facts.
        sensors as "sensor": Vec<OfflineSensorTable> = Vec::new();
    }

    /// Facts about a sensor.
    pub(crate) struct OfflineSensorTable with weighing: Weighing {
        check OfflineSensorTable::check;
        /// Number of the sensor in files.
        id: u32;
        /// Name, for messages and rules.
        name: Option<String> = None, usually "its id";
        /// East and north in the files' frame, for accuracies that depend on the distance.
        position_m: Option<[f64; 2]> = None;
        /// Limits of the sensor's reports: speed and, for a known position, distance from the sensor. Without a
        /// position, reports are at most 2,000 km from the origin of the frame.
        limits: PlausibilityLimits = PlausibilityLimits::default();
    }
}

impl OfflineTable {
    fn check(&self) -> Result<(), SettingsError> {
        let (mut ids, mut names) = (BTreeSet::new(), BTreeSet::new());
        for (index, sensor) in self.sensors.iter().enumerate() {
            let key = |part: &str| format!("sensor[{index}].{part}");
            if !ids.insert(sensor.id) {
                let what = format!("{} is the id of an earlier sensor; move its keys there", sensor.id);
                return Err(SettingsError::new(key("id"), what));
            }
            if let Some(name) = &sensor.name {
                check_name(&key("name"), name)?;
                if !names.insert(name) {
                    let what = format!("\"{name}\" is the name of an earlier sensor; give each its own");
                    return Err(SettingsError::new(key("name"), what));
                }
            }
        }
        Ok(())
    }
}

impl OfflineSensorTable {
    fn check(&self) -> Result<(), SettingsError> {
        if let Some(part) = self.needs_place().filter(|_| self.position_m.is_none()) {
            let what = "depends on where the sensor stands; give its position_m = [east, north]";
            return Err(SettingsError::new(part, what));
        }
        Ok(())
    }

    /// A key whose meaning depends on where the sensor stands.
    fn needs_place(&self) -> Option<&'static str> {
        let (accuracy, coverage) = (self.weighing.accuracy.as_ref(), self.weighing.coverage.as_ref());
        if accuracy.is_some_and(|accuracy| accuracy.model == AccuracyModel::Polar) {
            return Some("accuracy.model");
        }
        if coverage.is_some_and(|coverage| coverage.range_m.is_some()) {
            return Some("coverage.range_m");
        }
        coverage
            .is_some_and(|coverage| coverage.sector_deg.is_some())
            .then_some("coverage.sector_deg")
    }
}

impl Offline {
    /// Reads the text of `path`.
    ///
    /// # Errors
    /// [`ConfigError`] with file, line, key, value and remedy.
    pub fn parse(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let raw = super::read(path, text)?;
        Ok(Self {
            path: path.to_owned(),
            text: text.to_owned(),
            raw,
        })
    }

    /// The engine's settings for the sensors that were seen, in the order of their ids.
    ///
    /// # Errors
    /// [`ConfigError`] with file, line, key, value and remedy.
    pub fn settings(&self, seen: &[SeenSensor]) -> Result<OfflineSettings, ConfigError> {
        self.build(seen).map_err(|error| self.in_file(error))
    }

    /// Ids of the sensors for which the file states how accurate their positions are.
    pub fn accurate_sensors(&self) -> Vec<u32> {
        let is_accurate = |sensor: &&OfflineSensorTable| {
            let accuracy = sensor.weighing.accuracy.as_ref();
            accuracy.is_some_and(|accuracy| accuracy.model != AccuracyModel::Reported)
        };
        self.raw
            .sensors
            .iter()
            .filter(is_accurate)
            .map(|sensor| sensor.id)
            .collect()
    }

    /// Names of the sensors that have one, with their ids.
    pub fn named_sensors(&self) -> Vec<(String, u32)> {
        let sensors = self.raw.sensors.iter();
        sensors
            .filter_map(|sensor| Some((sensor.name.clone()?, sensor.id)))
            .collect()
    }

    fn in_file(&self, error: SettingsError) -> ConfigError {
        let located = Document::parse(&self.text, &[]).map(|document| document.located(error.clone()));
        super::in_file(&self.path, located.unwrap_or(error))
    }

    fn build(&self, seen: &[SeenSensor]) -> Checked<OfflineSettings> {
        let mut sources = Vec::new();
        for (place, sensor) in seen.iter().enumerate() {
            sources.push(self.source(place, sensor)?);
        }
        let engine = self.raw.fusion.engine.clone();
        let mut engine = engine.with_sources(sources).map_err(|error| error.under("fusion"))?;
        let room = room_for(seen.iter().map(|sensor| sensor.tracks_max).sum());
        engine.capacity.sensor_tracks.get_or_insert(room);
        engine.capacity.system_tracks.get_or_insert(room);
        Ok(OfflineSettings {
            sensor_ids: seen.iter().map(|sensor| sensor.id).collect(),
            engine,
        })
    }

    fn source(&self, place: usize, seen: &SeenSensor) -> Checked<SourceSettings> {
        let usual = OfflineSensorTable::default();
        let configured = self.raw.sensors.iter().position(|sensor| sensor.id == seen.id);
        let table = configured.map_or(&usual, |index| &self.raw.sensors[index]);
        let seen_s = seen.period_ns.map_or(PERIOD_UNKNOWN_S, |ns| Seconds::of_ns(ns).s());
        // What was seen cannot be refused; a sensor that reports a track once a day is of no use to the others.
        let period_s = table.weighing.period_s.unwrap_or(seen_s.clamp(1e-3, 3600.0));
        let name = table.name.clone().unwrap_or_else(|| seen.id.to_string());
        let stated = AccuracyTable {
            sigma_m: seen.sigma_m.unwrap_or(SIGMA_UNKNOWN_M).clamp(1e-3, 1e6),
            ..AccuracyTable::default()
        };
        let place_m = table.position_m.unwrap_or_default();
        let source = SourceSettings::new(&name, &table.weighing, (period_s, place as u32), place_m, &stated);
        let mut source = source.map_err(|error| error.under(&format!("sensor[{}]", configured.unwrap_or_default())))?;
        source.learns_period = false;
        let limits = limits(&table.limits, place_m);
        source.limits.speed_mps = limits.speed_mps;
        source.limits.range_m = REACH_M;
        if table.position_m.is_some() {
            source.place_m = table.position_m;
            source.limits = limits;
        }
        Ok(source)
    }
}

/// Room for `seen` tracks.
fn room_for(seen: usize) -> usize {
    ((seen as f64 * ROOM_FACTOR) as usize + ROOM_MORE).min(ROOM_MAX)
}
