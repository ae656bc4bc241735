//! Which columns of a header are read, and as what.
//!
//! `track` and `heading` have two meanings among programs. Receivers of aircraft write the direction of motion as
//! `track`, or as `heading`; trackers write their number as `track`, and ships have a heading beside their course. A
//! table decides by its other columns: whoever states a speed states a direction, too.

use std::io::Read;

use csv_table::{Column, CsvError, Table};

use crate::identity_columns::IdentityPlaces;
use crate::plane::Positions;

/// Column without which no table of sensor tracks in metres (FM-5) is read, or which no other table has.
const OF_SENSOR_TRACKS: [&str; 4] = ["sensor_id", "sensor_track_id", "P00", "trace"];

/// What a table names its targets by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetNames {
    /// Addresses of aircraft or numbers of ships, which the targets state themselves.
    Transponders,
    /// Callsigns, names, or numbers of tracks.
    Names,
    /// Nothing: all rows are of one target.
    One,
}

/// Places of the columns that are read.
#[derive(Clone, Debug)]
pub(super) struct Places {
    pub(super) time: Column,
    pub(super) positions: Positions,
    /// Height above the ellipsoid, and by pressure: of places in degrees.
    pub(super) height: Option<Column>,
    pub(super) pressure_altitude: Option<Column>,
    /// Metres per second, and degrees clockwise from north.
    pub(super) speed: Option<Column>,
    pub(super) course: Option<Column>,
    /// In place of both: towards east and north.
    pub(super) velocity: [Option<Column>; 2],
    pub(super) climb: Option<Column>,
    pub(super) sigma: Option<Column>,
    pub(super) identity: IdentityPlaces,
    /// Number or name of the target.
    pub(super) track: Option<Column>,
    pub(super) source: Option<Column>,
    pub(super) on_ground: Option<Column>,
    /// Names of the columns that are not read, as in the header.
    pub(super) ignored: Vec<String>,
}

impl Places {
    /// Finds the columns.
    ///
    /// # Errors
    /// If time or position is missing, or two columns state one quantity.
    pub(super) fn find<R: Read>(table: &Table<R>) -> Result<Self, CsvError> {
        let identity = IdentityPlaces::of_quantities(table)?;
        let velocity = [table.of_quantity("vx")?, table.of_quantity("vy")?];
        let speed = table.of_quantity("speed_mps")?;
        let (track, course) = track_and_course(table, &identity, (speed, velocity[0].is_some()))?;
        if let (Some(polar), Some(plane)) = (speed.or(course), velocity[0].or(velocity[1])) {
            let fault = "both state the velocity; leave out speed and course, or vx and vy";
            return Err(table.clash(polar, plane, fault));
        }
        let time = table.of_quantity("time")?.ok_or_else(|| table.missing("time"))?;
        let positions = Positions::find(table)?.ok_or_else(|| table.missing("latitude"))?;
        // The up component of a plane is no height above the Earth.
        let (in_degrees, up) = match positions {
            Positions::Degrees(columns) => (columns, None),
            Positions::Metres(columns, up) => (columns, up),
        };
        let of_earth = |name| match positions {
            Positions::Degrees(_) => table.of_quantity(name),
            Positions::Metres(..) => Ok(None),
        };
        let mut places = Self {
            time,
            positions,
            height: of_earth("altitude_m")?,
            pressure_altitude: of_earth("baroaltitude")?,
            speed,
            course,
            velocity,
            climb: table.of_quantity("climb_mps")?,
            sigma: table.of_quantity("sigma_m")?,
            identity,
            track,
            source: table.of_quantity("source")?,
            on_ground: table.of_quantity("on_ground")?,
            ignored: Vec::new(),
        };
        let [east, north] = in_degrees;
        let IdentityPlaces {
            address,
            mmsi,
            mode_3a,
            callsign,
            name,
        } = identity;
        let of_motion = [speed, course, velocity[0], velocity[1], places.climb, places.sigma];
        let of_place = [
            Some(time),
            Some(east),
            Some(north),
            up,
            places.height,
            places.pressure_altitude,
        ];
        let of_target = [address, mmsi, mode_3a, callsign, name, track];
        let read = [
            &of_motion[..],
            &of_place,
            &of_target,
            &[places.source, places.on_ground],
        ]
        .concat();
        places.ignored = table.unread(&read);
        Ok(places)
    }

    /// What the table names its targets by.
    pub(super) fn target_names(&self) -> TargetNames {
        if self.identity.address.or(self.identity.mmsi).is_some() {
            TargetNames::Transponders
        } else if self.identity.callsign.or(self.identity.name).or(self.track).is_some() {
            TargetNames::Names
        } else {
            TargetNames::One
        }
    }
}

/// The columns of the target's number or name, and of the course. A column `track` is the course if the table has a
/// speed and no other course, and either names its targets otherwise or has no heading. The heading is the course where
/// no column states the course.
fn track_and_course<R: Read>(
    table: &Table<R>,
    identity: &IdentityPlaces,
    (speed, has_velocity): (Option<Column>, bool),
) -> Result<(Option<Column>, Option<Column>), CsvError> {
    let (mut number, mut course) = (table.of_quantity("track_id")?, table.of_quantity("course_deg")?);
    let heading = table.of_quantity("heading")?;
    if let Some(track) = table.of_quantity("track")? {
        let names = [
            identity.address,
            identity.mmsi,
            identity.callsign,
            identity.name,
            number,
        ];
        let is_named = names.iter().any(Option::is_some);
        if speed.is_some() && course.is_none() && (is_named || heading.is_none()) {
            course = Some(track);
        } else if let Some(number) = number {
            let fault = "state one quantity; leave one of them out, or give it a name of your own";
            return Err(table.clash(number, track, fault));
        } else {
            number = Some(track);
        }
    }
    Ok((number, course.or(heading.filter(|_| !has_velocity))))
}

/// Whether a table has named columns, and no sensor tracks in metres (FM-5, [`crate::sensor_tracks_csv`]): it states
/// degrees without being a complete table of sensor tracks, or time and place without any column that only such a table
/// has.
pub fn has_named_columns<R: Read>(table: &Table<R>) -> bool {
    let has = |name: &str| table.names().any(|found| found == name.as_bytes());
    let is_complete = ["time_s", "sensor_id", "sensor_track_id", "x", "y"]
        .into_iter()
        .all(has)
        && (has("P00") || has("trace"));
    if is_complete {
        return false;
    }
    let is_placed = table.states("latitude") || table.states("longitude");
    let is_plain = !OF_SENSOR_TRACKS.into_iter().any(has);
    is_placed || is_plain && ["time", "x", "y"].into_iter().all(|name| table.states(name))
}
