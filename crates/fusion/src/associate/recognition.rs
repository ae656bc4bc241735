//! Confirmation by identity: a second report with the same address.
//!
//! A position without a name may be noise, and noise has to repeat several times before it is believed. Noise has no
//! address: a second report with an address, within reach of the target of the first, is of the same target. This
//! holds for any time between the two. A target reported once a minute is thus shown as soon as possible.
//!
//! The exception is an address with wrong bits. Each transponder is misread now and then, the same bit comes again
//! after some hundred reports, and both lie on the path of one aircraft. A report inside the gate of a confirmed track
//! with another address therefore recognises nothing. If the two addresses differ in few bits, the report is no
//! evidence of a further target at all, unless the source has reported the confirmed target besides, in the same scan:
//! a misread report takes the place of the right report. [`TOGETHER`] such scans distinguish the two.
//!
//! Limit: two targets with similar addresses are shown as a single target, if one is always in the gate of the other
//! and no source reports both in one scan.

use estimation::{Gaussian, length};
use messages::{NS_PER_S, SensorTrack};
use serde::{Deserialize, Serialize};
use source_models::gaussian_of;

/// Number of scans with both targets that shows two targets. If reports have no rhythm, the right report lies near the
/// misread report by chance in two of five cases.
const TOGETHER: u8 = 3;
/// Position error allowed for, in standard deviations.
const POSITION_SIGMAS: f64 = 5.0;
const VELOCITY_SIGMAS: f64 = 3.0;
/// Greatest acceleration of a target between two reports, m/s².
const MANOEUVRE_MPS2: f64 = 10.0;

/// Evidence from the reports of a system track with an address that was never shown.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Recognition {
    /// Whether a report agreed with the previous report, away from any confirmed track of another address.
    is_sure: bool,
    /// Whether the latest report may be a misreading of another address.
    is_doubted: bool,
    /// Scans with this target and the target that may be meant.
    together: u8,
}

/// Surroundings of a report with an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Beside {
    /// No confirmed track of another address.
    Nothing,
    /// A confirmed track; whether its address may be the right address of this report, and whether the source may have
    /// reported this track, too.
    Other { is_alike: bool, is_together: bool },
}

impl Recognition {
    /// Whether the identity shows the existence of a target.
    pub(crate) fn is_sure(&self) -> bool {
        self.is_sure
    }

    /// Whether the address may be a misreading of another address.
    pub(crate) fn is_doubted(&self) -> bool {
        self.is_doubted
    }

    pub(crate) fn note(&mut self, agrees: bool, beside: Beside) {
        let (is_alike, is_together) = match beside {
            Beside::Nothing => (false, false),
            Beside::Other { is_alike, is_together } => (is_alike, is_together),
        };
        self.is_sure |= agrees && beside == Beside::Nothing;
        self.together = self.together.saturating_add(u8::from(is_together));
        self.is_doubted = !self.is_sure && is_alike && self.together < TOGETHER;
    }
}

/// Whether the target of a report can have reached the place of a later report.
pub(crate) fn is_reachable(before: &SensorTrack, report: &SensorTrack) -> bool {
    let seconds = (report.time_of_measurement_ns - before.time_of_measurement_ns) as f64 / NS_PER_S;
    seconds > 0.0 && can_come_to(&gaussian_of(before), &gaussian_of(report), seconds)
}

/// Whether a target can change from one state to another in `seconds`: by straight flight, or by manoeuvres without a
/// speed above the larger speed of both states.
pub(crate) fn can_come_to(before: &Gaussian, after: &Gaussian, seconds: f64) -> bool {
    let sigma = |axis: usize| {
        let variance = |state: &Gaussian| state.covariance.get(axis, axis) + state.covariance.get(axis + 1, axis + 1);
        (variance(before) + variance(after)).sqrt()
    };
    let apart = |axis: usize| after.mean[axis] - before.mean[axis] - seconds * before.mean[axis + 3];
    let speed = |state: &Gaussian| length([state.mean[3], state.mean[4]]);
    let turned_mps = (0.5 * MANOEUVRE_MPS2 * seconds).min(2.0 * speed(before).max(speed(after)));
    let reach_m = POSITION_SIGMAS * sigma(0) + (VELOCITY_SIGMAS * sigma(3) + turned_mps) * seconds;
    length([apart(0), apart(1)]) <= reach_m
}
