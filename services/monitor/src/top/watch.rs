//! Puts together what is heard of a deployment. Pure: messages and times go in, an overview comes out.

use std::collections::{BTreeMap, BTreeSet};

use alarms::Present;
use bus::SubscriberCounts;
use frames::{Geodetic, SystemFrame};
use messages::{
    Alarm, BatchHeader, Counter, CounterClass, Counters, FrameOrigin, Health, LifeState, NO_SOURCE, ProcessKind,
    SystemTrack,
};
use runtime::Now;
use telemetry::{Journey, JourneyEnd, Stages};

use crate::display::overview::{AlarmRow, CounterRow, Overview, ProcessRow, SourceRow, joined, stage_rows};
use crate::display::tracks::LatestStates;
use crate::report::Picture;
use telemetry::{HealthBook, Latest, State, process_title as title};

/// Most system tracks whose states are kept.
const TRACKS_MAX: usize = 20_000;

/// Process that speaks, and the source that it speaks of.
type Speaker = (ProcessKind, String, u16);

/// Counters of a speaker, and when it stated them (monotonic, nanoseconds).
type Said = (i64, Counters);

/// Watch over a deployment.
#[derive(Debug)]
pub(crate) struct Watch {
    instance: String,
    begun: Now,
    stages: Stages,
    book: HealthBook,
    /// Counters at the end of the previous interval, or the first ones: rates count from there.
    before: BTreeMap<Speaker, Said>,
    live_max: u64,
    alarms: Present,
    states: LatestStates,
    /// System frame, once somebody has said which it is.
    frame: Option<SystemFrame>,
    ended: bool,
}

impl Watch {
    /// Nothing is known yet of the deployment that runs as `instance`.
    pub(crate) fn new(instance: &str, begun: Now) -> Self {
        let journey = Journey {
            end: JourneyEnd::Published,
            ..Journey::default()
        };
        Self {
            instance: instance.to_owned(),
            begun,
            stages: Stages::new(journey),
            // Nobody says how many sources there are.
            book: HealthBook::new(usize::from(NO_SOURCE)),
            before: BTreeMap::new(),
            live_max: 0,
            alarms: Present::default(),
            states: LatestStates::new(TRACKS_MAX),
            frame: None,
            ended: false,
        }
    }

    /// A slice of system tracks has come from the fusion process of `incarnation`.
    pub(crate) fn receive(&mut self, incarnation: u64, tracks: &[SystemTrack], received: Now) {
        let received_utc_ns = received.utc_ns.saturating_add(self.book.host_offset_ns());
        for track in tracks {
            self.stages.record(track, received.mono_ns, received_utc_ns);
            self.states.keep(incarnation, track);
        }
    }

    /// Somebody has said where the system frame lies; a place that is none is not believed.
    pub(crate) fn place(&mut self, origin: &FrameOrigin) {
        let place = Geodetic::from_degrees(origin.latitude_deg, origin.longitude_deg, origin.height_m);
        self.frame = place.ok().map(SystemFrame::at).or(self.frame);
    }

    /// The monitor has said which alarms stand.
    pub(crate) fn hear_alarms(&mut self, header: &BatchHeader, slice: &[Alarm]) {
        self.alarms.hear(header, slice);
    }

    /// A process has spoken.
    pub(crate) fn hear(&mut self, health: &Health) {
        self.book.hear(health);
        let Some(kind) = health.kind() else { return };
        if kind == ProcessKind::Fusion && health.source == NO_SOURCE {
            self.live_max = self.live_max.max(health.counters[Counter::LiveTracks]);
        }
        let is_launcher = kind == ProcessKind::Launcher && health.name() == kind.word();
        if is_launcher {
            self.ended = health.life() == Some(LifeState::Finished);
        }
        let speaker = (kind, health.name().to_owned(), health.source);
        if !self.before.contains_key(&speaker)
            && let Some(said) = self.book.said(kind, health.name(), health.source)
        {
            self.before.insert(speaker, (said.said_ns(), said.counters()));
        }
    }

