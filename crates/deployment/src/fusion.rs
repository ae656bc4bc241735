//! Keys of the fusion process, and of the memory that outlasts it.
//!
//! They stand here and not in the process's crate: the launcher, the monitor, adapters and commands use them, too.

use std::path::PathBuf;
use std::time::Duration;

use settings::{Seconds, SettingsError};

settings::settings! {
    /// The fusion process.
    pub struct Fusion {
        /// Kind of waiting for work: `spin` polls without a pause and uses a whole core; `event` sleeps until
        /// notified; `hybrid` does both in turn.
        wait: WaitWord = WaitWord::Event;
        /// Time for which `hybrid` spins.
        hybrid_spin_us: f64 = 20.0, in [0.1, 1e6];
        /// Core to run on.
        core: Option<usize> = None, usually "any";
        /// `SCHED_FIFO` priority.
        realtime_priority: Option<i32> = None, in [1, 99];
        /// Whether all memory is locked, so that no page fault delays the loop.
        lock_memory: bool = false;
        /// Whether the process ends with an error if the machine refuses core, priority or locking.
        required: bool = false;
        /// Whether a spinning thread with `SCHED_FIFO` pauses regularly, so that the kernel does not throttle the
        /// thread.
        rests: bool = true;
        /// Whether a second fusion process runs as standby and takes over if the leading process ends or hangs.
        standby: bool = false;
        /// Core for the standby.
        standby_core: Option<usize> = None, usually "any";
        /// Time without a sign of life from the leading process after which the standby takes over.
        takeover_ms: f64 = 100.0, in [50, 60_000];
        /// Whether the decisions of fusion, with reasons, are published on `system/decisions` for every reader, and
        /// recorded. A display gets them in any case; then a burst may exceed the queue.
        decisions: bool = false;
        /// Time through fusion beyond which a report has missed its deadline. For a report that waits for the end of
        /// its scan, the time begins there.
        deadline_us: f64 = 1000.0, in [0.1, 1e9];
    }

    /// The machine, while the deployment runs.
    pub struct Machine {
        /// Longest time that a sleeping core may take to wake up, requested from the kernel by holding
        /// `/dev/cpu_dma_latency` open. Cores then use more power while idle. Fusion refuses to start if the kernel
        /// refuses the request.
        cpu_dma_latency_us: Option<i32> = None, in [0, 1_000_000], usually "no limit";
        /// Greatest number of slices that wait in the queue of a reader of `system/tracks` before the oldest is lost.
        /// Readers that request no length have 256. Shared memory for the topic: at most 0.41 MB for each slice of
        /// this number, and 20 MB.
        queue_slices: usize = 256, in [256, 8192];
    }

    /// Memory of fusion, and of adapters with a tracker, that outlasts the process: a successor resumes the same
    /// tracks with the same numbers. Not used for recordings, which can be repeated.
    pub struct Checkpoint {
        check Checkpoint::check;
        /// Whether a checkpoint is kept.
        enabled: bool = true;
        /// Age after which the tracks of a checkpoint are terminated instead of resumed.
        max_age_s: Seconds = Seconds::of(10.0), in [0.1, 3600];
        /// Whether the checkpoint is copied to a disk, to survive a reboot: numbers are not reused, and learned
        /// values are kept; tracks resume within `max_age_s`.
        durable: bool = false;
        /// Folder for the copies.
        folder: Option<String> = None, usually "must be given with durable";
        /// Interval of the copies: a crash of the machine loses the changes since the last copy.
        copy_every_s: Seconds = Seconds::of(2.0), in [0.1, 3600];
    }
}

settings::words! {
    /// Words for how fusion waits.
    pub enum WaitWord {
        /// Asleep until notified.
        Event = "event",
        /// Asks again and again.
        Spin = "spin",
        /// Spins for a while, then sleeps until notified.
        Hybrid = "hybrid",
    }

}

impl Fusion {
    /// Time for which a fusion may stand still before another one takes over, nanoseconds.
    pub fn takeover_ns(&self) -> i64 {
        (self.takeover_ms * 1e6) as i64
    }

    /// Time through fusion beyond which a report has missed its deadline, nanoseconds.
    pub fn deadline_ns(&self) -> i64 {
        (self.deadline_us * 1e3) as i64
    }
}

impl Checkpoint {
    fn check(&self) -> Result<(), SettingsError> {
        let refused = |key: &str, what: &str| Err(SettingsError::new(key, what));
        match &self.folder {
            _ if !self.durable => Ok(()),
            _ if !self.enabled => refused("durable", "there is no checkpoint to copy: leave it enabled"),
            None => refused(
                "folder",
                "must be given with durable: a folder on a disk of this machine",
            ),
            Some(_) => Ok(()),
        }
    }

    /// Age beyond which its tracks are not continued, nanoseconds; `None`: there is no checkpoint.
    pub fn max_age_ns(&self) -> Option<i64> {
        self.enabled.then(|| self.max_age_s.ns())
    }

    /// Folder for copies on disk, and the time between two copies; `None`: there are no copies.
    pub fn copies(&self) -> Option<(PathBuf, Duration)> {
        let folder = self.folder.as_ref().filter(|_| self.durable)?;
        Some((
            PathBuf::from(folder),
            Duration::from_nanos(self.copy_every_s.ns().unsigned_abs()),
        ))
    }
}
