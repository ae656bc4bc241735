//! State of an aircraft: keys of JSON to values.

use std::ops::RangeInclusive;

use frames::time::NS_PER_DAY;
use messages::{Identity, IdentityText, TrackState, alert_bits};
use observations::{Alerts, Axes, Emergency, Observation, Quality, Statement, TargetCategory};
use serde::Deserialize;

use super::origin::Origin;
use super::reason::{Read, ReadsbReason};
use crate::observation::items::{alerts_of_emergency, components};
use crate::observation::navigation::{
    Integrity, SQUITTER_STEP_MPS, covariance_of_velocity_category, covariance_with_step, quality_of_accuracy,
    squitter_step_m, with_step,
};
use crate::sbs::{ALTITUDE_FT, M_PER_FT, MPS_PER_KT, SPEED_KT, VERTICAL_RATE_FTPMIN, callsign};
use crate::target_message::Refusal;

/// Bit of a track's number for an address that is not of ICAO: the same digits may be the address of an aircraft.
const FOREIGN_ADDRESS: u32 = 1 << 24;
/// Mark of an address that is not of ICAO.
const FOREIGN_MARK: char = '~';

/// Keys of a state that are used. Older programs have some under other names.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct AircraftState {
    pub(super) hex: Option<String>,
    #[serde(rename = "type")]
    pub(super) kind: Option<String>,
    pub(super) mlat: Vec<String>,
    pub(super) tisb: Vec<String>,
    pub(super) seen: Option<f64>,
    pub(super) seen_pos: Option<f64>,
    pub(super) lat: Option<f64>,
    pub(super) lon: Option<f64>,
    #[serde(alias = "altitude")]
    pub(super) alt_baro: Option<Altitude>,
    pub(super) alt_geom: Option<f64>,
    #[serde(alias = "speed")]
    pub(super) gs: Option<f64>,
    pub(super) track: Option<f64>,
    #[serde(alias = "vert_rate")]
    pub(super) baro_rate: Option<f64>,
    pub(super) geom_rate: Option<f64>,
    pub(super) flight: Option<String>,
    pub(super) squawk: Option<String>,
    pub(super) emergency: Option<String>,
    pub(super) alert: Option<u8>,
    pub(super) spi: Option<u8>,
    pub(super) nic: Option<u8>,
    pub(super) sil: Option<u8>,
    pub(super) nac_p: Option<u8>,
    pub(super) nac_v: Option<u8>,
    pub(super) category: Option<String>,
    pub(super) nav_altitude_mcp: Option<f64>,
}

/// Pressure altitude in feet, or `ground`.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum Altitude {
    Feet(f64),
    Word(String),
}

impl AircraftState {
    /// Number of the track, and the address if it is one of ICAO.
    pub(super) fn number(&self) -> Read<(u32, Option<u32>)> {
        let text = self.hex.as_deref().unwrap_or_default();
        let digits = text.strip_prefix(FOREIGN_MARK);
        let hex = digits.unwrap_or(text);
        let is_whole = hex.len() == IdentityText::ADDRESS.digits;
        let number = IdentityText::ADDRESS.read(hex).filter(|_| is_whole);
        let number = number.ok_or_else(|| Refusal::new(ReadsbReason::Address, "hex", text))?;
        Ok(match digits {
            Some(_) => (number | FOREIGN_ADDRESS, None),
            None => (number, Some(number)),
        })
    }

    pub(super) fn origin(&self) -> Origin {
        Origin::of(self.kind.as_deref(), &self.mlat, &self.tisb)
    }

    /// Latitude and longitude, radians.
    pub(super) fn position(&self) -> Read<Option<[f64; 2]>> {
        let reason = ReadsbReason::Position;
        let latitude = within(reason, "lat", self.lat, &(-90.0..=90.0))?;
        let longitude = within(reason, "lon", self.lon, &(-180.0..=180.0))?;
        match (latitude, longitude) {
            (None, None) => Ok(None),
            (Some(latitude), Some(longitude)) => Ok(Some([latitude.to_radians(), longitude.to_radians()])),
            (Some(alone), None) => Err(Refusal::new(reason, "lat without lon", alone)),
            (None, Some(alone)) => Err(Refusal::new(reason, "lon without lat", alone)),
        }
    }

