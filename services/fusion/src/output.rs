//! Output of system tracks and decisions.

use std::sync::Arc;

use bus::{BatchWriter, Bus, BusError, Mark, Publisher, Transport};
use deployment::{Deployment, ReportOrder};
use fusion::{FilterInput, Sink};
use messages::{Counter, Decision, NO_SOURCE, OrderState, ProcessKind, StreamId, SystemTrack, Topic};
use runtime::clock::{boot_identity, mono_ns};
use runtime::flow::Flow;
use runtime::housekeeping::Queues;

use crate::smoothing::SmoothingQueue;

/// System-track states that wait to be sent as a single slice.
#[derive(Debug)]
pub(crate) struct TrackOutput<S: Transport> {
    states: BatchWriter<S, SystemTrack>,
    /// States by the sources here alone, for other centres.
    own: Option<BatchWriter<S, SystemTrack>>,
    /// For recordings: the recorder must keep up.
    flow: Option<Flow<S>>,
    /// Number of the deployment.
    origin: u32,
    deadline_ns: i64,
    deadline_misses: u64,
    /// When fusion took the report being processed; 0 while time passes alone.
    taken_ns: i64,
    /// When the present turn began.
    turn_ns: i64,
    /// Queue of decisions, which another thread publishes.
    queues: Arc<Queues>,
    decisions_dropped: u64,
    /// For smoothed states, which another thread makes.
    smoothing: Option<Arc<SmoothingQueue>>,
    smoothing_dropped: u64,
}

impl<S: Transport> Sink for TrackOutput<S> {
    #[inline]
    fn track(&mut self, track: &SystemTrack) {
        if track.stages.taken_ns == self.taken_ns || track.trigger_source == NO_SOURCE {
            self.states.push(track);
        } else {
            self.push_held(track);
        }
        if self.smoothing.is_some() {
            self.smooth(track);
        }
    }

    fn follows_inputs(&self) -> bool {
        self.smoothing.is_some()
    }

    fn input(&mut self, input: &FilterInput) {
        if let Some(queue) = &self.smoothing {
            self.smoothing_dropped += u64::from(!queue.input(input));
        }
    }

    fn own_track(&mut self, track: &SystemTrack) {
        if let Some(own) = &mut self.own {
            own.push(track);
        }
    }

    fn order(&mut self, state: &OrderState) {
        // With a full queue, the oldest state gives way: a newer state of the same order follows or is repeated.
        let _ = self.queues.order_states.force_push(*state);
    }

    fn decision(&mut self, decision: &Decision) {
        if let Some(queue) = &self.queues.decisions {
            self.decisions_dropped += u64::from(queue.push(*decision).is_err());
        }
    }
}

impl<S: Transport> TrackOutput<S> {
    /// Sets the epoch of states.
    pub(crate) fn new(
        config: &Deployment,
        bus: &Bus<S>,
        (incarnation, epoch): (u64, u64),
        queues: Arc<Queues>,
    ) -> anyhow::Result<Self> {
        let topic = messages::system_tracks();
        let follow = config.is_recorded() && config.services.recorder;
        let flow = || {
            Flow::new(
                bus,
                incarnation,
                StreamId::SYSTEM_TRACKS,
                topic.capacity.depth,
                &[ProcessKind::Recorder],
            )
        };
        // The ends of all tracks at once fit too.
        let room = topic.capacity.slice_len + config.system_tracks.max;
        let boot = boot_identity();
        let writer = |topic: &Topic<SystemTrack>| -> Result<_, BusError> {
            let publisher: Publisher<S, SystemTrack> = bus.publisher(topic, incarnation)?;
            Ok(BatchWriter::new(publisher.with_epoch(epoch).of_boot(boot), room))
        };
        let own = || writer(&messages::own_tracks());
        Ok(Self {
            states: writer(&topic)?,
            own: config.system_tracks.exchange.then(own).transpose()?,
            flow: follow.then(flow).transpose()?,
            origin: config.origin,
            deadline_ns: match config.order {
                ReportOrder::Arrival => config.fusion.deadline_ns(),
                // Reports wait for each other by intention: none is late.
                ReportOrder::Time => i64::MAX,
            },
            deadline_misses: 0,
            taken_ns: 0,
            turn_ns: 0,
            queues,
            decisions_dropped: 0,
            smoothing: None,
            smoothing_dropped: 0,
        })
    }

    /// A turn begins at `now_ns`, monotonic: states due by time alone are due at this time at the latest.
    #[inline]
    pub(crate) fn begin_turn(&mut self, now_ns: i64) {
        self.turn_ns = now_ns;
    }

    /// The states that follow are caused by a report taken at `taken_ns`, monotonic, or release reports that waited;
    /// 0: time passes alone.
    #[inline]
    pub(crate) fn begin_report(&mut self, taken_ns: i64) {
        self.taken_ns = taken_ns;
    }

