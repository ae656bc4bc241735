//! A report of a track of a sensor that tracks by itself.

use frames::SystemFrame;
use messages::admission::Fault;
use messages::{Covariance, Identity, SensorTrack, TrackState, sensor_track_bits};

use super::place::{Place, Placed};
use super::{Observation, angle, fault, missing, observation, sigma, sigma_or_unknown};

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
            /// Standard deviation of the height, metres; that of the position if not stated. 0: the height is unknown.
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
            /// Standard deviation of the velocity along each axis, metres per second. 0: the velocity is unknown.
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

/// Velocity in the system frame, and which parts of it are stated.
struct StatedVelocity {
    velocity_mps: [f64; 3],
    has_plane: bool,
    has_climb: bool,
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

    /// Velocity in the system frame; `None` if nothing of it is stated.
    fn velocity(&self, placed: Placed, frame: &SystemFrame) -> Result<Option<StatedVelocity>, Fault> {
        let components = [self.velocity_east_mps, self.velocity_north_mps, self.velocity_up_mps];
        let [east, north, up] = components;
        let course = angle("course_deg", self.course_deg)?;
        let polar = [self.speed_mps, course, self.climb_mps];
        let both = "give velocity_east_mps and velocity_north_mps together";
        let together = "give speed_mps and course_deg together";
        match (components, polar) {
            ([None, None, None], [None, None, None]) => Ok(None),
            ([None, None, up @ Some(_)], [None, None, None]) | ([None, None, None], [None, None, up @ Some(_)]) => {
                Ok(Some(StatedVelocity {
                    velocity_mps: [0.0, 0.0, up.unwrap_or_default()],
                    has_plane: false,
                    has_climb: true,
                }))
            }
            ([None, None, None], [Some(speed), Some(course), climb]) => {
                let axes = frame.axes(placed.position_m);
                let parts = [speed * course.sin(), speed * course.cos(), climb.unwrap_or_default()];
                let along = |axis: usize| (0..3).map(|part| parts[part] * axes[part][axis]).sum();
                Ok(Some(StatedVelocity {
                    velocity_mps: [along(0), along(1), along(2)],
                    has_plane: true,
                    has_climb: climb.is_some(),
                }))
            }
            ([None, None, None], [None, ..]) => Err(missing("speed_mps", together)),
            ([None, None, None], _) => Err(missing("course_deg", together)),
            (_, [None, None, None]) => {
                let east = east.ok_or_else(|| missing("velocity_east_mps", both))?;
                let north = north.ok_or_else(|| missing("velocity_north_mps", both))?;
                Ok(Some(StatedVelocity {
                    velocity_mps: [east, north, up.unwrap_or_default()],
                    has_plane: true,
                    has_climb: up.is_some(),
                }))
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
        let height_sigma_m = sigma_or_unknown("height_sigma_m", self.height_sigma_m)?.unwrap_or(sigma_m);
        let velocity = self.velocity(placed, frame)?;
        let velocity_sigma = sigma_or_unknown("velocity_sigma_mps", self.velocity_sigma_mps)?;
        let has_height = placed.has_height && height_sigma_m > 0.0;
        let flag = |is_set: bool, bit: u16| if is_set { bit } else { 0 };
        let mut valid = bits::OWN_COVARIANCE | flag(has_height, bits::HEIGHT);
        // What has a variance of 0 is unknown.
        let (velocity_mps, velocity_sigmas) = match (velocity, velocity_sigma) {
            (None, _) | (Some(_), Some(0.0)) => ([0.0; 3], [0.0; 3]),
            (Some(_), None) => {
                let stated = "state the standard deviation of the velocity";
                return Err(missing("velocity_sigma_mps", stated));
            }
            (Some(stated), Some(sigma)) => {
                valid |= flag(stated.has_plane, bits::VELOCITY) | flag(stated.has_climb, bits::VERTICAL_RATE);
                let [plane, climb] =
                    [stated.has_plane, stated.has_climb].map(|is_stated| if is_stated { sigma } else { 0.0 });
                (stated.velocity_mps, [plane, plane, climb])
            }
        };
        let [east, north, up] = placed.position_m;
        let up_sigma_m = if has_height { height_sigma_m } else { 0.0 };
        Ok(SensorTrack {
            time_of_measurement_ns: self.time_ns.unwrap_or(now_ns),
            track_number,
            valid,
            identity: self.identity,
            position_m: [east, north, if has_height { up } else { 0.0 }],
            velocity_mps,
            covariance: Covariance::diagonal([sigma_m, sigma_m, up_sigma_m], velocity_sigmas),
            state: self.state.unwrap_or(TrackState::Confirmed) as u8,
            ..SensorTrack::default()
        })
    }
}
