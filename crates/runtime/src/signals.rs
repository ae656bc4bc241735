//! Being asked to stop.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rustix::process::{Signal, getppid, set_parent_process_death_signal};
use signal_hook::consts::{SIGINT, SIGTERM};

/// Becomes true when the process is asked to stop (SIGTERM, or Ctrl-C at a terminal).
#[derive(Clone, Debug)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Catches SIGTERM and SIGINT from now on. A second signal ends the process at once.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn on_signals() -> io::Result<Self> {
        let flag = Arc::new(AtomicBool::new(false));
        for signal in [SIGTERM, SIGINT] {
            signal_hook::flag::register_conditional_shutdown(signal, 1, Arc::clone(&flag))?;
            signal_hook::flag::register(signal, Arc::clone(&flag))?;
        }
        Ok(Self(flag))
    }

    /// Whether the process has been asked to stop.
    pub fn requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Asks the kernel to stop this process when `launcher`, its parent, dies, however it dies. If it is dead already,
/// `false`.
///
/// # Errors
/// If the operating system refuses.
pub fn stop_with_parent(launcher: u32) -> io::Result<bool> {
    set_parent_process_death_signal(Some(Signal::TERM))?;
    // The parent may have died before the line above.
    Ok(getppid().is_some_and(|parent| parent.as_raw_nonzero().get() as u32 == launcher))
}
