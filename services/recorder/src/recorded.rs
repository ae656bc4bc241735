//! Registry of what is recorded: one line per kind of topic.
//!
//! A row of a file is made of a sample alone and of the number under which the configuration knows its source: what a
//! sample says of its own source need not be true, its topic is.

use std::fmt::Debug;

use alarms::AlarmKind;
use bus::Payload;
use formats::alarms_csv::AlarmRow;
use formats::cues_csv::CueRow;
use formats::rows::Row;
use formats::tracks_csv::PlacedTrack;
use frames::SystemFrame;
use messages::{
    Alarm, AlarmEvent, Cue, Decision, PlatformState, SensorBearing, SensorDetection, SensorTrack, Stream, Streamed,
    SystemTrack, WideArea,
};
use observations::{Bearing, Detection, Sampled as _, WideAreaReport, sensor_id};

/// A sample of which rows are made.
pub(crate) trait Recorded: Streamed + Payload {
    type Row: Row + Debug + 'static;

    /// Row of a sample of the source or sensor `number`, whose positions are in `frame`; `None` for a code of another
    /// schema.
    fn row(&self, number: u16, frame: &SystemFrame) -> Option<Self::Row>;
}

/// A task that is the same for the samples of every stream.
pub(crate) trait ForSamples {
    type Done;

    /// Does it for samples `T`, of which the name of a file begins with `stem`.
    fn of<T: Recorded>(self, stem: &str) -> Self::Done;
}

/// Does `task` for the samples of a stream.
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
    }
}

impl Recorded for SensorTrack {
    type Row = Self;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<Self> {
        Some(Self { source, ..*self })
    }
}

impl Recorded for SensorDetection {
    type Row = Detection;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<Detection> {
        Detection::of_sample(&Self { source, ..*self })
    }
}

impl Recorded for SensorBearing {
    type Row = Bearing;

    fn row(&self, _: u16, _: &SystemFrame) -> Option<Bearing> {
        Bearing::of_sample(self)
    }
}

impl Recorded for PlatformState {
    type Row = Self;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<Self> {
        Some(Self { source, ..*self })
    }
}

impl Recorded for Cue {
    type Row = CueRow;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<CueRow> {
        Some(CueRow {
            sensor_id: sensor_id(source),
            cue: *self,
        })
    }
}

impl Recorded for WideArea {
    type Row = WideAreaReport;

    fn row(&self, _: u16, _: &SystemFrame) -> Option<WideAreaReport> {
        WideAreaReport::of_sample(self)
    }
}

impl Recorded for Decision {
    type Row = Self;

    fn row(&self, _: u16, _: &SystemFrame) -> Option<Self> {
        self.kind().map(|_| *self)
    }
}

impl Recorded for SystemTrack {
    type Row = PlacedTrack;

    fn row(&self, _: u16, frame: &SystemFrame) -> Option<PlacedTrack> {
        Some(PlacedTrack::new(self, frame))
    }
}

impl Recorded for Alarm {
    type Row = AlarmRow;

    /// What only goes on standing makes no row.
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
