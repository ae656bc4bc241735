//! Conditions of alarms, evaluated on health messages and on the room left on the machine.
//!
//! Each function evaluates one kind of condition (a source's silence, counters that should not grow, the processes,
//! …) and reports its findings for the round. The board decides on raising and clearing.

use alarms::{AlarmKind, Apart, Companions, Finding, Growth, Limits, Round, Silence, Subject, Usual, above, below};
use messages::{BatchHeader, Counter, LifeState, NO_SOURCE, ProcessKind, Registration, SystemTrack};
use observed::{Deployment, Process, Source, State, process_title as title};
use runtime::Now;

use crate::machine::Room;
use crate::shares::Shares;
use crate::text::{elapsed, several};

const MB: f64 = 1e6;
/// Period of the search for sources that never join, nanoseconds.
const COMPANIONS_NS: i64 = 5_000_000_000;
/// Difference of clocks that counts as agreement, besides the latency of the data, seconds.
const CLOCKS_AGREE_S: f64 = 1.0;
/// Number of comparisons after which an estimate of a source's errors counts as settled.
const COMPARISONS_MIN: f64 = 500.0;
/// Change of an estimate that exceeds chance, standard deviations.
const CHANGE_SIGMAS: f64 = 5.0;
/// Number of reports after which a source's probability of detection is known, and the loss that raises an alarm.
const DETECTION_REPORTS: u64 = 2_000;
const DETECTION_LOSS: f64 = 0.15;

/// Counters that should not grow: alarm, counters, counted objects, and the process that counts.
type Growing = (AlarmKind, &'static [Counter], &'static str, &'static [ProcessKind]);
const GROWING: &[Growing] = {
    use ProcessKind::{Adapter, Fusion, Gateway, Link, Recorder, Simulator};
    &[
        (
            AlarmKind::SamplesLost,
            &[Counter::Lost, Counter::RecordedLost],
            "sample",
            &[Fusion, Recorder, Gateway, Adapter, Link],
        ),
        (
            AlarmKind::LostOnTheWay,
            &[Counter::Unsent, Counter::LostOnTheWay],
            "sample",
            &[Link],
        ),
        (
            AlarmKind::RecordingFailed,
            &[Counter::RecordingFailures],
            "attempt",
            &[Recorder, Adapter],
        ),
        (
            AlarmKind::DatagramsDropped,
            &[Counter::DatagramsDropped],
            "datagram",
            &[Adapter],
        ),
        (
            AlarmKind::SendFailed,
            &[Counter::SendFailures],
            "datagram",
            &[Gateway, Simulator],
        ),
        (
            AlarmKind::CapacityReached,
            &[Counter::DroppedQueue, Counter::DroppedTable],
            "report",
            &[Fusion],
        ),
        (
            AlarmKind::CapacityReached,
            &[Counter::TracksDropped],
            "report",
            &[Adapter, Gateway],
        ),
        (
            AlarmKind::ReportQuarantined,
            &[Counter::Quarantined],
            "report",
            &[Fusion],
        ),
        (
            AlarmKind::LayoutMismatch,
            &[Counter::RejectedSchema],
            "slice",
            &[Fusion, Recorder, Gateway, Link],
        ),
    ]
};

/// View of a deployment in one round.
#[derive(Clone, Copy)]
pub(crate) struct Sight<'a> {
    pub(crate) observed: &'a Deployment,
    /// Processes of the deployment, and others with health messages.
    pub(crate) processes: &'a [Process],
    pub(crate) room: Room,
    pub(crate) now: Now,
}

/// All conditions, with their memory.
#[derive(Debug)]
pub(crate) struct Conditions {
    limits: Limits,
    /// Name of the monitor.
    own_name: String,
    folder: String,
    sources: Vec<Watched>,
    silence: Silence,
    shares: Shares,
    growth: Growth,
    companions: Companions,
    apart: Vec<Apart>,
    apart_due_ns: i64,
    /// Whether the data have the times of a recording.
    is_recorded: bool,
}

/// Source, as far as its alarms need.
#[derive(Debug)]
struct Watched {
    facts: Source,
    usual: [Usual; ERRORS.len()],
    usual_detection: Usual,
    /// Fusion process of the estimates, and the number of reports taken by its predecessors.
    learner: (u64, u64),
}

