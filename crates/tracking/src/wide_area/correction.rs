//! Correction of reliabilities by a known number of targets (WA-4).
//!
//! A hypothesis is a set of tracks. A sensor with a long observation reports the number of targets, so hypotheses with
//! at least as many tracks are likelier than hypotheses with fewer. The on-board detections do not determine the
//! factor, and a probability of 0 or 1 would let the report override everything. The source's rule sets the outcome
//! instead: the sums of the two groups stand as r to 1 − r, and ratios within each group stay unchanged. A group above
//! r keeps its sum: the correction only ever raises the sum.
//!
//! The correction is applied twice in the scan: to the hypotheses before the scan, then to the children of each, before
//! unreliable children are dropped. Otherwise a child made likely by the report would already have been dropped.
//!
//! Limit: a wrong report is raised to r all the same. [`Rule::Factor`] is milder: the odds are multiplied, so the
//! detections keep influence.
//!
//! Source: patent JP4702010B2, embodiment 1.

use settings::{KeyTable, KeyValue, Node, Place, Range, SettingsError};

use crate::log_sum::{log_add, log_sum};

/// Rule that raises the group with enough tracks. Each rule favours the same group and never lowers it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// To this share of the sum, in (0, 1), unless it has more already (the source's rule).
    Share(f64),
    /// Multiplies the odds by this factor, at least 1: the likelihood ratio of the report between enough and fewer
    /// tracks.
    Factor(f64),
}

settings::settings! {
    /// Correction of reliabilities: exactly one of the two keys.
    struct RuleKeys {
        check RuleKeys::check;
        /// Share of the sum to which the group with enough tracks is raised, unless it has more already (the source's
        /// rule).
        share: Option<f64> = None, in [1e-6, 0.999_999];
        /// Factor by which its odds are multiplied: how much likelier the report is if there are enough tracks than if
        /// there are fewer.
        factor: Option<f64> = None, in [1, 1e12];
    }
}

impl RuleKeys {
    fn check(&self) -> Result<(), SettingsError> {
        if self.share.is_some() != self.factor.is_some() {
            return Ok(());
        }
        let what = "needs exactly one of share and factor, like { share = 0.6 }; \"off\" is another choice";
        Err(SettingsError::new("", what))
    }
}

impl From<Rule> for RuleKeys {
    fn from(rule: Rule) -> Self {
        let (share, factor) = match rule {
            Rule::Share(share) => (Some(share), None),
            Rule::Factor(factor) => (None, Some(factor)),
        };
        Self { share, factor }
    }
}

impl Default for Rule {
    /// Three fifths.
    fn default() -> Self {
        Self::Share(0.6)
    }
}

impl KeyValue for Rule {
    fn read(&mut self, node: &Node<'_>, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        let mut keys = RuleKeys::default();
        KeyValue::read(&mut keys, node, range, at)?;
        let share = keys.share.map(Self::Share);
        *self = share.or(keys.factor.map(Self::Factor)).unwrap_or_default();
        Ok(())
    }

    fn check(&self, range: Range, at: &Place<'_>) -> Result<(), SettingsError> {
        KeyValue::check(&RuleKeys::from(*self), range, at)
    }

    fn kind(&self) -> String {
        "table".to_owned()
    }

    fn text(&self) -> String {
        match self {
            Self::Share(share) => format!("{{ share = {share} }}"),
            Self::Factor(factor) => format!("{{ factor = {factor} }}"),
        }
    }

    fn table(&self) -> Option<Box<dyn KeyTable>> {
        Some(Box::new(RuleKeys::from(*self)))
    }
}

/// Gains added to the logarithms of the two groups' reliabilities; the total stays unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gains {
    /// Gain of hypotheses with at least the reported number of tracks.
    pub(crate) enough: f64,
    /// Gain of the hypotheses with fewer.
    pub(crate) fewer: f64,
}

impl Gains {
    pub(crate) const NONE: Self = Self {
        enough: 0.0,
        fewer: 0.0,
    };

