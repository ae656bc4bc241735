//! Link that sends the system tracks to mirrors on this host, with an account of each state.
//!
//! Everything runs on one machine, so the measured cost is processor time. The scheduler places link and mirrors,
//! beside fusion and the bench.

use std::ffi::OsString;
use std::fs;
use std::io::Write as _;
use std::net::TcpListener;
use std::time::Instant;

use anyhow::Context as _;
use bus::{Bus, Root, SharedMemory};
use messages::{Counter, Health, system_tracks};
use runtime::clock::{instant, mono_ns};
use serde::Serialize;

use crate::memory::ProcessMemory;
use crate::site::{BenchSite, FusionProcess, PAUSE, ReportingProcess, START_PATIENCE};

/// Name of the link.
const NAME: &str = "out";

/// Link and its mirrors; dropping this value stops them.
pub(crate) struct LinkWithMirrors<'a> {
    link: ReportingProcess<'a>,
    mirrors: Vec<ReportingProcess<'a>>,
    begun: Instant,
    /// Processor time so far, of the link and of the mirrors, seconds.
    spent_s: (f64, f64),
}

/// Account of the states, and cost.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct LinkAccount {
    /// States due to be sent by the link, to each mirror.
    pub(crate) states: u64,
    /// Number of arrivals at a mirror.
    pub(crate) came: u64,
    /// Replacements by a newer state of the same track.
    pub(crate) conflated: u64,
    /// States lost in transit and counted by a mirror.
    pub(crate) lost: u64,
    /// States that neither arrived nor were counted.
    pub(crate) unaccounted: i64,
    /// Duration of the measurement, seconds.
    pub(crate) seconds: f64,
    /// Mean number of processors used by the link.
    pub(crate) link_cores: f64,
    /// Number of processors used by all mirrors.
    pub(crate) mirror_cores: f64,
    /// Physical memory of the link, megabytes.
    pub(crate) link_mb: f64,
    /// Mean physical memory of a mirror, megabytes.
    pub(crate) mirror_mb: f64,
}

impl<'a> LinkWithMirrors<'a> {
    /// Starts a link for `fusion` and `mirrors` mirrors, and waits until they are connected.
    pub(crate) fn start(site: &'a BenchSite, fusion: &FusionProcess<'_>, mirrors: usize) -> anyhow::Result<Self> {
        let port = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
        let endpoint = format!("tcp/127.0.0.1:{port}");
        let config = fusion.config().with_extension("link.toml");
        fs::copy(fusion.config(), &config)?;
        let topic = system_tracks();
        let topic = topic.name.as_str();
        let mut file = fs::File::options().append(true).open(&config)?;
        writeln!(
            file,
            "[[link]]\nname = \"{NAME}\"\nlisten = [\"{endpoint}\"]\nsend = [\"{topic}\"]"
        )?;
        let arguments: [OsString; 5] = [
            "link".into(),
            "--config".into(),
            config.clone().into(),
            "--name".into(),
            NAME.into(),
        ];
        let mut link = site.hear(site.start("the link", arguments.to_vec())?)?;
        link.until_running()?;
        // `koseki link` has replaced itself with this program.
        let program = fs::read_link(format!("/proc/{}/exe", link.pid())).context("finding koseki-link")?;
        let mut all = Vec::new();
        for number in 0..mirrors {
            let instance = format!("{}-mirror-{number}", site.root().instance());
            let mut arguments: Vec<OsString> = vec!["mirror".into(), "--config".into(), config.clone().into()];
            arguments.extend(["--connect", &endpoint, "--topics", topic].map(OsString::from));
            let running = site.start_program(&program, &instance, "a mirror", arguments)?;
            let root = Root::new(&instance)?;
            let begun = instant();
            let (bus, health) = loop {
                let bus = Bus::<SharedMemory>::open_for_few(&root, "bench");
                let opened = bus.and_then(|bus| Ok((bus.subscriber(&messages::health(), || mono_ns() as u64)?, bus)));
                match opened {
                    Ok((health, bus)) => break (bus, health),
                    Err(error) if instant() - begun > START_PATIENCE => return Err(error).context("reading a mirror"),
                    Err(_) => std::thread::sleep(PAUSE),
                }
            };
            all.push(ReportingProcess::of(health, Some(bus), running));
        }
        for mirror in &mut all {
            mirror.until(START_PATIENCE, "met the link", |said| {
                said.counters[Counter::MissingPeers] == 0
            })?;
        }
        let mut links = Self {
            link,
            mirrors: all,
            begun: instant(),
            spent_s: (0.0, 0.0),
        };
        links.spent_s = links.spent()?;
        Ok(links)
    }

