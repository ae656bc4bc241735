//! Rows of a table of named columns as sensor tracks in the system frame.

use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};
use frames::SystemFrame;
use messages::{Covariance, Identity, SensorTrack, TrackState, level_of, sensor_track_bits as bits};

use super::header::Places;
use super::targets::{RowNames, Targets};
use crate::identity_columns::digits;
use crate::plane::{Plane, limited};
use crate::rows::{Columns, RowReader};
use crate::time_base::TimeBase;

/// Standard deviation of each component of a stated velocity, metres per second: the default of
/// `covariance.velocity_sigma_mps` in a deployment.
pub const VELOCITY_SIGMA_MPS: f64 = 3.0;
/// Standard deviation of a stated height, metres: the default of `covariance.height_sigma_m` in a deployment.
pub const HEIGHT_SIGMA_M: f64 = 30.0;
/// Smallest and largest standard deviation of a position, metres.
const SIGMA_M: std::ops::RangeInclusive<f64> = 1e-3..=1e6;
/// Largest height to either side of the ellipsoid, metres.
pub(super) const HEIGHT_MAX_M: f64 = 1e5;
/// Largest component of a velocity, metres per second: turned into another frame, it is one that the engine accepts.
const SPEED_MAX_MPS: f64 = messages::admission::SPEED_MAX_MPS / 2.0;
/// A ship's values that mean "not available" (ITU-R M.1371): the speed from 102.2 knots on, the course from 360° on.
const SHIP_SPEED_END_MPS: f64 = 102.2 * 1852.0 / 3600.0;
const SHIP_COURSE_END_DEG: f64 = 360.0;

/// Reads sensor tracks from a table of named columns.
pub type NamedTrackReader<R, F> = RowReader<R, NamedTrackColumns<F>>;

/// The source of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowSource {
    /// Its number.
    pub number: u16,
    /// Standard deviation of positions without a statement of their own, metres; `None` leaves such a position without
    /// an accuracy, so that the configured one counts.
    pub sigma_m: Option<f64>,
}

/// Columns of a table. `F` gives the source of a name; `None` rejects the row.
#[derive(Debug)]
pub struct NamedTrackColumns<F> {
    at: Places,
    base: TimeBase,
    plane: Plane,
    /// Name of the source of a table without a column of sources.
    source_name: String,
    source_of: F,
    targets: Targets,
}

impl<R: Read, F: FnMut(&str) -> Option<RowSource>> NamedTrackReader<R, F> {
    /// Reads the header line of a table of the source `source_name`, unless its rows name their sources. Degrees are
    /// placed in `frame`, without it in that of the first position; a table in metres needs none.
    ///
    /// # Errors
    /// [`CsvError`] if a column is missing, two columns state one quantity, or the input fails.
    pub fn new(input: R, frame: Option<SystemFrame>, source_name: &str, source_of: F) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        let at = Places::find(&table)?;
        Ok(Self {
            columns: NamedTrackColumns {
                at,
                base: TimeBase::new(0),
                plane: frame.map_or(Plane::Open, Plane::Given),
                source_name: source_name.to_owned(),
                source_of,
                targets: Targets::default(),
            },
            table,
        })
    }
}

impl<R: Read, F> NamedTrackReader<R, F> {
    /// Counts times of day from `first_day_ns` (UTC, nanoseconds).
    #[must_use]
    pub fn counting_from(mut self, first_day_ns: i64) -> Self {
        self.columns.base = TimeBase::new(first_day_ns);
        self
    }
}

impl<F> NamedTrackColumns<F> {
    /// Velocity towards east and north at the target.
    fn velocity(&self, row: Cells<'_>, is_ship: bool) -> Result<Option<[f64; 2]>, CsvError> {
        let [east, north] = self.at.velocity.map(|column| limited(row, column, SPEED_MAX_MPS));
        if let (Some(east), Some(north)) = (east?, north?) {
            return Ok(Some([east, north]));
        }
        let (speed, course) = (self.speed(row, is_ship)?, self.course(row, is_ship)?);
        Ok(match (speed, course) {
            (Some(speed), Some(course_deg)) => {
                let (sine, cosine) = course_deg.to_radians().sin_cos();
                Some([speed * sine, speed * cosine])
            }
            // At rest, a target has no course.
            (Some(0.0), None) => Some([0.0; 2]),
            _ => None,
        })
    }

    fn speed(&self, row: Cells<'_>, is_ship: bool) -> Result<Option<f64>, CsvError> {
        let Some((column, speed)) = self.at.speed.zip(row.number_or_empty(self.at.speed)?) else {
            return Ok(None);
        };
        if !(0.0..=SPEED_MAX_MPS).contains(&speed) {
            let reason = "is no speed; leave the value empty where the speed is unknown";
            return Err(row.error(column, reason));
        }
        // A rounded factor must not turn the first value that means "not available" into a speed.
        let is_stated = !is_ship || speed < SHIP_SPEED_END_MPS - 1e-6;
        Ok(is_stated.then_some(speed))
    }

    fn course(&self, row: Cells<'_>, is_ship: bool) -> Result<Option<f64>, CsvError> {
        let Some((column, course_deg)) = self.at.course.zip(row.number_or_empty(self.at.course)?) else {
            return Ok(None);
        };
        if is_ship && course_deg >= SHIP_COURSE_END_DEG {
            return Ok(None);
        }
        if course_deg.abs() > 360.0 {
            return Err(row.error(column, "is no course; write degrees from north, 0 to 360"));
        }
        Ok(Some(course_deg))
    }

