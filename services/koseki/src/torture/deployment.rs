//! The deployment that suffers, in a folder of its own.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Root, SharedMemory, Subscriber};
use messages::{Counter, Health, NO_SOURCE, ProcessKind, SystemTrack};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use runtime::clock::{Now, instant, mono_ns};
use runtime::instance::leading_fusion;
use rustix::process::{Pid, Signal, kill_process};
use scoring::NumberTally;
use tempfile::TempDir;

use super::faults::Needs;
use super::own_file_systems::{self, SHARED_MEMORY};
use super::resources::{Latencies, Resources};
use super::sequence_tally::SequenceTally;
use crate::args::Torture;

const INSTANCE: &str = "torture";
/// How long a start, or an end, may take.
const PATIENCE: Duration = Duration::from_secs(60);
/// Pause between two looks.
const PAUSE: Duration = Duration::from_millis(5);

/// A deployment, its launcher, and the subscriber that keeps the tally.
pub(super) struct Deployment {
    folder: TempDir,
    root: Root,
    command: Vec<String>,
    launcher: Child,
    starts: usize,
    sources: Vec<String>,
    /// Age beyond which fusion does not go on with the tracks of the one before, nanoseconds.
    max_age_ns: i64,
    /// Names of the children, once all run.
    expected: Vec<String>,
    onlooker: Option<Onlooker>,
    tally: NumberTally,
    latencies: Latencies,
    /// By process and start: how often it took over, and how often from one that stood still.
    take_overs: BTreeMap<(u32, u64), [u64; 2]>,
    /// Lost samples, as the subscribers that were there before the present one counted them.
    lost: u64,
    /// What was wrong with how they were counted.
    miscounted: Vec<String>,
}

/// Subscriber that keeps the tally.
struct Onlooker {
    joined_ns: u64,
    tracks: Subscriber<SharedMemory, SystemTrack>,
    health: Subscriber<SharedMemory, Health>,
    sequences: SequenceTally,
}

impl Deployment {
    /// Starts it, and waits until it runs and shows tracks.
    pub(super) fn start(torture: &Torture) -> anyhow::Result<Self> {
        let folder = TempDir::new().context("making a folder")?;
        let root = Root::in_base(folder.path().join("koseki"), INSTANCE)?;
        let config = torture
            .config
            .as_deref()
            .unwrap_or(Path::new(configuration::BUILT_IN_DEMO));
        let mut command = vec!["up".to_owned(), config.display().to_string()];
        command.push(format!("--instance={INSTANCE}"));
        // Its world goes on when the launcher is started again.
        command.push(format!("--scenario-start={}", Now::read().utc_ns));
        let out = folder.path().join("out");
        command.push(format!("--out={}", out.display()));
        if own_file_systems::are_there() {
            fs::create_dir(&out)?;
            own_file_systems::mount(&out)?;
            own_file_systems::mount(Path::new(SHARED_MEMORY))?;
            // Else nobody writes to the disk.
            command.push("--set=recorder.enabled=true".to_owned());
        }
        for set in &torture.set {
            command.push(format!("--set={set}"));
        }
        let config = configuration::Config::read(config, &torture.set)?;
        let launcher = launch(&folder, &command, 0)?;
        let mut deployment = Self {
            folder,
            root,
            command,
            launcher,
            starts: 1,
            max_age_ns: config.fusion.checkpoint.map_or(0, |checkpoint| checkpoint.max_age_ns),
            sources: config.sources.into_iter().map(|source| source.name).collect(),
            expected: Vec::new(),
            onlooker: None,
            tally: NumberTally::default(),
            latencies: Latencies::default(),
            take_overs: BTreeMap::new(),
            lost: 0,
            miscounted: Vec::new(),
        };
        deployment.until_it_runs()?;
        deployment.expected = deployment.children()?.into_keys().collect();
        Ok(deployment)
    }