    /// Adds a state of a report that has waited for its scan: an answer before this turn was impossible.
    #[cold]
    fn push_held(&mut self, track: &SystemTrack) {
        let held_us = (self.turn_ns - track.stages.taken_ns) / 1000;
        self.states.push(&SystemTrack {
            held_us: held_us.clamp(0, i64::from(u32::MAX)) as u32,
            ..*track
        });
    }

    /// Passes the engine's output on to `queue`, too.
    pub(crate) fn smooth_into(&mut self, queue: Arc<SmoothingQueue>) {
        self.smoothing = Some(queue);
    }

    /// Marks states as continuing the tracks of the previous epoch.
    pub(crate) fn go_on(&mut self) {
        self.states.publisher_mut().go_on();
        if let Some(queue) = &self.smoothing {
            queue.go_on();
        }
        if let Some(own) = &mut self.own {
            own.publisher_mut().go_on();
        }
    }

    /// Start-up number of fusion, and number of the next state that is sent.
    pub(crate) fn next(&self) -> (u64, u64) {
        (self.states.publisher().epoch(), self.states.publisher().next_sequence())
    }

    /// Whether a further slice's worth may be worked off: all consumers that must not miss anything have room.
    pub(crate) fn has_room(&mut self) -> anyhow::Result<bool> {
        if !self.can_smooth() {
            return Ok(false);
        }
        let sent = self.states.publisher().counts().slices;
        let Some(flow) = &mut self.flow else { return Ok(true) };
        flow.update(sent)?;
        Ok(flow.may_send(sent))
    }

    /// Whether the smoothing thread has room, if any.
    pub(crate) fn can_smooth(&self) -> bool {
        self.smoothing.as_ref().is_none_or(|queue| queue.has_room())
    }

    /// Whether enough waits to fill a slice.
    pub(crate) fn is_full(&self) -> bool {
        self.states.len() >= self.states.publisher().slice_len()
    }

    /// How many wait.
    pub(crate) fn waiting(&self) -> usize {
        self.states.len()
    }

    /// Passes a state on to the smoothing thread.
    #[cold]
    fn smooth(&mut self, track: &SystemTrack) {
        if let Some(queue) = &self.smoothing {
            let (epoch, origin) = (self.states.publisher().epoch(), self.origin);
            let state = SystemTrack {
                epoch,
                origin,
                ..*track
            };
            self.smoothing_dropped += u64::from(!queue.state(state));
        }
    }

    /// Sends waiting states; with `end`, announces the end.
    #[inline]
    pub(crate) fn send(&mut self, progress_ns: i64, end: bool) -> anyhow::Result<()> {
        if self.states.is_empty() && !end {
            return Ok(());
        }
        self.send_batch(progress_ns, end)
    }

    fn send_batch(&mut self, progress_ns: i64, end: bool) -> anyhow::Result<()> {
        if let Some(queue) = self.smoothing.as_ref().filter(|_| end) {
            self.smoothing_dropped += u64::from(!queue.end());
        }
        let (sent_ns, deadline_ns) = (mono_ns(), self.deadline_ns);
        let mark = Mark {
            progress_ns,
            sent_ns,
            end,
        };
        let (epoch, origin) = (self.states.publisher().epoch(), self.origin);
        let stamp = |track: &mut SystemTrack, sequence| {
            (track.sequence, track.epoch, track.origin) = (sequence, epoch, origin);
            track.stages.fused_ns = sent_ns;
        };
        let mut missed = 0;
        self.states.send(mark, |track, sequence| {
            stamp(track, sequence);
            let answerable_ns = track.stages.taken_ns + i64::from(track.held_us) * 1000;
            missed += u64::from(track.stages.taken_ns != 0 && sent_ns - answerable_ns > deadline_ns);
        })?;
        self.deadline_misses += missed;
        if let Some(own) = &mut self.own {
            own.send(mark, stamp)?;
        }
        Ok(())
    }

    /// Wakes readers that came lately: to be called at times, and before a sleep.
    pub(crate) fn settle(&mut self) {
        self.states.settle();
        if let Some(own) = &mut self.own {
            own.settle();
        }
    }

    /// Returns whether all required readers have everything.
    pub(crate) fn all_received(&mut self) -> anyhow::Result<bool> {
        let sent = self.states.publisher().counts().slices;
        let Some(flow) = &mut self.flow else { return Ok(true) };
        flow.update(sent)?;
        Ok(flow.all_done(sent))
    }

    pub(crate) fn count(&self, counters: &mut messages::Counters) {
        counters[Counter::Published] = self.states.publisher().counts().samples;
        counters[Counter::DeadlineMisses] = self.deadline_misses;
        counters[Counter::DecisionsDropped] = self.decisions_dropped;
        counters[Counter::SmoothingDropped] = self.smoothing_dropped;
    }
}
