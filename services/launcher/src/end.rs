//! Ends of processes, in words.

use std::fmt;
use std::os::unix::process::ExitStatusExt as _;
use std::process::ExitStatus;
use std::time::Duration;

use signal_hook::consts::{SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV, SIGTERM, SIGTRAP};
use signal_hook::low_level::signal_name;

/// Exit code of a process with wrong arguments or configuration (FM).
const CODE_REFUSED: i32 = 2;
/// Exit code of a Rust program after a panic.
const CODE_PANICKED: i32 = 101;
/// Signals of the kernel for a process's own faults.
const FAULTS: [i32; 6] = [SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV, SIGTRAP];

/// End of a process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// Exit with this code.
    Code(i32),
    /// Signal.
    Signal(i32),
    /// Kill after a hang of this time.
    StoodStill(Duration),
    /// Failure to start, with the reason.
    NotStarted(String),
}

impl End {
    /// Whether the process had finished the work.
    pub(crate) fn is_finished(&self) -> bool {
        *self == Self::Code(0)
    }

    /// Whether the process refused the arguments or configuration: a restart would end in the same way.
    pub(crate) fn is_refused(&self) -> bool {
        *self == Self::Code(CODE_REFUSED)
    }

    /// Whether contents of shared memory could be the cause: a fault, a panic, or a hang.
    pub(crate) fn may_be_of_memory(&self) -> bool {
        match self {
            Self::Code(code) => *code == CODE_PANICKED,
            Self::Signal(signal) => FAULTS.contains(signal),
            Self::StoodStill(_) => true,
            Self::NotStarted(_) => false,
        }
    }

    /// Whether another process killed the process.
    pub(crate) fn is_killed(&self) -> bool {
        *self == Self::Signal(signal_hook::consts::SIGKILL)
    }

    /// Whether a stop request ended the process before requests could be caught.
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
