//! Registry of recorded streams: one line per kind of topic.
//!
//! A row depends only on a sample and on the configured number of its source. The topic identifies the source; the
//! source stated in a sample may be wrong.

use std::fmt::Debug;

use alarms::AlarmKind;
use bus::Payload;
use formats::alarms_csv::AlarmRow;
use formats::cues_csv::CueRow;
use formats::detections_csv::RepliedDetection;
use formats::rows::Row;
use formats::tracks_csv::PlacedTrack;
use frames::SystemFrame;
use messages::{
    Alarm, AlarmEvent, Cue, Decision, OrderState, PlatformState, SensorBearing, SensorDetection, SensorTrack, Stream,
    Streamed, SystemTrack, WideArea,
};
use observations::{Bearing, Detection, Sampled as _, WideAreaReport, sensor_id};

/// Sample with a row format.
pub(crate) trait RecordedSample: Streamed + Payload {
    type Row: Row + Debug + 'static;

    /// Returns the row of a sample of the source or sensor `number`, with positions in `frame`; `None` for a code
    /// of another schema.
    fn row(&self, number: u16, frame: &SystemFrame) -> Option<Self::Row>;
}

/// Task applicable to the samples of every stream.
pub(crate) trait ForSamples {
    type Done;

    /// Executes the task for samples `T`, whose file names begin with `stem`.
    fn of<T: RecordedSample>(self, stem: &str) -> Self::Done;
}

/// Executes `task` for the samples of a stream.
pub(crate) fn for_samples<F: ForSamples>(stream: Stream, task: F) -> F::Done {
    match stream {
        Stream::SensorTracks => task.of::<SensorTrack>("sensor_tracks"),
        Stream::Detections => task.of::<SensorDetection>("detections"),
        Stream::Bearings => task.of::<SensorBearing>("bearings"),
        Stream::PlatformStates => task.of::<PlatformState>("platform_states"),
        Stream::Cues => task.of::<Cue>("cues"),
        Stream::WideArea => task.of::<WideArea>("wide_area"),
        Stream::SystemTracks => task.of::<SystemTrack>("system_tracks"),
        Stream::Alarms => task.of::<Alarm>("alarms"),
        Stream::Decisions => task.of::<Decision>("decisions"),
        Stream::Orders => task.of::<OrderState>("orders"),
    }
}

impl RecordedSample for SensorTrack {
    type Row = Self;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<Self> {
        Some(Self { source, ..*self })
    }
}

impl RecordedSample for SensorDetection {
    type Row = RepliedDetection;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<RepliedDetection> {
        // A tracker process publishes the events of its sensors, whose numbers follow those of all sources.
        let source = source.max(self.source);
        Detection::of_sample(&Self { source, ..*self }).map(RepliedDetection)
    }
}

impl RecordedSample for SensorBearing {
    type Row = Bearing;

    fn row(&self, _: u16, _: &SystemFrame) -> Option<Bearing> {
        Bearing::of_sample(self)
    }
}

impl RecordedSample for PlatformState {
    type Row = Self;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<Self> {
        Some(Self { source, ..*self })
    }
}

impl RecordedSample for Cue {
    type Row = CueRow;

    fn row(&self, _: u16, _: &SystemFrame) -> Option<CueRow> {
        Some(CueRow {
            // Of several sensors of a tracker, the one that is to look.
            sensor_id: sensor_id(self.source),
            cue: *self,
        })
    }
}

impl RecordedSample for WideArea {
    type Row = WideAreaReport;

    fn row(&self, _: u16, _: &SystemFrame) -> Option<WideAreaReport> {
        WideAreaReport::of_sample(self)
    }
}

impl RecordedSample for Decision {
    type Row = Self;

    fn row(&self, _: u16, _: &SystemFrame) -> Option<Self> {
        self.kind().map(|_| *self)
    }
}

impl RecordedSample for OrderState {
    type Row = Self;

    /// A repeated state makes no row.
    fn row(&self, _: u16, _: &SystemFrame) -> Option<Self> {
        (self.has_changed != 0).then_some(*self)
    }
}

impl RecordedSample for SystemTrack {
    type Row = PlacedTrack;

    fn row(&self, _: u16, frame: &SystemFrame) -> Option<PlacedTrack> {
        Some(PlacedTrack::new(self, frame))
    }
}

impl RecordedSample for Alarm {
    type Row = AlarmRow;

    /// A repeated standing alarm makes no row.
    fn row(&self, _: u16, _: &SystemFrame) -> Option<AlarmRow> {
        let kind = AlarmKind::from_code(self.code)?;
        let event = self.event().filter(|event| *event != AlarmEvent::Standing)?;
        Some(AlarmRow {
            word: kind.word(),
            event,
            alarm: *self,
        })
    }
}
