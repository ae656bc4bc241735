//! Where a sensor should look next: what the controller of a steerable sensor needs to read from Koseki (WA-12).
//!
//! A source with `[source.tracker] cues = true` says after each scan where its sensor will find each confirmed track at
//! the next look, and how far around it has to search.
//!
//! ```text
//! koseki demo --set 'source[4].tracker.cues=true'   # in one terminal; the source called radar-south
//! cargo run --example cues -- demo radar-south      # in another
//! ```

use std::time::Duration;

use bus::{Bus, Root, SharedMemory, WaitMode};
use messages::{Cue, Health, LifeState, ProcessKind};
use runtime::clock::mono_ns;
use runtime::signals::Stop;

fn main() -> anyhow::Result<()> {
    // Which deployment (`koseki up --instance`, or the name in its configuration), and which of its sources.
    let mut arguments = std::env::args().skip(1);
    let instance = arguments.next().unwrap_or_else(|| "demo".to_owned());
    let source = arguments.next().unwrap_or_else(|| "radar-south".to_owned());
    let stop = Stop::on_signals()?;

    // Join it. The topic is there if the source has `cues = true`.
    let bus = Bus::<SharedMemory>::open(&Root::new(&instance)?, "cues")?;
    let topic = messages::cues(&source);
    let mut subscriber = bus.subscriber(&topic, || mono_ns() as u64)?;
    let mut health = bus.subscriber(&messages::health(), || mono_ns() as u64)?;
    let mut waiter = bus.waiter(WaitMode::Event);
    waiter.watch(&bus, &topic)?;

    let mut ended = false;
    while !ended && !stop.requested() {
        waiter.wait(Duration::from_millis(200), || subscriber.has_slices())?;
        // All cues of one scan come together. A controller would sort them by time and direction, and steer.
        subscriber.take(64, |_, cues| cues.iter().for_each(show))?;
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

/// One line per cue: when to look, for which track, where, and in what ellipse around it.
fn show(cue: &Cue) {
    let seconds = cue.time_ns as f64 / messages::NS_PER_S;
    let ([x, y, z], [vx, vy, _]) = (cue.position_m, cue.velocity_mps);
    let [longer, shorter] = cue.half_axes_m;
    println!(
        "{seconds:.3} look for track {} at {x:.0} {y:.0} {z:.0} m, {:.0} m/s, within {longer:.0} by {shorter:.0} m, the longer \
         axis at {:.0} degrees",
        cue.track_number,
        vx.hypot(vy),
        cue.orientation_rad.to_degrees()
    );
}
