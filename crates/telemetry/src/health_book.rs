//! Latest health messages of every process, with the launcher's facts.
//!
//! Counters of a process begin at 0 with each start. The book's counters continue: the counts of earlier epochs of a
//! process are added. Epochs of a process differ in the start time, which every health message contains.
//!
//! Restarts are known from two sides. The launcher counts the restarts of its children, and a new epoch under an old
//! name is a restart of any process. The larger number counts.
//!
//! Health messages may come from processes of another build. A message with an unknown code or source is counted and
//! otherwise rejected.

use std::collections::BTreeMap;

use messages::{Counter, Counters, Health, HealthName, LifeState, NO_SOURCE, ProcessKind, Registration};

use crate::process::{Process, State};

/// Silence after which a process is silent, nanoseconds: five health messages are missing then.
const SILENT_AFTER_NS: i64 = 1_000_000_000;
/// Maximum number of entries: some 100 processes, three of them with 64 sources each, and spare entries.
const SPEAKERS_MAX: usize = 1024;

/// Latest health messages of every process.
#[derive(Clone, Debug)]
pub struct HealthBook {
    sources: usize,
    speakers: BTreeMap<(ProcessKind, HealthName, u16), Speaker>,
    children: BTreeMap<HealthName, Child>,
    rejected: u64,
}

/// Messages of one process about itself as a whole, or about one source.
#[derive(Clone, Debug)]
struct Speaker {
    latest: Health,
    /// Counts of earlier epochs.
    earlier: Counters,
    incarnations: u32,
}

/// Launcher's facts about one process.
#[derive(Clone, Copy, Debug)]
struct Child {
    life: LifeState,
    restarts: u32,
    process_id: u32,
    /// Source of the process, for an adapter of one source.
    source: u16,
    /// Latest message with a note: the last unexpected end of the process.
    last_end: Health,
}

impl HealthBook {
    /// Creates an empty book of a deployment with so many sources.
    pub fn new(sources: usize) -> Self {
        Self {
            sources,
            speakers: BTreeMap::new(),
            children: BTreeMap::new(),
            rejected: 0,
        }
    }

