//! Scorecards with figures computed by hand.

use std::fmt::Write as _;

use areas::Outline;
use proptest::prelude::*;
use scoring::{
    AreaKind, CardReference, CardSettings, LineResult, LineVerdict, MOVEMENT_PHASES, PhaseFigures,
    SURVEILLANCE_STANDARDS, Scorecard, ScoredArea, SurveillanceStandard, Timeline, score_card,
};

const TRUTH: &str = "time_s,target_id,x,y,z,vx,vy,vz,address\n";
const TRACKS: &str = "time_s,system_track_id,x,y,z,vx,vy,vz,state,address,P00,P01,P02,P03,P04,P05,P11,P12,P13,P14,P15,P22,P23,\
                      P24,P25,P33,P34,P35,P44,P45,P55\n";

fn every_standard() -> Vec<&'static SurveillanceStandard> {
    SURVEILLANCE_STANDARDS.iter().collect()
}

fn card(truth: &str, tracks: &str, reference: CardReference, areas: &[ScoredArea]) -> Scorecard {
    let truth = Timeline::truth(truth.as_bytes()).unwrap();
    let tracks = Timeline::tracks(tracks.as_bytes(), 1.0).unwrap();
    let settings = CardSettings::default();
    score_card(&truth, &tracks, &settings, reference, &every_standard(), areas).unwrap()
}

/// A target flies east at 100 m/s for 40 s. Its track is 3 m ahead, 4 m to the left and 2 m above, flies north-east
/// at 141 m/s and climbs at 2 m/s, and is missing from 30 to 33 s. Another track has no target.
fn flight() -> (String, String) {
    let (mut truth, mut tracks) = (TRUTH.to_owned(), TRACKS.to_owned());
    let covariance = "9,0,0,0,0,0,16,0,0,0,0,1,0,0,0,1,0,0,10000,0,16";
    for second in 0..=40 {
        let east = 100 * second;
        writeln!(truth, "{second},1,{east},0,5000,100,0,0,3444CF").unwrap();
        let address = ["3444CF", "", "ABCDEF"][usize::from(second >= 35) + usize::from(second >= 38)];
        if !(30..34).contains(&second) {
            let east = east + 3;
            writeln!(
                tracks,
                "{second},7,{east},4,5002,100,100,2,confirmed,{address},{covariance}"
            )
            .unwrap();
        }
    }
    for second in 28..30 {
        writeln!(tracks, "{second},9,-9000,0,0,0,0,0,coasted,,{covariance}").unwrap();
    }
    (truth, tracks)
}

fn line<'a>(card: &'a Scorecard, standard: &str, name: &str) -> &'a LineResult {
    let standard = card
        .all
        .standards
        .iter()
        .find(|card| card.standard == standard)
        .unwrap();
    standard.lines.iter().find(|line| line.name == name).unwrap()
}

#[track_caller]
fn near(found: Option<f64>, expected: f64) {
    assert!(
        (found.unwrap() - expected).abs() < 1e-9,
        "{found:?}, {expected} expected"
    );
}

#[test]
fn errors_along_and_across_and_their_covariances_by_hand() {
    let (truth, tracks) = flight();
    let card = card(&truth, &tracks, CardReference::Truth, &[]);
    // From 25 s to 40 s, without 4 s.
    assert_eq!(
        (card.all.targets, card.all.target_seconds, card.errors.len()),
        (1, 16, 12)
    );
    for name in ["all", "straight", "level", "rate_steady"] {
        let figures: &PhaseFigures = card.all.phases.named(name).unwrap();
        assert_eq!(figures.n, 12, "{name}");
        for spread in [&figures.position, &figures.along, &figures.across, &figures.climb] {
            assert_eq!(spread.n, 12);
        }
        near(figures.position.rms, 5.0);
        near(figures.position.p99, 5.0);
        near(figures.along.mean, 3.0);
        near(figures.across.mean, -4.0);
        near(figures.across.p50, 4.0);
        near(figures.height.mean, 2.0);
        near(figures.speed.rms, 100.0 * (2f64.sqrt() - 1.0));
        near(figures.velocity.p95, 100.0);
        near(figures.heading_deg.mean, -45.0);
        near(figures.climb.p90, 2.0);
        let groups = &figures.consistency;
        // (3²/9 + 4²/16)/2; 100²/10000/2; 2²/1; 2²/16.
        near(groups.position.nees, 1.0);
        near(groups.velocity.nees, 0.5);
        near(groups.height.nees, 4.0);
        near(groups.climb.nees, 0.25);
        assert_eq!(
            (groups.height.in95, groups.climb.in95),
            (Some(0.0), Some(1.0)),
            "3.841 is the limit"
        );
    }
    assert_eq!(card.all.phases.named("turn").unwrap(), &PhaseFigures::default());
}

