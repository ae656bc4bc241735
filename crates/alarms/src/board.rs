//! Raising and clearing of alarms.
//!
//! ```text
//!              bad for the on-delay              good for the off-delay
//!   suspected ─────────────────────▶ standing ─────────────────────────▶ cleared
//!       ▲                              │    ▲                                │
//!       │                              └────┘ bad, or in between             │
//!       └───────────────────────────── bad again ────────────────────────────┘
//! ```
//!
//! Conditions are evaluated in *rounds*. In each round, the caller names the conditions found bad or in between
//! ([`Round::find`]); all others are good. A subject that disappears, such as a terminated process, therefore needs
//! no deregistration.

use std::collections::BTreeMap;

use messages::{Alarm, AlarmEvent};

use crate::registry::AlarmKind;
use crate::subject::Subject;

/// Maximum number of alarms standing or cleared in one round: the capacity of a slice of the topic.
const TOLD_MAX: usize = 64;
/// Maximum number of stored conditions, including suspected and cleared ones.
const ENTRIES_MAX: usize = 512;

/// Result of evaluating a condition. A condition without a finding is good.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Finding {
    /// Value between the limits for raising and for clearing.
    Between,
    /// Value beyond the limit for raising.
    Bad,
}

/// All alarms of a deployment.
#[derive(Clone, Debug, Default)]
pub struct Board {
    entries: BTreeMap<(AlarmKind, Subject), AlarmEntry>,
    dropped: u64,
}

#[derive(Clone, Debug)]
struct AlarmEntry {
    phase: AlarmPhase,
    /// Finding of the current round.
    found: Option<Finding>,
    text: String,
    times: u32,
    /// UTC, nanoseconds, like the next field.
    raised_ns: i64,
    cleared_ns: i64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AlarmPhase {
    /// Bad, but shorter than the on-delay; start time (monotonic, nanoseconds).
    Suspected { since_ns: i64 },
    /// Raised; start of the present good time, if any (monotonic, nanoseconds).
    Standing { good_ns: Option<i64> },
    /// Raised and cleared, or not raised.
    Cleared,
}

/// Alarm in the final report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlarmHistory {
    /// Kind of the alarm.
    pub kind: AlarmKind,
    /// Subject of the alarm.
    pub subject: Subject,
    /// Latest sentence.
    pub text: String,
    /// Number of times that the alarm was raised.
    pub times: u32,
    /// Time of the latest raising, UTC, nanoseconds.
    pub raised_ns: i64,
    /// Time of clearing, UTC, nanoseconds; `None` while the alarm stands.
    pub cleared_ns: Option<i64>,
}

impl Board {
    /// Begins a round at `now_ns` (monotonic) and `utc_ns` (UTC), nanoseconds.
    pub fn round(&mut self, now_ns: i64, utc_ns: i64) -> Round<'_> {
        Round {
            board: self,
            now_ns,
            utc_ns,
        }
    }

    /// Returns every alarm raised so far, in the order of the registry.
    pub fn history(&self) -> impl Iterator<Item = AlarmHistory> + '_ {
        let raised = self.entries.iter().filter(|(_, entry)| entry.times > 0);
        raised.map(|((kind, subject), entry)| AlarmHistory {
            kind: *kind,
            subject: *subject,
            text: entry.text.clone(),
            times: entry.times,
            raised_ns: entry.raised_ns,
            cleared_ns: match entry.phase {
                AlarmPhase::Standing { .. } => None,
                AlarmPhase::Cleared | AlarmPhase::Suspected { .. } => Some(entry.cleared_ns),
            },
        })
    }

    /// Returns the number of findings dropped for lack of room.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    fn told(&self) -> usize {
        let stands = |entry: &&AlarmEntry| matches!(entry.phase, AlarmPhase::Standing { .. });
        self.entries.values().filter(stands).count()
    }

    /// Makes room for one more entry by dropping the alarm that was cleared first; returns whether there is room.
    fn make_room(&mut self) -> bool {
        if self.entries.len() < ENTRIES_MAX {
            return true;
        }
        let cleared = self.entries.iter().filter_map(|(key, entry)| match entry.phase {
            AlarmPhase::Cleared if entry.found.is_none() => Some((entry.cleared_ns, *key)),
            _ => None,
        });
        match cleared.min() {
            Some((_, key)) => self.entries.remove(&key).is_some(),
            None => false,
        }
    }
}

