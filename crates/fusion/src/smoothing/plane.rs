//! The smoother of the plane: the models of `plane_filter`, all of them at all times.

use estimation::{LinearModel, Moment, Plane, Rotation, Smoothed, Smoother, Switching};
use nalgebra::{Matrix2, Matrix4, SMatrix, Vector2, Vector4};
use source_models::{LEVELS, MANOEUVRE_S, Motion};

use super::knowledge::{Knowledge, MotionFactors};
use super::stretch::{Moment as Event, Stretch};
use crate::update::plane_filter::{AGILE, HARDNESS, HOME, MODELS, STEADY};

/// Number of components.
const COMPONENTS: usize = 4;
/// Normalised innovation squared beyond which a measurement gets less weight.
const BLUNDER: f64 = 30.0;
/// Steps after which the first steps are smoothed, and number of steps kept then: later measurements hardly change
/// older states.
const STEPS_MAX: usize = 2048;
const STEPS_KEPT: usize = 512;
/// Speed above which a target has a rate of turn, m/s.
const MOVING_MPS: f64 = 3.0;
/// Probability of each model at the beginning, as in the filter: steady, agile, all turns.
const PRIOR: [f64; 3] = [0.86, 0.06, 0.08];

type Filter = Smoother<COMPONENTS, MODELS, 2>;

/// Smoothed states of a stretch, one state for each of its moments.
#[derive(Debug)]
pub(super) struct PlaneSmoother {
    states: Vec<Smoothed<COMPONENTS, MODELS>>,
    /// Place of each wanted state.
    wanted: Vec<usize>,
    /// Lateral accelerations of each class at each wanted state, m/s².
    lateral_mps2: Vec<[f64; LEVELS]>,
}

/// A smoothed state of the plane, in the form of messages.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaneState {
    pub(super) state: Plane,
    pub(super) modes: [f32; 5],
    pub(super) turn_rate: [f64; 2],
}

/// Filter of the plane at a moment, to go on from.
#[derive(Clone, Debug)]
pub(super) struct PlaneBase {
    filter: Filter,
    /// Smoothed velocity there, m/s.
    velocity_mps: [f64; 2],
}

impl PlaneSmoother {
    /// Smooths a stretch, starting at `base` if given. Releases `done` moments: returns the filter after these moments,
    /// for the next stretch.
    pub(super) fn smooth(
        known: &impl Knowledge,
        stretch: &Stretch,
        base: Option<&PlaneBase>,
        done: usize,
    ) -> (Self, Option<PlaneBase>) {
        // Speed and course, the parameters of the models, come first from the filter, then from the smoothed states.
        let (first, _) = run(known, stretch, (base, done), None);
        let (states, filter) = run(known, stretch, (base, done), Some(&first));
        let wanted = (0..stretch.moments.len()).filter(|place| stretch.moments[*place].is_wanted);
        let wanted: Vec<usize> = wanted.collect();
        let lateral_mps2 = wanted
            .iter()
            .map(|place| known.motion(velocity(&states[*place].state)).lateral_mps2)
            .collect();
        let next = filter.map(|filter| PlaneBase {
            filter,
            velocity_mps: velocity(&states[done - 1].state),
        });
        let smoother = Self {
            states,
            wanted,
            lateral_mps2,
        };
        (smoother, next)
    }

    /// Smoothed velocity at a moment, east and north, m/s.
    pub(super) fn velocity_mps(&self, moment: usize) -> [f64; 2] {
        velocity(&self.states[moment].state)
    }

    /// The state at the wanted time with this place in the order of time.
    pub(super) fn wanted(&self, stretch: &Stretch, place: usize) -> Option<PlaneState> {
        debug_assert_eq!(stretch.moments.len(), self.states.len());
        let smoothed = &self.states[*self.wanted.get(place)?];
        let lateral_mps2 = self.lateral_mps2.get(place)?;
        let probability = &smoothed.probability;
        let mut modes = [probability[STEADY], probability[AGILE], 0.0, 0.0, 0.0];
        let (mut left_mps2, mut square) = (0.0, 0.0);
        for (pair, lateral_mps2) in probability[AGILE + 1..].chunks_exact(2).zip(lateral_mps2) {
            modes[2] += pair[0];
            modes[3] += pair[1];
            left_mps2 += (pair[0] - pair[1]) * lateral_mps2;
            square += (pair[0] + pair[1]) * lateral_mps2 * lateral_mps2;
        }
        let [vx, vy] = velocity(&smoothed.state);
        let speed_mps = vx.hypot(vy);
        let sigma_mps2 = (square - left_mps2 * left_mps2).max(0.0).sqrt();
        let turn_rate = match speed_mps > MOVING_MPS {
            true => [
                -left_mps2 / speed_mps,
                (sigma_mps2 / speed_mps).max(f64::from(f32::MIN_POSITIVE)),
            ],
            false => [0.0; 2],
        };
        Some(PlaneState {
            state: plane_of(&smoothed.state),
            modes: modes.map(|value| value as f32),
            turn_rate,
        })
    }
}

