//! Latitude and longitude to the system frame and back.

use std::fmt;

use sguaba::math::RigidBodyTransform;
use sguaba::systems::{Ecef, Wgs84};
use sguaba::{Coordinate, coordinate, system};
use uom::si::angle::{degree, radian};
use uom::si::f64::{Angle, Length};
use uom::si::length::meter;

system!(pub(crate) struct SystemEnu using ENU);

/// Metres in a hundred feet.
const HUNDRED_FEET_M: f64 = 30.48;

/// A place on or above the WGS-84 ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    wgs84: Wgs84,
}

/// A latitude, longitude or height that no place has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GeodeticError {
    /// Latitude outside ±90°, in degrees.
    Latitude(f64),
    /// Longitude outside ±180°, in degrees.
    Longitude(f64),
    /// Height that is not a number, or farther than 100 km from the ellipsoid, in metres.
    Height(f64),
}

impl fmt::Display for GeodeticError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Latitude(value) => write!(f, "latitude {value}° is not between -90° and 90°"),
            Self::Longitude(value) => write!(f, "longitude {value}° is not between -180° and 180°"),
            Self::Height(value) => write!(f, "height {value} m is not between -100 km and 100 km"),
        }
    }
}

impl std::error::Error for GeodeticError {}

impl Geodetic {
    /// A place from degrees and metres above the ellipsoid.
    ///
    /// # Errors
    /// If a value is not finite or outside the range on Earth.
    pub fn from_degrees(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Result<Self, GeodeticError> {
        // Written so that NaN fails too.
        if !(-90.0..=90.0).contains(&latitude_deg) {
            return Err(GeodeticError::Latitude(latitude_deg));
        }
        if !(-180.0..=180.0).contains(&longitude_deg) {
            return Err(GeodeticError::Longitude(longitude_deg));
        }
        if !(-1e5..=1e5).contains(&height_m) {
            return Err(GeodeticError::Height(height_m));
        }
        let wgs84 = Wgs84::builder()
            .latitude(Angle::new::<degree>(latitude_deg))
            .ok_or(GeodeticError::Latitude(latitude_deg))?
            .longitude(Angle::new::<degree>(longitude_deg))
            .altitude(Length::new::<meter>(height_m))
            .build();
        Ok(Self { wgs84 })
    }

    /// Latitude, degrees, north positive.
    pub fn latitude_deg(&self) -> f64 {
        self.wgs84.latitude().get::<radian>().to_degrees()
    }

    /// Longitude, degrees, east positive.
    pub fn longitude_deg(&self) -> f64 {
        self.wgs84.longitude().get::<radian>().to_degrees()
    }

    /// Height above the ellipsoid, metres.
    pub fn height_m(&self) -> f64 {
        self.wgs84.altitude().get::<meter>()
    }

    /// Height in hundreds of feet: the flight level, where heights are pressure altitudes.
    pub fn flight_level(&self) -> f64 {
        self.height_m() / HUNDRED_FEET_M
    }

    pub(crate) fn wgs84(&self) -> &Wgs84 {
        &self.wgs84
    }
}

/// The one frame of all kinematics inside the pipeline: East-North-Up, tangent to WGS-84 at its origin.
#[derive(Clone, Copy, Debug)]
pub struct SystemFrame {
    from_ecef: RigidBodyTransform<Ecef, SystemEnu>,
}

impl SystemFrame {
    /// Makes the frame with the origin `origin`.
    pub fn at(origin: Geodetic) -> Self {
        // SAFETY: `SystemEnu` is, by definition, the tangent frame at this origin, and only this type can hold one.
        let from_ecef = unsafe { RigidBodyTransform::ecef_to_enu_at(origin.wgs84()) };
        Self { from_ecef }
    }

    /// East, north, up of `place`, metres.
    pub fn to_local(&self, place: Geodetic) -> [f64; 3] {
        metres(&self.from_ecef.transform(Coordinate::<Ecef>::from_wgs84(place.wgs84())))
    }

    /// The place at `east, north, up`, metres.
    pub fn to_geodetic(&self, [east, north, up]: [f64; 3]) -> Geodetic {
        let local = coordinate!(
            e = Length::new::<meter>(east),
            n = Length::new::<meter>(north),
            u = Length::new::<meter>(up);
            in SystemEnu
        );
        Geodetic {
            wgs84: self.from_ecef.inverse_transform(local).to_wgs84(),
        }
    }

    /// Vertical motion of a position (m) with a velocity (m/s), both east, north and up of this frame.
    pub fn vertical(&self, position_m: [f64; 3], velocity_mps: [f64; 3]) -> Vertical {
        let (height_m, up) = self.upward(position_m);
        let climb = up.iter().zip(velocity_mps).map(|(share, speed)| share * speed);
        Vertical {
            height_m,
            climb_mps: climb.sum(),
        }
    }

