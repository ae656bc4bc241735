//! Sensor tracks of several files in the order of time, track by track; for files with stated arrivals, in the order of
//! arrival (module `arrivals`).
//!
//! Memory holds a few rows of each file, so files may have any length. Unusable rows are skipped and counted
//! individually: a recording of a million rows stays useful with ten damaged rows. Reading ends only if the whole file
//! is unusable, for example without a required column.
//!
//! A row with a time far beyond the following rows of other sensors is skipped, rather than these rows: a wrong clock
//! of a single sensor must not advance the time of the others.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use formats::sensor_tracks_csv::SensorTrackReader;
use formats::time_base::is_since_1970;

use super::arrivals::{ArrivalOrder, ArrivedReport, RowOrder};
use super::kept::{KeptFile, KeptReader, KeptRows};
use super::named::NamedTables;
use super::progress::CountingInput;
use super::reader::{FileReader, SourceOf};
use super::refusals::{MIDNIGHT_REMEDY, MIDNIGHT_STEP_NS, SkippedRows};
use super::sensors::Sensors;
use super::time_base::FileBases;
use crate::files::InputError;
use crate::host::Host;

/// Number of rows read ahead.
const AHEAD: usize = 16;
/// A row this much later than most following rows counts as wrong, nanoseconds.
const LEAP_NS: i64 = 5_000_000_000;
/// Rows out of order that are left out of any file, and part of the rows of a long file, percent: more are no errors of
/// single rows.
const OUT_OF_ORDER_MAX: (u64, u64) = (10, 1);

/// Rows of several files, merged by time of arrival.
pub(crate) struct MergedRows {
    lanes: Vec<FileLane>,
    pub(crate) sensors: Rc<RefCell<Sensors>>,
    pub(crate) refusals: SkippedRows,
    /// Bytes read so far, and in total.
    pub(crate) octets: Rc<RefCell<u64>>,
    pub(crate) octets_in_all: u64,
}

/// A file.
struct FileLane {
    path: PathBuf,
    /// Name of the column of times.
    time_column: &'static str,
    rows: LaneRows,
    /// The next row, and up to [`AHEAD`] further rows. A row is large: each row is read into its place here, and moved
    /// once.
    ahead: VecDeque<ArrivedReport>,
    /// Time of the last returned row.
    given_ns: i64,
    /// Order of a file with stated arrivals.
    arrivals: Option<ArrivalOrder>,
    /// Number of readable rows so far, and whether the times count from 1970.
    readable: u64,
    since_1970: bool,
    /// Number of readable rows that are earlier than a row above, and the sentence on the first.
    out_of_order: u64,
    first_out_of_order: Option<String>,
}

/// Where the rows of a file come from.
enum LaneRows {
    File {
        reader: FileReader,
        /// Rows so far, if kept.
        kept: Option<KeptFile>,
    },
    Kept {
        reader: KeptReader,
        octets: Rc<RefCell<u64>>,
    },
}

impl MergedRows {
    /// Opens the files, those of `named` columns by their names.
    ///
    /// # Errors
    /// If a file cannot be read, or lacks a column.
    pub(crate) fn open(
        host: &dyn Host,
        (files, named): (&[PathBuf], &NamedTables),
        sensors: Sensors,
        order: RowOrder,
    ) -> Result<Self, InputError> {
        let mut merged = Self {
            lanes: Vec::new(),
            sensors: Rc::new(RefCell::new(sensors)),
            refusals: SkippedRows::default(),
            octets: Rc::default(),
            octets_in_all: 0,
        };
        for (index, path) in files.iter().enumerate() {
            let (file, length) = named.open(host, (index, path))?;
            merged.octets_in_all += length;
            let input = CountingInput::new(file, Rc::clone(&merged.octets));
            let (reader, arrivals) = match named.outline(index) {
                Some(outline) => (named.reader((path, outline), input, &merged.sensors)?, None),
                None => merged.in_metres(host, path, input, order)?,
            };
            // The pass that accepts all sensors is the first.
            let keeps = merged.sensors.borrow().open && arrivals.is_none();
            let rows = LaneRows::File {
                reader,
                kept: keeps.then(|| KeptFile::begin(files.len(), length)),
            };
            merged.add(FileLane::new((path, named.time_column(index)), rows, arrivals))?;
        }
        Ok(merged)
    }

    /// Opens a table of sensor tracks in metres, with the order of its arrivals if it states them.
    fn in_metres(
        &self,
        host: &dyn Host,
        path: &Path,
        input: CountingInput,
        order: RowOrder,
    ) -> Result<(FileReader, Option<ArrivalOrder>), InputError> {
        let sensors = Rc::clone(&self.sensors);
        let accurate = sensors.borrow().accurate.clone();
        let source_of: SourceOf = Box::new(move |id| sensors.borrow_mut().source(id));
        let reader = SensorTrackReader::new(input, 0, source_of).map_err(|error| InputError::new(path, error))?;
        let reader = reader.with_accuracies_of(accurate);
        let has_arrivals = reader.has_arrivals();
        let arrivals = has_arrivals.then(|| arrivals_of(host, path, order)).transpose()?;
        Ok((FileReader::Metres(Box::new(reader)), arrivals))
    }