    /// Whether the launcher has said that everything has ended.
    pub(crate) fn has_ended(&self) -> bool {
        self.ended
    }

    /// Ends the interval at hand, which took `interval_ns`. `own` is what was counted at the system tracks here.
    pub(crate) fn close_interval(&mut self, now: Now, interval_ns: i64, own: SubscriberCounts) -> Overview {
        self.stages.close_interval();
        let sources = self.sources();
        let waited = |row: &CounterRow| row.counter == Counter::WaitedForConsumers && row.per_s > 0.0;
        let counters = self.counters(&sources);
        let overview = Overview {
            instance: self.instance.clone(),
            utc_ns: now.utc_ns,
            elapsed_ns: now.mono_ns - self.begun.mono_ns,
            interval_ns,
            recording_ns: None,
            picture: self.picture(),
            tracks: self.states.rows(self.frame.as_ref(), now.utc_ns),
            stages: stage_rows(&self.stages, &sources, |_| true),
            queues_are_full: counters.iter().any(waited),
            counters,
            processes: self.processes(now),
            alarms: self
                .alarms
                .at(now.mono_ns)
                .unwrap_or_default()
                .iter()
                .filter_map(AlarmRow::new)
                .collect(),
            sources,
            missed: own.lost,
        };
        let said = self.book.all_said();
        self.before = said
            .map(|(kind, source, said)| {
                let speaker = (kind, said.name().to_owned(), source);
                (speaker, (said.said_ns(), said.counters()))
            })
            .collect();
        overview
    }

    fn sources(&self) -> Vec<SourceRow> {
        let spoken_of = |(kind, source, _): (ProcessKind, u16, Latest<'_>)| {
            let knows = matches!(kind, ProcessKind::Adapter | ProcessKind::Fusion);
            (knows && source != NO_SOURCE).then_some(source)
        };
        let numbers: BTreeSet<u16> = self.book.all_said().filter_map(spoken_of).collect();
        numbers.into_iter().map(|number| self.source(number)).collect()
    }

    fn source(&self, number: u16) -> SourceRow {
        let name = self.book.source_name(number);
        let adapter = self.book.adapter_of(number);
        let fusion = self.book.said(ProcessKind::Fusion, ProcessKind::Fusion.word(), number);
        let taken_per_s = fusion.as_ref().map_or(0.0, |said| {
            self.per_s(ProcessKind::Fusion, number, said, Counter::Taken)
        });
        let fusion = fusion.map_or_else(Counters::default, |said| said.counters());
        let of_monitors = self
            .book
            .all_said()
            .filter(|(kind, source, _)| *kind == ProcessKind::Monitor && *source == number);
        SourceRow {
            number,
            // In files, sources count from 1 too.
            name: name.map_or_else(|| format!("source {}", number + 1), str::to_owned),
            taken: fusion[Counter::Taken],
            per_s: taken_per_s,
            rejected: adapter.sum_of(CounterClass::Rejection),
            lost: fusion[Counter::Lost],
            not_used: fusion.sum_of(CounterClass::FusionRejection),
            // Several monitors count the same.
            late: of_monitors
                .map(|(.., said)| said.counters()[Counter::StagesLate])
                .max()
                .unwrap_or(0),
        }
    }

    /// How fast a counter has grown since the previous interval, by the speaker's own clock.
    fn per_s(&self, kind: ProcessKind, source: u16, said: &Latest<'_>, counter: Counter) -> f64 {
        let speaker = (kind, said.name().to_owned(), source);
        let Some((before_ns, before)) = self.before.get(&speaker) else {
            return 0.0;
        };
        let seconds = (said.said_ns() - before_ns) as f64 / messages::NS_PER_S;
        if seconds <= 0.0 {
            return 0.0;
        }
        said.counters()[counter].saturating_sub(before[counter]) as f64 / seconds
    }