impl Watched {
    /// Part of a clock's offset that the latency of the data does not explain, seconds: a sensor may take one of its
    /// periods to send a measurement.
    fn clock_excess_s(&self, offset_s: f64) -> f64 {
        match offset_s < 0.0 {
            true => -offset_s - self.facts.period_ns as f64 / messages::NS_PER_S,
            false => offset_s,
        }
    }
}

/// Systematic error: name, unit, relevant change, and estimate with standard deviation.
type SourceError = (&'static str, &'static str, f64, fn(&Registration) -> (f64, f64));
const ERRORS: [SourceError; 5] = [
    ("offset east", "m", 30.0, |known| {
        (known.offset_m[0], known.offset_sigma_m[0])
    }),
    ("offset north", "m", 30.0, |known| {
        (known.offset_m[1], known.offset_sigma_m[1])
    }),
    ("time offset", "s", 0.2, |known| {
        (known.time_offset_s, known.time_offset_sigma_s)
    }),
    ("range bias", "m", 30.0, |known| {
        (known.range_bias_m, known.range_bias_sigma_m)
    }),
    ("azimuth bias", "°", 0.1, |known| {
        (
            known.azimuth_bias_rad.to_degrees(),
            known.azimuth_bias_sigma_rad.to_degrees(),
        )
    }),
];

impl Conditions {
    /// Creates the conditions of the deployment of `config`, with files in `folder`.
    pub(crate) fn new(
        (config, limits): (&deployment::Deployment, Limits),
        own_name: &str,
        folder: String,
        begun: Now,
    ) -> Self {
        let watched = |facts| Watched {
            facts,
            usual: [Usual::default(); ERRORS.len()],
            usual_detection: Usual::default(),
            learner: (0, 0),
        };
        let sources: Vec<Watched> = config.observed_sources().into_iter().map(watched).collect();
        Self {
            limits,
            own_name: own_name.to_owned(),
            folder,
            silence: Silence::new(sources.len(), begun.mono_ns),
            shares: Shares::new(),
            growth: Growth::default(),
            companions: Companions::default(),
            apart: Vec::new(),
            apart_due_ns: begun.mono_ns + COMPANIONS_NS,
            is_recorded: config.is_recorded(),
            sources,
        }
    }

    /// Takes a slice of system tracks.
    pub(crate) fn receive(&mut self, header: &BatchHeader, tracks: &[SystemTrack], now: Now) {
        for track in tracks {
            self.companions.take(header.incarnation, track, now.mono_ns);
        }
    }

    /// Evaluates all conditions.
    pub(crate) fn look(&mut self, sight: Sight<'_>, round: &mut Round<'_>) {
        let awake_ns = self.silence.look(sight.now.mono_ns);
        self.silent_sources(sight, round);
        self.source_errors(sight, round);
        self.shares.look(sight.observed, sight.now.mono_ns, round);
        self.changed(sight, round);
        self.never_joined(sight.now, round);
        self.data_off(sight, round);
        self.growing_counters(sight, round);
        self.misfits(sight, round);
        self.processes(sight, awake_ns, round);
        self.links(sight, round);
        self.room(sight.room, round);
    }

    /// Conditions of links to other hosts.
    fn links(&self, sight: Sight<'_>, round: &mut Round<'_>) {
        for link in sight
            .processes
            .iter()
            .filter(|process| process.kind == Some(ProcessKind::Link))
        {
            let Some(latest) = sight.observed.book().whole(ProcessKind::Link, &link.name) else {
                continue;
            };
            let (subject, counters) = (Subject::process(&link.name), latest.counters());
            let values = [("process", link.title()), ("note", link.note.clone())];
            if counters[Counter::MissingPeers] > 0 {
                round.find(AlarmKind::PeerMissing, subject, Finding::Bad, &values);
            }
            let off_ms = counters[Counter::HostClockOffUs] as f64 / 1e3;
            if let Some(finding) = above(off_ms, self.limits.host_clock_ms) {
                let [process, note] = values;
                let offset = ("offset", format!("{off_ms:.0} ms"));
                round.find(AlarmKind::HostClockOff, subject, finding, &[process, note, offset]);
            }
        }
    }

