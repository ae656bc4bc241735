//! Meaning of a single frame.
//!
//! Sources: ICAO Annex 10 volume IV (formats), ICAO Doc 9871 and RTCA DO-260B with its predecessors (messages of
//! extended squitters, versions 0 to 2). Bits are numbered from 1, as there.
//!
//! Limits: registers in replies (formats 20 and 21) are not read, since nothing in the reply names the register. An
//! airspeed is not a ground speed, and is not used. Below one knot, version 2 divides the movement on the ground into
//! other steps than versions 0 and 1; the difference is below 0.15 kn. Heights of types 20 to 22 are read in the coding
//! of types 9 to 18, as DO-260 defines both in one paragraph; some descriptions have metres instead.

use messages::Callsign;
use observations::{Alerts, Emergency, TargetCategory};

use super::altitude::{M_PER_FT, altitude_ft, mode_3a};
use super::cpr::CprPosition;
use super::frame::ModeSFrame;
use super::refusal::ModeSRefusal;
use crate::observation::items;

const MPS_PER_KT: f64 = 1852.0 / 3600.0;
/// Greatest code of an interrogator in an all-call reply: a surveillance identifier of 63.
const INTERROGATOR_MAX: u32 = 79;

/// Who has sent an extended squitter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ModeSOrigin {
    /// The aircraft or vehicle itself.
    #[default]
    Own,
    /// A ground station, about an aircraft that its sensors see (TIS-B).
    TisB,
    /// A ground station that repeats what the aircraft sent over another data link (ADS-R).
    Rebroadcast,
}

/// Values of a single frame; what is `None`, unknown or unstated is not in the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModeSMessage {
    /// 24-bit address.
    pub address: u32,
    /// Whether the address is what the checksum leaves, and thus right only if an aircraft has it.
    pub is_reply: bool,
    /// Who has sent the message.
    pub origin: ModeSOrigin,
    /// Whether the address is not the aircraft's own.
    pub is_anonymous: bool,
    /// Call sign, padded with blanks.
    pub callsign: Option<Callsign>,
    /// Category.
    pub category: TargetCategory,
    /// Position in compact form.
    pub position: Option<CprPosition>,
    /// Type of a position, 5 to 22.
    pub position_type: u8,
    /// Bit B of the supplement to a position's integrity category.
    pub has_supplement_b: bool,
    /// Altitude in the standard atmosphere, metres.
    pub altitude_m: Option<f64>,
    /// Height above the ellipsoid, metres.
    pub ellipsoid_height_m: Option<f64>,
    /// Ground speed, metres per second.
    pub ground_speed_mps: Option<f64>,
    /// Direction of motion over ground, on the ground possibly of the aircraft's nose; radians clockwise from north.
    pub track_rad: Option<f64>,
    /// Category of the accuracy of the velocity (NACv or NUCr), 0 to 7.
    pub velocity_accuracy: Option<u8>,
    /// Rate of climb, metres per second.
    pub vertical_rate_mps: Option<f64>,
    /// Mode 3/A code.
    pub mode_3a: Option<u16>,
    /// Alerts about code and identification.
    pub transponder_alerts: Alerts,
    /// Alert of an emergency.
    pub emergency_alerts: Alerts,
    /// Alert of a resolution advisory.
    pub advisory_alerts: Alerts,
    /// Emergency.
    pub emergency: Emergency,
    /// Altitude selected at the control panel of the autopilot, metres in the standard atmosphere.
    pub selected_altitude_m: Option<f64>,
    /// Version of the aircraft's equipment, 0 to 7.
    pub version: Option<u8>,
    /// Category of the accuracy (NACp, 0 to 15) and level of the integrity (SIL, 0 to 3) of positions.
    pub accuracy: Option<(u8, u8)>,
    /// Bits A and C of the supplement to the integrity category of positions.
    pub supplements: Option<[bool; 2]>,
    /// Whether directions on the ground are from magnetic north.
    pub is_magnetic: Option<bool>,
}

