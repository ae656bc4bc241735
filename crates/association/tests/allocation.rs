//! After its construction the assignment allocates nothing, whatever it is given (PL-4).

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use association::assignment::{Assignment, Outcome, Pair};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn an_assignment_allocates_nothing_once_built() {
    let (rows_max, columns_max, pairs_max) = (3000, 2001, 6000);
    let mut noise = 1u64;
    let mut random = |below: usize| {
        noise ^= noise << 13;
        noise ^= noise >> 7;
        noise ^= noise << 17;
        (noise >> 16) as usize % below
    };
    // Sparse scans and crowded ones, some with unknown labels, some too large.
    let mut scans: Vec<Vec<Pair>> = (0..60)
        .map(|scan| {
            let mut pair = || Pair {
                row: random(rows_max + 1) as u32,
                column: random(columns_max + 1) as u32,
                cost: random(1000) as f64,
            };
            (0..150 * scan).map(|_| pair()).collect()
        })
        .collect();
    // One that takes too many steps: each late row looks through all of the line for a free column, in vain.
    let pair = |(row, column, cost)| Pair { row, column, cost };
    let line = (0..2000).flat_map(|row| [(row, row, 0.0), (row, (row + 1).min(1999), 0.0)]);
    let late = (2000..3000).map(|row| (row, 0, 1.0));
    scans.push(line.chain(late).map(pair).collect());
    let mut assignment = Assignment::new(rows_max, columns_max, pairs_max);
    let mut sum = Outcome::default();
    assert_no_alloc(|| {
        for scan in &scans {
            let outcome = assignment.solve(scan, 900.0, |_, _, _| {});
            sum.assigned += outcome.assigned;
            sum.greedy_components += outcome.greedy_components;
            sum.ignored_pairs += outcome.ignored_pairs;
        }
    });
    assert!(
        sum.assigned > 0 && sum.greedy_components > 0 && sum.ignored_pairs > 0,
        "{sum:?}"
    );
}
