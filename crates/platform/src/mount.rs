//! How a sensor is mounted on a platform.

use ::settings::Degrees;

::settings::settings! {
    /// Mounting of a sensor on its platform.
    #[derive(Copy)]
    pub struct Mount {
        /// Place of the sensor on the platform, seen from the point of the platform's position: forward, right, up,
        /// metres.
        lever_arm_m: [f64; 3] = [0.0; 3], in [-1e3, 1e3];
        /// Angles of the sensor against the platform's axes: yaw clockwise from the bow, pitch up, roll right side
        /// down.
        mounting_deg: [Degrees; 3] = [Degrees::of(0.0); 3], in [-360, 360];
        /// Zero of the sensor's bearings.
        bearings: Bearings = Bearings::Nose;
        /// Standard deviation of the elevation of targets, about the horizontal, for sensors that measure none. On
        /// a tilted deck the elevation changes the bearing.
        elevation_sigma_deg: Degrees = Degrees::of(0.5), in [0, 45];
    }
}

::settings::words! {
    /// Zero of a sensor's bearings on a platform.
    pub enum Bearings {
        /// The platform's nose; the sensor moves with the deck.
        Nose = "nose",
        /// North, by the platform's compass; the sensor is stabilised against pitch and roll.
        North = "north",
    }
}

impl Mount {
    /// The lever arm along right, forward, up, metres.
    pub(crate) fn arm(&self) -> [f64; 3] {
        let [forward, right, up] = self.lever_arm_m;
        [right, forward, up]
    }
}