/// The flight with these values in the columns of what is known without a manoeuvre.
fn flight_without_manoeuvre(values: &str) -> Scorecard {
    let (truth, tracks) = flight();
    let mut lines = tracks.lines();
    let header = format!("{},{}", lines.next().unwrap(), csv_table::STEADY_COLUMNS.join(","));
    let rows = lines.map(|line| format!("{line},{values}"));
    let tracks = std::iter::once(header).chain(rows).collect::<Vec<_>>().join("\n");
    card(&truth, &tracks, CardReference::Truth, &[])
}

#[test]
fn the_likeliest_case_has_its_own_consistency() {
    let nees = |values: &str| {
        let groups = flight_without_manoeuvre(values).all.phases.0[0].consistency;
        near(groups.velocity.nees, 0.5);
        near(groups.climb.nees, 0.25);
        [groups.likeliest_velocity.nees, groups.likeliest_climb.nees]
    };
    // 100²/2500/2, and the covariance of straight flight; 2²/1.
    let [velocity, climb] = nees("0.75,1000,0,2500,0.5,1");
    near(velocity, 2.0);
    near(climb, 4.0);
    // A manoeuvre is likelier: 100²/10000/2; 2²/16.
    let [velocity, climb] = nees("0.25,1000,0,2500,0.49,1");
    near(velocity, 0.5);
    near(climb, 0.25);
    assert_eq!(nees(",,,,,"), [None; 2]);
}

#[test]
fn lines_of_standards_by_hand() {
    let (truth, tracks) = flight();
    let card = card(&truth, &tracks, CardReference::Truth, &[]);
    use LineVerdict::{Fail, NoLimitKnown, Pass};
    for (standard, name, figure, verdict) in [
        ("ed-87", "update_1s", 12.0 / 16.0, Fail),
        ("ed-87", "position_p95", 5.0, Pass),
        // The gap from 29 to 34 s.
        ("ed-87", "gaps_3_to_5s", 1.0 / 12.0, Fail),
        ("ed-87", "gaps_over_5s", 0.0, Pass),
        ("ed-87", "longest_gap", 5.0, NoLimitKnown),
        // 25 to 29 s and 34 s; nothing at 35 to 37 s, another address at 38 to 40 s.
        ("ed-87", "address_right", 6.0 / 12.0, Fail),
        ("ed-87", "address_wrong", 3.0 / 9.0, Fail),
        // Two reports of no target.
        ("ed-87", "false_reports", 2.0 / 14.0, Fail),
        // One track in the 31 s from 10 s on.
        ("ed-87", "false_tracks", 3600.0 / 31.0, NoLimitKnown),
        ("ed-87", "speed", 0.0, Fail),
        ("ed-87", "course_p90", 45.0, Fail),
        ("ed-116", "position_p95", 5.0, Pass),
        ("ed-117", "position_p99", 5.0, Pass),
        // Only 31 and 32 s lack a report; 30 to 34 s have one.
        ("ed-117", "runway_update_2s", 7.0 / 8.0, Fail),
        ("ed-117", "stand_update_5s", 1.0, Pass),
        ("ed-117", "gaps_3s", 1.0 / 12.0, Fail),
        ("ed-142", "terminal_position_rms", 5.0, Pass),
        ("ed-142", "update_5s", 1.0, NoLimitKnown),
        ("esassp", "5N_N-R2", 1.0, Pass),
        ("esassp", "3N_N-R3", 5.0, Pass),
        ("esassp", "height_p95", 2.0, NoLimitKnown),
        ("esassp", "velocity_rms_straight", 100.0, NoLimitKnown),
    ] {
        let found = line(&card, standard, name);
        near(found.figure, figure);
        assert_eq!(found.verdict, verdict, "{standard} {name}");
    }
    assert_eq!(
        line(&card, "esassp", "velocity_rms_turn").verdict,
        LineVerdict::NotMeasured
    );
    // A hundredth of 16 cases and a twentieth of 12 are less than one.
    for (name, enough) in [("update_1s", false), ("position_p95", false), ("speed", true)] {
        assert_eq!(line(&card, "ed-87", name).enough, enough, "{name}");
    }
}

