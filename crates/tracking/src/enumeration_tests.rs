//! The tracker against full enumeration: no clusters, no ranking, no shared tracks, every matrix written down.

use std::collections::BTreeMap;

use observations::{Detection, WideAreaReport};
use proptest::prelude::*;

use crate::clutter::log_density;
use crate::correlation_tests::{Interpretation, Row, applies, child, matrices};
use crate::gate::gates;
use crate::initiation::first_state;
use crate::limits::{HISTORY_MAX, HYPOTHESES_MAX};
use crate::measurement::DetectionMeasurement;
use crate::motion::TargetMotion;
use crate::population::{Cluster, Population};
use crate::testing::{S, position, settings};
use crate::track::{NO_DETECTION, Track};
use crate::wide_area::correction::{Rule, correct};
use crate::{Settings, Tracker};

/// Serial numbers of each track's detections, latest first.
type Content = Vec<[u32; HISTORY_MAX]>;

/// A hypothesis of the reference: its tracks and the logarithm of its likelihood.
#[derive(Clone)]
struct Whole {
    tracks: Vec<Track>,
    log_likelihood: f64,
}

/// Short, so that absence matters within three scans.
const LIFE_S: f64 = 20.0;

fn exact_settings() -> Settings {
    let mut settings = settings();
    settings.reduction.merge_scans = 0;
    settings.reduction.reliability_min = 0.0;
    settings.reduction.hypotheses_max = HYPOTHESES_MAX;
    settings.initiation.new_target_share = 0.3;
    settings.confirmation.detections_min = 100;
    settings.deletion.mean_life_s = Some(LIFE_S);
    settings
}

/// Every child of `whole` by the definitions HT-5 to HT-8.
fn children(whole: &Whole, scan: &[Detection], time_ns: i64, first_serial: u32, settings: &Settings) -> Vec<Whole> {
    let gates = gates(settings.gate.probability);
    let detection_probability = settings.sensors[0].model.detection_probability.unwrap();
    let miss = (1.0 - detection_probability * settings.gate.probability).ln();
    let measured: Vec<_> = scan
        .iter()
        .map(|detection| DetectionMeasurement::of(detection, None).unwrap())
        .collect();
    let predicted: Vec<_> = whole
        .tracks
        .iter()
        .map(|track| track.motion_at(time_ns, &settings.motion))
        .collect();
    let in_gate = |measurement: &DetectionMeasurement| {
        let inside = |track: &usize| predicted[*track].innovation(measurement).unwrap().squared_distance <= gates[1];
        Row::of(&(0..predicted.len()).filter(inside).collect::<Vec<_>>())
    };
    let rows: Vec<_> = measured.iter().map(in_gate).collect();
    // A second has passed since the scan before.
    let absent = |track: usize| 1.0 - (1.0 - whole.tracks[track].absence) * (-1.0 / LIFE_S).exp();
    let own: Vec<_> = (0..whole.tracks.len()).collect();
    let mut found = Vec::new();
    for matrix in matrices(&rows, usize::MAX) {
        assert!(applies(&matrix, &own));
        let mut next = Whole {
            tracks: Vec::new(),
            log_likelihood: whole.log_likelihood,
        };
        for (row, column) in matrix.iter().enumerate() {
            let log_clutter = log_density(&measured[row], 1e-6, &settings.initiation);
            next.log_likelihood += match column {
                Interpretation::False => log_clutter,
                Interpretation::New => log_clutter + settings.initiation.new_target_share.ln(),
                Interpretation::Track(track) => {
                    let innovation = predicted[*track].innovation(&measured[row]).unwrap();
                    detection_probability.ln() + innovation.log_likelihood + (1.0 - absent(*track)).ln()
                }
            };
        }
        let (continued, new) = child(&matrix, &own);
        for (number, row) in continued {
            let mut track = whole.tracks[number];
            match row {
                Some(row) => {
                    track.motion = predicted[number];
                    track.absence = 0.0;
                    track.motion.update(&measured[row]).unwrap();
                    track.time_ns = time_ns;
                    track.remember(first_serial + row as u32);
                }
                None => {
                    next.log_likelihood += miss;
                    let there = (1.0 - absent(number)) * miss.exp();
                    track.absence = absent(number) / (absent(number) + there);
                    track.remember(NO_DETECTION);
                }
            }
            next.tracks.push(track);
        }
        for row in new {
            let state = first_state(&measured[row], &settings.initiation).unwrap();
            let motion = TargetMotion::begun(state, &settings.motion);
            let track = Track::begun(motion, time_ns, first_serial + row as u32, 0);
            next.tracks.push(track);
        }
        found.push(next);
    }
    found
}

