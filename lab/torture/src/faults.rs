//! How each fault is caused.

use std::sync::atomic::Ordering::Relaxed;

use bus::Mark;
use messages::{Covariance, Order, OrderKind, SensorTrack, TrackState};
use rand::{Rng as _, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use runtime::clock::{Now, mono_ns};
use runtime::instance::CHECKPOINT;
use rustix::process::Signal;

use super::deployment::Deployment;
use super::judge::event::Part;
use super::own_file_systems;
use super::schedule::Act;

/// Inherent effects of a fault.
pub(super) fn takes(act: &Act, deployment: &Deployment) -> Vec<Part> {
    let of = |names: &[&String]| names.iter().filter_map(|name| deployment.part(name)).collect();
    match act {
        Act::Kill { name } | Act::KillWhileStarting { name, .. } | Act::Stop { name, .. } => of(&[name]),
        Act::KillTwo { one, other } => of(&[one, other]),
        Act::FloodOfOrders | Act::HostileReports { .. } | Act::WildClock { .. } | Act::FullDisk { .. } => Vec::new(),
        Act::DamagedCheckpoint { .. } => vec![Part::Fusion, Part::Numbers],
        // Every process that writes without room is killed, perhaps all; any data may have to be read anew.
        Act::KillLauncher | Act::FullSharedMemory { .. } | Act::CorruptMemory { .. } => vec![Part::Memory],
    }
}

/// Causes a fault.
///
/// # Errors
/// If the fault cannot be caused.
pub(super) fn cause(act: &Act, deployment: &mut Deployment) -> anyhow::Result<()> {
    match act {
        Act::Kill { name } => {
            deployment.signal(name, Signal::KILL)?;
        }
        Act::KillWhileStarting { name, after } => {
            let dead = deployment.signal(name, Signal::KILL)?;
            let next = deployment.until_started(name, dead)?;
            deployment.watch(*after)?;
            deployment.signal_process(next, Signal::KILL);
        }
        Act::KillTwo { one, other } => {
            deployment.signal(one, Signal::KILL)?;
            if one != other {
                deployment.signal(other, Signal::KILL)?;
            }
        }
        Act::KillLauncher => deployment.restart()?,
        Act::Stop { name, time } => {
            let pid = deployment.signal(name, Signal::STOP)?;
            deployment.watch(*time)?;
            // A standby that took over has killed the process, unless the take-over was too late.
            deployment.signal_process(pid, Signal::CONT);
        }
        Act::FloodOfOrders => flood(deployment)?,
        Act::HostileReports { source, seed } => hostile_reports(deployment, source, *seed)?,
        Act::DamagedCheckpoint { seed } => damage_checkpoint(deployment, *seed)?,
        Act::FullDisk { time } => {
            let out = deployment.out();
            own_file_systems::fill(&out)?;
            deployment.watch(*time)?;
            own_file_systems::make_room(&out)?;
        }
        Act::FullSharedMemory { time } => deployment.full_memory(*time)?,
        Act::WildClock { source, off_s, seed } => wild_clock(deployment, source, *off_s, *seed)?,
        Act::CorruptMemory { seed } => deployment.corrupt(&mut ChaCha8Rng::seed_from_u64(*seed))?,
    }
    Ok(())
}

fn flood(deployment: &mut Deployment) -> anyhow::Result<()> {
    let (_bus, mut publisher) = deployment.publisher(&messages::orders())?;
    for number in 0..2000 {
        let order = Order::new(OrderKind::Condition).with_name(&format!("none-{number}"));
        let order = Order {
            token: number + 1,
            sent_ns: runtime::Now::read().utc_ns,
            ..order.unwrap_or_default()
        };
        publisher.send(mark(), 1, |_, _| order)?;
    }
    Ok(())
}

fn hostile_reports(deployment: &mut Deployment, source: &str, seed: u64) -> anyhow::Result<()> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (_bus, mut publisher) = deployment.publisher(&messages::sensor_tracks(source))?;
    for _ in 0..200 {
        let word = random.next_u64();
        let wild = f64::from_bits(word);
        let report = SensorTrack {
            time_of_measurement_ns: word.cast_signed(),
            track_number: word as u32,
            state: word as u8,
            position_m: [wild, -wild, f64::NAN],
            covariance: Covariance::diagonal([wild; 3], [-1.0; 3]),
            ..SensorTrack::default()
        };
        publisher.send(mark(), 1, |_, _| report)?;
    }
    Ok(())
}

fn wild_clock(deployment: &mut Deployment, source: &str, off_s: f64, seed: u64) -> anyhow::Result<()> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (_bus, mut publisher) = deployment.publisher(&messages::sensor_tracks(source))?;
    for number in 0..200 {
        let report = SensorTrack {
            time_of_measurement_ns: Now::read().utc_ns + (off_s * random.random_range(0.5..2.0) * 1e9) as i64,
            track_number: 60_000 + number,
            state: TrackState::Confirmed as u8,
            position_m: [0; 3].map(|_| random.random_range(-30_000.0..30_000.0)),
            covariance: Covariance::diagonal([50.0; 3], [5.0; 3]),
            ..SensorTrack::default()
        };
        publisher.send(mark(), 1, |_, _| report)?;
    }
    Ok(())
}

fn damage_checkpoint(deployment: &mut Deployment, seed: u64) -> anyhow::Result<()> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    if let Some(memory) = deployment.root().outlasting(CHECKPOINT)? {
        for _ in 0..1000 {
            let place = random.random_range(0..memory.words().len());
            memory.words()[place].store(random.random(), Relaxed);
        }
    }
    deployment.signal("fusion", Signal::KILL)?;
    Ok(())
}

fn mark() -> Mark {
    Mark {
        progress_ns: i64::MIN,
        sent_ns: mono_ns(),
        end: false,
    }
}
