//! What every process of a deployment is started with, and the duty cycle it runs.
//!
//! A service is an [`Agent`]: it does a bounded piece of work when asked and says whether there is more. [`run`] asks
//! it again and again, reads the clocks once per turn, publishes its health, and ends the process when it is done or
//! told to stop. The agent itself has no loop and reads no clock, so a test can drive it step by step. [`run_apart`] does
//! the same for an agent whose thread must do nothing else.

use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, BusError, Mark, Publisher, Root, SharedMemory};
use messages::{Counter, Health, LifeState, NO_SOURCE, ProcessKind, Registration};

use crate::clock::{Now, mono_ns};
use crate::cores;
use crate::ground::Visit;
use crate::housekeeping::Housekeeper;
use crate::loopback::loopback_of;
use crate::signals::{self, Stop};

/// Time between two health messages, nanoseconds.
const HEALTH_PERIOD_NS: i64 = 200_000_000;

/// How fast recordings are replayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// Seconds of the recording per second.
    Factor(f64),
    /// As fast as the consumers can follow.
    Max,
}

/// What the processes of a deployment are started with, beside its configuration file.
#[derive(Clone, Debug)]
pub struct Options {
    /// Values that replace those of the file: `key.path=value`.
    pub overrides: Vec<String>,
    /// Name under which the deployment runs; several can run side by side under different names.
    pub instance: String,
    /// Folder with recordings.
    pub data: PathBuf,
    /// Folder for what is recorded.
    pub out: PathBuf,
    /// Replay speed of recorded inputs.
    pub speed: Speed,
    /// Seed of the simulated world.
    pub seed: u64,
    /// When the simulated world began, UTC, nanoseconds.
    pub scenario_start_ns: i64,
    /// Process number of the launcher, if one started this process.
    pub launcher: Option<u32>,
}

/// The parts of a deployment's configuration that every process needs, whatever its work.
pub trait Deployment {
    /// Core that fusion has for itself; `None` if it shares one.
    fn fusion_core(&self) -> Option<usize>;

    /// Midnight of the recordings' first day, UTC, nanoseconds since 1970; `None` without recordings.
    fn first_day_ns(&self) -> Option<i64>;

    /// Visits each topic of the sources and wide-area sensors, every one with so many `publishers`.
    ///
    /// # Errors
    /// The first one of `visit`.
    fn each_input_topic(&self, publishers: usize, visit: &mut impl Visit) -> Result<(), BusError>;
}

/// One process of a deployment, connected and ready.
#[derive(Debug)]
pub struct Process<D> {
    /// Its deployment.
    pub config: D,
    /// How it was started.
    pub options: Options,
    /// Its kind.
    pub kind: ProcessKind,
    /// Its name: that of its source for an adapter, else that of its kind.
    pub name: String,
    /// Its connection to shared memory.
    pub bus: Bus<SharedMemory>,
    /// Monotonic start time, nanoseconds: tells it from an earlier process of the same name.
    pub incarnation: u64,
    /// The loopback address that belongs to its deployment.
    pub loopback: Ipv4Addr,
    stop: Stop,
}

impl<D: Deployment> Process<D> {
    /// Connects a process to its deployment. From now on it ends when its launcher does.
    ///
    /// # Errors
    /// If the deployment does not run, or the operating system refuses something.
    pub fn connect(config: D, options: Options, kind: ProcessKind, name: &str) -> anyhow::Result<Self> {
        let stop = Stop::on_signals().context("catching signals")?;
        if let Some(launcher) = options.launcher
            && !signals::stop_with_parent(launcher).context("following the launcher")?
        {
            anyhow::bail!("the launcher (process {launcher}) is gone");
        }
        // Fusion's core is for fusion alone.
        if kind != ProcessKind::Fusion
            && let Some(core) = config.fusion_core()
        {
            cores::stay_away_from(core);
        }
        let root = Root::new(&options.instance)?;
        let process = format!("{}-{name}", kind.word());
        // Fusion reads one publisher per topic, and again and again.
        let bus = match kind {
            ProcessKind::Fusion => Bus::open_for_few(&root, &process)?,
            _ => Bus::open(&root, &process)?,
        };
        Ok(Self {
            config,
            options,
            kind,
            name: name.to_owned(),
            bus,
            incarnation: mono_ns() as u64,
            loopback: loopback_of(root.path()),
            stop,
        })
    }

    /// Whether the process has been asked to stop.
    pub fn stop_requested(&self) -> bool {
        self.stop.requested()
    }

    /// A health message of this process, with nothing in it yet.
    pub(crate) fn blank_health(&self) -> Health {
        let blank = Health {
            incarnation: self.incarnation,
            process_id: std::process::id(),
            kind: self.kind as u8,
            ..Health::default()
        };
        blank.with_name(&self.name)
    }

