//! Numbers of targets that are silent for a while: they rest, and go back to the same target alone.

use std::collections::{BTreeMap, BTreeSet};

use messages::{Decision, DecisionKind, Order, OrderKind, Refusal};

use super::resumption::{kept, successor};
use super::*;
use crate::Sink;

/// Time after the last report at which a track is suspended, and at which it ends, seconds.
const SUSPENDED_S: f64 = 20.0;
const ENDED_S: f64 = 140.0;

/// Reports of a target by two sources from `from_s` to `until_s`; the numbers at the sources are `number`.
fn fly(
    harness: &mut Harness,
    number: u32,
    (from_s, until_s): (u32, u32),
    course: ([f64; 2], [f64; 2]),
) -> Option<SystemTrack> {
    let mut last = None;
    for second in from_s..until_s {
        for source in 0..2 {
            let time_s = f64::from(second) + 0.3 * f64::from(source) + 0.001 * f64::from(number % 100);
            last = harness.take(&report(source, number, time_s, course.0, course.1));
        }
    }
    last
}

fn state(track: &SystemTrack) -> Option<TrackState> {
    TrackState::from_code(track.state)
}

/// Numbers of the tracks shown since a place in the published states.
fn shown(harness: &Harness, from: usize) -> BTreeSet<u32> {
    let is_shown = |track: &&SystemTrack| track.state == TrackState::Confirmed as u8;
    harness.published[from..]
        .iter()
        .filter(is_shown)
        .map(|track| track.track_number)
        .collect()
}

/// Published states of a track, from a place, in the order of their states.
fn states(harness: &Harness, number: u32, from: usize) -> Vec<TrackState> {
    let of_track = harness.published[from..]
        .iter()
        .filter(|track| track.track_number == number);
    let mut states: Vec<TrackState> = of_track.filter_map(state).collect();
    states.dedup();
    states
}

const NORTH: ([f64; 2], [f64; 2]) = ([0.0, 0.0], [0.0, 200.0]);

#[test]
fn a_silent_track_is_suspended_once_and_ends_after_the_rest() {
    for refresh in [None, Some(Seconds::of(1.0))] {
        let mut settings = test_settings(2);
        settings.refresh_s = refresh;
        let mut harness = Harness::new(settings);
        fly(&mut harness, 1, (0, 10), NORTH);
        let last_s = 9.301;
        harness.advance(last_s + SUSPENDED_S + 1.0);
        let from = harness.published.len();
        assert_eq!(harness.published.last().and_then(state), Some(TrackState::Suspended));
        assert_eq!(
            (harness.live(), harness.engine.count_in_state(TrackState::Suspended)),
            (0, 1)
        );
        harness.advance(last_s + ENDED_S - 0.1);
        assert_eq!(harness.published.len(), from, "a suspended track is not refreshed");
        harness.advance(last_s + ENDED_S + 0.1);
        assert_eq!(states(&harness, 1, from), [TrackState::Terminated]);
        assert_eq!(harness.engine.count_in_state(TrackState::Suspended), 0);
        let ended = harness.published.last().unwrap();
        assert_eq!(ended.reference_time_ns, ((last_s + ENDED_S) * S as f64).round() as i64);
        // Who comes then is another target.
        fly(&mut harness, 1, (160, 166), NORTH);
        assert_eq!(shown(&harness, from), BTreeSet::from([2]));
    }
}

#[test]
fn a_suspended_track_is_not_refreshed_while_others_live() {
    let mut settings = test_settings(2);
    settings.refresh_s = Some(Seconds::of(1.0));
    let mut harness = Harness::new(settings);
    fly(&mut harness, 1, (0, 10), NORTH);
    fly(&mut harness, 2, (10, 60), ([50e3, 0.0], [0.0, 200.0]));
    let states = |number: u32, wanted: TrackState| {
        let of_track = harness.published.iter().filter(|track| track.track_number == number);
        of_track.filter(|track| state(track) == Some(wanted)).count()
    };
    assert_eq!(states(1, TrackState::Suspended), 1);
    assert!(states(2, TrackState::Confirmed) > 40, "the other one is");
}

#[test]
fn without_a_rest_the_number_ends_with_the_track() {
    let mut settings = test_settings(2);
    settings.numbers.rest_s = Seconds::default();
    let mut harness = Harness::new(settings);
    fly(&mut harness, 1, (0, 10), NORTH);
    harness.advance(31.0);
    assert_eq!(harness.published.last().and_then(state), Some(TrackState::Terminated));
    fly(&mut harness, 1, (40, 46), NORTH);
    assert_eq!(shown(&harness, 0), BTreeSet::from([1, 2]));
}

