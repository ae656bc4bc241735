//! Movement of a target.

use crate::codes;
use crate::codes::bits;
use crate::layout::sample;

bits! {
    /// Bits of [`Movement::valid`].
    movement_bits: u8 {
        /// `acceleration_mps2` is known east and north.
        ACCELERATION = 1;
        /// `acceleration_mps2` is known upwards.
        VERTICAL_ACCELERATION = 1 << 1;
    }
}

sample! {
    /// Modes of movement of a target and its acceleration, as far as known.
    Movement, size 16 {
        /// Acceleration east, north, up, metres per second squared.
        acceleration_mps2: [f32; 3],
        /// Mode in the horizontal plane: a `HorizontalMovement` code.
        horizontal: u8,
        /// Mode in the vertical: a `VerticalMovement` code.
        vertical: u8,
        /// Mode along the track: a `LongitudinalMovement` code.
        longitudinal: u8,
        /// Components of the acceleration that are known: see `movement_bits`.
        valid: u8,
    }
}

codes! {
    /// Horizontal mode of movement.
    pub enum HorizontalMovement: u8, default Unknown {
        /// Not known.
        Unknown = 0, "unknown";
        /// Constant course.
        Straight = 1, "straight";
        /// Turn to the left.
        TurnLeft = 2, "turn-left";
        /// Turn to the right.
        TurnRight = 3, "turn-right";
    }
}

codes! {
    /// Vertical mode of movement.
    pub enum VerticalMovement: u8, default Unknown {
        /// Not known.
        Unknown = 0, "unknown";
        /// Constant height.
        Level = 1, "level";
        /// Climb.
        Climb = 2, "climb";
        /// Descent.
        Descend = 3, "descend";
    }
}

codes! {
    /// Mode of movement along the track.
    pub enum LongitudinalMovement: u8, default Unknown {
        /// Not known.
        Unknown = 0, "unknown";
        /// Constant speed over ground.
        Constant = 1, "constant";
        /// Increasing speed over ground.
        Increasing = 2, "increasing";
        /// Decreasing speed over ground.
        Decreasing = 3, "decreasing";
    }
}
