//! Errors of positions and velocities of AIS.
//!
//! # Position
//!
//! A flag states whether the position is better or worse than 10 m. The recommendation takes 10 m from the expected
//! error that receivers with integrity monitoring give, or from the use of differential corrections. 10 m is therefore
//! the radius within which a flagged position lies with 95 % probability, and 30 m of one without the flag: receivers
//! without corrections keep within 13 m (resolution MSC.112(73)), but the flag is down, too, where a ship does not
//! know. Positions by hand, by dead reckoning, or of a system out of order have an unknown accuracy.
//!
//! Coordinates are whole ten-thousandths of a minute, 0.2 m. Those of type 27 are whole tenths of a minute: the error
//! is evenly distributed within 93 m in both directions on the equator, so that 95 % lie within 111 m. Its variance, a
//! third of the square of 93 m, goes into the covariance; for a ship at rest, the error stays the same in all reports.
//!
//! Positions are those of the antenna, and mean the hull's centre. Until static data state where on the hull the
//! antenna is, a ship of class A may be 300 m long: the distance is taken as 40 m along the heading, a fifth of 200 m,
//! as of antennas on bridges aft; of a stated length, as a fifth of it. Boats of class B are as short as the errors.
//! Without a heading, the direction from a known antenna to the centre is not known, and its distance is an error.
//!
//! # Velocity
//!
//! No accuracy is stated. Receivers of ships have to keep the speed within 0.2 kn, or 2 % of a higher speed, and the
//! course within 3°, or 1° above 17 kn (IEC 61108-1): these are taken as 95 % limits along the course and across it. At
//! low speeds the course is not reliable, but the velocity across is: as good as along. Speeds are whole tenths of a
//! knot, courses of a degree; whole knots in types 9 and 27, whole degrees in type 27. Limits: receivers average over
//! seconds, so that velocities in turns are late; a ship that rolls moves its antenna.

use observations::{Quality, RADIUS95_SIGMAS};

/// Metres per second of a knot.
pub(super) const MPS_PER_KT: f64 = 1852.0 / 3600.0;
/// Metres of a minute of latitude.
const M_PER_MINUTE: f64 = 1852.0;
/// Radius within which positions lie with 95 % probability, metres: of low and high accuracy.
const RADIUS95_M: [f64; 2] = [30.0, 10.0];
/// Step of the coordinates of type 27, minutes.
const COARSE_STEP_MIN: f64 = 0.1;
/// Half the interval that holds 95 % of a normal distribution, in standard deviations.
const INTERVAL95_SIGMAS: f64 = 1.959_964;
/// Limits of the error of speed: knots, and share of the speed.
const SPEED_ERROR_KT: f64 = 0.2;
const SPEED_ERROR_SHARE: f64 = 0.02;
/// Limits of the error of course, degrees: up to the speed, knots, and above.
const COURSE_ERROR_DEG: [f64; 2] = [3.0, 1.0];
const FAST_KT: f64 = 17.0;

/// Distance of the antenna from the centre, standard deviation: metres along a hull of class A that is not known, and
/// share of a known length.
const OFFSET_SIGMA_M: f64 = 40.0;
const OFFSET_SIGMA_SHARE: f64 = 0.2;

/// Standard deviation of the distance from the antenna to the centre of a hull that may have stated its length, metres.
pub(super) fn offset_sigma_m(length_m: Option<f64>) -> f64 {
    length_m.map_or(OFFSET_SIGMA_M, |length_m| OFFSET_SIGMA_SHARE * length_m)
}

/// The quality of a position whose distance from the hull's centre is not known: of this standard deviation along the
/// heading, or in an unknown direction.
pub(super) fn with_offset(quality: Quality, sigma_m: f64, heading_rad: Option<f64>) -> Quality {
    let own_m2 = match quality {
        Quality::Radius95(radius_m) => [
            (radius_m / RADIUS95_SIGMAS).powi(2),
            0.0,
            (radius_m / RADIUS95_SIGMAS).powi(2),
        ],
        Quality::Covariance(covariance_m2) => covariance_m2,
        _ => return quality,
    };
    let offset_m2 = sigma_m * sigma_m;
    let [xx, xy, yy] = match heading_rad.map(f64::sin_cos) {
        Some((sine, cosine)) => [sine * sine, sine * cosine, cosine * cosine],
        None => [0.5, 0.0, 0.5],
    };
    Quality::Covariance([
        own_m2[0] + offset_m2 * xx,
        own_m2[1] + offset_m2 * xy,
        own_m2[2] + offset_m2 * yy,
    ])
}

