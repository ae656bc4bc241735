//! Identity of a target in the columns of tables that are read: one reader for all of them.
//!
//! A target is an aircraft or a ship, so a row has an address or an MMSI. Every column may be absent and every value
//! empty.

use std::io::Read;

use csv_table::{Cells, Column, CsvError, Table};
use messages::{Callsign, Identity, IdentityText, NAME_MAX};

/// Places of the columns of an identity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IdentityPlaces {
    pub(crate) address: Option<Column>,
    pub(crate) mmsi: Option<Column>,
    pub(crate) mode_3a: Option<Column>,
    pub(crate) callsign: Option<Column>,
    pub(crate) name: Option<Column>,
}

impl IdentityPlaces {
    /// Finds the columns under any of their names.
    ///
    /// # Errors
    /// If two columns state one quantity.
    pub(crate) fn of_quantities<R: Read>(table: &Table<R>) -> Result<Self, CsvError> {
        Ok(Self {
            address: table.of_quantity("address")?,
            mmsi: table.of_quantity("mmsi")?,
            mode_3a: table.of_quantity("mode_3a")?,
            callsign: table.of_quantity("callsign")?,
            name: table.of_quantity("name")?,
        })
    }

    /// The numbers in the identity of a row, without its callsign and name.
    ///
    /// # Errors
    /// A value that no target has, or an MMSI beside an address.
    pub(crate) fn numbers(&self, row: Cells<'_>) -> Result<Identity, CsvError> {
        let mut identity = Identity::default();
        if let Some(address) = number(row, self.address, IdentityText::ADDRESS)? {
            identity = identity.with_address(address);
        }
        if let (Some(column), Some(mmsi)) = (self.mmsi, number(row, self.mmsi, IdentityText::MMSI)?) {
            if identity.address().is_some() {
                return Err(row.error(column, "stands beside an address; a target is an aircraft or a ship"));
            }
            identity = identity.with_mmsi(mmsi);
        }
        if let Some(code) = number(row, self.mode_3a, IdentityText::MODE_3A)? {
            identity = identity.with_mode_3a(code as u16);
        }
        Ok(identity)
    }

    /// The identity of a row of a foreign table: a callsign or name that is longer or in other letters names its
    /// target, but fits into no sample.
    ///
    /// # Errors
    /// As [`Self::numbers`].
    pub(crate) fn lenient(&self, row: Cells<'_>) -> Result<Identity, CsvError> {
        let mut identity = self.numbers(row)?;
        if let Some(callsign) = row.stated(self.callsign)?.and_then(callsign) {
            identity = identity.with_callsign(callsign);
        }
        if let Some(name) = row.stated(self.name)?
            && name.len() <= NAME_MAX
            && is_plain(name)
        {
            identity = identity.with_name(name);
        }
        Ok(identity)
    }

    /// The identity of a row.
    ///
    /// # Errors
    /// A value that no target has, or an MMSI beside an address.
    pub(crate) fn read(&self, row: Cells<'_>) -> Result<Identity, CsvError> {
        let mut identity = self.numbers(row)?;
        if let (Some(column), Some(text)) = (self.callsign, row.text(self.callsign)?) {
            let found = callsign(text);
            let reason = "is no callsign; write up to eight characters of plain ASCII";
            identity = identity.with_callsign(found.ok_or_else(|| row.error(column, reason))?);
        }
        if let (Some(column), Some(text)) = (self.name, row.text(self.name)?) {
            if text.len() > NAME_MAX || !is_plain(text) {
                let reason = format!("is no name; write up to {NAME_MAX} characters of plain ASCII");
                return Err(row.error(column, reason));
            }
            identity = identity.with_name(text);
        }
        Ok(identity)
    }
}

fn number(row: Cells<'_>, column: Option<Column>, spelling: IdentityText) -> Result<Option<u32>, CsvError> {
    let (Some(column), Some(text)) = (column, digits(&row, column)?) else {
        return Ok(None);
    };
    let number = spelling.read(text);
    let wrong = || row.error(column, format!("is not {}", spelling.form));
    number.map(Some).ok_or_else(wrong)
}

/// A whole number as text, without the decimals that programs add to columns with absent values: `1174.0` is `1174`.
pub(crate) fn digits<'r>(row: &'r Cells<'_>, column: Option<Column>) -> Result<Option<&'r str>, CsvError> {
    Ok(row.stated(column)?.map(|text| text.strip_suffix(".0").unwrap_or(text)))
}

/// A callsign padded with blanks.
pub(crate) fn callsign(text: &str) -> Option<Callsign> {
    let mut callsign = *b"        ";
    callsign.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
    is_plain(text).then_some(callsign)
}

/// Whether a text is visible ASCII and blanks only.
pub(crate) fn is_plain(text: &str) -> bool {
    text.bytes().all(|octet| octet.is_ascii_graphic() || octet == b' ')
}
