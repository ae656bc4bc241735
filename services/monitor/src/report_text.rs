//! The final report as text.
//!
//! For readers who see a report for the first time: a sentence describes each table, and values that are 0 in a good
//! run appear as words instead of columns of zeros.

use messages::{Counter, CounterClass, Counters};
use scoring::AccuracyReport;
use telemetry::Stage;
use telemetry::table::{self, Align, TextTable, count};

use crate::report::{NOT_MEASURED, Report, RunSettings, SourceReport, StageReport};
use crate::text::{date_time, percent, several, time_of_day, times, wrapped};
use crate::truth_watch::WARM_UP_NS;

impl Report {
    /// The report, for people; prose in lines of at most `width` characters.
    pub fn text(&self, width: usize) -> String {
        let mut sections = vec![self.heading()];
        sections.extend((!self.network.is_empty()).then(|| self.network_traffic()));
        sections.extend([self.reports(), self.not_used()]);
        sections.extend(self.also_counted());
        sections.extend([self.arrivals(), self.latencies()]);
        sections.extend(self.deadlines());
        sections.push(self.system_tracks());
        sections.extend(self.registration());
        sections.extend(self.accuracy.as_ref().map(accuracy));
        sections.push(self.alarm_table());
        sections.push(self.process_table());
        sections.push(self.verdict.sentence.clone() + "\n");
        let text = format!("\n{}", sections.join("\n"));
        text.lines().map(|line| fitted(line, width)).collect()
    }

    fn heading(&self) -> String {
        let settings = &self.settings;
        let end_ns = self.begun_utc_ns + (self.duration_s * 1e9) as i64;
        let mut text = format!("KOSEKI REPORT: {}\n", settings.deployment);
        let mut line = |label: &str, value: String| text.push_str(&format!("{label:<9} {value}\n"));
        line(
            "watched",
            format!(
                "{:.1} s, from {} to {} UTC",
                self.duration_s,
                date_time(self.begun_utc_ns),
                date_time(end_ns)
            ),
        );
        line("sources", sources(settings));
        let order = match settings.order {
            "time" => "merges the sources by time of measurement",
            _ => "takes reports as they arrive",
        };
        line(
            "fusion",
            format!("rule {}; {order}; wait mode {}", settings.rule, settings.wait),
        );
        if let Some(poll_ms) = settings.monitor_poll_ms {
            line("monitor", format!("looks every {poll_ms} ms; fusion does not wake it"));
        }
        if let Some(reached) = self.recording_reached_utc_ns {
            line("reached", format!("{} UTC in the recording", date_time(reached)));
        }
        text
    }

    fn alarm_table(&self) -> String {
        if self.alarms.is_empty() {
            return "ALARMS: none was raised\n".to_owned();
        }
        let mut text = "ALARMS that were raised, and what to do\n".to_owned();
        for alarm in &self.alarms {
            let until = match alarm.cleared_utc_ns {
                Some(cleared_ns) => format!("to {}", time_of_day(cleared_ns)),
                None => "stands".to_owned(),
            };
            let from = time_of_day(alarm.raised_utc_ns);
            let raised = match alarm.times {
                1 => format!("{from}, {until}"),
                count => format!("{}, last {from}, {until}", times(count.into())),
            };
            text.push_str(&format!(
                "{} ({raised}): {} {}\n",
                alarm.severity, alarm.text, alarm.remedy
            ));
        }
        text
    }

    fn network_traffic(&self) -> String {
        let mut rows = TextTable::new(&[
            ("process", Align::Left),
            ("datagrams in", Align::Right),
            ("dropped by the kernel", Align::Right),
            ("datagrams out", Align::Right),
            ("records out", Align::Right),
        ]);
        let mut trouble = String::new();
        for report in &self.network {
            let of = |counter: Counter| report.counters[counter];
            let shown = [
                Counter::Datagrams,
                Counter::DatagramsDropped,
                Counter::DatagramsSent,
                Counter::RecordsSent,
            ];
            let cells = shown.map(|counter| count(of(counter)));
            rows.row([report.process.clone()].into_iter().chain(cells));
            for counter in Counter::of(CounterClass::NetworkTrouble).filter(|counter| of(*counter) > 0) {
                let line = format!("{}: {}: {}", report.process, count(of(counter)), counter.sentence());
                trouble.push_str(&(line + "\n"));
            }
        }
        if trouble.is_empty() {
            trouble.push_str("No datagram was rejected or dropped.\n");
        }
        format!("NETWORK\n{rows}{trouble}")
    }

