//! Steps that innovations show, and what is none.

use test_support::Random;

use super::*;
use crate::registration::errors::prior_variances;

const SIGMA_M: f64 = 40.0;
const TARGETS: u32 = 20;

/// Innovations of the sources, one per target and tick.
struct Innovations {
    search: StepSearch,
    random: Random,
}

impl Innovations {
    fn of(sources: usize) -> Self {
        Self {
            search: StepSearch::new(sources),
            random: Random::new(7),
        }
    }

    /// Adds those of `ticks` ticks, with these errors by source and position; returns the first step found.
    fn pass(&mut self, ticks: u32, error_m: impl Fn(usize, [f64; 2], &mut Random) -> [f64; 2]) -> Option<Step> {
        (0..ticks).find_map(|_| {
            for source in 0..self.search.sums.len() {
                for target in 0..TARGETS {
                    let position_m = [f64::from(target % 5) * 20e3 - 40e3, f64::from(target / 5) * 20e3 - 30e3];
                    let error_m = error_m(source, position_m, &mut self.random);
                    let residual_m = error_m.map(|error| error + SIGMA_M * self.normal());
                    let covariance_m2 = [SIGMA_M * SIGMA_M, 0.0, SIGMA_M * SIGMA_M];
                    self.search
                        .add(source, (residual_m, covariance_m2), (target, position_m));
                }
            }
            self.search.look(0.0, |_| true)
        })
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.random.unit()).sum::<f64>() - 6.0
    }
}

fn turned(angle_rad: f64, [east, north]: [f64; 2]) -> [f64; 2] {
    [angle_rad * north, -angle_rad * east]
}

fn known(offset_m: [f64; 2], model: BiasModel) -> SourceErrors {
    let mut known = SourceErrors::unknown();
    (known.errors[0], known.errors[1]) = (offset_m[0], offset_m[1]);
    known.variances = prior_variances().map(|variance| 1e-4 * variance);
    (known.removed[0], known.removed[1]) = (true, true);
    known.model = model;
    known
}

#[test]
fn a_step_of_one_among_three_is_found_within_three_ticks_and_is_its_own() {
    for culprit in 0..3 {
        let mut innovations = Innovations::of(3);
        assert_eq!(innovations.pass(300, |_, _, _| [0.0; 2]), None);
        // The filters absorb a third of it.
        let share = |source: usize| if source == culprit { 0.67 } else { -0.33 };
        let step = innovations
            .pass(3, |source, _, _| [80.0 * share(source), -60.0 * share(source)])
            .unwrap();
        assert_eq!(step.source, culprit);
        assert!(!step.turns, "{step:?}");
        assert!(
            (step.by.x - 80.0).abs() < 40.0 && (step.by.y + 60.0).abs() < 40.0,
            "{step:?}"
        );
    }
}

#[test]
fn a_rotation_is_told_from_an_offset() {
    let mut innovations = Innovations::of(3);
    assert_eq!(innovations.pass(20, |_, _, _| [0.0; 2]), None);
    let error_m = |source: usize, position_m: [f64; 2], _: &mut Random| match source {
        1 => turned(0.01, [position_m[0] - 50e3, position_m[1]]),
        _ => [0.0; 2],
    };
    let step = innovations.pass(3, error_m).unwrap();
    assert!(step.source == 1 && step.turns, "{step:?}");
    let (seed, model) = Seed::of(&step, &known([0.0; 2], BiasModel::OFFSET), None, Some([50e3, 0.0]));
    assert_eq!(model, BiasModel::TURNED);
    // About the sensor it is a rotation alone.
    let mut normal = seed.normal;
    (0..ERRORS).for_each(|row| normal[(row, row)] += 1e-12);
    let errors = normal.cholesky().unwrap().solve(&seed.right);
    assert!((errors[AZIMUTH] - 0.01).abs() < 1e-3, "{errors:?}");
    assert!(errors[0].abs() < 60.0 && errors[1].abs() < 60.0, "{errors:?}");
}

#[test]
fn what_all_sources_have_in_common_is_no_step_and_two_are_not_told_apart() {
    let mut innovations = Innovations::of(3);
    assert_eq!(innovations.pass(20, |_, _, _| [0.0; 2]), None);
    assert_eq!(innovations.pass(40, |_, _, _| [150.0, 0.0]), None);
    let mut two = Innovations::of(2);
    assert_eq!(two.pass(20, |_, _, _| [0.0; 2]), None);
    let halves = |source: usize, _: [f64; 2], _: &mut Random| [[150.0, 0.0], [-150.0, 0.0]][source];
    assert_eq!(two.pass(40, halves), None);
}

#[test]
fn absurd_innovations_and_larger_noise_are_no_step() {
    let mut innovations = Innovations::of(3);
    let absurd = |source: usize, _: [f64; 2], random: &mut Random| match source == 1 && random.unit() < 0.1 {
        true => [random.between(-900.0, 900.0), random.between(-900.0, 900.0)],
        false => [0.0; 2],
    };
    assert_eq!(innovations.pass(300, absurd), None);
    let noisy = |source: usize, _: [f64; 2], random: &mut Random| match source {
        1 => [random.between(-300.0, 300.0), random.between(-300.0, 300.0)],
        _ => [0.0; 2],
    };
    assert_eq!(Innovations::of(3).pass(300, noisy), None);
}

#[test]
fn the_former_estimate_is_taken_up_again_only_where_it_explains_the_step() {
    let step = |east_m: f64| Step {
        source: 1,
        by: Vector3::new(east_m, 0.0, 0.0),
        covariance: Matrix3::from_diagonal(&Vector3::new(100.0, 100.0, 0.0)),
        turns: false,
        is_beyond: false,
        is_further: false,
        targets: 20,
        found: 0,
        intervals: 1,
        length: 100.0,
        effect_m: east_m.abs(),
    };
    let before = known([150.0, 0.0], BiasModel::OFFSET);
    let former = FormerErrors::of(&known([4.0, -3.0], BiasModel::OFFSET));
    let (mended, _) = Seed::of(&step(-140.0), &before, Some(&former), None);
    assert!(
        (mended.right[0] / mended.normal[(0, 0)] - 4.0).abs() < 1e-9,
        "{mended:?}"
    );
    let (other, _) = Seed::of(&step(-450.0), &before, Some(&former), None);
    assert!(
        (other.right[0] / other.normal[(0, 0)] + 300.0).abs() < 1e-9,
        "{other:?}"
    );
}
