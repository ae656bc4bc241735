//! Data of a recording through the source's pipeline, in the order of time.

use messages::{Counter, Counters, SensorDetection, SensorTrack};
use observations::{Observation, ServiceMessage};
use sources::{Pipeline, Reorder, Samples};

/// Receiver of a recording's contents.
#[derive(Debug)]
pub(crate) struct Intake {
    source: u16,
    pipeline: Pipeline,
    samples: Samples,
    reorder: Reorder<SensorTrack>,
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
            late: 0,
            tracks: 0,
        }
    }

    /// Takes a target report.
    pub(crate) fn observe(&mut self, observed: &Observation) {
        self.pipeline.take(observed, 0, &mut self.samples);
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

    /// Returns the next track in the order of times, if no earlier track can follow.
    pub(crate) fn pop(&mut self) -> Option<SensorTrack> {
        self.reorder.pop()
    }

    /// Returns the counts so far.
    pub(crate) fn counters(&self) -> Counters {
        let mut counters = self.pipeline.counters();
        counters[Counter::RejectedLate] += self.late;
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
