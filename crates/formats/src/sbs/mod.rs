//! Lines of transponder receivers, as BaseStation writes them (SBS-1, TCP port 30003).
//!
//! The format is that of a hobby receiver of 2005, and has become what nearly every receiver of aircraft transponders
//! can speak. No standard defines it; what is known comes from a description by its users
//! (<http://woodair.net/SBS/Article/Barebones42_Socket_Data.htm>) and from the programs that write it, which differ in
//! details. A line is 22 values separated by commas:
//!
//! | places | value |
//! | --- | --- |
//! | 1, 2 | `MSG`, and which of eight kinds of transmission was heard |
//! | 3, 4, 6 | numbers in the receiver's own database: not used |
//! | 5 | the aircraft's 24-bit address, hexadecimal |
//! | 7, 8 | date and time of reception |
//! | 9, 10 | date and time of writing |
//! | 11 | callsign |
//! | 12 | pressure altitude, feet |
//! | 13, 14 | ground speed, knots, and track, degrees from north |
//! | 15, 16 | latitude and longitude, degrees |
//! | 17 | vertical rate, feet per minute |
//! | 18 | Mode 3/A code, octal |
//! | 19 to 22 | code changed, emergency, identification pressed, on the ground: 0 for no, anything else for yes |
//!
//! A line holds only what its one transmission said: a position here, a velocity there, a callsign now and then.
//! [`Line::parse`] reads one; [`Merger`] puts the recent ones of each aircraft together, and gives an
//! [`Observation`](observations::Observation) whenever a position comes in. The other kinds of line, `SEL`, `ID`,
//! `AIR`, `STA` and `CLK`, speak of what happens in the receiver's window, and are passed over.
//!
//! Times carry no zone. As a rule they are the local time of the computer that writes them, whatever that is set to, so
//! the offset from UTC must be configured where it is not zero.

mod line;
mod merger;
mod moving;

pub use line::{Date, Line, Message, OtherKind, Rejection, SbsError, Stamp};
pub use merger::{
    CALLSIGN_AGE_MAX_NS, CODE_AGE_MAX_NS, MOTION_AGE_MAX_NS, Merger, SILENCE_MAX_NS, SbsCounters, SbsSettings,
};
pub use moving::{moved_line, stamped_ns};
