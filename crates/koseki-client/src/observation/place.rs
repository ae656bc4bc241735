//! A place in degrees or in metres to metres of the system frame.

use frames::{Geodetic, SystemFrame};
use messages::admission::{Fault, REACH_M};

use super::{fault, missing};

/// The fields of a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Begin of the names of the fields.
    pub(super) prefix: &'static str,
    /// Latitude and longitude, degrees, and height above the ellipsoid, metres.
    pub(super) degrees: [Option<f64>; 3],
    /// Metres east, north and up in the system frame.
    pub(super) metres: [Option<f64>; 3],
}

/// A position in the system frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    /// Metres east, north and up; of a place without a height, that of the ellipsoid.
    pub(super) position_m: [f64; 3],
    /// Whether the height is known.
    pub(super) has_height: bool,
    /// Whether the place was stated in degrees.
    pub(super) is_geographic: bool,
}

impl Placed {
    /// Turns a direction from here (radians: clockwise from north, above the horizontal) into a direction of the system
    /// frame. At a place in degrees, north and the horizontal are those of the place.
    pub(super) fn direction(&self, frame: &SystemFrame, [bearing, elevation]: [f64; 2]) -> [f64; 2] {
        if !self.is_geographic {
            return [bearing, elevation];
        }
        let parts = [
            elevation.cos() * bearing.sin(),
            elevation.cos() * bearing.cos(),
            elevation.sin(),
        ];
        let axes = frame.axes(self.position_m);
        let [east, north, up] = [0, 1, 2].map(|axis| (0..3).map(|part| parts[part] * axes[part][axis]).sum::<f64>());
        [east.atan2(north), up.atan2(east.hypot(north))]
    }
}

impl Place {
    /// Returns the position; `None` if no field is stated.
    pub(super) fn placed(self, frame: &SystemFrame) -> Result<Option<Placed>, Fault> {
        let name = |name: &str| format!("{}{name}", self.prefix);
        let placed = match (self.degrees, self.metres) {
            ([None, None, None], [None, None, None]) => Ok(None),
            ([None, None, None], metres) => self.of_metres(metres).map(Some),
            ([Some(latitude), Some(longitude), height_m], [None, None, None]) => {
                self.of_degrees(latitude, longitude, height_m, frame).map(Some)
            }
            ([None, None, Some(_)], [None, None, None]) => Err(missing(&name("latitude"), "a height needs a place")),
            ([None, ..], [None, None, None]) => Err(missing(&name("latitude"), "give both latitude and longitude")),
            (_, [None, None, None]) => Err(missing(&name("longitude"), "give both latitude and longitude")),
            (_, [east, ..]) => {
                let limit = "must not stand beside latitude, longitude and height_m";
                let value = east.map_or_else(|| "missing".to_owned(), |east| east.to_string());
                Err(fault(&name("east_m"), value, limit, "leave one of the two forms out"))
            }
        };
        match placed? {
            Some(placed) => self.within_reach(placed).map(Some),
            None => Ok(None),
        }
    }

    fn within_reach(self, placed: Placed) -> Result<Placed, Fault> {
        let [east, north, up] = placed.position_m;
        let distance_m = east.hypot(north).hypot(up);
        // A value that is no number has a fault of its own.
        if !distance_m.is_finite() || distance_m <= REACH_M {
            return Ok(placed);
        }
        let ([first, second, _], names) = match placed.is_geographic {
            true => (self.degrees.map(Option::unwrap_or_default), ["latitude", "longitude"]),
            false => ([east, north, up], ["east_m", "north_m"]),
        };
        let limit = format!(
            "with {}{} {second} it is {:.0} km from the origin of the system frame, and must be at most {:.0} km",
            self.prefix,
            names[1],
            distance_m / 1e3,
            REACH_M / 1e3
        );
        let remedy = "leave out places that are not known; check the unit, and [frame] of the configuration";
        Err(fault(&format!("{}{}", self.prefix, names[0]), first, &limit, remedy))
    }

    fn of_metres(self, [east, north, up]: [Option<f64>; 3]) -> Result<Placed, Fault> {
        let needed = |value: Option<f64>, name: &str| {
            value.ok_or_else(|| missing(&format!("{}{name}", self.prefix), "give both east_m and north_m"))
        };
        Ok(Placed {
            position_m: [
                needed(east, "east_m")?,
                needed(north, "north_m")?,
                up.unwrap_or_default(),
            ],
            has_height: up.is_some(),
            is_geographic: false,
        })
    }

    fn of_degrees(
        self,
        latitude: f64,
        longitude: f64,
        height_m: Option<f64>,
        frame: &SystemFrame,
    ) -> Result<Placed, Fault> {
        check_degrees(self.prefix, latitude, longitude)?;
        let place = Geodetic::from_degrees(latitude, longitude, height_m.unwrap_or_default());
        let place = place.map_err(|error| {
            let name = format!("{}height_m", self.prefix);
            fault(&name, height_m.unwrap_or_default(), &error.to_string(), "give metres")
        })?;
        Ok(Placed {
            position_m: frame.to_local(place),
            has_height: height_m.is_some(),
            is_geographic: true,
        })
    }
}

fn check_degrees(prefix: &str, latitude: f64, longitude: f64) -> Result<(), Fault> {
    // Not a number is within no limit.
    let (is_latitude, is_longitude) = (latitude.abs() <= 90.0, longitude.abs() <= 180.0);
    if is_latitude && is_longitude {
        return Ok(());
    }
    let remedy = match () {
        () if !is_latitude && latitude.abs() <= 180.0 && longitude.abs() <= 90.0 => {
            "latitude and longitude are exchanged"
        }
        () if latitude.abs() > 360.0 || longitude.abs() > 360.0 => "give metres of the system frame as position_m",
        () => "give degrees, north and east positive",
    };
    let (name, value, limit) = match is_latitude {
        false => ("latitude", latitude, "must be from -90 to 90 degrees"),
        true => ("longitude", longitude, "must be from -180 to 180 degrees"),
    };
    Err(fault(&format!("{prefix}{name}"), value, limit, remedy))
}
