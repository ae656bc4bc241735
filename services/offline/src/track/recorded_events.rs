//! `koseki track` on a recording of all topics (MCAP): the events of a tracker process, as taken by the process.
//!
//! The process publishes each event of its sensors before any decision about the event. The same joiner
//! ([`sources::joining`]) and the same tracker take the recorded events in the recorded order, so the tracks are equal
//! in every field, and the same late detections are rejected. Reports of the tracker's wide-area sensors are read from
//! the recording, too. The settings come from the recording, or from a deployment given by `--config`.
//!
//! Limit: a tracker process that was killed and has resumed the tracks has lost the detections that waited; from then
//! on the tracks may differ.

use std::collections::BTreeMap;
use std::io::{BufReader, Read as _};
use std::path::Path;

use anyhow::Context as _;
use configuration::Config;
use deployment::{Input, Source};
use frames::time::NS_PER_DAY;
use messages::layout::Sample as _;
use messages::{SensorDetection, WideArea};
use observations::{Sampled as _, SensorEvent, WideAreaReport};
use recording::Item;
use sources::joining::ScanJoiner;
use sources::{Outputs, ScanTracker, TrackerSettings};
use tracking::cutting::DetectionTreatment;
use tracking::explanation::Observer;
use tracking::wide_area::arrivals::Arrivals;

use super::explain::Explained;
use super::input::DetectionInput;
use super::outputs::TrackerSink;
use super::summary::TrackSummary;
use crate::args::TrackArgs;
use crate::files::{InputError, Usage};
use crate::host::Host;
use crate::reading::Progress;

/// First bytes of a recording.
const MAGIC: &[u8] = b"\x89MCAP";
/// Key of the configuration among the facts of a recording.
const CONFIGURATION: &str = "configuration";

/// Whether a file is a recording of all topics.
pub(super) fn is_recording(host: &dyn Host, path: &Path) -> anyhow::Result<bool> {
    let mut first = Vec::new();
    // A pipe cannot be read twice, and is no recording.
    if !path.is_file() {
        return Ok(false);
    }
    let read = host.open(path)?.take(MAGIC.len() as u64).read_to_end(&mut first);
    read.map_err(|error| InputError::unreadable(path, &error))?;
    Ok(first == MAGIC)
}

