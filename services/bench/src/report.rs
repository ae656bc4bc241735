//! Report of a measurement: for a JSON file (FM-4), and for the comparison of two measurements.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context as _;
use serde::{Deserialize, Serialize};
use telemetry::table::count;

use crate::engine_time::EngineTimes;
use crate::figures::Figures;
use crate::machine::MachineFacts;
use crate::measure::{FusionCounts, WarmUp};
use crate::memory::ProcessMemory;
use crate::settings::Settings;
use crate::verdict::FigureVerdict;

/// Share of the engine's updates that chance may make odd: with 16 sources, 6 of 98,000 have been. A part of the
/// reports that is rejected is larger.
const ODD_SHARE_MAX: f64 = 1e-3;

/// Contents of the file. The top-level figures are those of the first rate; `points` has all rates.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BenchReport {
    /// Command of the measurement: latency, throughput, engine, floor.
    pub command: String,
    /// Measuring machine.
    pub machine: MachineFacts,
    /// Settings of the measurement.
    pub settings: Option<Settings>,
    /// Latency of the bare relay: medians over the runs.
    pub floor: Figures,
    /// Latency of the pipeline: medians over the runs.
    pub pipeline: Figures,
    /// The pipeline's stages: medians over the runs.
    pub stages: BTreeMap<String, Figures>,
    /// Highest rate without loss after a search, else the received rate, reports per second.
    pub throughput_per_s: f64,
    /// Time per update of the engine alone, nanoseconds; 0 if not measured.
    pub engine_ns_per_update: f64,
    /// Detailed figures of the engine alone.
    pub engine: EngineTimes,
    /// Round trips through more and more layers; empty unless measured.
    #[serde(default)]
    pub layers: Vec<LayerFigures>,
    /// Jitter of the machine.
    pub jitter: JitterFigures,
    /// Figures at each rate.
    pub points: Vec<RatePoint>,
    /// Search for the highest rate.
    pub throughput: Option<Throughput>,
    /// Verdicts on the targets of performance.
    pub verdicts: Vec<FigureVerdict>,
    /// Clock readings along the path of one report, and the cost of a reading, nanoseconds.
    pub stamps: Stamps,
    /// Notes necessary to interpret the figures.
    pub notes: Vec<String>,
}

/// Figures at one rate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RatePoint {
    /// Reports per second.
    pub rate_per_s: f64,
    /// Medians over the runs, as in [`BenchReport`].
    pub floor: Figures,
    /// As in [`BenchReport`].
    pub pipeline: Figures,
    /// As in [`BenchReport`].
    pub stages: BTreeMap<String, Figures>,
    /// As in [`BenchReport`].
    pub jitter: JitterFigures,
    /// Latencies of a flooding source's own share.
    pub flooded: Option<Figures>,
    /// Single runs.
    pub runs: Vec<Repetition>,
}

/// One repetition: floor, pipeline and jitter, measured one after the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Repetition {
    /// The bare relay.
    pub floor: Figures,
    /// The pipeline.
    pub pipeline: Figures,
    /// Jitter of the machine.
    pub jitter: JitterFigures,
    /// The pipeline's stages.
    pub stages: BTreeMap<String, Figures>,
    /// Account of the reports.
    pub account: ReportAccount,
    /// Warm-up of the pipeline.
    pub warm_up: WarmUp,
    /// The fusion process's memory before and after the measured time.
    pub memory: [ProcessMemory; 2],
}

/// Account of the reports of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReportAccount {
    /// Reports sent in the measured time.
    pub sent: u64,
    /// System tracks received in answer.
    pub answers: u64,
    /// Unanswered reports, without those of a flooding source.
    pub unanswered: u64,
    /// Unanswered reports of the flooding source's share.
    #[serde(default)]
    pub flood_unanswered: u64,
    /// System tracks beyond one for each report.
    pub beyond_one: u64,
    /// System tracks without a triggering report: coasting, ending.
    pub untriggered: u64,
    /// System tracks that are not confirmed.
    pub unconfirmed: u64,
    /// Lateness of the bench's last report, nanoseconds.
    pub bench_late_ns: i64,
    /// Reports sent to the process since the start, warm-up and flood included.
    pub sent_ever: u64,
    /// Counts of fusion since the start.
    pub fusion: FusionCounts,
}

