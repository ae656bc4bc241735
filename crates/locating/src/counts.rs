//! Counts of processed, rejected (input) and dropped (for lack of room) items.

/// Counters; they only rise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LocatorCounts {
    /// Bearings taken.
    pub bearings: u64,
    /// Bearings rejected: a value that is no number, or no standard deviation.
    pub unusable: u64,
    /// Bearings rejected: older than the emitter's last one.
    pub out_of_order: u64,
    /// Bearings dropped: of a new emitter, and there is no place for it.
    pub table_full: u64,
    /// Emitters seen.
    pub emitters: u64,
    /// Emitters replaced by another emitter.
    pub emitters_dropped: u64,
    /// Bearings associated with their emitter by frequency and direction.
    pub associated: u64,
    /// Bearings of emitters without a fix: the geometry does not allow one.
    pub without_fix: u64,
    /// Bearings set aside by the most probable model.
    pub set_aside: u64,
    /// Fixes given out.
    pub fixes: u64,
}
