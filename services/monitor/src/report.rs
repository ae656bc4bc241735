//! Final report: processes, arrivals, latencies, and quality of the picture.
//!
//! The same structure is printed for people (`report_text`) and written as JSON. All members are always present: a run
//! without data has zeros and empty lists, so that programs need no special cases. Only counters are left out where 0.

use std::collections::BTreeMap;

use alarms::AlarmHistory;
use messages::{Counters, ErrorModel, NO_SOURCE, Registration, registration_bits};
use observed::{ObservedProcess, RefusedInput, TrackCounts};
use scoring::AccuracyReport;
use serde::{Serialize, Serializer};
use telemetry::{Irregularities, Span, Stage, Stages, Summary};

/// Reason for a stage without figures.
pub(crate) const NOT_MEASURED: &str = "transport out is not measured: the monitor polls, to leave fusion in peace, so \
     end to end and age end where fusion has published; `koseki bench` or a monitor with wait = \"event\" measures it";

/// Report on a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Settings of the run.
    pub settings: RunSettings,
    /// Start of the monitor, UTC, nanoseconds.
    pub begun_utc_ns: i64,
    /// Length of the observation, seconds.
    pub duration_s: f64,
    /// Progress of fusion in a recording's time, UTC, nanoseconds.
    pub recording_reached_utc_ns: Option<i64>,
    /// Verdict.
    pub verdict: Verdict,
    /// Sources in the order of the configuration.
    pub sources: Vec<SourceReport>,
    /// Arrival of the samples.
    pub losses: Losses,
    /// Remark on a stage that is not measured, if any.
    pub latency_remark: Option<String>,
    /// Latencies of all sources together, by stage.
    #[serde(serialize_with = "by_key")]
    pub stages: Vec<(Stage, StageReport)>,
    /// System tracks.
    pub picture: TrackCounts,
    /// Comparison with the truth, if known.
    pub accuracy: Option<AccuracyReport>,
    /// Number of restarts.
    pub restarts: Restarts,
    /// Raised alarms, in the order of the registry.
    pub alarms: Vec<AlarmReport>,
    /// States of the processes at the end.
    pub processes: Vec<ObservedProcess>,
    /// Counters of fusion in total.
    #[serde(serialize_with = "crate::counters::serialize")]
    pub fusion: Counters,
    /// Counters of each other process (recorder, gateways, simulator, adapters) that belong to no source.
    pub others: Vec<ProcessCounters>,
    /// Counters of the monitor itself for the system tracks read.
    #[serde(serialize_with = "crate::counters::serialize")]
    pub monitor: Counters,
    /// Counters of the processes with a socket.
    pub network: Vec<ProcessCounters>,
    /// Input that adapters refused last.
    pub refused: Vec<RefusedInput>,
    /// Health messages with an unknown code or source.
    pub health_rejected: u64,
}

/// Verdict on a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// Whether nothing needs attention.
    pub fine: bool,
    /// A sentence: the first matter that needs attention, or the absence of such a matter.
    pub sentence: String,
}

/// Raised alarm.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AlarmReport {
    /// Word for the kind of the alarm.
    pub alarm: &'static str,
    /// Word for the severity.
    pub severity: &'static str,
    /// Source concerned; empty for none.
    pub source: String,
    /// Second source concerned; empty for none.
    pub partner: String,
    /// Process concerned; empty for none.
    pub process: String,
    /// Latest sentence.
    pub text: String,
    /// Remedy.
    pub remedy: &'static str,
    /// Number of times that the alarm was raised.
    pub times: u32,
    /// Time of the last raising, UTC, nanoseconds.
    pub raised_utc_ns: i64,
    /// Time of clearing, UTC, nanoseconds; `None` for a present alarm.
    pub cleared_utc_ns: Option<i64>,
}

impl AlarmReport {
    /// Creates the report on an alarm; `name` returns the name of a source.
    pub(crate) fn new(alarm: AlarmHistory, name: impl Fn(u16) -> String) -> Self {
        let (kind, subject) = (alarm.kind, alarm.subject);
        let name = |source| match source {
            NO_SOURCE => String::new(),
            source => name(source),
        };
        Self {
            alarm: kind.word(),
            severity: kind.severity().word(),
            source: name(subject.source),
            partner: name(subject.partner),
            process: messages::Alarm::default()
                .with_process(subject.process)
                .process()
                .to_owned(),
            text: alarm.text,
            remedy: kind.remedy(),
            times: alarm.times,
            raised_utc_ns: alarm.raised_ns,
            cleared_utc_ns: alarm.cleared_ns,
        }
    }
}

/// Counters of a process that belong to no source.
#[derive(Clone, Debug, Serialize)]
pub struct ProcessCounters {
    /// Process, as named in text.
    pub process: String,
    /// Values of the counters.
    #[serde(serialize_with = "crate::counters::serialize")]
    pub counters: Counters,
}