/// All hypotheses after the scans, by their contents, with reliabilities that sum to 1. A wide-area report of `targets`
/// is due in the last scan.
fn enumerated(scans: &[Vec<Detection>], settings: &Settings, targets: Option<f64>) -> Vec<(Content, f64)> {
    let mut hypotheses = vec![Whole {
        tracks: Vec::new(),
        log_likelihood: 0.0,
    }];
    let mut serial = 1;
    for (number, scan) in (0..).zip(scans) {
        let due = targets.filter(|_| number as usize + 1 == scans.len());
        correct_all(&mut hypotheses, due);
        let all = hypotheses.iter();
        hypotheses = all
            .flat_map(|whole| {
                let mut own = children(whole, scan, number * S, serial, settings);
                correct_all(&mut own, due);
                own
            })
            .collect();
        serial += scan.len() as u32;
    }
    let best = hypotheses
        .iter()
        .map(|whole| whole.log_likelihood)
        .fold(f64::MIN, f64::max);
    let weight = |whole: &Whole| (whole.log_likelihood - best).exp();
    let total: f64 = hypotheses.iter().map(weight).sum();
    let content = |whole: &Whole| sorted(whole.tracks.iter().map(|track| track.history).collect());
    hypotheses
        .iter()
        .map(|whole| (content(whole), weight(whole) / total))
        .collect()
}

/// WA-4, written down.
fn correct_all(hypotheses: &mut [Whole], due: Option<f64>) {
    let Some(targets) = due else { return };
    let best = hypotheses
        .iter()
        .map(|whole| whole.log_likelihood)
        .fold(f64::MIN, f64::max);
    let all = hypotheses.iter();
    let mut reliabilities: Vec<f64> = all.map(|whole| (whole.log_likelihood - best).exp()).collect();
    let tracks: Vec<u32> = hypotheses.iter().map(|whole| whole.tracks.len() as u32).collect();
    correct(&mut reliabilities, &tracks, targets, Rule::Share(0.6));
    for (whole, reliability) in hypotheses.iter_mut().zip(reliabilities) {
        whole.log_likelihood = best + reliability.ln();
    }
}

fn sorted(mut content: Content) -> Content {
    content.sort_unstable();
    content
}

fn of_cluster(population: &Population, cluster: &Cluster) -> Vec<(Content, f64)> {
    let hypotheses = &population.hypotheses[cluster.hypotheses.start as usize..cluster.hypotheses.end as usize];
    let content = |members: &[u32]| {
        members
            .iter()
            .map(|track| population.tracks[*track as usize].history)
            .collect()
    };
    let each = hypotheses.iter();
    each.map(|hypothesis| {
        let members = population.members_of(hypothesis);
        (content(members), hypothesis.log_reliability.exp())
    })
    .collect()
}

/// The product of all clusters' hypotheses.
fn of_tracker(tracker: &Tracker) -> Vec<(Content, f64)> {
    let population = tracker.latest();
    let product = |whole: Vec<(Content, f64)>, cluster| {
        let own = of_cluster(population, cluster);
        let pairs = whole.iter().flat_map(|one| own.iter().map(move |other| (one, other)));
        pairs
            .map(|(one, other)| ([&one.0[..], &other.0].concat(), one.1 * other.1))
            .collect()
    };
    let all = population.clusters.iter().fold(vec![(Vec::new(), 1.0)], product);
    all.into_iter()
        .map(|(content, reliability)| (sorted(content), reliability))
        .collect()
}

fn run(scans: &[Vec<Detection>], settings: &Settings) -> Tracker {
    let mut tracker = Tracker::new(settings.clone()).unwrap();
    for (number, scan) in (0..).zip(scans) {
        tracker.scan(1, number * S, scan).unwrap();
    }
    tracker
}

