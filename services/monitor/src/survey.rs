//! All observations of the monitor, and the derived summaries.
//!
//! Pure: messages and times go in, summaries come out. The agent decides when.

use std::collections::BTreeMap;

use bus::SubscriberCounts;
use deployment::SourceFacts;
use deployment::{Input, ReceiverTransport, ReportOrder, Source};
use messages::{Alarm, BatchHeader, Counter, CounterClass, Counters, NO_SOURCE, ProcessKind, SystemTrack};
use observed::{Deployment, ObservedProcess, ProcessState, process_title as title};
use runtime::{Now, Options, Speed};
use telemetry::{Buckets, Journey, JourneyEnd, Span, Stage};

use crate::display::overview::Overview;
use crate::exposition::{MetricsSnapshot, ProcessCounts, StageSample};
use crate::report::{
    AlarmReport, Hop, Losses, NOT_MEASURED, ProcessCounters, Report, Restarts, RunSettings, SourceReport,
    SourceStageReport, StageReport, Verdict,
};
use crate::settings::{MonitorWait, Settings};
use crate::truth_watch::{SimulatedTargets, TruthWatch};
use crate::verdict;

/// Survey of a deployment.
#[derive(Debug)]
pub(crate) struct DeploymentSurvey {
    settings: RunSettings,
    /// Name of the monitor itself.
    name: String,
    pub(crate) observed: Deployment,
    /// The processes of the deployment, the monitor itself last.
    expected: Vec<(ProcessKind, String)>,
    has_recorder: bool,
    begun: Now,
    truth: Option<TruthWatch>,
    tracks_max: usize,
    scenario_start_ns: i64,
    /// By the number of a source: states that the source's reports led to, and states among these with other
    /// contributors.
    states: BTreeMap<u16, [u64; 2]>,
}

impl DeploymentSurvey {
    /// Nothing is known yet.
    pub(crate) fn new(
        (config, monitor): (&deployment::Deployment, &Settings),
        options: &Options,
        name: &str,
        begun: Now,
    ) -> Self {
        let settings = run_settings(config, monitor, options);
        let observed = Deployment::new(config.observed_sources())
            .observed_since(begun.mono_ns)
            .with_latencies(journey(config, monitor), settings.latencies_measured);
        Self {
            settings,
            name: name.to_owned(),
            observed,
            expected: expected(config, name),
            has_recorder: config.services.recorder,
            begun,
            truth: None,
            tracks_max: config.system_tracks.max,
            scenario_start_ns: options.scenario_start_ns,
            states: BTreeMap::new(),
        }
    }

    /// Compares the picture with `targets` from now on.
    pub(crate) fn compare_with(&mut self, targets: SimulatedTargets) {
        let times_ns = (self.scenario_start_ns, self.begun.utc_ns);
        self.settings.targets = Some(targets.count);
        let compare = |visible| TruthWatch::new(visible, times_ns, self.tracks_max);
        self.truth = targets.visible.map(compare);
    }

    /// Takes a received slice of system tracks.
    pub(crate) fn receive(&mut self, header: &BatchHeader, tracks: &[SystemTrack], received: Now) {
        let is_another = self
            .observed
            .take_tracks(header, tracks, received.mono_ns, received.utc_ns);
        if let Some(truth) = &mut self.truth {
            truth.take(is_another, tracks);
        }
        for track in tracks.iter().filter(|track| track.trigger_source != NO_SOURCE) {
            let [all, joint] = self.states.entry(track.trigger_source).or_default();
            *all += 1;
            *joint += u64::from(track.source_count > 1);
        }
    }

