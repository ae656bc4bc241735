//! Covariance of a report's position and velocity.
//!
//! A report's stated accuracy is limited to the configured accuracy: no source knows its positions better than its
//! antennas, clocks and survey permit, and smaller statements come from sources without a sound estimate. Reports
//! without a statement get the configured accuracy, of their own key where that limit is much smaller.

use frames::{SensorFrame, polar_covariance};
use messages::{Counter, Covariance, UNKNOWN_CLIMB_SIGMA_MPS, UNKNOWN_HEIGHT_SIGMA_M, UNKNOWN_VELOCITY_SIGMA_MPS};

use super::placing::SystemPosition;
use super::velocity::Slope;
use super::{ConversionModel, CovarianceFrom, PoorQuality};
use observations::RADIUS95_SIGMAS;
use observations::{Observation, Position, Quality};

/// Standard deviation given to a position of unknown accuracy, metres.
pub(crate) const UNKNOWN_POSITION_SIGMA_M: f64 = 500.0;
/// Covariance given to a velocity that is not known.
pub(crate) const UNKNOWN_VELOCITY: Horizontal = [
    UNKNOWN_VELOCITY_SIGMA_MPS * UNKNOWN_VELOCITY_SIGMA_MPS,
    0.0,
    UNKNOWN_VELOCITY_SIGMA_MPS * UNKNOWN_VELOCITY_SIGMA_MPS,
];
/// A derived velocity is at best this much less accurate than a delivered one.
const DERIVED_VELOCITY_FACTOR: f64 = 2.0;
/// Standard deviation of a target's acceleration since the time of the derived velocity, metres per second².
const ACCELERATION_SIGMA_MPS2: f64 = 1.0;

/// East-east, east-north and north-north of a horizontal covariance.
pub(crate) type Horizontal = [f64; 3];

/// Velocity with its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Velocity {
    /// From the source, with the source's covariance (in the system frame), if stated.
    Delivered([f64; 2], Option<Horizontal>),
    /// From successive positions.
    Derived(Slope),
    /// Neither.
    Unknown,
}

impl Velocity {
    /// Metres per second; 0 if it is not known.
    pub(crate) fn value_mps(self) -> [f64; 2] {
        match self {
            Self::Delivered(velocity_mps, _) => velocity_mps,
            Self::Derived(slope) => slope.velocity_mps,
            Self::Unknown => [0.0; 2],
        }
    }
}

/// Returns the report's own horizontal covariance of the used position, if stated and permitted by the configuration.
pub(crate) fn own_position(
    model: &ConversionModel,
    observation: &Observation,
    used: Position,
) -> Result<Option<Horizontal>, Counter> {
    let poor = model.covariance.poor_quality;
    if observation.suspect || observation.quality == Quality::Unknown && poor == PoorQuality::Reject {
        return Err(Counter::RejectedQuality);
    }
    // The statement of a radar belongs to the track, not to the plot in the same report.
    let of_another = matches!(used, Position::Slant(_)) && observation.cartesian.is_some();
    if model.covariance.from == CovarianceFrom::Configuration || of_another {
        return Ok(None);
    }
    let floor = model.covariance.position_sigma_m;
    let circular = |sigma: f64| Some(isotropic(sigma.max(floor)));
    Ok(match observation.quality {
        Quality::Unstated => model.covariance.unstated_position_sigma_m.map(isotropic),
        Quality::Covariance(stated) => {
            let own = no_less(stated, floor);
            Some(match used {
                Position::Geodetic(_) => own,
                _ => turned(own, &model.frame),
            })
        }
        Quality::Dilution(dilution) => circular(dilution * floor),
        Quality::Radius95(radius) => circular(radius / RADIUS95_SIGMAS),
        Quality::Unknown => circular(UNKNOWN_POSITION_SIGMA_M),
    })
}

/// Returns the report's own covariance of the velocity in the system frame, in the axes of `axes`.
pub(crate) fn own_velocity(
    model: &ConversionModel,
    observation: &Observation,
    axes: &SensorFrame,
) -> Option<Horizontal> {
    let stated = observation
        .velocity_covariance
        .filter(|_| model.covariance.from == CovarianceFrom::Report)?;
    Some(turned(no_less(stated, model.covariance.velocity_sigma_mps), axes))
}

