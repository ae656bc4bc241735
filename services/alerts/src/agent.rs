//! Duty cycle of the alerts process.

use std::time::Duration;

use alerts::AlertEngine;
use bus::{Bus, Mark, Publisher, Subscriber, Transport, WaitMode, Waiter};
use deployment::Deployment;
use messages::{AlarmEvent, Alert, Counter, SystemTrack};
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::memory::AlertMemory;

/// Most slices taken in one turn: the length of the queue.
const SLICES_PER_TURN: usize = 256;
/// Time between two publications without a change, nanoseconds.
const REPEAT_NS: i64 = 500_000_000;
/// Most changes in one slice, beside the alerts in force.
const CHANGES_MAX: usize = 64;

/// The process as an agent, generic over the transport: tests run it in process.
#[derive(Debug)]
pub(crate) struct AlertAgent<S: Transport> {
    engine: AlertEngine,
    memory: AlertMemory,
    tracks: Subscriber<S, SystemTrack>,
    publisher: Publisher<S, Alert>,
    waiter: Waiter<S>,
    changed: Vec<Alert>,
    due_ns: i64,
    /// Reference time of the newest state, UTC, nanoseconds.
    progress_ns: i64,
}

impl<S: Transport> AlertAgent<S> {
    /// With an engine that takes over the alerts left in `memory`; `incarnation` is the process's monotonic start
    /// time, nanoseconds.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(crate) fn new(
        (config, mut engine): (&Deployment, AlertEngine),
        mut memory: AlertMemory,
        bus: &Bus<S>,
        incarnation: u64,
    ) -> anyhow::Result<Self> {
        let (last, left) = memory.take_left();
        engine.resume(last, &left);
        let topic = config.system_tracks_topic();
        let mut waiter = bus.waiter(WaitMode::Event);
        waiter.watch(bus, &topic)?;
        Ok(Self {
            engine,
            memory,
            tracks: bus.subscriber(&topic, || incarnation)?,
            publisher: bus.publisher(&messages::alerts(), incarnation)?,
            waiter,
            changed: Vec::new(),
            due_ns: i64::MIN,
            progress_ns: i64::MIN,
        })
    }

    /// Publishes the alerts in force and the changes: what changed before is kept for a successor first.
    fn publish(&mut self, now: Now) -> anyhow::Result<()> {
        let (last, in_force) = (self.engine.last_number(), self.engine.in_force());
        self.memory.keep(last, in_force, now.mono_ns);
        loop {
            let rest = self.changed.split_off(self.changed.len().min(CHANGES_MAX));
            let changed = std::mem::replace(&mut self.changed, rest);
            let is_new = |alert: &Alert| {
                let raised = changed
                    .iter()
                    .filter(|change| change.event() == Some(AlarmEvent::Raised));
                raised.map(|change| change.number).any(|number| number == alert.number)
            };
            let standing = self
                .engine
                .in_force()
                .filter(|alert| !is_new(alert))
                .map(|alert| Alert {
                    event: AlarmEvent::Standing.code(),
                    ..*alert
                });
            let all: Vec<Alert> = standing.chain(changed.iter().copied()).collect();
            let mark = Mark {
                progress_ns: self.progress_ns,
                sent_ns: now.mono_ns,
                end: false,
            };
            self.publisher
                .send(mark, all.len(), |index, sequence| Alert { sequence, ..all[index] })?;
            if self.changed.is_empty() {
                break;
            }
        }
        self.due_ns = now.mono_ns + REPEAT_NS;
        Ok(())
    }
}

impl<S: Transport> Agent for AlertAgent<S> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let (engine, changed, progress_ns) = (&mut self.engine, &mut self.changed, &mut self.progress_ns);
        let slices = self.tracks.take(SLICES_PER_TURN, |_, tracks| {
            for track in tracks {
                *progress_ns = (*progress_ns).max(track.reference_time_ns);
                engine.take(track, changed);
            }
        })?;
        if !self.changed.is_empty() || now.mono_ns >= self.due_ns {
            self.publish(now)?;
        }
        if slices == SLICES_PER_TURN {
            return Ok(Turn::Worked);
        }
        Ok(Turn::Idle(Duration::from_nanos(
            (self.due_ns - now.mono_ns).clamp(0, REPEAT_NS) as u64,
        )))
    }

    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        self.publish(now)
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let tracks = &self.tracks;
        self.waiter.wait(at_most, || tracks.has_slices())?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut entry = HealthEntry::default();
        let taken = self.tracks.counts();
        entry.set(Counter::Taken, taken.taken);
        entry.set(Counter::Lost, taken.lost);
        entry.set(Counter::RejectedSchema, taken.schema_mismatch);
        entry.set(Counter::RejectedEpoch, taken.of_older_epochs);
        entry.set(Counter::RecordsSent, self.engine.last_number());
        entry.set(Counter::TracksDropped, self.engine.refused());
        entries.push(entry);
    }
}
