//! Alarms: conditions that need attention. An alarm is raised, standing, or cleared.

use crate::codes;
use crate::health::{HealthName, NO_SOURCE, fill, text};
use crate::layout::sample;

codes! {
    /// Severity of an alarm, as in ITU-T X.733.
    pub enum AlarmSeverity: u8, default Warning {
        /// Nothing is wrong yet; it may become so.
        Warning = 1, "warning";
        /// Part of the picture is missing or wrong.
        Major = 2, "major";
        /// The picture as a whole is not to be relied on.
        Critical = 3, "critical";
    }
}

codes! {
    /// Event stated by an alarm's sample.
    pub enum AlarmEvent: u8, default Standing {
        /// The alarm has just been raised.
        Raised = 1, "raised";
        /// The alarm was raised before, and stands.
        Standing = 2, "standing";
        /// The alarm has just been cleared.
        Cleared = 3, "cleared";
    }
}

/// Size of [`Alarm::text`], bytes.
pub const ALARM_TEXT_MAX: usize = 312;

sample! {
    /// One alarm. Every slice holds all standing alarms and all newly cleared alarms.
    Alarm, size 384 {
        /// Time of this statement, UTC, nanoseconds since 1970.
        time_ns: i64,
        /// When the alarm was raised, UTC, nanoseconds since 1970.
        raised_ns: i64,
        /// The sample's sequence number at its publisher.
        sequence: u64,
        /// Times that the alarm has been raised since its publisher started.
        times: u32,
        /// Code of the alarm; docs/alarms.md lists them.
        code: u16,
        /// Source concerned: its number in the configuration; 65535 for none.
        source: u16 = NO_SOURCE,
        /// Second source concerned; 65535 for none.
        partner: u16 = NO_SOURCE,
        /// An `AlarmSeverity` code.
        severity: u8,
        /// An `AlarmEvent` code.
        event: u8,
        /// Reserved, 0.
        reserved: u32,
        /// Name of the process concerned, UTF-8, padded with zeros; empty for none.
        process: [u8; 32],
        /// One sentence, UTF-8, padded with zeros.
        text: [u8; 312] = [0; ALARM_TEXT_MAX],
    }
}

impl Alarm {
    /// Returns the sentence.
    pub fn text(&self) -> &str {
        text(&self.text)
    }

    /// Returns this alarm with another sentence, cut to the available size.
    #[must_use]
    pub fn with_text(mut self, sentence: &str) -> Self {
        fill(&mut self.text, sentence);
        self
    }

    /// Returns the name of the process concerned; empty for none.
    pub fn process(&self) -> &str {
        text(&self.process)
    }

    /// Returns this alarm for another process.
    #[must_use]
    pub fn with_process(mut self, process: HealthName) -> Self {
        self.process = process;
        self
    }

    /// Returns the severity; `None` for a code of another schema.
    pub fn severity(&self) -> Option<AlarmSeverity> {
        AlarmSeverity::from_code(self.severity)
    }

    /// Returns the event; `None` for a code of another schema.
    pub fn event(&self) -> Option<AlarmEvent> {
        AlarmEvent::from_code(self.event)
    }
}
