//! Alerts by hand: two aircraft that meet, others that do not.

use areas::{Area, Level, Outline, VerticalLimits};

use super::*;
use crate::basis::FileBasis;

const HEADER: &str =
    "time_s,event,alert,rule,kind,system_track_id,other_system_track_id,area,probability,time_to_s,horizon_s\n";

/// Straight flights from `first_s` to 600 s: number, place at 300 s, velocity.
type Flight = (i64, i64, [f64; 3], [f64; 3]);

fn rows(number: &str, first: i64, flights: &[Flight]) -> String {
    let mut text = format!("time_s,{number},x,y,z,vx,vy,vz\n");
    for second in 0..=600 {
        for (id, _, [x, y, z], [vx, vy, vz]) in flights.iter().filter(|(_, first_s, ..)| second >= *first_s) {
            let since_s = (second - 300) as f64;
            let (x, y, z) = (x + vx * since_s, y + vy * since_s, z + vz * since_s);
            text += &format!("{second},{},{x:.3},{y:.3},{z:.3},{vx},{vy},{vz}\n", id + first);
        }
    }
    text
}

fn scored(flights: &[Flight], alerts: &str, areas: &[Area]) -> AlertScore {
    let truth = Timeline::truth(rows("target_id", 0, flights).as_bytes()).unwrap();
    // Tracks are numbered from 100 and have no error.
    let tracks = Timeline::tracks(rows("system_track_id", 100, flights).as_bytes(), 1.0).unwrap();
    let table = AlertTable::read(FileBasis::default(), format!("{HEADER}{alerts}").as_bytes()).unwrap();
    let settings = AlertScoreSettings {
        gate_m: 500.0,
        ..AlertScoreSettings::default()
    };
    score_alerts(&truth, &tracks, &table, &settings, areas).unwrap()
}

fn figures<'a>(score: &'a AlertScore, kind: &str) -> &'a AlertFigures {
    let of_kind = score.kinds.iter().find(|of| of.kind == kind);
    of_kind.and_then(|of| of.judged.as_ref()).expect("judged")
}

/// 1 and 2 meet head on at 300 s, 400 m/s apart: nearer than 9,260 m from 276.85 s to 323.15 s. 3 is 1,000 ft above 1,
/// 4 is 20 km beside it.
const MEETING: [Flight; 4] = [
    (1, 0, [0.0, 0.0, 9000.0], [200.0, 0.0, 0.0]),
    (2, 0, [0.0, 0.0, 9000.0], [-200.0, 0.0, 0.0]),
    (3, 0, [0.0, 0.0, 9304.8], [200.0, 0.0, 0.0]),
    (4, 0, [0.0, 20_000.0, 9000.0], [200.0, 0.0, 0.0]),
];

#[test]
fn a_pair_that_meets_is_the_only_event_and_levels_keep_apart() {
    let score = scored(&MEETING, "", &[]);
    let conflict = figures(&score, "conflict");
    assert_eq!((conflict.events, conflict.hits, conflict.misses), (1, 0, 1));
    assert_eq!(conflict.missed[0].targets, [1, 2]);
    let begin_s = 300.0 - (9260.0 - 0.01) / 400.0;
    assert!(
        (conflict.missed[0].begins_s - begin_s).abs() < 1e-6,
        "{:?}",
        conflict.missed
    );
    assert_eq!((conflict.lead_s_median, conflict.in_time), (None, None));
    assert_eq!(
        (score.targets, score.tracks, score.heights_above_ellipsoid),
        (4, 4, false)
    );
}

#[test]
fn hits_nuisances_duplicates_and_leads() {
    // 7 is right and 9 repeats it, whatever the order of the tracks. 8 is a nuisance, as is 10: cleared 130 s before
    // the violation, which is more than the look-ahead. 11 has a track that nobody knows. 12 is undecided.
    let alerts = "100,raised,10,a,conflict,101,102,,0.5,177,\n146,cleared,10,a,conflict,101,102,,,,\n\
                  150,raised,8,a,conflict,101,104,,0.5,60,\n\
                  180,cleared,8,a,conflict,101,104,,,,\n180,raised,7,a,conflict,102,101,,0.9,97,\n\
                  190,raised,11,a,conflict,101,7,,0.9,97,\n195,cleared,11,a,conflict,101,7,,0.9,97,\n\
                  250,cleared,7,a,conflict,102,101,,,,\n280,raised,9,a,conflict,101,102,,1,0,\n\
                  590,raised,12,a,conflict,103,104,,1,0,\n10,raised,13,a,lost,103,,,,,\n";
    let score = scored(&MEETING, alerts, &[]);
    let conflict = figures(&score, "conflict");
    assert_eq!(
        (conflict.events, conflict.hits, conflict.late, conflict.duplicates),
        (1, 1, 0, 1)
    );
    assert_eq!(conflict.nuisance_alerts, [10, 8, 11]);
    assert_eq!(
        (conflict.nuisance, conflict.nuisance_without_target, conflict.undecided),
        (3, 1, 1)
    );
    assert_eq!(conflict.nuisance_per_hour, Some(18.0));
    assert!((conflict.lead_s_median.unwrap() - 96.85).abs() < 1e-3, "{conflict:?}");
    assert_eq!(conflict.in_time, Some(1.0));
    assert_eq!(
        (score.kinds[1].kind, score.kinds[1].alerts, &score.kinds[1].judged),
        ("lost", 1, &None)
    );
}

