//! A measurement in the filters' form, and the dependence on the emitter's position: a line of position.
//!
//! A filter takes scalars. Each scalar places the emitter on a line in the plane, with an error: a ray from the
//! platform (a bearing), a hyperbola about two receivers (a difference of arrival times), or a straight line (a
//! coordinate of a ready-made fix). Filters need the difference between the measured and the expected value, and the
//! change of this difference with the position; the rest is common to all kinds.

use kept::{Get, Kept, Put, kept};
use observations::{Bearing, ReadyFix};

/// Normalised innovations beyond this count less.
pub(crate) const DEVIATION_MAX: f64 = 4.0;
/// The same, squared.
pub(crate) const KNEE: f64 = DEVIATION_MAX * DEVIATION_MAX;
/// Nearer to the platform or a receiver than this an emitter has no direction, metres.
const OVERHEAD_M: f64 = 1.0;
/// Largest bias that merging two lines may cause, in standard deviations of the mean.
const LOSS_MAX: f64 = 0.05;

kept! {
    /// A checked measurement; a few successive measurements may have been merged.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub(crate) struct LineOfBearing {
        pub(crate) time_ns: i64,
        pub(crate) shape: Shape,
        /// Inverse variance: 1/rad² of a bearing, 1/m² of the others.
        pub(crate) information: f64,
        /// Set if the line is used; measurements found to be wrong are not.
        pub(crate) is_used: bool,
    }
}

/// Place of the emitter, by a single measurement without error. Positions are east and north in the system frame,
/// metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    Ray(Ray),
    Hyperbola(Hyperbola),
    Straight(Straight),
}

/// Ray of a bearing: direction as sine and cosine, so that no angle has to be unwrapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ray {
    pub(crate) platform_m: [f64; 2],
    pub(crate) sine: f64,
    pub(crate) cosine: f64,
}

/// Hyperbola of a difference of arrival times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hyperbola {
    pub(crate) receivers_m: [[f64; 2]; 2],
    /// Height of the receivers above the emitter, metres.
    pub(crate) heights_m: [f64; 2],
    /// Distance from the first receiver minus distance from the second.
    pub(crate) difference_m: f64,
    pub(crate) clocks: PairOfClocks,
}

/// Share of the receivers' clocks in a difference of arrival times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PairOfClocks {
    /// Numbers of the receivers' clocks.
    pub(crate) numbers: [u16; 2],
    /// By how much the first clock was taken to be ahead, metres of way.
    pub(crate) ahead_m: f64,
    /// Inverse variance of the difference with exact clocks, 1/m².
    pub(crate) information: f64,
    /// Weight of the clocks' variance beside that inverse.
    pub(crate) share: f64,
}

/// Straight line: a coordinate of a ready-made fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Straight {
    pub(crate) fix_m: [f64; 2],
    /// Unit vector along which the coordinate is measured.
    pub(crate) along: [f64; 2],
}

/// Innovation of a line where the emitter is believed to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Residual {
    /// Measured minus expected value, radians (a bearing) or metres.
    pub(crate) innovation_rad: f64,
    /// Change of the value per metre east and north.
    pub(crate) gradient: [f64; 2],
}

impl LineOfBearing {
    pub(crate) const NONE: Self = Self {
        time_ns: 0,
        shape: Shape::Ray(Ray {
            platform_m: [0.0; 2],
            sine: 0.0,
            cosine: 1.0,
        }),
        information: 0.0,
        is_used: false,
    };

    /// Makes the line of a bearing with finite values.
    pub(crate) fn new(bearing: &Bearing) -> Self {
        let (sine, cosine) = bearing.bearing_rad.sin_cos();
        Self {
            time_ns: bearing.time_of_measurement_ns,
            shape: Shape::Ray(Ray {
                platform_m: [bearing.platform_m[0], bearing.platform_m[1]],
                sine,
                cosine,
            }),
            information: 1.0 / (bearing.sigma_rad * bearing.sigma_rad),
            is_used: true,
        }
    }

