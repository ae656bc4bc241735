//! Verdict: the source to which a bias between two sources belongs.
//!
//! Problem: the findings on two sources show a bias, but not the source of the bias. The pair alone cannot decide,
//! because either side gives the same difference.
//!
//! Method: further evidence decides, the strongest first.
//! 1. The reference source is true by configuration; the other source is off.
//! 2. A time bias belongs to the source with the worse clock by the times of receipt.
//! 3. The bias belongs to a source that disagrees with two others, if the partner agrees with a third source.
//! 4. Addresses confirm the pairs of tracks: a bias that depends on a sensor position is certain if only a single
//!    source of the pair has a known position.
//!
//! Otherwise the side of the hypothesis with the highest score is suspected, and the verdict is not certain. Only
//! certain verdicts lead to a removal.

use messages::BiasKind;

use crate::alignment::findings::{HYPOTHESES, PairFindings, Side, WINDOWS_MIN};
use crate::registration::ClockError;

/// Least difference of clock offsets that identifies the source of a time bias, seconds.
const CLOCK_WORSE_S: f64 = 0.5;
/// Pairs of tracks with the same address that confirm a bias.
const ADDRESSES_MIN: u32 = 3;

/// Bias of a source relative to its partner.
#[derive(Clone, Copy, Debug)]
pub(super) struct BiasVerdict {
    pub(super) culprit: usize,
    pub(super) partner: usize,
    pub(super) kind: BiasKind,
    /// Radians, metres or seconds, by the kind.
    pub(super) value: [f64; 2],
    pub(super) is_certain: bool,
}

/// Evidence for the verdicts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence<'a> {
    /// Findings on all pairs of sources, by first × number of sources + second.
    pub(super) pairs: &'a [PairFindings],
    /// Places of the sources' sensors.
    pub(super) places_m: &'a [Option<[f64; 2]>],
    /// Errors of the sources' clocks by the times of receipt.
    pub(super) clocks: &'a [ClockError],
    /// Source that is true by configuration.
    pub(super) reference: Option<usize>,
}

impl Evidence<'_> {
    /// Verdicts on all pairs of sources with a confirmed bias.
    pub(super) fn verdicts(&self) -> impl Iterator<Item = BiasVerdict> {
        let count = self.places_m.len();
        let pairs = (0..count).flat_map(move |first| (first + 1..count).map(move |second| (first, second)));
        pairs.filter_map(|(first, second)| self.verdict(first, second))
    }

    fn verdict(&self, first: usize, second: usize) -> Option<BiasVerdict> {
        let findings = &self.pairs[first * self.places_m.len() + second];
        let (side, kind) = HYPOTHESES[findings.best()?];
        let (culprit, is_certain) = self.culprit((first, second), (side, kind), findings.addresses);
        let (kind, value) = self.bias_of(culprit, first, second)?;
        Some(BiasVerdict {
            culprit,
            partner: first + second - culprit,
            kind,
            value,
            is_certain,
        })
    }

    /// Source of the bias, and whether the attribution is certain.
    fn culprit(
        &self,
        (first, second): (usize, usize),
        (side, kind): (Side, BiasKind),
        addresses: u32,
    ) -> (usize, bool) {
        if self.reference == Some(first) {
            return (second, true);
        }
        if self.reference == Some(second) {
            return (first, true);
        }
        if let (BiasKind::Time, Some(worse)) = (kind, self.worse_clock(first, second)) {
            return (worse, true);
        }
        let [of_first, of_second] = [first, second].map(|source| self.disagreements(source));
        let [first_agrees, second_agrees] = [first, second].map(|source| self.agrees_with_another(source));
        if of_first >= 2 && second_agrees && !first_agrees {
            return (first, true);
        }
        if of_second >= 2 && first_agrees && !second_agrees {
            return (second, true);
        }
        let (culprit, other) = match side {
            Side::First => (first, second),
            Side::Second => (second, first),
        };
        let needs_place = matches!(kind, BiasKind::Azimuth | BiasKind::Range);
        let is_certain = addresses >= ADDRESSES_MIN && needs_place && self.places_m[other].is_none();
        (culprit, is_certain)
    }

    fn worse_clock(&self, first: usize, second: usize) -> Option<usize> {
        let apart_s = self.clocks[first].excess_s - self.clocks[second].excess_s;
        (apart_s.abs() > CLOCK_WORSE_S).then_some(if apart_s > 0.0 { first } else { second })
    }

    fn pair_of(&self, one: usize, other: usize) -> Option<&PairFindings> {
        let (first, second) = (one.min(other), one.max(other));
        (one != other).then(|| &self.pairs[first * self.places_m.len() + second])
    }

    fn agrees_with_another(&self, source: usize) -> bool {
        (0..self.places_m.len()).any(|other| self.pair_of(source, other).is_some_and(|pair| pair.agree))
    }

    /// Number of other sources with a confirmed bias relative to this source.
    fn disagreements(&self, source: usize) -> usize {
        let others = 0..self.places_m.len();
        others
            .filter(|other| self.pair_of(source, *other).is_some_and(|pair| pair.best().is_some()))
            .count()
    }

    /// Confirmed bias of `culprit` with the highest score, and its value.
    fn bias_of(&self, culprit: usize, first: usize, second: usize) -> Option<(BiasKind, [f64; 2])> {
        let side = if culprit == first { Side::First } else { Side::Second };
        let pair = &self.pairs[first * self.places_m.len() + second];
        let candidates = HYPOTHESES.iter().enumerate().filter_map(|(hypothesis, (of, kind))| {
            // Time and place biases are differences: the sign depends on the erring side.
            let turns = matches!(kind, BiasKind::Time | BiasKind::Position) && side == Side::Second;
            let estimate = &pair.estimates[hypothesis];
            let is_usable = estimate.windows >= WINDOWS_MIN && (*of == side || turns);
            let value = if turns {
                estimate.value.map(|part| -part)
            } else {
                estimate.value
            };
            is_usable.then_some((estimate.score, *kind, value))
        });
        let best = candidates.max_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, kind, value)| (kind, value))
    }
}
