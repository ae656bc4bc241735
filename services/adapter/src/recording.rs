//! A recorded file as a queue of sensor tracks in the order of their times.
//!
//! Decoding runs ahead of replay by a few reports, so that the time of the next one is known: that is the source's
//! progress mark, and lets fusion go on during the source's silences.

use std::collections::VecDeque;

use configuration::{Recorded, Source};
use messages::{Counter, Counters, SensorDetection, SensorTrack};
use observations::{Observation, Service};
use reception::Reorder;
use sources::{Pipeline, Samples};
use tracking::wide_area::arrivals::Arrivals;

use crate::content::Content;
use crate::processing;

/// Reports that are decoded ahead: more than any slice holds.
pub(crate) const AHEAD: usize = 128;

/// A recording, decoded as it is asked for.
#[derive(Debug)]
pub struct Recording {
    content: Content,
    intake: Intake,
    ready: VecDeque<SensorTrack>,
    next_number: u64,
    /// Detections of which tracks were made, numbered by their place in the recording.
    detections: VecDeque<SensorDetection>,
    next_detection: u64,
}

/// Takes what a recording holds, and puts it into the order of its times.
#[derive(Debug)]
pub(crate) struct Intake {
    source: u16,
    pipeline: Pipeline,
    samples: Samples,
    reorder: Reorder,
    late: u64,
    tracks: u64,
}

impl Intake {
    /// A target report.
    pub(crate) fn observe(&mut self, observed: &Observation) {
        self.pipeline.take(observed, 0, &mut self.samples);
        self.put_in_order();
    }

    /// A record that speaks of the sensor.
    pub(crate) fn service(&mut self, service: &Service) {
        self.pipeline.service(service, 0, &mut self.samples);
        self.put_in_order();
    }

    /// Nothing follows.
    fn end(&mut self) {
        self.pipeline.end(&mut self.samples);
        self.put_in_order();
        self.reorder.finish();
    }

    fn put_in_order(&mut self) {
        for track in self.samples.tracks.drain(..) {
            if !self.reorder.push(track) {
                self.late += 1;
            }
        }
    }

    /// A sensor track, ready made.
    pub(crate) fn track(&mut self, track: SensorTrack) {
        self.tracks += 1;
        let report = SensorTrack {
            source: self.source,
            ..track
        };
        if !self.reorder.push(report) {
            self.late += 1;
        }
    }
}

impl Recording {
    /// The recording in `bytes` of `source`, whose first report is of the day that begins at `first_day_ns` (UTC,
    /// nanoseconds).
    ///
    /// # Errors
    /// If it is to be a table of sensor tracks and its header is none of such a table.
    pub fn new(bytes: Vec<u8>, recorded: &Recorded, source: &Source, first_day_ns: i64) -> anyhow::Result<Self> {
        Self::supported(bytes, recorded, source, first_day_ns, Arrivals::default())
    }

    /// As [`Self::new`], for a source whose tracker listens to wide-area sensors: these are their `counts`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn supported(
        bytes: Vec<u8>,
        recorded: &Recorded,
        source: &Source,
        first_day_ns: i64,
        counts: Arrivals,
    ) -> anyhow::Result<Self> {
        let mut recording = Self {
            content: Content::open(bytes, recorded, first_day_ns)?,
            intake: Intake {
                source: source.number,
                pipeline: Pipeline::new(source.model, &processing(source), first_day_ns, counts)?,
                samples: Samples::default(),
                reorder: Reorder::new(recorded.reorder_ns),
                late: 0,
                tracks: 0,
            },
            ready: VecDeque::with_capacity(2 * AHEAD),
            next_number: 0,
            detections: VecDeque::new(),
            next_detection: 0,
        };
        recording.decode_ahead();
        Ok(recording)
    }

    /// The next report without taking it; `None` at the end.
    pub fn peek(&self) -> Option<&SensorTrack> {
        self.ready.front()
    }

    /// The report `ahead` places after the next.
    pub fn peek_nth(&self, ahead: usize) -> Option<&SensorTrack> {
        self.ready.get(ahead)
    }

    /// The next detection without taking it: of those that the tracks decoded so far were made of.
    pub(crate) fn peek_detection(&self) -> Option<&SensorDetection> {
        self.detections.front()
    }

    /// The next detection.
    pub(crate) fn next_detection(&mut self) -> Option<SensorDetection> {
        self.detections.pop_front()
    }

    /// What has been counted so far, indexed by [`Counter`].
    pub fn counters(&self) -> Counters {
        let intake = &self.intake;
        let mut counters = intake.pipeline.counters();
        self.content.count(&mut counters);
        counters[Counter::RejectedLate] += intake.late;
        counters[Counter::Reports] += intake.tracks;
        counters[Counter::Reports] -= intake.late;
        counters
    }

    fn decode_ahead(&mut self) {
        while self.ready.len() < AHEAD && !self.content.is_exhausted() {
            self.content.read_piece(&mut self.intake);
            if self.content.is_exhausted() {
                self.intake.end();
            }
            for mut detection in self.intake.samples.detections.drain(..) {
                detection.sequence = self.next_detection;
                self.next_detection += 1;
                self.detections.push_back(detection);
            }
            while let Some(mut report) = self.intake.reorder.pop() {
                report.sequence = self.next_number;
                self.next_number += 1;
                self.ready.push_back(report);
            }
        }
    }
}

impl Iterator for Recording {
    type Item = SensorTrack;

    fn next(&mut self) -> Option<SensorTrack> {
        let report = self.ready.pop_front()?;
        self.decode_ahead();
        Some(report)
    }
}
