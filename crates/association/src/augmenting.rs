//! Shortest augmenting paths: the solver of every assignment problem.
//!
//! Rows are added in turn. A row may displace the holder of a column to another column, the holder of that column
//! moves to yet another, and so on, until the chain ends at a free column, or at a row with an own choice that bars no
//! other row. Dijkstra's search finds the cheapest such chain. Prices on the columns keep the results of earlier
//! searches, so that no step of a chain but the first has a negative cost and the result is exact.
//!
//! The search visits only the choices of a row. Thus the cost grows with the crowding, and hardly with the number of
//! columns. The worst case grows with the cube of the crowd, so callers with a time bound pass a maximum of steps.
//! Among columns reached at the same cost the lowest number comes first.
//!
//! Source: R. Jonker, A. Volgenant, *A shortest augmenting path algorithm for dense and sparse linear assignment
//! problems*, Computing 38 (1987).

use std::ops::Range;

/// Label of no choice, column of no column.
pub const NONE: u32 = u32::MAX;

/// Choice of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Row of the choice.
    pub row: u32,
    /// Column of the choice; [`NONE`] for the row's own choice.
    pub column: u32,
    /// Cost, a finite number, possibly negative.
    pub cost: f64,
}

/// A sparse assignment problem: each row takes a choice, no column is taken twice, and the sum of the costs is
/// smallest.
pub trait Problem {
    /// Tie rule for two chains of the same cost: the chain that ends at a row's own choice is made (`true`), or the
    /// chain that ends at a column (`false`).
    const OWN_FIRST: bool;

    /// Shows `each` every choice of a row, as label, column (or [`NONE`]) and cost.
    fn show_choices(&self, row: u32, each: impl FnMut(u32, u32, f64));

    /// The choice with a label, other than [`NONE`].
    fn choice(&self, label: u32) -> Choice;
}

/// Reason why a row could not be brought in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// Every change leaves a row without a choice.
    NoChoice,
    /// The search takes more steps than permitted.
    NoSteps,
}

/// Choices made so far, prices, and the working memory of a search.
#[derive(Clone, Debug)]
pub struct AugmentingPaths {
    columns: Vec<ColumnState>,
    /// By row: label of the taken choice, or [`NONE`].
    held: Vec<u32>,
    /// Columns reached by the search that may still be reached more cheaply, with the costs of the chains to these
    /// columns, as [`ordered`]: side by side, because of the repeated access to all of them.
    frontier: Vec<(i64, u32)>,
    /// Columns passed by the search.
    passed: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct ColumnState {
    /// Label of the choice that holds the column, or [`NONE`].
    held: u32,
    /// Dual price: cost of holding the column. 0 while the column is free.
    price: f64,
    /// Cost of the cheapest known chain to the column.
    reached: f64,
    /// Label of the last choice of that chain, or [`NONE`].
    through: u32,
    /// Place in the frontier.
    place: u32,
    /// No cheaper chain can be found.
    passed: bool,
}

impl ColumnState {
    const FREE: Self = Self {
        held: NONE,
        price: 0.0,
        reached: f64::INFINITY,
        through: NONE,
        place: 0,
        passed: false,
    };

    #[inline]
    fn forget_search(&mut self) {
        (self.reached, self.through, self.passed) = (f64::INFINITY, NONE, false);
    }
}

/// Number with the same order as a cost under [`f64::total_cmp`].
#[inline]
fn ordered(cost: f64) -> i64 {
    let bits = cost.to_bits() as i64;
    bits ^ ((bits >> 63) as u64 >> 1) as i64
}

/// End of a chain of changes.
#[derive(Clone, Copy)]
enum ChainEnd {
    /// At a free column.
    Column(u32),
    /// At a row with an own choice of this label.
    Own(u32, u32),
}

impl AugmentingPaths {
    /// Memory for rows `0..rows_max` and columns `0..columns_max`.
    pub fn new(rows_max: usize, columns_max: usize) -> Self {
        Self {
            columns: vec![ColumnState::FREE; columns_max],
            held: vec![NONE; rows_max],
            frontier: Vec::with_capacity(columns_max),
            passed: Vec::with_capacity(columns_max),
        }
    }

