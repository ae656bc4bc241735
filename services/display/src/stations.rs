//! Stations that are no targets: base stations and aids to navigation, the latest report of each.
//!
//! Their reports are minutes apart, so each stays where it is until it has been silent for [`STATION_AGE_S`]. Several
//! sources may receive the same station: the MMSI is its key, and the latest report counts. A page gets the stations
//! whose reports are newer than its previous picture, in any part of the world: they are few, and a page that moves its
//! view has them already.

use std::collections::BTreeMap;

use frames::SystemFrame;
use messages::TargetStatement;
use messages::picture::PictureStation;

use crate::records;
use crate::wire::STATION_AGE_S;

/// Maximum number of stations: four times those of a coast.
const STATIONS_MAX: usize = 8_192;
/// Silence, or lead of a wrong clock, with which a station is forgotten, nanoseconds.
const STATION_AGE_NS: u64 = STATION_AGE_S.unsigned_abs() * 1_000_000_000;

/// Stations by MMSI, see the module's documentation.
#[derive(Debug, Default)]
pub(crate) struct Stations {
    by_mmsi: BTreeMap<u32, Station>,
}

/// Station with its latest report.
#[derive(Debug)]
struct Station {
    /// Arrival of the report.
    stamp: u64,
    stated: TargetStatement,
}

impl Stations {
    /// Takes a statement of a station that arrived as number `stamp`.
    pub(crate) fn take(&mut self, stated: &TargetStatement, stamp: u64) {
        let known = self.by_mmsi.get(&stated.track_number);
        let has_room = known.is_some() || self.by_mmsi.len() < STATIONS_MAX;
        if has_room && known.is_none_or(|known| known.stated.time_ns <= stated.time_ns) {
            let stated = *stated;
            self.by_mmsi.insert(stated.track_number, Station { stamp, stated });
        }
    }

    /// Forgets the stations that are silent at `time_ns` (UTC, nanoseconds).
    pub(crate) fn forget_silent(&mut self, time_ns: i64) {
        self.by_mmsi
            .retain(|_, station| time_ns.abs_diff(station.stated.time_ns) <= STATION_AGE_NS);
    }

    /// Returns the stations with reports after `stamp`, by MMSI, each with the time of its report, UTC, nanoseconds.
    pub(crate) fn since(&self, stamp: u64, frame: &SystemFrame) -> impl Iterator<Item = (i64, PictureStation)> {
        let new = self.by_mmsi.values().filter(move |station| station.stamp > stamp);
        new.filter_map(|station| Some((station.stated.time_ns, records::station(&station.stated, frame)?)))
    }

    /// Returns the number of stations.
    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.by_mmsi.len()
    }
}
