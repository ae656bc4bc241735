//! What every process says about itself, several times a second.

use crate::Registration;
use crate::layout::sample;

/// Length of [`Health::counters`].
pub const COUNTERS_MAX: usize = 80;

/// [`Health::source`] of a message that speaks of the whole process.
pub const NO_SOURCE: u16 = u16::MAX;

/// A name in a [`Health`] message: UTF-8, padded with zeros.
pub type HealthName = [u8; 32];

sample! {
    /// State and counters of one process, or of one source within it.
    Health, size 888 {
        /// When this was said, monotonic, nanoseconds.
        said_ns: i64,
        /// Monotonic start time of the process, nanoseconds.
        incarnation: u64,
        /// How far the process has got in the time of its data, UTC, nanoseconds; i64::MIN if unknown.
        progress_ns: i64,
        /// Operating system's process number.
        process_id: u32,
        /// Source that the counters speak of; 65535 for the process as a whole.
        source: u16,
        /// What kind of process: a `ProcessKind` code.
        kind: u8,
        /// A `LifeState` code.
        life: u8,
        /// Restarts of the process so far, as its launcher counts them.
        restarts: u32,
        /// Reserved, 0.
        reserved: u32,
        /// Name of the process, UTF-8, padded with zeros.
        name: [u8; 32],
        /// What is wrong, in a few words; empty if nothing is. Of an adapter's source: its name. UTF-8, padded with zeros.
        note: [u8; 56],
        /// Values of the counters, indexed by `Counter`.
        counters: [u64; 80],
        /// Systematic errors of the source, where fusion speaks of one.
        registration: Registration,
    }
}

impl Default for Health {
    fn default() -> Self {
        Self {
            said_ns: 0,
            incarnation: 0,
            progress_ns: i64::MIN,
            process_id: 0,
            source: NO_SOURCE,
            kind: 0,
            life: 0,
            restarts: 0,
            reserved: 0,
            name: [0; 32],
            note: [0; 56],
            counters: [0; COUNTERS_MAX],
            registration: Registration::default(),
        }
    }
}

impl Health {
    /// The process's name.
    pub fn name(&self) -> &str {
        text(&self.name)
    }

    /// What is wrong, or an empty string; where an adapter speaks of one of its sources, the source's name.
    pub fn note(&self) -> &str {
        text(&self.note)
    }

    /// This message with another note, cut to what fits.
    #[must_use]
    pub fn with_note(mut self, note: &str) -> Self {
        fill(&mut self.note, note);
        self
    }

    /// This message with another name, cut to what fits.
    #[must_use]
    pub fn with_name(mut self, name: &str) -> Self {
        fill(&mut self.name, name);
        self
    }

    /// The value of one counter.
    pub fn counter(&self, counter: Counter) -> u64 {
        self.counters[counter as usize]
    }

    /// The process's kind; `None` for a code of another schema.
    pub fn kind(&self) -> Option<ProcessKind> {
        PROCESS_KINDS.get(usize::from(self.kind)).copied()
    }

    /// Where the process is in its life; `None` for a code of another schema.
    pub fn life(&self) -> Option<LifeState> {
        LifeState::ALL.get(usize::from(self.life)).copied()
    }
}

fn text(bytes: &[u8]) -> &str {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    std::str::from_utf8(&bytes[..end]).unwrap_or("?")
}

fn fill(bytes: &mut [u8], text: &str) {
    let mut end = text.len().min(bytes.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    bytes.fill(0);
    bytes[..end].copy_from_slice(&text.as_bytes()[..end]);
}

/// The kinds of processes a deployment is made of (PL-1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ProcessKind {
    /// Turns one sensor's data into sensor tracks.
    Adapter,
    /// Fuses sensor tracks into system tracks.
    Fusion,
    /// Records latencies and counters.
    Monitor,
    /// Writes tracks to files.
    Recorder,
    /// Starts and watches the others.
    Launcher,
    /// Sends what the simulated sensors observe over the network.
    Simulator,
    /// Sends tracks to other systems over the network.
    Gateway,
}

/// Every kind, in the order of its code.
pub const PROCESS_KINDS: [ProcessKind; 7] = [
    ProcessKind::Adapter,
    ProcessKind::Fusion,
    ProcessKind::Monitor,
    ProcessKind::Recorder,
    ProcessKind::Launcher,
    ProcessKind::Simulator,
    ProcessKind::Gateway,
];

