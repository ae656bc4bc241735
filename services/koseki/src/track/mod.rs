//! `koseki track`: files of detections into one file of tracks (FM-6).
//!
//! The tracker is the one that adapters run live, fed scan by scan in the order of their times: what an adapter published
//! comes out of its recorded detections again, byte for byte. The files are read into memory whole, since a scan may be
//! anywhere in them.

mod explain;
mod input;
mod summary;
mod support;

use std::io;
use std::path::Path;

use anyhow::Context as _;
use formats::tracks_csv::{TrackerTrackWriter, sensor_id};
use runtime::Config;
use runtime::config::{SeenDetections, Source, Tracking};
use tracking::explanation::Observer;
use tracking::scans::scans_of;
use tracking::{Settings, TrackReport, Tracker};

use crate::args::{Track, Usage};
use crate::files::{InputError, OutputFile, is_same_file};
use crate::offline::Progress;
use explain::Explained;
use input::Input;
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
    let scans = scans_of(&mut input.detections);
    let settings = config.settings(&input.seen(&scans))?;
    input.check(&settings)?;
    let mut tracker = Tracker::new(settings).map_err(anyhow::Error::msg)?;
    if let Some(first) = input.first_scan(&scans) {
        tracker.number_from(first);
    }
    let unwritten = || format!("{} cannot be made", track.out.display());
    let out = OutputFile::begin(&track.out)?;
    let mut writer = TrackerTrackWriter::begin(out, 0).with_context(unwritten)?;
    let explained = track.explain.as_deref().map(Explained::begin).transpose()?;
    let observer = explained.as_ref().map(|explained| explained as &dyn Observer);
    let mut progress = Progress::new(input.octets);
    let (mut tracked, mut reports) = (Tracked::default(), Vec::new());
    for scan in &scans {
        let begin_ns = runtime::clock::mono_ns();
        if let Some(support) = &mut support {
            support.give(scan.time_ns, &mut tracker);
        }
        let detections = &input.detections[scan.detections.clone()];
        let taken = tracker.scan_explained(scan.sensor_id, scan.time_ns, detections, observer);
        tracked.scan(scan, runtime::clock::mono_ns() - begin_ns, taken, &tracker);
        if taken.is_ok() {
            reports.clear();
            reports.extend_from_slice(tracker.tracks());
            reports.sort_unstable_by_key(TrackReport::order);
            write(&mut writer, &reports, &mut tracked.rows).with_context(unwritten)?;
        }
        progress.at(input.octets_until(scan.detections.end));
    }
    drop(progress);
    writer.into_inner().finish()?;
    if let (Some(explained), Some(path)) = (explained, &track.explain) {
        explained.finish(path)?;
    }
    let summary = Summary {
        out: &track.out,
        input: &input,
        support: support.as_ref(),
        tracker: &tracker,
        tracked,
    };
    summary.show(track.json)
}

/// Writes the tracks after a scan, in the order of times as an adapter publishes them.
fn write(writer: &mut TrackerTrackWriter<OutputFile>, reports: &[TrackReport], rows: &mut u64) -> io::Result<()> {
    for report in reports {
        writer.write(&report.sensor_track(0), report.hypotheses, report.reliability)?;
        *rows += 1;
    }
    Ok(())
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
    for (option, written) in [("--out", Some(&track.out)), ("--explain", track.explain.as_ref())] {
        let Some(written) = written else { continue };
        let mut inputs = track.detections.iter().chain(&track.config).chain(&track.wide_area);
        if inputs.any(|input| is_same_file(input, written)) {
            let what = format!("{option} {} is an input; name another file", written.display());
            return Err(Usage(what));
        }
    }
    let twice = |explain: &std::path::PathBuf| *explain == track.out || is_same_file(explain, &track.out);
    if track.explain.as_ref().is_some_and(twice) {
        return Err(Usage("--out and --explain name one file; name two".to_owned()));
    }
    Ok(())
}
