//! The smallest subscriber of system tracks: what another program needs to read Koseki's picture.
//!
//! ```text
//! koseki demo                            # in one terminal
//! cargo run --example subscribe -- demo  # in another
//! ```
//!
//! A reader can come and go at any time, and can be as slow as it likes: it never holds anybody up. What it misses by
//! being slow, it can count.

use std::time::Duration;

use bus::{Bus, Root, SharedMemory, WaitMode};
use messages::{Health, LifeState, ProcessKind, SystemTrack, TrackKind, TrackState};
use runtime::clock::mono_ns;
use runtime::signals::Stop;

fn main() -> anyhow::Result<()> {
    // Which deployment: the name given to `koseki up --instance`, or that of its configuration.
    let instance = std::env::args().nth(1).unwrap_or_else(|| "demo".to_owned());
    let stop = Stop::on_signals()?;

    // Join it. The name is what `koseki status` shows.
    let bus = Bus::<SharedMemory>::open(&Root::new(&instance)?, "subscribe")?;
    let topic = messages::system_tracks();
    // The time of joining tells which samples of a restarted publisher must arrive.
    let mut subscriber = bus.subscriber(&topic, || mono_ns() as u64)?;
    let mut health = bus.subscriber(&messages::health(), || mono_ns() as u64)?;
    // Sleep until something comes. `WaitMode::Spin` has less latency, and takes a core.
    let mut waiter = bus.waiter(WaitMode::Event);
    waiter.watch(&bus, &topic)?;

    let (mut ended, mut lost) = (false, 0);
    while !ended && !stop.requested() {
        waiter.wait(Duration::from_millis(200), || subscriber.has_slices())?;
        // Samples are read where fusion wrote them. Copy what is needed longer than this call.
        subscriber.take(64, |_, tracks| tracks.iter().for_each(show))?;
        if subscriber.counts().lost > lost {
            lost = subscriber.counts().lost;
            eprintln!("too slow: {lost} updates lost so far");
        }
        // The shared memory can only be cleared when everybody has left it.
        health.take(64, |_, said| ended |= said.iter().any(is_end))?;
    }
    Ok(())
}

/// Whether this is the launcher's last word.
fn is_end(health: &Health) -> bool {
    let launcher = health.kind() == Some(ProcessKind::Launcher);
    launcher && health.name() == ProcessKind::Launcher.word() && health.life() == Some(LifeState::Finished)
}

/// One line per update: time, number, state, who and what it is, where it is, how fast, and who sees it.
fn show(track: &SystemTrack) {
    let seconds = track.reference_time_ns as f64 / messages::NS_PER_S;
    let state = TrackState::from_code(track.state).map_or("?", TrackState::word);
    let [x, y, z] = track.position_m;
    let [vx, vy, _] = track.velocity_mps;
    let sources: Vec<String> = track
        .contributions()
        .iter()
        .map(|part| format!("{}:{:.2}", part.source, part.weight))
        .collect();
    let group = match TrackKind::from_code(track.kind) {
        Some(TrackKind::Group) => format!(" group of {}", track.members),
        _ => String::new(),
    };
    let target_type = track
        .target_type
        .name()
        .map(|name| format!(" {name}"))
        .unwrap_or_default();
    println!(
        "{seconds:.3} track {} {state} {}{group}{target_type} at {x:.0} {y:.0} {z:.0} m, {:.0} m/s, sources {}",
        track.track_number,
        track.identity,
        vx.hypot(vy),
        sources.join(" ")
    );
}
