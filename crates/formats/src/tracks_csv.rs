//! System tracks, and tracks of a tracker, as CSV rows (FM-5).
//!
//! Numbers are written with a fixed number of decimals, so that the same tracks give the same bytes. Times are seconds
//! since midnight (UTC) of the recording's first day, exact to the nanosecond. Several values in one column are joined
//! with `|`; no field needs quotes.

use std::io::{self, Write};

use csv_table::{COVARIANCE_COLUMNS, STEADY_COLUMNS};
use frames::{Geodetic, SystemFrame};
use messages::{SensorTrack, SystemTrack, TrackKind, TrackState, sensor_track_bits};

use crate::cells::{CellList, Plain, Rounded, SensorId, Time};
use crate::columns::columns;
use crate::parts::{KINEMATICS, ShipRow, confidence, covariance, kinematics, members, word, words};
use crate::rows::{Reference, Row, RowWriter, Utc};
use crate::sensor_tracks_csv::SensorTrackRow;
use crate::time_base::is_since_1970;

/// Writes system tracks.
pub type SystemTrackWriter<W> = RowWriter<SystemTrack, W>;
/// Writes system tracks with their places in the world.
pub type PlacedTrackWriter<W> = RowWriter<PlacedTrack, W>;
/// Writes the tracks of a tracker.
pub type TrackerTrackWriter<W> = RowWriter<TrackerTrack, W>;

/// A track that a tracker has made of several sensors' detections.
#[derive(Clone, Copy, Debug)]
pub struct TrackerTrack {
    /// The track in the form of a sensor's report; its source number has no meaning.
    pub track: SensorTrack,
    /// Number of hypotheses of its cluster.
    pub hypotheses: u32,
    /// Sum of the reliabilities of the hypotheses with this track, 0 to 1.
    pub reliability: f64,
}

impl TrackerTrack {
    /// The `sensor_id` of the tracker itself.
    pub const SENSOR_ID: u32 = 0;
}

columns! {
    TrackerTrack: |row|
    with SensorTrackRow<'_> = SensorTrackRow { sensor_id: Self::SENSOR_ID, track: &row.track };
    "hypotheses" => row.hypotheses,
    "reliability" => Rounded(row.reliability, 6),
}

/// A tracker's track with what transponders' replies state beyond the columns of all tracks.
#[derive(Clone, Copy, Debug)]
pub struct RepliedTrackerTrack(pub TrackerTrack);

columns! {
    RepliedTrackerTrack: |row|
    with TrackerTrack = row.0;
    "mmsi" => row.0.track.identity.mmsi_text(),
    "level" => level(&row.0.track).map(|(level, _)| level),
    "address_age_s" => row.0.track.identity.unique_number().map(|_| age(row.0.track.identity_ages.address_ms)),
    "mode_3a_age_s" => row.0.track.identity.mode_3a().map(|_| age(row.0.track.identity_ages.mode_3a_ms)),
    "callsign_age_s" => row.0.track.identity.callsign().map(|_| age(row.0.track.identity_ages.callsign_ms)),
    "level_age_s" => level(&row.0.track).map(|(_, age)| age),
    "name" => row.0.track.identity.name().map(words),
}

/// A tracker's track with its place in the world.
#[derive(Clone, Copy, Debug)]
pub struct PlacedTrackerTrack(pub TrackerTrack, pub Geodetic);

columns! {
    PlacedTrackerTrack: |row|
    with RepliedTrackerTrack = RepliedTrackerTrack(row.0);
    "latitude" => Plain(row.1.latitude_deg(), 7),
    "longitude" => Plain(row.1.longitude_deg(), 7),
}

/// Flight level of a sensor track, and its age in seconds.
fn level(track: &SensorTrack) -> Option<(Plain, Plain)> {
    let level = Plain(f64::from(track.level) / 4.0, 2);
    track
        .has(sensor_track_bits::LEVEL)
        .then(|| (level, age(track.level_age_ms)))
}

fn age(age_ms: u32) -> Plain {
    Plain(f64::from(age_ms) / 1e3, 3)
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

columns! {
    // The columns of a system track come first, so that readers by place find these where they were.
    PlacedTrack: |row|
    with SystemTrackRow<'_> = SystemTrackRow(&row.track);
    // Times of a day have no date.
    "utc" => is_since_1970(row.track.reference_time_ns).then_some(Utc(row.track.reference_time_ns)),
    // Seven decimals are a centimetre.
    "latitude" => Plain(row.place.latitude_deg(), 7),
    "longitude" => Plain(row.place.longitude_deg(), 7),
    "flight_level" => (row.track.height_valid != 0).then(|| Plain(row.place.flight_level(), 2)),
    "level" => (row.track.level_valid != 0).then_some(Plain(f64::from(row.track.level) / 4.0, 2)),
    "level_age_s" => (row.track.level_valid != 0).then_some(Plain(f64::from(row.track.level_age_ms) / 1e3, 3)),
    "mmsi" => row.track.identity.mmsi_text(),
    "name" => row.track.identity.name().map(words),
    "velocity_valid" => row.track.velocity_valid,
    "climb_valid" => KnownRow(&row.track).climb_valid(),
    STEADY_COLUMNS => steady(&row.track),
}

/// What is known of the velocity, written as the last part of a row.
struct KnownRow<'a>(&'a SystemTrack);

