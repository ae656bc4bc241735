//! Sends batches at the due times and receives the answers.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use anyhow::bail;
use messages::{SensorTrack, SystemTrack};

use crate::pace::Pace;
use crate::recorder::Recorder;
use crate::traffic::{Traffic, stamps};

/// Maximum wait for another answer after the last answer, nanoseconds.
const LINGER_NS: i64 = 500_000_000;
/// A resting thread wakes this long before the next report is due, nanoseconds, because sleep is inaccurate.
const AWAKE_BEFORE_NS: i64 = 200_000;
/// Minimum useful rest, nanoseconds.
const REST_MIN_NS: i64 = 300_000;
/// Maximum sleep of a reader between two checks for the end.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Value of the number of sent batches while further batches follow.
pub(crate) const NOT_YET: u64 = u64::MAX;

/// Outgoing path of reports.
pub(crate) trait ReportSender {
    /// Sends `count` reports of `source` as one slice.
    fn send(
        &mut self,
        source: u16,
        mark: SendTime,
        count: usize,
        fill: impl FnMut(usize) -> SensorTrack,
    ) -> anyhow::Result<()>;
}

/// Send time of a slice, and the source's progress stated in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SendTime {
    pub(crate) now_ns: i64,
    pub(crate) progress_ns: i64,
}

/// Incoming path of states.
pub(crate) trait StateReceiver {
    /// Passes the next slice to `visit`; returns `false` if there is none.
    fn receive(&mut self, visit: impl FnOnce(&[SystemTrack])) -> anyhow::Result<bool>;

    /// Returns the states lost before this receiver since its creation.
    fn lost(&self) -> u64;

    /// Sleeps until a slice may be available, at most `at_most`.
    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()>;
}

/// Monotonic clock.
pub(crate) trait Clock {
    fn now_ns(&self) -> i64;
    fn sleep(&self, nanoseconds: i64);
}

/// Clock of this machine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MachineClock;

impl Clock for MachineClock {
    fn now_ns(&self) -> i64 {
        runtime::clock::mono_ns()
    }

    fn sleep(&self, nanoseconds: i64) {
        std::thread::sleep(Duration::from_nanos(nanoseconds.max(0) as u64));
    }
}

/// Load to send.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Load<'a> {
    pub(crate) traffic: &'a Traffic,
    pub(crate) pace: Pace,
    /// Number of batches at that pace.
    pub(crate) batches: u64,
    /// Whether the thread must rest when nothing is due.
    pub(crate) rests: bool,
    /// Flooding source: sends further batches at a separate pace meanwhile.
    pub(crate) flood: Option<(u16, Pace)>,
}

/// Progress of sending.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SendProgress {
    /// Batches of the load.
    pub(crate) batches: u64,
    /// Further batches of the flooding source.
    pub(crate) flood_batches: u64,
    /// Send time of the last batch, monotonic, nanoseconds.
    pub(crate) last_sent_ns: i64,
    /// Lateness of the last batch, nanoseconds.
    pub(crate) last_late_ns: i64,
    /// Reception time of the last state, monotonic, nanoseconds.
    pub(crate) last_heard_ns: i64,
}

/// Sends and receives on one thread, which sleeps only if required by the load.
pub(crate) fn spin(
    load: &Load<'_>,
    sender: &mut impl ReportSender,
    receiver: &mut impl StateReceiver,
    recorder: &mut Recorder,
    clock: &impl Clock,
    abort: &AtomicBool,
) -> anyhow::Result<SendProgress> {
    let mut driven = SendProgress::default();
    loop {
        let now_ns = clock.now_ns();
        match next_due(load, &driven) {
            Some((due_ns, flood)) if due_ns <= now_ns => send(load, sender, &mut driven, flood, due_ns, now_ns)?,
            Some((due_ns, _)) => {
                let rest_ns = due_ns - now_ns - AWAKE_BEFORE_NS;
                if load.rests && rest_ns >= REST_MIN_NS && recorder.has_all(driven.batches) {
                    clock.sleep(rest_ns);
                }
            }
            None => {
                let quiet_ns = now_ns - driven.last_heard_ns.max(driven.last_sent_ns);
                if recorder.has_all(driven.batches) || quiet_ns > LINGER_NS {
                    recorder.missed_by_reader(receiver.lost());
                    return Ok(driven);
                }
            }
        }
        if receiver.receive(|tracks| take(tracks, recorder, clock))? {
            driven.last_heard_ns = now_ns;
        }
        if abort.load(Ordering::Relaxed) {
            bail!("the measurement was ended early");
        }
    }
}

