//! The floor: a process that only passes the payload on.
//!
//! The relay takes slices of sensor tracks and sends slices of as many system tracks. Shared memory, hops, sizes,
//! core, priority and way of waiting are the same as for fusion, but there is no engine, header, counter or health
//! message. Any additional time of the pipeline is Koseki's own.

use std::hint::spin_loop;
use std::time::Duration;

use anyhow::Context as _;
use bus::{BareReceiver, BareSender, Bus, Mark, Root, SharedMemory, WaitMode};
use messages::{SensorTrack, SystemTrack, TrackState};
use runtime::clock::mono_ns;
use runtime::cores::{self, Placement};
use runtime::signals::{self, Stop};

use crate::link::{RELAY_IN, RELAY_OUT, relay_settings, source_name};

/// Maximum sleep between two checks for a stop request.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Options of a relay.
#[derive(Clone, Debug)]
pub struct RelayOptions {
    /// Instance of the relay.
    pub instance: String,
    /// The bench's process number; the relay ends with it.
    pub launcher: u32,
    /// Way of waiting.
    pub wait: WaitMode,
    /// Requested core, priority and memory lock.
    pub placement: Placement,
    /// Maximum number of samples in a slice.
    pub slice_len: usize,
    /// Number of sources, whose slices wait in one queue.
    pub sources: u16,
    /// Whether it takes the reports from fusion's topics and sends to fusion's topic, with sequence numbers, marks and
    /// counts, spinning.
    pub over_bus: bool,
    /// Rest while spinning at a real-time priority: time without work before a sleep, and length of the sleep,
    /// nanoseconds. Without rests, the kernel takes the core away at a time of its own choice.
    pub rest_ns: Option<(i64, i64)>,
}

/// Number of polls without work per clock reading.
const CLOCK_EVERY: u32 = 16;

/// Rests of a thread that spins at a real-time priority.
#[derive(Debug)]
pub(crate) struct IdleRest {
    rest_ns: Option<(i64, i64)>,
    idle_since_ns: Option<i64>,
    looks: u32,
    rested: bool,
}

impl IdleRest {
    pub(crate) fn new(rest_ns: Option<(i64, i64)>) -> Self {
        Self {
            rest_ns,
            idle_since_ns: None,
            looks: 0,
            rested: false,
        }
    }

    /// There was work.
    pub(crate) fn worked(&mut self) {
        (self.idle_since_ns, self.rested) = (None, false);
    }

    /// There was no work: spins on, or sleeps once.
    pub(crate) fn idle(&mut self) {
        spin_loop();
        self.looks = self.looks.wrapping_add(1);
        if let Some((idle_ns, sleep_ns)) = self.rest_ns
            && !self.rested
            && self.looks.is_multiple_of(CLOCK_EVERY)
            && mono_ns() - *self.idle_since_ns.get_or_insert_with(mono_ns) >= idle_ns
        {
            std::thread::sleep(Duration::from_nanos(sleep_ns as u64));
            self.rested = true;
        }
    }
}

/// The state that answers a report.
pub(crate) fn answer(report: &SensorTrack) -> SystemTrack {
    SystemTrack {
        stages: report.stages,
        trigger_source: report.source,
        state: TrackState::Confirmed as u8,
        ..SystemTrack::default()
    }
}

/// Relays slices until a stop is requested.
///
/// # Errors
/// If the instance does not run or shared memory fails.
pub fn run(options: &RelayOptions) -> anyhow::Result<()> {
    let stop = Stop::on_signals().context("catching signals")?;
    if !signals::stop_with_parent(options.launcher).context("following the bench")? {
        anyhow::bail!("the bench (process {}) is gone", options.launcher);
    }
    let bus = Bus::<SharedMemory>::open_for_few(&Root::new(&options.instance)?, "relay")?;
    if options.over_bus {
        return run_over_bus(&bus, options, &stop);
    }
    let settings = relay_settings(options.slice_len, options.wait != WaitMode::Spin, options.sources);
    let receiver = BareReceiver::<SensorTrack>::open(&bus, RELAY_IN, settings)?;
    let sender = BareSender::<SystemTrack>::open(&bus, RELAY_OUT, settings)?;
    // The same refusals apply to fusion, which reports them.
    let _ = cores::take_place(options.placement);

    let spin_ns = match options.wait {
        WaitMode::Spin => i64::MAX,
        WaitMode::Event => 0,
        WaitMode::Hybrid { spin_ns } => spin_ns as i64,
    };
    let mut idle_since_ns = None;
    let mut rest = IdleRest::new(options.rest_ns);
    while !stop.requested() {
        let mut sent = Ok(());
        let took = receiver.receive(|reports| {
            sent = sender.send(reports.len(), |index| answer(&reports[index]));
        })?;
        sent?;
        if took {
            idle_since_ns = None;
            rest.worked();
        } else if spin_ns == i64::MAX {
            rest.idle();
        } else if mono_ns() - *idle_since_ns.get_or_insert_with(mono_ns) >= spin_ns {
            receiver.wait(LOOK_EVERY)?;
            idle_since_ns = None;
        }
    }
    Ok(())
}

fn run_over_bus(bus: &Bus<SharedMemory>, options: &RelayOptions, stop: &Stop) -> anyhow::Result<()> {
    let incarnation = mono_ns() as u64;
    let mut publisher = bus.publisher(&messages::system_tracks(), incarnation)?;
    let open =
        |number| bus.subscriber::<SensorTrack>(&messages::sensor_tracks(&source_name(number)), || mono_ns() as u64);
    let mut subscribers: Vec<_> = (0..options.sources).map(open).collect::<Result<_, _>>()?;
    let _ = cores::take_place(options.placement);
    let mut rest = IdleRest::new(options.rest_ns);
    while !stop.requested() {
        let mut took = 0;
        for subscriber in &mut subscribers {
            let mut sent = Ok(());
            took += subscriber.take(1, |_, reports| {
                let mark = Mark {
                    progress_ns: i64::MIN,
                    sent_ns: mono_ns(),
                    end: false,
                };
                sent = publisher.send(mark, reports.len(), |index, sequence| SystemTrack {
                    sequence,
                    ..answer(&reports[index])
                });
            })?;
            sent?;
        }
        if took > 0 {
            rest.worked();
        } else {
            rest.idle();
        }
    }
    Ok(())
}
