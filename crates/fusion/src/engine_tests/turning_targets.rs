//! Targets that turn, whatever their sources say of themselves.

use messages::{FusionRule, HorizontalMovement, LongitudinalMovement, VerticalMovement};
use test_support::Random;

use super::*;
use crate::settings::RuleName;

/// Speed, m/s; acceleration in a turn, m/s²; standard deviation of a measured position per axis, m.
const SPEED_MPS: f64 = 200.0;
const ACCELERATION_MPS2: f64 = 7.0;
const SIGMA_M: f64 = 50.0;
/// Seconds between which targets turn.
const TURN_S: [f64; 2] = [60.0, 90.0];

/// Place and velocity of a target that flies north, then turns to the right, then flies straight.
fn truth(time_s: f64) -> ([f64; 2], [f64; 2]) {
    let rate = ACCELERATION_MPS2 / SPEED_MPS;
    let turned = |time_s: f64| rate * (time_s.clamp(TURN_S[0], TURN_S[1]) - TURN_S[0]);
    let velocity = |time_s: f64| [SPEED_MPS * turned(time_s).sin(), SPEED_MPS * turned(time_s).cos()];
    let radius_m = SPEED_MPS / rate;
    let (turned, straight_s) = (turned(time_s), (time_s - TURN_S[1]).max(0.0));
    let [east, north] = velocity(time_s);
    let place = [
        radius_m * (1.0 - turned.cos()) + straight_s * east,
        SPEED_MPS * time_s.min(TURN_S[0]) + radius_m * turned.sin() + straight_s * north,
    ];
    (place, [east, north])
}

/// Root of the mean square of the distance of the published positions from the truth, from `since_s` to `until_s`,
/// metres, and the last of them, with two sources that give constant covariances, as ASTERIX mostly does.
fn error_m(since_s: f64, until_s: f64) -> (f64, SystemTrack) {
    let mut settings = test_settings(2);
    settings.rule.name = RuleName(FusionRule::Auto);
    let mut harness = Harness::new(settings);
    let mut random = Random::new(5);
    let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
    let (mut sum, mut count, mut last) = (0.0, 0.0, None);
    for step in 0..240 {
        let time_s = 0.5 * f64::from(step);
        let (place, velocity) = truth(time_s);
        for target in 0..5u32 {
            let far_m = 20e3 * f64::from(target);
            let measured = SensorTrack {
                position_m: [
                    far_m + place[0] + SIGMA_M * normal(),
                    place[1] + SIGMA_M * normal(),
                    0.0,
                ],
                covariance: Covariance::diagonal([SIGMA_M; 3], [20.0; 3]),
                ..report((step % 2) as u16, target, time_s, [0.0; 2], velocity)
            };
            if let Some(track) = harness.take(&measured)
                && (since_s..until_s).contains(&time_s)
            {
                let [east, north, _] = track.position_m;
                sum += (east - far_m - place[0]).powi(2) + (north - place[1]).powi(2);
                count += 1.0;
                last = Some(track);
            }
        }
    }
    (f64::sqrt(sum / count), last.unwrap())
}

#[test]
fn a_turn_is_followed_though_nobody_says_how_targets_move() {
    let (straight_m, _) = error_m(40.0, TURN_S[0]);
    assert!(straight_m < 0.5 * SIGMA_M, "{straight_m}");
    let (turning_m, _) = error_m(TURN_S[0], TURN_S[1]);
    assert!(turning_m < 1.2 * SIGMA_M, "{turning_m}");
}

#[test]
fn a_turn_is_told_with_its_side_and_acceleration() {
    let (_, straight) = error_m(40.0, TURN_S[0]);
    assert_eq!(straight.movement.horizontal, HorizontalMovement::Straight as u8);
    assert_eq!(straight.movement.longitudinal, LongitudinalMovement::Constant as u8);
    assert_eq!(
        straight.movement.vertical,
        VerticalMovement::Unknown as u8,
        "nobody observes height"
    );
    let (_, turning) = error_m(TURN_S[0], TURN_S[0] + 20.0);
    assert_eq!(turning.movement.horizontal, HorizontalMovement::TurnRight as u8);
    let [east, north, _] = turning.movement.acceleration_mps2;
    let acceleration_mps2 = f64::from(east.hypot(north));
    assert!(
        (0.5..1.5).contains(&(acceleration_mps2 / ACCELERATION_MPS2)),
        "{acceleration_mps2}"
    );
}
