//! Rules for the report of a deployment: what each of its sentences means, in the counters of `report.json`.
//!
//! The text is read as one sequence of sentences and rows. Each rule is a condition on the counters, and the sentence
//! that stands exactly where it holds. A sentence that no counter bears, one that is missing, and one without a rule
//! here are the same finding: the text does not go on as the counters do. Beside them are rules of counters among each
//! other, and one for each alarm.

use std::collections::{BTreeMap, BTreeSet};

use alarms::AlarmKind;
use messages::{Counter, CounterClass};
use serde_json::Value;
use telemetry::Stage;
use telemetry::table::{count, duration};

/// Begin of the text of a report.
pub(crate) const BEGIN: &str = "KOSEKI REPORT: ";
/// Stands in a rule for words that are not numbers of the report: times of day.
const ANY: char = '…';

/// Finds what is wrong in the text of a report, or in the report itself.
pub(crate) fn findings(text: &str, report: &Value) -> Vec<String> {
    let told = Told(report);
    let mut found = told.contradictions();
    found.extend(told.alarms().filter_map(|alarm| told.untrue(alarm)));
    found.extend(compared(text, &told.sentences()));
    found
}

/// The first place where the text differs from the sentences; blanks and line breaks are alike.
fn compared(text: &str, sentences: &[String]) -> Option<String> {
    let one_blank = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let text = one_blank(text);
    let mut rest = text.as_str();
    for sentence in sentences.iter().map(|sentence| one_blank(sentence)) {
        let mut literals = sentence.split(ANY);
        let first = rest.strip_prefix(literals.next().unwrap_or_default());
        let after = first.and_then(|first| {
            literals.try_fold(first, |rest, literal| {
                rest.find(literal).map(|place| &rest[place + literal.len()..])
            })
        });
        match after.filter(|after| after.is_empty() || after.starts_with(' ')) {
            Some(after) => rest = after.trim_start(),
            None => return Some(differs(rest, &sentence)),
        }
    }
    (!rest.is_empty()).then(|| differs(rest, "the end"))
}

fn differs(text: &str, sentence: &str) -> String {
    let beginning: String = text.chars().take(sentence.chars().count() + 80).collect();
    format!("the report has \"{beginning}\"; by the counters it is \"{sentence}\"")
}

/// A report as it was written.
struct Told<'r>(&'r Value);

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn words(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or(0)
}

fn float(value: &Value) -> f64 {
    value.as_f64().unwrap_or(0.0)
}

fn of(counters: &Value, counter: Counter) -> u64 {
    number(&counters[counter.label()])
}

fn sum(counters: &Value, class: CounterClass) -> u64 {
    Counter::of(class).map(|counter| of(counters, counter)).sum()
}

fn several(count_of: u64, thing: &str) -> String {
    format!("{} {thing}{}", count(count_of), if count_of == 1 { "" } else { "s" })
}

fn were(count_of: u64, thing: &str) -> String {
    format!(
        "{} {}",
        several(count_of, thing),
        if count_of == 1 { "was" } else { "were" }
    )
}

fn times(count_of: u64) -> String {
    match count_of {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        _ => format!("{} times", count(count_of)),
    }
}

fn percent(part: f64, whole: f64) -> String {
    let share = part / whole.max(1.0);
    match (share * 1000.0).round() / 10.0 {
        shown if share < 1.0 && shown >= 100.0 => "> 99.9 %".to_owned(),
        shown if share > 0.0 && shown <= 0.0 => "< 0.1 %".to_owned(),
        shown => format!("{shown:.1} %"),
    }
}

fn row(cells: &[&str]) -> String {
    cells.join(" ")
}

impl Told<'_> {
    fn sources(&self) -> impl Iterator<Item = &Value> {
        list(&self.0["sources"])
    }

    /// Sources of fusion: not the sensors of a tracker.
    fn reporting(&self) -> impl Iterator<Item = &Value> {
        self.sources().filter(|source| source["sensor_of"].is_null())
    }

    fn alarms(&self) -> impl Iterator<Item = &Value> {
        list(&self.0["alarms"])
    }

    fn processes(&self) -> impl Iterator<Item = &Value> {
        list(&self.0["processes"])
    }

    fn hops(&self) -> impl Iterator<Item = &Value> {
        list(&self.0["losses"]["hops"])
    }

    fn setting(&self, name: &str) -> &Value {
        &self.0["settings"][name]
    }

    fn polls(&self) -> bool {
        !self.setting("monitor_poll_ms").is_null()
    }

    fn by_time(&self) -> bool {
        self.setting("order") == "time"
    }

    fn has_latencies(&self) -> bool {
        self.setting("latencies_measured") == true
    }

    fn taken(&self) -> u64 {
        self.sources().map(|source| of(&source["fusion"], Counter::Taken)).sum()
    }
}

