//! Standby of fusion, and take-over.
//!
//! Of two fusion processes, a single process *leads*: the leader holds the leader lock, fuses and publishes. The other
//! is the *standby*, with allocated tables and open topics. The standby reads from the leader's checkpoint how many
//! reports of each source are finished, and keeps the others in its queues. The standby publishes no track and never
//! spins.
//!
//! ```text
//!   leader  ──▶ checkpoint: tracks, numbers, positions, a sign of life each millisecond (idle: every 20 ms)
//!      │             │
//!      │ lock        ▼ every 5 to 100 ms, by the number of reports
//!   standby: drops the reports that the leader has finished; is the leader's process gone? its sign of life old?
//!      │
//!      └─ gone: the lock is free      old: SIGKILL, then the lock is free
//!                 └──────────┬─────────┘
//!                            ▼
//!         resumes from the checkpoint, as a new epoch, with the remaining reports
//! ```
//!
//! There are never two leaders: the kernel releases the lock at any end of the process. A hung leader is killed before
//! continuing, and its epoch separates any late state from the successor's states. A restarted former leader becomes
//! the standby; the lead does not return.
//!
//! A stall of the whole machine stops both processes. The leader's sign of life therefore counts as old only if this
//! process has looked again after a long look: see [`StandbyLooks`].

use std::fs::{File, OpenOptions, TryLockError};
use std::time::Duration;

use anyhow::Context as _;
use bus::{Outlasting, SharedMemory};
use fusion::checkpoint::{CheckpointClock, CheckpointLayout, clock_of, position_of};
use runtime::Now;
use runtime::Process;
use runtime::clock::mono_ns;
use runtime::instance::{CHECKPOINT, FUSION_LEADS, leading_fusion};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::OwnedFd;
use rustix::process::{Pid, PidfdFlags, Signal, pidfd_open, pidfd_send_signal};

use crate::agent::Ready;
use crate::continuity::TakeOver;
use crate::inputs::SourceInput;
use crate::standby_looks::StandbyLooks;

/// Time between two looks without a leader, or at the leader's end.
const BRIEF: Duration = Duration::from_millis(1);
/// Time for which a process that starts as standby leaves the lead to another process.
const COURTESY: Duration = Duration::from_secs(3);
/// Permitted silence of a leader that has just begun: the leader fills tables while other processes start.
const BEGINS: Duration = Duration::from_secs(1);
/// Time in which a leader has taken all reports sent, nanoseconds: far longer than needed.
const TAKEN_NS: i64 = 1_000_000_000;
/// Slices between two looks from which on the next look is soon, so that no queue of 256 slices overflows. The pause
/// doubles at most after a look, and so does this number.
const MANY_SLICES: u64 = 32;
/// Name of the standby process.
pub(crate) const NAME: &str = "standby";

/// Leader lock file.
#[derive(Debug)]
pub(crate) struct LeadLock(File);

/// Leader lock, which the kernel gives to a single process at a time.
#[derive(Debug)]
pub(crate) struct Lead {
    _lock: File,
}

impl LeadLock {
    /// Creates the lock of the process's instance.
    ///
    /// # Errors
    /// If the lock file cannot be created.
    pub(crate) fn open(process: &Process) -> anyhow::Result<Self> {
        let path = process.bus.root().path().join(FUSION_LEADS);
        let mut options = OpenOptions::new();
        let opened = options.read(true).write(true).create(true).truncate(false).open(&path);
        Ok(Self(opened.with_context(|| format!("opening {}", path.display()))?))
    }
}

/// Standby fusion.
#[derive(Debug)]
pub(crate) struct StandbyFusion {
    takeover_ns: i64,
    lock: LeadLock,
    ready: Ready<SharedMemory>,
    layout: CheckpointLayout,
    leader: Option<Leader>,
    looks: StandbyLooks,
    /// Slices received from all sources, at the last look.
    slices: u64,
    /// Time until which the lead is left to another process.
    courteous_until_ns: i64,
    /// Whether a leader was observed.
    has_followed: bool,
    /// Whether the leader was killed after a hang.
    killed: bool,
}

#[derive(Debug)]
struct Leader {
    memory: Outlasting,
    clock: CheckpointClock,
    process: OwnedFd,
    /// Time at which the process was first observed as leader, monotonic, nanoseconds.
    since_ns: i64,
}

