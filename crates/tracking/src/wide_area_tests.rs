//! Wide-area support in the tracker as a whole: when reports are used, what each option does, what bad ones do.

use observations::Detection;

use settings::{Degrees, Seconds};

use crate::settings::{Confirmation, Deletion, SensorFacts};
use crate::testing::{S, position, settings};
use crate::wide_area::correction::Rule;
use crate::wide_area::group::Groups;
use crate::wide_area::prior::{Circle, Knowledge, Prior, Sector};
use crate::wide_area::settings::{EarlyConfirmation, EarlyDeletion};
use crate::wide_area::{ReportRejection, TARGETS_MAX, WideAreaReport};
use crate::{Settings, Tracker};

fn report(time_s: i64, arrival_s: i64, targets: u32) -> WideAreaReport {
    WideAreaReport {
        time_ns: time_s * S,
        arrival_ns: arrival_s * S,
        position_m: [15.0 * time_s as f64 + 300.0, -400.0, 0.0],
        velocity_mps: [15.0, 0.0, 0.0],
        targets,
        origin_m: None,
    }
}

/// Two targets side by side, of which every fifth scan shows both; otherwise one detection in the middle.
fn pair(second: i64) -> Vec<Detection> {
    let east = 15.0 * second as f64;
    if second % 5 == 3 {
        vec![
            position(second * S, east + 3.0, 40.0),
            position(second * S, east - 4.0, -40.0),
        ]
    } else {
        let off = 4.0 * ((second * 7) % 5 - 2) as f64;
        vec![position(second * S, east + off, -off)]
    }
}

/// Reliability of all hypotheses with at least `tracks` tracks, of a tracker with one cluster.
fn reliability_of(tracker: &Tracker, tracks: usize) -> f64 {
    let population = tracker.latest();
    let hypotheses = population.hypotheses.iter();
    let enough = hypotheses.filter(|hypothesis| hypothesis.members.len() >= tracks);
    enough.map(|hypothesis| hypothesis.log_reliability.exp()).sum()
}

#[test]
fn a_report_is_used_once_in_the_first_scan_after_its_arrival() {
    let mut plain = Tracker::new(settings()).unwrap();
    let mut supported = Tracker::new(settings()).unwrap();
    supported.wide_area(&report(4, 9, 2)).unwrap();
    for second in 0..13 {
        plain.scan(1, second * S, &pair(second)).unwrap();
        supported.scan(1, second * S, &pair(second)).unwrap();
        let used = supported.counts().wide_area_reports_used;
        assert_eq!(used, u64::from(second >= 9), "at {second} s");
        if second < 9 {
            assert_eq!(plain.latest(), supported.latest());
        }
        if second == 9 {
            assert!(reliability_of(&plain, 2) < 0.4, "{}", reliability_of(&plain, 2));
            assert!(
                reliability_of(&supported, 2) >= 0.6 - 1e-3,
                "{}",
                reliability_of(&supported, 2)
            );
        }
    }
    assert_eq!(supported.counts().wide_area_corrections, 1);
    assert_eq!(plain.counts().detections, supported.counts().detections);
}

#[test]
fn the_search_for_a_second_target_does_not_keep_the_first_from_being_believed() {
    // Along north the sensor is so coarse that any false detection may be a second target; each scan is told of two.
    let confirmed = |confirmed_only: bool, reported: bool| {
        let mut chosen = settings();
        chosen.sensors[0].model.clutter_density = None;
        chosen.wide_area.corrects_confirmed_only = confirmed_only;
        let mut tracker = Tracker::new(chosen).unwrap();
        let mut shown = 0;
        for second in 0..40 {
            if reported && second > 0 {
                tracker.wide_area(&report(second - 1, second, 2)).unwrap();
            }
            let coarse = |east: f64, north: f64| Detection {
                sigmas: Some([10.0, 1900.0, 0.0, 0.0]),
                ..position(second * S, east, north)
            };
            let wobble = 3.0 * ((second * 7) % 5 - 2) as f64;
            let clutter = ((second * 7919) % 4001 - 2000) as f64 * 10.0;
            let scan = [
                coarse(15.0 * second as f64 + wobble, 20.0 * wobble),
                coarse(clutter, 1.5 * clutter),
            ];
            tracker.scan(1, second * S, &scan).unwrap();
            shown += tracker.tracks().len();
        }
        shown
    };
    let (plain, with, source) = (confirmed(true, false), confirmed(true, true), confirmed(false, true));
    assert!(plain > 20 && with >= plain, "{plain} {with} {source}");
    assert!(source < plain, "{plain} {with} {source}");
}