/// Steps in which a message has its velocity: knots, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VelocitySteps {
    pub(super) speed_kt: f64,
    pub(super) course_deg: f64,
}

/// Steps of most types.
pub(super) const FINE: VelocitySteps = VelocitySteps {
    speed_kt: 0.1,
    course_deg: 0.1,
};

/// Quality of a position by the accuracy flag.
pub(super) fn by_flag(is_accurate: bool) -> Quality {
    Quality::Radius95(RADIUS95_M[usize::from(is_accurate)])
}

/// Quality of a position of type 27 by the accuracy flag, at a latitude.
pub(super) fn of_coarse(is_accurate: bool, latitude_deg: f64) -> Quality {
    let own_m2 = (RADIUS95_M[usize::from(is_accurate)] / RADIUS95_SIGMAS).powi(2);
    let step_m2 = (COARSE_STEP_MIN * M_PER_MINUTE).powi(2) / 12.0;
    let shrunk = latitude_deg.to_radians().cos().powi(2);
    Quality::Covariance([own_m2 + step_m2 * shrunk, 0.0, own_m2 + step_m2])
}

/// Standard deviations of a velocity along the course and across it, metres per second, without those of its steps.
fn receiver_sigmas_mps(speed_kt: f64) -> [f64; 2] {
    let course_deg = COURSE_ERROR_DEG[usize::from(speed_kt > FAST_KT)];
    let along_kt = SPEED_ERROR_KT.max(SPEED_ERROR_SHARE * speed_kt);
    let across_kt = SPEED_ERROR_KT.max(speed_kt * course_deg.to_radians());
    [along_kt, across_kt].map(|limit_kt| limit_kt * MPS_PER_KT / INTERVAL95_SIGMAS)
}

/// Covariance (xx, xy, yy) of a velocity towards east and north, m²/s².
pub(super) fn of_velocity(speed_kt: f64, course_deg: f64, steps: VelocitySteps) -> [f64; 3] {
    let rounding_mps = [steps.speed_kt, speed_kt * steps.course_deg.to_radians()].map(|step_kt| step_kt * MPS_PER_KT);
    let receiver_mps = receiver_sigmas_mps(speed_kt);
    let [along, across] = [0, 1].map(|axis| receiver_mps[axis].powi(2) + rounding_mps[axis].powi(2) / 12.0);
    let (sine, cosine) = course_deg.to_radians().sin_cos();
    [
        along * sine * sine + across * cosine * cosine,
        (along - across) * sine * cosine,
        along * cosine * cosine + across * sine * sine,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocities_are_as_good_as_receivers_have_to_be() {
        let [east, cross, north] = of_velocity(10.0, 0.0, FINE).map(|value| (value * 1e6).round() / 1e6);
        // 0.2 kn along; 3° of 10 kn across.
        assert_eq!((north.sqrt() * 1e3).round(), 55.0);
        assert_eq!((east.sqrt() * 1e3).round(), 137.0);
        assert_eq!(cross, 0.0);
        let slow = of_velocity(0.1, 77.0, FINE);
        assert!((slow[0].sqrt() - slow[2].sqrt()).abs() < 5e-3, "{slow:?}");
        let [east, _, north] = of_velocity(20.0, 90.0, FINE);
        assert!(east.sqrt() > 0.4 * MPS_PER_KT / 2.0 && north.sqrt() < 0.4 * MPS_PER_KT / 2.0);
        let coarse = VelocitySteps {
            speed_kt: 1.0,
            course_deg: 1.0,
        };
        assert!(of_velocity(10.0, 45.0, coarse)[0] > of_velocity(10.0, 45.0, FINE)[0]);
    }
}
