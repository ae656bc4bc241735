//! Lines on standard error.
//!
//! The processes of a deployment share one standard error. Formatted output is written piece by piece, so that lines
//! of two processes can mix. A notice is one write.

use std::fmt;
use std::io::Write as _;

/// Writes a line to standard error in one piece. A closed standard error has no effect.
pub fn notice(line: impl fmt::Display) {
    let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
}