/// Settings of the run, for readers of the report.
#[derive(Clone, Debug, Serialize)]
pub struct RunSettings {
    /// Name of the deployment.
    pub deployment: String,
    /// Instance name.
    pub instance: String,
    /// Fusion rule.
    pub rule: String,
    /// Order in which fusion took reports: "arrival" or "time".
    pub order: &'static str,
    /// How fusion waited: "spin", "event" or "hybrid".
    pub wait: &'static str,
    /// How many sources are recordings.
    pub recorded_sources: usize,
    /// How many sources are simulated.
    pub simulated_sources: usize,
    /// How many sources are behind a receiver.
    pub live_sources: usize,
    /// Speed of recordings: a factor or "max"; `None` without recordings.
    pub speed: Option<String>,
    /// Whether latencies mean anything: not if a recording is replayed as fast as possible.
    pub latencies_measured: bool,
    /// Seed of the simulated world, if any.
    pub seed: Option<u64>,
    /// Targets of the simulated world, if any.
    pub targets: Option<u32>,
    /// Time between two tables, seconds.
    pub interval_s: f64,
    /// Time that a report may take through fusion, microseconds.
    pub deadline_us: f64,
    /// The monitor's way of waiting: "event", or "poll".
    pub monitor_wait: &'static str,
    /// Time between two looks of a monitor that polls, milliseconds.
    pub monitor_poll_ms: Option<f64>,
}

/// A source.
#[derive(Clone, Debug, Serialize)]
pub struct SourceReport {
    /// Number of the source.
    pub number: u16,
    /// Name of the source.
    pub name: String,
    /// Number of the tracker that takes this source's detections, if the source is a tracker's sensor: then fusion
    /// takes none of the source's samples.
    pub sensor_of: Option<u16>,
    /// Counters of the source's adapter.
    #[serde(serialize_with = "crate::counters::serialize")]
    pub adapter: Counters,
    /// Counters of fusion for the source's reports.
    #[serde(serialize_with = "crate::counters::serialize")]
    pub fusion: Counters,
    /// Counters of the recorder for the source's reports.
    #[serde(serialize_with = "crate::counters::serialize")]
    pub recorder: Counters,
    /// Systematic errors, as estimated by fusion.
    #[serde(serialize_with = "as_learned")]
    pub registration: Registration,
    /// Time between two scans, as measured by the adapter, seconds; `None` if not measured.
    pub scan_period_s: Option<f64>,
    /// States of system tracks that a report of the source led to and the monitor saw.
    pub states: u64,
    /// States among these to which another source contributes, too.
    pub joint_states: u64,
    /// Latencies of the source's reports, by stage.
    #[serde(serialize_with = "by_key")]
    pub stages: Vec<(Stage, SourceStageReport)>,
}

/// Latencies of a stage, for the reports of a source.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct SourceStageReport {
    /// The latencies.
    #[serde(flatten)]
    pub summary: Summary,
    /// Number of times the stage exceeded the deadline.
    pub deadline_misses: u64,
}

/// [`Registration`] as written: words for the codes and bits, nothing for unknown values.
#[derive(Serialize)]
struct LearnedErrors {
    /// The whole in a single sentence.
    text: String,
    comparisons: f64,
    offset_m: [f64; 3],
    offset_sigma_m: [f64; 3],
    time_offset_s: f64,
    time_offset_sigma_s: f64,
    range_bias_m: f64,
    range_bias_sigma_m: f64,
    azimuth_bias_rad: f64,
    azimuth_bias_sigma_rad: f64,
    covariance_inflation: f64,
    removed: Vec<&'static str>,
    gross_error: Option<GrossErrorReport>,
    clock_offset_s: Option<f64>,
    clock_offset_sigma_s: Option<f64>,
    error_model: &'static str,
    /// Numbers of sources with dependent errors, and the correlations.
    depends_on: Vec<(u16, f32)>,
    target_share: Option<f32>,
    detection_probability: Option<f32>,
    lateness_s: f32,
    /// Step of coarse time stamps, and the standard deviation of the time offset, seconds.
    stamps_s: Option<[f32; 2]>,
    /// Standard deviations of a smoothed source's measurements, along, across and in height, metres.
    measured_sigma_m: Option<[f32; 3]>,
}

/// [`Bias`](messages::Bias) with a word for the kind.
#[derive(Serialize)]
struct GrossErrorReport {
    kind: &'static str,
    value: [f64; 2],
    partner: u16,
    is_certain: bool,
    is_removed: bool,
}

