//! JSON with all details of single tracks, and lists of all tracks.
//!
//! **A selected track** has `number`, `state`, `kind`, `members`, `rule`, `sequence`, `epoch`, `time_s`,
//! `reference_time_ns`, `time_of_measurement_ns`, `trigger_source`, `position_m` [3], `velocity_mps` [3],
//! `height_m` (as shown: the transponder's level, else the height above the ellipsoid), `climb_mps` (rate of the
//! height above the ellipsoid), `climb_rate_mps` (the same by the vertical filter), `climb_sigma_mps`,
//! `turn_rate_dps` (degrees per second, positive to the right),
//! `turn_sigma_dps`, `modes` (the most probable models of the plane and of the vertical, each `mode` and
//! `probability`), `level` (of the transponder, hundreds of feet), `level_age_s`, `height_valid`,
//! `on_ground`, `merged_into`, `owner_track_number` (0: this centre owns the track), `nis`, `covariance` (the 21
//! elements of the upper triangle), `identity` {`address`, `mmsi`, `mode_3a` (texts), `callsign`, `name`, `type`,
//! `type_confidence`}, `stated` ([[name, text]]: category, status, size and other facts beside the motion) and
//! `contributions`. Each contribution has
//! `source`, `name`, `track_number`, `weight`, `accuracy`, `fresh`, `scored`, `centre` (a system track of another
//! centre), `origin` (the other centre; `null`: unknown), `time_s`, `time_of_measurement_ns`, and the last position
//! of the sensor track: `position_m` [2] and `height_m`. In the past, position and velocity have no up component,
//! and `modes`, `level`, `covariance`, `sequence`, `epoch`, `rule`, `owner_track_number` and all rates but
//! `climb_mps` are absent.
//!
//! **Reasons** of a selected track of the present: each contribution also has `age_s` (at the state's time),
//! `period_s`, `sigma_m` [2] (half axes of the stated ellipse, scaled), `learned_sigma_m` [2] (of its measurements),
//! `residual_m` [2] (moved report minus state), `residual_sigmas`, `inflation` (covariance scaling), `bias_m` [3]
//! (taken off the report), `depends_on` [[name, correlation]], and `reason` (sentences). The track has `decisions`
//! [{`time_s`, `kind`, `text`}], the latest first, `decisions_missing`, and `rules` [{`rule`, `summary`, `in_force`,
//! `shares` [[source, name, share]], `apart_m` (from the state), `sigma_m` [2]}], `rules_missing`; see
//! [`crate::reasons`] and [`crate::decision_text`].
//!
//! **A row of a history** is `[time_s, east, north, height, speed, state, nis, [[source, weight], …]]`, the oldest
//! first. `nis` is the normalised innovation squared of the report that caused the state; without such a report it
//! is `null`.

use messages::picture::{PictureIdentity, PictureSensorTrack, PictureTrack, picture_track_bits};
use messages::{
    Contribution, Emergency, FusionRule, Identity, MotionMode, NO_SOURCE, NavigationStatus, Spelled, SystemTrack,
    TargetCategory, TargetStatement, TargetType, TrackKind, TrackState, contribution_bits,
    target_statement_bits as bits,
};
use runtime::Now;
use serde_json::{Value, json};

use crate::decision_text;
use crate::reasons;
use crate::vertical;
use crate::viewer::Viewer;
use crate::world::World;

/// Maximum number of rows of a history.
const ROWS_MAX: usize = 3_000;
const FEET_PER_M: f64 = 1.0 / 0.3048;
const KNOTS_PER_MPS: f64 = 3_600.0 / 1_852.0;

/// Converts nanoseconds to seconds since 1970, for JavaScript.
pub(crate) fn seconds(ns: i64) -> f64 {
    ns as f64 / messages::NS_PER_S
}