#[test]
fn a_late_alert_is_in_time_only_at_the_first_state() {
    let alert = |raised_s: u32| format!("{raised_s},raised,1,a,conflict,101,102,,0.5,,\n");
    let found = |flights: &[Flight], raised_s: u32| {
        let score = scored(flights, &alert(raised_s), &[]);
        let conflict = figures(&score, "conflict");
        (
            conflict.late,
            conflict.in_time.unwrap(),
            conflict.lead_s_median.unwrap().round(),
        )
    };
    assert_eq!(found(&MEETING, 290), (1, 0.0, -13.0));
    let mut appears = MEETING;
    appears[1].1 = 286;
    assert_eq!(
        found(&appears, 290),
        (1, 1.0, -4.0),
        "the violation begins with the first row"
    );
    assert_eq!(found(&appears, 295), (1, 0.0, -9.0));
}

#[test]
fn above_flight_level_410_the_vertical_minimum_doubles() {
    let pair = |height_m: f64| {
        [
            (1, 0, [0.0, 0.0, height_m], [200.0, 0.0, 0.0]),
            (2, 0, [0.0, 0.0, height_m + 400.0], [-200.0, 0.0, 0.0]),
        ]
    };
    assert!(scored(&pair(11_000.0), "", &[]).kinds.is_empty());
    assert_eq!(figures(&scored(&pair(12_300.0), "", &[]), "conflict").events, 1);
}

#[test]
fn ships_have_a_minimum_of_their_own_unless_both_lie_still() {
    let pair = |speed: f64| {
        [
            (1, 0, [0.0, 0.0, 20.0], [speed, 0.0, 0.0]),
            (2, 0, [0.0, 900.0, 20.0], [0.1, 0.0, 0.0]),
        ]
    };
    let score = scored(&pair(8.0), "0,raised,4,cpa,approach,101,102,,0.5,300,\n", &[]);
    let approach = figures(&score, "approach");
    assert_eq!((approach.events, approach.hits, score.kinds.len()), (1, 1, 1));
    assert!(scored(&pair(0.2), "", &[]).kinds.is_empty());
}

/// An area from x = −10 km to 10 km, flight levels 250 to 300.
fn zone() -> Area {
    Area {
        name: "Zone".to_owned(),
        kind: None,
        outline: Outline::new(vec![vec![vec![[-1e4, -5e3], [1e4, -5e3], [1e4, 5e3], [-1e4, 5e3]]]]),
        limits: VerticalLimits {
            floor: Some(Level::Flight(250.0)),
            ceiling: Some(Level::Sea(9144.0)),
        },
    }
}

#[test]
fn areas_are_entered_within_their_limits() {
    // 1 enters at 250 s, 2 flies above, 3 climbs into it at 300 s, 4 passes beside it.
    let flights: [Flight; 4] = [
        (1, 0, [0.0, 0.0, 9000.0], [200.0, 0.0, 0.0]),
        (2, 0, [0.0, 0.0, 9150.0], [200.0, 50.0, 0.0]),
        (3, 0, [0.0, 2e3, 7620.0], [10.0, 0.0, 5.0]),
        (4, 0, [0.0, 5001.0, 9000.0], [200.0, 0.0, 0.0]),
    ];
    let alerts = "240,raised,1,a,enter,101,,Zone,0.5,,\n310,raised,2,a,enter,103,,,0.5,,\n\
                  280,raised,3,a,enter,104,,Zone,0.5,,\n290,cleared,3,a,enter,104,,Zone,0.5,,\n";
    let score = scored(&flights, alerts, &[zone()]);
    let enter = figures(&score, "enter");
    assert_eq!((enter.events, enter.hits, enter.late, enter.nuisance), (2, 2, 1, 1));
    assert_eq!(
        (enter.nuisance_alerts.as_slice(), enter.lead_s_median),
        (&[3][..], Some(0.0))
    );
    let without = scored(&flights, alerts, &[]);
    let counted = without.kinds.iter().find(|of| of.kind == "enter").unwrap();
    assert_eq!((counted.alerts, &counted.judged), (3, &None), "nobody knows the area");
}

#[test]
fn predictions_are_counted_in_ten_bins() {
    // The violation is from 276.85 s to 323.15 s.
    let predicted = |time_s: u32, other: i64, probability: f64, horizon: &str| {
        format!("{time_s},predicted,,a,conflict,101,{other},,{probability},,{horizon}\n")
    };
    let alerts = [
        predicted(200, 102, 0.95, "100"),
        predicted(200, 102, 0.31, "76"),
        predicted(200, 102, 0.39, "78"),
        predicted(200, 102, 1.0, ""),
        predicted(200, 103, 0.0, "100"),
        predicted(550, 103, 0.9, "100"),
        predicted(200, 7, 0.9, "100"),
    ];
    let score = scored(&MEETING, &alerts.concat(), &[]);
    let [conflict] = &score.reliability[..] else {
        panic!("one kind")
    };
    assert_eq!((conflict.n, conflict.left_out), (5, 2));
    let counts = |place: usize| (conflict.bins[place].n, conflict.bins[place].violated);
    assert_eq!([0, 3, 9].map(counts), [(1, 0), (2, 1), (2, 2)]);
    assert_eq!(
        (conflict.bins[3].predicted, conflict.bins[3].observed),
        (Some(0.35), Some(0.5))
    );
    let brier = (0.05f64.powi(2) + 0.31f64.powi(2) + 0.61f64.powi(2)) / 5.0;
    assert!((conflict.brier.unwrap() - brier).abs() < 1e-12);
}
