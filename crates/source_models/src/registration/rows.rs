//! Rows of the vector of errors, and of its normal equations.

use nalgebra::{SMatrix, SVector};

/// Number of systematic errors per source.
pub const ERRORS: usize = 6;
/// Offset east, north, up (m); time offset (s, late is positive); range bias (m); azimuth bias (rad, clockwise).
pub type Errors = SVector<f64, ERRORS>;
/// Matrix of normal equations.
pub(crate) type NormalMatrix = SMatrix<f64, ERRORS, ERRORS>;

/// Places of the vertical offset, the time offset, the range bias and the azimuth bias among the errors.
pub(crate) const UP: usize = 2;
pub(crate) const TIME: usize = 3;
pub(crate) const RANGE: usize = 4;
pub(crate) const AZIMUTH: usize = 5;
