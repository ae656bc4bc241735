//! Errors of positions and velocities of squitters: as large as their categories state, for every category.

use std::f64::consts::TAU;

use ::frames::{Geodetic, SystemFrame};
use observations::RADIUS95_SIGMAS;
use test_support::Random;

use super::values::status;
use super::*;
use crate::normalised::{Nees, normal};

const A: u32 = 0x3c_6589;
const KT: f64 = 1852.0 / 3600.0;
/// Bounds of the errors of 95 % of the positions, metres, for NACp 6 to 11: RTCA DO-260B.
const NACP_M: [(u64, f64); 6] = [(6, 555.6), (7, 185.2), (8, 92.6), (9, 30.0), (10, 10.0), (11, 3.0)];
/// The same of velocities, metres per second, for NACv 1 to 4.
const NACV_MPS: [(u64, f64); 4] = [(1, 10.0), (2, 3.0), (3, 1.0), (4, 0.3)];

/// A velocity towards east and north in knots, rounded as transponders do.
fn velocity(category: u64, velocity_mps: [f64; 2]) -> String {
    let [east, north] = velocity_mps.map(|part| (part / KT).round());
    let signed = |part: f64| [(u64::from(part < 0.0), 1), (part.abs() as u64 + 1, 10)];
    let head = [(19, 5), (1, 3), (0, 2), (category, 3)];
    let rate = [(1, 1), (0, 1), (1, 9)];
    squitter(
        0x8d,
        A,
        message(&[&head[..], &signed(east), &signed(north), &rate].concat()),
    )
}

/// Mean normalised squares of the errors of position and velocity of an aircraft, and the number of positions, with
/// errors of these bounds.
fn nees((nacp, bound_m): (u64, f64), (nacv, bound_mps): (u64, f64), seed: u64) -> ([f64; 2], u32) {
    let mut random = Random::new(seed);
    let frame = SystemFrame::at(Geodetic::from_degrees(RECEIVER.place_deg[0], RECEIVER.place_deg[1], 0.0).unwrap());
    let mut reader = reader(Some(RECEIVER));
    let (mut of_position, mut of_velocity) = (Nees::default(), Nees::default());
    // Legs in all directions from the receiver's place, where the meridian is that of the frame.
    for step in 0..4000 {
        let (leg, time_s) = (step / 20, 0.5 * f64::from(step));
        let course_rad = TAU * f64::from(leg) * 0.381_966;
        let true_mps = [course_rad.sin(), course_rad.cos()].map(|part| 220.0 * part);
        let from_begin_s = time_s - 0.5 * 20.0 * f64::from(leg);
        let true_m = true_mps.map(|part| part * from_begin_s);
        let [east, north] = true_m.map(|place| place + bound_m / RADIUS95_SIGMAS * normal(&mut random));
        let sent_mps = true_mps.map(|part| part + bound_mps / RADIUS95_SIGMAS * normal(&mut random));
        if step % 5 == 0 {
            take(&mut reader, &status(2, nacp, 3), time_s);
        }
        take(&mut reader, &velocity(nacv, sent_mps), time_s);
        let place = frame.to_geodetic([east, north, 0.0]);
        let place = [place.latitude_deg(), place.longitude_deg()];
        let Some(found) = observed(&take(&mut reader, &airborne(A, place, step % 2 == 1), time_s)) else {
            continue;
        };
        let [latitude, longitude] = found.geodetic.unwrap().map(f64::to_degrees);
        let found_m = frame.to_local(Geodetic::from_degrees(latitude, longitude, 0.0).unwrap());
        of_position.take_quality([found_m[0] - true_m[0], found_m[1] - true_m[1]], found.quality);
        let [east, north] = found.velocity.unwrap();
        let covariance = found.velocity_covariance.unwrap();
        of_velocity.take([east - true_mps[0], north - true_mps[1]], covariance);
    }
    ([of_position.mean(), of_velocity.mean()], of_position.count())
}

#[test]
fn errors_of_aircraft_are_as_large_as_their_categories() {
    for (nacp, nacv) in NACP_M.into_iter().zip(NACV_MPS.into_iter().cycle()) {
        let ([position, velocity], count) = nees(nacp, nacv, 1);
        println!(
            "NACp {}: NEES of position {position:.2}; NACv {}: of velocity {velocity:.2}; {count} positions",
            nacp.0, nacv.0
        );
        assert!(count > 3900, "{count}");
        assert!(
            (0.7..1.4).contains(&position) && (0.7..1.4).contains(&velocity),
            "{position} {velocity}"
        );
    }
}
