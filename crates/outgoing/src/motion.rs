//! How a system track moves, as CAT062 has it.
//!
//! - **I062/200** has the modes of `movement`, in which fusion states what is sure.
//! - **I062/210** has the acceleration of `movement`. While fusion is not sure between straight flight and a turn, the
//!   acceleration follows from the rate of turn, if the rate is larger than its error: it is the rate times the speed,
//!   to the inner side of the turn.
//! - **I062/220** has the rate of climb of the vertical filter, and I062/500 its error. Both come from `velocity_mps`
//!   and `covariance` if there is no such rate, as in the tracks of other centres. The velocity in the plane is part of
//!   the rate: far from the origin, flight in the plane of the system is a climb.

use messages::{
    HorizontalMovement, LongitudinalMovement, Movement, SystemTrack, TrackState, VerticalMovement, movement_bits,
};

use asterix::categories::CAT062;
use asterix::field::{Elements, Field, elements, field, item, whole};
use asterix::{Frn, RecordWriter};

use super::items;
use super::place::{self, Axis};

const MOVEMENT: Frn = item(CAT062, "200");
const TRANS: Field = field(CAT062, &["200", "TRANS"]);
const LONG: Field = field(CAT062, &["200", "LONG"]);
const VERT: Field = field(CAT062, &["200", "VERT"]);
const ACCELERATION: Elements<2> = elements(CAT062, "210", ["AX", "AY"]);
const CLIMB: Elements<1> = whole(CAT062, "220");

/// Standard deviations above which a rate of turn is no noise.
const SURE_SIGMAS: f32 = 2.0;

/// Writes I062/200, where some mode is known.
pub(super) fn modes(movement: &Movement, record: &mut RecordWriter) {
    const UNDETERMINED: i64 = 3;
    let horizontal = match HorizontalMovement::from_code(movement.horizontal) {
        Some(HorizontalMovement::Straight) => 0,
        Some(HorizontalMovement::TurnRight) => 1,
        Some(HorizontalMovement::TurnLeft) => 2,
        _ => UNDETERMINED,
    };
    let longitudinal = match LongitudinalMovement::from_code(movement.longitudinal) {
        Some(LongitudinalMovement::Constant) => 0,
        Some(LongitudinalMovement::Increasing) => 1,
        Some(LongitudinalMovement::Decreasing) => 2,
        _ => UNDETERMINED,
    };
    let vertical = match VerticalMovement::from_code(movement.vertical) {
        Some(VerticalMovement::Level) => 0,
        Some(VerticalMovement::Climb) => 1,
        Some(VerticalMovement::Descend) => 2,
        _ => UNDETERMINED,
    };
    if [horizontal, longitudinal, vertical] != [UNDETERMINED; 3] {
        record
            .item(MOVEMENT)
            .put(TRANS, horizontal)
            .put(LONG, longitudinal)
            .put(VERT, vertical);
    }
}

/// Writes I062/210, where the acceleration is known; `towards` are east and north at the target.
pub(super) fn acceleration(track: &SystemTrack, towards: [Axis; 2], record: &mut RecordWriter) {
    let movement = &track.movement;
    let known = movement.valid & movement_bits::ACCELERATION != 0;
    let stated = known.then(|| movement.acceleration_mps2.map(f64::from));
    if let Some(acceleration) = stated.or_else(|| of_turn(track)) {
        let along = towards.map(|axis| place::along(axis, acceleration));
        items::quantities(record, &ACCELERATION, along);
    }
}

/// Returns the acceleration of a turn, m/s²; `None` if the track is not supported now, or the rate of turn is noise.
fn of_turn(track: &SystemTrack) -> Option<[f64; 3]> {
    let (rate, sigma) = (track.turn_rate_radps, track.turn_rate_sigma_radps);
    let is_updated = matches!(
        TrackState::from_code(track.state),
        Some(TrackState::Tentative | TrackState::Confirmed)
    );
    // Written so that NaN fails.
    let is_sure = sigma > 0.0 && rate.abs() >= SURE_SIGMAS * sigma;
    let [vx, vy, _] = track.velocity_mps.map(|velocity| velocity * f64::from(rate));
    (is_updated && is_sure).then_some([vy, -vx, 0.0])
}

/// Whether the rate of climb at the target is known: that in the system's plane, and the velocity along the plane,
/// which is part of it.
pub(super) fn has_climb(track: &SystemTrack) -> bool {
    track.velocity_valid != 0 && (has_rate(track) || track.covariance.knows_climb())
}

/// Writes I062/220, where the rate is known; `up` is the direction of the height at the target.
pub(super) fn climb(track: &SystemTrack, up: Axis, record: &mut RecordWriter) {
    if !has_climb(track) {
        return;
    }
    let [vx, vy, vz] = track.velocity_mps;
    let vz = if has_rate(track) {
        f64::from(track.climb_rate_mps)
    } else {
        vz
    };
    items::quantities(record, &CLIMB, [place::along(up, [vx, vy, vz])]);
}

/// Returns the variance of the rate of climb, m²/s²; `of_velocity` is that of the velocity.
pub(super) fn climb_variance(track: &SystemTrack, of_velocity: f64) -> f64 {
    match has_rate(track) {
        true => f64::from(track.climb_rate_variance),
        false => of_velocity,
    }
}

fn has_rate(track: &SystemTrack) -> bool {
    track.climb_rate_variance > 0.0
}
