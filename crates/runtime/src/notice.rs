//! Lines on standard error.
//!
//! The processes of a deployment share one standard error. Formatted output to it is written piece by piece, so that
//! lines of two processes would mix. A notice is one write.

use std::fmt;
use std::io::Write as _;

/// Writes a line to standard error in one piece. A standard error that is closed ends nothing.
pub fn notice(line: impl fmt::Display) {
    let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
}
