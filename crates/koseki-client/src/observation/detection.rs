//! A detection: a position, or directions and ranges from a sensor's place.

use frames::SystemFrame;
use messages::admission::Fault;
use messages::{DetectionKind, Identity, SensorDetection, sensor_detection_bits};

use super::place::{Place, Placed};
use super::{Observation, Scans, angle, missing, observation, sigma, sigma_or_unknown};

observation! {
    /// A detection of a sensor: a position, or a bearing with what else was measured from the sensor's place.
    ///
    /// ```
    /// use koseki_client::Detection;
    ///
    /// let seen = Detection::at(41.40, 2.10).height_m(900.0).sigma_m(20.0);
    /// let heard = Detection::from_sensor(41.30, 2.08).bearing_deg(37.0).bearing_sigma_deg(0.5);
    /// ```
    pub struct Detection by scan {
        numbers {
            /// Latitude of the target, WGS-84, degrees, from -90 to 90, north positive.
            latitude,
            /// Longitude of the target, WGS-84, degrees, from -180 to 180, east positive.
            longitude,
            /// Height of the target above the ellipsoid, metres, from -1e5 to 1e5.
            height_m,
            /// Place of the target in the system frame, metres east; in place of latitude and longitude.
            east_m,
            /// Place of the target in the system frame, metres north.
            north_m,
            /// Place of the target in the system frame, metres up.
            up_m,
            /// Standard deviation of the position along each horizontal axis, metres, above 0.
            sigma_m,
            /// Standard deviation of the height, metres; that of the position if not stated. 0: the height is unknown.
            height_sigma_m,
            /// Slant range from the sensor, metres.
            range_m,
            /// Direction from the sensor, degrees clockwise, from -360 to 360: from true north at a sensor in latitude
            /// and longitude, from the system frame's north at a sensor in metres.
            bearing_deg,
            /// Direction above the horizontal of the same place, degrees.
            elevation_deg,
            /// Standard deviation of the range, metres, above 0.
            range_sigma_m,
            /// Standard deviation of the bearing, degrees, above 0.
            bearing_sigma_deg,
            /// Standard deviation of the elevation, degrees, above 0.
            elevation_sigma_deg,
            /// Latitude of the sensor, degrees.
            sensor_latitude,
            /// Longitude of the sensor, degrees.
            sensor_longitude,
            /// Height of the sensor above the ellipsoid, metres.
            sensor_height_m,
            /// Place of the sensor in the system frame, metres east; in place of latitude and longitude.
            sensor_east_m,
            /// Place of the sensor in the system frame, metres north.
            sensor_north_m,
            /// Place of the sensor in the system frame, metres up.
            sensor_up_m,
            /// Rate of the range, metres per second, positive away from the sensor.
            range_rate_mps,
            /// Standard deviation of the rate, metres per second, above 0.
            range_rate_sigma_mps,
        }
        /// Time of measurement, UTC, nanoseconds since 1970; `None`: now.
        time_ns: Option<i64>,
        /// Number of the scan; `None`: detections with one time are one scan.
        scan: Option<u32>,
        /// Identity of the target.
        identity: Identity,
        /// Whether the configuration has standard deviations for detections that state none.
        has_configured_sigmas: bool,
    }
}

/// Kind, values and standard deviations, if stated.
type Measured = (DetectionKind, [f64; 3], Option<[f64; 3]>);

impl Detection {
    /// A detection at a latitude and a longitude (WGS-84, degrees).
    pub fn at(latitude: f64, longitude: f64) -> Self {
        Self::default().latitude(latitude).longitude(longitude)
    }

    /// A detection by directions and ranges from a sensor at a latitude and a longitude (WGS-84, degrees).
    pub fn from_sensor(latitude: f64, longitude: f64) -> Self {
        Self::default().sensor_latitude(latitude).sensor_longitude(longitude)
    }

    fn place(&self) -> Place {
        Place {
            prefix: "",
            degrees: [self.latitude, self.longitude, self.height_m],
            metres: [self.east_m, self.north_m, self.up_m],
        }
    }

    fn sensor(&self) -> Place {
        Place {
            prefix: "sensor_",
            degrees: [self.sensor_latitude, self.sensor_longitude, self.sensor_height_m],
            metres: [self.sensor_east_m, self.sensor_north_m, self.sensor_up_m],
        }
    }

    fn of_position(&self, placed: Placed) -> Result<Measured, Fault> {
        let sigma_m = sigma("sigma_m", self.sigma_m)?;
        let height_sigma_m = sigma_or_unknown("height_sigma_m", self.height_sigma_m)?;
        let [east, north, up] = placed.position_m;
        Ok(match placed.has_height && height_sigma_m != Some(0.0) {
            true => {
                let sigmas = sigma_m.map(|sigma_m| [sigma_m, sigma_m, height_sigma_m.unwrap_or(sigma_m)]);
                (DetectionKind::Position3, [east, north, up], sigmas)
            }
            false => {
                let sigmas = sigma_m.map(|sigma_m| [sigma_m, sigma_m, 0.0]);
                (DetectionKind::Position2, [east, north, 0.0], sigmas)
            }
        })
    }

