//! Stop requests.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rustix::process::{Signal, getppid, set_parent_process_death_signal};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

/// Stop request by SIGTERM, by Ctrl-C at a terminal, or by the end of the terminal (SIGHUP).
#[derive(Clone, Debug)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Catches SIGTERM, SIGINT and SIGHUP from now on. A second signal ends the process at once. A SIGHUP that was
    /// ignored at the start of the process (`nohup`) stays ignored.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn on_signals() -> io::Result<Self> {
        let flag = Arc::new(AtomicBool::new(false));
        let stays_without_terminal = is_ignored(SIGHUP);
        for signal in [SIGTERM, SIGINT, SIGHUP] {
            if signal == SIGHUP && stays_without_terminal {
                continue;
            }
            signal_hook::flag::register_conditional_shutdown(signal, 1, Arc::clone(&flag))?;
            signal_hook::flag::register(signal, Arc::clone(&flag))?;
        }
        Ok(Self(flag))
    }

    /// Catches the same signals; later signals do not end the process. For a process that ends soon after the first
    /// signal, and whose sudden end would leave shared memory behind. `timeout` sends SIGTERM twice, to the process
    /// and to its group.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn on_signals_to_clear_up() -> io::Result<Self> {
        let flag = Arc::new(AtomicBool::new(false));
        let caught = [SIGTERM, SIGINT, SIGHUP];
        for signal in caught
            .into_iter()
            .filter(|signal| *signal != SIGHUP || !is_ignored(SIGHUP))
        {
            signal_hook::flag::register(signal, Arc::clone(&flag))?;
        }
        Ok(Self(flag))
    }

    /// Whether a stop has been requested.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Whether the parent has set `signal` to be ignored by this process and its children.
pub fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & 1 << (signal - 1) != 0)
}

/// Requests the kernel to stop this process when `launcher`, its parent, dies. Returns `false` if the parent is dead
/// already.
///
/// # Errors
/// If the operating system refuses.
pub fn stop_with_parent(launcher: u32) -> io::Result<bool> {
    set_parent_process_death_signal(Some(Signal::TERM))?;
    // The parent may have died before the line above.
    Ok(getppid().is_some_and(|parent| parent.as_raw_nonzero().get() as u32 == launcher))
}
