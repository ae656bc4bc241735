//! Errors of values that are to become ASTERIX bytes.
//!
//! Every error names its place as the documents do, item first, then element by element down to the value: I020/500
//! SDP X. A repetition is named by its position, from 1: I020/250 \[2\] BDS1.

use std::fmt;

use super::error::describe_choice;
use super::table::TextCoding;

/// Error of encoding a record with a table: place and fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{place}: {fault}")]
pub struct EncodeError {
    /// The item or element.
    pub place: RecordPlace,
    /// Fault of the value there.
    pub fault: EncodeFault,
}

/// A place in a record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordPlace {
    /// The category.
    pub category: u8,
    /// The item's name, the element's in it, and so on inwards; empty for the record as a whole.
    pub path: Vec<String>,
}

impl fmt::Display for RecordPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.path.as_slice() {
            [] => write!(f, "category {:03}", self.category),
            [item, elements @ ..] => {
                write!(f, "I{:03}/{item}", self.category)?;
                elements.iter().try_for_each(|element| write!(f, " {element}"))
            }
        }
    }
}

/// Fault of a value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EncodeFault {
    /// The record is of another category than the table.
    #[error("the record is of category {found:03}")]
    CategoryDiffers {
        /// The record's category.
        found: u8,
    },
    /// A record without a single item can not be sent.
    #[error("the record has no item")]
    RecordEmpty,
    /// The item that decides between several profiles is absent, or has a value without profile.
    #[error("{item} {element} decides the profile, {}", describe_choice(*found))]
    ProfileUndecided {
        /// The deciding item.
        item: &'static str,
        /// The deciding element in it.
        element: &'static str,
        /// Value of the deciding element, if the record has one.
        found: Option<u64>,
    },
    /// An item, subitem or element that the edition does not define there.
    #[error("the edition defines nothing of this name here")]
    Unknown,
    /// An item, subitem or element that was there before.
    #[error("is given twice")]
    Twice,
    /// A missing element that is mandatory in its group, or in its part of an extended item.
    #[error("is missing, but its group is always sent completely")]
    Missing,
    /// A value of another kind than in the table.
    #[error("takes {expected}, found {found}")]
    Kind {
        /// The kind in the table.
        expected: &'static str,
        /// The kind of the value.
        found: &'static str,
    },
    /// A code or a whole number that its bits can not hold.
    #[error("{value} is out of range, the least is {least}, the greatest {greatest}")]
    NumberOutOfRange {
        /// The number.
        value: i128,
        /// The least that its bits hold.
        least: i128,
        /// The greatest that its bits hold.
        greatest: i128,
    },
    /// A quantity that its bits can not hold, in the table's unit.
    #[error(
        "{value} is out of range, the least is {least}, the greatest {greatest}{}",
        describe_unit(unit)
    )]
    QuantityOutOfRange {
        /// The quantity.
        value: f64,
        /// The least that its bits hold.
        least: f64,
        /// The greatest that its bits hold.
        greatest: f64,
        /// The unit of all three; empty for none.
        unit: &'static str,
    },
    /// A quantity that is no number.
    #[error("the quantity is no number (NaN)")]
    NotANumber,
    /// A character that the coding lacks.
    #[error("{text:?} has the character {character:?}, which {} lacks", describe_coding(*coding))]
    Character {
        /// The text.
        text: String,
        /// The character.
        character: char,
        /// Coding of the text.
        coding: TextCoding,
    },
    /// A text with too many characters, or with too few where no space can fill it up.
    #[error("{text:?} has {characters} characters, the least is {least}, the most {greatest}")]
    TextLength {
        /// The text.
        text: String,
        /// Characters of the text.
        characters: usize,
        /// The least that can be sent.
        least: usize,
        /// The most that can be sent.
        greatest: usize,
    },
    /// A list of more values than its byte can count.
    #[error("has {count} values, the most is {greatest}")]
    Repetitions {
        /// The values.
        count: usize,
        /// The most that can be sent.
        greatest: usize,
    },
    /// A list without values, in an item with at least one value.
    #[error("has no value, but needs at least one")]
    NoRepetition,
    /// The content of an explicit item, too long for its length byte.
    #[error("has {octets} octets of content, the most is {greatest}")]
    ExplicitLength {
        /// The bytes given.
        octets: usize,
        /// The most its length byte can give, without that byte itself.
        greatest: usize,
    },
    /// Bytes beyond the last defined part of an extended item, of which no reader would find the end.
    #[error(
        "{octets:02x?} can not follow the last defined part: 1 to {greatest} octets, the FX bit set in all but the last"
    )]
    UnknownExtension {
        /// The bytes given.
        octets: Vec<u8>,
        /// The most that can follow.
        greatest: usize,
    },
}

/// An error on its way outwards; each level adds its name.
pub(super) struct Failure {
    /// Innermost first.
    path: Vec<String>,
    fault: EncodeFault,
}

impl Failure {
    pub(super) fn at(name: &str, fault: EncodeFault) -> Self {
        Self::from(fault).within(name)
    }

    #[cold]
    pub(super) fn within(mut self, name: &str) -> Self {
        self.path.push(name.to_owned());
        self
    }

    /// Names the repetition, counted from 1, at this place of its list.
    #[cold]
    pub(super) fn within_repetition(self, place: usize) -> Self {
        self.within(&format!("[{}]", place + 1))
    }

    pub(super) fn into_error(mut self, category: u8) -> EncodeError {
        self.path.reverse();
        EncodeError {
            place: RecordPlace {
                category,
                path: self.path,
            },
            fault: self.fault,
        }
    }
}

impl From<EncodeFault> for Failure {
    fn from(fault: EncodeFault) -> Self {
        Self {
            path: Vec::new(),
            fault,
        }
    }
}

fn describe_unit(unit: &str) -> String {
    match unit {
        "" => String::new(),
        _ => format!(" (all in {unit})"),
    }
}

fn describe_coding(coding: TextCoding) -> &'static str {
    match coding {
        TextCoding::Ascii => "printable ASCII",
        TextCoding::Icao => "the six-bit alphabet",
        TextCoding::Octal => "the octal digits",
    }
}
