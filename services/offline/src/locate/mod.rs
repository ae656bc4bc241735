//! `koseki locate`: bearings, arrival times and fixes of emitters into emitter positions (FM-7, FM-11).
//!
//! The locator is the locator of the live adapters. This command reads files row by row and writes the results. A
//! file may hold any number of emitters; memory holds only the filters of each.

mod decisions;
mod finder_recording;
mod input;
mod picture;
mod rows;
mod summary;

use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;
use frames::SystemFrame;
use locating::selection::Select;
use locating::settings::{ClockChoice, FilterChoice, Settings};
use locating::{BearingRejection, DroppedEmitter, EmitterReport, Locator};
use observations::{ArrivalTime, Bearing, EmitterMeasurement};
use platform::{Assumed, History, Mount, Refusal};
use settings::Degrees;

use crate::args::Locate;
use crate::files::{InputError, OutputFile, Usage, check_answer, check_outputs};
use crate::host::{Host, TableOutput};
use crate::locate_columns::{FIX_COLUMNS, PLACE_COLUMNS};
use crate::reading::{FilePlane, Progress, SkippedRows, platform_states};
use decisions::Decisions;
use finder_recording::StatedFinder;
use input::{MeasuredRow, MeasurementInput};
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
    let inputs = [&locate.fixes, &locate.config, &locate.platform].into_iter().flatten();
    let measurements = [&locate.files[..], &locate.bearings].concat();
    check_outputs(inputs.chain(&measurements), &outputs)?;
    check_answer(locate.json, &outputs)?;
    let (mut settings, mut dropped) = settings(locate, host)?;
    dropped.extend_from_slice(&locate.dropped);
    let mut input = MeasurementInput::open(
        host,
        &measurements,
        locate.fixes.as_deref(),
        (&stated_finder(locate, &settings), FilePlane::new(locate.origin, None)),
    )?;
    check_kinds(locate, input.has_recordings)?;
    if settings.arrivals.clocks == ClockChoice::Auto && input.has_references {
        settings.arrivals.clocks = ClockChoice::Estimated;
    }
    let mut locator = Locator::new(settings).map_err(|fault| Usage(fault.to_string()))?;
    locator.set_dropped(&dropped);
    let mut out = host.begin(&locate.out)?;
    let frame = input.plane.of_outputs();
    let placed = if frame.is_some() { PLACE_COLUMNS } else { "" };
    writeln!(out, "{FIX_COLUMNS}{placed}").with_context(|| unwritten(locate))?;
    let explained = locate.explain.as_deref();
    let mut location = Location {
        locate,
        locator,
        out,
        row: Vec::new(),
        frame,
        decisions: explained.map(|path| Decisions::begin(host, path)).transpose()?,
        paths: locate.picture.as_ref().map(|_| Paths::new(locate.emitter)),
        picture: locate.picture.as_deref().map(OutputFile::begin).transpose()?,
        summary: LocateSummary::default(),
    };
    let progress = Progress::new(host, input.octets);
    let ship = locate
        .platform
        .as_deref()
        .map(|path| ship(host, path, &mut input))
        .transpose()?;
    while let Some(mut row) = input.next()? {
        location.complete(Some(&row), &mut input.refusals)?;
        if let (EmitterMeasurement::Bearing(bearing), Some(ship)) = (&mut row.measured, &ship) {
            match on_board(ship, bearing) {
                Ok(carried) => *bearing = carried,
                Err(refusal) => {
                    let why = format!("the platform's state at the time is not known: {refusal:?}");
                    let refusals = &mut input.refusals;
                    refusals.refused("want of a platform state", row.path, row.row, why);
                    continue;
                }
            }
        }
        location.take(&row, &mut input.refusals)?;
        progress.at(*input.octets_read.borrow())?;
    }
    location.complete(None, &mut input.refusals)?;
    drop(progress);
    location.finish(host, &input)
}

fn unwritten(locate: &Locate) -> String {
    format!("{} cannot be written", locate.out.display())
}

/// The locator, and the outputs of results.
struct Location<'a> {
    locate: &'a Locate,
    locator: Locator,
    out: Box<dyn TableOutput>,
    /// The row being written: the output gets each row in a single call.
    row: Vec<u8>,
    /// The frame of the plane, if its origin is known.
    frame: Option<SystemFrame>,
    decisions: Option<Decisions>,
    paths: Option<Paths>,
    picture: Option<OutputFile>,
    summary: LocateSummary,
}

