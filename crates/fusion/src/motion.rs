//! Motion: how the targets of a class move, as the filter assumes it.

use estimation::NearlyConstantVelocity;
use kept::kept;
use serde::{Deserialize, Serialize};

/// Time that it takes to notice a turn, seconds.
const UNNOTICED_S: f64 = 7.0;

kept! {
    /// Model of how the targets of a class move.
    #[derive(Clone, Copy, Debug, Serialize, Deserialize)]
    pub(crate) struct Motion {
        /// Process noise of turns.
        pub(crate) turns: NearlyConstantVelocity,
        /// Mean time for which a target flies straight before it turns, s.
        pub(crate) steady_s: f64,
    }
}

impl Motion {
    /// Variance per axis of a velocity caused by turns not yet detected, m²/s².
    pub(crate) fn unnoticed_m2ps2(&self) -> f64 {
        let share = UNNOTICED_S / self.steady_s;
        0.5 * share * UNNOTICED_S * self.turns.density_m2ps3[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_that_nobody_has_noticed_matter_as_often_as_they_are() {
        let motion = |steady_s| Motion {
            turns: NearlyConstantVelocity::new(50.0, 50.0),
            steady_s,
        };
        assert!((motion(245.0).unnoticed_m2ps2() - 5.0).abs() < 1e-9);
        assert!((motion(490.0).unnoticed_m2ps2() - 2.5).abs() < 1e-9);
    }
}
