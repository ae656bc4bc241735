//! CAT010: surface movement radar and multilateration of an airport.

use super::*;
use asterix::typed::cat010::{MessageType, ServiceMessage, TargetReport};

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    if let Some(report) = TargetReport::read(record) {
        return Some(Reading::Target(of(&report)));
    }
    ServiceMessage::read(record).map(|message| {
        let cycle = message.message_type == MessageType::StartOfUpdateCycle;
        turn(message.time_of_day, cycle)
    })
}

fn of(report: &TargetReport) -> Observation {
    let callsign = report.identification.and_then(|identification| identification.callsign);
    let descriptor = report.descriptor;
    let identified = descriptor.is_some_and(|descriptor| descriptor.special_identification);
    Observation {
        sac_sic: sac_sic(report.source),
        time_of_day_ns: report.time_of_day.map(nanoseconds),
        field_monitor: descriptor.is_some_and(|descriptor| descriptor.field_monitor),
        test: descriptor.is_some_and(|descriptor| descriptor.simulated || descriptor.test),
        track_number: report.track_number.map(u32::from).or(report.address),
        plot: report.track_number.is_none(),
        identity: identity(code(report.mode_3a), report.address, callsign),
        cartesian: report.cartesian_position.map(cartesian),
        // At an airport the range along the ground is that to the target.
        polar: report.polar_position.map(polar),
        geodetic: report.geodetic_position.map(geodetic),
        velocity: report
            .cartesian_velocity
            .map(components)
            .or(report.polar_velocity.map(from_polar)),
        pressure_altitude_m: altitude(report.flight_level),
        geometric_height_m: report.measured_height_m,
        on_ground: descriptor.is_some_and(|descriptor| descriptor.ground_bit),
        alerts: when(identified, alert_bits::SPECIAL_IDENTIFICATION),
        state: state(report.track_status),
        quality: report.position_deviation.map_or(Quality::Unstated, |deviation| {
            covariance([deviation.sigma_x_m, deviation.sigma_y_m], deviation.covariance_xy_m2)
        }),
        ..Observation::default()
    }
}