/// Tracks the detections of the recordings `--detections`.
///
/// # Errors
/// If the arguments are contradictory, or a file cannot be read or written.
pub(super) fn run(track: &TrackArgs, host: &dyn Host) -> anyhow::Result<()> {
    if track.wide_area.is_some() || track.emissions.is_some() {
        let what =
            "--wide-area and --emissions go with tables of detections; a recording contains what its tracker took";
        return Err(Usage(what.to_owned()).into());
    }
    let config = configuration(track, host)?;
    let (source, settings) = tracker(track, &config)?;
    let recorded = RecordedEvents::read(track, host, &config, source)?;
    let first_day_ns = match config.first_day_ns.or(recorded_day(track, host)?) {
        Some(first_day_ns) => first_day_ns,
        None => recorded.first_ns().div_euclid(NS_PER_DAY) * NS_PER_DAY,
    };
    let mut joiner = ScanJoiner::new(&settings.sensor_ids(), &settings.joining, first_day_ns)?;
    let outputs = Outputs {
        period_ns: track
            .period
            .map(|period| period.as_nanos() as i64)
            .or(settings.outputs.period_ns),
        cues: track.cues.is_some(),
    };
    let mut input = DetectionInput::of_recording(&track.detections[0], recorded.octets);
    input.detections = recorded.detections().collect();
    let mut written = TrackerSink::begin(host, (&track.out, input.has_replies(), None), track.cues.as_deref())?;
    (written.first_day_ns, written.marks_extrapolated) = (first_day_ns, true);
    let reports = Arrivals::of(recorded.reports);
    let mut tracker = ScanTracker::new(settings.settings.clone(), outputs, reports, Vec::new())?;
    let explained = track
        .explain
        .as_deref()
        .map(|path| Explained::begin(host, path))
        .transpose()?;
    let observer = explained.as_ref().map(|explained| explained as &dyn Observer);
    let progress = Progress::new(host, recorded.events.len() as u64);
    for (done, (sensor, event)) in recorded.events.iter().enumerate() {
        if matches!(event, SensorEvent::Unplaced(_)) {
            input.refusals.count("no state of the platform near the time");
            continue;
        }
        let treatment = match sensor {
            Some(sensor) => joiner.take(*sensor, event, 0),
            None => {
                joiner.clock(event.time_ns());
                DetectionTreatment::Waits
            }
        };
        match treatment {
            DetectionTreatment::Waits => {}
            DetectionTreatment::TooLate => input.refusals.count("late: the scan was complete"),
            DetectionTreatment::Refused => input.refusals.count("no room for waiting detections"),
        }
        while joiner.next_scan().is_some() {
            tracker.scan(&joiner.released(), observer, &mut written);
        }
        tracker.show(joiner.shown_ns(), &mut written);
        written.check()?;
        progress.at(done as u64)?;
    }
    drop(progress);
    // A live tracker never detects the end of the data; a recorded tracker does.
    if source.input.is_recorded() {
        joiner.end();
        while joiner.next_scan().is_some() {
            tracker.scan(&joiner.released(), observer, &mut written);
        }
        tracker.show(joiner.shown_ns(), &mut written);
        written.check()?;
    }
    let tracked = std::mem::take(&mut written.tracked);
    if tracked.refused_detections > 0 {
        let by_reason = &mut input.refusals.by_reason;
        by_reason.insert(
            "late: the scan was older than every open one".to_owned(),
            tracked.refused_detections,
        );
    }
    let mut summary = TrackSummary {
        out: &track.out,
        rows: 0,
        cues: None,
        input: &input,
        carried: None,
        support: None,
        emissions: None,
        tracker: tracker.tracker(),
        tracked,
    };
    (summary.rows, summary.cues) = written.finish()?;
    if let (Some(explained), Some(path)) = (explained, &track.explain) {
        explained.finish(path)?;
    }
    summary.show(host, track.json)
}

/// The deployment of `--config`, else that of the recording.
fn configuration(track: &TrackArgs, host: &dyn Host) -> anyhow::Result<Config> {
    if let Some(path) = &track.config {
        return Ok(host.deployment(path, &host.text(path)?, &[])?);
    }
    let path = &track.detections[0];
    let facts = recording::facts(&mut host.open(path)?).with_context(|| format!("reading {}", path.display()))?;
    let text = facts.and_then(|facts| facts.get(CONFIGURATION).cloned());
    let text = text.ok_or_else(|| InputError::new(path, "does not state its configuration; give it by --config"))?;
    Ok(Config::parse_whole(path, &text)?)
}

/// Day on which the deployment of the recording began, from which the tracker counts scans; UTC, nanoseconds.
fn recorded_day(track: &TrackArgs, host: &dyn Host) -> anyhow::Result<Option<i64>> {
    let path = &track.detections[0];
    let facts = recording::facts(&mut host.open(path)?).with_context(|| format!("reading {}", path.display()))?;
    Ok(facts.and_then(|facts| facts.get("first_day_ns")?.parse().ok()))
}

/// The tracker process to repeat: the only tracker process, or the tracker process of `--tracker`.
fn tracker<'a>(track: &TrackArgs, config: &'a Config) -> anyhow::Result<(&'a Source, &'a TrackerSettings)> {
    let is_tracker = |source: &&Source| matches!(source.input, Input::Tracker(_));
    let trackers: Vec<&Source> = config.sources.iter().filter(is_tracker).collect();
    let names: Vec<&str> = trackers.iter().map(|source| source.name.as_str()).collect();
    let found = match (&track.tracker, &trackers[..]) {
        (None, [only]) => Some(*only),
        (name, _) => trackers
            .iter()
            .find(|source| Some(&source.name) == name.as_ref())
            .copied(),
    };
    let settings = found.and_then(|source| Some((source, config.tracker(source.number)?)));
    settings.ok_or_else(|| {
        let what = match &names[..] {
            [] => "the recording's deployment has no [[tracker]]; give the table of a source's detections".to_owned(),
            names => format!("--tracker must name one of {}", names.join(", ")),
        };
        Usage(what).into()
    })
}