    /// The number of the row's target.
    fn target(&mut self, row: Cells<'_>, identity: &Identity) -> Result<u32, CsvError> {
        let (of, track) = (self.at.identity, self.at.track);
        let names = RowNames {
            name: of.name.zip(row.stated(of.name)?),
            callsign: of.callsign.zip(row.stated(of.callsign)?),
            track: track.zip(digits(&row, track)?),
            has_own_numbers: of.address.or(of.mmsi).is_none(),
        };
        if let Some(number) = self.targets.number(&row, identity, names)? {
            return Ok(number);
        }
        match of.address.or(of.mmsi).or(of.callsign).or(of.name).or(track) {
            Some(column) => Err(row.error(column, "names no target, nor does another column of the row")),
            None => Ok(Targets::only()),
        }
    }
}

impl<F: FnMut(&str) -> Option<RowSource>> NamedTrackColumns<F> {
    fn source(&mut self, row: Cells<'_>) -> Result<RowSource, CsvError> {
        match self.at.source.zip(digits(&row, self.at.source)?) {
            Some((column, name)) => (self.source_of)(name).ok_or_else(|| {
                let reason = "is no sensor of this run; name it in the configuration, or leave its rows out";
                row.error(column, reason)
            }),
            None => (self.source_of)(&self.source_name).ok_or_else(|| {
                let reason = format!("is of {:?}, which is no sensor of this run", self.source_name);
                row.error(self.at.time, reason)
            }),
        }
    }
}

impl<F: FnMut(&str) -> Option<RowSource>> Columns for NamedTrackColumns<F> {
    type Value = SensorTrack;

    fn read(&mut self, row: Cells<'_>) -> Result<SensorTrack, CsvError> {
        let time_ns = self.base.any_utc_ns(row, self.at.time)?;
        let by_pressure = limited(row, self.at.pressure_altitude, HEIGHT_MAX_M)?;
        let above_ellipsoid = limited(row, self.at.height, HEIGHT_MAX_M)?;
        // By the pressure first, which all aircraft have in common.
        let height_m = by_pressure.or(above_ellipsoid);
        let placed = self.at.positions.read(row, height_m, &mut self.plane)?;
        let has_height = placed.has_height;
        let identity = self.at.identity.lenient(row)?;
        let horizontal = self.velocity(row, identity.mmsi().is_some())?;
        let climb = limited(row, self.at.climb, SPEED_MAX_MPS)?;
        let stated_sigma_m = sigma(row, self.at.sigma)?;
        let is_on_ground = flag(row, self.at.on_ground)? == Some(true);
        let track_number = self.target(row, &identity)?;
        // The source last: a row without use makes none.
        let source = self.source(row)?;
        let sigma_m = stated_sigma_m.or(source.sigma_m);
        let known = |is_known: bool, sigma: f64| if is_known { sigma } else { 0.0 };
        let has_climb = has_height && climb.is_some();
        let position_sigma_m = sigma_m.unwrap_or_default();
        let velocity_sigma = known(horizontal.is_some(), VELOCITY_SIGMA_MPS);
        let level = by_pressure.and_then(level_of);
        let offset_m = by_pressure
            .zip(above_ellipsoid)
            .map(|(pressure, height)| pressure - height);
        let bit = |is_set: bool, bit: u16| if is_set { bit } else { 0 };
        let [east, north, up] = placed.position_m;
        let [to_east, to_north] = horizontal.unwrap_or_default();
        Ok(SensorTrack {
            time_of_measurement_ns: time_ns,
            track_number,
            source: source.number,
            valid: bit(stated_sigma_m.is_some(), bits::OWN_COVARIANCE)
                | bit(has_height, bits::HEIGHT)
                | bit(horizontal.is_some(), bits::VELOCITY)
                | bit(has_climb, bits::VERTICAL_RATE)
                | bit(is_on_ground, bits::ON_GROUND)
                | bit(level.is_some(), bits::LEVEL)
                | bit(offset_m.is_some(), bits::PRESSURE_OFFSET),
            identity,
            position_m: [east, north, if has_height { up } else { 0.0 }],
            velocity_mps: placed.in_frame([to_east, to_north, climb.unwrap_or_default()]),
            covariance: Covariance::diagonal(
                [position_sigma_m, position_sigma_m, known(has_height, HEIGHT_SIGMA_M)],
                [velocity_sigma, velocity_sigma, known(has_climb, VELOCITY_SIGMA_MPS)],
            ),
            state: TrackState::Confirmed as u8,
            level: level.unwrap_or_default(),
            pressure_offset_m: offset_m.unwrap_or_default() as f32,
            ..SensorTrack::default()
        })
    }
}

/// Standard deviation of a position, metres, if the row states it.
pub(super) fn sigma(row: Cells<'_>, column: Option<Column>) -> Result<Option<f64>, CsvError> {
    match (column, row.number_or_empty(column)?) {
        (Some(column), Some(sigma_m)) if !SIGMA_M.contains(&sigma_m) => {
            let (min, max) = (SIGMA_M.start(), SIGMA_M.end());
            let reason = format!("is no standard deviation; write metres, from {min} to {max}");
            Err(row.error(column, reason))
        }
        (_, stated) => Ok(stated),
    }
}

/// A flag; `None` if the cell states nothing.
fn flag(row: Cells<'_>, column: Option<Column>) -> Result<Option<bool>, CsvError> {
    let Some((column, word)) = column.zip(row.stated(column)?) else {
        return Ok(None);
    };
    let is_in = |words: [&str; 5]| words.iter().any(|known| known.eq_ignore_ascii_case(word));
    if is_in(["true", "1", "yes", "t", "y"]) {
        Ok(Some(true))
    } else if is_in(["false", "0", "no", "f", "n"]) {
        Ok(Some(false))
    } else {
        Err(row.error(column, "is neither true nor false"))
    }
}
