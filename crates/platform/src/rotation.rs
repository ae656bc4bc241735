//! Rotations from a platform's axes to the system frame, and the derivatives by the angles.
//!
//! A platform's axes are right, forward, up: with all angles zero, these are east, north, up. Heading, pitch and roll
//! are applied from the inside outward as roll, pitch, heading: R = Z(heading)·X(pitch)·Y(roll).

/// Matrix by rows.
pub(crate) type Matrix = [[f64; 3]; 3];

/// No rotation.
pub(crate) const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Attitude of a body, radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Direction of the nose, clockwise from north.
    pub heading_rad: f64,
    /// Nose above the horizon.
    pub pitch_rad: f64,
    /// Right side below the horizon.
    pub roll_rad: f64,
}

impl Attitude {
    /// The attitude of angles in the order heading (or yaw), pitch, roll.
    pub fn of([heading_rad, pitch_rad, roll_rad]: [f64; 3]) -> Self {
        Self {
            heading_rad,
            pitch_rad,
            roll_rad,
        }
    }

    /// Rotation from the body's axes (right, forward, up) to east, north, up.
    pub(crate) fn rotation(&self) -> Matrix {
        let [z, x, y] = self.factors();
        product(&product(&z, &x), &y)
    }

    /// Derivatives of the rotation by heading, pitch and roll.
    pub(crate) fn derivatives(&self) -> [Matrix; 3] {
        let [z, x, y] = self.factors();
        let (sh, ch) = self.heading_rad.sin_cos();
        let (sp, cp) = self.pitch_rad.sin_cos();
        let (sr, cr) = self.roll_rad.sin_cos();
        let dz = [[-sh, ch, 0.0], [-ch, -sh, 0.0], [0.0; 3]];
        let dx = [[0.0; 3], [0.0, -sp, -cp], [0.0, cp, -sp]];
        let dy = [[-sr, 0.0, cr], [0.0; 3], [-cr, 0.0, -sr]];
        [
            product(&product(&dz, &x), &y),
            product(&product(&z, &dx), &y),
            product(&product(&z, &x), &dy),
        ]
    }

    /// A vector of the body's axes (right, forward, up) towards east, north, up.
    pub fn to_world(&self, vector: [f64; 3]) -> [f64; 3] {
        times(&self.rotation(), vector)
    }

    /// A vector towards east, north, up along the body's axes (right, forward, up).
    pub fn to_body(&self, vector: [f64; 3]) -> [f64; 3] {
        let rotation = self.rotation();
        std::array::from_fn(|column| (0..3).map(|row| rotation[row][column] * vector[row]).sum())
    }

    /// The same attitude seen from other axes: `axes` has the axes of the present frame in the other, by rows.
    pub fn seen_from(&self, axes: &[[f64; 3]; 3]) -> Self {
        let turned = product(axes, &self.rotation());
        // The columns are right, forward, up.
        let forward = [turned[0][1], turned[1][1], turned[2][1]];
        Self {
            heading_rad: forward[0].atan2(forward[1]),
            pitch_rad: forward[2].atan2(forward[0].hypot(forward[1])),
            roll_rad: (-turned[2][0]).atan2(turned[2][2]),
        }
    }

    fn factors(&self) -> [Matrix; 3] {
        let (sh, ch) = self.heading_rad.sin_cos();
        let (sp, cp) = self.pitch_rad.sin_cos();
        let (sr, cr) = self.roll_rad.sin_cos();
        [
            [[ch, sh, 0.0], [-sh, ch, 0.0], [0.0, 0.0, 1.0]],
            [[1.0, 0.0, 0.0], [0.0, cp, -sp], [0.0, sp, cp]],
            [[cr, 0.0, sr], [0.0, 1.0, 0.0], [-sr, 0.0, cr]],
        ]
    }
}

pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| (0..3).map(|k| a[row][k] * b[k][column]).sum()))
}

pub(crate) fn times(a: &Matrix, vector: [f64; 3]) -> [f64; 3] {
    a.map(|row| dot(row, vector))
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

pub(crate) fn scaled(a: [f64; 3], factor: f64) -> [f64; 3] {
    a.map(|value| value * factor)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use proptest::prelude::*;

    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn each_angle_turns_as_a_navigator_reads_it() {
        let turned = |angles, axis| times(&Attitude::of(angles).rotation(), axis);
        let [right, forward] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        // Heading east: the nose points east, the right side south.
        assert!(near(turned([FRAC_PI_2, 0.0, 0.0], forward), [1.0, 0.0, 0.0]));
        assert!(near(turned([FRAC_PI_2, 0.0, 0.0], right), [0.0, -1.0, 0.0]));
        // Pitch lifts the nose; roll lowers the right side.
        assert!(near(turned([0.0, FRAC_PI_2, 0.0], forward), [0.0, 0.0, 1.0]));
        assert!(near(turned([0.0, 0.0, FRAC_PI_2], right), [0.0, 0.0, -1.0]));
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_the_rotation(
            angles in (-3.0..3.0f64, -1.4..1.4f64, -3.0..3.0f64), place in 0usize..3,
        ) {
            let angles = [angles.0, angles.1, angles.2];
            let moved = |step: f64| {
                let mut moved = angles;
                moved[place] += step;
                Attitude::of(moved).rotation()
            };
            let (after, before) = (moved(1e-6), moved(-1e-6));
            let derivative = Attitude::of(angles).derivatives()[place];
            for row in 0..3 {
                for column in 0..3 {
                    let slope = (after[row][column] - before[row][column]) / 2e-6;
                    prop_assert!((slope - derivative[row][column]).abs() < 1e-8);
                }
            }
        }

        #[test]
        fn an_attitude_is_read_from_its_rotation(
            angles in (-3.0..3.0f64, -1.4..1.4f64, -3.0..3.0f64),
        ) {
            let attitude = Attitude::of([angles.0, angles.1, angles.2]);
            let again = attitude.seen_from(&IDENTITY);
            prop_assert!((again.heading_rad - attitude.heading_rad).abs() < 1e-9);
            prop_assert!((again.pitch_rad - attitude.pitch_rad).abs() < 1e-9);
            prop_assert!((again.roll_rad - attitude.roll_rad).abs() < 1e-9);
        }
    }
}
