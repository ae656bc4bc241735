//! Why a frame was refused.

/// Reason for which a frame, or what stood in its place, was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum ModeSRefusal {
    /// Line longer than any with a frame.
    LineLength,
    /// Line of no known form.
    Line,
    /// Frame with a character that is no hexadecimal digit.
    Character,
    /// Frame of another length.
    Length,
    /// Frame that breaks off.
    Cut,
    /// Frame without a time.
    Time,
    /// Wrong checksum.
    Parity,
    /// Reply of an address that was not received lately.
    Address,
    /// Aircraft for which the table has no room.
    Table,
    /// Position that has come before.
    Repeated,
    /// Even and odd position from two latitude zones.
    Zone,
    /// Position out of the receiver's range.
    Range,
    /// Position that the aircraft cannot have reached.
    Speed,
    /// Position on the ground without a reference.
    Reference,
}

impl ModeSRefusal {
    /// Every reason, in the order of its code.
    pub const ALL: [Self; 14] = [
        Self::LineLength,
        Self::Line,
        Self::Character,
        Self::Length,
        Self::Cut,
        Self::Time,
        Self::Parity,
        Self::Address,
        Self::Table,
        Self::Repeated,
        Self::Zone,
        Self::Range,
        Self::Speed,
        Self::Reference,
    ];

    /// Returns the fault, and what is permitted.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::LineLength => "is longer than the 4096 characters of a line",
            Self::Line => "is no line with a frame: *HEX; @TICKSHEX; <TICKSSIGNALHEX; HEX, TIME HEX, or JSON",
            Self::Character => "has a character that is no hexadecimal digit",
            Self::Length => "has not the length of its format, 7 or 14 octets",
            Self::Cut => "breaks off: the next frame begins inside",
            Self::Time => "has no time: none of its own, none of receipt, and no ticks of a receiver",
            Self::Parity => "has a wrong checksum; check the receiver's signal level if there are many",
            Self::Address => "replies to an interrogation, and no squitter had the reply's address in the last 60 s",
            Self::Table => "is of one aircraft more than the table has room for",
            Self::Repeated => "repeats a position that was received less than 0.2 s before",
            Self::Zone => "has a position that lies in another latitude zone than its pair's first half",
            Self::Range => "has a position out of the receiver's range; check the receiver's place",
            Self::Speed => "has a position that its aircraft cannot have reached since its last position",
            Self::Reference => "has a position on the ground, which needs the receiver's place or an earlier position",
        }
    }
}
