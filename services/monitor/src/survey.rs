//! All that the monitor knows, and the summaries drawn from it.
//!
//! Pure: messages and times go in, summaries come out. The agent decides when.

use std::collections::BTreeMap;

use bus::{SubscriberCounts, WaitMode};
use configuration::{Config, Input, MonitorWait, ReportOrder};
use messages::{Alarm, BatchHeader, Counter, CounterClass, Counters, Health, NO_SOURCE, ProcessKind, SystemTrack};
use runtime::{Now, Options, Speed};
use telemetry::{
    Buckets, Deadlines, HealthBook, Journey, JourneyEnd, Process, Span, Stage, Stages, State, process_title as title,
};

use crate::display::overview::{AlarmRow, Overview, ProcessRow, SourceRow, stage_rows};
use crate::exposition::{Counted, Snapshot, StageSample};
use crate::report::{
    AlarmReport, Hop, Losses, NOT_MEASURED, Picture, ProcessCounters, Report, Restarts, RunSettings, SourceReport,
    SourceStageReport, StageReport, Verdict,
};
use crate::truth_watch::TruthWatch;
use crate::verdict;

/// Survey of a deployment.
#[derive(Debug)]
pub(crate) struct Survey {
    settings: RunSettings,
    /// Name of the monitor itself.
    name: String,
    sources: Vec<Watched>,
    /// The processes of the deployment, the monitor itself last.
    expected: Vec<(ProcessKind, String)>,
    has_recorder: bool,
    begun: Now,
    stages: Stages,
    book: HealthBook,
    truth: Option<TruthWatch>,
    live_max: u64,
    /// Reports that fusion had taken at the end of the previous interval, per source, and when it said so.
    taken_before: Vec<(u64, i64)>,
}

/// A source, as far as the monitor needs to know it.
#[derive(Debug)]
struct Watched {
    number: u16,
    name: String,
    /// Name of the adapter process that speaks of it.
    adapter: String,
}

impl Survey {
    /// Nothing is known yet.
    ///
    /// # Errors
    /// If the simulated world cannot be made.
    pub(crate) fn new(config: &Config, options: &Options, name: &str, begun: Now) -> anyhow::Result<Self> {
        let sources: Vec<Watched> = config
            .sources
            .iter()
            .map(|source| Watched {
                number: source.number,
                name: source.name.clone(),
                adapter: source.adapter.clone(),
            })
            .collect();
        Ok(Self {
            settings: run_settings(config, options),
            name: name.to_owned(),
            expected: expected(config, name),
            has_recorder: config.recorder,
            begun,
            stages: Stages::new(journey(config)),
            book: HealthBook::new(sources.len()),
            truth: TruthWatch::new(config, options, begun.utc_ns)?,
            live_max: 0,
            taken_before: vec![(0, 0); sources.len()],
            sources,
        })
    }

    /// A slice of system tracks has been received.
    pub(crate) fn receive(&mut self, header: &BatchHeader, tracks: &[SystemTrack], received: Now) {
        let received_utc_ns = received.utc_ns.saturating_add(self.book.host_offset_ns());
        for track in tracks {
            if self.settings.latencies_measured {
                self.stages.record(track, received.mono_ns, received_utc_ns);
            }
            if let Some(truth) = &mut self.truth {
                truth.keep(header.incarnation, track);
            }
        }
    }

    /// A process has spoken.
    pub(crate) fn hear(&mut self, health: &Health) {
        self.book.hear(health);
        if health.kind() == Some(ProcessKind::Fusion) && health.source == NO_SOURCE {
            self.live_max = self.live_max.max(health.counters[Counter::LiveTracks]);
        }
    }

    /// Forgets processes that have joined the deployment and left without a word, if `is_gone` says so of their number.
    pub(crate) fn forget_guests(&mut self, now: Now, is_gone: impl Fn(u32) -> bool) {
        self.book.forget_guests(&self.expected, now.mono_ns, is_gone);
    }

    /// Whether the launcher stops the deployment.
    pub(crate) fn is_stopping(&self) -> bool {
        let launcher = self.book.whole(ProcessKind::Launcher, ProcessKind::Launcher.word());
        launcher.is_some_and(|launcher| launcher.counters()[Counter::Stopping] > 0)
    }

    /// Time passes.
    pub(crate) fn pass(&mut self, now: Now) {
        if let Some(truth) = &mut self.truth {
            truth.pass(now.utc_ns);
        }
    }

