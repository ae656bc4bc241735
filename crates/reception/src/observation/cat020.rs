//! CAT020: multilateration.

use super::*;
use asterix::typed::cat020::TargetReport;

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    TargetReport::read(record).map(|report| Reading::Target(of(&report)))
}

fn of(report: &TargetReport) -> Observation {
    let callsign = report.identification.and_then(|identification| identification.callsign);
    let descriptor = report.descriptor;
    let status = report.transponder.map(|transponder| transponder.flight_status);
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
        geodetic: report.geodetic_position.map(geodetic),
        velocity: report.cartesian_velocity.map(components),
        // Systems fill the flight level with 0 where they have none, so a level of exactly 0 says nothing.
        pressure_altitude_m: altitude(report.flight_level).filter(|altitude| *altitude != 0.0),
        geometric_height_m: report.measured_height_m.or(report.geometric_height_m),
        on_ground: descriptor.is_some_and(|descriptor| descriptor.ground_bit)
            || status.is_some_and(|status| status.on_ground == Some(true)),
        alerts: when(identified, alert_bits::SPECIAL_IDENTIFICATION)
            | status.map_or(0, alerts_of_flight_status)
            | alerts_of_advisory(report.resolution_advisory),
        state: state(report.track_status),
        quality: quality(report),
        ..Observation::default()
    }
}

/// SDP where it says something, else the dilution of precision; systems send zeros for "not given".
fn quality(report: &TargetReport) -> Quality {
    let Some(accuracy) = report.position_accuracy else {
        return Quality::Unstated;
    };
    let stated = accuracy.deviation.map(|deviation| {
        let sigma = [deviation.sigma_x_m, deviation.sigma_y_m];
        covariance(sigma, deviation.correlation_xy * sigma[0] * sigma[1])
    });
    match (stated, accuracy.dilution) {
        (Some(stated @ Quality::Covariance(_)), _) => stated,
        (_, Some(dilution)) if dilution.xy > 0.0 => Quality::Dilution(dilution.xy),
        _ => Quality::Unstated,
    }
}
