//! Files of measurements of emitters, as a single stream in the order of time: tables, and recordings of direction
//! finders.

use std::cell::RefCell;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use formats::emitter_rows_csv::EmitterRowReader;
use formats::time_base::is_since_1970;
use observations::EmitterMeasurement;

use super::finder_recording::{FinderRecording, StatedFinder, is_recording};
use crate::files::InputError;
use crate::host::Host;
use crate::reading::{BegunFile, CountingInput, FileBases, FilePlane, RowPlace, SkippedRows};

/// Remedy where the times of a recording count from another base than those of the files before.
const DATE_REMEDY: &str =
    "--date YYYY-MM-DD gives recordings their first day, --date 1970-01-01 counts from its midnight";

/// A measurement, and the file and place of its row.
#[derive(Debug)]
pub(super) struct MeasuredRow<'a> {
    pub(super) path: &'a Path,
    pub(super) row: RowPlace,
    pub(super) measured: EmitterMeasurement,
}

/// All files. Unusable rows are skipped and counted.
pub(super) struct MeasurementInput<'a> {
    files: Vec<MeasurementFile<'a>>,
    pub(super) octets: u64,
    pub(super) octets_read: Rc<RefCell<u64>>,
    pub(super) refusals: SkippedRows,
    pub(super) bases: FileBases,
    pub(super) plane: FilePlane,
    /// Whether there are rows of reference emitters.
    pub(super) has_references: bool,
    /// Whether there are recordings, whose reports state no accuracy of bearings.
    pub(super) has_recordings: bool,
}

/// Reader of a file, by its kind.
enum MeasurementReader {
    Table(Box<EmitterRowReader<CountingInput>>),
    Recording(Box<FinderRecording>),
}

/// A file, and the next row.
struct MeasurementFile<'a> {
    path: &'a Path,
    reader: MeasurementReader,
    next: Option<MeasuredRow<'a>>,
    rows: u64,
}

impl<'a> MeasurementInput<'a> {
    /// Opens files of bearings and arrival times, and a file of fixes. Of rows with the same time, the rows of the file
    /// named first come first. `finder` is of recordings.
    ///
    /// # Errors
    /// If a file cannot be read, lacks a column or has no usable row.
    pub(super) fn open(
        host: &dyn Host,
        measurements: &'a [PathBuf],
        fixes: Option<&'a Path>,
        (finder, plane): (&StatedFinder, FilePlane),
    ) -> Result<Self, InputError> {
        let mut input = Self {
            files: Vec::new(),
            octets: 0,
            octets_read: Rc::default(),
            refusals: SkippedRows::default(),
            bases: FileBases::default(),
            plane,
            has_references: false,
            has_recordings: false,
        };
        let measurements = measurements.iter().map(|path| (path.as_path(), false));
        for (path, has_fixes) in measurements.chain(fixes.map(|path| (path, true))) {
            let begun = BegunFile::of(host, path)?;
            let reader = match is_recording(begun.head()) {
                true if has_fixes => {
                    return Err(InputError::new(path, "is no table; name a recording with --bearings"));
                }
                true => input.recording(path, begun, finder)?,
                false => input.table(host, path, begun, has_fixes)?,
            };
            let mut file = MeasurementFile {
                path,
                reader,
                next: None,
                rows: 0,
            };
            input.begin(&mut file)?;
            input.files.push(file);
        }
        Ok(input)
    }

    fn recording(
        &mut self,
        path: &Path,
        begun: BegunFile,
        finder: &StatedFinder,
    ) -> Result<MeasurementReader, InputError> {
        self.has_recordings = true;
        self.octets += begun.length();
        let recording = FinderRecording::read(path, begun, (finder, &mut self.plane), &self.octets_read)?;
        Ok(MeasurementReader::Recording(Box::new(recording)))
    }