    /// When time has to pass again at the latest, UTC, nanoseconds.
    pub(crate) fn due_utc_ns(&self) -> i64 {
        self.truth.as_ref().map_or(i64::MAX, TruthWatch::due_ns)
    }

    /// Latencies by stage and source.
    pub(crate) fn stages(&self) -> &Stages {
        &self.stages
    }

    /// The name of a source.
    pub(crate) fn source_name(&self, number: u16) -> &str {
        let found = self.sources.iter().find(|source| source.number == number);
        found.map_or("others", |source| &source.name)
    }

    /// The name of a source, as a text of its own.
    pub(crate) fn name_of(&self, number: u16) -> String {
        self.source_name(number).to_owned()
    }

    /// All that the processes have said.
    pub(crate) fn book(&self) -> &HealthBook {
        &self.book
    }

    /// Whether those whose last words the final report waits for have said them, or will not.
    pub(crate) fn others_have_ended(&self, now: Now) -> bool {
        let watching = [ProcessKind::Monitor, ProcessKind::Keeper, ProcessKind::Launcher];
        self.processes(now).iter().all(|process| {
            let may_speak = matches!(process.state, State::Life(life) if life != messages::LifeState::Finished);
            watching.contains(&process.kind) || !may_speak
        })
    }

    /// Ends the interval at hand.
    pub(crate) fn close_interval(&mut self) {
        self.stages.close_interval();
    }

    /// Does a part of that; `false`: it was the last.
    pub(crate) fn close_next_source(&mut self) -> bool {
        self.stages.close_next_source()
    }

    /// Overview of the interval that was closed last, which took `interval_ns`.
    pub(crate) fn overview(
        &mut self,
        now: Now,
        interval_ns: i64,
        own: SubscriberCounts,
        standing: &[Alarm],
    ) -> Overview {
        let sources: Vec<SourceRow> = (0..self.sources.len()).map(|index| self.source_row(index)).collect();
        // Data of recordings are as old as the recordings.
        let is_shown = |stage| stage != Stage::Age || self.settings.recorded_sources == 0;
        Overview {
            instance: self.settings.instance.clone(),
            utc_ns: now.utc_ns,
            elapsed_ns: now.mono_ns - self.begun.mono_ns,
            interval_ns,
            recording_ns: self.recording_reached_ns(),
            picture: self.picture(),
            tracks: Vec::new(),
            stages: stage_rows(&self.stages, &sources, is_shown),
            counters: Vec::new(),
            processes: self.processes(now).iter().map(ProcessRow::new).collect(),
            alarms: standing.iter().filter_map(AlarmRow::new).collect(),
            queues_are_full: !self.settings.latencies_measured,
            sources,
            missed: own.lost,
        }
    }

    fn source_row(&mut self, index: usize) -> SourceRow {
        let Watched { number, name, adapter } = &self.sources[index];
        let adapter = self.book.adapter(adapter, *number);
        let said = self.book.said(ProcessKind::Fusion, ProcessKind::Fusion.word(), *number);
        let (before, mut before_ns) = self.taken_before[index];
        if let (0, Some(said)) = (before_ns, &said) {
            // Not heard before: its rate since it started.
            before_ns = said.incarnation() as i64;
        }
        let (fusion, said_ns) = said.map_or_else(Default::default, |said| (said.counters(), said.said_ns()));
        let taken = fusion[Counter::Taken];
        // Both counts and both times are fusion's own, so the rate is exact whenever its message came.
        let per_s = if before_ns > 0 && said_ns > before_ns {
            taken.saturating_sub(before) as f64 * 1e9 / (said_ns - before_ns) as f64
        } else {
            0.0
        };
        self.taken_before[index] = (taken, said_ns);
        SourceRow {
            number: *number,
            name: name.clone(),
            taken,
            per_s,
            rejected: adapter.sum_of(CounterClass::Rejection),
            lost: fusion[Counter::Lost],
            not_used: fusion.sum_of(CounterClass::FusionRejection),
            late: self.late(Some(*number)),
        }
    }

