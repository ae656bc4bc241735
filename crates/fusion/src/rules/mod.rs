//! The rules that weigh a target's sources.
//!
//! A rule sees contributions that have already been brought to one reference time, and says how large a share each
//! one gets. It never sees topics, files, or a clock. A new rule is a file here and a line in [`REGISTRY`].

mod best_source;

use crate::settings::RuleSettings;

/// Source number that stands for none.
pub const NO_SOURCE: u16 = u16::MAX;

/// A rule, as the registry lists it.
#[derive(Debug)]
pub struct RuleEntry {
    /// Name on the command line and in the configuration.
    pub name: &'static str,
    /// One line for help texts.
    pub summary: &'static str,
    /// What the rule assumes about how the sources' errors are correlated.
    pub assumption: &'static str,
    /// Fills one share per candidate. For each axis the weights of all candidates sum to 1.
    pub weigh: fn(&RuleSettings, &[Candidate], &mut Memory, &mut [Share]),
}

/// Every rule there is.
pub static REGISTRY: &[RuleEntry] = &[best_source::ENTRY];

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
    /// Whether every candidate knows its height, so that the third axis may count.
    pub three_axes: bool,
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
            parts
                .into_iter()
                .enumerate()
                .map(|(source, (alpha, residual, priority))| Candidate {
                    source: source as u16,
                    priority,
                    alpha,
                    residual,
                    three_axes: true,
                })
                .collect()
        })
    }

    fn weigh(rule: &'static RuleEntry, candidates: &[Candidate], memory: &mut Memory) -> Vec<Share> {
        let settings = RuleSettings {
            rule,
            ..RuleSettings::default()
        };
        let mut shares = vec![Share::default(); candidates.len()];
        (rule.weigh)(&settings, candidates, memory, &mut shares);
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
