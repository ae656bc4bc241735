//! Duty cycle of the recorder.

use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Transport, WaitMode, Waiter};
use configuration::Config;
use messages::{BatchHeader, Counter, ProcessKind, Stream, StreamId};
use runtime::flow::Reached;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::all_topics::{AllTopics, Done};
use crate::recovery;
use crate::start::Start;
use crate::topic_file::{self, Place, StreamFile};

/// Maximum number of turns at the end for writing the slices still waiting.
const TURNS_AT_CLOSE: usize = 1000;

/// Recorder agent; generic over the transport, so that tests drive it in process.
#[derive(Debug)]
pub struct RecorderAgent<S: Transport> {
    files: Vec<Box<dyn StreamFile>>,
    all_topics: Option<AllTopics<S>>,
    waiter: Waiter<S>,
    /// Streams of the deployment, in their order, and whether each has ended.
    streams: Vec<(StreamId, bool)>,
    /// For recorded inputs: publishes the recorder's position in each stream, so that no sample is lost.
    reached: Option<Reached<S>>,
}

impl<S: Transport> RecorderAgent<S> {
    /// Creates a recorder for the run `start` of `config`, connected to `bus`; `incarnation` is the process's
    /// monotonic start time. Files left by an earlier recorder of the same run are continued; files of another run
    /// are rejected.
    ///
    /// # Errors
    /// If a file cannot be made or a topic cannot be opened.
    pub fn new(config: &Config, bus: &Bus<S>, incarnation: u64, start: &Start<'_>) -> anyhow::Result<Self> {
        let folder = start.folder;
        std::fs::create_dir_all(folder).with_context(|| format!("making the folder {}", folder.display()))?;
        let mut waiter = bus.waiter(WaitMode::Event);
        let csv = config.recording.csv;
        let all_topics = config.recording.mcap.map(|settings| {
            let waiter = (!csv).then_some(&mut waiter);
            AllTopics::new(config, settings, bus, waiter, incarnation, start)
        });
        let all_topics = all_topics.transpose()?;
        let mut place = Place {
            bus,
            waiter: &mut waiter,
            folder,
            resume: recovery::claim(folder, start.run)?,
            incarnation,
            first_day_ns: start.first_day_ns,
            frame: config.frame,
            replays: config.is_recorded(),
        };
        let streams: Vec<_> = config.streams().filter(|_| csv).collect();
        let open = |(id, name): &(StreamId, &str)| topic_file::open(&mut place, *id, name);
        let files = streams.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        let mut begins: Vec<_> = config.streams().map(|(id, _)| (id, 0)).collect();
        for ((_, begin), file) in begins.iter_mut().zip(&files) {
            *begin = file.next_sequence();
        }
        let reached = || Reached::new(bus, incarnation, ProcessKind::Recorder, &begins);
        Ok(Self {
            streams: begins.iter().map(|(id, _)| (*id, false)).collect(),
            files,
            all_topics,
            waiter,
            reached: config.is_recorded().then(reached).transpose()?,
        })
    }

    /// Writes the arrived slices; returns whether there were any.
    fn write_arrived(&mut self, now: Now) -> anyhow::Result<bool> {
        let Self {
            files,
            all_topics,
            streams,
            reached,
            ..
        } = self;
        let mut done = |index: usize, header: &BatchHeader, next_sequence: u64| {
            if let Some(reached) = reached {
                reached.done(index, header, next_sequence);
            }
            streams[index].1 |= header.flags & BatchHeader::END != 0;
        };
        let mut worked = false;
        if let Some(all_topics) = all_topics {
            // If rows are written, the position of the rows counts.
            let mut nothing = |_: usize, _: &BatchHeader, _: u64| {};
            let heard: &mut Done<'_> = if files.is_empty() { &mut done } else { &mut nothing };
            worked |= all_topics.turn(now, heard)?;
        }
        for (index, file) in files.iter_mut().enumerate() {
            worked |= file.write_arrived(&mut |header, next_sequence| done(index, header, next_sequence))?;
        }
        Ok(worked)
    }

    /// Whether all replayed streams and the resulting system tracks have ended.
    fn all_ended(&self) -> bool {
        let ends = |stream: Stream| stream.is_replayed() || stream == Stream::SystemTracks;
        let mut ending = self.streams.iter().filter(|(id, _)| ends(id.stream));
        ending.all(|(_, ended)| *ended)
    }
}

impl<S: Transport> Agent for RecorderAgent<S> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let worked = self.write_arrived(now)?;
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
        let (files, all_topics) = (&self.files, &self.all_topics);
        self.waiter.wait(at_most, || {
            files.iter().any(|file| file.has_slices()) || all_topics.as_ref().is_some_and(AllTopics::has_slices)
        })?;
        Ok(())
    }

    /// Appends an entry for the process, which covers the system tracks and the wide-area sensors (these are no
    /// sources), then one entry for each source.
    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let first = entries.len();
        entries.push(HealthEntry::default());
        if let Some(all_topics) = &self.all_topics {
            let counts = all_topics.counts();
            for (counter, count) in [
                (Counter::RecordedSamples, counts.samples),
                (Counter::RecordedLost, counts.lost),
                (Counter::RecordingFailures, counts.failures),
                (Counter::RecordingsDeleted, counts.deleted),
            ] {
                entries[first].counters.add(counter, count);
            }
        }
        if let (Some(all_topics), true) = (&self.all_topics, self.files.is_empty()) {
            for (place, (id, _)) in self.streams.iter().enumerate() {
                let taken = all_topics.taken(place);
                match id.stream {
                    Stream::SystemTracks => entries[first].set(Counter::Taken, taken),
                    Stream::SensorTracks => {
                        let mut entry = HealthEntry {
                            source: id.number,
                            ..HealthEntry::default()
                        };
                        entry.set(Counter::Taken, taken);
                        entries.push(entry);
                    }
                    _ => {}
                }
            }
        }
        for file in &self.files {
            let (id, counts) = (file.id(), file.counts());
            if id.stream == Stream::SensorTracks {
                entries.push(HealthEntry {
                    source: id.number,
                    ..HealthEntry::default()
                });
            }
            let is_of_process = matches!(
                id.stream,
                Stream::SystemTracks | Stream::WideArea | Stream::Alarms | Stream::Decisions | Stream::Orders
            );
            let place = if is_of_process { first } else { entries.len() - 1 };
            let entry = &mut entries[place];
            let lost = match id.stream {
                Stream::WideArea => Counter::WideAreaLost,
                _ => Counter::Lost,
            };
            entry.counters.add(lost, counts.lost);
            entry.counters.add(Counter::MissingRows, counts.missing);
            entry.counters.add(Counter::RowsWritten, counts.rows);
            entry
                .counters
                .add(Counter::RejectedSchema, counts.subscriber.schema_mismatch);
            if matches!(id.stream, Stream::SensorTracks | Stream::SystemTracks) {
                entry.counters.add(Counter::Taken, counts.subscriber.taken);
            }
            if id.stream == Stream::SystemTracks {
                entry.progress_ns = counts.progress_ns;
            }
        }
    }

    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        // Bounded, in case a publisher continues.
        for _ in 0..TURNS_AT_CLOSE {
            if !self.write_arrived(now)? {
                break;
            }
        }
        self.all_topics.as_mut().map_or(Ok(()), |topics| topics.close(now))
    }
}
