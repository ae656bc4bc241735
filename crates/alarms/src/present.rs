//! Standing alarms as received by a reader of the topic.

use messages::{Alarm, AlarmEvent, BatchHeader};

/// Age at which the latest slice becomes invalid, nanoseconds: two slices arrive every second.
const STALE_NS: i64 = 3_000_000_000;

/// Standing alarms in the latest slice.
#[derive(Clone, Debug)]
pub struct Present {
    said_ns: i64,
    standing: Vec<Alarm>,
}

impl Default for Present {
    fn default() -> Self {
        Self {
            said_ns: i64::MIN,
            standing: Vec::new(),
        }
    }
}

impl Present {
    /// Receives a slice, which replaces the previous slice.
    pub fn hear(&mut self, header: &BatchHeader, slice: &[Alarm]) {
        // After a restart of the monitor, an earlier slice may arrive late.
        if header.sent_ns >= self.said_ns {
            self.said_ns = header.sent_ns;
            self.standing.clear();
            let standing = slice.iter().filter(|alarm| alarm.event() != Some(AlarmEvent::Cleared));
            self.standing.extend(standing);
        }
    }

    /// Returns the alarms standing at `now_ns` (monotonic, nanoseconds); `None` without a recent slice.
    pub fn at(&self, now_ns: i64) -> Option<&[Alarm]> {
        (now_ns <= self.said_ns.saturating_add(STALE_NS)).then_some(&self.standing[..])
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    #[test]
    fn the_latest_slice_holds_and_only_for_a_while() {
        let mut present = Present::default();
        assert_eq!(present.at(0), None, "nothing was heard");
        let header = |sent_ns| BatchHeader {
            sent_ns,
            ..BatchHeader::default()
        };
        let alarm = |code, event: AlarmEvent| Alarm {
            code,
            event: event.code(),
            ..Alarm::default()
        };
        let slice = [alarm(1, AlarmEvent::Raised), alarm(2, AlarmEvent::Cleared)];
        present.hear(&header(10 * S), &slice);
        present.hear(&header(9 * S), &[]);
        assert_eq!(present.at(10 * S), Some(&slice[..1]));
        assert_eq!(present.at(14 * S), None, "the monitor says nothing any more");
        present.hear(&header(14 * S), &[]);
        assert_eq!(present.at(14 * S), Some(&[][..]));
    }
}