    /// The final report.
    pub(crate) fn report(&self, now: Now, own: SubscriberCounts, alarms: Vec<AlarmReport>) -> Report {
        let sources: Vec<SourceReport> = self.sources.iter().map(|source| self.source_report(source)).collect();
        let processes = self.processes(now);
        let stage = |stage| (stage, StageReport::new(&self.stages, stage));
        let mut report = Report {
            settings: self.settings.clone(),
            begun_utc_ns: self.begun.utc_ns,
            duration_s: (now.mono_ns - self.begun.mono_ns) as f64 / 1e9,
            recording_reached_utc_ns: self.recording_reached_ns(),
            verdict: Verdict::default(),
            losses: self.losses(&sources, own, &processes),
            sources,
            latency_remark: self.settings.monitor_poll_ms.map(|_| NOT_MEASURED.to_owned()),
            stages: Stage::ALL.map(stage).to_vec(),
            picture: self.picture(),
            accuracy: self.truth.as_ref().map(TruthWatch::report),
            restarts: restarts(&processes),
            alarms,
            processes,
            fusion: self.book.service(ProcessKind::Fusion, NO_SOURCE),
            others: self.others(),
            monitor: self.own_counters(own),
            network: self.network(),
            health_rejected: self.book.rejected(),
        };
        report.verdict = verdict::on(&report);
        report
    }

    /// State for a collector of metrics.
    pub(crate) fn snapshot(&self, now: Now, own: SubscriberCounts) -> Snapshot {
        let journey = self.stages.journey();
        let measured = || Stage::ALL.into_iter().filter(|stage| stage.is_measured(journey.end));
        let of_source = |stage, number| {
            let histogram = self.stages.histogram(stage, Some(number), Span::Total)?;
            let late = || self.stages.deadline_misses(stage, Some(number), Span::Total);
            Some(StageSample {
                stage,
                source: self.source_name(number).to_owned(),
                buckets: Buckets::from(histogram),
                late: journey.deadlines.get(stage).map(|_| late()),
            })
        };
        let of_stage = |stage| self.stages.sources().filter_map(move |number| of_source(stage, number));
        let counted = self.book.all_said().flat_map(|(kind, number, said)| {
            let counted = |source: &str, counters| Counted {
                kind,
                process: said.name().to_owned(),
                source: source.to_owned(),
                counters,
            };
            if number != NO_SOURCE {
                return vec![counted(self.source_name(number), said.counters())];
            }
            let whole = self.apart_from_sources(kind, said.name());
            let mut all = vec![counted("", whole.unwrap_or_default())];
            // An adapter that speaks of itself only, means its source.
            let sources = self
                .sources
                .iter()
                .filter(|source| kind == ProcessKind::Adapter && source.adapter == said.name());
            let sources = sources.filter(|source| self.book.said(kind, said.name(), source.number).is_none());
            all.extend(sources.map(|source| counted(&source.name, said.counters().without_those_of_processes())));
            all
        });
        Snapshot {
            settings: self.settings.clone(),
            stages: measured().flat_map(of_stage).collect(),
            deadlines: measured()
                .filter_map(|stage| Some((stage, journey.deadlines.get(stage)?)))
                .collect(),
            irregularities: measured()
                .map(|stage| (stage, self.stages.irregularities(stage)))
                .collect(),
            counted: counted.collect(),
            picture: self.picture(),
            processes: self.processes(now),
            alarms: Vec::new(),
            registrations: self
                .sources
                .iter()
                .map(|source| (source.name.clone(), self.book.registration(source.number)))
                .collect(),
            monitor_missed: own.lost,
            health_rejected: self.book.rejected(),
        }
    }

    fn source_report(&self, source: &Watched) -> SourceReport {
        let number = source.number;
        let of_stage = |stage| {
            let report = SourceStageReport {
                summary: self.stages.summary(stage, Some(number), Span::Total),
                deadline_misses: self.stages.deadline_misses(stage, Some(number), Span::Total),
            };
            (stage, report)
        };
        SourceReport {
            number,
            name: source.name.clone(),
            adapter: self.book.adapter(&source.adapter, number),
            fusion: self.book.service(ProcessKind::Fusion, number),
            recorder: self.book.service(ProcessKind::Recorder, number),
            registration: self.book.registration(number),
            stages: Stage::ALL.map(of_stage).to_vec(),
        }
    }

