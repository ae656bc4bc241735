//! `koseki check`: validates a configuration and its recordings, and summarises the deployment.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use alerts::NamedArea;
use deployment::{Input, ReportOrder, Source, TrackFeed, WaitWord, WideAreaInput, WideAreaSensor};
use fusion::settings::StampRounding;
use monitor::MonitorWait;
use offline::Usage;
use scenario::ScenarioSettings;
use serde_json::{Value, json};
use sources::TrackerSettings;
use telemetry::table::duration;
use telemetry::{Deadlines, Stage};
use tracking::cutting::Boundaries;
use tracking::turn_time::Basis;

use crate::args::{self, Check};
use crate::check_trackers;
use crate::config::Config;
use crate::link::{self, LinkFindings};
use crate::recordings::{self, Depth, RecordingFindings};

/// Nanoseconds in a second.
const NS: i64 = 1_000_000_000;
/// Logarithm of the ratio of a turn to the configured period, beyond which either is wrong.
const PERIOD_DOUBT: f64 = 0.15;

/// Validates, and prints a summary.
///
/// # Errors
/// If the configuration or a recording cannot be used.
pub(crate) fn run(check: &Check) -> anyhow::Result<()> {
    let data = args::data_folder(check.data.clone());
    let sides = [Some(&check.config), check.other.as_ref()].into_iter().flatten();
    let sides: Vec<Side<'_>> = sides
        .map(|path| Side::read(path, check, &data))
        .collect::<anyhow::Result<_>>()?;
    let has_links = sides.iter().any(|side| !side.config.links.is_empty());
    let links = match has_links || sides.len() > 1 {
        true => {
            let paths: Vec<&Path> = sides.iter().map(|side| side.path).collect();
            link::examine(&paths, &check.set)?
        }
        false => LinkFindings::default(),
    };
    refuse(&links, check.json)?;
    let free_bytes = bus::free_space().ok();
    if check.json {
        let mut all: Vec<Value> = sides.iter().map(|side| side.json(free_bytes, &links)).collect();
        let all = match all.len() {
            1 => all.remove(0),
            _ => Value::Array(all),
        };
        return crate::print(&(serde_json::to_string_pretty(&all)? + "\n"));
    }
    let mut text: Vec<String> = sides.iter().map(|side| side.summary(free_bytes)).collect();
    text.push(summary_of_links(&links));
    text.retain(|part| !part.is_empty());
    crate::print(&text.join("\n"))
}

/// A configuration that is sound by itself, with the findings in its recordings.
struct Side<'a> {
    path: &'a Path,
    config: Config,
    found: Vec<RecordingFindings>,
    areas: Vec<NamedArea>,
}

impl<'a> Side<'a> {
    fn read(path: &'a Path, check: &Check, data: &Path) -> anyhow::Result<Self> {
        let config = Config::read(path, &check.set)?;
        let found = recordings::inspect(&config, data, Depth::Records)?;
        display::check_maps(config.parts.display(), &config.frame, data).map_err(Usage)?;
        display::check_views(config.parts.display(), data).map_err(Usage)?;
        let areas = alerts_service::read_areas(&config.alerts, config.frame, data)
            .map_err(|refusal| Usage(format!("{}: {refusal}", path.display())))?;
        Ok(Self {
            path,
            config,
            found,
            areas,
        })
    }

    fn summary(&self, free_bytes: Option<u64>) -> String {
        let mut text = summary(self.path, &self.config, &self.found, free_bytes);
        self.write_alerts(&mut text);
        text
    }

    /// Writes the rules of alerts, and the areas with their limits: what a file lacks is unlimited.
    fn write_alerts(&self, text: &mut String) {
        let rules = self.config.alerts.rules.iter();
        let rules = rules.map(|rule| ("alert", rule.title().to_owned()));
        let areas = self.areas.iter().map(|named| {
            let limits = &named.area.limits;
            let [floor, ceiling] = [limits.floor, limits.ceiling].map(|level| level.map(|level| level.to_string()));
            let (floor, ceiling) = (
                floor.as_deref().unwrap_or("no floor"),
                ceiling.as_deref().unwrap_or("no ceiling"),
            );
            (
                "area",
                format!("{}: {floor} to {ceiling}", messages::printable(&named.area.name, 60)),
            )
        });
        for (title, row) in rules.chain(areas) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{title:<12} {row}");
        }
    }

    fn json(&self, free_bytes: Option<u64>, links: &LinkFindings) -> Value {
        let mut all = json(self.path, &self.config, &self.found, free_bytes);
        if let Some(warnings) = all["warnings"].as_array_mut() {
            let file = self.path.display().to_string();
            // A warning that names no file concerns this machine.
            let is_of = |text: &&String| text.starts_with(&file) || text.starts_with("koseki-link");
            warnings.extend(links.warnings.iter().filter(is_of).map(|text| json!(text)));
        }
        all
    }
}

