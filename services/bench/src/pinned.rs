//! Own thread for each measurement, on the bench's core.
//!
//! The main thread is unsuitable: child processes inherit the core and priority of the thread that starts them, and
//! end with it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use runtime::cores::{self, Placement};

/// Pause between two checks of the processes; long, so that the checks disturb little.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Runs `work` on a thread at `place` and polls `watch` meanwhile. If `watch` fails, the abort flag passed to
/// `work` is set, and the error of `watch` is the result.
pub(crate) fn run<R: Send>(
    place: Placement,
    mut watch: impl FnMut() -> anyhow::Result<()>,
    work: impl FnOnce(&Arc<AtomicBool>) -> anyhow::Result<R> + Send,
) -> anyhow::Result<R> {
    let abort = Arc::new(AtomicBool::new(false));
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| {
            // `refusals` shows refusals once.
            let _ = cores::take_place(place);
            work(&abort)
        });
        let mut watched = Ok(());
        while !worker.is_finished() {
            if watched.is_ok() {
                watched = watch();
                abort.store(watched.is_err(), Ordering::Relaxed);
            }
            std::thread::sleep(LOOK_EVERY);
        }
        let worked = match worker.join() {
            Ok(worked) => worked,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        watched.and(worked)
    })
}

/// Returns the parts of `place` that the machine refuses.
pub(crate) fn refusals(place: Placement) -> Vec<String> {
    let without_core = Placement { core: None, ..place };
    std::thread::scope(|scope| scope.spawn(|| cores::take_place(without_core)).join()).unwrap_or_default()
}
