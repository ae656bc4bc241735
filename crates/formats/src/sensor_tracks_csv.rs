//! Sensor tracks as CSV rows (FM-5).
//!
//! A row is a report: time, identity of the track, state vector, upper triangle of the covariance, and state of the
//! track. Identity of the target, method, trace, and flags for observed height and velocity may follow; without the
//! two flag columns, both were observed. A source with only the trace of its covariance leaves the covariance columns
//! empty, or omits them (TI-1). Times of a file count from a midnight, or all from 1970.
//!
//! An empty cell, or a variance of 0, leaves the height or a component of the velocity unknown. A
//! position needs variances, from the row or from the configured accuracy of its sensor. Further optional columns
//! are the subject of the track (`kind`: `single`, or `group` with its `members`), the target's `type` with its
//! `type_confidence`, and a ship's `mmsi` and `name`. `arrival_s` is the time at which the report arrived
//! (absolute, not before `time_s`); without the column, a report arrives at its time. A column `truth_id` is never
//! read: it must stay hidden from fusion.

use std::io::{self, Read, Write};

use messages::admission::COVARIANCE_MAX;
use messages::sensor_track_bits as bits;
use messages::{Covariance, STATE_LEN, SensorTrack, TYPE_NAME_MAX, TargetType, TrackKind, TrackState};

use csv_table::{COVARIANCE_COLUMNS, Cells, Column, CsvError, Table};

use crate::cells::{Rounded, Time};
use crate::columns::columns;
use crate::identity_columns::IdentityPlaces;
use crate::parts::{KINEMATICS, ShipRow, confidence, covariance, kinematics, members, word, words};
use crate::rows::{Columns, Reference, Row, RowReader, RowWriter};
use crate::time_base::TimeBase;

/// Excess of a covariance over the product of its standard deviations that is accepted: files round to a few decimals.
const ROUNDING: f64 = 1e-3;
/// Components of a position that every row has.
const PLACES: usize = 2;
/// Part of a variance that is lost where four decimals are written: a target that stands still may have none left.
const VARIANCE_ROUNDING: f64 = 5e-5;

/// Writes sensor tracks.
pub type SensorTrackWriter<W> = RowWriter<SensorTrack, W>;
/// Reads sensor tracks.
pub type SensorTrackReader<R, F> = RowReader<R, SensorTrackColumns<F>>;

/// Sensor track under the id by which a file names its sensor.
pub(crate) struct SensorTrackRow<'a> {
    pub(crate) sensor_id: u32,
    pub(crate) track: &'a SensorTrack,
}

columns! {
    /// Places of the columns of sensor tracks.
    SensorTrackPlaces of SensorTrackRow<'_>: |row|
    time: Column = "time_s" => Time(row.track.time_of_measurement_ns),
    sensor: Column = "sensor_id" => row.sensor_id,
    number: Column = "sensor_track_id" => row.track.track_number,
    kinematics: [Option<Column>; KINEMATICS.len()] = KINEMATICS => kinematics(&row.track.position_m, &row.track.velocity_mps),
    // Missing where the trace alone is given.
    covariance: Option<[Column; COVARIANCE_COLUMNS.len()]> = COVARIANCE_COLUMNS => covariance(&row.track.covariance),
    state: Option<Column> = "state" => TrackState::from_code(row.track.state).map(TrackState::word),
    address: Option<Column> = "address" => row.track.identity.address_text(),
    mode_3a: Option<Column> = "mode_3a" => row.track.identity.mode_3a_text(),
    callsign: Option<Column> = "callsign" => row.track.identity.callsign().map(word),
    method: Option<Column> = "method" => row.track.method,
    trace: Option<Column> = "trace" => row.track.has(bits::TRACE).then_some(Rounded(row.track.trace_m2, 4)),
    height_valid: Option<Column> = "height_valid" => u8::from(row.track.has(bits::HEIGHT)),
    velocity_valid: Option<Column> = "velocity_valid" => u8::from(row.track.has(bits::VELOCITY)),
    kind: Option<Column> = "kind" => members(row.track.kind, row.track.members).map(|_| TrackKind::Group.word()),
    members: Option<Column> = "members" => members(row.track.kind, row.track.members),
    target_type: Option<Column> = "type" => row.track.target_type.name().map(words),
    confidence: Option<Column> = "type_confidence" => confidence(&row.track.target_type),
}

