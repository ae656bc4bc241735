//! Messages between processes that repeat what their publisher has stated already.
//!
//! Processes repeat their health and the origin of the system frame five times a second, so that readers notice a
//! process that is silent. A recording needs them when they change, and else at times: of a deployment without data,
//! repetitions are nearly all of the recording.

use std::collections::BTreeMap;

use messages::layout::Sample;
use messages::{BatchHeader, Counters, FrameOrigin, Health, ProcessKind, Registration};
use recording::REPEATED_NS;

/// Time after which nothing more is expected of a publisher, nanoseconds.
const FORGOTTEN_NS: i64 = 4 * REPEATED_NS;

/// Sample that its publisher repeats.
pub(crate) trait Repeated: Sample + Copy {
    /// Returns the sample without what differs in a repetition: times and numbers.
    fn content(self) -> Self {
        self
    }

    /// Time without a record after which a repetition is recorded, nanoseconds.
    fn recorded_after_ns(&self) -> i64 {
        REPEATED_NS
    }
}

impl Repeated for Health {
    /// Estimates move by a little without a report; the recorder's own counters move with each record.
    fn content(mut self) -> Self {
        (self.said_ns, self.registration) = (0, Registration::default());
        if self.kind() == Some(ProcessKind::Recorder) {
            self.counters = Counters::default();
        }
        self
    }

    /// Of the recorder itself every second message: a longer time without one is a time without a recorder.
    fn recorded_after_ns(&self) -> i64 {
        match self.kind() {
            Some(ProcessKind::Recorder) => 300_000_000,
            _ => REPEATED_NS,
        }
    }
}

impl Repeated for FrameOrigin {}

/// What the publishers of one topic stated last.
#[derive(Debug, Default)]
pub(crate) struct Repeats {
    latest: BTreeMap<u64, Latest>,
}

/// Latest recorded slice of a publisher.
#[derive(Debug)]
struct Latest {
    recorded_ns: i64,
    content: Vec<u8>,
}

impl Repeats {
    /// Whether a slice taken at `now_ns` (monotonic, nanoseconds) repeats the publisher's latest recorded slice, which
    /// is recent. Any other slice counts as recorded.
    pub(crate) fn has<T: Repeated>(&mut self, header: &BatchHeader, samples: &[T], now_ns: i64) -> bool {
        let content: Vec<T> = samples.iter().map(|sample| sample.content()).collect();
        let content = T::octets(&content);
        let after_ns = samples.first().map_or(REPEATED_NS, T::recorded_after_ns);
        let is_recent = |latest: &Latest, limit_ns| now_ns.saturating_sub(latest.recorded_ns) < limit_ns;
        let is_repeated = |latest: &Latest| is_recent(latest, after_ns) && latest.content == content;
        if self.latest.get(&header.incarnation).is_some_and(is_repeated) {
            return true;
        }
        self.latest.retain(|_, latest| is_recent(latest, FORGOTTEN_NS));
        let latest = Latest {
            recorded_ns: now_ns,
            content: content.to_vec(),
        };
        self.latest.insert(header.incarnation, latest);
        false
    }
}

#[cfg(test)]
mod tests {
    use messages::{Counter, LifeState};

    use super::*;

    const PERIOD_NS: i64 = 200_000_000;

    fn health(kind: ProcessKind, said_ns: i64, taken: u64) -> Health {
        let mut health = Health {
            said_ns,
            kind: kind as u8,
            life: LifeState::Running as u8,
            ..Health::default()
        };
        health.counters[Counter::Taken] = taken;
        health
    }

    fn of(incarnation: u64) -> BatchHeader {
        BatchHeader {
            incarnation,
            ..BatchHeader::default()
        }
    }

    #[test]
    fn what_changes_is_recorded_and_what_is_repeated_at_times() {
        let mut repeats = Repeats::default();
        // A minute; after half of it the process gets data for a second.
        let recorded = (0..300).filter(|turn| {
            let taken = (turn - 150).clamp(0, 5) as u64;
            let said = [health(ProcessKind::Adapter, turn * PERIOD_NS, taken)];
            !repeats.has(&of(1), &said, turn * PERIOD_NS)
        });
        let recorded: Vec<i64> = recorded.collect();
        assert_eq!(recorded[..7], [0, 25, 50, 75, 100, 125, 150]);
        assert_eq!(recorded[7..12], [151, 152, 153, 154, 155]);
        assert_eq!(recorded[12..], [180, 205, 230, 255, 280]);
    }

    #[test]
    fn each_publisher_has_its_own_repetitions_and_is_forgotten() {
        let mut repeats = Repeats::default();
        let said = [health(ProcessKind::Adapter, 0, 0)];
        assert!(!repeats.has(&of(1), &said, 0) && !repeats.has(&of(2), &said, 0));
        assert!(repeats.has(&of(1), &said, 1) && repeats.has(&of(2), &said, 1));
        assert!(
            !repeats.has(&of(1), &[said[0], said[0]], 2),
            "another number of samples"
        );
        for publisher in 3..1000 {
            repeats.has(&of(publisher), &said, publisher as i64 * REPEATED_NS);
        }
        assert!(repeats.latest.len() < 10);
    }

    #[test]
    fn the_recorders_own_health_shows_that_it_runs() {
        let mut repeats = Repeats::default();
        let said = |turn| [health(ProcessKind::Recorder, turn * PERIOD_NS, turn as u64)];
        let recorded = (0..10).filter(|turn| !repeats.has(&of(1), &said(*turn), turn * PERIOD_NS));
        assert_eq!(recorded.collect::<Vec<_>>(), [0, 2, 4, 6, 8]);
    }
}
