//! Files of measurements of emitters, as a single stream in the order of time.

use std::cell::RefCell;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use formats::emitter_rows_csv::EmitterRowReader;
use formats::time_base::is_since_1970;
use observations::EmitterMeasurement;

use crate::files::InputError;
use crate::host::Host;
use crate::reading::{CountingInput, FileBases, FilePlane, SkippedRows};

/// A measurement, and the file and line of its row.
#[derive(Debug)]
pub(super) struct MeasuredRow<'a> {
    pub(super) path: &'a Path,
    pub(super) line: u64,
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
}

/// A file, and the next row.
struct MeasurementFile<'a> {
    path: &'a Path,
    reader: EmitterRowReader<CountingInput>,
    next: Option<MeasuredRow<'a>>,
    rows: u64,
}

impl<'a> MeasurementInput<'a> {
    /// Opens files of bearings and arrival times, and a file of fixes. Of rows with the same time, the rows of the file
    /// named first come first.
    ///
    /// # Errors
    /// If a file cannot be read, lacks a column or has no usable row.
    pub(super) fn open(
        host: &dyn Host,
        measurements: &'a [PathBuf],
        fixes: Option<&'a Path>,
        plane: FilePlane,
    ) -> Result<Self, InputError> {
        let mut input = Self {
            files: Vec::new(),
            octets: 0,
            octets_read: Rc::default(),
            refusals: SkippedRows::default(),
            bases: FileBases::default(),
            plane,
            has_references: false,
        };
        let measurements = measurements.iter().map(|path| (path.as_path(), false));
        for (path, has_fixes) in measurements.chain(fixes.map(|path| (path, true))) {
            let file = host.open(path)?;
            input.octets += file.length;
            let reader = EmitterRowReader::new(CountingInput::new(file, Rc::clone(&input.octets_read)), 0);
            let reader = reader.map_err(|error| InputError::new(path, error))?;
            if reader.has_fixes() != has_fixes {
                let why = match has_fixes {
                    true => {
                        "has no fixes, which need the columns x, y, z or latitude, longitude; name it with --bearings"
                    }
                    false => "has fixes; name it with --fixes",
                };
                return Err(InputError::new(path, why));
            }
            if reader.has_references() {
                input.has_references |= names_reference(host, path)?;
            }
            input.files.push(MeasurementFile {
                path,
                reader,
                next: None,
                rows: 0,
            });
        }
        for file in &mut input.files {
            input.plane.lend(&mut file.reader);
            file.advance(&mut input.refusals)?;
            input.plane.take(file.path, &mut file.reader);
            if let Some(row) = &file.next {
                input.bases.add(file.path, is_since_1970(row.measured.time_ns()))?;
            }
        }
        Ok(input)
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
        while let Some(row) = self.reader.next() {
            if let Some(measured) = refusals.usable(self.path, row)? {
                self.rows += 1;
                self.next = Some(MeasuredRow {
                    path: self.path,
                    line: self.reader.line(),
                    measured,
                });
                return Ok(());
            }
        }
        if self.rows == 0 {
            let first = refusals.first.first();
            let why = first.map_or("the file has a header only", String::as_str);
            return Err(InputError::new(self.path, format!("no row can be used: {why}")));
        }
        Ok(())
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