impl KnownRow<'_> {
    fn climb_valid(&self) -> u8 {
        u8::from(self.0.height_valid != 0 && self.0.covariance.knows_climb())
    }
}

columns! {
    KnownRow<'_>: |row|
    "velocity_valid" => row.0.velocity_valid,
    "climb_valid" => row.climb_valid(),
    STEADY_COLUMNS => steady(row.0),
}

/// Cells of a track's velocity without a manoeuvre, with the decimals of the covariance.
fn steady(track: &SystemTrack) -> [Option<Plain>; STEADY_COLUMNS.len()] {
    let cell = |value: f64| Some(Plain(value, 4));
    let velocity = track.steady_velocity();
    let [weight, xx, xy, yy] = velocity.map_or([None; 4], |(weight, [xx, xy, yy])| [weight, xx, xy, yy].map(cell));
    let [climb_weight, climb] = track
        .steady_climb()
        .map_or([None; 2], |(weight, climb)| [weight, climb].map(cell));
    [weight, xx, xy, yy, climb_weight, climb]
}

/// The columns of every system track.
struct SystemTrackRow<'a>(&'a SystemTrack);

impl Row for SystemTrack {
    fn columns() -> String {
        [SystemTrackRow::columns(), ShipRow::columns(), KnownRow::columns()].join(",")
    }

    fn write(&self, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        SystemTrackRow(self).write(out, reference)?;
        out.write_all(b",")?;
        ShipRow(&self.identity).write(out, reference)?;
        out.write_all(b",")?;
        KnownRow(self).write(out, reference)
    }
}

columns! {
    SystemTrackRow<'_>: |row|
    "time_s" => Time(row.0.reference_time_ns),
    "system_track_id" => row.0.track_number,
    KINEMATICS => kinematics(&row.0.position_m, &row.0.velocity_mps),
    "state" => TrackState::from_code(row.0.state).map(TrackState::word),
    "sources" => CellList(row.0.contributions().iter().map(|part| SensorId(part.source))),
    "weights" => CellList(row.0.contributions().iter().map(|part| Rounded(part.weight, 4))),
    "selected" => SensorId::known(row.0.selected_source),
    "lambda" => CellList(row.0.contributions().iter().map(|part| Rounded::known(part.accuracy, 4))),
    "address" => row.0.identity.address_text(),
    "mode_3a" => row.0.identity.mode_3a_text(),
    "callsign" => row.0.identity.callsign().map(word),
    COVARIANCE_COLUMNS => covariance(&row.0.covariance),
    "sensor_track_ids" => CellList(row.0.contributions().iter().map(|part| part.track_number)),
    "report_times_s" => CellList(row.0.contributions().iter().map(|part| Time(part.time_of_measurement_ns))),
    "height_valid" => row.0.height_valid,
    "trigger" => SensorId::known(row.0.trigger_source),
    "merged_into" => (row.0.merged_into != 0).then_some(row.0.merged_into),
    "kind" => members(row.0.kind, row.0.members).map(|_| TrackKind::Group.word()),
    "members" => members(row.0.kind, row.0.members),
    "type" => row.0.target_type.name().map(words),
    "type_confidence" => confidence(&row.0.target_type),
}

#[cfg(test)]
mod tests {
    use messages::{Contribution, Covariance, Identity, TargetType, contribution_bits, sensor_track_bits};

    use super::*;
    use crate::sensor_tracks_csv::SensorTrackWriter;

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
        // Values published without a check are not written as known values.
        let mut writer = SensorTrackWriter::begin(Vec::new(), 1_000).unwrap();
        let mut hostile = SensorTrack { members: 0, ..track };
        hostile.target_type.confidence = 7.0;
        writer.write(&hostile).unwrap();
        assert!(writer.into_inner().ends_with(b",0,1,,,,,,\n"));
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
            mode_probabilities: [0.875, 0.125, 0.0, 0.0, 0.0, 0.5, 0.25, 0.25],
            steady_velocity_covariance: [4.0, -0.5, 2.25],
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
            ("steady_weight", "0.8750"),
            ("steady_P33", "4.0000"),
            ("steady_P34", "-0.5000"),
            ("steady_P44", "2.2500"),
            ("steady_climb_weight", ""),
            ("steady_P55", ""),
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
            let of_all = before.rsplitn(11, ',').last().unwrap();
            assert!(line.starts_with(&format!("{of_all},")), "{line}");
        }
        let without_height = SystemTrack {
            height_valid: 0,
            level_valid: 0,
            ..track
        };
        assert!(written(&without_height).ends_with(",41.2500000,-2.5000000,,,,,,0,0,,,,,,\n"));
    }
}
