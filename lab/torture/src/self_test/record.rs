//! A record of events in which defects can be planted.

use std::collections::BTreeMap;

use crate::judge::event::{Conditions, Event, State, What};

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(super) struct Record {
    pub(super) conditions: Conditions,
    pub(super) events: Vec<Event>,
}

/// A second, nanoseconds.
pub(super) const SECOND: i64 = 1_000_000_000;
/// Numbers that no sound record has.
pub(super) const FOREIGN: u32 = 3_000_000_000;

impl Record {
    /// All states, with the times at which they came.
    pub(super) fn states(&self) -> impl Iterator<Item = (i64, &State)> {
        self.events.iter().filter_map(|event| match &event.what {
            What::State(state) => Some((event.at_ns, state)),
            _ => None,
        })
    }

    /// Changes the states of a target from a time on.
    pub(super) fn change(&mut self, address: u32, from_ns: i64, mut change: impl FnMut(&mut State)) {
        for event in self.events.iter_mut().filter(|event| event.at_ns >= from_ns) {
            if let What::State(state) = &mut event.what
                && state.address == Some(address)
            {
                change(state);
            }
        }
    }

    /// Removes the states of a target between two times.
    pub(super) fn remove(&mut self, address: u32, from_ns: i64, to_ns: i64) {
        self.events.retain(|event| match &event.what {
            What::State(state) => state.address != Some(address) || !(from_ns..to_ns).contains(&event.at_ns),
            _ => true,
        });
    }

    /// Adds an event in its place.
    pub(super) fn insert(&mut self, event: Event) {
        let place = self.events.partition_point(|before| before.at_ns <= event.at_ns);
        self.events.insert(place, event);
    }

    /// Begins of all faults that must leave the picture as it was.
    pub(super) fn faults(&self) -> Vec<i64> {
        let begins = self.events.iter().filter(|event| {
            matches!(
                event.what,
                What::FaultBegins {
                    keeps_numbers: true,
                    rebuilds: false,
                    ..
                }
            )
        });
        begins.map(|event| event.at_ns).collect()
    }

    /// Begin of the fault that was followed by a newer epoch, and longest by none that excuses changes of numbers.
    pub(super) fn kill_ns(&self) -> Option<i64> {
        let (mut fault_ns, mut epoch, mut candidates, mut excuses) = (None, 0, Vec::new(), Vec::new());
        for event in &self.events {
            match &event.what {
                What::FaultBegins { keeps_numbers, .. } => {
                    fault_ns = keeps_numbers.then_some(event.at_ns);
                    excuses.extend((!keeps_numbers).then_some(event.at_ns));
                }
                What::State(state) if state.epoch > epoch => {
                    epoch = state.epoch;
                    candidates.extend(fault_ns.take());
                }
                What::Stopped { .. } => excuses.push(event.at_ns),
                _ => {}
            }
        }
        let free = |kill_ns: &i64| {
            excuses
                .iter()
                .find(|at_ns| *at_ns > kill_ns)
                .map(|at_ns| at_ns - kill_ns)
        };
        candidates.into_iter().max_by_key(|kill_ns| (free(kill_ns), -kill_ns))
    }

    /// Targets that are shown shortly before and after a time, the farthest travelled first.
    pub(super) fn targets_at(&self, at_ns: i64) -> Vec<u32> {
        #[derive(Default)]
        struct Seen {
            before: bool,
            after: u32,
            from_m: Option<[f64; 2]>,
            moved_m: f64,
        }
        let mut seen: BTreeMap<u32, Seen> = BTreeMap::new();
        for (sent_ns, state) in self.states() {
            let Some(address) = state.address else { continue };
            let target = seen.entry(address).or_default();
            target.before |= (at_ns - 3 * SECOND..at_ns).contains(&sent_ns);
            if sent_ns >= at_ns {
                target.after += 1;
                let (Some(place_m), first_m) = (state.truth_m, target.from_m.or(state.truth_m)) else {
                    continue;
                };
                let [[x, y], [from_x, from_y]] = [place_m, first_m.unwrap_or(place_m)];
                (target.from_m, target.moved_m) = (first_m, target.moved_m.max((x - from_x).hypot(y - from_y)));
            }
        }
        let most = seen.values().map(|target| target.after).max().unwrap_or(0);
        let mut targets: Vec<(u32, Seen)> = seen
            .into_iter()
            .filter(|(_, target)| target.before && 2 * target.after > most)
            .collect();
        targets.sort_by(|(_, one), (_, other)| other.moved_m.total_cmp(&one.moved_m));
        targets.into_iter().map(|(address, _)| address).collect()
    }

    /// Begin of the longest time in which nothing excuses that the end of a track does not come, and its length.
    pub(super) fn longest_without_excuse(&self) -> (i64, i64) {
        let mut excuses: Vec<i64> = Vec::new();
        for event in &self.events {
            let excuses_ends = match &event.what {
                What::FaultBegins { keeps_numbers, .. } => !keeps_numbers,
                What::Back | What::Joined | What::Lost { .. } | What::Rebuilt | What::Helped | What::Stopped { .. } => {
                    !matches!(event.what, What::Back)
                }
                _ => false,
            };
            excuses.extend(excuses_ends.then_some(event.at_ns));
        }
        let spans = excuses.windows(2).map(|pair| (pair[0], pair[1] - pair[0]));
        spans.max_by_key(|(_, length_ns)| *length_ns).unwrap_or((0, 0))
    }
}
