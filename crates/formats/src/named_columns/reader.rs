//! Rows of a table of named columns as sensor tracks in the system frame.

use std::io::Read;

use csv_table::{Cells, CsvError, Table};
use frames::{Geodetic, SystemFrame};
use messages::admission::POSITION_MAX_M;
use messages::{
    Covariance, Identity, IdentityText, NAME_MAX, SensorTrack, TrackState, level_of, sensor_track_bits as bits,
};

use super::header::{Field, Places, Positions};
use super::list::Quantity;
use super::targets::{RowNames, Targets};
use super::values::{TimeForm, digits, flag, number, text, time};
use crate::identity_columns::{callsign, is_plain};
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
const HEIGHT_MAX_M: f64 = 1e5;
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
    /// The plane of positions in degrees.
    frame: Option<SystemFrame>,
    /// Name of the source of a table without a column of sources.
    source_name: String,
    source_of: F,
    targets: Targets,
}

impl<R: Read, F: FnMut(&str) -> Option<RowSource>> NamedTrackReader<R, F> {
    /// Reads the header line of a table of the source `source_name`, unless its rows name their sources. Degrees are
    /// placed in `frame`; a table in metres needs none.
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
                frame,
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
    fn field(&self, quantity: Quantity) -> Option<Field> {
        self.at.of(quantity)
    }

    fn value(&self, row: &Cells<'_>, quantity: Quantity) -> Result<Option<f64>, CsvError> {
        number(row, self.field(quantity))
    }

    /// Position in the system frame, and whether its height is known.
    fn position(&self, row: &Cells<'_>, height_m: Option<f64>) -> Result<([f64; 3], bool), CsvError> {
        match (self.at.positions, self.frame) {
            (Positions::Metres(fields), _) => {
                let [east, north] = both(row, fields)?;
                if let Some(place) = [east, north].iter().position(|part| part.abs() > POSITION_MAX_M) {
                    return Err(row.error(
                        fields[place].column,
                        "is farther away than anything on the Earth; write metres",
                    ));
                }
                let up = self.limited(row, Quantity::Up, POSITION_MAX_M)?;
                Ok(([east, north, up.unwrap_or_default()], up.is_some()))
            }
            (Positions::Degrees(fields), Some(frame)) => {
                let place = place(row, fields, height_m.unwrap_or_default())?;
                let [east, north, up] = frame.to_local(place);
                let known = height_m.is_some();
                Ok(([east, north, if known { up } else { 0.0 }], known))
            }
            (Positions::Degrees([latitude, _]), None) => {
                Err(row.error(latitude.column, "needs the origin of the system frame"))
            }
        }
    }

    /// A value of at most `max` to either side of 0, which no target exceeds.
    fn limited(&self, row: &Cells<'_>, quantity: Quantity, max: f64) -> Result<Option<f64>, CsvError> {
        let field = self.field(quantity);
        match (field, number(row, field)?) {
            (Some(field), Some(value)) if value.abs() > max => {
                let reason = "is beyond what any target does; leave the value empty where it is unknown";
                Err(row.error(field.column, reason))
            }
            (_, value) => Ok(value),
        }
    }