/// Refuses with a line for each mistake.
fn refuse(links: &LinkFindings, is_json: bool) -> anyhow::Result<()> {
    let Some((last, others)) = links.refused.split_last() else {
        return Ok(());
    };
    if is_json {
        let all = json!({ "sound": false, "refused": links.refused, "warnings": links.warnings });
        crate::print(&(serde_json::to_string_pretty(&all)? + "\n"))?;
    }
    for other in others {
        runtime::notice(format_args!("koseki: {other}"));
    }
    Err(Usage(last.clone()).into())
}

fn summary_of_links(links: &LinkFindings) -> String {
    let mut text = String::new();
    let rows = links
        .links
        .iter()
        .map(|each| ("link", format!("{}: {}", each.name, each.text)));
    for (title, row) in rows.chain(links.warnings.iter().map(|warning| ("warning", warning.clone()))) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{title:<12} {row}");
    }
    text
}

/// The summary for programs.
fn json(path: &Path, config: &Config, found: &[RecordingFindings], free_bytes: Option<u64>) -> Value {
    let settings = &config.engine;
    let source = |source: &Source| {
        let found = found.iter().find(|found| found.source == source.number);
        json!({
            "number": source.number,
            "name": source.name,
            "adapter": source.adapter,
            "period_s": period_s(source, config, found),
            "text": describe(source, config, found),
            "recording": found.map(|found| json!({
                "file": found.file,
                "bytes": found.bytes,
                "blocks": found.blocks,
                "records": found.records,
                "bytes_skipped": found.skipped,
            })),
        })
    };
    let wide_area = |sensor: &WideAreaSensor| {
        json!({
            "number": sensor.number,
            "name": sensor.name,
            "text": describe_wide_area(sensor, config),
        })
    };
    let monitor = config.parts.monitor();
    let deadlines_of_monitor = monitor.configured_deadlines(&config.fusion);
    let deadline_us = |stage: Stage| {
        let deadline_ns = deadlines_of_monitor.get(stage)?;
        Some((stage.key(), deadline_ns as f64 / 1e3))
    };
    let warnings = settings.doubtful_lifetimes().into_iter().map(|doubt| doubt.to_string());
    let warnings = warnings.chain(settings.border.gaps().into_iter().map(|gap| gap.to_string()));
    let warnings = warnings
        .chain(doubtful_periods(config, found))
        .chain(doubtful_editions(found));
    json!({
        "sound": true,
        "warnings": warnings.collect::<Vec<_>>(),
        "configuration": path,
        "deployment": config.name,
        "rule": settings.rule.name.0.word(),
        "order": match config.order {
            ReportOrder::Arrival => "arrival",
            ReportOrder::Time => "time",
        },
        "wait": wait(config.fusion.wait),
        "place": place(config),
        "capacity": {
            "system_tracks": settings.capacity.system_tracks(),
            "sensor_tracks": settings.capacity.sensor_tracks(),
            "waiting_reports_per_source": config.system_tracks.queue,
        },
        "monitor": {
            "interval_s": monitor.interval_s.ns() as f64 / NS as f64,
            "files": monitor.files,
            "wait": watching(monitor.waiting(&config.fusion)),
            "deadline_us": Stage::ALL.into_iter().filter_map(deadline_us).collect::<BTreeMap<_, _>>(),
            "metrics": monitor.metrics().map(|address| address.to_string()),
        },
        "recorder": config.parts.recorder().enabled,
        "shared_memory": {
            "needed_bytes": launcher::needed_bytes(config),
            "free_bytes": free_bytes,
        },
        "sources": config.sources.iter().map(source).collect::<Vec<_>>(),
        "wide_area_sensors": config.wide_area_sensors.iter().map(wide_area).collect::<Vec<_>>(),
    })
}

