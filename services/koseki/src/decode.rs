//! `koseki decode`: the records of a recording as JSON, or statistics of them (FM-8).
//!
//! What a recording holds and which of it can be believed is the business of [`formats::recording`]; here are files,
//! tables and sentences. Standard output has what was asked for and nothing else; what was refused is summed up on
//! standard error, each reason with its first occurrence.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, BufWriter, IsTerminal as _, Write};
use std::path::Path;

use anyhow::Context as _;
use formats::asterix::{Mode, NamedRecord};
use formats::containers::TimeStamp;
use formats::recording::{CategorySurvey, Rate, Recording, Refusal, Statistics, Survey};
use serde_json::json;
use telemetry::table::{Align, Table, count};

use crate::args::{Decode, Usage};

/// What `--out` means by standard output.
const STANDARD_OUTPUT: &str = "-";
/// Recordings shorter than this are decoded before anybody wonders.
const PROGRESS_BYTES_MIN: usize = 64 << 20;
/// Reasons that are shown on standard error; `--statistics` shows all.
const REASONS_SHOWN_MAX: usize = 20;
/// Other editions that are shown.
const EDITIONS_SHOWN_MAX: usize = 4;

/// Decodes.
///
/// # Errors
/// If what is asked for makes no sense, or a file cannot be read or written.
pub(crate) fn run(decode: &Decode) -> anyhow::Result<()> {
    check(decode)?;
    let bytes = fs::read(&decode.file).with_context(|| format!("{} cannot be read", decode.file.display()))?;
    let recording = open(decode, &bytes);
    let survey = recording.survey();
    if let Some(out) = &decode.out {
        write_records(&recording, &survey, bytes.len(), out)?;
    }
    if decode.statistics {
        let statistics = gather(&recording, &survey);
        crate::print(&tables(&decode.file, &survey, &statistics))?;
        if let Some(path) = &decode.json {
            let text = format!("{:#}\n", as_json(&survey, &statistics));
            fs::write(path, text).with_context(|| format!("{} cannot be written", path.display()))?;
        }
    }
    // With standard error closed, the records are written all the same.
    let _ = io::stderr().write_all(notes(decode, &survey).as_bytes());
    Ok(())
}

fn check(decode: &Decode) -> Result<(), Usage> {
    let refuse = |what: &str| Err(Usage(format!("{what} (see `koseki decode --help`)")));
    let to_standard_output = decode.out.as_deref() == Some(Path::new(STANDARD_OUTPUT));
    match &decode.out {
        None if !decode.statistics => refuse(
            "nothing is asked for: write the records with --out FILE.jsonl, or with --out - to standard output, or \
             print statistics with --statistics",
        )?,
        Some(_) if to_standard_output && decode.statistics => {
            refuse("--out - and --statistics would mix on standard output: give --out a file")?;
        }
        _ => {}
    }
    for written in [&decode.out, &decode.json].into_iter().flatten() {
        if is_same_file(written, &decode.file) {
            refuse(&format!(
                "{} is the recording itself: name another file",
                written.display()
            ))?;
        }
    }
    let mut numbers: Vec<u8> = decode.editions.iter().map(|table| table.number).collect();
    numbers.sort_unstable();
    match numbers.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => refuse(&format!(
            "--edition names two editions of category {:03}: name one",
            pair[0]
        )),
        None => Ok(()),
    }
}

fn is_same_file(one: &Path, other: &Path) -> bool {
    matches!((fs::canonicalize(one), fs::canonicalize(other)), (Ok(one), Ok(other)) if one == other)
}

fn open<'a>(decode: &Decode, bytes: &'a [u8]) -> Recording<'a> {
    let mut recording = Recording::new(bytes);
    if let Some(container) = decode.container {
        recording = recording.in_container(container);
    }
    if decode.strict {
        recording = recording.with_mode(Mode::Strict);
    }
    decode
        .editions
        .iter()
        .fold(recording, |recording, table| recording.with_table(table))
}

fn write_records(recording: &Recording<'_>, survey: &Survey, bytes: usize, out: &Path) -> anyhow::Result<()> {
    if out == Path::new(STANDARD_OUTPUT) {
        return match write_lines(recording, survey, bytes, io::stdout().lock()) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
            _ => Ok(()),
        };
    }
    let file = File::create(out).with_context(|| format!("--out {} cannot be made", out.display()))?;
    write_lines(recording, survey, bytes, file).with_context(|| format!("--out {} cannot be written", out.display()))
}

fn write_lines(recording: &Recording<'_>, survey: &Survey, bytes: usize, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let mut progress = Progress::new(bytes);
    let mut line = Vec::new();
    recording.for_each(survey, |found| {
        let mut named = NamedRecord::new(found.record);
        named.time_stamp_s = found.time_stamp.map(TimeStamp::seconds);
        line.clear();
        named.write_json(&mut line);
        line.push(b'\n');
        progress.at(found.record.offset());
        out.write_all(&line)
    })?;
    out.flush()
}