#[test]
fn what_a_report_asked_for_is_kept_until_the_next_one() {
    // Reliability of two tracks after four scans that show one detection.
    let left = |held: Option<Rule>, valid_s: i64| {
        let mut chosen = settings();
        chosen.wide_area.held = held;
        chosen.wide_area.valid_s = Seconds::of_ns(valid_s * S);
        let mut tracker = Tracker::new(chosen).unwrap();
        tracker.wide_area(&report(4, 9, 2)).unwrap();
        for second in 0..18 {
            tracker.scan(1, second * S, &pair(second)).unwrap();
        }
        (reliability_of(&tracker, 2), tracker.counts().wide_area_corrections)
    };
    let kept = Some(Rule::Share(0.1));
    let (without, with, until_14_s) = (left(None, 60), left(kept, 60), left(kept, 10));
    // A miss costs nine tenths, and a tenth is what they began with.
    assert!(without.0 < 1e-3 && with.0 > 5e-3, "{without:?} {with:?}");
    assert!(until_14_s.0 < 1e-3, "{until_14_s:?}: no longer valid");
    assert_eq!((without.1, with.1), (1, 1), "what is kept is no correction");
}

#[test]
fn without_reports_no_option_changes_anything() {
    let mut with_all = settings();
    with_all.wide_area.confirmation = Some(early_confirmation());
    with_all.wide_area.deletion = Some(early_deletion());
    with_all.wide_area.groups = Some(Groups { probability_min: 0.5 });
    with_all.wide_area.correction = Some(Rule::Factor(100.0));
    let (mut plain, mut all) = (Tracker::new(settings()).unwrap(), Tracker::new(with_all).unwrap());
    for second in 0..40 {
        for tracker in [&mut plain, &mut all] {
            tracker.scan(1, second * S, &pair(second)).unwrap();
        }
        assert_eq!((plain.latest(), plain.tracks()), (all.latest(), all.tracks()));
    }
}

#[test]
fn late_scans_see_the_same_reports() {
    let mut open = settings();
    open.capacity.open_scans = 4;
    open.wide_area.confirmation = Some(early_confirmation());
    let second_sensor = SensorFacts {
        sensor_id: 2,
        ..open.sensors[0].clone()
    };
    open.sensors.push(second_sensor);
    let scans: Vec<_> = (0..40).map(|k| (1 + k as u32 % 2, k * S, pair(k))).collect();
    let reports: Vec<_> = (1..7).map(|k| report(5 * k - 3, 5 * k + 3, 2)).collect();
    let mut in_time = Tracker::new(open.clone()).unwrap();
    for (sensor, time_ns, scan) in &scans {
        for report in reports.iter().filter(|report| report.arrival_ns == *time_ns) {
            in_time.wide_area(report).unwrap();
        }
        in_time.scan(*sensor, *time_ns, scan).unwrap();
    }
    let mut late = Tracker::new(open).unwrap();
    for group in scans.chunks(5) {
        for place in [1, 2, 3, 0, 4] {
            let (sensor, time_ns, scan) = &group[place];
            late.scan(*sensor, *time_ns, scan).unwrap();
        }
        // The reports themselves come later than they say.
        let (first_ns, last_ns) = (group[0].1, group[4].1);
        for report in reports
            .iter()
            .filter(|report| (first_ns..=last_ns).contains(&report.arrival_ns))
        {
            late.wide_area(report).unwrap();
        }
    }
    assert_eq!(late.latest(), in_time.latest());
    assert_eq!(late.tracks(), in_time.tracks());
    assert!(in_time.counts().wide_area_corrections > 2);
}

#[test]
fn a_report_older_than_all_open_scans_is_used_in_the_next_one() {
    let mut tracker = Tracker::new(settings()).unwrap();
    for second in 0..8 {
        tracker.scan(1, second * S, &pair(second)).unwrap();
    }
    let before = tracker.latest().clone();
    tracker.wide_area(&report(1, 3, 2)).unwrap();
    assert_eq!(tracker.latest(), &before, "what is closed stays");
    tracker.scan(1, 8 * S, &pair(8)).unwrap();
    assert_eq!(tracker.counts().wide_area_reports_used, 1);
}

