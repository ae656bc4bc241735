//! Values of the target's transponder, as columns behind those of a detection (FM-6).
//!
//! | column | value |
//! | --- | --- |
//! | `address` | 24-bit address, hexadecimal |
//! | `mode_3a` | Mode 3/A code, octal |
//! | `callsign` | up to eight characters |
//! | `mmsi` | number of a ship, nine decimal digits; excludes an address |
//! | `level` | flight level of Mode C or Mode S, in quarters |
//! | `address_age_s` (of `mmsi`, too), `mode_3a_age_s`, `callsign_age_s`, `level_age_s` | age; empty: of this look |
//! | `name` | up to twenty characters |
//!
//! Every column may be absent and every value empty.

use csv_table::{Cells, Column, CsvError};
use observations::TransponderReply;

use crate::cells::Plain;
use crate::columns::columns;
use crate::identity_columns::IdentityPlaces;
use crate::parts::{word, words};

/// Steps of a level in a flight level.
const STEPS: f64 = 4.0;
/// Largest age, seconds: that of a sample.
const AGE_MAX_S: f64 = u32::MAX as f64 / 1e3;

/// A reply, written as a part of a row.
pub(crate) struct ReplyRow<'a>(pub(crate) &'a TransponderReply);

columns! {
    /// Places of the columns of replies.
    ReplyPlaces of ReplyRow<'_>: |row|
    address: Option<Column> = "address" => row.0.identity.address_text(),
    mode_3a: Option<Column> = "mode_3a" => row.0.identity.mode_3a_text(),
    callsign: Option<Column> = "callsign" => row.0.identity.callsign().map(word),
    mmsi: Option<Column> = "mmsi" => row.0.identity.mmsi_text(),
    level: Option<Column> = "level" => row.0.level.map(|level| Plain(f64::from(level) / STEPS, 2)),
    address_age: Option<Column> = "address_age_s" => age(row.0.ages.address_ms),
    mode_3a_age: Option<Column> = "mode_3a_age_s" => age(row.0.ages.mode_3a_ms),
    callsign_age: Option<Column> = "callsign_age_s" => age(row.0.ages.callsign_ms),
    level_age: Option<Column> = "level_age_s" => age(row.0.level_age_ms),
    name: Option<Column> = "name" => row.0.identity.name().map(words),
}

fn age(age_ms: u32) -> Option<Plain> {
    (age_ms > 0).then(|| Plain(f64::from(age_ms) / 1e3, 3))
}

impl ReplyPlaces {
    /// The reply of a row.
    ///
    /// # Errors
    /// A value that no transponder states.
    pub(crate) fn read(&self, row: Cells<'_>) -> Result<TransponderReply, CsvError> {
        let mut reply = TransponderReply {
            identity: self.identity().read(row)?,
            level: self.level(row)?,
            level_age_ms: age_ms(row, self.level_age)?,
            ..TransponderReply::default()
        };
        reply.ages.address_ms = age_ms(row, self.address_age)?;
        reply.ages.mode_3a_ms = age_ms(row, self.mode_3a_age)?;
        reply.ages.callsign_ms = age_ms(row, self.callsign_age)?;
        Ok(reply)
    }

    fn identity(&self) -> IdentityPlaces {
        let Self {
            address,
            mmsi,
            mode_3a,
            callsign,
            name,
            ..
        } = *self;
        IdentityPlaces {
            address,
            mmsi,
            mode_3a,
            callsign,
            name,
        }
    }

    fn level(&self, row: Cells<'_>) -> Result<Option<i16>, CsvError> {
        let (Some(column), Some(level)) = (self.level, row.number_or_empty(self.level)?) else {
            return Ok(None);
        };
        let steps = (level * STEPS).round();
        if !(f64::from(i16::MIN)..=f64::from(i16::MAX)).contains(&steps) {
            return Err(row.error(column, "is no flight level; write hundreds of feet"));
        }
        Ok(Some(steps as i16))
    }
}

fn age_ms(row: Cells<'_>, column: Option<Column>) -> Result<u32, CsvError> {
    match (column, row.number_or_empty(column)?) {
        (Some(column), Some(age_s)) if !(0.0..=AGE_MAX_S).contains(&age_s) => {
            Err(row.error(column, "is no age; write seconds from 0 on"))
        }
        (_, age_s) => Ok((age_s.unwrap_or_default() * 1e3).round() as u32),
    }
}
