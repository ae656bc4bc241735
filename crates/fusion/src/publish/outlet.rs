//! The way out of the engine: states, decisions and counts.

use messages::{Counter, Decision, SystemTrack};

use crate::engine_counters::EngineCounters;
use crate::explanation::Sink;
use crate::update::filter_input::FilterInput;

/// The counters, and the message in preparation: a large message, filled anew each time and never copied here.
#[derive(Debug)]
pub(crate) struct EngineOutbox {
    pub(crate) counts: EngineCounters,
    message: Box<SystemTrack>,
}

impl EngineOutbox {
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
    outbox: &'a mut EngineOutbox,
    sink: &'a mut S,
}

impl<S: Sink> Outlet<'_, S> {
    /// Passes on the message written by `write` from the previous message. `false` for a state that is not finite: the
    /// message is then dropped and counted.
    pub(crate) fn track(&mut self, write: impl FnOnce(&mut SystemTrack)) -> bool {
        let message = &mut self.outbox.message;
        write(message);
        let is_sound = is_sound(message);
        if is_sound {
            self.sink.track(message);
        } else {
            self.outbox
                .counts
                .add(message.trigger_source, Counter::EstimatesRestarted);
        }
        is_sound
    }

    /// Hands out the state by the own sources alone, for other centres.
    pub(crate) fn own_track(&mut self, write: impl FnOnce(&mut SystemTrack)) {
        let message = &mut self.outbox.message;
        write(message);
        if is_sound(message) {
            self.sink.own_track(message);
        }
    }

    pub(crate) fn decision(&mut self, decision: &Decision) {
        self.sink.decision(decision);
    }

    /// Passes on the input of a filter, if a receiver is present.
    #[inline]
    pub(crate) fn input(&mut self, input: impl FnOnce() -> FilterInput) {
        if self.sink.follows_inputs() {
            self.sink.input(&input());
        }
    }

    pub(crate) fn count(&mut self, source: u16, counter: Counter) {
        self.outbox.counts.add(source, counter);
    }
}

/// Whether the state is finite.
#[inline]
fn is_sound(message: &SystemTrack) -> bool {
    // NaN and infinities times 0 are NaN: less than half the instructions of asking each value. Two sums let the
    // processor work on two values at once.
    let (position, velocity) = (&message.position_m, &message.velocity_mps);
    let (pairs, rest) = message.covariance.upper.as_chunks::<2>();
    let mut sums = [rest[0] * 0.0, 0.0];
    for [first, second] in pairs {
        sums[0] += first * 0.0;
        sums[1] += second * 0.0;
    }
    for (first, second) in position.iter().zip(velocity) {
        sums[0] += first * 0.0;
        sums[1] += second * 0.0;
    }
    sums[0] + sums[1] == 0.0
}
