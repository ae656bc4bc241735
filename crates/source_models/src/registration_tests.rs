//! Systematic errors that are known, and are found.

use std::ops::Range;

use proptest::prelude::*;

use super::*;
use crate::registration::rows::{AZIMUTH, RANGE};

/// A deterministic stand-in for noise.
fn noise(index: u32, scale: f64) -> f64 {
    let mixed = index.wrapping_mul(2_654_435_761) ^ (index >> 3).wrapping_mul(0x9e37_79b9);
    (f64::from(mixed % 10_007) / 10_007.0 - 0.5) * 3.46 * scale
}

/// Completes a solution that has begun.
fn finish(registration: &mut Registration) {
    while registration.is_solving() {
        registration.step(&[], |_| {});
    }
}

fn view(source: u16, truth: [f64; 3], velocity: [f64; 3], offset: [f64; 2], late_s: f64, index: u32) -> TargetView {
    let place = |axis: usize| {
        truth[axis] + offset.get(axis).copied().unwrap_or(0.0) - late_s * velocity[axis]
            + noise(index * 31 + u32::from(source) * 7 + axis as u32, 20.0)
    };
    TargetView {
        source,
        position_m: std::array::from_fn(place),
        covariance_m2: [400.0, 0.0, 0.0, 400.0, 0.0, 400.0],
        velocity_mps: velocity,
        has_velocity: true,
        has_height: true,
        place_m: None,
    }
}

fn registered(reference: Option<u16>, offsets: [[f64; 2]; 3], late_s: [f64; 3]) -> Registration {
    registered_while(reference, 100, late_s, |source, _| offsets[usize::from(source)])
}

/// Registration after so many seconds, with the offset of each source at each second.
fn registered_while(
    reference: Option<u16>,
    seconds: u32,
    late_s: [f64; 3],
    offset_m: impl Fn(u16, u32) -> [f64; 2],
) -> Registration {
    let velocity = |target: u32| {
        let heading = f64::from(target) * 0.7;
        [200.0 * heading.sin(), 200.0 * heading.cos(), 0.0]
    };
    registered_in(velocity, reference, seconds, late_s, offset_m)
}

/// The same in traffic of which each target has this velocity.
fn registered_in(
    velocity: impl Fn(u32) -> [f64; 3],
    reference: Option<u16>,
    seconds: u32,
    late_s: [f64; 3],
    offset_m: impl Fn(u16, u32) -> [f64; 2],
) -> Registration {
    let registration = Registration::new(3, reference, 300.0, 1.0);
    continued_in(velocity, registration, seconds, late_s, offset_m)
}

/// The same from this registration on.
fn continued_in(
    velocity: impl Fn(u32) -> [f64; 3],
    mut registration: Registration,
    seconds: u32,
    late_s: [f64; 3],
    offset_m: impl Fn(u16, u32) -> [f64; 2],
) -> Registration {
    for second in 0..seconds {
        for target in 0..20u32 {
            let velocity = velocity(target);
            let truth = [f64::from(target) * 3000.0, f64::from(second) * 100.0, 5000.0];
            let of = |source: u16| {
                let (offset_m, late_s) = (offset_m(source, second), late_s[usize::from(source)]);
                view(source, truth, velocity, offset_m, late_s, second * 20 + target)
            };
            registration.learn(
                &of((target % 3) as u16),
                &of(((target + 1) % 3) as u16),
                0.0,
                (1e9, 1.0),
            );
        }
        registration.begin((0.0, 0.0), |_| {});
        finish(&mut registration);
        registration.decide(&[], |_| Some(0.0), 20, false);
    }
    registration
}

#[test]
fn offsets_relative_to_their_mean_are_found() {
    let registration = registered(None, [[0.0, 0.0], [60.0, 0.0], [30.0, 52.0]], [0.0; 3]);
    for (source, expected) in [[-30.0, -17.3], [30.0, -17.3], [0.0, 34.7]].into_iter().enumerate() {
        let known = registration.of(source as u16);
        for (axis, expected) in expected.into_iter().enumerate() {
            assert!((known.errors[axis] - expected).abs() < 3.0, "{source}: {known:?}");
            assert!(known.removed[axis], "{source}: {known:?}");
        }
        assert!(!known.removed[3], "no clock is wrong: {known:?}");
    }
}

