//! Quality of alerts on targets, against the future that the truth has.
//!
//! An alert states that something happens, or is going to. Whoever watches the picture afterwards sees the tracks, not
//! what happened: a track that jumps makes a conflict that no aircraft flew. The truth decides instead. Its targets
//! fly on after the alert, so their own paths show whether and when the minima were violated ([`violations`]).
//!
//! 1. Tracks get the targets that they follow, second by second, by the pairs of [`crate::continuity`] ([`followed`]).
//! 2. An alert thereby is one on a target, or a pair of targets, and perhaps an area. It is *right* if this subject is
//!    in violation at some time from the alert's raising until its clearing plus the look-ahead; else a *nuisance*.
//!    Where the truth ends before, nobody knows: the alert is *undecided*.
//! 3. A violation with a right alert is a *hit*, another a *miss*. The first right alert has the *lead time*, from its
//!    raising to the begin of the violation; a hit without a lead is *late*. Each further one is a *duplicate*.
//! 4. A hit is *in time* if its lead is at least a minute, or if it was raised as soon as both targets had a track.
//!
//! Judged are `conflict` (aircraft), `approach` (ships) and `enter` (areas); alerts of other kinds are counted.
//! Predicted probabilities are compared with frequencies ([`reliability`]).
//!
//! Source of the minima: ICAO Doc 4444, *Air Traffic Management*, chapter 5.

mod alert_table;
mod followed;
mod judging;
mod reliability;
mod violations;

use areas::Area;
use serde::Serialize;

pub use alert_table::AlertTable;
use followed::Followed;
use judging::judged;
pub use judging::{AlertFigures, KindScore, MissedEvent};
use reliability::reliability;
pub use reliability::{KindReliability, ReliabilityBin};
use violations::Violations;

use crate::picture::{PictureError, Timeline};

const NAUTICAL_MILE_M: f64 = 1852.0;
const FOOT_M: f64 = 0.3048;

/// Words of the kinds of alerts.
pub const ALERT_KINDS: [&str; 10] = [
    "enter",
    "leave",
    "stay",
    CONFLICT,
    APPROACH,
    "low",
    "speed",
    "level",
    "lost",
    "emergency",
];
const CONFLICT: &str = "conflict";
const APPROACH: &str = "approach";
const ENTER: &str = ALERT_KINDS[0];

/// Least distances of two targets. A pair violates them while it is nearer than both at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Minima {
    /// Horizontal distance of two aircraft, metres (5 NM).
    pub horizontal_m: f64,
    /// Vertical distance of two aircraft, metres (1,000 ft).
    pub vertical_m: f64,
    /// The same where one of both is above flight level 410 (2,000 ft).
    pub vertical_high_m: f64,
    /// Distance of two ships, metres (0.5 NM).
    pub ships_m: f64,
}

impl Default for Minima {
    fn default() -> Self {
        Self {
            horizontal_m: 5.0 * NAUTICAL_MILE_M,
            vertical_m: 1000.0 * FOOT_M,
            vertical_high_m: 2000.0 * FOOT_M,
            ships_m: 0.5 * NAUTICAL_MILE_M,
        }
    }
}

/// Settings of a comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AlertScoreSettings {
    /// Least distances of two targets.
    pub minima: Minima,
    /// Distance up to which a track follows a target, metres.
    pub gate_m: f64,
    /// Time after the clearing of an alert in which a violation makes it right, seconds; usually that of its kind: 120
    /// of `conflict`, 900 of `approach`, 0 of `enter`.
    pub look_ahead_s: Option<f64>,
}

impl AlertScoreSettings {
    fn look_ahead_s(&self, kind: &str) -> f64 {
        self.look_ahead_s.unwrap_or(match kind {
            CONFLICT => 120.0,
            APPROACH => 900.0,
            _ => 0.0,
        })
    }
}

/// Figures of all alerts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AlertScore {
    /// First and last second of the truth.
    pub first_s: i64,
    /// Last second of the truth.
    pub last_s: i64,
    /// Targets of the truth.
    pub targets: u64,
    /// Tracks that followed a target.
    pub tracks: u64,
    /// Whether heights are those above the ellipsoid. Without the origin of the frame they are those above its plane,
    /// which are wrong far from the origin.
    pub heights_above_ellipsoid: bool,
    /// Rows `cleared` of alerts that were not in force.
    pub cleared_without_raised: u64,
    /// By kind, in the order of [`ALERT_KINDS`]; kinds without alerts and without violations are left out.
    pub kinds: Vec<KindScore>,
    /// Frequencies beside predicted probabilities, of the kinds with rows `predicted`.
    pub reliability: Vec<KindReliability>,
}

/// Scores alerts. Without `areas`, alerts of the kind `enter` are counted only.
///
/// # Errors
/// If the truth is empty.
pub fn score_alerts(
    truth: &Timeline,
    tracks: &Timeline,
    table: &AlertTable,
    settings: &AlertScoreSettings,
    areas: &[Area],
) -> Result<AlertScore, PictureError> {
    let span = truth.span(truth.first_second().ok_or(PictureError::NoTruth)?, None)?;
    let frame = tracks.basis().known_frame().or(truth.basis().known_frame());
    let violations = Violations::of(truth, span, frame.as_ref(), &settings.minima, areas);
    let followed = Followed::of(truth, tracks, span, settings.gate_m);
    Ok(AlertScore {
        first_s: span.0,
        last_s: span.1,
        targets: violations.targets(),
        tracks: followed.tracks(),
        heights_above_ellipsoid: frame.is_some(),
        cleared_without_raised: table.cleared_without_raised,
        kinds: judged(&violations, &followed, &table.alerts, settings, span),
        reliability: reliability(&violations, &followed, &table.predictions, settings),
    })
}

#[cfg(test)]
mod tests;
