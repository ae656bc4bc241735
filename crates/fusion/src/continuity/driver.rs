//! The driver: every call that changes an engine's state, beside the event of the log that stands for the call.
//!
//! Live fusion drives an engine with reports as they arrive and writes the log. A replay reads the events of a log and
//! drives an engine with the same methods. `koseki fuse` drives an engine with the rows of files. The same calls give
//! the same states, bit for bit.
//!
//! A step stands in the log before the effect of its event is published, since the sink only stores the effect.

use messages::{Counter, Decision, Order, OrderState, Refusal, SensorTrack, SystemTrack, sensor_track_bits};

use crate::continuity::checkpoint::{MemoryRefusal, Snapshot, SourcePosition};
use crate::continuity::event_log::{Event, EventLog, EventWriter};
use crate::engine::Engine;
use crate::explanation::Sink;
use crate::update::filter_input::FilterInput;

/// Engine with its event log.
#[derive(Debug)]
pub struct Driver<L> {
    engine: Engine,
    log: EventWriter<L>,
}

/// Number of a report at its publisher.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReportNumber {
    /// Epoch of the publisher.
    pub publisher: u64,
    /// Number among the publisher's samples; in order of time, the report's own number.
    pub sequence: u64,
    /// Whether fusion rejects the time of the report.
    pub is_wild: bool,
}

impl ReportNumber {
    /// Marks a report with a rejected time.
    #[inline]
    fn mark(self, report: &mut SensorTrack) {
        if self.is_wild {
            report.valid |= sensor_track_bits::WILD_CLOCK;
        }
    }
}

impl<L: EventLog> Driver<L> {
    /// Begins with a new engine, as `epoch`.
    pub fn begin(engine: Engine, log: L, epoch: u64) -> Self {
        let sources = engine.settings().sources.len();
        let mut driver = Self {
            engine,
            log: EventWriter::new(log, sources),
        };
        driver.log.write(&Event::Begin { epoch });
        driver
    }

    /// Returns the engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Returns the storage of the log.
    #[cfg(test)]
    pub(crate) fn log(&self) -> &L {
        self.log.storage()
    }

    /// Returns the engine at the end.
    pub fn into_engine(self) -> Engine {
        self.engine
    }

