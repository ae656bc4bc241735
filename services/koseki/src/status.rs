//! `koseki status`: the instances on this machine.
//!
//! The command joins each running instance as a reader, takes the messages of two rounds of health messages, and
//! leaves. Rates are the differences between the two rounds.

use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;
use std::time::Duration;

use bus::{Bus, BusError, InstanceEntry, Root, SharedMemory};
use messages::{Counter, OrderState, ProcessKind, Registration};
use observed::{
    ChildState, Deployment, HealthBook, LatestHealth, NO_MESSAGE, ObservedProcess, RefusedInput, StandingAlarm, remark,
};
use runtime::clock::{instant, mono_ns};
use serde::Serialize;
use telemetry::table::{Align, TextTable};

use crate::args::Status;
use crate::config::Config;
use crate::{instances, order};

/// How long to listen: health messages come five times a second.
const LISTEN: Duration = Duration::from_millis(700);
/// Pause between two looks: queues hold more than comes in this time.
const PAUSE: Duration = Duration::from_millis(20);
/// Name under which this command joins an instance.
const OWN_NAME: &str = "status";

/// Prints every instance, or the named instance.
///
/// # Errors
/// If the named instance does not run, the instances cannot be listed, or shared memory fails.
pub(crate) fn run(status: &Status) -> anyhow::Result<()> {
    let instances = match &status.instance {
        Some(name) => {
            let root = instances::named(name)?;
            let mut listed = Root::list(root.base())?;
            listed.retain(|instance| instance.root == root);
            listed
        }
        None => Root::list(bus::base::find())?,
    };
    let mut found: Vec<InstanceStatus> = instances.iter().map(InstanceStatus::of).collect::<Result<_, _>>()?;
    let is_asked = |name: &str| status.instance.as_deref().is_none_or(|asked| asked == name);
    let ended = launcher::ended_instances(&bus::base::find());
    let ended = ended.into_iter().filter(|ended| is_asked(&ended.instance));
    for ended in ended.filter(|ended| !instances.iter().any(|one| one.root.instance() == ended.instance)) {
        found.push(InstanceStatus::ended(ended)?);
    }
    if let (Some(name), true) = (&status.instance, found.is_empty()) {
        anyhow::bail!(instances::nothing_runs_as(name));
    }
    if status.json {
        return crate::print(&(serde_json::to_string_pretty(&found)? + "\n"));
    }
    if found.iter().all(|status| status.state == InstanceState::Ended) {
        crate::print(&format!("nothing runs in {}\n", bus::base::find().display()))?;
    }
    crate::print(&found.iter().map(InstanceStatus::text).collect::<String>())
}

/// Known facts about an instance.
#[derive(Debug, Serialize)]
struct InstanceStatus {
    instance: String,
    /// Folder of the instance.
    folder: PathBuf,
    state: InstanceState,
    /// Address of the picture for a browser; `None` without a display.
    picture: Option<String>,
    /// Process number of the launcher, while it runs.
    pid: Option<u32>,
    /// File of the last end, from which the next start goes on.
    #[serde(skip_serializing_if = "Option::is_none")]
    goes_on_from: Option<PathBuf>,
    processes: Vec<StatusRow>,
    registrations: Vec<RegistrationStatus>,
    /// Input that was refused last.
    refused: Vec<RefusedInput>,
    alarms: Vec<AlarmStatus>,
    orders: Vec<OrderStatusLine>,
}

/// An order in force.
#[derive(Debug, Serialize)]
struct OrderStatusLine {
    number: u32,
    order: String,
    operator: String,
}

/// How an instance is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum InstanceState {
    Runs,
    StartsOrStops,
    /// Running, with implausible content in the shared memory.
    Unreadable,
    /// Not running; the previous run was killed.
    Killed,
    /// Not running; a start was refused.
    Refused,
    /// Ended in order; the next start continues.
    Ended,
}

/// How far the reports of a source lie off.
#[derive(Debug, Serialize)]
struct RegistrationStatus {
    /// Number of the source, as in the files from 1.
    source: u16,
    name: String,
    text: String,
    /// Lines of `[source.correction]` that hold the estimated biases; empty without estimated biases.
    correction: Vec<String>,
}

/// An alarm that stands.
#[derive(Debug, Serialize)]
struct AlarmStatus {
    alarm: &'static str,
    severity: &'static str,
    text: String,
    remedy: &'static str,
}

