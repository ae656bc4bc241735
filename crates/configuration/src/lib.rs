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
mod deployment;
mod link;
mod locating;
mod network;
mod observed;
mod offline;
mod reference;
mod tables;
mod tracker;
mod tracker_links;
mod wide_area_sensor;

use std::fmt;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bus::WaitMode;
use frames::SystemFrame;
use fusion::settings as engine;
use outgoing::Technology;
use reception::SourceModel;
use telemetry::Deadlines;

use check_display::TOKEN_MIN;
use runtime::cores::Placement;
use settings::{Document, SettingsError, Table, Value};
use sources::{Processing, TrackerSettings};
use tables::DeploymentTable;

pub use check_link::check_endpoint;
pub use link::{Link, LinkPeer, LinkTls, RemoteTopic};
pub use locating::locating_settings;
pub use network::{Area, Asterix, Gateway, GatewayContent, Live, Receiver, Transport};
pub use offline::{Offline, OfflineSettings, SeenSensor};
pub use reference::{locating_help, reference, sensor_help, tracking_help};
pub use tracker::{SeenDetections, Tracking};
pub use wide_area_sensor::{CountedTracks, TrackFeed, WideAreaInput, WideAreaSensor};

/// One process of a deployment, connected and ready.
pub type Process = runtime::Process<Config>;

/// Stands for the configuration of the demonstration, which is part of the executable.
pub const BUILT_IN_DEMO: &str = "built-in:demo";

/// Beginning of the lines at the end of [`Config::text`] that state replaced values.
const OVERRIDE: &str = "# --set ";

/// File in the folder of a running instance that contains its [`Config::text`].
const IN_INSTANCE: &str = "configuration.toml";

/// File in the folder of a running instance with the names of its sources, a line each.
const SOURCES_IN_INSTANCE: &str = "sources";

/// The configuration of the demonstration, as text.
pub const DEMO: &str = include_str!("../../../config/demo.toml");

/// A checked deployment.
#[derive(Clone, Debug)]
pub struct Config {
    /// Name of the deployment.
    pub name: String,
    /// Number of the deployment among those that exchange tracks; 0: none.
    pub origin: u32,
    /// File it was read from.
    pub path: PathBuf,
    /// Text of the file; values that replace some of its stand in comments at the end.
    pub text: String,
    /// The system frame.
    pub frame: SystemFrame,
    /// Order in which fusion works (PL-12).
    pub order: ReportOrder,
    /// Midnight of the recordings' first day, UTC, nanoseconds; `None` without recordings.
    pub first_day_ns: Option<i64>,
    /// The sources, in the order of their numbers.
    pub sources: Vec<Source>,
    /// The wide-area sensors, in the order of their numbers; they are no sources.
    pub wide_area_sensors: Vec<WideAreaSensor>,
    /// The network inputs; each is an adapter process.
    pub receivers: Vec<Receiver>,
    /// The outputs to the network; each is a gateway process.
    pub gateways: Vec<Gateway>,
    /// The links to deployments on other hosts; each is a process.
    pub links: Vec<Link>,
    /// Copies on disk of what outlasts the processes; `None` if there are none.
    pub durable: Option<Durable>,
    /// The simulated world, if there are simulated sources.
    pub scenario: Option<scenario::ScenarioSettings>,
    /// The fusion process.
    pub fusion: Fusion,
    /// The monitor process.
    pub monitor: Monitor,
    /// The display process, if there is one.
    pub display: Option<Display>,
    /// Whether a recorder runs.
    pub recorder: bool,
    /// Forms of the recording.
    pub recording: Recording,
    /// A process that does not move for so long is replaced.
    pub watchdog: Duration,
}

/// Forms of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Recording {
    /// Whether rows of text are written.
    pub csv: bool,
    /// Containers of all topics, if they are written.
    pub mcap: Option<Segments>,
    /// Captures of what live sources send, if adapters write them.
    pub captures: Option<Segments>,
}

