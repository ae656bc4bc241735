//! Errors of the measurements behind the tracks of a source, from the corrections that its tracker makes.
//!
//! A tracker predicts x⁻, and corrects the prediction by a measurement with the innovation ν and the covariance R. A
//! tracker that weighs by Kalman's rule, with one model of motion or a mixture whose models share the prediction,
//! arrives at x⁺ = x⁻ + P⁺·Hᵀ·R⁻¹·ν, with the covariance P⁺ that it states. So the measurement is z = x⁻ + R·u, with u
//! = P⁺ₚₚ⁻¹·(x⁺ₚ − x⁻ₚ): process noise and models of the tracker do not matter. Unknown is R alone, and u shows it: the
//! covariance of u is (R − P⁺ₚₚ)⁻¹.
//!
//! R has a few numbers per source. Four shapes are followed at a time, and the shape with the greatest likelihood of
//! the corrections is used:
//! - proportional to P⁺ₚₚ: needs no place of the sensor;
//! - a circle;
//! - constant standard deviations along and across the line of sight;
//! - a radar's: a constant standard deviation along the line of sight, and of the azimuth.
//!
//! Each number is sought by steps: the mean of the squared corrections, relative to their covariance and bounded, is
//! that of chi-square, so that manoeuvres, a minority, move it little. Whether the tracker obeys the rule shows in the
//! velocity: its correction is then P⁺ᵥₚ·u. Trackers that do not are left alone.
//!
//! Limits: a covariance that is stated too small or too large by a factor is taken for the tracker's own; shapes other
//! than these four are met by the nearest.
//!
//! Source: the information form of Kalman's update, as in Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with
//! Applications to Tracking and Navigation*, Wiley 2001, section 7.2; R. K. Mehra, *On the identification of variances
//! and adaptive Kalman filtering*, IEEE Transactions on Automatic Control 15 (1970).

use estimation::{Gaussian, length};
use kept::kept;
use messages::AXES;
use serde::{Deserialize, Serialize};

use crate::measurement::Measurement;
use crate::principal::Principal;

/// Bound of the square of a component of a correction relative to its variance; the mean of chi-square with one degree
/// of freedom under this bound, and the part of the mean below the bound.
const BOUND: f64 = 4.0;
const BOUNDED_MEAN: f64 = 0.9206;
const BELOW_BOUND: f64 = 0.7385;
/// R over the stated covariance before anything is known, and its weight in corrections.
const RATIO_PRIOR: f64 = 3.0;
const PRIOR_CORRECTIONS: u32 = 4;
/// Least part of a step that the stated covariance leaves.
const STEP_LEAST: f64 = 0.1;
/// Corrections before measurements are recovered.
const CORRECTIONS_MIN: u32 = 32;
/// Reports of a track before its corrections teach: the gains of a new track say little about R.
const REPORTS_MIN: u32 = 3;
/// Weight of a correction in a mean, at least.
const GAIN_MIN: f64 = 1.0 / 512.0;
/// Largest share of R that the stated covariance can have: rounding, and values that are not yet known.
const STATED_SHARE_MAX: f64 = 0.98;
/// Squared length of a whitened correction from which on a longer one is no less likely: a manoeuvre.
const SQUARED_MAX: f64 = 12.0;
/// Likelihood per correction, as a logarithm, that a shape with a further number has to add.
const NUMBER_COSTS: f64 = 0.01;
/// Relative squared error up to which a correction of velocity counts as foretold; share of such corrections from which
/// on measurements are recovered, and below which no longer.
const FORETOLD: f64 = 0.05;
const FORETOLD_FROM: f64 = 0.8;
const FORETOLD_UNTIL: f64 = 0.6;
/// Squared change of velocity that rounding explains, m²/s².
const ROUNDING_M2PS2: f64 = 1e-3;
/// Shortest correction in the plane, metres: a shorter one is a prediction that was repeated.
const CORRECTION_MIN_M: f64 = 1e-2;

/// Number of shapes.
const SHAPES: usize = 4;
/// Numbers of each shape.
const NUMBERS: [f64; SHAPES] = [1.0, 1.0, 2.0, 2.0];

