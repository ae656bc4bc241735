//! The smoother of the vertical: the models of `vertical_filter`.

use estimation::{LinearModel, Moment, Smoother, Switching, Vertical};
use nalgebra::{Matrix1, Matrix2, Matrix3, Vector1, Vector2};

use super::knowledge::Knowledge;
use super::plane::PlaneSmoother;
use super::stretch::{Moment as Event, Stretch};
use crate::update::vertical_filter::{
    CHANGE_S, CLIMB_M2PS3, CLIMB_S, LEVEL_S, LEVELS_OFF, MODELS, PRIOR, REMAINDER_MPS, WANDER_M2PS,
};

/// Normalised innovation squared beyond which a height gets less weight.
const BLUNDER: f64 = 25.0;
/// As in the plane.
const STEPS_MAX: usize = 2048;
const STEPS_KEPT: usize = 512;
/// Standard deviation of the rate of climb at the beginning, m/s.
const RATE_MPS: f64 = 20.0;

/// A state with the probabilities of the models.
type VerticalState = (Vertical, [f32; MODELS]);

type Filter = Smoother<2, MODELS, 1>;

/// Smoother of the vertical.
pub(super) struct VerticalSmoother;

/// Filter of the vertical at a moment, to go on from, and the smoothed velocity in the plane there, m/s.
#[derive(Clone, Debug)]
pub(super) struct VerticalBase {
    filter: Filter,
    velocity_mps: [f64; 2],
}

impl VerticalSmoother {
    /// The state at each wanted time of a stretch, starting at `base` if given; `None` before the first measured
    /// height. Releases `done` moments: returns the filter after these moments, too.
    pub(super) fn smooth(
        known: &impl Knowledge,
        stretch: &Stretch,
        plane: &PlaneSmoother,
        (base, done): (Option<&VerticalBase>, usize),
    ) -> (Vec<Option<VerticalState>>, Option<VerticalBase>) {
        let mut states = Vec::new();
        let (mut filter, mut after_done) = (base.map(|base| base.filter.clone()), None);
        let mut before = 0;
        for (place, moment) in stretch.moments.iter().enumerate() {
            let heights = stretch.measured(moment).iter().filter(|measured| measured.axes > 2);
            let mut heights = heights.map(|measured| (measured.position_m[2], measured.covariance_m2[5]));
            let filter = match &mut filter {
                Some(filter) => {
                    let velocity_mps = match (place.checked_sub(1), base) {
                        (None, Some(base)) => base.velocity_mps,
                        (before, _) => plane.velocity_mps(before.unwrap_or_default()),
                    };
                    let motion = known.motion(velocity_mps);
                    filter.advance(switching(motion.climb_change_m2ps3, moment.passed_s));
                    filter
                }
                None => {
                    let Some((height_m, variance_m2)) = heights.next() else {
                        before += 1;
                        continue;
                    };
                    let begun = Moment {
                        mean: Vector2::new(height_m, 0.0),
                        covariance: Matrix2::new(variance_m2, 0.0, 0.0, RATE_MPS * RATE_MPS),
                    };
                    filter.insert(Smoother::new(begun, PRIOR))
                }
            };
            heights.for_each(|height| measure(filter, height));
            if place + 1 == done {
                after_done = Some(VerticalBase {
                    filter: filter.last_alone(),
                    velocity_mps: plane.velocity_mps(place),
                });
            }
            if filter.len() > STEPS_MAX {
                states.extend(filter.smooth(STEPS_KEPT));
            }
        }
        if let Some(filter) = &mut filter {
            states.extend(filter.smooth(0));
        }
        if base.is_some() {
            // The base itself is the first step.
            states.remove(0);
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
        let wanted = stretch.moments.iter().enumerate().filter_map(wanted).collect();
        (wanted, after_done)
    }
}

fn measure(filter: &mut Filter, (height_m, variance_m2): (f64, f64)) {
    let (expected, spread) = filter.expected();
    let residual_m = height_m - expected[0];
    let squared = residual_m * residual_m / (spread[0] + variance_m2);
    let factor = if squared > BLUNDER { squared / BLUNDER } else { 1.0 };
    // An unusable height leaves the state unchanged.
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
