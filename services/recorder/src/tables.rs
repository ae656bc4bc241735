//! Sink of the recorded stream: a table per data stream, with a row per new sample.
//!
//! The recorder writes the tables live, and [`Tables`] made from its files of all topics are identical.
//!
//! Samples of a replay are numbered, so the rows of a table state its position (`gaps`). System tracks have no such
//! numbers, because a restarted fusion makes new tracks.
//!
//! The recorder passes rows to the operating system before it acknowledges them. A killed recorder has therefore
//! not acknowledged any row that was lost with it.
//!
//! A table that cannot be written disturbs no other file: its rows are counted as lost, and each second the table is
//! tried again after its last complete row. A table that somebody has removed begins anew. The same holds for a table
//! that cannot be made at the start; a foreign file in its place is left as it is. The exception is a table of a replay
//! that is continued: only the table itself states the position, so the recorder ends and starts again.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use deployment::Deployment;
use formats::rows::RowWriter;
use frames::SystemFrame;
use messages::StreamId;
use recording::Item;
use runtime::Now;

use crate::account::SampleNumbers;
use crate::gaps::Gaps;
use crate::recorded::{ForSamples, RecordedSample, for_samples};
use crate::recovery::{self, Opened};
use crate::slice::StreamSlice;

/// Time between two attempts to write a table after a failure, and between two looks whether it is still there,
/// nanoseconds.
const RETRY_NS: i64 = 1_000_000_000;

/// Tables of a deployment, one per data stream, in the order of [`deployment::Deployment::streams`].
#[derive(Debug)]
pub struct Tables {
    tables: Vec<TableEntry>,
    /// Places of the tables by the name of the topic.
    places: BTreeMap<String, usize>,
    /// Time of the latest look whether the files are there, monotonic, nanoseconds.
    looked_ns: i64,
    failures: u64,
    /// Rows that could not be written.
    lost: u64,
}

#[derive(Debug)]
struct TableEntry {
    topic: String,
    path: PathBuf,
    table: Box<dyn TableSink>,
    /// Whether rows wait in memory.
    is_gathering: bool,
    /// Number of the next sample of a recording's replayed input: a restarted adapter publishes samples again.
    next_sequence: Option<u64>,
    /// Failure since which nothing has been written.
    failing: Option<Failure>,
}

/// Failure to write a table.
#[derive(Clone, Copy, Debug)]
struct Failure {
    kind: ErrorKind,
    /// Time of the next attempt, monotonic, nanoseconds.
    retry_ns: i64,
    /// Whether rows have been added since the last attempt that wait for the system to take them.
    is_tried: bool,
}

/// Table of any sample type.
trait TableSink: Debug {
    /// Writes the rows of samples, except of those numbered below `from_sequence`. Returns the number after the last
    /// sample.
    fn add(&mut self, octets: &[u8], from_sequence: u64) -> io::Result<u64>;

    /// Passes all rows to the operating system.
    fn flush(&mut self) -> io::Result<()>;

    /// Returns the sample numbers after the last row.
    fn numbers(&self) -> SampleNumbers;

    /// Returns the number of rows written since the start.
    fn rows(&self) -> u64;

    /// Returns the number of rows that [`TableSink::add`] would write.
    fn rows_of(&self, octets: &[u8], from_sequence: u64) -> u64;

    /// Gives up the rows that wait in memory; returns their number.
    fn give_up(&mut self) -> u64;

    /// Opens the file of a table that has none yet.
    fn open(&mut self, path: &Path) -> io::Result<()>;

    /// Whether the file has been open.
    fn is_made(&self) -> bool;

    /// Continues the file after the last row that the system has taken; begins the file anew if it is gone.
    fn reopen(&mut self, path: &Path) -> io::Result<()>;
}

#[derive(Debug)]
struct TableOf<T: RecordedSample> {
    /// `None` until the file could be opened.
    file: Option<TableFile<T>>,
    number: u16,
    frame: SystemFrame,
    first_day_ns: i64,
    /// Whether an existing file is continued.
    resume: bool,
    /// Whether the rows state sample numbers.
    is_numbered: bool,
    rows: u64,
    /// Rows in memory.
    waiting: u64,
}

