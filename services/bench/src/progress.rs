//! Progress messages: lines on standard error. Results go to standard output.

use std::io::Write as _;

/// Prints one line. Standard error may be closed; the measurement continues without it.
pub(crate) fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "koseki: {line}");
}