#[test]
fn a_track_that_was_never_shown_has_no_number_to_rest_unless_its_target_can_come_back() {
    for (state, address, last) in [
        (TrackState::Tentative, None, TrackState::Terminated),
        (TrackState::Confirmed, None, TrackState::Suspended),
        (TrackState::Tentative, Some(0x40_0000), TrackState::Suspended),
    ] {
        let mut harness = Harness::new(test_settings(3));
        for time_s in [0.0, 1.0] {
            let mut one = report(0, 1, time_s, [0.0, 0.0], [50.0, 0.0]);
            one.state = state as u8;
            harness.take(
                &address
                    .filter(|_| time_s > 0.0)
                    .map_or(one, |address| with_address(one, address)),
            );
        }
        harness.advance(8.0);
        assert_eq!(states(&harness, 1, 0), [TrackState::Tentative, last]);
    }
}

#[test]
fn the_number_goes_back_to_the_track_number_of_the_source_at_once() {
    let mut harness = Harness::new(test_settings(2));
    fly(&mut harness, 1, (0, 10), NORTH);
    harness.advance(40.0);
    let from = harness.published.len();
    let first = harness.take(&report(0, 1, 60.0, [0.0, 0.0], [0.0, 200.0])).unwrap();
    assert_eq!((first.track_number, state(&first)), (1, Some(TrackState::Confirmed)));
    // The state begins anew with the report, and the other source's number finds back, too.
    assert_eq!(first.position_m[1], 12_000.0);
    let second = harness.take(&report(1, 1, 60.3, [0.0, 0.0], [0.0, 200.0])).unwrap();
    assert_eq!((second.track_number, sources_of(&second)), (1, vec![0, 1]));
    assert_eq!(states(&harness, 1, from), [TrackState::Confirmed]);
    assert_eq!(harness.count(Counter::NumbersResumed), 1);
    assert_eq!(harness.count(Counter::TracksTerminated), 0);
    // The track lives as before: it coasts, and is suspended again.
    harness.advance(90.0);
    assert_eq!(
        states(&harness, 1, from),
        [TrackState::Confirmed, TrackState::Coasted, TrackState::Suspended]
    );
}

#[test]
fn a_track_number_that_a_source_has_given_to_another_target_resumes_nothing() {
    let mut harness = Harness::new(test_settings(2));
    fly(&mut harness, 1, (0, 10), NORTH);
    harness.advance(40.0);
    fly(&mut harness, 1, (40, 50), ([6_000.0, 0.0], [0.0, 200.0]));
    fly(&mut harness, 2, (50, 60), ([0.0, 20_000.0], [0.0, -200.0]));
    assert_eq!(shown(&harness, 0), BTreeSet::from([1, 2, 3]));
    assert_eq!(harness.count(Counter::NumbersResumed), 0);
}

/// Everything that the engine hands out.
#[derive(Default)]
struct Listener {
    tracks: Vec<SystemTrack>,
    decisions: Vec<Decision>,
}

impl Sink for Listener {
    fn track(&mut self, track: &SystemTrack) {
        self.tracks.push(*track);
    }

    fn decision(&mut self, decision: &Decision) {
        self.decisions.push(*decision);
    }
}

#[test]
fn under_other_numbers_a_target_takes_its_former_number_before_it_is_shown() {
    let mut engine = Engine::new(test_settings(2)).unwrap();
    let mut out = Listener::default();
    for second in (0..10).chain(45..55) {
        for source in 0..2 {
            let number = if second < 20 { 1 } else { 7 };
            let time_s = f64::from(second) + 0.3 * f64::from(source);
            engine.take(&report(source, number, time_s, [0.0, 0.0], [0.0, 200.0]), &mut out);
        }
    }
    let of_number = |number: u32| out.tracks.iter().filter(move |track| track.track_number == number);
    let mut young: Vec<_> = of_number(2)
        .map(|track| (state(track).unwrap(), track.merged_into))
        .collect();
    young.dedup();
    assert_eq!(young, [(TrackState::Tentative, 0), (TrackState::Terminated, 1)]);
    let last = of_number(1).next_back().unwrap();
    assert_eq!(
        (state(last), last.position_m[1]),
        (Some(TrackState::Confirmed), 54.3 * 200.0)
    );
    assert!(of_number(1).is_sorted_by_key(|track| track.reference_time_ns));
    assert!(of_number(1).all(|track| state(track) != Some(TrackState::Terminated)));
    let resumed: Vec<_> = out
        .decisions
        .iter()
        .filter(|one| one.kind() == Some(DecisionKind::Resumed))
        .collect();
    assert_eq!(resumed.len(), 1);
    assert_eq!((resumed[0].system_track, resumed[0].other_system_track), (1, 2));
    assert!(resumed[0].value > resumed[0].limit, "{resumed:?}");
    assert_eq!(engine.count_in_state(TrackState::Suspended), 0);
}

