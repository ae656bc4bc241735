//! Suspicion of shared memory: the decision alone, apart from the consequence.
//!
//! A child that crashes or hangs is replaced while the others continue: the right response to a fault of the child. If
//! several different children end like this within a short time, the common memory is suspect, and single replacements
//! would never end. If a single child ends like this several times in a row, the cause may be memory that only this
//! child reads. New memory is then tried once; if the child fails again, the fault is the child's.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Maximum time between ends with a common cause.
const MOMENTS: Duration = Duration::from_secs(15);
/// Minimum number of different children for a common cause.
const CHILDREN_MIN: usize = 2;
/// Number of failures in a row of a single child that raises the suspicion.
const IN_A_ROW_MIN: u32 = 5;

/// Recent ends that corrupt memory could explain.
#[derive(Clone, Debug, Default)]
pub(crate) struct Suspicion {
    recent: Vec<(Instant, usize)>,
    /// Children that new memory has been tried for.
    tried: BTreeSet<usize>,
}

impl Suspicion {
    /// Notes such an end of the child with this index, after `failures` failures in a row. Returns whether shared
    /// memory is suspect.
    pub(crate) fn raise(&mut self, now: Instant, child: usize, in_a_row: u32) -> bool {
        self.recent.retain(|(at, _)| now.duration_since(*at) < MOMENTS);
        self.recent.push((now, child));
        let children: BTreeSet<usize> = self.recent.iter().map(|(_, child)| *child).collect();
        children.len() >= CHILDREN_MIN || (in_a_row >= IN_A_ROW_MIN && self.tried.insert(child))
    }

    /// Notes that the memory is new.
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