    /// Up components of position (m) and velocity (m/s) for a place in the plane (m), a horizontal velocity there
    /// (m/s), and a height and climb rate above the Earth: the inverse of [`vertical`](Self::vertical).
    pub fn above(&self, [east, north]: [f64; 2], [vx, vy]: [f64; 2], vertical: Vertical) -> [f64; 2] {
        // The height changes almost as the up component does, so each round leaves a thousandth of the error.
        const ROUNDS: usize = 4;
        let mut up = vertical.height_m;
        for _ in 0..ROUNDS {
            up += vertical.height_m - self.to_geodetic([east, north, up]).height_m();
        }
        let (_, axis) = self.upward([east, north, up]);
        [up, (vertical.climb_mps - axis[0] * vx - axis[1] * vy) / axis[2]]
    }

    /// Height above the ellipsoid (m) of a position, and the direction in which it rises there.
    fn upward(&self, position_m: [f64; 3]) -> (f64, [f64; 3]) {
        // Long enough that rounding beside the distance from the Earth's centre has no part in the direction.
        const ARM_M: f64 = 10_000.0;
        let place = self.to_geodetic(position_m);
        let lifted = Wgs84::builder()
            .latitude(place.wgs84.latitude())
            .map(|latitude| {
                latitude
                    .longitude(place.wgs84.longitude())
                    .altitude(place.wgs84.altitude() + Length::new::<meter>(ARM_M))
                    .build()
            })
            .map_or(position_m, |wgs84| self.to_local(Geodetic { wgs84 }));
        let up = std::array::from_fn(|axis| (lifted[axis] - position_m[axis]) / ARM_M);
        (place.height_m(), up)
    }

    /// East, north and up at a position (m), as directions in this frame, a row each: away from the origin they differ
    /// from the frame's axes.
    pub fn axes(&self, position_m: [f64; 3]) -> [[f64; 3]; 3] {
        /// About 111 m, of which rounding has no part.
        const STEP_DEG: f64 = 1e-3;
        let place = self.to_geodetic(position_m);
        let (latitude, height_m) = (place.latitude_deg().clamp(-89.9, 89.9), place.height_m());
        let away = |step_deg: f64| {
            let moved = Geodetic::from_degrees(latitude + step_deg, place.longitude_deg(), height_m);
            moved.map_or(position_m, |moved| self.to_local(moved))
        };
        let north = unit(difference(away(STEP_DEG), away(-STEP_DEG)));
        let raised = Geodetic::from_degrees(latitude, place.longitude_deg(), height_m.min(90e3) + 1e3);
        let up = unit(difference(
            raised.map_or(position_m, |raised| self.to_local(raised)),
            away(0.0),
        ));
        [cross(north, up), north, up]
    }

    pub(crate) fn ecef_to_local(&self) -> &RigidBodyTransform<Ecef, SystemEnu> {
        &self.from_ecef
    }
}

/// Vertical motion over the round Earth. The up component of a system frame is none: at 100 nautical miles from the
/// origin, a level flight is 2.7 km lower in it, and one that leaves the origin sinks by 7 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertical {
    /// Height above the ellipsoid, metres.
    pub height_m: f64,
    /// Rate of that height, metres per second.
    pub climb_mps: f64,
}

/// Change from one system frame into another: a rotation and a shift, since both are at rest on the Earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameChange {
    /// Axes of the one frame in the other, by rows.
    rotation: [[f64; 3]; 3],
    shift_m: [f64; 3],
}

impl FrameChange {
    /// The change from `one` frame into the `other`.
    pub fn between(one: &SystemFrame, other: &SystemFrame) -> Self {
        // An arm so long that the rounding errors through the Earth's centre are negligible.
        const ARM_M: f64 = 1e6;
        let through = |[east, north, up]: [f64; 3]| {
            let local = coordinate!(
                e = Length::new::<meter>(east),
                n = Length::new::<meter>(north),
                u = Length::new::<meter>(up);
                in SystemEnu
            );
            metres(&other.from_ecef.transform(one.from_ecef.inverse_transform(local)))
        };
        let shift_m = through([0.0; 3]);
        let axes = [0, 1, 2].map(|axis| {
            let mut arm = [0.0; 3];
            arm[axis] = ARM_M;
            through(arm)
        });
        let rotation = [0, 1, 2].map(|row| axes.map(|axis| (axis[row] - shift_m[row]) / ARM_M));
        Self { rotation, shift_m }
    }

    /// A direction, a velocity or the like.
    pub fn direction(&self, vector: [f64; 3]) -> [f64; 3] {
        self.rotation
            .map(|row| (0..3).map(|axis| row[axis] * vector[axis]).sum())
    }

    /// A position, metres.
    pub fn position(&self, position_m: [f64; 3]) -> [f64; 3] {
        let turned = self.direction(position_m);
        [0, 1, 2].map(|axis| turned[axis] + self.shift_m[axis])
    }

