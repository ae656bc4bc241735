//! Samples that a recording gives beside its tracks: detections of which the tracks are made, and statements.
//!
//! The tracks set the pace. What is due before the next tracks is published before these; after a restart, what a
//! consumer still lacks is published again, with the same numbers.

use std::collections::VecDeque;

use bus::Mark;
use messages::Outgoing;
use runtime::Now;
use runtime::clock::mono_ns;

use crate::outlet::PacedOutlet;

/// Samples in the order in which they were made, numbered by their place, each with the time at which it is due (UTC,
/// nanoseconds).
#[derive(Debug)]
pub(crate) struct Beside<T> {
    waiting: VecDeque<(u64, i64, T)>,
    next_number: u64,
}

impl<T> Default for Beside<T> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            next_number: 0,
        }
    }
}

impl<T> Beside<T> {
    /// Adds a sample that is due at `due_ns` (UTC, nanoseconds).
    pub(crate) fn push(&mut self, due_ns: i64, sample: T) {
        self.waiting.push_back((self.next_number, due_ns, sample));
        self.next_number += 1;
    }

    fn skip_to(&mut self, first_needed: u64) {
        while self.waiting.front().is_some_and(|(number, ..)| *number < first_needed) {
            self.waiting.pop_front();
        }
    }

    /// Number of the first samples, at most `slice_len`, that are due at `until_ns`, and the time of the last of them.
    fn due(&self, slice_len: usize, until_ns: i64) -> Option<(usize, i64)> {
        let due = self.waiting.iter().take(slice_len);
        let due = due.take_while(|(_, due_ns, _)| *due_ns <= until_ns);
        due.enumerate().last().map(|(last, (_, due_ns, _))| (last + 1, *due_ns))
    }
}

/// The way out of these samples. Only the recorder reads all of them.
#[derive(Debug)]
pub(crate) struct BesideOutlet<T: Outgoing>(pub(crate) PacedOutlet<T>);

impl<T: Outgoing> BesideOutlet<T> {
    /// Publishes a slice of the samples that are due at `until_ns`; `None` if there are none, else whether there was
    /// room.
    pub(crate) fn publish(&mut self, samples: &mut Beside<T>, until_ns: i64, now: Now) -> anyhow::Result<Option<bool>> {
        let Self(outlet) = self;
        outlet.update()?;
        samples.skip_to(outlet.flow().first_needed());
        let Some((count, progress_ns)) = samples.due(outlet.slice_len(), until_ns) else {
            return Ok(None);
        };
        if !outlet.may_send() {
            return Ok(Some(false));
        }
        let mark = Mark {
            progress_ns,
            sent_ns: mono_ns(),
            end: false,
        };
        outlet.send(mark, count, now.mono_ns, || {
            let next = samples.waiting.pop_front();
            next.map_or_else(Default::default, |(number, _, sample)| (number, sample))
        })?;
        Ok(Some(true))
    }

    /// Publishes the end.
    pub(crate) fn end(&mut self, mark: Mark, now: Now) -> anyhow::Result<()> {
        Ok(self.0.send(mark, 0, now.mono_ns, Default::default)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_due_goes_out_by_slices_and_what_a_consumer_has_is_left_out() {
        let mut beside = Beside::default();
        for due_ns in [10, 20, 20, 30] {
            beside.push(due_ns, ());
        }
        assert_eq!(beside.due(2, 5), None);
        assert_eq!(beside.due(2, 20), Some((2, 20)));
        assert_eq!(beside.due(9, 25), Some((3, 20)));
        beside.skip_to(3);
        assert_eq!(beside.due(9, i64::MAX), Some((1, 30)));
    }
}
