//! A recorded file as a queue of sensor tracks in the order of their times.
//!
//! Decoding runs ahead of replay by a few reports, so that the time of the next one is known: that is the source's
//! progress mark, and lets fusion go on during the source's silences.

use std::collections::VecDeque;

use formats::csv_table::CsvError;
use formats::reports::{Converter, Observation, Reorder, SourceModel};
use messages::{COUNTERS_MAX, Counter, SensorTrack};
use runtime::config::Recorded;

use crate::content::Content;

/// Reports that are decoded ahead: more than any slice holds.
pub(crate) const AHEAD: usize = 128;

/// A recording, decoded as it is asked for.
#[derive(Debug)]
pub struct Recording {
    content: Content,
    intake: Intake,
    ready: VecDeque<SensorTrack>,
    next_number: u64,
}

/// Takes what a recording holds, and puts it into the order of its times.
#[derive(Debug)]
pub(crate) struct Intake {
    source: u16,
    converter: Converter,
    reorder: Reorder,
    late: u64,
    tracks: u64,
}

impl Intake {
    /// A target report.
    pub(crate) fn observe(&mut self, observed: &Observation) {
        if let Some(report) = self.converter.convert(observed, 0)
            && !self.reorder.push(report)
        {
            self.late += 1;
        }
    }

    /// A record that speaks of the sensor.
    pub(crate) fn service(&mut self, time_of_day_ns: Option<i64>) {
        self.converter.service(time_of_day_ns);
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
    /// The recording in `bytes`, whose first report is of the day that begins at `first_day_ns` (UTC, nanoseconds).
    ///
    /// # Errors
    /// If it is to be a table of sensor tracks and its header is none of such a table.
    pub fn new(bytes: Vec<u8>, recorded: &Recorded, model: SourceModel, first_day_ns: i64) -> Result<Self, CsvError> {
        let mut recording = Self {
            content: Content::open(bytes, recorded, first_day_ns)?,
            intake: Intake {
                source: model.number,
                converter: Converter::new(model, first_day_ns),
                reorder: Reorder::new(recorded.reorder_ns),
                late: 0,
                tracks: 0,
            },
            ready: VecDeque::with_capacity(2 * AHEAD),
            next_number: 0,
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

    /// What has been counted so far, indexed by [`Counter`].
    pub fn counters(&self) -> [u64; COUNTERS_MAX] {
        let intake = &self.intake;
        let mut counters = *intake.converter.counters();
        self.content.count(&mut counters);
        counters[Counter::RejectedLate as usize] = intake.late;
        counters[Counter::Reports as usize] += intake.tracks;
        counters[Counter::Reports as usize] -= intake.late;
        counters
    }

    fn decode_ahead(&mut self) {
        while self.ready.len() < AHEAD && !self.content.is_exhausted() {
            self.content.read_piece(&mut self.intake);
            if self.content.is_exhausted() {
                self.intake.reorder.finish();
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
