//! Key that no other test sets, with a value that changes the outcome.

use locating::{Locator, Settings};
use observations::Bearing;
use settings::Degrees;

fn bearing(second: i64, bearing_rad: f64) -> Bearing {
    Bearing {
        time_of_measurement_ns: second * 1_000_000_000,
        emitter_id: None,
        bearing_rad,
        sigma_rad: 0.01,
        platform_m: [100.0 * second as f64, 0.0, 3e3],
        heading_rad: None,
        frequency_hz: None,
        pulse_interval_s: None,
    }
}

#[test]
fn a_bearing_may_change_as_fast_as_its_key_permits() {
    let emitters = |rate: f64| {
        let mut settings = Settings::default();
        settings.association.rate_max_deg_per_s = Degrees::of_rad(rate);
        let mut locator = Locator::new(settings).unwrap();
        for second in 0..2 {
            // 0.2 rad in a second, 14 standard deviations of the two bearings.
            locator.bearing(&bearing(second, 0.2 * second as f64)).unwrap();
        }
        locator.counts().emitters
    };
    assert_eq!((emitters(0.0), emitters(0.1)), (2, 1));
}