/// Returns the time between two reports of a target by the source, seconds; `None` if the source's adapter measures
/// it.
fn period_s(source: &Source, config: &Config, found: Option<&RecordingFindings>) -> Option<f64> {
    let period_ns = match config.tracker(source.number).filter(|tracker| !tracker.events) {
        Some(tracker) => tracker.joining.cutters[0].period_ns.or(found?.turn.map(|turn| turn.ns)),
        None => Some(config.engine.sources[usize::from(source.number)].period_ns),
    };
    Some(period_ns? as f64 / NS as f64)
}

/// Period of a source's reports of a target, with the origin of a value that is not configured.
fn period(source: &Source, config: &Config, found: Option<&RecordingFindings>) -> String {
    let Some(period_s) = period_s(source, config, found) else {
        return "every antenna turn, with a duration measured by the adapter".to_owned();
    };
    let is_configured = config
        .tracker(source.number)
        .is_none_or(|tracker| tracker.events || tracker.joining.cutters[0].period_ns.is_some());
    match found.and_then(|found| found.turn).filter(|_| !is_configured) {
        Some(turn) => format!("every {} s, as {} show", digits(period_s), shown_by(turn.basis)),
        None => format!("every {period_s} s"),
    }
}

/// Blocks of recordings that fit another edition better.
fn doubtful_editions(found: &[RecordingFindings]) -> impl Iterator<Item = String> {
    let doubts = |found: &RecordingFindings| {
        let file = found.file.display().to_string();
        let doubts = found.doubts.iter().map(move |doubt| format!("{file}: {doubt}"));
        doubts.collect::<Vec<_>>()
    };
    found.iter().flat_map(doubts)
}

/// A period that is configured, and that the source's recording contradicts.
fn doubtful_periods<'a>(config: &'a Config, found: &'a [RecordingFindings]) -> impl Iterator<Item = String> + 'a {
    found.iter().filter_map(|found| {
        let source = &config.sources[usize::from(found.source)];
        let (configured_ns, turn) = (config.tracker(found.source)?.joining.cutters[0].period_ns?, found.turn?);
        let configured_s = configured_ns as f64 / NS as f64;
        let turn_s = turn.ns as f64 / NS as f64;
        ((turn_s / configured_s).ln().abs() > PERIOD_DOUBT).then(|| {
            format!(
                "source[{}].period_s = {configured_s}: a turn of {} takes {} s, as {} show; write that, or leave \
                 period_s out",
                found.source,
                source.name,
                digits(turn_s),
                shown_by(turn.basis)
            )
        })
    })
}

fn shown_by(basis: Basis) -> &'static str {
    match basis {
        Basis::Stated => "its messages",
        Basis::NorthMarks => "its north marks",
        Basis::Detections => "its plots",
    }
}

/// Seconds to the hundredth, without zeros at the end.
fn digits(seconds: f64) -> f64 {
    (100.0 * seconds).round() / 100.0
}

fn summary(path: &Path, config: &Config, found: &[RecordingFindings], free_bytes: Option<u64>) -> String {
    let mut text = format!("{} is sound.\n\n", path.display());
    let mut row = |title: &str, content: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{title:<12} {content}");
    };
    let order = match config.order {
        ReportOrder::Arrival => "in order of arrival (live)",
        ReportOrder::Time => "in order of time (the result does not depend on speed)",
    };
    let settings = &config.engine;
    row("deployment", config.name.clone());
    row("fusion", format!("rule {}, {order}", settings.rule.name.0.word()));
    row("", format!("waits by {}, {}", wait(config.fusion.wait), place(config)));
    let capacity = &settings.capacity;
    row(
        "capacities",
        format!(
            "{} system tracks, {} sensor tracks, {} waiting reports per source",
            capacity.system_tracks(),
            capacity.sensor_tracks(),
            config.system_tracks.queue
        ),
    );
    let monitor = config.parts.monitor();
    let seconds = monitor.interval_s.ns() as f64 / NS as f64;
    let files = if monitor.files { "with files" } else { "without files" };
    row(
        "monitor",
        format!(
            "a table every {seconds} s, {files}; {}",
            watching(monitor.waiting(&config.fusion))
        ),
    );
    let late = match config.order {
        ReportOrder::Arrival => format!("deadline: {}", deadlines(monitor.configured_deadlines(&config.fusion))),
        ReportOrder::Time => "nothing is late: reports wait for each other by intention".to_owned(),
    };
    row("", late);
    if let Some(address) = monitor.metrics() {
        row("", format!("metrics for Prometheus at http://{address}/metrics"));
    }
    let recorder = if config.parts.recorder().enabled { "on" } else { "off" };
    row("recorder", recorder.to_owned());
    let regions = &settings.border.regions;
    if !regions.is_empty() {
        let own = regions.iter().filter(|region| region.is_own).count();
        let others = regions.len() - own;
        row(
            "regions",
            format!("{own} of this deployment, {others} of other centres"),
        );
    }
    for doubt in settings.doubtful_lifetimes() {
        row("warning", doubt.to_string());
    }
    for gap in settings.border.gaps() {
        row("warning", gap.to_string());
    }
    let doubts = doubtful_periods(config, found).chain(doubtful_editions(found));
    for doubt in doubts.chain(check_trackers::doubts(config)) {
        row("warning", doubt);
    }
    let free = free_bytes.map_or_else(String::new, |free| format!("; {} are free", size(free)));
    let needed = size(launcher::needed_bytes(config));
    row("memory", format!("at most {needed} of shared memory{free}"));
    text.push('\n');
    for source in &config.sources {
        let found = found.iter().find(|found| found.source == source.number);
        let _ = writeln!(text, "source {}     {}", source.number, describe(source, config, found));
    }
    for sensor in &config.wide_area_sensors {
        let _ = writeln!(
            text,
            "wide area {}  {}",
            sensor.number,
            describe_wide_area(sensor, config)
        );
    }
    for platform in &config.platforms {
        let _ = writeln!(
            text,
            "platform {}   {}",
            platform.number,
            check_trackers::describe_platform(platform, &config.readings.platforms[usize::from(platform.number)])
        );
    }
    text
}

