//! Coarse clocks: sources whose time stamps are multiples of a step.
//!
//! A report that is stamped in whole seconds shows a position of another instant, up to a second later. If the period
//! of the source is a multiple of the step, the offset is the same for all reports: no average removes it, and no
//! innovation shows it. The stamps show the step T, so the offset is known up to T:
//!
//! | `stamps` | the position is of | mean offset | variance |
//! |---|---|---|---|
//! | `down` | t … t + T | T/2 later | T²/12 |
//! | `nearest` | t − T/2 … t + T/2 | none | T²/12 |
//! | `unknown` | t − T … t + T | none | T²/3 |
//! | `exact` | t | none | 0 |
//!
//! The mean and the variance are the prior of the time offset in `registration`, which finds the differences between
//! the sources. The common part shows in no difference: the sources decide by the inverse variances, so a source with
//! a fine clock decides against coarse clocks. A clock far off counts less (a robust mean, by P. J. Huber, *Robust
//! estimation of a location parameter*, Annals of Mathematical Statistics 35, 1964). The published covariance of a
//! target contains the rest, along the course ([`Sources::course_s2`](crate::Sources::course_s2)).
//!
//! A step is a member of [`STEPS_NS`] of which nearly all stamps are multiples; a few odd stamps are allowed, and
//! errors of a conversion through `f32` seconds of a day. Each stamp counts once, however many reports have it.
//!
//! Whole seconds do not always come from rounding. A radar with a turn of four seconds that really measures at whole
//! seconds, and a rounded radar, give the same stamps. The period *explains* the step if all times between stamps are
//! multiples of the shortest time between two reports of a track. The state is then doubtful: other sources with fine
//! stamps would show the offset, so the step counts only where no source has fine stamps, or where the
//! configuration states the rounding. The largest step is then a second, and the smallest step of the doubtful sources
//! holds for all, since a period hides a smaller step.
//!
//! Limits: steps below 0.4 s are fine: the offset is within the accuracy of usual trackers. A source without
//! velocities in its reports is not moved. A source is fine for good once [`DECIDED`] stamps are.

use kept::kept;
use messages::NS_PER_S;
use serde::{Deserialize, Serialize};

use crate::settings::{SourceSettings, StampRounding};

/// Recognised steps, from the longest on, nanoseconds. All divide a day, so that the time zone is irrelevant.
pub(crate) const STEPS_NS: [i64; 6] = [
    10_000_000_000,
    5_000_000_000,
    2_000_000_000,
    1_000_000_000,
    500_000_000,
    400_000_000,
];
/// First step that a source with an explained period may have: clocks that count in more than seconds are rare.
const EXPLAINED_FROM: usize = 3;
/// Largest distance of a stamp from a multiple, nanoseconds: seconds of a day as `f32` are in error by 4 ms.
const TOLERANCE_NS: i64 = 5_000_000;
/// Number of different stamps before a step counts, with a stated rounding and without.
const STAMPS_MIN: [u16; 2] = [3, 6];
/// Number of different stamps that decide that a source is fine.
const DECIDED: u16 = 16;
/// Stamps from which on the counts are halved, so that the latest stamps count.
const STAMPS_MAX: u16 = 256;
/// One stamp in so many may be odd.
const ODD: u16 = 8;
/// Standard deviation of the time offset of a fine clock beside coarse clocks, seconds.
const FINE_SIGMA_S: f64 = 0.05;
/// Distance from the mean offset beyond which a source weighs less, in standard deviations: rounding errs by 1.8.
const NEAR_SIGMAS: f64 = 2.0;

kept! {
    /// Time offset that the stamps of a source imply; both 0 for fine stamps.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    pub struct StampError {
        /// Mean, seconds; as a time offset of registration, so negative for stamps that are too early.
        pub mean_s: f64,
        /// Variance, s².
        pub variance_s2: f64,
    }
}

impl StampError {
    /// Returns the error by rounding to multiples of `step_s`, seconds.
    fn of(rounding: StampRounding, step_s: f64) -> Self {
        let (mean, parts) = match rounding {
            StampRounding::Down => (-0.5, 12.0),
            StampRounding::Nearest => (0.0, 12.0),
            StampRounding::Unknown => (0.0, 3.0),
            StampRounding::Exact => return Self::default(),
        };
        Self {
            mean_s: mean * step_s,
            variance_s2: step_s * step_s / parts,
        }
    }

    /// Whether the clock is coarse.
    #[inline]
    pub(crate) fn is_coarse(&self) -> bool {
        self.variance_s2 > 0.0
    }

    /// Returns the inverse variance of the offset, s⁻².
    pub(crate) fn information(&self) -> f64 {
        let variance_s2 = if self.is_coarse() {
            self.variance_s2
        } else {
            FINE_SIGMA_S * FINE_SIGMA_S
        };
        1.0 / variance_s2
    }

    /// Returns the weight of a source with the time offset `offset_s` in the common offset of all sources: the inverse
    /// variance near the mean, less beyond.
    pub(crate) fn closeness(&self, offset_s: f64) -> f64 {
        let (information, apart_s) = (self.information(), offset_s - self.mean_s);
        information / (information.sqrt() * apart_s.abs() / NEAR_SIGMAS).max(1.0)
    }
}

/// Step of a source's clock, as the stamps show it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ClockStep {
    /// Too few stamps.
    Open,
    Fine,
    /// The period of the source explains the step, nanoseconds.
    Explained(i64),
    Coarse(i64),
}

