//! Alarms as their operators treat them, and what has happened to them.
//!
//! The monitor states which alarms stand. The display adds two acts of operators: an alarm is *acknowledged* until the
//! alarm is cleared or raised again, or *shelved* for a time. Pages neither count nor sound a shelved alarm. Neither
//! act changes the alarm itself. A restart of the display forgets both acts: each alarm is then shown as before.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::str::FromStr;

use messages::{Alarm, AlarmEvent, NS_PER_S};

/// Maximum number of stored events.
const EVENTS_MAX: usize = 512;
/// Maximum number of alarms with acts of operators.
const ACTS_MAX: usize = 256;
/// Longest time for which an alarm is shelved, seconds.
pub(crate) const SHELVED_MAX_S: f64 = 86_400.0;

/// Identity of an alarm: `CODE/SOURCE/PARTNER/PROCESS` in texts.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct AlarmId {
    code: u16,
    source: u16,
    partner: u16,
    process: String,
}

impl From<&Alarm> for AlarmId {
    fn from(alarm: &Alarm) -> Self {
        Self {
            code: alarm.code,
            source: alarm.source,
            partner: alarm.partner,
            process: alarm.process().to_owned(),
        }
    }
}

impl fmt::Display for AlarmId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}/{}", self.code, self.source, self.partner, self.process)
    }
}

impl FromStr for AlarmId {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let mut parts = text.splitn(4, '/');
        let mut number = || parts.next()?.parse().ok();
        let (code, source, partner) = (number().ok_or(())?, number().ok_or(())?, number().ok_or(())?);
        Ok(Self {
            code,
            source,
            partner,
            process: parts.next().ok_or(())?.to_owned(),
        })
    }
}

/// Act of an operator on an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AlarmAct {
    Acknowledge,
    /// Until a time, UTC, nanoseconds.
    Shelve(i64),
    /// Both other acts are taken back.
    Restore,
}

/// Treatment of an alarm by operators.
#[derive(Clone, Debug, Default)]
pub(crate) struct Treatment {
    /// Operator and time of the acknowledgement, UTC, nanoseconds.
    pub(crate) acknowledged: Option<(String, i64)>,
    /// Operator and end of the shelving, UTC, nanoseconds.
    pub(crate) shelved: Option<(String, i64)>,
}

/// Event in the life of an alarm.
#[derive(Clone, Debug)]
pub(crate) struct PastEvent {
    pub(crate) time_ns: i64,
    pub(crate) word: &'static str,
    /// Empty for events that no operator has caused.
    pub(crate) operator: String,
    pub(crate) alarm: Alarm,
}

/// Alarms, their treatment, and their past.
#[derive(Debug, Default)]
pub(crate) struct AlarmBook {
    standing: BTreeMap<AlarmId, Alarm>,
    treatments: BTreeMap<AlarmId, Treatment>,
    events: VecDeque<PastEvent>,
    /// Number of all events so far.
    count: u64,
}

impl AlarmBook {
    /// Receives a slice: all standing alarms, and those just cleared.
    pub(crate) fn take(&mut self, slice: &[Alarm]) {
        let stands = |alarm: &&Alarm| alarm.event() != Some(AlarmEvent::Cleared);
        let now: BTreeMap<AlarmId, Alarm> = slice
            .iter()
            .filter(stands)
            .map(|alarm| (alarm.into(), *alarm))
            .collect();
        let before = std::mem::take(&mut self.standing);
        for (id, alarm) in &now {
            if before.get(id).is_none_or(|known| known.raised_ns != alarm.raised_ns) {
                self.note(alarm.raised_ns, "raised", "", *alarm);
                if let Some(treatment) = self.treatments.get_mut(id) {
                    treatment.acknowledged = None;
                }
            }
        }
        // A slice without alarms has no time; the last statement about the alarm is the best one.
        let time_ns = slice.iter().map(|alarm| alarm.time_ns).max();
        for (id, alarm) in before.iter().filter(|(id, _)| !now.contains_key(id)) {
            self.note(time_ns.unwrap_or(alarm.time_ns), "cleared", "", *alarm);
            if let Some(treatment) = self.treatments.get_mut(id) {
                treatment.acknowledged = None;
            }
        }
        self.standing = now;
    }

    /// Does what an operator wants of a standing alarm, at `now_ns` (UTC).
    ///
    /// # Errors
    /// A sentence, if no such alarm stands or too many alarms are treated.
    pub(crate) fn act(&mut self, id: &AlarmId, act: AlarmAct, operator: &str, now_ns: i64) -> Result<(), String> {
        let alarm = *self.standing.get(id).ok_or("This alarm no longer stands")?;
        self.treatments.retain(|known, treatment| {
            let is_shelved = treatment
                .shelved
                .as_ref()
                .is_some_and(|(_, until_ns)| *until_ns > now_ns);
            is_shelved || self.standing.contains_key(known)
        });
        if self.treatments.len() == ACTS_MAX && !self.treatments.contains_key(id) {
            return Err(format!("More than {ACTS_MAX} alarms are acknowledged or shelved"));
        }
        let treatment = self.treatments.entry(id.clone()).or_default();
        let word = match act {
            AlarmAct::Acknowledge => {
                treatment.acknowledged = Some((operator.to_owned(), now_ns));
                "acknowledged"
            }
            AlarmAct::Shelve(until_ns) => {
                let most_ns = now_ns.saturating_add(SHELVED_MAX_S as i64 * NS_PER_S as i64);
                treatment.shelved = Some((operator.to_owned(), until_ns.min(most_ns)));
                "shelved"
            }
            AlarmAct::Restore => {
                *treatment = Treatment::default();
                "restored"
            }
        };
        self.note(now_ns, word, operator, alarm);
        Ok(())
    }