impl ModeSMessage {
    /// Reads a frame; `None` if the frame is right, and of a kind that is not used.
    ///
    /// # Errors
    /// [`ModeSRefusal::Length`] or [`ModeSRefusal::Parity`].
    pub fn read(frame: &ModeSFrame) -> Result<Option<Self>, ModeSRefusal> {
        if !frame.has_length_of_format() {
            return Err(ModeSRefusal::Length);
        }
        let syndrome = frame.syndrome();
        let most = match frame.format() {
            0 | 4 | 5 | 16 | 20 | 21 => return Ok(Some(reply(frame, syndrome))),
            11 => INTERROGATOR_MAX,
            17 | 18 => 0,
            _ => return Ok(None),
        };
        if syndrome > most {
            return Err(ModeSRefusal::Parity);
        }
        let message = Self {
            address: frame.field(9, 32) as u32,
            ..Self::default()
        };
        let (origin, is_anonymous) = match (frame.format(), frame.field(6, 8)) {
            (11, _) => return Ok(Some(message)),
            (17, _) | (18, 0) => (ModeSOrigin::Own, false),
            (_, 1) => (ModeSOrigin::Own, true),
            (_, 2) => (ModeSOrigin::TisB, false),
            (_, 5) => (ModeSOrigin::TisB, true),
            (_, 6) => (ModeSOrigin::Rebroadcast, false),
            // Coarse positions, management of the service, and reserved formats.
            _ => return Ok(None),
        };
        let message = Self {
            origin,
            is_anonymous,
            ..message
        };
        Ok(message.with_squitter(frame))
    }

    /// Adds what an extended squitter says; `None` for types that are not used.
    fn with_squitter(mut self, frame: &ModeSFrame) -> Option<Self> {
        let kind = frame.message(1, 5) as u8;
        let subtype = frame.message(6, 8);
        if self.origin != ModeSOrigin::Own
            && let Some(place) = foreign_address_place(kind)
        {
            self.is_anonymous |= frame.message(place, place) == 1;
        }
        match (kind, subtype) {
            (1..=4, _) => {
                self.category = category(kind, subtype);
                self.callsign = items::callsign(frame.message(9, 56));
            }
            (5..=8, _) => self.read_surface_position(frame, kind),
            (0 | 9..=18 | 20..=22, _) => self.read_airborne_position(frame, kind),
            (19, 1..=4) => self.read_velocity(frame, subtype),
            (28, 1) => {
                let code = frame.message(9, 11) as u8;
                self.emergency = Emergency::from_code(code + 1).filter(|_| code < 7).unwrap_or_default();
                self.emergency_alerts = items::alerts_of_emergency(Some(code));
                self.mode_3a = Some(mode_3a(frame.message(12, 24) as u16));
            }
            (28, 2) => self.advisory_alerts = items::alerts_of_advisory(&frame.message_octets()),
            // The subtype has two bits here.
            (29, 2 | 3) => self.read_target_state(frame),
            (31, 0 | 1) => self.read_status(frame, subtype == 1),
            _ => return None,
        }
        Some(self)
    }

    fn read_surface_position(&mut self, frame: &ModeSFrame, kind: u8) {
        self.read_position(frame, kind);
        self.ground_speed_mps = movement_kt(frame.message(6, 12) as u8).map(|speed| speed * MPS_PER_KT);
        let track = frame.message(14, 20) as f64 * 360.0 / 128.0;
        self.track_rad = (frame.message(13, 13) == 1).then(|| track.to_radians());
    }

    fn read_airborne_position(&mut self, frame: &ModeSFrame, kind: u8) {
        if kind != 0 {
            self.read_position(frame, kind);
        }
        self.has_supplement_b = self.origin == ModeSOrigin::Own && frame.message(8, 8) == 1;
        self.transponder_alerts = items::alerts_of_surveillance_status(frame.message(6, 7) as u8);
        // The code without M.
        let code = frame.message(9, 14) << 7 | frame.message(15, 20);
        let height_m = altitude_ft(code as u16).map(|height| height * M_PER_FT);
        match kind {
            20.. => self.ellipsoid_height_m = height_m,
            _ => self.altitude_m = height_m,
        }
    }

    fn read_position(&mut self, frame: &ModeSFrame, kind: u8) {
        self.position_type = kind;
        self.position = Some(CprPosition {
            is_surface: kind < 9,
            is_odd: frame.message(22, 22) == 1,
            latitude: frame.message(23, 39) as u32,
            longitude: frame.message(40, 56) as u32,
        });
    }

    fn read_velocity(&mut self, frame: &ModeSFrame, subtype: u64) {
        // Subtypes 2 and 4 are for supersonic aircraft.
        let step = if subtype.is_multiple_of(2) { 4.0 } else { 1.0 };
        let signed = |sign: usize, first: usize, last: usize, step: f64| {
            let value = frame.message(first, last);
            let is_negative = frame.message(sign, sign) == 1;
            let size = step * (value as f64 - 1.0);
            (value != 0).then_some(if is_negative { -size } else { size })
        };
        let components = signed(14, 15, 24, step).zip(signed(25, 26, 35, step));
        if let Some((east, north)) = components.filter(|_| subtype <= 2) {
            self.ground_speed_mps = Some(east.hypot(north) * MPS_PER_KT);
            self.track_rad = Some(east.atan2(north).rem_euclid(std::f64::consts::TAU));
            self.velocity_accuracy = Some(frame.message(11, 13) as u8);
        }
        self.vertical_rate_mps = signed(37, 38, 46, 64.0).map(|rate| rate * M_PER_FT / 60.0);
    }

