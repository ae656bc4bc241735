//! Description of the measuring machine.

use std::fs;

use serde::{Deserialize, Serialize};

use crate::pinned;
use crate::progress::say;
use crate::settings::{Settings, Wait};

/// Facts necessary to interpret the figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineFacts {
    /// The processor's name.
    pub processor: String,
    /// Cores that this process may use.
    pub cores: Vec<usize>,
    /// Kernel release.
    pub kernel: String,
    /// Whether the machine is virtual: other guests then contribute to every tail.
    pub virtual_machine: bool,
    /// Clock source of the stamps.
    pub clock_source: String,
    /// Time available to real-time threads in each period of 1 s, microseconds; -1: unlimited.
    pub realtime_runtime_us: i64,
    /// Average number of runnable processes in the last minute, before the measurement.
    pub load_before: f64,
    /// Average number of runnable processes in the last minute, after the measurement.
    pub load_after: f64,
    /// Whether this executable was built with optimisation.
    pub optimised: bool,
    /// Version of Koseki.
    pub version: String,
}

/// Describes the machine before a measurement; prints and returns the notes necessary to interpret the figures.
pub(crate) fn begin(settings: &Settings) -> (MachineFacts, Vec<String>) {
    let machine = MachineFacts::read();
    let mut notes = self::notes(settings, &machine);
    let refused = pinned::refusals(settings.bench_place()).into_iter();
    notes.extend(refused.map(|what| format!("bench: {what}")));
    notes.iter().for_each(|note| say(note));
    (machine, notes)
}

/// Returns reasons to distrust the figures, or to read the figures with care, a sentence each.
pub(crate) fn notes(settings: &Settings, machine: &MachineFacts) -> Vec<String> {
    let mut notes = Vec::new();
    if !machine.optimised {
        notes.push("this executable is not optimised: build with --release".to_owned());
    }
    if machine.virtual_machine {
        notes.push("this is a virtual machine: other guests take part in every tail".to_owned());
    }
    if machine.load_before > 0.5 * machine.cores.len() as f64 {
        notes.push(format!(
            "load {:.1} on {} cores before it began: other processes take part in every tail",
            machine.load_before,
            machine.cores.len()
        ));
    }
    if settings.realtime_priority.is_some() && settings.wait == Wait::Spin {
        notes.push(
            "at real-time priority all of them rest, lest the kernel make them: bench and relay where the schedule has a \
             gap for it, fusion 60 µs in each millisecond, which shows in its p90"
                .to_owned(),
        );
    }
    notes
}

impl MachineFacts {
    /// Reads the current state of this machine.
    pub fn read() -> Self {
        let text = |path: &str| fs::read_to_string(path).unwrap_or_default().trim().to_owned();
        let processors = text("/proc/cpuinfo");
        let line = |key: &str| {
            let mut lines = processors.lines().filter(|line| line.starts_with(key));
            lines
                .next()
                .and_then(|line| line.split_once(':'))
                .map(|(_, value)| value.trim().to_owned())
        };
        Self {
            processor: line("model name").unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            cores: runtime::cores::available(),
            kernel: text("/proc/sys/kernel/osrelease"),
            virtual_machine: line("flags").is_some_and(|flags| flags.split(' ').any(|flag| flag == "hypervisor")),
            clock_source: text("/sys/devices/system/clocksource/clocksource0/current_clocksource"),
            realtime_runtime_us: text("/proc/sys/kernel/sched_rt_runtime_us").parse().unwrap_or(0),
            load_before: load(),
            load_after: load(),
            optimised: !cfg!(debug_assertions),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }

    /// Records the load at the end.
    pub(crate) fn ended(&mut self) {
        self.load_after = load();
    }
}

fn load() -> f64 {
    let text = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace()
        .next()
        .and_then(|load| load.parse().ok())
        .unwrap_or(0.0)
}