/// Returns the details of the tracks selected by `viewer`, for the picture at `time_ns`.
pub(crate) fn selected(world: &World, viewer: &Viewer, time_ns: i64) -> Value {
    let tracks = viewer.selected.iter().filter_map(|number| match viewer.then() {
        None => reasoned(world, *number),
        Some(then) => past(world, viewer, *number, *then.states.get(number)?),
    });
    json!({"type": "selected", "time_s": seconds(time_ns), "tracks": tracks.collect::<Vec<_>>()})
}

/// Returns a track of the present with reasons; `None` if there is no track of this number.
pub(crate) fn reasoned(world: &World, number: u32) -> Option<Value> {
    let track = &world.tracks.get(&number)?.track;
    let mut details = live(world, number)?;
    let facts = reasons::facts(world, track);
    let rule = FusionRule::from_code(track.rule);
    let parts = details.get_mut("contributions").and_then(Value::as_array_mut);
    for (part, fact) in parts.into_iter().flatten().zip(&facts) {
        fact.add_to(world, &facts, rule, part);
    }
    let (rules, rules_missing) = reasons::rules(world, track);
    let why = json!({
        "decisions": decision_text::list(world, number),
        "decisions_missing": decision_text::missing(world),
        "rules": rules,
        "rules_missing": rules_missing,
    });
    if let (Some(details), Value::Object(why)) = (details.as_object_mut(), why) {
        details.extend(why);
    }
    Some(details)
}

fn live(world: &World, number: u32) -> Option<Value> {
    let known = world.tracks.get(&number)?;
    let track = &known.track;
    let report = |part: &Contribution| {
        let heard = world.sensor_tracks.get(&(part.source, part.track_number));
        heard.map(|heard| heard.record)
    };
    let parts: Vec<Value> = track
        .listed()
        .iter()
        .map(|part| contribution(world, part, report(part)))
        .collect();
    Some(json!({
        "number": number,
        "state": word(TrackState::from_code(track.state), TrackState::word),
        "kind": word(TrackKind::from_code(track.kind), TrackKind::word),
        "members": track.members,
        "rule": word(FusionRule::from_code(track.rule), FusionRule::word),
        "sequence": track.sequence,
        "epoch": track.epoch.to_string(),
        "time_s": seconds(track.reference_time_ns),
        "reference_time_ns": track.reference_time_ns.to_string(),
        "time_of_measurement_ns": track.time_of_measurement_ns.to_string(),
        "trigger_source": source(track.trigger_source),
        "position_m": track.position_m,
        "velocity_mps": velocity(track.velocity_valid != 0, track.velocity_mps),
        "height_m": finite(known.record.height_m),
        "climb_mps": finite(known.record.height_m).and_then(|_| finite(known.record.climb_mps)),
        "climb_rate_mps": vertical::filtered_climb_mps(track, world.observed.frame()),
        "climb_sigma_mps": rate_sigma(track.climb_rate_variance.sqrt()),
        "turn_rate_dps": rate_sigma(track.turn_rate_sigma_radps).map(|_| track.turn_rate_radps.to_degrees()),
        "turn_sigma_dps": rate_sigma(track.turn_rate_sigma_radps).map(f32::to_degrees),
        "modes": modes(track),
        "level": track.level_m().map(|_| f64::from(track.level) / 4.0),
        "level_age_s": track.level_m().map(|_| f64::from(track.level_age_ms) / 1e3),
        "height_valid": track.height_valid != 0,
        "velocity_valid": track.velocity_valid != 0,
        "on_ground": track.on_ground != 0,
        "merged_into": track.merged_into,
        "owner_track_number": track.owner_track_number,
        "nis": nis(track.nis),
        "covariance": track.covariance.upper,
        "identity": identity(&track.identity, &track.target_type),
        "stated": stated(world, track),
        "contributions": parts,
    }))
}

