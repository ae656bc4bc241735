//! Where a search begins.
//!
//! Bearings alone cross at a single place ([`crate::triangulation`]). Hyperbolas may cross twice, and the search from a
//! bad start ends at the wrong crossing, or at a place where a wrong measurement and a right measurement meet. So the
//! search begins at many places around the receivers, on the rays and at the fixes. The best places are improved with
//! weights that forgive large errors first, and ever smaller errors later (graduated non-convexity: A. Blake, A.
//! Zisserman, *Visual Reconstruction*, MIT Press, 1987). The place that explains the lines best is the start. If
//! another place explains the lines nearly as well, the data do not show which is right, and there is no start yet.

use nalgebra::{Matrix2, Vector2};

use crate::gauss_newton::{KNEE, LeastSquaresProblem, StatePrior};
use crate::kinematics::longest_half_axis;
use crate::line_of_bearing::{LineOfBearing, Shape};
use crate::triangulation::crossing;

/// Fewest bearings of a start, and fewest lines if some are no bearings.
pub(crate) const BEARINGS_MIN: usize = 3;
const LINES_MIN: usize = 2;
/// Distances of the places around the receivers, in units of the receivers' spread, and directions.
const RINGS: [f64; 5] = [0.35, 0.8, 1.5, 3.0, 8.0];
const DIRECTIONS: usize = 12;
/// Distances along a ray, in the same units.
const ALONG_RAY: [f64; 5] = [0.1, 0.4, 1.0, 2.5, 6.0];
/// Rays and receivers that give places, and places that are improved.
const RAYS_MAX: usize = 2;
const RECEIVERS_MAX: usize = 8;
const IMPROVED: usize = 12;
/// Squared normalised innovations from which on a line counts less, round by round.
const KNEES: [f64; 4] = [1e6, 1e4, 400.0, KNEE];
const ROUNDS: usize = 6;
/// Places nearer to a better place than this share of the distance are not improved.
const NEIGHBOUR: f64 = 0.15;
/// An unknown position about the receivers, in the same units.
const SPREADS_MAX: f64 = 100.0;
/// A second place is distinct if so many standard deviations away, and a candidate if the cost is at most so much
/// greater: the limit that chi-square with two degrees of freedom exceeds once in a hundred times.
const APART_SIGMAS: f64 = 8.0;
const COST_APART: f64 = 9.2;

/// Places among which the best are chosen.
const PLACES_MAX: usize = 1 + RINGS.len() * DIRECTIONS + RECEIVERS_MAX + RAYS_MAX * ALONG_RAY.len() + 2;

/// A list of places with a fixed maximum.
struct Places {
    places: [[f64; 2]; PLACES_MAX],
    len: usize,
}

impl Places {
    fn push(&mut self, place: [f64; 2]) {
        if self.len < PLACES_MAX {
            self.places[self.len] = place;
            self.len += 1;
        }
    }
}

/// Start of a search for the position that explains the lines, metres east and north; `None` if the lines are too few,
/// or determine none.
pub(crate) fn start_position(lines: &[LineOfBearing]) -> Option<[f64; 2]> {
    let used = || lines.iter().filter(|line| line.is_used);
    if used().all(|line| line.ray().is_some()) {
        return (used().count() >= BEARINGS_MIN).then(|| crossing(lines))?;
    }
    if used().count() < LINES_MIN {
        return None;
    }
    let (centre, spread_m) = surroundings(lines);
    let information = Matrix2::identity() / (SPREADS_MAX * spread_m).powi(2);
    let prior = StatePrior {
        mean: Vector2::from(centre),
        information,
    };
    let problem = LeastSquaresProblem {
        reference_ns: lines[0].time_ns,
        prior: &prior,
        lines,
    };
    best_of(&problem, &places(lines, centre, spread_m))
}

/// Centre of the places that measured, and the distance over which these places spread.
fn surroundings(lines: &[LineOfBearing]) -> ([f64; 2], f64) {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for line in lines.iter().filter(|line| line.is_used) {
        for at in line.origins_m() {
            for axis in 0..2 {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
        }
    }
    let centre = [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]));
    (centre, (0.5 * (high[0] - low[0]).hypot(high[1] - low[1])).max(1.0))
}

