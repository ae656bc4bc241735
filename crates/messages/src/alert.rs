//! Alerts: events and dangers about targets. An alert is raised, in force, or cleared.
//!
//! An [`Alarm`](crate::Alarm) is about the system; an alert is about the targets that the system sees.

use crate::codes;
use crate::codes::bits;
use crate::health::{fill, text};
use crate::layout::sample;
use crate::{AlarmEvent, AlarmSeverity};

codes! {
    /// Kind of an alert.
    pub enum AlertKind: u8 {
        /// A target is in an area, or will be.
        Enter = 1, "enter";
        /// A target has left an area, or will leave it.
        Leave = 2, "leave";
        /// A target has been in an area for too long.
        Stay = 3, "stay";
        /// Two aircraft come nearer to each other than both minima.
        Conflict = 4, "conflict";
        /// Two vessels come close to each other.
        Approach = 5, "approach";
        /// A target is below a least height, or will be.
        Low = 6, "low";
        /// A target is too fast or too slow.
        Speed = 7, "speed";
        /// A target is outside of a band of heights.
        Level = 8, "level";
        /// A target is no longer reported.
        Lost = 9, "lost";
        /// A target states an emergency.
        Emergency = 10, "emergency";
    }
}

bits! {
    /// Bits of [`Alert::valid`].
    alert_value_bits: u16 {
        /// `time_to_s` and `probability` are of the future: the event has not happened yet.
        PREDICTED = 1;
        /// `distance_m` and `least_distance_m` hold distances.
        DISTANCE = 1 << 1;
        /// `vertical_m` and `least_vertical_m` hold differences of height.
        VERTICAL = 1 << 2;
        /// `value` and `limit` hold what is compared: metres per second, metres or seconds by the kind.
        VALUE = 1 << 3;
        /// An operator has acknowledged the alert.
        ACKNOWLEDGED = 1 << 4;
    }
}

/// Size of [`Alert::text`], bytes.
pub const ALERT_TEXT_MAX: usize = 160;

sample! {
    /// One alert. Every slice holds all alerts in force and all newly cleared ones.
    Alert, size 304 {
        /// Reference time of the state from which this statement follows, UTC, nanoseconds since 1970.
        time_ns: i64,
        /// Reference time of the state that raised the alert, UTC, nanoseconds since 1970.
        raised_ns: i64,
        /// The sample's sequence number at its publisher.
        sequence: u64,
        /// Number of the alert: 1, 2, … in the order of raising, across restarts of the process.
        number: u64,
        /// System-track numbers of the target, and of the other target; 0 for none.
        tracks: [u32; 2],
        /// Probability of the event in [0, 1]; 1 once it has happened.
        probability: f32,
        /// Time until the event, seconds; 0 once it has happened.
        time_to_s: f32,
        /// Present horizontal distance from the other target, or from the area's border, metres.
        distance_m: f32,
        /// Least horizontal distance ahead, metres.
        least_distance_m: f32,
        /// Present difference of height from the other target, metres.
        vertical_m: f32,
        /// Difference of height at the least distance, metres.
        least_vertical_m: f32,
        /// What is compared with `limit`: metres per second, metres or seconds by the kind.
        value: f32,
        /// The limit that `value` has passed.
        limit: f32,
        /// Values that are known: see `alert_value_bits`.
        valid: u16,
        /// An `AlertKind` code.
        kind: u8,
        /// An `AlarmEvent` code.
        event: u8,
        /// An `AlarmSeverity` code.
        severity: u8,
        /// Reserved, 0.
        reserved: [u8; 3],
        /// Name of the rule, UTF-8, padded with zeros.
        rule: [u8; 32],
        /// Name of the area, UTF-8, padded with zeros; empty for none.
        area: [u8; 32],
        /// One sentence, UTF-8, padded with zeros.
        text: [u8; 160] = [0; ALERT_TEXT_MAX],
    }
}

impl Alert {
    /// Returns the kind; `None` for a code of another schema.
    pub fn kind(&self) -> Option<AlertKind> {
        AlertKind::from_code(self.kind)
    }

    /// Returns the event; `None` for a code of another schema.
    pub fn event(&self) -> Option<AlarmEvent> {
        AlarmEvent::from_code(self.event)
    }

    /// Returns the severity; `None` for a code of another schema.
    pub fn severity(&self) -> Option<AlarmSeverity> {
        AlarmSeverity::from_code(self.severity)
    }

    /// Returns the name of the rule.
    pub fn rule(&self) -> &str {
        text(&self.rule)
    }

    /// Returns the name of the area; empty for none.
    pub fn area(&self) -> &str {
        text(&self.area)
    }

    /// Returns the sentence.
    pub fn text(&self) -> &str {
        text(&self.text)
    }

    /// Whether all of these [bits](alert_value_bits) are set.
    pub fn has(&self, bits: u16) -> bool {
        self.valid & bits == bits
    }

    /// Returns this alert with the names of its rule and area, and a sentence; each is cut to the available size.
    #[must_use]
    pub fn with_texts(mut self, rule: &str, area: &str, sentence: &str) -> Self {
        fill(&mut self.rule, rule);
        fill(&mut self.area, area);
        fill(&mut self.text, sentence);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_at_whole_characters() {
        let alert = Alert::default().with_texts("near", "Zürich", &"ü".repeat(100));
        assert_eq!((alert.rule(), alert.area()), ("near", "Zürich"));
        assert_eq!(alert.text(), "ü".repeat(ALERT_TEXT_MAX / 2));
    }
}
