//! CAT048: radar.
//!
//! A record holds up to two positions: the plot, range and azimuth as measured in this turn, and the track, x and y as
//! the radar's tracker calculated them. A plot without track number is numbered by its address, if it has one; the
//! number is then the same from turn to turn, and the plots of one aircraft are a track.

use super::*;
use asterix::typed::cat048::{Detection, TargetReport, Warnings};

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    TargetReport::read(record).map(|report| Reading::Target(of(&report)))
}

fn of(report: &TargetReport) -> Observation {
    let descriptor = report.descriptor;
    let status = report.transponder.map(|transponder| transponder.flight_status);
    let corrected = report.track_status.is_some_and(|status| status.slant_corrected);
    Observation {
        sac_sic: sac_sic(report.source),
        time_of_day_ns: report.time_of_day.map(nanoseconds),
        field_monitor: descriptor.is_some_and(|descriptor| descriptor.field_monitor),
        test: descriptor.is_some_and(|descriptor| descriptor.simulated || descriptor.test),
        track_number: report.track_number.map(u32::from).or(report.address),
        plot: report.track_number.is_none(),
        identity: identity(code(report.mode_3a), report.address, report.callsign),
        cartesian: report.cartesian_position.map(cartesian),
        plane: if corrected { Plane::Stereographic } else { Plane::Slant },
        // Beyond the range that the item can hold, it holds the largest.
        slant_polar: report
            .slant_position
            .filter(|_| !descriptor.is_some_and(|descriptor| descriptor.beyond_range))
            .map(polar),
        velocity: report.polar_velocity.map(from_polar),
        axes: Axes::Target,
        velocity_covariance: velocity_covariance(report),
        pressure_altitude_m: altitude(report.flight_level).filter(|_| !height_doubted(report.warnings)),
        geometric_height_m: report.measured_height_m,
        on_ground: status.is_some_and(|status| status.on_ground == Some(true)),
        alerts: descriptor.map_or(0, |descriptor| {
            when(descriptor.special_identification, alert_bits::SPECIAL_IDENTIFICATION)
                | when(descriptor.military_emergency, alert_bits::EMERGENCY)
        }) | status.map_or(0, alerts_of_flight_status)
            | alerts_of_advisory(report.resolution_advisory),
        state: state(report),
        quality: match report.track_quality {
            Some(quality) if report.cartesian_position.is_some() => {
                covariance([quality.sigma_x_m, quality.sigma_y_m], 0.0)
            }
            _ => Quality::Unstated,
        },
        ..Observation::default()
    }
}

fn state(report: &TargetReport) -> TrackState {
    let detected = report
        .descriptor
        .is_none_or(|descriptor| descriptor.detection != Detection::None);
    match report.track_status {
        Some(status) if status.ended => TrackState::Terminated,
        Some(status) if status.tentative => TrackState::Tentative,
        _ if !detected => TrackState::Coasted,
        _ => TrackState::Confirmed,
    }
}

fn height_doubted(warnings: Option<Warnings>) -> bool {
    warnings.is_some_and(|warnings| {
        warnings.contains(Warnings::ABNORMAL_HEIGHT) || warnings.contains(Warnings::UNDECODABLE_HEIGHT)
    })
}

/// Of speed along the track and heading across it; `None` where either is zero, which says nothing.
fn velocity_covariance(report: &TargetReport) -> Option<[f64; 3]> {
    let (velocity, quality) = (report.polar_velocity?, report.track_quality?);
    let along = quality.sigma_speed_m_s.powi(2);
    let across = (velocity.speed_m_s * quality.sigma_track_rad).powi(2);
    let (sine, cosine) = velocity.track_rad.sin_cos();
    (along > 0.0 && across > 0.0).then_some([
        along * sine * sine + across * cosine * cosine,
        (along - across) * sine * cosine,
        along * cosine * cosine + across * sine * sine,
    ])
}