fn places(lines: &[LineOfBearing], centre: [f64; 2], spread_m: f64) -> Places {
    let mut places = Places {
        places: [centre; PLACES_MAX],
        len: 1,
    };
    let used = || lines.iter().filter(|line| line.is_used);
    if let Some(crossing) = crossing(lines) {
        places.push(crossing);
    }
    if let Some(fix) = used().rev().find(|line| matches!(line.shape, Shape::Straight(_))) {
        places.push(fix.origin_m());
    }
    for ray in used().filter_map(LineOfBearing::ray).take(RAYS_MAX) {
        for share in ALONG_RAY {
            let along = |axis: usize, direction: f64| ray.platform_m[axis] + share * spread_m * direction;
            places.push([along(0, ray.sine), along(1, ray.cosine)]);
        }
    }
    let mut near: [Option<[f64; 2]>; RECEIVERS_MAX] = [None; RECEIVERS_MAX];
    for receiver in used()
        .filter(|line| line.has_outliers())
        .flat_map(LineOfBearing::origins_m)
    {
        if near.contains(&Some(receiver)) {
            continue;
        }
        let Some(free) = near.iter_mut().find(|place| place.is_none()) else {
            break;
        };
        *free = Some(receiver);
        // Beside the receiver, towards the others: at the receiver itself a distance has no direction.
        places.push([0, 1].map(|axis| receiver[axis] + 0.05 * (centre[axis] - receiver[axis])));
    }
    for (ring, share) in RINGS.into_iter().enumerate() {
        for direction in 0..DIRECTIONS {
            let turn = (direction as f64 + 0.5 * (ring % 2) as f64) / DIRECTIONS as f64;
            let (sine, cosine) = (std::f64::consts::TAU * turn).sin_cos();
            places.push([
                centre[0] + share * spread_m * sine,
                centre[1] + share * spread_m * cosine,
            ]);
        }
    }
    places
}

/// The place that explains the lines best after improvement, unless another place does nearly as well.
fn best_of(problem: &LeastSquaresProblem<'_, 2>, places: &Places) -> Option<[f64; 2]> {
    let mut candidates = [(f64::INFINITY, [0.0; 2]); PLACES_MAX];
    let candidates = &mut candidates[..places.len];
    for (candidate, place) in candidates.iter_mut().zip(&places.places) {
        let system = problem.linearised_with(&Vector2::from(*place), KNEES[1]);
        *candidate = (system.cost, *place);
    }
    candidates.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
    let mut chosen: [Option<[f64; 2]>; IMPROVED] = [None; IMPROVED];
    for (_, place) in candidates.iter() {
        let is_near = |other: &[f64; 2]| {
            (place[0] - other[0]).hypot(place[1] - other[1]) < NEIGHBOUR * distance_m(*place, problem)
        };
        if !chosen.iter().flatten().any(is_near)
            && let Some(free) = chosen.iter_mut().find(|free| free.is_none())
        {
            *free = Some(*place);
        }
    }
    let found = chosen.map(|place| improve(problem, place?));
    let best = (found.iter().flatten()).min_by(|one, other| one.cost.total_cmp(&other.cost))?;
    let is_other = |one: &&Improved| {
        let apart = (one.place - best.place).norm();
        one.cost < best.cost + COST_APART && apart > APART_SIGMAS * best.sigma_m.max(one.sigma_m) + 1.0
    };
    let is_unique = !found.iter().flatten().any(|one| is_other(&one));
    is_unique.then_some([best.place[0], best.place[1]])
}

/// Distance of a place from where the first line was measured.
fn distance_m(place: [f64; 2], problem: &LeastSquaresProblem<'_, 2>) -> f64 {
    let [east, north] = problem.lines[0].origin_m();
    (place[0] - east).hypot(place[1] - north)
}

/// A place and how well the place explains the lines.
#[derive(Clone, Copy)]
struct Improved {
    place: Vector2<f64>,
    cost: f64,
    sigma_m: f64,
}

fn improve(problem: &LeastSquaresProblem<'_, 2>, place: [f64; 2]) -> Option<Improved> {
    let mut at = Vector2::from(place);
    let mut covariance = Matrix2::zeros();
    for knee in KNEES {
        let found = problem.search_with(at, ROUNDS, knee)?;
        (at, covariance) = (found.state, found.covariance);
    }
    let system = problem.linearised(&at);
    let cost = system.flat_cost();
    let is_usable = at.iter().all(|value| value.is_finite()) && cost.is_finite() && system.most_arrivals_fit();
    is_usable.then(|| Improved {
        place: at,
        cost,
        sigma_m: longest_half_axis(&covariance),
    })
}
