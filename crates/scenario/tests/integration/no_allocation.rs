//! A sensor in its steady state does not allocate.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use scenario::{ScenarioSettings, SensorSettings, SimulatedSensor, Truth};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn scanning_does_not_allocate() {
    let truth = Truth::new(&ScenarioSettings::default(), 1).expect("valid");
    for (source, (_, settings)) in SensorSettings::demonstration().into_iter().enumerate() {
        let mut sensor = SimulatedSensor::new(&settings, 1, source as u16, 0).expect("valid");
        let mut reports = Vec::with_capacity(1000);
        sensor.scan(&truth, &mut reports);
        let mut total = 0;
        assert_no_alloc(|| {
            for _ in 0..500 {
                reports.clear();
                sensor.scan(&truth, &mut reports);
                total += reports.len();
            }
        });
        assert!(total > 1000);
    }
}