/// The sentences.
impl Told<'_> {
    fn sentences(&self) -> Vec<String> {
        let mut all = self.heading();
        all.extend(self.network());
        all.extend(self.reports());
        all.extend(self.not_used());
        all.extend(self.also_counted());
        all.extend(self.arrivals());
        all.extend(self.latencies());
        all.extend(self.deadlines());
        all.extend(self.system_tracks());
        all.extend(self.registration());
        all.extend(self.accuracy());
        all.extend(self.alarm_lines());
        all.extend(self.process_lines());
        all.push(self.verdict());
        all
    }

    fn heading(&self) -> Vec<String> {
        let order = match self.by_time() {
            true => "merges the sources by time of measurement",
            false => "takes reports as they arrive",
        };
        let of_settings = |name: &str| words(self.setting(name));
        let mut lines = vec![
            format!("{BEGIN}{}", of_settings("deployment")),
            format!("watched {:.1} s, from {ANY} to {ANY} UTC", float(&self.0["duration_s"])),
            format!("sources {}", self.kinds_of_sources()),
            format!(
                "fusion rule {}; {order}; wait mode {}",
                of_settings("rule"),
                of_settings("wait")
            ),
        ];
        if self.polls() {
            let poll_ms = self.setting("monitor_poll_ms");
            lines.push(format!(
                "monitor looks every {} ms; fusion does not wake it",
                float(poll_ms)
            ));
        }
        if !self.0["recording_reached_utc_ns"].is_null() {
            lines.push(format!("reached {ANY} UTC in the recording"));
        }
        lines
    }

    fn kinds_of_sources(&self) -> String {
        let counted = |name: &str, thing: &str| {
            let some = number(self.setting(name));
            (some > 0).then(|| several(some, thing))
        };
        let mut simulated = counted("simulated_sources", "simulated sensor");
        if let (Some(part), Some(targets)) = (&mut simulated, self.setting("targets").as_u64()) {
            part.push_str(&format!(" in a world of {}", several(targets, "target")));
        }
        if let (Some(part), Some(seed)) = (&mut simulated, self.setting("seed").as_u64()) {
            part.push_str(&format!(" (seed {seed})"));
        }
        let speed = match self.setting("speed").as_str() {
            Some("1") => ", at the speed of the recording".to_owned(),
            Some("max") | None => ", as fast as possible".to_owned(),
            Some(factor) => format!(", at {factor} times their speed"),
        };
        let recorded = counted("recorded_sources", "recording").map(|part| part + &speed);
        let parts = [simulated, counted("live_sources", "live source"), recorded];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" and ")
    }

    fn network(&self) -> Vec<String> {
        let network = || list(&self.0["network"]);
        if network().next().is_none() {
            return Vec::new();
        }
        let columns = "process datagrams in dropped by the kernel datagrams out records out";
        let mut lines = vec!["NETWORK".to_owned(), columns.to_owned()];
        let shown = [
            Counter::Datagrams,
            Counter::DatagramsDropped,
            Counter::DatagramsSent,
            Counter::RecordsSent,
        ];
        for process in network() {
            let cells = shown.map(|counter| count(of(&process["counters"], counter)));
            lines.push(format!("{} {}", words(&process["process"]), cells.join(" ")));
        }
        let before = lines.len();
        for process in network() {
            for counter in Counter::of(CounterClass::NetworkTrouble) {
                let value = of(&process["counters"], counter);
                let name = words(&process["process"]);
                lines.extend((value > 0).then(|| format!("{name}: {}: {}", count(value), counter.sentence())));
            }
        }
        if lines.len() == before {
            lines.push("No datagram was rejected or dropped.".to_owned());
        }
        lines
    }

    fn reports(&self) -> Vec<String> {
        let mut lines = vec![
            "REPORTS from the sensors into fusion".to_owned(),
            "source records read rejected published taken by fusion not used".to_owned(),
        ];
        for source in self.sources() {
            let (adapter, fusion) = (&source["adapter"], &source["fusion"]);
            let mut cells = vec![
                count(of(adapter, Counter::Records)),
                count(sum(adapter, CounterClass::Rejection)),
                count(of(adapter, Counter::Published)),
            ];
            cells.extend(match source["sensor_of"].is_null() {
                true => [of(fusion, Counter::Taken), sum(fusion, CounterClass::FusionRejection)].map(count),
                false => ["-", "-"].map(str::to_owned),
            });
            lines.push(format!("{} {}", words(&source["name"]), cells.join(" ")));
        }
        if self.reporting().count() < self.sources().count() {
            let remark = "Detections of a tracker's sensor are taken by its tracker, and its tracks by fusion.";
            lines.push(remark.to_owned());
        }
        lines
    }

    fn not_used(&self) -> Vec<String> {
        let mut rows = Vec::new();
        let mut listed = |whose: &str, by: &str, counters: &Value, classes: &[CounterClass]| {
            rows.extend(counted_rows(whose, by, counters, classes));
        };
        for source in self.sources() {
            let name = words(&source["name"]);
            listed(name, "adapter", &source["adapter"], &[CounterClass::Rejection]);
            listed(name, "fusion", &source["fusion"], &[CounterClass::FusionRejection]);
        }
        for process in list(&self.0["others"]) {
            let by = words(&process["process"]);
            listed("all", by, &process["counters"], &[CounterClass::Rejection]);
        }
        if rows.is_empty() {
            return vec!["REJECTED OR NOT USED: nothing".to_owned()];
        }
        let heading = ["REJECTED OR NOT USED, and why", "source by count what"].map(str::to_owned);
        let latest = list(&self.0["refused"]);
        let latest = latest.map(|refused| format!("latest of {}: {}", words(&refused["of"]), words(&refused["text"])));
        heading.into_iter().chain(rows).chain(latest).collect()
    }

    fn also_counted(&self) -> Vec<String> {
        use CounterClass::{AdapterRemark, FusionRejection, FusionRemark, Process, Tracking};
        let waited = |whose: &str, by: &str, counters: &Value| {
            let counter = Counter::WaitedForConsumers;
            let value = of(counters, counter);
            (value > 0).then(|| row(&[whose, by, &count(value), counter.sentence()]))
        };
        let mut rows = Vec::new();
        for source in self.sources() {
            let name = words(&source["name"]);
            rows.extend(counted_rows(
                name,
                "adapter",
                &source["adapter"],
                &[AdapterRemark, Tracking],
            ));
            rows.extend(waited(name, "adapter", &source["adapter"]));
            rows.extend(counted_rows(name, "fusion", &source["fusion"], &[FusionRemark]));
            rows.extend(counted_rows(name, "recorder", &source["recorder"], &[FusionRejection]));
        }
        rows.extend(counted_rows("all", "fusion", &self.0["fusion"], &[Process]));
        for process in list(&self.0["others"]) {
            let (by, counters) = (words(&process["process"]), &process["counters"]);
            let classes = [AdapterRemark, Tracking, FusionRejection, Process];
            rows.extend(counted_rows("all", by, counters, &classes));
            rows.extend(waited("all", by, counters));
        }
        rows.extend(counted_rows(
            "system tracks",
            "monitor",
            &self.0["monitor"],
            &[FusionRejection],
        ));
        match rows.is_empty() {
            true => Vec::new(),
            false => ["ALSO COUNTED", "of by count what"]
                .map(str::to_owned)
                .into_iter()
                .chain(rows)
                .collect(),
        }
    }

    fn arrivals(&self) -> Vec<String> {
        let losses = &self.0["losses"];
        let mut lines = vec![
            "ARRIVAL of samples, as publishers and readers count them independently".to_owned(),
            "from to published taken lost unread".to_owned(),
        ];
        for hop in self.hops() {
            let cells = ["published", "taken", "lost", "unread"].map(|name| count(number(&hop[name])));
            lines.push(format!(
                "{} {} {}",
                words(&hop["from"]),
                words(&hop["to"]),
                cells.join(" ")
            ));
        }
        let lost = several(number(&losses["reports_lost"]), "report");
        lines.push(format!("{lost} lost between adapters and fusion."));
        let any = |name: &str| self.hops().any(|hop| number(&hop[name]) > 0);
        let remarks = [
            (
                any("lost"),
                "Lost: the reader fell behind and its oldest samples gave way, or the samples were lost between hosts.",
            ),
            (
                any("unread"),
                "Unread: published when the reader was not there (not yet, just being restarted, or no more).",
            ),
            (
                number(&losses["monitor_missed"]) > 0,
                "What the monitor missed makes its own figures rest on fewer samples; nothing else is affected.",
            ),
            (
                losses["complete"] == false,
                "The monitor was restarted: what it did not see, and what others had counted before they were restarted, \
                 shows as unread here.",
            ),
            (
                self.processes().any(|process| number(&process["restarts"]) > 0),
                "A killed process takes its last 0.2 s of counts with it, so these are not exact.",
            ),
        ];
        lines.extend(
            remarks
                .into_iter()
                .filter(|(holds, _)| *holds)
                .map(|(_, remark)| remark.to_owned()),
        );
        lines
    }

    fn latencies(&self) -> Vec<String> {
        if !self.has_latencies() {
            let sentence = "LATENCY: not measured. The recording was worked off as fast as possible, so reports waited in \
                            full queues; replay it at a speed (--speed 1) to see latencies.";
            return vec![sentence.to_owned()];
        }
        let figures = |stage: Stage| &self.0["stages"][stage.key()];
        if Stage::ALL.iter().all(|stage| number(&figures(*stage)["count"]) == 0) {
            return vec!["LATENCY: no report has come through".to_owned()];
        }
        let is_recorded = number(self.setting("recorded_sources")) > 0;
        let columns = "count p50 p90 p99 p99.9 max mean";
        let mut lines = vec![
            "LATENCY of every state that a report caused: half took no longer than p50, 99 % no longer than p99"
                .to_owned(),
            format!("stage {columns}"),
        ];
        let shown = |stage: &Stage| !is_recorded || *stage != Stage::Age;
        for stage in Stage::ALL.into_iter().filter(shown) {
            let cells = match figures(stage)["measured"] == true {
                true => latency_cells(figures(stage)),
                false => ["-"; 7].join(" "),
            };
            lines.push(format!("{} {cells}", stage.label()));
        }
        lines.push(format!("end to end, by source {columns}"));
        for source in self.reporting() {
            let end_to_end = &source["stages"][Stage::EndToEnd.key()];
            lines.push(format!("{} {}", words(&source["name"]), latency_cells(end_to_end)));
        }
        lines.push(
            "adapter: from a report's last byte to its hand-over to shared memory; transport in: until fusion took it; \
             fusion: until the system track was handed over; transport out: until this subscriber had it."
                .to_owned(),
        );
        if self.polls() {
            lines.push(
                "transport out is not measured: the monitor polls, to leave fusion in peace, so end to end and age end where \
                 fusion has published; `koseki bench` or a monitor with wait = \"event\" measures it"
                    .to_owned(),
            );
        }
        if !is_recorded {
            let end = if self.polls() {
                "that hand-over"
            } else {
                "this subscriber"
            };
            lines.push(format!(
                "age of data: from the measurement to {end}; it holds the sensor's own delay and turn."
            ));
        }
        if self.by_time() {
            let waits = "fusion holds the time that a report waits for the slowest source, to be merged by time.";
            lines.push(waits.to_owned());
        }
        let irregular = |stage: Stage| number(&figures(stage)["negative"]) + number(&figures(stage)["missing"]);
        let odd: u64 = Stage::ALL
            .into_iter()
            .filter(|stage| *stage != Stage::Age)
            .map(irregular)
            .sum();
        lines.extend((odd > 0).then(|| format!("{} missing or out of order, and rejected.", several(odd, "stamp"))));
        lines
    }

    fn deadlines(&self) -> Vec<String> {
        if !self.has_latencies() {
            return Vec::new();
        }
        if self.by_time() {
            let none = "DEADLINES: none. Reports wait for each other by intention, to be merged by time.";
            return vec![none.to_owned()];
        }
        let mut lines = vec![
            "DEADLINES, among the states that the monitor saw".to_owned(),
            "stage may take of states late share".to_owned(),
        ];
        let cells = |figures: &Value| {
            let [states, late] = ["count", "deadline_misses"].map(|name| number(&figures[name]));
            let share = match states {
                0 => "-".to_owned(),
                _ => percent(late as f64, states as f64),
            };
            format!("{} {} {share}", count(states), count(late))
        };
        for stage in Stage::ALL {
            let all = &self.0["stages"][stage.key()];
            let Some(deadline_us) = all["deadline_us"].as_f64().filter(|_| all["measured"] == true) else {
                continue;
            };
            lines.push(format!(
                "{} {} all {}",
                stage.label(),
                duration(deadline_us * 1e3),
                cells(all)
            ));
            for source in self.sources() {
                let own = &source["stages"][stage.key()];
                if number(&own["deadline_misses"]) > 0 {
                    lines.push(format!("{} {}", words(&source["name"]), cells(own)));
                }
            }
        }
        lines.push(format!(
            "By its own count, fusion was late with {} of {}.",
            several(of(&self.0["fusion"], Counter::DeadlineMisses), "state"),
            count(of(&self.0["fusion"], Counter::Published))
        ));
        let left_out = "The wait of a new track's first report for the end of its scan is no delay, and is left out.";
        lines.push(left_out.to_owned());
        lines
    }

    fn system_tracks(&self) -> Vec<String> {
        let shown = |name: &str| count(number(&self.0["picture"][name]));
        vec![
            "SYSTEM TRACKS, one per target".to_owned(),
            format!(
                "in the end {} confirmed, {} coasted (carried on without reports), {} tentative, {} suspended (not shown, the \
                 number rests)",
                shown("confirmed"),
                shown("coasted"),
                shown("tentative"),
                shown("suspended")
            ),
            format!("at most {} confirmed or coasted at a time", shown("live_max")),
            format!(
                "so far {} started, {} confirmed, {} ended, {} resumed, {} merged, {} split, {} from source to source",
                shown("started"),
                shown("ever_confirmed"),
                shown("ended"),
                shown("resumed"),
                shown("merged"),
                shown("split"),
                several(number(&self.0["picture"]["hand_overs"]), "hand-over")
            ),
        ]
    }

    fn registration(&self) -> Vec<String> {
        if self
            .sources()
            .all(|source| float(&source["registration"]["comparisons"]) == 0.0)
        {
            return Vec::new();
        }
        let mut lines =
            vec!["REGISTRATION: how far the sources' reports lie off, as fusion has estimated it".to_owned()];
        for source in self.reporting() {
            let [joint, states] = ["joint_states", "states"].map(|name| number(&source[name]) as f64);
            let jointly = match states > 0.0 {
                true => format!("; {} of its states jointly with others", percent(joint, states)),
                false => String::new(),
            };
            let learned = words(&source["registration"]["text"]);
            lines.push(format!("{} {learned}{jointly}", words(&source["name"])));
        }
        lines
    }

    fn accuracy(&self) -> Vec<String> {
        let accuracy = &self.0["accuracy"];
        if accuracy.is_null() {
            return Vec::new();
        }
        let pictures = number(&accuracy["pictures"]);
        if pictures == 0 {
            let none = "ACCURACY: not compared with the truth; the first 10 s are left out, and there was no more";
            return vec![none.to_owned()];
        }
        let share = |name: &str| percent(float(&accuracy[name]), 1.0);
        let figure = |name: &str, decimals: usize| format!("{:.decimals$}", float(&accuracy[name]));
        let pictures = several(pictures, "whole second");
        vec![
            format!("ACCURACY against the simulated truth, at {pictures} after the first 10 s"),
            format!("targets in view of some sensor, on average {}", figure("targets", 1)),
            format!(
                "of these, held by exactly one system track {}",
                share("held_once_share")
            ),
            format!("of these, held by none {}", share("missed_share")),
            format!("duplicate tracks, on average {}", figure("duplicates", 2)),
            format!("tracks without a target, on average {}", figure("false_tracks", 2)),
            format!(
                "tracks with a wrong address, altogether {}",
                count(number(&accuracy["identity_errors"]))
            ),
            format!("horizontal error, root mean square {} m", figure("rms_m", 1)),
            format!("horizontal error, 95 % are below {} m", figure("p95_m", 1)),
            format!("horizontal error, largest {} m", figure("max_m", 1)),
        ]
    }

    fn alarm_lines(&self) -> Vec<String> {
        if self.alarms().next().is_none() {
            return vec!["ALARMS: none was raised".to_owned()];
        }
        let mut lines = vec!["ALARMS that were raised, and what to do".to_owned()];
        for alarm in self.alarms() {
            let until = match alarm["cleared_utc_ns"].is_null() {
                true => "stands".to_owned(),
                false => format!("to {ANY}"),
            };
            let raised = match number(&alarm["times"]) {
                1 => format!("{ANY}, {until}"),
                several => format!("{}, last {ANY}, {until}", times(several)),
            };
            let [severity, text, remedy] = ["severity", "text", "remedy"].map(|name| words(&alarm[name]));
            lines.push(format!("{severity} ({raised}): {text} {remedy}"));
        }
        lines
    }

    fn process_lines(&self) -> Vec<String> {
        let mut lines = vec![
            "PROCESSES in the end".to_owned(),
            "process state restarts remark".to_owned(),
        ];
        for process in self.processes() {
            let [state, end, note] = ["state", "last_end", "note"].map(|name| words(&process[name]));
            let remark = match (end, note) {
                ("", note) => note.to_owned(),
                (end, "") => format!("the last one {end}"),
                (end, note) => format!("the last one {end}; {note}"),
            };
            let restarts = count(number(&process["restarts"]));
            lines.push(row(&[&title(process), state, &restarts, &remark]));
        }
        let rejected = number(&self.0["health_rejected"]);
        lines.extend((rejected > 0).then(|| {
            let rejected = several(rejected, "health message");
            format!("{rejected} could not be understood and were rejected.")
        }));
        lines
    }
}

