//! Which columns of a header are read, and as what.
//!
//! `track` and `heading` have two meanings among programs. Receivers of aircraft write the direction of motion as
//! `track`, or as `heading`; trackers write their number as `track`, and ships have a heading beside their course. A
//! table decides by its other columns: whoever states a speed states a direction, too.

use std::io::Read;

use csv_table::{Column, CsvError, Table};

use super::list::{Quantity, find};

/// Column without which no table of sensor tracks in metres (FM-5) is read, or which no other table has.
const OF_SENSOR_TRACKS: [&str; 4] = ["sensor_id", "sensor_track_id", "P00", "trace"];

/// A column, and the value of one of its units in the unit of its quantity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    pub(super) column: Column,
    pub(super) scale: f64,
}

/// How the rows of a table state positions.
#[derive(Clone, Copy, Debug)]
pub(super) enum Positions {
    /// Latitude and longitude.
    Degrees([Field; 2]),
    /// East and north in the system frame.
    Metres([Field; 2]),
}

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
    fields: [Option<Field>; Quantity::COUNT],
    pub(super) time: Column,
    pub(super) positions: Positions,
    /// Names of the columns that are not read, as in the header.
    pub(super) ignored: Vec<String>,
}

impl Places {
    /// Finds the columns.
    ///
    /// # Errors
    /// If time or position is missing, or two columns state one quantity.
    pub(super) fn find<R: Read>(table: &Table<R>) -> Result<Self, CsvError> {
        let mut found = Found::default();
        for (place, name) in table.names().enumerate() {
            let entry = find(name).and_then(|(entry, known)| {
                let column = table.column_at(place, known)?;
                Some((
                    entry.quantity,
                    Field {
                        column,
                        scale: entry.scale,
                    },
                ))
            });
            let name = String::from_utf8_lossy(name).into_owned();
            match entry {
                Some((quantity, field)) => found.add(quantity, field, name)?,
                None => found.ignored.push(name),
            }
        }
        found.decide_track()?;
        found.decide_heading();
        found.check_velocity()?;
        let time = found.column(Quantity::Time).ok_or_else(|| table.missing("time"))?;
        let positions = found.positions(table)?;
        found.drop_heights_of_another_frame(positions);
        Ok(Self {
            time,
            positions,
            fields: found.fields,
            ignored: found.ignored,
        })
    }

    /// The column of a quantity, if the table has one.
    pub(super) fn of(&self, quantity: Quantity) -> Option<Field> {
        self.fields[quantity as usize]
    }

    /// What the table names its targets by.
    pub(super) fn target_names(&self) -> TargetNames {
        let has = |quantities: &[Quantity]| quantities.iter().any(|quantity| self.of(*quantity).is_some());
        if has(&[Quantity::Address, Quantity::Mmsi]) {
            TargetNames::Transponders
        } else if has(&[Quantity::Callsign, Quantity::Name, Quantity::Track]) {
            TargetNames::Names
        } else {
            TargetNames::One
        }
    }
}

/// Columns found so far.
#[derive(Default)]
struct Found {
    fields: [Option<Field>; Quantity::COUNT],
    /// Names in the header of the columns of `fields`.
    names: [String; Quantity::COUNT],
    /// A column `track`, of whichever meaning.
    track: Option<(Field, String)>,
    ignored: Vec<String>,
}

impl Found {
    fn has(&self, quantity: Quantity) -> bool {
        self.fields[quantity as usize].is_some()
    }

    fn column(&self, quantity: Quantity) -> Option<Column> {
        self.fields[quantity as usize].map(|field| field.column)
    }

    fn add(&mut self, quantity: Quantity, field: Field, name: String) -> Result<(), CsvError> {
        if quantity == Quantity::Track && name.eq_ignore_ascii_case("track") && self.track.is_none() {
            self.track = Some((field, name));
            return Ok(());
        }
        self.put(quantity, field, name)
    }

    fn put(&mut self, quantity: Quantity, field: Field, name: String) -> Result<(), CsvError> {
        let place = quantity as usize;
        if self.fields[place].is_some() {
            let fault = "state one quantity; leave one of them out, or give it a name of your own";
            return Err(clash(&self.names[place], &name, fault));
        }
        self.fields[place] = Some(field);
        self.names[place] = name;
        Ok(())
    }

    /// Leaves a column unread.
    fn ignore(&mut self, quantity: Quantity) {
        if self.fields[quantity as usize].take().is_some() {
            self.ignored.push(std::mem::take(&mut self.names[quantity as usize]));
        }
    }

