//! `koseki bench`: arguments and help.

use std::path::PathBuf;

use bench_service::relay::RelayOptions;
use bench_service::{Extra, Flood, OutputFiles, Settings, Wait};
use clap::{Args, Subcommand, ValueEnum};
use command_line::values::above_zero;
use runtime::cores::Placement;

use super::tracker::{TRACKER_EXAMPLES, TrackerArgs};

/// Rates of a sweep, reports per second.
const SWEEP: [f64; 9] = [1e3, 2e3, 5e3, 10e3, 20e3, 50e3, 100e3, 200e3, 500e3];
/// Rate unless another is given: where processes spin, and where they must be woken.
const RATE_SPIN: f64 = 20_000.0;
const RATE_EVENT: f64 = 2_000.0;

pub(super) const BENCH_EXAMPLES: &str = "\
Examples:
  koseki bench latency                                    20,000 reports/s, spinning, five runs
  koseki bench latency --rate 1000,20000 --json now.json  two rates, all figures in a file
  koseki bench compare before.json now.json               significant differences between two runs

Every command starts its own fusion process in a separate instance, and removes the instance at the end. Measure on an
otherwise idle machine: other programs enlarge the tails of all distributions.";

const LATENCY_EXAMPLES: &str = "\
Examples:
  koseki bench latency --rate 20000 --targets 1000
  koseki bench latency --sweep --json sweep.json --picture latency.svg --percentiles histograms
  koseki bench latency --wait event --rate 1000
  koseki bench latency --realtime-priority 80 --lock-memory          needs privileges (root, or ulimit -r and -l)
  koseki bench latency --sources 8 --flood 3=50                      source 3 sends fifty times its share

Reports are due at fixed times, and latency counts from the due time: a stall therefore appears in every delayed report.
Each run measures in turn the floor (a process that only forwards the payload), the pipeline, and the machine alone.
Select the cores with care: two logical cores of the same physical core disturb each other.";

const ENGINE_EXAMPLES: &str = "\
Examples:
  koseki bench engine --targets 1000
  koseki bench engine --targets 100000 --sources 8 --rule covariance-intersection
  koseki bench engine --targets 1000000 --sources 2 --runs 1

The same reports as in the other measurements, without shared memory and processes: the cost of fusing a report.";

const FLOOR_EXAMPLES: &str = "\
Examples:
  koseki bench floor
  koseki bench floor --runs 9 --realtime-priority 40 --json floor.json

Round trips of the same reports through two rings between threads, a relay with bare iceoryx2 ports, a relay over the bus,
and fusion, in turns; all spin. The best round of each shows what the machine can do.";

const THROUGHPUT_EXAMPLES: &str = "\
Examples:
  koseki bench throughput --targets 1000
  koseki bench throughput --batch 16 --seconds 60          memory of fusion over a minute of load
  koseki bench throughput --targets 100000 --sources 8 --json throughput.json

Without loss means: fusion took every report, every system track was received, and no queue was growing at the end of
the probe.";

const WATCH_EXAMPLES: &str = "\
Examples:
  koseki bench watch --with monitor
  koseki bench watch --with stopped-subscriber --runs 21
  koseki bench watch --with subscribers=10 --seconds 5
  koseki bench watch --with link=10 --rate 50000 --batch 16 the track picture to ten hosts: arrivals and cost
  koseki bench watch --with flood=100 --rate 4000           source 0 at 100 times its rate; the other sources are measured

The result is the ratio of each pair. An interval that contains 1 means: no significant effect.";

const COMPARE_EXAMPLES: &str = "\
Examples:
  koseki bench latency --json before.json    then change something, and
  koseki bench latency --json after.json
  koseki bench compare before.json after.json";

