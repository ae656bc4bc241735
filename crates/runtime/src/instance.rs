//! The instance of a deployment: its name, claimed for one launcher, and its topics in shared memory.
//!
//! Both must be there before the first process starts, and gone after the last one has ended. Whoever starts the
//! processes of a deployment (the launcher; the bench for its own) claims the instance and makes sure that the shared
//! memory is large enough ([`Instance`]). A process holds every topic as long as the others run ([`hold_topics`]): the
//! bench itself; under a launcher its keeper, because whoever maps memory that others write can be killed by what is
//! in it, and the launcher must not be. Nothing that [`Instance`] does maps any.

use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, BusError, Claim, Held, Payload, Root, SharedMemory};
use messages::Topic;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::clock;
use crate::signals::Stop;

/// How long the processes of a launcher that was killed may take to notice, before this start is refused.
const ORPHAN_PATIENCE: Duration = Duration::from_secs(5);
/// How long other readers of the deployment may take to leave at its end.
const LEAVE_PATIENCE: Duration = Duration::from_secs(2);
/// Pause between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// Publishers of a topic that has one: during a restart, the dead one's memory is not yet taken back.
const ONE_AND_ITS_SUCCESSOR: usize = 2;
/// Further publishers of health messages: the launcher, and some processes that have died.
const FURTHER_HEALTH: usize = 5;
/// Fusion and the recorder publish their progress.
const PROGRESS_PUBLISHERS: usize = 4;

/// Name of the memory in which fusion keeps what its successor goes on from. It outlasts every process, the launcher
/// too, but for an orderly end.
pub const CHECKPOINT: &str = "checkpoint";

/// Ending of the names of files in the base folder that keep a report in quarantine and the checkpoint before it.
pub const QUARANTINED: &str = "quarantined";

/// Name of the file, in the instance's folder, whose lock the fusion that leads holds where another one stands by.
pub const FUSION_LEADS: &str = "fusion-leads";

/// Process that holds the lock of the fusion that leads, as the system says; `None` while there is none, and where no
/// fusion stands by. After a take-over it is not the one that was started as the leader.
pub fn leading_fusion(root: &Root) -> Option<u32> {
    let inode = fs::metadata(root.path().join(FUSION_LEADS)).ok()?.ino();
    let locks = fs::read_to_string("/proc/locks").ok()?;
    locks.lines().find_map(|line| {
        // Number, kind, strictness, access, process, place: "device:device:inode".
        let words: Vec<&str> = line.split_whitespace().collect();
        let is_its = words.get(5)?.ends_with(&format!(":{inode}"));
        words.get(4)?.parse().ok().filter(|_| is_its)
    })
}

/// A claimed instance.
#[derive(Debug)]
pub struct Instance {
    claim: Claim,
    say: fn(&str),
}

impl Instance {
    /// Claims the instance for a deployment which is going to have so many `processes`. `say` is told, one line each,
    /// what was found and is waited for.
    ///
    /// # Errors
    /// If it runs already, is still used, or the machine has not enough memory or rights.
    pub fn claim(
        deployment: &impl Deployment,
        instance: &str,
        processes: usize,
        stop: &Stop,
        say: fn(&str),
    ) -> anyhow::Result<Self> {
        raise_file_limit();
        let root = Root::new(instance)?;
        let claim = claim(&root, stop, say)?;
        let wiped = claim.wiped();
        if wiped.files > 0 {
            say(&format!(
                "removed what an earlier run of instance {instance} had left: {} files, {:.1} MB",
                wiped.files,
                wiped.bytes as f64 / 1e6
            ));
        }
        bus::check_space(needed_bytes(deployment, processes))?;
        Ok(Self { claim, say })
    }

    /// Its places.
    pub fn root(&self) -> &Root {
        self.claim.root()
    }

    /// Removes the shared memory, for topics that are going to be held anew. For a deployment whose memory is corrupt
    /// and whose own processes have ended; others keep what they have mapped, and hear nothing any more.
    ///
    /// # Errors
    /// If files cannot be removed.
    pub fn empty(&self) -> anyhow::Result<()> {
        let users = self.claim.root().processes()?;
        if !users.is_empty() {
            (self.say)(&format!(
                "{} must join anew: the shared memory is replaced",
                list(&users)
            ));
        }
        let start = clock::instant();
        loop {
            match self.claim.empty() {
                // One that leaves just now takes files away under the hands of who removes them.
                Err(_) if start.elapsed() < LEAVE_PATIENCE => std::thread::sleep(PAUSE),
                emptied => {
                    emptied.context("removing corrupt shared memory")?;
                    return Ok(());
                }
            }
        }
    }

    /// Removes every trace of the instance. Where other processes still look at it, that is left to the next start.
    ///
    /// # Errors
    /// If files cannot be removed.
    pub fn clear(self) -> anyhow::Result<()> {
        let Self { claim, say } = self;
        let root = claim.root();
        let start = clock::instant();
        while start.elapsed() < LEAVE_PATIENCE && !root.processes()?.is_empty() {
            std::thread::sleep(PAUSE);
        }
        root.remove_outlasting();
        match claim.remove() {
            Ok(_) => Ok(()),
            Err(BusError::StillUsed { processes, .. }) => {
                say(&format!(
                    "the shared memory stays, because it is still read by {}; the next start removes it",
                    list(&processes)
                ));
                Ok(())
            }
            Err(error) => Err(error).context("clearing up"),
        }
    }
}

