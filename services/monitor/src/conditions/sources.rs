//! Conditions of the sources: silence, clocks, systematic errors, detection, sources that never join.

use std::collections::BTreeSet;

use alarms::{AlarmKind, Finding, Round, Subject, Usual, above};
use deployment::SourceFacts;
use messages::{Bias, BiasKind, Counter, LifeState, ProcessKind, Registration};
use observed::{ObservedProcess, ProcessState};

use super::{Conditions, RoundView};
use crate::text::{elapsed, several};

/// Period of the search for sources that never join, nanoseconds.
pub(super) const COMPANIONS_NS: i64 = 5_000_000_000;
/// Difference of clocks that counts as agreement, besides the latency of the data, seconds.
const CLOCKS_AGREE_S: f64 = 1.0;
/// Number of comparisons after which an estimate of a source's errors counts as settled.
const COMPARISONS_MIN: f64 = 500.0;
/// Change of an estimate that exceeds chance, standard deviations.
const CHANGE_SIGMAS: f64 = 5.0;
/// Number of reports after which a source's probability of detection is known, and the loss that raises an alarm.
const DETECTION_REPORTS: u64 = 2_000;
const DETECTION_LOSS: f64 = 0.15;

/// A source's facts for its alarms.
#[derive(Debug)]
pub(super) struct SourceWatch {
    pub(super) facts: SourceFacts,
    usual: [Usual; ERRORS.len()],
    usual_detection: Usual,
    /// Fusion process of the estimates, and the number of reports taken by the process's predecessors.
    learner: (u64, u64),
}

impl SourceWatch {
    pub(super) fn new(facts: SourceFacts) -> Self {
        Self {
            facts,
            usual: [Usual::default(); ERRORS.len()],
            usual_detection: Usual::default(),
            learner: (0, 0),
        }
    }

    /// Part of a clock's offset that the latency of the data does not explain, seconds: a sensor may take a whole
    /// period to send a measurement.
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
    /// Sources without records for longer than the configuration allows, except the sources in `arriving`, with refused
    /// data.
    pub(super) fn silent_sources(&mut self, sight: RoundView<'_>, arriving: &BTreeSet<Subject>, round: &mut Round<'_>) {
        for (index, source) in self.sources.iter().enumerate() {
            let is_adapter = |process: &&ObservedProcess| {
                process.kind == Some(ProcessKind::Adapter) && process.name == source.facts.adapter
            };
            let adapter = sight.processes.iter().find(is_adapter);
            let runs = |process: &ObservedProcess| process.state == ProcessState::Life(LifeState::Running);
            let is_expected = source.facts.is_external || adapter.is_some_and(runs);
            let delivered = sight.observed.delivered(source.facts.number);
            let is_arriving = arriving.contains(&Subject::source(source.facts.number));
            let is_unknown = sight.observed.is_counted_with_tracker(&source.facts);
            let may_be_silent = !is_expected || is_arriving || is_unknown || source.facts.silent_after_ns.is_none();
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
    fn machine_clock(&self, sight: RoundView<'_>, round: &mut Round<'_>) -> f64 {
        let known = |source: &&SourceWatch| {
            sight
                .observed
                .book()
                .registration(source.facts.number)
                .clock_offset_sigma_s
                > 0.0
        };
        let offset_s = |source: &SourceWatch| sight.observed.book().registration(source.facts.number).clock_offset_s;
        let sources = || self.sources.iter().filter(known);
        let agreeing = |of_s: f64| sources().filter(move |source| (offset_s(source) - of_s).abs() <= CLOCKS_AGREE_S);
        let limit_s = self.limits.clock_off_s.s();
        let found_s = sight.observed.book().host_offset_ns() as f64 / messages::NS_PER_S;
        // Below the limit on time steps, fusion leaves all times unchanged; most sources show the offset all the
        // same.
        let is_off = |source: &&SourceWatch| source.clock_excess_s(offset_s(source)) - CLOCKS_AGREE_S > limit_s;
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
    pub(super) fn source_errors(&mut self, sight: RoundView<'_>, round: &mut Round<'_>) {
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
                let value = source.facts.north_offset_against(&error);
                let value = value.map_or_else(String::new, |degrees| {
                    format!("; set `north_offset_deg = {degrees:.2}`")
                });
                let (subject, verdict) = match (error.is_certain, error.is_removed) {
                    (true, true) => (subject, format!(", and that is taken off{value}")),
                    (true, false) => (subject, value),
                    _ => {
                        let pair = Subject::pair(source.facts.number, error.partner);
                        (pair, format!("{value}; or {partner} is off the other way"))
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
            if let Some(error) = known.contradiction() {
                let partner = self.sources.get(usize::from(error.partner));
                let partner = partner.map_or_else(String::new, |partner| partner.facts.name.clone());
                let removed = if error.is_removed { "; fusion removes it" } else { "" };
                let (kind, subject) = match error.is_certain {
                    true => (AlarmKind::SourceOff, subject),
                    false => {
                        let pair = Subject::pair(source.facts.number, error.partner);
                        (AlarmKind::SourcesContradict, pair)
                    }
                };
                let values = [
                    name(),
                    ("error", error.to_string()),
                    ("partner", partner),
                    ("verdict", removed.to_owned()),
                ];
                round.find(kind, subject, Finding::Bad, &values);
            }
            if let Some(finding) = above(known.covariance_inflation, self.limits.inflation) {
                let values = [name(), ("factor", format!("{:.1}", known.covariance_inflation))];
                round.find(AlarmKind::AccuracyOverstated, subject, finding, &values);
            }
        }
    }

    /// Conditions of changes: of biases, and of the sources' probabilities of detection.
    pub(super) fn changed(&mut self, sight: RoundView<'_>, round: &mut Round<'_>) {
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

    /// Pairs of sources that observe the same targets without association.
    pub(super) fn never_joined(&mut self, sight: RoundView<'_>, round: &mut Round<'_>) {
        let now = sight.now;
        if now.mono_ns >= self.apart_due_ns {
            self.apart_due_ns = now.mono_ns + COMPANIONS_NS;
            self.apart = self.companions.apart(now.mono_ns);
        }
        let name = |number: u16| {
            self.sources
                .get(usize::from(number))
                .map(|source| source.facts.name.clone())
        };
        // A bias of azimuth, range or time explains the pairs better than a wrong position does.
        let is_explained = |source: u16, partner: u16| {
            let of = |source: u16| sight.observed.book().registration(source).gross_error();
            let is_between = |error: Bias, partner: u16| error.kind != BiasKind::Position && error.partner == partner;
            of(source).is_some_and(|error| is_between(error, partner))
                || of(partner).is_some_and(|error| is_between(error, source))
        };
        for apart in &self.apart {
            if is_explained(apart.source, apart.partner) {
                continue;
            }
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
}