    /// The observation at `time_ns`; `has_motion` if altitude and velocity are of that time.
    pub(super) fn observation(&self, time_ns: i64, position: Option<[f64; 2]>, has_motion: bool) -> Read<Observation> {
        let (number, address) = self.number()?;
        let (altitude_m, on_ground) = self.altitude()?;
        let geometric_m = within(ReadsbReason::Altitude, "alt_geom", self.alt_geom, &ALTITUDE_FT)?;
        let geometric_m = geometric_m
            .map(|feet| feet * M_PER_FT)
            .filter(|_| has_motion && !on_ground);
        let velocity = self.velocity()?;
        let rate = within(
            ReadsbReason::VerticalRate,
            "baro_rate",
            self.baro_rate,
            &VERTICAL_RATE_FTPMIN,
        )?;
        let geometric_rate = within(
            ReadsbReason::VerticalRate,
            "geom_rate",
            self.geom_rate,
            &VERTICAL_RATE_FTPMIN,
        )?;
        let rate_mps = rate.or(geometric_rate).map(|rate| rate * M_PER_FT / 60.0);
        // Categories are the transponder's own: they state nothing about results of multilateration.
        let is_stated = self.origin() != Origin::Multilateration;
        let velocity_category = self.nac_v.filter(|_| is_stated);
        let velocity_covariance = velocity_category.and_then(covariance_of_velocity_category);
        Ok(Observation {
            time_of_day_ns: Some(time_ns.rem_euclid(NS_PER_DAY)),
            track_number: Some(number),
            identity: self.identity(address)?,
            geodetic: position,
            velocity: velocity.filter(|_| has_motion),
            axes: Axes::Target,
            velocity_covariance: velocity_covariance.map(|stated| covariance_with_step(stated, SQUITTER_STEP_MPS)),
            pressure_altitude_m: altitude_m.filter(|_| has_motion),
            geometric_height_m: geometric_m,
            ellipsoid_height_m: geometric_m,
            vertical_rate_mps: rate_mps.filter(|_| has_motion),
            on_ground,
            alerts: self.alerts(),
            state: TrackState::Confirmed,
            quality: match is_stated {
                true => with_step(self.quality(), squitter_step_m(on_ground)),
                false => Quality::Unstated,
            },
            ..Observation::default()
        })
    }

    pub(super) fn statement(&self, number: u32) -> Read<Statement> {
        let selected_ft = within(
            ReadsbReason::Altitude,
            "nav_altitude_mcp",
            self.nav_altitude_mcp,
            &ALTITUDE_FT,
        )?;
        Ok(Statement {
            track_number: number,
            category: self.category.as_deref().map_or(Ok(TargetCategory::Unknown), category)?,
            emergency: self.emergency(),
            selected_altitude_m: selected_ft.map(|feet| (feet * M_PER_FT) as f32),
            ..Statement::default()
        })
    }

    /// Pressure altitude, metres, and whether the aircraft is on the ground.
    fn altitude(&self) -> Read<(Option<f64>, bool)> {
        let reason = ReadsbReason::Altitude;
        match &self.alt_baro {
            None => Ok((None, false)),
            Some(Altitude::Word(word)) if word == "ground" => Ok((None, true)),
            Some(Altitude::Word(word)) => Err(Refusal::new(reason, "alt_baro", word)),
            Some(Altitude::Feet(feet)) => {
                let feet = within(reason, "alt_baro", Some(*feet), &ALTITUDE_FT)?;
                Ok((feet.map(|feet| feet * M_PER_FT), false))
            }
        }
    }

    /// East and north, metres per second. An aircraft at rest needs no track.
    fn velocity(&self) -> Read<Option<[f64; 2]>> {
        let speed_kt = within(ReadsbReason::Velocity, "gs", self.gs, &SPEED_KT)?;
        let track_degrees = within(ReadsbReason::Velocity, "track", self.track, &(0.0..=360.0))?;
        Ok(match (speed_kt, track_degrees) {
            (Some(0.0), _) => Some([0.0; 2]),
            (Some(speed_kt), Some(track)) => Some(components([speed_kt * MPS_PER_KT, track.to_radians()])),
            _ => None,
        })
    }

