//! Display process: shows the track picture in browsers.
//!
//! The display is an ordinary subscriber. It can be killed at any time without any effect on fusion. One thread
//! reads the topics and updates the world; another serves pages over HTTP and WebSockets (crate `web`). Both share
//! the world under a lock, which is held only while a few slices are inserted or one picture is made.
//!
//! | module | purpose |
//! |---|---|
//! | `wire` | protocol between server and page |
//! | `layers` | registry of the displayed streams |
//! | `agent` | reads the topics |
//! | `guest` | shows an instance without its configuration |
//! | `tape` | replays a recording |
//! | `moments` | worlds of a recording: each window has its own moment |
//! | `world` | current state of the deployment |
//! | `records` | converts samples to records of a picture |
//! | `history` | past of the picture |
//! | `trails` | past positions of all tracks, for a page that was just opened |
//! | `coverage`, `coverage_json` | coverage and probability of detection of each source |
//! | `viewer` | state of one page, and the next picture for it |
//! | `reasons`, `decisions`, `decision_text`, `recent` | reasons of a track's weights, and the reports behind |
//! | `details`, `status` | details of single tracks, and status of the deployment, as JSON |
//! | `ground` | projects coasts and overlays into the system frame |
//! | `operator`, `orders` | acts of operators, and their way to fusion |
//! | `alarm_book` | acknowledged and shelved alarms, and the past of alarms |
//! | `views` | named views that all pages share |
//! | `kept_file` | small files that the display keeps |
//! | `feed` | samples as they are published |
//! | `events`, `foxglove` | these samples as server-sent events, and for Foxglove |
//! | `seat` | limit of the number of clients |
//! | `pages`, `assets` | HTTP server and the page's files |

#![forbid(unsafe_code)]

mod agent;
mod alarm_book;
mod assets;
mod clock;
mod coverage;
mod coverage_json;
mod decision_text;
mod decisions;
mod details;
mod events;
mod feed;
#[cfg(test)]
mod feed_tests;
mod foxglove;
mod ground;
mod guest;
mod history;
mod kept_file;
mod label_settings;
mod layers;
mod moments;
mod operator;
#[cfg(test)]
mod operator_tests;
mod orders;
mod pages;
mod passing;
mod reasons;
mod recent;
mod records;
mod reports;
mod seat;
mod settings;
#[cfg(test)]
mod settings_tests;
mod shared;
#[cfg(test)]
mod station_tests;
mod stations;
mod status;
mod tape;
mod trails;
mod vertical;
mod viewer;
mod views;
mod wire;
mod world;

use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use deployment::Deployment;
use deployment::Technology;
use frames::SystemFrame;
use messages::FrameOrigin;
use runtime::Now;
use runtime::Process;
use runtime::signals::Stop;
use web::{ForeignPages, Guard, HostName, Server, WriteAccess};

use crate::alarm_book::AlarmBook;
use crate::clock::PictureClock;
use crate::feed::Feed;
pub use crate::guest::show_instance;
use crate::moments::Moments;
pub use crate::settings::{Keys, Settings};
use crate::shared::{Desk, SharedState};
use crate::tape::Tape;
use crate::world::{ReplayedRecording, SourceFact, World};

/// File of the operators' acts on alarms, in the folder of the instance.
const ALARM_ACTS: &str = "alarm-acts.json";

/// Runs the display until the process is asked to stop. `engine`: settings of fusion, for the comparison of rules.
///
/// # Errors
/// If the configuration has no display, no port is free, or shared memory fails.
pub fn run(process: &Process, settings: &Settings, engine: &fusion_settings::Settings) -> anyhow::Result<()> {
    let path = process.config.path.display();
    let first = settings.address();
    first.with_context(|| format!("{path}: display.listen is not given"))?;
    let maps = settings.maps_in(&process.options.data);
    let mut world = World::new(
        &process.options.instance,
        sources(&process.config),
        settings.history_s.into(),
        settings.history_bytes(),
    );
    world.place(&origin(&process.config));
    world.labels = settings.labels.clone();
    world.set_clock(PictureClock::of(process.config.is_recorded()));
    world.engine = Some(Arc::new(engine.clone()));
    world.has_decisions = process.config.decision_use().is_some();
    world.declination_deg = settings.declination_deg;
    world.alarm_book = AlarmBook::kept_in(process.bus.root().path().join(ALARM_ACTS));
    let desk = Desk {
        has_operators: settings.operator_token.is_some(),
        views: settings.views.open(&process.options.data)?,
    };
    let shared = SharedState::fed(world, maps, Now::read, Feed::of(&process.config), desk);
    let server = serve(settings, Moments::of_deployment(shared.clone()))?;
    say(&server, settings);
    // For `koseki top` and `koseki status`, which go on without it.
    let _ = deployment::keep_page(process.bus.root().path(), &address_of(&server, settings));
    let sight = (shared, server.counts().clone());
    let has_operators = settings.operator_token.is_some();
    let mut agent = agent::DisplayAgent::new(&process.config, has_operators, &process.bus, process.incarnation, sight)?;
    runtime::service::run(process, &mut agent)
}

/// Checks that every file of the display's map can be drawn in the system frame `frame`.
///
/// # Errors
/// A sentence about the first file that is missing or not valid GeoJSON.
pub fn check_maps(settings: &Settings, frame: &SystemFrame, data: &Path) -> Result<(), String> {
    let Some(_) = settings.address() else { return Ok(()) };
    let maps = settings.maps_in(data);
    let refusal = |path: &Path, key: &str, error: String| {
        let path = path.display();
        format!("{path}: {error}; it is a file of the map: name its folder with --data, or correct {key}")
    };
    for (number, path) in maps.overlays.iter().enumerate() {
        pages::read_overlay(path, frame)
            .map_err(|error| refusal(path, &format!("display.overlays[{number}]"), error))?;
    }
    if let Some(path) = &maps.coast {
        pages::read_coast(path, frame).map_err(|error| refusal(path, "display.coast", error))?;
    }
    Ok(())
}

