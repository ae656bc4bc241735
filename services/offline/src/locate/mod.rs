//! `koseki locate`: bearings of emitters into their positions (FM-7).
//!
//! The locator is the locator of the live adapters. This command reads a file row by row and writes the results. A
//! file may hold any number of emitters; memory holds only the filters of each.

mod decisions;
mod picture;
mod rows;
mod summary;

use std::cell::RefCell;
use std::io::Write as _;
use std::path::Path;
use std::rc::Rc;

use anyhow::Context as _;
use formats::bearings_csv::BearingReader;
use locating::selection::Select;
use locating::settings::{FilterChoice, Settings};
use locating::{BearingRejection, DroppedEmitter, Locator};
use observations::Bearing;
use platform::{Assumed, History, Mount, Refusal};

use crate::args::Locate;
use crate::files::{InputError, Usage, check_outputs};
use crate::host::Host;
use crate::locate_columns::FIX_COLUMNS;
use crate::reading::{CountingInput, Progress, SkippedRows, platform_states};
use decisions::Decisions;
use picture::Paths;
use summary::LocateSummary;

/// Capacity for emitters without a configured limit: more than any file of measurements has. Memory is allocated on
/// demand.
const EMITTERS_MAX: usize = 20_000;

/// Runs the location.
///
/// # Errors
/// If the arguments are contradictory, or a file cannot be read or written.
pub(crate) fn run(locate: &Locate, host: &dyn Host) -> anyhow::Result<()> {
    let outputs = [
        ("--out", Some(&locate.out)),
        ("--explain", locate.explain.as_ref()),
        ("--picture", locate.picture.as_ref()),
    ];
    check_outputs(
        std::iter::once(&locate.bearings)
            .chain(&locate.config)
            .chain(&locate.platform),
        &outputs,
    )?;
    let (settings, mut dropped) = settings(locate, host)?;
    dropped.extend_from_slice(&locate.dropped);
    let mut locator = Locator::new(settings).map_err(|fault| Usage(fault.to_string()))?;
    locator.set_dropped(&dropped);
    let mut input = BearingInput::open(host, &locate.bearings)?;
    let mut out = host.begin(&locate.out)?;
    let unwritten = || format!("{} cannot be written", locate.out.display());
    writeln!(out, "{}", FIX_COLUMNS).with_context(unwritten)?;
    let mut decisions = locate
        .explain
        .as_deref()
        .map(|path| Decisions::begin(host, path))
        .transpose()?;
    let mut paths = locate.picture.as_ref().map(|_| Paths::new(locate.emitter));
    let mut summary = LocateSummary::default();
    let progress = Progress::new(host, input.octets);
    let ship = locate
        .platform
        .as_deref()
        .map(|path| ship(host, path, &mut input.refusals))
        .transpose()?;
    while let Some((line, measured)) = input.next()? {
        let carried = ship.as_ref().map_or(Ok(measured), |ship| on_board(ship, &measured));
        let bearing = match carried {
            Ok(bearing) => bearing,
            Err(refusal) => {
                let why = format!("the platform's state at the time is not known: {refusal:?}");
                input
                    .refusals
                    .refused("want of a platform state", input.path, line, why);
                continue;
            }
        };
        let begin_ns = runtime::clock::mono_ns();
        let taken = locator.bearing(&bearing);
        summary.locator_ns += runtime::clock::mono_ns() - begin_ns;
        match taken {
            Ok(report) => {
                if let Some(report) = &report {
                    rows::write(&mut out, report).with_context(unwritten)?;
                    summary.emitters.insert(report.number);
                }
                if let Some(paths) = &mut paths {
                    paths.take(&bearing, report.as_ref());
                }
            }
            Err(refusal) => input.refuse(line, refusal),
        }
        if let Some(table) = &mut decisions {
            table.write(locator.decisions())?;
        }
        summary.count(locator.decisions());
        progress.at(*input.octets_read.borrow())?;
    }
    drop(progress);
    out.finish()?;
    if let Some(table) = decisions {
        table.finish()?;
    }
    if let (Some(paths), Some(file)) = (paths, &locate.picture) {
        paths.draw(file)?;
    }
    summary.show(host, locate, &locator, &input.refusals)
}

