//! The tracker as a whole: what becomes of targets, clutter, late scans and hostile ones.

use std::f64::consts::TAU;

use messages::TrackState;
use observations::{Detection, DetectionKind};
use proptest::prelude::*;

use crate::clutter::SensorArea;
use crate::settings::{Limit, SensorFacts, SensorModel, Splitting};
use crate::testing::{S, position, settings};
use crate::{FieldOfView, ScanRejection, Settings, Tracker, TrackerCounts};

/// A number that looks random, in [-1, 1], for each step.
fn noise(step: u64) -> f64 {
    let mixed = (step + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Settings under which every detection in gates of two clusters joins them.
fn of_the_source() -> Settings {
    let mut chosen = settings();
    chosen.reduction.join_probability_min = 0.0;
    chosen
}

/// Settings under which new tracks stay tentative for so long that the options find something to reject.
fn slow() -> Settings {
    let mut chosen = of_the_source();
    chosen.confirmation.detections_min = 6;
    chosen
}

/// A target that flies east at 15 m/s, 8 m of noise.
fn flying(second: i64, north: f64) -> Detection {
    let step = second as u64 * 7 + (north.abs() as u64) * 131;
    let east = 15.0 * second as f64 + 8.0 * noise(step);
    position(second * S, east, north + 8.0 * noise(step + 3))
}

/// What a residual of fusion is made of (TI-6): the detection behind a track, and none of a scan without one.
#[test]
fn tracks_state_the_detection_that_updated_them() {
    let mut tracker = Tracker::new(settings()).unwrap();
    for second in 0..8i64 {
        let scan = match second {
            6 => vec![position(second * S, 20_000.0, 0.0)],
            _ => vec![
                position(second * S, 20_000.0, 0.0),
                position(second * S, 15.0 * second as f64 + (second % 2) as f64, 7.0),
            ],
        };
        tracker.scan(1, second * S, &scan).unwrap();
        let near = |track: &&crate::TrackReport| track.estimate.mean[0] < 1000.0;
        let Some(track) = tracker.tracks().iter().find(near) else {
            assert!(second < 5, "{second}: no track");
            continue;
        };
        let sample = track.sensor_track(0);
        let is_measured = sample.has(messages::sensor_track_bits::MEASURED);
        assert_eq!(is_measured, second != 6, "{second}");
        if is_measured {
            let [east, north, _] = sample.measured_m;
            assert_eq!([east, north], [15.0 * second as f64 + (second % 2) as f64, 7.0]);
        }
    }
    let mut picture = Vec::new();
    tracker.picture_at(9 * S, &mut picture);
    assert!(picture.iter().all(|track| track.measured_m.is_none()), "extrapolated");
}

#[test]
fn a_target_is_confirmed_carried_on_and_given_up() {
    let mut tracker = Tracker::new(settings()).unwrap();
    for second in 0..8 {
        tracker.scan(1, second * S, &[flying(second, 0.0)]).unwrap();
        assert!(
            tracker.tracks().is_empty() || second >= 2,
            "three detections are needed"
        );
    }
    let [track] = tracker.tracks() else {
        panic!("{:?}", tracker.tracks())
    };
    assert_eq!(
        (track.number, track.state, track.time_ns, track.missed),
        (1, TrackState::Confirmed, 7 * S, 0)
    );
    assert!((track.estimate.mean[0] - 105.0).abs() < 20.0 && (track.estimate.mean[3] - 15.0).abs() < 5.0);
    let message = track.sensor_track(3);
    assert_eq!(
        (message.source, message.track_number, message.state),
        (3, 1, TrackState::Confirmed as u8)
    );
    assert_eq!(message.position_m, track.estimate.position_m());
    for second in 8..11 {
        tracker.scan(1, second * S, &[]).unwrap();
        let [track] = tracker.tracks() else {
            panic!("given up after {} scans", second - 7)
        };
        assert_eq!(
            (track.number, track.state, track.time_ns),
            (1, TrackState::Coasted, second * S)
        );
        assert!(
            (track.estimate.mean[0] - 15.0 * second as f64).abs() < 40.0,
            "carried on"
        );
    }
    for second in 11..14 {
        tracker.scan(1, second * S, &[]).unwrap();
        assert_eq!(
            (tracker.tracks().len(), tracker.branches()),
            (0, 1),
            "kept, and not output"
        );
    }
    tracker.scan(1, 14 * S, &[]).unwrap();
    assert_eq!(
        (tracker.tracks().len(), tracker.branches(), tracker.clusters()),
        (0, 0, 0),
        "the seventh miss ends it"
    );
    for second in 20..28 {
        tracker.scan(1, second * S, &[flying(second, 0.0)]).unwrap();
    }
    assert_eq!(tracker.tracks()[0].number, 2, "a number is never used again");
}

#[test]
fn the_sources_rule_waits_until_no_other_hypothesis_is_left() {
    let mut strict = settings();
    strict.confirmation.reliability_min = 1.0;
    strict.confirmation.detections_min = 1;
    let mut tracker = Tracker::new(strict).unwrap();
    let mut confirmed = false;
    for second in 0..10 {
        tracker.scan(1, second * S, &[flying(second, 0.0)]).unwrap();
        let population = tracker.latest();
        confirmed |= population.hypotheses.len() == 1;
        assert_eq!(tracker.tracks().len(), usize::from(confirmed), "after {second} s");
    }
    assert_eq!(tracker.tracks().len(), 1);
}

/// Time of confirmation of a target that is seen every `every` tenths of a second, seconds.
fn confirmed_at_s(every: usize, change: impl Fn(&mut Settings)) -> Option<f64> {
    let mut chosen = settings();
    change(&mut chosen);
    let mut tracker = Tracker::new(chosen).unwrap();
    (0..200).step_by(every).find_map(|tenth| {
        let time_ns = tenth as i64 * S / 10;
        let seen = position(time_ns, 1.5 * tenth as f64, 0.0);
        tracker.scan(1, time_ns, &[seen]).unwrap();
        (!tracker.tracks().is_empty()).then_some(tenth as f64 / 10.0)
    })
}

#[test]
fn detections_of_a_moment_or_hardly_any_do_not_confirm() {
    let soon = confirmed_at_s(2, |_| ()).unwrap();
    assert!(soon < 2.0, "{soon}");
    let late = confirmed_at_s(2, |chosen| chosen.confirmation.span_min_s = Some(4.0));
    assert_eq!(late, Some(4.0));
    let rare = |most| confirmed_at_s(20, |chosen| chosen.confirmation.interval_max_s = Some(most));
    assert_eq!((rare(1.9), rare(2.0)), (None, confirmed_at_s(20, |_| ())));
    assert!(rare(2.0).is_some());
}

#[test]
fn the_likelihood_ratio_can_be_asked_for_besides() {
    let confirmed_at = |least: Option<f64>| {
        let mut asking = settings();
        asking.confirmation.log_likelihood_ratio_min = least;
        let mut tracker = Tracker::new(asking).unwrap();
        (0..30).find(|second| {
            tracker.scan(1, second * S, &[flying(*second, 0.0)]).unwrap();
            !tracker.tracks().is_empty()
        })
    };
    let (early, late) = (confirmed_at(None).unwrap(), confirmed_at(Some(60.0)).unwrap());
    assert!(early < late, "{early} {late}");
}

#[test]
fn what_several_branches_have_in_their_gates_is_left_out_of_the_clutter_once() {
    let mut chosen = settings();
    chosen.sensors[0].model.clutter_density = None;
    let mut tracker = Tracker::new(chosen).unwrap();
    for second in 0..80 {
        // Two targets that cannot be told apart, and four false detections far away, never twice in one place.
        let mut scan = vec![flying(second, 0.0), flying(second, 30.0)];
        let far = |place: i64| 1e5 * noise((4 * second + place) as u64 + 999);
        scan.extend((0..4).map(|place| position(second * S, far(place), 5e3 + 20.0 * far(place).abs())));
        tracker.scan(1, second * S, &scan).unwrap();
    }
    assert_eq!(tracker.tracks().len(), 2, "{:?}", tracker.tracks());
    let area_m2 = 1e16;
    let extent = SensorArea {
        width_rad: TAU,
        area_m2: Some(area_m2),
    };
    let count = tracker.latest().sensors[0].clutter.density(0, extent) * area_m2;
    assert!((count - 4.0).abs() < 0.2, "{count}");
}

#[test]
fn clutter_is_not_confirmed() {
    let mut tracker = Tracker::new(settings()).unwrap();
    for second in 0..200u64 {
        let anywhere = |k: u64| {
            position(
                second as i64 * S,
                3e3 * noise(second * 97 + k),
                3e3 * noise(second * 97 + k + 40),
            )
        };
        let scan: Vec<_> = (0..36).map(anywhere).collect();
        tracker.scan(1, second as i64 * S, &scan).unwrap();
    }
    assert_eq!(tracker.counts().confirmed, 0);
    assert!(tracker.branches() < 400, "{} tentative tracks", tracker.branches());
}

/// One target to 20 s, from then on two that part at 2 × 12 m/s. Scans of one second.
fn splitting(second: i64) -> Vec<Detection> {
    let apart = 12.0 * (second - 20) as f64;
    if second <= 20 {
        vec![flying(second, 0.0)]
    } else {
        vec![flying(second, apart), flying(second, -apart)]
    }
}

#[test]
fn every_splitting_option_and_all_together_find_both_targets() {
    let nothing = Splitting::default();
    type Choose = fn(&mut Splitting);
    let options: [(&str, Choose); 7] = [
        ("none", |_| ()),
        ("SP-1", |options| options.start_in_confirmed_gates = true),
        ("SP-2", |options| options.parents_motion = Some(3)),
        ("SP-3", |options| options.new_tracks_max = Limit::Fixed(1)),
        ("SP-4", |options| options.new_tracks_max = Limit::Computed),
        ("SP-6", |options| options.tentative_tracks = Limit::Computed),
        ("SP-7", |options| options.company_min = Some(0.4)),
    ];
    let mut together = nothing;
    options.iter().for_each(|(_, choose)| choose(&mut together));
    let singly = options.map(|(name, choose)| {
        let mut chosen = nothing;
        choose(&mut chosen);
        (name, chosen)
    });
    for (name, chosen) in singly.into_iter().chain([("together", together)]) {
        let mut tracker = Tracker::new(Settings {
            splitting: chosen,
            ..slow()
        })
        .unwrap();
        for second in 0..40 {
            let mut scan = splitting(second);
            // Clutter beside them now and then gives the options something to reject.
            if second % 4 == 2 {
                let beside = 60.0 + 40.0 * noise(second as u64 + 500);
                scan.push(position(second * S, 15.0 * second as f64 - beside, beside));
            }
            tracker.scan(1, second * S, &scan).unwrap();
            if (10..=20).contains(&second) {
                assert_eq!(tracker.tracks().len(), 1, "{name} at {second} s");
            }
        }
        let north: Vec<_> = tracker
            .tracks()
            .iter()
            .map(|track| track.estimate.mean[1].round())
            .collect();
        assert_eq!(north.len(), 2, "{name}: {north:?}");
        assert!(
            north[0] * north[1] < 0.0 && north.iter().all(|north| (north.abs() - 228.0).abs() < 25.0),
            "{name}: {north:?}"
        );
        let counts = tracker.counts();
        if name == "SP-1" {
            assert!(counts.starts_forbidden > 0);
        }
        assert!(
            counts.starts_forbidden == 0 || chosen.start_in_confirmed_gates,
            "{name}"
        );
        assert_eq!(
            counts.starts_with_parents_motion > 0,
            chosen.parents_motion.is_some(),
            "{name}"
        );
        assert!(counts.out_of_company == 0 || chosen.company_min.is_some(), "{name}");
        assert!(
            counts.too_many_new_tracks == 0 || chosen.new_tracks_max != Limit::Off,
            "{name}"
        );
        assert!(
            counts.too_many_tentative_tracks == 0 || chosen.tentative_tracks != Limit::Off,
            "{name}"
        );
    }
}

/// Counts of a tracker with this splitting, for a target that becomes two, and false detections beside them.
fn counts_with(choose: impl Fn(&mut Splitting)) -> TrackerCounts {
    let mut chosen = Splitting::default();
    choose(&mut chosen);
    let mut tracker = Tracker::new(Settings {
        splitting: chosen,
        ..slow()
    })
    .unwrap();
    for second in 0..40 {
        let mut scan = splitting(second);
        for number in 0..2 {
            let beside = (1.0 - 2.0 * number as f64) * (22.0 + 8.0 * noise(second as u64 + 500 * number));
            scan.push(position(second * S, 15.0 * second as f64 - beside, beside));
        }
        tracker.scan(1, second * S, &scan).unwrap();
    }
    *tracker.counts()
}

#[test]
fn each_option_of_splitting_rejects_what_it_names() {
    let plain = counts_with(|_| ());
    let rejected = [
        plain.starts_forbidden,
        plain.too_many_new_tracks,
        plain.too_many_tentative_tracks,
        plain.out_of_company,
    ];
    assert_eq!(rejected, [0; 4]);
    assert!(
        counts_with(|options| options.start_in_confirmed_gates = true).starts_forbidden > 0,
        "SP-1"
    );
    assert!(
        counts_with(|options| options.new_tracks_max = Limit::Fixed(0)).too_many_new_tracks > 0,
        "SP-3"
    );
    assert!(
        counts_with(|options| options.tentative_tracks = Limit::Fixed(1)).too_many_tentative_tracks > 0,
        "SP-5"
    );
    assert!(
        counts_with(|options| options.company_min = Some(0.9)).out_of_company > 0,
        "SP-7"
    );
}

#[test]
fn late_scans_give_the_same_as_in_time() {
    let mut open = settings();
    open.capacity.open_scans = 4;
    let second_sensor = SensorFacts {
        sensor_id: 2,
        ..open.sensors[0].clone()
    };
    open.sensors.push(second_sensor);
    let scans: Vec<_> = (0..40).map(|k| (1 + k as u32 % 2, k * S, splitting(k))).collect();
    let mut in_time = Tracker::new(open.clone()).unwrap();
    for (sensor, time_ns, scan) in &scans {
        in_time.scan(*sensor, *time_ns, scan).unwrap();
    }
    let mut late = Tracker::new(open).unwrap();
    // Every fifth scan comes after the next three.
    for group in scans.chunks(5) {
        for place in [1, 2, 3, 0, 4] {
            let (sensor, time_ns, scan) = &group[place];
            late.scan(*sensor, *time_ns, scan).unwrap();
        }
    }
    assert_eq!(late.latest(), in_time.latest());
    assert_eq!(late.tracks(), in_time.tracks());
    assert_eq!((in_time.counts().late_scans, late.counts().late_scans), (0, 8));
    assert_eq!(late.scan(1, 30 * S, &[]), Err(ScanRejection::TooLate));
    assert_eq!(late.scan(3, 99 * S, &[]), Err(ScanRejection::UnknownSensor(3)));
    assert_eq!(late.counts().rejected_scans, 2);
    assert_eq!(late.latest(), in_time.latest(), "what is refused changes nothing");
}

/// A detection of the target at `at` by a sensor of `kind` at `platform`, without noise.
fn seen(kind: DetectionKind, time_ns: i64, at: [f64; 3], platform_m: [f64; 3]) -> Detection {
    let [east, north, up] = std::array::from_fn(|axis| at[axis] - platform_m[axis]);
    let (ground, bearing) = (east.hypot(north), east.atan2(north));
    let (values, sigmas) = match kind {
        DetectionKind::Position2 | DetectionKind::Position3 => (at, [10.0; 4]),
        DetectionKind::RangeBearing => ([ground.hypot(up), bearing, 0.0], [10.0, 0.01, 0.0, 1.0]),
        DetectionKind::RangeBearingElevation => {
            ([ground.hypot(up), bearing, up.atan2(ground)], [10.0, 0.01, 0.01, 1.0])
        }
        DetectionKind::Bearing => ([bearing, 0.0, 0.0], [0.01, 0.0, 0.0, 1.0]),
        DetectionKind::BearingElevation => ([bearing, up.atan2(ground), 0.0], [0.01, 0.01, 0.0, 1.0]),
    };
    Detection {
        kind,
        values,
        sigmas: Some(sigmas),
        platform_m,
        ..position(time_ns, 0.0, 0.0)
    }
}

#[test]
fn sensors_of_every_kind_feed_one_track() {
    let mut mixed = settings();
    let sensor = |number: usize| SensorFacts {
        sensor_id: number as u32,
        ..SensorFacts::default()
    };
    mixed.sensors = (0..DetectionKind::ALL.len()).map(sensor).collect();
    let mut tracker = Tracker::new(mixed).unwrap();
    for second in 0..60 {
        let number = second as usize % DetectionKind::ALL.len();
        let at = [-500.0 + 15.0 * second as f64, 2e3, 100.0];
        let mut detection = seen(
            DetectionKind::ALL[number],
            second * S,
            at,
            [100.0, -50.0 * number as f64, 5.0],
        );
        let line: [f64; 3] = std::array::from_fn(|axis| at[axis] - detection.platform_m[axis]);
        let range = line.iter().map(|value| value * value).sum::<f64>().sqrt();
        if number != 0 {
            detection.range_rate_mps = Some(15.0 * line[0] / range);
        }
        tracker.scan(number as u32, second * S, &[detection]).unwrap();
    }
    let [track] = tracker.tracks() else {
        panic!("{:?}", tracker.tracks())
    };
    assert!(
        (30..=40).contains(&track.detections) && track.missed == 0,
        "40 scans were of positions: {track:?}"
    );
    for (found, expected) in track.estimate.mean.iter().zip([385.0, 2e3, 100.0, 15.0, 0.0, 0.0]) {
        assert!((found - expected).abs() < 8.0, "{:?}", track.estimate.mean);
    }
    assert_eq!(tracker.counts().rejected_detections, 0);
}

fn modelled(model: SensorModel) -> SensorFacts {
    SensorFacts {
        model,
        ..SensorFacts::default()
    }
}

/// Radar 1 every 4 s, and a second sensor whose scans come ten times a second and are given.
fn with_a_quick_sensor(
    coherence_s: f64,
    quick: SensorFacts,
    seconds: i64,
    scan: impl Fn(i64) -> Vec<Detection>,
) -> Tracker {
    let mut both = settings();
    both.deletion.coherence_s = coherence_s;
    both.sensors.push(SensorFacts { sensor_id: 2, ..quick });
    let mut tracker = Tracker::new(both).unwrap();
    for tenth in 0..10 * seconds {
        let time_ns = tenth * S / 10;
        if tenth % 40 == 0 {
            tracker.scan(1, time_ns, &[flying(tenth / 10, 0.0)]).unwrap();
        }
        // Nothing yet from the second sensor while the radar finds the target.
        if tenth >= 200 {
            tracker.scan(2, time_ns, &scan(tenth)).unwrap();
        }
    }
    tracker
}

#[test]
fn a_quick_sensor_that_sees_nothing_does_not_end_what_a_slow_one_sees() {
    let quick = modelled(SensorModel {
        detection_probability: Some(0.6),
        ..SensorModel::default()
    });
    let blind = |_| Vec::new();
    let kept = with_a_quick_sensor(1.0, quick.clone(), 60, blind);
    assert_eq!((kept.tracks().len(), kept.counts().confirmed), (1, 1));
    let literal = with_a_quick_sensor(0.01, quick.clone(), 60, blind);
    assert!(literal.tracks().is_empty(), "every look taken for a new one");
    // It does end a track that the slow one has lost as well.
    let mut lost = with_a_quick_sensor(1.0, quick, 24, blind);
    let confirmed = lost.tracks().len();
    for tenth in 240..440 {
        lost.scan(2, tenth * S / 10, &[]).unwrap();
    }
    assert_eq!((confirmed, lost.tracks().len()), (1, 0));
}

#[test]
fn a_quick_sensor_that_finds_nothing_leaves_open_choices_in_the_memory() {
    let mut both = settings();
    both.sensors.push(SensorFacts {
        sensor_id: 2,
        ..SensorFacts::default()
    });
    let mut tracker = Tracker::new(both).unwrap();
    for second in 0..4 {
        tracker.scan(1, second * S, &[flying(second, 0.0)]).unwrap();
    }
    tracker.scan(2, 3 * S, &[]).unwrap();
    let histories =
        |tracker: &Tracker| -> Vec<_> { tracker.latest().tracks.iter().map(|track| track.history).collect() };
    let before = histories(&tracker);
    for tenth in 31..40 {
        tracker.scan(2, tenth * S / 10, &[]).unwrap();
    }
    assert_eq!(histories(&tracker), before);
    tracker.scan(1, 4 * S, &[]).unwrap();
    assert_ne!(histories(&tracker), before, "a slow one's miss is remembered");
}

#[test]
fn outside_the_field_of_view_nothing_is_missed() {
    let ring = |range_m: [f64; 2], east: f64| {
        let field_of_view = Some(FieldOfView {
            range_m,
            sector_deg: None,
            position_m: Some([east, 0.0]),
        });
        modelled(SensorModel {
            detection_probability: Some(0.99),
            field_of_view,
            ..SensorModel::default()
        })
    };
    let silent = |tracker: Tracker| {
        tracker
            .latest()
            .tracks
            .iter()
            .map(|track| track.existence().ln())
            .sum::<f64>()
    };
    let run = |sensor| with_a_quick_sensor(1.0, sensor, 44, |_| Vec::new());
    // The target is 300 to 660 m east of the radar, known to about ten metres.
    let far_away = run(ring([0.0, 400.0], 5e3));
    assert_eq!(far_away.tracks().len(), 1);
    assert!(silent(far_away) > -0.1);
    let inside = run(ring([0.0, 5e3], 0.0));
    assert!(inside.tracks().is_empty(), "99 % would have been seen");
    // It enters the third a second before the end.
    let edge = run(ring([640.0, 5e3], 0.0));
    assert_eq!(edge.tracks().len(), 1);
    let silence = silent(edge);
    assert!(silence < -0.02 && silence > -0.7, "{silence}");
}

#[test]
fn beyond_every_field_of_view_a_track_is_kept_and_not_reported() {
    let mut both = settings();
    both.sensors[0].model.field_of_view = Some(FieldOfView {
        range_m: [0.0, 200.0],
        sector_deg: None,
        position_m: Some([0.0, 0.0]),
    });
    // 15 m/s: the target leaves the field of view in the fourteenth second.
    let missed = |settings: Settings| {
        let mut tracker = Tracker::new(settings).unwrap();
        for second in 0..13 {
            tracker.scan(1, second * S, &[flying(second, 0.0)]).unwrap();
        }
        let reported: Vec<usize> = (13..20)
            .map(|second| {
                tracker.scan(1, second * S, &[]).unwrap();
                tracker.tracks().len()
            })
            .collect();
        let returned = {
            tracker.scan(1, 20 * S, &[flying(20, 0.0)]).unwrap();
            tracker.tracks().iter().map(|track| track.number).collect::<Vec<_>>()
        };
        (reported, returned)
    };
    assert_eq!(missed(both.clone()), (vec![1, 1, 0, 0, 0, 0, 0], vec![1]));
    // Another sensor sees everything.
    both.sensors.push(SensorFacts {
        sensor_id: 2,
        ..SensorFacts::default()
    });
    assert_eq!(missed(both).0[3], 1);
}

#[test]
fn several_detections_of_one_hull_are_one_target() {
    let ends = |second: i64| {
        let (bow, mut stern) = (flying(second, 0.0), flying(second, 0.0));
        stern.values[0] -= 30.0 + 4.0 * noise(second as u64 + 900);
        [bow, stern]
    };
    let tracks = |resolution_m: Option<f64>| {
        let mut resolving = settings();
        resolving.sensors[0].model.resolution_m = resolution_m;
        let mut tracker = Tracker::new(resolving).unwrap();
        for second in 0..15 {
            tracker.scan(1, second * S, &ends(second)).unwrap();
        }
        (tracker.tracks().len(), tracker.counts().united_detections)
    };
    assert_eq!(tracks(Some(40.0)), (1, 15));
    assert_eq!(tracks(Some(20.0)), (2, 0), "so near they are two");
    assert_eq!(tracks(None), (2, 0));
}

/// A camera south of the target's path: bearings at the given offsets from the true one, radians.
fn bearings(tenth: i64, offsets: &[f64]) -> Vec<Detection> {
    let at = [1.5 * tenth as f64, 0.0, 0.0];
    let turned = |offset: &f64| {
        let mut detection = seen(DetectionKind::Bearing, tenth * S / 10, at, [600.0, -500.0, 0.0]);
        detection.values[0] += offset;
        detection
    };
    offsets.iter().map(turned).collect()
}

#[test]
fn directions_improve_a_track_and_do_no_harm() {
    let camera = || {
        modelled(SensorModel {
            detection_probability: Some(0.6),
            clutter_density: Some(0.5),
            ..SensorModel::default()
        })
    };
    let sigma_east = |tracker: &Tracker| {
        let [track] = tracker.tracks() else {
            panic!("{:?}", tracker.tracks())
        };
        let mean = track.estimate.mean;
        let expected = 15.0 * (track.time_ns as f64 / S as f64);
        assert!(
            (mean[0] - expected).abs() < 15.0 && mean[1].abs() < 15.0,
            "{mean:?} {expected}"
        );
        track.estimate.covariance.get(0, 0).sqrt()
    };
    let without = with_a_quick_sensor(1.0, camera(), 48, |_| Vec::new());
    let with = with_a_quick_sensor(1.0, camera(), 48, |tenth| bearings(tenth, &[0.0]));
    assert!(sigma_east(&with) < 0.7 * sigma_east(&without));
    assert_eq!(with.latest().hypotheses.len(), 1, "nothing branches");
    // Lights on the shore, always at the same side of the target: nothing begins, and the track stays.
    let lights = with_a_quick_sensor(1.0, camera(), 48, |tenth| bearings(tenth, &[-0.6, -0.3, 0.3, 0.6, 0.9]));
    assert!(sigma_east(&lights) < 1.3 * sigma_east(&without));
    assert_eq!(lights.branches(), 1);
    // A camera that sees the target keeps its track when the radar has lost it, and not for ever when neither does.
    let mut kept = with;
    for tenth in 480..800 {
        if tenth % 40 == 0 {
            kept.scan(1, tenth * S / 10, &[]).unwrap();
        }
        kept.scan(2, tenth * S / 10, &bearings(tenth, &[0.0])).unwrap();
    }
    assert_eq!(kept.tracks().len(), 1);
    for tenth in 800..1600 {
        kept.scan(2, tenth * S / 10, &bearings(tenth, &[0.9])).unwrap();
    }
    assert!(kept.tracks().is_empty());
}

#[test]
fn directions_that_come_late_give_the_same() {
    let mut open = settings();
    open.capacity.open_scans = 4;
    open.sensors.push(SensorFacts {
        sensor_id: 2,
        ..SensorFacts::default()
    });
    let scans: Vec<_> = (0..60)
        .map(|k| {
            let scan = match k % 3 {
                0 => vec![flying(k, 0.0)],
                1 => bearings(10 * k, &[0.01, 0.3]),
                _ => Vec::new(),
            };
            (1 + u32::from(k % 3 != 0), k * S, scan)
        })
        .collect();
    let (mut in_time, mut late) = (Tracker::new(open.clone()).unwrap(), Tracker::new(open).unwrap());
    for group in scans.chunks(4) {
        for place in 0..4 {
            let (sensor, time_ns, scan) = &group[place];
            in_time.scan(*sensor, *time_ns, scan).unwrap();
            let (sensor, time_ns, scan) = &group[[1, 0, 3, 2][place]];
            late.scan(*sensor, *time_ns, scan).unwrap();
        }
    }
    assert_eq!(late.latest(), in_time.latest());
    assert_eq!((in_time.counts().late_scans, late.counts().late_scans), (0, 30));
}

#[test]
fn what_the_bounds_cost_is_told() {
    let mut tracker = Tracker::new(settings()).unwrap();
    assert_eq!(tracker.counts().dropped_probability_mean(), 0.0);
    for second in 0..30 {
        tracker.scan(1, second * S, &splitting(second)).unwrap();
    }
    let counts = tracker.counts();
    let mean = counts.dropped_probability_mean();
    assert!(mean > 0.0 && mean < counts.dropped_probability_max, "{counts:?}");
    assert!(counts.dropped_probability_max <= 1.0 && counts.cluster_updates >= 29);
}

#[test]
fn bearings_alone_begin_nothing() {
    let mut tracker = Tracker::new(settings()).unwrap();
    for second in 0..20 {
        let detection = seen(DetectionKind::Bearing, second * S, [500.0, 2e3, 0.0], [0.0; 3]);
        tracker.scan(1, second * S, &[detection]).unwrap();
        assert_eq!(tracker.branches(), 0);
    }
}

#[test]
fn unusable_detections_are_counted_and_left_out() {
    let mut tracker = Tracker::new(settings()).unwrap();
    let good = position(S, 1.0, 2.0);
    let bad = [
        position(S, f64::NAN, 0.0),
        position(S, 0.0, f64::INFINITY),
        position(S + 61 * S, 0.0, 0.0),
        position(i64::MIN, 0.0, 0.0),
        Detection {
            sigmas: Some([0.0, 1.0, 0.0, 0.0]),
            ..good
        },
        Detection { sigmas: None, ..good },
        Detection {
            range_rate_mps: Some(f64::NAN),
            ..good
        },
        Detection {
            platform_m: [f64::NAN; 3],
            ..good
        },
        Detection {
            kind: DetectionKind::RangeBearing,
            values: [-1.0, 0.0, 0.0],
            ..good
        },
    ];
    tracker.scan(1, S, &[&bad[..], &[good]].concat()).unwrap();
    assert_eq!(
        (tracker.counts().rejected_detections, tracker.counts().detections),
        (9, 1)
    );
    assert_eq!(tracker.branches(), 1);
    assert_eq!(
        tracker.scan(1, 0, &[good]),
        Err(ScanRejection::TooLate),
        "times go backwards"
    );
}

#[test]
fn hostile_scans_are_bounded_and_counted() {
    let mut small = settings();
    small.capacity.detections = Some(2000);
    let mut tracker = Tracker::new(small).unwrap();
    for second in 0..6 {
        tracker.scan(1, second * S, &[flying(second, 0.0)]).unwrap();
    }
    // Ten thousand in one gate, then as many in one place, then silence for minutes, then the same again.
    let crowd = |second: i64, spread: f64| -> Vec<_> {
        let near = |k: u64| position(second * S, 90.0 + spread * noise(3 * k), spread * noise(3 * k + 1));
        (0..10_000).map(near).collect()
    };
    for (second, spread) in [(6, 30.0), (7, 30.0), (8, 0.0), (9, 0.0), (400, 30.0), (401, 0.0)] {
        tracker.scan(1, second * S, &crowd(second, spread)).unwrap();
        assert!(tracker.branches() <= 1024);
        let population = tracker.latest();
        assert!(
            population
                .clusters
                .iter()
                .all(|cluster| cluster.tracks.len() <= crate::CLUSTER_TRACKS_MAX)
        );
        assert!(
            population
                .tracks
                .iter()
                .all(|track| track.motion.estimate().mean.iter().all(|value| value.is_finite()))
        );
    }
    let counts = tracker.counts();
    assert_eq!((counts.detections, counts.dropped_detections), (6 + 6 * 2000, 6 * 8000));
    assert!(
        counts.dropped_comparisons > 0 && counts.dropped_pairs > 0 && counts.dropped_tracks > 0,
        "{counts:?}"
    );
    tracker.scan(1, 10_000 * S, &[]).unwrap();
    assert_eq!(tracker.branches(), 0, "silence ends every track");
}

#[test]
fn settings_are_checked() {
    assert_eq!(settings::check(&Settings::default()), Ok(()));
    let wrong: [fn(&mut Settings); 8] = [
        |settings| settings.gate.probability = 1.0,
        |settings| settings.sensors[0].model.detection_probability = Some(1.0),
        |settings| settings.sensors[0].model.clutter_density = Some(0.0),
        |settings| settings.reduction.hypotheses_max = 65,
        |settings| settings.deletion.coherence_s = 0.0,
        |settings| settings.deletion.limits.existence_min = 1.0,
        |settings| settings.sensors[0].model.resolution_m = Some(-1.0),
        |settings| settings.motion.process_noise_m2ps3[0] = f64::NAN,
    ];
    for wrong in wrong {
        let mut faulty = settings();
        wrong(&mut faulty);
        assert!(Tracker::new(faulty).is_err());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn each_cluster_sums_to_one_and_shares_nothing_with_others(
        scans in prop::collection::vec(prop::collection::vec((-150.0..150.0f64, -150.0..150.0f64), 0..6), 1..8),
    ) {
        let mut tracker = Tracker::new(of_the_source()).unwrap();
        for (second, places) in (0..).zip(&scans) {
            let scan: Vec<_> = places.iter().map(|(east, north)| position(second * S, *east, *north)).collect();
            tracker.scan(1, second * S, &scan).unwrap();
            let population = tracker.latest();
            let mut owners = std::collections::BTreeMap::new();
            for (number, cluster) in population.clusters.iter().enumerate() {
                let hypotheses = &population.hypotheses[cluster.hypotheses.start as usize..cluster.hypotheses.end as usize];
                let sum: f64 = hypotheses.iter().map(|hypothesis| hypothesis.log_reliability.exp()).sum();
                prop_assert!((sum - 1.0).abs() < 1e-9);
                for hypothesis in hypotheses {
                    let tracks: Vec<_> = population.members_of(hypothesis).iter().map(|track| &population.tracks[*track as usize]).collect();
                    for (place, one) in tracks.iter().enumerate() {
                        for other in &tracks[place + 1..] {
                            let common = one.history.iter().any(|serial| *serial != 0 && other.history.contains(serial));
                            prop_assert!(!common && one.root != other.root, "two tracks with the same detection");
                        }
                    }
                }
                for track in &population.tracks[cluster.tracks.start as usize..cluster.tracks.end as usize] {
                    prop_assert!(track.reliability > 0.0 && track.reliability < 1.0 + 1e-9);
                    for serial in track.history.iter().filter(|serial| **serial != 0) {
                        prop_assert_eq!(*owners.entry(*serial).or_insert(number), number, "clusters share a detection");
                    }
                }
            }
        }
    }
}
