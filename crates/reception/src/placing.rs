//! A position in the sensor's own terms into the system frame.
//!
//! [`SensorFrame`](frames::SensorFrame) does most of the work. This module chooses the height for the conversion of a
//! radar's slant range to a position on the ground.
//!
//! # Without a height
//!
//! A target that sends no height may be anywhere between the ground and some 12 km. At slant range ρ from a radar at
//! height h₀ its ground range is about g(h) = √(ρ² − (h − h₀)²), shorter than ρ by (h − h₀)²/2ρ: 120 m between ground
//! and 5 km at 100 km, but half of everything at 14 km. One height is assumed for all; the error this makes, if every
//! ground range between g(0) and g(12 km) is as likely as any other, has the mean square
//!
//! > w²/12 + (m − g(hₐ))², w = |g(0) − g(12 km)|, m = (g(0) + g(12 km))/2,
//!
//! which is added to the variance along the line of sight. The default of 5 km is a compromise: targets without
//! height are mostly low, without transponder; fast targets without height are not. Near the radar this height would
//! put targets directly above the radar, outside its beam; therefore the assumed elevation is at most 30°, half the
//! slant range up.
//!
//! A track with a height some seconds ago is still near this height: the earlier height is used, with an additional
//! uncertainty for a possible climb.

use std::fmt;

use frames::Geodetic;
use messages::Counter;

use super::ConversionModel;
use observations::{Plane, Position};

/// Height that hardly any target without a transponder exceeds, metres.
const UNKNOWN_HEIGHT_MAX_M: f64 = 12_000.0;
/// No height is greater, so that no straight distance exceeds that along the ground by more, metres.
const HEIGHT_MAX_M: f64 = 100_000.0;
/// Mean radius of the earth, metres; the scale of a map depends only weakly on the radius.
const EARTH_RADIUS_M: f64 = 6_371_000.0;

/// Knowledge of a target's height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Height {
    /// From the report, metres.
    Known(f64),
    /// From an earlier report of the track.
    Remembered {
        /// Height then, metres.
        height_m: f64,
        /// Error that it may have by now, metres.
        off_m: f64,
    },
    /// Nothing.
    Unknown,
}

impl Height {
    /// Height of the target, metres; `None` if nothing has stated it.
    fn value_m(self) -> Option<f64> {
        match self {
            Self::Known(height_m) | Self::Remembered { height_m, .. } => Some(height_m),
            Self::Unknown => None,
        }
    }

    /// Whether the report states the height.
    pub(crate) fn is_known(self) -> bool {
        matches!(self, Self::Known(_))
    }
}

/// A position in the system frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SystemPosition {
    pub(crate) position_m: [f64; 3],
    /// Slant range of the measurement, if any.
    pub(crate) slant: Option<Slant>,
}

/// A straight distance that was turned into one along the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slant {
    range_m: f64,
    /// Height of the target above the sensor, metres.
    up_m: f64,
    /// Height of the sensor, metres.
    sensor_height_m: f64,
    height: Height,
}

/// A position that no target of the sensor can have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefusedPlace {
    position: Position,
    distance_m: f64,
    range_m: f64,
}

impl RefusedPlace {
    #[cold]
    pub(crate) fn of(model: &ConversionModel, position: Position) -> Self {
        let distance_m = match position {
            Position::Cartesian([x, y], _) => x.hypot(y),
            Position::Polar([range, _]) | Position::Slant([range, _]) => range,
            Position::Geodetic([latitude, longitude]) => {
                let place = Geodetic::from_degrees(latitude.to_degrees(), longitude.to_degrees(), 0.0);
                place.map_or(f64::NAN, |place| distance_m(model, model.system.to_local(place)))
            }
        };
        Self {
            position,
            distance_m,
            range_m: model.limits.range_m,
        }
    }
}

impl fmt::Display for RefusedPlace {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Position::Geodetic([latitude, longitude]) = self.position {
            let (latitude, longitude) = (latitude.to_degrees(), longitude.to_degrees());
            write!(formatter, "latitude {latitude:.4}, longitude {longitude:.4}")?;
        } else {
            write!(formatter, "the position")?;
        }
        let [distance_km, range_km] = [self.distance_m, self.range_m].map(|metres| metres / 1e3);
        if distance_km.is_nan() {
            return write!(formatter, " is no place; correct the sender");
        }
        write!(
            formatter,
            " is {distance_km:.0} km from the sensor; at most limits.range_m, {range_km:.0} km: correct the sender, or \
             raise it"
        )
    }
}

/// Straight distance of a position in the system frame from the sensor, metres.
fn distance_m(model: &ConversionModel, position_m: [f64; 3]) -> f64 {
    let sensor_m = model.frame.cartesian([0.0; 3]);
    let [east, north, up] = [0, 1, 2].map(|axis| position_m[axis] - sensor_m[axis]);
    east.hypot(north).hypot(up)
}

