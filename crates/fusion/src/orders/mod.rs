//! Orders of operators, and execution by the engine.
//!
//! Effects on settings (condition, out, eta, k, rule) are a function of the configuration and of the orders in force.
//! Each change of the table applies all orders anew, in the order of their numbers (module `settings`). Effects on
//! tracks (drop, join, split, renumber) happen once; the table then keeps the tracks apart or together (module
//! `tracks`). The checkpoint holds the table, so orders survive the process.

pub(crate) mod order_table;
mod settings;
mod tracks;

use messages::{Order, OrderKind, OrderState, OrderStatus, Refusal};

use crate::continuity::checkpoint::RecordKind;
use crate::engine::Engine;
use crate::explanation::Sink;
use crate::orders::order_table::{IN_FORCE_MAX, OrderRecord, OrderTable, PLACES};

impl Engine {
    /// Returns the state of the order that was obeyed under this token.
    pub fn order_of_token(&self, token: u64) -> Option<OrderState> {
        let records = &self.orders.records;
        let obeyed = records
            .iter()
            .find(|record| record.number != 0 && record.order().token == token);
        obeyed.map(OrderRecord::state)
    }

    /// Returns the orders in force, oldest first.
    pub fn orders_in_force(&self) -> Vec<OrderState> {
        let mut states: Vec<OrderState> = self.orders.in_force().map(OrderRecord::state).collect();
        states.sort_unstable_by_key(|state| state.number);
        states
    }

    /// Checks an order against sources, settings and tracks, without an effect.
    ///
    /// # Errors
    /// The reason for which [`Self::obey`] would refuse the order.
    pub fn examine(&self, order: &Order) -> Result<(), Refusal> {
        let kind = messages::check_order(order)?;
        let sources = self.settings.sources.len();
        let is_known = |source: u16| source == messages::NO_SOURCE || usize::from(source) < sources;
        if !is_known(order.source) || !is_known(order.other_source) {
            return Err(Refusal::UnknownSource);
        }
        if order.ends_ns <= self.schedule.now_ns() {
            return Err(Refusal::Expired);
        }
        match kind {
            OrderKind::Cancel => {
                let found = self.orders.place_of(order.number);
                return found.map(|_| ()).ok_or(Refusal::UnknownOrder);
            }
            OrderKind::Drop | OrderKind::Join | OrderKind::Split | OrderKind::Renumber => {
                self.examine_tracks(kind, order)?;
            }
            _ => self.examine_settings(kind, order)?,
        }
        let has_room = !kind.lasts() || self.orders.in_force().count() < IN_FORCE_MAX;
        has_room.then_some(()).ok_or(Refusal::TableFull)
    }

    /// Obeys an order at the engine's present time. All changes of orders are handed to `sink`.
    ///
    /// # Errors
    /// The reason of a refusal; the order then has no effect.
    pub fn obey(&mut self, order: &Order, sink: &mut impl Sink) -> Result<(), Refusal> {
        self.examine(order)?;
        let sink = &mut self.host_clock.outward(sink);
        let kind = order.kind().ok_or(Refusal::UnknownKind)?;
        let place = self.orders.free_place().ok_or(Refusal::TableFull)?;
        let mut record = OrderRecord {
            words: order.to_words(),
            number: self.orders.next_number,
            status: OrderStatus::Done.code(),
            changed_ns: self.schedule.now_ns(),
            ..OrderRecord::FREE
        };
        if kind.lasts() {
            record.status = OrderStatus::InForce.code();
            self.replace(kind, order, sink);
        }
        match kind {
            OrderKind::Cancel => {
                if let Some(place) = self.orders.place_of(order.number) {
                    self.end_order(place, OrderStatus::Cancelled, sink);
                }
            }
            OrderKind::In => self.replace(OrderKind::Out, order, sink),
            OrderKind::Condition if settings::ends_conditions(order) => record.status = OrderStatus::Done.code(),
            OrderKind::Out => self.drop_source(order.source),
            OrderKind::Reset => self.reset_source(order.source),
            OrderKind::Drop => self.drop_track(order, &mut record, sink),
            OrderKind::Join => self.join_tracks(order, &mut record, sink),
            OrderKind::Split => self.split_track(order, &mut record, sink),
            OrderKind::Renumber => self.renumber_track(order, &mut record, sink),
            _ => {}
        }
        self.orders.records[place] = record;
        self.index_orders();
        self.keep_order(place);
        self.apply_orders();
        sink.order(&record.state());
        Ok(())
    }

    /// Ends the orders in force of `kind` for the subject of `order`.
    fn replace(&mut self, kind: OrderKind, order: &Order, sink: &mut impl Sink) {
        let mut number = 0;
        while let Some(place) = self.orders.next_in_force(number) {
            let record = &self.orders.records[place];
            number = record.number;
            if record.kind() == Some(kind) && settings::is_same_subject(kind, &record.order(), order) {
                self.end_order(place, OrderStatus::Replaced, sink);
            }
        }
    }

    /// Ends the order at `place` of the table.
    fn end_order(&mut self, place: usize, status: OrderStatus, sink: &mut impl Sink) {
        self.release_tracks(place);
        let changed_ns = self.schedule.now_ns();
        let record = &mut self.orders.records[place];
        (record.status, record.changed_ns) = (status.code(), changed_ns);
        sink.order(&record.state());
        self.index_orders();
        self.keep_order(place);
        self.apply_orders();
    }

    /// Ends the orders expired at `time_ns`, and looks at the tracks of the other orders.
    #[cold]
    pub(crate) fn look_at_orders(&mut self, time_ns: i64, sink: &mut impl Sink) {
        while let Some(place) = self
            .orders
            .records
            .iter()
            .position(|record| record.is_in_force() && record.order().ends_ns <= time_ns)
        {
            self.end_order(place, OrderStatus::Expired, sink);
        }
        if self.orders.watch_ns <= time_ns {
            self.watch_tracks(sink);
            self.orders.watch_ns = i64::MAX;
        }
        self.index_orders();
    }

    fn index_orders(&mut self) {
        self.orders.index(self.schedule.now_ns());
        self.schedule.set_orders_due(self.orders.due_ns);
    }

    /// Writes the record at `place` into the checkpoint.
    fn keep_order(&mut self, place: usize) {
        if let Some(checkpoint) = &mut self.tracks.checkpoint {
            checkpoint.write(RecordKind::Orders, place, &self.orders.records[place]);
        }
    }

    /// Writes all records into a new checkpoint.
    pub(crate) fn keep_orders(&mut self) {
        for place in 0..PLACES {
            if self.orders.records[place].number != 0 {
                self.keep_order(place);
            }
        }
    }

    /// Continues with the table of an image.
    pub(crate) fn resume_order_table(&mut self, orders: OrderTable) {
        self.orders = OrderTable {
            configured: std::mem::take(&mut self.orders.configured),
            ..orders
        };
        self.apply_orders();
    }

    /// Resumes the table of a former process; the system tracks live already.
    pub(crate) fn resume_orders(&mut self, records: impl Iterator<Item = (usize, OrderRecord)>, sink: &mut impl Sink) {
        for (place, record) in records {
            if let Some(to) = self.orders.records.get_mut(place) {
                *to = record;
            }
        }
        self.index_orders();
        self.apply_orders();
        self.bind_tracks();
        for state in self.orders_in_force() {
            sink.order(&state);
        }
    }
}
