//! Settings of a measurement.

use bus::WaitMode;
use runtime::cores::{self, Placement};
use serde::{Deserialize, Serialize};

/// Maximum numbers of targets of the engine alone and of processes, of targets times sources, and of sources.
const TARGETS_MAX: u32 = 1_000_000;
const PROCESS_TARGETS_MAX: u32 = 100_000;
const SENSOR_TRACKS_MAX: u64 = 8_000_000;
const SOURCES_MAX: u16 = 128;
/// Maximum number of reports in a slice of a sensor's topic.
const BATCH_MAX: usize = 64;
/// Range of rates, reports per second.
const RATE_MIN: f64 = 1.0;
const RATE_MAX: f64 = 20e6;
/// Maximum number of further subscribers: some places are for the bench and for others.
const SUBSCRIBERS_MAX: usize = 20;
/// Spinning time in hybrid mode, nanoseconds: the default of the configuration.
const HYBRID_SPIN_NS: u64 = 20_000;

/// Settings common to all measurements of a command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Rates, reports of all sources together per second.
    pub rates_per_s: Vec<f64>,
    /// Targets.
    pub targets: u32,
    /// Number of sources; each reports every target.
    pub sources: u16,
    /// Number of reports of one source in a slice.
    pub batch: usize,
    /// Waiting mode of fusion and relay.
    pub wait: Wait,
    /// Length of one measurement, seconds.
    pub seconds: f64,
    /// Repetitions; floor and pipeline alternate in each.
    pub runs: usize,
    /// Core of the bench's own threads.
    pub bench_core: usize,
    /// Core of fusion, and of the relay in its place.
    pub fusion_core: usize,
    /// `SCHED_FIFO` priority of both.
    pub realtime_priority: Option<i32>,
    /// Whether both lock their memory.
    pub lock_memory: bool,
    /// Fusion rule; `None`: the default.
    pub rule: Option<String>,
    /// Flooding source.
    pub flood: Option<Flood>,
    /// Further subscribers to the system tracks.
    pub subscribers: usize,
}

/// Waiting mode of fusion and relay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wait {
    /// Polls continuously.
    Spin,
    /// Blocks until woken.
    Event,
    /// Polls for a while, then blocks.
    Hybrid,
}

impl Wait {
    /// Returns the word used in configurations and command lines.
    pub fn word(self) -> &'static str {
        match self {
            Self::Spin => "spin",
            Self::Event => "event",
            Self::Hybrid => "hybrid",
        }
    }

    /// Returns the wait mode of the bus.
    pub fn mode(self) -> WaitMode {
        match self {
            Self::Spin => WaitMode::Spin,
            Self::Event => WaitMode::Event,
            Self::Hybrid => WaitMode::Hybrid {
                spin_ns: HYBRID_SPIN_NS,
            },
        }
    }
}

/// Source that sends more than an equal share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Flood {
    /// Number of the source, from 0.
    pub source: u16,
    /// Number of reports relative to each of the other sources.
    pub factor: f64,
}

/// Measurement that is impossible, on this machine or in general.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct MeasurementRefusal(pub String);

impl Settings {
    /// Checks the settings against their limits and against this machine.
    ///
    /// # Errors
    /// With option, value, limit and remedy.
    pub fn check(&self) -> Result<(), MeasurementRefusal> {
        self.check_without_cores()?;
        if self.targets > PROCESS_TARGETS_MAX {
            return Err(MeasurementRefusal(format!(
                "--targets {}: there can be 1 to {PROCESS_TARGETS_MAX}; only `koseki bench engine` takes more",
                self.targets
            )));
        }
        self.check_cores(&cores::available())
    }

    /// Checks the settings without the cores: the engine alone needs only one core.
    pub(crate) fn check_without_cores(&self) -> Result<(), MeasurementRefusal> {
        let refuse = |what: String| Err(MeasurementRefusal(what));
        for rate in &self.rates_per_s {
            if !(RATE_MIN..=RATE_MAX).contains(rate) {
                return refuse(format!(
                    "--rate {rate}: it must lie between {RATE_MIN} and {RATE_MAX} reports per second"
                ));
            }
        }
        if !(1..=TARGETS_MAX).contains(&self.targets) {
            return refuse(format!("--targets {}: there can be 1 to {TARGETS_MAX}", self.targets));
        }
        if !(1..=SOURCES_MAX).contains(&self.sources) {
            return refuse(format!("--sources {}: there can be 1 to {SOURCES_MAX}", self.sources));
        }
        let sensor_tracks = u64::from(self.targets) * u64::from(self.sources);
        if sensor_tracks > SENSOR_TRACKS_MAX {
            return refuse(format!(
                "--targets {} --sources {}: these are {sensor_tracks} sensor tracks, and there can be {SENSOR_TRACKS_MAX}; \
                 take fewer sources",
                self.targets, self.sources
            ));
        }
        if !(1..=BATCH_MAX).contains(&self.batch) || self.batch > self.targets as usize {
            return refuse(format!(
                "--batch {}: a slice holds 1 to {BATCH_MAX} reports, each of another target, and there are {}",
                self.batch, self.targets
            ));
        }
        if self.runs == 0 || self.runs > 1000 {
            return refuse(format!("--runs {}: take 1 to 1000", self.runs));
        }
        if let Some(flood) = self.flood
            && (flood.source >= self.sources || !(1.0..=1e6).contains(&flood.factor) || self.sources < 2)
        {
            return refuse(format!(
                "--flood {}={}: name one of at least two sources (0 to {}) and a factor from 1 to 1000000",
                flood.source,
                flood.factor,
                self.sources - 1
            ));
        }
        if let Some(priority) = self.realtime_priority
            && !(2..=99).contains(&priority)
        {
            return refuse(format!("--realtime-priority {priority}: it must lie between 2 and 99"));
        }
        if self.subscribers > SUBSCRIBERS_MAX {
            return refuse(format!(
                "--subscribers {}: the topic has places for {SUBSCRIBERS_MAX} beside the bench's own",
                self.subscribers
            ));
        }
        Ok(())
    }

