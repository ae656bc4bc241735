//! Sensor tracks and system tracks as CSV rows (FM-5).
//!
//! Numbers are written with a fixed number of decimals, so that the same tracks give the same bytes. Times are seconds
//! since midnight (UTC) of the recording's first day, exact to the nanosecond. Several values in one column are joined
//! with `|`; no field needs quotes.

use std::io::{self, Write};

use csv_table::COVARIANCE_COLUMNS;
use frames::{Geodetic, SystemFrame};
use messages::{
    COVARIANCE_LEN, Identity, SensorTrack, SystemTrack, TargetType, TrackKind, TrackState, sensor_track_bits,
};

use crate::rows::{Reference, Row, RowWriter, Utc};

/// The columns of a track's kind and of its target's type.
const DESCRIPTION_NAMES: &str = "kind,members,type,type_confidence";

/// Writes sensor tracks.
pub type SensorTrackWriter<W> = RowWriter<SensorTrack, W>;
/// Writes system tracks.
pub type SystemTrackWriter<W> = RowWriter<SystemTrack, W>;
/// Writes system tracks with their places in the world.
pub type PlacedTrackWriter<W> = RowWriter<PlacedTrack, W>;
/// Writes the tracks of a tracker.
pub type TrackerTrackWriter<W> = RowWriter<TrackerTrack, W>;

/// A track that a tracker has made of several sensors' detections.
#[derive(Clone, Copy, Debug)]
pub struct TrackerTrack {
    /// The track as a sensor would report it; its source does not matter.
    pub track: SensorTrack,
    /// Number of hypotheses of its cluster.
    pub hypotheses: u32,
    /// Sum of the reliabilities of those that contain it, 0 to 1.
    pub reliability: f64,
}

impl TrackerTrack {
    /// The `sensor_id` of the tracker itself.
    pub const SENSOR_ID: u32 = 0;
}

impl Row for SensorTrack {
    fn columns() -> String {
        let covariance = COVARIANCE_COLUMNS.join(",");
        format!(
            "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,{covariance},state,address,mode_3a,callsign,method,trace,\
             height_valid,velocity_valid,{DESCRIPTION_NAMES}"
        )
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        write_sensor_track(out, reference, reference.sensor_id(self.source), self)
    }
}

impl Row for TrackerTrack {
    fn columns() -> String {
        format!("{},hypotheses,reliability", SensorTrack::columns())
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        write_sensor_track(out, reference, Self::SENSOR_ID, &self.track)?;
        write!(out, ",{},{:.6}", self.hypotheses, self.reliability)
    }
}

/// A system track with its place in the world.
#[derive(Clone, Copy, Debug)]
pub struct PlacedTrack {
    /// The track.
    pub track: SystemTrack,
    /// Latitude, longitude and height of its position.
    pub place: Geodetic,
}

impl PlacedTrack {
    /// The track in the system frame in which its position is given.
    pub fn new(track: &SystemTrack, frame: &SystemFrame) -> Self {
        Self {
            track: *track,
            place: frame.to_geodetic(track.position_m),
        }
    }
}

impl Row for PlacedTrack {
    /// The columns of a system track come first, so that readers by place find these where they were.
    fn columns() -> String {
        format!(
            "{},utc,latitude,longitude,flight_level,level,level_age_s",
            SystemTrack::columns()
        )
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let Self { track, place } = self;
        track.write(out, reference)?;
        write!(out, ",{}", Utc(track.reference_time_ns))?;
        // Seven decimals are a centimetre.
        write!(
            out,
            ",{},{},",
            Plain(place.latitude_deg(), 7),
            Plain(place.longitude_deg(), 7)
        )?;
        if track.height_valid != 0 {
            write!(out, "{}", Plain(place.flight_level(), 2))?;
        }
        match track.level_valid {
            0 => write!(out, ",,"),
            _ => write!(
                out,
                ",{},{}",
                Plain(f64::from(track.level) / 4.0, 2),
                Plain(f64::from(track.level_age_ms) / 1e3, 3)
            ),
        }
    }
}