fn any_scans() -> impl Strategy<Value = Vec<Vec<Detection>>> {
    // Gates of a track that was seen once reach 70 m, so some of these meet and some do not.
    let place = || (-60.0..60.0f64, -60.0..60.0f64);
    let first = prop::collection::vec(place(), 1..3);
    let second = prop::collection::vec(place(), 0..3);
    let third = prop::collection::vec(place(), 0..4);
    (first, second, third).prop_map(|(first, second, third)| {
        let scan = |(number, places): (i64, Vec<(f64, f64)>)| {
            places
                .iter()
                .map(|(east, north)| position(number * S, *east, *north))
                .collect()
        };
        (0..).zip([first, second, third]).map(scan).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3_000, max_global_rejects: 5_000, ..ProptestConfig::default() })]
    #[test]
    fn the_same_best_hypotheses_with_the_same_reliabilities(scans in any_scans()) {
        let settings = exact_settings();
        let tracker = run(&scans, &settings);
        let mut expected = enumerated(&scans, &settings, None);
        let found = of_tracker(&tracker);
        // Where nothing was dropped, everything is there; where the last scan had more than 64 children, the best of
        // them.
        let full = tracker.counts().dropped_probability_max > 0.0;
        let complete_before = run(&scans[..2], &settings).counts().dropped_probability_max == 0.0;
        let whole = tracker.clusters() == 1 && found.len() == HYPOTHESES_MAX;
        prop_assume!(!full || complete_before && whole);
        expected.sort_by(|one, other| other.1.total_cmp(&one.1));
        let dropped: f64 = expected.iter().skip(found.len()).map(|each| each.1).sum();
        let least = if full { expected[found.len() - 1].1 * (1.0 + 1e-9) } else { 0.0 };
        let kept: BTreeMap<Content, f64> = found.into_iter().collect();
        if !full {
            prop_assert_eq!(kept.len(), expected.len());
        }
        for (content, reliability) in expected.iter().filter(|each| each.1 > least) {
            let found = kept.get(content).copied();
            prop_assert!(found.is_some(), "{:?} of {} is missing", content, reliability);
            let expected = reliability / (1.0 - dropped);
            prop_assert!((found.unwrap() - expected).abs() < 1e-9, "{} instead of {}", found.unwrap(), expected);
        }
        // What is reported is a bound.
        let reported = tracker.counts().dropped_probability_max;
        prop_assert!(reported >= dropped - 1e-9, "{} dropped, {} reported", dropped, reported);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, max_global_rejects: 50_000, ..ProptestConfig::default() })]
    #[test]
    fn the_same_corrections_by_a_wide_area_report(scans in any_scans(), targets in 1..5u32) {
        let mut settings = exact_settings();
        settings.wide_area.tracks_min = 0.0;
        settings.wide_area.corrects_confirmed_only = false;
        let before = run(&scans[..2], &settings);
        // One cluster, which every detection of the last scan belongs to.
        let reach = gates(settings.gate.probability)[1];
        let in_gate = |detection: &Detection| {
            let measurement = DetectionMeasurement::of(detection, None).unwrap();
            let tracks = &before.latest().tracks;
            let predicted = tracks.iter().map(|track| track.motion_at(2 * S, &settings.motion));
            predicted.into_iter().any(|motion| motion.innovation(&measurement).unwrap().squared_distance <= reach)
        };
        prop_assume!(before.clusters() == 1 && scans[2].iter().all(in_gate));
        let mut tracker = run(&scans[..2], &settings);
        let report = WideAreaReport {
            time_ns: 0,
            arrival_ns: 2 * S,
            position_m: [0.0; 3],
            velocity_mps: [0.0; 3],
            targets,
            origin_m: None,
        };
        tracker.wide_area(&report).unwrap();
        tracker.scan(1, 2 * S, &scans[2]).unwrap();
        prop_assert_eq!(tracker.counts().wide_area_reports_unmatched, 0);
        prop_assume!(tracker.counts().dropped_probability_max == 0.0);
        let expected = enumerated(&scans, &settings, Some(f64::from(targets)));
        let found: BTreeMap<Content, f64> = of_tracker(&tracker).into_iter().collect();
        prop_assert_eq!(found.len(), expected.len());
        for (content, reliability) in &expected {
            let found = found.get(content).copied().unwrap_or_default();
            prop_assert!((found - reliability).abs() < 1e-9, "{} instead of {}", found, reliability);
        }
    }
}
