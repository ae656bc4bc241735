//! `koseki decode`: the records of a recording as JSON, or as statistics (FM-8).
//!
//! [`formats::recording`] decides on the content and its credibility; this module handles files, tables and
//! sentences. Standard output contains only the requested data; a summary of rejected blocks goes to standard error,
//! each reason with its first occurrence. A recording of categories that are known by name and have no table is no
//! failure.

mod notes;
mod tables;

use std::io::{self, IsTerminal as _, Write};
use std::path::Path;

use anyhow::Context as _;
use asterix::choice::ChosenEdition;
use asterix::{JsonLines, Mode};
use formats::containers::TimeStamp;
use formats::recording::{Expansions, RecordingBytes, RecordingSurvey, Statistics};
use offline::{BUFFER_OCTETS, InputError, OutputFile, Usage, is_same_file};

use crate::args::DecodeArgs;

/// Value of `--out` that means standard output.
const STANDARD_OUTPUT: &str = "-";
/// Why a recording cannot be used.
const NO_RECORD: &str = "no record of ASTERIX can be read";
/// Recordings shorter than this are decoded before anybody wonders.
const PROGRESS_BYTES_MIN: usize = 64 << 20;

/// Decodes.
///
/// # Errors
/// If the arguments are invalid, a file cannot be read or written, or no record can be decoded.
pub(crate) fn run(decode: &DecodeArgs) -> anyhow::Result<()> {
    check(decode)?;
    let bytes = offline::read(&decode.file)?;
    let recording = open(decode, &bytes);
    let survey = recording.survey();
    if let Some(kind) = survey.foreign(&bytes) {
        return Err(InputError::new(&decode.file, format!("{NO_RECORD}: {kind}")).into());
    }
    let statistics_json = decode.json.as_deref().map(OutputFile::begin).transpose()?;
    let mut expansions = Expansions::new(&decode.editions);
    if let Some(out) = &decode.out {
        let lines = RecordLines {
            recording: &recording,
            survey: &survey,
            bytes: bytes.len(),
        };
        lines.write_to(out, &mut expansions)?;
    }
    if decode.shows_statistics() {
        let statistics = gather(&recording, &survey);
        crate::print(&tables::tables(&decode.file, &survey, &statistics))?;
        if let Some(mut file) = statistics_json {
            writeln!(file, "{:#}", tables::as_json(&survey, &statistics))?;
            file.finish()?;
        }
    }
    // With standard error closed, the records are written all the same.
    let said = notes::notes(decode, &survey) + &notes::of_expansions(&expansions);
    let _ = io::stderr().write_all(said.as_bytes());
    if survey.records() == 0 && !survey.is_mostly_without_table() {
        return Err(InputError::new(&decode.file, NO_RECORD).into());
    }
    Ok(())
}

fn check(decode: &DecodeArgs) -> Result<(), Usage> {
    let refuse = |what: &str| Err(Usage(format!("{what} (see `koseki decode --help`)")));
    let to_standard_output = decode.out.as_deref() == Some(Path::new(STANDARD_OUTPUT));
    if to_standard_output && decode.shows_statistics() {
        refuse("--out - and statistics would mix on standard output: give --out a file")?;
    }
    for written in [&decode.out, &decode.json].into_iter().flatten() {
        if is_same_file(written, &decode.file) {
            refuse(&format!(
                "{} is the recording itself: name another file",
                written.display()
            ))?;
        }
    }
    let mut chosen: Vec<String> = decode.editions.iter().map(subject).collect();
    chosen.sort_unstable();
    match chosen.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => refuse(&format!("--edition names two editions of {}: name one", pair[0])),
        None => Ok(()),
    }
}

fn subject(chosen: &ChosenEdition) -> String {
    match chosen {
        ChosenEdition::Category(table) => format!("category {:03}", table.number),
        ChosenEdition::Expansion(rules) => format!("I{:03}/RE", rules.number),
    }
}

fn open<'a>(decode: &DecodeArgs, bytes: &'a [u8]) -> RecordingBytes<'a> {
    let mut recording = RecordingBytes::new(bytes);
    if let Some(container) = decode.container {
        recording = recording.in_container(container);
    }
    if decode.strict {
        recording = recording.with_mode(Mode::Strict);
    }
    recording.with_editions(&decode.editions)
}

/// The records of a recording as lines.
struct RecordLines<'r, 'b> {
    recording: &'r RecordingBytes<'b>,
    survey: &'r RecordingSurvey,
    bytes: usize,
}

impl RecordLines<'_, '_> {
    fn write_to(&self, out: &Path, expansions: &mut Expansions) -> anyhow::Result<()> {
        let mut file = OutputFile::begin(out)?;
        self.write(&mut file, expansions)
            .with_context(|| format!("{} cannot be written", out.display()))?;
        file.finish()
    }

    fn write(&self, mut out: impl Write, expansions: &mut Expansions) -> io::Result<()> {
        let mut progress = DecodeProgress::new(self.bytes);
        let mut lines = JsonLines::default();
        self.recording.for_each(self.survey, |found| {
            let expanded = expansions.content(found.record);
            let time_stamp_s = found.time_stamp.map(TimeStamp::seconds);
            lines.write(found.record, time_stamp_s, expanded.as_ref());
            if lines.text().len() >= BUFFER_OCTETS {
                progress.at(found.record.offset());
                out.write_all(lines.text())?;
                lines.clear();
            }
            Ok::<(), io::Error>(())
        })?;
        out.write_all(lines.text())?;
        out.flush()
    }
}

/// How far a long recording is decoded, on a terminal.
struct DecodeProgress {
    bytes: usize,
    percent: usize,
    is_shown: bool,
}

impl DecodeProgress {
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

impl Drop for DecodeProgress {
    fn drop(&mut self) {
        if self.percent > 0 {
            let _ = write!(io::stderr(), "\r     \r");
        }
    }
}

fn gather(recording: &RecordingBytes<'_>, survey: &RecordingSurvey) -> Statistics {
    let mut statistics = Statistics::default();
    let Ok(()) = recording.for_each(survey, |found| {
        statistics.add(found.record, found.time_stamp);
        Ok::<(), std::convert::Infallible>(())
    });
    statistics
}
