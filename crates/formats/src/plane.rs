//! Places in degrees or metres, as places in the plane of a run.
//!
//! Trackers and locators compute in the metres of one plane. A table in degrees is placed in it row by row: positions
//! by the system frame, directions by the horizon and the true north of the place from which they were measured. The
//! origin of the plane is given, or it is the first place; two tables in degrees then have it in common.
//!
//! Limits: a place without a height is taken for one on the ellipsoid.

use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};
use frames::{Geodetic, SystemFrame};
use messages::admission::POSITION_MAX_M;

use crate::columns::ColumnPlace;
use crate::rows::RowReader;

/// The plane of a run.
#[derive(Clone, Copy, Debug, Default)]
pub enum Plane {
    /// No place has come.
    #[default]
    Open,
    /// Places are in metres, with an unknown origin.
    Metres,
    /// The origin is given.
    Given(SystemFrame),
    /// The first place in degrees is the origin, at height 0; with its line from 1.
    FirstPlace(SystemFrame, Geodetic, u64),
}

impl Plane {
    /// The frame of the plane, as far as its origin is known.
    pub fn frame(&self) -> Option<SystemFrame> {
        match self {
            Self::Open | Self::Metres => None,
            Self::Given(frame) | Self::FirstPlace(frame, ..) => Some(*frame),
        }
    }

    /// Takes note of a place in metres.
    pub(crate) fn take_metres(&mut self, row: Cells<'_>, column: Column) -> Result<(), CsvError> {
        match self {
            Self::FirstPlace(..) => Err(row.error(
                column,
                "is in metres, rows before in degrees; give --origin, from which the metres count",
            )),
            Self::Open => {
                *self = Self::Metres;
                Ok(())
            }
            Self::Metres | Self::Given(_) => Ok(()),
        }
    }

    /// The frame for a place in degrees.
    fn frame_of(&mut self, row: Cells<'_>, column: Column, place: Geodetic) -> Result<SystemFrame, CsvError> {
        match self {
            Self::Given(frame) | Self::FirstPlace(frame, ..) => Ok(*frame),
            Self::Open => {
                let origin = Geodetic::from_degrees(place.latitude_deg(), place.longitude_deg(), 0.0);
                let origin = origin.map_err(|error| row.error(column, error))?;
                let frame = SystemFrame::at(origin);
                *self = Self::FirstPlace(frame, origin, row.line());
                Ok(frame)
            }
            Self::Metres => Err(row.error(
                column,
                "is in degrees, rows before in metres; give --origin, from which the metres count",
            )),
        }
    }
}

/// The columns of a table whose places are in a plane.
pub trait InPlane {
    /// The plane.
    fn plane(&mut self) -> &mut Plane;
}

impl<R: Read, C: InPlane> RowReader<R, C> {
    /// Places what is in degrees in this plane.
    #[must_use]
    pub fn placed_in(mut self, plane: Plane) -> Self {
        *self.plane() = plane;
        self
    }

    /// The plane of the places in degrees: open, unless another is put in.
    pub fn plane(&mut self) -> &mut Plane {
        self.columns.plane()
    }
}

/// A place in the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// Metres east, north and up.
    pub(crate) position_m: [f64; 3],
    /// Whether the height is known.
    pub(crate) has_height: bool,
    /// East, north and up at the place, in the frame; `None` at a place in metres, whose axes are those of the frame.
    axes: Option<[[f64; 3]; 3]>,
}

impl Placed {
    /// Turns a vector from the horizon of the place into the frame.
    pub(crate) fn in_frame(&self, vector: [f64; 3]) -> [f64; 3] {
        match self.axes {
            None => vector,
            Some(axes) => [0, 1, 2].map(|part| (0..3).map(|axis| vector[axis] * axes[axis][part]).sum()),
        }
    }

    /// Turns a direction at the place (radians clockwise from north, above the horizontal) into the frame.
    pub(crate) fn direction(&self, [bearing, elevation]: [f64; 2]) -> [f64; 2] {
        if self.axes.is_none() {
            return [bearing, elevation];
        }
        let ((sine, cosine), level) = (bearing.sin_cos(), elevation.cos());
        let [east, north, up] = self.in_frame([level * sine, level * cosine, elevation.sin()]);
        [east.atan2(north), up.atan2(east.hypot(north))]
    }
}

/// Columns of a target's position.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Positions {
    /// Latitude and longitude.
    Degrees([Column; 2]),
    /// East and north in the system frame, and up if known.
    Metres([Column; 2], Option<Column>),
}

impl Positions {
    /// Finds the columns; `None` if the table states no position.
    ///
    /// # Errors
    /// If a part of a position is missing, or degrees stand beside metres.
    pub(crate) fn find<R: Read>(table: &Table<R>) -> Result<Option<Self>, CsvError> {
        let degrees = [table.of_quantity("latitude")?, table.of_quantity("longitude")?];
        let metres = [table.of_quantity("x")?, table.of_quantity("y")?];
        match (degrees, metres) {
            ([None, None], [None, None]) => Ok(None),
            ([None, None], [Some(east), Some(north)]) => Ok(Some(Self::Metres([east, north], table.of_quantity("z")?))),
            ([None, None], [Some(_), None]) => Err(table.missing("y")),
            ([None, None], [None, Some(_)]) => Err(table.missing("x")),
            ([Some(latitude), Some(longitude)], [None, None]) => Ok(Some(Self::Degrees([latitude, longitude]))),
            ([_, None], [None, None]) => Err(table.missing("longitude")),
            ([None, _], [None, None]) => Err(table.missing("latitude")),
            ([Some(first), _] | [_, Some(first)], [Some(second), _] | [_, Some(second)]) => {
                let fault = "both state the position; leave out degrees or metres";
                Err(table.clash(first, second, fault))
            }
        }
    }

