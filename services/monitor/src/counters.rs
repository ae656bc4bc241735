//! The counters of one process or source, and what they add up to.

use messages::{COUNTERS_MAX, Counter, ProcessKind};
use serde::{Serialize, Serializer};

/// Counters that show how many there are now, not how many there have been.
pub(crate) const LEVELS: [Counter; 3] = [Counter::LiveTracks, Counter::TentativeTracks, Counter::CoastedTracks];

/// Why an adapter did not pass a report on.
pub(crate) const REJECTIONS: [Counter; 14] = [
    Counter::RejectedFieldMonitor,
    Counter::RejectedTestTarget,
    Counter::RejectedNoPosition,
    Counter::RejectedNoTrackNumber,
    Counter::RejectedPosition,
    Counter::RejectedSpeed,
    Counter::RejectedJump,
    Counter::RejectedTime,
    Counter::RejectedLate,
    Counter::RejectedQuality,
    Counter::RejectedSource,
    Counter::RejectedTargets,
    Counter::RefusedTracks,
    Counter::DetectionsRefused,
];

/// What else an adapter says of records that it did not, or not wholly, turn into reports.
pub(crate) const ADAPTER_REMARKS: [Counter; 6] = [
    Counter::TracksEnded,
    Counter::ServiceMessages,
    Counter::BlocksRefused,
    Counter::BytesRefused,
    Counter::RejectedHeight,
    Counter::HeightAssumed,
];

/// What an adapter says that makes tracks of detections.
pub(crate) const TRACKING: [Counter; 13] = [
    Counter::Detections,
    Counter::Scans,
    Counter::DetectionsWithoutFix,
    Counter::WideAreaReports,
    Counter::WideAreaUsed,
    Counter::WideAreaUnmatched,
    Counter::WideAreaLate,
    Counter::WideAreaRefused,
    Counter::WideAreaLost,
    Counter::Emissions,
    Counter::EmissionsRefused,
    Counter::EmissionsUnclear,
    Counter::Cues,
];

/// Reports that fusion took, but did not use.
pub(crate) const FUSION_REFUSALS: [Counter; 7] = [
    Counter::Duplicates,
    Counter::Extrapolated,
    Counter::OutOfOrder,
    Counter::Invalid,
    Counter::SchemaMismatch,
    Counter::QueueFull,
    Counter::TableFull,
];

/// What else fusion says of the reports of a source: it used them.
pub(crate) const FUSION_REMARKS: [Counter; 3] = [
    Counter::IdentityConflicts,
    Counter::TracesUnusable,
    Counter::CovariancesRepaired,
];

/// What is worth knowing of a process as a whole, and said nowhere else.
pub(crate) const PROCESS_REMARKS: [Counter; 5] = [
    Counter::OrdersObeyed,
    Counter::OrdersRefused,
    Counter::WaitedForConsumers,
    Counter::RowsWritten,
    Counter::WideAreaLost,
];

/// What a process of this kind counts, levels apart: of these, metrics show a 0 too, because what is not there has no
/// rate when it begins.
pub(crate) fn counted_by(kind: ProcessKind) -> &'static [Counter] {
    use Counter::*;
    match kind {
        ProcessKind::Adapter => &[
            Records,
            ServiceMessages,
            BytesRefused,
            BlocksRefused,
            Published,
            Reports,
            RejectedFieldMonitor,
            RejectedTestTarget,
            RejectedNoPosition,
            RejectedNoTrackNumber,
            RejectedPosition,
            RejectedHeight,
            RejectedSpeed,
            RejectedJump,
            RejectedTime,
            RejectedLate,
            RejectedQuality,
            RejectedSource,
            TracksEnded,
            RefusedTracks,
            WaitedForConsumers,
            HeightAssumed,
            Datagrams,
            DatagramsRefused,
            DatagramsUnusable,
            KernelDrops,
            Connections,
            Detections,
            DetectionsRefused,
            DetectionsWithoutFix,
            Scans,
            RejectedTargets,
            WideAreaReports,
            WideAreaRefused,
            WideAreaLost,
            WideAreaLate,
            WideAreaUsed,
            WideAreaUnmatched,
            Emissions,
            EmissionsRefused,
            EmissionsUnclear,
            Cues,
        ],
        ProcessKind::Fusion => &[
            Taken,
            Lost,
            OutOfOrder,
            Invalid,
            SchemaMismatch,
            QueueFull,
            TableFull,
            Published,
            TracksStarted,
            TracksConfirmed,
            TracksTerminated,
            TracksMerged,
            ContributionsSplit,
            Duplicates,
            Extrapolated,
            IdentityConflicts,
            HandOvers,
            DeadlineMisses,
            OrdersObeyed,
            OrdersRefused,
            TracesUnusable,
            CovariancesRepaired,
        ],
        ProcessKind::Monitor => &[
            Taken,
            Lost,
            OutOfOrder,
            Invalid,
            SchemaMismatch,
            DeadlineMisses,
            StagesLate,
        ],
        ProcessKind::Recorder => &[Taken, Lost, SchemaMismatch, RowsWritten, WideAreaLost],
        ProcessKind::Gateway | ProcessKind::Simulator => {
            &[Taken, Lost, SchemaMismatch, RecordsSent, DatagramsSent, SendFailures]
        }
        ProcessKind::Launcher => &[],
    }
}