    /// The rows of `files` that the first pass has `kept`, under these source numbers; `None` if rows are missing.
    ///
    /// # Errors
    /// None: the rows are readable.
    pub(crate) fn of_kept(
        (files, named): (&[PathBuf], &NamedTables),
        kept: &KeptRows,
        sensors: &Sensors,
    ) -> Result<Option<Self>, InputError> {
        let Some(readers) = kept.again(&sensors.ids) else {
            return Ok(None);
        };
        let mut merged = Self {
            lanes: Vec::new(),
            sensors: Rc::new(RefCell::new(sensors.clone())),
            refusals: SkippedRows::default(),
            octets: Rc::default(),
            octets_in_all: readers.iter().map(KeptReader::octets).sum(),
        };
        for (index, (path, reader)) in files.iter().zip(readers).enumerate() {
            let octets = Rc::clone(&merged.octets);
            let place = (path.as_path(), named.time_column(index));
            merged.add(FileLane::new(place, LaneRows::Kept { reader, octets }, None))?;
        }
        Ok(Some(merged))
    }

    /// The rows, if all were read and kept.
    pub(crate) fn into_kept(self) -> Option<KeptRows> {
        let kept = |lane: FileLane| match lane.rows {
            LaneRows::File { kept, .. } => kept,
            LaneRows::Kept { .. } => None,
        };
        let files = self.lanes.into_iter().map(kept).collect::<Option<_>>()?;
        Some(KeptRows::new(files, self.sensors.borrow().ids.clone()))
    }

    fn add(&mut self, mut lane: FileLane) -> Result<(), InputError> {
        lane.step(&mut self.refusals)?;
        self.lanes.push(lane);
        Ok(())
    }

    /// Whether a file has stated arrivals.
    pub(crate) fn has_arrivals(&self) -> bool {
        self.lanes.iter().any(|lane| lane.arrivals.is_some())
    }

    /// Refuses files with different time bases, and files with too many rows left out for their time: the remaining
    /// rows would look right.
    ///
    /// # Errors
    /// The first file.
    pub(crate) fn check_order(&self) -> Result<(), InputError> {
        let mut bases = FileBases::default();
        for lane in self.lanes.iter().filter(|lane| lane.readable > 0) {
            bases.add(&lane.path, lane.since_1970)?;
        }
        let (rows_max, percent_max) = OUT_OF_ORDER_MAX;
        let is_unsorted =
            |lane: &&FileLane| lane.out_of_order > rows_max && 100 * lane.out_of_order > percent_max * lane.readable;
        let Some(lane) = self.lanes.iter().find(is_unsorted) else {
            return Ok(());
        };
        let first = lane.first_out_of_order.as_deref().unwrap_or_default();
        let what = format!(
            "{} of {} rows are out of order by time, the first: {first}",
            lane.out_of_order, lane.readable
        );
        Err(InputError::new(&lane.path, what))
    }

    /// Returns the next report of all files to arrive; at equal times, the report measured first, and then that of the
    /// sensor with the smallest number.
    ///
    /// # Errors
    /// If reading a file fails.
    pub(crate) fn next(&mut self) -> Result<Option<ArrivedReport>, InputError> {
        let order = |lane: &FileLane| {
            let row = lane.ahead.front()?;
            Some((row.arrival_ns, row.track.time_of_measurement_ns, row.track.source))
        };
        let lanes = self.lanes.iter_mut().filter(|lane| !lane.ahead.is_empty());
        let Some(lane) = lanes.min_by_key(|lane| order(lane)) else {
            return Ok(None);
        };
        let given = lane.ahead.pop_front();
        if let Some(given) = &given {
            lane.given_ns = given.track.time_of_measurement_ns;
        }
        lane.step(&mut self.refusals)?;
        Ok(given)
    }
}