fn early_confirmation() -> EarlyConfirmation {
    EarlyConfirmation {
        new_target_share: 1.0,
        beside_confirmed_only: false,
        confirmation: Confirmation {
            reliability_min: 0.55,
            detections_min: 2,
            log_likelihood_ratio_min: None,
            ..Confirmation::default()
        },
        company_min: 0.0,
    }
}

#[test]
fn new_tracks_are_confirmed_earlier_where_more_targets_were_reported() {
    let confirmed_at = |early: Option<EarlyConfirmation>, reported: bool| {
        let mut chosen = settings();
        chosen.wide_area.confirmation = early;
        chosen.wide_area.tracks_min = 0.0;
        let mut tracker = Tracker::new(chosen).unwrap();
        let at = (0..20).find(|second| {
            if reported && *second == 1 {
                tracker.wide_area(&report(0, 1, 1)).unwrap();
            }
            let seen = position(second * S, 15.0 * *second as f64, 0.0);
            tracker.scan(1, second * S, &[seen]).unwrap();
            !tracker.tracks().is_empty()
        });
        (at.unwrap(), tracker.counts().wide_area_confirmations)
    };
    let (without, _) = confirmed_at(None, true);
    let (silent, none) = confirmed_at(Some(early_confirmation()), false);
    let (with, some) = confirmed_at(Some(early_confirmation()), true);
    assert!(with < without && silent == without, "{with} {without} {silent}");
    assert_eq!((none, some), (0, 1));
}

#[test]
fn no_more_tracks_are_confirmed_earlier_than_targets_were_reported() {
    let confirmed = |reported: u32| {
        let mut chosen = settings();
        chosen.wide_area.confirmation = Some(early_confirmation());
        chosen.wide_area.tracks_min = 0.0;
        let mut tracker = Tracker::new(chosen).unwrap();
        for second in 0..5 {
            if second == 1 {
                tracker.wide_area(&report(0, 1, reported)).unwrap();
            }
            // Two targets so near to each other that their tracks share a cluster.
            let seen = [0.0, 25.0].map(|y| position(second * S, 15.0 * second as f64, y));
            tracker.scan(1, second * S, &seen).unwrap();
        }
        assert_eq!(tracker.clusters(), 1);
        (tracker.counts().wide_area_confirmations, tracker.tracks().len())
    };
    assert_eq!(confirmed(1), (1, 2), "the other one is confirmed as without a report");
    assert_eq!(confirmed(2), (2, 2));
}

fn early_deletion() -> EarlyDeletion {
    EarlyDeletion {
        deletion: Deletion {
            existence_min: 0.95,
            silent_s: Seconds::of(30.0),
        },
        coverage: None,
    }
}

/// Seconds for which a cluster lives on after its target has left at 10 s.
fn lifetime_s(deletion: Option<EarlyDeletion>, reports: &[WideAreaReport]) -> i64 {
    let mut chosen = settings();
    chosen.wide_area.deletion = deletion;
    let mut tracker = Tracker::new(chosen).unwrap();
    for second in 0..60 {
        for report in reports.iter().filter(|report| report.arrival_ns == second * S) {
            tracker.wide_area(report).unwrap();
        }
        let seen = position(second * S, 15.0 * second as f64, 0.0);
        let scan = if second <= 10 { vec![seen] } else { Vec::new() };
        tracker.scan(1, second * S, &scan).unwrap();
        if second > 10 && tracker.clusters() == 0 {
            return second - 10;
        }
    }
    panic!("never given up");
}

