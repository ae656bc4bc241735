//! States of a single kind in the order of time, in a bounded memory.

use std::collections::VecDeque;

use crate::pose::NoState;

/// Values by time: at most the latest `capacity` values.
#[derive(Clone, Debug)]
pub(crate) struct Channel<T> {
    entries: VecDeque<(i64, T)>,
    capacity: usize,
}

/// Where a time lies among the states.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Around<T> {
    At(T),
    Between([(i64, T); 2]),
}

impl<T: Copy> Channel<T> {
    pub(crate) fn new(capacity: usize) -> Self {
        let capacity = capacity.max(2);
        Self {
            entries: VecDeque::with_capacity(capacity + 1),
            capacity,
        }
    }

    /// Adds a value, or replaces that of the same time. `false` if the value is older than all of a full memory.
    pub(crate) fn add(&mut self, time_ns: i64, value: T) -> bool {
        let place = self.entries.partition_point(|(at, _)| *at < time_ns);
        let is_full = self.entries.len() == self.capacity;
        match self.entries.get_mut(place) {
            Some((at, entry)) if *at == time_ns => *entry = value,
            _ if place == 0 && is_full => return false,
            _ => {
                self.entries.insert(place, (time_ns, value));
                if self.entries.len() > self.capacity {
                    self.entries.pop_front();
                }
            }
        }
        true
    }

    /// The value of exactly this time.
    pub(crate) fn of(&mut self, time_ns: i64) -> Option<&mut T> {
        let place = self.entries.binary_search_by_key(&time_ns, |(at, _)| *at).ok()?;
        self.entries.get_mut(place).map(|(_, value)| value)
    }

    /// Time and value of the latest entry.
    pub(crate) fn latest(&self) -> Option<(i64, T)> {
        self.entries.back().copied()
    }

    pub(crate) fn around(&self, time_ns: i64, max_gap_ns: i64) -> Result<Around<T>, NoState> {
        let place = self.entries.partition_point(|(at, _)| *at < time_ns);
        match (
            place.checked_sub(1).and_then(|k| self.entries.get(k)),
            self.entries.get(place),
        ) {
            (_, Some((at, value))) if *at == time_ns => Ok(Around::At(*value)),
            (Some(before), Some(after)) if after.0.saturating_sub(before.0) <= max_gap_ns => {
                Ok(Around::Between([*before, *after]))
            }
            (Some(_), Some(_)) => Err(NoState::Gap),
            (None, Some(_)) => Err(NoState::TooOld),
            (Some(_), None) => Err(NoState::NotYet),
            (None, None) => Err(NoState::None),
        }
    }
}
