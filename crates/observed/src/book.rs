//! Latest health messages of every process, with the launcher's facts.
//!
//! Counters of a process begin at 0 with each start. The book's counters continue: the counts of earlier epochs of a
//! process are added. Epochs of a process differ in the start time, which every health message contains.
//!
//! Rates belong to the last closed interval. They use the times of the messages, so that a late message changes no
//! rate.
//!
//! Restarts are known from two sides. The launcher counts the restarts of its children, and a new epoch under an old
//! name is a restart of any process. The larger number counts.
//!
//! Health messages may come from processes of another build. A message with an unknown code or source is counted and
//! otherwise rejected.

use std::collections::BTreeMap;

use messages::{Counter, Counters, Health, HealthName, LifeState, NO_SOURCE, NS_PER_S, ProcessKind, Registration};

use crate::process::{ObservedProcess, ProcessState};

/// Silence after which a process is silent, nanoseconds: five health messages are missing then.
const SILENT_AFTER_NS: i64 = 1_000_000_000;
/// Maximum number of entries: some 170 processes, three of them with 128 sources each, and spare entries.
const ENTRIES_MAX: usize = 1024;
/// Maximum lead of a process's start over the reader's start, nanoseconds, so that the process's counters began at 0
/// within sight of the reader.
const TOGETHER_NS: i64 = 5_000_000_000;
/// Note of a process without any health message.
pub const NO_MESSAGE: &str = "no health message";

/// Latest health messages of every process.
#[derive(Clone, Debug)]
pub struct HealthBook {
    sources: usize,
    /// Start of the reader, monotonic, nanoseconds.
    begun_ns: i64,
    entries: BTreeMap<(ProcessKind, HealthName, u16), BookEntry>,
    children: BTreeMap<HealthName, ChildRecord>,
    rejected: u64,
}

/// Messages of one process about itself as a whole, or about one source.
#[derive(Clone, Debug)]
struct BookEntry {
    latest: Health,
    /// Counts of earlier epochs.
    earlier: Counters,
    epochs: u32,
    /// State at the begin and at the end of the last closed interval.
    interval: [CountMark; 2],
}

/// Counts at the time of a message, monotonic, nanoseconds.
#[derive(Clone, Copy, Debug)]
struct CountMark {
    time_ns: i64,
    counters: Counters,
}

/// Launcher's facts about one process.
#[derive(Clone, Copy, Debug)]
struct ChildRecord {
    /// Place in the launcher's list.
    place: usize,
    life: LifeState,
    restarts: u32,
    process_id: u32,
    /// Source of the process, for an adapter of one source.
    source: u16,
    /// Latest message with a note: the last unexpected end of the process.
    last_end: Health,
}

impl HealthBook {
    /// Creates an empty book of a deployment with so many sources, for a reader that started at `begun_ns`
    /// (monotonic, nanoseconds; `i64::MAX`: after all processes).
    pub fn new(sources: usize, begun_ns: i64) -> Self {
        Self {
            sources,
            begun_ns,
            entries: BTreeMap::new(),
            children: BTreeMap::new(),
            rejected: 0,
        }
    }

    /// Takes one message.
    pub fn take(&mut self, health: &Health) {
        let (Some(kind), Some(life)) = (health.kind(), health.life()) else {
            self.rejected += 1;
            return;
        };
        let known_source = health.source == NO_SOURCE || usize::from(health.source) < self.sources;
        if !known_source || health.name().is_empty() {
            self.rejected += 1;
            return;
        }
        if kind == ProcessKind::Launcher && health.name() != kind.word() {
            self.take_child(health, life);
        } else {
            self.take_process(kind, health);
        }
    }

    fn take_child(&mut self, health: &Health, life: LifeState) {
        let place = self.children.len();
        if place == ENTRIES_MAX && !self.children.contains_key(&health.name) {
            self.rejected += 1;
            return;
        }
        let child = self.children.entry(health.name).or_insert(ChildRecord {
            place,
            life,
            restarts: 0,
            process_id: 0,
            source: NO_SOURCE,
            last_end: *health,
        });
        child.life = life;
        (child.process_id, child.source) = (health.process_id, health.source);
        child.restarts = child.restarts.max(health.restarts);
        // Kept after a good end as well: the reason of a restart remains of interest.
        if !health.note().is_empty() {
            child.last_end = *health;
        }
    }

