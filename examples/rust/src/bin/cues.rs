//! Cues for a sensor: the minimal reader in the controller of a steerable sensor (WA-12).
//!
//! For a source with `[source.tracker] cues = true`, Koseki publishes after each scan the predicted position of
//! each confirmed track at the sensor's next look, and the size of the search region.
//!
//! ```text
//! koseki demo --set 'source[4].tracker.cues=true'           # in one terminal; the source called radar-south
//! cd examples/rust; cargo run --bin cues demo radar-south   # in another
//! ```

use std::time::Duration;

use koseki_client::messages::{self, Cue};
use koseki_client::{Error, ErrorKind, Root, Subscription};

fn main() -> Result<(), Error> {
    // Deployment (the name given to `koseki up --instance`, or the name in the configuration), and source.
    let mut arguments = std::env::args().skip(1);
    let instance = arguments.next().unwrap_or_else(|| "demo".to_owned());
    let source = arguments.next().unwrap_or_else(|| "radar-south".to_owned());

    // The topic exists if the source has `cues = true`.
    let mut cues = Subscription::at(&Root::new(&instance)?, &messages::cues(&source))?;
    loop {
        match cues.next(Duration::from_secs(1)) {
            // All cues of one scan arrive together. A controller would sort them by time and direction, and steer.
            Ok(Some(scan)) => scan.iter().for_each(show),
            Ok(None) => {}
            Err(error) if error.kind() == ErrorKind::Ended => return Ok(()),
            Err(error) => return Err(error),
        }
    }
}

/// Prints a line per cue: time, track, position, and the ellipse of the search.
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
