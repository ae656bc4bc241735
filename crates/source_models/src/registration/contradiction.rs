//! Contradictions: sources with reports displaced far from the reports of others.
//!
//! The errors are relative to the common part of all sources. If at least two other sources are near the common part,
//! these sources agree, and the source is off; a configured reference decides alone. Otherwise two sources contradict
//! each other, without a decision. Both cases are found at any size, whether or not the errors are removed.

use messages::{Bias, BiasKind};

use crate::registration::progress::SETTLED_MIN;
use crate::registration::rows::{AZIMUTH, RANGE, TIME};
use crate::registration::{MAJORITY, NEAR_2, Registration};

/// Least root mean square displacement of a source that is off, and of two contradicting sources, metres.
const OFF_M: f64 = 25.0;
const APART_M: f64 = 100.0;
/// Number of solutions before an estimate is reported.
const SOLUTIONS: u8 = 3;
/// Least squared statistical length of a significant displacement.
const SIGNIFICANT: f64 = 13.8;

impl Registration {
    /// Returns the errors of a source relative to a majority, or relative to a contradicting source; for a
    /// contradicting pair, the errors of the first source.
    pub(crate) fn contradiction(&self, source: u16) -> Option<Bias> {
        let own = usize::from(source);
        let size_m = self.settled_size_m(own).filter(|size_m| *size_m >= OFF_M)?;
        if let Some(reference) = self.reference {
            return (source != reference).then(|| self.bias(own, None, (usize::from(reference), true)));
        }
        if let Some(partner) = self.majority_beside(own, size_m) {
            return Some(self.bias(own, None, (partner, true)));
        }
        let (partner, other_m) = self.others(own).max_by(|a, b| a.1.total_cmp(&b.1))?;
        let is_undecided = size_m + other_m >= APART_M && self.majority_beside(partner, other_m).is_none();
        (own < partner && is_undecided).then(|| self.bias(own, Some(partner), (partner, false)))
    }

    /// Returns the first of the sources that agree with each other, but not with `own`, a source displaced by `size_m`;
    /// `None` without a majority.
    fn majority_beside(&self, own: usize, size_m: f64) -> Option<usize> {
        let near = || {
            self.others(own)
                .filter(|(_, other_m)| other_m * other_m <= NEAR_2 * size_m * size_m)
        };
        (near().count() >= MAJORITY)
            .then(|| near().next())?
            .map(|(other, _)| other)
    }

    /// Returns the other settled sources, with the respective [sizes](Self::settled_size_m).
    fn others(&self, own: usize) -> impl Iterator<Item = (usize, f64)> {
        let others = (0..self.sources.len()).filter(move |other| *other != own);
        others.filter_map(|other| Some((other, self.settled_size_m(other)?)))
    }

    /// Returns the root mean square displacement of the compared reports by the errors of a source, metres; 0 within
    /// chance, `None` if the source is not settled.
    fn settled_size_m(&self, own: usize) -> Option<f64> {
        let is_known = self.sources[own].samples >= SETTLED_MIN && self.solutions[own] >= SOLUTIONS;
        let squared_m2 = if is_known { self.squared_m2(own)? } else { return None };
        let is_by_chance = squared_m2 < SIGNIFICANT * self.displacements[own].variance_m2();
        Some(if is_by_chance { 0.0 } else { squared_m2.max(0.0).sqrt() })
    }

    fn bias(&self, own: usize, relative_to: Option<usize>, (partner, is_certain): (usize, bool)) -> Bias {
        let known = &self.sources[own];
        let other = relative_to.map(|other| self.sources[other].errors).unwrap_or_default();
        let (kind, value) = match (known.model.estimates(AZIMUTH), known.model.estimates(RANGE)) {
            (true, _) => (BiasKind::Azimuth, [known.errors[AZIMUTH], 0.0]),
            (_, true) => (BiasKind::Range, [known.errors[RANGE], 0.0]),
            _ if known.removed[TIME] && !known.removed[0] => (BiasKind::Time, [-known.errors[TIME], 0.0]),
            _ => (BiasKind::Position, [0, 1].map(|axis| known.errors[axis] - other[axis])),
        };
        Bias {
            kind,
            value,
            partner: partner as u16,
            is_certain,
            is_removed: known.removed.iter().any(|removed| *removed),
        }
    }
}
