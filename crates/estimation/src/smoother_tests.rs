//! The smoother, against worked examples and against batch solutions.

use nalgebra::{DMatrix, DVector, Matrix1, Matrix2, Matrix4, SMatrix, Vector1, Vector2, Vector4};
use proptest::prelude::*;

use crate::smoother::{Smoothed, Smoother};
use crate::{LinearModel, Moment, Switching};

/// One model with nearly constant velocity on two axes.
fn straight(seconds: f64, density: f64) -> LinearModel<4> {
    let t = seconds;
    let [first, second, third] = [t, 0.5 * t * t, t * t * t / 3.0].map(|value| value * density);
    let mut model = LinearModel {
        transition: Matrix4::identity(),
        noise: Matrix4::zeros(),
    };
    for axis in 0..2 {
        model.transition[(axis, axis + 2)] = t;
        model.noise[(axis, axis)] = third;
        model.noise[(axis, axis + 2)] = second;
        model.noise[(axis + 2, axis)] = second;
        model.noise[(axis + 2, axis + 2)] = first;
    }
    model
}

fn alone<const N: usize>(model: LinearModel<N>) -> Switching<N, 1> {
    Switching {
        models: [model],
        switches: Matrix1::identity(),
    }
}

#[test]
fn a_random_walk_by_hand() {
    // x₀ ~ N(0, 1); steps of variance 1; measurements 3 and 2 of variance 2 after the first and second step.
    let walk = || {
        alone(LinearModel {
            transition: Matrix1::new(1.0),
            noise: Matrix1::new(1.0),
        })
    };
    let begun = Moment {
        mean: Vector1::new(0.0),
        covariance: Matrix1::new(1.0),
    };
    let mut smoother: Smoother<1, 1, 1> = Smoother::new(begun, [1.0]);
    for (measured, filtered) in [(3.0, 1.5), (2.0, 1.75)] {
        smoother.advance(walk());
        smoother.update(&Vector1::new(measured), &Matrix1::new(2.0)).unwrap();
        // Predicted variance 2, gain 1/2.
        let state = smoother.filtered();
        assert!((state.mean[0] - filtered).abs() < 1e-12 && (state.covariance[0] - 1.0).abs() < 1e-12);
    }
    // Gain of the way back 1/2: 1.5 + (1.75 − 1.5)/2, 0 + (1.625 − 0)/2; 1 + (1 − 2)/4, 1 + (0.75 − 2)/4.
    let expected = [(0.8125, 0.6875), (1.625, 0.75), (1.75, 1.0)];
    for (smoothed, (mean, variance)) in smoother.smooth(0).iter().zip(expected) {
        let state = &smoothed.state;
        assert!((state.mean[0] - mean).abs() < 1e-12, "{state:?}");
        assert!((state.covariance[0] - variance).abs() < 1e-12, "{state:?}");
    }
}

/// Steps of a target on a plane: duration, measured place, standard deviation; `None` without a measurement.
type Steps = Vec<(f64, Option<([f64; 2], f64)>)>;

fn any_steps() -> impl Strategy<Value = Steps> {
    let place = (prop::array::uniform2(-1e3..1e3f64), 1.0..100.0f64);
    prop::collection::vec((0.1..8.0f64, prop::option::of(place)), 1..7)
}

fn begun() -> Moment<4> {
    Moment {
        mean: Vector4::new(100.0, -50.0, 30.0, 10.0),
        covariance: Matrix4::from_diagonal(&Vector4::new(900.0, 400.0, 100.0, 225.0)),
    }
}

fn run(steps: &Steps, density: f64) -> Smoother<4, 1, 2> {
    let mut smoother = Smoother::new(begun(), [1.0]);
    for (seconds, measured) in steps {
        smoother.advance(alone(straight(*seconds, density)));
        if let Some((place, sigma)) = measured {
            let r = Matrix2::identity() * (sigma * sigma);
            smoother.update(&Vector2::from(*place), &r).unwrap();
        }
    }
    smoother
}

/// All states at once by weighted least squares: the normal equations of prior, motion and measurements.
fn batch(steps: &Steps, density: f64) -> (DVector<f64>, DMatrix<f64>) {
    let size = 4 * (steps.len() + 1);
    let (mut information, mut vector) = (DMatrix::zeros(size, size), DVector::zeros(size));
    let prior = begun();
    let inverse = prior.covariance.try_inverse().unwrap();
    information.view_mut((0, 0), (4, 4)).copy_from(&inverse);
    vector.rows_mut(0, 4).copy_from(&(inverse * prior.mean));
    for (place, (seconds, measured)) in steps.iter().enumerate() {
        let model = straight(*seconds, density);
        let weight = model.noise.try_inverse().unwrap();
        let mut rows = SMatrix::<f64, 4, 8>::zeros();
        rows.fixed_view_mut::<4, 4>(0, 0).copy_from(&-model.transition);
        rows.fixed_view_mut::<4, 4>(0, 4).copy_from(&Matrix4::identity());
        let mut block = information.view_mut((4 * place, 4 * place), (8, 8));
        block += rows.transpose() * weight * rows;
        if let Some((measured, sigma)) = measured {
            for (axis, measured) in measured.iter().enumerate() {
                let at = 4 * (place + 1) + axis;
                information[(at, at)] += 1.0 / (sigma * sigma);
                vector[at] += measured / (sigma * sigma);
            }
        }
    }
    let covariance = information.try_inverse().unwrap();
    (&covariance * vector, covariance)
}