impl ProcessKind {
    /// The word that the command line uses (FM-3).
    pub fn word(self) -> &'static str {
        match self {
            Self::Adapter => "adapter",
            Self::Fusion => "fusion",
            Self::Monitor => "monitor",
            Self::Recorder => "recorder",
            Self::Launcher => "launcher",
            Self::Simulator => "simulator",
            Self::Gateway => "gateway",
        }
    }
}

/// Where a process is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum LifeState {
    /// Opening its topics.
    Starting,
    /// Doing its work.
    Running,
    /// All its input has been worked off; it will exit by itself.
    Finished,
    /// Cannot go on; the note says why.
    Failed,
}

impl LifeState {
    /// Every state, in the order of its code.
    pub const ALL: [Self; 4] = [Self::Starting, Self::Running, Self::Finished, Self::Failed];

    /// The word that tables use.
    pub fn word(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::Running => "running",
            Self::Finished => "finished",
            Self::Failed => "failed",
        }
    }
}

/// Declares the counters once: code, label and the sentence that help texts and metrics show.
macro_rules! counters {
    ($( $name:ident = $label:literal, $sentence:literal; )*) => {
        /// Something that is counted since the process started (a few are levels, and say so).
        ///
        /// Overload, loss and bad input are counters, not log lines: they can be read from outside at any time.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u16)]
        pub enum Counter {
            $( #[doc = $sentence] $name, )*
        }

        impl Counter {
            /// Every counter, in the order of its code.
            pub const ALL: &'static [Self] = &[ $( Self::$name, )* ];

            /// Short name, as tables, JSON and metrics use it.
            pub fn label(self) -> &'static str {
                match self { $( Self::$name => $label, )* }
            }

            /// One sentence that says what is counted.
            pub fn sentence(self) -> &'static str {
                match self { $( Self::$name => $sentence, )* }
            }
        }

        const _: () = assert!(Counter::ALL.len() <= COUNTERS_MAX);
    };
}

