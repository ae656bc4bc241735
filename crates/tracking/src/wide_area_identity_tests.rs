//! Who targets are (WA-9), in the tracker as a whole.

use messages::{TargetType, TrackKind};

use crate::testing::{S, position, settings};
use crate::wide_area::group::Groups;
use crate::wide_area::prior::{self, Circle, EmissionBand, Knowledge, Prior};
use crate::wide_area::{Emission, EmissionRejection, WideAreaReport};
use crate::{Settings, Tracker};

/// Patrol boats emit at 9.4 GHz and come from the east, ferries at 3 GHz and come from the west.
fn known() -> Settings {
    let mut chosen = settings();
    let target = |name: &str, frequency_hz| prior::TargetType {
        name: name.to_owned(),
        emissions: vec![EmissionBand {
            frequency_hz,
            pulse_interval_s: Some([5e-4, 2e-3]),
        }],
    };
    let from = |east_m, target: &str| Prior {
        circle: Some(Circle {
            centre_m: [east_m, 0.0],
            radius_m: 20e3,
        }),
        types: [(target.to_owned(), 0.6)].into(),
        ..Prior::default()
    };
    chosen.wide_area.knowledge = Knowledge {
        types: vec![target("patrol", [9.3e9, 9.5e9]), target("ferry", [2.9e9, 3.1e9])],
        priors: vec![from(80e3, "patrol"), from(-80e3, "ferry")],
    };
    chosen
}

/// Two targets that move east side by side, 4 km apart.
fn two(second: i64) -> [observations::Detection; 2] {
    let east = 15.0 * second as f64;
    [position(second * S, east, 2000.0), position(second * S, east, -2000.0)]
}

/// Heard from a place in the west, from which the two are in different directions: an emission of the one in the north
/// or of that in the south.
fn heard(second: i64, north_m: f64, frequency_hz: f64) -> Emission {
    let platform_m = [-3000.0, -2000.0];
    let east_m = 15.0 * second as f64;
    Emission {
        time_ns: second * S,
        bearing_rad: (east_m - platform_m[0]).atan2(north_m - platform_m[1]),
        sigma_rad: 0.02,
        platform_m,
        frequency_hz,
        pulse_interval_s: Some(1e-3),
    }
}

fn count(time_s: i64, arrival_s: i64, origin_m: Option<[f64; 2]>) -> WideAreaReport {
    WideAreaReport {
        time_ns: time_s * S,
        arrival_ns: arrival_s * S,
        position_m: [15.0 * time_s as f64, 2100.0, 0.0],
        velocity_mps: [15.0, 0.0, 0.0],
        targets: 2,
        origin_m,
    }
}

/// The types of the tracks, from the south to the north.
fn types(tracker: &Tracker) -> Vec<TargetType> {
    let mut tracks: Vec<_> = tracker.tracks().iter().collect();
    tracks.sort_by(|one, other| one.estimate.mean[1].total_cmp(&other.estimate.mean[1]));
    tracks.iter().map(|track| track.target_type).collect()
}

fn names(tracker: &Tracker) -> Vec<String> {
    let name = |target: TargetType| target.name().unwrap_or("").to_owned();
    types(tracker).into_iter().map(name).collect()
}

#[test]
fn emissions_and_origins_identify_the_tracks_they_come_from() {
    let mut tracker = Tracker::new(known()).unwrap();
    for second in 0..8 {
        tracker.scan(1, second * S, &two(second)).unwrap();
    }
    tracker.emission(&heard(8, 2000.0, 9.4e9)).unwrap();
    assert_eq!(names(&tracker), ["", ""], "used by the next scan");
    tracker.scan(1, 8 * S, &two(8)).unwrap();
    assert_eq!(names(&tracker), ["", "patrol"]);
    let alone = types(&tracker)[1].confidence;
    tracker.emission(&heard(9, -2000.0, 9.4e9)).unwrap();
    tracker.wide_area(&count(5, 9, Some([80e3, 0.0]))).unwrap();
    tracker.scan(1, 9 * S, &two(9)).unwrap();
    let [south, north] = types(&tracker)[..] else { panic!() };
    assert!(
        north.confidence > alone && south.name() == Some("patrol"),
        "{north:?} {south:?}"
    );
    let sent = tracker.tracks()[0].sensor_track(3);
    assert_eq!(
        (sent.target_type.name(), sent.kind, sent.members),
        (Some("patrol"), TrackKind::Single as u8, 0)
    );
    let counts = tracker.counts();
    assert_eq!(
        (counts.emissions, counts.emissions_used, counts.emissions_unclear),
        (2, 2, 0)
    );
    // The report is no longer valid, and what it told stays.
    for second in 10..60 {
        tracker.scan(1, second * S, &two(second)).unwrap();
    }
    assert_eq!(types(&tracker)[1], north);
}

