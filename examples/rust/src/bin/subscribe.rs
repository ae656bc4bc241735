//! Minimal subscriber of system tracks: the code required in another program to read Koseki's track picture.
//!
//! ```text
//! koseki demo                                       # in one terminal
//! cd examples/rust; cargo run --bin subscribe demo  # in another
//! ```
//!
//! A reader can start and stop at any time, and can read slowly: it never delays other processes. A slow reader is
//! informed of the number of lost samples.

use std::time::Duration;

use koseki_client::messages::{NS_PER_S, SystemTrack, TrackKind, TrackState};
use koseki_client::{Error, ErrorKind, Subscription};

fn main() -> Result<(), Error> {
    // Deployment: the name given to `koseki up --instance`, or the name in the configuration.
    let instance = std::env::args().nth(1).unwrap_or_else(|| "demo".to_owned());
    let mut tracks = Subscription::open(&instance)?;
    loop {
        // The slice refers to the samples in place, as written by fusion. Copy samples that are needed longer than
        // the slice.
        let slice = match tracks.next(Duration::from_secs(1)) {
            Ok(Some(slice)) => slice,
            Ok(None) => continue,
            Err(error) if error.kind() == ErrorKind::Ended => return Ok(()),
            Err(error) => return Err(error),
        };
        if slice.lost() > 0 {
            eprintln!("too slow: {} updates lost", slice.lost());
        }
        slice.iter().for_each(show);
    }
}

/// Prints a line per update: time, number, state, identity, position, velocity, and sources.
fn show(track: &SystemTrack) {
    let seconds = track.reference_time_ns as f64 / NS_PER_S;
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
