//! Size of a target.

use crate::layout::sample;

sample! {
    /// Horizontal extent of a target: a box centred on the track's position.
    Extent, size 24 {
        /// Length of the longer side, metres; 0: unknown.
        length_m: f32,
        /// Length of the shorter side, metres; 0: unknown.
        width_m: f32,
        /// Direction of the longer side, radians clockwise from north, in [0, 2 pi).
        orientation_rad: f32,
        /// Standard deviation of the length, metres; 0: unknown.
        length_sigma_m: f32,
        /// Standard deviation of the width, metres; 0: unknown.
        width_sigma_m: f32,
        /// Standard deviation of the orientation, radians; 0: the orientation is unknown.
        orientation_sigma_rad: f32,
    }
}
