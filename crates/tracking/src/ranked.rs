//! Ranked interpretations of a scan over all hypotheses of a cluster: the most likely first (HT-11).
//!
//! All interpretations are far too many: ten detections, each false, new or of any of three tracks, have millions. Only
//! the best few dozen are kept. In logarithms the likelihood of an interpretation is a sum over its rows, so the best
//! interpretation is an assignment problem: each row takes a single choice, and no column is taken twice (false and new
//! belong to the row alone and exclude no other row). The problem is solved by shortest augmenting paths
//! ([`association::augmenting`]).
//!
//! Murty's method finds the next solutions. The remaining solutions are split into disjoint parts: the first row
//! changes the choice; the first row keeps the choice and the second changes; and so on. The best solution of each part
//! is again an assignment problem. The parts of all parent hypotheses wait in a single heap, so the best children of
//! the cluster come out in order over all parents, and no part is solved twice.
//!
//! Bounds: at most [`ROWS_MAX`] rows of at most [`CHOICES_MAX`] choices, [`COLUMNS_MAX`] columns, and the tables'
//! sizes; entries without room are dropped and counted. Time is bounded by the number of requested solutions times
//! rows, each with a single assignment problem. Equal costs come out in the order of the problems and the choices.
//!
//! Sources: K. G. Murty, *An algorithm for ranking all the assignments in order of increasing cost*, Operations
//! Research 16 (1968); I. J. Cox, S. L. Hingorani, *An efficient implementation of Reid's multiple hypothesis tracking
//! algorithm*, IEEE Transactions on Pattern Analysis and Machine Intelligence 18 (1996).

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::ops::Range;

use association::augmenting::{self, AugmentingPaths};

use crate::log_sum::{log_add, log_sum};

/// Most rows of a problem.
pub(crate) const ROWS_MAX: usize = 64;
/// Most choices of a row: forbidden choices are bits of a word.
pub(crate) const CHOICES_MAX: usize = 64;
/// Most columns of a problem.
pub(crate) const COLUMNS_MAX: usize = 256;
/// Most problems at a time.
pub(crate) const PROBLEMS_MAX: usize = 256;
/// Most choices of all rows of all problems.
const CHOICES_TOTAL_MAX: usize = 1 << 17;
/// Maximum of parts in the heap, including parts already taken out.
const PARTS_MAX: usize = 1 << 14;

/// The column of a choice that bars no other row.
pub(crate) const OWN: u16 = u16::MAX;

/// Something that a row may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Alternative {
    /// Column of the choice, or [`OWN`].
    pub(crate) column: u16,
    /// Meaning of the choice, for the caller alone.
    pub(crate) meaning: u32,
    /// Negative logarithm of the likelihood.
    pub(crate) cost: f64,
}

#[derive(Clone, Copy, Debug)]
struct RankedProblem {
    base_cost: f64,
    first_row: usize,
    rows: usize,
    columns: usize,
}

/// All solutions of a problem with the first `fixed` rows as `chosen` and the next row without the choices in
/// `forbidden`; `chosen` is the best solution.
#[derive(Clone, Copy, Debug)]
struct SolutionPart {
    problem: u16,
    fixed: u8,
    chosen: [u8; ROWS_MAX],
    forbidden: u64,
    cost: f64,
    /// Logarithm of an upper bound of the likelihood of all solutions together.
    log_bound: f64,
}

impl SolutionPart {
    /// All solutions of a problem.
    fn whole(problem: usize) -> Self {
        Self {
            problem: problem as u16,
            fixed: 0,
            chosen: [0; ROWS_MAX],
            forbidden: 0,
            cost: 0.0,
            log_bound: 0.0,
        }
    }
}

/// A place in the heap: cheapest first, then earliest made.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Queued {
    cost: f64,
    part: u32,
}

impl Eq for Queued {}

impl Ord for Queued {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.part.cmp(&other.part))
    }
}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The rows of a part with the open choices. The label of a choice is the row and the number in the row.
struct OpenRows<'a> {
    choices: &'a [Alternative],
    /// Places of each row's choices.
    rows: &'a [Range<u32>],
    /// Row that may not take the choices of `forbidden`.
    limited: u32,
    forbidden: u64,
}

