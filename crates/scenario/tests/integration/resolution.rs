//! Detections of targets in formation by a radar of limited resolution.

use observations::DetectionTruth as Of;
use proptest::prelude::*;
use scenario::{FormationSettings, RadarPlot, ScenarioSettings, SensorKind, SensorSettings, SimulatedSensor, Truth};

/// Pairs from the north, straight towards the radar, so that they straddle the azimuth at which its turns begin.
fn pairs(spacing_m: f64) -> Truth {
    let settings = ScenarioSettings {
        targets: 0,
        formations: vec![FormationSettings {
            sector_rad: [0.0; 2],
            spacing_m,
            way_m: [140_000.0, 10_000.0],
            together_m: [120_000.0, 20_000.0],
            start_m: Some([110_000.0; 2]),
            speed_mps: [200.0; 2],
            ..FormationSettings::default()
        }],
        ..ScenarioSettings::default()
    };
    Truth::new(&settings, 1).expect("valid")
}

fn radar(detection_probability: f64, resolved_probability: f64) -> SensorSettings {
    SensorSettings {
        plots: true,
        range_resolution_m: Some(150.0),
        azimuth_resolution_rad: Some(0.02),
        resolved_probability: Some(resolved_probability),
        detection_probability: Some(detection_probability),
        period_s: Some(1.0),
        ..SensorSettings::new(SensorKind::Radar)
    }
}

fn plots(settings: &SensorSettings, truth: &Truth, seed: u64, until_s: f64) -> Vec<RadarPlot> {
    let mut sensor = SimulatedSensor::new(settings, seed, 1, 0).expect("valid");
    let (mut tracks, mut plots) = (Vec::new(), Vec::new());
    while sensor.next_scan_time_s() < until_s {
        sensor.scan_with_plots(truth, &mut tracks, &mut plots);
    }
    plots
}

/// 200 m apart at 100 to 20 km are at most 0.01 rad, so each turn detects a single plot, in the middle, with a
/// radar's errors.
#[test]
fn neighbours_give_one_plot_in_their_middle() {
    let truth = pairs(200.0);
    let found = plots(&radar(1.0, 0.0), &truth, 3, 400.0);
    assert!((399..=401).contains(&found.len()), "one in each turn: {}", found.len());
    let (mut across, mut along) = (0.0, 0.0);
    for plot in &found {
        assert_eq!(plot.of, Of::Merged);
        let time_s = plot.time_of_measurement_ns as f64 / 1e9;
        let [one, other] = [0, 1].map(|index| truth.target_at(index, time_s).position_m);
        let middle = [0, 1].map(|axis| 0.5 * (one[axis] + other[axis]));
        let sigma = 0.0012 * middle[1];
        across += ((plot.position_m[0] - middle[0]) / sigma).powi(2);
        along += ((plot.position_m[1] - middle[1]) / 50.0).powi(2);
    }
    for sum in [across, along] {
        let (mean, four_sigma) = (sum / found.len() as f64, 4.0 * (2.0 / found.len() as f64).sqrt());
        assert!((mean - 1.0).abs() < four_sigma, "{mean}");
    }
}

/// A look at two targets detects them unless it misses both; in a share of the turns they are resolved.
#[test]
fn rates_are_as_set() {
    let truth = pairs(200.0);
    let merged = plots(&radar(0.6, 0.0), &truth, 5, 400.0).len() as f64;
    let expected: f64 = 1.0 - 0.4 * 0.4;
    let sigma = (expected * (1.0 - expected) / 400.0).sqrt();
    assert!((merged / 400.0 - expected).abs() < 4.0 * sigma, "{merged}");

    let found = plots(&radar(1.0, 0.2), &truth, 5, 400.0);
    let apart = found.iter().filter(|plot| plot.of == Of::Target(0)).count() as f64;
    let sigma = (0.2f64 * 0.8 / 400.0).sqrt();
    assert!((apart / 400.0 - 0.2).abs() < 4.0 * sigma, "{apart}");
    let of_other = found.iter().filter(|plot| plot.of == Of::Target(1)).count() as f64;
    assert_eq!(apart, of_other);
}

#[test]
fn those_that_differ_enough_give_two_plots() {
    // 0.03 rad at 100 km.
    let truth = pairs(3000.0);
    let found = plots(&radar(1.0, 0.0), &truth, 3, 50.0);
    assert!(found.iter().all(|plot| plot.of != Of::Merged));
    assert!((98..=102).contains(&found.len()), "{}", found.len());
    // Separated along the line of sight by more than the length of a pulse.
    let aside = SensorSettings {
        position_m: Some([-90_000.0, 90_000.0, 0.0]),
        ..radar(1.0, 0.0)
    };
    assert!(
        plots(&aside, &pairs(200.0), 3, 50.0)
            .iter()
            .all(|plot| plot.of != Of::Merged)
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// A resolved target is measured as by a radar of unlimited resolution. A merged plot stands for at least two
    /// targets, which have no plot of their own in that turn. The same settings give the same plots.
    ///
    /// A radar of unlimited resolution need not have two plots in place of a merged one. The groups are fixed at
    /// the middle of a turn. A neighbour in view then may cross the edge of coverage, or north, before the antenna
    /// arrives.
    #[test]
    fn resolution_takes_plots_away_and_changes_no_other(seed: u64, resolved in 0.0..1.0f64, range_m in 10.0..2000.0f64) {
        let world = ScenarioSettings {
            formations: vec![FormationSettings {
                count: 8,
                sizes: vec![(2, 0.4), (5, 0.6)],
                ..FormationSettings::default()
            }],
            crossing_share: 1.0,
            ..ScenarioSettings::default()
        };
        let truth = Truth::new(&world, seed).expect("valid");
        let limited = SensorSettings {
            range_resolution_m: Some(range_m),
            false_plots_per_period: Some(5.0),
            ..radar(1.0, resolved)
        };
        let unlimited = SensorSettings {
            range_resolution_m: None,
            azimuth_resolution_rad: None,
            resolved_probability: None,
            ..limited.clone()
        };
        let [all, found] = [&unlimited, &limited].map(|settings| plots(settings, &truth, seed, 5.0));
        prop_assert_eq!(&found, &plots(&limited, &truth, seed, 5.0));
        for plot in found.iter().filter(|plot| plot.of != Of::Merged) {
            prop_assert!(all.contains(plot), "{plot:?}");
        }
        for turn in found.chunk_by(|one, other| one.scan == other.scan) {
            let merged = turn.iter().filter(|plot| plot.of == Of::Merged).count();
            let apart = turn.iter().filter(|plot| matches!(plot.of, Of::Target(_))).count();
            prop_assert!(apart + 2 * merged <= truth.len(), "{apart} and {merged} of {} targets", truth.len());
        }
    }
}
