//! How a process is: its health messages (PL-7).

use bus::{Bus, Mark, Publisher, SharedMemory};
use messages::{Counter, CounterClass, Health, LifeState, NO_SOURCE, Registration};

use crate::clock::Now;

/// One health message's content.
#[derive(Clone, Debug)]
pub struct HealthEntry {
    /// Source that it speaks of; [`NO_SOURCE`] for the process.
    pub source: u16,
    /// How far the process has got in the time of its data, UTC, nanoseconds.
    pub progress_ns: i64,
    /// Counters, indexed by [`Counter`].
    pub counters: messages::Counters,
    /// What is wrong; empty if nothing is.
    pub note: String,
    /// Systematic errors of the source, where fusion speaks of one.
    pub registration: Registration,
}

impl Default for HealthEntry {
    fn default() -> Self {
        Self {
            source: NO_SOURCE,
            progress_ns: i64::MIN,
            counters: messages::Counters::default(),
            note: String::new(),
            registration: Registration::default(),
        }
    }
}

impl HealthEntry {
    /// Adds what is counted of each of `sources`: a process speaks of all together, and of what is of none of them.
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

/// Publishes the health of one process.
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

    /// The process goes by this name from now on.
    pub(crate) fn rename(&mut self, name: &str) {
        self.blank = self.blank.with_name(name);
    }

    /// Publishes `entries`, as they were at `now`.
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
                counters: entry.counters,
                registration: entry.registration,
                ..blank
            };
            match entry.note.is_empty() {
                true => health,
                false => health.with_note(&entry.note),
            }
        })?;
        Ok(())
    }
}
