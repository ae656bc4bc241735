//! The fusion that stands by, and how it takes over.
//!
//! Of two fusion processes one *leads*: it holds a lock, fuses and publishes. The other one stands by: it has all its
//! tables allocated and its topics open, follows in the leader's checkpoint how far each source's reports have been
//! worked off, and keeps in its own queues what has not. It publishes no track and never spins.
//!
//! ```text
//!  leader  ──▶ checkpoint: tracks, numbers, positions, a note each millisecond
//!     │             │
//!     │ lock        ▼ every 5 ms
//!  standby: passes over what the leader has worked off; is the leader's process gone? its note old?
//!     │
//!     └─ gone: the lock is free      old: SIGKILL, then the lock is free
//!                └──────────┬─────────┘
//!                           ▼
//!        goes on from the checkpoint, as a new epoch, with the reports that are left
//! ```
//!
//! There are never two leaders: the lock is the system's, which gives it back when the process is gone, however it
//! ends. A leader that only stood still is killed before it can go on; what it had in its hands is fenced by its epoch.
//!
//! A machine that stalls as a whole stalls both. So the leader's note is old only if this process has seen it so while
//! it ran itself: a look that comes late counts as one pause.

use std::fs::{File, OpenOptions, TryLockError};
use std::time::Duration;

use anyhow::Context as _;
use bus::{Outlasting, SharedMemory};
use configuration::{Process, Standby as Settings};
use fusion::checkpoint::{Clock, Layout, clock_of, position_of};
use messages::Control;
use runtime::Now;
use runtime::clock::mono_ns;
use runtime::housekeeping::Queues;
use runtime::instance::{CHECKPOINT, FUSION_LEADS, leading_fusion};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::OwnedFd;
use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};

use crate::agent::Ready;
use crate::continuity::TakeOver;

/// Time between two looks at the leader.
pub(crate) const LOOK: Duration = Duration::from_millis(5);
/// The same while there is no leader, or it is about to be gone.
const BRIEF: Duration = Duration::from_millis(1);
/// Time for which a process that is to stand by at its start leaves the lead to another.
const COURTESY: Duration = Duration::from_secs(3);
/// A leader that has just begun may stand still for so long: it has its tables to fill, beside all others that start.
const BEGINS: Duration = Duration::from_secs(1);
/// Time in which a leader has taken what was sent to it, nanoseconds: far longer than it takes.
const TAKEN_NS: i64 = 1_000_000_000;
/// Name of the process that stands by.
pub(crate) const NAME: &str = "standby";

/// Lock that the fusion that leads holds.
#[derive(Debug)]
pub(crate) struct LeadLock(File);

/// The right to lead, of which the system makes sure that one process at a time has it.
#[derive(Debug)]
pub(crate) struct Lead {
    _lock: File,
}

impl LeadLock {
    /// The lock of the process's instance.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(crate) fn open(process: &Process) -> anyhow::Result<Self> {
        let path = process.bus.root().path().join(FUSION_LEADS);
        let mut options = OpenOptions::new();
        let opened = options.read(true).write(true).create(true).truncate(false).open(&path);
        Ok(Self(opened.with_context(|| format!("opening {}", path.display()))?))
    }
}

/// A fusion that stands by.
#[derive(Debug)]
pub(crate) struct Standby {
    settings: Settings,
    lock: LeadLock,
    ready: Ready<SharedMemory>,
    layout: Layout,
    leader: Option<Leader>,
    /// How long the leader's note has not changed, as far as this process ran.
    still_ns: i64,
    looked_ns: i64,
    /// Until when the lead is left to another.
    courteous_until_ns: i64,
    /// Whether a leader was seen.
    has_followed: bool,
    /// The last order that was obeyed: a leader may die before it has kept what came of it.
    order: Option<Control>,
    /// Whether the leader was killed because it stood still.
    killed: bool,
}

#[derive(Debug)]
struct Leader {
    memory: Outlasting,
    clock: Clock,
    process: OwnedFd,
    /// Monotonic time at which it was first seen to lead, nanoseconds.
    since_ns: i64,
}

impl Leader {
    /// Waits until the process is gone, or so long; what goes wrong shows in the next look.
    fn wait(&self, time: Duration) -> bool {
        let timeout = Timespec {
            tv_sec: 0,
            tv_nsec: i64::from(time.subsec_nanos()),
        };
        poll(&mut [PollFd::new(&self.process, PollFlags::IN)], Some(&timeout)).is_ok_and(|ended| ended > 0)
    }

    fn is_gone(&self) -> bool {
        self.wait(Duration::ZERO)
    }
}