fn list(processes: &[bus::Process]) -> String {
    let users: Vec<String> = processes.iter().map(|p| format!("{} ({})", p.pid, p.name)).collect();
    users.join(", ")
}

/// Creates every topic of the deployment, and keeps all of them in existence as long as the result lives.
///
/// # Errors
/// If the machine refuses one.
pub fn hold_topics(deployment: &impl Deployment, bus: &Bus<SharedMemory>) -> Result<Vec<Held>, BusError> {
    let mut hold = Hold { bus, held: Vec::new() };
    // The number of processes matters for the space only.
    each_topic(deployment, 0, &mut hold)?;
    bus.hold_log(&messages::order(), clock::mono_ns() as u64)?;
    Ok(hold.held)
}

/// Most bytes that a deployment of so many `processes` takes in shared memory.
pub fn needed_bytes(deployment: &impl Deployment, processes: usize) -> u64 {
    let mut need = Need(bus::needed_log_bytes(&messages::order()));
    // Adding up cannot fail.
    let _ = each_topic(deployment, processes, &mut need);
    need.0
}

/// The parts of a deployment's configuration that every process needs, whatever its work.
pub trait Deployment {
    /// Core that fusion has for itself; `None` if it shares one.
    fn fusion_core(&self) -> Option<usize>;

    /// Midnight of the recordings' first day, UTC, nanoseconds since 1970; `None` without recordings.
    fn first_day_ns(&self) -> Option<i64>;

    /// Visits the topic of each stream of data, every one with so many `publishers`.
    ///
    /// # Errors
    /// The first one of `visit`.
    fn each_stream(&self, publishers: usize, visit: &mut impl Visit) -> Result<(), BusError>;
}

/// An action that is done with every topic of a deployment.
pub trait Visit {
    /// Does it with `topic`, which can have so many publishers at a time.
    ///
    /// # Errors
    /// If shared memory refuses it.
    fn visit<T: Payload>(&mut self, topic: &Topic<T>, publishers: usize) -> Result<(), BusError>;
}

/// Every topic of a deployment, with the number of publishers that it can have at a time.
fn each_topic(deployment: &impl Deployment, processes: usize, visit: &mut impl Visit) -> Result<(), BusError> {
    deployment.each_stream(ONE_AND_ITS_SUCCESSOR, visit)?;
    visit.visit(&messages::frame_origin(), ONE_AND_ITS_SUCCESSOR)?;
    visit.visit(&messages::health(), processes + FURTHER_HEALTH)?;
    visit.visit(&messages::progress(), PROGRESS_PUBLISHERS)?;
    visit.visit(&messages::restored(), ONE_AND_ITS_SUCCESSOR)?;
    // Operators', and the recorder's.
    visit.visit(&messages::control(), 2 * ONE_AND_ITS_SUCCESSOR)
}

struct Need(u64);

impl Visit for Need {
    fn visit<T: Payload>(&mut self, topic: &Topic<T>, publishers: usize) -> Result<(), BusError> {
        self.0 += bus::needed_bytes(topic, publishers);
        Ok(())
    }
}

struct Hold<'a> {
    bus: &'a Bus<SharedMemory>,
    held: Vec<Held>,
}

impl Visit for Hold<'_> {
    fn visit<T: Payload>(&mut self, topic: &Topic<T>, _: usize) -> Result<(), BusError> {
        self.held.push(self.bus.hold(topic)?);
        Ok(())
    }
}

/// Claims the instance. Processes that an earlier, killed launcher had started are given time to end.
fn claim(root: &Root, stop: &Stop, say: fn(&str)) -> anyhow::Result<Claim> {
    let start = clock::instant();
    let mut said = false;
    loop {
        match root.claim() {
            Err(BusError::StillUsed { processes, .. }) if start.elapsed() < ORPHAN_PATIENCE && !stop.requested() => {
                if !said {
                    said = true;
                    let count = processes.len();
                    say(&format!("waiting for {count} processes of an earlier run to end"));
                }
                std::thread::sleep(PAUSE);
            }
            Err(BusError::AlreadyRunning { instance, pid }) => {
                let pid = pid.map_or_else(|| "(unknown)".to_owned(), |pid| pid.to_string());
                anyhow::bail!(
                    "instance {instance} is already run by process {pid}: stop that one first, or start this one beside \
                     it with --instance NAME"
                );
            }
            result => return Ok(result?),
        }
    }
}

/// Each process keeps some files open for every topic, and the usual limit of 1024 is soon reached. Children inherit
/// what is raised here.
fn raise_file_limit() {
    let limit = getrlimit(Resource::Nofile);
    // Raising it to the allowed maximum needs no right; where it is refused all the same, opening files will say so.
    let _ = setrlimit(
        Resource::Nofile,
        Rlimit {
            current: limit.maximum,
            maximum: limit.maximum,
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_holds_the_lock_leads() {
        let folder = tempfile::tempdir().unwrap();
        let root = Root::in_base(folder.path(), "test").unwrap();
        assert_eq!(leading_fusion(&root), None);
        fs::create_dir_all(root.path()).unwrap();
        let lock = fs::File::create(root.path().join(FUSION_LEADS)).unwrap();
        assert_eq!(leading_fusion(&root), None);
        lock.lock().unwrap();
        assert_eq!(leading_fusion(&root), Some(std::process::id()));
    }
}