    /// Axes of the one frame in the other, by rows.
    pub fn rotation(&self) -> &[[f64; 3]; 3] {
        &self.rotation
    }
}

fn difference(one: [f64; 3], other: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| one[axis] - other[axis])
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    vector.map(|part| if length > 0.0 { part / length } else { 0.0 })
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

pub(crate) fn metres(point: &Coordinate<SystemEnu>) -> [f64; 3] {
    [
        point.enu_east().get::<meter>(),
        point.enu_north().get::<meter>(),
        point.enu_up().get::<meter>(),
    ]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn barcelona() -> SystemFrame {
        SystemFrame::at(Geodetic::from_degrees(41.297063, 2.078447, 0.0).unwrap())
    }

    #[test]
    fn a_radar_east_of_the_origin_lies_east() {
        let radar = Geodetic::from_degrees(41.295618, 2.095114, 0.0).unwrap();
        let [east, north, up] = barcelona().to_local(radar);
        // One second of arc of latitude is 30.9 m; of longitude at this latitude 23.2 m.
        assert!((east - 1395.6).abs() < 1.0, "{east}");
        assert!((north + 160.3).abs() < 1.0, "{north}");
        assert!(up.abs() < 0.5, "the Earth falls away by 15 cm over 1.4 km, not {up}");
    }

    #[test]
    fn impossible_places_are_refused_by_name() {
        assert_eq!(
            Geodetic::from_degrees(90.5, 0.0, 0.0),
            Err(GeodeticError::Latitude(90.5))
        );
        assert_eq!(
            Geodetic::from_degrees(0.0, -181.0, 0.0),
            Err(GeodeticError::Longitude(-181.0))
        );
        assert!(matches!(
            Geodetic::from_degrees(0.0, 0.0, f64::NAN),
            Err(GeodeticError::Height(_))
        ));
        assert!(matches!(
            Geodetic::from_degrees(f64::NAN, 0.0, 0.0),
            Err(GeodeticError::Latitude(_))
        ));
    }

    proptest! {
        #[test]
        fn a_change_of_frame_goes_by_the_earth_and_turns_without_stretching(
            latitude in -89.0..89.0f64, longitude in -179.0..179.0f64, away in prop::array::uniform2(-2.0..2.0f64),
            offset in prop::array::uniform3(-2e5..2e5f64),
        ) {
            let frame = |latitude, longitude| SystemFrame::at(Geodetic::from_degrees(latitude, longitude, 50.0).unwrap());
            let (one, other) = (frame(latitude, longitude), frame((latitude + away[0]).clamp(-89.9, 89.9), longitude));
            let change = FrameChange::between(&one, &other);
            let by_place = other.to_local(one.to_geodetic(offset));
            let position = change.position(offset);
            let length = |vector: [f64; 3]| vector.iter().map(|value| value * value).sum::<f64>().sqrt();
            for axis in 0..3 {
                prop_assert!((position[axis] - by_place[axis]).abs() < 1e-4);
            }
            prop_assert!((length(change.direction(offset)) - length(offset)).abs() < 1e-6);
        }

        /// Height and climb are those that the motion of a second has, to 300 km and more from the origin.
        #[test]
        fn vertical_motion_is_that_over_the_ellipsoid(
            east in -400e3..400e3f64, north in -400e3..400e3f64, up in -15e3..12e3f64,
            velocity in prop::array::uniform3(-300.0..300.0f64),
        ) {
            let frame = barcelona();
            let position = [east, north, up];
            let found = frame.vertical(position, velocity);
            let height = |s: f64| frame.to_geodetic([0, 1, 2].map(|axis| position[axis] + s * velocity[axis])).height_m();
            prop_assert_eq!(found.height_m, height(0.0));
            let climb = (height(0.5) - height(-0.5)) / 1.0;
            prop_assert!((found.climb_mps - climb).abs() < 1e-4, "{found:?} {climb}");
            let [vx, vy, up_mps] = velocity;
            let back = frame.above([east, north], [vx, vy], found);
            prop_assert!((back[0] - up).abs() < 1e-3 && (back[1] - up_mps).abs() < 1e-3, "{back:?}");
        }

        #[test]
        fn to_local_and_back_is_the_same_place(
            latitude in -89.0..89.0f64, longitude in -179.0..179.0f64, height in -100.0..20e3f64,
            offset in prop::array::uniform3(-3e5..3e5f64),
        ) {
            let frame = SystemFrame::at(Geodetic::from_degrees(latitude, longitude, height).unwrap());
            let back = frame.to_local(frame.to_geodetic(offset));
            for axis in 0..3 {
                prop_assert!((back[axis] - offset[axis]).abs() < 1e-5);
            }
        }
    }
}
