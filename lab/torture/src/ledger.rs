//! Events on the way to the judge, and, if requested, to a file.

use std::fs::File;
use std::io::{BufRead as _, BufReader, BufWriter, Write as _};
use std::path::Path;

use crate::Refused;
use anyhow::Context as _;
use runtime::clock::mono_ns;
use serde::de::DeserializeOwned;

use super::judge::Judge;
use super::judge::event::{Conditions, Event, What};

/// The judge of a live run, and the record of the judge's input.
pub(super) struct Ledger {
    judge: Judge,
    record: Option<BufWriter<File>>,
    /// First failure to write the record.
    failure: Option<anyhow::Error>,
}

impl Ledger {
    /// Begins a record in `file`, if requested.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn new(conditions: Conditions, file: Option<&Path>) -> anyhow::Result<Self> {
        let mut record = match file {
            Some(path) => {
                Some(BufWriter::new(File::create(path).map_err(|error| {
                    Refused(format!("--record {}: {error}", path.display()))
                })?))
            }
            None => None,
        };
        if let Some(record) = &mut record {
            writeln!(record, "{}", serde_json::to_string(&conditions)?)?;
        }
        Ok(Self {
            judge: Judge::new(conditions),
            record,
            failure: None,
        })
    }

    pub(super) fn judge(&self) -> &Judge {
        &self.judge
    }

    /// Something happens now.
    pub(super) fn now(&mut self, what: What) {
        self.take(&Event { at_ns: mono_ns(), what });
    }

    pub(super) fn take(&mut self, event: &Event) {
        self.judge.take(event);
        if let (Some(record), None) = (&mut self.record, &self.failure) {
            let line = serde_json::to_string(event).map_err(anyhow::Error::from);
            let written = line.and_then(|line| Ok(writeln!(record, "{line}")?));
            self.failure = written.context("writing the record of events").err();
        }
    }

    /// Ends the record.
    ///
    /// # Errors
    /// If the record could not be written completely.
    pub(super) fn close(&mut self) -> anyhow::Result<()> {
        if let Some(mut record) = self.record.take() {
            record.flush().context("writing the record of events")?;
        }
        self.failure.take().map_or(Ok(()), Err)
    }
}

/// Reads a recorded input.
///
/// # Errors
/// If the file cannot be read, or a line is malformed.
pub(super) fn read(path: &Path) -> anyhow::Result<(Conditions, Vec<Event>)> {
    let file = File::open(path).map_err(|error| Refused(format!("{}: {error}", path.display())))?;
    let mut lines = BufReader::new(file).lines();
    let first = lines.next().transpose()?.unwrap_or_default();
    let conditions = parse(path, 1, &first)?;
    let events = lines.zip(2..).map(|(line, number)| parse(path, number, &line?));
    Ok((conditions, events.collect::<anyhow::Result<_>>()?))
}

fn parse<T: DeserializeOwned>(path: &Path, number: usize, line: &str) -> anyhow::Result<T> {
    let refused = |error| {
        Refused(format!(
            "{}, line {number}: {error}; record it with --record",
            path.display()
        ))
    };
    Ok(serde_json::from_str(line).map_err(refused)?)
}