/// Places a position.
pub(crate) fn place(model: &ConversionModel, position: Position, height: Height) -> Result<SystemPosition, Counter> {
    if !is_possible(model, position) {
        return Err(Counter::RejectedPosition);
    }
    let height_m = height.value_m().unwrap_or(model.height_m);
    let above = |offset: [f64; 2]| SystemPosition {
        position_m: model.frame.above(offset, height_m),
        slant: None,
    };
    let mut placed = match position {
        Position::Cartesian(offset, Plane::Tangent) => above(offset),
        Position::Cartesian(offset, Plane::Slant) => slant(model, to_polar(offset), height),
        Position::Cartesian(offset, Plane::Stereographic) => stereographic(model, offset, height_m),
        Position::Polar(polar) => above(to_cartesian(polar)),
        Position::Slant(polar) => slant(model, polar, height),
        Position::Geodetic([latitude, longitude]) => {
            let place = Geodetic::from_degrees(latitude.to_degrees(), longitude.to_degrees(), height_m);
            SystemPosition {
                position_m: model.system.to_local(place.map_err(|_| Counter::RejectedPosition)?),
                slant: None,
            }
        }
    };
    // The other side of the earth is below the sensor, and near it on the plane.
    let is_below = distance_m(model, placed.position_m) > model.limits.range_m + HEIGHT_MAX_M;
    if !height.is_known() {
        placed.position_m[2] = 0.0; // what the report does not say is not passed on
    }
    let [x0, y0] = model.frame.place();
    // Written so that NaN is refused.
    if !is_below && (placed.position_m[0] - x0).hypot(placed.position_m[1] - y0) <= model.limits.range_m {
        Ok(placed)
    } else {
        Err(Counter::RejectedPosition)
    }
}

/// Whether there is any sense in converting a position: numbers that are none, or that no antenna measures, must not
/// get into the geometry.
fn is_possible(model: &ConversionModel, position: Position) -> bool {
    let (distance_m, angle_rad) = match position {
        Position::Cartesian([x, y], _) => (x.hypot(y), 0.0),
        Position::Polar([range, azimuth]) | Position::Slant([range, azimuth]) => (range, azimuth),
        Position::Geodetic(_) => return true, // checked where it is made a place
    };
    (0.0..=model.limits.range_m + HEIGHT_MAX_M).contains(&distance_m) && angle_rad.is_finite()
}

fn slant(model: &ConversionModel, [range_m, azimuth_rad]: [f64; 2], height: Height) -> SystemPosition {
    let half_m = 0.5 * range_m;
    let assumed_m = model
        .assumed_height_m
        .min(model.height_m + half_m)
        .max(model.height_m - half_m);
    let height_m = height.value_m().unwrap_or(assumed_m);
    SystemPosition {
        position_m: model.frame.slant(range_m, azimuth_rad, height_m),
        slant: Some(Slant {
            range_m,
            up_m: height_m - model.height_m,
            sensor_height_m: model.height_m,
            height,
        }),
    }
}

/// On a sphere of radius R, a point at distance d on the map is at the angle c = 2·atan(d/2R) from the centre. The
/// angle gives the slant distance to a target above the point, and thereby the place on the ellipsoid.
fn stereographic(model: &ConversionModel, [x, y]: [f64; 2], height_m: f64) -> SystemPosition {
    let (near, far) = (EARTH_RADIUS_M + model.height_m, EARTH_RADIUS_M + height_m);
    let tangent = x.hypot(y) / (2.0 * EARTH_RADIUS_M);
    let sine_squared = tangent * tangent / (1.0 + tangent * tangent);
    let range_m = ((far - near).powi(2) + 4.0 * near * far * sine_squared).sqrt();
    SystemPosition {
        position_m: model.frame.slant(range_m, x.atan2(y), height_m),
        slant: None,
    }
}

fn to_polar([x, y]: [f64; 2]) -> [f64; 2] {
    [x.hypot(y), x.atan2(y)]
}

fn to_cartesian([range, azimuth]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = azimuth.sin_cos();
    [range * sine, range * cosine]
}

impl Slant {
    /// Whether the height was assumed.
    pub(crate) fn is_assumed(&self) -> bool {
        self.height == Height::Unknown
    }

    /// The straight distance, metres.
    pub(crate) fn range_m(&self) -> f64 {
        self.range_m
    }

    /// Variance of the ground range for a standard deviation of range and height, square metres: by differences, as the
    /// derivatives grow beyond all limits where the target is straight above.
    pub(crate) fn variance_m2(&self, range_sigma_m: f64, height_sigma_m: f64) -> f64 {
        let (range, up) = (self.range_m, self.up_m);
        let by_range = ground_m(range + range_sigma_m, up) - ground_m(range - range_sigma_m, up);
        let by_height = ground_m(range, up + height_sigma_m) - ground_m(range, up - height_sigma_m);
        (by_range * by_range + by_height * by_height) / 4.0
    }

    /// Mean square of the error that a height other than the target's own makes in the ground range, square metres.
    pub(crate) fn height_error_m2(&self) -> f64 {
        let ground_m = |up_m: f64| ground_m(self.range_m, up_m);
        match self.height {
            Height::Known(_) => 0.0,
            Height::Remembered { off_m, .. } => {
                (ground_m(self.up_m + off_m) - ground_m(self.up_m - off_m)).powi(2) / 4.0
            }
            Height::Unknown => {
                let [low, high] = [0.0, UNKNOWN_HEIGHT_MAX_M].map(|height_m| ground_m(height_m - self.sensor_height_m));
                let off = (low + high) / 2.0 - ground_m(self.up_m);
                (low - high).powi(2) / 12.0 + off * off
            }
        }
    }
}

/// Ground range of a target `up_m` above the sensor, on a flat earth.
fn ground_m(range_m: f64, up_m: f64) -> f64 {
    (range_m * range_m - up_m * up_m).max(0.0).sqrt()
}
