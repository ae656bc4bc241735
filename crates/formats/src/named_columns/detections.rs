//! Rows of a table of named columns as detections: positions, or directions and ranges from the place of a sensor.
//!
//! A table with a bearing measures from its sensor, and its latitude and longitude are those of the sensor; every other
//! table measures positions. What a tracker needs and a foreign table lacks has a substitute: the file is a sensor; the
//! rows of a sensor with one time are a scan, and scans are numbered in the order of the rows; detections have the
//! numbers of their rows. A position without a height is one in the plane.
//!
//! Limits: an antenna that turns sees each target at a time of its own. Without a column `scan`, each of its rows would
//! be a scan in which all other targets were missed.

use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};
use messages::level_of;
use observations::{Detection, DetectionKind, QUANTITIES_MAX, TransponderReply};
use rustc_hash::FxHashMap;

use super::reader::{HEIGHT_MAX_M, HEIGHT_SIGMA_M, sigma};
use crate::bearings_csv::angle;
use crate::identity_columns::{IdentityPlaces, digits};
use crate::plane::{Plane, Positions, SensorPlaces, limited};
use crate::platform_states_csv::positive;
use crate::time_base::TimeBase;

/// Place of the range rate among the standard deviations.
const RANGE_RATE: usize = QUANTITIES_MAX;

/// Columns of a table of detections, and the numbers that it does not state.
#[derive(Debug)]
pub(crate) struct NamedDetections {
    base: TimeBase,
    pub(crate) plane: Plane,
    /// Number of the sensor of rows that name none.
    pub(crate) sensor_id: u32,
    time: Column,
    measured: Measured,
    /// Range rate and its standard deviation.
    rate: [Option<Column>; 2],
    identity: IdentityPlaces,
    pressure_altitude: Option<Column>,
    sensor: Option<Column>,
    pub(crate) scan: Option<Column>,
    number: Option<Column>,
    /// Number and time of the latest scan of each sensor.
    scans: FxHashMap<u32, (u32, i64)>,
    rows: u32,
}

/// Columns of what is measured.
#[derive(Debug)]
enum Measured {
    Position {
        positions: Positions,
        height: Option<Column>,
        sigma: Option<Column>,
        /// Place of the sensor, if stated.
        from: Option<SensorPlaces>,
    },
    /// Range, bearing and elevation, each with its standard deviation, from the place of the sensor.
    Directions([Option<[Option<Column>; 2]>; 3], Column, SensorPlaces),
}

/// Values and standard deviations in the order of a kind, and the place of the sensor.
type MeasuredRow = (DetectionKind, [f64; 3], Option<[f64; 3]>, [f64; 3]);

/// Whether a table states detections by named columns, and is neither one of detections in their own form (FM-6) nor
/// one of tracks.
pub(crate) fn has_named_detections<R: Read>(table: &Table<R>) -> bool {
    let of_own_tables = ["m0", "kind", "sensor_track_id", "system_track_id"];
    let is_own = table
        .names()
        .any(|name| of_own_tables.iter().any(|own| name == own.as_bytes()));
    !is_own
        && ["latitude", "x", "bearing_rad"]
            .into_iter()
            .any(|name| table.states(name))
}

impl NamedDetections {
    /// Finds the columns. Times of rows count from `first_day_ns` (UTC, nanoseconds), or from 1970.
    ///
    /// # Errors
    /// If a column is missing, or two columns state one quantity.
    pub(crate) fn find<R: Read>(table: &Table<R>, first_day_ns: i64) -> Result<Self, CsvError> {
        let time = table.of_quantity("time")?.ok_or_else(|| table.missing("time"))?;
        Ok(Self {
            base: TimeBase::new(first_day_ns),
            plane: Plane::Open,
            sensor_id: 1,
            time,
            measured: Measured::find(table)?,
            rate: [
                table.of_quantity("range_rate_mps")?,
                table.of_quantity("range_rate_sigma_mps")?,
            ],
            identity: IdentityPlaces::of_quantities(table)?,
            pressure_altitude: table.of_quantity("baroaltitude")?,
            sensor: table.of_quantity("source")?,
            scan: table.of_quantity("scan")?,
            number: table.of_quantity("detection_id")?,
            scans: FxHashMap::default(),
            rows: 0,
        })
    }

    /// The detection of a row.
    pub(crate) fn read(&mut self, row: Cells<'_>) -> Result<Detection, CsvError> {
        self.rows = self.rows.saturating_add(1);
        let time_ns = self.base.any_utc_ns(row, self.time)?;
        let by_pressure = limited(row, self.pressure_altitude, HEIGHT_MAX_M)?;
        let (kind, values, stated, platform_m) = self.measured.read(row, by_pressure, &mut self.plane)?;
        let mut sigmas = stated.map(|[first, second, third]| [first, second, third, 0.0]);
        let [rate, rate_sigma] = self.rate;
        let rate_mps = row.number_or_empty(rate)?;
        if let (Some(rate), Some(_), Some(sigmas)) = (rate, rate_mps, &mut sigmas) {
            let sigma = rate_sigma.map(|column| positive(row, column)).transpose()?.flatten();
            let reason = "needs its standard deviation in range_rate_sigma_mps, as the other values of the row have";
            sigmas[RANGE_RATE] = sigma.ok_or_else(|| row.error(rate, reason))?;
        }
        let sensor_id = self.sensor(row)?;
        Ok(Detection {
            time_of_measurement_ns: time_ns,
            sensor_id,
            scan: self.scan(row, sensor_id, time_ns)?,
            detection_id: self.number.map_or(Ok(self.rows), |column| row.whole(column))?,
            kind,
            values,
            range_rate_mps: rate_mps,
            sigmas,
            platform_m,
            platform: Default::default(),
            height: None,
            velocity: None,
            reply: TransponderReply {
                identity: self.identity.lenient(row)?,
                level: by_pressure.and_then(level_of),
                ..TransponderReply::default()
            },
            truth: None,
        })
    }