/// `koseki bench`.
#[derive(Debug, Subcommand)]
pub(crate) enum BenchCommand {
    /// Measure the latency of a report at given rates
    #[command(after_help = LATENCY_EXAMPLES)]
    Latency(Latency),
    /// Find the highest rate without loss, and the behaviour at higher rates
    #[command(after_help = THROUGHPUT_EXAMPLES)]
    Throughput(ThroughputArgs),
    /// Measure the cost of fusing a report, without processes
    #[command(after_help = ENGINE_EXAMPLES)]
    Engine(EngineArgs),
    /// Measure what each layer adds to the way of a report: ring, iceoryx2, bus, fusion
    #[command(after_help = FLOOR_EXAMPLES)]
    Floor(FloorArgs),
    /// Measure the time from a scan to its tracks in a tracker of several sensors, without processes
    #[command(after_help = TRACKER_EXAMPLES)]
    Tracker(TrackerArgs),
    /// Measure the cost of a reader for fusion: pairs of runs with and without the reader
    #[command(after_help = WATCH_EXAMPLES)]
    Watch(WatchArgs),
    /// Compare two files of the same command, before and after a change
    #[command(after_help = COMPARE_EXAMPLES)]
    Compare(CompareArgs),
}

/// Traffic and placement of a measurement.
#[derive(Debug, Args)]
pub(crate) struct Common {
    /// Targets
    #[arg(long, value_name = "N", default_value_t = 1000)]
    targets: u32,
    /// Sources; every source reports every target
    #[arg(long, value_name = "K", default_value_t = 4)]
    sources: u16,
    /// Kind of waiting of fusion, and of the relay in the place of fusion
    #[arg(long, value_enum, default_value_t = WaitArg::Spin)]
    wait: WaitArg,
    /// Core of the bench's own threads
    #[arg(long, value_name = "CORE", default_value_t = 0)]
    bench_core: usize,
    /// Core of fusion
    #[arg(long, value_name = "CORE", default_value_t = 1)]
    fusion_core: usize,
    /// SCHED_FIFO priority of bench, fusion and relay, 2 to 99 [default: normal scheduling]
    #[arg(long, value_name = "PRIORITY")]
    realtime_priority: Option<i32>,
    /// Lock the memory of bench, fusion and relay
    #[arg(long)]
    lock_memory: bool,
    /// Fusion rule [default: the configuration's default]
    #[arg(long, value_name = "RULE")]
    rule: Option<String>,
    /// Further subscribers to the system tracks
    #[arg(long, value_name = "N", default_value_t = 0)]
    subscribers: usize,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum WaitArg {
    /// Poll without a pause
    Spin,
    /// Sleep until woken
    Event,
    /// Poll for 20 microseconds, then sleep
    Hybrid,
}

/// Output files.
#[derive(Debug, Args)]
pub(crate) struct FileArgs {
    /// Write all figures to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write latency against percentile as a picture (SVG)
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
    /// Write every distribution into this folder (HdrHistogram's percentile format, microseconds)
    #[arg(long, value_name = "DIR")]
    percentiles: Option<PathBuf>,
}

impl FileArgs {
    fn outputs(self) -> OutputFiles {
        OutputFiles {
            json: self.json,
            picture: self.picture,
            percentiles: self.percentiles,
        }
    }
}

/// `koseki bench latency`.
#[derive(Debug, Args)]
pub(crate) struct Latency {
    /// Reports per second, of all sources together [default: 20000; with --wait event 2000]
    #[arg(long, value_name = "R[,R...]", value_delimiter = ',', value_parser = above_zero)]
    rate: Vec<f64>,
    /// Measure rates from 1,000 up to the knee
    #[arg(long, conflicts_with = "rate")]
    sweep: bool,
    /// Number of reports of a source sent together
    #[arg(long, value_name = "B", default_value_t = 1)]
    batch: usize,
    /// Length of one measurement
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0, value_parser = above_zero)]
    seconds: f64,
    /// Repetitions
    #[arg(long, value_name = "N", default_value_t = 5)]
    runs: usize,
    /// Let a source send FACTOR times its share, and show the effect on the other sources
    #[arg(long, value_name = "SOURCE=FACTOR", value_parser = flood)]
    flood: Option<Flood>,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    files: FileArgs,
}