/// Round of evaluating all conditions.
#[derive(Debug)]
pub struct Round<'a> {
    board: &'a mut Board,
    now_ns: i64,
    utc_ns: i64,
}

impl Round<'_> {
    /// Records a finding; of several findings about the same condition, the worst counts. `values` fill in the
    /// sentence.
    pub fn find(&mut self, kind: AlarmKind, subject: Subject, finding: Finding, values: &[(&str, String)]) {
        let board = &mut *self.board;
        if !board.entries.contains_key(&(kind, subject)) {
            // A value in between raises nothing.
            if finding == Finding::Between {
                return;
            }
            if !board.make_room() {
                board.dropped += 1;
                return;
            }
        }
        let entry = board.entries.entry((kind, subject)).or_insert_with(|| AlarmEntry {
            phase: AlarmPhase::Suspected { since_ns: self.now_ns },
            found: None,
            text: String::new(),
            times: 0,
            raised_ns: 0,
            cleared_ns: 0,
        });
        if entry.found < Some(finding) {
            entry.found = Some(finding);
            if finding == Finding::Bad {
                entry.text = kind.say(values);
            }
        }
    }

    /// Ends the round; returns all standing alarms, the worst first, and the alarms cleared in this round.
    pub fn end(self) -> Vec<Alarm> {
        let Self { board, now_ns, utc_ns } = self;
        let mut room = TOLD_MAX - board.told();
        let mut told = Vec::new();
        let dropped = &mut board.dropped;
        board.entries.retain(|(kind, subject), entry| {
            let found = entry.found.take();
            let event = entry.step(*kind, found, now_ns, utc_ns, &mut room, dropped);
            if let Some(event) = event {
                told.push(alarm(*kind, *subject, entry, event, utc_ns));
            }
            entry.times > 0 || found.is_some()
        });
        // The sort is stable: at equal severity, the order of the registry stays.
        told.sort_by_key(|alarm| std::cmp::Reverse(alarm.severity));
        told
    }
}

impl AlarmEntry {
    /// Advances the entry; returns the event to publish, if any.
    fn step(
        &mut self,
        kind: AlarmKind,
        found: Option<Finding>,
        now_ns: i64,
        utc_ns: i64,
        room: &mut usize,
        dropped: &mut u64,
    ) -> Option<AlarmEvent> {
        if let (AlarmPhase::Cleared, Some(Finding::Bad)) = (self.phase, found) {
            self.phase = AlarmPhase::Suspected { since_ns: now_ns };
        }
        match (self.phase, found) {
            (AlarmPhase::Cleared, _) => None,
            (AlarmPhase::Suspected { since_ns }, Some(Finding::Bad)) => {
                if now_ns - since_ns < kind.raise_after_ns() {
                    return None;
                }
                if *room == 0 {
                    *dropped += 1;
                    return None;
                }
                *room -= 1;
                self.phase = AlarmPhase::Standing { good_ns: None };
                self.times = self.times.saturating_add(1);
                self.raised_ns = utc_ns;
                Some(AlarmEvent::Raised)
            }
            (AlarmPhase::Suspected { .. }, _) => {
                // An alarm raised earlier stays stored; the caller drops the others.
                self.phase = AlarmPhase::Cleared;
                None
            }
            (AlarmPhase::Standing { .. }, Some(_)) => {
                self.phase = AlarmPhase::Standing { good_ns: None };
                Some(AlarmEvent::Standing)
            }
            (AlarmPhase::Standing { good_ns }, None) => {
                let good_ns = good_ns.unwrap_or(now_ns);
                self.phase = AlarmPhase::Standing { good_ns: Some(good_ns) };
                if now_ns - good_ns < kind.clear_after_ns() {
                    return Some(AlarmEvent::Standing);
                }
                (self.phase, self.cleared_ns) = (AlarmPhase::Cleared, utc_ns);
                Some(AlarmEvent::Cleared)
            }
        }
    }
}

