//! Origin of the system frame.

use crate::layout::sample;

sample! {
    /// Origin of the system frame, the plane in which all positions are given: east, north, up, metres.
    FrameOrigin, size 24 {
        /// Latitude on the WGS-84 ellipsoid, degrees, north positive.
        latitude_deg: f64,
        /// Longitude, degrees, east positive.
        longitude_deg: f64,
        /// Height above the ellipsoid, metres.
        height_m: f64,
    }
}
