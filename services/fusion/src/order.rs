//! The order of work, written down step by step, each before anything that came of it is published: whoever has the
//! reports and these steps can make the same system tracks.

use bus::{Bus, BusError, LogWriter, Transport};
use messages::{NO_SOURCE, StepKind, WorkStep, work_step_bits};

/// Writes the order of work down.
#[derive(Debug)]
pub(crate) struct OrderOfWork {
    log: LogWriter<WorkStep>,
    /// Whose reports were worked off last, for each source.
    publishers: Vec<Option<u64>>,
}

/// Report as its publisher numbered it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbered {
    /// Incarnation of the publisher.
    pub(crate) publisher: u64,
    pub(crate) sequence: u64,
    /// Whether its time is not believed here.
    pub(crate) is_wild: bool,
}

impl OrderOfWork {
    /// Order of work of the fusion that starts now as `epoch`, with so many sources.
    ///
    /// # Errors
    /// If there is no log.
    pub(crate) fn begin<S: Transport>(bus: &Bus<S>, epoch: u64, sources: usize) -> Result<Self, BusError> {
        let mut order = Self {
            log: bus.log_writer(&messages::order())?,
            publishers: vec![None; sources],
        };
        order.write(StepKind::Begin, NO_SOURCE, 0, epoch.cast_signed());
        Ok(order)
    }

    /// A report was worked off, and time has passed up to `passed_ns`.
    #[inline]
    pub(crate) fn report(&mut self, source: u16, report: Numbered, passed_ns: i64) {
        self.publisher(source, report.publisher);
        self.log.write(&WorkStep {
            time_ns: passed_ns,
            sequence: report.sequence as u32,
            source,
            kind: StepKind::Report as u8,
            flags: u8::from(report.is_wild) * work_step_bits::WILD_CLOCK,
        });
    }

    /// The report is in quarantine, and has no effect.
    #[cold]
    pub(crate) fn quarantine(&mut self, source: u16, report: Numbered, passed_ns: i64) {
        self.publisher(source, report.publisher);
        self.write(StepKind::Quarantine, source, report.sequence as u32, passed_ns);
    }

    /// The next reports of `source` are those of `publisher`.
    #[inline]
    fn publisher(&mut self, source: u16, publisher: u64) {
        let last = &mut self.publishers[usize::from(source)];
        if *last != Some(publisher) {
            *last = Some(publisher);
            self.write(StepKind::Publisher, source, 0, publisher.cast_signed());
        }
    }

    /// Time has passed up to `passed_ns`, and changed something.
    pub(crate) fn time(&mut self, passed_ns: i64) {
        self.write(StepKind::Time, NO_SOURCE, 0, passed_ns);
    }

    /// The condition of this number holds, from `passed_ns` on.
    pub(crate) fn condition(&mut self, number: u32, passed_ns: i64) {
        self.write(StepKind::Condition, NO_SOURCE, number, passed_ns);
    }

    /// The sources' time is ahead of the engine's by `offset_ns` from now on.
    pub(crate) fn host_offset(&mut self, offset_ns: i64) {
        self.write(StepKind::HostOffset, NO_SOURCE, 0, offset_ns);
    }

    /// The clock of `source` is off by `offset_ms` from now on, when time has passed up to `passed_ns`.
    pub(crate) fn source_clock(&mut self, source: u16, offset_ms: Option<i32>, passed_ns: i64) {
        let offset_ms = offset_ms.unwrap_or(WorkStep::CLOCK_UNKNOWN);
        self.write(StepKind::SourceClock, source, offset_ms.cast_unsigned(), passed_ns);
    }

    /// The engine goes on from what was said to be restored.
    pub(crate) fn restored(&mut self) {
        self.write(StepKind::Restored, NO_SOURCE, 0, 0);
    }

    /// The next system track that starts has this number.
    pub(crate) fn numbers(&mut self, first: u32) {
        self.write(StepKind::Numbers, NO_SOURCE, first, 0);
    }

    /// An image of the engine is made, which is said under this time. Publishers are named again: whoever begins here
    /// knows none.
    pub(crate) fn image(&mut self, time_ns: i64) {
        self.write(StepKind::Image, NO_SOURCE, 0, time_ns);
        self.publishers.fill(None);
    }

    fn write(&mut self, kind: StepKind, source: u16, sequence: u32, time_ns: i64) {
        self.log.write(&WorkStep {
            time_ns,
            sequence,
            source,
            kind: kind as u8,
            flags: 0,
        });
    }
}
