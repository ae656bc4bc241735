//! A recorded file as a queue of sensor tracks in the order of their times.
//!
//! Decoding runs ahead of replay by a few reports, so that the time of the next one is known: that is the source's
//! progress mark, and lets fusion go on during the source's silences.

use std::collections::VecDeque;

use formats::asterix::{Decoder, Mode, blocks};
use formats::reports::observation::{self, Reading};
use formats::reports::{Converter, Reorder, SourceModel};
use messages::{COUNTERS_MAX, Counter, SensorTrack};
use runtime::config::Recorded;

/// Reports that are decoded ahead: more than any slice holds.
pub(crate) const AHEAD: usize = 128;

/// A recording, decoded as it is asked for.
#[derive(Debug)]
pub struct Recording {
    bytes: Vec<u8>,
    offset: usize,
    decoder: Decoder,
    converter: Converter,
    reorder: Reorder,
    ready: VecDeque<SensorTrack>,
    late: u64,
    next_number: u64,
}

impl Recording {
    /// The recording in `bytes`, whose first report is of the day that begins at `first_day_ns` (UTC, nanoseconds).
    pub fn new(bytes: Vec<u8>, recorded: &Recorded, model: SourceModel, first_day_ns: i64) -> Self {
        let decoder = recorded
            .tables
            .iter()
            .fold(Decoder::new(Mode::Lenient), |decoder, table| decoder.with_table(table));
        let mut recording = Self {
            bytes,
            offset: 0,
            decoder,
            converter: Converter::new(model, first_day_ns),
            reorder: Reorder::new(recorded.reorder_ns),
            ready: VecDeque::with_capacity(2 * AHEAD),
            late: 0,
            next_number: 0,
        };
        recording.decode_ahead();
        recording
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
        let (mut counters, decoded) = (*self.converter.counters(), self.decoder.counts());
        counters[Counter::Records as usize] = decoded.records;
        counters[Counter::BytesRefused as usize] = decoded.octets_skipped;
        counters[Counter::BlocksRefused as usize] =
            decoded.blocks_refused + decoded.blocks_cut + decoded.blocks_without_table;
        counters[Counter::RejectedLate as usize] = self.late;
        counters[Counter::Reports as usize] -= self.late;
        counters
    }

    fn decode_ahead(&mut self) {
        while self.ready.len() < AHEAD && self.offset < self.bytes.len() {
            self.decode_block();
            if self.offset == self.bytes.len() {
                self.reorder.finish();
            }
            while let Some(mut report) = self.reorder.pop() {
                report.sequence = self.next_number;
                self.next_number += 1;
                self.ready.push_back(report);
            }
        }
    }

    fn decode_block(&mut self) {
        let rest = &self.bytes[self.offset..];
        // What is no block ends the file; the decoder counts its bytes.
        let length = blocks(rest)
            .next()
            .and_then(Result::ok)
            .map_or(rest.len(), |block| block.bytes.len());
        for record in self.decoder.records(&rest[..length]).flatten() {
            match observation::read(&record) {
                Reading::Target(observed) => {
                    if let Some(report) = self.converter.convert(&observed, 0)
                        && !self.reorder.push(report)
                    {
                        self.late += 1;
                    }
                }
                Reading::Service(time_of_day_ns) => self.converter.service(time_of_day_ns),
                Reading::Other => {}
            }
        }
        self.offset += length;
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
