//! A detection of a sensor on board in the system's terms.
//!
//! The target is at T = p + R·l + ρ·R·M·d(b, e): position p and rotation R of the platform, lever arm l, mounting M,
//! measured range ρ and direction d. Each error moves T; the quantities of the result are read from T as seen from the
//! sensor's estimated place p + R·l. Every column of the Jacobian is an error: of the measured values, of the three
//! coordinates of p, of heading, pitch and roll. The covariance is J·diag(σ²)·Jᵀ.
//!
//! A sensor without elevation measures the bearing in the plane of the deck. On a rolling deck, the same bearing
//! belongs to different directions at different elevations. The target is assumed near the horizontal: the direction
//! h(ψ) in the horizontal plane with h·(R·M·∂d/∂b) = 0, and the assumed elevation's error moves ψ as this equation
//! demands.
//!
//! Where a height is stated, the elevation follows from the height ([`crate::height`]).
//!
//! Limits: the tangent is good for errors of a few degrees. A direction without a range has no enlargement by errors of
//! the position, which depend on the range.

use std::f64::consts::TAU;

use frames::{FrameChange, SystemFrame};
use observations::{Detection, DetectionKind, DetectionPlatform, QUANTITIES_MAX};

use crate::height::{Rise, elevation_to};
use crate::mount::{Bearings, Mount};
use crate::pose::{NoState, Pose};
use crate::rotation::{Attitude, IDENTITY, Matrix, dot, product, scaled, sum, times};
use crate::settings::Assumed;
use crate::state::State;

/// Horizontal part of a direction's unit vector, or of a range in metres, below which a bearing has no meaning.
const VERTICAL: f64 = 1e-6;
/// Errors: three of the measured values, the assumed elevation's, three of the position, three of the attitude.
const ERRORS_MAX: usize = 10;
const RANGE_RATE: usize = QUANTITIES_MAX;
const QUANTITIES: usize = QUANTITIES_MAX + 1;

/// Detection in the system's terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// The detection, relative to the system frame's axes and the sensor's place; positions become ranges with
    /// directions, with errors in these axes.
    pub detection: Detection,
    /// Covariance of range, bearing, elevation and range rate; 0 for quantities without a value.
    pub covariance: [[f64; QUANTITIES]; QUANTITIES],
}

/// Why a detection cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The platform's position at the time is not known.
    Position(NoState),
    /// The platform's heading at the time is not known.
    Heading(NoState),
    /// The platform's pitch and roll at the time are not known.
    Tilt(NoState),
    /// The detection and the sensor state no standard deviations.
    NoSigmas,
    /// The direction is vertical, or a value is not a number.
    NoDirection,
    /// There was no room for the detection to wait.
    Full,
}

/// The measured point in polar form, with a column of errors for each measured value.
struct Polar {
    range_m: Option<f64>,
    bearing_rad: f64,
    elevation_rad: Option<f64>,
    /// Errors of range, bearing and elevation for a single standard deviation of each measured value.
    columns: [[f64; 3]; QUANTITIES_MAX],
}

/// A direction in the system frame, with derivatives.
struct Direction {
    unit: [f64; 3],
    bearing_rad: f64,
    elevation_rad: f64,
    by_bearing: [f64; 2],
    by_elevation: [f64; 2],
    by_angles: [[f64; 2]; 3],
}

