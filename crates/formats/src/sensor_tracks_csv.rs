//! Sensor tracks from CSV rows (FM-5); [`SensorTrackWriter`] writes them.
//!
//! A row is one report: time, whose track it is, state vector, the covariance's upper triangle, and the track's state.
//! Who the target says it is, the method, the trace, and whether height and velocity were observed may follow; where
//! those last two columns are missing, both were. A source that gives no covariance but its trace leaves those columns
//! empty, or out (TI-1). So may what the track follows (`kind`: `single`, or `group` with its
//! `members`) and the target's `type` with its `type_confidence`. A column `truth_id` is never read: fusion must not
//! see it.

use std::io::Read;

use messages::sensor_track_bits as bits;
use messages::{
    Callsign, Covariance, Identity, STATE_LEN, SensorTrack, TYPE_NAME_MAX, TargetType, TrackKind, TrackState,
};

use csv_table::{COVARIANCE_COLUMNS, Cells, Column, CsvError, Table};

use crate::rows::{Columns, RowReader};
pub use crate::tracks_csv::SensorTrackWriter;

const KINEMATICS: [&str; STATE_LEN] = ["x", "y", "z", "vx", "vy", "vz"];
/// Excess of a covariance over the product of its standard deviations that is accepted: files round to a few decimals.
const ROUNDING: f64 = 1e-3;
/// Part of a variance that is lost where four decimals are written: a target that stands still may have none left.
const VARIANCE_ROUNDING: f64 = 5e-5;

/// Reads sensor tracks.
pub type SensorTrackReader<R, F> = RowReader<R, SensorTrackColumns<F>>;

/// Columns of sensor tracks. `F` says which source a `sensor_id` is; `None` rejects the row.
#[derive(Debug)]
pub struct SensorTrackColumns<F> {
    first_day_ns: i64,
    source_of: F,
    time: Column,
    sensor: Column,
    number: Column,
    kinematics: [Column; STATE_LEN],
    /// `None` where the trace alone is given.
    covariance: Option<[Column; COVARIANCE_COLUMNS.len()]>,
    state: Column,
    address: Option<Column>,
    mode_3a: Option<Column>,
    callsign: Option<Column>,
    method: Option<Column>,
    trace: Option<Column>,
    height_valid: Option<Column>,
    velocity_valid: Option<Column>,
    kind: Option<Column>,
    members: Option<Column>,
    target_type: Option<Column>,
    confidence: Option<Column>,
}

impl<R: Read, F: FnMut(u32) -> Option<u16>> SensorTrackReader<R, F> {
    /// Reads the header line. The rows' times count from `first_day_ns` (UTC, nanoseconds). `source_of` says which
    /// source a `sensor_id` is; `None` rejects the row.
    ///
    /// # Errors
    /// [`CsvError`] if a column is missing or the input fails.
    pub fn new(input: R, first_day_ns: i64, source_of: F) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        let trace = table.optional("trace")?;
        let is_trace_alone = trace.is_some() && table.optional(COVARIANCE_COLUMNS[0])?.is_none();
        let columns = SensorTrackColumns {
            first_day_ns,
            source_of,
            time: table.required("time_s")?,
            sensor: table.required("sensor_id")?,
            number: table.required("sensor_track_id")?,
            kinematics: table.all(KINEMATICS)?,
            covariance: match is_trace_alone {
                true => None,
                false => Some(table.all(COVARIANCE_COLUMNS)?),
            },
            state: table.required("state")?,
            address: table.optional("address")?,
            mode_3a: table.optional("mode_3a")?,
            callsign: table.optional("callsign")?,
            method: table.optional("method")?,
            trace,
            height_valid: table.optional("height_valid")?,
            velocity_valid: table.optional("velocity_valid")?,
            kind: table.optional("kind")?,
            members: table.optional("members")?,
            target_type: table.optional("type")?,
            confidence: table.optional("type_confidence")?,
        };
        Ok(Self { table, columns })
    }
}

impl<F: FnMut(u32) -> Option<u16>> Columns for SensorTrackColumns<F> {
    type Value = SensorTrack;

