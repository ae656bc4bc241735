//! One measurement: a fresh process under test, warmed up, then the load.
//!
//! No figure includes the warm-up. The warm-up ends when a whole round over all targets and sources was answered by
//! exactly one confirmed state per report: then every target has its system track, every page is touched and every
//! table filled. A short stretch at the measured rate follows, which adapts the caches to the rate.

use std::ffi::OsString;
use std::sync::Arc;

use anyhow::Context as _;
use bus::{Bus, SharedMemory};
use messages::{Counter, NO_SOURCE};
use runtime::Now;
use serde::{Deserialize, Serialize};

use crate::drive::{Clock as _, Load, MachineClock, SendProgress};
use crate::exchange::{Exchange, OneThread, TwoThreads};
use crate::jitter::Jitter;
use crate::link::{FromFusion, FromRelay, ToFusion, ToRelay, relay_settings};
use crate::memory::ProcessMemory;
use crate::pace::Pace;
use crate::pinned;
use crate::recorder::{Recorder, StateCounts};
use crate::ring;
use crate::settings::{Settings, Wait};
use crate::site::{BenchSite, FusionProcess, Running};
use crate::subscribers::Subscribers;
use crate::traffic::Traffic;

/// Maximum number of warm-up rounds.
const WARM_UP_ROUNDS_MAX: u32 = 40;
/// Rate and slice length of the warm-up; slow enough to lose nothing.
const WARM_UP_RATE: f64 = 60_000.0;
const WARM_UP_BATCH: usize = 16;
/// Duration of the last part of the warm-up, at the measured rate, seconds.
const LAST_WARM_UP_S: f64 = 0.3;
/// Time from now until the first batch of a load is due, nanoseconds.
const LEAD_NS: i64 = 2_000_000;

/// Load of one measurement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LoadPlan {
    /// Reports per second.
    pub(crate) rate_per_s: f64,
    /// Duration at that rate, seconds.
    pub(crate) seconds: f64,
    /// Whether every stage is recorded.
    pub(crate) detailed: bool,
}

/// Result of a measurement.
#[derive(Debug)]
pub(crate) struct MeasurementResult {
    pub(crate) recorder: Recorder,
    pub(crate) driven: SendProgress,
    pub(crate) warm_up: WarmUp,
    /// Memory of the process under test, before and after.
    pub(crate) memory: [ProcessMemory; 2],
    /// Reports sent to the process since the start.
    pub(crate) sent_ever: u64,
    /// Counts of fusion since the start; `None` for a relay.
    pub(crate) fusion: Option<FusionCounts>,
}

/// Course of the warm-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WarmUp {
    /// Reports sent during the warm-up, excluded from all figures.
    pub reports: u64,
    /// Duration, seconds.
    pub seconds: f64,
    /// Whether every report of its last round was answered by exactly one confirmed state.
    pub settled: bool,
}

/// Counts made by fusion itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FusionCounts {
    /// Reports taken.
    pub taken: u64,
    /// Reports missing from the sequence numbers.
    pub lost: u64,
    /// System tracks published.
    pub published: u64,
    /// System tracks missed by the bench's own reader.
    pub lost_by_reader: u64,
}

impl MeasurementResult {
    /// Returns the reports sent in the measured time.
    pub(crate) fn sent(&self, batch: usize) -> u64 {
        self.driven.batches * batch as u64
    }

    /// Returns the unanswered reports of the measured time, without those of a flooding source.
    pub(crate) fn unanswered(&self) -> u64 {
        self.recorder.unanswered(self.driven.batches)
    }

    /// Returns the unanswered reports of the flooding source's own share.
    pub(crate) fn flood_unanswered(&self) -> u64 {
        self.recorder.flood_unanswered(self.driven.batches)
    }

    pub(crate) fn received(&self) -> StateCounts {
        self.recorder.counts()
    }
}

/// Starts the relay; `over_bus` in fusion's place, with its topics.
fn start_relay<'a>(
    site: &'a BenchSite,
    settings: &Settings,
    plan: LoadPlan,
    over_bus: bool,
) -> anyhow::Result<Running<'a>> {
    let mut arguments: Vec<OsString> = vec!["bench-relay".into()];
    let mut option = |name: &str, value: String| arguments.extend([name.into(), value.into()]);
    option("--wait", settings.wait.word().to_owned());
    option("--core", settings.fusion_core.to_string());
    let slice_len = slice_len(settings);
    option("--slice", slice_len.to_string());
    option("--sources", settings.sources.to_string());
    if let Some(priority) = settings.realtime_priority {
        option("--realtime-priority", priority.to_string());
    }
    let pace = Pace::new(0, plan.rate_per_s / settings.batch as f64, rests(settings));
    if let Some((idle_ns, sleep_ns)) = pace.idle_rest_ns() {
        option("--rest-after-ns", idle_ns.to_string());
        option("--rest-ns", sleep_ns.to_string());
    }
    if settings.lock_memory {
        arguments.push("--lock-memory".into());
    }
    if over_bus {
        arguments.push("--over-bus".into());
    }
    let itself = std::env::current_exe().context("finding the program of the relay")?;
    site.start_program(&itself, site.root().instance(), "the relay", arguments)
}

