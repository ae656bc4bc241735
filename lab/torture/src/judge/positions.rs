//! Positions against the truth, of one target.

use super::finding::{Finding, Findings};
use super::limits::Limits;

/// States in a row that must be far off: one may be that of a report between two places.
const STATES: u32 = 3;
/// A position that stays within the first of these while the target moves by the second is frozen, metres.
const STILL_M: f64 = 1.0;
const MOVED_M: f64 = 100.0;

/// Memory of one target.
#[derive(Clone, Debug, Default)]
pub(crate) struct Positions {
    far_off: u32,
    /// Where the track, and the target, were when the track last moved.
    anchor_m: Option<[[f64; 2]; 2]>,
    is_frozen: bool,
    pub(crate) worst_m: f64,
}

impl Positions {
    /// Takes a state that a report led to; its error, metres.
    pub(crate) fn take(
        &mut self,
        address: u32,
        [shown_m, truth_m]: [[f64; 2]; 2],
        limits: &Limits,
        findings: &mut Findings,
    ) -> f64 {
        let error_m = distance(shown_m, truth_m);
        self.worst_m = self.worst_m.max(error_m);
        self.far_off = if error_m > limits.position_m {
            self.far_off + 1
        } else {
            0
        };
        if self.far_off == STATES {
            findings.add(Finding::Position, || {
                format!("{address:06X} is shown {error_m:.0} m off")
            });
        }
        match self.anchor_m {
            Some([shown_then_m, truth_then_m]) if distance(shown_m, shown_then_m) < STILL_M => {
                let moved_m = distance(truth_m, truth_then_m);
                if moved_m > MOVED_M && !self.is_frozen {
                    self.is_frozen = true;
                    findings.add(Finding::Frozen, || {
                        format!("{address:06X} has moved {moved_m:.0} m, its track less than {STILL_M} m")
                    });
                }
            }
            _ => (self.anchor_m, self.is_frozen) = (Some([shown_m, truth_m]), false),
        }
        error_m
    }

    /// The next state is not compared with those before.
    pub(crate) fn begin(&mut self) {
        (self.far_off, self.anchor_m) = (0, None);
    }
}

fn distance(one_m: [f64; 2], other_m: [f64; 2]) -> f64 {
    (one_m[0] - other_m[0]).hypot(one_m[1] - other_m[1])
}