/// A pass forwards and backwards; `smoothed` are the states of the previous pass. Returns the states, and the filter
/// after `done` moments.
fn run(
    known: &impl Knowledge,
    stretch: &Stretch,
    (base, done): (Option<&PlaneBase>, usize),
    smoothed: Option<&[Smoothed<COMPONENTS, MODELS>]>,
) -> (Vec<Smoothed<COMPONENTS, MODELS>>, Option<Filter>) {
    let mut states = Vec::with_capacity(stretch.moments.len() + 1);
    let (mut filter, mut after_done) = (base.map(|base| base.filter.clone()), None);
    for (place, moment) in stretch.moments.iter().enumerate() {
        let begins = filter.is_none();
        let filter = match &mut filter {
            Some(filter) => {
                let velocity_mps = match (smoothed, place.checked_sub(1), base) {
                    (Some(smoothed), Some(before), _) => velocity(&smoothed[before].state),
                    (Some(_), None, Some(base)) => base.velocity_mps,
                    _ => filtered_velocity(filter),
                };
                filter.advance(switching(
                    (known.motion(velocity_mps), known.factors()),
                    velocity_mps,
                    moment.passed_s,
                ));
                filter
            }
            None => filter.insert(begun(stretch)),
        };
        measure(filter, stretch, moment, begins);
        if place + 1 == done {
            after_done = Some(filter.last_alone());
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
    (states, after_done)
}

/// Logarithm of the likelihood of the measurements of a stretch.
pub(super) fn evidence(known: &impl Knowledge, stretch: &Stretch) -> f64 {
    let mut filter: Option<Filter> = None;
    for (place, moment) in stretch.moments.iter().enumerate() {
        filter = Some(match filter {
            Some(mut filter) => {
                let velocity_mps = filtered_velocity(&filter);
                filter.advance(switching(
                    (known.motion(velocity_mps), known.factors()),
                    velocity_mps,
                    moment.passed_s,
                ));
                filter.forget();
                filter
            }
            None => begun(stretch),
        });
        if let Some(filter) = &mut filter {
            measure(filter, stretch, moment, place == 0);
        }
    }
    filter.map_or(0.0, |filter| filter.evidence())
}

/// The state of the first measurement.
fn begun(stretch: &Stretch) -> Filter {
    let first = &stretch.measurements[0];
    let ([x, y, _], [xx, xy, _, yy, ..]) = (first.position_m, first.covariance_m2);
    let [vx, vy, _] = stretch.velocity_mps;
    let [uu, vv, _] = stretch.velocity_m2ps2;
    let mut covariance = Matrix4::from_diagonal(&Vector4::new(xx, yy, uu, vv));
    covariance[(0, 1)] = xy;
    covariance[(1, 0)] = xy;
    let state = Moment {
        mean: Vector4::new(x, y, vx, vy),
        covariance,
    };
    let [steady, agile, turns] = PRIOR;
    let probability = std::array::from_fn(|model| match model {
        STEADY => steady,
        AGILE => agile,
        turn => 0.5 * turns * HARDNESS[turn / 2 - 1],
    });
    Smoother::new(state, probability)
}

/// Updates with the measurements of a moment; the state itself is the first of all.
fn measure(filter: &mut Filter, stretch: &Stretch, moment: &Event, is_first: bool) {
    for measurement in &stretch.measured(moment)[usize::from(is_first)..] {
        let [x, y, _] = measurement.position_m;
        let [xx, xy, _, yy, ..] = measurement.covariance_m2;
        let (z, mut r) = (Vector2::new(x, y), Matrix2::new(xx, xy, xy, yy));
        let (expected, spread) = filter.expected();
        let residual = z - expected;
        if let Some(inverse) = (spread + r).try_inverse() {
            let squared = residual.dot(&(inverse * residual));
            if squared > BLUNDER {
                r *= squared / BLUNDER;
            }
        }
        // An unusable measurement leaves the state unchanged.
        let _ = filter.update(&z, &r);
    }
}

fn filtered_velocity(filter: &Filter) -> [f64; 2] {
    let mean = filter.mean();
    [mean[2], mean[3]]
}

fn velocity(state: &Moment<COMPONENTS>) -> [f64; 2] {
    [state.mean[2], state.mean[3]]
}

/// The models over `seconds` for a target with this velocity, and the probabilities of switches.
fn switching(
    (motion, factors): (&Motion, MotionFactors),
    [vx, vy]: [f64; 2],
    seconds: f64,
) -> Switching<COMPONENTS, MODELS> {
    let square = vx * vx + vy * vy;
    let straight = Rotation::new(0.0, seconds);
    let [along, across] = motion.agile_m2ps3(seconds);
    let agile = if square > motion.slow_mps * motion.slow_mps {
        let (excess, inverse) = (along - across, 1.0 / square);
        let [xx, xy, yy] = [vx * vx, vx * vy, vy * vy].map(|value| excess * value * inverse);
        [across + xx, xy, across + yy]
    } else {
        [along, 0.0, along]
    };
    let speed_mps = square.sqrt().max(motion.slow_mps);
    let models = std::array::from_fn(|model| match model {
        STEADY => model_of(&straight, evenly(factors.steady * motion.steady_m2ps3()), seconds),
        AGILE => model_of(&straight, agile, seconds),
        turn => {
            let lateral_mps2 = motion.lateral_mps2[turn / 2 - 1];
            let left = Rotation::new(lateral_mps2 / speed_mps, seconds);
            let rotation = if turn % 2 == 0 { left } else { left.mirrored() };
            model_of(&rotation, evenly(Motion::turn_m2ps3(lateral_mps2, seconds)), seconds)
        }
    });
    Switching {
        models,
        switches: switches(motion, factors.straight * motion.steady_s, seconds),
    }
}

fn evenly(density_m2ps3: f64) -> [f64; 3] {
    [density_m2ps3, 0.0, density_m2ps3]
}

fn model_of(rotation: &Rotation, [xx, xy, yy]: [f64; 3], t: f64) -> LinearModel<COMPONENTS> {
    let rows = rotation.transition();
    let (first, second, third) = (t, 0.5 * t * t, t * t * t / 3.0);
    let density = Matrix2::new(xx, xy, xy, yy);
    let mut noise = Matrix4::zeros();
    noise.fixed_view_mut::<2, 2>(0, 0).copy_from(&(density * third));
    noise.fixed_view_mut::<2, 2>(0, 2).copy_from(&(density * second));
    noise.fixed_view_mut::<2, 2>(2, 0).copy_from(&(density * second));
    noise.fixed_view_mut::<2, 2>(2, 2).copy_from(&(density * first));
    LinearModel {
        transition: Matrix4::from_fn(|row, column| rows[row][column]),
        noise,
    }
}

/// Probabilities of switches in `seconds`, as in the filter: the mode after a manoeuvre does not depend on its kind.
fn switches(motion: &Motion, steady_s: f64, seconds: f64) -> SMatrix<f64, MODELS, MODELS> {
    let [begins, ends] = [steady_s, MANOEUVRE_S].map(|duration| seconds / (seconds + duration));
    let share = |model: usize| match model {
        STEADY => 0.0,
        AGILE => motion.agile_share,
        turn => 0.5 * (1.0 - motion.agile_share) * HARDNESS[turn / 2 - 1],
    };
    SMatrix::from_fn(|from, to| {
        let stays = if from == to { 1.0 } else { 0.0 };
        match (from, to) {
            (STEADY, STEADY) => 1.0 - begins,
            (STEADY, _) => begins * share(to),
            (_, STEADY) => ends * HOME,
            _ => stays * (1.0 - ends) + ends * (1.0 - HOME) * share(to),
        }
    })
}

fn plane_of(state: &Moment<COMPONENTS>) -> Plane {
    let mut covariance = [0.0; 10];
    let places = (0..COMPONENTS).flat_map(|row| (row..COMPONENTS).map(move |column| (row, column)));
    for (element, place) in covariance.iter_mut().zip(places) {
        *element = state.covariance[place];
    }
    Plane {
        mean: state.mean.into(),
        covariance,
    }
}
