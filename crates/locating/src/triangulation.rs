//! A first guess of where bearings cross: total least squares.
//!
//! A bearing β from p means n·(x − p) = 0 with n = (cos β, −sin β). Ordinary least squares takes the n as exact. The n
//! are not exact, and the error is always to one side: for a distant emitter the solution lies at a fraction of the
//! emitter's range, and a filter that starts there keeps this error. Total least squares admits errors in all
//! coefficients: with (x, 1) in homogeneous coordinates, the solution is the direction that minimises the equations
//! together, the last eigenvector of a 3×3 matrix (S. C. Nardone, A. G. Lindgren, K. F. Gong, *Fundamental properties
//! and performance of conventional bearings-only target motion analysis*, IEEE Transactions on Automatic Control 29,
//! 1984, for the bias). The solution only starts a search; the search's result gives the accuracy.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::line_of_bearing::{LineOfBearing, Ray};

/// A platform that has moved less than this has seen the emitter from a single place, metres.
const BASELINE_MIN_M: f64 = 1.0;

/// Crossing of the bearings that count, metres east and north; `None` if the platform did not move, or the bearings
/// cross behind the platform or nowhere.
pub(crate) fn crossing(lines: &[LineOfBearing]) -> Option<[f64; 2]> {
    let used = || {
        let used = lines.iter().filter(|line| line.is_used);
        used.filter_map(|line| Some((line.information, line.ray()?)))
    };
    let weight: f64 = used().map(|(information, _)| information).sum();
    let mean = |axis: usize| used().map(|(w, ray)| w * ray.platform_m[axis]).sum::<f64>() / weight;
    let centre = [mean(0), mean(1)];
    let spread: f64 = used().map(|(w, ray)| w * distance_m(ray, centre).powi(2)).sum();
    // Lengths in units of the baseline, so that all three coefficients are about equally uncertain.
    let scale_m = (spread / weight).sqrt();
    if !scale_m.is_finite() || scale_m < BASELINE_MIN_M {
        return None;
    }
    let mut squares = Matrix3::zeros();
    for (information, ray) in used() {
        let [east, north] = [0, 1].map(|axis| (ray.platform_m[axis] - centre[axis]) / scale_m);
        let row = Vector3::new(ray.cosine, -ray.sine, ray.sine * north - ray.cosine * east);
        squares += row * row.transpose() * (information / weight);
    }
    let eigen = SymmetricEigen::new(squares);
    let least = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let place = [0, 1].map(|axis| centre[axis] + scale_m * least[axis] / least[2]);
    let ahead = |ray: &Ray| {
        let [east, north] = [0, 1].map(|axis| place[axis] - ray.platform_m[axis]);
        east * ray.sine + north * ray.cosine > 0.0
    };
    let in_front: f64 = used().filter(|(_, ray)| ahead(ray)).map(|(w, _)| w).sum();
    (place.iter().all(|value| value.is_finite()) && in_front > 0.5 * weight).then_some(place)
}

fn distance_m(ray: &Ray, place: [f64; 2]) -> f64 {
    let [east, north]: [f64; 2] = std::array::from_fn(|axis| place[axis] - ray.platform_m[axis]);
    (east * east + north * north).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line_of_bearing::Shape;

    fn seen(platform_m: [f64; 2], place: [f64; 2], error_rad: f64) -> LineOfBearing {
        let bearing = (place[0] - platform_m[0]).atan2(place[1] - platform_m[1]) + error_rad;
        LineOfBearing {
            shape: Shape::Ray(Ray {
                platform_m,
                sine: bearing.sin(),
                cosine: bearing.cos(),
            }),
            information: 1e4,
            is_used: true,
            ..LineOfBearing::NONE
        }
    }

    #[test]
    fn exact_bearings_cross_where_the_emitter_is() {
        let place = [3e3, 50e3];
        let lines: Vec<_> = (0..10).map(|k| seen([f64::from(k) * 1e3, 0.0], place, 0.0)).collect();
        let found = crossing(&lines).unwrap();
        assert!(
            (found[0] - place[0]).abs() < 1e-3 && (found[1] - place[1]).abs() < 1e-2,
            "{found:?}"
        );
    }

    #[test]
    fn parallel_diverging_and_unmoved_bearings_do_not_cross() {
        let parallel: Vec<_> = (0..5)
            .map(|k| seen([f64::from(k) * 1e3, 0.0], [f64::from(k) * 1e3, 1e3], 0.0))
            .collect();
        assert!(crossing(&parallel).is_none_or(|found| found[1].abs() > 1e9));
        let diverging: Vec<_> = (0..5)
            .map(|k| seen([f64::from(k) * 1e3, 0.0], [f64::from(k) * 2e3, 1e3], 0.0))
            .collect();
        assert_eq!(crossing(&diverging), None);
        assert_eq!(crossing(&[seen([5.0, 5.0], [0.0, 1e3], 0.0); 4]), None);
        assert_eq!(crossing(&[]), None);
    }
}