    fn spent(&self) -> anyhow::Result<(f64, f64)> {
        let mirrors: anyhow::Result<f64> = self.mirrors.iter().map(|mirror| processor_time_s(mirror.pid())).sum();
        Ok((processor_time_s(self.link.pid())?, mirrors?))
    }

    /// Returns the account of all states published by fusion, once the mirrors receive nothing more.
    pub(crate) fn carried(mut self) -> anyhow::Result<LinkAccount> {
        let seconds = (instant() - self.begun).as_secs_f64();
        let (link_s, mirrors_s) = self.spent()?;
        // The last states are still in transit.
        let (mut said, mut quiet) = (Vec::new(), 0);
        while quiet < QUIET {
            let now_ns = mono_ns();
            let mut ends = vec![&mut self.link];
            ends.extend(&mut self.mirrors);
            let now: anyhow::Result<Vec<Health>> = ends.into_iter().map(|end| end.said_after(now_ns)).collect();
            let counted = |all: &[Health]| all.iter().map(balance).collect::<Vec<_>>();
            let now = now?;
            quiet = if counted(&said) == counted(&now) { quiet + 1 } else { 0 };
            said = now;
        }
        let mb = |end: &ReportingProcess<'_>| {
            ProcessMemory::of(end.pid()).map(|memory| memory.resident_pages as f64 * 4096e-6)
        };
        let mirrors: anyhow::Result<f64> = self.mirrors.iter().map(mb).sum();
        let all = |counter: Counter| said[1..].iter().map(|mirror| mirror.counters[counter]).sum::<u64>();
        let states = said[0].counters[Counter::Taken] + said[0].counters[Counter::Lost];
        let (came, conflated, lost) = (all(Counter::Taken), all(Counter::Conflated), all(Counter::LostOnTheWay));
        let count = self.mirrors.len();
        Ok(LinkAccount {
            states,
            came,
            conflated,
            lost,
            unaccounted: (states * count as u64) as i64 - (came + conflated + lost) as i64,
            seconds,
            link_cores: (link_s - self.spent_s.0) / seconds,
            mirror_cores: (mirrors_s - self.spent_s.1) / seconds,
            link_mb: mb(&self.link)?,
            mirror_mb: mirrors? / count as f64,
        })
    }
}

/// Number of health messages with equal counts after which nothing is in transit.
const QUIET: usize = 5;

fn balance(said: &Health) -> u64 {
    [Counter::Taken, Counter::LostOnTheWay, Counter::Conflated]
        .map(|counter| said.counters[counter])
        .iter()
        .sum()
}

/// Returns the processor time of all threads of a process, seconds.
fn processor_time_s(pid: u32) -> anyhow::Result<f64> {
    let threads = fs::read_dir(format!("/proc/{pid}/task")).with_context(|| format!("finding process {pid}"))?;
    let of_thread = |thread: fs::DirEntry| {
        // A thread that has just ended does not count.
        let said = fs::read_to_string(thread.path().join("schedstat")).unwrap_or_default();
        let first = said.split(' ').next().and_then(|word| word.parse::<f64>().ok());
        first.unwrap_or(0.0) * 1e-9
    };
    Ok(threads.flatten().map(of_thread).sum())
}