#[test]
fn late_scans_reports_and_emissions_identify_as_in_order() {
    let mut open = known();
    open.capacity.open_scans = 5;
    let emissions: Vec<_> = (0..8)
        .map(|k| {
            heard(
                5 * k + 2,
                if k % 2 == 0 { 2000.0 } else { -2000.0 },
                if k < 4 { 9.4e9 } else { 3e9 },
            )
        })
        .collect();
    let reports = [count(12, 16, Some([80e3, 0.0])), count(22, 27, Some([-80e3, 0.0]))];
    let mut in_time = Tracker::new(open.clone()).unwrap();
    let mut states = Vec::new();
    for second in 0..40 {
        let now = |time_ns: i64| time_ns == second * S;
        for emission in emissions.iter().filter(|emission| now(emission.time_ns)) {
            in_time.emission(emission).unwrap();
        }
        for report in reports.iter().filter(|report| now(report.arrival_ns)) {
            in_time.wide_area(report).unwrap();
        }
        in_time.scan(1, second * S, &two(second)).unwrap();
        if second % 5 == 4 {
            states.push((in_time.latest().clone(), in_time.tracks().to_vec()));
        }
    }
    let mut late = Tracker::new(open).unwrap();
    for (group, state) in states.iter().enumerate() {
        let first = 5 * group as i64;
        for second in [1, 2, 3, 0, 4].map(|place| first + place) {
            late.scan(1, second * S, &two(second)).unwrap();
        }
        let within = |time_ns: i64| (first * S..(first + 5) * S).contains(&time_ns);
        for emission in emissions.iter().filter(|emission| within(emission.time_ns)) {
            late.emission(emission).unwrap();
        }
        for report in reports.iter().filter(|report| within(report.arrival_ns)) {
            late.wide_area(report).unwrap();
        }
        assert_eq!((late.latest(), late.tracks()), (&state.0, &state.1[..]), "{group}");
    }
    let mut seen = states.iter().flat_map(|(_, tracks)| tracks);
    assert!(seen.any(|track| track.target_type.name().is_some()));
}

#[test]
fn an_emission_moves_no_track_and_a_bad_one_changes_nothing() {
    let (mut silent, mut hostile) = (Tracker::new(known()).unwrap(), Tracker::new(known()).unwrap());
    let good = heard(4, 2000.0, 9.4e9);
    let bad = [
        Emission {
            bearing_rad: f64::NAN,
            ..good
        },
        Emission {
            frequency_hz: 0.0,
            ..good
        },
        Emission {
            platform_m: [1e12, 0.0],
            ..good
        },
        Emission {
            time_ns: -600 * S,
            ..good
        },
    ];
    for second in 0..20 {
        silent.scan(1, second * S, &two(second)).unwrap();
        if second > 0 {
            bad.iter()
                .for_each(|emission| assert!(hostile.emission(emission).is_err()));
        }
        hostile.scan(1, second * S, &two(second)).unwrap();
        let (silent, hostile) = (silent.latest(), hostile.latest());
        assert_eq!(
            (&silent.tracks, &silent.hypotheses, &silent.support.identities),
            (&hostile.tracks, &hostile.hypotheses, &hostile.support.identities)
        );
    }
    assert_eq!(hostile.counts().emissions_rejected, 4 * 19);
    let mut heard = Tracker::new(known()).unwrap();
    for second in 0..20 {
        heard
            .emission(&Emission {
                time_ns: second * S,
                ..good
            })
            .unwrap();
        heard.scan(1, second * S, &two(second)).unwrap();
    }
    assert_eq!(
        (&heard.latest().tracks, &heard.latest().hypotheses),
        (&silent.latest().tracks, &silent.latest().hypotheses)
    );
    let mut ignorant = Tracker::new(settings()).unwrap();
    assert_eq!(ignorant.emission(&good), Err(EmissionRejection::NoTypes));
}

#[test]
fn ended_tracks_are_forgotten() {
    let mut tracker = Tracker::new(known()).unwrap();
    for second in 0..200 {
        let scan = two(second);
        // Ten seconds there, ten seconds not, again and again.
        let seen = if second / 10 % 2 == 0 { &scan[..] } else { &[] };
        tracker.emission(&heard(second, 2000.0, 9.4e9)).unwrap();
        tracker.scan(1, second * S, seen).unwrap();
        let confirmed = tracker
            .latest()
            .tracks
            .iter()
            .filter(|track| track.is_confirmed())
            .count();
        assert!(tracker.latest().support.identities.len() <= confirmed);
    }
    assert!(tracker.counts().confirmed > 10);
}

#[test]
fn a_group_is_sent_as_one_with_its_members_and_type() {
    let mut chosen = known();
    chosen.wide_area.correction = None;
    chosen.wide_area.groups = Some(Groups { probability_min: 0.5 });
    let mut tracker = Tracker::new(chosen).unwrap();
    for second in 0..12 {
        tracker.scan(1, second * S, &two(second)[..1]).unwrap();
    }
    tracker.emission(&heard(12, 2000.0, 9.4e9)).unwrap();
    tracker
        .wide_area(&WideAreaReport {
            targets: 3,
            ..count(8, 12, None)
        })
        .unwrap();
    tracker.scan(1, 12 * S, &two(12)[..1]).unwrap();
    let [track] = tracker.tracks() else { panic!() };
    let sent = track.sensor_track(0);
    assert_eq!(
        (sent.kind, sent.members, sent.target_type.name()),
        (TrackKind::Group as u8, 3, Some("patrol"))
    );
}
