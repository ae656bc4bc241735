//! The duty cycle of the recorder.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Subscriber, Transport, WaitMode, Waiter};
use formats::detection::Detection;
use formats::detections_csv::DetectionWriter;
use formats::tracks_csv::{SensorTrackWriter, SystemTrackWriter};
use formats::wide_area::{WideAreaReport, WideAreaWriter};
use messages::{BatchHeader, Counter, NO_SOURCE, ProcessKind, SensorDetection, SensorTrack, SystemTrack, WideArea};
use runtime::config::Config;
use runtime::flow::Reached;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::recovery::{self, Opened};

/// Slices taken from one topic before the next one's turn.
const SLICES_PER_TOPIC: usize = 64;

/// Turns in which what is still waiting is written at the end.
const TURNS_AT_CLOSE: usize = 1000;

/// The recorder as an agent; generic over the transport, so that tests drive it in process.
#[derive(Debug)]
pub struct RecorderAgent<S: Transport> {
    sources: Vec<SourceFile<S>>,
    /// Of the sources whose tracks are made of detections.
    detections: Vec<DetectionFile<S>>,
    /// Of the wide-area sensors.
    counts: Vec<CountFile<S>>,
    system: SystemFile<S>,
    waiter: Waiter<S>,
    /// Recordings: says how far the recorder has got, so that nothing is lost.
    reached: Option<Reached<S>>,
}

#[derive(Debug)]
struct SourceFile<S: Transport> {
    source: u16,
    subscriber: Subscriber<S, SensorTrack>,
    writer: SensorTrackWriter<BufWriter<File>>,
    /// Reports of a recording are numbered: those below this have been written, whoever publishes them again.
    next_sequence: u64,
    /// Reports of a recording that were published but are in no row: a recorder died with them.
    missed: u64,
    rows: u64,
    ended: bool,
}

#[derive(Debug)]
struct DetectionFile<S: Transport> {
    source: u16,
    subscriber: Subscriber<S, SensorDetection>,
    writer: DetectionWriter<BufWriter<File>>,
    /// As of sensor tracks.
    next_sequence: u64,
    rows: u64,
    ended: bool,
}

#[derive(Debug)]
struct CountFile<S: Transport> {
    sensor: u16,
    subscriber: Subscriber<S, WideArea>,
    writer: WideAreaWriter<BufWriter<File>>,
    /// As of sensor tracks.
    next_sequence: u64,
    rows: u64,
    ended: bool,
}

#[derive(Debug)]
struct SystemFile<S: Transport> {
    subscriber: Subscriber<S, SystemTrack>,
    writer: SystemTrackWriter<BufWriter<File>>,
    rows: u64,
    progress_ns: i64,
    ended: bool,
}

