//! Duty cycle of a gateway.

use std::time::Duration;

use anyhow::Context as _;
use asterix::registry;
use bus::{Bus, Payload, Subscriber, Transport, WaitMode, Waiter};
use deployment::{Deployment, Source};
use messages::{Alarm, BatchHeader, Counter, Health, SensorTrack, SystemTrack, Topic, TrackState, sensor_track_bits};
use outgoing::{
    CotEvents, OutgoingCounts, SendBlock, SensorReports, ServiceEvent, StatusReports, SystemReports, SystemSource,
};
use runtime::{Agent, HealthEntry, Now, Turn};

use crate::outlet::Outlet;
use crate::schedule::SendSchedule;
use crate::selection::TrackSelection;
use crate::sensor_states::SensorStates;
use crate::settings::{GatewayContent as Sent, OutputFormat, Settings};

/// Maximum number of slices taken in one turn: the length of the queue.
const SLICES_PER_TURN: usize = 256;
/// Period of the search for due tracks, nanoseconds: the tracks of one search share datagrams.
const LOOK_PERIOD_NS: i64 = 20_000_000;
/// Categories of the state of a system and of its sensors.
const STATUS_CATEGORIES: [u8; 2] = [65, 63];
/// Longest sleep, bounded by status messages to send and health messages to read.
const SLEEP_MAX_NS: i64 = 50_000_000;

/// Gateway as an agent, generic over the transport: tests run it in process.
#[derive(Debug)]
pub(crate) struct GatewayAgent<S: Transport> {
    content: OutgoingContent<S>,
    health: Subscriber<S, Health>,
    alarms: Subscriber<S, Alarm>,
    sensors: SensorStates,
    outlet: Outlet,
    waiter: Waiter<S>,
    /// Categories of the status messages for this user.
    status: Vec<u8>,
    status_ns: i64,
    next_status_ns: i64,
}

/// Tracks to send.
#[derive(Debug)]
enum OutgoingContent<S: Transport> {
    System(Box<OutgoingPicture<S, SystemTrack, SystemReports>>, Box<StatusReports>),
    Sensor(Box<OutgoingPicture<S, SensorTrack, SensorReports>>),
    Events(Box<OutgoingPicture<S, SystemTrack, CotEvents>>),
}

/// Outgoing tracks of one topic.
#[derive(Debug)]
struct OutgoingPicture<S: Transport, T: Payload, R> {
    subscriber: Subscriber<S, T>,
    schedule: SendSchedule<T>,
    selection: TrackSelection,
    reports: R,
    /// Epoch of the publisher of the tracks; 0 before the first slice.
    publisher: u64,
    /// Whether tracks were dropped with their publisher, and the user has no notice yet.
    has_forgotten: bool,
    next_look_ns: i64,
}

/// Properties of a track that a gateway uses.
trait GatewayTrack: Payload + Copy {
    fn number(&self) -> u32;
    /// Returns the position in the system frame, metres.
    fn position_m(&self) -> [f64; 3];
    /// Whether the height is known.
    fn has_height(&self) -> bool;
    fn state(&self) -> Option<TrackState>;
    /// Returns the last state of the track, which ends it for the user.
    fn ended(self) -> Self;
}

