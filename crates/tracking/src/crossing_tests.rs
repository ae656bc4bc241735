//! Tracks that start at crossings of bearings: two cameras, targets that cross, ghosts.

use observations::{Detection, DetectionKind};
use proptest::prelude::*;
use test_support::Random;

use super::*;
use crate::Tracker;
use crate::settings::SensorFacts;
use crate::testing::{S, position, settings};

/// Places of the two cameras, metres.
const CAMERAS: [[f64; 2]; 2] = [[-2000.0, 0.0], [2000.0, 0.0]];
const SIGMA_RAD: f64 = 0.002;

/// Two cameras with a look each second, half a second apart.
fn cameras() -> Settings {
    let mut chosen = settings();
    chosen.initiation.crossing_s = Some(1.0);
    chosen.initiation.speed_sigma_mps = 20.0;
    let camera = |sensor_id| {
        let mut camera = SensorFacts {
            sensor_id,
            ..SensorFacts::default()
        };
        camera.model.detection_probability = Some(0.9);
        camera.model.clutter_density = Some(0.1);
        camera
    };
    chosen.sensors = vec![camera(1), camera(2)];
    chosen
}

/// A number of the standard normal distribution.
fn gauss(random: &mut Random) -> f64 {
    let radius = (-2.0 * random.between(1e-12, 1.0).ln()).sqrt();
    radius * (TAU * random.unit()).cos()
}

fn bearing(camera: usize, time_ns: i64, [east, north]: [f64; 2], error: f64) -> Detection {
    let [x, y] = CAMERAS[camera];
    Detection {
        sensor_id: camera as u32 + 1,
        kind: DetectionKind::Bearing,
        values: [(east - x).atan2(north - y) + error, 0.0, 0.0],
        sigmas: Some([SIGMA_RAD, 0.0, 0.0, 0.0]),
        platform_m: [x, y, 0.0],
        ..position(time_ns, 0.0, 0.0)
    }
}

/// Two targets that cross, at a time in seconds.
fn targets(time_s: f64) -> [[f64; 2]; 2] {
    [
        [-900.0 + 15.0 * time_s, 3000.0 + 4.0 * time_s],
        [900.0 - 15.0 * time_s, 3800.0 - 6.0 * time_s],
    ]
}

/// Numbers of tracks at targets that are followed at the end, and of all other tracks that were ever shown.
fn run(chosen: Settings, seed: u64, seconds: i64) -> (usize, usize, Tracker) {
    let mut tracker = Tracker::new(chosen).unwrap();
    let mut random = Random::new(seed);
    let mut false_tracks = std::collections::BTreeSet::new();
    for look in 0..2 * seconds {
        let (camera, time_ns) = ((look % 2) as usize, look * S / 2);
        let time_s = time_ns as f64 / 1e9;
        let mut seen = Vec::new();
        for target in targets(time_s) {
            if random.unit() < 0.9 {
                seen.push(bearing(camera, time_ns, target, SIGMA_RAD * gauss(&mut random)));
            }
        }
        if random.unit() < 0.3 {
            let place = [8000.0 * (random.unit() - 0.5), 6000.0];
            seen.push(bearing(camera, time_ns, place, 0.0));
        }
        tracker.scan(camera as u32 + 1, time_ns, &seen).unwrap();
        for track in tracker.tracks() {
            let [east, north, ..] = track.estimate.mean;
            let near = |target: &[f64; 2]| (target[0] - east).hypot(target[1] - north) < 300.0;
            if !targets(time_s).iter().any(near) {
                false_tracks.insert(track.number);
            }
        }
    }
    let found = targets(seconds as f64).map(|target| {
        let near = |track: &crate::TrackReport| {
            let [east, north, ..] = track.estimate.mean;
            (target[0] - east).hypot(target[1] - north) < 300.0
        };
        tracker.tracks().iter().any(near)
    });
    let found = found.into_iter().filter(|found| *found).count();
    (found, false_tracks.len(), tracker)
}

#[test]
fn two_cameras_start_the_tracks_of_crossing_targets_and_no_ghosts() {
    let (mut found, mut false_tracks) = (0, 0);
    for seed in (1..=40).chain(1001..=1040).chain(2001..=2040) {
        let (of_run, others, _) = run(cameras(), seed, 60);
        (found, false_tracks) = (found + of_run, false_tracks + others);
    }
    assert!(found >= 236, "{found} of 240");
    // At most .05 a run.
    assert!(false_tracks <= 6, "{false_tracks} in 120 runs");
}