#[test]
fn one_that_is_far_off_among_several_is_the_one() {
    let registration = registered(None, [[0.0, 0.0], [300.0, 0.0], [5.0, 0.0]], [0.0; 3]);
    assert!(
        (registration.of(1).errors[0] - 297.0).abs() < 5.0,
        "{:?}",
        registration.of(1)
    );
    assert!(
        [0, 2]
            .into_iter()
            .all(|source| registration.of(source).errors[0].abs() < 8.0)
    );
    assert_two_may_err(&registration, 300.0);
}

/// Two sources agree beside one that is `off_m` off: they err together with a probability of a quarter.
fn assert_two_may_err(registration: &Registration, off_m: f64) {
    let share = registration.common_offset_m2() / (0.5 * off_m * off_m);
    assert!((0.18..0.32).contains(&share), "{share}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// A time error explains an offset along the flight as well. Which of the two it is does not matter to the targets.
    #[test]
    fn in_parallel_traffic_as_in_any_other_one_that_is_far_off_moves_no_other(
        course in 0.0..6.3f64, bearing in 0.0..6.3f64, off_m in 60.0..500.0f64, speed_mps in 20.0..250.0f64,
        wrong in 0..3_u16, is_parallel in any::<bool>(),
    ) {
        let velocity = |target: u32| {
            let course = course + if is_parallel { 0.0 } else { std::f64::consts::PI * f64::from(target % 2) };
            [speed_mps * course.sin(), speed_mps * course.cos(), 0.0]
        };
        let off = [off_m * bearing.sin(), off_m * bearing.cos()];
        let offset_m = |source: u16, _| if source == wrong { off } else { [0.0; 2] };
        let found = registered_in(velocity, None, 60, [0.0; 3], offset_m);
        for source in 0..3 {
            let expected = offset_m(source, 0);
            for target in 0..2 {
                let effect: [f64; 3] = (sensitivity([0.0; 3], velocity(target), None) * found.of(source).errors).into();
                let apart_m = (effect[0] - expected[0]).hypot(effect[1] - expected[1]);
                prop_assert!(apart_m < 12.0, "{source}: {apart_m} m, {:?}", found.of(source));
            }
        }
        assert_two_may_err(&found, off_m);
    }
}

#[test]
fn an_error_that_drifts_is_followed_and_what_it_is_behind_is_known() {
    let drift_mps = 2.0;
    let at_end = registered_while(None, 300, [0.0; 3], |source, second| {
        let east_m = if source == 1 {
            drift_mps * f64::from(second)
        } else {
            0.0
        };
        [east_m, 0.0]
    });
    let behind_m = drift_mps * 300.0 - (at_end.of(1).errors[0] - at_end.of(0).errors[0]);
    assert!((0.0..40.0).contains(&behind_m), "{behind_m}");
    let left_m = at_end.left_over_m2().sqrt();
    assert!((0.2 * behind_m..behind_m).contains(&left_m), "{left_m} of {behind_m}");
    let steady = registered_while(None, 300, [0.0; 3], |source, _| [f64::from(source) * 20.0, 0.0]);
    assert_eq!(steady.left_over_m2(), 0.0);
}

#[test]
fn a_step_restarts_the_source_that_changed_alone() {
    let offset_m = |source: u16, second: u32| match (source, second) {
        (1, 100..160) => [150.0, 0.0],
        _ => [f64::from(source) * 5.0, 0.0],
    };
    let differs_by = |registration: &Registration| registration.of(1).errors[0] - registration.of(0).errors[0];
    let after = |seconds| registered_while(None, seconds, [0.0; 3], offset_m);
    let (found, mended) = (after(110), after(170));
    assert!((differs_by(&found) - 150.0).abs() < 8.0, "{:?}", found.of(1));
    assert!((differs_by(&mended) - 5.0).abs() < 8.0, "{:?}", mended.of(1));
    for registration in [found, mended] {
        assert!(registration.of(1).samples < registration.of(0).samples.min(registration.of(2).samples) / 4.0);
    }
}

#[test]
fn scattered_absurd_reports_make_no_step() {
    let offset_m = |source: u16, second: u32| match source {
        1 => [noise(second * 3, 800.0), noise(second * 3 + 1, 800.0)],
        _ => [0.0; 2],
    };
    let mut registration = registered_while(None, 60, [0.0; 3], |_, _| [0.0; 2]);
    let mut restarts = 0;
    for second in 0..60 {
        for target in 0..20u32 {
            let truth = [f64::from(target) * 3000.0, f64::from(second) * 100.0, 5000.0];
            let is_absurd = target % 10 == 0;
            let of = |source: u16| {
                let offset_m = if is_absurd {
                    offset_m(source, second * 20 + target)
                } else {
                    [0.0; 2]
                };
                view(source, truth, [100.0, 0.0, 0.0], offset_m, 0.0, second * 20 + target)
            };
            registration.learn(
                &of((target % 3) as u16),
                &of(((target + 1) % 3) as u16),
                0.0,
                (1e9, 1.0),
            );
        }
        registration.begin((0.0, 0.0), |_| restarts += 1);
        finish(&mut registration);
    }
    assert_eq!(restarts, 0);
}

#[test]
fn known_errors_are_solved_for_less_often_and_changed_errors_at_each_tick() {
    let mut registration = registered(None, [[0.0, 0.0], [60.0, 0.0], [30.0, 52.0]], [0.0; 3]);
    let solutions = |registration: &mut Registration, ticks: usize| {
        let begun = (0..ticks).filter(|_| {
            registration.begin((0.0, 0.0), |_| {});
            let begins = registration.is_solving();
            finish(registration);
            begins
        });
        begun.count()
    };
    assert_eq!(solutions(&mut registration, 50), 10);
    registration.begin_anew(1);
    assert_eq!(solutions(&mut registration, 20), 20);
}

#[test]
fn sums_fade_by_all_ticks_whether_solved_or_not() {
    let mut registration = registered(None, [[0.0, 0.0], [60.0, 0.0], [30.0, 52.0]], [0.0; 3]);
    let information = |registration: &Registration| registration.pairs[1].own[(0, 0)];
    let before = information(&registration);
    for _ in 0..50 {
        registration.begin((0.0, 0.0), |_| {});
        finish(&mut registration);
    }
    let kept = information(&registration) / before;
    assert!((kept / registration.keep.powi(50) - 1.0).abs() < 1e-9, "{kept}");
}

#[test]
fn a_named_reference_is_true() {
    let registration = registered(Some(1), [[0.0, 0.0], [60.0, 0.0], [30.0, 52.0]], [0.0; 3]);
    assert_eq!(registration.of(1).errors, Errors::zeros());
    assert!((registration.of(0).errors[0] + 60.0).abs() < 3.0);
    assert!((registration.of(2).errors[1] - 52.0).abs() < 3.0);
}

#[test]
fn what_all_offsets_have_in_common_is_as_uncertain_as_they_differ() {
    let offsets = [[0.0, 0.0], [60.0, 0.0], [30.0, 52.0]];
    // Each lies 34.6 m from their mean: 600 m² per axis of one, a third of that of the mean of three, and three times
    // as much since it is known from three.
    let common_m2 = registered(None, offsets, [0.0; 3]).common_offset_m2();
    assert!((common_m2 - 600.0).abs() < 80.0, "{common_m2}");
    assert_eq!(registered(Some(1), offsets, [0.0; 3]).common_offset_m2(), 0.0);
    let none_m2 = registered(None, [[0.0; 2]; 3], [0.0; 3]).common_offset_m2();
    assert!(none_m2 < 8.0, "{none_m2}");
}

#[test]
fn a_late_clock_is_found() {
    let registration = registered(Some(0), [[0.0; 2]; 3], [0.0, 0.0, 0.5]);
    assert!((registration.of(2).errors[3] - 0.5).abs() < 0.05);
    assert!(registration.of(2).removed[3] && !registration.of(1).removed[3]);
    let shift = registration.shift(2, [0.0; 3], [100.0, 0.0, 0.0], None);
    assert!((shift[0] + 50.0).abs() < 5.0, "{shift:?}");
}

/// Registration of sources with these offsets by their stamps, and these delays.
fn registered_by_stamps(reference: Option<u16>, stamps: [StampError; 3], late_s: [f64; 3]) -> Registration {
    let mut registration = Registration::new(3, reference, 300.0, 1.0);
    (0..3).for_each(|source| registration.set_stamps(source, stamps[source]));
    let velocity = |target: u32| {
        let heading = f64::from(target) * 0.7;
        [200.0 * heading.sin(), 200.0 * heading.cos(), 0.0]
    };
    continued_in(velocity, registration, 100, late_s, |_, _| [0.0; 2])
}

const DOWN: StampError = StampError {
    mean_s: -0.5,
    variance_s2: 1.0 / 12.0,
};

#[test]
fn a_source_with_fine_stamps_decides_against_rounded_stamps() {
    let fine = StampError::default();
    for rounded in [
        DOWN,
        StampError {
            mean_s: 0.0,
            variance_s2: 1.0 / 3.0,
        },
    ] {
        let registration = registered_by_stamps(None, [fine, rounded, rounded], [0.0, -0.8, -0.4]);
        for (source, late_s) in (0..).zip([0.0, -0.8, -0.4]) {
            let known = registration.of(source);
            assert!((known.time_offset_s() - late_s).abs() < 0.07, "{source}: {known:?}");
        }
        assert!(registration.common_time_s2().sqrt() < 0.05);
        // The median of three sources is a rounded one.
        let without = registered_by_stamps(None, [fine; 3], [0.0, -0.8, -0.4]);
        assert!(without.of(0).errors[TIME] > 0.3, "{:?}", without.of(0));
    }
}

#[test]
fn rounded_stamps_of_all_sources_leave_the_mean_rounding() {
    let registration = registered_by_stamps(None, [DOWN; 3], [-0.1, -0.4, -0.8]);
    let mean_s = (0..3)
        .map(|source| registration.of(source).time_offset_s())
        .sum::<f64>()
        / 3.0;
    assert!((mean_s + 0.5).abs() < 0.03, "{mean_s}");
    let apart_s = registration.of(0).time_offset_s() - registration.of(2).time_offset_s();
    assert!((apart_s - 0.7).abs() < 0.05, "{apart_s}");
    assert!((registration.common_time_s2() - 1.0 / 36.0).abs() < 1e-9);
    assert!(
        registration.common_offset_m2().sqrt() < 10.0,
        "the stamps explain the distances"
    );
}

/// Along parallel traffic, the offsets of place and time are one: the sum is that of the mean rounding.
#[test]
fn in_parallel_traffic_the_mean_rounding_is_removed_too() {
    let mut registration = Registration::new(3, None, 300.0, 1.0);
    (0..3).for_each(|source| registration.set_stamps(source, DOWN));
    let velocity = |_| [0.0, 200.0, 0.0];
    let registration = continued_in(velocity, registration, 100, [-0.1, -0.4, -0.8], |_, _| [0.0; 2]);
    let north_m = |source| registration.shift(source, [0.0; 3], [0.0, 200.0, 0.0], None)[1];
    let mean_m = (0..3).map(north_m).sum::<f64>() / 3.0;
    assert!((mean_m - 100.0).abs() < 10.0, "{mean_m}");
    assert!((north_m(2) - north_m(0) - 140.0).abs() < 15.0);
}

#[test]
fn a_reference_source_with_rounded_stamps_shows_the_others_its_own_time() {
    let registration = registered_by_stamps(Some(0), [DOWN, StampError::default(), DOWN], [-0.5, 0.0, -0.9]);
    for (source, late_s) in (0..).zip([-0.5, 0.0, -0.9]) {
        let known = registration.of(source);
        assert!((known.time_offset_s() - late_s).abs() < 0.07, "{source}: {known:?}");
    }
    assert_eq!(registration.common_time_s2(), DOWN.variance_s2);
}

#[test]
fn the_mean_offset_of_stamps_is_removed_without_comparisons() {
    let mut registration = Registration::new(1, None, 300.0, 1.0);
    registration.set_stamps(0, DOWN);
    assert_eq!(
        registration.shift(0, [0.0; 3], [100.0, -40.0, 8.0], None),
        [50.0, -20.0, 4.0]
    );
    assert_eq!(registration.common_time_s2(), 0.0, "nothing is compared");
    registration.forget(0);
    assert_eq!(registration.of(0).time_offset_s(), -0.5);
}

#[test]
fn many_sources_are_solved_for_in_steps_and_change_together() {
    const SOURCES: u16 = 40;
    let mut registration = Registration::new(usize::from(SOURCES), Some(0), 300.0, 1.0);
    for index in 0..20_000u32 {
        let (a, b) = ((index % 40) as u16, (index / 40 % 39) as u16);
        let b = if b < a { b } else { b + 1 };
        let heading = f64::from(index) * 0.7;
        let velocity = [200.0 * heading.sin(), 200.0 * heading.cos(), 0.0];
        let of = |source: u16| view(source, [3e3, 4e3, 5e3], velocity, [f64::from(source), 0.0], 0.0, index);
        registration.learn(&of(a), &of(b), 0.0, (1e9, 1.0));
    }
    registration.begin((0.0, 0.0), |_| {});
    assert!(!registration.step(&[], |_| {}) && registration.is_solving());
    assert!((0..SOURCES).all(|source| registration.of(source).errors == Errors::zeros()));
    for _ in 0..30 {
        registration.begin((0.0, 0.0), |_| {});
        finish(&mut registration);
    }
    assert!(!registration.is_solving() && !registration.step(&[], |_| {}));
    for source in 1..SOURCES {
        let east_m = registration.of(source).errors[0];
        assert!((east_m - f64::from(source)).abs() < 3.0, "{source}: {east_m}");
    }
}

#[test]
fn sources_that_agree_are_left_alone() {
    let registration = registered(None, [[0.0; 2]; 3], [0.0; 3]);
    for source in 0..3 {
        assert_eq!(
            registration.of(source).removed,
            [false; ERRORS],
            "{:?}",
            registration.of(source)
        );
    }
}

/// Places of three sensors, metres.
const PLACES_M: [[f64; 2]; 3] = [[50e3, 0.0], [-25e3, 43e3], [-25e3, -43e3]];

/// Continues `registration` for the seconds in `seconds`; source 1 has azimuth, range and offset errors. Sensors have
/// known positions if `places`.
fn register_polar(registration: &mut Registration, seconds: Range<u32>, places: bool, errors: (f64, f64, [f64; 2])) {
    register_polar_among(&[0, 1, 2], registration, seconds, places, errors);
}

/// [`register_polar`] with comparisons of these sources alone.
fn register_polar_among(
    compared: &[u16],
    registration: &mut Registration,
    seconds: Range<u32>,
    places: bool,
    (azimuth_rad, range_m, offset_m): (f64, f64, [f64; 2]),
) {
    for second in seconds {
        for target in 0..20u32 {
            let heading = f64::from(target) * 0.7;
            let velocity = [200.0 * heading.sin(), 200.0 * heading.cos(), 0.0];
            let along = f64::from(second % 100) - 50.0;
            let middle = [f64::from(target % 5) * 15e3 - 30e3, f64::from(target / 5) * 15e3 - 20e3];
            let truth = [middle[0] + velocity[0] * along, middle[1] + velocity[1] * along, 5000.0];
            let of = |source: u16| {
                let place_m = PLACES_M[usize::from(source)];
                let mut seen = view(source, truth, velocity, [0.0; 2], 0.0, second * 20 + target);
                if source == 1 {
                    let [dx, dy] = [truth[0] - place_m[0], truth[1] - place_m[1]];
                    let range = dx.hypot(dy);
                    seen.position_m[0] += azimuth_rad * dy + range_m * dx / range + offset_m[0];
                    seen.position_m[1] += range_m * dy / range - azimuth_rad * dx + offset_m[1];
                }
                seen.place_m = places.then_some(place_m);
                seen
            };
            let one_of = |place: u32| of(compared[place as usize % compared.len()]);
            registration.learn(&one_of(target), &one_of(target + 1), 0.0, (1e9, 1.0));
        }
        registration.begin((0.0, 0.0), |_| {});
        finish(registration);
        registration.decide(&[], |_| Some(0.0), 20, false);
    }
}

fn new_registration() -> Registration {
    Registration::new(3, None, 60.0, 1.0)
}

#[test]
fn an_azimuth_error_is_told_from_an_offset_by_its_evidence() {
    let azimuth_rad = 0.5f64.to_radians();
    let mut registration = new_registration();
    register_polar(&mut registration, 0..30, true, (azimuth_rad, 0.0, [0.0; 2]));
    let known = registration.of(1);
    assert_eq!(known.removed, [false, false, false, false, false, true], "{known:?}");
    assert!(
        (known.errors[AZIMUTH] - azimuth_rad).abs() < 0.01 * azimuth_rad,
        "{known:?}"
    );
    for source in [0, 2] {
        assert_eq!(
            registration.of(source).removed,
            [false; ERRORS],
            "{:?}",
            registration.of(source)
        );
    }
    // Once mended, the error goes.
    register_polar(&mut registration, 30..400, true, (0.0, 0.0, [0.0; 2]));
    let known = registration.of(1);
    assert!(
        !known.removed[AZIMUTH] || known.errors[AZIMUTH].abs() < 1e-5,
        "{known:?}"
    );
}

#[test]
fn a_constant_offset_is_no_azimuth_error() {
    let mut registration = new_registration();
    register_polar(&mut registration, 0..60, true, (0.0, 0.0, [150.0, -80.0]));
    let known = registration.of(1);
    assert!(
        !known.removed[AZIMUTH] && !known.removed[RANGE] && known.removed[0],
        "{known:?}"
    );
    let apart = [0, 1].map(|row| known.errors[row] - registration.of(0).errors[row]);
    assert!(
        (apart[0] - 150.0).abs() < 5.0 && (apart[1] + 80.0).abs() < 5.0,
        "{apart:?}"
    );
}

#[test]
fn a_range_error_and_an_offset_are_found_together() {
    let mut registration = new_registration();
    register_polar(&mut registration, 0..100, true, (0.0, 200.0, [150.0, 0.0]));
    let known = registration.of(1);
    assert!(known.removed[RANGE] && !known.removed[AZIMUTH], "{known:?}");
    assert!((known.errors[RANGE] - 200.0).abs() < 10.0, "{known:?}");
}

#[test]
fn without_positions_a_rotation_and_a_shift_are_found() {
    let azimuth_rad = 0.5f64.to_radians();
    let mut registration = new_registration();
    register_polar(&mut registration, 0..60, false, (azimuth_rad, 0.0, [0.0; 2]));
    let known = registration.of(1);
    assert!(known.removed[AZIMUTH] && known.removed[0], "{known:?}");
    for truth in [[-30e3, 10e3], [40e3, -20e3]] {
        let shift = registration.shift(1, [truth[0], truth[1], 5000.0], [0.0; 3], None);
        let [dx, dy] = [truth[0] - PLACES_M[1][0], truth[1] - PLACES_M[1][1]];
        let expected = [azimuth_rad * dy, -azimuth_rad * dx];
        let error = (shift[0] - expected[0]).hypot(shift[1] - expected[1]);
        assert!(error < 0.1 * expected[0].hypot(expected[1]), "{shift:?} {expected:?}");
    }
}

/// Two sources share a rotation, whichever of them is turned; a third source decides.
#[test]
fn a_rotation_is_of_the_minority_whatever_was_compared_first() {
    let azimuth_rad = 0.1f64.to_radians();
    for (first, last) in [([0, 1], 2), ([1, 2], 0), ([1, 0], 2), ([2, 1], 0)] {
        let mut registration = new_registration();
        let errors = (azimuth_rad, 0.0, [0.0; 2]);
        register_polar_among(&first, &mut registration, 0..40, false, errors);
        for source in first {
            let half = registration.of(source).errors[AZIMUTH].abs() / azimuth_rad;
            assert!((0.45..0.55).contains(&half), "{first:?}: {half}");
        }
        // Half the rotation displaces the targets by some tens of metres.
        let undecided_m = registration.common_error_m2().sqrt();
        assert!((20.0..80.0).contains(&undecided_m), "{first:?}: {undecided_m}");
        let all = [first[0], first[1], last];
        register_polar_among(&all, &mut registration, 40..46, false, errors);
        for source in [0, 1, 2] {
            let of = registration.of(source);
            let turn = if source == 1 { azimuth_rad } else { 0.0 };
            assert!(
                (of.errors[AZIMUTH] - turn).abs() < 0.1 * azimuth_rad,
                "{first:?}: {of:?}"
            );
            assert_eq!(of.removed[AZIMUTH], source == 1, "{first:?}: {of:?}");
        }
        assert!(registration.common_error_m2().sqrt() < 10.0, "{first:?}");
    }
}

/// After a step, a source has an estimate, and has been compared with nothing.
#[test]
fn a_turned_source_without_comparisons_leaves_the_common_error_finite() {
    let mut registration = new_registration();
    let errors = (0.1f64.to_radians(), 0.0, [0.0; 2]);
    register_polar_among(&[0, 1], &mut registration, 0..40, false, errors);
    let turned = registration.sources[1];
    registration.forget(1);
    registration.sources[1] = turned;
    assert!(registration.common_error_m2().is_finite());
}

/// Sensors of known position with a common rotation about their own positions, and without an offset, are turned: the
/// rotation of the frame would give an offset to each of them.
#[test]
fn known_positions_decide_about_a_common_rotation() {
    let vote = |turn| progress::Vote::Fixed(turn);
    assert_eq!(
        turns::majority(&[vote(0.01), vote(0.01), progress::Vote::Free(0.0)]),
        None
    );
    let free = progress::Vote::Free;
    assert_eq!(turns::majority(&[free(0.01), free(0.0101), free(0.0)]), Some(0.01));
    assert_eq!(turns::majority(&[free(0.01), free(0.01), vote(0.0), free(0.0)]), None);
    assert_eq!(turns::majority(&[free(0.01), free(0.0)]), None);
    assert_eq!(turns::majority(&[free(0.0), free(0.0), free(0.01)]), None);
    assert_eq!(turns::majority(&[progress::Vote::None; 3]), None);
}