impl LearnedErrors {
    fn of(known: &Registration) -> Self {
        let words = [
            (registration_bits::EAST, "east"),
            (registration_bits::NORTH, "north"),
            (registration_bits::UP, "up"),
            (registration_bits::TIME, "time"),
            (registration_bits::RANGE, "range"),
            (registration_bits::AZIMUTH, "azimuth"),
        ];
        let removed = words.into_iter().filter(|(bit, _)| known.removed & bit != 0);
        let has_clock = known.clock_offset_sigma_s > 0.0;
        let model = u8::try_from(known.error_model).ok().and_then(ErrorModel::from_code);
        let dependent = known.dependent_sources.into_iter().zip(known.dependence);
        let learned = |value: f32| Some(value).filter(|value| *value > 0.0);
        Self {
            text: known.to_string(),
            comparisons: known.comparisons,
            offset_m: known.offset_m,
            offset_sigma_m: known.offset_sigma_m,
            time_offset_s: known.time_offset_s,
            time_offset_sigma_s: known.time_offset_sigma_s,
            range_bias_m: known.range_bias_m,
            range_bias_sigma_m: known.range_bias_sigma_m,
            azimuth_bias_rad: known.azimuth_bias_rad,
            azimuth_bias_sigma_rad: known.azimuth_bias_sigma_rad,
            covariance_inflation: known.covariance_inflation,
            removed: removed.map(|(_, word)| word).collect(),
            gross_error: known.gross_error().map(|error| GrossErrorReport {
                kind: error.kind.word(),
                value: error.value,
                partner: error.partner,
                is_certain: error.is_certain,
                is_removed: error.is_removed,
            }),
            clock_offset_s: has_clock.then_some(known.clock_offset_s),
            clock_offset_sigma_s: has_clock.then_some(known.clock_offset_sigma_s),
            error_model: model.unwrap_or(ErrorModel::Undecided).word(),
            depends_on: dependent.filter(|(_, correlation)| *correlation > 0.0).collect(),
            target_share: learned(known.target_share),
            detection_probability: learned(known.detection_probability),
            lateness_s: known.lateness_s,
            stamps_s: learned(known.stamp_step_s).map(|step_s| [step_s, known.stamp_sigma_s]),
            measured_sigma_m: learned(known.long_sigma_m)
                .map(|long_m| [long_m, known.short_sigma_m, known.height_sigma_m]),
        }
    }
}

fn as_learned<S: Serializer>(known: &Registration, serializer: S) -> Result<S::Ok, S::Error> {
    LearnedErrors::of(known).serialize(serializer)
}

/// Latencies of a stage, and stamps that are no latencies.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct StageReport {
    /// The latencies.
    #[serde(flatten)]
    pub summary: Summary,
    /// Reports that lack a stamp.
    pub missing: u64,
    /// Reports with a stage that ended before its begin.
    pub negative: u64,
    /// Reports with a stage of more than ten minutes.
    pub too_long: u64,
    /// Whether the stage was measured: a polling monitor cannot measure stages after fusion.
    pub measured: bool,
    /// Deadline of the stage, microseconds, if configured.
    pub deadline_us: Option<f64>,
    /// Number of exceeded deadlines, among the states that the monitor saw.
    pub deadline_misses: u64,
}

impl StageReport {
    /// Latencies of all sources together, since the beginning.
    pub(crate) fn new(stages: &Stages, stage: Stage) -> Self {
        let Irregularities {
            missing,
            negative,
            too_long,
        } = stages.irregularities(stage);
        let journey = stages.journey();
        Self {
            summary: stages.summary(stage, None, Span::Total),
            missing,
            negative,
            too_long,
            measured: stage.is_measured(journey.end),
            deadline_us: journey.deadlines.get(stage).map(|deadline_ns| deadline_ns as f64 / 1e3),
            deadline_misses: stages.deadline_misses(stage, None, Span::Total),
        }
    }

    /// The latencies, if measured.
    pub(crate) fn latencies(&self) -> Option<Summary> {
        self.measured.then_some(self.summary)
    }
}

/// Whether every sample arrived.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Losses {
    /// Whether the monitor has watched from the start. After a restart, counts of processes restarted earlier are
    /// unknown, and appear as unread.
    pub complete: bool,
    /// Reports lost on the way from the adapters to fusion.
    pub reports_lost: u64,
    /// Reports published in the absence of fusion.
    pub reports_unread: u64,
    /// Each way from a publisher to a reader.
    pub hops: Vec<Hop>,
    /// System-track states that only the monitor missed: the monitor's figures rest on fewer samples, nothing else is
    /// affected.
    pub monitor_missed: u64,
}

/// A way from a publisher to a reader, in samples.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Hop {
    /// Name of the publishing process.
    pub from: String,
    /// Name of the reading process.
    pub to: String,
    /// By the publisher's own count.
    pub published: u64,
    /// By the reader's own count.
    pub taken: u64,
    /// Missing from the sequence that the reader saw: the reader fell behind.
    pub lost: u64,
    /// Published, and neither taken nor missed: the reader was not there.
    pub unread: u64,
}

impl Hop {
    pub(crate) fn new(from: &str, to: &str, published: u64, taken: u64, lost: u64) -> Self {
        Self {
            from: from.to_owned(),
            to: to.to_owned(),
            published,
            taken,
            lost,
            // 0 instead of a negative number if the publisher was killed before stating its last count.
            unread: published.saturating_sub(taken + lost),
        }
    }
}

/// How often processes were started again.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Restarts {
    /// All together.
    pub total: u64,
    /// By process, the restarted processes.
    pub by_process: BTreeMap<String, u32>,
}

/// An object with a member per stage, in the order of the journey.
fn by_key<T: Serialize, S: Serializer>(stages: &[(Stage, T)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(stages.iter().map(|(stage, figures)| (stage.key(), figures)))
}