/// Containers or captures, one after another.
#[derive(Clone, Copy, Debug)]
pub struct Segments {
    /// Time after which they are written to, nanoseconds.
    pub flush_ns: i64,
    /// Size at which another is begun.
    pub bytes: u64,
    /// Time after which another is begun, nanoseconds.
    pub length_ns: i64,
    /// Size of all beyond which the oldest are deleted; `None` keeps all.
    pub keep_bytes: Option<u64>,
}

settings::words! {
    /// Order in which fusion takes reports.
    pub enum ReportOrder {
        /// As they arrive: lowest latency.
        Arrival = "arrival",
        /// By time of measurement, merged with each source's progress: the result does not depend on scheduling.
        Time = "time",
    }
}

/// One source.
#[derive(Clone, Debug)]
pub struct Source {
    /// Its number: its place in the file, from 0.
    pub number: u16,
    /// Identity of the sensor, the same in every deployment that hears it.
    pub uid: u32,
    /// Its name, which is also part of its topic's name.
    pub name: String,
    /// Where its data come from.
    pub input: Input,
    /// Name of the adapter process that publishes it: that of its receiver, or its own.
    pub adapter: String,
    /// How it observes.
    pub technology: Technology,
    /// Where it stands, what its reports may contain, and how accurate they are.
    pub model: SourceModel,
    /// How its tracks come about.
    pub processing: Processing,
    /// Other sources that its tracker listens to.
    pub links: Links,
    /// Silence of its adapter's input that is an alarm, nanoseconds; `None` if none is. Nothing is expected of a
    /// recording.
    pub silent_after_ns: Option<i64>,
    /// Time between two reports of one target, nanoseconds.
    pub period_ns: i64,
    /// Whether the deployment ends where its adapter cannot be kept running.
    pub required: bool,
}

/// Sources that a source's tracker listens to besides its own detections.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Links {
    /// Numbers of the wide-area sensors, ascending.
    pub wide_area_sensors: Vec<u16>,
    /// Numbers of the sources, direction finders, whose emissions it hears, ascending.
    pub emissions: Vec<u16>,
}

impl Source {
    /// Settings of its tracker, if its tracks are made of its detections.
    pub fn tracker(&self) -> Option<&TrackerSettings> {
        self.processing.tracker()
    }

    /// Whether its sensor tracks reach fusion as they come, checked by no adapter.
    pub fn is_taken_as_it_is(&self) -> bool {
        match &self.input {
            Input::External => true,
            Input::Recorded(recorded) => recorded.format == RecordedFormat::SensorTracks,
            Input::Simulated(_) | Input::Live(_) => false,
        }
    }

    /// Settings of its locator, if its tracks are made of its bearings.
    pub fn locator(&self) -> Option<&::locating::Settings> {
        self.processing.locator()
    }
}

/// Where a source's data come from.
#[derive(Clone, Debug)]
pub enum Input {
    /// A recording.
    Recorded(Recorded),
    /// A simulated sensor, whose reports come over the loopback network like those of a real one.
    Simulated(Simulated),
    /// A sensor behind a receiver.
    Live(Live),
    /// A process that is no part of the deployment publishes the source's topic.
    External,
}

/// A simulated input.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// Simulated instrument that it observes with.
    pub instrument: Instrument,
    /// How what it sends is received.
    pub live: Live,
}

/// Instrument of a simulated source.
#[derive(Clone, Debug)]
pub enum Instrument {
    /// A sensor that tracks what it sees.
    Sensor(Box<scenario::SensorSettings>),
    /// A direction finder, whose bearings its adapter locates.
    DirectionFinder(Box<scenario::DirectionFinderSettings>),
}

/// A recorded input.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// File, relative to the data folder unless absolute.
    pub file: PathBuf,
    /// Content of the file.
    pub format: RecordedFormat,
    /// How its ASTERIX records are read.
    pub asterix: Asterix,
    /// How far reports may come out of order, nanoseconds.
    pub reorder_ns: i64,
    /// Whether the file may end in the middle of a data block.
    pub truncated: Truncated,
}

