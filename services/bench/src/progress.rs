//! Progress messages: lines on standard error. Results go to standard output.

/// Prints one line. Standard error may be closed; the measurement continues without it.
pub(crate) fn say(line: &str) {
    runtime::notice(format_args!("koseki: {line}"));
}