    fn check_cores(&self, available: &[usize]) -> Result<(), MeasurementRefusal> {
        if available.len() < 2 {
            return Err(MeasurementRefusal(format!(
                "this process may use {} core(s), {available:?}, but bench and fusion need one each: give it another \
                 (taskset, cgroup, container limits), or measure the engine alone with `koseki bench engine`",
                available.len()
            )));
        }
        for (option, core) in [("--bench-core", self.bench_core), ("--fusion-core", self.fusion_core)] {
            if !available.contains(&core) {
                return Err(MeasurementRefusal(format!(
                    "{option} {core}: this process may use cores {available:?}; name one of them"
                )));
            }
        }
        if self.bench_core == self.fusion_core {
            return Err(MeasurementRefusal(format!(
                "--bench-core and --fusion-core are both {}: they would measure each other; name two of {available:?}",
                self.bench_core
            )));
        }
        Ok(())
    }

    /// Returns the time between two reports of a target by the same source, seconds.
    pub fn period_s(&self, rate_per_s: f64) -> f64 {
        f64::from(self.targets) * f64::from(self.sources) / rate_per_s
    }

    /// Returns the requested placement of the bench's own threads.
    pub fn bench_place(&self) -> Placement {
        Placement {
            core: Some(self.bench_core),
            realtime_priority: self.realtime_priority,
            lock_memory: self.lock_memory,
        }
    }
}

#[cfg(test)]
pub(crate) fn test_settings() -> Settings {
    Settings {
        rates_per_s: vec![20_000.0],
        targets: 100,
        sources: 2,
        batch: 1,
        wait: Wait::Spin,
        seconds: 1.0,
        runs: 1,
        bench_core: 0,
        fusion_core: 1,
        realtime_priority: None,
        lock_memory: false,
        rule: None,
        flood: None,
        subscribers: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_measured_is_refused_with_its_option() {
        let cores = [0, 1, 2];
        assert_eq!(test_settings().check_cores(&cores), Ok(()));
        let refused = |change: fn(&mut Settings), expected: &str| {
            let mut settings = test_settings();
            change(&mut settings);
            let said = settings
                .check()
                .and_then(|()| settings.check_cores(&cores))
                .unwrap_err()
                .0;
            assert!(said.contains(expected), "{said}");
        };
        refused(|s| s.rates_per_s.push(0.5), "--rate 0.5");
        refused(|s| s.rates_per_s = vec![f64::NAN], "--rate NaN");
        refused(|s| s.targets = 0, "--targets 0");
        refused(|s| s.targets = 100_001, "--targets 100001");
        refused(|s| s.targets = 1_000_001, "--targets 1000001");
        refused(|s| s.sources = 129, "--sources 129");
        refused(|s| (s.targets, s.sources) = (1_000_000, 9), "9000000 sensor tracks");
        let many = Settings {
            targets: 1_000_000,
            sources: 8,
            ..test_settings()
        };
        assert_eq!(many.check_without_cores(), Ok(()));
        refused(|s| s.batch = 65, "--batch 65");
        refused(
            |s| {
                s.flood = Some(Flood {
                    source: 2,
                    factor: 10.0,
                })
            },
            "--flood 2=10",
        );
        let cores_refused = |settings: &Settings, cores: &[usize]| settings.check_cores(cores).unwrap_err().0;
        assert!(cores_refused(&test_settings(), &[0]).contains("need one each"));
        assert!(cores_refused(&test_settings(), &[0, 2]).contains("--fusion-core 1"));
        let same = Settings {
            fusion_core: 0,
            ..test_settings()
        };
        assert!(cores_refused(&same, &cores).contains("both 0"));
    }
}
