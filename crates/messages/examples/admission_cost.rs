//! Time of the checks of an external publisher, per report: `cargo run --profile dist -p koseki-messages --example
//! admission_cost`.

use std::hint::black_box;
use std::time::Instant;

use messages::admission::{CLOCK_LIMIT_NS, fault};
use messages::{Covariance, SensorDetection, SensorTrack, sensor_detection_bits};

const ROUNDS: u32 = 2_000_000;

fn main() {
    let mut track = SensorTrack {
        covariance: Covariance::diagonal([30.0; 3], [3.0; 3]),
        ..SensorTrack::default()
    };
    show("track, diagonal covariance", &track);
    track.covariance.set(0, 3, 45.0);
    show("track, full covariance", &track);
    let detection = SensorDetection {
        valid: sensor_detection_bits::SIGMAS,
        sigmas: [5.0; 4],
        ..SensorDetection::default()
    };
    show("detection", &detection);
}

fn show<T: messages::admission::Admission>(what: &str, sample: &T) {
    let begun = Instant::now();
    let faults = (0..ROUNDS).filter(|_| fault(black_box(sample), 0, Some(CLOCK_LIMIT_NS)).is_some());
    assert_eq!(faults.count(), 0);
    println!(
        "{what}: {:.1} ns",
        begun.elapsed().as_secs_f64() / f64::from(ROUNDS) * 1e9
    );
}
