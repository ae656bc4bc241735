//! Recorded tracker process: reads the sensors' files, and replays the tracks.
//!
//! Each file is in the order of recording. An event of a file comes when the file's latest time so far has come; the
//! events of all sensors are merged by these times. A detection that was recorded late thus comes late again.

use std::collections::VecDeque;
use std::path::Path;

use anyhow::Context as _;
use deployment::{Input, PlotFormat, Recorded, SampleDelivery, Source};
use formats::autoferry;
use formats::plane::Plane;
use formats::scan_rows_csv::ScanRowReader;
use frames::SystemFrame;
use messages::{Counter, Counters, ProcessKind, SensorDetection, SensorTrack, Stream, StreamId};
use observations::{Sampled, SensorEvent};
use runtime::Process;
use sources::{Pipeline, Samples, SourceReading};
use tracking::wide_area::arrivals::Arrivals;

use crate::Processed;
use crate::StatedReceiver;
use crate::beside::Beside;
use crate::content::RecordedContent;
use crate::intake::Intake;
use crate::plot_rows::event_of;
use crate::recorded_source::{AHEAD, counts};
use crate::replay::{Published, ReplayAgent, Replayed};

use super::on_board;

/// Recorded sensors and the tracker.
#[derive(Debug)]
pub(super) struct RecordedTracker {
    /// Place of the sensor, and the event, in the order of coming.
    events: VecDeque<(usize, SensorEvent)>,
    pipeline: Pipeline,
    samples: Samples,
    read: Counters,
    has_ended: bool,
    ready: VecDeque<SensorTrack>,
    next_track: u64,
    detections: Beside<SensorDetection>,
}

/// Creates the agent that replays the tracks of recorded sensors.
///
/// # Errors
/// If a recording cannot be read, or shared memory fails.
pub(super) fn replay(process: &Process, tracker: Processed<'_>) -> anyhow::Result<ReplayAgent<RecordedTracker>> {
    let (source, reading) = (tracker.source, tracker.reading());
    let first_day_ns = process.first_day_ns();
    let counts = counts(process, tracker)?;
    let pipeline = Pipeline::new(reading.model, &reading.processing, first_day_ns, counts)?;
    let mut recording = RecordedTracker {
        events: VecDeque::new(),
        pipeline,
        samples: Samples::default(),
        read: Counters::default(),
        has_ended: false,
        ready: VecDeque::with_capacity(2 * AHEAD),
        next_track: 0,
        detections: Beside::default(),
    };
    recording.read_all(process, tracker)?;
    recording.carry(process, tracker)?;
    recording.track_ahead();
    let published = |stream| StreamId {
        stream,
        number: source.number,
    };
    let tracks = Published {
        topic: &messages::sensor_tracks(&source.name),
        stream: published(Stream::SensorTracks),
        sensor_uid: Some(source.uid),
    };
    let detections = Published {
        topic: &messages::sensor_detections(&source.name),
        stream: published(Stream::Detections),
        sensor_uid: Some(source.uid),
    };
    ReplayAgent::new(
        process,
        recording,
        tracks.open(process, &[ProcessKind::Fusion])?,
        Some(detections.open(process, &[])?),
        None,
    )
}

impl RecordedTracker {
    /// Reads the files of all sensors.
    fn read_all(&mut self, process: &Process, tracker: Processed<'_>) -> anyhow::Result<()> {
        let (data, first_day_ns) = (&process.options.data, process.first_day_ns());
        let mut all = Vec::new();
        for (place, sensor) in process.config.sensors_of(tracker.source).iter().enumerate() {
            let reading = &tracker.readings.sources[usize::from(sensor.number)];
            let Input::Recorded(recorded) = &sensor.input else {
                anyhow::bail!("sensor {} has no recording", sensor.name);
            };
            let path = data.join(&recorded.file);
            let events = self.events_of((sensor, reading), recorded, &path, (first_day_ns, process.config.frame));
            let events =
                events.with_context(|| format!("reading {}, the recording of {}", path.display(), sensor.name))?;
            let mut come_ns = i64::MIN;
            all.extend(events.into_iter().map(|event| {
                come_ns = come_ns.max(event.time_ns());
                (come_ns, place, event)
            }));
        }
        all.sort_by_key(|(come_ns, place, _)| (*come_ns, *place));
        self.events = all.into_iter().map(|(_, place, event)| (place, event)).collect();
        Ok(())
    }

