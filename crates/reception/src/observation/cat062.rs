//! CAT062: tracks of another surveillance data processing system.
//!
//! The geographic position is used where there is one, x and y otherwise: their plane is a map around a place that the
//! system keeps to itself, and whoever wants them must configure that place as the source's. A state made with the
//! flight plan alone, or coasting, is the system's extrapolation and no observation.

use super::*;
use asterix::typed::cat062::{Accuracy, SystemTrackStatus, TrackMessage};

/// Mean radius of the earth, metres.
const EARTH_RADIUS_M: f64 = 6_371_000.0;

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    TrackMessage::read(record).map(|track| Reading::Target(of(&track)))
}

fn of(track: &TrackMessage) -> Observation {
    let (status, aircraft) = (track.track_status, &track.aircraft);
    let code = track.mode_3a.filter(|code| !code.not_validated && !code.garbled);
    let callsign = || track.identification.and_then(|identification| identification.callsign);
    let flight = aircraft.transponder.map(|transponder| transponder.flight_status);
    let (in_standard, above_sea) = match track.barometric_altitude {
        Some(altitude) if altitude.corrected => (None, Some(altitude.altitude_m)),
        Some(altitude) => (Some(altitude.altitude_m), None),
        None => (None, None),
    };
    Observation {
        sac_sic: sac_sic(track.source),
        time_of_day_ns: track.time_of_day.map(nanoseconds),
        test: status.is_some_and(|status| status.simulated),
        track_number: track.track_number.map(u32::from),
        identity: identity(
            code.map(|code| code.code),
            aircraft.address,
            aircraft.callsign.or_else(callsign),
        ),
        cartesian: track
            .cartesian_position
            .filter(|_| track.geodetic_position.is_none())
            .map(cartesian),
        plane: Plane::Stereographic,
        geodetic: track.geodetic_position.map(geodetic),
        velocity: track.cartesian_velocity.map(components),
        axes: Axes::Target,
        velocity_covariance: track.accuracy.sigma_velocity_m_s.and_then(variances),
        pressure_altitude_m: in_standard.or(track.measured_altitude_m),
        geometric_height_m: track.geometric_altitude_m.or(above_sea),
        vertical_rate_mps: track
            .vertical_rate_m_s
            .or(aircraft.barometric_rate_m_s)
            .or(aircraft.geometric_rate_m_s),
        on_ground: status.is_some_and(|status| status.on_surface)
            || aircraft.ads_b.is_some_and(|said| said.ground_bit)
            || flight.is_some_and(|flight| flight.on_ground == Some(true)),
        alerts: status.map_or(0, alerts_of_status)
            | aircraft.ads_b.map_or(0, |said| alerts_of_emergency(said.emergency))
            | flight.map_or(0, alerts_of_flight_status)
            | alerts_of_advisory(aircraft.resolution_advisory),
        state: status.map_or(TrackState::Confirmed, state),
        quality: quality(track),
        ..Observation::default()
    }
}

fn state(status: SystemTrackStatus) -> TrackState {
    match status {
        status if status.ended => TrackState::Terminated,
        status if status.tentative => TrackState::Tentative,
        status if status.coasting || status.from_flight_plan => TrackState::Coasted,
        _ => TrackState::Confirmed,
    }
}

fn alerts_of_status(status: SystemTrackStatus) -> u8 {
    when(status.special_identification, alert_bits::SPECIAL_IDENTIFICATION)
        | when(status.military_emergency, alert_bits::EMERGENCY)
        | alerts_of_emergency(status.emergency)
}

/// Of x and y with their covariance; else of latitude and longitude, as distances.
fn quality(track: &TrackMessage) -> Quality {
    let Accuracy {
        sigma_position_m,
        covariance_xy_m2,
        sigma_geodetic_rad,
        ..
    } = track.accuracy;
    if let Some(sigma) = sigma_position_m {
        return covariance(sigma, covariance_xy_m2.unwrap_or(0.0));
    }
    match (sigma_geodetic_rad, track.geodetic_position) {
        (Some([latitude, longitude]), Some(position)) => {
            let east_m = longitude * EARTH_RADIUS_M * position.latitude_rad.cos();
            covariance([east_m, latitude * EARTH_RADIUS_M], 0.0)
        }
        _ => Quality::Unstated,
    }
}

fn variances([x, y]: [f64; 2]) -> Option<[f64; 3]> {
    (x > 0.0 && y > 0.0).then_some([x * x, 0.0, y * y])
}