impl Location<'_> {
    /// Takes a measurement.
    fn take(&mut self, row: &MeasuredRow<'_>, refusals: &mut SkippedRows) -> anyhow::Result<()> {
        let begin_ns = runtime::clock::mono_ns();
        let taken = match &row.measured {
            EmitterMeasurement::Bearing(bearing) => self.locator.bearing(bearing),
            EmitterMeasurement::Arrival(arrival) => self.locator.arrival(arrival),
            EmitterMeasurement::Fix(fix) => self.locator.fix(fix),
        };
        self.summary.locator_ns += runtime::clock::mono_ns() - begin_ns;
        // An arrival at a single receiver completes the transmission before.
        let is_earlier = matches!(&row.measured, EmitterMeasurement::Arrival(arrival)
            if matches!(arrival.time, ArrivalTime::At { .. }));
        self.conclude(taken, Some(row), is_earlier, refusals)
    }

    /// Processes the transmissions that are complete before `next`, or all at the end.
    fn complete(&mut self, next: Option<&MeasuredRow<'_>>, refusals: &mut SkippedRows) -> anyhow::Result<()> {
        loop {
            let begin_ns = runtime::clock::mono_ns();
            let complete = self.locator.complete(next.map(|row| row.measured.time_ns()));
            self.summary.locator_ns += runtime::clock::mono_ns() - begin_ns;
            let Some(taken) = complete else { return Ok(()) };
            self.conclude(taken, next, true, refusals)?;
        }
    }

    /// Writes the result of a row, or of a transmission that ended before the row.
    fn conclude(
        &mut self,
        taken: Result<Option<EmitterReport>, BearingRejection>,
        row: Option<&MeasuredRow<'_>>,
        is_earlier: bool,
        refusals: &mut SkippedRows,
    ) -> anyhow::Result<()> {
        match taken {
            Ok(report) => {
                if let Some(report) = &report {
                    self.row.clear();
                    rows::append(&mut self.row, report, self.frame.as_ref());
                    self.out.write_all(&self.row).with_context(|| unwritten(self.locate))?;
                    self.summary.emitters.insert(report.number);
                }
                if let Some(paths) = &mut self.paths {
                    let bearing = match row.map(|row| &row.measured) {
                        Some(EmitterMeasurement::Bearing(bearing)) if !is_earlier => Some(bearing),
                        _ => None,
                    };
                    paths.take(bearing, report.as_ref());
                }
            }
            Err(refusal) => refuse(refusal, row, is_earlier, refusals),
        }
        if let Some(table) = &mut self.decisions {
            table.write(self.locator.decisions())?;
        }
        self.summary.count(self.locator.decisions());
        Ok(())
    }

    fn finish(self, host: &dyn Host, input: &MeasurementInput<'_>) -> anyhow::Result<()> {
        self.out.finish()?;
        if let Some(table) = self.decisions {
            table.finish()?;
        }
        if let (Some(paths), Some(file)) = (self.paths, self.picture) {
            paths.draw(file)?;
        }
        self.summary.show(host, self.locate, &self.locator, input)
    }
}

/// Counts a refused row, or a refused transmission that ended before the row.
fn refuse(refusal: BearingRejection, row: Option<&MeasuredRow<'_>>, is_earlier: bool, refusals: &mut SkippedRows) {
    let reason = match refusal {
        BearingRejection::Unusable(_) => "a value that cannot be",
        BearingRejection::OutOfOrder => "order of time",
        BearingRejection::TableFull | BearingRejection::ReceiversFull => "want of places",
        BearingRejection::Alone => "one receiver only",
        BearingRejection::ClockUnknown => "unknown clocks",
        BearingRejection::Impossible => "an impossible difference",
    };
    match row {
        Some(row) if is_earlier && !refusal.is_of_arrival() => {
            let why = format!("an arrival before {refusal}");
            refusals.refused(reason, row.path, row.row, why);
        }
        Some(row) => refusals.refused(reason, row.path, row.row, refusal),
        None => refusals.refused_at_end(reason, format!("the last arrival of an emitter {refusal}")),
    }
}

/// Reads the states of the ship that carries the direction finder.
fn ship(host: &dyn Host, path: &Path, input: &mut MeasurementInput<'_>) -> Result<History, InputError> {
    let states = platform_states(host, path, (&mut input.refusals, &mut input.bases))?;
    let mut history = History::new(Assumed::default(), states.len());
    for state in &states {
        history.add(state);
    }
    Ok(history)
}

/// A bearing from the bow, converted to a bearing from north.
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
    if locate.filter.is_none()
        && locate.bearings.is_empty()
        && locate.files.is_empty()
        && settings.motion.filter == FilterChoice::Auto
    {
        settings.motion.filter = FilterChoice::None;
    }
    if let Some(word) = &locate.select {
        let words = Select::ALL.map(Select::word);
        settings.selection.select = Select::from_word(word).ok_or_else(|| not_known("--select", word, &words))?;
    }
    if let Some(sigma_deg) = locate.bearing_sigma_deg {
        settings.bearing_sigma_deg = Degrees::of(sigma_deg);
        settings::check(&settings).map_err(|error| Usage(format!("--bearing-sigma-deg: {error}")))?;
    }
    Ok((settings, dropped))
}

/// Rejects options that do not apply to the files.
fn check_kinds(locate: &Locate, has_recordings: bool) -> Result<(), Usage> {
    let of_recordings = [
        ("--bearing-sigma-deg", locate.bearing_sigma_deg.is_some()),
        ("--date", locate.date.is_some()),
        ("--place", locate.place.is_some()),
        ("--sac", locate.sac.is_some()),
    ];
    let given = of_recordings.iter().find(|(_, is_given)| *is_given);
    match (has_recordings, given, &locate.platform) {
        (false, Some((option, _)), _) => Err(Usage(format!(
            "{option} is for recordings of direction finders; the files are tables, which state it themselves: leave it \
             out"
        ))),
        (true, _, Some(platform)) => Err(Usage(format!(
            "--platform {} is for bearings from the nose; those of recordings are from north: leave it out",
            platform.display()
        ))),
        _ => Ok(()),
    }
}

/// What the command line and the settings state of the finder of a recording.
fn stated_finder(locate: &Locate, settings: &Settings) -> StatedFinder {
    StatedFinder {
        sigma_rad: settings.bearing_sigma_deg.rad(),
        place: locate.place,
        sac_sic: locate.sac.zip(locate.sic),
        first_day_ns: locate.date,
    }
}

fn not_known(option: &str, word: &str, words: &[&str]) -> Usage {
    Usage(format!("{option} {word}: there are {}", words.join(", ")))
}
