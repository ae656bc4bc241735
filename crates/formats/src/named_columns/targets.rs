//! A number for each target of a table.
//!
//! Fusion recognises the track of a source by a number. An address and an MMSI are numbers already. Names are numbered
//! in the order in which they appear first, so that each reading of a file gives the same numbers. The number ranges
//! are apart, since rows of one table may name their targets in different ways:
//!
//! | number | target |
//! | --- | --- |
//! | below 2^24 | an address, or the number of a track in a table without addresses and MMSIs |
//! | from 2^24 to 2^30 | an MMSI; smaller ones have bit 30 set |
//! | from 2^31 | names and other tracks, as they appear |

use csv_table::{Cells, Column, CsvError};
use messages::Identity;
use rustc_hash::FxHashMap;

/// First number of a name.
const FIRST: u32 = 1 << 31;
/// End of the addresses.
const ADDRESS_END: u32 = 1 << 24;
/// Mark of an MMSI that could be an address.
const SMALL_MMSI: u32 = 1 << 30;
/// Most names of a table.
const NAMES_MAX: usize = 1_000_000;
/// Longest name, bytes.
const LENGTH_MAX: usize = 64;
/// Number of the target of a table that names none.
const ONLY: u32 = 1;

/// Names that a row may have, in the order of preference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum NameKind {
    Name,
    Callsign,
    Track,
}

/// Numbers of the targets of a table.
#[derive(Debug, Default)]
pub(super) struct Targets {
    by_name: FxHashMap<(NameKind, Box<str>), u32>,
}

/// The names of a row, with the columns that they stand in.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowNames<'r> {
    pub(super) name: Option<(Column, &'r str)>,
    pub(super) callsign: Option<(Column, &'r str)>,
    pub(super) track: Option<(Column, &'r str)>,
    /// Whether a whole number in `track` is the number itself: the table has neither addresses nor MMSIs.
    pub(super) has_own_numbers: bool,
}

impl Targets {
    /// The number of a row's target; `None` if the row names none.
    ///
    /// # Errors
    /// If a name is too long, or there are too many.
    pub(super) fn number(
        &mut self,
        row: &Cells<'_>,
        identity: &Identity,
        names: RowNames<'_>,
    ) -> Result<Option<u32>, CsvError> {
        if let Some(address) = identity.address() {
            return Ok(Some(address));
        }
        if let Some(mmsi) = identity.mmsi() {
            let number = if mmsi < ADDRESS_END { mmsi | SMALL_MMSI } else { mmsi };
            return Ok(Some(number));
        }
        let candidates = [
            (NameKind::Name, names.name),
            (NameKind::Callsign, names.callsign),
            (NameKind::Track, names.track),
        ];
        let Some((kind, (column, name))) = candidates.into_iter().find_map(|(kind, name)| Some((kind, name?))) else {
            return Ok(None);
        };
        let own = || name.parse::<u32>().ok().filter(|number| *number < FIRST);
        if let Some(number) = (kind == NameKind::Track && names.has_own_numbers).then(own).flatten() {
            return Ok(Some(number));
        }
        self.numbered(row, (kind, column), name).map(Some)
    }

    /// The number of the only target.
    pub(super) fn only() -> u32 {
        ONLY
    }

    fn numbered(&mut self, row: &Cells<'_>, (kind, column): (NameKind, Column), name: &str) -> Result<u32, CsvError> {
        if name.len() > LENGTH_MAX {
            let reason = format!("names a target by more than {LENGTH_MAX} bytes; shorten the name");
            return Err(row.error(column, reason));
        }
        let next = FIRST + self.by_name.len() as u32;
        if let Some(number) = self.by_name.get(&(kind, Box::from(name))) {
            return Ok(*number);
        }
        if self.by_name.len() == NAMES_MAX {
            let reason = format!("is one target too many; a table has at most {NAMES_MAX} names");
            return Err(row.error(column, reason));
        }
        self.by_name.insert((kind, Box::from(name)), next);
        Ok(next)
    }
}