impl<S: Transport> RecorderAgent<S> {
    /// A recorder of `config` into `folder`, connected to `bus`; `incarnation` is the process's monotonic start time, and
    /// files count their seconds from `first_day_ns` (UTC, nanoseconds). Files that an
    /// earlier recorder has left are continued if they are of the run described by `run`, else replaced.
    ///
    /// # Errors
    /// If a file cannot be made or a topic cannot be opened.
    pub fn new(
        config: &Config,
        bus: &Bus<S>,
        incarnation: u64,
        folder: &Path,
        first_day_ns: i64,
        run: &str,
    ) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("making the folder {}", folder.display()))?;
        let resume = recovery::claim(folder, run)?;
        let open = |name: String| recovery::open(&folder.join(name), resume);
        let mut waiter = bus.waiter(WaitMode::Event);
        let mut sources = Vec::new();
        for source in &config.sources {
            let topic = messages::sensor_tracks(&source.name);
            waiter.watch(bus, &topic)?;
            let Opened { file, rows } = open(format!("sensor_tracks_{}.csv", source.name))?;
            let file = BufWriter::new(file);
            sources.push(SourceFile {
                source: source.number,
                subscriber: bus.subscriber(&topic, || incarnation)?,
                writer: match rows {
                    0 => SensorTrackWriter::begin(file, first_day_ns)?,
                    _ => SensorTrackWriter::resume(file, first_day_ns),
                },
                // A recording's reports are numbered from 0, and each is one row.
                next_sequence: rows,
                missed: 0,
                rows: 0,
                ended: false,
            });
        }
        let mut detections = Vec::new();
        for source in config.sources.iter().filter(|source| source.tracker.is_some()) {
            let topic = messages::sensor_detections(&source.name);
            waiter.watch(bus, &topic)?;
            let Opened { file, rows } = open(format!("detections_{}.csv", source.name))?;
            let file = BufWriter::new(file);
            detections.push(DetectionFile {
                source: source.number,
                subscriber: bus.subscriber(&topic, || incarnation)?,
                writer: match rows {
                    0 => DetectionWriter::begin(file, first_day_ns)?,
                    _ => DetectionWriter::resume(file, first_day_ns),
                },
                next_sequence: rows,
                rows: 0,
                ended: false,
            });
        }
        let mut counts = Vec::new();
        for sensor in &config.wide_area_sensors {
            let topic = messages::wide_area(&sensor.name);
            waiter.watch(bus, &topic)?;
            let Opened { file, rows } = open(format!("wide_area_{}.csv", sensor.name))?;
            let file = BufWriter::new(file);
            counts.push(CountFile {
                sensor: sensor.number,
                subscriber: bus.subscriber(&topic, || incarnation)?,
                writer: match rows {
                    0 => WideAreaWriter::begin(file, first_day_ns)?,
                    _ => WideAreaWriter::resume(file, first_day_ns),
                },
                next_sequence: rows,
                rows: 0,
                ended: false,
            });
        }
        waiter.watch(bus, &messages::system_tracks())?;
        let of_sources = sources.iter().map(|source| source.source);
        let of_detections = detections.iter().map(|file| messages::detections_number(file.source));
        let of_counts = counts.iter().map(|file| messages::wide_area_number(file.sensor));
        let topics = of_sources.chain([NO_SOURCE]).chain(of_detections).chain(of_counts);
        let topics: Vec<u16> = topics.collect();
        let reached = || Reached::new(bus, incarnation, ProcessKind::Recorder, &topics);
        let Opened { file, rows } = open("system_tracks.csv".to_owned())?;
        let file = BufWriter::new(file);
        Ok(Self {
            sources,
            detections,
            counts,
            system: SystemFile {
                subscriber: bus.subscriber(&messages::system_tracks(), || incarnation)?,
                writer: match rows {
                    0 => SystemTrackWriter::begin(file, first_day_ns)?,
                    _ => SystemTrackWriter::resume(file, first_day_ns),
                },
                rows: 0,
                progress_ns: i64::MIN,
                ended: false,
            },
            waiter,
            reached: config.is_recorded().then(reached).transpose()?,
        })
    }

    /// Writes what has arrived; whether there was anything.
    fn write_arrived(&mut self) -> anyhow::Result<bool> {
        let mut worked = false;
        let recorded = self.reached.is_some();
        for (index, source) in self.sources.iter_mut().enumerate() {
            worked |= source.write_arrived(recorded, |header, next| {
                if let Some(reached) = &mut self.reached {
                    reached.done(index, header, next);
                }
            })?;
        }
        for (file, index) in self.detections.iter_mut().zip(self.sources.len() + 1..) {
            worked |= file.write_arrived(recorded, |header, next| {
                if let Some(reached) = &mut self.reached {
                    reached.done(index, header, next);
                }
            })?;
        }
        let first = self.sources.len() + 1 + self.detections.len();
        for (file, index) in self.counts.iter_mut().zip(first..) {
            worked |= file.write_arrived(recorded, |header, next| {
                if let Some(reached) = &mut self.reached {
                    reached.done(index, header, next);
                }
            })?;
        }
        let index = self.sources.len();
        worked |= self.system.write_arrived(|header, next| {
            if let Some(reached) = &mut self.reached {
                reached.done(index, header, next);
            }
        })?;
        Ok(worked)
    }

    fn all_ended(&self) -> bool {
        self.system.ended
            && self.sources.iter().all(|source| source.ended)
            && self.detections.iter().all(|file| file.ended)
            && self.counts.iter().all(|file| file.ended)
    }
}

