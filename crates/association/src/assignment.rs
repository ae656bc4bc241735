//! Association of all reports of a scan together with tracks (BF-2).
//!
//! The obvious method gives each report the nearest track, and fails for targets close together. Two aircraft fly 300
//! m apart, and a sensor shows both 200 m too far along: the report of the rear aircraft lies 100 m from the track of
//! the front aircraft, and takes it. The front report finds its track taken, and the rear track is left without a
//! report. Decided together the matter is plain: both reports are off by 200 m, which is more likely than a single
//! report off by 100 m and a new target. (Of a hundred aircraft in line it would be less likely: a common shift must
//! be taken out beforehand, not here.)
//!
//! Each row (report) gets at most one column (track), and each column at most one row. The minimised sum consists of
//! the costs of the chosen pairs and a fixed cost for each unassigned row. Costs are statistical distances or negative
//! logarithms of likelihoods, and may be negative.
//!
//! Rows that share no column, not even through others, do not concern each other. A union-find structure splits the
//! scan into such components, which away from crowds have one or two rows. Within a component the method is that of
//! shortest augmenting paths ([`crate::augmenting`]), where being alone is an own choice of the row.
//!
//! Limits: time must be bounded, and the worst case of an exact solution grows with the cube of the crowd. Crowds of
//! real targets are far from this case, because nearly every chain is short. The steps of a component are counted.
//! Above [`STEPS_PER_PAIR_MAX`] steps per pair, the component is decided greedily, the cheapest pair first, and
//! counted. Thus time grows with the number of pairs (and its logarithm, for sorting) in all cases. Among solutions of
//! equal sum the labels decide, never the order of the pairs: the same scan always has the same result.

use std::ops::Range;

use crate::augmenting::{AugmentingPaths, Choice, NONE, Problem, StopReason};
use crate::components::{join, representative};

/// Most steps of an exact solution, for each pair of the component: accesses to a pair or a column.
///
/// Components of up to 20 rows never need more, nor do 250 rows with 250 possible columns each. Of 2500 vehicles, 30 m
/// apart and seen with 30 m of noise, all in one component, each pair needs 15; of the hardest crowd measured (20 m
/// apart, every eighth without a track) 158.
pub const STEPS_PER_PAIR_MAX: usize = 300;

/// A row and a column that may be put together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Label of the row.
    pub row: u32,
    /// Label of the column.
    pub column: u32,
    /// Cost of choosing the pair, in the unit of the cost of staying alone.
    pub cost: f64,
}

/// Summary of a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Number of chosen pairs.
    pub assigned: usize,
    /// Components decided greedily because of the step limit of the exact solution.
    pub greedy_components: usize,
    /// Pairs ignored because of labels out of range, or for lack of room.
    pub ignored_pairs: usize,
}

/// Working memory for assignments up to a fixed size.
#[derive(Clone, Debug)]
pub struct Assignment {
    pairs_max: usize,
    /// Admissible pairs, sorted by component, row and column.
    pairs: Vec<Pair>,
    /// By row, then by column: a member of the same component with a smaller place, or the row or column itself.
    parent: Vec<u32>,
    /// By row: places of its pairs in the sorted list.
    rows: Vec<Range<u32>>,
    columns_max: usize,
    /// Rows with pairs, sorted by component and label.
    order: Vec<u32>,
    paths: AugmentingPaths,
}

/// Each row with its pairs; the label of a pair is its place.
struct Sparse<'a> {
    pairs: &'a [Pair],
    rows: &'a [Range<u32>],
    unassigned_cost: f64,
}

impl Problem for Sparse<'_> {
    /// A pair with at most the cost of leaving its row alone is admissible.
    const OWN_FIRST: bool = false;

    fn show_choices(&self, row: u32, mut each: impl FnMut(u32, u32, f64)) {
        each(NONE, NONE, self.unassigned_cost);
        for place in self.rows[row as usize].clone() {
            let pair = self.pairs[place as usize];
            each(place, pair.column, pair.cost);
        }
    }

    fn choice(&self, label: u32) -> Choice {
        let Pair { row, column, cost } = self.pairs[label as usize];
        Choice { row, column, cost }
    }
}