    /// Resets these rows and columns before the first row of a problem is added.
    #[inline]
    pub fn forget_ranges(&mut self, rows: Range<usize>, columns: Range<usize>) {
        self.frontier.clear();
        self.passed.clear();
        self.held[rows].fill(NONE);
        self.columns[columns].fill(ColumnState::FREE);
    }

    /// Resets the listed rows and columns.
    pub fn forget(&mut self, rows: impl Iterator<Item = u32>, columns: impl Iterator<Item = u32>) {
        self.frontier.clear();
        self.passed.clear();
        rows.for_each(|row| self.held[row as usize] = NONE);
        columns.for_each(|column| self.columns[column as usize] = ColumnState::FREE);
    }

    /// Keeps a column out of reach of all rows, until it is forgotten.
    pub fn bar(&mut self, column: u32) {
        self.columns[column as usize].passed = true;
    }

    /// Label of the choice taken by a row; [`NONE`] before the row is brought in.
    #[inline]
    pub fn held(&self, row: u32) -> u32 {
        self.held[row as usize]
    }

    /// Gives a row a final choice, if neither the row nor the column is taken.
    pub fn take_free(&mut self, label: u32, choice: Choice) {
        let (held, column) = (
            &mut self.held[choice.row as usize],
            &mut self.columns[choice.column as usize],
        );
        if *held == NONE && column.held == NONE {
            (*held, column.held) = (label, label);
        }
    }

    /// Makes the cheapest chain of changes that gives `start` a choice, and subtracts the number of visited choices
    /// and columns from `steps_left`.
    ///
    /// # Errors
    /// [`StopReason`], if there is no such chain, or the search takes more than `steps_left`.
    #[inline]
    pub fn bring_in<P: Problem>(&mut self, problem: &P, start: u32, steps_left: &mut usize) -> Result<(), StopReason> {
        let (end, end_cost) = self.cheapest_chain(problem, start, steps_left)?;
        let mut vacant = match end {
            ChainEnd::Column(column) => column,
            ChainEnd::Own(row, label) => self.exchange(problem, row, label),
        };
        while vacant != NONE {
            let label = self.columns[vacant as usize].through;
            let column = vacant;
            vacant = self.exchange(problem, problem.choice(label).row, label);
            self.columns[column as usize].held = label;
        }
        self.close_search(end_cost);
        Ok(())
    }

    /// Gives a row another choice, and returns the released column.
    #[inline]
    fn exchange(&mut self, problem: &impl Problem, row: u32, label: u32) -> u32 {
        let held = std::mem::replace(&mut self.held[row as usize], label);
        if held == NONE {
            NONE
        } else {
            problem.choice(held).column
        }
    }

    /// Dijkstra's search from `start` over columns and their holders: the end of the cheapest chain and its cost.
    #[inline]
    fn cheapest_chain<P: Problem>(
        &mut self,
        problem: &P,
        start: u32,
        steps_left: &mut usize,
    ) -> Result<(ChainEnd, f64), StopReason> {
        let (mut row, mut row_cost) = (start, 0.0);
        let mut own: Option<(ChainEnd, f64)> = None;
        loop {
            let mut steps = 0;
            let (columns, frontier) = (&mut self.columns, &mut self.frontier);
            problem.show_choices(row, |label, number, cost| {
                if number == NONE {
                    let cost = row_cost + cost;
                    if own.is_none_or(|(_, least)| cost < least) {
                        own = Some((ChainEnd::Own(row, label), cost));
                    }
                    return;
                }
                steps += 1;
                let column = &mut columns[number as usize];
                let reached = row_cost + cost + column.price;
                if !column.passed && reached < column.reached {
                    if column.through == NONE {
                        column.place = frontier.len() as u32;
                        frontier.push((ordered(reached), number));
                    } else {
                        frontier[column.place as usize].0 = ordered(reached);
                    }
                    (column.reached, column.through) = (reached, label);
                }
            });
            let Some(place) = self.nearest() else {
                return own.ok_or(StopReason::NoChoice);
            };
            *steps_left = steps_left
                .checked_sub(steps + self.frontier.len())
                .ok_or(StopReason::NoSteps)?;
            let (_, number) = self.frontier[place];
            let column = self.columns[number as usize];
            let ends_at_own = |cost: f64| cost < column.reached || P::OWN_FIRST && cost == column.reached;
            if let Some(own) = own.filter(|(_, cost)| ends_at_own(*cost)) {
                return Ok(own);
            }
            if column.held == NONE {
                return Ok((ChainEnd::Column(number), column.reached));
            }
            self.columns[number as usize].passed = true;
            self.passed.push(number);
            self.frontier.swap_remove(place);
            if let Some((_, moved)) = self.frontier.get(place) {
                self.columns[*moved as usize].place = place as u32;
            }
            let held = problem.choice(column.held);
            row = held.row;
            // Cost that the holder saves by releasing the column.
            row_cost = column.reached - column.price - held.cost;
        }
    }

