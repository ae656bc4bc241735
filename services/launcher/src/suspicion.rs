//! Whether the shared memory is to blame: deciding only, apart from doing.
//!
//! A child that dies of a fault, or stands still, is replaced, and the others go on: that is the right answer to a
//! fault of its own. If several different ones come to such an end within moments, it is what they share, and replacing
//! them one by one would go on for ever. One alone that comes to such an end again and again may have found what only
//! it reads: then new memory is tried, once, and if that does not help it is the child.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Ends that lie this close together may have one cause.
const MOMENTS: Duration = Duration::from_secs(15);
/// So many different children must have come to such an end.
const CHILDREN_MIN: usize = 2;
/// Or one alone so often in a row.
const IN_A_ROW_MIN: u32 = 5;

/// Recent ends that corrupt memory could explain.
#[derive(Clone, Debug, Default)]
pub(crate) struct Suspicion {
    recent: Vec<(Instant, usize)>,
    /// Children that have had new memory for themselves alone.
    tried: BTreeSet<usize>,
}

impl Suspicion {
    /// The child with this index has come to such an end, after so many failures in a row. Returns whether that is
    /// enough.
    pub(crate) fn raise(&mut self, now: Instant, child: usize, in_a_row: u32) -> bool {
        self.recent.retain(|(at, _)| now.duration_since(*at) < MOMENTS);
        self.recent.push((now, child));
        let children: BTreeSet<usize> = self.recent.iter().map(|(_, child)| *child).collect();
        children.len() >= CHILDREN_MIN || (in_a_row >= IN_A_ROW_MIN && self.tried.insert(child))
    }

    /// The memory is new.
    pub(crate) fn forget(&mut self) {
        self.recent.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_children_within_moments_are_enough_and_one_alone_is_once() {
        let mut suspicion = Suspicion::default();
        let start = Instant::now();
        assert!(!suspicion.raise(start, 3, 1));
        assert!(!suspicion.raise(start + 2 * MOMENTS, 4, 1), "too late");
        assert!(suspicion.raise(start + 3 * MOMENTS - Duration::from_secs(1), 3, 1));
        suspicion.forget();
        let enough: Vec<u32> = (1..20)
            .filter(|row| suspicion.raise(start + 9 * MOMENTS, 3, *row))
            .collect();
        assert_eq!(enough, [IN_A_ROW_MIN]);
    }
}
