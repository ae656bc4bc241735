//! Work that a real-time loop must not do itself (PL-6).
//!
//! A loop with a response time of microseconds cannot publish its own health: each wake-up of a listener is a system
//! call. Nor can the loop search shared memory for orders in every turn, or join a second topic after a fault. A
//! second thread, the *housekeeper*, does all of this. Both threads exchange data through bounded queues without
//! locks:
//!
//! ```text
//!   loop ── counters, five times a second ─────────▶ housekeeper ──▶ topic `health`
//!   loop ◀── emptied buffers ────────────────────── housekeeper
//!   loop ◀── orders ─────────────────────────────── housekeeper ◀── topic `orders`
//!   loop ── states of orders ──────────────────────▶ housekeeper ──▶ topic `system/order-states`
//!   loop ── decisions, on request ─────────────────▶ housekeeper ──▶ topic `system/decisions`
//!   loop ── snapshots of the engine ───────────────▶ housekeeper ──▶ topic `system/restored`
//!   loop ── reports in quarantine ─────────────────▶ housekeeper ──▶ a file in the base folder
//! ```
//!
//! The loop allocates nothing: two buffers go back and forth. If the housekeeper does not run for a while, the loop
//! continues, and the next message contains all counts, since counters only grow. An order that finds the queue full
//! is refused.
//!
//! The housekeeper starts before the loop takes its core and priority, which threads inherit, and stays off that
//! core.

use std::fs::OpenOptions;
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock, mpsc};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Mark, Publisher, Root, SharedMemory};
use crossbeam_queue::ArrayQueue;
use messages::layout::Sample as _;
use messages::{Decision, Health, LifeState, Restored, SensorTrack};

use crate::agent::Agent;
use crate::clock::{Now, mono_ns};
use crate::cores;
use crate::health::{HealthEntry, Reporter};
use crate::instance::QUARANTINED;
use crate::order_desk::OrderDesk;
use crate::pause::LookPause;
use crate::process::Process;
pub use crate::queues::{Queues, SnapshotParts};

/// Number of buffers for health entries.
const BUFFERS: usize = 2;
/// Number of slices of a snapshot published at a time. A slow reader loses none of the slices, for a snapshot of any
/// size.
const RESTORED_SLICES: usize = 4;
/// Pauses of the housekeeper: while there is work other than health, or there may be decisions, and while there is
/// none.
const PAUSE: Duration = Duration::from_millis(10);
const IDLE_PAUSE: Duration = Duration::from_millis(200);
/// Pause while the loop does not lead: it obeys no orders and makes nothing but health.
const STANDBY_PAUSE: Duration = Duration::from_millis(500);

/// Loop's side of a housekeeper.
#[derive(Debug)]
pub struct Housekeeper {
    desk: Arc<Desk>,
    thread: Option<JoinHandle<anyhow::Result<()>>>,
}

/// Data between the two threads.
#[derive(Debug)]
struct Desk {
    spare: ArrayQueue<Vec<HealthEntry>>,
    said: ArrayQueue<LoopHealth>,
    queues: Arc<Queues>,
    closing: AtomicBool,
    /// Fault that health messages state.
    note: OnceLock<String>,
}

/// Health of the loop at one moment.
#[derive(Debug)]
struct LoopHealth {
    now: Now,
    life: LifeState,
    entries: Vec<HealthEntry>,
}

