//! Detections of one or several files: tables, and recordings of the Autoferry data set, which begin with a
//! bracket.

use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use configuration::SeenDetections;
use formats::autoferry;
use formats::scan_rows_csv::{ScanRow, ScanRowReader};
use formats::time_base::is_since_1970;
use frames::time::{NS_PER_DAY, seconds};
use observations::{Detection, TransponderReply};
use tracking::Settings;
use tracking::scans::ScanOfDetections;

use crate::files::InputError;
use crate::host::{self, Host};
use crate::reading::{FileBases, FilePlane, MIDNIGHT_REMEDY, MIDNIGHT_STEP_NS, SkippedRows};

const BUFFER_OCTETS: usize = 1 << 18;

/// Place of a row in a file, and in the scans of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct RowPlace {
    sensor_id: u32,
    scan: u32,
    time_ns: i64,
    line: u64,
}

/// Returns a sentence on the first scan that is half a day and more before the scan of the number before: the times
/// begin again at midnight, and rows are put in order later.
fn midnight(mut places: Vec<RowPlace>) -> Option<String> {
    places.sort_unstable();
    let is_back = |pair: &&[RowPlace]| {
        pair[0].sensor_id == pair[1].sensor_id && pair[0].time_ns.saturating_sub(pair[1].time_ns) > MIDNIGHT_STEP_NS
    };
    let [before, back] = places.windows(2).find(is_back)? else {
        return None;
    };
    Some(format!(
        "line {}, column time_s: {} of scan {} of sensor {} is before {} of scan {}; {MIDNIGHT_REMEDY}",
        back.line,
        seconds(back.time_ns),
        back.scan,
        back.sensor_id,
        seconds(before.time_ns),
        before.scan,
    ))
}

/// Detections from the files.
#[derive(Debug)]
pub(super) struct DetectionInput {
    first_file: PathBuf,
    pub(super) detections: Vec<Detection>,
    /// Scans known to have no detections: sensor, number, time in nanoseconds.
    pub(super) silent: Vec<(u32, u32, i64)>,
    pub(super) refusals: SkippedRows,
    pub(super) bases: FileBases,
    pub(super) plane: FilePlane,
    pub(super) octets: u64,
}

impl DetectionInput {
    /// The input of a recording of this length, before the detections.
    pub(super) fn of_recording(file: &Path, octets: u64) -> Self {
        Self {
            first_file: file.to_owned(),
            detections: Vec::new(),
            silent: Vec::new(),
            refusals: SkippedRows::default(),
            bases: FileBases::default(),
            plane: FilePlane::default(),
            octets,
        }
    }

    /// Reads all files. Unusable rows are skipped and counted. A table that names no sensor is the sensor with the
    /// number of its file.
    ///
    /// # Errors
    /// If a file cannot be read or lacks a column, or no file has a usable row.
    pub(super) fn read(host: &dyn Host, files: &[PathBuf], plane: FilePlane) -> Result<Self, InputError> {
        let mut input = Self {
            first_file: files[0].clone(),
            detections: Vec::new(),
            silent: Vec::new(),
            refusals: SkippedRows::default(),
            bases: FileBases::default(),
            plane,
            octets: 0,
        };
        for (sensor_id, path) in (1..).zip(files) {
            input.read_file(host, path, sensor_id)?;
        }
        if input.detections.is_empty() {
            let first = input.refusals.first.first();
            let why = match first {
                Some(first) => first,
                None if input.silent.is_empty() => "the files have a header only",
                None => "no row is a detection",
            };
            return Err(InputError::new(&input.first_file, format!("no row can be used: {why}")));
        }
        Ok(input)
    }