impl Leader {
    /// Waits for the end of the process, at most for `at_most`; the next look reports faults.
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

impl StandbyFusion {
    /// Creates the standby with all that is `ready`.
    pub(crate) fn new(
        process: &Process,
        takeover_ns: i64,
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
            takeover_ns,
            lock,
            layout: ready.engine.checkpoint_layout(),
            ready,
            leader: None,
            looks: StandbyLooks::new(takeover_ns, now.mono_ns),
            slices: 0,
            courteous_until_ns: now.mono_ns.saturating_add(courtesy_ns),
            has_followed: false,
            killed: false,
        }
    }

    /// Engine and ports, ready to lead.
    pub(crate) fn into_ready(self) -> Ready<SharedMemory> {
        self.ready
    }

    /// Looks at the leader. Returns the lead, if it belongs to this process now, and the way in which the lead was
    /// obtained.
    ///
    /// # Errors
    /// If the lock or a topic fails.
    pub(crate) fn look(&mut self, process: &Process, now: Now) -> anyhow::Result<Option<(Lead, TakeOver)>> {
        let lock = &self.lock.0;
        match lock.try_lock() {
            Ok(()) if now.mono_ns < self.courteous_until_ns && !self.has_followed => lock.unlock()?,
            Ok(()) => {
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
        if self.leader.as_ref().is_none_or(Leader::is_gone) {
            self.find(process, now);
        }
        let Some(leader) = &mut self.leader else {
            return Ok(());
        };
        let done_ns = leader.clock.turn_ns.saturating_sub(TAKEN_NS);
        for input in &mut self.ready.inputs {
            let done = position_of(leader.memory.words(), &self.layout, input.source);
            input.follow(done, done_ns, mono_ns)?;
        }
        let slices: u64 = self.ready.inputs.iter().map(SourceInput::slices).sum();
        let arrived = slices.saturating_sub(std::mem::replace(&mut self.slices, slices));
        let clock = clock_of(leader.memory.words(), &self.layout).unwrap_or(leader.clock);
        let sign = (clock != leader.clock).then_some(clock.turn_ns);
        self.looks.note(now.mono_ns, sign, arrived >= MANY_SLICES);
        leader.clock = clock;
        let begins = now.mono_ns.saturating_sub(leader.since_ns) < COURTESY.as_nanos() as i64;
        let least_ns = if begins { BEGINS.as_nanos() as i64 } else { 0 };
        if self.looks.leader_hangs(least_ns) && !self.killed {
            self.killed = true;
            // Fails only if the process has ended, as intended.
            let _ = pidfd_send_signal(&leader.process, Signal::KILL);
        }
        Ok(())
    }

    /// Finds the leading process, once its number has been written.
    fn find(&mut self, process: &Process, now: Now) {
        self.leader = None;
        let Ok(Some(memory)) = process.bus.root().outlasting(CHECKPOINT) else {
            return;
        };
        // The entry is of another process, or of a leader that is gone.
        let Some(clock) = clock_of(memory.words(), &self.layout) else {
            return;
        };
        let pid = i32::try_from(clock.process_id).ok().and_then(Pid::from_raw);
        let opened = pid.and_then(|pid| pidfd_open(pid, PidfdFlags::empty()).ok());
        // The number may belong to another process by now. A process that still writes signs of life to the checkpoint
        // is the leader, since only the lock's holder writes. A leader that hung before any observation writes none:
        // then the kernel's list of locks decides.
        let lives = |memory: &Outlasting| {
            let noted = clock_of(memory.words(), &self.layout).map_or(0, |clock| clock.turn_ns);
            mono_ns().saturating_sub(noted) < self.takeover_ns
        };
        let leads = || leading_fusion(process.bus.root()) == Some(clock.process_id);
        if let Some(process) = opened.filter(|_| lives(&memory) || leads()) {
            self.leader = Some(Leader {
                memory,
                clock,
                process,
                since_ns: mono_ns(),
            });
            self.looks.begin(now.mono_ns);
            (self.has_followed, self.killed) = (true, false);
        }
    }

    /// Time until the next look.
    pub(crate) fn pause(&self) -> Duration {
        self.looks.pause()
    }

    /// Waits for the end of the leader's process, at most for `at_most`.
    pub(crate) fn wait(&self, at_most: Duration) {
        let time = at_most.min(self.pause());
        match &self.leader {
            Some(leader) if !self.killed => {
                leader.wait(time);
            }
            _ => std::thread::sleep(time.min(BRIEF)),
        }
    }
}
