//! Keeper: the launcher's access to shared memory.
//!
//! A process that maps memory written by others can be killed by the contents. The launcher must outlive all children,
//! and therefore maps no such memory. A child does this work: the keeper holds every topic, reclaims the memory of dead
//! processes, receives the children's health messages, and publishes the launcher's facts about the children. The
//! keeper is restarted like any other child. Meanwhile the topics continue to exist, since other processes have opened
//! all topics, and the successor opens the topics before removing the memory of the dead keeper.
//!
//! The launcher's health messages are of kind `launcher`: an entry for the launcher and an entry for each child, with
//! the child's name, process number, source, number of restarts and last end. A child's own message cannot contain
//! these facts, and a dead child publishes none. After the end of all children, the launcher's entry has the state
//! `finished`: readers outside the deployment then leave.

use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Mark, Publisher, SharedMemory, Subscriber};
use messages::{Counter, Counters, Health, LifeState, NO_SOURCE, ProcessKind};
use runtime::Process;
use runtime::instance::hold_topics;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::durable::CheckpointCopier;
use crate::link::{ChildFacts, HealthByProcess, KeeperLink, LauncherFacts, ProcessHealth};

/// Time between two looks while a child starts, and while all run. Nothing here is urgent: the launcher itself observes
/// the ends of children, and the launcher's message about an end wakes the keeper.
const PAUSE: Duration = Duration::from_millis(50);
const CALM_PAUSE: Duration = Duration::from_millis(200);
/// Time between two messages about the children, nanoseconds.
const PERIOD_NS: i64 = 200_000_000;
/// Time between searches for dead processes without a known death, nanoseconds: processes that joined by themselves
/// are not children of the launcher.
const RECLAIM_PERIOD_NS: i64 = 10_000_000_000;

/// Runs the keeper until a stop request.
///
/// # Errors
/// If the parent is no launcher, or if a topic cannot be held.
pub fn run(process: &Process) -> anyhow::Result<()> {
    let link =
        KeeperLink::of_keeper().context("only `koseki up` and `koseki demo` start a keeper, at the end of a socket")?;
    let _held = hold_topics(&process.config, &process.bus)?;
    let folder = process.bus.root().path();
    let written = process.config.write_into(folder);
    written.with_context(|| format!("writing the configuration into {}", folder.display()))?;
    let copies = process.config.checkpoint.copies();
    let copying = copies.map(|(folder, every)| CheckpointCopier::start(process.bus.root().clone(), folder, every));
    let copier = copying.transpose()?;
    let topic = messages::health();
    let mut keeper = Keeper {
        bus: &process.bus,
        link,
        copier,
        launcher: process.options.launcher.unwrap_or_default(),
        subscriber: process.bus.subscriber(&topic, || process.incarnation)?,
        // The epoch differs from the epoch of the process's own health messages on the same topic: readers on other
        // hosts identify publishers by the epoch.
        publisher: process.bus.publisher(&topic, process.incarnation + 1)?,
        facts: None,
        heard: HealthByProcess::default(),
        reclaimed: None,
        reclaimed_ns: i64::MIN,
        published_ns: i64::MIN,
    };
    runtime::service::run(process, &mut keeper)
}

struct Keeper<'a> {
    bus: &'a Bus<SharedMemory>,
    link: KeeperLink,
    /// Copies to disk, if configured.
    copier: Option<CheckpointCopier>,
    /// Process number of the launcher.
    launcher: u32,
    subscriber: Subscriber<SharedMemory, Health>,
    publisher: Publisher<SharedMemory, Health>,
    facts: Option<LauncherFacts>,
    heard: HealthByProcess,
    /// Number of deaths after which memory has been reclaimed.
    reclaimed: Option<u64>,
    /// Time of the latest reclamation.
    reclaimed_ns: i64,
    published_ns: i64,
}

