//! The deployment that suffers, in a folder of its own.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Root, SharedMemory, Subscriber};
use messages::SystemTrack;
use runtime::clock::{instant, mono_ns};
use runtime::instance::leading_fusion;
use rustix::process::{Pid, Signal, kill_process};
use scoring::NumberTally;
use tempfile::TempDir;

use super::faults::Needs;
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
    /// Names of the children, once all run.
    expected: Vec<String>,
    subscriber: Option<Subscriber<SharedMemory, SystemTrack>>,
    tally: NumberTally,
}

impl Deployment {
    /// Starts it, and waits until it runs and shows tracks.
    pub(super) fn start(torture: &Torture) -> anyhow::Result<Self> {
        let folder = TempDir::new().context("making a folder")?;
        let root = Root::in_base(folder.path().join("koseki"), INSTANCE)?;
        let (mut command, config) = match &torture.config {
            Some(path) => {
                let path = path.display().to_string();
                (vec!["up".to_owned(), path.clone()], path)
            }
            None => (vec!["demo".to_owned()], configuration::BUILT_IN_DEMO.to_owned()),
        };
        command.push(format!("--instance={INSTANCE}"));
        command.push(format!("--out={}", folder.path().join("out").display()));
        for set in &torture.set {
            command.push(format!("--set={set}"));
        }
        let config = configuration::Config::read(std::path::Path::new(&config), &torture.set)?;
        let launcher = launch(&folder, &command, 0)?;
        let mut deployment = Self {
            folder,
            root,
            command,
            launcher,
            starts: 1,
            sources: config.sources.into_iter().map(|source| source.name).collect(),
            expected: Vec::new(),
            subscriber: None,
            tally: NumberTally::default(),
        };
        deployment.until_it_runs()?;
        deployment.expected = deployment.children()?.into_keys().collect();
        Ok(deployment)
    }

    /// Whether it has what a fault needs.
    pub(super) fn has(&self, needs: Needs) -> bool {
        needs == Needs::Nothing || self.expected.iter().any(|name| name == "standby")
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
        self.subscriber = None;
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

    fn look(&mut self) -> anyhow::Result<()> {
        if self.subscriber.is_none() {
            let bus = self.bus()?;
            let subscriber = bus.subscriber(&messages::system_tracks(), || mono_ns() as u64)?;
            self.subscriber = Some(subscriber.of_all_epochs());
        }
        if let Some(subscriber) = &mut self.subscriber {
            let tally = &mut self.tally;
            subscriber.take(usize::MAX, |header, tracks| {
                tracks.iter().for_each(|track| tally.take(header.epoch, track));
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
        self.subscriber = None;
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
        let mut left = Vec::new();
        for entry in fs::read_dir(self.root.base())?.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            // A checkpoint that was refused stays, for somebody to look at.
            if !name.ends_with("-refused") {
                left.push(name);
            }
        }
        for entry in fs::read_dir("/dev/shm")?.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if prefix.as_ref().is_some_and(|prefix| name.starts_with(prefix)) {
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