fn describe(source: &Source, config: &Config, found: Option<&RecordingFindings>) -> String {
    let period = period(source, config, found);
    let input = match (&source.input, found) {
        (Input::Simulated(_), _) => {
            let world = config.world.targets.as_ref().map_or_else(String::new, describe_world);
            format!("simulated; observes a world of {world}")
        }
        (Input::Live(live), _) => format!("live, behind receiver {}", live.receiver),
        (Input::External, _) => "external, published by a separate process".to_owned(),
        (Input::Tracker(_), _) => check_trackers::describe(source, config),
        (Input::Recorded(recorded), None) => recorded.file.display().to_string(),
        (Input::Recorded(recorded), Some(found)) => {
            let editions: Vec<String> = recordings::tables(recorded)
                .tables()
                .iter()
                .map(ToString::to_string)
                .collect();
            let skipped = match found.skipped {
                0 => String::new(),
                bytes => format!(", {bytes} bytes not understood"),
            };
            format!(
                "{}, {}, {} records{skipped}, {} to {} UTC{}{}",
                found.file.display(),
                size(found.bytes as u64),
                found.records,
                time_of_day(found.first_time_ns),
                time_of_day(found.last_time_ns),
                if editions.is_empty() { "" } else { ", " },
                editions.join(" and ")
            )
        }
    };
    let tracked = config
        .tracker(source.number)
        .filter(|tracker| !tracker.events)
        .map_or("", |tracker| match tracker.joining.cutters[0].boundaries {
            Boundaries::Stated => "; its adapter makes tracks of its plots, scan by scan",
            Boundaries::Turn => "; its adapter makes tracks of its plots, turn by turn",
            Boundaries::Period => "; its adapter makes tracks of its plots, period by period",
        });
    let links = config
        .tracker(source.number)
        .map_or_else(String::new, |tracker| links(tracker, source, config));
    let stamps = stamps(config.engine.sources[usize::from(source.number)].stamps, found);
    format!("{}, {period}: {input}{stamps}{tracked}{links}", source.name)
}

/// Step of which the time stamps of a recording are multiples, with the rounding that fusion assumes.
fn stamps(stated: Option<StampRounding>, found: Option<&RecordingFindings>) -> String {
    let rounding = stated.unwrap_or(StampRounding::Unknown).word();
    match found.and_then(|found| found.stamps.multiples_of_s()) {
        Some(step_s) => format!("; its stamps are multiples of {step_s} s, rounding {rounding}"),
        None => stated.map_or_else(String::new, |_| {
            format!("; of coarse stamps the rounding is {rounding}")
        }),
    }
}
fn describe_world(world: &ScenarioSettings) -> String {
    let formations: u32 = world.formations.iter().map(|kind| kind.count).sum();
    match (world.targets, formations) {
        (targets, 0) => format!("{targets} targets"),
        (0, formations) => format!("{formations} formations only"),
        (targets, formations) => format!("{targets} targets beside {formations} formations"),
    }
}

