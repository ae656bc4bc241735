//! Best assignment of pairs.
//!
//! Each row (a target) may be paired with one column (a track) and each column with one row. A pair contributes its
//! gain; unpaired rows and columns contribute nothing. A greedy choice of the best pair fails as soon as two
//! targets compete: it can force a distant partner on the loser. The result is the set of pairs with the greatest
//! sum of gains.
//!
//! The solver is the solver of report-to-track association ([`association::augmenting`]). It visits listed pairs
//! only, so the cost grows with the crowding and hardly with the size of the picture. Solvers of full matrices need
//! a cost for every pair of a crowd: for two thousand vehicles on an airport, such a solver took most of a second,
//! and this solver a few milliseconds.

use association::augmenting::{AugmentingPaths, Choice, NONE, Problem};

/// Candidate pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidatePair {
    /// Place of the row, from 0.
    pub row: usize,
    /// Place of the column, from 0.
    pub column: usize,
    /// Gain of the pair: a finite number. Pairs without positive gain are never made.
    pub gain: f64,
}

/// Returns the column paired with each of `rows` rows, for the greatest possible sum of gains.
///
/// # Panics
/// If a candidate's row or column is not below `rows` or `columns`.
pub fn best_pairs(rows: usize, columns: usize, candidates: &[CandidatePair]) -> Vec<Option<usize>> {
    let known = |candidate: &CandidatePair| candidate.row < rows && candidate.column < columns;
    assert!(candidates.iter().all(known), "rows and columns are numbered from 0");
    let wishes = Wishes::new(rows, candidates);
    let (mut paths, mut steps) = (AugmentingPaths::new(rows, columns), usize::MAX);
    let all = 0..rows as u32;
    for row in all.clone() {
        // A row without a better choice stays unpaired.
        let _ = paths.bring_in(&wishes, row, &mut steps);
    }
    let held = all.map(|row| paths.held(row));
    held.map(|label| (label != NONE).then(|| wishes.wishes[label as usize].column))
        .collect()
}

/// Candidates of each row. A candidate's label is its place.
struct Wishes {
    /// Row after row.
    wishes: Vec<CandidatePair>,
    /// Start of each row's candidates; the length is the number of rows plus 1.
    begins: Vec<usize>,
}

impl Wishes {
    fn new(rows: usize, candidates: &[CandidatePair]) -> Self {
        let mut wishes = candidates.to_vec();
        wishes.sort_by_key(|candidate| candidate.row);
        let begin = |row: usize| wishes.partition_point(|candidate| candidate.row < row);
        Self {
            begins: (0..=rows).map(begin).collect(),
            wishes,
        }
    }
}

impl Problem for Wishes {
    /// Pairs without positive gain are never made.
    const OWN_FIRST: bool = true;

    fn show_choices(&self, row: u32, mut each: impl FnMut(u32, u32, f64)) {
        each(NONE, NONE, 0.0);
        let [begin, end] = [0, 1].map(|next| self.begins[row as usize + next]);
        for (label, wish) in (begin as u32..).zip(&self.wishes[begin..end]) {
            each(label, wish.column as u32, -wish.gain);
        }
    }