impl OpenRows<'_> {
    fn column(choice: &Alternative) -> u32 {
        if choice.column == OWN {
            augmenting::NONE
        } else {
            u32::from(choice.column)
        }
    }
}

impl augmenting::Problem for OpenRows<'_> {
    const OWN_FIRST: bool = true;

    #[inline]
    fn show_choices(&self, row: u32, mut each: impl FnMut(u32, u32, f64)) {
        let forbidden = if row == self.limited { self.forbidden } else { 0 };
        let Range { start, end } = self.rows[row as usize];
        for (number, choice) in (0..).zip(&self.choices[start as usize..end as usize]) {
            if forbidden >> number & 1 == 0 {
                each(row * CHOICES_MAX as u32 + number, Self::column(choice), choice.cost);
            }
        }
    }

    #[inline]
    fn choice(&self, label: u32) -> augmenting::Choice {
        let (row, number) = (label / CHOICES_MAX as u32, label % CHOICES_MAX as u32);
        let choice = &self.choices[(self.rows[row as usize].start + number) as usize];
        augmenting::Choice {
            row,
            column: Self::column(choice),
            cost: choice.cost,
        }
    }
}

/// Working memory for ranked solutions, reused for each cluster.
#[derive(Clone, Debug)]
pub(crate) struct Ranked {
    problems: Vec<RankedProblem>,
    /// Places of each row's choices.
    rows: Vec<Range<u32>>,
    /// By row: logarithm of the product, over this row and all later rows, of the sums of the choices' likelihoods.
    log_rest: Vec<f64>,
    choices: Vec<Alternative>,
    parts: Vec<SolutionPart>,
    heap: BinaryHeap<Reverse<Queued>>,
    paths: AugmentingPaths,
    /// Logarithm of the bound of the parts for which there was no room.
    log_dropped: f64,
}

/// The next best solution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solution {
    pub(crate) problem: usize,
    pub(crate) cost: f64,
    part: u32,
}

impl Ranked {
    pub(crate) fn new() -> Self {
        Self {
            problems: Vec::with_capacity(PROBLEMS_MAX),
            rows: Vec::with_capacity(PROBLEMS_MAX * ROWS_MAX),
            log_rest: Vec::with_capacity(PROBLEMS_MAX * ROWS_MAX),
            choices: Vec::with_capacity(CHOICES_TOTAL_MAX),
            parts: Vec::with_capacity(PARTS_MAX),
            heap: BinaryHeap::with_capacity(PARTS_MAX),
            paths: AugmentingPaths::new(ROWS_MAX, COLUMNS_MAX),
            log_dropped: f64::NEG_INFINITY,
        }
    }

    /// Forgets all problems.
    pub(crate) fn clear(&mut self) {
        self.problems.clear();
        self.rows.clear();
        self.log_rest.clear();
        self.choices.clear();
        self.parts.clear();
        self.heap.clear();
        self.log_dropped = f64::NEG_INFINITY;
    }

    /// Begins a problem with a base cost added to the costs of the choices. `false` if there is no room.
    pub(crate) fn begin_problem(&mut self, base_cost: f64) -> bool {
        let room = self.problems.len() < PROBLEMS_MAX;
        if room {
            self.problems.push(RankedProblem {
                base_cost,
                first_row: self.rows.len(),
                rows: 0,
                columns: 0,
            });
        }
        room
    }

    /// Begins the next row of the problem begun last. `false` if there is no room.
    pub(crate) fn begin_row(&mut self) -> bool {
        let place = self.choices.len() as u32;
        let room = self.rows.len() < PROBLEMS_MAX * ROWS_MAX;
        match self.problems.last_mut() {
            Some(problem) if problem.rows < ROWS_MAX && room => {
                problem.rows += 1;
                self.rows.push(place..place);
                true
            }
            _ => false,
        }
    }

