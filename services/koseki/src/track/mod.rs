//! `koseki track`: files of detections into one file of tracks (FM-6).
//!
//! The tracker is the one that adapters run live, fed scan by scan in the order of their times: what an adapter published
//! comes out of its recorded detections again, byte for byte. The files are read into memory whole, since a scan may be
//! anywhere in them.

mod cues;
mod emissions;
mod explain;
mod input;
mod rows;
mod summary;
mod support;

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use configuration::{Config, SeenDetections, Source, Tracking};
use observations::sensor_id;
use tracking::explanation::Observer;
use tracking::scans::scans_of;
use tracking::{Settings, Tracker};

use crate::args::{Track, Usage};
use crate::files::{InputError, is_same_file};
use crate::offline::Progress;
use cues::Cues;
use emissions::Emissions;
use explain::Explained;
use input::Input;
use rows::Rows;
use summary::{Summary, Tracked};
use support::Support;

/// Tracks.
///
/// # Errors
/// If what is asked for makes no sense, or a file cannot be read or written.
pub(crate) fn run(track: &Track) -> anyhow::Result<()> {
    check_files(track)?;
    let config = match &track.config {
        Some(path) => Given::read(path)?,
        None => Given::Offline(Box::default()),
    };
    let mut input = Input::read(&track.detections)?;
    let mut support = track.wide_area.as_deref().map(Support::read).transpose()?;
    let mut emissions = track.emissions.as_deref().map(Emissions::read).transpose()?;
    let scans = scans_of(&mut input.detections);
    let settings = config.settings(&input.seen(&scans))?;
    input.check(&settings)?;
    emissions.iter().try_for_each(|emissions| emissions.check(&settings))?;
    let cues = |path: &PathBuf| Cues::begin(path, &settings);
    let mut cues = track.cues.as_ref().map(cues).transpose()?;
    let mut tracker = Tracker::new(settings).map_err(anyhow::Error::msg)?;
    if let Some(first) = input.first_scan(&scans) {
        tracker.number_from(first);
    }
    let unwritten = |path: &Path| format!("{} cannot be written", path.display());
    let mut rows = Rows::begin(&track.out, track.period)?;
    let explained = track.explain.as_deref().map(Explained::begin).transpose()?;
    let observer = explained.as_ref().map(|explained| explained as &dyn Observer);
    let mut progress = Progress::new(input.octets);
    let mut tracked = Tracked::default();
    for scan in &scans {
        // A picture shows what all scans up to its time have shown.
        rows.pictures(scan.time_ns - 1, &tracker)
            .with_context(|| unwritten(&track.out))?;
        let begin_ns = runtime::clock::mono_ns();
        if let Some(support) = &mut support {
            support.give(scan.time_ns, &mut tracker);
        }
        if let Some(emissions) = &mut emissions {
            emissions.give(scan.time_ns, &mut tracker);
        }
        let detections = &input.detections[scan.detections.clone()];
        let taken = tracker.scan_explained(scan.sensor_id, scan.time_ns, detections, observer);
        tracked.scan(scan, runtime::clock::mono_ns() - begin_ns, taken, &tracker);
        if taken.is_ok() {
            rows.after_scan(&tracker).with_context(|| unwritten(&track.out))?;
            if let (Some(cues), Some(path)) = (&mut cues, &track.cues) {
                cues.after_scan(scan, detections, &tracker)
                    .with_context(|| unwritten(path))?;
            }
        }
        progress.at(input.octets_until(scan.detections.end));
    }
    drop(progress);
    if let Some(last) = scans.last() {
        rows.pictures(last.time_ns, &tracker)
            .with_context(|| unwritten(&track.out))?;
    }
    let summary = Summary {
        out: &track.out,
        rows: rows.written,
        cues: cues.as_ref().map(|cues| cues.written),
        input: &input,
        support: support.as_ref(),
        emissions: emissions.as_ref(),
        tracker: &tracker,
        tracked,
    };
    rows.finish()?;
    cues.map(Cues::finish).transpose()?;
    if let (Some(explained), Some(path)) = (explained, &track.explain) {
        explained.finish(path)?;
    }
    summary.show(track.json)
}

/// What `--config` names.
enum Given {
    /// A deployment: what it says of the source whose detections these are.
    Deployment(Box<Config>),
    Offline(Box<Tracking>),
}

impl Given {
    fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path);
        let text = text.map_err(|error| InputError::new(path, format!("cannot be read: {error}")))?;
        Ok(match Config::is_deployment(&text) {
            true => Self::Deployment(Box::new(Config::parse(path, &text, &[])?)),
            false => Self::Offline(Box::new(Tracking::parse(path, &text)?)),
        })
    }

    fn settings(&self, seen: &SeenDetections) -> anyhow::Result<Settings> {
        let config = match self {
            Self::Offline(config) => return Ok(config.settings(seen)?),
            Self::Deployment(config) => config,
        };
        let tracker_of = |id: &u32| {
            let of_files = |source: &&Source| sensor_id(source.number) == *id;
            config.sources.iter().find(of_files)?.tracker.as_ref()
        };
        let mut ids = seen.sensor_ids.iter();
        match (ids.next(), ids.next()) {
            (Some(id), None) => match tracker_of(id) {
                Some(tracker) => Ok(tracker.settings.clone()),
                None => {
                    let what =
                        format!("source {id} is none, or has no [source.tracker]; sensor_id 1 is the first source");
                    Err(InputError::new(&config.path, what).into())
                }
            },
            _ => {
                let ids: Vec<String> = seen.sensor_ids.iter().map(u32::to_string).collect();
                let what = format!(
                    "in a deployment each source has a tracker of its own, but the detections are of the sensors {}; give \
                     those of one",
                    ids.join(", ")
                );
                Err(InputError::new(&config.path, what).into())
            }
        }
    }
}

/// No detection counts twice, what is read must not be written over, nor one output over the other.
fn check_files(track: &Track) -> Result<(), Usage> {
    if let Some(file) = crate::offline::named_twice(&track.detections) {
        let what = format!("--detections names {} twice; name it once", file.display());
        return Err(Usage(what));
    }
    let given = [("--explain", &track.explain), ("--cues", &track.cues)];
    let given = given
        .iter()
        .filter_map(|(option, path)| Some((*option, path.as_ref()?)));
    let outputs: Vec<(&str, &PathBuf)> = std::iter::once(("--out", &track.out)).chain(given).collect();
    let inputs: Vec<&PathBuf> = track
        .detections
        .iter()
        .chain(&track.config)
        .chain(&track.wide_area)
        .chain(&track.emissions)
        .collect();
    for (place, (option, written)) in outputs.iter().enumerate() {
        if inputs.iter().any(|input| is_same_file(input, written)) {
            let what = format!("{option} {} is an input; name another file", written.display());
            return Err(Usage(what));
        }
        let is_other = |(_, earlier): &&(&str, &PathBuf)| earlier == written || is_same_file(earlier, written);
        if let Some((other, _)) = outputs[..place].iter().find(is_other) {
            return Err(Usage(format!("{other} and {option} name one file; name two")));
        }
    }
    Ok(())
}
