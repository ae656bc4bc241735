//! Why a document or a state was refused.

use crate::target_message::{Reason, Refusal};

messages::codes! {
    /// Reason for refusing a document, or a state of an aircraft.
    pub enum ReadsbReason: u8 {
        /// The document is too long.
        Length = 0, "length";
        /// The document, or a part of it, is no JSON of the described form.
        Json = 1, "json";
        /// The document is of no known kind.
        Kind = 2, "kind";
        /// A time is none.
        Time = 3, "time";
        /// The address is none.
        Address = 4, "address";
        /// The position is not on the globe, or half of it is missing.
        Position = 5, "position";
        /// The altitude cannot be.
        Altitude = 6, "altitude";
        /// The speed or track cannot be.
        Velocity = 7, "velocity";
        /// The vertical rate cannot be.
        VerticalRate = 8, "vertical-rate";
        /// The callsign is none.
        Callsign = 9, "callsign";
        /// The Mode 3/A code is none.
        Code = 10, "code";
        /// The category is none.
        Category = 11, "category";
        /// The table of aircraft is full.
        Room = 12, "room";
    }
}

impl Reason for ReadsbReason {
    fn sentence(self) -> &'static str {
        match self {
            Self::Length => "octets are too many; divide the document, at most 16 MiB are read",
            Self::Json => "is wrong with the JSON; unpack compressed files first, and read one document at a time",
            Self::Kind => "has no aircraft with now, no hex with now, and no trace with icao and timestamp",
            Self::Time => "is no time in seconds since 1970, or no age of 0 to 86400 seconds",
            Self::Address => "is no address of six hexadecimal digits, with ~ before one that is not of ICAO",
            Self::Position => "is no latitude of -90 to 90 with a longitude of -180 to 180 degrees",
            Self::Altitude => "is no altitude of -1500 to 126750 ft, and not \"ground\"",
            Self::Velocity => "is no speed of 0 to 6000 kt, or no track of 0 to 360 degrees",
            Self::VerticalRate => "is no vertical rate of -32640 to 32640 ft/min",
            Self::Callsign => "is no callsign of up to eight letters and digits",
            Self::Code => "is no code of four octal digits",
            Self::Category => "is no category of A0 to D7",
            Self::Room => "has no room in the table; raise the number of aircraft",
        }
    }
}

/// Result of reading a value.
pub(super) type Read<T> = Result<T, Refusal<ReadsbReason>>;
