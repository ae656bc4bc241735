//! Display while the deployment runs: a table on a terminal, one line per interval elsewhere.

use telemetry::table::{self, Align, Table};
use telemetry::{Span, Stage, Stages, Summary};

use crate::report::{Picture, Process};
use crate::text::{date_time, elapsed, several, time_of_day};

/// Most sources in the table: it has to fit on a screen.
const SOURCES_SHOWN_MAX: usize = 16;

/// Why a stage has no figures.
pub(crate) const NOT_MEASURED: &str = "transport out is not measured: the monitor polls, to leave fusion in peace, so end to end and age end where\n\
     fusion has published; `koseki bench` or a monitor with wait = \"event\" measures it\n";

/// State of the deployment at the end of an interval.
#[derive(Clone, Debug)]
pub struct Live {
    /// Name of the deployment.
    pub deployment: String,
    /// How long the monitor has watched, nanoseconds.
    pub elapsed_ns: i64,
    /// Now, UTC, nanoseconds.
    pub utc_ns: i64,
    /// Whether there are recordings.
    pub recorded: bool,
    /// How far fusion has got in the recordings' time, UTC, nanoseconds.
    pub recording_ns: Option<i64>,
    /// In the order of the configuration.
    pub sources: Vec<LiveSource>,
    /// The system tracks.
    pub picture: Picture,
    /// Length of the interval, nanoseconds.
    pub interval_ns: i64,
    /// Latencies of the interval; `None` if there are none to speak of.
    pub stages: Option<Vec<LiveStage>>,
    /// Restarts of all processes.
    pub restarts: u64,
    /// How the processes are.
    pub processes: Vec<Process>,
    /// System-track states that the monitor itself missed.
    pub monitor_missed: u64,
}

/// One stage in the live table.
#[derive(Clone, Copy, Debug)]
pub struct LiveStage {
    /// Which.
    pub stage: Stage,
    /// Latencies in the interval; `None` if they are not measured.
    pub summary: Option<Summary>,
    /// How often it took longer than its deadline in the interval; `None` if it has none.
    pub late: Option<u64>,
}

impl LiveStage {
    /// Latencies of all sources together, in the interval that was closed last.
    pub(crate) fn of_interval(stages: &Stages, stage: Stage) -> Self {
        let journey = stages.journey();
        Self {
            stage,
            summary: stage
                .is_measured(journey.end)
                .then(|| stages.summary(stage, None, Span::Interval)),
            late: journey
                .deadlines
                .get(stage)
                .map(|_| stages.deadline_misses(stage, None, Span::Interval)),
        }
    }
}

/// One source in the live table.
#[derive(Clone, Debug)]
pub struct LiveSource {
    /// Name of the source.
    pub name: String,
    /// Reports that fusion has taken.
    pub taken: u64,
    /// How many per second in the interval.
    pub per_s: f64,
    /// Reports that the adapter has rejected.
    pub rejected: u64,
    /// Reports that fusion has missed.
    pub lost: u64,
    /// Median age of the data at a subscriber, nanoseconds.
    pub age_ns: Option<u64>,
    /// Median time in the adapter, nanoseconds.
    pub adapter_ns: Option<u64>,
    /// Median time from there to fusion, nanoseconds.
    pub transport_ns: Option<u64>,
}

impl Live {
    /// The table.
    pub fn table(&self) -> String {
        let mut text = self.heading();
        text.push('\n');
        text.push_str(&self.source_table());
        text.push('\n');
        text.push_str(&self.picture_lines());
        text.push('\n');
        text.push_str(&self.stage_table());
        text.push('\n');
        text.push_str(&self.process_lines());
        text
    }

    /// One line, with its line feed.
    pub fn line(&self) -> String {
        let lost: u64 = self.sources.iter().map(|source| source.lost).sum();
        let per_s: f64 = self.sources.iter().map(|source| source.per_s).sum();
        let picture = &self.picture;
        let mut parts = vec![format!("{}  {}", time_of_day(self.utc_ns), elapsed(self.elapsed_ns))];
        if let Some(reached) = self.recording_ns {
            parts.push(format!("recording at {}", time_of_day(reached)));
        }
        parts.push(format!("{} reports/s", table::count(per_s.round() as u64)));
        parts.push(format!(
            "tracks: {} confirmed, {} coasted, {} tentative",
            table::count(picture.confirmed),
            table::count(picture.coasted),
            table::count(picture.tentative)
        ));
        parts.push(format!("{} lost", table::count(lost)));
        if let Some(summary) = self.end_to_end().filter(|summary| summary.count > 0) {
            let [p50, p99] = [summary.p50_ns, summary.p99_ns].map(|ns| table::duration(ns as f64));
            parts.push(format!("end to end p50 {p50}, p99 {p99}"));
        }
        parts.push(several(self.restarts, "restart"));
        let troubled = self.processes.iter().filter(|process| is_troubled(process));
        parts.extend(troubled.map(|process| format!("{} {}", process.title(), process.state)));
        parts.join(" | ") + "\n"
    }