/// File of a table.
#[derive(Debug)]
struct TableFile<T: RecordedSample> {
    writer: RowWriter<T::Row, BufWriter<File>>,
    /// Gaps of a numbered table.
    gaps: Option<Gaps>,
    /// Rows in the file, and the file's bytes up to the end of the last one.
    whole: (u64, u64),
}

impl Tables {
    /// Begins the tables of a recording of the deployment of `config` in `folder`, with times from `first_day_ns`
    /// (UTC, nanoseconds).
    ///
    /// # Errors
    /// If a file exists already, or cannot be made.
    pub fn begin(config: &Deployment, folder: &Path, first_day_ns: i64) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("making the folder {}", folder.display()))?;
        let mut tables = Self::open(config, folder, first_day_ns, None)?;
        for (entry, (id, _)) in tables.tables.iter_mut().zip(config.recorded_streams()) {
            entry.next_sequence = (config.is_recorded() && id.stream.is_replayed()).then_some(0);
        }
        Ok(tables)
    }

    /// Begins the tables of a recorder; with `resume`, continues the existing tables. A table that cannot be made fails
    /// like one that cannot be written.
    ///
    /// # Errors
    /// If a table of a replay cannot be continued.
    pub(crate) fn resume(config: &Deployment, folder: &Path, first_day_ns: i64, resume: bool) -> anyhow::Result<Self> {
        Self::open(config, folder, first_day_ns, Some(resume))
    }

    fn open(config: &Deployment, folder: &Path, first_day_ns: i64, live: Option<bool>) -> anyhow::Result<Self> {
        let open = |(id, name): (StreamId, &str)| {
            let opening = TableBuilder {
                folder,
                name,
                first_day_ns,
                number: id.number,
                frame: config.frame,
                resume: live.unwrap_or(false),
                is_numbered: live.is_some() && config.is_recorded() && id.stream.is_replayed(),
            };
            for_samples(id.stream, opening)
        };
        let entries: Vec<TableEntry> = config.recorded_streams().map(open).collect();
        let places = entries.iter().enumerate();
        let mut tables = Self {
            places: places.map(|(place, entry)| (entry.topic.clone(), place)).collect(),
            tables: entries,
            looked_ns: i64::MIN,
            failures: 0,
            lost: 0,
        };
        for (place, (id, _)) in config.recorded_streams().enumerate() {
            let entry = &mut tables.tables[place];
            let Err(error) = entry.table.open(&entry.path) else {
                continue;
            };
            let is_position = live == Some(true) && config.is_recorded() && id.stream.is_replayed();
            if live.is_none() || is_position {
                return Err(error).with_context(|| format!("opening {} for writing", entry.path.display()));
            }
            tables.failed(place, &error, i64::MIN);
        }
        Ok(tables)
    }

    /// Writes the rows of a part of the recording.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn add(&mut self, item: &Item<'_>) -> io::Result<()> {
        let Item::Sample { topic, octets } = item else {
            return Ok(());
        };
        let Some(place) = self.places.get(*topic) else {
            return Ok(());
        };
        let entry = &mut self.tables[*place];
        let next = entry.table.add(octets, entry.next_sequence.unwrap_or(0))?;
        entry.next_sequence = entry.next_sequence.map(|before| before.max(next));
        Ok(())
    }

    /// Writes the remaining rows.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.tables.iter_mut().try_for_each(|entry| entry.table.flush())
    }

    /// Writes the rows of a slice, or counts them as lost.
    pub(crate) fn slice(&mut self, slice: &StreamSlice<'_>) {
        let entry = &mut self.tables[slice.place];
        if let Some(failure) = &mut entry.failing
            && !failure.is_tried
        {
            if slice.now.mono_ns < failure.retry_ns {
                self.lost += entry.table.rows_of(slice.octets, slice.from_sequence);
                return;
            }
            failure.is_tried = true;
            if let Err(error) = entry.table.reopen(&entry.path) {
                self.lost += entry.table.rows_of(slice.octets, slice.from_sequence);
                self.failed(slice.place, &error, slice.now.mono_ns);
                return;
            }
        }
        entry.is_gathering = true;
        if let Err(error) = entry.table.add(slice.octets, slice.from_sequence) {
            self.failed(slice.place, &error, slice.now.mono_ns);
        }
    }

    /// Passes the rows of slices to the operating system, and looks whether the files are there.
    pub(crate) fn tend(&mut self, now: Now) {
        let looks = now.mono_ns.saturating_sub(self.looked_ns) >= RETRY_NS;
        if looks {
            self.looked_ns = now.mono_ns;
        }
        for place in 0..self.tables.len() {
            let entry = &mut self.tables[place];
            if looks && !entry.table.is_made() {
                match entry.table.open(&entry.path) {
                    Ok(()) => entry.is_gathering = true,
                    Err(error) => {
                        self.failed(place, &error, now.mono_ns);
                        continue;
                    }
                }
            }
            if std::mem::take(&mut entry.is_gathering) {
                match entry.table.flush() {
                    Ok(()) => entry.failing = None,
                    Err(error) => {
                        self.failed(place, &error, now.mono_ns);
                        continue;
                    }
                }
            }
            if looks && entry.failing.is_none() && matches!(entry.path.try_exists(), Ok(false)) {
                self.failed(place, &ErrorKind::NotFound.into(), now.mono_ns);
            }
        }
    }

    /// Notes a failure at `now_ns` (monotonic, nanoseconds): what waits in memory is lost.
    #[cold]
    fn failed(&mut self, place: usize, error: &io::Error, now_ns: i64) {
        let entry = &mut self.tables[place];
        if self.failures == 0 {
            let path = entry.path.display();
            runtime::notice(format_args!(
                "koseki: a table cannot be written ({path}: {error}); its rows are lost and counted until it can"
            ));
        }
        self.failures += 1;
        self.lost += entry.table.give_up();
        entry.is_gathering = false;
        entry.failing = Some(Failure {
            kind: error.kind(),
            retry_ns: now_ns.saturating_add(RETRY_NS),
            is_tried: false,
        });
    }

    /// Returns the kind of a failure since which a table has not been written.
    pub(crate) fn failing(&self) -> Option<ErrorKind> {
        self.tables
            .iter()
            .find_map(|entry| entry.failing)
            .map(|failure| failure.kind)
    }

    /// Returns the number of failures to write a table.
    pub(crate) fn failures(&self) -> u64 {
        self.failures
    }

    /// Returns the number of rows that could not be written.
    pub(crate) fn lost(&self) -> u64 {
        self.lost
    }

    /// Returns the sample numbers after the last row of the table at this place.
    pub(crate) fn numbers(&self, place: usize) -> SampleNumbers {
        self.tables[place].table.numbers()
    }

    /// Returns the number of rows written to the table at this place since the start.
    pub(crate) fn rows(&self, place: usize) -> u64 {
        self.tables[place].table.rows()
    }
}

