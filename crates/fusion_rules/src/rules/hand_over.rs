//! Hand-over: change of the output from a source to another (TI-13 … TI-16, TI-18).
//!
//! Two sources observe different points of a target, so that a change of source moves the output sideways. The change
//! is immediate, or spread over refreshes: the new source gets an increasing sequence of coefficients eta_0 and, after
//! the last, the whole weight; the remainder goes to the outgoing side. The outgoing side is the previous source or,
//! for a change during a hand-over, the last published blend: no change moves the output by more than its own first
//! eta_0 allows.
//!
//! A previous source that has missed its expected report is a drop-out. A drop-out is dropped at once, or blended by
//! the last stored report, moved to the reference time, as long as its sensor track exists.

use messages::CONTRIBUTIONS_MAX;
use serde::{Deserialize, Serialize};

use super::{Candidate, NO_SOURCE, Share};
use crate::settings::{DropOut, HandOverSettings};

/// State of a target's hand-over on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct HandOver {
    /// The source chosen last; [`NO_SOURCE`] at first.
    chosen: u16,
    /// Refreshes since the choice.
    refreshes: u32,
    /// Weight of the chosen source, in [0, 1].
    eta: f64,
    /// eta_0 from traces, if used for the first refresh (TI-16).
    statistical: Option<f64>,
    /// The source before the hand-over.
    from: u16,
    outgoing: Blend,
}

/// A mixture of sources: the weights sum to 1, or all are 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Blend {
    sources: [u16; CONTRIBUTIONS_MAX],
    weights: [f64; CONTRIBUTIONS_MAX],
}

const NOTHING: Blend = Blend {
    sources: [NO_SOURCE; CONTRIBUTIONS_MAX],
    weights: [0.0; CONTRIBUTIONS_MAX],
};

impl Default for HandOver {
    fn default() -> Self {
        Self {
            chosen: NO_SOURCE,
            refreshes: 0,
            eta: 1.0,
            statistical: None,
            from: NO_SOURCE,
            outgoing: NOTHING,
        }
    }
}

impl HandOver {
    /// Refreshes since the choice.
    pub(super) fn refreshes(&self) -> u32 {
        self.refreshes
    }

    /// Whether the output may need the last stored report of `source` after its end of freshness.
    pub(crate) fn holds(&self, source: u16) -> bool {
        self.chosen == source || (self.eta < 1.0 && self.outgoing.weight_of(source) > 0.0)
    }

    /// Takes `best`, chosen on this axis for this refresh: writes the weights on `axis`.
    pub(super) fn follow(
        &mut self,
        settings: &HandOverSettings,
        best: u16,
        axis: usize,
        candidates: &[Candidate],
        shares: &mut [Share],
    ) {
        if best != self.chosen {
            self.begin(settings, best, candidates, shares);
        } else {
            self.refreshes = self.refreshes.saturating_add(1);
        }
        self.eta = self.eta_now(settings);
        self.write(axis, candidates, shares);
    }

    fn begin(&mut self, settings: &HandOverSettings, best: u16, candidates: &[Candidate], shares: &mut [Share]) {
        let from = self.chosen;
        self.outgoing = self.outgoing.with(from, self.eta);
        (self.from, self.chosen, self.refreshes, self.statistical) = (from, best, 0, None);
        let previous = candidates.iter().find(|candidate| candidate.source == from);
        let dropped_out = previous.is_none_or(|previous| previous.overdue || previous.stale);
        if from == NO_SOURCE || (dropped_out && settings.drop_out == DropOut::Switch) {
            self.outgoing = NOTHING;
        } else if settings.by_traces && settings.ordered(from, best).is_none() {
            let trace = |candidate: Option<&Candidate>| candidate.and_then(Candidate::usable_trace_m2);
            let next = candidates.iter().position(|candidate| candidate.source == best);
            match (trace(previous), trace(next.map(|index| &candidates[index]))) {
                // (1/tr B) / (1/tr A + 1/tr B)
                (Some(a), Some(b)) => self.statistical = Some(a / (a + b)),
                _ => {
                    for (share, candidate) in shares.iter_mut().zip(candidates) {
                        let concerned = candidate.source == from || candidate.source == best;
                        share.trace_unusable |= concerned && candidate.usable_trace_m2().is_none();
                    }
                }
            }
        }
    }