impl Assignment {
    /// Memory for rows labelled `0..rows_max`, columns labelled `0..columns_max` and `pairs_max` pairs at a time.
    ///
    /// # Panics
    /// If `rows_max + columns_max` or `pairs_max` does not fit into 32 bits; all come from checked configuration.
    pub fn new(rows_max: usize, columns_max: usize, pairs_max: usize) -> Self {
        assert!(rows_max + columns_max < NONE as usize && pairs_max < NONE as usize);
        Self {
            pairs_max,
            pairs: Vec::with_capacity(pairs_max),
            parent: vec![NONE; rows_max + columns_max],
            rows: vec![0..0; rows_max],
            columns_max,
            order: Vec::with_capacity(rows_max),
            paths: AugmentingPaths::new(rows_max, columns_max),
        }
    }

    /// Chooses among `pairs` so that no row and no column is used twice and the sum of the chosen costs and of
    /// `unassigned_cost` for each row left alone is smallest. Calls `chosen(row, column, cost)` in ascending order of
    /// rows.
    ///
    /// A pair with more cost than leaving its row alone, or without a finite cost, is never chosen; nor is any if
    /// `unassigned_cost` is not finite. Of pairs of the same row and column the cheapest counts. If there are more
    /// admissible pairs than there is room for, the later pairs are ignored: only then does the order of the pairs
    /// matter.
    pub fn solve(&mut self, pairs: &[Pair], unassigned_cost: f64, mut chosen: impl FnMut(u32, u32, f64)) -> Outcome {
        let mut outcome = Outcome {
            ignored_pairs: self.admit(pairs, unassigned_cost),
            ..Outcome::default()
        };
        self.split();
        self.index();
        let mut begin = 0;
        while begin < self.order.len() {
            let end = self.component_end(begin);
            if self.choose_exactly(begin, end, unassigned_cost).is_err() {
                self.choose_greedily(begin, end);
                outcome.greedy_components += 1;
            }
            begin = end;
        }
        self.order.sort_unstable();
        for &row in &self.order {
            let held = self.paths.held(row);
            if held != NONE {
                let pair = self.pairs[held as usize];
                chosen(pair.row, pair.column, pair.cost);
                outcome.assigned += 1;
            }
        }
        outcome
    }

    /// Takes over the admissible pairs. Returns the number of ignored pairs.
    fn admit(&mut self, pairs: &[Pair], unassigned_cost: f64) -> usize {
        self.pairs.clear();
        let mut ignored = 0;
        for pair in pairs {
            let known = (pair.row as usize) < self.rows.len() && (pair.column as usize) < self.columns_max;
            let worthwhile = unassigned_cost.is_finite() && pair.cost.is_finite() && pair.cost <= unassigned_cost;
            if known && worthwhile && self.pairs.len() < self.pairs_max {
                self.pairs.push(*pair);
            } else if worthwhile {
                ignored += 1;
            }
        }
        ignored
    }

    /// Finds the components: afterwards the parent of each row is the first row of its component.
    fn split(&mut self) {
        let first_column = self.rows.len() as u32;
        for pair in &self.pairs {
            for member in [pair.row, first_column + pair.column] {
                self.parent[member as usize] = member;
            }
        }
        for pair in &self.pairs {
            join(&mut self.parent, pair.row, first_column + pair.column);
        }
        for pair in &self.pairs {
            self.parent[pair.row as usize] = representative(&mut self.parent, pair.row);
        }
    }

    /// Sorts the pairs and notes the range of each row's pairs.
    fn index(&mut self) {
        let parent = &self.parent;
        self.pairs.sort_unstable_by(|one, other| {
            let key = |pair: &Pair| (parent[pair.row as usize], pair.row, pair.column);
            key(one).cmp(&key(other)).then(one.cost.total_cmp(&other.cost))
        });
        self.pairs.dedup_by_key(|pair| (pair.row, pair.column));
        self.order.clear();
        for (place, pair) in (0..).zip(&self.pairs) {
            let row = &mut self.rows[pair.row as usize];
            if self.order.last() != Some(&pair.row) {
                self.order.push(pair.row);
                row.start = place;
            }
            row.end = place + 1;
        }
        self.paths
            .forget(self.order.iter().copied(), self.pairs.iter().map(|pair| pair.column));
    }

    /// End in the order of the component that begins at `begin`.
    fn component_end(&self, begin: usize) -> usize {
        let component = |row: &u32| self.parent[*row as usize];
        let first = component(&self.order[begin]);
        let same = self.order[begin..].iter().take_while(|row| component(row) == first);
        begin + same.count()
    }

