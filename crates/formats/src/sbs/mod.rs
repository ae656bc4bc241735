//! Lines of transponder receivers, as BaseStation writes them (SBS-1, TCP port 30003).
//!
//! The format comes from a hobby receiver of 2005; nearly every receiver of aircraft transponders supports it today.
//! No standard defines the format; the sources are a description by its users
//! (<http://woodair.net/SBS/Article/Barebones42_Socket_Data.htm>) and the programs that write it, which differ in
//! details. A line has 22 values separated by commas:
//!
//! | places | value |
//! | --- | --- |
//! | 1, 2 | `MSG`, and the kind of the transmission, 1 to 8 |
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
//! A line contains only the data of a single transmission: a position, a velocity, or sometimes a callsign.
//! [`SbsLine::parse`] reads a line; [`AircraftMerger`] combines the recent lines of each aircraft, and gives an
//! [`Observation`](observations::Observation) for each position. The other kinds of line, `SEL`, `ID`, `AIR`, `STA`
//! and `CLK`, describe events in the receiver's window, and are ignored.
//!
//! Times have no time zone. Usually they are the local time of the writing computer; a nonzero offset from UTC must
//! be configured.

mod line;
mod merger;
mod moving;

pub(crate) use line::{ALTITUDE_FT, M_PER_FT, MPS_PER_KT, SPEED_KT, VERTICAL_RATE_FTPMIN, callsign};
pub use line::{Date, LineRejection, OtherKind, SbsError, SbsLine, SbsMessage, SbsTime};
pub use merger::{
    AircraftMerger, CALLSIGN_AGE_MAX_NS, CODE_AGE_MAX_NS, MOTION_AGE_MAX_NS, SILENCE_MAX_NS, SbsCounters, SbsSettings,
};
pub use moving::{moved_line, stamped_ns};