    fn of_directions(&self, frame: &SystemFrame, sensor: Option<Placed>) -> Result<Measured, Fault> {
        let Some(bearing) = angle("bearing_deg", self.bearing_deg)? else {
            let remedy = "give latitude and longitude, a position in metres, or bearing_deg";
            return Err(missing("latitude", remedy));
        };
        let elevation = angle("elevation_deg", self.elevation_deg)?;
        let Some(sensor) = sensor else {
            return Err(missing(
                "sensor_latitude",
                "bearings need the sensor's place: sensor_latitude and sensor_longitude",
            ));
        };
        let [bearing, above] = sensor.direction(frame, [bearing, elevation.unwrap_or_default()]);
        let elevation = elevation.map(|_| above);
        let range_sigma = sigma("range_sigma_m", self.range_sigma_m)?;
        let bearing_sigma = angle("bearing_sigma_deg", sigma("bearing_sigma_deg", self.bearing_sigma_deg)?)?;
        let elevation_sigma = sigma("elevation_sigma_deg", self.elevation_sigma_deg)?;
        let elevation_sigma = angle("elevation_sigma_deg", elevation_sigma)?;
        let (kind, values, sigmas) = match (self.range_m, elevation) {
            (Some(range), Some(elevation)) => (
                DetectionKind::RangeBearingElevation,
                [range, bearing, elevation],
                [range_sigma, bearing_sigma, elevation_sigma],
            ),
            (Some(range), None) => (
                DetectionKind::RangeBearing,
                [range, bearing, 0.0],
                [range_sigma, bearing_sigma, None],
            ),
            (None, Some(elevation)) => (
                DetectionKind::BearingElevation,
                [bearing, elevation, 0.0],
                [bearing_sigma, elevation_sigma, None],
            ),
            (None, None) => (DetectionKind::Bearing, [bearing, 0.0, 0.0], [bearing_sigma, None, None]),
        };
        let measured = kind.quantities().len();
        if sigmas[..measured].iter().all(Option::is_none) {
            return Ok((kind, values, None));
        }
        let names = match self.range_m {
            Some(_) => ["range_sigma_m", "bearing_sigma_deg", "elevation_sigma_deg"],
            None => ["bearing_sigma_deg", "elevation_sigma_deg", ""],
        };
        let mut stated = [0.0; 3];
        for (place, sigma) in sigmas[..measured].iter().enumerate() {
            stated[place] = sigma.ok_or_else(|| missing(names[place], "give all standard deviations, or none"))?;
        }
        Ok((kind, values, Some(stated)))
    }

    /// Fills in the rate of the range.
    fn rate(&self, detection: &mut SensorDetection) -> Result<(), Fault> {
        use sensor_detection_bits as bits;
        let rate_sigma = sigma("range_rate_sigma_mps", self.range_rate_sigma_mps)?;
        let Some(rate_mps) = self.range_rate_mps else {
            return Ok(());
        };
        detection.valid |= bits::RANGE_RATE;
        detection.range_rate_mps = rate_mps;
        match (rate_sigma, detection.valid & bits::SIGMAS != 0) {
            (Some(sigma), true) => detection.sigmas[3] = sigma,
            (None, false) => {}
            _ => {
                return Err(missing("range_rate_sigma_mps", "give all standard deviations, or none"));
            }
        }
        Ok(())
    }
}

impl Observation for Detection {
    type Sample = SensorDetection;

    fn sample(&self, frame: &SystemFrame, now_ns: i64) -> Result<SensorDetection, Fault> {
        let place = self.place().placed(frame)?;
        let sensor = self.sensor().placed(frame)?;
        let (kind, values, sigmas) = match place {
            Some(placed) => self.of_position(placed)?,
            None => self.of_directions(frame, sensor)?,
        };
        let mut detection = SensorDetection {
            time_of_measurement_ns: self.time_ns.unwrap_or(now_ns),
            scan: self.scan.unwrap_or_default(),
            kind: kind as u8,
            values,
            platform_m: sensor.map_or([0.0; 3], |sensor| sensor.position_m),
            identity: self.identity,
            ..SensorDetection::default()
        };
        match sigmas {
            Some([first, second, third]) => {
                detection.valid |= sensor_detection_bits::SIGMAS;
                detection.sigmas = [first, second, third, 0.0];
            }
            None if self.has_configured_sigmas => {}
            None => {
                let name = if place.is_some() {
                    "sigma_m"
                } else {
                    "bearing_sigma_deg"
                };
                let remedy = "state the standard deviation of the sensor's error, with each detection or as `sigmas` in \
                              [source.external]";
                return Err(missing(name, remedy));
            }
        }
        self.rate(&mut detection)?;
        Ok(detection)
    }

    fn count(&self, sample: &mut SensorDetection, scans: &mut Scans) {
        scans.number(sample, self.scan.is_some());
    }
}