/// Returns the tracker's optional tasks, if configured.
fn links(tracker: &TrackerSettings, source: &Source, config: &Config) -> String {
    let mut text = String::new();
    if let Some(period_ns) = tracker.outputs.period_ns {
        // Writing to a string cannot fail.
        let _ = write!(text, ", given out every {} s", period_ns as f64 / NS as f64);
    }
    let finder = |number: &u16| config.sources[usize::from(*number)].name.as_str();
    let finders: Vec<&str> = source.links.emissions.iter().map(finder).collect();
    if !finders.is_empty() {
        let _ = write!(text, ", identified by what {} hears", finders.join(" and "));
    }
    text + if tracker.outputs.cues {
        "; it says where to look next"
    } else {
        ""
    }
}

fn describe_wide_area(sensor: &WideAreaSensor, config: &Config) -> String {
    let input = match &sensor.input {
        _ if sensor.is_simulated => "counts, simulated".to_owned(),
        WideAreaInput::Live(receiver) => format!("counts, live, behind receiver {receiver}"),
        WideAreaInput::Recorded(file) => format!("counts, {}", file.display()),
        WideAreaInput::Tracks(tracks) => {
            let from = match &tracks.feed {
                TrackFeed::Receiver(receiver) => format!("live, behind receiver {receiver}"),
                TrackFeed::File(file) => file.display().to_string(),
            };
            let (period, group) = (tracks.period_ns as f64 / NS as f64, tracks.group_m);
            format!("another system's tracks, {from}; those within {group} m are counted every {period} s")
        }
        WideAreaInput::External => "counts, external, published by a separate process".to_owned(),
    };
    let listens = |source: &&Source| source.links.wide_area_sensors.contains(&sensor.number);
    let listeners: Vec<&str> = config
        .sources
        .iter()
        .filter(listens)
        .map(|source| source.name.as_str())
        .collect();
    let heard = match &listeners[..] {
        [] => "no tracker".to_owned(),
        names => format!("the tracker of {}", names.join(", ")),
    };
    format!("{}: {input}; {heard} listens to it", sensor.name)
}

fn wait(word: WaitWord) -> &'static str {
    match word {
        WaitWord::Spin => "spinning",
        WaitWord::Event => "sleeping",
        WaitWord::Hybrid => "spinning, then sleeping",
    }
}

fn watching(wait: MonitorWait) -> String {
    match wait {
        MonitorWait::Event => "woken for each slice of system tracks".to_owned(),
        MonitorWait::Poll { pause } => format!(
            "looks every {} ms, so transport out is not measured",
            pause.as_secs_f64() * 1e3
        ),
    }
}

fn deadlines(deadlines: Deadlines) -> String {
    let of = |stage: Stage| Some((stage, deadlines.get(stage)?));
    let words = Stage::ALL
        .into_iter()
        .filter_map(of)
        .map(|(stage, deadline_ns)| format!("{} {}", stage.label(), duration(deadline_ns as f64)));
    words.collect::<Vec<_>>().join(", ")
}

fn place(config: &Config) -> String {
    let place = runtime::cores::Placement::from(&config.fusion);
    let mut words = vec![match place.core {
        Some(core) => format!("on core {core}"),
        None => "on any core".to_owned(),
    }];
    words.extend(place.realtime_priority.map(|priority| format!("SCHED_FIFO {priority}")));
    words.extend(place.lock_memory.then(|| "memory locked".to_owned()));
    words.extend(config.fusion.required.then(|| "all of it required".to_owned()));
    words.join(", ")
}

pub(crate) fn size(bytes: u64) -> String {
    let bytes = bytes as f64;
    if bytes >= 1e9 {
        format!("{:.1} GB", bytes / 1e9)
    } else if bytes >= 1e6 {
        format!("{:.1} MB", bytes / 1e6)
    } else {
        format!("{:.1} kB", bytes / 1e3)
    }
}

fn time_of_day(time_ns: Option<i64>) -> String {
    let Some(seconds) = time_ns.map(|ns| ns / NS) else {
        return "?".to_owned();
    };
    let (minutes, second) = (seconds / 60, seconds % 60);
    format!("{:02}:{:02}:{second:02}", minutes / 60, minutes % 60)
}

#[cfg(test)]
mod tests;