    /// Forgets processes that have joined the deployment and left without a last message, if `is_gone` holds for the
    /// process number.
    pub(crate) fn forget_guests(&mut self, now: Now, is_gone: impl Fn(u32) -> bool) {
        self.observed.forget_guests(&self.expected, now.mono_ns, is_gone);
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

    /// Returns the name of a source.
    pub(crate) fn source_name(&self, number: u16) -> &str {
        self.observed.known_name(number).unwrap_or("others")
    }

    /// Whether the processes with last messages for the final report have sent these messages, or will not.
    pub(crate) fn others_have_ended(&self, now: Now) -> bool {
        let watching = [ProcessKind::Monitor, ProcessKind::Keeper, ProcessKind::Launcher];
        self.processes(now).iter().all(|process| {
            let may_speak = matches!(process.state, ProcessState::Life(life) if life != messages::LifeState::Finished);
            process.kind.is_some_and(|kind| watching.contains(&kind)) || !may_speak
        })
    }

    /// Overview of the interval that was closed last, which took `interval_ns`.
    pub(crate) fn overview(&self, now: Now, interval_ns: i64, own: SubscriberCounts, standing: &[Alarm]) -> Overview {
        // Data of recordings are as old as the recordings.
        let is_shown = |stage| stage != Stage::Age || self.settings.recorded_sources == 0;
        let mut overview = Overview {
            instance: self.settings.instance.clone(),
            utc_ns: now.utc_ns,
            elapsed_ns: now.mono_ns - self.begun.mono_ns,
            interval_ns,
            recording_ns: self.recording_reached_ns(),
            queues_are_full: !self.settings.latencies_measured,
            missed: own.lost,
            ..Overview::new(&self.observed, &self.processes(now), standing, is_shown)
        };
        for source in &mut overview.sources {
            source.late = self.late(Some(source.number));
        }
        overview
    }

    /// The final report.
    pub(crate) fn report(&self, now: Now, own: SubscriberCounts, alarms: Vec<AlarmReport>) -> Report {
        let sources = self.observed.configured_sources().iter();
        let sources = sources.filter(|source| !self.observed.is_counted_with_tracker(source));
        let sources: Vec<SourceReport> = sources.map(|source| self.source_report(source)).collect();
        let processes = self.processes(now);
        let stage = |stage| (stage, StageReport::new(self.observed.stages(), stage));
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
            picture: self.observed.track_counts(),
            accuracy: self.truth.as_ref().map(TruthWatch::report),
            restarts: restarts(&processes),
            alarms,
            processes,
            fusion: self.observed.book().service(ProcessKind::Fusion, NO_SOURCE),
            others: self.others(),
            monitor: self.own_counters(own),
            network: self.network(),
            refused: self.observed.refused_input(),
            health_rejected: self.observed.book().rejected(),
        };
        report.verdict = verdict::on(&report);
        report
    }

    /// State for a collector of metrics.
    pub(crate) fn snapshot(&self, now: Now, own: SubscriberCounts) -> MetricsSnapshot {
        let (stages, book) = (self.observed.stages(), self.observed.book());
        let journey = stages.journey();
        let measured = || Stage::ALL.into_iter().filter(|stage| stage.is_measured(journey.end));
        let of_source = |stage, number| {
            let histogram = stages.histogram(stage, Some(number), Span::Total)?;
            let late = || stages.deadline_misses(stage, Some(number), Span::Total);
            Some(StageSample {
                stage,
                source: self.source_name(number).to_owned(),
                buckets: Buckets::from(histogram),
                late: journey.deadlines.get(stage).map(|_| late()),
            })
        };
        let of_stage = |stage| stages.sources().filter_map(move |number| of_source(stage, number));
        let counted = book.all().flat_map(|(kind, number, latest)| {
            let counted = |source: &str, counters| ProcessCounts {
                kind,
                process: latest.name().to_owned(),
                source: source.to_owned(),
                counters,
            };
            if number != NO_SOURCE {
                return vec![counted(self.source_name(number), latest.counters())];
            }
            let whole = self.apart_from_sources(kind, latest.name());
            let mut all = vec![counted("", whole.unwrap_or_default())];
            // The messages of an adapter with a single source are about that source.
            let sources = self.observed.configured_sources().iter();
            let sources = sources.filter(|source| kind == ProcessKind::Adapter && source.adapter == latest.name());
            let sources = sources.filter(|source| book.about(kind, latest.name(), source.number).is_none());
            all.extend(sources.map(|source| counted(&source.name, latest.counters().without_those_of_processes())));
            all
        });
        MetricsSnapshot {
            settings: self.settings.clone(),
            stages: measured().flat_map(of_stage).collect(),
            deadlines: measured()
                .filter_map(|stage| Some((stage, journey.deadlines.get(stage)?)))
                .collect(),
            irregularities: measured().map(|stage| (stage, stages.irregularities(stage))).collect(),
            counted: counted.collect(),
            picture: self.observed.track_counts(),
            processes: self.processes(now),
            alarms: Vec::new(),
            registrations: self
                .observed
                .configured_sources()
                .iter()
                .map(|source| (source.name.clone(), book.registration(source.number)))
                .collect(),
            monitor_missed: own.lost,
            health_rejected: self.observed.book().rejected(),
        }
    }

