//! Event log of fusion.

use crate::codes;
use crate::codes::bits;
use crate::layout::sample;

codes! {
    /// Kind of a step in the event log.
    pub enum StepKind: u8 {
        /// Fusion starts from its configuration: `time_ns` is its epoch.
        Begin = 1, "begin";
        /// The report of `source` with the number `sequence` is worked off, and time has passed up to `time_ns`.
        Report = 2, "report";
        /// The next reports of `source` come from the publisher with the incarnation `time_ns`.
        Publisher = 3, "publisher";
        /// Time has passed up to `time_ns` without a report.
        Time = 4, "time";
        /// Condition (weather) number `sequence` holds from now on, when time has passed up to `time_ns`. Written by
        /// builds before the kind `Order`.
        Condition = 5, "condition";
        /// Fusion resumes from the data on `system/restored` for its epoch; tracks listed there are reported as
        /// terminated.
        Restored = 6, "restored";
        /// Numbers of system tracks begin at `sequence`, because the numbers assigned before are unknown.
        Numbers = 7, "numbers";
        /// A snapshot of the engine's present state is published on `system/restored`, with the time `time_ns`.
        Image = 8, "image";
        /// The sources' time is ahead of the engine's by `time_ns` (nanoseconds) from now on: the host offset.
        HostOffset = 9, "host_offset";
        /// The clock of `source` is off by `sequence` milliseconds (as a signed number), as times of receipt show it.
        SourceClock = 10, "source_clock";
        /// The report of `source` with the number `sequence` is in quarantine and has no effect: fusion has died in the
        /// report twice.
        Quarantine = 11, "quarantine";
        /// Bytes 8·`sequence` to 8·`sequence` + 7 of the order that the next step of kind `Order` completes are
        /// `time_ns`, low byte first.
        OrderPart = 12, "order_part";
        /// The order of the preceding parts has its effect now, when time has passed up to `time_ns`.
        Order = 13, "order";
    }
}

bits! {
    /// Bits of [`WorkStep::flags`].
    work_step_bits: u8 {
        /// Fusion did not believe the time of the report.
        WILD_CLOCK = 1;
    }
}

sample! {
    /// Step in the event log: with the reports, all steps since a start reproduce the same system tracks.
    WorkStep, size 16 {
        /// Engine's time up to which time has passed with this step, nanoseconds; i64::MIN: unknown. Other meanings:
        /// see `StepKind`.
        time_ns: i64,
        /// Number of the report, modulo 2^32: its index among the samples of its publisher; in order `time` its own
        /// `sequence`.
        sequence: u32,
        /// Number of the source; 65535 if the step is of none.
        source: u16,
        /// Kind of step: a `StepKind` code.
        kind: u8,
        /// Flags: see `work_step_bits`.
        flags: u8,
    }
}

impl WorkStep {
    /// Offset of a source's clock in the absence of an estimate, in place of milliseconds.
    pub const CLOCK_UNKNOWN: i32 = i32::MIN;

    /// Returns the offset, milliseconds, stated by a step of kind [`StepKind::SourceClock`]; `None` if it is unknown.
    pub fn clock_offset_ms(&self) -> Option<i32> {
        let offset_ms = self.sequence.cast_signed();
        (offset_ms != Self::CLOCK_UNKNOWN).then_some(offset_ms)
    }
}