    fn take_process(&mut self, kind: ProcessKind, health: &Health) {
        let key = (kind, health.name, health.source);
        if let Some(entry) = self.entries.get_mut(&key) {
            // Messages of the name's former process may arrive after messages of the next. The start times give no
            // order: a fusion that takes over takes the name of a younger process.
            if health.said_ns < entry.latest.said_ns {
                return;
            }
            if health.incarnation != entry.latest.incarnation {
                entry.earlier = entry.earlier.followed_by(&entry.latest.counters);
                entry.epochs += 1;
            }
            entry.latest = *health;
        } else if self.entries.len() < ENTRIES_MAX {
            let begin = match is_seen_from_start(health, self.begun_ns) {
                true => CountMark {
                    time_ns: health.incarnation as i64,
                    counters: Counters::default(),
                },
                false => CountMark {
                    time_ns: health.said_ns,
                    counters: health.counters,
                },
            };
            self.entries.insert(
                key,
                BookEntry {
                    latest: *health,
                    earlier: Counters::default(),
                    epochs: 1,
                    interval: [begin; 2],
                },
            );
        } else {
            self.rejected += 1;
        }
    }

    /// Closes the interval of the rates and begins the next.
    pub fn close_interval(&mut self) {
        for entry in self.entries.values_mut() {
            let end = CountMark {
                time_ns: entry.latest.said_ns,
                counters: entry.counters(),
            };
            entry.interval = [entry.interval[1], end];
        }
    }

    /// Removes guests that have left without a last message at `now_ns`: unexpected, silent processes whose process
    /// number `is_gone`.
    pub fn forget_guests(&mut self, expected: &[(ProcessKind, String)], now_ns: i64, is_gone: impl Fn(u32) -> bool) {
        let guests = self.processes(&[], now_ns).into_iter().filter(|process| {
            let is_expected = expected
                .iter()
                .any(|(kind, name)| (Some(*kind), name) == (process.kind, &process.name));
            let is_silent = matches!(process.state, ProcessState::Silent { .. });
            is_silent && !is_expected && process.pid.is_some_and(&is_gone)
        });
        for guest in guests.collect::<Vec<_>>() {
            let name = padded(&guest.name);
            if !self.children.contains_key(&name) {
                self.entries
                    .retain(|(kind, other, _), _| (Some(*kind), *other) != (guest.kind, name));
            }
        }
    }

    /// Returns the number of messages with an unknown code or source.
    pub fn rejected(&self) -> u64 {
        self.rejected
    }

