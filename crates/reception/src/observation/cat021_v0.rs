//! CAT021 before ed 1: ADS-B.

use super::navigation::{covariance_of_velocity_category, radius_of_nucp};
use super::*;
use asterix::typed::cat021_v0::TargetReport;

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    TargetReport::read(record).map(|report| Reading::Target(of(&report)))
}

fn of(report: &TargetReport) -> Observation {
    let descriptor = report.descriptor;
    let identified = descriptor.is_some_and(|descriptor| descriptor.special_identification);
    Observation {
        sac_sic: sac_sic(report.source),
        time_of_day_ns: report.time_of_day.map(nanoseconds),
        field_monitor: descriptor.is_some_and(|descriptor| descriptor.field_monitor),
        test: descriptor.is_some_and(|descriptor| descriptor.simulated || descriptor.test),
        // These editions have no track number: a transmitter is its own track.
        track_number: report.address,
        identity: identity(code(report.mode_3a), report.address, report.callsign),
        geodetic: report.geodetic_position.map(geodetic),
        velocity: report.ground_vector.map(from_polar),
        axes: Axes::Target,
        velocity_covariance: report.velocity_category.and_then(covariance_of_velocity_category),
        pressure_altitude_m: report.pressure_altitude_m,
        geometric_height_m: report.geometric_altitude_m,
        vertical_rate_mps: report.barometric_rate_m_s.or(report.geometric_rate_m_s),
        on_ground: descriptor.is_some_and(|descriptor| descriptor.ground_bit),
        alerts: when(identified, alert_bits::SPECIAL_IDENTIFICATION) | report.emergency.map_or(0, alerts_of_emergency),
        state: TrackState::Confirmed,
        quality: report
            .figure_of_merit
            .map_or(Quality::Unstated, |merit| radius_of_nucp(merit.position_category)),
        ..Observation::default()
    }
}
