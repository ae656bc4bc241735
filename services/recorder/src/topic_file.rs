//! One topic written to one file, a row per sample.
//!
//! Samples of a recording are numbered from 0, and each is one row; so a file says by its rows how far it has got, and
//! what is published again after a restart is recognised. System tracks are not: a restarted fusion makes new ones.

use std::fmt::Debug;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use anyhow::Context as _;
use bus::{Bus, Subscriber, SubscriberCounts, Transport, Waiter};
use formats::rows::RowWriter;
use frames::SystemFrame;
use messages::{BatchHeader, StreamId};

use crate::recorded::Recorded;
use crate::recovery::{self, Opened};

/// Slices taken from one topic before the next one's turn.
const SLICES_PER_TOPIC: usize = 64;

/// Where files are made, and of what.
#[derive(Debug)]
pub(crate) struct Place<'a, S: Transport> {
    pub(crate) bus: &'a Bus<S>,
    /// Woken by every topic that is opened.
    pub(crate) waiter: &'a mut Waiter<S>,
    pub(crate) folder: &'a Path,
    /// Whether files that are there are continued.
    pub(crate) resume: bool,
    /// Monotonic start time of the recorder.
    pub(crate) incarnation: u64,
    pub(crate) first_day_ns: i64,
    /// System frame.
    pub(crate) frame: SystemFrame,
    /// Whether the inputs are recordings.
    pub(crate) replays: bool,
}

/// A file of whatever stream.
pub(crate) trait StreamFile: Debug {
    /// The stream.
    fn id(&self) -> StreamId;

    /// Writes what has arrived; whether there was anything. `done` hears of each slice and of how far the file has got.
    fn write_arrived(&mut self, done: &mut dyn FnMut(&BatchHeader, u64)) -> anyhow::Result<bool>;

    /// Whether something has arrived.
    fn has_slices(&self) -> bool;

    /// Counts so far.
    fn counts(&self) -> FileCounts;

    /// Whether the publisher has said that nothing follows.
    fn has_ended(&self) -> bool;

    /// Hands everything to the system.
    fn flush(&mut self) -> anyhow::Result<()>;
}

/// Counts of one file.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FileCounts {
    pub(crate) subscriber: SubscriberCounts,
    /// Samples that are in no file: lost on the way, or with a recorder that died.
    pub(crate) lost: u64,
    pub(crate) rows: u64,
    /// Latest time of the data, UTC, nanoseconds; `i64::MIN` before the first sample.
    pub(crate) progress_ns: i64,
}

/// File of samples `T`.
#[derive(Debug)]
pub(crate) struct TopicFile<S: Transport, T: Recorded> {
    id: StreamId,
    path: String,
    subscriber: Subscriber<S, T>,
    writer: RowWriter<T::Row, BufWriter<File>>,
    frame: SystemFrame,
    /// Whether the samples are numbered over all their publishers.
    is_replay: bool,
    /// Samples of a replay below this have been written, whoever publishes them again.
    next_sequence: u64,
    /// Samples of a replay that were published but are in no row: a recorder died with them.
    missed: u64,
    rows: u64,
    progress_ns: i64,
    ended: bool,
}

impl<S: Transport, T: Recorded> TopicFile<S, T> {
    /// Opens the file `<stem>_<name>.csv`, or `<stem>.csv` where there is no name.
    pub(crate) fn open(
        place: &mut Place<'_, S>,
        id: StreamId,
        name: &str,
        stem: &str,
    ) -> anyhow::Result<Box<dyn StreamFile>> {
        let file = match name {
            "" => format!("{stem}.csv"),
            name => format!("{stem}_{name}.csv"),
        };
        let path = place.folder.join(file);
        let topic = T::topic(name);
        let Opened { file, rows } = recovery::open(&path, place.resume)?;
        let file = BufWriter::new(file);
        place.waiter.watch(place.bus, &topic)?;
        Ok(Box::new(Self {
            id,
            path: path.display().to_string(),
            subscriber: place.bus.subscriber(&topic, || place.incarnation)?,
            writer: match rows {
                0 => RowWriter::begin(file, place.first_day_ns)?,
                _ => RowWriter::resume(file, place.first_day_ns),
            },
            frame: place.frame,
            is_replay: place.replays && id.stream.is_replayed(),
            next_sequence: rows,
            missed: 0,
            rows: 0,
            progress_ns: i64::MIN,
            ended: false,
        }))
    }
}

impl<S: Transport, T: Recorded> StreamFile for TopicFile<S, T> {
    fn id(&self) -> StreamId {
        self.id
    }

    fn write_arrived(&mut self, done: &mut dyn FnMut(&BatchHeader, u64)) -> anyhow::Result<bool> {
        let Self {
            id,
            path,
            subscriber,
            writer,
            frame,
            is_replay,
            next_sequence,
            missed,
            rows,
            progress_ns,
            ended,
        } = self;
        let mut written: io::Result<()> = Ok(());
        let taken = subscriber.take(SLICES_PER_TOPIC, |header, samples| {
            for sample in samples {
                let sequence = sample.sequence();
                if *is_replay && sequence < *next_sequence {
                    continue;
                }
                *missed += if *is_replay { sequence - *next_sequence } else { 0 };
                *next_sequence = sequence.saturating_add(1);
                *progress_ns = (*progress_ns).max(sample.time_ns());
                let Some(row) = sample.row(id.number, frame) else {
                    continue;
                };
                if written.is_ok() {
                    written = writer.write(&row);
                    *rows += 1;
                }
            }
            *ended |= header.flags & BatchHeader::END != 0;
            done(header, *next_sequence);
        })?;
        written.with_context(|| format!("writing {path}"))?;
        Ok(taken > 0)
    }

    fn has_slices(&self) -> bool {
        self.subscriber.has_slices()
    }

    fn counts(&self) -> FileCounts {
        let subscriber = self.subscriber.counts();
        FileCounts {
            subscriber,
            // The numbers of a replay's samples tell more than those of its slices: what a dead recorder had taken too.
            lost: if self.is_replay { self.missed } else { subscriber.lost },
            rows: self.rows,
            progress_ns: self.progress_ns,
        }
    }

    fn has_ended(&self) -> bool {
        self.ended
    }

    fn flush(&mut self) -> anyhow::Result<()> {
        self.writer.flush().with_context(|| format!("writing {}", self.path))
    }
}