#[test]
fn what_comes_from_the_same_data_never_passes() {
    let (truth, tracks) = flight();
    for (reference, limited) in [
        (CardReference::Truth, [LineVerdict::Pass, LineVerdict::Fail].as_slice()),
        (CardReference::Independent, &[LineVerdict::Pass, LineVerdict::Fail]),
        (CardReference::Smoothed, &[LineVerdict::PrecisionOnly]),
    ] {
        let card = card(&truth, &tracks, reference, &[]);
        for standard in &card.all.standards {
            let known = SURVEILLANCE_STANDARDS
                .iter()
                .find(|known| known.word == standard.standard)
                .unwrap();
            assert_eq!(standard.lines.len(), known.lines.len(), "every line is there");
            for line in &standard.lines {
                let expected = match (line.figure, line.limit) {
                    (None, _) => [LineVerdict::NotMeasured].as_slice(),
                    (_, None) => &[LineVerdict::NoLimitKnown],
                    _ => limited,
                };
                assert!(expected.contains(&line.verdict), "{} {:?}", line.name, line.verdict);
            }
        }
        // A reference that lacks targets does not make a report of another target false.
        let expected = if reference == CardReference::Truth {
            2.0 / 14.0
        } else {
            0.0
        };
        near(line(&card, "ed-87", "false_reports").figure, expected);
    }
}

#[test]
fn an_area_has_its_own_seconds_and_the_lines_of_its_kind() {
    let (truth, tracks) = flight();
    let square = |from: f64, to: f64| vec![vec![[from, -50.0], [to, -50.0], [to, 50.0], [from, 50.0]]];
    let area = |name: &str, kind, from, to| ScoredArea {
        name: name.to_owned(),
        kind,
        outline: Outline::new(vec![square(from, to)]),
    };
    let areas = [
        area("runway", Some(AreaKind::RUNWAY), 2750.0, 3150.0),
        area("sky", Some(AreaKind::TERMINAL), 3150.0, 9000.0),
        area("nowhere", None, -200.0, -100.0),
    ];
    let card = card(&truth, &tracks, CardReference::Truth, &areas);
    // Seconds 28 to 31, the last two without a track; 32 to 40, the first two without.
    let counts = card.areas.iter().map(|area| (area.target_seconds, area.phases.0[0].n));
    assert_eq!(counts.collect::<Vec<_>>(), [(4, 2), (9, 7), (0, 0)]);
    let names = |area: usize| -> Vec<&str> {
        let lines = card.areas[area].standards[2].lines.iter();
        lines.map(|line| line.name).collect()
    };
    let common = ["longest_gap", "address_right", "address_wrong", "false_reports"];
    assert_eq!(names(1), common);
    assert_eq!(
        names(0),
        [
            "position_p95",
            "position_p99",
            "update_1s",
            "runway_update_2s",
            "gaps_3s"
        ]
        .iter()
        .chain(&common)
        .copied()
        .collect::<Vec<_>>()
    );
    assert_eq!(names(2).len(), 16);
    // The leg ends with the area: two seconds from the last report to its end.
    let longest = card.areas[0].standards[2]
        .lines
        .iter()
        .find(|line| line.name == "longest_gap");
    near(longest.unwrap().figure, 2.0);
}

