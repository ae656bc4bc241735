//! The deployment that suffers, in a separate folder.

mod memory;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use bus::{Bus, BusError, Payload, Publisher, Root, SharedMemory};
use messages::{NS_PER_S, Topic};
use runtime::clock::{Now, instant, mono_ns};
use runtime::instance::{END_SUFFIX, NUMBERED, leading_fusion};
use runtime::signals::Stop;
use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

use crate::judge::event::{Conditions, Event, Part, What};
use crate::ledger::Ledger;
use crate::onlooker::{Onlooker, TakeOvers};
use crate::own_file_systems::{self, SHARED_MEMORY};
use crate::resources::{Latencies, Resources};
use crate::schedule::{Cast, Needs};
use crate::undisturbed;
use crate::world::World;
use crate::{Tested, Torture};

const INSTANCE: &str = "torture";
/// How long a start, or an end, may take.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time between two notes that time has passed.
const NOTE_NS: i64 = 500_000_000;
/// Pause between two looks.
const PAUSE: Duration = Duration::from_millis(5);
/// Time without the end of a process after which a deployment with corrupted memory counts as recovered.
const STABLE: Duration = Duration::from_secs(2);
/// The run was interrupted.
#[derive(Debug, thiserror::Error)]
#[error("interrupted")]
pub(crate) struct Interrupted;

/// The deployment is so broken that the run cannot go on: a verdict on the deployment, and no failure of this command.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Broken(String);

/// A deployment, the launcher, and the judge's subscriber.
pub(crate) struct Deployment {
    folder: TempDir,
    root: Root,
    executable: PathBuf,
    command: Vec<String>,
    launcher: Child,
    starts: usize,
    sources: Vec<String>,
    /// Sources with located tracks, by numbers.
    locators: BTreeSet<u16>,
    /// Names of the children, once all run.
    expected: Vec<String>,
    world: Option<World>,
    ledger: Ledger,
    onlooker: Option<Onlooker>,
    /// Start of the names of memory of a killed launcher.
    dead_prefix: Option<String>,
    /// Why the subscriber could not join last time.
    obstacle: String,
    /// The memory was corrupted: another process reads the memory first, because reading may kill the reader.
    is_spoilt: bool,
    probe: Option<(Child, Instant)>,
    latencies: Latencies,
    take_overs: TakeOvers,
    noted_ns: i64,
    stop: Stop,
}

impl Deployment {
    /// Starts the deployment, and waits until the deployment runs and publishes tracks.
    ///
    /// # Errors
    /// If the configuration cannot be used, or the deployment does not start.
    pub(crate) fn start(torture: &Torture, tested: Tested, stop: Stop) -> anyhow::Result<Self> {
        let Tested {
            executable,
            path,
            deployment: config,
            engines,
            terminate_s,
        } = tested;
        let begin = Now::read();
        let world = World::new(&config, engines, begin)?;
        let periods_ns = config.sources.iter().map(|source| source.period_ns);
        let conditions = Conditions {
            seed: torture.seed,
            terminate_s,
            period_s: periods_ns.max().unwrap_or_default() as f64 / NS_PER_S,
            begin_ns: [begin.mono_ns, begin.utc_ns],
        };
        let ledger = Ledger::new(conditions, torture.record.as_deref())?;
        let folder = TempDir::new().context("making a folder")?;
        let root = Root::in_base(folder.path().join("koseki"), INSTANCE)?;
        let mut command = vec!["up".to_owned(), path.display().to_string()];
        command.push(format!("--instance={INSTANCE}"));
        command.push(format!("--seed={}", undisturbed::SEED));
        // The simulated world continues when the launcher is started again.
        command.push(format!("--scenario-start={}", begin.utc_ns));
        let out = folder.path().join("out");
        command.push(format!("--out={}", out.display()));
        if own_file_systems::are_there() {
            fs::create_dir(&out)?;
            own_file_systems::mount(&out)?;
            own_file_systems::mount(Path::new(SHARED_MEMORY))?;
            // Otherwise no process writes to the disk.
            command.push("--set=recorder.enabled=true".to_owned());
        }
        for set in &torture.set {
            command.push(format!("--set={set}"));
        }
        let launcher = launch(&executable, &folder, &command, 0)?;
        let mut deployment = Self {
            folder,
            root,
            executable,
            command,
            launcher,
            starts: 1,
            locators: undisturbed::locators(&config),
            sources: config.sources.into_iter().map(|source| source.name).collect(),
            expected: Vec::new(),
            world,
            ledger,
            onlooker: None,
            dead_prefix: None,
            obstacle: String::new(),
            is_spoilt: false,
            probe: None,
            latencies: Latencies::default(),
            take_overs: TakeOvers::default(),
            noted_ns: 0,
            stop,
        };
        deployment.until_it_runs()?;
        deployment.expected = deployment.children()?.into_keys().collect();
        Ok(deployment)
    }