#[test]
fn clusters_are_given_up_earlier_only_where_absence_was_seen() {
    let none = report(9, 11, 0);
    let there = report(9, 11, 1);
    let elsewhere = WideAreaReport {
        position_m: [80e3, 0.0, 0.0],
        ..report(9, 11, 3)
    };
    let early = early_deletion();
    let watching = |radius_m| EarlyDeletion {
        coverage: Some(Circle {
            centre_m: [0.0; 2],
            radius_m,
        }),
        ..early
    };
    let cases = [
        ("without support", None, vec![none], 7),
        ("none reported there", Some(early), vec![none], 2),
        (
            "none reported where a target was",
            Some(early),
            vec![report(8, 9, 1), none],
            2,
        ),
        ("silence is not absence", Some(early), vec![], 7),
        ("a target reported there", Some(early), vec![there], 7),
        ("later report holds", Some(early), vec![none, report(10, 11, 1)], 7),
        ("seen elsewhere, place not covered", Some(early), vec![elsewhere], 7),
        (
            "seen elsewhere, place covered",
            Some(watching(100e3)),
            vec![elsewhere],
            2,
        ),
        (
            "seen elsewhere, place out of coverage",
            Some(watching(100.0)),
            vec![elsewhere],
            7,
        ),
        (
            "others seen later, place covered",
            Some(watching(100e3)),
            vec![report(8, 9, 1), elsewhere],
            7,
        ),
        ("covered, but silent", Some(watching(100e3)), vec![], 7),
        (
            "covered, and a target there",
            Some(watching(100e3)),
            vec![elsewhere, there],
            7,
        ),
    ];
    for (name, deletion, reports, expected) in cases {
        assert_eq!(lifetime_s(deletion, &reports), expected, "{name}");
    }
}

#[test]
fn fours_are_counted_on_only_in_their_sector() {
    let four_from = |bearings_deg| {
        let mut chosen = settings();
        chosen.splitting.new_target_share = Some(1.0);
        chosen.wide_area.knowledge = Knowledge {
            types: Vec::new(),
            priors: vec![Prior {
                sector: Some(Sector {
                    from_m: [0.0, -5000.0],
                    bearings_deg,
                }),
                formations: [("4".to_owned(), 0.8)].into(),
                ..Prior::default()
            }],
        };
        let mut tracker = Tracker::new(chosen).unwrap();
        for second in 0..10 {
            tracker.scan(1, second * S, &pair(second)).unwrap();
        }
        tracker.wide_area(&report(6, 10, 2)).unwrap();
        let four = [(-25.0, 10.0), (8.0, -20.0), (22.0, 12.0), (0.0, 28.0)];
        let scan = four.map(|(east, north)| position(10 * S, 150.0 + east, north));
        tracker.scan(1, 10 * S, &scan).unwrap();
        reliability_of(&tracker, 4)
    };
    let (inside, outside) = (
        four_from([6.0, 0.5].map(Degrees::of_rad)),
        four_from([1.0, 2.0].map(Degrees::of_rad)),
    );
    assert!(inside > 0.55 && outside < 0.5, "{inside} {outside}");
}

#[test]
fn targets_that_are_not_told_apart_are_published_as_a_group() {
    let mut chosen = settings();
    chosen.wide_area.correction = None;
    chosen.wide_area.groups = Some(Groups { probability_min: 0.5 });
    let mut tracker = Tracker::new(chosen).unwrap();
    for second in 0..12 {
        let together = position(second * S, 15.0 * second as f64, 0.0);
        tracker.scan(1, second * S, &[together]).unwrap();
    }
    assert_eq!(tracker.tracks()[0].group, None);
    tracker.wide_area(&report(8, 12, 3)).unwrap();
    tracker.scan(1, 12 * S, &[position(12 * S, 180.0, 0.0)]).unwrap();
    let [track] = tracker.tracks() else { panic!() };
    let group = track.group.unwrap();
    assert!(group.members == 3 && group.probability > 0.99, "{group:?}");
    assert_eq!(track.number, 1, "the group goes on under the track's number");
    for second in 13..60 {
        tracker
            .scan(1, second * S, &[position(second * S, 15.0 * second as f64, 0.0)])
            .unwrap();
    }
    assert_eq!(tracker.tracks()[0].group, None, "the report is no longer valid");
}

