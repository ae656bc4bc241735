//! State of a deployment at the end of an interval.

use messages::{Alarm, Counter};
use observed::{Deployment, ObservedProcess, ProcessState, SourceState, StandingAlarm, TrackCounts};
use serde::{Serialize, Serializer};
use telemetry::{Span, Stage, Stages, Summary};

use super::tracks::TrackRow;

/// Overview of a deployment.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Overview {
    pub(crate) instance: String,
    /// Address of the picture for a browser; `None` without a display.
    pub(crate) page: Option<String>,
    /// Now, UTC, nanoseconds.
    pub(crate) utc_ns: i64,
    /// Length of the observation so far, nanoseconds.
    pub(crate) elapsed_ns: i64,
    /// Length of the interval, nanoseconds.
    pub(crate) interval_ns: i64,
    /// How far fusion has got in the recordings' time, UTC, nanoseconds; `None` without recordings, or if unknown.
    pub(crate) recording_ns: Option<i64>,
    /// In the order of the numbers.
    pub(crate) sources: Vec<SourceRow>,
    pub(crate) picture: TrackCounts,
    /// Live tracks, in the order of the numbers; none where not requested.
    pub(crate) tracks: Vec<TrackRow>,
    /// All sources together first, then each in the order of `sources`; of each, every stage that is measured.
    pub(crate) stages: Vec<StageRow>,
    /// Everything that is not 0.
    pub(crate) counters: Vec<CounterRow>,
    pub(crate) processes: Vec<ProcessRow>,
    /// Alarms that stand, the worst first.
    pub(crate) alarms: Vec<StandingAlarm>,
    /// Whether recordings are worked off as fast as fusion can: reports wait in full queues then.
    pub(crate) queues_are_full: bool,
    /// System-track states that were missed here: latencies rest on fewer.
    pub(crate) missed: u64,
}

/// A source.
#[derive(Clone, Debug, Default, Serialize)]
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
    /// Stages that took longer than the deadlines, by the monitor's count.
    pub(crate) late: u64,
}

/// Latencies of a stage.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct StageRow {
    #[serde(serialize_with = "key")]
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

/// A counter of a process.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CounterRow {
    /// Process that counted.
    pub(crate) process: String,
    /// Counted source; empty: all.
    pub(crate) source: String,
    #[serde(serialize_with = "label")]
    pub(crate) counter: Counter,
    pub(crate) value: u64,
    /// How many per second.
    pub(crate) per_s: f64,
}

/// A process.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ProcessRow {
    pub(crate) title: String,
    pub(crate) state: ProcessState,
    pub(crate) pid: Option<u32>,
    pub(crate) restarts: u32,
    /// The last unexpected end, and the process's own note.
    pub(crate) note: String,
}

impl From<&SourceState> for SourceRow {
    fn from(source: &SourceState) -> Self {
        Self {
            number: source.number,
            name: source.name.clone(),
            taken: source.taken(),
            per_s: source.taken_per_s,
            rejected: source.rejected(),
            lost: source.lost(),
            not_used: source.not_used(),
            late: source.stages_late,
        }
    }
}

impl Overview {
    /// Overview of the last closed interval, with the stages that are `measured`. The caller adds times and facts.
    pub(crate) fn new(
        observed: &Deployment,
        processes: &[ObservedProcess],
        alarms: &[Alarm],
        measured: impl Fn(Stage) -> bool,
    ) -> Self {
        let sources: Vec<SourceRow> = observed.sources().iter().map(SourceRow::from).collect();
        Self {
            picture: observed.track_counts(),
            stages: stage_rows(observed.stages(), &sources, measured),
            processes: processes.iter().map(ProcessRow::new).collect(),
            alarms: alarms.iter().map(StandingAlarm::from).collect(),
            sources,
            ..Self::default()
        }
    }

    /// Latencies of a stage.
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

impl ProcessRow {
    /// Row of an observed process.
    pub(crate) fn new(process: &ObservedProcess) -> Self {
        Self {
            title: process.title(),
            state: process.state,
            pid: process.pid,
            restarts: process.restarts,
            note: process.remark(),
        }
    }
}

/// Rows of every stage that is `measured`: of all sources together, of each of `sources`, and of others that were seen.
fn stage_rows(stages: &Stages, sources: &[SourceRow], measured: impl Fn(Stage) -> bool) -> Vec<StageRow> {
    let numbers = sources.iter().map(|source| Some(source.number));
    let others = stages.sources().filter(|number| *number == telemetry::OTHER_SOURCES);
    let of = [None].into_iter().chain(numbers).chain(others.map(Some));
    let rows = of.flat_map(|source| Stage::ALL.map(|stage| (stage, source)));
    rows.filter(|(stage, _)| stage.is_measured(stages.journey().end) && measured(*stage))
        .map(|(stage, source)| StageRow {
            stage,
            source,
            interval: stages.summary(stage, source, Span::Interval),
            total: stages.summary(stage, source, Span::Total),
        })
        .collect()
}

fn key<S: Serializer>(stage: &Stage, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(stage.key())
}

fn label<S: Serializer>(counter: &Counter, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(counter.label())
}
