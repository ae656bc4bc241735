//! Times and places of two files in common terms.
//!
//! Truth and tracks come from different instruments. One file counts seconds from midnight, the other one from 1970;
//! one has metres in a frame, the other one degrees. A comparison of the numbers as they stand is meaningless and looks
//! like a bad picture. So the second file is read on the basis of the first one:
//!
//! - Times since 1970 become seconds since a midnight. It is the midnight of the first row; if the other file counts
//!   from a midnight, the one that brings the files nearest to each other.
//! - Places in degrees become metres in the frame of the other file. Its origin is given, or follows from a row that
//!   states its place both in metres and in degrees. Two files in degrees share a frame at the first place.
//!
//! Limits: a place without a height is taken for one on the ellipsoid; the covariance of a track in degrees is not
//! turned into the frame.

use csv_table::{Cells, Column, CsvError};
use frames::{Geodetic, SystemFrame};

/// Times that can only be UTC, seconds since 1970: from 1973 to 2103.
const UTC_S: std::ops::RangeInclusive<f64> = 1e8..=4.2e9;
const DAY_S: f64 = 86_400.0;
/// Steps per second to which times since 1970 are rounded: doubles have no finer ones there.
const STEPS: f64 = 1e6;
/// Rounds in which the origin of a frame is found; each leaves a fiftieth of the error.
const ROUNDS: usize = 8;
/// Metres in a flight level.
const FLIGHT_LEVEL_M: f64 = 30.48;

/// What the times and places of a file refer to.
#[derive(Clone, Copy, Debug, Default)]
pub struct FileBasis {
    frame: FrameBasis,
    /// Midnight from which times count, seconds since 1970.
    midnight_s: Option<f64>,
    /// Whether the file has times since 1970; `None` before its first row.
    has_utc: Option<bool>,
    /// First time of the other file, seconds.
    near_s: Option<f64>,
}

/// Frame of the places.
#[derive(Clone, Copy, Debug, Default)]
enum FrameBasis {
    /// No place yet.
    #[default]
    Open,
    /// The frame of x, y, z.
    Known(SystemFrame),
    /// All places are in degrees; this frame was chosen for them.
    Chosen(SystemFrame),
    /// Metres in a frame of unknown origin.
    Unknown,
}

impl FileBasis {
    /// Returns the basis with the given origin of the frame of x, y, z.
    pub fn at(origin: Geodetic) -> Self {
        Self {
            frame: FrameBasis::Known(SystemFrame::at(origin)),
            ..Self::default()
        }
    }

    /// Returns the frame of x, y, z, if its origin is known.
    pub(crate) fn known_frame(&self) -> Option<SystemFrame> {
        match self.frame {
            FrameBasis::Known(frame) | FrameBasis::Chosen(frame) => Some(frame),
            FrameBasis::Open | FrameBasis::Unknown => None,
        }
    }

    /// Returns the basis for the second file, of which the first one begins at `first_s` seconds.
    pub(crate) fn for_another(self, first_s: Option<f64>) -> Self {
        Self {
            has_utc: None,
            near_s: first_s,
            ..self
        }
    }

    /// Returns the time of a row.
    pub(crate) fn time_s(&mut self, row: Cells<'_>, column: Column) -> Result<f64, CsvError> {
        let stated_s = stated_s(row, column)?;
        let is_utc = UTC_S.contains(&stated_s);
        match (*self.has_utc.get_or_insert(is_utc), is_utc) {
            (true, true) => {}
            (true, false) => return Err(row.error(column, "is not in seconds since 1970, as the rows before are")),
            (false, _) if column.is_foreign() => return Ok(stated_s),
            (false, _) => return row.time_s(column),
        }
        let near_s = self.near_s;
        let midnight_s = *self.midnight_s.get_or_insert_with(|| {
            let own_s = (stated_s / DAY_S).floor() * DAY_S;
            let apart_s = near_s.map_or(0.0, |near_s| near_s - (stated_s - own_s));
            own_s - DAY_S * (apart_s / DAY_S).round()
        });
        Ok(((stated_s - midnight_s) * STEPS).round() / STEPS)
    }

