//! Orders on their way to a loop, and their states on the way out.
//!
//! The desk checks what an order states of itself, and bounds the rate of each sender, so that neither malformed orders
//! nor a flood reach the loop. The loop decides everything else. Each change of the list of orders is published at
//! once, and the list again twice a second.

use bus::{Bus, BusError, Mark, Publisher, SharedMemory, Subscriber};
use messages::{Order, OrderState, OrderStatus, Refusal};

use crate::clock::{Now, mono_ns};
use crate::queues::Queues;

/// Orders that a sender may give at once, and time for one more, nanoseconds: far more than operators need.
const BURST: i64 = 32;
const ORDER_NS: i64 = 50_000_000;
/// Number of senders with their own allowance; a further sender replaces the longest silent sender.
const SENDERS_MAX: usize = 16;
/// Time between two publications of an unchanged list, nanoseconds.
const REPEAT_NS: i64 = 500_000_000;
/// Time for which an order that is no longer in force stays in the list, nanoseconds.
const ENDED_FOR_NS: i64 = 60_000_000_000;

/// Desk for the orders to one loop.
pub(crate) struct OrderDesk {
    orders: Subscriber<SharedMemory, Order>,
    states: Publisher<SharedMemory, OrderState>,
    senders: Vec<SenderAllowance>,
    /// Listed orders with the monotonic time of their latest change.
    list: Vec<(OrderState, i64)>,
    published_ns: i64,
}

/// Allowance of a sender.
struct SenderAllowance {
    incarnation: u64,
    /// Monotonic time up to which the allowance is used, nanoseconds.
    used_until_ns: i64,
}

impl OrderDesk {
    /// Opens the topics.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(crate) fn open(bus: &Bus<SharedMemory>, incarnation: u64) -> Result<Self, BusError> {
        Ok(Self {
            orders: bus.subscriber(&messages::orders(), || mono_ns() as u64)?,
            states: bus.publisher(&messages::order_states(), incarnation)?,
            senders: Vec::new(),
            list: Vec::new(),
            published_ns: i64::MIN,
        })
    }

    /// Passes orders to the loop, takes states from the loop, and publishes the list. Returns whether an order or a
    /// state came.
    ///
    /// # Errors
    /// If shared memory fails.
    pub(crate) fn turn(&mut self, queues: &Queues, now: Now) -> Result<bool, BusError> {
        let Self { orders, senders, .. } = self;
        let mut refused = Vec::new();
        let leads = queues.leads();
        let taken = orders.take(usize::MAX, |header, slice| {
            for order in slice.iter().filter(|_| leads) {
                let admitted = admit(senders, header.incarnation, now.mono_ns);
                let checked = messages::check_order(order).and_then(|_| match admitted {
                    true => queues.orders.push(*order).map_err(|_| Refusal::TooMany),
                    false => Err(Refusal::TooMany),
                });
                if let Err(refusal) = checked {
                    queues.count_refused();
                    if admitted {
                        refused.push(OrderState::refused(order, refusal, now.utc_ns));
                    }
                }
            }
        })?;
        let mut has_changed = !refused.is_empty();
        for state in refused {
            self.enter(state, now);
        }
        while let Some(state) = queues.order_states.pop() {
            has_changed = true;
            self.enter(state, now);
        }
        let is_due = !self.list.is_empty() && now.mono_ns >= self.published_ns.saturating_add(REPEAT_NS);
        if has_changed || is_due {
            self.publish(now)?;
        }
        Ok(taken > 0 || has_changed)
    }

    /// Enters a state in the list.
    fn enter(&mut self, state: OrderState, now: Now) {
        let is_same = |(other, _): &(OrderState, i64)| match state.number {
            0 => other.number == 0 && other.order.token == state.order.token,
            number => other.number == number,
        };
        self.list.retain(|listed| !is_same(listed));
        if self.list.len() == messages::order_states().capacity.slice_len {
            let ended = self.list.iter().position(|(listed, _)| !is_in_force(listed));
            self.list.remove(ended.unwrap_or(0));
        }
        let state = OrderState {
            has_changed: 1,
            ..state.with_sentence()
        };
        self.list.push((state, now.mono_ns));
    }

    fn publish(&mut self, now: Now) -> Result<(), BusError> {
        self.published_ns = now.mono_ns;
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: now.mono_ns,
            end: false,
        };
        let list = &self.list;
        self.states.send(mark, list.len(), |place, sequence| OrderState {
            time_ns: now.utc_ns,
            sequence,
            ..list[place].0
        })?;
        for (state, _) in &mut self.list {
            state.has_changed = 0;
        }
        let kept_ns = now.mono_ns.saturating_sub(ENDED_FOR_NS);
        self.list
            .retain(|(state, changed_ns)| is_in_force(state) || *changed_ns > kept_ns);
        Ok(())
    }
}

fn is_in_force(state: &OrderState) -> bool {
    state.status() == Some(OrderStatus::InForce)
}

/// Returns whether a sender may give an order now.
fn admit(senders: &mut Vec<SenderAllowance>, incarnation: u64, now_ns: i64) -> bool {
    let known = senders.iter().position(|sender| sender.incarnation == incarnation);
    let place = known.unwrap_or_else(|| {
        if senders.len() == SENDERS_MAX {
            let silent = (0..SENDERS_MAX).min_by_key(|place| senders[*place].used_until_ns);
            senders.swap_remove(silent.unwrap_or(0));
        }
        senders.push(SenderAllowance {
            incarnation,
            used_until_ns: i64::MIN,
        });
        senders.len() - 1
    });
    let used_until_ns = &mut senders[place].used_until_ns;
    let next_ns = (*used_until_ns).max(now_ns).saturating_add(ORDER_NS);
    let is_admitted = next_ns <= now_ns.saturating_add(BURST * ORDER_NS);
    if is_admitted {
        *used_until_ns = next_ns;
    }
    is_admitted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_of_one_sender_leaves_the_allowance_of_another() {
        let mut senders = Vec::new();
        let mut count = |incarnation: u64, now_ns: i64, orders: usize| {
            (0..orders).filter(|_| admit(&mut senders, incarnation, now_ns)).count()
        };
        assert_eq!(count(1, 0, 10_000), 32);
        assert_eq!(count(2, 0, 3), 3);
        assert_eq!(count(1, 1_000_000_000, 10_000), 20);
        assert_eq!(count(1, 100_000_000_000, 10_000), 32);
        for other in 3..100 {
            assert_eq!(count(other, 100_000_000_001, 1), 1);
        }
    }
}
