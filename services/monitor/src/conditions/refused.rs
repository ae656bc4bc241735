//! Sources from which data arrive and none, or too few, are accepted.
//!
//! A silent source and a source with refused data look alike in the picture, and differ in the remedy. The counters of
//! refusals decide, and the latest refusal in words ([`Health::refusal`](messages::Health::refusal)) is the reason.
//! Fusion refuses reports that no adapter has checked, such as the reports of `koseki feed`.

use std::collections::BTreeSet;

use alarms::{AlarmKind, Finding, Lately, Round, Subject};
use messages::{Counter, CounterClass, Counters, NO_SOURCE, ProcessKind};
use observed::process_title as title;

use super::{Conditions, RoundView};
use crate::text::several;

/// Time over which refusals are counted, nanoseconds.
const WHILE_NS: i64 = 10_000_000_000;
/// Minimum number of refusals, with no accepted data, for an alarm: a single refusal may be the end of another sender's
/// test.
const REFUSED_MIN: u64 = 3;
/// Minimum number of unreadable data for an alarm, and minimum share, per cent: noise on a line is less.
const UNREADABLE_MIN: u64 = 5;
const UNREADABLE_PERCENT: u64 = 10;

/// Counters of data that cannot be read.
const UNREADABLE: [Counter; 8] = [
    Counter::BlocksRejected,
    Counter::SentencesPartial,
    Counter::SentencesChecksum,
    Counter::SentencesTalker,
    Counter::SnapshotsForeign,
    Counter::SnapshotsLength,
    Counter::SnapshotsValue,
    Counter::DatagramsRejectedLength,
];
/// Counters of data that can be read and not be used.
const UNUSABLE: [Counter; 13] = [
    Counter::RejectedNoPosition,
    Counter::RejectedNoTrackNumber,
    Counter::RejectedPosition,
    Counter::RejectedSpeed,
    Counter::RejectedTime,
    Counter::RejectedLate,
    Counter::RejectedQuality,
    Counter::RejectedTargets,
    Counter::DetectionsRejected,
    Counter::RejectedPlatform,
    Counter::SnapshotsAntennas,
    Counter::SentencesWithoutFix,
    Counter::DatagramsRejected,
];
/// Counters of reports that fusion refuses for their content, and that no other alarm covers.
const USELESS: [Counter; 3] = [
    Counter::RejectedTooFar,
    Counter::RejectedTooFast,
    Counter::RejectedInvalid,
];
const REFUSED: usize = UNREADABLE.len() + UNUSABLE.len();
/// Counters of accepted data.
const ACCEPTED: [Counter; 5] = [
    Counter::Reports,
    Counter::Detections,
    Counter::Published,
    Counter::WideAreaReports,
    Counter::ServiceMessages,
];

/// Memory of the condition: counts of accepted data, of data in another edition, and of refused data by reason.
pub(super) type Refusals = Lately<{ REFUSED + 2 }>;

/// Memory of the reports that fusion used, and of refused reports by reason.
pub(super) type Useless = Lately<{ USELESS.len() + 1 }>;

/// Begins a memory.
pub(super) fn memory<const N: usize>() -> Lately<N> {
    Lately::new(WHILE_NS)
}

/// Data refused of late.
struct Refused {
    accepted: u64,
    refused: u64,
    unreadable: u64,
    /// The most frequent reason.
    most: Counter,
    /// Another alarm names the edition that fits.
    is_of_other_edition: bool,
}

impl Refused {
    fn of(grown: [u64; REFUSED + 2]) -> Self {
        let [accepted, of_other_edition, by_reason @ ..] = grown;
        let reasons = || UNREADABLE.into_iter().chain(UNUSABLE).zip(by_reason);
        Self {
            accepted,
            refused: by_reason.iter().sum(),
            unreadable: by_reason[..UNREADABLE.len()].iter().sum(),
            most: reasons()
                .max_by_key(|(_, count)| *count)
                .map_or(UNREADABLE[0], |(counter, _)| counter),
            is_of_other_edition: of_other_edition > 0,
        }
    }

    /// Whether the data are of no use, or too large a share cannot be read.
    fn is_bad(&self) -> bool {
        let is_nothing_accepted = self.accepted == 0 && self.refused >= REFUSED_MIN;
        let all = self.unreadable + self.accepted;
        let is_much_unreadable = self.unreadable >= UNREADABLE_MIN && 100 * self.unreadable >= UNREADABLE_PERCENT * all;
        (is_nothing_accepted || is_much_unreadable) && !self.is_of_other_edition
    }
}

/// Values of the counters that the condition needs.
fn counts(counters: &Counters) -> [u64; REFUSED + 2] {
    let accepted = ACCEPTED.map(|counter| counters[counter]).iter().sum();
    let others = [accepted, counters[Counter::BlocksOfOtherEdition]].into_iter();
    let by_reason = UNREADABLE.into_iter().chain(UNUSABLE).map(|counter| counters[counter]);
    let mut values = others.chain(by_reason);
    std::array::from_fn(|_| values.next().unwrap_or_default())
}