/// Checks that the kept views of the display can be read.
///
/// # Errors
/// A sentence about the file of the views.
pub fn check_views(settings: &Settings, data: &Path) -> Result<(), String> {
    let views = settings.address().map(|_| settings.views.open(data));
    views
        .transpose()
        .map_or_else(|error| Err(format!("{error:#}")), |_| Ok(()))
}

/// Shows the recording `path`, which consists of `files`, with `settings` until the process is asked to stop. The
/// deployment of `config` with the fusion of `engine` made the recording. No running deployment is needed.
///
/// # Errors
/// If the recording cannot be read or no port is free.
pub fn show_recording(
    config: &Deployment,
    engine: &fusion_settings::Settings,
    (path, files): (&Path, &[PathBuf]),
    settings: &Settings,
) -> anyhow::Result<()> {
    let stop = Stop::on_signals().context("catching signals")?;
    let mut tape = Tape::open(config, files)?;
    let damage = tape.damage();
    if damage.parts > 0 {
        let (path, parts, bytes) = (path.display(), damage.parts, damage.bytes);
        runtime::notice(format_args!(
            "koseki: {path}: damaged parts skipped: {parts} ({bytes} bytes)"
        ));
    }
    // The real name instead of the link `latest`.
    let name = path.canonicalize()?;
    let mut world = World::new(
        &config.name,
        sources(config),
        settings.history_s.into(),
        settings.history_bytes(),
    );
    world.place(&origin(config));
    world.labels = settings.labels.clone();
    world.declination_deg = settings.declination_deg;
    world.engine = Some(Arc::new(engine.clone()));
    world.has_decisions = config.fusion.decisions;
    let name = name.file_name().unwrap_or_default().to_string_lossy().into_owned();
    world.observed = world.observed.of_recording(recording::REPEATED_NS);
    world.recording = Some(ReplayedRecording::begin(name, tape.span_ns(), Now::read()));
    // Paths of the maps are whole.
    let maps = settings.maps_in(Path::new(""));
    let desk = Desk {
        has_operators: false,
        views: settings.views.open(Path::new(""))?,
    };
    let shared = SharedState::fed(world, maps, Now::read, Feed::default(), desk);
    let server = serve(settings, Moments::of_recording(shared.clone(), tape.again()?))?;
    say(&server, settings);
    while !stop.requested() {
        moments::advance(&mut tape, &shared)?;
        std::thread::sleep(moments::LOOK_EVERY);
    }
    Ok(())
}

/// Serves `moments` on the first free port.
fn serve(settings: &Settings, moments: Moments) -> anyhow::Result<Server> {
    let guard = Guard {
        hosts: settings.hosts.iter().map(HostName::in_small_letters).collect(),
        token: settings.token.clone(),
        writer: settings.operator_token.clone().map(|token| WriteAccess {
            token,
            paths: operator::PATHS,
            login: operator::LOGIN,
        }),
        foreign: Some(ForeignPages {
            path: foxglove::FOXGLOVE,
            sites: settings.foxglove_sites.clone(),
        }),
    };
    let listener = listen(settings)?;
    Server::start_on("pages", listener, guard, pages::router(moments)).context("serving pages")
}

fn listen(settings: &Settings) -> anyhow::Result<TcpListener> {
    let first = settings.address().context("display.listen is not given")?;
    let ports = (u32::from(first.port())..=u32::from(u16::MAX)).take(1 + settings.more_ports as usize);
    let mut refusal = None;
    for port in ports {
        match web::listen(SocketAddr::new(first.ip(), port as u16)) {
            Ok(listener) => return Ok(listener),
            Err(error) => refusal = refusal.or(Some(error)),
        }
    }
    Err(refusal.map_or_else(|| anyhow::anyhow!("no port"), anyhow::Error::from)).context("display.listen")
}

/// Prints the address of the display.
fn say(server: &Server, settings: &Settings) {
    let address = address_of(server, settings);
    runtime::notice(format_args!("koseki: the picture is at {address}"));
}

/// Returns the address of the display for a browser, without the token.
fn address_of(server: &Server, settings: &Settings) -> String {
    let token = settings.token.as_ref().map_or("", |_| "?token=…");
    format!("http://{}/{token}", server.address())
}

fn origin(config: &Deployment) -> FrameOrigin {
    let place = config.frame.to_geodetic([0.0; 3]);
    FrameOrigin {
        latitude_deg: place.latitude_deg(),
        longitude_deg: place.longitude_deg(),
        height_m: place.height_m(),
    }
}

fn sources(config: &Deployment) -> Vec<SourceFact> {
    let observed = config.observed_sources().into_iter();
    observed
        .zip(&config.sources)
        .map(|(observed, source)| fact(observed, source))
        .collect()
}

fn fact(observed: deployment::SourceFacts, source: &deployment::Source) -> SourceFact {
    SourceFact {
        source: observed,
        kind: match source.technology {
            Technology::Primary | Technology::Secondary | Technology::ModeS => "radar",
            Technology::Multilateration => "mlat",
            Technology::AdsB => "adsb",
            Technology::Other | Technology::Ais => "other",
        },
        site_m: Some(source.frame.place()),
    }
}