    /// The coefficient of the chosen source at this refresh.
    fn eta_now(&self, settings: &HandOverSettings) -> f64 {
        if let Some(eta) = self.statistical {
            return if self.refreshes == 0 { eta } else { 1.0 };
        }
        if self.outgoing == NOTHING {
            return 1.0;
        }
        let ramp = settings.ramp(self.from, self.chosen);
        ramp.get(self.refreshes as usize).copied().unwrap_or(1.0)
    }

    fn write(&mut self, axis: usize, candidates: &[Candidate], shares: &mut [Share]) {
        // Outgoing sources that are no longer present leave their part to the others.
        let outgoing = |candidate: &Candidate| self.outgoing.weight_of(candidate.source);
        let total: f64 = candidates.iter().map(outgoing).sum();
        let rest = if self.eta < 1.0 && total > 0.0 {
            (1.0 - self.eta) / total
        } else {
            0.0
        };
        let chosen = if rest > 0.0 { self.eta } else { 1.0 };
        for (share, candidate) in shares.iter_mut().zip(candidates) {
            let own = if candidate.source == self.chosen { chosen } else { 0.0 };
            share.weight[axis] = own + rest * outgoing(candidate);
        }
        if rest == 0.0 {
            (self.eta, self.outgoing) = (1.0, NOTHING);
        }
    }
}

impl Blend {
    fn weight_of(&self, source: u16) -> f64 {
        let place = self.sources.iter().position(|known| *known == source);
        place.map_or(0.0, |place| self.weights[place])
    }