/// The covariance of a whole report.
pub(crate) fn covariance(
    model: &ConversionModel,
    placed: &SystemPosition,
    own: Option<Horizontal>,
    (height_known, climb_known): (bool, bool),
    velocity: Velocity,
) -> Covariance {
    let height = if height_known {
        model.covariance.height_sigma_m
    } else {
        UNKNOWN_HEIGHT_SIGMA_M
    };
    let sensor = sensor_position(model, placed);
    let position = wider(own.unwrap_or(sensor), model, placed);
    let rate = model.covariance.velocity_sigma_mps;
    let unstated = match model.covariance.from {
        CovarianceFrom::Report => model.covariance.unstated_velocity_sigma_mps.unwrap_or(rate),
        CovarianceFrom::Configuration => rate,
    };
    let horizontal = match velocity {
        Velocity::Delivered(_, own) => own.unwrap_or(isotropic(unstated)),
        Velocity::Derived(slope) => no_less(of_slope(sensor, slope), DERIVED_VELOCITY_FACTOR * rate),
        Velocity::Unknown => UNKNOWN_VELOCITY,
    };
    let vertical = if climb_known { rate } else { UNKNOWN_CLIMB_SIGMA_MPS };
    let mut covariance = Covariance::diagonal([0.0, 0.0, height], [0.0, 0.0, vertical]);
    for (first, [xx, xy, yy]) in [(0, position), (3, horizontal)] {
        covariance.set(first, first, xx);
        covariance.set(first, first + 1, xy);
        covariance.set(first + 1, first + 1, yy);
    }
    covariance
}

/// Covariance of a position as configured: of range and azimuth, else of the plane.
fn sensor_position(model: &ConversionModel, placed: &SystemPosition) -> Horizontal {
    let plane = model.covariance.position_sigma_m;
    let Some(sigma) = model.covariance.polar() else {
        return [plane * plane, 0.0, plane * plane];
    };
    let offset = from_sensor(model, placed);
    let Some(slant) = placed.slant else {
        return polar_covariance(offset, sigma);
    };
    let along_m2 = slant.variance_m2(sigma.range_m, model.covariance.height_sigma_m);
    // Across, the antenna's error is one of angle times the straight distance, however high the target.
    let across_m2 = (sigma.azimuth_rad * slant.range_m()).powi(2);
    along_and_across(offset, along_m2.max(sigma.range_m.powi(2)), across_m2)
}

/// Adds the error along the line of sight caused by an assumed height.
fn wider([xx, xy, yy]: Horizontal, model: &ConversionModel, placed: &SystemPosition) -> Horizontal {
    let along_m2 = placed.slant.map_or(0.0, |slant| slant.height_error_m2());
    let [more_xx, more_xy, more_yy] = along_and_across(from_sensor(model, placed), along_m2, 0.0);
    [xx + more_xx, xy + more_xy, yy + more_yy]
}

/// Returns the covariance of a velocity derived from successive positions. Common errors of the positions cancel, so
/// that the sensor's accuracy counts, not the report's statement; but the velocity is older than the report.
fn of_slope([xx, xy, yy]: Horizontal, slope: Slope) -> Horizontal {
    let since_then = (ACCELERATION_SIGMA_MPS2 * slope.age_s).powi(2);
    [
        xx / slope.spread_s2 + since_then,
        xy / slope.spread_s2,
        yy / slope.spread_s2 + since_then,
    ]
}

fn from_sensor(model: &ConversionModel, placed: &SystemPosition) -> [f64; 2] {
    let [x0, y0] = model.frame.place();
    [placed.position_m[0] - x0, placed.position_m[1] - y0]
}

/// Variances along the direction of `offset` and across it, as a covariance; in no direction, the larger in all.
fn along_and_across(offset: [f64; 2], along_m2: f64, across_m2: f64) -> Horizontal {
    let length = offset[0].hypot(offset[1]);
    if length < 1e-9 {
        let larger = along_m2.max(across_m2);
        return [larger, 0.0, larger];
    }
    let [east, north] = [offset[0] / length, offset[1] / length];
    [
        along_m2 * east * east + across_m2 * north * north,
        (along_m2 - across_m2) * east * north,
        along_m2 * north * north + across_m2 * east * east,
    ]
}

/// The same standard deviation in all directions.
fn isotropic(sigma: f64) -> Horizontal {
    [sigma * sigma, 0.0, sigma * sigma]
}

/// With variances of at least the square of `sigma`.
fn no_less([xx, xy, yy]: Horizontal, sigma: f64) -> Horizontal {
    [xx.max(sigma * sigma), xy, yy.max(sigma * sigma)]
}

/// A covariance along a sensor's own axes, in the system frame: R·C·Rᵀ.
fn turned([xx, xy, yy]: Horizontal, axes: &SensorFrame) -> Horizontal {
    let [a, c] = axes.velocity([1.0, 0.0]);
    let [b, d] = axes.velocity([0.0, 1.0]);
    [
        a * a * xx + 2.0 * a * b * xy + b * b * yy,
        a * c * xx + (a * d + b * c) * xy + b * d * yy,
        c * c * xx + 2.0 * c * d * xy + d * d * yy,
    ]
}