    /// Puts the detections of sensors on board into the system frame. All states are known before the first detection.
    fn carry(&mut self, process: &Process, tracker: Processed<'_>) -> anyhow::Result<()> {
        let mut all = Vec::new();
        for platform in on_board::platforms(process, tracker) {
            all.push(on_board::recorded_states(
                platform,
                &process.options.data,
                process.first_day_ns(),
            )?);
        }
        let states_max = all.iter().map(Vec::len).max().unwrap_or(0);
        let mut carrying = on_board::carrying(process, tracker, Some(states_max));
        for (place, states) in all.iter().enumerate() {
            states.iter().for_each(|state| carrying.state(place, state));
        }
        carrying.states_end();
        let events = std::mem::take(&mut self.events);
        let carried = &mut self.events;
        let mut out = |place, event, ()| carried.push_back((place, event));
        for (place, event) in events {
            carrying.take(place, event, (), &mut out);
        }
        Ok(())
    }

    fn events_of(
        &mut self,
        (sensor, reading): (&Source, &SourceReading),
        recorded: &Recorded,
        path: &Path,
        (first_day_ns, frame): (i64, SystemFrame),
    ) -> anyhow::Result<Vec<SensorEvent>> {
        let SampleDelivery::Plots { format, sensor_id } = sensor.delivers else {
            anyhow::bail!("it delivers no detections");
        };
        let bytes = std::fs::read(path)?;
        let is_own = |id: u32| sensor_id.is_none_or(|own| own == id);
        let mut events = Vec::new();
        match format {
            PlotFormat::Rows => {
                let mut rows = ScanRowReader::new(bytes.as_slice(), first_day_ns)?.placed_in(Plane::Given(frame));
                rows.set_sensor(sensor_id.unwrap_or(1));
                for row in rows {
                    self.read[Counter::Records] += 1;
                    match row {
                        Ok(row) => {
                            let (id, event) = event_of(row, |time_ns| time_ns);
                            events.extend(is_own(id).then_some(event));
                        }
                        Err(error) if error.is_of_row() => {
                            self.read[Counter::BlocksRejected] += 1;
                        }
                        Err(error) => return Err(error.into()),
                    }
                }
            }
            PlotFormat::Autoferry => {
                for scan in autoferry::read_detections(&bytes)? {
                    if !is_own(scan.sensor.id()) {
                        continue;
                    }
                    self.read[Counter::Records] += 1;
                    if scan.detections.is_empty() {
                        events.push(SensorEvent::EmptyScan {
                            number: scan.number,
                            time_ns: scan.time_of_measurement_ns,
                        });
                    }
                    events.extend(scan.detections.into_iter().map(SensorEvent::Detection));
                }
            }
            PlotFormat::Asterix => {
                let pipeline = Pipeline::new(reading.model, &reading.processing, first_day_ns, Arrivals::default())?;
                let mut intake = Intake::new(sensor.number, pipeline, 0);
                let place = (reading.model.system, StatedReceiver::default());
                let mut content = RecordedContent::open(bytes, recorded, place, first_day_ns)?;
                while !content.is_exhausted() {
                    content.read_piece(&mut intake);
                    events.extend(intake.detections().filter_map(|sample| SensorEvent::of_sample(&sample)));
                }
                content.count(&mut self.read);
                // The converter's refusals; the tracker counts the taken observations.
                let mut converted = intake.counters();
                for counter in [Counter::Reports, Counter::Detections] {
                    converted[counter] = 0;
                }
                self.read += &converted;
            }
        }
        Ok(events)
    }

    /// Gives events to the tracker until tracks are ahead of the replay.
    fn track_ahead(&mut self) {
        while self.ready.len() < AHEAD && !self.has_ended {
            match self.events.pop_front() {
                Some((place, event)) => self.pipeline.event(place, &event, 0, &mut self.samples),
                None => {
                    self.pipeline.end(&mut self.samples);
                    self.has_ended = true;
                }
            }
            for detection in self.samples.detections.drain(..) {
                self.detections.push(detection.time_of_measurement_ns, detection);
            }
            for mut track in self.samples.tracks.drain(..) {
                track.sequence = self.next_track;
                self.next_track += 1;
                self.ready.push_back(track);
            }
            // The sensors of a recording look nowhere.
            self.samples.cues.clear();
        }
    }
}

impl Replayed for RecordedTracker {
    type Sample = SensorTrack;
    const WAITS_FOR: &'static str = "fusion and recorder";

    fn due_ns(&self, ahead: usize) -> Option<i64> {
        self.ready.get(ahead).map(|track| track.time_of_measurement_ns)
    }

    fn ahead(&self) -> usize {
        self.ready.len()
    }

    fn next(&mut self) -> Option<(u64, SensorTrack)> {
        let track = self.ready.pop_front()?;
        self.track_ahead();
        Some((track.sequence, track))
    }

    fn skip_to(&mut self, first_needed: u64) {
        while self.ready.front().is_some_and(|track| track.sequence < first_needed) {
            Replayed::next(self);
        }
    }

    fn detections(&mut self) -> Option<&mut Beside<SensorDetection>> {
        Some(&mut self.detections)
    }

    fn counters(&self) -> Counters {
        let mut counters = self.pipeline.counters();
        counters += &self.read;
        counters
    }
}