    fn silent_sources(&mut self, sight: Sight<'_>, round: &mut Round<'_>) {
        for (index, source) in self.sources.iter().enumerate() {
            let is_adapter =
                |process: &&Process| process.kind == Some(ProcessKind::Adapter) && process.name == source.facts.adapter;
            let adapter = sight.processes.iter().find(is_adapter);
            let runs = |process: &Process| process.state == State::Life(LifeState::Running);
            let is_expected = source.facts.is_external || adapter.is_some_and(runs);
            let delivered = sight.observed.delivered(source.facts.number);
            let may_be_silent = !is_expected || source.facts.silent_after_ns.is_none();
            let silent_ns = self.silence.of(index, delivered, may_be_silent);
            if source
                .facts
                .silent_after_ns
                .is_some_and(|after_ns| silent_ns > after_ns)
            {
                let values = [
                    ("source", source.facts.name.clone()),
                    ("silence", elapsed(silent_ns)),
                    ("periods", (silent_ns / source.facts.period_ns.max(1)).to_string()),
                ];
                round.find(
                    AlarmKind::SourceSilent,
                    Subject::source(source.facts.number),
                    Finding::Bad,
                    &values,
                );
            }
        }
    }

    /// Finds the wrong clock where sources' clocks and the machine's differ, by the offset of sound clocks against
    /// the machine's, seconds.
    fn machine_clock(&self, sight: Sight<'_>, round: &mut Round<'_>) -> f64 {
        let known = |source: &&Watched| {
            sight
                .observed
                .book()
                .registration(source.facts.number)
                .clock_offset_sigma_s
                > 0.0
        };
        let offset_s = |source: &Watched| sight.observed.book().registration(source.facts.number).clock_offset_s;
        let sources = || self.sources.iter().filter(known);
        let agreeing = |of_s: f64| sources().filter(move |source| (offset_s(source) - of_s).abs() <= CLOCKS_AGREE_S);
        let limit_s = self.limits.clock_off_s.s();
        let found_s = sight.observed.book().host_offset_ns() as f64 / messages::NS_PER_S;
        // Below the limit on time steps, fusion leaves all times unchanged; most sources show the offset all the
        // same.
        let is_off = |source: &&Watched| source.clock_excess_s(offset_s(source)) - CLOCKS_AGREE_S > limit_s;
        let most = sources().filter(is_off).map(offset_s).find(|of_s| {
            let count = agreeing(*of_s).count();
            count >= 2 && 2 * count > sources().count()
        });
        let common_s = if found_s.abs() > limit_s {
            found_s
        } else {
            most.unwrap_or(0.0)
        };
        if common_s == 0.0 {
            return 0.0;
        }
        let names: Vec<&str> = agreeing(common_s).map(|source| source.facts.name.as_str()).collect();
        let (kind, subject) = match sources().count() {
            0 | 1 => (AlarmKind::ClocksDiffer, Subject::default()),
            _ => (AlarmKind::MachineClockOff, Subject::default()),
        };
        let values = [
            ("offset", format!("{:+.1} s", -common_s)),
            ("sources", names.join(", ")),
            ("source", names.first().unwrap_or(&"the source").to_string()),
        ];
        round.find(kind, subject, Finding::Bad, &values);
        common_s
    }

    /// Conditions of fusion's estimates of the sources.
    fn source_errors(&mut self, sight: Sight<'_>, round: &mut Round<'_>) {
        let common_s = self.machine_clock(sight, round);
        for source in &self.sources {
            let known = sight.observed.book().registration(source.facts.number);
            let subject = Subject::source(source.facts.number);
            let name = || ("source", source.facts.name.clone());
            let sigma_s = known.clock_offset_sigma_s;
            let offset_s = if sigma_s > 0.0 {
                known.clock_offset_s - common_s
            } else {
                0.0
            };
            let excess_s = source.clock_excess_s(offset_s);
            // Two standard deviations: a difference within chance raises no alarm.
            let certain_s = if sigma_s > 0.0 { excess_s - 2.0 * sigma_s } else { 0.0 };
            if let Some(finding) = above(certain_s, self.limits.clock_off_s.s()) {
                let values = [name(), ("offset", format!("{offset_s:+.2} s"))];
                round.find(AlarmKind::ClockOff, subject, finding, &values);
            }
            if let Some(error) = known.gross_error() {
                let partner = self.sources.get(usize::from(error.partner));
                let partner = partner.map_or_else(String::new, |partner| partner.facts.name.clone());
                let (subject, verdict) = match (error.is_certain, error.is_removed) {
                    (true, true) => (subject, ", and that is taken off".to_owned()),
                    (true, false) => (subject, String::new()),
                    _ => {
                        let pair = Subject::pair(source.facts.number, error.partner);
                        (pair, format!("; or {partner} is off the other way"))
                    }
                };
                let values = [
                    name(),
                    ("error", error.to_string()),
                    ("partner", partner),
                    ("verdict", verdict),
                ];
                round.find(AlarmKind::GrossError, subject, Finding::Bad, &values);
            }
            if let Some(finding) = above(known.covariance_inflation, self.limits.inflation) {
                let values = [name(), ("factor", format!("{:.1}", known.covariance_inflation))];
                round.find(AlarmKind::AccuracyOverstated, subject, finding, &values);
            }
        }
    }

