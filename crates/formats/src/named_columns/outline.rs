//! What a table of named columns states, as far as a plan for reading it needs.

use std::io::Read;

use csv_table::{CsvError, Table, TimeForm};
use frames::Geodetic;

use super::header::{Places, TargetNames, has_named_columns};
use crate::plane::{Positions, place};

/// Outline of a table of named columns.
#[derive(Clone, Debug)]
pub struct TableOutline {
    /// Whether positions are in degrees, not in metres of the system frame.
    pub is_in_degrees: bool,
    /// First valid position in degrees, at height 0, and its line from 1.
    pub first_place: Option<(Geodetic, u64)>,
    /// Form of the first valid time.
    pub time_form: Option<TimeForm>,
    /// Name of the column of the time, as the list of columns spells it.
    pub time_column: &'static str,
    /// What the table names its targets by.
    pub target_names: TargetNames,
    /// Whether rows may state their accuracy.
    pub has_sigma: bool,
    /// Whether rows may name their sensors.
    pub has_sources: bool,
    /// Names of the columns that are not read, as in the header.
    pub ignored: Vec<String>,
}

/// Standard deviation of the positions of aircraft and ships that state their own place, metres: the receiver's error
/// is below 10 m, the rest is the time between the measurement and the stated time.
const OWN_PLACE_SIGMA_M: f64 = 30.0;
/// Standard deviation of positions of unknown origin, metres: a surveillance radar at half its range.
const OTHER_SIGMA_M: f64 = 100.0;

impl TableOutline {
    /// Returns the standard deviation that is assumed for positions without a statement of their own, metres.
    pub fn assumed_sigma_m(&self) -> f64 {
        match self.target_names {
            TargetNames::Transponders => OWN_PLACE_SIGMA_M,
            TargetNames::Names | TargetNames::One => OTHER_SIGMA_M,
        }
    }

    /// Outlines a table: reads up to its first valid time and position; `None` if its header is not one of named
    /// columns.
    ///
    /// # Errors
    /// [`CsvError`] if time or position is missing from the header, two columns state one quantity, or the input fails.
    pub fn of<R: Read>(input: R) -> Result<Option<Self>, CsvError> {
        let mut table = Table::new(input)?;
        if !has_named_columns(&table) {
            return Ok(None);
        }
        let at = Places::find(&table)?;
        let mut outline = Self {
            is_in_degrees: matches!(at.positions, Positions::Degrees(_)),
            first_place: None,
            time_form: None,
            time_column: at.time.name(),
            target_names: at.target_names(),
            has_sigma: at.sigma.is_some(),
            has_sources: at.source.is_some(),
            ignored: at.ignored.clone(),
        };
        while outline.time_form.is_none() || outline.is_in_degrees && outline.first_place.is_none() {
            let Some(row) = table.next_row() else { break };
            let row = match row {
                Ok(row) => row,
                Err(error) if error.is_of_row() => continue,
                Err(error) => return Err(error),
            };
            let form = row.any_time(at.time).ok().map(|(_, form)| form);
            outline.time_form = outline.time_form.or(form);
            if let (Positions::Degrees(columns), Some(_)) = (at.positions, form) {
                let found = place(row, columns, 0.0).ok();
                outline.first_place = outline.first_place.or(found.map(|place| (place, row.line())));
            }
        }
        Ok(Some(outline))
    }
}