impl Mount {
    /// Carries a detection, measured on board, into the system's terms. `default_sigmas` serve a detection without
    /// stated values. With a `frame`, north and the horizontal of a sensor with `bearings = "north"` are taken at the
    /// platform's place; otherwise, from the system frame.
    ///
    /// # Errors
    /// [`Refusal`]: why the detection cannot be used.
    pub fn carry(
        &self,
        detection: &Detection,
        pose: &Pose,
        default_sigmas: Option<[f64; QUANTITIES]>,
        frame: Option<&SystemFrame>,
    ) -> Result<Carried, Refusal> {
        let sigmas = detection.sigmas.or(default_sigmas).ok_or(Refusal::NoSigmas)?;
        let polar = Polar::of(detection, &sigmas).ok_or(Refusal::NoDirection)?;
        let attitude = self.attitude(pose)?;
        let axes = Axes::of(self, pose, attitude.as_ref(), frame);
        let place = self.place(pose, attitude.as_ref());
        let (direction, rise) = polar
            .in_stated_height(detection, &axes, place.position_m, frame)
            .or_else(|| Some((Direction::of(&polar, &axes)?, Rise::default())))
            .ok_or(Refusal::NoDirection)?;

        let mut errors = Errors::default();
        for [range, bearing, elevation] in polar.columns {
            let turned = direction.moved(bearing, elevation + rise.by_range * range);
            errors.push([range, turned[0], turned[1]]);
        }
        match rise.sigma_rad {
            Some(sigma) => {
                let turned = direction.moved(0.0, sigma);
                errors.push([0.0, turned[0], turned[1]]);
            }
            None if polar.elevation_rad.is_none() => {
                let sigma = self.elevation_sigma_deg.rad();
                errors.push([0.0, direction.by_elevation[0] * sigma, 0.0]);
            }
            None => {}
        }
        let seen = polar.range_m.map(|range_m| Seen {
            range_m,
            direction: &direction,
            rise,
        });
        if let Some(seen) = &seen {
            for axis in 0..3 {
                let mut moved = [0.0; 3];
                moved[axis] = place.sigma_m;
                errors.push(seen.from(moved));
            }
        }
        for (k, sigma_rad) in axes.sigmas_rad.into_iter().enumerate() {
            let arm = seen.as_ref().map_or([0.0; 3], |seen| seen.from(place.by_angles[k]));
            let turned = direction.by_angles[k];
            errors.push([arm[0], arm[1] + turned[0], arm[2] + turned[1]].map(|value| value * sigma_rad));
        }

        let velocity = pose.velocity_at(self.arm());
        let range_rate = detection.range_rate_mps.zip(velocity).map(|(rate_mps, velocity)| {
            // Away from the sensor at rest in the system frame.
            errors.range_rate(&direction, velocity, [sigmas[RANGE_RATE], pose.velocity_sigma_mps]);
            rate_mps + dot(velocity, direction.unit)
        });
        let covariance = errors.covariance();
        let has_elevation = polar.elevation_rad.is_some() || rise.sigma_rad.is_some();
        let carried = Carried {
            detection: Detection {
                platform: DetectionPlatform {
                    attitude_rad: self.fixed_attitude(detection, attitude.as_ref()),
                    ..detection.platform
                },
                ..self.detection(
                    (detection, polar.range_m, has_elevation),
                    &direction,
                    place.position_m,
                    range_rate,
                    &covariance,
                )
            },
            covariance,
        };
        let finite = covariance
            .iter()
            .flatten()
            .chain(&carried.detection.values)
            .all(|value| value.is_finite());
        if finite { Ok(carried) } else { Err(Refusal::NoDirection) }
    }

    /// Carries a detection that states position and attitude of the platform. This position is the sensor's, so there
    /// is no lever arm.
    ///
    /// # Errors
    /// [`Refusal`]: why the detection cannot be used.
    pub fn carry_own(
        &self,
        detection: &Detection,
        assumed: &Assumed,
        default_sigmas: Option<[f64; QUANTITIES]>,
        frame: Option<&SystemFrame>,
    ) -> Result<Carried, Refusal> {
        let at_the_sensor = Self {
            lever_arm_m: [0.0; 3],
            ..*self
        };
        let pose = Pose::of(&State::of_detection(detection), assumed).ok_or(Refusal::Position(NoState::None))?;
        at_the_sensor.carry(detection, &pose, default_sigmas, frame)
    }

    /// The attitude, where the sensor needs an attitude.
    fn attitude(&self, pose: &Pose) -> Result<Option<Attitude>, Refusal> {
        if self.bearings == Bearings::North {
            return Ok(pose.attitude().ok());
        }
        pose.heading.map_err(Refusal::Heading)?;
        pose.tilt.map_err(Refusal::Tilt)?;
        Ok(pose.attitude().ok())
    }

    /// Attitude of the platform in which the sensor is fixed, stated with the detection: where a sensor sees moves with
    /// the hull. Otherwise as stated by the measured detection.
    fn fixed_attitude(&self, measured: &Detection, attitude: Option<&Attitude>) -> Option<[f32; 3]> {
        let fixed = attitude.filter(|_| self.bearings == Bearings::Nose);
        let angles = fixed.map(|attitude| [attitude.heading_rad, attitude.pitch_rad, attitude.roll_rad]);
        let angles = angles.map(|angles| angles.map(|angle| angle as f32));
        angles.or(measured.platform.attitude_rad)
    }

