//! Alerts of a track, over its reports.
//!
//! - A report without an item neither raises nor clears the alert: the alert is held for [`HOLD_NS`].
//! - A special Mode 3/A code is an alert from the second report on: a single one may be a garbled reply.
//! - A resolution advisory lasts some tens of seconds, and the transponder then sends its text as well (RTCA DO-260B,
//!   2.2.3.2.7.3.2; ICAO Annex 10 volume IV, 4.3.8.4.2.2). Some transponders set the bit for whole flights without
//!   any text. Such a *stuck* bit is no alert.

use messages::alert_bits;
use observations::Alerts;

/// An alert that later reports do not mention stands for so long, nanoseconds: some reports of a slow sensor.
const HOLD_NS: i64 = 15_000_000_000;
/// A bit of a resolution advisory that stands for so long without a text is stuck, nanoseconds: four times a long
/// advisory.
const STUCK_NS: i64 = 120_000_000_000;

/// Memory of one track's alerts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AlertMemory {
    /// Alerts as last stated.
    raised: u8,
    /// Time of the last statement about each bit, nanoseconds.
    stated_ns: [i64; 8],
    /// Time since which the bit of a resolution advisory stands without a text, nanoseconds.
    bare_since_ns: Option<i64>,
    is_stuck: bool,
    /// Alerts of the last Mode 3/A code, and of the last two.
    of_code: u8,
    of_codes: u8,
}

/// Alerts of a track after a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Standing {
    /// Bits of `messages::alert_bits`.
    pub(crate) bits: u8,
    /// Whether the track's resolution advisory was recognised as stuck by this report.
    pub(crate) got_stuck: bool,
}

impl AlertMemory {
    /// The track's alerts after a report at `time_ns` with the statement `alerts` and a Mode 3/A code, if it has one.
    pub(crate) fn take(&mut self, time_ns: i64, alerts: Alerts, code: Option<u16>) -> Standing {
        for (bit, stated_ns) in self.stated_ns.iter_mut().enumerate() {
            let mask = 1 << bit;
            if alerts.stated & mask != 0 {
                *stated_ns = time_ns;
                self.raised = self.raised & !mask | alerts.raised & mask;
            } else if time_ns - *stated_ns > HOLD_NS {
                self.raised &= !mask;
            }
        }
        let got_stuck = self.judge_advisory(time_ns, alerts.has_advisory);
        let stuck = if self.is_stuck {
            alert_bits::RESOLUTION_ADVISORY
        } else {
            0
        };
        Standing {
            bits: self.raised & !stuck | self.confirmed(code),
            got_stuck,
        }
    }

    /// Notes how long the bit of a resolution advisory stands without a text; returns whether it has become stuck.
    fn judge_advisory(&mut self, time_ns: i64, has_advisory: bool) -> bool {
        if has_advisory || self.raised & alert_bits::RESOLUTION_ADVISORY == 0 {
            (self.bare_since_ns, self.is_stuck) = (None, false);
            return false;
        }
        let since_ns = *self.bare_since_ns.get_or_insert(time_ns);
        let was_stuck = self.is_stuck;
        self.is_stuck = time_ns - since_ns > STUCK_NS;
        self.is_stuck && !was_stuck
    }

    /// Alerts of the Mode 3/A code, once two successive codes are the same special code.
    fn confirmed(&mut self, code: Option<u16>) -> u8 {
        if let Some(code) = code {
            let before = std::mem::replace(&mut self.of_code, alerts_of_code(code));
            self.of_codes = self.of_code & before;
        }
        self.of_codes
    }
}

/// Alerts that a Mode 3/A code states by itself.
fn alerts_of_code(code: u16) -> u8 {
    match code {
        0o7500 => alert_bits::UNLAWFUL_INTERFERENCE,
        0o7600 => alert_bits::COMMUNICATION_FAILURE,
        0o7700 => alert_bits::EMERGENCY,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::S;

    const ADVISORY: u8 = alert_bits::RESOLUTION_ADVISORY;

    fn bare(is_set: bool) -> Alerts {
        Alerts::flag(ADVISORY, is_set)
    }

    #[test]
    fn reports_without_the_item_hold_an_alert_and_a_statement_clears_it() {
        let mut memory = AlertMemory::default();
        let mut at = |seconds: i64, alerts: Alerts| memory.take(1000 * S + seconds * S, alerts, None).bits;
        assert_eq!(at(0, Alerts::default()), 0);
        assert_eq!(at(1, bare(true)), ADVISORY);
        assert_eq!(
            at(6, Alerts::flag(alert_bits::MEDICAL, true)),
            ADVISORY | alert_bits::MEDICAL
        );
        assert_eq!(
            at(12, Alerts::flag(alert_bits::MEDICAL, false)),
            ADVISORY,
            "the item is absent"
        );
        assert_eq!(at(17, Alerts::default()), 0, "nothing for longer than the hold");
        assert_eq!(at(18, bare(true)), ADVISORY);
        assert_eq!(at(19, bare(false)), 0);
    }

    #[test]
    fn a_bit_that_stands_for_minutes_without_a_text_is_stuck_once() {
        let mut memory = AlertMemory::default();
        let mut stuck = 0;
        for second in 0..300 {
            let alerts = if second % 3 == 0 { Alerts::default() } else { bare(true) };
            let standing = memory.take(second * S, alerts, None);
            stuck += u32::from(standing.got_stuck);
            assert_eq!(
                standing.bits,
                if (1..=121).contains(&second) { ADVISORY } else { 0 },
                "{second}"
            );
        }
        assert_eq!(stuck, 1);
        assert_eq!(
            memory.take(300 * S, Alerts::advisory(true), None).bits,
            ADVISORY,
            "a text is believed"
        );
        assert_eq!(memory.take(301 * S, bare(false), None).bits, 0);
        assert_eq!(memory.take(302 * S, bare(true), None).bits, ADVISORY, "a new advisory");
    }

    #[test]
    fn an_advisory_with_its_text_is_never_stuck() {
        let mut memory = AlertMemory::default();
        for second in 0..300 {
            let alerts = if second % 10 == 0 {
                Alerts::advisory(true)
            } else {
                bare(true)
            };
            assert_eq!(memory.take(second * S, alerts, None).bits, ADVISORY);
        }
    }

    #[test]
    fn a_special_code_needs_two_reports() {
        let mut memory = AlertMemory::default();
        let mut bits = |code| memory.take(0, Alerts::default(), code).bits;
        assert_eq!(bits(Some(0o7700)), 0);
        assert_eq!(bits(Some(0o7600)), 0, "another special code");
        assert_eq!(bits(Some(0o7600)), alert_bits::COMMUNICATION_FAILURE);
        assert_eq!(
            bits(None),
            alert_bits::COMMUNICATION_FAILURE,
            "no code is no other code"
        );
        assert_eq!(bits(Some(0o1234)), 0);
        assert_eq!(bits(Some(0o7500)), 0);
        assert_eq!(bits(Some(0o7500)), alert_bits::UNLAWFUL_INTERFERENCE);
    }
}
