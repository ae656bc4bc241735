//! The turn of the platform that would show an emitter's range.
//!
//! On a straight course all positions and velocities of an emitter that are scaled together give the same bearings. The
//! distinction requires a change of the platform's velocity across the line of sight: from the present velocity across
//! to the opposite velocity, the greatest change leads to a course at right angles to the bearing, on the other side of
//! the line (S. C. Nardone, V. J. Aidala, *Observability criteria for bearings-only target motion analysis*, IEEE
//! Transactions on Aerospace and Electronic Systems 17, 1981).

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::line_of_bearing::Ray;

/// A platform that has moved less between two bearings has no course, metres.
const WAY_MIN_M: f64 = 1.0;

/// Direction in which a platform turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnSide {
    /// To the left.
    Port,
    /// To the right.
    Starboard,
}

impl TurnSide {
    /// The word for the side.
    pub fn word(self) -> &'static str {
        match self {
            Self::Port => "port",
            Self::Starboard => "starboard",
        }
    }
}

/// A turn that would show the range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TurnCue {
    pub(crate) side: TurnSide,
    /// Course after the turn, and present course, radians from north, from 0 to 2π.
    pub(crate) course_rad: f64,
    pub(crate) present_rad: f64,
}

/// Returns the turn after two successive bearings; `None` if the platform did not move.
pub(crate) fn turn_for_range(before: &Ray, now: &Ray) -> Option<TurnCue> {
    let [east, north]: [f64; 2] = std::array::from_fn(|axis| now.platform_m[axis] - before.platform_m[axis]);
    if east.hypot(north) < WAY_MIN_M {
        return None;
    }
    let present_rad = east.atan2(north);
    let bearing_rad = now.sine.atan2(now.cosine);
    // Clockwise of the line of sight now: counterclockwise of this line then.
    let is_clockwise = (present_rad - bearing_rad).sin() > 0.0;
    let course_rad = bearing_rad + if is_clockwise { -FRAC_PI_2 } else { FRAC_PI_2 };
    let side = match (course_rad - present_rad).sin() < 0.0 {
        true => TurnSide::Port,
        false => TurnSide::Starboard,
    };
    Some(TurnCue {
        side,
        course_rad: course_rad.rem_euclid(TAU),
        present_rad: present_rad.rem_euclid(TAU),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(platform_m: [f64; 2], bearing_deg: f64) -> Ray {
        let (sine, cosine) = bearing_deg.to_radians().sin_cos();
        Ray {
            platform_m,
            sine,
            cosine,
        }
    }

    #[test]
    fn the_turn_leads_across_the_line_of_sight_to_its_other_side() {
        for (course_deg, bearing_deg, to_deg, side) in [
            (140.0, 80.0, 350.0, TurnSide::Port),
            (20.0, 80.0, 170.0, TurnSide::Starboard),
            (10.0, 270.0, 180.0, TurnSide::Starboard),
            (100.0, 300.0, 210.0, TurnSide::Starboard),
        ] {
            let (sine, cosine) = f64::to_radians(course_deg).sin_cos();
            let found = turn_for_range(
                &ray([5.0, 7.0], bearing_deg),
                &ray([5.0 + 100.0 * sine, 7.0 + 100.0 * cosine], bearing_deg),
            )
            .unwrap();
            assert!((found.course_rad.to_degrees() - to_deg).abs() < 1e-6, "{found:?}");
            assert!((found.present_rad.to_degrees() - course_deg).abs() < 1e-6, "{found:?}");
            assert_eq!(found.side, side, "{course_deg} {bearing_deg}");
        }
        assert_eq!(turn_for_range(&ray([5.0, 7.0], 80.0), &ray([5.0, 7.5], 80.0)), None);
    }
}
