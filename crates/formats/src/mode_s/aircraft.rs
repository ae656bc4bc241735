//! Latest values of one aircraft, and its observations.
//!
//! Every position is completed with values that are recent enough, by the ages of [`crate::sbs`]: both read the same
//! transmissions. Accuracy and status have the age of a code. A late frame replaces nothing newer.
//!
//! The errors of position and velocity are those that the aircraft states by categories, and those of the coding, which
//! are as large for aircraft of the best categories.
//!
//! One frame of noise in 16 million has the checksum of a reply of a given aircraft; a receiver that passes on
//! thousands of frames of noise a second gives false replies every minute. So code and alerts of replies are used once
//! a second reply within a minute states the same.

use messages::{Callsign, Identity, TrackState};
use observations::{Alerts, Axes, Emergency, Observation, Quality, Statement, TargetCategory};

use super::message::{ModeSMessage, ModeSOrigin};
use super::position::PositionDecoder;
use crate::observation::{items, navigation};
use crate::sbs::{CALLSIGN_AGE_MAX_NS, CODE_AGE_MAX_NS, MOTION_AGE_MAX_NS};

/// Bit of the track number of an address that is not the aircraft's own.
const ANONYMOUS: u32 = 1 << 24;

/// Latest values of one aircraft.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Aircraft {
    pub(super) positions: PositionDecoder,
    /// Velocity and the category of its accuracy.
    velocity: Option<Dated<([f64; 2], Option<u8>)>>,
    /// The category for velocities on the ground.
    surface_accuracy: Option<Dated<u8>>,
    vertical_rate_mps: Option<Dated<f64>>,
    altitude_m: Option<Dated<f64>>,
    callsign: Option<Dated<Callsign>>,
    mode_3a: Option<Dated<u16>>,
    transponder_alerts: Option<Dated<Alerts>>,
    /// Code and alerts of the latest replies.
    replied_mode_3a: Option<Dated<u16>>,
    replied_alerts: Option<Dated<Alerts>>,
    emergency_alerts: Option<Dated<Alerts>>,
    advisory_alerts: Option<Dated<Alerts>>,
    version: Option<Dated<u8>>,
    accuracy: Option<Dated<(u8, u8)>>,
    supplements: Option<Dated<[bool; 2]>>,
    is_magnetic: Option<Dated<bool>>,
    /// Statements given.
    category: TargetCategory,
    emergency: Emergency,
    selected_altitude_m: Option<f32>,
}

/// A value with the time of its frame.
#[derive(Clone, Copy, Debug)]
struct Dated<T> {
    time_ns: i64,
    value: T,
}

impl Aircraft {
    /// Stores the values of a message.
    pub(super) fn take(&mut self, message: &ModeSMessage, time_ns: i64) {
        let velocity = velocity(message).map(|velocity| (velocity, message.velocity_accuracy));
        put(&mut self.velocity, time_ns, velocity);
        let of_status = message.velocity_accuracy.filter(|_| message.ground_speed_mps.is_none());
        put(&mut self.surface_accuracy, time_ns, of_status);
        put(&mut self.vertical_rate_mps, time_ns, message.vertical_rate_mps);
        put(&mut self.altitude_m, time_ns, message.altitude_m);
        put(&mut self.callsign, time_ns, message.callsign);
        let (mut mode_3a, mut alerts) = (message.mode_3a, stated(message.transponder_alerts));
        if message.is_reply {
            mode_3a = repeated(&mut self.replied_mode_3a, time_ns, mode_3a);
            alerts = repeated(&mut self.replied_alerts, time_ns, alerts);
        }
        put(&mut self.mode_3a, time_ns, mode_3a);
        put(&mut self.transponder_alerts, time_ns, alerts);
        put(&mut self.emergency_alerts, time_ns, stated(message.emergency_alerts));
        put(&mut self.advisory_alerts, time_ns, stated(message.advisory_alerts));
        put(&mut self.version, time_ns, message.version);
        put(&mut self.accuracy, time_ns, message.accuracy);
        put(&mut self.supplements, time_ns, message.supplements);
        put(&mut self.is_magnetic, time_ns, message.is_magnetic);
    }

