//! Deployment of the bench: an exclusive instance, a configuration, and the processes under test.
//!
//! Fusion runs as in any deployment: the product's executable, a configuration file, topics held as by the launcher.
//! The sources are external: the bench itself publishes them. At any end of a measurement (completion, an error,
//! Ctrl-C, a panic), the bench first stops the processes and then removes every trace of the instance.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context as _, bail};
use bus::{Bus, Root, SharedMemory, Subscriber, TopicHold};
use deployment::Deployment;
use messages::{Health, LifeState, NO_SOURCE};
use runtime::clock::{instant, mono_ns};
use runtime::instance::{Instance, hold_topics};
use runtime::signals::Stop;
use rustix::process::{Pid, Signal, kill_process};

use crate::link::source_name;
use crate::product::Product;
use crate::progress;
use crate::settings::Settings;
use crate::traffic::RANGE_M;

/// Time limits of a process to report that it runs, to report its next health, and to stop.
pub(crate) const START_PATIENCE: Duration = Duration::from_secs(30);
const HEALTH_PATIENCE: Duration = Duration::from_secs(5);
const STOP_PATIENCE: Duration = Duration::from_secs(5);
/// Prefix of the bench's instance names; the process number follows.
const INSTANCES: &str = "bench-";
/// Pause between two checks of a process.
pub(crate) const PAUSE: Duration = Duration::from_millis(20);
/// Number of processes with health reports: fusion, a monitor, and spare places.
const PROCESSES: usize = 4;
/// Most system tracks that a configuration permits.
const SYSTEM_TRACKS_MAX: usize = 1_000_000;
/// Limits of a source's period in a configuration, seconds.
const PERIOD_MIN_S: f64 = 0.01;
const PERIOD_MAX_S: f64 = 600.0;

/// Deployment of the bench, see the module's documentation.
#[derive(Debug)]
pub(crate) struct BenchSite {
    /// Fields in the order of their required removal.
    topics: Option<(Vec<TopicHold>, Bus<SharedMemory>)>,
    instance: Option<Instance>,
    folder: tempfile::TempDir,
    root: Root,
    executable: PathBuf,
    stop: Stop,
}

impl BenchSite {
    /// Claims an instance and creates its topics.
    pub(crate) fn prepare(product: &dyn Product, settings: &Settings, stop: &Stop) -> anyhow::Result<Self> {
        remove_left_behind();
        let instance = format!("{INSTANCES}{}", std::process::id());
        let folder = tempfile::Builder::new().prefix(&folder_prefix(&instance)).tempdir();
        let folder = folder.context("making a folder for the configuration")?;
        let rate_per_s = settings.rates_per_s.first().copied().unwrap_or(1.0);
        let path = write_config(folder.path(), settings, rate_per_s)?;
        let config: Deployment = product.deployment(&path, &config_text(settings, rate_per_s))?;
        let claimed = Instance::claim(&config, &instance, PROCESSES, stop, progress::say)?;
        // From here on, dropping `site` cleans up after an error.
        let mut site = Self {
            topics: None,
            instance: Some(claimed),
            folder,
            root: Root::new(&instance)?,
            executable: product.executable().to_owned(),
            stop: stop.clone(),
        };
        let bus = Bus::open(&site.root, "bench")?;
        site.topics = Some((hold_topics(&config, &bus)?, bus));
        Ok(site)
    }

    pub(crate) fn root(&self) -> &Root {
        &self.root
    }

    pub(crate) fn stop_requested(&self) -> bool {
        self.stop.requested()
    }

    fn bus(&self) -> &Bus<SharedMemory> {
        &self.topics.as_ref().expect("they are there until dropped").1
    }

    /// Starts a process of the product in the instance.
    pub(crate) fn start(&self, name: &'static str, arguments: Vec<OsString>) -> anyhow::Result<Running<'_>> {
        self.start_program(&self.executable, self.root.instance(), name, arguments)
    }

    /// Starts a process of another program, possibly in another instance.
    pub(crate) fn start_program(
        &self,
        program: &Path,
        instance: &str,
        name: &'static str,
        arguments: Vec<OsString>,
    ) -> anyhow::Result<Running<'_>> {
        let child = Command::new(program)
            .args(arguments)
            .args(["--instance", instance, "--launcher"])
            .arg(std::process::id().to_string())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            // Ctrl-C is for the bench, which then stops the process.
            .process_group(0)
            .spawn()
            .with_context(|| format!("starting {name}"))?;
        Ok(Running {
            child,
            name,
            site: self,
        })
    }

