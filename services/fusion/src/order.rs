//! Event log, written step by step, each step before the publication of its effect. The reports and these steps
//! reproduce the same system tracks.

use bus::{Bus, BusError, LogWriter, Transport};
use messages::{NO_SOURCE, Order, StepKind, WorkStep, work_step_bits};

/// Writer of the event log.
#[derive(Debug)]
pub(crate) struct OrderOfWork {
    log: LogWriter<WorkStep>,
    /// Latest publisher of each source.
    publishers: Vec<Option<u64>>,
}

/// Number of a report at its publisher.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbered {
    /// Epoch of the publisher.
    pub(crate) publisher: u64,
    pub(crate) sequence: u64,
    /// Whether the report's time is rejected here.
    pub(crate) is_wild: bool,
}

impl OrderOfWork {
    /// Opens the event log of the fusion that starts as `epoch`, with so many sources.
    ///
    /// # Errors
    /// If there is no log.
    pub(crate) fn begin<S: Transport>(bus: &Bus<S>, epoch: u64, sources: usize) -> Result<Self, BusError> {
        let mut order = Self {
            log: bus.log_writer(&messages::event_log())?,
            publishers: vec![None; sources],
        };
        order.write(StepKind::Begin, NO_SOURCE, 0, epoch.cast_signed());
        Ok(order)
    }

    /// Logs that a report is finished, and that time has passed up to `passed_ns`.
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

    /// Logs that the report is in quarantine and has no effect.
    #[cold]
    pub(crate) fn quarantine(&mut self, source: u16, report: Numbered, passed_ns: i64) {
        self.publisher(source, report.publisher);
        self.write(StepKind::Quarantine, source, report.sequence as u32, passed_ns);
    }

    /// Logs that the next reports of `source` are from `publisher`.
    #[inline]
    fn publisher(&mut self, source: u16, publisher: u64) {
        let last = &mut self.publishers[usize::from(source)];
        if *last != Some(publisher) {
            *last = Some(publisher);
            self.write(StepKind::Publisher, source, 0, publisher.cast_signed());
        }
    }

    /// Logs that time has passed up to `passed_ns` with an effect.
    pub(crate) fn time(&mut self, passed_ns: i64) {
        self.write(StepKind::Time, NO_SOURCE, 0, passed_ns);
    }

    /// Logs the whole order, whose effect takes place at `passed_ns`.
    #[cold]
    pub(crate) fn order(&mut self, order: &Order, passed_ns: i64) {
        for step in order.steps(passed_ns) {
            self.log.write(&step);
        }
    }

    /// Logs the lead of the sources' time over the engine's, `offset_ns`, from now on.
    pub(crate) fn host_offset(&mut self, offset_ns: i64) {
        self.write(StepKind::HostOffset, NO_SOURCE, 0, offset_ns);
    }

    /// Logs the clock offset `offset_ms` of `source`, at the time `passed_ns`.
    pub(crate) fn source_clock(&mut self, source: u16, offset_ms: Option<i32>, passed_ns: i64) {
        let offset_ms = offset_ms.unwrap_or(WorkStep::CLOCK_UNKNOWN);
        self.write(StepKind::SourceClock, source, offset_ms.cast_unsigned(), passed_ns);
    }

    /// Logs that the engine resumes from the published snapshot.
    pub(crate) fn restored(&mut self) {
        self.write(StepKind::Restored, NO_SOURCE, 0, 0);
    }

    /// Logs the number of the next new system track.
    pub(crate) fn numbers(&mut self, first: u32) {
        self.write(StepKind::Numbers, NO_SOURCE, first, 0);
    }

    /// Logs a snapshot of the engine, published with this time. Publishers are logged again, for replays that begin
    /// here.
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
