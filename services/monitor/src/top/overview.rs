//! State of a deployment at the end of an interval.

use messages::Counter;
use telemetry::{Span, Stage, Summary};

use crate::report::{Picture, State};

/// Overview of a deployment.
#[derive(Clone, Debug)]
pub(crate) struct Overview {
    pub(crate) instance: String,
    /// Now, UTC, nanoseconds.
    pub(crate) utc_ns: i64,
    /// How long it has been looked at, nanoseconds.
    pub(crate) elapsed_ns: i64,
    /// Length of the interval, nanoseconds.
    pub(crate) interval_ns: i64,
    /// In the order of their numbers.
    pub(crate) sources: Vec<SourceRow>,
    pub(crate) picture: Picture,
    /// All sources together first, then each in the order of `sources`; of each, every stage that is measured.
    pub(crate) stages: Vec<StageRow>,
    /// Everything that is not 0.
    pub(crate) counters: Vec<CounterRow>,
    pub(crate) processes: Vec<ProcessRow>,
    /// Whether recordings are worked off as fast as fusion can: reports wait in full queues then.
    pub(crate) queues_are_full: bool,
    /// System-track states that were missed here: latencies rest on fewer.
    pub(crate) missed: u64,
}

/// One source.
#[derive(Clone, Debug, Default)]
pub(crate) struct SourceRow {
    pub(crate) number: u16,
    pub(crate) name: String,
    /// Reports that fusion has taken.
    pub(crate) taken: u64,
    /// How many per second.
    pub(crate) per_s: f64,
    /// Reports that the adapter has rejected.
    pub(crate) rejected: u64,
    /// Reports that fusion has missed.
    pub(crate) lost: u64,
    /// Reports that fusion took and did not use.
    pub(crate) not_used: u64,
    /// Stages that took longer than their deadlines, by the monitor's count.
    pub(crate) late: u64,
}

/// Latencies of one stage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StageRow {
    pub(crate) stage: Stage,
    /// `None`: all together.
    pub(crate) source: Option<u16>,
    pub(crate) interval: Summary,
    pub(crate) total: Summary,
}

impl StageRow {
    pub(crate) fn summary(&self, span: Span) -> Summary {
        match span {
            Span::Interval => self.interval,
            Span::Total => self.total,
        }
    }
}

/// One counter of one process.
#[derive(Clone, Debug)]
pub(crate) struct CounterRow {
    /// Process that counted.
    pub(crate) process: String,
    /// Source that it counted for; empty: all.
    pub(crate) source: String,
    pub(crate) counter: Counter,
    pub(crate) value: u64,
    /// How many per second.
    pub(crate) per_s: f64,
}

/// One process.
#[derive(Clone, Debug)]
pub(crate) struct ProcessRow {
    pub(crate) title: String,
    pub(crate) state: State,
    pub(crate) pid: Option<u32>,
    pub(crate) restarts: u32,
    /// How it last ended when it should not have, and what it has to say.
    pub(crate) note: String,
}

impl Overview {
    /// Latencies of one stage.
    pub(crate) fn stage(&self, stage: Stage, source: Option<u16>, span: Span) -> Summary {
        let found = self
            .stages
            .iter()
            .find(|row| row.stage == stage && row.source == source);
        found.map_or_else(Summary::default, |row| row.summary(span))
    }

    /// Name of a source.
    pub(crate) fn source_name(&self, number: u16) -> &str {
        let found = self.sources.iter().find(|source| source.number == number);
        found.map_or("others", |source| &source.name)
    }
}