impl FileLane {
    fn new((path, time_column): (&Path, &'static str), rows: LaneRows, arrivals: Option<ArrivalOrder>) -> Self {
        Self {
            path: path.to_owned(),
            time_column,
            rows,
            ahead: VecDeque::with_capacity(1 + AHEAD),
            given_ns: i64::MIN,
            arrivals,
            readable: 0,
            since_1970: false,
            out_of_order: 0,
            first_out_of_order: None,
        }
    }

    /// Leaves out a row that is earlier than a row above.
    fn leave_out(&mut self, refusals: &mut SkippedRows, line: u64, what: String) {
        refusals.out_of_order(&self.path, (line, self.time_column), &what);
        self.out_of_order += 1;
        let column = self.time_column;
        self.first_out_of_order
            .get_or_insert_with(|| format!("line {line}, column {column}: {what}"));
    }

    /// Finds the next row: the first row read ahead, unless its time or the following row's time is wrong.
    fn step(&mut self, refusals: &mut SkippedRows) -> Result<(), InputError> {
        if let Some(mut arrivals) = self.arrivals.take() {
            let next = self.next_arrival(&mut arrivals, refusals);
            self.arrivals = Some(arrivals);
            self.ahead.extend(next?);
            return Ok(());
        }
        loop {
            self.look_ahead(refusals)?;
            let Some((next_ns, source, line)) = self.ahead.front().map(time_source_line) else {
                return Ok(());
            };
            if self.runs_away(next_ns, source) {
                let what = format!("{} is far beyond the rows around it", seconds(next_ns));
                refusals.out_of_order(&self.path, (line, self.time_column), &what);
                self.ahead.pop_front();
                continue;
            }
            let after = self.ahead.get(1).map(time_source_line);
            let Some((after_ns, _, line)) = after.filter(|(after_ns, ..)| *after_ns < next_ns) else {
                return Ok(());
            };
            let remedy = match next_ns - after_ns > MIDNIGHT_STEP_NS {
                true => MIDNIGHT_REMEDY,
                false => "sort the rows by time",
            };
            let what = format!(
                "{} is before {}, the time of an earlier row; {remedy}",
                seconds(after_ns),
                seconds(next_ns)
            );
            self.leave_out(refusals, line, what);
            self.ahead.remove(1);
        }
    }

    /// Returns the next row in the order of arrival; nothing is read ahead.
    fn next_arrival(
        &mut self,
        arrivals: &mut ArrivalOrder,
        refusals: &mut SkippedRows,
    ) -> Result<Option<ArrivedReport>, InputError> {
        loop {
            if let Some(row) = arrivals.pop() {
                return Ok(Some(row));
            }
            self.read(refusals)?;
            match self.ahead.pop_back() {
                Some(row) => arrivals.push(&row),
                None => {
                    arrivals.end();
                    return Ok(arrivals.pop());
                }
            }
        }
    }

    /// Whether the time of the next row, from `source`, is far beyond most following rows of other sensors, or, without
    /// other sensors, of the same sensor.
    fn runs_away(&self, next_ns: i64, source: u16) -> bool {
        let latest_ns = next_ns.saturating_sub(LEAP_NS);
        if latest_ns <= self.given_ns {
            return false; // no time can speak against it
        }
        let following = || self.ahead.iter().skip(1);
        let has_others = following().any(|row| row.track.source != source);
        let judges = following().filter(|row| (row.track.source != source) == has_others);
        let times = judges.map(|row| row.track.time_of_measurement_ns);
        let (mut against, mut for_it) = (0, 0);
        for time_ns in times {
            against += usize::from((self.given_ns..latest_ns).contains(&time_ns));
            for_it += usize::from(time_ns >= latest_ns);
        }
        against > for_it
    }

    /// Fills the read-ahead buffer.
    fn look_ahead(&mut self, refusals: &mut SkippedRows) -> Result<(), InputError> {
        while self.ahead.len() <= AHEAD && self.read(refusals)? {}
        Ok(())
    }

    /// Reads the next readable row, behind the rows read ahead; `false` at the end.
    fn read(&mut self, refusals: &mut SkippedRows) -> Result<bool, InputError> {
        let (reader, kept) = match &mut self.rows {
            LaneRows::File { reader, kept } => (reader, kept),
            LaneRows::Kept { reader, octets } => {
                let has_next = reader.next_into(&mut self.ahead);
                if has_next {
                    self.readable += 1;
                    *octets.borrow_mut() += reader.octets_of_row();
                }
                return Ok(has_next);
            }
        };
        while let Some(row) = reader.next() {
            let track = match row {
                Ok(track) => track,
                Err(error) => {
                    refusals.skip(&self.path, error)?;
                    *kept = None;
                    continue;
                }
            };
            let row = ArrivedReport {
                arrival_ns: reader.arrival_ns(&track),
                track,
                line: reader.line(),
            };
            *kept = kept.take().and_then(|kept| kept.with(&row));
            self.readable += 1;
            self.since_1970 = is_since_1970(row.track.time_of_measurement_ns);
            self.ahead.push_back(row);
            return Ok(true);
        }
        Ok(false)
    }
}

/// Finds how far the rows of `path` are out of order.
fn arrivals_of(host: &dyn Host, path: &Path, order: RowOrder) -> Result<ArrivalOrder, InputError> {
    let input = CountingInput::new(host.open(path)?, Rc::default());
    let reader = SensorTrackReader::new(input, 0, |_| Some(0)).map_err(|error| InputError::new(path, error))?;
    let order = ArrivalOrder::of(reader, order);
    match order.midnight() {
        Some((line, time_ns)) => {
            let what = format!(
                "line {line}: {} is more than half a day before the time of an earlier row; {MIDNIGHT_REMEDY}",
                seconds(time_ns)
            );
            Err(InputError::new(path, what))
        }
        None => Ok(order),
    }
}

fn time_source_line(row: &ArrivedReport) -> (i64, u16, u64) {
    (row.track.time_of_measurement_ns, row.track.source, row.line)
}

fn seconds(ns: i64) -> f64 {
    frames::time::seconds(ns)
}