    /// Midnight of the day that files count their seconds from, UTC, nanoseconds.
    pub fn first_day_ns(&self) -> i64 {
        let live = || self.options.scenario_start_ns.div_euclid(frames::time::NS_PER_DAY) * frames::time::NS_PER_DAY;
        self.config.first_day_ns().unwrap_or_else(live)
    }
}

/// What a turn of an agent came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// There may be more to do at once.
    Worked,
    /// Nothing to do; look again after this time at the latest.
    Idle(Duration),
    /// All work is done, for good.
    Finished,
}

/// The part of a service that does its work.
pub trait Agent {
    /// Does a bounded piece of work.
    ///
    /// # Errors
    /// If the service cannot go on.
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn>;

    /// Waits for work, `at_most` so long.
    ///
    /// # Errors
    /// If waiting fails.
    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        std::thread::sleep(at_most);
        Ok(())
    }

    /// Says how it is. The first entry speaks of the process as a whole; others may speak of single sources.
    fn health(&self, entries: &mut Vec<HealthEntry>);

    /// The process has been told to stop, or has finished: time to write what is still in memory.
    ///
    /// # Errors
    /// If that fails.
    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        let _ = now;
        Ok(())
    }
}

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
    /// Sets one counter.
    pub fn set(&mut self, counter: Counter, value: u64) {
        self.counters[counter] = value;
    }
}

/// Pauses of a thread that would otherwise never sleep.
///
/// Linux keeps a `SCHED_FIFO` thread that leaves others nothing of its core from running at all for some 50 ms in each
/// second. One that pauses often enough by itself is left alone, and its pauses are short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rest {
    /// Time between two pauses, nanoseconds.
    pub every_ns: i64,
    /// Length of a pause, nanoseconds.
    pub for_ns: u64,
}

/// Runs `agent` until it has finished or the process is told to stop.
///
/// # Errors
/// What the agent could not cope with.
pub fn run<D: Deployment>(process: &Process<D>, agent: &mut dyn Agent) -> anyhow::Result<()> {
    let mut reporter = Reporter::new(&process.bus, process.incarnation, process.blank_health())?;
    let mut entries = Vec::new();
    let result = duty_cycle(&process.stop, agent, None, &mut |agent, now| {
        entries.clear();
        agent.health(&mut entries);
        reporter.publish(now, LifeState::Running, &entries)
    });
    let closed = agent.close(Now::read());
    entries.clear();
    agent.health(&mut entries);
    // Health is best effort at the end: what matters is the error itself.
    let _ = reporter.publish(Now::read(), life_at_end(&result, &closed), &entries);
    result.and(closed)
}

/// Runs `agent` like [`run`] does, with all that is not its work left to `housekeeper`. It pauses as `rest` says.
///
/// # Errors
/// What the agent or the housekeeper could not cope with.
pub fn run_apart<D: Deployment>(
    process: &Process<D>,
    agent: &mut dyn Agent,
    rest: Option<Rest>,
    housekeeper: Housekeeper,
) -> anyhow::Result<()> {
    let result = duty_cycle(&process.stop, agent, rest, &mut |agent, now| {
        housekeeper.say(agent, now)
    });
    let closed = agent.close(Now::read());
    let said = housekeeper.close(agent, Now::read(), life_at_end(&result, &closed));
    // The housekeeper's error first: where it failed, the agent only failed because of it.
    said.and(result).and(closed)
}

fn life_at_end(result: &anyhow::Result<()>, closed: &anyhow::Result<()>) -> LifeState {
    match result.is_err() || closed.is_err() {
        true => LifeState::Failed,
        false => LifeState::Finished,
    }
}

fn duty_cycle(
    stop: &Stop,
    agent: &mut dyn Agent,
    rest: Option<Rest>,
    say: &mut dyn FnMut(&dyn Agent, Now) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut next_health_ns = i64::MIN;
    let mut rested_ns = mono_ns();
    let idle_max_ns = rest.map_or(HEALTH_PERIOD_NS, |rest| rest.every_ns.min(HEALTH_PERIOD_NS));
    let idle_max = Duration::from_nanos(idle_max_ns as u64);
    loop {
        let now = Now::read();
        if now.mono_ns >= next_health_ns {
            say(agent, now)?;
            next_health_ns = now.mono_ns + HEALTH_PERIOD_NS;
        }
        if stop.requested() {
            return Ok(());
        }
        if let Some(rest) = rest
            && now.mono_ns - rested_ns >= rest.every_ns
        {
            std::thread::sleep(Duration::from_nanos(rest.for_ns));
            rested_ns = mono_ns();
        }
        match agent.turn(now)? {
            Turn::Worked => {}
            Turn::Idle(at_most) => agent.wait(at_most.min(idle_max))?,
            Turn::Finished => return Ok(()),
        }
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