impl Row for SensorTrack {
    fn columns() -> String {
        [SensorTrackRow::columns(), ShipRow::columns()].join(",")
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let report = SensorTrackRow {
            sensor_id: reference.sensor_id(self.source),
            track: self,
        };
        report.write(out, reference)?;
        out.write_all(b",")?;
        ShipRow(&self.identity).write(out, reference)
    }
}

/// Columns of sensor tracks. `F` says which source a `sensor_id` is; `None` rejects the row.
#[derive(Debug)]
pub struct SensorTrackColumns<F> {
    base: TimeBase,
    source_of: F,
    at: SensorTrackPlaces,
    identity: IdentityPlaces,
    arrival: Option<Column>,
    /// Sensors whose accuracy is configured, so that their positions need no variances; `None`: all.
    accurate: Option<Vec<u32>>,
    /// Time of arrival of the row read last, nanoseconds.
    arrival_ns: i64,
}

impl<R: Read, F: FnMut(u32) -> Option<u16>> SensorTrackReader<R, F> {
    /// Reads the header line. Times of rows count from `first_day_ns` (UTC, nanoseconds), or from 1970. `source_of`
    /// maps a `sensor_id` to a source; `None` rejects the row.
    ///
    /// # Errors
    /// [`CsvError`] if a column is missing or the input fails.
    pub fn new(input: R, first_day_ns: i64, source_of: F) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        let at = SensorTrackPlaces::find(&table)?;
        for name in &KINEMATICS[..PLACES] {
            table.required(name)?;
        }
        if at.covariance.is_none() && at.trace.is_none() {
            table.required(COVARIANCE_COLUMNS[0])?;
        }
        let columns = SensorTrackColumns {
            base: TimeBase::new(first_day_ns),
            source_of,
            identity: IdentityPlaces {
                address: at.address,
                mmsi: table.optional("mmsi")?,
                mode_3a: at.mode_3a,
                callsign: at.callsign,
                name: table.optional("name")?,
            },
            at,
            arrival: table.optional("arrival_s")?,
            accurate: Some(Vec::new()),
            arrival_ns: first_day_ns,
        };
        Ok(Self { table, columns })
    }
}

impl<R: Read, F> SensorTrackReader<R, F> {
    /// Accepts positions without variances of these sensors, `None` of all: their accuracy is configured.
    #[must_use]
    pub fn with_accuracies_of(mut self, sensor_ids: Option<Vec<u32>>) -> Self {
        self.columns.accurate = sensor_ids;
        self
    }

    /// Whether the file states when its reports arrived.
    pub fn has_arrivals(&self) -> bool {
        self.columns.arrival.is_some()
    }

    /// Time at which the report of the row read last arrived (UTC, nanoseconds): its own time unless the file states
    /// another.
    pub fn arrival_ns(&self) -> i64 {
        self.columns.arrival_ns
    }
}

impl<F: FnMut(u32) -> Option<u16>> Columns for SensorTrackColumns<F> {
    type Value = SensorTrack;

    fn read(&mut self, row: Cells<'_>) -> Result<SensorTrack, CsvError> {
        let sensor = row.whole(self.at.sensor)?;
        let source = (self.source_of)(sensor).ok_or_else(|| {
            let reason = "is no sensor of this run; name it in the configuration, or leave its file out";
            row.error(self.at.sensor, reason)
        })?;
        let mut state = [None; STATE_LEN];
        for (value, column) in state.iter_mut().zip(self.at.kinematics) {
            *value = row.number_or_empty(column)?;
        }
        for (column, value) in self.at.kinematics.iter().zip(&state).take(PLACES) {
            if let (Some(column), None) = (column, value) {
                return Err(row.error(*column, "is empty; write a number"));
            }
        }
        let trace_m2 = self.trace(row)?;
        let has_accuracy = self.accurate.as_ref().is_none_or(|ids| ids.contains(&sensor));
        let covariance = self.covariance(row, trace_m2, &state, has_accuracy)?;
        let (kind, members) = self.kind(row)?;
        let time_ns = self.base.utc_ns(row, self.at.time)?;
        self.arrival_ns = self.arrival_of(row, time_ns)?;
        Ok(SensorTrack {
            time_of_measurement_ns: time_ns,
            track_number: row.whole(self.at.number)?,
            source,
            valid: self.valid(row, covariance.is_some(), trace_m2.is_some(), &state)?,
            identity: self.identity.read(row)?,
            position_m: [0, 1, 2].map(|component: usize| state[component].unwrap_or_default()),
            velocity_mps: [3, 4, 5].map(|component: usize| state[component].unwrap_or_default()),
            covariance: covariance.unwrap_or_default(),
            trace_m2: trace_m2.unwrap_or_default(),
            state: self.state(row)? as u8,
            method: self.method(row)?,
            kind: kind as u8,
            members,
            target_type: self.target_type(row)?,
            ..SensorTrack::default()
        })
    }
}

