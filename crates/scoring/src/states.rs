//! States of targets and tracks from files, and their visibility at a given instant.
//!
//! A picture is the display at an instant: the newest state of each track, moved along its velocity, up to a
//! maximum age. Files hold up to one row per track and report, and need not be sorted. While a file is read, each
//! row goes to the first instant at which it is visible, and only the newest row of each track and instant is
//! stored. Memory thus holds the pictures, not the file.

use std::collections::BTreeMap;
use std::collections::btree_map;
use std::io::Read;

use csv_table::{COVARIANCE_COLUMNS, Cells, Column, CsvError, STEADY_COLUMNS, Table};
use messages::{COVARIANCE_LEN, Covariance, IdentityText};
use rustc_hash::FxHashMap;

use crate::basis::{DegreeColumns, FileBasis};
use crate::row_columns::{IdColumn, PLANE, VelocityColumns, columns, known};

/// Columns of positions, by dimension.
const POSITION: [&str; 3] = ["x", "y", "z"];

/// Number of an instant, in the order of time: whole seconds or places in a list.
pub(crate) type Instant = i64;

/// Position and velocity of one target or track, in `D` dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KinematicState<const D: usize> {
    pub(crate) id: i64,
    pub(crate) time_s: f64,
    pub(crate) position_m: [f64; D],
    pub(crate) velocity_mps: [f64; D],
    /// Covariance of position and velocity at the first instant of visibility, if stated.
    pub(crate) covariance: Option<Covariance>,
    /// Accuracy of the velocity without a manoeuvre, if stated.
    pub(crate) steady: SteadyKnowledge,
    /// 24-bit address, if known.
    pub(crate) address: Option<u32>,
    /// Whether height and rate of climb are known.
    pub(crate) has_height: bool,
    /// Whether the velocity is known.
    pub(crate) has_velocity: bool,
}

/// Accuracy of a track's velocity without a manoeuvre, each part with the probability of this case.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SteadyKnowledge {
    /// Covariance of the velocity in straight flight (xx, xy, yy), m²/s².
    pub(crate) velocity: Option<(f64, [f64; 3])>,
    /// Variance of a constant climb rate, m²/s².
    pub(crate) climb: Option<(f64, f64)>,
}

impl<const D: usize> KinematicState<D> {
    /// Returns the state moved to another time, under constant velocity.
    pub(crate) fn moved_to(&self, time_s: f64) -> Self {
        let seconds = time_s - self.time_s;
        Self {
            position_m: std::array::from_fn(|axis| self.position_m[axis] + self.velocity_mps[axis] * seconds),
            ..*self
        }
    }
}

/// Counted rows, by the word in the column `state`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StateFilter {
    /// All rows except `tentative`, `suspended` or `terminated`; in files without the column, all rows.
    NotUnconfirmed,
    /// Only rows with `confirmed` or `coasted`.
    Confirmed,
}

/// Rows of a file with states: `time_s`, a number that identifies the target or track, position, velocity.
#[derive(Debug)]
pub(crate) struct StateRows<R, const D: usize> {
    table: Table<R>,
    counted: StateFilter,
    basis: FileBasis,
    time: Column,
    id: IdColumn,
    place: PlaceColumns<D>,
    /// Optional beside places in degrees.
    velocity: Option<VelocityColumns<D>>,
    state: Option<Column>,
    covariance: Option<[Column; COVARIANCE_LEN]>,
    steady: Option<[Column; STEADY_COLUMNS.len()]>,
    address: Option<Column>,
    height_valid: Option<Column>,
    velocity_valid: Option<Column>,
}

/// Columns of a place.
#[derive(Clone, Copy, Debug)]
enum PlaceColumns<const D: usize> {
    /// Metres; some files state the place in degrees, too.
    Metres([Column; D], Option<DegreeColumns>),
    Degrees(DegreeColumns),
}