    /// Place in the frontier of the column reached most cheaply; among equal columns, the lowest number.
    #[inline]
    fn nearest(&self) -> Option<usize> {
        let nearest = self.frontier.iter().enumerate().min_by_key(|(_, column)| **column);
        nearest.map(|(place, _)| place)
    }

    /// Raises the price of each passed column by the difference between the costs of the end and of the column, and
    /// clears the search.
    #[inline]
    fn close_search(&mut self, end_cost: f64) {
        for &number in &self.passed {
            let column = &mut self.columns[number as usize];
            column.price += end_cost - column.reached;
            column.forget_search();
        }
        for &(_, number) in &self.frontier {
            self.columns[number as usize].forget_search();
        }
        self.passed.clear();
        self.frontier.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Choices (row, column, cost); of two chains of the same cost, the chain that ends at a row's own choice goes
    /// first.
    struct Listed(Vec<Choice>);

    impl Problem for Listed {
        const OWN_FIRST: bool = true;

        fn show_choices(&self, row: u32, mut each: impl FnMut(u32, u32, f64)) {
            for (label, choice) in (0..).zip(&self.0).filter(|(_, choice)| choice.row == row) {
                each(label, choice.column, choice.cost);
            }
        }

        fn choice(&self, label: u32) -> Choice {
            self.0[label as usize]
        }
    }

    fn listed(choices: &[(u32, u32, f64)]) -> Listed {
        let choice = |&(row, column, cost)| Choice { row, column, cost };
        Listed(choices.iter().map(choice).collect())
    }

    fn bring_in(
        paths: &mut AugmentingPaths,
        problem: &Listed,
        rows: u32,
        mut steps: usize,
    ) -> Result<Vec<u32>, StopReason> {
        (0..rows).try_for_each(|row| paths.bring_in(problem, row, &mut steps))?;
        Ok((0..rows).map(|row| paths.held(row)).collect())
    }

    #[test]
    fn rows_without_a_choice_of_their_own_may_find_none() {
        let both = listed(&[(0, 0, 1.0), (1, 0, 1.0)]);
        let mut paths = AugmentingPaths::new(2, 2);
        assert_eq!(bring_in(&mut paths, &both, 2, usize::MAX), Err(StopReason::NoChoice));
        paths.forget(0..2, 0..2);
        let one_gives_way = listed(&[(0, 0, 1.0), (0, 1, 5.0), (1, 0, 1.0)]);
        assert_eq!(bring_in(&mut paths, &one_gives_way, 2, usize::MAX), Ok(vec![1, 2]));
        paths.forget(0..2, 0..2);
        paths.bar(1);
        assert_eq!(
            bring_in(&mut paths, &one_gives_way, 2, usize::MAX),
            Err(StopReason::NoChoice)
        );
    }

    #[test]
    fn of_equal_chains_the_rows_own_choice_goes_first() {
        let equal = listed(&[(0, 0, 2.0), (0, NONE, 2.0)]);
        assert_eq!(
            bring_in(&mut AugmentingPaths::new(1, 1), &equal, 1, usize::MAX),
            Ok(vec![1])
        );
    }

    #[test]
    fn a_search_ends_when_its_steps_do() {
        // Row 1 visits its choice and the column reached, then the choices of the holder of the column.
        let chain = listed(&[(0, 0, 1.0), (0, 1, 2.0), (1, 0, 1.0)]);
        let needed = 4 + 2 + 3;
        assert!(bring_in(&mut AugmentingPaths::new(2, 2), &chain, 2, needed).is_ok());
        let found = bring_in(&mut AugmentingPaths::new(2, 2), &chain, 2, needed - 1);
        assert_eq!(found, Err(StopReason::NoSteps));
    }
}