    /// Takes a place in metres of a row that may state it in degrees, too.
    pub(crate) fn take_metres(
        &mut self,
        (row, column): (Cells<'_>, Column),
        position_m: [f64; 3],
        degrees: Option<&DegreeColumns>,
    ) -> Result<(), CsvError> {
        match self.frame {
            FrameBasis::Open => {
                let place = degrees.map(|columns| columns.stated(row)).transpose()?.flatten();
                let origin = place.and_then(|place| origin(place, position_m));
                self.frame = origin.map_or(FrameBasis::Unknown, |origin| FrameBasis::Known(SystemFrame::at(origin)));
                Ok(())
            }
            FrameBasis::Chosen(_) => Err(row.error(
                column,
                "is in metres, the other file in degrees; give --origin, that of x, y, z",
            )),
            FrameBasis::Known(_) | FrameBasis::Unknown => Ok(()),
        }
    }

    /// Returns the frame for a row with its place in degrees.
    pub(crate) fn frame(&mut self, row: Cells<'_>, column: Column, place: Geodetic) -> Result<SystemFrame, CsvError> {
        match self.frame {
            FrameBasis::Known(frame) | FrameBasis::Chosen(frame) => Ok(frame),
            FrameBasis::Open => {
                let frame = SystemFrame::at(place);
                self.frame = FrameBasis::Chosen(frame);
                Ok(frame)
            }
            FrameBasis::Unknown => Err(row.error(
                column,
                "is in degrees, the other file in metres; give --origin, that of x, y, z",
            )),
        }
    }
}

/// Seconds of a row, since a midnight or since 1970.
fn stated_s(row: Cells<'_>, column: Column) -> Result<f64, CsvError> {
    if !column.is_foreign() {
        return row.number(column);
    }
    let (time_ns, _) = row.any_time(column)?;
    Ok(frames::time::seconds(time_ns))
}

/// Columns of a place in degrees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DegreeColumns {
    pub(crate) latitude: Column,
    pub(crate) longitude: Column,
    /// Height above the ellipsoid, metres.
    pub(crate) height: Option<Column>,
    /// The same by pressure, in flight levels.
    pub(crate) flight_level: Option<Column>,
}

impl DegreeColumns {
    /// Returns the place of a row, and whether its height is known.
    pub(crate) fn place(&self, row: Cells<'_>) -> Result<(Geodetic, bool), CsvError> {
        let level = || {
            Ok(row
                .number_or_empty(self.flight_level)?
                .map(|level| level * FLIGHT_LEVEL_M))
        };
        let height_m = row
            .number_or_empty(self.height)?
            .map_or_else(level, |height_m| Ok(Some(height_m)))?;
        let [latitude_deg, longitude_deg] = row.numbers([self.latitude, self.longitude])?;
        let place = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m.unwrap_or(0.0));
        let place = place.map_err(|error| row.error(self.latitude, format!("stands in no place: {error}")))?;
        Ok((place, height_m.is_some()))
    }

    /// Returns the place of a row that may leave it out; the height is `None` if it is not stated.
    fn stated(&self, row: Cells<'_>) -> Result<Option<StatedPlace>, CsvError> {
        let latitude_deg = row.number_or_empty(self.latitude)?;
        let longitude_deg = row.number_or_empty(self.longitude)?;
        let height_m = match row.number_or_empty(self.flight_level)? {
            Some(level) => Some(level * FLIGHT_LEVEL_M),
            None => row.number_or_empty(self.height)?,
        };
        Ok(latitude_deg
            .zip(longitude_deg)
            .map(|degrees| StatedPlace { degrees, height_m }))
    }
}

/// Place beside a position in metres.
#[derive(Clone, Copy, Debug)]
struct StatedPlace {
    degrees: (f64, f64),
    height_m: Option<f64>,
}

/// Returns the origin of the frame in which a place has this position (m); at height 0 if the height of the place is
/// not known. `None` if there is no such place.
fn origin(place: StatedPlace, position_m: [f64; 3]) -> Option<Geodetic> {
    let ((latitude_deg, longitude_deg), mut height_m) = (place.degrees, place.height_m.unwrap_or(position_m[2]));
    let at = |height_m: f64| Geodetic::from_degrees(latitude_deg, longitude_deg, height_m).ok();
    let mut origin = at(0.0)?;
    for _ in 0..ROUNDS {
        let frame = SystemFrame::at(origin);
        let local = frame.to_local(at(height_m)?);
        let mut off_m: [f64; 3] = std::array::from_fn(|axis| local[axis] - position_m[axis]);
        if place.height_m.is_none() {
            height_m -= off_m[2];
            off_m[2] = 0.0;
        }
        origin = frame.to_geodetic(off_m);
    }
    Some(origin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_origin_is_found_from_a_place_in_metres_and_degrees() {
        let known = Geodetic::from_degrees(41.297063, 2.078447, 120.0).unwrap();
        let frame = SystemFrame::at(known);
        for position_m in [[0.0, 0.0, 0.0], [80e3, -120e3, 9e3], [-250e3, 30e3, -4e3]] {
            let place = frame.to_geodetic(position_m);
            let stated = StatedPlace {
                degrees: (place.latitude_deg(), place.longitude_deg()),
                height_m: Some(place.height_m()),
            };
            let off_m = frame.to_local(origin(stated, position_m).unwrap());
            assert!(
                off_m.iter().all(|metres| metres.abs() < 0.01),
                "{position_m:?}: {off_m:?}"
            );
        }
    }
}
