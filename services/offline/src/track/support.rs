//! Inputs of a tracker besides detections: reports of a wide-area sensor (FM-6), and emissions received on board
//! (FM-7).

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use formats::bearings_csv::BearingReader;
use formats::time_base::is_since_1970;
use formats::wide_area_csv::WideAreaReader;
use observations::WideAreaReport;
use tracking::Settings;
use tracking::wide_area::Emission;

use crate::files::InputError;
use crate::host::Host;
use crate::reading::{FileBases, FilePlane, RowPlace, SkippedRows};

/// Input file and the outcome of the rows.
#[derive(Debug)]
pub(super) struct SupportInput {
    path: PathBuf,
    pub(super) refusals: SkippedRows,
    /// Rows rejected by the tracker, by reason.
    pub(super) rejected: BTreeMap<String, u64>,
    /// Rows after the last scan, without effect.
    pub(super) left: usize,
}

impl SupportInput {
    fn of(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            refusals: SkippedRows::default(),
            rejected: BTreeMap::new(),
            left: 0,
        }
    }

    /// Reads reports of a wide-area sensor. Invalid rows are skipped and counted.
    ///
    /// # Errors
    /// If the file cannot be read, lacks a column, or differs from the files before in the time base.
    pub(super) fn reports(
        host: &dyn Host,
        path: &Path,
        bases: &mut FileBases,
    ) -> Result<(Self, Vec<WideAreaReport>), InputError> {
        let (mut support, mut reports) = (Self::of(path), Vec::new());
        let rows = WideAreaReader::new(BufReader::new(host.open(path)?), 0);
        for row in rows.map_err(|error| InputError::new(path, error))? {
            reports.extend(support.refusals.usable(path, row)?);
        }
        if let Some(first) = reports.first() {
            bases.add(path, is_since_1970(first.time_ns))?;
        }
        Ok((support, reports))
    }

    /// Reads emissions. Invalid rows are skipped and counted.
    ///
    /// # Errors
    /// If the file cannot be read, lacks a column, or differs from the files before in the time base.
    pub(super) fn emissions(
        host: &dyn Host,
        path: &Path,
        (bases, plane): (&mut FileBases, &mut FilePlane),
    ) -> Result<(Self, Vec<Emission>), InputError> {
        let (mut support, mut emissions) = (Self::of(path), Vec::new());
        let rows = BearingReader::new(BufReader::new(host.open(path)?), 0);
        let mut rows = rows.map_err(|error| InputError::new(path, error))?;
        plane.lend(&mut rows);
        while let Some(row) = rows.next() {
            let Some(bearing) = support.refusals.usable(path, row)? else {
                continue;
            };
            bases.add(path, is_since_1970(bearing.time_of_measurement_ns))?;
            match Emission::of(&bearing) {
                Some(emission) => emissions.push(emission),
                None => {
                    let why = "no frequency to identify a type; write frequency_hz";
                    support
                        .refusals
                        .refused("no frequency", path, RowPlace::Line(rows.line()), why);
                }
            }
        }
        plane.take(path, &mut rows);
        Ok((support, emissions))
    }

    /// Rejects a file of emissions if the configuration describes no types of targets.
    pub(super) fn check_types(&self, settings: &Settings) -> Result<(), InputError> {
        if !settings.wide_area.knowledge.types.is_empty() {
            return Ok(());
        }
        let what = "emissions identify types of targets, but no type is configured; configure [[wide_area.type]] in \
                    --config, or omit --emissions";
        Err(InputError::new(&self.path, what))
    }

    pub(super) fn reject(&mut self, reason: impl std::fmt::Display) {
        *self.rejected.entry(reason.to_string()).or_default() += 1;
    }
}