    /// Returns the treatment of an alarm at `now_ns` (UTC).
    pub(crate) fn treatment(&self, alarm: &Alarm, now_ns: i64) -> Treatment {
        let mut treatment = self.treatments.get(&alarm.into()).cloned().unwrap_or_default();
        treatment.shelved = treatment.shelved.filter(|(_, until_ns)| *until_ns > now_ns);
        treatment
    }

    /// Returns the stored events, the latest first.
    pub(crate) fn events(&self) -> impl Iterator<Item = &PastEvent> {
        self.events.iter().rev()
    }

    /// Returns the number of all events so far: it rises with each.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    fn note(&mut self, time_ns: i64, word: &'static str, operator: &str, alarm: Alarm) {
        if self.events.len() == EVENTS_MAX {
            self.events.pop_front();
        }
        self.count += 1;
        self.events.push_back(PastEvent {
            time_ns,
            word,
            operator: operator.to_owned(),
            alarm,
        });
    }
}

#[cfg(test)]
mod tests {
    use messages::{AlarmSeverity, NO_SOURCE};

    use super::*;

    fn alarm(code: u16, raised_ns: i64, event: AlarmEvent) -> Alarm {
        Alarm {
            time_ns: raised_ns + 5,
            raised_ns,
            code,
            source: NO_SOURCE,
            partner: NO_SOURCE,
            severity: AlarmSeverity::Major as u8,
            event: event as u8,
            ..Alarm::default()
        }
    }

    fn words(book: &AlarmBook) -> Vec<(&'static str, u16)> {
        book.events().map(|event| (event.word, event.alarm.code)).collect()
    }

    #[test]
    fn an_acknowledgement_ends_when_the_alarm_is_raised_again_and_a_shelving_with_its_time() {
        let mut book = AlarmBook::default();
        let first = alarm(7, 100, AlarmEvent::Raised);
        let id = AlarmId::from(&first);
        book.take(&[first]);
        book.act(&id, AlarmAct::Acknowledge, "anna", 110).unwrap();
        book.act(&id, AlarmAct::Shelve(500), "anna", 120).unwrap();
        book.take(&[alarm(7, 100, AlarmEvent::Standing)]);
        let treated = book.treatment(&first, 130);
        assert_eq!(treated.acknowledged, Some(("anna".to_owned(), 110)));
        assert_eq!(treated.shelved, Some(("anna".to_owned(), 500)));
        book.take(&[alarm(7, 300, AlarmEvent::Raised)]);
        assert!(
            book.treatment(&first, 310).acknowledged.is_none(),
            "it was raised again"
        );
        assert!(book.treatment(&first, 499).shelved.is_some());
        assert!(book.treatment(&first, 500).shelved.is_none());
        assert_eq!(
            words(&book),
            [("raised", 7), ("shelved", 7), ("acknowledged", 7), ("raised", 7)]
        );
        assert_eq!(book.count(), 4);
    }

    #[test]
    fn what_no_longer_stands_is_cleared_and_cannot_be_treated() {
        let mut book = AlarmBook::default();
        book.take(&[alarm(1, 100, AlarmEvent::Raised), alarm(2, 100, AlarmEvent::Raised)]);
        let id = AlarmId::from(&alarm(1, 100, AlarmEvent::Raised));
        book.act(&id, AlarmAct::Acknowledge, "anna", 101).unwrap();
        book.take(&[alarm(1, 100, AlarmEvent::Cleared), alarm(2, 100, AlarmEvent::Standing)]);
        book.take(&[]);
        assert_eq!(words(&book)[..2], [("cleared", 2), ("cleared", 1)]);
        assert!(book.act(&id, AlarmAct::Acknowledge, "anna", 200).is_err());
        assert!(
            book.treatment(&alarm(1, 100, AlarmEvent::Standing), 200)
                .acknowledged
                .is_none()
        );
    }

    #[test]
    fn identities_survive_a_text_and_the_past_is_bounded() {
        let id = AlarmId::from(&alarm(3, 1, AlarmEvent::Raised));
        assert_eq!(id.to_string().parse(), Ok(id));
        for text in ["", "1/2/3", "a/2/3/x", "1/2/70000/x"] {
            assert!(text.parse::<AlarmId>().is_err(), "{text}");
        }
        let mut book = AlarmBook::default();
        for turn in 0..EVENTS_MAX as i64 {
            book.take(&[alarm(1, turn, AlarmEvent::Raised)]);
            book.take(&[]);
        }
        assert_eq!(book.events().count(), EVENTS_MAX);
        assert_eq!(book.count(), 2 * EVENTS_MAX as u64);
    }
}