    fn sensor(&self, row: Cells<'_>) -> Result<u32, CsvError> {
        let Some((column, text)) = self.sensor.zip(digits(&row, self.sensor)?) else {
            return Ok(self.sensor_id);
        };
        let no_number = || row.error(column, "is no number of a sensor; number the sensors from 1");
        text.parse().map_err(|_| no_number())
    }

    /// The number of the row's scan: as stated, else one more if the time is another than that of the row before.
    fn scan(&mut self, row: Cells<'_>, sensor_id: u32, time_ns: i64) -> Result<u32, CsvError> {
        if let Some(column) = self.scan {
            return row.whole(column);
        }
        let (number, latest_ns) = self.scans.entry(sensor_id).or_insert((1, time_ns));
        if *latest_ns != time_ns {
            (*number, *latest_ns) = (number.saturating_add(1), time_ns);
        }
        Ok(*number)
    }
}

impl Measured {
    fn find<R: Read>(table: &Table<R>) -> Result<Self, CsvError> {
        let Some(bearing) = table.of_quantity("bearing_rad")? else {
            let from = table.states("px") || table.states("sensor_latitude");
            return Ok(Self::Position {
                positions: Positions::find(table)?.ok_or_else(|| table.missing("latitude"))?,
                height: table.of_quantity("altitude_m")?,
                sigma: table.of_quantity("sigma_m")?,
                from: from.then(|| SensorPlaces::of_table(table, false)).transpose()?,
            });
        };
        let names = [
            ("range_m", "range_sigma_m"),
            ("bearing_rad", "sigma_rad"),
            ("elevation_rad", "elevation_sigma_rad"),
        ];
        let has_sigmas = names.iter().any(|(_, sigma)| table.states(sigma));
        let mut columns = [None; 3];
        for (place, (name, sigma)) in columns.iter_mut().zip(names) {
            if let Some(column) = table.of_quantity(name)? {
                // Either all measured values have standard deviations, or none has.
                let sigma = has_sigmas.then(|| table.required(sigma)).transpose()?;
                *place = Some([Some(column), sigma]);
            }
        }
        Ok(Self::Directions(columns, bearing, SensorPlaces::of_table(table, true)?))
    }

    fn read(&self, row: Cells<'_>, by_pressure: Option<f64>, plane: &mut Plane) -> Result<MeasuredRow, CsvError> {
        match self {
            Self::Position {
                positions,
                height,
                sigma: column,
                from,
            } => {
                let height_m = by_pressure.or(limited(row, *height, HEIGHT_MAX_M)?);
                let placed = positions.read(row, height_m, plane)?;
                let sigma_m = sigma(row, *column)?;
                let platform_m = match from {
                    Some(from) => from.read(row, plane)?.position_m,
                    None => [0.0; 3],
                };
                let [east, north, up] = placed.position_m;
                Ok(match placed.has_height {
                    true => {
                        let sigmas = sigma_m.map(|sigma_m| [sigma_m, sigma_m, HEIGHT_SIGMA_M]);
                        (DetectionKind::Position3, [east, north, up], sigmas, platform_m)
                    }
                    false => {
                        let sigmas = sigma_m.map(|sigma_m| [sigma_m, sigma_m, 0.0]);
                        (DetectionKind::Position2, [east, north, 0.0], sigmas, platform_m)
                    }
                })
            }
            Self::Directions(columns, bearing, from) => directions(row, (columns, *bearing), from, plane),
        }
    }
}

/// Values in the frame: those that a row states, in the order of their kind.
fn directions(
    row: Cells<'_>,
    (columns, bearing): (&[Option<[Option<Column>; 2]>; 3], Column),
    from: &SensorPlaces,
    plane: &mut Plane,
) -> Result<MeasuredRow, CsvError> {
    let from = from.read(row, plane)?;
    let [mut range, _, mut elevation] = [None; 3];
    if let Some([column, _]) = columns[0] {
        range = row.number_or_empty(column)?;
        if let (Some(column), Some(..0.0)) = (column, range) {
            return Err(row.error(column, "is negative; a range is none"));
        }
    }
    if let Some([Some(column), _]) = columns[2] {
        elevation = row.number_or_empty(column)?.map(|_| angle(row, column)).transpose()?;
    }
    let [in_plane, above] = from.direction([angle(row, bearing)?, elevation.unwrap_or_default()]);
    let above = elevation.map(|_| above);
    let kind = match (range, above) {
        (Some(_), Some(_)) => DetectionKind::RangeBearingElevation,
        (Some(_), None) => DetectionKind::RangeBearing,
        (None, Some(_)) => DetectionKind::BearingElevation,
        (None, None) => DetectionKind::Bearing,
    };
    let (mut values, mut sigmas, mut count) = ([0.0; 3], [0.0; 3], 0);
    let mut has_sigmas = true;
    for (value, columns) in [range, Some(in_plane), above].into_iter().zip(columns) {
        let (Some(value), Some([_, sigma])) = (value, columns) else {
            continue;
        };
        values[count] = value;
        match sigma.map(|column| positive(row, column)).transpose()?.flatten() {
            Some(sigma) => sigmas[count] = sigma,
            None => has_sigmas = false,
        }
        count += 1;
    }
    Ok((kind, values, has_sigmas.then_some(sigmas), from.position_m))
}
