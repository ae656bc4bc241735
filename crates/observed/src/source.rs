//! Sources of a deployment, and their states.

use serde::Serialize;

use deployment::SourceFacts;
use messages::{Counter, CounterClass, Counters, NO_SOURCE, ProcessKind, Registration};

use crate::book::HealthBook;

/// State of a source.
#[derive(Clone, Debug, Default)]
pub struct SourceState {
    /// Number.
    pub number: u16,
    /// Name.
    pub name: String,
    /// Counters of the adapter for the source.
    pub adapter: Counters,
    /// Counters of fusion for the source.
    pub fusion: Counters,
    /// Reports taken by fusion per second in the last closed interval.
    pub taken_per_s: f64,
    /// Systematic errors.
    pub registration: Registration,
    /// Stages of the source's reports that took longer than their deadlines, as counted by the monitor.
    pub stages_late: u64,
}

impl SourceState {
    /// Returns the state of the source `number` called `name`; `adapter` are its adapter's counters.
    pub(crate) fn new(book: &HealthBook, number: u16, name: String, adapter: Counters) -> Self {
        let fusion = book.about(ProcessKind::Fusion, ProcessKind::Fusion.word(), number);
        let of_monitors = book
            .all()
            .filter(|(kind, source, _)| *kind == ProcessKind::Monitor && *source == number);
        Self {
            number,
            name,
            adapter,
            fusion: fusion.map_or_else(Counters::default, |fusion| fusion.counters()),
            taken_per_s: fusion.and_then(|fusion| fusion.per_s(Counter::Taken)).unwrap_or(0.0),
            registration: book.registration(number),
            // Several monitors count the same.
            stages_late: of_monitors
                .map(|(.., monitor)| monitor.counters()[Counter::StagesLate])
                .max()
                .unwrap_or(0),
        }
    }

    /// Returns the number of reports that fusion has taken.
    pub fn taken(&self) -> u64 {
        self.fusion[Counter::Taken]
    }

    /// Returns the number of reports that fusion has missed.
    pub fn lost(&self) -> u64 {
        self.fusion[Counter::Lost]
    }

    /// Returns the number of reports that the adapter has rejected.
    pub fn rejected(&self) -> u64 {
        self.adapter.sum_of(CounterClass::Rejection)
    }

    /// Returns the number of reports that fusion took and did not use.
    pub fn not_used(&self) -> u64 {
        self.fusion.sum_of(CounterClass::FusionRejection)
    }
}

/// Input of an adapter that was refused last.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RefusedInput {
    /// Name of the source, or of the process where the input is of no source.
    pub of: String,
    /// The refusals, one for each reason, the latest first; see [`Health::refusal`](messages::Health::refusal).
    pub text: String,
}

/// Samples delivered by a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Delivery {
    pub(crate) count: u64,
    /// Time of the message with the latest growth, monotonic, nanoseconds; `i64::MIN` before the first sample.
    pub(crate) grown_ns: i64,
}

impl Default for Delivery {
    fn default() -> Self {
        Self {
            count: 0,
            grown_ns: i64::MIN,
        }
    }
}

impl Delivery {
    /// Takes the count of a message of `time_ns`.
    pub(crate) fn take(&mut self, count: u64, time_ns: i64) {
        if count != self.count {
            (self.count, self.grown_ns) = (count, time_ns);
        }
    }
}

/// Returns the number of samples that a source has delivered: by its adapter; by fusion for a source without an
/// adapter.
pub(crate) fn delivered(book: &HealthBook, source: &SourceFacts) -> u64 {
    if source.is_external {
        return book.service(ProcessKind::Fusion, source.number)[Counter::Taken];
    }
    let adapter = book.adapter(&source.adapter, source.number);
    let delivers = [Counter::Records, Counter::Published, Counter::Detections];
    delivers.map(|counter| adapter[counter]).iter().sum()
}

/// Whether a message of the process (`kind`, `name`) about the source `number` may change the samples delivered by
/// `source`.
pub(crate) fn concerns(source: &SourceFacts, kind: ProcessKind, name: &str, number: u16) -> bool {
    match source.is_external {
        true => kind == ProcessKind::Fusion && number == source.number,
        false => kind == ProcessKind::Adapter && name == source.adapter && [source.number, NO_SOURCE].contains(&number),
    }
}
