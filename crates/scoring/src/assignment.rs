//! Which pairs are best together.
//!
//! Each row (a target) may be paired with one column (a track) and each column with one row; a pair is worth its gain,
//! and what stays alone is worth nothing. Taking the best pair first, then the next, goes wrong as soon as two targets
//! compete: the greedy choice can force a partner far away on the loser. What is wanted is the set of pairs whose gains
//! have the greatest sum.
//!
//! The method is that of shortest augmenting paths (Jonker and Volgenant, *A shortest augmenting path algorithm for dense
//! and sparse linear assignment problems*, Computing 38, 1987). Rows come in one after the other. A row that wants a
//! column which is taken may drive its holder to another column, that one's holder to yet another, or out; Dijkstra's
//! search finds the cheapest such chain. Prices on the columns keep what was learned in earlier searches, so that no step
//! of a chain has a negative cost and the result is exact.
//!
//! Only pairs that are listed are looked at. A search ends where its chain does, commonly at the next neighbour, so the
//! cost grows with the crowding and hardly with the size of the picture. Solvers of full matrices need a cost for every
//! pair of a crowd: two thousand vehicles on an airport took one most of a second, and this one a few milliseconds.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A possible pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Place of the row, from 0.
    pub row: usize,
    /// Place of the column, from 0.
    pub column: usize,
    /// What the pair is worth: a finite number. Pairs that are worth nothing are never made.
    pub gain: f64,
}

/// The column that each of `rows` rows is paired with, so that the sum of the gains is the greatest possible.
///
/// # Panics
/// If a candidate's row or column is not below `rows` or `columns`.
pub fn best_pairs(rows: usize, columns: usize, candidates: &[Candidate]) -> Vec<Option<usize>> {
    let wishes = Wishes::new(rows, candidates);
    let mut search = Search::new(rows, columns);
    for row in 0..rows {
        search.bring_in(row, &wishes);
    }
    search.column_of
}

/// The candidates of each row.
struct Wishes {
    /// Column and gain, row after row.
    wishes: Vec<(usize, f64)>,
    /// Where each row's wishes begin; one more than there are rows.
    begins: Vec<usize>,
}

impl Wishes {
    fn new(rows: usize, candidates: &[Candidate]) -> Self {
        let mut begins = vec![0; rows + 1];
        for candidate in candidates {
            begins[candidate.row + 1] += 1;
        }
        for row in 0..rows {
            begins[row + 1] += begins[row];
        }
        let mut free = begins.clone();
        let mut wishes = vec![(0, 0.0); candidates.len()];
        for candidate in candidates {
            wishes[free[candidate.row]] = (candidate.column, candidate.gain);
            free[candidate.row] += 1;
        }
        Self { wishes, begins }
    }

    fn of(&self, row: usize) -> &[(usize, f64)] {
        &self.wishes[self.begins[row]..self.begins[row + 1]]
    }
}

/// The pairs so far, and the working memory of one search.
struct Search {
    column_of: Vec<Option<usize>>,
    row_of: Vec<Option<usize>>,
    /// By row: the gain of its pair.
    gain: Vec<f64>,
    /// By column: what holding it has come to cost. 0 for a column that nobody holds.
    price: Vec<f64>,
    /// By column: cost of the cheapest chain to it that is known.
    cost: Vec<f64>,
    /// By column: the row that would take it at the end of that chain.
    taker: Vec<usize>,
    /// By column: the gain of that pair.
    offer: Vec<f64>,
    /// By column: whether no cheaper chain can be found.
    settled: Vec<bool>,
    /// Columns whose working memory is in use.
    touched: Vec<usize>,
    queue: BinaryHeap<Reached>,
}

/// A column at the end of a chain.
struct Reached {
    cost: f64,
    column: usize,
}

/// Where a chain ends.
enum End {
    /// At a column that nobody holds.
    Column(usize),
    /// At a row that stays, or becomes, alone.
    Row(usize),
}

impl Search {
    fn new(rows: usize, columns: usize) -> Self {
        Self {
            column_of: vec![None; rows],
            row_of: vec![None; columns],
            gain: vec![0.0; rows],
            price: vec![0.0; columns],
            cost: vec![f64::INFINITY; columns],
            taker: vec![0; columns],
            offer: vec![0.0; columns],
            settled: vec![false; columns],
            touched: Vec::new(),
            queue: BinaryHeap::new(),
        }
    }

    /// Gives `start` the column that the cheapest chain of changes gives it, if it is worth that.
    fn bring_in(&mut self, start: usize, wishes: &Wishes) {
        let (end, end_cost) = self.cheapest_chain(start, wishes);
        self.raise_prices(end_cost);
        let mut column = match end {
            End::Column(column) => Some(column),
            End::Row(row) => self.column_of[row].take(),
        };
        while let Some(taken) = column {
            let row = self.taker[taken];
            column = self.column_of[row].replace(taken);
            self.row_of[taken] = Some(row);
            self.gain[row] = self.offer[taken];
        }
        self.forget();
    }

