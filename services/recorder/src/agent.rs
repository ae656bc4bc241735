//! The duty cycle of the recorder.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Subscriber, Transport, WaitMode, Waiter};
use configuration::Config;
use formats::detections_csv::DetectionWriter;
use formats::tracks_csv::{SensorTrackWriter, SystemTrackWriter};
use formats::wide_area_csv::WideAreaWriter;
use messages::{BatchHeader, Counter, ProcessKind, Stream, StreamId, SystemTrack};
use runtime::flow::Reached;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::recovery::{self, Opened};
use crate::topic_file::{SLICES_PER_TOPIC, TopicFile};

/// Turns in which what is still waiting is written at the end.
const TURNS_AT_CLOSE: usize = 1000;

/// The recorder as an agent; generic over the transport, so that tests drive it in process.
#[derive(Debug)]
pub struct RecorderAgent<S: Transport> {
    sources: Vec<TopicFile<S, SensorTrackWriter<BufWriter<File>>>>,
    /// Of the sources whose tracks are made of detections.
    detections: Vec<TopicFile<S, DetectionWriter<BufWriter<File>>>>,
    /// Of the wide-area sensors.
    counts: Vec<TopicFile<S, WideAreaWriter<BufWriter<File>>>>,
    system: SystemFile<S>,
    waiter: Waiter<S>,
    /// Recordings: says how far the recorder has got, so that nothing is lost.
    reached: Option<Reached<S>>,
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
        let (mut sources, mut detections, mut counts) = (Vec::new(), Vec::new(), Vec::new());
        for source in &config.sources {
            let (topic, number) = (messages::sensor_tracks(&source.name), source.number);
            let file = open(format!("sensor_tracks_{}.csv", source.name))?;
            let ground = (bus, &mut waiter);
            sources.push(TopicFile::open(
                ground,
                incarnation,
                &topic,
                number,
                file,
                first_day_ns,
            )?);
        }
        for source in config.sources.iter().filter(|source| source.tracker.is_some()) {
            let (topic, number) = (messages::sensor_detections(&source.name), source.number);
            let file = open(format!("detections_{}.csv", source.name))?;
            let ground = (bus, &mut waiter);
            detections.push(TopicFile::open(
                ground,
                incarnation,
                &topic,
                number,
                file,
                first_day_ns,
            )?);
        }
        for sensor in &config.wide_area_sensors {
            let (topic, number) = (messages::wide_area(&sensor.name), sensor.number);
            let file = open(format!("wide_area_{}.csv", sensor.name))?;
            let ground = (bus, &mut waiter);
            counts.push(TopicFile::open(
                ground,
                incarnation,
                &topic,
                number,
                file,
                first_day_ns,
            )?);
        }
        waiter.watch(bus, &messages::system_tracks())?;
        let stream = |stream| move |number| StreamId { stream, number };
        let of_sources = sources.iter().map(|file| file.number).map(stream(Stream::SensorTracks));
        let of_detections = detections
            .iter()
            .map(|file| file.number)
            .map(stream(Stream::Detections));
        let of_counts = counts.iter().map(|file| file.number).map(stream(Stream::WideArea));
        let topics = of_sources
            .chain([StreamId::SYSTEM_TRACKS])
            .chain(of_detections)
            .chain(of_counts);
        let topics: Vec<_> = topics.collect();
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
        whole.set(Counter::RejectedSchema, system.schema_mismatch + refused);
        let rows: u64 = self.counts.iter().map(|file| file.rows).sum();
        whole.set(Counter::RowsWritten, self.system.rows + rows);
        entries.push(whole);
        for source in &self.sources {
            let counts = source.subscriber.counts();
            let mut entry = HealthEntry {
                source: source.number,
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
            let detections = self.detections.iter().find(|file| file.number == source.number);
            let lost = detections.map_or(0, |file| file.subscriber.counts().lost);
            entry.set(Counter::Lost, entry.counters[Counter::Lost] + lost);
            entry.set(Counter::RejectedSchema, counts.schema_mismatch);
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
        self.sources.iter_mut().try_for_each(TopicFile::flush)?;
        self.detections.iter_mut().try_for_each(TopicFile::flush)?;
        self.counts.iter_mut().try_for_each(TopicFile::flush)?;
        self.system.writer.flush().context("writing system tracks")
    }
}