    fn heading(&self) -> String {
        let mut text = format!(
            "Koseki {}   running for {}   {} UTC",
            self.deployment,
            elapsed(self.elapsed_ns),
            time_of_day(self.utc_ns)
        );
        if let Some(reached) = self.recording_ns {
            text.push_str(&format!("   recording at {}", date_time(reached)));
        }
        text.push('\n');
        text
    }

    fn source_table(&self) -> String {
        let mut columns = vec![
            ("source", Align::Left),
            ("reports", Align::Right),
            ("per second", Align::Right),
            ("rejected", Align::Right),
            ("lost", Align::Right),
        ];
        if self.stages.is_some() {
            columns.extend([("in adapter", Align::Right), ("to fusion", Align::Right)]);
        }
        if self.shows_age() {
            columns.push(("age of data", Align::Right));
        }
        let mut rows = Table::new(&columns);
        for source in self.sources.iter().take(SOURCES_SHOWN_MAX) {
            let mut cells = vec![
                source.name.clone(),
                table::count(source.taken),
                format!("{:.1}", source.per_s),
                table::count(source.rejected),
                table::count(source.lost),
            ];
            if self.stages.is_some() {
                cells.extend([source.adapter_ns, source.transport_ns].map(median));
            }
            if self.shows_age() {
                cells.push(median(source.age_ns));
            }
            rows.row(cells);
        }
        let mut text = rows.to_string();
        if let Some(more) = self.sources.len().checked_sub(SOURCES_SHOWN_MAX + 1) {
            text.push_str(&format!("and {}\n", several(more as u64 + 1, "further source")));
        }
        text
    }

    /// Data of recordings are as old as the recordings.
    fn shows_age(&self) -> bool {
        self.stages.is_some() && !self.recorded
    }

    fn picture_lines(&self) -> String {
        let picture = &self.picture;
        let count = table::count;
        format!(
            "system tracks   now: {} confirmed, {} coasted, {} tentative\n\
             so far          {} started, {} merged, {} split, {}\n",
            count(picture.confirmed),
            count(picture.coasted),
            count(picture.tentative),
            count(picture.started),
            count(picture.merged),
            count(picture.split),
            several(picture.hand_overs, "hand-over"),
        )
    }

    fn stage_table(&self) -> String {
        let Some(stages) = &self.stages else {
            return "latency         not shown: the recording is worked off as fast as possible, so reports wait in full \
                    queues\n"
                .to_owned();
        };
        let interval = format!("latency, last {:.1} s", self.interval_ns as f64 / 1e9);
        let mut rows = Table::new(&[
            (interval.as_str(), Align::Left),
            ("p50", Align::Right),
            ("p90", Align::Right),
            ("p99", Align::Right),
            ("max", Align::Right),
            ("late", Align::Right),
        ]);
        for LiveStage { stage, summary, late } in stages {
            if *stage == Stage::Age && !self.shows_age() {
                continue;
            }
            let summary = summary.filter(|summary| summary.count > 0);
            let figure = |of: fn(&Summary) -> u64| median(summary.as_ref().map(of));
            rows.row([
                stage.label().to_owned(),
                figure(|summary| summary.p50_ns),
                figure(|summary| summary.p90_ns),
                figure(|summary| summary.p99_ns),
                figure(|summary| summary.max_ns),
                late.map_or_else(|| "-".to_owned(), table::count),
            ]);
        }
        let mut text = rows.to_string();
        if stages.iter().any(|stage| stage.summary.is_none()) {
            text.push_str(NOT_MEASURED);
        }
        text
    }

    fn end_to_end(&self) -> Option<Summary> {
        let stages = self.stages.as_ref()?;
        let found = stages.iter().find(|stage| stage.stage == Stage::EndToEnd);
        found.and_then(|stage| stage.summary)
    }

    fn process_lines(&self) -> String {
        let well = self.processes.iter().filter(|process| !is_troubled(process)).count();
        let mut text = format!(
            "processes       {well} of {} well, {}\n",
            self.processes.len(),
            several(self.restarts, "restart")
        );
        let spoken_of = |process: &&Process| is_troubled(process) || process.restarts > 0;
        for process in self.processes.iter().filter(spoken_of) {
            text.push_str(&format!("  {}: {}", process.title(), process.state));
            if process.restarts > 0 {
                text.push_str(&format!(", {}", several(process.restarts.into(), "restart")));
            }
            if !process.last_end.is_empty() {
                text.push_str(&format!(", last time it {}", process.last_end));
            }
            text.push('\n');
        }
        if self.monitor_missed > 0 {
            let missed = several(self.monitor_missed, "state");
            text.push_str(&format!(
                "  the monitor itself missed {missed}: nothing else is affected\n"
            ));
        }
        text
    }
}

