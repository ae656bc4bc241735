//! Groups of points connected by chains of near neighbours.
//!
//! The shortest of all near pairs come first, and only pairs that join separate groups count: the links form a
//! minimum spanning tree. Four points in a line thus have three links, and each link can break separately.

/// Groups `points` (east and north, metres). Two points are near if their eastward distance is at most `reach_m`
/// and `apart` returns less than 1. A link between near points breaks if `breaks` returns true.
///
/// The result holds, for each point, the smallest index in its group: its own index if the point is alone or the
/// first.
pub(crate) fn groups(
    points: &[[f64; 2]],
    reach_m: f64,
    apart: impl Fn(usize, usize) -> f64,
    breaks: impl Fn(usize, usize) -> bool,
) -> Vec<usize> {
    let mut by_east: Vec<usize> = (0..points.len()).collect();
    by_east.sort_by(|&one, &other| points[one][0].total_cmp(&points[other][0]).then(one.cmp(&other)));
    let mut links: Vec<(f64, usize, usize)> = Vec::new();
    for (place, &one) in by_east.iter().enumerate() {
        for &other in &by_east[place + 1..] {
            if points[other][0] - points[one][0] > reach_m {
                break;
            }
            let (first, second) = (one.min(other), one.max(other));
            let distance = apart(first, second);
            if distance < 1.0 {
                links.push((distance, first, second));
            }
        }
    }
    links.sort_by(|one, other| one.0.total_cmp(&other.0).then((one.1, one.2).cmp(&(other.1, other.2))));
    let [mut reached, mut joined] = [Sets::new(points.len()), Sets::new(points.len())];
    for (_, first, second) in links {
        if reached.join(first, second) && !breaks(first, second) {
            joined.join(first, second);
        }
    }
    (0..points.len()).map(|place| joined.first(place)).collect()
}

/// Disjoint sets of numbers; each number points to a smaller number of its set, or to itself.
struct Sets(Vec<usize>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// Returns the smallest number of the set.
    fn first(&mut self, of: usize) -> usize {
        let mut at = of;
        while self.0[at] != at {
            // Path halving: each step shortens the path for later searches.
            self.0[at] = self.0[self.0[at]];
            at = self.0[at];
        }
        at
    }

    /// Joins two sets; returns whether they were separate before.
    fn join(&mut self, one: usize, other: usize) -> bool {
        let (one, other) = (self.first(one), self.first(other));
        self.0[one.max(other)] = one.min(other);
        one != other
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn within(points: &[[f64; 2]], reach_m: f64) -> impl Fn(usize, usize) -> f64 {
        move |one, other| (points[one][0] - points[other][0]).hypot(points[one][1] - points[other][1]) / reach_m
    }

    /// Three points in a line and a point beside: the middle link breaks alone, and no longer link replaces that
    /// link.
    #[test]
    fn links_break_one_by_one() {
        let points = [[0.0, 0.0], [100.0, 0.0], [190.0, 0.0], [0.0, 900.0]];
        let all = groups(&points, 300.0, within(&points, 300.0), |_, _| false);
        assert_eq!(all, [0, 0, 0, 3]);
        let broken = groups(&points, 300.0, within(&points, 300.0), |one, other| {
            (one, other) == (0, 1)
        });
        assert_eq!(broken, [0, 1, 1, 3]);
    }

    proptest! {
        /// The result equals a search along every chain of near points.
        #[test]
        fn chains_are_followed(points in prop::collection::vec([0.0..1000.0f64, 0.0..1000.0f64], 0..40), reach in 1.0..300.0f64) {
            let apart = within(&points, reach);
            let found = groups(&points, reach, &apart, |_, _| false);
            let mut expected: Vec<usize> = (0..points.len()).collect();
            for _ in 0..points.len() {
                for one in 0..points.len() {
                    for other in 0..points.len() {
                        if apart(one, other) < 1.0 {
                            let least = expected[one].min(expected[other]);
                            (expected[one], expected[other]) = (least, least);
                        }
                    }
                }
            }
            prop_assert_eq!(found, expected);
        }
    }
}
