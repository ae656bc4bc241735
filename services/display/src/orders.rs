//! Orders on their way to fusion, and the list of orders.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use bus::{Bus, BusError, OrderPort, Transport};
use messages::{Order, OrderKind, OrderState, OrderStatus, Parameter, Refusal};
use runtime::Now;
use serde_json::{Value, json};
use web::tokio::sync::oneshot;

use crate::details::seconds;
use crate::world::World;

/// Maximum number of orders that wait for their answers.
const WAITING_MAX: usize = 8;
/// Orders that may come at once, and time for one more, nanoseconds.
const BURST: i64 = 10;
const ORDER_NS: i64 = 200_000_000;
/// Time for which fusion's answer is waited for.
pub(crate) const PATIENCE: Duration = Duration::from_secs(8);

/// Orders on their way to the agent.
#[derive(Debug, Default)]
pub(crate) struct OrderQueue(Mutex<WaitingOrder>);

#[derive(Debug, Default)]
struct WaitingOrder {
    orders: VecDeque<(Order, oneshot::Sender<OrderState>)>,
    /// Monotonic time up to which the allowance is used, nanoseconds.
    used_until_ns: i64,
}

impl OrderQueue {
    /// Enters an order; `None` if too many orders came in a short time.
    pub(crate) fn enter(&self, order: Order, now: Now) -> Option<oneshot::Receiver<OrderState>> {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let next_ns = waiting.used_until_ns.max(now.mono_ns).saturating_add(ORDER_NS);
        if waiting.orders.len() == WAITING_MAX || next_ns > now.mono_ns.saturating_add(BURST * ORDER_NS) {
            return None;
        }
        waiting.used_until_ns = next_ns;
        let (sender, receiver) = oneshot::channel();
        waiting.orders.push_back((order, sender));
        Some(receiver)
    }

    fn next(&self) -> Option<(Order, oneshot::Sender<OrderState>)> {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.orders.pop_front()
    }
}

/// Agent's side: gives one order after another.
pub(crate) struct OrderAgent<S: Transport> {
    port: OrderPort<S>,
    /// Receiver of the present answer, and the monotonic time until which the answer is waited for.
    present: Option<(oneshot::Sender<OrderState>, i64)>,
}

impl<S: Transport> OrderAgent<S> {
    pub(crate) fn open(bus: &Bus<S>, incarnation: u64) -> Result<Self, BusError> {
        Ok(Self {
            port: OrderPort::open(bus, incarnation)?,
            present: None,
        })
    }

    /// Gives the next order, and passes answers on.
    pub(crate) fn turn(&mut self, queue: &OrderQueue, now: Now) -> Result<(), BusError> {
        if self
            .present
            .as_ref()
            .is_some_and(|(_, until_ns)| now.mono_ns > *until_ns)
        {
            // The page has the answer that fusion is silent: the order must not take effect later.
            self.present = None;
            self.port.withdraw();
        }
        if self.present.is_none()
            && let Some((order, answer)) = queue.next()
        {
            self.port.give(&order, now.utc_ns);
            self.present = Some((answer, now.mono_ns.saturating_add(PATIENCE.as_nanos() as i64)));
        }
        if let Some(state) = self.port.turn(now.mono_ns)?
            && let Some((answer, _)) = self.present.take()
        {
            // The page may have left.
            let _ = answer.send(state);
        }
        Ok(())
    }
}

/// Returns the orders for pages and scripts: `number`, `state`, `text`, `refusal`, `order`, `operator`, `changed_s`,
/// `ends_s`.
pub(crate) fn list(world: &World) -> Vec<Value> {
    let orders = world.observed.orders().iter();
    orders.map(|state| shown(state, world)).collect()
}

/// Returns the kinds of orders for pages: `kind`, `summary`, `needs`, `may` (parameters), `range` [2] of the value, and
/// whether the effect `lasts`.
pub(crate) fn kinds() -> Vec<Value> {
    let words = |parameters: &[Parameter]| parameters.iter().map(|one| one.word()).collect::<Vec<_>>();
    let kinds = OrderKind::ALL.iter().map(|kind| {
        json!({
            "kind": kind.word(),
            "summary": kind.summary(),
            "needs": words(kind.needs()),
            "may": words(kind.may()),
            "range": kind.range(),
            "lasts": kind.lasts(),
        })
    });
    kinds.collect()
}

pub(crate) fn shown(state: &OrderState, world: &World) -> Value {
    let order = &state.order;
    json!({
        "number": state.number,
        "state": state.status().map(OrderStatus::word),
        "text": state.text(),
        "refusal": state.refusal().map(Refusal::word),
        "order": order.words(|number| world.observed.known_name(number)),
        "operator": order.operator(),
        "changed_s": seconds(state.changed_ns),
        "ends_s": (order.ends_ns != i64::MAX).then(|| seconds(order.ends_ns)),
    })
}
