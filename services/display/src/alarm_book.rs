//! Alarms as their operators treat them, and what has happened to them.
//!
//! The monitor states which alarms stand. The display adds two acts of operators: an alarm is *acknowledged* until the
//! alarm is cleared or raised again, or *shelved* for a time. Pages neither count nor sound a shelved alarm. Neither
//! act changes the alarm itself. The acts are kept in a file, which a restarted display reads; events before its start
//! are forgotten.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use messages::{Alarm, AlarmEvent, NS_PER_S};
use serde::{Deserialize, Serialize};

use crate::kept_file;

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
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Treatment {
    /// Operator and time of the acknowledgement, UTC, nanoseconds.
    pub(crate) acknowledged: Option<(String, i64)>,
    /// When the acknowledged alarm was raised, UTC, nanoseconds: another raise is not acknowledged.
    raised_ns: i64,
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
    /// File of the treatments.
    file: Option<PathBuf>,
}

impl AlarmBook {
    /// Creates a book whose treatments are kept in `file`, and reads those of a previous display.
    pub(crate) fn kept_in(file: PathBuf) -> Self {
        let treatments = read(&file).unwrap_or_else(|error| {
            runtime::notice(format_args!(
                "koseki: {}: {error}; acts on alarms before this start are forgotten",
                file.display()
            ));
            BTreeMap::new()
        });
        Self {
            treatments,
            file: Some(file),
            ..Self::default()
        }
    }

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
    /// A sentence, if no such alarm stands, too many alarms are treated, or the file cannot be written.
    pub(crate) fn act(&mut self, id: &AlarmId, act: AlarmAct, operator: &str, now_ns: i64) -> Result<(), String> {
        let alarm = *self.standing.get(id).ok_or("This alarm no longer stands")?;
        let mut treatments = self.treatments.clone();
        treatments.retain(|known, treatment| {
            let is_shelved = treatment
                .shelved
                .as_ref()
                .is_some_and(|(_, until_ns)| *until_ns > now_ns);
            is_shelved || self.standing.contains_key(known)
        });
        if treatments.len() == ACTS_MAX && !treatments.contains_key(id) {
            return Err(format!("More than {ACTS_MAX} alarms are acknowledged or shelved"));
        }
        let treatment = treatments.entry(id.clone()).or_default();
        let word = match act {
            AlarmAct::Acknowledge => {
                treatment.acknowledged = Some((operator.to_owned(), now_ns));
                treatment.raised_ns = alarm.raised_ns;
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
        if let Some(file) = &self.file {
            let named: BTreeMap<String, &Treatment> =
                treatments.iter().map(|(id, one)| (id.to_string(), one)).collect();
            kept_file::write(file, &named).map_err(|error| format!("{}: {error}", file.display()))?;
        }
        self.treatments = treatments;
        self.note(now_ns, word, operator, alarm);
        Ok(())
    }

    /// Returns the treatment of an alarm at `now_ns` (UTC).
    pub(crate) fn treatment(&self, alarm: &Alarm, now_ns: i64) -> Treatment {
        let mut treatment = self.treatments.get(&alarm.into()).cloned().unwrap_or_default();
        treatment.shelved = treatment.shelved.filter(|(_, until_ns)| *until_ns > now_ns);
        let is_raised_again = treatment.raised_ns != alarm.raised_ns;
        treatment.acknowledged = treatment.acknowledged.filter(|_| !is_raised_again);
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

/// Reads the treatments in `file`; a missing file has none.
fn read(file: &Path) -> Result<BTreeMap<AlarmId, Treatment>, String> {
    let text = match std::fs::read_to_string(file) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(BTreeMap::new()),
        text => text.map_err(|error| error.to_string())?,
    };
    let named: BTreeMap<String, Treatment> = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let treatments = named.into_iter().take(ACTS_MAX);
    treatments
        .map(|(id, treatment)| Ok((id.parse().map_err(|()| format!("{id} is no alarm"))?, treatment)))
        .collect()
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
        let second = alarm(7, 300, AlarmEvent::Raised);
        book.take(&[second]);
        assert!(
            book.treatment(&second, 310).acknowledged.is_none(),
            "it was raised again"
        );
        assert!(book.treatment(&second, 499).shelved.is_some());
        assert!(book.treatment(&second, 500).shelved.is_none());
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
    fn acts_outlast_the_display_but_not_another_raise_of_the_alarm() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("acts.json");
        let (first, second) = (alarm(7, 100, AlarmEvent::Raised), alarm(8, 100, AlarmEvent::Raised));
        let mut book = AlarmBook::kept_in(file.clone());
        book.take(&[first, second]);
        book.act(&(&first).into(), AlarmAct::Acknowledge, "anna", 110).unwrap();
        book.act(&(&second).into(), AlarmAct::Acknowledge, "anna", 111).unwrap();
        book.act(&(&second).into(), AlarmAct::Shelve(500), "ben", 112).unwrap();
        let mut again = AlarmBook::kept_in(file.clone());
        // The second was cleared and raised while there was no display.
        let (first, second) = (alarm(7, 100, AlarmEvent::Standing), alarm(8, 300, AlarmEvent::Standing));
        again.take(&[first, second]);
        assert_eq!(
            again.treatment(&first, 400).acknowledged,
            Some(("anna".to_owned(), 110))
        );
        let treated = again.treatment(&second, 400);
        assert_eq!(
            (treated.acknowledged, treated.shelved),
            (None, Some(("ben".to_owned(), 500)))
        );
        again.act(&(&first).into(), AlarmAct::Restore, "ben", 410).unwrap();
        let last = AlarmBook::kept_in(file.clone());
        assert!(last.treatment(&first, 420).acknowledged.is_none());
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "nothing is left beside it"
        );
    }

    #[test]
    fn an_act_that_cannot_be_kept_is_refused_and_a_torn_file_costs_the_acts_alone() {
        let folder = tempfile::tempdir().unwrap();
        let first = alarm(7, 100, AlarmEvent::Raised);
        let mut book = AlarmBook::kept_in(folder.path().join("none/acts.json"));
        book.take(&[first]);
        let refused = book
            .act(&(&first).into(), AlarmAct::Acknowledge, "anna", 110)
            .unwrap_err();
        assert!(refused.contains("acts.json"), "{refused}");
        assert!(book.treatment(&first, 120).acknowledged.is_none());
        let file = folder.path().join("acts.json");
        for text in ["{", r#"{"7": {"raised_ns": 1}}"#] {
            std::fs::write(&file, text).unwrap();
            let mut book = AlarmBook::kept_in(file.clone());
            book.take(&[first]);
            assert!(book.treatment(&first, 120).acknowledged.is_none());
            book.act(&(&first).into(), AlarmAct::Acknowledge, "anna", 110).unwrap();
        }
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
