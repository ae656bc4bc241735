//! The smallest subscriber of system tracks: what another program needs to read Koseki's picture.
//!
//! ```text
//! koseki demo                                       # in one terminal
//! cd examples/rust; cargo run --bin subscribe demo  # in another
//! ```
//!
//! A reader can come and go at any time, and can be as slow as it likes: it never holds anybody up. What it misses by
//! being slow, it is told.

use std::time::Duration;

use koseki_client::messages::{NS_PER_S, SystemTrack, TrackKind, TrackState};
use koseki_client::{Error, ErrorKind, Subscription};

fn main() -> Result<(), Error> {
    // Which deployment: the name given to `koseki up --instance`, or that of its configuration.
    let instance = std::env::args().nth(1).unwrap_or_else(|| "demo".to_owned());
    let mut tracks = Subscription::open(&instance)?;
    loop {
        // Samples are read where fusion wrote them, as long as the slice is kept. Copy what is needed longer.
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

/// One line per update: time, number, state, who and what it is, where it is, how fast, and who sees it.
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