/// Reads the states of the ship that carries the direction finder.
fn ship(host: &dyn Host, path: &Path, refusals: &mut SkippedRows) -> Result<History, InputError> {
    let states = platform_states(host, path, refusals)?;
    let mut history = History::new(Assumed::default(), states.len());
    for state in &states {
        history.add(state);
    }
    Ok(history)
}

/// A bearing from the bow, as one from north.
fn on_board(ship: &History, bearing: &Bearing) -> Result<Bearing, Refusal> {
    let pose = ship.at(bearing.time_of_measurement_ns).map_err(Refusal::Position)?;
    Mount::default().carry_bearing(bearing, &pose, None)
}

/// Returns the settings of the command line and the configuration, and the emitters of the latter with a known place.
fn settings(locate: &Locate, host: &dyn Host) -> anyhow::Result<(Settings, Vec<DroppedEmitter>)> {
    let (mut settings, dropped) = match &locate.config {
        Some(path) => {
            let text = host.text(path)?;
            configuration::locating_settings(path, &text)?
        }
        None => {
            let settings = Settings {
                emitters_max: EMITTERS_MAX,
                ..Settings::default()
            };
            (settings, Vec::new())
        }
    };
    if let Some(word) = &locate.filter {
        let words = FilterChoice::ALL.map(FilterChoice::word);
        settings.motion.filter = FilterChoice::from_word(word).ok_or_else(|| not_known("--filter", word, &words))?;
    }
    if let Some(word) = &locate.select {
        let words = Select::ALL.map(Select::word);
        settings.selection.select = Select::from_word(word).ok_or_else(|| not_known("--select", word, &words))?;
    }
    Ok((settings, dropped))
}

fn not_known(option: &str, word: &str, words: &[&str]) -> Usage {
    Usage(format!("{option} {word}: there are {}", words.join(", ")))
}

/// Bearing file. Unusable rows are skipped and counted.
struct BearingInput<'a> {
    path: &'a Path,
    reader: BearingReader<CountingInput>,
    octets: u64,
    octets_read: Rc<RefCell<u64>>,
    refusals: SkippedRows,
    rows: u64,
}

impl<'a> BearingInput<'a> {
    fn open(host: &dyn Host, path: &'a Path) -> Result<Self, InputError> {
        let file = host.open(path)?;
        let octets = file.length;
        let octets_read = Rc::default();
        let reader = BearingReader::new(CountingInput::new(file, Rc::clone(&octets_read)), 0);
        Ok(Self {
            path,
            reader: reader.map_err(|error| InputError::new(path, error))?,
            octets,
            octets_read,
            refusals: SkippedRows::default(),
            rows: 0,
        })
    }

    /// Returns the next readable row, with its line number.
    fn next(&mut self) -> Result<Option<(u64, Bearing)>, InputError> {
        while let Some(row) = self.reader.next() {
            if let Some(bearing) = self.refusals.usable(self.path, row)? {
                self.rows += 1;
                return Ok(Some((self.reader.line(), bearing)));
            }
        }
        if self.rows == 0 {
            let why = self
                .refusals
                .first
                .first()
                .map_or("the file has a header only", String::as_str);
            return Err(InputError::new(self.path, format!("no row can be used: {why}")));
        }
        Ok(None)
    }

    fn refuse(&mut self, line: u64, refusal: BearingRejection) {
        let reason = match refusal {
            BearingRejection::Unusable(_) => "a value that cannot be",
            BearingRejection::OutOfOrder => "order of time",
            BearingRejection::TableFull => "want of places",
        };
        self.refusals.refused(reason, self.path, line, refusal);
    }
}