/// What is counted of processes only, not of their sources.
pub(crate) const OF_PROCESSES: [Counter; 17] = [
    Counter::TracksStarted,
    Counter::TracksConfirmed,
    Counter::TracksTerminated,
    Counter::TracksMerged,
    Counter::ContributionsSplit,
    Counter::HandOvers,
    Counter::OrdersObeyed,
    Counter::OrdersRefused,
    Counter::RowsWritten,
    Counter::Datagrams,
    Counter::DatagramsRefused,
    Counter::DatagramsUnusable,
    Counter::KernelDrops,
    Counter::Connections,
    Counter::RecordsSent,
    Counter::DatagramsSent,
    Counter::SendFailures,
];

/// What crosses a process's socket; if none of it does, it has none.
pub(crate) const TRAFFIC: [Counter; 5] = [
    Counter::Datagrams,
    Counter::DatagramsRefused,
    Counter::Connections,
    Counter::DatagramsSent,
    Counter::SendFailures,
];

/// What an operator of a network should look into.
pub(crate) const NETWORK_TROUBLE: [Counter; 7] = [
    Counter::DatagramsRefused,
    Counter::DatagramsUnusable,
    Counter::KernelDrops,
    Counter::RejectedSource,
    Counter::BlocksRefused,
    Counter::BytesRefused,
    Counter::SendFailures,
];

/// Values of all counters. In JSON: an object with one member per counter, by label, in the order of their codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counters([u64; COUNTERS_MAX]);

impl Default for Counters {
    fn default() -> Self {
        Self([0; COUNTERS_MAX])
    }
}

impl Counters {
    /// The value of one counter.
    pub fn get(&self, counter: Counter) -> u64 {
        self.0[counter as usize]
    }

    /// Sets one counter.
    pub(crate) fn set(&mut self, counter: Counter, value: u64) {
        self.0[counter as usize] = value;
    }

    /// All values, indexed by [`Counter`].
    pub fn values(&self) -> &[u64; COUNTERS_MAX] {
        &self.0
    }

    /// The sum of several counters.
    pub fn sum(&self, counters: &[Counter]) -> u64 {
        counters.iter().map(|counter| self.get(*counter)).sum()
    }

    /// What `later` has counted, on top of this. Levels are those of `later`.
    #[must_use]
    pub(crate) fn followed_by(&self, later: &Self) -> Self {
        let mut sum = Self(std::array::from_fn(|index| {
            self.0[index].saturating_add(later.0[index])
        }));
        for level in LEVELS {
            sum.0[level as usize] = later.get(level);
        }
        sum
    }

    #[cfg(test)]
    pub(crate) fn with(mut self, counter: Counter, value: u64) -> Self {
        self.set(counter, value);
        self
    }
}

impl From<[u64; COUNTERS_MAX]> for Counters {
    fn from(values: [u64; COUNTERS_MAX]) -> Self {
        Self(values)
    }
}

impl Serialize for Counters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(Counter::ALL.iter().map(|counter| (counter.label(), self.get(*counter))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_add_up_and_levels_do_not() {
        let first = Counters::default().with(Counter::Taken, 5).with(Counter::LiveTracks, 7);
        let second = Counters::default().with(Counter::Taken, 2).with(Counter::LiveTracks, 3);
        let both = first.followed_by(&second);
        assert_eq!((both.get(Counter::Taken), both.get(Counter::LiveTracks)), (7, 3));
    }

    #[test]
    fn every_level_says_that_it_is_one_and_every_rejection_is_listed() {
        for counter in Counter::ALL {
            assert_eq!(
                counter.sentence().starts_with("Level:"),
                LEVELS.contains(counter),
                "{counter:?}"
            );
            let listed = REJECTIONS.contains(counter) || ADAPTER_REMARKS.contains(counter);
            assert!(listed || !counter.label().starts_with("rejected_"), "{counter:?}");
        }
    }

    #[test]
    fn every_counter_is_counted_by_somebody_and_shown_somewhere() {
        // What the report shows by name, in a table or a sentence of its own.
        let by_name = [
            Counter::Records,
            Counter::Reports,
            Counter::Published,
            Counter::Taken,
            Counter::Lost,
            Counter::TracksStarted,
            Counter::TracksConfirmed,
            Counter::TracksTerminated,
            Counter::TracksMerged,
            Counter::ContributionsSplit,
            Counter::HandOvers,
            Counter::DeadlineMisses,
            Counter::StagesLate,
            Counter::RecordsSent,
        ];
        let lists: [&[Counter]; 10] = [
            &by_name,
            &LEVELS,
            &REJECTIONS,
            &ADAPTER_REMARKS,
            &TRACKING,
            &FUSION_REFUSALS,
            &FUSION_REMARKS,
            &PROCESS_REMARKS,
            &TRAFFIC,
            &NETWORK_TROUBLE,
        ];
        for counter in Counter::ALL {
            assert!(
                lists.iter().any(|list| list.contains(counter)),
                "{counter:?} is not shown"
            );
            let counted = messages::PROCESS_KINDS
                .iter()
                .any(|kind| counted_by(*kind).contains(counter));
            assert!(counted != LEVELS.contains(counter), "{counter:?}");
        }
    }

    #[test]
    fn json_has_every_counter_by_label() {
        let value = serde_json::to_value(Counters::default().with(Counter::Taken, 5)).unwrap();
        assert_eq!(value.as_object().unwrap().len(), Counter::ALL.len());
        assert_eq!(value["taken"], 5);
        assert_eq!(value["rejected_jump"], 0);
    }
}
