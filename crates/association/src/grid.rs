//! Neighbourhood search in a plane, without allocation.
//!
//! The plane is cut into square cells; each cell has a doubly linked list of its items, and a hash table of fixed size
//! finds the cells. Items are small integers (table slots), so the lists are arrays. A move of an item costs a few
//! writes, and only when the item has left its cell; a search visits the cells touched by its square. Several cells
//! may share a table entry: the stored cell distinguishes their items.

use serde::{Deserialize, Serialize};

/// Cell coordinates.
type GridCell = (i32, i32);

const NONE: u32 = u32::MAX;

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct CellLink {
    next: u32,
    previous: u32,
    cell: GridCell,
    present: bool,
}

/// Returns the largest whole number not above `value`, as an index of cells. Far-away places share the outermost cells
/// instead of wrapping round. `f64::floor` is a call if the processor need not have an instruction for the operation.
#[inline]
pub fn floor(value: f64) -> i32 {
    let whole = value as i32;
    whole.saturating_sub(i32::from(f64::from(whole) > value))
}

/// Items `0..capacity` at places in the plane.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Grid {
    cell_m: f64,
    heads: Vec<u32>,
    links: Vec<CellLink>,
}

impl Grid {
    /// An empty grid for items `0..capacity`, with cells of `cell_m` metres.
    ///
    /// # Panics
    /// If `cell_m` is not positive or `capacity` exceeds `u32::MAX - 1`; both come from checked configuration.
    pub fn new(cell_m: f64, capacity: usize) -> Self {
        assert!(cell_m > 0.0 && capacity < NONE as usize);
        let absent = CellLink {
            next: NONE,
            previous: NONE,
            cell: (0, 0),
            present: false,
        };
        Self {
            cell_m,
            heads: vec![NONE; (2 * capacity.max(8)).next_power_of_two()],
            links: vec![absent; capacity],
        }
    }

    /// Puts or moves `item` to (x, y), metres.
    pub fn place(&mut self, item: u32, x: f64, y: f64) {
        let cell = self.cell(x, y);
        let link = self.links[item as usize];
        if link.present {
            if link.cell == cell {
                return;
            }
            self.remove(item);
        }
        let entry = self.entry(cell);
        let head = self.heads[entry];
        self.links[item as usize] = CellLink {
            next: head,
            previous: NONE,
            cell,
            present: true,
        };
        if head != NONE {
            self.links[head as usize].previous = item;
        }
        self.heads[entry] = item;
    }

    /// Removes `item`; no effect if the grid does not contain the item.
    pub fn remove(&mut self, item: u32) {
        let link = self.links[item as usize];
        if !link.present {
            return;
        }
        if link.next != NONE {
            self.links[link.next as usize].previous = link.previous;
        }
        if link.previous == NONE {
            let entry = self.entry(link.cell);
            self.heads[entry] = link.next;
        } else {
            self.links[link.previous as usize].next = link.next;
        }
        self.links[item as usize].present = false;
    }

    /// Calls `visit` for every item in a cell touched by the square of half-width `reach_m` around (x, y).
    ///
    /// The order depends on the history of placements, so callers must choose by value, not by order. The square is at
    /// most `cells_max` cells wide: a larger reach is cut, so that an absurd accuracy cannot stall the rest.
    pub fn near(&self, x: f64, y: f64, reach_m: f64, cells_max: i32, mut visit: impl FnMut(u32)) {
        let reach_m = reach_m.min(0.5 * f64::from(cells_max) * self.cell_m);
        let (low, high) = (self.cell(x - reach_m, y - reach_m), self.cell(x + reach_m, y + reach_m));
        for column in low.0..=high.0 {
            for row in low.1..=high.1 {
                let mut item = self.heads[self.entry((column, row))];
                while item != NONE {
                    let link = &self.links[item as usize];
                    if link.cell == (column, row) {
                        visit(item);
                    }
                    item = link.next;
                }
            }
        }
    }

    fn cell(&self, x: f64, y: f64) -> GridCell {
        (floor(x / self.cell_m), floor(y / self.cell_m))
    }

    fn entry(&self, (column, row): GridCell) -> usize {
        let mixed = (column as u32).wrapping_mul(0x9e37_79b1) ^ (row as u32).wrapping_mul(0x85eb_ca77);
        (mixed ^ (mixed >> 15)) as usize & (self.heads.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn near(grid: &Grid, x: f64, y: f64, reach: f64) -> Vec<u32> {
        let mut found = Vec::new();
        grid.near(x, y, reach, 1000, |item| found.push(item));
        found.sort_unstable();
        found
    }

    #[test]
    fn floors_are_those_of_the_library_and_saturate() {
        for value in [
            0.0,
            -0.0,
            0.5,
            -0.5,
            1.0,
            -1.0,
            2e9,
            -2e9,
            2147483647.5,
            -2147483648.5,
            1e300,
            -1e300,
            f64::NAN,
        ] {
            assert_eq!(floor(value), value.floor() as i32, "{value}");
        }
    }

    #[test]
    fn an_item_is_found_where_it_is_and_only_there() {
        let mut grid = Grid::new(100.0, 4);
        grid.place(0, 10.0, 10.0);
        grid.place(1, 5000.0, 10.0);
        assert_eq!(near(&grid, 0.0, 0.0, 50.0), [0]);
        grid.place(0, 5050.0, 10.0);
        assert_eq!(near(&grid, 0.0, 0.0, 50.0), []);
        assert_eq!(near(&grid, 5020.0, 0.0, 50.0), [0, 1]);
        grid.remove(0);
        grid.remove(0);
        assert_eq!(near(&grid, 5020.0, 0.0, 50.0), [1]);
    }

    proptest! {
        #[test]
        fn a_search_misses_nothing_within_reach_and_finds_nothing_removed(
            moves in prop::collection::vec((0u32..40, -2e3..2e3f64, -2e3..2e3f64, prop::bool::weighted(0.2)), 1..300),
            x in -2e3..2e3f64, y in -2e3..2e3f64, reach in 1.0..500.0f64,
        ) {
            let mut grid = Grid::new(100.0, 40);
            let mut places = [None; 40];
            for (item, px, py, remove) in moves {
                if remove {
                    grid.remove(item);
                    places[item as usize] = None;
                } else {
                    grid.place(item, px, py);
                    places[item as usize] = Some((px, py));
                }
            }
            let found = near(&grid, x, y, reach);
            for (item, place) in places.iter().enumerate() {
                let inside = place.is_some_and(|(px, py): (f64, f64)| (px - x).abs() <= reach && (py - y).abs() <= reach);
                if inside {
                    prop_assert!(found.contains(&(item as u32)));
                }
                if place.is_none() {
                    prop_assert!(!found.contains(&(item as u32)));
                }
            }
            let mut unique = found.clone();
            unique.dedup();
            prop_assert_eq!(unique, found);
        }
    }
}
