//! The event log: all changes of an engine in order, as steps of 16 bytes ([`WorkStep`]).
//!
//! Reports and snapshots are not in the log: events name both. `EventWriter` turns events into steps, and
//! [`EventReader`] turns steps back into events.

use messages::{NO_SOURCE, Order, StepKind, WorkStep, work_step_bits};

/// Event of the log. Times are on the engine's clock, in nanoseconds; source numbers are the writer's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// Fusion begins, from the configuration.
    Begin {
        /// Epoch of fusion.
        epoch: u64,
    },
    /// A report is finished.
    Report {
        /// Source of the report.
        source: u16,
        /// Epoch of the publisher.
        publisher: u64,
        /// Number among the publisher's samples, modulo 2^32.
        sequence: u32,
        /// Whether fusion rejects the time of the report.
        is_wild: bool,
        /// Time up to which time has passed.
        passed_ns: i64,
    },
    /// A report is in quarantine and has no effect.
    Quarantine {
        /// Source of the report.
        source: u16,
        /// Epoch of the publisher.
        publisher: u64,
        /// Number among the publisher's samples, modulo 2^32.
        sequence: u32,
        /// Time of the engine.
        passed_ns: i64,
    },
    /// Time has passed without a report.
    Time {
        /// Time up to which time has passed.
        passed_ns: i64,
    },
    /// A condition (weather) holds from now on. Former builds wrote the event in place of an order.
    Condition {
        /// Number of the condition.
        condition: u32,
        /// Time up to which time has passed.
        passed_ns: i64,
    },
    /// An order takes effect.
    Order {
        /// The order.
        order: Order,
        /// Time up to which time has passed.
        passed_ns: i64,
    },
    /// The engine resumes from the published checkpoint of the previous fusion.
    Restored,
    /// A new range of track numbers begins.
    Numbers {
        /// Number of the next new system track.
        first: u32,
    },
    /// A snapshot of the engine is published.
    Snapshot {
        /// Time that identifies the snapshot.
        time_ns: i64,
    },
    /// The lead of the sources' time over the engine's time changes.
    HostOffset {
        /// The lead.
        offset_ns: i64,
    },
    /// The clock offset of a source changes.
    SourceClock {
        /// The source.
        source: u16,
        /// Offset in milliseconds; `None` if unknown.
        offset_ms: Option<i32>,
        /// Time of the engine.
        passed_ns: i64,
    },
}

/// Storage of steps.
pub trait EventLog {
    /// Appends a step.
    fn write(&mut self, step: &WorkStep);
}

/// No storage.
impl EventLog for () {
    fn write(&mut self, _: &WorkStep) {}
}

/// Unreadable step: the kind belongs to a later version, or preceding steps are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnreadableStep;

/// Writer of events. The log names a publisher once, before the first of its reports.
#[derive(Debug)]
pub(crate) struct EventWriter<L> {
    log: L,
    /// Latest publisher of each source.
    publishers: Vec<Option<u64>>,
}

impl<L: EventLog> EventWriter<L> {
    /// Creates the writer for a number of sources.
    pub(crate) fn new(log: L, sources: usize) -> Self {
        Self {
            log,
            publishers: vec![None; sources],
        }
    }

    #[cfg(test)]
    pub(crate) fn storage(&self) -> &L {
        &self.log
    }

    #[inline]
    pub(crate) fn write(&mut self, event: &Event) {
        match event {
            Event::Report { source, publisher, .. } | Event::Quarantine { source, publisher, .. } => {
                self.name_publisher(*source, *publisher);
            }
            Event::Order { order, passed_ns } => return self.write_order(order, *passed_ns),
            // A replay may begin here, without the steps before.
            Event::Snapshot { .. } => self.publishers.fill(None),
            _ => {}
        }
        self.log.write(&event.step());
    }

    #[inline]
    fn name_publisher(&mut self, source: u16, publisher: u64) {
        let Some(latest) = self.publishers.get_mut(usize::from(source)) else {
            return;
        };
        if *latest != Some(publisher) {
            *latest = Some(publisher);
            self.log
                .write(&step(StepKind::Publisher, source, 0, publisher.cast_signed()));
        }
    }

    #[cold]
    fn write_order(&mut self, order: &Order, passed_ns: i64) {
        for step in order.steps(passed_ns) {
            self.log.write(&step);
        }
    }
}

