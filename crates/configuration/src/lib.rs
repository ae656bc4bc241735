//! One TOML file per deployment (PL-14): read, checked, and turned into the values the processes work with.
//!
//! Reading is strict. An unknown key, a value out of range, two sources of one name, a core the machine does not have:
//! each is refused with file, line, key, value and what would be right, before anything is started.

#![forbid(unsafe_code)]

mod check;
mod check_network;
mod check_qnh;
mod check_region;
mod check_source;
mod checked;
mod external_detections;
mod finder_on_board;
mod locating;
mod offline;
mod platform;
mod reference;
mod tables;
mod tracker;
mod tracker_links;
mod tracker_process;
mod wide_area_sensor;
mod words;

use std::fmt;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use alerts::AlertRules;
use checked::Checked;
use deployment::{Deployment, IN_INSTANCE, Parts, Source};
use scenario::World;
use settings::{Document, KeyTable, KeyValue, SettingsError, Shared};
use sources::{Readings, SourceReading, TrackerSettings};
use tables::DeploymentTable;

pub use check::day_ns;
pub use locating::locating_settings;
pub use offline::{Offline, OfflineSettings, SeenSensor};
pub use reference::{locating_help, reference, sensor_help, tracking_help};
pub use tracker::{SeenDetections, Tracking};

/// Stands for the configuration of the demonstration, which is part of the executable.
pub const BUILT_IN_DEMO: &str = "built-in:demo";

/// Stands for the configuration of `koseki torture`, which is part of the executable: that of the demonstration with a
/// direction finder.
pub const BUILT_IN_TORTURE: &str = "built-in:torture";

/// Beginning of the lines at the end of [`Deployment::text`] that state replaced values.
const OVERRIDE: &str = "# --set ";

/// The configuration of the demonstration, as text.
pub const DEMO: &str = include_str!("../../../config/demo.toml");

/// The configuration of `koseki torture`, as text.
const TORTURE: &str = concat!(include_str!("../../../config/demo.toml"), include_str!("torture.toml"));

/// A checked deployment, with the settings of its algorithms, and without those of services.
pub type Config = ConfigWith<()>;

/// A checked deployment, with the settings of its algorithms and of the services `P`.
#[derive(Clone, Debug)]
pub struct ConfigWith<P> {
    /// Facts for each process.
    pub deployment: Deployment,
    /// Settings of the fusion engine.
    pub engine: fusion_settings::Settings,
    /// How adapters read what the deployment's sensors send.
    pub readings: Readings,
    /// The simulated world, and what observes it.
    pub world: World,
    /// Rules of alerts on targets, and their areas.
    pub alerts: AlertRules,
    /// Settings of services.
    pub parts: P,
}

impl<P> Deref for ConfigWith<P> {
    type Target = Deployment;

    fn deref(&self) -> &Deployment {
        &self.deployment
    }
}

/// A configuration that cannot be used: its file, and what is wrong in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// The file.
    pub file: PathBuf,
    /// Line, key, value and remedy.
    pub error: SettingsError,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.error.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}", self.error)
    }
}

impl std::error::Error for ConfigError {}

/// Reads the text of `path` as a table `T`.
fn read<T: KeyTable + KeyValue + Default>(path: &Path, text: &str) -> Result<T, ConfigError> {
    let read = Document::parse(text, &[]).and_then(|document| document.read());
    read.map_err(|error| in_file(path, error))
}

fn in_file(path: &Path, error: SettingsError) -> ConfigError {
    ConfigError {
        file: path.to_owned(),
        error,
    }
}

/// Reads the text of the configuration in the file `path`.
///
/// # Errors
/// If the file cannot be read; the message names the file of that name in the folder `config`, if it is there.
pub fn text(path: &Path) -> Result<String, ConfigError> {
    std::fs::read_to_string(path).map_err(|error| {
        let shipped = Path::new("config").join(path);
        let is_meant = error.kind() == std::io::ErrorKind::NotFound && path.is_relative() && shipped.is_file();
        let meant = if is_meant {
            format!("; did you mean {}?", shipped.display())
        } else {
            String::new()
        };
        let what = match error.kind() {
            std::io::ErrorKind::InvalidData => "is no text in UTF-8".to_owned(),
            _ => format!("cannot be read: {error}{meant}"),
        };
        in_file(path, SettingsError::new("", what))
    })
}

/// Reads a deployment, of which `services` have read their tables then.
fn read_deployment(
    path: &Path,
    document: &Document<'_>,
    services: Vec<&mut dyn KeyTable>,
) -> Checked<check::CheckedDeployment> {
    let mut table = DeploymentTable::default();
    let read = document.read_into(&mut Shared::new(&mut table, services));
    read.map_err(with_place_of_sensors)?;
    check::check(path, table)
}

