//! Polygons of the plane, with holes.

/// Distance within which two sides are the same, metres.
const SAME_M: f64 = 0.05;

/// A side: two points east and north, metres.
type Side = [[f64; 2]; 2];

/// One or more polygons, each with its outer ring and its holes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Rings of each polygon: points east and north, metres, without the first point again at the end.
    polygons: Vec<Vec<Vec<[f64; 2]>>>,
    /// The sides that separate inside from outside: without those that two polygons share, as where a file cuts an area
    /// at 180 degrees of longitude.
    border: Vec<Side>,
}

impl Outline {
    /// Of polygons: for each, the outer ring and the holes, of points east and north, metres.
    pub fn new(polygons: Vec<Vec<Vec<[f64; 2]>>>) -> Self {
        let mut border: Vec<Side> = Vec::new();
        for (number, polygon) in polygons.iter().enumerate() {
            let earlier = border.len();
            for side in polygon.iter().flat_map(|ring| sides(ring)) {
                let other = |other: &Side| is_same(other[0], side[1]) && is_same(other[1], side[0]);
                match border[..earlier.min(border.len())]
                    .iter()
                    .position(other)
                    .filter(|_| number > 0)
                {
                    Some(shared) => border[shared] = [[f64::NAN; 2]; 2],
                    None => border.push(side),
                }
            }
            border.retain(|side| !side[0][0].is_nan());
        }
        Self { polygons, border }
    }

    /// The polygons: for each, the outer ring and the holes.
    pub fn polygons(&self) -> &[Vec<Vec<[f64; 2]>>] {
        &self.polygons
    }

    /// Whether a place is inside. A place on the border belongs to either side.
    pub fn contains(&self, place_m: [f64; 2]) -> bool {
        // A place in a hole is in two rings.
        let rings = |polygon: &Vec<Vec<[f64; 2]>>| polygon.iter().filter(|ring| encloses(ring, place_m)).count();
        self.polygons.iter().any(|polygon| rings(polygon) % 2 == 1)
    }

    /// Distance of a place from the border, metres; negative inside.
    pub fn distance_m(&self, place_m: [f64; 2]) -> f64 {
        let distances = self.border.iter().map(|side| to_side_m(*side, place_m));
        let distance_m = distances.fold(f64::INFINITY, f64::min);
        match self.contains(place_m) {
            true => -distance_m,
            false => distance_m,
        }
    }

    /// Least and greatest east and north of all points, metres.
    pub fn bounds_m(&self) -> [[f64; 2]; 2] {
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for point in self.polygons.iter().flatten().flatten() {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(point[axis]);
                bounds[1][axis] = bounds[1][axis].max(point[axis]);
            }
        }
        bounds
    }
}

fn is_same(one: [f64; 2], other: [f64; 2]) -> bool {
    (0..2).all(|axis| (one[axis] - other[axis]).abs() < SAME_M)
}

fn sides(ring: &[[f64; 2]]) -> impl Iterator<Item = Side> + '_ {
    let after = ring.iter().cycle().skip(1);
    ring.iter().zip(after).map(|(from, to)| [*from, *to])
}

/// Whether a ray to the east crosses the ring an odd number of times.
fn encloses(ring: &[[f64; 2]], [east, north]: [f64; 2]) -> bool {
    let crossed = sides(ring).filter(|[[x1, y1], [x2, y2]]| {
        (*y1 > north) != (*y2 > north) && east < x1 + (north - y1) / (y2 - y1) * (x2 - x1)
    });
    crossed.count() % 2 == 1
}

/// Distance of a place from a side, metres.
fn to_side_m([a, b]: Side, place: [f64; 2]) -> f64 {
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn square(low: f64, high: f64) -> Vec<[f64; 2]> {
        vec![[low, low], [high, low], [high, high], [low, high]]
    }

    #[test]
    fn holes_and_further_polygons_count() {
        let outline = Outline::new(vec![
            vec![square(0.0, 10.0), square(4.0, 6.0)],
            vec![square(20.0, 30.0)],
        ]);
        for (place, expected_m) in [
            ([1.0, 1.0], -1.0),
            ([5.0, 5.0], 1.0),
            ([7.0, 5.0], -1.0),
            ([25.0, 25.0], -5.0),
            ([15.0, 15.0], 50f64.sqrt()),
            ([-1.0, 5.0], 1.0),
            ([25.0, 5.0], 15.0),
        ] {
            let distance_m = outline.distance_m(place);
            assert!((distance_m - expected_m).abs() < 1e-9, "{place:?}: {distance_m}");
            assert_eq!(outline.contains(place), expected_m < 0.0, "{place:?}");
        }
        assert_eq!(outline.bounds_m(), [[0.0; 2], [30.0; 2]]);
    }

    #[test]
    fn a_side_that_two_polygons_share_is_no_border() {
        let half = |from: f64| vec![vec![[from, 0.0], [from + 5.0, 0.0], [from + 5.0, 10.0], [from, 10.0]]];
        let whole = Outline::new(vec![half(0.0), half(5.0)]);
        assert_eq!(whole.distance_m([4.5, 5.0]), -4.5);
        assert_eq!(whole.distance_m([5.5, 5.0]), -4.5);
        assert_eq!(Outline::new(vec![half(0.0)]).distance_m([4.5, 5.0]), -0.5);
    }

    proptest! {
        #[test]
        fn between_two_places_the_distance_changes_by_no_more_than_the_way(
            corners in prop::collection::vec([-100.0f64..100.0, -100.0..100.0], 3..12),
            one in [-150.0f64..150.0, -150.0..150.0], way in [-30.0f64..30.0, -30.0..30.0],
        ) {
            let outline = Outline::new(vec![vec![corners]]);
            let other = [one[0] + way[0], one[1] + way[1]];
            let change = outline.distance_m(one) - outline.distance_m(other);
            prop_assert!(change.abs() <= way[0].hypot(way[1]) + 1e-9, "{change}");
        }
    }
}
