//! Subject of an alarm.

use messages::{Health, HealthName, NO_SOURCE};

/// Subject of an alarm: a source, a pair of sources, a process, or the deployment as a whole (the default).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Subject {
    /// Number of the source; [`NO_SOURCE`] for none.
    pub source: u16,
    /// Number of the second source; [`NO_SOURCE`] for none.
    pub partner: u16,
    /// Name of the process; empty for none.
    pub process: HealthName,
}

impl Default for Subject {
    fn default() -> Self {
        Self {
            source: NO_SOURCE,
            partner: NO_SOURCE,
            process: [0; 32],
        }
    }
}

impl Subject {
    /// Creates the subject of a source.
    pub fn source(source: u16) -> Self {
        Self {
            source,
            ..Self::default()
        }
    }

    /// Creates the subject of two sources, in any order.
    pub fn pair(one: u16, other: u16) -> Self {
        Self {
            source: one.min(other),
            partner: one.max(other),
            ..Self::default()
        }
    }

    /// Creates the subject of a process.
    pub fn process(name: &str) -> Self {
        Self {
            process: Health::default().with_name(name).name,
            ..Self::default()
        }
    }

    /// Returns this subject with the source of this number.
    #[must_use]
    pub fn of_source(self, source: u16) -> Self {
        Self { source, ..self }
    }
}
