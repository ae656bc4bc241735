//! Successive files of the recording of all topics.
//!
//! A starting recorder ends the file left by a terminated recorder and begins the next. Samples that cannot be
//! written are counted, and writing is retried in a new file. A full disk thus costs samples, but neither files nor
//! the deployment.

use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use configuration::Segments as Settings;
use messages::BatchHeader;
use messages::layout::Layout;
use recording::{Channel, Facts, RecordingError, Survey, Tally, Writer};
use runtime::{Now, NumberedFiles};

/// Time between two attempts to write after a failure, nanoseconds.
const RETRY_NS: i64 = 1_000_000_000;

/// Prefix of the file names.
const STEM: &str = "all_topics_";

/// Successive files of the recording.
#[derive(Debug)]
pub(crate) struct Segments {
    files: NumberedFiles,
    settings: Settings,
    facts: Facts,
    topics: Vec<Topic>,
    /// Number of the latest file.
    number: u32,
    open: Option<Open>,
    /// Time of the next attempt to write, monotonic, nanoseconds.
    retry_ns: i64,
    counts: SegmentCounts,
}

/// Recorded topic.
#[derive(Debug)]
struct Topic {
    name: String,
    layout: Layout,
    tally: Tally,
    /// Samples not yet on disk.
    gathered: u64,
}

/// File being written.
#[derive(Debug)]
struct Open {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    channels: Vec<Channel>,
    begun_ns: i64,
    flushed_ns: i64,
    bytes: u64,
}

/// Counts since the recorder started.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SegmentCounts {
    pub(crate) samples: u64,
    /// Samples in no file, including those lost with an earlier recorder.
    pub(crate) lost: u64,
    pub(crate) failures: u64,
    pub(crate) deleted: u64,
}

impl Segments {
    /// Continues the recording in `folder`, or begins one at `since_ns` (monotonic, nanoseconds). Each file records
    /// `topics` and begins with `facts`.
    ///
    /// # Errors
    /// If the folder or the latest file cannot be read.
    pub(crate) fn new(
        folder: &Path,
        settings: Settings,
        facts: Facts,
        topics: Vec<(String, Layout)>,
        since_ns: u64,
    ) -> anyhow::Result<Self> {
        let mut earlier = Survey::default();
        let files = NumberedFiles::new(folder, STEM, ".mcap");
        let found = files.list()?;
        let number = found.last().map_or(0, |(number, _)| *number);
        for (_, path) in found.iter().rev() {
            if recording::whole(&mut File::open(path)?)?.bytes > 0 {
                end(path)?;
                earlier.add(&mut File::open(path)?)?;
            }
            if !earlier.facts.is_empty() {
                break;
            }
            // A recorder terminated before its first record, so the file before holds the positions of the topics.
            std::fs::remove_file(path)?;
        }
        let topics = topics.into_iter().map(|(name, layout)| {
            let known = earlier.topics.get(&name).map(|topic| topic.tally.clone());
            let told = || match earlier.facts.is_empty() {
                true => Tally::since(&name, since_ns),
                false => Tally::begin(&name, &earlier.facts),
            };
            Topic {
                tally: known.unwrap_or_else(told),
                name,
                layout,
                gathered: 0,
            }
        });
        Ok(Self {
            files,
            settings,
            facts,
            topics: topics.collect(),
            number,
            open: None,
            retry_ns: i64::MIN,
            counts: SegmentCounts::default(),
        })
    }

    /// Returns the number of the next expected sample of a publisher of the topic at this place of the list; 0 for
    /// an unknown publisher.
    pub(crate) fn next_sequence(&self, topic: usize, incarnation: u64) -> u64 {
        self.topics[topic].tally.next_of(incarnation)
    }

    pub(crate) fn counts(&self) -> SegmentCounts {
        self.counts
    }

    /// Records that a publisher of the topic at this place of the list had sent all samples below this number.
    pub(crate) fn catch_up(&mut self, topic: usize, incarnation: u64, next_sequence: u64) {
        let tally = &mut self.topics[topic].tally;
        let before = tally.lost;
        tally.catch_up(incarnation, next_sequence);
        self.counts.lost += tally.lost - before;
    }

    /// Adds a slice of the topic at this place of the list; `octets` holds its samples.
    pub(crate) fn slice(&mut self, topic: usize, header: &BatchHeader, octets: &[u8], now: Now) {
        // First, because a file begins with the positions of the topics before it.
        self.open_if_due(now);
        let of = &mut self.topics[topic];
        let (count, before) = (octets.len() / of.layout.size, of.tally.lost);
        of.tally.slice(header, count);
        self.counts.samples += count as u64;
        self.counts.lost += of.tally.lost - before;
        self.topics[topic].gathered += count as u64;
        let Some(open) = &mut self.open else {
            self.give_up_gathered();
            return;
        };
        let sent_ns = now.utc_ns - (now.mono_ns - header.sent_ns);
        let written = open
            .writer
            .slice(open.channels[topic], header, octets, now.utc_ns, sent_ns);
        match written {
            Ok(false) => {}
            Ok(true) => self.flushed(now),
            Err(error) => self.failed(&error, now),
        }
    }

