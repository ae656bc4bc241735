//! Outages: how long each target showed no state at a fault.
//!
//! The run is divided into windows from each fault to the next, and windows of a quarter of a minute in quiet times. In
//! each window, a target shown at the window's start has an outage: the longest time without a state that reaches into
//! the window, less the time in which the fault's cause lasted. These are figures; the limits are in
//! [`super::picture`]. A track with silent sources coasts: such a time is no outage.

use std::collections::BTreeMap;

use super::limits::Spread;

/// Length of a window without a fault, nanoseconds.
const QUIET_NS: i64 = 15_000_000_000;
/// A target that was shown so long before a window's begin is expected in the window, nanoseconds.
const RECENT_NS: i64 = 5_000_000_000;

/// Kinds of windows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Window {
    #[default]
    Quiet,
    Fault,
    Rebuild,
}

/// Ledger of the outages of all targets, by addresses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outages {
    begun_ns: i64,
    targets: BTreeMap<u32, Shown>,
    /// Times in which a fault's cause lasted.
    held: Vec<(i64, i64)>,
    at_faults_s: Vec<f64>,
    at_rebuilds_s: Vec<f64>,
}

#[derive(Clone, Debug, Default)]
struct Shown {
    last_ns: i64,
    is_coasting: bool,
    /// Window of an expected outage.
    expected: Option<Window>,
    longest_ns: Option<i64>,
    worst_ns: i64,
}

impl Outages {
    /// A target is shown.
    pub(crate) fn shown(&mut self, address: u32, at_ns: i64, coasts: bool) {
        let held = &self.held;
        let target = self.targets.entry(address).or_insert(Shown {
            last_ns: at_ns,
            ..Shown::default()
        });
        if !target.is_coasting {
            let away_ns = at_ns - target.last_ns - overlap(held, target.last_ns, at_ns);
            target.longest_ns = Some(target.longest_ns.map_or(away_ns, |longest| longest.max(away_ns)));
            target.worst_ns = target.worst_ns.max(away_ns);
        } else if target.expected.is_some() {
            target.longest_ns.get_or_insert(0);
        }
        (target.last_ns, target.is_coasting) = (at_ns, coasts);
    }

    /// The track of a target has ended with cause: the target is no longer expected.
    pub(crate) fn ended(&mut self, address: u32) {
        self.targets.remove(&address);
    }

    /// A fault's cause lasted between these times.
    pub(crate) fn held(&mut self, from_ns: i64, to_ns: i64) {
        self.held.push((from_ns, to_ns));
    }

    /// The present window is that of a rebuild.
    pub(crate) fn rebuilt(&mut self) {
        for expected in self.targets.values_mut().filter_map(|target| target.expected.as_mut()) {
            *expected = Window::Rebuild;
        }
    }

    /// Ends the present window, and begins another.
    pub(crate) fn begin(&mut self, window: Window, at_ns: i64) {
        for target in self.targets.values_mut() {
            let is_carried = match (target.expected, target.longest_ns) {
                (Some(kind), Some(longest_ns)) => {
                    let outage_s = longest_ns as f64 / 1e9;
                    match kind {
                        Window::Quiet => {}
                        Window::Fault => self.at_faults_s.push(outage_s),
                        Window::Rebuild => self.at_rebuilds_s.push(outage_s),
                    }
                    false
                }
                (expected, _) => expected.is_some(),
            };
            let is_recent = !target.is_coasting && at_ns - target.last_ns < RECENT_NS;
            target.expected = match target.expected.filter(|_| is_carried) {
                Some(before) => Some(before.max(window)),
                None => is_recent.then_some(window),
            };
            target.longest_ns = None;
        }
        self.begun_ns = at_ns;
    }

    /// Advances the time: ends windows without a fault.
    pub(crate) fn pass(&mut self, at_ns: i64) {
        if at_ns - self.begun_ns > QUIET_NS {
            self.begin(Window::Quiet, at_ns);
        }
    }

    /// Outages at faults, and at rebuilds; number and spread.
    pub(crate) fn spreads(&self) -> [(usize, Option<Spread>); 2] {
        [&self.at_faults_s, &self.at_rebuilds_s].map(|outages_s| (outages_s.len(), Spread::of(outages_s)))
    }

    /// Longest time without a state of a target, seconds.
    pub(crate) fn worst_s(&self, address: u32) -> Option<f64> {
        Some(self.targets.get(&address)?.worst_ns as f64 / 1e9)
    }
}

/// Part of the time between two moments that is in any of the `held` times.
fn overlap(held: &[(i64, i64)], from_ns: i64, to_ns: i64) -> i64 {
    // Held times are in order, and only the latest reach so far.
    let late = held.iter().rev().take_while(|(_, end_ns)| *end_ns > from_ns);
    late.map(|(begin_ns, end_ns)| (to_ns.min(*end_ns) - from_ns.max(*begin_ns)).max(0))
        .sum()
}