    /// Conditions of changes: of biases, and of the sources' probabilities of detection.
    fn changed(&mut self, sight: Sight<'_>, round: &mut Round<'_>) {
        let now_ns = sight.now.mono_ns;
        for source in &mut self.sources {
            let known = sight.observed.book().registration(source.facts.number);
            let subject = Subject::source(source.facts.number);
            let compared = known.comparisons >= COMPARISONS_MIN;
            for (usual, (error, unit, margin, estimate)) in source.usual.iter_mut().zip(ERRORS) {
                let (value, sigma) = estimate(&known);
                let settled = compared && sigma > 0.0 && CHANGE_SIGMAS * sigma < margin;
                let Some((before, sigma_before)) = usual.before(value, sigma, settled, now_ns) else {
                    continue;
                };
                let limit = margin.max(CHANGE_SIGMAS * sigma.hypot(sigma_before));
                if let Some(finding) = above((value - before).abs(), limit) {
                    let values = [
                        ("source", source.facts.name.clone()),
                        ("error", error.to_owned()),
                        ("before", format!("{before:+.2} {unit}")),
                        ("now", format!("{value:+.2} {unit}")),
                    ];
                    round.find(AlarmKind::BiasChanged, subject, finding, &values);
                }
            }
            let Some(latest) =
                sight
                    .observed
                    .book()
                    .about(ProcessKind::Fusion, ProcessKind::Fusion.word(), source.facts.number)
            else {
                continue;
            };
            let counters = latest.counters();
            let taken = counters[Counter::Taken];
            if source.learner.0 != latest.incarnation() {
                // A restarted process learns from the beginning.
                source.learner = (latest.incarnation(), taken);
            }
            let settled = taken - source.learner.1 > DETECTION_REPORTS;
            let detection = counters[Counter::DetectionPermille] as f64 / 1e3;
            if let Some((before, _)) = source.usual_detection.before(detection, 0.0, settled, now_ns)
                && let Some(finding) = above(before - detection, DETECTION_LOSS)
            {
                let percent = |share: f64| format!("{:.0} %", 100.0 * share);
                let values = [
                    ("source", source.facts.name.clone()),
                    ("now", percent(detection)),
                    ("before", percent(before)),
                ];
                round.find(AlarmKind::DetectionFell, subject, finding, &values);
            }
        }
    }

    fn never_joined(&mut self, now: Now, round: &mut Round<'_>) {
        if now.mono_ns >= self.apart_due_ns {
            self.apart_due_ns = now.mono_ns + COMPANIONS_NS;
            self.apart = self.companions.apart(now.mono_ns);
        }
        let name = |number: u16| {
            self.sources
                .get(usize::from(number))
                .map(|source| source.facts.name.clone())
        };
        for apart in &self.apart {
            let (Some(source), Some(partner)) = (name(apart.source), name(apart.partner)) else {
                continue;
            };
            let [east_km, north_km] = apart.shift_m.map(|metres| metres / 1e3);
            let values = [
                ("source", source),
                ("partner", partner),
                ("pairs", several(apart.pairs as u64, "track")),
                ("shift", format!("{east_km:+.1} km east and {north_km:+.1} km north")),
            ];
            let subject = Subject::pair(apart.source, apart.partner);
            round.find(AlarmKind::NeverJoined, subject, Finding::Bad, &values);
        }
    }