impl<S: Transport> SourceFile<S> {
    fn write_arrived(&mut self, recorded: bool, mut done: impl FnMut(&BatchHeader, u64)) -> anyhow::Result<bool> {
        let mut failed = Ok(());
        let (writer, next_sequence, rows, ended) = (
            &mut self.writer,
            &mut self.next_sequence,
            &mut self.rows,
            &mut self.ended,
        );
        let (source, missed) = (self.source, &mut self.missed);
        let taken = self.subscriber.take(SLICES_PER_TOPIC, |header, reports| {
            for report in reports {
                if recorded && report.sequence < *next_sequence {
                    continue;
                }
                *missed += if recorded { report.sequence - *next_sequence } else { 0 };
                *next_sequence = report.sequence + 1;
                *rows += 1;
                let report = SensorTrack { source, ..*report };
                failed = std::mem::replace(&mut failed, Ok(())).and_then(|()| writer.write(&report));
            }
            *ended |= header.flags & BatchHeader::END != 0;
            done(header, *next_sequence);
        })?;
        failed.context("writing sensor tracks")?;
        Ok(taken > 0)
    }
}

impl<S: Transport> DetectionFile<S> {
    fn write_arrived(&mut self, recorded: bool, mut done: impl FnMut(&BatchHeader, u64)) -> anyhow::Result<bool> {
        let mut failed = Ok(());
        let (writer, next_sequence, rows, ended) = (
            &mut self.writer,
            &mut self.next_sequence,
            &mut self.rows,
            &mut self.ended,
        );
        let source = self.source;
        let taken = self.subscriber.take(SLICES_PER_TOPIC, |header, samples| {
            for sample in samples {
                if recorded && sample.sequence < *next_sequence {
                    continue;
                }
                *next_sequence = sample.sequence + 1;
                let sample = SensorDetection { source, ..*sample };
                // A kind that is not known is of another schema, whose slices are not taken.
                if let Some(detection) = Detection::of_sample(&sample) {
                    *rows += 1;
                    failed = std::mem::replace(&mut failed, Ok(())).and_then(|()| writer.write(&detection));
                }
            }
            *ended |= header.flags & BatchHeader::END != 0;
            done(header, *next_sequence);
        })?;
        failed.context("writing detections")?;
        Ok(taken > 0)
    }
}

impl<S: Transport> CountFile<S> {
    fn write_arrived(&mut self, recorded: bool, mut done: impl FnMut(&BatchHeader, u64)) -> anyhow::Result<bool> {
        let mut failed = Ok(());
        let (writer, next_sequence, rows, ended) = (
            &mut self.writer,
            &mut self.next_sequence,
            &mut self.rows,
            &mut self.ended,
        );
        let taken = self.subscriber.take(SLICES_PER_TOPIC, |header, samples| {
            for sample in samples {
                if recorded && sample.sequence < *next_sequence {
                    continue;
                }
                *next_sequence = sample.sequence + 1;
                *rows += 1;
                let report = WideAreaReport::of_sample(sample);
                failed = std::mem::replace(&mut failed, Ok(())).and_then(|()| writer.write(&report));
            }
            *ended |= header.flags & BatchHeader::END != 0;
            done(header, *next_sequence);
        })?;
        failed.context("writing wide-area reports")?;
        Ok(taken > 0)
    }
}

