//! A set of sources.

use std::ops::{BitOr, BitOrAssign};

use serde::{Deserialize, Serialize};

use crate::SOURCES_MAX;

/// A set of sources, by their numbers below [`SOURCES_MAX`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceSet([u64; WORDS]);

/// Sources have a bit each.
const WORDS: usize = SOURCES_MAX / u64::BITS as usize;

/// Word and bit of a source.
#[inline]
fn place(source: u16) -> (usize, u64) {
    (
        usize::from(source) / u64::BITS as usize % WORDS,
        1 << (source % u64::BITS as u16),
    )
}

impl SourceSet {
    /// The empty set.
    pub const EMPTY: Self = Self([0; WORDS]);
    /// All sources.
    pub const ALL: Self = Self([u64::MAX; WORDS]);

    /// One source.
    #[inline]
    pub fn of(source: u16) -> Self {
        let mut set = Self::EMPTY;
        set.insert(source);
        set
    }

    /// The set as bits, sources 0 to 63 first.
    pub fn bits(self) -> [u64; WORDS] {
        self.0
    }

    /// The set of [`Self::bits`].
    pub fn of_bits(bits: [u64; WORDS]) -> Self {
        Self(bits)
    }

    /// Adds a source.
    #[inline]
    pub fn insert(&mut self, source: u16) {
        let (word, bit) = place(source);
        self.0[word] |= bit;
    }

    /// Takes out a source.
    #[inline]
    pub fn remove(&mut self, source: u16) {
        let (word, bit) = place(source);
        self.0[word] &= !bit;
    }

    /// Whether a source is in the set.
    #[inline]
    pub fn contains(self, source: u16) -> bool {
        let (word, bit) = place(source);
        self.0[word] & bit != 0
    }

    /// The sources that are not in `others`.
    #[inline]
    pub fn without(self, others: Self) -> Self {
        Self(std::array::from_fn(|word| self.0[word] & !others.0[word]))
    }

    /// Whether some source is in both sets.
    #[inline]
    pub fn meets(self, other: Self) -> bool {
        self.0.iter().zip(other.0).any(|(one, other)| one & other != 0)
    }

    /// Whether there is a source beside `source`.
    #[inline]
    pub fn has_others_than(self, source: u16) -> bool {
        !self.without(Self::of(source)).is_empty()
    }

    /// Whether there is no source.
    #[inline]
    pub fn is_empty(self) -> bool {
        self == Self::EMPTY
    }

    /// Number of sources.
    pub fn count(self) -> u32 {
        self.0.iter().map(|word| word.count_ones()).sum()
    }

    /// The sources, in rising order.
    #[inline]
    pub fn iter(self) -> SourceIter {
        SourceIter { rest: self.0 }
    }
}

/// The sources of a set, in rising order.
#[derive(Clone, Debug)]
pub struct SourceIter {
    rest: [u64; WORDS],
}

impl Iterator for SourceIter {
    type Item = u16;

    #[inline]
    fn next(&mut self) -> Option<u16> {
        let (word, bits) = (0..).zip(&mut self.rest).find(|(_, bits)| **bits != 0)?;
        let bit = bits.trailing_zeros() as u16;
        *bits &= *bits - 1;
        Some(word * u64::BITS as u16 + bit)
    }
}

impl BitOr for SourceSet {
    type Output = Self;

    #[inline]
    fn bitor(mut self, other: Self) -> Self {
        self |= other;
        self
    }
}

impl BitOrAssign for SourceSet {
    #[inline]
    fn bitor_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(word, bits)| *word |= bits);
    }
}

impl FromIterator<u16> for SourceSet {
    fn from_iter<I: IntoIterator<Item = u16>>(sources: I) -> Self {
        let mut set = Self::EMPTY;
        sources.into_iter().for_each(|source| set.insert(source));
        set
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    fn sources() -> impl Strategy<Value = BTreeSet<u16>> {
        prop::collection::btree_set(0..SOURCES_MAX as u16, 0..20)
    }

    proptest! {
        #[test]
        fn a_set_is_as_a_set_of_numbers(one in sources(), other in sources(), source in 0..SOURCES_MAX as u16) {
            let [set, others]: [SourceSet; 2] = [&one, &other].map(|sources| sources.iter().copied().collect());
            prop_assert!(set.iter().eq(one.iter().copied()));
            prop_assert_eq!((set.is_empty(), set.count() as usize), (one.is_empty(), one.len()));
            prop_assert_eq!(set.contains(source), one.contains(&source));
            prop_assert!(set.without(others).iter().eq(one.difference(&other).copied()));
            prop_assert!((set | others).iter().eq(one.union(&other).copied()));
            prop_assert_eq!(set.meets(others), !one.is_disjoint(&other));
            prop_assert_eq!(set.has_others_than(source), one.iter().any(|other| *other != source));
            prop_assert_eq!(SourceSet::of_bits(set.bits()), set);
            let mut taken = set;
            taken.remove(source);
            prop_assert_eq!(taken, set.without(SourceSet::of(source)));
            prop_assert!(SourceSet::ALL.contains(source) && !SourceSet::EMPTY.contains(source));
        }
    }
}