counters! {
    Records = "records", "Records decoded from the source, of any kind.";
    ServiceMessages = "service_messages", "Records that speak of the sensor, not of a target.";
    BytesRefused = "bytes_refused", "Bytes of blocks that could not be explained and were skipped.";
    BlocksRefused = "blocks_refused", "Blocks that could not be explained, wholly or in part.";
    Published = "published", "Samples published.";
    Reports = "reports", "Reports of targets that passed every check.";
    RejectedFieldMonitor = "rejected_field_monitor", "Reports of a fixed field monitor, which is no aircraft.";
    RejectedTestTarget = "rejected_test_target", "Reports marked as simulated or test targets.";
    RejectedNoPosition = "rejected_no_position", "Reports without a usable position (a track's last message, for example).";
    RejectedNoTrackNumber = "rejected_no_track_number", "Reports with neither track number nor address.";
    RejectedPosition = "rejected_position", "Reports with a position that cannot be: outside the sensor's range or the globe.";
    RejectedHeight = "rejected_height", "Heights that cannot be; the report is used without its height.";
    RejectedSpeed = "rejected_speed", "Reports with a speed that no target has.";
    RejectedJump = "rejected_jump", "Reports that would need an impossible speed since the track's previous ones.";
    RejectedTime = "rejected_time", "Reports with a time of day far from that of their neighbours.";
    RejectedLate = "rejected_late", "Reports older than the source's own progress mark.";
    RejectedQuality = "rejected_quality", "Reports whose own quality figure says that the position cannot be used.";
    RejectedSource = "rejected_source", "Reports of another SAC/SIC than the one configured.";
    TracksEnded = "tracks_ended", "Sensor tracks that their source declared ended.";
    RefusedTracks = "refused_tracks", "Reports of tracks for which the adapter's table had no room.";
    WaitedForConsumers = "waited_for_consumers", "Times a recorded source waited for its consumers so that nothing is lost.";
    Taken = "taken", "Samples taken from the source's topic.";
    Lost = "lost", "Samples missing from the source's sequence: dropped because the reader fell behind.";
    OutOfOrder = "out_of_order", "Samples not newer than one already worked off: repeated, or out of order.";
    Invalid = "invalid", "Samples refused because a value is not finite or a code unknown.";
    SchemaMismatch = "schema_mismatch", "Batches refused because their publisher was built with another layout.";
    QueueFull = "queue_full", "Reports dropped because the source's queue in fusion was full, oldest first.";
    TableFull = "table_full", "Reports refused because the system-track table or a target's list of sources was full.";
    TracksStarted = "tracks_started", "System tracks started.";
    TracksConfirmed = "tracks_confirmed", "System tracks confirmed.";
    TracksTerminated = "tracks_terminated", "System tracks ended.";
    TracksMerged = "tracks_merged", "System tracks found to be the same target as another, and merged into it.";
    ContributionsSplit = "contributions_split", "Sensor tracks taken out of a system track they no longer fitted.";
    Duplicates = "duplicates", "Reports of a second track of one source on one target: recognised, not used.";
    Extrapolated = "extrapolated", "Reports that are their source's own extrapolation: no observation, so not used.";
    IdentityConflicts = "identity_conflicts", "Reports whose identity contradicted that of the system track they had belonged to.";
    HandOvers = "hand_overs", "Changes of the selected source.";
    LiveTracks = "live_tracks", "Level: system tracks that are confirmed or coasted now.";
    TentativeTracks = "tentative_tracks", "Level: system tracks that are tentative now.";
    CoastedTracks = "coasted_tracks", "Level: system tracks that are coasted now.";
    DeadlineMisses = "deadline_misses", "Reports that took longer through fusion than the configured deadline.";
    OrdersObeyed = "orders_obeyed", "Orders that fusion has obeyed.";
    OrdersRefused = "orders_refused", "Orders that fusion has refused: unknown kinds, conditions that no source names.";
    RowsWritten = "rows_written", "Rows written to files.";
    Datagrams = "datagrams", "Datagrams received, or pieces read from a connection.";
    DatagramsRefused = "datagrams_refused", "Datagrams from senders that are not on the receiver's list.";
    DatagramsUnusable = "datagrams_unusable", "Datagrams that were empty or longer than the receiver's buffer.";
    KernelDrops = "kernel_drops", "Datagrams that the kernel dropped because the receiver's buffer was full.";
    Connections = "connections", "Connections to a feed that were made.";
    RecordsSent = "records_sent", "Records sent to other systems.";
    DatagramsSent = "datagrams_sent", "Datagrams sent to other systems.";
    SendFailures = "send_failures", "Datagrams that could not be sent.";
    HeightAssumed = "height_assumed", "Reports without height whose slant range was turned into a place by an assumed one.";
    TracesUnusable = "traces_unusable", "Times a covariance trace was asked for and missing or no trace; the configured weights held.";
    CovariancesRepaired = "covariances_repaired", "Times a covariance was not positive definite, and was repaired or left out.";
    StagesLate = "stages_late", "Stages of reports that took longer than their configured deadline, as the monitor has seen it.";
    Detections = "detections", "Detections published, of which the source's adapter makes tracks.";
    DetectionsRefused = "detections_refused", "Detections for which the adapter's tracker had no room or no use.";
    Scans = "scans", "Scans that the adapter's tracker worked off, silent ones included.";
    RejectedTargets = "rejected_targets", "Wide-area reports with more targets than any cluster can have.";
    WideAreaReports = "wide_area_reports", "Wide-area reports that the adapter's tracker took.";
    WideAreaRefused = "wide_area_refused", "Wide-area reports that the adapter's tracker refused, or for which there was no room.";
    WideAreaLost = "wide_area_lost", "Wide-area reports that were published and did not reach their reader, a tracker or the recorder.";
    WideAreaLate = "wide_area_late", "Wide-area reports that came when the scan they were for had been worked off: used in the next one.";
    WideAreaUsed = "wide_area_used", "Wide-area reports that the adapter's tracker used.";
    WideAreaUnmatched = "wide_area_unmatched", "Wide-area reports, of those used, that were near no track.";
    Emissions = "emissions", "Emissions of direction finders that the adapter's tracker took, to identify its tracks.";
    EmissionsRefused = "emissions_refused", "Emissions refused: without a frequency, with a value that cannot be, too late, without room, or lost on the way.";
    EmissionsUnclear = "emissions_unclear", "Emissions in whose direction there was no track, or more than one.";
    Cues = "cues", "Cues published: where the sensor should look next.";
    DetectionsWithoutFix = "detections_without_fix", "Bearings of transmitters whose place the geometry does not yet allow to be told.";
}
