use proptest::prelude::*;
use test_support::S;

use super::*;
use crate::testing::test_settings;

/// Stamps of a source: measurements of `targets` targets, evenly over each turn of `turn_ns`, from `begin_ns` on for
/// `turns` turns, in the order of time; `stamped` makes the stamp of a time.
fn seen(turn_ns: i64, targets: i64, begin_ns: i64, turns: i64, stamped: impl Fn(i64) -> i64) -> Stamps {
    let mut stamps = Stamps::default();
    let mut before = vec![None; targets as usize];
    for turn in 0..turns {
        for (target, before) in (0..targets).zip(&mut before) {
            let time_ns = stamped(begin_ns + turn * turn_ns + target * turn_ns / targets);
            stamps.learn(time_ns);
            stamps.follow(before.replace(time_ns).map_or(0, |before: i64| time_ns - before));
        }
    }
    stamps
}

fn down(step_ns: i64) -> impl Fn(i64) -> i64 {
    move |time_ns| time_ns.div_euclid(step_ns) * step_ns
}

/// Steps that count among these sources, by their stated rounding, seconds.
fn counting<const N: usize>(mut all: [Stamps; N], stated: [Option<StampRounding>; N]) -> [f64; N] {
    let mut settings = test_settings(N);
    for (source, stated) in settings.sources.iter_mut().zip(stated) {
        source.stamps = stated;
    }
    let is_any = look(&mut all, &settings.sources);
    assert_eq!(is_any, all.iter().any(|stamps| stamps.step_ns != 0));
    all.map(|stamps| stamps.step_s())
}

#[test]
fn a_step_that_no_period_explains_counts_beside_fine_clocks() {
    let rounded = seen(4_800_000_000, 1, 7 * S + 1, 40, down(S));
    let fine = seen(3 * S, 1, 100_000_000, 40, |time_ns| time_ns);
    assert_eq!(rounded.step(), ClockStep::Coarse(S));
    assert_eq!(fine.step(), ClockStep::Fine);
    assert_eq!(counting([rounded, fine], [None; 2]), [1.0, 0.0]);
}

#[test]
fn a_step_that_the_period_explains_counts_where_nobody_has_fine_stamps_or_where_it_is_stated() {
    // A radar that measures all targets at whole seconds.
    let whole = seen(4 * S, 1, 8 * S, 20, |time_ns| time_ns);
    let half = seen(2 * S, 1, S + 700_000_000, 20, down(S / 2));
    let fine = seen(5 * S, 1, S + 300_000_000, 20, |time_ns| time_ns);
    assert_eq!(whole.step(), ClockStep::Explained(S));
    assert_eq!(counting([whole], [None]), [1.0]);
    assert_eq!(counting([whole, fine], [None; 2]), [0.0, 0.0]);
    let stated = Some(StampRounding::Down);
    assert_eq!(counting([whole, fine], [stated, stated]), [1.0, 0.0]);
    assert_eq!(counting([whole, half], [Some(StampRounding::Exact), None]), [0.0; 2]);
    // A period of whole seconds hides a step of half a second.
    assert_eq!(counting([whole, half], [None; 2]), [0.5; 2]);
}

#[test]
fn centres_state_the_times_of_their_states_and_sources_that_are_not_compared_decide_nothing() {
    let whole = seen(S, 1, 8 * S, 20, |time_ns| time_ns);
    let fine = seen(5 * S, 1, S + 300_000_000, 20, |time_ns| time_ns);
    let steps_s = |change: &dyn Fn(&mut [SourceSettings])| {
        let mut settings = test_settings(2);
        change(&mut settings.sources);
        let mut all = [whole, fine];
        look(&mut all, &settings.sources);
        all.map(|stamps| stamps.step_s())
    };
    assert_eq!(steps_s(&|sources| sources[0].is_centre = true), [0.0, 0.0]);
    assert_eq!(steps_s(&|sources| sources[1].is_centre = true), [1.0, 0.0]);
    assert_eq!(steps_s(&|sources| sources[1].is_registered = false), [1.0, 0.0]);
    let stated = |sources: &mut [SourceSettings]| {
        sources[0].is_centre = true;
        sources[0].stamps = Some(StampRounding::Unknown);
    };
    assert_eq!(steps_s(&stated), [1.0, 0.0]);
}