/// Conversion of tracks to data blocks.
trait BlockConversion<T> {
    fn report(&mut self, track: &T, send: &mut SendBlock<'_>);
    fn flush(&mut self, send: &mut SendBlock<'_>);
    fn counts(&self) -> OutgoingCounts;
}

impl<S: Transport> GatewayAgent<S> {
    /// Opens the gateway `gateway` of `config` on `bus`; `incarnation` is the process's monotonic start time,
    /// nanoseconds.
    ///
    /// # Errors
    /// If the socket or a topic cannot be opened.
    pub(crate) fn new(config: &Deployment, gateway: &Settings, bus: &Bus<S>, incarnation: u64) -> anyhow::Result<Self> {
        let outlet = Outlet::open(&gateway.way()?)?;
        let mut waiter = bus.waiter(WaitMode::Event);
        let user = (gateway.refresh_s.ns(), TrackSelection::new(gateway, config.frame));
        let block_bytes = gateway.block_bytes;
        let what = gateway.content(config)?;
        let content = match what {
            Sent::Fused | Sent::Own => {
                let topic = match what {
                    Sent::Own => messages::own_tracks(),
                    _ => messages::system_tracks(),
                };
                waiter.watch(bus, &topic)?;
                let capacity = config.system_tracks.max;
                if gateway.format == OutputFormat::Cot {
                    let events = CotEvents::new(&config.name, config.frame, gateway.stale_s.ns());
                    let events = events.with_height(gateway.heights);
                    let picture = OutgoingPicture::open(bus, &topic, incarnation, user, capacity, events)?;
                    OutgoingContent::Events(Box::new(picture))
                } else {
                    let [sac, sic] = gateway.codes()?;
                    let sources: Vec<SystemSource> = config.sources.iter().map(system_source).collect();
                    let reports = SystemReports::new(gateway.table()?, sac, sic, config.frame, &sources, block_bytes)?
                        .with_height(gateway.heights)
                        .with_tracks(capacity);
                    let reports = match gateway.target_identification {
                        true => reports.with_target_identification(),
                        false => reports,
                    };
                    let picture = OutgoingPicture::open(bus, &topic, incarnation, user, capacity, reports)?;
                    let [of_system, of_sensors] = STATUS_CATEGORIES.map(registry::default_edition);
                    let (of_system, of_sensors) = of_system.zip(of_sensors).context("CAT065 and CAT063 have tables")?;
                    let status = StatusReports::new(of_system, of_sensors, sac, sic, block_bytes)?;
                    OutgoingContent::System(Box::new(picture), Box::new(status))
                }
            }
            Sent::OfSource(source) => {
                let [sac, sic] = gateway.codes()?;
                let reports = SensorReports::new(gateway.table()?, sac, sic, source.frame, config.frame, block_bytes)?
                    .with_height(gateway.heights);
                let topic = messages::sensor_tracks(&source.name);
                waiter.watch(bus, &topic)?;
                let capacity = source.tracks_max;
                let picture = OutgoingPicture::open(bus, &topic, incarnation, user, capacity, reports)?;
                OutgoingContent::Sensor(Box::new(picture))
            }
        };
        Ok(Self {
            content,
            health: bus.subscriber(&messages::health(), || incarnation)?,
            alarms: bus.subscriber(&messages::alarms(), || incarnation)?,
            sensors: SensorStates::new(config),
            outlet,
            waiter,
            status: gateway.status.clone(),
            status_ns: gateway.status_s.ns(),
            next_status_ns: i64::MIN,
        })
    }

    /// Address at which clients connect; `None` for datagrams.
    #[cfg(test)]
    pub(crate) fn listening_at(&self) -> Option<std::net::SocketAddr> {
        self.outlet.listening_at()
    }

    fn say_status(&mut self, now: Now) {
        if now.utc_ns < self.next_status_ns {
            return;
        }
        self.next_status_ns = now.utc_ns + self.status_ns;
        let (outlet, wanted) = (&mut self.outlet, &self.status);
        let mut send = |datagram: &[u8]| outlet.send(datagram);
        // The first byte of a block is its category.
        let mut send_wanted = |datagram: &[u8]| {
            if datagram.first().is_some_and(|category| wanted.contains(category)) {
                send(datagram);
            }
        };
        match &mut self.content {
            OutgoingContent::System(_, status) => self.sensors.report(now, status, &mut send_wanted),
            OutgoingContent::Sensor(picture) => picture.reports.status(now.utc_ns, &mut send),
            OutgoingContent::Events(_) => {}
        }
    }
}

fn system_source(source: &Source) -> SystemSource {
    SystemSource {
        number: source.number,
        technology: source.technology,
        code: source.sac_sic.map(|(sac, sic)| [sac, sic]),
    }
}

impl<S: Transport, T: GatewayTrack, R: BlockConversion<T>> OutgoingPicture<S, T, R> {
    fn open(
        bus: &Bus<S>,
        topic: &Topic<T>,
        incarnation: u64,
        (refresh_ns, selection): (i64, TrackSelection),
        capacity: usize,
        reports: R,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            subscriber: bus.subscriber(topic, || incarnation)?,
            schedule: SendSchedule::new(refresh_ns, capacity),
            selection,
            reports,
            publisher: 0,
            has_forgotten: false,
            next_look_ns: i64::MIN,
        })
    }

