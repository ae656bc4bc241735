//! What the children say of themselves, and what the launcher says of them.
//!
//! A child's own health message cannot know how often it was restarted, and a dead child says nothing. So the launcher
//! adds one entry for itself and one for each child: of kind `launcher`, with the child's name, process number, source,
//! restarts, and how it last ended. When all children have ended, its own entry says `finished`; that is how readers
//! that are no children learn that it is time to leave.

use bus::{Bus, Mark, Publisher, SharedMemory, Subscriber};
use messages::{Health, LifeState, NO_SOURCE, ProcessKind};
use runtime::Now;

use crate::child::Child;

/// Time between two messages, nanoseconds.
const PERIOD_NS: i64 = 200_000_000;

/// The health topic, read and written.
#[derive(Debug)]
pub(crate) struct Board {
    subscriber: Subscriber<SharedMemory, Health>,
    publisher: Publisher<SharedMemory, Health>,
    blank: Health,
    entries: Vec<Health>,
    said_ns: i64,
}

impl Board {
    /// Joins the health topic.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub(crate) fn new(bus: &Bus<SharedMemory>) -> anyhow::Result<Self> {
        let incarnation = Now::read().mono_ns as u64;
        let topic = messages::health();
        Ok(Self {
            subscriber: bus.subscriber(&topic, || incarnation)?,
            publisher: bus.publisher(&topic, incarnation)?,
            blank: Health {
                incarnation,
                kind: ProcessKind::Launcher as u8,
                ..Health::default()
            },
            entries: Vec::new(),
            said_ns: i64::MIN,
        })
    }

    /// Shows `hear` what processes have said of their lives: process number and state.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(crate) fn read(&mut self, mut hear: impl FnMut(u32, LifeState)) -> anyhow::Result<()> {
        self.subscriber.take(usize::MAX, |_, said| {
            let of_processes = said
                .iter()
                .filter(|health| health.source == NO_SOURCE && health.kind != ProcessKind::Launcher as u8);
            for health in of_processes {
                if let Some(life) = health.life() {
                    hear(health.process_id, life);
                }
            }
        })?;
        Ok(())
    }

    /// Says how the launcher and its children are, if it is time to, or if it is `urgent`.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(crate) fn say(&mut self, now: Now, children: &[Child], urgent: bool) -> anyhow::Result<()> {
        if !urgent && now.mono_ns < self.said_ns.saturating_add(PERIOD_NS) {
            return Ok(());
        }
        self.publish(now, children, LifeState::Running)
    }

    /// Says that the deployment has ended: whoever still reads it should leave.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(crate) fn say_end(&mut self, now: Now, children: &[Child]) -> anyhow::Result<()> {
        self.publish(now, children, LifeState::Finished)
    }

    fn publish(&mut self, now: Now, children: &[Child], life: LifeState) -> anyhow::Result<()> {
        self.said_ns = now.mono_ns;
        let own = Health {
            said_ns: now.mono_ns,
            process_id: std::process::id(),
            life: life as u8,
            ..self.blank
        };
        self.entries.clear();
        self.entries.push(own.with_name(ProcessKind::Launcher.word()));
        self.entries.extend(children.iter().map(|child| {
            let entry = Health {
                process_id: child.pid().unwrap_or(0),
                source: child.part().source,
                life: child.life() as u8,
                restarts: child.restarts(),
                ..own
            };
            let note = child.last_end().map(ToString::to_string).unwrap_or_default();
            entry.with_name(&child.part().name).with_note(&note)
        }));
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: now.mono_ns,
            end: false,
        };
        let entries = &self.entries;
        self.publisher.send(mark, entries.len(), |index, _| entries[index])?;
        Ok(())
    }
}