    /// Whether it has what a fault needs.
    pub(super) fn has(&self, needs: Needs) -> bool {
        match needs {
            Needs::Nothing => true,
            Needs::Standby => self.expected.iter().any(|name| name == "standby"),
            Needs::OwnFileSystems => own_file_systems::are_there(),
        }
    }

    pub(super) fn root(&self) -> &Root {
        &self.root
    }

    pub(super) fn sources(&self) -> &[String] {
        &self.sources
    }

    pub(super) fn tally(&self) -> &NumberTally {
        &self.tally
    }

    /// Age beyond which fusion does not go on with the tracks of the one before, nanoseconds; 0 if it never does.
    pub(super) fn max_age_ns(&self) -> i64 {
        self.max_age_ns
    }

    /// Has the tally forget who carries which number.
    pub(super) fn forget_carriers(&mut self) {
        self.tally.forget_carriers();
    }

    /// Joins it for a moment.
    pub(super) fn bus(&self) -> anyhow::Result<Bus<SharedMemory>> {
        Ok(Bus::open(&self.root, "torture")?)
    }

    /// Process numbers of the launcher's children, by their names. Of two fusions, the one that leads is called fusion:
    /// after a take-over they have exchanged their parts, and not their command lines.
    pub(super) fn children(&self) -> anyhow::Result<BTreeMap<String, u32>> {
        let pid = self.launcher.id();
        let pids = fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).context("the launcher is gone")?;
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

    /// Sends a signal to a child, whose process number is returned.
    pub(super) fn signal(&self, name: &str, signal: Signal) -> anyhow::Result<u32> {
        let begun = instant();
        loop {
            if let Some(pid) = self.children()?.get(name).copied() {
                self.signal_process(pid, signal);
                return Ok(pid);
            }
            anyhow::ensure!(instant() - begun < PATIENCE, "there is no {name}");
            std::thread::sleep(PAUSE);
        }
    }

    /// Sends a signal to a process of the launcher's.
    pub(super) fn signal_process(&self, pid: u32, signal: Signal) {
        if let Some(pid) = i32::try_from(pid).ok().and_then(Pid::from_raw) {
            // It may have ended meanwhile.
            let _ = kill_process(pid, signal);
        }
    }

    /// Waits until a child has another process than the `dead` one.
    pub(super) fn until_started(&mut self, name: &str, dead: u32) -> anyhow::Result<u32> {
        let begun = instant();
        loop {
            if let Some(pid) = self.children()?.get(name).filter(|pid| **pid != dead) {
                return Ok(*pid);
            }
            anyhow::ensure!(instant() - begun < PATIENCE, "{name} is not started again");
            self.watch(PAUSE)?;
        }
    }

    /// Kills the launcher and starts it again.
    pub(super) fn restart(&mut self) -> anyhow::Result<()> {
        // Who looks on keeps the instance in use.
        self.look_away();
        self.launcher.kill()?;
        self.launcher.wait()?;
        self.launcher = launch(&self.folder, &self.command, self.starts)?;
        self.starts += 1;
        self.until_it_runs()
    }

    /// Looks on for a while.
    pub(super) fn watch(&mut self, time: Duration) -> anyhow::Result<()> {
        let begun = instant();
        loop {
            self.look()?;
            if instant() - begun >= time {
                return Ok(());
            }
            std::thread::sleep(PAUSE.min(time));
        }
    }

    /// Leaves the deployment, and checks what was counted as lost: what it counts, and what the numbers say.
    pub(super) fn look_away(&mut self) {
        let Some(onlooker) = self.onlooker.take() else { return };
        let counts = onlooker.tracks.counts();
        let (counted, missing) = (counts.lost - counts.lost_at_end, onlooker.sequences.lost());
        self.lost += counts.lost;
        // What is missing at the end of a publisher only its line tells; later ones are missing in both.
        if counted != missing && counts.lost != missing {
            self.miscounted
                .push(format!("{counted} samples counted as lost, {missing} by their numbers"));
        }
    }