impl<R: Read, const D: usize> StateRows<R, D> {
    /// Reads the header. The first of `ids` in the header identifies the rows' targets or tracks; without any, the
    /// error names `usual`.
    ///
    /// # Errors
    /// If a column is missing or the input fails.
    pub(crate) fn new(
        input: R,
        ids: &[&'static str],
        usual: &'static str,
        counted: StateFilter,
    ) -> Result<Self, CsvError> {
        let table = Table::new(input)?;
        let id = IdColumn::find(&table, ids, usual)?;
        let place = PlaceColumns::find(&table)?;
        Ok(Self {
            counted,
            basis: FileBasis::default(),
            time: table.required("time_s")?,
            id,
            velocity: match VelocityColumns::find(&table) {
                Err(error) if matches!(place, PlaceColumns::Metres(..)) => return Err(error),
                found => found.ok(),
            },
            place,
            state: match counted {
                StateFilter::NotUnconfirmed => table.optional("state")?,
                StateFilter::Confirmed => Some(table.required("state")?),
            },
            covariance: optional(&table, COVARIANCE_COLUMNS)?,
            steady: optional(&table, STEADY_COLUMNS)?,
            address: table.optional("address")?,
            height_valid: table.optional("height_valid")?,
            velocity_valid: table.optional("velocity_valid")?,
            table,
        })
    }

    /// Reads times and places on the basis of another file.
    pub(crate) fn on(self, basis: FileBasis) -> Self {
        Self { basis, ..self }
    }

    /// Returns what times and places of the rows so far refer to.
    pub(crate) fn basis(&self) -> FileBasis {
        self.basis
    }

    /// Returns the state in the next counted row, with the covariance at the time of the row; `None` at the end.
    ///
    /// # Errors
    /// If the row cannot be read.
    pub(crate) fn next(&mut self) -> Result<Option<KinematicState<D>>, CsvError> {
        while let Some(row) = self.table.next_row() {
            let row = row?;
            let counts = match (self.counted, row.text(self.state)?) {
                (StateFilter::NotUnconfirmed, word) => !matches!(word, Some("tentative" | "suspended" | "terminated")),
                (StateFilter::Confirmed, word) => matches!(word, Some("confirmed" | "coasted")),
            };
            if !counts {
                continue;
            }
            let id = self.id.read(row)?;
            let time_s = self.basis.time_s(row, self.time)?;
            let is_known = |column: Option<Column>| Ok(row.text(column)? != Some("0"));
            let has_height = is_known(self.height_valid)?;
            let has_velocity = is_known(self.velocity_valid)?;
            let velocity = self.velocity.filter(|_| has_velocity);
            let velocity = velocity.map_or(Ok(None), |columns| columns.read(row, has_height))?;
            let mut state = KinematicState {
                id,
                time_s,
                position_m: [0.0; D],
                velocity_mps: velocity.unwrap_or([0.0; D]),
                covariance: self.covariance.and_then(|columns| stated(row, columns)),
                steady: self
                    .steady
                    .map_or_else(SteadyKnowledge::default, |columns| steady(row, columns)),
                address: row.text(self.address)?.and_then(hexadecimal),
                has_height,
                has_velocity: velocity.is_some(),
            };
            self.place.read(row, &mut self.basis, &mut state)?;
            return Ok(Some(state));
        }
        Ok(None)
    }
}

impl<const D: usize> PlaceColumns<D> {
    fn find<R: Read>(table: &Table<R>) -> Result<Self, CsvError> {
        let degrees = match (table.optional("latitude")?, table.optional("longitude")?) {
            (Some(latitude), Some(longitude)) if D == POSITION.len() => Some(DegreeColumns {
                latitude,
                longitude,
                height: table.optional("height_m")?.or(table.optional("z")?),
                flight_level: table.optional("flight_level")?,
            }),
            _ => None,
        };
        let has_metres = table.optional("x")?.is_some() || table.optional("y")?.is_some();
        match degrees {
            Some(degrees) if !has_metres => Ok(Self::Degrees(degrees)),
            _ => Ok(Self::Metres(columns(table, POSITION)?, degrees)),
        }
    }

