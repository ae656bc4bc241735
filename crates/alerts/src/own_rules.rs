//! Rules about a single target's own state: `low`, `level`, `speed` and `emergency`.

use areas::Level;
use messages::{IdentityKind, SystemTrack, alert_bits, alert_value_bits};

use crate::area_rules::normal;
use crate::board::Finding;
use crate::target::Target;

/// Mode 3/A codes of emergencies (ICAO Doc 4444, 8.5.2.4): code, and what it means.
const EMERGENCY_CODES: [(u16, &str); 3] = [
    (0o7500, "unlawful interference"),
    (0o7600, "no radio communication"),
    (0o7700, "emergency"),
];
/// First digits of the MMSI of devices that send in distress (ITU-R M.585): millions, and what they are.
const DISTRESS_DEVICES: [(u32, &str); 3] = [
    (970, "search and rescue transmitter"),
    (972, "man overboard"),
    (974, "distress beacon"),
];
/// Least standard deviations that are assumed, metres and metres per second.
const SIGMA_MIN_M: f64 = 1.0;
const SIGMA_MIN_MPS: f64 = 0.1;

/// Below a level, now or where a descent leads within a time.
pub(crate) fn below(target: &Target, level: Level, ahead_s: f64) -> Option<Finding> {
    let (above_m, sigma_m) = target.above(level)?;
    let now = normal(-above_m / sigma_m.max(SIGMA_MIN_M));
    let mut finding = Finding {
        probability: now,
        value: above_m,
        valid: alert_value_bits::VALUE,
        ..Finding::default()
    };
    if let Some(height) = target
        .height
        .filter(|height| ahead_s > 0.0 && height.climb_mps < 0.0 && now < 0.5)
    {
        let [hh, hc, cc] = height.covariance;
        let variance = hh + 2.0 * hc * ahead_s + cc * ahead_s * ahead_s;
        let ahead_m = above_m + height.climb_mps * ahead_s;
        let ahead = normal(-ahead_m / variance.max(0.0).sqrt().max(SIGMA_MIN_M));
        if ahead > now {
            finding.probability = ahead;
            finding.time_to_s = (-above_m / height.climb_mps).clamp(0.0, ahead_s);
            finding.valid |= alert_value_bits::PREDICTED;
        }
    }
    Some(finding)
}

/// Above a level now.
pub(crate) fn above(target: &Target, level: Level) -> Option<Finding> {
    let (above_m, sigma_m) = target.above(level)?;
    Some(Finding {
        probability: normal(above_m / sigma_m.max(SIGMA_MIN_M)),
        value: above_m,
        valid: alert_value_bits::VALUE,
        ..Finding::default()
    })
}

/// Speed beyond the permitted ones, metres per second.
pub(crate) fn speed(target: &Target, least_mps: Option<f64>, greatest_mps: Option<f64>) -> Finding {
    let (speed_mps, sigma_mps) = (target.speed_mps(), target.speed_sigma_mps().max(SIGMA_MIN_MPS));
    let slow = least_mps.map_or(0.0, |least| normal((least - speed_mps) / sigma_mps));
    let fast = greatest_mps.map_or(0.0, |greatest| normal((speed_mps - greatest) / sigma_mps));
    let limit = if fast >= slow { greatest_mps } else { least_mps };
    Finding {
        probability: slow.max(fast),
        value: speed_mps,
        limit: limit.unwrap_or_default(),
        valid: alert_value_bits::VALUE,
        ..Finding::default()
    }
}

/// What emergency a target states; `None` for none.
pub(crate) fn emergency(track: &SystemTrack) -> Option<&'static str> {
    let of_code = track.identity.mode_3a().and_then(|code| {
        let known = EMERGENCY_CODES.iter().find(|(emergency, _)| *emergency == code);
        known.map(|(_, meaning)| *meaning)
    });
    let is_ship = track.identity.kind == IdentityKind::Ship.code();
    let of_device = || {
        let known = DISTRESS_DEVICES
            .iter()
            .find(|(digits, _)| is_ship && track.identity.address / 1_000_000 == *digits);
        known.map(|(_, meaning)| *meaning)
    };
    let of_bits = || {
        let has = |bit| track.alerts & bit != 0;
        let bits = [
            (alert_bits::UNLAWFUL_INTERFERENCE, "unlawful interference"),
            (alert_bits::COMMUNICATION_FAILURE, "no radio communication"),
            (alert_bits::EMERGENCY, "emergency"),
        ];
        bits.into_iter().find(|(bit, _)| has(*bit)).map(|(_, meaning)| meaning)
    };
    of_code.or_else(of_device).or_else(of_bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::futures::tests::{frame, state};

    fn target(height_m: f64, climb_mps: f64) -> Target {
        Target::of(
            &state(1, [0.0, 0.0, height_m], [100.0, 0.0, climb_mps], [10.0, 1.0]),
            &frame(),
        )
        .unwrap()
    }

    #[test]
    fn a_descent_through_the_least_height_is_predicted() {
        let level = Level::Sea(500.0);
        let found = below(&target(700.0, -10.0), level, 30.0).unwrap();
        assert!(
            found.probability > 0.99 && (found.time_to_s - 20.0).abs() < 0.1,
            "{found:?}"
        );
        assert!(below(&target(700.0, -10.0), level, 10.0).unwrap().probability < 0.01);
        assert!(below(&target(700.0, 10.0), level, 60.0).unwrap().probability < 0.01);
        let found = below(&target(450.0, 0.0), level, 30.0).unwrap();
        assert!(found.probability > 0.99 && found.time_to_s == 0.0, "{found:?}");
        assert!(above(&target(700.0, 0.0), level).unwrap().probability > 0.99);
    }

    #[test]
    fn speeds_are_judged_by_their_accuracy() {
        let target = target(500.0, 0.0);
        assert!(speed(&target, None, Some(90.0)).probability > 0.99);
        assert!((speed(&target, None, Some(target.speed_mps())).probability - 0.5).abs() < 1e-6);
        assert!(speed(&target, Some(120.0), None).probability > 0.99);
        assert!(speed(&target, Some(50.0), Some(150.0)).probability < 0.01);
    }

    #[test]
    fn codes_devices_and_bits_state_emergencies() {
        let plain = state(1, [0.0; 3], [0.0; 3], [10.0, 1.0]);
        let with_code = |code| SystemTrack {
            identity: plain.identity.with_mode_3a(code),
            ..plain
        };
        assert_eq!(emergency(&with_code(0o7600)), Some("no radio communication"));
        assert_eq!(emergency(&with_code(0o7000)), None);
        let with_mmsi = |mmsi| SystemTrack {
            identity: messages::Identity::default().with_mmsi(mmsi),
            ..plain
        };
        assert_eq!(emergency(&with_mmsi(972_123_456)), Some("man overboard"));
        assert_eq!(emergency(&with_mmsi(211_123_456)), None);
        let with_bit = SystemTrack {
            alerts: alert_bits::EMERGENCY | alert_bits::SPECIAL_IDENTIFICATION,
            ..plain
        };
        assert_eq!(emergency(&with_bit), Some("emergency"));
    }
}