    /// Makes the two lines of a ready-made fix: a line along each axis of the error ellipse, so that both errors are
    /// independent. `None` if the covariance is not positive definite.
    pub(crate) fn of_fix(fix: &ReadyFix) -> Option<[Self; 2]> {
        let [xx, xy, yy] = fix.covariance_m2;
        let greatest_m2 = 0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy);
        let least_m2 = (xx * yy - xy * xy) / greatest_m2;
        let (sine, cosine) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
        let is_ellipse = least_m2 > 0.0 && greatest_m2.is_finite() && xx > 0.0;
        let line = |along, variance_m2: f64| Self {
            time_ns: fix.time_of_measurement_ns,
            shape: Shape::Straight(Straight {
                fix_m: [fix.position_m[0], fix.position_m[1]],
                along,
            }),
            information: 1.0 / variance_m2,
            is_used: true,
        };
        is_ellipse.then(|| [line([cosine, sine], greatest_m2), line([-sine, cosine], least_m2)])
    }

    /// The ray, if this is the line of a bearing.
    pub(crate) fn ray(&self) -> Option<&Ray> {
        match &self.shape {
            Shape::Ray(ray) => Some(ray),
            Shape::Hyperbola(_) | Shape::Straight(_) => None,
        }
    }

    /// Whether wrong measurements of this kind come singly, and may be many: arrival times after a reflection. Wrong
    /// bearings come together.
    pub(crate) fn has_outliers(&self) -> bool {
        matches!(self.shape, Shape::Hyperbola(_))
    }

    /// The clocks of a difference of arrival times.
    pub(crate) fn clocks(&self) -> Option<&PairOfClocks> {
        match &self.shape {
            Shape::Hyperbola(hyperbola) => Some(&hyperbola.clocks),
            Shape::Ray(_) | Shape::Straight(_) => None,
        }
    }

    /// Sets how far the first clock of a difference is ahead, and the variance of that, metres and m². All lines
    /// of these clocks have this error in common: lines with the information `together` are together no better than the
    /// clocks.
    pub(crate) fn set_clocks(&mut self, ahead_m: f64, variance_m2: f64, together: f64) {
        if let Shape::Hyperbola(hyperbola) = &mut self.shape {
            let clocks = &mut hyperbola.clocks;
            hyperbola.difference_m += clocks.ahead_m - ahead_m;
            clocks.ahead_m = ahead_m;
            let common_m2 = clocks.share * variance_m2 * together.max(clocks.information);
            self.information = clocks.information / (1.0 + common_m2);
        }
    }

    /// With the emitter at `position_m`; `None` where the position is at the platform or a receiver itself.
    #[inline]
    pub(crate) fn residual(&self, position_m: [f64; 2]) -> Option<Residual> {
        match &self.shape {
            Shape::Ray(ray) => ray.residual(position_m),
            Shape::Hyperbola(hyperbola) => hyperbola.residual(position_m),
            Shape::Straight(straight) => Some(straight.residual(position_m)),
        }
    }

    /// Seconds since `reference_ns`.
    pub(crate) fn after_s(&self, reference_ns: i64) -> f64 {
        (self.time_ns - reference_ns) as f64 * 1e-9
    }

    /// A place of measurement, metres.
    pub(crate) fn origin_m(&self) -> [f64; 2] {
        match &self.shape {
            Shape::Ray(ray) => ray.platform_m,
            Shape::Hyperbola(hyperbola) => hyperbola.receivers_m[0],
            Shape::Straight(straight) => straight.fix_m,
        }
    }

    /// All places of measurement, metres.
    pub(crate) fn origins_m(&self) -> impl Iterator<Item = [f64; 2]> {
        let second = match &self.shape {
            Shape::Hyperbola(hyperbola) => Some(hyperbola.receivers_m[1]),
            Shape::Ray(_) | Shape::Straight(_) => None,
        };
        std::iter::once(self.origin_m()).chain(second)
    }

    /// Distance in the plane over which the line is nearly straight, metres: from the platform or the farther receiver;
    /// infinite for a straight line.
    pub(crate) fn distance_m(&self, position_m: [f64; 2]) -> f64 {
        match &self.shape {
            Shape::Ray(ray) => squared_distance_m2(ray.platform_m, position_m).sqrt(),
            Shape::Hyperbola(hyperbola) => {
                let [one, other] = hyperbola.receivers_m.map(|at| squared_distance_m2(at, position_m));
                one.max(other).sqrt()
            }
            Shape::Straight(_) => f64::INFINITY,
        }
    }

    /// Whether two lines taken in succession may be merged, with the emitter at `position_m` (`None`: unknown): the
    /// error of the mean is small beside the mean's standard deviation.
    pub(crate) fn may_merge(&self, later: &Self, position_m: Option<[f64; 2]>) -> bool {
        if self.is_used != later.is_used {
            return false;
        }
        match (&self.shape, &later.shape) {
            (Shape::Ray(one), Shape::Ray(other)) => {
                let Some(position_m) = position_m else { return true };
                let apart = squared_distance_m2(one.platform_m, other.platform_m);
                let range = squared_distance_m2(one.platform_m, position_m)
                    .min(squared_distance_m2(other.platform_m, position_m));
                let information = self.information + later.information;
                let limit = 8.0 * LOSS_MAX * range;
                apart * apart * information < limit * limit
            }
            (Shape::Hyperbola(one), Shape::Hyperbola(other)) => one.is_like(other),
            (Shape::Straight(one), Shape::Straight(other)) => one.along == other.along,
            _ => false,
        }
    }

    /// Whether both are differences of arrival times at the same receivers, and are used alike.
    pub(crate) fn is_of_same_pair(&self, other: &Self) -> bool {
        match (&self.shape, &other.shape) {
            (Shape::Hyperbola(one), Shape::Hyperbola(other_one)) => {
                one.is_like(other_one) && self.is_used == other.is_used
            }
            _ => false,
        }
    }

    /// Whether two such lines may be merged with the emitter at these positions: none is far off, and the emitter's way
    /// between them, as that of a platform between two bearings, is short beside the distance.
    pub(crate) fn may_merge_moving(&self, later: &Self, position_at: impl Fn(i64) -> [f64; 2]) -> bool {
        let places = [self, later].map(|line| position_at(line.time_ns));
        let fits = |line: &Self, place| {
            let residual = line.residual(place);
            residual.is_some_and(|residual| residual.innovation_rad.powi(2) * line.information < KNEE)
        };
        let way_m2 = squared_distance_m2(places[0], places[1]);
        let information = self.information + later.information;
        fits(self, places[0])
            && fits(later, places[1])
            && way_m2 * information.sqrt() < 8.0 * LOSS_MAX * self.distance_m(places[0])
    }

    /// Merges two lines of the same kind: mean time, place and value, weighted by information.
    pub(crate) fn merged(&self, later: &Self) -> Self {
        let information = self.information + later.information;
        let share = later.information / information;
        let mean = |a: f64, b: f64| a + share * (b - a);
        let shape = match (&self.shape, &later.shape) {
            (Shape::Ray(one), Shape::Ray(other)) => Shape::Ray(one.merged(other, mean)),
            (Shape::Hyperbola(one), Shape::Hyperbola(other)) => Shape::Hyperbola(one.merged(other, mean)),
            (Shape::Straight(one), Shape::Straight(other)) => Shape::Straight(Straight {
                fix_m: std::array::from_fn(|axis| mean(one.fix_m[axis], other.fix_m[axis])),
                ..*one
            }),
            (one, _) => *one,
        };
        Self {
            time_ns: self.time_ns + (share * (later.time_ns - self.time_ns) as f64) as i64,
            shape,
            information,
            is_used: self.is_used,
        }
    }
}

