//! Why a line or a message was refused.

use crate::target_message::{Reason, Refusal};

messages::codes! {
    /// Reason for refusing a line, or a message of a line.
    pub enum RemoteIdReason: u8 {
        /// The line is too long.
        Length = 0, "length";
        /// The line is no JSON of the described form.
        Json = 1, "json";
        /// The time is none.
        Time = 2, "time";
        /// The payload is no message and no pack.
        Payload = 3, "payload";
        /// Nothing names the transmitter.
        Transmitter = 4, "transmitter";
        /// The table of drones is full.
        Room = 5, "room";
        /// The type of the message is reserved.
        Kind = 6, "kind";
        /// The identity is no text.
        Identity = 7, "identity";
        /// A position is not on the globe.
        Position = 8, "position";
    }
}

impl Reason for RemoteIdReason {
    fn sentence(self) -> &'static str {
        match self {
            Self::Length => "octets are too many for a line; end each line, at most 4096 octets are read",
            Self::Json => "is wrong with the JSON; write an object with time and payload in each line",
            Self::Time => "is no time in seconds since 1970",
            Self::Payload => {
                "is neither a message of 25 octets nor a pack of one to nine, in hexadecimal digits or base64; begin \
                 with the octet of type and version"
            }
            Self::Transmitter => "belongs to no known drone; add mac to lines without a Basic ID",
            Self::Room => "has no room in the table; raise the number of drones",
            Self::Kind => "is no type of a message; 0 to 5 are, and 15 for a pack that holds no other pack",
            Self::Identity => "is no identity of printable ASCII characters",
            Self::Position => "is no latitude of -90 to 90 with a longitude of -180 to 180 degrees",
        }
    }
}

/// Result of reading a value.
pub(super) type Read<T> = Result<T, Refusal<RemoteIdReason>>;