#[test]
fn without_the_setting_directions_start_nothing() {
    let mut chosen = cameras();
    chosen.initiation.crossing_s = None;
    let (found, others, tracker) = run(chosen, 1, 20);
    assert_eq!(
        (found, others, tracker.branches(), tracker.counts().crossings),
        (0, 0, 0, 0)
    );
}

/// Five targets have 25 crossings: nothing is started, and all are counted.
#[test]
fn more_crossings_than_hypotheses_can_tell_apart_start_nothing() {
    let mut tracker = Tracker::new(cameras()).unwrap();
    for look in 0..2_i64 {
        let (camera, time_ns) = (look as usize, look * S / 2);
        let seen = [-2.0, -1.0, 0.0, 1.0, 2.0];
        let seen = seen.map(|step| bearing(camera, time_ns, [200.0 * step, 4000.0], 0.0));
        tracker.scan(camera as u32 + 1, time_ns, &seen).unwrap();
    }
    assert_eq!((tracker.branches(), tracker.counts().crossings), (0, 0));
    assert!(tracker.counts().crossings_dropped > CROSSINGS_MAX as u64);
}

/// A crossing begins one track, at the place where the rays meet, with an error that covers the place.
#[test]
fn a_track_begins_where_two_rays_meet() {
    let mut tracker = Tracker::new(cameras()).unwrap();
    let place = [300.0, 3500.0];
    tracker.scan(1, 0, &[bearing(0, 0, place, 0.0)]).unwrap();
    assert_eq!(tracker.branches(), 0);
    tracker.scan(2, S / 2, &[bearing(1, S / 2, place, 0.0)]).unwrap();
    assert_eq!((tracker.branches(), tracker.counts().crossings), (1, 1));
    let state = *tracker.latest().tracks[0].motion.widest();
    assert!(
        (state.mean[0] - 300.0).hypot(state.mean[1] - 3500.0) < 1.0,
        "{:?}",
        state.mean
    );
    // The same sensor's next direction begins nothing: it is of the track.
    tracker
        .scan(2, 3 * S / 2, &[bearing(1, 3 * S / 2, place, 0.0)])
        .unwrap();
    assert_eq!(tracker.counts().crossings, 1);
}

/// Two targets, of which the first camera has missed one at its first look.
const TWO: [[f64; 2]; 2] = [[-500.0, 3000.0], [600.0, 3600.0]];

fn look(tracker: &mut Tracker, number: i64, places: &[[f64; 2]]) {
    let (camera, time_ns) = ((number % 2) as usize, number * S / 2);
    let seen: Vec<_> = places
        .iter()
        .map(|place| bearing(camera, time_ns, *place, 0.0))
        .collect();
    tracker.scan(camera as u32 + 1, time_ns, &seen).unwrap();
}

/// A ghost that has begun before a target could, since that was missed, begins anew beside the target.
#[test]
fn a_further_crossing_lets_all_begin_anew() {
    let mut tracker = Tracker::new(cameras()).unwrap();
    look(&mut tracker, 0, &TWO[..1]);
    look(&mut tracker, 1, &TWO);
    assert_eq!(
        (tracker.branches(), tracker.counts().crossings),
        (2, 2),
        "a target and a ghost"
    );
    look(&mut tracker, 2, &TWO);
    assert_eq!((tracker.branches(), tracker.counts().crossings), (4, 6));
    let population = tracker.latest();
    assert!(
        population.tracks.iter().all(|track| track.begun_ns == S),
        "none is older"
    );
    // With nothing new to compare, they go on.
    look(&mut tracker, 3, &TWO);
    assert_eq!(tracker.counts().crossings, 6);
}

/// Two crossings on one earlier ray explain its one cause in two ways, though they have no detection of this scan in
/// common.
#[test]
fn crossings_on_one_earlier_ray_exclude_each_other() {
    let mut tracker = Tracker::new(cameras()).unwrap();
    look(&mut tracker, 0, &TWO[..1]);
    look(&mut tracker, 1, &TWO);
    for number in 2..6 {
        let places = if number % 2 == 0 { &TWO[..1] } else { &TWO };
        look(&mut tracker, number, places);
        let population = tracker.latest();
        assert!(!population.hypotheses.is_empty());
        for hypothesis in &population.hypotheses {
            assert!(population.members_of(hypothesis).len() <= 1, "scan {number}");
        }
        let roots: std::collections::BTreeSet<u32> = population.tracks.iter().map(|track| track.root).collect();
        assert!(number > 2 || roots.len() == 2, "both are compared");
    }
}