    fn table(
        &mut self,
        host: &dyn Host,
        path: &Path,
        begun: BegunFile,
        has_fixes: bool,
    ) -> Result<MeasurementReader, InputError> {
        let (file, length) = begun.whole();
        self.octets += length;
        let reader = EmitterRowReader::new(CountingInput::new(file, Rc::clone(&self.octets_read)), 0);
        let reader = reader.map_err(|error| InputError::new(path, error))?;
        if reader.has_fixes() != has_fixes {
            let why = match has_fixes {
                true => "has no fixes, which need the columns x, y, z or latitude, longitude; name it with --bearings",
                false => "has fixes; name it with --fixes",
            };
            return Err(InputError::new(path, why));
        }
        if reader.has_references() {
            self.has_references |= names_reference(host, path)?;
        }
        Ok(MeasurementReader::Table(Box::new(reader)))
    }

    /// Reads the first row of a file.
    fn begin(&mut self, file: &mut MeasurementFile<'a>) -> Result<(), InputError> {
        if let MeasurementReader::Table(reader) = &mut file.reader {
            self.plane.lend(reader);
        }
        file.advance(&mut self.refusals)?;
        if let MeasurementReader::Table(reader) = &mut file.reader {
            self.plane.take(file.path, reader);
        }
        if let Some(row) = &file.next {
            let added = self.bases.add(file.path, is_since_1970(row.measured.time_ns()));
            added.map_err(|error| match self.has_recordings {
                true => error.with(DATE_REMEDY),
                false => error,
            })?;
        }
        Ok(())
    }

    /// Returns the next row of the file with the earliest next row.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub(super) fn next(&mut self) -> Result<Option<MeasuredRow<'a>>, InputError> {
        let waiting = self.files.iter_mut().filter(|file| file.next.is_some());
        let time_ns = |file: &&mut MeasurementFile<'_>| file.next.as_ref().map(|row| row.measured.time_ns());
        match waiting.min_by_key(time_ns) {
            Some(file) => {
                let row = file.next.take();
                file.advance(&mut self.refusals)?;
                Ok(row)
            }
            None => Ok(None),
        }
    }
}

impl MeasurementFile<'_> {
    /// Reads the next usable row.
    fn advance(&mut self, refusals: &mut SkippedRows) -> Result<(), InputError> {
        let path = self.path;
        if let Some((row, measured)) = self.reader.next(path, refusals)? {
            self.rows += 1;
            self.next = Some(MeasuredRow { path, row, measured });
        } else if self.rows == 0 {
            let (row, empty) = self.reader.words();
            let why = refusals.first.first().map_or(empty, String::as_str);
            return Err(InputError::new(path, format!("no {row} can be used: {why}")));
        }
        Ok(())
    }
}

impl MeasurementReader {
    /// The next usable row, and its place.
    fn next(
        &mut self,
        path: &Path,
        refusals: &mut SkippedRows,
    ) -> Result<Option<(RowPlace, EmitterMeasurement)>, InputError> {
        match self {
            Self::Table(reader) => {
                while let Some(row) = reader.next() {
                    if let Some(measured) = refusals.usable(path, row)? {
                        return Ok(Some((RowPlace::Line(reader.line()), measured)));
                    }
                }
                Ok(None)
            }
            Self::Recording(recording) => {
                let next = recording.next(path, refusals);
                Ok(next.map(|(record, measured)| (RowPlace::Record(record), measured)))
            }
        }
    }

    /// The name of a row, and the reason why a file has none, if none was refused.
    fn words(&self) -> (&'static str, &'static str) {
        match self {
            Self::Table(_) => ("row", "the file has a header only"),
            Self::Recording(_) => (
                "record",
                "no report has a bearing, or a position of a single transmitter",
            ),
        }
    }
}

/// Looks for a row of a reference emitter: such a row anywhere means that the receivers' clocks are not exact.
fn names_reference(host: &dyn Host, path: &Path) -> Result<bool, InputError> {
    let reader = EmitterRowReader::new(BufReader::new(host.open(path)?), 0);
    let mut rows = reader.map_err(|error| InputError::new(path, error))?;
    let is_reference = |row: &EmitterMeasurement| match row {
        EmitterMeasurement::Arrival(arrival) => arrival.reference_m.is_some(),
        EmitterMeasurement::Bearing(_) | EmitterMeasurement::Fix(_) => false,
    };
    // Rows that cannot be read are counted when the file is read.
    Ok(rows.any(|row| row.is_ok_and(|row| is_reference(&row))))
}
