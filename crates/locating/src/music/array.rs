//! An array of antennas in a plane, and the response to a wave: the steering vector.
//!
//! A wave from the bearing β reaches an antenna earlier the further the antenna lies towards β, so the phase there is
//! ahead by 2π/λ · (right·sin β + forward·cos β). Phases are counted from the antennas' middle, which makes no
//! difference to a bearing, and keeps the derivatives small.
//!
//! If all antennas lie in a line, a wave from β and its mirror image at the line have the same phases. Then only a
//! single side is searched, and every bearing has an image.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::error::MusicError;
use super::settings::ElementPosition;

/// Speed of light, metres per second.
const LIGHT_MPS: f64 = 299_792_458.0;
/// Distance from the array's line, as a part of the array's width, below which an antenna is on it.
const LINE_TOLERANCE: f64 = 1e-9;
/// Greatest coordinate, metres.
const COORDINATE_MAX_M: f64 = 1e6;

/// An array of antennas on a platform.
#[derive(Clone, Debug, PartialEq)]
pub struct AntennaArray {
    /// Right and forward of the antennas' middle, metres.
    elements: Vec<[f64; 2]>,
    /// Greatest distance between two antennas, metres.
    width_m: f64,
    /// Direction of the line on which all antennas lie, radians clockwise from forward, 0 to π.
    line_rad: Option<f64>,
}

impl AntennaArray {
    /// The array of these antennas, in the order of the samples.
    ///
    /// # Errors
    /// Fewer than two antennas, a position that is no number, two antennas in the same place.
    pub fn new(positions: &[ElementPosition]) -> Result<Self, MusicError> {
        let antennas = positions.len();
        if antennas < 2 {
            return Err(MusicError::TooFewAntennas { antennas });
        }
        // A comparison with NaN is false.
        let usable =
            |at: &ElementPosition| at.right_m.abs() < COORDINATE_MAX_M && at.forward_m.abs() < COORDINATE_MAX_M;
        if let Some(antenna) = positions.iter().position(|at| !usable(at)) {
            return Err(MusicError::Position { antenna });
        }
        let mean = |of: fn(&ElementPosition) -> f64| positions.iter().map(of).sum::<f64>() / antennas as f64;
        let middle = [mean(|at| at.right_m), mean(|at| at.forward_m)];
        let elements: Vec<_> = positions
            .iter()
            .map(|at| [at.right_m - middle[0], at.forward_m - middle[1]])
            .collect();
        let (width_m, [first, second]) = widest(&elements)?;
        let along = [0, 1].map(|axis| (elements[second][axis] - elements[first][axis]) / width_m);
        let beside_m = |at: &[f64; 2]| {
            let from_first = [at[0] - elements[first][0], at[1] - elements[first][1]];
            (from_first[0] * along[1] - from_first[1] * along[0]).abs()
        };
        let in_line = elements.iter().all(|at| beside_m(at) <= LINE_TOLERANCE * width_m);
        Ok(Self {
            line_rad: in_line.then(|| along[0].atan2(along[1]).rem_euclid(PI)),
            elements,
            width_m,
        })
    }

    /// `antennas` in a line, `spacing_m` apart, from left to right: broadside is forward.
    ///
    /// # Errors
    /// As [`AntennaArray::new`].
    pub fn line(antennas: usize, spacing_m: f64) -> Result<Self, MusicError> {
        let position = |index: usize| ElementPosition {
            right_m: index as f64 * spacing_m,
            forward_m: 0.0,
        };
        Self::new(&(0..antennas).map(position).collect::<Vec<_>>())
    }

    /// `antennas` evenly on a circle, the first forward.
    ///
    /// # Errors
    /// As [`AntennaArray::new`].
    pub fn circle(antennas: usize, radius_m: f64) -> Result<Self, MusicError> {
        let position = |index: usize| {
            let (sin, cos) = (TAU * index as f64 / antennas as f64).sin_cos();
            ElementPosition {
                right_m: radius_m * sin,
                forward_m: radius_m * cos,
            }
        };
        Self::new(&(0..antennas).map(position).collect::<Vec<_>>())
    }