    /// Places of the pairs of the rows at `begin..end` of the order.
    fn places(&self, begin: usize, end: usize) -> Range<u32> {
        let (first, last) = (self.order[begin], self.order[end - 1]);
        self.rows[first as usize].start..self.rows[last as usize].end
    }

    /// Brings in the rows at `begin..end` of the order, with a step limit that depends on the number of their pairs.
    fn choose_exactly(&mut self, begin: usize, end: usize, unassigned_cost: f64) -> Result<(), StopReason> {
        let mut steps_left = STEPS_PER_PAIR_MAX * self.places(begin, end).len();
        let sparse = Sparse {
            pairs: &self.pairs,
            rows: &self.rows,
            unassigned_cost,
        };
        let (paths, mut rows) = (&mut self.paths, self.order[begin..end].iter());
        rows.try_for_each(|row| paths.bring_in(&sparse, *row, &mut steps_left))
    }

    /// Discards the search for the rows at `begin..end` of the order, and takes their cheapest pair, then the next
    /// possible pair, and so on.
    fn choose_greedily(&mut self, begin: usize, end: usize) {
        let places = self.places(begin, end);
        let pairs = &mut self.pairs[places.start as usize..places.end as usize];
        pairs.sort_unstable_by(|one, other| {
            let labels = (one.row, one.column).cmp(&(other.row, other.column));
            one.cost.total_cmp(&other.cost).then(labels)
        });
        let (rows, columns) = (pairs.iter().map(|pair| pair.row), pairs.iter().map(|pair| pair.column));
        self.paths.forget(rows, columns);
        for (place, &Pair { row, column, cost }) in (places.start..).zip(&*pairs) {
            self.paths.take_free(place, Choice { row, column, cost });
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn pairs(listed: &[(u32, u32, f64)]) -> Vec<Pair> {
        listed
            .iter()
            .map(|&(row, column, cost)| Pair { row, column, cost })
            .collect()
    }

    fn solve(memory: &mut Assignment, pairs: &[Pair], unassigned_cost: f64) -> (Vec<(u32, u32, f64)>, Outcome) {
        let mut chosen = Vec::new();
        let outcome = memory.solve(pairs, unassigned_cost, |row, column, cost| {
            chosen.push((row, column, cost))
        });
        assert_eq!(outcome.assigned, chosen.len());
        (chosen, outcome)
    }

    /// Chosen pairs of a problem with at most eight rows and columns.
    fn solution(listed: &[(u32, u32, f64)], unassigned_cost: f64) -> Vec<(u32, u32, f64)> {
        let (chosen, outcome) = solve(&mut Assignment::new(8, 8, 64), &pairs(listed), unassigned_cost);
        assert_eq!((outcome.greedy_components, outcome.ignored_pairs), (0, 0));
        chosen
    }

    /// The smallest possible sum for `rows` rows from `row` on, by trying everything.
    fn smallest(pairs: &[Pair], unassigned_cost: f64, row: u32, rows: u32, taken: &mut Vec<u32>) -> f64 {
        if row == rows {
            return 0.0;
        }
        let mut best = unassigned_cost + smallest(pairs, unassigned_cost, row + 1, rows, taken);
        for pair in pairs.iter().filter(|pair| pair.row == row && pair.cost.is_finite()) {
            if !taken.contains(&pair.column) {
                taken.push(pair.column);
                best = best.min(pair.cost + smallest(pairs, unassigned_cost, row + 1, rows, taken));
                taken.pop();
            }
        }
        best
    }

    fn assert_one_to_one(chosen: &[(u32, u32, f64)]) {
        assert!(chosen.is_sorted_by(|one, other| one.0 < other.0), "rows do not ascend");
        let mut columns: Vec<u32> = chosen.iter().map(|&(_, column, _)| column).collect();
        columns.sort_unstable();
        assert!(
            columns.is_sorted_by(|one, other| one < other),
            "a column was given twice"
        );
    }

    /// Targets in line, 300 m apart, all shown `shift_m` too far along by a sensor of 100 m: squared distances.
    fn formation(targets: u32, shift_m: f64) -> Vec<Pair> {
        let squared = |report: u32, track: u32| {
            let apart_m = 300.0 * f64::from(report) + shift_m - 300.0 * f64::from(track);
            (apart_m / 100.0).powi(2)
        };
        let all = (0..targets).flat_map(|row| (0..targets).map(move |column| (row, column)));
        all.map(|(row, column)| Pair {
            row,
            column,
            cost: squared(row, column),
        })
        .collect()
    }

    #[test]
    fn a_formation_moves_as_one() {
        for (targets, shift_m) in [(2, 200.0), (12, 160.0), (500, 150.2)] {
            let size = targets as usize;
            let (chosen, outcome) = solve(
                &mut Assignment::new(size, size, size * size),
                &formation(targets, shift_m),
                9.21,
            );
            assert_eq!(
                outcome,
                Outcome {
                    assigned: size,
                    ..Outcome::default()
                }
            );
            assert!(chosen.iter().all(|&(row, column, _)| row == column), "{chosen:?}");
        }
    }

    /// A line of `length` rows, each with its own column or the next, and half as many late rows with the first
    /// column: the search of each late row covers all of the line, in vain.
    fn hard(length: u32) -> Vec<Pair> {
        let own = (0..length).map(|row| (row, row, 0.0));
        let next = (1..length).map(|column| (column - 1, column, 0.0));
        let late = (length..3 * length / 2).map(|row| (row, 0, 1.0));
        pairs(&own.chain(next).chain(late).collect::<Vec<_>>())
    }

    #[test]
    fn one_huge_hard_component_is_decided_greedily_and_counted() {
        // Row 3000 takes the column needed by row 3001, unlike the exact solution; a pair with column 0 makes both
        // part of the component.
        let trap = pairs(&[(3000, 0, 8.0), (3000, 2000, 0.0), (3000, 2001, 1.0), (3001, 2000, 0.5)]);
        assert_eq!(solve(&mut Assignment::new(3002, 2002, 4), &trap, 9.0).1.assigned, 2);
        let all = [hard(2000), trap].concat();
        let (chosen, outcome) = solve(&mut Assignment::new(3002, 2002, 5003), &all, 9.0);
        let greedy = (0..2000).chain([3000]).map(|row| (row, row.min(2000), 0.0));
        assert_eq!(chosen, greedy.collect::<Vec<_>>());
        assert_eq!((outcome.greedy_components, outcome.ignored_pairs), (1, 0));
    }

    #[test]
    fn components_are_decided_apart() {
        // A hard component from row and column 1 on, and two rows, before and after it, in competition for column 0.
        let moved = |pair: Pair| Pair {
            row: pair.row + 1,
            column: pair.column + 1,
            ..pair
        };
        let mut all: Vec<Pair> = hard(2000).into_iter().map(moved).collect();
        all.extend(pairs(&[(0, 0, 3.0), (3001, 0, 2.0)]));
        let (chosen, outcome) = solve(&mut Assignment::new(3002, 2001, 5001), &all, 9.0);
        assert_one_to_one(&chosen);
        assert_eq!((outcome.assigned, outcome.greedy_components), (2001, 1));
        assert_eq!(
            (chosen.first(), chosen.last()),
            (Some(&(1, 1, 0.0)), Some(&(3001, 0, 2.0)))
        );
    }

    #[test]
    fn a_chain_moves_everyone_up_by_one() {
        let listed = [(0, 0, 1.0), (0, 1, 2.0), (1, 1, 1.0), (1, 2, 2.0), (2, 0, 1.0)];
        assert_eq!(solution(&listed, 9.0), [(0, 1, 2.0), (1, 2, 2.0), (2, 0, 1.0)]);
    }

    #[test]
    fn a_row_gives_way_where_another_gains_more() {
        assert_eq!(solution(&[(0, 0, 3.0), (1, 0, 1.0), (2, 0, 2.0)], 9.0), [(1, 0, 1.0)]);
    }

    #[test]
    fn of_equals_the_lower_label_wins() {
        assert_eq!(solution(&[(2, 3, 1.0), (1, 3, 1.0)], 9.0), [(1, 3, 1.0)]);
        assert_eq!(solution(&[(1, 5, 1.0), (1, 3, 1.0)], 9.0), [(1, 3, 1.0)]);
    }

    #[test]
    fn the_cheapest_of_a_repeated_pair_counts() {
        assert_eq!(solution(&[(1, 1, 3.0), (1, 1, 2.0), (1, 1, 4.0)], 9.0), [(1, 1, 2.0)]);
    }

    #[test]
    fn nothing_gives_nothing() {
        assert_eq!(solution(&[], 9.0), []);
        let mut memory = Assignment::new(0, 0, 0);
        assert_eq!(solve(&mut memory, &[], 9.0), (vec![], Outcome::default()));
    }

    #[test]
    fn what_costs_too_much_or_no_number_is_never_chosen() {
        let listed = [
            (0, 0, 9.5),
            (1, 1, f64::NAN),
            (2, 2, f64::INFINITY),
            (3, 3, f64::NEG_INFINITY),
            (4, 4, 9.0),
        ];
        assert_eq!(solution(&listed, 9.0), [(4, 4, 9.0)]);
        for unassigned_cost in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(solution(&[(0, 0, 1.0)], unassigned_cost), []);
        }
    }

    #[test]
    fn pairs_without_room_and_with_unknown_labels_are_ignored_and_counted() {
        let mut memory = Assignment::new(2, 3, 2);
        let listed = pairs(&[
            (2, 0, 1.0),
            (0, 3, 1.0),
            (u32::MAX, u32::MAX, 1.0),
            (0, 0, 99.0),
            (0, 2, 1.0),
        ]);
        let (chosen, outcome) = solve(&mut memory, &listed, 9.0);
        assert_eq!((chosen, outcome.ignored_pairs), (vec![(0, 2, 1.0)], 3));
        let (chosen, outcome) = solve(&mut memory, &pairs(&[(0, 0, 3.0), (1, 0, 2.0), (0, 1, 1.0)]), 9.0);
        assert_eq!(
            (chosen, outcome.ignored_pairs),
            (vec![(1, 0, 2.0)], 1),
            "the third had no room"
        );
    }

    fn cost() -> impl Strategy<Value = f64> {
        // Whole numbers make ties, fractions make near misses.
        prop_oneof![
            8 => (-2i32..9).prop_map(f64::from),
            8 => -1.0..9.0f64,
            1 => Just(f64::NAN),
            1 => Just(f64::INFINITY),
        ]
    }

    /// Rows, columns and pairs.
    fn problem(rows_max: u32, pairs_max: usize) -> impl Strategy<Value = (u32, u32, Vec<Pair>)> {
        (1..rows_max, 1..rows_max).prop_flat_map(move |(rows, columns)| {
            let pair = (0..rows, 0..columns, cost()).prop_map(|(row, column, cost)| Pair { row, column, cost });
            (Just(rows), Just(columns), prop::collection::vec(pair, 0..pairs_max))
        })
    }

    proptest! {
        #[test]
        fn no_other_choice_costs_less(problems in prop::collection::vec((problem(7, 24), -1.0..8.0f64), 1..4)) {
            // The same memory for all: a problem must leave nothing behind for the next.
            let mut memory = Assignment::new(7, 7, 24);
            for ((rows, _, pairs), unassigned_cost) in problems {
                let (chosen, outcome) = solve(&mut memory, &pairs, unassigned_cost);
                assert_one_to_one(&chosen);
                prop_assert_eq!(outcome.greedy_components + outcome.ignored_pairs, 0);
                for &(row, column, cost) in &chosen {
                    let listed = pairs.contains(&Pair { row, column, cost });
                    prop_assert!(listed && cost <= unassigned_cost, "{} {} {}", row, column, cost);
                }
                let alone = f64::from(rows) - chosen.len() as f64;
                let found = chosen.iter().map(|each| each.2).sum::<f64>() + alone * unassigned_cost;
                let best = smallest(&pairs, unassigned_cost, 0, rows, &mut Vec::new());
                prop_assert!((found - best).abs() < 1e-9, "{} instead of {}", found, best);
            }
        }

        #[test]
        fn the_order_of_the_pairs_does_not_matter(
            (pairs, shuffled) in prop_oneof![problem(7, 24), problem(120, 400)].prop_flat_map(|(_, _, pairs)| {
                (Just(pairs.clone()), Just(pairs).prop_shuffle())
            }),
            unassigned_cost in 0.0..8.0f64,
        ) {
            let mut memory = Assignment::new(120, 120, 400);
            let straight = solve(&mut memory, &pairs, unassigned_cost);
            assert_one_to_one(&straight.0);
            prop_assert_eq!(solve(&mut memory, &shuffled, unassigned_cost), straight);
        }
    }
}