#[test]
fn another_target_near_by_gets_a_number_of_its_own() {
    // To the side, ahead, the other way, slower.
    for (place, velocity) in [
        ([2_500.0, 0.0], [0.0, 200.0]),
        ([0.0, 3_000.0], [0.0, 200.0]),
        ([0.0, 18_000.0], [0.0, -200.0]),
        ([0.0, 6_750.0], [0.0, 50.0]),
        ([9_000.0, 9_000.0], [-200.0, 0.0]),
    ] {
        let mut harness = Harness::new(test_settings(2));
        fly(&mut harness, 1, (0, 10), NORTH);
        harness.advance(40.0);
        fly(&mut harness, 7, (45, 55), (place, velocity));
        assert_eq!(shown(&harness, 0), BTreeSet::from([1, 2]), "{place:?} {velocity:?}");
    }
}

#[test]
fn of_two_that_fit_alike_neither_is_taken() {
    let aside = |metres: f64| ([metres, 0.0], [0.0, 200.0]);
    let mut harness = Harness::new(test_settings(2));
    fly(&mut harness, 1, (0, 10), aside(-75.0));
    fly(&mut harness, 2, (10, 20), aside(75.0));
    harness.advance(45.0);
    assert_eq!(harness.engine.count_in_state(TrackState::Suspended), 2);
    fly(&mut harness, 7, (50, 60), aside(0.0));
    assert_eq!(shown(&harness, 0), BTreeSet::from([1, 2, 3]));
    // One silent target, and two that come up.
    let mut harness = Harness::new(test_settings(2));
    fly(&mut harness, 1, (0, 10), aside(0.0));
    harness.advance(45.0);
    for second in 50..60 {
        fly(&mut harness, 7, (second, second + 1), aside(-75.0));
        fly(&mut harness, 8, (second, second + 1), aside(75.0));
    }
    assert_eq!(shown(&harness, 0), BTreeSet::from([1, 2, 3]));
}

#[test]
fn targets_that_cross_while_all_sources_are_silent_keep_their_numbers() {
    let courses = [([-4_000.0, 0.0], [200.0, 0.0]), ([4_000.0, 300.0], [-200.0, 0.0])];
    let mut harness = Harness::new(test_settings(2));
    for (second, number) in (0..8).chain(32..42).flat_map(|second| [(second, 1), (second, 2)]) {
        let renumbered = if second < 20 { number } else { 10 - number };
        fly(
            &mut harness,
            renumbered,
            (second, second + 1),
            courses[number as usize - 1],
        );
    }
    assert_eq!(shown(&harness, 0), BTreeSet::from([1, 2]));
    let eastward = |track: &&SystemTrack| track.velocity_mps[0] > 0.0;
    assert!(
        harness
            .published
            .iter()
            .filter(eastward)
            .all(|track| track.track_number != 2)
    );
}

#[test]
fn a_coasted_target_far_from_its_last_report_keeps_its_number() {
    let fast = ([0.0, 0.0], [0.0, 300.0]);
    let mut harness = Harness::new(test_settings(2));
    fly(&mut harness, 1, (0, 10), fast);
    fly(&mut harness, 7, (25, 35), fast);
    assert_eq!(shown(&harness, 0), BTreeSet::from([1]));
}

#[test]
fn an_address_brings_a_target_back_that_has_turned_away() {
    let mut harness = Harness::new(test_settings(2));
    let at = |number: u32, time_s: f64, place: [f64; 2], velocity: [f64; 2]| {
        with_address(report(0, number, time_s, place, velocity), 0x40_0000)
    };
    for second in 0..10 {
        harness.take(&at(1, f64::from(second), [0.0, 0.0], [0.0, 250.0]));
    }
    harness.advance(70.0);
    // Back where it was 80 s ago, at another number of the source: 20 km from where it would be in straight flight.
    let back = harness.take(&at(2, 90.0, [0.0, 22_500.0], [0.0, -250.0])).unwrap();
    assert_eq!((back.track_number, state(&back)), (1, Some(TrackState::Confirmed)));
    assert_eq!(back.position_m[1], 0.0);
    // The same address 100 km away is a misread one.
    harness.advance(150.0);
    for second in 160..170 {
        harness.take(&at(3, f64::from(second), [100e3, 0.0], [0.0, 0.0]));
    }
    assert_eq!(shown(&harness, 0), BTreeSet::from([1, 2]));
    assert!(harness.count(Counter::IdentityConflicts) > 0);
}

