//! External source: passes tracks of another program to fusion.
//!
//! The configuration declares it as external: a `[[source]]` with a name and `[source.external]`.
//!
//! ```text
//! koseki up examples/feed.toml                  # in one terminal
//! cd examples/rust; cargo run --bin feed own    # in another
//! ```

use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use koseki_client::messages::{Covariance, SensorTrack, TrackState, sensor_track_bits};
use koseki_client::{Error, ErrorKind, Publisher};

/// Time between two reports.
const PERIOD: Duration = Duration::from_millis(500);
/// Standard deviations east, north and up.
const POSITION_SIGMA_M: [f64; 3] = [30.0, 30.0, 50.0];
const VELOCITY_SIGMA_MPS: [f64; 3] = [3.0, 3.0, 5.0];

fn main() -> Result<(), Error> {
    let source = std::env::args().nth(1).unwrap_or_else(|| "own".to_owned());
    let mut publisher = Publisher::<SensorTrack>::open("feed", &source)?;
    let velocity_mps = [150.0, 0.0, 0.0];
    for step in 0.. {
        let flown_s = (PERIOD * step).as_secs_f64();
        let report = SensorTrack {
            time_of_measurement_ns: utc_ns(),
            track_number: 1,
            valid: sensor_track_bits::HEIGHT
                | sensor_track_bits::VELOCITY
                | sensor_track_bits::VERTICAL_RATE
                | sensor_track_bits::OWN_COVARIANCE,
            position_m: [velocity_mps[0] * flown_s - 20e3, 5e3, 3e3],
            velocity_mps,
            covariance: Covariance::diagonal(POSITION_SIGMA_M, VELOCITY_SIGMA_MPS),
            state: TrackState::Confirmed as u8,
            ..SensorTrack::default()
        };
        match publisher.publish(&[report]) {
            Err(error) if error.kind() == ErrorKind::Ended => break,
            published => published?,
        }
        thread::sleep(PERIOD);
    }
    Ok(())
}

fn utc_ns() -> i64 {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since_1970.as_nanos()).unwrap_or(i64::MAX)
}