/// Adds to an unknown key like `sensor`, which the files of commands on tables have, what it is in a deployment.
fn with_place_of_sensors(mut error: SettingsError) -> SettingsError {
    if error.what.starts_with("unknown key") && settings::nearest(&error.key, &["sensor"]).is_some() {
        error.what.push_str("; a sensor of a deployment is a [[source]]");
    }
    error
}

impl<P: Parts> ConfigWith<P> {
    /// Reads and checks `path`; each of `overrides` (`key.path=value`, the value in TOML) replaces a value of the file.
    ///
    /// # Errors
    /// [`ConfigError`] with file, line, key, value and remedy.
    pub fn read(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        if path == Path::new(BUILT_IN_DEMO) {
            return Self::parse(path, DEMO, overrides);
        }
        if path == Path::new(BUILT_IN_TORTURE) {
            return Self::parse(path, TORTURE, overrides);
        }
        Self::parse(path, &text(path)?, overrides)
    }

    /// As [`Config::read`], from the file's text.
    ///
    /// # Errors
    /// As [`Config::read`].
    pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<Self, ConfigError> {
        let mut parts = P::default();
        let document = Document::parse(text, overrides).map_err(|error| in_file(path, error))?;
        let located = |error| in_file(path, document.located(error));
        let read = read_deployment(path, &document, parts.tables());
        let check::CheckedDeployment {
            mut deployment,
            engine,
            readings,
            world,
            alerts,
        } = read.map_err(located)?;
        parts.join(&mut deployment).map_err(located)?;
        let whole = &mut deployment.text;
        text.clone_into(whole);
        whole.extend(overrides.iter().map(|each| format!("\n{OVERRIDE}{each}")));
        Ok(Self {
            deployment,
            engine,
            readings,
            world,
            alerts,
            parts,
        })
    }

    /// As [`Config::parse`], from a [`Deployment::text`], which ends with the replaced values: that of a recording, or
    /// of a running instance.
    ///
    /// # Errors
    /// As [`Config::read`].
    pub fn parse_whole(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let overrides = text.lines().rev().map_while(|line| line.strip_prefix(OVERRIDE));
        let mut overrides: Vec<String> = overrides.map(str::to_owned).collect();
        overrides.reverse();
        Self::parse(path, text, &overrides)
    }

    /// Reads the configuration of the running instance in the folder `instance`.
    ///
    /// # Errors
    /// As [`Config::read`].
    pub fn of_running(instance: &Path) -> Result<Self, ConfigError> {
        let path = instance.join(IN_INSTANCE);
        Self::parse_whole(&path, &text(&path)?)
    }

    /// The same without the settings of services.
    pub fn without_services(self) -> Config {
        ConfigWith {
            deployment: self.deployment,
            engine: self.engine,
            readings: self.readings,
            world: self.world,
            alerts: self.alerts,
            parts: (),
        }
    }
}

impl Config {
    /// Whether a file's text describes a deployment, rightly or wrongly; else it may be an [`Offline`] configuration.
    pub fn is_deployment(text: &str) -> bool {
        let keys = ["name", "frame", "source"];
        Document::parse(text, &[]).is_ok_and(|document| keys.iter().any(|key| document.has(key)))
    }
}

impl<P> ConfigWith<P> {
    /// How the data of a source or of a tracker's sensor are read.
    pub fn reading(&self, source: &Source) -> &SourceReading {
        &self.readings.sources[usize::from(source.number)]
    }

    /// Settings of the tracker of source `number`, if its tracks are made of its detections.
    pub fn tracker(&self, number: u16) -> Option<&TrackerSettings> {
        self.readings.sources[usize::from(number)].processing.tracker()
    }

    /// Settings of the tracker process whose sensors have all of these ids in files.
    pub fn tracker_of(&self, sensor_ids: &std::collections::BTreeSet<u32>) -> Option<&TrackerSettings> {
        let readings = self.readings.sources.iter();
        let trackers = readings.filter_map(|reading| reading.processing.tracker());
        let has_all = |tracker: &&TrackerSettings| {
            let own = tracker.sensor_ids();
            tracker.events && sensor_ids.iter().all(|id| own.contains(id))
        };
        trackers.into_iter().find(has_all)
    }

    /// Settings of the locator of source `number`, if its tracks are made of its bearings.
    pub fn locator(&self, number: u16) -> Option<&::locating::Settings> {
        self.readings.sources[usize::from(number)].processing.locator()
    }
}

#[cfg(test)]
mod tests;
