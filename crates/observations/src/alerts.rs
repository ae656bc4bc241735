//! Alerts of a single report: what the report states, and what it leaves open.
//!
//! Transponders and ground stations do not send each alert in each report. A report without the item neither raises
//! nor clears the alert, so the raised bits alone are not enough.

use std::ops::BitOr;

use messages::alert_bits;

/// Statements of a report about the target's alerts; bits are those of [`messages::alert_bits`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Alerts {
    /// Alerts that the report raises.
    pub raised: u8,
    /// Alerts about which the report has an item: raised, or stated to be absent.
    pub stated: u8,
    /// Whether the report contains the text of an active resolution advisory (BDS register 3,0 or I021/260), and not
    /// only its bit.
    pub has_advisory: bool,
}

impl Alerts {
    /// The statement of a report about the alerts `stated`, of which `raised` are present.
    pub const fn of(stated: u8, raised: u8) -> Self {
        Self {
            raised,
            stated: stated | raised,
            has_advisory: false,
        }
    }

    /// The statement of a report's single flag for the alerts `bits`.
    pub const fn flag(bits: u8, is_set: bool) -> Self {
        Self::of(bits, if is_set { bits } else { 0 })
    }

    /// The statement of a report with a register of resolution advisories, `active` or past.
    pub const fn advisory(active: bool) -> Self {
        Self {
            has_advisory: active,
            ..Self::flag(alert_bits::RESOLUTION_ADVISORY, active)
        }
    }
}

impl BitOr for Alerts {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self {
            raised: self.raised | other.raised,
            stated: self.stated | other.stated,
            has_advisory: self.has_advisory || other.has_advisory,
        }
    }
}
