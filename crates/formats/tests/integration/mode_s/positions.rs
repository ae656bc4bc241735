//! Positions: pairs, checks, and the way out of a wrong place.

use formats::mode_s::ModeSRefusal;

use super::*;

const A: u32 = 0x3c_6589;
const HERE: [f64; 2] = [52.25, 4.75];
/// As far as a wrong zone would be.
const WRONG: [f64; 2] = [46.25, 11.5];

/// Reason of the only refusal.
fn refusal(reader: &ModeSReader) -> ModeSRefusal {
    let counters = reader.counters();
    assert_eq!(counters.refused_sum(), 1, "{counters:?}");
    let reasons = ModeSRefusal::ALL.into_iter();
    reasons.clone().find(|reason| counters.refused(*reason) == 1).unwrap()
}

#[test]
fn frames_too_far_apart_are_no_pair() {
    for (after_s, expected) in [(10.0, Some(HERE)), (10.1, None)] {
        let mut reader = reader(None);
        take(&mut reader, &airborne(A, HERE, false), 0.0);
        assert_eq!(place(&take(&mut reader, &airborne(A, HERE, true), after_s)), expected);
        assert_eq!(reader.counters().unpaired, if expected.is_some() { 1 } else { 2 });
    }
    // On the ground, 17 knots are slow.
    for (after_s, expected) in [(50.0, Some(HERE)), (50.1, None)] {
        let mut reader = reader(Some(RECEIVER));
        take(&mut reader, &surface(A, HERE, false), 0.0);
        assert_eq!(place(&take(&mut reader, &surface(A, HERE, true), after_s)), expected);
    }
}

#[test]
fn a_landing_aircraft_is_its_own_reference() {
    let mut reader = reader(None);
    take(&mut reader, &airborne(A, HERE, false), 0.0);
    take(&mut reader, &airborne(A, HERE, true), 0.5);
    assert_eq!(place(&take(&mut reader, &surface(A, HERE, true), 60.0)), Some(HERE));
    assert_eq!(place(&take(&mut reader, &surface(A, HERE, false), 61.0)), Some(HERE));
    assert_eq!(reader.counters().refused_sum(), 0);
}

#[test]
fn a_place_serves_ten_minutes() {
    for (after_s, expected) in [(600.0, Some(HERE)), (601.0, None)] {
        let mut reader = reader(None);
        take(&mut reader, &airborne(A, HERE, false), 0.0);
        take(&mut reader, &airborne(A, HERE, true), 0.0);
        assert_eq!(place(&take(&mut reader, &airborne(A, HERE, true), after_s)), expected);
    }
}

#[test]
fn positions_out_of_range_and_pairs_across_zones_are_refused() {
    let mut reader_in_range = reader(Some(RECEIVER));
    let far = [41.0, 12.0];
    take(&mut reader_in_range, &airborne(A, far, false), 0.0);
    assert_eq!(place(&take(&mut reader_in_range, &airborne(A, far, true), 0.5)), None);
    assert_eq!(refusal(&reader_in_range), ModeSRefusal::Range);
    // 52 zones become 51 at 29.9114°.
    let mut across = reader(None);
    take(&mut across, &airborne(A, [29.90, 4.0], false), 0.0);
    assert_eq!(place(&take(&mut across, &airborne(A, [29.92, 4.0], true), 5.0)), None);
    assert_eq!(refusal(&across), ModeSRefusal::Zone);
}

#[test]
fn one_contradicting_pair_gives_nothing_and_a_second_overrules() {
    let mut reader = reader(None);
    take(&mut reader, &airborne(A, WRONG, false), 0.0);
    assert_eq!(place(&take(&mut reader, &airborne(A, WRONG, true), 0.5)), Some(WRONG));
    // The first frame here contradicts by a pair with a frame of there, and all frames of one pair count once.
    let mut found = Vec::new();
    for step in 0..6 {
        found.push(place(&take(
            &mut reader,
            &airborne(A, HERE, step % 2 == 1),
            20.0 + f64::from(step),
        )));
    }
    assert_eq!(found[..3], [None; 3]);
    assert_eq!(found[3..], [Some(HERE); 3]);
    // The single frame at first was near the wrong place and is refused for its speed, as the pairs are.
    assert_eq!(
        reader.counters().refused(ModeSRefusal::Speed),
        reader.counters().refused_sum()
    );
}

#[test]
fn a_single_contradiction_is_forgotten_when_the_place_is_confirmed() {
    let mut reader = reader(None);
    let steps = [HERE, HERE, WRONG, WRONG, HERE, HERE, HERE, HERE];
    let found: Vec<_> = steps
        .iter()
        .enumerate()
        .map(|(step, at)| {
            place(&take(
                &mut reader,
                &airborne(A, *at, step % 2 == 1),
                12.0 * step as f64 / 8.0,
            ))
        })
        .collect();
    assert_eq!(found[1], Some(HERE));
    assert!(found.iter().flatten().all(|at| *at == HERE), "{found:?}");
    assert_eq!(found[6..], [Some(HERE); 2]);
}

#[test]
fn a_transmission_that_comes_twice_counts_once() {
    let mut reader = reader(None);
    take(&mut reader, &airborne(A, HERE, false), 0.0);
    let odd = airborne(A, HERE, true);
    assert_eq!(place(&take(&mut reader, &odd, 0.5)), Some(HERE));
    assert_eq!(place(&take(&mut reader, &odd, 0.6)), None);
    assert_eq!(refusal(&reader), ModeSRefusal::Repeated);
    assert_eq!(place(&take(&mut reader, &odd, 1.5)), Some(HERE));
}

#[test]
fn positions_go_on_across_the_date_line_and_the_equator() {
    for from in [[-0.01, 179.98], [51.0, -0.02], [-60.0, 179.98]] {
        let mut reader = reader(None);
        take(&mut reader, &airborne(A, from, false), 0.0);
        for step in 1..20 {
            let (latitude, longitude) = (from[0] + 0.001 * f64::from(step), from[1] + 0.002 * f64::from(step));
            let at = [
                latitude,
                if longitude >= 180.0 {
                    longitude - 360.0
                } else {
                    longitude
                },
            ];
            let found = observed(&take(&mut reader, &airborne(A, at, step % 2 == 1), f64::from(step)));
            let found = found.unwrap().geodetic.unwrap().map(f64::to_degrees);
            assert!(
                (found[0] - at[0]).abs() < 1e-4 && (found[1] - at[1]).abs() < 1e-4,
                "{found:?} {at:?}"
            );
        }
    }
}