/// Rows of the counters of these classes that count something.
fn counted_rows(whose: &str, by: &str, counters: &Value, classes: &[CounterClass]) -> Vec<String> {
    let listed = classes.iter().flat_map(|class| Counter::of(*class));
    let counted = listed.map(|counter| (of(counters, counter), counter.sentence()));
    let counted = counted.filter(|(value, _)| *value > 0);
    counted
        .map(|(value, sentence)| row(&[whose, by, &count(value), sentence]))
        .collect()
}

fn latency_cells(figures: &Value) -> String {
    let all = number(&figures["count"]);
    let mut cells = vec![count(all)];
    if all > 0 {
        let names = ["p50_ns", "p90_ns", "p99_ns", "p999_ns", "max_ns", "mean_ns"];
        cells.extend(names.map(|name| duration(float(&figures[name]))));
    }
    cells.join(" ")
}

fn title(process: &Value) -> String {
    let [kind, name] = ["kind", "name"].map(|member| words(&process[member]));
    match kind {
        "" => name.to_owned(),
        kind if kind == name => name.to_owned(),
        kind => format!("{kind} {name}"),
    }
}

/// The last sentence.
impl Told<'_> {
    fn verdict(&self) -> String {
        let concerns = self.concerns();
        if !concerns.is_empty() {
            return format!("Worth a look: {}.", concerns.join("; "));
        }
        let (taken, unread) = (self.taken(), number(&self.0["losses"]["reports_unread"]));
        let mut sentence = match unread {
            0 => format!(
                "Nothing to worry about: all {} reached fusion, none was lost",
                several(taken, "published report")
            ),
            unread => format!(
                "Nothing to worry about: {} reached fusion, none was lost, {} on the way at the end",
                several(taken, "report"),
                were(unread, "report")
            ),
        };
        sentence.push_str(", and no process was restarted");
        let end_to_end = &self.0["stages"][Stage::EndToEnd.key()];
        if number(&end_to_end["count"]) > 0 {
            let reached = if self.polls() {
                "were published"
            } else {
                "reached a subscriber"
            };
            let median = duration(float(&end_to_end["p50_ns"]));
            sentence.push_str(&format!("; half of the states {reached} within {median}"));
        }
        sentence + "."
    }

    fn concerns(&self) -> Vec<String> {
        let mut all = Vec::new();
        self.about_processes(&mut all);
        self.about_reports(&mut all);
        for process in list(&self.0["network"]) {
            let name = words(&process["process"]);
            let datagrams = |counter| of(&process["counters"], counter);
            let (dropped, unsent) = (datagrams(Counter::DatagramsDropped), datagrams(Counter::SendFailures));
            if dropped > 0 {
                let dropped = several(dropped, "datagram");
                all.push(format!(
                    "the kernel dropped {dropped} before {name} had read them: raise its buffer_bytes"
                ));
            }
            if unsent > 0 {
                all.push(format!("{name} could not send {}", several(unsent, "datagram")));
            }
        }
        let missed = self.hops().filter(|hop| hop["to"] == "recorder");
        let missed: u64 = missed.map(|hop| number(&hop["lost"])).sum();
        if missed > 0 {
            all.push(format!(
                "the recorder missed {}, so its files have gaps",
                several(missed, "sample")
            ));
        }
        self.about_fusion(&mut all);
        self.about_accuracy(&mut all);
        self.about_shares(&mut all);
        // These have a sentence of their own.
        let told = [
            AlarmKind::SamplesLost,
            AlarmKind::DatagramsDropped,
            AlarmKind::SendFailed,
            AlarmKind::CapacityReached,
            AlarmKind::LayoutMismatch,
            AlarmKind::ProcessRestarted,
            AlarmKind::ProcessDown,
            AlarmKind::ProcessHung,
        ];
        let others = self
            .alarms()
            .filter(|alarm| told.iter().all(|kind| alarm["alarm"] != kind.word()));
        all.extend(others.map(|alarm| words(&alarm["text"]).trim_end_matches('.').to_owned()));
        all
    }

    fn about_processes(&self, all: &mut Vec<String>) {
        for process in self.processes() {
            let (name, state) = (title(process), words(&process["state"]));
            let outlasts = ["monitor", "keeper", "launcher"].contains(&words(&process["kind"]));
            match state {
                _ if outlasts => {}
                "not heard from" => all.push(format!("{name} was never heard from")),
                "failed" => all.push(format!("{name} has failed")),
                silent if silent.starts_with("silent") => all.push(format!("{name} has been {silent}")),
                _ => {}
            }
            let restarts = number(&process["restarts"]);
            if restarts == 0 {
                continue;
            }
            let mut concern = format!("{name} was restarted {}", times(restarts));
            match words(&process["last_end"]) {
                "" => {}
                end => concern.push_str(&format!(" (the last time because it {end})")),
            }
            if process["kind"] == "monitor" && self.0["losses"]["complete"] == false {
                concern.push_str(", so this report speaks of the time since then only");
            }
            all.push(concern);
        }
    }

    fn about_reports(&self, all: &mut Vec<String>) {
        let taken = self.taken();
        if taken == 0 {
            all.push("fusion did not receive a single report".to_owned());
            return;
        }
        for source in self.sources() {
            let delivered = match source["sensor_of"].is_null() {
                true => of(&source["fusion"], Counter::Taken),
                false => of(&source["adapter"], Counter::Published) + of(&source["adapter"], Counter::Detections),
            };
            all.extend((delivered == 0).then(|| format!("{} delivered nothing", words(&source["name"]))));
        }
        let losses = &self.0["losses"];
        let [lost, unread] = ["reports_lost", "reports_unread"].map(|name| number(&losses[name]));
        if lost > 0 {
            all.push(format!(
                "{} did not reach fusion, because it fell behind",
                several(lost, "report")
            ));
        }
        let present = ["simulated_sources", "live_sources"].map(|name| number(self.setting(name)));
        let on_the_way = if present == [0, 0] { 0 } else { taken / 100 };
        if losses["complete"] == true && unread > on_the_way {
            let killed = self
                .processes()
                .any(|process| process["kind"] == "fusion" && number(&process["restarts"]) > 0);
            all.push(format!(
                "{}{} published while fusion was not there to read them",
                if killed { "up to " } else { "" },
                were(unread, "report")
            ));
        }
    }

    fn about_fusion(&self, all: &mut Vec<String>) {
        let counted = |counter| of(&self.0["fusion"], counter);
        let dropped = counted(Counter::DroppedQueue) + counted(Counter::DroppedTable);
        if dropped > 0 {
            all.push(format!(
                "fusion had no room for {}: raise [fusion.capacity]",
                several(dropped, "report")
            ));
        }
        if counted(Counter::RejectedSchema) > 0 {
            all.push(format!(
                "fusion rejected {} of publishers that were built with another layout",
                several(counted(Counter::RejectedSchema), "slice")
            ));
        }
        let is_much = |late: u64, all: u64| late as f64 > 0.01 * all as f64;
        let (published, late) = (counted(Counter::Published), counted(Counter::DeadlineMisses));
        if self.has_latencies() && !self.by_time() {
            if is_much(late, published) {
                all.push(format!(
                    "{} of the states took longer through fusion than {}",
                    percent(late as f64, published as f64),
                    duration(float(self.setting("deadline_us")) * 1e3)
                ));
            }
            for stage in Stage::ALL.into_iter().filter(|stage| *stage != Stage::TakenToFused) {
                let figures = &self.0["stages"][stage.key()];
                let [states, late] = ["count", "deadline_misses"].map(|name| number(&figures[name]));
                if is_much(late, states) && !figures["deadline_us"].is_null() {
                    all.push(format!(
                        "{} of the states missed a deadline: {} took longer than {}",
                        percent(late as f64, states as f64),
                        stage.label(),
                        duration(float(&figures["deadline_us"]) * 1e3)
                    ));
                }
            }
        }
        if self.taken() > 0 && number(&self.0["picture"]["ever_confirmed"]) == 0 {
            all.push("no system track was confirmed".to_owned());
        }
    }

    fn about_accuracy(&self, all: &mut Vec<String>) {
        let accuracy = &self.0["accuracy"];
        if number(&accuracy["pictures"]) == 0 {
            return;
        }
        let held = float(&accuracy["held_once_share"]);
        if held < 0.95 {
            let held = percent(held, 1.0);
            all.push(format!(
                "only {held} of the targets in view were held by exactly one system track"
            ));
        }
        let wrong = number(&accuracy["identity_errors"]);
        all.extend((wrong > 0).then(|| format!("system tracks carried a wrong address {}", times(wrong))));
    }

    fn about_shares(&self, all: &mut Vec<String>) {
        let is_raised = |kind: AlarmKind| self.alarms().any(|alarm| alarm["alarm"] == kind.word());
        for source in self.sources() {
            let (name, adapter) = (words(&source["name"]), &source["adapter"]);
            let late = of(adapter, Counter::RejectedLate);
            let reports = of(adapter, Counter::Reports) + late;
            if late >= 5 && late as f64 > 0.01 * reports as f64 && !is_raised(AlarmKind::ReportsLate) {
                let share = percent(late as f64, reports as f64);
                let late = several(late, "report");
                all.push(format!("{late} of {name} ({share}) came too late and were not used"));
            }
            let [detections, scans] = [Counter::Detections, Counter::Scans].map(|counter| of(adapter, counter));
            let made = of(adapter, Counter::Published) + of(adapter, Counter::ReportsAhead);
            let is_idle = detections >= 200 && scans >= 10 && 10 * made < scans && source["sensor_of"].is_null();
            if is_idle && !is_raised(AlarmKind::TrackerIdle) {
                all.push(format!(
                    "the tracker of {name} made {} of tracks from {} in {}",
                    several(made, "report"),
                    several(detections, "detection"),
                    several(scans, "scan")
                ));
            }
        }
    }
}