impl<F> SensorTrackColumns<F> {
    /// When the report of `time_ns` arrived, nanoseconds.
    fn arrival_of(&mut self, row: Cells<'_>, time_ns: i64) -> Result<i64, CsvError> {
        let Some(column) = self.arrival else {
            return Ok(time_ns);
        };
        let arrival_ns = self.base.utc_ns(row, column)?;
        if arrival_ns < time_ns {
            return Err(row.error(column, "is before time_s; no report arrives before its measurement"));
        }
        Ok(arrival_ns)
    }

    fn state(&self, row: Cells<'_>) -> Result<TrackState, CsvError> {
        let (Some(column), Some(word)) = (self.at.state, row.text(self.at.state)?) else {
            return Ok(TrackState::Confirmed);
        };
        TrackState::from_word(word).ok_or_else(|| {
            let words = TrackState::ALL.map(TrackState::word).join(", ");
            row.error(column, format!("is no state; write one of {words}"))
        })
    }

    fn valid(
        &self,
        row: Cells<'_>,
        covariance: bool,
        trace: bool,
        state: &[Option<f64>; STATE_LEN],
    ) -> Result<u16, CsvError> {
        let [_, _, z, vx, vy, vz] = state.map(|value| value.is_some());
        let height = flag(row, self.at.height_valid)? && z;
        let is_flagged = flag(row, self.at.velocity_valid)?;
        // One component may be known alone; its variance states that.
        let velocity = is_flagged && (if covariance { vx || vy } else { vx && vy });
        let bit = |set: bool, bit: u16| if set { bit } else { 0 };
        Ok(bit(covariance, bits::OWN_COVARIANCE)
            | bit(height, bits::HEIGHT)
            | bit(velocity, bits::VELOCITY)
            | bit(height && is_flagged && vz, bits::VERTICAL_RATE)
            | bit(trace, bits::TRACE))
    }

    /// The covariance; `None` if the row has its trace instead.
    fn covariance(
        &self,
        row: Cells<'_>,
        trace_m2: Option<f64>,
        state: &[Option<f64>; STATE_LEN],
        has_accuracy: bool,
    ) -> Result<Option<Covariance>, CsvError> {
        // By reference: the places of 21 columns are half a kilobyte.
        let columns = match (&self.at.covariance, self.at.trace, trace_m2) {
            (None, Some(column), None) => return Err(row.error(column, "is empty, and there are no covariances")),
            (None, ..) => return Ok(None),
            (Some(columns), _, Some(_)) if row.text(columns[0])?.is_none() => return Ok(None),
            (Some(columns), ..) => columns,
        };
        let mut covariance = Covariance::default();
        for (place, column) in covariance.upper.iter_mut().zip(columns) {
            let value = row.number_or_empty(*column)?.unwrap_or_default();
            if value.abs() > COVARIANCE_MAX {
                let reason = format!("is beyond {COVARIANCE_MAX:e}, the limit of variances and covariances");
                return Err(row.error(*column, reason));
            }
            *place = value;
        }
        let variances: [f64; STATE_LEN] = std::array::from_fn(|line| covariance.get(line, line));
        if let Some(line) = variances.iter().position(|variance| *variance < 0.0) {
            let column = columns[Covariance::index(line, line)];
            return Err(row.error(column, "is negative, which no variance is"));
        }
        let is_unknown = |line: &usize| variances[*line] == 0.0;
        if let Some(line) = (0..PLACES)
            .find(is_unknown)
            .filter(|_| !has_accuracy && trace_m2.is_none())
        {
            let reason = "is 0, so nothing is known of the position; write a variance above 0 (30 m are 900), or the \
                          accuracy of this sensor in a configuration";
            return Err(row.error(columns[Covariance::index(line, line)], reason));
        }
        // The upper triangle, line by line: the variance of a line precedes its covariances.
        let mut places = columns.iter().zip(&covariance.upper);
        for line in 0..STATE_LEN {
            places.next();
            for (other, (column, value)) in variances[line + 1..].iter().zip(places.by_ref()) {
                let limit = ((variances[line] + VARIANCE_ROUNDING) * (other + VARIANCE_ROUNDING)).sqrt() + ROUNDING;
                if value.abs() > limit {
                    let reason = format!("is beyond the product of its standard deviations, {limit:.4}");
                    return Err(row.error(*column, reason));
                }
            }
        }
        for line in (PLACES..STATE_LEN).filter(|line| state[*line].is_none()) {
            (0..STATE_LEN).for_each(|column| covariance.set(line, column, 0.0));
        }
        Ok(Some(covariance))
    }

