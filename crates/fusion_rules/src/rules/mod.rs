//! Rules for weighing a target's sources.
//!
//! A rule receives contributions at a common reference time, and returns the share of each and the resulting state.
//! Topics, files and clocks are outside its view. A new rule is a file here, a line in [`REGISTRY`], and a line in
//! [`FusionRule`] with its name and the code in messages.

mod auto;
mod bar_shalom_campo;
mod best_source;
mod centres;
mod combination;
#[cfg(test)]
mod conformance;
mod covariance_intersection;
mod hand_over;
mod information;
mod inverse_trace;
mod matrices;
mod mosaic;
mod quality_factor;
mod system_filter;

use messages::{FusionRule, TrackState};

pub use centres::join;
use hand_over::HandOver;
use serde::{Deserialize, Serialize};

use crate::settings::RuleSettings;
use crate::state::State;

/// Source number for no source.
pub const NO_SOURCE: u16 = u16::MAX;

/// A rule in the registry.
#[derive(Debug)]
pub struct RuleEntry {
    /// Code in messages, which also gives the name.
    pub code: FusionRule,
    /// Single line for help texts.
    pub summary: &'static str,
    /// Assumption about the correlation of the sources' errors (BF-1).
    pub assumption: &'static str,
    /// Whether the returned covariance is meant as the true covariance, as shown by the normalised error squared;
    /// otherwise it is a bound.
    pub claims_consistency: bool,
    /// Whether a single reference point per target is kept if sources observe different points.
    pub keeps_points: bool,
    /// Whether the rule chooses a source by accuracy value and hands over between sources: coefficients k and first
    /// weights eta_0 then have an effect.
    pub chooses_by_accuracy: bool,
    /// Origin of the states.
    pub method: RuleMethod,
}

impl RuleEntry {
    /// Name on the command line and in the configuration.
    pub fn name(&self) -> &'static str {
        self.code.word()
    }

    /// Whether the rule takes states from the targets' filters.
    pub fn is_from_filter(&self) -> bool {
        matches!(self.method, RuleMethod::Filter)
    }
}

/// Origin of the states of a rule.
#[derive(Clone, Copy, Debug)]
pub enum RuleMethod {
    /// The state is the estimate of the target's filter, and a share is a source's contribution to the estimate. The
    /// rule keeps no memory of a target. Of candidates, source and share are filled in, the other values only if
    /// accuracy values are requested.
    Filter,
    /// State and shares are made from the candidates.
    Candidates(RuleFunction),
}

/// Fills the weights of a share per candidate and returns the state at the candidates' common time.
///
/// For each axis the weights lie in [0, 1] and sum to 1. `None`, and no weight above 0, if the rule can use none of
/// the candidates: then the system track coasts. To be called through [`fuse`].
pub type RuleFunction = fn(&RuleSettings, &Target<'_>, &mut RuleMemory, &mut [Share]) -> Option<State>;

/// All rules.
pub static REGISTRY: &[RuleEntry] = &[
    auto::ENTRY,
    system_filter::ENTRY,
    best_source::ENTRY,
    inverse_trace::ENTRY,
    quality_factor::ENTRY,
    mosaic::ENTRY,
    information::ENTRY,
    covariance_intersection::ENTRY,
    bar_shalom_campo::ENTRY,
];

/// The rule with a code.
pub fn entry(code: FusionRule) -> &'static RuleEntry {
    let entry = REGISTRY.iter().find(|entry| entry.code == code);
    entry.expect("every code has a rule")
}

/// A rule in serde's form.
pub mod by_code {
    use messages::FusionRule;
    use serde::de::{Deserialize, Deserializer, Error};
    use serde::{Serialize, Serializer};

    use super::{RuleEntry, entry};

    /// Writes the rule's code.
    ///
    /// # Errors
    /// Errors of the serializer.
    pub fn serialize<S: Serializer>(rule: &RuleEntry, serializer: S) -> Result<S::Ok, S::Error> {
        rule.code.code().serialize(serializer)
    }

    /// Reads a code.
    ///
    /// # Errors
    /// Errors of the deserializer, or if no rule has the code.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<&'static RuleEntry, D::Error> {
        let code = FusionRule::from_code(u8::deserialize(deserializer)?);
        code.map(entry).ok_or_else(|| D::Error::custom("no rule has this code"))
    }
}

/// Applies a rule to `target`. `shares` has a share per candidate, at least one; accuracy values are filled in for
/// every rule (TI-9).
pub fn fuse(
    rule: RuleFunction,
    settings: &RuleSettings,
    target: &Target<'_>,
    memory: &mut RuleMemory,
    shares: &mut [Share],
) -> Option<State> {
    for (share, candidate) in shares.iter_mut().zip(target.candidates) {
        *share = Share {
            accuracy: candidate.lambda,
            ..Share::default()
        };
    }
    rule(settings, target, memory, shares)
}

/// Fills a share per candidate with the contribution to the estimate of the target's filter.
#[inline]
pub fn share_out(candidates: &[Candidate], shares: &mut [Share]) {
    system_filter::share_out(candidates, shares);
}

/// Target in the view of a rule.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// Contributions at the reference time, in the order of the sources; at least one, at most one per source.
    pub candidates: &'a [Candidate],
    /// The reference time, UTC, nanoseconds.
    pub reference_ns: i64,
    /// The system track's state so far, at its own time.
    pub last: &'a State,
    /// Spectral density of the white-noise acceleration of targets, m²/s³.
    pub process_noise_m2ps3: f64,
}