    fn counters(&self, sources: &[SourceRow]) -> Vec<CounterRow> {
        let name = |number: u16| {
            let found = sources.iter().find(|source| source.number == number);
            found.map_or_else(String::new, |source| source.name.clone())
        };
        let mut rows = Vec::new();
        for (kind, source, said) in self.book.all_said() {
            let counters = said.counters();
            let counted = Counter::ALL
                .iter()
                .filter(|counter| counter.class() != CounterClass::Level);
            for counter in counted.filter(|counter| counters[**counter] > 0) {
                rows.push(CounterRow {
                    process: title(kind, said.name()),
                    source: name(source),
                    counter: *counter,
                    value: counters[*counter],
                    per_s: self.per_s(kind, source, &said, *counter),
                });
            }
        }
        rows
    }

    fn picture(&self) -> Picture {
        Picture::of(&self.book.service(ProcessKind::Fusion, NO_SOURCE), self.live_max)
    }

    fn processes(&self, now: Now) -> Vec<ProcessRow> {
        let known = self.book.processes(&[], now.mono_ns).into_iter();
        let silent = self.book.silent_children().map(|child| ProcessRow {
            title: child.name.to_owned(),
            state: State::Life(child.life),
            pid: child.pid,
            restarts: child.restarts,
            note: joined(child.last_end, "has not said anything"),
        });
        known.map(|process| ProcessRow::new(&process)).chain(silent).collect()
    }
}

#[cfg(test)]
mod tests {
    use messages::StageTimes;
    use telemetry::{Span, Stage};

    use super::*;
    use test_support::S;

    const UTC_NS: i64 = 1_700_000_000 * S;

    fn now(s: f64) -> Now {
        let ns = (s * 1e9) as i64;
        Now {
            mono_ns: 100 * S + ns,
            utc_ns: UTC_NS + ns,
        }
    }

    fn said(s: f64, kind: ProcessKind, name: &str, source: u16, counters: &[(Counter, u64)]) -> Health {
        let mut health = Health {
            said_ns: now(s).mono_ns,
            incarnation: 7,
            process_id: 40 + kind as u32,
            source,
            kind: kind as u8,
            life: LifeState::Running as u8,
            ..Health::default()
        };
        for (counter, value) in counters {
            health.counters[*counter] = *value;
        }
        health.with_name(name)
    }

    fn closed(watch: &mut Watch, s: f64) -> Overview {
        watch.close_interval(now(s), S, SubscriberCounts::default())
    }

    #[test]
    fn sources_are_put_together_from_what_adapter_fusion_and_monitor_say() {
        let mut watch = Watch::new("demo", now(0.0));
        let (adapter, fusion, monitor) = (ProcessKind::Adapter, ProcessKind::Fusion, ProcessKind::Monitor);
        let rejected = [(Counter::RejectedJump, 3), (Counter::RejectedTime, 2)];
        watch.hear(&said(0.1, adapter, "antenna", 4, &rejected).with_note("ads-b"));
        let taken = |s, taken| said(s, fusion, "fusion", 4, &[(Counter::Taken, taken), (Counter::Lost, 9)]);
        watch.hear(&taken(0.1, 1_000));
        watch.hear(&taken(0.6, 1_100));
        watch.hear(&said(0.6, fusion, "fusion", 2, &[(Counter::DroppedQueue, 6)]));
        watch.hear(&said(0.6, monitor, "monitor", 4, &[(Counter::StagesLate, 8)]));
        let overview = closed(&mut watch, 1.0);
        let [second, fourth] = &overview.sources[..] else {
            panic!("{overview:?}")
        };
        assert_eq!((second.name.as_str(), second.not_used), ("source 3", 6));
        assert_eq!((fourth.name.as_str(), fourth.taken, fourth.lost), ("ads-b", 1_100, 9));
        assert_eq!((fourth.rejected, fourth.late), (5, 8));
        assert_eq!(fourth.per_s, 200.0, "by fusion's own clock");
        watch.hear(&taken(1.6, 1_150));
        assert_eq!(closed(&mut watch, 2.0).sources[1].per_s, 50.0);
        assert_eq!(
            closed(&mut watch, 3.0).sources[1].per_s,
            0.0,
            "it has said nothing since"
        );
    }

