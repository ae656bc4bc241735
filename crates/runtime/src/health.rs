//! Health messages of a process (PL-7).

use bus::{Bus, Mark, Publisher, SharedMemory};
use messages::{Counter, CounterClass, Health, LifeState, NO_SOURCE, Registration};

use crate::clock::Now;

/// Contents of one health message.
#[derive(Clone, Debug)]
pub struct HealthEntry {
    /// Source of the message; [`NO_SOURCE`] for the process as a whole.
    pub source: u16,
    /// Progress of the process in the time of its data, UTC, nanoseconds.
    pub progress_ns: i64,
    /// Counters, indexed by [`Counter`].
    pub counters: messages::Counters,
    /// Input outside the configuration, as in [`Health::misfit`].
    pub misfit: [u8; 4],
    /// Fault in words; empty without a fault.
    pub note: String,
    /// Input that was refused last, with the reasons, as in [`Health::refusal`].
    pub refusal: String,
    /// Systematic errors of the source, in messages of fusion.
    pub registration: Registration,
}

impl Default for HealthEntry {
    fn default() -> Self {
        Self {
            source: NO_SOURCE,
            progress_ns: i64::MIN,
            counters: messages::Counters::default(),
            misfit: [0; 4],
            note: String::new(),
            refusal: String::new(),
            registration: Registration::default(),
        }
    }
}

impl HealthEntry {
    /// Adds the counts of each of `sources`, and of reports without a source, to the totals of the process.
    pub fn add_sources(&mut self, sources: &[Self]) {
        let counted = Counter::ALL
            .iter()
            .filter(|counter| counter.class() != CounterClass::Level);
        for counter in counted {
            let of_sources = sources.iter().map(|source| source.counters[*counter]);
            self.counters[*counter] += of_sources.sum::<u64>();
        }
    }

    /// Sets one counter.
    pub fn set(&mut self, counter: Counter, value: u64) {
        self.counters[counter] = value;
    }
}

/// Publisher of the health of one process.
pub(crate) struct Reporter {
    publisher: Publisher<SharedMemory, Health>,
    blank: Health,
}

impl Reporter {
    pub(crate) fn new(bus: &Bus<SharedMemory>, incarnation: u64, blank: Health) -> anyhow::Result<Self> {
        Ok(Self {
            publisher: bus.publisher(&messages::health(), incarnation)?,
            blank,
        })
    }

    /// Changes the name of the process in later messages.
    pub(crate) fn rename(&mut self, name: &str) {
        self.blank = self.blank.with_name(name);
    }

    /// Publishes `entries` with the time `now`.
    pub(crate) fn publish(&mut self, now: Now, life: LifeState, entries: &[HealthEntry]) -> anyhow::Result<()> {
        let blank = self.blank;
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: now.mono_ns,
            end: false,
        };
        self.publisher.send(mark, entries.len(), |index, _| {
            let entry = &entries[index];
            let health = Health {
                said_ns: now.mono_ns,
                progress_ns: entry.progress_ns,
                source: entry.source,
                life: life as u8,
                misfit: entry.misfit,
                counters: entry.counters,
                registration: entry.registration,
                ..blank
            };
            let health = match entry.refusal.is_empty() {
                true => health,
                false => health.with_refusal(&entry.refusal),
            };
            match entry.note.is_empty() {
                true => health,
                false => health.with_note(&entry.note),
            }
        })?;
        Ok(())
    }
}
