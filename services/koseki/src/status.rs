//! `koseki status`: running instances of this machine.
//!
//! The command is a normal reader: it joins each running instance, takes two rounds of health messages, and leaves.
//! Rates are the differences between the two rounds.

use std::collections::BTreeMap;
use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;
use std::time::Duration;

use alarms::{AlarmKind, Present};
use bus::{Bus, BusError, Instance, Process, Root, SharedMemory};
use configuration::Config;
use messages::{Alarm, AlarmSeverity, Counter, Health, NO_SOURCE, OrderState, OrderStatus, ProcessKind, Registration};
use runtime::clock::{instant, mono_ns};
use serde::Serialize;
use telemetry::table::{Align, Table};

use crate::args::Status;
use crate::{instances, order};

/// How long to listen: health messages come five times a second.
const LISTEN: Duration = Duration::from_millis(700);
/// Pause between two looks: queues hold more than comes in this time.
const PAUSE: Duration = Duration::from_millis(20);
/// Name under which this command joins an instance.
const OWN_NAME: &str = "status";

/// Prints every instance, or the one that is named.
///
/// # Errors
/// If the named one does not run, the instances cannot be listed, or shared memory fails.
pub(crate) fn run(status: &Status) -> anyhow::Result<()> {
    let instances = match &status.instance {
        Some(name) => {
            let root = instances::named(name)?;
            let mut listed = Root::list(root.base())?;
            listed.retain(|instance| instance.root == root);
            if listed.is_empty() {
                anyhow::bail!(instances::nothing_runs_as(name));
            }
            listed
        }
        None => Root::list(bus::base::find())?,
    };
    let found: Vec<InstanceStatus> = instances.iter().map(InstanceStatus::of).collect::<Result<_, _>>()?;
    if status.json {
        return crate::print(&(serde_json::to_string_pretty(&found)? + "\n"));
    }
    if found.is_empty() {
        return crate::print(&format!("nothing runs in {}\n", bus::base::find().display()));
    }
    crate::print(&found.iter().map(InstanceStatus::text).collect::<String>())
}

/// State of an instance.
#[derive(Debug, Serialize)]
struct InstanceStatus {
    instance: String,
    /// Where it lives.
    folder: PathBuf,
    state: InstanceState,
    /// Process number of the launcher, while it runs.
    pid: Option<u32>,
    processes: Vec<Row>,
    registrations: Vec<RegistrationStatus>,
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
    /// Running, with invalid data in shared memory.
    Unreadable,
    /// It does not run, and the run before was killed.
    Killed,
    /// It does not run, and a start was refused.
    Refused,
}

