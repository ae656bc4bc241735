//! Where and when.
//!
//! Every sensor reports in its own frame: a radar in ranges and azimuths from its antenna, a multilateration system
//! in metres from a reference point, ADS-B in latitude and longitude. Koseki compares them in one *system frame*, a
//! plane East-North-Up frame that touches the WGS-84 ellipsoid at the configured origin. Confused frames are the
//! classic mistake of this field, and a silent one: the numbers look alike. So inside this crate the frames are
//! types (crate `sguaba`), and only checked conversions leave it.
//!
//! Time has the same trap: sensors send the time of *day*, which falls back to zero at midnight. [`time`] turns it
//! into UTC.

mod geodetic;
mod sensor;
pub mod time;

pub use geodetic::{FrameChange, Geodetic, GeodeticError, SystemFrame, Vertical};
pub use sensor::{PolarSigma, SensorFrame, Sighting, polar_covariance};