    fn read(&mut self, row: Cells<'_>) -> Result<SensorTrack, CsvError> {
        let sensor = row.whole(self.sensor)?;
        let source = (self.source_of)(sensor).ok_or_else(|| {
            let reason = "is no sensor of this run; name it in the configuration, or leave its file out";
            row.error(self.sensor, reason)
        })?;
        let [x, y, z, vx, vy, vz] = self.kinematics.map(|column| row.number(column));
        let trace_m2 = self.trace(row)?;
        let covariance = self.covariance(row, trace_m2)?;
        let (kind, members) = self.kind(row)?;
        Ok(SensorTrack {
            time_of_measurement_ns: row.time_ns(self.time)?.saturating_add(self.first_day_ns),
            track_number: row.whole(self.number)?,
            source,
            valid: self.valid(row, covariance.is_some(), trace_m2.is_some())?,
            identity: self.identity(row)?,
            position_m: [x?, y?, z?],
            velocity_mps: [vx?, vy?, vz?],
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
    fn state(&self, row: Cells<'_>) -> Result<TrackState, CsvError> {
        let word = row.text(self.state)?.unwrap_or_default();
        TrackState::from_word(word).ok_or_else(|| {
            let words = TrackState::ALL.map(TrackState::word).join(", ");
            row.error(self.state, format!("is no state; write one of {words}"))
        })
    }

    fn valid(&self, row: Cells<'_>, covariance: bool, trace: bool) -> Result<u16, CsvError> {
        let height = flag(row, self.height_valid)?;
        let velocity = flag(row, self.velocity_valid)?;
        let bit = |set: bool, bit: u16| if set { bit } else { 0 };
        Ok(bit(covariance, bits::OWN_COVARIANCE)
            | bit(height, bits::HEIGHT)
            | bit(velocity, bits::VELOCITY)
            | bit(height && velocity, bits::VERTICAL_RATE)
            | bit(trace, bits::TRACE))
    }

    /// The covariance; `None` if the row has its trace instead.
    fn covariance(&self, row: Cells<'_>, trace_m2: Option<f64>) -> Result<Option<Covariance>, CsvError> {
        let columns = match (self.covariance, self.trace, trace_m2) {
            (None, Some(column), None) => return Err(row.error(column, "is empty, and there are no covariances")),
            (None, ..) => return Ok(None),
            (Some(columns), _, Some(_)) if row.text(columns[0])?.is_none() => return Ok(None),
            (Some(columns), ..) => columns,
        };
        let mut covariance = Covariance::default();
        for (place, column) in covariance.upper.iter_mut().zip(columns) {
            *place = row.number(column)?;
        }
        for line in 0..STATE_LEN {
            if covariance.get(line, line) < 0.0 {
                let column = columns[Covariance::index(line, line)];
                return Err(row.error(column, "is negative, which no variance is"));
            }
        }
        for line in 0..STATE_LEN {
            for other in line + 1..STATE_LEN {
                let [one, another] = [line, other].map(|place| covariance.get(place, place) + VARIANCE_ROUNDING);
                let limit = (one * another).sqrt() + ROUNDING;
                if covariance.get(line, other).abs() > limit {
                    let column = columns[Covariance::index(line, other)];
                    let reason = format!("is beyond the product of its standard deviations, {limit:.4}");
                    return Err(row.error(column, reason));
                }
            }
        }
        Ok(Some(covariance))
    }

    fn trace(&self, row: Cells<'_>) -> Result<Option<f64>, CsvError> {
        match (self.trace, row.number_or_empty(self.trace)?) {
            (Some(column), Some(trace)) if trace < 0.0 => Err(row.error(column, "is negative, which no trace is")),
            (_, trace) => Ok(trace),
        }
    }

    fn method(&self, row: Cells<'_>) -> Result<u8, CsvError> {
        match (self.method, row.text(self.method)?) {
            (Some(column), Some(_)) => row.whole(column),
            _ => Ok(0),
        }
    }

    /// Kind of track, and number of members of a group.
    fn kind(&self, row: Cells<'_>) -> Result<(TrackKind, u16), CsvError> {
        let kind = match (self.kind, row.text(self.kind)?) {
            (Some(column), Some(word)) => {
                let known = TrackKind::ALL.into_iter().find(|kind| kind.word() == word);
                known.ok_or_else(|| row.error(column, "is no kind of track; write single or group"))?
            }
            _ => TrackKind::Single,
        };
        let members = match (self.members, row.text(self.members)?) {
            (Some(column), Some(_)) => row.whole(column)?,
            _ => 0,
        };
        let fits = (kind == TrackKind::Group) == (members > 0);
        match self.members.or(self.kind).filter(|_| !fits) {
            Some(column) => Err(row.error(
                column,
                "does not fit the kind: a group has members, a single target none",
            )),
            None => Ok((kind, members)),
        }
    }

    fn target_type(&self, row: Cells<'_>) -> Result<TargetType, CsvError> {
        let confidence = row.number_or_empty(self.confidence)?;
        match (self.target_type, row.text(self.target_type)?, self.confidence, confidence) {
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

    fn identity(&self, row: Cells<'_>) -> Result<Identity, CsvError> {
        let mut identity = Identity::default();
        if let Some(address) = digits(row, self.address, 16, 6, "an address of up to six hexadecimal digits")? {
            identity = identity.with_address(address);
        }
        if let Some(code) = digits(row, self.mode_3a, 8, 4, "a Mode 3/A code of up to four octal digits")? {
            identity = identity.with_mode_3a(code as u16);
        }
        if let (Some(column), Some(text)) = (self.callsign, row.text(self.callsign)?) {
            let callsign = callsign(text)
                .ok_or_else(|| row.error(column, "is no callsign; write up to eight characters of plain ASCII"))?;
            identity = identity.with_callsign(callsign);
        }
        Ok(identity)
    }
}

/// A column of zeros and ones; where it is missing or empty, ones.
fn flag(row: Cells<'_>, column: Option<Column>) -> Result<bool, CsvError> {
    let Some(column) = column else { return Ok(true) };
    match row.text(column)? {
        None | Some("1") => Ok(true),
        Some("0") => Ok(false),
        Some(_) => Err(row.error(column, "is neither 0 nor 1")),
    }
}

fn digits(
    row: Cells<'_>,
    column: Option<Column>,
    radix: u32,
    digits_max: usize,
    what: &str,
) -> Result<Option<u32>, CsvError> {
    let (Some(column), Some(text)) = (column, row.text(column)?) else {
        return Ok(None);
    };
    let plain = text.len() <= digits_max && text.chars().all(|character| character.is_digit(radix));
    match u32::from_str_radix(text, radix) {
        Ok(number) if plain => Ok(Some(number)),
        _ => Err(row.error(column, format!("is not {what}"))),
    }
}

/// A callsign padded with blanks.
fn callsign(text: &str) -> Option<Callsign> {
    let mut callsign = *b"        ";
    callsign.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
    text.bytes()
        .all(|octet| octet.is_ascii_graphic() || octet == b' ')
        .then_some(callsign)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const HEADER: &str = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,P00,P01,P02,P03,P04,P05,P11,P12,P13,P14,P15,\
                          P22,P23,P24,P25,P33,P34,P35,P44,P45,P55,state";
    const VARIANCES: &str = "25,0,0,0,0,0,25,0,0,0,0,100,0,0,0,4,0,0,4,0,9";

    /// The tracks of `rows` below a header with further `columns`; sensor 9 is no source.
    fn read(columns: &str, rows: &str) -> Vec<Result<SensorTrack, String>> {
        let text = format!("{HEADER}{columns}\n{rows}");
        let source_of = |sensor: u32| (sensor < 9).then_some(sensor as u16 + 100);
        let reader = SensorTrackReader::new(text.as_bytes(), 1_000, source_of).unwrap();
        reader.map(|row| row.map_err(|error| error.to_string())).collect()
    }

    #[test]
    fn a_row_without_further_columns_is_a_whole_report() {
        let rows = format!("2.5,3,42,1,-2,3.25,4,5,-6,{VARIANCES},coasted,7\n");
        let found = read(",truth_id", &rows);
        let mut covariance = Covariance::diagonal([5.0, 5.0, 10.0], [2.0, 2.0, 3.0]);
        let expected = SensorTrack {
            time_of_measurement_ns: 2_500_001_000,
            track_number: 42,
            source: 103,
            valid: bits::HEIGHT | bits::VELOCITY | bits::VERTICAL_RATE | bits::OWN_COVARIANCE,
            position_m: [1.0, -2.0, 3.25],
            velocity_mps: [4.0, 5.0, -6.0],
            covariance,
            state: TrackState::Coasted as u8,
            ..SensorTrack::default()
        };
        assert_eq!(found, [Ok(expected)]);
        covariance.set(1, 4, -3.5);
        let correlated = rows.replace("25,0,0,0,0,100", "25,0,0,-3.5,0,100");
        assert_eq!(
            read(",truth_id", &correlated)[0].as_ref().unwrap().covariance,
            covariance
        );
    }

    #[test]
    fn further_columns_are_read_by_name_and_may_be_empty() {
        let columns = ",velocity_valid,callsign,method,address,trace,mode_3a,height_valid";
        let row = |further: &str| format!("0,1,1,0,0,0,0,0,0,{VARIANCES},tentative,{further}\n");
        let track = read(columns, &row("1,VLG 20,3,3444cf,50.5,0412,0"))[0].clone().unwrap();
        let identity = Identity::default()
            .with_address(0x3444cf)
            .with_mode_3a(0o412)
            .with_callsign(*b"VLG 20  ");
        assert_eq!((track.identity, track.method, track.trace_m2), (identity, 3, 50.5));
        assert_eq!(track.valid, bits::VELOCITY | bits::OWN_COVARIANCE | bits::TRACE);
        let track = read(columns, &row(",,,,,,"))[0].clone().unwrap();
        assert_eq!((track.identity, track.method), (Identity::default(), 0));
        assert!(track.has(bits::HEIGHT | bits::VELOCITY) && !track.has(bits::TRACE));
    }

    #[test]
    fn a_row_may_have_the_trace_in_place_of_the_covariance() {
        let none = ",".repeat(COVARIANCE_COLUMNS.len() - 1);
        let row = |covariance: &str, trace: &str| format!("0,1,1,7,0,0,9,0,0,{covariance},confirmed,{trace}\n");
        let track = read(",trace", &row(&none, "200"))[0].clone().unwrap();
        assert_eq!((track.trace_m2, track.covariance), (200.0, Covariance::default()));
        assert!(track.has(bits::TRACE) && !track.has(bits::OWN_COVARIANCE));
        let error = read(",trace", &row(&none, "")).remove(0).unwrap_err();
        assert!(error.contains("P00"), "{error}");

        let header = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,state,trace";
        let text = format!("{header}\n0,1,1,7,0,0,9,0,0,confirmed,200\n1,1,1,7,0,0,9,0,0,confirmed,\n");
        let reader = SensorTrackReader::new(text.as_bytes(), 0, |_| Some(101)).unwrap();
        let [whole, short] = &reader.collect::<Vec<_>>()[..] else {
            panic!("two rows")
        };
        assert_eq!(
            whole.as_ref().unwrap(),
            &SensorTrack {
                time_of_measurement_ns: 0,
                ..track
            }
        );
        assert!(short.as_ref().unwrap_err().to_string().contains("column trace"));
        let missing = SensorTrackReader::new(&header.as_bytes()[..header.len() - 6], 0, |_| Some(101));
        assert!(missing.err().is_some_and(|error| error.to_string().contains("P00")));
    }

    #[test]
    fn kind_and_type_are_read_and_what_contradicts_itself_is_refused() {
        let read_row = |columns: &str, further: &str| {
            let rows = format!("0,1,1,0,0,0,0,0,0,{VARIANCES},confirmed,{further}\n");
            let found = read(columns, &rows).remove(0);
            found.map(|track| (track.kind, track.members, track.target_type))
        };
        let all = ",kind,members,type,type_confidence";
        let (single, group) = (TrackKind::Single as u8, TrackKind::Group as u8);
        let patrol = TargetType::new("patrol 7", 0.7).unwrap();
        assert_eq!(read_row(all, "group,4,patrol 7,0.7"), Ok((group, 4, patrol)));
        assert_eq!(read_row(all, "single,0,patrol 7,0.7"), Ok((single, 0, patrol)));
        assert_eq!(read_row(all, ",,,"), Ok((single, 0, TargetType::default())));
        assert_eq!(
            read_row(",members,kind", "2,group"),
            Ok((group, 2, TargetType::default()))
        );
        for (columns, further, expected) in [
            (
                all,
                "flock,4,,",
                "column kind: \"flock\" is no kind of track; write single or group",
            ),
            (all, "group,,,", "column members: \"\" does not fit the kind"),
            (all, "group,0,,", "column members: \"0\" does not fit the kind"),
            (all, "single,3,,", "column members: \"3\" does not fit the kind"),
            (all, ",3,,", "column members: \"3\" does not fit the kind"),
            (
                all,
                "group,70000,,",
                "column members: \"70000\" is no whole number of the kind u16",
            ),
            (
                ",kind",
                "group",
                "column kind: \"group\" does not fit the kind: a group has members",
            ),
            (all, ",,patrol 7,", "column type: \"patrol 7\" needs a type_confidence"),
            (",type", "patrol 7", "column type: \"patrol 7\" needs a type_confidence"),
            (all, ",,,0.5", "column type_confidence: \"0.5\" is of no type"),
            (
                all,
                ",,patrol 7,1.5",
                "column type: \"patrol 7\" with confidence 1.5 is no type",
            ),
            (
                all,
                ",,patrol 7,0",
                "column type: \"patrol 7\" with confidence 0 is no type",
            ),
            (all, ",,thirteen char,0.5", "is no type; write 1 to 12 characters"),
        ] {
            let text = read_row(columns, further).unwrap_err();
            assert!(text.starts_with("line 2, ") && text.contains(expected), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_place_and_remedy() {
        let columns = ",address,mode_3a,callsign,method,trace,height_valid";
        let good = format!("0,1,1,0,0,0,0,0,0,{VARIANCES},confirmed,,,,,,");
        read(columns, &good)[0].as_ref().unwrap();
        for (from, to, expected) in [
            ("0,1,1", "0,9,1", "column sensor_id: \"9\" is no sensor of this run"),
            ("0,1,1", "0,1,-1", "column sensor_track_id: \"-1\" is no whole number"),
            ("0,1,1,0", "0,1,1,NaN", "column x: \"NaN\" is not finite"),
            ("25,0,0", "-25,0,0", "column P00: \"-25\" is negative"),
            (
                "25,0,0",
                "25,25.1,0",
                "column P01: \"25.1\" is beyond the product of its standard deviations, 25.0011",
            ),
            (
                "confirmed",
                "Confirmed",
                "column state: \"Confirmed\" is no state; write one of tentative, confirmed",
            ),
            (
                "confirmed,",
                "confirmed,3444CFF",
                "column address: \"3444CFF\" is not an address",
            ),
            (
                "confirmed,",
                "confirmed,+44",
                "column address: \"+44\" is not an address",
            ),
            (
                "confirmed,,",
                "confirmed,,7800",
                "column mode_3a: \"7800\" is not a Mode 3/A code",
            ),
            (
                "confirmed,,,",
                "confirmed,,,TOOLONG12",
                "column callsign: \"TOOLONG12\" is no callsign",
            ),
            ("confirmed,,,", "confirmed,,,É", "column callsign: \"É\" is no callsign"),
            (
                "confirmed,,,,",
                "confirmed,,,,256",
                "column method: \"256\" is no whole number of the kind u8",
            ),
            ("confirmed,,,,,", "confirmed,,,,,-1", "column trace: \"-1\" is negative"),
            (
                "confirmed,,,,,,",
                "confirmed,,,,,,yes",
                "column height_valid: \"yes\" is neither 0 nor 1",
            ),
        ] {
            let row = good.replacen(from, to, 1);
            let [found] = &read(columns, &row)[..] else {
                panic!("{row}")
            };
            let text = found.as_ref().unwrap_err();
            assert!(text.starts_with("line 2, ") && text.contains(expected), "{text}");
        }
    }

    /// A standard deviation of 5 mm/s is written as a variance of 0.0000.
    #[test]
    fn a_covariance_beside_a_variance_that_rounding_took_is_read() {
        let mut covariance = Covariance::default();
        for (line, other, value) in [(0, 0, 1e4), (1, 1, 1.0), (3, 3, 25e-6), (0, 3, 0.4)] {
            covariance.set(line, other, value);
        }
        let track = SensorTrack {
            covariance,
            valid: bits::OWN_COVARIANCE | bits::VELOCITY,
            track_number: 1,
            ..SensorTrack::default()
        };
        let mut text = Vec::new();
        SensorTrackWriter::begin(&mut text, 0).unwrap().write(&track).unwrap();
        let mut found = SensorTrackReader::new(&text[..], 0, |_| Some(0)).unwrap();
        assert_eq!(found.next().unwrap().unwrap().covariance.get(0, 3), 0.4);
    }

    /// A track whose numbers have no more decimals than files carry.
    fn track() -> impl Strategy<Value = SensorTrack> {
        let thousandths =
            || prop::array::uniform3(-1_000_000_000i64..1_000_000_000).prop_map(|all| all.map(|one| one as f64 / 1e3));
        let sigmas = prop::array::uniform6(0.0f64..1e4);
        let correlation = -0.9f64..0.9;
        let identity = (
            prop::option::of(0u32..1 << 24),
            prop::option::of(0u16..0o10000),
            prop::option::of("[A-Z0-9]{1,8}"),
        );
        let flags = (0u16..16, 0u8..4, any::<u8>());
        let members = prop::option::of(1u16..=u16::MAX);
        let target_type = prop::option::of(("[A-Za-z0-9]{1,6}[ -]?[A-Z0-9]{1,5}", 1e-6f64..=1.0));
        (
            (0i64..4_000_000_000_000_000, 0u16..1000, any::<u32>()),
            (thousandths(), thousandths(), sigmas, correlation),
            (identity, flags, 0i64..1_000_000_000, members, target_type),
        )
            .prop_map(
                |((time_ns, source, number), (position_m, velocity_mps, sigmas, correlation), rest)| {
                    let ((address, code, name), (flags, state, method), trace, members, target_type) = rest;
                    let mut identity = Identity::default();
                    identity = address.map_or(identity, |address| identity.with_address(address));
                    identity = code.map_or(identity, |code| identity.with_mode_3a(code));
                    if let Some(name) = name {
                        identity = identity.with_callsign(callsign(&name).unwrap());
                    }
                    let mut covariance = Covariance::default();
                    for line in 0..STATE_LEN {
                        for other in line..STATE_LEN {
                            let share = if line == other { 1.0 } else { correlation };
                            let value = sigmas[line] * sigmas[other] * share;
                            covariance.set(line, other, (value * 1e4).round() / 1e4);
                        }
                    }
                    let bit = |place: u16, bit: u16| if flags >> place & 1 == 1 { bit } else { 0 };
                    let (height, velocity, trace_bit) =
                        (bit(0, bits::HEIGHT), bit(1, bits::VELOCITY), bit(2, bits::TRACE));
                    let vertical = if height != 0 && velocity != 0 {
                        bits::VERTICAL_RATE
                    } else {
                        0
                    };
                    SensorTrack {
                        time_of_measurement_ns: time_ns,
                        source,
                        track_number: number,
                        identity,
                        position_m,
                        velocity_mps,
                        covariance,
                        trace_m2: if trace_bit != 0 { trace as f64 / 1e4 } else { 0.0 },
                        state,
                        method,
                        valid: bits::OWN_COVARIANCE | height | velocity | vertical | trace_bit,
                        kind: members.map_or(TrackKind::Single, |_| TrackKind::Group) as u8,
                        members: members.unwrap_or(0),
                        target_type: target_type
                            .map(|(name, confidence)| TargetType::new(&name, confidence).unwrap())
                            .unwrap_or_default(),
                        ..SensorTrack::default()
                    }
                },
            )
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(tracks in prop::collection::vec(track(), 0..4), first_day_ns in 0i64..1 << 60) {
            let write = |tracks: &[SensorTrack]| {
                let mut text = Vec::new();
                let mut writer = SensorTrackWriter::begin(&mut text, first_day_ns).unwrap();
                for track in tracks {
                    writer.write(track).unwrap();
                }
                text
            };
            let moved = |mut track: SensorTrack| {
                track.time_of_measurement_ns += first_day_ns;
                track
            };
            let tracks: Vec<_> = tracks.into_iter().map(moved).collect();
            let text = write(&tracks);
            let source_of = |sensor: u32| u16::try_from(sensor - 1).ok();
            let reader = SensorTrackReader::new(&text[..], first_day_ns, source_of).unwrap();
            let found: Vec<_> = reader.map(Result::unwrap).collect();
            prop_assert_eq!(&found, &tracks);
            prop_assert_eq!(write(&found), text);
        }
    }
}
