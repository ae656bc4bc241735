//! Verification of self-reported positions (ADS-B, AIS) by measuring sensors.
//!
//! Problem: an aircraft may report a false or frozen position. Its address is right, so the report joins the system
//! track of that address and drags the track away. Or the report comes first, and the radar's track of the address is
//! taken for misread.
//!
//! Method: each report of a self-reporting source is compared with the tracks of measuring sources of the same address.
//! A position is contradicted beyond all possible deviations: the possible bias between the two sources, four
//! deviations of both, and a floor (`identity.false_m`) for late stamps and inertial drift. After [`FALSE_FROM`]
//! contradicted reports in a row, the address is *isolated* for this source alone: its reports are rejected, its system
//! track starts anew from the measuring sensors or ends. [`TRUE_FROM`] agreeing reports in a row end the isolation.
//!
//! If most of a source's compared addresses are contradicted, a bias is the cause, and no address is isolated.
//!
//! Limit: an address not reported by any measuring sensor is not checked. A radar without Mode S reports no addresses.

use serde::{Deserialize, Serialize};

/// Contradicted reports in a row for isolation of an address, and agreeing reports in a row for its end.
const FALSE_FROM: u8 = 3;
const TRUE_FROM: u8 = 5;

/// Result of the comparisons of a sensor track of a self-reporting source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Verification {
    /// Reports in a row against the present state.
    against: u8,
    /// Whether the address is isolated.
    pub(crate) is_isolated: bool,
}

impl Verification {
    /// Learns from a comparison; `may_isolate` unless the source as a whole is off.
    pub(crate) fn learn(&mut self, is_contradicted: bool, may_isolate: bool) {
        if is_contradicted == self.is_isolated {
            self.against = 0;
            return;
        }
        self.against = self.against.saturating_add(1);
        let needed = if self.is_isolated { TRUE_FROM } else { FALSE_FROM };
        if self.against >= needed && (self.is_isolated || may_isolate) {
            (self.is_isolated, self.against) = (!self.is_isolated, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_isolated_and_comes_back_after_reports_in_a_row() {
        let mut verification = Verification::default();
        let mut states = Vec::new();
        for is_contradicted in [
            true, true, false, true, true, true, false, false, true, false, false, false, false, false,
        ] {
            verification.learn(is_contradicted, true);
            states.push(verification.is_isolated);
        }
        assert_eq!(states.iter().position(|isolated| *isolated), Some(5));
        assert_eq!(states.iter().rposition(|isolated| *isolated), Some(12));
        for _ in 0..10 {
            verification.learn(true, false);
        }
        assert!(
            !verification.is_isolated,
            "a source that is off as a whole isolates none"
        );
    }
}