    /// Take-overs, those from a fusion that stood still, and samples that were lost on the way to who looks on.
    pub(super) fn counted(&self) -> (u64, u64, u64) {
        let sum = |place: usize| self.take_overs.values().map(|counts| counts[place]).sum();
        (sum(0), sum(1), self.lost)
    }

    /// What was wrong with the counts of losses.
    pub(super) fn miscounted(&self) -> &[String] {
        &self.miscounted
    }

    /// What it uses of the machine now.
    pub(super) fn resources(&mut self, at_s: f64) -> anyhow::Result<Resources> {
        let mut used = Resources {
            at_s,
            files: self.memory(self.root.prefix()?)?.len() + fs::read_dir(self.root.path())?.count(),
            latency_us: self.latencies.take_median_us(),
            ..Resources::default()
        };
        used.add_process("launcher".to_owned(), self.launcher.id());
        for (name, pid) in self.children()? {
            used.add_process(name, pid);
        }
        Ok(used)
    }

    /// Files of the deployment in shared memory.
    fn memory(&self, prefix: Option<String>) -> anyhow::Result<BTreeSet<String>> {
        let prefixes: Vec<String> = prefix.into_iter().chain([self.root.kept_prefix()]).collect();
        let names = fs::read_dir(SHARED_MEMORY)?.flatten();
        let names = names.map(|entry| entry.file_name().to_string_lossy().into_owned());
        Ok(names
            .filter(|name| prefixes.iter().any(|prefix| name.starts_with(prefix)))
            .collect())
    }

    /// Makes a file system full for a while, in which nobody looks on: who maps shared memory can be killed by it.
    pub(super) fn full(&mut self, folder: &Path, time: Duration) -> anyhow::Result<()> {
        self.look_away();
        own_file_systems::fill(folder)?;
        std::thread::sleep(time);
        own_file_systems::make_room(folder)
    }

    /// Folder for recordings.
    pub(super) fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    /// Writes random octets into the shared memory of its topics.
    pub(super) fn corrupt(&mut self, random: &mut ChaCha8Rng) -> anyhow::Result<()> {
        const OCTETS: usize = 4000;
        self.look_away();
        let names = self.memory(self.root.prefix()?)?;
        let of_topics = |name: &&String| {
            [".data", ".connection", ".dynamic"]
                .iter()
                .any(|end| name.ends_with(end))
        };
        let names: Vec<&String> = names.iter().filter(of_topics).collect();
        anyhow::ensure!(!names.is_empty(), "there is no shared memory");
        for _ in 0..OCTETS {
            let path = Path::new(SHARED_MEMORY).join(names[random.random_range(0..names.len())]);
            let (share, octet) = (random.random::<f64>(), random.random::<u8>());
            // Files come and go.
            if let Ok(file) = OpenOptions::new().write(true).open(path) {
                let length = file.metadata().map_or(0, |found| found.len());
                if length > 0 {
                    let _ = file.write_at(&[octet], (share * length as f64) as u64);
                }
            }
        }
        Ok(())
    }

    fn look(&mut self) -> anyhow::Result<()> {
        if self.onlooker.is_none() {
            let bus = self.bus()?;
            let mut joined_ns = 0;
            let now_ns = || {
                joined_ns = mono_ns() as u64;
                joined_ns
            };
            self.onlooker = Some(Onlooker {
                // To see with its own eyes whether an older fusion speaks.
                tracks: bus.subscriber(&messages::system_tracks(), now_ns)?.of_all_epochs(),
                health: bus.subscriber(&messages::health(), || mono_ns() as u64)?,
                sequences: SequenceTally::default(),
                joined_ns,
            });
        }
        if let Some(onlooker) = &mut self.onlooker {
            let (tally, latencies, sequences) = (&mut self.tally, &mut self.latencies, &mut onlooker.sequences);
            onlooker.tracks.take(usize::MAX, |header, tracks| {
                sequences.take(header, tracks.len(), onlooker.joined_ns);
                for track in tracks {
                    tally.take(header.epoch, track);
                    latencies.add(track.stages.fused_ns - track.stages.ingested_ns);
                }
            })?;
            let take_overs = &mut self.take_overs;
            onlooker.health.take(usize::MAX, |_, said| {
                let is_fusion = |said: &&Health| said.kind() == Some(ProcessKind::Fusion) && said.source == NO_SOURCE;
                for said in said.iter().filter(is_fusion) {
                    let counts = [Counter::TakeOvers, Counter::TakeOversFromStill];
                    let counts = counts.map(|counter| said.counters[counter]);
                    take_overs.insert((said.process_id, said.incarnation), counts);
                }
            })?;
        }
        Ok(())
    }

