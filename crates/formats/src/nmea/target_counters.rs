//! Counts of lines with targets of a radar, and reasons of refusals.

use std::fmt;

use super::sentence::NmeaFault;

/// Octets of a line that an error shows.
const SHOWN_MAX: usize = 100;

messages::codes! {
    /// Why a line was refused.
    pub enum RadarTargetRejection {
        /// The line is no text, or too long.
        Text, "text";
        /// No sentence begins in the line.
        NoSentence, "no-sentence";
        /// The sentence has no checksum: it was cut.
        Partial, "partial";
        /// The checksum is another.
        Checksum, "checksum";
        /// A sentence of own ship is from an unknown talker.
        Talker, "talker";
        /// A field has no value that can be meant.
        Field, "field";
        /// Own ship's receiver has no fix, or its instrument no valid value.
        NoFix, "no-fix";
        /// Own ship's time is more than a day from the time of receipt.
        NoDate, "no-date";
        /// The target is relative to own ship, whose place is not known.
        OwnPlace, "own-place";
        /// The target is relative to own ship's bow, and own ship's heading is not known.
        OwnHeading, "own-heading";
        /// The target's motion is relative to own ship, whose velocity is not known.
        OwnVelocity, "own-velocity";
        /// Neither the line nor a line before it states a time.
        NoTime, "no-time";
        /// More radars than are remembered.
        Radars, "radars";
    }
}

impl RadarTargetRejection {
    /// Returns the fault, and what is permitted or helps.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Text => "is not UTF-8 text of up to 1024 octets",
            Self::NoSentence => "has no sentence; one begins with $ or !",
            Self::Partial => "was cut, or has no checksum; a sentence ends in * and two hexadecimal digits",
            Self::Checksum => "has another checksum than its characters give; check the line, its speed and its parity",
            Self::Talker | Self::Field | Self::NoFix | Self::NoDate => self.fault().sentence(),
            Self::OwnPlace => {
                "is relative to a radar whose place is not known: state [source.place] of a radar ashore, or send own \
                 ship's GGA, RMC or GLL in the same lines"
            }
            Self::OwnHeading => {
                "is relative to the bow of a ship whose heading is not known: send own ship's HDT, THS, or HDG with its \
                 variation, in the same lines, or set the radar to true bearings (T)"
            }
            Self::OwnVelocity => {
                "moves relative to a ship whose velocity is not known: send own ship's RMC or VTG in the same lines, or \
                 set the radar to true speeds and courses (T)"
            }
            Self::NoTime => {
                "has no time, nor has a line before it: record the lines with their times, or have the radar send UTC"
            }
            Self::Radars => "is of a 17th radar (talker and station); give some of them a source of their own",
        }
    }

    /// The fault of a sentence of which this is the reason.
    fn fault(self) -> NmeaFault {
        match self {
            Self::Talker => NmeaFault::Talker,
            Self::NoFix => NmeaFault::NoFix,
            Self::NoDate => NmeaFault::NoDate,
            _ => NmeaFault::Field,
        }
    }
}

impl From<NmeaFault> for RadarTargetRejection {
    fn from(fault: NmeaFault) -> Self {
        match fault {
            NmeaFault::NoSentence => Self::NoSentence,
            NmeaFault::Partial => Self::Partial,
            NmeaFault::Checksum => Self::Checksum,
            NmeaFault::Talker => Self::Talker,
            NmeaFault::TooLong => Self::Text,
            NmeaFault::Field => Self::Field,
            NmeaFault::NoFix => Self::NoFix,
            NmeaFault::NoDate => Self::NoDate,
        }
    }
}

/// Counts of lines. Each line is in exactly one of `targets`, `ended`, `without_position`, `repeats`, `own`, `others`
/// and `rejected`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RadarTargetCounters {
    /// Targets with a position.
    pub targets: u64,
    /// Targets that the radar has lost.
    pub ended: u64,
    /// Targets without a position that are not lost.
    pub without_position: u64,
    /// Targets that another line has brought already: TLL beside TTM, and losses stated again.
    pub repeats: u64,
    /// Lines with a state of own ship.
    pub own: u64,
    /// Lines without anything of these: comments, other sentences.
    pub others: u64,
    /// Lines that were refused, by [`RadarTargetRejection`].
    pub rejected: [u64; RadarTargetRejection::ALL.len()],
    /// Targets, with a position or ended, whose line states a time.
    pub timed: u64,
    /// Tag blocks with a wrong sum.
    pub wrong_tags: u64,
    /// First time with a date in the lines, UTC, nanoseconds since 1970.
    pub first_stated_ns: Option<i64>,
}

impl RadarTargetCounters {
    /// Lines refused for one reason.
    pub fn rejected(&self, reason: RadarTargetRejection) -> u64 {
        self.rejected[reason as usize]
    }
}

/// Fault of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RadarTargetError<'a> {
    /// Why the line was refused.
    pub rejection: RadarTargetRejection,
    /// The line.
    pub line: &'a [u8],
}

impl std::error::Error for RadarTargetError<'_> {}

impl fmt::Display for RadarTargetError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = String::from_utf8_lossy(&self.line[..self.line.len().min(SHOWN_MAX)]);
        write!(f, "line {shown:?} {}", self.rejection.sentence())
    }
}
