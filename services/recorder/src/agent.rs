//! Duty cycle of the recorder.

use std::time::Duration;

use bus::{Bus, Transport, WaitMode, Waiter};
use deployment::Deployment;
use messages::{BatchHeader, Counter, ProcessKind, Stream, StreamId};
use runtime::flow::ConsumerProgress;
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::images::Images;
use crate::intake::TopicIntake;
use crate::journal::Journal;
use crate::settings::Settings;
use crate::start::Start;

/// Maximum number of turns at the end for writing the slices still waiting.
const TURNS_AT_CLOSE: usize = 1000;
/// Longest wait for data, whose arrival ends it.
const IDLE: Duration = Duration::from_millis(200);

/// Recorder agent; generic over the transport, so that tests drive it in process.
#[derive(Debug)]
pub struct RecorderAgent<S: Transport> {
    intake: TopicIntake<S>,
    journal: Journal,
    /// Requester of snapshots, for a recording of all topics.
    images: Option<Images<S>>,
    waiter: Waiter<S>,
    /// Streams of the deployment, in their order, and whether each has ended.
    streams: Vec<(StreamId, bool)>,
    /// For recorded inputs: publishes the recorder's position in each stream, so that no sample is lost.
    reached: Option<ConsumerProgress<S>>,
}

impl<S: Transport> RecorderAgent<S> {
    /// Creates a recorder for the run `start` of `config`, connected to `bus`; `incarnation` is the process's
    /// monotonic start time. Files left by an earlier recorder of the same run are continued; files of another run
    /// are rejected.
    ///
    /// # Errors
    /// If a file cannot be made or a topic cannot be opened.
    pub fn new(
        (config, settings): (&Deployment, &Settings),
        bus: &Bus<S>,
        incarnation: u64,
        start: &Start<'_>,
    ) -> anyhow::Result<Self> {
        let containers = settings.containers();
        let mut waiter = bus.waiter(WaitMode::Event);
        let (intake, topics) = TopicIntake::open((config, containers.is_some()), bus, &mut waiter, incarnation)?;
        let journal = Journal::new((config, settings), start, topics, intake.since_ns())?;
        let images = containers.map(|settings| {
            let is_late = intake.is_late(config);
            Images::new(bus, &settings, incarnation, intake.caught_up_ns(), is_late)
        });
        let begins = config.recorded_streams().enumerate();
        let begins: Vec<_> = begins
            .map(|(place, (id, _))| (id, journal.account(place).next_sequence()))
            .collect();
        let reached = || ConsumerProgress::new(bus, incarnation, ProcessKind::Recorder, &begins);
        Ok(Self {
            images: images.transpose()?,
            streams: begins.iter().map(|(id, _)| (*id, false)).collect(),
            reached: config.is_recorded().then(reached).transpose()?,
            intake,
            journal,
            waiter,
        })
    }

    /// Writes the arrived slices; returns whether there were any.
    fn write_arrived(&mut self, now: Now) -> anyhow::Result<bool> {
        let Self {
            intake,
            journal,
            images,
            streams,
            reached,
            ..
        } = self;
        let mut done = |place: usize, header: &BatchHeader, next_sequence: u64| {
            if let Some(reached) = reached {
                reached.done(place, header, next_sequence);
            }
            streams[place].1 |= header.flags & BatchHeader::END != 0;
        };
        let worked = intake.take(journal, now, &mut done)?;
        journal.tend(now);
        if let Some(images) = images {
            images.tend(journal.lost(), journal.is_writing(), now)?;
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
            Turn::Idle(IDLE)
        })
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let intake = &self.intake;
        self.waiter.wait(at_most, || intake.has_slices())?;
        Ok(())
    }

    /// Appends an entry for the process, which covers the system tracks and the wide-area sensors (these are no
    /// sources), then one entry for each source.
    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let first = entries.len();
        entries.push(HealthEntry::default());
        let (failures, lost_rows) = self.journal.table_counts();
        let of_process = &mut entries[first];
        of_process.note = self.journal.cause().to_owned();
        of_process.counters.add(Counter::RecordingFailures, failures);
        of_process.counters.add(Counter::RecordedLost, lost_rows);
        if let Some(counts) = self.journal.segment_counts() {
            for (counter, count) in [
                (Counter::RecordedSamples, self.journal.samples()),
                (Counter::RecordedLost, self.journal.lost()),
                (Counter::RecordingFailures, counts.failures),
                (Counter::RecordingsDeleted, counts.deleted),
            ] {
                of_process.counters.add(counter, count);
            }
        }
        for (place, (id, _)) in self.streams.iter().enumerate() {
            let (account, subscriber) = (self.journal.account(place), self.intake.counts(place));
            if id.stream == Stream::SensorTracks {
                entries.push(HealthEntry {
                    source: id.number,
                    ..HealthEntry::default()
                });
            }
            let is_of_process = matches!(
                id.stream,
                Stream::SystemTracks
                    | Stream::WideArea
                    | Stream::Alarms
                    | Stream::Alerts
                    | Stream::Decisions
                    | Stream::Orders
            );
            let of = if is_of_process { first } else { entries.len() - 1 };
            let entry = &mut entries[of];
            let lost = match id.stream {
                Stream::WideArea => Counter::WideAreaLost,
                _ => Counter::Lost,
            };
            // Files of all topics have a count of their own, in which these samples are contained.
            if let Some(rows) = self.journal.rows(place) {
                entry.counters.add(lost, account.not_arrived(subscriber.lost));
                entry.counters.add(Counter::MissingRows, account.missing());
                entry.counters.add(Counter::RowsWritten, rows);
            }
            entry.counters.add(Counter::RejectedSchema, subscriber.schema_mismatch);
            if matches!(id.stream, Stream::SensorTracks | Stream::SystemTracks) {
                entry.counters.add(Counter::Taken, subscriber.taken);
            }
            if id.stream == Stream::SystemTracks {
                entry.progress_ns = account.progress_ns();
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
        self.journal.close(now)
    }
}