    /// Computes the gains for two groups; `enough` and `fewer` are the logarithms of the reliability sums.
    pub(crate) fn of(enough: f64, fewer: f64, rule: Rule) -> Self {
        // Written so that NaN changes nothing.
        if !(enough > f64::NEG_INFINITY && fewer > f64::NEG_INFINITY) {
            return Self::NONE;
        }
        let sum = log_add(enough, fewer);
        match rule {
            Rule::Share(share) if enough >= share.ln() + sum => Self::NONE,
            Rule::Share(share) => Self {
                enough: share.ln() + sum - enough,
                fewer: (-share).ln_1p() + sum - fewer,
            },
            Rule::Factor(factor) => {
                let raised = log_add(factor.ln() + enough, fewer);
                Self {
                    enough: factor.ln() + sum - raised,
                    fewer: sum - raised,
                }
            }
        }
    }

    /// Returns whether both gains are zero.
    pub(crate) fn are_none(&self) -> bool {
        *self == Self::NONE
    }

    pub(crate) fn gain(&self, is_enough: bool) -> f64 {
        if is_enough { self.enough } else { self.fewer }
    }

    /// For hypotheses with these logarithms of reliabilities, each of which has enough tracks or not.
    pub(crate) fn of_all(hypotheses: impl Iterator<Item = (f64, bool)> + Clone, rule: Rule) -> Self {
        let sum = |wanted: bool| {
            let group = hypotheses.clone().filter(|(_, is_enough)| *is_enough == wanted);
            log_sum(group.map(|(log_reliability, _)| log_reliability))
        };
        Self::of(sum(true), sum(false), rule)
    }
}

/// Corrects the reliabilities of hypotheses with these numbers of tracks by a report of `targets`. The sum stays.
pub fn correct(reliabilities: &mut [f64], tracks: &[u32], targets: f64, rule: Rule) {
    let is_enough = |tracks: u32| has_enough(tracks as usize, targets);
    let pairs = reliabilities.iter().zip(tracks);
    let gains = Gains::of_all(
        pairs.map(|(reliability, tracks)| (reliability.ln(), is_enough(*tracks))),
        rule,
    );
    if gains == Gains::NONE {
        return;
    }
    for (reliability, tracks) in reliabilities.iter_mut().zip(tracks) {
        *reliability *= gains.gain(is_enough(*tracks)).exp();
    }
}

/// Returns whether this number of tracks explains the number of targets, which may be a fraction (WA-5).
pub(crate) fn has_enough(tracks: usize, targets: f64) -> bool {
    lacking(tracks, targets) == 0
}