    /// Returns the messages of process `name` about itself as a whole.
    pub fn whole(&self, kind: ProcessKind, name: &str) -> Option<LatestHealth<'_>> {
        self.about(kind, name, NO_SOURCE)
    }

    /// Returns the messages of process `name` about a source.
    pub fn about(&self, kind: ProcessKind, name: &str, source: u16) -> Option<LatestHealth<'_>> {
        let entry = self.entries.get(&(kind, padded(name), source));
        entry.map(|entry| self.latest(entry))
    }

    /// Returns the messages of process `name` about its sources or peers, in the latest round of the process.
    pub fn parts(&self, kind: ProcessKind, name: &str) -> impl Iterator<Item = LatestHealth<'_>> {
        let round_ns = self.whole(kind, name).map(|whole| whole.time_ns());
        let parts = self.entries.range(of_sources(kind, padded(name)));
        let parts = parts.filter(move |(_, entry)| Some(entry.latest.said_ns) == round_ns);
        parts.map(|(_, entry)| self.latest(entry))
    }

    fn latest<'a>(&self, entry: &'a BookEntry) -> LatestHealth<'a> {
        LatestHealth {
            entry,
            is_seen_from_start: is_seen_from_start(&entry.latest, self.begun_ns),
        }
    }

    /// Returns the time of the latest message of process `name`, monotonic, nanoseconds; `None` without a message.
    pub fn time_ns(&self, kind: ProcessKind, name: &str) -> Option<i64> {
        let name = padded(name);
        let entries = self.entries.range((kind, name, 0)..=(kind, name, NO_SOURCE));
        entries.map(|(_, entry)| entry.latest.said_ns).max()
    }

    /// Returns the counters of the adapter `name` for a source: by the source's number, or for the adapter as a whole
    /// if the adapter has one source.
    pub fn adapter(&self, name: &str, source: u16) -> Counters {
        let of = |source| self.about(ProcessKind::Adapter, name, source);
        let mut parts = self.entries.range(of_sources(ProcessKind::Adapter, padded(name)));
        let latest = of(source).or_else(|| parts.next().is_none().then(|| of(NO_SOURCE)).flatten());
        latest.map_or_else(Counters::default, |latest| latest.counters())
    }

    /// Returns the counters of a process that belong to none of its sources, so that sums over processes and sources
    /// contain every count once. `stands_for_source`: the counters of the process as a whole are those of its only
    /// source ([`Self::adapter`]).
    pub fn apart_from_sources(&self, kind: ProcessKind, name: &str, stands_for_source: bool) -> Option<Counters> {
        let mut counters = self.whole(kind, name)?.counters();
        let sources = self.entries.range(of_sources(kind, padded(name)));
        let of_sources: Vec<Counters> = sources.map(|(_, entry)| entry.counters()).collect();
        for counter in Counter::ALL.iter().filter(|counter| !counter.is_of_process()) {
            if of_sources.is_empty() && stands_for_source {
                counters[*counter] = 0;
            } else if kind != ProcessKind::Recorder {
                // The recorder counts system tracks apart from its sources; other processes count all sources
                // together.
                let counted: u64 = of_sources.iter().map(|counters| counters[*counter]).sum();
                counters[*counter] = counters[*counter].saturating_sub(counted);
            }
        }
        Some(counters)
    }

    /// Returns the counters of the service of a kind for one source, or for all sources together with [`NO_SOURCE`].
    pub fn service(&self, kind: ProcessKind, source: u16) -> Counters {
        let latest = self.about(kind, kind.word(), source);
        latest.map_or_else(Counters::default, |latest| latest.counters())
    }

    /// Returns all latest messages, each with its process and source (or [`NO_SOURCE`]).
    pub fn all(&self) -> impl Iterator<Item = (ProcessKind, u16, LatestHealth<'_>)> + '_ {
        let entries = self.entries.iter();
        entries.map(|((kind, _, source), entry)| (*kind, *source, self.latest(entry)))
    }

    /// Returns the messages of adapters about a source.
    fn of_adapters(&self, source: u16) -> impl Iterator<Item = LatestHealth<'_>> {
        let of_source = self
            .all()
            .filter(move |(kind, of, _)| *kind == ProcessKind::Adapter && *of == source);
        of_source.map(|(.., latest)| latest)
    }

    /// Returns the name of a source, by its adapter, or by the launcher for an adapter of one source. For readers
    /// without the configuration.
    pub fn source_name(&self, source: u16) -> Option<&str> {
        let mut noted = self.of_adapters(source).map(|latest| latest.note());
        let by_adapter = noted.find(|name| !name.is_empty());
        let mut children = self.children.values();
        by_adapter.or_else(|| {
            children
                .find(|child| child.source == source)
                .map(|child| child.last_end.name())
        })
    }

    /// Returns the counters of a source's adapter for the source, whatever the adapter's name.
    pub fn adapter_of(&self, source: u16) -> Counters {
        match self.of_adapters(source).next() {
            Some(latest) => latest.counters(),
            None => self
                .source_name(source)
                .map_or_else(Counters::default, |name| self.adapter(name, NO_SOURCE)),
        }
    }

    /// Returns the children of the launcher, by the launcher's facts and in the order of the launcher's list.
    pub fn children(&self) -> impl Iterator<Item = ChildState<'_>> + '_ {
        let mut children: Vec<&ChildRecord> = self.children.values().collect();
        children.sort_by_key(|child| child.place);
        children.into_iter().map(|child| ChildState {
            name: child.last_end.name(),
            pid: Some(child.process_id).filter(|pid| *pid != 0),
            life: child.life,
            restarts: child.restarts,
            last_end: child.last_end.note(),
        })
    }

    /// Returns the systematic errors of a source as learned by fusion, with the clock offset as learned by the
    /// source's adapter if it has one.
    pub fn registration(&self, source: u16) -> Registration {
        let kind = ProcessKind::Fusion;
        let latest = self.about(kind, kind.word(), source);
        let mut known = latest.map_or_else(Registration::default, |latest| latest.entry.latest.registration);
        if known.clock_offset_sigma_s == 0.0
            && let Some(latest) = self.of_adapters(source).next()
        {
            let judged = &latest.entry.latest.registration;
            (known.clock_offset_s, known.clock_offset_sigma_s) = (judged.clock_offset_s, judged.clock_offset_sigma_s);
        }
        known
    }

    /// Returns the lead of the sources' time over the machine's UTC as found by fusion, nanoseconds; 0 if both agree.
    pub fn host_offset_ns(&self) -> i64 {
        let kind = ProcessKind::Fusion;
        let latest = self.whole(kind, kind.word());
        // `as` saturates.
        latest.map_or(0, |latest| {
            (latest.entry.latest.registration.clock_offset_s * NS_PER_S) as i64
        })
    }

    /// Returns the `expected` processes, other processes with health messages, and other children of the launcher.
    pub fn processes(&self, expected: &[(ProcessKind, String)], now_ns: i64) -> Vec<ObservedProcess> {
        let mut names: Vec<(ProcessKind, HealthName)> =
            expected.iter().map(|(kind, name)| (*kind, padded(name))).collect();
        for (kind, name, _) in self.entries.keys() {
            if !names.contains(&(*kind, *name)) {
                names.push((*kind, *name));
            }
        }
        let silent = self.children().filter(|child| {
            let name = padded(child.name);
            names.iter().all(|(_, other)| *other != name)
        });
        let silent = silent.map(|child| ObservedProcess {
            kind: None,
            name: child.name.to_owned(),
            state: ProcessState::Life(child.life),
            restarts: child.restarts,
            last_end: child.last_end.to_owned(),
            note: NO_MESSAGE.to_owned(),
            pid: child.pid,
        });
        let named = names.iter().map(|(kind, name)| self.process(*kind, *name, now_ns));
        named.chain(silent).collect()
    }

    fn process(&self, kind: ProcessKind, name: HealthName, now_ns: i64) -> ObservedProcess {
        let child = self.children.get(&name).filter(|_| kind != ProcessKind::Launcher);
        let entries = self.entries.range((kind, name, 0)..=(kind, name, NO_SOURCE));
        let mut entries: Vec<&BookEntry> = entries.map(|(_, entry)| entry).collect();
        entries.sort_by_key(|entry| (entry.latest.said_ns, entry.latest.source));
        let latest = entries.last().map(|entry| entry.latest);
        let seen = entries.iter().map(|entry| entry.epochs).max().unwrap_or(1) - 1;
        let named = Health {
            name,
            ..Health::default()
        };
        // A fusion that has taken over has the name of another child.
        let own_pid = latest.map(|health| health.process_id).filter(|pid| *pid != 0);
        let is_a_child = |pid: &u32| self.children.values().any(|child| child.process_id == *pid);
        let of_child = child.map(|child| child.process_id);
        let pid = own_pid.filter(is_a_child).or(of_child).or(own_pid);
        ObservedProcess {
            kind: Some(kind),
            name: named.name().to_owned(),
            state: state(latest.as_ref(), child, now_ns),
            // Names pass from one fusion to another without a restart: only the launcher's count is certain.
            restarts: child.map_or(seen, |child| child.restarts),
            last_end: child.map_or_else(String::new, |child| child.last_end.note().to_owned()),
            note: latest.map_or_else(String::new, |health| health.note().to_owned()),
            pid: pid.filter(|pid| *pid != 0),
        }
    }
}

