//! Tables made from a recording of all topics, identical to those written live.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use anyhow::Context as _;
use configuration::Config;
use formats::rows::RowWriter;
use frames::SystemFrame;
use recording::Item;

use crate::recorded::{ForSamples, Recorded, for_samples};
use crate::topic_file::file_name;

/// Tables of a deployment, one per stream.
#[derive(Debug)]
pub struct Tables {
    /// Tables by the name of the topic.
    topics: BTreeMap<String, Box<dyn Table>>,
}

trait Table: Debug {
    /// Writes the row of a sample.
    fn add(&mut self, octets: &[u8]) -> io::Result<()>;

    fn finish(&mut self) -> io::Result<()>;
}

#[derive(Debug)]
struct TableOf<T: Recorded> {
    writer: RowWriter<T::Row, BufWriter<File>>,
    number: u16,
    frame: SystemFrame,
    /// Number of the next sample of a replayed input: a restarted adapter publishes the earlier samples again.
    next_sequence: Option<u64>,
}

impl Tables {
    /// Begins the tables of the deployment of `config` in `folder`, with times from `first_day_ns` (UTC,
    /// nanoseconds).
    ///
    /// # Errors
    /// If a file exists already, or cannot be made.
    pub fn begin(config: &Config, folder: &Path, first_day_ns: i64) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("making the folder {}", folder.display()))?;
        let mut topics = BTreeMap::new();
        for (id, name) in config.streams() {
            let is_numbered = config.is_recorded() && id.stream.is_replayed();
            let beginning = Beginning {
                folder,
                name,
                first_day_ns,
                number: id.number,
                frame: config.frame,
                next_sequence: is_numbered.then_some(0),
            };
            let (topic, table) = for_samples(id.stream, beginning)?;
            topics.insert(topic, table);
        }
        Ok(Self { topics })
    }

    /// Writes the rows of a part of the recording.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn add(&mut self, item: &Item<'_>) -> io::Result<()> {
        let Item::Sample { topic, octets } = item else {
            return Ok(());
        };
        self.topics.get_mut(*topic).map_or(Ok(()), |table| table.add(octets))
    }

    /// Writes the remaining rows.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.topics.values_mut().try_for_each(|table| table.finish())
    }
}

struct Beginning<'a> {
    folder: &'a Path,
    name: &'a str,
    first_day_ns: i64,
    number: u16,
    frame: SystemFrame,
    next_sequence: Option<u64>,
}

impl ForSamples for Beginning<'_> {
    type Done = anyhow::Result<(String, Box<dyn Table>)>;

    fn of<T: Recorded>(self, stem: &str) -> Self::Done {
        let path = self.folder.join(file_name(stem, self.name));
        let begin = || RowWriter::begin(BufWriter::new(File::create_new(&path)?), self.first_day_ns);
        let writer = begin().with_context(|| format!("opening {} for writing", path.display()))?;
        let table = TableOf::<T> {
            writer,
            number: self.number,
            frame: self.frame,
            next_sequence: self.next_sequence,
        };
        Ok((T::topic(self.name).name.as_str().to_owned(), Box::new(table)))
    }
}

impl<T: Recorded> Table for TableOf<T> {
    fn add(&mut self, octets: &[u8]) -> io::Result<()> {
        let Some(sample) = T::of_octets(octets) else {
            return Ok(());
        };
        if let Some(next) = &mut self.next_sequence {
            if sample.sequence() < *next {
                return Ok(());
            }
            *next = sample.sequence().saturating_add(1);
        }
        let row = sample.row(self.number, &self.frame);
        row.map_or(Ok(()), |row| self.writer.write(&row))
    }

    fn finish(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}
