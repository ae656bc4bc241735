//! Another system's tracks in ASTERIX (CAT062), counted by place.
//!
//! Each track passes the checks of a source's tracks. Tentative and terminated tracks are not counted.
//! [`tracking::wide_area::counting`] does the rest.
//!
//! Live, a track arrives with the datagram. A recording does not contain this time; there a track arrives at the time
//! of measurement.

use asterix::{Block, Decoder, Error, StatedTables};
use deployment::CountedTracks;
use formats::observation::{self, Reading};
use messages::{Counter, Counters, TrackState};
use reception::{ConversionModel, Converter};
use tracking::wide_area::WideAreaReport;
use tracking::wide_area::counting::{CountedTrack, TrackCounter};

use crate::counted::decoded;

/// Counter of another system's tracks.
#[derive(Debug)]
pub(super) struct OtherSystemTracks {
    period_ns: i64,
    decoder: Decoder,
    converter: Converter,
    counting: TrackCounter,
    /// Arrival of the latest track, UTC, nanoseconds.
    arrived_ns: Option<i64>,
    blocks_rejected: u64,
    bytes_rejected: u64,
}

impl OtherSystemTracks {
    /// The first track is of the day that begins at `first_day_ns` (UTC, nanoseconds).
    pub(super) fn new(settings: &CountedTracks, model: ConversionModel, first_day_ns: i64) -> Self {
        Self {
            period_ns: settings.period_ns,
            decoder: StatedTables::new(&settings.asterix.editions, settings.asterix.is_strict).decoder(),
            converter: Converter::new(model, first_day_ns),
            counting: TrackCounter::new(settings.period_ns, settings.group_m),
            arrived_ns: None,
            blocks_rejected: 0,
            bytes_rejected: 0,
        }
    }

