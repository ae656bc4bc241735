//! Keys of sensors on a platform.

use ::settings::{Seconds, SettingsError};

use crate::mount::Mount;
use crate::settings::Assumed;

::settings::settings! {
    /// Platform that carries sensors, for `koseki track --platform`: assumptions on its states, and the sensors on it.
    pub struct OfflinePlatform with assumed: Assumed {
        check OfflinePlatform::check;
        /// Time by which a sensor's data may run ahead of the platform's states, while a detection waits for a state.
        wait_s: Seconds = Seconds::of(2.0), in [0, 60];
        /// Sensor with a mounting of its own. Other sensors are at the platform's position, with bearings from the
        /// nose.
        sensors as "sensor": Vec<OnBoardSensor> = Vec::new();
    }

    /// Sensor on a platform.
    #[derive(Copy)]
    pub struct OnBoardSensor with mount: Mount {
        /// Number of the sensor in detections.
        id: u32;
        /// Whether the platform carries the sensor. The detections of other sensors are used as they are.
        on_board: bool = true;
    }
}

impl OfflinePlatform {
    /// No two sensors share a number.
    fn check(&self) -> Result<(), SettingsError> {
        let mut sensors = self.sensors.iter().enumerate();
        sensors
            .find(|(place, sensor)| self.sensors[..*place].iter().any(|earlier| earlier.id == sensor.id))
            .map_or(Ok(()), |(place, sensor)| {
                let what = format!("{} is the id of an earlier sensor; move its keys there", sensor.id);
                Err(SettingsError::new(format!("sensor[{place}].id"), what))
            })
    }

    /// The mounting of a sensor; `None` if the platform does not carry the sensor.
    pub fn mount(&self, sensor_id: u32) -> Option<Mount> {
        match self.sensors.iter().find(|sensor| sensor.id == sensor_id) {
            Some(sensor) => sensor.on_board.then_some(sensor.mount),
            None => Some(Mount::default()),
        }
    }
}