    /// Starts fusion for reports at `rate_per_s`, and waits until it runs.
    pub(crate) fn start_fusion(&self, settings: &Settings, rate_per_s: f64) -> anyhow::Result<FusionProcess<'_>> {
        let path = write_config(self.folder.path(), settings, rate_per_s)?;
        let running = self.start("fusion", vec!["fusion".into(), "--config".into(), path.clone().into()])?;
        let mut fusion = FusionProcess {
            heard: self.hear(running)?,
            config: path,
        };
        fusion.heard.until_running()?;
        Ok(fusion)
    }

    /// Subscribes to the health of a process of the instance.
    pub(crate) fn hear<'a>(&'a self, running: Running<'a>) -> anyhow::Result<ReportingProcess<'a>> {
        let health = self.bus().subscriber(&messages::health(), || mono_ns() as u64)?;
        Ok(ReportingProcess::of(health, None, running))
    }
}

impl Drop for BenchSite {
    fn drop(&mut self) {
        drop(self.topics.take());
        if let Some(instance) = self.instance.take()
            && let Err(error) = instance.clear()
        {
            progress::say(&format!("{error:#}"));
        }
    }
}

/// Child process, stopped on drop.
#[derive(Debug)]
pub(crate) struct Running<'a> {
    child: Child,
    name: &'static str,
    site: &'a BenchSite,
}

impl Running<'_> {
    pub(crate) fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Returns an error if the process has ended, or if the bench received a stop request.
    pub(crate) fn check(&mut self) -> anyhow::Result<()> {
        if self.site.stop_requested() {
            bail!("stopped before the end; no figures are shown");
        }
        match self.child.try_wait()? {
            None => Ok(()),
            Some(status) => bail!("{} has ended early ({status}); its reason is above", self.name),
        }
    }

    fn signal(&self, signal: Signal) {
        // Signalling fails only after the process has ended; the process number stays reserved until it is reaped.
        let _ = kill_process(Pid::from_child(&self.child), signal);
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.signal(Signal::TERM);
        let start = instant();
        while matches!(self.child.try_wait(), Ok(None)) {
            if instant() - start > STOP_PATIENCE {
                self.signal(Signal::KILL);
                let _ = self.child.wait();
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        self.site.bus().remove_dead();
    }
}

/// Process with health messages.
#[derive(Debug)]
pub(crate) struct ReportingProcess<'a> {
    /// Declared before the process, hence dropped first: a process with a separate instance waits for all readers
    /// to leave.
    health: Subscriber<SharedMemory, Health>,
    _bus: Option<Bus<SharedMemory>>,
    running: Running<'a>,
    /// Latest health message of the process.
    latest: Option<Health>,
}

impl<'a> ReportingProcess<'a> {
    /// Creates the watched process; `bus` is the bus of its own instance, if any.
    pub(crate) fn of(
        health: Subscriber<SharedMemory, Health>,
        bus: Option<Bus<SharedMemory>>,
        running: Running<'a>,
    ) -> Self {
        Self {
            health,
            _bus: bus,
            running,
            latest: None,
        }
    }

    pub(crate) fn pid(&self) -> u32 {
        self.running.pid()
    }

    /// Returns an error if the process has ended, or if the bench received a stop request.
    fn check(&mut self) -> anyhow::Result<()> {
        let (latest, pid) = (&mut self.latest, self.running.pid());
        self.health.take(usize::MAX, |_, said| {
            for health in said {
                if health.process_id == pid && health.source == NO_SOURCE {
                    *latest = Some(*health);
                }
            }
        })?;
        self.running.check()
    }

    pub(crate) fn until_running(&mut self) -> anyhow::Result<()> {
        self.until(START_PATIENCE, "said that it runs", |whole| {
            whole.life() == Some(LifeState::Running)
        })?;
        Ok(())
    }

    /// Returns the first health message sent after `mono_ns`.
    pub(crate) fn said_after(&mut self, mono_ns: i64) -> anyhow::Result<Health> {
        self.until(HEALTH_PATIENCE, "said how it is", |whole| whole.said_ns > mono_ns)
    }

    /// Returns the first health message that satisfies `condition`.
    pub(crate) fn until(
        &mut self,
        patience: Duration,
        what: &str,
        condition: impl Fn(&Health) -> bool,
    ) -> anyhow::Result<Health> {
        let start = instant();
        loop {
            self.check()?;
            if let Some(whole) = self.latest.filter(|whole| condition(whole)) {
                return Ok(whole);
            }
            if instant() - start > patience {
                bail!("{} has not {what} within {} s", self.running.name, patience.as_secs());
            }
            std::thread::sleep(PAUSE);
        }
    }
}

/// Fusion process.
#[derive(Debug)]
pub(crate) struct FusionProcess<'a> {
    heard: ReportingProcess<'a>,
    config: PathBuf,
}

