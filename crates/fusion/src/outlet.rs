//! The way out of the engine: states, decisions and counts.

use messages::{Counter, SystemTrack};

use crate::engine_counters::EngineCounters;
use crate::explanation::{Decision, Sink};

/// The caller's sink beside the engine's counters.
pub(crate) struct Outlet<'a, S> {
    pub(crate) counts: &'a mut EngineCounters,
    pub(crate) sink: &'a mut S,
}

impl<S: Sink> Outlet<'_, S> {
    pub(crate) fn track(&mut self, track: &SystemTrack) {
        self.sink.track(track);
    }

    pub(crate) fn decision(&mut self, decision: &Decision) {
        self.sink.decision(decision);
    }

    pub(crate) fn count(&mut self, source: u16, counter: Counter) {
        self.counts.add(source, counter);
    }
}
