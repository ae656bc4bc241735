//! Counters: one declaration gives each counter a code, a label, a class, the counting processes, and a sentence.
//!
//! Overload, loss and bad input are counted instead of logged: counters can be read from outside at any time.
//! Reports, displays and metrics group counters by the classes defined here. Two words have a fixed meaning: input
//! is *rejected* because of its content, and *dropped* because a table or queue is full.

use std::ops::{AddAssign, Index, IndexMut};

use crate::ProcessKind;
use crate::layout::sample;

/// Length of [`Counters::values`].
pub const COUNTERS_MAX: usize = 160;

sample! {
    /// Values of all counters of a process, or of a source within a process.
    Counters, size 1280 {
        /// Counts since the process started, indexed by the codes of `Counter`; a few are levels.
        values: [u64; 160] = [0; COUNTERS_MAX],
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
    /// Input rejected by an adapter, by reason: reports, or the blocks, sentences, snapshots and bearings before them.
    Rejection,
    /// Properties of an adapter's input that cost no report.
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
    // A code in parentheses follows the code of a counter that no longer exists, so that recorded codes keep their
    // meaning.
    ($( $name:ident $(($code:literal))? = $label:literal, $class:ident by [$($kind:ident),*], $sentence:literal; )*) => {
        /// Code of a count since the start of the process.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u16)]
        pub enum Counter {
            $( #[doc = $sentence] $name $(= $code)?, )*
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

        const _: () = assert!((Counter::ALL[Counter::ALL.len() - 1] as usize) < COUNTERS_MAX);
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
        "Records about the sensor itself, not about a target.";
    BytesRejected = "bytes_rejected", AdapterRemark by [Adapter],
        "Bytes of blocks that could not be decoded and were skipped.";
    BlocksRejected = "blocks_rejected", Rejection by [Adapter],
        "Blocks that could not be decoded completely.";
    Published = "published", Flow by [Adapter, Fusion, Link],
        "Samples published.";
    Reports = "reports", Flow by [Adapter],
        "Reports of targets that passed every check.";
    RejectedFieldMonitor = "rejected_field_monitor", Rejection by [Adapter],
        "Reports of a fixed field monitor, not of an aircraft.";
    RejectedTestTarget = "rejected_test_target", Rejection by [Adapter],
        "Reports marked as simulated or test targets.";
    RejectedNoPosition = "rejected_no_position", Rejection by [Adapter],
        "Reports without a usable position (a track's last message, for example).";
    RejectedNoTrackNumber = "rejected_no_track_number", Rejection by [Adapter, Gateway],
        "Reports with neither track number nor address.";
    RejectedPosition = "rejected_position", Rejection by [Adapter, Gateway],
        "Reports with an impossible position: outside the sensor's range, the globe, or the range of the category's items.";
    RejectedHeight = "rejected_height", AdapterRemark by [Adapter],
        "Impossible heights; the report is used without a height.";
    RejectedSpeed = "rejected_speed", Rejection by [Adapter],
        "Reports with an impossible speed.";
    RejectedJump = "rejected_jump", Rejection by [Adapter],
        "Reports at an impossible distance from the previous reports of the same track.";
    RejectedTime = "rejected_time", Rejection by [Adapter],
        "Reports with a time of day far from the times of neighbouring reports.";
    RejectedLate = "rejected_late", Rejection by [Adapter],
        "Reports older than the source's own watermark.";
    RejectedQuality = "rejected_quality", Rejection by [Adapter],
        "Reports marked as unusable by their own quality figure.";
    RejectedSource = "rejected_source", Rejection by [Adapter],
        "Reports of another SAC/SIC, or observed by another method, than configured.";
    TracksEnded = "tracks_ended", AdapterRemark by [Adapter],
        "Sensor tracks terminated by their source.";
    TracksDropped = "tracks_dropped", Rejection by [Adapter, Gateway],
        "Reports of tracks dropped because the process's table was full.";
    WaitedForConsumers = "waited_for_consumers", Flow by [Adapter],
        "Times that a recorded source waited for its consumers, so that no sample is lost.";
    Taken = "taken", Flow by [Fusion, Monitor, Recorder, Gateway, Simulator, Display, Link],
        "Samples taken from the source's topic.";
    Lost = "lost", Flow by [Fusion, Monitor, Recorder, Gateway, Simulator, Display, Link],
        "Samples missing from the source's sequence: dropped because the reader fell behind, or lost between hosts.";
    RejectedOutOfOrder = "rejected_out_of_order", FusionRejection by [Fusion, Monitor],
        "Samples not newer than a sample already processed: repeated, or out of order.";
    RejectedInvalid = "rejected_invalid", FusionRejection by [Fusion, Monitor],
        "Samples with a value that is not finite or beyond its limit, or with an unknown code.";
    RejectedSchema = "rejected_schema", FusionRejection by [Fusion, Monitor, Recorder, Gateway, Simulator, Display, Link],
        "Batches rejected because their publisher was built with another layout.";
    DroppedQueue = "dropped_queue", FusionRejection by [Fusion],
        "Reports dropped because the source's queue in fusion was full; the oldest are dropped first.";
    DroppedTable = "dropped_table", FusionRejection by [Fusion],
        "Reports dropped because a table, or the source's share of the table, was full.";
    TracksStarted = "tracks_started", Picture by [Fusion],
        "System tracks started.";
    TracksConfirmed = "tracks_confirmed", Picture by [Fusion],
        "System tracks confirmed.";
    TracksTerminated = "tracks_terminated", Picture by [Fusion],
        "System tracks terminated.";
    TracksMerged = "tracks_merged", Picture by [Fusion],
        "System tracks recognised as duplicates, and merged.";
    ContributionsSplit = "contributions_split", Picture by [Fusion],
        "Sensor tracks removed from a system track because they no longer fitted.";
    RejectedDuplicate = "rejected_duplicate", FusionRejection by [Fusion],
        "Reports of a second track of one target, by one source or by sources that repeat each other: not used.";
    RejectedExtrapolated = "rejected_extrapolated", FusionRejection by [Fusion],
        "Reports extrapolated by their source: no observation, therefore not used.";
    IdentityConflicts = "identity_conflicts", FusionRemark by [Fusion],
        "Reports with an identity in contradiction to their system track, or with a second number beside its own.";
    HandOvers = "hand_overs", Picture by [Fusion],
        "Changes of the selected source.";
    LiveTracks = "live_tracks", Level by [],
        "Level: system tracks, confirmed or coasted.";
    TentativeTracks = "tentative_tracks", Level by [],
        "Level: tentative system tracks.";
    CoastedTracks = "coasted_tracks", Level by [],
        "Level: coasted system tracks.";
    DeadlineMisses = "deadline_misses", Latency by [Fusion, Monitor],
        "Reports with a longer time in fusion than the configured deadline.";
    OrdersObeyed = "orders_obeyed", Process by [Fusion],
        "Orders obeyed by fusion.";
    OrdersRejected = "orders_rejected", Process by [Fusion],
        "Orders rejected by fusion: unknown kinds, conditions without a source.";
    RowsWritten = "rows_written", Process by [Recorder],
        "Rows written to files.";
    Datagrams = "datagrams", Network by [Adapter],
        "Datagrams received, or pieces read from a connection.";
    DatagramsRejected = "datagrams_rejected", NetworkTrouble by [Adapter],
        "Datagrams from senders missing in the receiver's list.";
    DatagramsRejectedLength = "datagrams_rejected_length", NetworkTrouble by [Adapter],
        "Empty datagrams, and datagrams longer than the receiver's buffer.";
    DatagramsDropped = "datagrams_dropped", NetworkTrouble by [Adapter],
        "Datagrams dropped by the kernel because the receiver's buffer was full.";
    Connections = "connections", Network by [Adapter, Gateway],
        "Connections made to a feed, or of clients.";
    RecordsSent = "records_sent", Network by [Gateway, Simulator, Link],
        "Records sent to other systems.";
    DatagramsSent = "datagrams_sent", Network by [Gateway, Simulator],
        "Datagrams sent to other systems.";
    SendFailures = "send_failures", NetworkTrouble by [Gateway, Simulator, Link],
        "Datagrams or messages not sent because of an error.";
    HeightAssumed = "height_assumed", AdapterRemark by [Adapter],
        "Reports without height, converted from slant range to a position with an assumed height.";
    TracesRejected = "traces_rejected", FusionRemark by [Fusion],
        "Covariance traces needed for a weight but missing or invalid; the configured weights were used.";
    CovariancesRepaired = "covariances_repaired", FusionRemark by [Fusion],
        "Covariances that were not positive definite, and were repaired or ignored.";
    StagesLate = "stages_late", Latency by [Monitor],
        "Stages of reports with a longer duration than their configured deadline, as measured by the monitor.";
    Detections = "detections", Tracking by [Adapter],
        "Detections published for the tracker in the source's adapter.";
    DetectionsRejected = "detections_rejected", Rejection by [Adapter],
        "Detections rejected by the adapter's tracker, or dropped because a table was full.";
    Scans = "scans", Tracking by [Adapter],
        "Scans processed by the adapter's tracker, including empty scans.";
    RejectedTargets = "rejected_targets", Rejection by [Adapter],
        "Wide-area reports with more targets than the largest permitted cluster.";
    WideAreaReports = "wide_area_reports", Tracking by [Adapter],
        "Wide-area reports accepted by the adapter's tracker.";
    WideAreaRejected = "wide_area_rejected", Tracking by [Adapter],
        "Wide-area reports rejected by the adapter's tracker, or dropped because a table was full.";
    WideAreaLost = "wide_area_lost", Tracking by [Adapter, Recorder],
        "Wide-area reports lost between their publisher and their reader (a tracker or the recorder).";
    WideAreaLate = "wide_area_late", Tracking by [Adapter],
        "Wide-area reports received after their scan had been processed, and used in the next scan.";
    WideAreaUsed = "wide_area_used", Tracking by [Adapter],
        "Wide-area reports used by the adapter's tracker.";
    WideAreaUnmatched = "wide_area_unmatched", Tracking by [Adapter],
        "Wide-area reports used, but not near any track.";
    Emissions = "emissions", Tracking by [Adapter],
        "Emissions of direction finders accepted by the adapter's tracker to identify tracks.";
    EmissionsRejected = "emissions_rejected", Tracking by [Adapter],
        "Emissions rejected: no frequency, an impossible value, too late, no room, or lost before arrival.";
    EmissionsUnclear = "emissions_unclear", Tracking by [Adapter],
        "Emissions from a direction with no track, or with several tracks.";
    Cues = "cues", Tracking by [Adapter],
        "Cues published: places where the sensor should look next.";
    DetectionsWithoutFix = "detections_without_fix", Tracking by [Adapter],
        "Bearings of transmitters without a fix, because the geometry does not allow a fix yet.";
    UnknownSenderBlocks (72) = "unknown_sender_blocks", Level by [],
        "Level: blocks received from the unknown sender with the most blocks.";
    UnknownSenders = "unknown_senders", Level by [],
        "Level: senders without a configured source.";
    BlocksOfOtherEdition = "blocks_of_other_edition", AdapterRemark by [Adapter],
        "Blocks that do not fit the configured edition but fit another edition of their category.";
    DetectionPermille (76) = "detection_permille", Level by [],
        "Level: scans with a detection of a tracked target, per thousand scans.";
    RejectedClock = "rejected_clock", FusionRejection by [Fusion],
        "Reports not used because of their source's clock: far from the time of receipt, or jumping.";
    RejectedContradicted = "rejected_contradicted", FusionRejection by [Fusion],
        "Reports not used because several other sources, in agreement with each other, contradict them.";
    EstimatesRestarted = "estimates_restarted", FusionRemark by [Fusion],
        "Estimates restarted because they were not finite or not plausible: a track's state, or a source's biases.";
    Rebuilds = "rebuilds", Process by [Launcher],
        "Times that the deployment was stopped and rebuilt because its shared memory was corrupt.";
    MissingRows = "missing_rows", Level by [],
        "Level: samples of a recorded source missing in the recorder's rows.";
    RecordedSamples = "recorded_samples", Process by [Recorder, Adapter],
        "Samples taken for the recording of all topics; in adapters, datagrams and lines written to captures.";
    RecordedLost = "recorded_lost", Process by [Recorder, Adapter],
        "Samples missing in the recording of all topics, rows missing in tables, or datagrams and lines missing in captures.";
    RecordingFailures = "recording_failures", Process by [Recorder, Adapter],
        "Failures to write the recording of all topics, a table or a capture; writing is retried every second.";
    RecordingsDeleted = "recordings_deleted", Process by [Recorder, Adapter],
        "Files of the recording of all topics, or captures, deleted to make room for later files.";
    DecisionsDropped = "decisions_dropped", Process by [Fusion],
        "Decisions of fusion not published because the second thread of fusion was too slow.";
    TakeOvers = "take_overs", Process by [Fusion],
        "Times that the standby fusion process took over.";
    TakeOversFromStill = "take_overs_from_still", Process by [Fusion],
        "Take-overs because the active fusion process did not advance.";
    PicturesSent = "pictures_sent", Process by [Display],
        "Pictures sent to connected pages.";
    PicturesSkipped = "pictures_skipped", Process by [Display],
        "Pictures not made because their page had not yet received the previous picture.";
    RequestsRejected = "requests_rejected", Process by [Gateway, Display, Link],
        "Requests and connections of browsers, clients, scripts and other hosts that were rejected.";
    Conflated = "conflated", Process by [Link],
        "States not sent to other hosts because a newer state of the same track replaced them.";
    MessagesRejected = "messages_rejected", Process by [Link],
        "Messages of other hosts that were rejected: malformed, repeated, or too many at a time.";
    LostOnTheWay = "lost_on_the_way", Process by [Link],
        "Samples of other hosts that were sent but did not arrive; subscribers on this host count these samples as lost.";
    Unsent = "unsent", Process by [Link],
        "Samples not sent to other hosts because the network is too slow for their rate.";
    MissingPeers = "missing_peers", Level by [],
        "Level: deployments of other hosts from which a link should receive but does not.";
    HostClockOffUs = "host_clock_off_us", Level by [],
        "Level: certain offset of another host's clock (UTC), microseconds: the part beyond the uncertainty of the comparison.";
    RejectedEpoch = "rejected_epoch", FusionRejection by [Monitor, Gateway, Display],
        "Samples of an earlier epoch of fusion, rejected after the first sample of a later epoch.";
    Stopping = "stopping", Level by [],
        "Level: 1 while the launcher stops the deployment.";
    ScanPeriodMs = "scan_period_ms", Level by [],
        "Level: duration of an antenna turn by which the adapter divides detections into scans, milliseconds; 0 while unknown.";
    Quarantined = "quarantined", FusionRejection by [Fusion],
        "Reports skipped because fusion had died twice while processing them.";
    RejectedByOrder = "rejected_by_order", FusionRejection by [Fusion],
        "Reports of sources excluded by an order.";
    RejectedTooFast = "rejected_too_fast", FusionRejection by [Fusion],
        "Reports faster than `limits.speed_mps`.";
    RejectedTooFar = "rejected_too_far", FusionRejection by [Fusion],
        "Reports further from their sensor than `limits.range_m`.";
    LateUsed = "late_used", FusionRemark by [Fusion],
        "Reports older than their track's state, used as if they had come in time.";
    LateBeyondWindow = "late_beyond_window", FusionRemark by [Fusion],
        "Reports older than their track's state by more than the window, carried forward to the state.";
    LateUnkept = "late_unkept", FusionRemark by [Fusion],
        "Reports within the window carried forward because earlier measurements are not kept: the track is young, or the table full.";
    AdvisoriesStuck = "advisories_stuck", AdapterRemark by [Adapter],
        "Targets with the bit of a resolution advisory for minutes without the advisory's text: the bit is not used.";
    RejectedFalsePosition = "rejected_false_position", FusionRejection by [Fusion],
        "Reports not used because other sources measure the same target elsewhere: targets on their own positions, and \
         targets that the source leads off.";
    SuspendedTracks = "suspended_tracks", Level by [],
        "Level: suspended system tracks: not shown, while their numbers rest.";
    NumbersResumed = "numbers_resumed", Picture by [Fusion],
        "System tracks under the number that their target had before it was silent.";
    SmoothingDropped = "smoothing_dropped", Process by [Fusion],
        "States and measurements not smoothed because the smoothing thread of fusion was too slow.";
    ExpiringCertificates (117) = "expiring_certificates", Level by [],
        "Level: certificates of a link, or of its authority, that expire within 30 days or have expired.";
    PlatformJumps (118) = "platform_jumps", AdapterRemark by [Adapter],
        "States of a platform that differ from the states before by more than any motion.";
    PlatformSilentMs = "platform_silent_ms", Level by [],
        "Level: time since the latest state of a platform beyond its limit, milliseconds.";
    SentencesPartial = "sentences_partial", Rejection by [Adapter],
        "Sentences of NMEA 0183 rejected because they were cut or too long.";
    SentencesChecksum = "sentences_checksum", Rejection by [Adapter],
        "Sentences of NMEA 0183 rejected because of their checksum.";
    SentencesTalker = "sentences_talker", Rejection by [Adapter],
        "Sentences of NMEA 0183 rejected because their talker is not known.";
    SentencesWithoutFix = "sentences_without_fix", Rejection by [Adapter],
        "Sentences of NMEA 0183 without a fix, or marked as invalid.";
    SentencesOther = "sentences_other", AdapterRemark by [Adapter],
        "Sentences of NMEA 0183 of kinds that are not read.";
    PlatformFarKm = "platform_far_km", Level by [],
        "Level: distance of a platform from the origin of the system frame where it is too far, kilometres.";
    RejectedPlatform = "rejected_platform", Rejection by [Adapter],
        "Detections rejected because no state of the sensor's platform belongs to their time.";
    DesignationsFollowed = "designations_followed", AdapterRemark by [Adapter],
        "Designations of targets that the tracker followed already; they change nothing.";
    SnapshotsForeign = "snapshots_foreign", Rejection by [Adapter],
        "Datagrams of array snapshots rejected because they have another layout or version.";
    SnapshotsLength = "snapshots_length", Rejection by [Adapter],
        "Datagrams of array snapshots rejected because their length is not the one that they state.";
    SnapshotsValue = "snapshots_value", Rejection by [Adapter],
        "Datagrams of array snapshots rejected because of an impossible value, or one unlike the rest of their measurement.";
    SnapshotsAntennas = "snapshots_antennas", Rejection by [Adapter],
        "Datagrams of array snapshots rejected because the configured array has another number of antennas.";
    SnapshotsRepeated = "snapshots_repeated", Rejection by [Adapter],
        "Datagrams of array snapshots rejected because they came twice, or after a later measurement.";
    SnapshotsMissing = "snapshots_missing", AdapterRemark by [Adapter],
        "Array snapshots that did not come; their measurement was made without them.";
    MeasurementsUnusable = "measurements_unusable", Rejection by [Adapter],
        "Measurements of an antenna array without a result: too few snapshots, no power, or too high a frequency.";
    BearingsAmbiguous = "bearings_ambiguous", Rejection by [Adapter],
        "Bearings not used because the antenna array cannot distinguish them from others.";
    BearingsOutsideSector = "bearings_outside_sector", Rejection by [Adapter],
        "Bearings not used because they are outside the sector of the antenna array.";
    BearingsUncertain = "bearings_uncertain", Rejection by [Adapter],
        "Bearings not used because their standard deviation exceeds 1 rad.";
    WavesUnresolved = "waves_unresolved", AdapterRemark by [Adapter],
        "Waves received by an antenna array that have no bearing of their own.";
    CopiesFailing = "copies_failing", Level by [],
        "Level: 1 while the memory for successors cannot be copied to disk.";
    ReportsAhead = "reports_ahead", Level by [],
        "Level: reports that a recorded source has made and that are not due yet.";
    LiveTracksMax = "live_tracks_max", Level by [],
        "Level: greatest number of system tracks that were confirmed or coasted at a time.";
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