    fn choice(&self, label: u32) -> Choice {
        let wish = &self.wishes[label as usize];
        Choice {
            row: wish.row as u32,
            column: wish.column as u32,
            cost: -wish.gain,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn candidates(gains: &[(usize, usize, f64)]) -> Vec<CandidatePair> {
        let candidate = |&(row, column, gain)| CandidatePair { row, column, gain };
        gains.iter().map(candidate).collect()
    }

    fn total(candidates: &[CandidatePair], pairs: &[Option<usize>]) -> f64 {
        let gain = |(row, column): (usize, &Option<usize>)| {
            let column = (*column)?;
            let listed = candidates
                .iter()
                .filter(|each| each.row == row && each.column == column);
            Some(listed.map(|each| each.gain).fold(f64::NAN, f64::max))
        };
        pairs.iter().enumerate().filter_map(gain).sum()
    }

    /// Returns the greatest sum, by exhaustive search.
    fn greatest(candidates: &[CandidatePair], row: usize, rows: usize, taken: &mut Vec<usize>) -> f64 {
        if row == rows {
            return 0.0;
        }
        let mut best = greatest(candidates, row + 1, rows, taken);
        for candidate in candidates.iter().filter(|candidate| candidate.row == row) {
            if !taken.contains(&candidate.column) {
                taken.push(candidate.column);
                best = best.max(candidate.gain + greatest(candidates, row + 1, rows, taken));
                taken.pop();
            }
        }
        best
    }

    #[test]
    fn the_greedy_choice_is_not_the_best() {
        // Taking 9 first leaves row 1 with 1: 10. 8 and 7 are 15.
        let gains = candidates(&[(0, 0, 9.0), (0, 1, 8.0), (1, 0, 7.0), (1, 1, 1.0)]);
        assert_eq!(best_pairs(2, 2, &gains), [Some(1), Some(0)]);
    }

    #[test]
    fn a_row_gives_way_where_another_gains_more() {
        // All want column 0 only.
        let gains = candidates(&[(0, 0, 2.0), (1, 0, 5.0), (2, 0, 3.0)]);
        assert_eq!(best_pairs(3, 1, &gains), [None, Some(0), None]);
    }

    #[test]
    fn a_chain_moves_everyone_up_by_one() {
        let gains = candidates(&[(0, 0, 5.0), (0, 1, 4.0), (1, 1, 5.0), (1, 2, 4.0), (2, 0, 5.0)]);
        assert_eq!(best_pairs(3, 3, &gains), [Some(1), Some(2), Some(0)]);
    }

    #[test]
    fn what_is_worth_nothing_is_left_alone() {
        let gains = candidates(&[(0, 0, 0.0), (1, 1, -3.0), (2, 2, 1e-300)]);
        assert_eq!(best_pairs(4, 3, &gains), [None, None, Some(2), None]);
        assert_eq!(best_pairs(2, 0, &[]), [None, None]);
        assert_eq!(best_pairs(0, 2, &[]), []);
    }

    #[test]
    fn a_crowd_of_thousands_is_paired_one_to_one() {
        // Tracks beside their targets on a lattice of 10 m, all within reach of many others.
        let side = 50_usize;
        let mut gains = Vec::new();
        for row in 0..side * side {
            for column in 0..side * side {
                let across = (row % side).abs_diff(column % side) as f64 * 10.0 + 3.0;
                let along = (row / side).abs_diff(column / side) as f64 * 10.0;
                let gain = 60.0 * 60.0 - across * across - along * along;
                if gain > 0.0 {
                    gains.push(CandidatePair { row, column, gain });
                }
            }
        }
        let pairs = best_pairs(side * side, side * side, &gains);
        assert!(pairs.iter().enumerate().all(|(row, column)| *column == Some(row)));
    }

    fn case() -> impl Strategy<Value = (usize, usize, Vec<CandidatePair>)> {
        (1usize..6, 1usize..6).prop_flat_map(|(rows, columns)| {
            // Whole numbers make ties, fractions make near misses.
            let gain = prop_oneof![(-2i32..9).prop_map(f64::from), -1.0..9.0f64];
            let candidate = (0..rows, 0..columns, gain);
            let candidate = candidate.prop_map(|(row, column, gain)| CandidatePair { row, column, gain });
            (Just(rows), Just(columns), prop::collection::vec(candidate, 0..20))
        })
    }

    proptest! {
        #[test]
        fn no_other_set_of_pairs_gains_more((rows, columns, candidates) in case()) {
            let pairs = best_pairs(rows, columns, &candidates);
            let mut held: Vec<usize> = pairs.iter().flatten().copied().collect();
            held.sort_unstable();
            held.dedup();
            prop_assert_eq!(held.len(), pairs.iter().flatten().count(), "a column was given twice");
            let (found, best) = (total(&candidates, &pairs), greatest(&candidates, 0, rows, &mut Vec::new()));
            prop_assert!((found - best).abs() < 1e-9, "{} instead of {}", found, best);
        }

        #[test]
        fn rows_and_columns_may_change_places((rows, columns, candidates) in case()) {
            let turned: Vec<CandidatePair> = candidates
                .iter()
                .rev()
                .map(|each| CandidatePair { row: each.column, column: each.row, gain: each.gain })
                .collect();
            let one = total(&candidates, &best_pairs(rows, columns, &candidates));
            let other = total(&turned, &best_pairs(columns, rows, &turned));
            prop_assert!((one - other).abs() < 1e-9, "{} and {}", one, other);
        }
    }
}
