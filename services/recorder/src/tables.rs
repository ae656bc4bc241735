//! Sink of the recorded stream: a table per data stream, with a row per new sample.
//!
//! The recorder writes the tables live, and [`Tables`] made from its files of all topics are identical.
//!
//! Samples of a replay are numbered, so the rows of a table state its position (`gaps`). System tracks have no such
//! numbers, because a restarted fusion makes new tracks.
//!
//! The recorder passes rows to the operating system before it acknowledges them. A killed recorder has therefore
//! not acknowledged any row that was lost with it.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use deployment::Deployment;
use formats::rows::RowWriter;
use frames::SystemFrame;
use messages::StreamId;
use recording::Item;

use crate::account::SampleNumbers;
use crate::gaps::Gaps;
use crate::recorded::{ForSamples, RecordedSample, for_samples};
use crate::recovery::{self, Opened};
use crate::slice::StreamSlice;

/// Tables of a deployment, one per data stream, in the order of [`deployment::Deployment::streams`].
#[derive(Debug)]
pub struct Tables {
    tables: Vec<TableEntry>,
    /// Places of the tables by the name of the topic.
    places: BTreeMap<String, usize>,
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
}

#[derive(Debug)]
struct TableOf<T: RecordedSample> {
    writer: RowWriter<T::Row, BufWriter<File>>,
    number: u16,
    frame: SystemFrame,
    /// Gaps of a numbered table.
    gaps: Option<Gaps>,
    rows: u64,
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
        for (entry, (id, _)) in tables.tables.iter_mut().zip(config.streams()) {
            entry.next_sequence = (config.is_recorded() && id.stream.is_replayed()).then_some(0);
        }
        Ok(tables)
    }

    /// Begins the tables of a recorder; with `resume`, continues the existing tables.
    ///
    /// # Errors
    /// If a file cannot be made or continued.
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
        let tables: Vec<TableEntry> = config.streams().map(open).collect::<Result<_, _>>()?;
        let places = tables.iter().enumerate();
        Ok(Self {
            places: places.map(|(place, entry)| (entry.topic.clone(), place)).collect(),
            tables,
        })
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

    /// Writes the rows of a slice.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub(crate) fn slice(&mut self, slice: &StreamSlice<'_>) -> anyhow::Result<()> {
        let entry = &mut self.tables[slice.place];
        entry.is_gathering = true;
        let written = entry.table.add(slice.octets, slice.from_sequence);
        written.with_context(|| format!("writing {}", entry.path.display()))?;
        Ok(())
    }

    /// Passes the rows of slices to the operating system.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub(crate) fn flush(&mut self) -> anyhow::Result<()> {
        for entry in self.tables.iter_mut().filter(|entry| entry.is_gathering) {
            let flushed = entry.table.flush();
            flushed.with_context(|| format!("writing {}", entry.path.display()))?;
            entry.is_gathering = false;
        }
        Ok(())
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
    type Done = anyhow::Result<TableEntry>;

    fn of<T: RecordedSample>(self, stem: &str) -> Self::Done {
        let path = self.folder.join(file_name(stem, self.name));
        let Opened { file, rows } = recovery::open(&path, self.resume)?;
        let file = BufWriter::new(file);
        let gaps = || Gaps::of(&path, rows).with_context(|| format!("reading the gaps of {}", path.display()));
        let gaps = self.is_numbered.then(gaps).transpose()?;
        let writer = match rows {
            0 => RowWriter::begin(file, self.first_day_ns)
                .with_context(|| format!("opening {} for writing", path.display()))?,
            _ => RowWriter::resume(file, self.first_day_ns),
        };
        let table = TableOf::<T> {
            writer,
            number: self.number,
            frame: self.frame,
            gaps,
            rows: 0,
        };
        Ok(TableEntry {
            topic: T::topic(self.name).name.as_str().to_owned(),
            path,
            table: Box::new(table),
            is_gathering: false,
            next_sequence: None,
        })
    }
}

impl<T: RecordedSample> TableSink for TableOf<T> {
    fn add(&mut self, octets: &[u8], from_sequence: u64) -> io::Result<u64> {
        let mut next_sequence = 0;
        for sample in octets.chunks_exact(size_of::<T>()).filter_map(T::of_octets) {
            let sequence = sample.sequence();
            if sequence < from_sequence {
                continue;
            }
            next_sequence = sequence.saturating_add(1);
            let Some(row) = sample.row(self.number, &self.frame) else {
                continue;
            };
            self.gaps.as_mut().map_or(Ok(()), |gaps| gaps.add_row(sequence))?;
            self.writer.write(&row)?;
            self.rows += 1;
        }
        Ok(next_sequence)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }

    fn numbers(&self) -> SampleNumbers {
        self.gaps.as_ref().map_or_else(SampleNumbers::default, Gaps::numbers)
    }

    fn rows(&self) -> u64 {
        self.rows
    }
}