    fn losses(&self, sources: &[SourceReport], own: SubscriberCounts, processes: &[Process]) -> Losses {
        let hop = |from: &str, to: ProcessKind, published, read: &Counters| {
            // A recorder knows by its files what died with its predecessors, counted by them or not.
            let (taken, lost) = (
                read[Counter::Taken],
                read[Counter::Lost].max(read[Counter::MissingRows]),
            );
            Hop::new(from, to.word(), published, taken, lost)
        };
        let is_restarted_monitor = |process: &Process| {
            process.kind == ProcessKind::Monitor && process.name == self.name && process.restarts > 0
        };
        let published = |source: &SourceReport| source.adapter[Counter::Published];
        let to_fusion =
            |source: &SourceReport| hop(&source.name, ProcessKind::Fusion, published(source), &source.fusion);
        let mut hops: Vec<Hop> = sources.iter().map(to_fusion).collect();
        let reports_lost = hops.iter().map(|hop| hop.lost).sum();
        let reports_unread = hops.iter().map(|hop| hop.unread).sum();
        let fusion = ProcessKind::Fusion.word();
        let fused = self.book.service(ProcessKind::Fusion, NO_SOURCE)[Counter::Published];
        if self.has_recorder {
            let to_recorder =
                |source: &SourceReport| hop(&source.name, ProcessKind::Recorder, published(source), &source.recorder);
            hops.extend(sources.iter().map(to_recorder));
            let read = self.book.service(ProcessKind::Recorder, NO_SOURCE);
            hops.push(hop(fusion, ProcessKind::Recorder, fused, &read));
        }
        hops.push(Hop::new(fusion, &self.name, fused, own.taken, own.lost));
        Losses {
            complete: !processes.iter().any(is_restarted_monitor),
            reports_lost,
            reports_unread,
            hops,
            monitor_missed: own.lost,
        }
    }

    fn picture(&self) -> Picture {
        Picture::of(&self.book.service(ProcessKind::Fusion, NO_SOURCE), self.live_max)
    }

    fn recording_reached_ns(&self) -> Option<i64> {
        let fusion = self.book.whole(ProcessKind::Fusion, ProcessKind::Fusion.word())?;
        fusion.progress_ns().filter(|_| self.settings.recorded_sources > 0)
    }

    /// How all processes are.
    pub(crate) fn processes(&self, now: Now) -> Vec<Process> {
        self.book.processes(&self.expected, now.mono_ns)
    }

    /// Counters of the monitor for the system tracks.
    pub(crate) fn own_counters(&self, own: SubscriberCounts) -> Counters {
        let mut counters = Counters::default();
        counters[Counter::Taken] = own.taken;
        counters[Counter::Lost] = own.lost;
        counters[Counter::RejectedOutOfOrder] = own.out_of_order;
        counters[Counter::RejectedSchema] = own.schema_mismatch;
        counters[Counter::RejectedEpoch] = own.of_older_epochs;
        counters[Counter::RejectedInvalid] = self.book.rejected();
        self.count_late(None, &mut counters);
        counters
    }

    /// The same, source by source: which deadlines their reports have missed.
    pub(crate) fn own_counters_by_source(&self) -> impl Iterator<Item = (u16, Counters)> + '_ {
        let numbers = self.stages.sources().filter(|number| *number != NO_SOURCE);
        numbers.map(|number| {
            let mut counters = Counters::default();
            self.count_late(Some(number), &mut counters);
            (number, counters)
        })
    }

    fn count_late(&self, source: Option<u16>, counters: &mut Counters) {
        counters[Counter::DeadlineMisses] = self.stages.deadline_misses(Stage::TakenToFused, source, Span::Total);
        counters[Counter::StagesLate] = self.late(source);
    }

    /// Stages that took longer than their deadlines, of one source's reports or (`None`) of all.
    fn late(&self, source: Option<u16>) -> u64 {
        let misses = |stage| self.stages.deadline_misses(stage, source, Span::Total);
        Stage::ALL.into_iter().map(misses).sum()
    }

    /// Counters of a process for none of its sources.
    fn apart_from_sources(&self, kind: ProcessKind, name: &str) -> Option<Counters> {
        let has_source = self.sources.iter().any(|source| source.adapter == name);
        let stands_for_source = kind == ProcessKind::Adapter && has_source;
        self.book.apart_from_sources(kind, name, stands_for_source)
    }

    /// Counters of the processes but fusion and the monitor, for none of their sources.
    fn others(&self) -> Vec<ProcessCounters> {
        let apart = [ProcessKind::Fusion, ProcessKind::Monitor];
        let others = self.expected.iter().filter(|(kind, _)| !apart.contains(kind));
        let said = others.filter_map(|(kind, name)| {
            Some(ProcessCounters {
                process: title(*kind, name),
                counters: self.apart_from_sources(*kind, name)?,
            })
        });
        said.collect()
    }

    /// Counters of the processes with a socket.
    fn network(&self) -> Vec<ProcessCounters> {
        let mut said = self.others();
        said.retain(|report| {
            let classes = [CounterClass::Network, CounterClass::NetworkTrouble];
            classes.iter().any(|class| report.counters.sum_of(*class) > 0)
        });
        said
    }
}

