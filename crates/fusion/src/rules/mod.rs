//! The rules that weigh a target's sources.
//!
//! A rule sees contributions that have already been brought to one reference time, and says how large a share each
//! one gets and which state they yield. It never sees topics, files, or a clock. A new rule is a file here and a line in
//! [`REGISTRY`].

mod auto;
mod best_source;
mod system_filter;

use messages::TrackState;

use crate::settings::RuleSettings;
use crate::state::State;

/// Source number that stands for none.
pub const NO_SOURCE: u16 = u16::MAX;

/// A rule, as the registry lists it.
#[derive(Debug)]
pub struct RuleEntry {
    /// Name on the command line and in the configuration.
    pub name: &'static str,
    /// One line for help texts.
    pub summary: &'static str,
    /// What the rule assumes about how the sources' errors are correlated (BF-1).
    pub assumption: &'static str,
    /// Whether the covariance it gives is meant to be the true one, which the normalised error squared shows; otherwise
    /// it is a bound.
    pub claims_consistency: bool,
    /// Whether one point of each target is kept where the sources see different ones.
    pub keeps_points: bool,
    /// Fills the weights of one share per candidate and returns the state at the candidates' common time.
    ///
    /// For each axis the weights lie in [0, 1] and sum to 1. `None`, and no weight above 0, if the rule can use none of
    /// the candidates: then the system track coasts. Call it through [`fuse`].
    pub fuse: fn(&RuleSettings, &Target<'_>, &mut Memory, &mut [Share]) -> Option<State>,
}

/// Every rule there is.
pub static REGISTRY: &[RuleEntry] = &[auto::ENTRY, system_filter::ENTRY, best_source::ENTRY];

/// The rule called `name`.
pub fn find(name: &str) -> Option<&'static RuleEntry> {
    REGISTRY.iter().find(|entry| entry.name == name)
}

/// The rule used where the configuration names none.
pub fn default_rule() -> &'static RuleEntry {
    &REGISTRY[0]
}

/// Place of `rule` in the registry, as messages carry it.
pub fn code(rule: &RuleEntry) -> u8 {
    REGISTRY
        .iter()
        .position(|entry| std::ptr::eq(entry, rule))
        .unwrap_or_default() as u8
}

/// Lets the configured rule weigh `target`. `shares` holds one share per candidate, of which there is at least one; their
/// accuracy values are filled in for every rule (TI-9).
pub fn fuse(settings: &RuleSettings, target: &Target<'_>, memory: &mut Memory, shares: &mut [Share]) -> Option<State> {
    for (share, candidate) in shares.iter_mut().zip(target.candidates) {
        *share = Share {
            accuracy: candidate.lambda,
            ..Share::default()
        };
    }
    (settings.rule.fuse)(settings, target, memory, shares)
}

/// One target, as a rule sees it.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// The contributions at the reference time, in the order of their sources; at least one, at most one per source.
    pub candidates: &'a [Candidate],
    /// The reference time, UTC, nanoseconds.
    pub reference_ns: i64,
    /// The estimate of the target's filter at the reference time.
    pub filtered: State,
    /// The system track's state so far, at its own time.
    pub last: State,
    /// Spectral density of the white-noise acceleration of targets, m²/s³.
    pub process_noise_m2ps3: f64,
}

/// One source's contribution to one target at the reference time, as a rule sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Source number.
    pub source: u16,
    /// Priority for ties, smaller first.
    pub priority: u32,
    /// Observation error coefficient alpha = k·s, normalised where configured (TI-8).
    pub alpha: f64,
    /// V per axis, metres or metres per second; `None` while there is no earlier report (TI-10).
    pub residual: Option<[f64; 3]>,
    /// Accuracy value lambda = alpha·V, V being the norm over the axes that all candidates have (TI-9); infinite while
    /// there is no V.
    pub lambda: f64,
    /// Age of its latest report, nanoseconds.
    pub age_ns: i64,
    /// Time between two reports of its source, nanoseconds.
    pub period_ns: i64,
    /// Whether its source has missed the expected report (TI-15).
    pub overdue: bool,
    /// State of the track at its source.
    pub life: TrackState,
    /// Trace over east and north that the source itself delivered (TI-16), brought to the reference time, m².
    pub trace_m2: Option<f64>,
    /// Quality index M: how many of the last scans confirmed the track (QF-4).
    pub quality: u32,
    /// Its share in the estimate of the target's filter, not yet scaled to sum to 1.
    pub filter_share: f64,
    /// Its latest report at the reference time.
    pub state: State,
}

