//! Registry of alarms: a line each.
//!
//! A code never changes and is never reused, because recordings and other systems identify alarms by code. Words in
//! braces are filled in when the alarm is raised; `source`, `partner` and `process` are the names of its subject.

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
        "Look whether the sensor transmits and the network delivers (address, port, group, interface of the receiver). \
         A source that may be quiet for so long gets a larger `silent_periods`.";
    ClockOff = 2, "clock-off", Major, raise 5 s, clear 30 s,
        "The clock of {source} is {offset} off, by the times at which its reports are received.",
        "Set the sensor's clock, or this machine's: `[source.limits] time_step_s` says how far it may be off.";
    SourceIsolated = 3, "source-isolated", Major, raise 0 s, clear 30 s,
        "{source} is isolated: {share} of its reports of the last minute ({bad} of {all}) claim times that cannot be, and are \
         kept out of the tracks.",
        "Set the sensor's clock; its reports are used again as soon as their times can be.";
    BiasChanged = 4, "bias-changed", Warning, raise 10 s, clear 60 s,
        "The {error} of {source} has changed from {before} to {now}.",
        "Look whether the sensor was moved, turned or set anew. What is known of the error is removed from reports.";
    AccuracyOverstated = 5, "accuracy-overstated", Warning, raise 30 s, clear 60 s,
        "{source} claims too much accuracy: its covariances are enlarged {factor} times.",
        "Give it larger sigmas in `[source.covariance]`; until then fusion enlarges them itself.";
    DetectionFell = 6, "detection-fell", Warning, raise 30 s, clear 60 s,
        "{source} sees its targets in {now} of its scans, {before} before.",
        "Look at the sensor's transmitter, receiver and antenna, at its thresholds, and at the weather.";
    SenderUnknown = 7, "sender-unknown", Warning, raise 0 s, clear 30 s,
        "{process} hears senders that no source is configured for: {sender}, {blocks}{others}.",
        "Write these codes as `sac` and `sic` of the source that they are of, or keep the sender out with `senders`.";
    EditionWrong = 8, "edition-wrong", Major, raise 0 s, clear 30 s,
        "{fitting} of {source} cannot be read as configured, and fit category {category} edition {edition}.",
        "Write that edition into the source's `editions`; `koseki decode --statistics` looks at a recording of it.";
    NeverJoined = 9, "never-joined", Warning, raise 30 s, clear 30 s,
        "{source} and {partner} have no track in common, and {pairs} of each fly side by side, all {shift} apart.",
        "Compare the places of the two sensors: one of them is configured wrongly, or both are of one place.";
    SamplesLost = 10, "samples-lost", Major, raise 0 s, clear 10 s,
        "{process} has lost {count}{of}: {process} fell behind, or a connection between hosts was interrupted.",
        "If `lost-on-the-way` stands as well, look at the network between the hosts. Else give the process more of the \
         machine (`[fusion] core`, fewer sources, fewer readers), or send less.";
    DatagramsDropped = 11, "datagrams-dropped", Major, raise 0 s, clear 10 s,
        "The kernel has dropped {count} before {process} had read them.",
        "Raise `buffer_bytes` of the receiver, and `net.core.rmem_max` of the machine.";
    SendFailed = 12, "send-failed", Major, raise 0 s, clear 10 s,
        "{process} could not send {count}.",
        "Look at the interface, the route and the group that the gateway sends to.";
    CapacityReached = 13, "capacity-reached", Major, raise 0 s, clear 10 s,
        "{process} had no room for {count}{of}.",
        "Raise `[fusion.capacity]` or `[source.limits] tracks`, or find out who sends so much.";
    LayoutMismatch = 14, "layout-mismatch", Major, raise 0 s, clear 10 s,
        "{process} has rejected {count}, whose publisher was built with another layout.",
        "Build the publisher with the samples of this version.";
    ProcessRestarted = 15, "process-restarted", Major, raise 0 s, clear 60 s,
        "{process} was restarted, {times} so far: the last one {end}.",
        "Read what it wrote to standard error before it ended.";
    ProcessDown = 16, "process-down", Critical, raise 1 s, clear 5 s,
        "{process} does not run: {end}.",
        "Read what it wrote to standard error; it is started again after a while.";
    ProcessHung = 17, "process-hung", Critical, raise 0 s, clear 2 s,
        "{process} says nothing for {silence}.",
        "Look whether the machine is overloaded, or the process was stopped.";
    DiskLow = 18, "disk-low", Major, raise 2 s, clear 10 s,
        "{free} are left on the disk of {folder}.",
        "Make room: a full disk ends the recording.";
    MemoryLow = 19, "memory-low", Critical, raise 2 s, clear 10 s,
        "{free} are left of {what}.",
        "End what else runs on the machine, or give it more; a process that gets none is killed.";
    MemoryCorrupt = 20, "memory-corrupt", Critical, raise 0 s, clear 60 s,
        "The shared memory was corrupt, and the deployment was rebuilt, {times} so far.",
        "Find out which process of this user writes where it should not, or test the machine's memory.";
    GrossError = 21, "gross-error", Major, raise 2 s, clear 30 s,
        "{source} is off by {error}, as the tracks of {partner} show{verdict}.",
        "Correct the sensor, or its place, `north_offset_deg` or clock, by that. `[fusion.registration] gross = true` takes \
         it off where a third source, a `reference_source` or addresses tell whose error it is.";
    FusionTakenOver = 22, "fusion-taken-over", Major, raise 0 s, clear 60 s,
        "The fusion that stood by has taken over, {times} so far, {still} from one that stood still.",
        "Read what the one before it wrote to standard error before it ended. One that stands still was kept from \
         running: give fusion a core of its own, or raise `takeover_ms`.";
    RecordingFailed = 23, "recording-failed", Major, raise 0 s, clear 5 s,
        "{process} cannot write its recording: {count} in vain.",
        "Make room on the disk, or mend what it said on standard error; it goes on by itself, and what is missing is \
         counted.";
    PeerMissing = 24, "peer-missing", Major, raise 3 s, clear 0 s,
        "{process} does not hear all that it is to receive from: {note}.",
        "Look whether the other host and its link run, and whether the network lets the connection pass.";
    HostClockOff = 25, "host-clock-off", Major, raise 3 s, clear 30 s,
        "The clock of another host is {offset} off by the comparison of {process}: {note}.",
        "Synchronise the clocks of both hosts (NTP, PTP): reports are used by the time that they state.";
    TrackerIdle = 26, "tracker-idle", Warning, raise 0 s, clear 5 s,
        "The tracker of {source} has made {reports} of tracks of its last {detections}, in {scans} of {period}.",
        "Compare `period_s` with the time of a turn (`koseki check` shows that of a recording; left out, it is found in the \
         data), and the sigmas, `detection_probability` and `clutter_density` with the sensor. Where there are only \
         false detections, there is nothing to do.";
    ReportsLate = 27, "reports-late", Warning, raise 0 s, clear 10 s,
        "{source} sends late: {share} of its reports of the last minute ({bad} of {all}) came after later ones, and are not used.",
        "Raise `reorder_s` of its `[source.recorded]`, or `wait_s` of its `[source.tracker]`, to what its reports are late by.";
    DataOff = 28, "data-off", Major, raise 5 s, clear 10 s,
        "The newest system tracks are {offset} off the clock of this machine.",
        "Set this machine's clock, or that of the source that has a `clock-off`. Tracks that are behind without one show \
         that fusion does not keep up: look at the latencies.";
    MachineClockOff = 30, "machine-clock-off", Critical, raise 1 s, clear 30 s,
        "This machine's clock is {offset} off: the clocks of {sources} agree with each other, and not with it.",
        "Set this machine's clock (NTP, PTP). Fusion goes on meanwhile, in the time of the sources.";
    ClocksDiffer = 31, "clocks-differ", Major, raise 1 s, clear 30 s,
        "The clocks of {source} and of this machine are {offset} apart, and no other source shows which one is wrong.",
        "Compare both with a third clock, and set the wrong one. Fusion goes on meanwhile, in the time of the source.";
    ReportQuarantined = 32, "report-quarantined", Major, raise 0 s, clear 60 s,
        "{process} died twice while it worked off the same report of a source, and passes over it: {count} so far.",
        "Report the fault with the file that the log of fusion names (the report, and the checkpoint before it) and, if \
         there is one, the recording. All other reports are used.";
    LostOnTheWay = 33, "lost-on-the-way", Major, raise 0 s, clear 10 s,
        "{count} of another host did not reach {process}: the connection was interrupted, or is too slow.",
        "Look at cable and network between the hosts. Reports of sensors come again after an interruption, as far as \
         `queue_mb` of the sender's link holds them.";
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