#[test]
fn a_rare_code_brings_a_target_back_that_has_turned() {
    let numbers = |code: u16| {
        let mut harness = Harness::new(test_settings(2));
        for second in (0..10).chain(50..60) {
            for source in 0..2 {
                let time_s = f64::from(second) + 0.3 * f64::from(source);
                let (number, place, velocity) = match second {
                    ..20 => (1, [0.0, 0.0], [0.0, 200.0]),
                    // By 40° to the east, 1.4 km from the straight way at 55 s.
                    _ => (7, [-5_800.0, 1_800.0], [128.0, 154.0]),
                };
                let mut report = report(source, number, time_s, place, velocity);
                report.identity = Identity::default().with_mode_3a(code);
                harness.take(&report);
            }
        }
        shown(&harness, 0)
    };
    assert_eq!(numbers(0o4521), BTreeSet::from([1]));
    assert_eq!(numbers(0o2000), BTreeSet::from([1, 2]), "a code that many have");
}

#[test]
fn a_new_target_in_a_full_table_ends_the_track_that_is_suspended_longest() {
    let mut settings = test_settings(2);
    settings.capacity.system_tracks = Some(4);
    let mut harness = Harness::new(settings);
    let course = |number: u32| ([20e3 * f64::from(number), 0.0], [0.0, 200.0]);
    for number in 1..5 {
        fly(&mut harness, number, (10 * number, 10 * number + 10), course(number));
    }
    harness.advance(72.0);
    let from = harness.published.len();
    fly(&mut harness, 5, (75, 80), course(5));
    assert_eq!(states(&harness, 1, from), [TrackState::Terminated]);
    assert_eq!(shown(&harness, from), BTreeSet::from([5]));
    assert_eq!(harness.count(Counter::DroppedTable), 0);
    // Another one, and the place of the first is looked after like any other.
    fly(&mut harness, 6, (80, 86), course(6));
    fly(&mut harness, 3, (86, 90), course(3));
    assert_eq!(shown(&harness, from), BTreeSet::from([3, 5, 6]));
    harness.advance(400.0);
    let ended: BTreeSet<u32> = harness
        .published
        .iter()
        .filter(|track| state(track) == Some(TrackState::Terminated))
        .map(|track| track.track_number)
        .collect();
    assert_eq!(ended, (1..7).collect());
    assert_eq!(
        harness
            .engine
            .tracks
            .systems
            .slots()
            .filter(|slot| { harness.engine.tracks.systems.get(*slot).number != 0 })
            .count(),
        0
    );
}

#[test]
fn an_operator_can_end_a_number_that_rests_and_nothing_else() {
    let mut harness = Harness::new(test_settings(2));
    fly(&mut harness, 1, (0, 10), NORTH);
    fly(&mut harness, 2, (0, 40), ([30e3, 0.0], [0.0, 200.0]));
    let order = |kind: OrderKind, track: u32, other_track: u32| Order {
        kind: kind.code(),
        track,
        other_track,
        ..Order::default()
    };
    let examine = |harness: &Harness, order: &Order| {
        harness
            .engine
            .examine_tracks(OrderKind::from_code(order.kind).unwrap(), order)
    };
    assert_eq!(harness.engine.count_in_state(TrackState::Suspended), 1);
    for (track, other) in [(1, 2), (2, 1)] {
        let refused = examine(&harness, &order(OrderKind::Join, track, other));
        assert_eq!(refused, Err(Refusal::UnknownTrack));
    }
    assert_eq!(examine(&harness, &order(OrderKind::Drop, 1, 0)), Ok(()));
}

#[test]
fn a_number_rests_on_through_a_kill() {
    for number_after in [1, 7] {
        let (mut harness, mut memory) = kept(Harness::new(test_settings(2)));
        fly(&mut harness, 1, (0, 10), NORTH);
        harness.advance(40.0);
        for _ in 0..2 {
            (harness, memory) = successor(harness, &memory, false);
            assert_eq!(
                (harness.live(), harness.engine.count_in_state(TrackState::Suspended)),
                (0, 1)
            );
        }
        fly(&mut harness, number_after, (50, 56), NORTH);
        assert_eq!(shown(&harness, 0), BTreeSet::from([1]), "{number_after}");
        // A start after that knows it as a live track.
        (harness, memory) = successor(harness, &memory, false);
        assert_eq!(harness.engine.count_in_state(TrackState::Confirmed), 1);
        harness.advance(55.3 + ENDED_S - 10.0);
        (harness, _) = successor(harness, &memory, false);
        harness.advance(55.4 + ENDED_S);
        assert_eq!(states(&harness, 1, 0), [TrackState::Terminated]);
    }
}

