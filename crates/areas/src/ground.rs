//! The ground in the plane of the system frame.

use frames::{Geodetic, SystemFrame};

use crate::AreaError;

/// Longest part of a side, metres. A part is straight in the plane instead of in longitude and latitude: it deviates by
/// 2 m at latitude 45°.
const PART_M: f64 = 10_000.0;
/// Greatest deviation of a part of a circle from the circle, metres.
const SAGITTA_M: f64 = 1.0;
/// Most parts of a circle.
const PARTS_MAX: f64 = 2000.0;
/// Mean radius of the Earth, metres.
const EARTH_M: f64 = 6_371_000.0;
/// How deep below the plane a place may lie, metres: 60 degrees of arc from the origin.
const DEPTH_MAX_M: f64 = 0.5 * EARTH_M;

/// The ground about the origin of a system frame.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    frame: SystemFrame,
}

/// Longitude and latitude, degrees.
pub(crate) type Degrees = [f64; 2];

/// The place on the ground below a position, east and north in the frame, metres.
pub fn below(frame: &SystemFrame, position_m: [f64; 3]) -> [f64; 2] {
    let place = frame.to_geodetic(position_m);
    let [east, north, _] = Geodetic::from_degrees(place.latitude_deg(), place.longitude_deg(), 0.0)
        .map_or(position_m, |ground| frame.to_local(ground));
    [east, north]
}

impl Ground {
    /// Of a frame.
    pub fn of(frame: SystemFrame) -> Self {
        Self { frame }
    }

    /// East and north of a place, metres.
    ///
    /// # Errors
    /// If it is no place, or too far from the origin.
    pub(crate) fn place(&self, [longitude_deg, latitude_deg]: Degrees) -> Result<[f64; 2], AreaError> {
        let faulty = |fault: &dyn std::fmt::Display| {
            AreaError(format!(
                "[{longitude_deg}, {latitude_deg}] is no position: {fault}; write [longitude, latitude] in degrees"
            ))
        };
        if !(-360.0..=360.0).contains(&longitude_deg) {
            return Err(faulty(&"the longitude is beyond ±360"));
        }
        let longitude_deg = (longitude_deg + 540.0).rem_euclid(360.0) - 180.0;
        let place = Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).map_err(|error| faulty(&error))?;
        let [east, north, up] = self.frame.to_local(place);
        match up < -DEPTH_MAX_M {
            true => Err(AreaError(format!(
                "[{longitude_deg}, {latitude_deg}] is more than 60 degrees of arc from the origin of the frame"
            ))),
            false => Ok([east, north]),
        }
    }

    /// A ring of corners, the last of which is followed by the first. Sides go the short way round the Earth.
    pub(crate) fn ring(&self, corners: &[Degrees]) -> Result<Vec<[f64; 2]>, AreaError> {
        let mut ring = Vec::new();
        for (corner, next) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let from_m = self.place(*corner)?;
            let to_m = self.place(*next)?;
            let east_deg = (next[0] - corner[0] + 540.0).rem_euclid(360.0) - 180.0;
            let north_deg = next[1] - corner[1];
            let parts = ((to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]) / PART_M)
                .ceil()
                .max(1.0);
            ring.push(from_m);
            for part in 1..parts as usize {
                let share = part as f64 / parts;
                let longitude_deg = corner[0] + share * east_deg;
                ring.push(self.place([
                    (longitude_deg + 540.0).rem_euclid(360.0) - 180.0,
                    corner[1] + share * north_deg,
                ])?);
            }
        }
        Ok(ring)
    }

    /// Part of a circle about a place, from one angle to another, clockwise from north, radians; the second angle is
    /// the greater one for a part that goes clockwise.
    pub(crate) fn arc(&self, centre: Degrees, radius_m: f64, [from, to]: [f64; 2]) -> Result<Vec<Degrees>, AreaError> {
        if !(radius_m > 0.0 && radius_m < 0.5 * EARTH_M) {
            return Err(AreaError(format!(
                "a radius of {radius_m} m; it is above 0 and at most half of the Earth's"
            )));
        }
        self.place(centre)?;
        let [longitude_deg, latitude_deg] = centre;
        let middle =
            Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).map_err(|error| AreaError(error.to_string()))?;
        let about = SystemFrame::at(middle);
        let angle = radius_m / EARTH_M;
        let (across_m, up_m) = (EARTH_M * angle.sin(), EARTH_M * (angle.cos() - 1.0));
        let step =
            (2.0 * (1.0 - SAGITTA_M / radius_m.max(2.0 * SAGITTA_M)).acos()).max(std::f64::consts::TAU / PARTS_MAX);
        let parts = ((to - from).abs() / step).ceil().max(3.0);
        let place = |part: usize| {
            let (sin, cos) = (from + (to - from) * part as f64 / parts).sin_cos();
            let place = about.to_geodetic([across_m * sin, across_m * cos, up_m]);
            [place.longitude_deg(), place.latitude_deg()]
        };
        Ok((0..=parts as usize).map(place).collect())
    }

    /// Angle clockwise from north, radians, and distance, metres, under which a place is seen from another.
    pub(crate) fn seen(&self, from: Degrees, place: Degrees) -> Result<[f64; 2], AreaError> {
        let geodetic = |[longitude_deg, latitude_deg]: Degrees| {
            Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).map_err(|error| AreaError(error.to_string()))
        };
        let [east, north, _] = SystemFrame::at(geodetic(from)?).to_local(geodetic(place)?);
        let distance_m = EARTH_M * (east.hypot(north) / EARTH_M).min(1.0).asin();
        Ok([east.atan2(north), distance_m])
    }

    /// A circle about a place, with its radius in metres.
    pub(crate) fn circle(&self, centre: Degrees, radius_m: f64) -> Result<Vec<Degrees>, AreaError> {
        let mut places = self.arc(centre, radius_m, [0.0, std::f64::consts::TAU])?;
        places.pop();
        Ok(places)
    }
}
