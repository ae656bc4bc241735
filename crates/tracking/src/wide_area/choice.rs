//! Choice of the cluster for a wide-area report (WA-3).
//!
//! The report is coarse and late. So nothing is gated: of each cluster only the centre is taken, the mean of the track
//! positions with the reliabilities as weights. The centres are moved along the velocities to the time of observation.
//! The nearest cluster is meant, unless even this cluster is too far away.
//!
//! Limit: a false detection that happens to be nearer is a cluster, too. `tracks_min` of
//! [`SupportSettings`](super::settings::SupportSettings) passes over clusters in which hardly a track is believed.

use messages::AXES;

/// Tracks of a cluster, as far as the choice is concerned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Centre {
    /// Position east, north, up at a reference time, metres.
    pub position_m: [f64; AXES],
    /// Velocity, metres per second.
    pub velocity_mps: [f64; AXES],
    /// Expected number of tracks: sum of the reliabilities.
    pub tracks: f64,
}

impl Centre {
    /// Centre of tracks with (position, velocity, reliability), all at the reference time; `None` where nothing is
    /// reliable.
    pub fn of(tracks: impl Iterator<Item = ([f64; AXES], [f64; AXES], f64)>) -> Option<Self> {
        let mut sum = Self::default();
        for (position_m, velocity_mps, reliability) in tracks {
            for axis in 0..AXES {
                sum.position_m[axis] += reliability * position_m[axis];
                sum.velocity_mps[axis] += reliability * velocity_mps[axis];
            }
            sum.tracks += reliability;
        }
        let mean = |sums: [f64; AXES]| sums.map(|value| value / sum.tracks);
        (sum.tracks > 0.0).then(|| Self {
            position_m: mean(sum.position_m),
            velocity_mps: mean(sum.velocity_mps),
            tracks: sum.tracks,
        })
    }

    /// Distance in the plane from `place_m`, `seconds` after the reference time, metres. Coarse sensors do not see
    /// heights.
    pub fn distance_m(&self, place_m: [f64; AXES], seconds: f64) -> f64 {
        let away = |axis: usize| self.position_m[axis] + self.velocity_mps[axis] * seconds - place_m[axis];
        length(away(0), away(1))
    }

    /// Speed in the plane, metres per second.
    pub(crate) fn speed_mps(&self) -> f64 {
        length(self.velocity_mps[0], self.velocity_mps[1])
    }
}

/// Distances here are too small for squares to overflow, so the slower `hypot` is not needed.
fn length(east: f64, north: f64) -> f64 {
    (east * east + north * north).sqrt()
}

/// The number, of (number, distance), with the smallest distance below `threshold_m`, the smallest number among equal
/// distances; `None` if all distances are at or beyond the threshold.
pub fn nearest(distances_m: impl Iterator<Item = (usize, f64)>, threshold_m: f64) -> Option<usize> {
    let below = distances_m.filter(|(_, distance)| *distance < threshold_m);
    let least = below.min_by(|one, other| one.1.total_cmp(&other.1).then(one.0.cmp(&other.0)));
    least.map(|(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reliabilities_are_the_weights_and_velocities_are_followed() {
        let centre = Centre::of(
            [
                ([0.0, 0.0, 0.0], [10.0, 0.0, 0.0], 0.9),
                ([300.0, 0.0, 0.0], [10.0, -30.0, 0.0], 0.3),
            ]
            .into_iter(),
        )
        .unwrap();
        assert!((centre.position_m[0] - 75.0).abs() < 1e-9 && (centre.tracks - 1.2).abs() < 1e-12);
        assert!((centre.velocity_mps[1] + 7.5).abs() < 1e-12);
        // Eight seconds before, the centre was 80 m further west and 60 m further north.
        assert!((centre.distance_m([-5.0, 60.0, 9e3], -8.0)).abs() < 1e-9);
        assert_eq!(Centre::of([].into_iter()), None);
        assert_eq!(Centre::of([([1.0; 3], [0.0; 3], 0.0)].into_iter()), None);
    }

    #[test]
    fn none_is_chosen_at_or_beyond_the_threshold() {
        let nearest_of = |distances: &[(usize, f64)], threshold| nearest(distances.iter().copied(), threshold);
        assert_eq!(nearest_of(&[(0, 30.0), (2, 20.0), (1, 20.0)], 25.0), Some(1));
        assert_eq!(nearest_of(&[(0, 30.0), (1, 20.0)], 20.0), None, "at the threshold");
        assert_eq!(nearest_of(&[(0, f64::NAN), (1, 20.0)], 21.0), Some(1));
        assert_eq!(nearest_of(&[], 21.0), None);
    }
}
