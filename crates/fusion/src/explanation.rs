//! Receivers of fusion's states and decisions, with reasons (BF-4).
//!
//! Each new state of a system track, and each decision before it, is passed on as a record.

use messages::{Decision, OrderState, SystemTrack};

use crate::update::filter_input::FilterInput;

/// Receiver of the engine's output. Every closure that takes a system track is a receiver that ignores decisions.
pub trait Sink {
    /// A system track has a new state.
    fn track(&mut self, track: &SystemTrack);

    /// A system track has a new state from local sources alone, for other centres. Passed on before the state with
    /// other centres' data, and only if [`exchange`](crate::Settings::exchange) requests it.
    fn own_track(&mut self, track: &SystemTrack) {
        let _ = track;
    }

    /// The state of an order has changed.
    fn order(&mut self, state: &OrderState) {
        let _ = state;
    }

    /// Something was decided. The sequence number and the epoch are the publisher's, and 0 here.
    fn decision(&mut self, decision: &Decision) {
        let _ = decision;
    }

    /// Whether [`Self::input`] is called.
    fn follows_inputs(&self) -> bool {
        false
    }

    /// The filter of a system track has received something.
    fn input(&mut self, input: &FilterInput) {
        let _ = input;
    }
}

impl<F: FnMut(&SystemTrack)> Sink for F {
    fn track(&mut self, track: &SystemTrack) {
        self(track);
    }
}