fn median(value: Option<u64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| table::duration(value as f64))
}

/// Whether a person should look at it.
fn is_troubled(process: &Process) -> bool {
    process.state.is_troubled()
}

#[cfg(test)]
mod tests {
    use messages::{LifeState, ProcessKind};

    use super::*;
    use crate::golden;
    use crate::report::State;

    fn source(name: &str, taken: u64) -> LiveSource {
        LiveSource {
            name: name.to_owned(),
            taken,
            per_s: taken as f64 / 12.0,
            rejected: 0,
            lost: 0,
            age_ns: Some(312_000_000),
            adapter_ns: Some(41_200),
            transport_ns: None,
        }
    }

    fn process(kind: ProcessKind, name: &str, state: State, restarts: u32) -> Process {
        Process {
            kind,
            name: name.to_owned(),
            state,
            restarts,
            last_end: String::new(),
            note: String::new(),
            pid: None,
        }
    }

    fn stages(summary: Option<Summary>) -> Vec<LiveStage> {
        let late = |stage| (stage == Stage::TakenToFused).then_some(17);
        let stage = |stage| LiveStage {
            stage,
            summary,
            late: late(stage),
        };
        Stage::ALL.map(stage).to_vec()
    }

    fn live() -> Live {
        let summary = Summary {
            count: 200,
            p50_ns: 41_200,
            p90_ns: 98_000,
            p99_ns: 412_000,
            p999_ns: 900_000,
            max_ns: 1_230_000,
            mean_ns: 50_000.0,
        };
        let running = State::Life(LifeState::Running);
        Live {
            deployment: "demo".to_owned(),
            elapsed_ns: 12_000_000_000,
            utc_ns: 1_700_000_000_000_000_000,
            recorded: false,
            recording_ns: None,
            sources: vec![source("radar-west", 1_234), source("ads-b", 9_876)],
            picture: Picture {
                confirmed: 78,
                coasted: 2,
                tentative: 1,
                started: 85,
                merged: 3,
                split: 1,
                hand_overs: 12_345,
                ..Picture::default()
            },
            interval_ns: 1_000_200_000,
            stages: Some(stages(Some(summary))),
            restarts: 1,
            processes: vec![
                process(ProcessKind::Adapter, "radar-west", running, 0),
                process(
                    ProcessKind::Adapter,
                    "ads-b",
                    State::Silent { for_ns: 1_500_000_000 },
                    0,
                ),
                Process {
                    last_end: "was killed by SIGKILL".to_owned(),
                    ..process(ProcessKind::Fusion, "fusion", running, 1)
                },
            ],
            monitor_missed: 0,
        }
    }

    #[test]
    fn table_of_a_live_deployment() {
        golden::assert("live_table.txt", &live().table());
    }

    #[test]
    fn table_of_a_monitor_that_polls() {
        let mut live = live();
        let stages = live.stages.as_mut().unwrap();
        stages[Stage::FusedToReceived as usize].summary = None;
        golden::assert("live_table_poll.txt", &live.table());
    }

    #[test]
    fn table_of_a_recording_as_fast_as_possible() {
        let live = Live {
            recorded: true,
            recording_ns: Some(1_462_917_600_000_000_000),
            stages: None,
            monitor_missed: 7,
            ..live()
        };
        golden::assert("live_table_max.txt", &live.table());
    }

    #[test]
    fn lines() {
        assert_eq!(
            live().line(),
            "22:13:20  12 s | 926 reports/s | tracks: 78 confirmed, 2 coasted, 1 tentative | 0 lost | \
             end to end p50 41.2 µs, p99 412 µs | 1 restart | adapter ads-b silent for 1.5 s\n"
        );
        let batch = Live {
            recording_ns: Some(1_462_917_600_000_000_000),
            stages: None,
            processes: Vec::new(),
            ..live()
        };
        assert_eq!(
            batch.line(),
            "22:13:20  12 s | recording at 22:00:00 | 926 reports/s | tracks: 78 confirmed, 2 coasted, 1 tentative | \
             0 lost | 1 restart\n"
        );
    }

    #[test]
    fn a_silent_interval_has_dashes_and_many_sources_are_cut() {
        let mut live = live();
        live.stages = Some(stages(Some(Summary::default())));
        live.sources = vec![source("radar", 1); SOURCES_SHOWN_MAX + 1];
        let table = live.table();
        assert!(table.contains("and 1 further source\n"), "{table}");
        assert!(
            table.contains("end to end             -    -    -    -     -\n"),
            "{table}"
        );
        assert!(!live.line().contains("end to end"));
    }
}
