//! Recorded file as a queue of sensor tracks in the order of time.
//!
//! Decoding is several reports ahead of the replay, so that the time of the next report is known. This time is the
//! source's watermark, and lets fusion continue during the source's silences.

use std::collections::VecDeque;

use anyhow::Context as _;
use deployment::{Recorded, Source};
use messages::{Counters, ProcessKind, SensorDetection, SensorTrack, Stream, StreamId, TargetStatement};
use runtime::Process;
use sources::{Pipeline, SourceReading};
use tracking::wide_area::arrivals::Arrivals;

use crate::Processed;
use crate::beside::Beside;
use crate::content::RecordedContent;
use crate::feed::StatedReceiver;
use crate::finder::finder_reports;
use crate::intake::Intake;
use crate::replay::{Published, ReplayAgent, Replayed};
use crate::wide_area::recorded;

/// Number of reports decoded ahead: more than a slice.
pub(crate) const AHEAD: usize = 128;

/// Recording, decoded on demand.
#[derive(Debug)]
pub struct RecordedSource {
    content: RecordedContent,
    intake: Intake,
    ready: VecDeque<SensorTrack>,
    next_number: u64,
    detections: Beside<SensorDetection>,
    statements: Beside<TargetStatement>,
}

/// Creates the agent that replays a recorded source.
///
/// # Errors
/// If the recording cannot be read, or shared memory fails.
pub(crate) fn replay(
    process: &Process,
    processed: Processed<'_>,
    recorded: &Recorded,
) -> anyhow::Result<ReplayAgent<RecordedSource>> {
    let source = processed.source;
    let path = process.options.data.join(&recorded.file);
    let bytes = std::fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
    let first_day_ns = process.first_day_ns();
    let recording = RecordedSource::supported(
        bytes,
        recorded,
        (source, processed.reading()),
        first_day_ns,
        counts(process, processed)?,
    );
    let (number, sensor_uid) = (source.number, Some(source.uid));
    let tracks = Published {
        topic: &messages::sensor_tracks(&source.name),
        stream: StreamId {
            stream: Stream::SensorTracks,
            number,
        },
        sensor_uid,
    };
    assert!(
        tracks.topic.capacity.slice_len < AHEAD,
        "the next report's time must be known"
    );
    let detections = Published {
        topic: &messages::sensor_detections(&source.name),
        stream: StreamId {
            stream: Stream::Detections,
            number,
        },
        sensor_uid,
    };
    let detections = source.has_detections().then(|| detections.open(process, &[]));
    let statements = Published {
        topic: &messages::target_statements(&source.name),
        stream: StreamId {
            stream: Stream::Statements,
            number,
        },
        sensor_uid,
    };
    let statements = source.has_statements.then(|| statements.open(process, &[]));
    ReplayAgent::new(
        process,
        recording.with_context(|| path.display().to_string())?,
        tracks.open(process, &[ProcessKind::Fusion])?,
        detections.transpose()?,
        statements.transpose()?,
    )
}

/// Reports of the wide-area sensors of the source's tracker: read from the recordings and not from their topics, so
/// that the tracks do not depend on the speed of other processes.
pub(crate) fn counts(process: &Process, Processed { source, readings }: Processed<'_>) -> anyhow::Result<Arrivals> {
    let mut reports = Vec::new();
    for number in &source.links.wide_area_sensors {
        let sensor = &process.config.wide_area_sensors[usize::from(*number)];
        reports.extend(recorded::read((sensor, readings), &process.options.data, process.first_day_ns())?.reports);
    }
    Ok(Arrivals::of(reports))
}

impl RecordedSource {
    /// Creates the recording in `bytes` of `source`, with the first report on the day that begins at `first_day_ns`
    /// (UTC, nanoseconds).
    ///
    /// # Errors
    /// If the file is configured as a table and the header is not the header of a table of sensor tracks.
    pub fn new(
        bytes: Vec<u8>,
        recorded: &Recorded,
        processed: (&Source, &SourceReading),
        first_day_ns: i64,
    ) -> anyhow::Result<Self> {
        Self::supported(bytes, recorded, processed, first_day_ns, Arrivals::default())
    }

    /// Creates the recording as [`Self::new`] does, with the `counts` of the wide-area sensors of the source's
    /// tracker.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn supported(
        bytes: Vec<u8>,
        recorded: &Recorded,
        (source, reading): (&Source, &SourceReading),
        first_day_ns: i64,
        counts: Arrivals,
    ) -> anyhow::Result<Self> {
        let pipeline = Pipeline::new(reading.model, &reading.processing, first_day_ns, counts)?;
        let place = (reading.model.system, StatedReceiver::of(source, reading));
        let mut recording = Self {
            content: RecordedContent::open(bytes, recorded, place, first_day_ns)?
                .with_finder(finder_reports(source, reading)),
            intake: Intake::new(source.number, pipeline, recorded.reorder_ns),
            ready: VecDeque::with_capacity(2 * AHEAD),
            next_number: 0,
            detections: Beside::default(),
            statements: Beside::default(),
        };
        recording.decode_ahead();
        Ok(recording)
    }

    /// Returns the counts so far.
    pub fn counters(&self) -> Counters {
        let mut counters = self.intake.counters();
        self.content.count(&mut counters);
        counters
    }

    fn decode_ahead(&mut self) {
        while self.ready.len() < AHEAD && !self.content.is_exhausted() {
            self.content.read_piece(&mut self.intake);
            if self.content.is_exhausted() {
                self.intake.end();
            }
            for detection in self.intake.detections() {
                self.detections.push(detection.time_of_measurement_ns, detection);
            }
            for (due_ns, stated) in self.intake.statements() {
                self.statements.push(due_ns, stated);
            }
            while let Some(mut report) = self.intake.pop() {
                report.sequence = self.next_number;
                self.next_number += 1;
                self.ready.push_back(report);
            }
        }
    }
}

impl Replayed for RecordedSource {
    type Sample = SensorTrack;
    const WAITS_FOR: &'static str = "fusion and recorder";

    fn due_ns(&self, ahead: usize) -> Option<i64> {
        self.ready.get(ahead).map(|report| report.time_of_measurement_ns)
    }

    fn ahead(&self) -> usize {
        self.ready.len()
    }

    fn next(&mut self) -> Option<(u64, SensorTrack)> {
        Iterator::next(self).map(|report| (report.sequence, report))
    }

    fn skip_to(&mut self, first_needed: u64) {
        while self.ready.front().is_some_and(|report| report.sequence < first_needed) {
            Iterator::next(self);
        }
    }

    fn detections(&mut self) -> Option<&mut Beside<SensorDetection>> {
        Some(&mut self.detections)
    }

    fn statements(&mut self) -> Option<&mut Beside<TargetStatement>> {
        Some(&mut self.statements)
    }

    fn counters(&self) -> Counters {
        self.counters()
    }
}

impl Iterator for RecordedSource {
    type Item = SensorTrack;

    fn next(&mut self) -> Option<SensorTrack> {
        let report = self.ready.pop_front()?;
        self.decode_ahead();
        Some(report)
    }
}
