//! What a measurement comes to: for a JSON file (FM-4), and for the comparison of two.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context as _;
use serde::{Deserialize, Serialize};
use telemetry::table::count;

use crate::engine_time::EngineTimes;
use crate::figures::Figures;
use crate::machine::Machine;
use crate::measure::{FusionCounts, WarmUp};
use crate::memory::Memory;
use crate::settings::Settings;
use crate::verdict::Verdict;

/// The whole file. Its figures at the top are those of the first rate; `points` has all of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Which command made it: latency, throughput, engine.
    pub command: String,
    /// On what.
    pub machine: Machine,
    /// With what.
    pub settings: Option<Settings>,
    /// Latency of the bare relay: medians over the runs.
    pub floor: Figures,
    /// Latency of the pipeline: medians over the runs.
    pub pipeline: Figures,
    /// The pipeline's stages: medians over the runs.
    pub stages: BTreeMap<String, Figures>,
    /// Highest rate without loss, where it was looked for, else what was received, reports per second.
    pub throughput_per_s: f64,
    /// The engine alone; 0 if it was not measured.
    pub engine_ns_per_update: f64,
    /// The engine alone, in more figures.
    pub engine: EngineTimes,
    /// The machine's own.
    pub jitter: JitterFigures,
    /// Each rate.
    pub points: Vec<Point>,
    /// Search for the highest rate.
    pub throughput: Option<Throughput>,
    /// Whether it is as fast as it is meant to be.
    pub verdicts: Vec<Verdict>,
    /// Clock readings on the way of one report, and what one costs, nanoseconds.
    pub stamps: Stamps,
    /// What somebody who reads the figures should know.
    pub notes: Vec<String>,
}

/// One rate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Reports per second.
    pub rate_per_s: f64,
    /// Medians over the runs, as in [`Report`].
    pub floor: Figures,
    /// As in [`Report`].
    pub pipeline: Figures,
    /// As in [`Report`].
    pub stages: BTreeMap<String, Figures>,
    /// As in [`Report`].
    pub jitter: JitterFigures,
    /// Where a source floods: latencies of that source's own share.
    pub flooded: Option<Figures>,
    /// Each run.
    pub runs: Vec<Run>,
}

/// One repetition: floor, pipeline and jitter, measured one after the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The bare relay.
    pub floor: Figures,
    /// The pipeline.
    pub pipeline: Figures,
    /// The machine's own.
    pub jitter: JitterFigures,
    /// The pipeline's stages.
    pub stages: BTreeMap<String, Figures>,
    /// What happened to the reports.
    pub account: Account,
    /// Warm-up of the pipeline.
    pub warm_up: WarmUp,
    /// The fusion process's memory before and after the measured time.
    pub memory: [Memory; 2],
}

/// Where the reports of a run have gone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Account {
    /// Reports sent in the measured time.
    pub sent: u64,
    /// System tracks that came back of them.
    pub answers: u64,
    /// Reports that nothing came back of; not those of a source that floods.
    pub unanswered: u64,
    /// The same of the flooding source's share.
    #[serde(default)]
    pub flood_unanswered: u64,
    /// System tracks beyond one for each report.
    pub beyond_one: u64,
    /// System tracks that no report caused: coasting, ending.
    pub untriggered: u64,
    /// System tracks that are not confirmed.
    pub unconfirmed: u64,
    /// How late the bench sent its last report, nanoseconds.
    pub bench_late_ns: i64,
    /// Reports sent to the process in its whole life, warm-up and flood included.
    pub sent_ever: u64,
    /// What fusion counted in its whole life.
    pub fusion: FusionCounts,
}

impl Account {
    /// Whether every report sent is either taken or counted as lost.
    pub fn adds_up(&self) -> bool {
        self.sent_ever == self.fusion.taken + self.fusion.lost
    }
}

