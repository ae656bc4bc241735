//! A source on a ship: its coverage lies around the ship.

use super::resumption::{kept, successor};
use super::*;

/// Reach of the ship's radar, metres.
const REACH_M: f64 = 10e3;
/// The ship looks around, and then goes east.
const LOOKS_S: u32 = 60;
const ARRIVES_S: u32 = LOOKS_S + 200;
const SHIP_MPS: f64 = 100.0;
/// Numbers of a boat that goes beside the ship, and of what only the radar ashore claims.
const BOAT: u32 = 800;
const CLAIMED: u32 = 900;
/// Where the ship was at first, and looks no more; and where it looks now.
const ASTERN: [f64; 2] = [-3e3, -3e3];
const NEAR: [f64; 2] = [22e3, -3e3];
/// So far ahead of the ship that nothing is known of its coverage there. The boat has been as far from the ship's first
/// place: coverage learned by place would be known.
const AHEAD: [f64; 2] = [35e3, 3e3];

fn ship_m(time_s: f64) -> [f64; 2] {
    [
        SHIP_MPS * (time_s - f64::from(LOOKS_S)).clamp(0.0, f64::from(ARRIVES_S - LOOKS_S)),
        0.0,
    ]
}

/// A report of a target at this place. The ship's radar, source 1, states where it is, unless it keeps this `secret`.
fn of_target(source: u16, number: u32, time_s: f64, place: [f64; 2], secret: bool) -> SensorTrack {
    let mut made = report(source, number, 0.0, place, [0.0; 2]);
    made.time_of_measurement_ns = (time_s * S as f64) as i64;
    if source == 1 && !secret {
        let [east, north] = ship_m(time_s);
        made.valid |= sensor_track_bits::PLATFORM;
        made.measured_m = [east, north, 0.3];
    }
    made
}

/// The reports of a second: of the targets at rest around the ship, until it leaves, and of the boat.
fn look(harness: &mut Harness, second: u32, secret: bool) {
    for source in 0..2 {
        let time_s = f64::from(second) + 0.3 * f64::from(source);
        let [east, north] = ship_m(time_s);
        let column = |column: u32| 5e3 * f64::from(column) - 28e3;
        let targets = (0..24).map(|target| (target, [column(target / 2), if target % 2 == 0 { -3e3 } else { 8e3 }]));
        for (number, place) in targets.filter(|_| second < LOOKS_S) {
            if source == 0 || (place[0] - east).hypot(place[1] - north) < REACH_M {
                harness.take(&of_target(source, number, time_s, place, secret));
            }
        }
        let boat = SensorTrack {
            velocity_mps: [if east > 0.0 { SHIP_MPS } else { 0.0 }, 0.0, 0.0],
            ..of_target(source, BOAT, time_s, [east + 3e3, north + 3e3], secret)
        };
        harness.take(&boat);
    }
}

/// The engine when the ship has arrived.
fn after_the_voyage(secret: bool) -> Harness {
    let mut harness = Harness::new(test_settings(2));
    (0..ARRIVES_S).for_each(|second| look(&mut harness, second, secret));
    harness
}

/// Existence of a target at this place that only the radar ashore claims, after each report, and whether it is shown.
fn claimed(harness: &mut Harness, place: [f64; 2], secret: bool) -> (Vec<f32>, bool) {
    let (mut found, mut is_shown) = (Vec::new(), false);
    for second in ARRIVES_S..ARRIVES_S + 5 {
        look(harness, second, secret);
        let track = harness.take(&of_target(0, CLAIMED, f64::from(second) + 0.6, place, secret));
        found.extend(track.map(|track| track.existence));
        is_shown |= track.is_some_and(|track| track.state == TrackState::Confirmed as u8);
    }
    (found, is_shown)
}

#[test]
fn the_coverage_of_a_ship_moves_with_the_ship() {
    let (astern, is_shown) = claimed(&mut after_the_voyage(false), ASTERN, false);
    assert!(is_shown, "the ship cannot see it: {astern:?}");
    let (ahead, is_shown) = claimed(&mut after_the_voyage(false), AHEAD, false);
    assert!(!is_shown, "coverage is learned by place as well: {ahead:?}");
    let (near, is_shown) = claimed(&mut after_the_voyage(false), NEAR, false);
    assert!(!is_shown, "the ship looks there and sees nothing: {near:?}");
    assert!(near.last().unwrap() < astern.last().unwrap(), "{near:?} {astern:?}");
}

#[test]
fn a_ship_that_does_not_state_its_place_has_a_coverage_where_it_was() {
    let (astern, is_shown) = claimed(&mut after_the_voyage(true), ASTERN, true);
    assert!(!is_shown, "{astern:?}");
}

#[test]
fn a_snapshot_knows_where_the_ship_is() {
    let mut engine = after_the_voyage(false);
    let mut resumed = Harness::new(engine.engine.settings().clone());
    resumed.engine.resume_image(&engine.engine.image()).unwrap();
    let found = [&mut engine, &mut resumed].map(|harness| format!("{:?}", claimed(harness, ASTERN, false)));
    assert_eq!(found[0], found[1]);
    assert!(engine.engine.image() == resumed.engine.image());
}

#[test]
fn a_successor_knows_where_the_ship_is() {
    let (mut engine, memory) = kept(after_the_voyage(false));
    let records = engine.engine.learned_records();
    engine.engine.keep_learned(records);
    let follows = |harness: &Harness, source: u16, after_s: i64| {
        let time_ns = (i64::from(ARRIVES_S) + after_s) * S;
        let detection = harness.engine.sources().follows_at(source, [20e3, 0.0, 0.0], time_ns);
        detection.map(|detection| [detection.assumed, detection.shown].map(f64::to_bits))
    };
    let before = follows(&engine, 1, 0);
    let (next, _) = successor(engine, &memory, false);
    assert_eq!(follows(&next, 1, 0), before);
    // A place that the ship stated long ago is not its place any more; a station does not move.
    assert!(follows(&next, 1, 3600).is_none() && follows(&next, 0, 3600).is_some());
}
