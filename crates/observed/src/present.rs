//! Standing alarms as received by a reader of the topic, and their texts.

use alarms::AlarmKind;
use messages::{Alarm, AlarmEvent, AlarmSeverity, BatchHeader};
use serde::Serialize;

/// Age at which the latest slice becomes invalid, nanoseconds: two slices arrive every second.
const STALE_NS: i64 = 3_000_000_000;

/// Standing alarms in the latest slice.
#[derive(Clone, Debug)]
pub(crate) struct PresentAlarms {
    sent_ns: i64,
    standing: Vec<Alarm>,
}

impl Default for PresentAlarms {
    fn default() -> Self {
        Self {
            sent_ns: i64::MIN,
            standing: Vec::new(),
        }
    }
}

impl PresentAlarms {
    /// Receives a slice, which replaces the previous slice.
    pub(crate) fn take(&mut self, header: &BatchHeader, slice: &[Alarm]) {
        // After a restart of the monitor, an earlier slice may arrive late.
        if header.sent_ns >= self.sent_ns {
            self.sent_ns = header.sent_ns;
            self.standing.clear();
            let standing = slice.iter().filter(|alarm| alarm.event() != Some(AlarmEvent::Cleared));
            self.standing.extend(standing);
        }
    }

    /// Returns the alarms standing at `now_ns` (monotonic, nanoseconds); `None` without a recent slice.
    pub(crate) fn at(&self, now_ns: i64) -> Option<&[Alarm]> {
        (now_ns <= self.sent_ns.saturating_add(STALE_NS)).then_some(&self.standing[..])
    }
}

/// Standing alarm in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct StandingAlarm {
    /// Word for the severity; `?` for an unknown one.
    pub severity: &'static str,
    /// Word for the kind; `?` for a kind of another version: its sentence is complete all the same.
    pub alarm: &'static str,
    /// Time at which it was raised, UTC, nanoseconds.
    pub raised_ns: i64,
    /// Sentence.
    pub text: String,
    /// Remedy; empty for an unknown kind.
    pub remedy: &'static str,
}

impl From<&Alarm> for StandingAlarm {
    fn from(alarm: &Alarm) -> Self {
        let kind = AlarmKind::from_code(alarm.code);
        Self {
            severity: alarm.severity().map_or("?", AlarmSeverity::word),
            alarm: kind.map_or("?", AlarmKind::word),
            raised_ns: alarm.raised_ns,
            text: alarm.text().to_owned(),
            remedy: kind.map_or("", AlarmKind::remedy),
        }
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    #[test]
    fn the_latest_slice_holds_and_only_for_a_while() {
        let mut present = PresentAlarms::default();
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
        present.take(&header(10 * S), &slice);
        present.take(&header(9 * S), &[]);
        assert_eq!(present.at(10 * S), Some(&slice[..1]));
        assert_eq!(present.at(14 * S), None, "the monitor says nothing any more");
        present.take(&header(14 * S), &[]);
        assert_eq!(present.at(14 * S), Some(&[][..]));
    }
}