proptest! {
    #[test]
    fn with_one_model_it_is_the_solution_by_least_squares(steps in any_steps(), density in 0.5..50.0f64) {
        let (means, covariance) = batch(&steps, density);
        let smoothed = run(&steps, density).smooth(0);
        prop_assert_eq!(smoothed.len(), steps.len() + 1);
        for (place, Smoothed { state, .. }) in smoothed.iter().enumerate() {
            for row in 0..4 {
                let at = 4 * place + row;
                let sigma = covariance[(at, at)].sqrt();
                prop_assert!((state.mean[row] - means[at]).abs() < 1e-4 * sigma, "{place} {row} {state:?} {}", means[at]);
                for column in 0..4 {
                    let found = state.covariance[(row, column)] - covariance[(at, 4 * place + column)];
                    let scale = sigma * covariance[(4 * place + column, 4 * place + column)].sqrt();
                    prop_assert!(found.abs() < 1e-4 * scale, "{place} {row} {column}: {found}");
                }
            }
        }
    }

    #[test]
    fn smoothed_states_are_never_less_certain_than_filtered_ones(steps in any_steps(), density in 0.0..50.0f64) {
        let smoothed = run(&steps, density).smooth(0);
        for (place, after) in smoothed.iter().enumerate() {
            let filtered = run(&steps[..place].to_vec(), density).filtered();
            let gained = filtered.covariance - after.state.covariance;
            let scale = Matrix4::from_diagonal(&filtered.covariance.diagonal().map(|value| 1.0 / value.sqrt()));
            let least = (scale * gained * scale).symmetric_eigenvalues().min();
            prop_assert!(least > -1e-6, "{place}: {least}");
        }
    }

    #[test]
    fn giving_up_the_first_steps_loses_nothing_but_the_future(steps in any_steps(), keep in 0usize..4) {
        let all = run(&steps, 5.0).smooth(0);
        let mut smoother = run(&steps, 5.0);
        let mut parts = smoother.smooth(keep);
        prop_assert_eq!(smoother.len(), keep.min(steps.len() + 1));
        if !parts.is_empty() && keep > 0 {
            parts.extend(smoother.smooth(0));
        }
        for (one, other) in parts.iter().zip(&all) {
            prop_assert!((one.state.mean - other.state.mean).norm() < 1e-6);
        }
    }
}

/// A target on a line that stands, runs for a while, and stands: which of the two it does is a model each.
#[test]
fn a_switch_is_found_where_it_was() {
    let standing = LinearModel {
        transition: Matrix2::new(1.0, 0.0, 0.0, 0.0),
        noise: Matrix2::new(0.01, 0.0, 0.0, 0.01),
    };
    let running = LinearModel {
        transition: Matrix2::new(1.0, 1.0, 0.0, 1.0),
        noise: Matrix2::new(10.0, 15.0, 15.0, 30.0),
    };
    let motion = Switching {
        models: [standing, running],
        switches: Matrix2::new(0.97, 0.03, 0.1, 0.9),
    };
    let begun = Moment {
        mean: Vector2::new(0.0, 0.0),
        covariance: Matrix2::new(100.0, 0.0, 0.0, 1.0),
    };
    let place = |second: usize| 8.0 * (second.clamp(20, 40) - 20) as f64;
    let error = |second: usize| 12.0 * ((second * 7919 % 101) as f64 / 50.0 - 1.0);
    let mut smoother: Smoother<2, 2, 1> = Smoother::new(begun, [0.9, 0.1]);
    let mut filtered = vec![smoother.filtered()];
    for second in 1..60 {
        smoother.advance(motion);
        smoother
            .update(&Vector1::new(place(second) + error(second)), &Matrix1::new(49.0))
            .unwrap();
        filtered.push(smoother.filtered());
    }
    let smoothed = smoother.smooth(0);
    let square = |states: &mut dyn Iterator<Item = f64>| {
        states
            .enumerate()
            .map(|(second, found)| (found - place(second)).powi(2))
            .sum::<f64>()
    };
    let before = square(&mut filtered.iter().map(|state| state.mean[0]));
    let after = square(&mut smoothed.iter().map(|smoothed| smoothed.state.mean[0]));
    assert!(after < 0.5 * before, "{after} {before}");
    for second in [5, 12, 48, 55] {
        assert!(
            smoothed[second].probability[0] > 0.9,
            "{second}: {:?}",
            smoothed[second].probability
        );
    }
    for smoothed in &smoothed[24..37] {
        assert!(smoothed.probability[1] > 0.9, "{:?}", smoothed.probability);
    }
}

#[test]
fn a_measurement_that_is_no_number_changes_nothing() {
    let mut smoother = run(&vec![(1.0, Some(([100.0, 0.0], 20.0)))], 1.0);
    let before = smoother.filtered();
    assert!(
        smoother
            .update(&Vector2::new(f64::NAN, 0.0), &Matrix2::identity())
            .is_none()
    );
    assert!(
        smoother
            .update(&Vector2::zeros(), &(Matrix2::identity() * -1e9))
            .is_none()
    );
    assert_eq!(smoother.filtered(), before);
}