/// Launcher's facts about a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChildState<'a> {
    /// Name.
    pub name: &'a str,
    /// Process number, while there is a process.
    pub pid: Option<u32>,
    /// State of life.
    pub life: LifeState,
    /// Number of restarts.
    pub restarts: u32,
    /// Last unexpected end; empty without one.
    pub last_end: &'a str,
}

fn state(latest: Option<&Health>, child: Option<&ChildRecord>, now_ns: i64) -> ProcessState {
    let Some((health, life)) = latest.and_then(|health| health.life().map(|life| (health, life))) else {
        return child.map_or(ProcessState::NotHeard, |child| ProcessState::Life(child.life));
    };
    let silent_ns = now_ns - health.said_ns;
    match life {
        LifeState::Starting | LifeState::Running if silent_ns > SILENT_AFTER_NS => {
            ProcessState::Silent { for_ns: silent_ns }
        }
        life => ProcessState::Life(life),
    }
}

/// Whether the counters of the process of `health` began at 0 within sight of a reader that started at `begun_ns`.
fn is_seen_from_start(health: &Health, begun_ns: i64) -> bool {
    health.incarnation as i64 >= begun_ns.saturating_sub(TOGETHER_NS)
}

/// Keys of the entries of a process about its sources.
fn of_sources(kind: ProcessKind, name: HealthName) -> std::ops::Range<(ProcessKind, HealthName, u16)> {
    (kind, name, 0)..(kind, name, NO_SOURCE)
}

