//! Alarms as a reader of the topic knows them.

use messages::{Alarm, AlarmEvent, BatchHeader};

/// Age beyond which the latest slice says nothing any more, nanoseconds: two come every second.
const STALE_NS: i64 = 3_000_000_000;

/// What stands, by the latest slice.
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
    /// Takes a slice: it replaces the one before.
    pub fn hear(&mut self, header: &BatchHeader, slice: &[Alarm]) {
        // Of a monitor that was restarted, an earlier word may come late.
        if header.sent_ns >= self.said_ns {
            self.said_ns = header.sent_ns;
            self.standing.clear();
            let standing = slice.iter().filter(|alarm| alarm.event() != Some(AlarmEvent::Cleared));
            self.standing.extend(standing);
        }
    }

    /// Alarms that stand at `now_ns` (monotonic, nanoseconds); `None` if nobody has said so lately.
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