    /// Returns whether the deployment has the requirements of a fault.
    pub(crate) fn has(&self, needs: Needs) -> bool {
        match needs {
            Needs::Nothing => true,
            Needs::Standby => self.has_standby(),
            Needs::OwnFileSystems => own_file_systems::are_there(),
        }
    }

    fn has_standby(&self) -> bool {
        self.expected.iter().any(|name| name == "standby")
    }

    /// Processes and sources that a fault can hit.
    pub(crate) fn cast(&self) -> Cast {
        Cast {
            processes: self.expected.clone(),
            sources: self.sources.clone(),
        }
    }

    /// The part that a process stands for; `None` for processes that the picture does not need.
    pub(crate) fn part(&self, name: &str) -> Option<Part> {
        match name {
            "keeper" | "monitor" | "recorder" | "display" | "standby" => None,
            "fusion" => Some(Part::Fusion),
            "simulator" => Some(Part::Sensors),
            _ => Some(Part::Adapter),
        }
    }

    pub(crate) fn root(&self) -> &Root {
        &self.root
    }

    pub(crate) fn ledger(&mut self) -> &mut Ledger {
        &mut self.ledger
    }

    /// Returns a publisher as soon as the deployment has the topic: a rebuild may be in progress.
    pub(crate) fn publisher<T: Payload>(
        &mut self,
        topic: &Topic<T>,
    ) -> anyhow::Result<(Bus<SharedMemory>, Publisher<SharedMemory, T>)> {
        let begun = instant();
        loop {
            let opened = || -> Result<_, BusError> {
                let bus = Bus::open(&self.root, "torture")?;
                let publisher = bus.publisher(topic, mono_ns() as u64)?;
                Ok((bus, publisher))
            };
            match opened() {
                Ok(opened) => return Ok(opened),
                Err(error) if instant() - begun > PATIENCE => return Err(error.into()),
                Err(_) => self.watch(PAUSE)?,
            }
        }
    }

    /// Returns the process numbers of the launcher's children by name. Of two fusion processes, the leader is called
    /// fusion: a take-over exchanges the roles, but not the command lines.
    pub(crate) fn children(&self) -> anyhow::Result<BTreeMap<String, u32>> {
        let pid = self.launcher.id();
        let pids = fs::read_to_string(format!("/proc/{pid}/task/{pid}/children"))
            .map_err(|_| Broken(format!("the launcher has ended: {}", self.said())))?;
        let leader = leading_fusion(&self.root);
        let named = pids.split_whitespace().filter_map(|pid| {
            let command = fs::read_to_string(format!("/proc/{pid}/cmdline")).ok()?;
            let name = command.split('\0').find_map(|word| word.strip_prefix("--name="))?;
            let pid = pid.parse().ok()?;
            let name = match leader.filter(|_| is_fusion(name)) {
                Some(leader) if pid == leader => "fusion",
                Some(_) => "standby",
                None => name,
            };
            Some((name.to_owned(), pid))
        });
        Ok(named.collect())
    }

    /// Sends a signal to a child; returns the child's process number.
    pub(crate) fn signal(&mut self, name: &str, signal: Signal) -> anyhow::Result<u32> {
        let begun = instant();
        loop {
            if let Some(pid) = self.children()?.get(name).copied() {
                self.signal_process(pid, signal);
                return Ok(pid);
            }
            if instant() - begun > PATIENCE {
                return Err(Broken(format!("there is no {name}")).into());
            }
            self.watch(PAUSE)?;
        }
    }

    /// Sends a signal to a process of the launcher's.
    pub(crate) fn signal_process(&self, pid: u32, signal: Signal) {
        if let Some(pid) = i32::try_from(pid).ok().and_then(Pid::from_raw) {
            // The process may have ended meanwhile.
            let _ = kill_process(pid, signal);
        }
    }

