//! Distance between two sets of points of possibly different sizes.
//!
//! A picture without one good track and a picture with an additional bad track are both wrong, in different ways.
//! The mean error of the existing tracks rewards omitting tracks. A distance between sets must therefore charge
//! missing and surplus tracks as well. GOSPA (Rahmathullah, García-Fernández and Svensson, *Generalized optimal
//! sub-pattern assignment metric*, 2017, here with alpha = 2) pairs targets with tracks at a cost of distance^p,
//! charges cut_off^p / 2 for each unpaired target or track, and takes the p-th root of the least possible sum. It
//! is a metric: zero only for equal sets, symmetric, and subject to the triangle inequality. Its sum splits into
//! the contributions of localisation, missed targets and false tracks.
//!
//! OSPA (Schuhmacher, Vo and Vo, *A consistent metric for performance evaluation of multi-object filters*, 2008)
//! divides by the size of the larger set, and so gives an error per target. The same pairs minimise both.

use crate::assignment::{CandidatePair, best_pairs};
use crate::near::{PointPair, near_pairs};

/// Parameters of the metric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metric {
    /// Distance from which a track does not belong to a target, metres; positive.
    pub cut_off_m: f64,
    /// Exponent p: 1 or more. A greater value gives outliers more weight.
    pub power: i32,
}

/// Distance between two sets of points, with its parts.
#[derive(Clone, Debug, PartialEq)]
pub struct SetDistance {
    /// Targets and their tracks, all nearer than the cut-off.
    pub pairs: Vec<PointPair>,
    /// Targets without a track.
    pub missed: usize,
    /// Tracks without a target.
    pub false_tracks: usize,
    metric: Metric,
}

impl Metric {
    /// Compares the positions of targets with those of tracks, metres.
    pub fn compare<const D: usize>(&self, targets: &[[f64; D]], tracks: &[[f64; D]]) -> SetDistance {
        let near = near_pairs(targets, tracks, self.cut_off_m);
        let alone = self.of(self.cut_off_m);
        let candidates: Vec<CandidatePair> = near
            .iter()
            .map(|pair| CandidatePair {
                row: pair.target,
                column: pair.track,
                gain: alone - self.of(pair.distance_m),
            })
            .collect();
        let chosen = best_pairs(targets.len(), tracks.len(), &candidates);
        let mut pairs = near;
        pairs.retain(|pair| chosen[pair.target] == Some(pair.track));
        SetDistance {
            missed: targets.len() - pairs.len(),
            false_tracks: tracks.len() - pairs.len(),
            pairs,
            metric: *self,
        }
    }

    fn of(&self, distance_m: f64) -> f64 {
        distance_m.powi(self.power)
    }

    fn root(&self, sum: f64) -> f64 {
        match self.power {
            2 => sum.sqrt(),
            power => sum.powf(1.0 / f64::from(power)),
        }
    }
}

impl SetDistance {
    /// Returns the total distance, metres.
    pub fn gospa_m(&self) -> f64 {
        self.metric
            .root(self.localisation() + self.alone(self.missed) + self.alone(self.false_tracks))
    }

    /// Returns the part due to the pairs' distances, metres.
    pub fn localisation_m(&self) -> f64 {
        self.metric.root(self.localisation())
    }

    /// Returns the part due to missed targets, metres.
    pub fn missed_m(&self) -> f64 {
        self.metric.root(self.alone(self.missed))
    }

    /// Returns the part due to false tracks, metres.
    pub fn false_m(&self) -> f64 {
        self.metric.root(self.alone(self.false_tracks))
    }

    /// Returns OSPA, metres; 0 between empty sets.
    pub fn ospa_m(&self) -> f64 {
        let alone = self.missed.max(self.false_tracks);
        let size = (self.pairs.len() + alone) as f64;
        if size == 0.0 {
            return 0.0;
        }
        let cut_off = self.metric.of(self.metric.cut_off_m);
        self.metric.root((self.localisation() + cut_off * alone as f64) / size)
    }

    fn localisation(&self) -> f64 {
        self.pairs.iter().map(|pair| self.metric.of(pair.distance_m)).sum()
    }

