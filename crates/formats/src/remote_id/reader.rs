//! Lines to messages of drones.

use frames::time::{NS_PER_DAY, NS_PER_S};
use messages::{Identity, TrackState};
use observations::{Axes, Observation, Statement};

use super::line::Line;
use super::message::{DroneId, Location, Message};
use super::reason::{Read, RemoteIdReason};
use crate::target_message::{KnownTarget, Memory, Refusal, TargetMessage};

/// Greatest time between a Location and its receipt, nanoseconds.
pub const DELAY_MAX_NS: i64 = 10 * NS_PER_S;
/// After this silence a drone may be forgotten, nanoseconds.
pub const SILENCE_MAX_NS: i64 = 60 * NS_PER_S;

const HOUR_NS: i64 = 3600 * NS_PER_S;

/// Settings of a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RemoteIdSettings {
    /// Most drones that are remembered, and most transmitters.
    pub drones_max: usize,
}

impl Default for RemoteIdSettings {
    /// More drones than are in reach of a network of receivers.
    fn default() -> Self {
        Self { drones_max: 4096 }
    }
}

/// Counts. A line is in exactly one of `lines` and `refused_lines`, a message of a used line in exactly one of
/// `identities`, `locations`, `systems`, `others` and `refused_messages`, and a Location in exactly one of
/// `observations`, `repetitions` and `without_position`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RemoteIdCounters {
    /// Lines that were used.
    pub lines: u64,
    /// Lines that were refused.
    pub refused_lines: u64,
    /// Messages in lines that were used.
    pub messages: u64,
    /// Basic IDs.
    pub identities: u64,
    /// Locations.
    pub locations: u64,
    /// System messages.
    pub systems: u64,
    /// Operator IDs, Self-IDs and authentications.
    pub others: u64,
    /// Messages that were refused.
    pub refused_messages: u64,
    /// Locations with a new position.
    pub observations: u64,
    /// Locations that were given before.
    pub repetitions: u64,
    /// Locations whose position is unknown.
    pub without_position: u64,
    /// Locations with the time of receipt, for want of a right one of their own.
    pub received_times: u64,
    /// Statements given.
    pub statements: u64,
    /// Lines and messages that were refused, by [`RemoteIdReason`].
    pub refused: [u64; RemoteIdReason::ALL.len()],
}

/// Reader of lines.
#[derive(Debug)]
pub struct RemoteIdReader {
    /// By number of the track.
    drones: Memory<KnownTarget>,
    /// By number of the transmitter.
    identities: Memory<Option<DroneId>>,
    counters: RemoteIdCounters,
    refusal: Option<Refusal<RemoteIdReason>>,
}

impl RemoteIdReader {
    /// Returns a reader with allocated tables.
    pub fn new(settings: RemoteIdSettings) -> Self {
        Self {
            drones: Memory::new(settings.drones_max, SILENCE_MAX_NS),
            identities: Memory::new(settings.drones_max, SILENCE_MAX_NS),
            counters: RemoteIdCounters::default(),
            refusal: None,
        }
    }

    /// Takes a line without its end; calls `each` for all news in the line.
    pub fn take(&mut self, line: &[u8], mut each: impl FnMut(TargetMessage)) {
        match self.line(line, &mut each) {
            Ok(()) => self.counters.lines += 1,
            Err(refusal) => {
                self.counters.refused_lines += 1;
                self.refuse(refusal);
            }
        }
    }

    /// Counts so far.
    pub fn counters(&self) -> &RemoteIdCounters {
        &self.counters
    }

    /// The latest refusal; `None` if there was none.
    pub fn refused(&self) -> Option<&Refusal<RemoteIdReason>> {
        self.refusal.as_ref()
    }

