//! What an on-board receiver heard (FM-7), each emission given to the tracker before the first scan after it.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use csv_table::CsvError;
use formats::bearings_csv::BearingReader;
use observations::Bearing;
use tracking::wide_area::Emission;
use tracking::{Settings, Tracker};

use crate::files::{InputError, open};
use crate::offline::Refusals;

/// Emissions in the order of their times, and what became of them.
#[derive(Debug)]
pub(super) struct Emissions {
    path: PathBuf,
    list: Vec<Emission>,
    given: usize,
    pub(super) refusals: Refusals,
    /// Emissions that the tracker refused, by reason.
    pub(super) refused: BTreeMap<String, u64>,
}

impl Emissions {
    /// Reads a file of bearings. Rows that cannot be used are left out and counted.
    ///
    /// # Errors
    /// If it cannot be read or lacks a column.
    pub(super) fn read(path: &Path) -> Result<Self, InputError> {
        let (mut list, mut refusals) = (Vec::new(), Refusals::default());
        let reader = BearingReader::new(BufReader::new(open(path)?), 0);
        let mut reader = reader.map_err(|error| InputError::new(path, error))?;
        while let Some(row) = reader.next() {
            match row.map(|bearing| emission(&bearing)) {
                Ok(Some(emission)) => list.push(emission),
                Ok(None) => {
                    let why = "no frequency, by which a type could be told; write frequency_hz";
                    refusals.refused("no frequency", path, reader.line(), why);
                }
                Err(error @ (CsvError::Value { .. } | CsvError::Length { .. })) => refusals.unreadable(path, &error),
                Err(error) => return Err(InputError::new(path, error)),
            }
        }
        list.sort_by_key(|emission: &Emission| emission.time_ns);
        Ok(Self {
            path: path.to_owned(),
            list,
            given: 0,
            refusals,
            refused: BTreeMap::new(),
        })
    }

    /// Refuses emissions where nobody says what emits the like.
    pub(super) fn check(&self, settings: &Settings) -> Result<(), InputError> {
        if !settings.wide_area.knowledge.types.is_empty() {
            return Ok(());
        }
        let what = "emissions tell types of targets, and none is described; do so in --config with [[wide_area.type]], or \
                    leave --emissions out";
        Err(InputError::new(&self.path, what))
    }

    /// Gives the tracker what was received until `time_ns`.
    pub(super) fn give(&mut self, time_ns: i64, tracker: &mut Tracker) {
        let waiting = &self.list[self.given..];
        let received = waiting.partition_point(|emission| emission.time_ns <= time_ns);
        for emission in &waiting[..received] {
            if let Err(refusal) = tracker.emission(emission) {
                *self.refused.entry(refusal.to_string()).or_default() += 1;
            }
        }
        self.given += received;
    }

    /// How many came after the last scan, and were of no use.
    pub(super) fn left(&self) -> usize {
        self.list.len() - self.given
    }
}

/// `None` without a frequency.
fn emission(bearing: &Bearing) -> Option<Emission> {
    let [east, north, _] = bearing.platform_m;
    Some(Emission {
        time_ns: bearing.time_of_measurement_ns,
        bearing_rad: bearing.bearing_rad,
        sigma_rad: bearing.sigma_rad,
        platform_m: [east, north],
        frequency_hz: bearing.frequency_hz?,
        pulse_interval_s: bearing.pulse_interval_s,
    })
}