    fn alone(&self, count: usize) -> f64 {
        self.metric.of(self.metric.cut_off_m) * count as f64 / 2.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn line(places: impl IntoIterator<Item = f64>) -> Vec<[f64; 1]> {
        places.into_iter().map(|place| [place]).collect()
    }

    fn metric(power: i32) -> Metric {
        Metric { cut_off_m: 10.0, power }
    }

    fn close(found: f64, expected: f64) {
        assert!(
            (found - expected).abs() < 1e-12 * (1.0 + expected.abs()),
            "{found}, not {expected}"
        );
    }

    /// Five targets 1 m apart, their tracks shifted: published for p = 1.
    #[test]
    fn shifted_tracks() {
        let targets = || line((0..5).map(f64::from));
        let shifted = |by: f64| line((0..5).map(|place| f64::from(place) + by));
        let half = metric(1).compare(&targets(), &shifted(0.5));
        close(half.gospa_m(), 2.5);
        close(half.ospa_m(), 0.5);
        close(metric(1).compare(&targets(), &shifted(1.0)).gospa_m(), 5.0);
        // With p = 2: the root of 5 times 0.25; the root of 5.
        close(metric(2).compare(&targets(), &shifted(0.5)).gospa_m(), 1.25f64.sqrt());
        close(metric(2).compare(&targets(), &shifted(1.0)).gospa_m(), 5f64.sqrt());
    }

    /// Targets at 0, 20 and 100; tracks at 3, 16 and 1000: 9 + 16 for the pairs, 50 for each unpaired point.
    #[test]
    fn the_parts_add_up() {
        let found = metric(2).compare(&line([0.0, 20.0, 100.0]), &line([3.0, 16.0, 1000.0]));
        assert_eq!((found.pairs.len(), found.missed, found.false_tracks), (2, 1, 1));
        close(found.localisation_m(), 5.0);
        close(found.missed_m(), 50f64.sqrt());
        close(found.false_m(), 50f64.sqrt());
        close(found.gospa_m(), 125f64.sqrt());
        // (9 + 16 + 100) / 3.
        close(found.ospa_m(), (125.0f64 / 3.0).sqrt());
    }

    /// Two tracks between two targets: both tracks have the same nearest target.
    #[test]
    fn pairs_are_best_together() {
        let found = metric(2).compare(&line([0.0, 6.0]), &line([4.0, 7.0]));
        let pairs: Vec<_> = found.pairs.iter().map(|pair| (pair.target, pair.track)).collect();
        assert_eq!(pairs, [(0, 0), (1, 1)]);
        close(found.gospa_m(), 17f64.sqrt());
    }

    #[test]
    fn empty_sets() {
        let nothing = metric(2).compare::<2>(&[], &[]);
        assert_eq!((nothing.gospa_m(), nothing.ospa_m()), (0.0, 0.0));
        let missed = metric(2).compare(&[[0.0, 0.0]; 3], &[]);
        close(missed.gospa_m(), 150f64.sqrt());
        assert_eq!((missed.gospa_m(), missed.ospa_m()), (missed.missed_m(), 10.0));
    }

    #[test]
    fn the_cut_off_itself_is_too_far() {
        let found = metric(2).compare(&line([0.0]), &line([10.0]));
        assert!(found.pairs.is_empty());
        close(found.gospa_m(), 10.0);
    }

    /// Returns the least sum over all pairings, by exhaustive search.
    fn least(targets: &[[f64; 2]], tracks: &mut Vec<[f64; 2]>, metric: Metric) -> f64 {
        let half = metric.of(metric.cut_off_m) / 2.0;
        let Some((first, rest)) = targets.split_first() else {
            return half * tracks.len() as f64;
        };
        let mut best = half + least(rest, tracks, metric);
        for place in 0..tracks.len() {
            let track = tracks.remove(place);
            let cost = metric.of(crate::near::distance(first, &track));
            best = best.min(cost + least(rest, tracks, metric));
            tracks.insert(place, track);
        }
        best
    }

    fn points() -> impl Strategy<Value = Vec<[f64; 2]>> {
        prop::collection::vec(prop::array::uniform2(-12.0..12.0f64), 0..6)
    }

    proptest! {
        #[test]
        fn no_other_pairing_costs_less(targets in points(), mut tracks in points(), power in 1..4i32) {
            let found = metric(power).compare(&targets, &tracks);
            let least = metric(power).root(least(&targets, &mut tracks, metric(power)));
            prop_assert!((found.gospa_m() - least).abs() < 1e-9, "{} {}", found.gospa_m(), least);
        }

        #[test]
        fn a_set_is_at_no_distance_from_itself_in_any_order(set in points(), turn in 0usize..6, power in 1..4i32) {
            let mut turned = set.clone();
            turned.rotate_left(turn.min(set.len()));
            let found = metric(power).compare(&set, &turned);
            prop_assert_eq!(found.gospa_m(), 0.0);
            prop_assert_eq!(found.ospa_m(), 0.0);
        }

        #[test]
        fn different_sets_are_at_some_distance(a in points(), b in points(), power in 1..4i32) {
            prop_assume!(a != b);
            prop_assert!(metric(power).compare(&a, &b).gospa_m() > 0.0);
        }

        #[test]
        fn there_is_as_far_as_back(a in points(), b in points(), power in 1..4i32) {
            let (there, back) = (metric(power).compare(&a, &b), metric(power).compare(&b, &a));
            prop_assert!((there.gospa_m() - back.gospa_m()).abs() < 1e-9);
            prop_assert!((there.ospa_m() - back.ospa_m()).abs() < 1e-9);
            prop_assert_eq!((there.missed, there.false_tracks), (back.false_tracks, back.missed));
        }

        #[test]
        fn no_detour_is_shorter(a in points(), b in points(), c in points(), power in 1..4i32) {
            let metric = metric(power);
            let legs = [metric.compare(&a, &b), metric.compare(&b, &c)];
            let direct = metric.compare(&a, &c);
            prop_assert!(direct.gospa_m() <= legs[0].gospa_m() + legs[1].gospa_m() + 1e-9);
            prop_assert!(direct.ospa_m() <= legs[0].ospa_m() + legs[1].ospa_m() + 1e-9);
        }

        #[test]
        fn the_order_of_the_points_does_not_matter(
            (a, shuffled) in points().prop_flat_map(|set| (Just(set.clone()), Just(set).prop_shuffle())),
            b in points(),
        ) {
            let (one, other) = (metric(2).compare(&a, &b), metric(2).compare(&shuffled, &b));
            prop_assert!((one.gospa_m() - other.gospa_m()).abs() < 1e-9);
            prop_assert_eq!((one.missed, one.false_tracks), (other.missed, other.false_tracks));
        }
    }
}