impl Standby {
    /// Stands by, with all that is `ready`, for whoever leads.
    pub(crate) fn new(
        process: &Process,
        settings: Settings,
        lock: LeadLock,
        ready: Ready<SharedMemory>,
        now: Now,
    ) -> Self {
        let courtesy_ns = if process.name == NAME {
            COURTESY.as_nanos() as i64
        } else {
            0
        };
        Self {
            settings,
            lock,
            layout: ready.engine.checkpoint_layout(),
            ready,
            leader: None,
            still_ns: 0,
            looked_ns: now.mono_ns,
            courteous_until_ns: now.mono_ns.saturating_add(courtesy_ns),
            has_followed: false,
            order: None,
            killed: false,
        }
    }

    /// Engine and ports, ready to lead with.
    pub(crate) fn into_ready(self) -> Ready<SharedMemory> {
        self.ready
    }

    /// Looks at the leader. The lead, if it is this process's now, and how it was come by.
    ///
    /// # Errors
    /// If the lock or a topic fails.
    pub(crate) fn look(
        &mut self,
        process: &Process,
        queues: &Queues,
        now: Now,
    ) -> anyhow::Result<Option<(Lead, TakeOver)>> {
        while let Some(order) = queues.orders.pop() {
            if order.kind == Control::CONDITION {
                self.order = Some(order);
            }
        }
        let lock = &self.lock.0;
        match lock.try_lock() {
            Ok(()) if now.mono_ns < self.courteous_until_ns && !self.has_followed => lock.unlock()?,
            Ok(()) => {
                if let Some(order) = self.order.take() {
                    // There is room: they were all taken.
                    let _ = queues.orders.push(order);
                }
                let how = TakeOver {
                    from_another: self.has_followed,
                    stood_still: self.killed,
                };
                let lead = Lead {
                    _lock: lock.try_clone()?,
                };
                return Ok(Some((lead, how)));
            }
            Err(TryLockError::WouldBlock) => self.follow(process, now)?,
            Err(TryLockError::Error(error)) => return Err(error.into()),
        }
        Ok(None)
    }

    fn follow(&mut self, process: &Process, now: Now) -> anyhow::Result<()> {
        let elapsed_ns = (now.mono_ns - self.looked_ns).min(2 * LOOK.as_nanos() as i64);
        self.looked_ns = now.mono_ns;
        if self.leader.as_ref().is_none_or(Leader::is_gone) {
            self.find(process);
        }
        let Some(leader) = &mut self.leader else {
            return Ok(());
        };
        let done_ns = leader.clock.turn_ns.saturating_sub(TAKEN_NS);
        for input in &mut self.ready.inputs {
            let done = position_of(leader.memory.words(), &self.layout, input.source);
            input.follow(done, done_ns, mono_ns)?;
        }
        let clock = clock_of(leader.memory.words(), &self.layout).unwrap_or(leader.clock);
        self.still_ns = match clock == leader.clock {
            true => self.still_ns.saturating_add(elapsed_ns),
            false => 0,
        };
        leader.clock = clock;
        let begins = now.mono_ns.saturating_sub(leader.since_ns) < COURTESY.as_nanos() as i64;
        let least_ns = if begins { BEGINS.as_nanos() as i64 } else { 0 };
        if self.still_ns >= self.settings.takeover_ns.max(least_ns) && !self.killed {
            self.killed = true;
            // It fails only if the process has ended, which is what is wanted.
            let _ = pidfd_send_signal(&leader.process, Signal::KILL);
        }
        Ok(())
    }

    /// Finds the process that leads, once it has said who it is.
    fn find(&mut self, process: &Process) {
        self.leader = None;
        let Ok(Some(memory)) = process.bus.root().outlasting(CHECKPOINT) else {
            return;
        };
        // Another one's, or that of a leader that is gone.
        let Some(clock) = clock_of(memory.words(), &self.layout) else {
            return;
        };
        let pid = i32::try_from(clock.process_id).ok().and_then(Pid::from_raw);
        let opened = pid.and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
        // The number may be another process's by now, unless that one still makes notes in the checkpoint: then it is
        // the leader, since it holds the lock. One that stood still before it was ever seen makes none: then the system
        // says who holds the lock.
        let lives = |memory: &Outlasting| {
            let noted = clock_of(memory.words(), &self.layout).map_or(0, |clock| clock.turn_ns);
            mono_ns().saturating_sub(noted) < self.settings.takeover_ns
        };
        let leads = || leading_fusion(process.bus.root()) == Some(clock.process_id);
        if let Some(process) = opened.filter(|_| lives(&memory) || leads()) {
            self.leader = Some(Leader {
                memory,
                clock,
                process,
                since_ns: mono_ns(),
            });
            (self.still_ns, self.has_followed, self.killed) = (0, true, false);
        }
    }

    /// Waits until the leader's process is gone, or `at_most` so long.
    pub(crate) fn wait(&self, at_most: Duration) {
        let time = at_most.min(LOOK);
        match &self.leader {
            Some(leader) if !self.killed => {
                leader.wait(time);
            }
            _ => std::thread::sleep(time.min(BRIEF)),
        }
    }
}