impl Ray {
    fn residual(&self, position_m: [f64; 2]) -> Option<Residual> {
        let east = position_m[0] - self.platform_m[0];
        let north = position_m[1] - self.platform_m[1];
        let squared = east * east + north * north;
        if squared.is_nan() || squared < OVERHEAD_M * OVERHEAD_M {
            return None;
        }
        // The expected direction, rotated so that the measured direction is north.
        let across = east * self.cosine - north * self.sine;
        let along = north * self.cosine + east * self.sine;
        Some(Residual {
            innovation_rad: -small_angle(across, along),
            gradient: [north / squared, -east / squared],
        })
    }

    fn merged(&self, later: &Self, mean: impl Fn(f64, f64) -> f64) -> Self {
        let (sine, cosine) = (mean(self.sine, later.sine), mean(self.cosine, later.cosine));
        let length = sine.hypot(cosine);
        // Opposite directions have no mean; the caller does not merge them, and either is as good as the other.
        let (sine, cosine) = match length > 0.0 {
            true => (sine / length, cosine / length),
            false => (self.sine, self.cosine),
        };
        Self {
            platform_m: std::array::from_fn(|axis| mean(self.platform_m[axis], later.platform_m[axis])),
            sine,
            cosine,
        }
    }
}

impl Hyperbola {
    /// Whether the line is of the same receivers.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.receivers_m == other.receivers_m
            && self.heights_m == other.heights_m
            && self.clocks.numbers == other.clocks.numbers
    }

    fn merged(&self, later: &Self, mean: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            difference_m: mean(self.difference_m, later.difference_m),
            clocks: PairOfClocks {
                ahead_m: mean(self.clocks.ahead_m, later.clocks.ahead_m),
                information: self.clocks.information + later.clocks.information,
                ..self.clocks
            },
            ..*self
        }
    }

    fn residual(&self, position_m: [f64; 2]) -> Option<Residual> {
        let mut residual = Residual {
            innovation_rad: self.difference_m,
            gradient: [0.0; 2],
        };
        for (receiver, sign) in [1.0, -1.0].into_iter().enumerate() {
            let east = position_m[0] - self.receivers_m[receiver][0];
            let north = position_m[1] - self.receivers_m[receiver][1];
            let height = self.heights_m[receiver];
            let squared = east * east + north * north + height * height;
            if squared.is_nan() || squared < OVERHEAD_M * OVERHEAD_M {
                return None;
            }
            let range = squared.sqrt();
            residual.innovation_rad -= sign * range;
            residual.gradient[0] += sign * east / range;
            residual.gradient[1] += sign * north / range;
        }
        Some(residual)
    }
}

