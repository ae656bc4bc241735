//! Smoothed states beside the loop: a separate thread publishes the states of some seconds ago.
//!
//! Smoothing allocates, and takes some milliseconds a second for each track. The loop therefore only copies its output
//! into a bounded queue without locks. The thread takes the queue, smooths, and publishes on `system/smoothed`:
//!
//! ```text
//!   loop ── inputs of filters, states ──▶ queue ──▶ thread, every 10 ms ──▶ topic `system/smoothed`
//! ```
//!
//! If the thread is too slow, the queue fills; entries without room are dropped and counted (`smoothing_dropped`). With
//! recorded inputs nothing is dropped: the loop waits, so a recording gives the same states at any speed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Mark, Publisher, Root, SharedMemory, Transport};
use crossbeam_queue::ArrayQueue;
use fusion::FilterInput;
use fusion::smoothing::LagSmoother;
use messages::SystemTrack;
use runtime::clock::{boot_identity, mono_ns};
use runtime::cores;

/// Least number of inputs and states that may wait for the thread: the output during many of the thread's pauses.
const EMITTED_MIN: usize = 8192;
/// States of each system track that may wait at least.
const PER_TRACK: usize = 4;
/// Number of states that are sent together.
const TOGETHER: usize = 64;
/// Period of the thread.
const PAUSE: Duration = Duration::from_millis(10);

/// Output of the loop.
#[derive(Clone, Copy, Debug)]
// The loop may not allocate, so a state is not in a box.
#[allow(clippy::large_enum_variant)]
enum Emitted {
    Input(FilterInput),
    State(SystemTrack),
    /// Nothing follows.
    End,
}

/// Queue from the loop to the thread.
#[derive(Debug)]
pub struct SmoothingQueue {
    emitted: ArrayQueue<Emitted>,
    closing: AtomicBool,
    /// Whether the thread has ended.
    ended: AtomicBool,
    /// Whether the states continue the tracks of the previous epoch.
    goes_on: AtomicBool,
}

impl SmoothingQueue {
    /// Allocates the queue for so many system tracks.
    pub fn new(system_tracks: usize) -> Arc<Self> {
        Arc::new(Self {
            emitted: ArrayQueue::new(EMITTED_MIN.max(PER_TRACK * system_tracks)),
            closing: AtomicBool::new(false),
            ended: AtomicBool::new(false),
            goes_on: AtomicBool::new(false),
        })
    }

    /// Whether there is room for the output of a turn of the loop; without a reader nothing waits for room.
    pub(crate) fn has_room(&self) -> bool {
        self.emitted.len() < self.emitted.capacity() / 2 || self.ended.load(Ordering::Acquire)
    }

    /// Marks the states as continuing the tracks of the previous epoch.
    pub(crate) fn go_on(&self) {
        self.goes_on.store(true, Ordering::Release);
    }

    /// Takes an input of a filter; `false` if there is no room.
    pub(crate) fn input(&self, input: &FilterInput) -> bool {
        self.emitted.push(Emitted::Input(*input)).is_ok()
    }

    /// Takes a state; `false` if there is no room.
    pub(crate) fn state(&self, state: SystemTrack) -> bool {
        self.emitted.push(Emitted::State(state)).is_ok()
    }

    /// Nothing follows.
    pub(crate) fn end(&self) -> bool {
        self.emitted.push(Emitted::End).is_ok()
    }
}

/// Takes the queue, and publishes smoothed states.
#[derive(Debug)]
pub struct SmoothingWorker<'a, S: Transport> {
    queue: Arc<SmoothingQueue>,
    smoother: LagSmoother,
    bus: &'a Bus<S>,
    incarnation: u64,
    /// Present once fusion leads: the epoch is then known.
    publisher: Option<Publisher<S, SystemTrack>>,
    progress_ns: i64,
    smoothed: Vec<SystemTrack>,
}

impl<'a, S: Transport> SmoothingWorker<'a, S> {
    /// Publishes on `bus`; states leave at the age `lag_ns`.
    pub fn new(queue: Arc<SmoothingQueue>, lag_ns: i64, bus: &'a Bus<S>, incarnation: u64) -> Self {
        Self {
            queue,
            smoother: LagSmoother::new(lag_ns),
            bus,
            incarnation,
            publisher: None,
            progress_ns: i64::MIN,
            smoothed: Vec::new(),
        }
    }