    /// The statement of a message, if it is another than before.
    pub(super) fn statement(&mut self, message: &ModeSMessage) -> Option<Statement> {
        let selected_altitude_m = message.selected_altitude_m.map(|altitude_m| altitude_m as f32);
        let statement = Statement {
            track_number: track_number(message),
            category: changed(&mut self.category, message.category),
            emergency: changed(&mut self.emergency, message.emergency),
            selected_altitude_m: changed(&mut self.selected_altitude_m, selected_altitude_m),
            ..Statement::default()
        };
        let nothing = Statement {
            track_number: statement.track_number,
            ..Statement::default()
        };
        (statement != nothing).then_some(statement)
    }

    /// The observation of a message's position, degrees.
    pub(super) fn observation(&self, message: &ModeSMessage, position_deg: [f64; 2], time_ns: i64) -> Observation {
        let is_surface = message.position.is_some_and(|position| position.is_surface);
        let mut identity = Identity::default();
        if !message.is_anonymous {
            identity = identity.with_address(message.address);
        }
        if let Some(callsign) = recent(self.callsign, time_ns, CALLSIGN_AGE_MAX_NS) {
            identity = identity.with_callsign(callsign);
        }
        if let Some(code) = recent(self.mode_3a, time_ns, CODE_AGE_MAX_NS) {
            identity = identity.with_mode_3a(code);
        }
        let (velocity, accuracy) = match is_surface {
            true => self.surface_velocity(message, time_ns),
            false => recent(self.velocity, time_ns, MOTION_AGE_MAX_NS),
        }
        .unzip();
        let own_or_recent = |own: Alerts, stored, age_max_ns| stated(own).or(recent(stored, time_ns, age_max_ns));
        let alerts = [
            own_or_recent(message.transponder_alerts, self.transponder_alerts, CODE_AGE_MAX_NS),
            recent(self.emergency_alerts, time_ns, CODE_AGE_MAX_NS),
            recent(self.advisory_alerts, time_ns, MOTION_AGE_MAX_NS),
        ];
        let altitude_m = message
            .altitude_m
            .or(recent(self.altitude_m, time_ns, MOTION_AGE_MAX_NS));
        let vertical_rate_mps = recent(self.vertical_rate_mps, time_ns, MOTION_AGE_MAX_NS);
        Observation {
            time_of_day_ns: Some(time_ns.rem_euclid(frames::time::NS_PER_DAY)),
            // An aircraft is its own track.
            track_number: Some(track_number(message)),
            identity,
            geodetic: Some(position_deg.map(f64::to_radians)),
            velocity,
            axes: Axes::Target,
            velocity_covariance: accuracy.flatten().and_then(velocity_covariance),
            pressure_altitude_m: altitude_m.filter(|_| !is_surface),
            geometric_height_m: message.ellipsoid_height_m,
            ellipsoid_height_m: message.ellipsoid_height_m,
            vertical_rate_mps: vertical_rate_mps.filter(|_| !is_surface),
            on_ground: is_surface,
            alerts: alerts
                .into_iter()
                .flatten()
                .fold(Alerts::default(), |all, some| all | some),
            state: TrackState::Confirmed,
            quality: navigation::with_step(self.quality(message, time_ns), navigation::squitter_step_m(is_surface)),
            ..Observation::default()
        }
    }

    /// Velocity on the ground, in the message itself. Directions from magnetic north are not used.
    fn surface_velocity(&self, message: &ModeSMessage, time_ns: i64) -> Option<([f64; 2], Option<u8>)> {
        let is_magnetic = recent(self.is_magnetic, time_ns, CODE_AGE_MAX_NS) == Some(true);
        let velocity = velocity(message).filter(|velocity| !is_magnetic || *velocity == [0.0; 2])?;
        Some((velocity, recent(self.surface_accuracy, time_ns, CODE_AGE_MAX_NS)))
    }

