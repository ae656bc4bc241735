//! The engine's time and the sources' time.
//!
//! The engine's time follows a clock without adjustments. If the times of all sources have the same offset, the
//! machine's clock is wrong (or all sources' clocks): this *host offset* is subtracted from the times of reports, and
//! added to the times of all output. The offset may change while tracks live, without effect on tracks.

use messages::{Decision, OrderState, SensorTrack, SystemTrack};
use serde::{Deserialize, Serialize};

use crate::explanation::Sink;
use crate::update::filter_input::FilterInput;

/// Host offset: sources' time less engine's time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct HostClock {
    pub(crate) offset_ns: i64,
}

impl HostClock {
    /// The report in the engine's time; `None` if unchanged.
    #[inline]
    pub(crate) fn inward(self, report: &SensorTrack) -> Option<SensorTrack> {
        (self.offset_ns != 0).then(|| SensorTrack {
            time_of_measurement_ns: report.time_of_measurement_ns.saturating_sub(self.offset_ns),
            ..*report
        })
    }

    /// A path to `sink` with conversion of all times to the sources' time.
    pub(crate) fn outward<S>(self, sink: &mut S) -> Outward<'_, S> {
        Outward { sink, clock: self }
    }

    #[cold]
    fn in_source_time(self, track: &SystemTrack) -> SystemTrack {
        let mut track = *track;
        let later = |time_ns: &mut i64| *time_ns = time_ns.saturating_add(self.offset_ns);
        later(&mut track.reference_time_ns);
        later(&mut track.time_of_measurement_ns);
        let listed = usize::from(track.contribution_count).min(track.contributions.len());
        for part in &mut track.contributions[..listed] {
            later(&mut part.time_of_measurement_ns);
        }
        track
    }
}

/// Sink with conversion of the engine's time to the sources' time.
#[derive(Debug)]
pub(crate) struct Outward<'a, S> {
    sink: &'a mut S,
    clock: HostClock,
}

impl<S: Sink> Sink for Outward<'_, S> {
    fn track(&mut self, track: &SystemTrack) {
        match self.clock.offset_ns {
            0 => self.sink.track(track),
            _ => self.sink.track(&self.clock.in_source_time(track)),
        }
    }

    fn own_track(&mut self, track: &SystemTrack) {
        match self.clock.offset_ns {
            0 => self.sink.own_track(track),
            _ => self.sink.own_track(&self.clock.in_source_time(track)),
        }
    }

    fn order(&mut self, state: &OrderState) {
        self.sink.order(state);
    }

    fn decision(&mut self, decision: &Decision) {
        self.sink.decision(&Decision {
            time_ns: decision.time_ns.saturating_add(self.clock.offset_ns),
            ..*decision
        });
    }

    fn follows_inputs(&self) -> bool {
        self.sink.follows_inputs()
    }

    fn input(&mut self, input: &FilterInput) {
        self.sink.input(&FilterInput {
            time_ns: input.time_ns.saturating_add(self.clock.offset_ns),
            ..*input
        });
    }
}
