//! `koseki status`: what runs on this machine.
//!
//! It looks on like any reader would: joins each instance that runs, listens to two rounds of health messages, and
//! leaves. Rates are the differences between the two rounds.

use std::collections::BTreeMap;
use std::time::Duration;

use alarms::{AlarmKind, Present};
use bus::{Bus, BusError, Instance, Process, Root, SharedMemory};
use messages::{Alarm, AlarmSeverity, Counter, Health, NO_SOURCE, ProcessKind, Registration};
use runtime::clock::{instant, mono_ns};
use telemetry::table::{Align, Table};

/// How long to listen: health messages come five times a second.
const LISTEN: Duration = Duration::from_millis(700);
/// Pause between two looks: queues hold more than comes in this time.
const PAUSE: Duration = Duration::from_millis(20);
/// Name under which this command joins an instance.
const OWN_NAME: &str = "status";

/// Prints every instance, or the one called `only`.
///
/// # Errors
/// If the instances cannot be listed, or shared memory fails.
pub(crate) fn run(only: Option<&str>) -> anyhow::Result<()> {
    let instances = match only {
        Some(name) => {
            // A name that cannot be one is wrong usage, not an instance that does not run.
            let root = Root::new(name).map_err(|error| crate::args::Usage(error.to_string()))?;
            let listed = Root::list(root.base())?.into_iter();
            listed.filter(|instance| instance.root == root).collect()
        }
        None => Root::list(Root::default_base())?,
    };
    let mut text = String::new();
    for instance in &instances {
        text.push_str(&describe(instance)?);
    }
    if instances.is_empty() {
        text = match only {
            Some(name) => format!("nothing runs as instance {name}\n"),
            None => "nothing runs\n".to_owned(),
        };
    }
    crate::print(&text)
}

fn describe(instance: &Instance) -> anyhow::Result<String> {
    let name = instance.root.instance();
    if !instance.runs {
        return Ok(format!(
            "instance {name}: does not run; an earlier run was killed, and the next start removes what it left\n"
        ));
    }
    let pid = instance.pid.map_or_else(|| "?".to_owned(), |pid| pid.to_string());
    let listened = listen(&instance.root);
    clear_if_ended(&instance.root)?;
    match listened {
        Ok(heard) => Ok(format!(
            "instance {name}: run by process {pid}\n{}{}{}",
            table(&heard.speakers, &heard.processes),
            registrations(&heard.registrations),
            alarms(&heard.alarms)
        )),
        Err(BusError::NotRunning { .. } | BusError::NoSuchTopic { .. }) => {
            Ok(format!("instance {name}: process {pid} is starting or stopping it\n"))
        }
        Err(error) => Err(error.into()),
    }
}

/// Joining an instance at the very moment in which its launcher clears it brings its folder back. Nobody else would
/// remove it before the next start.
pub(crate) fn clear_if_ended(root: &Root) -> Result<(), BusError> {
    if root.holder()?.is_none()
        && root.path().exists()
        && let Ok(claim) = root.claim()
    {
        claim.remove()?;
    }
    Ok(())
}

/// First and last message of one process, or of the launcher about it.
#[derive(Clone, Copy, Debug)]
struct Heard {
    first: Health,
    last: Health,
}

/// Everything that is said while listening, and who has joined the instance.
struct Listened {
    speakers: Vec<Heard>,
    /// By number of the source.
    registrations: BTreeMap<u16, Registration>,
    processes: Vec<Process>,
    /// Alarms that stand, the worst first.
    alarms: Vec<Alarm>,
}

fn listen(root: &Root) -> Result<Listened, BusError> {
    let bus = Bus::<SharedMemory>::open(root, OWN_NAME)?;
    let mut subscriber = bus.subscriber(&messages::health(), || mono_ns() as u64)?;
    let mut of_alarms = bus.subscriber(&messages::alarms(), || mono_ns() as u64)?;
    let mut present = Present::default();
    let mut speakers: Vec<Heard> = Vec::new();
    let mut registrations = BTreeMap::new();
    let start = instant();
    while instant() - start < LISTEN {
        subscriber.take(usize::MAX, |_, said| {
            for health in said {
                let whole = health.source == NO_SOURCE || is_launcher(health);
                if whole {
                    note(&mut speakers, health);
                } else if health.registration.comparisons > 0.0 {
                    registrations.insert(health.source, health.registration);
                }
            }
        })?;
        of_alarms.take(usize::MAX, |header, slice| present.hear(header, slice))?;
        std::thread::sleep(PAUSE);
    }
    let mut processes = root.processes()?;
    processes.retain(|process| process.pid != std::process::id());
    Ok(Listened {
        speakers,
        registrations,
        processes,
        alarms: present.at(mono_ns()).unwrap_or_default().to_vec(),
    })
}

/// Two lines per alarm: the condition, and what to do.
fn alarms(standing: &[Alarm]) -> String {
    let lines = |alarm: &Alarm| {
        let severity = alarm.severity().map_or("?", AlarmSeverity::word);
        let remedy = AlarmKind::from_code(alarm.code).map_or("", AlarmKind::remedy);
        format!("  alarm, {severity}: {}\n    {remedy}\n", alarm.text())
    };
    standing.iter().map(lines).collect()
}

/// One line per source of which fusion knows how far its reports lie off; sources count from 1, as in the files.
fn registrations(known: &BTreeMap<u16, Registration>) -> String {
    let line = |(source, known): (&u16, &Registration)| format!("  registration: source {}: {known}\n", source + 1);
    known.iter().map(line).collect()
}