#[test]
fn few_stamps_prove_nothing() {
    let begun = |turns| seen(4 * S, 1, 8 * S, turns, |time_ns| time_ns);
    assert_eq!(counting([begun(5)], [None]), [0.0]);
    assert_eq!(counting([begun(6)], [None]), [1.0]);
    assert_eq!(counting([begun(3)], [Some(StampRounding::Nearest)]), [1.0]);
    assert_eq!(begun(5).multiples_of_s(), None);
    assert_eq!(begun(6).multiples_of_s(), Some(1.0));
    // A hundred targets with one stamp are one stamp.
    let mut once = Stamps::default();
    (0..100).for_each(|_| once.learn(5 * S));
    assert_eq!(once.multiples_of_s(), None);
}

#[test]
fn a_clock_that_becomes_coarse_or_fine_is_noticed_until_it_is_decided() {
    let mut stamps = seen(4_800_000_000, 1, 0, 40, down(S));
    assert_eq!(stamps.step(), ClockStep::Coarse(S));
    for turn in 0..80 {
        stamps.learn(1000 * S + turn * 4_830_000_000);
    }
    assert_eq!(stamps.step(), ClockStep::Fine);
}

#[test]
fn roundings_have_their_moments() {
    let of = |rounding| StampError::of(rounding, 0.5);
    let [down, nearest, unknown, exact] = StampRounding::ALL.map(of);
    assert_eq!((down.mean_s, nearest.mean_s, unknown.mean_s), (-0.25, 0.0, 0.0));
    let variances = [down, nearest, unknown].map(|error| error.variance_s2);
    assert_eq!(variances, [0.25 / 12.0, 0.25 / 12.0, 0.25 / 3.0]);
    assert!(down.is_coarse());
    assert_eq!(exact, StampError::default());
    assert!(!exact.is_coarse());
    // A fine clock outweighs coarse clocks; a clock far off hardly counts.
    let fine = StampError::default();
    assert!(fine.closeness(0.0) > 8.0 * down.closeness(-0.25));
    assert!(fine.closeness(5.0) < down.closeness(-0.25));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_step_is_recognised(
        place in 0..STEPS_NS.len(), begin_ns in -2_000_000_000 * S..2_000_000_000 * S, targets in 2..20i64,
        turn_ms in 2_000..13_000i64, as_float in any::<bool>(), zone_quarters in -50..50i64,
    ) {
        let step_ns = STEPS_NS[place];
        // A shorter turn explains the step.
        prop_assume!(2 * step_ns <= turn_ms * 1_000_000 && turn_ms % 100 != 0);
        let day_ns = 86_400 * S;
        let stamped = |time_ns: i64| {
            let stamp_ns = down(step_ns)(time_ns) + zone_quarters * 900 * S;
            let (day, of_day_ns) = (stamp_ns.div_euclid(day_ns), stamp_ns.rem_euclid(day_ns));
            match as_float {
                true => day * day_ns + (f64::from((of_day_ns as f64 / NS_PER_S) as f32) * NS_PER_S) as i64,
                false => stamp_ns,
            }
        };
        let stamps = seen(turn_ms * 1_000_000, targets, begin_ns, 60, stamped);
        prop_assert_eq!(stamps.step(), ClockStep::Coarse(step_ns));
    }

    #[test]
    fn odd_stamps_do_not_hide_a_step(odd in prop::collection::btree_set(0..40i64, 0..3), off_ms in 10..990i64) {
        let mut stamps = Stamps::default();
        for turn in 0..40 {
            let late_ns = if odd.contains(&turn) && turn >= 8 { off_ms * 1_000_000 } else { 0 };
            stamps.learn(down(S)(turn * 4_830_000_000) + late_ns);
            stamps.follow(if turn % 6 == 5 { 4 * S } else { 5 * S });
        }
        prop_assert_eq!(stamps.multiples_of_s(), Some(1.0));
    }

    #[test]
    fn fine_stamps_are_fine(
        begin_ns in -2_000_000_000 * S..2_000_000_000 * S, turn_ns in 500_000_000..13 * S, targets in 1..20i64,
        step_ns in prop::sample::select(vec![1, 1_000_000, 7_812_500, 100_000_000]),
    ) {
        // A period that keeps the stamps of a fine clock at whole steps is another matter.
        prop_assume!(targets > 2 && (turn_ns / targets) % 100_000_000 > 1_000_000);
        let stamps = seen(turn_ns, targets, begin_ns, 60, down(step_ns));
        prop_assert_eq!(stamps.step(), ClockStep::Fine);
    }

    #[test]
    fn no_time_is_too_odd(times_ns in prop::collection::vec(any::<i64>(), 0..600)) {
        let mut stamps = Stamps::default();
        for time_ns in times_ns {
            stamps.learn(time_ns);
            stamps.follow(time_ns);
        }
        stamps.step();
    }
}