impl Housekeeper {
    /// Starts the housekeeper of `process`, whose loop will run on `core`, if the loop has a core of its own.
    /// Messages have up to `entries_max` entries. `queues` carries orders to the loop and data for publication from
    /// the loop.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub fn start(
        process: &Process,
        core: Option<usize>,
        entries_max: usize,
        queues: Arc<Queues>,
    ) -> anyhow::Result<Self> {
        let house = House {
            root: process.bus.root().clone(),
            name: format!("{}-{}-housekeeping", process.kind.word(), process.name),
            incarnation: process.incarnation,
            blank: process.blank_health(),
        };
        Self::start_in(house, core, entries_max, queues)
    }

    fn start_in(house: House, core: Option<usize>, entries_max: usize, queues: Arc<Queues>) -> anyhow::Result<Self> {
        let desk = Arc::new(Desk {
            spare: ArrayQueue::new(BUFFERS),
            said: ArrayQueue::new(BUFFERS),
            queues,
            closing: AtomicBool::new(false),
            note: OnceLock::new(),
        });
        for _ in 0..BUFFERS {
            // As many as have a place.
            let _ = desk.spare.push(Vec::with_capacity(entries_max));
        }
        let (ready, is_ready) = mpsc::channel();
        let thread_desk = Arc::clone(&desk);
        let thread = std::thread::Builder::new()
            .name("housekeeping".to_owned())
            .spawn(move || {
                if let Some(core) = core {
                    cores::stay_away_from(core);
                }
                house.keep(&thread_desk, &ready)
            })
            .context("starting the housekeeping thread")?;
        let mut housekeeper = Self {
            desk,
            thread: Some(thread),
        };
        // An error means that the thread ended before it was ready: joining the thread returns the cause.
        if is_ready.recv().is_err() {
            housekeeper.join()?;
        }
        Ok(housekeeper)
    }

    /// Sets the fault that health messages state from now on. Only the first call has an effect.
    pub fn set_note(&self, note: String) {
        let _ = self.desk.note.set(note);
    }

    /// Hands the counts of `agent` to the housekeeper, if a buffer is free. No allocation, no system call.
    ///
    /// # Errors
    /// If the housekeeper has ended: a process without health and orders must be restarted. [`Self::close`] returns
    /// the cause.
    pub(crate) fn say(&self, agent: &dyn Agent, now: Now) -> anyhow::Result<()> {
        let ended = self.thread.as_ref().is_none_or(JoinHandle::is_finished);
        anyhow::ensure!(!ended, "the housekeeping thread has ended");
        if let Some(mut entries) = self.desk.spare.pop() {
            agent.health(&mut entries);
            let life = LifeState::Running;
            // The queue has as many places as there are buffers.
            let _ = self.desk.said.push(LoopHealth { now, life, entries });
        }
        Ok(())
    }

    /// Publishes the last state of `agent` and ends the thread.
    pub(crate) fn close(mut self, agent: &dyn Agent, now: Now, life: LifeState) -> anyhow::Result<()> {
        let mut entries = Vec::new();
        agent.health(&mut entries);
        // The last state replaces a state that is not published yet.
        self.desk.said.force_push(LoopHealth { now, life, entries });
        self.join()
    }

    fn join(&mut self) -> anyhow::Result<()> {
        self.desk.closing.store(true, Ordering::Release);
        if let Some(thread) = &self.thread {
            thread.thread().unpark();
        }
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result.context("housekeeping"),
            Some(Err(_)) => anyhow::bail!("the housekeeping thread panicked"),
            None => Ok(()),
        }
    }
}

impl Drop for Housekeeper {
    fn drop(&mut self) {
        // Only without a call of `close`: otherwise the error is reported already.
        let _ = self.join();
    }
}

/// Arguments with which the housekeeper's thread opens its topics.
struct House {
    root: Root,
    name: String,
    incarnation: u64,
    blank: Health,
}

impl House {
    /// Opens the topics, signals `ready`, and works until the desk is closed.
    fn keep(self, desk: &Desk, ready: &mpsc::Sender<()>) -> anyhow::Result<()> {
        let bus: Bus<SharedMemory> = Bus::open(&self.root, &self.name)?;
        let reporter = Reporter::new(&bus, self.incarnation, self.blank)?;
        let order_desk = OrderDesk::open(&bus, self.incarnation)?;
        let publish = |_: &_| bus.publisher(&messages::decisions(), self.incarnation);
        let decisions = desk.queues.decisions.as_ref().map(publish).transpose()?;
        let whole = WholeSaid {
            bus: &bus,
            incarnation: self.incarnation,
            publisher: None,
            whole: SnapshotParts::default(),
            said: 0,
        };
        desk.queues.keep(std::thread::current());
        // The starter of this thread waits for the signal.
        let _ = ready.send(());
        keep_house(desk, reporter, order_desk, decisions, whole)
    }
}

/// Snapshot in publication.
struct WholeSaid<'a> {
    bus: &'a Bus<SharedMemory>,
    incarnation: u64,
    /// The publisher stays open: a reader loses samples of a publisher that opens and closes between two of its
    /// turns.
    publisher: Option<Publisher<SharedMemory, Restored>>,
    whole: SnapshotParts,
    said: usize,
}