    /// Place of the sensor in the system frame.
    fn place(&self, pose: &Pose, attitude: Option<&Attitude>) -> SensorPlace {
        let arm = self.arm();
        let Some(attitude) = attitude else {
            // The lever arm has an unknown direction: half of the arm's square along each horizontal axis.
            let [right, forward, up] = arm;
            let variance_m2 = pose.position_sigma_m.powi(2) + 0.5 * (right * right + forward * forward);
            return SensorPlace {
                position_m: sum(pose.position_m, [0.0, 0.0, up]),
                sigma_m: variance_m2.sqrt(),
                by_angles: [[0.0; 3]; 3],
            };
        };
        SensorPlace {
            position_m: sum(pose.position_m, times(&attitude.rotation(), arm)),
            sigma_m: pose.position_sigma_m,
            by_angles: attitude.derivatives().map(|derivative| times(&derivative, arm)),
        }
    }

    fn detection(
        &self,
        (measured, range_m, has_elevation): (&Detection, Option<f64>, bool),
        direction: &Direction,
        place_m: [f64; 3],
        range_rate_mps: Option<f64>,
        covariance: &[[f64; QUANTITIES]; QUANTITIES],
    ) -> Detection {
        use DetectionKind::{Bearing, BearingElevation, RangeBearing, RangeBearingElevation};
        let sigma = |place: usize| covariance[place][place].sqrt();
        let bearing_rad = direction.bearing_rad.rem_euclid(TAU);
        let has_range = range_m.is_some();
        let range_m = range_m.unwrap_or_default();
        let rate = if range_rate_mps.is_some() {
            sigma(RANGE_RATE)
        } else {
            0.0
        };
        let (kind, values, sigmas) = match (has_range, has_elevation) {
            (true, true) => (
                RangeBearingElevation,
                [range_m, bearing_rad, direction.elevation_rad],
                [sigma(0), sigma(1), sigma(2)],
            ),
            (true, false) => (RangeBearing, [range_m, bearing_rad, 0.0], [sigma(0), sigma(1), 0.0]),
            (false, true) => (
                BearingElevation,
                [bearing_rad, direction.elevation_rad, 0.0],
                [sigma(1), sigma(2), 0.0],
            ),
            (false, false) => (Bearing, [bearing_rad, 0.0, 0.0], [sigma(1), 0.0, 0.0]),
        };
        Detection {
            kind,
            values,
            range_rate_mps,
            sigmas: Some([sigmas[0], sigmas[1], sigmas[2], rate]),
            platform_m: place_m,
            height: None,
            ..*measured
        }
    }
}

struct SensorPlace {
    position_m: [f64; 3],
    sigma_m: f64,
    /// Motion of the place by heading, pitch and roll, metres per radian.
    by_angles: [[f64; 3]; 3],
}

/// Rotation from the sensor's axes to the system frame, with derivatives by heading, pitch and roll.
struct Axes {
    rotation: Matrix,
    derivatives: [Matrix; 3],
    sigmas_rad: [f64; 3],
}

impl Axes {
    fn of(mount: &Mount, pose: &Pose, attitude: Option<&Attitude>, frame: Option<&SystemFrame>) -> Self {
        let mounting = Attitude::of(mount.mounting_deg.map(|angle| angle.rad())).rotation();
        match (mount.bearings, attitude, pose.angles()) {
            (Bearings::Nose, Some(attitude), Ok(angles)) => Self {
                rotation: product(&attitude.rotation(), &mounting),
                derivatives: attitude.derivatives().map(|derivative| product(&derivative, &mounting)),
                sigmas_rad: angles.map(|angle| angle.sigma_rad),
            },
            _ => {
                let local = frame.map_or(IDENTITY, |frame| {
                    let here = SystemFrame::at(frame.to_geodetic(pose.position_m));
                    *FrameChange::between(&here, frame).rotation()
                });
                let [about_up, ..] = Attitude::default().derivatives();
                let turned = |matrix: &Matrix| product(&local, &product(matrix, &mounting));
                Self {
                    rotation: turned(&IDENTITY),
                    derivatives: [turned(&about_up), [[0.0; 3]; 3], [[0.0; 3]; 3]],
                    sigmas_rad: [pose.heading.map_or(0.0, |heading| heading.sigma_rad), 0.0, 0.0],
                }
            }
        }
    }
}