    /// Takes published tracks and sends due tracks. Returns whether more slices may be waiting.
    fn turn(&mut self, now: Now, send: &mut SendBlock<'_>) -> anyhow::Result<bool> {
        let (schedule, selection) = (&mut self.schedule, &self.selection);
        let (reports, publisher, has_forgotten) = (&mut self.reports, &mut self.publisher, &mut self.has_forgotten);
        let slices = self.subscriber.take(SLICES_PER_TURN, |header, tracks| {
            if header.incarnation != *publisher {
                if header.flags & BatchHeader::GOES_ON != 0 {
                    schedule.go_on(now.mono_ns);
                } else {
                    // The publisher of the present tracks has ended and can no longer terminate them.
                    schedule.forget_all(|track| reports.report(&track.ended(), send));
                    *has_forgotten |= *publisher != 0;
                }
                *publisher = header.incarnation;
            }
            for track in tracks {
                let at_once = match track.state() {
                    Some(TrackState::Confirmed | TrackState::Coasted)
                        if !selection.admits(track.position_m(), track.has_height()) =>
                    {
                        // The track has left the user's selection: the user's copy of the track ends.
                        if schedule.end(track.number()) {
                            reports.report(&track.ended(), send);
                        }
                        false
                    }
                    Some(TrackState::Confirmed | TrackState::Coasted) => {
                        if let Some(stale) = schedule.displaced_by(track.number(), now.mono_ns) {
                            reports.report(&stale.ended(), send);
                        }
                        schedule.take(track.number(), *track, now.mono_ns)
                    }
                    Some(TrackState::Suspended | TrackState::Terminated) => schedule.end(track.number()),
                    Some(TrackState::Tentative) | None => false,
                };
                if at_once {
                    reports.report(track, send);
                }
            }
        })?;
        if now.mono_ns >= self.next_look_ns {
            self.next_look_ns = now.mono_ns + LOOK_PERIOD_NS;
            schedule.forget_unheard(now.mono_ns, |track| reports.report(&track.ended(), send));
            while let Some(track) = schedule.next_turn(now.mono_ns) {
                reports.report(&track, send);
            }
        }
        reports.flush(send);
        Ok(slices == SLICES_PER_TURN)
    }

    fn next_turn_ns(&self) -> Option<i64> {
        self.schedule
            .next_turn_ns()
            .map(|turn_ns| turn_ns.max(self.next_look_ns))
    }

    fn count(&self, entry: &mut HealthEntry) {
        let (taken, sent) = (self.subscriber.counts(), self.reports.counts());
        entry.set(Counter::Taken, taken.taken);
        entry.set(Counter::Lost, taken.lost);
        entry.set(Counter::RejectedSchema, taken.schema_mismatch);
        entry.set(Counter::RejectedEpoch, taken.of_older_epochs);
        entry.set(Counter::RecordsSent, sent.records);
        entry.set(Counter::TracksDropped, sent.refused_number + self.schedule.dropped());
        entry.set(Counter::RejectedPosition, sent.refused_position);
        entry.set(Counter::RejectedNoTrackNumber, sent.refused_address);
    }
}

