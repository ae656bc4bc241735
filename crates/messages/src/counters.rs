//! Counters: one declaration gives each counter a code, a label, a class, the counting processes, and a sentence.
//!
//! Overload, loss and bad input are counted instead of logged: counters can be read from outside at any time.
//! Reports, displays and metrics group counters by the classes defined here. Two words have a fixed meaning: input
//! is *rejected* because of its content, and *dropped* because a table or queue is full.

use std::ops::{AddAssign, Index, IndexMut};

use crate::ProcessKind;
use crate::layout::sample;

/// Length of [`Counters::values`].
pub const COUNTERS_MAX: usize = 128;

sample! {
    /// Values of all counters of a process, or of a source within a process.
    Counters, size 1024 {
        /// Counts since the process started, indexed by the codes of `Counter`; a few are levels.
        values: [u64; 128] = [0; COUNTERS_MAX],
    }
}

impl Counters {
    /// Returns these counters with a single counter set to `count`.
    #[must_use]
    pub fn with(mut self, counter: Counter, count: u64) -> Self {
        self[counter] = count;
        self
    }

    /// Adds `count` to one counter.
    pub fn add(&mut self, counter: Counter, count: u64) {
        self[counter] += count;
    }

    /// Returns the sum of the counters of a class.
    pub fn sum_of(&self, class: CounterClass) -> u64 {
        Counter::of(class).map(|counter| self[counter]).sum()
    }

    /// Returns these counters without the counters of whole processes.
    #[must_use]
    pub fn without_those_of_processes(mut self) -> Self {
        for counter in Counter::ALL.iter().filter(|counter| counter.is_of_process()) {
            self[*counter] = 0;
        }
        self
    }

    /// Returns the total counts of a process and its successor `later`: sums, except that levels are those of
    /// `later`.
    #[must_use]
    pub fn followed_by(&self, later: &Self) -> Self {
        let mut sum = Self {
            values: std::array::from_fn(|index| self.values[index].saturating_add(later.values[index])),
        };
        for level in Counter::of(CounterClass::Level) {
            sum[level] = later[level];
        }
        sum
    }
}

impl Index<Counter> for Counters {
    type Output = u64;

    fn index(&self, counter: Counter) -> &u64 {
        &self.values[counter as usize]
    }
}

impl IndexMut<Counter> for Counters {
    fn index_mut(&mut self, counter: Counter) -> &mut u64 {
        &mut self.values[counter as usize]
    }
}

impl AddAssign<&Counters> for Counters {
    fn add_assign(&mut self, other: &Self) {
        for (count, more) in self.values.iter_mut().zip(&other.values) {
            *count += more;
        }
    }
}

/// Class of counters shown together in reports and displays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CounterClass {
    /// Samples and records passing through a process.
    Flow,
    /// Levels: present numbers, not totals.
    Level,
    /// Reports rejected by an adapter, by reason.
    Rejection,
    /// Records that an adapter converts to reports partly or not at all.
    AdapterRemark,
    /// Work of an adapter that forms tracks from detections.
    Tracking,
    /// Reports received but not used by fusion, by reason.
    FusionRejection,
    /// Properties of reports that fusion used.
    FusionRemark,
    /// Events of the fused picture.
    Picture,
    /// Work of a process, independent of sources.
    Process,
    /// Traffic through a process's sockets.
    Network,
    /// Network traffic that needs the operator's attention.
    NetworkTrouble,
    /// Deadlines missed.
    Latency,
}

macro_rules! counters {
    ($( $name:ident = $label:literal, $class:ident by [$($kind:ident),*], $sentence:literal; )*) => {
        /// Code of a count since the start of the process.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u16)]
        pub enum Counter {
            $( #[doc = $sentence] $name, )*
        }

        impl Counter {
            /// All counters, in the order of codes.
            pub const ALL: &'static [Self] = &[ $( Self::$name, )* ];

            /// Returns the short name used in tables, JSON and metrics.
            pub fn label(self) -> &'static str {
                match self { $( Self::$name => $label, )* }
            }

            /// Returns the class of the counter.
            pub const fn class(self) -> CounterClass {
                match self { $( Self::$name => CounterClass::$class, )* }
            }

            /// Returns the kinds of process with this counter; none for levels.
            pub fn counted_by(self) -> &'static [ProcessKind] {
                match self { $( Self::$name => &[ $( ProcessKind::$kind, )* ], )* }
            }

            /// Returns a description of the counted event, a single sentence.
            pub fn sentence(self) -> &'static str {
                match self { $( Self::$name => $sentence, )* }
            }
        }

        const _: () = assert!(Counter::ALL.len() <= COUNTERS_MAX);
    };
}