    fn identity(&self, address: Option<u32>) -> Read<Identity> {
        let mut identity = Identity::default();
        if let Some(address) = address {
            identity = identity.with_address(address);
        }
        if let Some(text) = self.flight.as_deref().map(str::trim).filter(|text| !text.is_empty()) {
            let callsign = callsign(text).ok_or_else(|| Refusal::new(ReadsbReason::Callsign, "flight", text))?;
            identity = identity.with_callsign(callsign);
        }
        if let Some(text) = self.squawk.as_deref().filter(|text| !text.is_empty()) {
            let is_whole = text.len() == IdentityText::MODE_3A.digits;
            let code = IdentityText::MODE_3A.read(text).filter(|_| is_whole);
            let code = code.ok_or_else(|| Refusal::new(ReadsbReason::Code, "squawk", text))?;
            identity = identity.with_mode_3a(code as u16);
        }
        Ok(identity)
    }

    /// Quality by the categories; programs that state none of them leave the accuracy to the configuration.
    fn quality(&self) -> Quality {
        match (self.nac_p, self.nic) {
            (None, None) => Quality::Unstated,
            (accuracy, integrity) => quality_of_accuracy(
                Integrity {
                    // A category that is not stated bounds nothing less.
                    category: integrity.unwrap_or(1),
                    level: self.sil,
                },
                accuracy,
            ),
        }
    }

    fn emergency(&self) -> Emergency {
        match self.emergency.as_deref() {
            Some("none") => Emergency::None,
            Some("general") => Emergency::General,
            Some("lifeguard") => Emergency::Medical,
            Some("minfuel") => Emergency::MinimumFuel,
            Some("nordo") => Emergency::NoCommunication,
            Some("unlawful") => Emergency::UnlawfulInterference,
            Some("downed") => Emergency::Downed,
            _ => Emergency::Unknown,
        }
    }

    fn alerts(&self) -> Alerts {
        // The numbers of ADS-B have the order of the codes.
        let emergency = self.emergency().code().checked_sub(Emergency::None.code());
        let flag = |flag: Option<u8>, bit| flag.map_or(Alerts::default(), |flag| Alerts::flag(bit, flag != 0));
        alerts_of_emergency(emergency)
            | flag(self.alert, alert_bits::TRANSPONDER_ALERT)
            | flag(self.spi, alert_bits::SPECIAL_IDENTIFICATION)
    }
}

/// A value within its range.
pub(super) fn within(
    reason: ReadsbReason,
    key: &'static str,
    value: Option<f64>,
    range: &RangeInclusive<f64>,
) -> Read<Option<f64>> {
    match value {
        Some(number) if !range.contains(&number) => Err(Refusal::new(reason, key, number)),
        _ => Ok(value),
    }
}

/// Category of an emitter by RTCA DO-260B, 2.2.3.2.5.2: a letter for the set, and a digit.
fn category(text: &str) -> Read<TargetCategory> {
    Ok(match text.as_bytes() {
        b"A1" => TargetCategory::Light,
        b"A2" => TargetCategory::Small,
        b"A3" => TargetCategory::Large,
        b"A4" => TargetCategory::HighVortex,
        b"A5" => TargetCategory::Heavy,
        b"A6" => TargetCategory::HighPerformance,
        b"A7" => TargetCategory::Rotorcraft,
        b"B1" => TargetCategory::Glider,
        b"B2" => TargetCategory::LighterThanAir,
        b"B3" => TargetCategory::Parachutist,
        b"B4" => TargetCategory::Ultralight,
        b"B6" => TargetCategory::Unmanned,
        b"B7" => TargetCategory::Space,
        b"C1" => TargetCategory::EmergencyVehicle,
        b"C2" => TargetCategory::ServiceVehicle,
        b"C3" | b"C4" | b"C5" => TargetCategory::Obstacle,
        // Nothing is stated, or the number is reserved.
        [b'A'..=b'D', b'0'..=b'7'] => TargetCategory::Unknown,
        _ => return Err(Refusal::new(ReadsbReason::Category, "category", text)),
    })
}
