//! A record of events in which defects can be planted.

use std::collections::BTreeMap;

use anyhow::Context as _;

use crate::Refused;
use crate::judge::event::{Conditions, Event, Life, State, What};
use crate::judge::limits::SETTLED_S;
use crate::judge::world::distance;

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(super) struct Record {
    pub(super) conditions: Conditions,
    pub(super) events: Vec<Event>,
}

/// Where defects are planted in a record: the longest time without a fault.
pub(super) struct Place {
    /// A while after the begin of that time.
    pub(super) from_ns: i64,
    /// Targets that are shown all the time, the farthest travelled first.
    pub(super) targets: Vec<u32>,
}

/// A second, nanoseconds.
pub(super) const SECOND: i64 = 1_000_000_000;
/// Numbers that no sound record has.
pub(super) const FOREIGN: u32 = 3_000_000_000;
/// Length of a planted defect, and so of the time after [`Place::from_ns`], nanoseconds.
pub(super) const LENGTH: i64 = 12 * SECOND;
/// Targets that a record must show.
const TARGETS_MIN: usize = 4;

impl Place {
    pub(super) fn target(&self) -> u32 {
        self.targets[0]
    }

    /// Whether a time is that of the defect.
    pub(super) fn has(&self, at_ns: i64) -> bool {
        (self.from_ns..self.from_ns + LENGTH).contains(&at_ns)
    }
}

impl Record {
    /// All states, with the times of arrival.
    pub(super) fn states(&self) -> impl Iterator<Item = (i64, &State)> {
        self.events.iter().filter_map(|event| match &event.what {
            What::State(state) => Some((event.at_ns, state)),
            _ => None,
        })
    }

    /// Changes all states from a time on.
    pub(super) fn change_all(&mut self, from_ns: i64, mut change: impl FnMut(i64, &mut State)) {
        for event in self.events.iter_mut().filter(|event| event.at_ns >= from_ns) {
            if let What::State(state) = &mut event.what {
                change(event.at_ns, state);
            }
        }
    }

    /// Changes the states of a target from a time on.
    pub(super) fn change(&mut self, address: u32, from_ns: i64, mut change: impl FnMut(&mut State)) {
        self.change_all(from_ns, |_, state| {
            if state.address == Some(address) {
                change(state);
            }
        });
    }

    /// Keeps only these states; the numbers of samples then follow each other as before, so that no loss shows.
    pub(super) fn keep(&mut self, mut keeps: impl FnMut(i64, &State) -> bool) {
        self.events.retain(|event| match &event.what {
            What::State(state) => keeps(event.at_ns, state),
            _ => true,
        });
        self.number();
    }

    /// Adds states, each directly after the event at the state's time.
    pub(super) fn add(&mut self, states: Vec<(i64, State)>) {
        for (at_ns, state) in states {
            let place = self.events.partition_point(|before| before.at_ns <= at_ns);
            let what = What::State(state);
            self.events.insert(place, Event { at_ns, what });
        }
        self.number();
    }

    /// Numbers the samples of each publisher from the first sample on.
    fn number(&mut self) {
        let mut next: BTreeMap<u64, u64> = BTreeMap::new();
        self.change_all(i64::MIN, |_, state| {
            let next = next.entry(state.incarnation).or_insert(state.sequence);
            state.sequence = *next;
            *next += 1;
        });
    }

    /// The latest state of a target before a time.
    pub(super) fn latest(&self, address: u32, before_ns: i64) -> State {
        let states = self.states().take_while(|(at_ns, _)| *at_ns < before_ns);
        let found = states.filter(|(_, state)| state.address == Some(address)).last();
        found
            .expect("places have only targets that were shown before")
            .1
            .clone()
    }

    /// The state of a target in each of the first seconds of a place, as tracks of another number.
    pub(super) fn copies(&self, place: &Place, address: u32, number: u32) -> Vec<(i64, State)> {
        let own = self
            .states()
            .filter(|(at_ns, state)| place.has(*at_ns) && state.address == Some(address));
        own.map(|(at_ns, state)| {
            (
                at_ns,
                State {
                    number,
                    ..state.clone()
                },
            )
        })
        .collect()
    }

    /// The place for defects.
    ///
    /// # Errors
    /// If the record is too short.
    pub(super) fn place(&self) -> anyhow::Result<Place> {
        let settled_ns = self.conditions.begin_ns[0] + i64::from(SETTLED_S) * SECOND;
        let mut bounds = vec![settled_ns];
        for event in &self.events {
            match event.what {
                What::FaultBegins { .. } | What::Back | What::Stopped { .. } => bounds.push(event.at_ns),
                _ => {}
            }
        }
        let spans = bounds.windows(2).map(|span| (span[0], span[1] - span[0]));
        let (begin_ns, length_ns) = spans.max_by_key(|(_, length_ns)| *length_ns).unwrap_or_default();
        // Earlier events may still have an effect.
        let from_ns = begin_ns + 2 * SECOND.min(length_ns / 4);
        let end_ns = self.events.last().map_or(0, |event| event.at_ns);
        let targets = self.targets_at(from_ns);
        let is_long = end_ns - from_ns > LENGTH + 3 * SECOND;
        (is_long && targets.len() >= TARGETS_MIN)
            .then_some(Place { from_ns, targets })
            .with_context(|| {
                Refused(format!(
                    "the record shows {TARGETS_MIN} targets for no {} s: record a longer run",
                    LENGTH / SECOND + 5
                ))
            })
    }

    /// Targets that are shown before a time and through the time of a defect, the farthest travelled first.
    fn targets_at(&self, from_ns: i64) -> Vec<u32> {
        /// States in each third, with the time before, and first and last place.
        type Seen = ([u32; 4], [Option<[f64; 3]>; 2]);
        let mut seen: BTreeMap<u32, Seen> = BTreeMap::new();
        for (at_ns, state) in self.states().filter(|(_, state)| state.life == Life::Confirmed) {
            let Some(address) = state.address else { continue };
            let third = (at_ns - from_ns).div_euclid(LENGTH / 3) + 1;
            if let Ok(third @ 0..4) = usize::try_from(third) {
                let (counts, ends) = seen.entry(address).or_default();
                counts[third] += 1;
                ends[0] = ends[0].or(state.position_m);
                ends[1] = state.position_m.or(ends[1]);
            }
        }
        let way_m = |ends: &[Option<[f64; 3]>; 2]| match ends {
            [Some(from_m), Some(to_m)] => distance(*from_m, *to_m),
            _ => 0.0,
        };
        let is_shown = |counts: &[u32; 4]| counts.iter().all(|count| *count >= 3);
        let shown = seen.into_iter().filter(|(_, (counts, _))| is_shown(counts));
        let mut targets: Vec<(u32, f64)> = shown.map(|(address, (_, ends))| (address, way_m(&ends))).collect();
        targets.sort_by(|(_, one), (_, other)| other.total_cmp(one));
        targets.into_iter().map(|(address, _)| address).collect()
    }
}