    /// Adds a choice to the row begun last. `false` if there is no room, or the cost is no number.
    pub(crate) fn add(&mut self, choice: Alternative) -> bool {
        let room = self.choices.len() < CHOICES_TOTAL_MAX && choice.cost.is_finite();
        let (Some(problem), Some(row)) = (self.problems.last_mut(), self.rows.last_mut()) else {
            return false;
        };
        let known = choice.column == OWN || usize::from(choice.column) < COLUMNS_MAX;
        if !room || !known || row.len() >= CHOICES_MAX {
            return false;
        }
        if choice.column != OWN {
            problem.columns = problem.columns.max(usize::from(choice.column) + 1);
        }
        row.end += 1;
        self.choices.push(choice);
        true
    }

    /// Cost of a problem's cheapest solution; before [`Self::begin`].
    pub(crate) fn best_cost(&mut self, number: usize) -> Option<f64> {
        let problem = self.problems[number];
        self.solve(&problem, &mut SolutionPart::whole(number))
    }

    /// Lets all solutions of a problem cost less by so much; before [`Self::begin`].
    pub(crate) fn lower(&mut self, number: usize, by: f64) {
        self.problems[number].base_cost -= by;
    }

    /// Solves each problem once; before the first call of [`Self::next`].
    pub(crate) fn begin(&mut self) {
        self.log_rest.resize(self.rows.len(), 0.0);
        for number in 0..self.problems.len() {
            let problem = self.problems[number];
            let mut rest = 0.0;
            for row in (problem.first_row..problem.first_row + problem.rows).rev() {
                rest += self.log_row(row, 0, |_| false);
                self.log_rest[row] = rest;
            }
            self.submit(SolutionPart::whole(number));
        }
    }

    /// Logarithm of a likelihood that all solutions that have not come out do not exceed together. −∞ once all are out.
    pub(crate) fn log_left(&self) -> f64 {
        let waiting = self
            .heap
            .iter()
            .map(|Reverse(queued)| self.parts[queued.part as usize].log_bound);
        log_add(log_sum(waiting), self.log_dropped)
    }

    /// Logarithm of the sum of the likelihoods of a row's choices that are not forbidden and not taken.
    fn log_row(&self, row: usize, forbidden: u64, taken: impl Fn(u16) -> bool) -> f64 {
        let range = self.rows[row].clone();
        let choices = self.choices[range.start as usize..range.end as usize]
            .iter()
            .enumerate();
        let open = choices.filter(|(number, choice)| forbidden >> number & 1 == 0 && !taken(choice.column));
        log_sum(open.map(|(_, choice)| -choice.cost))
    }

    /// Logarithm of the bound of a part: each row, except the fixed rows, takes all choices regardless of the others.
    fn log_bound(&self, part: &SolutionPart) -> f64 {
        let problem = self.problems[usize::from(part.problem)];
        let fixed = usize::from(part.fixed);
        let choice = |row: usize| self.choice(&problem, row as u8, part.chosen[row]);
        let known = -problem.base_cost - (0..fixed).map(|row| choice(row).cost).sum::<f64>();
        if fixed == problem.rows {
            return known;
        }
        let taken = |column: u16| column != OWN && (0..fixed).any(|row| choice(row).column == column);
        let here = problem.first_row + fixed;
        let after = if fixed + 1 < problem.rows {
            self.log_rest[here + 1]
        } else {
            0.0
        };
        known + self.log_row(here, part.forbidden, taken) + after
    }

    /// Cost of the next solution, if any.
    pub(crate) fn next_cost(&self) -> Option<f64> {
        self.heap.peek().map(|Reverse(queued)| queued.cost)
    }

    /// The cheapest solution that has not come out before.
    pub(crate) fn next(&mut self) -> Option<Solution> {
        let Reverse(queued) = self.heap.pop()?;
        let best = self.parts[queued.part as usize];
        let rows = self.problems[usize::from(best.problem)].rows;
        for row in usize::from(best.fixed)..rows {
            let already = if row == usize::from(best.fixed) {
                best.forbidden
            } else {
                0
            };
            self.submit(SolutionPart {
                fixed: row as u8,
                forbidden: already | 1 << best.chosen[row],
                ..best
            });
        }
        Some(Solution {
            problem: usize::from(best.problem),
            cost: queued.cost,
            part: queued.part,
        })
    }

