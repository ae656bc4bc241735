//! Metrics in the OpenMetrics text format, for Prometheus.
//!
//! Latencies are histograms, not summaries. Quantiles of each process cannot be combined over sources, instances or
//! times; counts in common buckets can (`histogram_quantile`).
//!
//! All names begin with `koseki_`. Every counter of `messages::Counter` is a separate family, with the counter's
//! sentence as help text. The label `source` is empty for counts of no source, so that sums contain every count once.

use std::fmt;

use messages::{Counter, CounterClass, Counters, LifeState, ProcessKind, Registration};
use observed::{ObservedProcess, ProcessState, TrackCounts};
use prometheus_client::collector::Collector;
use prometheus_client::encoding::text::encode;
use prometheus_client::encoding::{DescriptorEncoder, EncodeLabelSet, NoLabelSet};
use prometheus_client::metrics::MetricType;
use prometheus_client::registry::{Registry, Unit};
use telemetry::{BUCKET_BOUNDS_NS, Buckets, Irregularities, Stage};

use crate::report::{AlarmReport, RunSettings};

/// Media type of the metrics.
pub(crate) const CONTENT_TYPE: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

const NS_PER_S: f64 = 1e9;

/// State of the deployment at the end of an interval.
#[derive(Clone, Debug)]
pub(crate) struct MetricsSnapshot {
    pub(crate) settings: RunSettings,
    pub(crate) stages: Vec<StageSample>,
    pub(crate) deadlines: Vec<(Stage, u64)>,
    pub(crate) irregularities: Vec<(Stage, Irregularities)>,
    pub(crate) counted: Vec<ProcessCounts>,
    pub(crate) picture: TrackCounts,
    pub(crate) processes: Vec<ObservedProcess>,
    pub(crate) alarms: Vec<AlarmReport>,
    /// Systematic errors, by the names of the sources.
    pub(crate) registrations: Vec<(String, Registration)>,
    pub(crate) monitor_missed: u64,
    pub(crate) health_rejected: u64,
}

/// Latencies of a stage, for the reports of a source.
#[derive(Clone, Debug)]
pub(crate) struct StageSample {
    pub(crate) stage: Stage,
    pub(crate) source: String,
    pub(crate) buckets: Buckets,
    /// Number of missed deadlines of the stage, if the stage has a deadline.
    pub(crate) late: Option<u64>,
}

/// Counts of a process for a source; with an empty source, for none.
#[derive(Clone, Debug)]
pub(crate) struct ProcessCounts {
    pub(crate) kind: ProcessKind,
    pub(crate) process: String,
    pub(crate) source: String,
    pub(crate) counters: Counters,
}

impl MetricsSnapshot {
    /// Returns the text.
    pub(crate) fn text(self) -> String {
        let mut registry = Registry::with_prefix("koseki");
        registry.register_collector(Box::new(self));
        let mut text = String::new();
        // Writing to a string fails only with an encoder, and no encoder here fails.
        let _ = encode(&mut text, &registry);
        text
    }
}

impl Collector for MetricsSnapshot {
    fn encode(&self, encoder: DescriptorEncoder<'_>) -> fmt::Result {
        let mut families = Families(encoder);
        self.deployment(&mut families)?;
        self.latencies(&mut families)?;
        self.late(&mut families)?;
        self.counters(&mut families)?;
        self.tracks(&mut families)?;
        self.processes(&mut families)?;
        self.alarms(&mut families)?;
        self.registrations(&mut families)?;
        families.counter(
            "monitor_missed_states",
            "System-track states that only the monitor missed: its figures rest on fewer",
            self.monitor_missed,
        )?;
        families.counter(
            "health_rejected",
            "Health messages that could not be understood",
            self.health_rejected,
        )
    }
}

impl MetricsSnapshot {
    fn deployment(&self, families: &mut Families<'_>) -> fmt::Result {
        let settings = &self.settings;
        let labels = [
            ("deployment", settings.deployment.as_str()),
            ("run_as", &settings.instance),
            ("rule", &settings.rule),
            ("order", settings.order),
            ("wait", settings.wait),
            ("monitor_wait", settings.monitor_wait),
        ];
        families.gauges("deployment", "What is run, in its labels", None, [(labels, 1.0)])
    }

    fn latencies(&self, families: &mut Families<'_>) -> fmt::Result {
        let help = "Time that a stage took, of states that a report of the source caused; age: since the measurement";
        let unit = Unit::Seconds;
        let mut family = families
            .0
            .encode_descriptor("stage_latency", help, Some(&unit), MetricType::Histogram)?;
        let bounds_s = BUCKET_BOUNDS_NS.iter().map(|bound_ns| *bound_ns as f64 / NS_PER_S);
        let bounds_s: Vec<f64> = bounds_s.chain([f64::INFINITY]).collect();
        for sample in &self.stages {
            let counts = sample.buckets.counts;
            let buckets: Vec<(f64, u64)> = bounds_s.iter().copied().zip(counts).collect();
            let labels = [("stage", sample.stage.key()), ("source", &sample.source)];
            family.encode_family(&labels)?.encode_histogram::<NoLabelSet>(
                sample.buckets.sum_ns / NS_PER_S,
                counts.iter().sum(),
                &buckets,
                None,
            )?;
        }
        Ok(())
    }