impl FusionProcess<'_> {
    pub(crate) fn pid(&self) -> u32 {
        self.heard.pid()
    }

    /// Returns the configuration file.
    pub(crate) fn config(&self) -> &Path {
        &self.config
    }

    /// Returns an error if the process has ended, or if the bench received a stop request.
    pub(crate) fn check(&mut self) -> anyhow::Result<()> {
        self.heard.check()
    }

    /// Returns the counters of the whole process from a health message after `mono_ns`.
    pub(crate) fn counters_after(&mut self, mono_ns: i64) -> anyhow::Result<Health> {
        self.heard.said_after(mono_ns)
    }
}

/// Removes the remains of killed benches: a killed bench cannot clean up, and later benches have other names.
fn remove_left_behind() {
    // Failures to list or remove do not prevent a measurement; `koseki status` shows the remains.
    for left in Root::list(bus::base::find()).unwrap_or_default() {
        let name = left.root.instance();
        if left.runs || !name.starts_with(INSTANCES) {
            continue;
        }
        if let Ok(claim) = left.root.claim()
            && claim.remove().is_ok()
        {
            remove_folders(&folder_prefix(name));
            progress::say(&format!("removed the remains of a killed bench in instance {name}"));
        }
    }
}

/// Returns the name prefix of the folder with an instance's configuration.
fn folder_prefix(instance: &str) -> String {
    format!("koseki-{instance}-")
}

fn remove_folders(prefix: &str) {
    let folders = std::fs::read_dir(std::env::temp_dir()).into_iter().flatten().flatten();
    for folder in folders.filter(|folder| folder.file_name().to_string_lossy().starts_with(prefix)) {
        // Failures are ignored as above.
        let _ = std::fs::remove_dir_all(folder.path());
    }
}

/// Writes the configuration for reports at `rate_per_s`.
fn write_config(folder: &Path, settings: &Settings, rate_per_s: f64) -> anyhow::Result<PathBuf> {
    let path = folder.join("bench.toml");
    std::fs::write(&path, config_text(settings, rate_per_s)).with_context(|| format!("writing {}", path.display()))?;
    Ok(path)
}

/// Returns the configuration of a deployment whose sources the bench publishes at `rate_per_s` in total.
pub(crate) fn config_text(settings: &Settings, rate_per_s: f64) -> String {
    let period_s = settings.period_s(rate_per_s).clamp(PERIOD_MIN_S, PERIOD_MAX_S);
    let (targets, sources) = (settings.targets as usize, usize::from(settings.sources));
    // With spare places, as far as there can be.
    let systems = (targets + targets / 4 + 100).min(SYSTEM_TRACKS_MAX);
    let mut text = format!(
        "name = \"bench\"\n\
         [frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n\
         [monitor]\nfiles = false\n\
         [recorder]\nenabled = false\n\
         [fusion]\nwait = \"{}\"\ncore = {}\nlock_memory = {}\n",
        settings.wait.word(),
        settings.fusion_core,
        settings.lock_memory
    );
    if let Some(priority) = settings.realtime_priority {
        let _ = writeln!(text, "realtime_priority = {priority}");
    }
    let _ = write!(
        text,
        "[fusion.capacity]\nsystem_tracks = {}\nsensor_tracks = {}\n\
         [fusion.association]\ncell_m = 1000.0\n\
         [fusion.life]\nterminate_s = {}\n",
        systems,
        sources * systems,
        (10.0 * period_s).max(30.0)
    );
    if let Some(rule) = &settings.rule {
        let _ = writeln!(text, "[fusion.rule]\nname = \"{rule}\"");
    }
    for number in 0..settings.sources {
        let _ = write!(
            text,
            "[[source]]\nname = \"{}\"\nperiod_s = {period_s}\n[source.external]\n\
             [source.limits]\nrange_m = {RANGE_M:.1}\n\
             [source.accuracy]\nmodel = \"constant\"\nsigma_m = 10.0\n",
            source_name(number)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use configuration::Config;

    use super::*;
    use crate::settings::test_settings;

    #[test]
    fn its_configurations_are_sound() {
        let cores = runtime::cores::available();
        for (targets, sources, rate) in [
            (1, 1, 1.0),
            (100, 2, 20e3),
            (100_000, 4, 1e6),
            (100, 64, 1e5),
            (1_000_000, 1, 1e6),
        ] {
            let settings = Settings {
                targets,
                sources,
                fusion_core: cores[0],
                realtime_priority: Some(50),
                lock_memory: true,
                rule: Some("covariance-intersection".to_owned()),
                ..test_settings()
            };
            let config = Config::parse(Path::new("bench.toml"), &config_text(&settings, rate), &[]).unwrap();
            assert_eq!(config.sources.len(), usize::from(sources));
            assert!(config.adapters().is_empty() && !config.is_recorded());
            // A million places take a while to fill.
            if targets < 1_000_000 {
                fusion::Engine::new(config.engine.clone()).unwrap();
            }
        }
    }
}