/// The machine's own jitter, nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JitterFigures {
    /// Lateness at the times at which reports would have been due.
    pub lateness: Figures,
    /// Interruptions of a thread that only reads the clock: their lengths.
    pub gaps: Figures,
    /// Part of the time that was taken away so.
    pub taken_away: f64,
}

/// Clock readings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stamps {
    /// What one costs, nanoseconds.
    pub reading_ns: u64,
    /// Of the bench for each slice: when it is sent and when its states are received.
    pub bench_per_slice: u32,
    /// Of fusion for each slice: when it is taken, when its states are sent, and both clocks at the start of a turn.
    pub fusion_per_slice: u32,
}

/// The search for the highest rate without loss.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Throughput {
    /// The highest rate of the bare relay, reports per second.
    pub floor_per_s: f64,
    /// Every probe of the pipeline, in the order of its rate.
    pub probes: Vec<ProbeFigures>,
    /// One beyond the highest rate.
    pub overload: Option<Overload>,
    /// The fusion process's memory before and after the long run at the highest rate.
    pub memory: [Memory; 2],
    /// Length of that run, seconds.
    pub memory_seconds: f64,
}

/// One probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProbeFigures {
    /// Reports per second.
    pub rate_per_s: f64,
    /// Whether nothing was lost and no queue grew.
    pub lossless: bool,
    /// Latency from the intended time.
    pub latency: Figures,
    /// Reports that were due and sent late at the end, nanoseconds.
    pub last_late_ns: i64,
}

/// More than it can take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Overload {
    /// Reports per second that were sent.
    pub rate_per_s: f64,
    /// Where they have gone.
    pub account: Account,
    /// Whether fusion counted every report that it did not get.
    pub adds_up: bool,
    /// Latency of what came back, from the intended time.
    pub latency: Figures,
    /// From dispatch to the bench having the state: what the queues can add, nanoseconds.
    pub longest_in_queues_ns: u64,
}

/// Outcome of a measurement.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Text to show.
    pub text: String,
    /// Reason for which the figures are worth little; `None` if there is none.
    pub failure: Option<String>,
}

impl Report {
    /// Reason for which the figures are worth little: reports without an answer are in none of them.
    pub(crate) fn failure(&self) -> Option<String> {
        let runs = self.points.iter().flat_map(|point| &point.runs);
        let accounts = || runs.clone().map(|run| &run.account);
        let unanswered: u64 = accounts().map(|account| account.unanswered).sum();
        let sent: u64 = accounts().map(|account| account.sent).sum();
        let (unanswered_text, sent) = (count(unanswered), count(sent));
        (unanswered > 0).then(|| {
            format!("{unanswered_text} of {sent} reports were not answered: the figures speak of the others only")
        })
    }

    /// Writes it as JSON.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        std::fs::write(path, text + "\n").with_context(|| format!("--json {}", path.display()))
    }

    /// Reads one that was written by the bench.
    ///
    /// # Errors
    /// If it cannot be read, or is none.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("{}: cannot be read", path.display()))?;
        serde_json::from_str(&text)
            .with_context(|| format!("{}: not a file that `koseki bench --json` writes", path.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_has_the_keys_of_the_specification() {
        let report = Report {
            stages: BTreeMap::from([("taken_to_fused".to_owned(), Figures::default())]),
            ..Report::default()
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
        let back: Report = serde_json::from_value(value).unwrap();
        assert_eq!(back, report);
    }

    #[test]
    fn figures_without_the_reports_that_were_lost_are_a_failure() {
        let report = |unanswered| {
            let account = Account {
                sent: 20_000,
                unanswered,
                ..Account::default()
            };
            let run = Run {
                account,
                ..Run::default()
            };
            Report {
                points: vec![Point {
                    runs: vec![run.clone(), run],
                    ..Point::default()
                }],
                ..Report::default()
            }
        };
        assert_eq!(report(0).failure(), None);
        let failure = report(8_000).failure().unwrap();
        assert!(
            failure.starts_with("16,000 of 40,000 reports were not answered"),
            "{failure}"
        );
    }
}