#[test]
fn bad_reports_are_refused_counted_and_change_nothing() {
    let (mut tracker, mut untouched) = (Tracker::new(settings()).unwrap(), Tracker::new(settings()).unwrap());
    for second in 0..8 {
        tracker.scan(1, second * S, &pair(second)).unwrap();
        untouched.scan(1, second * S, &pair(second)).unwrap();
    }
    let good = report(6, 8, 2);
    let place = |position_m| WideAreaReport { position_m, ..good };
    let cases = [
        (
            report(6, 8, 10_000),
            ReportRejection::TooManyTargets(10_000),
            "10000 targets",
        ),
        (
            report(6, 8, TARGETS_MAX + 1),
            ReportRejection::TooManyTargets(257),
            "at most 256",
        ),
        (
            report(8, 6, 2),
            ReportRejection::NegativeDelay,
            "before it was observed",
        ),
        (report(6, 600, 2), ReportRejection::TooLate(594 * S), "594.0 s after"),
        (place([f64::NAN, 0.0, 0.0]), ReportRejection::NoPlace, "must be numbers"),
        (place([0.0, 1e12, 0.0]), ReportRejection::NoPlace, "must be numbers"),
        (
            WideAreaReport {
                velocity_mps: [f64::INFINITY; 3],
                ..good
            },
            ReportRejection::NoPlace,
            "must be numbers",
        ),
        (
            WideAreaReport {
                time_ns: i64::MIN,
                arrival_ns: i64::MAX,
                ..good
            },
            ReportRejection::TooLate(i64::MAX),
            "after the observation",
        ),
    ];
    for (number, (bad, expected, sentence)) in cases.iter().enumerate() {
        let refusal = tracker.wide_area(bad).unwrap_err();
        assert_eq!(refusal, *expected);
        assert!(refusal.to_string().contains(sentence), "{refusal}");
        assert_eq!(tracker.counts().wide_area_reports_rejected, number as u64 + 1);
    }
    for far in [place([90e3, 0.0, 0.0]), report(6, 8, 0)] {
        tracker.wide_area(&far).unwrap();
    }
    tracker.scan(1, 8 * S, &pair(8)).unwrap();
    untouched.scan(1, 8 * S, &pair(8)).unwrap();
    assert_eq!(
        tracker.latest(),
        untouched.latest(),
        "no cluster is there, and none is no number to correct by"
    );
    assert_eq!(tracker.counts().wide_area_reports_unmatched, 1);
}

#[test]
fn hostile_numbers_and_floods_of_reports_are_bounded() {
    let mut tracker = Tracker::new(settings()).unwrap();
    let mut refused = 0;
    for second in 0..20 {
        let crowd = (0..40).map(|k| position(second * S, 30.0 * (k % 7) as f64, 30.0 * (k / 7) as f64));
        for targets in [1, 3, 17, 200, 256] {
            for again in 0..60 {
                let flood = WideAreaReport {
                    position_m: [again as f64, 0.0, 0.0],
                    ..report(second, second, targets)
                };
                refused += u64::from(tracker.wide_area(&flood).is_err());
            }
        }
        tracker.scan(1, second * S, &crowd.collect::<Vec<_>>()).unwrap();
    }
    assert!(refused > 0, "more than there is room for");
    assert_eq!(tracker.counts().wide_area_reports_rejected, refused);
    for cluster in &tracker.latest().clusters {
        let hypotheses =
            &tracker.latest().hypotheses[cluster.hypotheses.start as usize..cluster.hypotheses.end as usize];
        let sum: f64 = hypotheses
            .iter()
            .map(|hypothesis| hypothesis.log_reliability.exp())
            .sum();
        assert!((sum - 1.0).abs() < 1e-9);
    }
}

#[test]
fn detections_are_refused_by_age_and_accuracy() {
    let mut chosen = settings();
    chosen.capacity.open_scans = 4;
    chosen.selection.age_max_s = Some(Seconds::of(2.0));
    chosen.selection.sigma_max_m = Some(50.0);
    let mut tracker = Tracker::new(chosen).unwrap();
    for second in [0, 1, 2, 3, 4] {
        tracker.scan(1, second * S, &pair(second)).unwrap();
    }
    assert_eq!(tracker.counts().deselected_detections, 0);
    tracker.scan(1, S + 1, &[position(S + 1, 0.0, 0.0)]).unwrap();
    assert_eq!(tracker.counts().deselected_detections, 1, "three seconds old");
    let coarse = Detection {
        sigmas: Some([20.0, 51.0, 0.0, 0.0]),
        ..position(5 * S, 75.0, 0.0)
    };
    tracker.scan(1, 5 * S, &[coarse]).unwrap();
    assert_eq!(tracker.counts().deselected_detections, 2);
}

/// Sensor 2 says of the same target at the same times that it is elsewhere.
fn two_sensors(chosen: Settings, order: [u32; 2]) -> Tracker {
    let mut chosen = chosen;
    let second_sensor = SensorFacts {
        sensor_id: 2,
        priority: chosen.sensors[0].priority / 2,
        ..chosen.sensors[0].clone()
    };
    chosen.sensors.push(second_sensor);
    let mut tracker = Tracker::new(chosen).unwrap();
    for second in 0..20 {
        for sensor in order {
            let off = if sensor == 2 { 25.0 } else { 0.0 };
            let time_ns = second * S + if sensor == 2 { 1000 } else { 0 };
            let seen = position(time_ns, 15.0 * second as f64, off);
            tracker.scan(sensor, time_ns, &[seen]).unwrap();
        }
    }
    tracker
}