impl Conditions {
    /// Finds the sources, and adapter processes, with refused data. Returns the subjects with recent arrivals: these
    /// are not silent.
    pub(super) fn refused(&mut self, sight: RoundView<'_>, round: &mut Round<'_>) -> BTreeSet<Subject> {
        let (mut arriving, mut found) = (self.refused_of_feed(sight), BTreeSet::new());
        let book = sight.observed.book();
        let adapters = book.all().filter(|(kind, ..)| *kind == ProcessKind::Adapter);
        for (kind, source, latest) in adapters {
            let name = latest.name();
            let known = self.sources.iter().find(|known| known.facts.number == source);
            let (subject, title, counters) = match known {
                Some(known) => (Subject::source(source), known.facts.name.clone(), latest.counters()),
                None if source == NO_SOURCE => {
                    // Counts of data without a source, beside everything that was accepted.
                    let mut own = book.apart_from_sources(kind, name, false).unwrap_or_default();
                    for counter in ACCEPTED {
                        own[counter] = latest.counters()[counter];
                    }
                    (Subject::process(name), title(kind, name), own)
                }
                None => continue,
            };
            let grown = self
                .refusals
                .grown(AlarmKind::SourceRefused, subject, counts(&counters), sight.now.mono_ns);
            let refused = Refused::of(grown);
            if refused.refused == 0 {
                continue;
            }
            arriving.insert(subject);
            // Data without a named source belong to the adapter's only source.
            let mut behind = self.sources.iter().filter(|known| known.facts.adapter == name);
            if let (NO_SOURCE, Some(only), None) = (source, behind.next(), behind.next()) {
                arriving.insert(Subject::source(only.facts.number));
            }
            if refused.is_bad() {
                found.insert(subject);
                let reason = match latest.refusal() {
                    "" => refused.most.sentence(),
                    words => words,
                };
                let values = [
                    ("source", title),
                    ("refused", telemetry::table::count(refused.refused)),
                    ("all", several(refused.refused + refused.accepted, "item")),
                    ("reason", reason.to_owned()),
                ];
                round.find(AlarmKind::SourceRefused, subject, Finding::Bad, &values);
            }
        }
        arriving.extend(self.refused_by_fusion(sight, &found, round));
        // A tracker with refused sensor data is not silent either.
        let of_sensor = |known: &super::sources::SourceWatch| {
            let is_arriving = arriving.contains(&Subject::source(known.facts.number));
            known.facts.sensor_of.filter(|_| is_arriving)
        };
        let trackers: Vec<u16> = self.sources.iter().filter_map(of_sensor).collect();
        arriving.extend(trackers.into_iter().map(Subject::source));
        arriving
    }

    /// Finds sources with no report used by fusion. `found` holds the subjects of the adapters' refusals.
    fn refused_by_fusion(
        &mut self,
        sight: RoundView<'_>,
        found: &BTreeSet<Subject>,
        round: &mut Round<'_>,
    ) -> Vec<Subject> {
        let mut arriving = Vec::new();
        for known in &self.sources {
            let subject = Subject::source(known.facts.number);
            let counters = sight.observed.book().service(ProcessKind::Fusion, known.facts.number);
            let unused = counters.sum_of(CounterClass::FusionRejection);
            let used = counters[Counter::Taken].saturating_sub(unused);
            let reasons = USELESS.map(|counter| counters[counter]);
            let counts = std::array::from_fn(|place| if place == 0 { used } else { reasons[place - 1] });
            let kind = AlarmKind::SourceRefused;
            let [used, reasons @ ..] = self.useless.grown(kind, subject, counts, sight.now.mono_ns);
            let refused: u64 = reasons.iter().sum();
            let most = USELESS.iter().zip(reasons).max_by_key(|(_, count)| *count);
            let Some((most, _)) = most.filter(|_| used == 0 && refused >= REFUSED_MIN) else {
                continue;
            };
            arriving.push(subject);
            if !found.contains(&subject) {
                let values = [
                    ("source", known.facts.name.clone()),
                    ("refused", telemetry::table::count(refused)),
                    ("all", several(refused, "report")),
                    ("reason", most.sentence().to_owned()),
                ];
                round.find(kind, subject, Finding::Bad, &values);
            }
        }
        arriving
    }

    /// Sources of which `koseki feed` has refused lines of late.
    fn refused_of_feed(&mut self, sight: RoundView<'_>) -> BTreeSet<Subject> {
        let now_ns = sight.now.mono_ns;
        let names = sight.feeding.refused.keys().cloned();
        self.refused_lines.extend(names.map(|name| (name, now_ns)));
        self.refused_lines
            .retain(|_, refused_ns| now_ns - *refused_ns < WHILE_NS);
        let fed = self
            .sources
            .iter()
            .filter(|known| self.refused_lines.contains_key(&known.facts.name));
        fed.map(|known| Subject::source(known.facts.number)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(counters: &[(Counter, u64)]) -> Refused {
        let mut all = Counters::default();
        counters.iter().for_each(|(counter, count)| all.add(*counter, *count));
        Refused::of(counts(&all))
    }

    #[test]
    fn nothing_accepted_or_much_unreadable_is_bad() {
        for (counters, is_bad) in [
            (&[][..], false),
            (&[(Counter::BlocksRejected, 2)], false),
            (&[(Counter::BlocksRejected, 3)], true),
            (&[(Counter::RejectedTime, 3)], true),
            (&[(Counter::RejectedTime, 300), (Counter::Reports, 1)], false),
            (&[(Counter::BlocksRejected, 4), (Counter::Reports, 1)], false),
            (&[(Counter::SentencesChecksum, 5), (Counter::Published, 45)], true),
            (&[(Counter::SentencesChecksum, 5), (Counter::Published, 46)], false),
            (
                &[(Counter::BlocksRejected, 9), (Counter::BlocksOfOtherEdition, 9)],
                false,
            ),
        ] {
            assert_eq!(refused(counters).is_bad(), is_bad, "{counters:?}");
        }
    }

    #[test]
    fn the_most_frequent_reason_is_found() {
        let found = refused(&[(Counter::BlocksRejected, 2), (Counter::RejectedSpeed, 7)]);
        assert_eq!(
            (found.most, found.refused, found.unreadable),
            (Counter::RejectedSpeed, 9, 2)
        );
    }
}
