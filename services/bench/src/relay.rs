//! The floor: a process that only passes the payload on.
//!
//! The relay takes slices of sensor tracks and sends slices of as many system tracks. Shared memory, hops, sizes,
//! core, priority and way of waiting are the same as for fusion, but there is no engine, header, counter or health
//! message. Any additional time of the pipeline is Koseki's own.

use std::hint::spin_loop;
use std::time::Duration;

use anyhow::Context as _;
use bus::{BareReceiver, BareSender, Bus, Root, SharedMemory, WaitMode};
use messages::{SensorTrack, SystemTrack, TrackState};
use runtime::clock::mono_ns;
use runtime::cores::{self, Placement};
use runtime::signals::{self, Stop};

use crate::link::{RELAY_IN, RELAY_OUT, relay_settings};

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
    /// Rest while spinning at a real-time priority: time without work before a sleep, and length of the sleep,
    /// nanoseconds. Without rests, the kernel takes the core away at a time of its own choice.
    pub rest_ns: Option<(i64, i64)>,
}

/// Number of polls without work per clock reading.
const CLOCK_EVERY: u32 = 16;

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
    let settings = relay_settings(options.slice_len, options.wait != WaitMode::Spin);
    let receiver = BareReceiver::<SensorTrack>::open(&bus, RELAY_IN, settings)?;
    let sender = BareSender::<SystemTrack>::open(&bus, RELAY_OUT, settings)?;
    // The same refusals apply to fusion, which reports them.
    let _ = cores::take_place(options.placement);

    let blank = SystemTrack {
        state: TrackState::Confirmed as u8,
        ..SystemTrack::default()
    };
    let spin_ns = match options.wait {
        WaitMode::Spin => i64::MAX,
        WaitMode::Event => 0,
        WaitMode::Hybrid { spin_ns } => spin_ns as i64,
    };
    let mut idle_since_ns = None;
    let (mut looks, mut rested) = (0u32, false);
    while !stop.requested() {
        let mut sent = Ok(());
        let took = receiver.receive(|reports| {
            sent = sender.send(reports.len(), |index| SystemTrack {
                stages: reports[index].stages,
                trigger_source: reports[index].source,
                ..blank
            });
        })?;
        sent?;
        if took {
            idle_since_ns = None;
            rested = false;
        } else if spin_ns == i64::MAX {
            spin_loop();
            looks = looks.wrapping_add(1);
            if let Some((idle_ns, sleep_ns)) = options.rest_ns
                && !rested
                && looks.is_multiple_of(CLOCK_EVERY)
                && mono_ns() - *idle_since_ns.get_or_insert_with(mono_ns) >= idle_ns
            {
                std::thread::sleep(Duration::from_nanos(sleep_ns as u64));
                rested = true;
            }
        } else if mono_ns() - *idle_since_ns.get_or_insert_with(mono_ns) >= spin_ns {
            receiver.wait(LOOK_EVERY)?;
            idle_since_ns = None;
        }
    }
    Ok(())
}