/// Counters against each other.
impl Told<'_> {
    fn contradictions(&self) -> Vec<String> {
        let mut found = Vec::new();
        let mut equal = |what: &str, one: u64, other: u64| {
            found.extend((one != other).then(|| format!("{what}: {one} and {other}")));
        };
        let trackers: BTreeSet<u64> = self
            .sources()
            .filter_map(|source| source["sensor_of"].as_u64())
            .collect();
        for source in self.reporting() {
            let name = words(&source["name"]);
            let hop = self
                .hops()
                .find(|hop| hop["from"] == source["name"] && hop["to"] == "fusion");
            let Some(hop) = hop else {
                found.push(format!("{name}: not among the arrivals"));
                return found;
            };
            let of_hop = |member: &str| number(&hop[member]);
            equal(
                &format!("{name}: published, and taken by fusion, lost or unread"),
                of_hop("published").max(of_hop("taken") + of_hop("lost")),
                of_hop("taken") + of_hop("lost") + of_hop("unread"),
            );
            equal(
                &format!("{name}: published by its own count, and in the arrivals"),
                of(&source["adapter"], Counter::Published),
                of_hop("published"),
            );
            equal(
                &format!("{name}: taken by fusion's count, and in the arrivals"),
                of(&source["fusion"], Counter::Taken),
                of_hop("taken"),
            );
        }
        for (member, of_hop) in [("reports_lost", "lost"), ("reports_unread", "unread")] {
            let to_fusion = self.hops().filter(|hop| hop["to"] == "fusion");
            let all: u64 = to_fusion.map(|hop| number(&hop[of_hop])).sum();
            equal(
                &format!("{member}, and in the arrivals"),
                number(&self.0["losses"][member]),
                all,
            );
        }
        for stage in Stage::ALL {
            let key = stage.key();
            let all = |member: &str| number(&self.0["stages"][key][member]);
            let by_source = |member: &str| -> u64 {
                self.sources()
                    .map(|source| number(&source["stages"][key][member]))
                    .sum()
            };
            for member in ["count", "deadline_misses"] {
                equal(
                    &format!("{key}: {member} of all, and by source"),
                    all(member),
                    by_source(member),
                );
            }
        }
        let restarts: u64 = self.processes().map(|process| number(&process["restarts"])).sum();
        equal(
            "restarts, and by process",
            number(&self.0["restarts"]["total"]),
            restarts,
        );
        let fusion_restarts = self.processes().filter(|process| process["kind"] == "fusion");
        let is_whole = fusion_restarts.map(|process| number(&process["restarts"])).sum::<u64>() == 0;
        if is_whole && self.0["losses"]["complete"] == true {
            equal(
                "taken by fusion, and by source",
                of(&self.0["fusion"], Counter::Taken),
                self.taken(),
            );
        }
        let picture = |member: &str| number(&self.0["picture"][member]);
        let found_of = |holds: bool, what: String| (!holds).then_some(what);
        let states = Stage::ALL.map(|stage| number(&self.0["stages"][stage.key()]["count"]));
        let caused: u64 = self.sources().map(|source| number(&source["states"])).sum();
        found.extend(found_of(
            states.iter().all(|measured| *measured <= caused),
            format!("stages of {states:?} states, and {caused} states by source"),
        ));
        found.extend(found_of(
            picture("confirmed") + picture("coasted") <= picture("live_max"),
            format!("tracks in the end, and at most at a time: {}", self.0["picture"]),
        ));
        for source in self.sources() {
            let name = words(&source["name"]);
            let [joint, states] = ["joint_states", "states"].map(|member| number(&source[member]));
            found.extend(found_of(
                joint <= states,
                format!("{name}: {joint} of {states} states jointly"),
            ));
            let is_sensor = !source["sensor_of"].is_null();
            let by_fusion = of(&source["fusion"], Counter::Taken) + states;
            found.extend(found_of(
                !is_sensor || by_fusion == 0,
                format!("{name}: a sensor of a tracker, and a source of fusion"),
            ));
            let is_tracker = trackers.contains(&number(&source["number"]));
            found.extend(found_of(
                !is_sensor || !is_tracker,
                format!("{name}: a sensor of a tracker, and a tracker"),
            ));
            let known = &source["registration"];
            let text = words(&known["text"]);
            found.extend(found_of(
                text.contains("not compared with another source yet") == (float(&known["comparisons"]) <= 0.0),
                format!("{name}: {} comparisons, and \"{text}\"", known["comparisons"]),
            ));
            found.extend(found_of(
                text.contains("grossly off") != known["gross_error"].is_null(),
                format!("{name}: gross error {}, and \"{text}\"", known["gross_error"]),
            ));
        }
        for (key, figures) in self.0["stages"].as_object().into_iter().flatten() {
            let names = ["p50_ns", "p90_ns", "p99_ns", "p999_ns", "max_ns"];
            let values = names.map(|name| number(&figures[name]));
            found.extend(found_of(values.is_sorted(), format!("{key}: percentiles {values:?}")));
            let deadline_ns = float(&figures["deadline_us"]) * 1e3;
            let late = number(&figures["deadline_misses"]);
            found.extend(found_of(
                late == 0 || values[4] as f64 > deadline_ns,
                format!("{key}: {late} late, and the latest took {} ns", values[4]),
            ));
        }
        let fine = self.0["verdict"]["fine"] == true;
        let sentence = words(&self.0["verdict"]["sentence"]);
        found.extend(found_of(
            fine == self.concerns().is_empty() && sentence == self.verdict(),
            format!("the verdict ({fine}): {sentence}; by the counters: {}", self.verdict()),
        ));
        let written: BTreeSet<&str> = Counter::ALL.iter().map(|counter| counter.label()).collect();
        let counters = self.sources().map(|source| &source["adapter"]);
        for counters in counters.chain([&self.0["fusion"], &self.0["monitor"]]) {
            let unknown = counters.as_object().into_iter().flatten();
            let unknown = unknown.filter(|(label, _)| !written.contains(label.as_str()));
            found.extend(unknown.map(|(label, _)| format!("{label}: no counter")));
        }
        found
    }
}