    fn trace(&self, row: Cells<'_>) -> Result<Option<f64>, CsvError> {
        match (self.at.trace, row.number_or_empty(self.at.trace)?) {
            (Some(column), Some(trace)) if trace < 0.0 => Err(row.error(column, "is negative, which no trace is")),
            (_, trace) => Ok(trace),
        }
    }

    fn method(&self, row: Cells<'_>) -> Result<u8, CsvError> {
        match (self.at.method, row.text(self.at.method)?) {
            (Some(column), Some(_)) => row.whole(column),
            _ => Ok(0),
        }
    }

    /// Kind of track, and number of members of a group.
    fn kind(&self, row: Cells<'_>) -> Result<(TrackKind, u16), CsvError> {
        let kind = match (self.at.kind, row.text(self.at.kind)?) {
            (Some(column), Some(word)) => {
                let known = TrackKind::ALL.into_iter().find(|kind| kind.word() == word);
                known.ok_or_else(|| row.error(column, "is no kind of track; write single or group"))?
            }
            _ => TrackKind::Single,
        };
        let members = match (self.at.members, row.text(self.at.members)?) {
            (Some(column), Some(_)) => row.whole(column)?,
            _ => 0,
        };
        let fits = (kind == TrackKind::Group) == (members > 0);
        match self.at.members.or(self.at.kind).filter(|_| !fits) {
            Some(column) => Err(row.error(
                column,
                "does not fit the kind: a group has members, a single target none",
            )),
            None => Ok((kind, members)),
        }
    }

    fn target_type(&self, row: Cells<'_>) -> Result<TargetType, CsvError> {
        let confidence = row.number_or_empty(self.at.confidence)?;
        match (self.at.target_type, row.text(self.at.target_type)?, self.at.confidence, confidence) {
            (_, None, Some(column), Some(_)) => Err(row.error(column, "is of no type; name it in the column type")),
            (Some(column), Some(_), _, None) => Err(row.error(column, "needs a type_confidence beside it, up to 1")),
            (Some(column), Some(name), _, Some(confidence)) => TargetType::new(name, confidence).ok_or_else(|| {
                let reason = format!(
                    "with confidence {confidence} is no type; write 1 to {TYPE_NAME_MAX} characters of plain ASCII, and a \
                     confidence above 0, up to 1"
                );
                row.error(column, reason)
            }),
            _ => Ok(TargetType::default()),
        }
    }
}

/// Returns a flag (0 or 1); a missing or empty column means 1.
fn flag(row: Cells<'_>, column: Option<Column>) -> Result<bool, CsvError> {
    let Some(column) = column else { return Ok(true) };
    match row.text(column)? {
        None | Some("1") => Ok(true),
        Some("0") => Ok(false),
        Some(_) => Err(row.error(column, "is neither 0 nor 1")),
    }
}

#[cfg(test)]
#[path = "sensor_tracks_csv_tests.rs"]
mod tests;