impl Agent for Keeper<'_> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let has_news = self.listen_to_launcher();
        self.reclaim(now);
        self.listen_to_processes()?;
        if has_news || now.mono_ns >= self.published_ns.saturating_add(PERIOD_NS) {
            self.publish(now)?;
        }
        if self.link.say(&self.heard) {
            self.heard.clear();
        }
        Ok(Turn::Idle(if self.is_calm() { CALM_PAUSE } else { PAUSE }))
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        self.link.wait(at_most);
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let failure = self.copier.as_ref().and_then(CheckpointCopier::failure);
        let mut entry = HealthEntry::default();
        entry.set(Counter::CopiesFailing, u64::from(failure.is_some()));
        entry.note = failure.unwrap_or_default();
        entries.push(entry);
    }

    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        self.listen_to_launcher();
        self.publish(now)
    }
}

impl Keeper<'_> {
    /// Whether all children run, and none is being stopped.
    fn is_calm(&self) -> bool {
        let runs = |child: &ChildFacts| child.life == LifeState::Running as u8;
        let facts = self.facts.as_ref().filter(|facts| !facts.stopping);
        facts.is_some_and(|facts| facts.children.iter().all(runs))
    }

    fn listen_to_launcher(&mut self) -> bool {
        let mut has_news = false;
        while let Some(facts) = self.link.hear() {
            self.facts = Some(facts);
            has_news = true;
        }
        has_news
    }

    /// Reclaims memory of dead processes after each death, and from time to time that of other processes. The first
    /// call reclaims the memory of the keeper's own predecessor.
    fn reclaim(&mut self, now: Now) {
        let Some(deaths) = self.facts.as_ref().map(|facts| facts.deaths) else {
            return;
        };
        let due = self.reclaimed != Some(deaths) || now.mono_ns >= self.reclaimed_ns.saturating_add(RECLAIM_PERIOD_NS);
        if due && self.bus.remove_dead().failed == 0 {
            (self.reclaimed, self.reclaimed_ns) = (Some(deaths), now.mono_ns);
        }
    }

    fn listen_to_processes(&mut self) -> anyhow::Result<()> {
        let heard = &mut self.heard;
        self.subscriber.take(usize::MAX, |_, slice| {
            let launcher = ProcessKind::Launcher as u8;
            let of_processes = slice
                .iter()
                .filter(|health| health.source == NO_SOURCE && health.kind != launcher);
            heard.extend(of_processes.map(|health| {
                let said = ProcessHealth {
                    life: health.life,
                    said_ns: health.said_ns,
                    has_reports: health.kind == ProcessKind::Fusion as u8 && health.counters[Counter::Taken] > 0,
                };
                (health.process_id, said)
            }));
        })?;
        Ok(())
    }

    fn publish(&mut self, now: Now) -> anyhow::Result<()> {
        self.published_ns = now.mono_ns;
        let Some(facts) = &self.facts else { return Ok(()) };
        let life = if facts.ended {
            LifeState::Finished
        } else {
            LifeState::Running
        };
        let own = Health {
            said_ns: now.mono_ns,
            incarnation: facts.incarnation,
            process_id: self.launcher,
            kind: ProcessKind::Launcher as u8,
            life: life as u8,
            counters: Counters::default()
                .with(Counter::Rebuilds, facts.rebuilds)
                .with(Counter::Stopping, facts.stopping.into()),
            ..Health::default()
        };
        let of_child = |index: usize| {
            let child = &facts.children[index];
            let entry = Health {
                process_id: child.process_id,
                source: child.source,
                life: child.life,
                restarts: child.restarts,
                counters: Counters::default(),
                ..own
            };
            entry.with_name(&child.name).with_note(&child.last_end)
        };
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: now.mono_ns,
            end: false,
        };
        let entries = 1 + facts.children.len();
        self.publisher.send(mark, entries, |index, _| match index {
            0 => own.with_name(ProcessKind::Launcher.word()),
            _ => of_child(index - 1),
        })?;
        Ok(())
    }
}
