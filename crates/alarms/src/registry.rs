//! Registry of alarms: a line each.
//!
//! A code never changes and is never reused, because recordings and other systems identify alarms by code. The monitor
//! replaces words in braces when it raises the alarm; `source`, `partner` and `process` name the subject.

use messages::AlarmSeverity;

macro_rules! alarms {
    ($(
        $name:ident = $code:literal, $word:literal, $severity:ident, raise $raise_s:literal s, clear $clear_s:literal s,
            $sentence:literal,
            $remedy:literal;
    )*) => {
        /// Kind of an alarm.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u16)]
        pub enum AlarmKind {
            $( #[doc = $sentence] $name = $code, )*
        }

        impl AlarmKind {
            /// All kinds, in the order of the registry.
            pub const ALL: &'static [Self] = &[ $( Self::$name, )* ];

            /// Returns the word used in tables, files and metrics.
            pub const fn word(self) -> &'static str {
                match self { $( Self::$name => $word, )* }
            }

            /// Returns the severity.
            pub const fn severity(self) -> AlarmSeverity {
                match self { $( Self::$name => AlarmSeverity::$severity, )* }
            }

            /// Returns the time for which the condition must hold before the alarm is raised, nanoseconds.
            pub const fn raise_after_ns(self) -> i64 {
                match self { $( Self::$name => $raise_s * S, )* }
            }

            /// Returns the time for which the condition must be absent before the alarm is cleared, nanoseconds.
            pub const fn clear_after_ns(self) -> i64 {
                match self { $( Self::$name => $clear_s * S, )* }
            }

            /// Returns the sentence, with placeholders in braces.
            pub const fn sentence(self) -> &'static str {
                match self { $( Self::$name => $sentence, )* }
            }

            /// Returns the remedy: one sentence or two.
            pub const fn remedy(self) -> &'static str {
                match self { $( Self::$name => $remedy, )* }
            }
        }
    };
}

/// Nanoseconds in a second.
const S: i64 = 1_000_000_000;

impl AlarmKind {
    /// Returns the code used in samples.
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// Returns the kind of a sample's code; `None` for a code of a later version.
    pub fn from_code(code: u16) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.code() == code)
    }

    /// Returns the sentence with each of `values` in place of its name.
    pub fn say(self, values: &[(&str, String)]) -> String {
        values
            .iter()
            .fold(self.sentence().to_owned(), |sentence, (name, value)| {
                sentence.replace(&format!("{{{name}}}"), value)
            })
    }
}