    /// Performs periodic work: writes gathered samples, begins another file, deletes old files.
    pub(crate) fn tend(&mut self, now: Now) {
        self.open_if_due(now);
        let Some(open) = &mut self.open else { return };
        if now.mono_ns - open.flushed_ns < self.settings.flush_ns {
            return;
        }
        match open.writer.flush() {
            Ok(()) => self.flushed(now),
            Err(error) => self.failed(&error, now),
        }
        let is_over =
            |open: &Open| open.bytes >= self.settings.bytes || now.mono_ns - open.begun_ns >= self.settings.length_ns;
        if self.open.as_ref().is_some_and(is_over) {
            self.finish(now);
        }
        self.make_room(now);
    }

    /// Ends the current file.
    pub(crate) fn finish(&mut self, now: Now) {
        if let Some(open) = self.open.take() {
            match open.writer.finish() {
                Ok(()) => self.topics.iter_mut().for_each(|topic| topic.gathered = 0),
                Err(error) => self.give_up(&open.path, &error, now),
            }
        }
    }

    fn flushed(&mut self, now: Now) {
        self.topics.iter_mut().for_each(|topic| topic.gathered = 0);
        if let Some(open) = &mut self.open {
            open.flushed_ns = now.mono_ns;
            open.bytes = std::fs::metadata(&open.path).map_or(0, |file| file.len());
        }
    }

    fn failed(&mut self, error: &RecordingError, now: Now) {
        if let Some(open) = self.open.take() {
            // Dropping the writer attempts to write the rest; a failed rest is cut off.
            drop(open.writer);
            self.give_up(&open.path, error, now);
        }
    }

    fn give_up(&mut self, path: &Path, error: &RecordingError, now: Now) {
        if self.counts.failures == 0 {
            let lead = "koseki: the recording of all topics cannot be written";
            let path = path.display();
            runtime::notice(format_args!(
                "{lead} ({path}: {error}); samples are lost and counted until it can"
            ));
        }
        self.counts.failures += 1;
        self.retry_ns = now.mono_ns + RETRY_NS;
        self.give_up_gathered();
        // If this fails as well, the next recorder ends the file.
        let _ = end(path);
    }

    fn give_up_gathered(&mut self) {
        for topic in &mut self.topics {
            topic.tally.lost += topic.gathered;
            self.counts.lost += std::mem::take(&mut topic.gathered);
        }
    }

    fn open_if_due(&mut self, now: Now) {
        if self.open.is_some() || now.mono_ns < self.retry_ns {
            return;
        }
        self.number += 1;
        let path = self.files.path(self.number);
        match self.begin(&path, now) {
            Ok(open) => self.open = Some(open),
            Err(error) => {
                self.give_up(&path, &error, now);
                // The file is empty.
                let _ = std::fs::remove_file(&path);
                self.number -= 1;
            }
        }
    }

    fn begin(&self, path: &Path, now: Now) -> Result<Open, RecordingError> {
        let mut facts = self.facts.clone();
        for topic in &self.topics {
            topic.tally.state(&topic.name, &mut facts);
        }
        let mut writer = Writer::begin(BufWriter::new(File::create_new(path)?), &facts)?;
        let channels = self.topics.iter();
        let channels = channels.map(|topic| writer.channel(&topic.name, &topic.layout));
        let channels = channels.collect::<Result<_, _>>()?;
        writer.flush()?;
        Ok(Open {
            path: path.to_owned(),
            writer,
            channels,
            begun_ns: now.mono_ns,
            flushed_ns: now.mono_ns,
            bytes: 0,
        })
    }

    /// Deletes the oldest files until the others fit the configured space; never deletes the current file.
    fn make_room(&mut self, now: Now) {
        let Some(keep_bytes) = self.settings.keep_bytes else {
            return;
        };
        for path in self.files.beyond(keep_bytes).unwrap_or_default() {
            if let Err(error) = std::fs::remove_file(&path) {
                self.failed(&error.into(), now);
                return;
            }
            self.counts.deleted += 1;
        }
    }
}

/// Ends a file that has no end record.
fn end(path: &Path) -> std::io::Result<()> {
    let mut file = OpenOptions::new().read(true).append(true).open(path)?;
    let whole = recording::whole(&mut file)?;
    if !whole.is_ended {
        file.set_len(whole.bytes)?;
        file.write_all(&recording::closing())?;
    }
    Ok(())
}
