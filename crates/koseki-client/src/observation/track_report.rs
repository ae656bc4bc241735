//! A report of a track of a sensor that tracks by itself.

use frames::SystemFrame;
use messages::admission::Fault;
use messages::{Covariance, Identity, SensorTrack, TrackState, sensor_track_bits};

use super::place::{Place, Placed};
use super::{Observation, angle, fault, missing, observation, sigma};

observation! {
    /// A report of a track: position, and velocity as speed and course or by its components.
    ///
    /// ```
    /// use koseki_client::TrackReport;
    ///
    /// let report = TrackReport::of(7, 41.40, 2.10).sigma_m(30.0);
    /// let moving = report.speed_mps(120.0).course_deg(90.0).velocity_sigma_mps(3.0);
    /// ```
    pub struct TrackReport by track {
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
            /// Standard deviation of the height, metres, above 0; that of the position if not stated.
            height_sigma_m,
            /// Speed over ground, metres per second.
            speed_mps,
            /// Direction of the motion, degrees clockwise from true north at the target, from -360 to 360.
            course_deg,
            /// Rate of climb, metres per second.
            climb_mps,
            /// Velocity in the system frame, metres per second east; in place of speed and course.
            velocity_east_mps,
            /// Velocity in the system frame, metres per second north.
            velocity_north_mps,
            /// Velocity in the system frame, metres per second up.
            velocity_up_mps,
            /// Standard deviation of the velocity along each axis, metres per second, above 0.
            velocity_sigma_mps,
        }
        /// Time of measurement, UTC, nanoseconds since 1970; `None`: now.
        time_ns: Option<i64>,
        /// Number of the track at its sensor; needed.
        track: Option<u32>,
        /// State of the track; `None`: confirmed.
        state: Option<TrackState>,
        /// Identity of the target.
        identity: Identity,
    }
}

impl TrackReport {
    /// A report of the track `track` at a latitude and a longitude (WGS-84, degrees).
    pub fn of(track: u32, latitude: f64, longitude: f64) -> Self {
        let report = Self {
            track: Some(track),
            ..Self::default()
        };
        report.latitude(latitude).longitude(longitude)
    }

    /// Velocity in the system frame, and whether its vertical part is known.
    fn velocity(&self, placed: Placed, frame: &SystemFrame) -> Result<Option<([f64; 3], bool)>, Fault> {
        let components = [self.velocity_east_mps, self.velocity_north_mps, self.velocity_up_mps];
        let [east, north, up] = components;
        let course = angle("course_deg", self.course_deg)?;
        let polar = [self.speed_mps, course, self.climb_mps];
        let both = "give velocity_east_mps and velocity_north_mps together";
        let together = "give speed_mps and course_deg together";
        match (components, polar) {
            ([None, None, None], [None, None, None]) => Ok(None),
            ([None, None, None], [Some(speed), Some(course), climb]) => {
                let axes = frame.axes(placed.position_m);
                let parts = [speed * course.sin(), speed * course.cos(), climb.unwrap_or_default()];
                let along = |axis: usize| (0..3).map(|part| parts[part] * axes[part][axis]).sum();
                Ok(Some(([along(0), along(1), along(2)], climb.is_some())))
            }
            ([None, None, None], [None, ..]) => Err(missing("speed_mps", together)),
            ([None, None, None], _) => Err(missing("course_deg", together)),
            (_, [None, None, None]) => {
                let east = east.ok_or_else(|| missing("velocity_east_mps", both))?;
                let north = north.ok_or_else(|| missing("velocity_north_mps", both))?;
                Ok(Some(([east, north, up.unwrap_or_default()], up.is_some())))
            }
            _ => Err(fault(
                "velocity_east_mps",
                "present",
                "must not stand beside speed_mps, course_deg and climb_mps",
                "leave one of the two forms out",
            )),
        }
    }
}

impl Observation for TrackReport {
    type Sample = SensorTrack;

    fn sample(&self, frame: &SystemFrame, now_ns: i64) -> Result<SensorTrack, Fault> {
        use sensor_track_bits as bits;
        let numbering = "number the sensor's tracks; detections have no number";
        let track_number = self.track.ok_or_else(|| missing("track", numbering))?;
        let place = Place {
            prefix: "",
            degrees: [self.latitude, self.longitude, self.height_m],
            metres: [self.east_m, self.north_m, self.up_m],
        };
        let placed = place.placed(frame)?;
        let placed =
            placed.ok_or_else(|| missing("latitude", "give latitude and longitude, or a position in metres"))?;
        let stated = "state the standard deviation of the position";
        let sigma_m = sigma("sigma_m", self.sigma_m)?.ok_or_else(|| missing("sigma_m", stated))?;
        let height_sigma_m = sigma("height_sigma_m", self.height_sigma_m)?.unwrap_or(sigma_m);
        let velocity = self.velocity(placed, frame)?;
        let velocity_sigma = sigma("velocity_sigma_mps", self.velocity_sigma_mps)?;
        let mut valid = bits::OWN_COVARIANCE;
        valid |= if placed.has_height { bits::HEIGHT } else { 0 };
        let (velocity_mps, velocity_sigmas) = match (velocity, velocity_sigma) {
            (None, _) => ([0.0; 3], [0.0; 3]),
            (Some(_), None) => {
                let stated = "state the standard deviation of the velocity";
                return Err(missing("velocity_sigma_mps", stated));
            }
            (Some((velocity_mps, has_climb)), Some(sigma)) => {
                valid |= bits::VELOCITY | if has_climb { bits::VERTICAL_RATE } else { 0 };
                (velocity_mps, [sigma, sigma, if has_climb { sigma } else { 0.0 }])
            }
        };
        let [east, north, up] = placed.position_m;
        let up_sigma_m = if placed.has_height { height_sigma_m } else { 0.0 };
        Ok(SensorTrack {
            time_of_measurement_ns: self.time_ns.unwrap_or(now_ns),
            track_number,
            valid,
            identity: self.identity,
            position_m: [east, north, if placed.has_height { up } else { 0.0 }],
            velocity_mps,
            covariance: Covariance::diagonal([sigma_m, sigma_m, up_sigma_m], velocity_sigmas),
            state: self.state.unwrap_or(TrackState::Confirmed) as u8,
            ..SensorTrack::default()
        })
    }
}
