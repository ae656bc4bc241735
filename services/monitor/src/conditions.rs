//! Conditions of alarms, evaluated on health messages and on the room left on the machine.
//!
//! Each function evaluates one kind of condition (a source's silence, counters that should not grow, the processes, …)
//! and reports its findings for the round. The board decides on raising and clearing. This module has the conditions of
//! processes, links and the machine. The submodules have the others: `sources` of sources, `counters` of counters,
//! `feeding` of publishers from outside, `refused` of refused data.

mod counters;
mod feeding;
mod refused;
mod sources;

use std::collections::{BTreeMap, BTreeSet};

use alarms::{AlarmKind, Apart, Companions, Finding, Growth, Limits, Round, Silence, Subject, above, below};
use messages::{BatchHeader, Counter, LifeState, ProcessKind, SystemTrack};
use observed::{Deployment, ObservedProcess, ProcessState};
use runtime::Now;

use crate::feeders::FeedFindings;
use crate::machine::Room;
use crate::shares::SourceShares;
use crate::text::{elapsed, several};
use sources::{COMPANIONS_NS, SourceWatch};

const MB: f64 = 1e6;

/// View of a deployment in a round.
#[derive(Clone, Copy)]
pub(crate) struct RoundView<'a> {
    pub(crate) observed: &'a Deployment,
    /// Processes of the deployment, and others with health messages.
    pub(crate) processes: &'a [ObservedProcess],
    pub(crate) room: Room,
    pub(crate) feeding: &'a FeedFindings,
    pub(crate) now: Now,
}

/// All conditions, with memory.
#[derive(Debug)]
pub(crate) struct Conditions {
    limits: Limits,
    /// Name of the monitor.
    own_name: String,
    folder: String,
    sources: Vec<SourceWatch>,
    silence: Silence,
    shares: SourceShares,
    refusals: refused::Refusals,
    useless: refused::Useless,
    /// Sources of lines that `koseki feed` refused, and the monotonic time of the latest, nanoseconds.
    refused_lines: BTreeMap<String, i64>,
    growth: Growth,
    companions: Companions,
    apart: Vec<Apart>,
    apart_due_ns: i64,
    /// Whether the data have the times of a recording.
    is_recorded: bool,
}