/// `koseki bench throughput`.
#[derive(Debug, Args)]
pub(crate) struct ThroughputArgs {
    /// Number of reports of a source sent together
    #[arg(long, value_name = "B", default_value_t = 64)]
    batch: usize,
    /// Length of one probe
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0, value_parser = above_zero)]
    probe_seconds: f64,
    /// Length of the final run for the memory measurement
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = above_zero)]
    seconds: f64,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    files: FileArgs,
}

impl ThroughputArgs {
    /// Returns the settings, the length of a probe in seconds, and the output files.
    pub(crate) fn orders(self) -> (Settings, f64, OutputFiles) {
        let settings = self.common.settings(Vec::new(), self.batch, self.seconds, 1, None);
        (settings, self.probe_seconds, self.files.outputs())
    }
}

/// `koseki bench engine`.
#[derive(Debug, Args)]
pub(crate) struct EngineArgs {
    /// Targets
    #[arg(long, value_name = "N", default_value_t = 1000)]
    targets: u32,
    /// Sources; every source reports every target
    #[arg(long, value_name = "K", default_value_t = 4)]
    sources: u16,
    /// Number of reports of a source that arrive together
    #[arg(long, value_name = "B", default_value_t = 1)]
    batch: usize,
    /// Fusion rule [default: the configuration's default]
    #[arg(long, value_name = "RULE")]
    rule: Option<String>,
    /// Core to run on
    #[arg(long, value_name = "CORE", default_value_t = 0)]
    core: usize,
    /// SCHED_FIFO priority, 2 to 99 [default: normal scheduling]
    #[arg(long, value_name = "PRIORITY")]
    realtime_priority: Option<i32>,
    /// Length of one run
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0, value_parser = above_zero)]
    seconds: f64,
    /// Repetitions
    #[arg(long, value_name = "N", default_value_t = 5)]
    runs: usize,
    /// Write all figures to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the distribution of single updates into this folder (HdrHistogram's percentile format, microseconds)
    #[arg(long, value_name = "DIR")]
    percentiles: Option<PathBuf>,
}

impl EngineArgs {
    /// Returns the settings and the output files.
    pub(crate) fn orders(self) -> (Settings, OutputFiles) {
        let settings = Settings {
            rates_per_s: vec![RATE_SPIN],
            targets: self.targets,
            sources: self.sources,
            batch: self.batch,
            wait: Wait::Spin,
            seconds: self.seconds,
            runs: self.runs,
            bench_core: self.core,
            fusion_core: self.core,
            realtime_priority: self.realtime_priority,
            lock_memory: false,
            rule: self.rule,
            flood: None,
            subscribers: 0,
        };
        let outputs = OutputFiles {
            json: self.json,
            picture: None,
            percentiles: self.percentiles,
        };
        (settings, outputs)
    }
}

