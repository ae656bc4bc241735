//! A system track as subscribers are told of it.

use messages::{AXES, Contribution, NO_SOURCE, SensorTrack, StageTimes, SystemTrack, contribution_bits};

use crate::explanation::Sink;
use crate::outlet::Outlet;
use crate::rules::Share;
use crate::settings::Settings;
use crate::system_tracks::SystemSlot;
use crate::tracks::Tracks;
use crate::weighing::Weighed;

/// Publishes that the life of a system track has changed without a report. At uniform times, the next refresh shows it.
pub(crate) fn publish_change<S: Sink>(
    settings: &Settings,
    tracks: &mut Tracks,
    slot: SystemSlot,
    now_ns: i64,
    out: &mut Outlet<'_, S>,
) {
    if settings.refresh_s.is_none() {
        publish_extrapolated(settings, tracks, slot, now_ns, out);
    }
}

/// Publishes the state extrapolated to `now_ns`.
pub(crate) fn publish_extrapolated<S: Sink>(
    settings: &Settings,
    tracks: &mut Tracks,
    slot: SystemSlot,
    now_ns: i64,
    out: &mut Outlet<'_, S>,
) {
    let entry = tracks.systems.get_mut(slot);
    entry.state = entry
        .state
        .at(now_ns.max(entry.state.time_ns), settings.process_noise_m2ps3);
    out.track(&system_track(settings, tracks, slot, None, None));
}

/// The message about a system track that `cause` changed, to which the contributions `weighed` led; without them, one
/// without contributions.
pub(crate) fn system_track(
    settings: &Settings,
    tracks: &Tracks,
    slot: SystemSlot,
    cause: Option<&SensorTrack>,
    weighed: Option<&Weighed>,
) -> SystemTrack {
    let entry = tracks.systems.get(slot);
    let (members, shares, candidates) = weighed.map_or((&[][..], &[][..], &[][..]), |weighed| {
        (weighed.members(), weighed.shares(), weighed.candidates())
    });
    let mut message = SystemTrack {
        reference_time_ns: entry.state.time_ns,
        time_of_measurement_ns: cause.map_or(entry.state.time_ns, |report| report.time_of_measurement_ns),
        stages: cause.map_or(StageTimes::default(), |report| report.stages),
        track_number: entry.number,
        trigger_source: cause.map_or(NO_SOURCE, |report| report.source),
        selected_source: NO_SOURCE,
        identity: entry.identity,
        position_m: entry.state.position_m,
        velocity_mps: entry.state.velocity_mps,
        covariance: entry.state.covariance,
        source_count: members.len() as u16,
        contribution_count: members.len() as u16,
        state: entry.life as u8,
        height_valid: u8::from(entry.state.has_height),
        rule: settings.rule.name.0.code(),
        alerts: entry.alerts,
        merged_into: entry.merged_into,
        on_ground: u8::from(entry.on_ground),
        kind: entry.description.kind as u8,
        members: entry.description.members,
        target_type: entry.description.target_type,
        ..SystemTrack::default()
    };
    let flag = |is_set: bool, flag| if is_set { flag } else { 0 };
    let mut heaviest = 0.0;
    for (index, share) in shares.iter().enumerate() {
        let member = tracks.sensors.get(members[index]);
        let weight = weight(share);
        let is_scored = share.accuracy.is_finite();
        let is_fresh = !candidates[index].stale;
        message.contributions[index] = Contribution {
            time_of_measurement_ns: member.time_ns,
            track_number: member.track_number,
            source: member.source,
            flags: flag(is_fresh, contribution_bits::FRESH) | flag(is_scored, contribution_bits::SCORED),
            weight,
            accuracy: if is_scored { share.accuracy } else { f64::NAN },
            sensor_uid: settings.sources[usize::from(member.source)].sensor_uid,
            ..Contribution::default()
        };
        if weight > heaviest {
            heaviest = weight;
            message.selected_source = member.source;
        }
    }
    message
}

/// The mean over the axes of a contribution's weight.
pub(crate) fn weight(share: &Share) -> f64 {
    share.weight.iter().sum::<f64>() / AXES as f64
}