/// Most reports in a slice, also while warming up.
fn slice_len(settings: &Settings) -> usize {
    settings.batch.max(WARM_UP_BATCH)
}

/// Measures the relay over the topics of fusion, in fusion's place; both ends spin.
pub(crate) fn over_bus(site: &BenchSite, settings: &Settings, plan: LoadPlan) -> anyhow::Result<MeasurementResult> {
    let mut running = start_relay(site, settings, plan, true)?;
    let (pid, root) = (running.pid(), site.root());
    pinned::run(
        settings.bench_place(),
        || running.check(),
        |abort| {
            let bus = Bus::<SharedMemory>::open_for_few(root, "bench")?;
            let mut exchange = OneThread {
                sender: ToFusion::open(&bus, settings)?,
                receiver: FromFusion::open(&bus, Wait::Spin.mode())?,
                abort: Arc::clone(abort),
            };
            carry_out(&mut exchange, settings, plan, pid, false)
        },
    )
}

/// Measures a pair of rings between two threads of this process, the least that passing a report on can take.
pub(crate) fn ring(site: &BenchSite, settings: &Settings, plan: LoadPlan) -> anyhow::Result<MeasurementResult> {
    let watch = || match site.stop_requested() {
        true => anyhow::bail!("stopped before the end; no figures are shown"),
        false => Ok(()),
    };
    let pace = Pace::new(0, plan.rate_per_s / settings.batch as f64, rests(settings));
    let echo = ring::Echo::start(settings, pace.idle_rest_ns());
    pinned::run(settings.bench_place(), watch, |abort| {
        let mut exchange = OneThread {
            sender: echo.sender(),
            receiver: echo.receiver(),
            abort: Arc::clone(abort),
        };
        carry_out(&mut exchange, settings, plan, std::process::id(), false)
    })
}

/// Measures the relay.
pub(crate) fn relay(site: &BenchSite, settings: &Settings, plan: LoadPlan) -> anyhow::Result<MeasurementResult> {
    let slice_len = slice_len(settings);
    let mut running = start_relay(site, settings, plan, false)?;
    let pid = running.pid();
    let bare = relay_settings(slice_len, settings.wait != Wait::Spin, settings.sources);
    let root = site.root();
    pinned::run(
        settings.bench_place(),
        || running.check(),
        |abort| {
            let bus = Bus::<SharedMemory>::open_for_few(root, "bench")?;
            let sender = ToRelay::open(&bus, bare)?;
            let mut exchange: Box<dyn Exchange> = match settings.wait {
                Wait::Event => {
                    let root = root.clone();
                    let receiver = move || FromRelay::open(&Bus::open_for_few(&root, "bench-reader")?, bare);
                    Box::new(TwoThreads::new(sender, receiver, Arc::clone(abort))?)
                }
                Wait::Spin | Wait::Hybrid => {
                    let receiver = FromRelay::open(&bus, relay_settings(slice_len, false, settings.sources))?;
                    Box::new(OneThread {
                        sender,
                        receiver,
                        abort: Arc::clone(abort),
                    })
                }
            };
            // The floor has one queue for all sources: a flood in it would not represent the pipeline.
            carry_out(exchange.as_mut(), settings, plan, pid, false)
        },
    )
}

/// Measures fusion.
pub(crate) fn pipeline(site: &BenchSite, settings: &Settings, plan: LoadPlan) -> anyhow::Result<MeasurementResult> {
    let fusion = site.start_fusion(settings, plan.rate_per_s)?;
    let _subscribers = Subscribers::start(site, settings.subscribers, true)?;
    running_pipeline(site, fusion, settings, plan)
}

/// Measures a running fusion process, and stops it.
pub(crate) fn running_pipeline(
    site: &BenchSite,
    mut fusion: FusionProcess<'_>,
    settings: &Settings,
    plan: LoadPlan,
) -> anyhow::Result<MeasurementResult> {
    let (pid, root) = (fusion.pid(), site.root());
    let mut measured = pinned::run(
        settings.bench_place(),
        || fusion.check(),
        |abort| {
            let bus = Bus::<SharedMemory>::open_for_few(root, "bench")?;
            let sender = ToFusion::open(&bus, settings)?;
            let mut exchange: Box<dyn Exchange> = match settings.wait {
                Wait::Event => {
                    let root = root.clone();
                    let receiver =
                        move || FromFusion::open(&Bus::open_for_few(&root, "bench-reader")?, Wait::Event.mode());
                    Box::new(TwoThreads::new(sender, receiver, Arc::clone(abort))?)
                }
                Wait::Spin | Wait::Hybrid => Box::new(OneThread {
                    sender,
                    receiver: FromFusion::open(&bus, Wait::Spin.mode())?,
                    abort: Arc::clone(abort),
                }),
            };
            carry_out(exchange.as_mut(), settings, plan, pid, true)
        },
    )?;
    let whole = fusion.counters_after(MachineClock.now_ns())?;
    debug_assert_eq!(whole.source, NO_SOURCE);
    measured.fusion = Some(FusionCounts {
        taken: whole.counters[Counter::Taken],
        lost: whole.counters[Counter::Lost],
        published: whole.counters[Counter::Published],
        lost_by_reader: measured.received().missed,
    });
    Ok(measured)
}

