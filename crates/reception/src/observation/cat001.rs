//! CAT001: radar, before CAT048.
//!
//! What the plane of a track's x and y is, nothing says. It is taken for the radar's own, uncorrected: a radar that
//! corrects for slant range is one that could say so, and sends CAT048. Plots have no number, and no address.

use super::*;
use asterix::typed::cat001::{Detection, TargetReport};
use frames::time::NS_PER_S;

pub(super) fn read(record: &Record<'_>) -> Option<Reading> {
    TargetReport::read(record).map(|report| Reading::Target(of(&report)))
}

fn of(report: &TargetReport) -> Observation {
    let descriptor = report.descriptor;
    Observation {
        sac_sic: sac_sic(report.source),
        truncated_time_ns: report
            .time
            .map(|time| i64::from(time.ticks) * NS_PER_S / i64::from(TimeOfDay::TICKS_PER_S)),
        field_monitor: descriptor.is_some_and(|descriptor| descriptor.field_monitor),
        test: descriptor.is_some_and(|descriptor| descriptor.simulated || descriptor.test),
        track_number: report.track_number.map(u32::from),
        plot: descriptor.is_none_or(|descriptor| !descriptor.is_track),
        identity: identity(code(report.mode_3a), None, None),
        cartesian: report.cartesian_position.map(cartesian),
        plane: Plane::Slant,
        slant_polar: report.slant_position.map(polar),
        velocity: report.polar_velocity.map(from_polar),
        pressure_altitude_m: altitude(report.flight_level),
        alerts: descriptor.map_or(0, |descriptor| {
            when(descriptor.special_identification, alert_bits::SPECIAL_IDENTIFICATION)
                | when(descriptor.military_emergency, alert_bits::EMERGENCY)
                | alerts_of_emergency(descriptor.emergency)
        }),
        state: state(report),
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