impl InstanceStatus {
    fn of(instance: &InstanceEntry) -> anyhow::Result<Self> {
        let mut status = Self {
            instance: instance.root.instance().to_owned(),
            folder: instance.root.path().to_owned(),
            state: InstanceState::Runs,
            picture: None,
            pid: instance.pid,
            goes_on_from: None,
            processes: Vec::new(),
            registrations: Vec::new(),
            refused: Vec::new(),
            alarms: Vec::new(),
            orders: Vec::new(),
        };
        if !instance.runs {
            // A refused start leaves its lock at most, a run leaves its folder.
            status.state = match instance.root.path().exists() {
                true => InstanceState::Killed,
                false => InstanceState::Refused,
            };
            return Ok(status);
        }
        // Reading overwritten memory may end in a panic of the underlying library.
        let Ok(listened) = without_panic(|| listen(&instance.root)) else {
            status.state = InstanceState::Unreadable;
            return Ok(status);
        };
        match listened {
            Ok((observed, joined)) => {
                let now_ns = mono_ns();
                status.processes = rows(observed.book(), &joined, now_ns);
                status.refused = observed.refused_input();
                status.picture = deployment::page_of(instance.root.path());
                let sources = observed.sources().into_iter();
                let compared = sources.filter(|source| {
                    let known = &source.registration;
                    known.comparisons > 0.0 || known.stamp_step_s > 0.0
                });
                let config = Config::of_running(instance.root.path()).ok();
                status.registrations = compared
                    .map(|source| RegistrationStatus {
                        source: source.number + 1,
                        name: source.name.clone(),
                        text: source.registration.to_string(),
                        correction: correction(config.as_ref(), source.number, &source.registration),
                    })
                    .collect();
                let alarms = observed.alarms(now_ns).iter();
                status.alarms = alarms
                    .map(|alarm| AlarmStatus::from(StandingAlarm::from(alarm)))
                    .collect();
                let line = |state: &OrderState| OrderStatusLine {
                    number: state.number,
                    order: order::words(&state.order, config.as_ref()),
                    operator: state.order.operator().to_owned(),
                };
                status.orders = observed.orders_in_force().map(line).collect();
            }
            Err(BusError::NotRunning { .. } | BusError::NoSuchTopic { .. }) => {
                status.state = InstanceState::StartsOrStops;
            }
            Err(error) => return Err(error.into()),
        }
        Ok(status)
    }

    fn ended(ended: launcher::EndedInstance) -> anyhow::Result<Self> {
        Ok(Self {
            folder: instances::named(&ended.instance)?.path().to_owned(),
            instance: ended.instance,
            state: InstanceState::Ended,
            picture: None,
            pid: None,
            goes_on_from: Some(ended.file),
            processes: Vec::new(),
            registrations: Vec::new(),
            refused: Vec::new(),
            alarms: Vec::new(),
            orders: Vec::new(),
        })
    }

    fn text(&self) -> String {
        let (name, folder) = (&self.instance, self.folder.display());
        let pid = self.pid.map_or_else(|| "?".to_owned(), |pid| pid.to_string());
        let mut text = match self.state {
            InstanceState::Runs => format!(
                "instance {name}: run by process {pid}, in {folder}\n{}",
                table(&self.processes)
            ),
            InstanceState::StartsOrStops => format!("instance {name}: process {pid} is starting or stopping it\n"),
            InstanceState::Unreadable => format!(
                "instance {name}: process {pid} runs it, and its shared memory cannot be read: look again when it has \
                 been rebuilt\n"
            ),
            InstanceState::Killed => format!(
                "instance {name}: does not run; an earlier run was killed, and the next start removes what it left in {folder}\n"
            ),
            InstanceState::Refused => format!("instance {name}: does not run; a start of it was refused\n"),
            InstanceState::Ended => format!("instance {name}: has ended\n"),
        };
        if let Some(address) = &self.picture {
            text.push_str(&format!("  the picture is at {address}\n"));
        }
        if let Some(file) = &self.goes_on_from {
            text.push_str(&format!("  the next start goes on from {}\n", file.display()));
        }
        for known in &self.registrations {
            text.push_str(&format!("  registration of {}: {}\n", known.name, known.text));
            if !known.correction.is_empty() {
                let lines = known.correction.join("\n      ");
                text.push_str(&format!(
                    "    to keep it, write into the source's table:\n      [source.correction]\n      {lines}\n"
                ));
            }
        }
        for refused in &self.refused {
            text.push_str(&format!("  refused of {}: {}\n", refused.of, refused.text));
        }
        for alarm in &self.alarms {
            let AlarmStatus {
                severity, text: what, ..
            } = alarm;
            text.push_str(&format!("  alarm, {severity}: {what}\n    {}\n", alarm.remedy));
        }
        for OrderStatusLine {
            number,
            order,
            operator,
        } in &self.orders
        {
            text.push_str(&format!("  order {number} of {operator}: {order}\n"));
        }
        text
    }
}