struct TableBuilder<'a> {
    folder: &'a Path,
    name: &'a str,
    first_day_ns: i64,
    number: u16,
    frame: SystemFrame,
    /// Whether an existing table is continued.
    resume: bool,
    /// Whether the rows state sample numbers.
    is_numbered: bool,
}

/// Returns the file name of a stream of a source or sensor; of the system if `name` is empty.
fn file_name(stem: &str, name: &str) -> String {
    match name {
        "" => format!("{stem}.csv"),
        name => format!("{stem}_{name}.csv"),
    }
}

impl ForSamples for TableBuilder<'_> {
    type Done = TableEntry;

    fn of<T: RecordedSample>(self, stem: &str) -> TableEntry {
        let table = TableOf::<T> {
            file: None,
            number: self.number,
            frame: self.frame,
            first_day_ns: self.first_day_ns,
            resume: self.resume,
            is_numbered: self.is_numbered,
            rows: 0,
            waiting: 0,
        };
        TableEntry {
            topic: T::topic(self.name).name.as_str().to_owned(),
            path: self.folder.join(file_name(stem, self.name)),
            table: Box::new(table),
            is_gathering: false,
            next_sequence: None,
            failing: None,
        }
    }
}

impl<T: RecordedSample> TableSink for TableOf<T> {
    fn add(&mut self, octets: &[u8], from_sequence: u64) -> io::Result<u64> {
        let file = self.file.as_mut().ok_or(ErrorKind::NotFound)?;
        let mut next_sequence = 0;
        // All rows wait, whether or not an earlier one is refused: what waits is lost with a refused row.
        let mut refused = Ok(());
        for sample in octets.chunks_exact(size_of::<T>()).filter_map(T::of_octets) {
            let sequence = sample.sequence();
            if sequence < from_sequence {
                continue;
            }
            next_sequence = sequence.saturating_add(1);
            let Some(row) = sample.row(self.number, &self.frame) else {
                continue;
            };
            self.waiting += 1;
            self.rows += 1;
            if refused.is_ok() {
                refused = match &mut file.gaps {
                    Some(gaps) => gaps.add_row(sequence).and_then(|()| file.writer.write(&row)),
                    None => file.writer.write(&row),
                };
            }
        }
        refused.map(|()| next_sequence)
    }

