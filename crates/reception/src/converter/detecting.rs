//! Conversion of an observation to a detection, for sensors tracked in their adapter (PL-3).
//!
//! A tracker needs the measurement of this scan only: a position smoothed by the sensor's own filter contains earlier
//! errors, and a tracker would take these errors for new information. Of a report with plot and track, only the plot
//! is used; of a report with another kind of position, this position, if it is a plot's. A report without a detection
//! gives nothing. The values of the target's transponder (address, code, callsign, level) stay with the detection.
//!
//! A radar's plot remains range and bearing, in the system frame and from the radar's position, because the errors
//! have these axes. If the target sends its height, the measurement is slant range, bearing and elevation, and the
//! height error becomes an elevation error; otherwise it is the ground range, with the error of an assumed height
//! ([`crate::placing`]).

use std::f64::consts::{FRAC_PI_4, TAU};

use frames::PolarSigma;
use messages::{Counter, TrackState, level_of};

use super::{Converter, NS_PER_MS};
use crate::PositionForm;
use crate::accuracy::{self, Velocity};
use crate::placing::{Height, RefusedPlace, SystemPosition};
use observations::sensor_id;
use observations::{Detection, DetectionKind, DetectionPlatform, StatedHeight, TransponderReply};
use observations::{Observation, Position};

impl Converter {
    /// The detection that `observation` reports, without scan and number; `None` if it was refused.
    pub fn detect(&mut self, observation: &Observation) -> Option<Detection> {
        match self.try_detect(observation) {
            Ok(detection) => {
                self.count(Counter::Reports);
                Some(detection)
            }
            Err(reason) => {
                self.count(reason);
                None
            }
        }
    }

    fn try_detect(&mut self, observation: &Observation) -> Result<Detection, Counter> {
        let time_ns = self.pass(observation)?.believed()?;
        let height = self.reported_height(observation).map_or(Height::Unknown, Height::Known);
        let used = self.plot(observation).ok_or(Counter::RejectedNoPosition)?;
        if self.model.is_on_board {
            return self
                .as_measured(observation, used, time_ns, height)
                .inspect_err(|reason| {
                    if *reason == Counter::RejectedPosition {
                        self.refused_place = Some(RefusedPlace::of(&self.model, used));
                    }
                });
        }
        let placed = self.placed(used, height)?;
        let own = accuracy::own_position(&self.model, observation, used)?;
        if placed.slant.is_some_and(|slant| slant.is_assumed()) {
            self.count(Counter::HeightAssumed);
        }
        let platform_m = self.model.frame.cartesian([0.0; 3]);
        let is_polar = matches!(used, Position::Polar(_) | Position::Slant(_));
        let (kind, values, sigmas) = match self.model.covariance.polar().filter(|_| is_polar) {
            Some(sigma) if height.is_known() => self.in_space(&placed, platform_m, sigma),
            Some(sigma) => along_the_ground(&placed, platform_m, sigma),
            None => {
                let velocity = Velocity::Unknown;
                let covariance = accuracy::covariance(&self.model, &placed, own, (height.is_known(), false), velocity);
                let sigma = |axis| covariance.get(axis, axis).sqrt();
                let kind = if height.is_known() {
                    DetectionKind::Position3
                } else {
                    DetectionKind::Position2
                };
                (kind, placed.position_m, [sigma(0), sigma(1), sigma(2)])
            }
        };
        Ok(self.detection(observation, time_ns, (kind, values, sigmas), platform_m))
    }

    /// Slant range and azimuth of a radar on a platform that moves: where the platform was is not known yet, so nothing
    /// is converted. The target's height stays beside them. A range along the ground needs no height.
    fn as_measured(
        &self,
        observation: &Observation,
        used: Position,
        time_ns: i64,
        height: Height,
    ) -> Result<Detection, Counter> {
        let (Position::Slant([range_m, azimuth_rad]) | Position::Polar([range_m, azimuth_rad])) = used else {
            return Err(Counter::RejectedNoPosition);
        };
        let sigma = self.model.covariance.polar().ok_or(Counter::RejectedNoPosition)?;
        if !(0.0..=self.model.limits.range_m).contains(&range_m) || !azimuth_rad.is_finite() {
            return Err(Counter::RejectedPosition);
        }
        let values = [range_m, azimuth_rad.rem_euclid(TAU), 0.0];
        let sigmas = [sigma.range_m, sigma.azimuth_rad, 0.0];
        let measured = (DetectionKind::RangeBearing, values, sigmas);
        let stated = match (used, height) {
            (Position::Slant(_), Height::Known(height_m)) => Some(StatedHeight {
                height_m,
                sigma_m: self.model.covariance.height_sigma_m,
            }),
            _ => None,
        };
        Ok(Detection {
            height: stated,
            ..self.detection(observation, time_ns, measured, [0.0; 3])
        })
    }

