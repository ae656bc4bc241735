//! A pair of rings between two threads of one process: the least that passing a report on can take.
//!
//! The other thread takes the reports from one ring and puts a state for each into the other, with the sizes of the
//! real messages. There is no process border, no discovery and no header.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use crossbeam_queue::ArrayQueue;
use messages::{SensorTrack, SystemTrack};
use runtime::cores::{self, Placement};

use crate::drive::{ReportSender, SendTime, StateReceiver};
use crate::relay::{IdleRest, answer};
use crate::settings::Settings;

/// Places of a ring.
const PLACES: usize = 4096;

/// The thread at the other end, which ends when this is dropped.
#[derive(Debug)]
pub(crate) struct Echo {
    reports: Arc<ArrayQueue<SensorTrack>>,
    states: Arc<ArrayQueue<SystemTrack>>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Echo {
    /// Starts the thread in the place of fusion.
    pub(crate) fn start(settings: &Settings, rest_ns: Option<(i64, i64)>) -> Self {
        let place = Placement {
            core: Some(settings.fusion_core),
            ..settings.bench_place()
        };
        let reports = Arc::new(ArrayQueue::<SensorTrack>::new(PLACES));
        let states = Arc::new(ArrayQueue::new(PLACES));
        let ends = Arc::new(AtomicBool::new(false));
        let (from, to, end) = (Arc::clone(&reports), Arc::clone(&states), Arc::clone(&ends));
        let thread = std::thread::spawn(move || {
            let _ = cores::take_place(place);
            let mut rest = IdleRest::new(rest_ns);
            while !end.load(Ordering::Relaxed) {
                match from.pop() {
                    // A full ring loses the oldest, as a topic does.
                    Some(report) => {
                        to.force_push(answer(&report));
                        rest.worked();
                    }
                    None => rest.idle(),
                }
            }
        });
        Self {
            reports,
            states,
            ends,
            thread: Some(thread),
        }
    }

    pub(crate) fn sender(&self) -> ToRing {
        ToRing(Arc::clone(&self.reports))
    }

    pub(crate) fn receiver(&self) -> FromRing {
        FromRing(Arc::clone(&self.states))
    }
}

impl Drop for Echo {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // It ends at its next look, and has nothing to tell.
            let _ = thread.join();
        }
    }
}

/// Way to the other thread.
#[derive(Debug)]
pub(crate) struct ToRing(Arc<ArrayQueue<SensorTrack>>);

impl ReportSender for ToRing {
    fn send(
        &mut self,
        _: u16,
        _: SendTime,
        count: usize,
        mut fill: impl FnMut(usize) -> SensorTrack,
    ) -> anyhow::Result<()> {
        for index in 0..count {
            self.0.force_push(fill(index));
        }
        Ok(())
    }
}

/// Way back.
#[derive(Debug)]
pub(crate) struct FromRing(Arc<ArrayQueue<SystemTrack>>);

impl StateReceiver for FromRing {
    fn receive(&mut self, visit: impl FnOnce(&[SystemTrack])) -> anyhow::Result<bool> {
        Ok(self.0.pop().map(|track| visit(&[track])).is_some())
    }

    /// Losses appear as unanswered reports.
    fn lost(&self) -> u64 {
        0
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        std::thread::sleep(at_most);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use messages::StageTimes;

    use super::*;
    use crate::settings::test_settings;

    #[test]
    fn each_report_is_answered_with_its_stamps() {
        let echo = Echo::start(&test_settings(), None);
        let (mut sender, mut receiver) = (echo.sender(), echo.receiver());
        let mark = SendTime {
            now_ns: 0,
            progress_ns: 0,
        };
        let stages = |index: usize| StageTimes {
            ingested_ns: index as i64 + 7,
            ..StageTimes::default()
        };
        let filled = |index| SensorTrack {
            source: 3,
            stages: stages(index),
            ..SensorTrack::default()
        };
        sender.send(3, mark, 2, filled).unwrap();
        let mut answers = Vec::new();
        while answers.len() < 2 {
            receiver.receive(|tracks| answers.extend_from_slice(tracks)).unwrap();
        }
        let found: Vec<_> = answers
            .iter()
            .map(|track| (track.trigger_source, track.stages))
            .collect();
        assert_eq!(found, [(3, stages(0)), (3, stages(1))]);
    }
}