/// Number of tracks that are lacking.
pub(crate) fn lacking(tracks: usize, targets: f64) -> usize {
    // Rounding errors of fractions are not a target.
    (targets - tracks as f64 - 1e-6).ceil().max(0.0) as usize
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SOURCE: Rule = Rule::Share(0.6);

    fn close(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }

    /// (reliability of the parent, ratios of the children, tracks of the children), from the worked check.
    type Family = (f64, &'static [f64], &'static [u32]);
    const FAMILIES: [Family; 2] = [(0.9, &[3.0, 3.0, 2.0, 2.0], &[1, 1, 2, 2]), (0.1, &[7.0, 3.0], &[2, 2])];

    fn children(parents: [f64; 2], corrected: bool) -> Vec<f64> {
        let mut all = Vec::new();
        for (parent, (_, ratios, tracks)) in parents.iter().zip(FAMILIES) {
            let sum: f64 = ratios.iter().sum();
            let mut own: Vec<f64> = ratios.iter().map(|ratio| ratio / sum * parent).collect();
            if corrected {
                correct(&mut own, tracks, 2.0, SOURCE);
            }
            all.extend(own);
        }
        all
    }

    #[test]
    fn the_worked_check() {
        let parents = FAMILIES.map(|(parent, ..)| parent);
        close(&children(parents, false), &[0.27, 0.27, 0.18, 0.18, 0.07, 0.03]);
        let mut raised = parents;
        correct(&mut raised, &[1, 2], 2.0, SOURCE);
        close(&raised, &[0.4, 0.6]);
        close(&children(raised, true), &[0.08, 0.08, 0.12, 0.12, 0.42, 0.18]);
    }

    #[test]
    fn without_it_the_best_two_have_one_track() {
        let plain = children(FAMILIES.map(|(parent, ..)| parent), false);
        let tracks: Vec<u32> = FAMILIES
            .iter()
            .flat_map(|(.., tracks)| tracks.iter().copied())
            .collect();
        let best = |reliabilities: &[f64]| {
            let mut order: Vec<usize> = (0..reliabilities.len()).collect();
            order.sort_by(|one, other| reliabilities[*other].total_cmp(&reliabilities[*one]));
            [tracks[order[0]], tracks[order[1]]]
        };
        assert_eq!(best(&plain), [1, 1]);
        assert_eq!(best(&children([0.4, 0.6], true)), [2, 2]);
    }

    #[test]
    fn one_group_alone_is_left_as_it_is() {
        for targets in [0.0, 1.0, 9.0, 10_000.0, f64::NAN] {
            let mut reliabilities = [0.7, 0.3];
            correct(&mut reliabilities, &[2, 3], targets, SOURCE);
            close(&reliabilities, &[0.7, 0.3]);
        }
        let mut nothing: [f64; 0] = [];
        correct(&mut nothing, &[], 2.0, SOURCE);
        let mut with_impossible = [1.0, 0.0];
        correct(&mut with_impossible, &[1, 2], 2.0, SOURCE);
        close(&with_impossible, &[1.0, 0.0]);
    }

    #[test]
    fn a_group_that_has_more_keeps_it() {
        let mut reliabilities = [0.75, 0.25];
        correct(&mut reliabilities, &[2, 1], 2.0, SOURCE);
        close(&reliabilities, &[0.75, 0.25]);
    }

    #[test]
    fn a_fraction_of_a_target_asks_for_a_whole_track() {
        assert_eq!([0, 1, 2, 3].map(|tracks| lacking(tracks, 1.4)), [2, 1, 0, 0]);
        assert_eq!(lacking(2, 2.0 + 1e-9), 0);
    }

    fn any_hypotheses() -> impl Strategy<Value = Vec<(f64, u32)>> {
        prop::collection::vec((1e-9..1.0f64, 0..5u32), 1..12)
    }

    fn any_rule() -> impl Strategy<Value = Rule> {
        prop_oneof![
            (0.01..0.99f64).prop_map(Rule::Share),
            (1.0..100.0f64).prop_map(Rule::Factor)
        ]
    }

    proptest! {
        #[test]
        fn sums_to_one_keeps_ratios_and_only_raises(all in any_hypotheses(), targets in 0..6u32, rule in any_rule()) {
            let sum: f64 = all.iter().map(|(reliability, _)| reliability).sum();
            let before: Vec<f64> = all.iter().map(|(reliability, _)| reliability / sum).collect();
            let tracks: Vec<u32> = all.iter().map(|(_, tracks)| *tracks).collect();
            let mut after = before.clone();
            correct(&mut after, &tracks, f64::from(targets), rule);
            prop_assert!((after.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            for (place, number) in tracks.iter().enumerate() {
                let raised = *number >= targets;
                let (one, other) = (after[place], before[place]);
                let only_raised = if raised { one >= other * (1.0 - 1e-12) } else { one <= other * (1.0 + 1e-12) };
                prop_assert!(only_raised);
                for next in place + 1..tracks.len() {
                    if raised == (tracks[next] >= targets) {
                        let (ratio, was) = (after[place] / after[next], before[place] / before[next]);
                        prop_assert!((ratio / was - 1.0).abs() < 1e-9);
                    }
                }
            }
        }

        #[test]
        fn the_share_is_reached(all in any_hypotheses(), targets in 1..5u32, share in 0.01..0.99f64) {
            let sum: f64 = all.iter().map(|(reliability, _)| reliability).sum();
            let tracks: Vec<u32> = all.iter().map(|(_, tracks)| *tracks).collect();
            let of = |reliabilities: &[f64]| -> f64 {
                reliabilities.iter().zip(&tracks).filter(|(_, number)| **number >= targets).map(|(value, _)| value).sum()
            };
            let before: Vec<f64> = all.iter().map(|(reliability, _)| reliability / sum).collect();
            let mut after = before.clone();
            correct(&mut after, &tracks, f64::from(targets), Rule::Share(share));
            let both = tracks.iter().any(|number| *number >= targets) && tracks.iter().any(|number| *number < targets);
            let expected = if both { of(&before).max(share) } else { of(&before) };
            prop_assert!((of(&after) - expected).abs() < 1e-12);
        }
    }
}