    /// Waits until a child has another process than the `dead` one.
    pub(crate) fn until_started(&mut self, name: &str, dead: u32) -> anyhow::Result<u32> {
        let begun = instant();
        loop {
            if let Some(pid) = self.children()?.get(name).filter(|pid| **pid != dead) {
                return Ok(*pid);
            }
            if instant() - begun > PATIENCE {
                return Err(Broken(format!("{name} is not started again")).into());
            }
            self.watch(PAUSE)?;
        }
    }

    /// Kills the launcher and starts the launcher again.
    pub(crate) fn restart(&mut self) -> anyhow::Result<()> {
        // A subscriber keeps the instance in use.
        self.look_away(true);
        self.dead_prefix = self.prefix();
        self.launcher.kill()?;
        self.launcher.wait()?;
        self.is_spoilt = false;
        self.launcher = launch(&self.executable, &self.folder, &self.command, self.starts)?;
        self.starts += 1;
        self.until_it_runs()
    }

    /// Watches for a while.
    pub(crate) fn watch(&mut self, time: Duration) -> anyhow::Result<()> {
        let begun = instant();
        loop {
            self.look()?;
            if instant() - begun >= time {
                return Ok(());
            }
            std::thread::sleep(PAUSE.min(time));
        }
    }

    /// Leaves the deployment; `whole` if the memory is sound.
    pub(crate) fn look_away(&mut self, whole: bool) {
        if let Some((mut probe, _)) = self.probe.take() {
            let _ = probe.kill();
            let _ = probe.wait();
        }
        if let Some(onlooker) = self.onlooker.take() {
            onlooker.leave(whole, &mut self.ledger);
        }
    }

    /// Returns the number of take-overs, and of take-overs from a process that did not advance.
    pub(crate) fn take_overs(&self) -> (u64, u64) {
        let sum = |place: usize| self.take_overs.values().map(|counts| counts[place]).sum();
        (sum(0), sum(1))
    }

    /// Present use of the machine.
    pub(crate) fn resources(&mut self, at_s: f64) -> anyhow::Result<Resources> {
        let folder = fs::read_dir(self.root.path()).map_or(0, Iterator::count);
        let mut used = Resources {
            at_s,
            files: self.memory(self.prefix())?.len() + folder,
            latency_us: self.latencies.take_median_us(),
            ..Resources::default()
        };
        used.add_process("launcher".to_owned(), self.launcher.id());
        for (name, pid) in self.children()? {
            used.add_process(name, pid);
        }
        Ok(used)
    }

    /// Folder for recordings.
    pub(crate) fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn heed_stop(&self) -> anyhow::Result<()> {
        if self.stop.requested() {
            return Err(Interrupted.into());
        }
        Ok(())
    }

    /// Passes received events to the judge. Joins without a subscriber; during a rebuild, at the next call.
    fn look(&mut self) -> anyhow::Result<()> {
        self.heed_stop()?;
        let now_ns = mono_ns();
        if now_ns - self.noted_ns > NOTE_NS {
            self.noted_ns = now_ns;
            self.ledger.now(What::Passed);
        }
        if let Some(world) = &mut self.world {
            while let Some(second) = world.next(now_ns) {
                self.ledger.now(What::Second(second));
            }
        }
        let has_memory = || {
            self.prefix()
                .is_some_and(|prefix| Some(&prefix) != self.dead_prefix.as_ref())
        };
        if self.onlooker.is_none() && has_memory() && self.may_be_read()? {
            match Onlooker::join(&self.root, &self.locators, &mut self.ledger) {
                Ok(onlooker) => self.onlooker = Some(onlooker),
                Err(error) => self.obstacle = format!("{error:#}"),
            }
        }
        let Some(onlooker) = &mut self.onlooker else {
            return Ok(());
        };
        match onlooker.look(&mut self.ledger, &mut self.latencies, &mut self.take_overs) {
            Ok(true) => return Ok(()),
            Ok(false) => {}
            Err(error) => self.obstacle = format!("{error:#}"),
        }
        self.look_away(false);
        self.ledger.now(What::Rebuilt);
        Ok(())
    }

