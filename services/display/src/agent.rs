//! Duty cycle of the display: receives samples from the topics and puts them into the world.
//!
//! The agent polls every few milliseconds instead of waiting for events, so no publisher ever has to wake the
//! display.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use bus::{Bus, Payload, Subscriber, Transport};
use deployment::Deployment;
use messages::{
    Alarm, Counter, Cue, Decision, FrameOrigin, Health, OrderState, SensorBearing, SensorDetection, SensorTrack,
    Stream, Streamed as _, SystemTrack, WideArea,
};
use runtime::{Agent, HealthEntry, Now, Turn};
use web::RequestCounts;

use crate::orders::OrderAgent;
use crate::shared::SharedState;

/// Slices taken from one topic in one turn: the capacity of its queue.
const SLICES_PER_TURN: usize = 256;
/// Time between two polls: at the highest rates, a queue holds the slices of several polls.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// Display agent; generic over the transport, so that tests drive it in process.
pub(crate) struct DisplayAgent<S: Transport> {
    shared: Arc<SharedState>,
    /// Requests that the server refused.
    refused: Arc<RequestCounts>,
    states: Subscriber<S, SystemTrack>,
    health: Subscriber<S, Health>,
    origins: Subscriber<S, FrameOrigin>,
    alarms: Subscriber<S, Alarm>,
    decisions: Option<Subscriber<S, Decision>>,
    orders: Option<Subscriber<S, OrderState>>,
    sensor_tracks: Vec<Subscriber<S, SensorTrack>>,
    detections: Vec<Subscriber<S, SensorDetection>>,
    bearings: Vec<Subscriber<S, SensorBearing>>,
    counts: Vec<Subscriber<S, WideArea>>,
    cues: Vec<Subscriber<S, Cue>>,
    /// Port for orders, if operators are configured.
    operators: Option<OrderAgent<S>>,
}

impl<S: Transport> DisplayAgent<S> {
    /// Creates the display agent of the deployment `config`, which may have operators; it fills `shared`.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(crate) fn new(
        config: &Deployment,
        has_operators: bool,
        bus: &Bus<S>,
        incarnation: u64,
        (shared, refused): (Arc<SharedState>, Arc<RequestCounts>),
    ) -> anyhow::Result<Self> {
        let now_ns = || incarnation;
        let mut agent = Self {
            shared,
            refused,
            states: bus.subscriber(&messages::system_tracks(), now_ns)?,
            health: bus.subscriber(&messages::health(), now_ns)?,
            origins: bus.subscriber(&messages::frame_origin(), now_ns)?,
            alarms: bus.subscriber(&messages::alarms(), now_ns)?,
            decisions: None,
            orders: None,
            sensor_tracks: Vec::new(),
            detections: Vec::new(),
            bearings: Vec::new(),
            counts: Vec::new(),
            cues: Vec::new(),
            operators: has_operators.then(|| OrderAgent::open(bus, incarnation)).transpose()?,
        };
        for (id, name) in config.streams() {
            match id.stream {
                Stream::SensorTracks => agent
                    .sensor_tracks
                    .push(bus.subscriber(&SensorTrack::topic(name), now_ns)?),
                Stream::Detections => agent
                    .detections
                    .push(bus.subscriber(&SensorDetection::topic(name), now_ns)?),
                Stream::Bearings => agent
                    .bearings
                    .push(bus.subscriber(&SensorBearing::topic(name), now_ns)?),
                Stream::WideArea => agent.counts.push(bus.subscriber(&WideArea::topic(name), now_ns)?),
                Stream::Cues => agent.cues.push(bus.subscriber(&Cue::topic(name), now_ns)?),
                Stream::Decisions => agent.decisions = Some(bus.subscriber(&Decision::topic(name), now_ns)?),
                Stream::Orders => agent.orders = Some(bus.subscriber(&messages::order_states(), now_ns)?),
                Stream::PlatformStates | Stream::SystemTracks | Stream::Alarms => {}
            }
        }
        Ok(agent)
    }
}

/// Takes the waiting slices of all `topics`.
fn take<S: Transport, T: Payload>(
    topics: &mut [Subscriber<S, T>],
    mut visit: impl FnMut(&[T]),
) -> Result<(), bus::BusError> {
    for topic in topics {
        topic.take(SLICES_PER_TURN, |_, slice| visit(slice))?;
    }
    Ok(())
}

impl<S: Transport> Agent for DisplayAgent<S> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        if let Some(operators) = &mut self.operators {
            operators.turn(&self.shared.orders, now)?;
        }
        let mut world = self.shared.world();
        let world = &mut *world;
        self.origins.take(SLICES_PER_TURN, |_, said| {
            said.iter().for_each(|origin| world.place(origin))
        })?;
        self.health.take(SLICES_PER_TURN, |_, said| {
            said.iter().for_each(|health| world.observed.take_health(health))
        })?;
        self.alarms.take(SLICES_PER_TURN, |header, slice| {
            world.observed.take_alarms(header, slice)
        })?;
        // Reports come before the states that result from them.
        take(&mut self.sensor_tracks, |reports| {
            world.hear_sensor_tracks(reports, now)
        })?;
        take(&mut self.detections, |detections| world.hear_detections(detections))?;
        take(&mut self.bearings, |bearings| world.hear_bearings(bearings))?;
        take(&mut self.counts, |counts| world.hear_counts(counts))?;
        take(&mut self.cues, |cues| world.hear_cues(cues))?;
        take(self.decisions.as_mut_slice(), |decisions| {
            world.hear_decisions(decisions)
        })?;
        take(self.orders.as_mut_slice(), |orders| world.observed.take_orders(orders))?;
        self.states
            .take(SLICES_PER_TURN, |header, tracks| world.receive(header, tracks, now))?;
        world.clean_up(now);
        Ok(Turn::Idle(LOOK_EVERY))
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let (taken, traffic) = (self.states.counts(), &self.shared.traffic);
        let mut entry = HealthEntry::default();
        entry.set(Counter::Taken, taken.taken);
        entry.set(Counter::Lost, taken.lost);
        entry.set(Counter::RejectedSchema, taken.schema_mismatch);
        entry.set(Counter::RejectedEpoch, taken.of_older_epochs);
        entry.set(Counter::PicturesSent, traffic.sent.load(Ordering::Relaxed));
        entry.set(Counter::PicturesSkipped, traffic.skipped.load(Ordering::Relaxed));
        let rejected = self.refused.total() + traffic.refused.load(Ordering::Relaxed);
        entry.set(Counter::RequestsRejected, rejected);
        entries.push(entry);
    }
}