    /// Reads the place of a row; that in degrees, with the velocity there, is turned into the frame of the basis.
    fn read(&self, row: Cells<'_>, basis: &mut FileBasis, state: &mut KinematicState<D>) -> Result<(), CsvError> {
        let full = |values: &[f64; D]| std::array::from_fn(|axis| values.get(axis).copied().unwrap_or(0.0));
        match self {
            Self::Metres(columns, degrees) => {
                state.position_m = known(row, *columns, state.has_height)?;
                basis.take_metres((row, columns[0]), full(&state.position_m), degrees.as_ref())
            }
            Self::Degrees(columns) => {
                let (place, has_height) = columns.place(row)?;
                let frame = basis.frame(row, columns.latitude, place)?;
                let local = frame.to_local(place);
                let axes = frame.axes(local);
                let speeds: [f64; 3] = full(&state.velocity_mps);
                state.has_height &= has_height;
                state.position_m = std::array::from_fn(|axis| local[axis]);
                state.velocity_mps =
                    std::array::from_fn(|axis| axes.iter().zip(speeds).map(|(to, speed)| to[axis] * speed).sum());
                Ok(())
            }
        }
    }
}

/// Returns optional columns if all are present.
fn optional<R: Read, const N: usize>(
    table: &Table<R>,
    names: [&'static str; N],
) -> Result<Option<[Column; N]>, CsvError> {
    for name in names {
        if table.optional(name)?.is_none() {
            return Ok(None);
        }
    }
    table.all(names).map(Some)
}

/// Returns what a row states without a manoeuvre; a value that is no number is not stated.
fn steady(row: Cells<'_>, columns: [Column; STEADY_COLUMNS.len()]) -> SteadyKnowledge {
    let [weight, xx, xy, yy, climb_weight, climb] = columns.map(|column| row.number(column).ok());
    let velocity = |weight| Some((weight, [xx?, xy?, yy?]));
    SteadyKnowledge {
        velocity: weight.and_then(velocity),
        climb: climb_weight.zip(climb),
    }
}

/// Returns the covariance of a row; `None` if an element is no number.
fn stated(row: Cells<'_>, columns: [Column; COVARIANCE_LEN]) -> Option<Covariance> {
    let mut covariance = Covariance::default();
    for (place, column) in covariance.upper.iter_mut().zip(columns) {
        *place = row.number(column).ok()?;
    }
    Some(covariance)
}

/// Returns the address in the text; `None` for other texts, since files without identities may use the name otherwise.
fn hexadecimal(text: &str) -> Option<u32> {
    IdentityText::ADDRESS.read(text)
}

/// Decides whether a state replaces a stored state.
pub(crate) type Supersedes<const D: usize> = fn(state: &KinematicState<D>, kept: &KinematicState<D>) -> bool;

/// Newest state of each target or track per instant.
#[derive(Clone, Debug)]
pub(crate) struct PictureSeries<const D: usize> {
    by_instant: BTreeMap<Instant, Vec<KinematicState<D>>>,
    /// Places of the latest stored states.
    latest: FxHashMap<i64, (Instant, usize)>,
    supersedes: Supersedes<D>,
}

impl<const D: usize> PictureSeries<D> {
    pub(crate) fn new(supersedes: Supersedes<D>) -> Self {
        Self {
            by_instant: BTreeMap::new(),
            latest: FxHashMap::default(),
            supersedes,
        }
    }

    /// Stores a state visible from `instant` on, unless a newer state is.
    pub(crate) fn keep(&mut self, instant: Instant, state: KinematicState<D>) {
        let states = self.by_instant.entry(instant).or_default();
        match self.latest.get(&state.id) {
            Some((of, place)) if *of == instant => {
                if (self.supersedes)(&state, &states[*place]) {
                    states[*place] = state;
                }
            }
            _ => {
                self.latest.insert(state.id, (instant, states.len()));
                states.push(state);
            }
        }
    }

    /// Returns the instant of the first picture.
    pub(crate) fn first(&self) -> Option<Instant> {
        self.by_instant.keys().next().copied()
    }

    /// Iterates over the pictures in the order of time.
    pub(crate) fn walk(&self) -> Walk<'_, D> {
        Walk {
            rest: self.by_instant.iter().peekable(),
            visible: BTreeMap::new(),
            supersedes: self.supersedes,
        }
    }
}

/// Iteration over pictures.
#[derive(Debug)]
pub(crate) struct Walk<'a, const D: usize> {
    rest: std::iter::Peekable<btree_map::Iter<'a, Instant, Vec<KinematicState<D>>>>,
    visible: BTreeMap<i64, KinematicState<D>>,
    supersedes: Supersedes<D>,
}

impl<const D: usize> Walk<'_, D> {
    /// Returns the states displayed at `instant`, which is at `time_s`: every state that is `fresh` then, moved to
    /// that time, in the order of their numbers. Calls must be in the order of instants; outdated states are
    /// dropped permanently.
    pub(crate) fn at(&mut self, instant: Instant, time_s: f64, fresh: impl Fn(f64) -> bool) -> Vec<KinematicState<D>> {
        while let Some((_, states)) = self.rest.next_if(|(of, _)| **of <= instant) {
            for state in states {
                let newest = self.visible.entry(state.id).or_insert(*state);
                if (self.supersedes)(state, newest) {
                    *newest = *state;
                }
            }
        }
        self.visible.retain(|_, state| fresh(state.time_s));
        self.visible.values().map(|state| state.moved_to(time_s)).collect()
    }
}

