//! The smoother of the vertical: the models of `vertical_filter`.

use estimation::{LinearModel, Moment, Smoother, Switching, Vertical};
use nalgebra::{Matrix1, Matrix2, Matrix3, Vector1, Vector2};

use super::plane::PlaneSmoother;
use super::stretch::{Moment as Event, Stretch};
use crate::Engine;
use crate::vertical_filter::{
    CHANGE_S, CLIMB_M2PS3, CLIMB_S, LEVEL_S, LEVELS_OFF, MODELS, PRIOR, REMAINDER_MPS, WANDER_M2PS,
};

/// Normalised innovation squared beyond which a height is weighed down.
const BLUNDER: f64 = 25.0;
/// As in the plane.
const STEPS_MAX: usize = 2048;
const STEPS_KEPT: usize = 512;
/// Standard deviation of the rate of climb at the beginning, m/s.
const RATE_MPS: f64 = 20.0;

/// A state with the probabilities of the models.
type VerticalState = (Vertical, [f32; MODELS]);

/// Smoother of the vertical.
pub(super) struct VerticalSmoother;

impl VerticalSmoother {
    /// The state at each wanted time of a stretch; `None` before a height is measured.
    pub(super) fn smooth(engine: &Engine, stretch: &Stretch, plane: &PlaneSmoother) -> Vec<Option<VerticalState>> {
        let mut states = Vec::new();
        let mut filter: Option<Smoother<2, MODELS, 1>> = None;
        let mut before = 0;
        for (place, moment) in stretch.moments.iter().enumerate() {
            let heights = stretch.measured(moment).iter().filter(|measured| measured.axes > 2);
            let heights = heights.map(|measured| (measured.position_m[2], measured.covariance_m2[5]));
            match &mut filter {
                Some(filter) => {
                    let [vx, vy] = plane.velocity_mps(place - 1);
                    let motion = engine.sources.manoeuvres.motion([vx, vy, 0.0]);
                    filter.advance(switching(motion.climb_change_m2ps3, moment.passed_s));
                    heights.for_each(|height| measure(filter, height));
                }
                None => {
                    let mut heights = heights;
                    let Some((height_m, variance_m2)) = heights.next() else {
                        before += 1;
                        continue;
                    };
                    let begun = Moment {
                        mean: Vector2::new(height_m, 0.0),
                        covariance: Matrix2::new(variance_m2, 0.0, 0.0, RATE_MPS * RATE_MPS),
                    };
                    let filter = filter.insert(Smoother::new(begun, PRIOR));
                    heights.for_each(|height| measure(filter, height));
                }
            }
            if let Some(filter) = filter.as_mut().filter(|filter| filter.len() > STEPS_MAX) {
                states.extend(filter.smooth(STEPS_KEPT));
            }
        }
        if let Some(filter) = &mut filter {
            states.extend(filter.smooth(0));
        }
        let wanted = |(place, moment): (usize, &Event)| {
            moment.is_wanted.then(|| {
                let smoothed = states.get(place.checked_sub(before)?)?;
                let covariance = &smoothed.state.covariance;
                let vertical = Vertical {
                    mean: smoothed.state.mean.into(),
                    covariance: [covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]],
                };
                Some((vertical, smoothed.probability.map(|value| value as f32)))
            })
        };
        stretch.moments.iter().enumerate().filter_map(wanted).collect()
    }
}

fn measure(filter: &mut Smoother<2, MODELS, 1>, (height_m, variance_m2): (f64, f64)) {
    let (expected, spread) = filter.expected();
    let residual_m = height_m - expected[0];
    let squared = residual_m * residual_m / (spread[0] + variance_m2);
    let factor = if squared > BLUNDER { squared / BLUNDER } else { 1.0 };
    // A height that cannot be used leaves the state as it is.
    let _ = filter.update(&Vector1::new(height_m), &Matrix1::new(variance_m2 * factor));
}

/// The models over `t` seconds, and the probabilities of switches.
fn switching(climb_change_m2ps3: f64, t: f64) -> Switching<2, MODELS> {
    let climbing = |density: f64| LinearModel {
        transition: Matrix2::new(1.0, t, 0.0, 1.0),
        noise: Matrix2::new(t * t * t / 3.0, 0.5 * t * t, 0.5 * t * t, t) * density,
    };
    // In level flight nothing is left of the rate.
    let level = LinearModel {
        transition: Matrix2::new(1.0, 0.0, 0.0, 0.0),
        noise: Matrix2::new(WANDER_M2PS * t, 0.0, 0.0, REMAINDER_MPS * REMAINDER_MPS),
    };
    let [level_ends, climb_ends, change_ends] = [LEVEL_S, CLIMB_S, CHANGE_S].map(|duration| t / (t + duration));
    Switching {
        models: [level, climbing(CLIMB_M2PS3), climbing(climb_change_m2ps3)],
        switches: Matrix3::new(
            1.0 - level_ends,
            0.0,
            level_ends,
            0.0,
            1.0 - climb_ends,
            climb_ends,
            change_ends * LEVELS_OFF,
            change_ends * (1.0 - LEVELS_OFF),
            1.0 - change_ends,
        ),
    }
}