/// How far the reports of a source lie off.
#[derive(Debug, Serialize)]
struct RegistrationStatus {
    /// Number of the source, as in the files from 1.
    source: u16,
    text: String,
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
    fn of(instance: &Instance) -> anyhow::Result<Self> {
        let mut status = Self {
            instance: instance.root.instance().to_owned(),
            folder: instance.root.path().to_owned(),
            state: InstanceState::Runs,
            pid: instance.pid,
            processes: Vec::new(),
            registrations: Vec::new(),
            alarms: Vec::new(),
            orders: Vec::new(),
        };
        if !instance.runs {
            // A rejected start leaves at most its lock, a run leaves its folder.
            status.state = match instance.root.path().exists() {
                true => InstanceState::Killed,
                false => InstanceState::Refused,
            };
            return Ok(status);
        }
        // Reading overwritten memory may cause a panic in the underlying library.
        let Ok(listened) = without_panic(|| listen(&instance.root)) else {
            status.state = InstanceState::Unreadable;
            return Ok(status);
        };
        match listened {
            Ok(heard) => {
                status.processes = rows(&heard.speakers, &heard.processes);
                status.registrations = heard
                    .registrations
                    .iter()
                    .map(|(source, known)| RegistrationStatus {
                        source: source + 1,
                        text: known.to_string(),
                    })
                    .collect();
                status.alarms = heard.alarms.iter().map(AlarmStatus::of).collect();
                let config = Config::of_running(instance.root.path()).ok();
                let line = |state: &OrderState| OrderStatusLine {
                    number: state.number,
                    order: order::words(&state.order, config.as_ref()),
                    operator: state.order.operator().to_owned(),
                };
                status.orders = heard.orders.iter().map(line).collect();
            }
            Err(BusError::NotRunning { .. } | BusError::NoSuchTopic { .. }) => {
                status.state = InstanceState::StartsOrStops;
            }
            Err(error) => return Err(error.into()),
        }
        Ok(status)
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
                "instance {name}: process {pid} runs it, but its shared memory is unreadable: try again after the \
                 rebuild\n"
            ),
            InstanceState::Killed => format!(
                "instance {name}: does not run; an earlier run was killed; the next start removes its remains in {folder}\n"
            ),
            InstanceState::Refused => format!("instance {name}: does not run; a start of it was refused\n"),
        };
        for known in &self.registrations {
            text.push_str(&format!("  registration: source {}: {}\n", known.source, known.text));
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

impl AlarmStatus {
    fn of(alarm: &Alarm) -> Self {
        let kind = AlarmKind::from_code(alarm.code);
        Self {
            alarm: kind.map_or("?", AlarmKind::word),
            severity: alarm.severity().map_or("?", AlarmSeverity::word),
            text: alarm.text().to_owned(),
            remedy: kind.map_or("", AlarmKind::remedy),
        }
    }
}

/// First and last message of a process, or of the launcher about the process.
#[derive(Clone, Debug)]
struct Heard {
    first: Health,
    last: Health,
    /// A link's notes about each of its peers.
    peers: BTreeMap<u16, String>,
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

/// Messages received in the two rounds, and members of the instance.
struct Listened {
    speakers: Vec<Heard>,
    /// By number of the source.
    registrations: BTreeMap<u16, Registration>,
    processes: Vec<Process>,
    /// Alarms that stand, the worst first.
    alarms: Vec<Alarm>,
    /// Orders in force.
    orders: Vec<OrderState>,
}

/// Returns the result of `work`; `Err` after a panic, without a message.
fn without_panic<T>(work: impl FnOnce() -> T) -> Result<T, ()> {
    let told = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    panic::set_hook(told);
    result.map_err(drop)
}

fn listen(root: &Root) -> Result<Listened, BusError> {
    let bus = Bus::<SharedMemory>::open(root, OWN_NAME)?;
    let mut subscriber = bus.subscriber(&messages::health(), || mono_ns() as u64)?;
    let mut of_alarms = bus.subscriber(&messages::alarms(), || mono_ns() as u64)?;
    let mut of_orders = bus.subscriber(&messages::order_states(), || mono_ns() as u64)?;
    let mut orders = Vec::new();
    let mut present = Present::default();
    let mut speakers: Vec<Heard> = Vec::new();
    let mut registrations = BTreeMap::new();
    let start = instant();
    while instant() - start < LISTEN {
        subscriber.take(usize::MAX, |_, said| {
            for health in said {
                let whole = health.source == NO_SOURCE || is_launcher(health);
                if whole || health.kind() == Some(ProcessKind::Link) {
                    note(&mut speakers, health);
                } else if health.registration.comparisons > 0.0 {
                    registrations.insert(health.source, health.registration);
                }
            }
        })?;
        of_alarms.take(usize::MAX, |header, slice| present.hear(header, slice))?;
        of_orders.take(usize::MAX, |_, slice| orders = slice.to_vec())?;
        std::thread::sleep(PAUSE);
    }
    let mut processes = root.processes()?;
    processes.retain(|process| process.pid != std::process::id());
    orders.retain(|state| state.status() == Some(OrderStatus::InForce));
    Ok(Listened {
        speakers,
        registrations,
        processes,
        alarms: present.at(mono_ns()).unwrap_or_default().to_vec(),
        orders,
    })
}

fn note(heard: &mut Vec<Heard>, health: &Health) {
    // The launcher names its children; a child's process number changes.
    let same = |other: &&mut Heard| {
        let other = &other.last;
        (other.kind, other.name) == (health.kind, health.name)
            && (is_launcher(health) || other.process_id == health.process_id)
    };
    let is_of_a_peer = !is_launcher(health) && health.source != NO_SOURCE;
    match heard.iter_mut().find(same) {
        Some(known) if is_of_a_peer => drop(known.peers.insert(health.source, health.note().to_owned())),
        Some(known) => {
            known.last = *health;
            known.peers.clear();
        }
        None if is_of_a_peer => {}
        None => heard.push(Heard {
            first: *health,
            last: *health,
            peers: BTreeMap::new(),
        }),
    }
}

fn is_launcher(health: &Health) -> bool {
    health.kind == ProcessKind::Launcher as u8
}

/// Returns rows: first the launcher and its children, then other members of the instance.
fn rows(heard: &[Heard], processes: &[Process]) -> Vec<Row> {
    let mut rows = Vec::new();
    let launched: Vec<&Heard> = heard.iter().filter(|each| is_launcher(&each.last)).collect();
    for each in &launched {
        let own = heard
            .iter()
            .find(|own| !is_launcher(&own.last) && own.last.process_id == each.last.process_id);
        rows.push(Row::of_child(&each.last, own));
    }
    let others = heard.iter().filter(|each| {
        launched
            .iter()
            .all(|child| child.last.process_id != each.last.process_id)
    });
    rows.extend(others.map(Row::of_process));
    let silent = processes
        .iter()
        .filter(|process| heard.iter().all(|each| each.last.process_id != process.pid));
    rows.extend(silent.map(|process| Row {
        name: process.name.clone(),
        pid: Some(process.pid),
        note: "says nothing of itself".to_owned(),
        ..Row::default()
    }));
    rows
}

/// One line per process.
fn table(rows: &[Row]) -> String {
    // Numbers have room for eight digits, so that columns stay in place from call to call.
    let mut table = Table::new(&[
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

/// One process.
#[derive(Debug, Default, Serialize)]
struct Row {
    name: String,
    pid: Option<u32>,
    state: Option<&'static str>,
    /// `None` for a process without restarts.
    restarts: Option<u32>,
    /// Samples or records taken per second; `None` if there were none, or it is not known.
    taken_per_s: Option<f64>,
    /// Rate of published, written or sent samples.
    published_per_s: Option<f64>,
    note: String,
}

impl Row {
    fn cells(&self) -> [String; 7] {
        let dash = || "-".to_owned();
        let number = |value: Option<u32>| value.map_or_else(dash, |value| value.to_string());
        let rate = |value: Option<f64>| value.map_or_else(dash, |value| format!("{value:.0}"));
        [
            self.name.clone(),
            number(self.pid),
            self.state.unwrap_or("-").to_owned(),
            number(self.restarts),
            rate(self.taken_per_s),
            rate(self.published_per_s),
            self.note.clone(),
        ]
    }

    /// Row of a child, from the launcher's and, if present, the child's own messages.
    fn of_child(child: &Health, own: Option<&Heard>) -> Self {
        let is_launcher_itself = child.name() == ProcessKind::Launcher.word();
        let of_itself = own.map(Self::of_process).unwrap_or_default();
        let last_end = match child.note() {
            "" => String::new(),
            end => format!("the last one {end}"),
        };
        let notes = [of_itself.note, last_end];
        let notes: Vec<String> = notes.into_iter().filter(|note| !note.is_empty()).collect();
        Self {
            name: child.name().to_owned(),
            pid: Some(child.process_id).filter(|pid| *pid != 0),
            state: Some(state(child)),
            restarts: (!is_launcher_itself).then_some(child.restarts),
            note: notes.join("; "),
            ..of_itself
        }
    }

    /// Row of a process, from its own messages.
    fn of_process(heard: &Heard) -> Self {
        let last = &heard.last;
        let (taken, published) = match last.kind() {
            Some(ProcessKind::Adapter) => (Counter::Records, Counter::Published),
            Some(ProcessKind::Recorder) => (Counter::Taken, Counter::RowsWritten),
            Some(ProcessKind::Gateway | ProcessKind::Simulator) => (Counter::Taken, Counter::RecordsSent),
            Some(ProcessKind::Display) => (Counter::Taken, Counter::PicturesSent),
            Some(ProcessKind::Link) => (Counter::Published, Counter::RecordsSent),
            _ => (Counter::Taken, Counter::Published),
        };
        Self {
            name: last.name().to_owned(),
            pid: Some(last.process_id),
            state: Some(state(last)),
            restarts: None,
            taken_per_s: heard.per_s(taken),
            published_per_s: heard.per_s(published),
            note: match heard.peers.is_empty() {
                true => last.note().to_owned(),
                false => heard.of_peers(),
            },
        }
    }
}

fn state(health: &Health) -> &'static str {
    health.life().map_or("?", messages::LifeState::word)
}

impl Heard {
    /// Returns a link's notes about its peers, and its losses and rejections.
    fn of_peers(&self) -> String {
        let losses = LOSSES.iter().filter_map(|(counter, what)| {
            let count = Some(self.last.counters[*counter]).filter(|count| *count > 0)?;
            Some(format!("{count} {what}"))
        });
        self.peers
            .values()
            .cloned()
            .chain(losses)
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// Returns the rate of a counter; `None` if it is 0, or only one message was received.
    fn per_s(&self, counter: Counter) -> Option<f64> {
        let seconds = (self.last.said_ns - self.first.said_ns) as f64 / messages::NS_PER_S;
        let (first, last) = (self.first.counters[counter], self.last.counters[counter]);
        (seconds > 0.0 && last > 0).then(|| last.saturating_sub(first) as f64 / seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::LifeState;

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
        let mut heard = Vec::new();
        note(&mut heard, &said(ProcessKind::Launcher, "launcher", 1, 0, 0));
        let mut child = said(ProcessKind::Launcher, "fusion", 2, 0, 0).with_note("was killed by SIGKILL");
        child.restarts = 3;
        note(&mut heard, &child);
        note(&mut heard, &said(ProcessKind::Fusion, "fusion", 2, 0, 100));
        note(&mut heard, &said(ProcessKind::Fusion, "fusion", 2, 500_000_000, 350));
        note(&mut heard, &said(ProcessKind::Monitor, "second", 9, 0, 0));
        let subscriber = Process {
            pid: 10,
            name: "subscribe".to_owned(),
        };
        let table = table(&rows(&heard, &[subscriber]));
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
        let mut heard = Vec::new();
        let mut link = said(ProcessKind::Link, "in", 5, 0, 0).with_note("north is not there");
        link.counters[Counter::LostOnTheWay] = 12;
        let peer = |source: u16, note: &str| Health {
            source,
            ..said(ProcessKind::Link, "in", 5, 0, 0).with_note(note)
        };
        for _ in 0..2 {
            note(&mut heard, &link);
            note(&mut heard, &peer(0, "north is not there"));
            note(&mut heard, &peer(1, "west 1.0 ms away"));
        }
        let notes: Vec<String> = rows(&heard, &[]).into_iter().map(|row| row.note).collect();
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
            pid: Some(7),
            processes: Vec::new(),
            registrations: vec![RegistrationStatus {
                source: 3,
                text: "-1.5 m east".to_owned(),
            }],
            alarms: vec![AlarmStatus::of(&alarm.with_text("12 MB are left."))],
            orders: Vec::new(),
        };
        let text = status.text();
        assert!(
            text.starts_with("instance demo: run by process 7, in /run/koseki/demo\n"),
            "{text}"
        );
        assert!(text.contains("  registration: source 3: -1.5 m east\n"), "{text}");
        let remedy = AlarmKind::DiskLow.remedy();
        let expected = format!("  alarm, major: 12 MB are left.\n    {remedy}\n");
        assert!(text.ends_with(&expected), "{text}");
        let value = serde_json::to_value(&status).unwrap();
        assert_eq!(value["alarms"][0]["severity"], "major");
        assert_eq!((&value["state"], &value["pid"]), (&"runs".into(), &7.into()));
        assert_eq!(value["registrations"][0]["source"], 3);
        let refused = InstanceStatus {
            state: InstanceState::Refused,
            ..status
        };
        assert!(!refused.text().contains("killed"), "{}", refused.text());
    }
}
