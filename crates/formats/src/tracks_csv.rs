//! Sensor tracks and system tracks as CSV rows (FM-5).
//!
//! Numbers are written with a fixed number of decimals, so that the same tracks give the same bytes. Times are seconds
//! since midnight (UTC) of the recording's first day, exact to the nanosecond. Several values in one column are joined
//! with `|`; no field needs quotes.

use std::io::{self, Write};

use csv_table::{COVARIANCE_COLUMNS, write_time};
use messages::{
    COVARIANCE_LEN, Identity, SensorTrack, SystemTrack, TargetType, TrackKind, TrackState, sensor_track_bits,
};
use observations::sensor_id;

/// The columns of a track's kind and of its target's type.
const DESCRIPTION_NAMES: &str = "kind,members,type,type_confidence";

/// Writes sensor tracks.
#[derive(Debug)]
pub struct SensorTrackWriter<W: Write> {
    writer: W,
    first_day_ns: i64,
}

impl<W: Write> SensorTrackWriter<W> {
    /// Goes on writing to something that has its header line.
    pub fn resume(writer: W, first_day_ns: i64) -> Self {
        Self { writer, first_day_ns }
    }

    /// Writes the header line; times will be counted from `first_day_ns` (UTC, nanoseconds).
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn begin(mut writer: W, first_day_ns: i64) -> io::Result<Self> {
        write_sensor_track_names(&mut writer)?;
        writeln!(writer)?;
        Ok(Self { writer, first_day_ns })
    }

    /// Writes one row. `sensor_id` is the source's place in the configuration, from 1.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn write(&mut self, track: &SensorTrack) -> io::Result<()> {
        write_sensor_track(&mut self.writer, self.first_day_ns, sensor_id(track.source), track)?;
        writeln!(self.writer)
    }

    /// Flushes the writer.
    ///
    /// # Errors
    /// If it fails.
    pub fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }

    /// What was written to; not flushed.
    pub fn into_inner(self) -> W {
        self.writer
    }
}

/// Writes tracks that were made of detections (FM-6): sensor tracks with what their tracker thinks of them.
#[derive(Debug)]
pub struct TrackerTrackWriter<W: Write> {
    writer: W,
    first_day_ns: i64,
}

impl<W: Write> TrackerTrackWriter<W> {
    /// The `sensor_id` of the tracker itself.
    pub const SENSOR_ID: u32 = 0;

    /// Writes the header line; times will be counted from `first_day_ns` (UTC, nanoseconds).
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn begin(mut writer: W, first_day_ns: i64) -> io::Result<Self> {
        write_sensor_track_names(&mut writer)?;
        writeln!(writer, ",hypotheses,reliability")?;
        Ok(Self { writer, first_day_ns })
    }

    /// Writes one row: a track, the number of hypotheses of its cluster, and the sum of the reliabilities of those that
    /// contain it.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn write(&mut self, track: &SensorTrack, hypotheses: u32, reliability: f64) -> io::Result<()> {
        write_sensor_track(&mut self.writer, self.first_day_ns, Self::SENSOR_ID, track)?;
        writeln!(self.writer, ",{hypotheses},{reliability:.6}")
    }

    /// What was written to; not flushed.
    pub fn into_inner(self) -> W {
        self.writer
    }
}

/// Writes system tracks.
#[derive(Debug)]
pub struct SystemTrackWriter<W: Write> {
    writer: W,
    first_day_ns: i64,
    sensor_ids: Option<Vec<u32>>,
}

impl<W: Write> SystemTrackWriter<W> {
    /// Goes on writing to something that has its header line.
    pub fn resume(writer: W, first_day_ns: i64) -> Self {
        Self {
            writer,
            first_day_ns,
            sensor_ids: None,
        }
    }

    /// Shows source number n as `sensor_ids[n]` instead of [`sensor_id`]: for tracks from files that have ids of their own.
    #[must_use]
    pub fn with_sensor_ids(mut self, sensor_ids: Vec<u32>) -> Self {
        self.sensor_ids = Some(sensor_ids);
        self
    }

