//! Sentences of alerts.

use std::fmt::Write as _;

use messages::{Alert, AlertKind, Identity, alert_value_bits};

use crate::settings::{FOOT_M, KNOT_MPS, NAUTICAL_MILE_M};

/// What a target is called: by its callsign or name, else by the number of its track.
pub(crate) fn label(identity: &Identity, number: u32) -> String {
    let given = identity.callsign().or_else(|| identity.name()).map(str::trim);
    match given.filter(|text| !text.is_empty()) {
        Some(given) => messages::printable(given, 20),
        None => format!("#{number}"),
    }
}

/// The sentence of an alert about targets with these labels; `event` is what a target itself states.
pub(crate) fn sentence(alert: &Alert, area: &str, labels: [&str; 2], event: &str) -> String {
    let [one, other] = labels;
    let is_ahead = alert.has(alert_value_bits::PREDICTED);
    let mut text = match alert.kind() {
        Some(AlertKind::Conflict | AlertKind::Approach) => pair(alert, one, other),
        Some(AlertKind::Enter) if is_ahead => format!("{one} will be in {area}"),
        Some(AlertKind::Enter) => format!("{one} is in {area}"),
        Some(AlertKind::Leave) if is_ahead => format!("{one} will leave {area}"),
        Some(AlertKind::Leave) => format!("{one} has left {area}"),
        Some(AlertKind::Stay) => format!("{one} has been in {area} for {:.0} s", alert.value),
        Some(AlertKind::Low) if is_ahead => format!("{one} will be below the least height"),
        Some(AlertKind::Low) => format!(
            "{one} is {:.0} ft below the least height",
            -f64::from(alert.value) / FOOT_M
        ),
        Some(AlertKind::Level) => {
            let feet = f64::from(alert.value) / FOOT_M;
            let side = if feet > 0.0 { "above" } else { "below" };
            format!("{one} is {:.0} ft {side} the permitted heights", feet.abs())
        }
        Some(AlertKind::Speed) => {
            let [speed, limit] = [alert.value, alert.limit].map(|mps| f64::from(mps) / KNOT_MPS);
            format!("{one} moves at {speed:.0} kn, the limit is {limit:.0} kn")
        }
        Some(AlertKind::Lost) => format!("{one} is no longer reported"),
        Some(AlertKind::Emergency) => format!("{one}: {event}"),
        None => one.to_owned(),
    };
    if is_ahead {
        let _ = write!(
            text,
            " in {:.0} s, probability {:.2}",
            alert.time_to_s, alert.probability
        );
    }
    let is_placed = !area.is_empty()
        && !matches!(
            alert.kind(),
            Some(AlertKind::Enter | AlertKind::Leave | AlertKind::Stay)
        );
    if is_placed {
        let _ = write!(text, " ({area})");
    }
    text
}

fn pair(alert: &Alert, one: &str, other: &str) -> String {
    let apart = |distance_m: f32, vertical_m: f32| {
        let miles = f64::from(distance_m) / NAUTICAL_MILE_M;
        match alert.has(alert_value_bits::VERTICAL) {
            true => format!("{miles:.1} NM and {:.0} ft", f64::from(vertical_m) / FOOT_M),
            false => format!("{miles:.2} NM"),
        }
    };
    let least = apart(alert.least_distance_m, alert.least_vertical_m);
    match alert.has(alert_value_bits::PREDICTED) {
        true => format!("{one} and {other} will pass each other at {least}, too close"),
        false => format!(
            "{one} and {other} are {} apart",
            apart(alert.distance_m, alert.vertical_m)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_name_the_targets_and_their_distances() {
        let conflict = Alert {
            kind: AlertKind::Conflict.code(),
            probability: 0.93,
            time_to_s: 87.2,
            least_distance_m: 3_704.0,
            least_vertical_m: 121.9,
            valid: alert_value_bits::PREDICTED | alert_value_bits::VERTICAL | alert_value_bits::DISTANCE,
            ..Alert::default()
        };
        assert_eq!(
            sentence(&conflict, "", ["KLM12", "#7"], ""),
            "KLM12 and #7 will pass each other at 2.0 NM and 400 ft, too close in 87 s, probability 0.93"
        );
        let low = Alert {
            kind: AlertKind::Low.code(),
            value: -30.48,
            ..Alert::default()
        };
        assert_eq!(
            sentence(&low, "TMA", ["#7", ""], ""),
            "#7 is 100 ft below the least height (TMA)"
        );
        let enter = Alert {
            kind: AlertKind::Enter.code(),
            ..Alert::default()
        };
        assert_eq!(sentence(&enter, "R 12", ["#7", ""], ""), "#7 is in R 12");
    }
}