    fn flush(&mut self) -> io::Result<()> {
        let Some(file) = &mut self.file else { return Ok(()) };
        file.writer.flush()?;
        file.whole = (
            file.whole.0 + std::mem::take(&mut self.waiting),
            file.writer.get_ref().get_ref().stream_position()?,
        );
        Ok(())
    }

    fn numbers(&self) -> SampleNumbers {
        let gaps = self.file.as_ref().and_then(|file| file.gaps.as_ref());
        gaps.map_or_else(SampleNumbers::default, Gaps::numbers)
    }

    fn rows(&self) -> u64 {
        self.rows
    }

    fn rows_of(&self, octets: &[u8], from_sequence: u64) -> u64 {
        let samples = octets.chunks_exact(size_of::<T>()).filter_map(T::of_octets);
        let is_row = |sample: &T| sample.sequence() >= from_sequence && sample.row(self.number, &self.frame).is_some();
        samples.filter(is_row).count() as u64
    }

    fn give_up(&mut self) -> u64 {
        let lost = std::mem::take(&mut self.waiting);
        self.rows -= lost;
        lost
    }

    fn open(&mut self, path: &Path) -> io::Result<()> {
        let Opened { file, rows } = recovery::open(path, self.resume)?;
        // From here on the file is this table's.
        self.resume = true;
        let whole = (rows, file.metadata()?.len());
        let gaps = self.is_numbered.then(|| Gaps::of(path, rows)).transpose()?;
        let file = BufWriter::new(file);
        let writer = match rows {
            0 => RowWriter::begin(file, self.first_day_ns)?,
            _ => RowWriter::resume(file, self.first_day_ns),
        };
        self.file = Some(TableFile { writer, gaps, whole });
        Ok(())
    }

    fn is_made(&self) -> bool {
        self.file.is_some()
    }

    fn reopen(&mut self, path: &Path) -> io::Result<()> {
        let Some(table) = &mut self.file else {
            return self.open(path);
        };
        let mut options = OpenOptions::new();
        let mut file = options.write(true).create(true).truncate(false).open(path)?;
        if file.metadata()?.len() < table.whole.1 {
            table.whole = (0, 0);
        }
        // Without a row, the file begins with its header again.
        if table.whole.0 == 0 {
            table.whole.1 = 0;
        }
        let at = table.whole.1;
        let other = BufWriter::new(file.try_clone()?);
        let writer = RowWriter::resume(other, self.first_day_ns);
        // Rows in memory are lost already: they must not go into the file late.
        drop(std::mem::replace(&mut table.writer, writer).into_inner().into_parts());
        file.set_len(at)?;
        file.seek(SeekFrom::End(0))?;
        if at == 0 {
            table.writer = RowWriter::begin(BufWriter::new(file), self.first_day_ns)?;
        }
        if table.gaps.is_some() {
            table.gaps = Some(Gaps::of(path, table.whole.0)?);
        }
        Ok(())
    }
}