impl<S: Transport> Agent for GatewayAgent<S> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        let sensors = &mut self.sensors;
        self.health.take(SLICES_PER_TURN, |_, said| {
            said.iter().for_each(|health| sensors.observed.take_health(health))
        })?;
        self.alarms.take(SLICES_PER_TURN, |header, slice| {
            sensors.observed.take_alarms(header, slice)
        })?;
        self.say_status(now);
        self.outlet.accept_with(&[])?;
        let outlet = &mut self.outlet;
        // The outlet counts blocks that it could not send; the remaining blocks follow.
        let mut send = |block: &[u8]| outlet.send(block);
        let (more, next_ns) = match &mut self.content {
            OutgoingContent::System(picture, status) => {
                let more = picture.turn(now, &mut send)?;
                if std::mem::take(&mut picture.has_forgotten) && self.status.contains(&65) {
                    self.sensors.renumbered(now, status, &mut send);
                }
                (more, picture.next_turn_ns())
            }
            OutgoingContent::Sensor(picture) => (picture.turn(now, &mut send)?, picture.next_turn_ns()),
            OutgoingContent::Events(picture) => (picture.turn(now, &mut send)?, picture.next_turn_ns()),
        };
        if more {
            return Ok(Turn::Worked);
        }
        let until_ns = next_ns.map_or(SLEEP_MAX_NS, |next_ns| (next_ns - now.mono_ns).clamp(0, SLEEP_MAX_NS));
        Ok(Turn::Idle(Duration::from_nanos(until_ns as u64)))
    }

    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        let outlet = &mut self.outlet;
        if let OutgoingContent::System(_, status) = &mut self.content
            && self.status.contains(&65)
        {
            status.event(now.utc_ns, ServiceEvent::Ended, &mut |datagram| outlet.send(datagram));
        }
        Ok(())
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        let content = &self.content;
        self.waiter.wait(at_most, || match content {
            OutgoingContent::System(picture, _) => picture.subscriber.has_slices(),
            OutgoingContent::Sensor(picture) => picture.subscriber.has_slices(),
            OutgoingContent::Events(picture) => picture.subscriber.has_slices(),
        })?;
        Ok(())
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        let mut entry = HealthEntry::default();
        match &self.content {
            OutgoingContent::System(picture, _) => picture.count(&mut entry),
            OutgoingContent::Sensor(picture) => picture.count(&mut entry),
            OutgoingContent::Events(picture) => picture.count(&mut entry),
        }
        self.outlet.count(&mut entry);
        entries.push(entry);
    }
}

impl GatewayTrack for SystemTrack {
    fn number(&self) -> u32 {
        self.track_number
    }

    fn position_m(&self) -> [f64; 3] {
        self.position_m
    }

    fn has_height(&self) -> bool {
        self.height_valid != 0
    }

    fn state(&self) -> Option<TrackState> {
        TrackState::from_code(self.state)
    }

    fn ended(self) -> Self {
        Self {
            state: TrackState::Terminated as u8,
            ..self
        }
    }
}

impl GatewayTrack for SensorTrack {
    fn number(&self) -> u32 {
        self.track_number
    }

    fn position_m(&self) -> [f64; 3] {
        self.position_m
    }

    fn has_height(&self) -> bool {
        self.has(sensor_track_bits::HEIGHT)
    }

    fn state(&self) -> Option<TrackState> {
        TrackState::from_code(self.state)
    }

    fn ended(self) -> Self {
        Self {
            state: TrackState::Terminated as u8,
            ..self
        }
    }
}

impl BlockConversion<SystemTrack> for SystemReports {
    fn report(&mut self, track: &SystemTrack, send: &mut SendBlock<'_>) {
        self.report(track, send);
    }

    fn flush(&mut self, send: &mut SendBlock<'_>) {
        self.flush(send);
    }

    fn counts(&self) -> OutgoingCounts {
        self.counts()
    }
}

impl BlockConversion<SystemTrack> for CotEvents {
    fn report(&mut self, track: &SystemTrack, send: &mut SendBlock<'_>) {
        self.report(track, send);
    }

    /// Each event has left at once.
    fn flush(&mut self, _send: &mut SendBlock<'_>) {}

    fn counts(&self) -> OutgoingCounts {
        self.counts()
    }
}

impl BlockConversion<SensorTrack> for SensorReports {
    fn report(&mut self, track: &SensorTrack, send: &mut SendBlock<'_>) {
        self.report(track, send);
    }

    fn flush(&mut self, send: &mut SendBlock<'_>) {
        self.flush(send);
    }

    fn counts(&self) -> OutgoingCounts {
        self.counts()
    }
}