impl Polar {
    fn of(detection: &Detection, sigmas: &[f64; QUANTITIES]) -> Option<Self> {
        let [a, b, c] = detection.values;
        let [sa, sb, sc, _] = *sigmas;
        let of = |range_m, bearing_rad, elevation_rad, columns| Self {
            range_m,
            bearing_rad,
            elevation_rad,
            columns,
        };
        let polar = match detection.kind {
            DetectionKind::RangeBearing => of(Some(a), b, None, [[sa, 0.0, 0.0], [0.0, sb, 0.0], [0.0; 3]]),
            DetectionKind::RangeBearingElevation => {
                of(Some(a), b, Some(c), [[sa, 0.0, 0.0], [0.0, sb, 0.0], [0.0, 0.0, sc]])
            }
            DetectionKind::Bearing => of(None, a, None, [[0.0, sa, 0.0], [0.0; 3], [0.0; 3]]),
            DetectionKind::BearingElevation => of(None, a, Some(b), [[0.0, sa, 0.0], [0.0, 0.0, sb], [0.0; 3]]),
            DetectionKind::Position2 | DetectionKind::Position3 => {
                let has_height = detection.kind == DetectionKind::Position3;
                let up = if has_height { c } else { 0.0 };
                let ground_m = a.hypot(b);
                let range_m = ground_m.hypot(up);
                if ground_m.is_nan() || ground_m <= VERTICAL {
                    return None;
                }
                let fall = -up / (range_m * range_m * ground_m);
                let columns = [
                    [a / range_m, b / (ground_m * ground_m), fall * a].map(|value| value * sa),
                    [b / range_m, -a / (ground_m * ground_m), fall * b].map(|value| value * sb),
                    [up / range_m, 0.0, ground_m / (range_m * range_m)]
                        .map(|value| if has_height { value * sc } else { 0.0 }),
                ];
                let elevation_rad = has_height.then(|| up.atan2(ground_m));
                of(Some(range_m), a.atan2(b), elevation_rad, columns)
            }
        };
        let fit = polar.range_m.is_none_or(|range_m| range_m > VERTICAL);
        fit.then_some(polar)
    }

    /// The direction to a target with a stated height, from the sensor's place; `None` without a height, and where no
    /// direction leads to this height.
    fn in_stated_height(
        &self,
        detection: &Detection,
        axes: &Axes,
        place_m: [f64; 3],
        frame: Option<&SystemFrame>,
    ) -> Option<(Direction, Rise)> {
        let (height, range_m) = detection.height.zip(self.range_m)?;
        if self.elevation_rad.is_some() {
            return None;
        }
        let at = |elevation_rad| Direction::in_the_plane(axes, self.bearing_rad, elevation_rad);
        let unit_at = |elevation_rad| at(elevation_rad).map(|direction| direction.unit);
        let (elevation_rad, rise) = elevation_to(height, range_m, place_m, frame, unit_at)?;
        Some((at(elevation_rad)?, rise))
    }
}

impl Direction {
    fn of(polar: &Polar, axes: &Axes) -> Option<Self> {
        let (sb, cb) = polar.bearing_rad.sin_cos();
        match polar.elevation_rad {
            Some(elevation_rad) => {
                let (se, ce) = elevation_rad.sin_cos();
                Self::in_space(
                    axes,
                    [sb * ce, cb * ce, se],
                    [cb * ce, -sb * ce, 0.0],
                    [-sb * se, -cb * se, ce],
                )
            }
            None => Self::in_the_plane(axes, polar.bearing_rad, 0.0),
        }
    }

    fn in_space(axes: &Axes, d: [f64; 3], by_bearing: [f64; 3], by_elevation: [f64; 3]) -> Option<Self> {
        let unit = times(&axes.rotation, d);
        let ground = unit[0].hypot(unit[1]);
        if ground.is_nan() || ground <= VERTICAL {
            return None;
        }
        let read = |moved: [f64; 3]| {
            let bearing = (unit[1] * moved[0] - unit[0] * moved[1]) / (ground * ground);
            [bearing, moved[2] / ground]
        };
        Some(Self {
            unit,
            bearing_rad: unit[0].atan2(unit[1]),
            elevation_rad: unit[2].atan2(ground),
            by_bearing: read(times(&axes.rotation, by_bearing)),
            by_elevation: read(times(&axes.rotation, by_elevation)),
            by_angles: axes.derivatives.map(|derivative| read(times(&derivative, d))),
        })
    }