    fn growing_counters(&mut self, sight: Sight<'_>, round: &mut Round<'_>) {
        for (kind, source, latest) in sight.observed.book().all() {
            // A process's message as a whole repeats the counts of its sources.
            let counters = match source {
                NO_SOURCE => sight
                    .observed
                    .book()
                    .apart_from_sources(kind, latest.name(), false)
                    .unwrap_or_default(),
                _ => latest.counters(),
            };
            let of_kind = GROWING.iter().filter(|(.., kinds)| kinds.contains(&kind));
            for (alarm, which, thing, _) in of_kind {
                let count = which.iter().map(|counter| counters[*counter]).sum();
                let subject = Subject::process(latest.name()).of_source(source);
                let at_first = if latest.is_seen_from_start() { 0 } else { count };
                if self.growth.has_grown(*alarm, subject, count, at_first) {
                    let of = match self.sources.iter().find(|other| other.facts.number == source) {
                        Some(source) => format!(" of {}", source.facts.name),
                        None => String::new(),
                    };
                    let values = [
                        ("process", title(kind, latest.name())),
                        ("count", several(count, thing)),
                        ("of", of),
                    ];
                    round.find(*alarm, subject, Finding::Bad, &values);
                }
            }
        }
    }

    /// Conditions of states whose time differs from the machine's.
    fn data_off(&self, sight: Sight<'_>, round: &mut Round<'_>) {
        let offset_ns = sight.observed.data_offset_ns(sight.now.mono_ns);
        let Some(offset_ns) = offset_ns.filter(|_| !self.is_recorded) else {
            return;
        };
        // The fastest source may take one of its periods to send a measurement.
        let period_ns = self.sources.iter().map(|source| source.facts.period_ns).min();
        let excess_ns = match offset_ns < 0 {
            true => -offset_ns - period_ns.unwrap_or_default(),
            false => offset_ns,
        };
        let seconds = |ns: i64| ns as f64 / messages::NS_PER_S;
        if let Some(finding) = above(seconds(excess_ns), self.limits.data_off_s.s()) {
            let values = [("offset", format!("{:+.1} s", seconds(offset_ns)))];
            round.find(AlarmKind::DataOff, Subject::process(&self.own_name), finding, &values);
        }
    }

    /// Conditions of received data outside the configuration.
    fn misfits(&mut self, sight: Sight<'_>, round: &mut Round<'_>) {
        for (kind, source, latest) in sight
            .observed
            .book()
            .all()
            .filter(|(kind, ..)| *kind == ProcessKind::Adapter)
        {
            let counters = latest.counters();
            let of = |counter: Counter| counters[counter];
            let subject = Subject::process(latest.name()).of_source(source);
            let senders = of(Counter::UnknownSenders);
            let rejected = of(Counter::RejectedSource);
            // Data received before a restart of the monitor continue if they matter.
            if senders > 0 && self.growth.has_grown(AlarmKind::SenderUnknown, subject, rejected, 0) {
                let [sac, sic] = (of(Counter::UnknownSender) as u16).to_be_bytes();
                let others = match senders - 1 {
                    0 => String::new(),
                    others => format!(", and {}", several(others, "other")),
                };
                let values = [
                    ("process", title(kind, latest.name())),
                    ("sender", format!("SAC/SIC {sac}/{sic}")),
                    ("blocks", several(of(Counter::UnknownSenderBlocks), "block")),
                    ("others", others),
                ];
                round.find(AlarmKind::SenderUnknown, subject, Finding::Bad, &values);
            }
            let fitting = of(Counter::BlocksOfOtherEdition);
            if self.growth.has_grown(AlarmKind::EditionWrong, subject, fitting, 0)
                && let Some(source) = self.sources.iter().find(|other| other.facts.number == source)
            {
                let [_, category, major, minor] = (of(Counter::OtherEdition) as u32).to_be_bytes();
                let values = [
                    ("source", source.facts.name.clone()),
                    ("fitting", several(fitting, "block")),
                    ("category", format!("{category:03}")),
                    ("edition", format!("{major}.{minor}")),
                ];
                round.find(
                    AlarmKind::EditionWrong,
                    Subject::source(source.facts.number),
                    Finding::Bad,
                    &values,
                );
            }
        }
    }

