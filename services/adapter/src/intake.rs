//! Data of a recording through the source's pipeline, in the order of time.

use formats::feed::Transmission;
use messages::{Counter, Counters, SensorDetection, SensorTrack, StageTimes, TargetStatement};
use observations::{EmitterMeasurement, Observation, ServiceMessage, Statement};
use sources::{Pipeline, Reorder, Samples};

use crate::statements::StatementBook;

/// Receiver of a recording's contents.
#[derive(Debug)]
pub(crate) struct Intake {
    source: u16,
    pipeline: Pipeline,
    samples: Samples,
    reorder: Reorder<SensorTrack>,
    book: StatementBook,
    /// Statements, each with the time at which it is due, UTC, nanoseconds.
    stated: Vec<(i64, TargetStatement)>,
    /// Latest time of a transmission in the recording, UTC, nanoseconds.
    heard_ns: i64,
    late: u64,
    tracks: u64,
}

impl Intake {
    /// Creates the intake of source `source`, whose reports are at most `reorder_ns` (nanoseconds) out of order.
    pub(crate) fn new(source: u16, pipeline: Pipeline, reorder_ns: i64) -> Self {
        Self {
            source,
            pipeline,
            samples: Samples::default(),
            reorder: Reorder::new(reorder_ns),
            book: StatementBook::default(),
            stated: Vec::new(),
            heard_ns: i64::MIN,
            late: 0,
            tracks: 0,
        }
    }

    /// Takes a target report.
    pub(crate) fn observe(&mut self, observed: &Observation) {
        self.pipeline.take(observed, 0, &mut self.samples);
        self.put_in_order();
    }

    /// Takes a target report of a feed.
    pub(crate) fn heard(&mut self, transmission: Transmission, observed: &Observation) {
        self.go_on(transmission);
        if let Some(number) = observed.track_number {
            self.book.alive(number, self.heard_ns);
        }
        self.observe(observed);
    }

    /// Takes what a target of a feed, or a station that is none, states beside motion.
    pub(crate) fn state(&mut self, transmission: Transmission, stated: &Statement) {
        self.go_on(transmission);
        if let Some(whole) = self.book.take(stated, self.heard_ns) {
            self.gather(&whole, self.heard_ns);
        }
    }

    /// States again what is due at the time of a transmission: a replay gives what the live feed gave.
    fn go_on(&mut self, transmission: Transmission) {
        self.heard_ns = self.heard_ns.max(transmission.utc_ns);
        for (whole, heard_ns) in self.book.due(self.heard_ns) {
            self.gather(&whole, heard_ns);
        }
    }

    fn gather(&mut self, whole: &Statement, heard_ns: i64) {
        let sample = whole.sample(self.source, heard_ns, StageTimes::default());
        self.stated.push((self.heard_ns, sample));
    }

    /// Takes a measurement of an emitter.
    pub(crate) fn emitter(&mut self, measured: &EmitterMeasurement) {
        self.pipeline.emitter(measured, 0, &mut self.samples);
        // A recording publishes the tracks.
        self.samples.bearings.clear();
        self.samples.platforms.clear();
        self.samples.fixes.clear();
        self.put_in_order();
    }

    /// Takes a record about the sensor.
    pub(crate) fn service(&mut self, service: &ServiceMessage) {
        self.pipeline.service(service, 0, &mut self.samples);
        self.put_in_order();
    }

    /// Takes a finished sensor track.
    pub(crate) fn track(&mut self, track: SensorTrack) {
        self.tracks += 1;
        self.samples.tracks.push(SensorTrack {
            source: self.source,
            ..track
        });
        self.put_in_order();
    }

    /// Processes waiting data at the end of the recording.
    pub(crate) fn end(&mut self) {
        self.pipeline.end(&mut self.samples);
        self.put_in_order();
        self.reorder.finish();
    }

    /// Returns the detections of tracks since the last call.
    pub(crate) fn detections(&mut self) -> impl Iterator<Item = SensorDetection> + '_ {
        self.samples.detections.drain(..)
    }

    /// Returns what targets have stated since the last call, each statement with the time at which it is due.
    pub(crate) fn statements(&mut self) -> impl Iterator<Item = (i64, TargetStatement)> + '_ {
        self.stated.drain(..)
    }

    /// Returns the next track in the order of times, if no earlier track can follow.
    pub(crate) fn pop(&mut self) -> Option<SensorTrack> {
        self.reorder.pop()
    }

    /// Returns the counts so far.
    pub(crate) fn counters(&self) -> Counters {
        let mut counters = self.pipeline.counters();
        counters[Counter::RejectedLate] += self.late;
        counters[Counter::TracksDropped] += self.book.refused();
        counters[Counter::Reports] += self.tracks;
        counters[Counter::Reports] -= self.late;
        counters
    }

    fn put_in_order(&mut self) {
        for track in self.samples.tracks.drain(..) {
            self.late += u64::from(!self.reorder.push(track.time_of_measurement_ns, 0, track));
        }
    }
}
