//! A thread of its own for each measurement, on the bench's core.
//!
//! Not the main thread: processes that are started inherit the core and priority of the thread that starts them, and
//! follow its end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use runtime::cores::{self, Placement};

/// Pause between two looks at the processes. Rare, so that looking disturbs little.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Does `work` on a thread at `place`. Meanwhile `watch` is asked whether to go on; if it says no, `work` is told to
/// end by the flag that it is given, and what `watch` said is the result.
pub(crate) fn run<R: Send>(
    place: Placement,
    mut watch: impl FnMut() -> anyhow::Result<()>,
    work: impl FnOnce(&Arc<AtomicBool>) -> anyhow::Result<R> + Send,
) -> anyhow::Result<R> {
    let abort = Arc::new(AtomicBool::new(false));
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| {
            // Refusals are shown once, by `refusals`.
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

/// What the machine refuses of `place`.
pub(crate) fn refusals(place: Placement) -> Vec<String> {
    let without_core = Placement { core: None, ..place };
    std::thread::scope(|scope| scope.spawn(|| cores::take_place(without_core)).join()).unwrap_or_default()
}