impl Event {
    /// Returns the step of the event; an order has further steps before this step.
    #[inline]
    fn step(&self) -> WorkStep {
        match *self {
            Self::Begin { epoch } => step(StepKind::Begin, NO_SOURCE, 0, epoch.cast_signed()),
            Self::Report {
                source,
                sequence,
                is_wild,
                passed_ns,
                ..
            } => WorkStep {
                flags: u8::from(is_wild) * work_step_bits::WILD_CLOCK,
                ..step(StepKind::Report, source, sequence, passed_ns)
            },
            Self::Quarantine {
                source,
                sequence,
                passed_ns,
                ..
            } => step(StepKind::Quarantine, source, sequence, passed_ns),
            Self::Time { passed_ns } => step(StepKind::Time, NO_SOURCE, 0, passed_ns),
            Self::Condition { condition, passed_ns } => step(StepKind::Condition, NO_SOURCE, condition, passed_ns),
            Self::Order { passed_ns, .. } => step(StepKind::Order, NO_SOURCE, messages::ORDER_WORDS as u32, passed_ns),
            Self::Restored => step(StepKind::Restored, NO_SOURCE, 0, 0),
            Self::Numbers { first } => step(StepKind::Numbers, NO_SOURCE, first, 0),
            Self::Snapshot { time_ns } => step(StepKind::Image, NO_SOURCE, 0, time_ns),
            Self::HostOffset { offset_ns } => step(StepKind::HostOffset, NO_SOURCE, 0, offset_ns),
            Self::SourceClock {
                source,
                offset_ms,
                passed_ns,
            } => {
                let offset_ms = offset_ms.unwrap_or(WorkStep::CLOCK_UNKNOWN);
                step(StepKind::SourceClock, source, offset_ms.cast_unsigned(), passed_ns)
            }
        }
    }

    /// Returns the time up to which time has passed with the event, if the event lets time pass.
    pub fn passed_ns(&self) -> Option<i64> {
        match *self {
            Self::Report { passed_ns, .. }
            | Self::Time { passed_ns }
            | Self::Condition { passed_ns, .. }
            | Self::Order { passed_ns, .. } => Some(passed_ns),
            _ => None,
        }
    }
}

/// Reader of a log, step by step.
#[derive(Clone, Debug, Default)]
pub struct EventReader {
    /// Latest publisher of each source, as far as named in the log.
    publishers: Vec<u64>,
    /// Parts of the next order.
    order_parts: Vec<WorkStep>,
}

impl EventReader {
    /// Returns the event that the step completes; `None` if further steps belong to the event.
    ///
    /// # Errors
    /// If the step is unreadable.
    pub fn read(&mut self, step: &WorkStep) -> Result<Option<Event>, UnreadableStep> {
        let WorkStep {
            time_ns: passed_ns,
            sequence,
            source,
            ..
        } = *step;
        let event = match StepKind::from_code(step.kind).ok_or(UnreadableStep)? {
            StepKind::Begin => Event::Begin {
                epoch: passed_ns.cast_unsigned(),
            },
            StepKind::Report => Event::Report {
                source,
                publisher: self.publisher(source),
                sequence,
                is_wild: step.flags & work_step_bits::WILD_CLOCK != 0,
                passed_ns,
            },
            StepKind::Quarantine => Event::Quarantine {
                source,
                publisher: self.publisher(source),
                sequence,
                passed_ns,
            },
            StepKind::Publisher => {
                let place = usize::from(source);
                self.publishers.resize(self.publishers.len().max(place + 1), 0);
                self.publishers[place] = passed_ns.cast_unsigned();
                return Ok(None);
            }
            StepKind::Time => Event::Time { passed_ns },
            StepKind::Condition => Event::Condition {
                condition: sequence,
                passed_ns,
            },
            StepKind::OrderPart => {
                if sequence == 0 {
                    self.order_parts.clear();
                }
                self.order_parts.push(*step);
                return Ok(None);
            }
            StepKind::Order => {
                let order = Order::of_parts(&std::mem::take(&mut self.order_parts)).ok_or(UnreadableStep)?;
                Event::Order { order, passed_ns }
            }
            StepKind::Restored => Event::Restored,
            StepKind::Numbers => Event::Numbers { first: sequence },
            StepKind::Image => Event::Snapshot { time_ns: passed_ns },
            StepKind::HostOffset => Event::HostOffset { offset_ns: passed_ns },
            StepKind::SourceClock => Event::SourceClock {
                source,
                offset_ms: step.clock_offset_ms(),
                passed_ns,
            },
        };
        Ok(Some(event))
    }

    fn publisher(&self, source: u16) -> u64 {
        self.publishers.get(usize::from(source)).copied().unwrap_or(0)
    }
}

#[inline]
fn step(kind: StepKind, source: u16, sequence: u32, time_ns: i64) -> WorkStep {
    WorkStep {
        time_ns,
        sequence,
        source,
        kind: kind as u8,
        flags: 0,
    }
}
