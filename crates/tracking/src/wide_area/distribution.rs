//! A report's number of targets shared among several clusters (WA-5).
//!
//! If a coarse position fits several clusters, the nearest cluster may be the wrong choice. Then the number is shared
//! among all clusters within a range, by closeness: the weights are inverse distances, optionally combined with the
//! tracks already in a cluster. Whole shares are rounded to the correct sum (largest remainders); optionally the sum
//! may exceed the reported number, so that no cluster is left without a share.
//!
//! Source: patent JP4702010B2, embodiment 2.

/// Distances below this count as this much, metres: a coarse position is not exact by chance.
const DISTANCE_MIN_M: f64 = 1.0;

settings::settings! {
    /// Sharing of a number among clusters, by default as in the source's example.
    #[derive(Copy)]
    pub struct Sharing {
        /// Only whole targets.
        whole: bool = true;
        /// A cluster's weight is also proportional to the number of its tracks (at least 1).
        by_tracks: bool = false;
        /// Sum of the shares, as a multiple of the reported number.
        excess: f64 = 1.0, in [1, 100];
        /// Distance within which reports with the same time of observation count as one group at their mean position.
        /// Other reports are shared separately, and the shares of a cluster are added.
        group_m: Option<f64> = None, in [1e-3, 1e7];
    }
}

/// Writes to `shares` each cluster's share of `targets`; `clusters` holds (distance in metres, expected tracks).
/// Clusters at or beyond `range_m` get nothing.
pub fn share(
    targets: f64,
    clusters: impl Iterator<Item = (f64, f64)>,
    range_m: f64,
    sharing: &Sharing,
    shares: &mut Vec<f64>,
) {
    shares.clear();
    let weight = |(distance_m, tracks): (f64, f64)| {
        // Written so that NaN gets nothing.
        if distance_m < range_m {
            let by_tracks = if sharing.by_tracks { tracks.max(1.0) } else { 1.0 };
            by_tracks / distance_m.max(DISTANCE_MIN_M)
        } else {
            0.0
        }
    };
    shares.extend(clusters.map(weight));
    let sum: f64 = shares.iter().sum();
    if sum <= 0.0 {
        return;
    }
    let total = targets * sharing.excess;
    shares.iter_mut().for_each(|share| *share *= total / sum);
    if sharing.whole {
        round(shares, total.round());
    }
}

/// Largest remainders: every cluster gets the integer part, and the rest goes to the largest fractions; the first of
/// equals wins.
fn round(shares: &mut [f64], total: f64) {
    // Rounding errors of 1.999… are no loss.
    let floor = |share: f64| (share + 1e-9).floor();
    let whole: f64 = shares.iter().map(|share| floor(*share)).sum();
    let left = (total - whole).max(0.0) as usize;
    for _ in 0..left.min(shares.len()) {
        let lost = |share: f64| share - floor(share);
        let (mut most, mut place) = (1e-9, None);
        for (number, share) in shares.iter().enumerate() {
            if lost(*share) > most {
                (most, place) = (lost(*share), Some(number));
            }
        }
        let Some(place) = place else { break };
        shares[place] = floor(shares[place]) + 1.0;
    }
    shares.iter_mut().for_each(|share| *share = floor(*share));
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn shared(targets: f64, clusters: &[(f64, f64)], sharing: Sharing) -> Vec<f64> {
        let mut shares = Vec::new();
        share(targets, clusters.iter().copied(), 10e3, &sharing, &mut shares);
        shares
    }

    #[test]
    fn the_worked_check() {
        let clusters = [(1e3, 1.0), (1e3, 1.0), (2e3, 1.0)];
        assert_eq!(shared(5.0, &clusters, Sharing::default()), [2.0, 2.0, 1.0]);
        let fractions = Sharing {
            whole: false,
            ..Sharing::default()
        };
        for (found, expected) in shared(4.0, &clusters, fractions).iter().zip([1.6, 1.6, 0.8]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn what_the_source_varies() {
        let clusters = [(1e3, 1.0), (1e3, 1.0), (2e3, 1.0)];
        let excess = Sharing {
            excess: 1.2,
            ..Sharing::default()
        };
        assert_eq!(
            shared(5.0, &clusters, excess),
            [3.0, 2.0, 1.0],
            "more than was reported"
        );
        let by_tracks = Sharing {
            by_tracks: true,
            ..Sharing::default()
        };
        let crowded = [(1e3, 1.0), (1e3, 0.2), (2e3, 6.0)];
        assert_eq!(shared(5.0, &crowded, by_tracks), [1.0, 1.0, 3.0]);
    }

    #[test]
    fn out_of_range_and_at_the_place_itself() {
        assert_eq!(
            shared(3.0, &[(10e3, 1.0), (f64::NAN, 1.0)], Sharing::default()),
            [0.0, 0.0]
        );
        assert_eq!(shared(3.0, &[(0.0, 1.0), (5e3, 1.0)], Sharing::default()), [3.0, 0.0]);
        assert!(shared(3.0, &[], Sharing::default()).is_empty());
        assert_eq!(shared(0.0, &[(5.0, 1.0)], Sharing::default()), [0.0]);
    }

    proptest! {
        #[test]
        fn shares_sum_up_and_nearer_clusters_get_no_less(
            targets in 0..300u32,
            distances in prop::collection::vec(0.0..12e3f64, 1..20),
            whole: bool,
        ) {
            let clusters: Vec<_> = distances.iter().map(|distance| (*distance, 1.0)).collect();
            let shares = shared(f64::from(targets), &clusters, Sharing { whole, ..Sharing::default() });
            let sum: f64 = shares.iter().sum();
            let any = distances.iter().any(|distance| *distance < 10e3);
            let expected = if any { f64::from(targets) } else { 0.0 };
            prop_assert!((sum - expected).abs() < 1e-6);
            for (one, near) in shares.iter().zip(&distances) {
                prop_assert!(!whole || one.fract() == 0.0);
                for (other, far) in shares.iter().zip(&distances) {
                    prop_assert!(near >= far || *one >= *other - 1e-9, "{near} {one} {far} {other}");
                }
            }
        }
    }
}