    fn source_report(&self, source: &SourceFacts) -> SourceReport {
        let number = source.number;
        let (stages, state) = (self.observed.stages(), self.observed.source(number));
        let of_stage = |stage| {
            let report = SourceStageReport {
                summary: stages.summary(stage, Some(number), Span::Total),
                deadline_misses: stages.deadline_misses(stage, Some(number), Span::Total),
            };
            (stage, report)
        };
        let [states, joint_states] = self.states.get(&number).copied().unwrap_or_default();
        let scan_period_ms = state.adapter[Counter::ScanPeriodMs];
        SourceReport {
            number,
            name: state.name,
            sensor_of: source.sensor_of,
            scan_period_s: (scan_period_ms > 0).then_some(scan_period_ms as f64 / 1e3),
            states,
            joint_states,
            adapter: state.adapter,
            fusion: state.fusion,
            recorder: self.observed.book().service(ProcessKind::Recorder, number),
            registration: state.registration,
            stages: Stage::ALL.map(of_stage).to_vec(),
        }
    }

    fn losses(&self, sources: &[SourceReport], own: SubscriberCounts, processes: &[ObservedProcess]) -> Losses {
        let hop = |from: &str, to: ProcessKind, published, read: &Counters| {
            // A recorder derives from its files the losses of its predecessors, counted by the predecessors or not.
            let (taken, lost) = (
                read[Counter::Taken],
                read[Counter::Lost].max(read[Counter::MissingRows]),
            );
            Hop::new(from, to.word(), published, taken, lost)
        };
        let is_restarted_monitor = |process: &ObservedProcess| {
            process.kind == Some(ProcessKind::Monitor) && process.name == self.name && process.restarts > 0
        };
        let published = |source: &SourceReport| source.adapter[Counter::Published];
        let to_fusion =
            |source: &SourceReport| hop(&source.name, ProcessKind::Fusion, published(source), &source.fusion);
        // The detections of a tracker's sensor go to the tracker.
        let reporting = sources.iter().filter(|source| source.sensor_of.is_none());
        let mut hops: Vec<Hop> = reporting.map(to_fusion).collect();
        let reports_lost = hops.iter().map(|hop| hop.lost).sum();
        let reports_unread = hops.iter().map(|hop| hop.unread).sum();
        let fusion = ProcessKind::Fusion.word();
        let fused = self.observed.book().service(ProcessKind::Fusion, NO_SOURCE)[Counter::Published];
        if self.has_recorder {
            let to_recorder =
                |source: &SourceReport| hop(&source.name, ProcessKind::Recorder, published(source), &source.recorder);
            let reporting = sources.iter().filter(|source| source.sensor_of.is_none());
            hops.extend(reporting.map(to_recorder));
            let read = self.observed.book().service(ProcessKind::Recorder, NO_SOURCE);
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

    fn recording_reached_ns(&self) -> Option<i64> {
        let fusion = self
            .observed
            .book()
            .whole(ProcessKind::Fusion, ProcessKind::Fusion.word())?;
        fusion.progress_ns().filter(|_| self.settings.recorded_sources > 0)
    }

    /// How all processes are.
    pub(crate) fn processes(&self, now: Now) -> Vec<ObservedProcess> {
        self.observed.processes(&self.expected, now.mono_ns)
    }

    /// Counters of the monitor for the system tracks.
    pub(crate) fn own_counters(&self, own: SubscriberCounts) -> Counters {
        let mut counters = Counters::default();
        counters[Counter::Taken] = own.taken;
        counters[Counter::Lost] = own.lost;
        counters[Counter::RejectedOutOfOrder] = own.out_of_order;
        counters[Counter::RejectedSchema] = own.schema_mismatch;
        counters[Counter::RejectedEpoch] = own.of_older_epochs;
        counters[Counter::RejectedInvalid] = self.observed.book().rejected();
        self.count_late(None, &mut counters);
        counters
    }

    /// The same, source by source: deadlines that the source's reports have missed.
    pub(crate) fn own_counters_by_source(&self) -> impl Iterator<Item = (u16, Counters)> + '_ {
        let numbers = self.observed.stages().sources().filter(|number| *number != NO_SOURCE);
        numbers.map(|number| {
            let mut counters = Counters::default();
            self.count_late(Some(number), &mut counters);
            (number, counters)
        })
    }

    fn count_late(&self, source: Option<u16>, counters: &mut Counters) {
        counters[Counter::DeadlineMisses] =
            self.observed
                .stages()
                .deadline_misses(Stage::TakenToFused, source, Span::Total);
        counters[Counter::StagesLate] = self.late(source);
    }

    /// Stages that exceeded the deadlines, of a source's reports or (`None`) of all.
    fn late(&self, source: Option<u16>) -> u64 {
        let misses = |stage| self.observed.stages().deadline_misses(stage, source, Span::Total);
        Stage::ALL.into_iter().map(misses).sum()
    }

    /// Counters of a process that belong to no source.
    fn apart_from_sources(&self, kind: ProcessKind, name: &str) -> Option<Counters> {
        let mut sources = self.observed.configured_sources().iter();
        let has_source = sources.any(|source| source.adapter == name);
        let stands_for_source = kind == ProcessKind::Adapter && has_source;
        self.observed.book().apart_from_sources(kind, name, stands_for_source)
    }

    /// Counters of the processes but fusion and the monitor that belong to no source.
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

/// Measured stages, and the end of the journey.
fn journey(config: &deployment::Deployment, monitor: &Settings) -> Journey {
    Journey {
        end: match monitor.waiting(&config.fusion) {
            MonitorWait::Event => JourneyEnd::Received,
            MonitorWait::Poll { .. } => JourneyEnd::Published,
        },
        deadlines: monitor.deadlines(config),
        ..Journey::default()
    }
}

/// The processes of a deployment, the monitor called `monitor` last.
fn expected(config: &deployment::Deployment, monitor: &str) -> Vec<(ProcessKind, String)> {
    let service = |kind: ProcessKind| (kind, kind.word().to_owned());
    let adapters = config
        .adapters()
        .into_iter()
        .map(|name| (ProcessKind::Adapter, name.to_owned()));
    let mut expected: Vec<(ProcessKind, String)> = adapters.collect();
    expected.push(service(ProcessKind::Fusion));
    let gateways = config
        .services
        .gateways
        .iter()
        .map(|gateway| (ProcessKind::Gateway, gateway.name.clone()));
    expected.extend(gateways);
    let links = config.links.iter().map(|link| (ProcessKind::Link, link.name.clone()));
    expected.extend(links);
    expected.extend(config.is_simulated().then(|| service(ProcessKind::Simulator)));
    expected.extend(config.services.alerts.then(|| service(ProcessKind::Alerts)));
    expected.extend(config.services.recorder.then(|| service(ProcessKind::Recorder)));
    expected.push((ProcessKind::Monitor, monitor.to_owned()));
    expected
}

fn restarts(processes: &[ObservedProcess]) -> Restarts {
    let restarted = processes.iter().filter(|process| process.restarts > 0);
    let by_process: BTreeMap<String, u32> = restarted.map(|process| (process.title(), process.restarts)).collect();
    Restarts {
        total: by_process.values().map(|count| u64::from(*count)).sum(),
        by_process,
    }
}

/// Whether a sensor is simulated; a radar of a tracker is live behind a receiver of the simulator.
fn is_simulated(config: &deployment::Deployment, sensor: &Source) -> bool {
    match &sensor.input {
        Input::Simulated(_) => true,
        Input::Live(live) => config.receivers.iter().any(|receiver| {
            receiver.name == live.receiver && matches!(receiver.transport, ReceiverTransport::Loopback { .. })
        }),
        _ => false,
    }
}

fn run_settings(config: &deployment::Deployment, monitor: &Settings, options: &Options) -> RunSettings {
    // A tracker stands for its sensors; operators' orders are no sources.
    let sources = config
        .sources
        .iter()
        .flat_map(|source| match config.sensors_of(source) {
            [] => std::slice::from_ref(source),
            sensors => sensors,
        });
    let sensors: Vec<&Source> = sources.filter(|source| !source.takes_orders).collect();
    let recorded = sensors.iter().filter(|sensor| sensor.input.is_recorded()).count();
    let simulated = sensors.iter().filter(|sensor| is_simulated(config, sensor)).count();
    let speed = match options.speed {
        Speed::Factor(factor) => factor.to_string(),
        Speed::Max => "max".to_owned(),
    };
    RunSettings {
        deployment: config.name.clone(),
        instance: options.instance.clone(),
        rule: config.system_tracks.rule.word().to_owned(),
        order: match config.order {
            ReportOrder::Arrival => "arrival",
            ReportOrder::Time => "time",
        },
        wait: config.fusion.wait.word(),
        recorded_sources: recorded,
        simulated_sources: simulated,
        live_sources: sensors.len() - recorded - simulated,
        speed: (recorded > 0).then_some(speed),
        latencies_measured: recorded == 0 || options.speed != Speed::Max,
        seed: (simulated > 0).then_some(options.seed),
        targets: None,
        interval_s: monitor.interval_s.ns() as f64 / 1e9,
        deadline_us: config.fusion.deadline_ns() as f64 / 1e3,
        monitor_wait: match monitor.waiting(&config.fusion) {
            MonitorWait::Event => "event",
            MonitorWait::Poll { .. } => "poll",
        },
        monitor_poll_ms: match monitor.waiting(&config.fusion) {
            MonitorWait::Event => None,
            MonitorWait::Poll { pause } => Some(pause.as_secs_f64() * 1e3),
        },
    }
}
