//! Message of a system track for subscribers.

use messages::{
    AXES, Contribution, Movement, NO_SOURCE, SensorTrack, StageTimes, SystemTrack, TrackState, contribution_bits,
    sensor_track_bits,
};

use crate::explanation::Sink;
use crate::publish::outlet::Outlet;
use crate::publish::weighing::Weighed;
use crate::rules::Share;
use crate::settings::Settings;
use crate::settings::qnh;
use crate::tables::system_tracks::{SystemEntry, SystemSlot};
use crate::tables::tracks::Tracks;

const NS_PER_MS: i64 = 1_000_000;

/// Maximum age of a level, for a source with the period `period_ns`: two periods, and a tenth for uneven turns of the
/// antenna.
fn level_age_max_ns(period_ns: i64) -> i64 {
    period_ns * 22 / 10
}

/// Publishes a change of the life of a system track without a report. At uniform times, the next refresh shows the
/// change.
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
    entry.extrapolations = entry.extrapolations.saturating_add(1);
    entry.state = entry
        .state
        .at(now_ns.max(entry.state.time_ns), settings.process_noise_m2ps3);
    // A finite state stays finite when extrapolated.
    out.track(|message| write(message, settings, tracks, slot, None, None));
    // Another centre lets the number rest by itself.
    let has_ended = matches!(
        tracks.systems.get(slot).life,
        TrackState::Suspended | TrackState::Terminated
    );
    if settings.exchange && has_ended {
        out.own_track(|message| {
            write(message, settings, tracks, slot, None, None);
            message.state = TrackState::Terminated.code();
        });
    }
    tracks.keep(slot);
}

/// Writes the state of a system track changed by `cause`, with the contributions `weighed`, into `message`. Fields
/// set elsewhere remain 0.
pub(crate) fn write(
    message: &mut SystemTrack,
    settings: &Settings,
    tracks: &Tracks,
    slot: SystemSlot,
    cause: Option<&SensorTrack>,
    weighed: Option<&Weighed>,
) {
    let entry = tracks.systems.get(slot);
    let (members, shares, candidates) = weighed.map_or((&[][..], &[][..], &[][..]), |weighed| {
        (weighed.members(), weighed.shares(), weighed.candidates())
    });
    message.reference_time_ns = entry.state.time_ns;
    message.time_of_measurement_ns = cause.map_or(entry.state.time_ns, |report| report.time_of_measurement_ns);
    message.stages = cause.map_or(StageTimes::default(), |report| report.stages);
    message.track_number = entry.number;
    message.trigger_source = cause.map_or(NO_SOURCE, |report| report.source);
    message.selected_source = NO_SOURCE;
    message.nis = cause.map_or(0.0, |_| entry.nis);
    message.identity = entry.identity;
    message.position_m = entry.state.position_m;
    message.velocity_mps = entry.state.velocity_mps;
    message.covariance = entry.state.covariance;
    message.velocity_valid = u8::from(entry.state.covariance.knows_velocity());
    message.movement = match entry.life {
        TrackState::Tentative | TrackState::Confirmed => entry.filter.movement(),
        TrackState::Coasted | TrackState::Suspended | TrackState::Terminated => Movement::default(),
    };
    message.source_count = weighed.map_or(0, Weighed::contributing);
    message.state = entry.life as u8;
    message.height_valid = u8::from(entry.state.has_height);
    message.rule = settings.rule.name.0.code();
    message.alerts = entry.alerts;
    message.merged_into = entry.merged_into;
    entry.ownership.write(message);
    message.on_ground = u8::from(entry.on_ground);
    message.kind = entry.description.kind as u8;
    message.members = entry.description.members;
    message.target_type = entry.description.target_type;
    message.mode_probabilities = entry.filter.mode_probabilities();
    [message.turn_rate_radps, message.turn_rate_sigma_radps] = entry
        .filter
        .turn_rate()
        .map_or([0.0; 2], |rate| rate.map(|value| value as f32));
    [message.climb_rate_mps, message.climb_rate_variance] = entry
        .filter
        .climb_rate()
        .map_or([0.0; 2], |rate| rate.map(|value| value as f32));
    write_steady(message, tracks, entry);
    let has_height = entry.state.has_height;
    let offset = has_height
        .then(|| tracks.sources.pressure_offset_m(entry.state.position_m))
        .flatten();
    [message.pressure_offset_m, message.pressure_offset_sigma_m] =
        offset.map_or([0.0; 2], |offset| offset.map(|value| value as f32));
    message.existence = entry.existence();
    message.updates = entry.reports;
    message.extrapolations = entry.extrapolations;
    let listed_before = std::mem::replace(&mut message.contribution_count, members.len() as u16);
    let flag = |is_set: bool, flag| if is_set { flag } else { 0 };
    let mut heaviest = 0.0;
    // Newest level of all present supporters of the track.
    let (mut level, mut level_age_ns) = (0, i64::MAX);
    let weighed = members.iter().zip(shares.iter().zip(candidates));
    for (place, (member, (share, candidate))) in message.contributions.iter_mut().zip(weighed) {
        let member = tracks.sensors.get(*member);
        let source = &settings.sources[usize::from(member.source)];
        let weight = weight(share);
        let is_scored = share.accuracy.is_finite();
        let is_fresh = !candidate.stale;
        *place = Contribution {
            time_of_measurement_ns: member.time_ns,
            track_number: member.track_number,
            source: member.source,
            flags: flag(is_fresh, contribution_bits::FRESH)
                | flag(is_scored, contribution_bits::SCORED)
                | flag(member.is_foreign, contribution_bits::CENTRE),
            weight,
            accuracy: if is_scored { share.accuracy } else { f64::NAN },
            sensor_uid: source.sensor_uid,
            origin: member.latest.origin,
            axis_weights: share.weight.map(|weight| weight as f32),
            axis_accuracies: if is_scored {
                candidate.lambda_by_axis()
            } else {
                [0.0; AXES]
            },
        };
        if member.latest.has(sensor_track_bits::LEVEL) {
            let stated_ns = member.time_ns - i64::from(member.latest.level_age_ms) * NS_PER_MS;
            let age_ns = (entry.state.time_ns - stated_ns).max(0);
            let age_max_ns = level_age_max_ns(source.period_ns.max(entry.rhythm.interval_ns()));
            if age_ns < level_age_ns && age_ns <= age_max_ns {
                (level, level_age_ns) = (member.latest.level, age_ns);
            }
        }
        if weight > heaviest {
            heaviest = weight;
            message.selected_source = member.source;
        }
    }
    let is_known = level_age_ns != i64::MAX;
    message.level = level;
    message.level_valid = u8::from(is_known);
    message.level_age_ms = if is_known { (level_age_ns / NS_PER_MS) as u32 } else { 0 };
    let [east, north, _] = message.position_m;
    let altitude_by_qnh = || qnh::altitude(&settings.qnh, [east, north], level, entry.state.time_ns);
    let altitude = is_known.then(altitude_by_qnh).flatten();
    [message.altitude_m, message.qnh_hpa] = altitude.map_or([0.0; 2], |altitude| {
        [altitude.altitude_m as f32, altitude.qnh_hpa as f32]
    });
    let left_over = members.len()..usize::from(listed_before).max(members.len());
    message.contributions[left_over].fill(Contribution::default());
}