    /// Number of antennas.
    #[allow(clippy::len_without_is_empty, reason = "an array without antennas cannot be made")]
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// Greatest distance between two antennas, metres.
    pub fn width_m(&self) -> f64 {
        self.width_m
    }

    /// Direction of the line on which all antennas lie, if so: radians clockwise from forward, 0 to π.
    pub fn line_rad(&self) -> Option<f64> {
        self.line_rad
    }

    /// Number of bearings that have the same steering vector for geometry alone.
    pub(super) fn images(&self) -> usize {
        if self.line_rad.is_some() { 2 } else { 1 }
    }

    /// The other bearing with the steering vector of `bearing_rad`, if the antennas are in a line and the bearing is
    /// not along it; 0 to 2π.
    pub fn mirrored(&self, bearing_rad: f64) -> Option<f64> {
        let mirrored_rad = (2.0 * self.line_rad? - bearing_rad).rem_euclid(TAU);
        (self.sine_to_line(bearing_rad)? > LINE_TOLERANCE).then_some(mirrored_rad)
    }

    /// Wave number at a frequency, radians per metre.
    pub(super) fn wave_number(frequency_hz: f64) -> f64 {
        TAU * frequency_hz / LIGHT_MPS
    }

    /// Per antenna: the response to a wave from a bearing.
    pub(super) fn response(&self, wave_number: f64, bearing_rad: f64) -> impl Iterator<Item = Response> + '_ {
        let (sin, cos) = bearing_rad.sin_cos();
        let line = self.line_rad.map(f64::sin_cos);
        self.elements.iter().map(move |[right_m, forward_m]| {
            let phase = wave_number * (right_m * sin + forward_m * cos);
            let slope = wave_number * (right_m * cos - forward_m * sin);
            Response {
                value: Complex::cis(phase),
                slope,
                curvature: -phase,
                search_slope: line.map_or(slope, |(sin, cos)| wave_number * (right_m * sin + forward_m * cos)),
            }
        })
    }

    /// Sine of the angle between a bearing and the line of the antennas, if the antennas are in a line; 0 to 1.
    pub(super) fn sine_to_line(&self, bearing_rad: f64) -> Option<f64> {
        Some((bearing_rad - self.line_rad?).sin().abs())
    }
}

/// Response of an antenna to a wave, and the change of the phase with the bearing, radians per (square) radian.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    /// Sample for a wave of amplitude 1.
    pub(super) value: Complex<f64>,
    /// First derivative of the phase.
    pub(super) slope: f64,
    /// Second derivative.
    pub(super) curvature: f64,
    /// In a line array the derivative by the cosine of the angle to the line, else the first derivative again.
    pub(super) search_slope: f64,
}

impl Response {
    /// First derivative of the value by the bearing.
    pub(super) fn first(&self) -> Complex<f64> {
        Complex::new(0.0, self.slope) * self.value
    }

    /// Second derivative of the value by the bearing.
    pub(super) fn second(&self) -> Complex<f64> {
        Complex::new(-self.slope * self.slope, self.curvature) * self.value
    }
}

/// Returns the greatest distance between two antennas, and the indices of both.
fn widest(elements: &[[f64; 2]]) -> Result<(f64, [usize; 2]), MusicError> {
    let mut widest = (0.0, [0, 1]);
    for (second, b) in elements.iter().enumerate() {
        for (first, a) in elements[..second].iter().enumerate() {
            let distance_m = (a[0] - b[0]).hypot(a[1] - b[1]);
            if distance_m <= f64::EPSILON * COORDINATE_MAX_M {
                return Err(MusicError::Coincident { first, second });
            }
            if distance_m > widest.0 {
                widest = (distance_m, [first, second]);
            }
        }
    }
    Ok(widest)
}