kept! {
    /// Stamps of a source.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    pub struct Stamps {
        latest_ns: i64,
        /// Shortest time between two reports of a track, nanoseconds; 0 before the first.
        interval_ns: i64,
        /// Different stamps.
        count: u16,
        /// Stamps off the multiples of each step.
        off: [u16; STEPS_NS.len()],
        /// Times between stamps that are no multiples of the interval.
        uneven: u16,
        is_fine: bool,
        /// Step that counts, nanoseconds; 0: none.
        step_ns: i64,
    }
}

/// Whether a time is a multiple of a step.
#[inline]
fn is_multiple(time_ns: i64, step_ns: i64) -> bool {
    let rest_ns = time_ns.rem_euclid(step_ns);
    rest_ns.min(step_ns - rest_ns) <= TOLERANCE_NS
}

impl Stamps {
    /// Learns from a stamp, as the source gave it, nanoseconds.
    #[inline]
    pub fn learn(&mut self, time_ns: i64) {
        if !self.is_fine {
            self.count(time_ns);
        }
    }

    fn count(&mut self, time_ns: i64) {
        let since_ns = time_ns.saturating_sub(self.latest_ns).saturating_abs();
        if since_ns <= TOLERANCE_NS && self.count > 0 {
            return;
        }
        for (off, step_ns) in self.off.iter_mut().zip(STEPS_NS) {
            *off += u16::from(!is_multiple(time_ns, step_ns));
        }
        if self.count > 0 && self.interval_ns > 0 {
            self.uneven += u16::from(!is_multiple(since_ns, self.interval_ns));
        }
        self.latest_ns = time_ns;
        self.count += 1;
        self.is_fine = self.count >= DECIDED && self.step() == ClockStep::Fine;
        if self.count >= STAMPS_MAX {
            self.count /= 2;
            self.uneven /= 2;
            self.off.iter_mut().for_each(|off| *off /= 2);
        }
    }

    /// Learns from the time between two reports of a track, nanoseconds.
    #[inline]
    pub(crate) fn follow(&mut self, since_ns: i64) {
        if !self.is_fine && since_ns > TOLERANCE_NS && (self.interval_ns == 0 || since_ns < self.interval_ns) {
            self.interval_ns = since_ns;
        }
    }

    fn step(&self) -> ClockStep {
        let is_rare = |count: u16| count <= self.count / ODD;
        if self.is_fine {
            return ClockStep::Fine;
        }
        let on = |from: usize| (from..STEPS_NS.len()).find(|step| is_rare(self.off[*step]));
        let Some(longest) = on(0) else {
            // One odd stamp proves nothing.
            let least = self.off.iter().copied().min().unwrap_or_default();
            return if least > 1 { ClockStep::Fine } else { ClockStep::Open };
        };
        match (is_rare(self.uneven), on(EXPLAINED_FROM)) {
            (true, Some(step)) => ClockStep::Explained(STEPS_NS[step]),
            (true, None) => ClockStep::Open,
            (false, _) => ClockStep::Coarse(STEPS_NS[longest]),
        }
    }

    /// Returns the step of which the stamps are multiples, seconds; `None` if the stamps are fine or too few.
    pub fn multiples_of_s(&self) -> Option<f64> {
        match self.step() {
            ClockStep::Coarse(step_ns) | ClockStep::Explained(step_ns) if self.count >= STAMPS_MIN[1] => {
                Some(step_ns as f64 / NS_PER_S)
            }
            _ => None,
        }
    }

    /// Returns the recognised step that counts, seconds; 0 for a fine clock.
    pub(crate) fn step_s(&self) -> f64 {
        self.step_ns as f64 / NS_PER_S
    }

    /// Returns the error by the step that counts.
    pub(crate) fn error(&self, rounding: Option<StampRounding>) -> StampError {
        match self.step_ns {
            0 => StampError::default(),
            _ => StampError::of(rounding.unwrap_or(StampRounding::Unknown), self.step_s()),
        }
    }
}

/// Decides which steps count; returns whether any does.
pub(crate) fn look(all: &mut [Stamps], sources: &[SourceSettings]) -> bool {
    // Others show no offset: they are not compared, or a centre, which states the time that its states are for.
    let is_compared = |source: &SourceSettings| source.is_registered && !source.is_centre;
    let step = |stamps: &Stamps, source: &SourceSettings| match source.stamps {
        Some(StampRounding::Exact) => ClockStep::Fine,
        _ => stamps.step(),
    };
    let is_any_fine = all
        .iter()
        .zip(sources)
        .any(|(stamps, source)| is_compared(source) && step(stamps, source) == ClockStep::Fine);
    let explained = all
        .iter()
        .zip(sources)
        .filter_map(|(stamps, source)| match step(stamps, source) {
            ClockStep::Explained(step_ns) if is_compared(source) || source.stamps.is_some() => Some(step_ns),
            _ => None,
        });
    let smallest_ns = explained.min().unwrap_or_default();
    let mut is_any_coarse = false;
    for (stamps, source) in all.iter_mut().zip(sources) {
        let is_stated = source.stamps.is_some();
        let step_ns = match step(stamps, source) {
            ClockStep::Coarse(step_ns) if is_stated || !source.is_centre => step_ns,
            ClockStep::Explained(_) if is_stated || (is_compared(source) && !is_any_fine) => smallest_ns,
            _ => 0,
        };
        let has_enough = stamps.count >= STAMPS_MIN[usize::from(!is_stated)];
        stamps.step_ns = if has_enough { step_ns } else { 0 };
        is_any_coarse |= stamps.step_ns != 0;
    }
    is_any_coarse
}

#[cfg(test)]
#[path = "stamps_tests.rs"]
mod tests;