/// Writes how far the velocity of `message` is known if the target does not manoeuvre.
fn write_steady(message: &mut SystemTrack, tracks: &Tracks, entry: &SystemEntry) {
    let velocity_mps = message.velocity_mps;
    message.steady_velocity_covariance = match message.velocity_valid {
        0 => [0.0; 3],
        _ => {
            let motion = tracks.sources.motion(entry.filter.velocity_mps());
            let time_ns = message.reference_time_ns;
            let square = entry.filter.steady_velocity_m2ps2(time_ns, velocity_mps, motion);
            square.map(|value| value as f32)
        }
    };
    let climb_m2ps2 = entry.filter.steady_climb_m2ps2(velocity_mps[2]);
    message.steady_climb_variance = climb_m2ps2.map_or(0.0, |value| value as f32);
}

/// Lists, after the contributions, other centres with an earlier track of the target that are silent now.
#[cold]
pub(crate) fn list_silent_centres(message: &mut SystemTrack, tracks: &Tracks, slot: SystemSlot) {
    for member in tracks.members(slot) {
        let centre = tracks.sensors.get(member);
        if centre.is_foreign
            && !tracks.is_fresh(centre, message.reference_time_ns)
            && let Some(place) = message.contributions.get_mut(usize::from(message.contribution_count))
        {
            *place = Contribution {
                time_of_measurement_ns: centre.time_ns,
                track_number: centre.track_number,
                source: centre.source,
                flags: contribution_bits::CENTRE,
                accuracy: f64::NAN,
                origin: centre.latest.origin,
                ..Contribution::default()
            };
            message.contribution_count += 1;
        }
    }
}

/// The mean over the axes of a contribution's weight.
pub(crate) fn weight(share: &Share) -> f64 {
    share.weight.iter().sum::<f64>() / AXES as f64
}