/// `koseki bench floor`.
#[derive(Debug, Args)]
pub(crate) struct FloorArgs {
    /// Reports per second, of all sources together
    #[arg(long, value_name = "R", default_value_t = RATE_SPIN, value_parser = above_zero)]
    rate: f64,
    /// Targets
    #[arg(long, value_name = "N", default_value_t = 1000)]
    targets: u32,
    /// Sources; every source reports every target
    #[arg(long, value_name = "K", default_value_t = 4)]
    sources: u16,
    /// Core of the bench's own threads
    #[arg(long, value_name = "CORE", default_value_t = 0)]
    bench_core: usize,
    /// Core of fusion, and of the layers in its place
    #[arg(long, value_name = "CORE", default_value_t = 1)]
    fusion_core: usize,
    /// SCHED_FIFO priority of all, 2 to 99 [default: normal scheduling]
    #[arg(long, value_name = "PRIORITY")]
    realtime_priority: Option<i32>,
    /// Length of one measurement
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, value_parser = above_zero)]
    seconds: f64,
    /// Rounds
    #[arg(long, value_name = "N", default_value_t = 9)]
    runs: usize,
    /// Write all figures to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl FloorArgs {
    /// Returns the settings and the output files.
    pub(crate) fn orders(self) -> (Settings, OutputFiles) {
        let settings = Settings {
            rates_per_s: vec![self.rate],
            targets: self.targets,
            sources: self.sources,
            batch: 1,
            wait: Wait::Spin,
            seconds: self.seconds,
            runs: self.runs,
            bench_core: self.bench_core,
            fusion_core: self.fusion_core,
            realtime_priority: self.realtime_priority,
            lock_memory: false,
            rule: None,
            flood: None,
            subscribers: 0,
        };
        let outputs = OutputFiles {
            json: self.json,
            picture: None,
            percentiles: None,
        };
        (settings, outputs)
    }
}

/// `koseki bench watch`.
#[derive(Debug, Args)]
pub(crate) struct WatchArgs {
    /// Added: monitor, stopped-subscriber, subscribers=N, link=MIRRORS (with koseki-link), flood=FACTOR (of source 0)
    #[arg(long, value_name = "EXTRA", value_parser = extra)]
    with: Extra,
    /// Reports per second, of all sources together [default: 20000; with --wait event 2000]
    #[arg(long, value_name = "R", value_parser = above_zero)]
    rate: Option<f64>,
    /// Number of reports of a source sent together
    #[arg(long, value_name = "B", default_value_t = 1)]
    batch: usize,
    /// Length of each of a pair's two runs
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0, value_parser = above_zero)]
    seconds: f64,
    /// Pairs
    #[arg(long, value_name = "N", default_value_t = 11)]
    runs: usize,
    #[command(flatten)]
    common: Common,
    /// Write all figures to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl WatchArgs {
    /// Returns the settings, the added reader, and the file for the figures.
    pub(crate) fn orders(self) -> (Settings, Extra, Option<PathBuf>) {
        let rate = self.rate.unwrap_or_else(|| self.common.wait.usual_rate());
        let settings = self
            .common
            .settings(vec![rate], self.batch, self.seconds, self.runs, None);
        (settings, self.with, self.json)
    }
}

/// `koseki bench compare`.
#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// Figures (--json) before the change
    #[arg(value_name = "A.json")]
    pub(crate) before: PathBuf,
    /// Figures after the change
    #[arg(value_name = "B.json")]
    pub(crate) after: PathBuf,
    /// Compare measurements with different settings, too
    #[arg(long)]
    pub(crate) force: bool,
}

impl WaitArg {
    /// Where processes must be woken, a rate at which they can sleep.
    fn usual_rate(self) -> f64 {
        match self {
            Self::Spin | Self::Hybrid => RATE_SPIN,
            Self::Event => RATE_EVENT,
        }
    }
}

impl Common {
    fn settings(
        self,
        rates_per_s: Vec<f64>,
        batch: usize,
        seconds: f64,
        runs: usize,
        flood: Option<Flood>,
    ) -> Settings {
        Settings {
            rates_per_s,
            targets: self.targets,
            sources: self.sources,
            batch,
            wait: self.wait.into(),
            seconds,
            runs,
            bench_core: self.bench_core,
            fusion_core: self.fusion_core,
            realtime_priority: self.realtime_priority,
            lock_memory: self.lock_memory,
            rule: self.rule,
            flood,
            subscribers: self.subscribers,
        }
    }
}

