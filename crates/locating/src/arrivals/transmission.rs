//! A transmission, and the receivers of this transmission.

use observations::Receiver;

/// Most receivers of a transmission.
pub(crate) const RECEPTIONS_MAX: usize = 8;
/// Times of arrival are seconds since midnight, and a transmission may be received on both sides of midnight.
const DAY_S: f64 = 86_400.0;

/// Arrival of a transmission at a receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reception {
    pub(crate) receiver: Receiver,
    /// Number of the receiver's clock.
    pub(crate) clock: usize,
    pub(crate) t_s: f64,
    pub(crate) sigma_s: f64,
}

impl Reception {
    /// Difference of arrival times, seconds: this reception minus the other.
    pub(crate) fn after(&self, other: &Self) -> f64 {
        let difference_s = self.t_s - other.t_s;
        difference_s - DAY_S * (difference_s / DAY_S).round()
    }
}

/// A transmission with receptions being collected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transmission {
    pub(crate) time_ns: i64,
    pub(crate) emitter_id: u32,
    /// Place of the emitter, if a reference emitter.
    pub(crate) reference_m: Option<[f64; 3]>,
    receptions: [Reception; RECEPTIONS_MAX],
    len: usize,
}

impl Transmission {
    pub(crate) fn new(time_ns: i64, emitter_id: u32, reference_m: Option<[f64; 3]>, first: Reception) -> Self {
        Self {
            time_ns,
            emitter_id,
            reference_m,
            receptions: [first; RECEPTIONS_MAX],
            len: 1,
        }
    }

    pub(crate) fn receptions(&self) -> &[Reception] {
        &self.receptions[..self.len]
    }

    /// Whether a reception at `time_ns` belongs to this transmission: near in time, and of another receiver.
    pub(crate) fn may_take(&self, time_ns: i64, together_ns: i64, reception: &Reception) -> bool {
        let is_other = |known: &Reception| known.receiver.name != reception.receiver.name;
        self.len < RECEPTIONS_MAX
            && (time_ns - self.time_ns).abs() <= together_ns
            && self.receptions().iter().all(is_other)
    }

    pub(crate) fn push(&mut self, reception: Reception) {
        self.receptions[self.len] = reception;
        self.len += 1;
    }
}
