//! What is said while it runs: lines on standard error. Results go to standard output.

use std::io::Write as _;

/// One line. Standard error may be closed; that is no reason to end a measurement.
pub(crate) fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "koseki: {line}");
}
