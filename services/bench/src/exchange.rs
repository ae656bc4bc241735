//! One end of the round trip: reports out, states back, on one thread or two.
//!
//! If fusion spins, one thread of the bench does both on the bench's core: it sends due batches and polls for
//! answers in between. If fusion sleeps until woken, so does the bench: one thread sends, and another blocks on the
//! states like any subscriber.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver as Jobs, SyncSender, sync_channel};

use anyhow::Context as _;

use crate::drive::{self, Load, MachineClock, NOT_YET, ReportSender, SendProgress, StateReceiver};
use crate::recorder::Recorder;

/// Executes loads, one after the other.
pub(crate) trait Exchange {
    /// Sends `load` and records the answers in `recorder`.
    fn run(&mut self, load: &Load<'_>, recorder: Recorder) -> anyhow::Result<(SendProgress, Recorder)>;
}

/// Exchange that alternates between sending and receiving.
pub(crate) struct OneThread<S, R> {
    pub(crate) sender: S,
    pub(crate) receiver: R,
    pub(crate) abort: Arc<AtomicBool>,
}

impl<S: ReportSender, R: StateReceiver> Exchange for OneThread<S, R> {
    fn run(&mut self, load: &Load<'_>, mut recorder: Recorder) -> anyhow::Result<(SendProgress, Recorder)> {
        let (sender, receiver) = (&mut self.sender, &mut self.receiver);
        let driven = drive::spin(load, sender, receiver, &mut recorder, &MachineClock, &self.abort)?;
        Ok((driven, recorder))
    }
}

/// Exchange that sends while a second thread receives. Both run at the place of the creating thread.
pub(crate) struct TwoThreads<S> {
    sender: S,
    jobs: SyncSender<Recorder>,
    done: Jobs<anyhow::Result<Recorder>>,
    all_sent: Arc<AtomicU64>,
    abort: Arc<AtomicBool>,
}

impl<S: ReportSender> TwoThreads<S> {
    /// Creates the exchange. The reading thread calls `make_receiver`, because ports stay on the creating thread.
    pub(crate) fn new<R: StateReceiver>(
        sender: S,
        make_receiver: impl FnOnce() -> anyhow::Result<R> + Send + 'static,
        abort: Arc<AtomicBool>,
    ) -> anyhow::Result<Self> {
        let (jobs, to_do) = sync_channel::<Recorder>(1);
        let (say_done, done) = sync_channel(1);
        let (say_ready, ready) = sync_channel(1);
        let all_sent = Arc::new(AtomicU64::new(NOT_YET));
        let (sent, stop) = (Arc::clone(&all_sent), Arc::clone(&abort));
        std::thread::spawn(move || {
            let mut receiver = match make_receiver() {
                Ok(receiver) => receiver,
                Err(error) => return drop(say_ready.send(Err(error))),
            };
            let _ = say_ready.send(Ok(()));
            while let Ok(mut recorder) = to_do.recv() {
                let read = drive::read_all(&mut receiver, &mut recorder, &MachineClock, &sent, &stop);
                if say_done.send(read.map(|()| recorder)).is_err() {
                    return;
                }
            }
        });
        ready.recv().context("the reading thread has ended")??;
        Ok(Self {
            sender,
            jobs,
            done,
            all_sent,
            abort,
        })
    }
}

impl<S: ReportSender> Exchange for TwoThreads<S> {
    fn run(&mut self, load: &Load<'_>, recorder: Recorder) -> anyhow::Result<(SendProgress, Recorder)> {
        self.all_sent.store(NOT_YET, Ordering::Release);
        self.jobs.send(recorder).context("the reading thread has ended")?;
        let driven = drive::send_all(load, &mut self.sender, &MachineClock, &self.abort);
        let batches = driven.as_ref().map_or(0, |driven| driven.batches);
        self.all_sent.store(batches, Ordering::Release);
        let recorder = self.done.recv().context("the reading thread has ended")??;
        Ok((driven?, recorder))
    }
}