    /// Decides what a column `track` is: the course, if the table has a speed and no other course, and either names its
    /// targets otherwise or has no heading; else the number of the track.
    fn decide_track(&mut self) -> Result<(), CsvError> {
        let Some((field, name)) = self.track.take() else {
            return Ok(());
        };
        const NAMES: [Quantity; 5] = [
            Quantity::Address,
            Quantity::Mmsi,
            Quantity::Callsign,
            Quantity::Name,
            Quantity::Track,
        ];
        let is_named = NAMES.into_iter().any(|quantity| self.has(quantity));
        let lacks_course = self.has(Quantity::Speed) && !self.has(Quantity::Course);
        let is_course = lacks_course && (is_named || !self.has(Quantity::Heading));
        let quantity = if is_course { Quantity::Course } else { Quantity::Track };
        self.put(quantity, field, name)
    }

    /// Takes the heading for the course where no column states the course.
    fn decide_heading(&mut self) {
        let heading = Quantity::Heading as usize;
        if self.has(Quantity::Course) || self.has(Quantity::EastVelocity) {
            self.ignore(Quantity::Heading);
        } else {
            self.fields[Quantity::Course as usize] = self.fields[heading].take();
            self.names[Quantity::Course as usize] = std::mem::take(&mut self.names[heading]);
        }
    }

    fn check_velocity(&self) -> Result<(), CsvError> {
        let polar = [Quantity::Speed, Quantity::Course];
        let plane = [Quantity::EastVelocity, Quantity::NorthVelocity];
        let first = |quantities: [Quantity; 2]| quantities.into_iter().find(|quantity| self.has(*quantity));
        match (first(polar), first(plane)) {
            (Some(polar), Some(plane)) => {
                let fault = "both state the velocity; leave out speed and course, or vx and vy";
                Err(clash(&self.names[polar as usize], &self.names[plane as usize], fault))
            }
            _ => Ok(()),
        }
    }

    fn positions<R: Read>(&self, table: &Table<R>) -> Result<Positions, CsvError> {
        let field = |quantity: Quantity| self.fields[quantity as usize];
        let degrees = [Quantity::Latitude, Quantity::Longitude];
        let metres = [Quantity::East, Quantity::North];
        match (degrees.map(field), metres.map(field)) {
            ([None, None], [Some(east), Some(north)]) => Ok(Positions::Metres([east, north])),
            ([None, None], [Some(_), None]) => Err(table.missing("y")),
            ([None, None], [None, Some(_)]) => Err(table.missing("x")),
            ([Some(latitude), Some(longitude)], [None, None]) => Ok(Positions::Degrees([latitude, longitude])),
            ([_, None], [None, None]) => Err(table.missing("longitude")),
            ([None, _], [None, None]) => Err(table.missing("latitude")),
            _ => {
                let name = |of: [Quantity; 2]| {
                    let present = of.into_iter().find(|quantity| self.has(*quantity));
                    present.map_or("", |quantity| self.names[quantity as usize].as_str())
                };
                let fault = "both state the position; leave out degrees or metres";
                Err(clash(name(degrees), name(metres), fault))
            }
        }
    }

    /// Leaves out heights that the positions do not go with: the up component of a plane is no height above the Earth.
    fn drop_heights_of_another_frame(&mut self, positions: Positions) {
        match positions {
            Positions::Degrees(_) => self.ignore(Quantity::Up),
            Positions::Metres(_) => {
                self.ignore(Quantity::Height);
                self.ignore(Quantity::PressureAltitude);
            }
        }
    }
}

#[cold]
fn clash(first: &str, second: &str, fault: &str) -> CsvError {
    CsvError::Clash {
        first: first.to_owned(),
        second: second.to_owned(),
        fault: fault.to_owned(),
    }
}

/// Whether a table has named columns, and no sensor tracks in metres (FM-5, [`crate::sensor_tracks_csv`]): it states
/// degrees without being a complete table of sensor tracks, or time and place without any column that only such a table
/// has.
pub fn has_named_columns<R: Read>(table: &Table<R>) -> bool {
    let has = |name: &str| table.names().any(|found| found == name.as_bytes());
    let states = |quantity: Quantity| {
        table
            .names()
            .any(|name| find(name).is_some_and(|(entry, _)| entry.quantity == quantity))
    };
    let is_complete = ["time_s", "sensor_id", "sensor_track_id", "x", "y"]
        .into_iter()
        .all(has)
        && (has("P00") || has("trace"));
    if is_complete {
        return false;
    }
    let is_placed = states(Quantity::Latitude) || states(Quantity::Longitude);
    let is_plain = !OF_SENSOR_TRACKS.into_iter().any(has);
    let is_plane = [Quantity::Time, Quantity::East, Quantity::North]
        .into_iter()
        .all(states);
    is_placed || is_plain && is_plane
}