    /// Works off the queue.
    ///
    /// # Errors
    /// If a state cannot be published.
    pub fn turn(&mut self) -> anyhow::Result<()> {
        while let Some(emitted) = self.queue.emitted.pop() {
            let smoothed = &mut self.smoothed;
            let out = |state: &SystemTrack| smoothed.push(*state);
            match emitted {
                Emitted::Input(input) => self.smoother.input(&input, out),
                Emitted::State(state) => {
                    self.smoother.state(&state, out);
                    if self.publisher.is_none() {
                        self.publisher = Some(self.open(state.epoch)?);
                    }
                }
                Emitted::End => {
                    self.smoother.finish(out);
                    self.send(true)?;
                }
            }
            if self.smoothed.len() >= TOGETHER {
                self.send(false)?;
            }
        }
        if self.smoothed.is_empty() {
            return Ok(());
        }
        self.send(false)
    }

    fn open(&self, epoch: u64) -> anyhow::Result<Publisher<S, SystemTrack>> {
        let publisher = self.bus.publisher(&messages::smoothed_tracks(), self.incarnation)?;
        let mut publisher = publisher.with_epoch(epoch).of_boot(boot_identity());
        if self.queue.goes_on.load(Ordering::Acquire) {
            publisher.go_on();
        }
        Ok(publisher)
    }

    fn send(&mut self, end: bool) -> anyhow::Result<()> {
        let (smoothed, sent_ns) = (&self.smoothed, mono_ns());
        let newest_ns = smoothed.iter().map(|state| state.reference_time_ns).max();
        self.progress_ns = self.progress_ns.max(newest_ns.unwrap_or(i64::MIN));
        let mark = Mark {
            progress_ns: if end { i64::MAX } else { self.progress_ns },
            sent_ns,
            end,
        };
        if self.publisher.is_none() {
            // Without any state: no epoch is known.
            self.publisher = Some(self.open(self.incarnation)?);
        }
        let Some(publisher) = &mut self.publisher else {
            return Ok(());
        };
        publisher.send(mark, smoothed.len(), |index, sequence| {
            let mut state = smoothed[index];
            state.sequence = sequence;
            state.stages.fused_ns = sent_ns;
            state
        })?;
        self.smoothed.clear();
        Ok(())
    }
}

/// Marks the thread as ended when dropped, even by a panic.
struct Ending(Arc<SmoothingQueue>);

impl Drop for Ending {
    fn drop(&mut self) {
        self.0.ended.store(true, Ordering::Release);
    }
}

/// The thread, for the loop that started the thread.
#[derive(Debug)]
pub(crate) struct SmoothingThread {
    queue: Arc<SmoothingQueue>,
    thread: Option<JoinHandle<anyhow::Result<()>>>,
}

impl SmoothingThread {
    /// Starts the thread, which stays away from the `core` of the loop.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub(crate) fn start(
        (root, name): (Root, String),
        core: Option<usize>,
        (lag_ns, system_tracks, incarnation): (i64, usize, u64),
    ) -> anyhow::Result<Self> {
        let queue = SmoothingQueue::new(system_tracks);
        let taken = Arc::clone(&queue);
        let work = move || {
            let _ending = Ending(Arc::clone(&taken));
            if let Some(core) = core {
                cores::stay_away_from(core);
            }
            let bus: Bus<SharedMemory> = Bus::open(&root, &name)?;
            let mut worker = SmoothingWorker::new(Arc::clone(&taken), lag_ns, &bus, incarnation);
            loop {
                // Read before the queue is emptied: all entries queued before the close are published.
                let closing = taken.closing.load(Ordering::Acquire);
                worker.turn()?;
                if closing {
                    return Ok(());
                }
                std::thread::sleep(PAUSE);
            }
        };
        let thread = std::thread::Builder::new().name("smoothing".to_owned());
        let thread = thread.spawn(work).context("starting the smoothing thread")?;
        Ok(Self {
            queue,
            thread: Some(thread),
        })
    }

    pub(crate) fn queue(&self) -> Arc<SmoothingQueue> {
        Arc::clone(&self.queue)
    }

    /// Ends the thread, once all queued entries are published.
    ///
    /// # Errors
    /// Why the thread has ended before.
    pub(crate) fn close(mut self) -> anyhow::Result<()> {
        self.join()
    }

    fn join(&mut self) -> anyhow::Result<()> {
        self.queue.closing.store(true, Ordering::Release);
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result.context("smoothing"),
            Some(Err(_)) => anyhow::bail!("the smoothing thread panicked"),
            None => Ok(()),
        }
    }
}

impl Drop for SmoothingThread {
    fn drop(&mut self) {
        // Only without a call of `close`: the loop has failed, which is reported.
        let _ = self.join();
    }
}