impl Straight {
    fn residual(&self, position_m: [f64; 2]) -> Residual {
        let [east, north] = self.along;
        Residual {
            innovation_rad: east * (self.fix_m[0] - position_m[0]) + north * (self.fix_m[1] - position_m[1]),
            gradient: self.along,
        }
    }
}

kept!(Ray {
    platform_m: [f64; 2],
    sine: f64,
    cosine: f64,
});

/// Numbers of a [`Shape`], kept in as many words.
const NUMBERS: usize = 12;

impl Kept for Shape {
    const WORDS: usize = 1 + NUMBERS;

    fn put(&self, to: &mut Put<'_>) {
        let (kind, numbers) = match self {
            Self::Ray(ray) => {
                let [east, north] = ray.platform_m;
                (
                    0,
                    [
                        east, north, ray.sine, ray.cosine, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
                    ],
                )
            }
            Self::Hyperbola(hyperbola) => {
                let [[a, b], [c, d]] = hyperbola.receivers_m;
                let [one, other] = hyperbola.heights_m;
                let PairOfClocks {
                    numbers,
                    ahead_m,
                    information,
                    share,
                } = hyperbola.clocks;
                let [first, second] = numbers.map(f64::from);
                let difference_m = hyperbola.difference_m;
                let clocks = [first, second, ahead_m, information, share];
                let [e, f, g, h, i] = clocks;
                (1, [a, b, c, d, one, other, difference_m, e, f, g, h, i])
            }
            Self::Straight(straight) => {
                let ([a, b], [c, d]) = (straight.fix_m, straight.along);
                (2, [a, b, c, d, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
            }
        };
        to.word(kind);
        numbers.put(to);
    }

    fn get(from: &mut Get<'_>) -> Option<Self> {
        let kind = from.word()?;
        let [a, b, c, d, e, f, g, first, second, ahead_m, information, share] = <[f64; NUMBERS]>::get(from)?;
        match kind {
            0 => Some(Self::Ray(Ray {
                platform_m: [a, b],
                sine: c,
                cosine: d,
            })),
            1 => Some(Self::Hyperbola(Hyperbola {
                receivers_m: [[a, b], [c, d]],
                heights_m: [e, f],
                difference_m: g,
                clocks: PairOfClocks {
                    numbers: [first as u16, second as u16],
                    ahead_m,
                    information,
                    share,
                },
            })),
            2 => Some(Self::Straight(Straight {
                fix_m: [a, b],
                along: [c, d],
            })),
            _ => None,
        }
    }
}

fn squared_distance_m2(one: [f64; 2], other: [f64; 2]) -> f64 {
    let [east, north]: [f64; 2] = std::array::from_fn(|axis| other[axis] - one[axis]);
    east * east + north * north
}

/// Returns the angle with the tangent `across / along`; nearly all angles are small, and then a few terms of the
/// series are exact to a millionth of a degree.
fn small_angle(across: f64, along: f64) -> f64 {
    let tangent = across / along;
    if along > 0.0 && tangent.abs() < 0.125 {
        let square = tangent * tangent;
        tangent * (1.0 - square * (1.0 / 3.0 - square * (0.2 - square * (1.0 / 7.0 - square / 9.0))))
    } else {
        across.atan2(along)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn line(bearing_rad: f64) -> LineOfBearing {
        LineOfBearing::new(&Bearing {
            time_of_measurement_ns: 0,
            emitter_id: None,
            bearing_rad,
            sigma_rad: 0.1,
            platform_m: [10.0, 20.0, 30.0],
            heading_rad: None,
            frequency_hz: None,
            pulse_interval_s: None,
        })
    }

    #[test]
    fn residuals_are_differences_of_angles_whatever_the_turn() {
        for (bearing, truth) in [
            (0.3, 0.31),
            (3.1, -3.1),
            (-FRAC_PI_2, 2.0),
            (0.01, 6.2),
            (1.0, 1.0 + 0.9 * PI),
        ] {
            let place = [10.0 + 500.0 * f64::sin(truth), 20.0 + 500.0 * f64::cos(truth)];
            let found = line(bearing).residual(place).unwrap();
            let mut expected: f64 = bearing - truth;
            expected -= 2.0 * PI * (expected / (2.0 * PI)).round();
            assert!((found.innovation_rad - expected).abs() < 1e-9, "{bearing} {truth}");
            // The gradient equals that of the expected bearing.
            for axis in 0..2 {
                let mut moved = place;
                moved[axis] += 0.01;
                let change = found.innovation_rad - line(bearing).residual(moved).unwrap().innovation_rad;
                assert!((change / 0.01 - found.gradient[axis]).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn the_lines_of_a_fix_have_its_covariance() {
        for covariance_m2 in [
            [400.0, 0.0, 100.0],
            [100.0, 0.0, 400.0],
            [300.0, -150.0, 200.0],
            [9.0, 0.0, 9.0],
        ] {
            let fix = ReadyFix {
                time_of_measurement_ns: 7,
                emitter_id: 1,
                position_m: [1e3, -2e3, 0.0],
                covariance_m2,
            };
            let lines = LineOfBearing::of_fix(&fix).unwrap();
            let mut information = [0.0; 3];
            for line in lines {
                let residual = line.residual([1e3, -2e3]).unwrap();
                assert_eq!(residual.innovation_rad, 0.0);
                let [east, north] = residual.gradient;
                for (sum, product) in information.iter_mut().zip([east * east, east * north, north * north]) {
                    *sum += line.information * product;
                }
            }
            let [xx, xy, yy] = covariance_m2;
            let determinant = xx * yy - xy * xy;
            for (found, expected) in information.iter().zip([yy, -xy, xx]) {
                assert!(
                    (found - expected / determinant).abs() < 1e-12,
                    "{covariance_m2:?} {information:?}"
                );
            }
        }
        let flat = ReadyFix {
            time_of_measurement_ns: 7,
            emitter_id: 1,
            position_m: [0.0; 3],
            covariance_m2: [1.0, 1.0, 1.0],
        };
        assert!(LineOfBearing::of_fix(&flat).is_none());
    }

    #[test]
    fn hyperbolas_are_kept_to_the_last_bit_and_corrected_by_clocks() {
        let mut line = LineOfBearing {
            shape: Shape::Hyperbola(Hyperbola {
                receivers_m: [[0.0, 1.0], [2.0, 3.0]],
                heights_m: [4.0, 5.0],
                difference_m: 70.0,
                clocks: PairOfClocks {
                    numbers: [1, 3],
                    ahead_m: 10.0,
                    information: 0.25,
                    share: 1.0,
                },
            }),
            ..LineOfBearing::NONE
        };
        let mut words = [0; LineOfBearing::WORDS];
        line.put(&mut Put::new(&mut words));
        assert_eq!(LineOfBearing::get(&mut Get(&words)), Some(line));
        line.set_clocks(30.0, 12.0, 0.25);
        let Shape::Hyperbola(hyperbola) = line.shape else {
            panic!()
        };
        assert_eq!((hyperbola.difference_m, line.information), (50.0, 1.0 / 16.0));
    }

    #[test]
    fn an_emitter_at_the_platform_has_no_direction() {
        assert!(line(1.0).residual([10.5, 20.0]).is_none());
        assert!(line(1.0).residual([f64::NAN, 20.0]).is_none());
    }
}