impl WholeSaid<'_> {
    /// Publishes the next parts.
    ///
    /// Returns whether there were any.
    fn go_on(&mut self, queue: &ArrayQueue<SnapshotParts>) -> anyhow::Result<bool> {
        if self.said == self.whole.parts() {
            (self.whole, self.said) = (queue.pop().unwrap_or_default(), 0);
        }
        let left = self.whole.parts() - self.said;
        if left == 0 {
            return Ok(false);
        }
        if self.publisher.is_none() {
            let publisher = self.bus.publisher(&messages::restored(), self.incarnation)?;
            self.publisher = Some(publisher.with_epoch(self.whole.epoch));
        }
        let Some(publisher) = &mut self.publisher else {
            return Ok(false);
        };
        let count = (RESTORED_SLICES * publisher.slice_len()).min(left);
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: mono_ns(),
            end: false,
        };
        publisher.send(mark, count, |place, sequence| Restored {
            sequence,
            ..self.whole.part(self.said + place)
        })?;
        self.said += count;
        Ok(true)
    }
}

fn keep_house(
    desk: &Desk,
    mut reporter: Reporter,
    mut order_desk: OrderDesk,
    mut decisions: Option<Publisher<SharedMemory, Decision>>,
    mut whole: WholeSaid<'_>,
) -> anyhow::Result<()> {
    // The loop wakes nobody: recorded decisions of a whole pause have to fit into their topic.
    let longest = if desk.queues.records_decisions() {
        PAUSE
    } else {
        IDLE_PAUSE
    };
    let mut pause = LookPause::between(PAUSE, longest);
    loop {
        // Read before the queue is emptied: entries queued before the close are published.
        let closing = desk.closing.load(Ordering::Acquire);
        while let Some(name) = desk.queues.names.pop() {
            reporter.rename(name);
        }
        while let Some(mut said) = desk.said.pop() {
            if let (Some(note), Some(whole)) = (desk.note.get(), said.entries.first_mut()) {
                whole.note.clone_from(note);
            }
            reporter.publish(said.now, said.life, &said.entries)?;
            // Emptied here: the loop must not free memory either.
            said.entries.clear();
            // The queue has as many places as there are buffers; the buffer of the last state was made in addition.
            let _ = desk.spare.push(said.entries);
        }
        let mut worked = false;
        if let (Some(queue), Some(publisher)) = (&desk.queues.decisions, &mut decisions) {
            // A display is content with decisions that are late by a pause.
            worked |= !queue.is_empty() && desk.queues.records_decisions();
            publish_decisions(queue, publisher)?;
        }
        worked |= whole.go_on(&desk.queues.restored)?;
        while let Some(report) = desk.queues.quarantined.pop() {
            write_quarantined(whole.bus.root(), &report);
            worked = true;
        }
        worked |= order_desk.turn(&desk.queues, Now::read())?;
        if closing {
            return Ok(());
        }
        let pause = pause.after(worked);
        // Ends early when the desk closes, and when the loop begins to lead.
        std::thread::park_timeout(if desk.queues.leads() { pause } else { STANDBY_PAUSE });
    }
}

/// Appends a report in quarantine, as the bytes of its sample, to a file in the base folder.
fn write_quarantined(root: &Root, report: &SensorTrack) {
    let path = root.base().join(format!("{}.report-{QUARANTINED}", root.instance()));
    let file = OpenOptions::new().create(true).append(true).open(&path);
    let written = file.and_then(|mut file| file.write_all(SensorTrack::octets(std::slice::from_ref(report))));
    let what = format!(
        "fusion died twice in the same report (source {}, track {}, number {}); the report is in quarantine",
        report.source, report.track_number, report.sequence
    );
    match written {
        Ok(()) => crate::notice(format_args!(
            "warning: {what}; the report is in {}, the checkpoint before it in {}.checkpoint-{QUARANTINED} beside it",
            path.display(),
            root.instance()
        )),
        Err(error) => crate::notice(format_args!(
            "warning: {what}; writing the report to {} failed: {error}",
            path.display()
        )),
    }
}

/// Publishes waiting decisions, at most one queue full: the loop makes new decisions meanwhile.
fn publish_decisions(
    queue: &ArrayQueue<Decision>,
    publisher: &mut Publisher<SharedMemory, Decision>,
) -> anyhow::Result<()> {
    let mut waiting = queue.len();
    while waiting > 0 {
        let count = waiting.min(publisher.slice_len());
        waiting -= count;
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: mono_ns(),
            end: false,
        };
        let epoch = publisher.incarnation();
        publisher.send(mark, count, |_, sequence| Decision {
            sequence,
            epoch,
            // No other thread takes from this queue.
            ..queue.pop().unwrap_or_default()
        })?;
    }
    Ok(())
}