/// Stages that are measured, and how far they go.
fn journey(config: &Config) -> Journey {
    Journey {
        end: match config.monitor.wait {
            MonitorWait::Event => JourneyEnd::Received,
            MonitorWait::Poll { .. } => JourneyEnd::Published,
        },
        deadlines: match config.order {
            ReportOrder::Arrival => config.monitor.deadlines,
            // Reports wait for each other by intention: nobody is late.
            ReportOrder::Time => Deadlines::default(),
        },
        ..Journey::default()
    }
}

/// The processes of a deployment, the monitor called `monitor` last.
fn expected(config: &Config, monitor: &str) -> Vec<(ProcessKind, String)> {
    let service = |kind: ProcessKind| (kind, kind.word().to_owned());
    let adapters = config
        .adapters()
        .into_iter()
        .map(|name| (ProcessKind::Adapter, name.to_owned()));
    let mut expected: Vec<(ProcessKind, String)> = adapters.collect();
    expected.push(service(ProcessKind::Fusion));
    let gateways = config
        .gateways
        .iter()
        .map(|gateway| (ProcessKind::Gateway, gateway.name.clone()));
    expected.extend(gateways);
    let links = config.links.iter().map(|link| (ProcessKind::Link, link.name.clone()));
    expected.extend(links);
    expected.extend(config.is_simulated().then(|| service(ProcessKind::Simulator)));
    expected.extend(config.recorder.then(|| service(ProcessKind::Recorder)));
    expected.push((ProcessKind::Monitor, monitor.to_owned()));
    expected
}

fn restarts(processes: &[Process]) -> Restarts {
    let restarted = processes.iter().filter(|process| process.restarts > 0);
    let by_process: BTreeMap<String, u32> = restarted.map(|process| (process.title(), process.restarts)).collect();
    Restarts {
        total: by_process.values().map(|count| u64::from(*count)).sum(),
        by_process,
    }
}

fn run_settings(config: &Config, options: &Options) -> RunSettings {
    let count = |of: fn(&Input) -> bool| config.sources.iter().filter(|source| of(&source.input)).count();
    let recorded = count(|input| matches!(input, Input::Recorded(_)));
    let simulated = count(|input| matches!(input, Input::Simulated(_)));
    let speed = match options.speed {
        Speed::Factor(factor) => factor.to_string(),
        Speed::Max => "max".to_owned(),
    };
    RunSettings {
        deployment: config.name.clone(),
        instance: options.instance.clone(),
        rule: config.fusion.settings.rule.name.0.word().to_owned(),
        order: match config.order {
            ReportOrder::Arrival => "arrival",
            ReportOrder::Time => "time",
        },
        wait: match config.fusion.wait {
            WaitMode::Spin => "spin",
            WaitMode::Event => "event",
            WaitMode::Hybrid { .. } => "hybrid",
        },
        recorded_sources: recorded,
        simulated_sources: simulated,
        live_sources: config.sources.len() - recorded - simulated,
        speed: (recorded > 0).then_some(speed),
        latencies_measured: recorded == 0 || options.speed != Speed::Max,
        seed: (simulated > 0).then_some(options.seed),
        targets: config
            .scenario
            .as_ref()
            .filter(|_| simulated > 0)
            .map(|world| world.target_count(options.seed)),
        interval_s: config.monitor.interval_ns as f64 / 1e9,
        deadline_us: config.fusion.deadline_ns as f64 / 1e3,
        monitor_wait: match config.monitor.wait {
            MonitorWait::Event => "event",
            MonitorWait::Poll { .. } => "poll",
        },
        monitor_poll_ms: match config.monitor.wait {
            MonitorWait::Event => None,
            MonitorWait::Poll { pause } => Some(pause.as_secs_f64() * 1e3),
        },
    }
}