/// Contribution of a source to a target at the reference time, in the view of a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Source number.
    pub source: u16,
    /// Priority for ties, smaller first.
    pub priority: u32,
    /// Observation error coefficient alpha = k·s, normalised if configured (TI-8).
    pub alpha: f64,
    /// V per axis, metres or metres per second; `None` without an earlier report (TI-10).
    pub residual: Option<[f64; 3]>,
    /// Accuracy value lambda = alpha·V, with V the norm over the axes common to all candidates (TI-9); infinite
    /// without V.
    pub lambda: f64,
    /// Age of the latest report, nanoseconds.
    pub age_ns: i64,
    /// Time between two reports of the source, nanoseconds.
    pub period_ns: i64,
    /// Whether the source has missed the expected report (TI-15).
    pub overdue: bool,
    /// Whether the contribution is no longer fresh, and included only to blend out the previous source (TI-15).
    pub stale: bool,
    /// State of the track at the source.
    pub life: TrackState,
    /// Trace over east and north delivered by the source itself (TI-16), brought to the reference time, m².
    pub trace_m2: Option<f64>,
    /// Quality index M: number of the last scans that confirmed the track (QF-4).
    pub quality: u32,
    /// Share in the estimate of the target's filter, not yet scaled to sum to 1.
    pub filter_share: f64,
    /// Latest report, brought to the reference time.
    pub state: State,
}

impl Candidate {
    /// alpha·V with V over two axes or all three.
    #[inline]
    pub(crate) fn lambda_over(&self, three_axes: bool) -> f64 {
        let norm = |[x, y, z]: [f64; 3]| {
            let z = if three_axes { z } else { 0.0 };
            (x * x + y * y + z * z).sqrt()
        };
        self.residual.map_or(f64::INFINITY, |v| self.alpha * norm(v))
    }

    /// Accuracy value of each axis (TI-6), metres; 0 if there is none.
    #[inline]
    pub fn lambda_by_axis(&self) -> [f32; 3] {
        let residual = self.residual.unwrap_or_default();
        let mut lambda = residual.map(|part| (self.alpha * part.abs()) as f32);
        if !self.state.has_height {
            lambda[2] = 0.0;
        }
        lambda
    }
}

impl Candidate {
    /// Trace over east and north: as stated by the source, else of the covariance; `None` if the value cannot be a
    /// trace.
    pub(crate) fn usable_trace_m2(&self) -> Option<f64> {
        let trace_m2 = self.trace_m2.unwrap_or_else(|| self.state.horizontal_trace_m2());
        (trace_m2 > 0.0 && trace_m2.is_finite()).then_some(trace_m2)
    }
}

impl Default for Candidate {
    fn default() -> Self {
        Self {
            source: NO_SOURCE,
            priority: 0,
            alpha: 0.0,
            residual: None,
            lambda: f64::INFINITY,
            age_ns: 0,
            period_ns: 1,
            overdue: false,
            stale: false,
            life: TrackState::Confirmed,
            trace_m2: None,
            quality: 0,
            filter_share: 0.0,
            state: State::default(),
        }
    }
}

/// Share of a candidate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// Coefficient eta per axis, in [0, 1].
    pub weight: [f64; 3],
    /// Accuracy value lambda (TI-9); infinite without a value.
    pub accuracy: f64,
    /// Whether the candidate's trace was requested and could not be used (TI-16).
    pub trace_unusable: bool,
    /// Whether the candidate's covariance was not positive definite, and was repaired or left out.
    pub repaired: bool,
}

/// Memory of a rule on candidates, per target between refreshes (TI-12).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RuleMemory {
    /// Source chosen last time, per axis; [`NO_SOURCE`] if the rule chooses none.
    pub selected: [u16; 3],
    /// State of the hand-over between sources, per axis (TI-13).
    pub(crate) hand_overs: [HandOver; 3],
}

impl RuleMemory {
    /// Whether the last stored report of `source` may still be needed after its end of freshness.
    #[inline]
    pub fn holds(&self, source: u16) -> bool {
        self.hand_overs.iter().any(|hand_over| hand_over.holds(source))
    }
}

impl Default for RuleMemory {
    fn default() -> Self {
        Self {
            selected: [NO_SOURCE; 3],
            hand_overs: [HandOver::default(); 3],
        }
    }
}

#[cfg(test)]
pub(crate) mod testing {
    //! Rules called by hand.

    use std::sync::LazyLock;

    use super::*;

    /// A target without past.
    pub(crate) fn target(candidates: &[Candidate]) -> Target<'_> {
        static NOWHERE: LazyLock<State> = LazyLock::new(State::default);
        Target {
            candidates,
            reference_ns: 0,
            last: &NOWHERE,
            process_noise_m2ps3: 1.0,
        }
    }

    /// Returns the result of `rule`, a rule on candidates, with default options and no memory.
    pub(crate) fn fused_of(rule: &'static RuleEntry, candidates: &[Candidate]) -> (Option<State>, Vec<Share>) {
        let settings = RuleSettings {
            name: crate::settings::RuleName(rule.code),
            ..RuleSettings::default()
        };
        let mut shares = vec![Share::default(); candidates.len()];
        let state = match rule.method {
            RuleMethod::Candidates(rule) => fuse(
                rule,
                &settings,
                &target(candidates),
                &mut RuleMemory::default(),
                &mut shares,
            ),
            RuleMethod::Filter => unreachable!("its states are the engine's"),
        };
        (state, shares)
    }

    /// The same for a fixed number of candidates.
    pub(crate) fn fused<const N: usize>(
        rule: &'static RuleEntry,
        candidates: &[Candidate; N],
    ) -> (Option<State>, [Share; N]) {
        let (state, shares) = fused_of(rule, candidates);
        (state, shares.try_into().expect("one share per candidate"))
    }
}