/// Sends only; the thread sleeps during long pauses and yields otherwise.
pub(crate) fn send_all(
    load: &Load<'_>,
    sender: &mut impl ReportSender,
    clock: &impl Clock,
    abort: &AtomicBool,
) -> anyhow::Result<SendProgress> {
    let mut driven = SendProgress::default();
    while let Some((due_ns, flood)) = next_due(load, &driven) {
        loop {
            let now_ns = clock.now_ns();
            if due_ns <= now_ns {
                send(load, sender, &mut driven, flood, due_ns, now_ns)?;
                break;
            }
            if due_ns - now_ns > 2 * AWAKE_BEFORE_NS {
                clock.sleep(due_ns - now_ns - AWAKE_BEFORE_NS);
            } else {
                // The reader on the same core must be able to run at once.
                std::thread::yield_now();
            }
        }
        if abort.load(Ordering::Relaxed) {
            bail!("the measurement was ended early");
        }
    }
    Ok(driven)
}

/// Receives until all sent batches are answered or answers stop; `all_sent` holds the number of batches once known.
pub(crate) fn read_all(
    receiver: &mut impl StateReceiver,
    recorder: &mut Recorder,
    clock: &impl Clock,
    all_sent: &AtomicU64,
    abort: &AtomicBool,
) -> anyhow::Result<()> {
    let mut heard_ns = i64::MIN;
    let mut sent_ns = None;
    loop {
        while receiver.receive(|tracks| take(tracks, recorder, clock))? {
            heard_ns = clock.now_ns();
        }
        let sent = all_sent.load(Ordering::Acquire);
        if sent != NOT_YET {
            let now_ns = clock.now_ns();
            let since_ns = heard_ns.max(*sent_ns.get_or_insert(now_ns));
            if recorder.has_all(sent) || now_ns - since_ns > LINGER_NS {
                recorder.missed_by_reader(receiver.lost());
                return Ok(());
            }
        }
        if abort.load(Ordering::Relaxed) {
            return Ok(());
        }
        receiver.wait(LOOK_EVERY)?;
    }
}

fn take(tracks: &[SystemTrack], recorder: &mut Recorder, clock: &impl Clock) {
    let received_ns = clock.now_ns();
    for track in tracks {
        recorder.record(track, received_ns);
    }
}

/// Returns the due time of the next batch, and whether the batch belongs to the flood. The flood ends with the
/// load.
fn next_due(load: &Load<'_>, driven: &SendProgress) -> Option<(i64, bool)> {
    let own_ns = (driven.batches < load.batches).then(|| load.pace.due_ns(driven.batches))?;
    let flood_ns = load.flood.map(|(_, pace)| pace.due_ns(driven.flood_batches));
    Some(match flood_ns {
        Some(flood_ns) if flood_ns < own_ns => (flood_ns, true),
        _ => (own_ns, false),
    })
}