    fn late(&self, families: &mut Families<'_>) -> fmt::Result {
        let deadlines = self.deadlines.iter();
        families.gauges(
            "stage_deadline",
            "How long a stage may take",
            Some(Unit::Seconds),
            deadlines.map(|(stage, deadline_ns)| ([("stage", stage.key())], *deadline_ns as f64 / NS_PER_S)),
        )?;
        let late = self.stages.iter().filter_map(|sample| {
            let labels = [("stage", sample.stage.key()), ("source", sample.source.as_str())];
            Some((labels, sample.late?))
        });
        families.counters("stage_late", "Times a stage took longer than its deadline", late)?;
        let irregular = self.irregularities.iter().flat_map(|(stage, counts)| {
            let reasons = [
                ("missing", counts.missing),
                ("negative", counts.negative),
                ("too_long", counts.too_long),
            ];
            reasons.map(|(reason, count)| ([("stage", stage.key()), ("reason", reason)], count))
        });
        let help = "Stamps that are no latency: missing, before their predecessors, or more than ten minutes after";
        families.counters("stage_stamps_rejected", help, irregular)
    }

    fn counters(&self, families: &mut Families<'_>) -> fmt::Result {
        for counter in Counter::ALL
            .iter()
            .filter(|counter| counter.class() != CounterClass::Level)
        {
            let samples = self.counted.iter().filter_map(|counted| {
                let value = counted.counters[*counter];
                let labels = [
                    ("kind", counted.kind.word()),
                    ("process", counted.process.as_str()),
                    ("source", counted.source.as_str()),
                ];
                let expected = counter.counted_by().contains(&counted.kind)
                    && (counted.source.is_empty() || !counter.is_of_process());
                (value > 0 || expected).then_some((labels, value))
            });
            families.counters(counter.label(), counter.sentence(), samples)?;
        }
        Ok(())
    }

    fn tracks(&self, families: &mut Families<'_>) -> fmt::Result {
        let picture = &self.picture;
        let states = [
            ("confirmed", picture.confirmed),
            ("coasted", picture.coasted),
            ("tentative", picture.tentative),
            ("suspended", picture.suspended),
        ];
        families.gauges(
            "system_tracks",
            "System tracks now, by state",
            None,
            states.map(|(state, count)| ([("state", state)], count as f64)),
        )
    }

    fn processes(&self, families: &mut Families<'_>) -> fmt::Result {
        let labels = |process: &'_ ObservedProcess| {
            [
                ("kind", process.kind.map_or("", ProcessKind::word).to_owned()),
                ("process", process.name.clone()),
            ]
        };
        let is_up = |state| matches!(state, ProcessState::Life(LifeState::Starting | LifeState::Running));
        families.gauges(
            "process_up",
            "1 while a process runs and is heard from",
            None,
            self.processes
                .iter()
                .map(|process| (labels(process), f64::from(u8::from(is_up(process.state))))),
        )?;
        families.counters(
            "process_restarts",
            "Times a process was started again",
            self.processes
                .iter()
                .map(|process| (labels(process), u64::from(process.restarts))),
        )
    }
}

impl MetricsSnapshot {
    fn alarms(&self, families: &mut Families<'_>) -> fmt::Result {
        let labels = |alarm: &'_ AlarmReport| {
            [
                ("alarm", alarm.alarm.to_owned()),
                ("severity", alarm.severity.to_owned()),
                ("source", alarm.source.clone()),
                ("partner", alarm.partner.clone()),
                ("process", alarm.process.clone()),
            ]
        };
        families.gauges(
            "alarm",
            "1 while an alarm stands, 0 once it was cleared",
            None,
            self.alarms
                .iter()
                .map(|alarm| (labels(alarm), f64::from(u8::from(alarm.cleared_utc_ns.is_none())))),
        )?;
        families.counters(
            "alarms_raised",
            "Times an alarm was raised",
            self.alarms.iter().map(|alarm| (labels(alarm), u64::from(alarm.times))),
        )
    }

    /// Writes estimates of the sources' errors; unknown estimates are left out.
    fn registrations(&self, families: &mut Families<'_>) -> fmt::Result {
        let estimates = self.registrations.iter().flat_map(|(source, known)| {
            let [east, north, up] = known.offset_m;
            let [east_sigma, north_sigma, up_sigma] = known.offset_sigma_m;
            let compared = known.comparisons > 0.0;
            [
                ("offset_east_m", east, east_sigma, compared),
                ("offset_north_m", north, north_sigma, compared),
                ("offset_up_m", up, up_sigma, compared),
                (
                    "time_offset_s",
                    known.time_offset_s,
                    known.time_offset_sigma_s,
                    compared,
                ),
                ("range_bias_m", known.range_bias_m, known.range_bias_sigma_m, compared),
                (
                    "azimuth_bias_rad",
                    known.azimuth_bias_rad,
                    known.azimuth_bias_sigma_rad,
                    compared,
                ),
                (
                    "clock_offset_s",
                    known.clock_offset_s,
                    known.clock_offset_sigma_s,
                    known.clock_offset_sigma_s > 0.0,
                ),
            ]
            .into_iter()
            .filter(|(.., is_known)| *is_known)
            .map(move |(error, value, sigma, _)| ([("source", source.as_str()), ("error", error)], value, sigma))
        });
        let estimates: Vec<_> = estimates.collect();
        families.gauges(
            "source_error",
            "Estimated systematic error of a source, in the unit at the end of the error's name",
            None,
            estimates.iter().map(|(labels, value, _)| (*labels, *value)),
        )?;
        families.gauges(
            "source_error_sigma",
            "Standard deviation of that estimate, in the same unit",
            None,
            estimates.iter().map(|(labels, _, sigma)| (*labels, *sigma)),
        )?;
        families.gauges(
            "source_covariance_inflation",
            "Factor by which a source's covariances are enlarged, since they claim too much",
            Some(Unit::Other("ratio".to_owned())),
            self.registrations
                .iter()
                .map(|(source, known)| ([("source", source.as_str())], known.covariance_inflation)),
        )
    }
}