    fn processes(&mut self, sight: Sight<'_>, awake_ns: i64, round: &mut Round<'_>) {
        let own_restarts = sight
            .observed
            .book()
            .children()
            .find(|child| child.name == self.own_name);
        // A monitor restarted itself has no record of the other processes' starts.
        let seen_from_start = own_restarts.is_none_or(|own| own.restarts == 0);
        if let Some(launcher) = sight
            .observed
            .book()
            .whole(ProcessKind::Launcher, ProcessKind::Launcher.word())
        {
            let rebuilds = launcher.counters()[Counter::Rebuilds];
            let subject = Subject::default();
            if self.growth.has_grown(AlarmKind::MemoryCorrupt, subject, rebuilds, 0) {
                let values = [("times", several(rebuilds, "time"))];
                round.find(AlarmKind::MemoryCorrupt, subject, Finding::Bad, &values);
            }
        }
        if let Some(fusion) = sight
            .observed
            .book()
            .whole(ProcessKind::Fusion, ProcessKind::Fusion.word())
        {
            let subject = Subject::process(ProcessKind::Fusion.word());
            let [times, still] =
                [Counter::TakeOvers, Counter::TakeOversFromStill].map(|counter| fusion.counters()[counter]);
            let at_first = if seen_from_start { 0 } else { times };
            if self
                .growth
                .has_grown(AlarmKind::FusionTakenOver, subject, times, at_first)
            {
                let values = [("times", several(times, "time")), ("still", still.to_string())];
                round.find(AlarmKind::FusionTakenOver, subject, Finding::Bad, &values);
            }
        }
        for child in sight.observed.book().children() {
            let subject = Subject::process(child.name);
            let process = ("process", child.name.to_owned());
            let end = match child.last_end {
                "" => "has ended".to_owned(),
                end => end.to_owned(),
            };
            let count = u64::from(child.restarts);
            let at_first = if seen_from_start || child.name == self.own_name {
                0
            } else {
                count
            };
            if self
                .growth
                .has_grown(AlarmKind::ProcessRestarted, subject, count, at_first)
            {
                let values = [process.clone(), ("times", several(count, "time")), ("end", end.clone())];
                round.find(AlarmKind::ProcessRestarted, subject, Finding::Bad, &values);
            }
            if child.life == LifeState::Failed {
                round.find(AlarmKind::ProcessDown, subject, Finding::Bad, &[process, ("end", end)]);
            }
        }
        let ended = |process: &Process| {
            let mut children = sight.observed.book().children();
            children.any(|child| {
                child.name == process.name && matches!(child.life, LifeState::Failed | LifeState::Finished)
            })
        };
        let limit_ns = self.limits.process_silent_s.ns();
        for process in sight.processes.iter().filter(|process| !ended(process)) {
            let State::Silent { for_ns } = process.state else {
                continue;
            };
            if for_ns.min(sight.now.mono_ns - awake_ns) > limit_ns {
                let values = [("process", process.title()), ("silence", elapsed(for_ns))];
                round.find(
                    AlarmKind::ProcessHung,
                    Subject::process(&process.name),
                    Finding::Bad,
                    &values,
                );
            }
        }
    }

    fn room(&self, room: Room, round: &mut Round<'_>) {
        let limits = [
            self.limits.disk_free_mb,
            self.limits.memory_free_mb,
            self.limits.memory_free_mb,
        ];
        let looked_at = [
            (AlarmKind::DiskLow, room.disk, ("folder", self.folder.clone()), ""),
            (
                AlarmKind::MemoryLow,
                room.memory,
                ("what", "the machine's memory".to_owned()),
                "",
            ),
            (
                AlarmKind::MemoryLow,
                room.shared,
                ("what", "the shared memory".to_owned()),
                "shm",
            ),
        ];
        for ((kind, octets, what, subject), limit_mb) in looked_at.into_iter().zip(limits) {
            let Some(free_mb) = octets.map(|octets| octets as f64 / MB) else {
                continue;
            };
            if let Some(finding) = below(free_mb, limit_mb) {
                let values = [("free", format!("{free_mb:.0} MB")), what];
                round.find(kind, Subject::process(subject), finding, &values);
            }
        }
    }
}