    /// Takes the data blocks found in `length` bytes, received at `received_ns` (UTC, nanoseconds); `None` in a
    /// recording.
    pub(super) fn take<'a>(
        &mut self,
        blocks: impl IntoIterator<Item = Result<Block<'a>, Error>>,
        length: usize,
        received_ns: Option<i64>,
        reports: &mut Vec<WideAreaReport>,
    ) {
        if let Some(received_ns) = received_ns {
            self.silent(received_ns, reports);
            self.converter.received(received_ns, received_ns);
        }
        for block in blocks {
            let block = match block {
                Ok(block) => block,
                Err(error) => {
                    self.blocks_rejected += 1;
                    self.bytes_rejected += (length - error.offset()) as u64;
                    return;
                }
            };
            for record in self.decoder.block_records(block).flatten() {
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

    pub(super) fn count(&self, counters: &mut Counters) {
        *counters += self.converter.counters();
        *counters += &decoded(self.decoder.counts());
        let counts = self.counting.counts();
        for (counter, count) in [
            (Counter::BytesRejected, self.bytes_rejected),
            (Counter::BlocksRejected, self.blocks_rejected),
            (Counter::RejectedLate, counts.late),
            (Counter::TracksDropped, counts.crowded_out),
        ] {
            counters[counter] += count;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use asterix::registry;
    use configuration::Config;
    use deployment::WideAreaInput;
    use messages::SystemTrack;
    use outgoing::SystemReports;
    use proptest::prelude::*;

    use super::*;
    use test_support::S;

    const SITE: &str = "name = \"t\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n[[receiver]]\nname = \"lan\"\n\
                        [receiver.udp]\nlisten = \"127.0.0.1:8600\"\n[[receiver]]\nname = \"link\"\n[receiver.udp]\n\
                        listen = \"127.0.0.1:8601\"\n[[source]]\nname = \"radar\"\n[source.live]\nreceiver = \"lan\"\n\
                        [[wide_area_sensor]]\nname = \"centre\"\n[wide_area_sensor.tracks]\nreceiver = \"link\"\nperiod_s = 2.0\n";
    /// Noon of some day.
    const NOON_NS: i64 = 20_000 * 86_400 * S + 43_200 * S;

    fn tracks() -> (OtherSystemTracks, SystemReports) {
        let config = Config::parse(Path::new("t.toml"), SITE, &[]).unwrap();
        let WideAreaInput::Tracks(settings) = &config.wide_area_sensors[0].input else {
            panic!("{config:?}");
        };
        let table = registry::default_edition(62).unwrap();
        let sender = SystemReports::new(table, 1, 1, config.frame, &[], 1400).unwrap();
        (
            OtherSystemTracks::new(settings, config.readings.counted[0].unwrap(), 0),
            sender.with_tentative(),
        )
    }

    /// Three tracks near each other at a time: confirmed, coasted, and a third.
    fn block(sender: &mut SystemReports, time_ns: i64, third: TrackState) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (number, state) in (1..).zip([TrackState::Confirmed, TrackState::Coasted, third]) {
            let track = SystemTrack {
                reference_time_ns: time_ns,
                time_of_measurement_ns: time_ns,
                track_number: number,
                position_m: [10e3 + 100.0 * f64::from(number), 5e3, 1000.0],
                velocity_mps: [50.0, 0.0, 0.0],
                state: state as u8,
                ..SystemTrack::default()
            };
            sender.report(&track, &mut |block| bytes.extend_from_slice(block));
        }
        sender.flush(&mut |block| bytes.extend_from_slice(block));
        bytes
    }

    #[test]
    fn tentative_and_ended_tracks_do_not_count_and_silence_completes_a_picture() {
        for third in [TrackState::Tentative, TrackState::Terminated] {
            let ((mut tracks, mut sender), mut reports) = (tracks(), Vec::new());
            let bytes = block(&mut sender, NOON_NS, third);
            tracks.take(
                asterix::blocks(&bytes),
                bytes.len(),
                Some(NOON_NS + S / 4),
                &mut reports,
            );
            tracks.silent(NOON_NS + 2 * S, &mut reports);
            assert_eq!(reports, []);
            tracks.silent(NOON_NS + 3 * S, &mut reports);
            let [report] = &reports[..] else { panic!("{reports:?}") };
            assert_eq!((report.targets, report.arrival_ns), (2, NOON_NS + 2 * S + S / 4));
            assert!((report.position_m[0] - 10_150.0).abs() < 20.0, "{report:?}");
        }
    }

    #[test]
    fn a_recording_arrives_when_it_was_measured() {
        let ((mut tracks, mut sender), mut reports) = (tracks(), Vec::new());
        for second in [0, 2, 4] {
            let bytes = block(&mut sender, 43_200 * S + second * S, TrackState::Confirmed);
            tracks.take(asterix::blocks(&bytes), bytes.len(), None, &mut reports);
        }
        tracks.end(&mut reports);
        let found: Vec<(u32, i64)> = reports
            .iter()
            .map(|report| (report.targets, report.arrival_ns / S))
            .collect();
        assert_eq!(found, [(3, 43_202), (3, 43_204), (3, 43_204)]);
    }

    proptest! {
        #[test]
        fn whatever_comes_is_read_or_counted(
            changes in prop::collection::vec((0..200usize, any::<u8>()), 0..6),
            noise in prop::collection::vec(any::<u8>(), 0..100),
        ) {
            let ((mut tracks, mut sender), mut reports) = (tracks(), Vec::new());
            let mut bytes = block(&mut sender, NOON_NS, TrackState::Confirmed);
            for (place, octet) in changes {
                let place = place % bytes.len();
                bytes[place] = octet;
            }
            tracks.take(asterix::blocks(&bytes), bytes.len(), Some(NOON_NS), &mut reports);
            tracks.take(asterix::blocks(&noise), noise.len(), Some(NOON_NS + S), &mut reports);
            tracks.end(&mut reports);
            let mut counters = Counters::default();
            tracks.count(&mut counters);
            let counted: u32 = reports.iter().map(|report| report.targets).sum();
            prop_assert!(u64::from(counted) <= counters[Counter::Records]);
            let refused = counters[Counter::BlocksRejected];
            prop_assert!(noise.is_empty() || refused > 0 || counters[Counter::Records] > 0);
            for report in &reports {
                prop_assert!(tracking::wide_area::fault_in(report).is_none(), "{report:?}");
            }
        }
    }
}
