//! Another system's tracks in ASTERIX (CAT062), counted by place.
//!
//! Each track goes through the checks that a source's tracks do. Tentative ones and those that have ended are not counted:
//! the one may be none, the other is none any more. The rest is [`tracking::wide_area::counting`].
//!
//! Live, a track has arrived when its datagram did. In a recording nobody knows when that was: there it arrives when it
//! was measured.

use formats::asterix::{Decoder, blocks};
use formats::reports::Converter;
use formats::reports::observation::{self, Reading};
use messages::{COUNTERS_MAX, Counter, TrackState};
use runtime::config::CountedTracks;
use tracking::wide_area::WideAreaReport;
use tracking::wide_area::counting::{CountedTrack, Counting};

/// See the module's documentation.
#[derive(Debug)]
pub(super) struct Tracks {
    period_ns: i64,
    decoder: Decoder,
    converter: Converter,
    counting: Counting,
    /// Arrival of the latest track, UTC, nanoseconds.
    arrived_ns: Option<i64>,
    blocks_refused: u64,
    octets_refused: u64,
}

impl Tracks {
    /// The first track is of the day that begins at `first_day_ns` (UTC, nanoseconds).
    pub(super) fn new(settings: &CountedTracks, first_day_ns: i64) -> Self {
        Self {
            period_ns: settings.period_ns,
            decoder: settings.asterix.decoder(),
            converter: Converter::new(settings.model, first_day_ns),
            counting: Counting::new(settings.period_ns, settings.group_m),
            arrived_ns: None,
            blocks_refused: 0,
            octets_refused: 0,
        }
    }

    /// Takes the data blocks of a datagram, received at `received_ns` (UTC, nanoseconds); `None` in a recording.
    pub(super) fn take(&mut self, bytes: &[u8], received_ns: Option<i64>, reports: &mut Vec<WideAreaReport>) {
        if let Some(received_ns) = received_ns {
            self.silent(received_ns, reports);
            self.converter.received(received_ns);
        }
        for block in blocks(bytes) {
            let block = match block {
                Ok(block) => block,
                Err(error) => {
                    self.blocks_refused += 1;
                    self.octets_refused += (bytes.len() - error.offset()) as u64;
                    return;
                }
            };
            for record in self.decoder.records(block.bytes).flatten() {
                let Reading::Target(observed) = observation::read(&record) else {
                    continue;
                };
                let Some(track) = self.converter.convert(&observed, 0) else {
                    continue;
                };
                let state = TrackState::from_code(track.state);
                if !matches!(state, Some(TrackState::Confirmed | TrackState::Coasted)) {
                    continue;
                }
                let arrival_ns = received_ns.unwrap_or(track.time_of_measurement_ns);
                self.arrived_ns = self.arrived_ns.max(Some(arrival_ns));
                let counted = CountedTrack {
                    number: track.track_number,
                    time_ns: track.time_of_measurement_ns,
                    position_m: track.position_m,
                    velocity_mps: track.velocity_mps,
                };
                self.counting.take(counted, arrival_ns, reports);
            }
        }
    }

    /// Time has come to `now_ns` (UTC, nanoseconds): a picture that nothing has followed for a period is complete.
    pub(super) fn silent(&mut self, now_ns: i64, reports: &mut Vec<WideAreaReport>) {
        let until_ns = self
            .arrived_ns
            .map(|arrived_ns| arrived_ns.saturating_add(self.period_ns));
        if let Some(until_ns) = until_ns.filter(|until_ns| *until_ns <= now_ns) {
            self.counting.complete(until_ns, reports);
            self.arrived_ns = None;
        }
    }

    /// Nothing follows.
    pub(super) fn end(&mut self, reports: &mut Vec<WideAreaReport>) {
        if let Some(arrived_ns) = self.arrived_ns.take() {
            self.counting.complete(arrived_ns, reports);
        }
    }

    pub(super) fn count(&self, counters: &mut [u64; COUNTERS_MAX]) {
        for (counter, counted) in counters.iter_mut().zip(self.converter.counters()) {
            *counter += counted;
        }
        let (decoded, counts) = (self.decoder.counts(), self.counting.counts());
        for (counter, count) in [
            (Counter::Records, decoded.records),
            (Counter::BytesRefused, decoded.octets_skipped + self.octets_refused),
            (
                Counter::BlocksRefused,
                decoded.blocks_refused + decoded.blocks_cut + decoded.blocks_without_table + self.blocks_refused,
            ),
            (Counter::RejectedLate, counts.late),
            (Counter::RefusedTracks, counts.crowded_out),
        ] {
            counters[counter as usize] += count;
        }
    }
}