    #[test]
    fn a_restarted_fusion_counts_on() {
        let mut watch = Watch::new("demo", now(0.0));
        let fusion = |s, incarnation, taken| Health {
            incarnation,
            ..said(s, ProcessKind::Fusion, "fusion", 0, &[(Counter::Taken, taken)])
        };
        watch.hear(&fusion(0.2, 1, 500));
        closed(&mut watch, 1.0);
        watch.hear(&fusion(1.2, 9, 100));
        let overview = closed(&mut watch, 2.0);
        assert_eq!((overview.sources[0].taken, overview.sources[0].per_s), (600, 100.0));
        assert_eq!(overview.processes[0].restarts, 1);
    }

    #[test]
    fn latencies_end_where_fusion_has_published() {
        let mut watch = Watch::new("demo", now(0.0));
        let received = now(0.5);
        let track = SystemTrack {
            trigger_source: 0,
            time_of_measurement_ns: received.utc_ns - S,
            stages: StageTimes {
                ingested_ns: received.mono_ns - 5_000,
                published_ns: received.mono_ns - 4_000,
                taken_ns: received.mono_ns - 3_000,
                fused_ns: received.mono_ns - 1_000,
            },
            ..SystemTrack::default()
        };
        watch.hear(&said(0.1, ProcessKind::Fusion, "fusion", 0, &[]));
        watch.receive(1, &[track; 3], received);
        let overview = closed(&mut watch, 1.0);
        let end_to_end = overview.stage(Stage::EndToEnd, Some(0), Span::Total);
        assert_eq!((end_to_end.count, end_to_end.max_ns / 10), (3, 400));
        assert!(overview.stages.iter().all(|row| row.stage != Stage::FusedToReceived));
        let later = closed(&mut watch, 2.0);
        let counts = [Span::Interval, Span::Total].map(|span| later.stage(Stage::EndToEnd, None, span).count);
        assert_eq!(counts, [0, 3]);
    }

    #[test]
    fn the_launchers_last_word_is_the_end_and_its_children_are_listed() {
        let mut watch = Watch::new("demo", now(0.0));
        let launcher = ProcessKind::Launcher;
        watch.hear(&said(0.1, launcher, "launcher", NO_SOURCE, &[]));
        let of_child = Health {
            restarts: 2,
            ..said(0.1, launcher, "radar", 0, &[])
        };
        watch.hear(&of_child.with_note("was killed by SIGKILL"));
        assert!(!watch.has_ended());
        let overview = closed(&mut watch, 1.0);
        let rows: Vec<(&str, Option<u32>, u32)> = overview
            .processes
            .iter()
            .map(|process| (process.title.as_str(), process.pid, process.restarts))
            .collect();
        assert_eq!(rows, [("launcher", Some(44), 0), ("radar", Some(44), 2)]);
        assert_eq!(
            overview.processes[1].note,
            "the last one was killed by SIGKILL; has not said anything"
        );
        let finished = Health {
            life: LifeState::Finished as u8,
            ..said(1.1, launcher, "launcher", NO_SOURCE, &[])
        };
        watch.hear(&finished);
        assert!(watch.has_ended());
    }

    #[test]
    fn every_counter_that_is_not_zero_is_listed_with_its_rate() {
        let mut watch = Watch::new("demo", now(0.0));
        let counters: Vec<(Counter, u64)> = Counter::ALL.iter().map(|counter| (*counter, 5)).collect();
        watch.hear(&said(0.1, ProcessKind::Adapter, "radar", 0, &[]));
        watch.hear(&said(0.6, ProcessKind::Adapter, "radar", 0, &counters).with_note("radar-west"));
        let overview = closed(&mut watch, 1.0);
        assert_eq!(
            overview.counters.len(),
            Counter::ALL.len() - Counter::of(CounterClass::Level).count()
        );
        let row = &overview.counters[0];
        assert_eq!(
            (row.process.as_str(), row.source.as_str()),
            ("adapter radar", "radar-west")
        );
        assert_eq!((row.value, row.per_s), (5, 10.0));
        assert!(overview.queues_are_full, "somebody waits for consumers");
    }
}
