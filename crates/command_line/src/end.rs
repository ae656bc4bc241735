//! Ends of a program: exit codes, and the one line on standard error that explains the code (FM-16).

use std::error::Error;
use std::fmt::Display;
use std::process::ExitCode;

use clap::Command;
use clap::error::ErrorKind;

use crate::{one_line, usage_line};

/// Exit code of a failure while running, or of a result that is worth nothing.
pub const CODE_FAILED: u8 = 1;
/// Exit code of wrong usage or configuration.
pub const CODE_REFUSED: u8 = 2;

/// Returns the exit code for a command line that was not parsed. Help and version, which are asked for, go to standard
/// output with code 0; everything else is one line on standard error, with a hint where to read on.
pub fn refuse_usage(error: &clap::Error, program: &Command) -> ExitCode {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        return match error.print() {
            Ok(()) => ExitCode::SUCCESS,
            Err(_) => ExitCode::from(CODE_FAILED),
        };
    }
    let words: Vec<String> = std::env::args().collect();
    end_with(CODE_REFUSED, usage_line(error, program, &words))
}

/// Joins an error and its causes. A cause that its error names already is not repeated.
pub fn reason(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut next = error.source();
    while let Some(cause) = next {
        let words = cause.to_string();
        if !text.ends_with(&words) {
            text.push_str(": ");
            text.push_str(&words);
        }
        next = cause.source();
    }
    text
}

/// Writes the reason in one line, and returns the exit code.
pub fn end_with(code: u8, reason: impl Display) -> ExitCode {
    let reason = one_line(&reason.to_string());
    runtime::notice(format_args!("koseki: {reason}"));
    ExitCode::from(code)
}