    /// Waits until every process runs and newly sent states arrive; otherwise returns a description of the missing. A
    /// deployment that may still fail has recovered after a time without the end of a process.
    pub(crate) fn until_back(&mut self, patience: Duration, stable: bool) -> anyhow::Result<Option<String>> {
        let (begun, begun_ns) = (instant(), mono_ns());
        let (mut seen, mut since) = (BTreeMap::new(), begun);
        loop {
            self.look()?;
            let children = self.children()?;
            let missing: Vec<String> = self
                .expected
                .iter()
                .filter(|name| !children.contains_key(*name))
                .cloned()
                .collect();
            if children != seen {
                (seen, since) = (children, instant());
            }
            let is_steady = !stable || instant() - since > STABLE;
            let latest_ns = self.ledger.judge().latest_ns();
            if missing.is_empty() && is_steady && latest_ns > begun_ns {
                return Ok(None);
            }
            if instant() - begun > patience {
                let last_s = (mono_ns() - latest_ns) as f64 / 1e9;
                return Ok(Some(format!(
                    "not back after {} s: missing {missing:?}, last state {last_s:.1} s ago{}",
                    patience.as_secs(),
                    self.obstacle()
                )));
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn obstacle(&self) -> String {
        match &self.onlooker {
            None if !self.obstacle.is_empty() => format!(", it cannot be read ({})", self.obstacle),
            _ => String::new(),
        }
    }

    fn until_it_runs(&mut self) -> anyhow::Result<()> {
        let (begun, begun_ns) = (instant(), mono_ns());
        let words = format!("instance {INSTANCE} runs");
        while !self.said().contains(&words) {
            // The ends of tracks that fusion sends at the start must not be missed.
            self.look()?;
            if let Some(status) = self.launcher.try_wait()? {
                return Err(Broken(format!("the deployment does not start ({status}): {}", self.said())).into());
            }
            if instant() - begun > PATIENCE {
                return Err(Broken(format!("the deployment does not start: {}", self.said())).into());
            }
            std::thread::sleep(PAUSE);
        }
        while self.ledger.judge().latest_ns() < begun_ns {
            self.look()?;
            if instant() - begun > PATIENCE {
                return Err(Broken(format!("no track is shown{}: {}", self.obstacle(), self.said())).into());
            }
            std::thread::sleep(PAUSE);
        }
        Ok(())
    }

    /// Words of the launcher of the present start.
    fn said(&self) -> String {
        fs::read_to_string(self.folder.path().join(format!("said{}", self.starts - 1))).unwrap_or_default()
    }

    /// Stops the deployment, and passes the remains to the judge.
    ///
    /// # Errors
    /// If the deployment does not stop.
    pub(crate) fn stop(&mut self) -> anyhow::Result<()> {
        self.look_away(true);
        let at_ns = mono_ns();
        let prefix = self.prefix();
        self.signal_process(self.launcher.id(), Signal::TERM);
        let begun = instant();
        while self.launcher.try_wait()?.is_none() {
            if instant() - begun > PATIENCE {
                return Err(Broken(format!("the deployment does not stop: {}", self.said())).into());
            }
            std::thread::sleep(PAUSE);
        }
        let mut left: Vec<String> = self.memory(prefix)?.into_iter().collect();
        for entry in fs::read_dir(self.root.base())?.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            // A rejected checkpoint remains for analysis, and an orderly end keeps the state from which the next start
            // continues.
            let is_kept = name.ends_with(END_SUFFIX) || name.split_once('.').is_some_and(|(_, rest)| rest == NUMBERED);
            if !is_kept && !name.ends_with("-refused") {
                left.push(name);
            }
        }
        self.ledger.take(&Event {
            at_ns,
            what: What::Stopped { left_behind: left },
        });
        Ok(())
    }
}

impl Drop for Deployment {
    fn drop(&mut self) {
        self.look_away(false);
        // Where something went wrong; the launcher's children follow.
        let _ = self.launcher.kill();
        let _ = self.launcher.wait();
        if own_file_systems::are_there() {
            own_file_systems::unmount(&self.out());
        }
    }
}

fn is_fusion(name: &str) -> bool {
    matches!(name, "fusion" | "standby")
}

fn launch(executable: &Path, folder: &TempDir, arguments: &[String], start: usize) -> anyhow::Result<Child> {
    let said = File::create(folder.path().join(format!("said{start}")))?;
    let child = Command::new(executable)
        .args(arguments)
        .env("KOSEKI_ROOT", folder.path().join("koseki"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(said)
        .spawn();
    child.context("starting the deployment")
}