    fn reports(&self) -> String {
        let mut rows = TextTable::new(&[
            ("source", Align::Left),
            ("records read", Align::Right),
            ("rejected", Align::Right),
            ("published", Align::Right),
            ("taken by fusion", Align::Right),
            ("not used", Align::Right),
        ]);
        for source in &self.sources {
            let [taken, unused] = match source.sensor_of {
                Some(_) => ["-", "-"].map(str::to_owned),
                None => {
                    let unused = source.fusion.sum_of(CounterClass::FusionRejection);
                    [source.fusion[Counter::Taken], unused].map(count)
                }
            };
            rows.row([
                source.name.clone(),
                count(source.adapter[Counter::Records]),
                count(source.adapter.sum_of(CounterClass::Rejection)),
                count(source.adapter[Counter::Published]),
                taken,
                unused,
            ]);
        }
        let has_sensors = self.sources.iter().any(|source| source.sensor_of.is_some());
        let remark = match has_sensors {
            true => "Detections of a tracker's sensor are taken by its tracker, and its tracks by fusion.\n",
            false => "",
        };
        format!("REPORTS from the sensors into fusion\n{rows}{remark}")
    }

    fn not_used(&self) -> String {
        let mut rows = CounterRows::new("source");
        for source in &self.sources {
            rows.list(&source.name, "adapter", &source.adapter, &[CounterClass::Rejection]);
            rows.list(&source.name, "fusion", &source.fusion, &[CounterClass::FusionRejection]);
        }
        // Input of no source: blocks of unknown senders, sentences of a platform, a wide-area sensor's reports.
        for process in &self.others {
            rows.list("all", &process.process, &process.counters, &[CounterClass::Rejection]);
        }
        let lines = self
            .refused
            .iter()
            .map(|refused| format!("latest of {}: {}\n", refused.of, refused.text));
        match rows.text() {
            Some(rows) => format!("REJECTED OR NOT USED, and why\n{rows}{}", lines.collect::<String>()),
            None => "REJECTED OR NOT USED: nothing\n".to_owned(),
        }
    }

    /// Other counts, if any: no count of a process is kept back.
    fn also_counted(&self) -> Option<String> {
        use CounterClass::{AdapterRemark, FusionRejection, FusionRemark, Process, Tracking};
        let mut rows = CounterRows::new("of");
        for source in &self.sources {
            rows.list(&source.name, "adapter", &source.adapter, &[AdapterRemark, Tracking]);
            rows.waited(&source.name, "adapter", &source.adapter);
            rows.list(&source.name, "fusion", &source.fusion, &[FusionRemark]);
            rows.list(&source.name, "recorder", &source.recorder, &[FusionRejection]);
        }
        rows.list("all", "fusion", &self.fusion, &[Process]);
        for process in &self.others {
            let classes = [AdapterRemark, Tracking, FusionRejection, Process];
            rows.list("all", &process.process, &process.counters, &classes);
            rows.waited("all", &process.process, &process.counters);
        }
        rows.list("system tracks", "monitor", &self.monitor, &[FusionRejection]);
        rows.text().map(|rows| format!("ALSO COUNTED\n{rows}"))
    }

