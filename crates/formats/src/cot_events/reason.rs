//! Why an event was refused.

use crate::target_message::{Reason, Refusal};

messages::codes! {
    /// Reason for refusing an event.
    pub enum CotReason: u8 {
        /// The event has no end.
        Partial = 0, "partial";
        /// The event is too long.
        Length = 1, "length";
        /// The event is no UTF-8 text.
        Text = 2, "text";
        /// The event is no well-formed XML.
        Xml = 3, "xml";
        /// The version of the schema is none.
        Version = 4, "version";
        /// The event has no uid or no type.
        Name = 5, "name";
        /// A time is none.
        Time = 6, "time";
        /// The position is not on the globe, or missing.
        Position = 7, "position";
        /// The height cannot be.
        Height = 8, "height";
        /// An error cannot be.
        Error = 9, "error";
        /// The course, speed or slope cannot be.
        Velocity = 10, "velocity";
        /// The table of things is full.
        Room = 11, "room";
    }
}

impl Reason for CotReason {
    fn sentence(self) -> &'static str {
        match self {
            Self::Partial => "was cut: another event begins, or the input ends, before </event>",
            Self::Length => "is longer than 65536 octets",
            Self::Text => "is not UTF-8 text",
            Self::Xml => "is wrong with the XML; an event is one element without a document type",
            Self::Version => "is no version of the schema from 2.0 on",
            Self::Name => "is missing; each event has a uid and a type",
            Self::Time => "is no date and time with a zone, like 2026-11-30T09:00:00.5Z",
            Self::Position => "is no latitude of -90 to 90 with a longitude of -180 to 180 degrees",
            Self::Height => "is no height above the ellipsoid from -12000 m on; 9999999 is unknown",
            Self::Error => "is no error from 0 m on; 9999999 is unknown",
            Self::Velocity => "is no speed of 0 to 12000 m/s, no course of 0 to 360 and no slope of -90 to 90 degrees",
            Self::Room => "has no room in the table; raise the number of things",
        }
    }
}

/// Result of reading a value.
pub(super) type Read<T> = Result<T, Refusal<CotReason>>;