    /// Writes the header line; times will be counted from `first_day_ns` (UTC, nanoseconds).
    ///
    /// # Errors
    /// If `writer` fails.
    pub fn begin(mut writer: W, first_day_ns: i64) -> io::Result<Self> {
        write!(
            writer,
            "time_s,system_track_id,x,y,z,vx,vy,vz,state,sources,weights,selected,lambda,"
        )?;
        write!(writer, "address,mode_3a,callsign,")?;
        write!(writer, "{}", COVARIANCE_COLUMNS.join(","))?;
        writeln!(
            writer,
            ",sensor_track_ids,report_times_s,height_valid,trigger,merged_into,{DESCRIPTION_NAMES}"
        )?;
        Ok(Self::resume(writer, first_day_ns))
    }

    /// Writes one row.
    ///
    /// # Errors
    /// If the writer fails.
    pub fn write(&mut self, track: &SystemTrack) -> io::Result<()> {
        let (out, first_day_ns) = (&mut self.writer, self.first_day_ns);
        let sensor_id = |source: u16| match &self.sensor_ids {
            Some(ids) => ids
                .get(usize::from(source))
                .copied()
                .unwrap_or_else(|| sensor_id(source)),
            None => sensor_id(source),
        };
        let parts = track.contributions();
        write_time(out, track.reference_time_ns - first_day_ns)?;
        write!(out, ",{}", track.track_number)?;
        write_kinematics(out, &track.position_m, &track.velocity_mps)?;
        write!(out, ",{},", state_word(track.state))?;
        write_joined(out, parts, |out, part| write!(out, "{}", sensor_id(part.source)))?;
        write_joined(out, parts, |out, part| write!(out, "{:.4}", part.weight))?;
        if track.selected_source != messages::NO_SOURCE {
            write!(out, "{}", sensor_id(track.selected_source))?;
        }
        write!(out, ",")?;
        write_joined(out, parts, |out, part| match part.accuracy.is_nan() {
            true => Ok(()),
            false => write!(out, "{:.4}", part.accuracy),
        })?;
        // The lists each end with the comma that the identity begins with.
        write_identity_fields(out, &track.identity)?;
        write!(out, ",")?;
        write_covariance_values(out, &track.covariance.upper)?;
        write!(out, ",")?;
        write_joined(out, parts, |out, part| write!(out, "{}", part.track_number))?;
        write_joined(out, parts, |out, part| {
            write_time(out, part.time_of_measurement_ns - first_day_ns)
        })?;
        write!(out, "{},", track.height_valid)?;
        if track.trigger_source != messages::NO_SOURCE {
            write!(out, "{}", sensor_id(track.trigger_source))?;
        }
        write!(out, ",")?;
        if track.merged_into != 0 {
            write!(out, "{}", track.merged_into)?;
        }
        write_description(out, track.kind, track.members, &track.target_type)?;
        writeln!(out)
    }

    /// Flushes the writer.
    ///
    /// # Errors
    /// If it fails.
    pub fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }

    /// What was written to; not flushed.
    pub fn into_inner(self) -> W {
        self.writer
    }
}

fn state_word(code: u8) -> &'static str {
    TrackState::from_code(code).map_or("", TrackState::word)
}

fn write_sensor_track_names(out: &mut impl Write) -> io::Result<()> {
    write!(out, "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,")?;
    write!(out, "{}", COVARIANCE_COLUMNS.join(","))?;
    write!(
        out,
        ",state,address,mode_3a,callsign,method,trace,height_valid,velocity_valid,{DESCRIPTION_NAMES}"
    )
}

fn write_sensor_track(out: &mut impl Write, first_day_ns: i64, sensor_id: u32, track: &SensorTrack) -> io::Result<()> {
    write_time(out, track.time_of_measurement_ns.saturating_sub(first_day_ns))?;
    write!(out, ",{sensor_id},{}", track.track_number)?;
    write_kinematics(out, &track.position_m, &track.velocity_mps)?;
    write_covariance(out, &track.covariance.upper)?;
    write!(out, ",{}", state_word(track.state))?;
    write_identity(out, &track.identity)?;
    write!(out, ",{},", track.method)?;
    if track.has(sensor_track_bits::TRACE) {
        write!(out, "{:.4}", track.trace_m2)?;
    }
    let flag = |bit: u16| u8::from(track.has(bit));
    write!(
        out,
        ",{},{}",
        flag(sensor_track_bits::HEIGHT),
        flag(sensor_track_bits::VELOCITY)
    )?;
    write_description(out, track.kind, track.members, &track.target_type)
}