    /// Target state and status of version 2.
    fn read_target_state(&mut self, frame: &ModeSFrame) {
        self.version = Some(2);
        self.accuracy = Some((frame.message(40, 43) as u8, frame.message(45, 46) as u8));
        let (by_flight_plan, altitude) = (frame.message(9, 9) == 1, frame.message(10, 20));
        let is_selected = altitude != 0 && !by_flight_plan;
        self.selected_altitude_m = is_selected.then_some((altitude as f64 - 1.0) * 32.0 * M_PER_FT);
    }

    /// Operational status.
    fn read_status(&mut self, frame: &ModeSFrame, is_surface: bool) {
        let version = frame.message(41, 43) as u8;
        self.version = Some(version);
        if version == 0 {
            return;
        }
        self.accuracy = Some((frame.message(45, 48) as u8, frame.message(51, 52) as u8));
        let has_surface_items = is_surface && version > 1;
        self.supplements = Some([
            frame.message(44, 44) == 1,
            has_surface_items && frame.message(20, 20) == 1,
        ]);
        if has_surface_items {
            self.velocity_accuracy = Some(frame.message(17, 19) as u8);
        }
        // The direction is that of the nose (bit 53), and magnetic (bit 54).
        self.is_magnetic = is_surface.then(|| frame.message(53, 54) == 0b11);
    }
}

/// Reply of an aircraft whose address the checksum contains.
fn reply(frame: &ModeSFrame, address: u32) -> ModeSMessage {
    let code = frame.field(20, 32) as u16;
    let is_identity = matches!(frame.format(), 5 | 21);
    let has_status = !matches!(frame.format(), 0 | 16);
    ModeSMessage {
        address,
        is_reply: true,
        altitude_m: altitude_ft(code)
            .map(|height| height * M_PER_FT)
            .filter(|_| !is_identity),
        mode_3a: is_identity.then(|| mode_3a(code)),
        transponder_alerts: items::flight_status(has_status.then(|| frame.field(6, 8) as u8)).0,
        ..ModeSMessage::default()
    }
}

/// Place of the bit by which ground stations mark an address that is not the aircraft's own (IMF), by type.
fn foreign_address_place(kind: u8) -> Option<usize> {
    match kind {
        5..=8 => Some(21),
        0 | 9..=18 | 20..=22 => Some(8),
        19 => Some(9),
        28 | 31 => Some(56),
        29 => Some(51),
        _ => None,
    }
}

/// Category by the set (types 1 to 4: D to A) and the number in it.
fn category(kind: u8, number: u64) -> TargetCategory {
    match (kind, number) {
        (4, 1) => TargetCategory::Light,
        (4, 2) => TargetCategory::Small,
        (4, 3) => TargetCategory::Large,
        (4, 4) => TargetCategory::HighVortex,
        (4, 5) => TargetCategory::Heavy,
        (4, 6) => TargetCategory::HighPerformance,
        (4, 7) => TargetCategory::Rotorcraft,
        (3, 1) => TargetCategory::Glider,
        (3, 2) => TargetCategory::LighterThanAir,
        (3, 3) => TargetCategory::Parachutist,
        (3, 4) => TargetCategory::Ultralight,
        (3, 6) => TargetCategory::Unmanned,
        (3, 7) => TargetCategory::Space,
        (2, 1) => TargetCategory::EmergencyVehicle,
        (2, 2) => TargetCategory::ServiceVehicle,
        (2, 3..=5) => TargetCategory::Obstacle,
        _ => TargetCategory::Unknown,
    }
}

/// Ground speed of a movement on the ground, knots: the lower end of its step.
fn movement_kt(movement: u8) -> Option<f64> {
    let (first, from, step) = match movement {
        1 => (1, 0.0, 0.0),
        2..=8 => (2, 0.125, 0.125),
        9..=12 => (9, 1.0, 0.25),
        13..=38 => (13, 2.0, 0.5),
        39..=93 => (39, 15.0, 1.0),
        94..=108 => (94, 70.0, 2.0),
        109..=123 => (109, 100.0, 5.0),
        124 => (124, 175.0, 0.0),
        // Not stated, or reserved.
        _ => return None,
    };
    Some(from + f64::from(movement - first) * step)
}
