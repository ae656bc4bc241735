//! Topics whose samples are published without a gap, as far as the sender still has what was lost.
//!
//! A gap in the sequence numbers shows that a connection was interrupted. What comes after the gap is held, and the
//! sender is asked for what is missing ([`history`](crate::history)). When the answer has come, or nobody answers, what
//! is held is published; what is still missing then is counted as lost.

use std::collections::VecDeque;

use bus::{Bus, Payload, SharedMemory};
use runtime::Now;

use crate::inbound::{Arrival, Counts, Inlet, Question, WAITING_OCTETS};
use crate::stand_in::Numbers;
use crate::wire::{Head, Slice};

/// Questions about one gap at most, where nobody answers.
const QUESTIONS_MAX: u32 = 4;
/// Time after a recovery in which samples may come twice: once in the answer and once on their own, nanoseconds.
const TWICE_NS: i64 = 10_000_000_000;

/// Publishes slices of one topic here.
pub(crate) trait Outlet {
    /// Type of the samples that come.
    type Came: Payload;

    /// Reads a message; `None` if it is none, which is counted.
    fn read(&mut self, arrival: &Arrival<'_>, counts: &mut Counts) -> Option<(Head, Vec<Slice<Self::Came>>)>;

    /// The numbers of the publishers elsewhere.
    fn numbers(&self) -> &Numbers;

    /// Publishes a slice that comes next, or after a gap.
    ///
    /// # Errors
    /// If shared memory fails.
    fn publish(
        &mut self,
        bus: &Bus<SharedMemory>,
        now: Now,
        came: (&Head, &Slice<Self::Came>),
        counts: &mut Counts,
    ) -> anyhow::Result<()>;
}

/// A topic whose gaps are filled.
pub(crate) struct InOrder<O: Outlet> {
    outlet: O,
    /// Key at which the sender answers; `None`: the topic has no history, since newer samples replace older ones.
    key: Option<String>,
    /// Slices after a gap, in their order; empty unless a gap is open.
    held: VecDeque<(Head, Slice<O::Came>)>,
    held_bytes: usize,
    /// Questions asked about the open gap.
    questions: u32,
    /// Whether the answer to the latest of them may still come.
    is_asked: bool,
    has_answer: bool,
    /// When the latest gap was closed, monotonic, nanoseconds.
    closed_ns: i64,
}

impl<O: Outlet> InOrder<O> {
    pub(crate) fn new(outlet: O, key: Option<String>) -> Self {
        Self {
            outlet,
            key,
            held: VecDeque::new(),
            held_bytes: 0,
            questions: 0,
            is_asked: false,
            has_answer: false,
            closed_ns: i64::MIN,
        }
    }

    fn hold(&mut self, head: &Head, slice: Slice<O::Came>) {
        self.held_bytes += size_of_val(&slice) + size_of_val(&slice.1[..]);
        self.held.push_back((*head, slice));
    }

    fn publish(
        &mut self,
        arrival: &Arrival<'_>,
        (head, slice): (&Head, &Slice<O::Came>),
        counts: &mut Counts,
    ) -> anyhow::Result<()> {
        match self.outlet.numbers().missing(&slice.0) {
            Some(missing) => {
                counts.missing += missing;
                counts.came += slice.1.len() as u64;
                self.outlet.publish(arrival.bus, arrival.now, (head, slice), counts)
            }
            None => {
                let is_recovering = !self.held.is_empty() || arrival.is_answer;
                let may_repeat = is_recovering || arrival.now.mono_ns.saturating_sub(self.closed_ns) < TWICE_NS;
                counts.rejected += u64::from(!may_repeat);
                Ok(())
            }
        }
    }

    /// Publishes what is held: the answer has come, or none will.
    fn close(&mut self, arrival: &Arrival<'_>, counts: &mut Counts) -> anyhow::Result<()> {
        self.closed_ns = arrival.now.mono_ns;
        (self.held_bytes, self.questions, self.is_asked, self.has_answer) = (0, 0, false, false);
        for (head, slice) in std::mem::take(&mut self.held) {
            self.publish(arrival, (&head, &slice), counts)?;
        }
        Ok(())
    }
}

impl<O: Outlet> Inlet for InOrder<O> {
    fn take(&mut self, arrival: Arrival<'_>, counts: &mut Counts) -> anyhow::Result<()> {
        let Some((head, slices)) = self.outlet.read(&arrival, counts) else {
            return Ok(());
        };
        self.has_answer |= arrival.is_answer;
        for slice in slices {
            let has_gap = || self.key.is_some() && self.outlet.numbers().has_gap(&slice.0);
            let is_held = !arrival.is_answer && (!self.held.is_empty() || has_gap());
            match is_held {
                true => self.hold(&head, slice),
                false => self.publish(&arrival, (&head, &slice), counts)?,
            }
        }
        match self.held_bytes > WAITING_OCTETS {
            true => self.close(&arrival, counts),
            false => Ok(()),
        }
    }

    fn lacks(&self) -> Option<Question> {
        let is_due = !self.held.is_empty() && !self.is_asked;
        let key = self.key.clone().filter(|_| is_due)?;
        let payload = self.outlet.numbers().position()?.to_bytes();
        Some(Question { key, payload })
    }

    fn asked(&mut self) {
        self.is_asked = true;
        self.questions += 1;
    }

    fn answered(&mut self, arrival: Arrival<'_>, counts: &mut Counts) -> anyhow::Result<()> {
        self.is_asked = false;
        if !self.held.is_empty() && (self.has_answer || self.questions >= QUESTIONS_MAX) {
            return self.close(&arrival, counts);
        }
        Ok(())
    }
}