alarms! {
    SourceSilent = 1, "source-silent", Major, raise 0 s, clear 0 s,
        "{source} has sent nothing for {silence}, {periods} of its periods.",
        "Check that the sensor transmits and the network delivers (address, port, group, interface of the receiver). \
         For a source with long pauses, raise `silent_periods`.";
    ClockOff = 2, "clock-off", Major, raise 5 s, clear 30 s,
        "The clock of {source} is {offset} off, compared with the times of receipt of its reports.",
        "Correct the sensor's clock, or this machine's. `[source.limits] time_step_s` sets the permitted offset.";
    SourceIsolated = 3, "source-isolated", Major, raise 0 s, clear 30 s,
        "{source} is isolated: {share} of its reports of the last minute ({bad} of {all}) have impossible times and \
         are not used.",
        "Correct the sensor's clock; fusion uses its reports again when their times are possible.";
    BiasChanged = 4, "bias-changed", Warning, raise 10 s, clear 60 s,
        "The {error} of {source} has changed from {before} to {now}.",
        "Check whether the sensor was moved, turned or adjusted. Fusion removes the estimated bias from reports.";
    AccuracyOverstated = 5, "accuracy-overstated", Warning, raise 30 s, clear 60 s,
        "The accuracy of {source} is overstated: its covariances are enlarged {factor} times.",
        "Configure larger sigmas in `[source.covariance]`; until then fusion enlarges the covariances.";
    DetectionFell = 6, "detection-fell", Warning, raise 30 s, clear 60 s,
        "{source} detects its targets in {now} of its scans, {before} before.",
        "Check the sensor's transmitter, receiver, antenna and thresholds, and the weather.";
    SenderUnknown = 7, "sender-unknown", Warning, raise 0 s, clear 30 s,
        "{process} receives data from senders without a configured source: {sender}, {blocks}{others}.",
        "Configure these codes as `sac` and `sic` of a source, or exclude the sender with `senders`.";
    EditionWrong = 8, "edition-wrong", Major, raise 0 s, clear 30 s,
        "{fitting} of {source} do not fit the configured edition, but fit category {category} edition {edition}.",
        "Configure this edition in the source's `editions`; `koseki decode --statistics` examines a recording.";
    NeverJoined = 9, "never-joined", Warning, raise 30 s, clear 30 s,
        "{source} and {partner} have no common track, but {pairs} of each move in parallel, all {shift} apart.",
        "Compare the positions of the two sensors: one position is wrong, or both sensors have the same position.";
    SamplesLost = 10, "samples-lost", Major, raise 0 s, clear 10 s,
        "{process} has lost {count}{of}: {process} fell behind, or a connection between hosts was interrupted.",
        "With the alarm `lost-on-the-way`, check the network between the hosts. Otherwise give the process more of \
         the machine (`[fusion] core`, fewer sources, fewer readers), or send less.";
    DatagramsDropped = 11, "datagrams-dropped", Major, raise 0 s, clear 10 s,
        "The kernel dropped {count} before {process} read them.",
        "Raise `buffer_bytes` of the receiver, and `net.core.rmem_max` of the machine.";
    SendFailed = 12, "send-failed", Major, raise 0 s, clear 10 s,
        "{process} could not send {count}.",
        "Check the interface, the route and the group of the gateway.";
    CapacityReached = 13, "capacity-reached", Major, raise 0 s, clear 10 s,
        "{process} had no room for {count}{of}.",
        "Raise `[fusion.capacity]` or `[source.limits] tracks`, or find the sender with too many targets.";
    LayoutMismatch = 14, "layout-mismatch", Major, raise 0 s, clear 10 s,
        "{process} has rejected {count} of a publisher with another layout.",
        "Build the publisher with the samples of this version.";
    ProcessRestarted = 15, "process-restarted", Major, raise 0 s, clear 60 s,
        "{process} was restarted, {times} so far: the last process {end}.",
        "Read the last output of the process on standard error.";
    ProcessDown = 16, "process-down", Critical, raise 1 s, clear 5 s,
        "{process} does not run: {end}.",
        "Read the last output of the process on standard error; the launcher starts the process again after a pause.";
    ProcessHung = 17, "process-hung", Critical, raise 0 s, clear 2 s,
        "{process} has published no health for {silence}.",
        "Check whether the machine is overloaded or the process was stopped.";
    DiskLow = 18, "disk-low", Major, raise 2 s, clear 10 s,
        "Only {free} are left on the disk of {folder}.",
        "Free space on the disk: a full disk ends the recording.";
    MemoryLow = 19, "memory-low", Critical, raise 2 s, clear 10 s,
        "Only {free} are left of {what}.",
        "Stop other programs on the machine, or add memory; the kernel kills a process without memory.";
    MemoryCorrupt = 20, "memory-corrupt", Critical, raise 0 s, clear 60 s,
        "The shared memory was corrupt; the deployment was rebuilt, {times} so far.",
        "Find the process of this user that writes outside its own memory, or test the machine's memory.";
    GrossError = 21, "gross-error", Major, raise 2 s, clear 30 s,
        "{source} has a bias of {error} relative to the tracks of {partner}{verdict}.",
        "Write the stated `north_offset_deg` into `[source.place]`; otherwise correct the sensor, its position or its \
         clock by this bias. `[fusion.registration] gross \
         = true` removes the bias if a third source, a `reference_source` or addresses identify the faulty sensor.";
    FusionTakenOver = 22, "fusion-taken-over", Major, raise 0 s, clear 60 s,
        "The standby fusion process has taken over, {times} so far, {still} because the active process did not \
         advance.",
        "Read the last output of the previous process on standard error. If a process did not advance, give fusion a \
         core of its own, or raise `takeover_ms`.";
    RecordingFailed = 23, "recording-failed", Major, raise 0 s, clear 5 s,
        "{process} cannot write its recording: {count} failed ({cause}).",
        "Free space on the disk, or remove the error reported on standard error. Recording resumes automatically; \
         missing samples are counted.";
    PeerMissing = 24, "peer-missing", Major, raise 3 s, clear 0 s,
        "{process} does not receive from all configured peers: {note}.",
        "Check that the other host and its link run, and that the network permits the connection.";
    HostClockOff = 25, "host-clock-off", Major, raise 3 s, clear 30 s,
        "The clock of another host is {offset} off, as compared by {process}: {note}.",
        "Synchronise the clocks of both hosts (NTP, PTP): fusion uses the times stated in reports.";
    TrackerIdle = 26, "tracker-idle", Warning, raise 0 s, clear 5 s,
        "The tracker of {source} made {reports} of tracks from its last {detections}, in {scans}{period}.",
        "Compare `period_s` with the duration of an antenna turn: `koseki check` prints the duration in a recording, \
         and without the key the adapter measures it. Compare the sigmas, `detection_probability` and \
         `clutter_density` with the sensor. If all detections are clutter, there is no fault.";
    ReportsLate = 27, "reports-late", Warning, raise 0 s, clear 10 s,
        "{source} sends late: {share} of its reports of the last minute ({bad} of {all}) arrived after later reports \
         and are not used.",
        "Raise `reorder_s` of its `[source.recorded]`, or `wait_s` of its `[source.tracker]`, to the delay of its \
         reports.";
    DataOff = 28, "data-off", Major, raise 5 s, clear 10 s,
        "The newest system tracks are {offset} off this machine's clock.",
        "Set this machine's clock, or that of the source with the alarm `clock-off`. Late tracks without `clock-off` \
         mean that fusion is overloaded: check the latencies.";
    MachineClockOff = 30, "machine-clock-off", Critical, raise 1 s, clear 30 s,
        "This machine's clock is {offset} off: the clocks of {sources} agree with each other, but not with this \
         machine.",
        "Set this machine's clock (NTP, PTP). Until then fusion uses the time of the sources.";
    ClocksDiffer = 31, "clocks-differ", Major, raise 1 s, clear 30 s,
        "The clocks of {source} and of this machine are {offset} apart; no other source identifies the wrong clock.",
        "Compare both with a third clock, and set the wrong clock. Until then fusion uses the time of the source.";
    ReportQuarantined = 32, "report-quarantined", Major, raise 0 s, clear 60 s,
        "{process} died twice while processing the same report of a source, and skips this report: {count} so far.",
        "Report the fault with the file named in fusion's log (the report and the checkpoint before the report) and, \
         if available, the recording. Fusion uses all other reports.";
    LostOnTheWay = 33, "lost-on-the-way", Major, raise 0 s, clear 10 s,
        "{count} of another host did not reach {process}: the connection was interrupted or is too slow.",
        "Check cable and network between the hosts. After an interruption the sender's link repeats reports of \
         sensors, up to `queue_mb`.";
    AlertStuck = 34, "alert-stuck", Warning, raise 0 s, clear 0 s,
        "{count} of {source} set the bit of an ACAS resolution advisory for more than 2 min without the advisory's \
         text (last 10 min). Fusion does not show this as an alert.",
        "No action is needed for the picture. Report the aircraft to their operators: `koseki decode` of a capture \
         lists the addresses with I021/008 RA = 1.";
    PositionFalse = 36, "position-false", Major, raise 0 s, clear 10 s,
        "{source} gives false positions of single targets: other sources measured the same targets elsewhere in {bad} of \
         {all} of the last minute ({share}).",
        "If targets report their positions themselves, find the addresses among the decisions `identity_conflict` of \
         `koseki fuse --explain`; otherwise check the sensor for reflections and jamming. Fusion does not use the positions \
         of these targets from this source until they agree again.";
    PlatformSilent = 40, "platform-silent", Major, raise 0 s, clear 2 s,
        "The platform of {process} has sent no state for {silence}.",
        "Check the navigation receiver and its line. States of this time are missing in the recording.";
    PlatformJumped = 41, "platform-jumped", Major, raise 0 s, clear 30 s,
        "The position, course or attitude of the platform of {process} jumped: {count}.",
        "Check the navigation receiver and the compass: detections of the sensors on board are displaced together. \
         `[platform.jumps]` sets the permitted differences.";
    PlatformFar = 42, "platform-far", Warning, raise 0 s, clear 30 s,
        "The platform of {process} is {distance} from the origin of the system frame.",
        "Choose an origin nearer to the platform (`[frame]`): beyond 300 km, the plane of the frame distorts.";
    RecordingIncomplete = 43, "recording-incomplete", Major, raise 0 s, clear 10 s,
        "The recording of {process} lacks {count}{of}: {cause}.",
        "On a full disk, free space or set `keep_gb`. Of a recorder that ended, read the last output on standard error. \
         Give a recorder that is too slow more of the machine.";
    CertificateExpires = 44, "certificate-expires", Major, raise 0 s, clear 10 s,
        "A certificate of {process} ends within 30 days, or has ended: {note}.",
        "Renew it with `koseki link renew`, copy the files to their host, and end the link's process: the launcher \
         starts the link again, with the new files. Peers refuse an expired certificate.";
    SecondPublisher = 45, "second-publisher", Major, raise 0 s, clear 10 s,
        "{source} has a second publisher: {which}.",
        "End one of the processes, or declare an external source for each: two publishers of a source double its \
         information.";
    LinesRefused = 46, "lines-refused", Major, raise 0 s, clear 10 s,
        "`koseki feed` refuses lines or connections{of}: {reasons}.",
        "Correct the sender: the words are the names of wrong fields, the last sentence is about the latest line, and \
         `koseki feed --help` lists the permitted fields. \
         `sender` counts datagrams of senders that are not listed, `length` empty and too long ones, `buffer` those that \
         the kernel dropped. Over TCP each refused line is answered. `connection` with a word counts connections that were \
         refused or ended: `silent` ones sent no line in time, `gave-way` ones sent none before others needed the place. \
         The last line of `koseki feed` on standard error names the latest peer; `--senders` keeps others out.";
    CheckpointUnkept = 47, "checkpoint-unkept", Major, raise 0 s, clear 10 s,
        "The memory for a start after a loss of power is not written to disk: {note}.",
        "Make the folder `checkpoint.folder` writable, or free space on its disk. A loss of power until then costs the \
         numbers of the tracks and what has been learned of the sources.";
    SourceRefused = 48, "source-refused", Major, raise 0 s, clear 10 s,
        "{source}: {refused} of {all} of the last 10 s were refused. {reason}",
        "Correct the sender, or the settings of the source: the text names line, column, field or item, its value, and \
         what is permitted. `koseki status` and the report show the latest refusal of each reason.";
    SourceOff = 49, "source-off", Warning, raise 2 s, clear 30 s,
        "{source} is off by {error}: the reference or a majority, with {partner}, shows it{verdict}.",
        "Check position, north mark, range and clock of the sensor. Fusion removes the error from its reports once the \
         error is significant, and until then does not use reports that contradict the others.";
    SourcesContradict = 50, "sources-contradict", Major, raise 2 s, clear 30 s,
        "{source} and {partner} contradict each other: {source} is off by {error} relative to {partner}, and no other \
         source decides.",
        "Check position, north mark, range and clock of both sensors, or name the true one as `reference_source` of \
         `[fusion.registration]`. Until then the tracks lie between the two, and their covariances contain both.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_words_name_one_alarm_each() {
        for (place, kind) in AlarmKind::ALL.iter().enumerate() {
            assert_eq!(AlarmKind::from_code(kind.code()), Some(*kind));
            let others = &AlarmKind::ALL[place + 1..];
            assert!(others.iter().all(|other| other.word() != kind.word()), "{kind:?}");
            assert!(
                others.iter().all(|other| other.code() > kind.code()),
                "{kind:?}: the table is in the order of codes"
            );
        }
        assert_eq!(AlarmKind::from_code(0), None);
    }

    #[test]
    fn values_take_the_place_of_their_names() {
        let values = [
            ("source", "radar".to_owned()),
            ("silence", "24 s".to_owned()),
            ("periods", "6".to_owned()),
        ];
        let sentence = AlarmKind::SourceSilent.say(&values);
        assert_eq!(sentence, "radar has sent nothing for 24 s, 6 of its periods.");
    }
}