kept! {
    /// Logarithm of a number of R.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    struct Sought {
        logarithm: f64,
        samples: u32,
    }
}

impl Sought {
    /// Learns from the component `u` of a whitened correction with the variance `stated` at its place; the number
    /// stands for the variance R = number · `unit`. A variance that rounding made 0 teaches nothing.
    fn add(&mut self, u: f64, stated: f64, unit: f64) {
        // Written so that NaN is refused.
        if !(stated > 0.0 && unit > 0.0 && u.is_finite()) {
            return;
        }
        if self.samples == 0 {
            self.logarithm = (RATIO_PRIOR * stated / unit).ln();
        }
        self.samples = self.samples.saturating_add(1);
        let covariance = self.value() * unit;
        let left = covariance - stated;
        let square = u * u * left.max((1.0 - STATED_SHARE_MAX) * covariance);
        let gain = (1.0 / f64::from(self.samples + PRIOR_CORRECTIONS)).max(GAIN_MIN);
        let share = (left / covariance).max(STEP_LEAST);
        self.logarithm += gain * share * (BOUNDED_MEAN - square.min(BOUND)) / BELOW_BOUND;
    }

    fn value(&self) -> f64 {
        self.logarithm.exp()
    }
}

kept! {
    /// Errors of the measurements, as the corrections show them.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct Corrections {
        /// R over the stated covariance.
        ratio: Sought,
        /// Variance of a circle, m².
        circle_m2: Sought,
        /// Variances along and across the line of sight, m².
        along_m2: Sought,
        across_m2: Sought,
        /// Variance of the azimuth, rad².
        azimuth_rad2: Sought,
        height_m2: Sought,
        /// Mean logarithm of the likelihood of each shape.
        likelihood: [f64; SHAPES],
        /// Share of the foretold corrections of velocity.
        foretold: f64,
        corrections: u32,
        is_used: bool,
    }
}

/// A correction of a track: the states before and after it.
pub(crate) struct Corrected<'a> {
    /// The prediction of the tracker, without noise.
    predicted_m: [f64; AXES],
    predicted_mps: [f64; AXES],
    after: &'a Gaussian,
    has_height: bool,
    /// The sensor's place, if known, metres.
    place_m: Option<[f64; 2]>,
}

/// Symmetric matrix in the plane: xx, xy, yy.
type Plane = [f64; 3];

/// Line of sight from the sensor to the target: the unit vector, and the distance, metres.
type Sight = ([f64; 2], f64);

fn inverse([xx, xy, yy]: Plane) -> Option<Plane> {
    let determinant = xx * yy - xy * xy;
    (determinant > 0.0).then(|| [yy / determinant, -xy / determinant, xx / determinant])
}

fn product([xx, xy, yy]: Plane, [x, y]: [f64; 2]) -> [f64; 2] {
    [xx * x + xy * y, xy * x + yy * y]
}

/// Components of a vector along and across a direction.
fn turned([x, y]: [f64; 2], [east, north]: [f64; 2]) -> [f64; 2] {
    [east * x + north * y, east * y - north * x]
}

/// Variances along and across a direction.
fn turned_variances([xx, xy, yy]: Plane, [east, north]: [f64; 2]) -> [f64; 2] {
    let both = 2.0 * east * north * xy;
    [
        east * east * xx + both + north * north * yy,
        north * north * xx - both + east * east * yy,
    ]
}

/// The matrix with these variances along and across a direction.
fn along_and_across([along, across]: [f64; 2], [east, north]: [f64; 2]) -> Plane {
    [
        along * east * east + across * north * north,
        (along - across) * east * north,
        along * north * north + across * east * east,
    ]
}

