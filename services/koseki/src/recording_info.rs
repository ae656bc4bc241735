//! `koseki recording info`: summary of a recording of all topics.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use formats::rows::Utc;
use offline::InputError;
use recording::{Chunks, Item, Survey};
use serde_json::json;
use telemetry::table::{Align, TextTable};

use crate::args::RecordingInfo;

/// Gaps that are listed in text.
const GAPS_SHOWN: usize = 10;

/// Prints the summary of a recording.
///
/// # Errors
/// Without a recording, or if the recording cannot be read.
pub(crate) fn run(info: &RecordingInfo) -> anyhow::Result<()> {
    // The summary states which files have no end.
    let files = all_files(&info.path)?;
    let mut survey = Survey::default();
    for path in &files {
        let mut add = || survey.add(&mut File::open(path)?);
        add().with_context(|| format!("reading {}", path.display()))?;
    }
    crate::print(&match info.json {
        true => json(&survey, files.len()),
        false => text(&survey, files.len())?,
    })
}

fn json(survey: &Survey, files: usize) -> String {
    let topics = survey.topics.iter().map(|(name, topic)| {
        let of_topic = json!({
            "schema": topic.schema,
            "samples": topic.samples,
            "lost": topic.tally.lost,
            "slices": topic.slices,
            "publishers": topic.tally.publishers(),
            "first_ns": topic.first_ns,
            "last_ns": topic.last_ns,
        });
        (name.clone(), of_topic)
    });
    let topics: serde_json::Map<_, _> = topics.collect();
    let fact = |name: &str| survey.facts.get(name);
    let all = json!({
        "run": fact("run"),
        "version": fact("version"),
        "configuration": fact("configuration"),
        "files": files,
        "without_an_end": survey.torn,
        "damaged": {"parts": survey.damaged, "bytes": survey.damaged_bytes},
        "gaps_ns": survey.gaps_ns,
        "topics": topics,
    });
    format!("{all}\n")
}

/// Notes on standard error that an item stands for damaged bytes of a file.
pub(crate) fn note_damage(path: &Path, item: &Item<'_>) {
    if let Item::Damaged { bytes, reason } = item {
        let (path, begin, end) = (path.display(), bytes.start, bytes.end);
        let note = format!("koseki: {path}: bytes {begin} to {end} are damaged and were skipped: {reason}\n");
        // With standard error closed, the rest is read all the same.
        let _ = io::stderr().write_all(note.as_bytes());
    }
}

/// The files of a recording, in order. A file still being written is noted on standard error.
///
/// # Errors
/// If a file cannot be read, or is no recording: a wrong path on the command line.
pub(crate) fn files(path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let files = all_files(path)?;
    for file in &files {
        if recording::is_unended(&mut File::open(file)?)? {
            runtime::notice(format_args!("koseki: {}: {}", file.display(), recording::UNENDED));
        }
    }
    Ok(files)
}

fn all_files(path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let files = match path.is_dir() {
        true => files_in(path)?,
        false => vec![path.to_owned()],
    };
    for file in &files {
        let opened = offline::open(file)?;
        // The last file of a killed recorder may be empty, but then other files precede.
        if files.len() == 1 && opened.metadata()?.len() == 0 {
            return Err(InputError::new(file, "is no recording of all topics: the file is empty").into());
        }
        Chunks::new(opened).map_err(|error| InputError::new(file, error))?;
    }
    Ok(files)
}

fn files_in(path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(path).map_err(|error| InputError::unreadable(path, &error))?;
    let mut files = Vec::new();
    for entry in entries {
        let file = entry?.path();
        files.extend(file.extension().is_some_and(|ending| ending == "mcap").then_some(file));
    }
    files.sort();
    if files.is_empty() {
        let why = "no recording of all topics is in this folder; [recorder] format = [\"csv\", \"mcap\"] makes one";
        return Err(InputError::new(path, why).into());
    }
    Ok(files)
}

fn text(survey: &Survey, files: usize) -> anyhow::Result<String> {
    let mut out = String::new();
    for fact in ["run", "version"] {
        let said = survey.facts.get(fact).map_or("not said", String::as_str);
        writeln!(out, "{fact}: {said}")?;
    }
    writeln!(out, "files: {files}, without an end: {}", survey.torn)?;
    if survey.damaged > 0 {
        let (parts, bytes) = (survey.damaged, survey.damaged_bytes);
        writeln!(
            out,
            "damaged parts: {parts} ({bytes} bytes), skipped; `koseki recording repair` copies the rest"
        )?;
    }
    let configuration = survey.facts.get("configuration");
    let lines = configuration.map_or("not said".to_owned(), |text| {
        format!("{} lines, see --json", text.lines().count())
    });
    writeln!(out, "configuration: {lines}")?;
    let utc = |time_ns: u64| Utc(time_ns as i64).to_string();
    for [from_ns, to_ns] in survey.gaps_ns.iter().take(GAPS_SHOWN) {
        let seconds = (to_ns - from_ns) as f64 / 1e9;
        writeln!(out, "gap: {seconds:.1} s, from {} to {}", utc(*from_ns), utc(*to_ns))?;
    }
    if let Some(more) = survey.gaps_ns.len().checked_sub(GAPS_SHOWN).filter(|more| *more > 0) {
        writeln!(out, "and {more} more gaps, see --json")?;
    }
    out.push('\n');
    let mut table = TextTable::new(&[
        ("topic", Align::Left),
        ("samples", Align::Right),
        ("lost", Align::Right),
        ("slices", Align::Right),
        ("publishers", Align::Right),
        ("first (UTC)", Align::Left),
        ("last (UTC)", Align::Left),
    ]);
    for (name, topic) in &survey.topics {
        let time = |time_ns: Option<u64>| time_ns.map_or(String::new(), |time_ns| Utc(time_ns as i64).to_string());
        table.row([
            name.clone(),
            topic.samples.to_string(),
            topic.tally.lost.to_string(),
            topic.slices.to_string(),
            topic.tally.publishers().to_string(),
            time(topic.first_ns),
            time(topic.last_ns),
        ]);
    }
    out.push_str(&table.to_string());
    Ok(out)
}