#[test]
fn rays_that_hardly_meet_give_no_crossing() {
    let guess = cameras().initiation;
    let measured = |camera, place| DetectionMeasurement::of(&bearing(camera, 0, place, 0.0), None).unwrap();
    let meets = |place| cross(&measured(0, place), &measured(1, place), 0.1, &guess).is_some();
    assert!(meets([0.0, 3000.0]));
    assert!(!meets([0.0, 40e3]), "nearly parallel");
    // Rays that meet behind a camera.
    assert!(
        cross(
            &measured(0, [-4000.0, 3000.0]),
            &measured(1, [4000.0, 3000.0]),
            0.1,
            &guess
        )
        .is_none()
    );
    assert!(cross(&measured(0, [0.0, 3000.0]), &measured(1, [0.0, 3000.0]), 60.0, &guess).is_none());
}

/// Heights tell ghosts from targets at once.
#[test]
fn directions_of_different_heights_do_not_meet() {
    let guess = cameras().initiation;
    let raised = |camera: usize, [east, north]: [f64; 2], up: f64| {
        let mut seen = bearing(camera, 0, [east, north], 0.0);
        let ground = (east - CAMERAS[camera][0]).hypot(north - CAMERAS[camera][1]);
        seen.kind = DetectionKind::BearingElevation;
        seen.values[1] = (up / ground).atan();
        seen.sigmas = Some([SIGMA_RAD, SIGMA_RAD, 0.0, 0.0]);
        DetectionMeasurement::of(&seen, None).unwrap()
    };
    let place = [200.0, 3000.0];
    let found = cross(&raised(0, place, 500.0), &raised(1, place, 500.0), 0.1, &guess).unwrap();
    assert_eq!(found.kind, DetectionKind::RangeBearingElevation);
    assert!((found.values[0] * found.values[2].sin() - 500.0).abs() < 1.0);
    assert!(cross(&raised(0, place, 500.0), &raised(1, place, 900.0), 0.1, &guess).is_none());
}

proptest! {
    /// Of any two rays, the crossing lies on both.
    #[test]
    fn a_crossing_lies_on_both_rays(east in -3000.0..3000.0f64, north in 200.0..9000.0f64, apart_s in 0.0..1.0f64) {
        let guess = cameras().initiation;
        let measured = |camera| DetectionMeasurement::of(&bearing(camera, 0, [east, north], 0.0), None).unwrap();
        if let Some(found) = cross(&measured(0), &measured(1), apart_s, &guess) {
            let ([x, y], _) = found.place().unwrap();
            prop_assert!((x - east).hypot(y - north) < 1e-3 * north, "{x} {y}");
            prop_assert!(found.sigmas[0] > 0.0 && found.sigmas[0] <= KNOWN * found.values[0]);
        }
    }

    #[test]
    fn a_late_scan_of_directions_is_as_one_in_time(seed in any::<u64>(), late in 1i64..16) {
        let mut chosen = cameras();
        chosen.capacity.open_scans = 4;
        let scans: Vec<(u32, i64, Vec<Detection>)> = {
            let mut random = Random::new(seed);
            (0..20_i64).map(|look| {
                let (camera, time_ns) = ((look % 2) as usize, look * S / 2);
                let seen = targets(time_ns as f64 / 1e9);
                let seen = seen.map(|target| bearing(camera, time_ns, target, SIGMA_RAD * gauss(&mut random)));
                (camera as u32 + 1, time_ns, seen.to_vec())
            }).collect()
        };
        let mut in_time = Tracker::new(chosen.clone()).unwrap();
        scans.iter().for_each(|(sensor, time_ns, seen)| in_time.scan(*sensor, *time_ns, seen).unwrap());
        let mut mixed = scans.clone();
        mixed.swap(late as usize, late as usize + 1);
        let mut after = Tracker::new(chosen).unwrap();
        mixed.iter().for_each(|(sensor, time_ns, seen)| after.scan(*sensor, *time_ns, seen).unwrap());
        prop_assert_eq!(in_time.tracks(), after.tracks());
        prop_assert_eq!(in_time.branches(), after.branches());
    }
}
