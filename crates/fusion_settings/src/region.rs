//! Regions of the ground: polygons, in the system frame.

/// Most corners of a region.
pub const CORNERS_MAX: usize = 256;
/// Distance within which borders are taken for the same, metres: rounding decides nothing.
pub const TOUCH_M: f64 = 1.0;
/// Most regions.
pub const REGIONS_MAX: usize = 64;

/// Region of a centre.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    /// Owning deployment: `origin` of its configuration.
    pub origin: u32,
    /// Whether it is the deployment at hand.
    pub is_own: bool,
    /// Corners in turn, east and north in the system frame, metres.
    pub corners_m: Vec<[f64; 2]>,
}

impl Region {
    /// Returns whether a place, east and north, metres, is inside: a ray from there crosses the sides an odd number
    /// of times.
    pub fn contains(&self, [east, north]: [f64; 2]) -> bool {
        let crossed = self.sides().filter(|[a, b]| {
            let is_between = (a[1] > north) != (b[1] > north);
            is_between && east < a[0] + (north - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        crossed.count() % 2 == 1
    }

    /// Distance of a place from it, metres; 0 inside.
    pub fn distance_m(&self, place: [f64; 2]) -> f64 {
        if self.contains(place) {
            return 0.0;
        }
        let distances = self.sides().map(|side| to_side_m(side, place));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Whether it has more than a line in common with another. Where sides meet, rounding decides nothing: a metre is
    /// allowed.
    pub fn overlaps(&self, other: &Self) -> bool {
        let crosses = self
            .sides()
            .any(|one| other.sides().any(|two| cross(one, two, TOUCH_M)));
        let is_inside = |a: &Self, b: &Self| {
            let deep = |place: &[f64; 2]| b.contains(*place) && b.sides().all(|side| to_side_m(side, *place) > TOUCH_M);
            let count = a.corners_m.len() as f64;
            let sum = a
                .corners_m
                .iter()
                .fold([0.0; 2], |sum, [east, north]| [sum[0] + east, sum[1] + north]);
            let middle = Some(sum.map(|part| part / count)).filter(|middle| a.contains(*middle));
            let halfway = |[a, b]: [[f64; 2]; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            a.corners_m
                .iter()
                .copied()
                .chain(a.sides().map(halfway))
                .chain(middle)
                .any(|place| deep(&place))
        };
        crosses || is_inside(self, other) || is_inside(other, self)
    }

    fn sides(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        let after = self.corners_m.iter().cycle().skip(1);
        self.corners_m.iter().zip(after).map(|(a, b)| [*a, *b])
    }
}

/// Distance of a place from a side, metres.
fn to_side_m([a, b]: [[f64; 2]; 2], place: [f64; 2]) -> f64 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [place[0] - a[0], place[1] - a[1]]);
    let length2 = along[0] * along[0] + along[1] * along[1];
    let share = if length2 > 0.0 {
        (to[0] * along[0] + to[1] * along[1]) / length2
    } else {
        0.0
    };
    let share = share.clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}

/// Whether two sides cross, each with its ends more than `touch_m` on either side of the other.
fn cross([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2], touch_m: f64) -> bool {
    let aside_m = |from: [f64; 2], to: [f64; 2], place: [f64; 2]| {
        let along = [to[0] - from[0], to[1] - from[1]];
        let across = along[0] * (place[1] - from[1]) - along[1] * (place[0] - from[0]);
        across / along[0].hypot(along[1]).max(f64::MIN_POSITIVE)
    };
    let parts = |one: f64, two: f64| one.min(two) < -touch_m && one.max(two) > touch_m;
    parts(aside_m(a, b, c), aside_m(a, b, d)) && parts(aside_m(c, d, a), aside_m(c, d, b))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_region_with_a_bay_has_an_inside_and_distances() {
        let region = Region {
            corners_m: vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [5.0, 4.0], [0.0, 10.0]],
            ..Region::default()
        };
        for (place, expected_m) in [
            ([5.0, 2.0], 0.0),
            ([1.0, 8.0], 0.0),
            ([-3.0, 5.0], 3.0),
            ([13.0, -4.0], 5.0),
            ([5.0, 10.0], 3.841),
        ] {
            let distance_m = region.distance_m(place);
            assert!((distance_m - expected_m).abs() < 1e-3, "{place:?}: {distance_m}");
        }
        assert!(!region.contains([5.0, 6.0]), "in the bay");
    }

    #[test]
    fn regions_that_meet_at_a_line_do_not_overlap() {
        let square = |east: f64, north: f64| Region {
            corners_m: vec![
                [east, north],
                [east + 10e3, north],
                [east + 10e3, north + 10e3],
                [east, north + 10e3],
            ],
            ..Region::default()
        };
        let first = square(0.0, 0.0);
        for (other, expected) in [
            (square(10e3, 0.0), false),
            (square(9_999.5, 3e3), false),
            (square(9e3, 3e3), true),
            (square(5e3, 0.0), true),
            (square(0.0, 0.0), true),
            (square(10e3, 10e3), false),
            (square(40e3, 0.0), false),
        ] {
            assert_eq!(first.overlaps(&other), expected, "{other:?}");
            assert_eq!(other.overlaps(&first), expected, "{other:?}");
        }
        let within = Region {
            corners_m: vec![[2e3, 2e3], [3e3, 2e3], [3e3, 3e3]],
            ..Region::default()
        };
        assert!(first.overlaps(&within) && within.overlaps(&first));
    }

    proptest! {
        #[test]
        fn inside_is_at_no_distance(east in -2.0..2.0f64, north in -2.0..2.0f64) {
            let corners = (0..9).map(|corner| f64::from(corner) * 0.698);
            let region = Region {
                corners_m: corners.map(|angle| [angle.cos(), angle.sin()]).collect(),
                ..Region::default()
            };
            let radius = east.hypot(north);
            prop_assert!(radius > 0.93 || region.contains([east, north]));
            prop_assert!(radius < 1.001 || !region.contains([east, north]));
            let outside = (radius - 1.0).max(0.0);
            prop_assert!((region.distance_m([east, north]) - outside).abs() < 0.07);
        }
    }
}