impl<'a> Corrected<'a> {
    /// The correction that led to the state `after`, of a report with or without height, `seconds` after the state
    /// `before`.
    pub(crate) fn of(
        (before, seconds): (&Gaussian, f64),
        (after, has_height): (&'a Gaussian, bool),
        place_m: Option<[f64; 2]>,
    ) -> Self {
        let (position, velocity) = (before.position_m(), before.velocity_mps());
        Self {
            predicted_m: std::array::from_fn(|axis| position[axis] + velocity[axis] * seconds),
            predicted_mps: velocity,
            after,
            has_height,
            place_m,
        }
    }

    fn moved_m(&self, axis: usize) -> f64 {
        self.after.mean[axis] - self.predicted_m[axis]
    }

    fn turned_mps(&self, axis: usize) -> f64 {
        self.after.mean[AXES + axis] - self.predicted_mps[axis]
    }

    fn plane(&self) -> Plane {
        let of = &self.after.covariance;
        [of.get(0, 0), of.get(0, 1), of.get(1, 1)]
    }

    /// The correction in the plane, whitened by the stated covariance; `None` if there was none.
    fn u(&self) -> Option<[f64; 2]> {
        let moved = [self.moved_m(0), self.moved_m(1)];
        let is_correction = moved[0].abs().max(moved[1].abs()) > CORRECTION_MIN_M;
        let inverse = inverse(self.plane()).filter(|_| is_correction)?;
        Some(product(inverse, moved))
    }

    fn sight(&self) -> Option<Sight> {
        let [east, north] = self.place_m?;
        let (x, y) = (self.predicted_m[0] - east, self.predicted_m[1] - north);
        let distance_m = length([x, y]);
        (distance_m > 1.0).then(|| ([x / distance_m, y / distance_m], distance_m))
    }

    /// Whether Kalman's rule foretells the correction of velocity.
    fn is_foretold(&self, [ux, uy]: [f64; 2]) -> bool {
        let of = &self.after.covariance;
        let [mut error, mut moved] = [0.0, ROUNDING_M2PS2];
        for axis in 0..2 {
            let foretold = of.get(axis + AXES, 0) * ux + of.get(axis + AXES, 1) * uy;
            let turned = self.turned_mps(axis);
            error += (turned - foretold) * (turned - foretold);
            moved += turned * turned;
        }
        error <= FORETOLD * moved
    }
}

impl Corrections {
    /// Whether measurements are recovered.
    #[inline]
    pub(crate) fn is_used(&self) -> bool {
        self.is_used
    }

    /// Covariance of the measurements in the plane for each shape, m²; shapes without a known place of the sensor are
    /// absent.
    fn shapes(&self, stated: Plane, sight: Option<Sight>) -> [Option<Plane>; SHAPES] {
        let circle = self.circle_m2.value();
        let along = self.along_m2.value();
        [
            Some(stated.map(|value| self.ratio.value() * value)),
            Some([circle, 0.0, circle]),
            sight.map(|(direction, _)| along_and_across([along, self.across_m2.value()], direction)),
            sight.map(|(direction, distance_m)| {
                let across = self.azimuth_rad2.value() * distance_m * distance_m;
                along_and_across([along, across], direction)
            }),
        ]
    }

    /// Learns from the correction of a track with so many `reports`.
    pub(crate) fn learn(&mut self, corrected: &Corrected<'_>, reports: u32) {
        let Some(u) = corrected.u().filter(|_| reports >= REPORTS_MIN) else {
            return;
        };
        let (stated, sight) = (corrected.plane(), corrected.sight());
        self.corrections = self.corrections.saturating_add(1);
        let gain = (1.0 / f64::from(self.corrections)).max(GAIN_MIN);
        let foretold = f64::from(u8::from(corrected.is_foretold(u)));
        self.foretold += gain * (foretold - self.foretold);
        if self.corrections > 1 {
            let shapes = self.shapes(stated, sight);
            for (shape, (mean, covariance)) in self.likelihood.iter_mut().zip(shapes).enumerate() {
                if let Some(covariance) = covariance {
                    let found = likelihood(u, covariance, stated) - NUMBER_COSTS * NUMBERS[shape];
                    *mean += gain * (found - *mean);
                }
            }
        }
        self.learn_values(u, stated, sight);
        // Heights that stay as predicted are those of ships, or repeated: no correction shows an error.
        if corrected.has_height && corrected.moved_m(2).abs() > CORRECTION_MIN_M {
            let stated_m2 = corrected.after.covariance.get(2, 2);
            self.height_m2.add(corrected.moved_m(2) / stated_m2, stated_m2, 1.0);
        }
        let least = if self.is_used { FORETOLD_UNTIL } else { FORETOLD_FROM };
        self.is_used = self.corrections >= CORRECTIONS_MIN && self.foretold >= least;
    }