/// What the targets of the contributing sensor tracks have stated beside their motion, as names with texts: of each
/// name the first that is known.
fn stated(world: &World, track: &SystemTrack) -> Vec<(&'static str, String)> {
    let mut known: Vec<(&'static str, String)> = Vec::new();
    for part in track.contributions() {
        let Some(statement) = world.statements.get(&(part.source, part.track_number)) else {
            continue;
        };
        for (name, text) in stated_facts(statement) {
            if let Some(text) = text.filter(|_| known.iter().all(|(other, _)| *other != name)) {
                known.push((name, text));
            }
        }
    }
    known
}

/// The facts of a statement; `None` where a fact is not known.
fn stated_facts(stated: &TargetStatement) -> [(&'static str, Option<String>); 6] {
    let word = |word: Option<&str>| {
        word.filter(|word| *word != "unknown")
            .map(|word| word.replace('-', " "))
    };
    let holds = |bit: u8, text: String| (stated.valid & bit != 0).then_some(text);
    let level = f64::from(stated.selected_altitude_m) * FEET_PER_M / 100.0;
    let [latitude, longitude] = stated.place_deg;
    [
        (
            "category",
            word(TargetCategory::from_code(stated.category).map(TargetCategory::word)),
        ),
        (
            "status",
            word(NavigationStatus::from_code(stated.navigation).map(NavigationStatus::word)),
        ),
        (
            "emergency",
            word(Emergency::from_code(stated.emergency).map(Emergency::word)),
        ),
        (
            "size",
            holds(bits::SIZE, format!("{:.0} × {:.0} m", stated.length_m, stated.width_m)),
        ),
        (
            "selected level",
            holds(bits::SELECTED_ALTITUDE, format!("FL {level:.0}")),
        ),
        (
            "operator at",
            holds(bits::OPERATOR, format!("{latitude:.5}, {longitude:.5}")),
        ),
    ]
}

fn past(world: &World, viewer: &Viewer, number: u32, state: u64) -> Option<Value> {
    let moment = world.history.moment(state)?;
    let record = &moment.track;
    let parts = world.history.contributions(state);
    let parts: Vec<Value> = parts
        .map(|part| contribution(world, part, viewer.report_then(world, part)))
        .collect();
    let has_velocity = record.flags & picture_track_bits::VELOCITY != 0;
    let known = world.identities.get(&number).map(|known| known.record);
    let (known, target_type) = known.map_or_else(Default::default, |known| named(&known));
    Some(json!({
        "number": number,
        "state": word(TrackState::from_code(record.state), TrackState::word),
        "kind": word(TrackKind::from_code(record.kind), TrackKind::word),
        "members": record.members,
        "time_s": seconds(moment.time_ns),
        "reference_time_ns": moment.time_ns.to_string(),
        "time_of_measurement_ns": moment.measured_ns.to_string(),
        "position_m": [record.east_m, record.north_m],
        "velocity_mps": velocity(has_velocity, [record.east_mps, record.north_mps]),
        "height_m": finite(record.height_m),
        "climb_mps": finite(record.height_m).and_then(|_| finite(record.climb_mps)),
        "height_valid": record.flags & picture_track_bits::HEIGHT != 0,
        "velocity_valid": has_velocity,
        "on_ground": record.flags & picture_track_bits::ON_GROUND != 0,
        "nis": nis(moment.nis),
        "identity": identity(&known, &target_type),
        "contributions": parts,
    }))
}

/// A velocity; `null` in place of each component of an unknown one.
fn velocity<T, const N: usize>(is_known: bool, velocity_mps: [T; N]) -> [Option<T>; N] {
    velocity_mps.map(|component| is_known.then_some(component))
}

fn word<T>(value: Option<T>, word: impl Fn(T) -> &'static str) -> Option<&'static str> {
    value.map(word)
}

/// Returns the value if it is finite; NaN means unknown.
fn finite(value: f32) -> Option<f32> {
    Some(value).filter(|value| value.is_finite())
}

/// Returns the normalised innovation squared if present.
fn nis(nis: f32) -> Option<f32> {
    Some(nis).filter(|nis| *nis > 0.0)
}

/// Returns the standard deviation of a rate if the rate is known.
fn rate_sigma(sigma: f32) -> Option<f32> {
    Some(sigma).filter(|sigma| *sigma > 0.0)
}

/// Returns the most probable motion model of the plane and of the vertical, as far as known.
fn modes(track: &SystemTrack) -> Vec<Value> {
    let (plane, vertical) = track.mode_probabilities.split_at(MotionMode::Level as usize);
    let probable = |first: MotionMode, probabilities: &[f32]| {
        let numbered = (first as u8..).zip(probabilities);
        let (code, probability) = numbered.max_by(|one, other| one.1.total_cmp(other.1))?;
        let mode = MotionMode::from_code(code).filter(|_| *probability > 0.0)?;
        Some(json!({"mode": mode.word(), "probability": probability}))
    };
    let both = [(MotionMode::Steady, plane), (MotionMode::Level, vertical)];
    both.into_iter()
        .filter_map(|(first, part)| probable(first, part))
        .collect()
}

fn source(number: u16) -> Option<u16> {
    Some(number).filter(|number| *number != NO_SOURCE)
}

/// Returns a contribution with the position of its sensor track in the shown picture.
fn contribution(world: &World, part: &Contribution, report: Option<PictureSensorTrack>) -> Value {
    let position = report.map(|report| (report.east_m, report.north_m));
    let height_m = report.and_then(|report| finite(report.height_m));
    json!({
        "source": part.source,
        "name": world.observed.source_name(part.source),
        "track_number": part.track_number,
        "weight": part.weight,
        "accuracy": Some(part.accuracy).filter(|accuracy| accuracy.is_finite()),
        "fresh": part.flags & contribution_bits::FRESH != 0,
        "scored": part.flags & contribution_bits::SCORED != 0,
        "centre": part.flags & contribution_bits::CENTRE != 0,
        "origin": Some(part.origin).filter(|origin| *origin != 0),
        "time_s": seconds(part.time_of_measurement_ns),
        "time_of_measurement_ns": part.time_of_measurement_ns.to_string(),
        "position_m": position,
        "height_m": height_m,
    })
}

fn identity(identity: &Identity, target_type: &TargetType) -> Value {
    let text = |spelled: Option<Spelled>| spelled.map(|spelled| spelled.to_string());
    json!({
        "address": text(identity.address_text()),
        "mmsi": text(identity.mmsi_text()),
        "mode_3a": text(identity.mode_3a_text()),
        "callsign": identity.callsign(),
        "name": identity.name(),
        "type": target_type.name(),
        "type_confidence": target_type.name().map(|_| target_type.confidence),
    })
}

/// Returns identity and type of a record.
fn named(record: &PictureIdentity) -> (Identity, TargetType) {
    let identity = Identity {
        address: record.address,
        mode_3a: record.mode_3a,
        kind: record.kind,
        valid: record.valid,
        callsign: record.callsign,
        name: record.name,
        ..Identity::default()
    };
    let target_type = TargetType {
        name: record.type_name,
        confidence: record.type_confidence,
    };
    (identity, target_type)
}

/// Returns the past of the track `number` up to `until_ns`; `None` if there is none.
pub(crate) fn history(world: &World, number: u32, until_ns: i64) -> Option<Value> {
    let states = world.history.of_track(number, until_ns).take(ROWS_MAX);
    let mut rows: Vec<Value> = states
        .map(|(state, moment)| {
            let record = &moment.track;
            let parts = world.history.contributions(state);
            let weights: Vec<(u16, f64)> = parts.map(|part| (part.source, part.weight)).collect();
            json!([
                seconds(moment.time_ns),
                record.east_m,
                record.north_m,
                finite(record.height_m),
                record.east_mps.hypot(record.north_mps),
                word(TrackState::from_code(record.state), TrackState::word),
                nis(moment.nis),
                weights,
            ])
        })
        .collect();
    rows.reverse();
    (!rows.is_empty()).then(|| json!({"type": "history", "number": number, "rows": rows}))
}

/// Returns all system tracks.
pub(crate) fn tracks(world: &World, now: Now) -> Value {
    let tracks: Vec<Value> = world.tracks.keys().filter_map(|number| live(world, *number)).collect();
    json!({"time_s": seconds(world.time_ns(now)), "tracks": tracks})
}

/// Returns all system tracks in the form of readsb's `aircraft.json`, for pages that read this format: feet, knots,
/// degrees.
pub(crate) fn aircraft(world: &World, now: Now) -> Value {
    let time_ns = world.time_ns(now);
    let shown = |state: u8| {
        matches!(
            TrackState::from_code(state),
            Some(TrackState::Confirmed | TrackState::Coasted)
        )
    };
    let tracks = world.tracks.values().filter(|live| shown(live.track.state));
    let aircraft = tracks.filter_map(|live| {
        let (track, record): (_, &PictureTrack) = (&live.track, &live.record);
        let place = world.observed.frame()?.to_geodetic(track.position_m);
        let [east, north, _] = track.velocity_mps;
        let seen_s = seconds(time_ns - live.measured_ns).max(0.0);
        // In that format, numbers other than aircraft addresses start with a tilde.
        let hex = track.identity.address_text().map_or_else(
            || format!("~{:06x}", track.track_number & 0xff_ffff),
            |address| address.to_string().to_lowercase(),
        );
        let mut one = json!({
            "hex": hex,
            "type": "other",
            "lat": place.latitude_deg(),
            "lon": place.longitude_deg(),
            "seen": seen_s,
            "seen_pos": seen_s,
            "messages": track.sequence,
            "rssi": -1.0,
        });
        let object = one.as_object_mut()?;
        if track.velocity_valid != 0 {
            object.insert("gs".to_owned(), json!(east.hypot(north) * KNOTS_PER_MPS));
            object.insert(
                "track".to_owned(),
                json!(east.atan2(north).to_degrees().rem_euclid(360.0)),
            );
        }
        if record.flags & picture_track_bits::ON_GROUND != 0 {
            object.insert("alt_baro".to_owned(), json!("ground"));
        } else if let Some(level_m) = track.level_m() {
            object.insert("alt_baro".to_owned(), json!((level_m * FEET_PER_M).round()));
        }
        if let Some(geometric) = vertical::geometric(track, world.observed.frame())
            && record.flags & picture_track_bits::ON_GROUND == 0
        {
            let rate = geometric.climb_mps * FEET_PER_M * 60.0;
            object.insert("alt_geom".to_owned(), json!((geometric.height_m * FEET_PER_M).round()));
            if vertical::knows_climb(track) {
                object.insert("geom_rate".to_owned(), json!(rate.round()));
            }
        }
        if let Some(callsign) = track.identity.callsign() {
            object.insert("flight".to_owned(), json!(format!("{callsign:8}")));
        }
        if let Some(code) = track.identity.mode_3a_text() {
            object.insert("squawk".to_owned(), json!(code.to_string()));
        }
        if let Some(name) = track.target_type.name() {
            object.insert("t".to_owned(), json!(name));
        }
        Some(one)
    });
    let aircraft: Vec<Value> = aircraft.collect();
    json!({"now": seconds(time_ns), "messages": world.stamp, "aircraft": aircraft})
}

/// Returns the receiver's description in readsb's form.
pub(crate) fn receiver(world: &World) -> Value {
    json!({
        "version": concat!("koseki ", env!("CARGO_PKG_VERSION")),
        "refresh": 1000,
        "history": 0,
        "lat": world.observed.origin().map(|origin| origin.latitude_deg),
        "lon": world.observed.origin().map(|origin| origin.longitude_deg),
    })
}
