//! Parts that rows of sensor tracks and of system tracks have in common.

use messages::{COVARIANCE_LEN, Covariance, Identity, STATE_LEN, TargetType, TrackKind};

use crate::cells::{Plain, Untrusted};
use crate::columns::columns;

/// Columns of position and velocity.
pub(crate) const KINEMATICS: [&str; STATE_LEN] = ["x", "y", "z", "vx", "vy", "vz"];

/// Position and velocity with millimetres.
pub(crate) fn kinematics(position_m: &[f64; 3], velocity_mps: &[f64; 3]) -> [Plain; STATE_LEN] {
    let ([x, y, z], [vx, vy, vz]) = (*position_m, *velocity_mps);
    [x, y, z, vx, vy, vz].map(|value| Plain(value, 3))
}

/// Upper triangle of a covariance.
pub(crate) fn covariance(covariance: &Covariance) -> [Plain; COVARIANCE_LEN] {
    covariance.upper.map(|value| Plain(value, 4))
}

/// Returns the members of a group; `None` for a single target. A group without members is none.
pub(crate) fn members(kind: u8, members: u16) -> Option<u16> {
    let is_group = TrackKind::from_code(kind) == Some(TrackKind::Group);
    (is_group && members > 0).then_some(members)
}

/// Returns the confidence of a known type.
pub(crate) fn confidence(target_type: &TargetType) -> Option<f32> {
    target_type.name().map(|_| target_type.confidence)
}

/// Text from outside without blanks.
pub(crate) fn word(text: &str) -> Untrusted<'_> {
    Untrusted {
        text,
        has_blanks: false,
    }
}

/// Text from outside with blanks.
pub(crate) fn words(text: &str) -> Untrusted<'_> {
    Untrusted { text, has_blanks: true }
}

/// What ships have in place of an address, written as the last part of a row.
pub(crate) struct ShipRow<'a>(pub(crate) &'a Identity);

columns! {
    ShipRow<'_>: |row|
    "mmsi" => row.0.mmsi_text(),
    "name" => row.0.name().map(words),
}
