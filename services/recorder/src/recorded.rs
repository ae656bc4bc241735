//! Registry of recorded streams: one line per kind of topic.
//!
//! A row depends only on a sample and on the configured number of its source. The topic identifies the source; the
//! source stated in a sample may be wrong.

use std::fmt::Debug;
use std::io;

use alarms::AlarmKind;
use bus::Payload;
use formats::alarms_csv::AlarmRow;
use formats::alerts_csv::AlertRow;
use formats::cues_csv::CueRow;
use formats::rows::{Row, RowWriter};
use formats::scan_rows_csv::{EmptyScan, RepliedScanRow, ScanRow};
use formats::tracks_csv::PlacedTrack;
use frames::SystemFrame;
use messages::{
    Alarm, AlarmEvent, Alert, Cue, Decision, OrderState, PlatformState, SensorArrival, SensorBearing, SensorDetection,
    SensorFix, SensorTrack, Stream, Streamed, SystemTrack, TargetStatement, WideArea,
};
use observations::{Arrival, Bearing, ReadyFix, Sampled as _, SensorEvent, WideAreaReport, sensor_id};

/// Sample with a row format.
pub(crate) trait RecordedSample: Streamed + Payload {
    type Row: Row + Debug + 'static;

    /// Returns the row of a sample of the source or sensor `number`, with positions in `frame`; `None` for a code
    /// of another schema.
    fn row(&self, number: u16, frame: &SystemFrame) -> Option<Self::Row>;

    /// Returns the number of the source or sensor as the sample states it; 0 for samples of fusion.
    fn stated_number(&self) -> u16 {
        0
    }
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
        Stream::Arrivals => task.of::<SensorArrival>("arrivals"),
        Stream::Fixes => task.of::<SensorFix>("fixes"),
        Stream::Statements => task.of::<TargetStatement>("statements"),
        Stream::PlatformStates => task.of::<PlatformState>("platform_states"),
        Stream::Cues => task.of::<Cue>("cues"),
        Stream::WideArea => task.of::<WideArea>("wide_area"),
        Stream::SystemTracks => task.of::<SystemTrack>("system_tracks"),
        Stream::Alarms => task.of::<Alarm>("alarms"),
        Stream::Alerts => task.of::<Alert>("alerts"),
        Stream::Decisions => task.of::<Decision>("decisions"),
        Stream::Orders => task.of::<OrderState>("orders"),
    }
}

/// Returns samples as the text of a table, with the columns of the recorder's tables; `None` if `sample` is not the
/// name of a recorded sample, or `octets` are no whole number of samples. Times count from `first_day_ns` (UTC,
/// nanoseconds).
pub fn table(sample: &str, octets: &[u8], frame: &SystemFrame, first_day_ns: i64) -> Option<String> {
    let named = |stream: &Stream| for_samples(*stream, NameOfSamples) == sample;
    let stream = Stream::ALL.into_iter().find(named)?;
    let task = TextOfSamples {
        octets,
        frame,
        first_day_ns,
    };
    for_samples(stream, task)
}

struct NameOfSamples;

impl ForSamples for NameOfSamples {
    type Done = &'static str;

    fn of<T: RecordedSample>(self, _: &str) -> &'static str {
        T::LAYOUT.name
    }
}

struct TextOfSamples<'a> {
    octets: &'a [u8],
    frame: &'a SystemFrame,
    first_day_ns: i64,
}

impl ForSamples for TextOfSamples<'_> {
    type Done = Option<String>;

    fn of<T: RecordedSample>(self, _: &str) -> Option<String> {
        let samples: Vec<T> = self
            .octets
            .chunks(T::LAYOUT.size)
            .map(T::of_octets)
            .collect::<Option<_>>()?;
        let write = || -> io::Result<Vec<u8>> {
            let mut writer = RowWriter::begin(Vec::new(), self.first_day_ns)?;
            for sample in &samples {
                if let Some(row) = sample.row(sample.stated_number(), self.frame) {
                    writer.write(&row)?;
                }
            }
            Ok(writer.into_inner())
        };
        String::from_utf8(write().ok()?).ok()
    }
}

impl RecordedSample for SensorTrack {
    type Row = Self;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<Self> {
        Some(Self { source, ..*self })
    }

    fn stated_number(&self) -> u16 {
        self.source
    }
}

impl RecordedSample for SensorDetection {
    type Row = RepliedScanRow;

    /// Of a sensor's marks, a scan without detections makes a row, so that the table gives the same tracks.
    fn row(&self, source: u16, _: &SystemFrame) -> Option<RepliedScanRow> {
        // A tracker process publishes the events of its sensors, whose numbers follow those of all sources.
        let source = source.max(self.source);
        let row = match SensorEvent::of_sample(&Self { source, ..*self })? {
            SensorEvent::Detection(detection) => ScanRow::Detection(detection),
            SensorEvent::EmptyScan { number, time_ns } => ScanRow::Empty(EmptyScan {
                sensor_id: sensor_id(source),
                scan: number,
                time_ns,
            }),
            SensorEvent::Passed(_) | SensorEvent::TurnBegins(_) | SensorEvent::Unplaced(_) => return None,
        };
        Some(RepliedScanRow(row))
    }

    fn stated_number(&self) -> u16 {
        self.source
    }
}

macro_rules! recorded_as_measured {
    ($($sample:ident: $value:ident;)*) => { $(
        impl RecordedSample for $sample {
            type Row = $value;

            fn row(&self, _: u16, _: &SystemFrame) -> Option<$value> {
                $value::of_sample(self)
            }

            fn stated_number(&self) -> u16 {
                self.source
            }
        }
    )* };
}

recorded_as_measured! {
    SensorBearing: Bearing;
    SensorArrival: Arrival;
    SensorFix: ReadyFix;
}

impl RecordedSample for TargetStatement {
    type Row = Self;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<Self> {
        Some(Self { source, ..*self })
    }

    fn stated_number(&self) -> u16 {
        self.source
    }
}

impl RecordedSample for PlatformState {
    type Row = Self;

    fn row(&self, source: u16, _: &SystemFrame) -> Option<Self> {
        Some(Self { source, ..*self })
    }

    fn stated_number(&self) -> u16 {
        self.source
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

    fn stated_number(&self) -> u16 {
        self.source
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

impl RecordedSample for Alert {
    type Row = AlertRow;

    /// An alert that stands as before makes no row.
    fn row(&self, _: u16, _: &SystemFrame) -> Option<AlertRow> {
        AlertRow::of(self)
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