settings::words! {
    /// Content of a recorded file.
    pub enum RecordedFormat {
        /// ASTERIX, as bare data blocks or in a capture file.
        Asterix = "asterix",
        /// Lines of SBS-1 (BaseStation).
        Sbs = "sbs",
        /// A table of sensor tracks (FM-5).
        SensorTracks = "sensor-tracks",
    }
}

settings::words! {
    /// Use of a recording that ends within a data block, after a kill of the recorder or an incomplete copy.
    pub enum Truncated {
        /// Refuse it before anything starts: more than one block may be missing.
        Refuse = "refuse",
        /// Use it without its last block.
        Accept = "accept",
    }
}

/// The fusion process.
#[derive(Clone, Debug)]
pub struct Fusion {
    /// The engine's settings.
    pub settings: engine::Settings,
    /// How it waits for work.
    pub wait: WaitMode,
    /// Demands on the machine: core, priority, memory.
    pub placement: Placement,
    /// Whether a refusal of that is an error.
    pub required: bool,
    /// Whether a thread that spins with `SCHED_FIFO` pauses often enough that the kernel does not make it.
    pub rests: bool,
    /// Memory that outlasts the process; `None` if there is none.
    pub checkpoint: Option<Checkpoint>,
    /// The process that stands by; `None` if none does.
    pub standby: Option<Standby>,
    /// Whether decisions are published.
    pub decisions: bool,
    /// Reports that wait per source in order `time`.
    pub queue: usize,
    /// A report that takes longer through fusion has missed its deadline, nanoseconds.
    pub deadline_ns: i64,
}

/// Copies on disk of what outlasts the processes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Durable {
    /// Folder for them.
    pub folder: PathBuf,
    /// Time between two copies.
    pub every: Duration,
}

/// Memory of fusion for its successor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checkpoint {
    /// Age beyond which its tracks are not gone on with, nanoseconds.
    pub max_age_ns: i64,
}

impl Config {
    /// The fusion that stands by; none where recordings are replayed.
    pub fn standby(&self) -> Option<Standby> {
        self.fusion.standby.filter(|_| !self.is_recorded())
    }
}

/// A fusion that stands by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standby {
    /// Core to run on.
    pub core: Option<usize>,
    /// Time for which the other one may stand still, nanoseconds.
    pub takeover_ns: i64,
}

/// The monitor process.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// Time between two tables, nanoseconds.
    pub interval_ns: i64,
    /// Whether the monitor writes its files (histogram log, percentiles, JSON).
    pub files: bool,
    /// How it waits for system tracks.
    pub wait: MonitorWait,
    /// How long each stage may take; fusion's own stage always has a deadline.
    pub deadlines: Deadlines,
    /// Where it serves metrics for Prometheus, if it does.
    pub metrics: Option<SocketAddr>,
    /// Names by which they may be asked for, besides the machine's own for itself, in small letters.
    pub metrics_hosts: Vec<String>,
    /// Limits beyond which alarms are raised.
    pub alarms: alarms::Limits,
}

/// The display process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Display {
    /// Where it is.
    pub listen: SocketAddr,
    /// How many ports after that one are tried where it is taken.
    pub more_ports: u32,
    /// Names by which it may be asked for, besides the machine's own for itself, in small letters.
    pub hosts: Vec<String>,
    /// Token that every browser has to show.
    pub token: Option<String>,
    /// Token of the operators, who give orders; `None`: no orders.
    pub operator_token: Option<String>,
    /// Time for which the past is kept, seconds.
    pub history_s: i64,
    /// Most memory that it takes, octets.
    pub history_octets: usize,
    /// Files that are drawn under the tracks, relative to the data folder unless absolute.
    pub overlays: Vec<PathBuf>,
}