/// The kind of track, a group's members, the target's type and its confidence; all empty for a single target of no type. A group
/// without members is none.
fn write_description(out: &mut impl Write, kind: u8, members: u16, target_type: &TargetType) -> io::Result<()> {
    match TrackKind::from_code(kind) {
        Some(TrackKind::Group) if members > 0 => write!(out, ",{},{members},", TrackKind::Group.word())?,
        _ => write!(out, ",,,")?,
    }
    match target_type.name() {
        Some(name) => {
            write_plain(out, name, |character| (b' '..=b'~').contains(&character))?;
            write!(out, ",{}", target_type.confidence)
        }
        None => write!(out, ","),
    }
}

fn write_kinematics(out: &mut impl Write, position_m: &[f64; 3], velocity_mps: &[f64; 3]) -> io::Result<()> {
    position_m
        .iter()
        .chain(velocity_mps)
        .try_for_each(|value| write!(out, ",{}", Plain(*value, 3)))
}

fn write_covariance(out: &mut impl Write, upper: &[f64; COVARIANCE_LEN]) -> io::Result<()> {
    write!(out, ",")?;
    write_covariance_values(out, upper)
}

fn write_covariance_values(out: &mut impl Write, upper: &[f64; COVARIANCE_LEN]) -> io::Result<()> {
    let mut separator = "";
    for value in upper {
        write!(out, "{separator}{}", Plain(*value, 4))?;
        separator = ",";
    }
    Ok(())
}

fn write_identity(out: &mut impl Write, identity: &Identity) -> io::Result<()> {
    write!(out, ",")?;
    write_identity_fields(out, identity)
}

/// Address (hexadecimal), Mode 3/A code (octal), callsign; empty where unknown.
fn write_identity_fields(out: &mut impl Write, identity: &Identity) -> io::Result<()> {
    if let Some(address) = identity.address() {
        write!(out, "{address:06X}")?;
    }
    write!(out, ",")?;
    if let Some(code) = identity.mode_3a() {
        write!(out, "{code:04o}")?;
    }
    write!(out, ",")?;
    write_plain(out, identity.callsign().unwrap_or_default(), |character| {
        character.is_ascii_graphic()
    })
}

/// Text from outside, which is not trusted to leave the columns alone, nor to be of nothing but `allowed` characters.
fn write_plain(out: &mut impl Write, text: &str, allowed: impl Fn(u8) -> bool) -> io::Result<()> {
    text.bytes().try_for_each(|character| {
        let plain = allowed(character) && !b",|\"".contains(&character);
        out.write_all(&[if plain { character } else { b'?' }])
    })
}

fn write_joined<W: Write, T>(
    out: &mut W,
    parts: &[T],
    mut one: impl FnMut(&mut W, &T) -> io::Result<()>,
) -> io::Result<()> {
    for (index, part) in parts.iter().enumerate() {
        if index > 0 {
            write!(out, "|")?;
        }
        one(out, part)?;
    }
    write!(out, ",")
}

/// A number with fixed decimals, and no minus sign before zero.
struct Plain(f64, usize);

impl std::fmt::Display for Plain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(value, decimals) = *self;
        let half = 0.5 * 10f64.powi(-(decimals as i32));
        write!(f, "{:.decimals$}", if value.abs() < half { 0.0 } else { value })
    }
}

#[cfg(test)]
mod tests {
    use messages::{Contribution, Covariance, contribution_bits};

    use super::*;

    fn columns(text: &str) -> Vec<(String, String)> {
        let mut lines = text.lines();
        let (header, row) = (lines.next().unwrap(), lines.next().unwrap());
        assert_eq!(header.split(',').count(), row.split(',').count(), "{header}\n{row}");
        header
            .split(',')
            .map(str::to_owned)
            .zip(row.split(',').map(str::to_owned))
            .collect()
    }

