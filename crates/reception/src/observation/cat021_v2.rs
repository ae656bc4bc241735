//! CAT021 from ed 2 on: ADS-B.
//!
//! Three generations of aircraft say in three ways how well they know where they are: an uncertainty category of the
//! position (version 0), or a category of its accuracy beside one of its integrity (versions 1 and 2). The integrity's
//! radius is one that the error exceeds once in ten million flight hours; as an error with 95 % probability it is far
//! too large, and used only where there is nothing else.

use super::navigation::{covariance_of_velocity_category, radius_of_nacp, radius_of_nic, radius_of_nucp};
use super::*;
use asterix::typed::cat021_v2::{FineTime, QualityIndicators, SurveillanceStatus, TargetReport, TargetStatus};
use frames::time::NS_PER_S;

/// Seconds in a day.
const DAY_S: i64 = 86_400;

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    TargetReport::read(record).map(|report| Reading::Target(of(&report)))
}

fn of(report: &TargetReport) -> Observation {
    let descriptor = report.descriptor;
    Observation {
        sac_sic: sac_sic(report.source),
        time_of_day_ns: time_of_day_ns(report),
        field_monitor: descriptor.is_some_and(|descriptor| descriptor.field_monitor),
        test: descriptor.is_some_and(|descriptor| descriptor.simulated || descriptor.test),
        suspect: descriptor.is_some_and(|descriptor| {
            descriptor.position_check_failed
                || descriptor.decoding_failed
                || descriptor.jumped
                || descriptor.range_check_failed
        }),
        track_number: report.track_number.map(u32::from).or(report.address),
        identity: identity(report.mode_3a, report.address, report.callsign),
        geodetic: report.geodetic_position.map(geodetic),
        velocity: report.ground_vector.map(from_polar),
        axes: Axes::Target,
        velocity_covariance: report
            .quality
            .and_then(|quality| covariance_of_velocity_category(quality.velocity_category)),
        pressure_altitude_m: report.pressure_altitude_m,
        geometric_height_m: report.geometric_height_m,
        vertical_rate_mps: report.barometric_rate_m_s.or(report.geometric_rate_m_s),
        on_ground: descriptor.is_some_and(|descriptor| descriptor.ground_bit),
        alerts: report.target_status.map_or(0, alerts_of_status)
            | when(report.advised == Some(true), alert_bits::RESOLUTION_ADVISORY)
            | alerts_of_advisory(report.resolution_advisory),
        state: TrackState::Confirmed,
        quality: report
            .quality
            .map_or(Quality::Unstated, |quality| position_quality(report.version, quality)),
        ..Observation::default()
    }
}

/// When the position applied, else when it was received, else the same of the velocity, which is as new within a
/// second, else when the report was sent.
fn time_of_day_ns(report: &TargetReport) -> Option<i64> {
    let position = (report.position_reception, report.position_reception_fraction);
    let velocity = (report.velocity_reception, report.velocity_reception_fraction);
    report
        .position_time
        .map(nanoseconds)
        .or_else(|| Some(reception_ns(position.0?, position.1)))
        .or(report.velocity_time.map(nanoseconds))
        .or_else(|| Some(reception_ns(velocity.0?, velocity.1)))
        .or(report.transmission.map(nanoseconds))
}

/// The time of a reception, with the fraction of its second where that was sent.
fn reception_ns(coarse: TimeOfDay, fine: Option<FineTime>) -> i64 {
    let second = i64::from(coarse.ticks / TimeOfDay::TICKS_PER_S);
    match fine.and_then(|fine| Some((i64::from(fine.second?), fine.fraction))) {
        Some((step, fraction)) if second < DAY_S => {
            let second = (second + step).rem_euclid(DAY_S);
            second * NS_PER_S + ((i64::from(fraction) * NS_PER_S) >> 30)
        }
        _ => nanoseconds(coarse),
    }
}

fn alerts_of_status(status: TargetStatus) -> u8 {
    alerts_of_emergency(status.emergency)
        | when(status.military_emergency, alert_bits::EMERGENCY)
        | match status.surveillance {
            SurveillanceStatus::None => 0,
            SurveillanceStatus::PermanentAlert | SurveillanceStatus::TemporaryAlert => alert_bits::TRANSPONDER_ALERT,
            SurveillanceStatus::SpecialIdentification => alert_bits::SPECIAL_IDENTIFICATION,
        }
}

/// An aircraft that sends no version is of version 0.
fn position_quality(version: Option<u8>, quality: QualityIndicators) -> Quality {
    match (version.unwrap_or(0), quality.accuracy_category) {
        (0, _) => radius_of_nucp(quality.integrity_category),
        (_, Some(category)) => radius_of_nacp(category),
        (_, None) => radius_of_nic(quality.integrity_category),
    }
}