/// Returns the positions of states for comparison: a height that is not known is NaN, which adds no distance.
pub(crate) fn positions<const D: usize>(states: &[KinematicState<D>]) -> Vec<[f64; D]> {
    let compared = |state: &KinematicState<D>| {
        let known = |axis: usize| axis < PLANE || state.has_height;
        std::array::from_fn(|axis| if known(axis) { state.position_m[axis] } else { f64::NAN })
    };
    states.iter().map(compared).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(id: i64, time_s: f64, x: f64) -> KinematicState<2> {
        KinematicState {
            id,
            time_s,
            position_m: [x, 0.0],
            velocity_mps: [10.0, -1.0],
            covariance: None,
            steady: SteadyKnowledge::default(),
            address: None,
            has_height: true,
            has_velocity: true,
        }
    }

    #[test]
    fn of_each_track_the_newest_state_shows_moved_and_not_too_old() {
        let mut pictures = PictureSeries::new(|state, kept| state.time_s >= kept.time_s);
        for (instant, state) in [
            (2, state(7, 1.5, 1.0)),
            (1, state(7, 0.5, 2.0)),
            (2, state(7, 1.25, 3.0)),
            (2, state(3, 2.0, 4.0)),
            (2, state(3, 2.0, 5.0)),
        ] {
            pictures.keep(instant, state);
        }
        let mut walk = pictures.walk();
        let mut at = |instant: i64| {
            let states = walk.at(instant, instant as f64, |time_s| instant as f64 - time_s < 1.0);
            let shown = states.iter().map(|state| (state.id, state.position_m));
            shown.collect::<Vec<_>>()
        };
        assert_eq!(at(0), []);
        assert_eq!(at(1), [(7, [7.0, -0.5])]);
        assert_eq!(at(2), [(3, [5.0, 0.0]), (7, [6.0, -0.5])]);
        assert_eq!(at(3), []);
    }

    #[test]
    fn rows_that_count_are_read_by_the_columns_names() {
        let text = "state,system_track_id,vy,vx,y,x,z,time_s\n\
                    coasted,4,0.5,-1,2,1,9,0.25\nterminated,-5,,,,,,1\n,6,0,0,0,0,9,2\n";
        let ids = ["target_id", "system_track_id"];
        let read = |counted| {
            let mut rows = StateRows::<_, 2>::new(text.as_bytes(), &ids, "system_track_id", counted).unwrap();
            std::iter::from_fn(|| rows.next().unwrap()).collect::<Vec<_>>()
        };
        let first = KinematicState {
            id: 4,
            time_s: 0.25,
            position_m: [1.0, 2.0],
            velocity_mps: [-1.0, 0.5],
            covariance: None,
            steady: SteadyKnowledge::default(),
            address: None,
            has_height: true,
            has_velocity: true,
        };
        assert_eq!(read(StateFilter::Confirmed), [first]);
        let all = read(StateFilter::NotUnconfirmed);
        assert_eq!(all.iter().map(|state| state.id).collect::<Vec<_>>(), [4, 6]);
    }

    #[test]
    fn mistakes_name_line_and_column() {
        let refused = |text: &str| {
            let rows = StateRows::<_, 3>::new(
                text.as_bytes(),
                &["target_id", "track_id"],
                "track_id",
                StateFilter::NotUnconfirmed,
            );
            let outcome = rows.and_then(|mut rows| rows.next().map(drop));
            outcome.unwrap_err().to_string()
        };
        assert!(refused("time_s,x,y,z,vx,vy,vz\n").contains("column track_id is missing"));
        assert!(refused("time_s,target_id,x,y,vx,vy,vz\n").contains("column z is missing"));
        let row = |row: &str| refused(&format!("time_s,target_id,x,y,z,vx,vy,vz\n{row}\n"));
        assert_eq!(
            row("1,2,3,4,5,6,7,?"),
            "line 2, column vz: \"?\" is no number; write one like -12.5"
        );
        assert!(row("1,2.5,3,4,5,6,7,8").contains("column target_id: \"2.5\" is no whole number"));
        assert!(row("1e7,2,3,4,5,6,7,8").contains("column time_s"));
        assert!(row("1,2,3").contains("3 values"));
    }
}