#[test]
fn a_start_after_a_kill_in_the_middle_of_a_take_over_has_each_number_once() {
    let (mut harness, memory) = kept(Harness::new(test_settings(2)));
    fly(&mut harness, 1, (0, 10), NORTH);
    fly(&mut harness, 2, (40, 50), ([30e3, 0.0], [0.0, 200.0]));
    // What the memory holds between the two halves: the live track has the number, and the silent one still.
    let live = harness
        .engine
        .tracks
        .systems
        .slots()
        .find(|slot| harness.engine.tracks.systems.get(*slot).number == 2);
    harness.engine.tracks.renumber(live.unwrap(), 1);
    let (next, _) = successor(harness, &memory, false);
    assert_eq!((next.live(), next.engine.count_in_state(TrackState::Suspended)), (1, 0));
}

#[test]
fn engines_that_go_on_from_an_image_during_the_rest_agree_to_the_bit() {
    let mut harness = Harness::new(test_settings(2));
    let courses: Vec<_> = (1..5)
        .map(|number| ([3e3 * f64::from(number), 0.0], [0.0, 200.0]))
        .collect();
    for (number, course) in (1..).zip(&courses) {
        fly(&mut harness, number, (0, 10), *course);
    }
    harness.advance(45.0);
    let mut other = Harness::new(test_settings(2));
    other.engine.resume_image(&harness.engine.image()).unwrap();
    let from = harness.published.len();
    for one in [&mut harness, &mut other] {
        for (number, course) in (1..).zip(&courses) {
            fly(one, if number < 3 { number } else { number + 5 }, (50, 56), *course);
        }
        one.advance(300.0);
    }
    let text = |tracks: &[SystemTrack]| tracks.iter().map(|track| format!("{track:?}")).collect::<Vec<_>>();
    assert!(text(&harness.published[from..]) == text(&other.published));
    assert_eq!(harness.count(Counter::NumbersResumed), 4);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever falls silent for however long, under whatever numbers it comes back: no two targets have one number at
    /// a time, no number comes after its end, and no track of one target goes over to another.
    #[test]
    fn a_number_is_never_of_two_targets_at_once(
        silences in prop::collection::vec((0u32..6, 5u32..200, 1u32..60), 1..20),
        renumbers: bool, has_addresses: bool,
    ) {
        let mut harness = Harness::new(test_settings(2));
        let mut of_number: BTreeMap<u32, u32> = BTreeMap::new();
        let mut ended = BTreeSet::new();
        let course = |target: u32| {
            let speed = if target.is_multiple_of(2) { 150.0 } else { -150.0 };
            ([0.0, 1_500.0 * f64::from(target)], [speed, 0.0])
        };
        let mut comes = [0u32; 6];
        for second in 0..240u32 {
            let mut shown_by: BTreeMap<u32, u32> = BTreeMap::new();
            for (source, target) in (0..2).flat_map(|source| (0..6).map(move |target| (source, target))) {
                let silent = |(of, from, length): &(u32, u32, u32)| {
                    *of == target && (*from..from + length).contains(&second)
                };
                if silences.iter().any(silent) {
                    comes[target as usize] = second;
                    continue;
                }
                let number = if renumbers { 10 * (1 + comes[target as usize]) + target } else { target };
                let time_s = f64::from(second) + 0.3 * f64::from(source) + 0.01 * f64::from(target);
                let (place, velocity) = course(target);
                let mut report = report(source, number, time_s, place, velocity);
                if has_addresses {
                    report = with_address(report, 0x40_0000 + target);
                }
                let from = harness.published.len();
                harness.take(&report);
                for track in &harness.published[from..] {
                    let number = track.track_number;
                    prop_assert!(!ended.contains(&number), "{number} after its end");
                    match state(track) {
                        Some(TrackState::Terminated) => drop(ended.insert(number)),
                        Some(TrackState::Confirmed) if track.trigger_source != NO_SOURCE => {
                            let of = (track.position_m[1] / 1_500.0).round() as u32;
                            prop_assert_eq!(*of_number.entry(number).or_insert(of), of, "{}", number);
                            prop_assert_eq!(*shown_by.entry(of).or_insert(number), number);
                        }
                        _ => {}
                    }
                }
            }
        }
    }
}