fn send(
    load: &Load<'_>,
    sender: &mut impl ReportSender,
    driven: &mut SendProgress,
    flood: bool,
    due_ns: i64,
    now_ns: i64,
) -> anyhow::Result<()> {
    let traffic = load.traffic;
    let (source, batch, counted_from_ns) = match load.flood {
        // A zero intended time marks the states of the flood.
        Some((source, _)) if flood => (source, driven.flood_batches * traffic.sources(), 0),
        _ => (traffic.source(driven.batches), driven.batches, due_ns),
    };
    let mark = SendTime {
        now_ns,
        progress_ns: traffic.utc_ns(due_ns),
    };
    sender.send(source, mark, traffic.batch(), |index| {
        let mut report = traffic.report(source, batch, index, due_ns);
        report.stages = stamps(counted_from_ns, now_ns);
        report
    })?;
    if flood {
        driven.flood_batches += 1;
    } else {
        driven.batches += 1;
        (driven.last_sent_ns, driven.last_late_ns) = (now_ns, now_ns - due_ns);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::collections::VecDeque;

    use messages::TrackState;

    use super::*;

    /// Fake clock: each reading takes 50 ns.
    struct FakeClock(Cell<i64>);

    impl Clock for FakeClock {
        fn now_ns(&self) -> i64 {
            self.0.set(self.0.get() + 50);
            self.0.get()
        }

        fn sleep(&self, nanoseconds: i64) {
            self.0.set(self.0.get() + nanoseconds);
        }
    }

    /// Server that takes 2 µs per report and stalls from 10 to 15 ms.
    struct Server<'a> {
        clock: &'a FakeClock,
        free_ns: Cell<i64>,
        queue: std::cell::RefCell<VecDeque<(i64, SystemTrack)>>,
    }

    const STALL_NS: std::ops::Range<i64> = 10_000_000..15_000_000;

    impl ReportSender for &Server<'_> {
        fn send(
            &mut self,
            source: u16,
            mark: SendTime,
            count: usize,
            mut fill: impl FnMut(usize) -> SensorTrack,
        ) -> anyhow::Result<()> {
            for index in 0..count {
                let mut done_ns = self.free_ns.get().max(mark.now_ns) + 2_000;
                if STALL_NS.contains(&done_ns) {
                    done_ns = STALL_NS.end + 2_000;
                }
                self.free_ns.set(done_ns);
                let track = SystemTrack {
                    stages: fill(index).stages,
                    trigger_source: source,
                    state: TrackState::Confirmed as u8,
                    ..SystemTrack::default()
                };
                self.queue.borrow_mut().push_back((done_ns, track));
            }
            Ok(())
        }
    }

    impl StateReceiver for &Server<'_> {
        fn receive(&mut self, visit: impl FnOnce(&[SystemTrack])) -> anyhow::Result<bool> {
            let now_ns = self.clock.0.get();
            let mut queue = self.queue.borrow_mut();
            if queue.front().is_none_or(|(done_ns, _)| *done_ns > now_ns) {
                return Ok(false);
            }
            let (_, track) = queue.pop_front().unwrap();
            visit(&[track]);
            Ok(true)
        }

        fn lost(&self) -> u64 {
            0
        }

        fn wait(&mut self, _: Duration) -> anyhow::Result<()> {
            Ok(())
        }
    }

    fn driven(rests: bool, bench_stall: bool) -> Recorder {
        let clock = FakeClock(Cell::new(0));
        let server = Server {
            clock: &clock,
            free_ns: Cell::new(0),
            queue: Default::default(),
        };
        let traffic = Traffic::new(100, 2, 1, 0, 0);
        let pace = Pace::new(1_000, 20_000.0, false);
        let load = Load {
            traffic: &traffic,
            pace,
            batches: 1_000,
            rests,
            flood: None,
        };
        let mut recorder = Recorder::new(pace, load.batches, 1, true);
        if bench_stall {
            clock.0.set(STALL_NS.end);
        }
        let (mut sender, mut receiver) = (&server, &server);
        let abort = AtomicBool::new(false);
        let driven = spin(&load, &mut sender, &mut receiver, &mut recorder, &clock, &abort).unwrap();
        assert_eq!(driven.batches, 1_000);
        recorder
    }

    #[test]
    fn a_stall_is_seen_in_every_report_that_was_due_meanwhile() {
        for rests in [false, true] {
            let recorder = driven(rests, false);
            let latencies = recorder.end_to_end();
            assert_eq!(
                (latencies.len(), recorder.unanswered(1_000), recorder.beyond_one()),
                (1_000, 0, 0)
            );
            // Due every 50 µs, 100 reports fall into the 5 ms, and wait 2.5 ms on average.
            let late = latencies.count_between(100_000, u64::MAX);
            assert!((95..=105).contains(&late), "{late}");
            assert!(latencies.max() > 4_900_000, "{}", latencies.max());
            assert!(latencies.value_at_quantile(0.5) < 3_000);
        }
    }

    #[test]
    fn a_stall_of_the_bench_itself_is_counted_too() {
        let recorder = driven(false, true);
        // 300 reports were due at the start; the first had waited for 15 ms.
        let late = recorder.end_to_end().count_between(100_000, u64::MAX);
        assert!(late >= 290, "{late}");
        assert!(recorder.end_to_end().max() >= 14_900_000);
    }
}
