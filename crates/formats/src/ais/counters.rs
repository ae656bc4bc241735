//! Counts of lines, and reasons of refusals.

use std::fmt;

/// Octets of a line that an error shows.
const SHOWN_MAX: usize = 100;

messages::codes! {
    /// Why a line was refused.
    pub enum AisRejection {
        /// The line is no text, or too long.
        Text, "text";
        /// No sentence begins in the line.
        NoSentence, "no-sentence";
        /// The sentence has no checksum: it was cut.
        Partial, "partial";
        /// The checksum is another.
        Checksum, "checksum";
        /// The number of fields, of parts or of fill bits cannot be.
        Fields, "fields";
        /// The payload has a character that codes no six bits.
        Payload, "payload";
        /// The part of a message has no predecessor, or another one.
        Order, "order";
        /// The number of the message's type or part is unknown.
        Type, "type";
        /// The message is shorter or longer than its type.
        Length, "length";
        /// No station has the MMSI.
        Mmsi, "mmsi";
    }
}

impl AisRejection {
    /// Returns the fault, and what is permitted.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Text => "is not UTF-8 text of up to 1024 octets",
            Self::NoSentence => "has no sentence; one begins with ! or $",
            Self::Partial => "was cut, or has no checksum; a sentence ends in * and two hexadecimal digits",
            Self::Checksum => "has another checksum than its characters give; check the line, its speed and its parity",
            Self::Fields => "is no VDM or VDO of seven fields, with a part of 1 to 255 and 0 to 5 fill bits",
            Self::Payload => "has a character other than 0 to W and ` to w in its payload",
            Self::Order => "continues a message whose part before it is missing; check the receiver for lost sentences",
            Self::Type => "has a message of unknown type; 1 to 27 are known, and of type 24 the parts A and B",
            Self::Length => "has a message that is shorter or longer than its type",
            Self::Mmsi => "is from an MMSI that no station has; check the transponder's setting",
        }
    }
}

/// Counts of lines. Each line is in exactly one of `messages`, `parts`, `repeats`, `others` and `rejected`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AisCounters {
    /// Lines with a message, or with the last part of one.
    pub messages: u64,
    /// Messages with a time in their lines.
    pub timed: u64,
    /// The first of these times, UTC, nanoseconds since 1970.
    pub first_stated_ns: Option<i64>,
    /// Lines with another part of a message.
    pub parts: u64,
    /// Lines with a message that another line has brought already.
    pub repeats: u64,
    /// Lines without a sentence of AIS: comments, other sentences.
    pub others: u64,
    /// Lines that were refused, by [`AisRejection`].
    pub rejected: [u64; AisRejection::ALL.len()],
    /// Messages by type, 1 to 27.
    pub types: [u64; 28],
    /// Positions given: of targets, of own ship, of fixed stations.
    pub positions: u64,
    /// Messages that announce a position and hold none.
    pub without_position: u64,
    /// Messages of which parts have not come in time.
    pub unfinished: u64,
    /// Tag blocks with a wrong sum.
    pub wrong_tags: u64,
    /// Messages of stations for whose static data the table had no room.
    pub refused_stations: u64,
}

impl AisCounters {
    /// Lines refused for one reason.
    pub fn rejected(&self, reason: AisRejection) -> u64 {
        self.rejected[reason as usize]
    }
}

/// Fault of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AisError<'a> {
    /// Why the line was refused.
    pub rejection: AisRejection,
    /// The line.
    pub line: &'a [u8],
}

impl std::error::Error for AisError<'_> {}

impl fmt::Display for AisError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = String::from_utf8_lossy(&self.line[..self.line.len().min(SHOWN_MAX)]);
        write!(f, "line {shown:?} {}", self.rejection.sentence())
    }
}
