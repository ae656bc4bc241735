//! Whom an alarm is about.

use messages::{Health, HealthName, NO_SOURCE};

/// Subject of an alarm: a source, two of them, a process, or the deployment as a whole (the default).
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
    /// The source of this number.
    pub fn source(source: u16) -> Self {
        Self {
            source,
            ..Self::default()
        }
    }

    /// Two sources, in whatever order.
    pub fn pair(one: u16, other: u16) -> Self {
        Self {
            source: one.min(other),
            partner: one.max(other),
            ..Self::default()
        }
    }

    /// The process of this name.
    pub fn process(name: &str) -> Self {
        Self {
            process: Health::default().with_name(name).name,
            ..Self::default()
        }
    }

    /// This subject, as far as the source of this number is concerned.
    #[must_use]
    pub fn of_source(self, source: u16) -> Self {
        Self { source, ..self }
    }
}