    fn detection(
        &self,
        observation: &Observation,
        time_ns: i64,
        (kind, values, sigmas): (DetectionKind, [f64; 3], [f64; 3]),
        platform_m: [f64; 3],
    ) -> Detection {
        let doppler = self.model.covariance.doppler_sigma_mps.zip(observation.doppler_mps);
        let range_rate = doppler.map(|(sigma_mps, speed_mps)| match self.model.covariance.doppler_towards {
            true => (-speed_mps, sigma_mps),
            false => (speed_mps, sigma_mps),
        });
        let measured = kind.quantities().len();
        let only_measured = |place: usize, value: f64| if place < measured { value } else { 0.0 };
        Detection {
            time_of_measurement_ns: time_ns,
            sensor_id: sensor_id(self.model.number),
            scan: 0,
            detection_id: 0,
            kind,
            values: std::array::from_fn(|place| only_measured(place, values[place])),
            range_rate_mps: range_rate.map(|(rate_mps, _)| rate_mps),
            sigmas: Some(std::array::from_fn(|place| match sigmas.get(place) {
                Some(sigma) => only_measured(place, *sigma),
                None => range_rate.map_or(0.0, |(_, sigma_mps)| sigma_mps),
            })),
            platform_m,
            platform: DetectionPlatform::default(),
            height: None,
            velocity: None,
            reply: self.reply(observation),
            truth: None,
        }
    }

    /// Values that the target's transponder stated. A code that is not validated, or garbled, has not come so far.
    fn reply(&self, observation: &Observation) -> TransponderReply {
        let limits = &self.model.limits;
        let possible = limits.height_min_m..=limits.height_max_m;
        let stated = observation
            .transponder_altitude()
            .filter(|(altitude_m, _)| possible.contains(&(altitude_m + self.altitude_correction_m)))
            .and_then(|(altitude_m, age_ns)| Some((level_of(altitude_m)?, age_ns)));
        TransponderReply {
            identity: observation.identity,
            level: stated.map(|(level, _)| level),
            level_age_ms: stated.map_or(0, |(_, age_ns)| (age_ns / NS_PER_MS).clamp(0, u32::MAX.into()) as u32),
            ..TransponderReply::default()
        }
    }

    /// Position measured in this look; `None` if none was.
    fn plot(&self, observation: &Observation) -> Option<Position> {
        if matches!(observation.state, TrackState::Coasted | TrackState::Terminated) {
            return None;
        }
        let other = || observation.position().filter(|_| observation.plot);
        match self.model.positions {
            PositionForm::Any => observation.polar_position().or_else(other),
            PositionForm::Polar => observation.polar_position(),
            PositionForm::Cartesian => other().filter(|position| matches!(position, Position::Cartesian(..))),
        }
    }

    /// Straight range, bearing and elevation with their standard deviations.
    fn in_space(
        &self,
        placed: &SystemPosition,
        platform_m: [f64; 3],
        sigma: PolarSigma,
    ) -> (DetectionKind, [f64; 3], [f64; 3]) {
        let [east, north, up] = offset(placed, platform_m);
        let ground_m = east.hypot(north);
        let range_m = ground_m.hypot(up);
        let straight = self.model.covariance.height_sigma_m / ground_m.max(1.0);
        (
            DetectionKind::RangeBearingElevation,
            [range_m, bearing(east, north), up.atan2(ground_m)],
            // Directly above the radar, the height does not determine the elevation.
            [sigma.range_m, across(placed, ground_m, sigma), straight.min(FRAC_PI_4)],
        )
    }
}

/// Range along the ground and bearing with their standard deviations.
fn along_the_ground(
    placed: &SystemPosition,
    platform_m: [f64; 3],
    sigma: PolarSigma,
) -> (DetectionKind, [f64; 3], [f64; 3]) {
    let [east, north, _] = offset(placed, platform_m);
    let ground_m = east.hypot(north);
    let variance_m2 = placed.slant.map_or(sigma.range_m.powi(2), |slant| {
        slant.variance_m2(sigma.range_m, 0.0).max(sigma.range_m.powi(2)) + slant.height_error_m2()
    });
    (
        DetectionKind::RangeBearing,
        [ground_m, bearing(east, north), 0.0],
        [variance_m2.sqrt(), across(placed, ground_m, sigma), 0.0],
    )
}

/// Standard deviation of a bearing, radians: the antenna's error is one of angle times the straight distance, however
/// high the target.
fn across(placed: &SystemPosition, ground_m: f64, sigma: PolarSigma) -> f64 {
    let straight_m = placed.slant.map_or(ground_m, |slant| slant.range_m());
    (sigma.azimuth_rad * straight_m / ground_m.max(1.0)).clamp(sigma.azimuth_rad, FRAC_PI_4)
}

fn offset(placed: &SystemPosition, platform_m: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| placed.position_m[axis] - platform_m[axis])
}

fn bearing(east: f64, north: f64) -> f64 {
    east.atan2(north).rem_euclid(TAU)
}
