//! Use of the machine by a deployment, which must not grow.

use std::collections::BTreeMap;
use std::fs;

use runtime::clock::mono_ns;
use serde::Serialize;

/// Use at a single moment.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Resources {
    pub(super) at_s: f64,
    /// Resident memory of each process, shared memory counted in each, KiB.
    pub(super) resident_kib: BTreeMap<String, u64>,
    /// Open files of all processes.
    pub(super) descriptors: usize,
    /// Files in shared memory and in the instance's folder.
    pub(super) files: usize,
    /// Median time from a report's arrival in the deployment to the resulting state, microseconds, since the last look;
    /// `None` if no state came.
    pub(super) latency_us: Option<f64>,
}

impl Resources {
    /// Adds the use of a process, which may end meanwhile.
    pub(super) fn add_process(&mut self, name: String, pid: u32) {
        let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let words = resident.and_then(|resident| resident.split_whitespace().next());
        let resident_kib = words.and_then(|word| word.parse().ok()).unwrap_or(0);
        self.resident_kib.insert(name, resident_kib);
        self.descriptors += fs::read_dir(format!("/proc/{pid}/fd")).map_or(0, Iterator::count);
    }
}

/// Resident memory of each process at the first look, in the middle, and at the last look.
pub(super) fn growth(looks: &[Resources]) -> String {
    let (Some(first), Some(last)) = (looks.first(), looks.last()) else {
        return String::new();
    };
    let mib = |look: &Resources, name: &String| look.resident_kib.get(name).map_or(0.0, |kib| *kib as f64 / 1024.0);
    let of_process = |name: &String| {
        let at = [first, &looks[looks.len() / 2], last].map(|look| format!("{:.1}", mib(look, name)));
        format!("{name} {}", at.join(" "))
    };
    last.resident_kib.keys().map(of_process).collect::<Vec<_>>().join(", ")
}

/// Latencies of states since the last look.
#[derive(Debug, Default)]
pub(super) struct Latencies(Vec<i64>);

impl Latencies {
    /// Most that are remembered.
    const MOST: usize = 100_000;

    /// A state was published `ns` after the report behind the state had come.
    pub(super) fn add(&mut self, ns: i64) {
        if self.0.len() < Self::MOST && (0..mono_ns()).contains(&ns) {
            self.0.push(ns);
        }
    }

    /// Returns the median, microseconds, and starts again.
    pub(super) fn take_median_us(&mut self) -> Option<f64> {
        let mut values = std::mem::take(&mut self.0);
        let middle = values.len() / 2;
        (!values.is_empty()).then(|| *values.select_nth_unstable(middle).1 as f64 / 1e3)
    }
}