    /// Dijkstra's search from `start` over columns and the rows that hold them.
    fn cheapest_chain(&mut self, start: usize, wishes: &Wishes) -> (End, f64) {
        let (mut row, mut cost) = (start, 0.0);
        let (mut loser, mut loser_cost) = (start, 0.0);
        loop {
            if cost < loser_cost {
                (loser, loser_cost) = (row, cost);
            }
            for &(column, gain) in wishes.of(row) {
                let through = cost + self.price[column] - gain;
                if !self.settled[column] && through < self.cost[column] {
                    if self.cost[column] == f64::INFINITY {
                        self.touched.push(column);
                    }
                    self.cost[column] = through;
                    self.taker[column] = row;
                    self.offer[column] = gain;
                    self.queue.push(Reached { cost: through, column });
                }
            }
            let next = loop {
                match self.queue.pop() {
                    Some(reached) if self.settled[reached.column] => {}
                    Some(reached) if reached.cost < loser_cost => break reached,
                    _ => return (End::Row(loser), loser_cost),
                }
            };
            let Some(holder) = self.row_of[next.column] else {
                return (End::Column(next.column), next.cost);
            };
            self.settled[next.column] = true;
            row = holder;
            // What the holder gives up: its gain, less the price that it no longer pays.
            cost = next.cost + self.gain[holder] - self.price[next.column];
        }
    }

    /// What the search has passed becomes dearer by as much as it was passed more cheaply than the end was reached.
    fn raise_prices(&mut self, end_cost: f64) {
        for &column in &self.touched {
            if self.settled[column] {
                self.price[column] += end_cost - self.cost[column];
            }
        }
    }

    fn forget(&mut self) {
        while let Some(column) = self.touched.pop() {
            self.cost[column] = f64::INFINITY;
            self.settled[column] = false;
        }
        self.queue.clear();
    }
}

impl PartialEq for Reached {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Reached {}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Reached {
    /// The cheapest is the greatest: the queue hands out the greatest first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then(other.column.cmp(&self.column))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn candidates(gains: &[(usize, usize, f64)]) -> Vec<Candidate> {
        let candidate = |&(row, column, gain)| Candidate { row, column, gain };
        gains.iter().map(candidate).collect()
    }

    fn total(candidates: &[Candidate], pairs: &[Option<usize>]) -> f64 {
        let gain = |(row, column): (usize, &Option<usize>)| {
            let column = (*column)?;
            let listed = candidates
                .iter()
                .filter(|each| each.row == row && each.column == column);
            Some(listed.map(|each| each.gain).fold(f64::NAN, f64::max))
        };
        pairs.iter().enumerate().filter_map(gain).sum()
    }

    /// The greatest sum, by trying everything.
    fn greatest(candidates: &[Candidate], row: usize, rows: usize, taken: &mut Vec<usize>) -> f64 {
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
        // 9 first would leave row 1 with 1: 10. 8 and 7 are 15.
        let gains = candidates(&[(0, 0, 9.0), (0, 1, 8.0), (1, 0, 7.0), (1, 1, 1.0)]);
        assert_eq!(best_pairs(2, 2, &gains), [Some(1), Some(0)]);
    }

    #[test]
    fn a_row_gives_way_where_another_gains_more() {
        // Both want column 0, and only that.
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
                    gains.push(Candidate { row, column, gain });
                }
            }
        }
        let pairs = best_pairs(side * side, side * side, &gains);
        assert!(pairs.iter().enumerate().all(|(row, column)| *column == Some(row)));
    }

    fn case() -> impl Strategy<Value = (usize, usize, Vec<Candidate>)> {
        (1usize..6, 1usize..6).prop_flat_map(|(rows, columns)| {
            // Whole numbers make ties, fractions make near misses.
            let gain = prop_oneof![(-2i32..9).prop_map(f64::from), -1.0..9.0f64];
            let candidate = (0..rows, 0..columns, gain);
            let candidate = candidate.prop_map(|(row, column, gain)| Candidate { row, column, gain });
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
            let turned: Vec<Candidate> = candidates
                .iter()
                .rev()
                .map(|each| Candidate { row: each.column, column: each.row, gain: each.gain })
                .collect();
            let one = total(&candidates, &best_pairs(rows, columns, &candidates));
            let other = total(&turned, &best_pairs(columns, rows, &turned));
            prop_assert!((one - other).abs() < 1e-9, "{} and {}", one, other);
        }
    }
}