/// How the monitor waits for system tracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MonitorWait {
    /// Woken for each slice: exact, at the price of a system call of fusion's per slice.
    Event,
    /// Looks now and then, which costs fusion nothing: what comes after fusion is not measured.
    Poll {
        /// Time between two looks.
        pause: Duration,
    },
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
        config.text = text.to_owned();
        config
            .text
            .extend(overrides.iter().map(|each| format!("\n{OVERRIDE}{each}")));
        Ok(config)
    }

    /// As [`Config::parse`], from a [`Config::text`], which ends with the replaced values: that of a recording, or of
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

    /// The whole text without secrets, for recordings.
    pub fn text_without_secrets(&self) -> String {
        let display = self.display.iter();
        let secrets = display.flat_map(|display| {
            [
                (&display.token, "hidden-token-"),
                (&display.operator_token, "hidden-order-token-"),
            ]
        });
        secrets.fold(self.text.clone(), |text, (secret, placeholder)| match secret {
            Some(secret) => text.replace(secret.as_str(), &format!("{placeholder}{}", "x".repeat(TOKEN_MIN))),
            None => text,
        })
    }

    /// Writes the whole text into the folder of the running instance, for [`Config::of_running`], and beside it the
    /// names of the sources, for programs without the configuration.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write_into(&self, instance: &Path) -> std::io::Result<()> {
        let names: String = self.sources.iter().map(|source| format!("{}\n", source.name)).collect();
        std::fs::write(instance.join(SOURCES_IN_INSTANCE), names)?;
        std::fs::write(instance.join(IN_INSTANCE), &self.text)
    }

    /// Whether a file's text describes a deployment, rightly or wrongly; else it may be an [`Offline`] configuration.
    pub fn is_deployment(text: &str) -> bool {
        let keys = ["name", "frame", "source"];
        Document::parse(text, &[]).is_ok_and(|document| keys.iter().any(|key| document.has(key)))
    }

    /// The source called `name`.
    pub fn source(&self, name: &str) -> Option<&Source> {
        self.sources.iter().find(|source| source.name == name)
    }

    /// The wide-area sensor called `name`.
    pub fn wide_area_sensor(&self, name: &str) -> Option<&WideAreaSensor> {
        self.wide_area_sensors.iter().find(|sensor| sensor.name == name)
    }

    /// The receiver called `name`.
    pub fn receiver(&self, name: &str) -> Option<&Receiver> {
        self.receivers.iter().find(|receiver| receiver.name == name)
    }

    /// The link called `name`.
    pub fn link(&self, name: &str) -> Option<&Link> {
        self.links.iter().find(|link| link.name == name)
    }

    /// The gateway called `name`.
    pub fn gateway(&self, name: &str) -> Option<&Gateway> {
        self.gateways.iter().find(|gateway| gateway.name == name)
    }

    /// The names of the adapter processes, in the order of their first sources, then of the wide-area sensors. External
    /// ones have none.
    pub fn adapters(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for source in self
            .sources
            .iter()
            .filter(|source| !matches!(source.input, Input::External))
        {
            if !names.contains(&source.adapter.as_str()) {
                names.push(&source.adapter);
            }
        }
        for sensor in &self.wide_area_sensors {
            if !matches!(sensor.input, WideAreaInput::External) && !names.contains(&sensor.adapter.as_str()) {
                names.push(&sensor.adapter);
            }
        }
        names
    }

    /// Whether any sensor is simulated.
    pub fn is_simulated(&self) -> bool {
        let sensors = &self.wide_area_sensors;
        self.sources
            .iter()
            .any(|source| matches!(source.input, Input::Simulated(_)))
            || sensors.iter().any(|sensor| sensor.simulated.is_some())
    }

    /// Whether all sources are recordings, some of them perhaps of other hosts: then producers wait for consumers, so
    /// that nothing is lost.
    pub fn is_recorded(&self) -> bool {
        self.sources.iter().all(|source| match source.input {
            Input::Recorded(_) => true,
            // In order `time` it is what a link brings.
            Input::External => self.order == ReportOrder::Time,
            Input::Live(_) | Input::Simulated(_) => false,
        })
    }
}

#[cfg(test)]
mod tests;