    /// Velocity towards east and north at the target.
    fn velocity(&self, row: &Cells<'_>, is_ship: bool) -> Result<Option<[f64; 2]>, CsvError> {
        let plane = [Quantity::EastVelocity, Quantity::NorthVelocity];
        let [east, north] = plane.map(|quantity| self.limited(row, quantity, SPEED_MAX_MPS));
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

    fn speed(&self, row: &Cells<'_>, is_ship: bool) -> Result<Option<f64>, CsvError> {
        let Some((field, speed)) = self.field(Quantity::Speed).zip(self.value(row, Quantity::Speed)?) else {
            return Ok(None);
        };
        if !(0.0..=SPEED_MAX_MPS).contains(&speed) {
            return Err(row.error(
                field.column,
                "is no speed; leave the value empty where the speed is unknown",
            ));
        }
        // A rounded factor must not turn the first value that means "not available" into a speed.
        let is_stated = !is_ship || speed < SHIP_SPEED_END_MPS - 1e-6;
        Ok(is_stated.then_some(speed))
    }

    fn course(&self, row: &Cells<'_>, is_ship: bool) -> Result<Option<f64>, CsvError> {
        let Some((field, course_deg)) = self.field(Quantity::Course).zip(self.value(row, Quantity::Course)?) else {
            return Ok(None);
        };
        if is_ship && course_deg >= SHIP_COURSE_END_DEG {
            return Ok(None);
        }
        if course_deg.abs() > 360.0 {
            return Err(row.error(field.column, "is no course; write degrees from north, 0 to 360"));
        }
        Ok(Some(course_deg))
    }

    /// Velocity and rate of climb at a position, turned from the horizon there into the frame.
    fn in_frame(&self, position_m: [f64; 3], horizontal: Option<[f64; 2]>, climb: Option<f64>) -> [f64; 3] {
        let [east, north] = horizontal.unwrap_or_default();
        let local = [east, north, climb.unwrap_or_default()];
        match (self.at.positions, self.frame) {
            (Positions::Degrees(_), Some(frame)) => {
                let axes = frame.axes(position_m);
                [0, 1, 2].map(|part| (0..3).map(|axis| local[axis] * axes[axis][part]).sum())
            }
            _ => local,
        }
    }

    /// Standard deviation of the position, metres, and whether the row states it.
    fn sigma(&self, row: &Cells<'_>) -> Result<Option<f64>, CsvError> {
        let stated = self.field(Quantity::Sigma).zip(self.value(row, Quantity::Sigma)?);
        match stated {
            Some((field, sigma_m)) if !SIGMA_M.contains(&sigma_m) => {
                let (min, max) = (SIGMA_M.start(), SIGMA_M.end());
                let reason = format!("is no standard deviation; write metres, from {min} to {max}");
                Err(row.error(field.column, reason))
            }
            stated => Ok(stated.map(|(_, sigma_m)| sigma_m)),
        }
    }

    fn identity(&self, row: &Cells<'_>) -> Result<Identity, CsvError> {
        let mut identity = Identity::default();
        if let Some((_, address)) = self.spelled(row, Quantity::Address, IdentityText::ADDRESS)? {
            identity = identity.with_address(address);
        }
        if let Some((field, mmsi)) = self.spelled(row, Quantity::Mmsi, IdentityText::MMSI)? {
            if identity.address().is_some() {
                let reason = "stands beside an address; a target is an aircraft or a ship";
                return Err(row.error(field.column, reason));
            }
            identity = identity.with_mmsi(mmsi);
        }
        if let Some((_, code)) = self.spelled(row, Quantity::Mode3a, IdentityText::MODE_3A)? {
            identity = identity.with_mode_3a(code as u16);
        }
        // A longer or foreign name names its target, but fits into no sample.
        if let Some(callsign) = self.name(row, Quantity::Callsign)?.and_then(|(_, name)| callsign(name)) {
            identity = identity.with_callsign(callsign);
        }
        if let Some((_, name)) = self.name(row, Quantity::Name)?
            && name.len() <= NAME_MAX
            && is_plain(name)
        {
            identity = identity.with_name(name);
        }
        Ok(identity)
    }

    /// A number of an identity.
    fn spelled(
        &self,
        row: &Cells<'_>,
        quantity: Quantity,
        spelling: IdentityText,
    ) -> Result<Option<(Field, u32)>, CsvError> {
        let field = self.field(quantity);
        let Some((field, text)) = field.zip(digits(row, field)?) else {
            return Ok(None);
        };
        let number = spelling.read(text);
        let wrong = || row.error(field.column, format!("is not {}", spelling.form));
        number.map(|number| Some((field, number))).ok_or_else(wrong)
    }

    fn name<'r>(
        &self,
        row: &'r Cells<'_>,
        quantity: Quantity,
    ) -> Result<Option<(csv_table::Column, &'r str)>, CsvError> {
        let column = self.field(quantity).map(|field| field.column);
        Ok(column.zip(text(row, column)?))
    }
}