    /// The place of a row; in degrees, at a height above the ellipsoid in metres.
    pub(crate) fn read(&self, row: Cells<'_>, height_m: Option<f64>, plane: &mut Plane) -> Result<Placed, CsvError> {
        match *self {
            Self::Metres(columns, up) => {
                let [east, north] = both(row, columns)?;
                if let Some(place) = [east, north].iter().position(|part| part.abs() > POSITION_MAX_M) {
                    let reason = "is farther away than anything on the Earth; write metres";
                    return Err(row.error(columns[place], reason));
                }
                let up = limited(row, up, POSITION_MAX_M)?;
                plane.take_metres(row, columns[0])?;
                Ok(Placed {
                    position_m: [east, north, up.unwrap_or_default()],
                    has_height: up.is_some(),
                    axes: None,
                })
            }
            Self::Degrees(columns) => in_degrees(row, columns, height_m, plane),
        }
    }
}

/// Columns of the place of a sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SensorPlaces {
    /// Latitude and longitude, and the height above the ellipsoid.
    Degrees([Column; 2], Option<Column>),
    /// East, north and up in the system frame.
    Metres([Column; 3]),
}

impl SensorPlaces {
    /// Names of the columns in metres.
    pub(crate) const METRES: [&'static str; 3] = ["px", "py", "pz"];

    /// Finds the columns. With `is_own`, a latitude and a longitude without a word before them are those of the sensor,
    /// because the table states no position of a target.
    ///
    /// # Errors
    /// If a part of the place is missing.
    pub(crate) fn of_table<R: Read>(table: &Table<R>, is_own: bool) -> Result<Self, CsvError> {
        let own = |of_sensor, plain| match table.optional(of_sensor)? {
            None if is_own => table.optional(plain),
            found => Ok(found),
        };
        let degrees = [
            own("sensor_latitude", "latitude")?,
            own("sensor_longitude", "longitude")?,
        ];
        match (table.optional(Self::METRES[0])?, degrees) {
            (None, [Some(latitude), Some(longitude)]) => {
                let height = own("sensor_height_m", "altitude_m")?;
                Ok(Self::Degrees([latitude, longitude], height))
            }
            (None, [Some(_), None]) => Err(table.missing("sensor_longitude")),
            (None, [None, Some(_)]) => Err(table.missing("sensor_latitude")),
            _ => table.all(Self::METRES).map(Self::Metres),
        }
    }

    /// The place of a row.
    pub(crate) fn read(&self, row: Cells<'_>, plane: &mut Plane) -> Result<Placed, CsvError> {
        match *self {
            Self::Metres(columns) => {
                let position_m = row.numbers(columns)?;
                plane.take_metres(row, columns[0])?;
                Ok(Placed {
                    position_m,
                    has_height: true,
                    axes: None,
                })
            }
            Self::Degrees(columns, height) => in_degrees(row, columns, row.number_or_empty(height)?, plane),
        }
    }
}

/// The place of the sensor in a table without targets.
impl ColumnPlace<[&'static str; 3]> for SensorPlaces {
    fn find<R: Read>(table: &Table<R>, _: [&'static str; 3]) -> Result<Self, CsvError> {
        Self::of_table(table, true)
    }
}

fn in_degrees(
    row: Cells<'_>,
    columns: [Column; 2],
    height_m: Option<f64>,
    plane: &mut Plane,
) -> Result<Placed, CsvError> {
    let place = place(row, columns, height_m.unwrap_or_default())?;
    let frame = plane.frame_of(row, columns[0], place)?;
    let position_m = frame.to_local(place);
    Ok(Placed {
        position_m,
        has_height: height_m.is_some(),
        axes: Some(frame.axes(position_m)),
    })
}

/// A value of at most `max` to either side of 0, which no target exceeds.
pub(crate) fn limited(row: Cells<'_>, column: Option<Column>, max: f64) -> Result<Option<f64>, CsvError> {
    match (column, row.number_or_empty(column)?) {
        (Some(column), Some(value)) if value.abs() > max => {
            let reason = "is beyond what any target does; leave the value empty where it is unknown";
            Err(row.error(column, reason))
        }
        (_, value) => Ok(value),
    }
}

/// Two numbers that a row must have.
fn both(row: Cells<'_>, columns: [Column; 2]) -> Result<[f64; 2], CsvError> {
    let mut values = [0.0; 2];
    for (value, column) in values.iter_mut().zip(columns) {
        let found = row.number_or_empty(column)?;
        *value = found.ok_or_else(|| row.error(column, "states no position; leave the row out"))?;
    }
    Ok(values)
}

/// The place of a row on the Earth, at a height in metres.
pub(crate) fn place(row: Cells<'_>, columns: [Column; 2], height_m: f64) -> Result<Geodetic, CsvError> {
    let [latitude, longitude] = both(row, columns)?;
    if latitude == 0.0 && longitude == 0.0 {
        let reason = "is latitude 0, longitude 0, as of a receiver without a fix; leave the row out";
        return Err(row.error(columns[0], reason));
    }
    Geodetic::from_degrees(latitude, longitude, height_m).map_err(|error| {
        let column = match error {
            frames::GeodeticError::Longitude(_) => columns[1],
            _ => columns[0],
        };
        let reason = format!("gives no place: {error}; write degrees, or leave the row out");
        row.error(column, reason)
    })
}

#[cfg(test)]
#[path = "plane_tests.rs"]
mod tests;
