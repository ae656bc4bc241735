//! `koseki track`: files of detections into a single file of tracks (FM-6).
//!
//! The command feeds the tracker of the live adapters ([`ScanTracker`]) scan by scan in order of time. The recorded
//! detections of an adapter therefore give the tracks published by that adapter, byte for byte. The command reads whole
//! files into memory, because a scan may be anywhere in a file.

mod explain;
mod input;
mod on_board;
mod outputs;
mod recorded_events;
mod summary;
mod support;

use std::collections::BTreeSet;
use std::path::Path;

use configuration::{Config, SeenDetections, Tracking};
use deployment::Source;
use frames::SystemFrame;
use observations::sensor_id;
use platform::Mount;
use sources::carrying::Carrier;
use sources::{Outputs, ScanTracker, SensorScan};
use tracking::Settings;
use tracking::explanation::Observer;
use tracking::scans::scans_of;
use tracking::wide_area::arrivals::Arrivals;

use crate::args::TrackArgs;
use crate::files::{InputError, Usage, check_answer, check_outputs};
use crate::host::Host;
use crate::reading::{FilePlane, Progress};
use explain::Explained;
use input::DetectionInput;
use on_board::OnBoard;
use outputs::TrackerSink;
use summary::TrackSummary;
use support::SupportInput;

/// Runs the tracker.
///
/// # Errors
/// If the arguments are contradictory, or a file cannot be read or written.
pub(crate) fn run(track: &TrackArgs, host: &dyn Host) -> anyhow::Result<()> {
    check_files(track)?;
    if recorded_events::is_recording(host, &track.detections[0])? {
        return recorded_events::run(track, host);
    }
    if let Some(name) = &track.tracker {
        let what = format!("--tracker {name}: goes with a recording of all topics; tables have no trackers");
        return Err(Usage(what).into());
    }
    let config = match &track.config {
        Some(path) => TrackConfiguration::read(host, path)?,
        None => TrackConfiguration::Offline(Box::default()),
    };
    let mut input = DetectionInput::read(host, &track.detections, FilePlane::new(track.origin, config.frame()))?;
    let carried = match &track.platform {
        Some(path) => Some(OnBoard::carry(host, path, &config, &mut input)?),
        None => OnBoard::carry_own(&track.detections[0], &config, &mut input)?,
    };
    let (support, reports) = read(track.wide_area.as_deref(), |path| {
        SupportInput::reports(host, path, &mut input.bases)
    })?;
    let (heard, emissions) = read(track.emissions.as_deref(), |path| {
        SupportInput::emissions(host, path, (&mut input.bases, &mut input.plane))
    })?;
    let scans = scans_of(&mut input.detections, &input.silent);
    let settings = config.settings(&input.seen(&scans))?;
    input.check(&settings)?;
    heard
        .iter()
        .try_for_each(|emissions| emissions.check_types(&settings))?;
    let outputs = Outputs {
        period_ns: track.period.map(|period| period.as_nanos() as i64),
        cues: track.cues.is_some(),
    };
    let mut written = TrackerSink::begin(
        host,
        (&track.out, input.has_replies(), input.plane.of_outputs()),
        track.cues.as_deref(),
    )?;
    (written.reports, written.emissions) = (support, heard);
    let mut tracker = ScanTracker::new(settings, outputs, Arrivals::of(reports), emissions)?;
    let explained = track
        .explain
        .as_deref()
        .map(|path| Explained::begin(host, path))
        .transpose()?;
    let observer = explained.as_ref().map(|explained| explained as &dyn Observer);
    let progress = Progress::new(host, input.octets);
    for scan in &scans {
        let detections = &input.detections[scan.detections.clone()];
        let scan_at_hand = SensorScan {
            sensor_id: scan.sensor_id,
            number: scan.number,
            time_ns: scan.time_ns,
            detections,
        };
        tracker.scan(&scan_at_hand, observer, &mut written);
        written.check()?;
        progress.at(input.octets_until(scan.detections.end))?;
    }
    drop(progress);
    if let Some(last) = scans.last() {
        tracker.show(last.time_ns, &mut written);
        written.check()?;
    }
    let (reports_left, emissions_left) = tracker.waiting();
    written
        .reports
        .iter_mut()
        .for_each(|support| support.left = reports_left);
    written
        .emissions
        .iter_mut()
        .for_each(|support| support.left = emissions_left);
    let mut summary = TrackSummary {
        out: &track.out,
        rows: 0,
        cues: None,
        input: &input,
        support: written.reports.take(),
        emissions: written.emissions.take(),
        carried,
        tracker: tracker.tracker(),
        tracked: std::mem::take(&mut written.tracked),
    };
    (summary.rows, summary.cues) = written.finish()?;
    if let (Some(explained), Some(path)) = (explained, &track.explain) {
        explained.finish(path)?;
    }
    summary.show(host, track.json)
}

/// Reads the rows of an optional file.
fn read<T>(
    path: Option<&Path>,
    read: impl FnOnce(&Path) -> Result<(SupportInput, Vec<T>), InputError>,
) -> Result<(Option<SupportInput>, Vec<T>), InputError> {
    match path {
        Some(path) => read(path).map(|(support, rows)| (Some(support), rows)),
        None => Ok((None, Vec::new())),
    }
}

/// Configuration given by `--config`.
enum TrackConfiguration {
    /// Deployment, with the settings of the source that delivered these detections.
    Deployment(Box<Config>),
    Offline(Box<Tracking>),
}

/// Numbers of the platforms that carry the sensors of the deployment's trackers.
fn carrying(config: &Config) -> impl Iterator<Item = u16> {
    let sensors = config.tracker_sensors.iter();
    sensors.filter_map(|sensor| sensor.on_board.and_then(|on_board| on_board.platform))
}

