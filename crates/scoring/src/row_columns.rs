//! Columns of a target or track that tables state in more than one way: its number, and its velocity.

use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};
use messages::IdentityText;

/// Columns of velocities, by dimension.
const VELOCITY: [&str; 3] = ["vx", "vy", "vz"];

/// Number of horizontal axes.
pub(crate) const PLANE: usize = 2;

/// Column that identifies the rows of a target or track.
#[derive(Clone, Copy, Debug)]
pub(crate) enum IdColumn {
    /// A whole number.
    Number(Column),
    /// A number of an aircraft or a ship, as a text of digits.
    Identity(Column, IdentityText),
}

impl IdColumn {
    /// Finds the first of `ids` in the header, else a foreign column of the number of a track, else the address or
    /// MMSI; without any, the error names `usual`.
    ///
    /// # Errors
    /// If there is none, or two columns state one quantity.
    pub(crate) fn find<R: Read>(table: &Table<R>, ids: &[&'static str], usual: &'static str) -> Result<Self, CsvError> {
        for name in ids {
            if let Some(column) = table.spelled(name)? {
                return Ok(Self::Number(column));
            }
        }
        // Another of these is the number of something else: the reports of a sensor are no truth.
        for name in ["target_id", "system_track_id", "sensor_track_id"] {
            if table.spelled(name)?.is_some() {
                return Err(table.missing(usual));
            }
        }
        for name in ["track_id", "track"] {
            if let Some(column) = table.of_quantity(name)? {
                return Ok(Self::Number(column));
            }
        }
        for (name, spelling) in [("address", IdentityText::ADDRESS), ("mmsi", IdentityText::MMSI)] {
            if let Some(column) = table.of_quantity(name)? {
                return Ok(Self::Identity(column, spelling));
            }
        }
        Err(table.missing(usual))
    }

    /// The number of a row.
    pub(crate) fn read(self, row: Cells<'_>) -> Result<i64, CsvError> {
        match self {
            Self::Number(column) => row.whole(column),
            Self::Identity(column, spelling) => {
                let number = row.stated(column)?.and_then(|text| spelling.read(text));
                let wrong = || row.error(column, format!("is not {}, which identifies its row", spelling.form));
                number.map(i64::from).ok_or_else(wrong)
            }
        }
    }
}

/// Columns of a velocity.
#[derive(Clone, Copy, Debug)]
pub(crate) enum VelocityColumns<const D: usize> {
    /// Its components.
    Components([Column; D]),
    /// Speed, course in degrees clockwise from north, and rate of climb if known.
    Polar([Column; 2], Option<Column>),
}

impl<const D: usize> VelocityColumns<D> {
    pub(crate) fn find<R: Read>(table: &Table<R>) -> Result<Self, CsvError> {
        let polar = (table.of_quantity("speed_mps")?, table.of_quantity("course_deg")?);
        match (columns(table, VELOCITY), polar) {
            (Err(_), (Some(speed), Some(course))) => Ok(Self::Polar([speed, course], table.of_quantity("climb_mps")?)),
            (components, _) => components.map(Self::Components),
        }
    }

    /// The velocity of a row; `None` if the row does not state it.
    pub(crate) fn read(self, row: Cells<'_>, has_height: bool) -> Result<Option<[f64; D]>, CsvError> {
        match self {
            Self::Components(columns) => known(row, columns, has_height).map(Some),
            Self::Polar([speed, course], climb) => {
                let climb_mps = row.number_or_empty(climb)?.unwrap_or_default();
                let stated = row.number_or_empty(speed)?.zip(row.number_or_empty(course)?);
                Ok(stated.map(|(speed_mps, course_deg)| {
                    let (sine, cosine) = course_deg.to_radians().sin_cos();
                    let parts = [speed_mps * sine, speed_mps * cosine, climb_mps];
                    std::array::from_fn(|axis| parts[axis])
                }))
            }
        }
    }
}

/// The columns of the first `D` names.
pub(crate) fn columns<R: Read, const D: usize>(
    table: &Table<R>,
    names: [&'static str; 3],
) -> Result<[Column; D], CsvError> {
    let mut wanted = [""; D];
    wanted.copy_from_slice(&names[..D]);
    table.all(wanted)
}

/// Returns the components of a vector; the vertical one is 0 if heights are not known.
pub(crate) fn known<const D: usize>(
    row: Cells<'_>,
    columns: [Column; D],
    has_height: bool,
) -> Result<[f64; D], CsvError> {
    let mut numbers = [0.0; D];
    for (axis, (number, column)) in numbers.iter_mut().zip(columns).enumerate() {
        if axis < PLANE || has_height {
            *number = row.number(column)?;
        }
    }
    Ok(numbers)
}
