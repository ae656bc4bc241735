//! One topic written to one file, a row per sample.
//!
//! Samples of a recording are numbered from 0, and each is one row; so a file says by its rows how far it has got, and
//! what is published again after a restart is recognised.

use std::fs::File;
use std::io::{self, BufWriter};

use anyhow::Context as _;
use bus::{Bus, Payload, Subscriber, Transport, Waiter};
use formats::detections_csv::DetectionWriter;
use formats::tracks_csv::SensorTrackWriter;
use formats::wide_area_csv::WideAreaWriter;
use messages::{BatchHeader, SensorDetection, SensorTrack, Topic, WideArea};
use observations::{Detection, Sampled, WideAreaReport};

use crate::recovery::Opened;

/// Slices taken from one topic before the next one's turn.
pub(crate) const SLICES_PER_TOPIC: usize = 64;

type Out = BufWriter<File>;

/// Writes samples of one kind as rows.
pub(crate) trait Rows: Sized {
    type Sample: Payload;
    /// What they are, for errors.
    const WHAT: &'static str;

    fn begin(out: Out, first_day_ns: i64) -> io::Result<Self>;
    fn resume(out: Out, first_day_ns: i64) -> Self;
    fn sequence(sample: &Self::Sample) -> u64;
    /// Writes the row of a sample of the source or sensor `number`; whether there is one.
    fn write(&mut self, number: u16, sample: &Self::Sample) -> io::Result<bool>;
    fn flush(&mut self) -> io::Result<()>;
}

/// See the module's documentation.
#[derive(Debug)]
pub(crate) struct TopicFile<S: Transport, W: Rows> {
    /// The source or sensor.
    pub(crate) number: u16,
    pub(crate) subscriber: Subscriber<S, W::Sample>,
    writer: W,
    /// Samples of a recording below this have been written, whoever publishes them again.
    next_sequence: u64,
    /// Samples of a recording that were published but are in no row: a recorder died with them.
    pub(crate) missed: u64,
    pub(crate) rows: u64,
    pub(crate) ended: bool,
}

impl<S: Transport, W: Rows> TopicFile<S, W> {
    pub(crate) fn open(
        (bus, waiter): (&Bus<S>, &mut Waiter<S>),
        incarnation: u64,
        topic: &Topic<W::Sample>,
        number: u16,
        Opened { file, rows }: Opened,
        first_day_ns: i64,
    ) -> anyhow::Result<Self> {
        waiter.watch(bus, topic)?;
        let file = BufWriter::new(file);
        Ok(Self {
            number,
            subscriber: bus.subscriber(topic, || incarnation)?,
            writer: match rows {
                0 => W::begin(file, first_day_ns)?,
                _ => W::resume(file, first_day_ns),
            },
            next_sequence: rows,
            missed: 0,
            rows: 0,
            ended: false,
        })
    }

    /// Writes what has arrived; whether there was anything. `done` hears of each slice and of how far the file has got.
    pub(crate) fn write_arrived(
        &mut self,
        recorded: bool,
        mut done: impl FnMut(&BatchHeader, u64),
    ) -> anyhow::Result<bool> {
        let Self {
            number,
            subscriber,
            writer,
            next_sequence,
            missed,
            rows,
            ended,
        } = self;
        let mut failed: io::Result<()> = Ok(());
        let taken = subscriber.take(SLICES_PER_TOPIC, |header, samples| {
            for sample in samples {
                let sequence = W::sequence(sample);
                if recorded && sequence < *next_sequence {
                    continue;
                }
                *missed += if recorded { sequence - *next_sequence } else { 0 };
                *next_sequence = sequence + 1;
                failed = std::mem::replace(&mut failed, Ok(())).and_then(|()| {
                    *rows += u64::from(writer.write(*number, sample)?);
                    Ok(())
                });
            }
            *ended |= header.flags & BatchHeader::END != 0;
            done(header, *next_sequence);
        })?;
        failed.with_context(|| format!("writing {}", W::WHAT))?;
        Ok(taken > 0)
    }

    pub(crate) fn flush(&mut self) -> anyhow::Result<()> {
        self.writer.flush().with_context(|| format!("writing {}", W::WHAT))
    }
}

impl Rows for SensorTrackWriter<Out> {
    type Sample = SensorTrack;
    const WHAT: &'static str = "sensor tracks";

    fn begin(out: Out, first_day_ns: i64) -> io::Result<Self> {
        Self::begin(out, first_day_ns)
    }

    fn resume(out: Out, first_day_ns: i64) -> Self {
        Self::resume(out, first_day_ns)
    }

    fn sequence(sample: &SensorTrack) -> u64 {
        sample.sequence
    }

    fn write(&mut self, number: u16, sample: &SensorTrack) -> io::Result<bool> {
        let source = number;
        Self::write(self, &SensorTrack { source, ..*sample }).map(|()| true)
    }

    fn flush(&mut self) -> io::Result<()> {
        Self::flush(self)
    }
}

impl Rows for DetectionWriter<Out> {
    type Sample = SensorDetection;
    const WHAT: &'static str = "detections";

    fn begin(out: Out, first_day_ns: i64) -> io::Result<Self> {
        Self::begin(out, first_day_ns)
    }

    fn resume(out: Out, first_day_ns: i64) -> Self {
        Self::resume(out, first_day_ns)
    }

    fn sequence(sample: &SensorDetection) -> u64 {
        sample.sequence
    }

    fn write(&mut self, number: u16, sample: &SensorDetection) -> io::Result<bool> {
        let source = number;
        // A kind that is not known is of another schema, whose slices are not taken.
        let detection = Detection::of_sample(&SensorDetection { source, ..*sample });
        detection.map_or(Ok(false), |detection| Self::write(self, &detection).map(|()| true))
    }

    fn flush(&mut self) -> io::Result<()> {
        Self::flush(self)
    }
}

impl Rows for WideAreaWriter<Out> {
    type Sample = WideArea;
    const WHAT: &'static str = "wide-area reports";

    fn begin(out: Out, first_day_ns: i64) -> io::Result<Self> {
        Self::begin(out, first_day_ns)
    }

    fn resume(out: Out, first_day_ns: i64) -> Self {
        Self::resume(out, first_day_ns)
    }

    fn sequence(sample: &WideArea) -> u64 {
        sample.sequence
    }

    fn write(&mut self, _: u16, sample: &WideArea) -> io::Result<bool> {
        let report = WideAreaReport::of_sample(sample);
        report.map_or(Ok(false), |report| Self::write(self, &report).map(|()| true))
    }

    fn flush(&mut self) -> io::Result<()> {
        Self::flush(self)
    }
}