    fn arrivals(&self) -> String {
        let mut rows = TextTable::new(&[
            ("from", Align::Left),
            ("to", Align::Left),
            ("published", Align::Right),
            ("taken", Align::Right),
            ("lost", Align::Right),
            ("unread", Align::Right),
        ]);
        for hop in &self.losses.hops {
            let numbers = [hop.published, hop.taken, hop.lost, hop.unread].map(count);
            rows.row([hop.from.clone(), hop.to.clone()].into_iter().chain(numbers));
        }
        let mut text = format!("ARRIVAL of samples, as publishers and readers count them independently\n{rows}");
        let hops = || self.losses.hops.iter();
        text.push_str(&format!(
            "{} lost between adapters and fusion.\n",
            several(self.losses.reports_lost, "report")
        ));
        if hops().any(|hop| hop.lost > 0) {
            text.push_str("Lost: the reader fell behind and its oldest samples gave way, or the samples were lost between hosts.\n");
        }
        if hops().any(|hop| hop.unread > 0) {
            text.push_str(
                "Unread: published when the reader was not there (not yet, just being restarted, or no more).\n",
            );
        }
        if self.losses.monitor_missed > 0 {
            text.push_str(
                "What the monitor missed makes its own figures rest on fewer samples; nothing else is affected.\n",
            );
        }
        if !self.losses.complete {
            text.push_str(
                "The monitor was restarted: what it did not see, and what others had counted before they were restarted, \
                 shows as unread here.\n",
            );
        }
        if self.restarts.total > 0 {
            text.push_str("A killed process takes its last 0.2 s of counts with it, so these are not exact.\n");
        }
        text
    }

    fn latencies(&self) -> String {
        if !self.settings.latencies_measured {
            return "LATENCY: not measured. The recording was worked off as fast as possible, so reports waited in full \
                    queues; replay it at a speed (--speed 1) to see latencies.\n"
                .to_owned();
        }
        if self.stages.iter().all(|(_, figures)| figures.summary.count == 0) {
            return "LATENCY: no report has come through\n".to_owned();
        }
        let recorded = self.settings.recorded_sources > 0;
        let shown = |stage: Stage| stage != Stage::Age || !recorded;
        let stages = self.stages.iter().filter(|(stage, _)| shown(*stage));
        let stages = stages.map(|(stage, figures)| (stage.label(), figures.latencies()));
        let end_to_end = |source: &SourceReport| {
            let found = source.stages.iter().find(|(stage, _)| *stage == Stage::EndToEnd);
            (source.name.clone(), found.map(|(_, figures)| figures.summary))
        };
        let reporting = self.sources.iter().filter(|source| source.sensor_of.is_none());
        let mut text = format!(
            "LATENCY of every state that a report caused: half took no longer than p50, 99 % no longer than p99\n\
             {}\n{}",
            table::latencies("stage", stages),
            table::latencies("end to end, by source", reporting.map(end_to_end)),
        );
        text.push_str(
            "adapter: from a report's last byte to its hand-over to shared memory; transport in: until fusion took it; \
             fusion: until the system track was handed over; transport out: until this subscriber had it.\n",
        );
        if self.polls() {
            text.push_str(&format!("{NOT_MEASURED}\n"));
        }
        if !recorded {
            let end = if self.polls() {
                "that hand-over"
            } else {
                "this subscriber"
            };
            text.push_str(&format!(
                "age of data: from the measurement to {end}; it holds the sensor's own delay and turn.\n"
            ));
        }
        if self.settings.order == "time" {
            text.push_str("fusion holds the time that a report waits for the slowest source, to be merged by time.\n");
        }
        let odd = |(_, figures): &(Stage, StageReport)| figures.negative + figures.missing;
        let odd: u64 = self
            .stages
            .iter()
            .filter(|(stage, _)| *stage != Stage::Age)
            .map(odd)
            .sum();
        if odd > 0 {
            text.push_str(&format!(
                "{} missing or out of order, and rejected.\n",
                several(odd, "stamp")
            ));
        }
        text
    }

