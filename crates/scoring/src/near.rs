//! Pairs of near points from two sets.
//!
//! One set is sorted by the first coordinate; for each point of the other set, the search covers only a strip. A
//! coordinate other than the first may be NaN, not known: a pair is then compared in the others.

/// Point of each set, and their distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointPair {
    /// Place in the first set: of the target.
    pub target: usize,
    /// Place in the second set: of the track.
    pub track: usize,
    /// Distance, metres.
    pub distance_m: f64,
}

/// Returns every pair nearer than `reach_m` metres, in the order of the targets.
pub(crate) fn near_pairs<const D: usize>(targets: &[[f64; D]], tracks: &[[f64; D]], reach_m: f64) -> Vec<PointPair> {
    let mut sorted: Vec<(f64, usize)> = tracks.iter().map(|track| track[0]).zip(0..).collect();
    sorted.sort_unstable_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
    let mut pairs = Vec::new();
    for (target, place) in targets.iter().enumerate() {
        // A sum may be rounded; the strip must not be narrower than the reach because of it.
        let (low, high) = ((place[0] - reach_m).next_down(), (place[0] + reach_m).next_up());
        let begin = sorted.partition_point(|(first, _)| *first < low);
        let strip = sorted[begin..].iter().take_while(|(first, _)| *first <= high);
        for &(_, track) in strip {
            let distance_m = distance(place, &tracks[track]);
            if distance_m < reach_m {
                pairs.push(PointPair {
                    target,
                    track,
                    distance_m,
                });
            }
        }
    }
    pairs
}

/// Returns the distance of two points in the coordinates that both have.
pub(crate) fn distance<const D: usize>(one: &[f64; D], other: &[f64; D]) -> f64 {
    let squares = one.iter().zip(other).map(|(one, other)| (one - other) * (one - other));
    squares.filter(|square| !square.is_nan()).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn what_is_near_is_found_and_nothing_else(
            targets in prop::collection::vec(prop::array::uniform3(-50.0..50.0f64), 0..30),
            tracks in prop::collection::vec(prop::array::uniform3(-50.0..50.0f64), 0..30),
            reach_m in 0.1..80.0f64,
        ) {
            let mut found: Vec<(usize, usize)> =
                near_pairs(&targets, &tracks, reach_m).iter().map(|pair| (pair.target, pair.track)).collect();
            found.sort_unstable();
            let mut expected = Vec::new();
            for (target, one) in targets.iter().enumerate() {
                for (track, other) in tracks.iter().enumerate() {
                    if distance(one, other) < reach_m {
                        expected.push((target, track));
                    }
                }
            }
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn the_reach_itself_is_out_of_reach() {
        assert!(near_pairs(&[[0.0, 0.0]], &[[3.0, 4.0]], 5.0).is_empty());
        let [pair] = near_pairs(&[[0.0, 0.0]], &[[3.0, 4.0]], 5.1)[..] else {
            panic!("one pair")
        };
        assert_eq!((pair.target, pair.track, pair.distance_m), (0, 0, 5.0));
    }
}