/// Returns the lines of `[source.correction]` that replace the configured correction and the estimated biases of a
/// source; none where nothing is estimated.
fn correction(config: Option<&Config>, source: u16, known: &Registration) -> Vec<String> {
    let settings = config.and_then(|config| config.engine.sources.get(usize::from(source)));
    let configured = settings.and_then(|settings| settings.correction).unwrap_or_default();
    let lines = configured.with_estimated(known).lines();
    if lines == configured.lines() { Vec::new() } else { lines }
}

impl From<StandingAlarm> for AlarmStatus {
    fn from(row: StandingAlarm) -> Self {
        Self {
            alarm: row.alarm,
            severity: row.severity,
            text: row.text,
            remedy: row.remedy,
        }
    }
}

/// Losses and refusals of links, in a few words.
const LOSSES: [(Counter, &str); 6] = [
    (Counter::LostOnTheWay, "lost on the way"),
    (Counter::Unsent, "unsent"),
    (Counter::Conflated, "conflated"),
    (Counter::MessagesRejected, "rejected"),
    (Counter::RejectedSchema, "of another layout"),
    (Counter::RequestsRejected, "connections refused"),
];

/// Result of `work`; `Err` after a panic, which is not printed.
fn without_panic<T>(work: impl FnOnce() -> T) -> Result<T, ()> {
    let told = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    panic::set_hook(told);
    result.map_err(drop)
}

/// Returns the state of a running instance, and the processes that have joined.
fn listen(root: &Root) -> Result<(Deployment, Vec<bus::MemberProcess>), BusError> {
    let bus = Bus::<SharedMemory>::open(root, OWN_NAME)?;
    let now_ns = || mono_ns() as u64;
    let mut health = bus.subscriber(&messages::health(), now_ns)?;
    let mut alarms = bus.subscriber(&messages::alarms(), now_ns)?;
    let mut orders = bus.subscriber(&messages::order_states(), now_ns)?;
    let mut observed = Deployment::default();
    let start = instant();
    while instant() - start < LISTEN {
        health.take(usize::MAX, |_, slice| {
            slice.iter().for_each(|health| observed.take_health(health))
        })?;
        alarms.take(usize::MAX, |header, slice| observed.take_alarms(header, slice))?;
        orders.take(usize::MAX, |_, slice| observed.take_orders(slice))?;
        std::thread::sleep(PAUSE);
    }
    observed.close_interval();
    let mut joined = root.processes()?;
    joined.retain(|process| process.pid != std::process::id());
    Ok((observed, joined))
}

/// Returns the rows of the launcher and its children, then of other processes in the instance.
fn rows(book: &HealthBook, joined: &[bus::MemberProcess], now_ns: i64) -> Vec<StatusRow> {
    let processes = book.processes(&[], now_ns);
    let is_launcher = |process: &&ObservedProcess| process.kind == Some(ProcessKind::Launcher);
    let of_itself = |process: &ObservedProcess| {
        Some(StatusRow::of_process(
            process,
            book.whole(process.kind?, &process.name)?,
            book,
        ))
    };
    let launcher = processes.iter().filter(is_launcher).filter_map(of_itself);
    let mut rows: Vec<StatusRow> = launcher.collect();
    rows.extend(book.children().map(|child| {
        let is_own = |process: &&ObservedProcess| process.kind.is_some() && process.pid == child.pid;
        let own = processes.iter().find(is_own).filter(|own| own.pid.is_some());
        StatusRow::of_child(&child, own.and_then(of_itself))
    }));
    let is_listed = |rows: &[StatusRow], pid| rows.iter().any(|row| row.pid == pid);
    for process in &processes {
        if process.kind.is_some() && !is_listed(&rows, process.pid) {
            rows.extend(of_itself(process));
        }
    }
    for process in joined {
        if !is_listed(&rows, Some(process.pid)) {
            rows.push(StatusRow {
                name: process.name.clone(),
                pid: Some(process.pid),
                note: NO_MESSAGE.to_owned(),
                ..StatusRow::default()
            });
        }
    }
    rows
}

/// A line per process.
fn table(rows: &[StatusRow]) -> String {
    // Numbers have room for eight digits, so that columns keep their places between two looks.
    let mut table = TextTable::new(&[
        ("process", Align::Left),
        ("     pid", Align::Right),
        ("state   ", Align::Left),
        ("restarts", Align::Right),
        ("    in/s", Align::Right),
        ("   out/s", Align::Right),
        ("note", Align::Left),
    ]);
    for row in rows {
        table.row(row.cells());
    }
    table.to_string().lines().map(|line| format!("  {line}\n")).collect()
}

