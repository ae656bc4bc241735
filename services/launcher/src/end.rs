//! How a process ended, in words.

use std::fmt;
use std::os::unix::process::ExitStatusExt as _;
use std::process::ExitStatus;
use std::time::Duration;

use signal_hook::consts::{SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV, SIGTERM, SIGTRAP};
use signal_hook::low_level::signal_name;

/// Exit code of a process that was used or configured wrongly (FM).
const CODE_REFUSED: i32 = 2;
/// Exit code of a Rust program that panicked.
const CODE_PANICKED: i32 = 101;
/// Signals that the kernel sends to a process for what it does itself.
const FAULTS: [i32; 6] = [SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV, SIGTRAP];

/// How a process ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// By itself, with this exit code.
    Code(i32),
    /// By a signal.
    Signal(i32),
    /// It stood still for so long, and was killed for it.
    StoodStill(Duration),
    /// It could not even be started, for this reason.
    NotStarted(String),
}

impl End {
    /// Whether it had done all it had to do.
    pub(crate) fn is_finished(&self) -> bool {
        *self == Self::Code(0)
    }

    /// Whether it refused how it was called or configured: another start would end the same way.
    pub(crate) fn is_refused(&self) -> bool {
        *self == Self::Code(CODE_REFUSED)
    }

    /// Whether what is in shared memory could have caused it: a fault, a panic, or that it stood still.
    pub(crate) fn may_be_of_memory(&self) -> bool {
        match self {
            Self::Code(code) => *code == CODE_PANICKED,
            Self::Signal(signal) => FAULTS.contains(signal),
            Self::StoodStill(_) => true,
            Self::NotStarted(_) => false,
        }
    }

    /// Whether somebody killed it.
    pub(crate) fn is_killed(&self) -> bool {
        *self == Self::Signal(signal_hook::consts::SIGKILL)
    }

    /// Whether a request to stop ended it before it could listen for one.
    pub(crate) fn is_request_to_stop(&self) -> bool {
        *self == Self::Signal(SIGTERM)
    }
}

impl From<ExitStatus> for End {
    fn from(status: ExitStatus) -> Self {
        match (status.code(), status.signal()) {
            (Some(code), _) => Self::Code(code),
            (None, signal) => Self::Signal(signal.unwrap_or(0)),
        }
    }
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Code(code) => write!(f, "ended with exit code {code}"),
            Self::Signal(number) => match signal_name(*number) {
                Some(name) => write!(f, "was killed by {name}"),
                None => write!(f, "was killed by signal {number}"),
            },
            Self::StoodStill(for_so_long) => {
                write!(f, "stood still for {:.1} s and was killed", for_so_long.as_secs_f64())
            }
            Self::NotStarted(reason) => write!(f, "could not be started ({reason})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_have_words() {
        let killed = End::from(ExitStatus::from_raw(9));
        assert_eq!(killed.to_string(), "was killed by SIGKILL");
        let failed = End::from(ExitStatus::from_raw(3 << 8));
        assert_eq!(failed.to_string(), "ended with exit code 3");
        assert!(!killed.may_be_of_memory() && End::from(ExitStatus::from_raw(11)).may_be_of_memory());
        assert!(!failed.may_be_of_memory() && End::Code(CODE_PANICKED).may_be_of_memory());
        assert!(End::from(ExitStatus::from_raw(0)).is_finished());
        assert!(End::from(ExitStatus::from_raw(2 << 8)).is_refused());
    }
}
