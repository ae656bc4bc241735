//! Counts of processed, rejected (input) and dropped (for lack of room) items.

/// Counters, which only rise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LocatorCounts {
    /// Bearings taken.
    pub bearings: u64,
    /// Bearings rejected: a value that is no number, or no standard deviation.
    pub unusable: u64,
    /// Bearings rejected: older than the emitter's last bearing.
    pub out_of_order: u64,
    /// Bearings dropped: of a new emitter, and there is no place.
    pub table_full: u64,
    /// Emitters seen.
    pub emitters: u64,
    /// Emitters replaced by another emitter.
    pub emitters_dropped: u64,
    /// Bearings associated with an emitter by frequency and direction.
    pub associated: u64,
    /// Bearings of emitters without a fix: the geometry does not allow a fix.
    pub without_fix: u64,
    /// Bearings set aside by the most probable model.
    pub set_aside: u64,
    /// Fixes given out.
    pub fixes: u64,
    /// Arrival times and differences taken.
    pub arrivals: u64,
    /// Transmissions of reference emitters used for the receivers' clocks.
    pub references: u64,
    /// Transmissions rejected: received by a single receiver.
    pub alone: u64,
    /// Transmissions rejected: the receivers' clocks are not known yet.
    pub clock_unknown: u64,
    /// Transmissions rejected: no position has such a difference of distances.
    pub impossible: u64,
    /// Ready-made fixes taken.
    pub ready_fixes: u64,
}

impl LocatorCounts {
    /// Measurements taken, of all kinds.
    pub fn measurements(&self) -> u64 {
        self.bearings + self.arrivals + self.ready_fixes
    }
}