impl ReportAccount {
    /// Whether every report sent is either taken or counted as lost.
    pub fn adds_up(&self) -> bool {
        self.sent_ever == self.fusion.taken + self.fusion.lost
    }
}

/// Jitter of the machine, nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JitterFigures {
    /// Lateness at the times at which reports would have been due.
    pub lateness: Figures,
    /// Interruptions of a thread that only reads the clock: their lengths.
    pub gaps: Figures,
    /// Share of the time lost to interruptions.
    pub taken_away: f64,
}

/// Clock readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stamps {
    /// Cost of a reading, nanoseconds.
    pub reading_ns: u64,
    /// Readings of the bench for each slice: at sending, and at the reception of the states.
    pub bench_per_slice: u32,
    /// Readings of fusion for each slice: at reception, at the sending of the states, and both clocks at the start
    /// of a turn.
    pub fusion_per_slice: u32,
}

/// Search for the highest rate without loss.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Throughput {
    /// The highest rate of the bare relay, reports per second.
    pub floor_per_s: f64,
    /// Every probe of the pipeline, in the order of rates.
    pub probes: Vec<ProbeFigures>,
    /// Measurement beyond the highest rate.
    pub overload: Option<Overload>,
    /// The fusion process's memory before and after the long run at the highest rate.
    pub memory: [ProcessMemory; 2],
    /// Length of that run, seconds.
    pub memory_seconds: f64,
}

/// One probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProbeFigures {
    /// Reports per second.
    pub rate_per_s: f64,
    /// Whether the probe lost no report and grew no queue.
    pub lossless: bool,
    /// Latency from the intended time.
    pub latency: Figures,
    /// Lateness of the last reports sent, nanoseconds.
    pub last_late_ns: i64,
}

/// Load beyond the capacity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Overload {
    /// Sent reports per second.
    pub rate_per_s: f64,
    /// Account of the reports.
    pub account: ReportAccount,
    /// Whether fusion counted every missing report.
    pub adds_up: bool,
    /// Latency of the answered reports, from the intended time.
    pub latency: Figures,
    /// Longest time from dispatch until the bench has the state: the possible delay by the queues, nanoseconds.
    pub longest_in_queues_ns: u64,
}

/// Outcome of a measurement.
#[derive(Clone, Debug)]
pub struct MeasurementOutcome {
    /// Text to show.
    pub text: String,
    /// Reason why the figures are unreliable, if any.
    pub failure: Option<String>,
}

/// Round trips through one layer and all below it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerFigures {
    /// Name of the layer.
    pub name: String,
    /// Least median of a round, nanoseconds.
    pub best_p50_ns: u64,
    /// Medians over the rounds of the median and of the 99th percentile, nanoseconds.
    pub p50_ns: u64,
    /// See above.
    pub p99_ns: u64,
    /// Reports without an answer, of all rounds.
    pub unanswered: u64,
}

impl BenchReport {
    /// Returns the reasons why the figures are unreliable, if any: unanswered reports are in no figure, and those that
    /// fusion rejects cost less than others.
    pub(crate) fn failure(&self) -> Option<String> {
        let runs = self.points.iter().flat_map(|point| &point.runs);
        let accounts = || runs.clone().map(|run| &run.account);
        let unanswered: u64 = accounts().map(|account| account.unanswered).sum();
        let sent: u64 = accounts().map(|account| account.sent).sum();
        let of_pipeline = (unanswered > 0).then(|| {
            let (unanswered, sent) = (count(unanswered), count(sent));
            format!("{unanswered} of {sent} reports were not answered: the figures cover the other reports only")
        });
        let layers = self.layers.iter().filter(|layer| layer.unanswered > 0);
        let of_layers = layers.map(|layer| {
            let unanswered = count(layer.unanswered);
            format!(
                "{}: {unanswered} reports were not answered: its figures cover the others only",
                layer.name
            )
        });
        joined(of_pipeline.into_iter().chain(of_layers).chain(self.engine_failure()))
    }