impl BookEntry {
    fn counters(&self) -> Counters {
        self.earlier.followed_by(&self.latest.counters)
    }
}

/// Latest message, with the counts of earlier epochs added.
#[derive(Clone, Copy, Debug)]
pub struct LatestHealth<'a> {
    entry: &'a BookEntry,
    is_seen_from_start: bool,
}

impl<'a> LatestHealth<'a> {
    /// Returns the name of the process.
    pub fn name(&self) -> &'a str {
        self.entry.latest.name()
    }

    /// Returns the note: a fault in a few words, or the name of an adapter's source.
    pub fn note(&self) -> &'a str {
        self.entry.latest.note()
    }

    /// Returns the state of life; `None` for a code of another schema.
    pub fn life(&self) -> Option<LifeState> {
        self.entry.latest.life()
    }

    /// Returns the input that was refused last, with the reasons; empty if none was.
    pub fn refusal(&self) -> &'a str {
        self.entry.latest.refusal()
    }

    /// Returns the input outside the configuration, as in [`Health::misfit`].
    pub fn misfit(&self) -> [u8; 4] {
        self.entry.latest.misfit
    }

    /// Returns the counts, with those of earlier epochs.
    pub fn counters(&self) -> Counters {
        self.entry.counters()
    }

    /// Returns the growth of a counter per second in the last closed interval; `None` without a new message in the
    /// interval.
    pub fn per_s(&self, counter: Counter) -> Option<f64> {
        let [begin, end] = &self.entry.interval;
        let seconds = (end.time_ns - begin.time_ns) as f64 / NS_PER_S;
        let grown = end.counters[counter].saturating_sub(begin.counters[counter]);
        (seconds > 0.0).then(|| grown as f64 / seconds)
    }

    /// Returns the time of the message, monotonic, nanoseconds.
    pub fn time_ns(&self) -> i64 {
        self.entry.latest.said_ns
    }

    /// Returns the start of the process, monotonic, nanoseconds.
    pub fn incarnation(&self) -> u64 {
        self.entry.latest.incarnation
    }

    /// Whether the counters began at 0 within sight of the reader.
    pub fn is_seen_from_start(&self) -> bool {
        self.is_seen_from_start
    }

    /// Returns the progress of the process in the time of its data, UTC, nanoseconds.
    pub fn progress_ns(&self) -> Option<i64> {
        Some(self.entry.latest.progress_ns).filter(|progress| *progress != i64::MIN && *progress != i64::MAX)
    }
}

fn padded(name: &str) -> HealthName {
    Health::default().with_name(name).name
}

#[cfg(test)]
#[path = "book_tests.rs"]
mod tests;