    /// The direction with this elevation above the horizontal that is seen at a bearing in the tilted plane of the
    /// sensor.
    fn in_the_plane(axes: &Axes, bearing_rad: f64, elevation_rad: f64) -> Option<Self> {
        let (sb, cb) = bearing_rad.sin_cos();
        let (se, ce) = elevation_rad.sin_cos();
        // The derivative of the direction by the bearing is at right angles to the direction, in the sensor's axes and
        // in all.
        let across = [cb, -sb, 0.0];
        let w = times(&axes.rotation, across);
        let forward = times(&axes.rotation, [sb, cb, 0.0]);
        let level = w[0].hypot(w[1]);
        if level.is_nan() || level <= VERTICAL || ce <= VERTICAL {
            return None;
        }
        let ahead = if forward[1] * w[0] - forward[0] * w[1] >= 0.0 {
            1.0
        } else {
            -1.0
        };
        // Above the horizontal, the plane of the bearing leans aside.
        let aside = -w[2] * se / (ce * level);
        let upright = (1.0 - aside * aside).sqrt();
        if upright.is_nan() || upright <= VERTICAL {
            return None;
        }
        let horizontal = [
            -w[1] * ahead / level * upright + w[0] / level * aside,
            w[0] * ahead / level * upright + w[1] / level * aside,
        ];
        let unit = [horizontal[0] * ce, horizontal[1] * ce, se];
        // The equation u·w = 0 changes by ±|w|, in these planes, for each radian of the bearing.
        let slope = -1.0 / (ahead * level * upright * ce);
        let rising = [-horizontal[0] * se, -horizontal[1] * se, ce];
        Some(Self {
            unit,
            bearing_rad: unit[0].atan2(unit[1]),
            elevation_rad,
            by_bearing: [-slope * dot(unit, forward), 0.0],
            by_elevation: [slope * dot(w, rising), 1.0],
            by_angles: axes
                .derivatives
                .map(|derivative| [slope * dot(unit, times(&derivative, across)), 0.0]),
        })
    }

    fn moved(&self, bearing: f64, elevation: f64) -> [f64; 2] {
        std::array::from_fn(|k| self.by_bearing[k] * bearing + self.by_elevation[k] * elevation)
    }

    /// Change of the unit vector by changes of bearing and elevation.
    fn unit_moved(&self, [bearing, elevation]: [f64; 2]) -> [f64; 3] {
        let (sb, cb) = self.bearing_rad.sin_cos();
        let (se, ce) = self.elevation_rad.sin_cos();
        sum(
            scaled([cb * ce, -sb * ce, 0.0], bearing),
            scaled([-sb * se, -cb * se, ce], elevation),
        )
    }
}

/// A target as seen from the sensor's place.
struct Seen<'a> {
    range_m: f64,
    direction: &'a Direction,
    rise: Rise,
}

impl Seen<'_> {
    /// Changes of range, bearing and elevation by a motion of the sensor, with the target, metres. A target with a
    /// stated height does not rise with the sensor.
    fn from(&self, moved: [f64; 3]) -> [f64; 3] {
        let (sb, cb) = self.direction.bearing_rad.sin_cos();
        let (se, ce) = self.direction.elevation_rad.sin_cos();
        let bearing = (cb * moved[0] - sb * moved[1]) / (self.range_m * ce.max(VERTICAL));
        let elevation = dot([-sb * se, -cb * se, ce], moved) / self.range_m;
        let turned = self.direction.moved(0.0, self.rise.by_up * moved[2]);
        [
            dot(self.direction.unit, moved),
            bearing + turned[0],
            elevation + turned[1],
        ]
    }
}

/// Errors of range, bearing, elevation and range rate, a row for each cause.
#[derive(Default)]
struct Errors {
    rows: [[f64; QUANTITIES]; ERRORS_MAX],
    count: usize,
    /// Variance of the range rate alone, (m/s)².
    rate_variance: f64,
}

impl Errors {
    fn push(&mut self, [range, bearing, elevation]: [f64; 3]) {
        self.rows[self.count] = [range, bearing, elevation, 0.0];
        self.count += 1;
    }

    /// The platform's velocity is taken along a direction that has the errors so far.
    fn range_rate(&mut self, direction: &Direction, velocity: [f64; 3], [own, of_platform]: [f64; 2]) {
        for row in &mut self.rows[..self.count] {
            row[RANGE_RATE] = dot(velocity, direction.unit_moved([row[1], row[2]]));
        }
        self.rate_variance = own * own + of_platform * of_platform;
    }

    fn covariance(&self) -> [[f64; QUANTITIES]; QUANTITIES] {
        let mut covariance = [[0.0; QUANTITIES]; QUANTITIES];
        for row in &self.rows[..self.count] {
            for a in 0..QUANTITIES {
                for b in 0..QUANTITIES {
                    covariance[a][b] += row[a] * row[b];
                }
            }
        }
        covariance[RANGE_RATE][RANGE_RATE] += self.rate_variance;
        covariance
    }
}
