//! Observations as columns: detections and reports of tracks in degrees or metres.

use csv_table::NamedColumn;
use koseki_client::Error;
use koseki_client::by_name::AnyPublisher;
use koseki_client::messages::admission::Fault;
use koseki_client::messages::{IdentityText, TrackState};
use koseki_client::observation::{Fields, callsign_of, fault, numbered, time_ns_of};
use koseki_client::{Detection, TrackReport};
use pyo3::buffer::PyBuffer;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Names of the columns that are numbers of detections, and of reports of tracks.
#[pyfunction]
pub(super) fn observation_numbers() -> (Vec<&'static str>, Vec<&'static str>) {
    (Detection::NUMBERS.to_vec(), TrackReport::NUMBERS.to_vec())
}

/// Returns the column of these observations that states the quantity of `name`, a name of columns in tables, and the
/// value of one of its units in the unit of that column.
#[pyfunction]
pub(super) fn observation_column(name: &str, are_tracks: bool) -> Option<(&'static str, f64)> {
    let (numbers, ordinal) = match are_tracks {
        true => (TrackReport::NUMBERS, "track"),
        false => (Detection::NUMBERS, "scan"),
    };
    let others = [ordinal, "time_s", "address", "mmsi", "callsign"];
    NamedColumn::among(name, &[numbers, &others].concat())
}

/// Columns of one length.
pub(super) struct Columns {
    rows: usize,
    numbers: Vec<(String, Vec<f64>)>,
    wholes: Vec<(String, Vec<i64>)>,
    callsigns: Option<Vec<String>>,
}

impl Columns {
    /// Copies the columns.
    pub(super) fn of(
        py: Python<'_>,
        rows: usize,
        numbers: Vec<(String, PyBuffer<f64>)>,
        wholes: Vec<(String, PyBuffer<i64>)>,
        callsigns: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let numbers = numbers.into_iter().map(|(name, column)| Ok((name, column.to_vec(py)?)));
        let wholes = wholes.into_iter().map(|(name, column)| Ok((name, column.to_vec(py)?)));
        let columns = Self {
            rows,
            numbers: numbers.collect::<PyResult<_>>()?,
            wholes: wholes.collect::<PyResult<_>>()?,
            callsigns,
        };
        let lengths = columns.numbers.iter().map(|(_, values)| values.len());
        let lengths = lengths.chain(columns.wholes.iter().map(|(_, values)| values.len()));
        let mut lengths = lengths.chain(columns.callsigns.iter().map(Vec::len));
        match lengths.all(|length| length == rows) {
            true => Ok(columns),
            false => Err(PyValueError::new_err("the columns differ in length")),
        }
    }

    /// Sends the observations of the columns: with `are_tracks` reports of tracks, else detections.
    pub(super) fn send(&self, are_tracks: bool, publisher: &mut dyn AnyPublisher) -> Result<(), Error> {
        match are_tracks {
            true => publisher.send_tracks(&self.observations(state)?),
            false => publisher.send_detections(&self.observations(|_, _, _| Ok(()))?),
        }
    }

    /// Returns the observations, but for what a column of another kind states.
    fn observations<O: Fields>(&self, other: fn(&mut O, &str, i64) -> Result<(), Fault>) -> Result<Vec<O>, Error> {
        let observation = |row: usize| {
            let mut observation = O::default();
            for (name, values) in &self.numbers {
                let value = values[row];
                if let Some(number) = observation.number_mut(name) {
                    *number = (!value.is_nan()).then_some(value);
                } else if name == "time_s" {
                    *observation.time_mut() = Some(time_ns_of(value)?);
                }
            }
            for (name, values) in &self.wholes {
                whole(&mut observation, name, values[row], other)?;
            }
            if let Some(callsign) = self.callsigns.as_ref().map(|callsigns| &callsigns[row]) {
                let identity = observation.identity_mut();
                *identity = identity.with_callsign(callsign_of(callsign)?);
            }
            Ok(observation)
        };
        let refused = |index, fault| Error::Observation {
            index,
            fault: Box::new(fault),
        };
        let rows = (0..self.rows).map(|row| observation(row).map_err(|fault| refused(row, fault)));
        rows.collect()
    }
}

/// Fills the whole number of a column in.
fn whole<O: Fields>(
    observation: &mut O,
    name: &str,
    value: i64,
    other: fn(&mut O, &str, i64) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let number = || {
        let limit = "must be a whole number from 0 to 4294967295";
        u32::try_from(value).map_err(|_| fault(name, value, limit, "check the column"))
    };
    let identity = *observation.identity_mut();
    match name {
        "time_ns" => *observation.time_mut() = Some(value),
        "scan" | "track" => *observation.ordinal_mut() = Some(number()?),
        "address" => *observation.identity_mut() = numbered(identity, IdentityText::ADDRESS, number()?)?,
        "mmsi" => *observation.identity_mut() = numbered(identity, IdentityText::MMSI, number()?)?,
        name => other(observation, name, value)?,
    }
    Ok(())
}

/// States the code of a track's state.
fn state(report: &mut TrackReport, name: &str, value: i64) -> Result<(), Fault> {
    let state = u8::try_from(value).ok().and_then(TrackState::from_code);
    let wrong = || fault(name, value, "is no code of a state", "use koseki.TrackState");
    report.state = Some(state.ok_or_else(wrong)?);
    Ok(())
}