/// Events taken by a tracker process, in the process's order.
#[derive(Debug, Default)]
struct RecordedEvents {
    /// Place of the sensor, and the event; without a sensor, the time of the clock.
    events: Vec<(Option<usize>, SensorEvent)>,
    reports: Vec<WideAreaReport>,
    octets: u64,
}

/// A topic that is read.
#[derive(Clone, Copy, Debug)]
enum ReadTopic {
    Events,
    Reports,
}

impl RecordedEvents {
    fn read(track: &TrackArgs, host: &dyn Host, config: &Config, source: &Source) -> anyhow::Result<Self> {
        let sensors = config.sensors_of(source);
        let events = messages::sensor_detections(&source.name).name;
        let mut topics = BTreeMap::from([(events.as_str().to_owned(), ReadTopic::Events)]);
        for number in &source.links.wide_area_sensors {
            let topic = messages::wide_area(&config.wide_area_sensors[usize::from(*number)].name);
            topics.insert(topic.name.as_str().to_owned(), ReadTopic::Reports);
        }
        let (mut recorded, mut next_sequence) = (Self::default(), 0);
        for path in &track.detections {
            let mut file = host.open(path)?;
            if recording::is_unended(&mut file)? {
                host.say(&format!("koseki: {}: {}\n", path.display(), recording::UNENDED));
            }
            recorded.octets += file.length;
            let (mut damaged, mut damaged_bytes) = (0, 0);
            let read = recording::read::<_, anyhow::Error>(&mut BufReader::new(file), |item| {
                if let Item::Damaged { bytes, .. } = &item {
                    damaged += 1;
                    damaged_bytes += bytes.end - bytes.start;
                }
                let Item::Sample { topic, octets } = item else {
                    return Ok(());
                };
                match topics.get(topic) {
                    Some(ReadTopic::Events) => {
                        let Some(sample) = SensorDetection::of_octets(octets) else {
                            return Ok(());
                        };
                        let place = sensors.iter().position(|sensor| sensor.number == sample.source);
                        let is_known = place.is_some() || sample.source == source.number;
                        // A replay that is started again publishes some events twice.
                        if let Some(event) = SensorEvent::of_sample(&sample)
                            && is_known
                            && sample.sequence >= next_sequence
                        {
                            next_sequence = sample.sequence + 1;
                            recorded.events.push((place, event));
                        }
                    }
                    Some(ReadTopic::Reports) => {
                        let report = WideArea::of_octets(octets).and_then(|sample| WideAreaReport::of_sample(&sample));
                        recorded.reports.extend(report);
                    }
                    None => {}
                }
                Ok(())
            });
            read.with_context(|| format!("reading {}", path.display()))?;
            if damaged > 0 {
                let path = path.display();
                host.say(&format!(
                    "koseki: {path}: damaged parts skipped: {damaged} ({damaged_bytes} bytes)\n"
                ));
            }
        }
        if recorded.events.is_empty() {
            let what = format!("contains no detection of the tracker {}", source.name);
            return Err(InputError::new(&track.detections[0], what).into());
        }
        Ok(recorded)
    }

    /// Time of the first event, nanoseconds.
    fn first_ns(&self) -> i64 {
        self.events.first().map_or(0, |(_, event)| event.time_ns())
    }

    fn detections(&self) -> impl Iterator<Item = observations::Detection> + '_ {
        self.events.iter().filter_map(|(_, event)| match event {
            SensorEvent::Detection(detection) => Some(*detection),
            _ => None,
        })
    }
}