    fn read_file(&mut self, host: &dyn Host, path: &Path, sensor_id: u32) -> Result<(), InputError> {
        let mut file = host.open(path)?;
        self.octets += file.length;
        let failed = |error| InputError::unreadable(path, &error);
        let mut first = [0];
        let begun = file.read(&mut first).map_err(failed)?;
        if begun == 1 && first[0] == b'[' {
            return self.read_autoferry(path, file, &first);
        }
        // A pipe cannot be read twice: reading continues after the first byte.
        let file = match file.seek(SeekFrom::Start(0)) {
            Ok(_) => first[..0].chain(file),
            Err(_) => first[..begun].chain(file),
        };
        let reader = ScanRowReader::new(BufReader::with_capacity(BUFFER_OCTETS, file), 0);
        let mut reader = reader.map_err(|error| InputError::new(path, error))?;
        reader.set_sensor(sensor_id);
        self.plane.lend(&mut reader);
        let mut places = Vec::new();
        while let Some(row) = reader.next() {
            let Some(row) = self.refusals.usable(path, row)? else {
                continue;
            };
            let (sensor_id, scan, time_ns) = match &row {
                ScanRow::Detection(detection) => {
                    (detection.sensor_id, detection.scan, detection.time_of_measurement_ns)
                }
                ScanRow::Empty(empty) => (empty.sensor_id, empty.scan, empty.time_ns),
            };
            if places.is_empty() {
                self.bases.add(path, is_since_1970(time_ns))?;
            }
            places.push(RowPlace {
                sensor_id,
                scan,
                time_ns,
                line: reader.line(),
            });
            match row {
                ScanRow::Detection(detection) => self.detections.push(detection),
                ScanRow::Empty(scan) => self.silent.push((scan.sensor_id, scan.scan, scan.time_ns)),
            }
        }
        self.plane.take(path, &mut reader);
        match midnight(places) {
            Some(what) => Err(InputError::new(path, what)),
            None => Ok(()),
        }
    }

    /// Reads a recording; times count from midnight of the first scan's day.
    fn read_autoferry(&mut self, path: &Path, mut file: host::TableInput, begun: &[u8]) -> Result<(), InputError> {
        let mut json = begun.to_vec();
        file.read_to_end(&mut json)
            .map_err(|error| InputError::unreadable(path, &error))?;
        let scans = autoferry::read_detections(&json).map_err(|error| InputError::new(path, error))?;
        let first_ns = scans.iter().map(|scan| scan.time_of_measurement_ns).min();
        self.bases.add(path, false)?;
        let day_ns = first_ns.unwrap_or_default().div_euclid(NS_PER_DAY) * NS_PER_DAY;
        for scan in scans {
            if scan.detections.is_empty() {
                let time_ns = scan.time_of_measurement_ns - day_ns;
                self.silent.push((scan.sensor.id(), scan.number, time_ns));
            }
            self.detections
                .extend(scan.detections.into_iter().map(|detection| Detection {
                    time_of_measurement_ns: detection.time_of_measurement_ns - day_ns,
                    ..detection
                }));
        }
        Ok(())
    }

    /// Returns the sensors as far as the detections describe the sensors.
    pub(super) fn seen(&self, scans: &[ScanOfDetections]) -> SeenDetections {
        SeenDetections {
            sensor_ids: scans.iter().map(|scan| scan.sensor_id).collect(),
            scan_max: scans.iter().map(|scan| scan.detections.len()).max().unwrap_or(0),
        }
    }

    /// Whether any detection has a transponder's reply.
    pub(super) fn has_replies(&self) -> bool {
        let none = TransponderReply::default();
        self.detections.iter().any(|detection| detection.reply != none)
    }

    /// Rejects sensors without any stated accuracy.
    pub(super) fn check(&self, settings: &Settings) -> Result<(), InputError> {
        for sensor in settings.sensors.iter().filter(|sensor| sensor.sigmas.is_none()) {
            let mut own = self.detections.iter().filter(|each| each.sensor_id == sensor.sensor_id);
            // A configured sensor without detections is absent from this file and needs no accuracy.
            let Some(first) = own.next() else { continue };
            if first.sigmas.is_none() && own.all(|each| each.sigmas.is_none()) {
                let id = sensor.sensor_id;
                let what = format!(
                    "no detection of sensor {id} states standard deviations (columns s0 to s3, or sigma_m); give them in \
                     --config: [[sensor]] with id = {id} and sigmas = […]"
                );
                return Err(InputError::new(&self.first_file, what));
            }
        }
        Ok(())
    }

    /// Estimates the bytes taken by this number of detections.
    pub(super) fn octets_until(&self, detections: usize) -> u64 {
        (self.octets as f64 * detections as f64 / self.detections.len().max(1) as f64) as u64
    }
}
