//! A deployment as each of its processes uses it: names and numbers, the system frame, inputs, outputs and the machine.
//!
//! The crate holds plain data and no settings of an algorithm. An edit in a tracker or in the fusion engine therefore
//! rebuilds no process that only reads topics. The crate `configuration` reads a file and makes the data.

#![forbid(unsafe_code)]

mod fusion;
mod link;
mod names;
mod network;
mod observed;
mod parts;
mod platform;
mod processes;
mod source;
mod streams;
mod technology;
mod wide_area;

use std::path::{Path, PathBuf};

use frames::SystemFrame;

pub use fusion::{Checkpoint, Fusion, Machine, WaitWord};
pub use link::{Link, LinkPeer, LinkTls, RemoteTopic, check_endpoint, check_links};
pub use names::check_name;
pub use network::{
    Asterix, DatagramInput, DatagramOutput, Feed, FeedFormat, FeedLink, FeedOrigin, Live, NetworkOutput, Receiver,
    ReceiverTransport,
};
pub use observed::SourceFacts;
pub use parts::Parts;
pub use platform::{Platform, PlatformFeed, PlatformInput};
pub use processes::{ReportOrder, Secret, Segments, Services, SystemTracks};
pub use source::{
    Input, Links, OnBoard, PlotFormat, Recorded, RecordedFormat, SampleDelivery, Source, TrackerInput, Truncated,
};
pub use streams::DecisionUse;
pub use technology::Technology;
pub use wide_area::{CountedTracks, TrackFeed, WideAreaInput, WideAreaSensor};

/// File in the folder of a running instance that contains its [`Deployment::text`].
pub const IN_INSTANCE: &str = "configuration.toml";

/// File in the folder of a running instance with the names of its sources, a line each.
const SOURCES_IN_INSTANCE: &str = "sources";

/// File in the folder of a running instance with the address at which browsers reach its display.
const PAGE_IN_INSTANCE: &str = "display";

/// Keeps the address of the page of the instance in the folder `instance`. The display may have chosen its port.
///
/// # Errors
/// If the file cannot be written.
pub fn keep_page(instance: &Path, address: &str) -> std::io::Result<()> {
    std::fs::write(instance.join(PAGE_IN_INSTANCE), address)
}

/// Returns the address of the page of the instance in the folder `instance`; `None` without a display.
pub fn page_of(instance: &Path) -> Option<String> {
    let address = std::fs::read_to_string(instance.join(PAGE_IN_INSTANCE)).ok()?;
    Some(address).filter(|address| !address.is_empty())
}

/// A checked deployment.
#[derive(Clone, Debug)]
pub struct Deployment {
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
    /// The sensors of tracker processes, whose numbers follow those of the sources. They deliver detections only, and
    /// are no sources of fusion. Their names begin with the tracker's.
    pub tracker_sensors: Vec<Source>,
    /// The wide-area sensors, in the order of their numbers; they are no sources.
    pub wide_area_sensors: Vec<WideAreaSensor>,
    /// The platforms that carry sensors, in the order of their numbers.
    pub platforms: Vec<Platform>,
    /// The network inputs; each is an adapter process.
    pub receivers: Vec<Receiver>,
    /// The links to deployments on other hosts; each is a process.
    pub links: Vec<Link>,
    /// The fusion process.
    pub fusion: Fusion,
    /// The system tracks.
    pub system_tracks: SystemTracks,
    /// Memory of fusion and adapters for their successors.
    pub checkpoint: Checkpoint,
    /// The machine.
    pub machine: Machine,
    /// Facts about services.
    pub services: Services,
}

impl Deployment {
    /// The whole text without secrets, for recordings.
    pub fn text_without_secrets(&self) -> String {
        let replace = |text: String, secret: &Secret| text.replace(&secret.text, &secret.placeholder);
        self.services.secrets.iter().fold(self.text.clone(), replace)
    }

    /// Writes the whole text into the folder of the running instance, for other commands, and
    /// beside it the names of the sources, for programs without the configuration.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write_into(&self, instance: &Path) -> std::io::Result<()> {
        let names: String = self.sources.iter().map(|source| format!("{}\n", source.name)).collect();
        std::fs::write(instance.join(SOURCES_IN_INSTANCE), names)?;
        std::fs::write(instance.join(IN_INSTANCE), &self.text)
    }

    /// The source called `name`.
    pub fn source(&self, name: &str) -> Option<&Source> {
        self.sources.iter().find(|source| source.name == name)
    }

    /// The sensors of a source that is a tracker process; empty for other sources.
    pub fn sensors_of(&self, source: &Source) -> &[Source] {
        match &source.input {
            Input::Tracker(tracker) => &self.tracker_sensors[tracker.sensors.clone()],
            _ => &[],
        }
    }

    /// The wide-area sensor called `name`.
    pub fn wide_area_sensor(&self, name: &str) -> Option<&WideAreaSensor> {
        self.wide_area_sensors.iter().find(|sensor| sensor.name == name)
    }

    /// The platform called `name`.
    pub fn platform(&self, name: &str) -> Option<&Platform> {
        self.platforms.iter().find(|platform| platform.name == name)
    }

    /// The receiver called `name`.
    pub fn receiver(&self, name: &str) -> Option<&Receiver> {
        self.receivers.iter().find(|receiver| receiver.name == name)
    }

    /// The link called `name`.
    pub fn link(&self, name: &str) -> Option<&Link> {
        self.links.iter().find(|link| link.name == name)
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
        // External sensors have none, and a recorded tracker reads its sensors' files itself.
        let of_trackers = self.tracker_sensors.iter();
        for sensor in of_trackers.filter(|sensor| matches!(sensor.input, Input::Live(_))) {
            if !names.contains(&sensor.adapter.as_str()) {
                names.push(&sensor.adapter);
            }
        }
        for sensor in &self.wide_area_sensors {
            if !matches!(sensor.input, WideAreaInput::External) && !names.contains(&sensor.adapter.as_str()) {
                names.push(&sensor.adapter);
            }
        }
        let live = self.platforms.iter().filter(|platform| platform.has_process());
        names.extend(live.map(|platform| platform.name.as_str()));
        names
    }

    /// Whether any sensor is simulated.
    pub fn is_simulated(&self) -> bool {
        let sensors = &self.wide_area_sensors;
        self.sources
            .iter()
            .any(|source| matches!(source.input, Input::Simulated(_)))
            || sensors.iter().any(|sensor| sensor.is_simulated)
            || self.platforms.iter().any(|platform| platform.is_simulated)
    }

    /// Whether all sources are recordings, some of them perhaps of other hosts: then producers wait for consumers, so
    /// that nothing is lost.
    pub fn is_recorded(&self) -> bool {
        self.sources.iter().all(|source| match source.input {
            Input::Recorded(_) | Input::Tracker(_) => source.input.is_recorded(),
            // In order `time` it is what a link brings.
            Input::External => self.order == ReportOrder::Time,
            Input::Live(_) | Input::Simulated(_) => false,
        })
    }

    /// Whether a second fusion stands by; none does where recordings are replayed.
    pub fn has_standby(&self) -> bool {
        self.fusion.standby && !self.is_recorded()
    }
}