fn alarm(kind: AlarmKind, subject: Subject, entry: &AlarmEntry, event: AlarmEvent, utc_ns: i64) -> Alarm {
    let alarm = Alarm {
        time_ns: utc_ns,
        raised_ns: entry.raised_ns,
        times: entry.times,
        code: kind.code(),
        source: subject.source,
        partner: subject.partner,
        severity: kind.severity().code(),
        event: event.code(),
        ..Alarm::default()
    };
    alarm.with_process(subject.process).with_text(&entry.text)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use test_support::S;

    use super::*;

    const UTC_NS: i64 = 1_700_000_000 * S;
    /// Raised after 5 s, cleared after 30 s.
    const KIND: AlarmKind = AlarmKind::ClockOff;

    fn round(board: &mut Board, second: i64, finding: Option<Finding>) -> Option<AlarmEvent> {
        let mut round = board.round(second * S, UTC_NS + second * S);
        if let Some(finding) = finding {
            let values = [("source", "radar".to_owned()), ("offset", format!("{second} s"))];
            round.find(KIND, Subject::source(3), finding, &values);
        }
        let told = round.end();
        assert!(told.len() <= 1);
        told.first().and_then(Alarm::event)
    }

    #[test]
    fn an_alarm_is_raised_and_cleared_after_its_delays() {
        let mut board = Board::default();
        let (bad, between) = (Some(Finding::Bad), Some(Finding::Between));
        assert_eq!(round(&mut board, 0, bad), None);
        assert_eq!(round(&mut board, 4, None), None, "it was good before its time");
        assert_eq!(round(&mut board, 5, between), None, "that begins nothing");
        assert_eq!(round(&mut board, 6, bad), None);
        assert_eq!(round(&mut board, 11, bad), Some(AlarmEvent::Raised));
        assert_eq!(round(&mut board, 12, None), Some(AlarmEvent::Standing));
        assert_eq!(round(&mut board, 41, between), Some(AlarmEvent::Standing));
        assert_eq!(round(&mut board, 42, None), Some(AlarmEvent::Standing));
        assert_eq!(round(&mut board, 72, None), Some(AlarmEvent::Cleared));
        assert_eq!(round(&mut board, 73, None), None);
        round(&mut board, 80, bad);
        assert_eq!(round(&mut board, 85, bad), Some(AlarmEvent::Raised));
        let history: Vec<_> = board.history().collect();
        assert_eq!((history.len(), history[0].times, history[0].cleared_ns), (1, 2, None));
        assert_eq!(
            (history[0].raised_ns, history[0].text.as_str()),
            (
                UTC_NS + 85 * S,
                "The clock of radar is 85 s off, compared with the times of receipt of its reports."
            )
        );
    }

    #[test]
    fn what_was_suspected_and_came_to_nothing_is_forgotten() {
        let mut board = Board::default();
        round(&mut board, 0, Some(Finding::Bad));
        round(&mut board, 1, None);
        assert!(board.entries.is_empty());
        assert_eq!(board.history().count(), 0);
    }

    #[test]
    fn a_sample_says_whom_it_is_about() {
        let mut board = Board::default();
        let mut round = board.round(S, UTC_NS);
        let subject = Subject::process("antenna").of_source(3);
        round.find(AlarmKind::SendFailed, subject, Finding::Bad, &[]);
        round.find(AlarmKind::ProcessHung, subject, Finding::Bad, &[]);
        let told = round.end();
        assert_eq!(
            told.iter().map(|alarm| alarm.code).collect::<Vec<_>>(),
            [17, 12],
            "the worst first"
        );
        assert_eq!((told[0].process(), told[0].source, told[0].times), ("antenna", 3, 1));
    }

    #[test]
    fn more_than_a_slice_holds_is_counted() {
        let mut board = Board::default();
        for second in 0..2 {
            let mut round = board.round(second * S, UTC_NS);
            for source in 0..600 {
                round.find(AlarmKind::SourceSilent, Subject::source(source), Finding::Bad, &[]);
            }
            assert_eq!(round.end().len(), TOLD_MAX);
        }
        // No room in the slice, and no room in the store.
        assert_eq!(
            board.dropped() as usize,
            2 * ((ENTRIES_MAX - TOLD_MAX) + (600 - ENTRIES_MAX))
        );
    }

    proptest! {
        #[test]
        fn an_alarm_is_told_as_raised_then_standing_then_cleared(found in proptest::collection::vec(0..3u8, 1..400)) {
            let mut board = Board::default();
            let mut before = None;
            for (second, found) in found.into_iter().enumerate() {
                let finding = [None, Some(Finding::Between), Some(Finding::Bad)][usize::from(found)];
                let event = round(&mut board, second as i64, finding);
                let stood = matches!(before, Some(AlarmEvent::Raised | AlarmEvent::Standing));
                prop_assert_eq!(stood, matches!(event, Some(AlarmEvent::Standing | AlarmEvent::Cleared)));
                before = event;
            }
        }
    }
}