    /// Waits until every process is there and states come that were sent from now on; what is missing if they do not.
    pub(super) fn until_back(&mut self, patience: Duration) -> anyhow::Result<Option<String>> {
        let (begun, begun_ns) = (instant(), mono_ns());
        loop {
            self.look()?;
            let children = self.children()?;
            let missing: Vec<&str> = self
                .expected
                .iter()
                .map(String::as_str)
                .filter(|name| !children.contains_key(*name))
                .collect();
            if missing.is_empty() && self.tally.latest_ns() > begun_ns {
                return Ok(None);
            }
            if instant() - begun > patience {
                return Ok(Some(format!(
                    "not back after {} s: missing {missing:?}, last state {:.1} s ago",
                    patience.as_secs(),
                    (mono_ns() - self.tally.latest_ns()) as f64 / 1e9
                )));
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn until_it_runs(&mut self) -> anyhow::Result<()> {
        let begun = instant();
        let words = format!("instance {INSTANCE} runs");
        while !self.said().contains(&words) {
            if let Some(status) = self.launcher.try_wait()? {
                anyhow::bail!("the deployment does not start ({status}): {}", self.said());
            }
            anyhow::ensure!(
                instant() - begun < PATIENCE,
                "the deployment does not start: {}",
                self.said()
            );
            std::thread::sleep(PAUSE);
        }
        let shown = self.tally.states();
        while self.tally.states() == shown {
            self.look()?;
            anyhow::ensure!(instant() - begun < PATIENCE, "no track is shown: {}", self.said());
            std::thread::sleep(PAUSE);
        }
        Ok(())
    }

    /// Words of the launcher of the present start.
    fn said(&self) -> String {
        fs::read_to_string(self.folder.path().join(format!("said{}", self.starts - 1))).unwrap_or_default()
    }

    /// Stops it; what is left then.
    pub(super) fn stop(mut self) -> anyhow::Result<Vec<String>> {
        self.onlooker = None;
        let prefix = self.root.prefix()?;
        self.signal_process(self.launcher.id(), Signal::TERM);
        let begun = instant();
        while self.launcher.try_wait()?.is_none() {
            anyhow::ensure!(
                instant() - begun < PATIENCE,
                "the deployment does not stop: {}",
                self.said()
            );
            std::thread::sleep(PAUSE);
        }
        let mut left: Vec<String> = self.memory(prefix)?.into_iter().collect();
        for entry in fs::read_dir(self.root.base())?.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            // A checkpoint that was refused stays, for somebody to look at.
            if !name.ends_with("-refused") {
                left.push(name);
            }
        }
        Ok(left)
    }
}

impl Drop for Deployment {
    fn drop(&mut self) {
        // Where something went wrong; its children follow.
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

fn launch(folder: &TempDir, arguments: &[String], start: usize) -> anyhow::Result<Child> {
    let said = File::create(folder.path().join(format!("said{start}")))?;
    let child = Command::new(std::env::current_exe()?)
        .args(arguments)
        .env("KOSEKI_ROOT", folder.path().join("koseki"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(said)
        .spawn();
    child.context("starting the deployment")
}
