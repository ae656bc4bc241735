//! One TOML file per deployment (PL-14): read, checked, and turned into the values the processes work with.
//!
//! Reading is strict. An unknown key, a value out of range, two sources of one name, a core the machine does not have:
//! each is refused with file, line, key, value and what would be right, before anything is started.

#![forbid(unsafe_code)]

mod check;
mod check_display;
mod check_link;
mod check_monitor;
mod check_network;
mod check_region;
mod locating;
mod offline;
mod reference;
mod tables;
mod tracker;
mod tracker_links;
mod wide_area_sensor;

use std::fmt;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use deployment::{Deployment, IN_INSTANCE};
use settings::{Document, SettingsError, Table, Value};
use sources::{Processing, TrackerSettings};
use tables::DeploymentTable;

pub use check_link::check_endpoint;
pub use locating::locating_settings;
pub use offline::{Offline, OfflineSettings, SeenSensor};
pub use reference::{locating_help, reference, sensor_help, tracking_help};
pub use tracker::{SeenDetections, Tracking};

/// Stands for the configuration of the demonstration, which is part of the executable.
pub const BUILT_IN_DEMO: &str = "built-in:demo";

/// Beginning of the lines at the end of [`Deployment::text`] that state replaced values.
const OVERRIDE: &str = "# --set ";

/// The configuration of the demonstration, as text.
pub const DEMO: &str = include_str!("../../../config/demo.toml");

/// A checked deployment, with the settings of its algorithms.
#[derive(Clone, Debug)]
pub struct Config {
    /// Facts for each process.
    pub deployment: Deployment,
    /// Settings of the fusion engine.
    pub engine: fusion::Settings,
    /// How each source's tracks come about, in the order of the sources' numbers.
    pub processing: Vec<Processing>,
}

impl Deref for Config {
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
fn read<T: Table + Value + Default>(path: &Path, text: &str) -> Result<T, ConfigError> {
    let read = Document::parse(text, &[]).and_then(|document| document.read());
    read.map_err(|error| in_file(path, error))
}

fn in_file(path: &Path, error: SettingsError) -> ConfigError {
    ConfigError {
        file: path.to_owned(),
        error,
    }
}

impl Config {
    /// Reads and checks `path`; each of `overrides` (`key.path=value`, the value in TOML) replaces a value of the file.
    ///
    /// # Errors
    /// [`ConfigError`] with file, line, key, value and remedy.
    pub fn read(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        if path == Path::new(BUILT_IN_DEMO) {
            return Self::parse(path, DEMO, overrides);
        }
        let text = std::fs::read_to_string(path)
            .map_err(|error| in_file(path, SettingsError::new("", format!("cannot be read: {error}"))))?;
        Self::parse(path, &text, overrides)
    }

    /// As [`Config::read`], from the file's text.
    ///
    /// # Errors
    /// As [`Config::read`].
    pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<Self, ConfigError> {
        let document = Document::parse(text, overrides).map_err(|error| in_file(path, error))?;
        let checked = document
            .read::<DeploymentTable>()
            .and_then(|table| check::check(path, table));
        let mut config = checked.map_err(|error| in_file(path, document.located(error)))?;
        let whole = &mut config.deployment.text;
        text.clone_into(whole);
        whole.extend(overrides.iter().map(|each| format!("\n{OVERRIDE}{each}")));
        Ok(config)
    }

    /// As [`Config::parse`], from a [`Deployment::text`], which ends with the replaced values: that of a recording, or of
    /// a running instance.
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
        let text = std::fs::read_to_string(&path)
            .map_err(|error| in_file(&path, SettingsError::new("", format!("cannot be read: {error}"))))?;
        Self::parse_whole(&path, &text)
    }

    /// Whether a file's text describes a deployment, rightly or wrongly; else it may be an [`Offline`] configuration.
    pub fn is_deployment(text: &str) -> bool {
        let keys = ["name", "frame", "source"];
        Document::parse(text, &[]).is_ok_and(|document| keys.iter().any(|key| document.has(key)))
    }

    /// Settings of the tracker of source `number`, if its tracks are made of its detections.
    pub fn tracker(&self, number: u16) -> Option<&TrackerSettings> {
        self.processing[usize::from(number)].tracker()
    }

    /// Settings of the locator of source `number`, if its tracks are made of its bearings.
    pub fn locator(&self, number: u16) -> Option<&::locating::Settings> {
        self.processing[usize::from(number)].locator()
    }
}

#[cfg(test)]
mod tests;
