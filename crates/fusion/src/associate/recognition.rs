//! Confirmation by identity: a second report with the same address.
//!
//! A position without a name may be noise, and noise has to repeat itself several times before it is believed. Noise
//! has no address: a second report with one, where the target of the first can have come to, is of the same target.
//! That holds however long the time between the two, so that a target that is reported once a minute is shown as soon
//! as it can be.
//!
//! The exception is an address with wrong bits. Each transponder is misread now and then, the same bit comes again
//! after some hundred reports, and both lie on the path of one aircraft. A report inside the gate of a confirmed track
//! with another address therefore recognises nothing. Where the two addresses differ in few bits, the report is no
//! evidence of a further target at all, unless the source has reported the confirmed target besides, in the same scan:
//! a misread report takes the place of the right one. [`TOGETHER`] such scans distinguish the two.
//!
//! Limit: two targets with addresses alike, one of them always in the gate of the other, that no source reports in one
//! scan, are shown as one.

use estimation::Gaussian;
use messages::{NS_PER_S, SensorTrack};
use serde::{Deserialize, Serialize};
use source_models::gaussian_of;

/// Scans with both targets that show that they are two. Where reports follow no rhythm, the right one lies near the
/// misread one by chance in two of five cases.
const TOGETHER: u8 = 3;
/// Standard deviations by which a position may lie off.
const POSITION_SIGMAS: f64 = 5.0;
const VELOCITY_SIGMAS: f64 = 3.0;
/// Greatest acceleration of a target between two reports, m/s².
const MANOEUVRE_MPS2: f64 = 10.0;

/// What the reports of a system track that has an address, and was never shown, have shown of that.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Recognition {
    /// Whether a report agreed with the one before, away from any confirmed track of another address.
    is_sure: bool,
    /// Whether the latest report may be a misreading of another address.
    is_doubted: bool,
    /// Scans with this target and the one that it may be.
    together: u8,
}

/// What lies where a report with an address is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Beside {
    /// No confirmed track of another address.
    Nothing,
    /// One; its address may be the right one of this report or not, and the source may have reported it, too.
    Other { is_alike: bool, is_together: bool },
}

impl Recognition {
    /// Whether the identity shows that there is a target.
    pub(crate) fn is_sure(&self) -> bool {
        self.is_sure
    }

    /// Whether the address may be a misreading of another one.
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

/// Whether the target of one report can have come to where a later one is.
pub(crate) fn is_reachable(before: &SensorTrack, report: &SensorTrack) -> bool {
    let seconds = (report.time_of_measurement_ns - before.time_of_measurement_ns) as f64 / NS_PER_S;
    seconds > 0.0 && can_come_to(&gaussian_of(before), &gaussian_of(report), seconds)
}

/// Whether a target in one state can be in another one `seconds` later: by straight flight, or by manoeuvres in which
/// it is nowhere faster than it is in both.
pub(crate) fn can_come_to(before: &Gaussian, after: &Gaussian, seconds: f64) -> bool {
    let sigma = |axis: usize| {
        let variance = |state: &Gaussian| state.covariance.get(axis, axis) + state.covariance.get(axis + 1, axis + 1);
        (variance(before) + variance(after)).sqrt()
    };
    let apart = |axis: usize| after.mean[axis] - before.mean[axis] - seconds * before.mean[axis + 3];
    let speed = |state: &Gaussian| state.mean[3].hypot(state.mean[4]);
    let turned_mps = (0.5 * MANOEUVRE_MPS2 * seconds).min(2.0 * speed(before).max(speed(after)));
    let reach_m = POSITION_SIGMAS * sigma(0) + (VELOCITY_SIGMAS * sigma(3) + turned_mps) * seconds;
    apart(0).hypot(apart(1)) <= reach_m
}
