//! Port of an operator: sends orders to fusion, and receives the states of orders.
//!
//! Fusion identifies an order by the token, so an order may be sent again until the state is published: the repetition
//! has no further effect. The port needs write access to the instance's folder; the file mode of the folder therefore
//! decides which users give orders.

use std::sync::atomic::{AtomicU64, Ordering};

use messages::{Order, OrderState, Refusal};

use crate::{Bus, BusError, Mark, Publisher, Subscriber, Transport};

/// Time after which an unanswered order is sent again, nanoseconds: far longer than an answer takes.
const REPEAT_NS: i64 = 1_000_000_000;

/// Port for orders of an operator.
#[derive(Debug)]
pub struct OrderPort<S: Transport> {
    orders: Publisher<S, Order>,
    states: Subscriber<S, OrderState>,
    /// Order without answer, and the monotonic time of the next send.
    pending: Option<(Order, i64)>,
    list: Vec<OrderState>,
}

impl<S: Transport> OrderPort<S> {
    /// Opens the port.
    ///
    /// # Errors
    /// If the deployment does not run, or the topic has no free place.
    pub fn open(bus: &Bus<S>, incarnation: u64) -> Result<Self, BusError> {
        Ok(Self {
            orders: bus.publisher(&messages::orders(), incarnation)?,
            states: bus.subscriber(&messages::order_states(), || incarnation)?,
            pending: None,
            list: Vec::new(),
        })
    }

    /// Gives an order at `utc_ns` (nanoseconds since 1970); [`Self::turn`] sends the order and returns the answer.
    pub fn give(&mut self, order: &Order, utc_ns: i64) {
        let order = Order {
            token: token(utc_ns),
            sent_ns: utc_ns,
            ..*order
        };
        self.pending = Some((order, i64::MIN));
    }

    /// Stops sending the pending order after the sender's time limit. Fusion may have obeyed the order already.
    pub fn withdraw(&mut self) {
        self.pending = None;
    }

    /// Sends the orders due at `mono_ns` (monotonic, nanoseconds) and takes the published states. Returns the state
    /// of the pending order, if published by fusion.
    ///
    /// # Errors
    /// If shared memory fails.
    pub fn turn(&mut self, mono_ns: i64) -> Result<Option<OrderState>, BusError> {
        if let Some((order, due_ns)) = &mut self.pending
            && mono_ns >= *due_ns
        {
            *due_ns = mono_ns.saturating_add(REPEAT_NS);
            let mark = Mark {
                progress_ns: i64::MIN,
                sent_ns: mono_ns,
                end: false,
            };
            self.orders.send(mark, 1, |_, _| *order)?;
        }
        let list = &mut self.list;
        self.states.take(usize::MAX, |_, slice| {
            list.clear();
            list.extend_from_slice(slice);
        })?;
        let Some((order, _)) = &self.pending else {
            return Ok(None);
        };
        // A refusal for want of time is followed by a repetition.
        let answer = list.iter().find(|state| {
            let is_early = matches!(state.refusal(), Some(Refusal::TooMany | Refusal::Busy));
            state.order.token == order.token && !is_early
        });
        let answer = answer.copied();
        if answer.is_some() {
            self.pending = None;
        }
        Ok(answer)
    }

    /// Returns the orders in force and the orders that ended recently, as last published.
    pub fn list(&self) -> &[OrderState] {
        &self.list
    }
}

/// Returns a number that no other order has: by time, process and count.
fn token(utc_ns: i64) -> u64 {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let own = u64::from(std::process::id()) << 42;
    (utc_ns.cast_unsigned() ^ own).wrapping_add(count).max(1)
}
