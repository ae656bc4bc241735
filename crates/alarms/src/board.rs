//! When an alarm is raised and when it is cleared.
//!
//! ```text
//!              bad for the on-delay              good for the off-delay
//!   suspected ─────────────────────▶ standing ─────────────────────────▶ cleared
//!       ▲                              │    ▲                                │
//!       │                              └────┘ bad, or in between             │
//!       └───────────────────────────── bad again ────────────────────────────┘
//! ```
//!
//! Conditions are gone through in *rounds*: in each, whoever evaluates them names those that it finds bad or in between
//! ([`Round::find`]); all others are good. So a subject that is no more, a process that left, needs no farewell.

use std::collections::BTreeMap;

use messages::{Alarm, AlarmEvent};

use crate::registry::AlarmKind;
use crate::subject::Subject;

/// Most alarms that stand or are cleared in one round: a slice of the topic holds them.
const TOLD_MAX: usize = 64;
/// Most conditions that are remembered, those suspected and those cleared included.
const ENTRIES_MAX: usize = 512;

/// Outcome of looking at a condition. Where there is nothing to be found, it is good.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Finding {
    /// Value between the limit for raising and that for clearing.
    Between,
    /// Value beyond the limit for raising.
    Bad,
}

/// All alarms of a deployment.
#[derive(Clone, Debug, Default)]
pub struct Board {
    entries: BTreeMap<(AlarmKind, Subject), Entry>,
    dropped: u64,
}

#[derive(Clone, Debug)]
struct Entry {
    phase: Phase,
    /// What was found in the round at hand.
    found: Option<Finding>,
    text: String,
    times: u32,
    /// UTC, nanoseconds, as the next one.
    raised_ns: i64,
    cleared_ns: i64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Bad, not yet for long enough; since when (monotonic, nanoseconds).
    Suspected { since_ns: i64 },
    /// Raised; since when it is good again, if it is (monotonic, nanoseconds).
    Standing { good_ns: Option<i64> },
    /// Raised and cleared, or not raised.
    Cleared,
}

/// Alarm, as the final report tells of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct History {
    /// Kind of the alarm.
    pub kind: AlarmKind,
    /// Subject of the alarm.
    pub subject: Subject,
    /// The sentence, as it was last.
    pub text: String,
    /// Times that it was raised.
    pub times: u32,
    /// When it was raised last, UTC, nanoseconds.
    pub raised_ns: i64,
    /// When it was cleared, UTC, nanoseconds; `None` if it stands.
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

    /// Every alarm that was ever raised, in the order of the registry.
    pub fn history(&self) -> impl Iterator<Item = History> + '_ {
        let raised = self.entries.iter().filter(|(_, entry)| entry.times > 0);
        raised.map(|((kind, subject), entry)| History {
            kind: *kind,
            subject: *subject,
            text: entry.text.clone(),
            times: entry.times,
            raised_ns: entry.raised_ns,
            cleared_ns: match entry.phase {
                Phase::Standing { .. } => None,
                Phase::Cleared | Phase::Suspected { .. } => Some(entry.cleared_ns),
            },
        })
    }

    /// Findings that there was no room for.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    fn told(&self) -> usize {
        let stands = |entry: &&Entry| matches!(entry.phase, Phase::Standing { .. });
        self.entries.values().filter(stands).count()
    }

    /// Makes room for one more entry, at the cost of the alarm that was cleared first; whether there is room.
    fn make_room(&mut self) -> bool {
        if self.entries.len() < ENTRIES_MAX {
            return true;
        }
        let cleared = self.entries.iter().filter_map(|(key, entry)| match entry.phase {
            Phase::Cleared if entry.found.is_none() => Some((entry.cleared_ns, *key)),
            _ => None,
        });
        match cleared.min() {
            Some((_, key)) => self.entries.remove(&key).is_some(),
            None => false,
        }
    }
}

/// One round of looking at all conditions.
#[derive(Debug)]
pub struct Round<'a> {
    board: &'a mut Board,
    now_ns: i64,
    utc_ns: i64,
}

impl Round<'_> {
    /// Notes what was found; of several findings about the same, the worst counts. `values` fill in the sentence.
    pub fn find(&mut self, kind: AlarmKind, subject: Subject, finding: Finding, values: &[(&str, String)]) {
        let board = &mut *self.board;
        if !board.entries.contains_key(&(kind, subject)) {
            // What is in between raises nothing.
            if finding == Finding::Between {
                return;
            }
            if !board.make_room() {
                board.dropped += 1;
                return;
            }
        }
        let entry = board.entries.entry((kind, subject)).or_insert_with(|| Entry {
            phase: Phase::Suspected { since_ns: self.now_ns },
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

    /// Ends the round: all that stands, the worst first, and what has been cleared in it.
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
        // Stable: among equals, the order of the registry.
        told.sort_by_key(|alarm| std::cmp::Reverse(alarm.severity));
        told
    }
}

impl Entry {
    /// Lets the entry go on; the event to tell, if there is one.
    fn step(
        &mut self,
        kind: AlarmKind,
        found: Option<Finding>,
        now_ns: i64,
        utc_ns: i64,
        room: &mut usize,
        dropped: &mut u64,
    ) -> Option<AlarmEvent> {
        if let (Phase::Cleared, Some(Finding::Bad)) = (self.phase, found) {
            self.phase = Phase::Suspected { since_ns: now_ns };
        }
        match (self.phase, found) {
            (Phase::Cleared, _) => None,
            (Phase::Suspected { since_ns }, Some(Finding::Bad)) => {
                if now_ns - since_ns < kind.raise_after_ns() {
                    return None;
                }
                if *room == 0 {
                    *dropped += 1;
                    return None;
                }
                *room -= 1;
                self.phase = Phase::Standing { good_ns: None };
                self.times = self.times.saturating_add(1);
                self.raised_ns = utc_ns;
                Some(AlarmEvent::Raised)
            }
            (Phase::Suspected { .. }, _) => {
                // One that was raised before stays known; the others are forgotten by the caller.
                self.phase = Phase::Cleared;
                None
            }
            (Phase::Standing { .. }, Some(_)) => {
                self.phase = Phase::Standing { good_ns: None };
                Some(AlarmEvent::Standing)
            }
            (Phase::Standing { good_ns }, None) => {
                let good_ns = good_ns.unwrap_or(now_ns);
                self.phase = Phase::Standing { good_ns: Some(good_ns) };
                if now_ns - good_ns < kind.clear_after_ns() {
                    return Some(AlarmEvent::Standing);
                }
                (self.phase, self.cleared_ns) = (Phase::Cleared, utc_ns);
                Some(AlarmEvent::Cleared)
            }
        }
    }
}

fn alarm(kind: AlarmKind, subject: Subject, entry: &Entry, event: AlarmEvent, utc_ns: i64) -> Alarm {
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
                "The clock of radar is 85 s off, by the times at which its reports are received."
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
        // No room to be told, and no room to be remembered.
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
