//! Replies of transponders in the plots of a radar.

use observations::DetectionTruth as Of;
use scenario::{RadarPlot, ScenarioSettings, SensorKind, SensorSettings, SimulatedSensor, Truth};

fn radar() -> SensorSettings {
    SensorSettings {
        plots: true,
        false_plots_per_period: Some(30.0),
        ..SensorSettings::new(SensorKind::Radar)
    }
}

fn plots(settings: &SensorSettings, truth: &Truth) -> Vec<RadarPlot> {
    let mut sensor = SimulatedSensor::new(settings, 3, 1, 0).expect("valid");
    let (mut tracks, mut plots) = (Vec::new(), Vec::new());
    while sensor.next_scan_time_s() < 400.0 {
        sensor.scan_with_plots(truth, &mut tracks, &mut plots);
    }
    plots
}

#[test]
fn replies_have_the_shares_that_are_set_and_change_nothing_else() {
    let truth = Truth::new(&ScenarioSettings::default(), 1).expect("valid");
    let silent = plots(&radar(), &truth);
    let replying = SensorSettings {
        address_probability: Some(0.9),
        code_probability: Some(0.8),
        garbled_probability: Some(0.1),
        ..radar()
    };
    let found = plots(&replying, &truth);
    assert_eq!(silent.len(), found.len());
    let (mut counts, mut targets) = ([0.0; 4], 0.0);
    for (plot, silent) in found.iter().zip(&silent) {
        let same = RadarPlot {
            identity: silent.identity,
            level: silent.level,
            ..*plot
        };
        assert_eq!(
            (same, silent.level, silent.identity),
            (*silent, None, Default::default())
        );
        let Of::Target(target) = plot.of else {
            assert_eq!((plot.identity, plot.level), Default::default(), "a false plot");
            continue;
        };
        let state = truth.target_at(target as usize, plot.time_of_measurement_ns as f64 / 1e9);
        // Vehicles have no code.
        let Some(code) = state.mode_3a else { continue };
        targets += 1.0;
        let (address, stated) = (plot.identity.address(), plot.identity.mode_3a());
        assert_eq!(plot.identity.callsign().is_some(), address.is_some());
        let is = [
            address.is_some(),
            address.is_some_and(|address| address != state.address),
            stated.is_some(),
            stated.is_some_and(|stated| stated != code),
        ];
        for (count, is) in counts.iter_mut().zip(is) {
            *count += f64::from(u8::from(is));
        }
        let level_m = messages::altitude_m(plot.level.expect("a height"));
        assert!((level_m - state.height_m).abs() < 80.0, "{level_m}");
    }
    for (count, share) in counts.into_iter().zip([0.9, 0.09, 0.8, 0.08]) {
        let sigma = (share * (1.0f64 - share) / targets).sqrt();
        assert!((count / targets - share).abs() < 4.0 * sigma, "{count} of {targets}");
    }
}

#[test]
fn keys_of_replies_belong_to_plots() {
    let refused = |settings: SensorSettings| SimulatedSensor::new(&settings, 1, 1, 0).unwrap_err().to_string();
    let without_plots = SensorSettings {
        address_probability: Some(0.9),
        ..SensorSettings::new(SensorKind::Radar)
    };
    assert!(refused(without_plots).contains("only a sensor with plots"));
    let garbled_alone = SensorSettings {
        garbled_probability: Some(0.1),
        ..radar()
    };
    assert!(refused(garbled_alone).contains("address_probability or code_probability"));
}