    fn learn_values(&mut self, u: [f64; 2], stated: Plane, sight: Option<Sight>) {
        let axes = Principal::of(stated);
        for (u, stated_m2) in axes.along(u).into_iter().zip(axes.values) {
            self.ratio.add(u, stated_m2, stated_m2);
        }
        self.circle_m2.add(u[0], stated[0], 1.0);
        self.circle_m2.add(u[1], stated[2], 1.0);
        if let Some((direction, distance_m)) = sight {
            let [along, across] = turned(u, direction);
            let [along_m2, across_m2] = turned_variances(stated, direction);
            self.along_m2.add(along, along_m2, 1.0);
            self.across_m2.add(across, across_m2, 1.0);
            self.azimuth_rad2.add(across, across_m2, distance_m * distance_m);
        }
    }

    /// The measurement behind a correction; `None` if the report shows none. Must be called only if
    /// [`Self::is_used`].
    pub(crate) fn measurement(&self, corrected: &Corrected<'_>) -> Option<Measurement> {
        let u = corrected.u()?;
        let stated = corrected.plane();
        let shapes = self.shapes(stated, corrected.sight()).into_iter().zip(self.likelihood);
        let known = shapes.filter_map(|(shape, likelihood)| Some((shape?, likelihood)));
        let (covariance, _) = known.max_by(|(_, one), (_, other)| one.total_cmp(other))?;
        let covariance = at_least(covariance, stated);
        let [east, north] = product(covariance, u);
        let [x, y, z] = corrected.predicted_m;
        let stated_m2 = corrected.after.covariance.get(2, 2);
        let height_m2 = match self.height_m2.samples {
            0 => RATIO_PRIOR * stated_m2,
            _ => self.height_m2.value().max(stated_m2 / STATED_SHARE_MAX),
        };
        // Without an uncertainty, the height is as stated.
        let up = corrected.moved_m(2) * if stated_m2 > 0.0 { height_m2 / stated_m2 } else { 1.0 };
        let [xx, xy, yy] = covariance;
        Some(match corrected.has_height {
            true => Measurement {
                position_m: [x + east, y + north, z + up],
                covariance_m2: [xx, xy, 0.0, yy, 0.0, height_m2],
                axes: AXES,
                has_waited: false,
            },
            false => Measurement {
                position_m: [x + east, y + north, 0.0],
                covariance_m2: [xx, xy, 0.0, yy, 0.0, 0.0],
                axes: 2,
                has_waited: false,
            },
        })
    }
}

/// R − P⁺ by its axes; on no axis is the difference less than the share of R that [`STATED_SHARE_MAX`] leaves.
fn difference(covariance: Plane, stated: Plane) -> Principal {
    let mut axes = Principal::of(std::array::from_fn(|part| covariance[part] - stated[part]));
    let least = (1.0 - STATED_SHARE_MAX) * 0.5 * (covariance[0] + covariance[2]);
    axes.values = axes.values.map(|value| value.max(least));
    axes
}

/// R, enlarged where it would not be larger than the stated covariance.
fn at_least(covariance: Plane, stated: Plane) -> Plane {
    let axes = difference(covariance, stated);
    let difference = axes.matrix(axes.values);
    std::array::from_fn(|part| stated[part] + difference[part])
}

/// Logarithm of the likelihood of a whitened correction, up to a constant.
fn likelihood(u: [f64; 2], covariance: Plane, stated: Plane) -> f64 {
    let axes = difference(covariance, stated);
    let [first, second] = axes.along(u);
    let squared = first * first * axes.values[0] + second * second * axes.values[1];
    0.5 * ((axes.values[0] * axes.values[1]).ln() - squared.min(SQUARED_MAX))
}

#[cfg(test)]
#[path = "corrections_tests.rs"]
mod tests;
