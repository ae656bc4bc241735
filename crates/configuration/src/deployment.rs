//! The parts of a deployment that every process needs.

use bus::BusError;
use runtime::Deployment;
use runtime::ground::Visit;

use super::Config;

impl Deployment for Config {
    fn fusion_core(&self) -> Option<usize> {
        self.fusion.placement.core
    }

    fn first_day_ns(&self) -> Option<i64> {
        self.first_day_ns
    }

    fn each_input_topic(&self, publishers: usize, visit: &mut impl Visit) -> Result<(), BusError> {
        for source in &self.sources {
            visit.visit(&messages::sensor_tracks(&source.name), publishers)?;
            if source.tracker.is_some() {
                visit.visit(&messages::sensor_detections(&source.name), publishers)?;
            }
            if source.tracker.as_ref().is_some_and(|tracker| tracker.cues) {
                visit.visit(&messages::cues(&source.name), publishers)?;
            }
            if source.locator.is_some() {
                visit.visit(&messages::sensor_bearings(&source.name), publishers)?;
                visit.visit(&messages::platform_states(&source.name), publishers)?;
            }
        }
        for sensor in &self.wide_area_sensors {
            visit.visit(&messages::wide_area(&sensor.name), publishers)?;
        }
        Ok(())
    }
}