#[test]
fn of_scans_at_the_same_time_only_the_highest_priority_counts() {
    let mut ranked = settings();
    ranked.sensors[0].priority = 5;
    ranked.selection.same_time_s = Seconds::of(0.1);
    assert_eq!(
        ranked.capacity.open_scans, 0,
        "scans are compared whether or not late ones are awaited"
    );
    let mut plain = settings();
    plain.capacity.open_scans = 4;
    let north = |tracker: &Tracker| tracker.tracks()[0].estimate.mean[1];
    for order in [[1, 2], [2, 1]] {
        let tracker = two_sensors(ranked.clone(), order);
        assert!(north(&tracker).abs() < 1.0, "{}", north(&tracker));
        assert!(tracker.counts().outranked_scans > 15);
        assert_eq!(tracker.tracks()[0].missed, 0, "no miss");
        assert!(north(&two_sensors(plain.clone(), order)) > 5.0);
    }
    ranked.selection.kept_weight = Some(0.0);
    let kept = two_sensors(ranked.clone(), [1, 2]);
    assert!(
        north(&kept).abs() < 1.0 && kept.tracks()[0].missed == 1,
        "seen, but taken for false"
    );
    ranked.selection.kept_weight = Some(0.5);
    assert!(north(&two_sensors(ranked, [1, 2])) > 5.0, "taken, though less reliable");
}

#[test]
fn cues_and_pictures_are_predictions() {
    let mut tracker = Tracker::new(settings()).unwrap();
    let mut looks = crate::wide_area::cue::LookTimes::of([1, 9].into_iter());
    for second in 0..20 {
        let seen = position(second * S, 15.0 * second as f64, 0.0);
        tracker.scan(1, second * S, &[seen]).unwrap();
        looks.saw(1, second * S);
    }
    assert_eq!(looks.next(0).collect::<Vec<_>>(), [(1, 20 * S)]);
    let (mut cues, mut picture) = (Vec::new(), Vec::new());
    tracker.cues_at((1, 20 * S), 10.0, &mut cues);
    let [cue] = &cues[..] else { panic!("{cues:?}") };
    assert!(
        (cue.position_m[0] - 300.0).abs() < 2.0 && (cue.velocity_mps[0] - 15.0).abs() < 1.0,
        "{cue:?}"
    );
    // A detection's gate: more than three of its standard deviations, and wider when it is longer until the look.
    assert!(cue.half_axes_m[1] > 30.0 && cue.half_axes_m[0] < 60.0 && cue.track_number == 1);
    let narrow = cue.half_axes_m[0];
    tracker.cues_at((1, 25 * S), 10.0, &mut cues);
    assert!(cues[0].half_axes_m[0] > narrow);
    tracker.picture_at(21 * S + S / 2, &mut picture);
    assert!(picture.len() == 1 && picture[0].time_ns == 21 * S + S / 2);
    assert!((picture[0].estimate.mean[0] - 322.5).abs() < 3.0);
}

#[test]
fn settings_are_checked() {
    let wrong: [fn(&mut Settings); 8] = [
        |settings| settings.wide_area.correction = Some(Rule::Share(1.0)),
        |settings| settings.wide_area.correction = Some(Rule::Factor(0.5)),
        |settings| settings.wide_area.range_m = f64::NAN,
        |settings| settings.wide_area.valid_s = Seconds::default(),
        |settings| settings.wide_area.groups = Some(Groups { probability_min: 0.0 }),
        |settings| settings.selection.kept_weight = Some(1.0),
        |settings| settings.sensors.push(settings.sensors[0].clone()),
        |settings| {
            settings.wide_area.deletion = Some(EarlyDeletion {
                coverage: Some(Circle {
                    centre_m: [0.0; 2],
                    radius_m: -1.0,
                }),
                ..early_deletion()
            });
        },
    ];
    for wrong in wrong {
        let mut faulty = settings();
        wrong(&mut faulty);
        assert!(Tracker::new(faulty).is_err());
    }
}