/// Writer of complete families.
struct Families<'a>(DescriptorEncoder<'a>);

impl Families<'_> {
    fn counters<L: EncodeLabelSet>(
        &mut self,
        name: &str,
        help: &str,
        samples: impl IntoIterator<Item = (L, u64)>,
    ) -> fmt::Result {
        let mut family = self.0.encode_descriptor(name, help, None, MetricType::Counter)?;
        for (labels, value) in samples {
            family
                .encode_family(&labels)?
                .encode_counter::<NoLabelSet, u64, f64>(&value, None)?;
        }
        Ok(())
    }

    fn counter(&mut self, name: &str, help: &str, value: u64) -> fmt::Result {
        let mut family = self.0.encode_descriptor(name, help, None, MetricType::Counter)?;
        family.encode_counter::<NoLabelSet, u64, f64>(&value, None)
    }

    fn gauges<L: EncodeLabelSet>(
        &mut self,
        name: &str,
        help: &str,
        unit: Option<Unit>,
        samples: impl IntoIterator<Item = (L, f64)>,
    ) -> fmt::Result {
        let mut family = self.0.encode_descriptor(name, help, unit.as_ref(), MetricType::Gauge)?;
        for (labels, value) in samples {
            family.encode_family(&labels)?.encode_gauge(&value)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden;
    use crate::report_text::tests::good;

    fn counted(kind: ProcessKind, process: &str, source: &str, counters: Counters) -> ProcessCounts {
        ProcessCounts {
            kind,
            process: process.to_owned(),
            source: source.to_owned(),
            counters,
        }
    }

    #[test]
    fn the_text_is_as_the_format_has_it() {
        let report = good();
        let mut buckets = Buckets::default();
        (buckets.counts[4], buckets.counts[6], buckets.sum_ns) = (19_000, 1_000, 1e9);
        let sample = |stage, source: &str, late| StageSample {
            stage,
            source: source.to_owned(),
            buckets,
            late,
        };
        let snapshot = MetricsSnapshot {
            settings: report.settings,
            stages: vec![
                sample(Stage::TakenToFused, "radar \"west\"", Some(3)),
                sample(Stage::EndToEnd, "ads-b", None),
            ],
            deadlines: vec![(Stage::TakenToFused, 1_000_000)],
            irregularities: vec![(
                Stage::Age,
                Irregularities {
                    missing: 1,
                    negative: 2,
                    too_long: 3,
                },
            )],
            counted: vec![
                counted(ProcessKind::Adapter, "ads-b", "ads-b", report.sources[1].adapter),
                counted(ProcessKind::Fusion, "fusion", "", report.fusion),
                counted(ProcessKind::Fusion, "fusion", "ads-b", report.sources[1].fusion),
            ],
            picture: report.picture,
            processes: report.processes,
            alarms: vec![AlarmReport {
                alarm: "never-joined",
                severity: "warning",
                source: "radar \"west\"".to_owned(),
                partner: "ads-b".to_owned(),
                process: String::new(),
                text: "A sentence.".to_owned(),
                remedy: "Advice.",
                times: 2,
                raised_utc_ns: 1,
                cleared_utc_ns: None,
            }],
            registrations: vec![
                ("radar \"west\"".to_owned(), Registration::default()),
                (
                    "ads-b".to_owned(),
                    Registration {
                        comparisons: 900.0,
                        offset_m: [1.5, -2.5, 0.0],
                        offset_sigma_m: [0.5; 3],
                        covariance_inflation: 1.5,
                        clock_offset_s: 0.25,
                        clock_offset_sigma_s: 0.125,
                        ..Registration::default()
                    },
                ),
            ],
            monitor_missed: 4,
            health_rejected: 5,
        };
        golden::assert("metrics.txt", &snapshot.text());
    }
}