impl Candidate {
    /// alpha·V with V over two axes or all three.
    pub(crate) fn lambda_over(&self, three_axes: bool) -> f64 {
        let norm = |[x, y, z]: [f64; 3]| {
            let z = if three_axes { z } else { 0.0 };
            (x * x + y * y + z * z).sqrt()
        };
        self.residual.map_or(f64::INFINITY, |v| self.alpha * norm(v))
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
            life: TrackState::Confirmed,
            trace_m2: None,
            quality: 0,
            filter_share: 0.0,
            state: State::default(),
        }
    }
}

/// One candidate's share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// Coefficient eta per axis, in [0, 1].
    pub weight: [f64; 3],
    /// Accuracy value lambda (TI-9); infinite while it does not exist.
    pub accuracy: f64,
}

/// What a rule remembers of one target between refreshes (TI-12).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Source chosen last time, per axis.
    pub selected: [u16; 3],
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            selected: [NO_SOURCE; 3],
        }
    }
}

#[cfg(test)]
mod conformance {
    //! What every rule promises, whatever its method.

    use proptest::prelude::*;

    use super::*;

    fn candidates() -> impl Strategy<Value = Vec<Candidate>> {
        let residual = prop::option::weighted(0.8, prop::array::uniform3(0.0..200.0f64));
        prop::collection::vec((0.0..100.0f64, residual, 0u32..3), 1..9).prop_map(|parts| {
            let numbered = parts.into_iter().enumerate();
            let candidate = |(source, (alpha, residual, priority))| {
                let candidate = Candidate {
                    source: source as u16,
                    priority,
                    alpha,
                    residual,
                    ..Candidate::default()
                };
                Candidate {
                    lambda: candidate.lambda_over(true),
                    ..candidate
                }
            };
            numbered.map(candidate).collect()
        })
    }

    fn weigh(rule: &'static RuleEntry, candidates: &[Candidate], memory: &mut Memory) -> Vec<Share> {
        let settings = RuleSettings {
            rule,
            ..RuleSettings::default()
        };
        let target = Target {
            candidates,
            reference_ns: 0,
            last: State::default(),
            process_noise_m2ps3: 1.0,
        };
        let mut shares = vec![Share::default(); candidates.len()];
        fuse(&settings, &target, memory, &mut shares);
        shares
    }

    proptest! {
        #[test]
        fn weights_lie_between_0_and_1_and_sum_to_1(candidates in candidates()) {
            for rule in REGISTRY {
                let shares = weigh(rule, &candidates, &mut Memory::default());
                for axis in 0..3 {
                    let sum: f64 = shares.iter().map(|share| share.weight[axis]).sum();
                    prop_assert!((sum - 1.0).abs() < 1e-12, "{}: {sum}", rule.name);
                    prop_assert!(shares.iter().all(|share| (0.0..=1.0).contains(&share.weight[axis])));
                }
            }
        }

        #[test]
        fn the_order_of_the_sources_does_not_matter(candidates in candidates()) {
            for rule in REGISTRY {
                let forwards = weigh(rule, &candidates, &mut Memory::default());
                let reversed: Vec<_> = candidates.iter().rev().copied().collect();
                let mut backwards = weigh(rule, &reversed, &mut Memory::default());
                backwards.reverse();
                prop_assert_eq!(forwards, backwards, "{}", rule.name);
            }
        }

        #[test]
        fn a_single_source_gets_everything(candidates in candidates()) {
            for rule in REGISTRY {
                let shares = weigh(rule, &candidates[..1], &mut Memory::default());
                prop_assert_eq!(shares[0].weight, [1.0; 3], "{}", rule.name);
            }
        }
    }

    #[test]
    fn names_are_unique_and_found() {
        for rule in REGISTRY {
            assert!(std::ptr::eq(find(rule.name).unwrap(), rule));
            assert_eq!(&REGISTRY[usize::from(code(rule))].name, &rule.name);
        }
        assert!(find("no-such-rule").is_none());
    }
}