    fn line(&mut self, line: &[u8], each: &mut dyn FnMut(TargetMessage)) -> Read<()> {
        let line = Line::read(line)?;
        let messages: Vec<_> = line.messages().map(Message::read).collect();
        // Identities come first, wherever they are in the pack: the other messages need them.
        let ids = messages.iter().filter_map(|message| match message {
            Ok(Message::BasicId(id, _)) => *id,
            _ => None,
        });
        let id = self.identity(&line, ids.max_by_key(|id| id.kind))?;
        let number = id.map(|id| id.number()).or(line.transmitter);
        let number = number.ok_or_else(|| Refusal::new(RemoteIdReason::Transmitter, "message without", "mac"))?;
        let room = || Refusal::new(RemoteIdReason::Room, "track", number);
        self.drones.of(number, line.received_ns).ok_or_else(room)?;
        let mut stated = Statement {
            track_number: number,
            ..Statement::default()
        };
        let mut locations = Vec::new();
        self.counters.messages += messages.len() as u64;
        for message in messages {
            let counter = match message {
                Ok(Message::BasicId(_, category)) => {
                    stated.category = category;
                    &mut self.counters.identities
                }
                Ok(Message::Location(location)) => {
                    stated.emergency = location.emergency;
                    locations.push(location);
                    &mut self.counters.locations
                }
                Ok(Message::System(operator_rad)) => {
                    stated.operator_rad = operator_rad;
                    &mut self.counters.systems
                }
                Ok(Message::Authentication | Message::SelfId | Message::OperatorId) => &mut self.counters.others,
                Err(refusal) => {
                    self.refuse(refusal);
                    &mut self.counters.refused_messages
                }
            };
            *counter += 1;
        }
        let mut statement = self
            .drones
            .of(number, line.received_ns)
            .and_then(|known| known.news(stated));
        self.counters.statements += u64::from(statement.is_some());
        let identity = id
            .as_ref()
            .and_then(DroneId::name)
            .map_or(Identity::default(), |name| Identity::default().with_name(name));
        for location in locations {
            if let Some((time_ns, observation)) = self.observation(&location, line.received_ns, number, identity) {
                each(TargetMessage {
                    time_ns,
                    observation: Some(observation),
                    statement: statement.take(),
                });
            }
        }
        if statement.is_some() {
            each(TargetMessage {
                time_ns: line.received_ns,
                observation: None,
                statement,
            });
        }
        Ok(())
    }

    /// The most lasting identity that is known of a line's drone.
    fn identity(&mut self, line: &Line, stated: Option<DroneId>) -> Read<Option<DroneId>> {
        let Some(transmitter) = line.transmitter else {
            return Ok(stated);
        };
        let known = self.identities.of(transmitter, line.received_ns);
        let known = known.ok_or_else(|| Refusal::new(RemoteIdReason::Room, "transmitter", transmitter))?;
        if stated.map(|id| id.kind) >= known.map(|id| id.kind) {
            *known = stated;
        }
        Ok(*known)
    }

    /// The observation of a Location, and its time, if it is new.
    fn observation(
        &mut self,
        location: &Location,
        received_ns: i64,
        number: u32,
        identity: Identity,
    ) -> Option<(i64, Observation)> {
        let Some(position) = location.position else {
            self.counters.without_position += 1;
            return None;
        };
        let own_ns = location.since_hour_ns.map(|since_ns| nearest_ns(since_ns, received_ns));
        let own_ns = own_ns.filter(|own_ns| own_ns.abs_diff(received_ns) <= DELAY_MAX_NS.unsigned_abs());
        self.counters.received_times += u64::from(own_ns.is_none());
        let time_ns = own_ns.unwrap_or(received_ns);
        let known = self.drones.of(number, received_ns);
        if !known.is_some_and(|known| known.is_new(time_ns, position, 1)) {
            self.counters.repetitions += 1;
            return None;
        }
        self.counters.observations += 1;
        let observation = Observation {
            time_of_day_ns: Some(time_ns.rem_euclid(NS_PER_DAY)),
            track_number: Some(number),
            identity,
            geodetic: Some(position),
            velocity: location.velocity,
            axes: Axes::Target,
            velocity_covariance: location.velocity_covariance,
            pressure_altitude_m: location.pressure_altitude_m,
            geometric_height_m: location.ellipsoid_height_m,
            ellipsoid_height_m: location.ellipsoid_height_m,
            vertical_rate_mps: location.vertical_rate_mps,
            on_ground: location.on_ground,
            alerts: location.alerts,
            state: TrackState::Confirmed,
            quality: location.quality,
            ..Observation::default()
        };
        Some((time_ns, observation))
    }

    fn refuse(&mut self, refusal: Refusal<RemoteIdReason>) {
        self.counters.refused[refusal.reason as usize] += 1;
        self.refusal = Some(refusal);
    }
}

/// The time of a time since the full hour, of the hour that brings it nearest to another time.
fn nearest_ns(since_hour_ns: i64, near_ns: i64) -> i64 {
    let after_ns = (since_hour_ns - near_ns + HOUR_NS / 2).rem_euclid(HOUR_NS) - HOUR_NS / 2;
    near_ns + after_ns
}