    /// The blend with weight `eta` on `source` and the rest on this blend.
    fn with(&self, source: u16, eta: f64) -> Self {
        let mut blend = *self;
        for weight in &mut blend.weights {
            *weight *= 1.0 - eta;
        }
        let known = blend.sources.iter().position(|known| *known == source);
        // If all places are taken, the lightest is replaced.
        let lightest = || (0..CONTRIBUTIONS_MAX).min_by(|a, b| blend.weights[*a].total_cmp(&blend.weights[*b]));
        if let Some(place) = known.or_else(lightest) {
            let kept = if known.is_some() { blend.weights[place] } else { 0.0 };
            blend.sources[place] = source;
            blend.weights[place] = kept + eta;
        }
        blend
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::PairRamp;

    /// Follows `choices` and yields the weights of sources 0, 1, 2 at each refresh.
    fn weights(settings: &HandOverSettings, choices: &[u16], change: impl Fn(&mut Candidate, usize)) -> Vec<[f64; 3]> {
        let mut hand_over = HandOver::default();
        let step = |(refresh, best): (usize, &u16)| {
            let mut candidates = [0, 1, 2].map(|source| Candidate {
                source,
                trace_m2: Some(f64::from(source + 1)),
                ..Candidate::default()
            });
            for candidate in &mut candidates {
                change(candidate, refresh);
            }
            let mut shares = [Share::default(); 3];
            hand_over.follow(settings, *best, 0, &candidates, &mut shares);
            shares.map(|share| (share.weight[0] * 1e6).round() / 1e6)
        };
        choices.iter().enumerate().map(step).collect()
    }

    fn ramp(values: &[f64]) -> HandOverSettings {
        HandOverSettings {
            ramp: values.to_vec(),
            ..HandOverSettings::default()
        }
    }

    #[test]
    fn the_worked_check_divides_the_way_in_the_ratio_of_eta_0() {
        let found = weights(&ramp(&[0.3]), &[0, 0, 0, 1, 1], |_, _| {});
        assert_eq!(found[2..], [[1.0, 0.0, 0.0], [0.7, 0.3, 0.0], [0.0, 1.0, 0.0]]);
        let at_once = weights(&HandOverSettings::default(), &[0, 0, 0, 1, 1], |_, _| {});
        assert_eq!(at_once[2..], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn a_change_during_a_ramp_starts_from_the_present_blend() {
        let found = weights(&ramp(&[0.25, 0.5, 0.75]), &[0, 1, 1, 2, 2, 2, 2], |_, _| {});
        assert_eq!(found[1..3], [[0.75, 0.25, 0.0], [0.5, 0.5, 0.0]]);
        assert_eq!(found[3], [0.375, 0.375, 0.25], "a quarter on from half and half");
        assert_eq!(found[5..], [[0.125, 0.125, 0.75], [0.0, 0.0, 1.0]]);
        // And back to the first source, now on both sides.
        let back = weights(&ramp(&[0.25, 0.5, 0.75]), &[0, 1, 0], |_, _| {});
        assert_eq!(back[2], [0.8125, 0.1875, 0.0], "0.25 + 0.75 · 0.75");
    }

    #[test]
    fn pairs_have_ramps_of_their_own() {
        let mut settings = ramp(&[0.5]);
        settings.pairs.push(PairRamp {
            from: 1.into(),
            to: 0.into(),
            ramp: vec![0.1],
        });
        let found = weights(&settings, &[0, 1, 1, 0], |_, _| {});
        assert_eq!(found[1], [0.5, 0.5, 0.0]);
        assert_eq!(found[3], [0.1, 0.9, 0.0]);
    }

    #[test]
    fn a_drop_out_is_left_at_once_or_blended() {
        let overdue =
            |candidate: &mut Candidate, refresh: usize| candidate.overdue = candidate.source == 0 && refresh > 0;
        let mut settings = ramp(&[0.5]);
        assert_eq!(weights(&settings, &[0, 1], overdue)[1], [0.0, 1.0, 0.0]);
        settings.drop_out = DropOut::Blend;
        assert_eq!(weights(&settings, &[0, 1], overdue)[1], [0.5, 0.5, 0.0]);
        // Gone altogether during the ramp.
        let gone = |candidate: &mut Candidate, refresh: usize| {
            if candidate.source == 0 && refresh > 1 {
                candidate.source = 9;
            }
        };
        let found = weights(&ramp(&[0.2, 0.4, 0.6]), &[0, 1, 1, 1], gone);
        assert_eq!(found[1..], [[0.8, 0.2, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn traces_decide_where_both_are_usable() {
        let settings = HandOverSettings {
            by_traces: true,
            ..ramp(&[0.5])
        };
        // Traces 1 and 3: (1/3) / (1 + 1/3).
        assert_eq!(
            weights(&settings, &[0, 2, 2], |_, _| {})[1..],
            [[0.75, 0.0, 0.25], [0.0, 0.0, 1.0]]
        );
        let unusable = |candidate: &mut Candidate, _| {
            if candidate.source == 2 {
                candidate.trace_m2 = Some(f64::NAN);
            }
        };
        assert_eq!(weights(&settings, &[0, 2], unusable)[1], [0.5, 0.0, 0.5]);
        let mut shares = [Share::default(); 2];
        let mut candidates = [0, 1].map(|source| Candidate {
            source,
            trace_m2: Some(2.0),
            ..Candidate::default()
        });
        candidates[1].trace_m2 = Some(0.0);
        let mut hand_over = HandOver::default();
        hand_over.follow(&settings, 0, 0, &candidates, &mut shares);
        hand_over.follow(&settings, 1, 0, &candidates, &mut shares);
        assert_eq!(shares.map(|share| share.trace_unusable), [false, true]);
    }
}