/// Reads the clock on the bench's core, with nothing under test.
pub(crate) fn jitter(site: &BenchSite, settings: &Settings, plan: LoadPlan) -> anyhow::Result<Jitter> {
    let rests = rests(settings);
    let watch = || match site.stop_requested() {
        true => anyhow::bail!("stopped before the end; no figures are shown"),
        false => Ok(()),
    };
    let rate = plan.rate_per_s / settings.batch as f64;
    pinned::run(settings.bench_place(), watch, |_| {
        Ok(Jitter::measure(&MachineClock, plan.seconds, rate, rests))
    })
}

/// Whether the threads of the bench must rest regularly.
fn rests(settings: &Settings) -> bool {
    settings.realtime_priority.is_some()
}

fn carry_out(
    exchange: &mut dyn Exchange,
    settings: &Settings,
    plan: LoadPlan,
    pid: u32,
    with_flood: bool,
) -> anyhow::Result<MeasurementResult> {
    let now = Now::read();
    let utc_offset_ns = now.utc_ns - now.mono_ns;
    let mut traffic = Traffic::new(
        settings.targets,
        settings.sources,
        WARM_UP_BATCH.min(settings.targets as usize).max(settings.batch),
        now.mono_ns,
        utc_offset_ns,
    );
    let warm_up = warm_up(exchange, settings, plan, &mut traffic)?;
    let before = ProcessMemory::of(pid).context("reading the memory of the process under test")?;
    let (load, recorder) = load(&traffic, settings, plan, plan.seconds, with_flood);
    let (driven, recorder) = exchange.run(&load, recorder)?;
    let after = ProcessMemory::of(pid).context("reading the memory of the process under test")?;
    let sent = (driven.batches + driven.flood_batches) * settings.batch as u64;
    Ok(MeasurementResult {
        recorder,
        driven,
        warm_up,
        memory: [before, after],
        sent_ever: warm_up.reports + sent,
        fusion: None,
    })
}

fn warm_up(
    exchange: &mut dyn Exchange,
    settings: &Settings,
    plan: LoadPlan,
    traffic: &mut Traffic,
) -> anyhow::Result<WarmUp> {
    let clock = MachineClock;
    let start_ns = clock.now_ns();
    let mut warm_up = WarmUp::default();
    for _ in 0..WARM_UP_ROUNDS_MAX {
        let batches = traffic.round();
        let batch = traffic.batch();
        let pace = Pace::new(clock.now_ns() + LEAD_NS, WARM_UP_RATE / batch as f64, rests(settings));
        let load = Load {
            traffic,
            pace,
            batches,
            rests: rests(settings),
            flood: None,
        };
        let (driven, recorder) = exchange.run(&load, Recorder::new(pace, batches, batch, false))?;
        warm_up.reports += driven.batches * batch as u64;
        let odd = recorder.unanswered(batches) + recorder.beyond_one() + recorder.counts().unconfirmed;
        warm_up.settled = odd == 0;
        if warm_up.settled {
            break;
        }
    }
    traffic.set_batch(settings.batch);
    let (load, recorder) = load(traffic, settings, plan, LAST_WARM_UP_S.min(plan.seconds), false);
    let (driven, _) = exchange.run(&load, recorder)?;
    warm_up.reports += driven.batches * settings.batch as u64;
    warm_up.seconds = (clock.now_ns() - start_ns) as f64 * 1e-9;
    Ok(warm_up)
}

fn load<'a>(
    traffic: &'a Traffic,
    settings: &Settings,
    plan: LoadPlan,
    seconds: f64,
    with_flood: bool,
) -> (Load<'a>, Recorder) {
    let rate = plan.rate_per_s / settings.batch as f64;
    let batches = ((seconds * rate).round() as u64).max(1);
    // The recorder allocates memory before the first report is due.
    let mut recorder = Recorder::new(Pace::new(0, rate, false), batches, settings.batch, plan.detailed);
    let pace = Pace::new(MachineClock.now_ns() + LEAD_NS, rate, rests(settings));
    recorder.set_pace(pace);
    let flood = settings.flood.filter(|_| with_flood).map(|flood| {
        let own_rate = rate / f64::from(settings.sources);
        let further = (own_rate * (flood.factor - 1.0)).max(1e-3);
        (flood.source, Pace::new(pace.due_ns(0), further, rests(settings)))
    });
    let load = Load {
        traffic,
        pace,
        batches,
        rests: rests(settings),
        flood,
    };
    if let Some((source, _)) = flood {
        recorder = recorder.with_flooding(source, traffic.sources());
    }
    (load, recorder)
}
