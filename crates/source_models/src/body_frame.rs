//! Horizontal vectors in the frame of a target's course, given as the direction: sine and cosine from north.

/// A horizontal vector in the frame of a course: along, across to the right.
#[inline]
pub fn to_body([east, north]: [f64; 2], [sin, cos]: [f64; 2]) -> [f64; 2] {
    [east * sin + north * cos, east * cos - north * sin]
}

/// The inverse of [`to_body`].
#[inline]
pub fn from_body([along, across]: [f64; 2], [sin, cos]: [f64; 2]) -> [f64; 2] {
    [along * sin + across * cos, along * cos - across * sin]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn body_frame_and_back() {
        let course = [0.6, 0.8];
        let [along, across] = to_body([6.0, 8.0], course);
        assert!((along - 10.0).abs() < 1e-12 && across.abs() < 1e-12);
        let back = from_body(to_body([3.0, -7.0], course), course);
        assert!((back[0] - 3.0).abs() < 1e-12 && (back[1] + 7.0).abs() < 1e-12);
    }
}