    /// Meanings of the choices that the rows take in a solution.
    pub(crate) fn meanings(&self, solution: Solution) -> impl Iterator<Item = u32> + '_ {
        let part = &self.parts[solution.part as usize];
        let problem = self.problems[solution.problem];
        (0..problem.rows).map(move |row| self.choice(&problem, row as u8, part.chosen[row]).meaning)
    }

    /// Solves a part and adds it to the heap, if there is a solution.
    fn submit(&mut self, mut part: SolutionPart) {
        part.log_bound = self.log_bound(&part);
        if self.parts.len() >= PARTS_MAX {
            self.log_dropped = log_add(self.log_dropped, part.log_bound);
            return;
        }
        let problem = self.problems[usize::from(part.problem)];
        let Some(cost) = self.solve(&problem, &mut part) else {
            return;
        };
        part.cost = cost;
        let place = self.parts.len() as u32;
        self.parts.push(part);
        self.heap.push(Reverse(Queued { cost, part: place }));
    }

    fn choice(&self, problem: &RankedProblem, row: u8, choice: u8) -> Alternative {
        let range = &self.rows[problem.first_row + usize::from(row)];
        self.choices[range.start as usize + usize::from(choice)]
    }

    /// Returns the cost of the part's best solution, and writes the solution to the part's choices; `None` without a
    /// solution.
    fn solve(&mut self, problem: &RankedProblem, part: &mut SolutionPart) -> Option<f64> {
        self.paths
            .forget_ranges(usize::from(part.fixed)..problem.rows, 0..problem.columns);
        for row in 0..part.fixed {
            let column = self.choice(problem, row, part.chosen[usize::from(row)]).column;
            if column != OWN {
                // Fixed rows are never displaced.
                self.paths.bar(u32::from(column));
            }
        }
        let open = OpenRows {
            choices: &self.choices,
            rows: &self.rows[problem.first_row..problem.first_row + problem.rows],
            limited: u32::from(part.fixed),
            forbidden: part.forbidden,
        };
        let mut steps = usize::MAX;
        for row in part.fixed..problem.rows as u8 {
            self.paths.bring_in(&open, u32::from(row), &mut steps).ok()?;
        }
        for row in usize::from(part.fixed)..problem.rows {
            part.chosen[row] = (self.paths.held(row as u32) % CHOICES_MAX as u32) as u8;
        }
        let chosen = (0..problem.rows).map(|row| self.choice(problem, row as u8, part.chosen[row]).cost);
        Some(problem.base_cost + chosen.sum::<f64>())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Problems: base cost, then rows of choices.
    type Listed = Vec<(f64, Vec<Vec<(u16, f64)>>)>;

    fn pose(ranked: &mut Ranked, problems: &Listed) {
        ranked.clear();
        for (base, rows) in problems {
            assert!(ranked.begin_problem(*base));
            for row in rows {
                assert!(ranked.begin_row());
                for (meaning, (column, cost)) in (0..).zip(row) {
                    assert!(ranked.add(Alternative {
                        column: *column,
                        meaning,
                        cost: *cost
                    }));
                }
            }
        }
        ranked.begin();
    }

    /// Every solution: cost, problem, choices.
    fn all(problems: &Listed) -> Vec<(f64, usize, Vec<u32>)> {
        fn extend(
            rows: &[Vec<(u16, f64)>],
            cost: f64,
            taken: &mut Vec<u16>,
            chosen: &mut Vec<u32>,
            found: &mut Vec<(f64, Vec<u32>)>,
        ) {
            let Some(row) = rows.first() else {
                found.push((cost, chosen.clone()));
                return;
            };
            for (number, (column, own)) in (0..).zip(row) {
                if *column != OWN && taken.contains(column) {
                    continue;
                }
                taken.push(*column);
                chosen.push(number);
                extend(&rows[1..], cost + own, taken, chosen, found);
                taken.pop();
                chosen.pop();
            }
        }
        let mut every = Vec::new();
        for (problem, (base, rows)) in problems.iter().enumerate() {
            let mut found = Vec::new();
            extend(rows, *base, &mut Vec::new(), &mut Vec::new(), &mut found);
            every.extend(found.into_iter().map(|(cost, chosen)| (cost, problem, chosen)));
        }
        every.sort_by(|one, other| one.0.total_cmp(&other.0));
        every
    }

    fn drawn(ranked: &mut Ranked) -> Vec<(f64, usize, Vec<u32>)> {
        let mut found = Vec::new();
        while let Some(solution) = ranked.next() {
            let meanings = ranked.meanings(solution).collect();
            found.push((solution.cost, solution.problem, meanings));
        }
        found
    }

    fn any_problems() -> impl Strategy<Value = Listed> {
        let cost = prop_oneof![4 => -5.0..5.0f64, 1 => (-2i32..3).prop_map(f64::from)];
        let choice = (prop_oneof![2 => 0u16..4, 1 => Just(OWN)], cost);
        let row = prop::collection::vec(choice, 0..6).prop_map(|mut row| {
            // A column stands once in a row.
            row.sort_by_key(|(column, _)| *column);
            row.dedup_by_key(|(column, _)| *column);
            row
        });
        prop::collection::vec((-3.0..3.0f64, prop::collection::vec(row, 0..5)), 0..4)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn every_solution_comes_out_once_and_in_order(problems in prop::collection::vec(any_problems(), 1..3)) {
            // The same memory for all problems: a cluster must not affect the next cluster.
            let mut ranked = Ranked::new();
            for problems in problems {
                pose(&mut ranked, &problems);
                let (found, expected) = (drawn(&mut ranked), all(&problems));
                prop_assert_eq!(found.len(), expected.len());
                for (found, expected) in found.iter().zip(&expected) {
                    prop_assert!((found.0 - expected.0).abs() < 1e-9, "{:?} {:?}", found, expected);
                }
                let sorted = |mut list: Vec<(f64, usize, Vec<u32>)>| {
                    list.sort_by(|one, other| (one.1, &one.2).cmp(&(other.1, &other.2)));
                    list.into_iter().map(|each| (each.1, each.2)).collect::<Vec<_>>()
                };
                prop_assert_eq!(ranked.log_left(), f64::NEG_INFINITY);
                pose(&mut ranked, &problems);
                for drawn in 0..expected.len() {
                    let left = log_sum(expected[drawn..].iter().map(|each| -each.0));
                    prop_assert!(ranked.log_left() >= left - 1e-9, "{drawn} of {} drawn", expected.len());
                    ranked.next();
                }
                prop_assert_eq!(sorted(found), sorted(expected));
            }
        }
    }

    #[test]
    fn a_scan_without_detections_has_one_interpretation_per_hypothesis() {
        let mut ranked = Ranked::new();
        pose(&mut ranked, &vec![(2.0, vec![]), (1.0, vec![])]);
        assert_eq!(drawn(&mut ranked), [(1.0, 1, vec![]), (2.0, 0, vec![])]);
    }

    #[test]
    fn what_finds_no_room_is_refused() {
        let mut ranked = Ranked::new();
        let choice = Alternative {
            column: OWN,
            meaning: 0,
            cost: 0.0,
        };
        assert!(!ranked.begin_row() && !ranked.add(choice), "there is no problem yet");
        assert!(ranked.begin_problem(0.0));
        for _ in 0..ROWS_MAX {
            assert!(ranked.begin_row());
            for _ in 0..CHOICES_MAX {
                assert!(ranked.add(choice));
            }
            assert!(!ranked.add(choice), "one choice too many");
        }
        assert!(!ranked.begin_row(), "one row too many");
        assert!(!ranked.add(Alternative {
            cost: f64::NAN,
            ..choice
        }));
        ranked.begin();
        // 64 rows of 64 equal choices have more solutions than there are atoms; each requested solution leaves 63
        // parts.
        for _ in 0..1000 {
            assert!(ranked.next().is_some());
        }
        assert!(ranked.log_dropped > 0.0, "the table of parts is full");
        assert!(ranked.log_left() > ranked.log_dropped);
    }
}
