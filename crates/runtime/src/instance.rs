//! Instance of a deployment: its name, claimed for one launcher, and its topics in shared memory.
//!
//! Both exist before the first process starts and until the last process has ended. The starter of the processes (the
//! launcher, or the bench) claims the instance and checks that shared memory is large enough ([`Instance`]). One
//! process holds every topic as long as the others run ([`hold_topics`]): the bench itself, or the launcher's keeper.
//! A process that maps memory written by others can be killed by its contents, which must not happen to the launcher.
//! [`Instance`] therefore maps no memory.

use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, BusError, Claim, Payload, Root, SharedMemory, TopicHold};
use deployment::Deployment;
use messages::{Stream, Topic};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::clock;
use crate::signals::Stop;

/// Time for the processes of a killed launcher to end, before this start is refused.
const ORPHAN_PATIENCE: Duration = Duration::from_secs(5);
/// Time for other readers of the deployment to leave at its end.
const LEAVE_PATIENCE: Duration = Duration::from_secs(2);
/// Pause between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// Publishers of a topic with one publisher: during a restart, the memory of the dead publisher still exists.
const ONE_AND_ITS_SUCCESSOR: usize = 2;
/// Further publishers of health messages: the launcher, and dead processes.
const FURTHER_HEALTH: usize = 5;
/// Publishers of progress: fusion and the recorder.
const PROGRESS_PUBLISHERS: usize = 4;

/// Name of fusion's checkpoint memory. The checkpoint outlives every process, the launcher included. At an orderly end
/// it becomes a file.
pub const CHECKPOINT: &str = "checkpoint";

/// Ending of the names of files in the base folder that an orderly end keeps for the next start.
pub const END_SUFFIX: &str = ".end";
/// `<instance>.numbered` in the base folder: numbers were given under the instance's name.
pub const NUMBERED: &str = "numbered";

/// Ending of the names of files in the base folder that contain a report in quarantine and the checkpoint before it.
pub const QUARANTINED: &str = "quarantined";

/// Leader lock file, in the instance's folder, if a standby is configured.
pub const FUSION_LEADS: &str = "fusion-leads";

/// Returns the number of the process that holds the leader lock, as the kernel lists locks; `None` without a leader
/// or without a standby. After a take-over, the leader is not the process that was started as the leader.
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

/// Claimed instance.
#[derive(Debug)]
pub struct Instance {
    claim: Claim,
    say: fn(&str),
}

impl Instance {
    /// Claims the instance for a deployment of `processes` processes. `say` receives one line for each remainder of
    /// an earlier start and for each wait.
    ///
    /// # Errors
    /// If the instance runs already, is still in use, or the machine lacks memory or permissions.
    pub fn claim(
        deployment: &Deployment,
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
                "removed the remains of an earlier run of instance {instance}: {} files, {:.1} MB",
                wiped.files,
                wiped.bytes as f64 / 1e6
            ));
        }
        bus::check_space(needed_bytes(deployment, processes))?;
        Ok(Self { claim, say })
    }

    /// Returns the folders of the instance.
    pub fn root(&self) -> &Root {
        self.claim.root()
    }

    /// Removes the shared memory, before topics are held anew: for a deployment with corrupt memory whose own
    /// processes have ended. Other processes keep their mappings and receive nothing further.
    ///
    /// # Errors
    /// If files cannot be removed.
    pub fn empty(&mut self) -> anyhow::Result<()> {
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
                // A process that leaves at this moment removes files as well.
                Err(_) if start.elapsed() < LEAVE_PATIENCE => std::thread::sleep(PAUSE),
                emptied => {
                    emptied.context("removing corrupt shared memory")?;
                    return Ok(());
                }
            }
        }
    }

    /// Removes every trace of the instance. If other processes still use the instance, the next start does this.
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
                    "the shared memory remains, because it is still read by {}; the next start removes the memory",
                    list(&processes)
                ));
                Ok(())
            }
            Err(error) => Err(error).context("clearing up"),
        }
    }
}

fn list(processes: &[bus::MemberProcess]) -> String {
    let users: Vec<String> = processes.iter().map(|p| format!("{} ({})", p.pid, p.name)).collect();
    users.join(", ")
}

/// Creates every topic of the deployment and keeps all topics in existence as long as the result lives.
///
/// # Errors
/// If the machine refuses a topic.
pub fn hold_topics(deployment: &Deployment, bus: &Bus<SharedMemory>) -> Result<Vec<TopicHold>, BusError> {
    let mut hold = Hold { bus, held: Vec::new() };
    // Only the required space depends on the number of processes.
    each_topic(deployment, 0, &mut hold)?;
    bus.hold_log(&messages::event_log(), clock::mono_ns() as u64)?;
    Ok(hold.held)
}

/// Returns the maximum size in shared memory of a deployment of `processes` processes, bytes.
pub fn needed_bytes(deployment: &Deployment, processes: usize) -> u64 {
    let mut need = Need(bus::needed_log_bytes(&messages::event_log()));
    // The sum cannot fail.
    let _ = each_topic(deployment, processes, &mut need);
    need.0
}