impl<S: Transport> SystemFile<S> {
    fn write_arrived(&mut self, mut done: impl FnMut(&BatchHeader, u64)) -> anyhow::Result<bool> {
        let mut failed = Ok(());
        let (writer, rows, progress_ns, ended) =
            (&mut self.writer, &mut self.rows, &mut self.progress_ns, &mut self.ended);
        let taken = self.subscriber.take(SLICES_PER_TOPIC, |header, tracks| {
            for track in tracks {
                *rows += 1;
                *progress_ns = (*progress_ns).max(track.reference_time_ns);
                failed = std::mem::replace(&mut failed, Ok(())).and_then(|()| writer.write(track));
            }
            *ended |= header.flags & BatchHeader::END != 0;
            done(header, header.first_sequence + tracks.len() as u64);
        })?;
        failed.context("writing system tracks")?;
        Ok(taken > 0)
    }
}

impl<S: Transport> Agent for RecorderAgent<S> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let worked = self.write_arrived()?;
        if let Some(reached) = &mut self.reached {
            reached.say(now)?;
        }
        if worked {
            return Ok(Turn::Worked);
        }
        Ok(if self.all_ended() {
            Turn::Finished
        } else {
            Turn::Idle(Duration::from_millis(20))
        })
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let (sources, detections, counts, system) = (&self.sources, &self.detections, &self.counts, &self.system);
        let has_work = || {
            system.subscriber.has_slices()
                || sources.iter().any(|source| source.subscriber.has_slices())
                || detections.iter().any(|file| file.subscriber.has_slices())
                || counts.iter().any(|file| file.subscriber.has_slices())
        };
        self.waiter.wait(at_most, has_work)?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut whole = HealthEntry {
            progress_ns: self.system.progress_ns,
            ..HealthEntry::default()
        };
        let system = self.system.subscriber.counts();
        whole.set(Counter::Taken, system.taken);
        whole.set(Counter::Lost, system.lost);
        // Wide-area sensors are no sources: what is said of their files is said here.
        let counts = self.counts.iter().map(|file| file.subscriber.counts());
        let (lost, refused) = counts.fold((0, 0), |(lost, refused), counts| {
            (lost + counts.lost, refused + counts.schema_mismatch)
        });
        whole.set(Counter::WideAreaLost, lost);
        whole.set(Counter::SchemaMismatch, system.schema_mismatch + refused);
        let rows: u64 = self.counts.iter().map(|file| file.rows).sum();
        whole.set(Counter::RowsWritten, self.system.rows + rows);
        entries.push(whole);
        for source in &self.sources {
            let counts = source.subscriber.counts();
            let mut entry = HealthEntry {
                source: source.source,
                ..HealthEntry::default()
            };
            entry.set(Counter::Taken, counts.taken);
            // The numbers of a recording's reports tell more than those of its slices: what a dead recorder had taken too.
            entry.set(
                Counter::Lost,
                if self.reached.is_some() {
                    source.missed
                } else {
                    counts.lost
                },
            );
            let of_source = |file: &&DetectionFile<S>| file.source == source.source;
            let detections = self.detections.iter().find(of_source);
            let lost = detections.map_or(0, |file| file.subscriber.counts().lost);
            entry.set(Counter::Lost, entry.counters[Counter::Lost as usize] + lost);
            entry.set(Counter::SchemaMismatch, counts.schema_mismatch);
            entry.set(
                Counter::RowsWritten,
                source.rows + detections.map_or(0, |file| file.rows),
            );
            entries.push(entry);
        }
    }

    fn close(&mut self, _now: Now) -> anyhow::Result<()> {
        // Bounded, in case somebody goes on publishing.
        for _ in 0..TURNS_AT_CLOSE {
            if !self.write_arrived()? {
                break;
            }
        }
        self.sources
            .iter_mut()
            .try_for_each(|source| source.writer.flush())
            .context("writing sensor tracks")?;
        self.detections
            .iter_mut()
            .try_for_each(|file| file.writer.flush())
            .context("writing detections")?;
        self.counts
            .iter_mut()
            .try_for_each(|file| file.writer.flush())
            .context("writing wide-area reports")?;
        self.system.writer.flush().context("writing system tracks")
    }
}
