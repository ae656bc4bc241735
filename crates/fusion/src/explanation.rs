//! Listeners to what fusion does, and why (BF-4).
//!
//! Each new state of a system track, and each decision on the way to it, is handed out as one record to whoever wants
//! it.

use messages::{Decision, OrderState, SystemTrack};

/// Takes what the engine hands out. Every closure that takes a system track is one, and leaves decisions alone.
pub trait Sink {
    /// A system track has a new state.
    fn track(&mut self, track: &SystemTrack);

    /// A system track has a new state by the sources here alone, for other centres. Handed out before the state that
    /// what they say has gone into, and only where [`exchange`](crate::Settings::exchange) asks for it.
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
}

impl<F: FnMut(&SystemTrack)> Sink for F {
    fn track(&mut self, track: &SystemTrack) {
        self(track);
    }
}