    /// Takes one message.
    pub fn hear(&mut self, health: &Health) {
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
            self.hear_of_child(health, life);
        } else {
            self.hear_speaker(kind, health);
        }
    }

    fn hear_of_child(&mut self, health: &Health, life: LifeState) {
        if self.children.len() == SPEAKERS_MAX && !self.children.contains_key(&health.name) {
            self.rejected += 1;
            return;
        }
        let child = self.children.entry(health.name).or_insert(Child {
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

    fn hear_speaker(&mut self, kind: ProcessKind, health: &Health) {
        let key = (kind, health.name, health.source);
        if let Some(speaker) = self.speakers.get_mut(&key) {
            // Messages of the name's former process may arrive after messages of the next. The start times give no
            // order: a fusion that takes over takes the name of a younger process.
            let is_another = health.incarnation != speaker.latest.incarnation;
            if is_another && health.said_ns < speaker.latest.said_ns {
                return;
            }
            if is_another {
                speaker.earlier = speaker.earlier.followed_by(&speaker.latest.counters);
                speaker.incarnations += 1;
            }
            speaker.latest = *health;
        } else if self.speakers.len() < SPEAKERS_MAX {
            self.speakers.insert(
                key,
                Speaker {
                    latest: *health,
                    earlier: Counters::default(),
                    incarnations: 1,
                },
            );
        } else {
            self.rejected += 1;
        }
    }

    /// Removes guests that have left without a last message at `now_ns`: unexpected, silent processes whose process
    /// number `is_gone`.
    pub fn forget_guests(&mut self, expected: &[(ProcessKind, String)], now_ns: i64, is_gone: impl Fn(u32) -> bool) {
        let guests = self.processes(&[], now_ns).into_iter().filter(|process| {
            let is_expected = expected
                .iter()
                .any(|(kind, name)| (*kind, name) == (process.kind, &process.name));
            let is_silent = matches!(process.state, State::Silent { .. });
            is_silent && !is_expected && process.pid.is_some_and(&is_gone)
        });
        for guest in guests.collect::<Vec<_>>() {
            let name = padded(&guest.name);
            if !self.children.contains_key(&name) {
                self.speakers
                    .retain(|(kind, other, _), _| (*kind, *other) != (guest.kind, name));
            }
        }
    }

    /// Returns the number of messages with an unknown code or source.
    pub fn rejected(&self) -> u64 {
        self.rejected
    }

    /// Returns the messages of process `name` about itself as a whole.
    pub fn whole(&self, kind: ProcessKind, name: &str) -> Option<Latest<'_>> {
        self.said(kind, name, NO_SOURCE)
    }

    /// Returns the messages of process `name` about a source.
    pub fn said(&self, kind: ProcessKind, name: &str, source: u16) -> Option<Latest<'_>> {
        self.speakers.get(&(kind, padded(name), source)).map(Latest)
    }

    /// Returns the counters of the adapter `name` for a source: by the source's number, or for the adapter as a whole
    /// if the adapter has one source.
    pub fn adapter(&self, name: &str, source: u16) -> Counters {
        let of = |source| self.said(ProcessKind::Adapter, name, source);
        let said = of(source).or_else(|| of(NO_SOURCE));
        said.map_or_else(Counters::default, |said| said.counters())
    }

    /// Returns the counters of a process that belong to none of its sources, so that sums over processes and sources
    /// contain every count once. `stands_for_source`: the counters of the process as a whole are those of its only
    /// source ([`Self::adapter`]).
    pub fn apart_from_sources(&self, kind: ProcessKind, name: &str, stands_for_source: bool) -> Option<Counters> {
        let mut counters = self.whole(kind, name)?.counters();
        let sources = self
            .speakers
            .range((kind, padded(name), 0)..(kind, padded(name), NO_SOURCE));
        let of_sources: Vec<Counters> = sources.map(|(_, speaker)| Latest(speaker).counters()).collect();
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
        let said = self.said(kind, kind.word(), source);
        said.map_or_else(Counters::default, |said| said.counters())
    }

    /// Returns all latest messages, each with its process and source (or [`NO_SOURCE`]).
    pub fn all_said(&self) -> impl Iterator<Item = (ProcessKind, u16, Latest<'_>)> + '_ {
        let speakers = self.speakers.iter();
        speakers.map(|((kind, _, source), speaker)| (*kind, *source, Latest(speaker)))
    }

    /// Returns the name of a source, by its adapter, or by the launcher for an adapter of one source. For readers
    /// without the configuration.
    pub fn source_name(&self, source: u16) -> Option<&str> {
        let adapters = self.all_said().filter(|(kind, ..)| *kind == ProcessKind::Adapter);
        let by_adapter = adapters
            .filter(|(_, of, said)| *of == source && !said.0.latest.note().is_empty())
            .map(|(.., said)| said.0.latest.note())
            .next();
        let mut children = self.children.values();
        by_adapter.or_else(|| {
            children
                .find(|child| child.source == source)
                .map(|child| child.last_end.name())
        })
    }

    /// Returns the counters of a source's adapter for the source, whatever the adapter's name.
    pub fn adapter_of(&self, source: u16) -> Counters {
        let of_source = self
            .all_said()
            .find(|(kind, of, _)| *kind == ProcessKind::Adapter && *of == source);
        match of_source {
            Some((.., said)) => said.counters(),
            None => self
                .source_name(source)
                .map_or_else(Counters::default, |name| self.adapter(name, NO_SOURCE)),
        }
    }

    /// Returns the children of the launcher without any health message.
    pub fn silent_children(&self) -> impl Iterator<Item = ChildState<'_>> + '_ {
        let has_spoken = |name: &str| self.speakers.values().any(|speaker| speaker.latest.name() == name);
        self.children().filter(move |child| !has_spoken(child.name))
    }

    /// Returns the children of the launcher, by the launcher's facts.
    pub fn children(&self) -> impl Iterator<Item = ChildState<'_>> + '_ {
        self.children.values().map(|child| ChildState {
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
        let said = self.said(kind, kind.word(), source);
        let mut known = said.map_or_else(Registration::default, |said| said.0.latest.registration);
        let mut adapters = self.all_said().filter(|(kind, ..)| *kind == ProcessKind::Adapter);
        if known.clock_offset_sigma_s == 0.0
            && let Some((.., said)) = adapters.find(|(_, of, _)| *of == source)
        {
            let judged = &said.0.latest.registration;
            (known.clock_offset_s, known.clock_offset_sigma_s) = (judged.clock_offset_s, judged.clock_offset_sigma_s);
        }
        known
    }

    /// Returns the lead of the sources' time over the machine's UTC as found by fusion, nanoseconds; 0 if both agree.
    pub fn host_offset_ns(&self) -> i64 {
        let kind = ProcessKind::Fusion;
        let said = self.said(kind, kind.word(), NO_SOURCE);
        // `as` saturates.
        said.map_or(0, |said| {
            (said.0.latest.registration.clock_offset_s * messages::NS_PER_S) as i64
        })
    }

    /// Returns the `expected` processes, and other processes with health messages.
    pub fn processes(&self, expected: &[(ProcessKind, String)], now_ns: i64) -> Vec<Process> {
        let mut names: Vec<(ProcessKind, HealthName)> =
            expected.iter().map(|(kind, name)| (*kind, padded(name))).collect();
        for (kind, name, _) in self.speakers.keys() {
            if !names.contains(&(*kind, *name)) {
                names.push((*kind, *name));
            }
        }
        names
            .into_iter()
            .map(|(kind, name)| self.process(kind, name, now_ns))
            .collect()
    }

    fn process(&self, kind: ProcessKind, name: HealthName, now_ns: i64) -> Process {
        let child = self.children.get(&name).filter(|_| kind != ProcessKind::Launcher);
        let mut said: Vec<&Speaker> = self
            .speakers
            .range((kind, name, 0)..=(kind, name, NO_SOURCE))
            .map(|(_, speaker)| speaker)
            .collect();
        said.sort_by_key(|speaker| (speaker.latest.said_ns, speaker.latest.source));
        let latest = said.last().map(|speaker| speaker.latest);
        let seen = said.iter().map(|speaker| speaker.incarnations).max().unwrap_or(1) - 1;
        let named = Health {
            name,
            ..Health::default()
        };
        Process {
            kind,
            name: named.name().to_owned(),
            state: state(latest.as_ref(), child, now_ns),
            // Names pass from one fusion to another without a restart: only the launcher's count is certain.
            restarts: child.map_or(seen, |child| child.restarts),
            last_end: child.map_or_else(String::new, |child| child.last_end.note().to_owned()),
            note: latest.map_or_else(String::new, |health| health.note().to_owned()),
            pid: child
                .map(|child| child.process_id)
                .or(latest.map(|health| health.process_id))
                .filter(|pid| *pid != 0),
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

fn state(latest: Option<&Health>, child: Option<&Child>, now_ns: i64) -> State {
    let Some((health, life)) = latest.and_then(|health| health.life().map(|life| (health, life))) else {
        return child.map_or(State::NotHeard, |child| State::Life(child.life));
    };
    let silent_ns = now_ns - health.said_ns;
    match life {
        LifeState::Starting | LifeState::Running if silent_ns > SILENT_AFTER_NS => State::Silent { for_ns: silent_ns },
        life => State::Life(life),
    }
}

/// Latest counters, with those of earlier epochs added.
pub struct Latest<'a>(&'a Speaker);

impl<'a> Latest<'a> {
    /// Returns the name of the process.
    pub fn name(&self) -> &'a str {
        self.0.latest.name()
    }

    /// Returns the counts, with those of earlier epochs.
    pub fn counters(&self) -> Counters {
        self.0.earlier.followed_by(&self.0.latest.counters)
    }

    /// Returns the time of the message, monotonic, nanoseconds.
    pub fn said_ns(&self) -> i64 {
        self.0.latest.said_ns
    }

    /// Returns the start of the process, monotonic, nanoseconds.
    pub fn incarnation(&self) -> u64 {
        self.0.latest.incarnation
    }

    /// Returns the progress of the process in the time of its data, UTC, nanoseconds.
    pub fn progress_ns(&self) -> Option<i64> {
        Some(self.0.latest.progress_ns).filter(|progress| *progress != i64::MIN && *progress != i64::MAX)
    }
}

fn padded(name: &str) -> HealthName {
    Health::default().with_name(name).name
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::S;

    fn health(kind: ProcessKind, name: &str, incarnation: u64, said_ns: i64) -> Health {
        Health {
            kind: kind as u8,
            incarnation,
            said_ns,
            life: LifeState::Running as u8,
            ..Health::default()
        }
        .with_name(name)
    }

    fn counting(mut health: Health, taken: u64) -> Health {
        health.counters[Counter::Taken] = taken;
        health
    }

    fn only(book: &HealthBook, now_ns: i64) -> Process {
        let mut processes = book.processes(&[], now_ns);
        assert_eq!(processes.len(), 1);
        processes.remove(0)
    }

    #[test]
    fn counters_survive_a_restart_and_late_words_of_the_dead_change_nothing() {
        let mut book = HealthBook::new(2);
        let said = |incarnation, said_s, taken| {
            counting(health(ProcessKind::Fusion, "fusion", incarnation, said_s * S), taken)
        };
        for health in [said(10, 1, 3), said(10, 2, 5), said(20, 4, 2), said(10, 3, 4)] {
            book.hear(&health);
        }
        assert_eq!(book.service(ProcessKind::Fusion, NO_SOURCE)[Counter::Taken], 7);
        assert_eq!(only(&book, 4 * S).restarts, 1);
    }

    #[test]
    fn a_process_that_takes_over_the_name_of_a_younger_one_is_heard_and_is_no_restart() {
        let mut book = HealthBook::new(0);
        // A standby has the name of a standby until it leads; it started before the leader.
        book.hear(&health(ProcessKind::Fusion, "standby", 20, S));
        for second in 2..5 {
            book.hear(&health(ProcessKind::Fusion, "fusion", 20, second * S));
            book.hear(&health(ProcessKind::Fusion, "standby", 10, second * S));
        }
        book.hear(&Health {
            restarts: 0,
            ..health(ProcessKind::Launcher, "standby", 1, S)
        });
        let standby = |book: &HealthBook, now_s: i64| {
            let processes = book.processes(&[], now_s * S);
            processes.into_iter().find(|process| process.name == "standby").unwrap()
        };
        assert_eq!(standby(&book, 4).state, State::Life(LifeState::Running));
        assert_eq!(standby(&book, 4).restarts, 0);
        // Take-over.
        for second in 5..9 {
            book.hear(&health(ProcessKind::Fusion, "fusion", 10, second * S));
        }
        let fusion = book
            .processes(&[], 8 * S)
            .into_iter()
            .find(|process| process.name == "fusion");
        assert_eq!(fusion.unwrap().state, State::Life(LifeState::Running));
    }

    #[test]
    fn the_launchers_count_of_restarts_is_shown_with_the_reason() {
        let mut book = HealthBook::new(2);
        book.hear(&health(ProcessKind::Adapter, "radar", 10, S));
        let of_child = Health {
            restarts: 3,
            source: 1,
            ..health(ProcessKind::Launcher, "radar", 1, S)
        };
        book.hear(&of_child.with_note("was killed by SIGKILL"));
        let process = only(&book, S);
        assert_eq!(
            (process.restarts, process.last_end.as_str()),
            (3, "was killed by SIGKILL")
        );
    }

    #[test]
    fn silence_is_shown_unless_the_process_has_ended() {
        let mut book = HealthBook::new(0);
        book.hear(&health(ProcessKind::Fusion, "fusion", 10, S));
        assert_eq!(only(&book, 2 * S).state, State::Life(LifeState::Running));
        assert_eq!(only(&book, 3 * S).state, State::Silent { for_ns: 2 * S });
        book.hear(&Health {
            life: LifeState::Finished as u8,
            ..health(ProcessKind::Fusion, "fusion", 10, S)
        });
        assert_eq!(only(&book, 30 * S).state, State::Life(LifeState::Finished));
    }

    #[test]
    fn expected_processes_are_listed_before_they_speak() {
        let book = HealthBook::new(0);
        let processes = book.processes(&[(ProcessKind::Fusion, "fusion".to_owned())], S);
        assert_eq!(processes[0].state, State::NotHeard);
    }

    #[test]
    fn what_cannot_be_understood_is_counted_and_ignored() {
        let mut book = HealthBook::new(2);
        let good = health(ProcessKind::Fusion, "fusion", 10, S);
        book.hear(&Health { kind: 77, ..good });
        book.hear(&Health { life: 9, ..good });
        book.hear(&Health { source: 2, ..good });
        book.hear(&health(ProcessKind::Fusion, "", 10, S));
        assert_eq!(book.rejected(), 4);
        assert!(book.processes(&[], S).is_empty());
        book.hear(&Health { source: 1, ..good });
        assert_eq!((book.rejected(), book.processes(&[], S).len()), (4, 1));
    }

    #[test]
    fn no_more_than_a_maximum_of_names_is_kept() {
        let mut book = HealthBook::new(0);
        for number in 0..SPEAKERS_MAX + 5 {
            book.hear(&health(ProcessKind::Adapter, &format!("a{number}"), 1, S));
        }
        assert_eq!((book.processes(&[], S).len(), book.rejected()), (SPEAKERS_MAX, 5));
    }

    #[test]
    fn sources_are_named_by_their_adapters_or_by_the_launcher() {
        let mut book = HealthBook::new(9);
        let of_child = |name: &str, source| Health {
            source,
            process_id: 77,
            ..health(ProcessKind::Launcher, name, 1, S)
        };
        book.hear(&of_child("radar", 0));
        book.hear(&of_child("antenna", NO_SOURCE));
        let said = Health {
            source: 3,
            ..health(ProcessKind::Adapter, "antenna", 1, S)
        };
        book.hear(&counting(said.with_note("ads-b"), 8));
        book.hear(&counting(health(ProcessKind::Adapter, "radar", 1, S), 5));
        assert_eq!(
            (book.source_name(0), book.source_name(3)),
            (Some("radar"), Some("ads-b"))
        );
        assert_eq!(book.source_name(4), None);
        let taken = |source| book.adapter_of(source)[Counter::Taken];
        assert_eq!((taken(0), taken(3), taken(4)), (5, 8, 0));
    }

    #[test]
    fn children_that_never_spoke_are_known_from_the_launcher() {
        let mut book = HealthBook::new(9);
        let of_child = Health {
            process_id: 77,
            restarts: 4,
            ..health(ProcessKind::Launcher, "radar", 1, S)
        };
        book.hear(&of_child.with_note("was killed by SIGKILL"));
        let silent: Vec<ChildState<'_>> = book.silent_children().collect();
        let expected = ChildState {
            name: "radar",
            pid: Some(77),
            life: LifeState::Running,
            restarts: 4,
            last_end: "was killed by SIGKILL",
        };
        assert_eq!(silent, [expected]);
        book.hear(&health(ProcessKind::Adapter, "radar", 1, S));
        assert_eq!(book.silent_children().count(), 0);
        assert_eq!(only(&book, S).pid, Some(77));
    }

    #[test]
    fn an_adapter_may_speak_of_itself_or_of_its_source() {
        let mut book = HealthBook::new(2);
        book.hear(&counting(health(ProcessKind::Adapter, "radar", 1, S), 4));
        let of_source = Health {
            source: 1,
            ..health(ProcessKind::Adapter, "radar", 1, S)
        };
        book.hear(&counting(of_source, 6));
        assert_eq!(book.adapter("radar", 1)[Counter::Taken], 6);
    }

    #[test]
    fn what_is_counted_for_a_source_is_not_counted_for_the_process_again() {
        let mut book = HealthBook::new(2);
        let of = |kind, name: &str, source, taken, datagrams| {
            let mut said = counting(health(kind, name, 1, S), taken);
            said.counters[Counter::Datagrams] = datagrams;
            Health { source, ..said }
        };
        let apart = |book: &HealthBook, kind, name, stands_for_source| {
            let counters = book.apart_from_sources(kind, name, stands_for_source).unwrap();
            [Counter::Taken, Counter::Datagrams].map(|counter| counters[counter])
        };
        let (adapter, recorder) = (ProcessKind::Adapter, ProcessKind::Recorder);
        book.hear(&of(adapter, "radar", NO_SOURCE, 9, 3));
        assert_eq!(apart(&book, adapter, "radar", true), [0, 3], "it speaks of its source");
        assert_eq!(apart(&book, adapter, "radar", false), [9, 3], "it has no source");
        book.hear(&of(adapter, "radar", 0, 5, 0));
        book.hear(&of(adapter, "radar", 1, 2, 0));
        assert_eq!(
            apart(&book, adapter, "radar", false),
            [2, 3],
            "of no source that is configured"
        );
        book.hear(&of(recorder, "recorder", NO_SOURCE, 9, 0));
        book.hear(&of(recorder, "recorder", 0, 50, 0));
        assert_eq!(apart(&book, recorder, "recorder", false), [9, 0], "system tracks");
    }
}