    /// Returns the engine for the counters and the checkpoint; no state depends on these.
    pub fn engine_mut(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// Processes a report received at `passed_ns`, up to which time passes; marks the report if its time is rejected.
    #[inline]
    pub fn report(&mut self, report: &mut SensorTrack, number: ReportNumber, passed_ns: i64, sink: &mut impl Sink) {
        number.mark(report);
        self.engine.take_at(report, passed_ns, &mut PassageSink::new(sink));
        // After the report: a successor repeats the report in which this process dies. Before the step: no report is
        // in the log twice.
        self.keep_position(report.source, number);
        self.log.write(&Event::Report {
            source: report.source,
            publisher: number.publisher,
            sequence: number.sequence as u32,
            is_wild: number.is_wild,
            passed_ns: self.engine.now_ns(),
        });
    }

    /// Processes a report of a time-ordered sequence. Time passes up to the time of the report.
    #[inline]
    pub fn report_in_order(&mut self, report: &mut SensorTrack, number: ReportNumber, sink: &mut impl Sink) {
        self.report(report, number, report.time_of_measurement_ns, sink);
    }

    /// Passes over a report, which has no effect except for a count; marks the report if its time is rejected.
    #[cold]
    pub fn quarantine(&mut self, report: &mut SensorTrack, number: ReportNumber) {
        number.mark(report);
        self.log.write(&Event::Quarantine {
            source: report.source,
            publisher: number.publisher,
            sequence: number.sequence as u32,
            passed_ns: self.engine.now_ns(),
        });
        self.keep_position(report.source, number);
        self.engine.counts_mut().add(report.source, Counter::Quarantined);
    }

    #[inline]
    fn keep_position(&mut self, source: u16, number: ReportNumber) {
        let position = SourcePosition {
            incarnation: number.publisher,
            next_sequence: number.sequence.wrapping_add(1),
        };
        self.engine.keep_position(source, position);
    }

    /// Lets time pass up to `until_ns`. The log has the event only if a state is published: otherwise the next event
    /// lets the same time pass.
    pub fn advance(&mut self, until_ns: i64, sink: &mut impl Sink) {
        let mut watched = PassageSink::new(sink);
        self.engine.advance(until_ns, &mut watched);
        if watched.has_state {
            let passed_ns = self.engine.now_ns();
            self.log.write(&Event::Time { passed_ns });
        }
    }

    /// Obeys an order when time has passed up to `passed_ns`.
    ///
    /// # Errors
    /// The reason of a refusal; the order is then not in the log.
    #[cold]
    pub fn order(&mut self, order: &Order, passed_ns: i64, sink: &mut impl Sink) -> Result<(), Refusal> {
        self.advance(passed_ns, sink);
        self.engine.examine(order)?;
        let event = Event::Order {
            order: *order,
            passed_ns,
        };
        self.log.write(&event);
        self.engine.obey(order, sink)
    }

    /// Sets the lead of the sources' time over the engine's time, nanoseconds.
    #[cold]
    pub fn set_host_offset(&mut self, offset_ns: i64) {
        self.log.write(&Event::HostOffset { offset_ns });
        self.engine.set_host_offset(offset_ns);
    }

    /// Sets the clock offset of `source`, milliseconds; `None` if unknown.
    #[cold]
    pub fn set_source_clock(&mut self, source: u16, offset_ms: Option<i32>) {
        self.log.write(&Event::SourceClock {
            source,
            offset_ms,
            passed_ns: self.engine.now_ns(),
        });
        let offset_s = offset_ms.map(|offset_ms| 1e-3 * f64::from(offset_ms));
        self.engine.set_source_clock(source, offset_s);
    }

    /// Resumes from the checkpoint of the previous fusion; see [`Engine::resume`].
    pub fn resume(&mut self, snapshot: &Snapshot, ends: bool, sink: &mut impl Sink) {
        self.log.write(&Event::Restored);
        self.engine.resume(snapshot, ends, sink);
    }

    /// Begins a new range of track numbers.
    pub fn start_numbers_at(&mut self, first: u32) {
        self.log.write(&Event::Numbers { first });
        self.engine.start_numbers_at(first);
    }

    /// Returns a snapshot of the engine, to be published with this time. Takes long and allocates.
    #[cold]
    pub fn snapshot(&mut self, time_ns: i64) -> Vec<u8> {
        let image = self.engine.image();
        self.log.write(&Event::Snapshot { time_ns });
        image
    }

    /// Resumes from the snapshot of another engine; see [`Engine::resume_image`]. The snapshot begins the log of a
    /// replay, so that no event stands for the call.
    ///
    /// # Errors
    /// If the snapshot belongs to other settings or to another build.
    pub fn resume_snapshot(&mut self, snapshot: &[u8]) -> Result<(), MemoryRefusal> {
        self.engine.resume_image(snapshot)
    }
}

/// Sink that notes whether a state of a track or of an order passes.
#[derive(Debug)]
struct PassageSink<'a, S> {
    sink: &'a mut S,
    has_state: bool,
}

impl<'a, S> PassageSink<'a, S> {
    fn new(sink: &'a mut S) -> Self {
        Self { sink, has_state: false }
    }
}

impl<S: Sink> Sink for PassageSink<'_, S> {
    #[inline]
    fn track(&mut self, track: &SystemTrack) {
        self.has_state = true;
        self.sink.track(track);
    }

    #[inline]
    fn own_track(&mut self, track: &SystemTrack) {
        self.sink.own_track(track);
    }

    fn order(&mut self, state: &OrderState) {
        self.has_state = true;
        self.sink.order(state);
    }

    #[inline]
    fn decision(&mut self, decision: &Decision) {
        self.sink.decision(decision);
    }

    #[inline]
    fn follows_inputs(&self) -> bool {
        self.sink.follows_inputs()
    }

    #[inline]
    fn input(&mut self, input: &FilterInput) {
        self.sink.input(input);
    }
}