fn note(heard: &mut Vec<Heard>, health: &Health) {
    // The launcher speaks of its children by their names; a child's process number changes.
    let same = |other: &&mut Heard| {
        let other = &other.last;
        (other.kind, other.name) == (health.kind, health.name)
            && (is_launcher(health) || other.process_id == health.process_id)
    };
    match heard.iter_mut().find(same) {
        Some(known) => known.last = *health,
        None => heard.push(Heard {
            first: *health,
            last: *health,
        }),
    }
}

fn is_launcher(health: &Health) -> bool {
    health.kind == ProcessKind::Launcher as u8
}

/// One line per process: first the launcher and its children, then what else has joined the instance.
fn table(heard: &[Heard], processes: &[Process]) -> String {
    // Numbers have room for eight digits, so that columns stay where they are from one look to the next.
    let columns = [
        ("process", Align::Left),
        ("     pid", Align::Right),
        ("state   ", Align::Left),
        ("restarts", Align::Right),
        ("    in/s", Align::Right),
        ("   out/s", Align::Right),
        ("note", Align::Left),
    ];
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
        pid: process.pid.to_string(),
        note: "says nothing of itself".to_owned(),
        ..Row::default()
    }));
    let mut table = Table::new(&columns);
    for row in rows {
        table.row(row.cells());
    }
    table.to_string().lines().map(|line| format!("  {line}\n")).collect()
}

/// Line of the table; an empty cell is shown as a dash.
#[derive(Default)]
struct Row {
    name: String,
    pid: String,
    state: String,
    restarts: String,
    taken: String,
    published: String,
    note: String,
}

impl Row {
    fn cells(self) -> [String; 7] {
        let [name, pid, state, restarts, taken, published] = [
            self.name,
            self.pid,
            self.state,
            self.restarts,
            self.taken,
            self.published,
        ]
        .map(|cell| if cell.is_empty() { "-".to_owned() } else { cell });
        [name, pid, state, restarts, taken, published, self.note]
    }

    /// A child, as the launcher speaks of it, and as it speaks of itself if it does.
    fn of_child(child: &Health, own: Option<&Heard>) -> Self {
        let state = child.life().map_or("?", messages::LifeState::word).to_owned();
        let is_launcher_itself = child.name() == ProcessKind::Launcher.word();
        let row = Self {
            name: child.name().to_owned(),
            pid: match child.process_id {
                0 => String::new(),
                pid => pid.to_string(),
            },
            restarts: if is_launcher_itself {
                String::new()
            } else {
                child.restarts.to_string()
            },
            state,
            note: match child.note() {
                "" => String::new(),
                end => format!("the last one {end}"),
            },
            ..Self::default()
        };
        let Some(own) = own else { return row };
        let of_itself = Self::of_process(own);
        let notes = [of_itself.note, row.note.clone()];
        Self {
            taken: of_itself.taken,
            published: of_itself.published,
            note: notes
                .into_iter()
                .filter(|note| !note.is_empty())
                .collect::<Vec<_>>()
                .join("; "),
            ..row
        }
    }

    /// A process, as it speaks of itself.
    fn of_process(heard: &Heard) -> Self {
        let last = &heard.last;
        let (taken, published) = match last.kind() {
            Some(ProcessKind::Adapter) => (Counter::Records, Counter::Published),
            Some(ProcessKind::Recorder) => (Counter::Taken, Counter::RowsWritten),
            Some(ProcessKind::Gateway | ProcessKind::Simulator) => (Counter::Taken, Counter::RecordsSent),
            _ => (Counter::Taken, Counter::Published),
        };
        Self {
            name: last.name().to_owned(),
            pid: last.process_id.to_string(),
            state: last.life().map_or("?", messages::LifeState::word).to_owned(),
            taken: heard.rate(taken),
            published: heard.rate(published),
            note: last.note().to_owned(),
            ..Self::default()
        }
    }
}

impl Heard {
    /// How fast a counter grew; nothing if it stands at 0, or only one message was heard.
    fn rate(&self, counter: Counter) -> String {
        let seconds = (self.last.said_ns - self.first.said_ns) as f64 / messages::NS_PER_S;
        let (first, last) = (self.first.counters[counter], self.last.counters[counter]);
        if seconds <= 0.0 || last == 0 {
            return String::new();
        }
        format!("{:.0}", last.saturating_sub(first) as f64 / seconds)
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
        let table = table(&heard, &[subscriber]);
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
    fn alarms_are_listed_with_what_to_do() {
        let alarm = Alarm {
            code: AlarmKind::DiskLow.code(),
            severity: AlarmSeverity::Major.code(),
            ..Alarm::default()
        };
        let remedy = AlarmKind::DiskLow.remedy();
        assert_eq!(
            alarms(&[alarm.with_text("12 MB are left.")]),
            format!("  alarm, major: 12 MB are left.\n    {remedy}\n")
        );
    }

    #[test]
    fn registrations_are_listed_by_source() {
        let known = Registration {
            comparisons: 100.0,
            offset_m: [-1.5, -6.8, 0.0],
            ..Registration::default()
        };
        let text = registrations(&BTreeMap::from([(2, known), (0, known)]));
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(
            lines[0].starts_with("  registration: source 1: -1.5 m east, -6.8 m north"),
            "{text}"
        );
    }
}