    /// Quality of a message's position, by the rules of CAT021: the same aircraft has one quality in both.
    fn quality(&self, message: &ModeSMessage, time_ns: i64) -> Quality {
        // The messages of TIS-B have no version, and another status.
        if message.origin == ModeSOrigin::TisB {
            return Quality::Unstated;
        }
        // An aircraft that sends no version is of version 0.
        let version = self.version.map_or(0, |version| version.value);
        let [a, c] = recent(self.supplements, time_ns, CODE_AGE_MAX_NS).unwrap_or_default();
        // Version 1 has one supplement for all.
        let b = if version == 1 { a } else { message.has_supplement_b };
        let category = match version {
            0 => uncertainty_category(message.position_type),
            _ => integrity_category(message.position_type, [a, b, c]),
        };
        let accuracy = recent(self.accuracy, time_ns, CODE_AGE_MAX_NS);
        let integrity = navigation::Integrity {
            category,
            level: accuracy.map(|(_, level)| level),
        };
        navigation::position_quality(
            Some(u64::from(version)),
            integrity,
            accuracy.map(|(category, _)| category),
        )
    }
}

/// Number of a message's aircraft at its source.
fn track_number(message: &ModeSMessage) -> u32 {
    message.address | if message.is_anonymous { ANONYMOUS } else { 0 }
}

/// Covariance of a velocity by its category (NACv or NUCr), with what the coding in knots adds.
fn velocity_covariance(category: u8) -> Option<[f64; 3]> {
    let stated = navigation::covariance_of_velocity_category(category)?;
    Some(navigation::covariance_with_step(stated, navigation::SQUITTER_STEP_MPS))
}

/// East and north of the velocity over ground. An aircraft that stands has no direction.
fn velocity(message: &ModeSMessage) -> Option<[f64; 2]> {
    match (message.ground_speed_mps?, message.track_rad) {
        (0.0, _) => Some([0.0; 2]),
        (speed_mps, track_rad) => Some(items::components([speed_mps, track_rad?])),
    }
}

/// Uncertainty category (NUCp) of a position of version 0, by its type: RTCA DO-260.
fn uncertainty_category(kind: u8) -> u8 {
    match kind {
        5..=8 => 14 - kind,
        9..=18 => 18 - kind,
        20 | 21 => 29 - kind,
        _ => 0,
    }
}

/// Integrity category (NIC) of a position of versions 1 and 2, by its type and the supplements: RTCA DO-260B, table of
/// the type codes.
fn integrity_category(kind: u8, [a, b, c]: [bool; 3]) -> u8 {
    match kind {
        5 | 9 | 20 => 11,
        6 | 10 | 21 => 10,
        7 if a && !c => 9,
        7 => 8,
        8 if a && c => 7,
        8 if a || c => 6,
        11 if a && b => 9,
        11 => 8,
        12..=15 => 19 - kind,
        16 if a && b => 3,
        16 => 2,
        17 => 1,
        _ => 0,
    }
}

/// Stores a value if there is one, unless the stored one is newer.
fn put<T>(stored: &mut Option<Dated<T>>, time_ns: i64, value: Option<T>) {
    if let Some(value) = value
        && stored.as_ref().is_none_or(|stored| stored.time_ns <= time_ns)
    {
        *stored = Some(Dated { time_ns, value });
    }
}

/// Stores the value of a reply; returns the value if the latest reply had the same.
fn repeated<T: Copy + PartialEq>(latest: &mut Option<Dated<T>>, time_ns: i64, value: Option<T>) -> Option<T> {
    let before = recent(*latest, time_ns, CODE_AGE_MAX_NS);
    put(latest, time_ns, value);
    value.filter(|value| before == Some(*value))
}

fn recent<T>(stored: Option<Dated<T>>, time_ns: i64, age_max_ns: i64) -> Option<T> {
    let stored = stored.filter(|stored| time_ns.abs_diff(stored.time_ns) <= age_max_ns.unsigned_abs());
    stored.map(|stored| stored.value)
}

fn stated(alerts: Alerts) -> Option<Alerts> {
    (alerts.stated != 0).then_some(alerts)
}

/// Stores a value; returns the value if it is stated and another one than before.
fn changed<T: Copy + Default + PartialEq>(stored: &mut T, value: T) -> T {
    let is_new = value != T::default() && value != *stored;
    if is_new {
        *stored = value;
    }
    if is_new { value } else { T::default() }
}
