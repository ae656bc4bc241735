//! One-to-one matching of reports with clusters (WA-3).
//!
//! The nearest cluster is wrong where a sensor reports several groups with errors as large as the distances of the
//! groups: two reports then mean the same cluster, and the other cluster has none. All reports of the same observation
//! and arrival are therefore matched together. Each report has at most one cluster, each cluster at most one report,
//! and the sum of the distances is smallest. A report without a cluster adds the range to the sum.
//!
//! Limit: a sensor that reports the targets of an unresolved group singly needs `nearest`, which adds up its reports.

use association::assignment::{Assignment, Pair};

/// Most reports that are matched together; more are matched in several steps.
pub(super) const TOGETHER_MAX: usize = 256;
/// Most clusters that are considered for a report, nearest first.
pub(super) const CLUSTERS_MAX: usize = 16;

settings::words! {
    /// How reports find their clusters.
    pub enum Matching {
        /// Each report means the nearest cluster; reports of the same cluster add up.
        Nearest = "nearest",
        /// Reports of the same observation are matched together: no cluster has two of them.
        OneToOne = "one_to_one",
    }
}

/// Working memory, reused for each observation.
#[derive(Clone, Debug)]
pub(super) struct Matcher {
    assignment: Assignment,
    pairs: Vec<Pair>,
    /// By report of the observation: the matched centre.
    chosen: Vec<Option<u32>>,
    /// By report: the place in the list of reports.
    pub(super) reports: Vec<usize>,
}

impl Matcher {
    pub(super) fn new(clusters_max: usize) -> Self {
        let pairs_max = TOGETHER_MAX * CLUSTERS_MAX;
        Self {
            assignment: Assignment::new(TOGETHER_MAX, clusters_max, pairs_max),
            pairs: Vec::with_capacity(pairs_max),
            chosen: Vec::with_capacity(TOGETHER_MAX),
            reports: Vec::with_capacity(TOGETHER_MAX),
        }
    }

    pub(super) fn clear(&mut self) {
        self.pairs.clear();
        self.reports.clear();
    }

    /// Adds the report in this place of the list, with (centre, distance in metres) of the centres in range.
    pub(super) fn add(&mut self, report: usize, distances_m: impl Iterator<Item = (u32, f64)>) {
        let row = self.reports.len() as u32;
        self.reports.push(report);
        let first = self.pairs.len();
        // Sorted in by distance: the vector must not outgrow the allocated room, nor the order of the search matter.
        for (column, cost) in distances_m {
            let pair = Pair { row, column, cost };
            let nearer = |kept: &Pair| kept.cost.total_cmp(&cost).then(kept.column.cmp(&column)).is_lt();
            let place = first + self.pairs[first..].partition_point(nearer);
            if place == first + CLUSTERS_MAX {
                continue;
            }
            if self.pairs.len() == first + CLUSTERS_MAX {
                self.pairs.pop();
            }
            self.pairs.insert(place, pair);
        }
    }

    /// Matches the added reports with centres that are nearer than `range_m`.
    pub(super) fn solve(&mut self, range_m: f64) {
        self.chosen.clear();
        self.chosen.resize(self.reports.len(), None);
        let chosen = &mut self.chosen;
        self.assignment.solve(&self.pairs, range_m, |row, column, _| {
            chosen[row as usize] = Some(column)
        });
    }

    /// The centre that the report added as number `row` means.
    pub(super) fn chosen(&self, row: usize) -> Option<u32> {
        self.chosen[row]
    }

    /// Whether a report means this centre.
    pub(super) fn is_meant(&self, centre: u32) -> bool {
        self.chosen.contains(&Some(centre))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn matched(distances_m: &[Vec<f64>], range_m: f64) -> Vec<Option<u32>> {
        let mut matcher = Matcher::new(CLUSTERS_MAX);
        matcher.clear();
        for (report, own) in distances_m.iter().enumerate() {
            let in_range = (0..)
                .zip(own.iter().copied())
                .filter(|(_, distance)| *distance < range_m);
            matcher.add(report, in_range);
        }
        matcher.solve(range_m);
        (0..distances_m.len()).map(|row| matcher.chosen(row)).collect()
    }

    #[test]
    fn two_reports_beside_one_cluster_mean_two_clusters() {
        let distances = [vec![400.0, 3000.0], vec![900.0, 1200.0]];
        assert_eq!(matched(&distances, 5000.0), [Some(0), Some(1)]);
        assert_eq!(
            matched(&distances, 1000.0),
            [Some(0), None],
            "the other one is out of range"
        );
    }

    #[test]
    fn of_many_clusters_the_nearest_are_considered() {
        let mut matcher = Matcher::new(100);
        matcher.clear();
        matcher.add(0, (0..100).map(|centre| (centre, f64::from(200 - centre))));
        assert_eq!(matcher.pairs.len(), CLUSTERS_MAX);
        matcher.solve(5000.0);
        assert_eq!(matcher.chosen(0), Some(99));
        assert!(matcher.is_meant(99) && !matcher.is_meant(98));
    }

    /// Sum of the distances of a matching, where a report without a cluster adds the range.
    fn cost(distances_m: &[Vec<f64>], chosen: &[Option<u32>], range_m: f64) -> f64 {
        let of = |(own, chosen): (&Vec<f64>, &Option<u32>)| chosen.map_or(range_m, |centre| own[centre as usize]);
        distances_m.iter().zip(chosen).map(of).sum()
    }

    proptest! {
        #[test]
        fn no_cluster_has_two_reports_and_no_exchange_is_better(
            distances in prop::collection::vec(prop::collection::vec(1.0..6e3f64, 4), 1..5),
        ) {
            let range_m = 5e3;
            let found = matched(&distances, range_m);
            for (row, centre) in found.iter().enumerate() {
                prop_assert!(centre.is_none() || !found[..row].contains(centre));
                prop_assert!(centre.is_none_or(|centre| distances[row][centre as usize] < range_m));
            }
            let least = cost(&distances, &found, range_m);
            // Every matching, as digits to the base of the number of clusters plus 1.
            for number in 0..5_u32.pow(distances.len() as u32) {
                let digit = |row: usize| number / 5_u32.pow(row as u32) % 5;
                let other: Vec<_> = (0..distances.len()).map(|row| digit(row).checked_sub(1)).collect();
                let is_valid = other.iter().enumerate().all(|(row, centre)| {
                    centre.is_none_or(|at| distances[row][at as usize] < range_m) && (centre.is_none() || !other[..row].contains(centre))
                });
                prop_assert!(!is_valid || cost(&distances, &other, range_m) >= least - 1e-6);
            }
        }
    }
}