/// How far a long recording is decoded, on a terminal.
struct Progress {
    bytes: usize,
    percent: usize,
    is_shown: bool,
}

impl Progress {
    fn new(bytes: usize) -> Self {
        Self {
            bytes,
            percent: 0,
            is_shown: bytes >= PROGRESS_BYTES_MIN && io::stderr().is_terminal() && !io::stdout().is_terminal(),
        }
    }

    fn at(&mut self, offset: usize) {
        let percent = offset / (self.bytes / 100).max(1);
        if self.is_shown && percent > self.percent {
            self.percent = percent;
            let _ = write!(io::stderr(), "\r{percent} %");
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.percent > 0 {
            let _ = write!(io::stderr(), "\r     \r");
        }
    }
}

fn gather(recording: &Recording<'_>, survey: &Survey) -> Statistics {
    let mut statistics = Statistics::default();
    let Ok(()) = recording.for_each(survey, |found| {
        statistics.add(found.record, found.time_stamp);
        Ok::<(), std::convert::Infallible>(())
    });
    statistics
}

// ---------------------------------------------------------------------------------------------------------------------
// Sentences for standard error.
// ---------------------------------------------------------------------------------------------------------------------

/// What was found in one line, and a line for everything that was not given.
fn notes(decode: &Decode, survey: &Survey) -> String {
    let mut text = format!(
        "koseki: {}: {} of {} in {} ({})\n",
        decode.file.display(),
        several(records_given(survey), "record"),
        several(survey.blocks(), "block"),
        several(survey.unpacked.datagrams, "datagram"),
        survey.container,
    );
    // Writing to a string cannot fail.
    let mut note = |line: &str| writeln!(text, "koseki: {line}").unwrap_or(());
    for (number, category) in &survey.categories {
        if category.blocks_refused > 0 {
            note(&verdict(*number, category));
        }
    }
    let refusals = survey.refusals.by_count();
    // A table shows them better.
    let shown = if decode.statistics { 0 } else { REASONS_SHOWN_MAX };
    for refusal in refusals.iter().take(shown) {
        note(&sentence(refusal));
    }
    if !decode.statistics && refusals.len() > shown {
        note(&format!(
            "and for {} more reasons; --statistics shows all",
            refusals.len() - shown
        ));
    }
    text
}

fn records_given(survey: &Survey) -> u64 {
    let given = survey.categories.values().filter(|category| !category.is_withheld());
    given.map(|category| category.records).sum()
}

/// What becomes of a category of which not all blocks fit, and what to try.
fn verdict(number: u8, category: &CategorySurvey) -> String {
    let Some(edition) = category.edition else {
        let blocks = several(category.blocks, "block");
        return format!("category {number:03}: {blocks} left out; there is no table of this category");
    };
    let refused = format!(
        "category {number:03}: {} of {} not fit edition {edition}",
        count(category.blocks_refused),
        match category.blocks {
            1 => "1 block does".to_owned(),
            blocks => format!("{} blocks do", count(blocks)),
        },
    );
    let consequence = match category.is_withheld() {
        true => "none of its records is given, since those that fit may do so by accident",
        false => "they are left out",
    };
    let remedy = match (category.better(), category.is_withheld()) {
        (Some((editions, fitting)), _) => {
            let names: Vec<String> = editions
                .iter()
                .take(EDITIONS_SHOWN_MAX)
                .map(ToString::to_string)
                .collect();
            let (first, same) = (&names[0], names[1..].join(", "));
            let so_do = if same.is_empty() {
                same
            } else {
                format!(" (so do {same})")
            };
            let fitting = count(fitting);
            format!("; edition {first} fits {fitting} of them{so_do}: try --edition {number}={first}")
        }
        (None, true) => {
            let others: Vec<String> = category.others.iter().map(|(edition, _)| edition.to_string()).collect();
            match others.is_empty() {
                true => "; there is no table of another edition".to_owned(),
                false => format!(
                    "; the other editions here ({}) fit no better, so the sender uses one that is not known",
                    others.join(", ")
                ),
            }
        }
        (None, false) => String::new(),
    };
    format!("{refused}: {consequence}{remedy}")
}

fn sentence(refusal: &Refusal) -> String {
    let place = match (refusal.category, refusal.item) {
        (Some(category), Some(item)) => format!(" in I{category:03}/{item}"),
        (Some(category), None) => format!(" in category {category:03}"),
        (None, _) => String::new(),
    };
    format!(
        "{} x {}{place} ({}), the first: {}",
        count(refusal.count),
        refusal.reason,
        several(refusal.octets, "octet"),
        refusal.first
    )
}

fn several(number: u64, what: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {what}{plural}", count(number))
}

// ---------------------------------------------------------------------------------------------------------------------
// Tables and JSON for standard output and files.
// ---------------------------------------------------------------------------------------------------------------------

fn tables(file: &Path, survey: &Survey, statistics: &Statistics) -> String {
    let mut text = format!("{}, {}\n", file.display(), survey.container);
    let mut section = |table: Table| write!(text, "\n{table}").unwrap_or(());
    section(table_of_octets(survey));
    section(table_of_categories(survey));
    section(table_of_senders(statistics));
    if !survey.refusals.by_count().is_empty() {
        section(table_of_refusals(survey));
    }
    text
}

fn table_of_octets(survey: &Survey) -> Table {
    let mut table = Table::new(&[("counted", Align::Right), ("", Align::Left)]);
    for (_, sentence, value) in survey.unpacked.entries() {
        if value > 0 {
            table.row([count(value), sentence.to_owned()]);
        }
    }
    table
}

fn table_of_categories(survey: &Survey) -> Table {
    let mut table = Table::new(&[
        ("category", Align::Left),
        ("edition", Align::Left),
        ("blocks", Align::Right),
        ("refused", Align::Right),
        ("records", Align::Right),
        ("", Align::Left),
    ]);
    for (number, category) in &survey.categories {
        let withheld = category.is_withheld();
        table.row([
            format!("{number:03}"),
            category
                .edition
                .map_or_else(|| "-".to_owned(), |edition| edition.to_string()),
            count(category.blocks),
            count(category.blocks_refused),
            count(if withheld { 0 } else { category.records }),
            if withheld { "withheld" } else { "" }.to_owned(),
        ]);
    }
    table
}

fn table_of_senders(statistics: &Statistics) -> Table {
    let mut table = Table::new(&[
        ("category", Align::Left),
        ("source", Align::Left),
        ("records", Align::Right),
        ("first", Align::Left),
        ("last", Align::Left),
        ("min/s", Align::Right),
        ("median/s", Align::Right),
        ("max/s", Align::Right),
    ]);
    let unknown = || "-".to_owned();
    for summary in statistics.senders() {
        let rate = |of: fn(Rate) -> u64| summary.rate.map_or_else(unknown, |rate| count(of(rate)));
        let source = summary.sender.source;
        table.row([
            format!("{:03}", summary.sender.category),
            source.map_or_else(unknown, |(area, identification)| format!("{area}/{identification}")),
            count(summary.records),
            summary.first_s.map_or_else(unknown, time_of_day),
            summary.last_s.map_or_else(unknown, time_of_day),
            rate(|rate| rate.min),
            rate(|rate| rate.median),
            rate(|rate| rate.max),
        ]);
    }
    table
}

fn table_of_refusals(survey: &Survey) -> Table {
    let mut table = Table::new(&[
        ("refused", Align::Right),
        ("octets", Align::Right),
        ("category", Align::Left),
        ("item", Align::Left),
        ("reason", Align::Left),
        ("the first", Align::Left),
    ]);
    for refusal in survey.refusals.by_count() {
        table.row([
            count(refusal.count),
            count(refusal.octets),
            refusal
                .category
                .map_or_else(|| "-".to_owned(), |category| format!("{category:03}")),
            refusal.item.unwrap_or("-").to_owned(),
            refusal.reason.to_owned(),
            refusal.first.clone(),
        ]);
    }
    table
}

/// `22:00:01.250`, and on other days than the first `00:00:01.250 +1 d`.
fn time_of_day(seconds: f64) -> String {
    const DAY_MS: i64 = 86_400_000;
    let all_ms = (seconds * 1000.0).round() as i64;
    let (day, ms) = (all_ms.div_euclid(DAY_MS), all_ms.rem_euclid(DAY_MS));
    let (minutes, ms) = (ms / 60_000, ms % 60_000);
    let time = format!(
        "{:02}:{:02}:{:02}.{:03}",
        minutes / 60,
        minutes % 60,
        ms / 1000,
        ms % 1000
    );
    match day {
        0 => time,
        day => format!("{time} {day:+} d"),
    }
}

fn as_json(survey: &Survey, statistics: &Statistics) -> serde_json::Value {
    let counters = survey
        .unpacked
        .entries()
        .map(|(label, _, value)| (label.to_owned(), json!(value)));
    let categories = survey.categories.iter().map(|(number, category)| {
        json!({
            "category": number,
            "edition": category.edition.map(|edition| edition.to_string()),
            "blocks": category.blocks,
            "blocks_refused": category.blocks_refused,
            "records": category.records,
            "withheld": category.is_withheld(),
        })
    });
    json!({
        "container": survey.container.word(),
        "unpacked": counters.into_iter().collect::<serde_json::Map<_, _>>(),
        "categories": categories.collect::<Vec<_>>(),
        "senders": statistics.senders().collect::<Vec<_>>(),
        "refusals": survey.refusals.by_count(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_show_the_day_they_are_of() {
        assert_eq!(time_of_day(79_201.25), "22:00:01.250");
        assert_eq!(time_of_day(86_461.999_6), "00:01:02.000 +1 d");
        assert_eq!(time_of_day(-1.0), "23:59:59.000 -1 d");
    }
}