impl TrackConfiguration {
    fn read(host: &dyn Host, path: &Path) -> anyhow::Result<Self> {
        let text = host.text(path)?;
        Ok(match Config::is_deployment(&text) {
            true => Self::Deployment(Box::new(host.deployment(path, &text, &[])?)),
            false => Self::Offline(Box::new(Tracking::parse(path, &text)?)),
        })
    }

    /// Assumptions on the states of the platform.
    fn carrier(&self) -> Carrier {
        let platform = match self {
            Self::Offline(config) => {
                let settings = config.platform();
                Some((settings.assumed, settings.wait_s.ns()))
            }
            Self::Deployment(config) => {
                let platform = carrying(config).next();
                let platform = platform.map(usize::from);
                platform.and_then(|number| {
                    let reading = config.readings.platforms.get(number)?;
                    Some((reading.assumed, config.platforms[number].wait_ns))
                })
            }
        };
        let (assumed, wait_ns) = platform.unwrap_or_default();
        Carrier {
            assumed,
            wait_ns,
            states_max: 0,
        }
    }

    /// The deployment's file, if the sensors are on several platforms: the states of `--platform` belong to a single
    /// platform.
    fn of_several_platforms(&self) -> Option<&Path> {
        let Self::Deployment(config) = self else { return None };
        let first = carrying(config).next();
        let is_other = |number: u16| Some(number) != first;
        carrying(config).any(is_other).then_some(&config.path)
    }

    /// Mounting of a sensor that the platform of `--platform` carries.
    fn mount(&self, sensor_id: u32) -> Option<Mount> {
        match self {
            Self::Offline(config) => config.platform().mount(sensor_id),
            Self::Deployment(config) => {
                let sensor = sensor_of(config, sensor_id)?;
                sensor.on_board?.platform.and_then(|_| config.reading(sensor).mount)
            }
        }
    }

    /// Mounting of a sensor with detections that may state the platform themselves.
    fn own_mount(&self, sensor_id: u32) -> Option<Mount> {
        match self {
            Self::Offline(config) => {
                let mut sensors = config.platform().sensors.iter();
                let named = sensors.find(|sensor| sensor.id == sensor_id && sensor.on_board);
                named.map(|sensor| sensor.mount)
            }
            Self::Deployment(config) => {
                let sensor = sensor_of(config, sensor_id)?;
                let is_stated = sensor.on_board?.platform.is_none();
                config.reading(sensor).mount.filter(|_| is_stated)
            }
        }
    }

    /// Frame of a deployment: north of a sensor on board is then that at the platform.
    fn frame(&self) -> Option<SystemFrame> {
        match self {
            Self::Offline(_) => None,
            Self::Deployment(config) => Some(config.frame),
        }
    }

    /// Standard deviations of a sensor's detections that state none.
    fn sigmas(&self, sensor_id: u32) -> Option<[f64; 4]> {
        match self {
            Self::Offline(config) => config.sigmas(sensor_id),
            Self::Deployment(config) => {
                let tracker = config.tracker_of(&BTreeSet::from([sensor_id]))?;
                let mut facts = tracker.settings.sensors.iter();
                facts.find(|facts| facts.sensor_id == sensor_id)?.default_sigmas()
            }
        }
    }

    fn settings(&self, seen: &SeenDetections) -> anyhow::Result<Settings> {
        let config = match self {
            Self::Offline(config) => return Ok(config.settings(seen)),
            Self::Deployment(config) => config,
        };
        let tracker_of = |id: &u32| {
            let of_files = |source: &&Source| sensor_id(source.number) == *id;
            config.tracker(config.sources.iter().find(of_files)?.number)
        };
        let mut ids = seen.sensor_ids.iter();
        match (ids.next(), ids.next()) {
            (Some(id), None) => match tracker_of(id).or_else(|| config.tracker_of(&seen.sensor_ids)) {
                Some(tracker) => Ok(tracker.settings.clone()),
                None => {
                    let what =
                        format!("source {id} is none, or has no [source.tracker]; sensor_id 1 is the first source");
                    Err(InputError::new(&config.path, what).into())
                }
            },
            _ if let Some(tracker) = config.tracker_of(&seen.sensor_ids) => Ok(tracker.settings.clone()),
            _ => {
                let ids: Vec<String> = seen.sensor_ids.iter().map(u32::to_string).collect();
                let what = format!(
                    "no tracker of the deployment has all of the sensors {}: each source has one of its own, and each \
                     [[tracker]] has its sensors; give the detections of one",
                    ids.join(", ")
                );
                Err(InputError::new(&config.path, what).into())
            }
        }
    }
}

/// Sensor of a tracker process, by the number in files.
fn sensor_of(config: &Config, id: u32) -> Option<&Source> {
    config
        .tracker_sensors
        .iter()
        .find(|sensor| sensor_id(sensor.number) == id)
}

/// Rejects detections given twice, inputs that would be overwritten, and outputs that share a file.
fn check_files(track: &TrackArgs) -> Result<(), Usage> {
    if let Some(file) = crate::files::named_twice(&track.detections) {
        let what = format!("--detections names {} twice; name it once", file.display());
        return Err(Usage(what));
    }
    let outputs = [
        ("--out", Some(&track.out)),
        ("--explain", track.explain.as_ref()),
        ("--cues", track.cues.as_ref()),
    ];
    check_answer(track.json, &outputs)?;
    let inputs = track.detections.iter().chain(&track.config);
    check_outputs(
        inputs
            .chain(&track.wide_area)
            .chain(&track.emissions)
            .chain(&track.platform),
        &outputs,
    )
}