/// A process.
#[derive(Debug, Default, Serialize)]
struct StatusRow {
    name: String,
    pid: Option<u32>,
    state: Option<String>,
    /// `None` for a process without restarts by a launcher.
    restarts: Option<u32>,
    /// Samples or records taken per second; `None` without any, or if unknown.
    taken_per_s: Option<f64>,
    /// The same for published, written or sent samples or records.
    published_per_s: Option<f64>,
    note: String,
}

impl StatusRow {
    fn cells(&self) -> [String; 7] {
        let dash = || "-".to_owned();
        let number = |value: Option<u32>| value.map_or_else(dash, |value| value.to_string());
        let rate = |value: Option<f64>| value.map_or_else(dash, |value| format!("{value:.0}"));
        [
            self.name.clone(),
            number(self.pid),
            self.state.clone().unwrap_or_else(dash),
            number(self.restarts),
            rate(self.taken_per_s),
            rate(self.published_per_s),
            self.note.clone(),
        ]
    }

    /// Row of a child of the launcher, with the child's `own` row for a child with health messages.
    fn of_child(child: &ChildState<'_>, own: Option<Self>) -> Self {
        let own = own.unwrap_or_default();
        Self {
            name: child.name.to_owned(),
            pid: child.pid,
            state: Some(child.life.word().to_owned()),
            restarts: Some(child.restarts),
            note: remark(child.last_end, &own.note),
            ..own
        }
    }

    /// Row of a process from the process's own messages.
    fn of_process(process: &ObservedProcess, latest: LatestHealth<'_>, book: &HealthBook) -> Self {
        let (taken, published) = match process.kind {
            Some(ProcessKind::Adapter) => (Counter::Records, Counter::Published),
            Some(ProcessKind::Recorder) => (Counter::Taken, Counter::RowsWritten),
            Some(ProcessKind::Gateway | ProcessKind::Simulator) => (Counter::Taken, Counter::RecordsSent),
            Some(ProcessKind::Display) => (Counter::Taken, Counter::PicturesSent),
            Some(ProcessKind::Link) => (Counter::Published, Counter::RecordsSent),
            _ => (Counter::Taken, Counter::Published),
        };
        let counters = latest.counters();
        let per_s = |counter: Counter| (counters[counter] > 0).then(|| latest.per_s(counter)).flatten();
        let peers = match process.kind {
            Some(ProcessKind::Link) => of_peers(book, latest),
            _ => String::new(),
        };
        Self {
            name: process.name.clone(),
            pid: process.pid,
            state: Some(process.state.to_string()),
            restarts: None,
            taken_per_s: per_s(taken),
            published_per_s: per_s(published),
            note: match peers.is_empty() {
                true => latest.note().to_owned(),
                false => peers,
            },
        }
    }
}

/// Returns the notes of a link about peers, with losses and refusals; empty without peers.
fn of_peers(book: &HealthBook, link: LatestHealth<'_>) -> String {
    let mut notes: Vec<String> = book
        .parts(ProcessKind::Link, link.name())
        .map(|peer| peer.note().to_owned())
        .collect();
    if !notes.is_empty() {
        let counters = link.counters();
        let losses = LOSSES.iter().filter(|(counter, _)| counters[*counter] > 0);
        notes.extend(losses.map(|(counter, what)| format!("{} {what}", counters[*counter])));
    }
    notes.join(", ")
}

#[cfg(test)]
mod tests {
    use alarms::AlarmKind;
    use messages::{Alarm, AlarmSeverity, Health, LifeState};

    use super::*;

    fn said(kind: ProcessKind, name: &str, pid: u32, said_ns: i64, published: u64) -> Health {
        let mut health = Health {
            kind: kind as u8,
            process_id: pid,
            said_ns,
            life: LifeState::Running as u8,
            ..Health::default()
        };
        health.counters[Counter::Published] = published;
        health.with_name(name)
    }

