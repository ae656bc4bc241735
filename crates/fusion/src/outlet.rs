//! The way out of the engine: states, decisions and counts.

use messages::{Counter, SystemTrack};

use crate::engine_counters::EngineCounters;
use crate::explanation::{Decision, Sink};

/// The counters, and the message that is being written: a large one, filled anew each time and never copied here.
#[derive(Debug)]
pub(crate) struct Outbox {
    pub(crate) counts: EngineCounters,
    message: Box<SystemTrack>,
}

impl Outbox {
    /// All zero, for `sources` sources.
    pub(crate) fn new(sources: usize) -> Self {
        Self {
            counts: EngineCounters::new(sources),
            message: Box::default(),
        }
    }

    /// The way out to `sink`.
    pub(crate) fn to<'a, S: Sink>(&'a mut self, sink: &'a mut S) -> Outlet<'a, S> {
        Outlet { outbox: self, sink }
    }
}

/// The caller's sink beside the engine's counters.
pub(crate) struct Outlet<'a, S> {
    outbox: &'a mut Outbox,
    sink: &'a mut S,
}

impl<S: Sink> Outlet<'_, S> {
    /// Hands out the message that `write` makes of the one before.
    pub(crate) fn track(&mut self, write: impl FnOnce(&mut SystemTrack)) {
        write(&mut self.outbox.message);
        self.sink.track(&self.outbox.message);
    }

    pub(crate) fn decision(&mut self, decision: &Decision) {
        self.sink.decision(decision);
    }

    pub(crate) fn count(&mut self, source: u16, counter: Counter) {
        self.outbox.counts.add(source, counter);
    }
}