    /// Numbers of exceeded deadlines, where latencies were measured.
    fn deadlines(&self) -> Option<String> {
        if !self.settings.latencies_measured {
            return None;
        }
        if self.settings.order == "time" {
            return Some(
                "DEADLINES: none. Reports wait for each other by intention, to be merged by time.\n".to_owned(),
            );
        }
        let mut rows = TextTable::new(&[
            ("stage", Align::Left),
            ("may take", Align::Right),
            ("of", Align::Left),
            ("states", Align::Right),
            ("late", Align::Right),
            ("share", Align::Right),
        ]);
        let row = |rows: &mut TextTable, first: [String; 3], states: u64, late: u64| {
            let share = if states == 0 {
                "-".to_owned()
            } else {
                percent(late as f64 / states as f64)
            };
            rows.row(first.into_iter().chain([count(states), count(late), share]));
        };
        for (stage, figures) in self.stages.iter().filter(|(_, figures)| figures.measured) {
            let Some(deadline_us) = figures.deadline_us else {
                continue;
            };
            let may_take = table::duration(deadline_us * 1e3);
            let first = [stage.label().to_owned(), may_take, "all".to_owned()];
            row(&mut rows, first, figures.summary.count, figures.deadline_misses);
            for source in &self.sources {
                let of_stage = source.stages.iter().find(|(of_source, _)| of_source == stage);
                let Some((_, figures)) = of_stage.filter(|(_, figures)| figures.deadline_misses > 0) else {
                    continue;
                };
                let first = [String::new(), String::new(), source.name.clone()];
                row(&mut rows, first, figures.summary.count, figures.deadline_misses);
            }
        }
        let own = self.fusion[Counter::DeadlineMisses];
        Some(format!(
            "DEADLINES, among the states that the monitor saw\n{rows}By its own count, fusion was late with {} of {}.\n\
             The wait of a new track's first report for the end of its scan is no delay, and is left out.\n",
            several(own, "state"),
            count(self.fusion[Counter::Published])
        ))
    }

    /// Whether the monitor looked now and then.
    fn polls(&self) -> bool {
        self.settings.monitor_poll_ms.is_some()
    }

    /// Systematic errors, if sources were compared at all.
    fn registration(&self) -> Option<String> {
        let width = self.sources.iter().map(|source| source.name.chars().count()).max()?;
        let compared = self.sources.iter().any(|source| source.registration.comparisons > 0.0);
        let joint = |source: &SourceReport| match source.states {
            0 => String::new(),
            states => {
                let share = source.joint_states as f64 / states as f64;
                format!("; {} of its states jointly with others", percent(share))
            }
        };
        let line =
            |source: &SourceReport| format!("{:<width$}  {}{}\n", source.name, source.registration, joint(source));
        let reporting = self.sources.iter().filter(|source| source.sensor_of.is_none());
        let lines: String = reporting.map(line).collect();
        compared
            .then(|| format!("REGISTRATION: how far the sources' reports lie off, as fusion has estimated it\n{lines}"))
    }

    fn system_tracks(&self) -> String {
        let picture = &self.picture;
        format!(
            "SYSTEM TRACKS, one per target\n\
             in the end  {} confirmed, {} coasted (carried on without reports), {} tentative, \
             {} suspended (not shown, the number rests)\n\
             at most     {} confirmed or coasted at a time\n\
             so far      {} started, {} confirmed, {} ended, {} resumed, {} merged, {} split, {} from source to source\n",
            count(picture.confirmed),
            count(picture.coasted),
            count(picture.tentative),
            count(picture.suspended),
            count(picture.live_max),
            count(picture.started),
            count(picture.ever_confirmed),
            count(picture.ended),
            count(picture.resumed),
            count(picture.merged),
            count(picture.split),
            several(picture.hand_overs, "hand-over"),
        )
    }

    fn process_table(&self) -> String {
        let mut rows = TextTable::new(&[
            ("process", Align::Left),
            ("state", Align::Left),
            ("restarts", Align::Right),
            ("remark", Align::Left),
        ]);
        for process in &self.processes {
            rows.row([
                process.title(),
                process.state.to_string(),
                count(process.restarts.into()),
                process.remark(),
            ]);
        }
        let mut text = format!("PROCESSES in the end\n{rows}");
        if self.health_rejected > 0 {
            let rejected = several(self.health_rejected, "health message");
            text.push_str(&format!("{rejected} could not be understood and were rejected.\n"));
        }
        text
    }
}

/// Table of counters that have counted something.
struct CounterRows {
    rows: TextTable,
    is_empty: bool,
}

