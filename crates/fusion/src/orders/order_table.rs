//! Table of orders: orders in force, and orders that ended recently.

use kept::kept;
use messages::{FusionRule, ORDER_WORDS, Order, OrderKind, OrderState, OrderStatus};
use serde::{Deserialize, Serialize};

use crate::settings::Settings;

/// Maximum number of orders in force.
pub(crate) const IN_FORCE_MAX: usize = 64;
/// Places of the table: orders in force, and orders that ended recently, for repetitions with the same token.
pub(crate) const PLACES: usize = 2 * IN_FORCE_MAX;
/// Time between two looks at the tracks of orders, nanoseconds.
pub(crate) const WATCH_NS: i64 = 1_000_000_000;
/// Maximum number of sensor tracks that an order keeps from starting a system track.
const BLOCKED_MAX: usize = 16;

kept! {
    /// An order with its state.
    #[derive(Clone, Copy, Debug, Serialize, Deserialize)]
    pub(crate) struct OrderRecord {
        pub(crate) words: [u64; ORDER_WORDS],
        /// Number of the order, ascending; 0: the place is free.
        pub(crate) number: u32,
        pub(crate) status: u8,
        pub(crate) changed_ns: i64,
        /// Numbers of the system tracks concerned.
        pub(crate) tracks: [u32; 2],
        /// Sensor tracks, by source and number, that start no system track.
        pub(crate) blocked: [(u16, u32); BLOCKED_MAX],
        pub(crate) blocked_count: u8,
        /// Time of the latest report of these.
        pub(crate) blocked_ns: i64,
        /// Time since which the tracks have been too far apart; `i64::MAX` otherwise.
        pub(crate) apart_since_ns: i64,
    }
}

impl OrderRecord {
    pub(crate) const FREE: Self = Self {
        words: [0; ORDER_WORDS],
        number: 0,
        status: 0,
        changed_ns: i64::MIN,
        tracks: [0; 2],
        blocked: [(0, 0); BLOCKED_MAX],
        blocked_count: 0,
        blocked_ns: i64::MIN,
        apart_since_ns: i64::MAX,
    };

    pub(crate) fn order(&self) -> Order {
        Order::of_words(&self.words)
    }

    pub(crate) fn is_in_force(&self) -> bool {
        self.number != 0 && self.status == OrderStatus::InForce.code()
    }

    pub(crate) fn kind(&self) -> Option<OrderKind> {
        self.order().kind()
    }

    pub(crate) fn state(&self) -> OrderState {
        OrderState {
            order: self.order(),
            changed_ns: self.changed_ns,
            number: self.number,
            status: self.status,
            ..OrderState::default()
        }
    }

    pub(crate) fn blocked(&self) -> &[(u16, u32)] {
        &self.blocked[..usize::from(self.blocked_count).min(BLOCKED_MAX)]
    }
}

/// Table of orders.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct OrderTable {
    pub(crate) records: Vec<OrderRecord>,
    pub(crate) next_number: u32,
    /// Time of the next look at the tracks of orders; `i64::MAX` without such orders.
    pub(crate) watch_ns: i64,
    /// Time of the next look or expiry, whichever is earlier; never (`i64::MAX`) without either.
    pub(crate) due_ns: i64,
    /// True while an order in force concerns tracks.
    pub(crate) concerns_tracks: bool,
    #[serde(skip)]
    pub(crate) configured: Configured,
}

impl OrderTable {
    /// Creates an empty table; `configured` are the settings without orders.
    pub(crate) fn new(configured: Configured) -> Self {
        Self {
            records: vec![OrderRecord::FREE; PLACES],
            next_number: 1,
            watch_ns: i64::MAX,
            due_ns: i64::MAX,
            concerns_tracks: false,
            configured,
        }
    }

    /// Returns the place of the order in force with this number.
    pub(crate) fn place_of(&self, number: u32) -> Option<usize> {
        let is_meant = |record: &OrderRecord| record.number == number && record.is_in_force();
        self.records.iter().position(is_meant)
    }

    pub(crate) fn in_force(&self) -> impl Iterator<Item = &OrderRecord> {
        self.records.iter().filter(|record| record.is_in_force())
    }

    /// Returns the place of the oldest order in force with a number above `number`.
    pub(crate) fn next_in_force(&self, number: u32) -> Option<usize> {
        let later = |record: &OrderRecord| record.is_in_force() && record.number > number;
        let places = (0..self.records.len()).filter(|place| later(&self.records[*place]));
        places.min_by_key(|place| self.records[*place].number)
    }

    /// Returns a place for a new record: free, or of the oldest ended order.
    pub(crate) fn free_place(&self) -> Option<usize> {
        let places = (0..self.records.len()).filter(|place| !self.records[*place].is_in_force());
        places.min_by_key(|place| self.records[*place].number)
    }

    /// Derives the values that the loop reads from the records, at `now_ns`.
    pub(crate) fn index(&mut self, now_ns: i64) {
        let binds = |kind| matches!(kind, OrderKind::Drop | OrderKind::Join | OrderKind::Split);
        let concerns_tracks = self.in_force().filter_map(OrderRecord::kind).any(binds);
        self.concerns_tracks = concerns_tracks;
        let next_ns = now_ns.saturating_add(WATCH_NS);
        self.watch_ns = if self.concerns_tracks {
            self.watch_ns.min(next_ns)
        } else {
            i64::MAX
        };
        let ends_ns = self.in_force().map(|record| record.order().ends_ns).min();
        self.due_ns = self.watch_ns.min(ends_ns.unwrap_or(i64::MAX));
        let last = self.records.iter().map(|record| record.number).max();
        self.next_number = self.next_number.max(last.unwrap_or(0).saturating_add(1));
    }
}

/// Settings of the configuration that orders change.
#[derive(Debug, Default)]
pub(crate) struct Configured {
    pub(crate) adjustments: Vec<f64>,
    pub(crate) rule: Option<FusionRule>,
}

impl Configured {
    /// Returns these settings of a configuration.
    pub(crate) fn of(settings: &Settings) -> Self {
        Self {
            adjustments: settings.sources.iter().map(|source| source.adjustment).collect(),
            rule: Some(settings.rule.name.0),
        }
    }
}