impl<F> NamedTrackColumns<F> {
    /// The number of the row's target.
    fn target(&mut self, row: &Cells<'_>, identity: &Identity) -> Result<u32, CsvError> {
        let transponder = [Quantity::Address, Quantity::Mmsi].map(|quantity| self.field(quantity));
        let track = self.field(Quantity::Track);
        let names = RowNames {
            name: self.name(row, Quantity::Name)?,
            callsign: self.name(row, Quantity::Callsign)?,
            track: track.map(|field| field.column).zip(digits(row, track)?),
            has_own_numbers: transponder.iter().all(Option::is_none),
        };
        if let Some(number) = self.targets.number(row, identity, names)? {
            return Ok(number);
        }
        let naming = [Quantity::Callsign, Quantity::Name, Quantity::Track].map(|quantity| self.field(quantity));
        match transponder.into_iter().chain(naming).flatten().next() {
            Some(field) => Err(row.error(field.column, "names no target, nor does another column of the row")),
            None => Ok(Targets::only()),
        }
    }
}

impl<F: FnMut(&str) -> Option<RowSource>> NamedTrackColumns<F> {
    fn source(&mut self, row: &Cells<'_>) -> Result<RowSource, CsvError> {
        let field = self.field(Quantity::Source);
        match field.zip(digits(row, field)?) {
            Some((field, name)) => (self.source_of)(name).ok_or_else(|| {
                let reason = "is no sensor of this run; name it in the configuration, or leave its rows out";
                row.error(field.column, reason)
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
        let row = &row;
        let (stated_ns, form) = time(row, self.at.time)?;
        let since_1970_ns = match form {
            TimeForm::OfDay => self.base.first_day_ns() + stated_ns,
            TimeForm::Since1970 | TimeForm::Zoned | TimeForm::Unzoned => stated_ns,
        };
        let time_ns = self.base.on_base(*row, self.at.time, since_1970_ns)?;
        let by_pressure = self.limited(row, Quantity::PressureAltitude, HEIGHT_MAX_M)?;
        let above_ellipsoid = self.limited(row, Quantity::Height, HEIGHT_MAX_M)?;
        // By the pressure first, which all aircraft have in common.
        let (position_m, has_height) = self.position(row, by_pressure.or(above_ellipsoid))?;
        let identity = self.identity(row)?;
        let horizontal = self.velocity(row, identity.mmsi().is_some())?;
        let climb = self.limited(row, Quantity::Climb, SPEED_MAX_MPS)?;
        let stated_sigma_m = self.sigma(row)?;
        let is_on_ground = flag(row, self.field(Quantity::OnGround))? == Some(true);
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
            position_m,
            velocity_mps: self.in_frame(position_m, horizontal, climb),
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

/// Two numbers that a row must have.
fn both(row: &Cells<'_>, fields: [Field; 2]) -> Result<[f64; 2], CsvError> {
    let mut values = [0.0; 2];
    for (value, field) in values.iter_mut().zip(fields) {
        let found = number(row, Some(field))?;
        *value = found.ok_or_else(|| row.error(field.column, "states no position; leave the row out"))?;
    }
    Ok(values)
}

/// The place of a row on the Earth, at a height in metres.
pub(super) fn place(row: &Cells<'_>, fields: [Field; 2], height_m: f64) -> Result<Geodetic, CsvError> {
    let [latitude, longitude] = both(row, fields)?;
    if latitude == 0.0 && longitude == 0.0 {
        let reason = "is latitude 0, longitude 0, as of a receiver without a fix; leave the row out";
        return Err(row.error(fields[0].column, reason));
    }
    Geodetic::from_degrees(latitude, longitude, height_m).map_err(|error| {
        let column = match error {
            frames::GeodeticError::Longitude(_) => fields[1].column,
            _ => fields[0].column,
        };
        row.error(
            column,
            format!("gives no place: {error}; write degrees, or leave the row out"),
        )
    })
}