#[test]
fn a_state_that_shows_for_longer_takes_its_covariance_along() {
    let truth: String = (0..=30).map(|second| format!("{second},1,0,0,0,0,0,0,\n")).collect();
    let state = "25.5,7,0,0,0,4,0,0,confirmed,,1,0,0,0,0,0,1,0,0,0,0,1,0,0,0,4,0,0,4,0,4\n";
    let truth = Timeline::truth(format!("{TRUTH}{truth}").as_bytes()).unwrap();
    let tracks = Timeline::tracks(format!("{TRACKS}{state}").as_bytes(), 3.0).unwrap();
    let settings = CardSettings::default();
    let card = score_card(&truth, &tracks, &settings, CardReference::Truth, &[], &[]).unwrap();
    // After 0.5, 1.5 and 2.5 s: (4 t)² over 1 + 4 t², half of it per degree.
    let found: Vec<f64> = card.errors.iter().map(|error| error.normalised[0].unwrap()).collect();
    let expected = [0.5f64, 1.5, 2.5].map(|t| 16.0 * t * t / (1.0 + 4.0 * t * t) / 2.0);
    assert_eq!(found.len(), 3);
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12);
    }
    assert_eq!(card.errors[0].along_across_m, None, "a target at rest has no course");
}

/// Steps of a generator whose numbers are the same everywhere.
fn generated() -> String {
    let mut seed = 12_345u64;
    let mut draw = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as i64
    };
    let mut truth = TRUTH.to_owned();
    for target in 0..40 {
        let (mut velocity, mut acceleration, mut until) = ([1000i64, 0, 0], [0i64; 3], 0);
        let mut position = [0i64; 3];
        for second in 0..240 {
            if second >= until {
                until = second + 3 + draw() % 40;
                let choice = draw() % 4;
                acceleration = [0; 3];
                if choice < 3 {
                    acceleration[choice as usize] = draw() % 21 - 10;
                }
            }
            for axis in 0..3 {
                velocity[axis] += acceleration[axis];
                position[axis] += velocity[axis];
            }
            let tenths = |value: i64| value as f64 / 10.0;
            let [x, y, z] = position.map(tenths);
            let [vx, vy, vz] = velocity.map(tenths);
            writeln!(truth, "{second},{target},{x},{y},{z},{vx},{vy},{vz},").unwrap();
        }
    }
    truth
}

/// The counts are those of the project's own measuring tool (Python) on the same rows.
#[test]
fn the_phases_of_generated_flights_are_those_of_the_measuring_tool() {
    let truth = generated();
    let tracks = truth.replacen("target_id", "system_track_id", 1);
    let card = card(&truth, &tracks, CardReference::Truth, &[]);
    let figures = MOVEMENT_PHASES.iter().zip(&card.all.phases.0);
    let counts: Vec<(&str, u64)> = figures.map(|(phase, figures)| (phase.name, figures.n)).collect();
    let expected = [
        ("all", 8600),
        ("straight", 4770),
        ("entry", 367),
        ("turn", 1519),
        ("exit", 1018),
        ("after", 926),
        ("level", 2361),
        ("climb", 6239),
        ("rate_steady", 5267),
        ("rate_entry", 340),
        ("rate_change", 1295),
        ("rate_exit", 890),
        ("rate_after", 808),
    ];
    assert_eq!(counts, expected);
}

proptest! {
    #[test]
    fn the_order_of_rows_changes_nothing(
        rows in prop::collection::vec((0..50i64, 0..4u32, -200..200i64, -200..200i64), 1..150),
        order in any::<u64>(),
    ) {
        let mut by_key = std::collections::BTreeMap::new();
        for (second, number, x, y) in rows {
            by_key.insert((second, number), (x, y));
        }
        let row = |((second, number), (x, y)): (&(i64, u32), &(i64, i64))| {
            format!("{second},{number},{x},{y},0,{},{},0,confirmed,,{}\n", x % 20, y % 20, "1,0,0,0,0,0,1,0,0,0,0,1,0,0,0,1,0,0,1,0,1")
        };
        let sorted: Vec<String> = by_key.iter().map(row).collect();
        let mut shuffled = sorted.clone();
        let length = shuffled.len();
        for place in 0..length {
            shuffled.swap(place, (order as usize).wrapping_mul(place + 7) % length);
        }
        let truth: String = (0..50).flat_map(|second| (0..4).map(move |target| {
            format!("{second},{target},{},0,0,10,{},0,\n", target * 150, second % 9)
        })).collect();
        let truth = format!("{TRUTH}{truth}");
        let of = |rows: &[String]| card(&truth, &format!("{TRACKS}{}", rows.concat()), CardReference::Truth, &[]);
        prop_assert_eq!(of(&sorted), of(&shuffled));
    }
}