impl Counter {
    /// Returns the counters of a class, in the order of codes.
    pub fn of(class: CounterClass) -> impl Iterator<Item = Self> + Clone {
        Self::ALL
            .iter()
            .copied()
            .filter(move |counter| counter.class() == class)
    }

    /// Whether the counter exists only for a whole process, never for a source.
    pub const fn is_of_process(self) -> bool {
        matches!(
            self.class(),
            CounterClass::Picture | CounterClass::Process | CounterClass::Network | CounterClass::NetworkTrouble
        )
    }
}

counters! {
    Records = "records", Flow by [Adapter],
        "Records decoded from the source, of any kind.";
    ServiceMessages = "service_messages", AdapterRemark by [Adapter],
        "Records that speak of the sensor, not of a target.";
    BytesRejected = "bytes_rejected", AdapterRemark by [Adapter],
        "Bytes of blocks that could not be explained and were skipped.";
    BlocksRejected = "blocks_rejected", AdapterRemark by [Adapter],
        "Blocks that could not be explained, wholly or in part.";
    Published = "published", Flow by [Adapter, Fusion, Link],
        "Samples published.";
    Reports = "reports", Flow by [Adapter],
        "Reports of targets that passed every check.";
    RejectedFieldMonitor = "rejected_field_monitor", Rejection by [Adapter],
        "Reports of a fixed field monitor, which is no aircraft.";
    RejectedTestTarget = "rejected_test_target", Rejection by [Adapter],
        "Reports marked as simulated or test targets.";
    RejectedNoPosition = "rejected_no_position", Rejection by [Adapter],
        "Reports without a usable position (a track's last message, for example).";
    RejectedNoTrackNumber = "rejected_no_track_number", Rejection by [Adapter, Gateway],
        "Reports with neither track number nor address.";
    RejectedPosition = "rejected_position", Rejection by [Adapter, Gateway],
        "Reports with a position that cannot be: outside the sensor's range, the globe, or what a category can express.";
    RejectedHeight = "rejected_height", AdapterRemark by [Adapter],
        "Heights that cannot be; the report is used without its height.";
    RejectedSpeed = "rejected_speed", Rejection by [Adapter],
        "Reports with a speed that no target has.";
    RejectedJump = "rejected_jump", Rejection by [Adapter],
        "Reports that would need an impossible speed since the track's previous ones.";
    RejectedTime = "rejected_time", Rejection by [Adapter],
        "Reports with a time of day far from that of their neighbours.";
    RejectedLate = "rejected_late", Rejection by [Adapter],
        "Reports older than the source's own progress mark.";
    RejectedQuality = "rejected_quality", Rejection by [Adapter],
        "Reports whose own quality figure says that the position cannot be used.";
    RejectedSource = "rejected_source", Rejection by [Adapter],
        "Reports of another SAC/SIC, or observed by another method, than configured.";
    TracksEnded = "tracks_ended", AdapterRemark by [Adapter],
        "Sensor tracks that their source declared ended.";
    TracksDropped = "tracks_dropped", Rejection by [Adapter, Gateway],
        "Reports of tracks dropped because the process's table was full.";
    WaitedForConsumers = "waited_for_consumers", Flow by [Adapter],
        "Times a recorded source waited for its consumers so that nothing is lost.";
    Taken = "taken", Flow by [Fusion, Monitor, Recorder, Gateway, Simulator, Display, Link],
        "Samples taken from the source's topic.";
    Lost = "lost", Flow by [Fusion, Monitor, Recorder, Gateway, Simulator, Display, Link],
        "Samples missing from the source's sequence: dropped because the reader fell behind, or lost between hosts.";
    RejectedOutOfOrder = "rejected_out_of_order", FusionRejection by [Fusion, Monitor],
        "Samples not newer than one already worked off: repeated, or out of order.";
    RejectedInvalid = "rejected_invalid", FusionRejection by [Fusion, Monitor],
        "Samples rejected because a value is not finite or beyond its limit, or a code unknown.";
    RejectedSchema = "rejected_schema", FusionRejection by [Fusion, Monitor, Recorder, Gateway, Simulator, Display, Link],
        "Batches rejected because their publisher was built with another layout.";
    DroppedQueue = "dropped_queue", FusionRejection by [Fusion],
        "Reports dropped because the source's queue in fusion was full, oldest first.";
    DroppedTable = "dropped_table", FusionRejection by [Fusion],
        "Reports dropped because a table was full, or full for their source: others may have their share.";
    TracksStarted = "tracks_started", Picture by [Fusion],
        "System tracks started.";
    TracksConfirmed = "tracks_confirmed", Picture by [Fusion],
        "System tracks confirmed.";
    TracksTerminated = "tracks_terminated", Picture by [Fusion],
        "System tracks ended.";
    TracksMerged = "tracks_merged", Picture by [Fusion],
        "System tracks found to be the same target as another, and merged into it.";
    ContributionsSplit = "contributions_split", Picture by [Fusion],
        "Sensor tracks taken out of a system track they no longer fitted.";
    RejectedDuplicate = "rejected_duplicate", FusionRejection by [Fusion],
        "Reports of a second track of one source on one target: recognised, not used.";
    RejectedExtrapolated = "rejected_extrapolated", FusionRejection by [Fusion],
        "Reports that are their source's own extrapolation: no observation, so not used.";
    IdentityConflicts = "identity_conflicts", FusionRemark by [Fusion],
        "Reports whose identity contradicted that of the system track they had belonged to.";
    HandOvers = "hand_overs", Picture by [Fusion],
        "Changes of the selected source.";
    LiveTracks = "live_tracks", Level by [],
        "Level: system tracks that are confirmed or coasted now.";
    TentativeTracks = "tentative_tracks", Level by [],
        "Level: system tracks that are tentative now.";
    CoastedTracks = "coasted_tracks", Level by [],
        "Level: system tracks that are coasted now.";
    DeadlineMisses = "deadline_misses", Latency by [Fusion, Monitor],
        "Reports that took longer through fusion than the configured deadline.";
    OrdersObeyed = "orders_obeyed", Process by [Fusion],
        "Orders that fusion has obeyed.";
    OrdersRejected = "orders_rejected", Process by [Fusion],
        "Orders that fusion has rejected: unknown kinds, conditions that no source names.";
    RowsWritten = "rows_written", Process by [Recorder],
        "Rows written to files.";
    Datagrams = "datagrams", Network by [Adapter],
        "Datagrams received, or pieces read from a connection.";
    DatagramsRejected = "datagrams_rejected", NetworkTrouble by [Adapter],
        "Datagrams from senders that are not on the receiver's list.";
    DatagramsRejectedLength = "datagrams_rejected_length", NetworkTrouble by [Adapter],
        "Datagrams that were empty or longer than the receiver's buffer.";
    DatagramsDropped = "datagrams_dropped", NetworkTrouble by [Adapter],
        "Datagrams that the kernel dropped because the receiver's buffer was full.";
    Connections = "connections", Network by [Adapter],
        "Connections to a feed that were made.";
    RecordsSent = "records_sent", Network by [Gateway, Simulator, Link],
        "Records sent to other systems.";
    DatagramsSent = "datagrams_sent", Network by [Gateway, Simulator],
        "Datagrams sent to other systems.";
    SendFailures = "send_failures", NetworkTrouble by [Gateway, Simulator, Link],
        "Datagrams or messages that could not be sent.";
    HeightAssumed = "height_assumed", AdapterRemark by [Adapter],
        "Reports without height whose slant range was turned into a place by an assumed one.";
    TracesRejected = "traces_rejected", FusionRemark by [Fusion],
        "Times a covariance trace was asked for and missing or no trace; the configured weights held.";
    CovariancesRepaired = "covariances_repaired", FusionRemark by [Fusion],
        "Times a covariance was not positive definite, and was repaired or left out.";
    StagesLate = "stages_late", Latency by [Monitor],
        "Stages of reports that took longer than their configured deadline, as the monitor has seen it.";
    Detections = "detections", Tracking by [Adapter],
        "Detections published, of which the source's adapter makes tracks.";
    DetectionsRejected = "detections_rejected", Rejection by [Adapter],
        "Detections that the adapter's tracker rejected, or dropped because it was full.";
    Scans = "scans", Tracking by [Adapter],
        "Scans that the adapter's tracker worked off, silent ones included.";
    RejectedTargets = "rejected_targets", Rejection by [Adapter],
        "Wide-area reports with more targets than any cluster can have.";
    WideAreaReports = "wide_area_reports", Tracking by [Adapter],
        "Wide-area reports that the adapter's tracker took.";
    WideAreaRejected = "wide_area_rejected", Tracking by [Adapter],
        "Wide-area reports that the adapter's tracker rejected, or dropped because it was full.";
    WideAreaLost = "wide_area_lost", Tracking by [Adapter, Recorder],
        "Wide-area reports that were published and did not reach their reader, a tracker or the recorder.";
    WideAreaLate = "wide_area_late", Tracking by [Adapter],
        "Wide-area reports that came when the scan they were for had been worked off: used in the next one.";
    WideAreaUsed = "wide_area_used", Tracking by [Adapter],
        "Wide-area reports that the adapter's tracker used.";
    WideAreaUnmatched = "wide_area_unmatched", Tracking by [Adapter],
        "Wide-area reports, of those used, that were near no track.";
    Emissions = "emissions", Tracking by [Adapter],
        "Emissions of direction finders that the adapter's tracker took, to identify its tracks.";
    EmissionsRejected = "emissions_rejected", Tracking by [Adapter],
        "Emissions rejected: without a frequency, with a value that cannot be, too late, without room, or lost on the way.";
    EmissionsUnclear = "emissions_unclear", Tracking by [Adapter],
        "Emissions in whose direction there was no track, or more than one.";
    Cues = "cues", Tracking by [Adapter],
        "Cues published: where the sensor should look next.";
    DetectionsWithoutFix = "detections_without_fix", Tracking by [Adapter],
        "Bearings of transmitters whose place the geometry does not yet allow to be told.";
    UnknownSender = "unknown_sender", Level by [],
        "Level: SAC × 256 + SIC of the sender that was heard most, of those that no source is configured for.";
    UnknownSenderBlocks = "unknown_sender_blocks", Level by [],
        "Level: blocks that were heard of that sender.";
    UnknownSenders = "unknown_senders", Level by [],
        "Level: senders that no source is configured for.";
    BlocksOfOtherEdition = "blocks_of_other_edition", AdapterRemark by [Adapter],
        "Blocks that cannot be read as configured and fit another edition of their category.";
    OtherEdition = "other_edition", Level by [],
        "Level: category × 65536 + edition (before the point) × 256 + edition (after it) that most of those blocks fit.";
    DetectionPermille = "detection_permille", Level by [],
        "Level: scans in which the source sees a target that it tracks, of a thousand.";
    RejectedClock = "rejected_clock", FusionRejection by [Fusion],
        "Reports kept out of the tracks because their source's clock is wild: far from the time of receipt, or jumping.";
    RejectedContradicted = "rejected_contradicted", FusionRejection by [Fusion],
        "Reports kept out of a track because other sources that agree with each other contradict them.";
    EstimatesRestarted = "estimates_restarted", FusionRemark by [Fusion],
        "Estimates that were not finite or beyond reason (a track's state, a source's errors): not used, and begun anew.";
    Rebuilds = "rebuilds", Process by [Launcher],
        "Times that the deployment was torn down and rebuilt because its shared memory was corrupt.";
    MissingRows = "missing_rows", Level by [],
        "Level: samples of a recorded source that are in none of the recorder's rows.";
    RecordedSamples = "recorded_samples", Process by [Recorder, Adapter],
        "Samples taken for the recording of all topics; of adapters, datagrams and lines written to captures.";
    RecordedLost = "recorded_lost", Process by [Recorder, Adapter],
        "Samples that the recording of all topics lacks, or datagrams and lines that captures lack: dropped, or not written.";
    RecordingFailures = "recording_failures", Process by [Recorder, Adapter],
        "Times that the recording of all topics, or a capture, could not be written; it is tried again every second.";
    RecordingsDeleted = "recordings_deleted", Process by [Recorder, Adapter],
        "Files of the recording of all topics, or captures, that were deleted to make room for later ones.";
    DecisionsDropped = "decisions_dropped", Process by [Fusion],
        "Decisions of fusion that were not published because they came faster than its second thread took them.";
    TakeOvers = "take_overs", Process by [Fusion],
        "Times that the fusion that stood by took over.";
    TakeOversFromStill = "take_overs_from_still", Process by [Fusion],
        "Times that it did so because the one before it stood still.";
    PicturesSent = "pictures_sent", Process by [Display],
        "Pictures sent to pages that look on.";
    PicturesSkipped = "pictures_skipped", Process by [Display],
        "Pictures that were not made because the page that they were for was still behind.";
    RequestsRejected = "requests_rejected", Process by [Display, Link],
        "Requests and connections of browsers, scripts and other hosts that were turned away.";
    Conflated = "conflated", Process by [Link],
        "States that were not sent to other hosts because a newer one of the same track took their place.";
    MessagesRejected = "messages_rejected", Process by [Link],
        "Messages of other hosts that were rejected: malformed, repeated, or too many at a time.";
    LostOnTheWay = "lost_on_the_way", Process by [Link],
        "Samples of other hosts that were sent and did not arrive; subscribers here count them as lost.";
    Unsent = "unsent", Process by [Link],
        "Samples that were not sent to other hosts because the network is slower than they come.";
    MissingPeers = "missing_peers", Level by [],
        "Level: deployments of other hosts that a link is to receive from, and does not hear.";
    HostClockOffUs = "host_clock_off_us", Level by [],
        "Level: microseconds by which the clock (UTC) of another host is off for certain: beyond what the comparison leaves open.";
    RejectedEpoch = "rejected_epoch", FusionRejection by [Monitor, Gateway, Display],
        "Samples rejected because they came from a fusion that has been replaced since.";
    Stopping = "stopping", Level by [],
        "Level: 1 once the launcher stops the deployment.";
    ScanPeriodMs = "scan_period_ms", Level by [],
        "Level: milliseconds that a turn takes, by which an adapter cuts detections into scans; 0 until it is known.";
    Quarantined = "quarantined", FusionRejection by [Fusion],
        "Reports passed over because fusion had died twice while it worked them off.";
    RejectedByOrder = "rejected_by_order", FusionRejection by [Fusion],
        "Reports of sources that an order keeps out.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_add_up_and_levels_do_not() {
        let counted = |taken, live| {
            Counters::default()
                .with(Counter::Taken, taken)
                .with(Counter::LiveTracks, live)
        };
        let both = counted(5, 7).followed_by(&counted(2, 3));
        assert_eq!(both, counted(7, 3));
        let mut sum = counted(5, 7);
        sum += &counted(2, 3);
        assert_eq!((sum.sum_of(CounterClass::Flow), sum[Counter::LiveTracks]), (7, 10));
    }

    #[test]
    fn levels_say_that_they_are_and_everything_else_is_counted_by_somebody() {
        for counter in Counter::ALL {
            let is_level = counter.class() == CounterClass::Level;
            assert_eq!(counter.sentence().starts_with("Level:"), is_level, "{counter:?}");
            assert_eq!(counter.counted_by().is_empty(), is_level, "{counter:?}");
        }
    }

    #[test]
    fn the_class_fits_the_word_for_bad_input() {
        for counter in Counter::ALL {
            let label = counter.label();
            assert!(!label.contains("refused") && !label.contains("ignored"), "{label}");
            let shown = [
                CounterClass::Rejection,
                CounterClass::AdapterRemark,
                CounterClass::FusionRejection,
            ]
            .contains(&counter.class());
            assert!(shown || !label.starts_with("rejected_"), "{label}");
        }
    }
}