impl Row for SystemTrack {
    fn columns() -> String {
        let covariance = COVARIANCE_COLUMNS.join(",");
        format!(
            "time_s,system_track_id,x,y,z,vx,vy,vz,state,sources,weights,selected,lambda,address,mode_3a,callsign,\
             {covariance},sensor_track_ids,report_times_s,height_valid,trigger,merged_into,{DESCRIPTION_NAMES}"
        )
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        let parts = self.contributions();
        reference.write_time(out, self.reference_time_ns)?;
        write!(out, ",{}", self.track_number)?;
        write_kinematics(out, &self.position_m, &self.velocity_mps)?;
        write!(out, ",{},", state_word(self.state))?;
        write_joined(out, parts, |out, part| {
            write!(out, "{}", reference.sensor_id(part.source))
        })?;
        write_joined(out, parts, |out, part| write!(out, "{:.4}", part.weight))?;
        if self.selected_source != messages::NO_SOURCE {
            write!(out, "{}", reference.sensor_id(self.selected_source))?;
        }
        write!(out, ",")?;
        write_joined(out, parts, |out, part| match part.accuracy.is_nan() {
            true => Ok(()),
            false => write!(out, "{:.4}", part.accuracy),
        })?;
        // The lists each end with the comma that the identity begins with.
        write_identity_fields(out, &self.identity)?;
        write!(out, ",")?;
        write_covariance_values(out, &self.covariance.upper)?;
        write!(out, ",")?;
        write_joined(out, parts, |out, part| write!(out, "{}", part.track_number))?;
        write_joined(out, parts, |out, part| {
            reference.write_time(out, part.time_of_measurement_ns)
        })?;
        write!(out, "{},", self.height_valid)?;
        if self.trigger_source != messages::NO_SOURCE {
            write!(out, "{}", reference.sensor_id(self.trigger_source))?;
        }
        write!(out, ",")?;
        if self.merged_into != 0 {
            write!(out, "{}", self.merged_into)?;
        }
        write_description(out, self.kind, self.members, &self.target_type)
    }
}

fn state_word(code: u8) -> &'static str {
    TrackState::from_code(code).map_or("", TrackState::word)
}

fn write_sensor_track(
    out: &mut impl Write,
    reference: &Reference,
    sensor_id: u32,
    track: &SensorTrack,
) -> io::Result<()> {
    reference.write_time(out, track.time_of_measurement_ns)?;
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

/// The kind of track, a group's members, the target's type and its confidence; all empty for a single target of no
/// type. A group without members is none.
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
        let written = writer.into_inner();
        let columns = columns(std::str::from_utf8(&written).unwrap());
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
        assert!(writer.into_inner().ends_with(b",0,1,,,,\n"));
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
            ..Contribution::default()
        };
        let mut writer = SystemTrackWriter::begin(Vec::new(), 0).unwrap();
        writer.write(&track).unwrap();
        let written = writer.into_inner();
        let columns = columns(std::str::from_utf8(&written).unwrap());
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

    #[test]
    fn a_placed_track_says_where_and_when_in_the_worlds_terms_behind_everything_else() {
        let frame = SystemFrame::at(Geodetic::from_degrees(41.25, -2.5, 100.0).unwrap());
        let track = SystemTrack {
            reference_time_ns: 1_462_917_600_250_000_000,
            position_m: [0.0, 0.0, 9_044.0],
            height_valid: 1,
            level: 1_199,
            level_valid: 1,
            level_age_ms: 1_250,
            ..SystemTrack::default()
        };
        let written = |track: &SystemTrack| {
            let mut writer = PlacedTrackWriter::begin(Vec::new(), 0).unwrap();
            writer.write(&PlacedTrack::new(track, &frame)).unwrap();
            String::from_utf8(writer.into_inner()).unwrap()
        };
        let text = written(&track);
        let columns = columns(&text);
        for (name, expected) in [
            ("utc", "2016-05-10T22:00:00.25Z"),
            ("latitude", "41.2500000"),
            ("longitude", "-2.5000000"),
            ("flight_level", "300.00"),
            ("level", "299.75"),
            ("level_age_s", "1.250"),
        ] {
            assert_eq!(value(&columns, name), expected, "{name}");
        }
        let mut before = SystemTrackWriter::begin(Vec::new(), 0).unwrap();
        before.write(&track).unwrap();
        let before = String::from_utf8(before.into_inner()).unwrap();
        for (line, before) in text.lines().zip(before.lines()) {
            assert!(line.starts_with(&format!("{before},")), "{line}");
        }
        let without_height = SystemTrack {
            height_valid: 0,
            level_valid: 0,
            ..track
        };
        assert!(written(&without_height).ends_with(",41.2500000,-2.5000000,,,\n"));
    }
}