impl Conditions {
    /// Creates the conditions of the deployment of `config`, with files in `folder`.
    pub(crate) fn new(
        (config, limits): (&deployment::Deployment, Limits),
        own_name: &str,
        folder: String,
        begun: Now,
    ) -> Self {
        let sources: Vec<SourceWatch> = config.observed_sources().into_iter().map(SourceWatch::new).collect();
        Self {
            limits,
            own_name: own_name.to_owned(),
            folder,
            silence: Silence::new(sources.len(), begun.mono_ns),
            shares: SourceShares::new(),
            refusals: refused::memory(),
            useless: refused::memory(),
            refused_lines: BTreeMap::new(),
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
    pub(crate) fn look(&mut self, sight: RoundView<'_>, round: &mut Round<'_>) {
        let awake_ns = self.silence.look(sight.now.mono_ns);
        let arriving = self.refused(sight, round);
        self.silent_sources(sight, &arriving, round);
        self.source_errors(sight, round);
        self.shares.look(sight.observed, sight.now.mono_ns, round);
        self.changed(sight, round);
        self.never_joined(sight, round);
        self.data_off(sight, round);
        self.growing_counters(sight, round);
        self.misfits(sight, round);
        self.processes(sight, awake_ns, round);
        self.links(sight, round);
        self.platforms(sight, &arriving, round);
        Self::copies(sight, round);
        self.room(sight.room, round);
        self.feeding(sight, round);
    }

    /// Conditions of links to other hosts.
    fn links(&self, sight: RoundView<'_>, round: &mut Round<'_>) {
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
            if counters[Counter::ExpiringCertificates] > 0 {
                round.find(AlarmKind::CertificateExpires, subject, Finding::Bad, &values);
            }
            let off_ms = counters[Counter::HostClockOffUs] as f64 / 1e3;
            if let Some(finding) = above(off_ms, self.limits.host_clock_ms) {
                let [process, note] = values;
                let offset = ("offset", format!("{off_ms:.0} ms"));
                round.find(AlarmKind::HostClockOff, subject, finding, &[process, note, offset]);
            }
        }
    }

    /// Conditions of the copies on disk for a start after a loss of power.
    fn copies(sight: RoundView<'_>, round: &mut Round<'_>) {
        for keeper in sight
            .processes
            .iter()
            .filter(|process| process.kind == Some(ProcessKind::Keeper))
        {
            let latest = sight.observed.book().whole(ProcessKind::Keeper, &keeper.name);
            if latest.is_some_and(|latest| latest.counters()[Counter::CopiesFailing] > 0) {
                let values = [("note", keeper.note.clone())];
                round.find(
                    AlarmKind::CheckpointUnkept,
                    Subject::process(&keeper.name),
                    Finding::Bad,
                    &values,
                );
            }
        }
    }

    /// Conditions of platforms that carry sensors.
    fn platforms(&mut self, sight: RoundView<'_>, arriving: &BTreeSet<Subject>, round: &mut Round<'_>) {
        for adapter in sight
            .processes
            .iter()
            .filter(|process| process.kind == Some(ProcessKind::Adapter))
        {
            let Some(latest) = sight.observed.book().whole(ProcessKind::Adapter, &adapter.name) else {
                continue;
            };
            let (subject, counters) = (Subject::process(&adapter.name), latest.counters());
            let process = ("process", adapter.title());
            let silent_ms = counters[Counter::PlatformSilentMs];
            if silent_ms > 0 && !arriving.contains(&subject) {
                let silence = ("silence", elapsed(silent_ms as i64 * 1_000_000));
                round.find(
                    AlarmKind::PlatformSilent,
                    subject,
                    Finding::Bad,
                    &[process.clone(), silence],
                );
            }
            let far_km = counters[Counter::PlatformFarKm];
            if far_km > 0 {
                let distance = ("distance", format!("{far_km} km"));
                round.find(
                    AlarmKind::PlatformFar,
                    subject,
                    Finding::Bad,
                    &[process.clone(), distance],
                );
            }
            let jumps = counters[Counter::PlatformJumps];
            if self.growth.has_grown(AlarmKind::PlatformJumped, subject, jumps, 0) {
                let count = ("count", several(jumps, "time"));
                round.find(AlarmKind::PlatformJumped, subject, Finding::Bad, &[process, count]);
            }
        }
    }

    /// Conditions of states with a time that differs from the machine's.
    fn data_off(&self, sight: RoundView<'_>, round: &mut Round<'_>) {
        let now_ns = sight.now.mono_ns;
        let offset_ns = sight.observed.data_offset_ns(now_ns).filter(|_| !self.is_recorded);
        let Some((offset_ns, excess_ns)) = offset_ns.zip(sight.observed.unexplained_offset_ns(now_ns)) else {
            return;
        };
        let seconds = |ns: i64| ns as f64 / messages::NS_PER_S;
        if let Some(finding) = above(seconds(excess_ns).abs(), self.limits.data_off_s.s()) {
            let values = [("offset", format!("{:+.1} s", seconds(offset_ns)))];
            round.find(AlarmKind::DataOff, Subject::process(&self.own_name), finding, &values);
        }
    }

    fn processes(&mut self, sight: RoundView<'_>, awake_ns: i64, round: &mut Round<'_>) {
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
        let ended = |process: &ObservedProcess| {
            let mut children = sight.observed.book().children();
            children.any(|child| {
                child.name == process.name && matches!(child.life, LifeState::Failed | LifeState::Finished)
            })
        };
        let limit_ns = self.limits.process_silent_s.ns();
        for process in sight.processes.iter().filter(|process| !ended(process)) {
            let ProcessState::Silent { for_ns } = process.state else {
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