    /// Returns the reason why the figures of the engine alone are unreliable, if any.
    pub(crate) fn engine_failure(&self) -> Option<String> {
        let passes = [self.engine.single, self.engine.paced];
        let odd: u64 = passes.iter().map(|pass| pass.lost).sum();
        let updates: u64 = passes.iter().map(|pass| pass.count).sum();
        (odd as f64 > ODD_SHARE_MAX * updates as f64).then(|| {
            format!(
                "{} of {} updates of the engine did not yield exactly one confirmed state: its figures are not those of \
                 accepted reports",
                count(odd),
                count(updates)
            )
        })
    }

    /// Writes the report as JSON.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        std::fs::write(path, text + "\n").with_context(|| format!("--json {}", path.display()))
    }

    /// Reads a report written by the bench.
    ///
    /// # Errors
    /// If the file cannot be read, or is no report.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("{}: cannot be read", path.display()))?;
        serde_json::from_str(&text)
            .with_context(|| format!("{}: not a file that `koseki bench --json` writes", path.display()))
    }
}

/// Returns all reasons as one, if there are any.
fn joined(reasons: impl Iterator<Item = String>) -> Option<String> {
    let reasons: Vec<_> = reasons.collect();
    (!reasons.is_empty()).then(|| reasons.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_has_the_keys_of_the_specification() {
        let report = BenchReport {
            stages: BTreeMap::from([("taken_to_fused".to_owned(), Figures::default())]),
            ..BenchReport::default()
        };
        let value = serde_json::to_value(&report).unwrap();
        for key in [
            "machine",
            "settings",
            "stages",
            "throughput_per_s",
            "engine_ns_per_update",
            "jitter",
        ] {
            assert!(value.get(key).is_some(), "{key}");
        }
        for of in ["/floor", "/pipeline", "/stages/taken_to_fused"] {
            for key in ["count", "lost", "p50_ns", "p90_ns", "p99_ns", "p999_ns", "max_ns"] {
                assert!(value.pointer(&format!("{of}/{key}")).is_some(), "{of}/{key}");
            }
        }
        let back: BenchReport = serde_json::from_value(value).unwrap();
        assert_eq!(back, report);
    }

    #[test]
    fn figures_without_the_reports_that_were_lost_are_a_failure() {
        let report = |unanswered| {
            let account = ReportAccount {
                sent: 20_000,
                unanswered,
                ..ReportAccount::default()
            };
            let run = Repetition {
                account,
                ..Repetition::default()
            };
            BenchReport {
                points: vec![RatePoint {
                    runs: vec![run.clone(), run],
                    ..RatePoint::default()
                }],
                ..BenchReport::default()
            }
        };
        assert_eq!(report(0).failure(), None);
        let failure = report(8_000).failure().unwrap();
        assert!(
            failure.starts_with("16,000 of 40,000 reports were not answered"),
            "{failure}"
        );
    }
    #[test]
    fn an_unanswered_layer_is_a_failure_by_its_name() {
        let layer = |name: &str, unanswered| LayerFigures {
            name: name.to_owned(),
            unanswered,
            ..LayerFigures::default()
        };
        let report = |relay, fusion| BenchReport {
            layers: vec![layer("ring", 0), layer("relay", relay), layer("fusion", fusion)],
            ..BenchReport::default()
        };
        assert_eq!(report(0, 0).failure(), None);
        let failure = report(17_845, 2).failure().unwrap();
        assert!(failure.contains("relay: 17,845 reports were not answered"), "{failure}");
        assert!(
            failure.contains("fusion: 2 reports") && !failure.contains("ring"),
            "{failure}"
        );
    }

    #[test]
    fn updates_of_the_engine_without_one_confirmed_state_are_a_failure() {
        let report = |of_single, of_paced| {
            let figures = |lost| Figures {
                count: 1_000,
                lost,
                ..Figures::default()
            };
            BenchReport {
                engine: EngineTimes {
                    single: figures(of_single),
                    paced: figures(of_paced),
                    ..EngineTimes::default()
                },
                ..BenchReport::default()
            }
        };
        assert_eq!(report(0, 0).failure(), None);
        assert_eq!(report(1, 1).failure(), None, "chance");
        for (single, paced, odd) in [(3, 0, "3"), (0, 4, "4"), (3, 4, "7")] {
            let failure = report(single, paced).failure().unwrap();
            assert!(failure.starts_with(&format!("{odd} of 2,000 updates")), "{failure}");
        }
    }
}