    fn value<'a>(columns: &'a [(String, String)], name: &str) -> &'a str {
        &columns
            .iter()
            .find(|(column, _)| column == name)
            .unwrap_or_else(|| panic!("no column {name}"))
            .1
    }

    #[test]
    fn a_sensor_track_has_every_named_column() {
        let track = SensorTrack {
            time_of_measurement_ns: 1_000 + 86_400_007_812_500,
            source: 1,
            track_number: 42,
            identity: Identity::default()
                .with_address(0x3444cf)
                .with_mode_3a(0o5545)
                .with_callsign(*b"VLG20,M "),
            position_m: [1.0, -2.0005, -0.0001],
            covariance: Covariance::diagonal([2.0; 3], [3.0; 3]),
            state: TrackState::Coasted as u8,
            valid: sensor_track_bits::VELOCITY,
            kind: TrackKind::Group as u8,
            members: 4,
            target_type: TargetType::new("fast,boat 2", 0.8125).unwrap(),
            ..SensorTrack::default()
        };
        let mut writer = SensorTrackWriter::begin(Vec::new(), 1_000).unwrap();
        writer.write(&track).unwrap();
        let columns = columns(std::str::from_utf8(&writer.writer).unwrap());
        assert_eq!(value(&columns, "time_s"), "86400.0078125");
        assert_eq!(value(&columns, "sensor_id"), "2");
        assert_eq!(value(&columns, "z"), "0.000", "no negative zero");
        assert_eq!(value(&columns, "P33"), "9.0000");
        assert_eq!(value(&columns, "state"), "coasted");
        assert_eq!(value(&columns, "address"), "3444CF");
        assert_eq!(value(&columns, "mode_3a"), "5545");
        assert_eq!(value(&columns, "callsign"), "VLG20?M");
        assert_eq!(
            (value(&columns, "height_valid"), value(&columns, "velocity_valid")),
            ("0", "1")
        );
        assert_eq!((value(&columns, "kind"), value(&columns, "members")), ("group", "4"));
        // What somebody published without checking it is not written as if it were known.
        let mut writer = SensorTrackWriter::begin(Vec::new(), 1_000).unwrap();
        let mut hostile = SensorTrack { members: 0, ..track };
        hostile.target_type.confidence = 7.0;
        writer.write(&hostile).unwrap();
        assert!(writer.writer.ends_with(b",0,1,,,,\n"));
        assert_eq!(
            (value(&columns, "type"), value(&columns, "type_confidence")),
            ("fast?boat 2", "0.8125")
        );
    }

    #[test]
    fn a_system_track_lists_its_contributions() {
        let mut track = SystemTrack {
            reference_time_ns: 2_500_000_000,
            track_number: 7,
            trigger_source: 0,
            selected_source: 1,
            state: TrackState::Confirmed as u8,
            source_count: 2,
            contribution_count: 2,
            ..SystemTrack::default()
        };
        track.contributions[0] = Contribution {
            track_number: 5,
            source: 0,
            accuracy: f64::NAN,
            ..Contribution::default()
        };
        track.contributions[1] = Contribution {
            time_of_measurement_ns: 2_000_000_000,
            track_number: 9,
            source: 1,
            flags: contribution_bits::FRESH,
            weight: 1.0,
            accuracy: 12.34567,
        };
        let mut writer = SystemTrackWriter::begin(Vec::new(), 0).unwrap();
        writer.write(&track).unwrap();
        let columns = columns(std::str::from_utf8(&writer.writer).unwrap());
        for (name, expected) in [
            ("time_s", "2.5"),
            ("system_track_id", "7"),
            ("state", "confirmed"),
            ("sources", "1|2"),
            ("weights", "0.0000|1.0000"),
            ("selected", "2"),
            ("lambda", "|12.3457"),
            ("address", ""),
            ("P00", "0.0000"),
            ("sensor_track_ids", "5|9"),
            ("report_times_s", "0|2"),
            ("trigger", "1"),
            ("merged_into", ""),
            ("kind", ""),
            ("members", ""),
            ("type", ""),
            ("type_confidence", ""),
        ] {
            assert_eq!(value(&columns, name), expected, "{name}");
        }
    }
}
