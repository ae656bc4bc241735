//! Due times: refreshes at whole multiples of the period, and a look at the sources once a second.

use serde::{Deserialize, Serialize};

/// Time between two looks at the learned properties of the sources, nanoseconds.
pub(crate) const TICK_NS: i64 = 1_000_000_000;

/// The engine's time, UTC, nanoseconds.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Schedule {
    /// The latest time that has passed.
    now_ns: i64,
    next_tick_ns: Option<i64>,
    refresh: Option<Refresh>,
    /// Time at which orders must be looked at; never (`i64::MAX`) without orders.
    orders_due_ns: i64,
}

/// States at uniform times.
#[derive(Debug, Serialize, Deserialize)]
struct Refresh {
    period_ns: i64,
    /// Delay of a refresh after the time of its states.
    delay_ns: i64,
    /// The next whole multiple of the period; `None` while nothing lives.
    next_ns: Option<i64>,
}

impl Schedule {
    /// With a refresh every `period_ns`, each due `delay_ns` after its time; none if there is no period.
    pub(crate) fn new(period_ns: Option<i64>, delay_ns: i64) -> Self {
        Self {
            now_ns: i64::MIN,
            next_tick_ns: None,
            refresh: period_ns.map(|period_ns| Refresh {
                period_ns,
                delay_ns,
                next_ns: None,
            }),
            orders_due_ns: i64::MAX,
        }
    }

    /// Sets the time at which orders must be looked at.
    pub(crate) fn set_orders_due(&mut self, due_ns: i64) {
        self.orders_due_ns = due_ns;
    }

    /// The latest time that has passed.
    pub(crate) fn now_ns(&self) -> i64 {
        self.now_ns
    }

    /// Lets time pass up to `time_ns`; time never goes back.
    pub(crate) fn pass(&mut self, time_ns: i64) {
        self.now_ns = self.now_ns.max(time_ns);
    }

    /// Returns the time of the next refresh or look at orders. There is no refresh (`i64::MAX`) if states come with
    /// reports or nothing lives.
    pub(crate) fn next_event(&mut self, nothing_lives: impl FnOnce() -> bool) -> i64 {
        let Some(refresh) = &mut self.refresh else {
            return self.orders_due_ns;
        };
        if nothing_lives() {
            refresh.next_ns = None;
            return self.orders_due_ns;
        }
        let (period_ns, delay_ns) = (refresh.period_ns, refresh.delay_ns);
        let next_ns = *refresh.next_ns.get_or_insert_with(|| {
            let past_ns = self.now_ns.saturating_sub(delay_ns).saturating_sub(1);
            past_ns
                .div_euclid(period_ns)
                .saturating_add(1)
                .saturating_mul(period_ns)
        });
        next_ns.saturating_add(delay_ns).min(self.orders_due_ns)
    }

    /// Returns the time of the due refresh, and counts the refresh as done; `None` without a due refresh.
    pub(crate) fn take_refresh(&mut self) -> Option<i64> {
        let refresh = self.refresh.as_mut()?;
        let time_ns = refresh.next_ns?;
        refresh.next_ns = Some(time_ns.saturating_add(refresh.period_ns));
        Some(time_ns)
    }

    /// Whether a second has passed since the last look at the sources; then the next second begins.
    pub(crate) fn tick(&mut self) -> bool {
        let next_ns = self.now_ns.saturating_add(TICK_NS);
        let due = self.now_ns >= *self.next_tick_ns.get_or_insert(next_ns);
        if due {
            self.next_tick_ns = Some(next_ns);
        }
        due
    }
}
