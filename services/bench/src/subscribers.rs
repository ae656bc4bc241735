//! Further subscribers to the system tracks: some read, others have stopped reading.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, SharedMemory};
use runtime::clock::mono_ns;

use crate::site::BenchSite;

/// Pause between two reads: as long as the queues permit, so that the readers take little of the measured machine.
const READ_EVERY: Duration = Duration::from_millis(2);

/// Thread with subscribers, which leave on drop.
#[derive(Debug)]
pub(crate) struct Subscribers {
    thread: Option<JoinHandle<()>>,
    leave: Arc<AtomicBool>,
}

impl Subscribers {
    /// Starts `count` subscribers on a thread that may run on any core; without `read`, their queues overflow.
    pub(crate) fn start(site: &BenchSite, count: usize, read: bool) -> anyhow::Result<Self> {
        let leave = Arc::new(AtomicBool::new(false));
        if count == 0 {
            return Ok(Self { thread: None, leave });
        }
        let (root, left) = (site.root().clone(), Arc::clone(&leave));
        let (say, there) = sync_channel(1);
        let thread = std::thread::spawn(move || {
            let topic = messages::system_tracks();
            let opened = Bus::<SharedMemory>::open(&root, "bench-subscribers").and_then(|bus| {
                let subscribers: Result<Vec<_>, _> = (0..count)
                    .map(|_| bus.subscriber(&topic, || mono_ns() as u64))
                    .collect();
                subscribers
            });
            let mut subscribers = match opened {
                Ok(subscribers) => subscribers,
                Err(error) => return drop(say.send(Err(error))),
            };
            let _ = say.send(Ok(()));
            while !left.load(Ordering::Relaxed) {
                for subscriber in subscribers.iter_mut().filter(|_| read) {
                    // Read failures are ignored here; the bench's own reader reports failures.
                    let _ = subscriber.take(usize::MAX, |_, _| {});
                }
                std::thread::sleep(READ_EVERY);
            }
        });
        there.recv().context("the subscribers' thread has ended")??;
        Ok(Self {
            thread: Some(thread),
            leave,
        })
    }
}

impl Drop for Subscribers {
    fn drop(&mut self) {
        self.leave.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