    #[test]
    fn children_others_and_silent_processes_are_listed_with_rates_and_restarts() {
        let mut observed = Deployment::default();
        observed.take_health(&said(ProcessKind::Launcher, "launcher", 1, 0, 0));
        let mut child = said(ProcessKind::Launcher, "fusion", 2, 0, 0).with_note("was killed by SIGKILL");
        child.restarts = 3;
        observed.take_health(&child);
        observed.take_health(&said(ProcessKind::Fusion, "fusion", 2, 0, 100));
        observed.take_health(&said(ProcessKind::Fusion, "fusion", 2, 500_000_000, 350));
        observed.take_health(&said(ProcessKind::Monitor, "second", 9, 0, 0));
        observed.close_interval();
        let subscriber = bus::MemberProcess {
            pid: 10,
            name: "subscribe".to_owned(),
        };
        let table = table(&rows(observed.book(), &[subscriber], 0));
        let lines: Vec<Vec<&str>> = table.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(lines.len(), 5, "{table}");
        let title = "  process         pid  state     restarts      in/s     out/s  note\n";
        assert!(table.starts_with(title), "{table}");
        assert_eq!(lines[1][..4], ["launcher", "1", "running", "-"]);
        assert_eq!(lines[2][..6], ["fusion", "2", "running", "3", "-", "500"]);
        let child =
            "  fusion            2  running          3         -       500  the last one was killed by SIGKILL\n";
        assert!(table.contains(child), "{table}");
        assert_eq!(lines[3][..2], ["second", "9"]);
        assert_eq!(lines[4][..2], ["subscribe", "10"]);
    }

    #[test]
    fn a_link_tells_of_all_its_peers_and_of_losses() {
        let mut observed = Deployment::default();
        let mut link = said(ProcessKind::Link, "in", 5, 0, 0).with_note("north is not there");
        link.counters[Counter::LostOnTheWay] = 12;
        let peer = |source: u16, note: &str| Health {
            source,
            ..said(ProcessKind::Link, "in", 5, 0, 0).with_note(note)
        };
        for _ in 0..2 {
            observed.take_health(&link);
            observed.take_health(&peer(0, "north is not there"));
            observed.take_health(&peer(1, "west 1.0 ms away"));
        }
        let notes: Vec<String> = rows(observed.book(), &[], 0).into_iter().map(|row| row.note).collect();
        assert_eq!(notes, ["north is not there, west 1.0 ms away, 12 lost on the way"]);
    }

    #[test]
    fn text_and_json_say_the_same() {
        let alarm = Alarm {
            code: AlarmKind::DiskLow.code(),
            severity: AlarmSeverity::Major.code(),
            ..Alarm::default()
        };
        let status = InstanceStatus {
            instance: "demo".to_owned(),
            folder: "/run/koseki/demo".into(),
            state: InstanceState::Runs,
            picture: Some("http://127.0.0.1:8900/".to_owned()),
            pid: Some(7),
            goes_on_from: None,
            processes: Vec::new(),
            registrations: vec![RegistrationStatus {
                source: 3,
                name: "radar-west".to_owned(),
                text: "-1.5 m east".to_owned(),
                correction: vec!["east_m = -1.5".to_owned(), "time_s = 0.250".to_owned()],
            }],
            refused: vec![RefusedInput {
                of: "sea".to_owned(),
                text: "07:08:09: line 2, column px: \"\" is empty; write a number".to_owned(),
            }],
            alarms: vec![AlarmStatus::from(StandingAlarm::from(
                &alarm.with_text("12 MB are left."),
            ))],
            orders: Vec::new(),
        };
        let text = status.text();
        assert!(
            text.starts_with("instance demo: run by process 7, in /run/koseki/demo\n"),
            "{text}"
        );
        assert!(
            text.contains("\n  the picture is at http://127.0.0.1:8900/\n"),
            "{text}"
        );
        let lines = "  registration of radar-west: -1.5 m east\n    to keep it, write into the source's table:\n      \
                     [source.correction]\n      east_m = -1.5\n      time_s = 0.250\n";
        assert!(text.contains(lines), "{text}");
        let refused = "\n  refused of sea: 07:08:09: line 2, column px: \"\" is empty; write a number\n";
        assert!(text.contains(refused), "{text}");
        let remedy = AlarmKind::DiskLow.remedy();
        let expected = format!("  alarm, major: 12 MB are left.\n    {remedy}\n");
        assert!(text.ends_with(&expected), "{text}");
        let value = serde_json::to_value(&status).unwrap();
        assert_eq!(value["refused"][0]["of"], "sea");
        assert_eq!(value["alarms"][0]["severity"], "major");
        assert_eq!((&value["state"], &value["pid"]), (&"runs".into(), &7.into()));
        assert_eq!(value["registrations"][0]["source"], 3);
        assert_eq!(value["registrations"][0]["name"], "radar-west");
        let refused = InstanceStatus {
            state: InstanceState::Refused,
            ..status
        };
        assert!(!refused.text().contains("killed"), "{}", refused.text());
    }
}
