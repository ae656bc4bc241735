//! Conditions of counters: counters that should not grow, and received data outside the configuration.

use alarms::{AlarmKind, Finding, Round, Subject};
use messages::{Counter, NO_SOURCE, ProcessKind};
use observed::process_title as title;

use super::{Conditions, RoundView};
use crate::text::several;

/// Counters that should not grow: alarm, counters, counted objects, and the process that counts.
type Growing = (AlarmKind, &'static [Counter], &'static str, &'static [ProcessKind]);
const GROWING: &[Growing] = {
    use ProcessKind::{Adapter, Fusion, Gateway, Link, Recorder, Simulator};
    &[
        (
            AlarmKind::SamplesLost,
            &[Counter::Lost, Counter::RecordedLost],
            "sample",
            &[Fusion, Gateway, Adapter, Link],
        ),
        (
            AlarmKind::RecordingIncomplete,
            &[Counter::Lost, Counter::RecordedLost],
            "sample",
            &[Recorder],
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

impl Conditions {
    /// Growth of the counters of [`GROWING`].
    pub(super) fn growing_counters(&mut self, sight: RoundView<'_>, round: &mut Round<'_>) {
        for (kind, source, latest) in sight.observed.book().all() {
            // A process's message as a whole repeats the counts of the process's sources.
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
                    // Notes of other processes are about inputs and peers.
                    let cause = match (kind, *alarm, latest.note()) {
                        (ProcessKind::Recorder, _, note) if !note.is_empty() => note,
                        (_, AlarmKind::RecordingFailed, _) => "standard error has the cause",
                        _ => "it fell behind",
                    };
                    let values = [
                        ("process", title(kind, latest.name())),
                        ("count", several(count, thing)),
                        ("of", of),
                        ("cause", cause.to_owned()),
                    ];
                    round.find(*alarm, subject, Finding::Bad, &values);
                }
            }
        }
    }

    /// Conditions of received data outside the configuration.
    pub(super) fn misfits(&mut self, sight: RoundView<'_>, round: &mut Round<'_>) {
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
            // Data received before a restart of the monitor continue if relevant.
            if senders > 0 && self.growth.has_grown(AlarmKind::SenderUnknown, subject, rejected, 0) {
                let [sac, sic, ..] = latest.misfit();
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
                let [category, major, minor, _] = latest.misfit();
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
}