/// Maximum number of processes that give orders at a time.
const ORDERS_PUBLISHERS: usize = 16;

/// Operation on every topic of a deployment.
pub trait Visit {
    /// Executes the operation on `topic`, which may have so many publishers at a time.
    ///
    /// # Errors
    /// If shared memory refuses.
    fn visit<T: Payload>(&mut self, topic: &Topic<T>, publishers: usize) -> Result<(), BusError>;
}

/// Visits the topic of each stream of data of a deployment, with the number of its publishers.
///
/// # Errors
/// The first error of `visit`.
pub fn each_stream(deployment: &Deployment, publishers: usize, visit: &mut impl Visit) -> Result<(), BusError> {
    for (id, name) in deployment.streams() {
        match id.stream {
            Stream::SensorTracks => visit.visit(&messages::sensor_tracks(name), publishers)?,
            Stream::Detections => visit.visit(&messages::sensor_detections(name), publishers)?,
            Stream::Bearings => visit.visit(&messages::sensor_bearings(name), publishers)?,
            Stream::Arrivals => visit.visit(&messages::sensor_arrivals(name), publishers)?,
            Stream::Fixes => visit.visit(&messages::sensor_fixes(name), publishers)?,
            Stream::Statements => visit.visit(&messages::target_statements(name), publishers)?,
            Stream::PlatformStates => visit.visit(&messages::platform_states(name), publishers)?,
            Stream::Cues => visit.visit(&messages::cues(name), publishers)?,
            Stream::WideArea => visit.visit(&messages::wide_area(name), publishers)?,
            Stream::SystemTracks => visit.visit(&deployment.system_tracks_topic(), publishers)?,
            Stream::Alarms => visit.visit(&messages::alarms(), publishers)?,
            Stream::Alerts => visit.visit(&messages::alerts(), publishers)?,
            Stream::Decisions => visit.visit(&messages::decisions(), publishers)?,
            Stream::Orders => visit.visit(&messages::order_states(), publishers)?,
        }
    }
    for sensor in &deployment.tracker_sensors {
        visit.visit(&messages::sensor_detections(&sensor.name), publishers)?;
    }
    for source in deployment.sources.iter().filter(|source| source.has_array()) {
        visit.visit(&messages::sensor_spectrum(&source.name), publishers)?;
    }
    for platform in &deployment.platforms {
        visit.visit(&messages::platform_states(&platform.name), publishers)?;
    }
    if deployment.system_tracks.exchange {
        visit.visit(&messages::own_tracks(), publishers)?;
    }
    if deployment.system_tracks.smooths {
        visit.visit(&messages::smoothed_tracks(), publishers)?;
    }
    Ok(())
}

/// Visits every topic of a deployment, with the number of its publishers at a time.
fn each_topic(deployment: &Deployment, processes: usize, visit: &mut impl Visit) -> Result<(), BusError> {
    each_stream(deployment, ONE_AND_ITS_SUCCESSOR, visit)?;
    visit.visit(&messages::frame_origin(), ONE_AND_ITS_SUCCESSOR)?;
    visit.visit(&messages::health(), processes + FURTHER_HEALTH)?;
    visit.visit(&messages::progress(), PROGRESS_PUBLISHERS)?;
    visit.visit(&messages::restored(), ONE_AND_ITS_SUCCESSOR)?;
    // Publishers: operators, displays, and the recorder.
    visit.visit(&messages::orders(), ORDERS_PUBLISHERS)
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
    held: Vec<TopicHold>,
}

impl Visit for Hold<'_> {
    fn visit<T: Payload>(&mut self, topic: &Topic<T>, _: usize) -> Result<(), BusError> {
        self.held.push(self.bus.hold(topic)?);
        Ok(())
    }
}

/// Claims the instance. Processes of an earlier, killed launcher get time to end.
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
                    "instance {instance} is already run by process {pid}: stop that process first, or start another \
                     instance with --instance NAME"
                );
            }
            result => return Ok(result?),
        }
    }
}

/// Raises the limit of open files. Each process keeps several files open for every topic, and the usual limit of 1024
/// is soon reached. Children inherit the limit.
fn raise_file_limit() {
    let limit = getrlimit(Resource::Nofile);
    // Raising to the permitted maximum needs no permission. If it is refused all the same, the later opening of files
    // reports the error.
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
    fn the_usual_queue_and_the_memory_are_as_stated_for_the_key() {
        let mut topic = messages::system_tracks();
        assert_eq!(deployment::Machine::default().queue_slices, topic.capacity.depth);
        for length in [256, 1024, 8192] {
            topic.capacity.depth = length;
            // Fusion and its successor publish.
            let megabytes = bus::needed_bytes(&topic, 2) as f64 / 1e6;
            let stated = 0.41 * length as f64 + 20.0;
            assert!(
                (0.95 * stated - 10.0..=stated).contains(&megabytes),
                "{length}: {megabytes}"
            );
        }
    }

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