impl CounterRows {
    fn new(of: &'static str) -> Self {
        let columns = [
            (of, Align::Left),
            ("by", Align::Left),
            ("count", Align::Right),
            ("what", Align::Left),
        ];
        Self {
            rows: TextTable::new(&columns),
            is_empty: true,
        }
    }

    fn list(&mut self, of: &str, by: &str, counters: &Counters, classes: &[CounterClass]) {
        let listed = classes.iter().flat_map(|class| Counter::of(*class));
        listed.for_each(|counter| self.row(of, by, counter, counters[counter]));
    }

    /// The only flow that is no step of a report's way.
    fn waited(&mut self, of: &str, by: &str, counters: &Counters) {
        let counter = Counter::WaitedForConsumers;
        self.row(of, by, counter, counters[counter]);
    }

    fn row(&mut self, of: &str, by: &str, counter: Counter, value: u64) {
        if value > 0 {
            self.is_empty = false;
            self.rows.row([of, by, &count(value), counter.sentence()]);
        }
    }

    fn text(self) -> Option<String> {
        (!self.is_empty).then(|| self.rows.to_string())
    }
}

/// A line, or several lines for long prose. Columns of tables are two blanks apart, words of prose a single blank.
fn fitted(line: &str, width: usize) -> String {
    if line.chars().count() <= width || line.contains("  ") {
        format!("{line}\n")
    } else {
        wrapped(line, width)
    }
}

fn sources(settings: &RunSettings) -> String {
    let mut parts = Vec::new();
    if settings.simulated_sources > 0 {
        let mut part = several(settings.simulated_sources as u64, "simulated sensor");
        if let Some(targets) = settings.targets {
            part.push_str(&format!(" in a world of {}", several(targets.into(), "target")));
        }
        if let Some(seed) = settings.seed {
            part.push_str(&format!(" (seed {seed})"));
        }
        parts.push(part);
    }
    if settings.live_sources > 0 {
        parts.push(several(settings.live_sources as u64, "live source"));
    }
    if settings.recorded_sources > 0 {
        let mut part = several(settings.recorded_sources as u64, "recording");
        part.push_str(&match settings.speed.as_deref() {
            Some("max") | None => ", as fast as possible".to_owned(),
            Some("1") => ", at the speed of the recording".to_owned(),
            Some(factor) => format!(", at {factor} times their speed"),
        });
        parts.push(part);
    }
    parts.join(" and ")
}

fn accuracy(accuracy: &AccuracyReport) -> String {
    let warm_up_s = WARM_UP_NS / 1_000_000_000;
    if accuracy.pictures == 0 {
        return format!(
            "ACCURACY: not compared with the truth; the first {warm_up_s} s are left out, and there was no more\n"
        );
    }
    let mut rows = TextTable::new(&[("", Align::Left), ("", Align::Right)]);
    let mut row = |what: &str, value: String| {
        rows.row([what.to_owned(), value]);
    };
    row(
        "targets in view of some sensor, on average",
        format!("{:.1}", accuracy.targets),
    );
    row(
        "of these, held by exactly one system track",
        percent(accuracy.held_once_share),
    );
    row("of these, held by none", percent(accuracy.missed_share));
    row("duplicate tracks, on average", format!("{:.2}", accuracy.duplicates));
    row(
        "tracks without a target, on average",
        format!("{:.2}", accuracy.false_tracks),
    );
    row(
        "tracks with a wrong address, altogether",
        count(accuracy.identity_errors),
    );
    row("horizontal error, root mean square", format!("{:.1} m", accuracy.rms_m));
    row("horizontal error, 95 % are below", format!("{:.1} m", accuracy.p95_m));
    row("horizontal error, largest", format!("{:.1} m", accuracy.max_m));
    let table = rows.to_string();
    let table = table.trim_start_matches('\n');
    format!(
        "ACCURACY against the simulated truth, at {} after the first {warm_up_s} s\n{table}",
        several(accuracy.pictures, "whole second")
    )
}

#[cfg(test)]
#[path = "report_tests.rs"]
pub(crate) mod tests;