impl Latency {
    /// Returns the settings, whether the run is a sweep, and the output files.
    pub(crate) fn orders(self) -> (Settings, bool, OutputFiles) {
        let rates = match (self.sweep, self.rate.is_empty()) {
            (true, _) => SWEEP.to_vec(),
            (false, false) => self.rate,
            (false, true) => vec![self.common.wait.usual_rate()],
        };
        let settings = self
            .common
            .settings(rates, self.batch, self.seconds, self.runs, self.flood);
        (settings, self.sweep, self.files.outputs())
    }
}

impl From<WaitArg> for Wait {
    fn from(word: WaitArg) -> Self {
        match word {
            WaitArg::Spin => Self::Spin,
            WaitArg::Event => Self::Event,
            WaitArg::Hybrid => Self::Hybrid,
        }
    }
}

/// `koseki bench-relay`: started by the bench only.
#[derive(Debug, Args)]
pub(crate) struct BenchRelay {
    #[arg(long)]
    instance: String,
    #[arg(long)]
    launcher: u32,
    #[arg(long, value_enum)]
    wait: WaitArg,
    #[arg(long)]
    core: usize,
    #[arg(long)]
    realtime_priority: Option<i32>,
    #[arg(long)]
    lock_memory: bool,
    #[arg(long)]
    slice: usize,
    #[arg(long)]
    sources: u16,
    #[arg(long)]
    over_bus: bool,
    #[arg(long, requires = "rest_ns")]
    rest_after_ns: Option<i64>,
    #[arg(long)]
    rest_ns: Option<i64>,
}

impl BenchRelay {
    pub(crate) fn options(&self) -> RelayOptions {
        RelayOptions {
            instance: self.instance.clone(),
            launcher: self.launcher,
            wait: Wait::from(self.wait).mode(),
            placement: Placement {
                core: Some(self.core),
                realtime_priority: self.realtime_priority,
                lock_memory: self.lock_memory,
            },
            slice_len: self.slice,
            sources: self.sources,
            over_bus: self.over_bus,
            rest_ns: self.rest_after_ns.zip(self.rest_ns),
        }
    }
}

fn flood(text: &str) -> Result<Flood, String> {
    let parsed = text.split_once('=').and_then(|(source, factor)| {
        Some(Flood {
            source: source.trim().parse().ok()?,
            factor: factor.trim().parse().ok()?,
        })
    });
    parsed.ok_or_else(|| "write a source's number and a factor, as in 3=50".to_owned())
}

fn extra(text: &str) -> Result<Extra, String> {
    match text
        .split_once('=')
        .map_or((text, None), |(name, value)| (name, value.parse::<u32>().ok()))
    {
        ("monitor", None) => Ok(Extra::Monitor),
        ("stopped-subscriber", None) => Ok(Extra::StoppedSubscriber),
        ("subscribers", Some(count @ 1..=20)) => Ok(Extra::Subscribers(count as usize)),
        ("link", Some(mirrors @ 1..=20)) => Ok(Extra::Link(mirrors as usize)),
        ("flood", Some(factor @ 1..)) => Ok(Extra::Flood(factor)),
        _ => Err(
            "write monitor, stopped-subscriber, subscribers=N or link=MIRRORS (1 to 20), or flood=FACTOR".to_owned(),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_checked() {
        assert_eq!(
            flood("3=50"),
            Ok(Flood {
                source: 3,
                factor: 50.0
            })
        );
        assert!(flood("3").is_err() && flood("x=1").is_err());
        assert_eq!(extra("subscribers=10"), Ok(Extra::Subscribers(10)));
        assert_eq!(extra("link=10"), Ok(Extra::Link(10)));
        assert_eq!(extra("flood=100"), Ok(Extra::Flood(100)));
        assert_eq!(extra("monitor"), Ok(Extra::Monitor));
        for wrong in [
            "subscribers",
            "subscribers=0",
            "subscribers=21",
            "radar",
            "flood",
            "flood=x",
            "monitor=1",
        ] {
            assert!(extra(wrong).is_err(), "{wrong}");
        }
    }
}
