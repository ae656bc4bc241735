//! File of one topic, with a row per sample.
//!
//! Samples of a replay are numbered, so the rows of a file state its position (`numbering`), and samples published
//! again after a restart are recognised. System tracks have no such numbers, because a restarted fusion makes new
//! tracks.
//!
//! The recorder passes rows to the operating system before it acknowledges them. A killed recorder has therefore
//! not acknowledged any row that was lost with it.

use std::fmt::Debug;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use anyhow::Context as _;
use bus::{Bus, Subscriber, SubscriberCounts, Transport, Waiter};
use formats::rows::RowWriter;
use frames::SystemFrame;
use messages::{BatchHeader, StreamId};

use crate::numbering::Numbering;
use crate::recorded::{ForSamples, Recorded, for_samples};
use crate::recovery::{self, Opened};

/// Slices taken from one topic before the next one's turn.
const SLICES_PER_TOPIC: usize = 64;

/// Parameters of new files.
#[derive(Debug)]
pub(crate) struct Place<'a, S: Transport> {
    pub(crate) bus: &'a Bus<S>,
    /// Woken by every opened topic.
    pub(crate) waiter: &'a mut Waiter<S>,
    pub(crate) folder: &'a Path,
    /// Whether existing files are continued.
    pub(crate) resume: bool,
    /// Monotonic start time of the recorder.
    pub(crate) incarnation: u64,
    pub(crate) first_day_ns: i64,
    /// System frame.
    pub(crate) frame: SystemFrame,
    /// Whether the inputs are recordings.
    pub(crate) replays: bool,
}

/// File of any stream.
pub(crate) trait StreamFile: Debug {
    /// Returns the stream.
    fn id(&self) -> StreamId;

    /// Writes the arrived slices; returns whether there were any. Calls `done` with each slice and the file's new
    /// position.
    fn write_arrived(&mut self, done: &mut dyn FnMut(&BatchHeader, u64)) -> anyhow::Result<bool>;

    /// Whether slices have arrived.
    fn has_slices(&self) -> bool;

    /// Returns the counts so far.
    fn counts(&self) -> FileCounts;

    /// Returns the number of the next sample of a replay; 0 for streams without numbers.
    fn next_sequence(&self) -> u64;
}

/// Counts of one file.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FileCounts {
    pub(crate) subscriber: SubscriberCounts,
    /// Samples in no file: lost in transit, or with a terminated recorder.
    pub(crate) lost: u64,
    /// Samples of a replay missing before the last row, whichever recorder lost them.
    pub(crate) missing: u64,
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
    /// Numbers of the samples, if they count over all publishers.
    numbering: Option<Numbering>,
    /// Samples already missing at the start of this recorder.
    missing_before: u64,
    rows: u64,
    progress_ns: i64,
}

/// Opens the file of a stream whose source or sensor is called `name`.
pub(crate) fn open<S: Transport>(
    place: &mut Place<'_, S>,
    id: StreamId,
    name: &str,
) -> anyhow::Result<Box<dyn StreamFile>> {
    for_samples(id.stream, Opening { place, id, name })
}

struct Opening<'a, 'p, S: Transport> {
    place: &'a mut Place<'p, S>,
    id: StreamId,
    name: &'a str,
}

impl<S: Transport> ForSamples for Opening<'_, '_, S> {
    type Done = anyhow::Result<Box<dyn StreamFile>>;

    fn of<T: Recorded>(self, stem: &str) -> Self::Done {
        let Self { place, id, name } = self;
        Ok(Box::new(TopicFile::<S, T>::open(place, id, name, stem)?))
    }
}

/// Returns the file name of a stream of a source or sensor; of the system if `name` is empty.
pub(crate) fn file_name(stem: &str, name: &str) -> String {
    match name {
        "" => format!("{stem}.csv"),
        name => format!("{stem}_{name}.csv"),
    }
}

impl<S: Transport, T: Recorded> TopicFile<S, T> {
    fn open(place: &mut Place<'_, S>, id: StreamId, name: &str, stem: &str) -> anyhow::Result<Self> {
        let path = place.folder.join(file_name(stem, name));
        let topic = T::topic(name);
        let Opened { file, rows } = recovery::open(&path, place.resume)?;
        let file = BufWriter::new(file);
        let is_replay = place.replays && id.stream.is_replayed();
        let numbers = || Numbering::of(&path, rows).with_context(|| format!("reading the gaps of {}", path.display()));
        let numbering = is_replay.then(numbers).transpose()?;
        place.waiter.watch(place.bus, &topic)?;
        Ok(Self {
            id,
            path: path.display().to_string(),
            // A file holds everything that was published, of all epochs.
            subscriber: place.bus.subscriber(&topic, || place.incarnation)?.of_all_epochs(),
            writer: match rows {
                0 => RowWriter::begin(file, place.first_day_ns)?,
                _ => RowWriter::resume(file, place.first_day_ns),
            },
            frame: place.frame,
            missing_before: numbering.as_ref().map_or(0, Numbering::missing),
            numbering,
            rows: 0,
            progress_ns: i64::MIN,
        })
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
            numbering,
            missing_before: _,
            rows,
            progress_ns,
        } = self;
        let mut written: io::Result<()> = Ok(());
        let taken = subscriber.take(SLICES_PER_TOPIC, |header, samples| {
            for sample in samples {
                let sequence = sample.sequence();
                if numbering
                    .as_ref()
                    .is_some_and(|numbers| sequence < numbers.next_sequence())
                {
                    continue;
                }
                *progress_ns = (*progress_ns).max(sample.time_ns());
                let Some(row) = sample.row(id.number, frame) else {
                    continue;
                };
                if written.is_ok() {
                    let numbered = numbering.as_mut().map_or(Ok(()), |numbers| numbers.add_row(sequence));
                    written = numbered.and_then(|()| writer.write(&row));
                    *rows += 1;
                }
            }
            done(header, numbering.as_ref().map_or(0, Numbering::next_sequence));
        })?;
        if taken > 0 {
            written = written.and_then(|()| writer.flush());
        }
        written.with_context(|| format!("writing {path}"))?;
        Ok(taken > 0)
    }

    fn has_slices(&self) -> bool {
        self.subscriber.has_slices()
    }

    fn counts(&self) -> FileCounts {
        let subscriber = self.subscriber.counts();
        let missing = self.numbering.as_ref().map(Numbering::missing);
        FileCounts {
            subscriber,
            // The numbers of a replay's samples are more complete than those of its slices: they include samples
            // lost with a terminated recorder.
            lost: missing.map_or(subscriber.lost, |missing| missing - self.missing_before),
            missing: missing.unwrap_or(0),
            rows: self.rows,
            progress_ns: self.progress_ns,
        }
    }

    fn next_sequence(&self) -> u64 {
        self.numbering.as_ref().map_or(0, Numbering::next_sequence)
    }
}
