//! Detections of three moving targets, in degrees, to fused tracks: start `koseki up examples/detections.toml` first.

use std::thread;
use std::time::{Duration, Instant};

use koseki_client::messages::TrackState;
use koseki_client::{Detection, Error, Publisher, Subscription};

fn main() -> Result<(), Error> {
    let (mut source, mut tracks) = (Publisher::open("feed", "own")?, Subscription::open("feed")?);
    let begin = Instant::now();
    loop {
        let longitude = 2.10 + 5e-4 * begin.elapsed().as_secs_f64();
        source.send(&[41.40, 41.43, 41.46].map(|latitude| Detection::at(latitude, longitude).sigma_m(20.0)))?;
        thread::sleep(Duration::from_millis(500));
        while let Some(slice) = tracks.next(Duration::ZERO)? {
            for track in slice.iter().filter(|track| track.state == TrackState::Confirmed as u8) {
                println!("track {} at {:?}", track.track_number, track.position_m);
            }
        }
    }
}
