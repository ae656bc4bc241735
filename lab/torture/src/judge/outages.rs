//! Outages: how long each target showed no state at a fault.
//!
//! The run is divided into windows from each fault to the next, and windows of a quarter of a minute in quiet times.
//! In each window, a target shown at the window's start has one outage: its longest time without a state that reaches
//! into the window. A target that returns in a later window has its outage there, with the more lenient limit of the
//! two. A track with silent sources coasts: such a time is no outage, unless one target in ten has it.

use std::collections::BTreeMap;

use super::finding::{Finding, Findings};
use super::limits::{Limits, Spread};

/// Length of a window without a fault, nanoseconds.
const QUIET_NS: i64 = 15_000_000_000;
/// A target that was shown so long before a window's begin is expected in it, nanoseconds.
const RECENT_NS: i64 = 5_000_000_000;
/// Share of the targets that may coast at once for longer than the worst outage.
const COASTING_SHARE: f64 = 0.1;

/// Kinds of windows, from the strict to the lenient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Window {
    #[default]
    Quiet,
    Fault,
    Rebuild,
}

/// Ledger of the outages of all targets, by their addresses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outages {
    window: Window,
    begun_ns: i64,
    targets: BTreeMap<u32, Shown>,
    /// Times in which a fault's cause itself kept the picture from going on.
    held: Vec<(i64, i64)>,
    at_faults_s: Vec<f64>,
    at_rebuilds_s: Vec<f64>,
    were_blind: bool,
}

#[derive(Clone, Debug, Default)]
struct Shown {
    last_ns: i64,
    is_coasting: bool,
    /// Window of an expected outage, which sets the limit.
    expected: Option<Window>,
    longest_ns: Option<i64>,
    is_missed: bool,
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
        (target.last_ns, target.is_coasting, target.is_missed) = (at_ns, coasts, false);
    }

    /// The track of a target has ended with cause: the target is no longer expected.
    pub(crate) fn ended(&mut self, address: u32) {
        self.targets.remove(&address);
    }

    /// A fault's cause kept the picture from going on between these times.
    pub(crate) fn held(&mut self, from_ns: i64, to_ns: i64) {
        self.held.push((from_ns, to_ns));
    }

    /// The present window is that of a rebuild.
    pub(crate) fn rebuilt(&mut self) {
        self.window = Window::Rebuild;
        for expected in self.targets.values_mut().filter_map(|target| target.expected.as_mut()) {
            *expected = Window::Rebuild;
        }
    }

    /// Ends the present window, and begins another.
    pub(crate) fn begin(&mut self, window: Window, at_ns: i64, limits: &Limits, findings: &mut Findings) {
        self.look(at_ns, limits, findings);
        for (address, target) in &mut self.targets {
            let is_carried = match (target.expected, target.longest_ns) {
                (Some(kind), Some(longest_ns)) => {
                    let outage_s = longest_ns as f64 / 1e9;
                    match kind {
                        Window::Quiet => {}
                        Window::Fault => self.at_faults_s.push(outage_s),
                        Window::Rebuild => self.at_rebuilds_s.push(outage_s),
                    }
                    let limit_s = limit_s(kind, limits);
                    if outage_s > limit_s {
                        findings.add(Finding::OutageWorst, || {
                            format!("{address:06X} was away for {outage_s:.2} s (limit {limit_s:.1} s)")
                        });
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
        (self.window, self.begun_ns) = (window, at_ns);
    }

    /// Advances the time: ends windows without a fault, and detects missing targets.
    pub(crate) fn pass(&mut self, at_ns: i64, limits: &Limits, findings: &mut Findings) {
        if at_ns - self.begun_ns > QUIET_NS {
            self.begin(Window::Quiet, at_ns, limits, findings);
        }
        self.look(at_ns, limits, findings);
    }

    fn look(&mut self, at_ns: i64, limits: &Limits, findings: &mut Findings) {
        let mut blind = 0;
        for (address, target) in &mut self.targets {
            let away_ns = at_ns - target.last_ns - overlap(&self.held, target.last_ns, at_ns);
            let away_s = away_ns as f64 / 1e9;
            let limit_s = limit_s(target.expected.unwrap_or(self.window), limits);
            if away_s <= limit_s {
                continue;
            }
            if target.is_coasting {
                blind += 1;
            } else if !target.is_missed {
                target.is_missed = true;
                findings.add(Finding::NotBack, || {
                    format!("{address:06X} is not shown for {limit_s:.1} s and longer")
                });
            }
        }
        let is_blind = blind > 1 && f64::from(blind) > COASTING_SHARE * self.targets.len() as f64;
        if is_blind && !self.were_blind {
            findings.add(Finding::Blind, || format!("{blind} of {} targets", self.targets.len()));
        }
        self.were_blind = is_blind;
    }

    /// Outages at faults, and at rebuilds; how many, and their spread.
    pub(crate) fn spreads(&self) -> [(usize, Option<Spread>); 2] {
        [&self.at_faults_s, &self.at_rebuilds_s].map(|outages_s| (outages_s.len(), Spread::of(outages_s)))
    }

    /// Longest time without a state of a target, seconds.
    pub(crate) fn worst_s(&self, address: u32) -> Option<f64> {
        Some(self.targets.get(&address)?.worst_ns as f64 / 1e9)
    }
}

fn limit_s(window: Window, limits: &Limits) -> f64 {
    match window {
        Window::Rebuild => limits.rebuild_s,
        Window::Quiet | Window::Fault => limits.outage_s.worst,
    }
}

/// Part of the time between two moments that is in one of the `held` times.
fn overlap(held: &[(i64, i64)], from_ns: i64, to_ns: i64) -> i64 {
    // Held times are in their order, and only the latest reach so far.
    let late = held.iter().rev().take_while(|(_, end_ns)| *end_ns > from_ns);
    late.map(|(begin_ns, end_ns)| (to_ns.min(*end_ns) - from_ns.max(*begin_ns)).max(0))
        .sum()
}
