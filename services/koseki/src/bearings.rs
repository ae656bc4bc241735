//! `koseki bearings`: snapshots of an antenna array into bearings (EL-1), as `koseki locate` reads them (FM-7).
//!
//! [`locating::music`] makes the measurement. This module collects rows with the same time, and writes unambiguous
//! bearings: inside the sector covered by the antennas, and without another bearing there that explains the snapshots
//! as well.

use std::f64::consts::TAU;
use std::path::Path;

use anyhow::Context as _;
use formats::bearings_csv::BearingWriter;
use formats::snapshots_csv::{ArraySnapshot, SnapshotReader};
use locating::music::{ArrayFinder, ArraySettings, Complex, Snapshots};
use observations::Bearing;
use offline::{InputError, OutputFile, RowPlace, SkippedRows, check_outputs, open};
use serde_json::json;

use crate::args::MeasureBearings;

/// Measures.
///
/// # Errors
/// If the arguments are invalid, or a file cannot be read or written.
pub(crate) fn run(command: &MeasureBearings) -> anyhow::Result<()> {
    check_outputs([&command.snapshots, &command.array], &[("--out", Some(&command.out))])?;
    let settings = array(&command.array)?;
    let antennas = settings.antennas.len();
    let array = ArrayFinder::new(settings).map_err(|error| InputError::new(&command.array, error))?;
    let file = open(&command.snapshots)?;
    let unreadable = |error| InputError::new(&command.snapshots, error);
    let mut rows = SnapshotReader::new(file, 0, antennas).map_err(unreadable)?;
    let unwritten = || format!("{} cannot be written", command.out.display());
    let out = BearingWriter::begin(OutputFile::begin(&command.out)?, 0).with_context(unwritten)?;
    let mut finder = Finder::new(command, array, out);
    while let Some(row) = rows.next() {
        if let Some(snapshot) = finder.refusals.usable(&command.snapshots, row)? {
            finder.take(snapshot, rows.line()).with_context(unwritten)?;
        }
    }
    finder.measure().with_context(unwritten)?;
    if finder.array.counts().measurements == 0 {
        let why = finder.refusals.first.first();
        let why = why.map_or("the file has a header only", String::as_str);
        return Err(InputError::new(&command.snapshots, format!("nothing was measured: {why}")).into());
    }
    finder.finish(command)
}

fn array(file: &Path) -> Result<ArraySettings, InputError> {
    let text = offline::read_text(file)?;
    let read = settings::Document::parse(&text, &[]).and_then(|document| document.read());
    read.map_err(|error| match error.line {
        Some(line) => InputError::new(file, format!("line {line}: {error}")),
        None => InputError::new(file, error),
    })
}

/// Finds the bearings measurement by measurement.
struct Finder<'a> {
    path: &'a Path,
    array: ArrayFinder,
    out: BearingWriter<OutputFile>,
    /// Rows of the present measurement: the first row with its line number, and all samples.
    first: Option<(ArraySnapshot, u64)>,
    samples: Vec<Complex<f64>>,
    refusals: SkippedRows,
    snapshots: u64,
}

impl<'a> Finder<'a> {
    fn new(command: &'a MeasureBearings, array: ArrayFinder, out: BearingWriter<OutputFile>) -> Self {
        Self {
            path: &command.snapshots,
            array,
            out,
            first: None,
            samples: Vec::new(),
            refusals: SkippedRows::default(),
            snapshots: 0,
        }
    }

    /// Adds the row of `line`; a row with another time ends the previous measurement.
    fn take(&mut self, snapshot: ArraySnapshot, line: u64) -> anyhow::Result<()> {
        if let Some((first, _)) = &self.first {
            if snapshot.time_ns < first.time_ns {
                let what = "is before the row above; rows come in the order of time";
                self.refusals.out_of_order(self.path, (line, "time_s"), what);
                return Ok(());
            }
            let place = |row: &ArraySnapshot| (row.platform_m, row.heading_rad, row.frequency_hz);
            if snapshot.time_ns > first.time_ns {
                self.measure()?;
            } else if place(&snapshot) != place(first) {
                let why = "it has the time of the row above, and another place, heading or frequency";
                self.refusals.refused(
                    "two measurements with the same time",
                    self.path,
                    RowPlace::Line(line),
                    why,
                );
                return Ok(());
            }
        }
        self.samples
            .extend(snapshot.samples.iter().map(|[re, im]| Complex::new(*re, *im)));
        self.first.get_or_insert((snapshot, line));
        self.snapshots += 1;
        Ok(())
    }

    /// Evaluates the collected rows, and writes the unambiguous bearings.
    fn measure(&mut self) -> anyhow::Result<()> {
        let Some((at, line)) = self.first.take() else {
            return Ok(());
        };
        let snapshots = Snapshots {
            samples: &self.samples,
            frequency_hz: at.frequency_hz,
        };
        match self.array.measure(&snapshots) {
            Ok(usable) => {
                for bearing in usable {
                    self.out.write(&Bearing {
                        time_of_measurement_ns: at.time_ns,
                        emitter_id: None,
                        bearing_rad: (at.heading_rad + bearing.bearing_rad).rem_euclid(TAU),
                        sigma_rad: bearing.sigma_rad,
                        platform_m: at.platform_m,
                        heading_rad: Some(at.heading_rad),
                        frequency_hz: Some(at.frequency_hz),
                        pulse_interval_s: None,
                    })?;
                }
            }
            Err(error) => {
                let reason = "a measurement that cannot be made";
                self.refusals.refused(reason, self.path, RowPlace::Line(line), error);
            }
        }
        self.samples.clear();
        Ok(())
    }

    /// Ends the output, and shows the counts: as JSON on standard output, else on standard error.
    fn finish(self, command: &MeasureBearings) -> anyhow::Result<()> {
        self.out.into_inner().finish()?;
        let (counts, refusals) = (self.array.counts(), &self.refusals);
        let json = || {
            json!({
                "out": command.out.display().to_string(),
                "rows": counts.bearings,
                "snapshots": self.snapshots,
                "measurements": counts.measurements,
                "ambiguous": counts.ambiguous,
                "outside_sector": counts.outside_sector,
                "uncertain": counts.uncertain,
                "unresolved": counts.unresolved,
                "rows_refused": refusals.rows(),
                "refused": refusals.by_reason,
                "first_refused": refusals.first,
            })
        };
        let text = || {
            format!(
                "{}{} snapshots in {} measurements; left out: {} ambiguous bearings, {} outside the sector, {} too uncertain; {} \
                 transmitters not resolved\n{}: {} bearings\n",
                refusals.as_text(),
                self.snapshots,
                counts.measurements,
                counts.ambiguous,
                counts.outside_sector,
                counts.uncertain,
                counts.unresolved,
                command.out.display(),
                counts.bearings
            )
        };
        crate::show(command.json.then(json), text)
    }
}