/// Alarms.
impl Told<'_> {
    /// What is wrong with an alarm by the counters of the end, which only grow.
    fn untrue(&self, alarm: &Value) -> Option<String> {
        let (word, text) = (words(&alarm["alarm"]), words(&alarm["text"]));
        let Some(kind) = AlarmKind::ALL.iter().copied().find(|kind| kind.word() == word) else {
            return Some(format!("{word}: no such alarm"));
        };
        let Some(values) = values(kind.sentence(), text) else {
            return Some(format!("{word}: not its sentence: {text}"));
        };
        let source = self
            .sources()
            .find(|source| !words(&alarm["source"]).is_empty() && source["name"] == alarm["source"]);
        // Digits up to the first other word: "1,234 reports".
        let numbers = |name: &str| -> u64 {
            let value = values.get(name).map(String::as_str).unwrap_or_default();
            let value = value.split_whitespace().next().unwrap_or_default().replace(',', "");
            value.parse().unwrap_or(u64::MAX)
        };
        let by = |process: &str, counter: Counter| -> u64 {
            source.map_or_else(|| self.everywhere(counter), |source| of(&source[process], counter))
        };
        let at_most = |value: u64, counted: u64| (1..=counted).contains(&value);
        let is_true = match kind {
            AlarmKind::SourceSilent => source.is_some() && numbers("periods") >= 1,
            AlarmKind::SourceIsolated => at_most(numbers("bad"), by("fusion", Counter::RejectedClock)),
            AlarmKind::ReportsLate => at_most(numbers("bad"), by("adapter", Counter::RejectedLate)),
            AlarmKind::PositionFalse => at_most(numbers("bad"), by("fusion", Counter::RejectedFalsePosition)),
            AlarmKind::TrackerIdle => {
                let [detections, scans] = ["detections", "scans"].map(numbers);
                at_most(detections, by("adapter", Counter::Detections))
                    && at_most(scans, by("adapter", Counter::Scans))
                    && 10 * numbers("reports") < scans
            }
            AlarmKind::AlertStuck => at_most(numbers("count"), by("adapter", Counter::AdvisoriesStuck)),
            AlarmKind::SourceRefused => {
                let [refused, all] = ["refused", "all"].map(numbers);
                let counted: u64 = [CounterClass::Rejection, CounterClass::NetworkTrouble]
                    .into_iter()
                    .flat_map(Counter::of)
                    .map(|counter| self.everywhere(counter))
                    .sum();
                at_most(refused, counted) && refused <= all
            }
            AlarmKind::SenderUnknown => self.everywhere(Counter::RejectedSource) > 0,
            AlarmKind::EditionWrong => at_most(numbers("fitting"), by("adapter", Counter::BlocksOfOtherEdition)),
            AlarmKind::SamplesLost => at_most(
                numbers("count"),
                self.everywhere(Counter::Lost) + self.everywhere(Counter::RecordedLost),
            ),
            AlarmKind::DatagramsDropped => at_most(numbers("count"), self.everywhere(Counter::DatagramsDropped)),
            AlarmKind::SendFailed => at_most(numbers("count"), self.everywhere(Counter::SendFailures)),
            AlarmKind::RecordingFailed => at_most(numbers("count"), self.everywhere(Counter::RecordingFailures)),
            AlarmKind::PlatformJumped => at_most(numbers("count"), self.everywhere(Counter::PlatformJumps)),
            AlarmKind::LayoutMismatch => at_most(numbers("count"), self.everywhere(Counter::RejectedSchema)),
            AlarmKind::ReportQuarantined => at_most(numbers("count"), self.everywhere(Counter::Quarantined)),
            AlarmKind::CapacityReached => {
                let full = [Counter::DroppedQueue, Counter::DroppedTable, Counter::TracksDropped];
                let full: u64 = full.into_iter().map(|counter| self.everywhere(counter)).sum();
                at_most(numbers("count"), full)
            }
            AlarmKind::ProcessRestarted => {
                let restarted = self.processes().find(|process| process["name"] == alarm["process"]);
                restarted.is_some_and(|process| at_most(numbers("times"), number(&process["restarts"])))
            }
            // Levels and what the machine is like: no counter of the report has them.
            AlarmKind::ProcessDown
            | AlarmKind::ProcessHung
            | AlarmKind::LinesRefused
            | AlarmKind::DataOff
            | AlarmKind::MachineClockOff
            | AlarmKind::ClocksDiffer
            | AlarmKind::ClockOff
            | AlarmKind::RecordingIncomplete
            | AlarmKind::PlatformSilent
            | AlarmKind::PlatformFar
            | AlarmKind::SecondPublisher
            | AlarmKind::FusionTakenOver
            | AlarmKind::MemoryCorrupt
            | AlarmKind::CheckpointUnkept
            | AlarmKind::PeerMissing
            | AlarmKind::LostOnTheWay
            | AlarmKind::HostClockOff
            | AlarmKind::DiskLow
            | AlarmKind::MemoryLow
            | AlarmKind::CertificateExpires
            | AlarmKind::GrossError
            | AlarmKind::SourceOff
            | AlarmKind::SourcesContradict
            | AlarmKind::NeverJoined
            | AlarmKind::BiasChanged
            | AlarmKind::DetectionFell
            | AlarmKind::AccuracyOverstated => true,
        };
        (!is_true).then(|| format!("{word}, which the counters do not bear: {text}"))
    }

    /// Sum over everything that counts.
    fn everywhere(&self, counter: Counter) -> u64 {
        let sources = self
            .sources()
            .flat_map(|source| ["adapter", "fusion", "recorder"].map(|by| &source[by]));
        let others = list(&self.0["others"]).map(|process| &process["counters"]);
        let all = sources.chain(others).chain([&self.0["fusion"], &self.0["monitor"]]);
        all.map(|counters| of(counters, counter)).sum()
    }
}

/// The values that stand in a text in the places of a sentence's names in braces, of names side by side the same;
/// `None` if it is not the sentence.
fn values(sentence: &str, text: &str) -> Option<BTreeMap<String, String>> {
    let mut values = BTreeMap::new();
    let mut parts = sentence.split('{').peekable();
    let mut rest = text.strip_prefix(parts.next()?)?;
    let mut names = Vec::new();
    while let Some(part) = parts.next() {
        let (name, literal) = part.split_once('}')?;
        names.push(name);
        let is_last = parts.peek().is_none();
        if literal.is_empty() && !is_last {
            continue;
        }
        let end = match is_last {
            true => rest.strip_suffix(literal)?.len(),
            false => rest.find(literal)?,
        };
        let value = &rest[..end];
        values.extend(names.drain(..).map(|name| (name.to_owned(), value.to_owned())));
        rest = &rest[end + literal.len()..];
    }
    rest.is_empty().then_some(values)
}
